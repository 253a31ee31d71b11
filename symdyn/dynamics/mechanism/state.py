"""The state of a scene as symbols, and what follows from it: placements, elastic energy, generalized forces.

Placements of bodies in the ground frame are products of the joints' placements, from the ground to the tips.
Generalized forces Q hold everything but gravity and drives: struts, friction, loads.

    x, v    position of a joint or distance of two points, and its rate
    E       energy that struts store, J
    Q_i     F·∂ṗ/∂u_i + C·∂ω/∂u_i, virtual work of force F at p and couple C; of a strut or dry friction -F ∂v/∂u_i

Here Q comes from derivatives of positions, as in Lagrange's equations. `wrenches` finds the same forces along the tree;
only the laws of force are common to both.

A prescribed coordinate follows a formula in time and inputs, whatever force that takes. It stays in q. In forward
dynamics its acceleration is known and its force is not: with p for prescribed and f for free velocities

    M_ff u̇_f = τ_f - (M_fp u̇_p + h_f)      τ_p = M_pf u̇_f + M_pp u̇_p + h_p      h = c + g + k_E - Q

References: the textbook, eq. (5.22), for Q^A; Featherstone, Rigid Body Dynamics Algorithms (2008), section 9.1, for
hybrid dynamics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from symdyn.dynamics.mechanism.linear_solve import Singular, solve
from symdyn.dynamics.mechanism.ropes import Taut
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Joint, Letter, Load, Place, Strut, acceleration_name
from symdyn.spatial import Transform, Vec, Wrench, dot, sub


@dataclass(frozen=True)
class State:
    """Symbols of the state.

    Attributes:
        q: coordinates, shape (nq,); rad, m, or 1 for a quaternion.
        qd: velocities, shape (nv,): rates of the coordinates, but for a quaternion.
        qdd: their rates, shape (nv,).
        tau: driving forces, shape (nv,).
        rates: rate of every coordinate in terms of q and qd, shape (nq,); qd itself where there is no quaternion.
        spheres, clock: coordinates of every unit quaternion (w, x, y, z); as of `Scene`.
    """

    q: tuple[Expr, ...]
    qd: tuple[Expr, ...]
    qdd: tuple[Expr, ...]
    tau: tuple[Expr, ...]
    rates: tuple[Expr, ...]
    spheres: tuple[tuple[Expr, ...], ...]
    clock: Mapping[Expr, Expr]

    @classmethod
    def of(cls, scene: Scene, graph: Graph) -> State:
        """Return the symbols of a scene's state; they carry the names that formulas of the scene use."""
        velocities = scene.velocities
        return cls(
            q=tuple(graph.symbol(name) for name in scene.coordinates),
            qd=tuple(graph.symbol(name) for name in velocities),
            qdd=tuple(graph.symbol(acceleration_name(name)) for name in velocities),
            tau=tuple(graph.symbol(f"tau[{i}]") for i in range(len(velocities))),
            rates=tuple(rate for joint in scene.moving for rate in joint_motion(joint, graph).rates),
            spheres=tuple(tuple(map(graph.symbol, names)) for names in quaternions(scene)),
            clock=scene.clock(graph),
        )

    @property
    def motion(self) -> tuple[tuple[Expr, ...], tuple[Expr, ...], tuple[Expr, ...]]:
        """Coordinates, velocities and their rates."""
        return self.q, self.qd, self.qdd

    @property
    def n(self) -> int:
        return len(self.qd)

    @property
    def velocity(self) -> dict[Expr, Expr]:
        """Seeds of d/dt for what depends on q, and on what is given over time."""
        return {**self.clock, **dict(zip(self.q, self.rates, strict=True))}

    @property
    def acceleration(self) -> dict[Expr, Expr]:
        """Seeds of d/dt for what depends on q and qd."""
        return self.velocity | dict(zip(self.qd, self.qdd, strict=True))


def quaternions(scene: Scene) -> list[tuple[str, ...]]:
    """Return the names of the coordinates that form unit quaternions (w, x, y, z)."""
    firsts = [(joint, JOINTS[joint.type].quaternion(joint)) for joint in scene.moving]
    return [joint.coordinates[first : first + 4] for joint, first in firsts if first is not None]


def vector(quantities: tuple[Quantity, Quantity, Quantity], graph: Graph) -> Vec:
    """Return a declared vector as nodes."""
    x, y, z = quantities
    return (x.express(graph), y.express(graph), z.express(graph))


def ends_apart(scene: Scene, ends: Sequence[Place], graph: Graph) -> Vec:
    """Return the way from one place to another, m, in the frame of the last body that carries both."""
    carrier = {joint.child: joint for joint in scene.joints}
    paths = []
    for end in ends:
        path = [end.body]
        while path[-1] != Scene.GROUND:
            path.append(carrier[path[-1]].parent)
        paths.append(path)
    common = next(body for body in paths[0] if body in paths[1])
    points = []
    for end, path in zip(ends, paths, strict=True):
        point = vector(end.at, graph)
        for body in path[: path.index(common)]:
            point = joint_placement(carrier[body], graph).point(point)
        points.append(point)
    return sub(points[1], points[0])


