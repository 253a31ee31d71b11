"""Joints that follow other joints: from the joint that `mimic` names to the coordinate at the end of the chain.

position of a joint = ratio · position of the joint that it follows + offset

Locked joints: declared to move, told to stand still. What comes out is a scene in which they are fixed.

    origin · motion(axis, position) · tip  =  (origin · step) · tip        step along or about a coordinate axis,
                                                                           between two turns if the axis is oblique

A joint that follows a locked one is locked at ratio · position + offset, one with several coordinates at zero. What
pulls along a locked joint goes. In formulas the coordinate has its position and the velocity is zero. The other
coordinates keep their names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError, suggestion
from symdyn.scene.declaration.dimensions import analysed
from symdyn.scene.declaration.draft import draft_of, uses
from symdyn.scene.joints.joint_table import JOINTS, resting
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose
from symdyn.scene.values.dimensional_analysis import fits, fits_place, with_unit
from symdyn.scene.values.entry import Entry, EntryReader, Faults, show
from symdyn.scene.values.formula import map_quantities, quantity, substituted
from symdyn.scene.values.joint import Coupling, Joint, Strut, acceleration_name, velocity_name
from symdyn.scene.values.key import Key, KeyGroup, keys_of, number, word
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.shape import FLAG, NUMBER, described
from symdyn.scene.values.unit import Unit, UnitError

ADVICE = 'write mimic = { joint = "leader", ratio = 1, offset = 0 }'

LEADER = word("joint", "", ADVICE.removeprefix("write "))

RATIO = Key("ratio", EntryReader.quantity, Quantity.ONE)

OFFSET = number("offset")

MIMIC: tuple[Key[str] | Key[Quantity], ...] = (LEADER, word("coordinate", ""), RATIO, OFFSET)
"""What `mimic` says."""


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


def read_mimic(table: EntryReader) -> Mimic | None:
    """Return what a joint declares to follow, None if it has a coordinate of its own."""
    if "mimic" not in table:
        return None
    inner = table.inner("mimic", keys_of(MIMIC), ADVICE)
    if "coordinate" in inner and "joint" in inner:
        inner.fault("joint and coordinate both name what it follows; write one of them")
    coordinate = inner.text("coordinate") if "coordinate" in inner else ""
    leader = "" if "coordinate" in inner else LEADER.declared(inner)
    if not (coordinate or leader):
        table.faults.nameless(table.entry.where, "mimic", "")
    return Mimic(leader, RATIO.declared(inner), OFFSET.declared(inner), coordinate)


def couple(joints: Sequence[Joint], mimics: Sequence[Mimic | None], tables: Sequence[EntryReader]) -> tuple[Joint, ...]:
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


def _leader(mimic: Mimic, joints: Sequence[Joint], index: Mapping[str, int], table: EntryReader) -> int | None:
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


def _followed(mimic: Mimic, joints: Sequence[Joint], table: EntryReader) -> str:
    """Return the coordinate that a mimic names, "" and a fault if it cannot be followed."""
    name = mimic.coordinate
    if not name:
        return ""
    leader = next((joint for joint in joints if name in joint.coordinates), None)
    if leader is None:
        known = [q for joint in joints for q in joint.coordinates]
        table.fault(f'mimic.coordinate = "{name}" is not a coordinate; {suggestion(name, known)}')
    elif leader.velocities and velocity_name(name) not in leader.velocities:
        table.fault(f'mimic.coordinate = "{name}" has a rate that is no velocity; follow an angle or a displacement')
    return name


def _check_units(mimic: Mimic, joint: Joint, joints: Sequence[Joint], table: EntryReader) -> None:
    """Report a ratio or an offset whose unit is not that of the joint, or of it for one of what it follows."""
    own = JOINTS[joint.type].coordinates(joint)[:1]
    leader = next((one for one in joints if one.name == mimic.leader or mimic.coordinate in one.coordinates), None)
    if leader is None or not own or "mimic" not in table:
        return
    units = JOINTS[leader.type].coordinates(leader)
    followed = dict(zip(leader.coordinates, units, strict=False)).get(mimic.coordinate, units[0] if units else "")
    inner = table.inner("mimic", keys_of(MIMIC), ADVICE)
    fits_place(inner, "ratio", mimic.ratio, ("1" if own[0] == followed else f"{own[0]}/{followed}",))
    fits_place(inner, "offset", mimic.offset, own)


def _chain(mimic: Mimic, behind: Coupling, table: EntryReader) -> Coupling:
    """Return ratio · (ratio' q + offset') + offset."""
    try:
        ratio = folding.mul(mimic.ratio, behind.ratio)
        offset = folding.add(folding.mul(mimic.ratio, behind.offset), mimic.offset)
    except FormulaError as error:
        table.fault(f"mimic: ratio and offset of the chain of joints that follow each other: {error}")
        return behind
    return Coupling(behind.coordinate, ratio, offset)


LOCKED = KeyGroup(  # read when the scene is known; what was locked is said as fixed
    {
        "locked": described("whether it stands still", FLAG),
        "position": described("where a locked joint stands, rad or m", NUMBER),
    },
    rules=[
        {"if": {"required": ["position"]}, "then": {"required": ["locked"], "properties": {"locked": {"const": True}}}}
    ],
)


def read_locks(joints: Sequence[Entry], faults: Faults) -> dict[str, Quantity]:
    """Return the position of every joint that is declared to be locked; rad or m."""
    positions: dict[str, Quantity] = {}
    for entry in joints:
        locked, raw = (entry.table.get(key) for key in LOCKED.keys)
        if locked is True:
            try:
                positions[entry.name] = quantity(raw if raw is not None else 0)
            except FormulaError as error:
                faults.add(entry.where, f"position {error}")
        elif locked not in (None, False):
            faults.add(entry.where, f"locked = {show(locked)} is neither true nor false")
        elif raw is not None:
            faults.add(entry.where, "position is where a locked joint stands; write locked = true, or leave it out")
    return positions


def lock(scene: Scene, positions: Mapping[str, Quantity | str | float], faults: Faults | None = None) -> Scene:
    """Return the scene with some joints fixed.

    Args:
        scene: checked, in order.
        positions: by name of the joint, rad or m: a number or a formula in parameters, such as "pi/2", or with a unit.
        faults: takes what is wrong and what was already found; a new list if None.

    Raises:
        SceneError: a position that is no constant or no formula, or nothing left that moves.
    """
    check_arguments(lock, locals(), SceneError)
    faults = faults or Faults(scene.source or scene.name)
    parameters = {parameter.name for parameter in scene.parameters}
    known: dict[str, Quantity] = {}
    for joint in (one for one in scene.moving if one.name in positions):
        where = f"joints.{joint.name}"
        try:
            position = quantity(positions[joint.name])
        except FormulaError as error:
            faults.add(where, f"position {error}")
            continue
        strangers = [name for name in position.symbols if name not in parameters]
        if strangers:
            faults.add(where, f"position uses {strangers[0]}, which is no parameter")
        try:
            fits(position, Unit.read(JOINTS[joint.type].coordinates(joint)[0]))
        except UnitError as error:
            faults.add(where, f'position = "{with_unit(position, position.unit)}" {error}')
        if len(joint.coordinates) > 1 and position != Quantity.ZERO:
            faults.add(where, f"has {len(joint.coordinates)} coordinates and is locked at zero only; turn its origin")
        at = (position,) if joint.coordinate else resting(joint)
        known |= dict(zip(joint.coordinates, at, strict=True)) | dict.fromkeys(joint.rates, Quantity.ZERO)
        known |= dict.fromkeys(map(acceleration_name, joint.rates), Quantity.ZERO)
    for name in sorted(positions.keys() - {joint.name for joint in scene.moving}):
        faults.add(f"joints.{name}", "only a joint with a coordinate of its own can be locked")
    try:
        joints = tuple(_settled(joint, known) for joint in scene.joints)
        still = {joint.name for joint in joints if joint.locked}
        locked = replace(
            scene,
            joints=joints,
            elements=tuple(one for one in scene.elements if not (isinstance(one, Strut) and one.joint in still)),
        )
        locked = map_quantities(locked, lambda one: substituted(one, known))
    except FormulaError as error:
        faults.add("", f"with locked joints a formula has no value: {error}")
    faults.close()
    for output in locked.outputs:
        symbols = output.formula.symbols
        gone = [name for name in symbols if name not in parameters and name not in locked.formula_names(symbols)]
        if gone:
            faults.add(f"outputs.{output.name}", f"uses {', '.join(gone)}, which a locked joint has no more")
    if not locked.coordinates:
        faults.add("", "nothing moves: every joint is locked; leave one free")
    faults.close()
    return _measured(locked, known, faults)


def _measured(locked: Scene, known: Mapping[str, Quantity], faults: Faults) -> Scene:
    """Return the scene without dimensions where a position of one, of 1 m, is a factor that is seen no more."""
    ones = [name for name, x in known.items() if x in (Quantity.ONE, Quantity.number(-1))]
    if not ones or locked.dimensionless or not analysed(locked, uses(draft_of(locked))).wrong:
        return locked
    faults.note("", f"{ones[0]} = {known[ones[0]].value} drops out of products, so that dimensions are not checked")
    return replace(locked, dimensionless=True)


def _settled(joint: Joint, known: Mapping[str, Quantity]) -> Joint:
    """Return the joint, fixed at its place if what moves it is known."""
    follows = joint.coupling
    leader = follows.coordinate if follows else next(iter(joint.coordinates), "")
    if leader not in known:
        return joint
    position = known[leader]
    if follows:
        position = folding.add(folding.mul(follows.ratio, position), follows.offset)
    return Joint(
        name=joint.name,
        type="fixed",
        parent=joint.parent,
        child=joint.child,
        origin=Pose((*joint.origin.steps, *JOINTS[joint.type].held(joint, position))),
        tip=joint.tip,
        locked=True,
    )
