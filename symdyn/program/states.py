"""States at which functions are run in numbers, and what rounding may leave there: for certificates and examples."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import BigFloats, LooseErrors, RunningErrors
from symdyn.dynamics import Argument, Function
from symdyn.dynamics.roads import DIRECTIONS, WEIGHTS
from symdyn.graph import Expr

if TYPE_CHECKING:
    from symdyn.algebra import Midpoints

FUNCTION_ULPS = 4.0  # what NumPy's vectorised sines are allowed
ALLOWED = 2.0  # times the bound, which is of first order
DRAWS = 40  # states tried for one at which a function is real

RANGES = {"q": 3.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "inputs": 3.0}  # half-widths of the sampled states, SI
RANGES |= dict.fromkeys((*DIRECTIONS.values(), WEIGHTS), 2.0)
WIDER = (1.0, 4.0, 16.0, 64.0)  # times those, one after the other, where a function is not real

ROUNDOFF = {"double": 2.0**-53, "float": 2.0**-24, "dd": 2.0**-102}
TINIEST = {"double": 2.0**-1022, "float": 2.0**-126, "dd": 2.0**-960}  # below, digits are lost by underflow


Array = np.ndarray[Any, Any]


def rounding(numbers: BigFloats | Midpoints, real: str, sines: float = 0.0) -> RunningErrors:
    """Return the analysis of what rounding may leave in a real type, and in sines that are off by so much beside it."""
    kind = LooseErrors if real == "dd" else RunningErrors
    return kind(numbers, ROUNDOFF[real], 2 * FUNCTION_ULPS * ROUNDOFF[real], sines)


def sample(arguments: Sequence[Argument], rng: random.Random, real: str = "double", widen: float = 1.0) -> list[Array]:
    """Return random states for a function's arguments, exact in the real type; free parameters are positive."""
    drawn = []
    for argument in arguments:
        wide = RANGES.get(argument.name)
        low, high = (-wide * widen, wide * widen) if wide else (0.5, 1.5 * widen)
        state = np.array([rng.uniform(low, high) for _ in argument.symbols])
        for k in quaternion_places(argument.units) if argument.name == "q" else ():
            state[k : k + 4] /= np.linalg.norm(state[k : k + 4])
        state = state.reshape(argument.shape)
        drawn.append(state.astype(np.float32).astype(np.float64) if real == "float" else state)
    return drawn


def quaternion_places(units: Sequence[str]) -> list[int]:
    """Return where quaternions begin among coordinates: four numbers without a unit."""
    return [k for k, unit in enumerate(units) if unit == "1"][::4]


def values_of(function: Function, given: Iterable[Any], number: Callable[[Any], Any] = float) -> dict[Expr, Any]:
    """Return the value of every symbol of a function's arguments, given in calling order, each as `number` makes it."""
    return {
        symbol: number(value)
        for argument, values in zip(function.arguments, given, strict=True)
        for symbol, value in zip(argument.symbols, np.ravel(values).tolist(), strict=True)
    }
