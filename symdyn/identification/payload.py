"""Payloads: bodies of known mass that some logs were measured with, which makes gains of drives identifiable.

    F_load = Y_b π          Y_b: the columns of the ten parameters of the body b that carries it
    π = K x + c             c: what is known of m, m r and the inertia about the frame of b; x: what is not, without
                            what no motion separates from the rest of it

Reference: Khalil and Dombre (2002), section 12.6; Gautier and Briot, Global identification of joint drive gains and
dynamic parameters of robots (2014), where the mass is known and the other nine are not.

Motions are held against columns of parameters and payloads, and rows of these by frequency; errors of forces are given
joint by joint, of data that were fitted and of validation data.
"""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import suggesting
from symdyn.errors import IdentifyError, choice, listed
from symdyn.frozen import dataclass
from symdyn.identification.filtered import Flags, Motion, projected
from symdyn.identification.linear_model import TEN, LinearModel
from symdyn.identification.log import Log
from symdyn.identification.rate_rows import width
from symdyn.identification.regression import GAUSS, Rows
from symdyn.rounding import in_digits
from symdyn.scene import INERTIAL
from symdyn.shown import Suggesting

SAME = 1e-8
"""Part of its size that a column has beside others, if it is no combination of them."""


@suggesting
@dataclass(frozen=True)
class Payload(Suggesting):
    """A body that is fixed to one of the scene's while a log is measured; what is not given is found with the rest.

    >>> from symdyn.identification import Payload
    >>> Payload("bob", 0.5, com=(0, -0.3, 0), inertia=(0, 0, 0), log="loaded.csv").mass
    0.5

    Attributes:
        body: name of the body that carries it.
        mass: kg, above zero.
        com: its centre of mass in the frame of that body, m, three numbers; None where it is not known.
        inertia: about its centre of mass, along the axes of that frame, kg m^2: xx, yy, zz, or these and xy, xz, yz;
            None where it is not known. A small one has zeros.
        log: the logs that it was carried in: a file's name or a pattern, or the place of one in the list, from 0.
    """

    body: str
    mass: float
    com: Sequence[float] | None = None
    inertia: Sequence[float] | None = None
    log: str | int = "*"

    def carried(self, place: int, log: Log) -> bool:
        """Return whether a log, the one at a place of the list, was measured with it."""
        if not isinstance(self.log, str):
            return self.log == place
        return any(fnmatchcase(name, self.log) for name in (log.source, Path(log.source).name))

    @property
    def ten(self) -> Array:
        """Mass, first moment and inertia about the frame of the body, shape (10,); NaN for what is not known."""
        found = np.full(TEN, np.nan)
        found[0] = self.mass
        if self.com is not None:
            r = np.asarray(self.com, dtype=float)
            found[1:4] = self.mass * r
            if self.inertia is not None:
                xx, yy, zz, *off = (float(one) for one in self.inertia)
                xy, xz, yz = off or (0.0, 0.0, 0.0)
                central = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                about = central + self.mass * (r @ r * np.eye(3) - np.outer(r, r))
                found[4:] = about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        return found


@dataclass(frozen=True)
class Carried:
    """What payloads add to the forces of logs."""

    names: tuple[str, ...]  # of what is not known of them, shape (u,)
    unknown: tuple[Array, ...]  # K of each log, shapes (10 bodies, u)
    known: tuple[Array, ...]  # c of each log, shapes (10 bodies,)

    def columns(self, model: LinearModel, place: int, q: Array, qd: Array, qdd: Array) -> Array:
        """Return columns of what is not known, and last the force of what is, of a log: shape (N, nv, u + 1)."""
        both = np.column_stack([self.unknown[place], self.known[place]])
        if not both.any():
            return np.zeros((len(q), len(model.drives), both.shape[1]))
        return np.asarray(model.ten(q, qd, qdd) @ both)


