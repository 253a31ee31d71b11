"""All second derivatives of inverse dynamics, packed: entries of velocities on one way from the ground to a tip.

    H[i][k][j] = X_j X_k τ_i     as `NAME_second_derivatives` has it, rows k and columns j over q, q̇, q̈
    packed       those that need not vanish, each once: in order for every velocity d, for every m on its way from the
                 ground, then the runs of `recursive.second_order` along the velocities s on the way of m

What is beside bodies, springs, friction, declared forces, is differentiated on the graph; it has a place where it does
not tie one branch to another.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from symdyn.dynamics.outputs.derivative_outputs import derived, differentiable, entries_of
from symdyn.dynamics.outputs.output import Formulation, Output, Size
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.recursive_derivatives import beside_bodies
from symdyn.dynamics.outputs.tangent_space import COLUMNS, FREE
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.second_order import Velocities, places, second_order
from symdyn.errors import DerivationError
from symdyn.graph import Expr, tangents
from symdyn.scene import Scene

PACKED_TENSOR = "_second_derivatives_packed"
"""Behind the name of an output that has them."""

OF = "inverse_dynamics"

Place = tuple[int, int, int]


def second_derivative_places(scene: Scene) -> npt.NDArray[np.int64]:
    """Return where the entries of `inverse_dynamics_second_derivatives_packed` stand in the whole, shape (P, 3).

    Columns are i, k, j: entry n is X_j X_k τ_i, rows k and columns j count all velocities of q, then of q̇, of q̈.
    What stands at no such place is 0, or the same by exchange: of k and j, where not both are positions of one joint
    that has a quaternion, or of i and that of q̈.

    Raises:
        DerivationError: the scene is no tree of joints with velocities of their own.
    """
    return np.array(_places(Workspace(scene)), dtype=np.int64).reshape(-1, 3)


def _places(w: Workspace) -> list[Place]:
    """Return the places of packed entries; DerivationError where a scene has no such packed order."""
    reasons = {
        "loops or rows close it": w.scene.is_constrained,
        "helical or coupled joints share velocities": w.scene.is_constrained or w.whole.coupled,
        "motions are prescribed": any(joint.motion is not None for joint in w.scene.joints),
    }
    if why := next((words for words, found in reasons.items() if found), ""):
        raise DerivationError(
            f"{w.scene.name}: {OF}{PACKED_TENSOR} is of trees whose joints have velocities of their own, and {why}; "
            f"ask for {OF}_hessian or {OF}_hessian_vector"
        )
    return places(Velocities.of(w.whole.parent, w.whole.block))


def _recursive(w: Workspace) -> list[Expr]:
    """Return the packed entries by recursion, and what is beside bodies."""
    at = w.once(_places)
    found = second_order(w.whole, w.state.qd, w.state.qdd)
    place = {one: k for k, one in enumerate(at)}
    for one, value in _beside(w).items():
        if one not in place:
            raise DerivationError(
                f"{w.scene.name}: {OF}{PACKED_TENSOR} is of forces along one way from the ground to a tip, and a "
                f"spring, load or formula ties others; ask for {OF}_hessian or {OF}_hessian_vector"
            )
        found[place[one]] = found[place[one]] + value
    return found


def _beside(w: Workspace) -> Mapping[Place, Expr]:
    """Return second derivatives of what inverse dynamics finds beside what bodies need, those that are not zero."""
    forces = [w.graph.total(parts) for parts in zip(*beside_bodies(w), strict=True)]
    directions, n, known = FREE.seeds(w, "", ("q", "qd", "qdd")), w.state.n, set(w.once(_places))
    found = {}
    for i, force in enumerate(forces):
        for k, first in enumerate(directions):
            (slope,) = tangents([force], first)
            for j, second in enumerate([] if slope.is_zero else directions):
                (value,) = tangents([slope], second)
                if not value.is_zero and not ((i, k, j) not in known and (i, j, k) in known):
                    found[i, k, j] = value
    return found


def _by_sweeps(w: Workspace) -> list[Expr]:
    """Return the packed entries by differentiation of inverse dynamics, a sweep forward for each row and column."""
    at, directions = w.once(_places), FREE.seeds(w, "", ("q", "qd", "qdd"))
    entries = entries_of(w, OUTPUTS[OF])
    slopes = [tangents(entries, one) for one in directions]
    wanted: dict[int, dict[tuple[int, int], int]] = {}
    for i, k, j in at:
        wanted.setdefault(j, {})[i, k] = 0
    found: dict[Place, Expr] = {}
    for j, some in wanted.items():
        values = tangents([slopes[k][i] for i, k in some], directions[j])
        found |= {(i, k, j): value for (i, k), value in zip(some, values, strict=True)}
    return [found[one] for one in at]


def _labels(w: Workspace) -> tuple[str, ...]:
    """Return what the packed entries stand for: the force, and along what it is differentiated."""
    columns = [f"{name} of {one}" for name in differentiable(OUTPUTS[OF]) for one in COLUMNS["qd"](w)]
    forces = COLUMNS["qd"](w)
    return tuple(f"force on {forces[i]} by {columns[k]}, {columns[j]}" for i, k, j in w.once(_places))


PACKED: dict[str, Output] = {
    f"{OF}{PACKED_TENSOR}": derived(
        OUTPUTS[OF],
        differentiable(OUTPUTS[OF]),
        text="second derivatives X_j X_k tau_i that need not vanish, each once: for every velocity d, every m on its way "
        "from the ground, runs along the velocities s on the way of m, their joints' own included, by i; k, j: "
        "d; m, s.qdd* | d; m.qd, s.qd | d; s, m.qd | d; m, s.qd* | d; m, s || m; d, s.qdd | m; d.qd, s.qd | m; s, d.qd "
        "| m; d, s.qd | m; d, s || s; d.qd, m.qd* | s; m, d.qd* | s; d, m.qd* | s; d, m*; a run with * ends before the "
        "joint of m, those between || and the last but one are there where d and m belong to different joints; of "
        + OUTPUTS[OF].text,
        formulations={"recursive": Formulation(_recursive), "forward": Formulation(_by_sweeps)},
        when_constrained="refuse",
        axes=(_labels,),
        result="ddtau",
        units=f"{OUTPUTS[OF].units}, per units of what moves",
        size=Size((500.0, 120.0, 22.5)),
    )
}
"""Rows that are asked for by their names alone."""
