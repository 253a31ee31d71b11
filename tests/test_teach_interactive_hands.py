"""What a hand does on the interactive page, and what its reader sees and hears: keys, links, panels, faults."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import OVERLAPS, move, opened, pictured, values
from test_teach_interactive import LED, saved, scene_of

from symdyn.scene import read, read_text
from symdyn.teach import walkthrough
from symdyn.teach.render.html import html_page
from symdyn.teach.render.page import interactive


@pytest.mark.wide("two_link-sk-light-1280", "everything-en-dark-390")
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize(("name", "language", "scheme"), [("two_link", "sk", "light"), ("everything", "en", "dark")])
def test_nothing_overlaps_and_nothing_is_wider_than_the_window(
    browser: Any, tmp_path: Path, name: str, language: str, scheme: str, width: int
) -> None:
    with opened(browser, saved(scene_of(name), tmp_path, language), width, scheme) as page:
        for group, x in (("qd", -1.23456), ("qdd", -12.3456)):
            move(page, group, 0, x)
        page.click(".live-choice summary")
        page.check("[data-word=frames]")
        page.evaluate("scrollTo(0, 0)")  # the picture stays in sight, and what is scrolled away lies under it

        assert page.evaluate(OVERLAPS) == []
        assert page.evaluate("document.documentElement.lang") == language
        dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 23, 29)"
        assert dark == (scheme == "dark")
        page.emulate_media(media="print")
        assert not page.is_visible("input[type=range]")
        assert page.is_visible("input[type=number][data-group]")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


def test_a_link_keeps_the_state_and_a_strange_one_changes_nothing(browser: Any, tmp_path: Path) -> None:
    path = saved(scene_of("two_link"), tmp_path)
    with opened(browser, path) as page:
        before = page.evaluate("[...symdyn.two_link.state().q]")
        for strange in ("q=1,2", "q=1,NaN&qd=0,0&qdd=0,0&params=1,1,1,1,1&t=0", "q=<script>", ""):
            page.evaluate(f"location.replace('#live-two_link?{strange}')")
            pictured(page)  # by then it has heard
            assert page.evaluate("[...symdyn.two_link.state().q]") == before
        page.evaluate("symdyn.two_link.advance(0.3)")
        state = page.evaluate("(({q, qd, params, t}) => [[...q], [...qd], [...params], t])(symdyn.two_link.state())")
        page.click("[data-do=link]")
        kept = page.evaluate("location.hash")
        page.click("[data-do=reset]")
        page.evaluate("location.replace('#other')")
        page.evaluate("hash => location.replace(hash)", kept)
        page.wait_for_function("symdyn.two_link.state().t > 0.2")
        again = page.evaluate("(({q, qd, params, t}) => [[...q], [...qd], [...params], t])(symdyn.two_link.state())")
    assert again == state


def test_the_phase_portrait_starts_where_it_is_pointed_at_and_a_ghost_moves_otherwise(
    browser: Any, tmp_path: Path
) -> None:
    with opened(browser, saved(scene_of("pendulum"), tmp_path)) as page:
        page.evaluate("symdyn.pendulum.show(['phase', 'ghost', 'trails', 'angles'])")
        portrait = page.locator("[data-panel=phase] svg")
        box = portrait.bounding_box()
        portrait.click(position={"x": box["width"] * (46 + 306 * 0.75) / 360, "y": box["height"] * 69 / 150})
        page.wait_for_function("symdyn.pendulum.state().t > 0.3")
        page.click("[data-do=play]")
        (E,) = values(page, "E")
        ghost, own = (
            page.eval_on_selector(f"svg.symdyn {where}", "x => x.getAttribute('d')")
            for where in (".live-ghost path.link", ".mark path.link")
        )
    assert abs(E) < 0.1  # it began at a quarter turn, at rest, as high as its pin; pictures have pixels
    assert ghost != own


def test_the_keyboard_is_enough(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        before = values(page, "coefficient")
        page.focus("input[type=range][data-group=q][data-k='1']")
        page.keyboard.press("ArrowRight")
        assert values(page, "coefficient") != before
        page.focus("[data-do=play]")
        page.keyboard.press("Space")
        page.wait_for_function("Number(document.querySelector('[data-out=t]').dataset.value) > 0")
        assert page.inner_text("[data-do=play]") == "Pause"
        page.keyboard.press("Space")
        assert page.inner_text("[data-do=play]") == "Play"
        names = page.eval_on_selector_all(
            ".live input, .live button, .live select",
            "all => all.map(x => x.getAttribute('aria-label') || x.textContent || x.closest('label').textContent)",
        )
        assert all(name.strip() for name in names)


def test_what_is_no_number_changes_nothing_and_a_massless_body_is_told(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        field = "input[type=number][data-group=q][data-k='0']"
        before, shown = values(page, "tau"), page.input_value(field)
        for typed, kept in (("", shown), ("1e400", "1e+40")):  # the last of 1, 1e4, 1e40 that is a number
            page.focus(field)
            page.keyboard.press("Control+A")
            page.keyboard.press("Delete")
            page.keyboard.type(typed)
            page.keyboard.press("Tab")
            assert page.input_value(field) == kept
            assert (values(page, "tau") == before) == (kept == shown)
        move(page, "params", 0, 0.0)
        move(page, "params", 1, 0.0)
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent")
        assert page.inner_text("[data-do=play]") == "Play"


def test_nothing_speaks_while_it_plays_but_faults(browser: Any, tmp_path: Path) -> None:
    """Numbers change sixty times a second: none of them is a live region."""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        loud = "output, [aria-live], [role=status], [role=alert], [role=log]"
        assert page.eval_on_selector_all(loud, "all => all.map(x => x.dataset.out)") == ["chosen", "lost"]
        page.evaluate("symdyn.two_link.advance(0.5)")
        assert page.text_content("[data-out=chosen]") == ""  # it tells what a key has moved
        order = "all => all.filter(x => x.tabIndex >= 0).map(x => x.dataset.do ?? x.dataset.group)"
        reached = page.eval_on_selector_all(".live button, .live select, .live input", order)
        assert reached[:3] == ["play", "step", "reset"]
        assert all(word in reached for word in ("q", "qd", "qdd", "params"))
        page.focus("[data-do=play]")
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.dataset.do") == "step"
        assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_several_scenes_stand_in_one_page(browser: Any, tmp_path: Path) -> None:
    parts = [interactive(scene_of(name)) for name in ("two_link", "cart_pole")]
    text = f"<!DOCTYPE html><meta charset=utf-8><style>{parts[0].css}</style>"
    text += "".join(f"{one.body}<script>{one.script}</script>" for one in parts)
    path = tmp_path / "both.html"
    path.write_text(text, encoding="utf-8")
    with opened(browser, path) as page:
        page.fill("[data-live=cart_pole] input[type=number][data-group=params]", "2.5")
        assert page.eval_on_selector("[data-live=cart_pole] [data-out=coefficient]", "x => x.dataset.value") == "2.6"
        assert page.evaluate("Object.keys(symdyn).join()") == "two_link,cart_pole"
        assert page.evaluate("new Set([...document.querySelectorAll('[id]')].map(x => x.id)).size") == page.evaluate(
            "document.querySelectorAll('[id]').length"
        )


def test_a_motion_that_runs_away_is_stopped_and_told(browser: Any, tmp_path: Path) -> None:
    text = """
    [bodies.cart]
    mass = 1
    [joints.rail]
    type = "prismatic"
    parent = "ground"
    child = "cart"
    axis = [1, 0, 0]
    coordinate = "x"
    force = "2*x_dot**3*exp(3*x)"
    """
    with opened(browser, saved(read_text(text, "runaway.toml"), tmp_path)) as page:
        move(page, "qd", 0, 5.0)
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent")
        assert "ran away" in page.inner_text("[data-out=lost]")
        assert page.inner_text("[data-do=play]") == "Play"


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_sliders_begin_at_the_state_of_the_lesson_and_come_back_to_it(browser: Any, tmp_path: Path, name: str) -> None:
    """The numbers of the lesson's table of values, as it prints them."""
    scene, path = scene_of(name), tmp_path / "lesson.html"
    path.write_text(html_page(walkthrough(scene)), encoding="utf-8")
    with opened(browser, path) as page:
        told = page.eval_on_selector_all(
            "#step-state tbody tr td:nth-child(2)", "all => all.map(x => x.textContent.replace('−', '-'))"
        )
        n = len(scene.parameters)

        def shown() -> list[str]:
            groups = ("params", "q", "qd", "qdd")
            return [x for g in groups for x in page.eval_on_selector_all(
                f"input[type=number][data-group={g}]", "all => all.map(x => x.value)")]  # fmt: skip

        begun = shown()
        assert [float(f"{float(x):.4g}") for x in begun] == [float(x) for x in told]
        assert len(begun) == n + 3 * len(scene.coordinates)
        for i, torque in enumerate(values(page, "tau") if name == "two_link" else (), 1):  # the lesson's are without Q
            claim = str(page.text_content(f"#step-torque-{i} .claim")).replace("−", "-")
            assert f"{torque:.4g}" in claim
        move(page, "q", 0, 1.7)
        assert shown() != begun
        page.click("[data-do=reset]")
        assert shown() == begun


