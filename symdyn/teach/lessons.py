"""The one door to walkthroughs, a scene and choices in and a document out; and both roads, section by section."""

from __future__ import annotations

from dataclasses import replace

from symdyn.algebra.form import Form
from symdyn.dynamics.reactions.dalembert import COUPLING, DRIVE
from symdyn.errors import EmitError
from symdyn.scene import Scene, SceneLike, scene_of, without_hidden_zeros
from symdyn.scene.values.signals import as_parameters
from symdyn.teach.balance import Balance
from symdyn.teach.bodies import body_steps
from symdyn.teach.document import ERRATA, Block, Document, Section, Step, Words
from symdyn.teach.energies import energy_steps
from symdyn.teach.equation_steps import coefficient_steps, equation_steps, name_coefficients
from symdyn.teach.equilibria import equilibrium_step
from symdyn.teach.languages import LANGUAGES
from symdyn.teach.lesson import Lesson
from symdyn.teach.loops import loop_steps
from symdyn.teach.meaning import meaning_steps
from symdyn.teach.notation import acting_steps, leader, notation_step, scene_step
from symdyn.teach.numbers import number_steps, power_step, scene_picture, state_step, weights_picture
from symdyn.teach.reactions import numbers_step, roads_step, solved_steps
from symdyn.teach.shown_motion import choose_motion
from symdyn.teach.shown_state import Chosen, choose_state
from symdyn.teach.textbook import errata, numbers_for
from symdyn.teach.velocities import position_steps, velocity_steps

UNTIL = ("energies", "lagrangian", "equations", "coefficients", "numbers")
STAGES = ("count", "bodies", "reactions", "roads")
ROADS = {"lagrange": UNTIL, "dalembert": STAGES}
"""The parts of each road that a walkthrough may end with."""
DETAILS = ("brief", "full")


def walkthrough(
    scene: SceneLike, language: str = "en", detail: str = "full", until: str = "", road: str = "lagrange"
) -> Document:
    """Return the derivation of a scene's equations as a document.

    Args:
        scene: by Lagrange's road an open chain or tree with a closed form; by D'Alembert's any mechanism.
        language: "en" or "sk".
        detail: "full", or "brief" without the steps that a second reading needs.
        until: the last part, "" for all: on Lagrange's road "energies", "lagrangian", "equations", "coefficients" or
            "numbers", on D'Alembert's "count", "bodies", "reactions" or "roads".
        road: "lagrange" (5.21)-(5.23) or "dalembert" (5.1)-(5.20).

    Raises:
        EmitError: an unknown choice, or a scene that is too large to be read.
        DerivationError: the scene has no closed form, or constraints that Lagrange's road does not take.
    """
    scene = as_parameters(scene_of(scene))
    for name, value, known in (("language", language, LANGUAGES), ("detail", detail, DETAILS), ("road", road, ROADS)):
        if value not in known:
            raise EmitError(f"{name} {value!r} is not known; give one of {', '.join(known)}")
    until = until or ROADS[road][-1]
    if until not in ROADS[road]:
        raise EmitError(f"until {until!r} is no part of the road {road}; give one of {', '.join(ROADS[road])}")
    make = dalembert_walkthrough if road == "dalembert" else lagrange_walkthrough
    document = make(scene, language, until)
    return document.brief() if detail == "brief" else document


