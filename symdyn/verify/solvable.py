"""Claims that linear equations can be met: that what some derivation found is a solution, be there others or not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import lgamma, log
from typing import Any

from symdyn.algebra.degree import Bound
from symdyn.algebra.elimination import Field, eliminate
from symdyn.graph import Expr
from symdyn.verify.equality import Claim


@dataclass(frozen=True)
class Solvable(Claim):
    """A claim that A x = b has a solution wherever it is looked at, be it unique or not; pivots are chosen there.

    Attributes:
        left: entries of A and b, what is zero left out; right are as many zeros.
        places: row and column of each; b is the column behind the unknowns.
        unknowns: how many.
    """

    places: tuple[tuple[int, int], ...] = ()
    unknowns: int = 0

    def compared(
        self, left: list[Any], right: list[Any], field: Field, zero: Any, weigh: Callable[[Any], Any]
    ) -> tuple[list[Any], list[Any]]:
        """Return what is left of b when A is eliminated, and zeros; see `Claim.compared`."""
        rows: list[dict[int, Any]] = [{} for _ in range(1 + max((r for r, _ in self.places), default=-1))]
        for (r, c), value in zip(self.places, left, strict=True):
            rows[r][c] = value
        rest = eliminate(rows, self.unknowns, field, zero, weigh).left
        return [rest.get(r, zero) for r in range(len(rows))], [zero] * len(rows)

    def widened(self, bound: Bound) -> Bound:
        """Return the bound of a determinant of A with b, each row of it multiplied out."""
        size = self.unknowns + 1
        wide = size * (size + 1)
        return Bound(wide * bound.degree, wide * bound.height + lgamma(size + 1) / log(2))


def solvable(name: str, left_name: str, right_name: str, rows: Sequence[Mapping[int, Expr]], unknowns: int) -> Solvable:
    """Return the claim that A x = b has a solution.

    Args:
        name: of the claim, for reading, as its two sides are.
        left_name: what is claimed to be a solution.
        right_name: of what.
        rows: of A with b beside it, entries by column, b's being `unknowns`.
        unknowns: how many there are.
    """
    places = tuple((r, c) for r, row in enumerate(rows) for c in row)
    left = tuple(entry for row in rows for entry in row.values())
    zeros = tuple(entry.graph.zero for entry in left)
    return Solvable(name, left_name, right_name, left, zeros, places, unknowns)
