r"""Points on the motions of a scene, where answers of students are judged; the shell and a page judge by the same ones.

At a point `on` the motions positions and rates keep the rows, prescribed motions have their values, and accelerations,
multipliers and the drives of prescribed motions follow:

    M u̇ - Gᵀ λ = τ + Q - h        G u̇ = -Ġ u

A quantity is right if its value is that of the scene at every such point. An equation of joint i is right if it holds
at every such point, and at none where equation i alone has a force too much: so combinations with other equations,
constraints that are put in and accelerations that are eliminated are right, and the equation of another joint is not.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache, lru_cache, partial
from math import isfinite, nan
from operator import attrgetter
from types import MappingProxyType
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches, Floats, Form
from symdyn.dynamics import Workspace
from symdyn.dynamics.loops import Numbers, free_motions
from symdyn.dynamics.mechanism import TIME, prescribed, quaternions
from symdyn.emit.print import Printable
from symdyn.errors import DerivationError, NoValueError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable, repeated
from symdyn.scene import Scene
from symdyn.scene.joints import start_of
from symdyn.scene.values import acceleration_name
from symdyn.teach.student.course import Course
from symdyn.teach.student.differences import half_unit
from symdyn.teach.student.rows import assembled
from symdyn.unlocked import cached_property

PLACES, ALONG = 3, 8
"""Points of a group, and as many elsewhere with the same parameters; and of those where terms are told apart."""
SAME, HOLDS = 1e-8, 1e-7
"""Of the largest value, and of what is left of an equation where it alone is broken: what counts as nothing."""
APART = 10
"""How much more than by its rounded numbers an equation is broken."""

ROUNDS, SWEEPS = 12, 20  # of looking at what decimals have left, and of fitting each one to it
Point = Mapping[str, float]
Decimals = Mapping[str, Fraction]
Values = Callable[[Array], Array]
Floating = Sequence[Sequence[float]]


@dataclass(frozen=True)
class Group:
    """Points with parameters of one kind.

    Attributes:
        on: on the motions, PLACES of them, as many with the same parameters elsewhere along the motion, then others.
        off: by equation, from 0: the first PLACES with a force too much in that equation alone.
        declared: whether the parameters have the scene's own values.
    """

    on: tuple[Point, ...]
    off: tuple[tuple[Point, ...], ...]
    declared: bool = False


@dataclass(frozen=True)
class Motions:
    """What answers are judged by: groups of points.

    Attributes:
        groups: see `Group`.
        along: points of one more, with all equations broken, where terms are told apart.
        ways: for each of these and each joint the motion of all that moves it, others as little as rows allow.
        masses: for each of these the mass matrix.
        inverses: for each of these the inverse of that, on the motions that rows allow.
        rows: unit and entries of the rows of the scene by their multipliers.
        accelerations: their names.
        senses: signs of rates: both, or what all has a value at.
    """

    groups: tuple[Group, ...]
    along: tuple[Point, ...]
    ways: tuple[Floating, ...]
    masses: tuple[Array, ...]
    inverses: tuple[Floating, ...]
    rows: Mapping[str, tuple[str, tuple[Form, ...]]]
    accelerations: tuple[str, ...]
    senses: tuple[int, ...] = (1,)

    def values(self, form: Form, equation: int | None = None) -> list[dict[str, list[float]]]:
        """Return what a formula is worth on the motions, by group, and where an equation is broken."""
        broken = [() if equation is None else group.off[equation] for group in self.groups]
        pairs = ((_values(one.on, form), _values(off, form)) for one, off in zip(self.groups, broken, strict=True))
        return [{"on": on(np.zeros(0)).tolist(), "off": off(np.zeros(0)).tolist()} for on, off in pairs]

    def equal(self, form: Form, decimals: Decimals, right: Form, free: bool = False) -> Group | None:
        """Return the group where a quantity has its value, up to a constant if that is free; None for none."""
        none = np.zeros(len(decimals))
        for group in self.groups:
            theirs, mine = _values(group.on, right)(np.zeros(0)), _values(group.on, form, decimals)
            scale = float(np.abs(theirs).max()) or 1e-12
            if _explained(lambda t: (mine(t) - theirs) / scale, none, SAME):  # noqa: B023
                return group
            moved, off = (x[PLACES : 2 * PLACES] - x[:PLACES] for x in (theirs, mine(none) - theirs))
            size = max(scale, float(np.abs(mine(none)).max()))
            if free and np.abs(moved).max() > 1e-6 * scale and np.abs(off).max() <= SAME * size:
                return group
        return None

    def holds(self, form: Form, decimals: Decimals, asked: Sequence[int]) -> Group | None:
        """Return the group where form = 0 is one of some equations, by number from 0; None for none."""
        none = np.zeros(len(decimals))
        for group in self.groups:
            on = _values(group.on, form, decimals)
            slack = np.sum([np.abs(on(t) - on(none)) for t in np.eye(len(none))], axis=0)
            for i in asked:
                off = np.resize(np.abs(_values(group.off[i], form, decimals)(none)), len(group.on))
                apart = (off > 0) & (off >= APART * slack)
                if apart[:PLACES].all() and _explained(lambda t: on(t) / off, none, HOLDS):  # noqa: B023
                    return group
        return None


def _values(points: Sequence[Point], form: Form, decimals: Decimals = MappingProxyType({})) -> Values:
    """Return what a formula is worth at points, by how many halves of a unit of its last digit each decimal is off."""
    node = form.express(Graph())
    halves = [(name, float(x), float(half_unit(x))) for name, x in decimals.items()]

    def values(t: Array) -> Array:
        own = {name: x + half * by for (name, x, half), by in zip(halves, t.tolist(), strict=True)}
        found = np.array([numbers([node], {**point, **own})[0] for point in points])
        return np.where(np.isfinite(found), found, np.nan)

    return values


def _explained(off: Values, t: Array, few: float) -> bool:
    """Whether decimals that are off by t, -1 to 1, halves of a unit of the last digit take away what is off everywhere.

    That is E t = -off(0) for what each does, E, in orthonormal rows V, coordinate by coordinate; where decimals are
    multiplied by others it takes some rounds.
    """
    left = off(t)
    E = np.array([off(one) - left for one in np.eye(len(t))]).reshape(len(t), len(left)).T
    if not np.isfinite(E).all():
        return False
    U, s, V = np.linalg.svd(E, full_matrices=False)
    U, s, V = U[:, s > few / 10], s[s > few / 10], V[s > few / 10]
    for _ in range(ROUNDS):
        if np.abs(left).max() <= few:
            return True
        goal, before, t = V @ t - U.T @ left / s, t, t.copy()
        for j in [*np.flatnonzero(V.any(axis=0))] * SWEEPS:
            t[j] = np.clip(t[j] + V[:, j] @ (goal - V @ t) / (V[:, j] @ V[:, j]), -1, 1)
        if np.array_equal(t, before):
            return False
        left = off(t)
    return False


@lru_cache(maxsize=2)
def _tied(scene: Scene) -> list[Printable]:
    return [Printable.of(scene, lengths=None)] if scene.is_constrained and not quaternions(scene) else []


def rows_of(scene: Scene) -> dict[str, tuple[str, tuple[Form, ...]]]:
    """Return unit and entries of the rows of a scene that have multipliers, by these; none where quaternions turn."""
    return {row.multiplier: (row.unit, row.G) for page in _tied(scene) for row in page.constraints.rows}


def beside(scene: Scene) -> dict[str, str]:
    """Return the names in these rows that are none of the scene, with their units, see `PrintedConstraints.units`."""
    return {name: unit for page in _tied(scene) for name, unit in page.constraints.units.items()}


def numbers(nodes: Sequence[Expr], point: Point) -> list[float]:
    """Return the values of nodes at a point; nan where there is none."""
    if not nodes:
        return []
    asked, kept = tuple(nodes), nodes[0].graph.found.setdefault("numbers", {})
    try:
        if asked not in kept:
            names = [str(x.value) for x in reachable(asked) if x.op is Op.SYMBOL]
            kept[asked] = names, repeated(asked, Floats(), attrgetter("value"))
        names, values_at = kept[asked]
        return [float(x) for x in values_at({name: point.get(name, float("nan")) for name in names})]
    except (ArithmeticError, ValueError):
        return [numbers([node], point)[0] for node in nodes] if len(nodes) > 1 else [float("nan")]


class _Pointwise(Batches):
    """Arrays with the digits that `Floats` has one by one; nan where there is no value."""

    def div(self, a: Any, b: Any) -> Any:
        return a / np.where(np.equal(b, 0), np.nan, b)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        rows = zip(*(x.tolist() for x in np.broadcast_arrays(*map(np.atleast_1d, args))), strict=True)
        return np.array([self._one(node, row) for row in rows])

    @staticmethod
    def _one(node: Expr, args: Sequence[float]) -> float:
        try:
            return Floats().function(node, args)
        except NoValueError:
            return nan


def at_points(nodes: Sequence[Expr], points: Sequence[Point]) -> list[list[float]]:
    """Return the values of nodes, by node and point; nan where there is none."""
    symbols = [x for x in reachable(nodes) if x.op is Op.SYMBOL]
    seeds = {x: np.array([point.get(str(x.value), nan) for point in points]) for x in symbols}
    with np.errstate(all="ignore"):
        rows = evaluate(nodes, _Pointwise(), seeds)
    return [np.broadcast_to(row, len(points)).tolist() for row in rows]


def in_reach(scene: Scene, point: dict[str, float]) -> dict[str, float]:
    """Return a point that is near the start, and ends that are moved, where springs on one line keep their order."""
    if not scene.supports and not any(one.is_ordered for one in scene.struts):
        return point
    starts = zip(scene.coordinates, start_of(scene).position, strict=True)
    near = {q: point[q] / 10 + float(x.known_at(point) or 0 if x is not None else 0) for q, x in starts}
    return point | {name: point[name] / 10 for name in scene.rates if name in point} | near


def motions_of(scene: Scene, course: Course | None) -> Motions | None:
    """Return the points of a scene; None where it has no course, or its motions are not drawn here.

    Rates have both signs, where all has a value then: a law of friction goes by them.
    """
    found = (None if course is None else _motions(_Drawing(scene, course, senses)) for senses in ((-1, 1), (1,)))
    return next((one for one in found if one is not None), None)


def _motions(drawing: _Drawing) -> Motions | None:
    scene = drawing.scene
    try:
        groups = [drawing.group(declared=False)]
        if any(p.value is not None for p in scene.parameters):
            groups.append(drawing.group(declared=True))
        along, ways = drawing.along()
        masses = [drawing.mass(point) for point in along]
        allowed = (np.array(way) @ M @ np.array(way) for M, way in zip(masses, ways, strict=True))
        inverses = [np.linalg.pinv(M, rcond=1e-10).tolist() for M in allowed]
    except (DerivationError, ArithmeticError, np.linalg.LinAlgError):
        return None
    every = [along, *(one for group in groups for one in (group.on, *group.off))]
    finite = all(isfinite(x) for one in every for p in one for x in p.values())
    names = tuple(map(acceleration_name, scene.velocities))
    kept = tuple(groups), tuple(along), tuple(ways), tuple(masses), tuple(inverses), rows_of(scene), names
    return Motions(*kept, drawing.senses) if finite else None


class _Drawing:
    def __init__(self, scene: Scene, course: Course, senses: tuple[int, ...]) -> None:
        self.scene, self.course, self.senses, graph = scene, course, senses, course.graph
        self.assembled = cache(partial(assembled, scene))
        self.given = prescribed(scene, graph)
        total = [course.value(f"tau:{i + 1}", course.right) for i in range(course.state.n)]
        self.balance = [node for node in total if node is not None]
        self.M = [gradient(node, course.state.qdd) for node in self.balance]
        self.rows = {name: [entry.express(graph) for entry in G] for name, (_, G) in rows_of(scene).items()}
        kept = Workspace(scene).loops.decisions.independent_rows if {*beside(scene)} - {*self.rows} else ()
        lettered = zip(kept, rows_of(scene).values(), strict=False)
        self.letters = {name: (k, i) for k, (_, G) in lettered for i, x in enumerate(G) for name in x.symbols}

    def group(self, declared: bool) -> Group:
        """Return points with the scene's parameters, or with drawn ones."""
        on, away, more, off = list[Point](), list[Point](), list[Point](), list[list[Point]]()
        for k in range(PLACES):
            rng = random.Random(f"{self.scene.name}:{k}:{declared}")
            here, there = self._positions(k, declared, rng)
            point, *broken = self._solved(*here, rng, [(i,) for i in range(len(self.balance))])
            on.append(point)
            off.append(broken)
            away.append(self._solved(*there, rng, ())[0])
            more += [self._solved(*place, rng, ())[0] for place in self._positions(k, declared, rng)]
        return Group((*on, *away, *more), tuple(zip(*off, strict=True)), declared)

    def along(self) -> tuple[list[Point], list[Floating]]:
        """Return points with drawn parameters, those elsewhere last, and the motions of each joint there.

        All equations are broken there: so an equation that is wrong by a factor is no other one.
        """
        here, there = list[Point](), list[Point]()
        ways: tuple[list[Floating], list[Floating]] = ([], [])
        for k in range(PLACES, PLACES + ALONG):
            rng = random.Random(f"{self.scene.name}:{k}")
            for (place, found), points, way in zip(self._positions(k, False, rng), (here, there), ways, strict=True):
                points.append(self._solved(place, found, rng, [range(len(self.balance))])[1])
                way.append(self._way(place, found))
        return here + there, ways[0] + ways[1]

    def mass(self, point: Point) -> Array:
        """Return the mass matrix at a point."""
        n = len(self.balance)
        return np.array(numbers([x for row in self.M for x in row], point)).reshape(n, n)

    def _way(self, place: Point, found: Numbers | None) -> Floating:
        q, free = np.array([place[name] for name in self.scene.coordinates]), np.eye(len(self.balance))
        free = free if found is None else free_motions(found.jacobian(q).reshape(-1, len(free)))
        return list((free.T @ free).tolist())

    def _positions(
        self, k: int, declared: bool, rng: random.Random, draws: int = 20
    ) -> tuple[tuple[dict[str, float], Numbers | None], ...]:
        """Return parameters, time and positions of a point and of one elsewhere, with the rows' numbers."""
        scene = self.scene
        rows = self.loops.constraints.residual if scene.is_constrained else ()
        if any(node is not None and not node.is_zero for node in rows):
            if self.given.place:
                raise DerivationError(f"{scene.name}: loops of prescribed motions are not drawn")
            found, q = self.assembled(k, near=not declared)
            step = 0.3 * self._allowed(found, q, self._way_of(rng))
            there = np.array(found.closed_position(found.retract(q, step), ()).q)
            values = {str(x.value): float(y) for x, y in found.parameters.items()} | {TIME: rng.uniform(0.25, 2.0)}
            return tuple((values | dict(zip(scene.coordinates, p.tolist(), strict=True)), found) for p in (q, there))
        values = {p.name: rng.uniform(0.25, 2.0) for p in scene.parameters} | (self._declared() if declared else {})
        if not scene.is_constrained:
            moving = sorted({*values} - constants(scene))
            both = [values | {name: rng.uniform(0.25, 2.0) for name in moving} for _ in range(2)]
            return tuple((self._prescribed(one, rng), None) for one in both)
        found = self.loops.bound_to(values)
        here = self._prescribed(values, rng)
        q, way = np.array([here[name] for name in scene.coordinates]), self._way_of(rng)
        try:
            for _ in range(40):  # along what the rows allow, by the midpoint rule
                half = q + 0.01 * self._allowed(found, q, way)
                q = q + 0.02 * self._allowed(found, half, way)
        except DerivationError:  # a root has no value there
            if not draws:
                raise
            return self._positions(k, declared, rng, draws - 1)
        return (here, found), (here | dict(zip(scene.coordinates, q.tolist(), strict=True)), found)

    def _declared(self) -> dict[str, float]:
        known = {p.name: p.value.known_at({}) for p in self.scene.parameters if p.value is not None}
        return {name: float(value) for name, value in known.items() if value is not None}

    @cached_property
    def loops(self) -> Numbers:
        return Numbers(replace(self.scene, parameters=tuple(replace(p, value=None) for p in self.scene.parameters)))

    def _prescribed(self, values: dict[str, float], rng: random.Random) -> dict[str, float]:
        """Return a point with coordinates and time that are drawn, and what is prescribed there."""
        drawn = {name: rng.uniform(0.25, 2.0) for name in (*self.scene.coordinates, TIME)}
        point = in_reach(self.scene, values | drawn)
        names = [self.scene.coordinates[k] for k in self.given.place]
        return point | dict(zip(names, numbers(self.given.position, point), strict=True))

    def _fixed(self, found: Numbers | None, q: Array) -> Array:
        """Return what rates keep to: the rows, and prescribed ones."""
        held = np.eye(len(self.balance))[list(self.given.place)]
        return held if found is None else np.vstack([found.jacobian(q).reshape(-1, len(self.balance)), held])

    def _allowed(self, found: Numbers, q: Array, way: Array) -> Array:
        free = free_motions(self._fixed(found, q))
        return np.asarray(free.T @ (free @ way))

    def _way_of(self, rng: random.Random) -> Array:
        return np.array([rng.uniform(-1, 1) for _ in self.balance])

    def _solved(
        self, place: dict[str, float], found: Numbers | None, rng: random.Random, broken: Sequence[Sequence[int]]
    ) -> list[Point]:
        """Return a point with rates, drives, accelerations and multipliers, then those with some equations broken."""
        scene, n, given = self.scene, len(self.balance), self.given
        q = np.array([place[name] for name in scene.coordinates])
        A = self._fixed(found, q)
        rates = numbers(given.velocity, place)
        loops = len(A) - len(rates)
        u = np.linalg.lstsq(A, np.array([*[0.0] * loops, *rates]), rcond=None)[0] if len(A) else np.zeros(n)
        free = free_motions(A) if len(A) else np.eye(n)
        u = u + np.array([rng.choice(self.senses) * rng.uniform(0.5, 1.5) for _ in free]) @ free
        drives = {name: rng.uniform(0.5, 2.0) for name in scene.drives if name}
        point = place | dict(zip(scene.velocities, u.tolist(), strict=True)) | drives
        point |= {name: float(A[at]) for name, at in self.letters.items()}
        accelerations = [acceleration_name(name) for name in scene.velocities]
        still = point | dict.fromkeys(accelerations, 0.0)
        bias: list[float] = []
        if found is not None:
            moving = dict(zip(found.state.qd, u.tolist(), strict=True))
            bias = found.at(found.constraints.bias, q, moving).tolist()
        M = self.mass(still)
        h = np.array(numbers(self.balance, still))
        tau = np.array([point[name] if name else 0.0 for name in scene.drives])
        for k in given.place:  # a prescribed motion: its own drive is unknown
            tau[k] = 0.0
        lhs = np.block([[M, -A.T], [A, np.zeros((len(A), len(A)))]]) if len(A) else M
        below = [*(-x for x in bias), *numbers(given.acceleration, place)]
        force = 1 + float(np.abs(M).max()) + float(np.abs(h).max())
        points = list[Point]()
        for equations in ((), *broken):
            extra = np.zeros(n)
            extra[list(equations)] = [force * rng.uniform(0.5, 1.5) for _ in equations]
            x = np.linalg.lstsq(lhs, np.array([*(tau - h + extra), *below]), rcond=None)[0]
            solved = point | dict(zip(accelerations, x[:n].tolist(), strict=True))
            held = dict(zip(given.place, x[len(x) - len(given.place) :], strict=True))
            solved |= {name: float(held[i]) for i, name in enumerate(scene.drives) if name and i in held}
            needed = M @ x[:n] + h - extra - np.array([solved[d] if d else 0.0 for d in scene.drives])
            points.append(solved | self._multipliers(solved, needed))
        return points

    def _multipliers(self, point: Point, needed: Array) -> dict[str, float]:
        G = np.array([numbers(row, point) for row in self.rows.values()]).reshape(len(self.rows), len(needed))
        found = np.linalg.lstsq(G.T, needed, rcond=None)[0]
        return dict(zip(self.rows, found.tolist(), strict=True))


def constants(scene: Scene) -> set[str]:
    """Return the names of parameters that do not change with time: a state stands among them for one moment."""
    rates = {one.name for one in scene.derived}
    return {p.name for p in scene.parameters if acceleration_name(p.name) not in rates}
