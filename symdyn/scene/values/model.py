"""The scene: what the user declared, and nothing derived from it. Frozen, exact, comparable.

Body 0 is the ground. Each moving body hangs on one joint, whose placement reads

    pose of child in parent = origin · motion(q) · tip

with `origin` from the parent's body frame to the joint frame and `tip` from the moved joint frame to the child's body
frame (the identity unless a standard Denavit-Hartenberg table or the user says otherwise).
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from typing import Any

from symdyn.scene.values.element import Contact, Element, Load, Row, Strut
from symdyn.scene.values.names import listed
from symdyn.scene.values.quantity import NULL, ONE, ZERO, Quantity, Vector, number
from symdyn.scene.values.tolerance import Tolerance
from symdyn.shown import Shown
from symdyn.unlocked import cached_property

GROUND = "ground"

STANDARD_GRAVITY: Vector = (ZERO, ZERO, number(Fraction("-9.81")))


@dataclass(frozen=True)
class Parameter:
    """A named constant of the scene.

    Attributes:
        name: as formulas write it.
        value: its value, free of symbols; None leaves it an argument of every generated function.
        positive: an assumption that printing and certificates may use.
        unit: for tables, e.g. "kg".
        latex: how to print it; None derives it from the name.
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
        tolerance: how far the value may be off, for sweeps; no part of the equations.
    """

    name: str
    value: Quantity | None = None
    positive: bool = False
    unit: str = ""
    latex: str | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()
    tolerance: Tolerance | None = None


@dataclass(frozen=True)
class Pose:
    """A placement as a product of elementary motions, read from left to right.

    Attributes:
        steps: pairs of "Tx", "Ty", "Tz" (m), "Rx", "Ry" or "Rz" (rad) and an amount; () is the identity.
    """

    steps: tuple[tuple[str, Quantity], ...] = ()


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
    mass: Quantity = ZERO
    com: Vector | None = NULL
    first_moment: Vector | None = None
    inertia: tuple[Quantity, Quantity, Quantity, Quantity, Quantity, Quantity] = (ZERO,) * 6
    about: str = "com"
    particles: tuple[Particle, ...] = ()
    allow_invalid_inertia: bool = False
    shape: Outline | None = None


@dataclass(frozen=True)
class Coupling:
    """A joint that follows another one's coordinate: its position is ratio · coordinate + offset.

    Attributes:
        coordinate: the coordinate that it follows.
        ratio: position of this joint per unit of that coordinate, free of coordinates.
        offset: position of this joint at coordinate zero; rad or m.
    """

    coordinate: str
    ratio: Quantity = ONE
    offset: Quantity = ZERO


@dataclass(frozen=True)
class Limits:
    """What a joint may do; data for controllers, no part of the equations. None: unlimited.

    Attributes:
        lower, upper: position, rad or m.
        velocity: largest speed, rad/s or m/s.
        effort: largest driving force, N m or N.
    """

    lower: Quantity | None = None
    upper: Quantity | None = None
    velocity: Quantity | None = None
    effort: Quantity | None = None


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
        coupling: the coordinate that the joint follows, in place of one of its own.
        armature: inertia of a rotor, seen at the joint: adds ½ armature (rate of the joint)² to K, at a ball ½
            armature ω² of its angular velocity relative to the parent; kg m^2 or kg.
        damping: viscous damping, adds -damping · rate to Q^A; N m s/rad or N s/m.
        friction: dry friction as robot files give it, N m or N; data, no part of the equations.
        dry: dry friction that enters the equations: what stands under `friction`, a row of `FORCES`.
        limits: data, no part of the equations.
        start: position at the start, or a guess of it where loops close; one a coordinate, () for zeros.
        start_rates: velocities at the start; one a velocity, () for zeros.
        motion: prescribed motion of a driven joint, a formula in t; None where a force drives it.
        locked: that it was declared to move and then locked: now a fixed joint; for reports, not compared.
    """

    name: str
    type: str
    parent: str
    child: str
    shape: tuple[tuple[str, Any], ...] = ()
    origin: Pose = Pose()
    tip: Pose = Pose()
    coordinates: tuple[str, ...] = ()
    velocities: tuple[str, ...] = ()
    drives: tuple[str | None, ...] = ()
    forces: tuple[Quantity, ...] = ()
    coupling: Coupling | None = None
    armature: Quantity = ZERO
    damping: Quantity = ZERO
    friction: Quantity = ZERO
    dry: Element | None = None
    limits: Limits = Limits()
    start: tuple[Quantity, ...] = ()
    start_rates: tuple[Quantity, ...] = ()
    motion: Quantity | None = None
    locked: bool = field(default=False, compare=False)

    def shaped(self, **values: Any) -> Joint:
        """Return the joint with other values of keys of its type."""
        return replace(self, shape=tuple((dict(self.shape) | values).items()))

    @property
    def axis(self) -> Vector:
        """Direction in the joint frame, any length but zero, free of symbols; z where its type takes none."""
        found: Vector = dict(self.shape).get("axis", (ZERO, ZERO, ONE))
        return found

    @property
    def moves(self) -> bool:
        """Whether the joint moves, by coordinates of its own or by one that it follows."""
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
        return self.forces[0] if len(self.forces) == 1 else ZERO

    @property
    def rates(self) -> tuple[str, ...]:
        """Names of its velocities, shape (nv,)."""
        return self.velocities or tuple(velocity_name(q) for q in self.coordinates)


@dataclass(frozen=True)
class Point:
    """A named frame fixed to a body, for kinematic outputs."""

    name: str
    body: str
    at: Pose = Pose()


