"""What tells the terms of a right result apart: their values at points on the motions, with names.

Columns are terms, and what belongs together: the mass of a body, its moment of inertia, all that is one rule's.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import product
from math import isfinite, prod
from typing import Union

import numpy as np

from symdyn.algebra import Array, Form, Function, Number, Power, Symbol
from symdyn.dynamics.mechanism import prescribed
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, reachable
from symdyn.scene import SceneUnits
from symdyn.spatial import dot
from symdyn.teach.lesson import masses
from symdyn.teach.student.course import Course
from symdyn.teach.student.motions import Floating, Motions, Point, at_points
from symdyn.teach.student.wrong_energies import from_ground, from_slope
from symdyn.unlocked import cached_property

MOST, PAIRED, FEW_JOINTS = 80, 24, 3
"""Terms of a result taken apart, and while what is wrong alike in two is looked at; joints, while terms of others."""
CLOSE, ALIKE = 1e-7, 1e-5
"""Of the largest value: what is nothing; of a term: how far it is from another one that is the same."""

OF_BODIES = ("prescribed", "body", "spin", "steiner", "weight", "carried", "hung", "cross")
"""Kinds that say more of a term than its own, if that is one of `OWN`."""
OWN = ("inertia", "gravity")
BESIDE = ("relative", "along", "prescribed")
"""Kinds that are told with another one of the same values."""


@dataclass(frozen=True)
class Column:
    """A term of a right result, or some that one rule makes: `form` is None then; `also`: kinds, `of`: its terms."""

    kind: str
    form: Form | None
    values: tuple[float, ...]
    also: tuple[str, ...] = ()
    of: tuple[int, ...] = ()

    @property
    def squared(self) -> tuple[str, ...]:
        """Return the functions that stand squared in it."""
        powers = [x.base for x in self.form.factors if isinstance(x, Power)] if self.form is not None else []
        return tuple(dict.fromkeys(x.op.name.lower() for x in powers if isinstance(x, Function)))

    def is_worth(self, row: Sequence[float]) -> bool:
        """Whether it has some values."""
        size = max(map(abs, row))
        return all(abs(a - b) <= CLOSE * size for a, b in zip(self.values, row, strict=True))


@dataclass(frozen=True)
class Handle:
    """What an equation is compared by: how symbols move, point by point, and what the right one changes by.

    `parameter` is the one that moves, "" for others: what is proportional to it all in all is not compared by it.
    """

    steps: tuple[Point, ...]
    right: tuple[float, ...]
    parameter: str = ""


@dataclass(frozen=True)
class Evidence:
    """What tells the terms of one result apart.

    Attributes:
        points: see `Motions`.
        columns: terms, and what belongs together.
        right: what the result is worth there; of an equation what is left of it.
        handles: of an equation.
        free: whether a constant is.
        tied: whether rows tie motions together, so that what is one term may be another one there.
        beside: terms of the equations of other joints.
        alike: columns by number that are alike, see `_alike`.
        common: what all of an equation may have been divided by, by point.
        how: what is written: "rows" with multipliers, "solved" with no acceleration but that of its joint, else "".
    """

    points: tuple[Point, ...]
    columns: tuple[Column, ...]
    right: tuple[float, ...]
    handles: tuple[Handle, ...]
    free: bool
    tied: bool
    beside: tuple[Column, ...] = ()
    how: str = ""
    alike: tuple[tuple[int, ...], ...] = ()
    common: tuple[tuple[float, ...], ...] = ()

    @cached_property
    def every(self) -> tuple[Column, ...]:
        """Return the columns, then those that are alike as one."""
        return (*self.columns, *(_together([self.columns[k] for k in one]) for one in self.alike))

    def overlap(self, j: int, k: int, against: bool) -> bool:
        """Whether two of `every` may hold the same term: groups, one of several kinds and a whole, any if `against`."""
        one, other = (self.alike[n - len(self.columns)] if n >= len(self.columns) else (n,) for n in (j, k))
        mixed = any(len({self.columns[n].kind for n in group}) > 1 for group in (one, other))
        if against:
            one, other = (self.every[n].of or group for n, group in ((j, one), (k, other)))
        return bool(set(one) & set(other)) or (mixed and None in (self.every[j].form, self.every[k].form))


def _together(columns: Sequence[Column]) -> Column:
    kind = columns[0].kind if len({one.kind for one in columns}) == 1 else "inertia"
    return Column(kind, columns[0].form, tuple(map(sum, zip(*(one.values for one in columns), strict=True))))


# What a result is made of

Shares = Sequence[tuple[Expr, Union[int, None]]]
"""Nodes, each times the share of a joint's equation, None for no equation."""
Piece = tuple[str, Union[Form, None], Shares]
"""Kind, formula and nodes."""


