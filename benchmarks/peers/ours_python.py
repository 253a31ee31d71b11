"""symdyn from Python: the NumPy ufuncs that `symdyn.load` compiles, and the generated NumPy module.

For a million states the C function of the same layout is timed on the same arrays, so that the ratio is what NumPy
adds. These arrays hold 1,024 different states over and over.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import address, loops

import symdyn
from peers import ours_c
from peers.ours_c import BATCH, LONG, longs, padded
from symdyn.emit.code import stem

NAME = "symdyn"

MILLION = 1_000_000

MANY = 16_384
"""States of a batch for the NumPy module, which cuts it into blocks itself."""

FEW_JOINTS = 7
"""Robots with more joints are not timed with a million states, which would need gigabytes."""


def version() -> str:
    """Return NumPy's version."""
    return f"this checkout, NumPy {np.__version__}"


@cache
def loaded(case_name: str, output: str) -> Callable[..., np.ndarray]:
    """Return the compiled function of one output."""
    from cases import cases

    return getattr(symdyn.load(cases()[case_name].scene, functions=(output,)), output)


def timed(case: Case, output: str) -> list[Timed]:
    """Return calls from Python with 1, 100, 1024 and a million states."""
    routine = case.programs[output].routines[0]
    short = routine.counts.multiplications + routine.counts.additions <= LONG
    arguments = [case.states[a] for a in case.arguments(output)]
    found = []
    module = symdyn.lambdify(case.scene, output)
    found += calls(case, output, "symdyn, NumPy module", module, arguments, {1: "python", MANY: "batch"})
    if short:
        ufunc = loaded(case.name, output)
        ways = {1: "python", 100: "hundred", BATCH: "batch"}
        found += calls(case, output, "symdyn, ufunc", ufunc, arguments, ways)
        if case.n <= FEW_JOINTS and output != "gravity_forces":
            found += million(case, output, ufunc, arguments)
    return found


def calls(
    case: Case,
    output: str,
    peer: str,
    function: Callable[..., np.ndarray],
    states: list[np.ndarray],
    ways: dict[int, str],
) -> list[Timed]:
    """Return calls of one function with several numbers of states; `states` are repeated as often as is needed."""
    found = []
    for count, way in ways.items():
        inputs = [a[0].copy() if count == 1 else repeated(a, count) for a in states]
        found.append(
            Timed(
                case.name,
                output,
                peer,
                way,
                count,
                python_sweep(lambda inputs=inputs: function(*inputs)),
                lambda inputs=inputs: rows(case, output, function(*inputs)),
            )
        )
    return found


def million(case: Case, output: str, ufunc: Callable[..., np.ndarray], states: list[np.ndarray]) -> list[Timed]:
    """Return the ufunc and the C function of the same layout on the same million states, both into one array."""
    inputs = [repeated(a, MILLION) for a in states]
    out = np.zeros((MILLION, *case.programs[output].routines[0].function.shape))
    code, clock = ours_c.library(case, output), loops()
    row = getattr(code, f"{stem(case.scene.name)}_{output}_rows")

    def in_c(sweeps: int) -> float:
        where = [address(a) for a in padded(inputs)]
        return clock.time_batch(row, len(inputs), *longs(MILLION, sweeps), *where, address(out))

    def c_result() -> np.ndarray:
        in_c(1)
        return rows(case, output, out)

    sweep = python_sweep(lambda: ufunc(*inputs, out=out))
    return [
        Timed(
            case.name, output, "symdyn, ufunc", "million", MILLION, sweep, lambda: rows(case, output, ufunc(*inputs))
        ),
        Timed(case.name, output, "symdyn, rows", "million", MILLION, in_c, c_result),
    ]


def repeated(array: np.ndarray, count: int) -> np.ndarray:
    """Return `count` rows that repeat those of an array."""
    return np.ascontiguousarray(np.resize(array, (count, array.shape[1])))


def rows(case: Case, output: str, found: np.ndarray) -> np.ndarray:
    """Return the first results, one row a state."""
    size = case.references[output].shape[1]
    return np.asarray(found).reshape(-1, size)[: len(case.states["q"])]
