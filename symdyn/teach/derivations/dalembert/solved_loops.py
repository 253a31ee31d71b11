"""Loops of a plane, solved one after the other: dependent coordinates, their rates and accelerations, as formulas.

A joint that keeps two points together gives two equations, g = 0. If two coordinates u, v in them are not known yet and
v is an angle, g is the sum of one vector that turns with v and one that does not:

    g = g0 + c cos v + s sin v,    |c| = |s|, c · s = 0
    |g0|² - |c|² = 0               without v
    v = atan2(-s · g0, -c · g0)

For an angle u, g0 = k + d cos u + e sin u, and what is left is A cos u + B sin u + C = 0; for a slide, g0 = k + e u, it
is quadratic. Of the two roots one belongs to the drawn position. Rates and accelerations solve two linear equations.

Quotients are written as by hand: terms that divide stand alone, and factors of both sides are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, remainder

from symdyn.algebra import Form, Function, Number, Power, Symbol
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Op, gradient, reachable, substitute, tangents
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.velocities import PAGE, length
from symdyn.teach.document import Block, Formula, Letter, Step, Words
from symdyn.teach.lesson import named, together
from symdyn.teach.shown_state import Chosen


def quotient(above: Form, below: Form) -> Form:
    """Return above / below: terms that divide stand alone, and factors that both have are left out."""
    above, below = _laid_open(above), _factored(below)
    whole: list[tuple[Form, Form]] = []
    rest: list[tuple[Form, Form]] = []
    for term in above.terms:
        divided = _divided(term, below)
        (whole if divided[1] == Number.ONE else rest).append((term, divided[0]))
    if not whole:
        top, bottom = _divided(above, below)
        return top if bottom == Number.ONE else Form.product((top, Power(bottom, -1)))
    left = quotient(Form.sum(term for term, _ in rest), below) if rest else Number.ZERO
    return Form.sum([*(one for _, one in whole), left])


def _laid_open(form: Form) -> Form:
    """Return a product with one sum among its factors as a sum."""
    factors = form.factors
    sums = [k for k, one in enumerate(factors) if len(one.terms) > 1]
    if len(sums) != 1:
        return form
    others = [one for k, one in enumerate(factors) if k != sums[0]]
    return Form.sum(Form.product([*others, term]) for term in factors[sums[0]].terms)


def _factored(form: Form) -> Form:
    """Return a sum with the factors that all of its terms have in front."""
    terms = [list(term.factors) for term in form.terms]
    common: list[Form] = []
    for factor in terms[0] if len(terms) > 1 else []:
        base = factor.base if isinstance(factor, Power) else factor
        if not isinstance(base, Number) and all(has(base, one) for one in terms):
            terms = [less(base, one) for one in terms]
            common.append(base)
    return Form.product([*common, Form.sum(map(Form.product, terms))])


def _divided(above: Form, below: Form) -> tuple[Form, Form]:
    """Return numerator and denominator without the factors that both have; for a sum, those of all its terms."""
    terms = [list(term.factors) for term in above.terms]
    bottom: list[Form] = []
    for factor in below.factors:
        base, times = (factor.base, factor.exponent) if isinstance(factor, Power) else (factor, 1)
        for _ in range(times):
            if isinstance(base, Number):
                terms = [[Number(1 / base.value), *factors] for factors in terms]
            elif all(has(base, factors) for factors in terms):
                terms = [less(base, factors) for factors in terms]
            else:
                bottom.append(base)
    return Form.sum(map(Form.product, terms)), Form.product(bottom)


def has(base: Form, factors: Sequence[Form]) -> bool:
    """Whether a base, or a power of it, is among factors."""
    return any(one == base or (isinstance(one, Power) and one.base == base and one.exponent > 0) for one in factors)


def less(base: Form, factors: Sequence[Form]) -> list[Form]:
    """Return factors with one `base` less."""
    left = list(factors)
    place = next(k for k, one in enumerate(left) if has(base, [one]))
    found = left[place]
    left[place] = base.power(found.exponent - 1) if isinstance(found, Power) and found != base else Number.ONE
    return left


Writer = Callable[[Balance, Sequence[Expr]], Callable[[Expr], Form]]

NEAR = 1e-7
"""How far a formula's value may be from the drawn position, rad or m."""


@dataclass
class Solving:
    """The loops of one lesson while they are solved: what is known by now."""

    lesson: Balance
    chosen: Chosen
    writer: Writer
    left: list[int]
    several: bool
    count: int = 0

    def symbol(self, k: int) -> Symbol:
        """Return coordinate k as a form."""
        return Symbol(str(self.lesson.state.q[k].value))

    def write(self, *nodes: Expr) -> list[Form]:
        """Return nodes as forms, written together."""
        write = self.writer(self.lesson, nodes)
        return [write(node) for node in nodes]


