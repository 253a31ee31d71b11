"""Gains that were said, held against the data: whether forces fit better where one of them is left free.

A wrong one does not stay with its drive: all that this drive tells, masses and gains of others, is scaled with it. So
it may as well be that a column of forces is off, which a gain that was said rightly contradicts.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from symdyn.errors import IdentifyError
from symdyn.identification.fitting import Fitted
from symdyn.identification.free_gain import bounds, steps
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.regression import Regression
from symdyn.identification.units import ColumnUnits
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit, listed
from symdyn.simulation.prescribed import drive_names

SURE = 6.0
"""Standard errors from which on a gain is another than was said."""

OFF = 0.03
"""Part by which it is off at least, if anything is said: friction that the model lacks makes as much."""

ALIKE, FAR = 0.1, 0.1
"""Parts within which parameters are off by one factor, and by which this factor is not one."""

LEVEL = 1.5
"""Times the least sum of squares up to which several gains explain what is off as well as the best."""

NEAR = 0.5
"""Part of what is said from which on one step of a gain is looked at by a whole fit."""

FEW = 3
"""Parameters from which on they may be said to be off by one factor."""


def doubts(
    model: LinearModel,
    specified: Mapping[int, ColumnUnits],
    forces: Sequence[int],
    shown: Collection[int],
    fitted: Fitted,
    again: Callable[[int], Fitted],
    alone: bool,
) -> list[str]:
    """Return a note on the gain that was said and does not fit, or on what all of them have in common; or nothing.

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
    for j, bound in _in_doubt((*specified, *(forces if specified else ())), fitted, shown):
        if freed and bound > LEVEL * min(one[0] for one in freed):
            break
        try:
            other = again(j)
        except IdentifyError:  # the data do not tell it
            continue
        error, part = float(other.regression.errors[-1]), float(other.gains[j])
        if abs(part - 1) > max(SURE * error, OFF):  # NaN: not told
            value = f"{part:.4g} times as much with a standard error of {error:.2g}"
            if (one := specified.get(j)) is not None:
                kind = f"{units[j]}/{one.unit}"
                value = f"{part * one.value:.4g} {kind} with a standard error of {error * abs(one.value):.2g}"
            freed.append((sum(fit.percent**2 for fit in other.fits), j, value, other))
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
            f"again, or let the data tell it, with --units {names[j]}={unit}"
        ]
    return [
        f"{' and '.join(given)} do not fit together: left free, {' or '.join(free)}, and {fit}; the data do not tell "
        "which one is wrong, and what was found with them is off, too. A payload of known mass tells"
    ]


def _in_doubt(drives: Sequence[int], fitted: Fitted, shown: Collection[int]) -> list[tuple[int, float]]:
    """Return drives whose gains may be others, with a bound of the sum of squares of a fit without it, least first."""
    step = steps(fitted.rows, fitted.regression, drives)
    far = [j for j in drives if abs(step[j].size) > NEAR * max(SURE * step[j].error, OFF)]
    least = bounds(fitted.rows, far, shown)
    return sorted(((j, 100**2 * least[j]) for j in far), key=lambda one: one[1])


def _by_one_factor(model: LinearModel, specified: Mapping[int, ColumnUnits], regression: Regression) -> list[str]:
    """Return a note where all parameters are off by one factor from what the scene says."""
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
        f"masses and inertias are all {factor:.3g} times what the scene says, as if {given} ought to be "
        f"{1 / factor:.3g} times as much, and nothing else is of known size: look the gain up again, or measure once "
        "more with a payload of known mass"
    ]
