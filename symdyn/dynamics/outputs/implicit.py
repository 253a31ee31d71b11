"""Derivatives by the implicit function theorem: one rule for trees and closed scenes, for Jacobians and products.

    x        arguments: q, u and driving forces τ, or independent ones of them
    y        solution of R(x, y) = 0: u̇, and multipliers λ where loops, contacts or other constraints are
    M, h     mass matrix, and forces of velocities, gravity and loads; G, γ constraint rows: G u̇ + γ = 0
    R        M u̇ + h - Gᵀ λ - τ (`loops.reduction`), then -(G u̇ + γ); a tree's without λ
    K        ∂R/∂y, symmetric, factored by forward dynamics already

    J        = -K⁻¹ ∂R/∂x       a right-hand side for each column
    J d      = -K⁻¹ δR          δR is the derivative of R along d at fixed y
    wᵀ J     = -μᵀ ∂R/∂x        K μ = w, weights of the entries of y; one reverse sweep at fixed y and μ

d is a direction of x; as an index it means dependent velocities of a partition, i independent ones.

x varies in a `TangentSpace`. Where a motion is prescribed its equation determines the driving force, and K⁻¹ is zero
there. Driving forces of closed scenes by the same rule: R is f - Gᵀ λ - τ, y are λ, which G_dᵀ determines at passive
velocities, and then τ at the others, which alone are returned.

All other formulations differentiate their own solutions. All of it is proved off the constraint manifold too, where
M u̇ + h = τ + Gᵀ λ and G u̇ + γ = 0 hold as well.

Reference: Carpentier, Budhiraja and Mansard, Proximal and sparse resolution of constrained dynamic equations (2021),
section IV, on derivatives of solutions by those of the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.loops.constraint_rows import Constraints
from symdyn.dynamics.loops.reduction import rows_of
from symdyn.dynamics.mechanism.linear_solve import RowSolve, solve
from symdyn.dynamics.outputs import constrained_outputs as closed, recursive_derivatives, tree_formulations
from symdyn.dynamics.outputs.named_functions import WEIGHTS, direction, multiplier_symbols
from symdyn.dynamics.outputs.tangent_space import FREE, TangentSpace, by_row, cheaper
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.tree_dynamics import aba
from symdyn.frozen import dataclass
from symdyn.graph import Expr, LocalPartials, substitute, tangents


@dataclass(frozen=True)
class Implicit:
    """Equations R(x, y) = 0 and their solution y."""

    symbols: tuple[Expr, ...]  # those of y in R
    residual: Callable[[], Sequence[Expr]]  # returns R
    values: Callable[[], Sequence[Expr]]  # returns y in terms of x
    solve: Callable[[Sequence[Expr]], list[Expr]]  # returns K⁻¹ r for r of R's shape

    def at_solution(self, moved: Sequence[Expr]) -> list[Expr]:
        """Return -δR at y, from δR at symbols for it."""
        return [-x for x in substitute(moved, dict(zip(self.symbols, self.values(), strict=True)))]


Equations = Callable[[Workspace, TangentSpace], Implicit]

# The equations of motion


def motion(w: Workspace, space: TangentSpace) -> Implicit:
    """Return the equations of motion, solved for accelerations, then multipliers."""
    if not w.scene.is_constrained:

        def unbalanced() -> list[Expr]:
            return [force - tau for force, tau in zip(w.forces(list(w.state.qdd)), w.state.tau, strict=True)]

        return Implicit(w.state.qdd, unbalanced, lambda: tree_formulations.forward(w), partial(_accelerated, w))
    n, at_once = w.state.n, _all_at_once(w, space)

    def residual() -> list[Expr]:
        found = w.once(equations)
        return [*found[:n], *(-x for x in found[n:])]

    def solved(sides: Sequence[Expr]) -> list[Expr]:
        x, found = w.loops.solved(sides[:n], sides[n:], at_once=at_once)
        return [*x, *found]

    return Implicit((*w.state.qdd, *multiplier_symbols(w)), residual, partial(w.once, _solution, space), solved)


def _solution(w: Workspace, space: TangentSpace) -> list[Expr]:
    """Return u̇ and λ of a closed scene, by factors that their derivatives share."""
    _ = w.once(closed.forward)  # raises where a motion moves no mass
    rest = [tau - h for tau, h in zip(w.state.tau, w.forces(w.zeros), strict=True)]
    gamma = w.loops.gamma(w.loops.recursive)
    accelerations, multipliers = w.loops.solved(rest, gamma, w.prescribed.acceleration, _all_at_once(w, space))
    return [*accelerations, *multipliers]


def _accelerated(w: Workspace, forces: Sequence[Expr]) -> list[Expr]:
    """Return M⁻¹ f as forward dynamics of a tree finds it; 0 where a motion is prescribed."""
    if w.once(tree_formulations.cheaper_forward) == "aba":
        return aba(w.recursion_tree.without_gravity, w.zeros, forces)
    free, found = w.prescribed.free, [w.graph.zero] * w.state.n
    M = [[w.composite_mass[i][j] for j in free] for i in free]
    for k, x in zip(free, solve(w.tree.velocity_parents(free), M, [forces[k] for k in free]), strict=True):
        found[k] = x
    return found


def _all_at_once(w: Workspace, space: TangentSpace) -> bool:
    """Whether all constraints are solved at once: where a partition fails, but along the constraint manifold."""
    return w.loops.decisions.fails and space is FREE


def equations(w: Workspace) -> list[Expr]:
    """Return M u̇ + h - Gᵀ λ - τ and G u̇ + γ of a closed scene by recursion, shape (nv + m,)."""
    return _equations(w, w.forces(list(w.state.qdd)), w.loops.recursive)


def lagrange_equations(w: Workspace) -> list[Expr]:
    """Return the same by Lagrange's equations."""
    return _equations(w, w.loops.lagrange_forces, w.loops.differentiated)


