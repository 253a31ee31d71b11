"""What opens, closes, sticks and slips: contacts, stops of joints, dry friction of joints."""

from __future__ import annotations

from symdyn.frozen import dataclass
from symdyn.scene.values.joint import Contact, Element, Place, Plane, Row
from symdyn.scene.values.quantity import Quantity, Vector

_NOWHERE, _LEVEL = Place(""), Plane()


@dataclass(frozen=True)
class Unilateral(Element):
    """What opens and closes, 0 ≤ g ⊥ λ ≥ 0, or sticks and slips: a contact, the stop of a joint, its dry friction.

    Attributes:
        restitution: e, 0 to 1.
        friction: Coulomb's coefficient while it slips.
        static: while it sticks; None for the same.
        law: of impacts, "poisson" or "newton".
        active: where it is above zero what is open may strike; None for everywhere.
    """

    restitution: Quantity = Quantity.ZERO
    friction: Quantity = Quantity.ZERO
    static: Quantity | None = None
    law: str = "poisson"
    active: Quantity | None = None

    at_rates = False
    """Whether its law is one of rates, 0 ≤ n u ⊥ λ ≥ 0, and there is no gap."""

    @property
    def closed(self) -> Row | None:
        """The rows that hold it closed and sticking; None where a formula or a joint tells its gap."""
        return None


@dataclass(frozen=True)
class PlaneContact(Unilateral):
    """A place of a body over a plane; g is the height of what is lowest over the plane, m.

    Attributes:
        type: "point", "ball" or "wheel".
        place, axis, radius, plane: as of a `Contact`.
    """

    type: str = "point"
    place: Place = _NOWHERE
    axis: Vector | None = None
    radius: Quantity = Quantity.ZERO
    plane: Plane = _LEVEL

    @property
    def kind(self) -> str:
        return self.type

    @property
    def ends(self) -> tuple[Place, ...]:
        """The point, or the centre of the ball or the wheel."""
        return (self.place,)

    @property
    def closed(self) -> Contact:
        """The rows that hold it closed and sticking."""
        every = ("normal", "along", "across")
        return Contact(self.name, "rolling", self.place, self.axis, self.radius, self.plane, every)


@dataclass(frozen=True)
class GapContact(Unilateral):
    """A contact by formulas.

    Attributes:
        gap: in coordinates and parameters, m.
        tangent: the velocity with which it slips, linear in velocities; None without friction.
    """

    gap: Quantity = Quantity.ZERO
    tangent: Quantity | None = None

    kind = "gap"


@dataclass(frozen=True)
class Stop(Unilateral):
    """A limit of a joint that it strikes: g is how far the joint is from it, rad or m.

    Attributes:
        joint: whose it is, of one coordinate.
        upper: whether it is the upper one.
        at: the limit, rad or m.
    """

    joint: str = ""
    upper: bool = True
    at: Quantity = Quantity.ZERO

    kind = "joint_stop"


@dataclass(frozen=True)
class DryJoint(Unilateral):
    """Dry friction of a joint of one coordinate, whose sign is not smoothed."""

    joint: str = ""
    dry: Element | None = None

    kind = "joint_friction"


@dataclass(frozen=True)
class OneWay(Unilateral):
    """A joint of one coordinate whose rate is never below zero, a freewheel or a ratchet: 0 ≤ q̇ ⊥ λ ≥ 0."""

    joint: str = ""

    kind, at_rates = "one_way", True
