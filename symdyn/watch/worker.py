"""Equations of motion as HTML, in a process of their own, so that a page follows its file while they are derived.

What goes to the process and comes back are pickles, each behind its length in eight bytes. The process hears no Ctrl-C,
ends with its input, and is ended where a newer scene wants its place.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import IO, Any

from symdyn.emit import in_html
from symdyn.scene import Scene

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
        """Start the process, which is then ready when it is first asked."""
        self._start()

    def _start(self) -> None:
        self._found: list[str] = []
        self._since: float | None = None
        path = [str(Path(__file__).parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "symdyn.watch.worker"],
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
