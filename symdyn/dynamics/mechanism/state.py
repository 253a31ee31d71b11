"""The symbols of a scene's state, and what a scene says, as nodes of a graph."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Graph
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import acceleration_name
from symdyn.spatial import Vec


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
        )

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


def quaternions(scene: Scene) -> list[tuple[str, ...]]:
    """Return the names of the coordinates that form unit quaternions (w, x, y, z)."""
    firsts = [(joint, JOINTS[joint.type].quaternion(joint)) for joint in scene.moving]
    return [joint.coordinates[first : first + 4] for joint, first in firsts if first is not None]


def vector(quantities: tuple[Quantity, Quantity, Quantity], graph: Graph) -> Vec:
    """Return a declared vector as nodes."""
    x, y, z = quantities
    return (x.express(graph), y.express(graph), z.express(graph))
