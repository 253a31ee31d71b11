"""Derivatives of inverse and forward dynamics of trees by recursion, gathered from the elementary joints.

    φ_i      force of elementary joint i that bodies need, a function of joint positions, rates, accelerations θ, r, a
    τ_k      Σ_i A_ik φ_i + what is left: loads, springs, dampers, friction, declared forces, rotors
    X_l      derivative along velocity l, u and u̇ held; X without index: along any argument
    A_ik     rate of elementary joint i per unit of velocity u_k

    X_l τ_k = Σ_ij A_ik (∂φ_i/∂θ_j A_jl + ∂φ_i/∂r_j X_l r_j + ∂φ_i/∂a_j X_l a_j) + Σ_i φ_i X_l A_ik + …
    ∂τ_k/∂u_l = Σ_ij A_ik (∂φ_i/∂r_j A_jl + ∂φ_i/∂a_j ∂a_j/∂u_l) + …
    ∂τ_k/∂u̇_l = Σ_ij A_ik ∂φ_i/∂a_j A_jl + …

A block of joints (a ball, a free body) has rates u and accelerations u̇ whatever the bias of its joints is. What is left
is differentiated on the graph.

Forward dynamics solves M u̇ + h = τ; at its u̇, with M = Lᵀ D L factored once for u̇ and all columns,

    X u̇ = -M⁻¹ X τ(q, u, u̇)    ∂u̇/∂u = -M⁻¹ ∂τ/∂u    ∂u̇/∂τ = M⁻¹

The Coriolis matrix is half of ∂c/∂u, c = C u, and what directions that do not commute add (`mechanism.kinematics`):

    C_kl = ½ ∂c_k/∂u_l + ½ Σ_m γ^i_ml M_ik u_m    γ^i_ml: brackets of directions m and l

Reference: Carpentier and Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from operator import mul

from symdyn.dynamics.mechanism.cost import cost
from symdyn.dynamics.mechanism.linear_solve import Factored, RowSolve, RowStep, Singular, factored
from symdyn.dynamics.outputs.workspace import Matrix, Workspace
from symdyn.dynamics.recursive.rnea_derivatives import JointForceDerivatives, halves_by_rate, rnea_derivatives
from symdyn.dynamics.recursive.tree_dynamics import rnea
from symdyn.frozen import dataclass
from symdyn.graph import Expr, gradient, substitute, tangents

Jacobians = dict[str, Matrix]
"""Derivatives along each argument, shape (nv, nv)."""

COUNTED = 16
"""Velocities up to which M⁻¹ times the right sides is compared with solving, and C with another one, by counting."""


def inverse_derivatives(w: Workspace, along: Sequence[str]) -> list[Expr]:
    """Return the derivatives of inverse dynamics along "q", "qd" or "qdd", row by row."""
    return _beside(w.once(_inverse), along)


def forward_derivatives(w: Workspace, along: Sequence[str]) -> list[Expr]:
    """Return the derivatives of forward dynamics along "q", "qd" or "tau", row by row."""
    return _beside(w.once(forward_with_factors).jacobians, along)


def forward_solve(w: Workspace, along: Sequence[str]) -> RowSolve | None:
    """Return what the derivatives of forward dynamics are solved from; None for M⁻¹ alone, which is symmetric."""
    found: Forward = w.once(forward_with_factors)
    n, free, zero, one = w.state.n, w.prescribed.free, w.graph.zero, w.graph.one
    solved = [name for name in along if name in RIGHT_SIDES or not found.by_inverse]
    if not (free and any(name in RIGHT_SIDES for name in along)):
        return None
    sides = []
    for k, i in enumerate(free):
        given = {name: found.rows[k][m * n : (m + 1) * n] for m, name in enumerate(RIGHT_SIDES)}
        given["tau"] = [one if j == i else zero for j in range(n)]
        sides.append(tuple(chain.from_iterable(given[name] for name in solved)))
    if found.by_inverse:
        at = [(n + k, tuple(-entry for entry in side)) for k, side in enumerate(sides)]
        terms = [tuple((entry, n + k) for k, entry in enumerate(row) if not entry.is_zero) for row in found.inverse]
        steps = [RowStep(i, one, some) for i, some in zip(free, terms, strict=True)]
    else:
        at = list(zip(free, sides, strict=True))
        steps = [*found.factors.steps(free)]
    beside = tuple(
        tuple(None if i in free and name in solved else entry for name in along for entry in found.jacobians[name][i])
        for i in range(n)
    )
    return RowSolve(w.scene, tuple(at), n + len(free) if found.by_inverse else n, tuple(steps), beside)


def coriolis_matrix(w: Workspace) -> list[Expr]:
    """Return C(q, u), row by row."""
    tree, u, n = w.whole, w.state.qd, range(w.state.n)
    of_joints = halves_by_rate(tree, u)
    half = w.graph.one / 2
    varying, _ = _of_varying_coefficients(w, of_joints)
    rotors = _rotors(w, w.zeros)
    C = tree.generalized_matrix(of_joints.by_rate)
    for j in n:
        own = tangents(rotors, {u[j]: w.graph.one})
        for i in n:
            turned = (
                w.composite_mass[m][i] * value * u[k] for k in n for m, value in w.directions.brackets.get((k, j), ())
            )
            C[i][j] = C[i][j] + (varying[i][j] + own[i] + w.graph.total(turned)) * half
    return list(chain(*C))


def _beside(slopes: Jacobians, along: Sequence[str]) -> list[Expr]:
    return [entry for rows in zip(*(slopes[name] for name in along), strict=True) for entry in chain(*rows)]


# Inverse dynamics


def _inverse(w: Workspace) -> Jacobians:
    tree, state = w.whole, w.state
    of_joints = rnea_derivatives(tree, state.qd, state.qdd)
    kinds = {"q": of_joints.by_position, "qd": of_joints.by_rate, "qdd": of_joints.by_acceleration}
    found = {name: tree.generalized_matrix(by_joint) for name, by_joint in kinds.items()}
    by_rate, by_position = _of_varying_coefficients(w, of_joints)
    rest = [sum(parts[1:], parts[0]) for parts in zip(*beside_bodies(w), strict=True)]
    for k in range(state.n):
        for m in range(state.n):
            found["q"][k][m] = found["q"][k][m] + by_position[k][m]
            found["qd"][k][m] = found["qd"][k][m] + by_rate[k][m]
    for name, along in _directions(w).items():
        for m, seed in enumerate(along):
            for k, slope in enumerate(tangents(rest, seed)):
                found[name][k][m] = found[name][k][m] + slope
    return found


def _directions(w: Workspace) -> dict[str, Sequence[dict[Expr, Expr]]]:
    """Return the directions of the arguments of inverse dynamics."""
    one = w.graph.one
    return {"q": w.directions.along, "qd": [{x: one} for x in w.state.qd], "qdd": [{x: one} for x in w.state.qdd]}


def _of_varying_coefficients(w: Workspace, of_joints: JointForceDerivatives) -> tuple[Matrix, Matrix]:
    """Return what joints add whose coefficients A depend on q (cams, couplings by formulas): by rates, by positions."""
    tree, (u, du) = w.whole, (w.state.qd, w.state.qdd)
    by_rate, by_position = ([[w.graph.zero] * w.state.n for _ in u] for _ in range(2))
    for j in tree.outward():
        if not tree.b[j] or len(tree.block[j]) > 1 or not tree.block[j]:
            continue
        rate, acceleration = tree.rates(u)[j], tree.accelerations(u, du)[j]
        carried = [i for i in tree.outward() if (i, j) in of_joints.by_acceleration]
        for m in range(w.state.n):
            r, a = w.directions.derivative([rate, acceleration], m)
            (a_by_rate,) = tangents([acceleration], {u[m]: w.graph.one})
            for i in carried:
                M, D = of_joints.by_acceleration[i, j], of_joints.by_rate[i, j]
                for k, x in tree.A[i]:
                    by_rate[k][m] = by_rate[k][m] + x * (M * a_by_rate)
                    by_position[k][m] = by_position[k][m] + x * (D * r + M * a)
            for k, x in tree.A[j] if j in of_joints.forces else ():
                (turned,) = w.directions.derivative([x], m)
                by_position[k][m] = by_position[k][m] + turned * of_joints.forces[j]
    return by_rate, by_position


def beside_bodies(w: Workspace) -> list[list[Expr]]:
    """Return what inverse dynamics finds beside what bodies need, shape (nv,) each."""
    loads = rnea(w.whole.without_gravity, w.zeros, w.zeros, w.loads)
    return [w.elastic.forces, loads, [-push for push in w.pushes], _rotors(w, w.state.qdd)]


def _rotors(w: Workspace, qdd: Sequence[Expr]) -> list[Expr]:
    """Return what rotors at the joints need, shape (nv,)."""
    tree, u = w.whole, w.state.qd
    accelerations = tree.accelerations(u, qdd)
    forces = tree.generalized_forces([a * inertia for a, inertia in zip(accelerations, tree.armature, strict=True)])
    return [own + ball for own, ball in zip(forces, tree.spherical_rotor_forces(u, qdd), strict=True)]


# Forward dynamics


RIGHT_SIDES = ("q", "qd")
"""Arguments along which derivatives of forward dynamics are solved for."""


@dataclass(frozen=True)
class Forward:
    """Derivatives of forward dynamics, and what they are solved from, of velocities whose motion is not prescribed."""

    jacobians: Jacobians  # the derivatives
    accelerations: list[Expr]  # what is differentiated
    factors: Factored  # of M
    rows: Matrix  # right sides -X τ, a column for each of `RIGHT_SIDES`
    inverse: Matrix  # M⁻¹
    by_inverse: bool  # whether rows are multiplied by it


def forward_with_factors(w: Workspace) -> Forward:
    """Return the derivatives of forward dynamics; prescribed accelerations depend on no argument."""
    slopes, given, n = w.once(_inverse_to_solve), w.prescribed, w.state.n
    free = given.free
    factored_mass(w, w.once(_inverse)["qdd"])  # sees that a branch has no mass, whatever sweeps have made of M
    factors = factored_mass(w, slopes["qdd"])
    bias = w.forces(given.entered(w.zeros))
    accelerations = given.entered(w.zeros)
    for i, (value,) in zip(free, factors.solve([[w.state.tau[i] - bias[i]] for i in free]), strict=True):
        accelerations[i] = value
    moving = dict(zip(w.state.qdd, accelerations, strict=True))
    rows = [substitute([-entry for name in RIGHT_SIDES for entry in slopes[name][i]], moving) for i in free]
    inverse = factors.inverse()
    solved, by_inverse = factors.solve(rows), False
    if n <= COUNTED:
        state, columns = (*w.state.q, *w.state.qd, *w.state.tau), list(zip(*rows, strict=True))
        multiplied = [[w.graph.total(map(mul, row, column)) for column in columns] for row in inverse]
        by_inverse = cost(chain(*multiplied, *inverse), state) < cost(chain(*solved, *inverse), state)
        solved = multiplied if by_inverse else solved
    found = {name: [[w.graph.zero] * n for _ in range(n)] for name in ("q", "qd", "tau")}
    for i, row, by_force in zip(free, solved, inverse, strict=True):
        found["q"][i], found["qd"][i] = row[:n], row[n:]
        for j, value in zip(free, by_force, strict=True):
            found["tau"][i][j] = value
    return Forward(found, accelerations, factors, rows, inverse, by_inverse)


def factored_mass(w: Workspace, M: Matrix) -> Factored:
    """Return its factors where no motion is prescribed; Singular where there are none."""
    free = w.prescribed.free
    try:
        return factored(w.graph, w.tree.velocity_parents(free), [[M[i][j] for j in free] for i in free])
    except Singular as fault:
        raise Singular(free[fault.velocity]) from fault


def _inverse_to_solve(w: Workspace) -> Jacobians:
    """Return the derivatives of inverse dynamics by recursion or by reverse sweeps, whichever cost less."""
    by_recursion: Jacobians = w.once(_inverse)
    if w.state.n > COUNTED:
        return by_recursion
    forces, along = w.forces(list(w.state.qdd)), _directions(w)
    inputs = list(dict.fromkeys(symbol for seeds in along.values() for seed in seeds for symbol in seed))
    partials = [dict(zip(inputs, gradient(force, inputs), strict=True)) for force in forces]
    by_sweeps = {
        name: [[w.graph.total(h * row[x] for x, h in seed.items()) for seed in seeds] for row in partials]
        for name, seeds in along.items()
    }
    return min((by_recursion, by_sweeps), key=lambda one: cost(_beside(one, list(one)), inputs))
