"""What eigenvalues say, in words; zeros counted and named apart, as they are no sign of instability.

cyclic       positions on which no rate depends
rolling      at rest, as many as there are more positions than velocities: it stays where it is put
drifting     velocities that no rate of a velocity depends on, once cyclic positions are left out: conserved momenta
family       other states that A maps to nothing: equilibria, or steady motions, next to this one
undecided    the rest: of these the linear motion tells nothing
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from symdyn.linear.linearization import Linearization
from symdyn.linear.modes import NOTHING, balance, spectrum, untouched
from symdyn.rounding import in_digits

ZEROS = {
    "cyclic": "of cyclic positions, on which nothing depends",
    "rolling": "of rolling at rest, which has more positions than velocities",
    "drifting": "of momenta that nothing changes, so that it drifts",
    "family": "of a family that it belongs to, others like it being next to it",
    "undecided": "of which the linear motion tells nothing",
}
"""Kinds of eigenvalues that are zero."""


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


def stability(found: Linearization) -> Stability:
    """Return what the eigenvalues of a system say."""
    zeros, names = _zeros(found)
    all_of_it = found.spectrum
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


def _zeros(found: Linearization) -> tuple[dict[str, int], tuple[str, ...]]:
    """Return how many eigenvalues of each kind are zero, and the cyclic positions."""
    left, names = found.spectrum.zeros, found.cyclic
    counts: dict[str, int] = {}
    p, m = found.positions, len(found.states) - found.positions
    rolling = p - m if found.kind == "rest" else 0
    rest = [k for k in range(len(found.states)) if k >= p or found.states.names[k] not in names]
    A = found.A[np.ix_(rest, rest)]
    scale = balance(A)
    A = A * scale[None, :] / scale[:, None]
    size = float(np.abs(A).max(initial=0.0))
    drifting = m - (int(np.linalg.matrix_rank(A[len(rest) - m :], tol=NOTHING * size)) if size else 0)
    for kind, count in (
        ("rolling", rolling),
        ("cyclic", len(names) - rolling),
        ("family", found.family),
        ("drifting", drifting if found.kind == "rest" else 0),
        ("family", _neighbours(found, names) if found.kind == "steady" else 0),
    ):
        some = min(left, max(0, count))
        counts[kind] = counts.get(kind, 0) + some
        left -= some
    counts["undecided"] = left
    return {kind: counts[kind] for kind in ZEROS if counts[kind]}, names


def _neighbours(found: Linearization, names: tuple[str, ...]) -> int:
    """Return how many ways lead to other steady motions: of another speed, on another circle, in another heading."""
    rest, p = [k for k in range(len(found.states)) if k >= found.positions or found.states.names[k] not in names], 0
    while more := untouched(found.A[np.ix_(rest, rest)], [i for i, k in enumerate(rest) if k < found.positions]):
        p += len(more)
        rest = [k for i, k in enumerate(rest) if i not in more]
    return p + int(spectrum(found.A[np.ix_(rest, rest)]).still.shape[1])
