"""Steps: Lagrange's equations solved for the accelerations, with prescribed motions put in.

The equations M q̈ = h are solved in quotients of polynomials in sines (`symdyn.algebra.Ratios`), so that factors which
numerator and denominator share are gone. A denominator that several accelerations share has the letter Δ. What would
be too long to read is left as a linear system.

Each solution is compared in numbers with the one that the equations have at the state of the lesson.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction

import numpy as np

from symdyn.algebra import Form, Function, Number, Power, Ratio, Ratios, Sum, Symbol
from symdyn.dynamics.mechanism import TIME, prescribed
from symdyn.errors import DerivationError, NoValueError
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.short_sines import in_sines
from symdyn.teach.derivations.velocities import accelerations_system, folded, force_row, length, waves_cancelled
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.lesson import SMALL_SCENE, Lesson, named, together
from symdyn.teach.shown_state import Chosen

LONGEST = 40  # terms and factors of a formula that is written out
MOST = 8  # accelerations up to which the system is shown as a matrix
LARGE = 20  # a number below the line that is no fraction of a textbook
SMALL = 1e-9  # of a comparison in numbers, relative

NO_SHORT_FORM = (DerivationError, KeyError, OverflowError, ZeroDivisionError)
"""What says that no quotient of polynomials in sines is found, or none that is short."""


class Quotients:
    """Writes quotients of some nodes: letters that stay in front, then what moves; denominators in factors."""

    def __init__(self, lesson: Lesson, nodes: Sequence[Expr]) -> None:
        """Take the field that the nodes need."""
        self.lesson, self.field = lesson, Ratios(nodes)
        self.known = dict(zip(nodes, evaluate(nodes, self.field, self.field.values()), strict=True))
        state = lesson.state
        self._moving = {str(x.value) for x in (*state.q, *state.qd, *state.qdd)}
        self._fixed = {one.name: k for k, one in enumerate(lesson.scene.parameters)}

    def parts(self, ratio: Ratio) -> tuple[list[Form], list[Form]]:
        """Return the factors above and below the line, the number first; of two terms over letters both are divided."""
        form = self.field.form(ratio)
        above = self._joined([y for x in form.factors if not _below(x) for y in self.short(x).factors])
        below = (y for x in form.factors if _below(x) for y in _base(x).factors)
        under = self._joined([z for y in below for z in self.short(y).factors])
        above, under = _decimal(*_powers_cancelled(above, under))
        above, sums = _sign_inside(above), [k for k, x in enumerate(above) if isinstance(x, Sum)]
        letters = not any(isinstance(y, (Number, Sum)) for y in under) and not self._moves(Form.product(under))
        if under and letters and len(sums) == 1 and len(above[sums[0]].terms) == 2:
            spread = _divided(above[sums[0]], under)
            above, under = ([*above[: sums[0]], spread, *above[sums[0] + 1 :]], []) if spread else (above, under)
        above, under = (
            [self.short(x) if any(_scale(y) != 1 for y in x.walk()) else x for x in some] for some in (above, under)
        )
        above, under = waves_cancelled(above, under)
        return _in_decimals(self.lesson, sorted(above, key=self._place), sorted(under, key=self._place))

    def _place(self, form: Form) -> tuple[int, int]:
        """Return where a factor stands: numbers, parameters, other letters, functions of letters, sums, what moves.

        Parameters stand in the order of the scene, sums of them behind.
        """
        letters = list(form.symbols)
        if self._moves(form):
            return 4 if isinstance(form, Sum) else 5, 0
        if any(isinstance(x, Function) for x in form.walk()):
            return 3, 0
        if not self._fixed.keys() >= set(letters):
            return 2, 0
        return int(bool(letters)), self._fixed[letters[0]] if len(letters) == 1 else len(self._fixed)

    def short(self, form: Form) -> Form:
        """Return a sum, or a power of one, as short as a ring of sines can write it."""
        if isinstance(form, Power) and isinstance(form.base, Sum):
            return self.short(form.base).power(form.exponent)
        return self._in_sines(form).plus_first if isinstance(form, Sum) else form

    def _joined(self, factors: list[Form]) -> list[Form]:
        """Return factors, two sums whose product is one term as that: (1 + cos q) (1 - cos q) = sin² q."""
        for k, a in enumerate(factors):
            for b in factors[k + 1 :]:
                if isinstance(a, Sum) and isinstance(b, Sum):
                    one = self._in_sines(Form.product((a, b)))
                    if not isinstance(one, Sum):
                        return [*one.factors, *(x for x in factors if x not in (a, b))]
        return factors

    def _in_sines(self, form: Form) -> Form:
        return in_sines(self.lesson, form.express(self.lesson.graph)) or form

    def _moves(self, form: Form) -> bool:
        return bool(self._moving.intersection(form.symbols))


def _in_decimals(lesson: Lesson, above: list[Form], under: list[Form]) -> tuple[list[Form], list[Form]]:
    """Return a quotient without a number below the line that decimals of the scene have made: 981/100 is 9.81."""
    number = under[0].value if under and isinstance(under[0], Number) else Fraction(1)
    if number < LARGE or 10**9 % number:
        return above, under
    sums = [k for k, x in enumerate(above) if isinstance(x, Sum)]
    if len(sums) == 1 and (not isinstance(above[0], Number) or abs(above[0].value) < LARGE):
        divided = in_sines(lesson, above[sums[0]].express(lesson.graph) / number)
        if divided is not None:
            return [*above[: sums[0]], divided.plus_first, *above[sums[0] + 1 :]], under[1:]
    return [Form.product((Number(1 / number), *above))], under[1:]


def quotient(above: Sequence[Form], under: Sequence[Form]) -> Form:
    """Return a quotient in print."""
    return Form.product((*above, *([Form.product(under).power(-1)] if under else [])))


def in_decimals(form: Form) -> Form:
    """Return a quotient in factors with decimals where they have made a number below the line: 9.81 for 981/100."""
    under = [y for x in form.factors if _below(x) for y in _base(x).factors]
    return quotient(*_decimal([x for x in form.factors if not _below(x)], under))


def short_form(lesson: Lesson, node: Expr) -> Form:
    """Return a node in the ring of the lesson, or as a quotient where a spring is none of the ring's."""
    try:
        return lesson.short(node)
    except (DerivationError, KeyError):
        return in_decimals(Ratios.form_of(node))


