"""Where a mechanism stays at rest: positions that are known exactly, and those that Newton's method leads to.

Seeds are fixed, so that the same scene gives the same list. Other starts are positions that are known exactly, and,
where one angle alone matters, those at which its force changes sign in steps of half a degree. Coordinates on which
nothing depends stay where the scene starts. Places that have no one linear motion are told apart: those where branches
of loops meet, and those where coordinates are singular (`search`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symdyn.algebra import Array, Form
from symdyn.errors import LinearizeError
from symdyn.linear.exact_rests import exact_rests
from symdyn.linear.linearization import Linearization
from symdyn.linear.modes import Complexes
from symdyn.linear.prepared import Prepared
from symdyn.linear.search import NEAR, SAME, Search
from symdyn.linear.second_order import SecondOrder
from symdyn.linear.steady import at_rest
from symdyn.simulation import read_start
from symdyn.unlocked import cached_property

STARTS = 200
"""Seeded starts."""

ALIKE = 1e-5
"""Distance of eigenvalues, over the largest, that are one."""

FAMILY = 12
"""Places with other equilibria next to them that are told: more of them are one surface of rests, seen again."""

Exact = Mapping[str, Form] | None


@dataclass(frozen=True)
class Equilibrium:
    """A position of rest.

    Attributes:
        q: coordinates, shape (nq,).
        found: how many of the seeded starts led there; 0 where others did.
        family: whether others are next to it, along more than coordinates on which nothing depends.
        near: inertia, damping and stiffness there.
        kind: what the potential energy says of it, where no rows hold it: "stable", "unstable" or "undecided".
        exact: its coordinates, those on which something depends, as formulas of the parameters if they are so for all
            values of these; else None.
    """

    q: Array
    found: int
    family: bool
    near: SecondOrder
    kind: str
    exact: Exact = None


@dataclass(frozen=True)
class Equilibria:
    """What was found.

    Attributes:
        places: in the order of their coordinates.
        starts: how many seeded starts were tried.
        lost: how many of them led nowhere.
        singular: how many of them led to where coordinates are singular, a wheel lies flat, or rows of loops lose rank
            where they balance nothing.
        idle: coordinates on which nothing depends: they may have any value.
        crossings: where it rests too, but branches of loops meet, so that there is no one linear motion.
        locked: where it rests too, but coordinates are singular, so that there is no linear motion in these.
        false: where coordinates are singular and forces vanish though bodies are pulled; those next to which there are
            no others.
        more: how many of them led to further places with others next to them; FAMILY of those are told.
        scanned: how far to either side of zero changes of sign of a force were looked for, rad; 0 where they were not.
        prepared: what was searched.
    """

    places: tuple[Equilibrium, ...]
    starts: int
    lost: int
    singular: int
    idle: tuple[str, ...]
    crossings: tuple[Equilibrium, ...]
    locked: tuple[Equilibrium, ...]
    false: tuple[Equilibrium, ...]
    more: int
    scanned: float
    prepared: Prepared = field(repr=False, compare=False)

    @cached_property
    def systems(self) -> tuple[Linearization, ...]:
        """The linear systems at the places, one each.

        Raises:
            LinearizeError: a motion moves no mass there, or a derivative has no finite value.
        """
        return tuple(at_rest(self.prepared, place.q) for place in self.places)


def equilibria(prepared: Prepared, t: float = 0.0, starts: int = STARTS, start: Array | None = None) -> Equilibria:
    """Return the positions of rest that are known exactly or that starts lead to, at a time, s.

    Coordinates on which nothing depends stay as in `start`, shape (nq,), in place of what the scene says of its start.

    Raises:
        LinearizeError: a prescribed motion does not rest.
    """
    scene, moved = prepared.scene, prepared.functions.w.prescribed.place
    rates = read_start(scene).u if moved else ()
    led = ", ".join(f"{scene.velocities[k]} = {rates[k]:g}" for k in moved if rates[k])
    if led:
        raise LinearizeError(
            f"{scene.name}: no position of rest: a prescribed motion goes on, {led}; for a steady motion say where, "
            "as in --at NAME=VALUE"
        )
    search = Search(prepared, read_start(scene).q if start is None else start, t)
    exact = exact_rests(prepared, search.idle)
    known, (scanned, changes) = search.placed(exact), search.scanned()
    q, good = search.roots(np.vstack([known, search.drawn(starts), changes]))
    seeded = np.arange(len(q)) - len(known) < starts
    seeded[: len(known)] = False
    lists = _Lists(search, dict(enumerate(exact)))
    for k in np.flatnonzero(good):
        lists.add(search.wrapped(q[k]), int(k), bool(seeded[k]))
    return Equilibria(
        _sorted(lists.places), starts, int(np.sum(np.logical_and(seeded, np.logical_not(good)))), lists.singular,
        tuple(name for name, idle in zip(scene.coordinates, search.idle, strict=True) if idle),
        _sorted(lists.crossings), _sorted(lists.locked), _sorted(lists.false), lists.more, scanned, prepared,
    )  # fmt: skip


class _Lists:
    """The places that starts led to, each once."""

    def __init__(self, search: Search, exact: Mapping[int, Mapping[str, Form]]) -> None:
        self.search, self.exact = search, exact
        self.places, self.crossings, self.locked, self.false = (list[Equilibrium]() for _ in range(4))
        self.spectra = dict[int, Complexes]()
        self.singular = self.more = 0

    def add(self, q: Array, start: int, seeded: bool) -> None:
        """Add the place that a start led to."""
        search, exact = self.search, self.exact.get(start)
        if search.regular(q):
            self._add(self.places, q, exact, seeded, family=search.flat(q))
        elif search.crossing(q):
            self._add(self.crossings, q, None, seeded, near=NEAR)
        else:
            rests = search.locked(q)
            self.singular += seeded and not rests
            if search.singular(q) and (exact is not None or not search.flat(q)):
                self._add(self.locked if rests else self.false, q, exact, seeded)

    def _add(
        self, some: list[Equilibrium], q: Array, exact: Exact, seeded: bool, near: float = SAME, family: bool = False
    ) -> None:
        """Add a place to some, or count it where it is among them; of a family one of each set of eigenvalues."""
        search, values = self.search, np.zeros(0, dtype=np.complex128)
        known = next((k for k, other in enumerate(some) if search.same(q, other.q, near)), None)
        if family and known is None:
            values = search.eigenvalues(q)
            known = next((k for k, other in self.spectra.items() if _alike(values, other)), None)
        if known is not None:
            some[known] = replace(some[known], found=some[known].found + seeded)
        elif family and len(self.spectra) == FAMILY:
            self.more += seeded
        else:
            self.spectra |= {len(some): values} if family else {}
            beside = search.near(q)
            some.append(Equilibrium(q, int(seeded), family, beside, search.kind(beside), exact))


def _sorted(places: Sequence[Equilibrium]) -> tuple[Equilibrium, ...]:
    return tuple(sorted(places, key=lambda place: [round(float(x), 6) + 0.0 for x in place.q]))


def _alike(x: Complexes, y: Complexes) -> bool:
    """Tell whether two sets of eigenvalues are one."""
    if len(x) != len(y):
        return False
    apart, size = np.abs(x[:, None] - y[None, :]), max(float(np.abs(x).max(initial=0.0)), 1e-9)
    return bool(np.max([apart.min(axis=0), apart.min(axis=1)], initial=0.0) < ALIKE * size)
