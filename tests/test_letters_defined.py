"""A letter on a page of a lesson is defined on that page, by every formulation, and with results left out, too."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lessons import lesson_of
from page_letters import Letter, letters, page_of

from symdyn.errors import SymdynError
from symdyn.scene import Scene, read
from symdyn.teach import Document, rendered
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.html import html_page

ROOT = Path(__file__).parent
EXAMPLES = ROOT.parent / "examples"
FORMULATIONS = ("lagrange", "multipliers", "quaternions", "dalembert")
FOUND = ROOT / "data" / "found"
SEEN = ("cart_pole", "cart_with_wheel", "two_link", "four_bar")
SOME = [*(pytest.param(name, marks=pytest.mark.mends("30.class.letters")) for name in SEEN), "heavy_top"]
OTHERS = sorted({path.stem for path in EXAMPLES.glob("*.toml")} - {*SEEN, "heavy_top"})


@cache
def scene(name: str) -> Scene:
    return read(EXAMPLES / f"{name}.toml")


@cache
def lessons(name: str) -> dict[str, Document]:
    found = {}
    for formulation in FORMULATIONS:
        try:
            found[formulation] = lesson_of(scene(name), formulation=formulation)
        except SymdynError:  # not a formulation of this scene
            continue
    return found


def markdown(document: Document) -> str:
    return str(next(iter(rendered(document, "md").values())))


def undefined(name: str) -> dict[str, list[str]]:
    """Return the letters that pages of a scene leave undefined; an exercise may use what its lesson defines."""
    found: dict[str, list[str]] = {}
    for formulation, lesson in lessons(name).items():
        whole = page_of(markdown(lesson))
        found[formulation] = [f"{one} in: {line}" for one, line in whole.strange().items()]
        try:
            asked = page_of(markdown(with_exercises(lesson, 1)))
        except SymdynError:  # nothing is asked for
            continue
        found[f"{formulation}, exercises"] = [f"{one} in: {line}" for one, line in asked.strange(whole).items()]
    return {page: lines for page, lines in found.items() if lines}


@pytest.mark.wide("cart_pole", "heavy_top")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", SOME)
def test_every_letter_of_a_lesson_is_defined_in_it(name: str) -> None:
    assert undefined(name) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_every_letter_of_every_lesson_is_defined_in_it(name: str) -> None:
    assert undefined(name) == {}


EMPTY = re.compile(r"[:,] ?\.(?: |$)", re.MULTILINE)


@pytest.mark.long(0)
@pytest.mark.parametrize("name", [*SEEN, "heavy_top", *(pytest.param(name, marks=pytest.mark.slow) for name in OTHERS)])
def test_no_sentence_of_a_lesson_tells_of_an_empty_list(name: str) -> None:
    assert {
        formulation: found for formulation, one in lessons(name).items() if (found := EMPTY.findall(markdown(one)))
    } == {}


@pytest.mark.mends("30.lessons.1.0")
def test_where_nothing_is_driven_no_drives_are_compared() -> None:
    """And no formulation agrees with another; what is proved of the reactions stays."""
    page = markdown(lesson_of(read(FOUND / "wheel_with_pendulum.toml"), formulation="dalembert"))

    assert not EMPTY.search(page)
    assert "Lagrange's formulation gives the same drives" not in page
    assert "All reactions together have the power of the drives" in page


# What the tool sees


def test_what_defines_a_letter() -> None:
    said = r"""
| symbol | meaning |
| --- | --- |
| $m_1$ | mass |

**The force is $F$, and $Q_i$ is any.**

$$
k = \underbrace{(m_1 + m_2)}_{k_{z,11}}\, \ddot x + S_1 + Q_2 + \dot H_{1,z} + v_x
$$
"""
    assert set(map(str, page_of(said).strange())) == {"m_2", "x", "S_1", "H_1,z", "v_x"}


@pytest.mark.parametrize(
    ("math", "found"),
    [
        (r"\tilde r_{0j}\,\bar P_{0j}", [Letter("r", "tilde", "0j"), Letter("P", "bar", "0j")]),
        (r"F_{1,\mathrm{axle}}^{*R} \cos^2 \phi_1", [Letter("F", "", "1,axle", "*R"), Letter("phi", "", "1")]),
        (r"\frac{\mathrm{d}}{\mathrm{d}t} \dot{\theta}", [Letter("t"), Letter("theta")]),
        (r"P_{0j}^{T} x^2 \tag{5.4}", [Letter("P", "", "0j"), Letter("x")]),
        (r"\mathbf{A} \mathbf{x}", [Letter("boldA"), Letter("boldx")]),
    ],
)
def test_what_a_letter_is(math: str, found: list[Letter]) -> None:
    assert list(letters(math)) == found


# The question that had two right answers

RIGHT = "(mc + mp) x'' - mp l/2 cos(theta) theta'' + mp l/2 sin(theta) theta'^2"


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("asked") / "exercise.html"
    path.write_text(html_page(with_exercises(lessons("cart_pole")["lagrange"], 3)), encoding="utf-8")
    return path


@pytest.mark.long(0)
@pytest.mark.mends("30.lessons.1.3")
def test_an_answer_is_what_stands_behind_the_box_or_the_drive_alone(browser: Any, asked: Path) -> None:
    """In front of the box stands F - b x'; what is F alone is read so, and what says that it is F has to be it."""
    answers = {
        RIGHT: True,
        f"{RIGHT} + b x'": True,
        f"F = {RIGHT} + b x'": True,
        f"F = {RIGHT}": False,
        f"F - b x' = {RIGHT}": True,
        f"F - b x' - ({RIGHT}) = 0": True,
    }
    page = browser.new_page()
    page.goto(asked.as_uri())
    told = page.evaluate("texts => texts.map(x => Answers.judge('equation:1', x).right)", list(answers))
    page.close()

    assert dict(zip(answers, told, strict=True)) == answers


@pytest.mark.mends("30.lessons.1.3")
def test_what_stands_before_a_box_is_what_is_asked_for(asked: Path) -> None:
    """Of an equation its known side, no letter of our own."""
    page = asked.read_text(encoding="utf-8")
    for form in re.findall(r'<form class="blank".*?</form>', page, re.DOTALL):
        asks, entry = (re.search(rf'<p class="{one}">(.*?)</p>', form, re.DOTALL) for one in ("ask", "entry"))
        assert asks is not None
        assert entry is not None
        before = re.findall(r"<math.*?</math>", entry[1], re.DOTALL)[:1]
        question = re.findall(r"<math.*?</math>", asks[1], re.DOTALL)[:1]
        assert question in ([], before)
        if not question:
            assert re.sub(r"<[^>]*>", "", before[0]) == "0"


@pytest.mark.long(0)
@pytest.mark.mends("30.lessons.1.3")
def test_no_letter_stands_for_a_drive_with_what_else_acts() -> None:
    assert not any(one.sign == "S" for one in page_of(markdown(lessons("cart_pole")["lagrange"])).used)