def evidence_of(course: Course, motions: Motions, key: str) -> list[Evidence]:
    """Return what tells the terms of a quantity apart, of an equation in all ways to write it; few terms alone.

    Where rows tie joints together an equation is that of all that moves with its joint, or has multipliers; where they
    do not it has the accelerations of others in it, or these are eliminated.
    """
    i = int(key[4:]) - 1 if key.startswith("tau:") else None
    n, tied = course.state.n, course.scene.is_constrained
    ways = [(motions.ways, "")]
    if i is not None and 1 < n <= FEW_JOINTS:
        ways.append((motions.inverses, "solved"))
    if i is not None and tied:
        ways.append((tuple(np.eye(n).tolist() for _ in motions.along), "rows"))
    found = (_evidence(course, motions, key, i, [_of_own(way, i) for way in one], how) for one, how in ways)
    return [one for one in found if one is not None]


def _of_own(way: Floating, i: int | None) -> Floating:
    """Return the shares of joints in an equation with one of its own joint."""
    if i is None or way[i][i] == 0:
        return way
    return [*way[:i], [x / way[i][i] for x in way[i]], *way[i + 1 :]]


def _evidence(
    course: Course, motions: Motions, key: str, i: int | None, ways: Sequence[Floating], how: str
) -> Evidence | None:
    """Return what tells terms apart, with the shares of joints in an equation; `how`: see `Evidence`."""
    points, state = motions.along, course.state
    tied = course.scene.is_constrained and how != "rows"
    try:
        pieces = list(_pieces(course, motions, key, i, ways))
    except DerivationError:
        return None
    if how == "rows" and i is not None:
        rows = [(name, G[i].express(course.graph) * course.graph.symbol(name)) for name, (_, G) in motions.rows.items()]
        pieces += [("row", Form.of(node), [(-node, i)]) for _, node in rows if not node.is_zero]
        pieces.append(("row", None, [(-node, i) for _, node in rows]))
    fine = [k for k, (_, form, _) in enumerate(pieces) if form is not None]
    if not 0 < len(fine) <= (PAIRED if how == "solved" else MOST):
        return None
    nodes = [node for _, _, terms in pieces for node, _ in terms]
    known = [iter(row) for row in zip(*at_points(nodes, points), strict=True)]
    values = [
        tuple(
            sum((1.0 if j is None or i is None else way[i][j]) * next(row) for _, j in terms)
            for row, way in zip(known, ways, strict=True)
        )
        for _, _, terms in pieces
    ]
    right = tuple(sum(values[k][p] for k in fine) for p in range(len(points)))
    columns: list[Column] = []
    alone = tied and i is not None and any(way[i][j] for way in ways for j in range(state.n) if j != i)
    terms = np.array([values[k] for k in fine]).T
    for (kind, form, _), row in zip(pieces, values, strict=True):
        if kind == "slope" and form is None and len(fine) < len(points) and not alone and not _made_of(terms, row):
            kind = "cancelling"  # noqa: PLW2901
        size = max(map(abs, row))
        if size == 0 or (form is not None and alone):  # terms of several equations, which rows tie together
            continue
        same = [k for k, one in enumerate(columns) if one.is_worth(row)]
        for k in same:
            if kind == "body" and columns[k].kind == "spin":  # it has no other share
                columns[k] = replace(columns[k], kind="turner")
            if form is None and kind in OF_BODIES and columns[k].form is not None and columns[k].kind in OWN:
                columns[k] = replace(columns[k], kind=kind)
        if form is not None or not same:
            columns.append(Column(kind, form, row))
            continue
        one = columns[same[0]]
        led = "prescribed" in (one.kind, *one.also)  # it accounts for the others
        if kind in BESIDE and i is not None and not led and (kind, one.kind) != ("along", "spin"):
            columns[same[0]] = replace(one, also=(*one.also, kind))
    held = [k for k, one in enumerate(columns) if one.form is not None]
    if 0 < len(held) < len(points):
        terms = np.array([columns[k].values for k in held]).T
        columns = [replace(one, of=tuple(held[n] for n in _made_of(terms, one.values))) for one in columns]
    handles = tuple(_handles(course, motions, i, ways, tied, how)) if i is not None else ()
    beside = () if i is None or tied or how else tuple(_beside(course, motions, i))
    if tied and i is not None and not how:
        columns += _biased(motions, i, ways, columns)
    if how == "rows" and not any(one.kind == "row" for one in columns):  # no row acts in this equation
        how = ""
    names = frozenset(p.name for p in course.scene.parameters)
    alike, powers = _alike(columns, names), common([one.form for one in columns if one.form], names) if handles else {}
    ways_to = list(product(*(range(n + 1) for n in powers.values())))[1:9]
    divided = tuple(tuple(prod(p[x] ** n for x, n in zip(powers, of, strict=True)) for p in points) for of in ways_to)
    return Evidence(points, tuple(columns), right, handles, key in ("P:", "L:"), tied, beside, how, alike, divided)