def _equations(w: Workspace, forces: Sequence[Expr], rows: Constraints) -> list[Expr]:
    loops, state = w.loops, w.state
    exerted = loops.constraint_forces(multiplier_symbols(w), rows)
    left = [f - x - tau for f, x, tau in zip(forces, exerted, state.tau, strict=True)]
    return [*left, *loops.acceleration_residual(rows, loops.gamma(rows))]


def drives(w: Workspace, _: TangentSpace) -> Implicit:
    """Return the equations of inverse dynamics of a closed scene, solved for multipliers."""
    symbols, loops = multiplier_symbols(w), w.loops

    def residual() -> list[Expr]:
        forces = w.forces(list(w.state.qdd))
        return [f - x for f, x in zip(forces, loops.constraint_forces(symbols), strict=True)]

    def solved(sides: Sequence[Expr]) -> list[Expr]:
        return loops.drives_of([-x for x in sides])

    return Implicit(symbols, residual, partial(w.once, closed.inverse_multipliers), solved)


# Parts of y


def accelerations(w: Workspace) -> slice:
    """Return the indices of accelerations, or of driving forces, in y."""
    return slice(w.state.n)


def multipliers(w: Workspace) -> slice:
    """Return the indices of multipliers in y."""
    return slice(w.state.n, None)


Part = Callable[[Workspace], slice]

# J d and wᵀ J


