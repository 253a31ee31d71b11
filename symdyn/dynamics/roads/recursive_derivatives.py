"""Derivatives of inverse and forward dynamics of trees by recursion, gathered from the moves on the velocities.

    φ_i      force on move i that the bodies need, a function of the moves' positions, rates and accelerations θ, r, a
    τ_k      Σ_i A_ik φ_i + what is left: loads, springs, dampers, friction, declared forces, rotors
    X_l      derivative along velocity l, u and u̇ held

    X_l τ_k = Σ_ij A_ik (∂φ_i/∂θ_j A_jl + ∂φ_i/∂r_j X_l r_j + ∂φ_i/∂a_j X_l a_j) + Σ_i φ_i X_l A_ik + …
    ∂τ_k/∂u_l = Σ_ij A_ik (∂φ_i/∂r_j A_jl + ∂φ_i/∂a_j ∂a_j/∂u_l) + …
    ∂τ_k/∂u̇_l = Σ_ij A_ik ∂φ_i/∂a_j A_jl + …

A block of moves (a ball, a free body) has rates u and accelerations u̇ whatever the bias of its moves is. What is left
is differentiated on the graph.

Forward dynamics solves M u̇ + h = τ; at its u̇, with M = Lᵀ D L factored once for u̇ and all columns,

    X u̇ = -M⁻¹ X τ(q, u, u̇)    ∂u̇/∂u = -M⁻¹ ∂τ/∂u    ∂u̇/∂τ = M⁻¹

Reference: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain, product
from operator import mul

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.ldl import factored
from symdyn.dynamics.recursive.rnea import rnea
from symdyn.dynamics.recursive.rnea_derivatives import MoveDerivatives, rnea_derivatives
from symdyn.dynamics.roads.workspace import Matrix, Workspace
from symdyn.graph import Expr, substitute, tangents

Slopes = dict[str, Matrix]
"""Derivatives along each argument, shape (nv, nv)."""


def inverse(w: Workspace, along: Sequence[str]) -> list[Expr]:
    """Return the derivatives of inverse dynamics along "q", "qd" or "qdd", row by row."""
    return _beside(w.once(_inverse), along)


def _beside(slopes: Slopes, along: Sequence[str]) -> list[Expr]:
    return [entry for rows in zip(*(slopes[name] for name in along), strict=True) for entry in chain(*rows)]


def _inverse(w: Workspace) -> Slopes:
    """Return the derivatives of inverse dynamics."""
    state = w.state

    def moves(leaping: bool, far: int) -> MoveDerivatives:
        return rnea_derivatives(w.whole, state.qd, state.qdd, leaping=leaping, far=far)

    found = _gathered(w, _cheapest(w, moves))
    rest = [sum(parts[1:], parts[0]) for parts in zip(*_beside_bodies(w), strict=True)]
    seeds = {
        "q": w.directions.along,
        "qd": [{one: w.graph.one} for one in state.qd],
        "qdd": [{one: w.graph.one} for one in state.qdd],
    }
    for name, matrix in found.items():
        for m, seed in enumerate(seeds[name]):
            for k, slope in enumerate(tangents(rest, seed)):
                matrix[k][m] = matrix[k][m] + slope
    return found


COUNTED = 16
"""Velocities up to which the variants of the recursion are compared by counting."""


def _cheapest(w: Workspace, moves: Callable[[bool, int], MoveDerivatives]) -> MoveDerivatives:
    """Return the variant of the recursion that costs least; see `rnea_derivatives`."""
    if w.state.n > COUNTED:
        return moves(True, 1)
    state = (*w.state.q, *w.state.qd, *w.state.qdd)

    def price(one: MoveDerivatives) -> int:
        return cost(chain(*(kind.values() for kind in (one.by_position, one.by_rate, one.by_acceleration))), state)

    return min((moves(*choices) for choices in product((False, True), (0, 1, 2))), key=price)


def _beside_bodies(w: Workspace) -> list[list[Expr]]:
    """Return what inverse dynamics finds beside what bodies need, shape (nv,) each."""
    tree, state = w.whole, w.state
    acceleration = tree.accelerations(state.qd, state.qdd)
    rotors = tree.gather([a * inertia for a, inertia in zip(acceleration, tree.armature, strict=True)])
    for ball in tree.balls:
        for k, moment in zip(ball.velocities, ball.forces(state.qd, state.qdd), strict=True):
            rotors[k] = rotors[k] + moment
    loads = rnea(tree, w.still, w.still, gravity=False, acting=w.loads)
    return [w.elastic.forces, loads, [-push for push in w.pushes], rotors]


def _gathered(w: Workspace, moves: MoveDerivatives) -> Slopes:
    """Return the derivatives of what bodies need; see the module's legend."""
    tree, (u, du), n = w.whole, (w.state.qd, w.state.qdd), w.state.n
    found = {name: [[w.graph.zero] * n for _ in range(n)] for name in ("q", "qd", "qdd")}
    kinds = {"q": moves.by_position, "qd": moves.by_rate, "qdd": moves.by_acceleration}
    for name, by_move in kinds.items():
        for (i, j), value in by_move.items():
            for k, x in tree.A[i]:
                for m, y in tree.A[j]:
                    found[name][k][m] = found[name][k][m] + x * y * value
    curved = [j for j in tree.outward() if len(tree.block[j]) == 1 and tree.b[j]]
    for j in curved:
        rate, acceleration = tree.rates(u)[j], tree.accelerations(u, du)[j]
        for m in range(n):
            r, a = w.directions.derivative([rate, acceleration], m)
            (by_rate,) = tangents([acceleration], {u[m]: w.graph.one})
            for i in tree.outward():
                if (i, j) not in moves.by_acceleration:
                    continue
                M, bent = moves.by_acceleration[i, j], moves.by_rate[i, j] * r
                for k, x in tree.A[i]:
                    found["q"][k][m] = found["q"][k][m] + x * (bent + M * a)
                    found["qd"][k][m] = found["qd"][k][m] + x * M * by_rate
            for k, x in tree.A[j]:
                (turned,) = w.directions.derivative([x], m)
                found["q"][k][m] = found["q"][k][m] + turned * moves.forces[j]
    return found


