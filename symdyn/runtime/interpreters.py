"""The only file that runs Node.js and Octave: generated JavaScript and functions for MATLAB as Python callables.

JavaScript takes one state a call, MATLAB a state or many.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import weakref
from collections.abc import Callable
from math import prod
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Function
from symdyn.emit import Sources, verbatim, write
from symdyn.errors import BuildError, MissingProgram
from symdyn.runtime.cache import check_target
from symdyn.runtime.commands import GNU, waiting

NODE_COMMANDS = ("node", "nodejs")


def find_node() -> str:
    """Return the path of Node.js.

    Raises:
        MissingProgram: there is none.
    """
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
    """Return one function as a callable."""
    scalars = [argument.scalar for argument in function.arguments]

    def call(*values: npt.ArrayLike) -> Any:
        given = [
            {"scalar": scalar, "bytes": np.asarray(value, dtype="<f8").tobytes().hex()}
            for scalar, value in zip(scalars, values, strict=True)
        ]
        found = process.ask({"name": name, "arguments": given})
        return np.frombuffer(bytes.fromhex(found["bytes"]), dtype="<f8").reshape(function.shape)[()]

    return call


class _Node:
    """One Node.js that answers a line with a line."""

    def __init__(self, node: str, text: str) -> None:
        """Start it and load a module; BuildError where it cannot be run or refuses that."""
        command = (node, "--input-type=module", "--eval", verbatim("js/calls.mjs"))
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except OSError as fault:
            raise BuildError(f"{node} cannot be run ({fault.strerror})") from fault
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
    """Return the path of Octave.

    Raises:
        MissingProgram: there is none.
    """
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
    """Return one function as a callable."""
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
    """One Octave that answers calls."""

    def __init__(self, octave: str, sources: Sources) -> None:
        """Write the package where it is found and start Octave; BuildError where it cannot be run."""
        self._folder = TemporaryDirectory()
        self._package = sources.stem
        write(sources, self._folder.name)
        if f"{self._package}_mex.c" in sources:
            compile_mex(self._folder.name, self._package)
        command = (octave, *OPTIONS, "--path", self._folder.name, "--eval", verbatim("matlab/calls.m"))
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except OSError as fault:
            raise BuildError(f"{octave} cannot be run ({fault.strerror})") from fault
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
        return np.frombuffer(_exactly(self._process.stdout, 8 * int(line)), dtype="<f8")


def _exactly(stream: IO[bytes], size: int) -> bytes:
    """Return so many bytes; BuildError where there are fewer."""
    found = stream.read(size)
    if len(found) != size:
        raise BuildError("Octave ended in the middle of an answer")
    return found


def _end(process: subprocess.Popen[bytes], folder: TemporaryDirectory[str]) -> None:
    """Let a process end, which has nothing more to read, and take its files away."""
    process.communicate()
    folder.cleanup()
