"""Locked joints: declared to move, told to stand still. What comes out is a scene in which they are fixed.

    origin · motion(axis, position) · tip  =  (origin · step) · tip        step along or about a coordinate axis,
                                                                           between two turns if the axis is oblique

A joint that follows a locked one is locked at ratio · position + offset, one with several coordinates at zero. What
pulls along a locked joint goes. In formulas the coordinate has its position and the velocity is zero. The other
coordinates keep their names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symdyn.arguments import check_arguments
from symdyn.errors import SceneError
from symdyn.scene.checks.dimensions import analysed
from symdyn.scene.checks.draft import draft_of, uses
from symdyn.scene.joints.joint_table import JOINTS
from symdyn.scene.joints.start import resting
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose
from symdyn.scene.values.element import Strut
from symdyn.scene.values.formula import quantity
from symdyn.scene.values.joint import Joint, acceleration_name
from symdyn.scene.values.mapping import map_quantities, substituted
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity
from symdyn.scene.values.table import Entry, Faults, show
from symdyn.scene.values.unit import Unit, UnitError
from symdyn.scene.values.with_unit import fits, with_unit

DECLARED = ("locked", "position")


def read_locks(joints: Sequence[Entry], faults: Faults) -> dict[str, Quantity]:
    """Return the position of every joint that is declared to be locked; rad or m."""
    positions: dict[str, Quantity] = {}
    for entry in joints:
        locked, raw = (entry.table.get(key) for key in DECLARED)
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


def lock(scene: Scene, positions: Mapping[str, Quantity], faults: Faults | None = None) -> Scene:
    """Return the scene with some joints fixed.

    Args:
        scene: checked, in order.
        positions: by name of the joint, rad or m, in numbers and parameters.
        faults: takes what is wrong and what was already found; a new list if None.

    Raises:
        SceneError: a position that is no constant, or nothing left that moves.
    """
    check_arguments(lock, locals(), SceneError)
    faults = faults or Faults(scene.source or scene.name)
    parameters = {parameter.name for parameter in scene.parameters}
    known: dict[str, Quantity] = {}
    for joint in scene.moving:
        if joint.name not in positions:
            continue
        where, position = f"joints.{joint.name}", positions[joint.name]
        strangers = [name for name in position.symbols if name not in parameters]
        if strangers:
            faults.add(where, f"position uses {strangers[0]}, which is no parameter")
        try:
            fits(position, Unit.read(JOINTS[joint.type].coordinates(joint)[0]))
        except UnitError as error:
            faults.add(where, f'position = "{with_unit(position, position.unit)}" {error}')
        if len(joint.coordinates) > 1 and position != Quantity.ZERO:
            faults.add(
                where, f"has {len(joint.coordinates)} coordinates and is locked at zero only; place it by origin"
            )
        at = (position,) if joint.coordinate else resting(joint)
        known |= dict(zip(joint.coordinates, at, strict=True)) | dict.fromkeys(joint.rates, Quantity.ZERO)
        known |= dict.fromkeys(map(acceleration_name, joint.rates), Quantity.ZERO)
    unknown = [name for name in positions if name not in {joint.name for joint in scene.moving}]
    for name in unknown:
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
        said = output.formula.symbols
        gone = [name for name in said if name not in parameters and name not in locked.letters(said)]
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