def _made_of(terms: Array, row: Sequence[float]) -> list[int]:
    """Return the terms, columns of their values by number, that some values are made of; none where they are not."""
    shares = np.linalg.lstsq(terms, np.array(row), rcond=None)[0]
    off = np.abs(terms @ shares - row).max()
    return [k for k, x in enumerate(shares) if abs(x) > ALIKE and off <= CLOSE * max(map(abs, row))]


def common(forms: Sequence[Form], names: Collection[str]) -> dict[str, int]:
    """Return the powers of some symbols that all of some terms have."""
    every = [{getattr(x, "base", x): getattr(x, "exponent", 1) for x in one.factors} for one in forms]
    return {x: n for x in sorted(names) if (n := min((one.get(Symbol(x), 0) for one in every), default=0)) > 0}


def _alike(columns: Sequence[Column], parameters: frozenset[str]) -> tuple[tuple[int, ...], ...]:
    """Return terms, by number, that share all but parameters, (J + m l²) q̈, their parameters, or a factor."""
    groups: dict[object, list[int]] = {}
    for k, one in enumerate(columns):
        factors = [x for x in one.form.factors if not isinstance(x, Number)] if one.form is not None else []
        outer = frozenset(x for x in factors if set(x.symbols) <= parameters)
        for mark in ((one.kind, frozenset(factors) - outer), outer, *factors) if factors else ():
            groups.setdefault(mark, []).append(k)
    return tuple(dict.fromkeys(tuple(one) for one in groups.values() if len(one) > 1))


def _biased(motions: Motions, i: int, ways: Sequence[Floating], columns: Sequence[Column]) -> Iterator[Column]:
    """Yield what products of rates make where rows tie accelerations to them as well, as one column."""
    still, found = next((one.values for one in columns if one.kind == "rates" and one.form is None), None), []
    for k, (point, way, mass) in enumerate(zip(motions.along, ways, motions.masses, strict=True)):
        share, accelerations = np.array(way[i]), np.array([point[name] for name in motions.accelerations])
        if share[i] == 0:
            return
        rest = accelerations - share * accelerations[i] / share[i]
        found.append(float(share @ np.array(mass) @ rest) + (still[k] if still else 0.0))
    yield Column("rates", None, tuple(found))


def _beside(course: Course, motions: Motions, i: int) -> Iterator[Column]:
    """Yield the terms of the equations of other joints, as long as they are few."""
    weights = [node for name, node in course.right.P.items() if name != "E"]
    for j in range(course.state.n if course.state.n <= FEW_JOINTS else 0):
        pieces = [x for x in _equations(course, weights, [j]) if x[1] is not None] if j != i else []
        rows = at_points([node for _, _, ((node, _),) in pieces], motions.along)
        yield from (Column(kind, form, tuple(row)) for (kind, form, _), row in zip(pieces, rows, strict=True))


