"""Scenes as SDF text (SDFormat 1.11).

Every joint stands where it is at zero: its pose is `origin`, in its parent, and that of its child `tip`, in the joint.
Points are frames, springs at joints are springs of axes, a loop is a joint that must be cut, a passive joint has an
effort of zero, a free joint is none; gravity that is not the usual one is that of a world. What is left is `lost`.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul

from symdyn.errors import SceneError
from symdyn.frozen import dataclass, replace
from symdyn.scene.declaration.reading import Written, lost_words
from symdyn.scene.forces.applied_forces import Spring
from symdyn.scene.formats.inertias import possible
from symdyn.scene.formats.placing import Doubles, angle_text, decimal_text, placement, xyz_rpy
from symdyn.scene.formats.robot_file import INERTIA
from symdyn.scene.formats.urdf_writer import UrdfWriter, check_writable, element, lost_names, words_of
from symdyn.scene.joints.blocks import AXIS, ORIENTATION
from symdyn.scene.joints.compound_joints import PITCH, SECOND
from symdyn.scene.values.body import Body, Pose, Step, inverse_steps
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key
from symdyn.scene.values.model import STANDARD_GRAVITY, Scene
from symdyn.scene.values.quantity import Quantity, Vector


@dataclass(frozen=True)
class Kind:
    """How SDF has a joint."""

    word: str  # its type; "" where a link is free, and no joint
    ball: bool = False  # whether it turns about a point: it has no limits, and a loop holds no directions there
    hinge: bool = False  # whether a loop holds its axis alone


KINDS = {
    "revolute": Kind("revolute", hinge=True),
    "prismatic": Kind("prismatic"),
    "helical": Kind("screw"),
    "universal": Kind("universal"),
    "spherical": Kind("ball", ball=True),
    "fixed": Kind("fixed"),
    "free": Kind(""),
}

HEAD = '<?xml version="1.0"?>'

VERSION = ' version="1.11"'

CUT = "<physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics>"

LIMITS = ("lower", "upper", "velocity", "effort")

CLOSED = 1e-9
"""How far what closes a loop may be open, m and rad."""


def write_text(scene: Scene) -> Written:
    """Return the scene as SDF text, and what the format cannot hold.

    Raises:
        SceneError: a parameter has no value, a body has a first moment without a mass, SDF has no such joint, or a loop
            is open where all coordinates are zero.
    """
    check_writable(scene, "SDF", KINDS, scene.joints)
    check_writable(scene, "SDF, as what closes a loop,", [name for name, one in KINDS.items() if one.word], scene.loops)
    writer = SdfWriter(scene)
    writer.check()
    return Written(writer.text(), tuple(writer.lost()))


class SdfWriter(UrdfWriter):
    """One scene, with the values of its parameters and names of joints that no body has."""

    FORMAT = "SDF"

    def __init__(self, scene: Scene) -> None:
        """Give every joint a name of its own; one spring a joint is written."""
        super().__init__(scene)
        taken = [*self.frames, "world"]
        self.called = {one.name: self.new(taken, one.name) for one in (*scene.joints, *scene.loops)}
        self.leaders = {q: self.called[name] for q, name in self.leaders.items()}
        self.springs: dict[str, Spring] = {}
        for one in scene.elements:
            if isinstance(one, Spring) and one.joint and len(one.stiffness) == 1 and one.preload == Quantity.ZERO:
                self.springs.setdefault(one.joint, one)

    def lost(self) -> list[str]:
        """Return what the format cannot hold, one line each."""
        scene, held = self.scene, list(self.springs.values())
        lost = lost_names(scene)
        for joint in scene.joints:
            where, free = f"joints.{joint.name}", not KINDS[joint.type].word
            if (free or KINDS[joint.type].ball) and any(joint.drives):
                lost.append(f"{where}: drives: nothing drives a link that is free, nor a ball")
            if free and joint.name != f"{joint.child}_free":
                lost.append(f"{where}: a link that is free has no joint; read again it is called {joint.child}_free")
            if free and (joint.origin.steps or joint.tip.steps):
                lost.append(f"{where}: origin and tip: read again, coordinates count from the world to the link")
            if free and (joint.damping, joint.friction) != (Quantity.ZERO, Quantity.ZERO):
                lost.append(f"{where}: damping: a link that is free has none")
        lost += [f"{one}: is called {name} there" for one, name in self.called.items() if one != name]
        lost += [f"springs.{s.name}: is called {name} there" for name, s in self.springs.items() if s.name != name]
        lost += [f"points.{one.name}: a point of the ground" for one in scene.points if one.body == Scene.GROUND]
        plain = [replace(joint, start=()) if not KINDS[joint.type].word else joint for joint in scene.joints]
        elements = tuple(one for one in scene.elements if one not in held)
        return [*lost, *lost_words(replace(scene, joints=tuple(plain), loops=(), elements=elements))]

    def text(self) -> str:
        lines = []
        for joint, body in zip(self.scene.joints, self.scene.bodies, strict=True):
            lines += self.link(joint, body) + ([] if not KINDS[joint.type].word else self.joint(joint, body.name))
        for point in self.scene.points:
            if point.body != Scene.GROUND:
                attached = f' attached_to="{point.body}"'
                lines += element("frame", point.name, [self.pose(point.at)], attached)
        for loop in self.scene.loops:
            lines += self.joint(loop, loop.child, [CUT])
        model = element("model", self.scene.name, lines)
        gravity = [self.value(x) for x in self.scene.gravity]
        if gravity != [x.at({}) for x in STANDARD_GRAVITY]:
            model = element("world", "scene", [f"<gravity>{words_of(gravity)}</gravity>", *model])
        return "\n".join([HEAD, *element("sdf", "", model, VERSION)]) + "\n"

    def pose(self, pose: Pose, relative: str = "") -> str:
        xyz, rpy = xyz_rpy(pose, self.values)
        base = f' relative_to="{relative}"' if relative else ""
        return f"<pose{base}>{words_of(xyz)} {' '.join(map(angle_text, rpy))}</pose>"

    def link(self, joint: Joint, body: Body) -> list[str]:
        """Return the lines of a body, which a joint carries, or which starts somewhere in the world."""
        if KINDS[joint.type].word:
            return element("link", body.name, [self.pose(joint.tip, self.called[joint.name]), *self.inertial(body)])
        if joint.parent != Scene.GROUND:
            advice = "let it leave the ground, or write TOML"
            raise SceneError(
                f"{self.scene.name}: joints.{joint.name}: a link of SDF is free of the world alone; {advice}"
            )
        placed = Pose((*joint.origin.steps, *_started(joint), *joint.tip.steps))
        return element("link", body.name, [self.pose(placed), *self.inertial(body)])

    def inertial(self, body: Body) -> list[str]:
        """Return the lines of a body's mass and inertia, point masses included; zeros, where SDF has ones, too."""
        mass, com, inertia = self.combined(body)
        entries = [f"<{key}>{decimal_text(x)}</{key}>" for key, x in zip(INERTIA, possible(inertia), strict=True)]
        place = [f"<pose>{words_of(com)} 0 0 0</pose>"] if any(com) else []
        return element("inertial", "", [*place, f"<mass>{decimal_text(mass)}</mass>", *element("inertia", "", entries)])

    def joint(self, joint: Joint, child: str, more: Sequence[str] = ()) -> list[str]:
        kind, ground = KINDS[joint.type].word, joint.parent == Scene.GROUND
        parent = "world" if ground else joint.parent
        lines = [self.pose(joint.origin, "__model__" if ground else parent)]
        lines += [f"<parent>{parent}</parent>", f"<child>{child}</child>", *more]
        if kind == "screw":
            lines.append(f"<screw_thread_pitch>{decimal_text(self.value(PITCH.of(joint)))}</screw_thread_pitch>")
        if kind == "universal":
            lines += [line for k, key in enumerate((AXIS, SECOND)) for line in self.along(joint, key, k)]
        elif kind != "fixed":
            lines += self.along(joint, AXIS)
        if kind == "revolute" and joint.limits.lower is None and joint.limits.upper is None:
            kind = "continuous"
        return element("joint", self.called[joint.name], lines, f' type="{kind}"')

    def along(self, joint: Joint, key: Key[Vector], k: int = 0) -> list[str]:
        """Return the lines of an axis, the k-th of the joint: what limits, drives, resists and couples it there."""
        bounds = {} if len(joint.coordinates) > 1 else vars(joint.limits)
        limit = [
            f"<{name}>{decimal_text(self.value(bounds[name]))}</{name}>"
            for name in LIMITS
            if bounds.get(name) is not None
        ]
        if not KINDS[joint.type].ball and k < len(joint.drives) and joint.drives[k] is None:
            limit = [*(line for line in limit if not line.startswith("<effort>")), "<effort>0</effort>"]
        spring, dynamics = self.springs.get(joint.name), {"damping": joint.damping, "friction": joint.friction}
        if spring is not None:
            dynamics |= {"spring_stiffness": spring.stiffness[0], "spring_reference": spring.free}
        said = {name: decimal_text(self.value(x)) for name, x in dynamics.items() if x != Quantity.ZERO}
        if KINDS[joint.type].ball and not said:
            return []
        inside = [f"<xyz>{self.axis(joint, key)}</xyz>"]
        inside += element("limit", "", limit) if limit else []
        inside += element("dynamics", "", [f"<{name}>{text}</{name}>" for name, text in said.items()]) if said else []
        if joint.coupling is not None:
            leader, *numbers = self.follows(joint)
            said = dict(zip(("multiplier", "offset", "reference"), (*numbers, "0"), strict=True))
            lines = [f"<{name}>{text}</{name}>" for name, text in said.items()]
            inside += element("mimic", "", lines, f' joint="{leader}"')
        return element("axis2" if k else "axis", "", inside)

    def check(self) -> None:
        """Raise what closes no loop where all coordinates are zero, which is where SDF draws every body.

        Raises:
            SceneError: the loops that are open there; or a name that SDF keeps for the ground.
        """
        if "world" in self.frames:
            raise SceneError(f'{self.scene.name}: "world" is what SDF calls the ground; give the body another name')
        at: dict[str, tuple[Step, ...]] = {Scene.GROUND: ()}
        for joint in self.scene.joints:
            moved = _started(joint) if not KINDS[joint.type].word else ()
            at[joint.child] = (*at[joint.parent], *joint.origin.steps, *moved, *joint.tip.steps)
        faults = []
        for loop in self.scene.loops:
            back = (*loop.origin.inverse().steps, *inverse_steps(at[loop.parent]))
            p, R = placement(Pose((*back, *at[loop.child], *loop.tip.inverse().steps)), self.values)
            gap = [abs(float(x)) for x in p]
            if KINDS[loop.type].hinge:
                axis = [self.value(x) for x in loop.axis]
                gap += [abs(float(sum(map(mul, row, axis)) - x)) for row, x in zip(R, axis, strict=True)]
            elif not KINDS[loop.type].ball:
                gap += [abs(float(R[i][j]) - (i == j)) for i in range(3) for j in range(3)]
            if max(gap) > CLOSED:
                told = f"is open by {max(gap):.3g} where all coordinates are zero, and SDF draws it closed there"
                advice = "count coordinates from a place where it is closed, or write TOML"
                faults.append(f"{self.scene.name}: loops.{loop.name}: {told}; {advice}")
        if faults:
            raise SceneError(faults)


def _started(joint: Joint) -> tuple[Step, ...]:
    """Return what a free joint does where it starts."""
    if not joint.start:
        return ()
    kind, turn = ORIENTATION.of(joint), joint.start[3:]
    shift = zip(("Tx", "Ty", "Tz"), joint.start[:3], strict=True)
    if len(turn) == 3:
        return (*shift, *zip((f"R{letter}" for letter in kind), turn, strict=True))
    return (*shift, *Doubles(snap=True).rotation([float(x.at({}) or 0) for x in turn], joint.name))
