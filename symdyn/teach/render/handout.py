"""A lesson as it is handed out: of a scene or a variant of it, whole or with exercises, or as a sheet of them.

A walkthrough takes a scene and choices, and gives a document; `FORMULATIONS` is the table of what there is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import ClassVar

from symdyn.algebra import Form, Symbol
from symdyn.arguments import argument, suggesting
from symdyn.emit.print import latex_symbols, refuse_too_long
from symdyn.errors import EmitError, NoValueError, TeachError, choice
from symdyn.frozen import dataclass, replace
from symdyn.scene import Quantity, Scene, SceneLike, SceneUnits, scene_of, with_symbols
from symdyn.scene.forces import FORCES
from symdyn.spatial import zero_vector
from symdyn.table import Table
from symdyn.teach.derivations import lagrange, multipliers, quaternions
from symdyn.teach.derivations.contact_runs import with_contacts, without_contacts
from symdyn.teach.derivations.dalembert import walkthrough as dalembert
from symdyn.teach.derivations.dalembert.side_by_side import side_by_side
from symdyn.teach.derivations.formulations import UNTIL, WAYS, formulation_walkthrough, with_cost
from symdyn.teach.derivations.own_states import with_states
from symdyn.teach.document import Document, Letter, Step, Words
from symdyn.teach.languages import language_of, languages
from symdyn.teach.lesson import SMALL_SCENE, Prose, apart, is_tied
from symdyn.teach.notation import in_order
from symdyn.teach.practice.exercises import GRADES, with_exercises
from symdyn.teach.practice.questions import sheet
from symdyn.teach.practice.quiz import Variant as Asked
from symdyn.teach.practice.variants import Variant, variant, with_changes
from symdyn.teach.render import PLATFORMS, asked, rendered
from symdyn.teach.render.math_editor import with_math_editor
from symdyn.teach.render.page import interactive_page
from symdyn.teach.render.quiz_text import Quiz
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class LessonFormulation:
    """One way from a scene to its equations."""

    until: tuple[str, ...]  # the parts that its walkthrough may end with, in their order
    walkthrough: Callable[[Scene, str, str], Document]  # (scene, language, until) to the document
    usual: Callable[[Scene], bool]  # whether it is the one for a scene where nobody asks for another


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


def _with_matter(document: Document) -> Document:
    """Return a lesson with what matter does that leaves or arrives."""
    scene, graph = document.scene, document.graph
    flows = [(one, law) for one in scene.loads if (law := FORCES[one.kind].push.carried)]
    if not flows:
        return document
    prose, blocks = Prose(scene, document.language, dict(document.names)), []
    for one, law in flows:
        force = [Form.of(x) for x in FORCES[one.kind].push.wrench(one, scene, graph).force]
        shown, body = Words(("(", force[0], ", ", force[1], ", ", force[2], ")")), one.place.body
        blocks.append(prose.say(f"matter.{one.frame}", flow=one.name, body=body, force=shown))
        turning = (graph.symbol(" x"), graph.symbol(" y"), graph.symbol(" z"))  # names that no scene has
        if any(not x.is_zero for part in law(one, scene, zero_vector(graph), turning) for x in part):
            blocks.append(prose.say("matter.turns", body=body))
    step = Step("matter", prose.say("matter"), tuple(blocks), prose.say("matter.reason"))
    first, *others = document.sections
    return replace(document, sections=(first, prose.section("matter", [step]), *others))


def _with_mass_matrix(document: Document) -> Document:
    """Return a lesson whose table of symbols has the mass matrix, too, where it is bold beside the scene's own M."""
    prose = Prose(document.scene, document.language, dict(document.names))
    bold = Letter(prose.letters.mass_matrix)
    own = [name for name, printed in latex_symbols(document.scene).items() if printed == "M"]
    if not own or all(not isinstance(x.look, Letter) or x.look.letter != bold.letter for x in document.names.values()):
        return document
    cells = prose.called("mass:", bold), prose.say("notation.mass_matrix", M=Symbol(own[0])), Words(("",)), Words(("",))
    row = tuple(cell if isinstance(cell, Words) else Words((cell,)) for cell in cells)

    def told(step: Step) -> Step:
        blocks = [replace(x, rows=(*x.rows, row)) if isinstance(x, Table) else x for x in step.blocks]
        return replace(step, blocks=tuple(blocks)) if step.key == "notation" else step

    sections = (replace(one, steps=tuple(map(told, one.steps))) for one in document.sections)
    return replace(document, sections=tuple(sections), names=prose.names)


def _turns_by_quaternion(scene: Scene) -> bool:
    return any(joint.velocities for joint in scene.joints)


