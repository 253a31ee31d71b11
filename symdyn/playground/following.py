"""`symdyn play`: serves the playground to this machine, and follows the file that is written on it.

A file that another program saves is shown once it has settled, so that none is shown that is half written. What the
page asks is answered in a process of its own, one question after the other; what takes too long is ended with the
process, and so is what nobody waits for any longer. What goes there and comes back are texts of JSON, one a line. The
process hears no Ctrl-C and ends with its input.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from symdyn.emit import write
from symdyn.errors import SymdynError, printable
from symdyn.playground.answers import Settings, answer
from symdyn.playground.server import Board, PageServer

RACY = 0.1
"""s after a change was seen in which a file may be half written, or be written again under the same time stamp."""

Stamp = tuple[int, int, int]


class EditedFile:
    """A file, followed by its name, so that editors may write it in place or put another in its place."""

    def __init__(self, path: Path, clock: Callable[[], float] = time.monotonic) -> None:
        self.path, self._clock = path, clock
        self._stamp, self._content, self._seen = self._looked(), self._read(), clock()

    @property
    def content(self) -> bytes:
        """What it says; nothing where it is not there."""
        return self._content or b""

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


LONGEST = 60.0
"""s that an answer may take."""


class AnsweringProcess:
    """One process at a time, which answers one question at a time."""

    def __init__(self, settings: Settings) -> None:
        self._settings, self._turn, self._lock = settings, threading.Lock(), threading.Lock()
        self._process = self._started()

    def _started(self) -> subprocess.Popen[str]:
        path = [str(Path(__file__).parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "symdyn.playground.following"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # so that it hears no Ctrl-C
            start_new_session=True,
        )
        assert process.stdin is not None, "it is a pipe"
        process.stdin.write(json.dumps(dataclasses.asdict(self._settings)) + "\n")
        process.stdin.flush()
        return process

    def ask(self, sent: dict[str, Any]) -> bytes:
        """Return the answer as JSON; why there is none where it took too long, or was stopped."""
        with self._turn:
            with self._lock:
                process = self._process = self._started() if self._process.poll() is not None else self._process
            assert process.stdin is not None and process.stdout is not None, "they are pipes"  # noqa: PT018
            late = threading.Timer(LONGEST, process.kill)
            late.daemon = True
            begun = time.monotonic()
            late.start()
            try:
                process.stdin.write(json.dumps(sent) + "\n")
                process.stdin.flush()
                line = process.stdout.readline()
            except OSError:  # it has ended
                line = ""
            finally:
                late.cancel()
            if line:
                return line.encode()
            process.wait()
            took = time.monotonic() - begun
            why = f"it takes longer than {LONGEST:g} s" if took > LONGEST else "it was stopped"
            return json.dumps({"refused": [f"no answer: {why}; the command line has no such limit"]}).encode()

    def stop(self) -> None:
        """End the process; the next question begins another one."""
        with self._lock:
            self._process.kill()

    def close(self) -> None:
        """End the process."""
        self.stop()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            try:
                if pipe is not None:
                    pipe.close()
            except OSError:  # what it did not read is lost
                pass


def _work() -> None:
    said = json.loads(sys.stdin.readline())
    lists = {"at": tuple(map(tuple, said["at"])), "view": said["view"] and tuple(said["view"])}
    known = Settings(**{**said, **lists, "labels": tuple(said["labels"])})
    for line in sys.stdin:
        print(json.dumps(answer(**json.loads(line), settings=known)), flush=True)


if __name__ == "__main__":
    sys.stdin.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    _work()


LOOKED = 0.02
"""s between looks at the file."""


class Played:
    """The page, and the file that it follows, if there is one."""

    def __init__(
        self,
        path: Path | None = None,
        text_of: Callable[[], str] | None = None,
        settings: Settings = Settings(),  # noqa: B008  frozen
        port: int = 0,
    ) -> None:
        """Read the file and listen; see `play`."""
        self._path, self._text_of, self._board = path, text_of, Board()
        self._file = EditedFile(path) if path else None
        self._process = AnsweringProcess(settings)
        self._unsettled = False
        self._server = PageServer(self._board, self, port)
        self.address = self._server.address
        self._tell()
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True).start()

    def ask(self, sent: dict[str, Any]) -> bytes:
        """Return the answer, as JSON."""
        return self._process.ask(sent)

    def stop(self) -> None:
        """Answer no longer what is being answered."""
        self._process.stop()

    def save(self, text: str, before: str) -> dict[str, Any]:
        """Write the file, if it says what it said before; else nothing, and why."""
        if self._path is None or self._text_of is not None:
            return {"refused": ["there is no file to write; save it under a name"]}
        try:
            now = self._path.read_text(encoding="utf-8") if self._path.exists() else before
            if now != before:
                return {"refused": [f"{self._path.name} says something else by now; nothing was written"]}
            write({self._path.name: text}, self._path.parent)
        except (OSError, UnicodeError, SymdynError) as fault:
            return {"refused": [printable(f"{self._path.name}: {fault}", keep="")]}
        return {"saved": self._path.name}

    def look(self) -> None:
        """Look at the file once."""
        if self._file is None:
            return
        self._unsettled |= self._file.changed()
        if self._unsettled and self._file.settled:
            self._unsettled = False
            self._tell()

    def _tell(self) -> None:
        """Tell the page what the file says, or why it says nothing."""
        if self._file is None or self._path is None:
            self._board.put("file", None)
            return
        told: dict[str, Any] = {"name": printable(self._path.name, keep=""), "own": self._text_of is None}
        try:
            if not self._file.there:
                raise SymdynError("is not there; the page waits for it")
            told["text"] = self._text_of() if self._text_of else self._file.content.decode("utf-8")
        except UnicodeDecodeError as fault:
            told["refused"] = [f"byte {fault.start} is not UTF-8; save the file as UTF-8 text"]
        except SymdynError as fault:
            told["refused"] = str(fault).splitlines()
        self._board.put("file", told)

    def close(self) -> None:
        """End the server and the process."""
        self._board.close()
        self._server.shutdown()
        self._server.server_close()
        self._process.close()


def play(
    path: Path | None,
    text_of: Callable[[], str] | None,
    settings: Settings,
    opened: Callable[[str], None],
) -> None:
    """Serve the page until Ctrl-C.

    Args:
        path: the file that it begins with and follows; None for none.
        text_of: returns the TOML of a file that the page does not write; None for a file that is shown as it is.
        settings: how scenes are read and drawn.
        opened: takes the address of the page.

    Raises:
        KeyboardInterrupt: on Ctrl-C, when all has ended.
    """
    found = Played(path, text_of, settings)
    try:
        opened(found.address)
        while True:
            time.sleep(LOOKED)
            found.look()
    finally:
        found.close()
