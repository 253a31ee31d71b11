"""A body of a scene: its mass, inertia, particles and outline, and where things stand on it."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Graph
from symdyn.scene.values.quantity import NULL, Quantity, Vector
from symdyn.spatial import Transform, Vec


@dataclass(frozen=True)
class Pose:
    """A placement as a product of elementary motions, read from left to right.

    Attributes:
        steps: pairs of "Tx", "Ty", "Tz" (m), "Rx", "Ry" or "Rz" (rad) and an amount; () is the identity.
    """

    steps: tuple[tuple[str, Quantity], ...] = ()

    def transform(self, graph: Graph) -> Transform:
        """Return it as a transform."""
        result = Transform.unit(graph)
        for kind, amount in self.steps:
            result = result @ Transform.elementary(kind, amount.express(graph))
        return result


UNMOVED = Pose()
"""Where a frame itself is."""

ELEMENTARY = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


@dataclass(frozen=True)
class Particle:
    """A point mass fixed to a body: mass in kg, place in body coordinates, m."""

    mass: Quantity
    at: Vector


@dataclass(frozen=True)
class Outline:
    """What a body looks like, a word of the scene: for pictures, no part of the equations.

    Attributes:
        type: a key of `OUTLINES`.
        sizes: its lengths by name, m; those that are left out follow from the inertia.
        axis: that it is round about, or lies along (a rod) or across (a plate), in body coordinates; None: the inertia
            tells.
    """

    type: str
    sizes: tuple[tuple[str, Quantity], ...] = ()
    axis: Vector | None = None


@dataclass(frozen=True)
class Body:
    """A rigid body: an extended mass, point masses, or both.

    Attributes:
        mass: mass of the extended part, kg; the particles come on top.
        com: its centre of mass in body coordinates, m; None when `first_moment` is declared.
        first_moment: mass times centre of mass, kg m; None when `com` is declared.
        inertia: matrix entries (xx, yy, zz, xy, xz, yz) along the body axes, kg m^2; products enter as matrix
            entries, the negative of the textbook's D.
        about: "com" or "frame" (the origin of the body frame): the point that `inertia` refers to.
        particles: point masses fixed to the body.
        allow_invalid_inertia: the user knows that no real body has this inertia and wants it all the same.
        shape: what it looks like; None: as its inertia tells.
    """

    name: str
    mass: Quantity = Quantity.ZERO
    com: Vector | None = NULL
    first_moment: Vector | None = None
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity] = (Quantity.ZERO,) * 6
    about: str = "com"
    particles: tuple[Particle, ...] = ()
    allow_invalid_inertia: bool = False
    shape: Outline | None = None

    def mass_moment(self, graph: Graph) -> Vec:
        """Return m r of the extended mass, kg m, body frame."""
        if self.first_moment is not None:
            x, y, z = self.first_moment
            return (x.express(graph), y.express(graph), z.express(graph))
        assert self.com is not None
        m, (x, y, z) = self.mass.express(graph), self.com
        return (m * x.express(graph), m * y.express(graph), m * z.express(graph))
