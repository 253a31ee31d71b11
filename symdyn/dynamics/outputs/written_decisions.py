"""Decisions about closed mechanisms that are written into their equations, and whether they hold elsewhere.

Where a start is given for other values of the parameters, nothing is assembled: it is looked whether the decisions hold
there and a step away from there, and only where they may not are they made anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.loops.loop_decisions import NOTHING, indeterminate_rows
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import CLOSED, free_motions, rank_of
from symdyn.dynamics.loops.partition import LoopChoices, Partition
from symdyn.dynamics.outputs.linear_loops import LinearLoops, linear_loops
from symdyn.dynamics.outputs.signal_outputs import multiplier_names
from symdyn.errors import DerivationError
from symdyn.scene import Scene

WORDS = {
    **dict.fromkeys(("independent_rows", "zero_rows", "redundant", "indeterminate"), "redundant rows"),
    **dict.fromkeys(("partition", "fails"), "independent velocities"),
    "actuated": "what the drives determine",
    "linear": "loops in proportion",
}

CLEAR = 0.03
"""Smallest singular value of G_d over the largest of G with which a choice of independent velocities is kept."""

AWAY, STEPS = 0.03, 4
"""Step, rad or characteristic lengths, after which redundant rows must still be redundant; Newton's steps there."""

LARGEST_RATIOS, SAME = 27720.0, 1e-4
"""The least multiple of 1 to 12, with which ratios of loops in proportion are whole, and how nearly."""


@dataclass(frozen=True)
class WrittenDecisions:
    """The decisions that are written into equations; a tree has none.

    Attributes:
        independent_rows, zero_rows, redundant, partition, fails, actuated: as of `LoopDecisions`.
        indeterminate: rows whose multipliers rigid bodies do not tell.
        linear: how loops hold dependent coordinates in proportion, None where not.
        length: the characteristic length, m, at the values that they were made for.
        letters: names of the multipliers of the independent rows, as formulas and columns have them.
    """

    independent_rows: tuple[int, ...] = ()
    zero_rows: tuple[int, ...] = ()
    redundant: tuple[int, ...] = ()
    partition: Partition | None = None
    fails: bool = False
    actuated: Partition | None = None
    indeterminate: tuple[int, ...] = ()
    linear: LinearLoops | None = None
    length: float = field(default=1.0, compare=False)
    letters: tuple[str, ...] = field(default=(), compare=False)

    @classmethod
    def of(cls, numbers: Numbers, closing: LoopChoices) -> WrittenDecisions:
        """Return what is written of decisions about a mechanism; DerivationError where it cannot be assembled."""
        decisions, numbers = numbers.decided(closing)
        names = ("independent_rows", "zero_rows", "redundant", "partition", "fails", "actuated")
        unknown, linear = indeterminate_rows(numbers, decisions.assembly), linear_loops(numbers, decisions)
        found = {name: getattr(decisions, name) for name in names}
        letters = multiplier_names(numbers.scene, decisions, numbers, unknown)
        return cls(**found, indeterminate=unknown, linear=linear, length=decisions.assembly.length, letters=letters)

    def instead_of(self, other: WrittenDecisions) -> str:
        """Return what is said where values before have led to other decisions."""
        changed = [WORDS[f.name] for f in fields(self) if f.compare and getattr(self, f.name) != getattr(other, f.name)]
        words = " and ".join(dict.fromkeys(changed))
        return f"with these values numbers decide otherwise than before about {words}: the equations are written anew"

    def hold(self, numbers: Numbers, q: Array) -> bool:
        """Tell whether they, made for other values, hold for sure where a mechanism starts; False if they may not."""
        partition, length = self.partition, self.length
        if partition is None or self.linear is not None:
            return False
        try:
            here = numbers.dimensionless(q, length)
            if not (numbers.is_closed(q) and _fit(self, here, numbers.scene)):
                return False
            free = free_motions(here)
            if not len(free):
                return True
            scales = np.full(numbers.state.n, length)
            scales[numbers.angular_velocities] = 1.0
            away = numbers.moved(q, AWAY * scales * free.sum(axis=0))
            for _ in range(STEPS):
                r = numbers.residual(away)
                if np.abs(r).max(initial=0.0) <= CLOSED * max(1.0, length):
                    return _fit(self, numbers.dimensionless(away, length), numbers.scene)
                step = np.asarray(np.linalg.lstsq(numbers.residual_rates(away), -r, rcond=1e-10)[0], dtype=np.float64)
                away = numbers.moved(away, step)
        except DerivationError:  # a formula has no value there
            pass
        return False


def _fit(decisions: WrittenDecisions, G: Array, scene: Scene) -> bool:
    """Tell whether the zero rows vanish, the independent ones are so, and all others depend on them."""
    assert decisions.partition is not None, "it was looked"
    basis, dependent = G[list(decisions.independent_rows)], list(decisions.partition.dependent)
    if np.abs(G[list(decisions.zero_rows)]).max(initial=0.0) > NOTHING or rank_of(singular(G)) != len(basis):
        return False
    if not dependent:
        return True
    chosen = singular(basis[:, dependent])
    if chosen[-1] < CLEAR * singular(basis)[0]:
        return False
    if scene.rows:  # holds no coordinates in proportion
        return True
    ratios = np.linalg.solve(basis[:, dependent], np.delete(basis, dependent, axis=1))
    return not np.all(np.abs(LARGEST_RATIOS * ratios - np.round(LARGEST_RATIOS * ratios)) < SAME)


def singular(G: Array) -> Array:
    """Return the singular values of a matrix, descending; none of one without entries."""
    return np.asarray(np.linalg.svd(G, compute_uv=False) if G.size else np.zeros(0))
