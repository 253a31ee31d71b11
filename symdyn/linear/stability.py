"""The stability that eigenvalues show, what those that are zero come from, and how far loops are from its edge.

    |G(iω)| = 1       at zeros of G(s) G(-s) - 1 on the imaginary axis: the phase left to -180° is the phase margin
    Im G(iω) = 0      at zeros of G(s) - G(-s) there, and at ω = 0; where G < 0 the gain margin is 1/|G|
    min |1 + G(iω)|   the distance, between frequencies close together

Zeros are those of systems of twice the states, found as all zeros are. A sampled loop is looked at in
w = (z - 1)/(z + 1), in which its unit circle is the imaginary axis: ω = 2 atan(Im w)/T.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symdyn.algebra import Array
from symdyn.errors import LinearizeError, listed
from symdyn.frozen import asdict, dataclass, replace
from symdyn.linear.modes import NOTHING, balance, spectrum
from symdyn.linear.plots import Answer
from symdyn.linear.responses import response_at
from symdyn.linear.transfer import invariant_zeros
from symdyn.rounding import in_digits

if TYPE_CHECKING:
    from symdyn.linear.linearization import Linearization
    from symdyn.linear.state_space import StateSpace


ZEROS = {
    "cyclic": "of cyclic positions, on which nothing depends",
    "rolling": "of rolling at rest, which has more positions than velocities",
    "drifting": "of momenta that nothing changes, so that it drifts",
    "family": "of a family that it belongs to, others like it being next to it",
    "undecided": "of which the linear motion tells nothing",
}
"""Kinds of eigenvalues that are zero."""


def zero_kinds(A: Array, count: int, positions: int, cyclic: Sequence[int], family: int, kind: str) -> dict[str, int]:
    """Return how many eigenvalues of each kind are zero, kinds that there are; all are `count`.

    States are `positions` and then velocities; `cyclic` are places, `family` counts directions to other equilibria.
    """
    left, counts = count, dict[str, int]()
    p, m = positions, len(A) - positions
    rolling = p - m if kind == "rest" else 0
    rest = [k for k in range(len(A)) if k not in cyclic]
    part = A[np.ix_(rest, rest)]
    scale = balance(part)
    part = part * scale[None, :] / scale[:, None]
    size = float(np.abs(part).max(initial=0.0))
    drifting = m - (int(np.linalg.matrix_rank(part[len(rest) - m :], tol=NOTHING * size)) if size else 0)
    for of, most in (
        ("rolling", rolling),
        ("cyclic", len(cyclic) - rolling),
        ("family", family),
        ("drifting", drifting if kind == "rest" else 0),
        ("family", _neighbours(A[np.ix_(rest, rest)], sum(k < p for k in rest)) if kind == "steady" else 0),
        ("undecided", count),
    ):
        some = min(left, max(0, most))
        counts[of] = counts.get(of, 0) + some
        left -= some
    return {of: counts[of] for of in ZEROS if counts[of]}


def _neighbours(A: Array, positions: int) -> int:
    """Return how many ways lead to other steady motions: of another speed, on another circle, in another heading.

    Directions of positions on which nothing depends come first, along states or oblique to them, as of what spins about
    an axis that is none of its body's own.
    """
    scale = balance(A)
    left, p = A * scale[None, :] / scale[:, None], positions
    size, found = float(np.abs(left).max(initial=0.0)), 0
    while p:
        _, values, rows = np.linalg.svd(left[:, :p])
        lost = p - int(np.sum(values > NOTHING * size))
        if not lost:
            break
        turn = np.eye(len(left))
        turn[:p, :p] = np.vstack([rows[p - lost :], rows[: p - lost]]).T
        left, p, found = (turn.T @ left @ turn)[lost:, lost:], p - lost, found + lost
    return found + int(spectrum(left).still.shape[1])


@dataclass(frozen=True)
class Stability(Answer):
    """A verdict.

    Attributes:
        zeros: how many eigenvalues of each kind of `ZEROS` are zero, kinds that there are.
        names: positions that are cyclic.
        verdict: "asymptotically stable", "marginally stable" or "unstable", as of any system.
        words: one line, with the states that do not decay.
    """

    zeros: dict[str, int]
    names: tuple[str, ...]
    verdict: str
    words: str

    def __repr__(self) -> str:
        return "\n    ".join([f"<Stability: {self.words}", *self.lines]) + ">"

    @property
    def lines(self) -> tuple[str, ...]:
        """What is said of eigenvalues that are zero, a line for each kind; they stand beside the modes everywhere."""
        of = {**ZEROS, "cyclic": f"{ZEROS['cyclic']} ({', '.join(self.names)})"}
        return tuple(f"{count} eigenvalue{'s' * (count > 1)} zero {of[kind]}" for kind, count in self.zeros.items())


def stability(system: Linearization) -> Stability:
    """Return what the eigenvalues of a system say."""
    zeros, said, all_of_it = system.zero_eigenvalues, system.verdict, system.spectrum
    if all_of_it.growing:
        fastest = all_of_it.growing[0].value.real
        count = sum(2 if mode.oscillates else 1 for mode in all_of_it.growing)
        many = "one eigenvalue has" if count == 1 else f"{count} eigenvalues have"
        rest = f"{many} a positive real part; the fastest doubles in {in_digits(math.log(2) / fastest, 3)} s"
    elif not all_of_it.modes:
        rest = "all eigenvalues are zero"
    elif len(all_of_it.decaying) < len(all_of_it.modes):
        rest = "no eigenvalue has a positive real part"
    else:
        rest = f"all {'other ' if zeros else ''}eigenvalues have negative real parts"
    term, apart, _ = said.partition(":")
    return Stability(zeros, system.cyclic, term, f"{said}{';' if apart else ':'} {rest}")


ASIDE = 1e-6
"""Real parts of a zero over its size that are rounding."""

NEAR = 1e-4
"""Part of a frequency within which it is found to all digits."""

LARGE = 1e9
"""Of G, where it has a pole."""

POINTS = 4000
"""Frequencies at which the distance is looked for."""


@dataclass(frozen=True)
class Margins(Answer):
    """Margins of the loop that feeds -y back to w.

    Attributes:
        gain: the factor next to 1 at which the loop is at the edge; one below 1 it must not fall to; inf of none.
        phase: degrees of lag next to 0 that it stands; negative is what it lacks; inf of none.
        delay: s of dead time that it stands; inf of none.
        distance: of G(iω) from -1, the least.
        phase_crossover, gain_crossover: where gain and phase margin are, rad/s; nan of none.
        stable: whether the loop is stable as it is, `left_alone` not counted; margins of one that is not are those
            to become so.
        left_alone: states of what stays or swings for ever; of a loop that is stable it does not move or does not show
            them, such as a position on which nothing depends.
        drifting: those of them that move on for ever, growing with t.
    """

    gain: float
    phase: float
    delay: float
    distance: float
    phase_crossover: float
    gain_crossover: float
    stable: bool
    left_alone: tuple[str, ...] = ()
    drifting: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[float]:
        """Yield gain and phase margin, and where they are, as `margin` of python-control."""
        return iter((self.gain, self.phase, self.phase_crossover, self.gain_crossover))

    @property
    def decibels(self) -> float:
        """The gain margin, dB."""
        return 20 * math.log10(self.gain) if self.gain > 0 else -math.inf

    def __repr__(self) -> str:
        return f"<Margins of a loop that is {self.verdict}: {self.words}>"

    @property
    def verdict(self) -> str:
        """In words, as of a system: "asymptotically stable", "marginally stable: phi does not decay", "unstable"."""
        return verdict(self.stable or bool(self.left_alone), self.left_alone, self.drifting)

    @property
    def words(self) -> str:
        """All of them in one line."""
        parts = (
            ("gain", self.gain, "", self.phase_crossover),
            ("phase", self.phase, "°", self.gain_crossover),
            ("delay", self.delay, " s", math.nan),
            ("distance", self.distance, "", math.nan),
        )
        at = ("" if math.isnan(w) else f" at {in_digits(w, 4)} rad/s" for *_, w in parts)
        return ", ".join(f"{what} {in_digits(x, 4)}{unit}{w}" for (what, x, unit, _), w in zip(parts, at, strict=True))

    def as_json(self) -> dict[str, float | bool | list[str] | None]:
        """Return them for JSON; what is not finite is None."""
        names = {"left_alone": [*self.left_alone], "drifting": [*self.drifting]}
        return {name: x if math.isfinite(x) else None for name, x in asdict(self).items() if name not in names} | names


def verdict(stable: bool, but: Sequence[str], drifts: Sequence[str]) -> str:
    """Return in words whether something is stable, and which states do not decay, or drift, of a multiple zero."""
    if not stable or not but:
        return "asymptotically stable" if stable else "unstable"
    one = not (drifts or but)[1:]
    does = ("drifts" if one else "drift") if drifts else f"{'does' if one else 'do'} not decay"
    return f"marginally stable: {listed(drifts or but)} {does}"


def margins(one: StateSpace) -> Margins:
    """Return the margins of a loop of one input and one output.

    Raises:
        LinearizeError: the loop has no answer, 1 + D = 0; or a sampled one has a pole at -1.
    """
    loop = (one if one.period is None else _in_w(one)).minimal
    A, b, c, d = loop.A, loop.B, loop.C, float(loop.D[0, 0])
    if abs(1 + d) < ASIDE:
        raise LinearizeError(f"{one.name}: the loop has no answer, 1 + D = 0")

    def G(w: float) -> complex:
        return complex(response_at(loop, w)[0, 0])

    scale = max(float(np.linalg.norm(A, 2)) if A.size else 0.0, 1e-300)
    grid = np.geomspace(1e-6 * scale, 1e3 * scale, POINTS)
    resonant = np.abs(np.linalg.eigvals(A)) if len(A) else np.zeros(0)
    grid = np.unique([*grid, *(w * (1 + x) for w in resonant if w > 0 for x in np.linspace(-0.05, 0.05, 101))])
    values = np.array([G(w) for w in grid])
    phases = _phase_crossings(A, b, c, d, G, values)
    gains = _crossings(
        np.block([[A, -b @ c], [np.zeros_like(A), -A]]), np.vstack([b * d, b]), np.hstack([c, -d * c]), d * d - 1,
        lambda w: abs(G(w)) - 1,
    )  # fmt: skip
    turn: Callable[[float], float] = (lambda w: w) if one.period is None else lambda w: 2 * math.atan(w) / one.period  # type: ignore[operator]
    lags = [(math.degrees(np.angle(G(w))) % 360 - 180, turn(w)) for w in gains]
    factors = [(1 / abs(G(w)), turn(w)) for w in phases]
    gain, at = min(factors, key=lambda two: abs(math.log(two[0])), default=(math.inf, math.nan))
    phase, crossing = min(lags, key=lambda two: abs(two[0]), default=(math.inf, math.nan))
    delay = min((math.radians(lag % 360) / w for lag, w in lags if w > 0), default=math.inf)
    closed = replace(one, A=one.A - one.B @ one.C / (1 + one.D[0, 0]))
    shown = spectrum(A - b @ c / (1 + d), scale)
    stable = closed.stable or not (closed.growth.growing or shown.lasting)
    alone = (closed.left_alone, closed.drifting)
    return Margins(gain, phase, delay, _distance(G, grid, values, d), at, crossing, stable, *alone)


def _in_w(one: StateSpace) -> StateSpace:
    """Return a sampled system in w = (z - 1)/(z + 1)."""
    n = len(one.A)
    try:
        inverse = np.linalg.inv(one.A + np.eye(n))
    except np.linalg.LinAlgError:
        raise LinearizeError(f"{one.name}: has a pole at z = -1, where margins are not known") from None
    B, C, D = 2 * inverse @ one.B, one.C @ inverse, one.D - one.C @ inverse @ one.B
    return replace(one, A=(one.A - np.eye(n)) @ inverse, B=B, C=C, D=D, period=None)


def _phase_crossings(
    A: Array, b: Array, c: Array, d: float, G: Callable[[float], complex], values: Array
) -> list[float]:
    """Return frequencies at which G is real and negative; none where it is real at all of them."""
    finite = values[np.abs(values) < LARGE]
    if np.all(np.abs(finite.imag) <= ASIDE**2 * np.abs(finite)):
        return []
    zero = np.zeros_like(A)
    found = _crossings(
        np.block([[A, zero], [zero, -A]]), np.vstack([b, b]), np.hstack([c, c]), 0.0, lambda w: G(w).imag
    )
    least = ASIDE**2 * float(np.abs(finite).max(initial=0.0))
    return [w for w in (0.0, *found) if G(w).real < -least and abs(G(w)) < LARGE]


def _crossings(A: Array, B: Array, C: Array, D: float, error: Callable[[float], float]) -> list[float]:
    """Return the frequencies, ascending, of zeros on the imaginary axis, each to where an error vanishes."""
    from scipy.optimize import brentq  # late: it takes a second to load

    size = float(np.linalg.norm(A, 2)) if A.size else 1.0
    zeros = invariant_zeros(A, B, C, np.array([[D]]), size)
    found = []
    for w in sorted(z.imag for z in zeros if z.imag > 0 and abs(z.real) <= ASIDE * abs(z)):
        low, high = w * (1 - NEAR), w * (1 + NEAR)
        found.append(float(brentq(error, low, high, xtol=1e-300, rtol=8.9e-16)) if error(low) * error(high) < 0 else w)
    return found


def _distance(G: Callable[[float], complex], grid: Array, values: Array, d: float) -> float:
    """Return the least distance of G from -1."""
    from scipy.optimize import minimize_scalar

    away = np.abs(1 + values)
    least = [abs(1 + d), float(away[0])]
    for k in np.flatnonzero((away[1:-1] <= away[:-2]) & (away[1:-1] <= away[2:])) + 1:
        bounds = (float(grid[k - 1]), float(grid[k + 1]))
        least.append(
            float(minimize_scalar(lambda w: abs(1 + G(w)), bounds=bounds, options={"xatol": 1e-9 * bounds[0]}).fun)
        )
    return min(least)
