"""A base that floats: the joint that sets a robot free whose file says nothing of how it stands in the world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.scene.declaration.joint_table import freedoms
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import check_name
from symdyn.scene.values.table import Entry, Faults, show

WHERE = "floating base"

UNABLE: Mapping[str, str] = {
    "toml": 'a scene says it itself: a body for the base and [joints.NAME] with type = "free" and parent = "ground"',
    "par": "the file gives its base no mass; convert it to TOML, and add a body for the base and a free joint there",
}
"""Formats that have no base to set free, and what would work."""


def check_base(name: str, format: str, faults: Faults) -> None:
    """Report a name that no joint can have, and a format without a base to set free."""
    if fault := check_name(name):
        faults.add(WHERE, f"{show(name)} {fault}")
    if format in UNABLE:
        faults.add(WHERE, f"only robots in URDF and MJCF are set free; {UNABLE[format]}")


def free_base(name: str, root: str, joints: Sequence[Entry], faults: Faults, start: object = None) -> Entry:
    """Return the free joint `name` with a quaternion, without drives, that carries a root.

    Args:
        name: of the joint.
        root: body that it carries.
        joints: those of the file; none has this name, and none sets free what the root carries.
        faults: takes what is wrong.
        start: seven numbers where the base starts; the world's frame without them.
    """
    if any(joint.name == name for joint in joints):
        faults.add(WHERE, f"there is a joint {name} already; give the base another name, such as {name}_joint")
    for joint in joints:
        if freedoms(joint) == 6 and joint.table["parent"] == root:
            faults.add(WHERE, f"the joint {joint.name} sets the robot free already; leave the floating base out")
    table: dict[str, object] = {"type": "free", "parent": Scene.GROUND, "child": root, "drive": False}
    return Entry(name, table if start is None else table | {"start": start}, WHERE)
