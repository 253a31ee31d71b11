"""Programs: equations as straight-line code, pruned, named and counted; no syntax yet."""

from symdyn.program.assemble import assemble, identifier
from symdyn.program.count import CATEGORY, Counts, count
from symdyn.program.lower import lower
from symdyn.program.model import Program, Routine, Step, check

__all__ = ["CATEGORY", "Counts", "Program", "Routine", "Step", "assemble", "check", "count", "identifier", "lower"]
