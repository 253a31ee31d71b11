"""Tangents of the constraint manifold of a closed mechanism: r(q) = 0, G u = 0 and G u̇ + Ġ u = 0.

    r, G      residual of holonomic constraints; constraint rows of the velocities u, G u = 0
    ξ, v      independent positions, of the holonomic constraints; independent velocities, of all constraints
    i, d      independent and dependent, of either partition
    X_k       derivative along velocity k, all else fixed
    T_h, T    derivatives of positions by ξ, of velocities by v: T_i = 1, T_d = -G_d⁻¹ G_i
    S         derivatives of velocities by ξ at fixed v: S_i = 0, S_d = -G_d⁻¹ (Σ_k T_h,k X_k G) u

Accelerations likewise: those of independent velocities are fixed or vary alone, the others keep G u̇ + Ġ u = 0.
The formulas hold wherever u and u̇ are, so that two derivations of them agree off the manifold too; on it they are
T u_i differentiated.

Reference: Bayo and García de Jalón, Kinematic and Dynamic Simulation of Multibody Systems (1994), sections 3.5 and 8.2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from symdyn.dynamics.loops.partition import Matrix, Partition
from symdyn.dynamics.mechanism.state import State
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, LocalPartials, gradient, operands, substitute, tangents
from symdyn.unlocked import cached_property

Seeds = dict[Expr, Expr]
Solve = Callable[[Partition, Matrix, Sequence[Expr]], dict[int, Expr]]


@dataclass(frozen=True)
class Manifold:
    """The manifold of one scene, by one formulation.

    Attributes:
        graph: the graph of the scene.
        state: symbols of the state.
        along: directions of the velocities, as of `Directions`.
        position_rows, position_partition: rows of holonomic constraints, shape (rows, nv), and their partition.
        G, bias, partition: independent constraint rows, Ġ u, and the partition of velocities.
        solve: returns x with G_d x = b, by velocity.
    """

    graph: Graph
    state: State
    along: Sequence[Seeds]
    position_rows: Matrix
    position_partition: Partition
    G: Matrix
    bias: Sequence[Expr]
    partition: Partition
    solve: Solve

    @cached_property
    def position_tangents(self) -> list[dict[int, Expr]]:
        """T_h, a column for every independent position, by velocity; what is missing is zero."""
        return self._columns(self.position_rows, self.position_partition)

    @cached_property
    def velocity_tangents(self) -> list[dict[int, Expr]]:
        """T, a column for every independent velocity, by velocity."""
        return self.position_tangents if self.position_rows is self.G else self._columns(self.G, self.partition)

    def _columns(self, rows: Matrix, partition: Partition) -> list[dict[int, Expr]]:
        return [
            {i: self.graph.one} | self._solved(rows, partition, [-row[i] for row in rows])
            for i in partition.independent
        ]

    def _solved(self, rows: Matrix, partition: Partition, b: Sequence[Expr]) -> dict[int, Expr]:
        if all(one.is_zero for one in b):
            return {}
        return {k: x for k, x in self.solve(partition, rows, b).items() if not x.is_zero}

    @cached_property
    def velocity_residual(self) -> list[Expr]:
        """G u, shape (m,)."""
        return self._through(self.G, self.state.qd)

    @cached_property
    def acceleration_residual(self) -> list[Expr]:
        """G u̇ + Ġ u, shape (m,)."""
        return [rate + rest for rate, rest in zip(self._through(self.G, self.state.qdd), self.bias, strict=True)]

    def _through(self, rows: Matrix, x: Sequence[Expr]) -> list[Expr]:
        return [self.graph.dot(row, x) for row in rows]

    # Seeds of the columns of a Jacobian

    @cached_property
    def by_position(self) -> list[Seeds]:
        """Derivatives of coordinates and velocities by each independent position."""
        return [self._moved(column, {}, {}) for column in self.position_tangents]

    def by_parameter(self, symbol: Expr, residual: Sequence[Expr]) -> Seeds:
        """Return the derivatives of all by a parameter at fixed independent ones: holonomic residuals stay zero."""
        seeds = {symbol: self.graph.one}
        step = self._solved(self.position_rows, self.position_partition, [-x for x in tangents(residual, seeds)])
        return self._moved(step, {}, seeds)

    def _moved(self, step: dict[int, Expr], speeds: dict[int, Expr], more: Seeds) -> Seeds:
        """Return the derivatives of coordinates along a step of all directions, beside more, and of velocities."""
        seeds = dict(more)
        for k, x in step.items():
            for q, h in self.along[k].items():
                seeds[q] = seeds.get(q, self.graph.zero) + x * h
        return seeds | self._following(self.velocity_residual, seeds, self.state.qd, speeds)

    @cached_property
    def by_velocity(self) -> list[Seeds]:
        """Derivatives of velocities by each independent velocity."""
        return [{self.state.qd[k]: x for k, x in column.items()} for column in self.velocity_tangents]

    @cached_property
    def by_force(self) -> list[Seeds]:
        return [{one: one.graph.one} for one in self.state.tau]

    def accelerating(self, seeds: Seeds) -> Seeds:
        """Return the derivatives of accelerations too, those of independent velocities being fixed."""
        return seeds | self._following(self.acceleration_residual, seeds, self.state.qdd, {})

    @cached_property
    def by_acceleration(self) -> list[Seeds]:
        """Derivatives of accelerations by each independent acceleration."""
        return [{self.state.qdd[k]: x for k, x in column.items()} for column in self.velocity_tangents]

    def _following(
        self, vanishing: Sequence[Expr], seeds: Seeds, symbols: Sequence[Expr], free: dict[int, Expr]
    ) -> Seeds:
        """Return the derivatives of symbols that G multiplies in `vanishing`: `free` ones given, others solved for."""
        rates = tangents(vanishing, seeds)
        moving = [self.graph.total(row[k] * x for k, x in free.items()) for row in self.G]
        moved = self._solved(self.G, self.partition, [-x - y for x, y in zip(rates, moving, strict=True)])
        return {symbols[k]: x for k, x in (free | moved).items()}

    # One direction, and one weighted sum

    def direction(self, amounts: Mapping[str, Sequence[Expr]]) -> Seeds:
        """Return the directional derivative of all symbols, by independent ones' "q", "qd", "qdd" or "tau"."""
        positions = dict(zip(self.position_partition.independent, amounts["q"], strict=True))
        speeds = dict(zip(self.partition.independent, amounts["qd"], strict=True))
        moving = [-self.graph.total(row[k] * x for k, x in positions.items()) for row in self.position_rows]
        seeds = self._moved(positions | self._solved(self.position_rows, self.position_partition, moving), speeds, {})
        if "qdd" in amounts:
            gaining = dict(zip(self.partition.independent, amounts["qdd"], strict=True))
            return seeds | self._following(self.acceleration_residual, seeds, self.state.qdd, gaining)
        return seeds | dict(zip(self.state.tau, amounts["tau"], strict=True))

    def pullback(
        self, phi: Expr, arguments: Sequence[str], partials: LocalPartials = operands
    ) -> dict[str, list[Expr]]:
        """Return the gradient of one number by independent variables, by argument, in reverse mode.

        Dependent variables are eliminated by adjoints: y with G_dᵀ y = ∂φ/∂u̇_d, then y·(G u̇ + Ġ u) is subtracted
        from φ, and so on with u and with q. One reverse sweep for each.
        """
        known, state = dict[Expr, Expr](), self.state
        found = {"tau": gradient(phi, state.tau, partials)}
        residuals = self.acceleration_residual, self.velocity_residual
        for name, symbols, vanishing in zip(("qdd", "qd"), (state.qdd, state.qd), residuals, strict=True):
            if name not in arguments:
                continue
            slopes = substitute(gradient(phi, symbols, partials), known)
            y = self.partition.solve_transposed(self.G, slopes)
            found[name] = self._left(self.G, self.partition, slopes, y)
            fixed = [self.graph.symbol(f"y {name}[{k}]") for k in range(len(y))]
            known |= dict(zip(fixed, y, strict=True))
            phi = phi - self.graph.dot(fixed, vanishing)
        partial = dict(zip(state.q, substitute(gradient(phi, state.q, partials), known), strict=True))
        slopes = [self.graph.total(h * partial[q] for q, h in seeds.items()) for seeds in self.along]
        y = self.position_partition.solve_transposed(self.position_rows, slopes)
        found["q"] = self._left(self.position_rows, self.position_partition, slopes, y)
        return {name: found[name] for name in arguments}

    def _left(self, rows: Matrix, partition: Partition, slopes: Sequence[Expr], y: Sequence[Expr]) -> list[Expr]:
        """Return the reduced gradient ∂φ/∂u_i - G_iᵀ y."""
        pairs = list(zip(rows, y, strict=True))
        return [slopes[i] - self.graph.total(row[i] * x for row, x in pairs) for i in partition.independent]
