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
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from symdyn.errors import SceneError, listed, suggestion
from symdyn.scene.declaration.declare import Declaration, reading_of
from symdyn.scene.declaration.joint_table import STAND_IN, freedoms
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions
from symdyn.scene.formats.inertias import free_base
from symdyn.scene.formats.robot_file import RobotFile
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.joints.blocks import AXIS
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.entry import Entry, Faults, show
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity, Vector, spell

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


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in a URDF file; SceneError with every fault of it, one line each."""
    return read_element(*XmlElement.noted(path), options)


def read_element(root: XmlElement, faults: Faults, options: ReadOptions) -> Reading:
    """Return the scene below the root of a URDF file; errors as of `read`."""
    root.check_root("robot", "a URDF", faults)
    _refuse_xacro(root, faults.source)
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


class _Robot(RobotFile):
    """One walk over one file: links to bodies, joints to joints, names to printable names."""

    def __init__(self, root: XmlElement, faults: Faults, options: ReadOptions) -> None:
        super().__init__(root, faults, options)
        self.links = [self.named(link) for link in root.all("link")]
        self.joints = [self.named(joint) for joint in root.all("joint")]
        self.body_name = self.printable([name for name, _ in self.links if name], "link")
        self.joint_name = self.printable([name for name, _ in self.joints if name], "joint")
        self.base, roots = options.floating_base, self._roots()
        if self.base is None:
            self.body_name.update(dict.fromkeys(roots, Scene.GROUND))
        self.root_names = [self.body_name[name] for name in roots]

    def name(self) -> str:
        given = self.root.attributes.get("name") or Path(self.source).stem
        return self.printable([given], "robot")[given]

    def bodies(self) -> list[Entry]:
        """Return the links but the root."""
        entries = []
        for name, link in self.links:
            where = self.where(name, link)
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
            Entry(self.joint_name[name], self._joint(self.where(name, joint), name, joint), self.where(name, joint))
            for name, joint in self.joints
            if name
        ]
        if self.base is not None:
            joints[:0] = [free_base(self.base, root, joints, self.faults) for root in self.root_names]
        return joints

    # Names and tree

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
            self.note("<inertial> without <inertia> is read as a point mass at its origin", where)
            return table | {"com": self.attributes.vector(where, origin, "xyz")}
        rpy = self.attributes.angles(where, origin, "rpy")
        table["com"] = self.attributes.vector(where, origin, "xyz")
        return table | self.inertia(where, inertia, tuple(zip(("Rz", "Ry", "Rx"), reversed(rpy), strict=True)))

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
                    self.note(f"{key} of a fixed joint is left out", name)
            if joint.first("mimic") is not None:
                self.note("mimic of a fixed joint is left out", name)
            return table
        if AXIS in JOINTS[kind].keys:
            table["axis"] = self.attributes.vector(where, joint.first("axis"), "xyz", X_AXIS)
        if joint.attributes.get("type") in SEVERAL:
            for tag in ("limit", "mimic"):
                if joint.first(tag) is not None:
                    self.note(f"{tag} of a joint with several coordinates is left out", name)
            return table | losses | {"drive": False}
        table.update(losses)
        if losses.get("damping", Quantity.ZERO) != Quantity.ZERO:
            self.note("damping enters the equations as -damping * rate", name)
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
        return self.limits(where, limit, {**defaults, "velocity": None, "effort": None})

    def _mimic(self, where: str, joint: XmlElement, mimic: XmlElement) -> dict[str, object]:
        leader = self.attributes.text(where, mimic, "joint", "name the joint to follow")
        turns = joint.attributes.get("type") != "prismatic"
        read_offset = self.attributes.angle if turns else self.attributes.number
        return {
            "joint": self.joint_name.get(leader, leader),
            "ratio": self.attributes.number(where, mimic, "multiplier", Quantity.ONE),
            "offset": read_offset(where, mimic, "offset"),
        }


def _link_of(joint: XmlElement, key: str) -> str:
    """Return the name of the link that <parent> or <child> gives, "" if it gives none."""
    element = joint.first(key)
    return "" if element is None else element.attributes.get("link", "").strip()
