"""Whole lessons, each derived once for all tests of a process; what a test changes it derives by itself."""

from __future__ import annotations

from functools import lru_cache

from symdyn.scene import Scene
from symdyn.teach import walkthrough
from symdyn.teach.document import Document, Step
from symdyn.teach.render.handout import usual_formulation


def lesson_of(scene: Scene, language: str = "en", formulation: str = "") -> Document:
    """Return `walkthrough` of the same, every step open."""
    return _lesson_of(scene, language, formulation or usual_formulation(scene))


@lru_cache(maxsize=64)
def _lesson_of(scene: Scene, language: str, formulation: str) -> Document:
    return walkthrough(scene, language, "full", formulation=formulation)


def step_of(document: Document, key: str) -> Step:
    return next(step for section in document.sections for step in section.steps if step.key == key)


def keys_of(document: Document) -> set[str]:
    """Return the keys of all steps."""
    return {step.key for section in document.sections for step in section.steps}
