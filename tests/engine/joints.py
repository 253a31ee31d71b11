"""Joint types of the reference, each told twice: how it moves, for trees, and what it forbids, where it closes a loop.

    T, X         placements, homogeneous 4 x 4; X that of the moved joint frame in the joint frame
    F, N         a wrench that does no work: force and moment about the moved frame's origin, axes of the joint frame

Conventions are those of docs/scenes.md: quaternions (w, x, y, z), velocities of balls and of free flight in the moved
frame, the two ways of a plane along the x and y that the shortest rotation of z to its normal gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .jets import Jet, angle, apply, cross, jet, number, stack, value

EYE = np.eye(3)
AXES = dict(zip("xyz", EYE, strict=True))


def tilde(a: np.ndarray) -> np.ndarray:
    """Return the matrix of a ×."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def placed(R: Any = EYE, p: Any = (0, 0, 0)) -> Jet:
    """Return a placement."""
    R, p = jet(R), jet(p)
    parts = []
    for part, last in (("x", 1.0), ("v", 0.0), ("a", 0.0)):
        T = np.zeros((4, 4))
        T[:3, :3], T[:3, 3], T[3, 3] = getattr(R, part), getattr(p, part), last
        parts.append(T)
    return Jet(*parts)


def inverse(T: Jet) -> Jet:
    """Return the placement that undoes one."""
    R = T[:3, :3].T
    return placed(R, -(R @ T[:3, 3]))


def turn(axis: np.ndarray, q: Jet) -> Jet:
    """Return a turn about a unit axis."""
    along = np.outer(axis, axis)
    return placed(along + apply("COS", q) * (EYE - along) + apply("SIN", q) * tilde(axis))


def slide(axis: np.ndarray, q: Jet) -> Jet:
    """Return a slide along a unit axis."""
    return placed(EYE, q * axis)


def step(kind: str, q: Jet) -> Jet:
    """Return an elementary motion such as "Rx"."""
    return (turn if kind[0] == "R" else slide)(AXES[kind[1]], q)


def pose(declared: Any, known: Mapping[str, Any]) -> Jet:
    """Return a declared placement: the product of its steps."""
    T = placed()
    for kind, amount in declared.steps:
        T = T @ step(kind, value(amount, known))
    return T


def unit(axis: Any) -> np.ndarray:
    """Return a declared direction with length 1."""
    a = np.array([number(x, {}) for x in axis])
    return a / np.linalg.norm(a)


def across(axis: np.ndarray) -> np.ndarray:
    """Return the shortest rotation from z to a unit axis; its first two columns are directions across it."""
    if axis[2] < -1 + 1e-14:
        return np.diag([1.0, -1.0, -1.0])
    v = tilde(np.cross(EYE[2], axis))
    return EYE + v + v @ v / (1 + axis[2])


# How joints move


def rotation_of(e: Jet) -> Jet:
    """Return the rotation of a unit quaternion: r' = e (0, r) e*."""
    w, u = e[0], e[1:]
    u_tilde = stack([stack([jet(0.0), -u[2], u[1]]), stack([u[2], jet(0.0), -u[0]]), stack([-u[1], u[0], jet(0.0)])])
    return EYE + 2.0 * (w * u_tilde) + 2.0 * (u_tilde @ u_tilde)


def quaternion(q: np.ndarray, omega: np.ndarray, alpha: np.ndarray) -> Jet:
    """Return a quaternion that moves: ė = ½ e ∘ (0, ω), ω along the moved axes."""

    def half(e: np.ndarray, w: np.ndarray) -> np.ndarray:
        return 0.5 * np.array([-e[1:] @ w, *(e[0] * w + np.cross(e[1:], w))])

    rate = half(q, omega)
    return Jet(q, rate, half(rate, omega) + half(q, alpha))


def coordinates(joint: Any, q: np.ndarray, u: np.ndarray, du: np.ndarray) -> Jet:
    """Return the coordinates of a joint as they move at velocities u with rates du."""
    if len(q) == len(u):
        return Jet(q, u, du)
    if joint.type == "free":
        e = quaternion(q[3:], u[3:], du[3:])
        R, omega = rotation_of(e).x, u[3:]
        p = Jet(q[:3], R @ u[:3], R @ (du[:3] + np.cross(omega, u[:3])))
    else:
        e, k = quaternion(q[-4:], u[-3:], du[-3:]), len(q) - 4
        p = Jet(q[:k], u[:k], du[:k])
    return Jet(*(np.concatenate([getattr(p, part), getattr(e, part)]) for part in ("x", "v", "a")))


