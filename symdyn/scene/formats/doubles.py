"""Doubles of a compiled model as the exact numbers they were rounded from, as far as that is beyond doubt.

A compiler turns 90° into 1.5707963267948966 and into the quaternion (0.7071067811865476, 0.7071067811865475, 0, 0).
Here the way back: an angle that is a short decimal of degrees or radians to `ROUNDING`, a rotation that two or three
such angles reproduce to `ROUNDING`, a direction in whole numbers. By chance that happens less than once in a million
numbers. What is not recognised stays the double, digit for digit; with `snap` off, everything does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from symdyn.scene.formats.snap import snap_angle
from symdyn.scene.values import folding
from symdyn.scene.values.formula import DEGREE, quantity
from symdyn.scene.values.quantity import Quantity, Vector
from symdyn.scene.values.turns import Step, turns

ROUNDING = 1e-15
DECIMALS_OF_DEGREES = 6
DECIMALS_OF_RADIANS = 8
LARGEST_WHOLE = 1000

SEQUENCES = ("zyx", "xyz")

Matrix = list[list[float]]


class Doubles:
    """Readers of doubles; `turned` are the places where a multiple of π was recognised."""

    def __init__(self, snap: bool) -> None:
        """Remember whether anything may be recognised."""
        self.snap = snap
        self.turned: dict[str, None] = {}

    def vector(self, values: Sequence[float]) -> Vector:
        """Return three lengths or moments; what is rounding beside the largest is zero."""
        least = ROUNDING * max(abs(float(x)) for x in values) if self.snap else 0.0
        x, y, z = (Quantity.ZERO if abs(v) <= least else quantity(float(v)) for v in values)
        return x, y, z

    def angle(self, value: float, where: str) -> Quantity:
        """Return an angle, rad."""
        exact = _exact_angle(float(value)) if self.snap else None
        if exact is None:
            return quantity(float(value))
        if exact != Quantity.ZERO and turns(exact) is not None:
            self.turned[where] = None
        return exact

    def direction(self, values: Sequence[float]) -> Vector:
        """Return a direction of any length: whole numbers where they say the same as the unit vector."""
        largest = max(abs(float(v)) for v in values)
        if self.snap and largest > 0:
            ratios = [Fraction(float(v) / largest).limit_denominator(LARGEST_WHOLE) for v in values]
            shared = math.lcm(*(ratio.denominator for ratio in ratios))
            whole = [int(ratio * shared) for ratio in ratios]
            norm, length = math.hypot(*whole), math.hypot(*map(float, values))
            if all(abs(a / norm - float(b) / length) <= ROUNDING for a, b in zip(whole, values, strict=True)):
                return Quantity.number(whole[0]), Quantity.number(whole[1]), Quantity.number(whole[2])
        return self.vector(values)

    def rotation(self, quaternion: Sequence[float], where: str) -> tuple[Step, ...]:
        """Return the rotation of a unit quaternion w, x, y, z as elementary steps."""
        matrix = matrix_of(quaternion)
        for sequence in SEQUENCES if self.snap else ():
            exact = [_exact_angle(angle) for angle in _angles(matrix, sequence)]
            if None in exact:
                continue
            steps = [(f"R{axis}", angle) for axis, angle in zip(sequence, exact, strict=True) if angle]
            plain = [(step, _float(angle)) for step, angle in steps]
            if _distance(matrix, plain) <= 4 * ROUNDING:
                snapped = [(step, _resnapped(angle)) for step, angle in steps if angle != Quantity.ZERO]
                if any(turns(angle) is not None for _, angle in snapped):
                    self.turned[where] = None
                return tuple(snapped)
        angles = zip(SEQUENCES[0], _angles(matrix, SEQUENCES[0]), strict=True)
        least = ROUNDING if self.snap else 0.0
        return tuple((f"R{axis}", quantity(angle)) for axis, angle in angles if abs(angle) > least)


def matrix_of(quaternion: Sequence[float]) -> Matrix:
    """Return the rotation matrix of a quaternion w, x, y, z of any length but zero."""
    length = math.hypot(*map(float, quaternion))
    w, x, y, z = (float(part) / length for part in quaternion)
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def times(a: Matrix, b: Matrix) -> Matrix:
    """Return a b."""
    return [[math.fsum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def _exact_angle(value: float) -> Quantity | None:
    """Return a short decimal of degrees (as a multiple of π) or of radians, None for any other angle."""
    slack = ROUNDING * max(1.0, abs(value))
    if abs(value) <= slack:
        return Quantity.ZERO
    degrees = round(math.degrees(value), DECIMALS_OF_DEGREES)
    if abs(math.radians(degrees) - value) <= slack:
        return folding.mul(quantity(degrees), DEGREE)
    radians = round(value, DECIMALS_OF_RADIANS)
    return quantity(radians) if abs(radians - value) <= slack else None


def _resnapped(angle: Quantity) -> Quantity:
    """Return an angle; a decimal that is a multiple of π at its own digits, such as 1.57079633, as that multiple."""
    value = folding.fraction(angle)
    snapped = snap_angle(repr(float(value))) if value is not None else None
    return snapped or angle


def _float(angle: Quantity) -> float:
    half_turns = turns(angle)
    if half_turns is not None:
        return float(half_turns) * math.pi
    value = folding.fraction(angle)
    assert value is not None, "an exact angle is a multiple of pi or a fraction"
    return float(value)


def _angles(matrix: Matrix, sequence: str) -> list[float]:
    """Return the angles a, b, c of R = R_i(a) R_j(b) R_k(c), one after the other, so that errors do not add up."""
    i, j, k = ("xyz".index(axis) for axis in sequence)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    gimbal = max(abs(matrix[k][k]), abs(matrix[j][k])) <= ROUNDING  # b is 90°: only the sum of a and c counts, or
    a = 0.0 if gimbal else math.atan2(-sign * matrix[j][k], matrix[k][k])  # their difference
    rest = times(_elementary(i, -a), matrix)
    b = math.atan2(sign * rest[i][k], rest[k][k])
    rest = times(_elementary(j, -b), rest)
    return [a, b, math.atan2(sign * rest[j][i], rest[i][i])]


def _elementary(axis: int, angle: float) -> Matrix:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[float(a == b) for b in range(3)] for a in range(3)]
    c, s = math.cos(angle), math.sin(angle)
    matrix[j][j], matrix[j][k], matrix[k][j], matrix[k][k] = c, -s, s, c
    return matrix


def _distance(matrix: Matrix, steps: Sequence[tuple[str, float]]) -> float:
    product = [[float(a == b) for b in range(3)] for a in range(3)]
    for kind, angle in steps:
        product = times(product, _elementary("xyz".index(kind[1]), angle))
    return max(abs(matrix[i][j] - product[i][j]) for i in range(3) for j in range(3))
