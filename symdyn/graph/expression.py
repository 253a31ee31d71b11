"""Hash-consed exact expressions: the one graph that everything else reads.

A `Graph` is an append-only list of nodes; an argument always comes before the node that uses it, so evaluation and
differentiation are plain loops and nothing recurses. Equal subexpressions are one object, so `is` compares them and
common-subexpression elimination never has to run. Constants are exact fractions or π; no float ever enters.

Identities applied at birth, cheap and always true:

    x + 0 = x    x - x = 0    x + x = 2 x    0 x = 0    1 x = x    x / x = 1    a (b x) = (a b) x    (a, b constant)
    -(-x) = x    a + (-b) = a - b    (-a) b = -(a b)    b - a = -(a - b) when a - b exists
    sin(-x) = -sin x    cos(-x) = cos x    sin(x + π/2) = cos x    exact sines of the usual multiples of π
    sqrt(x) sqrt(x) = x    sqrt(8) = 2 sqrt(2)

Nothing that grows a graph is garbage before it is done, but the collector of cycles walks all nodes again whenever they
have become a quarter more: for a chain of 5000 bodies that is half of the time. `growing` lets it rest; reference
counts work on as ever.
"""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Union

from symdyn.graph.ops import (
    ADD,
    CONSTANT,
    DIV,
    FUNCTIONS,
    MUL,
    NEG,
    PI,
    SUB,
    SYMBOL,
    LinearForm,
    Op,
    linear_form,
    simplify_function,
)

if TYPE_CHECKING:
    from symdyn.graph.piecewise import Piecewise

Scalar = Union["Expr", int, Fraction]
Key = Union[Fraction, str, tuple["Expr", ...], tuple[int, int], tuple["Piecewise", "Expr"]]
Value = Union[Fraction, str, "Piecewise", None]


class Expr:
    """One node of a graph. Made by the graph only; compared by identity."""

    __slots__ = ("args", "graph", "index", "op", "value")

    def __init__(self, graph: Graph, op: Op, args: tuple[Expr, ...], value: Value) -> None:
        """Append the node to the graph; `value` is the fraction of a constant, the name of a symbol, or a table."""
        self.graph = graph
        self.index = len(graph.nodes)
        self.op = op
        self.args = args
        self.value = value
        graph.nodes.append(self)

    def __add__(self, other: Scalar) -> Expr:
        return self.graph.add(self, other if type(other) is Expr else self.graph.lift(other))

    def __radd__(self, other: Scalar) -> Expr:
        return self.graph.add(self.graph.lift(other), self)

    def __sub__(self, other: Scalar) -> Expr:
        return self.graph.sub(self, other if type(other) is Expr else self.graph.lift(other))

    def __rsub__(self, other: Scalar) -> Expr:
        return self.graph.sub(self.graph.lift(other), self)

    def __mul__(self, other: Scalar) -> Expr:
        return self.graph.mul(self, other if type(other) is Expr else self.graph.lift(other))

    def __rmul__(self, other: Scalar) -> Expr:
        return self.graph.mul(self.graph.lift(other), self)

    def __truediv__(self, other: Scalar) -> Expr:
        return self.graph.div(self, self.graph.lift(other))

    def __rtruediv__(self, other: Scalar) -> Expr:
        return self.graph.div(self.graph.lift(other), self)

    def __neg__(self) -> Expr:
        return self.graph.neg(self)

    def __pow__(self, exponent: int) -> Expr:
        return self.graph.power(self, exponent)

    def linear_form(self) -> LinearForm:
        """Return the node as a linear form, as an angle is read; products and functions are atoms."""
        return linear_form(self)

    @property
    def jumps(self) -> bool:
        """Whether the node jumps where its first operand is zero; abs, max and min bend there."""
        if self.op is not Op.SELECT:
            return self.op is Op.SIGN or (self.op is Op.TABLE and self.value.jumps)  # type: ignore[union-attr]
        guard, a, b = self.args
        step = self.graph.sub(a, b)
        return guard is not step and guard is not self.graph.neg(step)

    @property
    def guards(self) -> tuple[Expr, ...]:
        """What passes zero where the node bends or jumps."""
        if self.op is Op.TABLE:
            return tuple(self.args[0] - knot for knot in self.value.knots)  # type: ignore[union-attr]
        return self.args[:1] if self.op.turns else ()

    def __repr__(self) -> str:
        if self.op in (Op.CONSTANT, Op.SYMBOL):
            return str(self.value)
        if self.op is Op.PI:
            return "pi"
        return f"{self.op.name.lower()}({', '.join(f'#{a.index}' for a in self.args)})"

    @property
    def is_zero(self) -> bool:
        """Whether the node is the constant 0 (structurally; see `verify` for zero as a function)."""
        return self is self.graph.zero


