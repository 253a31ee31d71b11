"""Steps: for each coordinate ∂L/∂q̇_i, its time derivative, ∂L/∂q_i, the equation; then the coefficients, read off.

Kane's form of an equation is one line of comparison:

    F_i = Σ m a · ∂v/∂q̇_i + Σ (I ω̇ + ω × I ω) · ∂ω/∂q̇_i + ∂P/∂q_i        sums over masses, ω and I in body axes

Reference: Kane and Levinson, Dynamics: Theory and Applications (1985), chapter 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, groupby

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import generalized_forces, vector
from symdyn.emit.print import Coefficient, Printable, text_of
from symdyn.graph import Expr, gradient, tangents
from symdyn.scene.values import force_unit
from symdyn.spatial import add, cross
from symdyn.table import Table
from symdyn.teach.derivations.rotations import angular_velocity, is_rate, rate_of
from symdyn.teach.derivations.velocities import MOST_TERMS, folded, length
from symdyn.teach.document import Block, Brace, Braced, Fold, Formula, Name, Step, Words
from symdyn.teach.lesson import AXES, SMALL_SCENE, Lesson, Mass, Prose, named, together
from symdyn.teach.shown_state import Chosen

WIDEST = 110
"""Characters of a coefficient that stands over a brace."""


def coefficient_key(c: Coefficient) -> str:
    """Return "k_z:1,2", the key of a coefficient's name."""
    return f"{c.kind}:{','.join(map(str, c.indices))}"


def coefficient_unit(of: str, indices: Sequence[int], slides: Sequence[bool]) -> str:
    """Return the unit of a coefficient: of a force, or kg m² with a metre less for each slide that it belongs to.

    What it multiplies is as of `Coefficient`, indices are from 1, slides tell for each velocity whether it is in m/s.
    """
    if not of:
        return force_unit("m" if slides[indices[0] - 1] else "rad")
    factors = indices if of == "qdd" else (*indices, indices[-1])[:3]  # two velocities, or one squared
    return ("kg m²", "kg m", "kg", "kg/m")[sum(slides[i - 1] for i in factors)]


def name_coefficients(lesson: Lesson) -> Printable:
    """Name every coefficient, drive and generalized force, each with its value by Lagrange's equations on the graph."""
    page = lesson.page
    M = lesson.energy.mass_matrix()
    found = lesson.energy.directions.christoffel(M)
    rows = {"k_z": M, "k_C": found.coriolis(), "k_D": found.centrifugal()}
    rows |= {"k_G": [[x] for x in lesson.energy.gravity_forces()], "k_E": [[x] for x in lesson.energy.elastic_forces()]}
    pairs = {pair: k for k, pair in enumerate(combinations(range(1, len(M) + 1), 2))}
    for c in page.coefficients:
        i, *rest = c.indices
        column = pairs[rest[0], rest[1]] if len(rest) > 1 else sum(rest, -1) if rest else 0
        between = " " if any(x > 9 for x in c.indices) else ""
        index = (str(i), between.join(map(str, rest))) if len(rest) > 1 else (between.join(map(str, c.indices)),)
        lesson.name(coefficient_key(c), "k", c.kind.removeprefix("k_"), *index, node=rows[c.kind][i - 1][column])
    acting = generalized_forces(lesson.scene, lesson.graph)
    for i, (drive, force) in enumerate(zip(lesson.drives, acting, strict=True)):
        lesson.name(f"tau:{i + 1}", "tau" if force.is_zero else "S", str(i + 1), node=drive + force)  # a sum
        own = lesson.scene.drives[i]
        if own:
            lesson.names[own] = Name(None, drive)
    return page


def equation_steps(lesson: Lesson, page: Printable) -> list[Step]:
    """Return four steps a coordinate."""
    steps: list[Step] = []
    for i in range(len(page.rows)):
        steps += [_momentum(lesson, i), _rate(lesson, i), _slope(lesson, page, i), _equation(lesson, page, i)]
    return steps


def _momentum(lesson: Lesson, i: int) -> Step:
    """Return ∂L/∂q̇_i = Σ k_z,ij q̇_j."""
    qd = str(lesson.state.qd[i].value)
    symbol = lesson.slope("L:", qd, lesson.momenta[i])
    block = folded(lesson, Formula(symbol.name, momentum_form(lesson, i), lesson.number(f"momentum:{i + 1}")))
    claim, key = lesson.say("momentum", slope=symbol), f"momentum:{i + 1}"
    return Step(key, claim, (block,), lesson.once("momentum.reason", rate=_qd(lesson, i)), lesson.reference(key))


