"""Steps: energies in turning axes, momenta, why their rates turn too, and the equations of motion."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations

from symdyn.algebra import Form, Number, Power, Symbol
from symdyn.emit.print import text_of
from symdyn.graph import Expr, gradient, substitute
from symdyn.scene.values import Joint
from symdyn.spatial import cross, dot
from symdyn.teach.derivations.lagrange.equation_steps import supplied
from symdyn.teach.derivations.lagrange.velocities import HALF, MOST_TERMS, folded, kinetic_form, length
from symdyn.teach.derivations.multipliers.balance import valued
from symdyn.teach.derivations.quaternions.turning import Turning
from symdyn.teach.document import Block, Brace, Braced, Formula, Letter, Name, Rate, Step, Words
from symdyn.teach.lesson import AXES, Mass, named, together

WIDEST = 110
"""Characters of a coefficient that stands over a brace."""


# Energies


def energy_steps(lesson: Turning) -> list[Step]:
    """Return K and P: of every mass, and of all."""
    for key, node in (("K:", lesson.energy.K), ("P:", lesson.energy.P)):
        lesson.name(key, key[0], node=node)
    steps, parts = list[Step](), list[Form]()
    for mass in lesson.masses:
        blocks = _kinetic(lesson, mass)
        if blocks:
            parts.append(Symbol(f"K:{mass.tag}"))
            claim = lesson.say("body.kinetic", body=mass.body.name, tag=mass.tag)
            reason = lesson.say("body.kinetic.reason") if len(parts) == 1 else Words(())
            steps.append(Step(f"kinetic:{mass.tag}", claim, blocks, reason))
    whole = valued(lesson, Form.sum(parts))
    blocks = (Formula("K:", Form.sum(parts)),) if lesson.vanishes(whole - lesson.energy.K) else ()  # rotors turn too
    blocks += (folded(lesson, Formula("K:", kinetic_form(lesson, lesson.energy.K))),)
    blocks += (folded(lesson, Formula("P:", lesson.shape(lesson.energy.P))),)
    reason = lesson.say("body.potential.reason")
    return [*steps, Step("energies", lesson.say("energies"), blocks, reason, show=("energies",))]


def _kinetic(lesson: Turning, mass: Mass) -> tuple[Block, ...]:
    """Return K of one mass: ½ m v², ½ ω·I ω, and the mixed term of a first moment."""
    tag, terms, blocks = mass.tag, list[Form](), list[Block]()
    v, w = ([Symbol(f"{letter}:{tag}{axis}") for axis in AXES] for letter in ("v", "omega"))
    squares = Form.sum(one.power(2) for one in v if lesson.shape(lesson.node(one.name)).terms)
    if not mass.m.is_zero and squares.terms:
        terms.append(Form.product((HALF, lesson.short(mass.m), squares)))
    for a in range(3):
        for b in range(a, 3):
            if not mass.inertia[a][b].is_zero:
                pair: list[Form] = [HALF, w[a].power(2)] if a == b else [w[a], w[b]]
                terms.append(Form.product((lesson.short(mass.inertia[a][b]), *pair)))
    if mass.h is not None:
        x, y, z = (lesson.node(one.name) for one in v)
        a1, a2, a3 = lesson.twist(mass.body.name)[1]
        mixed = dot((x, y, z), cross((a1, a2, a3), lesson.placed[mass.body.name].R.T @ mass.h))
        if not lesson.vanishes(mixed):
            terms.append(lesson.name(f"Kh:{tag}", "K", tag, "h", node=mixed))
            blocks.append(folded(lesson, Formula(f"Kh:{tag}", kinetic_form(lesson, mixed))))
    if not terms:
        return ()
    form = Form.sum(terms)
    lesson.name(f"K:{tag}", "K", tag, node=valued(lesson, form))
    return (*blocks, Formula(f"K:{tag}", form))


# Momenta


def momentum_steps(lesson: Turning) -> list[Step]:
    """Return the momenta, and why the rate of a vector in turning axes has a second part."""
    steps: list[Step] = []
    for joint in lesson.scene.moving:
        blocks: list[Block] = []
        for i in _velocities(lesson, joint):
            lesson.name(f"p:{i + 1}", "p", str(i + 1), node=lesson.p[i])
            blocks.append(folded(lesson, Formula(f"p:{i + 1}", _linear(lesson, lesson.p[i]))))
        claim = lesson.say("momenta", joint=joint.name)
        reason = lesson.say("momenta.reason") if not steps else Words(())
        steps.append(Step(f"momenta:{joint.name}", claim, tuple(blocks), reason, show=("momenta",)))
    for i in range(lesson.state.n):
        lesson.names[f"d/dt p:{i + 1}"] = Name(Rate(f"p:{i + 1}"), lesson.p_rates[i])
    shown = lesson.balls[0]
    first = lesson.first(shown)
    free = len(shown.rates) == 6
    p = [Symbol(f"p:{first + k + 1}") for k in range(len(shown.rates))]
    w = [Symbol(name) for name in shown.rates[-3:]]
    turned = _cross(w, p[-3:])
    blocks = [lesson.say("turned.angular", joint=shown.name), *(Words((one,)) for one in turned)]
    if free:
        blocks += [lesson.say("turned.linear"), *(Words((one,)) for one in _cross(w, p[:3]))]
    said = lesson.say("turned", joint=shown.name)
    return [*steps, Step("turned", said, tuple(blocks), lesson.say("turned.reason"))]


def _cross(a: Sequence[Symbol], b: Sequence[Symbol]) -> list[Form]:
    pairs = ((1, 2), (2, 0), (0, 1))
    return [Form.sum((Form.product((a[i], b[j])), Form.product((Number.MINUS_ONE, a[j], b[i])))) for i, j in pairs]


def _velocities(lesson: Turning, joint: Joint) -> range:
    first = lesson.first(joint)
    return range(first, first + len(joint.rates))


def _linear(lesson: Turning, node: Expr) -> Form:
    """Return Σ coefficient · u_j."""
    slopes = zip(gradient(node, lesson.state.qd), lesson.state.qd, strict=True)
    return Form.sum(lesson.shape(slope).signed_product(named(u)) for slope, u in slopes if not slope.is_zero)


# Equations


def name_forces_at_rest(lesson: Turning) -> None:
    """Name τ_i, k_G,i, k_E,i and X_i K, each with its value."""
    for i in range(lesson.state.n):
        number = str(i + 1)
        acting = "tau" if lesson.acting[i].is_zero and not lesson.ties else "S"
        lesson.name(f"tau:{number}", acting, number, node=lesson.needed[i])
        lesson.name(f"k_G:{number}", "k", "G", number, node=lesson.weights[i])
        lesson.name(f"k_E:{number}", "k", "E", number, node=lesson.springs[i])
        lesson.called(f"XK:{number}", Letter(rf"\partial_{{{number}}} {lesson.letters['K']}"), lesson.along_K[i])


def weight_step(lesson: Turning) -> Step | None:
    """Return what gravity and springs contribute; None where they do nothing."""
    blocks: list[Block] = []
    zero: list[Form] = []
    for kind, nodes in (("k_G", lesson.weights), ("k_E", lesson.springs)):
        for i, node in enumerate(nodes, 1):
            key, form = f"{kind}:{i}", lesson.shape(node)
            if form.terms:
                blocks.append(folded(lesson, Formula(key, form)))
            elif kind == "k_G":
                zero.append(Symbol(key))
    if not blocks:
        return None
    if zero:
        blocks.append(lesson.say("coefficients.zero", names=together(zero)))
    return Step("along", lesson.say("along"), tuple(blocks), lesson.say("along.reason"), show=("weights",))


def right_sides(lesson: Turning) -> tuple[Form, ...]:
    """Return drive + Q of every velocity."""
    found = []
    for drive, force in zip(lesson.scene.drives, lesson.acting, strict=True):
        found.append(Form.sum([*([Symbol(drive)] if drive else []), lesson.shape(force)]))
    return tuple(found)


def equation_steps(lesson: Turning, right: Sequence[Form]) -> list[Step]:
    """Return one step a velocity: the equation in its parts, and written out."""
    steps, u = list[Step](), lesson.state.qd
    for i in range(lesson.state.n):
        number = str(i + 1)
        parts: list[Form] = [Symbol(f"d/dt p:{number}")]
        for (j, k), terms in lesson.energy.directions.brackets.items():
            for m, value in terms if k == i else ():
                if lesson.shape(lesson.p[m]).terms:
                    parts.append(Form.product((Number(Fraction(-value)), named(u[j]), Symbol(f"p:{m + 1}"))))
        if lesson.shape(lesson.along_K[i]).terms:
            parts.append(Form.product((Number.MINUS_ONE, Symbol(f"XK:{number}"))))
        parts += [Symbol(key) for key, node in _along(lesson, i) if lesson.shape(node).terms]
        blocks: list[Block] = [Formula("", right[i], right=Form.sum(parts))]
        braces, long = _terms(lesson, i)
        blocks.append(Braced(right[i], tuple(braces), f"tau:{number}"))
        if long:
            blocks += [lesson.say("equation.named"), *(folded(lesson, Formula(*one)) for one in long.items())]
        reason = supplied(lesson, lesson.scene.drives[i], right[i], named(u[i]))
        steps.append(
            Step(f"equation:{number}", lesson.say("quaternion.equation", u=named(u[i])), tuple(blocks), reason)
        )
    return steps


def _along(lesson: Turning, i: int) -> tuple[tuple[str, Expr], tuple[str, Expr]]:
    """Return k_G,i and k_E,i: keys and values."""
    return (f"k_G:{i + 1}", lesson.weights[i]), (f"k_E:{i + 1}", lesson.springs[i])


def _terms(lesson: Turning, i: int) -> tuple[list[Brace], dict[str, Form]]:
    """Return the terms of one equation, coefficient by coefficient, and what is too long for a brace by its name."""
    state, node, n = lesson.state, lesson.needed[i], lesson.state.n
    found: list[tuple[str, tuple[str, ...], Expr, Form]] = []
    M = lesson.energy.mass_matrix()[i]
    for j in range(n):
        found.append((f"k_z:{i + 1},{j + 1}", ("z", f"{i + 1}{j + 1}"), M[j], named(state.qdd[j])))
    slopes = gradient(node, state.qd)
    pairs = [*combinations(range(n), 2), *((j, j) for j in range(n))]
    still = dict.fromkeys((*state.qd, *state.qdd), lesson.graph.zero)
    for j, k in pairs:
        second = gradient(slopes[j], [state.qd[k]])[0]
        (second,) = substitute([second], still)
        square = j == k
        index: tuple[str, ...] = ("D", f"{i + 1}{j + 1}") if square else ("C", str(i + 1), f"{j + 1}{k + 1}")
        key = f"k_D:{i + 1},{j + 1}" if square else f"k_C:{i + 1},{j + 1},{k + 1}"
        rate: Form = Power(named(state.qd[j]), 2) if square else Form.product((named(state.qd[j]), named(state.qd[k])))
        found.append((key, index, second / 2 if square else second, rate))
    braces: list[Brace] = []
    long: dict[str, Form] = {}
    for key, below, value, rate in found:
        form = lesson.shape(value)
        if not form.terms:
            continue
        lesson.name(key, "k", *below, node=value)
        braces.append(_brace(form, key, rate))
        if not braces[-1].under:
            long[key] = form
    for key, node in _along(lesson, i):  # written out above, where weights and springs are
        if (form := lesson.shape(node)).terms:
            braces.append(_brace(form, key, Number.ONE))
    return braces, long


def _brace(form: Form, key: str, rate: Form) -> Brace:
    short = length(form) <= MOST_TERMS // 3 and len(text_of(form)) <= WIDEST
    return Brace(form, key, rate) if short else Brace(Symbol(key), "", rate)
