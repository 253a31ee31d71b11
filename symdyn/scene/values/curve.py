"""Tables of numbers as functions: exact knots, and what stands between them.

With x_k ascending, h_k = x_(k+1) - x_k and u_k = max(x - x_k, 0), so that s_k = u_k - u_(k+1) runs from 0 to h_k inside
the k-th interval and stays there behind it:

    f(x) = y_0 + d_0 (x - x_0 - u_0) + Σ q_k(s_k) + d_n u_n        q_k(0) = 0, q_k(h_k) = y_(k+1) - y_k

Outside of the knots f goes on with the slope of the nearest one. q_k is linear, or Hermite's cubic of slopes d_k:

    linear    d_k is not asked for; f bends at every knot
    akima     d_k = (|m_(k+1) - m_k| m_(k-1) + |m_(k-1) - m_(k-2)| m_k) / (sum of both weights), of slopes m of chords
    cubic     the spline with two continuous derivatives whose third one is continuous at the second and the last but
              one knot, "not-a-knot"; d_k is rounded to 20 digits

A second argument goes over rows of values, linearly. All of it is max, sums and products, so that a table has
derivatives, proofs and code wherever formulas have them, and the places where max turns over are its knots.

References: Akima, A new method of interpolation and smooth curve fitting, Journal of the ACM 17 (1970); de Boor, A
practical guide to splines (2001), chapter IV.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from itertools import pairwise

from symdyn.graph import Expr, Graph, Op

Rows = tuple[tuple[Fraction | None, ...], ...]
"""Numbers of a table, None of an empty cell."""

Slopes = Callable[[Sequence[Fraction], Sequence[Fraction]], list[Fraction]]

MOST_KNOTS = 200
"""Of each argument: every one is some operations of code."""

MOST_VALUES = 1000

DIGITS = 10**20


def _chords(x: Sequence[Fraction], y: Sequence[Fraction]) -> list[Fraction]:
    return [(d - b) / (c - a) for (a, b), (c, d) in pairwise(zip(x, y, strict=True))]


def _akima(x: Sequence[Fraction], y: Sequence[Fraction]) -> list[Fraction]:
    """Return slopes at knots; two chords more at each end lie on parabolas."""
    m = _chords(x, y)
    if len(m) == 1:
        return [m[0], m[0]]
    m = [3 * m[0] - 2 * m[1], 2 * m[0] - m[1], *m, 2 * m[-1] - m[-2], 3 * m[-1] - 2 * m[-2]]
    found = []
    for a, b, c, d in zip(m, m[1:], m[2:], m[3:], strict=False):
        left, right = abs(d - c), abs(b - a)
        found.append((left * b + right * c) / (left + right) if left + right else (b + c) / 2)
    return found


def _cubic(x: Sequence[Fraction], y: Sequence[Fraction]) -> list[Fraction]:
    """Return slopes at knots, by elimination without rounding."""
    m, n = _chords(x, y), len(x)
    if n == 2:
        return [m[0], m[0]]
    h = [b - a for a, b in pairwise(x)]
    if n == 3:  # a parabola
        bend = (m[1] - m[0]) / (h[0] + h[1])
        return [m[0] - bend * h[0], m[0] + bend * h[0], m[1] + bend * h[1]]
    rows = [_end(h[0], h[1], m[0], m[1])]
    rows += [(h[k], 2 * (h[k - 1] + h[k]), h[k - 1], 3 * (h[k] * m[k - 1] + h[k - 1] * m[k])) for k in range(1, n - 1)]
    last = _end(h[-1], h[-2], m[-1], m[-2])
    rows.append((last[2], last[1], Fraction(0), last[3]))
    above: list[tuple[Fraction, Fraction]] = [(Fraction(0), Fraction(0))]
    for below, middle, over, right in rows:
        pivot = middle - below * above[-1][0]
        above.append((over / pivot, (right - below * above[-1][1]) / pivot))
    found = [Fraction(0)]
    for factor, rest in reversed(above[1:]):
        found.append(rest - factor * found[-1])
    return [Fraction(round(d * DIGITS), DIGITS) for d in found[:0:-1]]


def _end(h: Fraction, g: Fraction, m: Fraction, n: Fraction) -> tuple[Fraction, Fraction, Fraction, Fraction]:
    """Return the row of the first knot, with intervals h, g and chords m, n: d'' changes alike in both."""
    return Fraction(0), g, h + g, ((h + 2 * (h + g)) * g * m + h * h * n) / (h + g)


METHODS: Mapping[str, Slopes | None] = {"linear": None, "akima": _akima, "cubic": _cubic}


@dataclass(frozen=True)
class Curve:
    """A function of one argument or two, given by points.

    Attributes:
        name: of it in formulas.
        points: rows (x, y); of two arguments the first row is (None, x_1, x_2, ...), the others are (y, z_1, z_2, ...).
        method: a key of `METHODS`, along x.
    """

    name: str
    points: Rows
    method: str = "linear"

    @property
    def arguments(self) -> int:
        """How many arguments it takes."""
        return 2 if self.points and self.points[0][:1] == (None,) else 1

    def faults(self) -> Iterator[str]:
        """Yield what is wrong with the points."""
        grid = self.arguments > 1
        width = len(self.points[0]) if grid else 2
        ragged = next(
            (k for k, row in enumerate(self.points, 1) if len(row) != width or None in row[k == 1 and grid :]), 0
        )
        if ragged:
            yield f"row {ragged} has other than {width} numbers; write x, y, or a grid whose first cell is empty"
            return
        for what, knots in (("x", self._x), *((("y", self._y),) if grid else ())):
            bad = next((k for k, (a, b) in enumerate(pairwise(knots), 2) if a >= b), 0)
            if bad:
                yield f"{what} must ascend; the {bad}. is {float(knots[bad - 1]):g} behind {float(knots[bad - 2]):g}"
            if not 2 <= len(knots) <= MOST_KNOTS:
                yield f"has {len(knots)} knots of {what}; give 2 to {MOST_KNOTS}"
        if len(self.points) * width > MOST_VALUES:
            yield f"has {len(self.points) * width} numbers; {MOST_VALUES} are allowed"

    @property
    def _x(self) -> list[Fraction]:
        return [
            x for x in (self.points[0][1:] if self.arguments > 1 else [row[0] for row in self.points]) if x is not None
        ]

    @property
    def _y(self) -> list[Fraction]:
        return [row[0] for row in self.points[1:] if row[0] is not None]

    def at(self, args: Sequence[Fraction | float]) -> Fraction:
        """Return its value, exactly."""
        graph = Graph()
        found = self.body(graph, [graph.constant(Fraction(x)) for x in args]).value
        assert isinstance(found, Fraction), "constants fold"
        return found

    def body(self, graph: Graph, args: Sequence[Expr]) -> Expr:
        """Return the function of its arguments, nodes of a graph."""
        if self.arguments == 1:
            return self._along(args[0], self._x, [row[1] or Fraction(0) for row in self.points])
        rows = [self._along(args[0], self._x, [z or Fraction(0) for z in row[1:]]) for row in self.points[1:]]
        y = self._y
        slopes = [(b - a) / (q - p) for (a, b), (p, q) in zip(pairwise(rows), pairwise(y), strict=True)]
        return _summed(args[1], y, rows[0], slopes[0], slopes[-1], [(m,) for m in slopes])

    def _along(self, x: Expr, knots: Sequence[Fraction], values: Sequence[Fraction]) -> Expr:
        constant, make, m = x.graph.constant, METHODS[self.method], _chords(knots, values)
        pieces: list[tuple[Expr, ...]]
        if make is None:
            d, pieces = m, [(constant(chord),) for chord in m]
        else:
            d = make(knots, values)
            pieces = [
                (constant((a + b - 2 * chord) / h**2), constant((3 * chord - 2 * a - b) / h), constant(a))
                for chord, (a, b), h in zip(m, pairwise(d), [q - p for p, q in pairwise(knots)], strict=True)
            ]
        return _summed(x, knots, constant(values[0]), constant(d[0]), constant(d[-1]), pieces)


def _summed(
    x: Expr, knots: Sequence[Fraction], first: Expr, before: Expr, behind: Expr, pieces: Sequence[tuple[Expr, ...]]
) -> Expr:
    """Return the function of x that begins with a value: slopes before and behind, coefficients between, s's last."""
    graph = x.graph
    past = [graph.function(Op.SELECT, x - knot, x - knot, 0) for knot in knots]
    total = first + before * (x - knots[0] - past[0])
    for coefficients, (u, v) in zip(pieces, pairwise(past), strict=True):
        s, piece = u - v, graph.zero
        for one in coefficients:
            piece = (piece + one) * s
        total = total + piece
    return total + behind * past[-1]


def cells_of(text: str) -> Rows:
    """Return the numbers of a CSV file: cells between commas, semicolons or tabs; a line of words may stand on top.

    Raises:
        ValueError: with the line that holds something else.
    """
    rows: list[tuple[Fraction | None, ...]] = []
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1):
        mark = next((one for one in ";\t," if one in line), ",")
        if not line.strip() or line.startswith("#"):
            continue
        try:
            rows.append(tuple(cell_of(cell.strip()) for cell in line.split(mark)))
        except ValueError as error:
            if rows:
                raise ValueError(f"line {number}: {error}") from None
    return tuple(rows)


def cell_of(value: object) -> Fraction | None:
    """Return a number, exactly, None of an empty cell; ValueError of what is none."""
    if value == "":
        return None
    try:
        found = Decimal(repr(value) if isinstance(value, float) else str(value))
        if found.is_finite() and abs(found.adjusted()) < 300 and not isinstance(value, bool):
            return Fraction(found)
    except InvalidOperation:
        pass
    raise ValueError(f"{str(value)[:40]!r} is no number")
