"""CasADi: our C by `external`, the C that it writes of our SX, and its virtual machine; each called through CasADi."""

from __future__ import annotations

from typing import Any

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import NATIVE, compiled

from symdyn.emit import emit
from symdyn.emit.targets.casadi_modules import EXTERNAL
from symdyn.runtime.runners import run_casadi

ID, DERIVATIVES = "inverse_dynamics", "inverse_dynamics_derivatives"

FLAGS = (*NATIVE, "-fno-math-errno")
"""For our C and for CasADi's alike."""

OURS, ITS, MACHINE = "casadi, our C", "casadi, its C", "casadi, SX"


def version() -> str:
    """Return how CasADi calls itself, and how both sorts of C are compiled."""
    import casadi

    return f"casadi {casadi.__version__}, gcc {' '.join(FLAGS)}"


def timed(case: Case) -> list[Timed]:
    """Return inverse dynamics called one state at a time and mapped over 64, and derivatives, mapped."""
    import casadi

    found = []
    for output in (ID, DERIVATIVES):
        sources = emit(case.programs[output], "casadi", option=EXTERNAL)
        function = run_casadi(sources).module.functions[output]
        generated = casadi.CodeGenerator("generated.c")
        generated.add(function)
        ours, its = (compiled(text, FLAGS, more=("-lm",)) for text in (str(sources.files[1][1]), generated.dump()))
        ways = {OURS: casadi.external(output, str(ours)), ITS: casadi.external(output, str(its)), MACHINE: function}
        found += [mapped(case, output, peer, call) for peer, call in ways.items()]
        found += [one(case, output, peer, call) for peer, call in ways.items()] if output == ID else []
    return found


def one(case: Case, output: str, peer: str, function: Any) -> Timed:
    """Return a function called one state at a time, all on the same place in memory; Python's loop is part of it."""
    arguments = [np.ascontiguousarray(case.states[a]) for a in case.arguments(output)]
    wanted = case.references[output]
    rows = [np.array(a[0]) for a in arguments]
    out = np.zeros(wanted.shape[1])
    buffer, call = bound(function, rows, out)

    def result() -> np.ndarray:
        found = np.zeros_like(wanted)
        for k in range(len(wanted)):
            for row, argument in zip(rows, arguments, strict=True):
                row[:] = argument[k]
            call()
            found[k] = out
        return found

    return Timed(case.name, output, peer, "state", 1, python_sweep(call), held(result, buffer))


def mapped(case: Case, output: str, peer: str, function: Any) -> Timed:
    """Return a function mapped by CasADi over all states of the case, a column each."""
    columns = [np.ascontiguousarray(case.states[a]) for a in case.arguments(output)]
    wanted = case.references[output]
    out = np.zeros(wanted.shape)
    buffer, call = bound(function.map(len(wanted)), columns, out)
    height, width = function.size_out(0)

    def result() -> np.ndarray:
        call()
        return out.reshape(-1, width, height).swapaxes(1, 2).reshape(wanted.shape)

    return Timed(case.name, output, peer, "batch", len(wanted), python_sweep(call), held(result, buffer))


def bound(function: Any, arguments: list[np.ndarray], out: np.ndarray) -> tuple[Any, Any]:
    """Return what calls a function on places in memory, without Python's share of an ordinary call."""
    buffer, call = function.buffer()
    for place, argument in enumerate(arguments):
        buffer.set_arg(place, memoryview(argument))
    buffer.set_res(0, memoryview(out))
    return buffer, call


def held(result: Any, buffer: Any) -> Any:
    """Return a function that keeps a buffer alive."""
    return lambda: (result(), buffer)[0]
