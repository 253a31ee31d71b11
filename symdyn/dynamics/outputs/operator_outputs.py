"""Outputs that solve with the mass matrix, spread forces over redundant rows, or sum up the ground: rows of OUTPUTS.

    M        mass matrix = Lᵀ D L, L unit lower triangular; no entry of L stands between velocities of two branches
    G, λ     independent rows of loops and their multipliers; G_d those that they imply, = B G
    λ', μ    multipliers of both of least norm: λ' + Bᵀ μ = λ, so that (1 + B Bᵀ) μ = B λ

Of the same forces, C y with Cᵀ C y = G f has the least norm, where C = [G; G_d] Gᵀ and f = Gᵀ λ: the other formulation.

    f, n_O   force of the ground on all that moves, its moment about the origin: rates of momentum less weight
    e        up, against gravity
    p        e × n_O / (f·e), centre of pressure on the plane through the origin across e: no moment along it

References: Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.5; Golub and Van Loan, Matrix Computations
(2013), section 5.5; Sardain and Bessonnet, Forces acting on a biped robot, IEEE Trans. SMC A 34 (2004) 630.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.loops.partition import squared
from symdyn.dynamics.mechanism import centroidal
from symdyn.dynamics.mechanism.linear_solve import Factored, factored, solve
from symdyn.dynamics.outputs import constrained_outputs, result_labels as labels, tree_formulations as formulations
from symdyn.dynamics.outputs.named_functions import RIGHT, direction
from symdyn.dynamics.outputs.output import Formulation, Output, Size, by_differentiation, by_lagrange
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.dynamics.recursive.tree_dynamics import aba
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.spatial import add, cross, dot, scale


def _mass(w: Workspace, by_recursion: bool) -> tuple[Sequence[int], list[list[Expr]]]:
    """Return the tree of the velocities, and M."""
    return (w.tree.velocity_parents(), w.composite_mass) if by_recursion else (range(-1, w.state.n), w.lagrange_mass)


def _factors(w: Workspace, by_recursion: bool) -> Factored:
    return factored(w.graph, *_mass(w, by_recursion))


def _lower(w: Workspace, by_recursion: bool) -> list[Expr]:
    """Return L below the diagonal and D on it, row by row."""
    found: Factored = w.once(_factors, by_recursion)
    n, zero = range(w.state.n), w.graph.zero
    return [found.L[i][j] if j < i else found.pivots[i] if i == j else zero for i in n for j in n]


def _right(w: Workspace) -> tuple[Expr, ...]:
    return direction(w.graph, RIGHT, w.state.n)


def _least(w: Workspace) -> list[Expr]:
    """Return all multipliers, those of what independent rows imply from their coefficients."""
    independent, rows, total = w.loops.decisions.independent_rows, w.loops.recursive, w.graph.total
    found, one, zero = list(w.once(constrained_outputs.multipliers)), w.graph.one, w.graph.zero
    dependent = [k for k in range(len(rows.G)) if k not in independent]
    if not (dependent and found):
        return [*found, *(zero for _ in dependent)]
    G, n = w.loops.G(rows), range(len(dependent))
    sides = [[w.graph.dot(row, rows.G[k]) for k in dependent] for row in G]
    B = [list(row) for row in zip(*squared(list(zip(*G, strict=True))).solve(sides), strict=True)]
    square = [[w.graph.dot(B[i], B[j]) + (one if i == j else zero) for j in n] for i in n]
    mu = solve(range(-1, len(n)), square, [w.graph.dot(row, found) for row in B])
    kept = [x - total(B[i][k] * mu[i] for i in n) for k, x in enumerate(found)]
    values = dict(zip((*independent, *dependent), (*kept, *mu), strict=True))
    return [values[k] for k in range(len(rows.G))]


def _lagrange_least(w: Workspace) -> list[Expr]:
    """Return them from the forces that Lagrange's equations have, in the space of all rows."""
    rows, G = w.loops.differentiated, w.loops.G(w.loops.differentiated)
    if not G:
        return [w.graph.zero for _ in rows.G]
    f = w.loops.constraint_forces(w.once(constrained_outputs.lagrange_multipliers), rows)
    C = [[w.graph.dot(every, one) for one in G] for every in rows.G]
    y = [one for (one,) in squared(C).solve([[w.graph.dot(row, f)] for row in G])]
    return [w.graph.dot(row, y) for row in C]


