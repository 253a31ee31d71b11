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
from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import isfinite, nan
from operator import attrgetter
from typing import Any

import numpy as np

from symdyn.algebra import Array, Batches, Floats, Form
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
from symdyn.teach.student.rows import assembled

PLACES, ALONG = 3, 8
"""Points of a group, and as many elsewhere with the same parameters; and of those where terms are told apart."""
SAME, HOLDS = 1e-8, 1e-7
"""Of the largest value, and of what is left of an equation where it alone is broken: what counts as nothing."""
APART = 10
"""How much more than by its rounded numbers an equation is broken."""

Point = Mapping[str, float]
Floating = Sequence[Sequence[float]]


@dataclass(frozen=True)
class Group:
    """Points with parameters of one kind.

    Attributes:
        on: on the motions, PLACES of them, then as many with the same parameters elsewhere along the motion.
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
    """

    groups: tuple[Group, ...]
    along: tuple[Point, ...]
    ways: tuple[Floating, ...]
    masses: tuple[Array, ...]
    inverses: tuple[Floating, ...]
    rows: Mapping[str, tuple[str, tuple[Form, ...]]]
    accelerations: tuple[str, ...]

    def values(self, form: Form, equation: int | None = None) -> list[dict[str, list[float]]]:
        """Return what a formula is worth on the motions, by group, and where an equation is broken."""
        found = []
        for group in self.groups:
            off = [] if equation is None else _values(group.off[equation], [form])[0]
            found.append({"on": _values(group.on, [form])[0], "off": off})
        return found

    def equal(self, form: Form, near: Sequence[Form], right: Form, free: bool = False) -> Group | None:
        """Return the group where a quantity has its value, up to a constant if that is free; None for none.

        `near` are the formula with one rounded number off by half of its last digit.
        """
        for group in self.groups:
            mine, theirs, *others = _values(group.on, [form, right, *near])
            scale = max(map(abs, theirs), default=0.0) or 1e-12
            slack = [sum(abs(one[k] - mine[k]) for one in others) for k in range(len(mine))]
            pairs = range(PLACES)
            if all(abs(mine[k] - theirs[k]) <= SAME * scale + slack[k] for k in pairs):
                return group
            off = [mine[k] - theirs[k] for k in range(len(mine))]
            moved = any(abs(theirs[PLACES + k] - theirs[k]) > 1e-6 * scale for k in pairs)
            size = max(scale, *map(abs, mine))
            if free and moved and all(abs(off[PLACES + k] - off[k]) <= SAME * size for k in pairs):
                return group
        return None

    def holds(self, form: Form, near: Sequence[Form], asked: Sequence[int]) -> Group | None:
        """Return the group where form = 0 is one of some equations, by number from 0; None for none."""
        for group in self.groups:
            on = _values(group.on[:PLACES], [form, *near])
            for i in asked:
                off = _values(group.off[i], [form])[0]
                slack = [sum(abs(one[k] - on[0][k]) for one in on[1:]) for k in range(PLACES)]
                if all(
                    isfinite(b) and b != 0 and abs(a) <= HOLDS * abs(b) + few and abs(b) >= APART * few
                    for a, b, few in zip(on[0], off, slack, strict=True)
                ):
                    return group
        return None


@lru_cache(maxsize=2)
def rows_of(scene: Scene) -> dict[str, tuple[str, tuple[Form, ...]]]:
    """Return unit and entries of the rows of a scene that have multipliers, by these; none where quaternions turn."""
    if not scene.is_constrained or quaternions(scene):
        return {}
    return {row.multiplier: (row.unit, row.G) for row in Printable.of(scene, lengths=None).constraints.rows}


def _values(points: Sequence[Point], forms: Sequence[Form]) -> list[list[float]]:
    """Return the values of forms, by form and point; nan where there is none."""
    graph = Graph()
    nodes = [form.express(graph) for form in forms]
    return [list(row) for row in zip(*(numbers(nodes, point) for point in points), strict=True)]


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
    """Return a point whose coordinates are near the start where springs on one line have to keep the order of ends."""
    if not any(one.is_ordered for one in scene.struts):
        return point
    starts = zip(scene.coordinates, start_of(scene).position, strict=True)
    return point | {q: point[q] / 10 + float(x.known_at(point) or 0 if x is not None else 0) for q, x in starts}


def motions_of(scene: Scene, course: Course | None) -> Motions | None:
    """Return the points of a scene; None where it has no course, or its motions are not drawn here."""
    if course is None:
        return None
    drawing = _Drawing(scene, course)
    try:
        groups = [drawing.group(declared=False)]
        if any(p.value is not None for p in scene.parameters):
            groups.append(drawing.group(declared=True))
        along, ways = drawing.along()
        masses = [drawing.mass(point) for point in along]
        inverses = [drawing.inverse(M, way) for M, way in zip(masses, ways, strict=True)]
    except (DerivationError, ArithmeticError, np.linalg.LinAlgError):
        return None
    every = [along, *(one for group in groups for one in (group.on, *group.off))]
    finite = all(isfinite(x) for one in every for p in one for x in p.values())
    names = tuple(acceleration_name(u) for u in scene.velocities)
    return (
        Motions(tuple(groups), tuple(along), tuple(ways), tuple(masses), tuple(inverses), rows_of(scene), names)
        if finite
        else None
    )


