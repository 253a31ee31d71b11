"""`symdyn draw SCENE --watch`: follows a file, draws it as it is saved, and serves the page that shows it.

Nothing is written but to the page. A fault is shown once the file has settled, so that one that is just being written
is not called faulty; until then, and as long as it is faulty, the last good picture stays.

Equations of motion as HTML are made in a process of their own, so that a page follows its file while they are derived.
What goes to the process and comes back are pickles, each behind its length in eight bytes. The process hears no Ctrl-C,
ends with its input, and is ended where a newer scene wants its place.
"""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from symdyn.emit import in_html
from symdyn.errors import printable
from symdyn.scene import Scene
from symdyn.watch.server import Board, Drawn, Loaded, PageServer, Show

RACY = 0.1
"""s after a change was seen in which a file may be half written, or be written again under the same time stamp."""

Stamp = tuple[int, int, int]


class EditedFile:
    """A file, followed by its name, so that editors may write it in place or put another in its place."""

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self.path, self._clock = path, clock
        self._stamp, self._content, self._seen = self._looked(), self._read(), clock()

    @property
    def there(self) -> bool:
        """Whether there is such a file."""
        return self._stamp is not None

    @property
    def settled(self) -> bool:
        """Whether no change was seen just now; a file system's own clock may go wrong."""
        return self._clock() - self._seen >= RACY

    def changed(self) -> bool:
        """Tell whether it says something else than when this was last asked; it is read only where it may."""
        stamp = self._looked()
        if stamp == self._stamp and self.settled:
            return False
        if stamp != self._stamp:
            self._stamp, self._seen = stamp, self._clock()
        before, self._content = self._content, self._read()
        return self._content != before

    def _looked(self) -> Stamp | None:
        try:
            found = os.stat(self.path)
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino

    def _read(self) -> bytes | None:
        try:
            with self.path.open("rb") as file:
                return file.read(LARGEST)
        except OSError:
            return None


LARGEST = 2**25
"""Bytes of a file that are compared; no scene is longer."""


LONGEST = 30.0
"""s that equations may take."""


def _send(pipe: IO[bytes], value: Any) -> None:
    data = pickle.dumps(value)
    pipe.write(len(data).to_bytes(8, "big") + data)
    pipe.flush()


def _received(pipe: IO[bytes]) -> Any:
    """Return what the other side sent; EOFError where it has ended."""
    length = pipe.read(8)
    data = pipe.read(int.from_bytes(length, "big")) if len(length) == 8 else b""
    if not data:
        raise EOFError
    return pickle.loads(data)


class EquationsProcess:
    """One process at a time, which derives the equations of the scene that was asked for last."""

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        self._found: list[str] = []
        self._since: float | None = None
        path = [str(Path(__file__).parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "symdyn.watch.watching"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # so that it hears no Ctrl-C
            start_new_session=True,
        )
        threading.Thread(target=_listen, args=(self._process, self._found), daemon=True).start()

    def drop(self) -> bool:
        """Derive no longer what was asked for, so that what comes first has the machine; tell whether anything was."""
        if self._since is None:
            return False
        self.close()
        self._since = None
        return True

    def ask(self, scene: Scene) -> None:
        """Derive the equations of a scene, and of no earlier one."""
        self.drop()
        if self._process.poll() is not None:
            self._start()
        self._since = time.monotonic()
        try:
            assert self._process.stdin is not None, "it is a pipe"
            _send(self._process.stdin, scene)
        except OSError:  # it has ended; `answer` says so
            pass

    def answer(self) -> str | None:
        """Return the equations that were asked for as HTML, or why there are none; None while they are derived."""
        if self._since is None:
            return None
        if self._found:
            self._since = None
            return self._found.pop()
        late = time.monotonic() - self._since > LONGEST
        if not late and self._process.poll() is None:
            return None
        self.close()
        self._start()
        why = f"they take longer than {LONGEST:g} s" if late else "what derives them has ended"
        return f'<p class="note">{in_html(f"no equations: {why}; symdyn equations writes them")}</p>'

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            try:
                if pipe is not None:
                    pipe.close()
            except OSError:  # what it did not read is lost
                pass


def _listen(process: subprocess.Popen[bytes], result: list[str]) -> None:
    assert process.stdout is not None, "it is a pipe"
    try:
        while True:
            result.append(_received(process.stdout))
    except (EOFError, OSError, ValueError):  # it has ended
        return


def html_of(scene: Scene) -> str:
    """Return the equations of motion of a scene as notebooks show them."""
    from symdyn.emit.print import EquationsOfMotion
    from symdyn.notebook import equations_of_motion

    return "\n".join(part.html for part in equations_of_motion(EquationsOfMotion(scene))[1:])


def _work() -> None:
    if hasattr(os, "nice"):
        os.nice(10)  # pictures come first
    while True:
        try:
            scene = _received(sys.stdin.buffer)
        except EOFError:
            return
        try:
            html = html_of(scene)
        except Exception as fault:  # the page says what it was, and goes on
            html = f'<p class="note">{in_html(f"no equations: {fault}")}</p>'
        _send(sys.stdout.buffer, html)


if __name__ == "__main__":
    _work()


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
