"""heyoka: compiled functions (LLVM, vectorised over states) of our own expressions.

heyoka has no robots; it is given the graph that our C is printed from, so what is compared is how well the same
operations run. A batch is one call on arrays of shape (arguments, states), its layout and ours for batches.

heyoka shares a call's states among threads. On an idle machine that halved the processor time of the calling one, which
is what is measured here, and on a busy one it did not: so it is told to use one thread, as all others do.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from cases import Case
from harness import Timed, moved, python_sweep
from native import MissingError

from peers.ours_c import BATCH
from symdyn.graph import Arithmetic, Expr, evaluate

NAME = "heyoka, our graph"

LONG = 1_100
"""Operations above which compiling is not waited for."""


def version() -> str:
    """Return its version."""
    import heyoka

    return f"{heyoka.__version__}, cfunc with fast_math off, opt_level 3, one thread"


class Heyoka(Arithmetic):
    """heyoka's expressions as an algebra."""

    def constant(self, value: Fraction) -> Any:
        """Return the nearest double as an expression."""
        import heyoka

        return heyoka.expression(float(value))

    def pi(self) -> Any:
        """Return pi."""
        import heyoka

        return heyoka.expression(float(np.pi))

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args)."""
        import heyoka

        return getattr(heyoka, node.op.name.lower())(*args)


def timed(case: Case, output: str) -> list[Timed]:
    """Return one call on many states."""
    import heyoka

    heyoka.set_nthreads(1)
    routine = case.programs[output].routines[0]
    if routine.counts.multiplications + routine.counts.additions > LONG:
        raise MissingError(f"more than {LONG:,} operations, whose compilation is not waited for")
    names = [str(symbol.value) for argument in routine.function.arguments for symbol in argument.symbols]
    symbols = [symbol for argument in routine.function.arguments for symbol in argument.symbols]
    variables = [heyoka.make_vars(name) for name in names]
    entries = evaluate(routine.function.entries, Heyoka(), dict(zip(symbols, variables, strict=True)))
    entries = [e if isinstance(e, heyoka.expression) else heyoka.expression(e) for e in entries]
    function = heyoka.cfunc(entries, vars=variables)
    many = case.draw(BATCH)
    states = len(case.states["q"])
    stacked = [np.concatenate([case.states[a], many[a][states:]]).T for a in case.arguments(output)]
    inputs = np.ascontiguousarray(np.vstack(stacked))
    out = np.zeros((len(entries), BATCH))

    to = random.Random(0)

    def result() -> np.ndarray:
        function(inputs=inputs, outputs=out)
        return out.T[:states]

    def call(sweeps: int) -> float:
        here, there = moved(inputs, to), moved(out, to)
        return python_sweep(lambda: function(inputs=here, outputs=there))(sweeps)

    return [Timed(case.name, output, NAME, "batch", BATCH, call, result, own_clock=True)]