class Graph:
    """An append-only list of hash-consed nodes.

    >>> graph = Graph()
    >>> q = graph.symbol("q")
    >>> graph.sin(q + graph.pi / 2) is graph.cos(q)
    True
    >>> graph.cos(graph.pi / 3)
    1/2
    """

    LARGEST_POWER = 64
    """Of integers that powers are multiplied out to."""

    def __init__(self) -> None:
        """Make a graph that holds only 0 and 1."""
        self.nodes: list[Expr] = []
        self.found: dict[str, dict[Any, Any]] = {}  # about nodes, by topic, so that no one looks twice
        self.reached: tuple[tuple[Expr, ...], tuple[Expr, ...]] = ((), ())  # outputs and what they need, asked last
        self._tables: tuple[dict[Key, Expr], ...] = tuple({} for _ in Op)
        self.zero = self.constant(Fraction(0))
        self.one = self.constant(Fraction(1))

    # Leaves

    def constant(self, value: Fraction | int) -> Expr:
        """Return the node of an exact constant."""
        key = (value.numerator, value.denominator)
        found = self._tables[CONSTANT].get(key)
        return found or self._append(key, CONSTANT, (), value if type(value) is Fraction else Fraction(value))

    def symbol(self, name: str) -> Expr:
        """Return the node of a named input."""
        return self._tables[SYMBOL].get(name) or self._append(name, SYMBOL, (), name)

    def names(self, name: str) -> bool:
        """Tell whether any node is the symbol of this name."""
        return name in self._tables[SYMBOL]

    @property
    def pi(self) -> Expr:
        """The named constant π."""
        return self.node(PI)

    def lift(self, value: Scalar) -> Expr:
        """Return `value` as a node of this graph; floats are refused, since their digits are not exact."""
        if type(value) is Expr:
            assert value.graph is self, "an expression of another graph was mixed in"
            return value
        if isinstance(value, (int, Fraction)):
            return self.constant(value)
        raise TypeError(f"{value!r} is a {type(value).__name__}; give an int, a Fraction or an Expr")

    # Field arithmetic

    def add(self, a: Expr, b: Expr) -> Expr:
        if a is self.zero:
            return b
        if b is self.zero:
            return a
        if b.op is NEG:
            return self.sub(a, b.args[0])
        if a.op is NEG:
            return self.sub(b, a.args[0])
        if a is b:
            return self.mul(self.constant(2), a)
        if b.op is CONSTANT:
            if a.op is CONSTANT:
                return self.constant(_fraction(a) + _fraction(b))
            if _fraction(b).numerator < 0:
                return self.sub(a, self.neg(b))
        elif a.op is CONSTANT and _fraction(a).numerator < 0:
            return self.sub(b, self.neg(a))
        if a.index > b.index:
            a, b = b, a
        return self.node(ADD, a, b)

    def sub(self, a: Expr, b: Expr) -> Expr:
        if b is self.zero:
            return a
        if a is self.zero:
            return self.neg(b)
        if a is b:
            return self.zero
        if b.op is NEG:
            return self.add(a, b.args[0])
        if a.op is NEG:
            return self.neg(self.add(a.args[0], b))
        if b.op is CONSTANT:
            if a.op is CONSTANT:
                return self.constant(_fraction(a) - _fraction(b))
            if _fraction(b).numerator < 0:
                return self.add(a, self.neg(b))
        elif a.op is CONSTANT and _fraction(a).numerator < 0:
            return self.neg(self.add(self.neg(a), b))
        args, table = (a, b), self._tables[SUB]
        found = table.get(args)
        if found is not None:
            return found
        reverse = table.get((b, a))
        if reverse is not None:
            return self.neg(reverse)
        return self._append(args, SUB, args, None)

    def mul(self, a: Expr, b: Expr) -> Expr:
        if a is self.zero or b is self.zero:
            return self.zero
        if a is self.one:
            return b
        if b is self.one:
            return a
        if a.op is NEG:
            return self.neg(self.mul(a.args[0], b))
        if b.op is NEG:
            return self.neg(self.mul(a, b.args[0]))
        if b.op is CONSTANT:
            a, b = b, a
        if a.op is CONSTANT:
            return self._scale(a, b)
        if a is b and a.op is Op.SQRT:
            return a.args[0]
        if a.index > b.index:
            a, b = b, a
        return self.node(MUL, a, b)

    def _scale(self, constant: Expr, x: Expr) -> Expr:
        """Return constant x, the sign outside and one constant at most inside."""
        factor = _fraction(constant)
        if x.op is CONSTANT:
            return self.constant(factor * _fraction(x))
        if x.op is MUL and x.args[0].op is CONSTANT:
            return self.mul(self.constant(factor * _fraction(x.args[0])), x.args[1])
        if factor.numerator < 0:
            return self.neg(self.mul(self.constant(-factor), x))
        return self.node(MUL, constant, x)

    def div(self, a: Expr, b: Expr) -> Expr:
        """Return a / b; a constant zero below raises ZeroDivisionError."""
        if b.op is CONSTANT:
            return self.mul(self.constant(1 / _fraction(b)), a)
        if a is self.zero:
            return a
        if a is b:
            return self.one
        if a.op is NEG:
            return self.neg(self.div(a.args[0], b))
        if b.op is NEG:
            return self.neg(self.div(a, b.args[0]))
        return self.node(DIV, a, b)

    def neg(self, a: Expr) -> Expr:
        if a.op is NEG:
            return a.args[0]
        if a.op is CONSTANT:
            return self.constant(-_fraction(a))
        return self.node(NEG, a)

    def power(self, base: Expr, exponent: int) -> Expr:
        """Return base to an integer power, by squaring."""
        if exponent < 0:
            return self.div(self.one, self.power(base, -exponent))
        result, square = self.one, base
        while exponent:
            if exponent & 1:
                result = self.mul(result, square)
            exponent >>= 1
            if exponent:
                square = self.mul(square, square)
        return result

    # Functions

    def function(self, op: Op, *args: Scalar) -> Expr:
        """Return op(args) for any operation of `FUNCTIONS`."""
        assert op in FUNCTIONS, f"{op.name} is arithmetic; use the operators"
        nodes = tuple(self.lift(arg) for arg in args)
        simpler = simplify_function(self, op, nodes)
        if simpler is not None:
            return simpler
        return self.node(op, *nodes)

    def sin(self, x: Scalar) -> Expr:
        """Return sin x; x in rad."""
        return self.function(Op.SIN, x)

    def cos(self, x: Scalar) -> Expr:
        """Return cos x; x in rad."""
        return self.function(Op.COS, x)

    def sqrt(self, x: Scalar) -> Expr:
        """Return the non-negative square root of x."""
        return self.function(Op.SQRT, x)

    def total(self, terms: Iterable[Expr]) -> Expr:
        """Return the sum of `terms`, 0 if there are none."""
        result = self.zero
        for term in terms:
            result = self.add(result, term)
        return result

    def dot(self, a: Iterable[Expr], b: Iterable[Expr]) -> Expr:
        """Return the sum of products a_i b_i of as many."""
        return self.total(x * y for x, y in zip(a, b, strict=True))

    def table(self, name: str, body: Expr, args: tuple[Expr, ...]) -> Expr:
        """Return a function's node, which is read by its name and arguments, not by what it is made of."""
        self.found.setdefault("tables", {})[body] = (name, args)
        return body

    def lookup(self, table: Piecewise, x: Expr) -> Expr:
        """Return a function that is given by points, of x; a number where it is one."""
        if x.op is CONSTANT:
            return self.constant(table.at(_fraction(x)))
        if len(table.rows[0]) == 1 and len({*table.rows}) == 1:
            return self.constant(table.rows[0][0])
        key = (table, x)
        return self._tables[Op.TABLE].get(key) or self._append(key, Op.TABLE, (x,), table)

    def copy(self, node: Expr, args: Sequence[Expr]) -> Expr:
        """Return the operation of a node of this graph or another with other operands; it simplifies as at birth."""
        op = node.op
        if op is MUL:
            return self.mul(*args)
        if op is ADD:
            return self.add(*args)
        if op is SUB:
            return self.sub(*args)
        if op is NEG:
            return self.neg(*args)
        if op is DIV:
            return self.div(*args)
        if op is CONSTANT:
            return self.constant(node.value)  # type: ignore[arg-type]
        if op is SYMBOL:
            return self.symbol(str(node.value))
        if op is Op.TABLE:
            return self.lookup(node.value, args[0])  # type: ignore[arg-type]
        return self.pi if op is PI else self.function(op, *args)

    def node(self, op: Op, *args: Expr) -> Expr:
        """Return the node op(args) as it stands, without any identity applied."""
        return self._tables[op].get(args) or self._append(args, op, args, None)

    def _append(self, key: Key, op: Op, args: tuple[Expr, ...], value: Value) -> Expr:
        node = Expr(self, op, args, value)
        self._tables[op][key] = node
        return node


def _fraction(node: Expr) -> Fraction:
    value = node.value
    assert type(value) is Fraction, "only a constant has a fraction"
    return value


@contextmanager
def growing() -> Iterator[None]:
    """Rest the collector inside a `with`, or as a decorator inside a function; it goes on as it was, errors or not."""
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
