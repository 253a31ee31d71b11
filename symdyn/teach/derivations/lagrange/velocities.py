"""Steps: where every mass is, and how fast it moves, differentiated term by term."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.algebra import Form, Function, Number, Power, Product, Sum, Symbol
from symdyn.graph import Expr, tangents
from symdyn.scene import Scene
from symdyn.spatial import Vec
from symdyn.teach.derivations.lagrange.forms import rate_of
from symdyn.teach.derivations.lagrange.rotations import angular_velocity, read_from
from symdyn.teach.document import Block, Fold, Formula, Step
from symdyn.teach.lesson import SMALL_SCENE, Lesson, Prose, named
from symdyn.teach.masses import AXES, Mass

MOST_TERMS = 20
"""Terms of one formula from which it is shown folded."""

PAGE = 90
"""The same for scenes that are shown in full: about a page."""

MOST = 20_000
"""Terms of the longest formula that is written at all: 600 in the examples, ten times this take minutes."""


def position_steps(lesson: Lesson, result: list[Mass]) -> list[Step]:
    """Return one step a mass: x, y, z of its place in the ground frame."""
    steps = []
    for mass in result:
        names = [lesson.name(f"{axis}:{mass.tag}", axis, mass.tag, node=node) for axis, node in _along(mass.place)]
        blocks = _components(lesson, names, mass.place)
        claim = lesson.say(f"position.{_kind(mass)}", body=mass.body.name, tag=mass.tag)
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
            blocks = [lesson.say("velocity.rests", tag=mass.tag)]
        if details:
            shown = len(lesson.scene.velocities) <= SMALL_SCENE
            table = tuple(details)
            blocks = [*(table if shown and len(table) < 3 else (Fold(lesson.say("velocity.terms"), table),)), *blocks]
        claim = lesson.say("velocity", tag=mass.tag, body=mass.body.name)
        reason = lesson.once("velocity.reason", lesson.say("place", tag=mass.tag))
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
    return Step(f"turning:{tag}", claim, tuple(blocks), lesson.once(key, mass.body.name))


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


def _kind(mass: Mass) -> str:
    return "particle" if mass.particle else "centre" if mass.h is None else "origin"


def _range(blocks: list[Block]) -> str:
    """Return the equation numbers of some formulas: "5.28, 5.29"."""
    return ", ".join(f"({b.number})" for b in blocks if isinstance(b, Formula) and b.number)
