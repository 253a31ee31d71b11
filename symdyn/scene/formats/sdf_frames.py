"""Frames of an SDF scope, a world or a model: poses in terms of one another, and what each is attached to.

    X_AB = X_CA⁻¹ X_CB        C the last frame that is above both A and B, by `relative_to`

so what lies between two frames is made of the poses on the way alone, and reads as the file does where one is given in
the other. Reference: SDFormat specification, "Pose frame semantics".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from symdyn.errors import suggestion
from symdyn.frozen import dataclass
from symdyn.scene.formats.mjcf_joints import merged
from symdyn.scene.formats.placing import Doubles, Matrix, known, placement, times
from symdyn.scene.formats.robot_file import Attributes
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose, Step, inverse_steps, translation
from symdyn.scene.values.entry import STRAIGHT, Faults, show
from symdyn.scene.values.folding import DEGREE
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.quantity import Vector

EULER, QUATERNION = "euler_rpy", "quat_xyzw"

NUMBERS = {EULER: "six: x y z roll pitch yaw", QUATERNION: "seven: x y z, then the quaternion x y z w"}
"""Formats of a rotation, and the numbers of a pose with one."""

FAR = 36
"""Steps between two frames from which on they are worked out one after the other, each frame once."""

UNTURNED: Matrix = [[float(i == j) for j in range(3)] for i in range(3)]


@dataclass(frozen=True)
class Frame:
    """A name that poses may refer to."""

    name: str  # in the file
    pose: tuple[Step, ...]  # steps from `base`
    base: str  # frame that the pose is given in
    attached: str  # frame that it moves with; "" for itself, a link
    where: str  # for messages


class Frames:
    """The frames of one scope, each led back to its root."""

    def __init__(self, root: str, frames: Iterable[Frame], faults: Faults, snap: bool) -> None:
        """Look whether every frame is led back to the root.

        Raises:
            SceneError: names that stand twice or name no frame, and what goes in a circle.
        """
        self.root, self.faults, self.doubles = root, faults, Doubles(snap)
        self.frames: dict[str, Frame] = {}
        for frame in frames:
            if frame.name == root or frame.name in self.frames:
                other = self.frames[frame.name].where if frame.name in self.frames else "what SDF calls so itself"
                faults.add(frame.where, f"the name {show(frame.name)} is that of {other}, too; rename one of them")
            else:
                self.frames[frame.name] = frame
        self.above = {name: self.known(one.base, one.where, "relative_to") for name, one in self.frames.items()}
        self.carrier = {
            name: one.attached and self.known(one.attached, one.where, "attached_to")
            for name, one in self.frames.items()
        }
        self.places: dict[str, tuple[list[float], Matrix]] = {root: ([0.0] * 3, UNTURNED)}
        self.depth = self._depths(self.above, "relative_to")
        self._depths(self.carrier, "attached_to")
        faults.close()

    def known(self, name: str, where: str, key: str) -> str:
        """Return a name if it is that of a frame; after a fault the root's."""
        if name == self.root or name in self.frames:
            return name
        nested = "; what is inside of nested models is not read" if "::" in name else ""
        told = suggestion(name, [*self.frames, self.root])
        self.faults.add(where, f"{key}={show(name)} is not a frame of this file{nested}; {told}")
        return self.root

    def _depths(self, above: dict[str, str], key: str) -> dict[str, int]:
        """Return how far each frame is from the root, or from what carries itself; a circle is a fault."""
        depths = {self.root: 0, "": 0}
        for start in self.frames:
            path: dict[str, None] = {}
            name = start
            while name not in depths and name not in path:
                path[name] = None
                name = above[name]
            if name in path:
                ring = list(path)[list(path).index(name) :]
                shown = " -> ".join([*ring[:10], *["..."] * (len(ring) > 10), name])
                self.faults.add(self.frames[name].where, f"{key} goes in a circle: {shown}; give one in {self.root}")
            for one in reversed(path):
                depths[one] = depths.get(above[one], 0) + 1
        return depths

    def body(self, name: str, canonical: str) -> str:
        """Return the link that a frame moves with; `canonical` carries the frame of the model."""
        while name != self.root and self.carrier[name]:
            name = self.carrier[name]
        return canonical if name == self.root else name

    def between(self, a: str, b: str) -> tuple[Step, ...]:
        """Return steps from frame a to frame b, where all joints are at zero; far away, with numbers worked out."""
        ends = (a, b)
        back: list[Step] = []
        forth: list[tuple[Step, ...]] = []
        while a != b:
            if self.depth[a] >= self.depth[b]:
                back += inverse_steps(self.frames[a].pose)
                a = self.above[a]
            else:
                forth.append(self.frames[b].pose)
                b = self.above[b]
            if len(back) + 6 * len(forth) > FAR:
                (p, R), (s, S) = (self.seen(end) for end in ends)
                turn = [list(column) for column in zip(*R, strict=True)]
                shift = [sum(x * (t - r) for x, t, r in zip(row, s, p, strict=True)) for row in turn]
                return stepped(shift, times(turn, S), self.doubles)
        return (*back, *(step for steps in reversed(forth) for step in steps))

    def seen(self, name: str) -> tuple[list[float], Matrix]:
        """Return translation and rotation of a frame in the root, kept for the frames behind it."""
        path = []
        while name not in self.places:
            path.append(name)
            name = self.above[name]
        for one in reversed(path):
            (p, R), (shift, turn) = self.places[self.above[one]], placement(Pose(self.frames[one].pose), {})
            r = [a + sum(x * float(y) for x, y in zip(row, shift, strict=True)) for a, row in zip(p, R, strict=True)]
            self.places[one] = r, times(R, [[float(x) for x in row] for row in turn])
        return self.places[path[0] if path else name]


