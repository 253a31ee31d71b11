"""Which entries of reactions rigid bodies do not tell: those that self-equilibrated wrenches in the loops change.

    N    λ of all wrenches that close loops, none left out, with Gᵀ λ = 0: they load joints and move nothing

An entry is unique exactly when no λ of N changes it. One drawn at random from N changes, but for a set of measure zero,
every entry that any of them does; it is drawn at generic positions, where the loops are closed and nothing is special.
"""

from __future__ import annotations

import numpy as np

from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.reactions.hanging import Hanging
from symdyn.dynamics.reactions.hinges import nothing
from symdyn.dynamics.reactions.least import Flags
from symdyn.dynamics.reactions.recursion import with_loops
from symdyn.dynamics.reactions.ties import all_ties
from symdyn.dynamics.roads.workspace import Workspace
from symdyn.scene import Scene

LOOSE = 1e-7
"""Entries above it, over the largest, are changed: positions are closed to the last digits."""


def unique_reactions(
    scene: Scene,
    axes: str = "body",
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Flags:
    """Return which entries of `reactions` rigid bodies determine, shape (joints + loops, 6), [force; moment] by joint.

    Args:
        scene: the mechanism.
        axes: "body", "joint" or "ground"; in other axes other entries are.
        closing: what to choose about closed loops.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    count = len(scene.joints) + len(scene.loops)
    found = unique_entries(Workspace(scene, closing), axes) or (True,) * (6 * count)
    return np.array(found).reshape(count, 6)


def unique_entries(w: Workspace, axes: str = "body") -> tuple[bool, ...]:
    """Return which entries of the reactions are unique, row by row; () where all are.

    Args:
        w: the workspace of the scene.
        axes: as of `reactions`; in other axes other entries are.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    if not w.hanging.cuts:
        return ()
    decisions, numbers = w.loops.decisions, w.loops.numbers
    rank, count = len(decisions.kept), len(decisions.names)
    if rank == count:
        return ()
    hanging = Hanging(w.scene, numbers.tree, numbers.state, decisions)  # on a graph of its own
    sizes = [numbers.graph.symbol(f"size[{k}]") for k in range(count)]
    still = [nothing(numbers.graph)] * len(hanging.joints)
    R = with_loops(hanging, still, all_ties(hanging, whole=True), sizes, axes)
    loose = np.zeros(len(R), dtype=bool)
    rng = np.random.default_rng(1)
    for place in map(np.array, decisions.assembly.places):
        U, _, _ = np.linalg.svd(numbers.jacobian(place))
        drawn = U[:, rank:] @ rng.uniform(0.5, 1.5, count - rank)
        changed = np.abs(numbers.at(R, place, dict(zip(sizes, drawn.tolist(), strict=True))))
        loose |= changed > LOOSE * changed.max(initial=0.0)
    return () if not loose.any() else tuple((~loose).tolist())
