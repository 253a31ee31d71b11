"""What was set out to be reached, and what was: ratios inside a round, medians over rounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Bar:
    """One line: what is compared, what was wanted, what was measured."""

    text: str
    wanted: str
    shown: str
    reached: bool | None
    """None where the bar is meant for another machine."""

    @property
    def verdict(self) -> str:
        """One word, or whose bar it is."""
        return {True: "reached", False: "**missed**", None: "another core's bar"}[self.reached]


FILLING = ("filling the result's array", "batch")
"""What writing so many numbers costs, whatever they are."""

ALONE = ("symdyn, arithmetic alone", "batch")
"""What computing them costs, where they stay in work space."""

OURS, PIN = ("symdyn", "state"), ("Pinocchio C++", "state")
BATCH, ROWS = ("symdyn", "batch"), ("symdyn, rows", "batch")
ID, M, FD = "inverse_dynamics", "mass_matrix", "forward_dynamics"

AT_LEAST = (
    ("inverse dynamics, scalar C, times Pinocchio C++", ID, PIN, OURS, 8.0),
    ("inverse dynamics, scalar C, times CasADi's C", ID, ("CasADi C", "state"), OURS, 1.25),
    ("inverse dynamics, batch, times Pinocchio C++", ID, PIN, BATCH, 50.0),
    ("inverse dynamics, batch, times heyoka on our graph", ID, ("heyoka, our graph", "batch"), BATCH, 1.4),
    ("forward dynamics, scalar C, times Pinocchio's ABA", FD, PIN, OURS, 9.0),
    ("forward dynamics, batch, times Pinocchio's ABA", FD, PIN, BATCH, 50.0),
    ("M, scalar C, times Pinocchio's CRBA", M, PIN, OURS, 5.0),
    ("NumPy module in batch, times Pinocchio C++", ID, PIN, ("symdyn, NumPy module", "batch"), 2.0),
    ("two threads, times one", ID, ROWS, ("symdyn, rows", "threads"), 1.9),
)
"""Text, output, the slower, the faster, and how many times at least."""

NEAR_FLOOR = (("arm7", 16.5), ("puma560", 11.6))
"""ns a state of inverse dynamics in batch, at most, on a core with one 512-bit multiplier: 1.18 times what the
multiplications alone took when the bar was set (271 and 172, and 23 for each of 6 and 5 sines with cosines; 14.0 ns for
the arm)."""


def bars(times: Sequence[Row], robot: str = "arm7", multipliers: int = 0) -> list[Bar]:
    """Return the bars for which everything was measured, on a core with so many 512-bit multipliers."""
    at = {(row["robot"], row["output"], row["peer"], row["way"]): row for row in times}
    found = []
    for text, output, slow, fast, least in AT_LEAST:
        pair = [at.get((robot, output, *one)) for one in (slow, fast)]
        if pair[0] and pair[1]:
            ratio = paired(pair[0], pair[1])
            found.append(Bar(text, f"≥ {least:g}", f"{ratio:.2f}", ratio >= least))
    for robot_of, most in NEAR_FLOOR:
        many = at.get((robot_of, ID, *BATCH))
        if many:
            text = f"inverse dynamics of {robot_of}, batch, on a core with one 512-bit multiplier"
            reached = many["median"] <= most if multipliers == 1 else None
            found.append(Bar(text, f"≤ {most:g} ns", f"{many['median']:.1f} ns, with {multipliers}", reached))
    for output in (ID, M, FD):
        pair = [at.get((robot, output, peer, "million")) for peer in ("symdyn, ufunc", "symdyn, rows")]
        if pair[0] and pair[1]:
            ratio = paired(pair[0], pair[1])
            text = f"{output}, ufunc with a million states, times C on the same arrays"
            found.append(Bar(text, "≤ 1.15", f"{ratio:.2f}", ratio <= 1.15))
    single = at.get((robot, ID, "symdyn, ufunc", "python"))
    if single:
        time = single["median"]
        found.append(Bar("inverse dynamics, ufunc with one state", "< 900 ns", f"{time:.0f} ns", time < 900))
    for robot_of in ("tree32", "chain32"):
        filled, one, alone = (at.get((robot_of, M, *kind)) for kind in (FILLING, OURS, ALONE))
        for kind, words in ((BATCH, "columns"), (ROWS, "rows")):
            many = at.get((robot_of, M, *kind))
            if filled and one and many:
                text = f"M of {robot_of} in batch, {words}, times"
                ratio = paired(many, filled)
                floor = f" (floor {1 + paired(alone, filled):.2f})" if alone else ""
                found.append(Bar(f"{text} filling the same array", "≤ 1.3", f"{ratio:.2f}{floor}", ratio <= 1.3))
                if alone:
                    both = [a + b for a, b in zip(alone["samples"], filled["samples"], strict=True)]
                    ratio = median(a / b for a, b in zip(many["samples"], both, strict=True))
                    floor = f"{text} arithmetic alone and then filling"
                    found.append(Bar(floor, "≤ 1.3", f"{ratio:.2f}", ratio <= 1.3))
                ratio = paired(many, one)
                found.append(Bar(f"{text} one state a call", "≤ 1", f"{ratio:.2f}", ratio <= 1))
    for output in (ID, FD):
        for way, most in (("state", 1.5), ("batch", 1.3)):
            pair = [at.get((f"chain{n}", output, "symdyn", way)) for n in (8, 64)]
            if pair[0] and pair[1]:
                growth = (pair[1]["median"] / 64) / (pair[0]["median"] / 8)
                text = f"{output}, {way}: time a joint of a chain of 64, times that of 8"
                few, many = (row.get("operations", 0) for row in pair)
                counted = f" (by count {many / 64 / (few / 8):.2f})" if few else ""
                found.append(Bar(text, f"≤ {most:g}", f"{growth:.2f}{counted}", growth <= most))
    return found


def paired(slow: Row, fast: Row) -> float:
    """Return how many times longer `slow` takes: the median of the ratios inside a round."""
    return median(a / b for a, b in zip(slow["samples"], fast["samples"], strict=True))


def at_most(text: str, most: float, value: float, unit: str = "") -> Bar:
    """Return the bar of a figure."""
    return Bar(text, f"≤ {most:g} {unit}".strip(), f"{value:.3g} {unit}".strip(), value <= most)


def at_least(text: str, least: float, value: float, unit: str = "") -> Bar:
    """Return the bar of what the more the better."""
    return Bar(text, f"≥ {least:g} {unit}".strip(), f"{value:.3g} {unit}".strip(), value >= least)


def told(found: Sequence[Bar]) -> int:
    """Print bars, a line each; return 1 where one is missed, else 0."""
    for bar in found:
        print(f"{bar.text}: {bar.shown} ({bar.wanted}), {bar.verdict}")
    return int(any(bar.reached is False for bar in found))


def in_time(text: str, most: float, seconds: float) -> Bar:
    """Return the bar of what shall take `most` seconds at most."""
    return Bar(text, f"≤ {most:g} s", f"{seconds:.3f} s", seconds <= most)
