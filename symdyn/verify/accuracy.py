"""Built modules against the same graph in 50 digits: how many units in the last place they are off.

The yardstick is a running error analysis of the graph: a bound, entry by entry, of the error that rounding every
operation once may leave (Higham, Accuracy and Stability of Numerical Algorithms, section 3.3). A module passes when
each entry stays within a small multiple of its bound.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from symdyn.algebra.big import BigFloats, Bounded, RunningErrors
from symdyn.dynamics import Function
from symdyn.graph import evaluate
from symdyn.program import Program
from symdyn.program.states import ALLOWED, DRAWS, FUNCTION_ULPS, ROUNDOFF, TINIEST, WIDER, sample, values_of

DIGITS = 50
Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Accuracy:
    """Error of one function of one module over sampled states.

    Attributes:
        function: its name.
        module: its target, a key of `TARGETS`.
        real: "double" or "float".
        states: how many states were sampled; 0 if the function is real at none of those tried.
        median_ulp, max_ulp: error of the worst entry, in ulps of the largest entry of the result.
        worst: largest error of an entry over what its bound allows; at most 1 to pass.
        passed: no entry exceeded what is allowed.
    """

    function: str
    module: str
    real: str
    states: int
    median_ulp: float
    max_ulp: float
    worst: float
    passed: bool


def measure(
    program: Program, modules: Mapping[str, Any], states: int = 12, seed: int = 1, real: str = "double"
) -> list[Accuracy]:
    """Return the accuracy of every function of every module.

    Args:
        program: what the modules were emitted from.
        modules: objects with one callable a function, by name; a function that a module lacks is left out.
        states: how many random states a function.
        seed: of the states.
        real: "double" or "float", of the modules.
    """
    numbers = BigFloats(DIGITS)
    numbers.context.trap_complex = True
    analysis = RunningErrors(numbers, ROUNDOFF[real], 2 * FUNCTION_ULPS * ROUNDOFF[real])
    found = []
    for routine in program.routines:
        function = routine.function
        if not function.entries:
            continue
        rng = random.Random(f"{seed}:{function.name}")
        cases = [case for k in range(states) if (case := _case(function, rng, analysis, real, k)) is not None]
        found += [
            _compare(function, name, getattr(module, function.name), cases, numbers, real)
            for name, module in modules.items()
            if hasattr(module, function.name)
        ]
    return found


@dataclass(frozen=True)
class _Case:
    """A state, and the exact result with its error bounds."""

    inputs: list[Array]
    exact: list[Bounded]


def _case(function: Function, rng: random.Random, analysis: RunningErrors, real: str, k: int) -> _Case | None:
    """Return a case at the next state where the function is real, trying ever wider ranges; None if there is none."""
    for draw in range(DRAWS):
        inputs = sample(function.arguments, rng, real, WIDER[draw * len(WIDER) // DRAWS])
        values = values_of(function, inputs, lambda value: analysis.exact(analysis.numbers.number(value)))
        try:
            return _Case(inputs, evaluate(function.entries, analysis, values))
        except (ValueError, ZeroDivisionError, OverflowError):
            continue
    return None


def _compare(
    function: Function, module: str, call: Callable[..., Any], cases: Sequence[_Case], numbers: BigFloats, real: str
) -> Accuracy:
    errors, worst = [0.0] if not cases else [], 0.0
    for case in cases:
        got = np.ravel(call(*case.inputs))
        ulp = 2 * ROUNDOFF[real] * max(float(abs(entry.value)) for entry in case.exact) or TINIEST[real]
        largest = 0.0
        for value, entry in zip(got, case.exact, strict=True):
            finite = bool(np.isfinite(value))
            error = float(abs(numbers.number(float(value)) - entry.value)) if finite else float("inf")
            worst = max(worst, error / (ALLOWED * float(entry.error) + TINIEST[real]))
            largest = max(largest, error)
        errors.append(largest / ulp)
    return Accuracy(function.name, module, real, len(cases), median(errors), max(errors), worst, worst <= 1)
