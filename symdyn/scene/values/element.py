"""Elements: what acts in a scene beside gravity and drives, by the way in which it does.

    strut   pulls along one way: the position of a joint, or the distance of two points
    load    is a wrench on a body
    row     forbids velocities, and exerts whatever that takes

What an element is beyond that, its kind tells: a row of `FORCES`.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.scene.values.quantity import NULL, Quantity, Vector


@dataclass(frozen=True)
class Place:
    """A point of a body (or of the ground): body name and place in body coordinates, m."""

    body: str
    at: Vector = NULL


@dataclass(frozen=True)
class Element:
    """What acts, by name; names of one section of a file differ."""

    name: str

    @property
    def kind(self) -> str:
        """The row of `FORCES` that tells about it."""
        raise NotImplementedError

    @property
    def ends(self) -> tuple[Place, ...]:
        """The points of bodies that it acts at."""
        return ()


@dataclass(frozen=True)
class Strut(Element):
    """What pulls along one way.

    Attributes:
        joint: name of the joint, with one coordinate, whose position is the way; "" between points.
        ends: the two points whose distance is the way; () at a joint.
    """

    joint: str = ""
    ends: tuple[Place, ...] = ()


@dataclass(frozen=True)
class Load(Element):
    """A wrench on a body: "technological" forces and couples, formulas in t, parameters, coordinates, velocities.

    Attributes:
        place: body and point that the force acts at.
        force: N. couple: N m. Components along the axes of `frame`.
        frame: "body" (the body's own axes) or "ground".
    """

    place: Place
    force: Vector = NULL
    couple: Vector = NULL
    frame: str = "ground"

    kind = "load"

    @property
    def ends(self) -> tuple[Place, ...]:
        """The point that the force acts at."""
        return (self.place,)


@dataclass(frozen=True)
class Plane:
    """The plane that a wheel, a ball or a blade touches.

    Attributes:
        body: that carries it, the ground as a rule.
        at: a point of it, axes of that body, m.
        normal: towards what touches it, axes of that body; any length but zero, free of symbols.
        declared: whether the scene says where it lies; else it passes through the origin of the ground.
    """

    body: str = "ground"
    at: Vector = NULL
    normal: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.ONE)
    declared: bool = False


@dataclass(frozen=True)
class Row(Element):
    """A constraint on velocities, which may hold a position too."""


@dataclass(frozen=True)
class Contact(Row):
    """A place of a body that touches a plane: the point of a blade, or the centre of a wheel or a ball.

        knife_edge  a point of a body has no velocity along an axis of the body, the one across the blade: one row
        rolling     the point C of a wheel or a ball that is lowest has no velocity: one row a component

    Velocities are relative to the body that carries the plane. With the wheel's axis a, its centre O, a point p of the
    plane and its normal n, a and n unit vectors, and w = |a × n|,

        C = O - r (n - (n·a) a) / w        along  v_C·(a × n) / w = (v_O·(a × n)) / w - r ω·a
                                           across v_C·(n × (a × n)) / w        normal v_C·n

    The last is the rate of n·(O - p) - r w, how high C is, which vanishes where the row is kept. Without an axis the
    body is a ball, C = O - r n, and "along" and "across" are two directions of the plane.

    Attributes:
        type: "knife_edge" or "rolling".
        place: the point of the blade, or the centre of the wheel.
        axis: the direction across the blade, or the wheel's axis; body axes, any length but zero, free of symbols.
            None for a ball.
        radius: of the wheel, m.
        plane: what the wheel rolls on, or the blade cuts.
        components: of the velocity of C, those that vanish: of "along", "across", "normal".
    """

    type: str
    place: Place
    axis: Vector | None = (Quantity.ZERO, Quantity.ONE, Quantity.ZERO)
    radius: Quantity = Quantity.ZERO
    plane: Plane = Plane()
    components: tuple[str, ...] = ("along", "across")

    @property
    def kind(self) -> str:
        """The row of `FORCES` that tells about it."""
        return self.type

    @property
    def ends(self) -> tuple[Place, ...]:
        """The point of the blade, or the centre of the wheel."""
        return (self.place,)
