"""What the template of a loop over pairs of velocities is given: second derivatives of whole robots, packed."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics import PairRuns, Velocities
from symdyn.dynamics.recursive.second_order import HALVED, RUNS, Run, pair_steps
from symdyn.emit.code.spelling import Printer
from symdyn.emit.targets.c.loops import StepText, written
from symdyn.program import PairLoop

LANES = 8
"""Velocities of a way side by side, to whole ones of which ways are filled up."""


@dataclass(frozen=True)
class PairRunsText:
    """A loop over pairs of velocities.

    Attributes:
        size: numbers that lines leave for it, `each` of every velocity.
        table: of every velocity how many it depends on, how many of these are of other joints, and all of them.
        velocities, entries: how many there are.
        lanes: the longest way, filled up.
        pair, run: steps of a pair, `goes` numbers, and along a way.
        joined: numbers of a pair that are others where both are of one joint, and behind which number these are.
        halved: the run whose entries within one joint are behind those of all runs.
    """

    size: int
    table: tuple[int, ...]
    velocities: int
    entries: int
    lanes: int
    pair: StepText
    run: StepText
    joined: tuple[int, int]
    runs: tuple[Run, ...] = RUNS
    halved: int = HALVED
    each: int = PairRuns.EACH
    copies: tuple[()] = ()


def chains(velocities: Velocities) -> tuple[int, ...]:
    """Return the table of ways."""
    ways = zip(velocities.chain, velocities.shared, strict=True)
    return tuple(x for chain, shared in ways for x in (len(chain), len(chain) - shared, *chain))


def pair_runs_text(loop: PairLoop, printer: Printer) -> PairRunsText:
    """Return the loop over pairs."""
    chain, steps = loop.velocities.chain, pair_steps()
    lanes = -(-max(map(len, chain)) // LANES) * LANES
    ways = {f"ways{k}": f"ways[{k * lanes} + k]" for k in range(30)}
    pair = [(f"pairs[{k * lanes} + k]", x) for k, x in enumerate(steps.pair)]
    found = [(f"found[{k * lanes} + k]", x) for k, x in enumerate(steps.entries)]
    numbers = {f"reach{k}": f"reach[{k}]" for k in range(54)}
    numbers |= {f"reach{54 + k}": f"S[{k}]" for k in range(6)}
    taken = range(steps.joined, steps.joined + 6)
    pairs = {
        f"pair{k}": f"joined[{(k - steps.joined) * lanes}]" if k in taken else f"pair[{k * lanes}]" for k in range(54)
    }
    return PairRunsText(
        len(loop.entries),
        chains(loop.velocities),
        len(chain),
        len(loop.composed(loop.entries)),
        lanes,
        written(pair, printer, numbers | ways, ("reach[", "S[")),
        written(found, printer, pairs | ways, ("pair[", "joined[")),
        (steps.joined, 54),
    )
