"""How a named frame moves: its velocity, acceleration and Jacobian, in the axes and at the point that a word says.

    aligned   at the origin of the named frame, axes of the ground
    local     at the origin of the named frame, its own axes
    world     of the point of the body that passes the origin of the ground, axes of the ground
    R, p      placement of the named frame in the ground frame
    v, ω      velocity of its origin, angular velocity; axes of the ground

    V         aligned [v; ω]        local [Rᵀ v; Rᵀ ω]                  world [v + p × ω; ω]           V = J u
    V̇         aligned [v̇; ω̇]        local [Rᵀ (v̇ - ω × v); Rᵀ ω̇]        world [v̇ + v × ω + p × ω̇; ω̇]   V̇ = J u̇ + J̇ u

V̇ is the rate of the numbers in V: so it is the acceleration of a point where frames are aligned, and what Featherstone
calls a spatial acceleration elsewhere. Each exists twice. *By differentiation*: the placement in the ground frame, its
rates, and [v; ω] as a function of u. *Recursive*: from the joint axes and the motion of the tree, in axes of the body
that carries the frame. The linear part stands first.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), sections 2.10 and 2.11.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.kinematics import locate, placed, tree_placed
from symdyn.dynamics.mechanism.state import State
from symdyn.dynamics.mechanism.tree import Tree
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.spatial import Transform, Vec, add, cross, scale, sub, zero_vector

FRAMES = ("aligned", "local", "world")
"""The first is that of requests without a word."""

# By differentiation


def differentiated(scene: Scene, name: str, graph: Graph, frame: str) -> list[Expr]:
    """Return V, shape (6,), of v = ṗ and ω̃ = Ṙ Rᵀ."""
    T, state = placed(scene, name, graph), State.of(scene, graph)
    x, y, z = tangents(T.p, state.velocity)
    v, w = (x, y, z), T.R.spin([tangents(row, state.velocity) for row in T.R])
    if frame == "local":
        v, w = T.R.T @ v, T.R.T @ w
    return [*(add(v, cross(T.p, w)) if frame == "world" else v), *w]


def differentiated_jacobian(scene: Scene, name: str, graph: Graph, frame: str) -> list[Expr]:
    """Return J with V = J u, row by row, shape (6, n)."""
    twist = differentiated(scene, name, graph, frame)
    columns = [tangents(twist, {qd: graph.one}) for qd in State.of(scene, graph).qd]
    return [column[k] for k in range(6) for column in columns]


# Recursive


def jacobian(scene: Scene, tree: Tree, state: State, name: str, frame: str) -> list[Expr]:
    """Return J with V = J u, row by row, shape (6, n): column z × (p - o) + s over z, with z, s the joint axis."""
    body, local = locate(scene, name, tree.graph)
    i, home = tree.home[body]
    columns: list[tuple[Expr, ...]] = [(tree.graph.zero,) * 6] * tree.n
    placements, here = tree.placements(), home @ local  # here: the named frame in that of body i
    p = zero_vector(tree.graph) if frame == "world" else tree_placed(scene, tree, name).p
    while i:
        (z, s), T = tree.S[i], placements[i]
        if frame == "local":
            column = (*here.R.T @ add(cross(z, here.p), s), *here.R.T @ z)
        else:
            z, s = T.R @ z, T.R @ s
            column = (*add(cross(z, sub(p, T.p)), s), *z)
        for k, share in tree.A[i]:
            columns[k] = tuple(x + share * y for x, y in zip(columns[k], column, strict=True))
        here, i = tree.T[i] @ here, tree.parent[i]
    return [column[k] for k in range(6) for column in columns]


def velocity(scene: Scene, tree: Tree, state: State, name: str, frame: str) -> list[Expr]:
    """Return V, shape (6,)."""
    carrier, here, T = _carried(scene, tree, name)
    v, w = _twist(tree, state.qd, carrier, here.p)
    if frame == "local":
        return [*here.R.T @ v, *here.R.T @ w]
    v, w = T.R @ v, T.R @ w
    return [*(add(v, cross(T.point(here.p), w)) if frame == "world" else v), *w]


def acceleration(scene: Scene, tree: Tree, state: State, name: str, frame: str, qdd: Sequence[Expr] = ()) -> list[Expr]:
    """Return V̇, shape (6,); J̇ u without the rates u̇ of the velocities."""
    carrier, here, T = _carried(scene, tree, name)
    zero = tree.graph.zero
    motion = tree.motion(state.qd, qdd or [zero] * tree.n, (zero, zero, zero))[carrier]
    a, dw = motion.at(here.p), motion.dw
    if frame != "aligned":
        a = add(a, cross(_twist(tree, state.qd, carrier, here.p)[0], motion.w))
    if frame == "local":
        return [*here.R.T @ a, *here.R.T @ dw]
    a, dw = T.R @ a, T.R @ dw
    return [*(add(a, cross(T.point(here.p), dw)) if frame == "world" else a), *dw]


def _carried(scene: Scene, tree: Tree, name: str) -> tuple[int, Transform, Transform]:
    """Return the moving body that carries a frame, the frame's placement there, and the body's in the ground."""
    body, local = locate(scene, name, tree.graph)
    carrier, home = tree.home[body]
    return carrier, home @ local, tree.placements()[carrier]


def _twist(tree: Tree, qd: Sequence[Expr], carrier: int, r: Vec) -> tuple[Vec, Vec]:
    """Return the velocity of the point r of a moving body, m/s, and its angular velocity, in the body's axes."""
    rate, v, w = tree.rates(qd), zero_vector(tree.graph), zero_vector(tree.graph)
    for i in tree.paths(0, carrier)[1]:
        (z, s), E = tree.S[i], tree.T[i].R
        v = add(E.T @ add(v, cross(w, tree.T[i].p)), scale(rate[i], s))
        w = add(E.T @ w, scale(rate[i], z))
    return add(v, cross(w, r)), w
