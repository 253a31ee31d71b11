"""Laws of contacts in numbers: which mode follows, and what an impact does.

    ξ = D λ + d - target               what gaps and slips do, beside what they should
    held   ξn = 0, λn ≥ offset         free   λn = offset, ξn ≥ 0
    stick  ξt = 0, |λt| ≤ μs λn        slip   λt = -μ λn z, ξt = |ξt| z, z a sign or a unit vector

Accelerations: d = W a + γ, λ forces. Impacts: d = W u, λ impulses; Newton's law aims at -e ġ⁻. By Poisson's law there
are two: compression aims at 0, and expansion begins with e times its normal impulse, so that it may end with ġ⁺ > 0.

Of few contacts all cases are tried, so that every solution is found, and that there is none, or more than one, is told.
Where a contact may slip along two directions, Newton's method finds which, from several guesses. There are 4ᵏ cases of
k contacts of one direction: of more, Lemke's pivots find one, and projections of those that slip any way, see
many_contacts.py.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 6 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, product
from math import pi

import numpy as np

from symdyn.algebra import Array
from symdyn.frozen import dataclass, replace
from symdyn.simulation.equations.many_contacts import pivoted, projected

FEW = 2
"""Contacts of which all cases are tried."""

TURNS, SWEEPS, GUESSED = 60, 4000, 100
"""Steps of Newton's method for the directions of slips, of projections, and of those that only guess, at most."""

UNEVEN = 100.0
"""How much more than another a contact that sticks may take along the plane."""

EVENED = 12
"""Shares along the plane that are tried, at most."""

CLOSE = 1e-9
"""What is smaller, over the largest of its kind, is zero."""


def least(A: Array, b: Array) -> Array:
    """Return the x of least size with A x as close to b as can be, shape (m,)."""
    if A.shape == (1, 1):
        return np.asarray(b / A[0] if A[0, 0] else np.zeros(1), dtype=np.float64)
    return np.asarray(np.linalg.lstsq(A, b, rcond=1e-12)[0], dtype=np.float64)


@dataclass(frozen=True)
class Case:
    """What one contact does.

    What is free and sticks touches, though nothing presses there: others carry all, or it has just lifted off.

    Attributes:
        held: whether it is closed.
        slip: STICK, SLIP, or "" without friction.
        way: along which it slips, shape (1,) or (2,); () where that is to be found.
        moving: it slips already, so that nothing is asked of ξt, or opens where its force passes zero, so that ξn is
            zero but for rounding.
        yields: how much more than another it leaves to those that stick with it.
    """

    held: bool
    slip: str = ""
    way: tuple[float, ...] = ()
    moving: bool = False
    yields: float = 1.0

    @property
    def slips(self) -> bool:
        return self.slip == SLIP

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        way = self.way[0] if len(self.way) == 1 else float(self.slips)
        return float(self.held), float(self.slip == STICK), way, self.yields if self.held or self.slip else 0.0


STICK, SLIP = "stick", "slip"
FREE, OPENS = Case(False), Case(False, moving=True)
CARRIED, LIFTED = Case(False, STICK), Case(False, STICK, yields=0.0)

ROUNDS = 1e-7
"""An acceleration, over the largest one or 1, that is zero where a force passes zero."""