def joint_placement(joint: Joint, graph: Graph) -> Transform:
    """Return the placement of a joint's child in its parent: origin · motion(q) · tip."""
    origin, tip = joint.origin.transform(graph), joint.tip.transform(graph)
    return origin @ joint_motion(joint, graph).placement @ tip


def body_placements(scene: Scene, graph: Graph) -> dict[str, Transform]:
    """Return T_0B for every body B, the ground's included.

    T_0B = T_0P · origin · motion(q) · tip for the joint that carries B on its parent P.
    """
    placed = {Scene.GROUND: Transform.unit(graph)}
    for joint in scene.joints:
        origin, tip = joint.origin.transform(graph), joint.tip.transform(graph)
        placed[joint.child] = placed[joint.parent] @ origin @ joint_motion(joint, graph).placement @ tip
    return placed


def moved_placements(scene: Scene, joint: Joint | None, graph: Graph) -> Iterator[tuple[int, Transform]]:
    """Yield, for every joint that moves the child, the number of its velocity and the child's placement before it.

    The frame is the joint frame, before the motion: joints nearer to the ground do not change a velocity written in the
    body. Of joints that share a velocity the last one counts, nearest to the ground: its placement holds the others.
    """
    number = {velocity: i for i, velocity in enumerate(scene.velocities)}
    carrier = {j.child: j for j in scene.joints}
    T = None
    while joint is not None:
        tip = joint.tip.transform(graph)
        T = tip if T is None else tip @ T
        if joint.moves:
            T = joint_motion(joint, graph).placement @ T
            for velocity, _, _ in joint.moved_by(graph):
                yield number[velocity], T
        T = joint.origin.transform(graph) @ T
        joint = None if joint.parent == Scene.GROUND else carrier[joint.parent]


# Laws of force


def pull(strut: Strut, square: Expr, rate: Expr) -> Expr:
    """Return the force of a strut between points over their distance, F / s, N/m, by s² (m²) and the rate of s (m/s).

    What does not pull where the points meet may have a value there; what pulls has no direction. Points that never
    part pull at nothing. The rate may be zero for what stores energy.
    """
    law, graph = FORCES[strut.kind].pull, square.graph
    if square.is_zero:
        return graph.zero
    if law.over is not None:
        return law.over(strut, square)
    s = graph.sqrt(square)
    return law.force(strut, s, rate) / s


def stored(strut: Strut, position: Expr) -> Expr:
    """Return the energy of a strut at a joint, J."""
    energy = FORCES[strut.kind].pull.energy
    return position.graph.zero if energy is None else energy(strut, position)


def stored_between(strut: Strut, square: Expr) -> Expr:
    """Return the energy of a strut between two points of squared distance s², J."""
    law = FORCES[strut.kind].pull
    return law.stored(strut, square) if law.stored else stored(strut, square.graph.sqrt(square))


def joint_resistance(joint: Joint, rate: Expr) -> Expr:
    """Return viscous damping and dry friction of a joint against one of its rates, N or N m."""
    viscous = joint.damping.express(rate.graph) * rate
    return viscous if joint.dry is None else viscous + FORCES[joint.dry.kind].rub.force(joint.dry, rate)


def refuse_ideal_friction(scene: Scene) -> None:
    """Raise DerivationError where dry friction has no smoothing: at rest an ideal sign has no value to integrate."""
    ideal = [
        joint.name for joint in scene.joints if joint.dry is not None and FORCES[joint.dry.kind].rub.jumps(joint.dry)
    ]
    if ideal:
        plural = "s" * (len(ideal) > 1)
        raise DerivationError(
            f"forward dynamics does not exist: dry friction in joint{plural} {', '.join(ideal)} is an ideal sign of "
            "the rate, and at rest it takes whatever value keeps the joint at rest, which no formula gives; runs "
            "stick and slip by it, linearize takes a mode; for a formula write a smoothing (a rate well below those "
            "of interest) to have tanh(rate / smoothing), or ask for inverse dynamics, where the sign is enough"
        )


# Elastic energy


def elastic_energy(scene: Scene, graph: Graph) -> Expr:
    """Return E(q) of all struts that store energy, J."""
    struts = elastic(scene)
    placed = body_placements(scene, graph) if struts else {}
    return graph.total(
        stored_between(strut, squared_length(placed, strut, graph))
        if strut.ends and not strut.is_rope
        else stored(strut, strut_way(scene, placed, strut, graph))
        for strut in struts
    )


