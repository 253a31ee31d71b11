"""Loops that hold dependent coordinates in proportion to independent ones: parallelograms, and rows of them.

    q_d = T q_i + b,    u_d = T u_i        T, b constant

Such a mechanism passes its change points smoothly, where G_d is singular and the partitioned equations are 0/0: with
the constant T in place of -G_d⁻¹ G_i they hold there too, on the branch that the mechanism is assembled in. T and b are
read off the assembled position, b to the last digit of a double, and tried at random values of the independent
coordinates, all round: residuals and rows must vanish there.

Reference: Gonzalez, Dopico, Lugris and Cuadrado, A benchmarking system for MBS simulation software (2006), problem A02,
whose loops all meet a change point at once.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from symdyn.dynamics.loops.loop_decisions import LoopDecisions
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.reduction import Reduction, accelerations
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, substitute

SAME = 1e-9
"""Ratios this near to a simple fraction are it."""

LARGEST = 12
"""Denominator of the ratios."""

TRIED = 6
CLOSED = 1e-12
"""Largest residual at positions tried, over the size of the mechanism or a metre."""


@dataclass(frozen=True)
class LinearLoops:
    """Dependent coordinates in terms of the independent ones.

    Attributes:
        independent, dependent: places of velocities, ascending; coordinates have the same.
        T: ratios, by dependent and then independent velocity; what is missing is zero.
        b: offset of every dependent coordinate, rad or m.
    """

    independent: tuple[int, ...]
    dependent: tuple[int, ...]
    T: dict[int, dict[int, Fraction]] = field(hash=False)
    b: dict[int, Fraction] = field(hash=False)

    def followers(self, w: Workspace) -> dict[Expr, Expr]:
        """Return dependent coordinates and velocities as what they are in terms of independent ones."""
        graph, q, u = w.graph, w.state.q, w.state.qd
        found: dict[Expr, Expr] = {}
        for k in self.dependent:
            ratios = self.T[k].items()
            found[q[k]] = graph.total([*(x * q[j] for j, x in ratios), graph.constant(self.b[k])])
            found[u[k]] = graph.total(x * u[j] for j, x in ratios)
        return found

    def forward_dynamics(self, w: Workspace) -> list[Expr]:
        """Return u̇, shape (nv,), by independent coordinates and velocities: no division by what may vanish."""
        graph, n = w.graph, w.state.n
        T: list[dict[int, Expr]] = [{} for _ in range(n)]
        for j in self.independent:
            T[j][j] = graph.one
        for k, row in self.T.items():
            T[k] |= {j: graph.constant(x) for j, x in row.items()}
        still = (graph.zero,) * n
        values = self.followers(w)
        h = substitute(w.forces(list(still)), values)
        M = substitute([entry for row in w.composite_mass for entry in row], values)
        rows = [M[k : k + n] for k in range(0, n * n, n)]
        rest = [tau - force for tau, force in zip(w.state.tau, h, strict=True)]
        return accelerations(Reduction(self.independent, tuple(T), still), rows, rest)


def linear_loops(numbers: Numbers, decisions: LoopDecisions) -> LinearLoops | None:
    """Return how the loops of a scene hold its dependent coordinates, None where not in constant proportion."""
    state, scene = numbers.state, numbers.scene
    if not scene.loops or scene.rows or scene.prescribed_velocities or state.rates != state.qd:
        return None
    i, d = list(decisions.partition.independent), list(decisions.partition.dependent)
    G = numbers.jacobian(np.array(decisions.assembly.regular))
    ratios = -np.linalg.lstsq(G[:, d], G[:, i], rcond=None)[0]
    simple = [[Fraction(float(x)).limit_denominator(LARGEST) for x in row] for row in ratios]
    if any(
        abs(float(x) - y) > SAME
        for row, exact in zip(ratios, simple, strict=True)
        for y, x in zip(row, exact, strict=True)
    ):
        return None
    q, A = np.array(decisions.assembly.q), np.array([[float(x) for x in row] for row in simple]).reshape(len(d), len(i))
    b = q[d] - A @ q[i]
    size = max(1.0, decisions.assembly.length)
    rng = random.Random(scene.name)
    for _ in range(TRIED):
        q[i] = [rng.uniform(-np.pi, np.pi) for _ in i]
        q[d] = A @ q[i] + b
        rows = numbers.jacobian(q)
        missed = np.abs(rows[:, i] + rows[:, d] @ A).max(initial=0.0)
        if max(missed, np.abs(numbers.residual(q)).max(initial=0.0)) > CLOSED * size:
            return None
    T = {k: {j: x for j, x in zip(i, row, strict=True) if x} for k, row in zip(d, simple, strict=True)}
    return LinearLoops(tuple(i), tuple(d), T, {k: Fraction(float(x)) for k, x in zip(d, b, strict=True)})
