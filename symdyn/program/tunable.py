"""Code whose parameters are free and have start values, and random states at which functions are run in numbers.

What a simulator may set while it runs cannot be bound. The equations are derived with every parameter free, and the
scene keeps the values; decisions about loops, which are made in numbers, are made at these values.

States in numbers are for certificates and examples.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from symdyn.arguments import argument
from symdyn.dynamics import Argument, LoopChoices
from symdyn.dynamics.outputs import DIRECTIONS, POSE
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.program.lower import formulate, lower
from symdyn.program.routine import Program
from symdyn.scene import Scene

if TYPE_CHECKING:  # code is written where there is no NumPy
    import numpy as np

    Array = np.ndarray[Any, Any]


def tunable(
    scene: Scene,
    outputs: Sequence[str],
    formulation: str | None = None,
    closing: LoopChoices = LoopChoices(),  # noqa: B008  frozen
) -> Program:
    """Return the program of outputs with every parameter in `params`; its scene keeps their values.

    Raises:
        DerivationError: as `formulate`; or loops close a scene of which a parameter has no value.
    """
    free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    if scene.is_constrained:
        if scene.free_parameters:
            names = [one.name for one in scene.free_parameters]
            raise DerivationError(
                f"{scene.name}: {', '.join(names)} {'has' if len(names) == 1 else 'have'} no value, at which the loops "
                f"are looked at; give {argument('values', dict.fromkeys(names, 1))}, or what they are"
            )
        known = ((one.name, one.value.at({})) for one in scene.parameters if one.value is not None)
        closing = replace(closing, parameters=tuple((name, float(value or 0)) for name, value in known))
    return replace(lower(formulate(free, outputs, formulation, closing)), scene=scene)


DRAWS = 40  # states tried for one at which a function is real

RANGES = {
    "q": 3.0,
    "qd": 2.0,
    "qdd": 2.0,
    "tau": 5.0,
    "t": 3.0,
    "inputs": 3.0,
    "internal": 3.0,
    POSE: 0.5,
}  # half-widths of the sampled states, SI
RANGES |= dict.fromkeys((*DIRECTIONS.values(), "weights", "p"), 2.0)


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
        import numpy as np

        drawn = []
        for one in self.arguments:
            wide = RANGES.get(one.name)
            low, high = (-wide * widen, wide * widen) if wide else (0.5, 1.5 * widen)
            state = np.array([self.rng.uniform(low, high) for _ in one.symbols])
            for k in quaternion_places(one.units) if one.name == "q" else ():
                state[k : k + 4] /= np.linalg.norm(state[k : k + 4])
            if one.name == POSE:
                turn = np.linalg.qr(state.reshape(3, 4)[:, :3])[0]
                state = np.column_stack([turn * np.linalg.det(turn), state[3::4]])
            state = state.reshape(one.shape)
            drawn.append(state.astype(np.float32).astype(np.float64) if self.real == "float" else state)
        return drawn


def quaternion_places(units: Sequence[str]) -> list[int]:
    """Return where quaternions begin among coordinates: four numbers without a unit."""
    return [k for k, unit in enumerate(units) if unit == "1"][::4]
