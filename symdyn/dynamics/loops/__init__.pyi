"""Names that `symdyn.dynamics.loops` offers; each is imported when it is first used."""

from .assembly import Assembly as Assembly
from .constraint_rows import Label as Label, differentiated as differentiated
from .cuts import Cut as Cut, cuts as cuts
from .loop_decisions import LoopDecisions as LoopDecisions, pivots as pivots
from .loop_numbers import Numbers as Numbers
from .loop_words import direction_words as direction_words, ends as ends
from .mobility import idle_motions as idle_motions, mobility as mobility
from .newton import free_motions as free_motions
from .partition import Block as Block, Partition as Partition
from .reduction import (
    solve_dependent as solve_dependent,
    solve_normal as solve_normal,
    solve_square as solve_square,
    solve_transposed as solve_transposed,
)
