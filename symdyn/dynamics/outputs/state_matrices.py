"""The state equation next to any motion, δẋ = A δx + B δτ, as an output: symbols where the scene has such.

    δξ       displacements along the independent positions; all directions of the velocities where nothing closes
    δv       deviations of the independent velocities, all of them where nothing closes
    A        δξ̇ = δu - ad_u δξ with δu = S δξ + T δv, then δv̇ by the derivatives of forward dynamics
    ad_u     Σ_ij γ^l_ij δξ_i u_j is what -ad_u adds to δξ̇_l, of brackets [X_i, X_j] = γ^l_ij X_l

From d/dt (δξ_i X_i f) = δ(u_j X_j f) for every f. A's block of positions is 0 where velocities are rates of coordinates
and all positions independent of the others' rates; where something turns or rolls it is not.

Reference: Bloch, Krishnaprasad, Marsden and Ratiu, The Euler-Poincaré equations and double bracket dissipation (1996),
section 2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from symdyn.dynamics.outputs.closed_derivatives import CLOSED
from symdyn.dynamics.outputs.derivative_outputs import derivatives
from symdyn.dynamics.outputs.output import Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.tangent_space import (
    COLUMNS,
    independent_positions,
    independent_velocities,
    manifold_of,
)
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr

STATE_MATRICES = "state_matrices"


def _assembled(formulation: str, derive: Callable[[Workspace], Sequence[Expr]], w: Workspace) -> list[Expr]:
    """Return [A | B] row by row, from the derivatives of forward dynamics."""
    graph, u, manifold = w.graph, w.state.qd, manifold_of(w, formulation)
    places, speeds = manifold.places.independent, manifold.partition.independent
    slopes, following, moving = manifold.slopes, manifold.by_position, manifold.by_velocity
    accelerations = w.once(derive)
    width = len(places) + len(speeds) + w.state.n
    found = []
    for k in places:
        turned = [(i, j, x) for (i, j), terms in w.directions.brackets.items() for m, x in terms if m == k]
        found += [
            graph.total([seeds.get(u[k], graph.zero), *(xi[i] * u[j] * x for i, j, x in turned if i in xi)])
            for xi, seeds in zip(slopes, following, strict=True)
        ]
        found += [seeds.get(u[k], graph.zero) for seeds in moving]
        found += [graph.zero] * w.state.n
    return found + [entry for k in speeds for entry in accelerations[k * width : (k + 1) * width]]


def _state(w: Workspace) -> tuple[str, ...]:
    if w.scene.is_closed:
        return (*independent_positions(w), *independent_velocities(w))
    return (*COLUMNS["q"](w), *w.scene.velocities)


def state_matrices(closed: bool) -> Output:
    """Return the row of [A | B], of scenes that loops or rows close or of others."""
    forward = OUTPUTS["forward_dynamics"]
    row = CLOSED["forward_dynamics_derivatives"] if closed else derivatives("forward_dynamics", forward)
    which = "independent " if closed else ""
    return Output(
        f"[A | B] of dx/dt = A x + B tau for small deviations from any motion; x are {which}positions, along the "
        f"directions of the velocities, and {which}velocities",
        row.arguments,
        "AB",
        (lambda w: tuple(f"rate of {name}" for name in _state(w)), lambda w: (*_state(w), *COLUMNS["tau"](w))),
        "rate of the row's entry of x, per unit of the column's",
        "same",
        {
            name: replace(formulation, derive=partial(_assembled, name, formulation.derive))
            for name, formulation in row.formulations.items()
        },
        default_in="request",
        may_fail="reported",
        depends=row.depends,
        prefer=row.prefer,
        remark=row.remark,
        size=row.size,
    )
