"""How soon the page of `symdyn play` shows what is written or saved, in Chromium, and what that costs it.

    python benchmarks/playground.py [EDITS]         as `symdyn play` serves it
    python benchmarks/playground.py [EDITS] --site  with Python inside, as `make playground` makes it

Of the site's: how soon the example made beforehand is shown, then Python is there, with nothing kept and with all.

Of each scene: from its example to its equations the first time; from a key to the equations and to the picture, the
150 ms that a hand may rest included; from a save by another program to the picture; the longest task of the page's
main thread; its heap. The clock is the page's own. Beside each median stands the bar, where there is one.
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from browser import chromium

ROOT = Path(__file__).parent.parent
BARS = {"two_link": (50, 100), "four_bar": (200, 200), "puma560": (400, 700)}
"""ms from a text to equations and picture, beside the rest of a hand."""

REST = 150
PORT = "8137"
"""Of the server of files."""

TASK, HEAP = 50, 64
"""ms of the main thread at once; MB."""

OBSERVED = """() => {
  window.changes = {}, window.tasks = [];
  const state = document.getElementById("state"), observed = { childList: true, subtree: true };
  new MutationObserver(() => { if (state.textContent.endsWith(" ms")) changes.equations = performance.now(); })
    .observe(state, observed);
  new MutationObserver(() => { changes.picture = performance.now(); })
    .observe(document.getElementById("picture"), observed);
  new PerformanceObserver(list => tasks.push(...list.getEntries().map(one => one.duration)))
    .observe({ type: "longtask" });
}"""

EDITED = """async value => {
  const field = document.querySelector("#text"), before = document.body.dataset.shown, begun = performance.now();
  changes = {};
  field.value = value;
  field.dispatchEvent(new InputEvent("input", { bubbles: true }));
  while (document.body.dataset.shown === before || !changes.picture) await new Promise(done => setTimeout(done, 5));
  return [changes.equations - begun, changes.picture - begun];
}"""


def lengthened(text: str, by: float) -> str:
    """Return a scene with its longest decimal changed; of one without, with a letter's factor."""
    if '"-h1"' in text:
        return text.replace('"-h1"', f'"-{1 + by}*h1"')
    found = re.finditer(r"(?<![\w.])\d+\.\d*[1-9]\d*", text)
    longest = max(found, key=lambda one: float(one[0]))
    return f"{text[: longest.start()]}{float(longest[0]) * (1 + by):.6f}{text[longest.end() :]}"


def waited(page: Any, true: str) -> None:
    """Wait until an expression of the page is true; its policy lets nobody wait inside it."""
    begun = time.monotonic()
    while not page.evaluate(true):
        assert time.monotonic() - begun < 120, true
        time.sleep(0.005)


def started(browser: Any, address: str) -> None:
    """Print how soon the site's page is there, the first time and again."""
    context = browser.new_context()
    for times in ("the first time", "again"):
        page = context.new_page()
        begun = time.perf_counter()
        page.goto(address)
        waited(page, "document.querySelector('#equations math')")
        example = time.perf_counter() - begun
        waited(page, "document.documentElement.dataset.python")
        python = time.perf_counter() - begun
        page.evaluate(OBSERVED)
        page.evaluate(EDITED, lengthened(page.input_value("#text"), 0.01))
        waited(page, "document.body.dataset.shown > 1")
        first = time.perf_counter() - begun
        print(f"{times}: example {example:.2f} s, Python {python:.2f} s, an edit with picture and code {first:.2f} s")
        page.close()
    context.close()


def edits_of(page: Any, name: str, text: str, edits: int) -> None:
    """Print how soon a page shows edits, and what they cost its main thread."""
    page.evaluate(OBSERVED)
    page.evaluate(EDITED, text + "#")
    typed = [page.evaluate(EDITED, lengthened(text, 0.01 * (k + 1))) for k in range(edits)]
    equations, picture = (statistics.median(one) - REST for one in zip(*typed, strict=True))
    for_equations, for_picture = BARS[name]
    print(f"{name}: edit -> equations {equations:.0f} ms ({for_equations}), picture {picture:.0f} ms ({for_picture})")
    tasks, heap = page.evaluate("tasks"), page.evaluate("performance.memory.usedJSHeapSize") / 2**20
    print(f"  main thread: longest task {max(tasks, default=0):.0f} ms ({TASK}), heap {heap:.0f} MB ({HEAP})")


def site(browser: Any, edits: int) -> None:
    """Print the figures of the page with Python inside."""
    command = [sys.executable, "-m", "http.server", "-b", "127.0.0.1", "-d", str(ROOT / "build" / "playground"), PORT]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(1)
        address = f"http://127.0.0.1:{PORT}/"
        started(browser, address)
        page = browser.new_page()
        page.goto(address)
        waited(page, "document.documentElement.dataset.python")
        for name in BARS:
            edits_of(page, name, (ROOT / "examples" / f"{name}.toml").read_text(encoding="utf-8"), edits)
    finally:
        process.kill()
        process.wait()


def measured(browser: Any, name: str, edits: int) -> None:
    """Print the figures of one example."""
    text = (ROOT / "examples" / f"{name}.toml").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "symdyn", "play", str(path)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert process.stdout is not None, "it is a pipe"
        try:
            page = browser.new_page()
            begun = time.perf_counter()
            page.goto(process.stdout.readline().strip())
            waited(page, "document.querySelector('#equations math')")
            first = time.perf_counter() - begun
            waited(page, "document.body.dataset.shown")
            print(f"{name}: first equations {first:.2f} s")
            edits_of(page, name, text, edits)
            page.evaluate(EDITED, text)
            saved = []
            for k in range(edits):
                before = page.evaluate("changes = {}, document.body.dataset.shown")
                written = time.time()
                path.write_text(lengthened(text, 0.01 * (k + 1)), encoding="utf-8")
                waited(page, f"document.body.dataset.shown !== {before!r} && changes.picture")
                saved.append(page.evaluate("changes.picture + performance.timeOrigin") - 1000 * written)
            page.close()
        finally:
            process.kill()
            process.wait()
    print(f"  save -> picture {statistics.median(saved):.0f} ms, longest {max(saved):.0f}")


def main(edits: int, inside: bool) -> None:
    """Print the figures of all."""
    size = sum(one.stat().st_size for one in (ROOT / "templates" / "playground").iterdir() if one.is_file())
    print(f"the page: {size / 1000:.0f} kB; load of the machine {os.getloadavg()[0]:.1f}")
    with chromium() as browser:
        if inside:
            site(browser, edits)
        for name in () if inside else BARS:
            measured(browser, name, edits)


if __name__ == "__main__":
    numbers = [int(one) for one in sys.argv[1:] if one.isdigit()]
    main(numbers[0] if numbers else 11, "--site" in sys.argv)
