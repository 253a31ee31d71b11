"""Joints that follow other joints: from the joint that `mimic` names to the coordinate at the end of the chain.

position of a joint = ratio · position of the joint that it follows + offset
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.values import folding
from symdyn.scene.values.joint import Coupling, Joint, velocity_name
from symdyn.scene.values.names import suggestion
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.table import Table
from symdyn.scene.values.with_unit import fits_place

MIMIC_KEYS = ("joint", "coordinate", "ratio", "offset")

ADVICE = 'write mimic = { joint = "leader", ratio = 1, offset = 0 }'


@dataclass(frozen=True)
class Mimic:
    """What a joint declares to follow; the leader may itself follow another joint.

    Attributes:
        leader: name of a joint with one coordinate or none of its own; "" where `coordinate` names what it follows.
        ratio, offset: position = ratio · (that of the leader) + offset.
        coordinate: name of a coordinate of a joint that has several.
    """

    leader: str
    ratio: Quantity = Quantity.ONE
    offset: Quantity = Quantity.ZERO
    coordinate: str = ""


def read_mimic(table: Table) -> Mimic | None:
    """Return what a joint declares to follow, None if it has a coordinate of its own."""
    if "mimic" not in table:
        return None
    inner = table.inner("mimic", MIMIC_KEYS, ADVICE)
    if "coordinate" in inner and "joint" in inner:
        inner.fault("joint and coordinate say the same thing twice; give one of them")
    coordinate = inner.text("coordinate") if "coordinate" in inner else ""
    leader = "" if "coordinate" in inner else inner.required("joint", ADVICE)
    if not (coordinate or leader):
        table.faults.nameless(table.entry.where, "mimic", "")
    return Mimic(leader, inner.quantity("ratio", Quantity.ONE), inner.quantity("offset"), coordinate)


def couple(joints: Sequence[Joint], mimics: Sequence[Mimic | None], tables: Sequence[Table]) -> tuple[Joint, ...]:
    """Return the joints, those that follow another one coupled to the coordinate at the end of their chain.

    Args:
        joints: in any order.
        mimics: what each of them follows.
        tables: where each was declared; they take the faults.
    """
    index = {joint.name: i for i, joint in reversed(list(enumerate(joints)))}
    leaders = [_leader(m, joints, index, table) if m else None for m, table in zip(mimics, tables, strict=True)]
    settled = {i: Coupling(joint.coordinate) for i, (joint, m) in enumerate(zip(joints, mimics, strict=True)) if not m}
    for start in range(len(joints)):
        path: dict[int, Mimic] = {}
        step: int | None = start
        while step is not None and step not in settled and step not in path:
            mimic = mimics[step]
            assert mimic is not None, "a joint with a coordinate of its own is settled"
            path[step] = mimic
            step = leaders[step]
        if step in path:
            ring = list(path)[list(path).index(step) :]
            names = [joints[k].name for k in (*ring[:10], ring[0])]
            tables[ring[0]].fault(f"mimic: the joint follows itself: {' -> '.join(names)}; give one a coordinate")
        for k in reversed(path):
            leader = leaders[k]
            behind = None if leader is None else settled.get(leader)
            _check_units(path[k], joints[k], joints, tables[k])
            settled[k] = _chain(path[k], behind or Coupling(_followed(path[k], joints, tables[k])), tables[k])
    return tuple(
        joint if mimic is None else replace(joint, coupling=settled[i])
        for i, (joint, mimic) in enumerate(zip(joints, mimics, strict=True))
    )


def _leader(mimic: Mimic, joints: Sequence[Joint], index: Mapping[str, int], table: Table) -> int | None:
    """Return the index of the joint that a joint follows; None, and a fault, if it cannot be followed."""
    name = mimic.leader
    if name not in index:
        if name:
            table.fault(f'mimic.joint = "{name}" is not a joint; {suggestion(name, index)}')
        return None
    leader = joints[index[name]]
    if not JOINTS[leader.type].velocities(leader):
        table.fault(f'mimic.joint = "{name}" is a {leader.type} joint; follow one that moves')
        return None
    if len(leader.coordinates) > 1:
        table.fault(f'mimic.joint = "{name}" has several coordinates; write coordinate = "{leader.coordinates[0]}"')
        return None
    return index[name]


def _followed(mimic: Mimic, joints: Sequence[Joint], table: Table) -> str:
    """Return the coordinate that a mimic names, "" and a fault if it cannot be followed."""
    name = mimic.coordinate
    if not name:
        return ""
    leader = next((joint for joint in joints if name in joint.coordinates), None)
    if leader is None:
        known = [q for joint in joints for q in joint.coordinates]
        table.fault(f'mimic.coordinate = "{name}" is not a coordinate; {suggestion(name, known)}')
    elif leader.velocities and velocity_name(name) not in leader.velocities:
        table.fault(f'mimic.coordinate = "{name}" has a rate that is no velocity; follow an angle or a way')
    return name


def _check_units(mimic: Mimic, joint: Joint, joints: Sequence[Joint], table: Table) -> None:
    """Report a ratio or an offset whose unit is not that of the joint, or of it for one of what it follows."""
    own = JOINTS[joint.type].coordinates(joint)[:1]
    leader = next((one for one in joints if one.name == mimic.leader or mimic.coordinate in one.coordinates), None)
    if leader is None or not own or "mimic" not in table:
        return
    units = JOINTS[leader.type].coordinates(leader)
    followed = dict(zip(leader.coordinates, units, strict=False)).get(mimic.coordinate, units[0] if units else "")
    inner = table.inner("mimic", MIMIC_KEYS, ADVICE)
    fits_place(inner, "ratio", mimic.ratio, ("1" if own[0] == followed else f"{own[0]}/{followed}",))
    fits_place(inner, "offset", mimic.offset, own)


def _chain(mimic: Mimic, behind: Coupling, table: Table) -> Coupling:
    """Return ratio · (ratio' q + offset') + offset."""
    try:
        ratio = folding.mul(mimic.ratio, behind.ratio)
        offset = folding.add(folding.mul(mimic.ratio, behind.offset), mimic.offset)
    except FormulaError as error:
        table.fault(f"mimic: ratio and offset of the chain of joints that follow each other: {error}")
        return behind
    return Coupling(behind.coordinate, ratio, offset)
