"""The playground of the site: its files, its stand-in for NumPy against NumPy, and the page in a browser."""

from __future__ import annotations

import gzip
import json
import subprocess
import sys
import time
import zlib
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import chromium, window
from npm_packages import packages
from patience import HANG
from programs import path_of
from site_page import BUILT, bundle, edited, served, turned, until

from symdyn.playground import answer

ROOT = bundle.ROOT
pytestmark = pytest.mark.playground

ANSWERS = """
import json, sys
if sys.argv[1]:
    sys.path.insert(0, sys.argv[1])
from symdyn.playground import answer
from symdyn.scene import examples
found = {}
for name in examples():
    text = answer("example", "", {"name": name})["text"]
    asked = {"scene": {}, "equations": {}, "coefficients": {}, "picture": {}}
    for what, how in [*asked.items(), ("code", {"target": "js"}), ("code", {"target": "c"})]:
        told = answer(what, text, how)
        told.pop("sliders", None)  # positions of assembled loops, to the last digit
        found[f"{name}: {what} {how}"] = told
    if name in ("two_link", "cart_pole", "puma560"):
        found[f"{name}: motion"] = answer("motion", text, {})
    elif name in ("four_bar", "rssr"):
        found[f"{name}: motion"] = [*answer("motion", text, {})]
print(json.dumps(found))
"""


@pytest.mark.runs
def test_the_stand_in_gives_the_texts_and_pictures_of_numpy() -> None:
    """Of all examples, byte for byte."""

    def answers(folder: str) -> dict[str, Any]:
        command = [sys.executable, "-c", ANSWERS, folder]
        done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT, timeout=HANG)
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    real, other = answers(""), answers(str(bundle.HERE / "standin"))

    assert len(real) > 200
    assert [name for name, told in real.items() if told != other[name]] == []
    assert not [name for name, told in real.items() if "failed" in told]


