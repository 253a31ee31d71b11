"""Kinematics of a tree: motion from the ground to the tips, named points and bodies, and directions of the velocities.

    i, p        a moving body 1..n and its parent, p < i; body 0 is the ground
    E, r        rotation and translation of T[i]: x_p = E x_i + r
    S = z, s    motion subspace of joint i, angular and linear part, constant in frame i
    w, dw, a    angular velocity, angular acceleration, acceleration of the origin of frame i, all in frame i

Pose and acceleration of a centre of mass are derived twice. *By differentiation*: placements in the ground frame,
differentiated on the graph. *Recursive*: from the motion of the tree. Velocities of named frames: `frame_outputs`.

Motion of one frame relative to another is added up along the tree.

Directions of the velocities on the space of coordinates, their brackets, and the connection of a mass matrix M:

    q̇ = H(q) u                 kinematic map, H = 1 where the velocities are rates of coordinates
    X_i f = Σ_k H_ki ∂f/∂q_k    derivative along velocity i
    [X_j, X_i] = Σ γ^l_ji X_l    zero for rates of coordinates; ε_jil for angular velocities in the body

    k_D[i, j]   = X_j M_ij - ½ X_i M_jj - γ^l_ji M_lj                            multiplies u_j²       shape (n, n)
    k_C[i, jk]  = X_k M_ij + X_j M_ik - X_i M_jk - γ^l_ji M_lk - γ^l_ki M_lj     multiplies u_j u_k    j < k
    C[i, j]     = Σ_k ⟨∇_k X_j, X_i⟩ u_k                                         Ṁ - 2C is skew        shape (n, n)

    2 ⟨∇_k X_j, X_i⟩ = X_k M_ij + X_j M_ik - X_i M_jk + γ^l_kj M_li - γ^l_ji M_lk - γ^l_ki M_lj

k_D are centrifugal, k_C Coriolis coefficients, split as in the textbook's (5.40). ∇ is the Levi-Civita connection of M,
by Koszul's formula for frames that do not commute. For rates of coordinates X_i = ∂/∂q_i and γ = 0, and these are
Christoffel symbols of the first kind.

H of a ball or of free flight also follows from placements:

    R, p    placement that the joint makes, R(e) of the unit quaternion e = (w, x, y, z)
    v, ω    its velocity and angular velocity, both in the moved frame

    Ṙ = R ω̃,  ṗ = R v           4 w² = 1 + tr R,  4 w (x, y, z) = (R_zy - R_yz, R_xz - R_zx, R_yx - R_xy)

The right sides, differentiated, give ẇ and then ẋ, ẏ, ż, where w is not 0. Generated code takes ½ e ∘ ω, which each
joint states and which holds everywhere; this formulation proves it.

References: Khalil and Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.90); Maruskin,
Introduction to Dynamical Systems and Geometric Mechanics (2012), chapter 8 (quasi-velocities, Boltzmann-Hamel
equations); Siciliano et al., Robotics (2009), eq. (7.44)-(7.45); Shepperd, Quaternion from Rotation Matrix, J. Guidance
and Control 1 (1978) 223.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from itertools import combinations

from symdyn.dynamics.mechanism.state import State, body_placements, vector
from symdyn.dynamics.mechanism.tree import Tree, body_inertia
from symdyn.errors import DerivationError, choice
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import LETTERS, Joint
from symdyn.spatial import Transform, Vec, add, cross, dot, neg, scale, sub, zero_vector

PLACES = {"body": ("bodies",), "body or point": ("bodies", "points")}
"""Where a name is looked for that shall be one of these."""


def check_place(scene: Scene, name: str, kind: str = "body or point") -> None:
    """Look whether a scene has a body, or a body or point, called `name`.

    Raises:
        DerivationError: it has none; with those that it has.
    """
    known = [one.name for place in PLACES[kind] for one in getattr(scene, place)]
    if name not in known:
        raise DerivationError(f"{scene.name}: there is no {kind} {name!r}; {choice(name, known)}")


def locate(scene: Scene, name: str, graph: Graph) -> tuple[str, Transform]:
    """Return the body that carries the body or point called `name`, and its placement there."""
    for point in scene.points:
        if point.name == name:
            return point.body, point.at.transform(graph)
    check_place(scene, name)
    return name, Transform.unit(graph)


def joints_below(scene: Scene, name: str) -> list[Joint]:
    """Return the joints from the ground to the body that carries the body or point called `name`."""
    found, carrying, (body, _) = list[Joint](), {j.child: j for j in scene.joints}, locate(scene, name, Graph())
    while body in carrying:
        found.insert(0, carrying[body])
        body = found[0].parent
    return found


# By differentiation


def placed(scene: Scene, name: str, graph: Graph) -> Transform:
    """Return the placement of a body or point in the ground frame."""
    body, local = locate(scene, name, graph)
    return body_placements(scene, graph)[body] @ local


def pose(T: Transform) -> list[Expr]:
    """Return [R | p] row by row, shape (3, 4)."""
    return [entry for row, shift in zip(T.R, T.p, strict=True) for entry in (*row, shift)]


def differentiated_acceleration(scene: Scene, name: str, graph: Graph) -> list[Expr]:
    """Return the acceleration of a body's centre of mass, the input of (5.11), shape (3,), ground frame, m/s^2."""
    motion = State.of(scene, graph).acceleration
    centre = body_placements(scene, graph)[name].point(centre_of_mass(scene, name, graph))
    return tangents(tangents(centre, motion), motion)


