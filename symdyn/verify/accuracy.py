"""Built modules against the same graph in 50 digits: how many units in the last place they are off.

The yardstick is a running error analysis of the graph: a bound, entry by entry, of the error that rounding every
operation once may leave (Higham, Accuracy and Stability of Numerical Algorithms, section 3.3). A module passes when
each entry stays within a small multiple of its bound. After many divisions in a row, as in long chains, that bound may
be wider than a divisor is; such a function is held against a few runs whose roundings go up or down by lot. Reference:
Vignes, A stochastic arithmetic for reliable scientific computation (1993).
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from math import inf, isfinite, nan
from statistics import median
from typing import Any

import numpy as np

from symdyn.algebra import BigFloats, Bounded, Midpoints, RunningErrors
from symdyn.dynamics import Function
from symdyn.emit.code import REALS, Real
from symdyn.frozen import dataclass
from symdyn.graph import Arithmetic, Expr, evaluate, reachable, repeated
from symdyn.program import Program, Sampling
from symdyn.verdict import Verdict


class Shaken(Arithmetic):
    """An arithmetic whose results are off by the roundoff u of an operation, or v of a function, up or down."""

    def __init__(self, numbers: BigFloats | Midpoints, roundoff: Any, function_roundoff: Any, rng: random.Random):
        self.numbers = numbers
        self.factors = [1 + sign * numbers.context.mpf(roundoff) for sign in (-1, 1)]
        self.function_factors = [1 + sign * numbers.context.mpf(function_roundoff) for sign in (-1, 1)]
        self.rng = rng

    def constant(self, value: Fraction) -> Any:
        return self._rounded(self.numbers.constant(value))

    def pi(self) -> Any:
        return self._rounded(self.numbers.pi())

    def add(self, a: Any, b: Any) -> Any:
        return self._rounded(a + b)

    def sub(self, a: Any, b: Any) -> Any:
        return self._rounded(a - b)

    def mul(self, a: Any, b: Any) -> Any:
        return self._rounded(a * b)

    def div(self, a: Any, b: Any) -> Any:
        if b == 0:
            raise ZeroDivisionError("a divisor is zero")
        return self._rounded(a / b)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        return self.numbers.function(node, args) * self.rng.choice(self.function_factors)

    def _rounded(self, value: Any) -> Any:
        return value * self.rng.choice(self.factors)


DIGITS = 50
RUNS = 6  # by lot, where there is no bound
ALLOWED_OF_RUNS = 10.0  # times the largest deviation of these
Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Accuracy:
    """Error of one function of one module over sampled states.

    Attributes:
        function: its name.
        module: its target, a key of `TARGETS`.
        real: "double" or "float".
        states: how many states were sampled; 0 if the function is real at none of those tried.
        median_ulp, max_ulp: error of the worst entry, in ulps of the largest entry of the result; NaN of no state.
        worst: largest error of an entry over what its bound allows; at most 1 to agree; NaN of no state.
        verdict: one of `symdyn.verdict`: whether an entry exceeded what is allowed; NOT_SHOWN if there was no state.
        bounded: what is allowed is a bound; else what a few runs with roundings by lot show.
    """

    function: str
    module: str
    real: str
    states: int
    median_ulp: float
    max_ulp: float
    worst: float
    verdict: str
    bounded: bool = True

    @property
    def passed(self) -> bool:
        """Whether it was measured, and no entry exceeded what is allowed."""
        return self.verdict in Verdict.HOLD


def measure(
    program: Program,
    modules: Mapping[str, Any],
    states: int = 12,
    seed: int = 1,
    real: str = "double",
    accuracy: str = "",
) -> list[Accuracy]:
    """Return the accuracy of every function of every module.

    Args:
        program: what the modules were emitted from.
        modules: objects with one callable a function, by name; a function that a module lacks is left out.
        states: how many random states a function.
        seed: of the states.
        real: "double" or "float", of the modules.
        accuracy: likewise, as for `emit`: what sines are off by is in the bounds then.
    """
    numbers, kind, found = Midpoints(DIGITS), REALS[real], []
    with numbers:
        analysis = kind.rounding(numbers, accuracy)
        for routine in program.routines:
            function = routine.function
            if not function.entries:
                continue
            rng, bounded_at = random.Random(f"{seed}:{function.name}"), repeated(function.entries, analysis)
            first = _case(function, bounded_at, rng, analysis, kind)
            if first is None:
                order = reachable(function.entries)
                tried = [_case_by_lot(function, order, rng, analysis, kind) for _ in range(states)]
            else:
                tried = [first, *(_case(function, bounded_at, rng, analysis, kind) for _ in range(1, states))]
            cases, bounded = [case for case in tried if case is not None], first is not None
            found += [
                _compare(function, name, getattr(module, function.name), cases, real, bounded or not cases)
                for name, module in modules.items()
                if hasattr(module, function.name)
            ]
    return found


def remarks(measured: Sequence[Accuracy]) -> list[str]:
    """Return what has to be known of functions that were not held against a bound."""
    by_lot = f"no bound holds so many roundings: held against {RUNS} runs whose roundings go up or down by lot"
    return list(dict.fromkeys(f"{a.function}: {by_lot}" for a in measured if not a.bounded))


@dataclass(frozen=True)
class _Case:
    """A state, the exact result, the error that each entry is allowed, and an ulp of the largest entry."""

    inputs: list[Array]
    exact: list[Any]
    allowed: list[float]
    ulp: float


def _case(
    function: Function,
    bounded_at: Callable[[Mapping[Expr, Bounded]], list[Bounded]],
    rng: random.Random,
    analysis: RunningErrors,
    real: Real,
) -> _Case | None:
    """Return a case at the next state where the function is real, trying ever wider ranges; None if there is none."""
    for inputs in Sampling(function.arguments, rng, real.name):
        values = function.values(inputs, lambda value: analysis.exact(analysis.numbers.number(value)))
        try:
            found = bounded_at(values)
        except (ValueError, ZeroDivisionError, OverflowError):
            continue
        ulp = 2 * real.roundoff * max(float(abs(entry.value)) for entry in found) or real.tiniest
        allowed = [Real.ALLOWED * float(entry.error) + real.tiniest for entry in found]
        if not isfinite(ulp) or not all(map(isfinite, allowed)):
            continue  # beyond all numbers of the type, or no slope is defined near: there is nothing to compare with
        return _Case(inputs, [entry.value for entry in found], allowed, ulp)
    return None


def _case_by_lot(
    function: Function, order: Sequence[Expr], rng: random.Random, analysis: RunningErrors, real: Real
) -> _Case | None:
    """Return a case at a state where the function is real, allowed what runs with roundings by lot are off by."""
    numbers, unit = analysis.numbers, real.roundoff
    for inputs in Sampling(function.arguments, rng, real.name):
        values = function.values(inputs, numbers.number)
        try:
            exact = evaluate(function.entries, numbers, values, order)
            if not all(isfinite(float(value)) for value in exact):
                continue
            lots = [Shaken(numbers, unit, real.function_error, rng) for _ in range(RUNS)]
            runs = [evaluate(function.entries, lot, values, order) for lot in lots]
        except (ValueError, ZeroDivisionError, OverflowError):
            continue
        ulp = 2 * unit * max(float(abs(value)) for value in exact) or real.tiniest
        off = [max(float(abs(run[k] - value)) for run in runs) for k, value in enumerate(exact)]
        if not all(map(isfinite, off)):
            continue
        return _Case(inputs, exact, [ALLOWED_OF_RUNS * one + Real.ALLOWED * ulp for one in off], ulp)
    return None


def _compare(
    function: Function, module: str, call: Callable[..., Any], cases: Sequence[_Case], real: str, bounded: bool
) -> Accuracy:
    if not cases:
        return Accuracy(function.name, module, real, 0, nan, nan, nan, Verdict.of(0), bounded)
    errors, worst = [], 0.0
    for case in cases:
        got = np.ravel(call(*case.inputs)).tolist()
        largest = 0.0
        for value, exact, allowed in zip(got, case.exact, case.allowed, strict=True):
            error = abs(float(exact - value)) if isfinite(value) else inf
            worst = max(worst, error / allowed)
            largest = max(largest, error)
        errors.append(largest / case.ulp)
    said = Verdict.of(len(cases), not worst <= 1)
    return Accuracy(function.name, module, real, len(cases), median(errors), max(errors), worst, said, bounded)
