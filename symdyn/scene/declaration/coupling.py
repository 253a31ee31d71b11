"""Joints that follow other joints: from the joints that `mimic` names to the coordinates at the ends of the chains.

position of a joint = Σ ratio · position of a joint that it follows + offset
ratio of wheels that mesh = ∓ radius of the one that is followed / own radius, + where one has its teeth inside

Locked joints: declared to move, told to stand still. What comes out is a scene in which they are fixed.

    origin · motion(axis, position) · tip  =  (origin · step) · tip        step along or about a coordinate axis,
                                                                           between two turns if the axis is oblique

A joint that follows a locked one is locked at ratio · position + offset, one with several coordinates at zero. What
pulls along a locked joint goes. In formulas the coordinate has its position and the velocity is zero. The other
coordinates keep their names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

from symdyn.arguments import checked
from symdyn.errors import SceneError, listed, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene.declaration.dimensions import analysed
from symdyn.scene.declaration.draft import draft_of, uses
from symdyn.scene.joints.joint_table import JOINTS, resting
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose
from symdyn.scene.values.dimensional_analysis import fits, fits_place
from symdyn.scene.values.entry import Entry, EntryReader, Faults, show, shown
from symdyn.scene.values.folding import map_quantities, substituted
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import Coupling, Joint, Place, Strut, acceleration_name, velocity_name
from symdyn.scene.values.key import Key, KeyGroup, coefficients, keys_of, number, one_of, raw_of, word
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.shape import FLAG, NUMBER, described, several
from symdyn.scene.values.unit import Unit, UnitError, with_unit

ADVICE = 'write mimic = { joint = "leader", ratio = 1, offset = 0 }'

LED = {"type": "object", "additionalProperties": NUMBER, "minProperties": 1}

SEVERAL = 'write mimic = { ratios = { left = "1/2", right = "1/2" } }'

LEADER = word("joint", "", ADVICE.removeprefix("write "))

RATIO = Key("ratio", EntryReader.quantity, Quantity.ONE)


def _ratios(table: EntryReader, key: str, usual: tuple[tuple[str, Quantity], ...]) -> tuple[tuple[str, Quantity], ...]:
    raw = table.raw[key]
    inner = table.inner(key, tuple(map(str, raw)) if isinstance(raw, Mapping) else (), SEVERAL)
    return tuple((name, inner.quantity(name)) for name in inner.raw)


RATIOS: Key[tuple[tuple[str, Quantity], ...]] = Key("ratios", _ratios, (), shape=LED)

OFFSET = number("offset")

WHEELS = 'write mimic = { joint = "motor", radii = ["r1", "r2"] }, of that wheel and its own, or both numbers of teeth'


def _radii(table: EntryReader, key: str, usual: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    radii = coefficients(table, key, usual)
    if len(radii) != 2:
        table.fault(f"{key} = {show(table.raw[key])} is no list of two; {WHEELS}")
    for radius in radii:
        if (value := radius.known_at({})) is not None and value <= 0:
            table.fault(f"{key}: {shown(radius)} is that of no wheel; give two above zero, and mesh for the direction")
            return usual
    return radii if len(radii) == 2 else usual


RADII = Key[tuple[Quantity, ...]]("radii", _radii, (Quantity.ONE, Quantity.ONE), shape=several(NUMBER, 2))

OUTSIDE, INSIDE = "external", "internal"

MESH = one_of("mesh", (OUTSIDE, INSIDE), "whether both turn in one direction, as a belt and a ring gear do", OUTSIDE)

MIMIC: tuple[Key[Any], ...] = (LEADER, word("coordinate", ""), RATIO, RADII, MESH, RATIOS, OFFSET)
"""What `mimic` says."""


@dataclass(frozen=True)
class Mimic:
    """What a joint declares to follow; a leader may itself follow other joints.

    Attributes:
        ratios: names of leaders, and the joint's position per unit of the position of each.
        offset: position = Σ ratio · (that of a leader) + offset.
        key: what the names were declared under: "joint", of a joint with one coordinate or none of its own;
            "coordinate", of a coordinate of a joint that has several; "ratios", of either.
        radii: of both wheels, that of the leader first, if both are wheels.
    """

    ratios: tuple[tuple[str, Quantity], ...]
    offset: Quantity = Quantity.ZERO
    key: str = "joint"
    radii: tuple[Quantity, ...] = ()


@dataclass(frozen=True)
class _Leader:
    """What a joint follows: a joint by its number, None where it is not known, and its coordinate or ""."""

    joint: int | None
    coordinate: str
    ratio: Quantity


def read_mimic(table: EntryReader) -> Mimic | None:
    """Return what a joint declares to follow, None if it has a coordinate of its own."""
    if "mimic" not in table:
        return None
    inner = table.inner("mimic", keys_of(MIMIC), ADVICE)
    if RATIOS.name in inner:
        if extra := [key for key in ("joint", "coordinate", "ratio", "radii", "mesh") if key in inner]:
            inner.fault(f"ratios names all that it follows; leave {listed(extra)} out")
        ratios = RATIOS.declared(inner)
        if not ratios:
            inner.fault(f"ratios names no joint; {SEVERAL}")
            return Mimic((("", Quantity.ONE),))
        if all(ratio.known_at({}) == 0 for _, ratio in ratios):
            instead = SEVERAL.removeprefix("write ")
            inner.fault(f'ratios are all zero, and the joint follows nothing; write type = "fixed", or {instead}')
        return Mimic(ratios, OFFSET.declared(inner), RATIOS.name)
    if "coordinate" in inner and "joint" in inner:
        inner.fault("joint and coordinate both name what it follows; write one of them")
    coordinate = inner.text("coordinate") if "coordinate" in inner else ""
    leader = "" if "coordinate" in inner else LEADER.declared(inner)
    if not (coordinate or leader):
        table.faults.nameless(table.entry.where, "mimic", "")
    key, meshes = "coordinate" if coordinate else "joint", RADII.name in inner
    if meshes and "ratio" in inner:
        inner.fault("radii and ratio both say how far it turns; write one of them")
    if MESH.name in inner and not meshes:
        inner.fault(f"mesh is that of two wheels; {WHEELS}")
    radii = RADII.declared(inner) if meshes else ()
    ratio = _of_wheels(inner, *radii) if meshes else RATIO.declared(inner)
    return Mimic(((coordinate or leader, ratio),), OFFSET.declared(inner), key, radii)


def _of_wheels(table: EntryReader, led: Quantity, own: Quantity) -> Quantity:
    for radius in (led, own):
        fits_place(table, RADII.name, radius, ("m", "1"))
    ratio = folding.div(led, own)
    return ratio if MESH.declared(table) == INSIDE else folding.neg(ratio)


def said_mimic(follows: Coupling | None, leaders: Mapping[str, str]) -> dict[str, object]:
    """Return what a joint's table says of what it follows; `leaders` are names of joints by their coordinate."""
    if follows is None:
        return {}
    offset = raw_of((OFFSET,), follows)
    if len(follows.ratios) > 1:
        return {"mimic": {RATIOS.name: {leaders.get(q, q): ratio for q, ratio in follows.ratios}} | offset}
    ((followed, ratio),) = follows.ratios
    name = leaders.get(followed)
    leader = {LEADER.name: name} if name else {"coordinate": followed}
    return {"mimic": leader | {RATIO.name: ratio} | offset}