def point_motion(
    scene: Scene,
    named: Container[str],
    state: State,
    place: Callable[[str], Sequence[Expr]],
    qdd: Callable[[], Sequence[Expr]],
) -> dict[Expr, Expr]:
    """Return what is named of places, velocities and accelerations of points, and what these are rates of."""
    found: dict[Expr, Expr] = {}
    for point in scene.points:
        names = LETTERS.of_point(point.name)
        if asked := [k for k, name in enumerate(names) if name in named]:
            p = place(point.name)
            v = tangents(p, state.velocity) if asked[-1] > 2 else ()
            a = tangents(v, state.velocity | dict(zip(state.qd, qdd(), strict=True))) if asked[-1] > 5 else ()
            found |= zip(map(p[0].graph.symbol, names), (*p, *v, *a), strict=False)
    return found


# Recursive


def tree_placed(scene: Scene, tree: Tree, name: str) -> Transform:
    """Return the placement of a body or point in the ground frame."""
    body, local = locate(scene, name, tree.graph)
    carrier, home = tree.home[body]
    return tree.placements()[carrier] @ home @ local


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


Brackets = Mapping[tuple[int, int], tuple[tuple[int, int], ...]]


@dataclass(frozen=True)
class Directions:
    """Directions of the velocities.

    Attributes:
        q: coordinates, shape (nq,).
        along: along[i] maps every coordinate that velocity i moves to its rate per unit, H_ki.
        brackets: brackets[j, i] are pairs (l, γ^l_ji).
    """

    q: tuple[Expr, ...]
    along: tuple[dict[Expr, Expr], ...]
    brackets: Brackets

    @property
    def entries(self) -> tuple[Expr, ...]:
        """All H_ki that are not zero."""
        return tuple(h for seeds in self.along for h in seeds.values())

    def slopes(self, f: Expr) -> list[Expr]:
        """Return X_i f, shape (nv,)."""
        partial = dict(zip(self.q, gradient(f, self.q), strict=True))
        return [f.graph.total(h * partial[q] for q, h in seeds.items()) for seeds in self.along]

    def derivative(self, fs: Sequence[Expr], i: int) -> list[Expr]:
        """Return X_i f of several functions."""
        return tangents(fs, self.along[i])

    def christoffel(self, M: Matrix) -> Christoffel:
        """Return the connection of a symmetric mass matrix, shape (n, n), for velocities along these directions."""
        n = len(M)
        upper = [M[i][j] for i in range(n) for j in range(i, n)]
        slopes = []
        for k in range(n):
            flat = iter(self.derivative(upper, k))
            slope: Matrix = [[M[0][0]] * n for _ in range(n)]
            for i in range(n):
                for j in range(i, n):
                    slope[i][j] = slope[j][i] = next(flat)
            slopes.append(slope)
        return Christoffel(M, tuple(slopes), self.brackets)


