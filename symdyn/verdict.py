"""What becomes of a claim: one of four verdicts, of which the first two hold; they are told here and nowhere else.

    proved              for all values, but for a chance of error that is said
    agrees in numbers   at the values that were looked at, as far as numbers tell
    fails               something else came out at one of them
    not shown           it was claimed, and nothing could be compared

Whoever makes a claim counts what was compared: nothing compared is never a claim that holds. What is no claim at all
stands apart with its reason: what does not exist there, and what cannot be run on this machine.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

PROVED = "proved"
NUMERICAL = "agrees in numbers"
DIFFERENT = "fails"
NOT_SHOWN = "not shown"

HOLD = (PROVED, NUMERICAL)
WORST_FIRST = (DIFFERENT, NOT_SHOWN, NUMERICAL, PROVED)


def verdict(compared: int, wrong: bool = False, proved: bool = False) -> str:
    """Return what became of a claim.

    Args:
        compared: how many comparisons were made.
        wrong: whether one of them came out otherwise, or could not come out at all for what was claimed is missing.
        proved: whether they tell of all values.
    """
    if wrong:
        return DIFFERENT
    if not compared:
        return NOT_SHOWN
    return PROVED if proved else NUMERICAL


def together(verdicts: Iterable[str]) -> str:
    """Return what became of several claims as one: the worst of their verdicts; of no claims nothing is shown."""
    found = set(verdicts)
    return next((one for one in WORST_FIRST if one in found), NOT_SHOWN)


@dataclass(frozen=True)
class Judged:
    """What became of one claim, for reading.

    Attributes:
        what: was claimed.
        verdict: one of the four.
        why: it does not hold; "" where it does.
    """

    what: str
    verdict: str
    why: str = ""


@dataclass(frozen=True)
class Unclaimed:
    """What nothing is claimed of.

    Attributes:
        what: is not there, or is not run.
        why: that is so.
    """

    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.what}: {self.why}"
