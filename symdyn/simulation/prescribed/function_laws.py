"""Motions that functions of time say, in Python.

A function that returns a position alone is differentiated by differences, whose step is chosen by their agreement: of
sin(2 t) the rate comes out to 1e-13 and the acceleration to 2e-11. One that returns all three is taken as it is.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import SimulateError
from symdyn.scene.values import Faults
from symdyn.simulation.prescribed.motion_laws import EVER, Law, Motion3


def read_function(function: Callable[[float], Any], where: str, faults: Faults) -> Law | None:
    """Return the law of a function of time that returns x, or (x, ẋ, ẍ); None after a fault."""
    if required_arguments(function) not in (1, None):
        faults.add(where, "a function takes one argument, the time in s, and returns x or (x, rate, acceleration)")
        return None
    return function_law(function, where)


def required_arguments(function: Callable[..., Any]) -> int | None:
    """Return how many arguments a function must be given, None where it does not tell or takes any number."""
    try:
        given = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(one.kind is one.VAR_POSITIONAL for one in given):
        return None
    return sum(
        one.default is one.empty and one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in given
    )


def function_law(function: Callable[[float], Any], where: str) -> Law:
    """Return the law of a function of time; it raises SimulateError where that raises, or returns what is no motion."""

    def at(t: float) -> Array:
        try:
            said = function(t)
        except Exception as fault:
            words = f": {fault}" if str(fault) else ""
            raise SimulateError(f"{where}: the function raised {type(fault).__name__}{words} at t = {t:g} s") from fault
        try:
            found = np.asarray(said, dtype=np.float64)
        except (TypeError, ValueError):
            found = np.empty(0)
        if found.size not in (1, 3) or found.ndim > 1:
            raise SimulateError(
                f"{where}: the function returned {said!r:.80} at t = {t:g} s; give x, or (x, rate, acceleration)"
            )
        return found.reshape(-1)

    def profile(times: Array) -> Motion3:
        rows = []
        for t in times.reshape(-1).tolist():
            found = at(t)
            rows.append(found if len(found) == 3 else np.array([found[0], *_differences(at, t)]))
        q, qd, qdd = np.array(rows).reshape(*times.shape, 3).transpose(-1, *range(times.ndim))
        return q, qd, qdd

    return Law("function", EVER, profile, (function_law, (function, where)))


FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
"""Central differences of order 8 at -4, ..., 4 steps."""

STEPS = (0.2, 0.08, 0.032, 0.0128, 0.005, 0.002, 0.0008)
"""s; which one is short enough, and not too short for the digits of a double, its neighbour tells."""


def _differences(at: Callable[[float], Array], t: float) -> tuple[float, float]:
    """Return ẋ and ẍ, each by the shorter of the two neighbouring steps that agree best; NaN where none has a value."""

    def near(time: float) -> float:
        try:
            return float(at(time)[0])
        except SimulateError:  # before its beginning, or behind its end
            return math.nan

    values = [np.array([near(t + k * h) for k in range(-4, 5)]) for h in STEPS]
    found = []
    for weights, order in ((FIRST, 1), (SECOND, 2)):
        some = np.array([weights @ x / h**order for x, h in zip(values, STEPS, strict=True)])
        apart = np.abs(np.diff(some))
        found.append(float(some[1 + int(np.nanargmin(apart))]) if np.any(np.isfinite(apart)) else math.nan)
    return found[0], found[1]
