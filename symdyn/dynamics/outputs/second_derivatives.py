"""All second derivatives of inverse dynamics, packed: entries of velocities on one way from the ground to a tip.

    H[i][k][j] = X_j X_k τ_i     as `NAME_second_derivatives` has it, rows k and columns j over q, q̇, q̈
    packed       those that need not vanish, each once: in order for every velocity d, for every m on its way from the
                 ground, then the runs of `recursive.second_order` along the velocities s on the way of m

What is beside bodies, springs, friction, declared forces, is differentiated on the graph; it has a place where it does
not tie one branch to another.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from symdyn.dynamics.mechanism.linear_solve import RowSolve
from symdyn.dynamics.outputs.derivative_outputs import derived, differentiable, entries_of
from symdyn.dynamics.outputs.directional_outputs import PACKED_TENSOR
from symdyn.dynamics.outputs.output import Formulation, Output, Size
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.dynamics.outputs.recursive_derivatives import beside_bodies, forward_with_factors
from symdyn.dynamics.outputs.tangent_space import COLUMNS, FREE, by_row
from symdyn.dynamics.outputs.workspace import Matrix, Workspace
from symdyn.dynamics.recursive.pair_runs import PairRuns
from symdyn.dynamics.recursive.second_order import Velocities, places
from symdyn.errors import DerivationError
from symdyn.graph import Expr, substitute, tangents
from symdyn.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

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
    import numpy as np  # equations and code are made without

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
            f"{w.scene.name}: packed second derivatives are of trees whose joints have velocities of their own, and "
            f"{why}; ask for {OF}_hessian or {OF}_hessian_vector, or the same of forward_dynamics"
        )
    return places(Velocities.of(w.whole.parent, w.whole.block))


def _recursive(w: Workspace) -> list[Expr]:
    """Return the packed entries by recursion, and what is beside bodies."""
    at, runs = w.once(_places), w.once(pair_runs)
    found = PairRuns.composed(runs.velocities, runs.numbers)
    place = {one: k for k, one in enumerate(at)}
    for one, value in w.once(_beside).items():
        if one not in place:
            raise DerivationError(
                f"{w.scene.name}: packed second derivatives are of forces along one way from the ground to a tip, and "
                f"a spring, load or formula ties others; ask for {OF}_hessian or {OF}_hessian_vector, or the same "
                f"of forward_dynamics"
            )
        found[place[one]] = found[place[one]] + value
    return found


def pair_runs(w: Workspace) -> PairRuns:
    """Return what they are composed of, but for what is beside bodies."""
    return PairRuns.of(w.scene, w.whole, w.state.qd, w.state.qdd)


def _in_runs(w: Workspace) -> PairRuns | None:
    """Return the same where nothing is beside bodies."""
    return None if w.once(_beside) else w.once(pair_runs)


def _beside(w: Workspace) -> Mapping[Place, Expr]:
    """Return second derivatives of what inverse dynamics finds beside what bodies need, those that are not zero."""
    forces = [w.graph.total(parts) for parts in zip(*beside_bodies(w), strict=True)]
    directions, known = FREE.seeds(w, "", ("q", "qd", "qdd")), set(w.once(_places))
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


def _pairs(w: Workspace) -> list[tuple[int, int]]:
    """Return the columns of packed second derivatives of forward dynamics: k before j, but for two of one joint."""
    n, shared = w.state.n, Velocities.of(w.whole.parent, w.whole.block).own
    every = range(n)
    return [
        *((k, j) for k in every for j in every if j <= k or j in shared[k]),
        *((k, n + j) for k in every for j in every),
        *((n + k, n + j) for k in every for j in range(k + 1)),
        *((k, 2 * n + j) for k in every for j in every),
    ]


def _sides(w: Workspace) -> Matrix:
    """Return the right sides -(X_j X_k τ_i + X_k M_il X_j u̇_l + X_j M_il X_k u̇_l) at u̇ of forward dynamics."""
    n, known = w.state.n, w.once(forward_with_factors)
    moving = dict(zip(w.state.qdd, known.accelerations, strict=True))
    tensor = dict(zip(w.once(_places), substitute(w.once(_recursive), moving), strict=True))
    for (i, k, j), value in list(tensor.items()):
        tensor.setdefault((i, j, k), value)
        if j >= 2 * n:
            tensor.setdefault((j - 2 * n, k, 2 * n + i), value)
    mass: dict[tuple[int, int], list[tuple[int, Expr]]] = {}  # X_k M_il by i and k
    for (i, k, j), value in tensor.items():
        if k < n and j >= 2 * n and not value.is_zero:
            mass.setdefault((i, k), []).append((j - 2 * n, value))
    slopes = [found for name in ("q", "qd", "tau") for found in zip(*known.jacobians[name], strict=True)]
    zero, rows = w.graph.zero, list[list[Expr]]()
    for i in range(n):
        row = []
        for k, j in w.once(_pairs):
            parts = [tensor.get((i, k, j), zero)] if j < 2 * n else []
            parts += [value * slopes[j][m] for m, value in mass.get((i, k), ())]
            parts += [value * slopes[k][m] for m, value in mass.get((i, j), ())]
            row.append(-w.graph.total(parts))
        rows.append(row)
    return rows


def _solved(w: Workspace) -> list[Expr]:
    """Return the second derivatives of forward dynamics, row by row, by the implicit relation."""
    return [entry for row in w.once(forward_with_factors).factors.solve(w.once(_sides)) for entry in row]


def _row_solve(w: Workspace) -> RowSolve:
    n, steps = w.state.n, w.once(forward_with_factors).factors.steps(range(w.state.n))
    beside = ((None,) * len(w.once(_pairs)),) * n
    return RowSolve(w.scene, tuple(enumerate(map(tuple, w.once(_sides)))), n, steps, beside)


def _forward_by_sweeps(w: Workspace) -> list[Expr]:
    """Return the same by differentiation of forward dynamics."""
    w.once(_places)
    entries, directions = entries_of(w, OUTPUTS["forward_dynamics"]), FREE.seeds(w, "", ("q", "qd", "tau"))
    slopes = [tangents(entries, one) for one in directions]
    return by_row([tangents(slopes[k], directions[j]) for k, j in w.once(_pairs)], w.state.n)


def _columns(w: Workspace) -> tuple[str, ...]:
    names = [f"{name} of {one}" for name in ("q", "qd", "tau") for one in w.scene.velocities]
    return tuple(f"by {names[k]}, {names[j]}" for k, j in w.once(_pairs))


PACKED: dict[str, Output] = {
    f"{OF}{PACKED_TENSOR}": derived(
        OUTPUTS[OF],
        differentiable(OUTPUTS[OF]),
        text="second derivatives X_j X_k tau_i that need not vanish, each once: for every velocity d, every m on its "
        "way from the ground, runs along all s on the way of m, listed in docs/derivatives.md under Packed; "
        "symdyn.dynamics.second_derivative_places(scene) returns i, k, j of every entry; of " + OUTPUTS[OF].text,
        formulations={"recursive": Formulation(_recursive, solve=_in_runs), "forward": Formulation(_by_sweeps)},
        when_constrained="refuse",
        axes=(_labels,),
        result="ddtau",
        units=f"{OUTPUTS[OF].units}, per units of what moves",
        size=Size((500.0, 120.0, 22.5)),
    ),
    f"forward_dynamics{PACKED_TENSOR}": derived(
        OUTPUTS["forward_dynamics"],
        differentiable(OUTPUTS["forward_dynamics"]),
        text="second derivatives X_j X_k qdd_i, a column for each k, j: both of q with j up to k, or of one joint; q "
        "and qd; both of qd with j up to k; q and tau; all others vanish, or follow by exchange; of "
        + OUTPUTS["forward_dynamics"].text,
        formulations={"implicit": Formulation(_solved, solve=_row_solve), "forward": Formulation(_forward_by_sweeps)},
        when_constrained="refuse",
        axes=(COLUMNS["qd"], _columns),
        result="ddqdd",
        units=f"{OUTPUTS['forward_dynamics'].units}, per units of what moves",
        size=Size((100.0, 20.0, 45.0, 9.0)),
    ),
}
"""Rows that are asked for by their names alone."""
