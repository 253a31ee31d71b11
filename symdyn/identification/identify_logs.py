"""The function `identify`: logs of motion and driving forces in, base parameters with standard errors out.

Gains of drives that were given are tested against the data: would the forces fit better if one of them were free? A
wrong gain scales all that its drive shows, masses and gains of others too. So it may as well be that a column of forces
is off, which a right gain contradicts.

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
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, check_arguments, native, suggesting
from symdyn.errors import IdentifyError, listed
from symdyn.identification.filtered import Motion, choose_band, motions
from symdyn.identification.gains import Fitted, estimated_gains, fitted
from symdyn.identification.identification import Identification, not_identifiable
from symdyn.identification.linear_model import LinearModel, linear_model
from symdyn.identification.log import ColumnUnits, Log, forces_off, given_gains, read_logs, shown_in
from symdyn.identification.payload import Carried, Payload, carried, check_payloads, evidence
from symdyn.identification.regression import Regression, Rows
from symdyn.scene import SceneLike, SceneUnits, scene_of
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
    """One step of Gauss-Newton of one gain.

    Attributes:
        size: by which the gain would change, in parts of it.
        error: standard error of that; infinite where it is not identifiable.
    """

    size: float
    error: float


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
        found: Array = inside + b_out @ b_out + np.sum((i_out - u * F_out) ** 2, axis=-1)
        return found

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
    for j, bound in _in_doubt((*specified, *(forces if specified else ())), fitted, shown):
        if freed and bound > LEVEL * min(one[0] for one in freed):
            break
        try:
            other = again(j)
        except IdentifyError:  # it is not identifiable
            continue
        error, part = float(other.regression.errors[-1]), float(other.gains[j])
        if abs(part - 1) > max(SURE * error, OFF):  # NaN: not identifiable
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


@suggesting
def identify(
    scene: SceneLike,
    data: Any,
    band: float | None = None,
    friction: str | Sequence[str] = (),
    hold_back: float = 0.0,
    outliers: bool = True,
    units: Mapping[str, str] | None = None,
    values: Mapping[str, object] | None = None,
    payloads: Payload | Sequence[Payload] = (),
    say: Callable[[str], None] | None = None,
) -> Identification:
    """Identify the base parameters of a scene from measured motion and driving forces, with standard errors.

    >>> import numpy as np
    >>> import symdyn
    >>> scene = symdyn.example("pendulum")
    >>> motion, values = "q1=sin(t)+0.4*sin(2.7*t)", {"m": 1.2, "b": 0.03}
    >>> log = symdyn.inverse(scene, motion, times=np.linspace(0, 10, 1001), values=values)
    >>> found = symdyn.identify(scene, {"t": log.t, "q1": log["q1"], "tau1": log["tau1"]})
    >>> [f"{name} = {value:.3f}" for name, value in zip(found.names, found.after, strict=True)]
    ['mxR1 = 0.000', 'myR1 = -0.600', 'JxxR1 + JyyR1 = 0.300', 'b = 0.030']

    Args:
        scene: the mechanism; parameters that are not identifiable keep its values.
        data: path of a CSV file with the columns t, coordinates, driving forces, inputs and states, as `simulate`
            writes them; arrays by name, a data frame or a run; or a list of such, a log each. Velocities and
            accelerations may be among them, else they are differentiated.
        band: highest frequency that is used, Hz; None takes that where noise begins.
        friction: terms that joints with a drive have beside what the scene declares: "viscous", "coulomb", "offset",
            "armature".
        hold_back: share of every log, in contiguous blocks, that is not fitted and judges the result; 0 to 0.9.
        outliers: whether samples that no noise explains are left out; they are reported.
        units: of columns that are not in SI with radians, by name or pattern, such as {"q*": "deg", "t": "ms"}. Drives
            that show currents, {"tau*": "A"}, have their gains among the unknowns; {"tau1": "0.12*A"} has 0.12 N m/A.
        values: of parameters, in place of those that the scene gives: numbers or formulas by name.
        payloads: bodies of known mass that some logs were measured with: they make gains identifiable.
        say: takes notes, a line at a time.

    Raises:
        IdentifyError: with every fault of the data, one line each.
        SceneError: the file of the scene has faults.
        DerivationError: the scene has no driving forces.
    """
    check_arguments(identify, locals(), IdentifyError)
    band, hold_back = native(float, band, hold_back)
    scene = scene_of(scene, values)
    if not scene.velocities:
        raise IdentifyError(f"{scene.name}: nothing moves: no joint has a coordinate")
    faults = []
    if band is not None and not (np.isfinite(band) and band > 0):
        faults.append(f"band = {band!r:.40}: give a frequency in Hz above zero, such as 10")
    if not 0 <= hold_back <= 0.9:
        faults.append(f"hold_back = {hold_back!r:.40}: give a share of the data, 0 to 0.9, such as 0.25")
    if faults:
        raise IdentifyError(faults)
    logs = read_logs(scene, data, units)
    _check_logs(logs, band)
    model = linear_model(scene, (friction,) if isinstance(friction, str) else tuple(friction))
    payloads = (payloads,) if isinstance(payloads, Payload) else tuple(payloads)
    check_payloads(model, payloads, logs)
    shown = shown_in(units or {}, [drive or "" for drive in scene.drives])
    _check_gains(model, shown, payloads, logs)
    band = choose_band(logs) if band is None else band
    parts = [motions(log, band) for log in logs]
    moved = [(place, model.beside(one)) for place, (some, _) in enumerate(parts) for one in some]
    if not moved:
        raise IdentifyError([note for _, told in parts for note in told])
    load = carried(model, payloads, logs)
    held = evidence(model, moved, load, hold_back)
    found = fitted(model, held, load, shown, band, outliers)
    said = given_gains(units or {}, [drive or "" for drive in scene.drives])

    def freed(j: int) -> Fitted:
        unit = said[j].unit if j in said else "force"
        return fitted(model, held, load, {**shown, j: unit}, band, outliers)

    forces = [j for j in model.driven if j not in shown and j not in said]
    alone = not payloads and all(j in shown or j in said for j in model.driven) and len(said) == 1
    doubted = doubts(model, said, forces, shown, found, freed, alone)
    gains = estimated_gains(scene, shown, found.regression, found.gains)
    notes = [note for log, (_, told) in zip(logs, parts, strict=True) for note in (*log.notes, *told)]
    notes += [*_expected(model, logs, moved, load, shown), *found.notes]
    lost = not_identifiable(model, load, shown, found, [place for place, _ in moved])
    notes += [one.words for one in lost]
    notes += [one.words for one in gains if one.words]
    notes += doubted
    if say is not None:
        for note in notes:
            say(note)
    return Identification(
        scene, model, logs, found.motions, band, found.regression, found.fits, found.outliers, lost, tuple(notes),
        found.predicted, found.used, found.validation, gains,
    )  # fmt: skip


def _check_gains(
    model: LinearModel, shown: Mapping[int, str], payloads: Sequence[Payload], logs: Sequence[Log]
) -> None:
    """Raise IdentifyError where no drive is known as a force and nothing of known size acts in some logs alone."""
    driven = model.driven
    if not shown or any(j not in shown for j in driven):
        return
    names = [drive_names(model.scene)[j] for j in driven]
    if payloads and len({tuple(one.carried(k, log) for one in payloads) for k, log in enumerate(logs)}) == 1:
        raise IdentifyError(
            f"{model.scene.name}: {listed(names)}: every log carries the same payload, which cannot "
            "be separated from the body that it is fixed to; measure the motion without it, too, and give both logs"
        )
    if payloads:
        return
    last = model.scene.bodies[-1].name if model.scene.bodies else "BODY"
    python = f'payloads=Payload("{last}", 2, log="loaded.csv")'
    carried = argument("payload", f"loaded.csv:{last}:mass=2", python)
    known = argument("units", {names[0]: "0.12*A"})
    raise IdentifyError(
        f"{model.scene.name}: {listed(names)}: the gain of one {next(iter(shown.values()))} is not identifiable: twice "
        "all gains with twice all masses and frictions is the same motion. Measure again with a payload of known mass "
        f"and give both logs, with {carried}; or give a known gain, as in {known}"
    )


def _check_logs(logs: Sequence[Log], band: float | None) -> None:
    """Raise IdentifyError for a log that counts twice, and for a band that samples cannot show."""
    faults = []
    for k, log in enumerate(logs):
        if any(np.array_equal(log.t, one.t) and np.array_equal(log.tau, one.tau) for one in logs[:k]):
            faults.append(f"{log.source}: is a log that is given already; leave it out")
        half = 0.5 / float(np.median(np.diff(log.t)))
        if band is not None and band > half:
            faults.append(
                f"{log.source}: band = {band:.6g} Hz: samples show no more than {half:.6g} Hz, half of their rate; "
                "give less, or leave it out"
            )
    if faults:
        raise IdentifyError(faults)


def _expected(
    model: LinearModel,
    logs: Sequence[Log],
    moved: Sequence[tuple[int, Motion]],
    load: Carried,
    shown: Mapping[int, str],
) -> list[str]:
    """Return notes on driving forces that are far from what the scene expects of the motion."""
    driven = [j for j in model.driven if j not in shown]
    if not np.isfinite(model.prior).all() or not driven:
        return []
    tau = np.concatenate([one.tau for _, one in moved])
    before = [
        model.regressor(one.q, one.qd, one.qdd) @ model.prior
        + load.columns(model, place, one.q, one.qd, one.qdd)[..., -1]
        for place, one in moved
    ]
    names = [drive_names(model.scene)[j] for j in driven]
    kinds = [SceneUnits(model.scene).velocities[j] for j in driven]
    return forces_off(logs[0].source, names, kinds, tau[:, driven], np.concatenate(before)[:, driven])
