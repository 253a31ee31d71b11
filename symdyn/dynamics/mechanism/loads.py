"""What acts beside gravity and drives, by positions and their derivatives: struts, friction, loads.

    x, v    position of a joint or distance of two points, and its rate
    E       energy that struts store, J
    Q_i     F·∂ṗ/∂u_i + C·∂ω/∂u_i, virtual work of force F at p and couple C; of a strut or dry friction -F ∂v/∂u_i

This is the Lagrange formulation; `wrenches` finds the same forces along the tree. Both share the laws of force only.

Reference: the textbook, eq. (5.22), Q^A.
"""

from __future__ import annotations

from collections.abc import Callable

from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.mechanism.state import State, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.values import Joint, Load, Place, Strut
from symdyn.spatial import Transform, Vec, Wrench, dot, sub

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
            "the rate, and at rest it takes whatever value keeps the joint at rest, which no formula gives; write a "
            "smoothing (a rate well below those of interest) to have tanh(rate / smoothing), or ask for inverse "
            "dynamics, where the sign is enough"
        )


# Elastic energy


def elastic_energy(scene: Scene, graph: Graph) -> Expr:
    """Return E(q) of all struts that store energy, J."""
    struts = elastic(scene)
    placed = body_placements(scene, graph) if struts else {}
    return graph.total(
        stored_between(strut, squared_length(placed, strut, graph))
        if strut.ends
        else stored(strut, joint_of(scene, strut).position(graph))
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
        if strut.ends:
            x = squared_length(placed, strut, graph)
            force = pull(strut, x, graph.zero) / 2
        else:
            x = joint_of(scene, strut).position(graph)
            force = FORCES[strut.kind].pull.force(strut, x, graph.zero)
        found = [total + force * slope for total, slope in zip(found, slopes(x), strict=True)]
    return found


def resisting(scene: Scene) -> tuple[Strut, ...]:
    """Return the struts that store no energy."""
    return tuple(one for one in scene.struts if FORCES[one.kind].pull.energy is None)


def joint_of(scene: Scene, strut: Strut) -> Joint:
    """Return the joint that a strut acts at."""
    return next(joint for joint in scene.joints if joint.name == strut.joint)


def squared_length(placed: dict[str, Transform], strut: Strut, graph: Graph) -> Expr:
    """Return the squared distance of the ends of a strut between points, m², from the placement of every body."""
    a, b = (_point(placed, end, graph) for end in strut.ends)
    apart = sub(b, a)
    return dot(apart, apart)


def _point(placed: dict[str, Transform], place: Place, graph: Graph) -> Vec:
    return placed[place.body].point(vector(place.at, graph))


# Generalized forces


def generalized_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return Q^A of (5.22), shape (nv,): everything but drives, gravity and what stores energy; N m or N."""
    state = State.of(scene, graph)
    forces = joint_forces(scene, graph)
    struts = resisting(scene)
    placed = body_placements(scene, graph) if struts or scene.loads else {}
    for strut in struts:
        if strut.ends:
            s = graph.sqrt(squared_length(placed, strut, graph))
            (rate,) = tangents([s], state.velocity)
            _oppose(forces, rate, FORCES[strut.kind].pull.force(strut, s, rate), state)
    for load in scene.loads:
        work = _work(load, placed[load.place.body], scene, graph)
        forces = [force + share for force, share in zip(forces, work, strict=True)]
    return forces


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
    wrench = load_vectors(load, graph)
    if load.frame == "body":
        wrench = wrench.rotated(T.R)
    columns = placement_rates(Transform(T.R, T.point(vector(load.place.at, graph))), scene, graph)
    return [wrench.power(twist) for twist in columns]


def load_vectors(load: Load, graph: Graph) -> Wrench:
    """Return force and couple of a load along the axes of its frame, N and N m."""
    return FORCES[load.kind].push.wrench(load, graph)


def placement_rates(T: Transform, scene: Scene, graph: Graph) -> list[Wrench]:
    """Return (∂ṗ/∂u_i, ∂ω/∂u_i) of a placement for every velocity, ground frame, from ω̃ = Ṙ Rᵀ."""
    state = State.of(scene, graph)
    rates = tangents((*T.p, *T.R[0], *T.R[1], *T.R[2]), state.velocity)
    columns = []
    for u in state.qd:
        x = tangents(rates, {u: graph.one})
        columns.append(Wrench((x[0], x[1], x[2]), T.R.spin((x[3:6], x[6:9], x[9:12]))))
    return columns
