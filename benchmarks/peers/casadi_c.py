"""CasADi: C that it generates from the graph of Pinocchio's own recursions over CasADi symbols.

This is what `pinocchio.casadi` gives; the wheel has no such module, so a C++ program is compiled from the headers of
both. Derivatives are CasADi's jacobians of rnea, beside crba, and of aba. Common subexpressions are eliminated (`cse`)
before the C is written, which is compiled with the flags of all.
"""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import numpy as np
from cases import OUTPUTS, Case
from harness import Timed
from native import FOLDER, HERE, NATIVE, MissingError, address, compiled, loops

from peers import pinocchio_cpp
from peers.ours_c import LONG, lengths, longs, padded

NAME = "CasADi C"

CODES = {
    "inverse_dynamics": 0,
    "mass_matrix": 1,
    "forward_dynamics": 2,
    "inverse_dynamics_derivatives": 3,
    "forward_dynamics_derivatives": 5,
    "gravity_forces": 7,
}

LONGEST, LARGEST = 2_000_000, 16
"""Bytes of C, and joints, above which nobody waits for derivatives: gcc takes more than five minutes for 3.5 MB."""


def version() -> str:
    """Return its version."""
    import casadi

    return f"{casadi.__version__}, from Pinocchio's graph, gcc {' '.join(NATIVE)}"


def generate(case: Case, code: int) -> tuple[str, pinocchio_cpp.Places]:
    """Return the C of an output of the program, and our places of its arguments."""
    import casadi

    folder = Path(casadi.__file__).parent
    flags = ("-std=c++17", "-w", "-O1", *pinocchio_cpp.DEFINES, *pinocchio_cpp.include(), f"-I{folder}/include")
    more = (f"-L{folder}", "-lcasadi", f"-Wl,-rpath,{folder}")
    program = compiled(HERE / "peers" / "pinocchio_casadi.cpp", flags, "g++", library=False, more=more)
    rows, places = pinocchio_cpp.numbers(case)
    if len(rows) != case.n:
        raise MissingError("a base that floats, for which there is no such program here")
    target = FOLDER / f"casadi_{case.name}_{code}.c"
    words = [str(target), str(code), str(len(rows)), *(repr(float(x)) for x in rows.ravel())]
    done = subprocess.run([str(program)], input=" ".join(words), capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"its generator ends with {done.stderr.strip().splitlines()[-1:]}")
    return target.read_text("utf-8"), places


def timed(case: Case, output: str) -> list[Timed]:
    """Return the generated function, one state a call."""
    counts = case.programs[output].routines[0].counts
    if counts.multiplications + counts.additions > LONG and output in OUTPUTS:
        raise MissingError(f"more than {LONG:,} operations, whose compilation is not waited for")
    return [generated(case, output, NAME, CODES[output])]


def generated(case: Case, output: str, name: str, program: int) -> Timed:
    """Return what a program's output makes of a case, under a name."""
    if case.n > LARGEST and output not in OUTPUTS:
        raise MissingError(f"more than {LARGEST} joints, for whose derivatives nobody waits")
    text, places = generate(case, program)
    if len(text) > LONGEST:
        raise MissingError(f"{len(text) / 1e6:.1f} MB of C, whose compilation is not waited for")
    code, clock = ctypes.CDLL(str(compiled(text, NATIVE))), loops()
    sizes = [ctypes.c_longlong() for _ in range(4)]
    code.f_work(*(ctypes.byref(x) for x in sizes))
    iw, w = np.zeros(max(1, sizes[2].value), dtype=np.int64), np.zeros(max(1, sizes[3].value))
    arguments = pinocchio_cpp.given(case, output, places)[: len(case.arguments(output))]
    states, size = case.references[output].shape
    out = np.zeros((states, size))

    def sweep(sweeps: int) -> float:
        where = [address(a) for a in (*padded(arguments), out, iw, w)]
        sizes = (*longs(states, sweeps), lengths(arguments), *longs(size))
        return clock.time_casadi(code.f, len(arguments), *sizes, *where)

    def result() -> np.ndarray:
        sweep(1)
        return pinocchio_cpp.restored(out, places["qd"], case.n)

    return Timed(case.name, output, name, "state", states, sweep, result)
