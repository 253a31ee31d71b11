"""Laws of contacts in numbers: which mode follows, and what an impact does.

    ξ = D λ + d - target               what gaps and slips do, beside what they should
    held   ξn = 0, λn ≥ offset         free   λn = offset, ξn ≥ 0
    stick  ξt = 0, |λt| ≤ μs λn        slip   λt = -z μ λn, z ξt ≥ 0, z = ±1

Accelerations: d = W a + γ, λ forces. Impacts: d = W u, λ impulses; Newton's law aims at -e ġ⁻. By Poisson's law there
are two: compression aims at 0, and expansion begins with e times its normal impulse, so that it may end with ġ⁺ > 0.

All cases are tried, so that every solution is found, and that there is none, or more than one, is told. There are 4ᵏ
of k contacts.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 6 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from symdyn.algebra import Array

CLOSE = 1e-9
"""What is smaller, over the largest of its kind, is zero."""


@dataclass(frozen=True)
class Case:
    """What one contact does: whether it is held, and how its slip is: "stick", 1, -1, or 0 without friction.

    What is `moving` slips already, so that nothing is asked of ξt.
    """

    held: bool
    slip: float | str = 0.0
    moving: bool = False


FREE = Case(False)


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
            found = np.linalg.lstsq(A, b, rcond=1e-12)[0]
            if self._kept(cases, found, A @ found - b, self.D @ found + d - goal, shift):
                yield cases, found

    def _kept(self, cases: Sequence[Case], found: Array, missed: Array, xi: Array, shift: Array) -> bool:
        small, slow = CLOSE * (1e-300 + np.abs(found).max()), CLOSE * (1e-300 + np.abs(xi).max(initial=0.0))
        slow = max(slow, CLOSE * np.abs(self.D @ found).max())
        if np.abs(missed).max() > 10 * max(small, slow):
            return False
        for k, case in enumerate(cases):
            n, t = self.normals[k], self.tangents[k]
            if n is not None and (found[n] < shift[k] - small or xi[n] < -slow):
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

    def _least(self, v: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array) -> Array:
        found = [impulses for _, impulses in self.solutions(v, options, offset, target)]
        if not found:
            raise ArithmeticError("no impulses keep the laws of its impact")
        return min(found, key=lambda one: float(np.abs(one).sum()))
