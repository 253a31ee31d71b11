"""Shared intermediate results of a closed scene, computed when first asked for: the part of the workspace on loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from symdyn.dynamics.loops.constraint_rows import FLAT, Constraints, contact_gaps, differentiated, recursive
from symdyn.dynamics.loops.manifold import Manifold, Solve
from symdyn.dynamics.loops.partition import Partition
from symdyn.dynamics.loops.reduction import (
    AllConstraints,
    Partitioned,
    Reduction,
    all_constraints,
    nonzero,
    reduction,
    with_multipliers,
)
from symdyn.dynamics.mechanism.linear_solve import Factored, factored
from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.dynamics.mechanism.state import body_placements
from symdyn.errors import DerivationError, NoValueError
from symdyn.graph import Expr, evaluate, reachable, substitute
from symdyn.scene.values import spell
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.dynamics.loops.loop_decisions import LoopDecisions
    from symdyn.dynamics.loops.loop_numbers import Numbers
    from symdyn.dynamics.outputs.workspace import Workspace

Matrix = list[list[Expr]]

SINGULAR = 1e-13
"""Eigenvalues of a mass matrix over the largest that are zero."""


EMPTY = Fraction(1, 10**6)
"""The share of a mass that is left where equations end, since forces over none have no value."""


class LoopWorkspace:
    """Independent constraint rows of one scene on the workspace's graph, and decisions about them."""

    def __init__(self, workspace: Workspace) -> None:
        self.w = workspace

    # Decisions

    @property
    def _decided(self) -> tuple[LoopDecisions, Numbers]:
        if isinstance(self._outcome, DerivationError):
            raise self._outcome
        return self._outcome

    @cached_property
    def _outcome(self) -> tuple[LoopDecisions, Numbers] | DerivationError:
        from symdyn.dynamics.loops.loop_numbers import Numbers

        try:
            return Numbers(self.w.scene).decided(self.w.closing)
        except DerivationError as fault:  # kept, since every output would try again
            return fault

    @property
    def decisions(self) -> LoopDecisions:
        """Independent constraints and partitions; DerivationError where loops do not close, or choices do not fit."""
        return self._decided[0]

    @property
    def numbers(self) -> Numbers:
        """The mechanism with numerical values of all parameters, on a graph of its own."""
        return self._decided[1]

    def values(self, q: Iterable[float]) -> dict[Expr, float]:
        """Return values of all parameters, and of the coordinates at q."""
        values = {self.w.graph.symbol(str(node.value)): x for node, x in self.numbers.parameters.items()}
        return values | dict(zip(self.w.state.q, q, strict=True))

    @property
    def actuated(self) -> Partition:
        """The partition of inverse dynamics; DerivationError where the drives do not determine the motion."""
        partition = self.decisions.actuated
        if partition is None:
            raise DerivationError(f"{self.w.scene.name}: inverse dynamics is not unique: {self.decisions.fault}")
        return partition

    @cached_property
    def coordinates(self) -> tuple[Expr, ...]:
        """The coordinate whose rate each velocity is, shape (nv,); the velocity itself where it is none."""
        by_rate = {rate: q for q, rate in zip(self.w.state.q, self.w.state.rates, strict=True)}
        return tuple(by_rate.get(qd, qd) for qd in self.w.state.qd)

    @cached_property
    def ends(self) -> list[tuple[Expr, str]]:
        """Functions whose zero ends the validity of the equations of motion, and messages; of trees too.

        They are the determinant of the three axes of Euler angles, zero where the angles are singular; w² - FLAT² of
        a wheel, w being the sine of its lean; what vanishes where a rope lifts off a wheel; and masses that change,
        less EMPTY of what they begin with.
        """
        from symdyn.dynamics.mechanism.angles import angles_of  # with NumPy

        scene, graph = self.w.scene, self.w.graph
        found = [(one.clearance(graph), one.became_singular) for one in angles_of(scene)]
        least = graph.constant(Fraction(FLAT).limit_denominator(10**6))
        found += [(one.sine * one.sine - least * least, one.fell_flat) for one in contact_gaps(scene, graph)]
        found += self.lifts
        begin = {graph.symbol(one.name): one.value.express(graph) for one in scene.states}
        for body in scene.bodies:
            mass, told = body.mass.express(graph), f"body {body.name} has lost its mass, {spell(body.mass)}"
            found.append(
                (mass - substitute([mass], begin)[0] * graph.constant(EMPTY), f"{told}; let its flow end before")
            )
        moving = {graph.symbol(name) for name in (*scene.coordinates, *(one.name for one in scene.states))}
        return [(formula, words) for formula, words in found if moving.intersection(reachable([formula]))]

    @cached_property
    def lifts(self) -> list[tuple[Expr, str]]:
        """Functions that fall to zero where a rope lifts off a wheel, and messages."""
        scene, graph = self.w.scene, self.w.graph
        placed = body_placements(scene, graph) if scene.ropes else {}
        return [one for rope in scene.ropes for one in Taut(scene, graph).lifts(rope.name, rope.ends, placed)]

    @cached_property
    def singular_somewhere(self) -> bool:
        """Whether M of the spanning tree is singular at zeros, at the start or at a generic position."""
        import numpy as np

        from symdyn.algebra import Floats

        w, assembly = self.w, self.decisions.assembly
        entries = [x for row in w.composite_mass for x in row]
        zeros = self.numbers.normalised(np.zeros(len(w.state.q)))
        for q in map(np.array, (zeros, assembly.q, assembly.regular, *assembly.configurations)):
            try:
                numbers = evaluate(entries, Floats(), self.values(q) | w.scene.at_time(w.graph))
            except NoValueError:  # no position of this mechanism
                continue
            found = np.array(numbers, dtype=np.float64)
            size = np.linalg.eigvalsh(found.reshape(w.state.n, w.state.n))
            if not size[0] > SINGULAR * abs(size[-1]):
                return True
        return False

    # Rows, by recursion and by differentiation

    @cached_property
    def recursive(self) -> Constraints:
        return recursive(self.w.scene, self.w.tree, self.w.state)

    @cached_property
    def differentiated(self) -> Constraints:
        return differentiated(self.w.scene, self.w.graph, self.w.state)

    def residual(self, rows: Constraints) -> list[Expr]:
        """Return residuals of the independent constraints, shape (m,)."""
        return [rows.residual[k] for k in self.decisions.independent_rows]

    def G(self, rows: Constraints) -> Matrix:
        """Return the rows of the independent constraints, shape (m, nv)."""
        return [list(rows.G[k]) for k in self.decisions.independent_rows]

    def constraint_forces(self, multipliers: Sequence[Expr], rows: Constraints | None = None) -> list[Expr]:
        """Return Gᵀ λ, shape (nv,), for λ of the independent constraints."""
        pairs = list(zip(self.G(rows or self.recursive), multipliers, strict=True))
        return [self.w.graph.total(row[k] * x for row, x in pairs) for k in range(self.w.state.n)]

    def bias(self, rows: Constraints) -> list[Expr]:
        """Return Ġ u of the independent constraints, shape (m,)."""
        return [rows.bias[k] for k in self.decisions.independent_rows]

    def acceleration_residual(self, rows: Constraints, rest: Sequence[Expr]) -> list[Expr]:
        """Return G u̇ + Ġ u, or G u̇ with another `rest`, of the independent constraints, shape (m,)."""
        pairs = zip(self.G(rows), rest, strict=True)
        return [self.w.graph.total([*(x * self.w.state.qdd[k] for k, x in nonzero(row)), one]) for row, one in pairs]

    def gamma(self, rows: Constraints) -> list[Expr]:
        """Return Ġ u + 2 α G u + β² residual of the independent constraints, shape (m,)."""
        closing, u, graph = self.w.closing, self.w.state.qd, self.w.graph
        alpha, beta = graph.constant(closing.alpha), graph.constant(closing.beta)
        rates = [graph.total(entry * u[k] for k, entry in nonzero(row)) for row in self.G(rows)]
        stabilised = zip(self.bias(rows), rates, self.residual(rows), strict=True)
        return [bias + 2 * alpha * rate + beta * beta * off for bias, rate, off in stabilised]

    # Directions along the manifold

    @cached_property
    def position_level(self) -> tuple[tuple[int, ...], Partition]:
        """Indices of independent holonomic constraints among all rows, and the partition of positions."""
        from symdyn.dynamics.loops.closed_positions import position_level  # with NumPy

        return position_level(self.numbers, self.decisions)

    @cached_property
    def recursive_manifold(self) -> Manifold:
        """Tangents by recursion, dependent ones by blocks."""
        return self._manifold(self.recursive, Partition.solve_dependent)

    @cached_property
    def differentiated_manifold(self) -> Manifold:
        """Tangents by differentiation, dependent ones by normal equations of all constraints."""
        return self._manifold(self.differentiated, Partition.solve_normal)

    def _manifold(self, rows: Constraints, solve: Solve) -> Manifold:
        level, partition = self.position_level
        G = self.G(rows)
        position_rows = G if level == self.decisions.independent_rows else [list(rows.G[k]) for k in level]
        along, velocities = self.w.directions.along, self.decisions.partition
        bias = self.bias(rows)
        return Manifold(self.w.graph, self.w.state, along, position_rows, partition, G, bias, velocities, solve)

    # Recursive formulation: coordinates partitioned

    @cached_property
    def reduction(self) -> Reduction:
        """u̇ = T u̇_i + s of forward dynamics."""
        rows = self.recursive
        return reduction(self.G(rows), self.gamma(rows), self.decisions.partition, self.w.state.n, self.w.graph)

    @cached_property
    def motion(self) -> Reduction:
        """The same with prescribed accelerations substituted: only those that forces determine are left."""
        given = self.w.prescribed
        return self.reduction.prescribed(given.place, given.acceleration)

    def drives_of(self, forces: Sequence[Expr]) -> list[Expr]:
        """Return the driving forces for forces of the tree, with constraints by recursion; linear in the forces."""
        G = self.G(self.recursive)
        return self.at_drives(forces, G, self.actuated.solve_transposed(G, forces))

    def at_drives(self, forces: Sequence[Expr], G: Matrix, multipliers: Sequence[Expr]) -> list[Expr]:
        """Return f - Gᵀ λ at actuated velocities, zero at passive ones; without any drive, at independent ones."""
        graph = self.w.graph
        tau = [graph.zero] * self.w.state.n
        for k in self.w.scene.actuated_velocities or self.actuated.independent:
            tau[k] = forces[k] - graph.total(row[k] * x for row, x in zip(G, multipliers, strict=True))
        return tau

    # Lagrange formulation: with multipliers

    @cached_property
    def lagrange_forces(self) -> list[Expr]:
        """M u̇ + h, shape (nv,)."""
        return self.w.energy.driving_forces()

    @cached_property
    def lagrange_solution(self) -> tuple[list[Expr], list[Expr]]:
        """u̇, and λ followed by the forces of prescribed motions, each a constraint u̇_p = p̈ of its own."""
        bias = substitute(self.lagrange_forces, dict.fromkeys(self.w.state.qdd, self.w.graph.zero))
        return self._by_all_constraints(self.w.lagrange_mass, self.differentiated, bias)

    # Recursive formulation where every partition fails somewhere: all constraints at once

    @cached_property
    def all_constraints_solution(self) -> tuple[list[Expr], list[Expr]]:
        """The same by recursion: regular wherever G has full rank, whatever velocities are independent."""
        w = self.w
        return self._by_all_constraints(w.composite_mass, self.recursive, w.forces([w.graph.zero] * w.state.n))

    def _by_all_constraints(self, M: Matrix, rows: Constraints, bias: list[Expr]) -> tuple[list[Expr], list[Expr]]:
        w, given = self.w, self.w.prescribed
        rest = [tau - h for tau, h in zip(w.state.tau, bias, strict=True)]
        one, zero = w.graph.one, w.graph.zero
        units = [[one if i == k else zero for i in range(w.state.n)] for k in given.place]
        gamma = [*self.gamma(rows), *(-a for a in given.acceleration)]
        return with_multipliers(M, [*self.G(rows), *units], gamma, rest, self.singular_somewhere)

    # Solutions of M x = rest + Gᵀ λ and G x = -gamma: accelerations and their derivatives

    @cached_property
    def _factored(self) -> Factored:
        """Tᵀ M T of the velocities whose motion is not prescribed, factored once."""
        size = len(self.motion.independent)
        return factored(self.w.graph, range(-1, size), self.motion.mass(self.w.composite_mass) if size else [])

    @cached_property
    def _all_constraints(self) -> AllConstraints:
        """M, the independent constraints and those of prescribed motions, factored once."""
        w = self.w
        units = [[w.graph.one if i == k else w.graph.zero for i in range(w.state.n)] for k in w.prescribed.place]
        return all_constraints(w.composite_mass, [*self.G(self.recursive), *units], self.singular_somewhere)

    @cached_property
    def partitioned(self) -> Partitioned:
        """What right-hand sides that are solved by the partition have in common."""
        G = self.G(self.recursive)
        return Partitioned(self.w.composite_mass, G, self.decisions.partition, self.motion, self._factored)

    def solved(
        self, rest: Sequence[Expr], gamma: Sequence[Expr], given: Sequence[Expr] = (), at_once: bool = False
    ) -> tuple[list[Expr], list[Expr]]:
        """Return x, shape (nv,), as `given` (zero) where a motion is prescribed, and λ, shape (m,), by recursion.

        Factors are shared: those of a partition, or of all constraints `at_once`, where every partition fails
        somewhere. `rest` is of shape (nv,), `gamma` of shape (independent constraints,).
        """
        w, partition, G, zero = self.w, self.decisions.partition, self.G(self.recursive), self.w.graph.zero
        M, n, place = w.composite_mass, range(w.state.n), w.prescribed.place
        accelerations = given or [zero] * len(place)
        if at_once:
            x, found = self._all_constraints.solve(rest, [*gamma, *(-one for one in accelerations)])
            return x, found[: len(G)]
        fixed = partition.solve_dependent(G, [-one for one in gamma])
        whole = Reduction(self.reduction.independent, self.reduction.T, tuple(fixed.get(k, zero) for k in n))
        motion = whole.prescribed(place, accelerations)
        left = [one - w.graph.total(M[k][j] * motion.s[j] for j in n) for k, one in enumerate(rest)]
        free = [row[0] for row in self._factored.solve([[one] for one in motion.project(left)])]
        x = motion.expand(free)
        excess = [w.graph.total(M[k][j] * x[j] for j in n) - one for k, one in enumerate(rest)]
        return x, partition.solve_transposed(G, excess)
