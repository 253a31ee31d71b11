"""Exercises as an exam of Numbas: a script of JME marks each part by its numbers at points on the motions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.emit import render
from symdyn.emit.code import page_stem
from symdyn.teach.document import Choice
from symdyn.teach.practice.exercises import ENOUGH
from symdyn.teach.practice.quiz import NEAR, Part, Variant
from symdyn.teach.render.quiz_text import Dialect, Html, Quiz, points_by

RESERVED = "e i j pi infinity infty nan nothing true false and or not xor nand nor implies in isa divides fact"
JME = Dialect({"log": "ln", "sign": "sgn"}, RESERVED, cased=False)


def numbas(quiz: Quiz) -> dict[str, str]:
    """Return the one file by name."""
    pages = [_Page(quiz, one) for one in quiz.variants]
    choices = [isinstance(quiz.parts(key)[0].asked, Choice) for key in quiz.keys]
    parts = [
        {"number": k, "marks": quiz.marks(key), "options": options, "script": render("quiz/marking.jme", {"number": k})}
        for k, (key, options) in enumerate(zip(quiz.keys, choices, strict=True))
    ]
    variables = [
        ("quiz_variant", f"random(0..{len(pages) - 1})" if len(pages) > 1 else "0"),
        ("quiz_data", _json([page.data for page in pages])),
        ("quiz_shown", render("quiz/shown.jme.jinja", {"row": _json([page.shown for page in pages])})),
    ]
    title = pages[0].variant.document.title.translate(_Html.instead)
    values = {"name": title, "words": quiz.words, "variables": variables, "parts": parts}
    return {f"{page_stem(quiz.scene.name)}-numbas.exam": render("quiz/numbas.exam.jinja", values)}


class _Html(Html):
    """HTML without braces in its text, in which Numbas evaluates what stands between."""

    instead = str.maketrans("{}", "()")


class _Page:
    """One variant in JME's words."""

    def __init__(self, quiz: Quiz, variant: Variant) -> None:
        self.quiz, self.variant, self.letters, self.html = quiz, variant, JME.letters(variant), _Html(variant)

    def points(self, points: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
        return points_by(self.letters, points, self.variant.scene)

    @property
    def data(self) -> dict[str, Any]:
        """Return points, words, and what is known of each part."""
        say = self.quiz.words
        groups = [{"on": self.points(on), "off": [*map(self.points, off), []]} for on, off in self.variant.groups]
        words = {
            "right": say["answer.right"], "numbers": say["answer.numbers"], "shifted": say["answer.shifted"],
            "wrong": say["answer.wrong"], "empty": say["fault.empty"], "unread": say["quiz.unread"],
        }  # fmt: skip
        parts = [self.part(self.variant.parts[key], len(groups)) for key in self.quiz.keys]
        return {"groups": groups, "words": words, "parts": parts}

    def part(self, part: Part, groups: int) -> dict[str, Any]:
        if isinstance(part.asked, Choice):
            every = part.asked.lettered
            return {
                "choices": [f"{letter}) {self.html.words(one.text)}" for letter, one in every.items()],
                "matrix": [1 if one.right else -1 for one in every.values()],
            }
        answer = JME.text(part.answer, self.letters)
        moves = self.variant.diagnosis.motions is not None and part.equation is not None
        beside = JME.text(part.front, self.letters) if moves else answer
        return {
            "answer": answer, "beside": beside, "equation": moves, "broken": part.equation if moves else -1,
            "near": [NEAR] * (groups - 1) + [ENOUGH if part.is_rounded else NEAR], "free": part.is_free,
            "marks": self.points(self.variant.marks(part)), "wrong": [[one.text, *one.marks] for one in part.wrong],
        }  # fmt: skip

    @property
    def shown(self) -> dict[str, Any]:
        parts = [self.variant.parts[key] for key in self.quiz.keys]
        asked = ["".join((before, f"<p>{left}</p>" if left else "")) for before, left in map(self.html.asked, parts)]
        return {
            "task": self.html.blocks(self.variant.task) + self.html.how(self.letters),
            "asked": asked,
            "solution": "\n".join(map(self.html.solved, parts)),
        }


def _json(rows: Sequence[object]) -> str:
    """Return the variant's row, as an expression of JME."""
    text = json.dumps(rows, ensure_ascii=False)
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'json_decode(safe("{quoted}"))[quiz_variant]'