def solved_loops(lesson: Balance, chosen: Chosen, gaps: Sequence[Sequence[Expr]], writer: Writer) -> list[Step]:
    """Return the steps that solve the loops, in formulas where that can be, else as it is done in numbers."""
    try:
        partition = lesson.workspace.loops.decisions.partition
    except DerivationError:
        return []
    solving = Solving(lesson, chosen, writer, list(partition.dependent), len(gaps) > 1)
    independent = [Symbol(lesson.scene.velocities[k]) for k in partition.independent]
    steps: list[Step] = []
    waiting = [tuple(gap) for gap in gaps]
    while True:
        found = next(((gap, one) for gap in waiting if (one := _tried(solving, gap)) is not None), None)
        if found is None:
            break
        waiting.remove(found[0])
        steps += found[1]
    if solving.left:
        linear = _left_over(solving) if not steps else ()
        if linear:
            names = [Symbol(lesson.scene.velocities[k]) for k in solving.left]
            said = lesson.say("solved.linear", rates=together(names))
            why = lesson.say("solved.rates.reason") if len(names) > 1 else Words(())
            steps.append(Step("solved:linear", said, linear, why))
        if not linear or lesson.scene.loops:
            steps.append(_in_numbers(solving, independent, bool(linear)))
    return steps


def _left_over(solving: Solving) -> tuple[Formula, ...]:
    """Return rates and accelerations from rows that are no plane loops, if these are few and short; else ()."""
    lesson, left = solving.lesson, solving.left
    loops, state = lesson.workspace.loops, lesson.state
    kept = loops.decisions.independent_rows
    if len(kept) != len(left) or len(left) > 2 or state.rates != state.qd:
        return ()
    rows = loops.recursive
    G, bias = loops.G(rows), loops.bias(rows)
    rates = [lesson.graph.dot(G[k], state.qd) for k in kept]
    pushes = [lesson.graph.total([bias[k], *(g * a for g, a in zip(G[k], state.qdd, strict=True))]) for k in kept]
    levels = ((rates, state.qd), (pushes, state.qdd))
    try:
        found = [one for rows, names in levels for one in _linear(solving, rows, [names[k] for k in left])]
    except DerivationError:  # no polynomials
        return ()
    return tuple(found) if max(length(one.right or Number.ZERO) for one in found) <= PAGE else ()


def _tried(solving: Solving, gap: Sequence[Expr]) -> list[Step] | None:
    """Return the steps that solve one loop; None where there are none, or no polynomials to write them with."""
    try:
        return _loop(solving, gap)
    except DerivationError:
        return None


def _loop(solving: Solving, gap: Sequence[Expr]) -> list[Step] | None:
    """Return the steps that solve one loop; None if it has not two equations for two unknowns that formulas give."""
    lesson, state = solving.lesson, solving.lesson.state
    if len(gap) != 2:
        return None
    used = {x for x in reachable(list(gap)) if x.op is Op.SYMBOL}
    pair = [k for k in solving.left if state.q[k] in used]
    if len(pair) != 2 or state.rates != state.qd:
        return None
    placed = next((one for v in pair for u in pair if u != v and (one := _placed(solving, gap, u, v))), None)
    if placed is None:
        return None
    rates = tangents(list(gap), state.velocity)
    pushes = tangents(rates, state.acceleration)
    names = [lesson.scene.velocities[k] for k in pair]
    moved = _linear(solving, rates, [state.qd[k] for k in pair])
    pushed = _linear(solving, pushes, [state.qdd[k] for k in pair])
    if max(length(x.form) + length(x.right or Number.ZERO) for x in (*moved, *pushed)) > 2 * PAGE:
        return None
    solving.left = [k for k in solving.left if k not in pair]
    solving.count += 1
    number = str(solving.count)
    q = [solving.symbol(k) for k in pair]
    places = {"first": q[0], "second": q[1]}
    rest = {"first": Symbol(names[0]), "second": Symbol(names[1])}
    return [
        Step(f"solved:positions:{number}", lesson.say("solved.positions", **places), *placed),
        Step(
            f"solved:rates:{number}",
            lesson.say("solved.rates", **rest),
            tuple(moved),
            lesson.say("solved.rates.reason"),
            show=("velocities",),
        ),
        Step(
            f"solved:accelerations:{number}",
            lesson.say("solved.accelerations"),
            tuple(pushed),
            lesson.say("solved.accelerations.reason"),
            show=("accelerations",),
        ),
    ]


