"""What this machine has to compile, run and show what is generated, and what one does without where it is missing.

The only file that runs Node.js and Octave: generated JavaScript and functions for MATLAB as Python callables.
JavaScript takes one state a call, MATLAB a state or many.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import weakref
from collections.abc import Callable, Mapping, Sequence
from math import prod
from os import W_OK, access
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Function
from symdyn.emit import Sources, verbatim, write
from symdyn.errors import BuildError, MissingProgram, printable
from symdyn.runtime.cache import cache_folder, check_target, distrust
from symdyn.runtime.commands import GNU, waiting
from symdyn.runtime.compiler import CPLUSPLUS, RUSTC, find_compiler, try_compiler
from symdyn.runtime.library import python_headers

NODE_COMMANDS = ("node", "nodejs")


def find_node() -> str:
    """Return the path of Node.js; MissingProgram where there is none."""
    return _find("Node.js", NODE_COMMANDS, "nodejs")


def _find(program: str, commands: tuple[str, ...], package: str) -> str:
    for name in commands:
        path = shutil.which(name)
        if path is not None:
            return path
    tried = ", ".join(commands)
    raise MissingProgram(f"no {program} found (tried {tried}); install it, `apt-get install {package}` for one")


def run_js(sources: Sources) -> SimpleNamespace:
    """Return the functions of sources that `emit(program, "js")` made, running in a Node.js of their own.

    Each is an attribute and takes one state, arrays of shape (n,). Node.js ends when no function is used any longer.

    Raises:
        BuildError: sources of another target, or Node.js's own words where it refuses them.
        MissingProgram: there is no Node.js.
    """
    check_target(sources, "js")
    process = _Node(find_node(), next(iter(sources.texts.values())))
    named = zip(sources.functions, sources.program.routines, strict=True)
    return SimpleNamespace(**{name: _of_node(process, name, routine.function) for name, routine in named})


def _of_node(process: _Node, name: str, function: Function) -> Callable[..., Any]:
    scalars = [argument.scalar for argument in function.arguments]

    def call(*values: npt.ArrayLike) -> Any:
        given = [
            {"scalar": scalar, "bytes": np.asarray(value, dtype="<f8").tobytes().hex()}
            for scalar, value in zip(scalars, values, strict=True)
        ]
        found = process.ask({"name": name, "arguments": given})
        return np.frombuffer(bytes.fromhex(found["bytes"]), dtype="<f8").reshape(function.shape)[()]

    return call


def _started(command: Sequence[str]) -> subprocess.Popen[bytes]:
    """Return a process that is asked by a pipe and answers by another; BuildError where it cannot be run."""
    try:
        return subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
        )
    except OSError as fault:
        raise BuildError(f"{command[0]} cannot be run ({fault.strerror})") from fault


class _Node:
    def __init__(self, node: str, text: str) -> None:
        """Start it and load a module; BuildError where it cannot be run or refuses that."""
        command = (node, "--input-type=module", "--eval", verbatim("js/calls.mjs"))
        self._process = _started(command)
        weakref.finalize(self, self._process.communicate)  # there is nothing more to read, so that it ends
        self.ask(text)

    def ask(self, words: Any) -> dict[str, Any]:
        """Return the answer to a line. Whoever is interrupted meanwhile has no Node.js any more.

        Raises:
            BuildError: Node.js answers with a fault, or has ended.
        """
        assert self._process.stdin is not None, "it was given a pipe"
        assert self._process.stdout is not None, "it was given a pipe"
        try:
            with waiting(self._process):
                self._process.stdin.write(json.dumps(words).encode() + b"\n")
                self._process.stdin.flush()
                line = self._process.stdout.readline()
        except OSError:
            line = b""
        if not line:
            raise BuildError("Node.js ended without an answer; it must be version 15 or later")
        answer: dict[str, Any] = json.loads(line)
        if "fault" in answer:
            raise BuildError(f"Node.js refused the code: {answer['fault']}")
        return answer


OCTAVE_COMMANDS = ("octave-cli", "octave")

CFLAGS = " ".join((*(flag for flag in GNU.flags if flag != "-shared"), "-march=native"))

OPTIONS = ("--quiet", "--norc", "--no-history", "--no-window-system")


def find_octave() -> str:
    """Return the path of Octave; MissingProgram where there is none."""
    return _find("Octave", OCTAVE_COMMANDS, "octave")


def run_matlab(sources: Sources) -> SimpleNamespace:
    """Return the functions of sources that `emit(program, "matlab")` made, running in an Octave of their own.

    Each is an attribute and takes arrays of shape (n,) or (..., n), whose leading dimensions broadcast and are columns
    there. Octave ends when no function is used any longer.

    Raises:
        BuildError: sources of another target, or Octave's own words where it refuses them.
        MissingProgram: there is no Octave.
    """
    check_target(sources, "matlab")
    process = _Octave(find_octave(), sources)
    named = zip(sources.functions, sources.program.routines, strict=True)
    return SimpleNamespace(**{name: _of_octave(process, name, routine.function) for name, routine in named})


def compile_mex(folder: str, package: str) -> None:
    """Compile the C of sources with option "mex" where it lies.

    Raises:
        BuildError: what the compiler says.
        MissingProgram: there is no mkoctfile, which comes with the headers of Octave.
    """
    program = shutil.which("mkoctfile")
    if program is None:
        raise MissingProgram("no mkoctfile found; install it, `apt-get install octave-dev` for one")
    process = subprocess.Popen(
        [program, "--mex", f"{package}_mex.c", f"{package}.c"], cwd=folder, env=os.environ | {"CFLAGS": CFLAGS},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    with waiting(process):
        said = b"".join(process.communicate()[::-1]).decode(errors="replace")
    if process.returncode:
        raise BuildError(f"mkoctfile refused the code: {said}")


def _of_octave(process: _Octave, name: str, function: Function) -> Callable[..., Any]:
    scalars = [argument.scalar for argument in function.arguments]

    def call(*values: npt.ArrayLike) -> Any:
        arrays = [
            np.asarray(value, dtype="<f8")[..., None] if scalar else np.asarray(value, dtype="<f8")
            for scalar, value in zip(scalars, values, strict=True)
        ]
        batch = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
        given = [
            np.broadcast_to(array, batch + array.shape[-1:] if array.ndim > 1 else array.shape) for array in arrays
        ]
        found = process.ask(name, [array.reshape(prod(array.shape[:-1]), array.shape[-1]) for array in given])
        pages = found.reshape((*batch, *function.shape[::-1]))
        own = range(pages.ndim - 1, len(batch) - 1, -1)
        return np.ascontiguousarray(pages.transpose(*range(len(batch)), *own))[()]

    return call


class _Octave:
    def __init__(self, octave: str, sources: Sources) -> None:
        """Write the package where it is found and start Octave; BuildError where it cannot be run."""
        self._folder = TemporaryDirectory()
        self._package = sources.stem
        write(sources, self._folder.name)
        if f"{self._package}_mex.c" in sources:
            compile_mex(self._folder.name, self._package)
        command = (octave, *OPTIONS, "--path", self._folder.name, "--eval", verbatim("matlab/calls.m"))
        self._process = _started(command)
        weakref.finalize(self, _end, self._process, self._folder)

    def ask(self, name: str, arrays: list[npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
        """Return what a function gives for arguments of shape (states, n), a row each, in the order of their memory.

        Whoever is interrupted meanwhile has no Octave any more.

        Raises:
            BuildError: Octave answers with a fault, or has ended.
        """
        with waiting(self._process):
            return self._answer(name, arrays)

    def _answer(self, name: str, arrays: list[npt.NDArray[np.float64]]) -> npt.NDArray[np.float64]:
        assert self._process.stdin is not None, "it was given a pipe"
        assert self._process.stdout is not None, "it was given a pipe"
        sizes = [str(length) for array in arrays for length in array.shape[::-1]]
        try:
            self._process.stdin.write(" ".join([f"{self._package}.{name}", *sizes]).encode() + b"\n")
            for array in arrays:
                self._process.stdin.write(array.tobytes())
            self._process.stdin.write(b"\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline().decode(errors="replace").strip()
        except OSError:
            line = ""
        if not line:
            raise BuildError("Octave ended without an answer; it must be version 7 or later")
        if not line.isdecimal():
            raise BuildError(f"Octave refused the code: {line}")
        size = 8 * int(line)
        found = self._process.stdout.read(size)
        if len(found) != size:
            raise BuildError("Octave ended in the middle of an answer")
        return np.frombuffer(found, dtype="<f8")


def _end(process: subprocess.Popen[bytes], folder: TemporaryDirectory[str]) -> None:
    """Let a process end, which has nothing more to read, and take its files away."""
    process.communicate()
    folder.cleanup()


PROGRAMS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "LaTeX": (("pdflatex",), "walkthrough writes no PDF"),
    "C++ compiler": (CPLUSPLUS.candidates, "verify measures no C++, which is written all the same"),
    "Rust compiler": (RUSTC.candidates, "verify measures no Rust, which is written all the same"),
    "Node.js": (NODE_COMMANDS, "verify runs no JavaScript, which is written all the same"),
    "Octave": (OCTAVE_COMMANDS, "verify measures no MATLAB, which is written all the same"),
    "Chromium": (
        ("chromium", "chromium-browser", "google-chrome", "chrome"),
        "nothing: only tests of pages run it, and any browser shows them",
    ),
}
"""Programs by title: their commands, and what one does without."""

NO_COMPILER = "load, lambdify and simulate run the NumPy module: the same results, slower; verify measures no C"
NO_HEADERS = "load runs the NumPy module: the same results, slower"


def here() -> dict[str, Any]:
    """Return the compiler of C, Python's headers, the cache and programs as plain values; nothing is made."""
    programs = [_program(title, *row) for title, row in PROGRAMS.items()]
    return {"compiler": _compiler(), "headers": _headers(), "cache": _cache(), "programs": programs}


