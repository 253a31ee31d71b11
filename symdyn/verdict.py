"""What becomes of a claim: one of four verdicts, of which the first two hold; they are told here and nowhere else.

    proved              for all values, but for a chance of error that is said
    agrees in numbers   at the values that were looked at, as far as numbers tell
    fails               something else came out at one of them
    not shown           it was claimed, and nothing could be compared

Whoever makes a claim counts what was compared: nothing compared is never a claim that holds. What is no claim at all
stands apart with its reason: what does not apply there, what cannot be run on this machine, and what is looked at
nowhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum, nonmember
from typing import Any

from symdyn.frozen import asdict, dataclass


class Verdict(StrEnum):
    """One of the four, the worst first."""

    DIFFERENT = "fails"
    NOT_SHOWN = "not shown"
    NUMERICAL = "agrees in numbers"
    PROVED = "proved"

    __repr__ = str.__repr__

    HOLD = nonmember((PROVED, NUMERICAL))

    @staticmethod
    def of(compared: int, wrong: bool = False, proved: bool = False) -> Verdict:
        """Return what became of a claim.

        Args:
            compared: how many comparisons were made.
            wrong: whether one of them came out otherwise, or could not come out at all for what was claimed is missing.
            proved: whether they tell of all values.
        """
        if wrong:
            return Verdict.DIFFERENT
        if not compared:
            return Verdict.NOT_SHOWN
        return Verdict.PROVED if proved else Verdict.NUMERICAL

    @staticmethod
    def worst(verdicts: Iterable[str]) -> Verdict:
        """Return what became of several claims as one: the worst of their verdicts; of no claims nothing is shown."""
        found = set(verdicts)
        return next((one for one in Verdict if one in found), Verdict.NOT_SHOWN)


@dataclass(frozen=True)
class Judged:
    """What became of one claim, for reading."""

    what: str  # what was claimed
    verdict: str  # one of the four
    why: str = ""  # why it does not hold; "" where it does


@dataclass(frozen=True)
class Unclaimed:
    """What nothing is claimed of, and why that is so."""

    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.what}: {self.why}"


class NotLookedAt(Unclaimed):
    """What could be claimed, and was not looked at."""

    __slots__ = ()


class Claims:
    """Whatever makes claims: its verdict is the worst of theirs, and of no claims nothing is shown.

    Attributes:
        absent: what does not apply there, for the scene or a position has none.
        not_run: what cannot be run on this machine, and nobody asked for by name.
        not_looked_at: what was not looked at, beside what was shown.
    """

    absent: tuple[Unclaimed, ...]
    not_run: tuple[Unclaimed, ...]
    not_looked_at: tuple[Unclaimed, ...] = ()

    @property
    def claims(self) -> tuple[Judged, ...]:
        """What was claimed, and what became of it."""
        raise NotImplementedError

    @property
    def verdict(self) -> str:
        """One of the four: the worst of those on all claims."""
        return Verdict.worst(one.verdict for one in self.claims)

    @property
    def passed(self) -> bool:
        """Whether there are claims, and all of them hold."""
        return self.verdict in Verdict.HOLD

    @property
    def failed(self) -> tuple[Judged, ...]:
        """The claims that fail."""
        return tuple(one for one in self.claims if one.verdict == Verdict.DIFFERENT)

    @property
    def not_shown(self) -> tuple[Judged, ...]:
        """The claims of which nothing could be compared, and that there was none."""
        found = tuple(one for one in self.claims if one.verdict == Verdict.NOT_SHOWN)
        return found or (() if self.claims else (Judged("anything", Verdict.NOT_SHOWN, "nothing was claimed"),))

    @property
    def apart(self) -> dict[str, list[tuple[str, str]]]:
        """What is told beside claims that hold, under its heading: what, and why."""
        return {
            Verdict.DIFFERENT: [(one.what, one.why) for one in self.failed],
            Verdict.NOT_SHOWN: [(one.what, one.why) for one in self.not_shown],
            "does not apply": [(one.what, one.why) for one in self.absent],
            "not run": [(one.what, one.why) for one in self.not_run],
            "not looked at": [(one.what, one.why) for one in self.not_looked_at],
        }

    @property
    def lines(self) -> list[str]:
        """The same as lines of text."""
        return [f"{word.capitalize()}: {what}: {why}" for word, rows in self.apart.items() for what, why in rows]

    def _verdicts(self) -> dict[str, Any]:
        """Return what JSON says of all claims together."""
        failed, not_shown = ([asdict(one) for one in some] for some in (self.failed, self.not_shown))
        return {"failed": failed, "not_shown": not_shown, "verdict": self.verdict, "passed": self.passed}