# Forward dynamics


def forward(w: Workspace, along: Sequence[str]) -> list[Expr]:
    """Return the derivatives of forward dynamics along "q", "qd" or "tau", row by row."""
    return _beside(w.once(_forward), along)


def _forward(w: Workspace) -> Slopes:
    """Return the derivatives of forward dynamics; prescribed accelerations depend on no argument."""
    slopes, given, n = w.once(_inverse), w.prescribed, w.state.n
    free = given.free
    factors = factored(w.graph, w.tree.velocity_parents(free), [[slopes["qdd"][i][j] for j in free] for i in free])
    bias = w.forces(given.entered(w.still))
    accelerations = given.entered(w.still)
    for i, (value,) in zip(free, factors.solve([[w.state.tau[i] - bias[i]] for i in free]), strict=True):
        accelerations[i] = value
    moving = dict(zip(w.state.qdd, accelerations, strict=True))
    rows = [substitute([-entry for name in ("q", "qd") for entry in slopes[name][i]], moving) for i in free]
    inverse = factors.inverse()
    state = (*w.state.q, *w.state.qd, *w.state.tau)
    columns = list(zip(*rows, strict=True))
    by_inverse = [[w.graph.total(map(mul, row, column)) for column in columns] for row in inverse]
    both = factors.solve(rows), by_inverse
    solved = min(both, key=lambda one: cost(chain(*one, *inverse), state))
    found = {name: [[w.graph.zero] * n for _ in range(n)] for name in ("q", "qd", "tau")}
    for i, row, by_force in zip(free, solved, inverse, strict=True):
        found["q"][i], found["qd"][i] = row[:n], row[n:]
        for j, value in zip(free, by_force, strict=True):
            found["tau"][i][j] = value
    return found
