"""Our WebAssembly in Node.js, one state a call and many by columns; JavaScript's own beside it."""

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

from symdyn.build.run_node import find_node
from symdyn.emit import emit, write
from symdyn.errors import MissingProgram

OUTPUT = "inverse_dynamics"

MANY = 4096
"""States of a batch."""

SCRIPT = """
import { createInterface } from "node:readline";
const { NAME: one, NAME_batch: many } = await import("./FILE");
const given = {};
const ways = {
  state: () => {
    const [q, qd, qdd] = given.state, out = new Float64Array(q[0].length);
    return [q.length, () => { for (let k = 0; k < q.length; k++) one(q[k], qd[k], qdd[k], out); },
            () => q.map((_, k) => Array.from(one(q[k], qd[k], qdd[k])))];
  },
  batch: () => {
    const [q, qd, qdd, count] = given.batch, out = new Float64Array(q.length);
    const call = () => many(count, q, qd, qdd, out);
    return [count, call, () => Array.from(call())];
  },
};
for await (const line of createInterface({ input: process.stdin })) {
  const { way, sweeps, states } = JSON.parse(line);
  if (states) {
    given.state = states.map(rows => rows.map(row => Float64Array.from(row)));
  } else if (sweeps === undefined) {
    console.log(JSON.stringify(ways[way]()[2]()));
    continue;
  } else {
    const call = ways[way]()[1];
    const start = process.cpuUsage();
    for (let k = 0; k < sweeps; k++) call();
    console.log(process.cpuUsage(start).user * 1e-6);
    continue;
  }
  const { columns, count } = JSON.parse(line);
  given.batch = [...columns.map(column => Float64Array.from(column)), count];
  console.log("0");
}
""".replace("NAME", OUTPUT)


def version() -> str:
    """Return which Node.js runs it."""
    return (
        f"Node.js {subprocess.run([_node(), '--version'], capture_output=True, text=True, check=True).stdout.strip()}"
    )


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics, one state a call and many."""

    def one(peer: str, way: str, states: int) -> Timed:
        process, about = _process(case, peer), {"way": way}

        def sweep(sweeps: int) -> float:
            return float(process.ask({**about, "sweeps": sweeps}))

        def result() -> Array:
            found = np.array(process.ask(about))
            return found if way == "state" else found.reshape(-1, MANY).T[: len(case.references[OUTPUT])]

        return Timed(case.name, OUTPUT, peer, way, states, sweep, result, own_clock=True)

    few = len(case.references[OUTPUT])
    return [one("wasm", "state", few), one("wasm", "batch", MANY), one("js", "state", few)]


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
def _process(case: Case, target: str) -> _Process:
    """Return the process that runs a target and holds the states of a case."""
    folder = tempfile.TemporaryDirectory()
    sources = emit(case.programs[OUTPUT], target, option="batch" if target == "wasm" else "")
    write(sources, folder.name)
    process = _Process(folder, next(iter(sources)))
    few, many = case.states, case.draw(MANY)
    arguments = case.arguments(OUTPUT)
    columns = [np.vstack([few[a], many[a][len(few[a]) :]]).T.ravel().tolist() for a in arguments]
    process.ask({"states": [few[a].tolist() for a in arguments], "columns": columns, "count": MANY})
    return process
