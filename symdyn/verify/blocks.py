"""Fixed text of code for many states, measured: every length from none to three blocks gives the states one by one.

Blocks, what is left over, columns and rows are no arithmetic, so they are not proved but run: at each length, in each
way that the target has, next to one state a call, with an entry behind the result that nothing may touch.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.dynamics import Function
from symdyn.emit.code import REALS
from symdyn.program import Sampling, shared
from symdyn.runtime import RUNNERS, bind_rows
from symdyn.verdict import Verdict
from symdyn.verify.building import Building

COLUMNS, ROWS = "columns", "rows"

WAYS: Mapping[str, Mapping[str, str]] = {
    "c": {COLUMNS: "batch", ROWS: "rows"},
    "cpp": {COLUMNS: "batch", ROWS: "rows"},
    "rust": {ROWS: "rows"},
}
"""Targets whose code for many states is run: how states may lie, and how functions of C end that take them so."""

LONGEST = 3 * REALS["double"].lanes
"""States of three blocks: no target has longer ones than C."""

NEAR = {"double": 1e-6, "float": 1e-2}
"""Share of a result's largest entry by which both ways may differ: a wrong place is off by all of it."""

UNTOUCHED = 7.0

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Blocks:
    """How the functions over many states of one target were run.

    Attributes:
        target: which.
        option: of the target.
        ways: how states lay, columns or rows.
        functions: how many.
        longest: states; every number of them from 0 on was tried.
        wrong: function, way and length at which a state came out otherwise; "" for none.
        without: functions that have a value at none of these states, so that nothing was compared.
    """

    target: str
    option: str
    ways: tuple[str, ...]
    functions: int
    longest: int
    wrong: str
    without: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """One of `symdyn.verdict`: whether all states of every function came out as one by one."""
        return Verdict.of(self.functions * (not self.without), bool(self.wrong))

    @property
    def passed(self) -> bool:
        """Whether all states came out as one by one."""
        return self.verdict in Verdict.HOLD


def run_blocks(building: Building, target: str, seed: int = 1) -> Blocks:
    """Return how the code of one of `WAYS` over many states runs at every length from 0 to three blocks.

    Raises:
        BuildError: no compiler, or its own words when it refuses.
    """
    program, ways, option = building.program, WAYS[target], RUNNERS[target].many
    sources, module = building.compiled(target, option)
    library = ctypes.CDLL(str(module.path))
    opening, count, wrong = sources.stem, 0, ""
    without: list[str] = []
    for name, routine in zip(sources.functions, program.routines, strict=True):
        function = routine.function
        if not function.entries or wrong:
            continue
        count += 1
        arity = len(function.arguments) + 1
        calls = {way: bind_rows(library, f"{opening}_{name}_{ending}", arity) for way, ending in ways.items()}
        compared, wrong = _wrong(function, getattr(module, name), calls, NEAR[building.real], seed)
        without += [] if compared else [name]
    return Blocks(target, option, tuple(ways), count, LONGEST, wrong, tuple(without))


def _states(function: Function, one: Any, seed: int) -> tuple[list[Array], Array]:
    """Return arguments of states and what one at a time gives, in ever wider ranges until some have a value."""
    rng = np.random.default_rng(seed)
    common = shared([argument.name for argument in function.arguments])
    given: list[Array] = []
    wanted = np.empty((0, 0))
    for wide in Sampling.WIDER:
        given = [
            rng.uniform(0.5, 2 * wide, (1 if a.name == common else LONGEST, len(a.symbols))).astype(one.dtype)
            for a in function.arguments
        ]
        states = [
            [values[0 if a.name == common else k] for a, values in zip(function.arguments, given, strict=True)]
            for k in range(LONGEST)
        ]
        wanted = np.array([np.ravel(one(*(v[0] if a.scalar else v for a, v in _named(function, s)))) for s in states])
        if np.isfinite(wanted).all(axis=1).any():
            break
    return given, wanted


def _wrong(function: Function, one: Any, calls: Mapping[str, Any], near: float, seed: int) -> tuple[int, str]:
    """Return at how many states a function has a value, and where it is off over many of them, "" if nowhere."""
    given, wanted = _states(function, one, seed)
    compared = int(np.isfinite(wanted).all(axis=1).sum())
    for length in range(LONGEST + 1):
        for way, call in calls.items():
            columns = way == COLUMNS
            rows = [values if len(values) == 1 else values[:length] for values in given]
            arrays = [np.ascontiguousarray(values.T if columns and len(values) > 1 else values) for values in rows]
            out = np.full(length * wanted.shape[1] + 1, UNTOUCHED, one.dtype)
            call(length, *(array.ctypes.data for array in arrays), out.ctypes.data)
            size = wanted.shape[1]
            found = out[:-1].reshape((size, length)).T if columns else out[:-1].reshape((length, size))
            if out[-1] != UNTOUCHED or not _close(found, wanted[:length], near):
                return compared, f"{function.name}, {way} of {length} states"
    return compared, ""


def _named(function: Function, state: Sequence[Array]) -> list[tuple[Any, Array]]:
    return list(zip(function.arguments, state, strict=True))


def _close(values: Array, requested: Array, near: float) -> bool:
    """Tell whether states came out alike; those that have no value are left out."""
    if not prod(requested.shape):
        return True
    real = np.isfinite(requested).all(axis=1)
    size = np.abs(requested[real]).max(axis=1, keepdims=True, initial=0.0)
    return bool((np.abs(values[real] - requested[real]) <= near * size).all())
