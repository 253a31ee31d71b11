"""Which terms of a wrong answer differ, found by value at points on the motions.

    mine / factor = Σ t_k + e        e = c t_k        c = -1: lost, -2: turned, other numbers: a wrong factor
                                     e = (n a / b - 1) t_k    a stands for b in it: a symbol, a rate, a sine
                                     e = c t_k + d t_l        two terms at once

Columns t_k are terms, and what belongs together: the mass of a body, its moment of inertia, all that is one rule's.
The factor of an equation is what makes the coefficient of an acceleration, of a drive or of a parameter that of the
scene. A page does the same with the same numbers: `templates/teach/terms.js`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice
from math import cos, isfinite, sin
from typing import Union

from symdyn.algebra import Form
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient
from symdyn.scene import SceneUnits
from symdyn.teach.student.course import Course
from symdyn.teach.student.differences import split_terms
from symdyn.teach.student.motions import Motions, Point, numbers

MOST = 14
"""Terms of a result that is taken apart."""
CLOSE = 1e-7
"""Of the largest value: what is nothing."""

STATES: Mapping[str, tuple[str, str, str]] = {
    "gravity": ("weightless", "gravity", "termfactor"),
    "spring": ("spring", "spring", "termfactor"),
    "load": ("friction", "friction", "termfactor"),
    "rates": ("velocities", "termsign", "termfactor"),
    "slope": ("slope", "slope", ""),
    "product": ("product", "", ""),
    "static": ("", "energies", ""),
    "spin": ("inertia", "inertia", "inertia"),
    "steiner": ("steiner", "", ""),
    "body": ("body", "", ""),
    "coupling": ("coupling", "termsign", "termfactor"),
    "cross": ("cross", "cross", "termfactor"),
    "inertia": ("term", "termsign", "termfactor"),
    "drive": ("term", "termsign", "termfactor"),
}
"""Rules that a column of a kind tells where it is lost, turned, or has another factor; "" for none."""
SUITS: Mapping[str, tuple[str, ...]] = {
    "gravity": ("height", "direction"),
    "rates": ("product", "slope", "chain", "cross", "relative"),
    "inertia": ("coupling", "steiner", "half", "carried", "relative", "cross", "arm"),
}
"""Rules found otherwise that explain what differs in a term of a kind."""


@dataclass(frozen=True)
class Column:
    """A term of a right result, or some of them that one rule makes: `form` is None then."""

    kind: str
    form: Form | None
    values: tuple[float, ...]


@dataclass(frozen=True)
class Atom:
    """What a factor of a term may be: function ("", "sin", "cos"), of what, unit, and values."""

    function: str
    of: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Handle:
    """What an equation is compared by: how symbols move, point by point, and what the right one changes by."""

    steps: tuple[Point, ...]
    right: tuple[float, ...]


@dataclass(frozen=True)
class Evidence:
    """What tells the terms of one result apart; `free` says whether a constant is."""

    points: tuple[Point, ...]
    columns: tuple[Column, ...]
    right: tuple[float, ...]
    handles: tuple[Handle, ...]
    free: bool


@dataclass(frozen=True)
class Found:
    """What differs: rules, and the columns."""

    rules: tuple[str, ...]
    columns: tuple[Column, ...]


# What a result is made of

Piece = tuple[str, Union[Form, None], Sequence[tuple[Expr, Union[int, None]]]]
"""Kind, formula, and nodes, each times the share of a joint's equation, None for no equation."""