def said(joint: Any, key: str) -> Any:
    """Return what a key of a joint's type says."""
    return dict(joint.shape)[key]


def velocities_of(joint: Any) -> int:
    """Return how many velocities a joint of the tree has."""
    ball = joint.type in ("spherical", "point_on_line", "point_on_plane", "rod", "free")
    return len(joint.coordinates) - (ball and said(joint, "orientation") == "quaternion")


def ball(joint: Any, q: Jet) -> Jet:
    """Return a rotation in every direction: of a quaternion, or three turns about moving axes."""
    if said(joint, "orientation") == "quaternion":
        return placed(rotation_of(q))
    x, y, z = said(joint, "orientation")
    return turn(AXES[x], q[0]) @ turn(AXES[y], q[1]) @ turn(AXES[z], q[2])


Known = Mapping[str, Any]

MOTIONS: Mapping[str, Callable[[Any, Jet, np.ndarray, Known], Jet]] = {  # a joint, its q, its axis, values
    "revolute": lambda j, q, a, known: turn(a, q[0]),
    "prismatic": lambda j, q, a, known: slide(a, q[0]),
    "helical": lambda j, q, a, known: turn(a, q[0]) @ slide(a, q[0] * rise(j, known)),
    "cylindrical": lambda j, q, a, known: turn(a, q[0]) @ slide(a, q[1]),
    "universal": lambda j, q, a, known: turn(a, q[0]) @ turn(unit(said(j, "second_axis")), q[1]),
    "spherical": lambda j, q, a, known: ball(j, q),
    "planar": lambda j, q, a, known: in_plane(a, q) @ turn(a, q[2]),
    "point_on_line": lambda j, q, a, known: slide(a, q[0]) @ ball(j, q[1:]),
    "point_on_plane": lambda j, q, a, known: in_plane(a, q) @ ball(j, q[2:]),
    "rod": lambda j, q, a, known: (
        turn(EYE[0], q[0]) @ turn(EYE[1], q[1]) @ slide(EYE[2], value(said(j, "length"), known)) @ ball(j, q[2:])
    ),
    "free": lambda j, q, a, known: placed(EYE, q[:3]) @ ball(j, q[3:]),
    "custom": lambda j, q, a, known: pose(
        said(j, "steps"), {**known, **{name: q[k] for k, name in enumerate(j.coordinates)}}
    ),
    "fixed": lambda j, q, a, known: placed(),
}


def motion(joint: Any, q: Jet, known: Known) -> Jet:
    """Return X of a joint at its coordinates."""
    return MOTIONS[joint.type](joint, q, unit(joint.axis), known)


def in_plane(normal: np.ndarray, q: Jet) -> Jet:
    """Return two slides across a normal."""
    A = across(normal)
    return slide(A[:, 0], q[0]) @ slide(A[:, 1], q[1])


def rise(joint: Any, known: Known) -> float:
    """Return the advance of a screw per radian, m."""
    return number(said(joint, "pitch"), known) / (2 * math.pi)


# What joints forbid

Wrench = tuple[Jet, Jet]
NONE = Jet(np.zeros(3))


def forces(*along: Any) -> list[Wrench]:
    """Return unit forces."""
    return [(jet(x), NONE) for x in along]


def moments(*along: Any) -> list[Wrench]:
    """Return unit moments."""
    return [(NONE, jet(x)) for x in along]


def rod_force(j: Any, X: Jet, A: np.ndarray, known: Known) -> list[Wrench]:
    """Return the force along a rod, from one of its ends to the other."""
    p = X[:3, 3]
    return forces(p / apply("SQRT", p @ p))


def universal_moment(j: Any, X: Jet, A: np.ndarray, known: Known) -> list[Wrench]:
    """Return the moment across both axes of a cross, of which the second turns with the child."""
    return moments(cross(jet(unit(j.axis)), X[:3, :3] @ unit(said(j, "second_axis"))))