def lagrange_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of an open mechanism by Lagrange's equations (5.21)-(5.23), up to one of `UNTIL`.

    Raises:
        DerivationError: the mechanism has constraints or no closed form.
    """
    lesson = Lesson(without_hidden_zeros(scene), language)
    assert lesson.forms.n == lesson.state.n, "closed forms and graph have the same velocities"  # raises early
    lesson.numbers = numbers_for(lesson)
    found = lesson.masses
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    sections = [
        lesson.section("scene", [shown, *acting_steps(lesson), notation_step(lesson)]),
        lesson.section("positions", position_steps(lesson, found)),
        lesson.section("velocities", velocity_steps(lesson, found)),
    ]
    *energies, lagrangian = energy_steps(lesson, found)
    sections.append(lesson.section("energies", energies))
    last = UNTIL.index(until)
    if last >= 1:
        sections.append(lesson.section("lagrangian", [lagrangian]))
    if last >= 2:
        page = name_coefficients(lesson)
        sections.append(lesson.section("equations", equation_steps(lesson, page)))
    if last >= 3:
        steps = coefficient_steps(lesson, page)
        meanings = meaning_steps(lesson, page, found)
        weights = weights_picture(lesson, chosen, found)
        if weights is not None:
            meanings = _with_picture(meanings, weights)
        sections.append(lesson.section("coefficients", [*steps, *meanings]))
    if last >= 4:
        steps = number_steps(lesson, page, chosen)
        steps += [equilibrium_step(lesson, chosen), power_step(lesson, page, chosen)]
        sections.append(lesson.section("numbers", steps))
    if lesson.numbers:
        sections = [_with_errata(lesson, section, chosen) for section in sections]
    title = lesson.text("title", scene=scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections))


def _with_picture(steps: list[Step], shown: Block) -> list[Step]:
    """Return the steps with a picture in the first one about weights."""
    for k, step in enumerate(steps):
        if step.key.startswith("meaning:k_G"):
            return [*steps[:k], replace(step, blocks=(shown, *step.blocks)), *steps[k + 1 :]]
    return steps


def _with_errata(lesson: Lesson, section: Section, chosen: Chosen) -> Section:
    """Return the section with a step of boxes behind each step where the source is wrong."""
    steps: list[Step] = []
    for step in section.steps:
        steps.append(step)
        boxes = errata(lesson, step.key, chosen)
        if boxes:
            steps.append(Step(f"{ERRATA}{step.key}", Words(()), tuple(boxes)))
    return replace(section, steps=tuple(steps))


def dalembert_walkthrough(scene: Scene, language: str = "en", until: str = "roads") -> Document:
    """Return the walkthrough by D'Alembert's method (5.1)-(5.20), for open and closed mechanisms, up to one of STAGES.

    Raises:
        EmitError: there are more unknowns than anyone reads.
    """
    lesson = Balance(scene, language)
    chosen = choose_motion(lesson)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    first = [shown, *acting_steps(lesson), notation_step(lesson), _unknown_table(lesson)]
    sections = [lesson.section("scene", first), lesson.section("count", [_count(lesson), *loop_steps(lesson)])]
    last = STAGES.index(until)
    if last >= 1:
        steps = [step for j in range(len(lesson.scene.bodies)) for step in body_steps(lesson, j, chosen)]
        sections.append(lesson.section("bodies", steps))
    if last >= 2:
        steps = [*solved_steps(lesson), state_step(lesson, chosen), numbers_step(lesson, chosen)]
        sections.append(lesson.section("reactions", steps))
    if last >= 3 and (proof := roads_step(lesson, chosen)) is not None:
        sections.append(lesson.section("roads", [proof]))
    title = lesson.text("title.dalembert", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "dalembert")


def _unknown_table(lesson: Balance) -> Step:
    rows = []
    passive = lesson.system.passive
    for symbol, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True):
        words = lesson.along(one)
        kind = f"unknown.{words.split(' ')[0]}" if words else "unknown.other"
        if one.kind == DRIVE:
            kind = "unknown.drive" if one not in passive else "unknown.idle" if lesson.closed else "unknown.passive"
        places = {"joint": one.joint, "axis": words[-1:]}
        if one.kind == COUPLING:
            joint = next(joint for joint in lesson.scene.joints if joint.name == one.joint)
            kind, places["leader"] = "unknown.coupling", leader(lesson.scene, joint)
        rows.append((symbol, lesson.say(kind, **places)))
    table, reason = lesson.table(("symbol", "meaning"), rows), lesson.say("unknowns.reason")
    return Step("unknowns", lesson.say("unknowns"), (table,), reason, "(5.6), (5.7)")


def _count(lesson: Balance) -> Step:
    """Return (5.18)-(5.20) in numbers."""
    system, joints = lesson.system, (*lesson.scene.joints, *lesson.scene.loops)
    counts = [one.joint for one in system.unknowns if one.kind != DRIVE]
    rows = [(joint.name, lesson.kind(joint), str(counts.count(joint.name))) for joint in joints]
    classes = [counts.count(name) for name in dict.fromkeys(counts)]
    places: dict[str, str | Form] = {
        "equations": str(system.equations),
        "each": str(len(system.kept)),
        "bodies": str(len(system.bodies)),
        "sum": " + ".join(f"{t} · {classes.count(t)}" for t in sorted(set(classes), reverse=True)) or "0",
        "reactions": str(system.reactions),
        "drives": str(system.drives),
        "m": lesson.name("m:R", "m", "R", node=None),
    }
    correct = system.equations == len(system.unknowns)
    blocks: list[Block] = [lesson.table(("joint", "kind", "class"), rows), lesson.say("count.sum", **places)]
    coupled = ", ".join(one.joint for one in system.unknowns if one.kind == COUPLING)
    if coupled:
        blocks.append(lesson.say("count.coupled", joints=coupled))
    if system.passive:
        names = ", ".join(dict.fromkeys(one.joint for one in system.passive))
        key = "count.idle" if lesson.closed else "count.passive"
        blocks.append(lesson.say(key, number=str(len(system.passive)), joints=names))
    blocks.append(lesson.say("count.correct" if correct else "count.over", **places))
    plane = lesson.say("count.plane") if len(system.kept) == 3 else Words(())
    return Step("count", lesson.say("count", **places), tuple(blocks), plane, "(5.18)-(5.20)")
