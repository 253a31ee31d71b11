"""The operations a graph is made of, what each one needs, and the identities of functions.

Everything that depends on an operation stands in a table keyed by `Op`, a row an operation: its arity here, its partial
derivatives in `differentiate.py`, its value in each algebra, its spelling in each target. A test holds the tables
complete. TABLE alone is another function at every node, that of `piecewise.py`, made of other operations where an
algebra or a target has no more for it.

Identities are applied when a node is born: exact sines, parities, roots. An angle is read as a *linear form*: a
rational multiple of π plus rational multiples of other nodes. Every algebra that is exact about angles reads it the
same way, so the decomposition stands here once.
"""

from __future__ import annotations

from enum import IntEnum
from fractions import Fraction
from math import isqrt
from typing import TYPE_CHECKING

from symdyn.frozen import dataclass

if TYPE_CHECKING:
    from symdyn.graph.expression import Expr, Graph


class Op(IntEnum):
    """What a node computes.

    Loops over nodes have names of their own for members: Python 3.11 takes 100 ns to look one up in its class.
    """

    CONSTANT = 0  # an exact fraction
    PI = 1  # the named constant
    SYMBOL = 2  # a named input
    ADD = 3
    SUB = 4
    MUL = 5
    DIV = 6
    NEG = 7
    SIN = 8
    COS = 9
    SQRT = 10
    EXP = 11
    LOG = 12
    TANH = 13
    ABS = 14
    SIGN = 15
    ATAN2 = 16
    POW = 17  # x to a real exponent
    SELECT = 18  # of (c, a, b): a where c > 0, b where c ≤ 0
    TABLE = 19  # a function of one argument, a polynomial between knots; it stands in the node's value

    @property
    def arity(self) -> int:
        """How many operands it takes."""
        return ARITY[self]

    @property
    def is_function(self) -> bool:
        """Whether it is no field arithmetic; an algebra answers it in its `function` method."""
        return self >= Op.SIN

    @property
    def turns(self) -> bool:
        """Whether it bends or jumps, where `Expr.guards` pass zero."""
        return self in (Op.ABS, Op.SIGN, Op.SELECT, Op.TABLE)

    __hash__ = int.__hash__  # an enumeration's own is a Python function, and tables are read at every node


CONSTANT, PI, SYMBOL, ADD, SUB, MUL, DIV, NEG = list(Op)[:8]
"""Names for loops over nodes of this package."""

ELEMENTARY = (Op.SIN, Op.COS, Op.SQRT, Op.EXP, Op.LOG, Op.TANH)
"""Functions of one number that all libraries call by the same word."""

ARITY: dict[Op, int] = {
    **dict.fromkeys((CONSTANT, PI, SYMBOL), 0),
    **dict.fromkeys((NEG, *ELEMENTARY, Op.ABS, Op.SIGN, Op.TABLE), 1),
    **dict.fromkeys((ADD, SUB, MUL, DIV, Op.ATAN2, Op.POW), 2),
    Op.SELECT: 3,
}

FUNCTIONS: frozenset[Op] = frozenset(op for op in Op if Op.SIN <= op < Op.TABLE)
"""Operations that are not field arithmetic and are the same at every node; tables are made by `Graph.lookup`."""


@dataclass(frozen=True)
class LinearForm:
    """An angle as turns + constant + Σ coefficient · atom."""

    turns: Fraction  # multiple of π
    constant: Fraction  # rational part, rad
    terms: tuple[tuple[Expr, Fraction], ...]  # (node, coefficient) by ascending node index; no coefficient is zero


def linear_form(angle: Expr) -> LinearForm:
    """Return `angle` as a linear form; products and functions are atoms."""
    turns = constant = Fraction(0)
    terms: dict[Expr, Fraction] = {}
    stack = [(angle, Fraction(1))]
    while stack:
        node, factor = stack.pop()
        if node.op is Op.CONSTANT:
            constant += factor * node.value  # type: ignore[operator]
        elif node.op is Op.PI:
            turns += factor
        elif node.op is Op.ADD:
            stack += [(node.args[0], factor), (node.args[1], factor)]
        elif node.op is Op.SUB:
            stack += [(node.args[0], factor), (node.args[1], -factor)]
        elif node.op is Op.NEG:
            stack.append((node.args[0], -factor))
        elif node.op is Op.MUL and node.args[0].op is Op.CONSTANT:
            stack.append((node.args[1], factor * node.args[0].value))  # type: ignore[operator]
        else:
            terms[node] = terms.get(node, Fraction(0)) + factor
    ordered = sorted((item for item in terms.items() if item[1]), key=lambda item: item[0].index)
    return LinearForm(turns, constant, tuple(ordered))