def _pieces(course: Course, motions: Motions, key: str, i: int | None, ways: Sequence[Floating]) -> Iterator[Piece]:
    """Yield terms, then what belongs together."""
    graph, e, state = course.graph, course.right, course.state
    weights = [node for name, node in e.P.items() if name != "E"]
    if i is not None:
        joints = [j for j in range(state.n) if any(way[i][j] for way in ways)]
        yield from _equations(course, weights, joints) if joints else ()  # none: rows hold all that it says
        return
    kinetic, gravity, elastic = graph.total(e.K.values()), graph.total(weights), e.P["E"]
    name = key.removeprefix("dL:/d")
    if key in ("P:", "L:"):
        sign = -1 if key == "L:" else 1
        yield from _terms(course, [("gravity", sign * gravity, None), ("spring", sign * elastic, None)])
        yield from (("weight", None, [(sign * node, None)]) for node in (*weights, gravity))
        yield from (("hung", None, [(sign * course.weight(part, arm=0), None)]) for part in course.parts)
        yield ("static", None, [(sign * (gravity + elastic), None)])
        for angles in (*from_ground(course), *from_slope(course)):
            yield ("absolute", None, [(sign * (gravity - course.put(gravity, angles)), None)])
    if key in ("K:", "L:"):
        yield from _terms(course, [("inertia", kinetic, None)])
        still = course.put(kinetic, {state.qd[k]: graph.zero for k in prescribed(course.scene, graph).place})
        yield ("prescribed", None, [(kinetic - still, None)])
        yield from _bodies(course, lambda K: [(K, None)])
    elif name in course.scene.coordinates:
        q = graph.symbol(name)
        parts = (("slope", kinetic), ("gravity", -gravity), ("spring", -elastic))
        yield from _terms(course, [(kind, course.slope(x, q), None) for kind, x in parts])
    elif key.startswith(("k_z", "dL:")) and (node := course.value(key, e)) is not None:
        off = key.startswith("k_z") and len(set(key[4:].split(","))) > 1
        yield from _terms(course, [("coupling" if off else "inertia", node, None)])
        if off:
            yield ("coupling", None, [(node, None)])

        def share(K: Expr) -> Shares:
            found = course.value(key, replace(e, K={"": K}, P={"E": graph.zero}))
            return [(found, None)] if found is not None else []

        yield from _bodies(course, share)


