"""Motion of a kinematic tree from the ground to the tips, and kinematics of named points and bodies.

Pose, Jacobian, velocity product and acceleration of a centre of mass exist twice. *By differentiation*: placements in
the ground frame, differentiated on the graph. *Recursive*: from the joint axes and from the motion of the tree. Public
twists and accelerations are stacked linear part first, angular part second, in the ground frame, at the origin of the
named frame.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    E, r        rotation and translation of T[i]: x_p = E x_i + r
    S = z, s    motion subspace of joint i, angular and linear part, constant in frame i
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, all in frame i

Reference: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.90).
"""

from __future__ import annotations

from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.mechanism.state import State, vector
from symdyn.dynamics.mechanism.tree import Tree, body_inertia
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene
from symdyn.spatial import Transform, Vec, add, cross, scale, sub, zero_vector

PLACES = {"body": ("bodies",), "body or point": ("bodies", "points")}
"""Where a name is looked for that shall be one of these."""


def check_place(scene: Scene, name: str, kind: str = "body or point") -> None:
    """Look whether a scene has a body, or a body or point, called `name`.

    Raises:
        DerivationError: it has none; with those that it has.
    """
    known = [one.name for place in PLACES[kind] for one in getattr(scene, place)]
    if name not in known:
        raise DerivationError(f"{scene.name}: there is no {kind} {name!r}; there are {', '.join(known)}")


def locate(scene: Scene, name: str, graph: Graph) -> tuple[str, Transform]:
    """Return the body that carries the body or point called `name`, and its placement there."""
    for point in scene.points:
        if point.name == name:
            return point.body, point.at.transform(graph)
    check_place(scene, name)
    return name, Transform.unit(graph)


# By differentiation


def placed(scene: Scene, name: str, graph: Graph) -> Transform:
    """Return the placement of a body or point in the ground frame."""
    body, local = locate(scene, name, graph)
    return body_placements(scene, graph)[body] @ local


def pose(T: Transform) -> list[Expr]:
    """Return [R | p] row by row, shape (3, 4)."""
    return [entry for row, shift in zip(T.R, T.p, strict=True) for entry in (*row, shift)]


def differentiated_jacobian(scene: Scene, name: str, graph: Graph) -> list[Expr]:
    """Return J with [v; ω] = J q̇, row by row, shape (6, n): v = ∂p/∂q q̇, ω̃ = Ṙ Rᵀ."""
    T, state = placed(scene, name, graph), State.of(scene, graph)
    twist = _twist(T, state.velocity)
    columns = [tangents(twist, {qd: graph.one}) for qd in state.qd]
    return [column[k] for k in range(6) for column in columns]


def differentiated_velocity_product(scene: Scene, name: str, graph: Graph) -> list[Expr]:
    """Return J̇ q̇, shape (6,): the acceleration [v̇; ω̇] at q̈ = 0."""
    T, state = placed(scene, name, graph), State.of(scene, graph)
    return tangents(_twist(T, state.velocity), state.velocity)


def differentiated_acceleration(scene: Scene, name: str, graph: Graph) -> list[Expr]:
    """Return the acceleration of a body's centre of mass, the input of (5.11), shape (3,), ground frame, m/s^2."""
    state = State.of(scene, graph)
    motion = state.acceleration
    centre = body_placements(scene, graph)[name].point(centre_of_mass(scene, name, graph))
    return tangents(tangents(centre, motion), motion)


def _twist(T: Transform, rates: dict[Expr, Expr]) -> list[Expr]:
    """Return [ṗ; ω] of a placement along given rates, ground frame."""
    turning = T.R.spin([tangents(row, rates) for row in T.R])
    return [*tangents(T.p, rates), *turning]


# Recursive


def tree_placed(scene: Scene, tree: Tree, name: str) -> Transform:
    """Return the placement of a body or point in the ground frame."""
    body, local = locate(scene, name, tree.graph)
    carrier, home = tree.home[body]
    return tree.placements()[carrier] @ home @ local


def jacobian(scene: Scene, tree: Tree, state: State, name: str) -> list[Expr]:
    """Return J with [v; ω] = J q̇, row by row, shape (6, n): column z × (p - o) + s over z, with z, s the joint axis."""
    body, _ = locate(scene, name, tree.graph)
    p, placements = tree_placed(scene, tree, name).p, tree.placements()
    columns: list[tuple[Expr, ...]] = [(tree.graph.zero,) * 6] * tree.n
    i = tree.home[body][0]
    while i:
        z, s = placements[i].R @ tree.S[i][0], placements[i].R @ tree.S[i][1]
        column = (*add(cross(z, sub(p, placements[i].p)), s), *z)
        for k, share in tree.A[i]:
            columns[k] = tuple(x + share * y for x, y in zip(columns[k], column, strict=True))
        i = tree.parent[i]
    return [column[k] for k in range(6) for column in columns]


def velocity_product(scene: Scene, tree: Tree, state: State, name: str) -> list[Expr]:
    """Return J̇ q̇, shape (6,): the acceleration [v̇; ω̇] at q̈ = 0."""
    still = [tree.graph.zero] * tree.n
    body, local = locate(scene, name, tree.graph)
    carrier, home = tree.home[body]
    motion = tree.motion(state.qd, still, zero_vector(tree.graph))[carrier]
    R = tree.placements()[carrier].R
    return [*R @ motion.at((home @ local).p), *R @ motion.dw]


def acceleration(scene: Scene, tree: Tree, state: State, name: str) -> list[Expr]:
    """Return the acceleration of a body's centre of mass, the input of (5.11), shape (3,), ground frame, m/s^2."""
    centre = centre_of_mass(scene, name, tree.graph)
    carrier, home = tree.home[name]
    motion = tree.motion(state.qd, state.qdd, zero_vector(tree.graph))[carrier]
    return list(tree.placements()[carrier].R @ motion.at(home.point(centre)))


def centre_of_mass(scene: Scene, name: str, graph: Graph) -> Vec:
    """Return the centre of mass of a body in its own frame, m; DerivationError where it is no body, or has no mass."""
    check_place(scene, name, "body")
    body = next(body for body in scene.bodies if body.name == name)
    if not body.particles and body.com is not None:
        return vector(body.com, graph)
    inertia = body_inertia(body, graph)
    if inertia.m.is_zero:
        raise DerivationError(f"{scene.name}: body {name!r} has no mass, so it has no centre of mass")
    return scale(1 / inertia.m, inertia.h)
