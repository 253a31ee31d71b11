"""Programs of others that open .glb files: Khronos' validator in Node.js, and three.js in Chromium.

Both are packages of npm, see `npm_packages`.
"""

from __future__ import annotations

import contextlib
import json
import mimetypes
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from browser import WAIT, window
from npm_packages import packages
from programs import path_of

VIEWERS = Path(__file__).parent / "viewers"
HOST = "http://viewer.invalid"


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
