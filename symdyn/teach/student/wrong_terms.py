"""The right formula with one symbol, one function or one term wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import permutations

from symdyn.algebra import Form, Function, Number, Power, Product, Sum
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.student.course import Course
from symdyn.teach.student.differences import split_terms
from symdyn.teach.student.wrong_energies import from_ground

Wrong = tuple[str, Expr]
"""A rule and what it gives when it is forgotten."""

MOST_TERMS = 24
FACTORS = (2, Fraction(1, 2), 3, Fraction(1, 3), 4, Fraction(1, 4))


def wrong_terms(course: Course, key: str, right: Expr) -> Iterator[Wrong]:
    """Yield the right formula with one symbol, function or term wrong."""
    graph, state = course.graph, course.state
    yield ("turned", -right)
    for pairs in _swaps(course, right):
        yield ("index", substitute([right], pairs)[0])
    turned = {x: -x for x in (*state.q, *state.qd, *state.qdd)}
    for q, u, a in zip(state.q, state.qd, state.qdd, strict=True):
        yield ("clockwise", substitute([right], {x: turned[x] for x in (q, u, a)})[0])
    try:
        form = Form.of(right)
        terms = [one.express(graph) for one in split_terms(form, course.scene)]
    except DerivationError:
        return
    for ops in ((Op.SIN, Op.COS), (Op.COS, Op.SIN)):
        yield ("trig", _exchanged(form, {ops[0]: ops[1]}).express(graph))
    both = _exchanged(form, {Op.SIN: Op.COS, Op.COS: Op.SIN}).express(graph)
    yield ("trig", both)
    yield ("trig", -both)
    if len(terms) > MOST_TERMS:
        return
    rate = {x: k for k, x in enumerate(state.qdd)}
    for term in terms:
        rest, own = right - term, Form.of(term)
        swapped = _exchanged(own, {Op.SIN: Op.COS, Op.COS: Op.SIN}).express(graph)
        lost = _lost(course, key, term)
        if len(terms) > 1:
            yield (lost, rest)
            yield ("gravity" if lost == "weightless" else "cross" if lost == "cross" else "termsign", rest - term)
        yield ("trig", rest + swapped)
        yield ("trig", rest - swapped)
        plain = _exchanged(own, {Op.SIN: None, Op.COS: None}).express(graph)
        yield ("trig", rest + plain)
        for times in FACTORS:
            yield lost if lost in ("cross", "velocities") else "termfactor", rest + graph.constant(times) * term
        for a in used(term, state.qdd):
            yield ("squared", rest + substitute([term], {a: state.qd[rate[a]] * state.qd[rate[a]]})[0])
        for angles in (*from_ground(course), *from_ground(course, 1)):
            turned_angle = {q: x for q, x in angles.items() if q in state.q}
            yield "absolute", rest + substitute([term], turned_angle)[0]
        for pairs in _swaps(course, term):
            yield ("index", rest + substitute([term], pairs)[0])


def _lost(course: Course, key: str, term: Expr) -> str:
    """Return the rule of a term that is lost, by what stands in it."""
    state = course.state
    accelerations, rates = used(term, state.qdd), used(term, state.qd)
    if accelerations:
        drives = [
            *(f"tau:{i + 1}" for i in range(len(state.qdd))),
            *course.scene.drives,
        ]  # a formulation asks for one of them
        own = state.qdd[drives.index(key) % len(state.qdd)] if key in drives else None
        return "coupling" if own is not None and own not in accelerations else "term"
    if key.startswith(("K", "v2")):
        return "cross" if used(term, state.q) or len(rates) > 1 else "term"
    if (
        key.startswith("dL")
        and rates
        and not used(term, state.q)
        and not any(key.endswith(f"/d{u.value}") for u in rates)
    ):
        return "relative"
    if key.startswith("dL") and rates:
        return "cross" if used(term, state.q) else "term"
    if key.startswith(("tau", "P", "k_G", "L")) and not rates:
        return "weightless"
    if key.startswith(("tau", "d/dt")) and rates:
        return "velocities"
    if key.startswith("k_z") and not used(term, state.q) and any(part.rigid for part in course.parts):
        return "inertia"
    return "term"


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


def _exchanged(form: Form, ops: Mapping[Op, Op | None]) -> Form:
    """Return a form with sines for cosines, and so on; None leaves the function out."""
    if isinstance(form, Sum):
        return Form.sum(_exchanged(one, ops) for one in form.terms)
    if isinstance(form, Product):
        return Form.product(_exchanged(one, ops) for one in form.factors)
    if isinstance(form, Power):
        return _exchanged(form.base, ops).power(form.exponent)
    if isinstance(form, Function) and form.op in ops:
        other = ops[form.op]
        return Number.ONE if other is None else Function(other, form.args)
    return form


def used(node: Expr, symbols: Sequence[Expr]) -> list[Expr]:
    """Return the symbols that a node holds."""
    own = set(reachable([node]))
    return [x for x in symbols if x in own]