def couple(joints: Sequence[Joint], mimics: Sequence[Mimic | None], tables: Sequence[EntryReader]) -> tuple[Joint, ...]:
    """Return the joints, those that follow others coupled to the coordinates at the ends of their chains.

    Args:
        joints: in any order.
        mimics: what each of them follows.
        tables: where each was declared; they take the faults.
    """
    leaders = [_leaders(m, joints, table) if m else [] for m, table in zip(mimics, tables, strict=True)]
    settled = {k: Coupling(((joints[k].coordinate, Quantity.ONE),)) for k, mimic in enumerate(mimics) if not mimic}
    for start in range(len(joints)):
        path = [] if start in settled else [start]
        while path:
            k = path[-1]
            ahead = next((one.joint for one in leaders[k] if one.joint not in (None, *settled)), None)
            if ahead in path:
                ring = path[path.index(ahead) :]
                names = [joints[i].name for i in (*ring[:10], ring[0])]
                tables[ring[0]].fault(f"mimic: the joint follows itself: {' -> '.join(names)}; give one a coordinate")
                leaders[k] = [_Leader(None, "", Quantity.ONE)]
            elif ahead is not None:
                path.append(ahead)
            else:
                mimic = mimics[path.pop()]
                assert mimic is not None, "a joint with a coordinate of its own is settled"
                _check_units(mimic, leaders[k], joints[k], joints, tables[k])
                settled[k] = _chain(mimic, leaders[k], settled, tables[k])
                if mimic.radii:
                    _check_wheels(mimic.ratios[0][0], leaders[k][0], joints[k], joints, tables[k])
                    settled[k] = replace(settled[k], wheels=_wheels(mimic, leaders[k][0], joints[k], joints))
    return tuple(
        joint if mimic is None else replace(joint, coupling=settled[k])
        for k, (joint, mimic) in enumerate(zip(joints, mimics, strict=True))
    )


