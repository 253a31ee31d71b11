"""Every lesson page that there is: those of docs, and those of all examples, with exercises, in two languages.

axe-core finds nothing in it, wide in the light and narrow in the dark; a screen reader has a name for every formula,
picture and control; by Tab one comes to every control and sees where one is; and Firefox shows it and lets it move.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import opened, played
from npm_packages import packages
from programs import path_of

from symdyn.errors import SymdynError
from symdyn.scene import read
from symdyn.teach import interactive_page, walkthrough
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.html import html_page

ROOT = Path(__file__).parent.parent
WRITTEN = sorted((ROOT / "docs/walkthroughs").glob("*.html"))
EXAMPLES = sorted({*(ROOT / "examples").glob("*.toml")} - {ROOT / "examples/quadruped.toml"})  # too long for a page
PAGES = [*(path.name for path in WRITTEN), *(f"{path.stem}-{code}" for path in EXAMPLES for code in ("en", "sk"))]
AXE = """async () => {
  const resultTypes = ["violations"], rules = { "color-contrast": { enabled: false } };
  const all = await axe.run(document, { rules, resultTypes });
  const later = [...document.querySelectorAll("math")].slice(300);
  later.forEach(one => one.style.display = "none");
  const some = await axe.run(document, { runOnly: ["color-contrast"], resultTypes });
  later.forEach(one => one.style.display = "");
  return [...all.violations, ...some.violations].map(one => [one.id, one.nodes.map(node => node.html)]);
}"""
"""What axe-core finds; the contrast of 300 formulas, since what that takes goes with their square."""
OPENED = "document.querySelectorAll('details').forEach(one => one.open = true)"
NAMED = {"MathMLMath", "math", "image", "application", "button", "link", "checkbox", "radio", "slider", "spinbutton"}
NAMED |= {"textbox", "combobox", "region", "navigation", "DisclosureTriangle"}
"""Roles of the tree of a browser whose every element must have a name."""
FOCUSABLE = """() => [...document.querySelectorAll(`a[href], button, input, select, summary, [tabindex="0"]`)]
  .filter(one => one.checkVisibility() && !one.disabled).map((one, k) => one.dataset.stop = k).length"""
STOP = """() => {
  const one = document.activeElement, look = getComputedStyle(one);
  return [Number(one.dataset.stop ?? -1), look.outlineStyle !== "none" && parseFloat(look.outlineWidth) >= 2];
}"""
SMALL = """() => [...document.querySelectorAll("button, select, summary, input, nav a, .points")]
  .filter(one => one.checkVisibility())
  .map(one => [one.outerHTML.slice(0, 90), (one.closest("label") ?? one).getBoundingClientRect()])
  .filter(([, box]) => box.width < 23.9 || box.height < 23.9).map(([text]) => text)"""


def shown(name: str, folder: Path) -> Path:
    """Return the file of a page: of docs, or made of an example; with sliders alone where formulas are too long."""
    if name.endswith(".html"):
        return ROOT / "docs/walkthroughs" / name
    stem, code = name.rsplit("-", 1)
    scene = read(ROOT / f"examples/{stem}.toml")
    try:
        text = html_page(with_exercises(walkthrough(scene, code)))
    except SymdynError:
        text = interactive_page(scene, language=code)
    (folder / f"{name}.html").write_text(text, encoding="utf-8")
    return folder / f"{name}.html"


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium", "npm")
@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_for_everybody(name: str, tmp_path: Path, browser: Any) -> None:
    axe = (packages() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")
    path = shown(name, tmp_path)
    for width, scheme in ((1280, "light"), (390, "dark")):
        with opened(browser, path, width, scheme) as page:
            page.evaluate(OPENED)
            page.evaluate(axe)
            assert (name, width, page.evaluate(AXE)) == (name, width, [])
            assert (name, width, page.evaluate(SMALL)) == (name, width, [])
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), (name, width)
            if width == 1280:
                nameless = list(nameless_in(page))
    assert (name, nameless) == (name, [])


INSIDE = """() => {
  const picture = document.querySelector(".live-figure svg.symdyn"), at = one => one.getBoundingClientRect();
  const seen = [...picture.querySelectorAll("text")].filter(one => one.checkVisibility());
  const names = seen.filter(one => one.classList.contains("live-name"));
  const hit = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 8;
  const frame = at(picture), round = [...picture.querySelectorAll("[data-mark=disc] path, [data-mark=wheel] path")];
  return [names.filter(a => seen.some(b => b !== a && hit(at(a), at(b)))).length,
    round.map(at).filter(one => one.left < frame.left - 1 || one.right > frame.right + 1).length];
}"""
"""How many names of bodies stand on other letters, and how many wheels are cut off by the frame."""
ASKED = """document.querySelectorAll('[data-word=velocities], [data-word=weights]')
  .forEach(one => one.checked || one.click())"""


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium")
@pytest.mark.parametrize("name", ["governor-en", "gripper2-en", "cart_with_wheel-en"])
def test_names_are_apart_and_wheels_inside_while_it_moves(name: str, tmp_path: Path, browser: Any) -> None:
    with opened(browser, shown(name, tmp_path)) as page:
        page.evaluate(ASKED)
        for seconds in (0.0, 0.6, 1.2):
            played(page, seconds)
            assert page.evaluate(INSIDE) == [0, 0], (name, seconds)


def nameless_in(page: Any) -> Iterator[str]:
    """Yield roles of what a screen reader finds without a name, and whether it finds formulas at all."""
    session = page.context.new_cdp_session(page)
    tree = [one for one in session.send("Accessibility.getFullAXTree")["nodes"] if not one.get("ignored")]
    session.detach()
    roles = [one["role"]["value"] for one in tree]
    for one, role in zip(tree, roles, strict=True):
        if role in NAMED and not str(one.get("name", {}).get("value") or "").strip():
            yield role
    shown = page.evaluate("[...document.querySelectorAll('math')].filter(one => one.checkVisibility()).length")
    if roles.count("MathMLMath") + roles.count("math") < 0.5 * shown:
        yield f"{shown} formulas of which few are in the tree"


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium")
@pytest.mark.parametrize("name", ["pendulum-en", "four_bar.html"])
def test_tab_comes_to_every_control_and_is_seen(name: str, tmp_path: Path, browser: Any) -> None:
    with opened(browser, shown(name, tmp_path)) as page:
        stops = page.evaluate(FOCUSABLE)
        reached = []
        for _ in range(2 * stops):
            page.keyboard.press("Tab")
            place, is_seen = page.evaluate(STOP)
            assert is_seen or place < 0, place
            reached.append(place)
            if place == stops - 1:
                break
    order = [place for place in reached if place >= 0]
    assert order == sorted(order), "in the order of the page"
    assert set(range(stops)) - set(order) <= set(), "every control"


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("firefox", "node", "npm")
def test_firefox_shows_and_moves_them(tmp_path: Path) -> None:
    names = [*(path.name for path in WRITTEN), "pendulum-sk", "governor-en", "heavy_top-sk"]
    addresses = [shown(name, tmp_path).as_uri() for name in names]
    node, firefox = (path_of(one) for one in ("node", "firefox"))
    command = [str(node), str(ROOT / "tests/lessons_in_firefox.mjs"), str(packages() / "puppeteer-core"), str(firefox)]
    told = subprocess.run([*command, *addresses], capture_output=True, text=True, check=True, timeout=600).stdout
    pages = [json.loads(line) for line in told.splitlines()]
    assert len(pages) == len(names)
    for name, page in zip(names, pages, strict=True):
        assert page["said"] == [], name
        assert all(one["moved"] and one["over"] <= 0 and one["flat"] == one["short"] == 0 for one in page["seen"]), name