@dataclass(frozen=True)
class Laws:
    """Contacts at a state.

    Attributes:
        D: Delassus' matrix, shape (m, m): per unit of force, or of impulse.
        normals, tangents: the row of each contact's n, None of dry friction of a joint, and those of its t.
        friction, static, restitution: of each; without n the largest forces themselves.
    """

    D: Array
    normals: tuple[int | None, ...]
    tangents: tuple[tuple[int, ...], ...]
    friction: Array
    static: Array
    restitution: Array

    def solutions(
        self,
        d: Array,
        options: Sequence[Sequence[Case]],
        offset: Array | None = None,
        target: Array | None = None,
        near: Array | None = None,
    ) -> Iterator[tuple[tuple[Case, ...], Array]]:
        """Yield cases, one for each contact, and λ, shape (m,), that keep all laws; `near` is a guess of λ."""
        shift = np.zeros(len(self.normals)) if offset is None else offset
        goal = np.zeros(len(d)) if target is None else target
        if len(d) == 1 and self.normals[0] == 0:
            yield from self._of_one_row(options[0], float(d[0] - goal[0]), float(shift[0]))
            return
        if near is None and len(options) > 1 and any(case.slips and not case.way for some in options for case in some):
            near = projected(self, d, shift, goal, GUESSED)
        for cases in product(*options):
            for some in self._directed(cases, d - goal, shift, near):
                found, missed = self._solved(some, d - goal, shift)
                if self._kept(some, found, missed, self.D @ found + d - goal, shift):
                    yield some, found
                    break
                evened = self._evened(some, found)
                for _ in range(EVENED):
                    if evened is None:
                        break
                    found, missed = self._solved(evened, d - goal, shift)
                    if self._kept(evened, found, missed, self.D @ found + d - goal, shift):
                        break
                    evened = self._eased(evened, found)
                else:
                    continue
                if evened is not None:
                    yield evened, found
                    break

    def _of_one_row(self, options: Sequence[Case], d: float, shift: float) -> Iterator[tuple[tuple[Case, ...], Array]]:
        """Yield what `solutions` does, of one gap alone."""
        D = float(self.D[0, 0])
        for case in options:
            found = shift if not case.held else -d / D if D else 0.0
            xi, small = D * found + d, CLOSE * (1e-300 + abs(found))
            slow = CLOSE * max(1e-300 + abs(xi), D * abs(found))
            zero = ROUNDS * max(1.0, abs(xi)) if case == OPENS else slow
            missed = case.held and abs(xi) > 10 * max(small, slow)
            if found >= shift - small and xi >= -zero and not missed:
                yield (case,), np.array([found])

    def _system(self, cases: Sequence[Case], d: Array, shift: Array) -> tuple[Array, Array]:
        """Return A and b of A λ = b, which forces keep in some cases, all rows in the unit of ξ."""
        A, b = self.D.copy(), -d
        unit = np.where(np.diag(A) > 0.0, np.diag(A), 1.0)
        for k, case in enumerate(cases):
            n, along = self.normals[k], self.tangents[k]
            if n is not None and not case.held:
                A[n], b[n] = 0.0, unit[n] * shift[k]
                A[n, n] = unit[n]
            if case.slip == STICK:
                continue
            for t, way in zip(along, case.way or (0.0,) * len(along), strict=True):
                A[t], b[t] = 0.0, 0.0
                A[t, t] = unit[t]
                limit = unit[t] * way * self.friction[k]
                if n is None:
                    b[t] = -limit
                else:
                    A[t, n] = limit
        return A, b

    def _solved(self, cases: Sequence[Case], d: Array, shift: Array) -> tuple[Array, Array]:
        """Return λ of some cases, of least size, and what it misses."""
        A, b = self._system(cases, d, shift)
        size = np.ones(len(b))
        for along, case in zip(self.tangents, cases, strict=True):
            size[list(along)] = case.yields**-0.5
        found = size * least(A * size, b)
        return found, np.asarray(A @ found - b)

    def _evened(self, cases: tuple[Case, ...], found: Array) -> tuple[Case, ...] | None:
        """Return cases in which what sticks takes as much as its normal force lets it; None where one sticks alone.

        Where forces of least size pull, as of a ball between floor and wall, friction takes little before others.
        """
        rows = {k: n for k, n in enumerate(self.normals) if cases[k].slip == STICK and n is not None}
        stuck = {k: float(found[n]) for k, n in rows.items()}
        if len(stuck) < 2 or not any(stuck.values()):
            return None
        largest, pulls = max(stuck.values()), min(stuck.values()) < 0.0
        shares = {k: UNEVEN if pulls else largest / max(force, largest / UNEVEN) for k, force in stuck.items()}
        return tuple(replace(one, yields=shares.get(k, 1.0)) for k, one in enumerate(cases))

    def _eased(self, cases: tuple[Case, ...], found: Array) -> tuple[Case, ...] | None:
        """Return cases in which what is beyond its cone takes less beside the others; None where nothing is."""
        eased, beyond = list(cases), False
        for k, (n, along) in enumerate(zip(self.normals, self.tangents, strict=True)):
            most = 0.0 if n is None or cases[k].slip != STICK else float(self.static[k] * found[n])
            if most > 0.0:
                share = float(np.linalg.norm(found[list(along)])) / most
                beyond = beyond or share > 1.0
                yields = cases[k].yields * max(share, 1 / UNEVEN)
                eased[k] = replace(cases[k], yields=min(max(yields, 1 / UNEVEN), UNEVEN**2))
        return tuple(eased) if beyond else None

    def _directed(
        self, cases: tuple[Case, ...], d: Array, shift: Array, near: Array | None
    ) -> Iterator[tuple[Case, ...]]:
        """Yield cases in which every direction of a slip is known, one for each guess from which Newton finds some."""
        unknown = [k for k, case in enumerate(cases) if case.slips and not case.way]
        if not unknown:
            yield cases
            return
        stuck = tuple(replace(case, slip=STICK) if k in unknown else case for k, case in enumerate(cases))
        smooth = tuple(replace(case, slip="") if k in unknown else case for k, case in enumerate(cases))
        held, free = self._solved(stuck, d, shift)[0], self._solved(smooth, d, shift)[0]
        rates = self.D @ free + d
        ways = [rates, -held] if near is None else [-near, rates, -held]
        guesses = [[(way[i], way[j]) for i, j in (self.tangents[k] for k in unknown)] for way in ways]
        if len(unknown) == 1:
            guesses += [[way] for way in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))]
        for guess in guesses:
            angles = self._turned(cases, unknown, d, shift, np.array([np.arctan2(y, x) for x, y in guess]))
            if angles is None:
                continue
            some = self._along(cases, unknown, angles)
            yield some
            xi = self.D @ self._solved(some, d, shift)[0] + d
            back = [float(np.dot(some[k].way, xi[list(self.tangents[k])])) < 0.0 for k in unknown]
            if any(back):  # it is along a line, and friction would push
                angles = self._turned(cases, unknown, d, shift, angles + pi * np.array(back))
                if angles is not None:
                    yield self._along(cases, unknown, angles)

    @staticmethod
    def _along(cases: tuple[Case, ...], unknown: Sequence[int], angles: Array) -> tuple[Case, ...]:
        found = list(cases)
        for k, angle in zip(unknown, angles, strict=True):
            found[k] = replace(cases[k], way=(float(np.cos(angle)), float(np.sin(angle))))
        return tuple(found)

    def _turned(
        self, cases: tuple[Case, ...], unknown: Sequence[int], d: Array, shift: Array, angles: Array
    ) -> Array | None:
        """Return angles at which slips are along their directions, by Newton's method; None where it does not end."""
        for _ in range(TURNS):
            A, b = self._system(self._along(cases, unknown, angles), d, shift)
            inverse = np.linalg.pinv(A, rcond=1e-12)
            found = inverse @ b
            xi, change = self.D @ found + d, np.zeros((len(d), len(unknown)))
            z = np.array([np.cos(angles), np.sin(angles)])
            for j, k in enumerate(unknown):  # what λ changes by an angle
                n = self.normals[k]
                assert n is not None, "friction of two directions has a normal force"
                along = list(self.tangents[k])
                change[along, j] = -self.friction[k] * found[n] * A[along, along] * np.array([-z[1, j], z[0, j]])
            slopes = self.D @ inverse @ change
            across, turns = np.zeros(len(unknown)), np.zeros((len(unknown), len(unknown)))
            for j, k in enumerate(unknown):
                x, y = self.tangents[k]
                across[j] = z[0, j] * xi[y] - z[1, j] * xi[x]
                turns[j] = z[0, j] * slopes[y] - z[1, j] * slopes[x]
                turns[j, j] -= z[0, j] * xi[x] + z[1, j] * xi[y]
            step = least(turns, across)
            largest = float(np.abs(step).max())
            angles = angles - step * min(1.0, 0.7 / max(largest, 1e-300))
            if largest < 1e-14:
                return angles
        return angles if largest < 1e-9 else None

    def _kept(self, cases: Sequence[Case], found: Array, missed: Array, xi: Array, shift: Array) -> bool:
        small, slow = CLOSE * (1e-300 + np.abs(found).max()), CLOSE * (1e-300 + np.abs(xi).max(initial=0.0))
        slow = max(slow, CLOSE * float((np.abs(self.D) @ np.abs(found)).max()))  # rows that hold the same cancel
        if np.abs(missed).max() > 10 * max(small, slow):
            return False
        for k, case in enumerate(cases):
            n, along = self.normals[k], list(self.tangents[k])
            zero = ROUNDS * max(1.0, float(np.abs(xi).max())) if case == OPENS else slow
            if n is not None and (found[n] < shift[k] - small or xi[n] < -zero):
                return False
            if not along or (n is not None and found[n] == 0.0):
                continue
            largest = self.static[k] * (1.0 if n is None else found[n])
            if case.slip == STICK and float(np.linalg.norm(found[along])) > largest + small:
                return False
            if case.slips and not case.moving and np.dot(case.way, xi[along]) < -slow:
                return False
        return True

    def slips(self, k: int) -> tuple[Case, ...]:
        """Return how it may be held, before anything is known of its slip."""
        if self.static[k] == 0.0:
            return (Case(True),)
        every = (("",),), ((STICK,), (SLIP, (1.0,)), (SLIP, (-1.0,))), ((STICK,), (SLIP,))
        return tuple(Case(True, *one) for one in every[len(self.tangents[k])])

    def impact(
        self, v: Array, by_poisson: Sequence[bool], told: list[tuple[Case, ...]] | None = None, keep: bool = False
    ) -> Array:
        """Return the impulses, shape (m,), of contacts that touch, from v = W u⁻; each by its law.

        The cases of compression and expansion are put on a list that is given, or are taken from it and kept: so it is
        a smooth function next to an impact.

        Raises:
            ArithmeticError: no impulses keep the laws.
        """
        options = [(FREE, *self.slips(k)) for k in range(len(self.normals))]
        target, offset = np.zeros(len(v)), np.zeros(len(self.normals))
        rows = [n for n in self.normals if n is not None]
        assert len(rows) == len(self.normals), "dry friction of joints gives no impulse"
        for k, n in enumerate(rows):
            target[n] = 0.0 if by_poisson[k] else -self.restitution[k] * v[n]
        sliding, known = replace(self, static=self.friction), iter(told if told is not None and keep else ())

        def solved(d: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array) -> Array:
            if keep:
                cases = next(sliding._directed(next(known), d - target, offset, None))
                return sliding._solved(cases, d - target, offset)[0]
            found = sliding._least(d, options, offset, target)
            if told is not None:
                told.append(tuple(sliding.case(k, found, offset) for k in range(len(sliding.normals))))
            return found

        first = solved(v, options, offset, target)
        if not any(by_poisson):
            return first
        offset = np.array([first[n] * self.restitution[k] * by_poisson[k] for k, n in enumerate(rows)])
        if not offset.any():
            return first
        more = [
            tuple(replace(one, held=held) for held in (False, True) for one in self.slips(k))
            for k in range(len(self.normals))
        ]
        return first + solved(v + self.D @ first, more, offset, np.zeros(len(v)))

    def case(self, k: int, found: Array, offset: Array) -> Case:
        """Return what a contact does, from impulses; which way it slips along two directions is left open."""
        n, along = self.normals[k], list(self.tangents[k])
        normal, size = 1.0 if n is None else float(found[n]), CLOSE * float(np.abs(found).max(initial=0.0))
        most, held = self.friction[k] * normal, n is None or normal > offset[k] + size
        if not along:
            return Case(held)
        if float(np.linalg.norm(found[along])) < most - size:
            return Case(held, STICK)
        return Case(held, SLIP, (-float(np.sign(found[along[0]])),) if len(along) == 1 else () if most else (0.0, 0.0))

    def percussions(self, d: Array, target: Array) -> Array:
        """Return what keeps all laws in a step, shape (m,), of contacts and of dry friction, whose law is of forces.

        Raises:
            ArithmeticError: nothing does.
        """
        options = [(*self.slips(k), *(() if n is None else (FREE,))) for k, n in enumerate(self.normals)]
        return self._least(d, options, np.zeros(len(options)), target, 1)

    def by_pivots(self, d: Array, slides: Sequence[float], offset: Array, target: Array) -> Array | None:
        """Return λ, shape (m,), of one solution by Lemke's method, see `pivoted`; None where it ends without."""
        return pivoted(self, d, slides, offset, target)

    def by_projection(
        self, d: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array
    ) -> Iterator[tuple[tuple[Case, ...], Array]]:
        """Yield what `solutions` yields, of the cases that projections end at; nothing where they do not."""
        found, chosen = projected(self, d, offset, target, SWEEPS), list[Sequence[Case]]()
        for k, n in enumerate(self.normals):
            size, most = float(np.linalg.norm(found[list(self.tangents[k])])), self.static[k] * found[n]
            held, stuck = n is None or found[n] > offset[k], size < most * (1 - 1e-7)
            wanted = [one for one in options[k] if one.held == held and (one.slip == STICK) >= stuck]
            chosen.append(wanted or options[k])
        yield from self.solutions(d, chosen, offset, target, found)

    def _least(
        self, v: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array, most: int | None = None
    ) -> Array:
        """Return the least impulses that keep the laws, of the first `most` that are found."""
        found = list[Array]()
        alone = len(self.normals) > FEW and max(map(len, self.tangents)) < 2
        if alone and np.array_equal(self.static, self.friction):
            one = self.by_pivots(v, [0.0] * len(self.normals), offset, target)
            found = [] if one is None else [one]
        else:
            found = [impulses for _, impulses in islice(self.ways(v, options, offset, target), most)]
        if not found:
            raise ArithmeticError("no impulses keep the laws of its impact")
        if len(found) == 1:
            return found[0]
        least_sum = min(float(np.abs(one).sum()) for one in found)
        found = [one for one in found if np.abs(one).sum() <= least_sum * (1 + CLOSE)]
        return min(found, key=lambda one: float(one @ one))

    def ways(
        self, d: Array, options: Sequence[Sequence[Case]], offset: Array, target: Array
    ) -> Iterator[tuple[tuple[Case, ...], Array]]:
        """Yield what keeps all laws: of few contacts every solution, of many that slip along two directions one."""
        known = all(case.way or not case.slips for some in options for case in some)
        if len(options) > FEW and not known:
            found = list(self.by_projection(d, options, offset, target))
            if found or len(options) > 2 * FEW:
                yield from found
                return
        yield from self.solutions(d, options, offset, target)
