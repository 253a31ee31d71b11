"""Inertias of a compiled MuJoCo model: principal moments and a quaternion, as six entries along the body axes."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.scene.formats.doubles import ROUNDING, Doubles, matrix_of, times
from symdyn.scene.formats.rounded import possible
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.quantity import Quantity

KEYS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}

AGREEMENT = 1e-8
"""Relative; the compiler of some versions turns a matrix into principal axes no more accurately than this."""


def entries(
    principal: Sequence[float], quaternion: Sequence[float], declared: Sequence[float] | None, doubles: Doubles
) -> dict[str, Quantity]:
    """Return R diag(principal) Rᵀ, the inertia about the centre of mass along the body axes, kg m^2.

    Args:
        principal: principal moments, kg m^2.
        quaternion: w, x, y, z of the principal axes in the body frame.
        declared: xx, yy, zz, xy, xz, yz as the file writes them; they count where the compiler left them alone.
        doubles: says whether a product of inertia that is rounding beside the largest moment is zero.
    """
    computed = _rotated([float(x) for x in principal], quaternion, doubles.snap)
    largest = max(abs(x) for x in computed.values())
    if declared is not None:
        written = dict(zip(KEYS, map(float, declared), strict=True))
        if all(abs(written[key] - computed[key]) <= AGREEMENT * largest for key in KEYS):
            return {key: quantity(value) for key, value in written.items()}
    return {key: quantity(float(x)) for key, x in zip(KEYS, possible(list(computed.values())), strict=True)}


def _rotated(principal: list[float], quaternion: Sequence[float], tidy: bool) -> dict[str, float]:
    rotation = matrix_of(quaternion)
    if tidy:
        rotation = [[float(round(x)) if abs(x - round(x)) <= ROUNDING else x for x in row] for row in rotation]
    scaled = [[x * moment for x, moment in zip(row, principal, strict=True)] for row in rotation]
    full = times(scaled, [list(column) for column in zip(*rotation, strict=True)])
    least = ROUNDING * max(principal) if tidy else 0.0
    return {key: full[i][j] if i == j or abs(full[i][j]) > least else 0.0 for key, (i, j) in KEYS.items()}