def _equations(course: Course, weights: Sequence[Expr], joints: Sequence[int]) -> Iterator[Piece]:
    graph, e, state = course.graph, course.right, course.state
    kinetic, gravity, zero = graph.total(e.K.values()), graph.total(weights), graph.zero
    shares: dict[str, list[tuple[Expr, int | None]]] = {}
    terms = []
    for j in joints:
        inertial, product, slope, _ = course.steps(j, kinetic, zero)
        drive, beside = course.scene.drives[j], {rule: of[j] for rule, of in course.beside.items()}
        of = {
            "inertia": inertial, "rates": product - slope, "gravity": course.slope(gravity, state.q[j]),
            "spring": course.slope(e.P["E"], state.q[j]), **{rule: -load for rule, load in beside.items()},
            "flow": course.loads[j] - e.Q[j], "drive": -graph.symbol(drive) if drive else zero,
        }  # fmt: skip
        terms += [(kind, node, j) for kind, node in of.items()]
        for kind, node in (*of.items(), ("product", product), ("slope", -slope)):
            shares.setdefault(kind, []).append((node, j))
    yield from _terms(course, terms)
    if place := prescribed(course.scene, graph).place:
        given = dict.fromkeys((x[k] for k in place for x in (state.qd, state.qdd)), zero)
        still = [(node - course.put(node, given), j) for kind, node, j in terms if kind in ("inertia", "rates")]
        yield ("prescribed", None, still)
    yield from (({"gravity": "weight", "spring": "springs"}.get(kind, kind), None, x) for kind, x in shares.items())
    yield ("static", None, [*shares["gravity"], *shares["spring"]])
    for part, weight in zip(course.parts, weights, strict=True):
        for kind, node in (("weight", weight), ("hung", course.weight(part, arm=0))):
            yield (kind, None, [(course.slope(node, state.q[j]), j) for j in joints])

    children = {name: joint.child for joint in course.scene.joints for name in joint.coordinates}
    units = SceneUnits(course.scene).coordinates
    for part, mass in zip(course.parts, masses(course.scene, graph, course.placed), strict=True):
        K = course.kinetic(part, spin=0)
        own: Shares = [(course.slope(course.steps(j, K, zero)[0], state.qdd[j]) * state.qdd[j], j) for j in joints]
        j = joints[0]
        turned = len(joints) == 1 and units[j] == "rad" and children[course.scene.coordinates[j]] == mass.body.name
        yield ("steiner" if turned and part.rigid else "body", None, own)
    for angles in from_ground(course):
        off = gravity - course.put(gravity, angles)
        yield ("absolute", None, [(course.slope(off, state.q[j]), j) for j in joints])
    every = [(course.balance(j, kinetic, graph.total([gravity, e.P["E"]]), e.Q), j) for j in joints]
    for name, rate in course.scene.definitions.items():  # of a state
        x, f = graph.symbol(name.removesuffix("_dot")), rate.express(graph)
        if x in reachable([node for node, _ in every]) and not (by := course.slope(f, x)).is_zero:
            yield ("steady", None, [(node - course.put(node, {x: x - f / by}), j) for node, j in every])
    for angles in from_slope(course):
        yield ("absolute", None, [(node - course.put(node, angles), j) for node, j in every])
    yield from _bodies(course, lambda K: [(course.steps(j, K, zero)[0], j) for j in joints])
    yield from _bodies(course, lambda K: [(course.balance(j, K, zero, course.still), j) for j in joints], turning=True)
    for part in course.parts if len(joints) == 1 else ():
        turning, inertial = set(reachable([part.relative[1]])), course.steps(joints[0], part.spin, zero)[0]
        rest = {a: zero for u, a in zip(state.qd, state.qdd, strict=True) if u not in turning}
        yield ("along", None, [(inertial - course.put(inertial, rest), joints[0])])


def _bodies(course: Course, of: Callable[[Expr], Shares], turning: bool = False) -> Iterator[Piece]:
    """Yield what masses and moments of inertia of single bodies have in a result."""
    units = SceneUnits(course.scene).coordinates
    slides = {u for u, unit in zip(course.state.qd, units, strict=True) if unit != "rad"}
    for part in course.parts:
        turned = part.rigid and slides.isdisjoint(reachable([course.kinetic(part, base=0, cross=0, spin=0)]))
        lone = turned and all(node.is_zero for node, _ in of(course.kinetic(part, own=0, spin=0)))
        yield ("steiner" if lone else "body", None, of(course.kinetic(part, spin=0)))
        yield from (("spin", None, of(x)) for x in (part.spin, *(() if turning else part.axes)))
        yield ("body", None, of(course.right.K[part.tag]))
        yield ("carried", None, of(course.kinetic(part, cross=0, own=0, spin=0)))
        yield ("cross", None, of(course.kinetic(part, base=0, own=0, spin=0)))
        yield ("carried", None, of(course.kinetic(part, own=0, spin=0)))
        v, spin = part.relative
        arm = course.velocities(part)[1]
        yield ("relative", None, of(part.spin - spin))
        if turning:
            kept = of(part.m * dot(v, v) / 2 + spin)
            kind = "along" if all(node.is_zero for node, _ in kept) else "relative"  # all that turns is lost
            yield (kind, None, of(part.m * (dot(arm, arm) - dot(v, v)) / 2 + part.spin - spin))
        yield from (("relative", None, of(course.kinetic(part) - lone)) for lone in part.lone)
    yield from (("spin", None, of(K)) for name, K in course.right.K.items() if name.startswith("rotor "))
    tails = (course.parts[k:] for k in range(1, len(course.parts) - 1))
    yield from (("body", None, of(course.graph.total(course.right.K[x.tag] for x in some))) for some in tails)


