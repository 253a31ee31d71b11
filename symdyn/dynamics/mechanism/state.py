"""The symbols of a scene's state, and what a scene says, as nodes of a graph."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Graph
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import JOINTS, JointMotion
from symdyn.scene.values import Body, Joint, Pose, acceleration_name, velocity_name
from symdyn.spatial import Transform, Vec


@dataclass(frozen=True)
class State:
    """Symbols of the state.

    Attributes:
        q: coordinates, shape (nq,); rad, m, or 1 for a quaternion.
        qd: velocities, shape (nv,): rates of the coordinates, but for a quaternion.
        qdd: their rates, shape (nv,).
        tau: driving forces, shape (nv,).
        rates: rate of every coordinate in terms of q and qd, shape (nq,); qd itself where there is no quaternion.
    """

    q: tuple[Expr, ...]
    qd: tuple[Expr, ...]
    qdd: tuple[Expr, ...]
    tau: tuple[Expr, ...]
    rates: tuple[Expr, ...]

    @property
    def motion(self) -> tuple[tuple[Expr, ...], tuple[Expr, ...], tuple[Expr, ...]]:
        """Coordinates, velocities and their rates."""
        return self.q, self.qd, self.qdd

    @property
    def n(self) -> int:
        """Number of velocities."""
        return len(self.qd)

    @property
    def velocity(self) -> dict[Expr, Expr]:
        """Seeds of d/dt for what depends on q."""
        return dict(zip(self.q, self.rates, strict=True))

    @property
    def acceleration(self) -> dict[Expr, Expr]:
        """Seeds of d/dt for what depends on q and qd."""
        return self.velocity | dict(zip(self.qd, self.qdd, strict=True))


def state_symbols(scene: Scene, graph: Graph) -> State:
    """Return the state symbols; they carry the names that formulas of the scene use."""
    velocities = scene.velocities
    return State(
        q=tuple(graph.symbol(name) for name in scene.coordinates),
        qd=tuple(graph.symbol(name) for name in velocities),
        qdd=tuple(graph.symbol(acceleration_name(name)) for name in velocities),
        tau=tuple(graph.symbol(f"tau[{i}]") for i in range(len(velocities))),
        rates=tuple(rate for joint in scene.moving for rate in joint_motion(joint, graph).rates),
    )


def quaternions(scene: Scene) -> list[tuple[str, ...]]:
    """Return the names of the coordinates that form unit quaternions (w, x, y, z)."""
    firsts = [(joint, JOINTS[joint.type].quaternion(joint)) for joint in scene.moving]
    return [joint.coordinates[first : first + 4] for joint, first in firsts if first is not None]


def vector(quantities: tuple[Quantity, Quantity, Quantity], graph: Graph) -> Vec:
    """Return a declared vector as nodes."""
    x, y, z = quantities
    return (x.express(graph), y.express(graph), z.express(graph))


def placement(pose: Pose, graph: Graph) -> Transform:
    """Return a declared pose as a transform."""
    result = Transform.unit(graph)
    for kind, amount in pose.steps:
        result = result @ Transform.elementary(kind, amount.express(graph))
    return result


def joint_position(joint: Joint, graph: Graph) -> Expr:
    """Return the position of a joint with one freedom in terms of the coordinates; rad or m."""
    if joint.coupling is None:
        return graph.symbol(joint.coordinates[0])
    ratio, offset = joint.coupling.ratio.express(graph), joint.coupling.offset.express(graph)
    return ratio * graph.symbol(joint.coupling.coordinate) + offset


def joint_motion(joint: Joint, graph: Graph) -> JointMotion:
    """Return the motion of the moved joint frame in the joint frame; velocities count from the joint's first."""
    if joint.coupling is not None:
        ratio = joint.coupling.ratio.express(graph)
        leader = graph.symbol(velocity_name(joint.coupling.coordinate))
        position = joint_position(joint, graph)
        return JOINTS[joint.type].motion(joint, graph, (position,), (ratio * leader,))
    q = tuple(graph.symbol(name) for name in joint.coordinates)
    return JOINTS[joint.type].motion(joint, graph, q, tuple(graph.symbol(name) for name in joint.rates))


def first_moment(body: Body, graph: Graph) -> Vec:
    """Return m r of the extended mass, kg m, body frame."""
    if body.first_moment is not None:
        return vector(body.first_moment, graph)
    assert body.com is not None
    m, r = body.mass.express(graph), vector(body.com, graph)
    return (m * r[0], m * r[1], m * r[2])