def momentum_form(lesson: Lesson, i: int) -> Form:
    """Return Σ k_z,ij q̇_j, which costs nothing, where the derivative of K multiplied out may be too long."""
    terms = [Form.product((_M(lesson, i, j), _qd(lesson, j))) for j in range(lesson.state.n)]
    return Form.sum(term for term in terms if term != Number.ZERO)


def _rate(lesson: Lesson, i: int) -> Step:
    """Return d/dt ∂L/∂q̇_i: the product rule, term by term, then the sum by accelerations and rates."""
    forms, n = lesson.forms, lesson.state.n
    symbol = lesson.rate(f"dL:/d{lesson.state.qd[i].value}", lesson.momentum_rates[i])
    slopes = {
        (j, k): forms.ring.derivative(forms.M[i][j], forms.state.q[k])
        for j in range(n)
        for k in range(n)
        if forms.M[i][j]
    }
    terms = [Form.product((_M(lesson, i, j), _qdd(lesson, j))) for j in range(n) if forms.M[i][j]]
    for j, k in [*combinations(range(n), 2), *((j, j) for j in range(n))]:
        zero = forms.ring.zero
        total = slopes.get((j, k), zero) + (slopes.get((k, j), zero) if j != k else zero)
        if total:
            terms.append(_signed(forms.compactor(total), *_rates(lesson, j, k)))
    key = f"rate:{i + 1}"
    formula = folded(lesson, Formula(symbol.name, Form.sum(terms), lesson.number(key)))
    written = sum(length(_M(lesson, i, j)) for j in range(n)) <= MOST_TERMS
    table = _products(lesson, i) if written else _products_by_name(lesson, i)
    shown: Block = table if n <= SMALL_SCENE else Fold(lesson.say("rate.fold"), (table,))
    claim, reason = lesson.say("rate", rate=symbol), lesson.once("rate.reason")
    return Step(key, claim, (shown, lesson.say("rate.sum"), formula), reason, lesson.reference(key))


def _products(lesson: Lesson, i: int) -> Table[Words]:
    """Return a table: each term of ∂L/∂q̇_i, a coefficient times a rate, and both parts of its derivative."""
    rates: dict[str, Form] = {str(q.value): named(u) for q, u in zip(lesson.state.q, lesson.state.rates, strict=True)}
    rows: list[tuple[Form, Form, Form]] = []
    for j in range(lesson.state.n):
        for term in _M(lesson, i, j).terms:
            changing = Form.sum(_with_rate(part, _qd(lesson, j)) for part in rate_of(term, rates).terms)
            rows.append((Form.product((term, _qd(lesson, j))), changing, Form.product((term, _qdd(lesson, j)))))
    return lesson.table(("velocity.term", "rate.coefficient", "rate.acceleration"), rows)


def _products_by_name(lesson: Lesson, i: int) -> Table[Words]:
    """Return the same with coefficients that are long by their names."""
    rows: list[tuple[Form, Form, Form]] = []
    for j in range(lesson.state.n):
        if lesson.forms.M[i][j]:
            key = f"k_z:{i + 1},{j + 1}"
            (node,) = tangents([node_of(lesson, key)], lesson.state.velocity)
            rates = _qd(lesson, j), _qdd(lesson, j)
            still = not any(lesson.forms.ring.derivative(lesson.forms.M[i][j], q) for q in lesson.forms.state.q)
            change = Number.ZERO if still else Form.product((lesson.rate(key, node), rates[0]))
            rows.append((Form.product((Symbol(key), rates[0])), change,
                         Form.product((Symbol(key), rates[1]))))  # fmt: skip
    return lesson.table(("velocity.term", "rate.coefficient", "rate.acceleration"), rows)


def _with_rate(term: Form, rate: Symbol) -> Form:
    """Return a term with one rate more, squares as squares and the rates in order."""
    factors = [*term.factors, rate]
    rates = sorted((x for x in factors if isinstance(x, Symbol) and is_rate(x)), key=lambda x: x.name)
    others = [x for x in factors if x not in rates]
    return Form.product((*others, *(x.power(rates.count(x)) for x in dict.fromkeys(rates))))


def _rates(lesson: Lesson, j: int, k: int) -> list[Form]:
    """Return the factors of q̇_j q̇_k."""
    return [_qd(lesson, j).power(2)] if j == k else [_qd(lesson, x) for x in sorted((j, k))]


