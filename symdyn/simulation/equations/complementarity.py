"""Laws of contacts in numbers: which mode follows, and what an impact does.

    ξ = D λ + d - target               what gaps and slips do, beside what they should
    held   ξn = 0, λn ≥ offset         free   λn = offset, ξn ≥ 0
    stick  ξt = 0, |λt| ≤ μs λn        slip   λt = -z μ λn, z ξt ≥ 0, z = ±1

Accelerations: d = W a + γ, λ forces. Impacts: d = W u, λ impulses; Newton's law aims at -e ġ⁻. By Poisson's law there
are two: compression aims at 0, and expansion begins with e times its normal impulse, so that it may end with ġ⁺ > 0.

Of few contacts all cases are tried, so that every solution is found, and that there is none, or more than one, is told.
There are 4ᵏ of k contacts: of more, Lemke's pivots find one, from one linear complementarity problem:

    w = A z + b,  w ≥ 0, z ≥ 0, w·z = 0
    z = (λn - offset, λR, ξL)    w = (ξn, ξR, λL)    λR = μ λn + λt,  λL = μ λn - λt,  ξt = ξR - ξL

What slips already has λt = -z μ λn in place of the last two rows; dry friction of a joint has no first one, and F in
place of μ λn. Where friction is larger at rest, it is that of rest here.

References: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 6 and 8; Cottle, Pang and
Stone, The Linear Complementarity Problem (1992), section 4.4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from symdyn.algebra import Array

FEW = 2
"""Contacts of which all cases are tried."""

PIVOTS = 500
"""Pivots at most."""

CLOSE = 1e-9
"""What is smaller, over the largest of its kind, is zero."""


def least(A: Array, b: Array) -> Array:
    """Return the x of least size with A x as close to b as can be, shape (m,)."""
    if A.shape == (1, 1):
        return np.asarray(b / A[0] if A[0, 0] else np.zeros(1), dtype=np.float64)
    return np.asarray(np.linalg.lstsq(A, b, rcond=1e-12)[0], dtype=np.float64)


@dataclass(frozen=True)
class Case:
    """What one contact does: whether it is held, and how its slip is: "stick", 1, -1, or 0 without friction.

    What is `moving` slips already, so that nothing is asked of ξt, or opens where its force passes zero, so that ξn is
    zero but for rounding.
    """

    held: bool
    slip: float | str = 0.0
    moving: bool = False


FREE, OPENS = Case(False), Case(False, moving=True)

ROUNDS = 1e-7
"""An acceleration, over the largest one or 1, that is zero where a force passes zero."""


@dataclass(frozen=True)
class Laws:
    """Contacts at a state.

    Attributes:
        D: Delassus' matrix, shape (m, m): per unit of force, or of impulse.
        normals, tangents: the row of each contact's n, and of its t; None without friction, and of dry friction of a
            joint, which has no n.
        friction, static, restitution: of each; without n the largest forces themselves.
    """

    D: Array
    normals: tuple[int | None, ...]
    tangents: tuple[int | None, ...]
    friction: Array
    static: Array
    restitution: Array

    def solutions(
        self, d: Array, options: Sequence[Sequence[Case]], offset: Array | None = None, target: Array | None = None
    ) -> Iterator[tuple[tuple[Case, ...], Array]]:
        """Yield cases, one for each contact, and λ, shape (m,), that keep all laws."""
        shift = np.zeros(len(self.normals)) if offset is None else offset
        goal = np.zeros(len(d)) if target is None else target
        for cases in product(*options):
            A, b = self.D.copy(), goal - d
            for k, case in enumerate(cases):
                n, t = self.normals[k], self.tangents[k]
                if n is not None and not case.held:
                    A[n], b[n] = np.eye(len(d))[n], shift[k]
                if t is not None and case.slip != "stick":
                    A[t], b[t] = np.eye(len(d))[t], 0.0
                    limit = float(case.slip) * self.friction[k]
                    if n is None:
                        b[t] = -limit
                    else:
                        A[t, n] = limit
            found = least(A, b)
            if self._kept(cases, found, np.asarray(A @ found - b), self.D @ found + d - goal, shift):
                yield cases, found

    def _kept(self, cases: Sequence[Case], found: Array, missed: Array, xi: Array, shift: Array) -> bool:
        small, slow = CLOSE * (1e-300 + np.abs(found).max()), CLOSE * (1e-300 + np.abs(xi).max(initial=0.0))
        slow = max(slow, CLOSE * np.abs(self.D @ found).max())
        if np.abs(missed).max() > 10 * max(small, slow):
            return False
        for k, case in enumerate(cases):
            n, t = self.normals[k], self.tangents[k]
            zero = ROUNDS * max(1.0, float(np.abs(xi).max())) if case == OPENS else slow
            if n is not None and (found[n] < shift[k] - small or xi[n] < -zero):
                return False
            if t is None or (n is not None and found[n] == 0.0):
                continue
            largest = self.static[k] * (1.0 if n is None else found[n])
            if case.slip == "stick" and abs(found[t]) > largest + small:
                return False
            if case.slip in (1.0, -1.0) and not case.moving and float(case.slip) * xi[t] < -slow:
                return False
        return True

    def slips(self, k: int) -> tuple[Case, ...]:
        """Return how it may be held, before anything is known of its slip."""
        every = (0.0,) if self.tangents[k] is None else ("stick", 1.0, -1.0)
        return tuple(Case(True, one) for one in every)

    def impact(self, v: Array, by_poisson: Sequence[bool]) -> Array:
        """Return the impulses, shape (m,), of contacts that touch, from v = W u⁻; each by its law.

        Raises:
            ArithmeticError: no impulses keep the laws.
        """
        options = [(FREE, *self.slips(k)) for k in range(len(self.normals))]
        target, offset = np.zeros(len(v)), np.zeros(len(self.normals))
        rows = [n for n in self.normals if n is not None]
        assert len(rows) == len(self.normals), "dry friction of joints gives no impulse"
        for k, n in enumerate(rows):
            target[n] = 0.0 if by_poisson[k] else -self.restitution[k] * v[n]
        sliding = replace(self, static=self.friction)
        first = sliding._least(v, options, offset, target)
        if not any(by_poisson):
            return first
        offset = np.array([first[n] * self.restitution[k] * by_poisson[k] for k, n in enumerate(rows)])
        if not offset.any():
            return first
        more = [
            tuple(Case(held, slip.slip) for held in (False, True) for slip in self.slips(k))
            for k in range(len(self.normals))
        ]
        return first + sliding._least(v + self.D @ first, more, offset, np.zeros(len(v)))

    def by_pivots(self, d: Array, slides: Sequence[float], offset: Array, target: Array) -> Array | None:
        """Return λ, shape (m,), of one solution by Lemke's method, None where it ends without; `slides` are z, else 0.

        ξ is D λ + d - target.
        """
        k, m = len(self.normals), len(d)
        mu = np.where(np.array(slides) == 0.0, self.static, self.friction)
        to_forces = list[Array]()  # λ = Σ z · column + fixed
        fixed = np.zeros(m)
        names = list[tuple[int, str]]()
        for i in range(k):
            n, t = self.normals[i], self.tangents[i]
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
        xi, rest = self.D @ Z, self.D @ fixed + d - target
        A, b = np.zeros((len(names), len(names))), np.zeros(len(names))
        for row, (i, what) in enumerate(names):
            n, t = self.normals[i], self.tangents[i]
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

    def _least(self, v: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array) -> Array:
        if len(self.normals) > FEW:
            one = self.by_pivots(v, [0.0] * len(self.normals), offset, target)
            if one is None:
                raise ArithmeticError("no impulses keep the laws of its impact")
            return one
        found = [impulses for _, impulses in self.solutions(v, options, offset, target)]
        if not found:
            raise ArithmeticError("no impulses keep the laws of its impact")
        return min(found, key=lambda one: float(np.abs(one).sum()))


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
