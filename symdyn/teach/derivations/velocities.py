"""Steps: places and velocities of all masses, differentiated term by term; energies and the Lagrangian.

Kinetic and potential energy go body by body, with squares multiplied out and simplified.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction

from symdyn.algebra import Form, Function, Number, Power, Product, Sum, Symbol
from symdyn.dynamics import rotor_energy
from symdyn.dynamics.mechanism import vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import elastic
from symdyn.scene.values import Joint
from symdyn.spatial import Vec, cross, dot
from symdyn.teach.derivations.rotations import angular_velocity, expanded_squares, is_rate, rate_of, read_from
from symdyn.teach.document import Block, Fold, Formula, Letter, Matrix, Step, Words
from symdyn.teach.lesson import AXES, SMALL_SCENE, Lesson, Mass, Prose, named, together

MOST_TERMS = 20
"""Terms of one formula from which it is shown folded."""

PAGE = 90
"""The same for scenes that are shown in full: about a page."""

MOST = 2_000
"""Terms of the longest formula that is written at all: 600 in the examples."""


def position_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return one step a mass: x, y, z of its place in the ground frame."""
    steps = []
    for mass in result:
        names = [lesson.name(f"{axis}:{mass.tag}", axis, mass.tag, node=node) for axis, node in _along(mass.place)]
        blocks = _components(lesson, names, mass.place)
        claim = lesson.say("position", mass=lesson.of(mass))
        steps.append(Step(f"position:{mass.tag}", claim, tuple(blocks), reference=_range(blocks)))
    return steps


