"""Walkthroughs: a scene and choices in, a document out. `FORMULATIONS` is the table of what there is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from symdyn.emit.print import refuse_too_long
from symdyn.errors import EmitError, NoValueError
from symdyn.scene import Scene, SceneLike, scene_of, with_symbols
from symdyn.teach.derivations.dalembert import walkthrough as dalembert
from symdyn.teach.derivations.dalembert.side_by_side import side_by_side
from symdyn.teach.derivations.lagrange import walkthrough as lagrange
from symdyn.teach.derivations.multipliers import walkthrough as multipliers
from symdyn.teach.derivations.quaternions import walkthrough as quaternions
from symdyn.teach.document import Document
from symdyn.teach.languages import language_of, languages
from symdyn.teach.lesson import SMALL_SCENE, Prose, is_tied


@dataclass(frozen=True)
class LessonFormulation:
    """One way from a scene to its equations.

    Attributes:
        until: the parts that its walkthrough may end with, in their order.
        walkthrough: (scene, language, until) to the document.
        usual: whether it is the one for a scene where nobody asks for another.
    """

    until: tuple[str, ...]
    walkthrough: Callable[[Scene, str, str], Document]
    usual: Callable[[Scene], bool]


def _compared(scene: Scene, language: str, until: str) -> Document:
    """Return Lagrange's walkthrough; a whole one has D'Alembert's terms beside its own, before what is an appendix."""
    document = lagrange.lagrange_walkthrough(scene, language, until)
    prose = Prose(document.scene, language, dict(document.names))
    table = side_by_side(prose) if until == lagrange.UNTIL[-1] else None
    if table is None:
        return document
    place = next((k for k, one in enumerate(document.sections) if one.key == "errata"), len(document.sections))
    both = prose.section("formulations", [table])
    return replace(document, sections=(*document.sections[:place], both, *document.sections[place:]))


def _turns_by_quaternion(scene: Scene) -> bool:
    return any(joint.velocities for joint in scene.joints)


FORMULATIONS: Mapping[str, LessonFormulation] = {
    "lagrange": LessonFormulation(
        lagrange.UNTIL, _compared, lambda scene: not _turns_by_quaternion(scene) and not is_tied(scene)
    ),
    "quaternions": LessonFormulation(quaternions.UNTIL, quaternions.quaternions_walkthrough, _turns_by_quaternion),
    "multipliers": LessonFormulation(
        multipliers.UNTIL, multipliers.multipliers_walkthrough, lambda scene: scene.is_closed
    ),
    "dalembert": LessonFormulation(dalembert.UNTIL, dalembert.dalembert_walkthrough, lambda scene: False),
}
"""The first whose lesson is the usual one of a scene is taken where nobody says which."""

DETAILS = ("brief", "full")

SHORTER = "ask for less of it (--until, --detail brief), or for --format sliders; generated code has no such limit"
"""What to ask for where a lesson is too long."""


def walkthrough(
    scene: SceneLike, language: str = "en", detail: str = "full", until: str = "", formulation: str = ""
) -> Document:
    """Return the derivation of a scene's equations as a document.

    Args:
        scene: by Lagrange's method an open chain or tree with a closed form; with multipliers one with loops,
            rolling or other conditions; with quaternions one whose bodies turn by them; by D'Alembert's any mechanism.
        language: "en" or "sk".
        detail: keep every small step, "full", or leave out those that a second reading needs, "brief".
        until: the last part, "" for all: by Lagrange's method "energies", "lagrangian", "equations",
            "coefficients" or "numbers"; with multipliers "conditions", "energies", "lagrangian", "equations", "system"
            or "numbers"; with quaternions "rotations", "energies", "equations" or "numbers"; by D'Alembert's "count",
            "bodies", "reactions" or "formulations".
        formulation: a key of `FORMULATIONS`: "lagrange" (5.21)-(5.23), "multipliers", "quaternions" or "dalembert"
            (5.1)-(5.20); "" for the first of them that is usual for the scene.

    Raises:
        EmitError: an unknown choice, or a scene that is too large to be read.
        DerivationError: the scene has no closed form, or constraints that Lagrange's formulation does not take.
        NoValueError: a formula has no value where the lesson shows numbers.
    """
    scene = scene_of(scene)
    formulation = formulation or usual_formulation(scene)
    scene = scene.as_parameters()
    for name, value, known in (
        ("language", language, languages()),
        ("detail", detail, DETAILS),
        ("formulation", formulation, FORMULATIONS),
    ):
        if value not in known:
            raise EmitError(f"{name} {value!r} is not known; give one of {', '.join(known)}")
    scene = with_letters(scene.in_language(language), language)
    chosen = FORMULATIONS[formulation]
    until = until or chosen.until[-1]
    if until not in chosen.until:
        raise EmitError(
            f"until {until!r} is no part of the formulation {formulation}; give one of {', '.join(chosen.until)}"
        )
    try:
        document = chosen.walkthrough(scene, language, until)
    except NoValueError as fault:
        raise NoValueError(f"{scene.name}: where the lesson shows numbers, such as at a dead centre: {fault}") from None
    document = document.brief() if detail == "brief" else document
    refuse_too_long(scene.name, f"the lesson by {formulation}", document.forms(), SHORTER)
    return document


def usual_formulation(scene: Scene) -> str:
    """Return the formulation that a scene's lesson takes where nobody asks for another."""
    return next(name for name, formulation in FORMULATIONS.items() if formulation.usual(scene))


def with_letters(scene: Scene, language: str = "en") -> Scene:
    """Return a small scene of numbers alone with letters in their place, which keep the numbers as values."""
    if scene.parameters or len(scene.velocities) > SMALL_SCENE:
        return scene
    named, said = with_symbols(scene, "all"), language_of(language).letter
    return replace(named, parameters=tuple(replace(one, text=said(one.text)) for one in named.parameters))
