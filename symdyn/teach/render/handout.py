"""A lesson as it is handed out: of a scene or a variant of it, whole or with exercises, or as a sheet of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import ClassVar

from symdyn.scene import Scene
from symdyn.teach.derivations.lessons import walkthrough
from symdyn.teach.document import Document
from symdyn.teach.interactive.page import interactive_page
from symdyn.teach.practice.exercises import GRADES, with_exercises
from symdyn.teach.practice.questions import sheet
from symdyn.teach.practice.variants import Variant, variant, with_changes
from symdyn.teach.render import rendered
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class Handout:
    """A lesson as it is handed out.

    Attributes:
        scene: any that `walkthrough` takes.
        language, detail, until, formulation: as of `walkthrough`.
        seed: of a variant of the scene: other masses, lengths, axes, springs, another way down; None for the scene.
        exercises: leave results out, with hints and solutions; the HTML page checks answers.
        grade, ask: which, as of `with_exercises`.
        grades: those that there are.
        sheet: the exercises to print, "questions" with room to write, or "solutions"; "" for the whole lesson.
    """

    grades: ClassVar[tuple[int, ...]] = tuple(GRADES)

    scene: Scene
    language: str = "en"
    detail: str = "full"
    until: str = ""
    formulation: str = ""
    seed: int | None = None
    exercises: bool = False
    grade: int = 2
    ask: tuple[str, ...] = ()
    sheet: str = ""

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

    def files(self, formats: Iterable[str], progress: Callable[[str], None]) -> dict[str, str | bytes]:
        """Return the files of the lesson in formats, by name; errors as of `document` and `rendered`."""
        document = self.document()
        progress("writing")
        return {name: text for one in formats for name, text in rendered(document, one).items()}