def elastic_slopes(scene: Scene, graph: Graph, slopes: Callable[[Expr], list[Expr]]) -> list[Expr]:
    """Return X E, shape (nv,), for X that `slopes` applies: F X x at a joint, F/s X s² / 2 between points.

    s² has a slope where the points meet, and s has none.
    """
    struts = elastic(scene)
    placed = body_placements(scene, graph) if struts else {}
    found = [graph.zero] * len(scene.velocities)
    for strut in struts:
        if strut.ends and not strut.is_rope:
            x = squared_length(placed, strut, graph)
            force = pull(strut, x, graph.zero) / 2
        else:
            x = strut_way(scene, placed, strut, graph)
            force = FORCES[strut.kind].pull.force(strut, x, graph.zero)
        found = [total + force * slope for total, slope in zip(found, slopes(x), strict=True)]
    return found


def resisting(scene: Scene) -> tuple[Strut, ...]:
    """Return the struts that store no energy."""
    return tuple(one for one in scene.struts if FORCES[one.kind].pull.energy is None)


def joint_of(scene: Scene, strut: Strut) -> Joint:
    """Return the joint that a strut acts at."""
    return next(joint for joint in scene.joints if joint.name == strut.joint)


def strut_way(scene: Scene, placed: dict[str, Transform], strut: Strut, graph: Graph) -> Expr:
    """Return the way that a strut pulls along: position of a joint, distance of two points, length of a rope."""
    if strut.joint:
        return joint_of(scene, strut).position(graph)
    if strut.is_rope:
        return Taut(scene, graph).placed(strut.ends, placed)
    return graph.sqrt(squared_length(placed, strut, graph))


def squared_length(placed: dict[str, Transform], strut: Strut, graph: Graph) -> Expr:
    """Return the squared distance of the ends of a strut between points, m², from the placement of every body."""
    a, b = (placed[end.body].point(vector(end.at, graph)) for end in strut.ends)
    apart = sub(b, a)
    return dot(apart, apart)


# Generalized forces


def generalized_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return Q^A of (5.22), shape (nv,): everything but drives, gravity and what stores energy; N m or N."""
    state = State.of(scene, graph)
    struts, forces = resisting(scene), joint_forces(scene, graph)
    placed = body_placements(scene, graph) if struts or scene.loads else {}
    for strut in struts:
        if strut.ends:
            s = strut_way(scene, placed, strut, graph)
            (rate,) = tangents([s], state.velocity)
            _oppose(forces, rate, FORCES[strut.kind].pull.force(strut, s, rate), state)
    for load in scene.loads:
        work = _work(load, placed[load.place.body], scene, graph)
        forces = [force + share for force, share in zip(forces, work, strict=True)]
    return [force + share for force, share in zip(forces, carried_forces(scene, graph), strict=True)]


def carried_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the part of Q that loads have by the motion of their bodies, shape (nv,), N m or N."""
    moved = [load for load in scene.loads if FORCES[load.kind].push.carried]
    forces, placed = [graph.zero] * len(scene.velocities), body_placements(scene, graph) if moved else {}
    for load in moved:
        T = placed[load.place.body]
        at = Transform(T.R, T.point(vector(scene.seated(load).place.at, graph)))
        wrench, columns = carried(load, scene, T), placement_rates(at, scene, graph)
        forces = [force + wrench.power(twist) for force, twist in zip(forces, columns, strict=True)]
    return forces


def carried(load: Load, scene: Scene, T: Transform) -> Wrench:
    """Return what a load has by the motion of its body, whose placement is T, at its place, ground axes."""
    law, graph = FORCES[load.kind].push.carried, T.p[0].graph
    if law is None:
        return Wrench.none(graph)
    p, rates = T.point(vector(scene.seated(load).place.at, graph)), State.of(scene, graph).velocity
    x, y, z = tangents(p, rates)
    turning = T.R.spin([tangents(row, rates) for row in T.R])
    return law(load, scene, T.R.T @ (x, y, z), T.R.T @ turning).rotated(T.R)


def joint_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the part of Q that acts at joints: declared forces, damping, friction, struts; shape (nv,), N m or N."""
    state, forces = State.of(scene, graph), declared_forces(scene, graph)
    for joint in scene.joints:
        for rate in joint.speeds(graph):
            _oppose(forces, rate, joint_resistance(joint, rate), state)
    for strut in resisting(scene):
        if strut.joint:
            joint = joint_of(scene, strut)
            (rate,) = joint.speeds(graph)
            _oppose(forces, rate, FORCES[strut.kind].pull.force(strut, joint.position(graph), rate), state)
    return forces


def _oppose(forces: list[Expr], rate: Expr, force: Expr, state: State) -> None:
    """Let a force act against a rate."""
    for i, share in enumerate(gradient(rate, state.qd)):
        forces[i] = forces[i] - force * share


def declared_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the generalized forces that the joints declare, shape (nv,); N m or N."""
    return [
        force.express(graph) for joint in scene.joints for force in joint.forces or (Quantity.ZERO,) * len(joint.rates)
    ]