def _terms(course: Course, of: Sequence[tuple[str, Expr, int | None]]) -> Iterator[Piece]:
    """Yield the terms of nodes; of inertia those with two rates, or the acceleration of another joint, as such."""
    graph, state = course.graph, course.state
    rates, other = ([str(x.value) for x in symbols] for symbols in (state.qd, state.qdd))
    for kind, node, j in of:
        forms = course.terms(node)
        most = max((_degree(form, course) for form in forms), default=0)
        laws = [{x for x in form.walk() if isinstance(x, Function) and {*x.symbols} & {*rates}} for form in forms]
        for form, law in zip(forms, laws, strict=True):
            held = set(form.symbols)
            own = "springs" if kind == "spring" and _degree(form, course) == most else kind
            if kind == "friction" and sum(not law.isdisjoint(one) for one in laws) > 1:
                own = "law"
            if kind == "inertia" and len(held & set(rates)) > 1:
                own = "cross"
            elif kind == "inertia" and j is not None and held & (set(other) - {other[j]}):
                own = "coupling"
            yield (own, form, [(form.express(graph), j)])


def _degree(form: Form, course: Course) -> int:
    """Return the degree of a term in bare coordinates."""
    powers = [(x.base, x.exponent) if isinstance(x, Power) else (x, 1) for x in form.factors]
    return sum(n for x, n in powers if isinstance(x, Symbol) and x.name in course.scene.coordinates)


def _handles(
    course: Course, motions: Motions, i: int, ways: Sequence[Floating], tied: bool, how: str
) -> Iterator[Handle]:
    """Yield accelerations, drives and parameters that an equation is linear in."""
    state, scene = course.state, course.scene
    nodes = [course.value(f"tau:{j + 1}", course.right) for j in range(state.n)]
    drives = [course.graph.symbol(drive) if drive else course.graph.zero for drive in scene.drives]
    balances = [node - drive for node, drive in zip(nodes, drives, strict=True) if node is not None]
    names = [str(a.value) for a in state.qdd]
    along = [{name: way[i][j] for j, name in enumerate(names)} for way in ways]
    own = names[i : i + 1] if how else names
    steps = [along, *_others(ways, i, names)] if tied and not how else [[{name: 1.0}] * len(along) for name in own]
    parameters = [p.name for p in scene.parameters]
    steps += [[{name: 1.0}] * len(along) for name in (*filter(None, scene.drives), *parameters)]

    for step in steps:
        every = [moved(p, by, n) for p, by in zip(motions.along, step, strict=True) for n in (0, 1, 2)]
        values = zip(*at_points(balances, every), strict=True)
        rows = [[sum(w * x for w, x in zip(way[i], next(values), strict=True) if w) for _ in range(3)] for way in ways]
        if slopes := linear(rows):
            yield Handle(tuple(step), slopes, next((x for x in step[0] if x in parameters), ""))


def _others(ways: Sequence[Floating], i: int, names: Sequence[str]) -> Iterator[list[dict[str, float]]]:
    """Yield how accelerations move with other joints than one, in ways that it has no share in."""
    for j in range(len(names)):
        if all(abs(way[i][j]) < CLOSE < way[j][j] for way in ways):
            yield [dict(zip(names, way[j], strict=True)) for way in ways]


def moved(point: Point, by: Point, times: int) -> Point:
    """Return a point with some symbols moved."""
    return {**point, **{name: point[name] + times * x for name, x in by.items()}} if times else point


def linear(rows: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """Return the slopes of what is worth three values in equal steps; none where one is zero, or they differ."""
    slopes = [b - a for a, b, _ in rows]
    size = max(abs(x) for row in rows for x in row)
    straight = all(abs(c - b - s) <= CLOSE * size for (_, b, c), s in zip(rows, slopes, strict=True))
    return tuple(slopes) if isfinite(size) and straight and all(abs(s) > CLOSE * size for s in slopes) else ()
