"""How soon the page of `symdyn draw --watch` shows what was saved, from the writing to Chromium's picture.

    python benchmarks/watched_file.py [SCENE] [SAVES]

Each save changes one length. The page's own observer says when its picture changed, by the clock that both sides read.
A second passes between saves, in which the equations before are still being derived by another process.
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

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from browser import chromium

SCENE = Path(__file__).parent.parent / "examples" / "puma560.toml"

OBSERVED = """() => { window.changes = [];
new MutationObserver(() => changes.push(performance.timeOrigin + performance.now())).observe(
document.getElementById("picture"), { childList: true }) }"""


def main(scene: Path, saves: int) -> None:
    """Print the milliseconds of every save, the median and the longest."""
    text = scene.read_text(encoding="utf-8")
    lengths = list(re.finditer(r"(?<![\w.])0\.\d*[1-9]\d*", text))
    longest = max(lengths, key=lambda found: float(found[0]))
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        path = Path(folder) / scene.name
        path.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "symdyn", "draw", str(path), "--watch"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert process.stdout is not None, "it is a pipe"
        try:
            page = browser.new_page()
            page.goto(process.stdout.readline().strip())
            page.wait_for_selector("#picture img")
            page.wait_for_selector("#equations math", timeout=60_000)
            page.evaluate(OBSERVED)
            found = []
            for k in range(saves):
                value = f"{float(longest[0]) * (1.01 + k / 100):.6f}"
                changed = text[: longest.start()] + value + text[longest.end() :]
                before, saved = len(page.evaluate("changes")), time.time()
                path.write_text(changed, encoding="utf-8")
                while len(changes := page.evaluate("changes")) == before:
                    time.sleep(0.01)
                found.append(changes[before] - 1000 * saved)
                time.sleep(1.0)
        finally:
            process.kill()
            process.wait()
    print(f"{scene.name}, load of the machine {os.getloadavg()[0]:.1f}")
    print("save -> picture, ms: " + " ".join(f"{one:.0f}" for one in found))
    print(f"median {statistics.median(found):.0f}, longest {max(found):.0f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else SCENE, int(sys.argv[2]) if len(sys.argv) > 2 else 20)
