"""Functions that code may compute by a loop over a table of joints: one row each."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.recursive.joint_table import JointTable


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
    """When a loop is taken, and what for.

    Attributes:
        fewest: joints from which code is a loop unless it is asked for otherwise.
        why: what is gained from there on, in words.
        divides: whether it divides by pivots of the mass matrix, and does not exist where that is singular.
    """

    fewest: int
    why: str
    divides: bool = False


TABLE_LOOPS = {
    # About where blocks of states in lines leave the stack, so that many states take four times as long.
    "rnea_loop": LoopAlgorithm(400, "faster over many states, and compiled at once"),
    # About where lines of one state, which are fetched anew at every call, take longer than they wait for each other.
    "aba_loop": LoopAlgorithm(48, "faster, as its code stays in the nearest cache, and compiled at once", True),
}
