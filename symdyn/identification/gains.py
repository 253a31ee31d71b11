"""Fits of logs, outliers left out round by round, how well forces are predicted, and the gains of drives.

    Y β + Y_L x + F = k i       Y_L, x, F: what is not known of payloads and what is (`payload`); k: gains of drives

What a drive shows, such as a current, times its gain is its force. The gain may be unknown:

    k_j i_j = Y_j β + F_j + noise         F: forces of what is known of payloads; noise is in i, as measured
    i_j = (Y_j β + F_j) / k_j             so this is what is fitted, by Gauss-Newton: with f0 = Y β0 + F at β0, k0

    k0 i - F - f0 = Y β - (f0 / k0) k     a row for each, and a column for each gain

With i itself in the column, in place of f0 / k0, its noise would make gains too small. If nothing is known, k and β may
grow together: the direction (β0, k0) cannot be determined, whatever the noise.

Reference: Gautier and Briot, Global identification of joint drive gains and dynamic parameters of robots (2014).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, suggesting
from symdyn.errors import IdentifyError
from symdyn.frozen import dataclass, replace
from symdyn.identification.filtered import Flags, Indices, Motion
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.payload import Carried, Evidence, Fit, held_in, mean_square, rows_of, sliding
from symdyn.identification.regression import Outlier, Regression, Rows, far, solve, stretches
from symdyn.scene import Scene, SceneUnits
from symdyn.scene.values import force_unit
from symdyn.simulation.prescribed import drive_names

STEPS = 30
"""Of Gauss-Newton, at most."""

SETTLED = 1e-6
"""Part of a gain that a step changes it by when no more are taken."""

LONGEST = 5.0
"""Times by which one step may change a gain."""

LEAST = 1e-9
"""Part of the largest singular value below which the first guess leaves a direction to what was expected."""

CLEAN = 1e-9
"""Part of what a drive shows that the first guess takes for noise at least."""

WEAK = 1e-2
"""One over the standard deviation of the first guess of one over a gain, in parts of it."""

TRIES = 200
"""Of Levenberg and Marquardt, from each first guess."""

HARDLY = 0.2
"""Standard error, in parts of a gain, from which on it is reported as hardly identifiable."""


@suggesting
@dataclass(frozen=True)
class Gain:
    """What the column of a drive is multiplied by to become its force.

    Attributes:
        drive: its name.
        unit: such as "N m/A".
        value: as found; negative where the column has the other sign than the force.
        error: its standard error; NaN where it is not identifiable.
    """

    drive: str
    unit: str
    value: float
    error: float

    @property
    def words(self) -> str:
        """What is doubtful about it, "" where nothing is."""
        if not np.isfinite(self.error):
            return ""
        if self.error > HARDLY * abs(self.value):
            return (
                f"gain {self.drive} = {self.value:.3g} with a standard error of {self.error:.2g} {self.unit} is hardly "
                "identifiable: take a heavier payload, or mount it further out"
            )
        turned = f"gain {self.drive} is below zero: its column has the other sign than its force"
        return turned if self.value < 0 else ""


@dataclass(frozen=True)
class Gains:
    """Gains of the drives that do not show forces, at some point of the fit."""

    shown: Mapping[int, str]  # what one of what they show is, by the number of their velocity
    values: Array  # of every velocity, shape (nv,); one where a drive shows its force
    forces: Array  # β and what is not known of payloads, with which the forces are, shape (b,)

    @property
    def drives(self) -> list[int]:
        """Numbers of the velocities whose gains are identified, shape (g,)."""
        return list(self.shown)

    @property
    def factors(self) -> Array:
        """What columns are multiplied by to become forces, those of what is known last: shape (b + 1,)."""
        return np.asarray(np.append(self.forces, 1.0))

    def linear(self, rows: Rows) -> Rows:
        """Return rows with a column a gain, of rows with what drives show, and the known forces as last column."""
        said, known = rows.Y @ self.factors, rows.Y[:, -1]
        force = rows.tau * self.values[rows.joint]
        found = self.columns(rows.Y, rows.joint)
        noise = self.columns(rows.buried, rows.joint) if rows.buried.size else rows.buried
        left = force - known - np.where(np.isin(rows.joint, self.drives), said, 0.0)
        return replace(rows, Y=found, tau=left, buried=noise, force=force)

    def columns(self, Y: Array, joint: Indices) -> Array:
        """Return columns, those of gains last, shape (M, b + g), of columns of which the last is known, (M, b + 1)."""
        slopes = -(Y @ self.factors) / self.values[joint]
        own = [np.where(joint == j, slopes, 0.0) for j in self.drives]
        return np.column_stack([Y[:, :-1], *own])

    def after_step(self, estimate: Array) -> Gains:
        """Return them after a step, which turns no sign."""
        values = self.values.copy()
        for j, new in zip(self.drives, estimate[len(self.forces) :], strict=True):
            values[j] *= np.clip(new / values[j], 1 / LONGEST, LONGEST)
        return Gains(self.shown, values, estimate[: len(self.forces)])


def expected(shown: Mapping[int, str], seen: Array, forces: Array) -> Array:
    """Return gains of all velocities, shape (nv,): those by which what was seen is as large as expected, else one.

    Args:
        shown: as of `Gains`.
        seen: what drives show, shape (N, nv).
        forces: as the scene expects them, shape (N, nv); NaN where it does not.
    """
    found = np.ones(seen.shape[1])
    for j in shown:
        size, force = float(np.linalg.norm(seen[:, j])), float(np.linalg.norm(forces[:, j]))
        ratio = np.copysign(force / size, forces[:, j] @ seen[:, j]) if size else np.nan
        found[j] = ratio if np.isfinite(ratio) and ratio else np.sqrt(len(seen)) / size if size else 1.0
    return found


def first(shown: Mapping[int, str], rows: Rows, gains: Array) -> Gains:
    """Return where Gauss-Newton starts: the best that Levenberg and Marquardt find from some guesses.

    Args:
        shown: as of `Gains`.
        rows: what drives show, and columns, the last of them forces that are known.
        gains: that are expected, shape (nv,).
    """
    few = _few(rows)
    drives, guess = list(shown), np.array([gains[j] for j in shown])
    smoothed = _two_stages(few, drives, gains)
    sizes = [float(np.sqrt(np.mean(rows.tau[rows.joint == j] ** 2))) for j in drives]
    force = float(np.median(np.abs(guess) * sizes)) or 1.0
    even = force / np.array([one or force for one in sizes])  # drives that work equally hard
    best, found = np.inf, np.zeros(0)
    for one in (smoothed, guess, np.copysign(even, smoothed), np.copysign(even, guess), even):
        off, at = _fitted(few, drives, one)
        best, found = (off, at) if off < best else (best, found)
        if 2 * best < len(rows.tau) + len(few.tau):  # noise of each drive, and of what all of them share
            break
    values = gains.copy()
    values[drives] = found[-len(drives) :]
    return Gains(shown, values, found[: -len(drives)])


def _few(rows: Rows) -> Rows:
    """Return few rows of the same sums of squares, over the noise of what each drive shows, by QR joint by joint."""
    found = []
    for j in np.unique(rows.joint):
        own = np.column_stack([rows.Y, rows.tau])[rows.joint == j]
        scale = np.linalg.norm(own, axis=0)
        own = own / np.where(scale > 0, scale, 1.0)
        off = own[:, -1] - own[:, :-1] @ np.linalg.lstsq(own[:, :-1], own[:, -1], rcond=LEAST)[0]
        noise = max(float(np.linalg.norm(off)), CLEAN) * scale[-1] / np.sqrt(len(own))
        found.append((np.linalg.qr(own, mode="r") * scale / (noise or 1.0), int(j)))
    R = np.vstack([one for one, _ in found])
    joint = np.concatenate([np.full(len(one), j) for one, j in found])
    return Rows(R[:, :-1], R[:, -1], joint, np.zeros(len(R)), np.zeros(len(R), np.int64))


def _two_stages(rows: Rows, drives: Sequence[int], gains: Array) -> Array:
    """Return gains by least squares with a column of what each drive shows, smoothed by the others: signs at least."""
    columns, target = np.zeros((len(rows.tau), len(drives))), rows.tau - rows.Y[:, -1]
    for place, j in enumerate(drives):
        own = rows.joint == j
        columns[own, place] = -rows.Y[own] @ np.linalg.lstsq(rows.Y[own], rows.tau[own], rcond=LEAST)[0]
        target[own] = -rows.Y[own, -1]
    A = np.column_stack([rows.Y[:, :-1], columns])
    weights = 1 / np.abs(gains[rows.joint])
    scale = np.linalg.norm(A * weights[:, None], axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    found = (np.linalg.lstsq(A * weights[:, None] / scale, target * weights, rcond=LEAST)[0] / scale)[-len(drives) :]
    return np.where(found != 0, found, gains[list(drives)])


def _fitted(rows: Rows, drives: Sequence[int], guess: Array) -> tuple[float, Array]:
    """Return the sum of squares, and parameters and gains, of i = u (Y β + F), u = 1/k in parts of a guess."""
    from scipy.optimize import least_squares

    Y, known, seen = rows.Y[:, :-1], rows.Y[:, -1], rows.tau
    scale = np.linalg.norm(Y, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    Y = Y / scale
    count, own = Y.shape[1], np.stack([rows.joint == j for j in drives], axis=1)
    alone = ~own.any(axis=1)
    weak = np.column_stack([np.zeros((len(drives), count)), WEAK * np.eye(len(drives))])  # for gains that hardly count

    def turned(x: Array) -> Array:
        return np.asarray(alone + own @ (x[count:] / guess))

    def off(x: Array) -> Array:
        found: Array = turned(x) * (Y @ x[:count] + known) - seen
        return np.append(found, WEAK * (x[count:] - 1))

    def slope(x: Array) -> Array:
        force = Y @ x[:count] + known
        rows = np.column_stack([turned(x)[:, None] * Y, own * force[:, None] / guess])
        return np.vstack([rows, weak])

    u = turned(np.ones(count + len(drives)))
    begin = np.append(np.linalg.lstsq(u[:, None] * Y, seen - u * known, rcond=LEAST)[0], np.ones(len(drives)))
    found = least_squares(
        off, begin, slope, method="lm" if len(seen) >= count else "trf", x_scale="jac", max_nfev=TRIES
    )
    parts = np.where(found.x[count:] != 0, found.x[count:], 1.0)
    return float(found.cost), np.append(found.x[:count] / scale, guess / parts)


def estimated_gains(scene: Scene, shown: Mapping[int, str], regression: Regression, values: Array) -> tuple[Gain, ...]:
    """Return the gains of a fit, with their standard errors, in the order of velocities."""
    names, kinds = drive_names(scene), SceneUnits(scene).velocities
    errors = regression.errors[len(regression.names) - len(shown) :]
    return tuple(
        Gain(names[j], f"{force_unit(kinds[j])}/{one}", float(values[j]), float(error))
        for (j, one), error in zip(shown.items(), errors, strict=True)
    )


ROUNDS = 4
"""Of leaving out outliers and fitting again."""


@dataclass(frozen=True)
class Fitted:
    """What a fit found."""

    regression: Regression  # least squares of all parameters: β, then what is not known of payloads, then gains
    gains: Array  # of every velocity, shape (nv,); one where a drive shows its force
    motions: tuple[Motion, ...]  # with forces in place of what drives show
    fits: tuple[Fit, ...]  # how well each driving force is predicted
    rows: Rows  # what was fitted, with what drives show
    outliers: tuple[Outlier, ...]  # what was left out
    notes: tuple[str, ...]  # what a user should know, one line each
    predicted: tuple[Array, ...]  # forces of each motion, shapes (N, nv)
    used: tuple[Flags, ...]  # of each motion, which samples were fitted, shapes (N, nv)
    validation: tuple[Flags, ...]  # of each motion, which samples are validation data, shapes (N,)


def fitted(
    model: LinearModel, evidence: Evidence, carried: Carried, shown: Mapping[int, str], band: float, leave_out: bool
) -> Fitted:
    """Return the regression of motions, outliers left out.

    Args:
        model: the mechanism.
        evidence: motions, and what they are held against.
        carried: payloads by log.
        shown: what drives show that do not show their force, by the number of their velocity.
        band: Hz.
        leave_out: whether outliers are.

    Raises:
        IdentifyError: too few rows, or gains that do not settle.
    """
    parts = evidence.parts
    names = (*model.names, *carried.names, *(f"gain {model.drives[j]}" for j in shown))
    start = np.append(np.nan_to_num(model.prior), np.zeros(len(carried.names)))
    usual = expected(
        shown,
        np.concatenate([one.motion.tau for one in parts]),
        np.concatenate([one.Y @ np.append(start, 1.0) for one in parts]),
    )
    prior = np.append(start, usual[list(shown)])
    gains = Gains(shown, usual, start)
    used = fast = list(evidence.used)
    out = [np.zeros(one.motion.tau.shape, bool) for one in parts]
    for k in range(2 * ROUNDS):
        rows = rows_of(model, parts, used, False) if k else evidence.rows
        if len(rows.tau) < len(names) // 4 + 2:
            raise IdentifyError(
                f"{parts[0].motion.source}: the data leave {len(rows.tau)} rows below {band:.3g} Hz for "
                f"{len(names)} parameters; give a longer log, or a wider band"
            )
        if shown and not k:
            gains = first(shown, rows, usual)
        regression, gains = _settled(rows, gains, names, prior, band)
        forces = [one.motion.tau * gains.values for one in parts]
        predicted = [one.Y @ gains.factors for one in parts]
        residuals = [force - said for force, said in zip(forces, predicted, strict=True)]
        if k < ROUNDS and (slid := sliding(model, parts, fast, residuals, forces)) is not fast:
            fast, used = slid, [one & ~gone for one, gone in zip(slid, out, strict=True)]
            continue
        if not leave_out or k == 2 * ROUNDS - 1:
            break
        new = _far(residuals, used, forces, model.rows)
        if not any(one.any() for one in new):
            break
        out = [one | more for one, more in zip(out, new, strict=True)]
        used = [one & ~more for one, more in zip(used, new, strict=True)]
    outliers = [
        one
        for part, mask, left in zip(parts, out, residuals, strict=True)
        for one in stretches(mask, left, part.motion.t, part.motion.source, model.drives)
    ]
    return Fitted(
        regression,
        gains.values,
        tuple(replace(one.motion, tau=force) for one, force in zip(parts, forces, strict=True)),
        _fits(model, evidence, gains, rows, used),
        rows,
        tuple(outliers),
        (*_standing(model, fast), *_told_of(outliers, out)),
        tuple(predicted),
        tuple(used),
        tuple(held_in(one) for one in parts),
    )


def _settled(rows: Rows, gains: Gains, names: Sequence[str], prior: Array, band: float) -> tuple[Regression, Gains]:
    """Return least squares and gains, without these one solution; IdentifyError where gains do not settle."""
    for _ in range(STEPS):
        regression = solve(names, gains.linear(rows), prior, band, len(gains.values))
        before, gains = gains, gains.after_step(regression.estimate)
        parts = np.abs(gains.values / before.values - 1)
        if parts.max() < SETTLED:
            return regression, gains
    drive = names[len(names) - len(gains.drives) + int(parts[gains.drives].argmax())].removeprefix("gain ")
    raise IdentifyError(
        f"units: gains did not converge in {STEPS} steps, that of {drive} is hardly identifiable; give a log with a "
        f"payload that it feels, or its gain, as in {argument('units', {drive: '0.12*A'})}"
    )


def _far(residuals: list[Array], used: list[Flags], taus: list[Array], rows: tuple[int, ...]) -> list[Flags]:
    lengths = np.cumsum([len(one) for one in residuals])[:-1]
    every = far(np.concatenate(residuals), np.concatenate(used), np.concatenate(taus))
    passive = [j for j in range(every.shape[1]) if j not in rows]
    every[:, passive] = False
    return np.split(every, lengths)


def _told_of(outliers: list[Outlier], out: list[Flags]) -> list[str]:
    count = int(sum(one.sum() for one in out))
    if not count:
        return []
    worst = sorted(outliers, key=lambda one: -abs(one.worst))[:3]
    where = "; ".join(f"{one.drive} at t = {one.start:.6g} s, off by {one.worst:.3g}" for one in worst)
    return [f"{count} sample{'s' * (count != 1)} of a force left out that no noise explains: {where}"]


def _standing(model: LinearModel, fast: Sequence[Flags]) -> list[str]:
    """Return a note on samples of joints that were left out as `moving` and `sliding` say."""
    left = 1 - np.concatenate(fast).mean(axis=0)
    parts = [f"{100 * left[j]:.2g} % of {model.drives[j]}" for j in model.rows if left[j] > 0]
    return [f"left out where a joint stands or creeps, where dry friction jumps: {', '.join(parts)}"] if parts else []


def _fits(model: LinearModel, evidence: Evidence, gains: Gains, own: Rows, used: Sequence[Flags]) -> tuple[Fit, ...]:
    """Return how well each driving force is predicted; root mean squares over samples, in the band."""
    other = rows_of(model, evidence.parts, used, True)
    back = {
        held: sum(p.stop - p.start for one in evidence.parts for p, h in one.blocks if h is held)
        for held in (False, True)
    }
    count = len(model.prior)
    before = np.append(model.prior, gains.factors[count:])
    known = bool(np.isfinite(before).all())
    found = []
    for j in model.rows:

        def off(rows: Rows, factors: Array) -> float:
            mine = rows.joint == j  # noqa: B023  called at once
            left = rows.tau[mine] * gains.values[j] - rows.Y[mine] @ factors  # noqa: B023
            return mean_square(left) * float(np.sqrt(len(left) / back[rows is other])) if len(left) else float("nan")

        found.append(
            Fit(
                model.drives[j],
                model.units[j],
                off(own, 0 * gains.factors),
                off(own, gains.factors),
                off(own, before) if known else float("nan"),
                off(other, gains.factors),
            )
        )
    return tuple(found)
