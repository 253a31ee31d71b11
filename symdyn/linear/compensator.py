"""The gain of a Kalman filter, and a controller of outputs: a regulator of the state that the filter estimates.

x̂' = A x̂ + B w + L (y - C x̂)      L = Kᵀ of (Aᵀ, Cᵀ), with covariances W of what disturbs x and V of what disturbs y
w = w0 - K x̂       by the filter: x̂' = (A - B K - L C + L D K) x̂ + L y, in deviations from the point
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError, listed
from symdyn.frozen import dataclass, replace
from symdyn.linear.modes import NOTHING, Complexes, pairs_of
from symdyn.linear.regulator import Gain, Regulator, at_drive, before_and_after, held, opened, riccati, steps, when
from symdyn.linear.stability import Margins
from symdyn.linear.state_space import StateSpace
from symdyn.linear.transfer import poles_in_words
from symdyn.linear.weights import Axis, Weights, weight
from symdyn.scene.values import Faults
from symdyn.simulation import Feedback
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization


@dataclass(frozen=True, eq=False)
class Observer(Gain):
    """The gain of a Kalman filter, L, shape (nx, ny), and the poles of A - L C; of a sampled one of Φ - L C.

    P, shape (nx, nx), is the covariance of what it estimates; `L, P, E = lin.kalman(W, V)` as python-control.
    """

    system: Linearization
    L: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()
    P: Array | None = None

    def __iter__(self) -> Iterator[Any]:
        """Yield L, P and the poles."""
        return iter((self.L, self.P, self.poles))

    def __repr__(self) -> str:
        outputs = ", ".join(self.system.outputs.names)
        notes = "".join(f"; {note}" for note in self.notes)
        poles = f"poles: {poles_in_words(self.poles)}{notes}"
        return f"<Observer of {self.name} from {outputs}{when(self.period)}; {poles}>"

    def tables(self) -> list[Table[str | float]]:
        """Return L with its names."""
        return [Table.matrix("L", self.system.states.names, self.system.outputs.names, self.L.tolist())]

    def _figure(self) -> FilledFigure:
        return before_and_after(self.system, self.poles, self.period, "filter")

    def feedback(self) -> NoReturn:
        """Raise LinearizeError: an estimate of the state is no force."""
        raise LinearizeError(
            f"{self.name}: an observer estimates the state, and drives nothing; give lin.lqg(Q, R, W, V), which has a "
            "regulator beside it"
        )

    def as_json(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "L": self.L.tolist(), "states": list(self.system.states.names),
            "outputs": list(self.system.outputs.names), "poles": pairs_of(self.poles),
        }  # fmt: skip


class Compensator(StateSpace):
    """A regulator of the state that a filter estimates: a linear system from r - y, of outputs, to drives.

    Attributes:
        regulator, observer: what it is made of.
    """

    regulator: Regulator
    observer: Observer

    def __init__(self, regulator: Regulator, observer: Observer) -> None:
        one, K, L = regulator.system, regulator.K, observer.L
        step, places = opened(one, regulator.inputs, regulator.period)
        names = tuple(f"{name}_estimate" for name in one.states.names)
        A = step.A - step.B[:, places] @ K - L @ one.C + L @ one.D[:, places] @ K
        super().__init__(
            A, -L, -K, None, Axis(names, one.states.units), one.outputs, one.inputs.of(places), regulator.period,
            f"{one.name}_lqg",
        )  # fmt: skip
        object.__setattr__(self, "regulator", regulator)
        object.__setattr__(self, "observer", observer)

    def __repr__(self) -> str:
        notes = "".join(f"; {note}" for note in (*self.regulator.notes, *self.observer.notes))
        return f"{super().__repr__()[:-1]}{notes}>"

    def margins(self, drive: str | None = None) -> Margins:  # type: ignore[override]  # of its loop
        """Return how far the loop, cut open at a drive, is from the edge of stability, as of a `Regulator`."""
        found = at_drive(self.loop, drive).margins()
        both = (found.left_alone, found.drifting)
        alone, drifting = (tuple(x for x in one if x not in self.states.names) or one for one in both)
        return replace(found, left_alone=alone, drifting=drifting)

    @property
    def loop(self) -> StateSpace:
        """The loop cut open at the drives, from them to what the controller takes off them, for `.margins()`."""
        one = self.regulator.system
        step, places = opened(one, self.outputs.names, self.period)
        states = Axis((*one.states.names, *self.states.names), (*one.states.units, *self.states.units))
        A = np.block([[step.A, np.zeros((len(step.A),) * 2)], [-self.B @ one.C, self.A]])
        B = np.vstack([step.B[:, places], -self.B @ one.D[:, places]])
        C = np.hstack([np.zeros((len(places), len(step.A))), -self.C])
        return StateSpace(A, B, C, None, states, self.outputs, self.outputs, self.period, f"{one.name}_loop")

    @property
    def closed_loop(self) -> StateSpace:
        """The mechanism with this feedback, from all its inputs, which are added to it, to its outputs."""
        one = self.regulator.system
        step, places = opened(one, self.outputs.names, self.period)
        by, through = step.B[:, places] @ self.C, one.D[:, places] @ self.C
        L = self.observer.L
        states = Axis((*one.states.names, *self.states.names), (*one.states.units, *self.states.units))
        return StateSpace(
            np.block([[step.A, by], [L @ one.C, self.A + L @ through]]), np.vstack([step.B, L @ one.D]),
            np.hstack([one.C, through]), one.D, states, one.inputs, one.outputs, self.period, f"{one.name}_closed",
        )  # fmt: skip

    def feedback(self) -> Feedback:
        """Return it as a controller of a run, about the point: it adds to the drives there, given the outputs there."""
        one, point, found = self.regulator.system, self.regulator.point, super().feedback()
        zero = np.array([point.get(name, 0.0) for name in one.states.names])
        y0, u0 = one.point.outputs.tolist(), held(one, self.outputs.names).values()
        return replace(found, law=replace(found.law, y0=tuple(y0), initial=tuple(u0), shown=(zero, self._led())))

    def _led(self) -> Array:
        """Return x_r over r and ṙ, shape (2, nx, ny): where outputs are at r, as near to 0 = ẋ - ẋ_r as that leaves.

        What z estimates is x - x_r: [C D] [x_r; w_r] = r, and [A B] [x_r; w_r] = ẋ_r, in least squares.
        """
        one, n = self.regulator.system, len(self.A)
        places = [one.inputs.names.index(name) for name in self.outputs.names]
        moves, seen = np.hstack([one.A, one.B[:, places]]), np.hstack([one.C, one.D[:, places]])
        back = np.linalg.pinv(seen)
        free = np.eye(len(back)) - back @ seen
        hidden = free @ np.linalg.pinv(moves @ free, rcond=NOTHING)
        still = back - hidden @ moves @ back
        return np.array([still[:n], (hidden @ still[:n])[:n]])


def kalman(
    one: Linearization, W: Weights | None = None, V: Weights | None = None, period: float | None = None
) -> Observer:
    """Return the gain of the Kalman filter of a system; arguments and errors as of its method."""
    faults = Faults("")
    if not one.outputs.names:
        raise LinearizeError(f"{one.name}: nothing is measured; give outputs to linearize")
    step = steps(one, period)
    forms = ("{}/s", "{} s") if period is None else ("{}", "{}")  # spectral densities, or variances
    disturbed = _disturbed(W, one, step.B, forms, faults)
    noise = weight("V", V, one.outputs.squared(forms[1]), faults, definite=True)
    faults.close(LinearizeError)
    K, P, poles, notes = riccati(
        one.A.T, one.C.T, step.A.T, one.C.T, disturbed, noise, period, "kalman", one.states.names, one.outputs.names
    )
    missed = [name for name in one.outputs.names if isinstance(V, Mapping) and name not in V]
    if missed:
        outputs = argument("outputs", [name for name in one.outputs.names if name not in missed])
        notes = (*notes, f"V misses {listed(missed)}: measured with variance 1; linearize with {outputs} leaves it out")
    return Observer(one, K.T, poles, period, notes, P)


def _disturbed(W: Weights | None, one: Linearization, B: Array, forms: tuple[str, str], faults: Faults) -> Array:
    if not isinstance(W, Mapping):
        if W is None and one.inputs.names:
            return B @ B.T
        return weight("W", W, one.states, faults)
    states, inputs = one.states.squared(forms[0]), one.inputs.squared(forms[1])
    both = weight("W", W, Axis((*states.names, *inputs.names), (*states.units, *inputs.units)), faults)
    n = len(one.states)
    return both[:n, :n] + B @ both[n:, n:] @ B.T
