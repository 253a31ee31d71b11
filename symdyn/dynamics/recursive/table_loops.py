"""Functions that code may compute by a loop over a table of joints: one row each.

A road of `OUTPUTS` that goes over a table has its row here, by its name, and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.recursive.aba_loop import forward_sweeps
from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.dynamics.recursive.rnea_loop import inverse_sweeps
from symdyn.dynamics.recursive.sweeps import Sweeps


@dataclass(frozen=True)
class TableLoop:
    """A loop over a table.

    Attributes:
        road: which, a key of `TABLE_LOOPS`.
        table: the joints.
    """

    road: str
    table: JointTable

    @property
    def algorithm(self) -> LoopAlgorithm:
        """The row of the table of loops."""
        return TABLE_LOOPS[self.road]


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
