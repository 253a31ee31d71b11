"""Regressors: driving forces, power and energies as a matrix times the parameters that they are linear in.

    τ = Y(q, q̇, q̈) π + r           r: what depends on none of the columns' parameters, zero in most scenes

    regressor          π: ten parameters of every body about its frame, m, m r, I; armatures, damping, dry friction,
                       stiffness and preload of springs, loads: by the names of `--symbolic all`, or of the scene's own
                       parameters where one stands there
    base_regressor     the fewest columns that span the same forces: base parameters of the moving bodies in the link
                       frames that the generator chose (`reduced_tree`), by second moments J; equal columns are one

`base_columns` says what is a column, and which few do as well.

Adaptive control and observers want passive forces along a reference, and the regressor of those:

    C(q, q̇) v                                   C the Coriolis matrix of Christoffel symbols, v = q̇_r
    τ = M q̈_r + C(q, q̇) q̇_r + g + k_E + F(q, q̇)      F: what friction, dampers and loads take, at q̇
    τ = Y(q, q̇, q̇_r, q̈_r) β                    β the base parameters

C v is c(q, q̇) with each product of two velocities taken of q̇ and v (`polarised`), and M w where velocities are no
rates of coordinates, w_l = ½ Σ γ^l_kj q̇_k v_j: so nothing of n² entries is made.

Reference: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986); Khalil
and Dombre (2002), chapters 9 and 12; Gautier and Khalil (1990); Slotine and Li, On the adaptive control of robot
manipulators (1987).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.arguments import suggesting
from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.base_columns import (
    Base,
    BaseColumns,
    Linear,
    base,
    base_by_lagrange,
    base_columns,
    chosen,
    columns,
    driving,
    felt,
    lagrange_driving,
    others,
)
from symdyn.dynamics.outputs.constrained_outputs import lagrange_drives_of
from symdyn.dynamics.outputs.named_functions import REFERENCE, REFERENCE_RATE, direction
from symdyn.dynamics.outputs.output import FORCES, Constrained, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.tree_formulations import shorter_coriolis_times
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.tree_dynamics import polarised, rnea
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, substitute, tangents
from symdyn.scene import Scene


def _regressor(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> list[Expr]:
    """Return Y row by row, on the graph of the workspace."""
    found = Linear.of(w)
    rows = found.slopes(forces(found.workspace))
    return substitute([one for row in rows for one in row], {}, w.graph)


@suggesting
def linear_parameters(scene: Scene, output: str = "regressor") -> tuple[tuple[str, Expr], ...]:
    """Return name and value of what the columns of a regressor are to be multiplied by, formulas of the scene's names.

    Args:
        scene: the mechanism.
        output: "regressor", or "base_regressor" for that of the fewest columns; kg, kg m, kg m^2 and the units of what
            acts.

    Raises:
        DerivationError: `output` is neither.
    """
    known: dict[str, type[Linear | BaseColumns]] = {"regressor": Linear, "base_regressor": BaseColumns}
    if output not in known:
        raise DerivationError(f"{output} has no parameters of its own; give {' or '.join(known)}")
    return known[output].of(Workspace(scene)).named()


# Where loops close: what each column takes from the drives


def _driven(w: Workspace, entries: Sequence[Expr], drives: Callable[[Workspace, list[Expr]], list[Expr]]) -> list[Expr]:
    """Return a regressor of the spanning tree as that of the drives, row by row."""
    count = len(entries) // w.state.n
    found = [drives(w, [entries[i * count + k] for i in range(w.state.n)]) for k in range(count)]
    return [column[i] for i in range(w.state.n) for column in found]


_row = partial(Output, default_in="request")


def _of_drives(
    recursive: Callable[[Workspace], list[Expr]], differentiated: Callable[[Workspace], list[Expr]]
) -> Callable[..., Output]:
    """Return what makes a row of the regressors of a tree, which scenes with loops have of their drives."""
    constrained = {
        "rnea": Formulation(lambda w: _driven(w, recursive(w), lambda _, forces: w.loops.drives_of(forces))),
        "lagrange": by_lagrange(lambda w: _driven(w, differentiated(w), lagrange_drives_of)),
    }
    return partial(
        _row,
        when_constrained=Constrained(constrained),
        formulations={"rnea": Formulation(recursive), "lagrange": by_lagrange(differentiated)},
        may_fail="reported",
        depends=("independent",),
    )


# Energies and power


def _energies(w: Workspace, of: Callable[[Workspace], tuple[Expr, Expr]]) -> list[Expr]:
    """Return the slopes of K, then those of P, by the columns of the regressor."""
    found = Linear.of(w)
    return substitute([one for row in found.slopes(of(found.workspace)) for one in row], {}, w.graph)


def _power(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> list[Expr]:
    """Return q̇ᵀ Y."""
    rows, count = _regressor(w, forces), len(columns(w))
    return [w.graph.total(u * rows[i * count + k] for i, u in enumerate(w.state.qd)) for k in range(count)]


# Rows of the table

_PER_UNIT = "N m or N, per unit of the parameter"

REGRESSORS: dict[str, Output] = {
    "regressor": _of_drives(lambda w: _regressor(w, driving), lambda w: _regressor(w, lagrange_driving))(
        "regressor Y(q, qd, qdd) of the driving forces tau = Y pi, pi the parameters that they are linear in",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, columns),
        _PER_UNIT,
        size=Size((0, 75)),
    ),
    "base_regressor": _of_drives(lambda w: chosen(w, w.once(felt)[1]), lambda w: chosen(w, base_by_lagrange(w)))(
        "base regressor Y(q, qd, qdd) of the driving forces tau = Y beta, beta the base parameters",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, base_columns),
        _PER_UNIT,
        size=Size((0, 50)),
    ),
    "energy_regressor": _row(
        "regressor Y(q, qd) of the energies [K; P] = Y pi, pi the parameters of the regressor",
        ("q", "qd"),
        "Y",
        (labels.fixed("kinetic", "potential"), columns),
        "J, per unit of the parameter",
        when_constrained="same",
        formulations={
            "recursive": Formulation(lambda w: _energies(w, Workspace.energies_by_momentum)),
            "lagrange": Formulation(lambda w: _energies(w, lambda there: (there.energy.K, there.energy.P))),
        },
    ),
    "power_regressor": _row(
        "regressor y(q, qd, qdd) of the power of the driving forces qd.tau = y.pi, pi the parameters of the regressor",
        ("q", "qd", "qdd"),
        "y",
        (columns,),
        "W, per unit of the parameter",
        when_constrained="tree",
        formulations={
            "rnea": Formulation(lambda w: _power(w, driving)),
            "lagrange": by_lagrange(lambda w: _power(w, lagrange_driving)),
        },
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""


def _reference(w: Workspace) -> tuple[Expr, ...]:
    return direction(w.graph, REFERENCE, w.state.n)


def _turned(w: Workspace) -> list[Expr]:
    """Return w_l = ½ Σ γ^l_kj q̇_k v_j, zero for rates of coordinates."""
    found, v = list(w.zeros), _reference(w)
    for (k, j), terms in w.directions.brackets.items():
        for m, value in terms:
            found[m] = found[m] + w.state.qd[k] * v[j] * value / 2
    return found


def _sum(*lists: Sequence[Expr]) -> list[Expr]:
    return [one.graph.total((one, *rest)) for one, *rest in zip(*lists, strict=True)]


def coriolis_times(w: Workspace) -> list[Expr]:
    """Return C(q, q̇) v, shape (n,), by recursion."""
    return polarised(w.reduced.without_gravity, w.state.qd, _reference(w), _turned(w))


def _by_matrix(w: Workspace) -> list[Expr]:
    """Return the matrix of Christoffel symbols times v."""
    C = w.composite_christoffel.coriolis_matrix(w.state.qd)
    return [w.graph.dot(row, _reference(w)) for row in C]


def _rest(w: Workspace) -> list[Expr]:
    """Return k_E - Q, what does not come from inertia or weight."""
    loads = rnea(w.reduced.without_gravity, w.zeros, w.zeros, w.loads)
    return [pull - push + load for pull, push, load in zip(w.elastic.forces, w.pushes, loads, strict=True)]


def _accelerations(w: Workspace) -> list[Expr]:
    return _sum(direction(w.graph, REFERENCE_RATE, w.state.n), _turned(w))


def _forces(w: Workspace) -> list[Expr]:
    return _sum(polarised(w.reduced, w.state.qd, _reference(w), _accelerations(w)), _rest(w))


def _forces_by_matrices(w: Workspace) -> list[Expr]:
    qdd = direction(w.graph, REFERENCE_RATE, w.state.n)
    inertial = [w.graph.dot(row, qdd) for row in w.composite_mass]
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
    along = tangents(at_rest, dict(zip(state.qd, _reference(w), strict=True)))
    return _sum(substitute(alone, moved), [one / 2 for one in along])


def _slotine_li_regressor(w: Workspace) -> list[Expr]:
    """Return the regressor by one recursion."""
    found: Base = w.once(base)
    forces = polarised(found.tree, w.state.qd, _reference(w), _accelerations(w))
    rows = [gradient(force, found.symbols) for force in forces]
    return chosen(w, [*zip(*rows, strict=True), *(_polarised(w, column) for column in w.once(others)[1])])


_passivity_row = partial(Output, when_constrained="tree", default_in="request")

PASSIVITY: dict[str, Output] = {
    "coriolis_times": _passivity_row(
        "Coriolis matrix of Christoffel symbols times a velocity, C(q, qd) qd_r",
        ("q", "qd", REFERENCE),
        "f",
        (labels.velocities,),
        FORCES,
        formulations={"rnea": Formulation(coriolis_times), "crba": Formulation(_by_matrix)},
        prefer=shorter_coriolis_times,
    ),
    "slotine_li_forces": _passivity_row(
        "driving forces along a reference, tau = M(q) qdd_r + C(q, qd) qd_r + g(q){pulls} - Q",
        ("q", "qd", REFERENCE, REFERENCE_RATE),
        "tau",
        (labels.velocities,),
        FORCES,
        formulations={"rnea": Formulation(_forces), "crba": Formulation(_forces_by_matrices)},
        prefer=shorter_coriolis_times,
    ),
    "slotine_li_regressor": _passivity_row(
        "regressor Y(q, qd, qd_r, qdd_r) of the driving forces along a reference, Y beta, beta the base parameters",
        ("q", "qd", REFERENCE, REFERENCE_RATE),
        "Y",
        (labels.velocities, base_columns),
        "N m or N, per unit of the parameter",
        formulations={
            "rnea": Formulation(_slotine_li_regressor),
            "lagrange": by_lagrange(lambda w: chosen(w, [_polarised(w, column) for column in base_by_lagrange(w)])),
        },
        size=Size((0, 46)),
    ),
}
"""Rows of the table, which a scene has when it is asked for them."""
