"""Derivatives of closed scenes along the manifold of their states, in each formulation.

    ξ, v     independent positions, of the rows that hold positions; independent velocities, of all rows
    J        [∂f/∂ξ | ∂f/∂v | ∂f/∂τ], dependent positions and velocities (and accelerations) moving along
    R        M u̇ + h - Gᵀ λ - τ, and C = G u̇ + γ, which vanish

With rolling there are more ξ than v. The same independent velocities serve all outputs; of inverse dynamics, which may
solve for other ones, too. The formulation "implicit" differentiates R and C at fixed u̇ and λ and solves what forward
dynamics solves once more:

    M δu̇ - Gᵀ δλ = -δR,    G δu̇ = -δC

and needs one tangent of unsolved equations a column; "recursive" takes that of the tree's forces from its recursion.
The other formulations differentiate what is solved, each its own. All of it is proved off the manifold too, where
M u̇ + h = τ + Gᵀ λ and G u̇ + γ = 0 hold as well.

Reference: Carpentier, Budhiraja and Mansard, Proximal and sparse resolution of constrained dynamic equations (2021),
section IV, for the derivatives of what is solved by those of what is not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.loops.constraint_rows import Constraints
from symdyn.dynamics.loops.manifold import Manifold, Seeds
from symdyn.dynamics.loops.reduced_rows import rows_of
from symdyn.dynamics.mechanism.row_solve import RowSolve
from symdyn.dynamics.outputs import closed_outputs as closed, recursive_derivatives
from symdyn.dynamics.outputs.derivative_outputs import along_all
from symdyn.dynamics.outputs.named_functions import multiplier_symbols
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, substitute, tangents

Columns = list[list[Expr]]
Entries = Callable[[Workspace], Sequence[Expr]]


def manifold_of(w: Workspace, formulation: str) -> Manifold:
    """Return the manifold as derivatives of a formulation take it."""
    return w.loops.differentiated_manifold if formulation == "lagrange" else w.loops.recursive_manifold


def along_manifold(w: Workspace, formulation: str, along: Sequence[str]) -> list[Seeds]:
    """Return how all symbols move, a column each; accelerations are no argument."""
    manifold = manifold_of(w, formulation)
    ways = {"q": manifold.by_position, "qd": manifold.by_velocity, "ui": manifold.by_velocity, "tau": manifold.by_force}
    return [one for name in along for one in ways[name]]


def along_motion(w: Workspace, formulation: str, along: Sequence[str]) -> list[Seeds]:
    """Return the same where accelerations are an argument: dependent ones move with positions and velocities too."""
    manifold, found = manifold_of(w, formulation), list[Seeds]()
    for name in along:
        if name == "qdd":
            found += manifold.by_acceleration
        else:
            found += map(manifold.accelerating, along_manifold(w, formulation, [name]))
    return found


WAYS: dict[str, Callable[[Workspace, str, Sequence[str]], list[Seeds]]] = {
    "manifold": along_manifold,
    "motion": along_motion,
    "free": lambda w, _, along: along_all(w, along),
}
"""How symbols move, column by column, by name: from the formulation and the arguments."""


# Formulations: each takes how symbols move, a key of `WAYS`, and the arguments along which derivatives are wanted


def by_row(columns: Columns, rows: int) -> list[Expr]:
    """Return the entries of columns, row by row."""
    return [column[i] for i in range(rows) for column in columns]


def tangent(of: Entries, formulation: str, w: Workspace, way: str, *along: str) -> list[Expr]:
    """Return J of entries that are solved already."""
    entries: Sequence[Expr] = w.once(of)
    return by_row([tangents(entries, one) for one in WAYS[way](w, formulation, along)], len(entries))


def equations(w: Workspace) -> list[Expr]:
    """Return R and C by recursion, shape (nv + kept rows,)."""
    return _equations(w, w.forces(list(w.state.qdd)), w.loops.recursive)


def lagrange_equations(w: Workspace) -> list[Expr]:
    """Return the same by Lagrange's equations."""
    return _equations(w, w.loops.lagrange_forces, w.loops.differentiated)


def _equations(w: Workspace, forces: Sequence[Expr], rows: Constraints) -> list[Expr]:
    loops, state = w.loops, w.state
    carried = loops.constraint_forces(multiplier_symbols(w), rows)
    motion = [f - x - tau for f, x, tau in zip(forces, carried, state.tau, strict=True)]
    return [*motion, *loops.gains(rows, loops.gamma(rows))]


def solution(w: Workspace, way: str) -> tuple[list[Expr], list[Expr]]:
    """Return u̇ and λ, of factors that their derivatives share."""
    _ = w.once(closed.forward)  # tells what moves no mass
    rest = [tau - h for tau, h in zip(w.state.tau, w.forces(w.still), strict=True)]
    gamma = w.loops.gamma(w.loops.recursive)
    return w.loops.solved(rest, gamma, w.prescribed.acceleration, _together(w, way))


def _together(w: Workspace, way: str) -> bool:
    """Whether all rows are taken at once: where a partition fails, which directions along the manifold need anyway."""
    return w.loops.decisions.fails and way == "free"


def implicit(w: Workspace, way: str, *along: str) -> Columns:
    """Return δR and δC, a column each, by differentiating the equations of motion before they are solved."""
    entries = w.once(equations)
    return _at_solution(w, way, [tangents(entries, one) for one in WAYS[way](w, "implicit", along)])