class _Drawing:
    def __init__(self, scene: Scene, course: Course) -> None:
        self.scene, self.course, graph = scene, course, course.graph
        self.given = prescribed(scene, graph)
        total = [course.value(f"tau:{i + 1}", course.right) for i in range(course.state.n)]
        self.balance = [node for node in total if node is not None]
        self.M = [gradient(node, course.state.qdd) for node in self.balance]
        self.rows = {name: [entry.express(graph) for entry in G] for name, (_, G) in rows_of(scene).items()}

    def group(self, declared: bool) -> Group:
        """Return points with the scene's parameters, or with drawn ones."""
        on, away, off = list[Point](), list[Point](), list[list[Point]]()
        for k in range(PLACES):
            rng = random.Random(f"{self.scene.name}:{k}:{declared}")
            here, there = self._positions(k, declared, rng)
            point, *broken = self._solved(*here, rng, [(i,) for i in range(len(self.balance))])
            on.append(point)
            off.append(broken)
            away.append(self._solved(*there, rng, ())[0])
        return Group((*on, *away), tuple(zip(*off, strict=True)), declared)

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

    def inverse(self, mass: Array, way: Floating) -> Floating:
        """Return what forces make of accelerations: the inverse of the mass matrix on the motions that rows allow."""
        return list(np.linalg.pinv(np.array(way) @ mass @ np.array(way), rcond=1e-10).tolist())

    def _way(self, place: Point, found: Numbers | None) -> Floating:
        n = len(self.balance)
        if found is None:
            return list(np.eye(n).tolist())
        free = free_motions(found.jacobian(np.array([place[name] for name in self.scene.coordinates])).reshape(-1, n))
        return list((free.T @ free).tolist())

    def _positions(
        self, k: int, declared: bool, rng: random.Random
    ) -> tuple[tuple[dict[str, float], Numbers | None], ...]:
        """Return parameters, time and positions of a point and of one elsewhere, with the rows' numbers."""
        scene = self.scene
        own = {p.name: p.value for p in scene.parameters}
        if not scene.is_constrained:
            values = {name: rng.uniform(0.25, 2.0) for name in own}
            if declared:
                values |= self._declared()
            return tuple(
                (self._prescribed(in_reach(self.scene, values | self._drawn(rng)), rng), None) for _ in range(2)
            )
        if any(node is not None and not node.is_zero for node in self._loops().constraints.residual):
            if self.given.place:
                raise DerivationError(f"{scene.name}: loops of prescribed motions are not drawn")
            found, q = assembled(scene, k, near=not declared)
            there = np.array(found.closed_position(found.retract(q, self._step(found, q, rng)), ()).q)
            values = {str(x.value): float(y) for x, y in found.parameters.items()} | {TIME: rng.uniform(0.25, 2.0)}
            return tuple((values | dict(zip(scene.coordinates, p.tolist(), strict=True)), found) for p in (q, there))
        values = {name: rng.uniform(0.25, 2.0) for name in own} | (self._declared() if declared else {})
        found = self._loops().bound_to(values)
        here = self._prescribed(in_reach(self.scene, values | self._drawn(rng)), rng)
        q, way = (
            np.array([here[name] for name in scene.coordinates]),
            np.array([rng.uniform(-1, 1) for _ in self.balance]),
        )
        for _ in range(40):  # along what the rows allow, by the midpoint rule
            half = q + 0.01 * self._allowed(found, q, way)
            q = q + 0.02 * self._allowed(found, half, way)
        return (here, found), (here | dict(zip(scene.coordinates, q.tolist(), strict=True)), found)

    def _declared(self) -> dict[str, float]:
        known = {p.name: p.value.known_at({}) for p in self.scene.parameters if p.value is not None}
        return {name: float(value) for name, value in known.items() if value is not None}

    def _loops(self) -> Numbers:
        if "loops" not in self.__dict__:
            freed = replace(self.scene, parameters=tuple(replace(p, value=None) for p in self.scene.parameters))
            self.loops = Numbers(freed)
        return self.loops

    def _drawn(self, rng: random.Random) -> dict[str, float]:
        return {name: rng.uniform(0.25, 2.0) for name in (*self.scene.coordinates, TIME)}

    def _prescribed(self, point: dict[str, float], rng: random.Random) -> dict[str, float]:
        values = numbers(self.given.position, point)
        names = [self.scene.coordinates[k] for k in self.given.place]
        return point | dict(zip(names, values, strict=True))

    def _fixed(self, found: Numbers | None, q: Array) -> Array:
        """Return what rates keep to: the rows, and prescribed ones."""
        n = len(self.balance)
        held = np.eye(n)[list(self.given.place)]
        return np.vstack([found.jacobian(q).reshape(-1, n), held]) if found is not None else held

    def _allowed(self, found: Numbers, q: Array, way: Array) -> Array:
        free = free_motions(self._fixed(found, q))
        return np.asarray(free.T @ (free @ way))

    def _step(self, found: Numbers, q: Array, rng: random.Random) -> Array:
        return 0.3 * self._allowed(found, q, np.array([rng.uniform(-1, 1) for _ in self.balance]))

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
        u = u + np.array([rng.uniform(0.5, 1.5) for _ in free]) @ free
        drives = {name: rng.uniform(0.5, 2.0) for name in scene.drives if name}
        point = place | dict(zip(scene.velocities, u.tolist(), strict=True)) | drives
        accelerations = [acceleration_name(name) for name in scene.velocities]
        still = point | dict.fromkeys(accelerations, 0.0)
        bias: list[float] = []
        if found is not None:
            moving = dict(zip(found.state.qd, u.tolist(), strict=True))
            bias = found.at(found.constraints.bias, q, moving).tolist()
        M = np.array(numbers([x for row in self.M for x in row], still)).reshape(n, n)
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
        if not self.rows:
            return {}
        G = np.array([numbers(row, point) for row in self.rows.values()])
        if not np.isfinite(G).all():
            raise DerivationError(f"{self.scene.name}: rows that are not written out have no numbers here")
        found = np.linalg.lstsq(G.T, needed, rcond=None)[0]
        return dict(zip(self.rows, found.tolist(), strict=True))