def _decimal(above: Sequence[Form], under: Sequence[Form]) -> tuple[list[Form], list[Form]]:
    """Return factors above and below a line with decimals in place of large integers that decimals have made.

    A sum is divided by a large coefficient of its own, and what is left of a large number below the line divides the
    one sum above, or the number there.
    """
    head, over, below = Fraction(1), list[Form](), list[Form]()
    for sign, factors, side in ((1, above, over), (-1, under, below)):
        for x in factors:
            scale = x.value if isinstance(x, Number) else max(map(_scale, x.terms)) if isinstance(x, Sum) else 1
            head *= Fraction(scale) ** sign
            side.extend([] if isinstance(x, Number) else [_scaled(x, 1 / Fraction(scale))])
    if head.denominator < LARGE or 10**9 % head.denominator:
        return [Number(Fraction(head.numerator)), *over], _below_with(head.denominator, below)
    sums = [k for k, x in enumerate(over) if isinstance(x, Sum)]
    if len(sums) != 1 or abs(head.numerator) >= LARGE:
        return [Number(head), *over], below
    over[sums[0]] = _scaled(over[sums[0]], Fraction(1, head.denominator))
    return [Number(Fraction(head.numerator)), *over], below


def _scale(term: Form) -> Fraction:
    """Return the coefficient of a term if it is a large one of decimals, else 1."""
    number = next((abs(x.value) for x in term.factors if isinstance(x, Number)), Fraction(1))
    return number if number >= LARGE and number.denominator == 1 and number % 5 == 0 == 10**9 % number else Fraction(1)


