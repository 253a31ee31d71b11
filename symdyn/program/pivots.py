"""Whether forward dynamics as a loop may not exist: a look with floats before its lines are left out."""

from __future__ import annotations

import random

from symdyn.dynamics import BESIDES, INERTIA, JointTable, forward_sweeps, kinds_of, names_of
from symdyn.errors import NoValueError
from symdyn.graph import evaluate
from symdyn.program.table_numbers import TableNumbers
from symdyn.scene import Scene

LITTLE = 1e-10
"""A pivot so many times smaller than the largest one is looked at exactly."""


def may_vanish(table: JointTable, scene: Scene) -> bool:
    """Tell whether a pivot of the mass matrix of a table is zero, or near it, at a position drawn at random."""
    from symdyn.algebra import Floats

    draw = random.Random(1)
    numbers = iter(TableNumbers(table, scene).every()[len(table.ground) :])
    exact = {id(row): [float(next(numbers)) for _ in row.entries] for row in table.rows}
    held = {i: [0.0] * INERTIA for i in range(len(table.rows) + 1)}
    pivots, algebra = [], Floats()
    for i, (row, kind) in reversed(list(enumerate(zip(table.rows, kinds_of(table), strict=True), 1))):
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
