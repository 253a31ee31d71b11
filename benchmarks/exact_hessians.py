"""Exact Hessians of robots for CasADi's solvers: `python benchmarks/exact_hessians.py [--robots NAME ..]`.

A solver with exact Hessians, as IPOPT by `nlpsol` or acados with `hessian_approx = "EXACT"`, takes second derivatives
of λᵀ f by all arguments of f, inverse or forward dynamics. In acados#1259 those that CasADi wrote of a manipulator of
24 joints were 24.4 MB of C, for which gcc took 20.5 GB until it was killed. Here of robots up to Talos, 32 joints:

    symdyn    functions `_vjp`, `_hessian`, `_derivatives` of `--target casadi --external`, which CasADi calls
    CasADi    its own Hessian of the same expressions of f, `cse`, and its own C of it; reads what symdyn wrote of f

Each way is a process of its own whose memory is limited, and so is its compiler. Sizes, seconds and memory of both, gcc
-O2 as acados has it; microseconds of a call, medians of interleaved rounds of the processor's time for one thread, and
the largest difference over the largest entry. Robots of example-robot-data stand on a fixed base, without friction.
Talos needs some minutes; the script ends with 1 where a bar was missed.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from bars import Bar, at_most, told as tell
from derivatives import SCENES

from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.scene import Scene

WAYS = ("symdyn", "CasADi")
FUNCTIONS = ("inverse_dynamics", "forward_dynamics")
FLAGS = ("-O2", "-fPIC", "-shared")
SECONDS = 900
"""Of a process or of its compiler, at most."""

MEGABYTES, COMPILED, GIGABYTES = 2.0, 60.0, 2.0
"""Of our source, and of its compiler, at most."""


def ours(scene: Scene, name: str, folder: Path) -> Path:
    """Return the file that symdyn writes."""
    names = [name, f"{name}_derivatives", f"{name}_vjp", f"{name}_hessian"]
    for file, text in emit(lower(formulate(scene, names)), "casadi", option="external").texts.items():
        (folder / file).write_text(text, "utf-8")
    return folder / f"{scene.name}_external.c"


def theirs(scene: Scene, name: str, folder: Path) -> Path:
    """Return the file that CasADi writes of its own Hessian."""
    import casadi

    source = emit(lower(formulate(scene, [name])), "casadi")
    space: dict[str, Any] = {"__name__": "written"}
    exec(next(iter(source.texts.values())), space)
    f = space["functions"][name]
    n = len(scene.velocities)
    x, weights = casadi.SX.sym("x", 3 * n), casadi.SX.sym("weights", n)
    H, _ = casadi.hessian(casadi.dot(weights, f(x[:n], x[n : 2 * n], x[2 * n :])), x)
    whole = casadi.Function("hessian", [x, weights], [casadi.densify(H)], {"cse": True})
    os.chdir(folder)
    return folder / whole.generate("casadis.c")


def spent(command: list[str]) -> tuple[float, float, str]:
    """Return seconds and GB of a process, and how it ended where it did not well."""
    where = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(command, env=where, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        _, said = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return SECONDS, 0.0, f"more than {SECONDS} s"
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines = said.strip().splitlines()
    return (
        used.ru_utime + used.ru_stime,
        used.ru_maxrss / 2**20,
        (lines or ["killed"])[-1] if process.returncode else "",
    )


def made(robot: str, name: str, way: str, gigabytes: float, folder: Path) -> dict[str, Any]:
    """Return what a way takes: a process of its own counts each of its children alone."""
    words = [sys.executable, __file__, "--made", robot, name, way, str(gigabytes), str(folder)]
    found = subprocess.run(words, capture_output=True, text=True, check=True, timeout=3 * SECONDS)
    told: dict[str, Any] = json.loads(found.stdout.splitlines()[-1])
    return told


def make(robot: str, name: str, way: str, gigabytes: float, folder: Path) -> dict[str, Any]:
    """Write and compile; return seconds, GB and MB."""
    most = int(gigabytes * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (most, most))  # what this process starts has the limit from the first
    words = [sys.executable, __file__, "--write", robot, name, way, str(folder)]
    seconds, memory, ended = spent(words)
    told: dict[str, Any] = {"write, s": seconds, "write, GB": memory, "ended": ended}
    if ended:
        return told
    source = Path((folder / f"{way}.txt").read_text("utf-8"))
    told["MB"] = source.stat().st_size / 1e6
    seconds, memory, ended = spent(["gcc", *FLAGS, str(source), "-o", str(folder / f"{way}.so"), "-lm"])
    return told | {"gcc, s": seconds - told["write, s"], "gcc, GB": memory, "ended": ended and f"gcc: {ended}"}


def write(robot: str, name: str, way: str, folder: Path) -> None:
    """Write the file of a way, and where it is."""
    path = {"symdyn": ours, "CasADi": theirs}[way](SCENES[robot](), name, folder)
    (folder / f"{way}.txt").write_text(str(path), "utf-8")


class Call:
    """The Hessian of one way at a state, row by row; CasADi's own is a function of all arguments in one."""

    def __init__(self, scene: Scene, name: str, way: str, folder: Path) -> None:
        n = len(scene.velocities)
        x, weights = np.random.default_rng(1).uniform(-1, 1, 3 * n), np.random.default_rng(2).uniform(-1, 1, n)
        library, self.n = ctypes.CDLL(str(folder / f"{way}.so")), n
        if way == "CasADi":
            self.call, self.out = library.hessian, [np.zeros(9 * n * n)]
            given = [x, weights]
        else:
            self.call, self.out = getattr(library, f"jac_adj1_{name}"), [np.zeros(n * n) for _ in range(15)]
            given = [x[:n], x[n : 2 * n], x[2 * n :], np.zeros(n), weights, *(np.zeros(n) for _ in range(3))]
        work = getattr(library, f"{self.call.__name__}_work")
        sizes = [ctypes.c_longlong() for _ in range(4)]
        work(*(ctypes.byref(one) for one in sizes))
        w, iw = np.zeros(sizes[3].value + 1), np.zeros(sizes[2].value + 1, dtype=np.int64)
        self.kept = [*given, w, iw]
        arg, res = (ctypes.c_void_p * sizes[0].value)(), (ctypes.c_void_p * sizes[1].value)()
        for k, one in enumerate(given):
            arg[k] = one.ctypes.data
        for k, one in enumerate(self.out):
            res[k] = None if len(self.out) > 1 and k % 5 > 2 else one.ctypes.data
        self.given = [arg, res, ctypes.c_void_p(iw.ctypes.data), ctypes.c_void_p(w.ctypes.data), 0]

    def run(self) -> None:
        """Call it once."""
        self.call(*self.given)

    def whole(self) -> np.ndarray:
        """Return H, shape (3 n, 3 n)."""
        n = self.n
        self.run()
        if len(self.out) == 1:
            return self.out[0].reshape(3 * n, 3 * n).T
        blocks = [[self.out[5 * a + b].reshape(n, n).T for b in range(3)] for a in range(3)]
        return np.block(blocks)


