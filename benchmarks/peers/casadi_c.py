"""CasADi: C that it generates from the graph of Pinocchio's own recursions over CasADi symbols.

This is what `pinocchio.casadi` gives; the wheel has no such module, so a C++ program is compiled from the headers of
both. Common subexpressions are eliminated (`cse`) before the C is written, which is compiled with the flags of all.
"""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import numpy as np
from cases import Case
from harness import Timed
from native import FOLDER, HERE, NATIVE, MissingError, address, compiled, loops

from peers import pinocchio_cpp
from peers.ours_c import LONG, longs, padded

NAME = "CasADi C"

CODES = {"inverse_dynamics": 0, "mass_matrix": 1, "forward_dynamics": 2, "gravity_forces": 3}


def version() -> str:
    """Return its version."""
    import casadi

    return f"{casadi.__version__}, from Pinocchio's graph, gcc {' '.join(NATIVE)}"


def generate(case: Case, output: str) -> tuple[str, np.ndarray]:
    """Return the C of an output, and our place of each joint."""
    import casadi

    folder = Path(casadi.__file__).parent
    flags = ("-std=c++17", "-w", "-O1", *pinocchio_cpp.DEFINES, *pinocchio_cpp.include(), f"-I{folder}/include")
    more = (f"-L{folder}", "-lcasadi", f"-Wl,-rpath,{folder}")
    program = compiled(HERE / "peers" / "pinocchio_casadi.cpp", flags, "g++", library=False, more=more)
    rows, order = pinocchio_cpp.numbers(case)
    target = FOLDER / f"casadi_{case.name}_{output}.c"
    words = [str(target), str(CODES[output]), str(len(rows)), *(repr(float(x)) for x in rows.ravel())]
    done = subprocess.run([str(program)], input=" ".join(words), capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"its generator ends with {done.stderr.strip().splitlines()[-1:]}")
    return target.read_text("utf-8"), order


def timed(case: Case, output: str) -> list[Timed]:
    """Return the generated function, one state a call."""
    counts = case.programs[output].routines[0].counts
    if counts.multiplications + counts.additions > LONG:
        raise MissingError(f"more than {LONG:,} operations, whose compilation is not waited for")
    text, order = generate(case, output)
    code, clock = ctypes.CDLL(str(compiled(text, NATIVE))), loops()
    sizes = [ctypes.c_longlong() for _ in range(4)]
    code.f_work(*(ctypes.byref(x) for x in sizes))
    iw, w = np.zeros(max(1, sizes[2].value), dtype=np.int64), np.zeros(max(1, sizes[3].value))
    arguments = [np.ascontiguousarray(case.states[a][:, order]) for a in case.arguments(output)]
    states, n, size = len(arguments[0]), case.n, case.references[output].shape[1]
    out = np.zeros((states, size))

    def sweep(sweeps: int) -> float:
        where = [address(a) for a in (*padded(arguments), out, iw, w)]
        return clock.time_casadi(code.f, len(arguments), *longs(states, sweeps, n, size), *where)

    def result() -> np.ndarray:
        sweep(1)
        return pinocchio_cpp.restored(out, order, case.n)

    return [Timed(case.name, output, NAME, "state", states, sweep, result)]
