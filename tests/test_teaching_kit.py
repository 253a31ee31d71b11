"""The kit for a field trial: symdyn judges its keys, its forms are parallel, and no page keeps a log by itself."""

from __future__ import annotations

import json
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from browser import opened

import symdyn
from symdyn.resources import folder
from symdyn.scene import Scene, read
from symdyn.teach import Handout, check_derivation
from symdyn.teach.document import Document
from symdyn.teach.languages import language_of
from symdyn.teach.practice.exercises import judge
from symdyn.teach.render.html import html_page

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


OF_LESSONS = ("b1.4", "a2.4", "b2.4")
"""Items whose lessons are derived in `make slow`; one is in every test."""


@pytest.mark.parametrize(
    ("form", "number"),
    [pytest.param(*one.values, id=one.id, marks=[pytest.mark.slow] * (one.id in OF_LESSONS)) for one in ITEMS],
)
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
        assert {rule: rule_of(wrong, of) for rule, wrong in item["wrong"].items()} == {
            rule: rule for rule in item["wrong"]
        }
        assert item["wrong"]


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", sorted(path.stem for path in KIT.glob("[ab]?.toml")))
def test_the_equations_of_every_mechanism_are_derived_twice(name: str) -> None:
    assert symdyn.certify(scene(name)).passed


@pytest.mark.parametrize("name", ["a1", pytest.param("a2", marks=pytest.mark.slow)])
def test_pictures_are_those_of_the_scenes(name: str) -> None:
    for form in FORMS:
        own = f"{form}{name[1]}"
        drawn = symdyn.picture(scene(own), labels=("coordinates",), scheme="light")
        assert drawn.strip() == (KIT / f"{own}.svg").read_text(encoding="utf-8").strip()


def form_of(form: str, language: str) -> str:
    return (KIT / f"form-{form}{'' if language == 'en' else f'-{language}'}.md").read_text(encoding="utf-8")


PHRASES = {
    "en": {
        "slope": "the derivative of $K$ by the coordinate has the wrong sign",
        "squared": "the square of a rate stands where an acceleration belongs",
        "velocities": "a term with a product of two rates is missing",
        "weightless": "the weight is missing",
    },
    "sk": {
        "slope": "derivácia $K$ podľa súradnice má opačné znamienko",
        "squared": "druhá mocnina rýchlosti stojí namiesto zrýchlenia",
        "velocities": "chýba člen so súčinom dvoch rýchlostí",
        "weightless": "chýba tiaž",
    },
}
"""What students read for a rule."""


@pytest.mark.parametrize("language", PHRASES)
def test_forms_are_parallel_and_ask_what_the_keys_answer(language: str) -> None:
    asked = {form: re.findall(r"(?m)^\*\*(\d\.\d)\*\* (.*)$", form_of(form, language)) for form in FORMS}

    assert [number for number, _ in asked["a"]] == [number for number, _ in asked["b"]] == list(KEYS["a"])
    assert list(KEYS["a"]) == list(KEYS["b"])
    for form in FORMS:
        for number, text in asked[form]:
            item = KEYS[form][number]
            assert f"({item['scene']}.svg)" in form_of(form, language)
            if "faulty" in item:
                formula = re.search(r"\$([^$]+=[^$]+)\$", text)
                assert formula
                assert rule_of(formula[1], scene(item["scene"])) == item["rules"]["abcd".index(item["answer"])]
                options = [
                    f"{letter}) {PHRASES[language][rule]}" for letter, rule in zip("abcd", item["rules"], strict=True)
                ]
                assert text.endswith("; ".join(options) + ".")
            else:
                assert text == dict(asked["a"])[number]  # in the same words
    assert KEYS["a"]["3.1"]["answer"] != KEYS["b"]["3.1"]["answer"]


# The log of a page


@cache
def page_with_exercises(language: str = "en") -> str:
    own = Handout(symdyn.example("pendulum"), language=language, exercises=True).quiz()
    return html_page(own.variants[0].document)


KEYS_OF_EVENTS = {
    "answer": {"event", "question", "typed", "right", "causes", "told", "time"},
    "solution": {"event", "question", "time"},
}


def test_a_log_is_off_until_a_student_agrees_and_is_never_sent() -> None:
    page = page_with_exercises()
    scripts = "".join(re.findall(r"(?s)<script>(.*?)</script>", page))
    (box,) = re.findall(r'(?s)<details class="log".*?</details>', page)

    assert re.search(r'<label><input type="checkbox" autocomplete="off"> I agree', box)
    assert box.count("disabled") == 3  # the field and both buttons, until then
    assert "agree.checked = false;" in scripts
    assert not re.search(
        r"\bfetch\(|XMLHttpRequest|sendBeacon|WebSocket|EventSource|indexedDB|document\.cookie", scripts
    )
    own = (folder("templates") / "teach" / "log.js").read_text("utf-8")
    assert scripts.count("localStorage") == own.count("localStorage") == 3
    assert "localStorage" not in html_page(Handout(symdyn.example("pendulum")).document())


