"""Steps: motions in closed form: forced vibration, and one freedom whose equation knows no position.

Amplitude, phase and resonance are of what a force or a motion cos(Ωt) drives.

Prescribed motions are put in, and the equations taken to first order about rest without the wave:

    M q̈ + D q̇ + K q = F cos(Ωt),     (K - Ω² M + i Ω D) X = F

X is found by Cramer's rule; with damping of one degree of freedom alone. Reference: Meirovitch, Fundamentals of
Vibrations, 3.2.

Without a position, a constant acceleration is integrated twice; with one that is linear in the rate, a - rate/T, the
rate tends to a T, and what is left of the difference fades like exp(-t/T).
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from symdyn.algebra import Floats, Form, Function, Number, Ratios, Symbol
from symdyn.draw import Text
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.emit.print import PrintName, latex_symbols
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.charts import SOLID, Curve, Panel, chart
from symdyn.teach.derivations.precession import NO_FORM, lowest, shortened
from symdyn.teach.derivations.reduced import at_bound
from symdyn.teach.derivations.solved import motions_put_in, quotient, vanishing
from symdyn.teach.document import Block, Formula, Letter, Picture, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

MOST, PLACES = 2, 401
"""Degrees of freedom that have a short form; points of the curve."""

WIDE, TALL = 2.5, 6.0
"""How far the curve goes, over the highest resonance; how high, over the amplitude of a force that does not change."""


@dataclass(frozen=True)
class Forced:
    """The linear equations about rest.

    Attributes:
        free: coordinates without a prescribed motion.
        wave: cos(Ωt), or sin(Ωt).
        rate: Ω.
        M, D, K: entries by row and column.
        F: what stands in front of the wave.
    """

    lesson: Lesson
    free: tuple[int, ...]
    wave: Expr
    rate: Expr
    M: list[list[Expr]]
    D: list[list[Expr]]
    K: list[list[Expr]]
    F: list[Expr]

    @property
    def amplitudes(self) -> list[Expr]:
        """Return X without damping."""
        rows = [
            [lowest(k - self.rate**2 * m) for k, m in zip(*pair, strict=True)]
            for pair in zip(self.K, self.M, strict=True)
        ]
        nodes = [*(x for row in rows for x in row), *self.F]
        field = Ratios(nodes)
        known = dict(zip(nodes, evaluate(nodes, field, field.values()), strict=True))
        found = field.solved([[known[x] for x in row] for row in rows], [[known[x]] for x in self.F])
        return [field.form(x).express(self.rate.graph) for (x,) in found]


def forced(lesson: Lesson) -> Forced | None:
    """Return the linear equations of a mechanism that one wave drives about rest at zero; None of any other."""
    state, graph = lesson.state, lesson.graph
    free = prescribed(lesson.scene, graph).free
    if not 1 <= len(free) <= MOST or len(state.q) != state.n:
        return None
    told = vanishing(lesson, free, motions_put_in(lesson))
    t = graph.symbol(TIME)
    waves = [x for x in reachable(told) if x.op in (Op.SIN, Op.COS) and t in reachable(x.args)]
    if len(waves) != 1:
        return None
    (rate,) = gradient(waves[0].args[0], [t])
    letter = graph.symbol("forced:")
    drives = {graph.symbol(name): graph.zero for name in lesson.scene.drives if name}
    told = substitute(substitute(told, {waves[0]: letter}), drives)
    if t in reachable([rate, *told]):
        return None
    variables = [symbols[k] for symbols in (state.qdd, state.qd, state.q) for k in free]
    rest = dict.fromkeys((*state.q, *state.qd, *state.qdd, letter), graph.zero)
    whole = [substitute(gradient(node, [*variables, letter]), rest) for node in told]
    n, still = len(free), substitute(told, rest)
    M, D, K = ([[lowest(x) for x in row[k * n : k * n + n]] for row in whole] for k in range(3))
    F = [lowest(-row[-1]) for row in whole]
    if not all(lowest(x).is_zero for x in still) or all(x.is_zero for x in F):
        return None
    return Forced(lesson, tuple(free), waves[0], rate, M, D, K, F)


def forced_steps(lesson: Lesson, chosen: Chosen) -> list[Step]:
    """Return amplitude, phase and resonance; none where no wave drives, or nothing has a short form."""
    try:
        one = forced(lesson)
        return [] if one is None else [_equations(one), _response(one, chosen)]
    except NO_FORM:
        return []


def _equations(one: Forced) -> Step:
    """Return the equations to first order."""
    lesson, state, blocks = one.lesson, one.lesson.state, list[Block]()
    for m, d, k, f in zip(one.M, one.D, one.K, one.F, strict=True):
        terms = [
            shortened(lesson, x).signed_product(named(symbols[i]))
            for row, symbols in ((m, state.qdd), (d, state.qd), (k, state.q))
            for i, x in zip(one.free, row, strict=True)
            if not x.is_zero
        ]
        right = Form.product((shortened(lesson, f), Form.of(one.wave))) if not f.is_zero else Number.ZERO
        blocks.append(Formula("", Form.sum(terms), right=right))
    q = together([named(state.q[k]) for k in one.free])
    return Step("forced", lesson.say("forced", wave=Form.of(one.wave), q=q), tuple(blocks), lesson.say("forced.reason"))


def _response(one: Forced, chosen: Chosen) -> Step:
    """Return the amplitude of every coordinate, the phase, and where it is largest."""
    lesson, rate = one.lesson, one.rate
    damped = any(not x.is_zero for row in one.D for x in row)
    symbols = [
        lesson.called(f"forced:X:{k + 1}", Letter("X", (str(k + 1),) if len(one.free) > 1 else ())) for k in one.free
    ]
    blocks, at = list[Block](), Form.of(rate)
    own = shortened(lesson, lowest(one.K[0][0] / one.M[0][0]))
    tried = at_bound(lesson, chosen, quotient([own], [at.power(2)])) if len(one.free) == 1 else None
    if damped and len(one.free) > 1:
        blocks.append(lesson.say("forced.undamped"))
    if damped and len(one.free) == 1:
        (m,), (d,), (k,), (f,) = one.M[0], one.D[0], one.K[0], one.F
        less = Form.product((Number.MINUS_ONE, shortened(lesson, m), at.power(2)))
        stiff = Form.sum((*shortened(lesson, k).terms, less))
        under = Form.sum((stiff.power(2), shortened(lesson, rate**2 * d**2)))
        form = Form.product((shortened(lesson, f), Function(Op.SQRT, (under,)).power(-1)))
        blocks.append(Formula("", symbols[0], right=form))
        phase = lesson.called("forced:delta", Letter("delta"))
        lag = Form.product((shortened(lesson, rate * d), stiff.power(-1)))
        blocks.append(lesson.say("forced.phase", lag=lag, delta=phase, square=at.power(2), own=own))
        peak = lowest(k / m - d**2 / m**2 / 2)
        blocks.append(lesson.say("forced.peak", square=at.power(2), peak=shortened(lesson, peak)))
    else:
        blocks += [
            Formula("", x, right=shortened(lesson, node)) for x, node in zip(symbols, one.amplitudes, strict=True)
        ]
        if len(one.free) == 1:
            blocks.append(lesson.say("forced.resonance", square=at.power(2), own=own))
        else:
            blocks.append(lesson.say("forced.resonances"))
    blocks += _curve(one, chosen)
    claim = lesson.say("forced.response", rate=at, amplitudes=together(symbols))
    reason, tries = lesson.say("forced.response.reason"), tuple(filter(None, [tried]))
    return Step("forced.response", claim, tuple(blocks), reason, show=("plots", "forces"), tries=tries)


def _curve(one: Forced, chosen: Chosen) -> list[Block]:
    """Return the amplitudes over Ω, for the values of the lesson; none where a parameter is what Ω is made of."""
    lesson, n = one.lesson, len(one.free)
    if one.rate.op is not Op.SYMBOL:
        return []
    fixed = {x: value for x, value in chosen.values.items() if x is not one.rate}
    nodes = [x for rows in (one.M, one.D, one.K) for row in rows for x in row]
    M, D, K = np.array(chosen.of(*nodes)).reshape(3, n, n)
    own = np.abs(np.linalg.eigvals(np.linalg.solve(M, K)))
    last = WIDE * math.sqrt(float(own.max()))
    x = np.linspace(last / PLACES, last, PLACES)
    F = np.array([[float(v) for v in evaluate(one.F, Floats(), {**fixed, one.rate: w})] for w in x])
    X = np.abs(np.array([np.linalg.solve(K - w * w * M + 1j * w * D, f) for w, f in zip(x, F, strict=True)]))
    top = float(min(X.max(), TALL * np.median(X.max(axis=1))))
    units, spelled, shown = SceneUnits(lesson.scene).coordinates, latex_symbols(lesson.scene), lesson.scene.shown_unit
    panels = []
    for i, k in enumerate(one.free):
        across = Text.of_name(spelled[str(one.rate.value)]).with_unit(shown("rad/s"))
        up = Text.of_name("X" if n == 1 else f"X_{{{k + 1}}}").with_unit(shown(units[k]))
        panels.append(Panel(across, up, (0.0, 0.0), (last, 1.05 * top), [Curve(np.stack([x, X[:, i]], axis=1), SOLID)]))
    title = lesson.text("forced.alt", scene=lesson.scene.name)
    return [Picture(chart(title, panels, lesson.written, "forced-"), lesson.say("forced.curve"), title, "forced")]


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
        moving = {*state.q, rate, graph.symbol(TIME), *state.clock}
        if moving.intersection(reachable([gain, slope])) or (gain.is_zero and slope.is_zero):
            return []
        if not lowest(found - gain - slope * rate).is_zero:  # a sign of the rate, or a branch
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
