"""How numbers and operations are written in a language: real types, operators, and a printer of formulas.

An exact constant is rounded once, to the nearest number of the type. A double-double is the sum of two doubles, the
second at most half a unit in the last place of the first: 106 bits, and the range of a double.

Sines and cosines may be shorter than doubles allow, a row for every accuracy that `--accuracy` takes:

    n = round(2x/π),   y = x - n π/2                 |y| ≤ π/4, one product; 2⁻⁵³ |x| and n times the rest of π/2 off
    sin y = y + y³ S(y²),   cos y = 1 + y² C(y²)     as `benchmarks/minimax.py` prints them

The bound of a row holds whether sums and products are fused or not: `tests/test_short_sines.py` proves it by balls, the
polynomials, every rounding and the reduction. It is absolute; near multiples of π/2 that are not zero few digits of a
small sine are right.

A spelling says how tightly its result binds and how tightly each operand must bind to stand there bare. Right operands
of + and * must bind tighter than the operator itself, so the text is evaluated in the order of the graph. In the text
of a line stand names of values, and operations that have no name of their own. Graphs are written as Python for SymPy
here, whose import takes longer than writing a lesson.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

from symdyn.algebra import NAMES, BigFloats, RunningErrors
from symdyn.errors import EmitError, choice
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, Piecewise

if TYPE_CHECKING:
    from symdyn.algebra import Midpoints

ANY, SUM, PRODUCT, SIGN, ATOM = range(5)


@dataclass(frozen=True)
class Spelling:
    """One row of a target's table."""

    pattern: str  # text with {} for each operand; for a leaf, for its name or its digits
    binds: int = ATOM  # how tightly the result binds
    wants: tuple[int, ...] = ()  # least binding of each operand


def call(name: str, operands: int = 1) -> Spelling:
    """Return the spelling of a function call."""
    return Spelling(f"{name}({', '.join(['{}'] * operands)})", ATOM, (ANY,) * operands)


LEAF, TABLE = Spelling("{}"), Spelling("{table}({})", ATOM, (ANY,))

OPERATORS: Mapping[Op, Spelling] = {
    Op.CONSTANT: LEAF,
    Op.PI: LEAF,
    Op.SYMBOL: LEAF,
    Op.ADD: Spelling("{} + {}", SUM, (SUM, PRODUCT)),
    Op.SUB: Spelling("{} - {}", SUM, (SUM, PRODUCT)),
    Op.MUL: Spelling("{} * {}", PRODUCT, (PRODUCT, SIGN)),
    Op.DIV: Spelling("{} / {}", PRODUCT, (PRODUCT, SIGN)),
    Op.NEG: Spelling("-{}", SIGN, (ATOM,)),
}
"""What C, Python and most other languages write alike; `--x` never appears, since a sign wants an atom."""


