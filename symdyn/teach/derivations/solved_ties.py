"""Steps: dependent coordinates of loops in closed form, where a condition can be solved for one after the other.

A condition is solved for what it is linear in: a coordinate, or a sine or cosine of one, whose other wave is the root
that has the sign of the assembled position. Of a condition in factors that factor holds which vanishes there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import permutations
from math import atan2, factorial, sin

from symdyn.algebra import Floats, Form, Function, Number, Power, Ratios, Symbol
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.teach.derivations.constrained import Condition, Constrained
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.derivations.short_sines import in_sines
from symdyn.teach.derivations.solved import LONGEST, quotient, short_form
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Formula, Step
from symdyn.teach.lesson import named

CLOSED = 1e-6
"""rad or m: what a condition is at an assembled position, at most."""

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}

HIGHEST = 6
"""Powers of a coordinate in a condition that is integrated."""

Solutions = Mapping[Form, Form]
"""Coordinates and waves of them, by the others."""


def solved_ties_steps(lesson: Constrained) -> list[Step]:
    """Return the dependent coordinates in closed form, none where a condition cannot be solved for one."""
    if len(lesson.state.q) != lesson.state.n:
        return []
    unknown = [named(lesson.state.q[k]) for k in lesson.partition.dependent]
    squared = _squared(lesson, {x.name for x in unknown})
    found = squared.found if squared else solutions(lesson, unknown)
    shown = {x: form for x, form in found.items() if length(form) <= LONGEST and not _told(x, found)}
    if not shown:
        return []
    blocks: list[Block] = list(squared.way) if squared else []
    blocks += [Formula("", x, right=form) for x, form in shown.items()]
    used = {part.op for form in shown.values() for part in form.walk() if isinstance(part, Function)}
    polar = Op.ATAN2 in used and not squared
    reason = lesson.say(f"ties.solved.{'polar' if polar else 'root' if Op.SQRT in used else 'reason'}")
    return [Step("ties.solved", lesson.say("ties.solved"), tuple(blocks), reason, show=("angles",))]


def integral(lesson: Constrained, tie: Condition) -> Form | None:
    """Return what a condition of velocities keeps constant, where it is the derivative of that; None of another."""
    q, graph = lesson.state.q, lesson.graph
    if len(q) != lesson.state.n or tie.residual is not None:
        return None
    total = graph.zero
    try:
        for x, node in zip(q, tie.nodes, strict=False):
            total = total + _over(lesson, lesson.tie_form(node).express(graph) - gradient(total, [x])[0], x)
        off = [a - b for a, b in zip(tie.slopes, gradient(total, q), strict=True)]
        rates = graph.dot(gradient(total, q), lesson.state.qd)
        pushed = graph.dot(gradient(rates, q), lesson.state.qd)
        exact = all(map(lesson.vanishes, (*off, tie.bias - pushed)))
        return shortened(lesson, total).plus_first if exact else None
    except NO_FORM:
        return None


def _over(lesson: Constrained, node: Expr, x: Expr) -> Expr:
    """Return an integral over a coordinate of what is a polynomial in it, or has its sine or cosine.

    By parts: ∫f = f x - f' x²/2 + f'' x³/6 - …, of a polynomial a finite sum; ∫f = -f' where f'' = -f.

    Raises:
        DerivationError: of anything else.
    """
    graph, total = lesson.graph, lesson.graph.zero
    for term in Form.of(node).terms:
        f, k, sign = term.express(graph), 1, 1
        if lesson.vanishes(f + gradient(gradient(f, [x])[0], [x])[0]):
            total = total - gradient(f, [x])[0]
            continue
        while not lesson.vanishes(f):
            if k > HIGHEST:
                raise DerivationError("a condition of velocities has no integral that is told")
            total = total + graph.constant(Fraction(sign, factorial(k))) * f * x**k
            f, k, sign = gradient(f, [x])[0], k + 1, -sign
    return total


def solutions(lesson: Constrained, unknown: Sequence[Symbol]) -> dict[Form, Form]:
    """Return what conditions of positions say of unknown coordinates, each by what stands before it and the others."""
    forms = [lesson.tie_form(tie.nodes[-1]) for tie in lesson.ties if tie.residual is not None]
    found, at = dict[Form, Form](), lesson.assembled(0)
    while True:
        for form in forms:
            one = _solved(lesson, form.exchanged(found), {x.name for x in unknown}, at)
            if one is not None:
                break
        else:
            left = [form.exchanged(found) for form in forms]
            pairs = (_polar(lesson, *pair, {x.name for x in unknown}, at) for pair in permutations(left, 2))
            return found | next(filter(None, pairs), {})
        forms.remove(form)
        atom, value = one
        found[atom] = value
        if isinstance(atom, Function):
            found |= _others(lesson, atom, value, at, forms)


def _polar(
    lesson: Constrained, first: Form, second: Form, unknown: set[str], at: Mapping[Expr, float]
) -> dict[Form, Form]:
    """Return slide and angle of a link that turns by u, by the two conditions of its loop; none of others.

    p cos u - e sin u + f = p sin u + e cos u + g = 0: p² = f² + g² - e²; p is the slide, or that and a length.
    """
    atoms = {x for form in (first, second) for x in _atoms(form, unknown)}
    slides, angles = [x for x in atoms if isinstance(x, Symbol)], {x.args[0] for x in atoms if isinstance(x, Function)}
    turning = unknown.intersection(*(u.symbols for u in angles))
    if not len(slides) == len(angles) == len(turning) == 1:
        return {}
    graph, (slide,), (u,), x = lesson.graph, slides, angles, Symbol(*turning)
    letters = [graph.symbol(f"solved:{k}") for k in range(2)]
    waves = [Function(op, (u,)) for op in (Op.COS, Op.SIN)]
    put: dict[Form, Form] = {wave: Symbol(str(y.value)) for wave, y in zip(waves, letters, strict=True)}
    nodes = [form.exchanged(put).express(graph) for form in (first, second)]
    (p, across), (e, along) = (gradient(node, letters) for node in nodes)
    f, g = substitute(nodes, dict.fromkeys(letters, graph.zero))
    s, q = slide.express(graph), x.express(graph)
    ways = gradient(p, [s])[0], gradient(u.express(graph), [q])[0]
    if {*letters, s, q} & set(reachable([f, g, e, across, *ways])):
        return {}
    try:
        if lesson.vanishes(p + along):  # the other way round
            e, along, g = -e, -along, -g
        if not all(map(lesson.vanishes, (p - along, e + across, *(way**2 - 1 for way in ways)))):
            return {}
        *signs, now = (1 if float(y) > 0 else -1 for y in evaluate([*ways, p], Floats(), at))  # as assembled
        size = graph.constant(now) if e.is_zero else p
        root = Function(Op.SQRT, (shortened(lesson, f**2 + g**2 - e**2),))
        end = Function(Op.ATAN2, (shortened(lesson, e * f - size * g), shortened(lesson, -size * f - e * g)))
        far, others = (substitute([node], {y: graph.zero})[0] for node, y in ((p, s), (u.express(graph), q)))
        values = Form.product((Number(Fraction(now)), root)), end
        return {
            y: Form.product((Number(Fraction(sign)), Form.sum((value, *shortened(lesson, -rest).terms))))
            for y, sign, value, rest in zip((slide, x), signs, values, (far, others), strict=True)
        }
    except NO_FORM:
        return {}


@dataclass(frozen=True)
class Squared:
    """An angle by the sum of the squares of two conditions: how it is found, and it by the others."""

    way: tuple[Block, ...]
    found: Solutions


def _squared(lesson: Constrained, unknown: set[str]) -> Squared | None:
    """Return an angle of a loop of four bars by s cos u + f = s' sin u + g = 0, and cos u and sin u; None of others."""
    left = [lesson.tie_form(tie.nodes[-1]) for tie in lesson.ties if tie.residual is not None]
    for first, second in permutations(left, 2) if len(unknown) == len(left) == 2 else ():
        atoms = {x for form in (first, second) for x in _atoms(form, unknown) if isinstance(x, Function)}
        u, *others = sorted({x.args[0] for x in atoms}, key=lambda one: -len(one.symbols)) or [Number.ZERO]
        if len(atoms) != 4 or len(others) != 1 or not isinstance(others[0], Symbol):
            continue
        if (found := _other_angle(lesson, first, second, u, others[0])) is not None:
            return found
    return None


