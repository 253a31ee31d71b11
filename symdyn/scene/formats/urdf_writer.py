"""Scenes as URDF text.

Bodies are links and joints are joints; the ground is the root link. A tip becomes a fixed joint, a named point a
massless link on a fixed joint, point masses are part of their body's inertia. What is left is `lost`: the format has
no gravity, no rotor inertia, no forces in formulas, no passive joints, and no names of coordinates and parameters.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from fractions import Fraction
from xml.sax.saxutils import quoteattr

from symdyn.arguments import argument
from symdyn.errors import SceneError, listed
from symdyn.scene.declaration.reading import Written, lost_words
from symdyn.scene.formats.inertias import possible
from symdyn.scene.formats.placing import angle_text, decimal_text, known, known_angle, printable_names, xyz_rpy
from symdyn.scene.formats.robot_file import INERTIA, UNLIMITED
from symdyn.scene.formats.urdf import TYPES
from symdyn.scene.joints.blocks import AXIS, ORIENTATION
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.body import Body, Pose, central_inertia
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.model import STANDARD_GRAVITY, Scene
from symdyn.scene.values.quantity import Quantity, Value, Vector, spell

KINDS = {ours: next(word for word in TYPES if TYPES[word] == ours) for ours in dict.fromkeys(TYPES.values())}

NEARLY_ONE = 1e-5
"""Lengths this close to 1 are those of unit vectors that were rounded; every reader makes them exact."""

INDENT = "  "


def write_text(scene: Scene) -> Written:
    """Return the scene as URDF text, and what the format cannot hold.

    Raises:
        SceneError: a parameter has no value, or a body has a first moment without a mass.
    """
    check_writable(scene, "URDF", KINDS, scene.joints)
    return Written(UrdfWriter(scene).text(), tuple(_lost(scene)))


def check_writable(scene: Scene, format: str, kinds: Collection[str], joints: Iterable[Joint]) -> None:
    """Raise what a format of numbers cannot hold even in part: letters without a value, joints of other kinds."""
    free = [*(parameter.name for parameter in scene.free_parameters), *scene.changing]
    if free:
        advice = "give each a value, or write TOML"
        have = "has" if len(free) == 1 else "have"
        raise SceneError(f"{scene.name}: {format} holds numbers only, and {listed(free)} {have} no value; {advice}")
    if strange := [joint for joint in joints if joint.type not in kinds]:
        where, known = f"{scene.source or scene.name}: joints.", ", ".join(kinds)
        raise SceneError([f"{where}{one.name}: {format} has no {one.type} joints; it has {known}" for one in strange])


def _lost(scene: Scene) -> list[str]:
    """Return what the format cannot hold, one line each."""
    lost = lost_names(scene)
    if [x.at(values_of(scene)) for x in scene.gravity] != [x.at({}) for x in STANDARD_GRAVITY]:
        shown = ", ".join(spell(x) for x in scene.gravity)
        lost.append(f"gravity = [{shown}]: readers of URDF take [0, 0, -9.81]")
    for joint in scene.joints:
        where = f"joints.{joint.name}"
        if joint.coordinate and joint.drive is None:
            lost.append(f"{where}: drive = false: every joint of a URDF that moves is driven")
        if len(joint.coordinates) > 1 and any(joint.drives):
            lost.append(f"{where}: drives: no floating or planar joint of a URDF is driven")
    return [*lost, *lost_words(scene)]


def lost_names(scene: Scene) -> list[str]:
    """Return what a format of bodies and joints in numbers cannot hold, names first, one line each."""
    lost = []
    if scene.parameters:
        names = listed(parameter.name for parameter in scene.parameters)
        lost.append(f"the names of parameters: {names} are written as their values")
    if known := [parameter.name for parameter in scene.parameters if parameter.tolerance]:
        lost.append(f"tolerances: {listed(known)}")
    renamed = [q for k, q in enumerate(scene.coordinates, start=1) if q != f"q{k}"]
    if renamed:
        lost.append(f"the names of coordinates: {listed(renamed)} are called q1, q2, ... when the file is read again")
    renamed = [drive for k, drive in enumerate(scene.drives, start=1) if drive and drive != f"tau{k}"]
    if renamed:
        lost.append(f"the names of drives: {listed(renamed)} are called tau1, tau2, ... when the file is read again")
    for joint in scene.joints:
        where = f"joints.{joint.name}"
        if ORIENTATION.of(joint) != ORIENTATION.default:
            lost.append(f'{where}: orientation = "{ORIENTATION.of(joint)}": it is read as a quaternion')
        if joint.armature != Quantity.ZERO:
            lost.append(f"{where}: armature = {spell(joint.armature)}: there is no rotor inertia")
    for body in scene.bodies:
        if body.allow_invalid_inertia:
            again = argument("allow_invalid_inertia", True)
            lost.append(f"bodies.{body.name}: allow_invalid_inertia; read it back with {again}")
    return lost


def values_of(scene: Scene) -> dict[str, Value]:
    """Return the values of the parameters."""
    found = {p.name: p.value.at({}) for p in scene.parameters if p.value is not None}
    return {name: value for name, value in found.items() if value is not None}


class UrdfWriter:
    """One scene, with the values of its parameters and names for the links and joints that URDF needs on top."""

    FORMAT = "URDF"

    def __init__(self, scene: Scene) -> None:
        """Remember values, and which names are taken."""
        self.scene, self.values = scene, values_of(scene)
        self.frames = [body.name for body in scene.bodies] + [point.name for point in scene.points]
        self.joints = [joint.name for joint in scene.joints]
        self.leaders = {joint.coordinate: joint.name for joint in scene.moving if len(joint.coordinates) == 1}

    def text(self) -> str:
        lines = element("link", Scene.GROUND)
        for joint, body in zip(self.scene.joints, self.scene.bodies, strict=True):
            carried = body.name
            if joint.tip.steps:
                carried = self.new(self.frames, f"{body.name}_base")
                lines += [*element("link", carried), *self.joint(joint, carried)]
                lines += self.fixed(self.new(self.joints, f"{joint.name}_tip"), carried, body.name, joint.tip)
            else:
                lines += self.joint(joint, carried)
            lines += element("link", body.name, self.inertial(body))
        for point in self.scene.points:
            lines += element("link", point.name)
            lines += self.fixed(self.new(self.joints, f"{point.name}_joint"), point.body, point.name, point.at)
        return "\n".join(['<?xml version="1.0"?>', *element("robot", self.scene.name, lines)]) + "\n"

    def new(self, taken: list[str], name: str) -> str:
        """Return a name like `name` that is not taken, and take it."""
        found, k = printable_names([name], "link")[name], 2
        while found in taken:
            found, k = f"{name}_{k}", k + 1
        taken.append(found)
        return found

    def inertial(self, body: Body) -> list[str]:
        """Return the lines of a body's mass and inertia, point masses included; none for a massless body."""
        mass, com, inertia = self.combined(body)
        if not mass and not any(inertia):
            return []
        entries = " ".join(f'{key}="{decimal_text(x)}"' for key, x in zip(INERTIA, possible(inertia), strict=True))
        origin = [f'<origin xyz="{words_of(com)}"/>'] if any(com) else []
        return element("inertial", "", [*origin, f'<mass value="{decimal_text(mass)}"/>', f"<inertia {entries}/>"])

    def combined(self, body: Body) -> tuple[Value, list[Value], list[Value]]:
        """Return mass, centre of mass and inertia about it (xx, yy, zz, xy, xz, yz) of a body with its point masses."""
        parts = [(self.value(body.mass), self.centre(body))]
        parts += [(self.value(p.mass), [self.value(x) for x in p.at]) for p in body.particles]
        matrix = central_inertia(body, self.values)
        assert matrix is not None, "all values are known, and a first moment has a mass"
        total = sum((mass for mass, _ in parts), start=Fraction(0))
        if not body.particles or not total:
            com = parts[0][1]
        else:
            com = [sum((m * r[i] for m, r in parts), start=Fraction(0)) / total for i in range(3)]
        for mass, place in parts:
            arm = [x - y for x, y in zip(place, com, strict=True)]
            square = sum((x * x for x in arm), start=Fraction(0))
            for i in range(3):
                for j in range(3):
                    matrix[i][j] += mass * ((square if i == j else 0) - arm[i] * arm[j])
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
        return total, com, [xx, yy, zz, xy, xz, yz]

    def centre(self, body: Body) -> list[Value]:
        """Return the centre of mass of the extended part, m."""
        if body.first_moment is None:
            assert body.com is not None
            return [self.value(x) for x in body.com]
        mass, moment = self.value(body.mass), [self.value(x) for x in body.first_moment]
        if mass:
            return [x / mass for x in moment]
        if any(moment):
            advice = "give it a mass, or write TOML"
            raise SceneError(f"{self.scene.name}: bodies.{body.name}: has a first moment but no mass; {advice}")
        return [Fraction(0)] * 3

    def joint(self, joint: Joint, child: str) -> list[str]:
        if not joint.moves:
            return self.fixed(joint.name, joint.parent, child, joint.origin)
        if len(joint.coordinates) > 1:
            return self.several(joint, child)
        limits = joint.limits
        bounded = limits.lower is not None or limits.upper is not None
        kind = KINDS[joint.type] if bounded or JOINTS[joint.type].slides(joint) else "continuous"
        inside = [f'<axis xyz="{self.axis(joint)}"/>']
        bounds = {"velocity": limits.velocity, "effort": limits.effort}
        if kind != "continuous":
            bounds = {"lower": limits.lower, "upper": limits.upper, **bounds}
        if kind != "continuous" or limits.velocity or limits.effort:
            shown = " ".join(f'{key}="{self.limit(key, value)}"' for key, value in bounds.items())
            inside.append(f"<limit {shown}/>")
        inside += self.dynamics(joint)
        if joint.coupling is not None:
            leader, ratio, offset = self.follows(joint)
            inside.append(f'<mimic joint="{leader}" multiplier="{ratio}" offset="{offset}"/>')
        return self.ends(joint.name, kind, joint.parent, child, joint.origin, inside)

    def follows(self, joint: Joint) -> tuple[str, str, str]:
        """Return the joint that one with a coupling follows, the ratio and the offset."""
        assert joint.coupling is not None, "the joint follows another one"
        (followed, slope), *more = joint.coupling.ratios
        if more or followed not in self.leaders:
            what = "several" if more else "one coordinate of several"
            advice = "give it a coordinate of its own, or write TOML"
            where = f"{self.scene.name}: joints.{joint.name}"
            raise SceneError(f"{where}: {self.FORMAT} has no joint that follows {what}; {advice}")
        return self.leaders[followed], decimal_text(self.value(slope)), self.offset(joint)

    def several(self, joint: Joint, child: str) -> list[str]:
        """Return the lines of a floating or planar joint."""
        axis = [f'<axis xyz="{self.axis(joint)}"/>'] if AXIS in JOINTS[joint.type].keys else []
        kind = KINDS[joint.type]
        return self.ends(joint.name, kind, joint.parent, child, joint.origin, [*axis, *self.dynamics(joint)])

    def dynamics(self, joint: Joint) -> list[str]:
        if joint.damping == Quantity.ZERO and joint.friction == Quantity.ZERO:
            return []
        damping, friction = (decimal_text(self.value(x)) for x in (joint.damping, joint.friction))
        return [f'<dynamics damping="{damping}" friction="{friction}"/>']

    def fixed(self, name: str, parent: str, child: str, origin: Pose) -> list[str]:
        return self.ends(name, "fixed", parent, child, origin, [])

    def ends(self, name: str, kind: str, parent: str, child: str, origin: Pose, inside: Sequence[str]) -> list[str]:
        """Return the lines of any joint."""
        xyz, rpy = xyz_rpy(origin, self.values)
        shift = f' xyz="{words_of(xyz)}"' if any(xyz) else ""
        turn = f' rpy="{" ".join(angle_text(x) for x in rpy)}"' if any(rpy) else ""
        place = [f"<origin{shift}{turn}/>"] if shift or turn else []
        lines = [*place, f'<parent link="{parent}"/>', f'<child link="{child}"/>', *inside]
        return element("joint", name, lines, f' type="{kind}"')

    def axis(self, joint: Joint, key: Key[Vector] = AXIS) -> str:
        """Return an axis with length one, as the format wants it; rounded unit vectors are left as they are."""
        axis = [self.value(x) for x in key.of(joint)]
        if abs(math.hypot(*map(float, axis)) - 1) < NEARLY_ONE:
            return words_of(axis)
        if sum(map(bool, axis)) == 1:
            return words_of([Fraction((x > 0) - (x < 0)) for x in axis])
        length = math.hypot(*(float(x) for x in axis))
        return words_of([float(x) / length if x else Fraction(0) for x in axis])

    def offset(self, joint: Joint) -> str:
        """Return the offset of a joint that follows another one, an angle if it turns."""
        assert joint.coupling is not None, "the joint follows another one"
        if JOINTS[joint.type].slides(joint):
            return decimal_text(self.value(joint.coupling.offset))
        return angle_text(known_angle(joint.coupling.offset, self.values))

    def limit(self, key: str, quantity: Quantity | None) -> str:
        """Return a limit; the format demands a number where there is none."""
        if quantity is None:
            return str(-UNLIMITED if key == "lower" else UNLIMITED)
        return decimal_text(self.value(quantity))

    def value(self, quantity: Quantity) -> Value:
        return known(quantity, self.values)


def element(tag: str, name: str, inside: Sequence[str] = (), more: str = "") -> list[str]:
    """Return an element, what is inside indented by one step."""
    opening = f"{tag} name={quoteattr(name)}{more}" if name else f"{tag}{more}"
    if not inside:
        return [f"<{opening}/>"]
    return [f"<{opening}>", *(INDENT + line for line in inside), f"</{tag}>"]


def words_of(numbers: Sequence[Value]) -> str:
    """Return numbers with blanks between them."""
    return " ".join(decimal_text(x) for x in numbers)