def timed(calls: dict[str, Call], rounds: int) -> dict[str, list[float]]:
    """Return microseconds of interleaved rounds."""
    found: dict[str, list[float]] = {way: [] for way in calls}
    for _ in range(rounds):
        for way, call in calls.items():
            begin = time.thread_time()
            for _ in range(20):
                call.run()
            found[way].append((time.thread_time() - begin) / 20 * 1e6)
    return found


def main() -> int:
    """Print a line a robot, function and way, and the bars; 1 where one is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="*", default=["arm7", "anymal", "talos"])
    parser.add_argument("--functions", nargs="*", default=FUNCTIONS)
    parser.add_argument("--gigabytes", type=float, default=6.0, help="address space of a process, GB")
    parser.add_argument("--rounds", type=int, default=50)
    given = parser.parse_args()
    bars: list[Bar] = []
    columns = ("write, s", "write, GB", "MB", "gcc, s", "gcc, GB")
    print(f"{'':44}" + "".join(f"{one:>11}" for one in columns) + f"{'us':>10}{'apart':>10}")
    for robot in given.robots:
        scene = SCENES[robot]()
        for name in given.functions:
            with tempfile.TemporaryDirectory() as place:
                folder = Path(place)
                told = {way: made(robot, name, way, given.gigabytes, folder) for way in WAYS}
                calls = {way: Call(scene, name, way, folder) for way in WAYS if not told[way]["ended"]}
                values = {way: call.whole() for way, call in calls.items()}
                times = timed(calls, given.rounds)
            both = len(calls) == len(WAYS)
            off = float(np.abs(np.subtract(*values.values())).max() / np.abs(values["CasADi"]).max()) if both else None
            for way in WAYS:
                cells = "".join(f"{told[way][one]:11.2f}" if one in told[way] else f"{'':11}" for one in columns)
                micro = f"{median(times[way]):10.1f}" if way in times else f"{'':10}"
                shown = micro + (f"{off:10.0e}" if off is not None else "") + "  " + told[way]["ended"]
                print(f"{robot}, {len(scene.velocities)} joints, {name}, {way}".ljust(44) + cells + shown, flush=True)
            mine, what = told["symdyn"], f"{robot}, Hessian of {name}"
            limits = (
                ("source", MEGABYTES, "MB", "MB"),
                ("gcc", COMPILED, "gcc, s", "s"),
                ("gcc", GIGABYTES, "gcc, GB", "GB"),
            )
            bars += [at_most(f"{what}, {text}", most, mine.get(key, np.inf), unit) for text, most, key, unit in limits]
            if both:
                ratio = median(a / b for a, b in zip(times["symdyn"], times["CasADi"], strict=True))
                bars.append(at_most(f"{what}, CasADi's time", 1, ratio))
                bars.append(at_most(f"{what}, off CasADi's", 1e-9, off or 0.0))
    return tell(bars)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--made"]:
        print(json.dumps(make(*sys.argv[2:5], float(sys.argv[5]), Path(sys.argv[6]))))
    elif sys.argv[1:2] == ["--write"]:
        write(*sys.argv[2:5], Path(sys.argv[5]))
    else:
        sys.exit(main())
