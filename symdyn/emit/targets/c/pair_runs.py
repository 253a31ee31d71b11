"""Loops over pairs of velocities, which second derivatives are found by, as C."""

from __future__ import annotations

from symdyn.dynamics import PairRuns, PairSteps
from symdyn.emit.code.spelling import Printer
from symdyn.emit.targets.c.loops import StepText, whole, written
from symdyn.frozen import dataclass
from symdyn.program import PairLoop

SIDE = 8
"""Velocities of a way side by side, to whole ones of which ways are filled up."""


@dataclass(frozen=True)
class PairRunsText:
    """A loop over pairs of velocities."""

    loop: PairLoop  # what it goes over
    lanes: int  # the longest way, filled up
    steps: PairSteps  # of a pair and along a way, as expressions and as C, `pair` and `run`
    pair: StepText
    run: StepText
    each: int = PairRuns.EACH
    copies: tuple[()] = ()

    @property
    def behind(self) -> int:
        """Where its work space begins, behind what lines leave for it."""
        return whole(len(self.loop.entries))

    @property
    def size(self) -> int:
        """Numbers that lines leave for it, and of its work space: of ways, of pairs, and of what is found of one."""
        return self.behind + (30 + 60 + len(self.steps.runs) + 1) * self.lanes + 8

    @property
    def places(self) -> int:
        """Bytes of what tells whose numbers these are."""
        return 2 * (self.lanes + 2 * len(self.loop.velocities.chain))

    @property
    def table(self) -> tuple[int, ...]:
        """Of every velocity how many it depends on, how many of these are of other joints, and all of them."""
        ways = zip(self.loop.velocities.chain, self.loop.velocities.shared, strict=True)
        return tuple(x for way, shared in ways for x in (len(way), len(way) - shared, *way))


def pair_runs_text(loop: PairLoop, printer: Printer) -> PairRunsText:
    """Return the loop over pairs."""
    steps = PairSteps.known()
    lanes = -(-max(map(len, loop.velocities.chain)) // SIDE) * SIDE
    ways = {f"ways{k}": f"ways[{k * lanes} + k]" for k in range(30)}
    numbers = ways | {f"reach{k}": f"reach[{k}]" for k in range(54)} | {f"reach{54 + k}": f"S[{k}]" for k in range(6)}
    pairs = ways | {f"pair{k}": f"pair[{k * lanes}]" for k in range(54)}
    pairs |= {f"pair{steps.joined + k}": f"joined[{k * lanes}]" for k in range(6)}
    pair, run = (
        [(f"{name}[{k * lanes} + k]", x) for k, x in enumerate(results)]
        for name, results in (("pairs", steps.pair), ("found", steps.entries))
    )
    whole = "reach[", "S[", "pair[", "joined["
    return PairRunsText(loop, lanes, steps, written(pair, printer, numbers, whole), written(run, printer, pairs, whole))