def _slope(lesson: Lesson, page: Printable, i: int) -> Step:
    """Return ∂L/∂q_i = ½ Σ ∂k_z,jk/∂q_i q̇_j q̇_k - k_G,i - k_E,i."""
    forms, n, q = lesson.forms, lesson.state.n, lesson.forms.state.q[i]
    symbol = lesson.slope("L:", str(q.value), lesson.slopes[i])
    terms: list[Form] = []
    for j in range(n):
        for k in range(j, n):
            slope = forms.ring.derivative(forms.M[j][k], q)
            if slope:
                shown = forms.compactor(slope / 2 if j == k else slope)
                terms.append(_signed(shown, *_rates(lesson, j, k)))
    terms += [_signed(Number.MINUS_ONE, term) for c in page.rows[i] if not c.of for term in c.form.terms]
    key = f"slope:{i + 1}"
    block = folded(lesson, Formula(symbol.name, Form.sum(terms), lesson.number(key)))
    absent = not any(forms.ring.derivative(forms.M[j][k], q) for j in range(n) for k in range(n))
    said = "slope.reason" if not absent else "slope.absent" if terms else "slope.cyclic"
    reason = lesson.once(said, q=named(q))
    return Step(key, lesson.say("slope", slope=symbol), (block,), reason, lesson.reference(key))


def _equation(lesson: Lesson, page: Printable, i: int) -> Step:
    """Return the equation, under-braced as (5.40)."""
    terms = []
    for c in page.rows[i]:
        if c.vanishes:
            continue
        short = length(c.form) <= MOST_TERMS // 3 and len(text_of(c.form)) <= WIDEST
        form = c.form if short else Symbol(coefficient_key(c))
        terms.append(Brace(form, coefficient_key(c) if short else "", c.rate))
    q, qd = lesson.state.q[i].value, lesson.state.qd[i].value
    left = Form.sum((Symbol(f"d/dt dL:/d{qd}"), _signed(Number.MINUS_ONE, Symbol(f"dL:/d{q}"))))
    claim = lesson.say("equation", left=left, right=page.right[i])
    key, motion = f"equation:{i + 1}", f"motion:{i + 1}"
    blocks: list[Block] = [Braced(page.right[i], tuple(terms), f"tau:{i + 1}", lesson.number(key))]
    if lesson.number(motion):
        blocks.insert(0, Formula("", left, lesson.number(motion), page.right[i]))
    if any(not brace.under for brace in terms):
        blocks.append(lesson.say("equation.named"))
    reason = supplied(lesson, lesson.scene.drives[i], page.right[i], Symbol(str(q)))
    return Step(key, claim, tuple(blocks), reason, lesson.reference(motion, key))


def supplied(lesson: Prose, drive: str | None, right: Form, q: Form) -> Words:
    """Return who has to supply the terms of an equation: its drive, what else stands on the right, or nobody."""
    if drive is None:
        key = "equation.free" if right == Number.ZERO else "equation.passive"
    else:
        key = "equation.reason" if right == Symbol(drive) else "equation.shared"
    return lesson.say(key, q=q)


def _M(lesson: Lesson, i: int, j: int) -> Form:
    return lesson.forms.form("k_z", i, j)


def _qd(lesson: Lesson, j: int) -> Symbol:
    return named(lesson.state.qd[j])


def _qdd(lesson: Lesson, j: int) -> Symbol:
    return named(lesson.state.qdd[j])


def _signed(form: Form, *rate: Form) -> Form:
    """Return form · rate; a sum of negative terms takes its sign in front."""
    return form.signed_product(Form.product(rate))


# Coefficients


def coefficient_steps(lesson: Lesson, page: Printable) -> list[Step]:
    """Return one step a kind: every coefficient that does not vanish, then those that do."""
    steps = []
    for kind, found in groupby(page.coefficients, lambda c: c.kind):
        blocks: list[Block] = []
        zero: list[Form] = []
        for c in (c for c in found if c.indices == min(c.places)):
            key = coefficient_key(c)
            if c.vanishes:
                zero.append(Symbol(key))
            elif len(c.places) > 1 and length(c.form) <= MOST_TERMS:
                twin = Symbol(coefficient_key(replace(c, indices=c.places[1])))
                blocks.append(Formula(key, twin, lesson.number(key), c.form))
            else:
                blocks.append(folded(lesson, Formula(key, c.form, lesson.number(key))))
        if zero:
            blocks.append(lesson.say("coefficients.zero", names=together(zero)))
        if len(blocks) == 1 and zero:
            steps.append(Step(f"coefficients:{kind}", lesson.say("coefficients.zero", names=together(zero)), ()))
        else:
            steps.append(Step(f"coefficients:{kind}", lesson.say(f"coefficients.{kind}"), tuple(blocks)))
    return steps


def node_of(lesson: Lesson, key: str) -> Expr:
    """Return the value of a name."""
    node = lesson.names[key].node
    assert node is not None, f"{key} has no value"
    return node


SMALL = 1e-9

TURNED = "dH:"
"""What keys of components of Ḣ begin with."""


