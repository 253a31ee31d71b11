"""Joints in the order of another tool, and where what it lists of them stands here.

Libraries sort the branches of a robot each by a rule of its own: here joints stand as in the file, parents first;
Pinocchio goes through branches by name. Numbers that are handed over in the wrong order look plausible. So an order is
asked for by names, and gives places: entry k of the other is entry `q[k]`, or `v[k]`, of ours.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from symdyn.arguments import walked
from symdyn.errors import SceneError, quoted
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.names import listed, suggestion

QUATERNIONS = {"wxyz": (0, 1, 2, 3), "xyzw": (1, 2, 3, 0)}
"""Orders of the four coordinates of a quaternion by name, as places in ours."""


@dataclass(frozen=True)
class JointOrder:
    """Joints in the order of another tool; each attribute is in that order.

    `theirs = ours[..., order.q]` reads positions, and `ours[..., order.q] = theirs` writes them; velocities,
    accelerations and forces (one for each velocity) go by `order.v`, and a matrix by
    `M[numpy.ix_(order.v, order.v)]`.

    Attributes:
        joints: names of the joints that have coordinates.
        coordinates: names of their coordinates.
        velocities: names of their velocities.
        drives: names of their driving forces, one a velocity; None where it is passive.
        places: of the coordinates in q, and of the velocities in q̇, q̈ and tau; those of `q` and `v` as tuples.
    """

    joints: tuple[str, ...]
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    drives: tuple[str | None, ...]
    places: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def q(self) -> Any:
        """Places of the other's positions in ours, an array of whole numbers, shape (nq,)."""
        return _array(self.places[0])

    @property
    def v(self) -> Any:
        """Places of the other's velocities, accelerations and forces in ours, shape (nv,)."""
        return _array(self.places[1])


def _array(places: Sequence[int]) -> Any:
    import numpy as np

    return np.array(places, dtype=np.intp)


def order_of(joints: Sequence[Joint], names: Sequence[str], quaternion: str = "wxyz") -> JointOrder:
    """Return joints in another order.

    Args:
        joints: all of a scene, in its order.
        names: the joints as the other lists them, every one that has coordinates; fixed ones may be among them. A name
            that a robot file has and that was made printable here is known too, as "left-hip" for left_hip.
        quaternion: the order of the other's quaternions, a key of `QUATERNIONS`.

    Raises:
        SceneError: a name that no joint has or that stands twice, a joint that is missing, no such order.
    """
    if isinstance(names, str):
        raise SceneError(f"names = {quoted(names)}: give a list of names, such as [{quoted(names)}]")
    (names,) = walked(order_of, locals(), "names", error=SceneError)
    if quaternion not in QUATERNIONS:
        raise SceneError(f"quaternion = {quaternion!r} is not known; give {' or '.join(map(repr, QUATERNIONS))}")
    known = {joint.name: joint for joint in joints}
    spelled: dict[str, list[str]] = {}
    for name in known:
        spelled.setdefault(_plain(name), []).append(name)
    found: dict[str, Joint] = {}
    faults = []
    for given in names:
        near = spelled.get(_plain(given), ())
        name = given if given in known else near[0] if len(near) == 1 else ""
        if not name:
            faults.append(f"names: there is no joint {quoted(given)}; {suggestion(given, known)}")
        elif name in found:
            faults.append(f"names: {given!r} stands there twice; give every joint once")
        else:
            found[name] = known[name]
    moving = {joint.name for joint in joints if joint.coordinates}
    missing = [joint.name for joint in joints if joint.name in moving and joint.name not in found]
    if missing and not faults:
        faults.append(f"names: {listed(missing)} missing; give every joint that moves")
    if faults:
        raise SceneError(faults)
    first: dict[str, tuple[int, int]] = {}
    nq = nv = 0
    for joint in joints:
        first[joint.name] = nq, nv
        nq, nv = nq + len(joint.coordinates), nv + len(joint.rates)
    wanted = [joint for joint in found.values() if joint.coordinates]
    q = [(joint, k) for joint in wanted for k in _inside(joint, quaternion)]
    v = [(joint, k) for joint in wanted for k in range(len(joint.rates))]
    return JointOrder(
        joints=tuple(joint.name for joint in wanted),
        coordinates=tuple(joint.coordinates[k] for joint, k in q),
        velocities=tuple(joint.rates[k] for joint, k in v),
        drives=tuple(joint.drives[k] if joint.drives else None for joint, k in v),
        places=(
            tuple(first[joint.name][0] + k for joint, k in q),
            tuple(first[joint.name][1] + k for joint, k in v),
        ),
    )


def _plain(name: str) -> str:
    """Return a name without what no identifier has, to be compared."""
    return re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_").lower()


def _inside(joint: Joint, quaternion: str) -> list[int]:
    """Return the places of a joint's coordinates in the other order; its quaternion, if it has one, stands last."""
    places = list(range(len(joint.coordinates)))
    if len(places) == len(joint.rates):
        return places
    before = places[:-4]
    return [*before, *(len(before) + k for k in QUATERNIONS[quaternion])]
