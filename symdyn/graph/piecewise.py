"""Functions of one argument that are polynomials between knots: tables of numbers, as one operation of a graph.

With x_k ascending and u_k = max(x - x_k, 0), s_k = u_k - u_(k+1) runs from 0 to x_(k+1) - x_k inside the k-th interval
and stays there behind it. A function f that is continuous is made of other operations by

    f(x) = f(x_0) + f'(x_0 - 0) (x - x_0 - u_0) + Σ q_k(s_k) + f'(x_n + 0) u_n        q_k(s) = f(x_k + s) - f(x_k)

and its derivatives are those of this. Algebras that have no value of their own for it take that one, so that all that
is known of max is known of a table. At a knot a piece ends: there f has the value, and f' the slope, of below.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import lcm

from symdyn.frozen import dataclass, replace
from symdyn.graph.differentiate import Algebra, T, evaluate, reachable, substitute, tangents
from symdyn.graph.expression import Expr, Graph
from symdyn.graph.ops import Op
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Piecewise:
    """A continuous function, or a derivative of one.

    Attributes:
        name: of the function.
        knots: ascending.
        pieces: of the function; the k-th, of n + 1, is a polynomial in x less the knot below it, the first in x less
            the first knot, from the constant upwards. The first and the last are of degree 1.
        order: how often it is differentiated.
    """

    name: str
    knots: tuple[Fraction, ...]
    pieces: tuple[tuple[Fraction, ...], ...]
    order: int = 0

    @cached_property
    def _hash(self) -> int:  # of numbers alone: that of a text is another one in another process
        return hash((self.knots, self.pieces, self.order))

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def rows(self) -> tuple[tuple[Fraction, ...], ...]:
        """The pieces, differentiated; coefficients from the constant upwards, as many in each."""
        found = self.pieces
        for _ in range(self.order):
            found = tuple(tuple(k * c for k, c in enumerate(row))[1:] or (Fraction(0),) for row in found)
        return found

    @cached_property
    def jumps(self) -> bool:
        ends = (self.at(knot) for knot in self.knots)
        return any(end != row[0] for end, row in zip(ends, self.rows[1:], strict=True))

    @property
    def numbers(self) -> tuple[Fraction, ...]:
        """Knots, then rows, those of one piece after those of another: what code looks up."""
        return (*self.knots, *(c for row in self.rows for c in row))

    @cached_property
    def denominator(self) -> int:
        """What makes whole numbers of all of its numbers."""
        return lcm(*(c.denominator for row in (self.knots, *self.pieces) for c in row))

    def printed(self, number: Callable[[Fraction], Fraction]) -> Piecewise:
        """Return it as code has it: numbers without a name, each as it is rounded."""
        return Piecewise("", tuple(map(number, self.knots)), tuple(tuple(number(c) for c in row) for row in self.rows))

    @property
    def derivative(self) -> Piecewise:
        """The derivative; between knots where it jumps."""
        return replace(self, order=self.order + 1)

    def at(self, x: Fraction) -> Fraction:
        k = bisect_left(self.knots, x)
        h, total = x - self.knots[max(k - 1, 0)], Fraction(0)
        for c in reversed(self.rows[k]):
            total = total * h + c
        return total

    def over(self, algebra: Algebra[T], x: T) -> T:
        """Return its value over an algebra, by other operations."""
        symbol, body = _made(self)
        return evaluate([body], algebra, {symbol: x})[0]

    def opened(self, x: Expr) -> Expr:
        """Return it by other operations, on the graph of x."""
        symbol, body = _made(self)
        return substitute([body], {symbol: x}, x.graph)[0]

    @staticmethod
    def all_opened(outputs: Sequence[Expr], graph: Graph) -> list[Expr]:
        """Return nodes on another graph, every table by other operations."""
        known: dict[Expr, Expr] = {}
        for node in reachable(outputs):
            args = [known[arg] for arg in node.args]
            known[node] = node.value.opened(args[0]) if isinstance(node.value, Piecewise) else graph.copy(node, args)
        return [known[node] for node in outputs]


@lru_cache(maxsize=256)
def _made(table: Piecewise) -> tuple[Expr, Expr]:
    """Return x, and the function of it, on a graph of their own."""
    graph = Graph()
    x, constant = graph.symbol("x"), graph.constant
    if table.order:
        before = replace(table, order=table.order - 1)
        return x, tangents([before.opened(x)], {x: graph.one})[0]
    first, *inner, last = table.pieces
    past = [graph.function(Op.SELECT, x - knot, x - knot, 0) for knot in table.knots]
    total = constant(first[0]) + constant(first[1]) * (x - table.knots[0] - past[0])
    for row, (u, v) in zip(inner, pairwise(past), strict=True):
        s, piece = u - v, graph.zero
        for c in reversed(row[1:]):
            piece = (piece + constant(c)) * s
        total = total + piece
    return x, total + constant(last[1]) * past[-1]
