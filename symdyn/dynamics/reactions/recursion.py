"""Reactions by recursion: every joint's wrench from the equilibrium of what hangs on it, from the tips to the ground.

Reference: the textbook, eq. (5.18), body by body; Khalil and Dombre, Modeling, Identification and Control of Robots
(2002), section 9.5.

    f        wrench that the parent exerts on body j through its joint, about the origin of the body's frame, its axes
    τ_k      Σ over the moves of velocity k of S·f, and the rotors: what drives and the joint's own elements do
    λ        sizes of the wrenches W of joints that close loops and of contacts: the multipliers of forward dynamics, or
             from `ties` where a motion is given

A reaction is the whole wrench through the joint: what the bearing forbids, the drive, and the joint's own springs,
dampers and friction; only what turns the rotor itself (armature) stays in the drive. It acts at the origin of the moved
joint frame. No body is merged or regrouped: a fixed joint has its reaction, and so a body is cut by declaring it in two
parts, a fixed joint between them.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.reactions.closure_equations import ClosureEquation, refuse_without_place, sizes, ties
from symdyn.dynamics.reactions.free_bodies import FreeBodies
from symdyn.graph import Expr
from symdyn.spatial import Wrench


def reactions(hanging: FreeBodies, axes: str = "body", multipliers: Sequence[Expr] | None = None) -> list[Expr]:
    """Return every joint's reaction, row by row, shape (joints + loops, 6): [force; moment], N and N m.

    Args:
        hanging: the mechanism.
        axes: "body" (of the child as declared), "joint" (of the joint frame on the parent's side, for every type of
            joint) or "ground".
        multipliers: λ of the kept rows, where forces give the motion; None where the motion is given, and the drives of
            passive joints are zero.

    Raises:
        DerivationError: motion and drives do not determine what the loops transmit, or a row does not say where its
            force acts.
    """
    refuse_without_place(hanging.scene)
    f = hanging.transmitted(hanging.loads)
    if not hanging.cuts:
        return as_rows(hanging, hanging.at_joints(f), axes)
    unknown = ties(hanging)
    if multipliers is None:
        multipliers = sizes(hanging, unknown, hanging.needed_forces(f))
    return with_loops(hanging, f, unknown, multipliers, axes)


def with_loops(
    hanging: FreeBodies, f: Sequence[Wrench], unknown: Sequence[ClosureEquation], multipliers: Sequence[Expr], axes: str
) -> list[Expr]:
    """Return every reaction for f of the tree alone and given λ of what closes the loops; see `reactions`."""
    f = list(f)
    closing = [Wrench.none(hanging.graph)] * len(hanging.cuts)
    for one, size in zip(unknown, multipliers, strict=True):
        if one.wrench is not None:
            closing[one.loop] = closing[one.loop] + one.wrench.scaled(size)
    for loop, wrench in zip(hanging.cuts, closing, strict=True):
        hanging.carry(f, loop, wrench)
    ends = [loop.on_child(wrench) for loop, wrench in zip(hanging.loops, closing, strict=False)]
    return as_rows(hanging, [*hanging.at_joints(f), *ends], axes)


def as_rows(hanging: FreeBodies, wrenches: Sequence[Wrench], axes: str) -> list[Expr]:
    """Return the wrenches of all joints, axes of their children, in the axes that are asked for; see `reactions`."""
    placed = hanging.placements if axes == "ground" else []
    entries: list[Expr] = []
    for hinge, wrench in zip((*hanging.joints, *hanging.loops), wrenches, strict=True):
        force, moment = hinge.in_joint_axes(wrench) if axes == "joint" else wrench
        if axes == "ground" and hinge.child >= 0:
            force, moment = wrench.rotated(placed[hinge.child].R)
        entries += [*force, *moment]
    return entries
