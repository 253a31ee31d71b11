"""Runs in lockstep in C: functions of lanes as the C target writes them, with a loop around them, as one file."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.emit import C, emit, render
from symdyn.emit.code import REALS
from symdyn.program import Program
from symdyn.runtime import load_functions
from symdyn.simulation.ensemble.lockstep_functions import Lockstep
from symdyn.simulation.integrate.looks import CLOSER, FIRST, Looks
from symdyn.simulation.integrate.watch import ROUNDING

KEPT = 8
"""Numbers that are kept of a formula that is folded."""

MOST = 200_000
"""Steps of a run, after which it is looked at one by one: the system may be stiff."""

RESULT = 12
"""The stage whose state is that at the end of the step."""


@dataclass(frozen=True)
class Library:
    """The compiled loop.

    Attributes:
        functions: what it runs.
        nq, nx: numbers of coordinates, and of coordinates and velocities.
        calls: the functions of the library.
    """

    functions: Lockstep
    nq: int
    nx: int
    calls: tuple[Any, Any]

    def prepared(self, parameters: Mapping[str, Array], runs: int) -> Array:
        """Return what depends on parameters alone, shape (runs, values)."""
        found = np.empty((runs, self.functions.values))
        if self.functions.values and runs:
            names = self.functions.parameters
            given = np.empty((runs, len(names)))
            for k, name in enumerate(names):
                given[:, k] = parameters[name]
            self.calls[1](runs, given.ctypes.data, found.ctypes.data)
        return found

    def run(
        self, x: Array, values: Array, times: Array, tolerances: tuple[float, float], halt: npt.NDArray[np.int32],
        keep: bool,
    ) -> tuple[Array, Array, npt.NDArray[np.int32], Array, Array | None, int]:  # fmt: skip
        """Return ends, their times, why, what is kept of formulas and of samples, and steps, from states (runs, nx)."""
        runs, seen = len(x), self.functions.seen
        end, ended, why = np.full((runs, self.nx), np.nan), np.zeros(runs), np.zeros(runs, dtype=np.int32)
        sums = np.full((runs, seen, KEPT), np.nan)
        kept = np.full((runs, len(times), self.nx), np.nan) if keep else None
        arrays = [np.ascontiguousarray(one, dtype=np.float64) for one in (x, values, np.append(times, np.inf))]
        steps = self.calls[0](
            runs, arrays[0].ctypes.data, arrays[1].ctypes.data, len(times), arrays[2].ctypes.data, *tolerances, MOST,
            halt.ctypes.data, end.ctypes.data, ended.ctypes.data, why.ctypes.data, sums.ctypes.data,
            None if kept is None else kept.ctypes.data,
        )  # fmt: skip
        if steps < 0:
            raise MemoryError("no memory for runs in lockstep")
        return end, ended, why, sums, kept, int(steps)


def library(functions: Lockstep, quaternions: Iterable[int]) -> Library:
    """Return the loop compiled, from the cache if it was compiled before.

    Raises:
        MissingCompiler: there is no C compiler.
        BuildError: its own words where it refuses the code.
    """
    program = functions.program
    sources = emit(program, C.name, option="batch")
    opening = sources.stem
    nq, nv = len(program.scene.coordinates), len(program.scene.velocities)
    values = {
        "stem": opening, "lanes": REALS["double"].lanes, "nq": nq, "nx": nq + nv, "values": functions.values,
        "seen": functions.seen, "watched": functions.watched, "outward": functions.outward,
        "quaternions": list(quaternions), **tableau(),
        "first": _looks(FIRST), "closer": _looks(CLOSER), "rounding": repr(ROUNDING),
    }  # fmt: skip
    name = f"{opening}.c"
    files = {**sources.texts, name: sources.texts[name] + render("ensemble/lockstep.c.jinja", values)}
    exports = (f"{opening}_lockstep", *((f"{opening}_{Program.PREPARE}_rows",) if functions.values else ()))
    _, found = load_functions(files, exports)
    p, n, d = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
    run, prepare = found[exports[0]], found[exports[1]] if functions.values else None
    run.argtypes, run.restype = [n, p, p, n, p, d, d, n, p, p, p, p, p, p], n
    if prepare is not None:
        prepare.argtypes, prepare.restype = [ctypes.c_size_t, p, p], None
    return Library(functions, nq, nq + nv, (run, prepare))


def tableau() -> dict[str, Any]:
    """Return the coefficients of DOP853 as text, from SciPy's."""
    from scipy.integrate._ivp import dop853_coefficients as of

    stages = range(1, of.N_STAGES)
    steps = [{"to": "stage", "number": s, "c": repr(float(of.C[s])), "sum": _sum(of.A[s, :s])} for s in stages]
    steps.append({"to": "y", "number": RESULT, "c": "1.0", "sum": _sum(of.B)})
    more = range(RESULT + 1, of.N_STAGES_EXTENDED)
    extra = [{"number": s, "c": repr(float(of.C[s])), "sum": _sum(of.A[s, :s])} for s in more]
    return {
        "steps": steps, "extra": extra, "dense": [_sum(row) for row in of.D], "fifth": _sum(of.E5),
        "third": _sum(of.E3), "stages": of.N_STAGES_EXTENDED,
    }  # fmt: skip


def _looks(of: Looks) -> dict[str, Any]:
    """Return nodes, and the rows of coefficients that tell of bends, as text."""
    rows = zip(of.coefficients, of.bends, strict=True)
    lines = [{"numbers": [repr(float(x)) for x in row], "bends": repr(float(bend))} for row, bend in rows if bend]
    return {"parts": [repr(float(x)) for x in of.parts], "coefficients": lines}


def _sum(row: Array) -> str:
    terms = [f"{float(x)!r} * a->slope[{j}][i][k]" for j, x in enumerate(row) if x]
    return " + ".join(terms)
