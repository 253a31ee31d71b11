"""Steps: kinetic and potential energy, body by body; squares multiplied out and simplified; the Lagrangian."""

from __future__ import annotations

from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Symbol
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import vector
from symdyn.graph import Expr, tangents
from symdyn.scene.forces import elastic
from symdyn.scene.values import Joint
from symdyn.spatial import cross, dot
from symdyn.teach.derivations.lagrange.forms import expanded_squares, is_rate, rate_of
from symdyn.teach.derivations.lagrange.rotations import angular_velocity
from symdyn.teach.derivations.lagrange.velocities import MOST_TERMS, folded, length
from symdyn.teach.document import Block, Fold, Formula, Step, Words
from symdyn.teach.lesson import Lesson, named
from symdyn.teach.masses import AXES, Mass

HALF = Number(Fraction(1, 2))


def energy_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return the steps to K and P of every mass, rotor and spring."""
    kinetic: list[str] = []
    potential: list[str] = []
    steps: list[Step] = []
    for mass in result:
        steps += _kinetic(lesson, mass, kinetic)
        steps += _potential(lesson, mass, potential)
    for joint in lesson.scene.joints:
        if joint.moves and not joint.armature.express(lesson.graph).is_zero:
            steps.append(_rotor(lesson, joint, kinetic))
    if elastic(lesson.scene):
        steps.append(_springs(lesson, potential))
    return [*steps, *_totals(lesson, kinetic, potential)]


# Kinetic


def _kinetic(lesson: Lesson, mass: Mass, kinetic: list[str]) -> list[Step]:
    """Return v² and K of one mass; its key is added to `kinetic`."""
    state, tag = lesson.state, mass.tag
    velocity = tangents(mass.place, state.velocity)
    square = lesson.graph.total(v * v for v in velocity)
    moves = not lesson.vanishes(square)
    steps, parts, values = [], [], []
    if moves and not mass.m.is_zero:
        lesson.name(f"v2:{tag}", "v", tag, node=square, power=2)
        steps.append(_square(lesson, mass))
        parts.append(Form.product((HALF, lesson.short(mass.m), Symbol(f"v2:{tag}"))))
        values.append(mass.m * square / 2)
    if mass.h is not None:
        omega = lesson.placed[mass.body.name].R @ angular_velocity(lesson, mass.body)
        term = dot((velocity[0], velocity[1], velocity[2]), cross(omega, mass.h))
        if not lesson.vanishes(term):
            symbol = lesson.name(f"Kh:{tag}", "K", tag, "h", node=term)
            steps.append(_offset(lesson, mass, term))
            parts.append(symbol)
            values.append(term)
    w = angular_velocity(lesson, mass.body)
    if mass.spins and not lesson.vanishes(spin := dot(w, mass.inertia @ w) / 2):
        symbol = lesson.name(f"Kw:{tag}", "K", tag, "omega", node=spin)
        steps.append(_spinning(lesson, mass, spin))
        parts.append(symbol)
        values.append(spin)
    if not parts:
        return steps
    key, node = f"K:{tag}", lesson.graph.total(values)
    lesson.name(key, "K", tag, node=node)
    kinetic.append(key)
    definition = Form.sum(parts)
    blocks: list[Block] = [Formula(key, definition, lesson.number(f"K.definition:{tag}"))]
    blocks.append(folded(lesson, Formula(key, kinetic_form(lesson, node), lesson.number(key))))
    claim = lesson.say("kinetic", body=mass.body.name, tag=tag)
    steps.append(Step(f"kinetic:{tag}", claim, tuple(blocks), reference=_reference(lesson, key)))
    return steps


def _square(lesson: Lesson, mass: Mass) -> Step:
    """Return v² as a sum of squares, multiplied out, each identity named, simplified."""
    tag, key = mass.tag, f"v2:{mass.tag}"
    state = lesson.state
    rates: dict[str, Form] = {str(q.value): named(u) for q, u in zip(state.q, state.rates, strict=True)}
    components = {axis: rate_of(lesson.short(node), rates) for axis, node in zip(AXES, mass.place, strict=True)}
    components = {axis: form for axis, form in components.items() if form.terms}
    squares = Form.sum(Symbol(f"d{axis}:{tag}").power(2) for axis in components)
    blocks: list[Block] = [Formula(key, squares, lesson.number(f"v2.definition:{tag}"))]
    groups = expanded_squares(components.values())
    if groups is None:
        blocks.append(lesson.say("square.long"))
        return Step(f"square:{tag}", lesson.say("square", tag=tag), tuple(blocks), reference=_reference(lesson, key))
    simple = []
    identities: list[Block] = []
    for group in groups:
        sines = Form.sum(group.sines)
        short = lesson.short(sines.express(lesson.graph))
        if set(short.terms) != set(sines.terms):
            identities += [_identity(lesson, sines, short), Formula("", sines, right=short)]
        if short.terms:
            simple.append(Form.product((group.outer, short)))
    if identities:
        expanded = Formula(key, Form.sum(group.form for group in groups))
        multiplied: list[Block] = [lesson.say("square.out"), expanded, *identities]
        if length(expanded.form) > 3 * MOST_TERMS:
            multiplied = [Fold(lesson.say("square.fold", terms=str(length(expanded.form))), tuple(multiplied))]
        blocks += [*multiplied, lesson.say("square.result")]
    ordered = Form.sum(_rates_last(term) for term in simple)
    blocks.append(folded(lesson, Formula(key, ordered, lesson.number(key))))
    return Step(f"square:{tag}", lesson.say("square", tag=tag), tuple(blocks), reference=_reference(lesson, key))


def _rates_last(term: Form) -> Form:
    """Return a product with rates behind sines."""
    factors = term.factors
    moving = [f for f in factors if is_rate(f)]
    return Form.product([*(f for f in factors if not is_rate(f)), *moving])


def _identity(lesson: Lesson, sines: Form, short: Form) -> Words:
    """Return the words that name what is used: Pythagoras, the addition formulas, or both."""
    if isinstance(short, Number) or _angles(short) <= _angles(sines):
        return lesson.say("identity.pythagoras")
    return lesson.say("identity.addition")


def _angles(form: Form) -> set[Form]:
    return {one.args[0] for one in form.walk() if isinstance(one, Function)}


def _spinning(lesson: Lesson, mass: Mass, spin: Expr) -> Step:
    """Return K of the rotation: ½ ω·I ω in body axes."""
    tag, terms = mass.tag, []
    w = [Symbol(f"omega:{tag}{axis}") for axis in AXES]
    still = [lesson.vanishes(x) for x in angular_velocity(lesson, mass.body)]
    for a in range(3):
        for b in range(a, 3):
            if not mass.inertia[a][b].is_zero and not still[a] and not still[b]:
                rates: list[Form] = [w[a].power(2)] if a == b else [w[a], w[b]]
                terms.append(Form.product((HALF if a == b else Number.ONE, lesson.short(mass.inertia[a][b]), *rates)))
    key = f"Kw:{tag}"
    blocks: list[Block] = [Formula(key, Form.sum(terms)), folded(lesson, Formula(key, kinetic_form(lesson, spin)))]
    claim = lesson.say("spin", body=mass.body.name)
    return Step(f"spin:{tag}", claim, tuple(blocks), lesson.once("spin.reason", mass.body.name), level="full")


def _offset(lesson: Lesson, mass: Mass, term: Expr) -> Step:
    claim = lesson.say("offset", body=mass.body.name)
    block = folded(lesson, Formula(f"Kh:{mass.tag}", kinetic_form(lesson, term)))
    return Step(f"offset:{mass.tag}", claim, (block,), lesson.once("offset.reason", mass.body.name), level="full")


def _rotor(lesson: Lesson, joint: Joint, kinetic: list[str]) -> Step:
    key = f"K:rotor {joint.name}"
    node = rotor_energy(joint, lesson.state.velocity, lesson.graph)
    lesson.name(key, "K", joint.name, node=node)
    kinetic.append(key)
    return Step(f"rotor:{joint.name}", lesson.say("rotor", joint=joint.name), (Formula(key, lesson.short(node)),))


def kinetic_form(lesson: Lesson, node: Expr) -> Form:
    """Return a quadratic form of the rates as Σ coefficient · q̇_i q̇_j."""
    qd, terms = lesson.state.qd, []
    for i, u in enumerate(qd):
        slope = tangents([node], {u: lesson.graph.one})[0]
        for j in range(i, len(qd)):
            second = tangents([slope], {qd[j]: lesson.graph.one})[0]
            short = lesson.short(second / 2 if i == j else second)
            if short.terms:
                a, b = named(u), named(qd[j])
                terms.append(Form.product((short, a.power(2)) if i == j else (short, a, b)))
    return Form.sum(terms)


# Potential


def _potential(lesson: Lesson, mass: Mass, potential: list[str]) -> list[Step]:
    """Return P = -m g·r of one mass; its key is added to `potential`."""
    graph, tag = lesson.graph, mass.tag
    gravity = vector(lesson.scene.gravity, graph)
    node = -(mass.m * dot(gravity, mass.place))
    if mass.h is not None:
        node = node - dot(gravity, mass.h)
    if lesson.vanishes(node):
        return []
    key = f"P:{tag}"
    lesson.name(key, "P", tag, node=node)
    potential.append(key)
    blocks: list[Block] = []
    places = [
        Form.product((Number.MINUS_ONE, lesson.short(mass.m), lesson.short(one), Symbol(f"{axis}:{tag}")))
        for axis, one in zip(AXES, gravity, strict=True)
        if not lesson.vanishes(one)
    ]
    if mass.h is None:
        blocks.append(Formula(key, Form.sum(places), lesson.number(f"P.definition:{tag}")))
    blocks.append(folded(lesson, Formula(key, lesson.short(node), lesson.number(key))))
    claim = lesson.say("potential", body=mass.body.name, tag=tag)
    reason = lesson.once("potential.reason", Symbol(key))
    return [Step(f"potential:{tag}", claim, tuple(blocks), reason, _reference(lesson, key))]


def _springs(lesson: Lesson, potential: list[str]) -> Step:
    lesson.name("P:E", "P", "E", node=lesson.energy.E)
    potential.append("P:E")
    block = folded(lesson, Formula("P:E", lesson.page.E))
    return Step("springs", lesson.say("springs"), (block,), lesson.say("springs.reason"))


# Together


def _totals(lesson: Lesson, kinetic: list[str], potential: list[str]) -> list[Step]:
    page, energy = lesson.page, lesson.energy
    lesson.name("K:", "K", node=energy.K)
    lesson.name("P:", "P", node=energy.P)
    lesson.name("L:", "L", node=lesson.L)
    total: list[Block] = []
    for name, keys, form in (("K", kinetic, page.K), ("P", potential, page.P)):
        parts = Form.sum(Symbol(key) for key in keys)
        if parts != Number.ZERO:
            total.append(Formula(f"{name}:", parts))
        if len(keys) != 1 or name == "K":
            total.append(folded(lesson, Formula(f"{name}:", form, lesson.number(name))))
    steps = [Step("energies", lesson.say("energies"), tuple(total))]
    blocks: list[Block] = [
        folded(lesson, Formula("L:", Form.sum((page.K, page.P.negative)), lesson.number("L"))),
    ]
    steps.append(Step("lagrangian", lesson.say("lagrangian"), tuple(blocks), reference="(5.23)"))
    return steps


def _reference(lesson: Lesson, key: str) -> str:
    return lesson.reference(key.replace(":", ".definition:", 1), key)