@dataclass(frozen=True)
class Input:
    """A letter that somebody outside gives over time, such as a motor's voltage; forces and loads may use it.

    Attributes:
        name: as formulas write it.
        value: what it is where nobody gives it, free of symbols.
        unit: for tables, e.g. "V".
        latex: how to print it; None derives it from the name.
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
    """

    name: str
    value: Quantity = ZERO
    unit: str = ""
    latex: str | None = None
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Signal:
    """What is looked at: a formula with a name, a letter of which may be a place or a reaction; see `signals`.

    Attributes:
        name: of its column, and behind "output:".
        formula: in coordinates, velocities, accelerations, drives, inputs, parameters, t, points and reactions.
        unit: for tables, e.g. "m".
        text: a description for tables.
        texts: the same in other languages: ("sk", description).
    """

    name: str
    formula: Quantity
    unit: str = ""
    text: str = ""
    texts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Scene(Shown):
    """A mechanism, checked and in order: every joint comes after the joint of its parent.

    >>> import symdyn
    >>> arm = symdyn.example("two_link")
    >>> arm.coordinates, arm.velocities, [body.name for body in arm.bodies]
    (('q1', 'q2'), ('q1_dot', 'q2_dot'), ['link1', 'link2'])

    Attributes:
        name: used for file and function names.
        parameters: in declared order; those without a value become the argument `params`, in this order.
        gravity: acceleration of free fall in the ground frame, m/s^2.
        bodies: bodies[i] is the child of joints[i].
        joints: parents first; the coordinates q follow this order.
        points: named frames.
        loops: joints that close loops: they carry nothing and have no coordinates.
        elements: what acts beside gravity and drives, in the order of `FORCES`.
        inputs: what somebody gives over time: the argument `inputs` of generated functions, in this order.
        outputs: what is looked at.
        source: where it was read from, for messages; not compared.
    """

    name: str
    parameters: tuple[Parameter, ...] = ()
    gravity: Vector = STANDARD_GRAVITY
    bodies: tuple[Body, ...] = ()
    joints: tuple[Joint, ...] = ()
    points: tuple[Point, ...] = ()
    loops: tuple[Joint, ...] = ()
    elements: tuple[Element, ...] = ()
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Signal, ...] = ()
    source: str = field(default="", compare=False)

    def __repr__(self) -> str:
        free = [one.name for one in self.parameters if one.value is None]
        told = [f"coordinates {listed(self.coordinates)}", f"drives {listed(filter(None, self.drives))}"]
        told += [f"inputs {listed(one.name for one in self.inputs)}"] if self.inputs else []
        told += [f"parameters without a value {listed(free)}"] if free else []
        bodies = f"{len(self.bodies)} {'body' if len(self.bodies) == 1 else 'bodies'}"
        loops = f", {len(self.loops)} {'loop' if len(self.loops) == 1 else 'loops'}" if self.loops else ""
        return f"<Scene {self.name}: {bodies}{loops}; {'; '.join(told)}>"

    def __hash__(self) -> int:
        return self._hash

    @cached_property  # what is kept by scenes asks for it many times
    def _hash(self) -> int:
        return hash(tuple(getattr(self, one.name) for one in fields(self) if one.compare))

    def __getstate__(self) -> dict[str, object]:
        return {one.name: getattr(self, one.name) for one in fields(self)}  # a hash of text is that of one process

    @cached_property  # these are asked for joint by joint
    def moving(self) -> tuple[Joint, ...]:
        """The joints that have coordinates, in order of q."""
        return tuple(joint for joint in self.joints if joint.coordinates)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of q, shape (nq,)."""
        return tuple(name for joint in self.joints for name in joint.coordinates)

    @cached_property
    def velocities(self) -> tuple[str, ...]:
        """Names of the velocities, shape (nv,)."""
        return tuple(name for joint in self.joints for name in joint.rates)

    @cached_property
    def drives(self) -> tuple[str | None, ...]:
        """Names of the driving forces, shape (nv,); None where a velocity is passive."""
        return tuple(drive for joint in self.joints for drive in joint.drives or (None,) * len(joint.rates))

    @cached_property
    def struts(self) -> tuple[Strut, ...]:
        """What pulls along one way."""
        return tuple(one for one in self.elements if isinstance(one, Strut))

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """The wrenches on bodies."""
        return tuple(one for one in self.elements if isinstance(one, Load))

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """The constraints on velocities."""
        return tuple(one for one in self.elements if isinstance(one, Row))

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """The rows that are contacts with planes."""
        return tuple(one for one in self.rows if isinstance(one, Contact))

    @property
    def is_closed(self) -> bool:
        """Whether it has loops or rows."""
        return bool(self.loops or self.rows)

    @cached_property
    def free_parameters(self) -> tuple[Parameter, ...]:
        """Parameters without a value: the argument `params` of generated functions, in this order."""
        return tuple(parameter for parameter in self.parameters if parameter.value is None)

    def with_gravity(self, gravity: Vector) -> Scene:
        """Return the scene with another acceleration of free fall, m/s^2."""
        return replace(self, gravity=gravity)


def velocity_name(coordinate: str) -> str:
    """Return the name of q̇ in formulas."""
    return f"{coordinate}_dot"


def acceleration_name(velocity: str) -> str:
    """Return the name of the rate of a velocity on the graph: x_ddot for x_dot."""
    return f"{velocity[:-4]}_ddot" if velocity.endswith("_dot") else f"{velocity}_dot"