FORMULATIONS: Mapping[str, LessonFormulation] = {
    "lagrange": LessonFormulation(
        lagrange.UNTIL, _compared, lambda scene: not _turns_by_quaternion(scene) and not is_tied(scene)
    ),
    "quaternions": LessonFormulation(quaternions.UNTIL, quaternions.quaternions_walkthrough, _turns_by_quaternion),
    "multipliers": LessonFormulation(
        multipliers.UNTIL, multipliers.multipliers_walkthrough, lambda scene: scene.is_constrained
    ),
    "dalembert": LessonFormulation(dalembert.UNTIL, dalembert.dalembert_walkthrough, lambda scene: False),
    **{name: LessonFormulation(UNTIL, partial(formulation_walkthrough, name), lambda scene: False) for name in WAYS},
}
"""The first whose lesson is the usual one of a scene is taken where nobody says which."""

DETAILS = ("brief", "full")
MOST_VARIANTS = 20


def _shorter() -> str:
    """Return what to ask for where a lesson is too long."""
    less = argument("until")
    return f"ask for less of it ({less}), or for {argument('format', 'sliders')}; generated code has no such limit"


@suggesting
def walkthrough(
    scene: SceneLike, language: str = "en", detail: str = "brief", until: str = "", formulation: str = ""
) -> Document:
    """Return the derivation of a scene's equations as a document.

    Args:
        scene: by Lagrange's method an open chain or tree with a closed form; with multipliers one with loops,
            rolling or other conditions; with quaternions one whose bodies turn by them; by D'Alembert's any mechanism;
            by the others one that `symdyn.equations` writes such equations of.
        language: "en" or "sk".
        detail: brief has the task, the equations, what follows from them and checks, all other steps folded, and left
            out of LaTeX and PDF; full has every step open.
        until: the last part, "" for all: by Lagrange's method "energies", "lagrangian", "equations",
            "coefficients" or "numbers"; with multipliers "conditions", "energies", "lagrangian", "equations", "system"
            or "numbers"; with quaternions "rotations", "energies", "equations" or "numbers"; by D'Alembert's "count",
            "bodies", "reactions" or "formulations"; by the others "equations", "check" or "gains".
        formulation: a key of `FORMULATIONS`: "lagrange" (5.21)-(5.23), "multipliers", "quaternions", "dalembert"
            (5.1)-(5.20), or one of `WAYS`, such as "hamilton"; "" for the first of them that is usual for the scene.

    Raises:
        EmitError: an unknown choice, or a scene that is too large to be read.
        DerivationError: the scene has no closed form, or constraints that Lagrange's formulation does not take.
        NoValueError: a formula has no value where the lesson shows numbers.
    """
    scene = scene_of(scene)
    formulation = formulation or usual_formulation(scene)
    if scene.is_constrained or _turns_by_quaternion(scene):
        scene.refuse_contacts("a lesson of loops, rows or quaternions", EmitError)
    declared, scene = scene, scene.as_parameters()
    for name, value, known in (
        ("language", language, languages()),
        ("detail", detail, DETAILS),
        ("formulation", formulation, FORMULATIONS),
    ):
        if value not in known:
            raise EmitError(f"{name} {value!r} is not known; {choice(value, known)}")
    scene = in_order(masses_first(apart(with_letters(scene.in_language(language), language), language)))
    chosen = FORMULATIONS[formulation]
    until = until or chosen.until[-1]
    if until not in chosen.until:
        raise EmitError(f"until {until!r} is no part of the formulation {formulation}; {choice(until, chosen.until)}")
    touched = scene
    scene = without_contacts(scene)
    try:
        document = chosen.walkthrough(scene, language, until)
    except NoValueError as fault:
        raise NoValueError(f"{scene.name}: where the lesson shows numbers, such as at a dead centre: {fault}") from None
    document = with_cost(document, declared) if formulation in WAYS else document
    document = _with_mass_matrix(with_contacts(_with_matter(document), touched))
    document = with_states(document, declared) if declared.states else document
    if declared.given or any(joint.dry for joint in declared.joints):  # what acts is not constant
        document = _without(document, "uniform")
    document = replace(document, brief=detail == "brief")
    refuse_too_long(scene.name, f"the lesson by {formulation}", document.forms(), _shorter())
    return document


def _without(document: Document, key: str) -> Document:
    """Return a document without the steps of a key."""
    kept = (replace(part, steps=tuple(x for x in part.steps if x.key != key)) for part in document.sections)
    return replace(document, sections=tuple(kept))


def usual_formulation(scene: Scene) -> str:
    """Return the formulation that a scene's lesson takes where nobody asks for another."""
    return next(name for name, formulation in FORMULATIONS.items() if formulation.usual(scene))


def with_letters(scene: Scene, language: str = "en") -> Scene:
    """Return a small scene of numbers alone with letters in their place, which keep the numbers as values."""
    if scene.parameters or len(scene.velocities) > SMALL_SCENE:
        return scene
    named, said = _axes_alike(with_symbols(scene, "all")), language_of(language).letter
    return replace(named, parameters=tuple(replace(one, text=said(one.text)) for one in named.parameters))


