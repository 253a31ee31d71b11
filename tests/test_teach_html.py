"""The HTML page of a lesson in a real browser: quiet, alone, without overlaps, with exercises that judge by value."""

from __future__ import annotations

import random
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from browser import OVERLAPS, opened
from lessons import blanks, lesson_of

from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.emit.print.breaking import BREAK
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import TeachError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import read, read_text
from symdyn.teach import walkthrough
from symdyn.teach.document import Document
from symdyn.teach.languages import language_of, languages
from symdyn.teach.mathematics import Spelling, flow, inner
from symdyn.teach.practice.exercises import judge, with_exercises
from symdyn.teach.practice.questions import questions
from symdyn.teach.render.html import html_page
from symdyn.teach.student.statements import read_formula

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(scope="module")
def lesson() -> Document:
    return with_exercises(lesson_of(read(EXAMPLES / "two_link.toml")))


@pytest.fixture(scope="module")
def shown(lesson: Document, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the page of the lesson."""
    path = tmp_path_factory.mktemp("shown") / "lesson.html"
    path.write_text(html_page(lesson), encoding="utf-8")
    return path


# The text of the page


class _Balanced(HTMLParser):
    """Notes elements that are opened and not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in ("meta", "input", "br", "wbr"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.wide("cart_pole")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
@pytest.mark.parametrize("language", ["en", "sk"])
def test_a_page_is_small_closed_and_alone(name: str, language: str) -> None:
    page = html_page(with_exercises(lesson_of(read(EXAMPLES / f"{name}.toml"), language)))

    parser = _Balanced()
    parser.feed(page)
    assert parser.open == []
    assert len(page.encode()) < 1_500_000
    assert page.count("<style") == 1  # all pictures of a page have one style sheet
    assert not re.search(r'(?:src|href)="(?!#)', page)
    assert not re.search(r"url\(|@import|fetch\(|XMLHttp", page)
    assert len(ids := re.findall(r' id="([^"]*)"', page)) == len(set(ids))
    assert set(re.findall(r'href="#([^"]*)"', page)) <= set(ids)
    assert f'<html lang="{language}">' in page


@pytest.mark.slow
@pytest.mark.long
def test_the_longest_page_is_small_too() -> None:
    lesson = with_exercises(lesson_of(read(EXAMPLES / "spatial_3r.toml")))

    assert len(html_page(lesson).encode()) < 1_500_000


@pytest.mark.long(0)
def test_every_formula_becomes_wellformed_mathml(shown: Path) -> None:
    page = shown.read_text(encoding="utf-8")

    found = re.findall(r"<math.*?</math>", page, re.DOTALL)

    assert len(found) > 200
    for text in found:
        assert "\\" not in "".join(ElementTree.fromstring(text).itertext())


def test_mathml_has_the_spaces_of_the_formula() -> None:
    assert inner(r"h_1 \sin q_1") == (
        "<msub><mi>h</mi><mn>1</mn></msub><mi>\u2009sin\u2009</mi><msub><mi>q</mi><mn>1</mn></msub>"
    )
    assert inner(r"\sin(q)") == '<mi>sin</mi><mo stretchy="false">(</mo><mi>q</mi><mo stretchy="false">)</mo>'
    assert inner(r"\sin^2 q") == "<msup><mi>sin</mi><mn>2\u2005</mn></msup><mi>q</mi>"
    assert 'mover accent="true"' in inner(r"\dot q_1")


def test_a_formula_may_part_at_its_terms_and_in_long_brackets_only() -> None:
    short = flow("x", f"= a {BREAK}- (b {BREAK}+ c) d")
    assert short.count("<wbr>") == 2
    assert short.endswith("− <math>" + inner("(b + c) d") + "</math>")
    long = flow("", f"a {BREAK}+ \\bigl({'b c ' * 20}{BREAK}- {'d e ' * 20}\\bigr) f")
    assert long.count("<wbr>") == 2
    assert re.search(r'<wbr><span class="term">\+ <math>.*</math> <wbr>− <math>.*</math></span>$', long)


@pytest.mark.long
def test_the_page_is_the_same_in_every_run(cart: Path) -> None:
    again = html_page(with_exercises(walkthrough(read(EXAMPLES / "cart_pole.toml"), detail="full")))

    assert again == cart.read_text(encoding="utf-8")


def test_languages_have_the_same_keys_and_places() -> None:
    places = {
        name: {key: sorted(re.findall(r"\{\w+\}", text)) for key, text in texts.items()}
        for name in languages()
        for texts in [language_of(name).lesson]
    }

    assert places["sk"] == places["en"]


# Exercises as a document


def test_answers_of_blanks_are_what_the_graph_says(lesson: Document) -> None:
    from symdyn.verdict import Verdict
    from symdyn.verify import Claim, prove

    claims = []
    for blank in blanks(lesson):
        node = lesson.names[blank.left].node
        assert node is not None
        claims.append(Claim(blank.key, "answer", "graph", (lesson.value(blank.answer),), (node,)))

    assert {finding.verdict for finding in prove(claims)[1]} == {Verdict.PROVED}


@pytest.mark.long(0)
def test_the_page_does_not_hold_the_results(lesson: Document) -> None:
    asked = questions(lesson)

    assert set(asked["values"]) == {blank.key for blank in blanks(lesson)}
    assert "cos" not in str(asked["values"])


@pytest.mark.long
def test_exercises_of_the_other_formulation_ask_for_moments_of_inertia_and_drives() -> None:
    closed = with_exercises(lesson_of(read(EXAMPLES / "four_bar.toml"), formulation="dalembert"))
    assert [b.left for b in blanks(closed)] == ["MD:11:z", "MD:22:z", "MD:33:z"]
    assert "<math" in html_page(closed)

    arm = with_exercises(lesson_of(read(EXAMPLES / "two_link.toml"), formulation="dalembert"))
    assert [b.left for b in blanks(arm)] == ["MD:11:z", "MD:22:z", "M1", "M2"]
    assert judge(arm, "bivectors:link1", "-m_1 h_1^2 \\ddot q_1") == "Right."
    assert judge(arm, "bivectors:link1", "m_1 h_1^2 \\ddot q_1").endswith("the opposite sign.")


def test_a_walkthrough_without_such_results_says_so() -> None:
    lesson = walkthrough(read(EXAMPLES / "four_bar.toml"), formulation="dalembert", until="count")

    with pytest.raises(TeachError, match="give a later part with until"):
        with_exercises(lesson)


# The browser


@pytest.mark.wide("light-1280", "dark-390")
@pytest.mark.runs
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_page_is_quiet_and_nothing_overlaps(browser: Any, shown: Path, width: int, scheme: str) -> None:

    with opened(browser, shown, width, scheme) as page:
        assert page.evaluate(OVERLAPS) == []
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == (
            "rgb(255, 255, 255)" if scheme == "light" else "rgb(18, 23, 29)"
        )
        page.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
        assert page.evaluate(OVERLAPS) == []


def test_every_right_answer_is_accepted_and_every_changed_one_refused(
    lesson: Document, browser: Any, shown: Path
) -> None:
    spell = Spelling(lesson)

    with opened(browser, shown) as page:
        for blank in blanks(lesson):
            plain, spelled = text_of(blank.answer), spell.inline(blank.answer)
            judge = "([key, text]) => Answers.judge(key, text)"
            for right in (plain, spelled):
                assert page.evaluate(judge, [blank.key, right])["right"], right
            for wrong in (f"{plain} + m1 sin(q1)", f"-({spelled})", f"2 ({spelled})", f"({plain}) * 1.000001"):
                assert not page.evaluate(judge, [blank.key, wrong])["right"], wrong


def test_answers_of_a_body_in_quaternions_are_judged_by_their_values(tmp_path: Path, browser: Any) -> None:
    lesson = with_exercises(lesson_of(read(EXAMPLES / "heavy_top.toml")))
    path = tmp_path / "heavy_top.html"
    path.write_text(html_page(lesson), encoding="utf-8")

    with opened(browser, path) as page:
        for blank in blanks(lesson):
            judged = [
                page.evaluate("([key, text]) => Answers.judge(key, text)", [blank.key, text])["right"]
                for text in (text_of(blank.answer), f"2 ({text_of(blank.answer)})")
            ]
            assert judged == [True, False], blank.key


RULES, ENGLISH = language_of("en").mistakes, language_of("en").lesson


READ = {
    "": "Nothing is written here.",
    "m2*h2**2 + m2*h1*h2*cos(q2)": "Right.",
    "m2 h2^2 + m3": "m3 is no symbol here.",
    "k_z12 = m2 h2 (h2 + h1 c2)": "Right.",
    "m2 (h2": "This bracket is not closed.",
    r"m_{2}h_{2}\left[h_2+h_1\cos{q_2}\right]": "Right.",
    "m2 h2^": "Something is missing at the end.",
    "m₂·h₂² + m₂h₁h₂cos(q₂)": "Right.",
    "m2^h2": "An exponent is an integer up to 32, or 1/2; more than one digit in braces.",
    r"\frac12 (2 m_2 h_2^2 + 2 m_2 h_1 h_2 \cos q_2)": "Right.",
    "m1'": "m1 carries no dots; only coordinates do.",
    "m2 h2^2 + m2 h1 h2 (cos(q1) cos(q1+q2) + sin q1 sin(q1 + q2))": "Right.",
    "1/0": "This has no value: it divides by zero, or takes the root of a negative number.",
    "m2 h2^2 + m2 h1 h2 c q_2": "Right.",
    "alert(1)": "alert is no symbol here.",
    "m2 h2^2 / h1 h1 + m2 h1 h2 cos(q2)": "Right.",
    "constructor": "constructor is no symbol here.",
    "__proto__": "_ does not fit here.",
    "m2[0]('x')": "' has no place in a formula.",
    "(" * 4000: "This is too long or nests too deep.",
}
"""What is typed, and what the page says of it, however often one has tried; no two in turn are alike."""


@pytest.mark.long
def test_what_is_typed_is_right_or_told_why_it_is_not_read(browser: Any, shown: Path) -> None:
    with opened(browser, shown) as page:
        form = page.locator('form[data-key="coefficients:k_z:k_z:1,2"]')
        for text, says in READ.items():
            form.locator("input").fill(text)
            form.locator("input").press("Enter")

            assert form.locator(".verdict").inner_text() == says, text


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("m2 h2^2 - m2 h1 h2 cos q2", f"Not yet: {RULES['cross']} (mass 2); and {RULES['termsign']}."),
        ("-m2 h2^2 - m2 h1 h2 cos q2", "Not yet: all of it has the opposite sign."),
        ("0.5 m2 h2 (h2 + h1 cos q2)", f"Not yet: {RULES['factor']}."),
        ("0.7 m2 h2 (h2 + h1 cos q2)", "Not yet: yours is 0.7 times the result."),
        ("0", f"Not yet: {RULES['coupling']}."),
    ],
)
def test_a_typed_answer_is_judged(text: str, says: str, browser: Any, shown: Path) -> None:

    with opened(browser, shown) as page:
        form = page.locator('form[data-key="coefficients:k_z:k_z:1,2"]')
        form.locator("input").fill(text)
        form.locator("input").press("Enter")

        assert form.locator(".verdict").inner_text() == says