def _scaled(form: Form, by: Fraction) -> Form:
    return form if by == 1 else Form.sum(Form.product((Number(by), *x.factors)) for x in form.terms)


def _below_with(number: int, below: list[Form]) -> list[Form]:
    return below if number == 1 else [Number(Fraction(number)), *below]


def _below(form: Form) -> bool:
    return isinstance(form, Power) and form.exponent < 0


def _base(form: Form) -> Form:
    assert isinstance(form, Power), "what stands below the line is a power"
    return form.base.power(-form.exponent)


def _sign_inside(factors: Sequence[Form]) -> list[Form]:
    """Return factors with a minus put into the first sum that holds one; sums begin without."""
    found, k = list(factors), next((k for k, x in enumerate(factors) if isinstance(x, Sum)), 0)
    if k and found[0].split_sign()[0] < 0:
        plain = [x.negative for x in found[k].terms]
        for turned in (plain, [_turned(x) for x in found[k].terms]):
            if any(x.split_sign()[0] > 0 for x in turned):
                found[0], found[k] = found[0].negative, Form.sum(turned)
                break
    return [x.plus_first for x in found]


def _turned(term: Form) -> Form:
    """Return minus a term, by a sum among its factors that holds a minus: minus (a - b) c is (b - a) c."""
    for k, x in enumerate(term.factors):
        if isinstance(x, Sum) and any(y.split_sign()[0] < 0 for y in x.terms):
            return Form.product((*term.factors[:k], x.negative.plus_first, *term.factors[k + 1 :]))
    return term.negative


def _powers_cancelled(above: Sequence[Form], under: Sequence[Form]) -> tuple[list[Form], list[Form]]:
    """Return factors above and below a line without powers of the same there; numbers in one, the first."""
    number, powers = Fraction(1), dict[Form, int]()
    for sign, factors in ((1, above), (-1, under)):
        for x in factors:
            if isinstance(x, Number):
                number *= x.value**sign
                continue
            base, exponent = (x.base, x.exponent) if isinstance(x, Power) else (x, 1)
            powers[base] = powers.get(base, 0) + sign * exponent
    over = [Number(Fraction(number.numerator)), *(x.power(k) for x, k in powers.items() if k > 0)]
    below: list[Form] = [x.power(-k) for x, k in powers.items() if k < 0]
    return over, _below_with(number.denominator, below)


def _divided(whole: Form, under: Sequence[Form]) -> Form | None:
    """Return a sum, each term divided by a product of letters; None where no term loses a letter."""
    pairs = [_decimal(*_powers_cancelled(term.factors, under)) for term in whole.terms]
    return Form.sum(quotient(*pair) for pair in pairs) if any(len(x) < len(under) for _, x in pairs) else None


