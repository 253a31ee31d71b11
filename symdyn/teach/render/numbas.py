"""Exercises as an exam of Numbas: a script of JME marks each part by its numbers at points on the motions."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from symdyn.algebra import Form
from symdyn.emit import render
from symdyn.emit.code import page_stem
from symdyn.teach.document import Blank, Choice
from symdyn.teach.practice.exercises import ENOUGH
from symdyn.teach.practice.quiz import Part, Quiz, Variant
from symdyn.teach.render.quiz_text import Dialect, Html
from symdyn.teach.student.motions import PLACES, SAME, Point

HEADER = "// Numbas version: exam_results_page_options\n"
"""What every file of Numbas begins with."""

JME = Dialect(
    {"log": "ln", "sign": "sgn"}, frozenset("e i j pi infinity infty nan nothing true false and or not xor in isa".split()), False
)  # fmt: skip


def numbas(quiz: Quiz) -> dict[str, str]:
    """Return the one file by name."""
    pages = [_Page(quiz, one) for one in quiz.variants]
    name, words = quiz.title, quiz.words
    question = {
        "name": name,
        "tags": [],
        "metadata": {"description": words["quiz.weaker.numbas"], "licence": "None specified"},
        "statement": f"<div>{{quiz_shown[\"task\"]}}</div>\n<p>{words['quiz.numbas']}</p>",
        "advice": "<div>{quiz_shown[\"solution\"]}</div>",
        "rulesets": {},
        "extensions": [],
        "builtin_constants": {"e": True, "pi,π": True, "i": True, "j": False},
        "constants": [],
        "variables": {
            **_variable("quiz_variant", f"random(0..{len(pages) - 1})" if len(pages) > 1 else "0", words),
            **_variable("quiz_data", _json([page.data for page in pages]), words),
            **_variable("quiz_shown", _shown([page.shown for page in pages]), words),
        },
        "variablesTest": {"condition": "", "maxRuns": 1},
        "ungrouped_variables": ["quiz_variant", "quiz_data", "quiz_shown"],
        "variable_groups": [],
        "functions": {},
        "preamble": {"js": "", "css": ""},
        "parts": [_part(quiz, pages, key, k) for k, key in enumerate(quiz.keys)],
        "partsMode": "all",
        "maxMarks": 0,
    }
    exam = {
        "name": name,
        "metadata": {"description": words["quiz.weaker.numbas"], "licence": "None specified"},
        "duration": 0,
        "percentPass": 0,
        "showQuestionGroupNames": False,
        "question_groups": [
            {"name": "", "pickingStrategy": "all-ordered", "pickQuestions": 1, "questions": [question]}
        ],
        "allowPrinting": True,
        "navigation": {"allowregen": True, "reverse": True, "browse": True, "showfrontpage": False},
        "timing": {"allowPause": True},
        "feedback": {"allowrevealanswer": True, "advicethreshold": 0},
        "contributors": [],
        "extensions": [],
        "custom_part_types": [],
        "resources": [],
    }
    text = json.dumps(exam, ensure_ascii=False, indent=1)
    return {f"{page_stem(quiz.scene.name)}-numbas.exam": f"{HEADER}{text}\n"}


class _Page:
    """One variant in JME's words."""

    def __init__(self, quiz: Quiz, variant: Variant) -> None:
        self.quiz, self.variant = quiz, variant
        self.letters, self.html = JME.letters(variant), Html(variant)
        motions = variant.diagnosis.motions
        self.groups = motions.groups if motions else ()

    def points(self, points: Sequence[Point]) -> list[dict[str, float]]:
        return [{self.letters[x]: float(f"{v:.12g}") for x, v in p.items() if x in self.letters} for p in points]

    @property
    def data(self) -> dict[str, Any]:
        """Return points, words, and what is known of each part; no right answer's text but where it stands beside it."""
        say, drawn = self.quiz.words, self.variant.diagnosis.points.at
        known = [(one.on, one.off) for one in self.groups] or [((*drawn[:PLACES], *drawn[PLACES : 2 * PLACES]), ())]
        groups = [{"on": self.points(on), "off": [*map(self.points, off), []]} for on, off in known]
        words = {
            "right": say["answer.right"], "numbers": say["answer.numbers"], "shifted": say["answer.shifted"],
            "wrong": say["answer.wrong"], "empty": say["fault.empty"], "unread": say["quiz.unread"],
        }  # fmt: skip
        parts = [self.part(self.variant.parts[key], len(groups)) for key in self.quiz.keys]
        return {"groups": groups, "words": words, "parts": parts}

    def part(self, part: Part, groups: int) -> dict[str, Any]:
        """Return what is known of one part."""
        if isinstance(part.asked, Choice):
            every = part.asked.lettered
            return {
                "choices": [f"{letter}) {self.html.words(one.text)}" for letter, one in every.items()],
                "matrix": [1 if one.right else -1 for one in every.values()],
                "reasons": [self.html.words(one.reason) for one in every.values()],
            }
        answer = JME.text(self.variant.answer(part.asked), self.letters)
        moves = bool(self.groups) and part.equation is not None
        beside = JME.text(part.front, self.letters) if moves and part.front is not None else answer
        return {
            "answer": answer,
            "beside": beside,
            "equation": moves,
            "broken": part.equation if moves else -1,
            "near": [SAME] * (groups - 1) + [ENOUGH if part.is_rounded else SAME],
            "free": part.is_free,
            "marks": self.points(self.variant.marks(part)),
            "wrong": [[one.text, *one.marks] for one in part.wrong],
        }

    @property
    def shown(self) -> dict[str, Any]:
        """Return what is shown, as HTML."""
        parts = [self.variant.parts[key] for key in self.quiz.keys]
        asked = ["".join((before, f"<p>{left}</p>" if left else "")) for before, left in map(self.html.asked, parts)]
        return {
            "task": self.html.blocks(self.variant.task) + self.html.how(self.letters),
            "asked": asked,
            "solution": "\n".join(map(self.html.solved, parts)),
        }


