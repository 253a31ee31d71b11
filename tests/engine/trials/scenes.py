"""Random mechanisms as TOML: trees of all joints, closed ones in space and in an oblique plane, wheels and blades.

A mechanism is drawn with numbers; some of them are told as parameters, of which some are zero. Loops are closed by the
frame on the child that closes them at the start, which is random or natural: zeros, equal or right angles.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symdyn.scene import Scene, read_text

from ..jets import Jet
from ..joints import inverse, motion, pose
from ..mechanism import Array, Mechanism

AXES = ([0, 0, 1], [0, 0, -1], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, -2, 2], [3, 0, 4], [1, 2, 3])
ANGLES = ("pi/2", "-pi/2", "pi", "pi/6", 0.4, -1.1)
ORIENTATIONS = ("quaternion", "quaternion", "zyx", "zxz", "xyz", "zxy")
LETTERS = "abcdefg"

COORDINATES = {  # of a joint whose orientation is told by three angles; a quaternion is one more
    "revolute": 1, "prismatic": 1, "helical": 1, "cylindrical": 2, "universal": 2, "spherical": 3, "planar": 3,
    "point_on_line": 4, "point_on_plane": 5, "rod": 5, "free": 6, "fixed": 0, "custom": 1,
}  # fmt: skip
TURNING = ("spherical", "point_on_line", "point_on_plane", "rod", "free")
STRAIGHT = ("spherical", "rod", "free", "custom", "fixed")  # they take no axis
TREE = ("revolute",) * 4 + ("prismatic",) * 2 + tuple(COORDINATES)
IN_PLANE = ("revolute", "revolute", "spherical", "rod", "point_on_line", "point_on_plane", "cylindrical", "prismatic")
IN_SPACE = tuple(kind for kind in COORDINATES if kind not in ("free", "custom"))


WITHOUT_UNITS: dict[str, Any] = {"units": "none"} if "dimensionless" in Scene.__dataclass_fields__ else {}
"""What is drawn has no dimensions; commits on which faults are shown know no such word."""


class Undrawable(Exception):  # noqa: N818  no error: another mechanism is drawn
    """The numbers drawn give no mechanism."""


@dataclass
class Drawing:
    """A scene while it is drawn.

    Attributes:
        told: "numbers", or "parameters", "free", "zero": how numbers are told.
        natural: "zero", "equal" or "right" angles at the start, or "" for random ones.
        values: of every parameter; zeros: those that are zero.
        q: coordinates at the start.
    """

    rng: random.Random
    told: str = "numbers"
    natural: str = ""
    tables: dict[str, dict[str, Any]] = field(default_factory=lambda: {"bodies": {}, "joints": {}})
    loops: list[dict[str, Any]] = field(default_factory=list)
    values: dict[str, float] = field(default_factory=dict)
    zeros: list[str] = field(default_factory=list)
    gravity: list[Any] | str = field(default_factory=lambda: [0, 0, -9.81])

    # Numbers

    def number(self, x: float, may_vanish: bool = False) -> Any:
        """Return a number as it is, or the name of a new parameter in its place."""
        if self.told == "numbers" or self.rng.random() < 0.7:
            return x
        name = f"p{len(self.values) + 1}"
        if may_vanish and self.told == "zero" and len(self.zeros) < 4:
            self.zeros.append(name)
            x = 0.0
        self.values[name] = x
        return name if self.rng.random() < 0.8 else f"(2*{name} - {name})"

    def small(self) -> Any:
        """Return a length or the like between -0.9 and 0.9; of a natural mechanism 0, 1/2 or 1."""
        rng = self.rng
        return self.number(rng.choice([0, 0, 0.5, 1]) if self.natural else rng.randint(-9, 9) / 10, may_vanish=True)

    def positive(self, low: float = 0.3, high: float = 3.0) -> Any:
        """Return a positive number."""
        return self.number(1 if self.natural else round(self.rng.uniform(low, high), 2))

    def place(self) -> list[Any]:
        """Return a point."""
        return [self.small(), self.small(), self.small()]

    # Bodies and joints

    def body(self, name: str) -> str:
        """Add a body with mass, particles at times."""
        rng, table = self.rng, {"mass": self.positive()}
        about = rng.choice(["com", "com", "frame"])
        table["first_moment" if about == "frame" and rng.random() < 0.5 else "com"] = self.place()
        far = 8.0 if about == "frame" else 0.0  # so that it is an inertia about the frame's origin
        size = rng.choice([0.2, 1.0])
        table["inertia"] = {key: round(far + size * rng.uniform(1, 1.5), 3) for key in ("xx", "yy", "zz")}
        if rng.random() < 0.7:
            table["inertia"] |= {key: round(size * rng.uniform(-0.2, 0.2), 3) for key in ("xy", "xz", "yz")}
        table |= {"inertia_about": about, "allow_invalid_inertia": True}
        if rng.random() < 0.2:
            table["particles"] = [{"mass": self.positive(), "at": self.place()}]
        self.tables["bodies"][name] = table
        return name

    def joint(self, kind: str, parent: str, child: str, **more: Any) -> str:
        """Add a joint of the tree with a random placement, or with keys given."""
        name = f"j{len(self.tables['joints']) + 1}"
        table = {"type": kind, "parent": parent, "child": child, "origin": self.steps()}
        table |= self.shape(kind) | more
        if kind == "spherical" and self.rng.random() < 0.5:
            table["armature"] = self.positive()
        if kind == "custom":
            u, w = f"{name}a", f"{name}b"
            two = self.rng.random() < 0.5
            table["steps"] = [["Rz", u], ["Tx", f"{w}*{u}" if two else f"0.3*{u}"], ["Ty", f"sin({u})"]]
            table["steps"] += [["Rx", w if two else f"0.5*{u}**2"]]
            table |= {"units": ["rad"] * (1 + two), "coordinates": [u, w][: 1 + two]}
        elif kind != "fixed" and "mimic" not in table:
            count = COORDINATES[kind] + (table.get("orientation") == "quaternion")
            table["coordinates"] = [f"{name}{letter}" for letter in LETTERS[:count]]
        self.tables["joints"][name] = table
        return name

    def steps(self) -> list[Any]:
        """Return a placement: shifts, and a turn or two."""
        shifts = [[kind, self.small()] for kind in ("Tx", "Ty", "Tz")]
        return shifts + [
            [self.rng.choice(["Rx", "Ry", "Rz"]), self.rng.choice(ANGLES)] for _ in range(self.rng.randint(0, 2))
        ]

    def shape(self, kind: str) -> dict[str, Any]:
        """Return what a type takes."""
        rng, table = self.rng, {}
        if kind not in STRAIGHT:
            table["axis"] = rng.choice(AXES)
        if kind == "universal":
            table["second_axis"] = rng.choice([a for a in AXES if np.any(np.cross(a, table["axis"]))])
        if kind == "helical":
            table["pitch"] = self.positive()
        if kind == "rod":
            table["length"] = self.positive(0.5, 1.5)
        if kind in TURNING:
            table["orientation"] = rng.choice(ORIENTATIONS)
        if rng.random() < 0.3:
            table["tip"] = [["Tx", self.small()], ["Rz", rng.choice(ANGLES)]]
        return table

    # The whole

    def text(self, locked: Mapping[str, float] = {}, turned: Sequence[str] = ()) -> str:
        """Return the scene in TOML, some joints locked, some declared from the child towards the ground."""
        told = self.told == "parameters"
        tables: dict[str, Any] = {"parameters": {k: {"value": x} if told else {} for k, x in self.values.items()}}
        joints = {
            name: (round_about(table) if name in turned else table)
            | ({"locked": True, "position": locked[name]} if name in locked else {})
            for name, table in self.tables["joints"].items()
        }
        return toml(WITHOUT_UNITS | {"gravity": self.gravity}, tables | self.tables | {"joints": joints}, self.loops)

    def mechanism(self) -> Mechanism:
        """Return what the reference computes with."""
        return Mechanism(read_text(self.text()), self.values)

    def first(self) -> Array:
        """Return the coordinates at the start, natural or random."""
        rng, q = self.rng, []
        for table in self.tables["joints"].values():
            names = table.get("coordinates", [])
            ball = table.get("orientation") == "quaternion"
            for _ in range(len(names) - 4 * ball):
                q.append(self.angle())
            if ball:
                e = {"zero": [1, 0, 0, 0], "equal": [0.8, 0, 0, 0.6], "right": [1, rng.choice([-1, 1]), 0, 0]}
                four = np.array(e.get(self.natural, [rng.uniform(-1, 1) for _ in range(4)]))
                q += list(four / np.linalg.norm(four))
        return np.array(q, float)

    def angle(self) -> float:
        """Return a coordinate at the start."""
        if not self.natural:
            return round(self.rng.uniform(-1, 1), 2)
        return {"zero": 0.0, "equal": 0.5, "right": self.rng.choice([0.0, math.pi / 2, -math.pi / 2])}[self.natural]

    def close(self, kind: str, parent: str, child: str, q: Array, **more: Any) -> None:
        """Add a loop that is closed at q."""
        table = {"name": f"loop{len(self.loops) + 1}", "type": kind, "parent": parent, "child": child}
        table |= {"origin": self.steps()} | self.shape(kind) | more
        table.pop("tip", None)
        self.loops.append(table)
        m = self.mechanism()
        joint, state = m.scene.loops[-1], m.at(q)
        X = motion(joint, Jet(self.within(kind, table.get("orientation", ""))), m.values)
        at = state.T[parent] @ pose(joint.origin, m.values) @ X
        tip = (inverse(at) @ state.T[child]).x
        roll, pitch, yaw = angles(tip[:3, :3])
        table["tip"] = {"xyz": [float(x) for x in tip[:3, 3]], "rpy": [roll, pitch, yaw]}

    def within(self, kind: str, orientation: str) -> Array:
        """Return coordinates that a joint closes at."""
        count = COORDINATES[kind] - 3 * (kind in TURNING)
        q = [0.0 if self.natural else self.rng.uniform(-1, 1) for _ in range(count)]
        if kind in TURNING and orientation == "quaternion":
            return np.array([*q, 1.0, 0.0, 0.0, 0.0])
        return np.array(q + [0.0] * 3 * (kind in TURNING))


def round_about(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same joint declared from its child to its parent: X⁻¹ is the motion about the opposite axis."""
    turned = dict(table) | {"parent": table["child"], "child": table["parent"]}
    turned["origin"], turned["tip"] = undone(table.get("tip", [])), undone(table.get("origin", []))
    if "axis" in table:
        turned["axis"] = [-x for x in table["axis"]]
    return turned


