"""Sweeps over a table of joints: what they do at a joint, and what that comes to over all rows.

A sweep is a pass out to the tips or back. Its steps are expressions of the numbers of a row, one set for each kind of
row. C prints them as a loop, and `over_table` puts the numbers of a table into them: what is proved of these
expressions is proved of that loop. A sweep back may do something to each pair of a joint and one that it carries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache
from operator import add, attrgetter
from typing import ClassVar, TypeVar

from symdyn.dynamics.recursive.joint_table import JointTable, RowKind, kinds_of, names_of
from symdyn.frozen import dataclass
from symdyn.graph import Algebra, Expr, Graph, Op, reachable, repeated, substitute


@dataclass(frozen=True)
class Pairs:
    """What a sweep back does for each pair of a joint and one that it carries; the result has three blocks of columns.

    Attributes:
        starts: what goes along from a joint towards the ground, at the joint.
        own: entries of the joint and itself, by positions, rates, accelerations.
        goes: what that becomes at the parent, of a turn and of a slide, of `carried0`, ..., of what the joint keeps and
            of `above0`, ..., which its parent does.
        found: entries of the parent, a turn, then a slide, and the one carried, in the order of `BOTH_WAYS`.
        keeps, kept: how symbols begin of what a joint keeps, and how many.
        solved: whether blocks x, y, M become -M⁻¹ x, -M⁻¹ y, M⁻¹.
    """

    starts: tuple[Expr, ...]
    own: tuple[Expr, Expr, Expr]
    goes: tuple[Expr, ...]
    found: tuple[tuple[Expr, ...], tuple[Expr, ...]]
    keeps: str
    kept: int
    solved: bool = False

    CARRIED: ClassVar[str] = "carried"
    ABOVE: ClassVar[str] = "above"
    BOTH_WAYS: ClassVar = ((True, 2), (True, 1), (True, 0), (False, 1), (False, 0))
    """Of each entry whether it is in the row of the joint and the column of one it carries, or not, and the block.

    Blocks are by positions, rates and accelerations; the last is symmetric.
    """

    def of(self, slides: bool) -> tuple[Expr, ...]:
        """Return all of a pair whose parent slides or turns."""
        return (*self.goes, *self.found[slides])


@dataclass(frozen=True)
class Sweep:
    """What one sweep does at a joint of a kind: expressions of symbols on one graph.

    Attributes:
        name: of the sweep.
        takes: how symbols begin of what the joint before hands on, or all behind it together: "motion" of motion0 ..
        handed: what is handed on, as many.
        inward: whether it goes from the tips to the ground.
        ground: where the acceleration of the ground begins among the numbers of a motion that it starts with; none of
            these is another than zero, and all are if it has no place.
        keeps: how symbols begin by which a later sweep reads what this one keeps.
        kept: what it keeps, in place of what others before it kept.
        result: the entry of the result, where it finds that.
        ones: places of a motion that the ground has a one in.
        pairs: what it does for pairs of joints, going back.
        finds: the argument that later sweeps read what it finds as, which then is no entry of the result.
    """

    name: str
    takes: str
    handed: tuple[Expr, ...]
    inward: bool = False
    ground: int | None = None
    keeps: str = ""
    kept: tuple[Expr, ...] = ()
    result: Expr | None = None
    ones: tuple[int, ...] = ()
    pairs: Pairs | None = None
    finds: str = ""

    @property
    def results(self) -> tuple[Expr, ...]:
        pairs = (*self.pairs.starts, *self.pairs.own) if self.pairs else ()
        return (*self.handed, *self.kept, *pairs, *([] if self.result is None else [self.result]))

    @property
    def reads(self) -> set[str]:
        return {str(node.value) for node in reachable(self.results) if node.op is Op.SYMBOL}


Sweeps = Callable[[RowKind], tuple[Sweep, ...]]

T = TypeVar("T")


def over_table(table: JointTable, sweeps: Sweeps, given: Mapping[str, Sequence[Expr]]) -> list[Expr]:
    """Return the entries of the result of a loop, row by row; `given` are its arguments by name, q among them, (n,)."""
    graph = given["q"][0].graph

    def put(nodes: Sequence[Expr], here: Mapping[str, Expr]) -> list[Expr]:
        home = nodes[0].graph
        return substitute(nodes, {home.symbol(name): x for name, x in here.items()}, graph)

    return _walked(
        table,
        sweeps,
        [dict(zip(names_of(row), row.entries, strict=True)) for row in table.rows],
        table.ground,
        given,
        graph.zero,
        graph.one,
        add,
        put,
    )


def values_over_table(
    table: JointTable, sweeps: Sweeps, numbers: Sequence[T], given: Mapping[str, Sequence[T]], algebra: Algebra[T]
) -> list[T]:
    """Return the same over an algebra, without a graph of it; `numbers` are the ground's and those of every row.

    Raises:
        what the algebra does where there is no value.
    """
    left = iter(numbers)
    ground = [next(left) for _ in table.ground]
    steps: dict[tuple[Expr, ...], Callable[[Mapping[str, T]], list[T]]] = {}

    def put(nodes: Sequence[Expr], here: Mapping[str, T]) -> list[T]:
        whole = tuple(nodes)
        if whole not in steps:
            steps[whole] = repeated(whole, algebra, attrgetter("value"))
        return steps[whole](here)

    rows = [{name: next(left) for name in names_of(row)} for row in table.rows]
    zero, one = (algebra.constant(Fraction(k)) for k in (0, 1))
    return _walked(table, sweeps, rows, ground, given, zero, one, algebra.add, put)


def _walked(
    table: JointTable,
    sweeps: Sweeps,
    rows: Sequence[Mapping[str, T]],
    ground: Sequence[T],
    given: Mapping[str, Sequence[T]],
    zero: T,
    one: T,
    plus: Callable[[T, T], T],
    put: Callable[[Sequence[Expr], Mapping[str, T]], list[T]],
) -> list[T]:
    """Return the result: `put` gives expressions their values, where names of rows and arguments have theirs."""
    order, kinds = range(1, len(rows) + 1), kinds_of(table)
    known: list[dict[str, T]] = []
    for k, row in enumerate(table.rows):
        here = {**rows[k], **{name: entries[k] for name, entries in given.items()}}
        c, s = put(_turn(row.slides, row.at_zero), here)
        known.append({**here, "cosine": c, "sine": s})
    results = [zero] * len(rows)
    for number, first in enumerate(sweeps(kinds[0])):
        at_joint = list[tuple[int, list[T]]]()
        nothing = [zero] * len(first.handed)
        held: list[list[T]] = [nothing] * (len(rows) + 1)
        if first.ground is not None:
            held[0] = [*nothing[: first.ground], *ground, *nothing[first.ground + 3 :]]
        for place in first.ones:
            held[0][place] = one
        for i in reversed(order) if first.inward else order:
            p, here, sweep = table.rows[i - 1].parent, known[i - 1], sweeps(kinds[i - 1])[number]
            here |= _named(sweep.takes, held[i if sweep.inward else p])
            found = put(sweep.results, here)
            handed, kept = found[: len(nothing)], found[len(nothing) : len(nothing) + len(sweep.kept)]
            here |= _named(sweep.keeps, kept)
            if sweep.inward and held[p] is not nothing:
                handed = [plus(a, b) for a, b in zip(held[p], handed, strict=True)]
            held[p if sweep.inward else i] = handed
            if sweep.finds:
                here[sweep.finds] = found[-1]
            elif sweep.result is not None:
                results[i - 1] = found[-1]
            if sweep.pairs:
                at_joint.append((i, found[len(nothing) + len(sweep.kept) :]))
        if first.pairs:
            results = _paired(table, first.pairs, dict(at_joint), known, zero, put)
            if first.pairs.solved:
                results = _solved(table, results, zero, one, put)
    return results


def _paired(
    table: JointTable,
    pairs: Pairs,
    at_joint: Mapping[int, Sequence[T]],
    known: Sequence[Mapping[str, T]],
    zero: T,
    put: Callable[[Sequence[Expr], Mapping[str, T]], list[T]],
) -> list[T]:
    """Return the result of pairs, row by row, from what stands at each joint: what goes along, and its own entries."""
    n, many = len(known), len(pairs.starts)
    results = [zero] * (3 * n * n)
    for i, found in at_joint.items():
        carried, own = found[:many], found[many:]
        for block, entry in enumerate(own):
            results[((i - 1) * 3 + block) * n + i - 1] = entry
        below = i
        while parent := table.rows[below - 1].parent:
            here = {**known[below - 1], **_named(Pairs.CARRIED, carried)}
            here |= {f"{Pairs.ABOVE}{k}": known[parent - 1][f"{pairs.keeps}{k}"] for k in range(pairs.kept)}
            carried_on = put(pairs.of(table.rows[parent - 1].slides), here)
            carried, entries = carried_on[:many], carried_on[many:]
            for entry, (up, block) in zip(entries, Pairs.BOTH_WAYS, strict=True):
                row, column = (parent, i) if up else (i, parent)
                results[((row - 1) * 3 + block) * n + column - 1] = entry
            results[((i - 1) * 3 + 2) * n + parent - 1] = entries[0]
            below = parent
    return results


def _solved(
    table: JointTable, entries: Sequence[T], zero: T, one: T, put: Callable[[Sequence[Expr], Mapping[str, T]], list[T]]
) -> list[T]:
    """Return -M⁻¹ x, -M⁻¹ y, M⁻¹ of blocks x, y, M, row by row: M = Lᵀ D L, whose L has entries for ancestors alone."""
    n, parents = len(table.rows), [row.parent - 1 for row in table.rows]
    rows = [list(entries[k * 3 * n : k * 3 * n + 2 * n]) for k in range(n)]
    L = [list(entries[k * 3 * n + 2 * n : (k + 1) * 3 * n]) for k in range(n)]
    lessened, scaled = _lessened_and_scaled()

    def ancestors(k: int) -> Iterator[int]:
        while (k := parents[k]) >= 0:
            yield k

    def less(x: T, f: T, y: T) -> T:
        return put(lessened, {"x": x, "f": f, "y": y})[0]

    def over(x: T, d: T, sign: int = 0) -> T:
        return put(scaled, {"x": x, "d": d})[sign]

    for k in reversed(range(n)):
        for i in ancestors(k):
            f = over(L[k][i], L[k][k])
            for j in (i, *ancestors(i)):
                L[i][j] = less(L[i][j], f, L[k][j])
            L[k][i] = f
    for k in range(n):
        rows[k] += [one if j == k else zero for j in range(n)]
    for k in reversed(range(n)):
        for i in ancestors(k):
            rows[i] = [less(x, L[k][i], y) for x, y in zip(rows[i], rows[k], strict=True)]
    for k in range(n):
        rows[k] = [over(x, L[k][k], int(c < 2 * n)) for c, x in enumerate(rows[k])]
        for i in ancestors(k):
            rows[k] = [less(x, L[k][i], y) for x, y in zip(rows[k], rows[i], strict=True)]
    return [entry for row in rows for entry in row]


@cache
def _lessened_and_scaled() -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    x, y, f, d = map(Graph().symbol, "xyfd")
    return (x - f * y,), (x / d, -(x / d))


@cache
def _turn(slides: bool, at_zero: bool) -> tuple[Expr, Expr]:
    """Return cosine and sine of the turn of a joint, a slide's at zero."""
    graph = Graph()
    q, c0, s0 = (graph.symbol(name) for name in ("q", "c0", "s0"))
    c, s = (graph.one, graph.zero) if slides else (graph.cos(q), graph.sin(q))
    return (c, s) if at_zero else (c * c0 - s * s0, s * c0 + c * s0)


def _named(name: str, entries: Sequence[T]) -> dict[str, T]:
    return {f"{name}{k}": x for k, x in enumerate(entries)}