def _other_angle(lesson: Constrained, first: Form, second: Form, u: Form, x: Symbol) -> Squared | None:
    """Return x by A cos x + B sin x = C, the sum of the squares of two conditions without u; None where it is none."""
    graph, zero = lesson.graph, lesson.graph.zero
    waves = [Function(op, (one,)) for one in (u, x) for op in (Op.COS, Op.SIN)]
    letters = [graph.symbol(f"solved:{k}") for k in range(4)]
    put: dict[Form, Form] = {wave: Symbol(str(letter.value)) for wave, letter in zip(waves, letters, strict=True)}
    f, g = (form.exchanged(put).express(graph) for form in (first, second))
    (s, other), (none, same) = (gradient(node, letters[:2]) for node in (f, g))
    if not (other.is_zero and none.is_zero) or set(letters).intersection(reachable([s, same])):
        return None
    f, g = substitute([f, g], dict.fromkeys(letters[:2], zero))
    whole = f**2 + g**2 - s**2
    (cc, cs), (_, ss) = (gradient(node, letters[2:]) for node in gradient(whole, letters[2:]))
    if not all(map(lesson.vanishes, (s**2 - same**2, cc - ss, cs))):
        return None
    A, B, rest = substitute([*gradient(whole, letters[2:]), whole], dict.fromkeys(letters[2:], zero))
    nodes = {"A": A, "B": B, "C": -rest - cc / 2}
    a, b, c = (lesson.name(f"loop:{letter}", letter, node=node) for letter, node in nodes.items())
    v, w, turn = (float(y) for y in evaluate([A, B, x.express(graph)], Floats(), lesson.assembled(0)))
    sign = Number(Fraction(1 if sin(turn - atan2(w, v)) > 0 else -1))  # of two positions the assembled one
    root = Function(Op.SQRT, (Form.sum((a.power(2), b.power(2), Form.product((Number.MINUS_ONE, c.power(2))))),))
    found: dict[Form, Form] = {
        x: Form.sum((Function(Op.ATAN2, (b, a)), Form.product((sign, Function(Op.ATAN2, (root, c))))))
    }
    ends = {letter: wave.express(graph) for letter, wave in zip(letters[2:], waves[2:], strict=True)}
    for wave, node, slope in zip(waves[:2], substitute([f, g], ends), (s, same), strict=True):
        turned, under = Form.of(slope).split_sign()
        found[wave] = quotient([short_form(lesson, -turned * node)], [under])
    equation = Form.sum(Form.product((y, wave)) for y, wave in zip((a, b), waves[2:], strict=True))
    said = lesson.say("ties.squared", other=u, q=x)
    forms = [Formula(y.name, shortened(lesson, node)) for y, node in zip((a, b, c), nodes.values(), strict=True)]
    return Squared((said, Formula("", equation, right=c), *forms), found)