def undone(steps: list[Any]) -> list[Any]:
    """Return the steps that undo steps."""
    return [[kind, f"-({x})" if isinstance(x, str) else -x] for kind, x in reversed(steps)]


def angles(R: Array) -> tuple[float, float, float]:
    """Return roll, pitch, yaw of a rotation."""
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) < 1e-9:
        return math.atan2(-R[1, 2], R[1, 1]), pitch, 0.0
    return math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])


def toml(head: Mapping[str, Any], tables: Mapping[str, Any], loops: list[dict[str, Any]]) -> str:
    """Return TOML."""
    lines = [f"{key} = {told(x)}" for key, x in head.items()]
    for kind, entries in tables.items():
        for name, table in entries.items():
            lines += ["", f"[{kind}.{name}]", *(f"{key} = {told(x)}" for key, x in table.items())]
    for loop in loops:
        lines += ["", "[[loop]]", *(f"{key} = {told(x)}" for key, x in loop.items())]
    return "\n".join(lines) + "\n"


def told(x: Any) -> str:
    """Return a value in TOML."""
    if isinstance(x, bool):
        return str(x).lower()
    if isinstance(x, str):
        return f'"{x}"'
    if isinstance(x, dict):
        return "{ " + ", ".join(f"{key} = {told(one)}" for key, one in x.items()) + " }"
    if isinstance(x, list):
        return "[" + ", ".join(map(told, x)) + "]"
    return repr(x)
