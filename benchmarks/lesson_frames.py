"""How long a picture of a moving lesson takes in Chromium: script, style and layout, in milliseconds.

    python benchmarks/lesson_frames.py                      the pages of loops, everything shown, beside the goal
    python benchmarks/lesson_frames.py examples/two_link.toml --show velocities,trails --seconds 5

The page is the lesson as `symdyn walkthrough --format html --exercises` writes it; its mechanism plays while the
browser records its own timeline. A picture lasts from one animation frame to the next; what it costs is what the main
thread ran in scripts, style and layout in between, in time of its thread, which other work of the machine does not
lengthen. The goal is 8 ms at the 95th percentile: half of a picture at 60 a second.
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
from pathlib import Path

from symdyn.emit.code import stem
from symdyn.scene import read
from symdyn.teach import walkthrough
from symdyn.teach.practice.exercises import with_exercises
from symdyn.teach.render.html import html_page

ROOT = Path(__file__).parent.parent
LOOPS = [ROOT / f"examples/{name}.toml" for name in ("four_bar", "slider_crank", "governor")]
GOAL = 8.0
"""Milliseconds, at the 95th percentile."""
SHOWN = "velocities,accelerations,weights,inertia,coriolis,centrifugal,trails,angles,energies,plots,phase"
COSTS = ("FireAnimationFrame", "UpdateLayoutTree", "Layout", "TimerFire", "EventDispatch")
CATEGORIES = ["devtools.timeline", "blink", "v8"]


def pictures(page: Path, name: str, shown: list[str], seconds: float) -> list[float]:
    """Return what each picture cost, ms, while a lesson's page plays."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1280, "height": 800})
        tab.goto(page.as_uri())
        tab.evaluate(f"words => symdyn.{name}.show(words)", shown)
        tab.eval_on_selector("[data-do=play]", "button => button.click()")
        tab.wait_for_timeout(1000)  # what is compiled once is not a picture
        browser.start_tracing(page=tab, categories=CATEGORIES)
        tab.wait_for_timeout(1000 * seconds)
        events = json.loads(browser.stop_tracing())["traceEvents"]
        browser.close()
    return costs(events)


def costs(events: list[dict[str, object]]) -> list[float]:
    """Return the sum of script, style and layout from each animation frame to the next, ms."""
    threads = [one["tid"] for one in events if one.get("name") == "FireAnimationFrame"]
    main = max(set(threads), key=threads.count)
    spans = sorted(
        (float(str(one["tts"])), float(str(one.get("tdur", 0))), str(one["name"]))
        for one in events
        if one.get("tid") == main and one.get("ph") == "X" and one.get("name") in COSTS and "tts" in one
    )
    found: list[float] = []
    end = 0.0
    for at, lasts, name in spans:
        if name == "FireAnimationFrame" and at >= end:
            found.append(0.0)
        if found:
            found[-1] += max(0.0, at + lasts - max(at, end)) / 1000
        end = max(end, at + lasts)
    return found[:-1]


def main() -> None:
    """Print quantiles."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path, default=LOOPS, help="scene files; of loops when left out")
    parser.add_argument("--show", default=SHOWN, help="words of what the figure shows, with commas between")
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    for path in options.scenes:
        print(measured(path, options.show.split(","), options.seconds))


def measured(path: Path, shown: list[str], seconds: float) -> str:
    """Return what a scene's page costs a picture, in words."""
    scene = read(path)
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "lesson.html"
        page.write_text(html_page(with_exercises(walkthrough(scene))), encoding="utf-8")
        size = page.stat().st_size
        found = sorted(pictures(page, stem(scene.name), shown, seconds))
    half, most = found[len(found) // 2], found[int(0.95 * len(found))]
    kept = f"goal {GOAL:g} ms {'kept' if most <= GOAL else 'missed'}"
    numbers = f"{len(found)} pictures, median {half:.1f} ms, 95 % within {most:.1f} ms"
    return f"{scene.name}: {numbers}, {kept}, page {size / 1e6:.2f} MB"


if __name__ == "__main__":
    main()
