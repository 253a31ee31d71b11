"""Passive forces along a reference, as adaptive control and observers want them: rows of OUTPUTS.

    C(q, q̇) v                                   C the Coriolis matrix of Christoffel symbols, v = q̇_r
    τ = M q̈_r + C(q, q̇) q̇_r + g + k_E + F(q, q̇)      F: what friction, dampers and loads take, at q̇
    τ = Y(q, q̇, q̇_r, q̈_r) β                    β the base parameters

C v is c(q, q̇) with each product of two velocities taken of q̇ and v (`polarised`), and M w where velocities are no rates
of coordinates, w_l = ½ Σ γ^l_kj q̇_k v_j: so nothing of n² entries is made.

Reference: Slotine and Li, On the adaptive control of robot manipulators (1987).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.base_columns import Base, base, base_by_lagrange, base_columns, chosen, others
from symdyn.dynamics.outputs.named_functions import REFERENCE, REFERENCE_RATE, direction
from symdyn.dynamics.outputs.output import FORCES, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.tree_formulations import shorter_coriolis_times
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.rnea import polarised, rnea
from symdyn.graph import Expr, gradient, substitute, tangents


def _reference(w: Workspace) -> tuple[Expr, ...]:
    return direction(w.graph, REFERENCE, w.state.n)


def _turned(w: Workspace) -> list[Expr]:
    """Return w_l = ½ Σ γ^l_kj q̇_k v_j, zero for rates of coordinates."""
    found, v = list(w.still), _reference(w)
    for (k, j), terms in w.directions.brackets.items():
        for m, value in terms:
            found[m] = found[m] + w.state.qd[k] * v[j] * value / 2
    return found


def _along(w: Workspace, forces: Sequence[Expr]) -> list[Expr]:
    """Return half the derivative of functions along q̇ = v."""
    return [one / 2 for one in tangents(forces, dict(zip(w.state.qd, _reference(w), strict=True)))]


def _sum(*lists: Sequence[Expr]) -> list[Expr]:
    return [one.graph.total((one, *rest)) for one, *rest in zip(*lists, strict=True)]


def coriolis_times(w: Workspace) -> list[Expr]:
    """Return C(q, q̇) v, shape (n,), by recursion."""
    return polarised(w.reduced.weightless, w.state.qd, _reference(w), _turned(w))


def _by_matrix(w: Workspace) -> list[Expr]:
    """Return the matrix of Christoffel symbols times v."""
    C = w.composite_christoffel.coriolis_matrix(w.state.qd)
    return [w.graph.total(x * y for x, y in zip(row, _reference(w), strict=True)) for row in C]


def _rest(w: Workspace) -> list[Expr]:
    """Return k_E - Q, what does not come from inertia or weight."""
    loads = rnea(w.reduced.weightless, w.still, w.still, w.loads)
    return [pull - push + load for pull, push, load in zip(w.elastic.forces, w.pushes, loads, strict=True)]


def _accelerations(w: Workspace) -> list[Expr]:
    return _sum(direction(w.graph, REFERENCE_RATE, w.state.n), _turned(w))


def _forces(w: Workspace) -> list[Expr]:
    return _sum(polarised(w.reduced, w.state.qd, _reference(w), _accelerations(w)), _rest(w))


def _forces_by_matrices(w: Workspace) -> list[Expr]:
    qdd = direction(w.graph, REFERENCE_RATE, w.state.n)
    inertial = [w.graph.total(x * y for x, y in zip(row, qdd, strict=True)) for row in w.composite_mass]
    return _sum(inertial, _by_matrix(w), w.gravity_forces, _rest(w))


# Regressor


def _polarised(w: Workspace, column: Sequence[Expr]) -> list[Expr]:
    """Return a column of the regressor of driving forces as one along the reference.

    What has accelerations is quadratic in velocities, and is taken at q̇ and v; all else, such as friction, at q̇.
    """
    state = w.state
    still, rest = dict.fromkeys(state.qd, w.graph.zero), dict.fromkeys(state.qdd, w.graph.zero)
    alone = substitute(column, still)
    moved = dict(zip(state.qdd, _accelerations(w), strict=True))
    at_rest = substitute(column, rest)
    if all(one is other for one, other in zip(at_rest, column, strict=True)):
        return list(column)
    return _sum(substitute(alone, moved), _along(w, at_rest))


def _regressor(w: Workspace) -> list[Expr]:
    """Return the regressor by one recursion."""
    found: Base = w.once(base)
    forces = polarised(found.tree, w.state.qd, _reference(w), _accelerations(w))
    rows = [gradient(force, found.symbols) for force in forces]
    return chosen(w, [*zip(*rows, strict=True), *(_polarised(w, column) for column in w.once(others)[1])])


def _regressor_by_lagrange(w: Workspace) -> list[Expr]:
    """Return the regressor from that of the driving forces."""
    return chosen(w, [_polarised(w, column) for column in base_by_lagrange(w)])


_row = partial(Output, when_constrained="tree", default_in="request")

PASSIVITY: dict[str, Output] = {
    "coriolis_times": _row(
        "Coriolis matrix of Christoffel symbols times a velocity, C(q, qd) qd_r",
        ("q", "qd", REFERENCE),
        "f",
        (labels.velocities,),
        FORCES,
        formulations={"rnea": Formulation(coriolis_times), "crba": Formulation(_by_matrix)},
        prefer=shorter_coriolis_times,
    ),
    "slotine_li_forces": _row(
        "driving forces along a reference, tau = M(q) qdd_r + C(q, qd) qd_r + g(q){pulls} - Q",
        ("q", "qd", REFERENCE, REFERENCE_RATE),
        "tau",
        (labels.velocities,),
        FORCES,
        formulations={"rnea": Formulation(_forces), "crba": Formulation(_forces_by_matrices)},
        prefer=shorter_coriolis_times,
    ),
    "slotine_li_regressor": _row(
        "regressor Y(q, qd, qd_r, qdd_r) of the driving forces along a reference, Y beta, beta the base parameters",
        ("q", "qd", REFERENCE, REFERENCE_RATE),
        "Y",
        (labels.velocities, base_columns),
        "N m or N, per unit of the parameter",
        formulations={
            "rnea": Formulation(_regressor),
            "lagrange": by_lagrange(_regressor_by_lagrange),
        },
        size=Size((0, 46)),
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""
