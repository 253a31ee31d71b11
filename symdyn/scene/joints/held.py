"""Joints at a fixed position, as elementary steps: along or about a coordinate axis, between two turns if oblique."""

from __future__ import annotations

from collections.abc import Callable

from symdyn.scene.values import folding
from symdyn.scene.values.model import Joint
from symdyn.scene.values.quantity import ZERO, Quantity
from symdyn.scene.values.turns import Step, inverse, towards
from symdyn.scene.values.value import value_of

Steps = tuple[Step, ...]


def held(joint: Joint, position: Quantity, motion: Callable[[Quantity], Steps]) -> Steps:
    """Return what a joint does at a position along or about its axis; () at zero.

    Args:
        joint: one with an axis.
        position: rad or m.
        motion: steps "R" about and "T" along the axis, of a position in the sense of the axis.
    """
    if position == ZERO:
        return ()
    along = [(k, value) for k, x in enumerate(joint.axis) if (value := value_of(x, {})) != 0]
    there: Steps = ()
    if len(along) == 1:
        ((k, value),) = along
        position = position if value is not None and value > 0 else folding.neg(position)
    else:
        k, there = 2, towards(joint.axis)
    return (*there, *((kind + "xyz"[k], amount) for kind, amount in motion(position)), *inverse(there))


def turned_by(joint: Joint, angle: Quantity) -> Steps:
    """Return a turn about the axis, rad."""
    return held(joint, angle, lambda x: (("R", x),))


def shifted_by(joint: Joint, way: Quantity) -> Steps:
    """Return a shift along the axis, m."""
    return held(joint, way, lambda x: (("T", x),))
