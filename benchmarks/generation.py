"""How long it takes to get code: ours from scene to source and on to a library, SymPy's two methods to equations.

    python benchmarks/generation.py WHAT ROBOT      one measurement, in seconds, on stdout

Each measurement runs in a process of its own, imports aside, and is stopped when it takes too long.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from cases import Case, cases, chain

PATIENCE = 45.0

OUTPUTS = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "velocity_forces", "gravity_forces")
OUTPUTS += ("kinetic_energy", "potential_energy")

SYMPY = {"KanesMethod": "SymPy KanesMethod", "LagrangesMethod": "SymPy LagrangesMethod"}

KINDS = ("plain C", "plain library", "C", "library")
"""Ours, without functions over many states and with them."""

PLAN = (
    ("to C", "two_link"),
    ("KanesMethod", "two_link"),
    ("LagrangesMethod", "two_link"),
    ("to C", "chain3"),
    ("KanesMethod", "chain3"),
    ("LagrangesMethod", "chain3"),
    ("to C", "arm7"),
    ("to library", "arm7"),
    *((f"inverse dynamics to {what}", robot) for robot in ("chain64", "chain256") for what in KINDS),
)


@dataclass(frozen=True)
class Generated:
    """One measurement; `seconds` is None where it was stopped, and `words` say what went wrong, if anything."""

    what: str
    robot: str
    seconds: float | None
    words: str = ""


def measure_all(quick: bool) -> list[Generated]:
    """Return every measurement of the plan."""
    wanted = [row for row in PLAN if row[1] == "two_link" or row[0] == "to C"] if quick else list(PLAN)
    return [_in_a_process(what, robot) for what, robot in wanted]


def _in_a_process(what: str, robot: str) -> Generated:
    command = [sys.executable, __file__, what, robot]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired:
        return Generated(what, robot, None, f"stopped after {PATIENCE:.0f} s")
    if done.returncode:
        return Generated(what, robot, None, (done.stderr.strip().splitlines() or ["it failed"])[-1])
    return Generated(what, robot, float(done.stdout))


def once(what: str, robot: str) -> float:
    """Return the seconds of one measurement in this process."""
    known = cases()
    case = known[robot] if robot in known else Case(robot, chain(int(robot.removeprefix("chain"))))
    if what in SYMPY:
        import mechanics

        method = mechanics.kane if what == "KanesMethod" else mechanics.lagrange
        start = time.perf_counter()
        method(case.scene)
        return time.perf_counter() - start
    return ours(case, what)


def ours(case: Case, what: str) -> float:
    """Return the seconds from scene to C, or to a library without what is derived and printed before.

    It is what `symdyn generate` and `symdyn.runtime` do: formulations chosen by counting, the package's flags for this
    machine.
    """
    from symdyn.emit import emit
    from symdyn.program import formulate, lower
    from symdyn.runtime import find_compiler
    from symdyn.runtime.compiler import compile_library

    outputs = ("inverse_dynamics",) if what.startswith("inverse dynamics") else OUTPUTS
    option = "" if "plain" in what else "batch"
    emit(lower(formulate(chain(1), ("inverse_dynamics",))), "c", option=option)  # imports and templates
    start = time.perf_counter()
    sources = emit(lower(formulate(case.scene, outputs)), "c", option=option)
    if what.endswith("C"):
        return time.perf_counter() - start
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, "utf-8")
        compiler = find_compiler("gcc")
        start = time.perf_counter()
        compile_library(compiler, Path(folder) / sources.files[0][0], Path(folder) / "code.so")
        return time.perf_counter() - start


if __name__ == "__main__":
    print(once(sys.argv[1], sys.argv[2]))
