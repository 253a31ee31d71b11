"""The stability that eigenvalues show, and what those that are zero come from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.linear.modes import NOTHING, balance, spectrum
from symdyn.linear.plots import Answer
from symdyn.rounding import in_digits

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


ZEROS = {
    "cyclic": "of cyclic positions, on which nothing depends",
    "rolling": "of rolling at rest, which has more positions than velocities",
    "drifting": "of momenta that nothing changes, so that it drifts",
    "family": "of a family that it belongs to, others like it being next to it",
    "undecided": "of which the linear motion tells nothing",
}
"""Kinds of eigenvalues that are zero."""


def zero_kinds(A: Array, count: int, positions: int, cyclic: Sequence[int], family: int, kind: str) -> dict[str, int]:
    """Return how many eigenvalues of each kind are zero, kinds that there are.

    Args:
        A: shape (nx, nx).
        count: of all that are zero.
        positions: p, how many states are positions; they come first.
        cyclic: places of those that are.
        family: how many more directions lead to other equilibria.
        kind: "rest", "steady" or "moving".
    """
    left, counts = count, dict[str, int]()
    p, m = positions, len(A) - positions
    rolling = p - m if kind == "rest" else 0
    rest = [k for k in range(len(A)) if k not in cyclic]
    part = A[np.ix_(rest, rest)]
    scale = balance(part)
    part = part * scale[None, :] / scale[:, None]
    size = float(np.abs(part).max(initial=0.0))
    drifting = m - (int(np.linalg.matrix_rank(part[len(rest) - m :], tol=NOTHING * size)) if size else 0)
    for of, most in (
        ("rolling", rolling),
        ("cyclic", len(cyclic) - rolling),
        ("family", family),
        ("drifting", drifting if kind == "rest" else 0),
        ("family", _neighbours(A[np.ix_(rest, rest)], sum(k < p for k in rest)) if kind == "steady" else 0),
    ):
        some = min(left, max(0, most))
        counts[of] = counts.get(of, 0) + some
        left -= some
    counts["undecided"] = left
    return {of: counts[of] for of in ZEROS if counts[of]}


def _neighbours(A: Array, positions: int) -> int:
    """Return how many ways lead to other steady motions: of another speed, on another circle, in another heading.

    Directions of positions on which nothing depends come first, along states or oblique to them, as of what spins about
    an axis that is none of its body's own.
    """
    scale = balance(A)
    left, p = A * scale[None, :] / scale[:, None], positions
    size, found = float(np.abs(left).max(initial=0.0)), 0
    while p:
        _, values, rows = np.linalg.svd(left[:, :p])
        lost = p - int(np.sum(values > NOTHING * size))
        if not lost:
            break
        turn = np.eye(len(left))
        turn[:p, :p] = np.vstack([rows[p - lost :], rows[: p - lost]]).T
        left, p, found = (turn.T @ left @ turn)[lost:, lost:], p - lost, found + lost
    return found + int(spectrum(left).still.shape[1])


@dataclass(frozen=True)
class Stability(Answer):
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

    def __repr__(self) -> str:
        return "\n    ".join([f"<Stability: {self.words}", *self.lines]) + ">"

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
    zeros, names = system.zero_eigenvalues, system.cyclic
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
