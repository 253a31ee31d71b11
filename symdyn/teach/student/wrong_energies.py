"""Energies in which one rule is broken, for each mass that it concerns, then for all.

Others are the right formula with one symbol, one function or one term wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import replace
from fractions import Fraction
from itertools import permutations, tee

from symdyn.algebra import Form, Function, Number, Power, Symbol
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, reachable
from symdyn.scene import SceneUnits
from symdyn.spatial import dot
from symdyn.teach.student.course import Course, Energies, Parts

HALF = Fraction(1, 2)


def wrong_energies(course: Course) -> Iterator[tuple[str, str, Energies]]:
    """Return energies in which one rule is broken, for each mass that it concerns, for all of a body, or of one size.

    Each is made once: a copy of what `tee` returns begins with those that are there, and makes the rest on demand.
    """
    kept = course.graph.found.setdefault("wrong energies", {})
    if not kept:
        (kept["first"],) = tee(_wrong_energies(course), 1)
    return copy(kept["first"])


def _wrong_energies(course: Course) -> Iterator[tuple[str, str, Energies]]:
    right, parts = course.right, course.parts
    groups: dict[object, list[str]] = {}
    for part in parts:
        for mark in (re.split("[a-z,]", part.tag)[0], part.m):
            groups.setdefault(mark, []).append(part.tag)
    bodies = [body for body in groups.values() if 1 < len(body) < len(parts)]
    for rule, treat in TREATMENTS:
        each = {part.tag: found for part in parts if (found := list(treat(course, part)))}
        for tag, ways in each.items():
            for way in ways:
                yield rule, tag, course.with_part({tag: way})
        for body in bodies:
            for k in range(min((len(each.get(tag, ())) for tag in body), default=0)):
                yield rule, "", course.with_part({tag: each[tag][k] for tag in body})
        if len(each) > 1:
            for k in range(min(map(len, each.values()))):
                yield rule, "", course.with_part({tag: ways[k] for tag, ways in each.items()})
    negative = {tag: -node for tag, node in right.P.items()}
    yield "energies", "", replace(right, P=negative | {"E": right.P["E"]})
    yield "energies", "", replace(right, P=negative)
    zero, E = course.graph.zero, right.P["E"]
    stored = [("term", zero), ("spring", -E), ("factor", 2 * E)]
    for term in Form.of(E).terms:  # a stretch that is not squared
        flat = Form.product(x.base if isinstance(x, Power) and x.exponent == 2 else x for x in term.factors)
        stored.append(("power", E + flat.express(course.graph) - term.express(course.graph)))
    yield from ((rule, "", replace(right, P={**right.P, "E": node})) for rule, node in stored if not E.is_zero)
    yield from (("ratio", "", energies) for energies in wrong_ratios(course))
    for rule, loads in course.beside.items():
        for times in (1, 2) if any(not load.is_zero for load in loads) else ():
            yield rule, "", replace(right, Q=tuple(node - times * x for node, x in zip(right.Q, loads, strict=True)))
    for by in (course.graph.symbol(p.name) for p in course.scene.parameters if p.unit == "rad"):
        if by in reachable(right.K.values()):  # a sum of angles for their difference
            yield "clockwise", "", list(_replaced(course, {by: -by}))[2]
        if by in reachable(node for tag, node in right.P.items() if tag != "E"):  # what is inclined taken for level
            level = list(_replaced(course, {by: zero}))[1]
            yield from (("trig", "", level), ("absolute", "", level))
    yield from (("absolute", "", wrong) for values in from_ground(course) for wrong in _replaced(course, values))
    stretched = (course.put(E, values) for values in from_ground(course, 1))  # of a spring from link to link
    yield from (("absolute", "", replace(right, P={**right.P, "E": node})) for node in stretched if node != E)


def _replaced(course: Course, values: Mapping[Expr, Expr]) -> Iterator[Energies]:
    """Yield energies with other symbols: both, P alone and K alone."""
    wrong = course.replaced(course.right, values)
    yield from (wrong, replace(course.right, P=wrong.P), replace(course.right, K=wrong.K, square=wrong.square))


Way = tuple["Expr | None", "Expr | None", "Expr | None"]


def _half(course: Course, part: Parts) -> Iterator[Way]:
    K = course.kinetic(part)
    yield from ((None, x, None) for x in (2 * K, *((K + part.spin, 2 * K - part.spin) if part.rigid else ())))


def _steiner(course: Course, part: Parts) -> Iterator[Way]:
    shares = ((1, 1, 0), (1, 0, 0), (0, 0, 0), (1, 1, 4), (1, 1, -1), (0, 0, 1), (0, 1, 1))
    if part.rigid:
        yield from ((None, course.kinetic(part, *each), None) for each in shares)
        yield None, course.kinetic(part) + part.parallel, None


def _extra(course: Course, part: Parts) -> Iterator[Way]:
    """Yield K with a parallel-axis term too much: that of the body, then one of another distance."""
    if part.rigid:
        lengths = [course.graph.symbol(p.name) for p in course.scene.parameters if p.unit == "m"]
        others = (part.m * x * x * u * u / 2 for u in used(part.spin, course.state.qd) for x in lengths)
        yield from ((None, course.kinetic(part) + x, None) for x in (part.parallel, *others))


def _inertia(course: Course, part: Parts) -> Iterator[Way]:
    rods = ((1, rod, 1) for rod in (Fraction(1, 3), Fraction(1, 12), Fraction(4, 3)))
    shares = ((1, 1, 0), (1, 1, 2), (1, 1, 4), (1, 0, 0), (0, 0, 0)) if part.rigid else rods
    yield from ((None, course.kinetic(part, 1, *each), None) for each in shares)


def _arm(course: Course, part: Parts) -> Iterator[Way]:
    for times in (2, HALF):
        K, still = (course.kinetic(part, 1, times, times * times, spin) for spin in (1, 0))
        v2, P = course.squared(part, 1, times, times * times), course.weight(part, arm=times)
        yield from ((v2, K, P), (None, None, P), (v2, K, None), (None, course.kinetic(part, cross=times), None))
        yield from ((v2, still, P), (None, still, None)) if part.rigid else ()
    yield from _upright(course, part)


def _upright(course: Course, part: Parts) -> Iterator[Way]:
    """Yield K with the distances that hold where an angle is zero."""
    K, units = course.kinetic(part), SceneUnits(course.scene).coordinates
    for q in used(K, [q for q, unit in zip(course.state.q, units, strict=True) if unit == "rad"]):
        yield None, course.put(K, {q: course.graph.zero}), None


def _cross(course: Course, part: Parts) -> Iterator[Way]:
    u, v = course.velocities(part)
    if not dot(u, v).is_zero:
        for times in (0, -1, 2, HALF):
            yield course.squared(part, cross=times), course.kinetic(part, cross=times), None


def _carried(course: Course, part: Parts) -> Iterator[Way]:
    u, _ = course.velocities(part)
    if not dot(u, u).is_zero:
        yield from ((course.squared(part, *x), course.kinetic(part, *x), None) for x in ((0,), (0, 0)))
    if not all(x.is_zero for x in part.base):
        v2, K, P = course.squared(part, 1, 0, 0), course.kinetic(part, 1, 0, 0, 0), course.weight(part, arm=0)
        heights = ((None, None, course.weight(part, base=0)), (None, None, P), (v2, K, P))
        yield from (*(() if P.is_zero else heights), (None, K, None))  # a hinge at the height zero lifts nothing


def _relative(course: Course, part: Parts) -> Iterator[Way]:
    u, _ = course.velocities(part)
    v, spin = part.relative
    square = dot(u, u) + 2 * dot(u, v) + dot(v, v)
    yield dot(v, v), part.m * dot(v, v) / 2 + spin, None
    yield square, part.m * square / 2 + spin, None
    yield square, part.m * square / 2 + part.spin, None
    yield None, course.kinetic(part, spin=0) + spin, None
    full = course.velocities(part)[1]
    for square in (dot(u, u) + 2 * dot(u, full) + dot(v, v), dot(u, u) + 2 * dot(u, v) + dot(full, full)):
        yield square, part.m * square / 2 + part.spin, None
    yield from ((None, lone, None) for lone in part.lone)


def _height(course: Course, part: Parts) -> Iterator[Way]:
    """Yield P with another coordinate of the place for its height."""
    g = course.gravity
    size = next((x for x in g if not x.is_zero), None)
    if size is None or sum(not x.is_zero for x in g) > 1:
        return
    up = next(k for k, x in enumerate(g) if not x.is_zero)
    for k in range(3):
        if k != up and not (part.base[k].is_zero and part.arm[k].is_zero):
            node = part.m * size * (part.base[k] + part.arm[k])
            yield from ((None, None, node), (None, None, -node))


def _gravity(course: Course, part: Parts) -> Iterator[Way]:
    yield from ((None, None, P) for P in (-course.weight(part), course.weight(part, arm=-1)))


def _weightless(course: Course, part: Parts) -> Iterator[Way]:
    yield None, None, course.graph.zero


def _massless(course: Course, part: Parts) -> Iterator[Way]:
    if not part.m.is_zero:
        yield None, None, course.weight(part) / part.m


def _body(course: Course, part: Parts) -> Iterator[Way]:
    zero = course.graph.zero
    yield from ((None, zero, None), (None, zero, zero), (zero, zero, zero))


TREATMENTS: tuple[tuple[str, Callable[[Course, Parts], Iterator[Way]]], ...] = (
    ("half", _half),
    ("gravity", _gravity),
    ("weightless", _weightless),
    ("power", _massless),
    ("extra", _extra),
    ("steiner", _steiner),
    ("inertia", _inertia),
    ("cross", _cross),
    ("relative", _relative),
    ("carried", _carried),
    ("height", _height),
    ("arm", _arm),
    ("body", _body),
    ("trig", _upright),
)
"""Rules about the energies of one mass: the ways to break them, as v², K and P in place of the right ones."""


def from_ground(course: Course, sign: int = -1) -> Iterator[dict[Expr, Expr]]:
    """Yield angles counted from the ground in place of the body that carries the hinge, with rates; `sign` 1: back."""
    state = {str(q.value): (q, u) for q, u in zip(course.state.q, course.state.qd, strict=True)}
    for joint in course.scene.moving:
        before = [x for one in course.ancestors(joint) for x in one.coordinates if x in state]
        if before and len(joint.coordinates) == 1 and joint.coordinates[0] in state:
            q, u = state[joint.coordinates[0]]
            total = course.graph.total(state[x][0] for x in before)
            rates = course.graph.total(state[x][1] for x in before)
            yield {q: q + sign * total, u: u + sign * rates}


Ratio = tuple["Expr", Mapping["Expr", "Expr"], Mapping["Expr", "Expr"]]
"""A ratio of gears, and what makes it one, or turns it over."""


def ratios(course: Course) -> Iterator[Ratio]:
    """Yield the ratios of gears: of two lengths, or teeth, in a coupling, or one parameter of it."""
    units = {p.name: p.unit for p in course.scene.parameters}
    given = [x for joint in course.scene.joints if joint.coupling for _, x in joint.coupling.ratios]
    factors = [x for ratio in given for x in Form.of(ratio.express(course.graph)).factors]
    below = [x.base for x in factors if isinstance(x, Power) and x.exponent == -1 and isinstance(x.base, Symbol)]
    above = [x for x in factors if isinstance(x, Symbol)]
    for a in dict.fromkeys([*above, *below]):
        up = a.express(course.graph)
        if units.get(a.name) in ("", "1"):
            yield up if a in above else 1 / up, {up: course.graph.one}, {up: 1 / up}
    for a in dict.fromkeys(above):
        up = a.express(course.graph)
        for down in dict.fromkeys(x.express(course.graph) for x in below if units.get(x.name) == units.get(a.name)):
            yield up / down, {up: down}, {up: down, down: up}


def wrong_ratios(course: Course) -> Iterator[Energies]:
    """Yield energies with a ratio of gears turned over or left out, in both, in one, or not squared in K."""
    right = course.right
    for ratio, one, turned in ratios(course):
        for values in (turned, one):
            every = [*_replaced(course, values)]
            alone = (replace(right, K={**right.K, tag: K}) for tag, K in every[0].K.items() if right.K[tag] != K)
            yield from (*every, *alone)
        flat = course.replaced(right, one).K
        yield replace(right, K={tag: K if flat[tag] == K else flat[tag] * ratio for tag, K in right.K.items()})


def from_slope(course: Course) -> Iterator[dict[Expr, Expr]]:
    """Yield angles counted from what is inclined by an angle that is a parameter, on either side."""
    units = SceneUnits(course.scene).coordinates
    angles = [q for q, unit in zip(course.state.q, units, strict=True) if unit == "rad"]
    for p in course.scene.parameters:
        by = course.graph.symbol(p.name)
        yield from ({q: q + x} for q in angles if p.unit == "rad" for x in (by, -by))


Wrong = tuple[str, Expr]
"""A rule and what it gives when it is forgotten."""


def wrong_terms(course: Course, right: Expr) -> Iterator[Wrong]:
    """Yield the right formula with one symbol or function wrong in all of it; single terms are told by `evidence`."""
    graph, state = course.graph, course.state
    yield ("turned", -right)
    for pairs in _swaps(course, right):
        with suppress(ZeroDivisionError):  # A in place of C in 1/(C - A)
            yield ("index", course.put(right, pairs))
    for one in zip(state.q, state.qd, state.qdd, strict=True):
        yield ("clockwise", course.put(right, {x: -x for x in one}))
    try:
        form = Form.of(right)
    except DerivationError:
        return
    with suppress(DerivationError):
        form = Form.sum(course.terms(right))
    still = {x: x for x in form.walk() if isinstance(x, Function)}
    held = {x for x in still if x.op in (Op.SIN, Op.COS)}
    angles = sorted({x.args for x in held}, key=str)
    both = {Op.SIN: Op.COS, Op.COS: Op.SIN}
    swaps: dict[Form, Form]
    for ops in ({Op.SIN: Op.COS}, {Op.COS: Op.SIN}, both):
        for of in (angles, *([one] for one in angles if len(angles) > 1)):  # of all angles, and of one
            swaps = {x: Function(ops[x.op], x.args) for x in held if x.op in ops and x.args in of}
            other = form.exchanged(still | swaps).express(graph)
            yield from (("trig", other), ("trig", -other)) if swaps else ()
    for mine, theirs in permutations(angles, 2):
        swaps = {x: Function(x.op, theirs) for x in held if x.args == mine}
        with suppress(ZeroDivisionError):
            yield ("absolute", form.exchanged(still | swaps).express(graph))
    for name in (Symbol(p.name) for p in course.scene.parameters):
        for here, there in ((name, Number.ONE), (name.power(2), name)):
            with suppress(ZeroDivisionError):
                yield ("power", form.exchanged(still | {here: there}).express(graph))


def _swaps(course: Course, node: Expr) -> Iterator[dict[Expr, Expr]]:
    """Yield symbols of one unit in each other's place: both exchanged, then one for the other."""
    state, graph = course.state, course.graph
    groups: dict[str, list[tuple[Expr, ...]]] = {}
    for parameter in course.scene.parameters:
        if parameter.unit:
            groups.setdefault(parameter.unit, []).append((graph.symbol(parameter.name),))
    for unit, q, u, a in zip(SceneUnits(course.scene).coordinates, state.q, state.qd, state.qdd, strict=True):
        groups.setdefault(f"q {unit}", []).append((q, u, a))
        for kind, one in (("only q", q), ("only u", u), ("only a", a)):
            groups.setdefault(f"{kind} {unit}", []).append((one,))
    own = set(reachable([node]))
    for group in groups.values():
        for mine, theirs in permutations(group, 2):
            if own & set(mine):
                there = dict(zip(mine, theirs, strict=True))
                if own & set(theirs):
                    yield there | dict(zip(theirs, mine, strict=True))
                yield there


def used(node: Expr, symbols: Sequence[Expr]) -> list[Expr]:
    """Return the symbols that a node holds."""
    own = set(reachable([node]))
    return [x for x in symbols if x in own]