def velocity_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return one step a mass: each component differentiated, the angular velocity of a body that has inertia."""
    state = lesson.state
    rates: dict[str, Form] = {str(q.value): named(u) for q, u in zip(state.q, state.rates, strict=True)}
    steps = []
    for mass in result:
        blocks: list[Block] = []
        details: list[Block] = []
        for axis, node in _along(mass.place):
            key, velocity = f"d{axis}:{mass.tag}", tangents([node], state.velocity)[0]
            lesson.name(key, axis, mass.tag, node=velocity, dots=1)
            form = lesson.short(node)
            rate = rate_of(form, rates)
            if not rate.terms:
                continue
            rows = [(term, rate_of(term, rates)) for term in form.terms]
            details.append(lesson.table(("velocity.term", "velocity.rate"), rows))
            blocks.append(folded(lesson, Formula(key, rate, lesson.number(key))))
        if not blocks:
            steps.append(Step(f"velocity:{mass.tag}", lesson.say("velocity.rests", mass=lesson.of(mass)), ()))
        if details:
            shown = len(lesson.scene.velocities) <= SMALL_SCENE
            table = tuple(details)
            blocks = [*(table if shown and len(table) < 3 else (Fold(lesson.say("velocity.terms"), table),)), *blocks]
        if blocks:
            claim, reason = lesson.say("velocity", mass=lesson.of(mass)), lesson.once("velocity.reason")
            reference = _range([block for block in blocks if isinstance(block, Formula)])
            steps.append(Step(f"velocity:{mass.tag}", claim, tuple(blocks), reason, reference))
        if mass.spins:
            steps.append(_turning(lesson, mass, result))
    return steps


def _turning(lesson: Lesson, mass: Mass, result: list[Mass]) -> Step:
    """Return ω in body axes, as it is read from the matrices of direction cosines where they are shown."""
    w, tag = angular_velocity(lesson, mass.body), mass.tag
    names = [lesson.name(f"omega:{tag}{axis}", "omega", tag, axis, node=node) for axis, node in _along(w)]
    claim, read = lesson.say("turning", body=mass.body.name), read_from(lesson, mass.body, result)
    key = "turning.plane" if read is None else "turning.sum" if mass.body.name in _carried(lesson) else "turning.reason"
    key = "turning.still" if all(map(lesson.vanishes, w)) else key
    blocks = _components(lesson, names, w, read or [Number.ZERO] * 3)
    return Step(f"turning:{tag}", claim, tuple(blocks), lesson.once(key))


def _carried(lesson: Lesson) -> set[str]:
    """Return the bodies whose neighbour towards the ground moves."""
    return {joint.child for joint in lesson.scene.joints if joint.parent != Scene.GROUND}


def _along(v: Vec) -> Iterator[tuple[str, Expr]]:
    return zip(AXES, v, strict=True)


def _components(lesson: Lesson, names: list[Symbol], v: Vec, forms: Sequence[Form] = (Number.ZERO,) * 3) -> list[Block]:
    """Return the components of a vector, each as it was found where that is not its short form; zeros last."""
    blocks: list[Block] = []
    absent = []
    for name, node, read in zip(names, v, forms, strict=True):
        form = lesson.short(node)
        if form.terms and read.terms and set(read.terms) != set(form.terms):
            blocks.append(folded(lesson, Formula(name.name, read, lesson.number(name.name), form)))
        elif form.terms:
            blocks.append(folded(lesson, Formula(name.name, form, lesson.number(name.name))))
        else:
            absent.append(name)
    if len(absent) == len(AXES):
        return [Words((*(part for one in absent for part in (one, " = ")), "0"))]
    if len(absent) > 1:
        first, second, *absent = absent
        blocks.append(Formula(first.name, second, right=Number.ZERO))
    return [*blocks, *(Formula(one.name, Number.ZERO) for one in absent)]


def folded(lesson: Prose, formula: Formula) -> Block:
    """Return a formula, folded under its name where it is long, and told of where nobody could read it."""
    terms = length(formula.form)
    left = Symbol(formula.left) if formula.left else formula.right or Number.ZERO
    if terms > MOST:
        return lesson.say("longer", name=left, terms=str(terms))
    if terms <= (PAGE if len(lesson.scene.velocities) <= SMALL_SCENE else MOST_TERMS):
        return formula
    if left == Number.ZERO:
        return Fold(lesson.say("long.short", terms=str(terms)), (formula,))
    return Fold(lesson.say("long", name=left, terms=str(terms)), (formula,))


def length(form: Form) -> int:
    """Return how many terms a reader sees, those in brackets included."""
    return _length(form, {})


def _length(form: Form, known: dict[int, int]) -> int:
    """Return the same; `known` holds it by identity, since long forms have most of their parts in common."""
    if id(form) not in known:
        parts = () if isinstance(form, Function) else form.parts
        if isinstance(form, Product):
            parts = tuple(part for part in parts if isinstance(part, (Sum, Power)))
        least = 0 if isinstance(form, Sum) else 1
        known[id(form)] = max(least, sum(_length(part, known) for part in parts))
    return known[id(form)]


def _range(blocks: list[Block]) -> str:
    """Return the equation numbers of some formulas: "5.28, 5.29"."""
    return ", ".join(f"({b.number})" for b in blocks if isinstance(b, Formula) and b.number)


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
    claim = lesson.say("kinetic", mass=lesson.of(mass, whole=True))
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
        return Step(
            f"square:{tag}",
            lesson.say("square", mass=lesson.of(mass)),
            tuple(blocks),
            reference=_reference(lesson, key),
        )
    simple, used = [], False
    identities: list[Block] = []
    for group in groups:
        sines = Form.sum(group.sines)
        short = lesson.short(sines.express(lesson.graph))
        if short == Number.ONE and len(sines.terms) == 2:
            used = True  # the identity itself
        elif set(short.terms) != set(sines.terms):
            said = _identity(lesson, sines, short)
            identities += [*([] if said in identities else [said]), Formula("", sines, right=short)]
        if short.terms:
            simple.append(Form.product((group.outer, short)))
    if identities or used:
        expanded = Formula(key, Form.sum(group.form for group in groups))
        multiplied: list[Block] = [lesson.say("square.out"), expanded, *identities]
        if length(expanded.form) > 3 * MOST_TERMS:
            multiplied = [Fold(lesson.say("square.fold", terms=str(length(expanded.form))), tuple(multiplied))]
        blocks += [*multiplied, lesson.say("square.result" if identities else "identity.pythagoras")]
    ordered = Form.sum(_rates_last(term) for term in simple)
    blocks.append(folded(lesson, Formula(key, ordered, lesson.number(key))))
    return Step(
        f"square:{tag}", lesson.say("square", mass=lesson.of(mass)), tuple(blocks), reference=_reference(lesson, key)
    )


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
    return Step(f"spin:{tag}", claim, tuple(blocks), lesson.once("spin.reason"))


def _offset(lesson: Lesson, mass: Mass, term: Expr) -> Step:
    claim = lesson.say("offset", body=mass.body.name)
    block = folded(lesson, Formula(f"Kh:{mass.tag}", kinetic_form(lesson, term)))
    return Step(f"offset:{mass.tag}", claim, (block,), lesson.once("offset.reason"))


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
    claim = lesson.say("potential", mass=lesson.of(mass, whole=True))
    reason = lesson.once("potential.reason")
    return [Step(f"potential:{tag}", claim, tuple(blocks), reason, _reference(lesson, key))]


def _springs(lesson: Lesson, potential: list[str]) -> Step:
    lesson.name("P:E", "P", "E", node=lesson.energy.E)
    potential.append("P:E")
    blocks = [folded(lesson, Formula("P:E", lesson.page.E))]
    if set(lesson.page.E.symbols) & {one.name for one in lesson.page.lengths.named}:
        with suppress(DerivationError, KeyError):  # a free length leaves the root
            blocks.append(folded(lesson, Formula("P:E", lesson.short(lesson.energy.E))))
    return Step("springs", lesson.say("springs"), tuple(blocks), lesson.say("springs.reason"))


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
    block = folded(lesson, Formula("L:", Form.sum((page.K, page.P.negative)), lesson.number("L")))
    claim = lesson.say("lagrangian", difference=Form.sum((Symbol("K:"), Symbol("P:").negative)))
    steps.append(Step("lagrangian", claim, (block,), reference="(5.23)"))
    return steps


def _reference(lesson: Lesson, key: str) -> str:
    return lesson.reference(key.replace(":", ".definition:", 1), key)


def force_row(lesson: Lesson, i: int) -> Form:
    """Return a row of h: the right-hand side less the terms without accelerations, coefficients by name."""
    terms = [*lesson.page.right[i].terms]
    for c in lesson.page.rows[i]:
        if c.of != "qdd" and not c.vanishes:
            key = f"{c.kind}:{','.join(map(str, c.indices))}"
            terms.append(Form.product((Number.MINUS_ONE, Symbol(key), c.rate)))
    return Form.sum(terms)


def accelerations_system(lesson: Lesson, free: Sequence[int], h: Sequence[Expr]) -> list[Block]:
    """Return M q̈ = h, M by the names of its entries."""
    if not all(f"k_z:{i + 1},{j + 1}" in lesson.names for i in free for j in free):
        return []
    M, right = lesson.name("M:", lesson.letters.mass_matrix, node=None), lesson.name("h:", "h", node=None)
    faster = lesson.called("accelerations:", Letter("q", dots=2))
    cells = []
    for i in free:
        for j in free:
            key = f"k_z:{i + 1},{j + 1}"
            cells.append((Symbol(key) if lesson.forms.M[i][j] else Number.ZERO, key))
    forms, names = zip(*cells, strict=True)
    entries, keys = [], []
    for k, i in enumerate(free):
        keys.append(lesson.name(f"h:{i + 1}", "h", str(i + 1), node=h[k]).name)
        entries.append(lesson.page.right[i] if h[k].is_zero else force_row(lesson, i))
    order = together([named(lesson.state.qdd[k]) for k in free])
    said = lesson.say("explicit.matrix", left=Form.product((M, faster)), right=right, columns=order)
    return [said, Matrix(M.name, forms, names, width=len(free)), Matrix(right.name, tuple(entries), tuple(keys))]


def waves_cancelled(above: Sequence[Form], under: Sequence[Form]) -> tuple[list[Form], list[Form]]:
    """Return factors above and below a line without sines and cosines below it that all terms of a sum above have.

    A field of sines in which sin² is 1 - cos² does not see them.
    """
    over, below = list(above), list(under)
    for wave in [x for x in under if isinstance(x, Function)]:
        for k, x in enumerate(over):
            rest = [_less(term, wave) for term in x.terms] if isinstance(x, Sum) else [None]
            left = [one for one in rest if one is not None]
            if len(left) == len(rest):
                over[k] = Form.sum(left)
                below.remove(wave)
                break
    return over, below


def _less(term: Form, wave: Form) -> Form | None:
    """Return a term divided by a wave that is one of its factors, squared or not; None of another."""
    factors = list(term.factors)
    for k, x in enumerate(factors):
        if wave in (x, x.base if isinstance(x, Power) and x.exponent > 1 else None):
            left = x.base.power(x.exponent - 1) if isinstance(x, Power) and x != wave else Number.ONE
            return Form.product((*factors[:k], left, *factors[k + 1 :]))
    return None
