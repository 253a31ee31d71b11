"""Tables of numbers as functions: exact knots, and what stands between them.

With x_k ascending, values y_k and slopes d_k, between two knots stands a straight line, or Hermite's cubic of both
values and slopes. Outside of the knots f goes on with the slope of the nearest one.

    linear    f bends at every knot
    akima     d_k = (|m_(k+1) - m_k| m_(k-1) + |m_(k-1) - m_(k-2)| m_k) / (sum of both weights), of slopes m of chords
    cubic     the spline with two continuous derivatives whose third one is continuous at the second and the last but
              one knot, "not-a-knot"; d_k is rounded to 20 digits

Of two arguments the values z_j(x) of all rows y_j are such functions, and so are A_j and B_j, which are 1 in value or
in slope at y_j and 0 in all else:

    f(x, y) = Σ z_j(x) A_j(y) + Σ d_j(x) B_j(y)

with d_j(x) between the slopes that the points of each column have along y, by the same method; a cubic one is the
tensor product of splines. Straight lines need no slopes.

References: Akima, A new method of interpolation and smooth curve fitting, Journal of the ACM 17 (1970); de Boor, A
practical guide to splines (2001), chapters IV and XVII.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from itertools import pairwise

from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Piecewise
from symdyn.unlocked import cached_property

Rows = tuple[tuple[Fraction | None, ...], ...]
"""Numbers of a table, None of an empty cell."""

Slopes = Callable[[Sequence[Fraction], Sequence[Fraction]], list[Fraction]]

MOST_KNOTS = 200
"""Of each argument: every one is some operations of code."""

MOST_VALUES = 1000

DIGITS = 10**20

_0, _1 = Fraction(0), Fraction(1)


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
        method: a key of `METHODS`.
    """

    name: str
    points: Rows
    method: str = "linear"

    @property
    def arguments(self) -> int:
        """How many arguments it takes."""
        return 2 if self.points and self.points[0][:1] == (None,) else 1

    def faults(self) -> Iterator[str]:
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
                told = f"the {bad}. is {float(knots[bad - 1]):g} behind {float(knots[bad - 2]):g}"
                yield f"{what} must ascend; {told}; give them in order, each once"
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
        graph = Graph()
        found = self.body(graph, [graph.constant(Fraction(x)) for x in args]).value
        assert isinstance(found, Fraction), "constants fold"
        return found

    def body(self, graph: Graph, args: Sequence[Expr]) -> Expr:
        """Return the function of its arguments, nodes of a graph."""
        found = [[graph.lookup(one, x) for one, x in zip(part, args, strict=True)] for part in self._parts]
        return graph.total(graph.mul(*two) if len(two) > 1 else two[0] for two in found)

    @cached_property
    def _parts(self) -> tuple[tuple[Piecewise, ...], ...]:
        """Products of functions of one argument each, whose sum it is."""
        x, y, make = self._x, self._y, METHODS[self.method]
        if self.arguments == 1:
            return ((self._through("", x, [row[1] or _0 for row in self.points]),),)
        rows, zero = [[z or _0 for z in row[1:]] for row in self.points[1:]], [_0] * len(y)
        unit = [[_1 if k == j else _0 for k in range(len(y))] for j in range(len(y))]
        if make is None:
            return tuple(
                (self._through(f"_{j}", x, row), self._through(f"_y{j}", y, unit[j])) for j, row in enumerate(rows)
            )
        slopes = [*zip(*(make(y, column) for column in zip(*rows, strict=True)), strict=True)]
        found = []
        for j, (row, slope) in enumerate(zip(rows, slopes, strict=True)):
            found.append((self._through(f"_{j}", x, row), self._through(f"_y{j}", y, unit[j], zero)))
            found.append((self._through(f"_{j}y", x, slope), self._through(f"_yy{j}", y, zero, unit[j])))
        return tuple(found)

    def _through(
        self, row: str, x: Sequence[Fraction], y: Sequence[Fraction], slopes: Sequence[Fraction] = ()
    ) -> Piecewise:
        """Return the function through points, of slopes that are given or of those of the method."""
        make, m = METHODS[self.method], _chords(x, y)
        inner: list[tuple[Fraction, ...]]
        if make is None:
            inner, before, behind = [*zip(y, m, strict=False)], m[0], m[-1]
        else:
            d = slopes or make(x, y)
            before, behind = d[0], d[-1]
            inner = [
                (value, a, (3 * chord - 2 * a - b) / h, (a + b - 2 * chord) / h**2)
                for value, chord, (a, b), h in zip(y, m, pairwise(d), [q - p for p, q in pairwise(x)], strict=False)
            ]
        rest = (_0,) * (len(inner[0]) - 2)
        ends = (y[0], before, *rest), (y[-1], behind, *rest)
        return Piecewise(f"{self.name}{row}", tuple(x), (ends[0], *inner, ends[1]))


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
