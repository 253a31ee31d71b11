"""Recipe: an output is one row. Import this file, and `symdyn generate --functions energy_integral` writes it.

h = u·∂L/∂u - L, L = K - P, for velocities u, Jacobi's integral; two formulations: half of u·M u and P by recursion, and
that by its definition.
"""

from __future__ import annotations

from symdyn.dynamics import OUTPUTS, Formulation, Output, Workspace
from symdyn.dynamics.recursive.reduced_tree import potential_energy
from symdyn.graph import Expr, gradient


def by_recursion(w: Workspace) -> list[Expr]:
    """Return h from the inertia matrix of composite bodies, and the heights of bodies along the tree."""
    pairs = [(i, j) for i in range(w.state.n) for j in range(w.state.n)]
    twice = w.graph.total(w.composite_mass[i][j] * w.state.qd[i] * w.state.qd[j] for i, j in pairs)
    return [twice / 2 + potential_energy(w.reduced) + w.elastic.energy]


def by_definition(w: Workspace) -> list[Expr]:
    """Return h of the Lagrangian that positions give."""
    lagrangian = w.energy.K - w.energy.P
    slopes = zip(gradient(lagrangian, w.state.qd), w.state.qd, strict=True)
    return [w.graph.total(slope * u for slope, u in slopes) - lagrangian]


OUTPUTS["energy_integral"] = Output(
    "energy integral h = qd.dL/dqd - L of L = K - P{stored}",
    ("q", "qd"),
    "h",
    (),
    "J",
    "same",
    {"recursive": Formulation(by_recursion), "definition": Formulation(by_definition, up_to=4)},
)
