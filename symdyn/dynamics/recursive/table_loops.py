"""Functions that code may compute by a loop over a table of joints: one row each.

A formulation of `OUTPUTS` that goes over a table has its row here, by its name, and nowhere else.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from symdyn.dynamics.recursive.aba_loop import BESIDES, INERTIA, forward_sweeps
from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.dynamics.recursive.rnea_loop import inverse_sweeps
from symdyn.dynamics.recursive.row_kinds import RowKind, kinds_of, names_of
from symdyn.dynamics.recursive.sweeps import Sweeps, values_over_table
from symdyn.errors import NoValueError
from symdyn.graph import Algebra, evaluate
from symdyn.scene import Scene

T = TypeVar("T")

LITTLE = 1e-10
"""A pivot so many times smaller than the largest one is looked at exactly."""


@dataclass(frozen=True)
class TableLoop:
    """A loop over a table.

    Attributes:
        formulation: which, a key of `TABLE_LOOPS`.
        table: the joints.
    """

    formulation: str
    table: JointTable

    @property
    def algorithm(self) -> LoopAlgorithm:
        """The row of the table of loops."""
        return TABLE_LOOPS[self.formulation]

    @property
    def kinds(self) -> list[RowKind]:
        """The kind of every row."""
        return kinds_of(self.table)

    def may_fail(self, scene: Scene) -> bool:
        """Tell whether it may not exist: it divides by pivots, and one at a position drawn at random is near zero."""
        if not self.algorithm.divides:
            return False
        from symdyn.algebra import Floats

        draw = random.Random(1)
        numbers = iter(self.table.numbers(scene)[len(self.table.ground) :])
        exact = {id(row): [float(next(numbers)) for _ in row.entries] for row in self.table.rows}
        held = {i: [0.0] * INERTIA for i in range(len(self.table.rows) + 1)}
        pivots, algebra = [], Floats()
        for i, (row, kind) in reversed(list(enumerate(zip(self.table.rows, self.kinds, strict=True), 1))):
            (inward,) = (one for one in forward_sweeps(kind) if one.inward)
            x, y = draw.uniform(-1, 1), draw.uniform(-1, 1)
            known = dict(zip(names_of(row), exact[id(row)], strict=True))
            known |= {"cosine": x, "sine": (1 - x * x) ** 0.5, "q": y, "tau": 1.0}
            known |= {f"inertia{k}": one for k, one in enumerate(held[i])} | {f"bias{k}": 0.0 for k in range(6)}
            known |= {f"inertia{k}": 0.0 for k in range(INERTIA - 6, INERTIA)}
            values = {inward.handed[0].graph.symbol(name): one for name, one in known.items()}
            try:
                found = evaluate((inward.kept[BESIDES], *inward.handed), algebra, values)
            except NoValueError:
                return True
            pivots.append(abs(1 / found[0]) if found[0] else float("inf"))
            held[row.parent] = [a + b for a, b in zip(held[row.parent], found[1:], strict=True)]
        return min(pivots) <= LITTLE * max(pivots)

    def values(self, numbers: Sequence[T], given: Mapping[str, Sequence[T]], algebra: Algebra[T]) -> list[T]:
        """Return its result over an algebra, for the numbers of its table and its arguments.

        Raises:
            what the algebra does where there is no value.
        """
        return values_over_table(self.table, self.algorithm.sweeps, numbers, given, algebra)


@dataclass(frozen=True)
class LoopAlgorithm:
    """What a loop does, when it is taken, and what for.

    Attributes:
        sweeps: what it does at a joint of a kind.
        fewest: joints from which code is a loop unless it is asked for otherwise.
        why: what is gained from there on, in words.
        divides: whether it divides by pivots of the mass matrix, and does not exist where that is singular.
    """

    sweeps: Sweeps
    fewest: int
    why: str
    divides: bool = False


SOONER = "faster, as its code stays in the nearest cache, and compiled at once"

TABLE_LOOPS = {
    # About where lines of one state, which are fetched anew at every call, take longer than they wait for each other;
    # of trees with many kinds of joints and of bodies with many zeros a little later than of others.
    "rnea_loop": LoopAlgorithm(inverse_sweeps, 64, SOONER),
    "aba_loop": LoopAlgorithm(forward_sweeps, 40, SOONER, divides=True),
}
