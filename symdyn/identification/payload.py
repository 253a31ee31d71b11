"""Payloads: bodies of known mass that some logs were measured with, the known size by which gains of drives are told.

    F_load = Y_b π          Y_b: the columns of the ten parameters of the body b that carries it
    π = K x + c             c: what is known of m, m r and the inertia about the frame of b; x: what is not, without
                            what no motion tells apart from the rest of it

Reference: Khalil and Dombre (2002), section 12.6; Gautier and Briot, Global identification of joint drive gains and
dynamic parameters of robots (2014), where the mass is known and the other nine are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from numbers import Real
from pathlib import Path

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.log import Log
from symdyn.identification.unknowns import TEN
from symdyn.rounding import in_digits
from symdyn.scene import INERTIAL
from symdyn.scene.values import choice, listed

SAME = 1e-8
"""Part of its size that a column has beside others, if it is no combination of them."""


@dataclass(frozen=True)
class Payload:
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
    """What payloads add to the forces of logs.

    Attributes:
        names: of what is not known of them, shape (u,).
        unknown: K of each log, shapes (10 bodies, u).
        known: c of each log, shapes (10 bodies,).
    """

    names: tuple[str, ...]
    unknown: tuple[Array, ...]
    known: tuple[Array, ...]

    def columns(self, model: LinearModel, place: int, q: Array, qd: Array, qdd: Array) -> Array:
        """Return columns of what is not known, and last the force of what is, of a log: shape (N, nv, u + 1)."""
        both = np.column_stack([self.unknown[place], self.known[place]])
        if not both.any():
            return np.zeros((len(q), qd.shape[1], both.shape[1]))
        found: Array = model.ten(q, qd, qdd) @ both
        return found


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
            faults.append(f"{where}: com = {_shown(one.com)}: give three numbers, m, such as [0, 0, 0.1]")
        if one.inertia is not None and not _numbers(one.inertia, (3, 6)):
            faults.append(
                f"{where}: inertia = {_shown(one.inertia)}: give xx, yy, zz, or these and xy, xz, yz, kg m^2, about "
                "the centre of mass"
            )
        if one.inertia is not None and one.com is None:
            faults.append(f"{where}: an inertia about a centre of mass that is not known says nothing; give com, too")
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
    nq, nv = len(model.scene.coordinates), len(model.scene.velocities)
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
