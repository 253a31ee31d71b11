"""Which positions of a closed mechanism are independent: rows that hold positions decide, whatever else rolls.

    held       independent rows among those that close; a wheel's normal row is one, and no row along its track
    places     their partition; its dependent velocities are dependent ones of all rows, so that independent
               velocities move independent positions

It is made at the assembled position, as the partition of velocities is.
"""

from __future__ import annotations

import numpy as np

from symdyn.dynamics.loops.loop_decisions import LoopDecisions, pivots, unit_rows
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.newton import NEGLIGIBLE
from symdyn.dynamics.loops.partition import Partition, blocks


def held_positions(numbers: Numbers, decisions: LoopDecisions) -> tuple[tuple[int, ...], Partition]:
    """Return the held rows, counted among all, and the partition of positions: independent velocities come first."""
    closes = [k for k, label in enumerate(numbers.constraints.labels) if label.closes and k not in decisions.empty]
    partition, n = decisions.partition, numbers.state.n
    if set(decisions.kept) <= set(closes):
        return decisions.kept, partition
    G = numbers.dimensionless(np.array(decisions.assembly.typical), decisions.assembly.length)
    count = int(np.linalg.matrix_rank(G[closes], tol=NEGLIGIBLE * float(np.abs(G).max()))) if closes else 0
    held = tuple(sorted(closes[i] for i in pivots(unit_rows(G[closes]), [list(range(len(closes)))], count)[0]))
    among = sorted(partition.dependent, reverse=True)
    chosen = pivots(G[list(held)].T, [among], count)[0]
    dependent = tuple(sorted(chosen))
    independent = (*partition.independent, *(k for k in partition.dependent if k not in chosen))
    rows = [numbers.constraints.G[k] for k in held]
    assert len(independent) + len(dependent) == n, "a velocity is one or the other"
    return held, Partition(
        independent, dependent, tuple(blocks([[k for k in dependent if not row[k].is_zero] for row in rows]))
    )
