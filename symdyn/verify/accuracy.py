"""Built modules against the same graph in 50 digits: how many units in the last place they are off.

The yardstick is the graph itself with every operation rounded once, at random (stochastic arithmetic, after Vignes,
Mathematics and Computers in Simulation 35, 1993): that is the error which double arithmetic has a right to. A module
passes when its error stays within a small multiple of it.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from symdyn.algebra.big import BigFloats
from symdyn.dynamics import Argument, Function
from symdyn.graph import Expr, evaluate
from symdyn.program import Program

DIGITS = 50
ULP = 2.0**-53  # half a unit in the last place of 1, the relative error of one rounding
ALLOWED = 16.0  # times the stochastic error, plus as many ulps of the largest entry
NOISY_RUNS = 3

RANGES = {"q": 3.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0}  # half-widths of the sampled states, SI


class NoisyFloats(BigFloats):
    """Big floats whose every operation is off by a random relative error of at most one rounding in double."""

    def __init__(self, seed: int) -> None:
        """Seed the noise."""
        super().__init__(DIGITS)
        self._rng = random.Random(seed)

    def _noise(self, value: Any) -> Any:
        return value * (1 + self._rng.uniform(-ULP, ULP))

    def add(self, a: Any, b: Any) -> Any:
        """Return a + b, off by one rounding."""
        return self._noise(a + b)

    def sub(self, a: Any, b: Any) -> Any:
        """Return a - b, off by one rounding."""
        return self._noise(a - b)

    def mul(self, a: Any, b: Any) -> Any:
        """Return a b, off by one rounding."""
        return self._noise(a * b)

    def div(self, a: Any, b: Any) -> Any:
        """Return a / b, off by one rounding."""
        return self._noise(a / b)

    def function(self, node: Expr, args: Sequence[Any]) -> Any:
        """Return node.op(args), off by one rounding."""
        return self._noise(super().function(node, args))


@dataclass(frozen=True)
class Accuracy:
    """Error of one function of one module over sampled states.

    Attributes:
        function: its name.
        module: "numpy", "c" or "ufunc".
        states: how many states were sampled.
        median_ulp, max_ulp: error of the worst entry, in ulps of the largest entry of the result.
        allowed_ulp: what the yardstick allows at the state of the largest excess.
        passed: no state exceeded what is allowed.
    """

    function: str
    module: str
    states: int
    median_ulp: float
    max_ulp: float
    allowed_ulp: float
    passed: bool


def sample(arguments: Sequence[Argument], rng: random.Random) -> list[np.ndarray[Any, Any]]:
    """Return random doubles for a function's arguments; free parameters lie between 0.5 and 1.5."""
    drawn = []
    for argument in arguments:
        wide = RANGES.get(argument.name)
        low, high = (-wide, wide) if wide else (0.5, 1.5)
        drawn.append(np.array([rng.uniform(low, high) for _ in argument.symbols]))
    return drawn


def measure(program: Program, modules: Mapping[str, Any], states: int = 12, seed: int = 1) -> list[Accuracy]:
    """Return the accuracy of every function of every module.

    Args:
        program: what the modules were emitted from.
        modules: objects with one callable a function, by name; a function that a module lacks is left out.
        states: how many random states a function.
        seed: of the states and of the noise.
    """
    found = []
    for routine in program.routines:
        function = routine.function
        if not function.entries:
            continue
        rng = random.Random(f"{seed}:{function.name}")
        cases = [_case(function, sample(function.arguments, rng), seed + k) for k in range(states)]
        found += [
            _compare(function, name, getattr(module, function.name), cases)
            for name, module in modules.items()
            if hasattr(module, function.name)
        ]
    return found


@dataclass(frozen=True)
class _Case:
    """A state, the exact result, and the size of one ulp of its largest entry and of the stochastic error."""

    inputs: list[np.ndarray[Any, Any]]
    exact: list[Any]
    ulp: float
    noise: float


def _case(function: Function, inputs: list[np.ndarray[Any, Any]], seed: int) -> _Case:
    algebra = BigFloats(DIGITS)
    exact = _big(function, inputs, algebra)
    largest = max(abs(value) for value in exact)
    noise = 0.0
    for run in range(NOISY_RUNS):
        noisy = _big(function, inputs, NoisyFloats(1000 * seed + run))
        noise = max(noise, *(float(abs(a - b)) for a, b in zip(exact, noisy, strict=True)))
    return _Case(inputs, exact, float(largest) * 2 * ULP, noise)


def _big(function: Function, inputs: Sequence[np.ndarray[Any, Any]], algebra: BigFloats) -> list[Any]:
    values = {
        symbol: algebra.number(float(value))
        for argument, given in zip(function.arguments, inputs, strict=True)
        for symbol, value in zip(argument.symbols, given, strict=True)
    }
    return evaluate(function.entries, algebra, values)


def _compare(function: Function, module: str, call: Callable[..., Any], cases: Sequence[_Case]) -> Accuracy:
    errors, worst, allowed = [], float("-inf"), 0.0
    for case in cases:
        got = np.ravel(call(*case.inputs))
        context = BigFloats(DIGITS)
        error = max(
            float(abs(context.number(float(a)) - b)) if np.isfinite(a) else float("inf")
            for a, b in zip(got, case.exact, strict=True)
        )
        bound = ALLOWED * (case.noise + case.ulp)
        unit = case.ulp or 1.0
        errors.append(error / unit)
        if error - bound > worst:
            worst, allowed = error - bound, bound / unit
    passed = worst <= 0
    return Accuracy(function.name, module, len(cases), median(errors), max(errors), allowed, passed)
