"""Mechanisms from SDF files (SDFormat): links are bodies, joints are joints, frames are points, the world is ground.

What is drawn, sensed or touched is left aside; what would change the motion and has no place in a scene is refused.
Reference: SDFormat specification, sdformat.org/spec, with the changes of meaning up to 1.12.

    pose         x y z roll pitch yaw, in `relative_to`: the model for a link, the child for a joint
    joint        origin = X_PJ, tip = X_JC of the poses in the file, where every joint is at zero
    axis         in the joint frame or `expressed_in`; before 1.5 in the model's
    loops        a joint whose ends are led to the ground by others already is cut
    a model that no joint ties to the world is free: a joint with a quaternion, which starts where the file puts it
    <gravity>    of the world, 0 0 -9.8 without one; a file without a world has 9.81 as other robot files
    <inertial>   what it leaves out is 1 kg and 1 kg m^2
    <effort>     zero: a joint without a drive
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from symdyn.errors import listed, suggestion
from symdyn.graph import Op
from symdyn.scene.declaration.declare import Declaration, reading_of
from symdyn.scene.declaration.joint_table import STAND_IN
from symdyn.scene.declaration.reading import Opened, Reading, ReadOptions
from symdyn.scene.formats.inertias import WHERE as FLOATING, free_base
from symdyn.scene.formats.placing import known
from symdyn.scene.formats.robot_file import INERTIA, RobotFile
from symdyn.scene.formats.sdf_frames import Frame, Frames, Poses, based, says
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose, Step, circular, translation
from symdyn.scene.values.entry import Entry, Faults, show
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import NULL, Quantity, Value, Vector

MODEL, WORLD = "__model__", "world"

TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "screw": "helical",
    "universal": "universal",
    "revolute2": "universal",
    "ball": "spherical",
    "fixed": "fixed",
}

TWO = ("universal", "revolute2")
"""Joints of two axes; a ball and a fixed joint need none."""

SPLIT = "write two revolute joints with a link between them"

WRITE_OUT = 'gz sdf -p FILE > whole.sdf writes it out where its <include> says merge="true"'

REFUSED = {
    "world": {
        "include": f"an <include> is not read; delete it if it is scenery, or put the model in its place; {WRITE_OUT}",
        "population": "a <population> is not read; write out its models",
        "joint": "a joint between models is not read; put their links into one model",
    },
    "model": {
        "include": f"an <include> is not read; {WRITE_OUT}",
        "model": f"a nested model is not read; move its links and joints into the outer one; {WRITE_OUT}",
    },
    "link": {"velocity_decay": "drag by <velocity_decay> is not read; write <damping> of joints, or [loads] in TOML"},
    "inertial": {"fluid_added_mass": "<fluid_added_mass> is not read; write [loads] in TOML"},
}
"""What would change the motion, by where it stands, and what would work."""

ONCE = {"model": ("pose",), "frame": ("pose",), "link": ("pose", "inertial"), "inertial": ("pose", "mass", "inertia")}
ONCE["joint"] = ("pose", "parent", "child", "axis", "axis2")
"""What stands in an element once at most, and is read."""

LEFT = {"plugin": "what plugins do is not part of the equations", "state": "a recorded state is left aside"}

STANDARD: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.number(Fraction(-49, 5)))

Z_AXIS: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.ONE)

OLD = (1, 5)
"""Before this version axes are those of the model."""

VAIN = ("limits", "drive", "drives", "friction")
"""What a joint that must close a loop has no use for."""

UNITS = {key: Quantity.ONE if key[1] == key[2] else Quantity.ZERO for key in INERTIA}


def read(path: Path | Opened, options: ReadOptions) -> Reading:
    """Return the scene in an SDF file; SceneError with every fault of it, one line each."""
    return read_element(*XmlElement.noted(path), options)


def read_element(root: XmlElement, faults: Faults, options: ReadOptions) -> Reading:
    """Return the scene below the root of an SDF file; errors as of `read`."""
    root.check_root("sdf", "an SDF file", faults)
    worlds = root.all("world") or [XmlElement("world", {}, root.line)]
    every = [*root.all("model"), *worlds[0].all("model")]
    moving = [model for model in every if not says(faults, model, "static")]
    still = [model.attributes.get("name", "") for model in every if model not in moving]
    _refuse(worlds[0], faults)
    for what, found in (("worlds", worlds), ("models that move", moving)):
        if len(found) > 1:
            faults.add(f"line {found[1].line}", f"there are {len(found)} {what}; keep one in a file")
    if not moving:
        static = f"; {listed(still)} is static: delete <static>" if still else ""
        faults.add("", f"there is no <model> that moves{static}")
    faults.close()
    if still:
        faults.note("", f"what is static is left aside ({listed(still)})")
    scope = worlds[0] if root.all("world") else root
    model = _Model(moving[0], scope, root.attributes.get("version", ""), faults, options)
    declaration = model.declaration()
    model.note_data()
    return reading_of(declaration, faults, options)


def _refuse(element: XmlElement, faults: Faults) -> None:
    """Report what stands in an element and would change the motion; note what may act and is left aside."""
    for child in element.children:
        told = REFUSED.get(element.tag, {}).get(child.tag)
        if told and not (child.tag == "include" and says(faults, child, "static")):
            faults.add(f"line {child.line}", told)
    for tag in ONCE.get(element.tag, ()):
        if again := element.all(tag)[1:]:
            faults.add(f"line {again[0].line}", f"a second <{tag}> of one <{element.tag}>; keep one of them")
    for tag, told in LEFT.items():
        if element.all(tag):
            faults.note(f"line {element.all(tag)[0].line}", told)


def _part(element: XmlElement, tag: str) -> XmlElement:
    """Return the first element of a tag with what its children say as attributes, an empty one where there is none."""
    return (element.first(tag) or XmlElement(tag, {}, element.line)).flat()


class _Model(RobotFile):
    """One walk over one model; `scope` is what it stands in, a world or the file."""

    def __init__(self, root: XmlElement, scope: XmlElement, version: str, faults: Faults, options: ReadOptions) -> None:
        super().__init__(root, faults, options)
        _refuse(root, faults)
        self.poses, self.base = Poses(self.attributes, options.snap), options.floating_base
        self.old = () < tuple(int(part) for part in version.split(".") if part.isdecimal() and len(part) < 9) < OLD
        tags = ("link", "joint", "frame")
        self.links, self.joints, points = ([self.named(one) for one in root.all(tag)] for tag in tags)
        self.frames = self._frames(MODEL, [*self.links, *self.joints, *points])
        self.body_name = self.printable([name for name, _ in (*self.links, *points) if name], "link")
        self.joint_name = self.printable([name for name, _ in self.joints if name], "joint")
        where, link = f"line {root.line}: model", next((name for name, _ in self.links), "")
        if not link:
            faults.add(where, "there is no <link>; a model has one at least")
        keys = ("canonical_link", "placement_frame")
        carrier, placed = (self.frames.known(root.attributes.get(key) or MODEL, where, key) for key in keys)
        self.canonical = self.frames.body(carrier, link)
        world = self._frames(WORLD, [self.named(one) for one in scope.children if one.tag in ("frame", "model")])
        name = root.attributes.get("name", "").strip()
        self.place = (*world.between(WORLD, name or WORLD), *self.frames.between(placed, MODEL))
        self.points = [self._point(name, frame) for name, frame in points if name]
        self.springs: list[Entry] = []
        self.gravity = self._gravity(scope)

    def declaration(self) -> Declaration:
        given = self.root.attributes.get("name", "").strip() or Path(self.source).stem
        links = [(name, self.body_name[name], link) for name, link in self.links if name]
        bodies = [Entry(body, self._body(name, link), self.where(name, link)) for name, body, link in links]
        place = {child: k for k, child in enumerate(self.root.children)}
        every = [(joint, self._joint(name, joint)) for name, joint in self.joints if name]
        free = self._free([entry for _, entry in every])
        cut = [
            entry for joint, entry in every if any(says(self.faults, one, "must_be_loop_joint") for one in joint.walk())
        ]
        joints = [(place[one], entry) for one, entry in (*every, *free) if entry not in cut]
        return Declaration(
            name=self.printable([given], "robot")[given],
            gravity=self.gravity,
            bodies=tuple(bodies),
            joints=tuple(entry for _, entry in sorted(joints, key=lambda one: one[0])),
            points=tuple(self.points),
            loops=tuple(replace(one, table=_without(one.table, VAIN)) for one in cut),
            elements={"springs": tuple(self.springs)},
        )

    def _gravity(self, scope: XmlElement) -> object:
        """Return the gravity of the world, None without one; no gravity where it pulls no link."""
        where = f"line {scope.line}: world"
        free = [name for name, link in self.links if not says(self.faults, link, "gravity", usual=True)]
        if free and len(free) < len(self.links):
            advice = "give it to all links or to none, and write [loads] in TOML"
            self.faults.add(where, f"<gravity> is false for some links and not for others ({listed(free)}); {advice}")
        if free or scope.tag != "world":
            return list(NULL) if free else None
        if scope.first("gravity") is None:
            self.faults.note(where, "has no <gravity>; SDF takes 0 0 -9.8")
        return list(self.attributes.vector(where, scope.flat(), "gravity", STANDARD))

    # Frames

    def _frames(self, root: str, named: Sequence[tuple[str, XmlElement]]) -> Frames:
        """Return the frames of a scope: joints are given in their child, frames in what they are attached to."""
        names, frames = {name for name, _ in named}, []
        for name, one in named:
            keys = {"joint": one.flat().attributes.get("child", ""), "frame": one.attributes.get("attached_to", "")}
            attached = keys.get(one.tag) or ("" if one.tag == "link" else root)
            if one.tag == "joint" and attached not in names:
                attached = root  # reported where it is read
            where, pose = self.where(name, one), one.first("pose")
            if root == MODEL:
                _refuse(one, self.faults)
            if name:
                base = based(pose) or attached or root
                frames.append(Frame(name, self.poses.read(where, pose), base, attached, where))
        return Frames(root, frames, self.faults, self.attributes.snap)

    def _from(self, link: str, frame: str) -> tuple[Step, ...]:
        return self.frames.between(link, frame) if link else (*self.place, *self.frames.between(MODEL, frame))

    def _point(self, name: str, frame: XmlElement) -> Entry:
        where, link = self.where(name, frame), self.frames.body(name, self.canonical)
        at = self.poses.placed(self.frames.between(link, name))
        return Entry(self.body_name[name], {"body": self.body_name.get(link, Scene.GROUND), "at": at}, where)

    # Links

    def _body(self, name: str, link: XmlElement) -> dict[str, object]:
        where, inertial = self.where(name, link), _part(link, "inertial")
        _refuse(inertial, self.faults)
        if says(self.faults, link, "kinematic"):
            self.faults.add(where, "is <kinematic>, moved by a program; give its joint a motion in TOML")
        if says(self.faults, inertial, "auto"):
            advice = "gz sdf -p --expand-auto-inertials FILE > whole.sdf writes numbers"
            self.faults.add(where, f"<inertial auto> takes the inertia from shapes, which are not read; {advice}")
        pose = inertial.first("pose")
        if base := based(pose):
            told = f"<pose relative_to={show(base)}> of <inertial>: it is in its link; delete relative_to"
            self.faults.add(where, told)
        if "mass" not in inertial.attributes or inertial.first("inertia") is None:
            self.note("what <inertial> leaves out is 1 kg and 1 kg m^2, as SDF has it", name)
        steps = self.poses.read(where, pose)
        turn = [step for step in steps if step[0][0] == "R"]
        mass = self.attributes.number(where, inertial, "mass", Quantity.ONE)
        inertia = self.inertia(where, _part(inertial, "inertia"), turn, UNITS)
        return {"mass": mass, "com": translation(Pose(steps)), **inertia}

    # Joints

    def _joint(self, name: str, joint: XmlElement) -> Entry:
        where, said = self.where(name, joint), joint.flat()
        given = self.attributes.text(where, joint, "type", f"write one of {', '.join(TYPES)}")
        if given and given not in TYPES:
            told = "write <mimic> in an <axis>" if given == "gearbox" else suggestion(given, TYPES)
            self.faults.add(where, f"type={show(given)} is not read; {told}")
        parent, child = (self._end(where, said, key) for key in ("parent", "child"))
        table: dict[str, object] = {
            "type": TYPES.get(given, STAND_IN),
            "parent": self.body_name.get(parent, Scene.GROUND),
            "child": self.body_name.get(child, ""),
            "origin": self.poses.placed(self._from(parent, name)),
            "tip": self.poses.placed(self.frames.between(name, child or MODEL)),
        }
        if given == "fixed":
            return Entry(self.joint_name[name], table, where)
        keys = ("axis", "axis2") if given in TWO else ("axis",)
        axes = [_part(joint, key) for key in keys]
        for key, axis, ours in zip(keys, axes, ("axis", "second_axis"), strict=False) if given != "ball" else ():
            if joint.first(key) is None:
                self.faults.add(where, f"<{key}> is missing; give <{key}><xyz>0 0 1</xyz></{key}>")
            table[ours] = self._axis(where, name, axis)
        if given == "screw":
            table["pitch"] = self._pitch(where, said)
        return Entry(self.joint_name[name], table | self._moving(where, name, given, axes), where)

    def _end(self, where: str, said: XmlElement, key: str) -> str:
        """Return the link at an end of a joint; "" for the world, and after a fault."""
        name = self.attributes.text(where, said, key, f"name a link as its <{key}>")
        if name == WORLD and key == "child":
            self.faults.add(where, "<child> is the world, which carries and is not carried; swap parent and child")
        known = name and name != WORLD
        return self.frames.body(self.frames.known(name, where, key), self.canonical) if known else ""

    def _axis(self, where: str, name: str, axis: XmlElement) -> Vector:
        """Return the direction of an axis in the frame of its joint."""
        given = self.attributes.vector(where, axis, "xyz", Z_AXIS)
        of_model = self.old or says(self.faults, axis, "use_parent_model_frame")
        inside = _part(axis, "xyz").attributes.get("expressed_in") or (MODEL if of_model else name)
        return self.poses.turned(given, self.frames.between(name, self.frames.known(inside, where, "expressed_in")))

    def _pitch(self, where: str, joint: XmlElement) -> Quantity:
        """Return the pitch of a screw, m a turn; `thread_pitch` is in rad/m, and positive left-handed."""
        if "screw_thread_pitch" in joint.attributes:
            return self.attributes.number(where, joint, "screw_thread_pitch")
        ratio = self.attributes.number(where, joint, "thread_pitch")
        if ratio == Quantity.ZERO:
            self.faults.add(where, "has no pitch; give <screw_thread_pitch>, m a turn")
            return Quantity.ONE
        return folding.div(folding.mul(Quantity.number(-2), Quantity.PI), ratio)

    def _moving(self, where: str, name: str, given: str, axes: Sequence[XmlElement]) -> dict[str, object]:
        """Return what resists, limits, drives and couples a joint; keep its spring."""
        number = self.attributes.number
        table: dict[str, object] = {}
        angle = number if given == "prismatic" else self.attributes.angle
        parts, single = [_part(axis, "dynamics") for axis in axes], given not in ("ball", *TWO)
        for key in ("damping", "friction"):
            first, *others = (number(where, part, key) for part in parts)
            table |= {key: first} if first != Quantity.ZERO else {}
            if others not in ([], [first]):
                told = f"{key} of its two axes differs, and a joint has one; make them equal, or {SPLIT}"
                self.faults.add(where, told)
        limits = [self._limit(where, given, axis) for axis in axes]
        stiff = [k for k in (number(where, part, "spring_stiffness") for part in parts) if k != Quantity.ZERO]
        mimics = [axis.first("mimic") for axis in axes if axis.first("mimic")]
        if not single:
            if stiff or mimics:
                self.faults.add(where, f"a spring, or <mimic>, of a {given} joint is not read; {SPLIT}")
            if any(limits):
                self.note("limits of a joint with several coordinates are left out", name)
        elif stiff:
            spring = {"joint": self.joint_name[name], "stiffness": stiff[0]}
            spring["free"] = angle(where, parts[0], "spring_reference")
            self.springs.append(Entry(self.joint_name[name], spring, where))
        if single and mimics:
            mimic = _part(axes[0], "mimic")
            leader = self.attributes.text(where, mimic, "joint", "name the joint to follow")
            if mimic.attributes.get("axis", "axis") != "axis":
                self.faults.add(where, f"<mimic> of an axis2 is not read; in place of its leader {SPLIT}")
            ratio = number(where, mimic, "multiplier", Quantity.ONE)
            offset, reference = (angle(where, mimic, key) for key in ("offset", "reference"))
            offset = folding.sub(offset, folding.mul(ratio, reference))
            table["mimic"] = {"joint": self.joint_name.get(leader, leader), "ratio": ratio, "offset": offset}
        elif not all(driven := [given != "ball" and one.get("effort") != Quantity.ZERO for one in limits]):
            table |= {"drives": driven} if any(driven) else {"drive": False}
        if single:
            table["limits"] = _without(limits[0], ["effort"] if limits[0].get("effort") == Quantity.ZERO else [])
        return table

    def _limit(self, where: str, given: str, axis: XmlElement) -> dict[str, Quantity]:
        """Return the limits of an axis; of effort and velocity, a negative one is none."""
        limit, keys = _part(axis, "limit"), ("lower", "upper", "velocity", "effort")[2 * (given == "continuous") :]
        found = self.limits(where, limit, dict.fromkeys(key for key in keys if key in limit.attributes))
        return {key: value for key, value in found.items() if key in keys[:-2] or (folding.fraction(value) or 0) >= 0}

    # What floats

    def _free(self, joints: Sequence[Entry]) -> list[tuple[XmlElement, Entry]]:
        """Return a free joint for each part that no joint ties to the world, beside the link that it carries."""
        at: dict[str, set[str]] = {}
        for joint in joints:
            pair = {str(joint.table["parent"]), str(joint.table["child"])}
            for body in pair:
                at.setdefault(body, set()).update(pair)
        children, seen, found = {joint.table["child"] for joint in joints}, _reached(at, Scene.GROUND), []
        heads = sorted(self.links, key=lambda one: (self.body_name.get(one[0]) in children, one[0] != self.canonical))
        for name, link in heads:
            root = self.body_name.get(name, Scene.GROUND)
            if root in seen:
                continue
            seen |= _reached(at, root)
            steps = self._from("", name)
            start = [*translation(Pose(steps)), *map(quantity, quaternion(steps))]
            there = start if start != AT_REST else None
            found.append((link, free_base(self.base or f"{root}_free", root, joints, self.faults, there)))
            if self.base is None:
                advice = "a fixed joint with <parent>world</parent> would hold one"
                self.note(f"what no joint ties to the world is free, by a joint NAME_free; {advice}", root)
        if self.base is not None and len(found) != 1:
            told = f"{len(found)} parts of the model are free, and one can have this name; leave it out"
            self.faults.add(FLOATING, told)
        return found


def _without(table: Mapping[str, Any], keys: Sequence[str]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in keys}


AT_REST = [Quantity.ZERO] * 3 + [Quantity.ONE] + [Quantity.ZERO] * 3


def quaternion(steps: Sequence[Step]) -> list[Value]:
    """Return the quaternion w, x, y, z of the turns among some steps."""
    found: list[Value] = [Fraction(1), *[Fraction(0)] * 3]
    for kind, angle in steps:
        if kind[0] == "R":
            half = folding.mul(Quantity.number(Fraction(1, 2)), angle)
            c, s = (known(circular(op, half), {}) for op in (Op.COS, Op.SIN))
            w, *v = found
            i, j, k = (("xyz".index(kind[1]) + shift) % 3 for shift in range(3))
            found = [w * c - v[i] * s, *[Fraction(0)] * 3]
            found[1 + i], found[1 + j], found[1 + k] = v[i] * c + w * s, v[j] * c + v[k] * s, v[k] * c - v[j] * s
    return found


def _reached(at: Mapping[str, set[str]], start: str) -> set[str]:
    """Return what joints lead to from a body, itself included."""
    seen, waiting = {start}, [start]
    while waiting:
        new = at.get(waiting.pop(), set()) - seen
        seen |= new
        waiting += new
    return seen
