"""Programs: equations as straight-line code, pruned, named and counted; no syntax yet."""

from symdyn.dynamics.roads.count import Counts
from symdyn.program.assemble import identifier
from symdyn.program.formulation import cheapest, choose, formulate, kept_in_lines
from symdyn.program.in_lines import in_lines
from symdyn.program.lower import at_rest, count_derived, lower
from symdyn.program.prepare import prepare
from symdyn.program.routine import Program, Routine, Step
from symdyn.program.skipped import skipped
from symdyn.program.tunable import tunable

__all__ = [
    "Counts",
    "Program",
    "Routine",
    "Step",
    "at_rest",
    "cheapest",
    "choose",
    "count_derived",
    "formulate",
    "identifier",
    "in_lines",
    "kept_in_lines",
    "lower",
    "prepare",
    "skipped",
    "tunable",
]