def _work(load: Load, T: Transform, scene: Scene, graph: Graph) -> list[Expr]:
    """Return F·∂ṗ/∂u_i + C·∂ω/∂u_i for every velocity; F and C do no work of their own on the way."""
    wrench = load_vectors(load, scene, graph)
    if load.frame == "body":
        wrench = wrench.rotated(T.R)
    columns = placement_rates(Transform(T.R, T.point(vector(scene.seated(load).place.at, graph))), scene, graph)
    return [wrench.power(twist) for twist in columns]


def load_vectors(load: Load, scene: Scene, graph: Graph) -> Wrench:
    """Return force and couple of a load along the axes of its frame, N and N m."""
    return FORCES[load.kind].push.wrench(load, scene, graph)


def placement_rates(T: Transform, scene: Scene, graph: Graph) -> list[Wrench]:
    """Return (∂ṗ/∂u_i, ∂ω/∂u_i) of a placement for every velocity, ground frame, from ω̃ = Ṙ Rᵀ."""
    state = State.of(scene, graph)
    rates = tangents((*T.p, *T.R[0], *T.R[1], *T.R[2]), state.velocity)
    columns = []
    for u in state.qd:
        x = tangents(rates, {u: graph.one})
        columns.append(Wrench((x[0], x[1], x[2]), T.R.spin((x[3:6], x[6:9], x[9:12]))))
    return columns


TIME = "t"
"""Name of time in formulas and on the graph, s."""

INPUTS, STATES = "inputs", "internal"
"""Names of the arguments of what depends on letters that are given over time, and on states of one's own.

Generated code counts `states`.
"""


def letters_of(scene: Scene, argument: str) -> tuple[Letter, ...]:
    """Return the letters of an argument, `INPUTS` or `STATES`."""
    return scene.inputs if argument == INPUTS else scene.states


def symbols_of(scene: Scene, graph: Graph, argument: str) -> tuple[Expr, ...]:
    """Return the symbols of the entries of such an argument."""
    return tuple(graph.symbol(one.name) for one in letters_of(scene, argument))


def has_motion(scene: Scene) -> bool:
    """Whether a motion is prescribed."""
    return any(joint.motion is not None for joint in scene.joints)


@dataclass(frozen=True)
class Prescribed:
    """Prescribed motions.

    Attributes:
        n: number of velocities.
        place: velocities with a prescribed motion, from 0, ascending.
        position, velocity, acceleration: of each, formulas in t, and in inputs and their rates.
    """

    n: int
    place: tuple[int, ...]
    position: tuple[Expr, ...]
    velocity: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]

    @property
    def free(self) -> list[int]:
        """Velocities without a prescribed motion, from 0, ascending."""
        return [k for k in range(self.n) if k not in self.place]

    def entered(self, values: Sequence[Expr]) -> list[Expr]:
        """Return rates of velocities, shape (n,), with the prescribed ones in their places."""
        result = list(values)
        for k, value in zip(self.place, self.acceleration, strict=True):
            result[k] = value
        return result


def prescribed(scene: Scene, graph: Graph) -> Prescribed:
    """Return the prescribed motions of a scene, and their derivatives by time."""
    known = [(scene.velocities.index(j.rates[0]), j.motion) for j in scene.joints if j.motion is not None]
    known.sort(key=lambda pair: pair[0])
    seeds = scene.clock(graph) | {graph.symbol(TIME): graph.one} if known else {}
    position = [formula.express(graph) for _, formula in known]
    velocity = tangents(position, seeds)
    acceleration = tangents(velocity, seeds)
    place = tuple(k for k, _ in known)
    return Prescribed(len(scene.velocities), place, tuple(position), tuple(velocity), tuple(acceleration))


def accelerations(
    given: Prescribed, parents: Sequence[int], M: list[list[Expr]], tau: Sequence[Expr], bias: Sequence[Expr]
) -> list[Expr]:
    """Return u̇, shape (n,): prescribed where it is, else from M_ff u̇_f = τ_f - bias_f; Singular where M_ff is.

    The bias is M u̇ + h for the prescribed accelerations alone; `parents` is the tree of the free velocities.
    """
    free = given.free
    own = [[M[i][j] for j in free] for i in free]
    try:
        found = solve(parents, own, [tau[i] - bias[i] for i in free])
    except Singular as fault:
        raise Singular(free[fault.velocity]) from fault
    result = given.entered([M[0][0].graph.zero] * given.n) if given.n else []
    for i, value in zip(free, found, strict=True):
        result[i] = value
    return result
