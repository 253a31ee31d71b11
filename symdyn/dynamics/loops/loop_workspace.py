"""What the outputs of a closed scene share, computed when first asked for: the part of the workspace about loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from symdyn.dynamics.lagrange import second_kind as lagrange
from symdyn.dynamics.loops.constraint_rows import Constraints, differentiated, recursive
from symdyn.dynamics.loops.partition import Partition
from symdyn.dynamics.loops.reduction import Reduction, reduction, with_multipliers
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_decisions import LoopDecisions
    from symdyn.dynamics.loops.loop_numbers import Numbers
    from symdyn.dynamics.roads.workspace import Workspace

Matrix = list[list[Expr]]


class LoopWorkspace:
    """Rows of one scene's loops on the workspace's graph, kept ones only, and what is decided about them."""

    def __init__(self, workspace: Workspace) -> None:
        """Begin with nothing decided."""
        self.w = workspace

    # Decisions

    @property
    def _decided(self) -> tuple[LoopDecisions, Numbers]:
        if isinstance(self._outcome, DerivationError):
            raise self._outcome
        return self._outcome

    @cached_property
    def _outcome(self) -> tuple[LoopDecisions, Numbers] | DerivationError:
        from symdyn.dynamics.loops.loop_decisions import close  # with NumPy, which trees can do without
        from symdyn.dynamics.loops.loop_numbers import Numbers

        try:
            return close(Numbers(self.w.scene), self.w.closing)
        except DerivationError as fault:  # every output would try again, and all in vain
            return fault

    @property
    def decisions(self) -> LoopDecisions:
        """Kept rows and partitions; DerivationError where loops cannot be assembled, or a choice does not fit them."""
        return self._decided[0]

    @property
    def numbers(self) -> Numbers:
        """The mechanism in numbers, on a graph of its own, with values of all parameters."""
        return self._decided[1]

    def values(self, q: Iterable[float]) -> dict[Expr, float]:
        """Return values of all parameters, those that the numbers have, and of the coordinates at q."""
        values = {self.w.graph.symbol(str(node.value)): x for node, x in self.numbers.parameters.items()}
        return values | dict(zip(self.w.state.q, q, strict=True))

    @property
    def driven(self) -> Partition:
        """The partition of inverse dynamics; DerivationError where the drives do not fit."""
        partition = self.decisions.driven
        if partition is None:
            raise DerivationError(f"{self.w.scene.name}: inverse dynamics is not unique: {self.decisions.fault}")
        return partition

    @cached_property
    def coordinates(self) -> tuple[Expr, ...]:
        """The coordinate whose rate each velocity is, shape (nv,); the velocity itself where it is none."""
        by_rate = {rate: q for q, rate in zip(self.w.state.q, self.w.state.rates, strict=True)}
        return tuple(by_rate.get(qd, qd) for qd in self.w.state.qd)

    # Rows, by recursion and by differentiation

    @cached_property
    def recursive(self) -> Constraints:
        """All rows by recursion."""
        return recursive(self.w.scene, self.w.tree, self.w.state)

    @cached_property
    def differentiated(self) -> Constraints:
        """All rows by differentiation."""
        return differentiated(self.w.scene, self.w.graph, self.w.state)

    def residual(self, rows: Constraints) -> list[Expr]:
        """Return residuals of the kept rows, shape (m,)."""
        return [rows.residual[k] for k in self.decisions.kept]

    def G(self, rows: Constraints) -> Matrix:
        """Return the kept rows, shape (m, nv)."""
        return [list(rows.G[k]) for k in self.decisions.kept]

    def constraint_forces(self, multipliers: Sequence[Expr]) -> list[Expr]:
        """Return Gᵀ λ, shape (nv,), for λ of the kept rows."""
        pairs = list(zip(self.G(self.recursive), multipliers, strict=True))
        return [self.w.graph.total(row[k] * x for row, x in pairs) for k in range(self.w.state.n)]

    def bias(self, rows: Constraints) -> list[Expr]:
        """Return Ġ u of the kept rows, shape (m,)."""
        return [rows.bias[k] for k in self.decisions.kept]

    def gamma(self, rows: Constraints) -> list[Expr]:
        """Return Ġ u + 2 α G u + β² residual of the kept rows, shape (m,)."""
        closing, u, graph = self.w.closing, self.w.state.qd, self.w.graph
        alpha, beta = graph.constant(closing.alpha), graph.constant(closing.beta)
        rates = [graph.total(entry * speed for entry, speed in zip(row, u, strict=True)) for row in self.G(rows)]
        stabilised = zip(self.bias(rows), rates, self.residual(rows), strict=True)
        return [bias + 2 * alpha * rate + beta * beta * off for bias, rate, off in stabilised]

    # Recursive road: coordinates partitioned

    @cached_property
    def reduction(self) -> Reduction:
        """u̇ = T u̇_i + s of forward dynamics."""
        rows = self.recursive
        return reduction(self.G(rows), self.gamma(rows), self.decisions.partition, self.w.state.n, self.w.graph)

    @cached_property
    def motion(self) -> Reduction:
        """The same with prescribed accelerations put in: only what forces decide is left."""
        given = self.w.prescribed
        return self.reduction.led(given.place, given.acceleration)

    # Lagrange road: with multipliers

    @cached_property
    def lagrange_forces(self) -> list[Expr]:
        """M u̇ + h, shape (nv,)."""
        return lagrange.driving_forces(self.w.energy)

    @cached_property
    def lagrange_solution(self) -> tuple[list[Expr], list[Expr]]:
        """u̇, and λ with what prescribed motions take beside τ behind it: each is a row u̇_p = p̈ of its own."""
        bias = substitute(self.lagrange_forces, dict.fromkeys(self.w.state.qdd, self.w.graph.zero))
        return self._by_all_rows(self.w.lagrange_mass, self.differentiated, bias)

    # Recursive road where every partition fails somewhere: all rows at once

    @cached_property
    def together(self) -> tuple[list[Expr], list[Expr]]:
        """The same by recursion: regular wherever G has full rank, whatever velocities are independent."""
        w = self.w
        return self._by_all_rows(w.composite_mass, self.recursive, w.forces([w.graph.zero] * w.state.n))

    def _by_all_rows(self, M: Matrix, rows: Constraints, bias: list[Expr]) -> tuple[list[Expr], list[Expr]]:
        w, given = self.w, self.w.prescribed
        rest = [tau - h for tau, h in zip(w.state.tau, bias, strict=True)]
        one, zero = w.graph.one, w.graph.zero
        units = [[one if i == k else zero for i in range(w.state.n)] for k in given.place]
        gamma = [*self.gamma(rows), *(-a for a in given.acceleration)]
        return with_multipliers(M, [*self.G(rows), *units], gamma, rest)
