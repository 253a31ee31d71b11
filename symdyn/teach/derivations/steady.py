"""Motions in which one coordinate rests while others turn on, relative equilibria: a hoop, a top, a governor.

They are where W = P - K(ṙ = 0) is level along r, the rates of the others held: the weights against what turns. Which
are stable is told by V of `reduced`, whose momenta, or prescribed rates, stay when r is pushed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence, Set
from fractions import Fraction
from itertools import permutations

from symdyn.algebra import Form, Function, Number, Power, Ratios, Symbol
from symdyn.dynamics.mechanism import prescribed, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, gradient, reachable, substitute, tangents
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.contact_laws import square_root
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.reduced import Reduced, at_bound
from symdyn.teach.derivations.short_sines import in_sines
from symdyn.teach.derivations.solved import in_decimals, quotient
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import Lesson, Mass, named, together

LONGEST = 60  # terms and factors of a formula that is shown
ROUNDING = 1e-9  # of the largest rate: what is none


def steady_step(lesson: Lesson, left: Reduced) -> Step | None:
    """Return the condition of steady motions, its solutions by factors, and in numbers; None where there are none."""
    if not left.couples:
        return None
    r, others = named(left.q), [named(lesson.state.q[k]) for k in (*left.cyclic, *left.led)]
    blocks: list[Block] = []
    bounds: list[Form] = []
    (slope,) = gradient(left.static, [left.q])
    W = lesson.name("W:", "W", node=left.static)
    try:
        whole = lesson.short(left.static)
        factored = in_decimals(Ratios.form_of(slope))
    except (DerivationError, KeyError, OverflowError, ZeroDivisionError):
        whole = factored = Number.ZERO
    if whole != Number.ZERO and length(whole) <= LONGEST and length(factored) <= LONGEST:
        symbol = lesson.slope(W.name, r.name, slope)
        blocks += [
            Formula(W.name, whole),
            lesson.say("steady.level"),
            Formula(symbol.name, waves_first(lesson, factored)),
        ]
        turning = {str(lesson.state.qd[k].value) for k in left.cyclic}
        for kind, places in level_places(factored, r, turning):
            if kind in ("steady.wave", "steady.place"):
                blocks += _reached(left, factored, bounds, **places)
            else:
                blocks.append(lesson.say(kind, **places))
    blocks += _numbers(lesson, left)
    key = "steady.led" if left.led else "steady.free"
    rates = together([named(lesson.state.qd[k]) for k in left.cyclic])
    claim = lesson.say(key, q=r, others=together(others), rates=rates)
    reason = lesson.say(f"{key}.reason", W=W)
    tries = tuple(one for value in bounds if (one := at_bound(lesson, left.chosen, value)) is not None)
    return Step("steady", claim, tuple(blocks), reason, show=("centrifugal", "weights", "phase"), tries=tries)


def level_places(factored: Form, r: Symbol, rates: Set[str]) -> Iterator[tuple[str, dict[str, Form]]]:
    """Yield what each factor says: r or sin r = 0, r or cos r is a quotient, or, of rates, r is any."""
    for factor in factored.factors:
        inner = factor.base if isinstance(factor, Power) else factor
        if isinstance(factor, Power) and factor.exponent < 0:
            continue
        names = set(inner.symbols)
        if r.name not in names and names & rates:
            yield "steady.any", {"rates": inner, "q": r}
            continue
        if inner == r:
            yield "steady.zero", {"wave": r}
        elif r.name not in names and (flat := _flat(inner)):
            yield "steady.flat", {"square": flat[0], "least": flat[1], "q": r}
        waves = {one for one in inner.walk() if isinstance(one, Function) and r in one.args}
        if r.name not in names or (waves and r in inner.exchanged(dict.fromkeys(waves, Number.ZERO)).walk()):
            continue
        if len(waves) > 1 or not all(wave.op in (Op.SIN, Op.COS) for wave in waves):
            continue
        wave = next(iter(waves), r)
        if inner == wave:
            yield "steady.zero", {"wave": wave}
            continue
        over = [term for term in inner.terms if wave not in set(term.walk())]
        under = [_divided(term, wave) for term in inner.terms if wave in set(term.walk())]
        if any(one is None for one in under):
            continue
        above = Form.sum(over).negative
        below = Form.sum(one for one in under if one is not None)
        falls, minus = ([term.split_sign()[0] < 0 for term in side.terms] for side in (above, below))
        if all(minus) or (any(minus) and all(falls)):  # no sign in front that the other side could take
            above, below = above.negative, below.negative
        value = Form.product((above, _taken_out(below).plus_first.power(-1)))
        yield "steady.place" if wave == r else "steady.wave", {"wave": wave, "value": value}


def force_on(lesson: Lesson, masses: Sequence[Mass]) -> list[Expr]:
    """Return the force that holds masses, shape (3,), ground frame, N: rates of momenta less weights."""
    gravity, whole = vector(lesson.scene.gravity, lesson.graph), [lesson.graph.zero] * 3
    for mass in masses:
        moment = [mass.m * x for x in mass.place]
        moment = [a + b for a, b in zip(moment, mass.h, strict=True)] if mass.h is not None else moment
        rate = tangents(tangents(moment, lesson.state.velocity), lesson.state.acceleration)
        whole = [F + a - mass.m * g for F, a, g in zip(whole, rate, gravity, strict=True)]
    return whole


def force_aside(lesson: Lesson, left: Reduced, wave: Form, value: Form) -> Iterator[tuple[str, Form]]:
    """Yield the joint that holds a single point on its circle, and how large its force is at a level place, if so."""
    graph, state, scene = lesson.graph, lesson.state, lesson.scene
    joint = next(one for one in scene.joints if str(left.q.value) in one.coordinates)
    masses = [mass for mass in lesson.masses if mass.body.name == joint.child]
    held = [joint.child in (one.parent for one in scene.joints), *(mass.spins for mass in masses)]
    if held != [False, False] or scene.elements or not left.turns:
        return
    led, still = prescribed(scene, graph), dict.fromkeys([*state.qdd, state.qd[left.r]], graph.zero)
    at = still | dict(zip([state.qd[k] for k in led.place], led.velocity, strict=True))
    square = graph.total(x * x for x in substitute(force_on(lesson, masses), at))
    other = Function(Op.SIN if wave == Function(Op.COS, (named(left.q),)) else Op.COS, (named(left.q),))
    beside = Form.sum((Number.ONE, value.power(2).negative))
    there = Ratios.form_of(square).exchanged({wave: value, other.power(2): beside})
    if not {str(q.value) for q in state.q}.intersection(there.symbols):
        yield joint.name, square_root(Ratios.form_of(there.express(graph)))


def _flat(factor: Form, falls: bool = False) -> tuple[Form, Form] | None:
    """Return the square of a parameter, taken away if it falls, and what it is where a difference is zero, or None."""
    terms = [term.split_sign() for term in factor.terms]
    for (sign, term), (other, rest) in permutations(terms, 2) if len(terms) == 2 else ():
        squared = isinstance(term, Power) and term.exponent == 2 and isinstance(term.base, Symbol)
        if squared and sign * other < 0 and not (falls and sign > 0):
            return term, Form.product((Number(Fraction(abs(other))), rest))
    return None


def waves_first(lesson: Lesson, form: Form) -> Form:
    """Return a slope with sines that are factors in front, and the decimals of the scene in the rest."""
    waves = [x for x in form.factors if isinstance(x, Function)]
    rest = Form.product(x for x in form.factors if x not in waves)
    return Form.product((*waves, in_sines(lesson, rest.express(lesson.graph)) or rest))


def plain(lesson: Lesson, value: Form, of: Form) -> Form:
    """Return a quotient both sides of which are divided by the number below the line of what it comes from."""
    scales = [y.value for x in of.factors for y in (x, *_below(x)) if isinstance(y, Number)]
    scale = max((x.denominator * abs(x) if x.denominator == 1 else x.denominator for x in scales), default=1)
    sides = []
    for side in ([x for x in value.factors if not _below(x)], [y for x in value.factors for y in _below(x)]):
        whole = Form.product((Number(Fraction(1, int(scale))), *side))
        sides.append(in_sines(lesson, whole.express(lesson.graph)) or whole)
    return quotient(sides[:1], sides[1:])


def _below(form: Form) -> tuple[Form, ...]:
    return form.base.power(-form.exponent).factors if isinstance(form, Power) and form.exponent < 0 else ()


def _swing(left: Reduced, wave: Form, value: Form) -> Form | None:
    """Return W''/m where r or cos r has a value, the square of the frequency of small swings; None if not short."""
    lesson, q, qd = left.lesson, left.q, left.lesson.state.qd[left.r]
    (m,) = gradient(gradient(lesson.energy.K, [qd])[0], [qd])
    (bent,) = gradient(gradient(left.static, [q])[0], [q])
    try:
        node = Ratios.form_of(bent / m).express(lesson.graph)  # in cosines, where the sine stands squared
    except (OverflowError, ZeroDivisionError):
        return None
    (there,) = substitute([node], {wave.express(lesson.graph): value.express(lesson.graph)})
    form = None if q in reachable([there]) else in_sines(lesson, there)
    return form.plus_first if form is not None and length(form) <= LONGEST else None


def _reached(left: Reduced, factored: Form, bounds: list[Form], wave: Form, value: Form) -> Iterator[Words]:
    """Yield where r or a sine has a value, from or up to which rate if that is told, and how fast it swings there."""
    lesson, q = left.lesson, named(left.q)
    positive = {one.name for one in lesson.scene.parameters if one.positive}
    divisors = [x for x in value.factors if isinstance(x, Power) and x.exponent == -1]
    below = [x for one in divisors for x in one.base.factors]
    above = [x for x in value.factors if x not in divisors]
    squares = [x for x in below if isinstance(x, Power) and x.exponent == 2 and isinstance(x.base, Symbol)]
    others = Form.product(x for x in below if x not in squares)
    least = quotient(above, [] if others == Number.ONE else [others])
    square = _swing(left, wave, value) if left.led and wave in (q, Function(Op.COS, (q,))) else None
    flat = _flat(square, falls=True) if wave == q and square is not None else None
    flat = flat if flat and positive.issuperset(flat[1].symbols) and left.of(flat[1]) >= 0 else None
    bounds += [value] if wave != q else [quotient(flat[1:], flat[:1])] if flat else []
    if wave == q:
        yield lesson.say("steady.place", wave=wave, value=value)
    elif len(squares) == 1 and len(Form.product(above).terms) == 1 and positive.issuperset(least.symbols):
        least = least.negative if left.of(least) < 0 else least  # a cosine below zero is as small as one above
        yield lesson.say("steady.from", wave=wave, value=value, square=squares[0], least=least)
        flat = squares[0], least
    else:
        yield lesson.say("steady.wave", wave=wave, value=plain(lesson, value, factored))
    if wave == q and flat:
        yield lesson.say("steady.until", square=flat[0], least=flat[1])
    if flat:
        critical = math.sqrt(left.of(flat[1]))
        yield lesson.say("steady.critical", value=f"{lesson.written(critical)} rad/s")
    if square is not None:
        omega = lesson.name("steady:omega", "omega", "s", node=None)
        yield lesson.say("steady.omega", q=q, square=omega.power(2), value=square)


def _divided(term: Form, wave: Form) -> Form | None:
    """Return a term divided by a wave that is one of its factors, None where it is a power of it."""
    rest = [factor for factor in term.factors if factor != wave]
    return None if wave in {one for factor in rest for one in factor.walk()} else Form.product(rest)


def _taken_out(form: Form) -> Form:
    """Return a sum as the factors that all of its terms have, times the rest."""
    terms = [term.split_sign() for term in form.terms]
    shared = [one for one in terms[0][1].factors if all(one in term.factors for _, term in terms)]
    if len(terms) < 2 or not shared:
        return form
    rest = []
    for sign, term in terms:
        left = list(term.factors)
        for one in shared:
            left.remove(one)
        rest.append(Form.product((Number(Fraction(sign)), *left)))
    return Form.product((Form.sum(rest), *shared))


def _numbers(lesson: Lesson, left: Reduced) -> list[Block]:
    """Return the table of steady motions for the values of the lesson."""
    if told := elsewhere(lesson, "steady"):
        return [told]
    if not (found := left.places):
        return [lesson.say("steady.nowhere")]
    units = SceneUnits(lesson.scene).coordinates
    rows = []
    for place, curvature, m in found:
        at = zip(left.cyclic, _rates(left, place), strict=True)
        rates = [lesson.scene.in_shown_unit(lesson.written(x), f"{units[k]}/s") for k, x in at]
        kind = lesson.text("equilibria.stable" if curvature > 0 else "equilibria.unstable")
        time = "–"  # nothing that has inertia moves next to it
        if m > 0:
            root = math.sqrt(abs(curvature) / m)
            time = lesson.text("steady.swing" if curvature > 0 else "steady.leave", rate=lesson.written(root))
        rows.append([lesson.scene.in_shown_unit(lesson.written(place), units[left.r]), *rates, kind, time])
    heads: list[str | Symbol] = [named(left.q), *(named(lesson.state.qd[k]) for k in left.cyclic)]
    key = "steady.numbers.led" if left.led else "steady.numbers.free"
    return [lesson.say(key), lesson.table([*heads, "table.kind", "steady.next"], rows)]


def _rates(left: Reduced, place: float) -> list[float]:
    """Return the rates at a place; what is nothing but rounding beside the others, and the momenta, is zero."""
    if not left.cyclic:
        return []
    found = [float(x) for x in left.rates(place)]
    usual = [abs(x) for x in left.chosen.of(*(left.lesson.state.qd[k] for k in left.cyclic))]
    least = ROUNDING * max(*usual, *map(abs, found), 0.0)
    return [x if abs(x) > least else 0.0 for x in found]
