"""What numbers decide about closed mechanisms before their equations are written, at values of the parameters.

Decisions are made at assembled positions. Where the start is given for other values, nothing is assembled: it is looked
whether the decisions hold there and a step away from there, and only where they may not are they made anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import lru_cache

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops import (
    CLOSED,
    NOTHING,
    LoopDecisions,
    Numbers,
    Partition,
    close,
    dimensionless,
    free_motions,
    loose_rows,
    rank_of,
    seen_closed,
)
from symdyn.dynamics.roads import LinearLoops, linear_loops
from symdyn.errors import DerivationError
from symdyn.scene import Scene
from symdyn.simulation.equations.opened import opened


@dataclass(frozen=True)
class WrittenDecisions:
    """The decisions that are written into equations; a tree has none.

    Attributes:
        kept, empty, redundant, partition, fails, driven: as of `LoopDecisions`.
        loose: rows whose multipliers rigid bodies do not tell.
        linear: how loops hold dependent coordinates in proportion, None where not.
        length: the characteristic length, m, at the values that they were made for.
    """

    kept: tuple[int, ...] = ()
    empty: tuple[int, ...] = ()
    redundant: tuple[int, ...] = ()
    partition: Partition | None = None
    fails: bool = False
    driven: Partition | None = None
    loose: tuple[int, ...] = ()
    linear: LinearLoops | None = None
    length: float = field(default=1.0, compare=False)

    def instead_of(self, other: WrittenDecisions) -> str:
        """Return what is said where values before have led to other decisions."""
        changed = [WORDS[f.name] for f in fields(self) if f.compare and getattr(self, f.name) != getattr(other, f.name)]
        words = " and ".join(dict.fromkeys(changed))
        return f"with these values numbers decide otherwise than before about {words}: the equations are written anew"


WORDS = {
    **dict.fromkeys(("kept", "empty", "redundant", "loose"), "redundant rows"),
    **dict.fromkeys(("partition", "fails"), "independent velocities"),
    "driven": "what the drives determine",
    "linear": "loops in proportion",
}


@lru_cache(maxsize=16)
def loop_decisions(scene: Scene) -> tuple[LoopDecisions, Numbers]:
    """Return what is decided about the loops and rows of a scene at its values, and the mechanism in numbers.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    return close(opened(scene).numbers(), opened(scene).closing)


@lru_cache(maxsize=16)
def written_decisions(scene: Scene) -> WrittenDecisions:
    """Return the decisions for a scene at its values; errors as of `loop_decisions`."""
    if not scene.is_closed:
        return WrittenDecisions()
    decisions, numbers = loop_decisions(scene)
    found = {name: getattr(decisions, name) for name in ("kept", "empty", "redundant", "partition", "fails", "driven")}
    loose, linear = loose_rows(numbers, decisions.assembly), linear_loops(numbers, decisions)
    return WrittenDecisions(**found, loose=loose, linear=linear, length=decisions.assembly.length)


CLEAR = 0.03
"""Smallest singular value of G_d over the largest of G with which a choice of independent velocities is kept."""

AWAY, STEPS = 0.03, 4
"""Step, rad or characteristic lengths, after which redundant rows must still be redundant; Newton's steps there."""


def hold(decisions: WrittenDecisions, numbers: Numbers, q: Array) -> bool:
    """Tell whether decisions made for other values hold for sure where a mechanism starts; False if they may not."""
    partition, length = decisions.partition, decisions.length
    if partition is None or decisions.linear is not None:
        return False
    try:
        here = dimensionless(numbers, q, length)
        if not (seen_closed(numbers, q) and _fit(decisions, here, numbers.scene)):
            return False
        free = free_motions(here)
        if not len(free):
            return True
        scales = np.full(numbers.state.n, length)
        scales[numbers.turns] = 1.0
        away = numbers.moved(q, AWAY * scales * free.sum(axis=0))
        for _ in range(STEPS):
            r = numbers.residual(away)
            if np.abs(r).max(initial=0.0) <= CLOSED * max(1.0, length):
                return _fit(decisions, dimensionless(numbers, away, length), numbers.scene)
            step = np.asarray(np.linalg.lstsq(numbers.residual_rates(away), -r, rcond=1e-10)[0], dtype=np.float64)
            away = numbers.moved(away, step)
    except DerivationError:  # a formula has no value there
        pass
    return False


def _fit(decisions: WrittenDecisions, G: Array, scene: Scene) -> bool:
    """Tell whether the rows without effect have none, the kept ones are independent, and all others depend on them."""
    assert decisions.partition is not None, "it was looked"
    kept, dependent = G[list(decisions.kept)], list(decisions.partition.dependent)
    if np.abs(G[list(decisions.empty)]).max(initial=0.0) > NOTHING or rank_of(singular(G)) != len(kept):
        return False
    if not dependent:
        return True
    chosen = singular(kept[:, dependent])
    if chosen[-1] < CLEAR * singular(kept)[0]:
        return False
    if scene.rows:  # holds no coordinates in proportion
        return True
    ratios = np.linalg.solve(kept[:, dependent], np.delete(kept, dependent, axis=1))
    return not np.all(np.abs(LARGEST_RATIOS * ratios - np.round(LARGEST_RATIOS * ratios)) < SAME)


def singular(G: Array) -> Array:
    """Return the singular values of a matrix, descending; none of one without entries."""
    return np.asarray(np.linalg.svd(G, compute_uv=False) if G.size else np.zeros(0))


LARGEST_RATIOS, SAME = 27720.0, 1e-4
"""The least multiple of 1 to 12, with which ratios of loops in proportion are whole, and how nearly."""
