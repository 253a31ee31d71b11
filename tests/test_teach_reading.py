"""A lesson that is read in a browser: its figure stays, follows and can be dragged; numbers stand under its terms."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from browser import opened, pictured
from lessons import lesson_of
from test_teach_contacts import ROD

from symdyn.algebra.numeric import Floats
from symdyn.graph import evaluate
from symdyn.scene import Scene, read, read_text
from symdyn.scene.values import acceleration_name
from symdyn.teach import Document
from symdyn.teach.languages import language_of
from symdyn.teach.mathematics import with_words
from symdyn.teach.render.html import BY_STEP, SHOWN, Numbered, Owners, html_page, pointed

EXAMPLES = Path(__file__).parent.parent / "examples"
LESSONS = [("two_link", "lagrange"), ("cart_pole", "lagrange"), ("slider_crank", "dalembert")]


@cache
def lesson(name: str, formulation: str = "lagrange") -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"), formulation=formulation)


def saved(name: str, folder: Path, formulation: str = "lagrange") -> Path:
    path = folder / "lesson.html"
    path.write_text(html_page(lesson(name, formulation)), encoding="utf-8")
    return path


def state_of(page: Any, scene: Scene) -> dict[str, float]:
    """Return the numbers of the page's state by symbol."""
    at = page.evaluate(
        f"(({{q, qd, qdd, params}}) => [q, qd, qdd, params].map(x => [...x]))(symdyn.{scene.name}.state())"
    )
    accelerations = [acceleration_name(name) for name in scene.velocities]
    names = (scene.coordinates, scene.velocities, accelerations, [one.name for one in scene.parameters])
    return {name: x for row, found in zip(names, at, strict=True) for name, x in zip(row, found, strict=True)}


def drag(page: Any, mark: str, dx: float, dy: float) -> None:
    x, y = page.eval_on_selector(mark, "x => (r => [r.x + r.width / 2, r.y + r.height / 2])(x.getBoundingClientRect())")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx / 2, y + dy / 2)
    pictured(page)
    page.mouse.move(x + dx, y + dy)
    pictured(page)
    page.mouse.up()


ENDS = "x => (r => [r.top, r.bottom])(x.getBoundingClientRect())"
FORMULAS = """
  [...document.querySelectorAll(".flow[data-n]")].filter(x => x.offsetParent).map(flow => {
    flow.scrollIntoView();
    const text = x => x.textContent.replace(/\\s/g, "");
    return [...flow.querySelectorAll(".t")].map(x => [x.firstChild, x.lastChild].map(text));
  })"""


def number(text: str) -> float:
    return float(text.replace("\u2212", "-"))


@pytest.mark.long
@pytest.mark.parametrize(("name", "formulation"), LESSONS)
def test_numbers_under_terms_are_those_of_the_graph(browser: Any, tmp_path: Path, name: str, formulation: str) -> None:
    document = lesson(name, formulation)
    numbered = Numbered(document)
    path = saved(name, tmp_path, formulation)
    html_page(document)
    with opened(browser, path) as page:
        drag(page, ".mark[data-mark=particle], .mark[data-mark=com]", 30, -20)
        scene = document.scene
        at, found = state_of(page, scene), page.evaluate(f"symdyn.{scene.name}.named()")
    for _, block in document.blocks():
        if block in numbered._pieces:
            numbered.marks(block, len(numbered._pieces[block]))
    symbols = {document.graph.symbol(symbol): x for symbol, x in at.items()}
    expected = evaluate(numbered.values, Floats(), symbols)
    assert len(expected) > 10
    assert list(found.values() if isinstance(found, dict) else found) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("name", "formulation"), [("two_link", "lagrange"), ("two_link", "dalembert")])
