"""Gains from weights or poles: regulators, the gain of a Kalman filter, and both together as a controller of outputs.

    w = w0 - K x       least ∫ xᵀ Q x + (w - w0)ᵀ R (w - w0) dt; sampled: the least sum over samples, inputs held
    A - B K            the closed loop
    x̂' = A x̂ + B w + L (y - C x̂)      K = Lᵀ of (Aᵀ, Cᵀ), with covariances W of what disturbs x and V of what disturbs y
    w = w0 - K x̂       by the filter: x̂' = (A - B K - L C + L D K) x̂ + L y, in deviations from the point

Users give weights and variances by name or as matrices, whose rows and columns have names and units (`Axis`).

What is weighted and does not decay by itself must be moved by some input. What stays or swings for ever and has no
weight, such as the place of a wheel on the ground, is left alone, and a note says so.

References: Anderson and Moore, Optimal Control: Linear Quadratic Methods (1990), sections 2.3, 3.3 and 8.1; Tits and
Yang, Globally convergent algorithms for robust pole assignment by state feedback, IEEE Trans. Aut. Control 41 (1996).
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.linear.locus import array_of
from symdyn.linear.modes import SIDEWAYS, Complexes, balance, pairs_of, spectrum
from symdyn.linear.plots import Plotted, pole_map
from symdyn.linear.state_space import StateSpace
from symdyn.linear.transfer import Margins, poles_in_words, shown, staircase
from symdyn.linear.weights import Axis, Weights, weight
from symdyn.scene.values import Faults
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.simulation import Feedback

MOVING = "the point is neither of rest nor of a steady motion: nothing holds the mechanism there, gains neither"
SPINNING = (
    "states and drives along axes of a body are in axes that do not spin with it: a controller has to turn them; "
    "simulate reads gains in axes of the body, at one orientation of it"
)
"""What is said of gains beside forces that feed back, at a point where velocities change, and in axes that turn."""


class _Gain(Plotted):
    """A gain that was found for a system."""

    system: Linearization

    @property
    def name(self) -> str:
        """What it is of."""
        return self.system.name


@dataclass(frozen=True, eq=False)
class Regulator(_Gain):
    """Feedback of the state.

    Attributes:
        system: what it was found for.
        inputs: the drives, which it acts by; all inputs of a scene without any.
        K: shape (inputs, nx).
        poles: eigenvalues of the closed loop, 1/s; of a sampled one those of Φ - Γ K.
        period: seconds between samples; None is none.
        notes: what a user should know.
    """

    system: Linearization
    inputs: tuple[str, ...]
    K: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        told = "".join(f"\n    {line}" for line in (*self.lines(), f"poles: {poles_in_words(self.poles)}"))
        return f"<Regulator of {self.name}{_when(self.period)}:{told}>"

    @property
    def closed_loop(self) -> StateSpace:
        """The mechanism with this feedback, from all its inputs, which are added to it, to its outputs."""
        one, (step, places) = self.system, _opened(self.system, self.inputs, self.period)
        A, C = step.A - step.B[:, places] @ self.K, one.C - one.D[:, places] @ self.K
        return StateSpace(A, step.B, C, one.D, one.states, one.inputs, one.outputs, self.period, f"{one.name}_closed")

    @property
    def loop(self) -> StateSpace:
        """The loop cut open at the drives, from them to K x, for `.margins()` and `.nyquist()`."""
        step, places = _opened(self.system, self.inputs, self.period)
        axis = self.system.inputs.of(places)
        return StateSpace(
            step.A, step.B[:, places], self.K, None, self.system.states, axis, axis, self.period, f"{self.name}_loop"
        )

    def gains(self) -> dict[str, object]:
        """Return what `symdyn simulate --feedback` reads."""
        one = self.system
        point = dict(zip(one.scene.coordinates, one.point.q.tolist(), strict=True))
        point |= dict(zip(one.scene.first_order, one.point.u.tolist(), strict=True))
        found: dict[str, object] = {
            "K": self.K.tolist(),
            "states": list(one.states.names),
            "inputs": list(self.inputs),
            "x0": point,
            "u0": held(one, self.inputs),
        }
        return found if self.period is None else found | {"period": self.period}

    def feedback(self) -> Feedback:
        """Return it as a controller of a run, u = u0 - K (x - x0)."""
        from symdyn.simulation import read_feedback

        return read_feedback(self.system.scene, self.gains())

    def text(self) -> str:
        """Return the gains as JSON text, a row of K a line."""
        said = {name: json.dumps(value, allow_nan=False) for name, value in self.gains().items()}
        rows = ",\n    ".join(json.dumps(row) for row in self.K.tolist())
        said["K"] = f"[\n    {rows}\n  ]"
        return "{\n" + ",\n".join(f'  "{name}": {value}' for name, value in said.items()) + "\n}\n"

    def lines(self) -> list[str]:
        """Return a formula in deviations of the states for each input, one line each."""
        return [f"{name} = {self._terms(row)}" for name, row in zip(self.inputs, self.K, strict=True)]

    def _terms(self, row: Array) -> str:
        parts = [f"{-x:+.6g} {name}" for x, name in zip(row, self.system.states.names, strict=True) if abs(x) > 1e-12]
        return " ".join(parts).replace("+", "+ ").replace("-", "- ").replace("e- ", "e-").replace("e+ ", "e+") or "0"

    def tables(self) -> list[Table[str | float]]:
        """Return K with its names."""
        return [Table.matrix("K", self.inputs, self.system.states.names, self.K.tolist())]

    def _figure(self) -> FilledFigure:
        return _before_and_after(self.system, self.poles, self.period, "closed loop")

    def as_json(self) -> dict[str, object]:
        """Return it for JSON, poles and notes beside the gains."""
        return self.gains() | {"poles": pairs_of(self.poles), "notes": list(self.notes)}


@dataclass(frozen=True, eq=False)
class Observer(_Gain):
    """The gain of a Kalman filter, L, shape (nx, ny), and the poles of A - L C; of a sampled one of Φ - L C."""

    system: Linearization
    L: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        outputs = ", ".join(self.system.outputs.names)
        return f"<Observer of {self.name} from {outputs}{_when(self.period)}; poles: {poles_in_words(self.poles)}>"

    def tables(self) -> list[Table[str | float]]:
        """Return L with its names."""
        return [Table.matrix("L", self.system.states.names, self.system.outputs.names, self.L.tolist())]

    def _figure(self) -> FilledFigure:
        return _before_and_after(self.system, self.poles, self.period, "filter")

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
        step, places = _opened(one, regulator.inputs, regulator.period)
        names = tuple(f"{name}_estimate" for name in one.states.names)
        A = step.A - step.B[:, places] @ K - L @ one.C + L @ one.D[:, places] @ K
        D = np.zeros((len(K), len(one.C)))
        super().__init__(
            A, -L, -K, D, Axis(names, one.states.units), one.outputs, one.inputs.of(places), regulator.period,
            f"{one.name}_lqg",
        )  # fmt: skip
        object.__setattr__(self, "regulator", regulator)
        object.__setattr__(self, "observer", observer)

    def margins(self, output: str | None = None, input: str | None = None) -> Margins:
        """Return how far the loop, cut open at a drive, is from the edge of stability; errors as of a system."""
        return self.loop.margins(output, input)

    @property
    def loop(self) -> StateSpace:
        """The loop cut open at the drives, from them to what the controller takes off them, for `.margins()`."""
        one = self.regulator.system
        step, places = _opened(one, self.outputs.names, self.period)
        states = Axis((*one.states.names, *self.states.names), (*one.states.units, *self.states.units))
        A = np.block([[step.A, np.zeros((len(step.A),) * 2)], [-self.B @ one.C, self.A]])
        B = np.vstack([step.B[:, places], -self.B @ one.D[:, places]])
        C = np.hstack([np.zeros((len(places), len(step.A))), -self.C])
        return StateSpace(A, B, C, None, states, self.outputs, self.outputs, self.period, f"{one.name}_loop")

    @property
    def closed_loop(self) -> StateSpace:
        """The mechanism with this feedback, from all its inputs, which are added to it, to its outputs."""
        one = self.regulator.system
        step, places = _opened(one, self.outputs.names, self.period)
        by, through = step.B[:, places] @ self.C, one.D[:, places] @ self.C
        L = self.observer.L
        states = Axis((*one.states.names, *self.states.names), (*one.states.units, *self.states.units))
        return StateSpace(
            np.block([[step.A, by], [L @ one.C, self.A + L @ through]]), np.vstack([step.B, L @ one.D]),
            np.hstack([one.C, through]), one.D, states, one.inputs, one.outputs, self.period, f"{one.name}_closed",
        )  # fmt: skip

    def feedback(self) -> Feedback:
        """Return it as a controller of a run, about the point: it adds to the drives there, given the outputs there."""
        from symdyn.simulation import linear_law

        one = self.regulator.system
        return linear_law(
            self.A, self.B, self.C, self.D, self.inputs.names, self.outputs.names, period=self.period,
            y0=dict(zip(one.outputs.names, one.point.outputs.tolist(), strict=True)),
            u0=held(one, self.outputs.names), states=self.states.names,
        )  # fmt: skip


def held(one: Linearization, inputs: Sequence[str]) -> dict[str, float]:
    """Return what inputs have at the point beside formulas that feed back."""
    names = [*map(str, one.scene.drives), *(letter.name for letter in one.scene.inputs)]
    found = np.concatenate([one.point.tau, one.point.inputs]) - (one.feeding or 0.0)
    return {name: float(found[names.index(name)]) for name in inputs}


def _when(period: float | None) -> str:
    return "" if period is None else f", every {period:g} s"


def _before_and_after(one: Linearization, poles: Complexes, period: float | None, what: str) -> FilledFigure:
    """Return a map of the poles that were found, and of those of the system itself."""
    return pole_map(f"{one.name}: poles", {what: poles, "mechanism": _steps(one, period).poles}, period=period)


def controls(one: Linearization) -> list[int]:
    """Return the inputs that a regulator acts by: drives, or all where there is none."""
    rates = one.scene.rates
    free = [k for k, name in enumerate(one.inputs.names) if name not in (*rates, *rates.values())]
    if not free:
        why = "only inputs with rates move it, by which no regulator acts" if rates else "nothing drives it"
        raise LinearizeError(f"{one.scene.name}: {why}; declare a drive, or an input: [inputs.u]")
    return [k for k in free if one.inputs.names[k] in one.scene.drives] or free


def _regulator(one: Linearization, used: list[int], K: Array, poles: Complexes, period: float | None,
               notes: tuple[str, ...] = ()) -> Regulator:  # fmt: skip
    """Return gains with what is said of them at the point."""
    if one.feeding:
        formulas = f"the formulas of {argument('forces')} depend on the state"
        notes = (*notes, f"{formulas}: gains act beside them, give them to simulate, too")
    if one.kind == "moving":
        notes = (*notes, MOVING)
    if one.spin.any():
        notes = (*notes, SPINNING)
    return Regulator(one, one.inputs.of(used).names, K, poles, period, notes)


def lqr(
    one: Linearization, Q: Weights | None = None, R: Weights | None = None, period: float | None = None
) -> Regulator:
    """Return the linear quadratic regulator of a system; arguments and errors as of its method."""
    used, faults = controls(one), Faults("")
    heavy = weight("Q", Q, one.states, faults)
    light = weight("R", R, one.inputs.of(used), faults, definite=True, inputs=one.inputs)
    faults.close(LinearizeError)
    step = _steps(one, period)
    K, poles, notes = _gain(
        one.A, one.B[:, used], step.A, step.B[:, used], heavy, light, period, WORDS["lqr"], one.states.names
    )
    return _regulator(one, used, K, poles, period, notes)


def place(one: Linearization, poles: Sequence[complex] | Array, period: float | None = None) -> Regulator:
    """Return the regulator that gives the closed loop its poles; arguments and errors as of the method of a system."""
    from scipy.signal import place_poles  # late: it takes long to load

    used, names = controls(one), one.states.names
    wanted, step = _wanted(poles, names), _steps(one, period)
    scale = balance(one.A)
    A, B = one.A * scale[None, :] / scale[:, None], one.B[:, used] / scale[:, None]
    size, beside = float(np.linalg.norm(A, 2)) or 1.0, staircase(A, B)[1]
    if beside.shape[1]:
        stuck = spectrum(beside.T @ A @ beside, size).values[0]
        raise LinearizeError(
            f"poles: no input moves the mode {shown(stuck)}, of {_named(beside, names)}; it stays there"
        )
    most = int(np.linalg.matrix_rank(B))
    often = [value for value in wanted if np.count_nonzero(wanted == value) > most]
    if often:
        raise LinearizeError(
            f"poles: {shown(often[0])} is asked for more than {most} times, which is what drives can do"
        )
    A, B = step.A * scale[None, :] / scale[:, None], step.B[:, used] / scale[:, None]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the most robust gains were not reached; these are looked at below
            K = np.asarray(place_poles(A, B, wanted).gain_matrix, dtype=np.float64)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise LinearizeError(f"poles: cannot be placed: {error}") from None
    found = np.linalg.eigvals(A - B @ K).astype(np.complex128)
    apart = max(float(np.abs(found - value).min()) for value in wanted)
    if not apart <= PLACED * max(1.0, float(np.abs(wanted).max())):
        raise LinearizeError("poles: cannot be placed to six digits: a mode is close to one that no input moves")
    return _regulator(one, used, K / scale[None, :], found[np.argsort(-found.real, kind="stable")], period)


PLACED = 1e-6
"""Distance of poles from those that were asked for, over the largest, that is rounding."""


def _wanted(poles: Sequence[complex] | Array, names: tuple[str, ...]) -> Complexes:
    found: Complexes = array_of(poles, complex)
    if found.shape != (len(names),) or not np.isfinite(found).all():
        raise LinearizeError(f"poles: give {len(names)} finite numbers, one for each of {', '.join(names)}")
    for value in found:
        if np.count_nonzero(found == value) != np.count_nonzero(found == value.conjugate()):
            raise LinearizeError(f"poles: {value:g} comes without its conjugate {value.conjugate():g}; give both")
    return found


def kalman(
    one: Linearization, W: Weights | None = None, V: Weights | None = None, period: float | None = None
) -> Observer:
    """Return the gain of the Kalman filter of a system; arguments and errors as of its method."""
    faults = Faults("")
    if not one.outputs.names:
        raise LinearizeError(f"{one.name}: nothing is measured; give outputs to linearize")
    step = _steps(one, period)
    disturbed = _disturbed(W, one, step.B, faults)
    noise = weight("V", V, one.outputs, faults, definite=True)
    faults.close(LinearizeError)
    K, poles, notes = _gain(
        one.A.T, one.C.T, step.A.T, one.C.T, disturbed, noise, period, WORDS["kalman"], one.states.names
    )
    return Observer(one, K.T, poles, period, notes)


def _opened(one: Linearization, inputs: Sequence[str], period: float | None) -> tuple[StateSpace, list[int]]:
    """Return the open loop, sampled if there is a period, and the places of inputs."""
    return _steps(one, period), [one.inputs.names.index(name) for name in inputs]


def _steps(one: StateSpace, period: float | None) -> StateSpace:
    return one if period is None else one.discretize(period)


def _disturbed(W: Weights | None, one: Linearization, B: Array, faults: Faults) -> Array:
    if not isinstance(W, Mapping):
        if W is None and one.inputs.names:
            return B @ B.T
        return weight("W", W, one.states, faults)
    names = (*one.states.names, *one.inputs.names)
    both = weight("W", W, Axis(names, ("",) * len(names)), faults)
    n = len(one.states)
    return both[:n, :n] + B @ both[n:, n:] @ B.T


WORDS = {
    "lqr": ("Q", "gives no weight to", "no input moves"),
    "kalman": ("W", "lets nothing disturb", "no output shows"),
}
"""How faults call the weight of what is minimised, what it lacks, and a mode that is out of reach."""


def _gain(
    A: Array, B: Array, step: Array, held: Array, Q: Array, R: Array, period: float | None,
    words: tuple[str, str, str], names: tuple[str, ...],
) -> tuple[Array, Complexes, tuple[str, ...]]:  # fmt: skip
    """Return K, the poles, and notes; `step` and `held` are A and B, or those of a sampled system."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are  # late: it takes long to load

    (weighed, forgets, beyond), scale = words, balance(A)
    A, B, Q = A * scale[None, :] / scale[:, None], B / scale[:, None], Q * scale[None, :] * scale[:, None]
    step, held = step * scale[None, :] / scale[:, None], held / scale[:, None]
    size = float(np.linalg.norm(A, 2)) or 1.0
    seen, unseen = staircase(A.T, Q)
    basis, notes = np.eye(len(A)), tuple[str, ...]()
    drifting = _lasting(unseen.T @ A @ unseen, size)
    if any(value.real <= SIDEWAYS * size for value in drifting):
        if drifting[0].real > SIDEWAYS * size:
            raise LinearizeError(
                f"{weighed} {forgets} the mode {shown(drifting[0])}, of {_named(unseen, names)}, which "
                "grows; name those there"
            )
        basis, notes = seen, (f"left alone: {_named(unseen, names)}; {weighed} {forgets} them",)
    if not basis.shape[1]:
        raise LinearizeError(f"{weighed} {forgets} anything that has to be; give weights by name")
    part, way = basis.T @ A @ basis, basis.T @ B
    beside = staircase(part, way)[1]
    stuck = _lasting(beside.T @ part @ beside, size)
    if stuck:
        raise LinearizeError(
            f"{beyond} the mode {shown(stuck[0])}, of {_named(basis @ beside, names)}, and it does not decay; "
            f"leave those out of {weighed}, or let something reach them"
        )
    part, way, cost = basis.T @ step @ basis, basis.T @ held, basis.T @ Q @ basis
    try:
        P = (solve_continuous_are if period is None else solve_discrete_are)(part, way, (cost + cost.T) / 2, R)
        light, heavy = (R, way.T @ P) if period is None else (R + way.T @ P @ way, way.T @ P @ part)
        K = np.linalg.solve(light, heavy)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise LinearizeError(f"the Riccati equation has no solution that stabilises: {error}") from None
    poles = np.linalg.eigvals(part - way @ K).astype(np.complex128)
    if not np.isfinite(K).all() or not np.all((poles.real < 0) if period is None else (np.abs(poles) < 1)):
        raise LinearizeError(
            "not all poles of what was found decay; weights differ by too much, or a mode is close to one out of reach"
        )
    return K @ basis.T / scale[None, :], poles[np.argsort(-poles.real, kind="stable")], notes


def _lasting(A: Array, size: float) -> list[complex]:
    """Return eigenvalues that do not decay, those that grow fastest first."""
    found = spectrum(A, size)
    return [*(mode.value for mode in found.modes if mode.value.real >= -SIDEWAYS * size), *[0j] * found.zeros]


def _named(space: Array, names: tuple[str, ...]) -> str:
    """Return the names of the states that take part in a space of balanced states."""
    share = np.linalg.norm(space, axis=1)
    return ", ".join(name for name, x in zip(names, share, strict=True) if x > 0.1 * share.max(initial=0.0))
