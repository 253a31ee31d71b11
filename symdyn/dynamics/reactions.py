"""Reactions by recursion: every joint's wrench from the equilibrium of what hangs on it, from the tips to the ground.

Reference: the textbook, eq. (5.18), body by body; Khalil and Dombre, Modeling, Identification and Control of Robots
(2002), section 9.5.

    f        wrench that the parent exerts on body j through its joint, about the origin of the body's frame, its axes
    τ_k      Σ over the moves of velocity k of S·f, and the rotors: what drives and the joint's own elements do
    λ        sizes of the wrenches W of the joints that close loops, from `closing`

A reaction is the whole wrench through the joint: what the bearing forbids, the drive, and the joint's own springs,
dampers and friction; only what turns the rotor itself (armature) stays in the drive. It acts at the origin of the moved
joint frame. No body is merged or regrouped: a fixed joint has its reaction, and so a body is cut by declaring it in two
parts, a fixed joint between them.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.closing import Closing, closings, solved
from symdyn.dynamics.hanging import Hanging
from symdyn.dynamics.hinges import nothing, plus, times
from symdyn.dynamics.members import placements
from symdyn.graph import Expr
from symdyn.scene.joints import Wrench
from symdyn.spatial import apply


def tree_forces(hanging: Hanging) -> list[Expr]:
    """Return M u̇ + h of the tree, shape (nv,): what drives and loops must exert together."""
    return hanging.driving(hanging.felt(hanging.transmitted(hanging.loads)))


def reactions(hanging: Hanging, axes: str = "body") -> list[Expr]:
    """Return every joint's reaction, row by row, shape (joints + loops, 6): [force; moment], N and N m.

    Args:
        hanging: the mechanism.
        axes: "body" (of the child as declared), "joint" (of the joint frame on the parent's side, for every type of
            joint) or "ground".

    Raises:
        DerivationError: motion and drives do not determine what the loops transmit.
    """
    f = hanging.transmitted(hanging.loads)
    if not hanging.loops:
        return rows(hanging, f, [], axes)
    unknown = closings(hanging)
    sizes = solved(hanging, unknown, hanging.driving(hanging.felt(f)))
    return with_loops(hanging, f, unknown, sizes, axes)


def with_loops(
    hanging: Hanging, f: Sequence[Wrench], unknown: Sequence[Closing], sizes: Sequence[Expr], axes: str
) -> list[Expr]:
    """Return every reaction for f of the tree alone and given sizes λ of what closes the loops; see `reactions`."""
    f = list(f)
    closing = [nothing(hanging.graph)] * len(hanging.loops)
    for one, size in zip(unknown, sizes, strict=True):
        if one.wrench is not None:
            closing[one.loop] = plus(closing[one.loop], times(size, one.wrench))
    for loop, wrench in zip(hanging.loops, closing, strict=True):
        hanging.carry(f, loop, wrench)
    return rows(hanging, f, closing, axes)


def rows(hanging: Hanging, f: Sequence[Wrench], closing: Sequence[Wrench], axes: str) -> list[Expr]:
    """Return the reactions as they are asked for; see `reactions`."""
    here = [hanging.at_joint(hinge, wrench) for hinge, wrench in zip(hanging.joints, f, strict=True)]
    here += [hinge.on_child(wrench) for hinge, wrench in zip(hanging.loops, closing, strict=True)]
    placed = placements(hanging.joints) if axes == "ground" else []
    entries: list[Expr] = []
    for hinge, (force, moment) in zip(hanging.hinges, here, strict=True):
        if axes == "joint":
            force, moment = hinge.in_joint_axes((force, moment))
        elif axes == "ground" and hinge.child >= 0:
            R = placed[hinge.child].R
            force, moment = apply(R, force), apply(R, moment)
        entries += [*force, *moment]
    return entries