def by_recursion(w: Workspace, way: str, *along: str) -> Columns:
    """Return the same, forces of the tree differentiated along all directions by its recursion first."""
    n, tau = w.state.n, w.state.tau
    by_tree = recursive_derivatives.inverse_derivatives(w, ("q", "qd"))
    carried = w.loops.constraint_forces(multiplier_symbols(w))
    rest = [*(-x - force for x, force in zip(carried, tau, strict=True)), *w.once(equations)[n:]]
    sides = []
    for seeds, step in zip(WAYS[way](w, "implicit", along), _steps(w, way, along), strict=True):
        moved = tangents(rest, seeds)
        for i in range(n):
            moved[i] = moved[i] + w.graph.total(by_tree[2 * n * i + k] * x for k, x in step.items())
        sides.append(moved)
    return _at_solution(w, way, sides)


def _steps(w: Workspace, way: str, along: Sequence[str]) -> list[dict[int, Expr]]:
    """Return how directions (from 0) and velocities (from nv) move, a column each."""
    n, every = w.state.n, w.loops.recursive_manifold.slopes
    slopes = every if way == "manifold" else [{k: w.graph.one} for k in range(n)]
    slopes = slopes if "q" in along else []
    return [
        (slopes[k] if k < len(slopes) else {}) | {n + i: seeds[u] for i, u in enumerate(w.state.qd) if u in seeds}
        for k, seeds in enumerate(WAYS[way](w, "implicit", along))
    ]


def _at_solution(w: Workspace, way: str, sides: Columns) -> Columns:
    """Return δR and δC at u̇ and λ, from those at symbols for them."""
    accelerations, multipliers = w.once(solution, way)
    known = dict(zip((*w.state.qdd, *multiplier_symbols(w)), (*accelerations, *multipliers), strict=True))
    return [substitute(one, known) for one in sides]


Sides = Callable[..., Columns]


def _solved_from(by: Sides, w: Workspace, way: str, *along: str) -> list[tuple[list[Expr], list[Expr]]]:
    """Return δu̇ and δλ of every column."""
    n, together = w.state.n, _together(w, way)
    found = [w.loops.solved([-x for x in one[:n]], one[n:], together=together) for one in w.once(by, way, *along)]
    for k, (pulled, _) in enumerate(found[-n:] if along[-1] == "tau" else ()):  # symmetric in fact: one of each pair
        for j in range(k):
            pulled[j] = found[j - n][0][k]
    return found


def columns_of(by: Sides, part: int, w: Workspace, way: str, *along: str) -> list[Expr]:
    """Return J of u̇ (part 0) or λ (part 1), from δR and δC that one of the two above finds."""
    columns = [one[part] for one in w.once(_SOLVED[by], way, *along)]
    return by_row(columns, len(w.loops.decisions.kept) if part else w.state.n)


_SOLVED = {by: partial(_solved_from, by) for by in (implicit, by_recursion)}
"""What is found from their sides, each a derivation that workspaces know."""


def solve_of(by: Sides, part: int, w: Workspace, way: str, *along: str) -> RowSolve | None:
    """Return what J of u̇ or λ is solved from; None where that is not by blocks of a partition."""
    n, given = w.state.n, w.loops.partitioned
    if _together(w, way) or not given.motion.independent:
        return None
    columns = w.once(by, way, *along)
    sides = [tuple(column[i] for column in columns) for i in range(len(columns[0]))]
    rows = rows_of(given, [tuple(-x for x in side) for side in sides[:n]], sides[n:], bool(part))
    size = len(w.loops.decisions.kept) if part else n
    beside = ((None,) * len(columns),) * size
    return RowSolve(w.scene, tuple(rows.sides.items()), rows.count, tuple(rows.steps), beside)


def carried_forces(w: Workspace) -> list[Expr]:
    """Return f - Gᵀ λ at fixed λ: the drives of inverse dynamics, once λ is what its partition finds."""
    forces = w.forces(list(w.state.qdd))
    return [f - x for f, x in zip(forces, w.loops.constraint_forces(multiplier_symbols(w)), strict=True)]


def driven(w: Workspace, moved: Sequence[Expr]) -> list[Expr]:
    """Return how the drives change, from how what is carried does at fixed λ."""
    loops = w.loops
    known = dict(zip(multiplier_symbols(w), w.once(closed.carried), strict=True))
    changes = substitute(moved, known)
    G = loops.G(loops.recursive)
    return loops.at_drives(changes, G, loops.driven.solve_transposed(G, changes))


def implicit_inverse(w: Workspace, way: str, *along: str) -> list[Expr]:
    """Return J of the drives, by differentiating what is carried before it is."""
    entries = w.once(carried_forces)
    return by_row([driven(w, tangents(entries, one)) for one in WAYS[way](w, "implicit", along)], w.state.n)


def slopes_of_velocities(w: Workspace, way: str, *along: str) -> list[Expr]:
    """Return S and T, in terms of the independent velocities."""
    known = dict(zip(w.state.qd, w.once(closed.velocities), strict=True))
    seeds = WAYS[way](w, "partition", along)
    return by_row([substitute([one.get(u, w.graph.zero) for u in w.state.qd], known) for one in seeds], w.state.n)


def normal_slopes_of_velocities(w: Workspace, _: str, *along: str) -> list[Expr]:
    """Return the same by normal equations, differentiated."""
    manifold, u = w.loops.differentiated_manifold, w.state.qd
    free = {"q": manifold.by_position, "ui": [{u[k]: w.graph.one} for k in manifold.partition.independent]}
    entries: list[Expr] = w.once(closed.normal_velocities)
    return by_row([tangents(entries, one) for name in along for one in free[name]], w.state.n)


def slopes_of_positions(manifold: Callable[[Workspace], Manifold], w: Workspace, *_: str) -> list[Expr]:
    """Return T_h row by row."""
    columns = manifold(w).slopes
    return by_row([[column.get(k, w.graph.zero) for k in range(w.state.n)] for column in columns], w.state.n)
