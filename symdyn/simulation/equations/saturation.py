"""Saturation: when forces of a controller were cut at their limits.

A run reports which force was cut, at which limit, from when until when. A force that is held is cut from one sample to
the next, or not. One that acts all the time is tested inside every step, and the time at which it passes a limit is
found by bisection, for it may jump.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.frozen import dataclass, replace

Sides = npt.NDArray[np.int_]
"""Of every force: -1 where it is cut at its least value, 1 where at its most, else 0; shape (m,)."""

LOOKS = np.arange(1, 5) / 4
"""Where in a step a force is looked at that acts all the time, over its length."""

CLOSE = 1e-12
"""Part of a time, or of a second, to which it is narrowed down."""


@dataclass(frozen=True)
class Saturation:
    """A time in which a controller asked for more than a limit allows, and got the limit.

    Attributes:
        name: of the force or input.
        limit: what it was cut at.
        unit: of the limit, "" where it is not known.
        begin, end: from when until when, s.
    """

    name: str
    limit: float
    unit: str
    begin: float
    end: float

    @property
    def words(self) -> str:
        limit = f"{self.limit:g} {self.unit}".rstrip()
        return f"{self.name} is at its limit {limit} from t = {self.begin:.9g} s to t = {self.end:.9g} s"


class Cuts:
    """What is kept of a run in which forces are cut.

    Attributes:
        sides: where they are now.
        met: which of them were just at a limit at some time, shape (m,).
    """

    def __init__(
        self, names: Sequence[str], units: Sequence[str], least: Sequence[float], most: Sequence[float]
    ) -> None:
        """Take the names of forces, their units and their limits, shape (m,)."""
        self.names, self.units = tuple(names), tuple(units)
        self.least, self.most = np.array(least), np.array(most)
        self.limited = bool(np.isfinite(self.least).any() or np.isfinite(self.most).any())
        self.sides: Sides = np.zeros(len(self.names), dtype=int)
        self.met = np.zeros(len(self.names), dtype=bool)
        self._since = np.zeros(len(self.names))
        self._ended: list[Saturation] = []

    def of(self, values: Array) -> Sides:
        """Return on which sides of their limits forces are, shape (m,); what is at one is inside, and met it."""
        self.met |= (values == self.most) | (values == self.least)
        found: Sides = (values > self.most).astype(int) - (values < self.least).astype(int)
        return found

    def change(self, t: float, sides: Sides) -> None:
        """Take note of where forces are from a time on."""
        for k in np.flatnonzero(sides != self.sides):
            self._ended += self._open(int(k), t)
            self._since[k] = t
        self.sides = sides

    def look(self, t0: float, t1: float, requested: Callable[[float], Array]) -> None:
        """Look at forces that act all the time, from a time on at which they were looked at, to a later one."""
        before = t0
        for t in map(float, t0 + (t1 - t0) * LOOKS):
            sides = self.of(requested(t))
            while (sides != self.sides).any():
                k = int(np.flatnonzero(sides != self.sides)[0])
                before, changed = self._narrowed(k, before, t, sides, requested)
                self.change(before, changed)
            before = t

    def _narrowed(
        self, k: int, low: float, high: float, sides: Sides, requested: Callable[[float], Array]
    ) -> tuple[float, Sides]:
        """Return when one of the forces leaves the side on which it is at a time, and where all are then."""
        while high - low > CLOSE * max(1.0, high):
            middle = (low + high) / 2
            found = self.of(requested(middle))
            if found[k] == self.sides[k]:
                low = middle
            else:
                high, sides = middle, found
        return float(high), np.where(np.arange(len(sides)) == k, sides, self.sides)

    def until(self, end: float) -> tuple[Saturation, ...]:
        """Return what there was until a time, in order of time."""
        found = [*self._ended, *(one for k in range(len(self.names)) for one in self._open(k, end))]
        kept = [replace(one, end=min(one.end, end)) for one in found if one.begin < end]
        return tuple(sorted(kept, key=lambda one: one.begin))

    def _open(self, k: int, end: float) -> list[Saturation]:
        """Return the time that ends at a time, nothing where the force is inside its limits."""
        side, begin = int(self.sides[k]), float(self._since[k])
        limit = float((self.most if side > 0 else self.least)[k])
        return [Saturation(self.names[k], limit, self.units[k], begin, end)] if side and end > begin else []


MOST = 20
"""Times that are listed for a reader; a controller may chatter."""


def cut_lines(saturations: Sequence[Saturation]) -> list[str]:
    """Return lines that list such times, the first of many."""
    more = len(saturations) - MOST
    lines = [one.words for one in saturations[:MOST]]
    return [*lines, f"and {more} more, which {argument('json', True, 'run.saturations')} lists"] if more > 0 else lines


def saturation_report(cuts: Cuts, end: float) -> list[str]:
    """Return what is said of every limited force: for which share of the time it was cut, how often, first when."""
    found, lines = cuts.until(end), []
    rows = zip(cuts.names, cuts.units, cuts.met.tolist(), cuts.least.tolist(), cuts.most.tolist(), strict=True)
    for name, of, met, *ends in rows:
        unit = f" {of}" if of else ""
        at = [limit for limit in ends if any(one.name == name and one.limit == limit for one in found)]
        for limit in at:
            these = [one for one in found if one.name == name and one.limit == limit]
            share = 100 * sum(one.end - one.begin for one in these) / end
            often = "" if len(these) == 1 else f", {len(these)} times, the first"
            lines.append(
                f"{name} saturates at its limit {limit:g}{unit} for {share:.3g} % of the time{often} from "
                f"t = {these[0].begin:.6g} s to {these[0].end:.6g} s"
            )
        if not at and np.isfinite(ends).any():
            told = "reaches its limits and goes no further" if met else "never reaches its limits"
            lines.append(f"{name} {told}, {ends[0]:g} to {ends[1]:g}{unit}")
    return lines
