"""Many contacts in numbers: Lemke's pivots where each slips along one direction, projections where one slips any way.

    w = A z + b,  w ≥ 0, z ≥ 0, w·z = 0
    z = (λn - offset, λ+, λ-, σ)    w = (ξn, σ + ξt, σ - ξt, μ λn - λ+ - λ-)    λt = λ+ - λ-,  σ = |ξt| where it slips

z·A z = λ·D λ + μ σ·λn is never negative, so that pivots end at a solution where no slip is decided yet, if D is regular
or d = W u. (With three unknowns, λn and μ λn ± λt, they may end on a ray beside one.) What slips already has
λt = -z μ λn in place of the last three rows; dry friction of a joint has no first one, and F in place of μ λn. Where
friction is larger at rest, it is that of rest here. Units are chosen, powers of two, in which the diagonal of D and the
largest of d are near one. Projections pass D contact by contact, and bring every force back into its cone.

References: Cottle, Pang and Stone, The Linear Complementarity Problem (1992), section 4.4; Anitescu and Potra,
Nonlinear Dynamics 14 (1997) 231; Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008),
chapter 13.
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
    unit = np.ldexp(1.0, (-np.frexp(np.diag(laws.D))[1] / 2).astype(int))
    b = unit * (d - target)
    size = np.ldexp(1.0, np.frexp(np.abs(b).max(initial=0.0))[1])
    forces, rows = list[Array](), list[Array]()  # λ = Σ z · column + fixed, and of which ξ a row of w is made
    coupled, fixed, free = list[tuple[int, int, float]](), np.zeros(len(d)), list[float]()
    for i, slide in enumerate(slides):
        n, t = laws.normals[i], next(iter(laws.tangents[i]), None)
        mu = float((laws.friction if slide else laws.static)[i])
        least = 1.0 / size if n is None else offset[i] / (unit[n] * size)
        if t is not None:
            mu *= (1.0 if n is None else unit[n]) / unit[t]
        e, slips = np.eye(len(d)), 0.0 if t is None else -slide * mu
        if n is not None:
            fixed[n] = least
            forces.append(e[n] if t is None else e[n] + slips * e[t])
            rows.append(e[n])
            free.append(0.0)
        if t is not None:
            fixed[t] = slips * least
        if t is not None and not slide:
            at = len(rows)
            forces += [e[t], -e[t], 0.0 * e[t]]
            rows += [e[t], -e[t], 0.0 * e[t]]
            free += [0.0, 0.0, mu * least]
            coupled += [(at, at + 2, 1.0), (at + 1, at + 2, 1.0), (at + 2, at, -1.0), (at + 2, at + 1, -1.0)]
            coupled += [] if n is None else [(at + 2, at - 1, mu)]
    Z, R = (np.array(some).reshape(len(rows), len(d)) for some in (forces, rows))
    D = unit[:, None] * laws.D * unit
    A = R @ D @ Z.T
    for row, column, value in coupled:
        A[row, column] += value
    found = lemke(A, R @ (D @ fixed + b / size) + free)
    return None if found is None else unit * size * (found @ Z + fixed)


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
        ties = able[ratios <= ratios.min() + 1e-12 * (1 + abs(ratios.min()))]
        last = [int(i) for i in ties if basis[i] == 2 * n]
        row = last[0] if last else min(map(int, ties), key=lambda i: tuple(T[i, :n] / T[i, enter]))
    return None
