"""The walkthrough of a mechanism whose bodies turn by quaternions, section by section.

It begins with what a unit quaternion is, the rotation that it makes, ω from its rate and its rate from ω, and
velocities, and ends with what the equations are worth at a state, and what stays constant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from math import sqrt

from symdyn.algebra import Form, Number, Symbol
from symdyn.emit.print import latex_symbols
from symdyn.graph import Expr, reachable, tangents
from symdyn.scene import Quantity, Scene, without_hidden_zeros
from symdyn.scene.joints import joint_motion
from symdyn.scene.values import Joint
from symdyn.spatial import Mat
from symdyn.teach.derivations.eliminated import conserved_sections
from symdyn.teach.derivations.equilibria import closed_sections
from symdyn.teach.derivations.lagrange import scene_picture, state_step, task_step, with_figures
from symdyn.teach.derivations.multiplier_steps import condition_steps, meaning_step, name_forces, name_ties, system_step
from symdyn.teach.derivations.multipliers import choose_tied_motion, forces_step, tied_power_steps
from symdyn.teach.derivations.quaternion_steps import (
    Turning,
    energy_steps,
    equation_steps,
    momentum_steps,
    name_forces_at_rest,
    right_sides,
    weight_step,
)
from symdyn.teach.derivations.rotations import angular_velocity
from symdyn.teach.derivations.turning_body import turning_sections
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Document, Formula, Letter, Matrix, Name, Section, Step, Words
from symdyn.teach.lesson import AXES, called, named, silent_steps, together
from symdyn.teach.notation import acting_steps, joints_step, notation_step, scene_step
from symdyn.teach.shown_state import Chosen, choose_state

TWO, HALF = Number(Fraction(2)), Number(Fraction(1, 2))
MINUS = Number(Fraction(-1))


def rotation_steps(lesson: Turning) -> list[Step]:
    """Return the steps about every quaternion; what is the same for all is said of the first."""
    steps: list[Step] = []
    for k, joint in enumerate(lesson.balls):
        steps += _quaternion(lesson, joint, first=k == 0)
    return steps


def _quaternion(lesson: Turning, joint: Joint, first: bool) -> list[Step]:
    graph, spelled = lesson.graph, latex_symbols(lesson.scene)
    e = tuple(graph.symbol(name) for name in joint.coordinates[-4:])
    e0, e1, e2, e3 = forms = [named(x) for x in e]
    for u in joint.rates:
        lesson.names[u] = Name(None, graph.symbol(u))
    rates = [lesson.state.velocity[x] for x in e]
    dots = [
        lesson.called(f"rate:{x.value}", Letter(rf"\dot{{{spelled[str(x.value)]}}}"), node)
        for x, node in zip(e, rates, strict=True)
    ]
    square = Form.sum(x.power(2) for x in forms)
    steps: list[Step] = []
    if first:
        said = lesson.say("quaternion.unit", scalar=e0, vector=together([e1, e2, e3]), square=square)
        claim = lesson.say("quaternion", joint=joint.name)
        steps.append(Step("quaternion", claim, (said,), lesson.say("quaternion.reason")))
    steps.append(_rotation(lesson, joint, e, first))
    w = [Symbol(name) for name in joint.rates[-3:]]
    c0, c1, c2, c3 = dots
    a, b, c = w
    turning = ((a, c1, e1, e2, c3, e3, c2), (b, c2, e2, e3, c1, e1, c3), (c, c3, e3, e1, c2, e2, c1))
    blocks: list[Block] = []
    for one, own, x, y, z, s, t in turning:
        terms = (
            Form.product((e0, own)),
            Form.product((MINUS, x, c0)),
            Form.product((MINUS, y, z)),
            Form.product((s, t)),
        )
        blocks.append(Formula(one.name, Form.product((TWO, Form.sum(terms)))))
    reason = lesson.say("quaternion.omega.reason") if first else Words(())
    claim = lesson.say("quaternion.omega", joint=joint.name)
    steps.append(Step(f"omega:{joint.name}", claim, tuple(blocks), reason, show=("velocities",)))
    inverse = (
        Form.sum(Form.product((MINUS, x, y)) for x, y in ((e1, a), (e2, b), (e3, c))),
        Form.sum((Form.product((e0, a)), Form.product((e2, c)), Form.product((MINUS, e3, b)))),
        Form.sum((Form.product((e0, b)), Form.product((e3, a)), Form.product((MINUS, e1, c)))),
        Form.sum((Form.product((e0, c)), Form.product((e1, b)), Form.product((MINUS, e2, a)))),
    )
    back: list[Block] = [Formula(dot.name, Form.product((HALF, form))) for dot, form in zip(dots, inverse, strict=True)]
    kept = Form.sum(Form.product((x, dot)) for x, dot in zip(forms, dots, strict=True))
    back.append(lesson.say("quaternion.kept", sum=kept))
    reason = lesson.say("quaternion.rates.reason") if first else Words(())
    steps.append(Step(f"rates:{joint.name}", lesson.say("quaternion.rates", joint=joint.name), tuple(back), reason))
    if len(joint.coordinates) == 7:
        steps.append(_shift(lesson, joint))
    return steps


def _rotation(lesson: Turning, joint: Joint, e: tuple[Expr, ...], first: bool) -> Step:
    R, key = Mat.of_quaternion(e), f"R:{joint.name}"
    index = (joint.name,) if len(lesson.balls) > 1 else ()
    lesson.name(key, "R", *index, node=None)
    names = []
    for a, row in enumerate(R, 1):
        for b, node in enumerate(row, 1):
            names.append(f"{key},{a}{b}")
            lesson.name(names[-1], "R", *index, f"{a}{b}", node=node)
    matrix = Matrix(key, tuple(lesson.short(x) for row in R for x in row), tuple(names), width=3)
    reason = lesson.say("quaternion.rotation.reason") if first else Words(())
    claim = lesson.say("quaternion.rotation", joint=joint.name)
    return Step(f"rotation:{joint.name}", claim, (matrix,), reason, show=("frames", f"joint:{joint.name}"))


def _shift(lesson: Turning, joint: Joint) -> Step:
    """Return ṙ = R v of free flight."""
    spelled, blocks = latex_symbols(lesson.scene), list[Block]()
    R = Symbol(f"R:{joint.name}")
    for name, rate in zip(joint.coordinates[:3], joint_motion(joint, lesson.graph).rates[:3], strict=True):
        key = lesson.called(f"rate:{name}", Letter(rf"\dot{{{spelled[name]}}}"), rate).name
        blocks.append(folded(lesson, Formula(key, lesson.short(rate))))
    v = together([Symbol(name) for name in joint.rates[:3]])
    claim = lesson.say("quaternion.shift", joint=joint.name, velocities=v)
    return Step(f"shift:{joint.name}", claim, tuple(blocks), lesson.say("quaternion.shift.reason", matrix=R))


# Velocities of masses


def body_velocity_steps(lesson: Turning) -> list[Step]:
    """Return velocity and angular velocity of every mass in the axes of its body."""
    steps: list[Step] = []
    for mass in lesson.masses:
        T, tag = lesson.placed[mass.body.name], mass.tag
        x, y, z = tangents(mass.place, lesson.state.velocity)
        v, w = T.R.T @ (x, y, z), angular_velocity(lesson, mass.body)
        blocks: list[Block] = []
        for letter, key, entries in (("v", "v", v), ("omega", "omega", w)):
            if letter == "omega" and not mass.spins:
                continue
            for axis, node in zip(AXES, entries, strict=True):
                name = lesson.name(f"{key}:{tag}{axis}", letter, tag, axis, node=node).name
                blocks.append(folded(lesson, Formula(name, lesson.shape(node))))
        claim = lesson.say("body.velocity", mass=lesson.of(mass), body=mass.body.name)
        reason = lesson.say("body.velocity.reason") if not steps else Words(())
        steps.append(Step(f"velocity:{tag}", claim, tuple(blocks), reason, show=("velocities",)))
    return steps


TURNED = (0.8, 0.4, 0.2, 0.4)
"""A unit quaternion none of whose components hides anything."""


def choose_turned(lesson: Turning) -> Chosen:
    """Return the state of all lessons with every quaternion turned away from where it hides something."""
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
    values = dict(chosen.values)
    for sphere in lesson.spheres:
        e = [values[x] for x in sphere]
        if min(map(abs, e)) < 1e-6 or abs(sqrt(sum(x * x for x in e)) - 1) > 1e-9:
            values |= dict(zip(sphere, TURNED, strict=True))
    return replace(chosen.with_values(values), q=tuple(values[q] for q in lesson.state.q))


def conserved_steps(lesson: Turning) -> list[Step]:
    """Return a step for every quaternion whose momentum about the turned axes keeps its size, as without moments."""
    if lesson.ties:
        return []
    steps = []
    for joint in lesson.balls:
        first = lesson.first(joint) + len(joint.rates) - 3
        own = range(first, first + 3)
        free = all(lesson.scene.drives[i] is None and lesson.acting[i].is_zero for i in own)
        graph = lesson.graph
        turning = graph.total(lesson.p[i] * (lesson.p_rates[i] - lesson.needed[i]) for i in own)
        if not free or not lesson.vanishes(turning):
            continue
        square: Form = Form.sum(Symbol(f"p:{i + 1}").power(2) for i in own)
        assert square.terms, "a sum of squares has terms"
        momenta = together([Symbol(f"p:{i + 1}") for i in own])
        said = lesson.say("conserved", joint=joint.name, square=square)
        steps.append(Step(f"conserved:{joint.name}", said, (), lesson.say("conserved.reason", momenta=momenta)))
    return steps


UNTIL = ("rotations", "energies", "equations", "numbers")
"""The parts that it may end with."""


def quaternions_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of a mechanism with quaternions, tied by conditions or not, up to one of `UNTIL`.

    Raises:
        DerivationError: no joint turns by a quaternion, or the equations are too long to be read.
    """
    lesson = _without_idle_masses(Turning(without_hidden_zeros(scene), language))
    chosen = choose_tied_motion(lesson, None if lesson.ties else choose_turned(lesson))
    last, right = UNTIL.index(until), right_sides(lesson)
    shown = scene_step(lesson, scene_picture(lesson, chosen), numbered=False)
    begun = rotation_sections(lesson)
    sections = [turning_scene(lesson, shown, *silent_steps(lesson), task_step(lesson)), next(begun)]
    sections += begun if last >= 1 else ()
    if last >= 2:
        sections += _equations(lesson, right)
    if last >= 3:
        kept = conserved_sections(lesson) if lesson.ties else turning_sections(lesson, chosen)
        sections += [*closed_sections(lesson), *kept]
        steps = [state_step(lesson, chosen), forces_step(lesson, chosen), *tied_power_steps(lesson, right, chosen)]
        sections.append(lesson.section("numbers", steps))
    sections = [with_figures(section, lesson.masses) for section in sections]
    title = lesson.text("title.quaternions", scene=called(lesson.scene))
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "quaternions")


