"""The walkthrough of a mechanism whose bodies turn by quaternions, section by section."""

from __future__ import annotations

from symdyn.algebra import Form
from symdyn.scene import Scene, without_hidden_zeros
from symdyn.teach.derivations.afterwards.closed import closed_sections
from symdyn.teach.derivations.lagrange.numbers import scene_picture, state_step
from symdyn.teach.derivations.lagrange.principle import task_step
from symdyn.teach.derivations.lagrange.shows import with_figures
from symdyn.teach.derivations.multipliers.balance import meaning_step, name_forces, system_step
from symdyn.teach.derivations.multipliers.conditions import condition_steps, name_ties
from symdyn.teach.derivations.multipliers.motion import choose_tied_motion
from symdyn.teach.derivations.multipliers.numbers import forces_step, tied_power_step
from symdyn.teach.derivations.quaternions.equations import (
    energy_steps,
    equation_steps,
    momentum_steps,
    name_forces_at_rest,
    right_sides,
    weight_step,
)
from symdyn.teach.derivations.quaternions.kinematics import body_velocity_steps, rotation_steps, symbols_step
from symdyn.teach.derivations.quaternions.numbers import choose_turned, conserved_steps
from symdyn.teach.derivations.quaternions.turning import Turning
from symdyn.teach.document import Document, Name, Section
from symdyn.teach.notation import acting_steps, scene_step
from symdyn.teach.silent_loops import silent_steps

UNTIL = ("rotations", "energies", "equations", "numbers")
"""The parts that it may end with."""


def quaternions_walkthrough(scene: Scene, language: str = "en", until: str = "numbers") -> Document:
    """Return the walkthrough of a mechanism with quaternions, tied by conditions or not, up to one of `UNTIL`.

    Raises:
        DerivationError: no joint turns by a quaternion, or the equations are too long to be read.
    """
    lesson = Turning(without_hidden_zeros(scene), language)
    chosen = choose_tied_motion(lesson, None if lesson.ties else choose_turned(lesson))
    last, right = UNTIL.index(until), right_sides(lesson)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    sections = [
        lesson.section(
            "scene",
            [shown, *silent_steps(lesson), task_step(lesson), *acting_steps(lesson), symbols_step(lesson)],
        ),
        lesson.section("rotations.quaternion", rotation_steps(lesson)),
    ]
    if last >= 1:
        sections.append(lesson.section("velocities", body_velocity_steps(lesson)))
        sections.append(lesson.section("energies", energy_steps(lesson)))
    if last >= 2:
        sections += _equations(lesson, right)
    if last >= 3:
        sections += closed_sections(lesson)
        steps = [state_step(lesson, chosen), forces_step(lesson, chosen), tied_power_step(lesson, right, chosen)]
        sections.append(lesson.section("numbers", steps))
    sections = [with_figures(section, lesson.masses) for section in sections]
    title = lesson.text("title.quaternions", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "quaternions")


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