def evidence_of(course: Course, motions: Motions, key: str) -> Evidence | None:
    """Return what tells the terms of a quantity apart; None where they are too many, or not known."""
    points, i = motions.along, int(key[4:]) - 1 if key.startswith("tau:") else None
    try:
        pieces = list(islice(_pieces(course, motions, key, i), 4 * MOST))
    except DerivationError:
        return None
    fine = [k for k, (_, form, _) in enumerate(pieces) if form is not None]
    if not 0 < len(fine) <= MOST:
        return None
    nodes = [node for _, _, terms in pieces for node, _ in terms]
    known = [iter(numbers(nodes, point)) for point in points]
    values = [
        tuple(
            sum((1.0 if j is None or i is None else way[i][j]) * next(row) for _, j in terms)
            for row, way in zip(known, motions.ways, strict=True)
        )
        for _, _, terms in pieces
    ]
    right = tuple(sum(values[k][p] for k in fine) for p in range(len(points)))
    columns: list[Column] = []
    for (kind, form, _), row in zip(pieces, values, strict=True):
        size = max(map(abs, row))
        same = [one for one in columns if all(abs(a - b) <= CLOSE * size for a, b in zip(one.values, row, strict=True))]
        if size > 0 and (form is not None or not any(one.kind == kind for one in same)):
            columns.append(Column(kind, form, row))
    handles = tuple(_handles(course, motions, i)) if i is not None else ()
    return Evidence(points, tuple(columns), right, handles, key in ("P:", "L:"))


def _pieces(course: Course, motions: Motions, key: str, i: int | None) -> Iterator[Piece]:
    """Yield terms, then what belongs together."""
    graph, e, state = course.graph, course.right, course.state
    weights = [node for name, node in e.P.items() if name != "E"]
    if i is not None:
        joints = [j for j in range(state.n) if any(way[i][j] for way in motions.ways)]
        yield from _equations(course, weights, joints)
        return
    kinetic, gravity, elastic = graph.total(e.K.values()), graph.total(weights), e.P["E"]
    name = key.removeprefix("dL:/d")
    if key in ("P:", "L:"):
        sign = -1 if key == "L:" else 1
        yield from _terms(course, [("gravity", sign * gravity, None), ("spring", sign * elastic, None)])
        yield from (("gravity", None, [(sign * node, None)]) for node in weights)
        yield ("static", None, [(sign * (gravity + elastic), None)])
    if key in ("K:", "L:"):
        yield from _terms(course, [("inertia", kinetic, None)])
        yield from _bodies(course, lambda K: [(K, None)])
    elif name in course.scene.coordinates:
        q = graph.symbol(name)
        parts = (("rates", kinetic), ("gravity", -gravity), ("spring", -elastic))
        yield from _terms(course, [(kind, course.slope(x, q), None) for kind, x in parts])
    elif key.startswith(("k_z", "dL:")) and (node := course.value(key, e)) is not None:
        yield from _terms(course, [("inertia", node, None)])
        of = {tag: replace(e, K={tag: K}, P={"E": graph.zero}) for tag, K in e.K.items()}
        shares = {tag: course.value(key, one) for tag, one in of.items()}
        yield from (("body", None, [(share, None)]) for share in shares.values() if share is not None)
        for part in course.parts:
            spin = course.value(key, replace(e, K={"": part.spin}, P={"E": graph.zero}))
            yield ("spin", None, [(spin, None)] if spin is not None else [])


def _equations(course: Course, weights: Sequence[Expr], joints: Sequence[int]) -> Iterator[Piece]:
    graph, e, state = course.graph, course.right, course.state
    kinetic, gravity, zero = graph.total(e.K.values()), graph.total(weights), graph.zero
    shares: dict[str, list[tuple[Expr, int | None]]] = {}
    terms = []
    for j in joints:
        inertial, product, slope, _ = course.steps(j, kinetic, zero)
        drive = course.scene.drives[j]
        of = {
            "inertia": inertial, "rates": product - slope, "gravity": course.slope(gravity, state.q[j]),
            "spring": course.slope(e.P["E"], state.q[j]), "load": -e.Q[j],
            "drive": -graph.symbol(drive) if drive else zero,
        }  # fmt: skip
        terms += [(kind, node, j) for kind, node in of.items()]
        for kind, node in (*of.items(), ("product", product), ("slope", -slope)):
            if kind != "inertia":
                shares.setdefault(kind, []).append((node, j))
    yield from _terms(course, terms)
    yield from ((kind, None, nodes) for kind, nodes in shares.items())
    yield ("static", None, [*shares["gravity"], *shares["spring"]])

    def inertial_share(K: Expr) -> list[tuple[Expr, int | None]]:
        return [(course.steps(j, K, zero)[0], j) for j in joints]

    yield from _bodies(course, inertial_share)
    for part in course.parts:
        K = course.kinetic(part, spin=0)
        own = [(gradient(course.steps(j, K, zero)[0], [state.qdd[j]])[0] * state.qdd[j], j) for j in joints]
        turns = SceneUnits(course.scene).coordinates[joints[0]] == "rad" and len(joints) == 1
        yield ("steiner" if turns and part.rigid else "body", None, own)


