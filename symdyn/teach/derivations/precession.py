"""Steps: what turns steadily, in closed form from cyclic coordinates: precession, critical spin, nutation.

    r     what stays                          c     a cyclic coordinate whose rate is looked for
    s     the other cyclic ones, whose spins ω_s = p_s/M_ss stay; every M_ss is constant
    N     M_cc - Σ M_cs²/M_ss                 m     M_rr - M_rc M_cc⁻¹ M_cr, the inertia of r, momenta kept
    V     P + ½ (p_c - Σ M_cs ω_s)²/N + Σ ½ p_s²/M_ss, in which r moves alone

r stays where a ċ² + b ċ + d = 0. Next to such a motion it swings with ω² = V''/m, that condition put in.
Where the axes of c and s coincide, N and the bracket above it vanish; the limit of V tells from which spin on a motion
stands upright.

Reference: Goldstein, Classical Mechanics, 5.7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Pi, Power, Ratios, Sum, Symbol
from symdyn.dynamics.mechanism import vector
from symdyn.emit.print import text_of
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, gradient, reachable, substitute
from symdyn.teach.derivations.reduced import Reduced
from symdyn.teach.derivations.short_sines import in_sines
from symdyn.teach.derivations.solved import NO_SHORT_FORM, Quotients, quotient
from symdyn.teach.derivations.velocities import length
from symdyn.teach.document import Block, Formula, Letter, Step, Words
from symdyn.teach.lesson import Lesson, named, together

LONGEST = 60  # terms and factors of a formula that is shown
NO_FORM = NO_SHORT_FORM  # what says that something has no closed form
WIDEST = 240  # characters of the frequency of nutation

TWO, HALF = Number(Fraction(2)), Fraction(1, 2)

PARTS = (Fraction(1, 6), Fraction(1, 3), HALF, Fraction(2, 3), Fraction(5, 6))
"""Inclinations in the table of precessions, over π."""


@dataclass(frozen=True)
class Precession:
    """Where r stays while a cyclic coordinate turns: a ċ² + b ċ + d = 0.

    Attributes:
        c: the cyclic coordinate.
        M: entries of the mass matrix by numbers of coordinates.
        spins: by the other cyclic ones, the symbol of the spin.
        a, b, d: nodes in r, spins and parameters.
        still: whether r stays where ċ = 0, too.
    """

    left: Reduced
    c: int
    M: Mapping[tuple[int, int], Expr]
    spins: Mapping[int, Expr]
    a: Expr
    b: Expr
    d: Expr
    still: bool

    @property
    def rate(self) -> Expr:
        """Return ċ."""
        return self.left.lesson.state.qd[self.c]

    @property
    def size(self) -> int:
        """Return how long it is."""
        return sum(length(Form.of(x)) for x in (self.a, self.b, self.d))

    @property
    def around(self) -> Expr:
        """Return N, what turns about c beside the spins."""
        less = [self.M[self.c, s] ** 2 / self.M[s, s] for s in self.spins]
        return lowest(self.M[self.c, self.c] - self.left.lesson.graph.total(less))

    @property
    def carried(self) -> Expr:
        """Return Σ M_cs ω_s, the momentum of c that the spins carry."""
        return self.left.lesson.graph.total(self.M[self.c, s] * spin for s, spin in self.spins.items())

    def potential(self, push: Expr) -> Expr:
        """Return P + ½ push²/N, what r moves in."""
        lesson = self.left.lesson
        (P,) = substitute([lesson.energy.P], {lesson.state.q[k]: lesson.graph.zero for k in self.left.cyclic})
        return P if push.is_zero else P + lowest(push**2 / self.around / 2)


def precession_steps(
    left: Reduced, momenta: Mapping[int, Symbol] | None = None, spins: Mapping[int, float] | None = None
) -> list[Step]:
    """Return the steps on steady motions in closed form; none where a motion is prescribed, or nothing is short.

    Args:
        left: the one freedom that is left.
        momenta: by cyclic coordinate, what its momentum is called; p1, p2 by the number of the coordinate.
        spins: by cyclic coordinate, rad/s, for which precessions are told in numbers; those of the state when left out.
    """
    if not left.cyclic or not left.couples:
        return []
    p = momenta or {k: Symbol(f"p:{k + 1}") for k in left.cyclic}
    try:
        M = _inertia(left)
        found = [one for c in left.cyclic if (one := _condition(left, c, M)) is not None]
        one = min(found, key=lambda one: one.size)
        told = _named_spins(one)
    except (*NO_FORM, ValueError):
        return []
    steps = list[Step]()
    kinds: tuple[Callable[[], list[Step]], ...] = (
        lambda: _effective(one, p, told), lambda: _steady(one, spins or {}), lambda: _upright(one),
        lambda: _nutation(one),
    )  # fmt: skip
    for kind in kinds:
        try:
            steps += kind()
        except NO_FORM:
            continue
    return steps


def shortened(lesson: Lesson, node: Expr) -> Form:
    """Return a node as a quotient in print; one of `NO_FORM` is raised where it has none that is short."""
    form = in_sines(lesson, node)
    parts = () if form is None else form.factors
    if form is None or any(_divides(x) for x in parts) or any(_divides(x, Sum) for x in form.walk()):
        write = Quotients(lesson, [node])
        form = quotient(*write.parts(write.known[node]))
    if length(form) > LONGEST:
        raise OverflowError("a formula that is no short one")
    return form


def _divides(form: Form, base: type[Form] = Form) -> bool:
    return isinstance(form, Power) and form.exponent < 0 and isinstance(form.base, base)


def lowest(node: Expr) -> Expr:
    """Return a quotient in lowest terms."""
    return Ratios.form_of(node).express(node.graph)


def _inertia(left: Reduced) -> dict[tuple[int, int], Expr]:
    """Return the mass matrix of r and the cyclic coordinates."""
    lesson, order = left.lesson, (left.r, *left.cyclic)
    none = {lesson.state.q[k]: lesson.graph.zero for k in left.cyclic}
    rows = {i: gradient(substitute([lesson.momenta[i]], none)[0], lesson.state.qd) for i in order}
    return {(i, j): lowest(rows[i][j]) for i in order for j in order}


def _condition(left: Reduced, c: int, M: Mapping[tuple[int, int], Expr]) -> Precession | None:
    """Return the condition for one cyclic coordinate; None where the others have no constant spin."""
    lesson, u, others = left.lesson, left.lesson.state.qd[c], [k for k in left.cyclic if k != c]
    alone = all(M[s, k].is_zero for s in others for k in others if s != k)
    if not alone or any(M[s, s].is_zero or left.q in reachable([M[s, s]]) for s in others):
        return None
    spins = {s: lesson.graph.symbol(f"spin:{s + 1}") for s in others}
    rates = {lesson.state.qd[s]: spin - M[s, c] / M[s, s] * u for s, spin in spins.items()}
    (slope,) = substitute(gradient(left.static, [left.q]), rates)
    factors = Ratios.form_of(slope).factors
    turning = [x for x in factors if str(u.value) in x.symbols]
    scale = [x.base for x in factors if isinstance(x, Power) and x.exponent == -1 and isinstance(x.base, Number)]
    found = [x for x in turning if x != named(u)]
    if len(found) != 1 or isinstance(found[0], Power):
        return None
    node, none = found[0].express(lesson.graph), {u: lesson.graph.zero}
    for x in scale:  # of decimals of the scene
        node = node / x.value
    (first,) = gradient(node, [u])
    (second,) = gradient(first, [u])
    b, d = substitute([first, node], none)
    a = second / 2
    if u in reachable([a]) or (b.is_zero and d.is_zero):
        return None
    if not a.is_zero and left.chosen.of(a)[0] < 0:
        a, b, d = -a, -b, -d
    return Precession(left, c, M, spins, a, b, d, named(u) in turning)


def _named_spins(one: Precession) -> list[Block]:
    """Name the spins, and return what those are that have not been named."""
    lesson, blocks = one.left.lesson, list[Block]()
    for s in one.spins:
        if f"spin:{s + 1}" not in lesson.names:
            node = lesson.momenta[s] / one.M[s, s]
            symbol = lesson.name(f"spin:{s + 1}", "omega", str(s + 1), node=node)
            blocks.append(Formula(symbol.name, shortened(lesson, node)))
    return blocks


def _effective(one: Precession, p: Mapping[int, Symbol], told: list[Block]) -> list[Step]:
    """Return the potential in which r moves alone, the momenta put in, and the spins."""
    lesson, graph, left = one.left.lesson, one.left.lesson.graph, one.left
    momenta = {k: graph.symbol(p[k].name) for k in left.cyclic}
    moment = momenta[one.c] - graph.total(one.M[one.c, s] * momenta[s] / one.M[s, s] for s in one.spins)
    under = Form.product((TWO, *shortened(lesson, one.around).factors))
    parts = [Form.product((shortened(lesson, moment).power(2), under.power(-1)))]
    parts += [shortened(lesson, momenta[s] ** 2 / one.M[s, s] / 2) for s in one.spins]
    form = Form.sum((*parts, *shortened(lesson, lesson.energy.P).terms))
    (node,) = substitute([form.express(graph)], {momenta[k]: lesson.momenta[k] for k in left.cyclic})
    symbol = lesson.called("V:kept", Letter("V"), node)
    q, names = named(left.q), together([p[k] for k in left.cyclic])
    blocks: list[Block] = [Formula(symbol.name, form)]
    if told:
        said = [lesson.say("effective.spin", momentum=p[s], inertia=shortened(lesson, one.M[s, s])) for s in one.spins]
        blocks += [*said[:1], *told]
    claim, reason = lesson.say("effective", q=q, names=names), lesson.say("effective.reason", V=symbol)
    return [Step("effective", claim, tuple(blocks), reason, show=("phase", "momenta"))]


def _steady(one: Precession, spins: Mapping[int, float]) -> list[Step]:
    """Return the rates at which r stays: of a quadratic equation both, and where they are real."""
    lesson, q, u = one.left.lesson, named(one.left.q), named(one.rate)
    a, b, d = (shortened(lesson, x) if not x.is_zero else Number.ZERO for x in (one.a, one.b, one.d))
    terms = [*Form.product((a, u.power(2))).terms, *b.signed_product(u).terms, *d.terms]
    blocks: list[Block] = [Formula("", Form.sum(terms), right=Number.ZERO)]
    if one.a.is_zero:
        blocks.append(Formula("", u, right=shortened(lesson, -one.d / one.b)))
    elif one.b.is_zero:
        blocks.append(Formula("", u.power(2), right=shortened(lesson, -one.d / one.a)))
        blocks += [lesson.say("precession.conical")] if _hangs_alone(one) else []
    else:
        blocks += [*_both(one, a, b), *_in_numbers(one, spins)]
    blocks += [lesson.say("precession.still", rate=u)] if one.still else []
    claim = lesson.say("precession", q=q, rate=u)
    return [Step("precession", claim, tuple(blocks), show=("centrifugal", "weights"))]


def _both(one: Precession, a: Form, b: Form) -> list[Block]:
    """Return both rates, where they are real, and what they tend to as the spin grows."""
    lesson, rate = one.left.lesson, one.rate
    under = shortened(lesson, one.b**2 - 4 * one.a * one.d)
    root, below = Function(Op.SQRT, (under,)), Form.product((TWO, *a.factors))
    at = one.left.chosen.with_values(dict.fromkeys(one.spins.values(), 1.0))
    slow = -1 if at.of(one.b)[0] < 0 else 1  # the root that takes from the size of b
    blocks: list[Block] = [lesson.say("precession.both")]
    for sign in (slow, -slow):
        above = Form.sum((*b.negative.terms, *Form.product((Number(Fraction(sign)), root)).terms))
        blocks.append(Formula("", named(rate), right=quotient([above], list(below.factors))))
    if len(one.spins) == 1:
        (spin,) = one.spins.values()
        slope = one.b / spin
        if spin not in reachable([lowest(slope)]):
            least = shortened(lesson, 4 * one.a * one.d / lowest(slope) ** 2)
            blocks.append(lesson.say("precession.real", square=named(spin).power(2), least=least))
            ends = (shortened(lesson, -one.d / one.b), shortened(lesson, -one.b / one.a))
            blocks.append(lesson.say("precession.fast", spin=named(spin), slow=ends[0], fast=ends[1]))
    return blocks


def _in_numbers(one: Precession, spins: Mapping[int, float]) -> list[Block]:
    """Return what is left where the first coefficient vanishes, and both rates over the inclination."""
    lesson, left, rate = one.left.lesson, one.left, named(one.rate)
    level = lesson.graph.cos(left.q)
    if len(one.spins) != 1 or not left.turns or not lowest(substitute([one.a], {level: lesson.graph.zero})[0]).is_zero:
        return []
    ((s, spin),) = one.spins.items()
    value = spins.get(s) or left.chosen.of(lesson.momenta[s] / one.M[s, s])[0]
    rows = list[list[str | Form]]()
    for part in PARTS:
        at = left.chosen.with_values({left.q: float(part) * math.pi, spin: value})
        a, b, d = (0.0 if part == HALF else at.of(one.a)[0], *at.of(one.b, one.d))
        root, slow = b * b - 4 * a * d, -1 if b < 0 else 1
        found = (
            [-d / b] if not a else [] if root < 0 else [(-b + k * slow * math.sqrt(root)) / (2 * a) for k in (1, -1)]
        )
        told = [f"{lesson.written(x)} rad/s" for x in found]
        rows.append([Form.product((Number(part), Pi())), *told, *["–"] * (2 - len(told))])
    said = lesson.say("precession.level", wave=Form.of(level), rate=rate, slow=shortened(lesson, -one.d / one.b))
    table = lesson.table([named(left.q), "precession.slow", "precession.quick"], rows)
    return [said, lesson.say("precession.numbers", spin=named(spin), value=f"{lesson.written(value)} rad/s"), table]


def _hangs_alone(one: Precession) -> bool:
    """Tell whether one particle moves on a sphere about a fixed point under gravity."""
    lesson = one.left.lesson
    weighs = [mass for mass in lesson.masses if not mass.m.is_zero or mass.spins]
    if len(weighs) != 1 or not weighs[0].particle or lesson.scene.elements:
        return False
    square = lesson.graph.total(x * x for x in weighs[0].place)
    return all(lesson.vanishes(x) for x in gradient(square, lesson.state.q))


def _upright(one: Precession) -> list[Step]:
    """Return, of places where the axes of c and s coincide, from which spin on they are stable."""
    lesson, left, graph, steps = one.left.lesson, one.left, one.left.lesson.graph, list[Step]()
    if not left.turns or len(one.spins) > 1 or not one.M[left.r, one.c].is_zero:
        return []
    for number, place in enumerate((graph.zero, graph.pi)):
        here = {left.q: place}
        if not substitute([one.around], here)[0].is_zero:
            continue
        V = one.potential(substitute([one.carried], here)[0] - one.carried)
        (slope,) = gradient(V, [left.q])
        m, curvature, level = substitute([one.M[left.r, left.r], *gradient(slope, [left.q]), slope], here)
        square = lowest(curvature / m)
        if not level.is_zero or (not one.spins and left.chosen.of(square)[0] <= 0):
            continue
        where = Words((named(left.q), " = ", Pi() if number else Number.ZERO))
        names = together([named(lesson.state.q[k]) for k in left.cyclic])
        steps.append(_stands(one, square, where, names, f"upright:{number}"))
    return steps


def _stands(one: Precession, square: Expr, where: Words, names: Words, key: str) -> Step:
    """Return when one upright place is stable, ω² there being given."""
    lesson, left = one.left.lesson, one.left
    omega = lesson.name("nutation:omega", "omega", "n", node=None).power(2)
    if not one.spins:
        c = named(lesson.state.q[one.c])
        told = lesson.say("upright.plain", square=omega, value=shortened(lesson, square))
        claim, reason = lesson.say("upright.singular", where=where, c=c), lesson.say("upright.singular.reason", c=c)
        return Step(key, claim, (told,), reason)
    (spin,) = one.spins.values()
    (rest,) = substitute([square], {spin: square.graph.zero})
    gain = lowest((square - rest) / spin**2)
    value = Form.sum((shortened(lesson, gain * spin**2), *shortened(lesson, rest).terms))
    blocks: list[Block] = [lesson.say("upright.omega", square=omega, value=value)]
    claim = lesson.say("upright", where=where, names=names, spin=named(spin))
    if left.chosen.of(rest)[0] < 0 < left.chosen.of(gain)[0]:
        least = lowest(-rest / gain)
        number = f"{lesson.about(left.chosen.of(least)[0] ** 0.5)} rad/s"
        shown = shortened(lesson, least)
        blocks.append(lesson.say("upright.from", square=named(spin).power(2), least=shown, value=number))
    else:
        blocks.append(lesson.say("upright.always" if left.chosen.of(rest)[0] >= 0 else "upright.never"))
    reason = lesson.say("upright.reason", names=names) if key.endswith("0") else Words(())
    return Step(key, claim, tuple(blocks), reason)


def _nutation(one: Precession) -> list[Step]:
    """Return ω² of swings about a steady motion, the condition put in."""
    lesson, left, M, r = one.left.lesson, one.left, one.M, one.left.r
    if any(not M[r, s].is_zero for s in one.spins):
        return []
    p = lesson.graph.symbol("precession:p")
    (slope,) = gradient(one.potential(p - one.carried), [left.q])
    square = gradient(slope, [left.q])[0] / (M[r, r] - M[r, one.c] ** 2 / one.around)
    (held,) = substitute([square], {p: one.around * one.rate + one.carried})
    node = _with_condition(one, held)
    if one.a.is_zero:
        (node,) = substitute([node], {one.rate: -one.d / one.b})
    node = lowest(node)
    q, omega = named(left.q), lesson.name("nutation:omega", "omega", "n", node=None)
    key = "nutation" if one.spins else "nutation.plain"
    form = shortened(lesson, node)
    if len(text_of(form)) > WIDEST:
        return []
    blocks: list[Block] = [Formula("", omega.power(2), right=form)]
    if one.still:
        (still,) = substitute([held], {one.rate: lesson.graph.zero})
        blocks += [
            lesson.say("nutation.still", rate=named(one.rate)),
            Formula("", omega.power(2), right=shortened(lesson, still)),
        ]
    if len(one.spins) == 1 and not one.a.is_zero:
        (spin,) = one.spins.values()
        (second,) = gradient(gradient(node, [spin])[0], [spin])
        fast = shortened(lesson, lowest(second / 2) * spin**2)
        if fast != Number.ZERO:
            blocks.append(lesson.say("nutation.fast", square=omega.power(2), value=fast))
    return [Step("nutation", lesson.say(key, q=q), tuple(blocks), lesson.say("nutation.reason"), show=("phase",))]


def _with_condition(one: Precession, node: Expr) -> Expr:
    """Return a node with the letter of gravity, or of a spring, put in from the condition; as it is without such."""
    lesson = one.left.lesson
    condition = one.a * one.rate**2 + one.b * one.rate + one.d
    elastic = set(reachable([lesson.energy.E])) - set(reachable([lesson.energy.K]))
    pulls = ({*reachable(vector(lesson.scene.gravity, lesson.graph))}, elastic)
    for g in (x for some in pulls for x in sorted(some, key=str) if x.op is Op.SYMBOL):
        (slope,) = gradient(condition, [g])
        if slope.is_zero or g in reachable([slope]):
            continue
        (rest,) = substitute([condition], {g: node.graph.zero})
        return substitute([node], {g: -rest / slope})[0]
    return node