def _part(quiz: Quiz, pages: Sequence[_Page], key: str, k: int) -> dict[str, Any]:
    """Return one part of the question; what it asks is taken from the variant's data."""
    part = quiz.parts(key)[0]
    common = {
        "marks": part.marks,
        "showCorrectAnswer": True,
        "showFeedbackIcon": True,
        "scripts": {},
        "variableReplacements": [],
        "variableReplacementStrategy": "originalfirst",
        "adaptiveMarkingPenalty": 0,
        "exploreObjective": None,
        "steps": [],
        "prompt": f'<div>{{quiz_shown["asked"][{k}]}}</div>',
    }
    if isinstance(part.asked, Choice):
        return {
            **common,
            "type": "m_n_2",
            "customMarkingAlgorithm": "",
            "extendBaseMarkingAlgorithm": True,
            "minMarks": 0,
            "maxMarks": part.marks,
            "shuffleChoices": False,
            "displayType": "checkbox",
            "displayColumns": 1,
            "minAnswers": 0,
            "maxAnswers": 0,
            "warningType": "none",
            "showCellAnswerState": True,
            "markingMethod": "all-or-nothing",
            "choices": f'map(safe(x), x, quiz_data["parts"][{k}]["choices"])',
            "matrix": f'quiz_data["parts"][{k}]["matrix"]',
        }
    return {
        **common,
        "type": "jme",
        "customMarkingAlgorithm": render("quiz/marking.jme", {"number": k}),
        "extendBaseMarkingAlgorithm": True,
        "answer": f'{{expression(quiz_data["parts"][{k}]["answer"])}}',
        "answerSimplification": "basic",
        "showPreview": True,
        "checkingType": "absdiff",
        "checkingAccuracy": 0.001,
        "failureRate": 1,
        "vsetRangePoints": 5,
        "vsetRange": [0, 1],
        "checkVariableNames": False,
        "singleLetterVariables": False,
        "allowUnknownFunctions": True,
        "implicitFunctionComposition": False,
        "caseSensitive": True,
        "valuegenerators": [],
    }


def _variable(name: str, definition: str, words: Mapping[str, str]) -> dict[str, Any]:
    said = words["quiz.data"]
    row = {"name": name, "group": "Ungrouped variables", "definition": definition, "description": said,
           "templateType": "anything", "can_override": False}  # fmt: skip
    return {name: row}


def _json(rows: Sequence[object]) -> str:
    """Return the variant's row, as an expression of JME."""
    text = json.dumps(rows, ensure_ascii=False)
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'json_decode(safe("{quoted}"))[quiz_variant]'


def _shown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the variant's texts as elements of HTML."""
    return (
        f"let(quiz_row, {_json(rows)}, "
        '["task": html(safe(quiz_row["task"])), "solution": html(safe(quiz_row["solution"])), '
        '"asked": map(html(safe(x)), x, quiz_row["asked"])])'
    )
