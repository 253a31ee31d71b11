"""Directions along the manifold of a closed mechanism's states, on which r(q) = 0, G u = 0 and G u̇ + Ġ u = 0.

    ξ, v      independent positions, of the rows that hold positions; independent velocities, of all rows
    i, d      independent and dependent, of either partition
    X_k       derivative along velocity k, all else held
    T_h, T    how positions follow ξ, velocities follow v: T_i = 1, T_d = -G_d⁻¹ G_i
    S         how velocities follow ξ at fixed v: S_i = 0, S_d = -G_d⁻¹ (Σ_k T_h,k X_k G) u

Accelerations follow likewise: those of independent velocities are held or move alone, the others keep G u̇ + Ġ u = 0.
The formulas hold wherever u and u̇ are, so that two roads to them agree off the manifold too; on it they are T u_i
differentiated.

Reference: Bayo and García de Jalón, Kinematic and Dynamic Simulation of Multibody Systems (1994), sections 3.5 and 8.2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from symdyn.dynamics.loops.partition import Partition
from symdyn.dynamics.mechanism.state import State
from symdyn.graph import Expr, tangents

Matrix = Sequence[Sequence[Expr]]
Seeds = dict[Expr, Expr]
Solve = Callable[[Matrix, Partition, Sequence[Expr]], dict[int, Expr]]


@dataclass(frozen=True)
class Manifold:
    """The manifold of one scene, by one road.

    Attributes:
        state: symbols of the state.
        along: directions of the velocities, as of `Directions`.
        held, places: rows that hold positions, shape (rows, nv), and the partition of positions.
        G, bias, partition: kept rows, Ġ u, and the partition of velocities.
        solve: returns x with G_d x = b, by velocity.
    """

    state: State
    along: Sequence[Seeds]
    held: Matrix
    places: Partition
    G: Matrix
    bias: Sequence[Expr]
    partition: Partition
    solve: Solve

    @cached_property
    def slopes(self) -> list[dict[int, Expr]]:
        """T_h, a column for every independent position, by velocity; what is missing is zero."""
        return self._columns(self.held, self.places)

    @cached_property
    def spread(self) -> list[dict[int, Expr]]:
        """T, a column for every independent velocity, by velocity."""
        return self.slopes if self.held is self.G else self._columns(self.G, self.partition)

    def _columns(self, rows: Matrix, partition: Partition) -> list[dict[int, Expr]]:
        return [
            {i: self.state.q[0].graph.one} | self._solved(rows, partition, [-row[i] for row in rows])
            for i in partition.independent
        ]

    def _solved(self, rows: Matrix, partition: Partition, b: Sequence[Expr]) -> dict[int, Expr]:
        if all(one.is_zero for one in b):
            return {}
        return {k: x for k, x in self.solve(rows, partition, b).items() if not x.is_zero}

    # Seeds of the columns of a Jacobian

    @cached_property
    def by_position(self) -> list[Seeds]:
        """How coordinates and velocities move with each independent position."""
        graph, u = self.state.q[0].graph, self.state.qd
        powers = [graph.total(x * speed for x, speed in zip(row, u, strict=True)) for row in self.G]
        found = []
        for column in self.slopes:
            seeds: Seeds = {}
            for k, x in column.items():
                for q, h in self.along[k].items():
                    seeds[q] = seeds.get(q, graph.zero) + x * h
            found.append(seeds | self._following(powers, seeds, u))
        return found

    @cached_property
    def by_velocity(self) -> list[Seeds]:
        """How velocities move with each independent velocity."""
        return [{self.state.qd[k]: x for k, x in column.items()} for column in self.spread]

    @cached_property
    def by_force(self) -> list[Seeds]:
        """The driving forces, all independent."""
        return [{one: one.graph.one} for one in self.state.tau]

    def accelerating(self, seeds: Seeds) -> Seeds:
        """Return how accelerations move too, those of the independent velocities held."""
        graph, rates = self.state.q[0].graph, self.state.qdd
        gains = [
            graph.total([*(x * rate for x, rate in zip(row, rates, strict=True)), rest])
            for row, rest in zip(self.G, self.bias, strict=True)
        ]
        return seeds | self._following(gains, seeds, rates)

    @cached_property
    def by_acceleration(self) -> list[Seeds]:
        """How accelerations move with each independent acceleration."""
        return [{self.state.qdd[k]: x for k, x in column.items()} for column in self.spread]

    def _following(self, vanishing: Sequence[Expr], seeds: Seeds, symbols: Sequence[Expr]) -> Seeds:
        """Return how dependent symbols, multiplied by G in what vanishes, move when others do."""
        moved = self._solved(self.G, self.partition, [-x for x in tangents(vanishing, seeds)])
        return {symbols[k]: x for k, x in moved.items()}
