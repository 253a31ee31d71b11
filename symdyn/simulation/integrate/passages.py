"""Where in a step a formula passes zero: stretches are divided until their looks are sure, and a zero is closed in on.

A formula that has no real value for a while takes the sign that it has behind that as its own: it has not passed zero;
nor has one that changes its sign through infinity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.integrate.looks import CLOSER

EPS = float(np.finfo(np.float64).eps)

NARROW = 1e-6
"""Part of a step below which a stretch is narrow."""

DIVISIONS = 400
"""Narrow stretches that are divided in one place: what rounds to and fro at zero would take them without end."""

MOST = 10_000
"""The same in a whole step, which of a motion without forces may be the whole run."""

REAL = 1e-12
"""Part of a step to which it is found where a formula begins to have a real value, or ends to have one."""

MONOTONE = 4.0
"""Between nodes whose values differ by so many times what a formula can bend there it has one zero at most."""

POLE = 10.0
"""How many times larger a formula is where it changes its sign than close by, if it does so through infinity."""

HALVINGS = 1000
"""Steps of the search for a zero at most; one of high order takes more than a hundred."""

Look = Callable[[Array], Array]
"""Returns the values of a formula at times, shape (N,)."""

Place = tuple[float, float]
"""A time, and a value there."""


class Search:
    """The search for the passages of one formula in one step.

    Attributes:
        armed: the sign that it had last, NaN for none.
        given_up: from when on it was not divided though it was not sure, s; None where all is sure.
    """

    def __init__(self, look: Look, begin: Place, end: Place, armed: float, most: int = MOST) -> None:
        """Take the ends of a step, the sign before it, and how many narrow stretches are divided."""
        self.look, self.begin, self.end, self.armed = look, begin, end, armed
        self.given_up: float | None = None
        self.left, self.here = most, 0
        self.length = end[0] - begin[0]

    def passages(self) -> Iterator[tuple[Place, Place]]:
        """Yield stretches in which the formula passes zero once, in order; `armed` is then the sign behind."""
        waiting = [(self.begin, self.end, math.inf)]
        while waiting:
            low, high, bend = waiting.pop()
            if not self._sure(low, high, bend) and self._may(low, high):
                times = CLOSER.times(low[0], high[0])
                values = np.concatenate([[low[1]], self.look(times[1:-1]), [high[1]]])
                if np.isfinite(values).any():
                    known = float(CLOSER.bend(values))
                    bend = math.inf if math.isnan(known) else known
                    places = [*zip(times.tolist(), values.tolist(), strict=True)]
                    waiting += [(a, b, bend) for a, b in zip(places[-2::-1], places[:0:-1], strict=True)]
                    continue
            before, self.armed = self._signs(low, high)
            if before * self.armed < 0:
                yield low, high

    def _signs(self, low: Place, high: Place) -> tuple[float, float]:
        """Return the signs before and behind a stretch, NaN for none."""
        if not _real(low, high):
            return math.nan, math.nan
        before = self.armed if self.armed in (-1.0, 1.0) else float(np.sign(low[1])) or math.nan
        return before, float(np.sign(high[1])) or before

    def _sure(self, low: Place, high: Place, bend: float) -> bool:
        """Tell whether a stretch has one zero at most, and that where the signs differ, or is as short as can be."""
        width = high[0] - low[0]
        if not _real(low, high):
            return width <= REAL * self.length
        before, behind = self._signs(low, high)
        far = min(abs(low[1]), abs(high[1])) if before == behind else abs(high[1] - low[1]) / MONOTONE
        return far > bend or bend == 0.0 or width <= 4 * EPS * abs(high[0])

    def _may(self, low: Place, high: Place) -> bool:
        """Tell whether a stretch that is not sure is to be divided: not where too many narrow ones were."""
        narrow = high[0] - low[0] <= NARROW * self.length
        self.here = self.here + 1 if narrow else 0
        self.left -= narrow
        if self.here <= DIVISIONS and self.left > 0:
            return True
        self.given_up = low[0] if self.given_up is None else self.given_up
        return False


def _real(low: Place, high: Place) -> bool:
    return math.isfinite(low[1]) and math.isfinite(high[1])


def zero(look: Look, low: Place, high: Place) -> float:
    """Return the time between two at which a formula vanishes that changes its sign there, or has no value there."""
    from scipy.optimize import brentq

    if low[1] * high[1] >= 0:  # it vanishes at the first of them
        return low[0]
    known = dict((low, high))

    def value(t: float) -> float:
        found = known[t] if t in known else float(look(np.array([t]))[0])
        return 0.0 if math.isnan(found) else found

    found, _ = brentq(value, low[0], high[0], xtol=1e-24, rtol=4 * EPS, maxiter=HALVINGS, full_output=True, disp=False)
    return float(found)


def jumps(look: Look, t: float, begin: float, end: float) -> bool:
    """Tell whether a formula passes infinity where it changes its sign, at t in a step, or has no value there."""
    near = max(NARROW * (end - begin), 1e3 * EPS * abs(t))
    before, there, behind = np.abs(look(np.array([max(begin, t - near), t, min(end, t + near)])))
    return bool(np.isnan(there) or there > POLE * np.fmax(before, behind))
