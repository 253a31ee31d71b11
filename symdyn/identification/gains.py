"""Gains of drives: what a drive shows, a current, times its gain is its force, and the gain is not known.

    k_j i_j = Y_j β + F_j + noise         F: forces of what is known of payloads; noise is in i, as measured
    i_j = (Y_j β + F_j) / k_j             so this is what is fitted, by Gauss-Newton: with f0 = Y β0 + F at β0, k0

    k0 i - F - f0 = Y β - (f0 / k0) k     a row for each, and a column for each gain

With i itself in the column, in place of f0 / k0, its noise would make gains too small. Where nothing is known, k and β
may grow together, and the direction (β0, k0) is not told, exactly: whatever the noise.

Reference: Gautier and Briot, Global identification of joint drive gains and dynamic parameters of robots (2014).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.identification.filtered import Indices
from symdyn.identification.regression import Regression, Rows
from symdyn.scene import Scene
from symdyn.scene.units import velocity_units
from symdyn.simulation.prescribed.forces import drive_names

STEPS = 30
"""Of Gauss-Newton, at most."""

SETTLED = 1e-6
"""Part of a gain that a step changes it by when no more are taken."""

LONGEST = 5.0
"""Times by which one step may change a gain."""

LEAST = 1e-9
"""Part of the largest singular value below which the first guess leaves a direction to what was expected."""

HARDLY = 0.2
"""Standard error, in parts of a gain, from which on it is said to be hardly told."""


@dataclass(frozen=True)
class Gain:
    """What the column of a drive is multiplied by to become its force.

    Attributes:
        drive: its name.
        unit: such as "N m/A".
        value: as found; negative where the column has the other sign than the force.
        error: its standard error; NaN where the data do not tell it.
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
                "told: a heavier payload, or one further out, is felt more"
            )
        turned = f"gain {self.drive} is below zero: its column has the other sign than its force"
        return turned if self.value < 0 else ""


@dataclass(frozen=True)
class Gains:
    """Gains of the drives that do not show forces, at some point of the fit.

    Attributes:
        shown: what one of what they show is, by the number of their velocity.
        values: of every velocity, shape (nv,); one where a drive shows its force.
        forces: β and what is not known of payloads, with which the forces are, shape (b,).
    """

    shown: Mapping[int, str]
    values: Array
    forces: Array

    @property
    def drives(self) -> list[int]:
        """Numbers of the velocities whose gains are looked for, shape (g,)."""
        return list(self.shown)

    @property
    def factors(self) -> Array:
        """What columns are multiplied by to become forces, those of what is known last: shape (b + 1,)."""
        found: Array = np.append(self.forces, 1.0)
        return found

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

    def moved(self, estimate: Array) -> tuple[Gains, float]:
        """Return them after a step, and the largest part of a gain by which it is one."""
        values, part = self.values.copy(), 0.0
        for j, new in zip(self.drives, estimate[len(self.forces) :], strict=True):
            ratio = float(new / self.values[j])
            part = max(part, abs(ratio - 1))
            values[j] = self.values[j] * (np.clip(ratio, 1 / LONGEST, LONGEST) if ratio > 0 else ratio or 1.0)
        return Gains(self.shown, values, estimate[: len(self.forces)]), part


def expected(shown: Mapping[int, str], seen: Array, forces: Array) -> Array:
    """Return gains of all velocities, shape (nv,): those by which what was seen is what a scene expects, else one.

    Args:
        shown: as of `Gains`.
        seen: what drives show, shape (N, nv).
        forces: as the scene expects them, shape (N, nv); NaN where it does not.
    """
    found = np.ones(seen.shape[1])
    for j in shown:
        size = float(seen[:, j] @ seen[:, j])
        ratio = float(forces[:, j] @ seen[:, j]) / size if size else np.nan
        largest = float(np.abs(seen[:, j]).max(initial=0.0))
        found[j] = ratio if np.isfinite(ratio) and ratio else 1 / largest if largest else 1.0
    return found


def first(shown: Mapping[int, str], rows: Rows, prior: Array, gains: Array) -> Gains:
    """Return where Gauss-Newton starts: least squares with currents that are smoothed first (two stages).

    Args:
        shown: as of `Gains`.
        rows: what drives show, and columns, the last of them forces that are known.
        prior: of the parameters, shape (b,).
        gains: that are expected, shape (nv,).
    """
    Y, known, joint = rows.Y[:, :-1], rows.Y[:, -1], rows.joint
    b, drives = Y.shape[1], list(shown)
    columns, target, weights = np.zeros((len(Y), len(drives))), rows.tau - known, np.ones(len(Y))
    for j in np.unique(joint):
        of = joint == j
        size = float(np.sqrt(np.mean((gains[j] * rows.tau[of]) ** 2)))
        weights[of] = 1 / size if size > 0 else 1.0
        if j in shown:
            span = rows.Y[of] / np.maximum(np.linalg.norm(rows.Y[of], axis=0), 1e-300)
            columns[of, drives.index(int(j))] = -span @ np.linalg.lstsq(span, rows.tau[of], rcond=LEAST)[0]
            target[of] = -known[of]
    begin = np.append(prior, gains[drives])
    A = np.column_stack([Y, columns]) * weights[:, None]
    scale = np.linalg.norm(A, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    found = begin + np.linalg.lstsq(A / scale, target * weights - A @ begin, rcond=LEAST)[0] / scale
    values = gains.copy()
    values[drives] = np.where(found[b:] != 0, found[b:], gains[drives])
    return Gains(shown, values, found[:b])


def told_gains(scene: Scene, shown: Mapping[int, str], regression: Regression, values: Array) -> tuple[Gain, ...]:
    """Return the gains of a fit, with their standard errors, in the order of velocities."""
    names, kinds = drive_names(scene), velocity_units(scene)
    errors = regression.errors[len(regression.names) - len(shown) :]
    return tuple(
        Gain(names[j], f"{'N m' if kinds[j] == 'rad' else 'N'}/{one}", float(values[j]), float(error))
        for (j, one), error in zip(shown.items(), errors, strict=True)
    )