def closed_positions(lesson: Constrained, unknown: Sequence[int]) -> dict[Expr, Expr]:
    """Return coordinates and waves of them by the others; none where one has a root, or does not follow alone."""
    graph, q = lesson.graph, [lesson.state.q[k] for k in unknown]
    found = {x.express(graph): value.express(graph) for x, value in solutions(lesson, list(map(named, q))).items()}
    used = reachable(list(found.values()))
    known = found.keys() >= set(q) and not set(q).intersection(used) and not any(x.op is Op.SQRT for x in used)
    return found if known else {}


def _told(wave: Form, found: Solutions) -> bool:
    """Tell whether a wave is one of an angle that is found itself."""
    return isinstance(wave, Function) and any(x in found for x in wave.args)


def _worth(lesson: Constrained, form: Form, at: Mapping[Expr, float]) -> float:
    return float(evaluate([form.express(lesson.graph)], Floats(), at)[0])


def _solved(lesson: Constrained, form: Form, unknown: set[str], at: Mapping[Expr, float]) -> tuple[Form, Form] | None:
    """Return the coordinate or wave that a condition is linear in, and its value; None where it is in none alone."""
    try:
        factors = Ratios.form_of(form.express(lesson.graph)).factors
    except NO_FORM:
        return None
    for factor in factors:
        whole = factor.base if isinstance(factor, Power) and factor.exponent > 0 else factor
        atoms = set(_atoms(whole, unknown))
        if len(atoms) != 1 or abs(_worth(lesson, whole, at)) > CLOSED:
            continue
        (atom,) = atoms
        letter = lesson.graph.symbol("solved:")
        node = whole.exchanged({atom: Symbol("solved:")}).express(lesson.graph)
        (slope,) = gradient(node, [letter])
        if slope.is_zero or letter in reachable([slope]):
            return None
        (rest,) = substitute([node], {letter: lesson.graph.zero})
        return atom, shortened(lesson, -rest / slope)
    return None


