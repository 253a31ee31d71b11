"""Numbers and placements as text: decimals that read back to the same value, poses as xyz and rpy.

    pose = product of elementary motions = translation xyz · Rz(yaw) Ry(pitch) Rx(roll)

What is rational stays exact: a terminating decimal is written in full, rotations by right angles give whole numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import Context, Decimal, Inexact
from fractions import Fraction

from symdyn.graph import Graph, Op
from symdyn.scene.formats.snap import PI_50, snap_angle
from symdyn.scene.values.body import Pose
from symdyn.scene.values.quantity import FormulaError, Quantity, Value
from symdyn.scene.values.turns import circular

MOST_DIGITS = 40
"""A decimal longer than this is written as the nearest double, or as a fraction."""

EXACT = Context(prec=MOST_DIGITS, traps=[Inexact])

NEARLY_ZERO = 1e-14
"""Cosine of the pitch below which roll and yaw turn about one axis, so that the roll may be zero."""

Rows = list[list[Value]]


def decimal_text(value: Value) -> str:
    """Return a number as a decimal: exact where it terminates within `MOST_DIGITS`, else the nearest double."""
    if isinstance(value, Fraction):
        try:
            exact = exact_decimal(value)
        except Inexact:
            return repr(float(value)).removesuffix(".0")
        return f"{exact:f}" if Fraction(1, 10**9) <= abs(value) < 10**15 else str(exact)
    return repr(float(value)).removesuffix(".0")


def exact_decimal(value: Fraction) -> Decimal:
    """Return a fraction as a decimal without zeros behind it.

    Raises:
        Inexact: it has none of at most `MOST_DIGITS` digits.
    """
    return EXACT.normalize(EXACT.divide(Decimal(value.numerator), Decimal(value.denominator)))


def angle_text(value: Value) -> str:
    """Return an angle as a decimal that is snapped to a multiple of π by a reader only if it is one."""
    text = decimal_text(value)
    if isinstance(value, Fraction) and "e" not in text.lower():
        text = text if "." in text else f"{text}."
        while snap_angle(text) is not None:
            text += "0"
    return text.removesuffix(".")


def xyz_rpy(pose: Pose, values: Mapping[str, Value]) -> tuple[list[Value], list[Value]]:
    """Return a pose as a translation (m) and roll, pitch, yaw (rad).

    Raises:
        FormulaError: one of its amounts has no value.
    """
    R: Rows = [[Fraction(i == j) for j in range(3)] for i in range(3)]
    p: list[Value] = [Fraction(0)] * 3
    turns: list[tuple[str, Value]] = []
    for kind, amount in pose.steps:
        axis = "xyz".index(kind[1])
        if kind[0] == "T":
            shift = known(amount, values)
            p = [p[i] + R[i][axis] * shift for i in range(3)]
        else:
            turns.append((kind, known_angle(amount, values)))
            R = _product(R, _elementary(axis, amount, values))
    order = [kind for kind, _ in turns]
    if order == [kind for kind in ("Rz", "Ry", "Rx") if kind in order]:
        given = dict(turns)
        return p, [given.get(kind, Fraction(0)) for kind in ("Rx", "Ry", "Rz")]
    return p, _rpy(R)


def known(quantity: Quantity, values: Mapping[str, Value]) -> Value:
    """Return the value of a quantity.

    Raises:
        FormulaError: one of its symbols has no value.
    """
    value = quantity.at(values)
    if value is None:
        raise FormulaError(f"depends on {', '.join(quantity.symbols)} without a value")
    return value


def known_angle(quantity: Quantity, values: Mapping[str, Value]) -> Value:
    """Return the value of an angle, a multiple of π as the double nearest to it; see `known`."""
    form = quantity.express(Graph()).linear_form()
    if form.turns and not form.constant and not form.terms:
        return float(form.turns * PI_50)
    return known(quantity, values)


def _elementary(axis: int, angle: Quantity, values: Mapping[str, Value]) -> Rows:
    c, s = (known(circular(op, angle), values) for op in (Op.COS, Op.SIN))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R: Rows = [[Fraction(a == b) for b in range(3)] for a in range(3)]
    R[j][j], R[j][k], R[k][j], R[k][k] = c, -s, s, c
    return R


def _product(A: Rows, B: Rows) -> Rows:
    return [[_dot(row, [B[k][j] for k in range(3)]) for j in range(3)] for row in A]


def _dot(a: Sequence[Value], b: Sequence[Value]) -> Value:
    total: Value = Fraction(0)
    for x, y in zip(a, b, strict=True):
        if x and y:
            total += x * y
    return total


def _rpy(R: Rows) -> list[Value]:
    """Return roll, pitch and yaw of a rotation matrix, |pitch| <= π/2."""
    r = [[float(x) for x in row] for row in R]
    level = math.hypot(r[0][0], r[1][0])
    pitch = math.atan2(-r[2][0], level)
    if level < NEARLY_ZERO:
        return [Fraction(0), pitch, math.atan2(-r[0][1], r[1][1])]
    return [_turn(r[2][1], r[2][2]), pitch, _turn(r[1][0], r[0][0])]


def _turn(s: float, c: float) -> Value:
    return math.atan2(s, c) if s else (Fraction(0) if c > 0 else math.pi)