def kane_steps(lesson: Lesson, page: Printable, chosen: Chosen) -> list[Step]:
    """Return Kane's form of the first equation that a mass has a share in; none where a body has a first moment.

    On the left stands what the page has there: the drive and what else acts.
    """
    if any(mass.h is not None for mass in lesson.masses):
        return []  # its origin is no centre of mass, so that the line would be another one
    i = next(
        (k for k in range(lesson.state.n) if not lesson.vanishes(gradient(lesson.energy.K, lesson.state.qd)[k])), 0
    )
    u, q = lesson.state.qd[i], lesson.state.q[i]
    forms: list[Form] = []
    nodes: list[Expr] = []
    for mass in lesson.masses:
        shares = _moved(lesson, mass, u) + _turned(lesson, mass, u)
        forms += [form for form, _ in shares]
        nodes += [node for _, node in shares]
    for joint in lesson.scene.joints:
        if joint.moves and not joint.armature.express(lesson.graph).is_zero:
            momentum = gradient(rotor_energy(joint, lesson.state.velocity, lesson.graph), [u])
            (node,) = tangents(momentum, lesson.state.acceleration)
            if (form := lesson.short(node)).terms:
                forms.append(form)
                nodes.append(node)
    slope = gradient(lesson.energy.P, [q])[0]
    if any(not x.is_zero for x in vector(lesson.scene.gravity, lesson.graph)) or not slope.is_zero:
        forms.append(lesson.slope("P:", str(q.value), slope))
        nodes.append(slope)
    whole = lesson.names[f"tau:{i + 1}"].node
    assert whole is not None, "an equation has a value"
    ours, truth = chosen.of(lesson.graph.total(nodes), whole)
    assert abs(ours - truth) <= SMALL * (1 + sum(map(abs, chosen.of(*nodes)))), "Kane's form is another equation"
    claim = lesson.say("kane", rate=named(u), left=page.right[i])
    blocks: list[Block] = [folded(lesson, Formula("", page.right[i], right=Form.sum(forms)))]
    reason = lesson.say("kane.reason") if lesson.state.n > 1 else Words(())
    if turned := list(dict.fromkeys(symbol for form in forms for symbol in form.factors if is_turned(symbol))):
        said = "kane.turned" if len(turned) > 1 else "kane.turned.one"
        blocks.append(lesson.say(said, rates=together(turned)))
        reason = lesson.say("kane.reason.turned", reason=lesson.say("kane.reason"))
    return [Step("kane", claim, tuple(blocks), reason, show=("accelerations", "velocities"))]


def is_turned(form: Form) -> bool:
    """Tell whether a factor is the rate of an angular momentum."""
    return isinstance(form, Symbol) and form.name.startswith(TURNED)


def _moved(lesson: Lesson, mass: Mass, u: Expr) -> list[tuple[Form, Expr]]:
    """Return m ẍ ∂ẋ/∂u by axes, with its values; none that vanishes."""
    if mass.m.is_zero:
        return []
    found, state = [], lesson.state
    for axis, place in zip(AXES, mass.place, strict=True):
        (velocity,) = tangents([place], state.velocity)
        partial = gradient(velocity, [u])[0]
        if lesson.vanishes(partial):
            continue
        (pushed,) = tangents([velocity], state.acceleration)
        lesson.name(f"d{axis}:{mass.tag}", axis, mass.tag, node=velocity, dots=1)
        a = lesson.name(f"dd{axis}:{mass.tag}", axis, mass.tag, node=pushed, dots=2)
        slope = lesson.slope(f"d{axis}:{mass.tag}", str(u.value), partial)
        found.append((Form.product((lesson.short(mass.m), a, slope)), mass.m * pushed * partial))
    return found


def _turned(lesson: Lesson, mass: Mass, u: Expr) -> list[tuple[Form, Expr]]:
    """Return Ḣ ∂ω/∂u by axes of the body: Ḣ = I ω̇ + ω × I ω."""
    if not mass.spins:
        return []
    w, state = angular_velocity(lesson, mass.body), lesson.state
    x, y, z = tangents(w, state.acceleration)
    moments = add(mass.inertia @ (x, y, z), cross(w, mass.inertia @ w))
    found = []
    for axis, rate, moment in zip(AXES, w, moments, strict=True):
        partial = gradient(rate, [u])[0]
        if lesson.vanishes(partial) or lesson.vanishes(moment):
            continue
        lesson.name(f"omega:{mass.tag}{axis}", "omega", mass.tag, axis, node=rate)
        H = lesson.name(f"{TURNED}{mass.tag}{axis}", "H", mass.tag, axis, node=moment, dots=1)
        slope = lesson.slope(f"omega:{mass.tag}{axis}", str(u.value), partial)
        found.append((Form.product((H, slope)), moment * partial))
    return found
