"""How outputs follow inputs: over frequency, G(iω) = C (iω - A)⁻¹ B + D, and over time, after a step or an impulse.

From sample to sample G is at e^{iωT}, up to ω = π/T. A response over time is exact at its times: the input is constant
between them, so x goes on by Φ and Γ of the matrix exponential. Where nothing is asked, frequencies and times are those
of the system's own modes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, checked, native
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.frozen import dataclass, replace
from symdyn.linear.locus import RootLocus, array_of, numbers, root_locus
from symdyn.linear.modes import Complexes, growth
from symdyn.linear.plots import Plotted, bode, courses, nyquist
from symdyn.linear.transfer import balanced
from symdyn.linear.weights import places
from symdyn.table import Table

if TYPE_CHECKING:
    from symdyn.linear.state_space import StateSpace
    from symdyn.linear.weights import Axis

POINTS, CLOSE = 200, 2000
"""Frequencies that nobody gives, of a Bode and of a Nyquist plot."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse(Plotted):
    """Responses of all outputs to all inputs over frequency.

    Attributes:
        omega, hertz: frequencies, rad/s and Hz, shape (N,).
        inputs, outputs: names, w and y of them.
        response: G, shape (N, y, w), units of outputs over those of inputs; infinite at an undamped mode.
        name: what it is of.
        kind: what `plot` draws.
        unit: of frequencies there, and in what is printed.
    """

    omega: Array
    hertz: Array
    inputs: Axis
    outputs: Axis
    response: Complexes
    name: str = ""
    kind: Literal["bode", "nyquist"] = "bode"
    unit: Literal["rad/s", "Hz"] = "rad/s"

    def __repr__(self) -> str:
        at = self.hertz if self.unit == "Hz" else self.omega
        span = f"{at[0]:.4g} to {at[-1]:.4g} {self.unit}, {len(at)} frequencies"
        return f"<FrequencyResponse of {self.name}: {_channels(self.inputs, self.outputs)}, {span}>"

    @checked(LinearizeError)
    def __getitem__(self, channel: tuple[str | None, str | None]) -> FrequencyResponse:
        """Return the response to one output from one input, `response["theta", "F"]`; errors as of a system."""
        i, k = places(self.outputs, self.inputs, channel)
        inputs, outputs = self.inputs.of([k]), self.outputs.of([i])
        return replace(self, inputs=inputs, outputs=outputs, response=self.response[:, [i]][:, :, [k]])

    def __iter__(self) -> Iterator[Array]:
        """Yield |G|, phases in rad and omega, as python-control: shapes (N,), of several channels (y, w, N)."""
        return iter((_channel_first(np.abs(self.response)), _channel_first(np.radians(self.degrees)), self.omega))

    @property
    def decibels(self) -> Array:
        """20 log10 |G|, shape (N, y, w); of units that outputs have over inputs."""
        with np.errstate(divide="ignore"):
            return np.asarray(20 * np.log10(np.abs(self.response)))

    @property
    def degrees(self) -> Array:
        """Phases without jumps along the frequencies, degrees, shape (N, y, w); begins within -180 … 180."""
        whole = np.where(np.isfinite(self.response), self.response, 1.0)
        return np.asarray(np.degrees(np.unwrap(np.angle(whole), axis=0)))

    @property
    def pairs(self) -> list[tuple[str, Array, Array]]:
        """Title, decibels and degrees of each output and input, those that do not follow left out."""
        return [
            (f"{output} / {name}", self.decibels[:, i, k], self.degrees[:, i, k])
            for i, output in enumerate(self.outputs.names)
            for k, name in enumerate(self.inputs.names)
            if np.any(self.response[:, i, k])
        ]

    def table(self) -> Table[str | float]:
        """Return a row a frequency: that in Hz, then decibels and degrees of each pair."""
        head, columns = ["frequency_Hz"], [self.hertz]
        for title, size, phase in self.pairs:
            head += [f"{title} dB", f"{title} deg"]
            columns += [size, phase]
        return Table(head, np.stack(columns, axis=1).tolist(), range(len(head)))

    def _figure(self) -> FilledFigure:
        return bode(self) if self.kind == "bode" else nyquist(self)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON; what is not finite is None."""
        channels = [
            {"of": title, "decibels": _finite(size), "degrees": _finite(phase)} for title, size, phase in self.pairs
        ]
        return {"hertz": self.hertz.tolist(), "channels": channels}


def _channel_first(values: Array) -> Array:
    """Return values over all channels with these in front, and those of the only one alone."""
    found = np.moveaxis(values, 0, -1)
    return found[0, 0] if found.shape[:2] == (1, 1) else found


def _finite(values: Array) -> list[float | None]:
    return [float(x) if math.isfinite(x) else None for x in values]


def _channels(inputs: Axis, outputs: Axis) -> str:
    return f"{', '.join(inputs.names)} to {', '.join(outputs.names)}"


def frequency_response(
    one: StateSpace,
    omega: Sequence[float] | Array | None = None,
    hertz: Sequence[float] | Array | str | bool = False,
    points: int = POINTS,
    kind: Literal["bode", "nyquist"] = "bode",
) -> FrequencyResponse:
    """Return the frequency responses of a system; arguments and errors as of its method `bode`."""
    _check_driven(one, "a frequency response")
    switch = isinstance(hertz, bool | np.bool_)
    if omega is not None and (hertz if switch else True):
        w, dots = np.ravel(array_of(omega)), ["..."] * (np.size(omega) > 3)
        own, over = (", ".join([*(f"{x:.6g}" for x in some[:3]), *dots]) for some in (w, w / (2 * math.pi)))
        told = f"omega, hertz: give one of them: hertz=[{own}] if they are in Hz; if they are in rad/s leave hertz out"
        raise LinearizeError(f"{told}, or give hertz=[{over}], to see them in Hz")
    if omega is not None:
        w = _frequencies(omega, "omega", "rad/s", one.period)
        f = w / (2 * math.pi)
    else:
        said = numbers(hertz, argument("hertz")) if isinstance(hertz, str) else hertz
        f = usual_frequencies(one, points) if switch else _frequencies(said, "hertz", "Hz", one.period)
        w = 2 * math.pi * f
    found = np.array([response_at(one, x) for x in w])
    unit: Literal["rad/s", "Hz"] = "Hz" if hertz is not False else "rad/s"
    return FrequencyResponse(w, f, one.inputs, one.outputs, found, one.name, kind, unit)


def _check_driven(one: StateSpace, what: str) -> None:
    if not one.inputs.names:
        raise LinearizeError(
            f"{one.name}: nothing drives it, and {what} is that to an input; declare a drive, or an input: [inputs.u]"
        )


def _frequencies(given: object, what: str, unit: str, period: float | None) -> Array:
    found: Array = array_of(given)
    if found.ndim != 1 or not len(found) or not np.isfinite(found).all() or np.any(found <= 0):
        told = f"a list of them, such as {what}=[{found:g}]" if not found.ndim else "finite and above zero"
        raise LinearizeError(f"{what}: frequencies must be {told}, in {unit}")
    most = math.inf if period is None else (math.pi if what == "omega" else 0.5) / period
    if found.max() > most * (1 + 1e-9):
        raise LinearizeError(f"{what}: {found.max():g} {unit} is beyond half the rate of samples, {most:g} {unit}")
    return found


def response_at(one: StateSpace, omega: float) -> Complexes:
    """Return G at a frequency, rad/s, shape (y, w); infinite at an undamped mode."""
    s = 1j * omega if one.period is None else np.exp(1j * omega * one.period)
    try:
        moved = np.linalg.solve(s * np.eye(len(one.A)) - one.A, one.B.astype(np.complex128))
    except np.linalg.LinAlgError:
        return np.full(one.D.shape, complex(math.inf))
    return np.asarray(one.C @ moved + one.through(s))


def usual_frequencies(one: StateSpace, points: int) -> Array:
    """Return frequencies from a decade below the slowest mode to one above the fastest, Hz, as far as samples go."""
    sizes = [one.frequency for one in one.modes if one.frequency > 0 and math.isfinite(one.frequency)] or [1.0]
    low, high = min(sizes) / 10, max(sizes) * 10
    if one.period is not None:
        high = 0.5 / one.period
        low = min(low, high / 100)
    return np.asarray(np.geomspace(low, high, points))


LONGEST = 1_000_000
"""Times of a response at most."""

USUAL, ROUND, MOST = 500, 20, 20_000
"""Times of a response that nobody gives: at least, of one round of what oscillates, at most."""

SETTLED, GROWN, ROUNDS = 7.0, 100.0, 10.0
"""Time constants after which a mode has settled, how far one grows that is shown, and rounds of what does not decay."""

ROUNDED, EVENED = 1e-12, 10
"""Part of its terms that rounding leaves of a final value that is zero; times that rows and columns are made alike."""

BESIDE, ALIKE = 1e-3, 1e-6
"""Distance from a pole over its size at which systems are compared, and parts of G in which they are alike."""

RISES, SETTLES, ROUNDING = (0.1, 0.9), 0.02, 1e-10
"""Parts of the final value between which a response rises, and within which of it it has settled."""


@dataclass(frozen=True, eq=False)
class TimeResponse(Plotted):
    """Responses of all outputs to all inputs over time.

    Attributes:
        t: s, shape (N,).
        values: shape (N, y, w); an output to a unit of an input.
        inputs, outputs: names.
        final: where they end, shape (y, w); nan of an output that does not come to rest, as states that take part in
            it do not decay.
        kind: "step" or "impulse".
        period: seconds between samples; None is none.
        name: what it is of.
    """

    t: Array
    values: Array
    inputs: Axis
    outputs: Axis
    final: Array
    kind: Literal["step", "impulse"]
    period: float | None = None
    name: str = ""

    def __repr__(self) -> str:
        span = f"t = 0 to {self.t[-1]:.4g} s, {len(self.t)} times"
        return f"<TimeResponse of {self.name} to a unit {self.kind}: {_channels(self.inputs, self.outputs)}, {span}>"

    @checked(LinearizeError)
    def __getitem__(self, channel: tuple[str | None, str | None]) -> TimeResponse:
        """Return the response of one output to one input, `response["theta", "F"]`; errors as of a system."""
        i, k = places(self.outputs, self.inputs, channel)
        inputs, outputs, values = self.inputs.of([k]), self.outputs.of([i]), self.values[:, [i]][:, :, [k]]
        return replace(self, inputs=inputs, outputs=outputs, values=values, final=self.final[[i]][:, [k]])

    def __iter__(self) -> Iterator[Array]:
        """Yield t and the values, as python-control: shape (N,), of several channels (y, w, N)."""
        return iter((self.t, _channel_first(self.values)))

    @checked(LinearizeError)
    def info(self, output: str | None = None, input: str | None = None) -> dict[str, float]:
        """Return the figures of a step response: times in s, overshoot and undershoot in % of the final value.

        It rises from 10 to 90 % of the final value, and has settled when it stays within 2 % of it. What never happens
        is nan: of an output that does not come to rest the final value, and all that is a part of it, as of a final
        value of zero; that has settled when it stays within 2 % of its peak. The peak is that of the times shown.

        Raises:
            LinearizeError: it is none of a step; a name that is not known, or none given where there are several.
        """
        if self.kind != "step":
            raise LinearizeError("info: is of a step response, and this is one of an impulse")
        one = self[output, input]
        y = one.values[:, 0, 0]
        final = float(one.final[0, 0])
        if abs(final) <= ROUNDING * float(np.abs(y).max()):
            final = 0.0
        part = y / (final or math.nan)
        begun, risen = (self._first(part, level) for level in RISES)
        top = int(np.abs(y).argmax())
        off = part - 1 if final else y / (y[top] or 1.0)  # of one that comes back to zero, of its peak
        away = np.flatnonzero(~(np.abs(off) < SETTLES))
        last = int(away[-1]) if len(away) else -1
        edge = math.copysign(SETTLES, off[last])
        settled = math.nan if last == len(y) - 1 else 0.0 if last < 0 else self._crossing(off, last, edge)
        return {
            "rise_time": risen - begun,
            "settling_time": settled,
            "overshoot": 100 * float(np.maximum(part.max() - 1, 0)),
            "undershoot": 100 * float(np.maximum(-part.min(), 0)),
            "peak": float(abs(y[top])),
            "peak_time": float(self.t[top]),
            "final": final,
        }

    def _first(self, part: Array, level: float) -> float:
        """Return when a response first reaches a part of its final value."""
        beyond = np.flatnonzero(part >= level)
        if not len(beyond):
            return math.nan
        return self._crossing(part, int(beyond[0]) - 1, level) if beyond[0] else 0.0

    def _crossing(self, part: Array, k: int, level: float) -> float:
        """Return when a response is at a level between two times; of samples the later one."""
        if self.period is not None:
            return float(self.t[k + 1])
        share = (level - part[k]) / (part[k + 1] - part[k])
        return float(self.t[k] + share * (self.t[k + 1] - self.t[k]))

    def table(self) -> Table[str | float]:
        """Return a row a time: that in s, then each output to each input."""
        head = ["t", *(f"{output} / {name}" for output in self.outputs.names for name in self.inputs.names)]
        rows = np.column_stack([self.t, self.values.reshape(len(self.t), -1)])
        return Table(head, rows.tolist(), range(len(head)))

    def _figure(self) -> FilledFigure:
        return courses(self)


def time_response(
    one: StateSpace, kind: Literal["step", "impulse"], until: float | None, points: int | None
) -> TimeResponse:
    """Return the responses of a system over time; arguments and errors as of its methods `step` and `impulse`."""
    _check_driven(one, "a response")
    (until,), (points,) = native(float, until), native(int, points)
    if until is not None and not (math.isfinite(until) and until > 0):
        raise LinearizeError(f"until = {until:g}: give a time above zero, s")
    end = _usual_end(one) if until is None else until
    count = points if one.period is None else int(end / one.period) + 1
    if count is None:
        fastest = max((mode.frequency for mode in one.modes if mode.oscillates), default=0.0)
        count = min(MOST, max(USUAL, math.ceil(ROUND * fastest * end) + 1))
    if not 2 <= count <= LONGEST:
        raise LinearizeError(f"points, until: {count} times; give 2 to {LONGEST} of them")
    try:
        step = one.discretize(end / (count - 1)) if one.period is None else one
    except LinearizeError as fault:
        raise LinearizeError(f"until = {end:g} s, points = {count}: {fault}") from None
    t: Array = np.linspace(0.0, end, count) if one.period is None else one.period * np.arange(count, dtype=np.float64)
    if kind == "step":
        x, w, D = np.zeros_like(one.B), np.eye(one.B.shape[1]), one.D
    else:  # what D passes on is an impulse itself, and left out
        x, w, D = one.B / (one.period or 1.0), np.zeros((one.B.shape[1],) * 2), 0 * one.D
    found = np.empty((count, *one.D.shape))
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(count):
            found[k] = one.C @ x + D
            x = step.A @ x + step.B @ w
    if kind == "impulse" and one.period is not None:
        found = np.concatenate([one.D[None] / one.period, found[:-1]])
    if not np.isfinite(found).all():
        raise LinearizeError(f"{one.name}: it grows beyond all numbers until t = {end:g} s; give until, an earlier end")
    return TimeResponse(t, found, one.inputs, one.outputs, _final(one, kind), kind, one.period, one.name)


def _final(one: StateSpace, kind: str) -> Array:
    """Return where responses end, shape (y, w); nan of a channel that is not stable."""
    found = np.full(one.D.shape, math.nan)
    for i, k in np.ndindex(found.shape):
        own = _joined(one[one.outputs.names[i], one.inputs.names[k]])
        whole, ends = own, own.stable or _settles(own)
        own = own if ends else own.minimal
        if ends or (own.stable and _alike(own, whole)):
            x = np.linalg.solve((0.0 if one.period is None else 1.0) * np.eye(len(own.A)) - own.A, own.B)
            size = float((np.abs(own.C) @ np.abs(x) + np.abs(own.D))[0, 0])
            end = float((own.C @ x + own.D)[0, 0])
            found[i, k] = end if kind == "step" and abs(end) > ROUNDED * size else 0.0
    return found


def _settles(one: StateSpace) -> bool:
    """Return whether all modes decay, however slow: those are of the inverse of A, its rows and columns evened."""
    if one.period is not None or not len(one.A):
        return False
    A, rows, columns = one.A, np.ones((len(one.A), 1)), np.ones((1, len(one.A)))
    for axis in (1, 0) * EVENED:
        size = np.abs(A).max(axis=axis, keepdims=True)
        size[size == 0] = 1.0
        A, rows, columns = A / size, rows * (size if axis else 1.0), columns * (1.0 if axis else size)
    sizes = np.linalg.svd(A, compute_uv=False)
    if sizes[-1] <= ROUNDED * sizes[0]:
        return False
    fast, slow = np.linalg.eigvals(one.A), 1 / np.linalg.eigvals(np.linalg.inv(A) / (rows * columns).T)
    middle = math.sqrt(np.abs(fast).max() * np.abs(slow).min())
    values = np.concatenate([fast[np.abs(fast) > 0.9 * middle], slow[np.abs(slow) < 1.1 * middle]])
    return bool(np.all(values.real < -ROUNDING * np.abs(values)))


def _alike(one: StateSpace, whole: StateSpace) -> bool:
    """Return whether a system follows as the whole does beside each pole of it, where what is weak is seen, too."""
    (A, B, C, _), edge = balanced(whole), 0.0 if whole.period is None else 1.0
    poles = np.linalg.eigvals(A) - edge
    slow = np.abs(poles)[np.abs(poles) > ROUNDED * np.abs(poles).max(initial=0.0)].min(initial=1.0)
    for pole in poles:
        s = edge + pole + (1 + 1j) * BESIDE * max(abs(pole), slow)
        left = s * np.eye(len(A)) - A
        inverse = np.linalg.inv(left)
        x = inverse @ B
        error = np.abs(C) @ np.abs(inverse) @ (np.abs(left) @ np.abs(x) + np.abs(B))  # over that of a double
        G, own = C @ x + whole.D, one.C @ np.linalg.solve(s * np.eye(len(one.A)) - one.A, one.B + 0j) + one.D
        if np.any(np.abs(G - own) > ALIKE * np.abs(G) + ROUNDING * error):
            return False
    return True


def _joined(one: StateSpace) -> StateSpace:
    """Return a system on the states that some entry not zero, or a chain of them, joins to inputs and to outputs."""
    moves, moved, seen = one.A != 0, np.any(one.B != 0, axis=1), np.any(one.C != 0, axis=0)
    for _ in moves:
        moved, seen = moved | moves @ moved, seen | seen @ moves
    own = moved & seen
    states = one.states.of(np.flatnonzero(own).tolist())
    return replace(one, A=one.A[own][:, own], B=one.B[own], C=one.C[:, own], states=states)


def _usual_end(one: StateSpace) -> float:
    values = [mode.value for mode in one.modes if math.isfinite(mode.value.real)]
    size = max(map(abs, values), default=0.0)
    each = [*zip(values, growth(values, size), strict=True)]
    if growing := [value.real for value, way in each if way > 0]:
        end = math.log(GROWN) / max(growing)
    else:
        ends = (-SETTLED / one.real if way else ROUNDS * 2 * math.pi / abs(one) for one, way in each)
        end = max(ends, default=ROUNDS)
    return end if one.period is None else max(end, ROUNDS * one.period)


GAINS, DECADES = 300, 8
"""Gains of a root locus that nobody gives, and how many decades of them at most."""


def locus_over_gain(one: StateSpace, gains: Sequence[float] | Array | None) -> RootLocus:
    """Return the root locus of a loop over its gain; arguments and errors as of the method `root_locus`."""
    d = float(one.D[0, 0])

    def closed(k: float) -> StateSpace:
        if abs(1 + k * d) <= 1e-12:
            raise LinearizeError(f"gains: at {k:g} the loop has no answer, 1 + k D = 0; leave it out")
        return replace(one, A=one.A - k / (1 + k * d) * one.B @ one.C)

    values = _usual_gains(one) if gains is None else gains
    return root_locus("k", values, closed, one.name, one.zeros)


def _usual_gains(one: StateSpace) -> Array:
    """Return 0 and gains at which |k G| is about 1 at the frequencies of the modes, and a decade beyond."""
    sizes = np.abs([response_at(one, 2 * math.pi * f)[0, 0] for f in usual_frequencies(one, POINTS)])
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if not len(sizes):
        raise LinearizeError(f"{one.name}: {one.outputs.names[0]} does not follow {one.inputs.names[0]}")
    low = 0.1 / sizes.max()
    return np.array([0.0, *np.geomspace(low, min(10 / sizes.min(), low * 10.0**DECADES), GAINS)])