def test_the_log_is_told_as_it_is_written_and_read() -> None:
    """By the page's script, the table of its format, and the notebook."""
    script = (folder("templates") / "teach" / "practice.js").read_text(encoding="utf-8")
    calls = re.findall(r"Log\.add\(\{(.*?)\}\)", script)
    written = [{*re.findall(r"(?:^|, )(\w+)", one), "time"} for one in calls]
    told = (KIT / "README.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"(?s)```json\n(.*?)```", told)
    book = "".join("".join(cell["source"]) for cell in json.loads((KIT / "analysis.ipynb").read_text("utf-8"))["cells"])
    (read_as,) = re.findall(r"(?s)KEYS = (\{.*?\n?\})\n", book)

    assert {one["event"]: set(one) for one in json.loads(shown)["events"]} == KEYS_OF_EVENTS
    assert eval(read_as) == KEYS_OF_EVENTS
    assert written == [*KEYS_OF_EVENTS.values()]
    assert "symdyn log 1" in (folder("templates") / "teach" / "log.js").read_text(encoding="utf-8")


def test_nobody_says_that_a_trial_was_made() -> None:
    cells = json.loads((KIT / "analysis.ipynb").read_text("utf-8"))["cells"]

    assert cells[0]["source"][0].startswith("# Simulated data")
    assert "**No such trial has been made.**" in (KIT / "README.md").read_text(encoding="utf-8")


COUNTED = """() => {
  window.touched = 0;
  for (const name of ["getItem", "setItem", "removeItem"]) {
    const own = Storage.prototype[name];
    Storage.prototype[name] = function (...given) { window.touched += 1; return own.apply(this, given); };
  }
}"""
OPEN = """() => {
  for (const one of document.querySelectorAll("details:not(.solution)")) one.open = true;
}"""
BROKEN = """() => { Storage.prototype.setItem = () => { throw new DOMException("full", "QuotaExceededError"); }; }"""


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_a_page_logs_what_is_answered_once_its_reader_agrees(tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "lesson.html"
    path.write_text(page_with_exercises(), encoding="utf-8")
    with opened(browser, path) as page:

        def answers(text: str) -> None:
            form = page.locator("form.blank[data-key='square:1']")
            form.locator("input[name=answer]").fill(text)
            form.locator("button").click()

        page.evaluate(COUNTED)
        page.evaluate(OPEN)
        answers("l^2*q1'")
        assert page.evaluate("touched") == 0
        assert page.get_by_role("button", name="Save my log").is_disabled()

        box = page.get_by_role("checkbox", name="I agree")
        box.check()
        page.get_by_label("Code from your test sheet").fill("K 07")
        answers("l^2*q1'")
        answers("l^2*q1'^2")
        page.locator("form.blank[data-key='potential:1'] .solution summary").click()
        page.wait_for_function("JSON.parse(localStorage.getItem('symdyn.log.pendulum')).events.length === 3")
        with page.expect_download() as saved:
            page.get_by_role("button", name="Save my log").click()
        assert saved.value.suggested_filename == "log-K07-pendulum.json"
        log = json.loads(Path(saved.value.path()).read_text(encoding="utf-8"))
        assert {key: log[key] for key in ("format", "lesson", "language", "code")} == {
            "format": "symdyn log 1",
            "lesson": "pendulum",
            "language": "en",
            "code": "K 07",
        }
        assert [set(one) for one in log["events"]] == [KEYS_OF_EVENTS[one] for one in ("answer", "answer", "solution")]
        assert [(one.get("typed"), one.get("right")) for one in log["events"]] == [
            ("l^2*q1'", False),
            ("l^2*q1'^2", True),
            (None, None),
        ]
        assert log["events"][0]["told"].startswith("Not yet")
        assert log["events"][1]["causes"] == []

        box.uncheck()
        answers("l")
        assert page.evaluate("JSON.parse(localStorage.getItem('symdyn.log.pendulum')).events.length") == 3
        page.reload()
        page.evaluate(COUNTED)
        page.evaluate(OPEN)
        assert not box.is_checked()
        assert page.evaluate("touched") == 0
        box.check()
        assert page.get_by_label("Code from your test sheet").input_value() == "K 07"
        page.get_by_role("button", name="Delete my log").click()
        assert page.evaluate("localStorage.length") == 0
        assert not box.is_checked()

        page.evaluate(BROKEN)
        box.check()
        assert page.get_by_text("lets the page keep nothing").is_visible()
        answers("l")
        with page.expect_download() as saved:
            page.get_by_role("button", name="Save my log").click()
        assert len(json.loads(Path(saved.value.path()).read_text(encoding="utf-8"))["events"]) == 1


@pytest.mark.slow
@pytest.mark.runs("chromium")
def test_what_stands_in_the_storage_already_is_no_code(tmp_path: Path, browser: Any) -> None:
    path = tmp_path / "lesson.html"
    path.write_text(page_with_exercises("sk"), encoding="utf-8")
    for kept in (
        "{",
        "null",
        '{"format":"symdyn log 1","code":1,"events":[]}',
        '{"format":"symdyn log 1","code":""><b>","events":{}}',
    ):
        with opened(browser, path) as page:
            page.evaluate("kept => localStorage.setItem('symdyn.log.pendulum', kept)", kept)
            page.locator(".log summary").click()
            page.get_by_role("checkbox", name="Súhlasím").check()
            assert page.evaluate("JSON.parse(localStorage.getItem('symdyn.log.pendulum')).events") == []
            page.get_by_role("button", name="Vymazať môj záznam").click()
