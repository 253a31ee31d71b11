"""Whole lessons, each derived once for all tests of a process; what a test changes it derives by itself."""

from __future__ import annotations

from functools import lru_cache

from symdyn.algebra.numeric import Floats
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import Scene
from symdyn.teach import walkthrough
from symdyn.teach.document import Blank, Document, Step
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


def blanks(document: Document) -> list[Blank]:
    return [block for _, block in document.blocks() if isinstance(block, Blank)]


def value_of_symbol(name: str) -> float:
    """Return a value that depends on the name alone."""
    return 0.3 + sum(ord(letter) * (k + 3) for k, letter in enumerate(name)) % 89 / 60


def floats(nodes: list[Expr]) -> list[float]:
    values = {x: value_of_symbol(str(x.value)) for x in reachable(nodes) if x.op is Op.SYMBOL}
    return evaluate(nodes, Floats(), values)
