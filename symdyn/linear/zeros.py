"""Eigenvalues that are zero, counted by what they come from; they are no modes, and no sign of instability.

cyclic       positions on which no rate depends
rolling      at rest, as many as there are more positions than velocities: it stays where it is put
drifting     velocities that no rate of a velocity depends on, once cyclic positions are left out: conserved momenta
family       other states that A maps to nothing: equilibria, or steady motions, next to this one
undecided    the rest: of these the linear motion tells nothing
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symdyn.algebra import Array
from symdyn.linear.modes import NOTHING, balance, spectrum

ZEROS = {
    "cyclic": "of cyclic positions, on which nothing depends",
    "rolling": "of rolling at rest, which has more positions than velocities",
    "drifting": "of momenta that nothing changes, so that it drifts",
    "family": "of a family that it belongs to, others like it being next to it",
    "undecided": "of which the linear motion tells nothing",
}
"""Kinds of eigenvalues that are zero."""


def zeros(A: Array, count: int, positions: int, cyclic: Sequence[int], family: int, kind: str) -> dict[str, int]:
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
