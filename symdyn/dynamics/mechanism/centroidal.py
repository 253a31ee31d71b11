"""The centre of mass of all that moves, and momentum about it.

    m, C     mass of the bodies that move, and their centre of mass, ground frame
    J        velocity of C = J u                                        shape (3, n)
    p, L     momentum, and angular momentum about C: [p; L] = A u       shape (6, n), linear part first, ground axes
    b        what velocities alone add to its rate: d/dt [p; L] = A u̇ + b

p = m J u. What is welded to the ground does not count, and rotors (armature) have no part, as they have no gyroscopic
effect in the equations of motion. Each exists twice. *Recursive*: column k of A is the momentum of what joint k
carries, as one rigid body, at unit rate; b is the sum of the wrenches that move the bodies at u̇ = 0. *By
differentiation*: placements in the ground frame, their rates, and [p; L] as a function of u.

Reference: Orin, Goswami and Lee, Centroidal dynamics of a humanoid robot, Autonomous Robots 35 (2013) 161.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.dynamics.mechanism.state import State, body_placements
from symdyn.dynamics.mechanism.tree import Tree, body_inertia
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.spatial import Inertia, Transform, Vec, add, cross, scale, sub, zero_vector


def massive(scene: Scene, m: Expr) -> Expr:
    """Return a mass that a centre of mass needs; DerivationError where there is none."""
    if m.is_zero:
        raise DerivationError(f"{scene.name}: no body that moves has a mass, so that there is no centre of mass")
    return m


def by_rows(columns: Sequence[Sequence[Expr]]) -> list[Expr]:
    """Return the entries of a matrix row by row, for its columns."""
    return [entry for row in zip(*columns, strict=True) for entry in row]


# Recursive


def composites(tree: Tree) -> list[Inertia]:
    """Return the inertia of all that every moving body carries, itself included, in its frame; entry 0 the ground's."""
    found = [Inertia.none(tree.graph), *tree.inertia[1:]]
    for i in tree.inward():
        p = tree.parent[i]
        found[p] = found[p] + found[i].seen_from(tree.T[i])
    return found


def mass(scene: Scene, tree: Tree) -> Expr:
    """Return m, kg."""
    return massive(scene, tree.graph.total(one.m for one in tree.inertia[1:]))


def centre(scene: Scene, tree: Tree) -> Vec:
    """Return C, m."""
    m, total = mass(scene, tree), zero_vector(tree.graph)
    for T, one in list(zip(tree.placements(), tree.inertia, strict=True))[1:]:
        total = add(total, add(T.R @ one.h, scale(one.m, T.p)))
    return scale(1 / m, total)


def _momenta(scene: Scene, tree: Tree, C: Vec) -> list[tuple[Vec, Vec]]:
    """Return (linear, angular) momentum about C for the unit rate of every velocity."""
    zero = zero_vector(tree.graph)
    columns = [(zero, zero)] * tree.n
    for i, (T, carried) in enumerate(zip(tree.placements(), composites(tree), strict=True)):
        L, p = (T.R @ part for part in carried.momentum(*tree.S[i]))
        L = add(L, cross(sub(T.p, C), p))
        for k, share in tree.A[i]:
            columns[k] = add(columns[k][0], scale(share, p)), add(columns[k][1], scale(share, L))
    return columns


def centre_jacobian(scene: Scene, tree: Tree) -> list[Expr]:
    """Return J row by row, shape (3, n)."""
    m = mass(scene, tree)
    return by_rows([scale(1 / m, p) for p, _ in _momenta(scene, tree, zero_vector(tree.graph))])


def momentum_matrix(scene: Scene, tree: Tree) -> list[Expr]:
    """Return A row by row, shape (6, n); kg and kg m, kg m and kg m^2."""
    return by_rows([(*p, *L) for p, L in _momenta(scene, tree, centre(scene, tree))])


def momentum_bias(scene: Scene, tree: Tree, state: State) -> list[Expr]:
    """Return b, shape (6,); N and N m."""
    C, still = centre(scene, tree), [tree.graph.zero] * tree.n
    force = moment = zero_vector(tree.graph)
    motion = tree.motion(state.qd, still, zero_vector(tree.graph))
    for T, one, at in list(zip(tree.placements(), tree.inertia, motion, strict=True))[1:]:
        turning, pushing = one.momentum(at.dw, at.a)
        L, p = one.momentum(at.w, zero_vector(tree.graph))
        f = T.R @ add(pushing, cross(at.w, p))
        n = T.R @ add(turning, cross(at.w, L))
        force, moment = add(force, f), add(moment, add(n, cross(sub(T.p, C), f)))
    return [*force, *moment]


# By differentiation


def _moving(scene: Scene, graph: Graph) -> Iterator[tuple[Transform, Inertia]]:
    """Yield placement and inertia of every body that moves."""
    placed, moving = body_placements(scene, graph), {Scene.GROUND: False}
    for joint, body in zip(scene.joints, scene.bodies, strict=True):
        moving[body.name] = moving[joint.parent] or joint.moves or joint.coupling is not None
        if moving[body.name]:
            yield placed[body.name], body_inertia(body, graph)


def differentiated_centre(scene: Scene, graph: Graph) -> Vec:
    """Return C, m."""
    total, m = zero_vector(graph), graph.zero
    for T, one in _moving(scene, graph):
        total, m = add(total, add(T.R @ one.h, scale(one.m, T.p))), m + one.m
    return scale(1 / massive(scene, m), total)


def differentiated_momentum(scene: Scene, graph: Graph) -> list[Expr]:
    """Return [p; L], shape (6,): ∫ ṙ dm and ∫ (r - C) × ṙ dm."""
    rates, C = State.of(scene, graph).velocity, differentiated_centre(scene, graph)
    p = L = zero_vector(graph)
    for T, one in _moving(scene, graph):
        x, y, z = tangents(T.p, rates)
        w = T.R.T @ T.R.spin([tangents(row, rates) for row in T.R])
        own, linear = (T.R @ part for part in one.momentum(w, T.R.T @ (x, y, z)))
        p, L = add(p, linear), add(L, add(own, cross(sub(T.p, C), linear)))
    return [*p, *L]


def differentiated_centre_jacobian(scene: Scene, graph: Graph) -> list[Expr]:
    """Return J row by row, shape (3, n)."""
    state = State.of(scene, graph)
    velocity = tangents(differentiated_centre(scene, graph), state.velocity)
    return by_rows([tangents(velocity, {u: graph.one}) for u in state.qd])


def differentiated_momentum_matrix(scene: Scene, graph: Graph) -> list[Expr]:
    """Return A row by row, shape (6, n)."""
    momentum = differentiated_momentum(scene, graph)
    return by_rows([tangents(momentum, {u: graph.one}) for u in State.of(scene, graph).qd])


def differentiated_momentum_bias(scene: Scene, graph: Graph) -> list[Expr]:
    """Return b, shape (6,): the rate of [p; L] at u̇ = 0."""
    return tangents(differentiated_momentum(scene, graph), State.of(scene, graph).velocity)
