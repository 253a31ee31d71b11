"""Linear systems of A, B, C, D with names and units, continuous or sampled, and what each answers.

    ẋ = A x + B w           x(t + T) = A x(t) + B w(t), w held between samples, where there is a period T
    y = C x + D w

What is asked of one input and output takes their names, which may be left out where there is one alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.arguments import argument, checked, native
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError, suggestion
from symdyn.extras import install
from symdyn.frozen import dataclass
from symdyn.linear.locus import RootLocus
from symdyn.linear.modes import Mode, Spectrum, array, balance, spectrum
from symdyn.linear.plots import Plotted, pole_map
from symdyn.linear.responses import (
    CLOSE,
    FrequencyResponse,
    TimeResponse,
    frequency_response,
    locus_over_gain,
    time_response,
)
from symdyn.linear.stability import Margins, margins, verdict
from symdyn.linear.transfer import Reach, Transfer, balanced, invariant_zeros, minimal, named, reach, transfers
from symdyn.linear.weights import Axis, places, read_axis, read_matrix
from symdyn.scene.values import Faults
from symdyn.simulation import Feedback, linear_law, matrices_of
from symdyn.simulation.prescribed import timed
from symdyn.table import Table
from symdyn.unlocked import cached_property


@dataclass(frozen=True, eq=False, init=False)
class StateSpace(Plotted):
    """A linear system: a mechanism about a point or from sample to sample, a loop that is closed, a controller.

    Attributes:
        A, B, C, D: shapes (nx, nx), (nx, nw), (ny, nx), (ny, nw).
        states, inputs, outputs: what x, w and y are.
        period: seconds between samples; None is none.
        name: what it is of.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: Axis
    inputs: Axis
    outputs: Axis
    period: float | None
    name: str

    @checked(LinearizeError)
    def __init__(
        self,
        A: npt.ArrayLike,
        B: npt.ArrayLike,
        C: npt.ArrayLike,
        D: npt.ArrayLike | None = None,
        states: Axis | Sequence[str] | None = None,
        inputs: Axis | Sequence[str] | None = None,
        outputs: Axis | Sequence[str] | None = None,
        period: float | None = None,
        name: str = "system",
    ) -> None:
        """Check and keep matrices and names; D is 0, names are x1, w1, y1 and so on where they are left out.

        Raises:
            LinearizeError: with every fault: matrices that do not fit, a number that is not finite, a name given twice.
        """
        faults: list[str] = []
        found = {letter: read_matrix(letter, one, faults) for letter, one in {"A": A, "B": B, "C": C}.items()}
        n, nw, ny = len(found["A"]), found["B"].shape[-1], len(found["C"])
        found["D"] = np.zeros((ny, nw)) if D is None else read_matrix("D", D, faults)
        shapes = {"A": (n, n), "B": (n, nw), "C": (ny, n), "D": (ny, nw)}
        faults += [
            f"{letter} is {'{} x {}'.format(*found[letter].shape)}, and has to be {'{} x {}'.format(*shape)}, "
            "by the rows of A and C and the columns of B"
            for letter, shape in shapes.items()
            if not faults and found[letter].shape != shape
        ]
        if period is not None and not (math.isfinite(period) and period > 0):
            faults.append(f"period = {period:g}: give seconds above zero, or None")
        axes = {"states": (states, "x", n), "inputs": (inputs, "w", nw), "outputs": (outputs, "y", ny)}
        said = {what: read_axis(what, *one, faults) for what, one in axes.items()} if not faults else {}
        if faults:
            raise LinearizeError(faults)
        for key, value in {**found, **said, "period": period, "name": name}.items():
            object.__setattr__(self, key, value)

    def __repr__(self) -> str:
        when = "continuous" if self.period is None else f"every {self.period:g} s"
        told = (f"{len(one)} {what}" for what, one in (("states", self.states), ("inputs", self.inputs)))
        to = f"{', '.join(self.inputs.names) or 'nothing'} to {', '.join(self.outputs.names) or 'nothing'}"
        return f"<{type(self).__name__} {self.name}: {', '.join(told)}, {len(self.outputs)} outputs, {when}; {to}>"

    @classmethod
    def from_control(cls, system: Any) -> StateSpace:
        """Return a StateSpace, or transfer functions, of python-control or SciPy, with the names and the period.

        Raises:
            LinearizeError: it is neither, or a transfer function with more zeros than poles.
        """
        faults = Faults("system")
        if (found := matrices_of(system, faults)) is None:
            raise LinearizeError(f"system: {type(system).__name__} is no StateSpace or TransferFunction of control")
        if system.dt is True:
            faults.add("", "is sampled with no period; give one, as in control.ss(A, B, C, D, 0.01)")
        faults.close(LinearizeError)
        x, w, y = (getattr(system, f"{one}_labels", None) or None for one in ("state", "input", "output"))
        A, B, C, D = found.values()
        return StateSpace(A, B, C, D, x, w, y, system.dt or None, getattr(system, "name", "system"))

    @checked(LinearizeError)
    def __getitem__(self, channel: tuple[str | None, str | None]) -> StateSpace:
        """Return the system to one output from one input, `system["theta", "F"]`, all states kept.

        Raises:
            LinearizeError: a name that is not known, or None where there are several.
        """
        i, k = places(self.outputs, self.inputs, channel, self.states.names)
        return StateSpace(self.A, self.B[:, [k]], self.C[[i]], self.D[[i]][:, [k]], self.states,
                          self.inputs.of([k]), self.outputs.of([i]), self.period, self.name)  # fmt: skip

    @property
    def names(self) -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
        """Names of the rows and of the columns of A, B, C and D."""
        x, w, y = (one.names for one in (self.states, self.inputs, self.outputs))
        return {"A": (x, x), "B": (x, w), "C": (y, x), "D": (y, w)}

    @cached_property
    def spectrum(self) -> Spectrum:
        """Eigenvalues of A, zeros apart."""
        return spectrum(self.A)

    @property
    def growth(self) -> Spectrum:
        """What grows, decays and stays: the eigenvalues of A, from sample to sample those of A - 1."""
        return self.spectrum if self.period is None else spectrum(self.A, sampled=True)

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Modes of eigenvalues that are not zero, those that grow fastest first.

        Of a sampled system they are ln(z)/T, and of z = 0, which is over at once, and of z = 1 there are none.
        """
        if self.period is None:
            return self.spectrum.modes
        stays = [-1.0, *np.sort(np.abs(self.spectrum.values - 1))][self.growth.zeros]
        found = [one for one in self.spectrum.modes if abs(one.value - 1) > stays * (1 + 1e-9)]
        return tuple(Mode(complex(np.log(one.value)) / self.period, one.shape) for one in found)

    @cached_property
    def poles(self) -> array:
        """All eigenvalues of A, pairs in full, shape (nx,): 1/s, those that grow fastest first, zeros last.

        Of a sampled system they have no unit, and the largest is first; inside the unit circle decays.
        """
        if self.period is None:
            return self.spectrum.values.view(array)
        found = np.linalg.eigvals(self.A).astype(np.complex128)
        found[np.argsort(np.abs(found - 1), kind="stable")[: self.growth.zeros]] = 1.0
        return found[np.argsort(-np.abs(found), kind="stable")].view(array)

    @cached_property
    def zeros(self) -> array:
        """Invariant zeros of all inputs and outputs together, 1/s: where inputs move states and outputs rest."""
        A, B, C, _ = balanced(self)
        return invariant_zeros(A, B, C, self.D, float(np.linalg.norm(A, 2)) if A.size else 0.0).view(array)

    @property
    def stable(self) -> bool:
        """Whether all poles decay: those that are zero, of samples 1, as of what is left alone, do not."""
        found = self.growth
        return len(found.decaying) == len(found.modes) and not found.zeros

    @property
    def verdict(self) -> str:
        """In words: "asymptotically stable", "marginally stable: phi does not decay" or "x drifts", "unstable"."""
        return verdict(not self.growth.growing, self.left_alone, self.drifting)

    @property
    def left_alone(self) -> tuple[str, ...]:
        """States of modes that neither grow nor decay, as of what no weight of a regulator asks for, and of drifts."""
        found = self.growth
        space = np.hstack([found.staying, found.drifting]) / balance(self.A)[:, None]
        return () if found.growing else named(space, self.states.names)

    @property
    def drifting(self) -> tuple[str, ...]:
        """States that move on for ever once they are moved, as a cart that nothing holds or brakes."""
        found = self.growth
        return () if found.growing else named(found.drifting / balance(self.A)[:, None], self.states.names)

    @property
    def minimal(self) -> StateSpace:
        """The system on what inputs move and outputs show; its states have no names."""
        A, B, C, _ = balanced(self)
        return StateSpace(*minimal(A, B, C), self.D, None, self.inputs, self.outputs, self.period, self.name)

    def damp(self) -> Table[str | float]:
        """Return a row a mode: eigenvalue, 1/s, frequency, Hz, damping ratio, what moves."""
        from symdyn.linear.report import HEAD, eigenvalue, shape

        size = 1e3 * max((abs(one.value) for one in self.modes), default=0.0)
        rows = [(eigenvalue(one, size), one.frequency, one.damping, shape(one, self)) for one in self.modes]
        zeros = self.growth.zeros
        beside = f"; {zeros} {'pole' if zeros == 1 else 'poles'} more at {0 if self.period is None else 1}"
        return Table(HEAD, rows, (1, 2), "modes" + (beside if zeros else ""))

    @overload
    def transfer(self) -> tuple[Transfer, ...]: ...

    @overload
    def transfer(self, output: str, input: str | None = None) -> Transfer: ...

    @overload
    def transfer(self, output: None = None, *, input: str) -> Transfer: ...

    @checked(LinearizeError)
    def transfer(self, output: str | None = None, input: str | None = None) -> Transfer | tuple[Transfer, ...]:
        """Return the transfer function to an output from an input; without names all; errors as of `lin[..., ...]`."""
        found = transfers(self._chosen(output, input))
        return found if output is None and input is None else found[0]

    def controllability(self) -> Reach:
        """Return what the inputs move."""
        A, B, _, _ = balanced(self)
        return reach("controllability", A, B, self.states.names)

    def observability(self) -> Reach:
        """Return what the outputs show."""
        A, _, C, _ = balanced(self)
        return reach("observability", A.T, C.T, self.states.names)

    @checked(LinearizeError)
    def bode(
        self,
        output: str | None = None,
        input: str | None = None,
        omega: Sequence[float] | Array | None = None,
        *,
        hertz: Sequence[float] | Array | str | bool = False,
    ) -> FrequencyResponse:
        """Return the response to an output from an input, or all responses, whose `.plot()` is a Bode plot.

        Args:
            output: y; without names all outputs to all inputs.
            input: w.
            omega: frequencies, rad/s, above zero; without them 200, from a decade below the slowest mode to one above
                the fastest.
            hertz: frequencies in Hz, or a range of them, "geomspace(0.1,10,200)", shown so; True shows those in Hz that
                nobody gives. With numbers in `omega` it is refused, since these are in rad/s.

        Raises:
            LinearizeError: a name that is not known; there is no input, a frequency is none, or both are given.
        """
        return frequency_response(self._chosen(output, input, ahead=True), omega, hertz)

    @checked(LinearizeError)
    def nyquist(
        self,
        output: str | None = None,
        input: str | None = None,
        omega: Sequence[float] | Array | None = None,
        *,
        hertz: Sequence[float] | Array | str | bool = False,
    ) -> FrequencyResponse:
        """Return the same as `bode`, closer together; its `.plot()` is a Nyquist plot."""
        return frequency_response(self._chosen(output, input, ahead=True), omega, hertz, CLOSE, "nyquist")

    @checked(LinearizeError)
    def margins(self, output: str | None = None, input: str | None = None) -> Margins:
        """Return how far the loop that feeds -y back to w is from the edge of stability; errors as of `transfer`."""
        if output is input is None and self.inputs == self.outputs and len(self.inputs) > 1:
            raise LinearizeError(f'{self.name}: .margins("{self.inputs.names[0]}") of the regulator cuts one open')
        return margins(self[output, input])

    @timed(LinearizeError)
    def step(
        self, output: str | None = None, input: str | None = None, until: float | None = None, points: int | None = None
    ) -> TimeResponse:
        """Return how an output follows an input, or all follow each, which goes from 0 to 1 at t = 0, from x = 0.

        Args:
            output: y; without names all outputs to all inputs.
            input: w.
            until: the end, s; without it when the slowest mode has settled, or the fastest has grown a hundredfold.
            points: number of times, from 0 to the end; of a sampled system there is one a sample.

        Raises:
            LinearizeError: a name that is not known; there is no input, or an end or a number of points that is none.
        """
        return time_response(self._chosen(output, input), "step", until, points)

    @timed(LinearizeError)
    def impulse(
        self, output: str | None = None, input: str | None = None, until: float | None = None, points: int | None = None
    ) -> TimeResponse:
        """Return the same of an impulse of area 1, which a sampled system is given as 1/T for one period."""
        return time_response(self._chosen(output, input), "impulse", until, points)

    @checked(LinearizeError)
    def root_locus(
        self, output: str | None = None, input: str | None = None, gains: Sequence[float] | Array | None = None
    ) -> RootLocus:
        """Return the poles of the loop w = -k y over its gain k, and where stability begins and ends.

        Args:
            output: y.
            input: w.
            gains: values of k, increasing; without them 0 and 300 around those at which poles move.

        Raises:
            LinearizeError: a name that is not known, gains that do not increase, a loop 1 + k D = 0, or a sampled one.
        """
        if input in [one.name for one in getattr(getattr(self, "scene", None), "parameters", ())]:
            told = f"input: {input} is no input; {suggestion(input, self.inputs.names)}; over a parameter it is"
            raise LinearizeError(f'{told} symdyn.linear.root_locus("{input}", values, system)')
        return locus_over_gain(self[output, input], gains)

    def through(self, s: complex) -> npt.NDArray[np.complex128]:
        """Return what passes through at once, D, shape (y, w), at a value of the variable of Laplace's transform."""
        return self.D.astype(np.complex128)

    def _chosen(self, output: str | None, input: str | None, ahead: bool = False) -> StateSpace:
        """Return the system of a channel, the whole without names; one `ahead` of its inputs only if that is said."""
        return self if output is None and input is None else self[output, input]

    @timed(LinearizeError)
    def discretize(self, dt: float) -> StateSpace:
        """Return the system from sample to sample, its inputs held for `dt` s, by the matrix exponential.

        Raises:
            LinearizeError: no period, or one in which something grows beyond what a double can hold; it is sampled.
        """
        from scipy.linalg import expm  # late: it takes long to load

        (period,) = native(float, dt)
        check_period(period)
        if self.period is not None:
            raise LinearizeError(f"{self.name}: {argument('dt')}: it is sampled already, every {self.period:g} s")
        n, inputs = self.B.shape
        whole = np.zeros((n + inputs, n + inputs))
        whole[:n, :n], whole[:n, n:] = self.A, self.B
        with np.errstate(over="ignore", invalid="ignore"):
            found = expm(whole * period)
        if not np.isfinite(found).all():
            told = f"{argument('dt')} {period:g}: something grows beyond all numbers within a period"
            raise LinearizeError(f"{told}; give a shorter one")
        return sampled(self, found[:n, :n], found[:n, n:], period)

    def to_control(self) -> Any:
        """Return it as a StateSpace of python-control, names and period included.

        Raises:
            LinearizeError: python-control is not installed.
        """
        try:
            from control import ss
        except ImportError:
            raise LinearizeError(f"python-control is not installed; {install('control')}") from None
        names = {"states": list(self.states.names), "outputs": list(self.outputs.names), "name": self.name or None}
        B, D, inputs = self.B, self.D, list(self.inputs.names)
        if not inputs:  # python-control knows no system without inputs: one that does nothing
            B, D, inputs = np.zeros((len(B), 1)), np.zeros((len(D), 1)), ["none"]
        return ss(self.A, B, self.C, D, self.period or 0, inputs=inputs, **names)

    def _figure(self) -> FilledFigure:
        return pole_map(f"{self.name}: poles", {"poles": self.poles}, self.zeros, self.period)

    def tables(self) -> list[Table[str | float]]:
        """Return the matrices with their names, and the modes."""
        found = [Table.matrix(letter, *names, getattr(self, letter).tolist()) for letter, names in self.names.items()]
        return [*(one for one in found if one.rows and len(one.columns) > 1), self.damp()]

    def feedback(self) -> Feedback:
        """Return it as a controller of a run: its input names measured signals, its output drives.

        It is given r - y and added to what drives have at the point; r is y there, or what `linear_law` is given.
        """
        names = self.inputs.names, self.outputs.names
        return linear_law(self.A, self.B, self.C, self.D, *names, period=self.period, states=self.states.names)


SHORTEST = 1e-12
"""Periods, s, that are none."""


def check_period(period: float) -> None:
    """Raise LinearizeError for what is no period."""
    if not (math.isfinite(period) and period > SHORTEST):
        raise LinearizeError(f"{argument('dt')} {period:g}: a period is finite and above zero, in s")


def sampled(one: StateSpace, Phi: Array, Gamma: Array, period: float) -> StateSpace:
    """Return a system from sample to sample whose names are those of another."""
    return StateSpace(Phi, Gamma, one.C, one.D, one.states, one.inputs, one.outputs, period, one.name)
