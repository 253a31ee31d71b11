"""Orientations by angles: where they are singular, and the same mechanism without them.

Three turns about moving axes span all angular velocities but where the middle one makes the outer axes parallel:

    zxz and the like     sin of the middle angle vanishes
    zyx and the like     its cosine vanishes
    the rod's x, y       cosine of the second: the rod lies along the first axis

There rates of angles say less than angular velocities do, so that ranks and masses written in them are untrue: it is
the description that is singular, not the mechanism. A quaternion, with angular velocities, is singular nowhere.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from symdyn.graph import Expr, Graph
from symdyn.scene import JOINTS, Joint, Scene

ROD = "xy"


@dataclass(frozen=True)
class Angles:
    """Angles of one joint.

    Attributes:
        joint: whose they are.
        names: of the coordinates, in the order of the turns.
        first: place of the first of them in q.
        axes: of the turns, such as "zxz".
    """

    joint: Joint
    names: tuple[str, ...]
    first: int
    axes: str

    @property
    def middle(self) -> int:
        """Place in q of the angle that decides."""
        return self.first + 1

    def clearance(self, graph: Graph) -> Expr:
        """Return what vanishes where the angles are singular, and changes its sign there: the volume of the axes."""
        angle = graph.symbol(self.names[1])
        return graph.sin(angle) if len(self.axes) == 3 and self.axes[0] == self.axes[2] else graph.cos(angle)

    def singular(self, value: float, held: bool = False) -> str:
        """Return what is said where they are singular: at a start, or wherever loops hold the joint."""
        at = round(value, 9) + 0.0  # no rounding errors, no -0
        where = f"joint {self.joint.name}: {self.names[1]} = {at:.6g}{', where the loops hold it' if held else ''}"
        return f"{where}: {self._parallel}; {self._remedy}{'' if held else ', or give another start'}"

    @property
    def became_singular(self) -> str:
        """What is said where a motion ends because they are singular."""
        return f"joint {self.joint.name}: the motion came to where {self._parallel}; {self._remedy}"

    @property
    def _parallel(self) -> str:
        others = [name for name in self.names if name != self.names[1]]
        if self.axes == ROD:
            return f"the rod lies along the axis of {others[0]}, so that its angles are singular"
        return f"the axes of {others[0]} and {others[1]} are parallel, so that the angles are singular"

    @property
    def _remedy(self) -> str:
        if self.axes == ROD:
            return "turn its joint frame by origin"
        another = "zyx" if self.axes[0] == self.axes[2] else "zxz"
        return f'describe it by orientation = "quaternion", or by another sequence such as "{another}"'


def angles_of(scene: Scene) -> Iterator[Angles]:
    """Yield the angles of a scene that are singular somewhere."""
    at = 0
    for joint in scene.moving:
        if joint.type == "rod":
            yield Angles(joint, joint.coordinates[:2], at, ROD)
        if "orientation" in JOINTS[joint.type].keys and joint.orientation != "quaternion":
            count = len(joint.coordinates)
            yield Angles(joint, joint.coordinates[count - 3 :], at + count - 3, joint.orientation)
        at += len(joint.coordinates)


def without_angles(scene: Scene) -> Scene:
    """Return the scene with a quaternion in place of every three angles, for what only depends on its kinematics.

    Velocities keep their places and names, and mean angular velocities then (and velocities in the moved frame of a
    free joint). A joint whose angles stand in a formula of a row keeps them. The same scene if there is nothing to do.
    """
    spoken = {name for row in scene.rows for name in row.formula.symbols}
    spoken |= {joint.coupling.coordinate for joint in scene.joints if joint.coupling}
    joints = tuple(
        _turning(joint) if _has_angles(joint) and not spoken & {*joint.coordinates, *joint.rates} else joint
        for joint in scene.joints
    )
    if joints == scene.joints:
        return scene
    return replace(scene, joints=joints, springs=(), dampers=(), loads=())


def _has_angles(joint: Joint) -> bool:
    return bool(joint.coordinates) and "orientation" in JOINTS[joint.type].keys and joint.orientation != "quaternion"


def _turning(joint: Joint) -> Joint:
    fresh = tuple(f"{joint.name}.{letter}" for letter in "wxyz")  # no name of a scene holds a dot
    return replace(
        joint,
        orientation="quaternion",
        coordinates=(*joint.coordinates[:-3], *fresh),
        velocities=joint.rates,
        forces=(),
        start=(),
        start_rates=(),
    )