def check_payloads(model: LinearModel, payloads: Sequence[Payload], logs: Sequence[Log]) -> None:
    """Raise IdentifyError with every fault of payloads, one line each."""
    faults, bodies = list[str](), tuple(body.name for body in model.scene.bodies)
    sources = listed(tuple(Path(log.source).name for log in logs))
    for one in payloads:
        if not isinstance(one, Payload):
            faults.append(f"payloads: {one!r:.40} is no Payload, such as Payload({bodies[-1]!r}, 2, log=1)")
    if faults:
        raise IdentifyError(faults)
    for one in payloads:
        where = f"payload of {one.log}" if isinstance(one.log, str) else f"payload of log {one.log}"
        if one.body not in bodies:
            faults.append(f"{where}: {model.scene.name} has no body {one.body}; {choice(one.body, bodies)}")
        if not any(one.carried(k, log) for k, log in enumerate(logs)):
            how = f"a number from 0 to {len(logs) - 1}, " if not isinstance(one.log, str) else ""
            faults.append(f"{where}: there is no such log; give {how}one of {sources}, or a pattern such as load*.csv")
        if not (isinstance(one.mass, Real) and np.isfinite(one.mass) and one.mass > 0):
            faults.append(f"{where}: mass = {one.mass!r:.40}: give what it weighs, kg, above zero")
        if one.com is not None and not _numbers(one.com, (3,)):
            faults.append(f"{where}: com = {_shown(one.com)}: give a vector of three numbers, m, such as [0, 0, 0.1]")
        if one.inertia is not None and not _numbers(one.inertia, (3, 6)):
            faults.append(
                f"{where}: inertia = {_shown(one.inertia)}: give xx, yy, zz, or these and xy, xz, yz, kg m^2, about "
                "the centre of mass"
            )
        if one.inertia is not None and one.com is None:
            faults.append(f"{where}: an inertia about an unknown centre of mass has no meaning; give com, too")
    if faults:
        raise IdentifyError(faults)
    for one in payloads:
        if one.inertia is not None and not _possible(one.inertia):
            faults.append(
                f"payload of {one.log}: inertia = {_shown(one.inertia)} is that of no body: no principal moment is "
                "negative or larger than the two others together"
            )
    if faults:
        raise IdentifyError(faults)


def carried(model: LinearModel, payloads: Sequence[Payload], logs: Sequence[Log]) -> Carried:
    """Return what payloads add to the forces of each log."""
    count = TEN * len(model.scene.bodies)
    places = {body.name: k for k, body in enumerate(model.scene.bodies)}
    Y = _random(model) if payloads else np.zeros((0, count))
    names, columns = list[str](), list[tuple[int, Array]]()
    for number, one in enumerate(payloads, start=1):
        own = [TEN * places[one.body] + k for k in range(TEN) if np.isnan(one.ten[k])]
        title = "payload" if len(payloads) == 1 else f"payload {number}"
        for name, k in _independent(Y, own):
            names.append(f"{title} {name}")
            columns.append((number - 1, np.eye(count)[k]))
    unknown, known = [], []
    for place, log in enumerate(logs):
        here = [one.carried(place, log) for one in payloads]
        K = [column if here[number] else np.zeros(count) for number, column in columns]
        c = np.zeros(count)
        for one in (one for one, there in zip(payloads, here, strict=True) if there):
            c[TEN * places[one.body] :][:TEN] += np.nan_to_num(one.ten)
        unknown.append(np.stack(K, axis=1) if K else np.zeros((count, 0)))
        known.append(c)
    return Carried(tuple(names), tuple(unknown), tuple(known))


def _random(model: LinearModel) -> Array:
    """Return the columns of the ten of every body in random motions, shape (rows, 10 bodies)."""
    rng = np.random.default_rng(2)
    nq, nv = width(model.scene), len(model.scene.velocities)
    found = model.ten(*(rng.uniform(-1, 1, (100, n)) for n in (nq, nv, nv)))
    return np.nan_to_num(found.reshape(-1, found.shape[2]))


def _independent(Y: Array, own: Sequence[int]) -> list[tuple[str, int]]:
    """Return the columns out of `own` that others of them do not stand for, each with the name of what it stands for.

    >>> import numpy as np
    >>> Y = np.zeros((3, 10))
    >>> Y[0, 1] = Y[1, 4] = Y[2, 3] = 1.0
    >>> Y[1, 5] = -2.0
    >>> _independent(Y, [1, 2, 4, 5])
    [('mx', 1), ('Ixx - 2 Iyy', 4)]
    """
    kept, names = list[int](), list[str]()
    for k in own:
        size = float(np.linalg.norm(Y[:, k]))
        if size <= 1e-12:
            continue
        label = INERTIAL[k % TEN][0]
        shares = np.linalg.lstsq(Y[:, kept], Y[:, k], rcond=None)[0] if kept else np.zeros(0)
        if np.linalg.norm(Y[:, k] - Y[:, kept] @ shares) > SAME * size:
            kept.append(k)
            names.append(label)
            continue
        for place, c in enumerate(shares):
            if abs(c) > SAME:
                factor = "" if abs(abs(c) - 1) < SAME else f"{in_digits(abs(float(c)), 3)} "
                names[place] += f" {'-' if c < 0 else '+'} {factor}{label}"
    return list(zip(names, kept, strict=True))