def test_what_is_typed_is_shown_and_hints_say_more_with_every_try(browser: Any, shown: Path) -> None:
    with opened(browser, shown) as page:
        form = page.locator('form[data-key="coefficients:k_z:k_z:1,2"]')
        box, verdict = form.locator("input"), form.locator(".verdict")
        box.fill("m2 h2^2 + m2 h1 h2 cos(q2")
        assert form.locator(".echo math").text_content() == ""  # a bracket is open
        box.fill("m2 h2^2 + 3 m2 h1 h2 cos(q2)")
        assert "cos" in form.locator(".echo math").text_content()

        tries = []
        for _ in range(3):
            box.press("Enter")
            tries.append((verdict.inner_text(), verdict.locator("math").count()))

        kind = ENGLISH["answer.kind.look"].partition("{text}")[0]
        assert [kind in text for text, _ in tries] == [False, True, True]
        assert [count > 0 for _, count in tries] == [False, False, True]
        assert page.locator(".progress output").inner_text().startswith("0 of ")
        box.fill("m2 h2^2 + m2 h1 h2 cos(q2)")
        box.press("Enter")
        page.wait_for_function("document.querySelector('.progress output').textContent.startsWith('1 of ')")
        page.locator(".progress button").click()
        assert page.evaluate("document.activeElement.closest('form') !== null")