def _bodies(course: Course, of: Callable[[Expr], list[tuple[Expr, int | None]]]) -> Iterator[Piece]:
    """Yield what masses and moments of inertia of single bodies have in a result."""
    for part in course.parts:
        yield ("body", None, of(course.kinetic(part, spin=0)))
        yield ("spin", None, of(part.spin))
        yield ("body", None, of(course.right.K[part.tag]))
    yield from (("spin", None, of(K)) for name, K in course.right.K.items() if name.startswith("rotor "))


def _terms(course: Course, of: Sequence[tuple[str, Expr, int | None]]) -> Iterator[Piece]:
    """Yield the terms of nodes; of inertia those with two rates, or the acceleration of another joint, as such."""
    graph, state = course.graph, course.state
    rates = [str(u.value) for u in state.qd]
    other = [str(a.value) for a in state.qdd]
    for kind, node, j in of:
        if node.is_zero:
            continue
        for form in split_terms(Form.of(node), course.scene):
            held = set(form.symbols)
            own = kind
            if kind == "inertia" and len(held & set(rates)) > 1:
                own = "cross"
            elif kind == "inertia" and j is not None and held & (set(other) - {other[j]}):
                own = "coupling"
            yield (own, form, [(form.express(graph), j)])


def _handles(course: Course, motions: Motions, i: int) -> Iterator[Handle]:
    """Yield accelerations, drives and parameters that an equation is linear in."""
    state, scene = course.state, course.scene
    nodes = [course.value(f"tau:{j + 1}", course.right) for j in range(state.n)]
    balances = [
        node - (course.graph.symbol(drive) if drive else course.graph.zero)
        for node, drive in zip(nodes, scene.drives, strict=True)
        if node is not None
    ]
    names = [str(a.value) for a in state.qdd]
    along = [{name: way[i][j] for j, name in enumerate(names)} for way in motions.ways]
    steps = [along] if scene.is_constrained else [[{name: 1.0}] * len(along) for name in names]
    beside = [*filter(None, scene.drives), *(p.name for p in scene.parameters)]
    steps += [[{name: 1.0}] * len(along) for name in beside]

    def value(point: Point, way: Sequence[Sequence[float]]) -> float:
        return sum(w * x for w, x in zip(way[i], numbers(balances, point), strict=True) if w)

    for step in steps:
        rows = [
            [value(moved(p, by, n), way) for n in (0, 1, 2)]
            for p, by, way in zip(motions.along, step, motions.ways, strict=True)
        ]
        slopes = linear(rows)
        if slopes:
            yield Handle(tuple(step), slopes)


def moved(point: Point, by: Point, times: int) -> Point:
    """Return a point with some symbols moved."""
    return {**point, **{name: point[name] + times * x for name, x in by.items()}} if times else point


