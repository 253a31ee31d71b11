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

from symdyn.dynamics.loops.manifold import Seeds
from symdyn.dynamics.outputs.closed_derivatives import CLOSED_DERIVATIVES, independent_positions, independent_velocities
from symdyn.dynamics.outputs.closed_slopes import manifold_of
from symdyn.dynamics.outputs.derivative_outputs import COLUMNS, derivatives
from symdyn.dynamics.outputs.output import Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr

STATE_MATRICES = "state_matrices"

Slopes = Sequence[dict[int, Expr]]


def _assembled(
    w: Workspace,
    positions: tuple[Sequence[int], Slopes, Sequence[Seeds]],
    velocities: tuple[Sequence[int], Sequence[Seeds]],
    accelerations: Sequence[Expr],
) -> list[Expr]:
    """Return [A | B] row by row.

    Args:
        w: the workspace.
        positions: independent ones, how all directions move with each, and how velocities do.
        velocities: independent ones, and how all move with each.
        accelerations: derivatives of forward dynamics, row by row, columns in the order of the state, then forces.
    """
    graph, u = w.graph, w.state.qd
    (places, slopes, following), (speeds, moving) = positions, velocities
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


def _of_tree(_: str, derive: Callable[[Workspace], Sequence[Expr]], w: Workspace) -> list[Expr]:
    every, one = range(w.state.n), w.graph.one
    moving = [{u: one} for u in w.state.qd]
    still: list[Seeds] = [{} for _ in every]
    return _assembled(w, (every, [{k: one} for k in every], still), (every, moving), w.once(derive))


def _of_manifold(formulation: str, derive: Callable[[Workspace], Sequence[Expr]], w: Workspace) -> list[Expr]:
    manifold = manifold_of(w, formulation)
    positions = (manifold.places.independent, manifold.slopes, manifold.by_position)
    return _assembled(w, positions, (manifold.partition.independent, manifold.by_velocity), w.once(derive))


def _state(w: Workspace) -> tuple[str, ...]:
    if w.scene.is_closed:
        return (*independent_positions(w), *independent_velocities(w))
    return (*COLUMNS["q"](w), *w.scene.velocities)


def state_matrices(closed: bool) -> Output:
    """Return the row of [A | B], of scenes that loops or rows close or of others."""
    forward = OUTPUTS["forward_dynamics"]
    row = CLOSED_DERIVATIVES["forward_dynamics_derivatives"] if closed else derivatives("forward_dynamics", forward)
    along, which = (_of_manifold, "independent ") if closed else (_of_tree, "")
    return Output(
        f"[A | B] of dx/dt = A x + B tau for small deviations from any motion; x are {which}positions, along the "
        f"directions of the velocities, and {which}velocities",
        row.arguments,
        "AB",
        (lambda w: tuple(f"rate of {name}" for name in _state(w)), lambda w: (*_state(w), *COLUMNS["tau"](w))),
        "rate of the row's entry of x, per unit of the column's",
        "same",
        {
            name: replace(formulation, derive=partial(along, name, formulation.derive))
            for name, formulation in row.formulations.items()
        },
        default_in="request",
        may_fail="reported",
        depends=row.depends,
        prefer=row.prefer,
        remark=row.remark,
        size=row.size,
    )