def jvp(of: Equations, part: Part, space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    """Return J d."""
    known: Implicit = w.once(of, space)
    seeds, residual = space.direction(w, "", along), known.residual()

    def changes(slopes: LocalPartials) -> list[Expr]:
        return known.solve(known.at_solution(tangents(residual, seeds, slopes)))[part(w)]

    return cheaper(w, residual, changes)


def vjp(of: Equations, part: Part, space: TangentSpace, along: Sequence[str], w: Workspace) -> list[Expr]:
    """Return wᵀ J."""
    known: Implicit = w.once(of, space)
    weights = [w.graph.zero] * len(known.symbols)
    weights[part(w)] = direction(w.graph, WEIGHTS, len(weights[part(w)]))
    mu = known.solve(weights)
    fixed = direction(w.graph, "mu", len(mu))
    phi = w.graph.total(-a * x for a, x in zip(fixed, known.residual(), strict=True))
    values = dict(zip((*known.symbols, *fixed), (*known.values(), *mu), strict=True))
    return cheaper(w, [phi], lambda slopes: substitute(space.pullback(w, "", along, phi, slopes), values))


# J, column by column, of closed scenes; that of a tree is solved by the factors of M of its own recursion

Columns = list[list[Expr]]


def _by_sweeps(w: Workspace, of: Equations, space: TangentSpace, along: Sequence[str]) -> Columns:
    """Return δR, a column each, by forward-mode differentiation."""
    residual = w.once(of, space).residual()
    return [tangents(residual, one) for one in space.seeds(w, "", along)]


def _by_recursion(w: Workspace, of: Equations, space: TangentSpace, along: Sequence[str]) -> Columns:
    """Return the same, with derivatives of the tree's forces by its recursion."""
    n, tau = w.state.n, w.state.tau
    by_tree = recursive_derivatives.inverse_derivatives(w, ("q", "qd"))
    known: Implicit = w.once(of, space)
    exerted = w.loops.constraint_forces(multiplier_symbols(w))
    rest = [*(-x - force for x, force in zip(exerted, tau, strict=True)), *known.residual()[n:]]
    found = []
    for seeds, step in zip(space.seeds(w, "", along), _steps(w, space, along), strict=True):
        moved = tangents(rest, seeds)
        for i in range(n):
            moved[i] = moved[i] + w.graph.total(by_tree[2 * n * i + k] * x for k, x in step.items())
        found.append(moved)
    return found


def _steps(w: Workspace, space: TangentSpace, along: Sequence[str]) -> list[dict[int, Expr]]:
    """Return derivatives of directions (from 0) and velocities (from nv), a column each."""
    n, every = w.state.n, w.loops.recursive_manifold.position_tangents
    slopes = [{k: w.graph.one} for k in range(n)] if space is FREE else every
    slopes = slopes if "q" in along else []
    return [
        (slopes[k] if k < len(slopes) else {}) | {n + i: seeds[u] for i, u in enumerate(w.state.qd) if u in seeds}
        for k, seeds in enumerate(space.seeds(w, "", along))
    ]


SIDES = {"implicit": _by_sweeps, "recursive": _by_recursion}
"""How δR is computed, by the name of the formulation."""


def _sides(w: Workspace, of: Equations, formulation: str, space: TangentSpace, *along: str) -> Columns:
    """Return -δR at y, a column each."""
    known: Implicit = w.once(of, space)
    return [known.at_solution(one) for one in SIDES[formulation](w, of, space, along)]


def _changes(w: Workspace, of: Equations, formulation: str, space: TangentSpace, *along: str) -> Columns:
    """Return δy, a column each."""
    n, known = w.state.n, w.once(of, space)
    found: Columns = [known.solve(one) for one in w.once(_sides, of, formulation, space, *along)]
    for k, column in enumerate(found[-n:] if along[-1] == "tau" else ()):  # symmetric: one triangle
        for j in range(k):
            column[j] = found[j - n][k]
    return found


def jacobian(
    of: Equations, part: Part, formulation: str, space: TangentSpace, along: tuple[str, ...], w: Workspace
) -> list[Expr]:
    """Return J, row by row."""
    columns = [one[part(w)] for one in w.once(_changes, of, formulation, space, *along)]
    return by_row(columns, len(columns[0]) if columns else 0)


def row_solve(
    part: Part, formulation: str, space: TangentSpace, along: tuple[str, ...], w: Workspace
) -> RowSolve | None:
    """Return the steps that solve for J of the equations of motion; None where no partition is used."""
    n, given, m = w.state.n, w.loops.partitioned, len(w.loops.decisions.independent_rows)
    if _all_at_once(w, space) or not given.motion.independent:
        return None
    columns = w.once(_sides, motion, formulation, space, *along)
    sides = list(zip(*columns, strict=True))
    rows = rows_of(given, sides[:n], sides[n:], part is multipliers)
    beside = ((None,) * len(columns),) * (m if part is multipliers else n)
    return RowSolve(w.scene, tuple(rows.sides.items()), rows.count, tuple(rows.steps), beside)
