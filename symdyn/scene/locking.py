"""Locked joints: declared to move, told to stand still. What comes out is a scene in which they are fixed.

    origin · motion(axis, position) · tip  =  (origin · step) · tip        step along or about a coordinate axis

A joint that follows a locked one is locked at ratio · position + offset. In the formulas of other joints the
coordinate has its position and the velocity is zero. The other coordinates keep their names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symdyn.scene import folding
from symdyn.scene.folding import FormulaError
from symdyn.scene.formula import quantity
from symdyn.scene.mapping import map_quantities, substituted
from symdyn.scene.model import Joint, Pose, Scene, velocity_name
from symdyn.scene.quantity import ZERO, Quantity
from symdyn.scene.table import Entry, Faults, show
from symdyn.scene.value import value_of

DECLARED = ("locked", "position")

STEPS = {"revolute": ("Rx", "Ry", "Rz"), "prismatic": ("Tx", "Ty", "Tz")}


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
        SceneError: a position that is no constant, an oblique axis away from zero, or nothing left that moves.
    """
    faults = faults or Faults(scene.source or scene.name)
    parameters = {parameter.name for parameter in scene.parameters}
    known: dict[str, Quantity] = {}
    for joint in scene.joints:
        if joint.name in positions and joint.coordinate:
            strangers = [name for name in positions[joint.name].symbols if name not in parameters]
            if strangers:
                faults.add(f"joints.{joint.name}", f"position uses {strangers[0]}, which is no parameter")
            known[joint.coordinate] = positions[joint.name]
            known[velocity_name(joint.coordinate)] = ZERO
    unknown = [name for name in positions if name not in {joint.name for joint in scene.moving}]
    for name in unknown:
        faults.add(f"joints.{name}", "only a joint with a coordinate of its own can be locked")
    try:
        joints = tuple(_settled(joint, known, faults) for joint in scene.joints)
        joints = map_quantities(joints, lambda one: substituted(one, known))
    except FormulaError as error:
        faults.add("", f"with locked joints a formula has no value: {error}")
    faults.close()
    locked = replace(scene, joints=joints)
    if not locked.coordinates:
        faults.add("", "nothing moves: every joint is locked; leave one free")
    faults.close()
    return locked


def _settled(joint: Joint, known: Mapping[str, Quantity], faults: Faults) -> Joint:
    """Return the joint, fixed at its place if what moves it is known."""
    follows = joint.coupling
    leader = follows.coordinate if follows else joint.coordinate
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
        origin=Pose((*joint.origin.steps, *_step(joint, position, faults))),
        tip=joint.tip,
        locked=True,
    )


def _step(joint: Joint, position: Quantity, faults: Faults) -> tuple[tuple[str, Quantity], ...]:
    """Return the motion of a joint at a position as an elementary step; () where it stands at zero."""
    if position == ZERO:
        return ()
    along = [(k, value) for k, x in enumerate(joint.axis) if (value := value_of(x, {})) != 0]
    if len(along) != 1:
        advice = "turn the joint frame by origin.rpy so that the axis is x, y or z"
        faults.add(f"joints.{joint.name}", f"a joint locked away from zero needs an axis along x, y or z; {advice}")
        return ()
    k, value = along[0]
    return ((STEPS[joint.type][k], position if value is not None and value > 0 else folding.neg(position)),)
