"""SymPy: `lambdify(cse=True)` over NumPy of our own expressions, one state a call and many.

SymPy's own mechanics gives much longer expressions, and none at all in reasonable time from three joints in space on;
so this is the best case for it.
"""

from __future__ import annotations

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import MissingError

from peers.ours_c import BATCH
from symdyn.algebra import graph_to_sympy

NAME = "SymPy lambdify, our graph"

LONG = 400
"""Operations above which `cse` is not waited for."""


def version() -> str:
    """Return its version."""
    import sympy

    return f"{sympy.__version__}, lambdify(modules='numpy', cse=True)"


def timed(case: Case, output: str) -> list[Timed]:
    """Return a call on one state (floats) and a call on many (arrays)."""
    import sympy

    routine = case.programs[output].routines[0]
    if routine.counts.multiplications + routine.counts.additions > LONG:
        raise MissingError(f"more than {LONG:,} operations, whose cse is not waited for")
    names = [str(symbol.value) for argument in routine.function.arguments for symbol in argument.symbols]
    symbols = [sympy.Symbol(name, real=True) for name in names]
    function = sympy.lambdify(symbols, graph_to_sympy(routine.function.entries), modules="numpy", cse=True)
    states = len(case.states["q"])
    many = case.draw(BATCH)
    columns = [
        np.ascontiguousarray(np.concatenate([case.states[a], many[a][states:]])[:, i])
        for a in case.arguments(output)
        for i in range(case.n)
    ]
    first = [float(column[0]) for column in columns]

    def one_result() -> np.ndarray:
        return np.array([function(*first)], dtype=float)

    def result() -> np.ndarray:
        return np.array([np.broadcast_to(x, (BATCH,)) for x in function(*columns)]).T[:states]

    one = python_sweep(lambda: function(*first))
    batch = python_sweep(lambda: function(*columns))
    return [
        Timed(case.name, output, NAME, "python", 1, one, one_result),
        Timed(case.name, output, NAME, "batch", BATCH, batch, result),
    ]
