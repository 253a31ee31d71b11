"""What was tried, how often and how long, and the smallest case of everything that was found."""

from __future__ import annotations

import re
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

from .cases import VERBS, Case, verbs
from .judge import Verdict
from .minimise import minimised


class Report:
    """What was tried, and the smallest case of everything that was found."""

    def __init__(self, seed: str, make: Callable[[int], Case]) -> None:
        """Begin for the cases of a seed, which `make` gives by number."""
        self.seed, self.make = seed, make
        self.finds: dict[str, tuple[int, Case, Verdict]] = {}
        self.times: Counter[str] = Counter()
        self.counts: Counter[str] = Counter()
        self.read: Counter[str] = Counter()
        self.right: Counter[str] = Counter()
        self.spent: defaultdict[str, float] = defaultdict(float)
        self.longest: defaultdict[str, float] = defaultdict(float)
        self.start = time.monotonic()

    def add(self, number: int, verdict: Verdict) -> None:
        """Count a case."""
        verb = verdict.verb if verdict.verb in {**verbs(), **VERBS} else "(no verb)"
        self.counts[verb] += 1
        self.read[verb] += verdict.read
        self.right[verb] += verdict.status == 0
        self.spent[verb] += verdict.seconds
        self.longest[verb] = max(self.longest[verb], verdict.seconds)
        if not verdict.sign:
            return
        self.times[verdict.sign] += 1
        one, before = self.make(number), self.finds.get(verdict.sign)
        if before is None:
            print(f"case {self.seed}:{number}: {verdict.sign}", flush=True)
        if before is None or _size(one) < _size(before[1]):
            self.finds[verdict.sign] = number, one, verdict

    def show(self, keep: Path) -> None:
        """Print counts a verb, then minimise and write every find."""
        total, read = self.counts.total(), self.read.total()
        print(f"\n{'verb':20}{'cases':>9}{'scene read':>12}{'exit 0':>9}{'mean, ms':>11}{'longest, s':>12}")
        for verb, cases in self.counts.most_common():
            mean, longest = self.spent[verb] / cases * 1e3, self.longest[verb]
            print(f"{verb:20}{cases:9}{self.read[verb]:12}{self.right[verb]:9}{mean:11.1f}{longest:12.2f}")
        spent = sum(self.spent.values())
        print(f"{'all':20}{total:9}{read:12}{self.right.total():9}{spent / max(1, total) * 1e3:11.1f}")
        print(f"{read / max(1, total):.1%} of cases are scenes that are read; seed {self.seed}; ", end="")
        print(f"{time.monotonic() - self.start:.0f} s, {spent:.0f} s of the processor; {len(self.finds)} faults")
        for sign, (number, one, verdict) in sorted(self.finds.items(), key=lambda find: -self.times[find[0]]):
            small = minimised(one, sign)
            keep.mkdir(parents=True, exist_ok=True)
            path = keep / (re.sub(r"\W+", "_", sign).strip("_")[:90] + ".json")
            path.write_text(small.text() + "\n", encoding="utf-8")
            times = f"{self.times[sign]} times, kept {self.seed}:{number}, {_size(small)} bytes"
            print(f"\n{sign}: {times}: {path}")
            print("    " + verdict.words.strip().replace("\n", "\n    ")[-1500:])


def _size(one: Case) -> int:
    return len(one.text())
