"""Gains of drives that were given, tested against the data: would the forces fit better if one of them were free?

A wrong gain scales all that its drive shows, masses and gains of others too. So it may as well be that a column of
forces is off, which a right gain contradicts.

Of a fit without it, one more free gain has

    δ = c·r / c·c           one step of Gauss-Newton: r, weighted residuals of the fit; c, the column of that gain
                            without what the other columns do, so that no other has to be solved for again

    least(u) = min |A β - b|² + |i - u (Y β + F)|²        u = 1/k; Y, F, i: rows of that drive; A, b: of all others
             = |b'|² + |i' - u F'|² + Σ (u s b* - c (i* - u F*))² / (c² + u² s²)
                                                          c, s: singular values of A and Y in one orthonormal basis of
                                                          both; *: along their left vectors; ': outside of these

With each drive weighted by the size of what it shows, the minimum of least(u) is a bound: in no fit is the sum of
squares of errors, as parts of what drives show, below it.

Reference: Golub and Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate (1973); Golub and Van Loan, Matrix Computations, section 6.1 (generalised singular values).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.errors import IdentifyError, listed
from symdyn.frozen import dataclass
from symdyn.identification.gains import Fitted
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.log import ColumnUnits
from symdyn.identification.regression import Regression, Rows
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.simulation.prescribed import drive_names

LEAST = 1e-9
"""Part of the largest singular value, and of a column, below which nothing is identifiable."""

WIDE, FINE = 6, 20
"""Decades on both sides of what was given, and how many gains of each are looked at."""

ROUNDED = 1e-10
"""Part of the squares of what a drive shows that rounding may make."""


@dataclass(frozen=True)
class GainStep:
    """One step of Gauss-Newton of one gain."""

    size: float  # by which the gain would change, in parts of it
    error: float  # standard error of that; infinite where it is not identifiable


def steps(rows: Rows, regression: Regression, drives: Collection[int]) -> dict[int, GainStep]:
    """Return the step that each gain would take if it alone were left free, weights as they are.

    Args:
        rows: that were fitted, what drives show taken for forces.
        regression: of these rows.
        drives: numbers of the velocities.
    """
    w = regression.weights
    columns = regression.Y * w[:, None] / regression.scale
    if len(regression.null_space):
        columns = columns @ np.linalg.svd(regression.null_space)[2][len(regression.null_space) :].T
    basis = np.linalg.qr(columns)[0]
    left = regression.residuals * w
    force = rows.tau - regression.residuals
    return {j: _step(basis, left, np.where(rows.joint == j, -force * w, 0.0)) for j in drives}


def _step(basis: Array, left: Array, column: Array) -> GainStep:
    own = column - basis @ (basis.T @ column)
    size = float(own @ own)
    if size <= LEAST**2 * float(column @ column):
        return GainStep(0.0, np.inf)
    return GainStep(float(own @ left) / size, size**-0.5)


def bounds(rows: Rows, drives: Collection[int], shown: Collection[int]) -> dict[int, float]:
    """Return below what no sum of squares of errors is, in parts of what each drive shows, by the gain that is free.

    Args:
        rows: that were fitted, what drives show taken for forces.
        drives: numbers of the velocities.
        shown: drives whose gains are free in any case; what they show may be fitted exactly.
    """
    pressed: dict[int, Array] = {}
    for j in np.unique(rows.joint):
        of = rows.joint == j
        if (size := float(np.linalg.norm(rows.tau[of]))) and int(j) not in shown:
            pressed[int(j)] = np.asarray(np.linalg.qr(np.column_stack([rows.Y[of], rows.tau[of]]), mode="r")) / size
    return {j: _bound(pressed, j) if j in pressed else 0.0 for j in drives}


def _bound(pressed: Mapping[int, Array], free: int) -> float:
    """Return the least of all gains, of rows of each drive: columns, then what is known, then what it shows."""
    from scipy.optimize import minimize_scalar

    few = pressed[free]
    own = np.vstack([few, np.zeros((max(0, few.shape[1] - len(few)), few.shape[1]))])  # for all singular values
    others = np.vstack([np.zeros((1, own.shape[1])), *(one for j, one in pressed.items() if j != free)])
    both = np.vstack([others, own])[:, :-2]
    scale = np.linalg.norm(both, axis=0)
    U, s, _ = np.linalg.svd(both / np.where(scale > 0, scale, 1.0), full_matrices=False)
    U = U[:, s > LEAST * s[0]]
    left, s, Wt = np.linalg.svd(U[len(others) :])
    s = np.append(s, np.zeros(len(Wt) - len(s)))
    along = U[: len(others)] @ Wt.T
    c = np.linalg.norm(along, axis=0)
    c = np.where(c > LEAST, c, 0.0)
    along = along / np.where(c > 0, c, 1.0) * (c > 0)
    left = left[:, : len(s)] * (s > LEAST)
    b = others[:, -1] - others[:, -2]
    F, i = own[:, -2], own[:, -1]
    b_along, F_along, i_along = along.T @ b, left.T @ F, left.T @ i
    b_out, F_out, i_out = b - along @ b_along, F - left @ F_along, i - left @ i_along

    def least(u: Array) -> Array:
        u = np.asarray(u)[..., None]
        off = u * s * b_along - c * (i_along - u * F_along)
        inside = np.sum(off**2 / (c**2 + (u * s) ** 2), axis=-1)
        return np.asarray(inside + b_out @ b_out + np.sum((i_out - u * F_out) ** 2, axis=-1))

    at = np.linspace(-WIDE, WIDE, 2 * WIDE * FINE + 1)
    found = np.inf
    for sign in (1.0, -1.0):
        seen = least(sign * 10.0**at)
        for k in np.flatnonzero((seen[1:-1] <= seen[:-2]) & (seen[1:-1] <= seen[2:])) + 1:
            ends = (at[k - 1], at[k + 1])
            best = minimize_scalar(lambda x: float(least(sign * 10.0**x)), bounds=ends, method="bounded")  # noqa: B023
            found = min(found, float(best.fun), float(seen[k]))
        found = min(found, float(seen[0]), float(seen[-1]))
    return max(0.0, found - ROUNDED * len(pressed))


SURE = 6.0
"""Standard errors from which on a gain is another than was given."""

OFF = 0.03
"""Part by which it is off at least, if anything is reported: friction that the model lacks makes as much."""

ALIKE, FAR = 0.1, 0.1
"""Parts within which parameters are off by one factor, and by which this factor is not one."""

LEVEL = 1.5
"""Times the least sum of squares up to which several gains explain what is off as well as the best."""

NEAR = 0.5
"""Part of what is given from which on one step of a gain is looked at by a whole fit."""

FEW = 3
"""Parameters from which on they may be reported to be off by one factor."""


def doubts(
    model: LinearModel,
    specified: Mapping[int, ColumnUnits],
    forces: Sequence[int],
    shown: Collection[int],
    fitted: Fitted,
    again: Callable[[int], Fitted],
    alone: bool,
) -> list[str]:
    """Return a note on the gain that was given and does not fit, or on what all of them have in common; or nothing.

    Args:
        model: the mechanism.
        specified: gains by the number of their velocity.
        forces: numbers of velocities whose drives show forces; columns of these may be what is off.
        shown: numbers of velocities whose gains are found with the rest.
        fitted: the fit with them.
        again: fits once more with the gain of this velocity free, what its drive shows taken for a force so far.
        alone: whether nothing else is of known size: no payload, and no other drive that shows its force.
    """
    if alone:
        return _by_one_factor(model, specified, fitted.regression)
    units = [force_unit(unit) for unit in SceneUnits(model.scene).velocities]
    freed: list[tuple[float, int, str, Fitted]] = []
    most = sum(fit.percent**2 for fit in fitted.fits)  # a fit with one gain more that leaves as much went far away
    for j, bound in _in_doubt((*specified, *(forces if specified else ())), fitted, shown):
        if freed and bound > LEVEL * min(one[0] for one in freed):
            break
        try:
            other = again(j)
        except IdentifyError:  # it is not identifiable
            continue
        error, part = float(other.regression.errors[-1]), float(other.gains[j])
        left, one = sum(fit.percent**2 for fit in other.fits), specified.get(j)
        if left < most and abs(part - 1) > max(SURE * error, OFF):  # NaN: not identifiable
            size, unit = (1.0, "times as much") if one is None else (one.value, f"{units[j]}/{one.unit}")
            value = f"{part * size:.4g} {unit} with a standard error of {error * abs(size):.2g}"
            freed.append((left, j, value, other))
    freed.sort(key=lambda one: one[0])
    alike = sorted((one for one in freed if one[0] < LEVEL * freed[0][0]), key=lambda one: one[1])
    if not alike:
        return []
    names = drive_names(model.scene)
    given = [
        f"gain {names[j]}={specified[j].value:.4g}*{specified[j].unit}"
        if j in specified
        else f"{names[j]} in {units[j]}"
        for _, j, _, _ in alike
    ]
    free = [f"{names[j]} is {value}" for _, j, value, _ in alike]
    pairs = list(zip(fitted.fits, alike[0][3].fits, strict=True))
    before, after = max(pairs, key=lambda pair: pair[0].percent - pair[1].percent)
    fit = f"{before.drive} is off by {after.percent:.3g} % in place of {before.percent:.3g} %"
    if len(alike) == 1:
        ((_, j, _, _),) = alike
        unit = specified[j].unit if j in specified else "A"
        return [
            f"{given[0]} does not fit: left free, {free[0]}, and {fit}; what was found with it is off, too. Look it up "
            f"again, or identify it, with {argument('units', {names[j]: unit})}"
        ]
    return [
        f"{' and '.join(given)} do not fit together: left free, {' or '.join(free)}, and {fit}; the data do not show "
        "which one is wrong, and what was found with them is off, too. A payload of known mass shows it"
    ]


def _in_doubt(drives: Sequence[int], fitted: Fitted, shown: Collection[int]) -> list[tuple[int, float]]:
    """Return drives whose gains may be others, with a bound of the sum of squares of a fit without it, least first."""
    step = steps(fitted.rows, fitted.regression, drives)
    far = [j for j in drives if abs(step[j].size) > NEAR * max(SURE * step[j].error, OFF)]
    least = bounds(fitted.rows, far, shown)
    return sorted(((j, 100**2 * least[j]) for j in far), key=lambda one: one[1])


def _by_one_factor(model: LinearModel, specified: Mapping[int, ColumnUnits], regression: Regression) -> list[str]:
    """Return a note where all parameters are off by one factor from those of the scene."""
    count = len(model.prior)
    after, errors = regression.estimate[:count], regression.errors[:count]
    clear = np.isfinite(model.prior) & (model.prior != 0) & (np.abs(after) > np.abs(errors) / ALIKE)
    ratios = after[clear] / model.prior[clear]
    factor = float(np.median(ratios)) if len(ratios) >= FEW else 1.0
    if abs(factor - 1) < FAR or np.max(np.abs(ratios / factor - 1)) > ALIKE:
        return []
    names = drive_names(model.scene)
    given = listed([f"{names[j]}={one.value:.4g}*{one.unit}" for j, one in specified.items()])
    return [
        f"masses and inertias are all {factor:.3g} times those of the scene, as if {given} ought to be "
        f"{1 / factor:.3g} times as much, and nothing else is of known size: look the gain up again, or measure once "
        "more with a payload of known mass"
    ]