def test_numbers_under_a_sum_add_up_as_they_are_read(browser: Any, tmp_path: Path, name: str, formulation: str) -> None:
    with opened(browser, saved(name, tmp_path, formulation)) as page:
        formulas = page.evaluate(FORMULAS)
    checked = 0
    for terms in formulas:
        equal = [k for k, (text, _) in enumerate(terms) if text[0] in "=≈"]
        left, right = terms[: equal[0]], terms[equal[0] :]
        sides = [[text for _, text in side] for side in (left, right)]
        if right[0][0] in ("=0", "=1"):
            sides[1] = [right[0][0][1:]]
        if len(equal) > 1 or len(terms) < 3 or not all(text for side in sides for text in side):
            continue
        step = 10.0 ** -len(terms[0][1].partition(".")[2])
        sums = [sum(map(number, side)) for side in sides]
        assert abs(sums[0] - sums[1]) <= step * (1 + len(terms)) / 2, terms
        checked += 1
    assert checked > 5


def test_the_figure_follows_the_step_that_is_read(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("two_link", tmp_path)) as page:
        page.evaluate(
            "document.querySelector('.live-figure')"
            ".addEventListener('symdyn:shown', event => { window.said = event.detail.words; })"
        )
        for step in ("position-2", "velocity-1", "coefficients-k_C", "coefficients-k_G"):
            page.evaluate(f"document.getElementById('step-{step}').scrollIntoView()")
            page.wait_for_selector(f"#step-{step}.now")
            declared = page.eval_on_selector(f"#step-{step}", "x => x.dataset.show.split(' ')")
            assert page.evaluate("window.said") == declared
            assert page.eval_on_selector(".now", "x => x.id") == f"step-{step}"
            box = page.eval_on_selector("svg.symdyn", ENDS)
            assert box[0] >= -1
            assert box[1] <= 800
        assert page.evaluate("[...document.querySelectorAll('.vector.weights')].some(x => x.style.display !== 'none')")


def test_a_term_points_at_its_vectors_and_a_vector_at_its_terms(browser: Any, tmp_path: Path) -> None:
    shown = "x => x.style.display !== 'none' && !x.classList.contains('faint')"
    seen = f"[...new Set([...document.querySelectorAll('.vector')].filter({shown}).map(x => x.dataset.vector))]"
    with opened(browser, saved("two_link", tmp_path)) as page:
        page.evaluate("document.getElementById('step-velocity-2').scrollIntoView()")
        page.wait_for_selector("#step-velocity-2.now")
        page.hover("#step-velocity-2 .points")
        assert page.evaluate(seen) == ["velocities:link2"]
        page.mouse.move(2, 2)
        assert set(page.evaluate(seen)) == {"velocities:link1", "velocities:link2"}
        page.hover(".vector[data-vector='velocities:link2'] path", force=True)
        assert page.locator("#step-velocity-2 .t.hot").count() > 1
        assert page.locator(".t.hot").count() == page.locator("#step-velocity-2 .t.hot").count()


def test_keys_go_from_term_to_term_and_leave_them(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("two_link", tmp_path)) as page:
        tabs = page.eval_on_selector_all(
            ".flow", "all => all.map(x => x.querySelectorAll('.t[tabindex=\"0\"]').length)"
        )
        assert max(tabs) == 1  # one stop a formula
        page.evaluate("document.querySelectorAll('#step-equation-1 .points')[0].focus()")
        first = page.evaluate("document.activeElement.textContent")
        page.keyboard.press("ArrowRight")
        assert page.evaluate("document.activeElement.classList.contains('hot')")
        assert page.evaluate("document.activeElement.textContent") != first
        assert page.locator(".t.hot").count() == 1
        page.keyboard.press("Escape")
        assert page.locator(".t.hot").count() == 0


def test_what_is_dragged_stays_under_the_pointer(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("two_link", tmp_path)) as page:
        tip = ".mark[data-mark=particle][data-body=link2] circle"
        middle = "x => (r => [r.x + r.width / 2, r.y + r.height / 2])(x.getBoundingClientRect())"
        before = page.eval_on_selector(tip, middle)
        drag(page, tip, 25, -60)
        after = page.eval_on_selector(tip, middle)
        assert [b - a for a, b in zip(before, after, strict=True)] == pytest.approx([25, -60], abs=2)


