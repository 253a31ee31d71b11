"""Names that `symdyn.dynamics.loops` offers; each is imported when it is first used."""

from .assembly import Assembly as Assembly
from .constraint_rows import Cut as Cut, differentiated as differentiated
from .loop_decisions import pivots as pivots
from .loop_numbers import Numbers as Numbers
from .mobility import idle_motions as idle_motions, mobility as mobility
from .newton import direction_words as direction_words, free_motions as free_motions
from .partition import Partition as Partition, solve_normal as solve_normal
