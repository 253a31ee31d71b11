"""The walkthrough of a mechanism with loops or rolling by Lagrange's equations with multipliers, section by section."""

from __future__ import annotations

from dataclasses import replace

from symdyn.scene import Scene, without_hidden_zeros
from symdyn.teach.coordinates import coordinate_step
from symdyn.teach.derivations.afterwards.closed import closed_sections
from symdyn.teach.derivations.kane import kane_steps
from symdyn.teach.derivations.lagrange.energies import energy_steps
from symdyn.teach.derivations.lagrange.equation_steps import coefficient_steps, equation_steps, name_coefficients
from symdyn.teach.derivations.lagrange.numbers import scene_picture, state_step
from symdyn.teach.derivations.lagrange.principle import task_step
from symdyn.teach.derivations.lagrange.shows import with_figures
from symdyn.teach.derivations.lagrange.strut_lengths import length_steps
from symdyn.teach.derivations.lagrange.velocities import position_steps, velocity_steps
from symdyn.teach.derivations.multipliers.balance import name_forces, principle_steps, reduced_steps, system_step
from symdyn.teach.derivations.multipliers.conditions import condition_steps, name_ties
from symdyn.teach.derivations.multipliers.constrained import Constrained
from symdyn.teach.derivations.multipliers.motion import choose_tied_motion
from symdyn.teach.derivations.multipliers.numbers import forces_step, tied_power_step
from symdyn.teach.document import Document
from symdyn.teach.notation import acting_steps, notation_step, scene_step
from symdyn.teach.silent_loops import silent_steps

UNTIL = ("conditions", "energies", "lagrangian", "equations", "system", "numbers")
"""The parts that it may end with."""


def multipliers_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of a mechanism with loops, rolling or other conditions, up to one of `UNTIL`.

    Raises:
        DerivationError: nothing ties the coordinates, or the open mechanism has no closed form.
    """
    lesson = Constrained(without_hidden_zeros(scene), language)
    assert lesson.forms.n == lesson.state.n, "closed forms and graph have the same velocities"  # raises early
    name_ties(lesson)
    chosen, found, last = choose_tied_motion(lesson), lesson.masses, UNTIL.index(until)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    first = [shown, *silent_steps(lesson), task_step(lesson), coordinate_step(lesson, lesson.graph, chosen)]
    sections = [
        lesson.section("scene", [*first, *acting_steps(lesson), *length_steps(lesson), notation_step(lesson)]),
        lesson.section("conditions", condition_steps(lesson)),
    ]
    if last >= 1:
        *energies, lagrangian = energy_steps(lesson, found)
        sections += [
            lesson.section("positions", position_steps(lesson, found)),
            lesson.section("velocities", velocity_steps(lesson, found)),
            lesson.section("energies", energies),
        ]
    if last >= 2:
        sections.append(lesson.section("lagrangian", [lagrangian]))
    if last >= 3:
        open_page = name_coefficients(lesson)
        page = replace(open_page, right=name_forces(lesson, open_page.right))
        steps = equation_steps(lesson, page)  # names what the principle is made of
        sections.append(lesson.section("principle.multipliers", principle_steps(lesson, open_page)))
        sections.append(lesson.section("equations", [*steps, *kane_steps(lesson, page, chosen)]))
        sections.append(lesson.section("coefficients.open", coefficient_steps(lesson, page)))
    if last >= 4:
        sections.append(lesson.section("system", [system_step(lesson), *reduced_steps(lesson, open_page)]))
    if last >= 5:
        steps = [
            state_step(lesson, chosen),
            forces_step(lesson, chosen),
            tied_power_step(lesson, open_page.right, chosen),
        ]
        sections += [*closed_sections(lesson), lesson.section("numbers", steps)]
    sections = [with_figures(section, found) for section in sections]
    title = lesson.text("title.multipliers", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "multipliers")