def solved_steps(lesson: Lesson, chosen: Chosen) -> list[Step]:
    """Return the equations solved for the accelerations, and the drives of prescribed motions."""
    state, led = lesson.state, prescribed(lesson.scene, lesson.graph)
    put = motions_put_in(lesson)
    free = led.free
    told = vanishing(lesson, free, put)
    steps: list[Step] = []
    if free:
        small = len(free) <= SMALL_SCENE and not led.place
        found = accelerations(lesson, told, free, chosen, _entries(lesson, free) if small else None)
        key = "explicit.led" if led.place else "explicit" if len(free) > 1 else "explicit.one"
        claim = lesson.say(key, q=named(state.q[free[0]]), led=together([named(state.q[k]) for k in led.place]))
        if found is not None:
            blocks, forms = found
            apart = all(lesson.forms.form("k_z", i, j) == Number.ZERO for i in free for j in free if i != j)
            reason = lesson.say(f"explicit.{'diagonal' if apart else 'cramer'}")
            if len(free) == 1:
                lost = {str(x.value) for x in reachable(told)} - {*forms[0].symbols}
                gone: list[Form] = [Symbol(one.name) for one in lesson.scene.parameters if one.name in lost]
                reason = lesson.say("explicit.gone", names=together(gone)) if gone else Words(())
            if any(name.startswith("k_z:") for form in forms for name in form.symbols):
                blocks = [lesson.say("explicit.entries"), *blocks]
            said = Words((*reason.parts, " " * bool(reason.parts), *signs_told(lesson, free, forms, chosen)))
            steps.append(Step("explicit", claim, tuple(blocks), said))
        elif len(free) <= MOST and not led.place:
            system = tuple(accelerations_system(lesson, free, _linear(lesson, told, free)[1]))
            steps.append(Step("explicit", lesson.say("explicit.linear"), system, lesson.say("explicit.system")))
    if led.place and (step := _drives(lesson, led.place, put)):
        steps.append(step)
    return steps


Linear = tuple[list[list[Expr]], list[Expr]]
"""M and h of M q̈ = h."""


def accelerations(
    lesson: Lesson, told: Sequence[Expr], free: Sequence[int], chosen: Chosen, named_as: Linear | None = None
) -> tuple[list[Block], list[Form]] | None:
    """Return accelerations of `free` for which nodes vanish, with Δ in print; None where they have no short form.

    Where they have none, `named_as` stands for M and h.
    """
    if len(free) > SMALL_SCENE:
        return None
    M, h = _linear(lesson, told, free)
    found = _solved(lesson, M, h, free, chosen) or (_solved(lesson, *named_as, free, chosen) if named_as else None)
    if found is None:
        return None
    delta, forms = found
    _compare(lesson, M, h, forms, chosen)
    qdd = [lesson.state.qdd[k] for k in free]
    blocks: list[Block] = [Formula(symbol.name, form) for symbol, form in delta.items()]
    blocks += [folded(lesson, Formula("", named(x), right=form)) for x, form in zip(qdd, forms, strict=True)]
    divided: dict[Form, list[Symbol]] = {}
    for x, form in zip(qdd, forms, strict=True):
        if zeros := _zeros(lesson, form, chosen):
            divided.setdefault(Form.product(zeros), []).append(named(x))
    blocks += [lesson.say("explicit.unless", of=together(x), zeros=zeros) for zeros, x in divided.items()]
    return blocks, forms


def _zeros(lesson: Lesson, form: Form, chosen: Chosen) -> list[Form]:
    """Return the factors of denominators that vanish somewhere, each once and without its power."""
    factors = (y for x in form.walk() if _below(x) for y in _base(x).factors)
    below = list(dict.fromkeys(x.base if isinstance(x, Power) else x for x in factors))
    nodes = with_entries(lesson, [x.express(lesson.graph) for x in below])
    return [x for x, node in zip(below, nodes, strict=True) if chosen.meets_zero(node, lesson.scene, lesson.state.q)]


def _linear(lesson: Lesson, told: Sequence[Expr], free: Sequence[int]) -> Linear:
    """Return M and h for which nodes vanish."""
    qdd = [lesson.state.qdd[k] for k in free]
    h = [-x for x in substitute(told, dict.fromkeys(qdd, lesson.graph.zero))]
    return [gradient(node, qdd) for node in told], h


def _entries(lesson: Lesson, free: Sequence[int]) -> Linear | None:
    """Return M and h by the names of coefficients, where the mass matrix is constant; None elsewhere."""
    entries = {(i, j): lesson.forms.form("k_z", i, j) for i in free for j in free}
    if any({str(q.value) for q in lesson.state.q}.intersection(form.symbols) for form in entries.values()):
        return None
    zero, symbol = lesson.graph.zero, lesson.graph.symbol
    M = [[symbol(f"k_z:{min(i, j) + 1},{max(i, j) + 1}") if entries[i, j].terms else zero for j in free] for i in free]
    return M, [force_row(lesson, i).express(lesson.graph) for i in free]


