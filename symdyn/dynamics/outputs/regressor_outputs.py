"""Regressors: driving forces, power and energies as a matrix times the parameters that they are linear in.

    τ = Y(q, q̇, q̈) π + r           r: what depends on none of the columns' parameters, zero in most scenes

    regressor          π: ten parameters of every body about its frame, m, m r, I; armatures, damping, dry friction,
                       stiffness and preload of springs, loads: by the names of `--symbolic all`, or of the scene's own
                       parameters where one stands there
    base_regressor     the fewest columns that span the same forces: base parameters of the moving bodies in the link
                       frames that the generator chose (`reduced_tree`), by second moments J; equal columns are one

`linear_forces` says what is a column, `base_columns` which few do as well.

Reference: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and links (1986); Khalil
and Dombre (2002), chapters 9 and 12; Gautier and Khalil (1990).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.outputs import result_labels as labels
from symdyn.dynamics.outputs.base_columns import (
    BaseColumns,
    Linear,
    base_by_lagrange,
    base_columns,
    chosen,
    columns,
    driving,
    felt,
    lagrange_driving,
)
from symdyn.dynamics.outputs.closed_outputs import lagrange_drives_of
from symdyn.dynamics.outputs.output import Constrained, Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute
from symdyn.scene import Scene


def _regressor(w: Workspace, forces: Callable[[Workspace], list[Expr]]) -> list[Expr]:
    """Return Y row by row, on the graph of the workspace."""
    found = Linear.of(w)
    rows = found.slopes(forces(found.workspace))
    return substitute([one for row in rows for one in row], {}, w.graph)


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


def _of_drives(
    recursive: Callable[[Workspace], list[Expr]], differentiated: Callable[[Workspace], list[Expr]]
) -> Constrained:
    """Return the row of scenes with loops, for the formulations of the regressor of a tree."""
    return Constrained(
        {
            "rnea": Formulation(lambda w: _driven(w, recursive(w), lambda _, forces: w.loops.drives_of(forces))),
            "lagrange": by_lagrange(lambda w: _driven(w, differentiated(w), lagrange_drives_of)),
        }
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


def _whole(w: Workspace) -> list[Expr]:
    return _regressor(w, driving)


def _whole_by_lagrange(w: Workspace) -> list[Expr]:
    return _regressor(w, lagrange_driving)


def _fewest(w: Workspace) -> list[Expr]:
    return chosen(w, w.once(felt)[1])


def _fewest_by_lagrange(w: Workspace) -> list[Expr]:
    return chosen(w, base_by_lagrange(w))


_row = partial(Output, default_in="request")
_PER_UNIT = "N m or N, per unit of the parameter"

REGRESSORS: dict[str, Output] = {
    "regressor": _row(
        "regressor Y(q, qd, qdd) of the driving forces tau = Y pi, pi the parameters that they are linear in",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, columns),
        _PER_UNIT,
        when_constrained=_of_drives(_whole, _whole_by_lagrange),
        formulations={"rnea": Formulation(_whole), "lagrange": by_lagrange(_whole_by_lagrange)},
        size=Size((0, 75)),
        may_fail="reported",
        depends=("independent",),
    ),
    "base_regressor": _row(
        "base regressor Y(q, qd, qdd) of the driving forces tau = Y beta, beta the base parameters",
        ("q", "qd", "qdd"),
        "Y",
        (labels.velocities, base_columns),
        _PER_UNIT,
        when_constrained=_of_drives(_fewest, _fewest_by_lagrange),
        formulations={"rnea": Formulation(_fewest), "lagrange": by_lagrange(_fewest_by_lagrange)},
        size=Size((0, 50)),
        may_fail="reported",
        depends=("independent",),
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
