"""`symdyn draw SCENE --watch`: follows a file, draws it as it is saved, and serves the page that shows it.

Nothing is written but to the page. A fault is shown once the file has settled, so that one that is just being
written is not called faulty; until then, and as long as it is faulty, the last good picture stays.
"""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symdyn.errors import printable
from symdyn.scene import Scene
from symdyn.watch.file import EditedFile
from symdyn.watch.server import Board, PageServer
from symdyn.watch.sheet import Drawn, Loaded, Show
from symdyn.watch.worker import EquationsProcess

LOOKED = 0.02
"""s between looks at the file."""

CALM = 0.4
"""s without a change after which equations are derived."""

DERIVED = '<p class="note">being derived …</p>'


class Watched:
    """A file and its page."""

    def __init__(
        self, path: Path, load: Callable[[], Loaded], draw: Drawn, at: dict[str, float] | None = None, port: int = 0
    ) -> None:
        """Read and draw the file, and listen; see `watch`."""
        self._name = printable(path.name, keep="")
        self._file, self._show, self._board = EditedFile(path), Show(self._name, load, draw, at or {}), Board()
        self._lock, self._unsettled = threading.RLock(), False
        self._derived: Scene | None = None
        self._changed = 0.0
        self._equations = EquationsProcess()
        self._server = PageServer(self._name, self._board, self._pulled, port)
        self.address = self._server.address
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True).start()
        self._read()

    def look(self) -> None:
        """Look at the file once, and at what is being derived."""
        if self._file.changed():
            self._unsettled, self._changed = True, time.monotonic()
            if self._equations.drop():
                self._derived = None
            self._read()
        elif self._unsettled and self._file.settled:
            self._read()
        scene = self._show.scene
        if scene is not self._derived and scene is not None and time.monotonic() - self._changed > CALM:
            self._derived = scene
            self._equations.ask(scene)
        answer = self._equations.answer()
        if answer is not None:
            self._board.put("equations", answer)

    def close(self) -> None:
        """End the server and the process."""
        self._board.close()
        self._server.shutdown()
        self._server.server_close()
        self._equations.close()

    def _read(self) -> None:
        """Show what the file says; a fault of a file that was written just now waits until it has settled."""
        with self._lock:
            before = self._show.sheet
            if self._file.there:
                self._show.read()
            else:
                self._show.gone(f"{self._name}: is not there; the page waits for it")
            if self._show.sheet.faults and not self._file.settled and before.picture:
                self._show.sheet, self._unsettled = before, True
                return
            self._unsettled = False
            self._tell()
            if self._show.scene is not self._derived:
                self._board.put("equations", DERIVED)

    def _pulled(self, sent: dict[str, Any]) -> None:
        with self._lock:
            if "back" in sent:
                self._show.back()
            else:
                self._show.pull(sent["name"], float(sent["value"]))
            self._tell()

    def _tell(self) -> None:
        self._board.put("sheet", dataclasses.asdict(self._show.sheet))


def watch(
    path: Path,
    load: Callable[[], Loaded],
    draw: Drawn,
    opened: Callable[[str], None],
    at: dict[str, float] | None = None,
) -> None:
    """Serve the page of a file until Ctrl-C.

    Args:
        path: the file.
        load: reads it; returns the scene, and what its reader notes.
        draw: returns the picture of a scene at q, shape (nq,), and values of all its parameters, as SVG.
        opened: takes the address of the page.
        at: coordinates where the picture begins.

    Raises:
        KeyboardInterrupt: on Ctrl-C, when all has ended.
    """
    found = Watched(path, load, draw, at)
    try:
        opened(found.address)
        while True:
            time.sleep(LOOKED)
            found.look()
    finally:
        found.close()