def stepped(
    shift: Sequence[float | Fraction], turn: Sequence[Sequence[float | Fraction]], doubles: Doubles
) -> tuple[Step, ...]:
    """Return a translation and a rotation matrix as steps; what is rounding beside a metre is zero."""
    p = [x if isinstance(x, Fraction) else doubles.vector((x, 1.0, 0.0))[0] for x in shift]
    turns = doubles.turns([[float(x) for x in row] for row in turn], "")
    return merged(*zip(STRAIGHT[:3], map(quantity, p), strict=True), *turns).steps


class Poses:
    """Poses of elements, and what they come to: xyz and rpy with numbers that are as exact as those of the file."""

    def __init__(self, attributes: Attributes, snap: bool) -> None:
        """Remember who reads numbers, and works them out."""
        self.attributes, self.quaternions, self.doubles = attributes, Doubles(snap), Doubles(snap)

    def read(self, where: str, pose: XmlElement | None) -> tuple[Step, ...]:
        """Return the steps of <pose>; none where there is none."""
        words = pose.text.split() if pose is not None else []
        if pose is None or not words:
            return ()
        faults = self.attributes.faults
        format = pose.attributes.get("rotation_format", EULER)
        if format not in NUMBERS:
            faults.add(where, f"<pose> rotation_format={show(format)} is unknown; {suggestion(format, NUMBERS)}")
            return ()
        if len(words) != (6 if format == EULER else 7):
            faults.add(where, f"<pose> {show(pose.text)} has {len(words)} numbers; it takes {NUMBERS[format]}")
            return ()
        said = XmlElement("pose", {"xyz": " ".join(words[:3]), "rpy": " ".join(words[3:6])}, pose.line)
        shift: tuple[Step, ...] = tuple(zip(STRAIGHT[:3], self.attributes.vector(where, said, "xyz"), strict=True))
        if format == EULER:
            degrees = says(faults, pose, "degrees")
            read: Callable[..., Vector] = self.attributes.vector if degrees else self.attributes.angles
            rpy = read(where, said, "rpy")
            turns = [folding.mul(x, DEGREE) if degrees else x for x in rpy]
            return merged(*shift, *zip(STRAIGHT[3:], reversed(turns), strict=True)).steps
        element = XmlElement("pose", dict(zip("xyzw", words[3:], strict=True)), pose.line)
        x, y, z, w = (float(known(self.attributes.number(where, element, name), {})) for name in "xyzw")
        if not 0 < math.hypot(x, y, z, w) < math.inf:
            faults.add(where, f"<pose> {show(pose.text)} has a quaternion of length zero; that of no turn is 0 0 0 1")
            return ()
        return merged(*shift, *self.quaternions.rotation((w, x, y, z), where)).steps

    def placed(self, steps: tuple[Step, ...]) -> Pose:
        """Return steps as one placement: as they stand where that is xyz and rpy, else with numbers worked out."""
        pose = Pose(steps)
        while (shorter := merged(*pose.steps)) != pose:
            pose = shorter
        order = [STRAIGHT.index(kind) for kind, _ in pose.steps]
        if order == sorted(set(order)):
            return pose
        return Pose(stepped(*placement(pose, {}), self.doubles))

    def turned(self, axis: Vector, steps: tuple[Step, ...]) -> Vector:
        """Return a direction that is given behind some steps along the axes in front of them."""
        turns = tuple(step for step in steps if step[0].startswith("R"))
        if not turns:
            return axis
        found = translation(Pose((*turns, *zip(STRAIGHT[:3], axis, strict=True))))
        values = [x.at({}) for x in found]
        exact = all(folding.fraction(x) is not None for x in found)
        return found if exact else self.doubles.direction([float(value or 0) for value in values])


def based(pose: XmlElement | None) -> str:
    """Return the frame that a pose is given in, "" where it does not say; until 1.6 the key was `frame`."""
    found = {} if pose is None else pose.attributes
    return found.get("relative_to", "") or found.get("frame", "")


def says(faults: Faults, element: XmlElement, key: str, usual: bool = False) -> bool:
    """Return whether a boolean is true, an attribute or a child; any other word is a fault."""
    word = element.flat().attributes.get(key, "").strip()
    if word.lower() not in ("", "true", "1", "false", "0"):
        faults.add(f"line {element.line}", f"<{element.tag}> {key}={show(word)} is not a boolean; write true or false")
    return word.lower() in ("true", "1") if word else usual