@dataclass(frozen=True)
class Printer:
    """Writes nodes in one language."""

    spellings: Mapping[Op, Spelling]  # a row for every `Op`
    literal: Callable[[Fraction], str]  # how a constant is written
    tables: Mapping[Piecewise, str] = field(default_factory=dict)  # what functions that are given by points are called

    def code(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return `node` as text: its name if it has one, else written out down to names and constants."""
        return self._bound(node, names, constants)[0]

    def definition(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> str:
        """Return the right-hand side of the line that gives `node` its name."""
        return self._written(node, names, constants)[0]

    def _bound(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the text of `node` and how tightly it binds."""
        if node in names:
            return self.spellings[Op.SYMBOL].pattern.format(names[node]), ATOM
        if node in constants:
            digits = self.literal(constants[node])
            return self.spellings[Op.CONSTANT].pattern.format(digits), SIGN if digits.startswith("-") else ATOM
        return self._written(node, names, constants)

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        """Return the operation of `node` with its operands, and how tightly it binds."""
        spelling = self.spellings[node.op]
        operands = []
        for arg, wanted in zip(node.args, spelling.wants, strict=True):
            text, binds = self._bound(arg, names, constants)
            operands.append(text if binds >= wanted else f"({text})")
        named = {"table": self.tables[node.value]} if isinstance(node.value, Piecewise) else {}
        return spelling.pattern.format(*operands, **named), spelling.binds


def standing(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> list[Expr]:
    """Return the nodes that stand in the text of `nodes`, in order, as often as they do; not those that are `known`.

    A `named` node stands for itself, of any other one what it is computed from stands there, too.
    """
    found: list[Expr] = []
    stack = list(nodes)[::-1]
    while stack:
        node = stack.pop()
        if node in named:
            found.append(node)
        elif node not in known:
            found.append(node)
            stack += node.args[::-1]
    return found


def operands(nodes: Iterable[Expr], named: Container[Expr], known: Container[Expr]) -> tuple[Expr, ...]:
    """Return the named nodes that stand in the text of `nodes`, once each, in order."""
    return tuple(dict.fromkeys([node for node in standing(nodes, named, known) if node in named]))


class _Powers(Printer):
    """Writes a product of equal factors as a power."""

    def _written(self, node: Expr, names: Mapping[Expr, str], constants: Mapping[Expr, Fraction]) -> tuple[str, int]:
        if node.op is not Op.MUL:
            return super()._written(node, names, constants)
        pieces: list[str] = []
        for factor, count in Counter(_factors(node, names)).items():
            text, binds = self._bound(factor, names, constants)
            bare = binds > SIGN if pieces or count > 1 else binds >= PRODUCT
            pieces.append((text if bare else f"({text})") + (f"**{count}" if count > 1 else ""))
        return "*".join(pieces), PRODUCT


def _factors(node: Expr, names: Mapping[Expr, str]) -> Iterator[Expr]:
    if node.op is Op.MUL and node not in names:
        for arg in node.args:
            yield from _factors(arg, names)
    else:
        yield node


SYMPY = _Powers(
    {
        **OPERATORS,
        **{op: call(name, op.arity) for op, name in NAMES.items()},
        Op.SELECT: Spelling("Piecewise(({1}, {0} > 0), ({2}, True))", ATOM, (SUM, ANY, ANY)),
        Op.PI: Spelling("pi"),
        Op.NEG: Spelling("-{}", SIGN, (PRODUCT,)),
    },
    lambda value: str(value) if value.denominator == 1 else f"Rational({value.numerator}, {value.denominator})",
)
"""A product of equal factors is a power, a fraction a `Rational`."""


@dataclass(frozen=True)
class ShortSines:
    """How sines and cosines of one accuracy are computed."""

    accuracy: str  # what `--accuracy` calls it: about what functions are right to, relative to their largest entry
    real: str  # type of all numbers
    bound: float  # no sine or cosine is farther than this from that of the same angle
    limit_exponent: int  # angles below 2 to this in size are reduced here, others by the C library
    half_pi: float  # the double next to π/2
    sine: tuple[float, ...]  # coefficients of S, lowest power first
    cosine: tuple[float, ...]  # those of C

    @classmethod
    def accuracies(cls) -> tuple[str, ...]:
        return tuple(SHORT_SINES)

    @classmethod
    def find(cls, accuracy: str, real: str = "") -> ShortSines | None:
        """Return the sines of an accuracy, None for "": as near as the type allows. Type "" is that of the sines.

        Raises:
            EmitError: there is no such accuracy, or not of this type.
        """
        if not accuracy:
            return None
        known = " or ".join(map(repr, SHORT_SINES))
        if accuracy not in SHORT_SINES:
            raise EmitError(
                f"accuracy {accuracy!r} is not known; give {known}, or leave it out for about 1e-16, in float 1e-7"
            )
        row = SHORT_SINES[accuracy]
        if real not in ("", row.real):
            raise EmitError(f"accuracy {accuracy} is one of {row.real}, not of {real}; leave one of both out")
        return row

    @property
    def description(self) -> str:
        return (
            f"Accuracy {self.accuracy}: where angles are taken in rows (of many states, or three and more of one) each "
            f"sine and cosine\nis within {self.bound:.0e} of the true one, below {2**self.limit_exponent} rad in size. "
            "Others are the C library's."
        )


SHORT_SINES: Mapping[str, ShortSines] = {
    row.accuracy: row
    for row in (
        ShortSines(
            accuracy="1e-10",
            real="double",
            bound=8e-12,
            limit_exponent=15,
            half_pi=1.5707963267948966,
            sine=(
                -0.16666666627998725,
                0.00833332823869236,
                -0.0001983904376548974,
                2.716013980798435e-06,
            ),
            cosine=(
                -0.499999999995451,
                0.04166666656208085,
                -0.0013888881078919053,
                2.4799041081799083e-05,
                -2.718010367936957e-07,
            ),
        ),
    )
}


FUNCTION_ULPS = 4.0  # what NumPy's vectorised sines are allowed


@dataclass(frozen=True)
class Real:
    """A binary floating-point type.

    Attributes:
        name: as C calls it.
        dtype: as NumPy calls it.
        suffix: of literals and of the functions of <math.h>.
        bits: of the significand.
        lowest: exponent of the smallest positive number.
        top: exponent of the first power of two that is too large.
        roundoff: largest error of one rounding, relative.
        tiniest: smallest number that has all its digits; below, some are lost by underflow.
        lanes: states of a block in the C that computes many: enough to hide what starting a loop costs, few enough for
            the nearest cache; of double-doubles two of the widest vectors, so that one hides the latency of the other.
        parts: how many numbers one is the sum of; all else is said of each of them.
        limit_exponent: angles below 2 to this in size have a sine; 0 where all have.
        lacks: operations that there are no functions of so many digits for: why, and what would work.
        ALLOWED: how many times the bound of an analysis results may be off, as that is of first order.
    """

    ALLOWED: ClassVar[float] = 2.0

    name: str
    dtype: str
    suffix: str
    bits: int
    lowest: int
    top: int
    roundoff: float
    tiniest: float
    lanes: int
    parts: int = 1
    limit_exponent: int = 0
    lacks: Mapping[Op, str] = field(default_factory=dict, hash=False)

    @property
    def function_error(self) -> float:
        """Largest error of a sine or another function, relative."""
        return 2 * FUNCTION_ULPS * self.roundoff

    def numbers(self, value: Fraction) -> tuple[float, ...]:
        """Return the number nearest to `value`, as those that it is the sum of; EmitError if it is too large."""
        return halves(value) if self.parts > 1 else (nearest(value, self),)

    def rounding(self, numbers: BigFloats | Midpoints, accuracy: str = "") -> RunningErrors:
        """Return the analysis of what rounding may leave in this type, and in sines of an accuracy, a key of them."""
        kind = RunningErrors.of_parts(self.parts)
        row = ShortSines.find(accuracy)
        return kind(numbers, self.roundoff, self.function_error, (row.bound if row else 0.0))


NO_FUNCTION = "its functions of 31 digits are sine, cosine and square root; take real type double"

REALS = {
    "double": Real("double", "float64", "", 53, -1074, 1024, 2.0**-53, 2.0**-1022, 64),
    "float": Real("float", "float32", "f", 24, -149, 128, 2.0**-24, 2.0**-126, 64),
    "dd": Real(
        "dd",
        "float64",
        "",
        53,
        -1074,
        1024,
        2.0**-102,
        2.0**-960,
        16,
        2,
        20,
        dict.fromkeys((Op.EXP, Op.LOG, Op.TANH, Op.ATAN2, Op.POW, Op.SELECT), NO_FUNCTION),
    ),
}

SINGLE = tuple(name for name, row in REALS.items() if row.parts == 1)
"""Types of which a number is one number, which most languages have."""


def find_real(name: str) -> Real:
    """Return the real type called `name`; EmitError if there is none."""
    if name not in REALS:
        raise EmitError(f"real type {name!r} is not known; {choice(name, REALS)}")
    return REALS[name]


def nearest(value: Fraction, real: Real) -> float:
    """Return the number of the type that is nearest to `value`, ties to even.

    Raises:
        EmitError: `value` is too large for the type.
    """
    if not value:
        return 0.0
    if real is REALS["double"] and abs(value) < 2**1023:
        return float(value)  # Python's own division is rounded correctly
    size = abs(value)
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    if size < Fraction(2) ** exponent:
        exponent -= 1
    unit = Fraction(2) ** max(exponent - real.bits + 1, real.lowest)
    rounded = round(value / unit) * unit
    if abs(rounded) >= 2**real.top:
        raise EmitError(f"a constant of about 2^{exponent} is too large for the real type {real.name}; change units")
    return float(rounded)


def halves(value: Fraction) -> tuple[float, float]:
    """Return the double-double nearest to `value` but for its last bit: the nearest double, and that of what is left.

    >>> halves(Fraction(1, 10))
    (0.1, -5.551115123125783e-18)

    Raises:
        EmitError: `value` is too large for a double.
    """
    high = nearest(value, REALS["double"])
    return high, nearest(value - Fraction(high), REALS["double"])


@lru_cache(maxsize=4096)
def digits(value: Fraction, real: Real) -> str:
    """Return the shortest decimal text that reads back as the number nearest to `value`; of a sum, one of each part."""
    if real.parts == 2:
        return ", ".join(map(repr, halves(value)))
    number = nearest(value, real)
    if real.name == "double":
        return repr(number)
    texts = (f"{number:.{count}g}" for count in range(1, 18))
    short = next(text for text in texts if _reads_as(text, number, real))
    return repr(float(short))


def _reads_as(text: str, number: float, real: Real) -> bool:
    """Tell whether `text` is read as `number`; near the largest number fewer digits may be too large."""
    try:
        return nearest(Fraction(text), real) == number
    except EmitError:
        return False
