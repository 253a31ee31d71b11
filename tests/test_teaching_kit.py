"""The kit for a field trial: its answer keys are judged by symdyn, its forms are parallel, and no page keeps a log by itself."""

from __future__ import annotations

import json
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import symdyn
from symdyn.scene import Scene, read
from symdyn.teach import Handout, check_derivation
from symdyn.teach.document import Document
from symdyn.teach.languages import language_of
from symdyn.teach.practice.exercises import judge

ROOT = Path(__file__).parent.parent
KIT = ROOT / "docs" / "teaching"
FORMS = ("a", "b")
KEYS: dict[str, dict[str, dict[str, Any]]] = tomllib.loads((KIT / "keys.toml").read_text(encoding="utf-8"))
ITEMS = [pytest.param(form, number, id=f"{form}{number}") for form in FORMS for number in KEYS[form]]


@cache
def scene(name: str) -> Scene:
    return read(KIT / f"{name}.toml")


@cache
def lesson(name: str) -> Document:
    return Handout(scene(name), exercises=True).quiz().variants[0].document


def rule_of(formula: str, of: Scene) -> str:
    """Return the rule that check-derivation says a formula forgets, "" where it is right."""
    (told,) = check_derivation(formula, of)
    assert told.right == (told.mistake is None)
    return told.mistake.rule if told.mistake else ""


@pytest.mark.parametrize(("form", "number"), ITEMS)
def test_symdyn_judges_every_answer_key(form: str, number: str) -> None:
    item = KEYS[form][number]
    of, answer = scene(item["scene"]), item["answer"]
    if "faulty" in item:
        assert item["rules"]["abcd".index(answer)] == rule_of(item["faulty"], of)
        assert len(set(item["rules"])) == 4
    elif "question" in item:
        right = language_of("en").lesson["answer.right"]
        assert judge(lesson(item["scene"]), item["question"], answer) == right
        assert all(judge(lesson(item["scene"]), item["question"], one) != right for one in item["wrong"])
        assert item["wrong"]
    else:
        assert rule_of(answer, of) == ""
        assert {rule: rule_of(wrong, of) for rule, wrong in item["wrong"].items()} == {rule: rule for rule in item["wrong"]}
        assert item["wrong"]
