"""Joints and what acts: directions, signs and starts, and what their rows know to be wrong."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.scene.checks.draft import Draft, joint_numbers
from symdyn.scene.forces.force_table import FORCES
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.key import Key, Stand
from symdyn.scene.values.quantity import Value
from symdyn.scene.values.table import Faults, shown

NOT_NEGATIVE = ("armature", "damping", "friction", "limits.velocity", "limits.effort")


def check_joints(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the joints, one by one."""
    for section in ("joints", "loops"):
        for where, joint in zip(draft.where[section], getattr(draft.scene, section), strict=True):
            stand = Stand(where, draft.scene, values, faults)
            _shape(joint, stand)
            _signs(joint, stand)
            _start(joint, stand)
            if joint.motion is not None and not any(joint.drives):
                what = f"motion = {shown(joint.motion)} prescribes what no drive can hold"
                stand.fault(f"{what}: the joint is passive; leave out drive = false, or the motion")


def _shape(joint: Joint, stand: Stand) -> None:
    """Directions are directions, and what the keys of the type say fits together."""
    kind = JOINTS[joint.type]
    fine = [stand.direction(key.name, way) for key, way in kind.directions(joint)]
    if all(fine) and (amiss := kind.fault(joint)):
        stand.fault(amiss)
    for key in kind.keys:
        key.check(joint, stand)


def _signs(joint: Joint, stand: Stand) -> None:
    """What dissipates or stores energy is not negative, and limits leave room."""
    numbers = dict(joint_numbers(joint))
    known = {key: stand.value(quantity) for key, quantity in numbers.items()}
    for key in NOT_NEGATIVE:
        value = known.get(key)
        if value is not None and value < 0:
            stand.fault(f"{key} = {float(value):.6g} is negative; give zero or more")
    if joint.dry and (check := FORCES[joint.dry.kind].check):
        check(joint.dry, stand)
    lower, upper = known.get("limits.lower"), known.get("limits.upper")
    if lower is not None and upper is not None and lower > upper:
        texts = [f"{key} = {shown(numbers[key])}" for key in ("limits.lower", "limits.upper")]
        stand.fault(f"{texts[0]} is above {texts[1]}; swap them")


def _start(joint: Joint, stand: Stand) -> None:
    first = JOINTS[joint.type].quaternion(joint)
    if first is None or not joint.start:
        return
    if all(stand.value(x) == 0 for x in joint.start[first : first + 4]):
        shift = "" if len(joint.start) == 4 else f", entries {first + 1} to {first + 4},"
        stand.fault(f"start: the quaternion (w, x, y, z){shift} has zero length; give one such as 1, 0, 0, 0")


def check_elements(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the elements, one by one: places before numbers, and then what their kind knows."""
    for where, one in zip(draft.where["elements"], draft.scene.elements, strict=True):
        kind, stand = FORCES[one.kind], Stand(where, draft.scene, values, faults)
        for part in sorted(kind.parts, key=lambda part: isinstance(part, Key)):
            part.check(one, stand)
        if kind.check is not None:
            kind.check(one, stand)