def test_archives_are_the_same_bytes_each_time() -> None:
    files = {"b/c.py": b"1", "a.py": b"2" * 2000}
    assert bundle.archive(files) == bundle.archive(dict(reversed(files.items())))


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Serve the folder that `make playground` writes."""
    with served() as (found, _):
        yield found


def sent(path: Path) -> int:
    """Return how many bytes a server sends of a file that compresses."""
    text = path.read_bytes()
    return len(text) if path.suffix in (".gz", ".zip") else len(gzip.compress(text, 9))


def test_what_travels_is_bounded(address: str) -> None:
    every = {path: sent(path) for path in BUILT.rglob("*") if path.is_file()}
    later, asked = (
        sum(n for path, n in every.items() if path.name.startswith(f"{one}-")) for one in ("rest", "library")
    )

    assert sum(every.values()) - later - asked < 13.5e6
    assert sum(every.values()) - asked < 15.8e6


@pytest.mark.runs("chromium")
def test_the_page_shows_an_example_at_once_then_whatever_is_written_and_needs_no_network_again(address: str) -> None:
    said: list[str] = []
    with chromium() as browser:
        page = window(browser)
        page.on("request", lambda one: None if one.url.startswith((address, "data:")) else said.append(one.url))
        page.on("pageerror", lambda fault: said.append(str(fault)))
        page.on("console", lambda message: said.append(message.text))
        page.goto(address)
        until(page, "document.body.dataset.shown", 30)
        assert page.locator("#equations math").count() > 3
        until(page, "document.documentElement.dataset.python")

        text = page.input_value("#text")
        edited(page, text.replace('"-h2"', '"-2*h2"'))
        assert "4" in page.text_content("#equations")
        assert page.locator("#picture img").count() == 1
        edited(page, text.replace("axis =", "axi =", 1).replace('"m1"', '"M1"'))
        assert "did you mean axis?" in page.text_content("#faults")
        lines = [int(one.split()[1]) for one in page.locator("#faults b").all_text_contents()]
        assert len(lines) > 1
        assert lines == sorted(lines)
        edited(page, text.replace('name = "two_link"', 'name = "mine"'))
        until(page, "document.querySelector('#name').textContent === 'mine.toml'")  # as it is saved
        page.select_option("#target", "js")
        until(page, "document.querySelector('#code').textContent.includes('forward_dynamics')")
        turned(page, "motion")
        page.frame_locator("#motion iframe").locator("[data-do=play]").click()
        turned(page, "motion")
        turned(page, "lesson")
        lesson = page.frame_locator("#lesson iframe")
        lesson.locator("#step-numbers, #step-state").first.wait_for(state="attached", timeout=HANG * 1000)
        assert "symdyn play" in lesson.locator("#step-equilibria").text_content()
        page.check("#exercises")
        asked = lesson.locator("form.blank:not(.choice)").first
        asked.wait_for(state="attached", timeout=HANG * 1000)
        asked.evaluate("form => form.closest('details').setAttribute('open', '')")
        asked.locator("input[name=answer]").fill("m1 + 7")
        asked.locator("button[type=submit]").click()  # judged in its frame
        assert "wrong" in asked.locator(".verdict").get_attribute("class")
        turned(page, "lesson")

        until(page, "navigator.serviceWorker.controller !== null", 30)
        page.reload()  # with the worker that keeps what is loaded
        until(page, "document.documentElement.dataset.python")
        edited(page, text)
        page.context.set_offline(True)
        page.reload()
        until(page, "document.documentElement.dataset.python")
        edited(page, text.replace('"-h2"', '"-3*h2"'))
        assert page.locator("#equations math").count() > 3
    assert not said


SEEN = """(([inner, outer]) => {
  const [a, b] = [inner, outer].map(one => document.querySelector(one).getBoundingClientRect());
  const isInside = a.top >= b.top && a.bottom <= b.bottom + 1 && a.left >= b.left && a.left < b.right;
  return a.height > 0 && isInside && scrollX === 0;
})(%s)"""
"""Whether one element stands inside another, and the page at its left edge."""


@pytest.mark.runs("chromium")
@pytest.mark.parametrize("width", [1280, 390])
def test_an_editor_shows_its_focus_a_mistake_that_is_tapped_and_what_completes(address: str, width: int) -> None:
    """Each of these was out of sight once: behind a long line, below the last one, under a list of mistakes."""
    wide = "point = { at = [" + ", ".join(["0.25"] * 40) + ", 1..5] }"
    with chromium() as browser:
        page = window(browser, viewport={"width": width, "height": 844})
        page.goto(address)
        until(page, "document.body.dataset.shown", 50)
        until(page, "document.documentElement.dataset.python")
        edited(page, "\n".join(['name = "arm"', *["# below"] * 60, wide]))
        page.locator("#faults button").first.click()
        until(page, SEEN % '["#editor .wrong", "#editor"]')
        assert page.evaluate("getSelection().toString() || text.value.slice(text.selectionStart, text.selectionEnd)")
        assert page.evaluate("getComputedStyle(document.querySelector('#editor .numbers')).boxShadow") != "none"
        until(page, SEEN % '["#editor .numbers div.wrong", "#editor"]')  # its number, too, which has the focus's mark

        edited(page, "\n".join(["gravity = 1 1", *["nme = 1"] * 30, "[bodies.arm]", ""]))
        page.focus("#text")
        page.keyboard.press("Control+End")
        page.keyboard.type("ma")
        until(page, "!document.querySelector('#choices').hidden")
        until(page, "document.querySelectorAll('#faults li').length")
        time.sleep(0.5)  # the rest of a hand, after which mistakes take their room
        until(page, SEEN % '["#choices li[aria-selected=true]", "#editor"]')
        page.keyboard.press("Enter")
        assert page.input_value("#text").endswith("mass = ")


INSIDE = """html => {
  const { body } = new DOMParser().parseFromString(html, "text/html");
  return (body.querySelector(":scope > .long") ?? body).innerHTML;
}"""


@pytest.mark.runs("chromium")
def test_a_long_formula_is_shown_in_parts_and_whole_and_an_editor_scrolls_no_further_than_its_text(
    address: str,
) -> None:
    """Laying out the first equation of puma560, 2757 elements, took 150 ms in one go."""
    text = (ROOT / "examples" / "puma560.toml").read_text(encoding="utf-8")
    with chromium() as browser:
        page = window(browser, viewport={"width": 390, "height": 844})
        page.goto(address)
        edited(page, text)
        shown = page.evaluate("document.querySelector('#equations .symdyn-shown').innerHTML")
        assert shown == page.evaluate(INSIDE, answer("equations", text, {})["html"])
        edited(page, 'name = "short"')
        assert (
            page.evaluate(
                "(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)(document.querySelector('.editor'))"
            )
            == 0
        )


AXE = """async () => (await axe.run(document)).violations.map(one => [one.id, one.nodes.map(node => node.html)])"""


@pytest.mark.runs("chromium", "npm")
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_axe_finds_nothing(address: str, width: int, scheme: str) -> None:
    axe = (packages() / "axe-core" / "axe.min.js").read_text(encoding="utf-8")
    with chromium() as browser:
        page = window(browser, viewport={"width": width, "height": 844}, color_scheme=scheme)
        page.goto(address)
        until(page, "document.documentElement.dataset.python")
        page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
        until(page, "document.querySelector('#motion iframe') && document.querySelector('#lesson iframe')")
        edited(page, page.input_value("#text").replace("axis =", "axi =", 1))
        page.focus("#text")
        page.keyboard.press("Control+Space")
        for frame in page.frames:
            frame.evaluate(axe)
            assert frame.evaluate(AXE) == []


@pytest.mark.runs("chromium")
def test_a_link_opens_with_its_scene_before_anything_else(address: str) -> None:
    """What is asked while the worker of Python begins was lost, and the page waited for a minute."""
    text = (ROOT / "examples" / "cart_pole.toml").read_text(encoding="utf-8").replace('"cart_pole"', '"mine"')
    packed = zlib.compress(text.encode(), wbits=-15)
    with chromium() as browser:
        page = window(browser)
        page.goto(f"{address}#s={urlsafe_b64encode(packed).decode().rstrip('=')}")
        until(page, "document.body.dataset.shown", 50)
        assert page.title() == "mine · symdyn"
        assert page.locator("#equations math").count() > 3


@pytest.mark.runs("firefox", "node", "npm")
def test_firefox_shows_edits_mistakes_and_equations_in_their_column(address: str) -> None:
    script = Path(__file__).parent / "playground_in_firefox.mjs"
    command = ["node", str(script), str(packages() / "puppeteer-core"), str(path_of("firefox")), address]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=HANG)

    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout) == {"equations": True, "faults": True, "pulled": True, "wide": 0, "said": []}
