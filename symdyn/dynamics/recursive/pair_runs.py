"""Packed second derivatives as a loop over pairs of velocities: what comes before it, and its steps.

All scenes have the same steps, those of `second_order`, on the numbers of their velocities; what is proved of these
expressions is proved of the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import ClassVar

from symdyn.dynamics.recursive.joint_table import symbols, vectors
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.second_order import (
    HALVED,
    RUNS,
    Pair,
    Reach,
    Run,
    Velocities,
    Ways,
    halved,
    numbers,
    of_one_joint,
    pair,
)
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.spatial import Mat

WAYS, REACH, PAIR = 24, 54, 54
"""How many numbers these have; those of a reach begin with its momentum."""


@dataclass(frozen=True, eq=False)
class PairRuns:
    """What packed entries are composed of, which code may do in a loop over pairs of velocities."""

    scene: Scene  # whose parameters the numbers hold
    velocities: Velocities  # of its tree
    numbers: tuple[Expr, ...]  # WAYS and REACH numbers of every velocity, which may be any that are so `grouped`

    EACH: ClassVar = WAYS + REACH

    @classmethod
    def of(cls, scene: Scene, tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr]) -> PairRuns:
        """Return that of the bodies of a scene's tree, a velocity for each elementary joint, at q̇ and q̈, shape (n,)."""
        every = zip(*numbers(tree, qd, qdd), strict=True)
        return cls(scene, Velocities.of(tree.parent, tree.block), tuple(x for one in every for x in _flat(one)))

    @classmethod
    def composed(cls, velocities: Velocities, numbers: Sequence[Expr]) -> list[Expr]:
        """Return the packed entries from such numbers, on any graph."""
        every = [grouped(numbers[k : k + cls.EACH]) for k in range(0, len(numbers), cls.EACH)]
        found = list[Expr]()
        for d, m, same in velocities.pairs():
            (of_d, reach), (of_m, other), chain = every[d], every[m], velocities.chain[m]
            here, own = pair(reach, of_m), len(chain) - velocities.shared[m]
            if same:
                here = here._replace(uu=of_one_joint(here, of_d, other))
            for number, run in enumerate(RUNS):
                for k, s in enumerate(chain if run.whole else chain[:own]):
                    if not (same and run.apart):
                        ways = every[s][0]
                        half = number == HALVED and k >= own
                        found.append(halved(here, ways) if half else run.entry(here, ways))
        return found


def grouped(numbers: Sequence[Expr]) -> tuple[Ways, Reach]:
    """Return the ways and the reach that WAYS + REACH numbers are."""
    v = vectors(numbers)
    ways, x = Ways(*((v[k], v[k + 1]) for k in range(0, 8, 2))), v[8:]
    return ways, Reach((x[0], x[1]), (x[2], x[3]), x[4], (x[5], x[6]), (x[7], x[8]), x[9], Mat(x[10:13]), x[13], x[14],
                       Mat(x[15:]))  # fmt: skip


def _flat(one: object) -> Iterator[Expr]:
    """Iterate over all numbers of ways, of a reach, of a pair, in their order there."""
    if isinstance(one, Expr):
        yield one
    else:
        for part in one if isinstance(one, Iterable) else vars(one).values():
            yield from _flat(part)


@dataclass(frozen=True)
class PairSteps:
    """What a loop does for a pair and along the way of its outer velocity, as expressions of symbols.

    Attributes:
        pair: numbers of a pair, then of one of one joint in place of the sum V + W, of `reach0` …, the reach of d and
            the S of its ways, and `ways0` …, the ways of m and the momentum of its reach.
        joined: where that sum stands among the numbers.
        entries: an entry of every run, then of the halved one, of `pair0` … and `ways0` … of s.
        runs, halved: those runs, and which one is halved.
    """

    pair: tuple[Expr, ...]
    joined: int
    entries: tuple[Expr, ...]
    runs: tuple[Run, ...] = RUNS
    halved: int = HALVED

    @classmethod
    @cache
    def known(cls) -> PairSteps:
        """Return them; what they do not read of a reach or of ways is `rest0` …."""
        graph = Graph()
        d, m, rest = (symbols(graph, name, many) for name, many in (("reach", 60), ("ways", 30), ("rest", 54)))
        ways, reach = grouped([*d[REACH:], *rest[: WAYS - 6], *d[:REACH]])
        other, momentum = grouped([*m, *rest[: REACH - 6]])
        here = pair(reach, other)
        whole = (*_flat(here), *_flat(of_one_joint(here, ways, momentum)))
        f, s = vectors(symbols(graph, "pair", PAIR)), grouped([*m[:WAYS], *rest])[0]
        there = Pair(*((f[k], f[k + 1]) for k in range(0, len(f), 2)))
        entries = (*(run.entry(there, s) for run in RUNS), halved(there, s))
        return PairSteps(whole, 6 * Pair._fields.index("uu"), entries)
