"""Programs that tests start: which there are, where they are, and that no test starts one without saying so.

A test is marked with the programs that it starts, `@pytest.mark.runs("cc")`, and is skipped where one is missing; with
none, `@pytest.mark.runs()`, if it starts only Python. Whatever is not marked cannot start a process: the interpreter
tells of each before it begins. So `pytest --quick`, which leaves marked tests out, needs nothing but Python.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

PROGRAMS: Mapping[str, tuple[str, ...]] = {
    "cc": ("cc", "gcc", "clang"),
    "gcc": ("gcc",),
    "g++": ("g++",),
    "clang": ("clang",),
    "clang++": ("clang++",),
    "rustc": ("rustc",),
    "node": ("node", "nodejs"),
    "chromium": ("chromium", "chromium-browser", "google-chrome", "chrome"),
    "firefox": ("firefox-esr", "firefox"),
    "pdflatex": ("pdflatex",),
    "rsvg-convert": ("rsvg-convert",),
    "pdftoppm": ("pdftoppm",),
    "pdftotext": ("pdftotext",),
    "npm": ("npm",),
    "bash": ("bash",),
    "zsh": ("zsh",),
    "fish": ("fish",),
    "cmake": ("cmake",),
    "octave-cli": ("octave-cli",),
    "maxima": ("maxima",),
    "openssl": ("openssl",),
    "aarch64-gcc": ("aarch64-linux-gnu-gcc",),
    "qemu-aarch64": ("qemu-aarch64", "qemu-aarch64-static"),
}
"""What tests may name, and the commands that are tried for it, in this order."""

STARTS = frozenset({"subprocess.Popen", "os.fork", "os.posix_spawn", "os.system"})
"""Events of the interpreter before a process begins."""

_said = [True]


def path_of(program: str) -> str | None:
    """Return the path of a program of the table, or None."""
    return next((found for name in PROGRAMS[program] if (found := shutil.which(name))), None)


def missing(programs: tuple[str, ...]) -> list[str]:
    """Return those that are not there."""
    return [name for name in programs if path_of(name) is None]


@contextmanager
def starting(said: bool) -> Iterator[None]:
    """Say whether processes may be started for now."""
    before, _said[0] = _said[0], said
    try:
        yield
    finally:
        _said[0] = before


def watch(event: str, details: tuple[Any, ...]) -> None:
    """Refuse a process that a test starts without saying so; for `sys.addaudithook`."""
    if event in STARTS and not _said[0]:
        words = details[1] if event == "subprocess.Popen" else details
        raise AssertionError(
            f"{words} is started: mark the test with @pytest.mark.runs, so that `--quick` leaves it out"
        )


def begin() -> None:
    """Watch from now on."""
    sys.addaudithook(watch)
