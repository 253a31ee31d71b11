"""The kinematic tree that the recursions run over: moving bodies only, frames at the joints.

A scene declares `pose of child in parent = origin · motion · tip`, with frames wherever the user put them. Here body i
has its frame in the moved joint frame, so that the joint axis is constant and as simple as declared. Everything that is
fixed to a body is part of it.

    i, p      a moving body 1..n and its parent, p < i; body 0 is the ground
    T[i]      placement of frame i in frame p
    S[i]      motion subspace of elementary joint i in frame i: (angular, linear)
    inertia   of body i about the origin of frame i, everything welded to it included

An *elementary joint* is a turn about one axis or a slide along it. A joint of several is a chain of as many bodies,
massless but for the last. Elementary joint i has

    rate           Σ_k A_ik u_k
    acceleration   Σ_k A_ik u̇_k + Σ b_i,jk u_j u_k

As a rule A_i is one 1. A joint that follows another one, a screw or a cam have other entries; a ball has b.

The rotor of a ball has the same inertia about all axes, so that its orientation does not matter:

    ω = Σ S_k u_k                                       angular velocity of the child relative to the parent
    K = ½ a ω·ω                                         a: the joint's armature, kg m^2
    τ_k = a S_k·α                                       α: its rate, seen from the parent or from the child alike
    α = Σ S_k u̇_k + Σ_{m<k} (S_m × S_k) u_m u_k         for turns one behind the other; S_k u̇_k alone for a quaternion

As at other joints, the rotation of the parent does not enter: it would add the gyroscopic effect of a rotor.

Constants that hide a zero or a simple fraction are recognised: cos²(40°) + sin²(40°) is built as a sum of products, and
whether two axes are parallel must not depend on that. A constant is computed at two precisions, as the constants of a
program are. A fraction that is recognised here enters one derivation only, and the proof against the other one checks
it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import arb

from symdyn.algebra import Midpoints, rounded
from symdyn.dynamics.mechanism.state import vector
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, substitute
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Body, Joint
from symdyn.spatial import Inertia, Mat, Transform, Vec, Wrench, add, cross, dot, scale, zero_vector


@dataclass(frozen=True)
class Topology:
    """How moving bodies 1..N hang together in n velocities; tuples have N + 1 entries, entry 0 is the ground.

    Attributes:
        graph: where the entries live.
        gravity: acceleration of free fall, ground frame, m/s^2.
        parent: parent[i] < i; parent[0] is -1.
        A: A[i] are pairs (velocity k from 0, coefficient), as in the module's legend; none for the ground.
        b: b[i] are triples (j, k, coefficient), as in the module's legend.
        block: block[i] are the elementary joints that end with i and belong together, () where i is not the last: (i,)
            but for velocities that are no rates of coordinates, those of one ball or one free flight being one block.
        armature: inertia of the rotor of elementary joint i, seen at the joint, kg m^2 or kg; zero at spherical joints.
        spherical_rotors: rotors of spherical joints, which belong to no elementary joint alone.
        n: number of velocities.
    """

    graph: Graph
    gravity: Vec
    parent: tuple[int, ...]
    A: tuple[tuple[tuple[int, Expr], ...], ...]
    b: tuple[tuple[tuple[int, int, Expr], ...], ...]
    block: tuple[tuple[int, ...], ...]
    armature: tuple[Expr, ...]
    spherical_rotors: tuple[SphericalRotor, ...]
    n: int

    @property
    def coupled(self) -> bool:
        """Whether elementary joints share a velocity, or a rate is no velocity: else joint i has velocity i - 1."""
        return any(self.A[i] != ((i - 1, self.graph.one),) for i in self.outward())

    def outward(self) -> range:
        """Return the moving bodies from the ground to the tips."""
        return range(1, len(self.parent))

    def inward(self) -> range:
        """Return the moving bodies from the tips to the ground."""
        return range(len(self.parent) - 1, 0, -1)

    def paths(self, i: int, j: int) -> tuple[list[int], list[int]]:
        """Return the joints from body i inwards to the nearest common carrier, and from there outwards to body j."""
        inner, outer = [], []
        while i != j:
            if i > j:
                inner.append(i)
                i = self.parent[i]
            else:
                outer.append(j)
                j = self.parent[j]
        return inner, outer[::-1]

    def rates(self, qd: Sequence[Expr]) -> list[Expr]:
        """Return the rate of every elementary joint, entry 0 the ground's, for velocities of shape (n,)."""
        return [self.graph.total(x * qd[k] for k, x in row) for row in self.A]

    def bias(self, qd: Sequence[Expr]) -> list[Expr]:
        """Return the part of every joint's acceleration that is quadratic in the velocities, entry 0 the ground's."""
        return [self.graph.total(x * qd[j] * qd[k] for j, k, x in triples) for triples in self.b]

    def accelerations(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
        """Return the acceleration of every elementary joint, entry 0 the ground's, for velocities and their rates."""
        return [a + b for a, b in zip(self.rates(qdd), self.bias(qd), strict=True)]

    def generalized_forces(self, forces: Sequence[Expr]) -> list[Expr]:
        """Return the forces on the velocities, shape (n,), for the forces of elementary joints, entry 0 unused."""
        total = [self.graph.zero] * self.n
        for i in self.outward():
            for k, x in self.A[i]:
                total[k] = total[k] + x * forces[i]
        return total

    def generalized_matrix(self, entries: Mapping[tuple[int, int], Expr]) -> list[list[Expr]]:
        """Return Σ_ij A_ik x_ij A_jl, shape (n, n), for x_ij of pairs of elementary joints."""
        matrix = [[self.graph.zero] * self.n for _ in range(self.n)]
        for (i, j), value in entries.items():
            for k, x in self.A[i]:
                for m, y in self.A[j]:
                    matrix[k][m] = matrix[k][m] + x * y * value
        return matrix

    def spherical_rotor_forces(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
        """Return what the rotors of spherical joints need, shape (n,); N m."""
        forces = [self.graph.zero] * self.n
        for ball in self.spherical_rotors:
            for k, moment in zip(ball.velocities, ball.forces(qd, qdd), strict=True):
                forces[k] = forces[k] + moment
        return forces

    def velocity_parents(self, kept: Sequence[int] | None = None) -> list[int]:
        """Return the tree of velocities 1..n for `linear_solve`: that of the joints, or a chain where joints share.

        Of `kept` velocities, ascending from 0, each hangs on its nearest ancestor among them.
        """
        parent = list(range(-1, self.n)) if self.coupled else list(self.parent)
        if kept is None:
            return parent
        place = {0: 0} | {k + 1: i for i, k in enumerate(kept, 1)}
        shorter = [-1]
        for k in kept:
            above = parent[k + 1]
            while above not in place:
                above = parent[above]
            shorter.append(place[above])
        return shorter


@dataclass(frozen=True)
class Tree(Topology):
    """A tree of moving bodies with the frames that the scene declares.

    Attributes:
        base: base[i] is the placement of elementary joint i, at zero, in frame p; constant but for a ball's.
        T, S, inertia: as in the module's legend; T[i] is base[i] and then the joint's motion.
        position: position of elementary joint i in terms of the coordinates, rad or m.
        home: for every body of the scene the moving body that carries it, and its placement there.
        joint: for every joint the moving body that carries its joint frame, and its placement there; and the last
            body of its chain (the carrier itself for a fixed joint), and the placement of its moved joint frame there.
    """

    base: tuple[Transform, ...]
    T: tuple[Transform, ...]
    S: tuple[tuple[Vec, Vec], ...]
    inertia: tuple[Inertia, ...]
    position: tuple[Expr, ...]
    home: dict[str, tuple[int, Transform]]
    joint: dict[str, tuple[tuple[int, Transform], tuple[int, Transform]]]

    def placements(self) -> list[Transform]:
        """Return T_0i of every frame, the ground first."""
        placements = [Transform.unit(self.graph)]
        for i in self.outward():
            placements.append(placements[self.parent[i]] @ self.T[i])
        return placements

    def motion(self, qd: Sequence[Expr], qdd: Sequence[Expr], ground: Vec) -> list[TreeMotion]:
        """Return the motion of every frame, the ground first: its acceleration -g puts gravity into every body."""
        zeros = zero_vector(self.graph)
        rate, acceleration = self.rates(qd), self.accelerations(qd, qdd)
        motion = [TreeMotion(zeros, zeros, ground)]
        for i in self.outward():
            (z, s), E, r = self.S[i], self.T[i].R, self.T[i].p
            parent = motion[self.parent[i]]
            wp = E.T @ parent.w
            spin, slide = scale(rate[i], z), scale(rate[i], s)
            w = add(wp, spin)
            dw = add(add(E.T @ parent.dw, cross(wp, spin)), scale(acceleration[i], z))
            a = add(add(E.T @ parent.at(r), scale(2, cross(wp, slide))), scale(acceleration[i], s))
            motion.append(TreeMotion(w, dw, a))
        return motion


@dataclass(frozen=True)
class TreeMotion:
    """Motion of one frame, in its own axes; see `kinematics`. rad/s, rad/s^2, m/s^2."""

    w: Vec
    dw: Vec
    a: Vec

    def at(self, r: Vec) -> Vec:
        """Return the acceleration of a point at r: a + ω̇ × r + ω × (ω × r)."""
        return add(self.a, add(cross(self.dw, r), cross(self.w, cross(self.w, r))))


def build_tree(scene: Scene, graph: Graph) -> Tree:
    """Return the scene's kinematic tree."""
    identity, zeros = Transform.unit(graph), zero_vector(graph)
    rows: list[tuple[object, ...]] = [(-1, identity, identity, Wrench.none(graph), graph.zero, (), (), graph.zero)]
    block: list[tuple[int, ...]] = [()]
    inertia, rotors = [Inertia.none(graph)], list[SphericalRotor]()
    velocities = {name: k for k, name in enumerate(scene.velocities)}
    home: dict[str, tuple[int, Transform]] = {Scene.GROUND: (0, identity)}
    ends: dict[str, tuple[tuple[int, Transform], tuple[int, Transform]]] = {}
    for joint, body in zip(scene.joints, scene.bodies, strict=True):
        carrier, place = home[joint.parent]
        place = place @ joint.origin.transform(graph)
        start = (carrier, place)
        motion = joint_motion(joint, graph)
        moved: dict[int, list[tuple[int, Expr]]] = {}  # of each rate of the joint: by which velocities, and how much
        for name, k, ratio in joint.moved_by(graph):
            moved.setdefault(k, []).append((velocities[name], ratio))
        ball = spherical_rotor(joint, [v for pairs in moved.values() for v, _ in pairs], graph)
        rotors += [] if ball is None else [ball]
        rotor = joint.armature.express(graph) if ball is None else graph.zero
        block += motion.blocks(len(block))
        for part in motion.joints:
            here = place @ part.before
            T, S = here @ part.placement, (zeros, part.axis) if part.slides else (part.axis, zeros)
            A = tuple((v, ratio * x) for k, x in part.rate for v, ratio in moved[k])
            b = tuple((v, w, r * s * x) for j, k, x in part.bias for v, r in moved[j] for w, s in moved[k])
            rows.append((carrier, here, T, S, part.amount, A, b, rotor))
            rotor = graph.zero
            inertia.append(Inertia.none(graph))
            carrier, place = len(rows) - 1, identity
        place = place @ motion.tail
        ends[joint.name] = (start, (carrier, place))
        place = place @ joint.tip.transform(graph)
        home[body.name] = (carrier, place)
        inertia[carrier] = inertia[carrier] + body_inertia(body, graph).seen_from(place)
    columns = zip(("parent", "base", "T", "S", "position", "A", "b", "armature"), zip(*rows, strict=True), strict=True)
    return Tree(
        graph=graph,
        gravity=vector(scene.gravity, graph),
        spherical_rotors=tuple(rotors),
        block=tuple(block),
        n=len(velocities),
        inertia=tuple(inertia),
        home=home,
        joint=ends,
        **dict(columns),
    )


def body_inertia(body: Body, graph: Graph) -> Inertia:
    """Return the inertia of a declared body about the origin of its own frame."""
    total = Inertia.none(graph)
    for particle in body.particles:
        total = total + Inertia.of_point(particle.mass.express(graph), vector(particle.at, graph))
    m = body.mass.express(graph)
    matrix = Mat.symmetric(*(entry.express(graph) for entry in body.inertia))
    if body.about == "frame":
        return total + Inertia(m, body.mass_moment(graph), matrix)
    assert body.com is not None
    steiner = Inertia.of_point(m, vector(body.com, graph))
    return total + Inertia(m, steiner.h, matrix + steiner.I)


@dataclass(frozen=True)
class SphericalRotor:
    """The rotor of one ball; see the module's legend."""

    inertia: Expr  # a, kg m^2
    velocities: tuple[int, ...]  # numbers from 0 of the three velocities
    S: tuple[Vec, ...]  # one a velocity, in axes behind the first turn, or (a quaternion's) in the moved ones
    bent: tuple[tuple[int, int, Vec], ...]  # pairs m < k with S_m × S_k

    def forces(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
        """Return what turns the rotor along each of the ball's velocities, N m, for those of the scene."""
        u, du = ([of[k] for k in self.velocities] for of in (qd, qdd))
        alpha = zero_vector(self.inertia.graph)
        for S, rate in zip(self.S, du, strict=True):
            alpha = add(alpha, scale(rate, S))
        for m, k, across in self.bent:
            alpha = add(alpha, scale(u[m] * u[k], across))
        return [self.inertia * dot(S, alpha) for S in self.S]

    def entries(self) -> Iterator[tuple[int, int, Expr]]:
        """Yield rows and columns of the mass matrix and what the rotor adds there, kg m^2."""
        for i, first in zip(self.velocities, self.S, strict=True):
            for j, second in zip(self.velocities, self.S, strict=True):
                yield i, j, self.inertia * dot(first, second)


def spherical_rotor(joint: Joint, velocities: Sequence[int], graph: Graph) -> SphericalRotor | None:
    """Return the rotor of a ball whose velocities have these numbers; None where there is none, or it is no ball."""
    inertia = joint.armature.express(graph)
    if inertia.is_zero or not JOINTS[joint.type].ball(joint):
        return None
    place, S = Transform.unit(graph), []
    for k, part in enumerate(joint_motion(joint, graph).joints):
        if k:  # what stands in front of the first turn, or of the axes of a quaternion, turns all of S alike
            place = place @ part.before
        S.append(place.R @ part.axis)
        if k:
            place = place @ part.placement
    pairs = [] if joint.velocities else [(0, 1), (0, 2), (1, 2)]
    return SphericalRotor(inertia, tuple(velocities), tuple(S), tuple((m, k, cross(S[m], S[k])) for m, k in pairs))


DIGITS = 100
SIMPLE = 10**9
WHOLE_TURN = 1_296_000  # arc seconds
SAME = Fraction(1, 10**60)


def settle(nodes: Sequence[Expr]) -> list[Expr]:
    """Return the nodes, hidden fractions replaced by what they are."""
    hidden = [node for node in nodes if node.args and not has_symbols(node)]
    if not hidden:
        return list(nodes)
    settled = hidden[0].graph.found.setdefault("settled", {})
    fresh = [node for node in hidden if node not in settled]
    settled.update((node, _settled(node, value)) for node, value in zip(fresh, values_of(fresh), strict=True))
    return [settled.get(node, node) for node in nodes]


def values_of(nodes: Sequence[Expr]) -> list[Fraction]:
    """Return the values of nodes without symbols, to 100 digits where they are no fractions.

    Raises:
        DerivationError: a constant is no finite real number; so of all in this file.
    """
    known = [rational(node) for node in nodes]
    if None not in known:
        return [value for value in known if value is not None]
    seen = nodes[0].graph.found.setdefault("constants", {})
    try:
        fresh = reachable(nodes, seen)
        with Midpoints(DIGITS) as numbers:
            seen.update(zip(fresh, evaluate(fresh, numbers, seen), strict=True))
        return [_fraction(seen[node]) for node in nodes]
    except (ArithmeticError, ValueError) as fault:
        raise DerivationError("a constant of the scene's placements is no finite real number") from fault


def in_fractions(nodes: Sequence[Expr]) -> list[Expr]:
    """Return the nodes with every constant as a fraction: those that are none are rounded."""
    every = reachable(nodes)
    varying: set[Expr] = set()
    for node in every:
        if node.op is Op.SYMBOL or not varying.isdisjoint(node.args):
            varying.add(node)
    outermost = [*nodes, *(arg for node in every if node in varying for arg in node.args)]
    inexact = [x for x in dict.fromkeys(outermost) if x not in varying and rational(x) is None]
    if not inexact:
        return list(nodes)
    values = (x.graph.constant(rounded(value, DIGITS)) for x, value in zip(inexact, values_of(inexact), strict=True))
    return substitute(nodes, dict(zip(inexact, values, strict=True)))


def turns_of(cosine: Expr, sine: Expr) -> Fraction | None:
    """Return the angle with this cosine and sine, both numbers, in turns within ±1/2; None if it is no simple part."""
    values = values_of([cosine, sine])
    with Midpoints(DIGITS) as numbers:
        c, s = map(numbers.constant, values)
        turns = _fraction(arb.atan2(s, c) / (2 * numbers.pi()))
    simple = turns.limit_denominator(WHOLE_TURN)
    return simple if abs(simple - turns) <= SAME else None


def rational(node: Expr) -> Fraction | None:
    """Return the value of a constant fraction, None for anything else."""
    return node.value if isinstance(node.value, Fraction) else None


def has_symbols(node: Expr) -> bool:
    """Return whether a node depends on anything."""
    seen = node.graph.found.setdefault("symbols", {})
    for inner in reachable([node], seen):
        seen[inner] = inner.op is Op.SYMBOL or any(seen[arg] for arg in inner.args)
    return bool(seen[node])


def _settled(node: Expr, value: Fraction) -> Expr:
    simple = value.limit_denominator(SIMPLE)
    return node.graph.constant(simple) if abs(simple - value) <= SAME else node


def _fraction(value: Any) -> Fraction:
    """Return the midpoint of a ball as the fraction that it is."""
    if not value.is_finite():
        raise ValueError(f"{value} is not finite")
    mantissa, exponent = value.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