def directions(scene: Scene, graph: Graph) -> Directions:
    """Return the directions of a scene's velocities."""
    state = State.of(scene, graph)
    along: list[dict[Expr, Expr]] = [{} for _ in state.qd]
    for q, rate in zip(state.q, state.rates, strict=True):
        for i, h in enumerate(gradient(rate, state.qd)):
            if not h.is_zero:
                along[i][q] = h
    brackets: dict[tuple[int, int], list[tuple[int, int]]] = {}
    first = 0
    for joint in scene.moving:
        for j, i, m, value in joint_motion(joint, graph).brackets:
            brackets.setdefault((first + j, first + i), []).append((first + m, value))
        first += len(joint.rates)
    return Directions(state.q, tuple(along), {pair: tuple(terms) for pair, terms in brackets.items()})


def has_quaternions(scene: Scene) -> bool:
    """Tell whether a velocity of the scene is no rate of a coordinate."""
    return len(scene.coordinates) != len(scene.velocities)


def rates_of_placements(scene: Scene, graph: Graph) -> list[Expr]:
    """Return q̇, shape (nq,), from the rates of placements."""
    result: list[Expr] = []
    for joint in scene.moving:
        q = tuple(graph.symbol(name) for name in joint.coordinates)
        u = tuple(graph.symbol(name) for name in joint.rates)
        for block in JOINTS[joint.type].blocks(joint):
            here, q = q[: len(block.coordinates)], q[len(block.coordinates) :]
            moving, u = u[: len(block.velocities)], u[len(block.velocities) :]
            result += block.quaternion_rates(here, moving) if block.letters else moving
    return result


Matrix = list[list[Expr]]


@dataclass(frozen=True)
class Christoffel:
    """The connection of a mass matrix: `slopes[k][i][j]` = X_k M_ij, and the brackets of the velocities."""

    M: Matrix
    slopes: tuple[Matrix, ...]
    brackets: Brackets

    @property
    def n(self) -> int:
        return len(self.slopes)

    def twice(self, i: int, j: int, k: int) -> Expr:
        """Return the coefficient of u_j u_k in force i, of j k and k j together: 2 c_ijk for rates of coordinates."""
        d = self.slopes
        return d[k][i][j] + d[j][i][k] - d[i][j][k] - self._turned(j, i, k) - self._turned(k, i, j)

    def centrifugal(self) -> Matrix:
        """Return k_D, shape (n, n)."""
        n = range(self.n)
        return [[self.twice(i, j, j) / 2 for j in n] for i in n]

    def coriolis(self) -> Matrix:
        """Return k_C, shape (n, n(n-1)/2)."""
        return [[self.twice(i, j, k) for j, k in combinations(range(self.n), 2)] for i in range(self.n)]

    def coriolis_matrix(self, qd: Sequence[Expr]) -> Matrix:
        """Return C(q, u), shape (n, n)."""
        n = range(self.n)
        zero = qd[0].graph.zero
        return [
            [sum(((self.twice(i, j, k) + self._turned(k, j, i)) / 2 * qd[k] for k in n), zero) for j in n] for i in n
        ]

    def _turned(self, j: int, i: int, k: int) -> Expr:
        """Return Σ γ^l_ji M_lk."""
        terms = self.brackets.get((j, i), ())
        return sum((self.M[m][k] * value for m, value in terms), self.M[0][0].graph.zero)


Twist = tuple[Vec, Vec]  # angular, linear