def test_a_loop_stays_closed_while_it_is_dragged(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("four_bar", tmp_path, "dalembert")) as page:
        before = page.evaluate("[...symdyn.four_bar.state().q]")
        drag(page, ".mark[data-mark=com][data-body=coupler]", 12, 6)
        after = page.evaluate("[...symdyn.four_bar.state().q]")
        off = page.evaluate(
            "(({q, params}) => [...symdyn.four_bar.constraint_residual(q, params)])(symdyn.four_bar.state())"
        )
    assert max(abs(b - a) for a, b in zip(before, after, strict=True)) > 0.01
    assert max(map(abs, off)) < 1e-9


def test_the_figure_is_moved_by_keys_and_says_so(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("two_link", tmp_path)) as page:
        page.focus("svg.symdyn")
        before = page.evaluate("[...symdyn.two_link.state().q]")
        for key in ("ArrowDown", "ArrowRight", "ArrowRight"):
            page.keyboard.press(key)
        after = page.evaluate("[...symdyn.two_link.state().q]")
        assert after[0] == before[0]
        assert after[1] > before[1]
        assert page.inner_text("[data-out=chosen]").startswith("q2: ")
        page.keyboard.press("Space")
        assert page.inner_text("[data-do=play]") == "Pause"


@pytest.mark.heavy("700", "1280")
@pytest.mark.long
@pytest.mark.parametrize("width", [390, 700, 1024, 1280, 1920])
def test_the_figure_stays_and_nothing_is_wider_than_the_window(browser: Any, tmp_path: Path, width: int) -> None:
    with opened(browser, saved("two_link", tmp_path), width) as page:
        for part in ("part-velocities", "part-equations", "part-coefficients"):
            page.evaluate(f"document.getElementById('{part}').scrollIntoView()")
            pictured(page)
            top, bottom = page.eval_on_selector(
                "svg.symdyn", "x => (r => [r.top, r.bottom])(x.getBoundingClientRect())"
            )
            heading = page.eval_on_selector(f"#{part} h2", "x => x.getBoundingClientRect().top")
            assert -1 <= top < bottom <= 800
            assert width >= 1024 or heading >= bottom - 1  # not hidden behind the figure
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_printed_lesson_has_no_numbers_that_move(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved("two_link", tmp_path)) as page:
        page.emulate_media(media="print")
        assert page.evaluate("[...document.querySelectorAll('.n')].every(x => getComputedStyle(x).display === 'none')")
        for moving in (".stage", "#part-live"):
            assert page.eval_on_selector(moving, "x => getComputedStyle(x).display") == "none"


def is_shown(word: str) -> bool:
    return word in SHOWN or any(word.startswith(kind) and len(word) > len(kind) for kind in ("body:", "joint:"))


@pytest.mark.long(0)
def test_every_word_that_a_step_shows_is_known() -> None:
    for name, formulation in LESSONS:
        document = lesson(name, formulation)
        for section in document.sections:
            for step in section.steps:
                assert all(map(is_shown, Numbered(document).shown(step) if step.blocks else step.show)), step.key
    assert all(is_shown(word) for words in BY_STEP.values() for word in words)
    assert not is_shown("body:")


def test_names_speak_of_vectors() -> None:
    owners = Owners({"1": "arm", "2a": "wheel"}, ("arm", "wheel"), {"arm": "hip", "wheel": "axle"})
    for key, about in {
        "dx:1": "velocities:arm", "P:2a": "weights:wheel", "P:01:11": "", "K:": "velocities", "L:": "",
        "k_C:1,1,2": "coriolis/0,1", "k_D:2,1": "centrifugal/0", "k_z:1,2": "inertia", "FDbar:01": "inertia",
        "FD:22:x": "inertia:wheel", "F*R:1,axle:x": "reactions:axle", "FR:11:x": "reactions:hip",
        "reaction:hip:0": "reactions:hip", "FA:33": "weights",
    }.items():  # fmt: skip
        assert pointed(key, owners) == about


@pytest.mark.long(0)
def test_a_lesson_of_too_many_terms_has_no_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 'data-n="' in html_page(lesson("pendulum"))
    monkeypatch.setattr("symdyn.teach.render.html.MOST", 10)
    page = html_page(lesson("pendulum"))
    assert 'data-n="' not in page
    assert 'data-do="numbers"' not in page