GARBAGE = "m1h2q_^{}()[]\\+-*/=.,;:'\"<>&|!?@#$%~`0123456789 \t\n\0\u0307\u202e\ud83d\ude00αθ½²₁∫∞−·\u200b"


def test_garbage_is_answered_in_words(lesson: Document, browser: Any, shown: Path) -> None:
    rng = random.Random(3)
    texts = ["".join(rng.choices(GARBAGE, k=rng.randint(0, 30))) for _ in range(3000)]
    texts += [
        "m1" * 3000,
        "((((" * 500,
        "1e999",
        "m1^" * 50 + "2",
        "--" * 999 + "1",
        "\\frac" * 99,
        "{" * 99,
        "constructor.x",
    ]
    with opened(browser, shown) as page:
        told = page.evaluate("([key, texts]) => texts.map(x => Answers.judge(key, x))", [blanks(lesson)[0].key, texts])

    assert all(isinstance(one["text"], str) and one["text"] for one in told)
    assert not any(one["right"] for one in told)


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the page of a scene that gives some letters their numbers."""
    path = tmp_path_factory.mktemp("cart") / "lesson.html"
    path.write_text(html_page(with_exercises(lesson_of(read(EXAMPLES / "cart_pole.toml")))), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("mc + mp", "Right."),
        ("1 + 0.1", "Right, with the numbers of this scene"),
        ("(mc + mp) * 1.0000001", "right to some digits only"),
        ("mc - mp", "Not yet: "),
    ],
)
def test_numbers_of_the_scene_and_rounded_ones_are_told(text: str, says: str, browser: Any, cart: Path) -> None:
    with opened(browser, cart) as page:
        verdict = page.evaluate("text => Answers.judge('coefficients:k_z:k_z:1,1', text)", text)

    assert says in verdict["text"]


def read_or_none(text: str, lesson: Document) -> Expr | None:
    try:
        return read_formula(text, lesson.scene).express(Graph())
    except TeachError:
        return None


@pytest.mark.long
def test_page_and_command_line_read_the_same_formulas(lesson: Document, browser: Any, shown: Path) -> None:
    pieces = r"m1 m_2 h1 h_2^2 q_1 q_{2} q1' \dot q_1 \ddot{q}_2 \frac {2} { }"
    pieces += r" ( ) ( ) \left[ \right] \sin cos cos^2 c_{12} s"
    signs = "^ ** * * / + - + 2 0,5 1.5 ½ ² q̇₁ · m2h2 g sqrt x q̇1 (t) q_1(t) d/dt dq2/dt"
    signs += r" diff(q_1,t) Derivative(q2(t),(t,2)) \frac{d}{dt} \frac{d^2q_1}{dt^2} {\left(t\right)}"
    rng, known = random.Random(7), [*pieces.split(), *signs.split()]
    texts = [" ".join(rng.choices(known, k=rng.randint(1, 9))) for _ in range(1500)]
    points = questions(lesson)["points"]
    read_there = """texts => texts.map(text => {
        try { return QUESTIONS.points.map(Formulas.formula(text)).map(x => Number.isFinite(x) ? x : null); }
        catch (fault) { return String(fault.key); }
    })"""

    with opened(browser, shown) as page:
        there = page.evaluate(read_there, texts)

    accepted = 0
    for text, found in zip(texts, there, strict=True):
        node = read_or_none(text, lesson)
        if node is None:
            assert isinstance(found, str) or None in found, (text, found)  # a division by zero is told there by value
            continue
        assert isinstance(found, list), (text, found)
        accepted += 1
        for point, value in zip(points, found, strict=True):
            seeds = {x: point[str(x.value)] for x in reachable([node]) if x.op is Op.SYMBOL}
            try:
                here = evaluate([node], Floats(), seeds)[0]
            except (ValueError, ZeroDivisionError, OverflowError):
                assert value is None
                continue
            assert value == pytest.approx(here, rel=1e-9, abs=1e-9), text
    assert accepted > 100


def test_the_verb_writes_sliders_alone_for_scenes_without_formulas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, target = str(EXAMPLES / "heavy_top.toml"), tmp_path / "top.html"

    assert main(["walkthrough", scene, "--format", "sliders", "--language", "sk", "-o", str(target)]) == 0
    assert "klopenie" in target.read_text(encoding="utf-8")
    assert main(["walkthrough", str(EXAMPLES / "quadruped.toml"), "--format", "sliders", "-o", str(target)]) == 1
    assert "more than 8 velocities" in capsys.readouterr().err


def test_a_page_without_sliders_says_why() -> None:
    links = "".join(
        f"[bodies.b{k}]\nmass = 1\ncom = [1, 0, 0]\n[joints.j{k}]\ntype = 'revolute'\nparent = "
        f"'{f'b{k - 1}' if k else 'ground'}'\nchild = 'b{k}'\naxis = [0, 0, 1]\n"
        for k in range(9)
    )
    lesson = walkthrough(read_text(links, "chain"), formulation="dalembert", until="count")

    assert "more than 8 velocities" in html_page(lesson)


@pytest.mark.long(0)
def test_the_verb_writes_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene, target = str(EXAMPLES / "cart_pole.toml"), tmp_path / "lesson.html"

    assert main(["walkthrough", scene, "--format", "html", "--exercises", "--language", "sk", "-o", str(target)]) == 0

    assert capsys.readouterr().out.split() == [str(target)]
    assert "Skontrolovať" in target.read_text(encoding="utf-8")


# Answers as books, students and computer algebra write them

K_Z12 = "coefficients:k_z:k_z:1,2"
SQUARE = "square:2"
OTHER_WAYS = [
    (K_Z12, r"k_z21 = m_2 h_2^2 + m_2 h_1 h_2 \cos(q_2(t))", "Right."),
    (K_Z12, "m2*h2**2 + m2*h1*h2*cos(q2(t))", "Right."),
    (
        K_Z12,
        r"h_{1} h_{2} m_{2} \cos{\left(q_{2}{\left(t \right)} \right)} + h_{2}^{2} m_{2}",
        "Right.",
    ),
    (K_Z12, r"m_2 h_2^2 + m_2 h_1 h_2 \cos{\left(\operatorname{q_{2}}{\left(t \right)} \right)}", "Right."),
    (K_Z12, "m2*h2**2 + m2*h1*h2*sin(q2(t))", "Not yet: "),
    (K_Z12, "k_z21", "k_z21 only names a result"),
    (K_Z12, "k_{z,21}", "only names a result"),
    ("square:1", "h1^2 q̇1^2", "Right."),
    ("square:1", "h₁² q̇1²", "Right."),
    ("square:1", r"h_1^2 \left(\frac{d}{d t} q_{1}{\left(t \right)}\right)^{2}", "Right."),
    ("square:1", r"h_1^2 (\frac{dq_1(t)}{dt})^2", "Right."),
    ("square:1", "h1**2*Derivative(q1(t), t)**2", "Right."),
    ("square:1", "h1**2 (dq1/dt)^2", "Right."),
    ("square:1", "h1**2*diff(q1(t), t, t)**2", "Not yet: "),
    ("square:1", r"\frac{d^2}{dt^2} (h_1 q_1 + 1)", "Derivatives are read of coordinates only"),
    ("potential:1", "m1*g*h1*(1 - cos(q1))", "Right; your zero of potential energy lies elsewhere"),
    ("potential:2", r"-m_2 g (h_1 \cos q_1 + h_2\cos(q_1+q_2)) + m_2 g (h_1 + h_2)", "Right; your zero"),
    ("potential:1", "m1*g*h1*(1 + cos(q1))", "Not yet: "),
    ("potential:1", "m1*g*h1", "Not yet: "),
    ("potential:1", "m1*g*h1 - m1*g*h1*cos(q1)*1.00001", "Not yet: it has another value."),
    ("potential:1", "m1*g*y1", "y1 only names a result"),
    ("square:1", "h1**2*q1'^2 + m1*h1", "Not yet: "),
]


def agree(found: str, says: str) -> bool:
    return found.startswith(says) or (not says.startswith(("Right", "Not")) and says in found)


@pytest.mark.mends("5.7")
def test_a_page_reads_answers_as_the_command_line_does(browser: Any, shown: Path) -> None:
    with opened(browser, shown) as page:
        asked = [[key, text] for key, text, _ in OTHER_WAYS]
        told = page.evaluate("asked => asked.map(([key, text]) => Answers.judge(key, text).text)", asked)

    wrong = [(text, one) for (_, text, says), one in zip(OTHER_WAYS, told, strict=True) if not agree(one, says)]
    assert wrong == []


@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.mends("5.7")
@pytest.mark.parametrize(("key", "text", "says"), [one for one in OTHER_WAYS if "1.00001" not in one[1]])
def test_a_notebook_reads_answers_as_the_command_line_does(key: str, text: str, says: str, lesson: Document) -> None:
    assert agree(judge(lesson, key, text), says.replace("Derivatives are read", "derivatives are read"))
