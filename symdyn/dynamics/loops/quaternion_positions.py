"""Positions with angles as positions with quaternions, and back: the same bodies at the same places.

e      (w, x, y, z) of three turns about moving axes, the product of theirs
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from symdyn.scene import Joint, Scene
from symdyn.scene.joints import ORIENTATION

Array = np.ndarray[Any, np.dtype[np.float64]]


def with_quaternions(scene: Scene, plain: Scene, q: Array) -> Array:
    """Return the position q of a scene as one of the same scene without angles, `plain`."""
    found: list[float] = []
    at = 0
    for joint, other in zip(scene.moving, plain.moving, strict=True):
        here = q[at : at + len(joint.coordinates)]
        at += len(here)
        turned = ORIENTATION.of(joint) != ORIENTATION.of(other)
        found += [*here[:-3], *_quaternion(ORIENTATION.of(joint), here[-3:])] if turned else [*here]
    return np.array(found, dtype=np.float64)


def with_angles(scene: Scene, plain: Scene, q: Array, near: Array) -> Array:
    """Return the position q of a scene without angles, `plain`, as one of the scene: of its angles those `near`."""
    found: list[float] = []
    at = 0
    for joint, other in zip(scene.moving, plain.moving, strict=True):
        here = q[at : at + len(other.coordinates)]
        at += len(here)
        if ORIENTATION.of(joint) == ORIENTATION.of(other):
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
    from scipy.spatial.transform import Rotation

    axes = ORIENTATION.of(joint)
    sequence: Any = axes.upper()  # about moving axes
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that they are singular is told elsewhere
        one = np.asarray(Rotation.from_quat([*e[1:], e[0]]).as_euler(sequence), dtype=np.float64)
    middle = -one[1] if axes[0] == axes[2] else np.pi - one[1]
    both = [one, np.array([one[0] + np.pi, middle, one[2] + np.pi])]
    both = [angles + 2 * np.pi * np.round((near - angles) / (2 * np.pi)) for angles in both]
    return min(both, key=lambda angles: float(np.abs(angles - near).max()))