def _numbers(values: Sequence[float], lengths: Sequence[int]) -> bool:
    try:
        found = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return False
    return found.shape in [(n,) for n in lengths] and bool(np.isfinite(found).all())


def _possible(inertia: Sequence[float]) -> bool:
    xx, yy, zz, *off = (float(one) for one in inertia)
    xy, xz, yz = off or (0.0, 0.0, 0.0)
    low, middle, high = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return bool(low >= -SAME * high and high <= (low + middle) * (1 + SAME))


def _shown(values: object) -> str:
    return f"{list(values) if isinstance(values, (tuple, np.ndarray)) else values}"[:60]


@dataclass(frozen=True)
class Fit:
    """How well one driving force is predicted by base parameters."""

    drive: str  # its name
    unit: str  # "N m" or "N"
    size: float  # root mean square of the force as measured
    error: float  # root mean square of measured less predicted, in the band
    before: float  # the same with the scene's own values; NaN where it has none
    validation: float  # the same as `error`, on data that were not fitted; NaN where there are none

    @property
    def percent(self) -> float:
        """Error in parts of the force, %."""
        return 100 * self.error / self.size if self.size else float("nan")

    @property
    def validation_percent(self) -> float:
        """Error on data that were not fitted, %."""
        return 100 * self.validation / self.size if self.size else float("nan")


def blocks(count: int, share: float, most: int = 4) -> list[tuple[slice, bool]]:
    """Return contiguous parts of `count` samples, and whether each is validation data; `share` of all are.

    >>> [(part.start, part.stop, back) for part, back in blocks(100, 0.25, 2)]
    [(0, 37, False), (37, 50, True), (50, 87, False), (87, 100, True)]
    """
    if share <= 0:
        return [(slice(0, count), False)]
    found = []
    for k in range(most):
        low, high = count * k // most, count * (k + 1) // most
        at = low + int((high - low) * (1 - share))
        found += [(slice(low, at), False), (slice(at, high), True)]
    return found


def mean_square(residuals: Array) -> float:
    """Return the root mean square, NaN of nothing."""
    return float(np.sqrt(np.mean(residuals**2))) if len(residuals) else float("nan")


SLOW = 3.0
"""Standard deviations of a velocity's noise within which a joint stands, where its dry friction jumps."""

CREEP, BENT, FEWEST = (0.025, 0.4), (0.2, 1e-4), 8
"""Parts of the root mean square of a velocity below which friction is compared with that of a sign, first and at most;
parts of noise and of the force by which it differs, in the median of so many samples at least."""


@dataclass(frozen=True)
class DataPart:
    """One motion, and what it is held against."""

    motion: Motion  # with what drives show
    Y: Array  # columns of β, of what is not known of payloads, and last the force of what is, shape (N, nv, b + 1)
    drawn: Array | None  # what noise of the motion makes of them; None where there is none
    blocks: tuple[tuple[slice, bool], ...]  # which samples are validation data


@dataclass(frozen=True)
class Evidence:
    """What all fits of the same motions share, whichever gains they look for."""

    parts: tuple[DataPart, ...]  # the motions
    used: tuple[Flags, ...]  # of each, which samples are fitted before outliers are left out, shapes (N, nv)
    rows: Rows  # of these samples


def evidence(model: LinearModel, moved: Sequence[tuple[int, Motion]], carried: Carried, hold_back: float) -> Evidence:
    """Return motions, each with the place of its log, beside the columns that they are held against.

    Raises:
        IdentifyError: a regressor without finite values.
    """
    parts = tuple(_part(model, one, carried, place, hold_back) for place, one in moved)
    used = tuple(moving(model, one.motion) for one in parts)
    return Evidence(parts, used, rows_of(model, parts, used, False))


def moving(model: LinearModel, motion: Motion) -> Flags:
    """Return which samples of which joints are fitted: not where dry friction jumps within the noise of a velocity."""
    used = np.ones(motion.tau.shape, bool)
    for j in model.jumps:
        used[:, j] = np.abs(motion.qd[:, j]) > SLOW * motion.noise[1, j]
    return used