def motions_put_in(lesson: Lesson) -> Mapping[Expr, Expr]:
    """Return what coordinates, rates and accelerations with a prescribed motion are, in time."""
    state, led = lesson.state, prescribed(lesson.scene, lesson.graph)
    pairs = ((state.q, led.position), (state.qd, led.velocity), (state.qdd, led.acceleration))
    return {x[k]: value for x, values in pairs for k, value in zip(led.place, values, strict=True)}


def vanishing(lesson: Lesson, of: Sequence[int], put: Mapping[Expr, Expr]) -> list[Expr]:
    """Return what vanishes in a motion: inertia and other forces less the drive, with prescribed motions put in."""
    graph, drives = lesson.graph, lesson.scene.drives
    nodes = [lesson.drives[i] - (graph.symbol(str(drives[i])) if drives[i] else graph.zero) for i in of]
    return substitute(nodes, put)


def _solved(
    lesson: Lesson, M: Sequence[Sequence[Expr]], h: Sequence[Expr], free: Sequence[int], chosen: Chosen
) -> tuple[dict[Symbol, Form], list[Form]] | None:
    """Return Δ > 0, if several denominators share a sum, and the accelerations; None where they have no short form."""
    try:
        write = Quotients(lesson, [*(x for row in M for x in row), *h])
        left = [[write.known[x] for x in row] for row in M]
        found = write.field.solved(left, [[write.known[x]] for x in h])
        parts = [write.parts(x) for (x,) in found]
    except NO_SHORT_FORM:
        return None
    sums = [{x for x in under if isinstance(x, Sum)} for _, under in parts]
    shared = set.intersection(*sums) if len(free) > 1 else set()
    delta: dict[Symbol, Form] = {}
    if shared:
        form = max(shared, key=length)
        turned = _is_negative(lesson, form, chosen)  # Δ is positive, as the determinant is
        delta_form = form.negative.plus_first if turned else form
        symbol = lesson.name("Delta:", r"\Delta", node=delta_form.express(lesson.graph))
        delta[symbol] = delta_form
        sign = Number.MINUS_ONE if turned else Number.ONE
        parts = [(_sign_inside([sign, *x]), [*(z for z in y if z != form), symbol]) for x, y in parts]
    forms = [quotient(*pair) for pair in parts]
    return (delta, forms) if max(map(length, (*forms, *delta.values()))) <= LONGEST else None


def _is_negative(lesson: Lesson, form: Form, chosen: Chosen) -> bool:
    """Tell whether a form is negative at the lesson's state; False where it has no value there."""
    try:
        return chosen.of(*with_entries(lesson, [form.express(lesson.graph)]))[0] < 0
    except NoValueError:
        return False


def with_entries(lesson: Lesson, nodes: Sequence[Expr]) -> list[Expr]:
    """Return nodes with Δ put in, and the entries of the mass matrix and lengths that stand in Δ, too."""
    known = {lesson.graph.symbol(key): name.node for key, name in lesson.names.items() if name.node is not None}
    for key in ("Delta:", "k_", "length:"):
        nodes = substitute(nodes, {x: node for x, node in known.items() if str(x.value).startswith(key)})
    return list(nodes)


def _compare(
    lesson: Lesson, M: Sequence[Sequence[Expr]], h: Sequence[Expr], forms: Sequence[Form], chosen: Chosen
) -> None:
    """Hold the forms against the solution in numbers."""
    nodes = with_entries(lesson, [form.express(lesson.graph) for form in forms])
    drives = {lesson.graph.symbol(name): 1.0 for name in lesson.scene.drives if name}
    at = chosen.with_values(drives)
    n = len(h)
    try:
        values = np.array(at.of(*(x for row in M for x in row), *h, *nodes))
    except NoValueError:  # at the lesson's state a solution divides by zero: it is compared nowhere else
        return
    matrix, right, ours = values[: n * n].reshape(n, n), values[n * n : n * n + n], values[n * n + n :]
    with np.errstate(over="ignore"):  # what is beyond doubles is no smaller than what it is held against
        size = 1 + np.abs(matrix) @ np.abs(ours) + np.abs(right)
        left = np.abs(matrix @ ours - right)
    assert not np.any(left > SMALL * size), "accelerations that are no solution"


