"""Pages in a headless Chromium, with everything that its console said."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from patience import HANG
from programs import path_of

WAIT = 1000 * HANG
"""Milliseconds."""

PICTURES = """number => new Promise(done => {
  const next = () => { number -= 1; requestAnimationFrame(number > 0 ? next : done); };
  next();
})"""

PLAYED = """seconds => {
  window.isPlayed = false;
  const look = () => {
    if (Number(document.querySelector("[data-out=t]").dataset.value) <= seconds) {
      requestAnimationFrame(look);
      return;
    }
    document.querySelector("[data-do=play]").click();
    window.isPlayed = true;
  };
  requestAnimationFrame(look);
}"""


@contextmanager
def chromium(*more: str) -> Iterator[Any]:
    """Yield a browser, started with more arguments; the test is skipped where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra dev)")
    path = path_of("chromium")
    if path is None:
        pytest.skip("there is no chromium; apt-get install chromium")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=path, args=["--no-sandbox", *more], timeout=WAIT
        )  # root has none
        yield browser
        browser.close()


def window(browser: Any, **settings: Any) -> Any:
    """Return a new page in a context of its own that waits for what is sure to come."""
    context = browser.new_context(**settings)
    context.set_default_timeout(WAIT)
    return context.new_page()


def pictured(page: Any, number: int = 2) -> None:
    """Wait until a page has drawn so many pictures: with the second, what was asked for before the first is done."""
    page.evaluate(PICTURES, number)


def played(page: Any, seconds: float) -> None:
    """Play a mechanism of a page until its time is past some seconds, and stop it in the picture in which it is."""
    page.evaluate(PLAYED, seconds)
    page.click("[data-do=play]")
    page.wait_for_function("window.isPlayed")


@contextmanager
def opened(browser: Any, what: Path | str, width: int = 1280, scheme: str = "light") -> Iterator[Any]:
    """Yield a page that shows a file, or what a server shows at an address that is its own up to there.

    Afterwards the console must have been silent and nothing fetched from elsewhere.

    All files are shown by one page of one window, one after the other, since a new page starts processes.
    """
    pages = [page for context in browser.contexts[:1] for page in context.pages]
    page = pages[0] if pages else window(browser)
    page.set_viewport_size({"width": width, "height": 800})
    page.emulate_media(media="screen", color_scheme=scheme)
    said: list[str] = []
    address = what.as_uri() if isinstance(what, Path) else what

    def own(url: str) -> bool:
        return url == address if isinstance(what, Path) else url.startswith((address, "data:image/"))

    listeners = {
        "console": lambda message: said.append(message.text),
        "pageerror": lambda fault: said.append(str(fault)),
        "request": lambda request: None if own(request.url) else said.append(request.url),
    }
    for event, listener in listeners.items():
        page.on(event, listener)
    try:
        page.goto(address)
        yield page
    except BaseException:
        page.close()  # whatever it is busy with
        raise
    for event, listener in listeners.items():
        page.remove_listener(event, listener)
    page.goto("about:blank")  # the file's scripts end
    assert not said, said


OVERLAPS = """() => {
  const TEXTS = `h1, h2, h3, p, label, legend, summary, button, select, input, output, th, td, dt, dd, math, svg text,
    .live-unit`;
  const boxes = [...document.querySelectorAll(TEXTS)]
    .filter(element => element.checkVisibility())
    .map(element => {
      const { left, right, top, bottom, width, height } = element.getBoundingClientRect();
      const lead = element.matches("svg text") ? 0.12 * height : 0; // above and below letters of a picture is no ink
      return { element, box: { left, right, top: top + lead, bottom: bottom - lead, width, height } };
    })
    .filter(({ box }) => box.width > 0 && box.height > 0);
  const found = [];
  for (let i = 0; i < boxes.length; i++) {
    for (let j = 0; j < i; j++) {
      const a = boxes[i], b = boxes[j];
      if (a.element.contains(b.element) || b.element.contains(a.element)) continue;
      const wide = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
      const high = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
      if (wide > 1 && high > 1) found.push(`${b.element.outerHTML.slice(0, 90)} | ${a.element.outerHTML.slice(0, 90)}`);
    }
  }
  for (const { element } of boxes) {
    if (!(element instanceof HTMLElement) || element.clientWidth === 0 || element.type === "range") continue;
    const excess = element.scrollWidth - element.clientWidth;
    if (excess > 1) found.push(`${excess} px too much in ${element.outerHTML.slice(0, 90)}`);
  }
  const wide = document.documentElement.scrollWidth;
  if (wide > innerWidth) found.push(`the page is ${wide} px wide, the window ${innerWidth}`);
  return found;
}"""
"""What overlaps in a page or does not fit into its place, and whether it must be scrolled sideways."""


def values(page: Any, kind: str) -> list[float]:
    """Return all values of one kind that the page shows, with all digits, in its order."""
    found: list[str] = page.eval_on_selector_all(f"[data-out={kind}]", "all => all.map(x => x.dataset.value)")
    return [float(x) for x in found]


def move(page: Any, group: str, k: int, value: float) -> None:
    """Type a number as a user does."""
    page.fill(f"input[type=number][data-group={group}][data-k='{k}']", repr(value))


def typed(page: Any, group: str) -> list[float]:
    """Return the numbers in the fields of a group, in their order."""
    found: list[str] = page.eval_on_selector_all(
        f"input[type=number][data-group={group}]", "all => all.map(x => x.value)"
    )
    return [float(x) for x in found]
