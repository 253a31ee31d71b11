"""Logs fitted: rows of a base regressor, outliers left out round by round, and how well each force is predicted.

Y β + Y_L x + F = k i       Y_L, x, F: what is not known of payloads and what is (`payload`); k: gains (`gains`)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import IdentifyError
from symdyn.identification.filtered import Flags, Motion
from symdyn.identification.gains import SETTLED, STEPS, Gains, expected, first
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.payload import Carried, Evidence, Fit, held_in, mean_square, moving, rows_of
from symdyn.identification.regression import Outlier, Regression, Rows, far, solve, stretches
from symdyn.scene import SceneUnits
from symdyn.scene.values import force_unit
from symdyn.simulation.prescribed import drive_names

ROUNDS = 4
"""Of leaving out outliers and fitting again."""


@dataclass(frozen=True)
class Fitted:
    """What a fit found.

    Attributes:
        regression: least squares of all parameters: β, then what is not known of payloads, then gains.
        gains: of every velocity, shape (nv,); one where a drive shows its force.
        motions: with forces in place of what drives show.
        fits: how well each driving force is predicted.
        rows: what was fitted, with what drives show.
        outliers: what was left out.
        notes: what a user should know, one line each.
        predicted: forces of each motion, shapes (N, nv).
        used: of each motion, which samples were fitted, shapes (N, nv).
        held: of each motion, which samples were held back, shapes (N,).
    """

    regression: Regression
    gains: Array
    motions: tuple[Motion, ...]
    fits: tuple[Fit, ...]
    rows: Rows
    outliers: tuple[Outlier, ...]
    notes: tuple[str, ...]
    predicted: tuple[Array, ...]
    used: tuple[Flags, ...]
    held: tuple[Flags, ...]


def fitted(
    model: LinearModel,
    evidence: Evidence,
    carried: Carried,
    shown: Mapping[int, str],
    band: float,
    leave_out: bool,
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
    names = (*model.names, *carried.names, *(f"gain {drive_names(model.scene)[j]}" for j in shown))
    start = np.append(np.nan_to_num(model.prior), np.zeros(len(carried.names)))
    usual = expected(
        shown,
        np.concatenate([one.motion.tau for one in parts]),
        np.concatenate([one.Y @ np.append(start, 1.0) for one in parts]),
    )
    prior = np.append(start, usual[list(shown)])
    gains = Gains(shown, usual, start)
    used = list(evidence.used)
    out = [np.zeros(one.motion.tau.shape, bool) for one in parts]
    for k in range(ROUNDS if leave_out else 1):
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
        if not leave_out or k == ROUNDS - 1:
            break
        new = _far(residuals, used, forces, model.rows)
        if not any(one.any() for one in new):
            break
        out = [one | more for one, more in zip(out, new, strict=True)]
        used = [one & ~more for one, more in zip(used, new, strict=True)]
    drives = drive_names(model.scene)
    outliers = [
        one
        for part, mask, left in zip(parts, out, residuals, strict=True)
        for one in stretches(mask, left, part.motion.t, part.motion.source, drives)
    ]
    return Fitted(
        regression,
        gains.values,
        tuple(replace(one.motion, tau=force) for one, force in zip(parts, forces, strict=True)),
        _fits(model, evidence, gains, rows, used),
        rows,
        tuple(outliers),
        (*_standing(model, [one.motion for one in parts]), *_told_of(outliers, out)),
        tuple(predicted),
        tuple(used),
        tuple(held_in(one) for one in parts),
    )


def _settled(rows: Rows, gains: Gains, names: Sequence[str], prior: Array, band: float) -> tuple[Regression, Gains]:
    """Return least squares and gains; without these, one solution is all.

    Raises:
        IdentifyError: gains do not settle.
    """
    for _ in range(STEPS):
        regression = solve(names, gains.linear(rows), prior, band, len(gains.values))
        before, gains = gains, gains.moved(regression.estimate)
        parts = np.abs(gains.values / before.values - 1)
        if parts.max() < SETTLED:
            return regression, gains
    drive = names[len(names) - len(gains.drives) + int(parts[gains.drives].argmax())].removeprefix("gain ")
    raise IdentifyError(
        f"units: gains did not settle in {STEPS} steps: data hardly tell that of {drive}; give a log with a payload "
        f"that it feels, or its gain, as in --units {drive}=0.12*A"
    )


def _far(residuals: list[Array], used: list[Flags], taus: list[Array], rows: tuple[int, ...]) -> list[Flags]:
    """Return which samples are far off, of each motion."""
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


def _standing(model: LinearModel, moved: Sequence[Motion]) -> list[str]:
    """Return a note on samples of joints that were left out as `moving` says."""
    left = 1 - np.concatenate([moving(model, one) for one in moved]).mean(axis=0)
    names = drive_names(model.scene)
    parts = [f"{100 * left[j]:.2g} % of {names[j]}" for j in model.rows if left[j] > 0]
    return [f"left out where a joint stands, where dry friction jumps: {', '.join(parts)}"] if parts else []


def _fits(model: LinearModel, evidence: Evidence, gains: Gains, own: Rows, used: Sequence[Flags]) -> tuple[Fit, ...]:
    """Return how well each driving force is predicted; root mean squares over samples, in the band."""
    other = rows_of(model, evidence.parts, used, True)
    back = {
        held: sum(p.stop - p.start for one in evidence.parts for p, h in one.blocks if h is held)
        for held in (False, True)
    }
    units, names = SceneUnits(model.scene).velocities, drive_names(model.scene)
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
                names[j],
                model.scene.shown_unit(force_unit(units[j])),
                off(own, 0 * gains.factors),
                off(own, gains.factors),
                off(own, before) if known else float("nan"),
                off(other, gains.factors),
            )
        )
    return tuple(found)
