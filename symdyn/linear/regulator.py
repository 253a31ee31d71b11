"""Gains from weights: the linear quadratic regulator, and by the dual equation the gain of a Kalman filter.

    w = w0 - K x       least ∫ xᵀ Q x + (w - w0)ᵀ R (w - w0) dt; sampled: the least sum over samples, inputs held
    A - B K            the closed loop
    x̂' = A x̂ + B w + L (y - C x̂)      K = Lᵀ of (Aᵀ, Cᵀ), with covariances W of what disturbs x and V of what disturbs y

What is weighed and does not decay by itself has to be moved by some input. What stays or swings for ever and is not
weighed, as the place of a wheel on the ground, is left alone, and said.

Reference: Anderson and Moore, Optimal Control: Linear Quadratic Methods (1990), sections 2.3, 3.3 and 8.1.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError
from symdyn.linear.axis import Axis
from symdyn.linear.modes import SIDEWAYS, Complexes, balance, pairs_of, spectrum
from symdyn.linear.reach import shown, staircase
from symdyn.linear.sampled import sampled
from symdyn.linear.weights import Weights, weight
from symdyn.scene.values import Faults

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization

FEEDING = "the formulas of --forces depend on the state: gains act beside them, give them to simulate, too"
MOVING = "the point is neither of rest nor of a steady motion: nothing holds the mechanism there, gains neither"
SPINNING = (
    "states and drives along axes of a body are in axes that do not spin with it: a controller has to turn them; "
    "simulate reads gains in axes of the body, at one orientation of it"
)
"""What is said of gains beside forces that feed back, at a point where velocities change, and in axes that turn."""


@dataclass(frozen=True)
class Regulator:
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

    def gains(self) -> dict[str, object]:
        """Return what `symdyn simulate --feedback` reads."""
        one = self.system
        names = [*map(str, one.scene.drives), *(letter.name for letter in one.scene.inputs)]
        point = dict(zip(one.scene.coordinates, one.point.q.tolist(), strict=True))
        point |= dict(zip(one.scene.velocities, one.point.u.tolist(), strict=True))
        held = np.concatenate([one.point.tau, one.point.inputs]) - (one.feeding or 0.0)
        found: dict[str, object] = {
            "K": self.K.tolist(),
            "states": list(one.states.names),
            "inputs": list(self.inputs),
            "x0": point,
            "u0": {name: float(held[names.index(name)]) for name in self.inputs},
        }
        return found if self.period is None else found | {"period": self.period}

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

    def as_json(self) -> dict[str, object]:
        """Return it for JSON, poles and notes beside the gains."""
        return self.gains() | {"poles": pairs_of(self.poles), "notes": list(self.notes)}


@dataclass(frozen=True)
class Observer:
    """The gain of a Kalman filter, L, shape (nx, ny), and the poles of A - L C; of a sampled one of Φ - L C."""

    system: Linearization
    L: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()

    def as_json(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "L": self.L.tolist(), "states": list(self.system.states.names),
            "outputs": list(self.system.outputs.names), "poles": pairs_of(self.poles),
        }  # fmt: skip


def lqr(
    one: Linearization, Q: Weights | None = None, R: Weights | None = None, period: float | None = None
) -> Regulator:
    """Return the linear quadratic regulator of a system.

    Args:
        one: the system.
        Q: weights of states by name, others 0, or a matrix, shape (nx, nx), positive semidefinite; 1 each without.
        R: of drives likewise, positive definite, others 1; other inputs are no controls where there are drives.
        period: seconds between samples, for gains of a sampled controller.

    Raises:
        LinearizeError: with every fault: a name that is not known, a weight that is none; a mode that is weighed,
            does not decay, and that no input moves.
    """
    if not one.inputs.names:
        raise LinearizeError(f"{one.scene.name}: nothing drives it; declare a drive, or an input: [inputs.u]")
    drives = [k for k, name in enumerate(one.inputs.names) if name in one.scene.drives]
    used = drives or list(range(len(one.inputs)))
    inputs = one.inputs.of(used)
    faults = Faults("")
    heavy = weight("Q", Q, one.states, faults)
    light = weight("R", R, inputs, faults, definite=True)
    _close(faults)
    A, B = _steps(one, period)
    K, poles, notes = _gain(one.A, one.B[:, used], A, B[:, used], heavy, light, period, WORDS["lqr"], one.states.names)
    if one.feeding:
        notes = (*notes, FEEDING)
    if one.kind == "moving":
        notes = (*notes, MOVING)
    if one.spin.any():
        notes = (*notes, SPINNING)
    return Regulator(one, inputs.names, K, poles, period, notes)


def kalman(
    one: Linearization, W: Weights | None = None, V: Weights | None = None, period: float | None = None
) -> Observer:
    """Return the gain of the Kalman filter of a system, a predictor where it is sampled.

    Args:
        one: the system.
        W: variances of what disturbs the rates of states by name, or inputs, by which they come in; others 0; or a
            matrix, shape (nx, nx); 1 for each input, or each state where there is no input, without.
        V: variances of outputs by name, which must be above zero, or a matrix, shape (ny, ny); 1 each without.
        period: seconds between samples.

    Raises:
        LinearizeError: with every fault, as of `lqr`: a mode that does not decay and that no output shows.
    """
    faults = Faults("")
    A, B = _steps(one, period)
    disturbed = _disturbed(W, one, B, faults)
    noise = weight("V", V, one.outputs, faults, definite=True)
    _close(faults)
    K, poles, notes = _gain(one.A.T, one.C.T, A.T, one.C.T, disturbed, noise, period, WORDS["kalman"], one.states.names)
    return Observer(one, K.T, poles, period, notes)


def _steps(one: Linearization, period: float | None) -> tuple[Array, Array]:
    if period is None:
        return one.A, one.B
    found = sampled(one, period)
    return found.A, found.B


def _disturbed(W: Weights | None, one: Linearization, B: Array, faults: Faults) -> Array:
    if not isinstance(W, Mapping):
        if W is None and one.inputs.names:
            return B @ B.T
        return weight("W", W, one.states, faults)
    names = (*one.states.names, *one.inputs.names)
    both = weight("W", W, Axis(names, ("",) * len(names)), faults)
    n = len(one.states)
    return both[:n, :n] + B @ both[n:, n:] @ B.T


@dataclass(frozen=True)
class RegulatorWords:
    """How faults speak: the weight of what is minimised, what it lacks, and how a mode is out of reach."""

    weight: str
    forgets: str
    beyond: str


WORDS = {
    "lqr": RegulatorWords("Q", "gives no weight to", "no input moves"),
    "kalman": RegulatorWords("W", "lets nothing disturb", "no output shows"),
}


def _gain(
    A: Array, B: Array, step: Array, held: Array, Q: Array, R: Array, period: float | None,
    words: RegulatorWords, names: tuple[str, ...],
) -> tuple[Array, Complexes, tuple[str, ...]]:  # fmt: skip
    """Return K, the poles, and notes; `step` and `held` are A and B, or those of a sampled system."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are  # late: it takes long to load

    scale = balance(A)
    A, B, Q = A * scale[None, :] / scale[:, None], B / scale[:, None], Q * scale[None, :] * scale[:, None]
    step, held = step * scale[None, :] / scale[:, None], held / scale[:, None]
    size = float(np.linalg.norm(A, 2)) or 1.0
    seen, unseen = staircase(A.T, Q)
    basis, notes = np.eye(len(A)), tuple[str, ...]()
    drifting = _lasting(unseen.T @ A @ unseen, size)
    if any(value.real <= SIDEWAYS * size for value in drifting):
        if drifting[0].real > SIDEWAYS * size:
            raise LinearizeError(
                f"{words.weight} {words.forgets} the mode {shown(drifting[0])}, of {_named(unseen, names)}, which "
                "grows; name those there"
            )
        basis, notes = seen, (f"left alone: {_named(unseen, names)}; {words.weight} {words.forgets} them",)
    if not basis.shape[1]:
        raise LinearizeError(f"{words.weight} {words.forgets} anything that has to be; give weights by name")
    part, way = basis.T @ A @ basis, basis.T @ B
    beside = staircase(part, way)[1]
    stuck = _lasting(beside.T @ part @ beside, size)
    if stuck:
        raise LinearizeError(
            f"{words.beyond} the mode {shown(stuck[0])}, of {_named(basis @ beside, names)}, and it does not decay; "
            f"leave those out of {words.weight}, or let something reach them"
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
            "not all poles of what was found decay; weights differ by too much, or a mode is next to one out of reach"
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


def _close(faults: Faults) -> None:
    faults.close(LinearizeError)