def _leaders(mimic: Mimic, joints: Sequence[Joint], table: EntryReader) -> list[_Leader]:
    index = {joint.name: i for i, joint in reversed(list(enumerate(joints)))}
    found = []
    for name, ratio in mimic.ratios:
        said = f'mimic.{mimic.key} = "{name}"' if mimic.key != RATIOS.name else f"mimic.ratios.{name}"
        if mimic.key == RATIOS.name and any(name in one.coordinates for one in joints if one.name != name in index):
            table.fault(f"{said} is a joint, and a coordinate of another one; give one of them another name")
        if mimic.key == "joint" or (mimic.key == RATIOS.name and name in index):
            found.append(_Leader(_followed_joint(name, said, joints, index, table), "", ratio))
        else:
            found.append(_Leader(None, _followed_coordinate(name, said, mimic.key, joints, table), ratio))
    return found


def _followed_joint(
    name: str, said: str, joints: Sequence[Joint], index: Mapping[str, int], table: EntryReader
) -> int | None:
    if name not in index:
        if name:
            table.fault(f"{said} is not a joint; {suggestion(name, index)}")
        return None
    leader = joints[index[name]]
    if not JOINTS[leader.type].velocities(leader):
        table.fault(f"{said} is a {leader.type} joint; follow one that moves")
        return None
    if len(leader.coordinates) > 1:
        table.fault(f'{said} has several coordinates; write coordinate = "{leader.coordinates[0]}"')
        return None
    return index[name]


def _followed_coordinate(name: str, said: str, key: str, joints: Sequence[Joint], table: EntryReader) -> str:
    leader = next((joint for joint in joints if name in joint.coordinates), None)
    if name and leader is None:
        known = [q for joint in joints for q in joint.coordinates]
        known += [joint.name for joint in joints] if key == RATIOS.name else []
        what = "neither a joint nor a coordinate" if key == RATIOS.name else "not a coordinate"
        table.fault(f"{said} is {what}; {suggestion(name, known)}")
    elif leader is not None and leader.velocities and velocity_name(name) not in leader.velocities:
        table.fault(f"{said} has a rate that is no velocity; follow an angle or a displacement")
    return name


def _followed(one: _Leader, joints: Sequence[Joint]) -> Joint | None:
    if one.joint is not None:
        return joints[one.joint]
    return next((other for other in joints if one.coordinate in other.coordinates), None)


def _check_units(
    mimic: Mimic, leaders: Sequence[_Leader], joint: Joint, joints: Sequence[Joint], table: EntryReader
) -> None:
    """Report a ratio or an offset whose unit is not that of the joint, or of it for one of what it follows."""
    own = JOINTS[joint.type].coordinates(joint)[:1]
    if not own or "mimic" not in table:
        return
    inner = table.inner("mimic", keys_of(MIMIC), ADVICE)
    followed = tuple(name for name, _ in mimic.ratios)
    ratios = inner.inner(RATIOS.name, followed, SEVERAL) if mimic.key == RATIOS.name else inner
    known = False
    for (name, ratio), one in zip(mimic.ratios, leaders, strict=False):
        leader = _followed(one, joints)
        if leader is None:
            continue
        known, units = True, JOINTS[leader.type].coordinates(leader)
        theirs = dict(zip(leader.coordinates, units, strict=False)).get(one.coordinate, units[0] if units else "")
        key = name if mimic.key == RATIOS.name else RATIO.name
        unit = "1" if own[0] == theirs else f"{own[0]}/{theirs}"
        fits_place(ratios, key, ratio, (unit,))
        if unit != "1" and key not in ratios and not mimic.radii:
            inner.fault(f"ratio is missing, in {unit}, since {name} is in {theirs}; write one such as ratio = 2")
    if known:
        fits_place(inner, "offset", mimic.offset, own)


