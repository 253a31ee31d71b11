"""Long chains as a loop over a table, beside lines: run by `benchmarks/large_mechanisms.py`."""

from __future__ import annotations

import ctypes
import resource
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
import numpy.typing as npt
from bars import Bar
from native import address, loops as clock

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


def loops(paths: dict[int, Path]) -> list[Bar]:
    """Print a row a chain and way, and return the bars; `paths` are scenes by their joints."""
    return _loops(paths, ID) + _loops(paths, FD)


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
    path: Path, output: str, formulation: str, joints: int
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
