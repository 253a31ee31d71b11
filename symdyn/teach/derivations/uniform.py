"""Steps: the motion in time of one freedom whose equation knows no position, and at most its rate.

With a constant acceleration it is integrated twice; with one that is linear in the rate, a - rate/T, the rate tends to
a T, and what is left of the difference fades like exp(-t/T).
"""

from __future__ import annotations

from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Symbol
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.emit.print import PrintName, latex_symbols
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, gradient, reachable, substitute
from symdyn.scene.values import acceleration_name
from symdyn.teach.derivations.precession import NO_FORM, lowest, shortened
from symdyn.teach.derivations.solved import vanishing
from symdyn.teach.document import Block, Formula, Letter, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen


def uniform_steps(lesson: Lesson, chosen: Chosen) -> list[Step]:
    """Return the motion while what drives it is constant; none where a position or the time acts, or nothing does."""
    state, graph = lesson.state, lesson.graph
    if len(state.q) != 1 or state.n != 1 or not prescribed(lesson.scene, graph).free:
        return []
    (told,) = vanishing(lesson, [0], {})
    try:
        (rate,), (inertia,) = state.qd, gradient(told, state.qdd)
        found = lowest(-substitute([told], {state.qdd[0]: graph.zero})[0] / inertia)
        gain, slope = (lowest(x) for x in (substitute([found], {rate: graph.zero})[0], *gradient(found, [rate])))
        derived = {x.name for x in lesson.scene.derived}
        states = (x.name for x in lesson.scene.parameters if acceleration_name(x.name) in derived)
        moving = {*state.q, rate, graph.symbol(TIME), *state.clock, *map(graph.symbol, states)}
        if moving.intersection(reachable([gain, slope])) or (gain.is_zero and slope.is_zero):
            return []
        if not slope.is_zero and chosen.of(slope)[0] >= 0:  # driven by its own rate: it runs away
            return []
        return [_accelerated(lesson, gain) if slope.is_zero else _settling(lesson, chosen, gain, slope)]
    except NO_FORM:
        return []


def _letter(lesson: Lesson, below: str, dots: int = 0) -> Symbol:
    """Return the letter of the coordinate with one more index."""
    look = PrintName.of_latex(latex_symbols(lesson.scene)[lesson.scene.coordinates[0]])
    if "_" in look.head:
        raise DerivationError("a symbol of one's own with an index in it takes no other")
    index = (look.subscript, below) if look.subscript else (below,)
    return lesson.called(f"uniform:{below}{dots}", Letter(look.head, index, dots))


def _held(lesson: Lesson, gain: Expr) -> Words:
    """Return what has to be constant, the drive."""
    drives = [Symbol(x) for x in lesson.scene.drives if x and lesson.graph.symbol(x) in reachable([gain])]
    return lesson.say("uniform.held", drives=together(drives)) if drives else Words(())


def _accelerated(lesson: Lesson, gain: Expr) -> Step:
    q, rate, t, a = lesson.state.q[0], lesson.state.qd[0], Symbol(TIME), shortened(lesson, gain)
    first, start = _letter(lesson, "0"), _letter(lesson, "0", 1)
    half = Form.product((Number(Fraction(1, 2)), *a.factors, t.power(2)))
    blocks = (
        Formula("", named(rate), right=Form.sum((start, Form.product((*a.factors, t))))),
        Formula("", named(q), right=Form.sum((first, Form.product((start, t)), half))),
    )
    return Step("uniform", lesson.say("uniform", held=_held(lesson, gain)), blocks, lesson.say("uniform.reason"))


def _settling(lesson: Lesson, chosen: Chosen, gain: Expr, slope: Expr) -> Step:
    t, rate, time = Symbol(TIME), named(lesson.state.qd[0]), lowest(-1 / slope)
    blocks, start = list[Block](), _letter(lesson, "0", 1)
    fading = Function(Op.EXP, (shortened(lesson, slope).signed_product(t),))
    if gain.is_zero:
        blocks.append(Formula("", rate, right=Form.product((start, fading))))
    else:
        steady = _letter(lesson, "s", 1)
        blocks.append(Formula("", steady, right=shortened(lesson, lowest(gain * time))))
        left = Form.product((Form.sum((start, steady.negative)), fading))
        blocks.append(Formula("", rate, right=Form.sum((steady, left))))
    value = lesson.about(chosen.of(time)[0])
    blocks.append(lesson.say("uniform.time", time=shortened(lesson, time), value=f"{value} s"))
    claim = lesson.say("uniform.fades" if gain.is_zero else "uniform.settles", rate=rate, held=_held(lesson, gain))
    reason = lesson.say("uniform.first").parts + (() if gain.is_zero else (" ", *lesson.say("uniform.steady").parts))
    return Step("uniform", claim, tuple(blocks), Words(reason))