def linear(rows: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """Return the slopes of what is worth three values in equal steps; none where one is zero, or they differ."""
    slopes = [b - a for a, b, _ in rows]
    size = max(abs(x) for row in rows for x in row)
    straight = all(abs(c - b - s) <= CLOSE * size for (_, b, c), s in zip(rows, slopes, strict=True))
    return tuple(slopes) if isfinite(size) and straight and all(abs(s) > CLOSE * size for s in slopes) else ()


def atoms_of(course: Course, motions: Motions) -> list[Atom]:
    """Return what factors of terms may be: parameters, rates, coordinates, their squares, sines and cosines."""
    scene, units = course.scene, SceneUnits(course.scene)
    named = [(p.name, p.unit or "") for p in scene.parameters]
    moving = [
        *zip(scene.velocities, units.velocities, strict=True),
        *zip(scene.coordinates, units.coordinates, strict=True),
    ]
    angles = [name for name, unit in (*named, *zip(scene.coordinates, units.coordinates, strict=True)) if unit == "rad"]
    sums = [{x: 1} for x in angles] + [{x: 2} for x in angles]
    sums += [{a: 1, b: sign} for a, b in combinations(angles, 2) for sign in (1, -1)]
    found = [Atom("", "", "1", (1.0,) * len(motions.along))]
    for name, unit in (*named, *moving):
        row = tuple(point[name] for point in motions.along)
        found += [Atom("", name, unit, row), Atom("", name, f"{unit}^2", tuple(x * x for x in row))]
    for function, of in (("sin", sin), ("cos", cos)):
        for angle in sums:
            row = tuple(of(sum(n * point[x] for x, n in angle.items())) for point in motions.along)
            found.append(Atom(function, " ".join(f"{x}{n}" for x, n in angle.items()), "1", row))
    return found


# What differs


def explained(evidence: Evidence, atoms: Sequence[Atom], value: Callable[[Point], float]) -> Found | None:
    """Return what differs in a wrong answer, by its value at points; None where that cannot be told."""
    mine = [value(point) for point in evidence.points]
    scaled = [] if evidence.handles else [mine]
    for handle in evidence.handles:
        rows = [
            [x, *(value(moved(p, by, n)) for n in (1, 2))]
            for x, p, by in zip(mine, evidence.points, handle.steps, strict=True)
        ]
        if slopes := linear(rows):
            scaled.append([x * b / a for x, a, b in zip(mine, slopes, handle.right, strict=True)])
    told = [found for row in scaled if (found := _search(evidence, atoms, row))]
    return min(told, key=lambda one: one[0])[1] if told else None


def _search(evidence: Evidence, atoms: Sequence[Atom], mine: Sequence[float]) -> tuple[float, Found] | None:
    """Return the fewest columns that account for a difference, with their cost."""
    e = [a - b for a, b in zip(mine, evidence.right, strict=True)]
    columns = evidence.columns
    size = max(*map(abs, mine), *(abs(x) for one in columns for x in one.values))
    if not isfinite(size) or max(map(abs, e)) <= CLOSE * size:
        return None
    half = len(e) // 2

    def change(row: Sequence[float]) -> list[float]:
        return [row[half + k] - row[k] for k in range(half)] if evidence.free else list(row)

    rows, left = [change(one.values) for one in columns], change(e)
    singles = [(_price(c), c, k) for k, row in enumerate(rows) if (c := _share(left, row, size)) is not None]
    if singles:
        return _told_singles(columns, singles)
    others = [
        (2.0 + price, (k,), rules) for k in range(len(columns)) for price, rules in _replaced(columns[k], e, atoms)
    ]
    if others:
        cost, of, rules = min(others)
        return cost, Found(rules, tuple(columns[k] for k in of))
    pairs = []
    fine = [k for k, one in enumerate(columns) if one.form is not None]
    for j, k in combinations(range(len(columns)), 2):
        if (shares := _shares(left, rows[j], rows[k], size)) is not None:
            whole = (columns[j].form is None) + (columns[k].form is None)
            rules = [rule for n, c in zip((j, k), shares, strict=True) for rule in _states(columns[n].kind, c)]
            pairs.append((3 + _price(shares[0]) + _price(shares[1]) + 0.1 * whole, (j, k), tuple(rules)))
    for j in () if pairs else fine:
        for c in (-1.0, -2.0):
            rest = [x - c * t for x, t in zip(e, columns[j].values, strict=True)]
            for k in fine:
                for price, rules in _replaced(columns[k], rest, atoms) if k != j else ():
                    pairs.append((6 + price, (j, k), (*_states(columns[j].kind, c), *rules)))
    if not pairs:
        return None
    cost, of, rules = min(pairs)
    return cost, Found(tuple(dict.fromkeys(rules)), tuple(columns[k] for k in of if columns[k].form is not None))


def _told_singles(columns: Sequence[Column], singles: Sequence[tuple[float, float, int]]) -> tuple[float, Found]:
    """Return what one column tells that accounts for a difference: a term, and what one rule makes."""
    fine = sorted(one for one in singles if columns[one[2]].form is not None)
    whole = sorted(one for one in singles if columns[one[2]].form is None)
    rules = [rule for _, c, k in (*fine[:1], *whole[:1]) for rule in _states(columns[k].kind, c)]
    special = [rule for rule in rules if rule not in ("term", "termfactor")]
    return (fine or whole)[0][0], Found(
        tuple(dict.fromkeys(special or rules)), tuple(columns[k] for _, _, k in fine[:1])
    )


def _states(kind: str, c: float) -> tuple[str, ...]:
    """Return the rules that a column tells with a coefficient 1 + c."""
    lost, turned, scaled = STATES[kind]
    rules = (
        (lost,)
        if abs(c + 1) < CLOSE
        else (turned,)
        if abs(c + 2) < CLOSE
        else ("termsign", scaled)
        if c < -1
        else (scaled,)
    )
    return tuple(filter(None, rules))


def _price(c: float) -> float:
    return 1.0 if min(abs(c + 1), abs(c + 2)) < CLOSE else 1.5


def _share(e: Sequence[float], row: Sequence[float], size: float) -> float | None:
    """Return c of e = c row, None where that does not hold."""
    square = sum(x * x for x in row)
    if square <= (CLOSE * size) ** 2:
        return None
    c = sum(a * b for a, b in zip(e, row, strict=True)) / square
    return c if all(abs(a - c * b) <= CLOSE * size for a, b in zip(e, row, strict=True)) else None


def _shares(e: Sequence[float], one: Sequence[float], two: Sequence[float], size: float) -> tuple[float, float] | None:
    """Return the shares of two rows in e, None where that does not hold, or the rows are one."""
    aa, ab, bb = (sum(x * y for x, y in zip(p, q, strict=True)) for p, q in ((one, one), (one, two), (two, two)))
    det = aa * bb - ab * ab
    if det <= 1e-9 * aa * bb:
        return None
    ea, eb = (sum(x * y for x, y in zip(e, q, strict=True)) for q in (one, two))
    c, d = (ea * bb - eb * ab) / det, (eb * aa - ea * ab) / det
    return (c, d) if all(abs(x - c * p - d * q) <= CLOSE * size for x, p, q in zip(e, one, two, strict=True)) else None


def _replaced(column: Column, e: Sequence[float], atoms: Sequence[Atom]) -> Iterator[tuple[float, tuple[str, ...]]]:
    """Yield what stands for something else in a term, t n a/b in place of t, with a price."""
    t = column.values
    if column.form is None or any(x == 0 or abs(x + d) <= 1e-9 * abs(x) for x, d in zip(t, e, strict=True)):
        return
    ratio = [1 + d / x for x, d in zip(t, e, strict=True)]
    for a in atoms:
        for b in atoms:
            if a is b or (a.function, a.of) == (b.function, b.of):
                continue
            n = ratio[0] * b.values[0] / a.values[0]
            if all(abs(r * y - n * x) <= 1e-7 * abs(n * x) for r, x, y in zip(ratio, a.values, b.values, strict=True)):
                beside = ["termsign"] if n < 0 else []
                beside += ["termfactor"] if abs(abs(n) - 1) > 1e-6 else []
                yield 0.1 * bool(a.of and b.of) + 0.2 * len(beside), (_exchanged(a, b), *beside)


def _exchanged(a: Atom, b: Atom) -> str:
    """Return the rule that tells a in place of b."""
    if a.function == b.function != "":
        return "absolute"
    if a.function or b.function:
        return (
            "trig"
            if (a.function and b.function) or "1" in (a.unit, b.unit) or "rad" in (a.unit, b.unit)
            else "dimension"
        )
    return "index" if a.unit == b.unit else "dimension"