def sliding(
    model: LinearModel, parts: Sequence[DataPart], used: list[Flags], off: list[Array], taus: list[Array]
) -> list[Flags]:
    """Return samples that are used, without the slowest if residuals show friction that sticks or jumps smoothly."""
    qd, every, r, tau = (np.concatenate(one) for one in ([one.motion.qd for one in parts], used, off, taus))
    v, least = np.abs(qd), np.zeros(qd.shape[1])
    for j in set(model.jumps) & set(model.rows):
        own = every[:, j]
        first, most = np.multiply(CREEP, mean_square(v[own, j]))
        slow = max(2 * v[own, j].min(initial=np.inf), first)
        bent = (r[:, j] * np.sign(qd[:, j]))[own & (v[:, j] < slow)]
        if len(bent) >= FEWEST and slow <= most:
            noise = GAUSS * float(np.median(np.abs(r[own & (v[:, j] >= slow), j])))
            noise = max(noise, BENT[1] * mean_square(tau[own, j])) * max(BENT[0], SLOW / np.sqrt(len(bent)))
            least[j] = min(2 * slow, most) if abs(np.median(bent)) > noise else 0.0
    fast = [mask & (np.abs(one.motion.qd) >= least) for mask, one in zip(used, parts, strict=True)]
    return fast if least.any() else used


def _part(model: LinearModel, motion: Motion, carried: Carried, place: int, hold_back: float) -> DataPart:
    """Return a motion with the columns that it is held against."""

    def columns(*state: Array) -> Array:
        found = model.regressor(*state)
        return np.concatenate([found, carried.columns(model, place, *state)], axis=2)

    both = columns(motion.q, motion.qd, motion.qdd)
    bad = np.argwhere(~np.isfinite(both))
    if len(bad):
        raise IdentifyError(
            f"{motion.source}: at t = {motion.t[bad[0][0]]:.6g} s the regressor has no finite value, as at a dead "
            "centre; leave such samples out"
        )
    drawn = None
    if motion.noise.any() and len(model.scene.coordinates) == motion.qd.shape[1]:
        drawn = columns(*_shaken(motion)) - both
    return DataPart(motion, both, drawn, tuple(blocks(len(motion.t), hold_back)))


def _shaken(motion: Motion) -> tuple[Array, Array, Array]:
    """Return a motion with one draw of its noise; None of it has what was not differentiated."""
    rng = np.random.default_rng(0)
    step = float(motion.t[1] - motion.t[0])
    frequency = np.fft.rfftfreq(len(motion.t), step)
    shape = (len(frequency), n := motion.qd.shape[1])
    white = (rng.normal(size=shape) + 1j * rng.normal(size=shape)) * (frequency <= motion.cut)[:, None]
    turn = 2j * np.pi * frequency[:, None]
    parts = [np.fft.irfft(white * turn**k, len(motion.t), axis=0) for k in range(3)]
    level = motion.noise[1] / np.maximum(np.std(parts[1], axis=0), 1e-300)
    q, qd, qdd = (x + p * level for x, p in zip((motion.q[:, :n], motion.qd, motion.qdd), parts, strict=True))
    return np.hstack([q, motion.q[:, n:]]), qd, qdd


def held_in(part: DataPart) -> Flags:
    """Return which samples of a motion are validation data, shape (N,)."""
    mask = np.zeros(len(part.motion.t), bool)
    for samples, back in part.blocks:
        mask[samples] = back
    return mask


def rows_of(model: LinearModel, parts: Sequence[DataPart], used: Sequence[Flags], back: bool) -> Rows:
    """Return what drives show and the columns beside it, of validation data, or of those that are fitted."""
    found: list[tuple[Any, ...]] = []
    group = 0
    for one, mask in zip(parts, used, strict=True):
        motion, Y, drawn = one.motion, one.Y, one.drawn
        step = float(motion.t[1] - motion.t[0])
        for part, held in one.blocks:
            n = part.stop - part.start
            count = int(min(n, 2 * motion.band * step * n))
            if held is not back or count < 1:
                continue
            frequency = np.arange(count) / (2 * step * n)
            for j in model.rows:
                take = mask[part, j].astype(float)[:, None]
                if not take.any():
                    continue
                own = projected(np.column_stack([Y[part, j], motion.tau[part, j]]) * take, count)
                lost = np.zeros((count, Y.shape[2])) if drawn is None else projected(drawn[part, j] * take, count)
                numbers = group + np.arange(count)
                found.append((own[:, :-1], own[:, -1], np.full(count, j), frequency, numbers, lost))
            group += count
    if not found:
        p = parts[0].Y.shape[2]
        none = np.zeros(0)
        return Rows(np.zeros((0, p)), none, none.astype(int), none, none.astype(int), np.zeros((0, p)))
    columns, tau, joint, frequency, numbers, lost = (np.concatenate(one) for one in zip(*found, strict=True))
    return Rows(columns, tau, joint, frequency, numbers, lost if lost.any() else np.zeros((0, 0)))
