"""Robots from URDF files: links are bodies, joints are joints, the root link is the ground.

Read are the parts that a mechanism has; what is drawn, sensed, transmitted or simulated (visual, collision, sensor,
transmission, gazebo, ...) is left aside, as the format demands of elements that a reader has no use for. No mesh is
opened here and no package:// is looked up; films in space do both (`symdyn.draw.robot_meshes`).
Reference: the URDF XML specification, wiki.ros.org/urdf/XML.

    origin rpy       R = Rz(yaw) Ry(pitch) Rx(roll), the rpy of a scene
    inertia          about the centre of mass, along the axes of its origin; products are matrix entries, as here
    axis             (1, 0, 0) when left out, of any length
    floating         a free joint with a quaternion; planar: in the plane across the axis; neither is driven
    damping          enters the equations; friction and limits are data
    mimic            position = multiplier · position of the joint + offset

Numbers in attributes of XML elements: exact as written, angles snapped, every fault collected.
"""

from __future__ import annotations

import re
from decimal import Decimal
from pathlib import Path
from typing import Any

from symdyn.errors import SceneError, listed, suggestion
from symdyn.scene.declaration.declare import Declaration, reading_of
from symdyn.scene.declaration.joint_table import STAND_IN, freedoms
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions
from symdyn.scene.formats.inertias import Entries, free_base, turned
from symdyn.scene.formats.placing import printable_names, snap_angle
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.joints.blocks import AXIS
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values import folding
from symdyn.scene.values.entry import Entry, Faults, show
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, FormulaError, Quantity, Vector, spell

_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?\Z", re.ASCII)


class Attributes:
    """Typed access to attributes. What cannot be read is a fault, and a usable stand-in takes its place."""

    def __init__(self, faults: Faults, snap: bool) -> None:
        """Remember where faults go and whether angles are snapped to multiples of π."""
        self.faults, self.snap = faults, snap
        self._snapped: dict[tuple[str, Quantity], list[str]] = {}

    def text(self, where: str, element: XmlElement, key: str, advice: str) -> str:
        """Return text that must be given, "" after a fault."""
        value = element.attributes.get(key, "").strip()
        if not value:
            self.faults.add(where, f"<{element.tag}> has no {key}; {advice}")
        return value

    def number(self, where: str, element: XmlElement, key: str, default: Quantity | None = Quantity.ZERO) -> Quantity:
        """Return a number; one that must be given has no default."""
        if key not in element.attributes:
            if default is None:
                self.faults.add(where, f'<{element.tag}> has no {key}; give a number such as {key}="1.0"')
            return default or Quantity.ZERO
        return self._read(where, element, key, element.attributes[key].strip())

    def angle(self, where: str, element: XmlElement, key: str) -> Quantity:
        """Return an angle, rad; 0 when it is not given."""
        value = self.number(where, element, key)
        return self._snap(where, key, element.attributes.get(key, ""), value)

    def vector(self, where: str, element: XmlElement | None, key: str, default: Vector = NULL) -> Vector:
        """Return three numbers; the default when the element or the attribute is not there."""
        words = self._three(where, element, key)
        if element is None or words is None:
            return default
        return self._triple([self._read(where, element, key, word) for word in words])

    def angles(self, where: str, element: XmlElement | None, key: str) -> Vector:
        """Return three angles, rad; zeros when the element or the attribute is not there."""
        words = self._three(where, element, key)
        if element is None or words is None:
            return NULL
        place = f"<{element.tag}> {key}"
        values = [self._snap(where, place, word, self._read(where, element, key, word)) for word in words]
        return self._triple(values)

    def note_snaps(self) -> None:
        """Note every angle that was read as a multiple of π, one line for each spelling."""
        for (text, value), places in self._snapped.items():
            self.faults.note("", f"{text} is read as {spell(value)} in {', '.join(places)}")

    def _three(self, where: str, element: XmlElement | None, key: str) -> list[str] | None:
        if element is None or key not in element.attributes:
            return None
        words = element.attributes[key].split()
        if len(words) == 3:
            return words
        shown = show(element.attributes[key])
        advice = f'three are needed, such as {key}="0 0 1"'
        self.faults.add(where, f"<{element.tag}> {key}={shown} has {len(words)} numbers; {advice}")
        return None

    def _triple(self, values: list[Quantity]) -> Vector:
        x, y, z = values
        return (x, y, z)

    def _read(self, where: str, element: XmlElement, key: str, text: str) -> Quantity:
        try:
            if not _DECIMAL.match(text):
                raise FormulaError("is not a decimal number; write one such as 0.35 or 1e-3")
            return quantity(Decimal(text))
        except FormulaError as error:
            reason = str(error)
            verb = "" if reason.startswith("is ") else "cannot be used: "
            self.faults.add(where, f"<{element.tag}> {key}={show(text)} {verb}{reason}")
            return Quantity.ZERO

    def _snap(self, where: str, place: str, text: str, value: Quantity) -> Quantity:
        snapped = snap_angle(text) if self.snap and value != Quantity.ZERO else None
        if snapped is None:
            return value
        places = self._snapped.setdefault((text.strip(), snapped), [])
        name = f"{where} {place}"
        if name not in places:
            places.append(name)
        return snapped


TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
}

SEVERAL = ("floating", "planar")
"""Joints of several coordinates, which nothing drives."""

X_AXIS: Vector = (Quantity.ONE, Quantity.ZERO, Quantity.ZERO)

UNLIMITED = 10**9
"""A limit of this size or more is none: the format demands numbers, and files write 1e9 or 1e16 for "no limit"."""

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in a URDF file.

    Raises:
        SceneError: with every fault of the file, one line each.
    """
    faults = Faults(str(path))
    return read_element(XmlElement.read(path, faults.note), str(path), options, faults)


def read_element(root: XmlElement, source: str, options: ReadOptions, faults: Faults | None = None) -> Reading:
    """Return the scene below a <robot> element; `source` stands in front of every fault and note, `faults` of before.

    Raises:
        SceneError: with every fault of the element, one line each.
    """
    if root.tag != "robot":
        raise SceneError(f"{source}: its root is <{root.tag}>; the root of a URDF is <robot>")
    _refuse_xacro(root, source)
    faults = faults or Faults(source)
    robot = _Robot(root, faults, options)
    declaration = Declaration(name=robot.name(), bodies=tuple(robot.bodies()), joints=tuple(robot.joints_in_file()))
    robot.note_data()
    return reading_of(declaration, faults, options)


def _refuse_xacro(root: XmlElement, source: str) -> None:
    """Refuse macros and expressions that xacro has yet to replace."""
    advice = "run xacro first: xacro robot.xacro > robot.urdf"
    for element in root.walk():
        namespace, _, tag = element.tag.rpartition("}")
        if "xacro" in namespace:
            raise SceneError(f"{source}: line {element.line}: <xacro:{tag}> is a macro; {advice}")
        for key, value in element.attributes.items():
            if "${" in value and not namespace:
                found = f"<{element.tag}> {key}={show(value)} is an expression of xacro"
                raise SceneError(f"{source}: line {element.line}: {found}; {advice}")


class _Robot:
    """One walk over one file: links to bodies, joints to joints, names to printable names."""

    def __init__(self, root: XmlElement, faults: Faults, options: ReadOptions) -> None:
        self.root, self.faults = root, faults
        self.source = faults.source
        self.attributes = Attributes(faults, options.snap)
        self.links = [self._named(link) for link in root.all("link")]
        self.joints = [self._named(joint) for joint in root.all("joint")]
        self.body_name = self._printable([name for name, _ in self.links if name], "link")
        self.joint_name = self._printable([name for name, _ in self.joints if name], "joint")
        self.base, roots = options.floating_base, self._roots()
        if self.base is None:
            self.body_name.update(dict.fromkeys(roots, Scene.GROUND))
        self.root_names = [self.body_name[name] for name in roots]
        self.data: dict[str, list[str]] = {}

    def name(self) -> str:
        """Return the name of the scene."""
        given = self.root.attributes.get("name") or Path(self.source).stem
        return self._printable([given], "robot")[given]

    def bodies(self) -> list[Entry]:
        """Return the links but the root."""
        entries = []
        for name, link in self.links:
            where = self._where(name, link)
            body = self._body(where, link)
            if name and self.body_name[name] != Scene.GROUND:
                entries.append(Entry(self.body_name[name], body, where))
            elif name and body.get("mass", Quantity.ZERO) != Quantity.ZERO:
                found = f"is the root and does not move; its mass ({spell(body['mass'])} kg) enters no equation"
                self.faults.note(where, f"{found}, and the potential energy is that of the moving links")
        return entries

    def joints_in_file(self) -> list[Entry]:
        """Return the joints; where the base floats, the one that carries the root is the first."""
        joints = [
            Entry(self.joint_name[name], self._joint(self._where(name, joint), name, joint), self._where(name, joint))
            for name, joint in self.joints
            if name
        ]
        if self.base is not None:
            joints[:0] = [free_base(self.base, root, joints, self.faults) for root in self.root_names]
        return joints

    def note_data(self) -> None:
        """Note what was snapped, and what was read that the equations do not hold, or that other tools leave out."""
        self.attributes.note_snaps()
        for what, names in self.data.items():
            self.faults.note("", f"{what} ({listed(names)})")

    # Names and tree

    def _named(self, element: XmlElement) -> tuple[str, XmlElement]:
        name = element.attributes.get("name", "").strip()
        if not name:
            advice = f'give one such as name="{element.tag}_1"'
            self.faults.add(f"line {element.line}", f"<{element.tag}> has no name; {advice}")
        return name, element

    def _where(self, name: str, element: XmlElement) -> str:
        return f"line {element.line}: {element.tag} {name}".rstrip()

    def _printable(self, names: list[str], kind: str) -> dict[str, str]:
        chosen = printable_names(names, kind)
        for name, better in chosen.items():
            if name != better:
                self.faults.note(f"{kind} {show(name)}", f"is called {better} here")
        return chosen

    def _roots(self) -> list[str]:
        """Return the links that are nobody's child; in a tree there is one."""
        children = {child for _, joint in self.joints if (child := _link_of(joint, "child"))}
        roots = [name for name in self.body_name if name not in children]
        if not self.links:
            self.faults.add("", "there is no <link>; was it written by xacro from a file without content?")
        elif not roots:
            advice = "a URDF is a tree, and one link must be the root; delete the joint that closes the loop"
            self.faults.add("", f"every link is the child of a joint; {advice}")
        elif len(roots) > 1:
            advice = "connect all but one of them by joints, such as fixed ones"
            self.faults.add("", f"{len(roots)} links are the child of no joint: {listed(roots)}; {advice}")
        return roots

    # Links

    def _body(self, where: str, link: XmlElement) -> dict[str, Any]:
        inertial = link.first("inertial")
        if inertial is None:
            return {}
        mass, inertia, origin = inertial.first("mass"), inertial.first("inertia"), inertial.first("origin")
        if mass is None:
            advice = "give both mass and inertia, or leave out <inertial> for a massless link"
            self.faults.add(where, f"<inertial> has no <mass>; {advice}")
            return {}
        table: dict[str, Any] = {"mass": self.attributes.number(where, mass, "value", None)}
        if inertia is None:
            self._note("<inertial> without <inertia> is read as a point mass at its origin", where)
            return table | {"com": self.attributes.vector(where, origin, "xyz")}
        xx, yy, zz, xy, xz, yz = (self.attributes.number(where, inertia, key, None) for key in INERTIA)
        entries: Entries = (xx, yy, zz, xy, xz, yz)
        rpy = self.attributes.angles(where, origin, "rpy")
        if rpy != NULL:
            entries = turned(entries, rpy)
        table["com"] = self.attributes.vector(where, origin, "xyz")
        table["inertia"] = dict(zip(("xx", "yy", "zz", "xy", "xz", "yz"), entries, strict=True))
        table["inertia_about"] = "com"
        return table

    # Joints

    def _joint(self, where: str, name: str, joint: XmlElement) -> dict[str, object]:
        origin = joint.first("origin")
        kind = self._type(where, joint)
        table: dict[str, object] = {
            "type": kind,
            "parent": self._end(where, joint, "parent"),
            "child": self._end(where, joint, "child"),
            "origin": {
                "xyz": self.attributes.vector(where, origin, "xyz"),
                "rpy": self.attributes.angles(where, origin, "rpy"),
            },
        }
        dynamics = joint.first("dynamics")
        losses: dict[str, object] = {}
        if dynamics is not None:
            losses = {key: self.attributes.number(where, dynamics, key) for key in ("damping", "friction")}
        if not freedoms(Entry(name, table, where)):
            for key in ("damping", "friction"):
                if losses.get(key, Quantity.ZERO) != Quantity.ZERO:
                    self._note(f"{key} of a fixed joint is left out", name)
            if joint.first("mimic") is not None:
                self._note("mimic of a fixed joint is left out", name)
            return table
        if AXIS in JOINTS[kind].keys:
            table["axis"] = self.attributes.vector(where, joint.first("axis"), "xyz", X_AXIS)
        if joint.attributes.get("type") in SEVERAL:
            for tag in ("limit", "mimic"):
                if joint.first(tag) is not None:
                    self._note(f"{tag} of a joint with several coordinates is left out", name)
            return table | losses | {"drive": False}
        table.update(losses)
        if losses.get("damping", Quantity.ZERO) != Quantity.ZERO:
            self._note("damping enters the equations as -damping * rate", name)
        table["limits"] = self._limits(where, joint)
        mimic = joint.first("mimic")
        if mimic is not None:
            table["mimic"] = self._mimic(where, joint, mimic)
        return table

    def _type(self, where: str, joint: XmlElement) -> str:
        given = self.attributes.text(where, joint, "type", f"write one of {', '.join(TYPES)}")
        if given and given not in TYPES:
            near = suggestion(given, TYPES)
            self.faults.add(where, f"type={show(given)} is not a joint of URDF; {near}")
        return TYPES.get(given, STAND_IN)

    def _end(self, where: str, joint: XmlElement, key: str) -> str:
        """Return the body that a joint hangs on, or carries."""
        link = _link_of(joint, key)
        if not link:
            self.faults.add(where, f'<{key} link="..."> is missing; name the link there')
            return ""
        if link not in self.body_name:
            self.faults.add(where, f"<{key}> link={show(link)} is not a link; {suggestion(link, self.body_name)}")
            return ""
        return self.body_name[link]

    def _limits(self, where: str, joint: XmlElement) -> dict[str, Quantity]:
        limit, kind = joint.first("limit"), joint.attributes.get("type")
        if limit is None:
            if kind in ("revolute", "prismatic"):
                other = ', or make it type="continuous"' if kind == "revolute" else ""
                advice = f'give <limit lower="-1" upper="1" effort="10" velocity="1"/>{other}'
                self.faults.add(where, f"<limit> is missing; {advice}")
            return {}
        defaults = {} if kind == "continuous" else {"lower": Quantity.ZERO, "upper": Quantity.ZERO}
        limits = {}
        for key in (*defaults, "velocity", "effort"):
            if limit.attributes.get(key, "").strip().lstrip("+-").lower() in ("inf", "infinity"):
                continue
            value = self.attributes.number(where, limit, key, defaults.get(key))
            size = folding.fraction(value)
            if size is None or -UNLIMITED < size < UNLIMITED:
                limits[key] = value
        low, high = (folding.fraction(limits[key]) if key in limits else None for key in ("lower", "upper"))
        if low is not None and high is not None and low > high:
            shown = (f"{key}={show(limit.attributes.get(key, '0'))}" for key in ("lower", "upper"))
            self.faults.add(where, f"<limit> {' is above '.join(shown)}; swap them")
            return {}
        return limits

    def _mimic(self, where: str, joint: XmlElement, mimic: XmlElement) -> dict[str, object]:
        leader = self.attributes.text(where, mimic, "joint", "name the joint to follow")
        turns = joint.attributes.get("type") != "prismatic"
        read_offset = self.attributes.angle if turns else self.attributes.number
        return {
            "joint": self.joint_name.get(leader, leader),
            "ratio": self.attributes.number(where, mimic, "multiplier", Quantity.ONE),
            "offset": read_offset(where, mimic, "offset"),
        }

    def _note(self, what: str, name: str) -> None:
        self.data.setdefault(what, []).append(name)


def _link_of(joint: XmlElement, key: str) -> str:
    """Return the name of the link that <parent> or <child> gives, "" if it gives none."""
    element = joint.first(key)
    return "" if element is None else element.attributes.get("link", "").strip()
