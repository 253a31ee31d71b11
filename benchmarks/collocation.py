"""Optimal control beside opty: lines to write, seconds to build, to evaluate and to solve, for opty's own pendulums.

    python benchmarks/collocation.py [--opty PYTHON] [--rounds N] [--problems NAME …] [--rules NAME …]
    python benchmarks/collocation.py --counts

Without an interpreter that has opty and cyipopt only our side is measured. cyipopt has no wheels for Linux; it builds
against the IPOPT in CasADi's wheel: take its `pkgconfig/ipopt.pc`, write the folder of casadi where prefix, libdir and
includedir stand, and `PKG_CONFIG_PATH=… LDFLAGS=-Wl,-rpath,FOLDER pip install cyipopt`; both then run the same IPOPT.

Problems have 500 intervals. Both start from the straight way between start and end, without forces. Evaluations are
medians over rounds in which both take turns, ratios medians of the ratios inside a round. Times are processor time,
those of building wall time, for there compilers run. opty has no Hessian; ours is solved with, and by the rules that
both have also without. What is counted with `--counts` are multiplications and additions at one place that depend on
the state, lowered: the dynamics with all its derivatives, as inverse dynamics with accelerations for unknowns, and as
forward dynamics.
"""

from __future__ import annotations

import argparse
import inspect
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from itertools import chain
from pathlib import Path
from statistics import median
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import symdyn
from symdyn.dynamics import Equations, Function, derive_one, row_of
from symdyn.program import lower
from symdyn.simulation.equations.compiled_routines import plain
from symdyn.transcription import Collocation
from symdyn.transcription.local import argument_of, inputs_of, partials, slopes_of, written
from symdyn.transcription.solution import lagrangian

HERE = Path(__file__).parent
EXAMPLES, DATA = HERE.parent / "examples", HERE / "data"
PEER = HERE / "peers" / "opty_collocation.py"
INTERVALS = 500


# The three problems: what is counted as lines to write.


def fixed_pendulum(method: str) -> Collocation:  # noqa: D103
    scene = symdyn.read(DATA / "driven_pendulum.toml")
    return symdyn.collocation(scene, 10, INTERVALS, method, "T**2", end={"theta": "pi"}, end_rates={"theta": 0})


def free_pendulum(method: str) -> Collocation:  # noqa: D103
    scene = symdyn.read(DATA / "driven_pendulum.toml")
    return symdyn.collocation(
        scene, (0.1, 19.9), INTERVALS, method, "T**2", end={"theta": "pi"}, end_rates={"theta": 0}
    )


def cart_pole(method: str) -> Collocation:  # noqa: D103
    scene = symdyn.read(DATA / "swing_up.toml")
    end = {"q1": 1, "q2": "pi"}
    return symdyn.collocation(scene, 2, INTERVALS, method, "u**2", end=end, end_rates={"q1": 0, "q2": 0})


PROBLEMS: dict[str, Callable[[str], Collocation]] = {
    "fixed_pendulum": fixed_pendulum,
    "free_pendulum": free_pendulum,
    "cart_pole": cart_pole,
}
SCENES = {"fixed_pendulum": "driven_pendulum", "free_pendulum": "driven_pendulum", "cart_pole": "swing_up"}
MOST = 1000
"""Iterations of IPOPT."""

OURS = ("implicit_midpoint", "trapezoidal", "hermite_simpson")
THEIRS = ("implicit_midpoint", "backward_euler")