def _linear(solving: Solving, equations: Sequence[Expr], unknowns: Sequence[Expr]) -> list[Formula]:
    """Return the unknowns of one or two linear equations, by Cramer's rule, what is common cancelled."""
    graph = solving.lesson.graph
    if len(unknowns) == 1:
        one, rest = solving.write(
            gradient(equations[0], unknowns)[0], -substitute(list(equations), {unknowns[0]: graph.zero})[0]
        )
        return [Formula("", Symbol(str(unknowns[0].value)), right=solving.lesson.order(quotient(rest, one)))]
    (a, b), (c, d) = (gradient(one, unknowns) for one in equations)
    still = dict.fromkeys(unknowns, graph.zero)
    e, f = (-x for x in substitute(list(equations), still))
    below, *above = solving.write(a * d - b * c, e * d - b * f, a * f - e * c)
    found = [solving.lesson.order(quotient(one, below)) for one in above]
    return [Formula("", Symbol(str(x.value)), right=one) for x, one in zip(unknowns, found, strict=True)]


# Positions


@dataclass(frozen=True)
class Root:
    """How one coordinate is found: x = middle ± way."""

    values: tuple[Expr, Expr]  # middle and way on the graph
    forms: tuple[Form, Form]  # the same as they are printed
    blocks: tuple[Block, ...]  # what is said and written before


def _placed(solving: Solving, gap: Sequence[Expr], u: int, v: int) -> tuple[tuple[Block, ...], Words] | None:
    """Return the formulas of u and v and how they come about; None if the gap is no such sum of vectors."""
    lesson, graph, units = solving.lesson, solving.lesson.graph, SceneUnits(solving.lesson.scene).velocities
    x, y = lesson.state.q[u], lesson.state.q[v]
    if units[v] != "rad" or (turning := _turned(gap, y)) is None:
        return None
    g0, c, s = turning
    turns = units[u] == "rad"
    root = _angle(solving, g0, x, _dot(c, c)) if turns else _slide(solving, g0, x, _dot(c, c))
    sign = None if root is None else _sign(solving, root, u, turns)
    if root is None or sign is None:
        return None
    down = (-_dot(s, g0), -_dot(c, g0))
    (turn,) = solving.chosen.of(graph.function(Op.ATAN2, *down))
    if abs(remainder(turn - solving.chosen.q[v], 2 * pi)) > NEAR:
        return None
    first, gone = named(x), named(y)
    middle, way = root.forms
    solution = lesson.order(Form.sum((middle, way if sign > 0 else Form.product((Number.MINUS_ONE, way)))))
    above, beside = solving.write(*down)
    blocks = (
        lesson.say("solved.without", gone=gone),
        *root.blocks,
        Formula("", first, right=solution),
        lesson.say("solved.back", gone=gone),
        Formula("", gone, right=Function(Op.ATAN2, _without_lengths(lesson, above, beside))),
    )
    return blocks, lesson.say("solved.angle.reason" if turns else "solved.slide.reason", first=first)


def _angle(solving: Solving, g0: Sequence[Expr], x: Expr, radius: Expr) -> Root | None:
    """Return the roots of A cos x + B sin x + C = 0, which |g0|² = radius² is."""
    lesson, graph = solving.lesson, solving.lesson.graph
    if (turning := _turned(g0, x)) is None:
        return None
    k, d, e = turning
    nodes = (2 * _dot(k, d), 2 * _dot(k, e), _dot(k, k) + _dot(d, d) - radius)
    index = (str(solving.count + 1),) if solving.several else ()
    A, B, C = (
        lesson.called(f"loop:{letter}:{solving.count + 1}", Letter(letter, index), node)
        for letter, node in zip("ABC", nodes, strict=True)
    )
    a, b, c = nodes
    way = graph.function(Op.ATAN2, graph.function(Op.SQRT, a * a + b * b - c * c), -c)
    opposite = Form.product((Number.MINUS_ONE, C))
    under = Form.sum((Power(A, 2), Power(B, 2), Form.product((Number.MINUS_ONE, Power(C, 2)))))
    shown = Function(Op.ATAN2, (B, A)), Function(Op.ATAN2, (Function(Op.SQRT, (under,)), opposite))
    terms = (Form.product((A, Function(Op.COS, (named(x),)))), Form.product((B, Function(Op.SIN, (named(x),)))), C)
    written = (Formula(one.name, form) for one, form in zip((A, B, C), solving.write(*nodes), strict=True))
    blocks = (Formula("", Form.sum(terms), right=Number.ZERO), *written)
    return Root((graph.function(Op.ATAN2, b, a), way), shown, blocks)


