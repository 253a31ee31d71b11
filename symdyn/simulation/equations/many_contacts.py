"""Many contacts in numbers: Lemke's pivots where each slips along one direction, projections where one slips any way.

    w = A z + b,  w ≥ 0, z ≥ 0, w·z = 0
    z = (λn - offset, λR, ξL)    w = (ξn, ξR, λL)    λR = μ λn + λt,  λL = μ λn - λt,  ξt = ξR - ξL

What slips already has λt = -z μ λn in place of the last two rows; dry friction of a joint has no first one, and F in
place of μ λn. Where friction is larger at rest, it is that of rest here. Projections pass D contact by contact, and
bring every force back into its cone.

References: Cottle, Pang and Stone, The Linear Complementarity Problem (1992), section 4.4; Acary and Brogliato,
Numerical Methods for Nonsmooth Dynamical Systems (2008), chapter 13.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array

if TYPE_CHECKING:
    from symdyn.simulation.equations.complementarity import Laws

PIVOTS = 500
"""Pivots at most."""

CLOSE = 1e-9
"""A change, over the largest force, behind which projections end."""


def pivoted(laws: Laws, d: Array, slides: Sequence[float], offset: Array, target: Array) -> Array | None:
    """Return λ, shape (m,), of one solution by Lemke's method, None where it ends without; `slides` are z, else 0.

    ξ is D λ + d - target.
    """
    k, m = len(laws.normals), len(d)
    tangents = [next(iter(along), None) for along in laws.tangents]
    mu = np.where(np.array(slides) == 0.0, laws.static, laws.friction)
    to_forces = list[Array]()  # λ = Σ z · column + fixed
    fixed = np.zeros(m)
    names = list[tuple[int, str]]()
    for i in range(k):
        n, t = laws.normals[i], tangents[i]
        if n is not None:
            column = np.zeros(m)
            column[n] = 1.0
            if t is not None:
                column[t] = -mu[i] if not slides[i] else -slides[i] * mu[i]
            fixed += offset[i] * column
            to_forces.append(column)
            names.append((i, "normal"))
        elif t is not None:
            fixed[t] = -mu[i] if not slides[i] else -slides[i] * mu[i]
        if t is not None and not slides[i]:
            column = np.zeros(m)
            column[t] = 1.0
            to_forces += [column, np.zeros(m)]
            names += [(i, "right"), (i, "left")]
    Z = np.array(to_forces).T.reshape(m, len(names))
    xi, rest = laws.D @ Z, laws.D @ fixed + d - target
    A, b = np.zeros((len(names), len(names))), np.zeros(len(names))
    for row, (i, what) in enumerate(names):
        n, t = laws.normals[i], tangents[i]
        if what == "normal":
            A[row], b[row] = xi[n], rest[n]
        elif what == "right":
            A[row], b[row] = xi[t], rest[t]
            A[row, row + 1] = 1.0
        else:
            A[row, row - 1] = -1.0
            b[row] = 2 * mu[i] * (1.0 if n is None else offset[i])
            if n is not None:
                A[row, row - 2] = 2 * mu[i]
    found = lemke(A, b)
    return None if found is None else Z @ found + fixed


def projected(laws: Laws, d: Array, offset: Array, target: Array, sweeps: int) -> Array:
    """Return λ to which projections come, shape (m,)."""
    found = np.zeros(len(d))
    for _ in range(sweeps):
        before = found.copy()
        for k, n in enumerate(laws.normals):
            along = list(laws.tangents[k])
            if n is None or not laws.D[n, n]:
                continue
            found[n] = max(offset[k], found[n] - (laws.D[n] @ found + d[n] - target[n]) / laws.D[n, n])
            if along:
                pushed = found[along] - (laws.D[along] @ found + d[along]) / laws.D[along, along].max()
                size, most = float(np.linalg.norm(pushed)), laws.static[k] * found[n]
                found[along] = pushed * min(1.0, most / max(size, 1e-300))
        if np.abs(found - before).max() <= CLOSE * np.abs(found).max():
            break
    return found


def lemke(A: Array, b: Array) -> Array | None:
    """Return z ≥ 0 with w = A z + b ≥ 0 and w·z = 0, shape (n,); None where the pivots end on a ray.

    Ties are broken by the lexicographic rule, so that it ends.
    """
    n = len(b)
    if not n or b.min() >= 0:
        return np.zeros(n)
    T = np.hstack([np.eye(n), -A, -np.ones((n, 1)), b.reshape(-1, 1)])
    basis, enter, row = list(range(n)), 2 * n, int(np.argmin(b))
    for _ in range(PIVOTS):
        T[row] /= T[row, enter]
        others = np.arange(n) != row
        T[others] -= np.outer(T[others, enter], T[row])
        leaves, basis[row] = basis[row], enter
        if leaves == 2 * n:
            found = np.zeros(2 * n + 1)
            found[basis] = T[:, -1]
            return np.maximum(found[n : 2 * n], 0.0)
        enter = leaves + n if leaves < n else leaves - n
        able = np.flatnonzero(T[:, enter] > 1e-12)
        if not len(able):
            return None
        ratios = T[able, -1] / T[able, enter]
        ties = able[ratios <= ratios.min() + 1e-13 * (1 + abs(ratios.min()))]
        last = [int(i) for i in ties if basis[i] == 2 * n]
        row = last[0] if last else min(map(int, ties), key=lambda i: tuple(T[i, :n] / T[i, enter]))
    return None
