"""What the system of a closed mechanism has beside that of a tree.

residual, row_rates    r and G u: how far a state misses its loops
correction, fitted     what brings it back: -G_d⁻¹ r, and velocities from independent ones
reach                  ∂u/∂u_i, which is large where the choice of independent velocities fails
together               rates by all rows at once, with multipliers: no choice, regular wherever G has full rank

M u̇ - Gᵀ λ = τ - h        G u̇ = -γ        u̇_p = p̈ where a motion p is prescribed
"""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.dynamics import Function, Workspace
from symdyn.dynamics.outputs import WrittenDecisions
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute
from symdyn.simulation.equations.compiled_routines import function_of


def row_rates(w: Workspace, G: Function) -> Function:
    """Return G u, what the rows make of the velocities."""
    rows, n = G.shape
    terms = [[G.entries[r * n + k] * w.state.qd[k] for k in range(n)] for r in range(rows)]
    return function_of(w, "row_rates", [w.graph.total(row) for row in terms], ("q", "qd"))


def corrections(w: Workspace, decisions: WrittenDecisions) -> list[Function]:
    """Return what brings a state of a closed mechanism back: Newton's step, its way in q, and fitting velocities."""
    zero, u = w.graph.zero, w.state.qd
    linear = decisions.linear
    if linear:
        values = linear.followers(w)
        step = {k: values[w.state.q[k]] - w.state.q[k] for k in linear.dependent}
        fitted = {k: values[u[k]] for k in linear.dependent}
    else:
        rows, partition = w.loops.recursive, w.loops.decisions.partition
        G = w.loops.G(rows)
        step = partition.solve_dependent(G, [-r for r in w.loops.residual(rows)]) if G else {}
        moved = [-w.graph.total(row[k] * u[k] for k in partition.independent) for row in G]
        fitted = partition.solve_dependent(G, moved) if G else {}
    return [
        function_of(w, "correction", [step.get(k, zero) for k in range(w.state.n)], ("q", "qd")),
        function_of(w, "movement", w.state.rates, ("q", "qd")),
        function_of(w, "fitted", [fitted.get(k, x) for k, x in enumerate(u)], ("q", "qd")),
    ]


def reach(w: Workspace) -> list[Expr]:
    """Return ∂u/∂u_i of the dependent velocities; nothing where there is no other choice."""
    if not w.loops.motion.independent:
        return []
    return [x for row in w.loops.reduction.T for x in row.values() if x is not w.graph.one]


def together(w: Workspace, place: Mapping[Expr, Expr], power: Expr) -> Function | None:
    """Return the rates of a state by all rows at once; None where masses leave some acceleration open without them."""
    try:
        found, _ = w.loops.together
    except DerivationError:
        return None
    accelerations = substitute(found, place)
    return function_of(w, "together", [*w.state.rates, *accelerations, *([] if power.is_zero else [power])])
