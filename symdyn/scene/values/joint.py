"""Joints and elements of a scene: what connects its bodies, and what acts on them beside gravity and drives.

An element is one of three by the way in which it acts; what it is beyond that, its kind tells, a row of `FORCES`:

    strut   pulls along one way: the position of a joint, or the distance of two points
    load    is a wrench on a body
    row     forbids velocities, and exerts whatever that takes
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf
from typing import Any

from symdyn.arguments import walked
from symdyn.errors import SceneError, listed, quoted, suggestion
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene.values.body import UNMOVED, Pose
from symdyn.scene.values.quantity import NULL, Quantity, Vector


@dataclass(frozen=True)
class Place:
    """A point of a body (or of the ground), or the centre of a wheel that a rope runs around, slipping freely.

    Attributes:
        body: its name.
        at: in body coordinates, m.
        radius: of the wheel, m.
        axis: of the wheel, body axes, any length but zero, free of symbols.
        turn: 1 where the rope turns left around it, seen with the axis towards the eye, -1 right; 0 at a point.
        ordered: of both ends of a spring or damper that lessons take not to pass each other; see `in_order`.
    """

    body: str
    at: Vector = NULL
    radius: Quantity = Quantity.ZERO
    axis: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.ONE)
    turn: int = 0
    ordered: bool = False


@dataclass(frozen=True)
class Element:
    """What acts, by name, with a description as of a joint; names of one section of a file differ."""

    name: str
    text: str = field(default="", kw_only=True)
    texts: tuple[tuple[str, str], ...] = field(default=(), kw_only=True)

    @property
    def kind(self) -> str:
        """The row of `FORCES` that tells about it."""
        raise NotImplementedError

    @property
    def ends(self) -> tuple[Place, ...]:
        return ()

    @property
    def is_taut(self) -> bool:
        """Whether it never pushes."""
        return False


@dataclass(frozen=True)
class Strut(Element):
    """What pulls along one way.

    Attributes:
        joint: name of the joint, with one coordinate, whose position is the way; "" between points.
        ends: the two points whose distance is the way, or the places of a rope whose length is; () at a joint.
        free: of a spring, the way at which it counts from zero, rad or m.
    """

    joint: str = ""
    ends: tuple[Place, ...] = ()
    free: Quantity = field(default=Quantity.ZERO, kw_only=True)

    @property
    def is_rope(self) -> bool:
        """Whether it runs through more than two points, around a wheel, or between ends that keep their order."""
        return len(self.ends) > 2 or self.is_ordered or any(end.turn for end in self.ends)

    @property
    def is_ordered(self) -> bool:
        return any(end.ordered for end in self.ends)


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

    kind, spread = "load", False

    @property
    def ends(self) -> tuple[Place, ...]:
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
        return self.type

    @property
    def ends(self) -> tuple[Place, ...]:
        return (self.place,)


@dataclass(frozen=True)
class Coupling:
    """A joint that follows coordinates of others: its position is Σ ratio · coordinate + offset.

    Attributes:
        ratios, offset: coordinates, each once, and its position per unit of each and at zero, free of coordinates.
        wheels: that of what it follows and its own, in a belt or a ring gear; for pictures.
    """

    ratios: tuple[tuple[str, Quantity], ...]
    offset: Quantity = Quantity.ZERO
    wheels: tuple[Place, ...] = field(default=(), compare=False)

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.ratios)


@dataclass(frozen=True)
class Limits:
    """What a joint may do; data for controllers, no part of the equations. None: unlimited.

    Attributes:
        lower, upper, velocity, effort: positions, rad or m, largest speed, rad/s or m/s, and driving force, N m or N.
        restitution, one_way: of both positions, which it strikes in runs; whether its rate is never below zero.
    """

    lower: Quantity | None = None
    upper: Quantity | None = None
    velocity: Quantity | None = None
    effort: Quantity | None = None
    restitution: Quantity | None = None
    one_way: bool = False


@dataclass(frozen=True)
class Joint:
    """A joint between two bodies: in the tree it carries its child, in a loop it closes it.

    Attributes:
        type: a key of `JOINTS`.
        parent, child: body names; `GROUND` is the ground.
        shape: what the keys of its type say, in their order; one that is left out says its default.
        origin: from the parent's body frame to the joint frame.
        tip: from the moved joint frame to the child's body frame.
        coordinates: names of its q; () for a joint that is fixed, follows another one, or closes a loop.
        velocities: names of its velocities where they are no rates of coordinates (a quaternion's); else ().
        drives: name of the driving force or torque of each velocity, None where it is passive; () for none at all.
        forces: generalized force Q^A of each velocity beside the drive (5.22), a formula; N m or N; () for none.
        coupling: the coordinates that the joint follows, in place of one of its own.
        armature: rotor inertia seen at the joint, in K ½ armature ω², ω relative to the parent; kg m^2 or kg.
        damping: viscous damping, adds -damping · rate to Q^A; N m s/rad or N s/m.
        friction: dry friction as robot files give it, N m or N; data, no part of the equations.
        dry: dry friction that enters the equations: what stands under `friction`, a row of `FORCES`.
        limits: data, no part of the equations.
        start: position at the start, or a guess of it where loops close; () for zeros.
        start_rates: velocities at the start; one a velocity, () for zeros.
        motion: prescribed motion of a driven joint, a formula in t; None where a force drives it.
        locked: that it was declared to move and then locked: now a fixed joint; not compared.
        text: a description, which lessons and pictures call it by.
        texts: the same in other languages: ("sk", description).
        latex: how coordinates are printed where that is said: (name, LaTeX).
    """

    name: str
    type: str
    parent: str
    child: str
    shape: tuple[tuple[str, Any], ...] = ()
    origin: Pose = UNMOVED
    tip: Pose = UNMOVED
    coordinates: tuple[str, ...] = ()
    velocities: tuple[str, ...] = ()
    drives: tuple[str | None, ...] = ()
    forces: tuple[Quantity, ...] = ()
    coupling: Coupling | None = None
    armature: Quantity = Quantity.ZERO
    damping: Quantity = Quantity.ZERO
    friction: Quantity = Quantity.ZERO
    dry: Element | None = None
    limits: Limits = Limits()
    start: tuple[Quantity, ...] = ()
    start_rates: tuple[Quantity, ...] = ()
    motion: Quantity | None = None
    locked: bool = field(default=False, compare=False)
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()
    latex: tuple[tuple[str, str], ...] = ()

    def shaped(self, **values: Any) -> Joint:
        return replace(self, shape=tuple((dict(self.shape) | values).items()))

    def range(self, values: Mapping[str, Fraction | float]) -> tuple[float, float]:
        """Return the limits of its coordinate at values of parameters, infinite without; of several it has none."""
        given = (self.limits.lower, self.limits.upper) if len(self.coordinates) == 1 else (None, None)
        low, high = (None if x is None else x.at(values) for x in given)
        return -inf if low is None else float(low), inf if high is None else float(high)

    @property
    def axis(self) -> Vector:
        """Direction in the joint frame, any length but zero, free of symbols; z where its type takes none."""
        found: Vector = dict(self.shape).get("axis", (Quantity.ZERO, Quantity.ZERO, Quantity.ONE))
        return found

    @property
    def moves(self) -> bool:
        """Whether the joint moves, by coordinates of its own or by those that it follows."""
        return bool(self.coordinates) or self.coupling is not None

    @property
    def coordinate(self) -> str:
        """Name of q of a joint that has exactly one; else ""."""
        return self.coordinates[0] if len(self.coordinates) == 1 else ""

    @property
    def drive(self) -> str | None:
        """Name of the driving force of a joint that has exactly one velocity; else None."""
        return self.drives[0] if len(self.drives) == 1 else None

    @property
    def force(self) -> Quantity:
        """Generalized force beside the drive of a joint that has exactly one velocity; else zero."""
        return self.forces[0] if len(self.forces) == 1 else Quantity.ZERO

    @property
    def rates(self) -> tuple[str, ...]:
        """Names of its velocities, shape (nv,)."""
        return self.velocities or tuple(velocity_name(q) for q in self.coordinates)

    def position(self, graph: Graph) -> Expr:
        """Return its position, if it has one freedom, in terms of the coordinates; rad or m."""
        if self.coupling is None:
            return graph.symbol(self.coordinates[0])
        led = graph.total(ratio.express(graph) * graph.symbol(name) for name, ratio in self.coupling.ratios)
        return led + self.coupling.offset.express(graph)

    def speeds(self, graph: Graph) -> list[Expr]:
        """Return its rates, by differentiating its position where it follows another joint."""
        if self.coupling is None:
            return [graph.symbol(name) for name in self.rates]
        leaders = self.coupling.coordinates
        return tangents([self.position(graph)], {graph.symbol(q): graph.symbol(velocity_name(q)) for q in leaders})

    def moved_by(self, graph: Graph) -> list[tuple[str, int, Expr]]:
        """Return the velocities that move it: name, which of its own rates, and that rate per unit."""
        if self.coupling is None:
            return [(name, k, graph.one) for k, name in enumerate(self.rates)]
        return [(velocity_name(name), 0, ratio.express(graph)) for name, ratio in self.coupling.ratios]


def velocity_name(coordinate: str) -> str:
    """Return the name of q̇ in formulas."""
    return f"{coordinate}_dot"


def acceleration_name(velocity: str) -> str:
    """Return the name of the rate of a velocity on the graph: x_ddot for x_dot."""
    return f"{velocity[:-4]}_ddot" if velocity.endswith("_dot") else f"{velocity}_dot"


QUATERNIONS = {"wxyz": (0, 1, 2, 3), "xyzw": (1, 2, 3, 0)}
"""Orders of the four coordinates of a quaternion by name, as places in ours."""


@dataclass(frozen=True)
class JointOrder:
    """Joints in the order of another tool; each attribute is in that order.

    `theirs = ours[..., order.q]` reads positions, and `ours[..., order.q] = theirs` writes them; velocities,
    accelerations and forces (one for each velocity) go by `order.v`, and a matrix by
    `M[numpy.ix_(order.v, order.v)]`.

    Attributes:
        joints: names of the joints that have coordinates.
        coordinates: names of their coordinates.
        velocities: names of their velocities.
        drives: names of their driving forces, one a velocity; None where it is passive.
        places: of the coordinates in q, and of the velocities in q̇, q̈ and tau; those of `q` and `v` as tuples.
    """

    joints: tuple[str, ...]
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    drives: tuple[str | None, ...]
    places: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def q(self) -> Any:
        """Places of the other's positions in ours, an array of whole numbers, shape (nq,)."""
        return _array(self.places[0])

    @property
    def v(self) -> Any:
        """Places of the other's velocities, accelerations and forces in ours, shape (nv,)."""
        return _array(self.places[1])


def _array(places: Sequence[int]) -> Any:
    import numpy as np

    return np.array(places, dtype=np.intp)


def order_of(joints: Sequence[Joint], names: Sequence[str], quaternion: str = "wxyz") -> JointOrder:
    """Return joints in another order.

    Args:
        joints: all of a scene, in its order.
        names: the joints as the other lists them, every one that has coordinates; fixed ones may be among them. A name
            that a robot file has and that was made printable here is known too, as "left-hip" for left_hip.
        quaternion: the order of the other's quaternions, a key of `QUATERNIONS`.

    Raises:
        SceneError: a name that no joint has or that stands twice, a joint that is missing, no such order.
    """
    if isinstance(names, str):
        raise SceneError(f"names = {quoted(names)}: give a list of names, such as [{quoted(names)}]")
    (names,) = walked(order_of, locals(), "names", error=SceneError)
    if quaternion not in QUATERNIONS:
        raise SceneError(f"quaternion = {quaternion!r} is not known; give {' or '.join(map(repr, QUATERNIONS))}")
    known = {joint.name: joint for joint in joints}
    spelled: dict[str, list[str]] = {}
    for name in known:
        spelled.setdefault(_plain(name), []).append(name)
    found: dict[str, Joint] = {}
    faults = []
    for given in names:
        near = spelled.get(_plain(given), ())
        name = given if given in known else near[0] if len(near) == 1 else ""
        if not name:
            faults.append(f"names: there is no joint {quoted(given)}; {suggestion(given, known)}")
        elif name in found:
            faults.append(f"names: {given!r} stands there twice; give every joint once")
        else:
            found[name] = known[name]
    moving = {joint.name for joint in joints if joint.coordinates}
    missing = [joint.name for joint in joints if joint.name in moving and joint.name not in found]
    if missing and not faults:
        faults.append(f"names: {listed(missing)} missing; give every joint that moves")
    if faults:
        raise SceneError(faults)
    first: dict[str, tuple[int, int]] = {}
    nq = nv = 0
    for joint in joints:
        first[joint.name] = nq, nv
        nq, nv = nq + len(joint.coordinates), nv + len(joint.rates)
    wanted = [joint for joint in found.values() if joint.coordinates]
    q = [(joint, k) for joint in wanted for k in _inside(joint, quaternion)]
    v = [(joint, k) for joint in wanted for k in range(len(joint.rates))]
    return JointOrder(
        joints=tuple(joint.name for joint in wanted),
        coordinates=tuple(joint.coordinates[k] for joint, k in q),
        velocities=tuple(joint.rates[k] for joint, k in v),
        drives=tuple(joint.drives[k] if joint.drives else None for joint, k in v),
        places=(
            tuple(first[joint.name][0] + k for joint, k in q),
            tuple(first[joint.name][1] + k for joint, k in v),
        ),
    )


def _plain(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()


def _inside(joint: Joint, quaternion: str) -> list[int]:
    """Return the places of a joint's coordinates in the other order; its quaternion, if it has one, stands last."""
    places = list(range(len(joint.coordinates)))
    if len(places) == len(joint.rates):
        return places
    return [*places[:-4], *(len(places) - 4 + k for k in QUATERNIONS[quaternion])]