def signs_told(lesson: Lesson, free: Sequence[int], forms: Sequence[Form], chosen: Chosen) -> tuple[str | Form, ...]:
    """Return what the sign says: of one coordinate whose acceleration vanishes at zero, of rest next to there."""
    state, graph, plain = lesson.state, lesson.graph, lesson.say("explicit.signs").parts
    if len(free) != 1 or lesson.scene.drives[free[0]] or TIME in forms[0].symbols:
        return plain
    q, node = state.q[free[0]], forms[0].express(graph)
    zero = {**dict.fromkeys(state.qd, graph.zero), q: graph.zero}
    try:
        there, slope = substitute([node, gradient(node, [q])[0]], zero)
        if not there.is_zero or slope.is_zero:
            return plain
        write = Quotients(lesson, [slope])
        shown = quotient(*write.parts(write.known[slope]))
    except NO_SHORT_FORM:  # the ends of a spring meet there as well
        return plain
    linear = shown.signed_product(named(q)) if len(shown.terms) == 1 else Form.product((shown, named(q)))
    (value,) = chosen.of(slope)
    if not value:
        return plain
    key = "explicit.back" if value < 0 else "explicit.away"
    told = lesson.say(key, q=named(q), acceleration=named(state.qdd[free[0]]), linear=linear).parts
    return (*told, *_threshold(lesson, slope, chosen))


def _threshold(lesson: Lesson, slope: Expr, chosen: Chosen) -> tuple[str | Form, ...]:
    """Return the rate among the parameters at whose square a slope is zero; nothing where there is none."""
    for p in lesson.scene.parameters:
        letter = lesson.graph.symbol(p.name)
        (gain,) = gradient(slope, [letter])
        rest = slope - gain * letter / 2  # of a p² + b, which is what has a threshold
        if p.unit != "rad/s" or gain.is_zero or Ratios.form_of(gradient(rest, [letter])[0]) != Number.ZERO:
            continue
        write = Quotients(lesson, [least := Ratios.form_of(-2 * letter * rest / gain).express(lesson.graph)])
        if (square := chosen.of(least)[0]) > 0:
            value = f"{lesson.written(math.sqrt(square))} rad/s"
            form, letters = quotient(*write.parts(write.known[least])), named(letter)
            said = lesson.say("explicit.threshold", square=letters.power(2), least=form, p=letters, value=value)
            return (" ", *said.parts)
    return ()


def _drives(lesson: Lesson, led: Collection[int], put: Mapping[Expr, Expr]) -> Step | None:
    """Return the drives that prescribed motions take."""
    blocks, names = list[Block](), list[Symbol]()
    for k in led:
        if (own := lesson.scene.drives[k]) is None:
            continue
        (node,) = substitute([lesson.drives[k]], put)
        form = in_sines(lesson, node)
        if form is not None and length(form) <= LONGEST:
            names.append(Symbol(own))
            blocks.append(Formula("", Symbol(own), right=form))
    if not blocks:
        return None
    units = {lesson.scene.drives[k]: unit for k, unit in enumerate(SceneUnits(lesson.scene).velocities)}
    way = ".several" if len(names) > 1 else ".slide" if units[names[0].name] == "m" else ""
    return Step(
        "explicit.drives",
        lesson.say(f"explicit.drives{way}", drives=together(names)),
        tuple(blocks),
        lesson.say("explicit.power"),
    )