def _atoms(form: Form, unknown: set[str]) -> Iterator[Form]:
    """Yield the coordinates and waves in a form that hold what is unknown."""
    if isinstance(form, Function) and form.op in OTHER and unknown.intersection(form.symbols):
        yield form
    elif isinstance(form, Symbol):
        yield from (form,) if form.name in unknown else ()
    else:
        for part in form.parts:
            yield from _atoms(part, unknown)


def _others(
    lesson: Constrained, wave: Function, value: Form, at: Mapping[Expr, float], forms: Sequence[Form]
) -> dict[Form, Form]:
    """Return what follows from a wave: the angle, where another has the same cosine or sine, else the other wave."""
    (angle,) = wave.args
    other = Function(OTHER[wave.op], (angle,))
    if isinstance(value, Function) and value.op is wave.op and isinstance(angle, Symbol):
        for sign in (Number.ONE, Number.MINUS_ONE):
            same = Form.product((sign, *value.args))
            if abs(_worth(lesson, angle, at) - _worth(lesson, same, at)) < CLOSED:
                sine = Form.product((sign if other.op is Op.SIN else Number.ONE, Function(other.op, value.args)))
                return {angle: same, other: sine}
    if not any(other in set(form.walk()) for form in forms):
        return {}
    root = _root(lesson, Ratios.form_of(1 - value.express(lesson.graph) ** 2))
    sign = Number(Fraction(1 if _worth(lesson, other, at) > 0 else -1))
    return {other: Form.product((sign, *root.factors))}


def _root(lesson: Constrained, square: Form) -> Form:
    """Return the root of a quotient, what is squared below the line outside."""
    below = [x for x in square.factors if isinstance(x, Power) and x.exponent < 0]
    inside = [y for x in below for y in x.base.power(-x.exponent).factors]
    if not all(isinstance(y, Power) and y.exponent % 2 == 0 for y in inside):
        return Function(Op.SQRT, (square,))
    above = Form.product(x for x in square.factors if x not in below)
    whole = in_sines(lesson, above.express(lesson.graph)) or above
    roots = [y.base.power(y.exponent // 2) for y in inside if isinstance(y, Power)]
    return Form.product((Function(Op.SQRT, (whole,)), *([Form.product(roots).power(-1)] if roots else [])))
