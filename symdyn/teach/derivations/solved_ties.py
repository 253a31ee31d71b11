"""Steps: dependent coordinates of loops in closed form, where a condition can be solved for one after the other.

A condition is solved for what it is linear in: a coordinate, or a sine or cosine of one, whose other wave is the root
that has the sign of the assembled position. Of a condition in factors that factor holds which vanishes there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from symdyn.algebra import Floats, Form, Function, Number, Power, Ratios, Symbol
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.derivations.solved import LONGEST, in_sines
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Formula, Step
from symdyn.teach.lesson import named

CLOSED = 1e-6
"""rad or m: what a condition is at an assembled position, at most."""

OTHER = {Op.SIN: Op.COS, Op.COS: Op.SIN}

Solutions = Mapping[Form, Form]
"""Coordinates and waves of them, by the others."""


def solved_ties_steps(lesson: Constrained) -> list[Step]:
    """Return the dependent coordinates in closed form, none where a condition cannot be solved for one."""
    if len(lesson.state.q) != lesson.state.n:
        return []
    found = solutions(lesson, [named(lesson.state.q[k]) for k in lesson.partition.dependent])
    shown = {x: form for x, form in found.items() if length(form) <= LONGEST and not _told(x, found)}
    blocks = [Formula("", x, right=form) for x, form in shown.items()]
    if not blocks:
        return []
    rooted = any(isinstance(part, Function) and part.op is Op.SQRT for block in blocks for part in _walk(block))
    reason = lesson.say("ties.solved.root" if rooted else "ties.solved.reason")
    return [Step("ties.solved", lesson.say("ties.solved"), tuple(blocks), reason, show=("angles",))]


def solutions(lesson: Constrained, unknown: Sequence[Symbol]) -> dict[Form, Form]:
    """Return what conditions of positions say of unknown coordinates, each by what stands before it and the others."""
    left = [tie.nodes[-1] for tie in lesson.ties if tie.residual is not None]
    forms = [lesson.tie_form(node) for node in left]
    found, at = dict[Form, Form](), lesson.assembled(0)
    while True:
        for form in forms:
            one = _solved(lesson, _put_in(form, found), {x.name for x in unknown}, at)
            if one is not None:
                break
        else:
            return found
        forms.remove(form)
        atom, value = one
        found[atom] = value
        if isinstance(atom, Function):
            found |= _others(lesson, atom, value, at, forms)


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


def _put_in(form: Form, found: Solutions) -> Form:
    """Return a form with solutions put in, whole waves first."""
    if form in found:
        return found[form]
    return form.with_parts(_put_in(part, found) for part in form.parts) if form.parts else form


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
        node = _put_in(whole, {atom: Symbol("solved:")}).express(lesson.graph)
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


def _walk(block: Formula) -> Iterator[Form]:
    assert block.right is not None, "a solution has two sides"
    yield from block.right.walk()
