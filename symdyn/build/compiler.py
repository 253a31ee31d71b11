"""The only file that runs a compiler: finding one, asking who it is, compiling one source into a shared library."""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from symdyn.errors import BuildError, MissingCompiler

CANDIDATES = ("cc", "gcc", "clang")

FLAGS = ("-O2", "-fPIC", "-shared", "-ffp-contract=fast")
"""No -std=c99 here: as a build flag it turns fused multiply-add off. And never -ffast-math, which breaks NaN."""

PATIENCE = 300.0
"""Seconds that one compilation may take."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the words of its command line, and what it says about itself."""

    command: tuple[str, ...]
    version: str


def find_compiler(wanted: str | None = None) -> Compiler:
    """Return the compiler to use: `wanted`, else $CC, else cc, gcc, clang, else the one in the ziglang package.

    Raises:
        BuildError: the one that was asked for is not there.
        MissingCompiler: there is none at all.
    """
    asked = wanted or os.environ.get("CC", "").strip()
    if asked:
        origin = "compiler" if wanted else "the environment variable CC"
        try:
            words = shlex.split(asked)
        except ValueError as fault:
            raise BuildError(f"{origin} = {asked} is no command line ({fault}); {_ways_out()}") from fault
        if shutil.which(words[0]) is None:
            raise BuildError(f"{origin} = {asked}: there is no such program; {_ways_out()}")
        return _known(tuple(words))
    for name in CANDIDATES:
        path = shutil.which(name)
        if path is not None:
            return _known((path,))
    if find_spec("ziglang") is not None:
        return _known((sys.executable, "-m", "ziglang", "cc"))
    tried = f"$CC, {', '.join(CANDIDATES)} and the ziglang package"
    raise MissingCompiler(f"no C compiler found (tried {tried}); {_ways_out()}")


def _ways_out() -> str:
    return (
        "install one (`pip install ziglang` will do), or use the NumPy module, which needs none: "
        "`symdyn generate SCENE --target numpy`"
    )


@cache
def _known(command: tuple[str, ...]) -> Compiler:
    """Return the compiler behind a command line; its version text is asked for once a process."""
    _, words = _run((*command, "--version"), patience=30.0)
    return Compiler(command, words)


def compile_library(compiler: Compiler, source: Path, library: Path, patience: float = PATIENCE) -> None:
    """Compile one C file into a shared library.

    Raises:
        BuildError: the compiler refuses, says nothing for `patience` seconds, or leaves no library behind.
    """
    command = (*compiler.command, *FLAGS, str(source), "-o", str(library), "-lm")
    code, words = _run(command, patience)
    shown = shlex.join(compiler.command)
    if code is None:
        raise BuildError(f"{shown} did not finish {source.name} within {patience:g} s and was stopped; {_ways_out()}")
    if code != 0 or not library.is_file():
        said = words.strip() or "(it said nothing)"
        raise BuildError(f"{shown} could not compile {source.name} (exit {code}):\n{said}\n{_ways_out()}")


def _run(command: Sequence[str], patience: float) -> tuple[int | None, str]:
    """Run a command and return its exit code (None: it had to be stopped) and all it said.

    Words go to a file and the command gets a process group of its own, so that a compiler which hangs, or whose
    children do, is stopped and waits for nobody.
    """
    with tempfile.TemporaryFile() as words:
        try:
            process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=words, stderr=words, start_new_session=True
            )
        except OSError as fault:
            raise BuildError(f"{shlex.join(command)} cannot be run ({fault.strerror}); {_ways_out()}") from fault
        code: int | None
        try:
            code = process.wait(patience)
        except subprocess.TimeoutExpired:
            _stop(process)
            code = None
        words.seek(0)
        return code, words.read().decode(errors="replace")


def _stop(process: subprocess.Popen[bytes]) -> None:
    """End a process together with its children."""
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()
