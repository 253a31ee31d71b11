"""Our own C, one state a call, and the ufuncs that `load` makes of it: what the tools are held against."""

from __future__ import annotations

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from peers import ours_c

from symdyn.emit import emit
from symdyn.runtime import build_extension

MANY = 10_000
"""States of a batch that a tool gets."""

OUTPUTS = ("inverse_dynamics", "inverse_dynamics_derivatives")

version = ours_c.version


def many(case: Case, output: str) -> list[np.ndarray]:
    """Return the arguments of so many states, a row each, the first 64 of them the case's own."""
    drawn = case.draw(MANY)
    known = len(next(iter(case.states.values())))
    return [np.ascontiguousarray(np.concatenate([case.states[a], drawn[a][known:]])) for a in case.arguments(output)]


def timed(case: Case) -> list[Timed]:
    """Return scalar C, and the ufunc with many states, of each output."""
    found = []
    for output in OUTPUTS:
        found += [one for one in ours_c.timed(case, output) if one.way == "state"]
        call = getattr(build_extension(emit(case.programs[output], "ufunc"))[1], output)
        arguments = many(case, output)
        out = np.empty((MANY, *case.programs[output].routines[0].function.shape))
        known = len(case.references[output])

        def sweep(call=call, arguments=arguments, out=out):  # type: ignore[no-untyped-def]
            call(*arguments, out)

        def result(sweep=sweep, out=out, known=known):  # type: ignore[no-untyped-def]
            sweep()
            return out[:known].reshape(known, -1)

        found.append(Timed(case.name, output, "ufunc", "batch", MANY, python_sweep(sweep), result))
    return found
