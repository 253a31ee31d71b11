"""Directions, signs and starts of joints."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.scene.checks.draft import Draft, joint_numbers
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.start import quaternion
from symdyn.scene.values.direction import direction
from symdyn.scene.values.folding import FormulaError
from symdyn.scene.values.model import Joint
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.table import Faults, shown
from symdyn.scene.values.value import Value, value_of

NOT_NEGATIVE = (
    *("armature", "damping", "friction", "limits.velocity", "limits.effort"),
    *("friction.coulomb", "friction.static", "friction.smoothing"),
)


def check_joints(draft: Draft, values: Mapping[str, Value], faults: Faults) -> None:
    """Report what is wrong with the joints, one by one."""
    for kind in ("joints", "loops"):
        for where, joint in zip(draft.where[kind], getattr(draft.scene, kind), strict=True):
            _shape(where, joint, values, faults)
            _signs(where, joint, values, faults)
            _start(where, joint, values, faults)
            _driven(where, joint, faults)


def _shape(where: str, joint: Joint, values: Mapping[str, Value], faults: Faults) -> None:
    """Directions are directions, and what the keys of the type say fits together."""
    kind = JOINTS[joint.type]
    fine = [direction(where, key.name, way, faults) for key, way in kind.directions(joint)]
    if all(fine) and (amiss := kind.amiss(joint)):
        faults.add(where, amiss)
    for key, one in kind.values(joint):
        if key.above_zero and (value := _value(one, values)) is not None and value <= 0:
            faults.add(where, f"{key.name} = {shown(one)} {key.above_zero}")


def _signs(where: str, joint: Joint, values: Mapping[str, Value], faults: Faults) -> None:
    """What dissipates or stores energy is not negative, and limits leave room."""
    numbers = dict(joint_numbers(joint))
    known = {key: _value(quantity, values) for key, quantity in numbers.items()}
    for key in NOT_NEGATIVE:
        value = known.get(key)
        if value is not None and value < 0:
            faults.add(where, f"{key} = {float(value):.6g} is negative; give zero or more")
    if joint.dry and (value := known.get("friction.stribeck")) is not None and value <= 0:
        faults.add(where, f"friction.stribeck = {float(value):.6g} is no rate; give one above zero")
    lower, upper = known.get("limits.lower"), known.get("limits.upper")
    if lower is not None and upper is not None and lower > upper:
        texts = [f"{key} = {shown(numbers[key])}" for key in ("limits.lower", "limits.upper")]
        faults.add(where, f"{texts[0]} is above {texts[1]}; swap them")


def _start(where: str, joint: Joint, values: Mapping[str, Value], faults: Faults) -> None:
    first = quaternion(joint)
    if first is None or not joint.start:
        return
    four = [_value(x, values) for x in joint.start[first : first + 4]]
    if all(x == 0 for x in four):
        shift = "" if len(joint.start) == 4 else f", entries {first + 1} to {first + 4},"
        faults.add(where, f"start: the quaternion (w, x, y, z){shift} has zero length; give one such as 1, 0, 0, 0")


def _driven(where: str, joint: Joint, faults: Faults) -> None:
    if joint.motion is not None and not any(joint.drives):
        what = f"motion = {shown(joint.motion)} prescribes what no drive can hold"
        faults.add(where, f"{what}: the joint is passive; leave out drive = false, or the motion")


def _value(quantity: Quantity, values: Mapping[str, Value]) -> Value | None:
    try:
        return value_of(quantity, values)
    except FormulaError:
        return None  # reported as a formula without a value