def _check_wheels(name: str, one: _Leader, joint: Joint, joints: Sequence[Joint], table: EntryReader) -> None:
    """Report radii of what does not turn, or of wheels on two bodies, whose ratio would leave out how these turn."""
    leader = _followed(one, joints)
    if leader is None:
        return
    for wheel in (leader, joint):
        if JOINTS[wheel.type].coordinates(wheel) != ("rad",):
            table.fault(
                f"mimic.radii are those of two wheels that turn, and {wheel.name} is a {wheel.type} joint; of a rack "
                f'write ratio = "r", of a screw ratio = "lead/(2*pi)"'
            )
            return
    if leader.parent != joint.parent:
        table.fault(
            f"mimic.radii: {name} turns on {leader.parent} and {joint.name} on {joint.parent}, so that a third angle "
            'counts; write ratios, as of a planet on a carrier ratios = { sun = "-rs/rp", carrier = "rs/rp" }'
        )


def _wheels(mimic: Mimic, one: _Leader, joint: Joint, joints: Sequence[Joint]) -> tuple[Place, ...]:
    """Return the wheels, about origins of their bodies, and which way they turn when the first turns left; or none."""
    leader, (led, own) = _followed(one, joints), mimic.radii
    turns = {folding.div(led, own): 1, folding.neg(folding.div(led, own)): -1}
    if leader is None or leader.tip.steps or joint.tip.steps or mimic.ratios[0][1] not in turns:
        return ()
    wheels = ((leader, led, 1), (joint, own, turns[mimic.ratios[0][1]]))
    return tuple(Place(x.child, radius=r, axis=x.axis, turn=turn) for x, r, turn in wheels)


def _chain(mimic: Mimic, leaders: Sequence[_Leader], settled: Mapping[int, Coupling], table: EntryReader) -> Coupling:
    """Return Σ ratio · (Σ ratio' q + offset') + offset."""
    ratios, offset = dict[str, Quantity](), mimic.offset
    try:
        for one in leaders:
            behind = Coupling(((one.coordinate, Quantity.ONE),)) if one.joint is None else settled[one.joint]
            offset = folding.add(folding.mul(one.ratio, behind.offset), offset)
            for name, ratio in behind.ratios:
                term = folding.mul(one.ratio, ratio)
                ratios[name] = folding.add(ratios[name], term) if name in ratios else term
    except FormulaError as error:
        table.fault(f"mimic: ratio and offset of the chain of joints that follow each other: {error}")
        ratios = dict.fromkeys(ratios, Quantity.ONE) or {"": Quantity.ONE}
    return Coupling(tuple(ratios.items()), offset)


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
            meant = "a place in space is its origin" if isinstance(raw, list | tuple) else "write locked = true"
            faults.add(entry.where, f"position is where a locked joint stands; {meant}, or motion where it moves")
    return positions


@checked(SceneError)
def lock(scene: Scene, positions: Mapping[str, Quantity | str | float], faults: Faults | None = None) -> Scene:
    """Return the scene with some joints fixed.

    Args:
        scene: checked, in order.
        positions: by name of the joint, rad or m: a number or a formula in parameters, such as "pi/2", or with a unit.
        faults: takes what is wrong and what was already found; a new list if None.

    Raises:
        SceneError: a position that is no constant or no formula, or nothing left that moves.
    """
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
    if follows:
        ratios = tuple((name, ratio) for name, ratio in follows.ratios if name not in known)
        locked = (folding.mul(ratio, known[name]) for name, ratio in follows.ratios if name in known)
        position = reduce(folding.add, locked, follows.offset)
        if ratios:
            return replace(joint, coupling=Coupling(ratios, position))
    elif not joint.coordinates or joint.coordinates[0] not in known:
        return joint
    else:
        position = known[joint.coordinates[0]]
    return Joint(
        name=joint.name,
        type="fixed",
        parent=joint.parent,
        child=joint.child,
        origin=Pose((*joint.origin.steps, *JOINTS[joint.type].held(joint, position))),
        tip=joint.tip,
        locked=True,
    )
