"""The symbols of a scene's state, and what a scene says, as nodes of a graph."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Graph, gradient, tangents
from symdyn.scene import JOINTS, Body, Joint, Pose, Quantity, Scene, acceleration_name, express, velocity_name
from symdyn.spatial import Transform, Vec, dot, elementary, scale, unit_transform


@dataclass(frozen=True)
class State:
    """Symbols of the state, each of shape (n,): q (rad or m), q̇, q̈, and the driving forces τ."""

    q: tuple[Expr, ...]
    qd: tuple[Expr, ...]
    qdd: tuple[Expr, ...]
    tau: tuple[Expr, ...]

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return len(self.q)


def state_symbols(scene: Scene, graph: Graph) -> State:
    """Return the state symbols; q and q̇ carry the names that formulas of the scene use."""
    names = scene.coordinates
    return State(
        q=tuple(graph.symbol(name) for name in names),
        qd=tuple(graph.symbol(velocity_name(name)) for name in names),
        qdd=tuple(graph.symbol(acceleration_name(name)) for name in names),
        tau=tuple(graph.symbol(f"tau[{i}]") for i in range(len(names))),
    )


def vector(quantities: tuple[Quantity, Quantity, Quantity], graph: Graph) -> Vec:
    """Return a declared vector as nodes."""
    x, y, z = quantities
    return (express(x, graph), express(y, graph), express(z, graph))


def unit_axis(joint: Joint, graph: Graph) -> Vec:
    """Return the joint's axis with length 1, exact (with a root where its length is irrational)."""
    axis = vector(joint.axis, graph)
    length = graph.sqrt(dot(axis, axis))
    return scale(graph.one / length, axis)


def placement(pose: Pose, graph: Graph) -> Transform:
    """Return a declared pose as a transform."""
    result = unit_transform(graph)
    for kind, amount in pose.steps:
        result = result @ elementary(kind, express(amount, graph))
    return result


def joint_position(joint: Joint, graph: Graph) -> Expr:
    """Return the position of a joint that moves, in terms of the coordinates; rad or m."""
    if joint.coupling is None:
        return graph.symbol(joint.coordinate)
    ratio, offset = express(joint.coupling.ratio, graph), express(joint.coupling.offset, graph)
    return ratio * graph.symbol(joint.coupling.coordinate) + offset


def joint_motion(joint: Joint, graph: Graph) -> Transform:
    """Return the placement of the moved joint frame in the joint frame."""
    q = (joint_position(joint, graph),) if joint.moves else ()
    return JOINTS[joint.type].motion(unit_axis(joint, graph), q)


def first_moment(body: Body, graph: Graph) -> Vec:
    """Return m r of the extended mass, kg m, body frame."""
    if body.first_moment is not None:
        return vector(body.first_moment, graph)
    assert body.com is not None
    m, r = express(body.mass, graph), vector(body.com, graph)
    return (m * r[0], m * r[1], m * r[2])


def generalized_forces(scene: Scene, graph: Graph) -> list[Expr]:
    """Return Q^A of (5.22), shape (n,): declared forces and viscous damping, everything but the drives; N m or N."""
    state = state_symbols(scene, graph)
    rates = dict(zip(state.q, state.qd, strict=True))
    declared = {joint.coordinate: express(joint.force, graph) for joint in scene.moving}
    forces = [declared[name] for name in scene.coordinates]
    for joint in scene.joints:
        damping = express(joint.damping, graph)
        if damping.is_zero or not joint.moves:
            continue
        position = joint_position(joint, graph)
        (rate,) = tangents([position], rates)
        for k, slope in enumerate(gradient(position, state.q)):
            forces[k] = forces[k] - damping * rate * slope
    return forces
