"""Names that `symdyn.dynamics.loops` offers; each is imported when it is first used."""

from .assembly import (
    Assembly as Assembly,
    closed_position as closed_position,
    off_planes as off_planes,
    witness as witness,
)
from .constraint_rows import Label as Label, differentiated as differentiated
from .continuation import declared_rates as declared_rates, fitting as fitting
from .cuts import Cut as Cut, cuts as cuts, gauges as gauges
from .loop_decisions import (
    NOTHING as NOTHING,
    LoopDecisions as LoopDecisions,
    close as close,
    loose_rows as loose_rows,
    pivots as pivots,
)
from .loop_numbers import FLAT as FLAT, Array as Array, Numbers as Numbers
from .loop_words import direction_words as direction_words, in_words as in_words
from .mobility import idle_motions as idle_motions, mobility as mobility
from .newton import (
    CLOSED as CLOSED,
    dimensionless as dimensionless,
    free_motions as free_motions,
    newton as newton,
    rank_of as rank_of,
    seen_closed as seen_closed,
)
from .partition import Block as Block, Partition as Partition, driven_velocities as driven_velocities
from .reduction import (
    Reduction as Reduction,
    solve_dependent as solve_dependent,
    solve_normal as solve_normal,
    solve_square as solve_square,
    solve_transposed as solve_transposed,
)
