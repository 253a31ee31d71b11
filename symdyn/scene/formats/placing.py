"""Numbers, placements and names of other formats: decimals that read back, multiples of π, poses as xyz and rpy.

    pose = product of elementary motions = translation xyz · Rz(yaw) Ry(pitch) Rx(roll)

What is rational stays exact: a terminating decimal is written in full, rotations by right angles give whole numbers.
Names may be any text there, and are identifiers of Python, C and LaTeX here.

Files write decimals for multiples of π because they cannot write π:

    1.57079633  is π/2 rounded at its last digit
    1.5708      is too, and stays a decimal: π/2 differs from it by 4e-6, which other readers of the file do not add
    1.57079632  is π/2 cut off, not rounded: it stays a decimal

The multiple must be simple, k π / d with d in `DENOMINATORS` and |k / d| <= 2, or whole degrees, and the text must be
that multiple *correctly rounded at its own last digit*, which has at least seven before it: what reading changes is
below 5e-8 rad. Beyond fifteen digits a text is often a double printed in full, right only in its first sixteen
(1.57079632679489655800): then it is enough that the double nearest to the text is the double nearest to the multiple.

A compiler of models turns 90° into 1.5707963267948966 and into the quaternion (0.7071067811865476, 0.7071067811865475,
0, 0). Here is the way back: an angle that is a short decimal of degrees or radians to `ROUNDING`, a rotation that two
or three such angles reproduce to `ROUNDING`, a direction in whole numbers. By chance that happens less than once in a
million numbers. What is not recognised stays the double, digit for digit; with `snap` off, everything does.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal, Inexact, InvalidOperation
from fractions import Fraction

from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose, Step, circular, turns
from symdyn.scene.values.folding import DEGREE
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.grammar import check_name
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, Value, Vector, exact_decimal

DENOMINATORS = (1, 2, 3, 4, 5, 6, 8, 9, 10, 12)
DEGREES = 180

FEWEST_DIGITS = 8
"""Significant digits from which on a decimal may be a multiple of π."""

DIGITS_OF_A_DOUBLE = 15
"""Every decimal of so many digits survives being stored as a double; one of more digits may not."""

LONGEST_TEXT = 60

PI_50 = Fraction("3.14159265358979323846264338327950288419716939937511")

_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?\Z")


def snap_angle(text: str) -> Quantity | None:
    """Return the simple multiple of π that a decimal is rounded from, None if it is not clear that it is one.

    Args:
        text: a decimal as the file writes it, rad, such as "-1.5707963" or "7.853981634e-1".
    """
    text = text.strip()
    if len(text) > LONGEST_TEXT or not _DECIMAL.match(text):
        return None
    for denominator in (*DENOMINATORS, DEGREES):
        turns = Fraction(round(Fraction(text) * denominator / PI_50), denominator)
        if turns and abs(turns) <= 2 and is_rounding(text, turns * PI_50):
            return folding.mul(Quantity.number(turns), Quantity.PI)
    return None


def is_rounding(text: str, exact: Fraction, fewest_digits: int = FEWEST_DIGITS) -> bool:
    """Return whether a decimal is a number rounded correctly at the decimal's own last digit.

    Args:
        text: a decimal such as "0.70711".
        exact: the number, or a fraction within 1e-50 of it.
        fewest_digits: significant digits that the decimal must have.
    """
    try:
        decimal = Decimal(text)
    except InvalidOperation:
        return False
    _, digits, exponent = decimal.as_tuple()
    if not isinstance(exponent, int) or len(digits) < fewest_digits:
        return False
    if len(digits) > DIGITS_OF_A_DOUBLE and float(decimal) == float(exact):
        return True
    return abs(Fraction(decimal) - exact) * 2 <= Fraction(10) ** exponent


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
    p, R = placement(pose, values)
    turns = [(kind, known_angle(amount, values)) for kind, amount in pose.steps if kind[0] == "R"]
    order = [kind for kind, _ in turns]
    if order == [kind for kind in ("Rz", "Ry", "Rx") if kind in order]:
        given = dict(turns)
        return p, [given.get(kind, Fraction(0)) for kind in ("Rx", "Ry", "Rz")]
    return p, _rpy(R)


def placement(pose: Pose, values: Mapping[str, Value]) -> tuple[list[Value], Rows]:
    """Return a pose as a translation (m) and a rotation matrix; FormulaError where one of its amounts has no value."""
    R: Rows = [[Fraction(i == j) for j in range(3)] for i in range(3)]
    p: list[Value] = [Fraction(0)] * 3
    for kind, amount in pose.steps:
        axis = "xyz".index(kind[1])
        if kind[0] == "T":
            shift = known(amount, values)
            p = [p[i] + R[i][axis] * shift for i in range(3)]
        else:
            R = _product(R, _elementary(axis, amount, values))
    return p, R


def known(quantity: Quantity, values: Mapping[str, Value]) -> Value:
    """Return the value of a quantity; FormulaError where one of its symbols has no value."""
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
        return self.turns(matrix_of(quaternion), where)

    def turns(self, matrix: Matrix, where: str) -> tuple[Step, ...]:
        """Return a rotation as elementary steps."""
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
    rest = times(_elementary_double(i, -a), matrix)
    b = math.atan2(sign * rest[i][k], rest[k][k])
    rest = times(_elementary_double(j, -b), rest)
    return [a, b, math.atan2(sign * rest[j][i], rest[i][i])]


def _elementary_double(axis: int, angle: float) -> Matrix:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[float(a == b) for b in range(3)] for a in range(3)]
    c, s = math.cos(angle), math.sin(angle)
    matrix[j][j], matrix[j][k], matrix[k][j], matrix[k][k] = c, -s, s, c
    return matrix


def _distance(matrix: Matrix, steps: Sequence[tuple[str, float]]) -> float:
    product = [[float(a == b) for b in range(3)] for a in range(3)]
    for kind, angle in steps:
        product = times(product, _elementary_double("xyz".index(kind[1]), angle))
    return max(abs(matrix[i][j] - product[i][j]) for i in range(3) for j in range(3))


LONGEST_CORE = 40

SYMBOL = "symbol"
"""The kind of what formulas name."""


def printable_names(names: Iterable[str], kind: str) -> dict[str, str]:
    """Return a printable name for each name; good ones stay, the others come as near as they can and stay unique.

    Args:
        names: in the order of the file; repeated ones share a name.
        kind: such as "link"; helps where a name has no letters, or is one that something else needs.
    """
    every = dict.fromkeys(names)
    chosen = {name: name for name in every if _good(name, kind)}
    taken = dict.fromkeys(chosen)
    for name in every:
        if name not in chosen:
            chosen[name] = _near(name, kind, taken)
            taken[chosen[name]] = None
    return chosen


def _good(name: str, kind: str) -> bool:
    return check_name(name, letter=kind == SYMBOL) is None and name != Scene.GROUND


def _near(name: str, kind: str, taken: dict[str, None]) -> str:
    core = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")[:LONGEST_CORE].rstrip("_")
    if not _good(core, kind):
        core = f"{core}_{kind}" if core[:1].isalpha() else f"{kind}_{core}".rstrip("_")
    found, k = core, 2
    while found in taken or not _good(found, kind):
        found, k = f"{core}_{k}", k + 1
    return found
