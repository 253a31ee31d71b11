"""Gains from weights or poles: regulators of the state, and of integrals of outputs beside it.

    w = w0 - K x       least ∫ xᵀ Q x + 2 xᵀ N (w - w0) + (w - w0)ᵀ R (w - w0) dt = x0ᵀ S x0; sampled: a sum
    A - B K            the closed loop
    x̃ = [x; z]         with integral action: ż = y - r, sampled z' = z + T (y - r), of the outputs that are to be r

Users give weights and variances by name or as matrices, whose rows and columns have names and units (`Axis`).

References: Anderson and Moore, Optimal Control: Linear Quadratic Methods (1990), sections 2.3, 3.3 and 8.1; Tits and
Yang, Globally convergent algorithms for robust pole assignment by state feedback, IEEE Trans. Aut. Control 41 (1996).
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError, listed, suggestion
from symdyn.frozen import dataclass, replace
from symdyn.linear.locus import array_of
from symdyn.linear.modes import Complexes, array, balance, pairs_of, spectrum
from symdyn.linear.plots import Plotted, pole_map
from symdyn.linear.stability import Margins, verdict
from symdyn.linear.state_space import StateSpace
from symdyn.linear.transfer import named, poles_in_words, shown, staircase
from symdyn.linear.weights import SYMMETRIC, Axis, Weights, weight
from symdyn.scene.values import Faults
from symdyn.simulation import Feedback, linear_law, read_feedback
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization

MOVING = "the point is neither of rest nor of a steady motion: nothing holds the mechanism there, gains neither"
SPINNING = (
    "states and drives along axes of a body are in axes that do not spin with it: a controller has to turn them; "
    "simulate reads gains in axes of the body, at one orientation of it"
)
"""What is said of gains beside forces that feed back, at a point where velocities change, and in axes that turn."""


class Gain(Plotted):
    """A gain that was found for a system."""

    system: Linearization

    @property
    def name(self) -> str:
        """What it is of."""
        return self.system.name


@dataclass(frozen=True, eq=False)
class Regulator(Gain):
    """Feedback of the state.

    `K, S, E = lin.lqr(Q, R)` has gains, S and poles, as python-control.

    Attributes:
        system: what it was found for.
        inputs: the drives, which it acts by; all inputs of a scene without any.
        K: shape (inputs, nx), and a column an integral.
        poles: eigenvalues of the closed loop, 1/s; of a sampled one those of Φ - Γ K.
        period: seconds between samples; None is none.
        notes: what a user should know.
        S: what is left to pay, x0ᵀ S x0, shape (nx, nx), integrals behind states; None of gains for poles.
        integral: outputs, or states, whose integrals it acts on.
    """

    system: Linearization
    inputs: tuple[str, ...]
    K: Array
    poles: Complexes
    period: float | None = None
    notes: tuple[str, ...] = ()
    S: Array | None = None
    integral: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Any]:
        """Yield K, S and the poles."""
        return iter((self.K, self.S, self.poles))

    def __repr__(self) -> str:
        told = "".join(f"\n    {line}" for line in (*self.lines(), f"poles: {poles_in_words(self.poles)}", *self.notes))
        return f"<Regulator of {self.name}{when(self.period)}:{told}>"

    @property
    def closed_loop(self) -> StateSpace:
        """The mechanism with this feedback, from all its inputs, which are added to it, to its outputs."""
        step, places = opened(self.system, self.inputs, self.period, self.integral)
        A, C = step.A - step.B[:, places] @ self.K, step.C - step.D[:, places] @ self.K
        name = f"{self.name}_closed"
        return StateSpace(A, step.B, C, step.D, step.states, step.inputs, step.outputs, self.period, name)

    @property
    def loop(self) -> StateSpace:
        """The loop cut open at all drives at once, from them to K x, for `.nyquist()` and `.bode()`."""
        step, places = opened(self.system, self.inputs, self.period, self.integral)
        axis, name = step.inputs.of(places), f"{self.name}_loop"
        return StateSpace(step.A, step.B[:, places], self.K, None, step.states, axis, axis, self.period, name)

    def margins(self, drive: str | None = None) -> Margins:
        """Return how far the loop cut open at a drive, the others closed, is from the edge of stability."""
        return at_drive(self.loop, drive).margins()

    @property
    def _names(self) -> tuple[str, ...]:
        return (*self.system.states.names, *(f"{name}_integral" for name in self.integral))

    @property
    def point(self) -> dict[str, float]:
        """Coordinates and velocities where it acts, by name."""
        one = self.system
        found = dict(zip(one.scene.coordinates, one.point.q.tolist(), strict=True))
        return found | dict(zip(one.scene.first_order, one.point.u.tolist(), strict=True))

    def gains(self) -> dict[str, object]:
        """Return what `symdyn simulate --feedback` reads; LinearizeError of integrals, which it does not."""
        if self.integral:
            told = "gains act on integrals, too; in Python give the regulator itself: feedback=regulator"
            raise LinearizeError(f"{self.name}: {told}")
        return self._told

    @property
    def _told(self) -> dict[str, object]:
        point = {"x0": self.point, "u0": held(self.system, self.inputs)}
        found = {"K": self.K.tolist(), "states": list(self._names), "inputs": list(self.inputs), **point}
        return found if self.period is None else found | {"period": self.period}

    def feedback(self) -> Feedback:
        """Return it as a controller of a run, u = u0 - K (x - x0), integrals being states of the controller."""
        if not self.integral:
            return read_feedback(self.system.scene, self.gains())
        one, n, many = self.system, len(self.system.states), len(self.integral)
        names = (*one.states.names, *(name for name in self.integral if name not in one.states.names))
        point = self.point | dict(zip(one.outputs.names, one.point.outputs.tolist(), strict=True))
        summed = np.array([[float(name == other) for other in names] for name in self.integral])
        A, B = (np.zeros((many, many)), summed) if self.period is None else (np.eye(many), self.period * summed)
        D = np.hstack([self.K[:, :n], np.zeros((len(self.K), len(names) - n))])
        return linear_law(
            A, -B, -self.K[:, n:], D, names, self.inputs, period=self.period, y0={name: point[name] for name in names},
            u0=held(one, self.inputs), states=self._names[n:],
        )  # fmt: skip

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
        parts = [f"{-x:+.6g} {name}" for x, name in zip(row, self._names, strict=True) if abs(x) > 1e-12]
        return " ".join(parts).replace("+", "+ ").replace("-", "- ").replace("e- ", "e-").replace("e+ ", "e+") or "0"

    def tables(self) -> list[Table[str | float]]:
        """Return K with its names."""
        return [Table.matrix("K", self.inputs, self._names, self.K.tolist())]

    def _figure(self) -> FilledFigure:
        return before_and_after(self.system, self.poles, self.period, "closed loop")

    def as_json(self) -> dict[str, object]:
        """Return it for JSON, poles and notes beside the gains."""
        return self._told | {"poles": pairs_of(self.poles), "notes": list(self.notes)}


def held(one: Linearization, inputs: Sequence[str]) -> dict[str, float]:
    """Return what inputs have at the point beside formulas that feed back."""
    names = [*map(str, one.scene.drives), *(letter.name for letter in one.scene.inputs)]
    found = np.concatenate([one.point.tau, one.point.inputs]) - (one.feeding or 0.0)
    return {name: float(found[names.index(name)]) for name in inputs}


def when(period: float | None) -> str:
    """Return in words how often a controller samples."""
    return "" if period is None else f", every {period:g} s"


def before_and_after(one: Linearization, poles: Complexes, period: float | None, what: str) -> FilledFigure:
    """Return a map of the poles that were found, and of those of the system itself."""
    return pole_map(f"{one.name}: poles", {what: poles, "mechanism": steps(one, period).poles}, period=period)


def controls(one: Linearization) -> list[int]:
    """Return the inputs that a regulator acts by: drives, or all where there is none."""
    rates = one.scene.rates
    free = [k for k, name in enumerate(one.inputs.names) if name not in (*rates, *rates.values())]
    if not free:
        why = "only inputs with rates move it, by which no regulator acts" if rates else "nothing drives it"
        raise LinearizeError(f"{one.scene.name}: {why}; declare a drive, or an input: [inputs.u]")
    return [k for k in free if one.inputs.names[k] in one.scene.drives] or free


def _noted(found: Regulator) -> Regulator:
    """Return gains with what is said of them at the point."""
    one, formulas = found.system, f"the formulas of {argument('forces')} depend on the state"
    beside = f"{formulas}: gains act beside them, give them to simulate, too"
    said = ((one.feeding, beside), (one.kind == "moving", MOVING), (one.spin.any(), SPINNING))
    return replace(found, notes=(*found.notes, *(told for so, told in said if so)))


def lqr(
    one: Linearization,
    Q: Weights | None = None,
    R: Weights | None = None,
    period: float | None = None,
    N: Mapping[str, float] | Sequence[Sequence[float]] | Array | None = None,
    integral: Sequence[str] = (),
) -> Regulator:
    """Return the linear quadratic regulator of a system; arguments and errors as of its method."""
    used, faults = controls(one), Faults("")
    whole, step = steps(one, None, integral), steps(one, period, integral)
    heavy = weight("Q", Q, step.states, faults)
    light = weight("R", R, one.inputs.of(used), faults, definite=True, inputs=one.inputs)
    cross = _cross(N, step.states, one.inputs.of(used), faults)
    if cross.shape != (len(heavy), len(used)) or not np.isfinite(cross).all():
        faults.add("N", f"is no matrix of {len(heavy)} x {len(used)} finite numbers, states by drives")
    elif period is not None and cross.any():
        faults.add("N", f"is a weight of what goes on all the time; leave {argument('period')} out")
    faults.close(LinearizeError)
    before = np.linalg.solve(light, cross.T)  # w = v - R⁻¹ Nᵀ x has no cross term
    rest = heavy - cross @ before
    if np.linalg.eigvalsh((rest + rest.T) / 2)[0] < -SYMMETRIC * np.abs(heavy).max(initial=0.0):
        told = "N: is so large that some motion costs less than nothing"
        raise LinearizeError(f"{told}; Q - N R^-1 N^T is to be semidefinite")
    A, B, Phi, Gamma = whole.A, whole.B[:, used], step.A, step.B[:, used]
    A, Phi = A - B @ before, Phi - Gamma @ before
    K, S, poles, notes = riccati(A, B, Phi, Gamma, rest, light, period, "lqr", step.states.names)
    return _noted(Regulator(one, one.inputs.of(used).names, K + before, poles, period, notes, S, tuple(integral)))


def at_drive(loop: StateSpace, drive: str | None) -> StateSpace:
    """Return a loop that is open at all drives, cut open at one and closed at the others; errors as of `margins`."""
    k = loop.inputs.place(drive, "drive")
    rest = [j for j in range(len(loop.inputs)) if j != k]
    names = loop.inputs.names
    return replace(loop, A=loop.A - loop.B[:, rest] @ loop.C[rest])[names[k], names[k]]


def _cross(N: object, states: Axis, drives: Axis, faults: Faults) -> Array:
    """Return weights of states times drives as a matrix; of those by name, "x*F", others are 0."""
    found: Array = np.zeros((len(states), len(drives))) if N is None or isinstance(N, Mapping) else array_of(N)
    for key, value in N.items() if isinstance(N, Mapping) else ():
        state, _, drive = (part.strip() for part in str(key).partition("*"))
        if state in states.names and drive in drives.names:
            found[states.names.index(state), drives.names.index(drive)] = value
        else:
            faults.add("N", f"{key} is no state times a drive; write such as {states.names[0]}*{drives.names[0]}")
    return found


def place(one: Linearization, poles: Sequence[complex] | Array, period: float | None = None) -> Regulator:
    """Return the regulator that gives the closed loop its poles; arguments and errors as of the method of a system."""
    from scipy.signal import place_poles  # late: it takes long to load

    used, names = controls(one), one.states.names
    wanted, step = _wanted(poles, names), steps(one, period)
    scale = balance(one.A)
    A, B = one.A * scale[None, :] / scale[:, None], one.B[:, used] / scale[:, None]
    moved, beside = staircase(A, B)
    wanted, stays = _movable(A, beside, names, wanted, period)
    if period is not None and np.abs(wanted).max(initial=0.0) > 1:
        raise LinearizeError("poles: with a period they are z = exp(s T), inside the unit circle: numpy.exp(T * s)")
    most = int(np.linalg.matrix_rank(B))
    often = [value for value in wanted if np.count_nonzero(wanted == value) > most]
    if often:
        told = f"poles: {shown(often[0])} is asked for more than {most} times"
        raise LinearizeError(f"{told}, which is what drives can do")
    A, B = step.A * scale[None, :] / scale[:, None], step.B[:, used] / scale[:, None]
    K = np.zeros(B.T.shape)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the most robust gains were not reached; these are looked at below
            if len(wanted):
                K = np.asarray(place_poles(moved.T @ A @ moved, moved.T @ B, wanted).gain_matrix) @ moved.T
    except (np.linalg.LinAlgError, ValueError) as error:
        raise LinearizeError(f"poles: cannot be placed: {error}") from None
    found = np.linalg.eigvals(A - B @ K).astype(np.complex128)
    wanted = np.concatenate([wanted, stays])
    apart = max(float(np.abs(found - value).min()) for value in wanted)
    if not apart <= PLACED * max(1.0, float(np.abs(wanted).max())):
        raise LinearizeError("poles: cannot be placed to six digits: a mode is close to one that no input moves")
    found = found[np.argsort(-found.real, kind="stable")].view(array)
    return _noted(Regulator(one, one.inputs.of(used).names, K / scale[None, :], found, period))


PLACED = 1e-6
"""Distance of poles from those that were asked for, over the largest, that is rounding."""


TYPED = 1e-5
"""Distance of a pole from a mode that stays, over its size, that is the rounding of what was typed."""


def _movable(
    A: Array, beside: Array, names: tuple[str, ...], wanted: Complexes, period: float | None
) -> tuple[Complexes, Complexes]:
    """Return the poles to be placed, and of modes that no input moves; LinearizeError where these are not wanted."""
    modes = spectrum(beside.T @ A @ beside, float(np.linalg.norm(A, 2)) or 1.0).values if beside.size else wanted[:0]
    stays = modes if period is None else np.exp(modes * period)
    for mode, z in zip(modes, stays, strict=True):
        if np.abs(wanted - z).min() > TYPED * max(1.0, abs(z)):
            keep = f"{z:.6g}, {z.conjugate():.6g}" if z.imag else f"{z.real:.6g}"
            lqr = ", or take lqr, which leaves alone what has no weight and does not grow" * bool(mode.real <= 0)
            told = f"no input moves the mode {shown(mode)}, of {listed(named(beside, names))}; it stays there"
            raise LinearizeError(f"poles: {told}: keep it among the poles ({keep}), declare a drive that moves it{lqr}")
        wanted = np.delete(wanted, int(np.abs(wanted - z).argmin()))
    return wanted, stays


def _wanted(poles: Sequence[complex] | Array, names: tuple[str, ...]) -> Complexes:
    found: Complexes = array_of(poles, complex)
    if found.shape != (len(names),) or not np.isfinite(found).all():
        raise LinearizeError(f"poles: give {len(names)} finite numbers, one for each of {', '.join(names)}")
    for value in found:
        if np.count_nonzero(found == value) != np.count_nonzero(found == value.conjugate()):
            raise LinearizeError(f"poles: {value:g} comes without its conjugate {value.conjugate():g}; give both")
    return found


def opened(
    one: Linearization, inputs: Sequence[str], period: float | None, integral: Sequence[str] = ()
) -> tuple[StateSpace, list[int]]:
    """Return the open loop, as of `steps`, and the places of inputs."""
    return steps(one, period, integral), [one.inputs.names.index(name) for name in inputs]


def steps(one: StateSpace, period: float | None, integral: Sequence[str] = ()) -> StateSpace:
    """Return a system, sampled if there is a period, with integrals of outputs, or of states, behind its states."""
    names, units = (*one.outputs.names, *one.states.names), (*one.outputs.units, *one.states.units)
    if strange := [name for name in integral if name not in names]:
        raise LinearizeError(f"integral: {strange[0]} is no output or state; {suggestion(strange[0], names)}")
    step, (n, inputs), many = one if period is None else StateSpace.discretize(one, period), one.B.shape, len(integral)
    some, (every, stays) = [names.index(name) for name in integral], (1.0, 0.0) if period is None else (period, 1.0)
    rows = every * np.block([[one.C, one.D], [np.eye(n, n + inputs)]])[some]
    A = np.block([[step.A, np.zeros((n, many))], [rows[:, :n], stays * np.eye(many)]])
    B, C = np.vstack([step.B, rows[:, n:]]), np.hstack([step.C, np.zeros((len(step.C), many))])
    x = (*one.states.names, *(f"{name}_integral" for name in integral))
    states = Axis(x, (*one.states.units, *(f"{units[k]} s" for k in some)))
    return StateSpace(A, B, C, step.D, states, one.inputs, one.outputs, period, one.name)


_WORDS = {
    "lqr": ("Q", "gives no weight to", "no input moves"),
    "kalman": ("W", "lets nothing disturb", "no output shows"),
}
"""How faults call the weight of what is minimised, what it lacks, and a mode that is out of reach."""


def riccati(
    A: Array, B: Array, step: Array, held: Array, Q: Array, R: Array, period: float | None,
    gain: str, names: tuple[str, ...], measured: tuple[str, ...] = (),
) -> tuple[Array, Array, Complexes, tuple[str, ...]]:  # fmt: skip
    """Return K, what is left to pay, the poles, and notes; `step` and `held` are A and B, or those when sampled."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are  # late: it takes long to load

    (weighed, forgets, beyond), scale = _WORDS[gain], balance(A)
    A, B, Q = A * scale[None, :] / scale[:, None], B / scale[:, None], Q * scale[None, :] * scale[:, None]
    step, held = step * scale[None, :] / scale[:, None], held / scale[:, None]
    size = float(np.linalg.norm(A, 2)) or 1.0
    seen, unseen = staircase(A.T, Q)
    basis, notes = np.eye(len(A)), tuple[str, ...]()
    drifting = spectrum(unseen.T @ A @ unseen, size)
    if drifting.lasting:
        alone = named(unseen, names)
        if drifting.growing:
            raise LinearizeError(
                f"{weighed} {forgets} the mode {shown(drifting.lasting[0])}, of {listed(alone)}, which grows; "
                "name those there"
            )
        told = verdict(True, alone, named(unseen @ drifting.drifting, names))
        basis, notes = seen, (f"{told}, as {weighed} {forgets} {'them' if alone[1:] else 'it'}",)
    if not basis.shape[1]:
        raise LinearizeError(f"{weighed} {forgets} anything that has to be; give weights by name")
    part, way = basis.T @ A @ basis, basis.T @ B
    beside = staircase(part, way)[1]
    if stuck := spectrum(beside.T @ part @ beside, size).lasting:
        of = listed(named(basis @ beside, names))
        told = f"{beyond} the mode {shown(stuck[0])}, of {of}, and it does not decay"
        if gain == "kalman":
            found = [*measured, *_showing(part, way, basis, names, size)]
            raise LinearizeError(f"{told}; measure it, too: linearize with {argument('outputs', found)}")
        raise LinearizeError(f"{told}; declare a drive, or an input, that moves it, or leave {of} out of {weighed}")
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
    S = basis @ P @ basis.T / np.outer(scale, scale)
    return K @ basis.T / scale[None, :], S, poles[np.argsort(-poles.real, kind="stable")].view(array), notes


def _showing(A: Array, C: Array, basis: Array, names: tuple[str, ...], size: float) -> list[str]:
    """Return states that, measured beside what columns of C show, show all that does not decay; A and C are dual."""
    found = list[str]()
    while True:
        beside = staircase(A, C)[1]
        hidden = spectrum((beside.T @ A @ beside).T, size)
        if not hidden.lasting:
            return found
        k = int(np.linalg.norm(basis @ beside @ hidden.staying, axis=1).round(6).argmax())
        found.append(names[k])
        C = np.column_stack([C, basis[k]])
