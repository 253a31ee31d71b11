"""Programs of others that open .glb files: Khronos' validator in Node.js, and three.js in Chromium.

Both are packages of npm, installed once into build/npm by these versions; a test that needs them is skipped where npm
is missing or reaches no registry.
"""

from __future__ import annotations

import contextlib
import json
import mimetypes
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from browser import WAIT, window
from patience import HANG
from programs import path_of

ROOT = Path(__file__).parent.parent
PACKAGES = {"gltf-validator": "2.0.0-dev.3.10", "three": "0.187.0"}
VIEWERS = Path(__file__).parent / "viewers"
HOST = "http://viewer.invalid"


def packages() -> Path:
    """Return the folder of the packages, which are installed if they are missing."""
    import fcntl  # not on Windows, where nobody has asked for them yet

    place = ROOT / "build" / "npm"
    there = place / "node_modules"
    place.parent.mkdir(exist_ok=True)
    with open(place.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several workers may come here at once
        _installed(place)
    return there


def _installed(place: Path) -> None:
    """Install the packages where they are missing; the test is skipped where that cannot be."""
    versions = {name: place / "node_modules" / name / "package.json" for name in PACKAGES}
    if all(path.is_file() and json.loads(path.read_text())["version"] == PACKAGES[name]
           for name, path in versions.items()):  # fmt: skip
        return
    npm = path_of("npm")
    if npm is None:
        pytest.skip("there is no npm; apt-get install npm")
    with tempfile.TemporaryDirectory(dir=place.parent) as aside:
        words = [npm, "install", "--prefix", aside, "--no-audit", "--no-fund", "--no-save", "--ignore-scripts"]
        words += [f"{name}@{version}" for name, version in PACKAGES.items()]
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=HANG)
        if done.returncode:
            pytest.skip(f"npm installs no {', '.join(PACKAGES)}: {done.stderr.strip().splitlines()[-1:]}")
        shutil.rmtree(place, ignore_errors=True)
        Path(aside).rename(place)
        Path(aside).mkdir()


def validated(paths: Sequence[Path]) -> dict[Path, dict[str, Any]]:
    """Return what Khronos' validator says of files: "issues" and "info"."""
    node = path_of("node")
    assert node is not None, "who asks is marked with node"
    words = [node, str(VIEWERS / "validate.mjs"), str(packages()), *map(str, paths)]
    told = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout)
    return {path: told[str(path)] for path in paths}


@contextlib.contextmanager
def viewer() -> Iterator[Any]:
    """Yield a page that shows files by three.js: see `shown`."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra dev)")
    there = packages()
    drawing = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]

    def answer(route: Any) -> None:
        path = route.request.url.removeprefix(HOST)
        if path == "/":
            file = VIEWERS / "viewer.html"
        else:
            file = there / path[1:] if path.startswith("/three/") else Path(path.removeprefix("/file"))
        kind = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
        route.fulfill(body=file.read_bytes(), content_type=kind)

    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path_of("chromium"), args=drawing, timeout=WAIT)
        page = window(browser, viewport={"width": 320, "height": 240})
        page.route(f"{HOST}/**", answer)
        page.goto(f"{HOST}/")
        page.wait_for_function("window.ready")
        yield page
        browser.close()


def shown(page: Any, path: Path, times: Sequence[float]) -> tuple[dict[str, Any], list[tuple[bytes, dict[str, Any]]]]:
    """Return what is in a file, and at each time the picture as PNG and where every node is, in the viewer's axes."""
    about = page.evaluate(f"open_file({json.dumps(f'{HOST}/file{path}')})")
    return about, [(_pictured(page, t), page.evaluate(f"show({t})")) for t in times]


def _pictured(page: Any, t: float) -> bytes:
    page.evaluate(f"show({t})")
    return page.screenshot()