def simplify_function(graph: Graph, op: Op, args: tuple[Expr, ...]) -> Expr | None:
    """Return a simpler node for op(args), or None when the function stands as it is."""
    x = args[0]
    if op in (Op.SIN, Op.COS):
        return _circular(graph, op, x)
    if op is Op.SQRT and x.op is Op.CONSTANT:
        return _root(graph, x)
    if op in (Op.ABS, Op.SIGN) and x.op is Op.CONSTANT:
        value = x.value
        assert isinstance(value, Fraction)
        return graph.constant(abs(value) if op is Op.ABS else (value > 0) - (value < 0))
    if op is Op.ABS and x.op is Op.NEG:
        return graph.function(Op.ABS, x.args[0])
    if op in (Op.TANH, Op.SIGN) and x.op is Op.NEG:
        return graph.neg(graph.function(op, x.args[0]))
    if op is Op.POW:
        return _power(graph, x, args[1])
    if op is Op.SELECT and args[1] is args[2]:
        return args[1]
    if op is Op.SELECT and x.op is Op.CONSTANT:
        return args[1] if x.value > 0 else args[2]  # type: ignore[operator]
    if op is Op.TANH and x is graph.zero:
        return graph.zero
    if op is Op.EXP and x is graph.zero:
        return graph.one
    if op is Op.LOG and x is graph.one:
        return graph.zero
    return None


def _power(graph: Graph, x: Expr, exponent: Expr) -> Expr | None:
    """Return x to a constant exponent that is an integer or a half of one; None for others."""
    if x is graph.one:
        return x
    if exponent.op is not Op.CONSTANT:
        return None
    value = exponent.value
    assert isinstance(value, Fraction)
    if value.denominator == 1 and abs(value) <= graph.LARGEST_POWER:
        return graph.power(x, int(value))
    if abs(value) == Fraction(1, 2):
        root = graph.sqrt(x)
        return root if value > 0 else graph.div(graph.one, root)
    return None


def _circular(graph: Graph, op: Op, x: Expr) -> Expr | None:
    """Return sin or cos of x in lowest terms: leading sign positive, multiples of π/2 gone; None if x is so already."""
    if x.op is Op.SYMBOL:
        return None
    form = linear_form(x)
    turns = form.turns % 2
    if not form.terms and not form.constant:
        return _exact(graph, op, turns)
    quarter = turns // Fraction(1, 2)
    rest = turns - Fraction(quarter, 2)
    angle = graph.total(
        [graph.constant(form.constant), graph.mul(graph.constant(rest), graph.pi)]
        + [graph.mul(graph.constant(coefficient), node) for node, coefficient in form.terms]
    )
    leading = form.terms[0][1] if form.terms else form.constant
    flipped = leading < 0
    if flipped:
        angle = graph.neg(angle)
    if quarter == 0 and not flipped and angle is x:
        return None
    s, c = graph.function(Op.SIN, angle), graph.function(Op.COS, angle)
    s = graph.neg(s) if flipped else s
    sines = (s, c, graph.neg(s), graph.neg(c))  # sin(x + k π/2)
    return sines[(quarter + (1 if op is Op.COS else 0)) % 4]


def _exact(graph: Graph, op: Op, turns: Fraction) -> Expr | None:
    """Return sin or cos of turns·π: exact for multiples of π/4 and π/6, else reduced to the first octant."""
    if op is Op.COS:
        turns = (turns + Fraction(1, 2)) % 2
    sign = 1 if turns < 1 else -1
    turns %= 1
    turns = min(turns, 1 - turns)  # sin(π - x) = sin x, now 0 .. 1/2
    table = {
        Fraction(0): graph.zero,
        Fraction(1, 6): graph.constant(Fraction(1, 2)),
        Fraction(1, 2): graph.one,
    }
    if turns in (Fraction(1, 4), Fraction(1, 3)):
        table[turns] = graph.constant(Fraction(1, 2)) * graph.sqrt(2 if turns == Fraction(1, 4) else 3)
    value = table.get(turns)
    if value is None:  # no exact form: as sine or cosine of under π/4
        op, reduced = (Op.SIN, turns) if turns < Fraction(1, 4) else (Op.COS, Fraction(1, 2) - turns)
        value = graph.node(op, graph.mul(graph.constant(reduced), graph.pi))
    return value if sign > 0 else graph.neg(value)


def _root(graph: Graph, x: Expr) -> Expr | None:
    """Return sqrt(p/q) as k sqrt(n) with n free of small squares; None if x is so already or negative."""
    value = x.value
    assert isinstance(value, Fraction)
    if value < 0:
        return None
    outside, inside = 1, value.numerator * value.denominator
    root = isqrt(inside)
    if root * root == inside:
        return graph.constant(Fraction(root, value.denominator))
    for prime in SMALL_PRIMES:
        while inside % (prime * prime) == 0:
            inside //= prime * prime
            outside *= prime
    factor = Fraction(outside, value.denominator)
    if factor == 1:
        return None
    return graph.mul(graph.constant(factor), graph.sqrt(inside))


SMALL_PRIMES = tuple(n for n in range(2, 1000) if all(n % d for d in range(2, isqrt(n) + 1)))
"""Trial divisors: enough for every radical that a direction or an angle of a robot file gives."""
