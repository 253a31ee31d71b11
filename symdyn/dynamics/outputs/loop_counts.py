"""Operations of a loop over a table of joints, by categories: what its sweeps do at every joint and for every pair."""

from __future__ import annotations

from collections import Counter
from functools import cache

from symdyn.dynamics.mechanism.cost import CATEGORY
from symdyn.dynamics.recursive.sweeps import Pairs, Sweep
from symdyn.dynamics.recursive.table_loops import TableLoop
from symdyn.graph import Expr, reachable

FROM_ZERO = Counter(multiplications=4, additions=2)
"""What a turn that is not zero where q is costs besides."""


def count_loop(loop: TableLoop) -> Counter[str]:
    """Return the operations of one call; what several hand to one joint is added."""
    found, handed, rows = Counter[str](), set[int](), loop.table.rows
    for row, kind in zip(rows, loop.kinds, strict=True):
        sweeps = loop.algorithm.sweeps(kind)
        found += _count_sweeps(sweeps)
        if row.parent in handed:
            inward = (one for one in sweeps if one.inward)
            found += Counter(additions=sum(not x.is_zero for one in inward for x in one.handed))
        handed.add(row.parent)
        found += Counter(sincos=int(not row.slides))
        found += Counter() if row.at_zero or row.slides else FROM_ZERO
    for pairs in (one.pairs for one in loop.algorithm.sweeps(loop.kinds[0]) if one.pairs):
        found += _count_pairs(loop, pairs)
    return found


def _count_pairs(loop: TableLoop, pairs: Pairs) -> Counter[str]:
    """Return the operations of all pairs, and of equations with M where they are solved, all columns alike."""
    found, rows, n = Counter[str](), loop.table.rows, len(loop.table.rows)
    depth, products = [0], 0
    for row, many in zip(rows, loop.table.carried, strict=True):
        depth.append(depth[row.parent] + 1)
        products += (many - 1) * (depth[-1] + 6 * n)
        if row.parent:
            one = _count(pairs.of(rows[row.parent - 1].slides))
            found += Counter({name: many * number for name, number in one.items()})
    if pairs.solved:
        found += Counter(multiplications=products, additions=products, divisions=sum(depth) - n + 3 * n * n)
    return found


@cache
def _count_sweeps(sweeps: tuple[Sweep, ...]) -> Counter[str]:
    """Return the operations of sweeps at a joint, as they are printed: each is a function of its own."""
    return sum((_count(one.results) for one in sweeps), Counter[str]())


@cache
def _count(results: tuple[Expr, ...]) -> Counter[str]:
    return Counter(name for node in reachable(results) if (name := CATEGORY[node.op]))
