"""Orientations by angles: where they are singular, and the same mechanism, and its positions, without them.

Three turns about moving axes span all angular velocities but where the middle one makes the outer axes parallel:

    zxz and the like     sin of the middle angle vanishes
    zyx and the like     its cosine vanishes
    the rod's x, y       cosine of the second: the rod lies along the first axis

There rates of angles say less than angular velocities do, so that ranks and masses written in them are untrue: it is
the description that is singular, not the mechanism. A quaternion, with angular velocities, is singular nowhere.

That of three turns about moving axes is the product e = (w, x, y, z) of theirs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import JOINTS, Gimbal
from symdyn.scene.values import Joint


@dataclass(frozen=True)
class Angles:
    """Angles of one joint: coordinates in the order of the turns, the place of the first in q, and their axes."""

    joint: Joint
    names: tuple[str, ...]
    first: int
    gimbal: Gimbal

    @property
    def middle(self) -> int:
        """Place in q of the angle that decides."""
        return self.first + 1

    def clearance(self, graph: Graph) -> Expr:
        """Return what vanishes where the angles are singular, and changes its sign there: the volume of the axes."""
        angle = graph.symbol(self.names[1])
        axes = self.gimbal.axes
        return graph.sin(angle) if len(axes) == 3 and axes[0] == axes[2] else graph.cos(angle)

    def singular(self, value: float, everywhere: bool = False) -> str:
        """Return what is said where they are singular: at a start, or wherever loops hold the joint."""
        at = round(value, 9) + 0.0  # no rounding errors, no -0
        where = f"joint {self.joint.name}: {self.names[1]} = {at:.6g}{', where the loops hold it' * everywhere}"
        return f"{where}: {self._parallel}; {self.gimbal.remedy}{'' if everywhere else ', or give another start'}"

    @property
    def became_singular(self) -> str:
        """What is said where a motion ends because they are singular."""
        return f"joint {self.joint.name}: the motion came to where {self._parallel}; {self.gimbal.remedy}"

    @property
    def _parallel(self) -> str:
        return self.gimbal.parallel.format(self.names[0], self.names[-1])


def angles_of(scene: Scene) -> Iterator[Angles]:
    """Yield the angles of a scene that are singular somewhere."""
    at = 0
    for joint in scene.moving:
        for one in JOINTS[joint.type].gimbals(joint):
            names = joint.coordinates[one.first : one.first + len(one.axes)]
            yield Angles(joint, names, at + one.first, one)
        at += len(joint.coordinates)


def without_angles(scene: Scene) -> Scene:
    """Return the scene with a quaternion in place of every three angles, for what only depends on its kinematics.

    Velocities keep their places and names, and mean angular velocities then (and velocities in the moved frame of a
    free joint). A joint whose angles stand in a formula of a row keeps them. The same scene if there is nothing to do.
    """
    spoken = {name for quantity in Quantity.inside(scene.constraints) for name in quantity.symbols}
    spoken |= scene.followed
    joints = tuple(
        _turning(joint)
        if joint.coordinates and _turns(joint) and not spoken & {*joint.coordinates, *joint.rates}
        else joint
        for joint in scene.joints
    )
    if joints == scene.joints:
        return scene
    return replace(scene, joints=joints, elements=scene.constraints)


def _turns(joint: Joint) -> str:
    """Return the axes of the three turns that describe a rotation, such as "zyx"; "" where none do."""
    return next((one.axes for one in JOINTS[joint.type].gimbals(joint) if len(one.axes) == 3), "")


def _turning(joint: Joint) -> Joint:
    fresh = tuple(f"{joint.name}.{letter}" for letter in "wxyz")  # no name of a scene holds a dot
    return replace(
        joint.shaped(orientation="quaternion"),
        coordinates=(*joint.coordinates[:-3], *fresh),
        velocities=joint.rates,
        forces=(),
        start=(),
        start_rates=(),
    )


Array = np.ndarray[Any, np.dtype[np.float64]]


def with_quaternions(scene: Scene, plain: Scene, q: Array) -> Array:
    """Return the position q of a scene as one of the same scene without angles, `plain`."""
    found: list[float] = []
    at = 0
    for joint, other in zip(scene.moving, plain.moving, strict=True):
        here = q[at : at + len(joint.coordinates)]
        at += len(here)
        turned = _turns(joint) != _turns(other)
        found += [*here[:-3], *_quaternion(_turns(joint), here[-3:])] if turned else [*here]
    return np.array(found, dtype=np.float64)


def with_angles(scene: Scene, plain: Scene, q: Array, near: Array) -> Array:
    """Return the position q of a scene without angles, `plain`, as one of the scene: of its angles those `near`."""
    found: list[float] = []
    at = 0
    for joint, other in zip(scene.moving, plain.moving, strict=True):
        here = q[at : at + len(other.coordinates)]
        at += len(here)
        if _turns(joint) == _turns(other):
            found += [*here]
        else:
            first = len(found) + len(joint.coordinates) - 3
            found += [*here[:-4], *_angles(joint, here[-4:], near[first : first + 3])]
    return np.array(found, dtype=np.float64)


def _quaternion(axes: str, angles: Array) -> Array:
    e = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in zip(axes, angles.tolist(), strict=True):
        turn = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * (axis == one) for one in "xyz")])
        v = e[0] * turn[1:] + turn[0] * e[1:] + np.cross(e[1:], turn[1:])
        e = np.array([e[0] * turn[0] - e[1:] @ turn[1:], *v])
    return e


def _angles(joint: Joint, e: Array, near: Array) -> Array:
    """Return the nearest of the angles of a rotation: they come in two kinds, each modulo a turn."""
    axes = _turns(joint)
    one = np.array(three_angles(axes, *e.tolist()), dtype=np.float64)
    middle = -one[1] if axes[0] == axes[2] else np.pi - one[1]
    both = [one, np.array([one[0] + np.pi, middle, one[2] + np.pi])]
    both = [angles + 2 * np.pi * np.round((near - angles) / (2 * np.pi)) for angles in both]
    return min(both, key=lambda angles: float(np.abs(angles - near).max()))


def three_angles(axes: str, w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return angles about moving axes of a rotation by its quaternion; where they are singular, the last is 0.

    Reference: Bernardes and Viollet, Quaternion to Euler angles conversion, PLOS ONE (2022), algorithm 1, which takes
    the axes backwards.
    """
    k, j, i = ("xyz".index(axis) for axis in axes)
    same, part = i == k, (x, y, z)
    k = 3 - i - j if same else k
    sign = (i - j) * (j - k) * (k - i) // 2
    a, b, c, d = w, part[i], part[j], part[k] * sign
    if not same:
        a, b, c, d = a - c, b + d, c + a, d - b
    middle = 2 * math.atan2(math.hypot(c, d), math.hypot(a, b))
    half_sum, half_difference = math.atan2(b, a), math.atan2(d, c)
    if middle < SINGULAR:
        first, last = 2 * half_sum, 0.0
    elif middle > math.pi - SINGULAR:
        first, last = 2 * half_difference, 0.0
    else:
        last, first = half_sum - half_difference, half_sum + half_difference
    return (first, middle, last) if same else (sign * first, middle - math.pi / 2, last)


SINGULAR = 1e-7
"""rad between two axes below which two of three angles turn about one axis."""