# What is beside the formulas


def test_formulas_are_said_in_words() -> None:
    """axe-core finds heads of tables empty that hold mathematics alone."""
    math = "<mover><mi>q</mi><mo>¨</mo></mover><mo>=</mo><mo>−</mo>"
    math += "<mfrac><mi>g</mi><msup><mi>l</mi><mn>2</mn></msup></mfrac>"

    english, slovak = (with_words(f"<th><math>{math}</math></th>", language_of(one).page) for one in ("en", "sk"))

    assert 'aria-label="q double dot equals minus g over (l squared)"' in english
    assert re.sub("<.*?>", "", english).startswith("q double dot equals")
    assert 'aria-label="q s dvomi bodkami rovná sa mínus g lomeno (l na druhú)"' in slovak


@pytest.mark.runs
def test_a_slider_at_a_sentence_is_around_the_threshold_that_it_states(browser: Any, tmp_path: Path) -> None:
    hoop = lesson_of(read(Path(__file__).parent / "data" / "found" / "hoop_driven.toml"))
    (one,) = (one for section in hoop.sections for step in section.steps for one in step.tries)
    assert one.threshold == pytest.approx((9.81 / 0.4) ** 0.5)  # Ω² > g/R

    path = tmp_path / "lesson.html"
    path.write_text(html_page(hoop), encoding="utf-8")
    with opened(browser, path) as page:
        page.fill("[data-try]", f"{one.threshold / 2:.4f}")
        assert state_of(page, hoop.scene)[one.name] == pytest.approx(one.threshold / 2, rel=1e-3)
        assert page.text_content("nav [aria-current]")
        assert not page.is_visible(".still")


@pytest.mark.slow
@pytest.mark.runs
def test_a_rate_is_moved_at_the_sentence_with_its_critical_value(browser: Any, tmp_path: Path) -> None:
    """The governor: alike arms rest apart from phi_dot**2 > dW/d(cos alpha) at alpha = 0 on."""
    governor = lesson_of(read(EXAMPLES / "governor.toml"))
    (one,) = (one for section in governor.sections for step in section.steps for one in step.tries)
    long, ball, sleeve, stiff, free = 0.15, 0.8, 1.5, 400, 0.29
    pulls = (4 * ball + 2 * sleeve + 2 * 0.1) * 9.81 * long - 2 * stiff * (2 * long - free) * long
    turns = 2 * (4 * ball * long**2 + 0.1 * long**2 + 8e-4)
    assert (one.name, one.threshold) == ("phi_dot", pytest.approx((pulls / turns) ** 0.5))

    path = tmp_path / "lesson.html"
    path.write_text(html_page(governor), encoding="utf-8")
    slid = "(x, v) => { x.value = v; x.dispatchEvent(new Event('input')); return symdyn.governor.state().qd[0]; }"
    with opened(browser, path) as page:
        for rate in (one.threshold / 2, 1.5 * one.threshold):
            assert page.eval_on_selector("[data-try]", slid, rate) == pytest.approx(rate, rel=1e-6)
            page.wait_for_timeout(200)
            assert state_of(page, governor.scene)["phi_dot"] != rate, "it plays on"


@pytest.mark.slow
@pytest.mark.runs
def test_the_line_of_a_chart_goes_with_its_slider(browser: Any, tmp_path: Path) -> None:
    """Painlevé's chart of a rod: the line at a coefficient of friction stands where the axis has it."""
    path = tmp_path / "lesson.html"
    path.write_text(html_page(lesson_of(read_text(ROD))), encoding="utf-8")
    with opened(browser, path) as page:
        line, axis = page.locator("path.level").last, page.locator("svg:has(path.level) path.stem").last
        top = float(page.get_attribute("[data-try]", "max"))
        for mu in (1.6, 0.5):
            page.fill("[data-try]", f"{mu}")
            over, all_of_it = line.bounding_box(), axis.bounding_box()
            height = all_of_it["y"] + all_of_it["height"] - over["y"] - over["height"] / 2
            assert height == pytest.approx(mu / top * all_of_it["height"], abs=1.5)