def masses_first(scene: Scene) -> Scene:
    """Return a scene with masses, then moments of inertia, before other parameters: m l² is printed, not l² m."""
    units = SceneUnits(scene).inferred
    order = ("kg", "kg m", "kg m^2")
    place = {one.name: order.index(units[one.name]) if units[one.name] in order else 3 for one in scene.parameters}
    parameters = sorted(scene.parameters, key=lambda one: place[one.name])
    return replace(scene, parameters=tuple(parameters))


def _axes_alike(scene: Scene) -> Scene:
    """Return a scene whose moments of inertia of one body, where they are equal, are one letter."""
    known, bodies = {Quantity.symbol(one.name): one for one in scene.parameters}, []
    for body in scene.bodies:
        moments, first = [*body.inertia], dict[Quantity | None, int]()
        for k, axes in enumerate(("xx", "yy", "zz")):
            if (letter := known.get(moments[k])) is None:
                continue
            at = first.setdefault(letter.value, k)
            if at != k:
                kept = known[moments[at]]
                text = kept.text.replace(" of ", f" = {axes} of ", 1)
                known[moments[at]] = replace(kept, text=text)
                del known[moments[k]]
                moments[k] = moments[at]
        xx, yy, zz, xy, xz, yz = moments
        bodies.append(replace(body, inertia=(xx, yy, zz, xy, xz, yz)))
    return replace(scene, bodies=tuple(bodies), parameters=tuple(known.values()))


@dataclass(frozen=True)
class Handout:
    """A lesson as it is handed out.

    Attributes:
        scene: any that `walkthrough` takes.
        language, detail, until, formulation: as of `walkthrough`.
        seed: of a variant of the scene: other masses, lengths, axes, springs, another way down; None for the scene.
        exercises: leave results out, with hints and solutions; the HTML page checks answers.
        grade, ask: which, as of `with_exercises`.
        grades: those that there are; platforms: formats of `files` that are questions for learning platforms.
        sheet: the exercises to print, "questions" with room to write, or "solutions"; "" for the whole lesson.
        variants: how many a question for a learning platform draws from: the one of `seed` and those that follow it.
        math_editor: MathLive's folder, for a page that takes formulas in two dimensions, see `with_math_editor`.
    """

    grades: ClassVar[tuple[int, ...]] = tuple(GRADES)
    platforms: ClassVar[tuple[str, ...]] = tuple(PLATFORMS)

    scene: Scene
    language: str = "en"
    detail: str = "brief"
    until: str = ""
    formulation: str = ""
    seed: int | None = None
    exercises: bool = False
    grade: int = 2
    ask: tuple[str, ...] = ()
    sheet: str = ""
    variants: int = 1
    math_editor: str = ""

    @cached_property
    def variant(self) -> Variant | None:
        """The variant that is drawn; None for the scene itself."""
        return None if self.seed is None else variant(self.scene, self.seed)

    @property
    def shown(self) -> Scene:
        """The scene that the lesson is about."""
        return self.variant.scene if self.variant else self.scene

    def page(self) -> str:
        """Return the interactive part alone, as HTML; errors as of `interactive_page`."""
        return interactive_page(self.shown, language=self.language)

    def document(self) -> Document:
        """Return the lesson; errors as of `walkthrough`, `variant` and `with_exercises`."""
        found = walkthrough(self.shown, self.language, self.detail, self.until, self.formulation)
        found = with_changes(found, self.variant) if self.variant else found
        found = with_exercises(found, self.grade, self.ask) if self.exercises else found
        return sheet(found, self.sheet == "solutions") if self.sheet else found

    def quiz(self) -> Quiz:
        """Return the exercises for learning platforms.

        Raises:
            TeachError: there is nothing to ask, or no question that every variant has; else errors as of `document`.
        """
        if not 1 <= self.variants <= MOST_VARIANTS:
            raise TeachError(f"variants = {self.variants}; give 1 to {MOST_VARIANTS}")
        first = 0 if self.seed is None else self.seed
        seeds = [self.seed, *range(first + 1, first + self.variants)]
        lessons = [replace(self, seed=seed, exercises=True, sheet="") for seed in seeds]
        settings = {name: getattr(self, name) for name in ("language", "until", "formulation", "grade", "ask")}
        drawn = (Asked(one.document(), one.seed) for one in lessons)
        return Quiz(self.scene, tuple(drawn), settings)

    def files(self, formats: Iterable[str], progress: Callable[[str], None]) -> dict[str, str | bytes]:
        """Return the files of the lesson in formats, by name; errors as of `document`, `rendered` and `quiz`."""
        found, document, quiz = dict[str, str | bytes](), None, None
        for one in formats:
            if one in PLATFORMS:
                quiz = quiz or self.quiz()
                found |= asked(quiz, one)
            else:
                document = document or self.document()
                progress("writing")
                files = rendered(document, one)
                if one == "html" and self.math_editor:
                    editor = self.math_editor
                    files = {name: with_math_editor(str(text), document, editor) for name, text in files.items()}
                found |= files
        return found
