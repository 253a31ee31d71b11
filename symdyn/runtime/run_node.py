"""The only file that runs Node.js: generated JavaScript as Python callables, one state a call."""

from __future__ import annotations

import json
import shutil
import subprocess
import weakref
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Function
from symdyn.emit import Sources, verbatim
from symdyn.errors import BuildError, MissingProgram
from symdyn.runtime.cache import check_target
from symdyn.runtime.commands import waiting

NODE_COMMANDS = ("node", "nodejs")


def find_node() -> str:
    """Return the path of Node.js.

    Raises:
        MissingProgram: there is none.
    """
    for name in NODE_COMMANDS:
        path = shutil.which(name)
        if path is not None:
            return path
    raise MissingProgram(
        f"no Node.js found (tried {', '.join(NODE_COMMANDS)}); install it, `apt-get install nodejs` for one"
    )


def run_js(sources: Sources) -> SimpleNamespace:
    """Return the functions of sources that `emit(program, "js")` made, running in a Node.js of their own.

    Each is an attribute and takes one state, arrays of shape (n,). Node.js ends when no function is used any longer.

    Raises:
        BuildError: sources of another target, or Node.js's own words where it refuses them.
        MissingProgram: there is no Node.js.
    """
    check_target(sources, "js")
    process = _Process(find_node(), next(iter(sources.texts.values())))
    named = zip(sources.functions, sources.program.routines, strict=True)
    return SimpleNamespace(**{name: _call(process, name, routine.function) for name, routine in named})


def _call(process: _Process, name: str, function: Function) -> Callable[..., Any]:
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


class _Process:
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
