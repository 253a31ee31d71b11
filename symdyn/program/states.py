"""States at which functions are run in numbers: for certificates and examples."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from symdyn.dynamics import Argument
from symdyn.dynamics.roads import DIRECTIONS

ALLOWED = 2.0  # times the bound, which is of first order
DRAWS = 40  # states tried for one at which a function is real

RANGES = {"q": 3.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "inputs": 3.0}  # half-widths of the sampled states, SI
RANGES |= dict.fromkeys((*DIRECTIONS.values(), "weights"), 2.0)
WIDER = (1.0, 4.0, 16.0, 64.0)  # times those, one after the other, where a function is not real

Array = np.ndarray[Any, Any]


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


def samples(arguments: Sequence[Argument], rng: random.Random, real: str = "double") -> Iterator[list[Array]]:
    """Yield states as `sample` draws them, in ever wider ranges: for one at which a function is real."""
    for draw in range(DRAWS):
        yield sample(arguments, rng, real, WIDER[draw * len(WIDER) // DRAWS])


def quaternion_places(units: Sequence[str]) -> list[int]:
    """Return where quaternions begin among coordinates: four numbers without a unit."""
    return [k for k, unit in enumerate(units) if unit == "1"][::4]
