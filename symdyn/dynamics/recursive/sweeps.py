"""A loop over a table of joints as sweeps: what each does at a joint, kind by kind.

A sweep is a pass out to the tips or back. Its steps are expressions of the numbers of a row; C prints them, and
`over_table` puts the numbers of a table into them: so what is proved of these expressions is proved of that loop.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from operator import add, attrgetter
from typing import TypeVar

from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.dynamics.recursive.row_kinds import RowKind, kinds_of, names_of
from symdyn.graph import Algebra, Expr, Graph, Op, reachable, repeated, substitute


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
    """

    name: str
    takes: str
    handed: tuple[Expr, ...]
    inward: bool = False
    ground: int | None = None
    keeps: str = ""
    kept: tuple[Expr, ...] = ()
    result: Expr | None = None

    @property
    def results(self) -> tuple[Expr, ...]:
        """All that it computes."""
        return (*self.handed, *self.kept, *([] if self.result is None else [self.result]))

    @property
    def reads(self) -> set[str]:
        """Names of the symbols that it reads."""
        return {str(node.value) for node in reachable(self.results) if node.op is Op.SYMBOL}


Sweeps = Callable[[RowKind], tuple[Sweep, ...]]

T = TypeVar("T")


def over_table(table: JointTable, sweeps: Sweeps, given: Mapping[str, Sequence[Expr]]) -> list[Expr]:
    """Return the entries of the result of a loop; `given` are its arguments by name, q among them, shapes (n,)."""
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
        add,
        put,
    )


def values_over_table(
    table: JointTable,
    sweeps: Sweeps,
    numbers: Sequence[T],
    given: Mapping[str, Sequence[T]],
    algebra: Algebra[T],
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
    return _walked(table, sweeps, rows, ground, given, algebra.constant(Fraction(0)), algebra.add, put)


def _walked(
    table: JointTable,
    sweeps: Sweeps,
    rows: Sequence[Mapping[str, T]],
    ground: Sequence[T],
    given: Mapping[str, Sequence[T]],
    zero: T,
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
        nothing = [zero] * len(first.handed)
        held: list[list[T]] = [nothing] * (len(rows) + 1)
        if first.ground is not None:
            held[0] = [*nothing[: first.ground], *ground, *nothing[first.ground + 3 :]]
        for i in reversed(order) if first.inward else order:
            p, here, sweep = table.rows[i - 1].parent, known[i - 1], sweeps(kinds[i - 1])[number]
            here |= _named(sweep.takes, held[i if sweep.inward else p])
            found = put(sweep.results, here)
            handed, kept = found[: len(nothing)], found[len(nothing) : len(nothing) + len(sweep.kept)]
            here |= _named(sweep.keeps, kept)
            if sweep.inward and held[p] is not nothing:
                handed = [plus(a, b) for a, b in zip(held[p], handed, strict=True)]
            held[p if sweep.inward else i] = handed
            if sweep.result is not None:
                results[i - 1] = found[-1]
    return results


@cache
def _turn(slides: bool, at_zero: bool) -> tuple[Expr, Expr]:
    """Return cosine and sine of the turn of a joint, a slide's at zero."""
    graph = Graph()
    q, c0, s0 = (graph.symbol(name) for name in ("q", "c0", "s0"))
    c, s = (graph.one, graph.zero) if slides else (graph.cos(q), graph.sin(q))
    return (c, s) if at_zero else (c * c0 - s * s0, s * c0 + c * s0)


def _named(name: str, entries: Sequence[T]) -> dict[str, T]:
    return {f"{name}{k}": x for k, x in enumerate(entries)}
