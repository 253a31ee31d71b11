"""What closes loops: reactions of the tree eliminated from (5.18) leave an equation for each velocity without a drive.

    W_l      wrench l of a joint that closes a loop, axes of its joint frame J, about P
    G_lk     its power for unit velocity k: W_l · (twist of the child relative to J)
    Gᵀ λ = f    in the velocities without a drive, f what they feel from the tree alone

A loop whose bodies move in one plane relative to each other cannot say what goes across the plane: there are three
equations a body. Its joint is taken to transmit what lies in the plane, and the tree's joints the rest: reactions in
the plane are unique, those across it are this choice among many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.dynamics.loops.closed import solve_transposed
from symdyn.dynamics.loops.partition import Partition, blocks, over_driven
from symdyn.dynamics.loops.rows import recursive
from symdyn.dynamics.reactions.elimination import pivots
from symdyn.dynamics.reactions.hanging import Hanging
from symdyn.dynamics.reactions.hinges import Hinge, power, relative_twists
from symdyn.dynamics.reactions.samples import Array
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene import JOINTS, Scene
from symdyn.scene.joints import Wrench
from symdyn.scene.joints.blocks import unit
from symdyn.scene.joints.constraints import everywhere
from symdyn.spatial import Vec, dot, scale, sub

FLAT = 1e-9  # how far a twist may leave a plane, relative to the largest


@dataclass(frozen=True)
class Tie:
    """One unknown that closes a loop, or keeps a row of the scene.

    Attributes:
        owner: name of the loop or row.
        loop: number of the loop or contact, -1 for a row.
        wrench: W at unit size; None for a row, which acts on the velocities alone.
        G: its row of G, shape (nv,).
    """

    owner: str
    loop: int
    wrench: Wrench | None
    G: tuple[Expr, ...]


def ties(hanging: Hanging) -> list[Tie]:
    """Return the unknowns of all loops, those across the plane of a planar loop left out, and of all rows."""
    found: list[Tie] = []
    for number, loop in enumerate(hanging.cuts):
        twists = relative_twists(loop, hanging.joints)
        wrenches = loop.wrenches
        normal = plane(hanging, loop, twists)
        if normal is not None:
            wrenches = in_plane(hanging, wrenches, normal)
        for wrench in wrenches:
            row = [hanging.graph.zero] * hanging.state.n
            for k, twist in twists.items():
                row[k] = power(wrench, twist)
            found.append(Tie(loop.joint.name, number, wrench, tuple(row)))
    return [*found, *rows_of(hanging)]


def rows_of(hanging: Hanging) -> list[Tie]:
    """Return the unknowns of the rows that are formulas: forces on the velocities, whatever exerts them."""
    names = {row.name for row in hanging.scene.rows if row.type == "formula"}
    if not names:
        return []
    every = recursive(hanging.scene, hanging.tree, hanging.state)
    pairs = zip(every.labels, every.G, strict=True)
    return [Tie(label.owner, -1, None, G) for label, G in pairs if label.owner in names]


def solved(hanging: Hanging, unknown: Sequence[Tie], excess: Sequence[Expr], among: Sequence[int]) -> list[Expr]:
    """Return the sizes λ with Gᵀ λ = excess, block by block.

    Args:
        hanging: the mechanism.
        unknown: from `ties`.
        excess: what the velocities feel from the tree alone, M u̇ + h, less what drives them; shape (nv,).
        among: velocities whose excess is known. Those beyond the number of unknowns keep their equations by themselves
            (the idle spin of a rod between two balls) if the motion is one that the drives can give.

    Raises:
        DerivationError: these velocities do not determine λ.
    """
    rows = telling(hanging, unknown, among)
    uses = [[k for k in rows if not one.G[k].is_zero] for one in unknown]
    partition = Partition((), tuple(rows), tuple(blocks(uses)))
    return solve_transposed([one.G for one in unknown], partition, excess)


def telling(hanging: Hanging, unknown: Sequence[Tie], among: Sequence[int]) -> list[int]:
    """Return as many velocities as unknowns, whose equations determine these; see `solved`."""
    A = [one.G[k] for k in among for one in unknown]
    order = pivots(hanging.samples.at(A).reshape(len(among), len(unknown)))
    if len(order) < len(unknown):
        scene, every = hanging.scene, range(len(hanging.scene.velocities))
        whole = hanging.samples.at([one.G[k] for k in every for one in unknown]).reshape(len(every), len(unknown))
        free = len(every) - len(pivots(whole))
        if len(every) - len(among) > free:
            raise DerivationError(f"{scene.name}: reactions are not unique: {over_driven(scene, free)}")
        owners = ", ".join(dict.fromkeys(one.owner for one in unknown))
        raise DerivationError(
            f"{hanging.scene.name}: reactions: {len(among)} velocities without a drive determine {len(order)} of the "
            f"{len(unknown)} components that close {owners}: the mechanism has too many drives, or is overconstrained; "
            "leave drives out, take joints with more freedoms, or ask "
            "symdyn.dynamics.reactions_at for the least reactions at one position, with those "
            "flagged that are not unique"
        )
    return sorted(among[row] for row, _ in order)


def undriven(scene: Scene) -> list[int]:
    """Return the velocities without a drive or a prescribed motion."""
    moved = {name for joint in scene.joints if joint.motion is not None for name in joint.rates}
    pairs = zip(scene.velocities, scene.drives, strict=True)
    return [k for k, (name, drive) in enumerate(pairs) if drive is None and name not in moved]


# Planes


def plane(hanging: Hanging, loop: Hinge, twists: dict[int, Wrench]) -> Vec | None:
    """Return the normal of the plane that a loop moves in, axes of J; None in space."""
    graph = hanging.graph  # the joint's own axis and those of J are tried
    entries = [x for v, omega in twists.values() for x in (*v, *omega)]
    numbers = [hanging.samples.at(entries, seed).reshape(-1, 2, 3) for seed in (2, 3)]
    normals = list(everywhere(graph)[::-1])
    if loop.joint.type in JOINTS and "axis" in JOINTS[loop.joint.type].keys:
        normals.insert(0, unit(loop.joint.axis, graph))
    for normal in normals:
        n = hanging.samples.at(normal, 2)
        if all(_flat(twist, n) for at in numbers for twist in at):
            return normal
    return None


def _flat(twist: Array, n: Array) -> bool:
    (v, omega), size = twist, max(1.0, float(np.abs(twist).max()))
    return abs(float(v @ n)) < FLAT * size and float(np.abs(np.cross(n, omega)).max()) < FLAT * size


def in_plane(hanging: Hanging, wrenches: Sequence[Wrench], normal: Vec) -> tuple[Wrench, ...]:
    """Return wrenches without what goes across a plane, of which only independent ones."""
    flat = [(sub(f, scale(dot(f, normal), normal)), scale(dot(m, normal), normal)) for f, m in wrenches]
    numbers = hanging.samples.at([x for f, m in flat for x in (*f, *m)], 2).reshape(-1, 6)
    kept: list[int] = []
    for k in range(len(flat)):
        if np.linalg.matrix_rank(numbers[[*kept, k]], tol=FLAT) > len(kept):
            kept.append(k)
    return tuple(flat[k] for k in kept)
