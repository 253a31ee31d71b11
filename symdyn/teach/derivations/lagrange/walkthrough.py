"""The walkthrough of an open mechanism by Lagrange's equations, section by section."""

from __future__ import annotations

from dataclasses import replace

from symdyn.scene import Scene, without_hidden_zeros
from symdyn.teach.coordinates import coordinate_step
from symdyn.teach.derivations.afterwards.afterwards import after_sections
from symdyn.teach.derivations.kane import kane_steps
from symdyn.teach.derivations.lagrange.energies import energy_steps
from symdyn.teach.derivations.lagrange.equation_steps import coefficient_steps, equation_steps, name_coefficients
from symdyn.teach.derivations.lagrange.meaning import meaning_steps
from symdyn.teach.derivations.lagrange.numbers import number_steps, power_step, scene_picture, weights_picture
from symdyn.teach.derivations.lagrange.principle import principle_steps, task_step
from symdyn.teach.derivations.lagrange.rotations import rotation_steps
from symdyn.teach.derivations.lagrange.shows import with_figures
from symdyn.teach.derivations.lagrange.strut_lengths import length_steps
from symdyn.teach.derivations.lagrange.velocities import position_steps, velocity_steps
from symdyn.teach.document import Block, Document, Step
from symdyn.teach.lesson import Lesson
from symdyn.teach.notation import acting_steps, notation_step, scene_step
from symdyn.teach.picture_letters import picture_letters
from symdyn.teach.shown_state import choose_state
from symdyn.teach.silent_loops import silent_steps
from symdyn.teach.textbook import errata, numbers_for, with_appendix

UNTIL = ("energies", "lagrangian", "equations", "coefficients", "numbers")
"""The parts that it may end with."""


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
    page = name_coefficients(lesson)
    letters = picture_letters(lesson.scene, lesson.graph, chosen)
    shown = scene_step(lesson, scene_picture(lesson, chosen, letters))
    first = [shown, *silent_steps(lesson), task_step(lesson), coordinate_step(lesson, lesson.graph, chosen)]
    sections = [
        lesson.section("scene", [*first, *acting_steps(lesson), *length_steps(lesson), notation_step(lesson)]),
        lesson.section("principle", principle_steps(lesson, page)),
        *([lesson.section("rotations", turned)] if (turned := rotation_steps(lesson, found)) else []),
        lesson.section("positions", position_steps(lesson, found)),
        lesson.section("velocities", velocity_steps(lesson, found)),
    ]
    *energies, lagrangian = energy_steps(lesson, found)
    sections.append(lesson.section("energies", energies))
    last = UNTIL.index(until)
    if last >= 1:
        sections.append(lesson.section("lagrangian", [lagrangian]))
    if last >= 2:
        sections.append(lesson.section("equations", [*equation_steps(lesson, page), *kane_steps(lesson, page, chosen)]))
    if last >= 3:
        steps = coefficient_steps(lesson, page)
        meanings = meaning_steps(lesson, page, found)
        weights = weights_picture(lesson, chosen, found)
        if weights is not None:
            meanings = _with_picture(meanings, weights)
        sections.append(lesson.section("coefficients", [*steps, *meanings]))
    if last >= 4:
        sections += after_sections(lesson, page, chosen)
        steps = [*number_steps(lesson, page, chosen), power_step(lesson, page, chosen)]
        sections.append(lesson.section("numbers", steps))
    if lesson.numbers:
        sections = with_appendix(lesson, [errata(lesson, section, chosen) for section in sections])
    sections = [with_figures(section, found) for section in sections]
    title = lesson.text("title", scene=scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections))


def _with_picture(steps: list[Step], shown: Block) -> list[Step]:
    """Return the steps with a picture in the first one about weights."""
    for k, step in enumerate(steps):
        if step.key.startswith("meaning:k_G"):
            return [*steps[:k], replace(step, blocks=(shown, *step.blocks)), *steps[k + 1 :]]
    return steps
