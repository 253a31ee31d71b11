"""Steps: where a tied mechanism rests or turns steadily with one coordinate that decides, in closed form: a governor.

With the dependent coordinates put in, W = P - K of the motion in which cyclic rates alone are not zero depends on one
coordinate r. It rests, or turns on steadily, where dW/dr = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from symdyn.algebra import Floats, Form, Function, Number, Pi, Power, Ratios, Symbol
from symdyn.draw import Text
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.emit.print import latex_symbols
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, evaluate, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.charts import DASHED, Curve, Panel, chart
from symdyn.teach.derivations.constrained import Constrained
from symdyn.teach.derivations.precession import NO_FORM, shortened
from symdyn.teach.derivations.reduced import zero
from symdyn.teach.derivations.solved_ties import closed_positions
from symdyn.teach.derivations.steady import level_places, plain, waves_first
from symdyn.teach.document import Block, Formula, Picture, Step, Try, Words
from symdyn.teach.lesson import named
from symdyn.teach.shown_state import Chosen

FASTEST = 2.0
"""Over the larger of the starting rate and the critical one: where the curve ends."""

PLACES = 241
"""Points of the curve."""

ROWS = 6
"""Round rates of the table, at most."""

STILL = 1e-6
"""rad/s: a frequency that is none."""


@dataclass(frozen=True)
class OneLeft:
    """A tied mechanism in which one coordinate decides."""

    lesson: Constrained
    r: int  # which
    c: tuple[int, ...]  # the cyclic velocities
    put: dict[Expr, Expr]  # by symbols and waves of dependent coordinates, what they are by r
    W: Expr  # P - K with the rates of c alone

    @property
    def slope(self) -> Form:
        """Return dW/dr in factors."""
        return Ratios.form_of(gradient(self.W, [self.lesson.state.q[self.r]])[0])

    @property
    def shown(self) -> list[int]:
        """The coordinates whose places are told."""
        return [k for k in range(self.lesson.state.n) if k not in self.c]

    def at(self, chosen: Chosen, r: float) -> tuple[Chosen, list[str | Form | Words]]:
        """Return a state with r, and places of coordinates there in print."""
        lesson, units = self.lesson, SceneUnits(self.lesson.scene).coordinates
        at = chosen.with_values({lesson.state.q[self.r]: r})
        at = at.with_values({x: at.of(node)[0] for x, node in self.put.items() if x.op is Op.SYMBOL})
        told = [(lesson.written(at.values[lesson.state.q[k]]), units[k]) for k in self.shown]
        return at, [lesson.scene.in_shown_unit(*one) for one in told]

    def squares(self) -> tuple[Expr, Expr]:
        """Return ω² of small swings about a steady motion: the rate of c held, and its momentum kept.

        With m of r, N of c, and M of both in K: W''/m, and (W'' + u² N'²/N)/(m - M²/N).
        """
        lesson, state, graph = self.lesson, self.lesson.state, self.lesson.graph
        q, v, u = state.q[self.r], state.qd[self.r], state.qd[self.c[0]]
        rates = {state.qd[k]: gradient(self.put[x], [q])[0] * v for k, x in enumerate(state.q) if x in self.put}
        still = {state.q[k]: graph.zero for k in self.c}
        (K,) = substitute(substitute(substitute([lesson.energy.K], rates), self.put), still)
        m, M, N = (gradient(gradient(K, [x])[0], [y])[0] for x, y in ((v, v), (v, u), (u, u)))
        (bent,) = gradient(gradient(self.W, [q])[0], [q])
        (steeper,) = gradient(N, [q])
        return bent / m, (bent + u**2 * steeper**2 / N) / (m - M**2 / N)


def one_left(lesson: Constrained) -> OneLeft | None:
    """Return the coordinate that decides, where the others follow from it without roots; None where there is none."""
    state, graph = lesson.state, lesson.graph
    slips = any(tie.residual is None for tie in lesson.ties)
    if len(state.q) != state.n or lesson.scene.prescribed_velocities or slips:
        return None
    held = {x for tie in lesson.ties for x in lesson.tie_form(tie.nodes[-1]).symbols}
    c = tuple(k for k, q in enumerate(state.q) if str(q.value) not in held and zero(lesson, lesson.slopes[k]))
    others = [k for k in range(state.n) if k not in c]
    if len(lesson.partition.independent) - len(c) != 1:
        return None
    still = {state.qd[k]: graph.zero for k in others} | {state.q[k]: graph.zero for k in c}
    whole, *acting = substitute([-lesson.L, *generalized_forces(lesson.scene, graph)], still)
    if not all(x.is_zero for x in acting) or graph.symbol(TIME) in reachable([whole]):
        return None
    for r in others:
        if put := closed_positions(lesson, [k for k in others if k != r]):
            return OneLeft(lesson, r, c, put, substitute([whole], put)[0])
    return None


def tied_steady_steps(lesson: Constrained, chosen: Chosen) -> tuple[list[Step], list[Step]]:
    """Return the steps on rests that a search with all conditions misses, and on steady motions."""
    try:
        left = one_left(lesson)
        if left is None:
            return [], []
        return _rests(left, chosen), _turning(left, chosen)
    except NO_FORM:
        return [], []


def _places(form: Form, r: Symbol, chosen: Chosen, left: OneLeft) -> Iterator[tuple[float, Form | None]]:
    """Yield values of r at which a slope vanishes, and exact ones."""
    quarter = {Op.SIN: ((0.0, Number.ZERO), (math.pi, Pi())), Op.COS: ()}
    for key, places in level_places(form, r, frozenset()):
        wave = places["wave"]
        if not isinstance(wave, Function) or wave.args != (r,):
            continue
        if key == "steady.zero":
            yield from quarter[wave.op]
        elif key == "steady.wave" and wave.op is Op.COS:
            (value,) = chosen.of(places["value"].express(left.lesson.graph))
            if abs(value) < 1:
                yield from ((sign * math.acos(value), None) for sign in (1, -1))


def _rests(left: OneLeft, chosen: Chosen) -> list[Step]:
    """Return the table of rests, where at one of them conditions say the same; else none, for a search finds them."""
    lesson, state, graph = left.lesson, left.lesson.state, left.lesson.graph
    rates = {state.qd[k]: graph.zero for k in left.c}
    (W,) = substitute([left.W], rates)
    q = state.q[left.r]
    (slope,) = gradient(W, [q])
    (bent,) = gradient(slope, [q])
    form, r = Ratios.form_of(slope), named(q)
    rows, singular = [], False
    slopes = [x for tie in lesson.ties for x in tie.slopes]
    for value, exact in _places(form, r, chosen, left):
        at, cells = left.at(chosen, value)
        A = np.array(at.of(*slopes)).reshape(len(lesson.ties), -1)
        singular |= int(np.linalg.matrix_rank(A, tol=1e-9)) < len(A)
        if exact is not None:
            cells[left.shown.index(left.r)] = exact
        rows.append([*cells, lesson.say("equilibria.stable" if at.of(bent)[0] > 0 else "equilibria.unstable")])
    if not singular:
        return []
    P = lesson.name("P:tied", "P", node=W)
    symbol = lesson.slope(P.name, r.name, slope)
    blocks: list[Block] = [
        Formula(symbol.name, waves_first(lesson, form)),
        lesson.table([*(named(state.q[k]) for k in left.shown), "table.kind"], rows),
        lesson.say("tied.singular"),
    ]
    claim, reason = lesson.say("tied.rests", r=r), lesson.say("tied.rests.reason", P=P)
    return [Step("equilibria.one", claim, tuple(blocks), reason, show=("weights", "forces"))]


def _turning(left: OneLeft, chosen: Chosen) -> list[Step]:
    """Return where r stays while one coordinate turns on, and its curve over the rate."""
    if len(left.c) != 1:
        return []
    lesson, state = left.lesson, left.lesson.state
    r, u = named(state.q[left.r]), state.qd[left.c[0]]
    W = lesson.name("W:", "W", node=left.W)
    (node,) = gradient(left.W, [state.q[left.r]])
    symbol, form = lesson.slope(W.name, r.name, node), left.slope
    blocks: list[Block] = [
        Formula(W.name, shortened(lesson, left.W)),
        lesson.say("steady.level"),
        Formula(symbol.name, waves_first(lesson, form)),
    ]
    tries: tuple[Try, ...] = ()
    for key, places in level_places(form, r, {str(u.value)}):
        least = _least(left, places["value"], u) if key == "steady.wave" else None
        shown = {name: plain(lesson, one, form) if name == "value" else one for name, one in places.items()}
        if least is None:
            blocks.append(lesson.say(key, **shown))
            continue
        told = plain(lesson, Ratios.form_of(least), form)
        blocks.append(lesson.say("steady.from", **shown, square=named(u).power(2), least=told))
        critical, wave = chosen.of(least)[0], places["wave"]
        if critical > 0 and isinstance(wave, Function) and wave.op is Op.COS:
            value, rate = places["value"].express(lesson.graph), math.sqrt(critical)
            blocks.append(lesson.say("steady.critical", value=f"{lesson.written(rate)} rad/s"))
            tries = (Try(str(u.value), rate, "rad/s"),)
            last = FASTEST * max(abs(chosen.values[u]), rate)
            blocks += [_curve(left, chosen, value, rate, last), *_numbers(left, chosen, value, rate, last)]
    claim = lesson.say("tied.turning", q=r, c=named(state.q[left.c[0]]))
    reason = lesson.say("steady.led.reason", W=W)
    return [Step("steady.curve", claim, tuple(blocks), reason, show=("centrifugal", "weights"), tries=tries)]


def _least(left: OneLeft, value: Form, u: Expr) -> Expr | None:
    """Return u² where a cosine is one; None where that is no equation in u² alone."""
    graph = left.lesson.graph
    over = [x for x in Ratios.form_of(value.express(graph) - 1).factors if str(u.value) in x.symbols]
    over = [x for x in over if not (isinstance(x, Power) and x.exponent < 0)]
    if len(over) != 1:
        return None
    node = over[0].express(graph)
    (first,) = gradient(node, [u])
    (second,) = gradient(first, [u])
    slope, rest = substitute([first, node], {u: graph.zero})
    if not slope.is_zero or second.is_zero or u in reachable([second]):
        return None
    return -2 * rest / second


def _curve(left: OneLeft, chosen: Chosen, value: Expr, critical: float, last: float) -> Picture:
    """Return r over the rate: both branches, that of r = 0 dashed from the critical rate on."""
    lesson, state = left.lesson, left.lesson.state
    u, fixed = state.qd[left.c[0]], {x: one for x, one in chosen.values.items() if x is not state.qd[left.c[0]]}
    x = np.linspace(0.0, last, PLACES)
    cosine = np.array([float(evaluate([value], Floats(), {**fixed, u: one})[0]) for one in x])
    with np.errstate(invalid="ignore"):
        lifted = np.where(np.abs(cosine) <= 1, np.arccos(cosine), np.nan)
    ends = np.array([[critical, 0.0]])
    curves = [
        Curve(np.concatenate([ends, np.stack([x, lifted], axis=1)[np.isfinite(lifted)]])),
        Curve(np.array([[0.0, 0.0], [critical, 0.0]])),
        Curve(np.array([[critical, 0.0], [last, 0.0]]), DASHED),
    ]
    symbols, shown = latex_symbols(lesson.scene), lesson.scene.shown_unit
    across = Text.of_name(symbols[str(u.value)]).with_unit(shown("rad/s"))
    up = Text.of_name(symbols[str(state.q[left.r].value)]).with_unit(shown("rad"))
    panel = Panel(across, up, (0.0, 0.0), (last, math.pi / 2), curves, (), (False, True))
    title = lesson.text("tied.curve.alt", scene=lesson.scene.name)
    return Picture(chart(title, [panel], lesson.written, "steady-"), lesson.say("tied.curve"), title, "steady")


def _numbers(left: OneLeft, chosen: Chosen, value: Expr, critical: float, last: float) -> list[Block]:
    """Return the table of the branch over the rate, with both frequencies, and what tells them apart."""
    lesson, state, u, squares = left.lesson, left.lesson.state, left.lesson.state.qd[left.c[0]], left.squares()
    step = min(x for k in range(-9, 9) for x in (10.0**k, 2 * 10.0**k, 5 * 10.0**k) if x * ROWS >= last)
    whole = [k * step for k in range(1, ROWS + 1) if critical < k * step <= last]
    rows = []
    for rate in sorted({critical, *whole, max(abs(chosen.values[u]), critical)}):
        turning = chosen.with_values({u: rate})
        (cosine,) = turning.of(value)
        at, places = left.at(turning, math.acos(max(cosine, -1.0)) if cosine < 1 - STILL**2 else 0.0)
        found = [math.sqrt(x) if x > STILL**2 else 0.0 for x in at.of(*squares)]
        rows.append([f"{lesson.written(rate)} rad/s", *places, *(f"{lesson.written(x)} rad/s" for x in found)])
    c, own = named(state.q[left.c[0]]), lesson.scene.drives[left.c[0]]
    heads: list[str | Symbol] = [named(u), *(named(state.q[k]) for k in left.shown), "tied.held", "tied.free"]
    said = lesson.say("tied.apart", c=c, rate=named(u), q=named(state.q[left.r]))
    drive = [lesson.say("tied.drive", drive=Symbol(own))] if own else []
    return [lesson.say("steady.numbers.led"), lesson.table(heads, rows), said, *drive]
