"""Long chains as a loop over a table, beside lines and Pinocchio: run by `benchmarks/large_mechanisms.py`."""

from __future__ import annotations

import ctypes
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
from bars import Bar
from native import address, loops as clock

import symdyn
from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.runtime import bind_rows, build
from symdyn.scene import read

ID, FD, STATES, ROUNDS = "inverse_dynamics", "forward_dynamics", 264, 9

SINGLE = 64
"""Calls of one state in a row, from C: from Python one takes as long as 50 joints."""

Array = npt.NDArray[np.float64]

FORMULATIONS = {ID: {"loop": "rnea_loop", "lines": "rnea"}, FD: {"loop": "aba_loop", "lines": "aba"}}

LONGEST_LINES = 1024
"""Joints up to which lines are compiled too."""

WANTED = (("one state", 22.0), ("columns", 4.0))
"""Of inverse dynamics: at most so many ns a joint."""

SECONDS = 3.0

FASTER = 1.1
"""Of forward dynamics, one state: lines of the shortest of the chains at least so many times the loop."""


DERIVATIVES = (f"{ID}_derivatives", f"{FD}_derivatives")

ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""Python's own compiled modules are there, which all but the first process finds."""

FIRST = {64: 1.0, 256: 3.0, 1024: 12.0}
"""Processor seconds at most from a file to the first result of anything, compiler included, by joints."""

MEGABYTES = 500

FEW = 64
"""Joints up to which derivatives are held to Pinocchio's."""

MOST = 256
"""Joints up to which both are compared: a model of 1,024 took Pinocchio 24 GB and more."""

PAIRS = 101
"""Interleaved pairs of calls of 0.3 ms or so: a busy machine then seldom stops one of them."""


SHORT, EVEN = 16, 1.5
"""Joints of the chain that a joint of the longest one is compared with, and how many times its time at most."""


def loops(paths: dict[int, Path], short: Path) -> list[Bar]:
    """Print a row a chain and way, and return the bars; `paths` are scenes by their joints, `short` one of SHORT."""
    found = [*_first_results(paths), *_beside_pinocchio(paths), *_loops(paths, ID), *_loops(paths, FD)]
    return [*found, *(_by_length(short, paths, output) for output in (ID, FD))]


def _by_length(short: Path, paths: dict[int, Path], output: str) -> Bar:
    """Return the bar of a joint's time in the longest chain, each as code of one state by default."""
    ends = {SHORT: short, max(paths): paths[max(paths)]}
    calls = {joints: _built(path, output, None, joints)[1] for joints, path in ends.items()}
    pairs = [[_timed(call["one state"]) / joints for joints, call in calls.items()] for _ in range(PAIRS)]
    ratio = median(b / a for a, b in pairs)
    text = f"{output}, one state, a joint of {max(paths)} as one of {SHORT}, times"
    return Bar(text, f"≤ {EVEN:g}", f"{ratio:.2f}", ratio <= EVEN)


def _first_results(paths: dict[int, Path]) -> list[Bar]:
    """Return bars of processes that read a file and call one function once, with an empty cache of compiled code."""
    print(f"\n{'joints':>8}  {'output':32}{'to a result, s':>16}{'MB':>8}")
    found = []
    _first(min(paths.items())[1], DERIVATIVES[-1])  # which makes those modules
    for joints, path in paths.items():
        for output in (ID, FD, *DERIVATIVES):
            seconds, megabytes = _first(path, output)
            print(f"{joints:8}  {output:32}{seconds:16.2f}{megabytes:8.0f}", flush=True)
            if joints in FIRST:
                text, most = f"{output} of a chain of {joints}, file to result", FIRST[joints]
                reached = seconds <= most and megabytes <= MEGABYTES
                told_as = f"{seconds:.2f} s, {megabytes:.0f} MB"
                found.append(Bar(text, f"≤ {most:g} s, ≤ {MEGABYTES} MB", told_as, reached))
    return found


