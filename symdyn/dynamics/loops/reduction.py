"""Equations of closed mechanisms: M u̇ + h = τ + Gᵀ λ together with G u̇ + γ = 0.

    M, h      of the spanning tree; h = c + g - Q, forces of velocities, gravity and loads; f = M u̇ + h
    G, γ      independent constraint rows; γ = Ġ u, and Baumgarte's terms where they are asked for
    i, d      independent and dependent velocities of a partition
    T, s      u̇ = T u̇_i + s solves G u̇ + γ = 0:  T_i = 1, T_d = -G_d⁻¹ G_i,  s_i = 0, s_d = -G_d⁻¹ γ

*Partitioned*: Tᵀ M T u̇_i = Tᵀ (τ - h - M s), since Tᵀ Gᵀ = 0; then λ = G_d⁻ᵀ (f - τ)_d. M may be singular (a massless
coupler) as long as Tᵀ M T is not. *With multipliers*, the other formulation: A = M + Gᵀ G is regular with it, and

    G A⁻¹ Gᵀ λ = -γ - G A⁻¹ (τ - h - Gᵀ γ),    u̇ = A⁻¹ (τ - h - Gᵀ γ + Gᵀ λ)

where A = M without the terms Gᵀ γ suffices if M is regular at all positions, singular ones included. Both agree
identically off the constraint manifold too. Where contacts and nonholonomic constraints alone have no partition that
is valid at every position, the first formulation solves for all multipliers at once as well.

G_d is solved by its blocks (`partition.py`). Symmetric matrices are factored as Lᵀ D L, which needs no pivots.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 8.5 and 3.2; Wehage and Haug (1982); Baumgarte,
Stabilization of constraints and integrals of motion in dynamical systems (1972).

Many right-hand sides r, c are solved column by column, by the same partition:

    M x = r + Gᵀ λ    G x = -c

    x_d := -G_d⁻¹ c                            block by block, from the constraints
    x_i := r_i + T_dᵀ r_d - (M T)_dᵀ x_d       = Tᵀ (r - M s)
    x_i := (Tᵀ M T)⁻¹ x_i
    x_d := x_d + T_d x_i
    r_d := r_d - M_d x, then λ = -G_d⁻ᵀ r_d    where multipliers are asked for

Velocities whose motion is prescribed have x = 0, and no column in T.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

from symdyn.dynamics.loops.partition import CRAMER, Matrix, Partition, inverse, squared
from symdyn.dynamics.mechanism.linear_solve import Factored, RowStep, Singular, factored, solve
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Graph
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Reduction:
    """Accelerations in terms of the independent ones.

    Attributes:
        T: T[k] maps an independent velocity to its coefficient in u̇_k; what is missing is zero.
        s: the rest of u̇, shape (nv,).
    """

    independent: tuple[int, ...]
    T: tuple[dict[int, Expr], ...]
    s: tuple[Expr, ...]

    def prescribed(self, indices: Sequence[int], given: Sequence[Expr]) -> Reduction:
        """Return the reduction with the accelerations of some independent velocities prescribed."""
        known = dict(zip(indices, given, strict=True))
        s = [
            one + one.graph.total(t * known[i] for i, t in row.items() if i in known)
            for row, one in zip(self.T, self.s, strict=True)
        ]
        T = tuple({i: t for i, t in row.items() if i not in known} for row in self.T)
        return Reduction(tuple(i for i in self.independent if i not in known), T, tuple(s))

    def expand(self, reduced: Sequence[Expr]) -> list[Expr]:
        """Return T x + s for x of shape (independent,)."""
        x = dict(zip(self.independent, reduced, strict=True))
        return [s + s.graph.total(t * x[i] for i, t in row.items()) for row, s in zip(self.T, self.s, strict=True)]

    def project(self, forces: Sequence[Expr]) -> list[Expr]:
        """Return Tᵀ f, shape (independent,)."""
        total = dict.fromkeys(self.independent, forces[0].graph.zero)
        for row, force in zip(self.T, forces, strict=True):
            for i, t in row.items():
                total[i] = total[i] + t * force
        return list(total.values())

    def mass_times_T(self, M: Matrix) -> dict[int, list[Expr]]:
        """Return M T, a column of shape (nv,) for each independent velocity."""
        rows = [nonzero(row) for row in M]
        return {
            i: [M[0][0].graph.total(x * self.T[k][i] for k, x in row if i in self.T[k]) for row in rows]
            for i in self.independent
        }

    def mass(self, M: Matrix) -> list[list[Expr]]:
        """Return Tᵀ M T, shape (independent, independent)."""
        graph, columns = M[0][0].graph, self.mass_times_T(M).values()
        entries = [
            [graph.total(t[i] * x for t, x in zip(self.T, column, strict=True) if i in t) for column in columns]
            for i in self.independent
        ]
        size = range(len(self.independent))
        return [[entries[max(i, j)][min(i, j)] for j in size] for i in size]  # symmetric: the lower triangle


def reduction(G: Matrix, gamma: Sequence[Expr], partition: Partition, n: int, graph: Graph) -> Reduction:
    """Return T and s for the independent constraint rows."""
    T: list[dict[int, Expr]] = [{} for _ in range(n)]
    for i in partition.independent:
        T[i][i] = graph.one
        for k, x in partition.solve_dependent(G, [-row[i] for row in G]).items():
            if not x.is_zero:
                T[k][i] = x
    s = [graph.zero] * n
    for k, x in partition.solve_dependent(G, [-one for one in gamma]).items():
        s[k] = x
    return Reduction(partition.independent, tuple(T), tuple(s))


def accelerations(reduced: Reduction, M: Matrix, rest: Sequence[Expr]) -> list[Expr]:
    """Return u̇, shape (nv,), for `rest` = τ - h - M s; DerivationError where Tᵀ M T is singular."""
    if not reduced.independent:
        return list(reduced.s)
    chain = range(-1, len(reduced.independent))
    return reduced.expand(solve(chain, reduced.mass(M), reduced.project(rest)))


def nonzero(row: Sequence[Expr]) -> list[tuple[int, Expr]]:
    """Return the nonzero entries of a matrix row with their indices: rows of large mechanisms are sparse."""
    zero = row[0].graph.zero if row else None
    return [(k, x) for k, x in enumerate(row) if x is not zero]


# With multipliers


def with_multipliers(
    M: Matrix, G: Matrix, gamma: Sequence[Expr], rest: Sequence[Expr], singular: bool
) -> tuple[list[Expr], list[Expr]]:
    """Return u̇ and λ for `rest` = τ - h, by elimination of u̇; `singular` tells whether M is so at some position."""
    if not singular:
        with suppress(Singular):  # everywhere
            return _schur([list(row) for row in M], G, gamma, list(rest))
    graph = M[0][0].graph
    shifted = [x - graph.total(row[i] * c for row, c in zip(G, gamma, strict=True)) for i, x in enumerate(rest)]
    return _schur(_shifted(M, G), G, gamma, shifted)


def _shifted(M: Matrix, G: Matrix) -> list[list[Expr]]:
    n, graph = range(len(M)), M[0][0].graph
    return [[M[i][j] + graph.total(row[i] * row[j] for row in G) for j in n] for i in n]


def _schur(A: list[list[Expr]], G: Matrix, gamma: Sequence[Expr], rest: list[Expr]) -> tuple[list[Expr], list[Expr]]:
    n, m, graph = len(A), range(len(G)), A[0][0].graph
    chain = range(-1, n)
    free = solve(chain, A, rest)
    if not G:
        return free, []
    A_inverse_GT = [solve(chain, A, row) for row in G]  # A⁻¹ Gᵀ, a column each
    S = [[_product(G[i], A_inverse_GT[j]) for j in m] for i in m]
    right = [-gamma[i] - _product(G[i], free) for i in m]
    found = solve(range(-1, len(G)), S, right)
    return [x + graph.total(found[i] * A_inverse_GT[i][k] for i in m) for k, x in enumerate(free)], found


@dataclass(frozen=True)
class AllConstraints:
    """The same for many right-hand sides: A = M, or M + Gᵀ G where that is singular, and G A⁻¹ Gᵀ, both factored."""

    A: Factored
    G: Matrix
    A_inverse_GT: list[list[Expr]]
    S: Factored
    shifts: bool

    def solve(self, rest: Sequence[Expr], gamma: Sequence[Expr]) -> tuple[list[Expr], list[Expr]]:
        """Return x and λ of M x = rest + Gᵀ λ, G x = -gamma."""
        graph, pairs = self.A.graph, list(zip(self.G, gamma, strict=True))
        if self.shifts:
            rest = [one - graph.total(row[i] * c for row, c in pairs) for i, one in enumerate(rest)]
        free = [row[0] for row in self.A.solve([[one] for one in rest])]
        found = [row[0] for row in self.S.solve([[-c - _product(row, free)] for row, c in pairs])]
        shares = list(zip(found, self.A_inverse_GT, strict=True))
        x = [one + graph.total(y * column[k] for y, column in shares) for k, one in enumerate(free)]
        return x, found


def all_constraints(M: Matrix, G: Matrix, singular: bool) -> AllConstraints:
    """Return M and G factored; Singular where the constraints leave something undetermined.

    `singular` tells whether M is so at some position.
    """
    n, graph = range(len(M)), M[0][0].graph

    def tried(A: list[list[Expr]], shifts: bool) -> AllConstraints:
        of_A = factored(graph, range(-1, len(A)), A)
        columns = of_A.solve([[row[i] for row in G] for i in n]) if G else []
        A_inverse_GT = [[row[k] for row in columns] for k in range(len(G))]
        S = factored(graph, range(-1, len(G)), [[_product(row, one) for one in A_inverse_GT] for row in G])
        return AllConstraints(of_A, G, A_inverse_GT, S, shifts)

    if not singular:
        with suppress(Singular):  # everywhere
            return tried([list(row) for row in M], False)
    return tried(_shifted(M, G), True)


def _product(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    return a[0].graph.total(x * b[k] for k, x in nonzero(a))


Side = tuple[Expr, ...]


@dataclass(frozen=True)
class Partitioned:
    """What all right-hand sides have in common."""

    M: Matrix  # of the spanning tree, shape (nv, nv)
    G: Matrix  # independent constraint rows, shape (m, nv)
    partition: Partition  # of the velocities, all its blocks square
    motion: Reduction  # T, without velocities whose motion is prescribed
    mass: Factored  # Tᵀ M T factored


@dataclass
class SolveSteps:
    """A solve as steps on rows of a table of right-hand sides: the result, λ or x, first, then intermediate rows."""

    given: Partitioned  # what is common to all right-hand sides
    multipliers: bool  # whether λ is the result
    sides: dict[int, Side]  # right-hand sides by row of the table; a row without one, and without a step yet, is zero
    steps: list[RowStep] = field(default_factory=list)  # so far
    stepped: set[int] = field(default_factory=set)  # their rows

    @cached_property
    def indices(self) -> dict[int, int]:
        """The index of every dependent velocity among them."""
        return {k: index for index, k in enumerate(self.given.partition.dependent)}

    @property
    def count(self) -> int:
        return len(self.given.M) + len(self.given.G) + self._size

    @property
    def _size(self) -> int:
        return len(self.given.M) + (len(self.given.G) if self.multipliers else 0)

    def x(self, k: int) -> int:
        return k + self._size - len(self.given.M)

    def r(self, k: int) -> int:
        """Return the row of r_k: where x_k is to be, of an independent velocity."""
        return self._size + self.indices[k] if k in self.indices else self.x(k)

    def c(self, row: int) -> int:
        return self._size + len(self.given.partition.dependent) + row

    def take(self, row: int, terms: Iterable[tuple[Expr, int]], scale: Expr | None = None) -> None:
        """Add a step, without terms that are zero."""
        left = tuple(one for one in terms if (one[1] in self.sides or one[1] in self.stepped) and not one[0].is_zero)
        if left or scale is not None:
            self.stepped.add(row)
            self.steps.append(RowStep(row, self.given.M[0][0].graph.one if scale is None else scale, left))

    def factored(self, factors: Factored, at: Sequence[int]) -> None:
        """Add the steps of a symmetric matrix with its factors, to right-hand sides at some rows."""
        for step in factors.steps(at):
            self.take(step.row, step.terms, step.scale)

    def solve(self, B: Matrix, to: Sequence[int], sides: Sequence[int]) -> None:
        """Add steps to -B⁻¹ times some rows: as `solve_square` finds it, by minors or by normal equations."""
        by_minors = len(B) <= CRAMER
        for row, line in zip(to, inverse(B) if by_minors else zip(*B, strict=True), strict=True):
            self.take(row, zip(line, sides, strict=True))
        if not by_minors:
            self.factored(squared(B), to)


def rows_of(given: Partitioned, rest: Sequence[Side], gamma: Sequence[Side], multipliers: bool) -> SolveSteps:
    """Return the steps that solve for x, or λ, with right-hand sides r, c, shapes (nv, columns) and (m, columns)."""
    rows = SolveSteps(given, multipliers, {})
    partition, T, M = given.partition, given.motion.T, given.M
    for k in (*given.motion.independent, *partition.dependent):
        rows.sides[rows.r(k)] = rest[k]
    rows.sides |= {rows.c(i): side for i, side in enumerate(gamma) if not all(one.is_zero for one in side)}
    _dependent_alone(rows)
    moved = given.motion.mass_times_T(M)
    for i in given.motion.independent:
        projected = [(-T[k][i], rows.r(k)) for k in partition.dependent if i in T[k]]
        rows.take(rows.x(i), [*projected, *((moved[i][k], rows.x(k)) for k in partition.dependent)])
    rows.factored(given.mass, [rows.x(i) for i in given.motion.independent])
    for k in partition.dependent:
        rows.take(rows.x(k), [(-T[k][i], rows.x(i)) for i in given.motion.independent if i in T[k]])
    if multipliers:
        for k in partition.dependent:
            rows.take(rows.r(k), [(entry, rows.x(j)) for j, entry in nonzero(M[k])])
        _multipliers(rows)
    return rows


def _dependent_alone(rows: SolveSteps) -> None:
    """Add -G_d⁻¹ c."""
    G, known = rows.given.G, list[int]()
    for block in rows.given.partition.blocks:
        for row in block.rows:
            # c + G x of known velocities: less its negative
            rows.take(rows.c(row), [(-G[row][k], rows.x(k)) for k in known])
        matrix = [[G[row][k] for k in block.velocities] for row in block.rows]
        rows.solve(matrix, [rows.x(k) for k in block.velocities], [rows.c(row) for row in block.rows])
        known += block.velocities


def _multipliers(rows: SolveSteps) -> None:
    """Add -G_d⁻ᵀ r_d, λ being the first rows."""
    G, known = rows.given.G, list[int]()
    for block in reversed(rows.given.partition.blocks):
        for k in block.velocities:
            rows.take(rows.r(k), [(-G[row][k], row) for row in known])
        matrix = [[G[row][k] for row in block.rows] for k in block.velocities]
        rows.solve(matrix, block.rows, [rows.r(k) for k in block.velocities])
        known += block.rows