@dataclass(frozen=True)
class Relative:
    """Motion of the child relative to J, axes of J: its twist at P by unit velocity, and (α, that of P) at u̇ = 0."""

    X: Transform
    columns: dict[int, Twist]
    acceleration: Twist

    def twist(self, u: Sequence[Expr]) -> Twist:
        """Return (ω, Ṗ)."""
        graph = self.X.p[0].graph
        omega, v = zero_vector(graph), zero_vector(graph)
        for k, (z, s) in self.columns.items():
            omega, v = add(omega, scale(u[k], z)), add(v, scale(u[k], s))
        return omega, v


Seat = tuple[str, Transform]  # a body, and a frame in it


def relative_motion(
    tree: Tree, parent: Seat, child: Seat, speeds: Callable[[], tuple[list[Expr], list[Expr]]]
) -> Relative:
    """Return the motion of the child relative to J: inwards to the lowest common ancestor, then outwards.

    J is the parent's frame, and P the origin of the child's. `speeds` are the rate of every elementary joint, and the
    part of its acceleration that is quadratic in velocities.
    """
    graph = tree.graph
    (body, on_parent), (other, on_child) = parent, child
    i, at_parent = tree.home[body]
    j, at_child = tree.home[other]
    last = at_child @ on_child
    inner, outer = tree.paths(i, j)
    rate, accelerated = speeds()
    T = (at_parent @ on_parent).inverse()  # pose of the current frame in J
    still = zero_vector(graph)
    omega, alpha = still, still  # of the current body
    a = still  # acceleration of its origin
    axes: list[tuple[int, Vec, Vec]] = []  # elementary joint, its axis z, s
    steps = [T.p]  # from J to the first origin, from there to the next, ..., to P
    for b in inner:  # to the common ancestor: the joint backwards
        z, s = (neg(T.R @ part) for part in tree.S[b])
        axes.append((b, z, s))
        omega, alpha, a = _moved(omega, alpha, a, z, s, rate[b], accelerated[b])
        step = tree.T[b].inverse()
        steps.append(T.R @ step.p)
        a = add(a, _swing(omega, alpha, steps[-1]))
        T = T @ step
    for b in outer:
        steps.append(T.R @ tree.T[b].p)
        a = add(a, _swing(omega, alpha, steps[-1]))
        T = T @ tree.T[b]
        z, s = (T.R @ part for part in tree.S[b])
        axes.append((b, z, s))
        omega, alpha, a = _moved(omega, alpha, a, z, s, rate[b], accelerated[b])
    steps.append(T.R @ last.p)
    a = add(a, _swing(omega, alpha, steps[-1]))
    # a joint inwards is about the origin at which its step begins, one outwards about that at which it ends
    levers = [still]
    for d in reversed(steps[1:]):
        levers.append(add(levers[-1], d))
    levers.reverse()  # from the k-th origin to P
    columns: dict[int, Twist] = {}
    for place_of, (b, z, s) in enumerate(axes):
        lever = levers[place_of] if place_of < len(inner) else levers[place_of + 1]
        linear = add(s, cross(z, lever))
        for k, x in tree.A[b]:
            so_far = columns.get(k, (still, still))
            columns[k] = (add(so_far[0], scale(x, z)), add(so_far[1], scale(x, linear)))
    X = Transform(T.R @ last.R, add(steps[0], levers[0]))
    return Relative(X, dict(sorted(columns.items())), (alpha, a))


def _swing(omega: Vec, alpha: Vec, d: Vec) -> Vec:
    """Return α × d + ω × (ω × d), the last as (ω·d) ω - ω² d: one product less for planar motion."""
    turned = sub(scale(dot(omega, d), omega), scale(dot(omega, omega), d))
    return add(cross(alpha, d), turned)


def _moved(omega: Vec, alpha: Vec, a: Vec, z: Vec, s: Vec, rate: Expr, accelerated: Expr) -> tuple[Vec, Vec, Vec]:
    """Return ω, α, a of the successor of an elementary joint about or along an axis through the origin."""
    slide, spin = scale(rate, s), scale(rate, z)
    a = add(a, add(scale(2, cross(omega, slide)), scale(accelerated, s)))
    alpha = add(alpha, add(cross(omega, spin), scale(accelerated, z)))
    return add(omega, spin), alpha, a