def turning_scene(lesson: Turning, *first: Step) -> Section:
    """Return the section of the mechanism: its first steps, what acts, all symbols, joints."""
    return lesson.section("scene", [*first, *acting_steps(lesson), notation_step(lesson), joints_step(lesson)])


def rotation_sections(lesson: Turning) -> Iterator[Section]:
    """Yield the sections of quaternions, velocities in turning axes, and energies."""
    yield lesson.section("rotations.quaternion", rotation_steps(lesson))
    yield lesson.section("velocities", body_velocity_steps(lesson))
    yield lesson.section("energies", energy_steps(lesson))


def _without_idle_masses(lesson: Turning) -> Turning:
    """Return a lesson without letters of masses that no equation holds: of a body about a fixed point moments count."""
    used = {str(x.value) for x in reachable([lesson.L, *lesson.acting])}
    parameters = lesson.scene.parameters
    idle = {
        Quantity.symbol(one.name): one.value for one in parameters if one.name not in used and one.value is not None
    }
    bodies = tuple(replace(one, mass=idle.get(one.mass, one.mass)) for one in lesson.scene.bodies)
    if bodies == lesson.scene.bodies:
        return lesson
    gone = {one.mass for one in lesson.scene.bodies} & idle.keys()
    kept = tuple(one for one in parameters if Quantity.symbol(one.name) not in gone)
    return Turning(replace(lesson.scene, bodies=bodies, parameters=kept), lesson.language)


def _equations(lesson: Turning, right: tuple[Form, ...]) -> list[Section]:
    """Return the sections of momenta and equations, and of conditions where there are some."""
    name_forces_at_rest(lesson)
    sections = []
    whole = right
    if lesson.ties:
        name_ties(lesson)
        sections.append(lesson.section("conditions", condition_steps(lesson)))
        whole = name_forces(lesson, right)
    else:
        for drive, node in zip(lesson.scene.drives, lesson.drives, strict=True):
            if drive:
                lesson.names[drive] = Name(None, node)
    along = weight_step(lesson)
    sections.append(lesson.section("momenta", [*momentum_steps(lesson), *([along] if along else [])]))
    steps = equation_steps(lesson, whole)
    meaning = [meaning_step(lesson)] if lesson.ties else []
    sections.append(lesson.section("equations.turning", [*meaning, *steps, *conserved_steps(lesson)]))
    if lesson.ties:
        sections.append(lesson.section("system", [system_step(lesson)]))
    return sections
