"""Programs: equations as straight-line code, pruned, named and counted; no syntax yet."""

from symdyn.dynamics.roads.count import BINDING, Counts, count, count_by_binding, state_dependent_counts
from symdyn.program.assemble import assemble, identifier
from symdyn.program.formulation import cheapest, choose, formulate
from symdyn.program.lower import at_rest, count_derived, lower
from symdyn.program.passes import PASSES, optimise
from symdyn.program.prepare import prepare
from symdyn.program.routine import Program, Routine, Step, check
from symdyn.program.skipped import Skipped, skipped

__all__ = [
    "BINDING",
    "PASSES",
    "Counts",
    "Program",
    "Routine",
    "Skipped",
    "Step",
    "assemble",
    "at_rest",
    "cheapest",
    "check",
    "choose",
    "count",
    "count_by_binding",
    "count_derived",
    "formulate",
    "identifier",
    "lower",
    "optimise",
    "prepare",
    "skipped",
    "state_dependent_counts",
]