def _program(title: str, commands: tuple[str, ...], without: str) -> dict[str, Any]:
    """Return where a program is, or what one does without."""
    path = next((found for command in commands if (found := shutil.which(command))), None)
    return {"name": title, "path": path, "without": None if path else without}


def _compiler() -> dict[str, Any]:
    """Return the compiler, whether it compiles, and what one does without one that does."""
    facts: dict[str, Any] = {"command": None, "version": None, "works": False, "why": None, "without": NO_COMPILER}
    try:
        compiler = find_compiler()
        facts |= {
            "command": " ".join(compiler.command),
            "version": printable(next(iter(compiler.version.splitlines()), "")),
        }
        try_compiler(compiler)
    except (BuildError, OSError) as fault:
        return facts | {"why": str(fault).splitlines()[0]}
    return facts | {"works": True, "without": None}


def _headers() -> dict[str, Any]:
    try:
        return {"folder": python_headers(), "why": None, "without": None}
    except BuildError as fault:
        return {"folder": None, "why": str(fault), "without": NO_HEADERS}


def _cache() -> dict[str, Any]:
    """Return the folder of compiled code, whether it is safe, and how much is there; nothing is made or changed."""
    folder = cache_folder()
    facts: dict[str, Any] = {"folder": str(folder), "safe": True, "why": None, "entries": 0, "bytes": 0}
    try:
        if not folder.exists():
            above = next(one for one in folder.parents if one.exists())
            if not above.is_dir() or not access(above, W_OK):
                return facts | {"safe": False, "why": f"it is not there, and you may not write to {above}"}
            return facts | {"why": "is made when something is compiled"}
        reason = distrust(folder.stat()) or ("" if access(folder, W_OK) else "you may not write there")
        reason = reason if folder.is_dir() else "it is no folder"
        sizes = [path.lstat().st_size for path in folder.iterdir()] if folder.is_dir() else []
    except OSError as fault:
        return facts | {"safe": False, "why": fault.strerror or str(fault)}
    return facts | {"safe": not reason, "why": reason or None, "entries": len(sizes), "bytes": sum(sizes)}
