"""Linear equations with many right sides, solved in rows: what code may go over in a loop of vectors, column by column.

    x_t := s x_t - Σ_k f_k x_k

Right sides stand side by side, so that a step takes one number from the left and does the same to all columns. Steps
run in order, and so do the terms of each, as lines would have them; a row that is not given starts at zero.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from symdyn.graph import Expr
from symdyn.scene import Scene


@dataclass(frozen=True)
class RowStep:
    """One row after another one.

    Attributes:
        row: t, which row becomes another one.
        scale: s, by what it is multiplied before.
        terms: (f_k, k), what is taken away, in order.
    """

    row: int
    scale: Expr
    terms: tuple[tuple[Expr, int], ...]


@dataclass(frozen=True, eq=False)
class RowSolve:
    """A matrix whose rows begin with rows of a solution.

    Attributes:
        scene: whose parameters its entries hold.
        sides: right sides and the row that each is before the first step, all of one width; other rows start at zero.
        rows: how many rows there are: those of the result, then more.
        steps: in order.
        beside: entries of the result, row by row, that are no part of the solution; None for those that are.
    """

    scene: Scene
    sides: tuple[tuple[int, tuple[Expr, ...]], ...]
    rows: int
    steps: tuple[RowStep, ...]
    beside: tuple[tuple[Expr | None, ...], ...]

    @property
    def width(self) -> int:
        """Columns that are solved for."""
        return len(self.sides[0][1])

    @property
    def products(self) -> int:
        """How many products of factors and entries of rows all steps take."""
        return self.width * sum(len(step.terms) for step in self.steps)

    @property
    def factors(self) -> tuple[Expr, ...]:
        """What rows are multiplied by, each once, in the order in which it is first taken."""
        all_of_it = (one for step in self.steps for one in (step.scale, *(factor for factor, _ in step.terms)))
        return tuple(dict.fromkeys(all_of_it))

    @staticmethod
    def stepped(x: Expr, scale: Expr, taken: Iterable[tuple[Expr, Expr]]) -> Expr:
        """Return s x - Σ f y of one column, in order; zeros are not taken away, and nothing is multiplied by one."""
        if not (scale == scale.graph.one or x.is_zero):
            x = scale * x
        for factor, y in taken:
            if not (factor.is_zero or y.is_zero):
                x = -(factor * y) if x.is_zero else x - factor * y
        return x
