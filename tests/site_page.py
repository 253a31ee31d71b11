"""The page with Python inside, as any server of files offers it, and a hand on it in a browser."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "docs" / "site" / "playground"))

import bundle  # type: ignore[import-not-found, unused-ignore]

BUILT: Path = bundle.ROOT / "build" / "playground"


@contextmanager
def served(
    instead: Mapping[str, bytes] | None = None, held: Mapping[str, threading.Event] | None = None
) -> Iterator[tuple[str, list[str]]]:
    """Yield the address of the folder that `make playground` writes, and what was asked of it so far.

    Args:
        instead: contents of files in place of theirs.
        held: how names of files begin that nobody is sent before an event.
    """
    if not (BUILT / "manifest.json").is_file():
        pytest.skip("make playground writes what is tested here")
    asked: list[str] = []

    class Files(SimpleHTTPRequestHandler):
        extensions_map = {  # noqa: RUF012  as the class has it
            **SimpleHTTPRequestHandler.extensions_map,
            ".mjs": "text/javascript",
            ".wasm": "application/wasm",
            ".gz": "application/octet-stream",
        }

        def do_GET(self) -> None:
            name = self.path.strip("/").partition("?")[0]
            asked.append(name)
            for begin, event in (held or {}).items():
                if name.startswith(begin):
                    event.wait(60)
            if instead and name in instead:
                self.send_response(200)
                self.send_header("Content-Type", self.guess_type(name))
                self.send_header("Content-Length", str(len(instead[name])))
                self.end_headers()
                self.wfile.write(instead[name])
            else:
                super().do_GET()

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Files, directory=str(BUILT)))
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/", asked
    server.shutdown()


def until(page: Any, true: str, seconds: float = 120.0) -> None:
    """Wait until an expression of a page is true."""
    begun = time.monotonic()
    while not page.evaluate(true):  # the page's policy lets nobody wait inside it
        assert time.monotonic() - begun < seconds, f"{true}: {page.inner_text('#writing')[-800:]}"
        time.sleep(0.02)


def edited(page: Any, text: str) -> None:
    """Write a text, and wait until all of it is shown or a mistake is."""
    until(page, "document.body.dataset.shown")
    before = page.evaluate("document.body.dataset.shown")
    page.fill("#text", text)
    until(page, f"document.body.dataset.shown !== {before!r} || document.querySelectorAll('#faults li').length")


def turned(page: Any, name: str) -> None:
    """Fold a part of the page, or unfold it, by the keyboard."""
    page.focus(f"#d-{name} summary")
    page.keyboard.press("Enter")