def _slide(solving: Solving, g0: Sequence[Expr], x: Expr, radius: Expr) -> Root | None:
    """Return the roots of |k + e x|² = radius²."""
    graph = solving.lesson.graph
    e = [gradient(one, (x,))[0] for one in g0]
    k = substitute(list(g0), {x: graph.zero})
    if x in reachable(e):
        return None
    along, size, across = _dot(k, e), _dot(e, e), k[0] * e[1] - k[1] * e[0]
    under = size * radius - across * across
    middle, below, inside = solving.write(-along, size, under)
    shown = quotient(middle, below), quotient(Function(Op.SQRT, (inside,)), below)
    return Root((-along / size, graph.function(Op.SQRT, under) / size), shown, ())


def _turned(vector: Sequence[Expr], angle: Expr) -> tuple[list[Expr], list[Expr], list[Expr]] | None:
    """Return g0, c, s with vector = g0 + c cos angle + s sin angle; None if it is no such sum."""
    graph = angle.graph
    cosine, sine = graph.function(Op.COS, angle), graph.function(Op.SIN, angle)

    def at(c: Expr, s: Expr) -> list[Expr]:
        return substitute(list(vector), {cosine: c, sine: s})

    g0 = at(graph.zero, graph.zero)
    c = [x - y for x, y in zip(at(graph.one, graph.zero), g0, strict=True)]
    s = [x - y for x, y in zip(at(graph.zero, graph.one), g0, strict=True)]
    return None if angle in reachable([*g0, *c, *s]) else (g0, c, s)


def _sign(solving: Solving, root: Root, u: int, turns: bool) -> int | None:
    """Return 1 or -1: which of the two roots the drawn position is; None for neither."""
    middle, way = solving.chosen.of(*root.values)
    for sign in (1, -1):
        off = middle + sign * way - solving.chosen.q[u]
        if abs(remainder(off, 2 * pi) if turns else off) < NEAR:
            return sign
    return None


def _dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    return a[0] * b[0] + a[1] * b[1]


def _without_lengths(lesson: Balance, above: Form, beside: Form) -> tuple[Form, Form]:
    """Return both arguments of an atan2 without the positive parameters that all of their terms are multiplied by."""
    positive = {Symbol(one.name) for one in lesson.scene.parameters if one.positive}
    terms = [*above.terms, *beside.terms]
    for factor in [one for one in terms[0].factors if one in positive]:
        if all(has(factor, term.factors) for term in terms):
            terms = [Form.product(less(factor, term.factors)) for term in terms]
    count = len(above.terms)
    return Form.sum(terms[:count]), Form.sum(terms[count:])


# Where there are no formulas


def _in_numbers(solving: Solving, independent: Sequence[Symbol], solved: bool) -> Step:
    """Return how the loops are solved in numbers: Newton's steps for places, linear equations for rates."""
    lesson = solving.lesson
    look = {
        "r": Letter("r", (), accent="bar"),
        "u": Letter("q", ("d",), dots=1),
        "ui": Letter("q", ("i",), dots=1),
        "a": Letter("q", ("d",), dots=2),
        "ai": Letter("q", ("i",), dots=2),
        "G": Letter("G", ("d",), above="-1"),
        "Gi": Letter("G", ("i",)),
        "dG": Letter("G", (), dots=1),
        "J": Letter("G"),
        "Gd": Letter("G", ("d",)),
        "all": Letter("q", (), dots=1),
        "step": Letter(r"\Delta q", ("d",)),
    }
    s = {key: lesson.called(f"law:loop:{key}", one) for key, one in look.items()}
    minus = (Number.MINUS_ONE, s["G"])
    blocks: list[Block] = []
    if lesson.scene.loops:
        blocks.append(Formula("law:loop:step", Form.product((*minus, s["r"]))))
    if not solved:
        blocks.append(Formula("law:loop:u", Form.product((*minus, s["Gi"], s["ui"]))))
        pushed = Form.sum((Form.product((s["Gi"], s["ai"])), Form.product((s["dG"], s["all"]))))
        blocks.append(Formula("law:loop:a", Form.product((*minus, pushed))))
    names = [Symbol(lesson.scene.velocities[k]) for k in solving.left]
    said = lesson.say("solved.numbers.reason", **s, dependent=together(names), independent=together(independent))
    if lesson.scene.loops:
        said = Words((*said.parts, " ", *lesson.say("solved.numbers.newton", **s).parts))
    return Step("law:loops", lesson.say("solved.numbers"), tuple(blocks), said)