@pytest.mark.mends("5.6")
def test_the_lines_of_the_energies_go_by_time(browser: Any, tmp_path: Path) -> None:
    """Half as fast a motion fills half as much of the strip in the same number of pictures."""
    end = """() => {
      symdyn.two_link.show(["energies"]);
      const points = document.querySelector("[data-panel=energies] path.line.live-k").getAttribute("d").split("L");
      const t = Number(document.querySelector("[data-out=t]").dataset.value);
      const axis = document.querySelector("[data-panel=energies] .grid").getAttribute("d").match(/M([\\d.]+)/)[1];
      return [t, points[points.length - 1].split(" ").map(Number)[0] - Number(axis)];
    }"""
    through = f"""stages => {{
      window.seen = [];
      const end = {end}, [play, speed] = ["play", "speed"].map(kind => document.querySelector(`[data-do=${{kind}}]`));
      const look = () => {{
        const [faster, least] = stages[window.seen.length];
        speed.value = faster;
        if (Number(document.querySelector("[data-out=t]").dataset.value) > least) window.seen.push(end());
        if (window.seen.length < stages.length) requestAnimationFrame(look);
        else play.click();
      }};
      play.click();
      look();
    }}"""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.evaluate(through, [["2", 1.0], ["0.25", 1.4], ["1", 2.0]])
        page.wait_for_function("window.seen.length === 3")
        seen = page.evaluate("window.seen")
    slopes = [x / t for t, x in seen]
    assert slopes == pytest.approx([slopes[0]] * 3, rel=0.01)


