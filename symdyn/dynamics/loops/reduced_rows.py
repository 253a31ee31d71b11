"""Equations of closed mechanisms with many right sides, solved in rows: the partition of `reduction`, column by column.

    M x = r + Gᵀ λ    G x = -c

    x_d := -G_d⁻¹ c                            block by block, the share of the rows
    x_i := r_i + T_dᵀ r_d - (M T)_dᵀ x_d       = Tᵀ (r - M s)
    x_i := (Tᵀ M T)⁻¹ x_i
    x_d := x_d + T_d x_i
    r_d := r_d - M_d x, then λ = -G_d⁻ᵀ r_d    where multipliers are asked for

Velocities whose motion is prescribed have x = 0, and no share in T.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from symdyn.dynamics.loops.dense import CRAMER, Matrix, inverse, squared
from symdyn.dynamics.loops.partition import Partition
from symdyn.dynamics.loops.reduction import Reduction, nonzero
from symdyn.dynamics.mechanism.ldl import Factored
from symdyn.dynamics.mechanism.row_solve import RowStep
from symdyn.graph import Expr
from symdyn.unlocked import cached_property

Side = tuple[Expr, ...]


@dataclass(frozen=True)
class Partitioned:
    """What all right sides have in common.

    Attributes:
        M: of the spanning tree, shape (nv, nv).
        G: kept rows, shape (m, nv).
        partition: of the velocities, all its blocks square.
        motion: T, without velocities whose motion is prescribed.
        mass: Tᵀ M T factored.
    """

    M: Matrix
    G: Matrix
    partition: Partition
    motion: Reduction
    mass: Factored


@dataclass
class RowsTaken:
    """Rows of a solve: λ or x first, the result, then what else there is; steps are added to it.

    Attributes:
        given: what is common.
        multipliers: whether λ is the result.
        sides: right sides by row; a row that has none, and no step yet, is zero and is not taken away.
        steps: so far.
        stepped: their rows.
    """

    given: Partitioned
    multipliers: bool
    sides: dict[int, Side]
    steps: list[RowStep] = field(default_factory=list)
    stepped: set[int] = field(default_factory=set)

    @cached_property
    def places(self) -> dict[int, int]:
        """The place of every dependent velocity among them."""
        return {k: place for place, k in enumerate(self.given.partition.dependent)}

    @property
    def count(self) -> int:
        """How many rows there are."""
        return len(self.given.M) + len(self.given.G) + self._size

    @property
    def _size(self) -> int:
        return len(self.given.M) + (len(self.given.G) if self.multipliers else 0)

    def x(self, k: int) -> int:
        """Return the row of x_k."""
        return k + self._size - len(self.given.M)

    def r(self, k: int) -> int:
        """Return the row of r_k: where x_k is to be, of an independent velocity."""
        return self._size + self.places[k] if k in self.places else self.x(k)

    def c(self, row: int) -> int:
        """Return the row of c."""
        return self._size + len(self.given.partition.dependent) + row

    def take(self, row: int, terms: Iterable[tuple[Expr, int]], scale: Expr | None = None) -> None:
        """Add a step, without terms that are zero."""
        left = tuple(one for one in terms if (one[1] in self.sides or one[1] in self.stepped) and not one[0].is_zero)
        if left or scale is not None:
            self.stepped.add(row)
            self.steps.append(RowStep(row, self.given.M[0][0].graph.one if scale is None else scale, left))

    def factored(self, factors: Factored, places: Sequence[int]) -> None:
        """Add the steps of a symmetric matrix with its factors, to right sides at some rows."""
        for step in factors.steps():
            self.take(places[step.row], [(factor, places[k]) for factor, k in step.terms], step.scale)

    def solve(self, B: Matrix, to: Sequence[int], sides: Sequence[int]) -> None:
        """Add steps to -B⁻¹ times some rows: as `solve_square` finds it, by minors or by normal equations."""
        by_minors = len(B) <= CRAMER
        for row, line in zip(to, inverse(B) if by_minors else zip(*B, strict=True), strict=True):
            self.take(row, zip(line, sides, strict=True))
        if not by_minors:
            self.factored(squared(B), to)


def rows_of(given: Partitioned, rest: Sequence[Side], gamma: Sequence[Side], multipliers: bool) -> RowsTaken:
    """Return the rows of x, or of λ, for right sides r and c, shapes (nv, columns) and (m, columns)."""
    rows = RowsTaken(given, multipliers, {})
    partition, T, M = given.partition, given.motion.T, given.M
    for k in (*given.motion.independent, *partition.dependent):
        rows.sides[rows.r(k)] = rest[k]
    rows.sides |= {rows.c(i): side for i, side in enumerate(gamma) if not all(one.is_zero for one in side)}
    _dependent_alone(rows)
    moved = given.motion.moved(M)
    for i in given.motion.independent:
        pulled = [(-T[k][i], rows.r(k)) for k in partition.dependent if i in T[k]]
        rows.take(rows.x(i), [*pulled, *((moved[i][k], rows.x(k)) for k in partition.dependent)])
    rows.factored(given.mass, [rows.x(i) for i in given.motion.independent])
    for k in partition.dependent:
        rows.take(rows.x(k), [(-T[k][i], rows.x(i)) for i in given.motion.independent if i in T[k]])
    if multipliers:
        for k in partition.dependent:
            rows.take(rows.r(k), [(entry, rows.x(j)) for j, entry in nonzero(M[k])])
        _multipliers(rows)
    return rows


def _dependent_alone(rows: RowsTaken) -> None:
    """Add -G_d⁻¹ c."""
    G, known = rows.given.G, list[int]()
    for block in rows.given.partition.blocks:
        for row in block.rows:
            # c + G x of what is known: less its negative
            rows.take(rows.c(row), [(-G[row][k], rows.x(k)) for k in known])
        matrix = [[G[row][k] for k in block.velocities] for row in block.rows]
        rows.solve(matrix, [rows.x(k) for k in block.velocities], [rows.c(row) for row in block.rows])
        known += block.velocities


def _multipliers(rows: RowsTaken) -> None:
    """Add -G_d⁻ᵀ r_d, λ being the first rows."""
    G, known = rows.given.G, list[int]()
    for block in reversed(rows.given.partition.blocks):
        for k in block.velocities:
            rows.take(rows.r(k), [(-G[row][k], row) for row in known])
        matrix = [[G[row][k] for row in block.rows] for k in block.velocities]
        rows.solve(matrix, block.rows, [rows.r(k) for k in block.velocities])
        known += block.rows
