"""Where a mechanism stays at rest: positions that are known exactly, and those that Newton's method leads to.

Seeds are fixed, so that the same scene gives the same list. Other starts are positions that are known exactly, and,
where one angle alone matters, those at which its force changes sign in steps of half a degree. Coordinates on which
nothing depends stay where the scene starts.

A position of a tree is exact if it is one for every value of the parameters: at quarter turns sines and cosines are 0,
1 or -1, slides follow from what is left where that is linear in them, and forces are zero as formulas.

Places that have no one linear motion are told apart: those where branches of loops meet, and those where coordinates
are singular (`search`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import product

import numpy as np

from symdyn.algebra import Array, Form, Number, Ratios
from symdyn.arguments import argument
from symdyn.dynamics import formulas
from symdyn.errors import DerivationError, LinearizeError
from symdyn.frozen import dataclass, field, replace
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.linear.linearization import Linearization
from symdyn.linear.modes import Complexes, SecondOrder
from symdyn.linear.prepared import Prepared
from symdyn.linear.search import NEAR, SAME, Search
from symdyn.linear.steady import at_rest
from symdyn.scene import SceneUnits
from symdyn.simulation import Problem
from symdyn.unlocked import cached_property

STARTS = 200
"""Seeded starts."""

ALIKE = 1e-5
"""Distance of eigenvalues, over the largest, that are one."""

CANDIDATES = 256
"""Positions at quarter turns of which it is decided whether they are exact."""

FAMILY = 12
"""Places with other equilibria next to them that are told: more of them are one surface of rests, seen again."""

Exact = Mapping[str, Form] | None


@dataclass(frozen=True)
class Equilibrium:
    """A position of rest.

    Attributes:
        q: coordinates, shape (nq,).
        starts: how many of the seeded starts led there; 0 where others did.
        family: whether others are next to it, along more than coordinates on which nothing depends.
        exact: its coordinates, those on which something depends, as formulas of the parameters if they are so for all
            values of these; else None.
        u: velocities, zero, and states of one's own, shape (nu,).
        search: what led there.
    """

    q: Array
    starts: int
    family: bool
    exact: Exact
    u: Array
    search: Search = field(repr=False, compare=False)

    @cached_property
    def near(self) -> SecondOrder:
        """Inertia, damping and stiffness there."""
        return self.search.near(self.whole)

    @property
    def whole(self) -> Array:
        """Coordinates, and then states of one's own."""
        return np.append(self.q, self.u[len(self.search.scene.velocities) :])

    @cached_property
    def kind(self) -> str:
        """What the potential energy says of it, where no rows hold it: "stable", "unstable" or "undecided"."""
        v = self.search.v
        tree = not v.multipliers and len(self.q) == v.w.state.n
        return self.near.of(self.search.matter).kind if tree else "undecided"


