"""How long a run will take: said once it is known to be long; a run that would take years is ended.

The time of the end may be a slip of the pen, `--until 1e6` for 1e0, and nobody should wait for it in ignorance. The
pace is that of the stretch since the last look, so that a slow beginning does not count; a run is ended by two of them.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from symdyn.simulation.integrate import IntegrationError

FIRST = 3.0
"""Seconds of computing before the first look, and after each look four times as many."""

LONG, HOPELESS = 60.0, 365.25 * 86400.0
"""Seconds of computing that are worth a word, and those that nobody waits for."""

UNITS = (("year", HOPELESS), ("day", 86400.0), ("hour", 3600.0), ("minute", 60.0), ("second", 1.0))


class Outlook:
    """Looks at the pace of a run."""

    def __init__(self, until: float, say: Callable[[str], None] | None) -> None:
        """Start the clock; `say` is told."""
        self.until, self.say = until, say
        self.next, self.t, self.begin = FIRST, 0.0, time.perf_counter()
        self.last, self.hopeless = self.begin, False

    def look(self, t: float) -> None:
        """Tell how long the rest takes.

        Raises:
            IntegrationError: it would take years.
        """
        now = time.perf_counter()
        if t == 0.0:  # compiling is no part of the pace
            self.begin = self.last = now
        if now - self.last < self.next:
            return
        rest = (self.until - t) * ((now - self.last) / (t - self.t)) if t > self.t else float("inf")
        spent = now - self.begin
        if rest > HOPELESS and self.hopeless:
            raise IntegrationError(
                f"t = {t:g} s after {spoken(spent)} of computing; at this pace t = {self.until:g} s takes "
                f"{spoken(rest)}, so the run ends here; give an end that is sooner, or a coarser tolerance"
            )
        if rest > LONG and self.say is not None:
            self.say(
                f"t = {t:g} s after {spoken(spent)}; at this pace the end at t = {self.until:g} s is "
                f"{spoken(rest)} away; Ctrl-C ends the run with what it has"
            )
        self.last, self.t, self.next, self.hopeless = now, t, 4 * self.next, rest > HOPELESS


def spoken(seconds: float) -> str:
    """Return a duration in words, such as "about 5 hours"."""
    name, unit = next(((name, unit) for name, unit in UNITS if seconds >= unit), UNITS[-1])
    number = f"{seconds / unit:.2g}" if seconds < 1000 * HOPELESS else f"{seconds / unit:.0e}"
    return f"about {number} {name}{'s' * (number != '1')}"
