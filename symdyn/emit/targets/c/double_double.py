"""How C writes arithmetic on double-doubles: pairs of doubles whose sum is the number, 106 bits of it.

    a + b  dd_add(a, b)      a b  dd_mul(a, b)      a b, b a double  dd_times(a, b)      1/10  dd_of(0.1, -5.6e-18)

A sum or product that goes into a sum is not brought to normal form before (`_loose`): its low part may be a few units
too large, and the sum is as right as with normal ones. Error bounds, in u² = 2^-106: a product 5, a quotient 15, a
square root 3.2, each of the result, a sum 3 of |a| + |b|; with loose operands up to 16.

References: Dekker, A floating-point technique for extending the available precision (1971); Joldes, Muller and Popescu,
Tight and rigorous error bounds for basic building blocks of double-word arithmetic (2017), algorithms 5, 9, 11 and 17;
Lefèvre, Louvet, Muller, Picot and Rideau, Accurate calculation of Euclidean norms using double-word arithmetic (2023),
for the square root.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import factorial, frexp
from typing import Any

from symdyn.emit.code.operators import LEAF, Printer, Spelling, call
from symdyn.emit.code.real import REALS, Real, digits, halves
from symdyn.graph import Expr, Op

LOOSE = {Op.ADD: "dd_add_loose", Op.SUB: "dd_sub_loose", Op.MUL: "dd_mul_loose"}
"""What is left as it comes where the next operation does not mind."""

NAMES: Mapping[Op, Spelling] = {
    **dict.fromkeys((Op.CONSTANT, Op.PI, Op.SYMBOL), LEAF),
    Op.ADD: call("dd_add", 2),
    Op.SUB: call("dd_sub", 2),
    Op.MUL: call("dd_mul", 2),
    Op.DIV: call("dd_div", 2),
    Op.NEG: call("dd_neg"),
    Op.SIN: call("dd_sin"),
    Op.COS: call("dd_cos"),
    Op.SQRT: call("dd_sqrt"),
    Op.ABS: call("dd_abs"),
    Op.SIGN: call("dd_sign"),
    **{op: call(f"dd_{op.name.lower()}", 1 + (op is Op.ATAN2)) for op in REALS["dd"].lacks},
}

PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")
"""To 101 digits, of which the reduction of an angle needs 62."""

CUT, PARTS = 33, 3
"""Bits of the first parts of π/2, so that 20 bits times one of them is exact, and how many such parts there are."""

SINE_TERMS, COSINE_TERMS = 13, 14
"""Last terms of the series: y^27 and y^28."""

SINE_IN_DOUBLE, COSINE_IN_DOUBLE = 8, 9
"""The first terms that doubles hold well enough, y^17 and y^18: they are below 2^-53."""


@dataclass(frozen=True)
class DoubleDoublePrinter(Printer):
    """Writes nodes as calls of the arithmetic; sums and products stay loose where that does no harm."""

    def definition(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return the right-hand side of the line that gives `node` its name, in normal form."""
        return self._called(node, names, constants, loose=False)

    def _bound(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the text of `node`, which is a name or a call."""
        return self._text(node, names, constants, ()), self.spellings[Op.NEG].binds

    def _text(
        self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction], loose: tuple[Op, ...]
    ) -> str:
        if node in names:
            return names[node]
        if node in constants:
            return f"dd_of({self.literal(constants[node])})"
        return self._called(node, names, constants, node.op in loose)

    def _called(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction], loose: bool) -> str:
        spelled = f"{LOOSE[node.op]}({{}}, {{}})" if loose else self.spellings[node.op].pattern
        if node.op is Op.MUL:
            for one, other in (node.args, node.args[::-1]):
                if one in constants and not halves(constants[one])[1]:
                    factor = halves(constants[one])[0]
                    word = "dd_scale" if abs(frexp(factor)[0]) == 0.5 else "dd_times_loose" if loose else "dd_times"
                    return f"{word}({self._text(other, names, constants, (Op.MUL,))}, {factor!r})"
        below = (Op.MUL,) if node.op is Op.MUL else tuple(LOOSE) if node.op in LOOSE else ()
        return spelled.format(*(self._text(arg, names, constants, below) for arg in node.args))


def printer(real: Real) -> Printer:
    """Return what writes double-doubles in C."""
    return DoubleDoublePrinter(NAMES, lambda value: digits(value, real))


def sincos_numbers() -> Mapping[str, Any]:
    """Return the numbers of sine and cosine: π/2 in parts, and the coefficients of both series in y².

    sin y = y (1 + z S(z)),   cos y = 1 - z/2 + z² C(z),   z = y², |y| ≤ π/4
    """
    sine = [Fraction((-1) ** m, factorial(2 * m + 1)) for m in range(1, SINE_TERMS + 1)]
    cosine = [Fraction((-1) ** m, factorial(2 * m)) for m in range(2, COSINE_TERMS + 1)]
    return {
        "limit_exponent": REALS["dd"].limit_exponent,
        "two_over_pi": repr(float(2 / PI)),
        "half_pi": [f"{part!r}" for part in half_pi()],
        "sine": _series(sine, SINE_IN_DOUBLE - 1),
        "cosine": _series(cosine, COSINE_IN_DOUBLE - 2),
    }


def half_pi() -> list[float]:
    """Return π/2 in parts: three of 33 bits, so that 20 bits times one are exact, and two doubles for the rest."""
    rest, parts = PI / 2, []
    for k in range(PARTS):
        unit = Fraction(2) ** -(CUT * (k + 1) - 1)
        parts.append(float(rest // unit * unit))
        rest -= Fraction(parts[-1])
    return [*parts, *halves(rest)]


def _series(coefficients: list[Fraction], exact: int) -> dict[str, Any]:
    """Return a series: its first `exact` coefficients as pairs, last first, the others by Horner's rule."""
    short = [float(one) for one in coefficients[exact:]]
    text = repr(short[-1])
    for one in short[-2::-1]:
        text = f"{one!r} + z.hi * ({text})"
    return {"short": text, "pairs": [digits(one, REALS["dd"]) for one in coefficients[exact - 1 :: -1]]}
