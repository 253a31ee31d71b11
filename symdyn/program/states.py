"""States at which functions are run in numbers: for certificates and examples."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from symdyn.dynamics import Argument
from symdyn.dynamics.outputs import DIRECTIONS

DRAWS = 40  # states tried for one at which a function is real

RANGES = {"q": 3.0, "qd": 2.0, "qdd": 2.0, "tau": 5.0, "t": 3.0, "inputs": 3.0}  # half-widths of the sampled states, SI
RANGES |= dict.fromkeys((*DIRECTIONS.values(), "weights"), 2.0)

Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Sampling:
    """Random states for a function's arguments, exact in the real type; free parameters are positive.

    Attributes:
        arguments: of the function.
        rng: what draws.
        real: the type.
        WIDER: times the usual ranges, one after the other, where a function is not real.
    """

    arguments: Sequence[Argument]
    rng: random.Random
    real: str = "double"

    WIDER: ClassVar[tuple[float, ...]] = (1.0, 4.0, 16.0, 64.0)

    def __iter__(self) -> Iterator[list[Array]]:
        """Yield states in ever wider ranges: for one at which a function is real."""
        for draw in range(DRAWS):
            yield self.state(self.WIDER[draw * len(self.WIDER) // DRAWS])

    def state(self, widen: float = 1.0) -> list[Array]:
        """Return the values of the arguments at one state, in ranges wider than usual by a factor."""
        drawn = []
        for argument in self.arguments:
            wide = RANGES.get(argument.name)
            low, high = (-wide * widen, wide * widen) if wide else (0.5, 1.5 * widen)
            state = np.array([self.rng.uniform(low, high) for _ in argument.symbols])
            for k in quaternion_places(argument.units) if argument.name == "q" else ():
                state[k : k + 4] /= np.linalg.norm(state[k : k + 4])
            state = state.reshape(argument.shape)
            drawn.append(state.astype(np.float32).astype(np.float64) if self.real == "float" else state)
        return drawn


def quaternion_places(units: Sequence[str]) -> list[int]:
    """Return where quaternions begin among coordinates: four numbers without a unit."""
    return [k for k, unit in enumerate(units) if unit == "1"][::4]
