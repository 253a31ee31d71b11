"""What eigenvalues say, in words; zeros counted and named apart, as they are no sign of instability (`zeros`)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from symdyn.linear.zeros import ZEROS
from symdyn.rounding import in_digits

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


@dataclass(frozen=True)
class Stability:
    """A verdict.

    Attributes:
        zeros: how many eigenvalues of each kind of `ZEROS` are zero, kinds that there are.
        names: positions that are cyclic.
        verdict: "stable", "unstable", "oscillating" (neither grows nor decays) or "undecided".
        words: one line.
    """

    zeros: dict[str, int]
    names: tuple[str, ...]
    verdict: str
    words: str

    @property
    def lines(self) -> tuple[str, ...]:
        """What is said of eigenvalues that are zero, a line for each kind; they stand beside the modes everywhere."""
        found = []
        for kind, count in self.zeros.items():
            names = f" ({', '.join(self.names)})" if kind == "cyclic" else ""
            found.append(f"{count} eigenvalue{'s' * (count > 1)} zero {ZEROS[kind]}{names}")
        return tuple(found)


def stability(system: Linearization) -> Stability:
    """Return what the eigenvalues of a system say."""
    zeros, names = system.zeros, system.cyclic
    all_of_it = system.spectrum
    apart = " apart from what is zero" if zeros else ""
    if all_of_it.growing:
        fastest = all_of_it.growing[0].value.real
        count = sum(2 if mode.oscillates else 1 for mode in all_of_it.growing)
        many = "one eigenvalue has" if count == 1 else f"{count} eigenvalues have"
        words = f"unstable: {many} a positive real part; the fastest doubles in {in_digits(math.log(2) / fastest, 3)} s"
        return Stability(zeros, names, "unstable", words)
    if "undecided" in zeros:
        return Stability(zeros, names, "undecided", "undecided to first order: an eigenvalue is zero, none grows")
    if not all_of_it.modes:
        return Stability(zeros, names, "oscillating", "all eigenvalues are zero: it stays, or drifts on")
    if len(all_of_it.decaying) == len(all_of_it.modes):
        words = f"asymptotically stable{apart}: all {'other ' if zeros else ''}eigenvalues have negative real parts"
        return Stability(zeros, names, "stable", words)
    words = f"oscillates{apart}: to first order nothing grows, and not all decays"
    return Stability(zeros, names, "oscillating", words)