class Opty:
    """The other process; `ask` returns what it answers."""

    def __init__(self, python: str) -> None:
        command = [python, str(PEER)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: str) -> dict[str, Any]:
        """Return the answer to a problem, a rule and a task."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(" ".join(words) + "\n")
        self.process.stdin.flush()
        while line := self.process.stdout.readline():
            if line.startswith("{"):
                found: dict[str, Any] = json.loads(line)
                return found
        raise SystemExit(f"{PEER.name}: ended with {self.process.wait()}; has its Python opty and cyipopt?")


def timed(call: Callable[[], object]) -> float:
    """Return seconds of a call, the median of ten groups of twenty."""
    groups = []
    for _ in range(10):
        began = time.process_time()
        for _ in range(20):
            call()
        groups.append((time.process_time() - began) / 20)
    return median(groups)


def code_lines(path: Path) -> int:
    """Return the lines of a file that say something."""
    return sum(bool(line.split("#")[0].strip()) for line in path.read_text(encoding="utf-8").splitlines())


def main(python: str | None, rounds: int, wanted: Sequence[str], rules: Sequence[str]) -> None:
    """Print a table a problem."""
    opty = Opty(python) if python else None
    for name in wanted:
        make = PROBLEMS[name]
        own, scene = len(inspect.getsource(make).splitlines()), code_lines(DATA / f"{SCENES[name]}.toml")
        print(f"\n{name}, {INTERVALS} intervals; symdyn: {own} lines and a scene of {scene}")
        problems, samples = {}, {}
        for method in OURS:
            began = time.perf_counter()
            problem = problems[method] = make(method)
            z = problem.guess + 0.01
            _ = problem.residual(z), problem.jacobian_values(z)
            built = time.perf_counter() - began
            of = lagrangian(problem)
            more = time.perf_counter() - began - built
            print(f"  symdyn {method}: built in {built:.2f} s, Hessian {more:.2f} s, ", end="")
            entries = f"{len(problem.jacobian_rows)} and {len(of.rows)} entries"
            print(f"{problem.size} unknowns, {problem.rows} equations, {entries}")
        for rule in rules if opty else ():
            told = opty.ask(name, rule, "build")
            words = f"built in {told['seconds']:.2f} s, {told['unknowns']} unknowns, {told['rows']} equations"
            print(f"  opty {rule}: {words}; {told['lines']} lines")
        for _ in range(rounds):
            for method, problem in problems.items():
                z, of = problem.guess + 0.01, lagrangian(problem)
                multipliers = np.ones(problem.rows)
                calls = {
                    "residual": lambda p=problem, z=z: p.residual(z),
                    "jacobian": lambda p=problem, z=z: p.jacobian_values(z),
                    "hessian": lambda o=of, z=z, m=multipliers: o.values(z, 1.0, m),
                }
                for what, call in calls.items():
                    samples.setdefault(("symdyn", method, what), []).append(timed(call))
            for rule in rules if opty else ():
                for what, seconds in opty.ask(name, rule, "time").items():
                    samples.setdefault(("opty", rule, what), []).append(seconds)
        for (who, rule, what), seconds in samples.items():
            ours = samples["symdyn", "implicit_midpoint", what]
            ratio = median(x / y for x, y in zip(seconds, ours, strict=True))
            print(f"  {who} {rule}, {what}: {1e6 * median(seconds):.0f} µs, {ratio:.2f} times ours by midpoints")
        for method, problem in problems.items():
            for exact in (True, False) if method in rules else (True,):
                began = time.process_time()
                found = problem.solve(exact=exact, max_iter=MOST)
                words = f"{time.process_time() - began:.2f} s, {found.iterations} iterations, "
                words += f"cost {found.objective:.6f}, {found.status}"
                print(f"  symdyn {method}, {'with' if exact else 'without'} Hessian: {words}", flush=True)
        for rule in rules if opty else ():
            told = opty.ask(name, rule, "solve")
            words = f"{told['seconds']:.2f} s, {told['iterations']} iterations, cost {told['objective']:.6f}"
            print(f"  opty {rule}: {words}, {told['status']}")


def counts() -> None:
    """Print what one place costs, implicit and explicit."""
    for name in ("cart_pole", "four_bar", "puma560", "arm7"):
        w = symdyn.dynamics.Workspace(symdyn.read(EXAMPLES / f"{name}.toml"))
        found = written(w, (), {})
        takes = [argument_of(kind, found.kinds[kind]) for kind in ("q", "u", "a", "multiplier")]
        takes.append(argument_of("force", w.state.tau))

        def count(entries: list[Any], takes: list[Any] = takes, w: Any = w) -> object:
            function: Function = plain("place", entries, [one for one in takes if one.symbols])
            return lower(Equations(w.scene, w.graph, (function,))).routines[0].state_counts

        balance = list(found.entries["balance"])
        slopes = slopes_of(w, found, "balance", [symbol for _, _, symbol in inputs_of(found, balance)])
        row, _ = row_of("forward_dynamics", w.scene)
        forward = list(derive_one(w, "forward_dynamics", row.preferred(w)).entries)
        if w.scene.is_constrained:
            explicit = partials(forward, list(chain(*(found.kinds[kind] for kind in ("q", "u", "force"))))).values()
        else:
            explicit = derive_one(w, "forward_dynamics_derivatives").entries
        print(f"{name}: implicit {count([*balance, *slopes.values()])}; explicit {count([*forward, *explicit])}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--opty", metavar="PYTHON", help="an interpreter that has opty and cyipopt")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--problems", nargs="*", choices=[*PROBLEMS], default=[*PROBLEMS])
    parser.add_argument("--rules", nargs="*", choices=THEIRS, default=THEIRS, help="opty's")
    parser.add_argument("--counts", action="store_true", help="count operations instead")
    options = parser.parse_args()
    if options.counts:
        counts()
    else:
        main(options.opty, options.rounds, options.problems, options.rules)
    sys.exit(0)