@pytest.mark.mends("5.6")
def test_a_spring_of_a_slide_begins_where_its_length_does(browser: Any, tmp_path: Path) -> None:
    """The spring of an elastic pendulum is as long as its coordinate: from the pivot, not from a wall behind it."""
    scene = read(LED.parent / "elastic_pendulum.toml")
    with opened(browser, saved(scene, tmp_path)) as page:
        pivot, bob = page.evaluate(
            """() => ["circle.joint", "path.joint"].map(look => {
              const all = [...document.querySelectorAll(`svg.symdyn ${look}`)].filter(x => x.getAttribute("transform"));
              return all[all.length - 1].getAttribute("transform").match(/-?[\\d.]+/g).slice(0, 2).map(Number);
            })"""
        )
        ropes = page.eval_on_selector_all("svg.symdyn path.rope", "all => all.map(x => x.getAttribute('d'))")
    way = np.array(bob) - np.array(pivot)
    coils = [text for text in ropes if text and "A" not in text and text.count("L") > 1]
    drawn = [np.array([float(x) for x in re.findall(r"-?[\d.]+", text)]).reshape(-1, 2) for text in coils]
    placed = [spots for spots in drawn if np.abs(spots).max() > 40]  # in the picture's place, not around its own
    assert placed
    for spots in placed:
        assert ((spots - pivot) @ way / (way @ way)).min() > -0.1


def test_the_page_says_when_the_energy_is_not_held(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.evaluate("""() => {
            const right = symdyn.two_link.potential_energy;
            let calls = 0;
            symdyn.two_link.potential_energy = (...given) => right(...given) * (1 + 1e-6 * calls++);
        }""")
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent.includes('billionth')")


def test_what_is_said_of_a_panel_goes_with_it(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        assert page.is_visible("[data-note=energies]")
        page.evaluate("symdyn.two_link.show(['velocities'])")
        assert not page.is_visible("[data-note=energies]")
        assert page.is_visible("text=Energy kept to")


@pytest.mark.slow
def test_blocks_in_the_window_take_turns_while_it_plays_and_agree_when_it_stands(browser: Any, tmp_path: Path) -> None:
    """One block of numbers a picture; within a table its terms are of one moment and add up."""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.set_viewport_size({"width": 1280, "height": 3000})
        page.evaluate("""() => {
            window.most = 0;
            let blocks = new Set();
            const watch = new MutationObserver(found => {
                for (const one of found) blocks.add(one.target.closest(".live-rows, .live-panel table"));
            });
            const options = { subtree: true, attributes: true, attributeFilter: ["data-value"] };
            watch.observe(document.querySelector(".live-panel"), options);
            const next = () => {
                window.most = Math.max(window.most, blocks.size);
                blocks = new Set();
                requestAnimationFrame(next);
            };
            requestAnimationFrame(next);
        }""")
        first = values(page, "tau")
        page.click("[data-do=play]")
        changed = """first => [...document.querySelectorAll('[data-out=tau]')]
            .every((one, k) => Number(one.dataset.value) !== first[k])"""
        page.wait_for_function(changed, arg=first)
        assert page.evaluate("window.most") == 1
        off = """() => Math.max(...[...document.querySelectorAll('.live-torques table')].map(table => {
            const all = kind => [...table.querySelectorAll(`[data-out=${kind}]`)].map(one => Number(one.dataset.value));
            return Math.abs(all("tau")[0] - all("term").reduce((x, y) => x + y, 0)); }))"""
        assert page.evaluate(off) < 1e-9
        page.click("[data-do=play]")
        assert page.evaluate(off) < 1e-9