WRENCHES: Mapping[str, Callable[[Any, Jet, np.ndarray, Known], list[Wrench]]] = {  # columns of A: x, y across, axis
    "revolute": lambda j, X, A, known: forces(*EYE) + moments(A[:, 0], A[:, 1]),
    "prismatic": lambda j, X, A, known: forces(A[:, 0], A[:, 1]) + moments(*EYE),
    "helical": lambda j, X, A, known: (
        forces(A[:, 0], A[:, 1]) + moments(A[:, 0], A[:, 1]) + [(jet(A[:, 2]), jet(-rise(j, known) * A[:, 2]))]
    ),
    "cylindrical": lambda j, X, A, known: forces(A[:, 0], A[:, 1]) + moments(A[:, 0], A[:, 1]),
    "universal": lambda j, X, A, known: forces(*EYE) + universal_moment(j, X, A, known),
    "spherical": lambda j, X, A, known: forces(*EYE),
    "planar": lambda j, X, A, known: forces(A[:, 2]) + moments(A[:, 0], A[:, 1]),
    "point_on_line": lambda j, X, A, known: forces(A[:, 0], A[:, 1]),
    "point_on_plane": lambda j, X, A, known: forces(A[:, 2]),
    "rod": rod_force,
    "free": lambda j, X, A, known: [],
    "fixed": lambda j, X, A, known: forces(*EYE) + moments(*EYE),
}


def wrenches(joint: Any, X: Jet, known: Known) -> list[Wrench]:
    """Return what the parent of a joint can exert on the child without working."""
    return WRENCHES[joint.type](joint, X, across(unit(joint.axis)), known)


def lean(j: Any, X: Jet, A: np.ndarray) -> list[Jet]:
    """Return how far the axis leans: vanishes where the moved axis is the fixed one."""
    moved = X[:3, :3] @ A[:, 2]
    return [A[:, 0] @ moved, A[:, 1] @ moved]


def twisted(X: Jet) -> list[Jet]:
    """Return the skew part of R: vanishes without rotation (and at half turns, from which nobody starts)."""
    R = X[:3, :3]
    return [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]


def offset(X: Jet, *along: np.ndarray) -> list[Jet]:
    """Return components of the moved frame's origin."""
    return [a @ X[:3, 3] for a in along]


def universal_angle(j: Any, X: Jet) -> list[Jet]:
    """Return how far the angle of the two axes of a cross has changed."""
    first, second = unit(j.axis), unit(said(j, "second_axis"))
    return [first @ (X[:3, :3] @ second) - first @ second]


def screwed(j: Any, X: Jet, A: np.ndarray, known: Known) -> list[Jet]:
    """Return how far the way along a screw differs from what its angle gives."""
    moved = X[:3, :3] @ A[:, 0]
    return [A[:, 2] @ X[:3, 3] - rise(j, known) * angle(A[:, 1] @ moved, A[:, 0] @ moved)]


def stretched(j: Any, X: Jet, known: Known) -> list[Jet]:
    """Return how much longer a rod is than it may be."""
    p = X[:3, 3]
    return [apply("SQRT", p @ p) - value(said(j, "length"), known)]


RESIDUALS: Mapping[str, Callable[[Any, Jet, np.ndarray, Known], list[Jet]]] = {
    "revolute": lambda j, X, A, known: offset(X, *EYE) + lean(j, X, A),
    "prismatic": lambda j, X, A, known: offset(X, A[:, 0], A[:, 1]) + twisted(X),
    "helical": lambda j, X, A, known: offset(X, A[:, 0], A[:, 1]) + lean(j, X, A) + screwed(j, X, A, known),
    "cylindrical": lambda j, X, A, known: offset(X, A[:, 0], A[:, 1]) + lean(j, X, A),
    "universal": lambda j, X, A, known: offset(X, *EYE) + universal_angle(j, X),
    "spherical": lambda j, X, A, known: offset(X, *EYE),
    "planar": lambda j, X, A, known: offset(X, A[:, 2]) + lean(j, X, A),
    "point_on_line": lambda j, X, A, known: offset(X, A[:, 0], A[:, 1]),
    "point_on_plane": lambda j, X, A, known: offset(X, A[:, 2]),
    "rod": lambda j, X, A, known: stretched(j, X, known),
    "free": lambda j, X, A, known: [],
    "fixed": lambda j, X, A, known: offset(X, *EYE) + twisted(X),
}


def residual(joint: Any, X: Jet, known: Known) -> list[Jet]:
    """Return what vanishes where X is a placement that a joint allows."""
    return RESIDUALS[joint.type](joint, X, across(unit(joint.axis)), known)
