"""A function whose result is solved in rows: lines up to right sides and factors, and what rows become of them.

Entries of such a function are lines like any other's. A target that has a loop over rows asks here for the lines before
it, and for its steps in places of what the lines compute:

    r    a row of one pitch for each of the result: columns of the solution, then all others, each part filled up to
         whole vectors with zeros; more rows; then factors

These lines are lowered when they are first asked for; whoever prints all entries never pays for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from weakref import WeakKeyDictionary

from symdyn.dynamics import Equations, Function
from symdyn.dynamics.mechanism import RowSolve
from symdyn.graph import Expr
from symdyn.program.lower import lower
from symdyn.program.routine import Program

LANES_AT_ONCE = 8
"""Columns of a vector, to whole ones of which rows are filled up with zeros."""

FEWEST = 500
"""Products of a solve from which it is taken in rows."""


@dataclass(frozen=True)
class RowStepAt:
    """A step in places of r: where its row begins, its scale, and of each term factor and where its row begins."""

    row: int
    scale: int
    terms: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class RowLoop:
    """Lines before a loop over rows, and its steps.

    Attributes:
        program: of one function, the lines; its entries are r.
        width: columns that a step goes over, whole vectors.
        steps: in order.
        places: where in r each entry of the result is, when all steps are done.
    """

    program: Program
    width: int
    steps: tuple[RowStepAt, ...]
    places: tuple[int, ...]

    @classmethod
    def of(cls, function: Function) -> RowLoop | None:
        """Return that of a function; None where it is solved in lines, or has few products."""
        solve = function.solve
        if solve is None or solve.products < FEWEST:
            return None
        if solve not in _FOUND:
            _FOUND[solve] = _lowered(function, solve)
        return _FOUND[solve]

    @property
    def entries(self) -> tuple[Expr, ...]:
        """Entries of r, before the first step."""
        return self.program.routines[0].function.entries

    @property
    def vectors(self) -> int:
        """Vectors that a step goes over."""
        return self.width // LANES_AT_ONCE

    def composed(self, entries: Sequence[Expr]) -> list[Expr]:
        """Return the entries of the result from those of r, on any graph."""
        r = list(entries)
        for step in self.steps:
            for c in range(self.width):
                taken = ((r[factor], r[row + c]) for factor, row in step.terms)
                r[step.row + c] = RowSolve.stepped(r[step.row + c], r[step.scale], taken)
        return [r[place] for place in self.places]


_FOUND: WeakKeyDictionary[RowSolve, RowLoop] = WeakKeyDictionary()


def _lowered(function: Function, solve: RowSolve) -> RowLoop:
    factors, columns = solve.factors, len(solve.beside[0])
    graph, width = factors[0].graph, _filled(solve.width)
    pitch = width + _filled(columns - solve.width)
    entries = [graph.zero] * (pitch * solve.rows)
    places = tuple(
        pitch * i + (j if j < solve.width else width + j - solve.width)
        for i in range(len(solve.beside))
        for j in range(columns)
    )
    for place, entry in zip(places, chain(*solve.beside), strict=True):
        entries[place] = entry or graph.zero
    for row, side in solve.sides:
        entries[pitch * row : pitch * row + solve.width] = side
    at = {factor: len(entries) + k for k, factor in enumerate(factors)}
    entries += factors
    given = [replace(a, symbols=tuple(graph.symbol(str(x.value)) for x in a.symbols)) for a in function.arguments]
    lines = replace(function, arguments=tuple(given), shape=(len(entries),), entries=tuple(entries), solve=None)
    steps = (
        RowStepAt(pitch * one.row, at[one.scale], tuple((at[factor], pitch * row) for factor, row in one.terms))
        for one in solve.steps
    )
    return RowLoop(lower(Equations(solve.scene, graph, (lines,))), width, tuple(steps), places)


def _filled(columns: int) -> int:
    return -(-columns // LANES_AT_ONCE) * LANES_AT_ONCE