def _first(path: Path, output: str) -> tuple[float, float]:
    """Return seconds and MB of such a process."""
    with tempfile.TemporaryDirectory() as cache:
        given = [sys.executable, "-c", FIRST_RESULT, str(path), output]
        told = subprocess.run(given, env={**ENVIRONMENT, "XDG_CACHE_HOME": cache}, capture_output=True, check=True)
    seconds, megabytes = map(float, told.stdout.split())
    return seconds, megabytes


FIRST_RESULT = """
import resource, sys, time
import numpy as np
import symdyn
before = time.process_time()
scene = symdyn.scene.read(sys.argv[1])
function = getattr(symdyn.load(scene, functions=sys.argv[2]), sys.argv[2])
function(*np.random.default_rng(0).uniform(-1, 1, (3, len(scene.velocities))))
spent, compiler = time.process_time() - before, resource.getrusage(resource.RUSAGE_CHILDREN)
print(spent + compiler.ru_utime + compiler.ru_stime, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def _beside_pinocchio(paths: dict[int, Path]) -> list[Bar]:
    """Return bars of the derivatives of one state, called from Python, in interleaved pairs; [] without Pinocchio."""
    try:
        import pinocchio
    except ImportError:
        return []
    print(f"\n{'joints':>8}  {'output':32}{'symdyn, us':>12}{'Pinocchio, us':>15}{'ratio':>8}")
    found = []
    for joints, path in ((joints, path) for joints, path in paths.items() if joints <= MOST):
        model = _pinocchio_chain(joints)
        data, state = model.createData(), np.random.default_rng(joints).uniform(-1, 1, (3, joints))
        theirs = dict(
            zip(DERIVATIVES, (pinocchio.computeRNEADerivatives, pinocchio.computeABADerivatives), strict=True)
        )
        for output in DERIVATIVES:
            functions = symdyn.load(read(path), functions=output)
            mine, out = getattr(functions, output), np.zeros((joints, 3 * joints))
            calls = (partial(mine, *state, out=out), partial(theirs[output], model, data, *state))
            many = max(1, 300 // joints)
            times = [[_each(call, many) for call in calls] for _ in range(PAIRS)]
            ours, other = map(median, zip(*times, strict=True))
            ratio = median(a / b for a, b in times)
            print(f"{joints:8}  {output:32}{ours:12.1f}{other:15.1f}{ratio:8.2f}", flush=True)
            if joints <= FEW:
                found.append(
                    Bar(f"{output} of a chain of {joints}, Pinocchio's time", "≤ 1", f"{ratio:.2f}", ratio <= 1)
                )
    return found


def _each(call: Callable[[], object], many: int) -> float:
    start = time.process_time()
    for _ in range(many):
        call()
    return (time.process_time() - start) / many * 1e6


def _pinocchio_chain(joints: int) -> Any:
    """Return the model of `large_mechanisms.chain`."""
    import pinocchio as pin

    model = pin.Model()
    model.gravity = pin.Motion(np.array([0.0, 0, -9.81, 0, 0, 0]))
    inertia = pin.Inertia(1.0, np.array([0.1, 0, 0]), np.diag([0.1] * 3))
    for i in range(joints):
        turn = pin.JointModelRY() if i % 2 else pin.JointModelRZ()
        last = model.addJoint(i, turn, pin.SE3(np.eye(3), np.array([0.2, 0, 0])), f"j{i}")
        model.appendBodyToJoint(last, inertia, pin.SE3.Identity())
    return model


def _loops(paths: dict[int, Path], output: str) -> list[Bar]:
    ways = ("one state", "columns", "rows")
    print(f"\n{output}\n{'joints':>8}{'way':>8}{'to a result, s':>16}" + "".join(f"{way + ', ns':>16}" for way in ways))
    print("processor time; of three arrays, a joint and state; medians of interleaved rounds")
    found: list[Bar] = []
    for joints, path in paths.items():
        kept = {
            way: formulation
            for way, formulation in FORMULATIONS[output].items()
            if way == "loop" or joints <= LONGEST_LINES
        }
        made = {way: _built(path, output, formulation, joints) for way, formulation in kept.items()}
        times: dict[tuple[str, str], list[float]] = {}
        for _ in range(ROUNDS):
            for way, (_, calls) in made.items():
                for name, call in calls.items():
                    times.setdefault((way, name), []).append(_timed(call) / joints)
        for way, (seconds, _) in made.items():
            shown = [median(times[way, name]) for name in ways]
            print(f"{joints:8}{way:>8}{seconds:16.2f}" + "".join(f"{one:16.2f}" for one in shown), flush=True)
        if output == FD and joints == min(paths):
            ratio = median(a / b for a, b in zip(times["lines", ways[0]], times["loop", ways[0]], strict=True))
            text = f"forward dynamics of a chain of {joints}, one state, lines, times the loop"
            found.append(Bar(text, f"≥ {FASTER:g}", f"{ratio:.2f}", ratio >= FASTER))
        if output == ID and joints == max(paths):
            found = [
                Bar(f"chain of {joints}, loop, {name}", f"≤ {most:g} ns a joint", f"{here:.1f} ns", here <= most)
                for name, most in WANTED
                for here in [median(times["loop", name])]
            ]
            seconds = made["loop"][0]
            text = f"chain of {joints}, from the file to a result, compiler included"
            found.append(Bar(text, f"≤ {SECONDS:g} s", f"{seconds:.2f} s", seconds <= SECONDS))
    return found


def _built(
    path: Path, output: str, formulation: str | None, joints: int
) -> tuple[float, dict[str, tuple[Callable[[], object], int]]]:
    """Return processor seconds from a file to the first result, and calls by name with the states of each."""
    before = _seconds()
    scene = read(path)
    program = lower(formulate(scene, [output], formulation, lines=False))
    module = build(emit(program, "c", option="batch"))
    rng = np.random.default_rng(joints)
    getattr(module, output)(*rng.uniform(-1, 1, (3, joints)))
    seconds = _seconds() - before
    library = ctypes.CDLL(str(module.path))
    given = rng.uniform(-1, 1, (3, STATES, joints))
    columns = [np.ascontiguousarray(one.T) for one in given]
    out = np.zeros((STATES, joints))
    places = {name: [*some, out] for name, some in (("rows", given), ("columns", columns))}
    calls: dict[str, tuple[Callable[[], object], int]] = {}
    for name, ending in (("columns", "batch"), ("rows", "rows")):
        call = bind_rows(library, f"{scene.name}_{output}_{ending}", 4)
        calls[name] = _call(call, places[name], (STATES,)), STATES
    one = getattr(library, f"{scene.name}_{output}")
    entries = (ctypes.c_long * 3)(*[joints] * 3)
    sizes = [ctypes.c_long(SINGLE), ctypes.c_long(1)]
    ends = [ctypes.c_long(joints), *(address(array) for array in (*given, out))]
    calls["one state"] = partial(clock().time_states, one, 3, *sizes, entries, *ends), SINGLE
    return seconds, calls


def _call(function: Callable[..., object], arrays: Sequence[Array], first: tuple[int, ...] = ()) -> Callable[[], None]:
    """Return a call that holds on to its arrays."""
    at = [one.ctypes.data for one in arrays]

    def run(held: Sequence[Array] = arrays) -> None:
        function(*first, *at)

    return run


def _seconds() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _timed(call: tuple[Callable[[], object], int]) -> float:
    """Return ns of processor time a state, of some milliseconds."""
    run, states = call
    run()
    times, start = 0, time.process_time()
    while (spent := time.process_time() - start) < 0.01:
        run()
        times += 1
    return spent / times / states * 1e9