@dataclass(frozen=True)
class Equilibria:
    """What was found.

    Attributes:
        places: in the order of their coordinates.
        starts: how many seeded starts were tried.
        lost: how many of them led nowhere, or to where the equations have no slope.
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
        return tuple(at_rest(self.prepared, place.q, place.u) for place in self.places)


def equilibria(prepared: Prepared, t: float = 0.0, starts: int = STARTS, start: Array | None = None) -> Equilibria:
    """Return the positions of rest that are known exactly or that starts lead to, at a time, s.

    Coordinates on which nothing depends stay as in `start`, shape (nq,), in place of what the scene says of its start.

    Raises:
        LinearizeError: a prescribed motion does not rest.
    """
    scene, moved = prepared.scene, prepared.functions.w.prescribed.place
    problem = Problem(scene, prepared.forces)  # whose start is asked for where it is needed: it may be singular
    rates = problem.initial.u if moved else ()
    led = ", ".join(f"{scene.velocities[k]} = {rates[k]:g}" for k in moved if rates[k])
    if led:
        raise LinearizeError(
            f"{scene.name}: no position of rest: a prescribed motion goes on, {led}; for a steady motion say where, "
            f"as in {argument('start', {'NAME': 'VALUE'})}"
        )
    search = Search(prepared, problem.initial.q if start is None else start, t)
    exact = _exact(prepared, search.idle)
    known, (scanned, changes) = search.placed(exact), search.scanned()
    q, good = search.roots(np.vstack([known, search.drawn(starts), changes]))
    q = np.vstack([search.wrapped(place) for place in q])
    good = np.logical_and(good, search.sloped(q))
    seeded = np.arange(len(q)) - len(known) < starts
    seeded[: len(known)] = False
    lists = _Lists(search, dict(enumerate(exact)))
    for k, rank in zip(np.flatnonzero(good), search.ranks(q[good]), strict=True):
        lists.add(q[k], int(rank), int(k), bool(seeded[k]))
    return Equilibria(
        _sorted(lists.places), starts, int(np.sum(np.logical_and(seeded, np.logical_not(good)))), lists.singular,
        tuple(name for name, idle in zip(scene.coordinates, search.idle, strict=False) if idle),
        _sorted(lists.crossings), _sorted(lists.locked), _sorted(lists.false), lists.more, scanned, prepared,
    )  # fmt: skip


class _Lists:
    """The places that starts led to, each once."""

    def __init__(self, search: Search, exact: Mapping[int, Mapping[str, Form]]) -> None:
        self.search, self.exact = search, exact
        self.places, self.crossings, self.locked, self.false = (list[Equilibrium]() for _ in range(4))
        self.spectra = dict[int, Complexes]()
        self.singular = self.more = 0

    def add(self, q: Array, rank: int, start: int, seeded: bool) -> None:
        """Add the place that a start led to."""
        search, exact = self.search, self.exact.get(start)
        if search.regular(q, rank):
            self._add(self.places, q, exact, seeded, family=search.flat(q))
        elif search.crossing(q):
            self._add(self.crossings, q, None, seeded, near=NEAR)
        else:
            rests = search.locked(q)
            self.singular += seeded and not rests
            if search.singular(q, rank) and (exact is not None or not search.flat(q)):
                self._add(self.locked if rests else self.false, q, exact, seeded)

    def _add(
        self, some: list[Equilibrium], q: Array, exact: Exact, seeded: bool, near: float = SAME, family: bool = False
    ) -> None:
        """Add a place to some, or count it where it is among them; of a family one of each set of eigenvalues."""
        search, values = self.search, np.zeros(0, dtype=np.complex128)
        known = next((k for k, other in enumerate(some) if search.same(q, other.whole, near)), None)
        if family and known is None:
            values = search.eigenvalues(q)
            known = next((k for k, other in self.spectra.items() if _alike(values, other)), None)
        if known is not None:
            some[known] = replace(some[known], starts=some[known].starts + seeded)
        elif family and len(self.spectra) == FAMILY:
            self.more += seeded
        else:
            self.spectra |= {len(some): values} if family else {}
            at, u = search.state(q)
            some.append(Equilibrium(at, int(seeded), family, exact, u, search))


def _sorted(places: Sequence[Equilibrium]) -> tuple[Equilibrium, ...]:
    return tuple(sorted(places, key=lambda place: [round(float(x), 6) + 0.0 for x in place.whole]))


def _alike(x: Complexes, y: Complexes) -> bool:
    if len(x) != len(y):
        return False
    apart, size = np.abs(x[:, None] - y[None, :]), max(float(np.abs(x).max(initial=0.0)), 1e-9)
    return bool(np.max([apart.min(axis=0), apart.min(axis=1)], initial=0.0) < ALIKE * size)


# Exactly


def _exact(prepared: Prepared, idle: Sequence[bool]) -> list[dict[str, Form]]:
    """Return the positions, each as formulas of the parameters by coordinate, `idle` ones left out; of a tree alone.

    Slides are where linear springs hold them, at zero where nothing linear does.
    """
    v, scene = prepared.functions, prepared.scene
    state, graph = v.w.state, v.w.graph
    bound = any(p.value is not None for p in v.w.scene.parameters)  # one decides the form of the equations
    if bound or v.multipliers or scene.given or prepared.forces.tables or len(state.q) != state.n:
        return []
    forces = substitute(v.statics.parts["f"][1], dict.fromkeys(state.tau, graph.zero))
    moving = [
        (q, unit) for q, unit, still in zip(state.q, SceneUnits(scene).coordinates, idle, strict=True) if not still
    ]
    for choice in ((0, 2, 1, -1), (0, 2)):
        candidates = list(product(*(choice if unit == "rad" else (0,) for _, unit in moving)))
        if len(candidates) <= CANDIDATES:
            break
    else:
        return []
    found = []
    for one in candidates:
        turned = {q: graph.pi * Fraction(k, 2) for (q, unit), k in zip(moving, one, strict=True) if unit == "rad"}
        slides = [q for q, unit in moving if unit != "rad"]
        try:
            at = {**turned, **_held([forces[state.q.index(q)] for q in slides], slides, turned)}
            left = substitute(forces, at)
        except ZeroDivisionError:  # a spring of no length pulls nowhere
            continue
        if all(_vanishes(force, state.q) for force in left):
            found.append({str(q.value): Ratios.form_of(at[q]) for q, _ in moving})
    return found


def _vanishes(force: Expr, q: Sequence[Expr]) -> bool:
    """Tell whether a force is zero for every value of the parameters, wherever the mechanism is."""
    if force.is_zero or set(reachable([force])).intersection(q):
        return force.is_zero
    try:
        return formulas([force], 1) == [Number.ZERO]
    except DerivationError:
        return False


def _held(forces: Sequence[Expr], slides: Sequence[Expr], turned: Mapping[Expr, Expr]) -> Mapping[Expr, Expr]:
    """Return where linear forces hold the slides, angles being given; zeros where they are not linear."""
    if not slides:
        return {}
    graph = slides[0].graph
    free = dict.fromkeys(slides, graph.zero)
    forces = substitute(forces, turned)
    slopes = [x for force in forces for x in gradient(force, slides)]
    if set(reachable(slopes)).intersection(slides):
        return free
    still = substitute(forces, free)
    quotients = Ratios([*slopes, *still])
    known, n = evaluate([*slopes, *still], quotients, quotients.values()), len(slides)
    stiffness = [known[k : k + n] for k in range(0, n * n, n)]
    try:
        shifts = quotients.solved(stiffness, [[quotients.neg(x)] for x in known[n * n :]])
    except (ZeroDivisionError, OverflowError):
        return free
    return {q: quotients.form(x).express(graph) for q, (x,) in zip(slides, shifts, strict=True)}