def _pressure(w: Workspace, by_recursion: bool) -> list[Expr]:
    scene, tree, graph, g, u = w.scene, w.tree, w.graph, w.tree.gravity, w.state.qdd
    if dot(g, g).is_zero:
        raise DerivationError(f"{scene.name}: there is no centre of pressure without gravity, which presses")
    if by_recursion:
        C, matrix = centroidal.centre(scene, tree), centroidal.momentum_matrix(scene, tree)
        bias = centroidal.momentum_bias(scene, tree, w.state)
    else:
        C, matrix = (
            centroidal.differentiated_centre(scene, graph),
            centroidal.differentiated_momentum_matrix(scene, graph),
        )
        bias = centroidal.differentiated_momentum_bias(scene, graph)
    x, y, z, *turning = (w.graph.dot(matrix[len(u) * k : len(u) * (k + 1)], u) + bias[k] for k in range(6))
    f = add((x, y, z), scale(-w.mass, g))
    about = add(cross(C, f), (turning[0], turning[1], turning[2]))
    return list(scale(1 / dot(f, g), cross(g, about)))


# The table

_ON_REQUEST = partial(Output, default_in="request", may_fail="reported")
_OF_MASS = partial(_ON_REQUEST, when_constrained="tree")
_SQUARE = (labels.velocities, labels.velocities)


def _both(derive: Callable[[Workspace, bool], list[Expr]]) -> dict[str, Formulation]:
    return {"crba": Formulation(lambda w: derive(w, True)), "lagrange": by_lagrange(lambda w: derive(w, False))}


OPERATORS: dict[str, Output] = {
    "mass_matrix_inverse": _OF_MASS(
        "inverse of the mass matrix M(q), symmetric",
        ("q",), "Minv", _SQUARE, "1/(kg m^2), 1/(kg m) or 1/kg", size=Size((0, 40), 1.0),
        formulations=_both(lambda w, way: formulations.flat(w.once(_factors, way).inverse())),
    ),
    "mass_matrix_factors": _OF_MASS(
        "factors of M(q) = L^T D L: D on the diagonal, below it L, which is 1 on its own; zero between branches",
        ("q",), "LD", _SQUARE, "D as M, L without or m or 1/m", formulations=_both(_lower), size=Size((0, 30), 0.3),
    ),
    "mass_matrix_solve": _OF_MASS(
        "accelerations x that solve M(q) x = forces",
        ("q", RIGHT), "x", (labels.velocities,), "rad/s^2 (revolute) or m/s^2 (prismatic)",
        formulations=_both(lambda w, way: solve(*_mass(w, way), _right(w))) | {"aba": Formulation(
            lambda w: aba(w.recursion_tree.without_gravity, w.zeros, _right(w)), trees_only=True
        )},
        prefer=formulations.cheaper_forward,
    ),
    "minimum_norm_multipliers": _ON_REQUEST(
        "multipliers lambda of all rows of loops, redundant ones too, of least norm among those of the same forces "
        "G^T lambda; as multipliers, units mixed where rows are",
        ("q", "qd", "tau"), "lambda", (lambda w: w.loops.decisions.names,), "N or N m",
        when_constrained="only",
        formulations={"crba": Formulation(_least), "lagrange": by_lagrange(_lagrange_least)},
        depends=("independent", "alpha", "beta"),
    ),
    "centre_of_pressure": _ON_REQUEST(
        "centre of pressure of all that the ground exerts, on the plane across gravity through the origin of the "
        "ground frame: where it has no moment along the plane; without rotors",
        ("q", "qd", "qdd"), "p", (labels.fixed(*"xyz"),), "m",
        when_constrained="same",
        formulations={
            "recursive": Formulation(lambda w: _pressure(w, True)),
            "differentiation": by_differentiation(lambda w: _pressure(w, False)),
        },
    ),
}  # fmt: skip
