"""Our JavaScript in Node.js, one state a call."""

from __future__ import annotations

import json
import subprocess
import tempfile
from functools import cache
from typing import Any

import numpy as np
from cases import Array, Case
from harness import Timed
from native import MissingError

from symdyn.emit import emit, write
from symdyn.errors import MissingProgram
from symdyn.runtime.machine import find_node

OUTPUT = "inverse_dynamics"

SCRIPT = """
import { createInterface } from "node:readline";
const { NAME: one } = await import("./FILE");
let q, qd, qdd, out;
for await (const line of createInterface({ input: process.stdin })) {
  const { sweeps, states } = JSON.parse(line);
  if (states) {
    [q, qd, qdd] = states.map(rows => rows.map(row => Float64Array.from(row)));
    out = new Float64Array(q[0].length);
    console.log("0");
  } else if (sweeps === undefined) {
    console.log(JSON.stringify(q.map((_, k) => Array.from(one(q[k], qd[k], qdd[k])))));
  } else {
    const start = process.cpuUsage();
    for (let j = 0; j < sweeps; j++) for (let k = 0; k < q.length; k++) one(q[k], qd[k], qdd[k], out);
    console.log(process.cpuUsage(start).user * 1e-6);
  }
}
""".replace("NAME", OUTPUT)


def version() -> str:
    """Return which Node.js runs it."""
    return (
        f"Node.js {subprocess.run([_node(), '--version'], capture_output=True, text=True, check=True).stdout.strip()}"
    )


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics, one state a call."""
    process = _process(case)

    def sweep(sweeps: int) -> float:
        return float(process.ask({"sweeps": sweeps}))

    def result() -> Array:
        return np.array(process.ask({}))

    few = len(case.references[OUTPUT])
    return [Timed(case.name, OUTPUT, "js", "state", few, sweep, result, own_clock=True)]


def _node() -> str:
    try:
        return find_node()
    except MissingProgram as missing:
        raise MissingError(str(missing)) from missing


class _Process:
    """A Node.js that answers each line with a line."""

    def __init__(self, folder: tempfile.TemporaryDirectory[str], file: str) -> None:
        self.folder = folder
        self.process = subprocess.Popen(
            [_node(), "--input-type=module", "--eval", SCRIPT.replace("FILE", file)],
            cwd=folder.name, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def ask(self, words: dict[str, Any]) -> Any:
        """Return the answer."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(words) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


@cache
def _process(case: Case) -> _Process:
    """Return the process that holds the states of a case."""
    folder = tempfile.TemporaryDirectory()
    sources = emit(case.programs[OUTPUT], "js")
    write(sources, folder.name)
    process = _Process(folder, next(iter(sources)))
    process.ask({"states": [case.states[a].tolist() for a in case.arguments(OUTPUT)]})
    return process
