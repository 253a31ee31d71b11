"""Root loci: eigenvalues over a parameter, a speed or the gain of a loop, and where stability begins and ends.

    λ_k(x)    branches, followed from value to value by the nearest pairs
    x_c       critical: a real part crosses zero; where the counts of growing modes at two values differ it is bracketed
              by bisection, and then the zero of the polynomial through Re λ at Chebyshev points of the bracket; of
              λ² where a pair on the axis, as without damping, meets at zero

Eigenvalues that are zero at every value, of what drifts, say nothing of stability and are left out of the counts.

Users give values as a range, a list, or a number that is a formula without names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev

from symdyn.algebra import Array
from symdyn.arguments import argument, checked
from symdyn.draw import FilledFigure
from symdyn.errors import LinearizeError
from symdyn.frozen import dataclass
from symdyn.linear.modes import SIDEWAYS, Complexes, pairs_of
from symdyn.linear.plots import Plotted, pole_map
from symdyn.rounding import in_digits
from symdyn.scene import Scene
from symdyn.scene.values import Faults, Letter, Parameter, split_commas
from symdyn.simulation.prescribed import read_number
from symdyn.table import Table
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.linear.state_space import StateSpace


MOST = 20_000
"""Values of a parameter at most."""

RANGES: Mapping[str, Callable[[float, float, int], Array]] = {"linspace": np.linspace, "geomspace": np.geomspace}

RANGE = re.compile(r"(?P<kind>\w+)\s*\((?P<inside>.*)\)\Z", re.DOTALL)

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")

FORM = '"NAME=linspace(0,10,100)", geomspace(0.1,10,50) or [1, 2, 5]'


def read_values(text: str, option: str = "--over", scene: Scene | None = None) -> tuple[str, Array]:
    """Return the name and the values of `NAME=linspace(a,b,n)`, `geomspace(a,b,n)` or `[a, b, ...]`.

    With a scene, numbers are asked about that are bare where its parameter is in another unit than that of SI.

    Raises:
        LinearizeError: it is none of these.
    """
    name, equals, said = (part.strip() for part in text.partition("="))
    if not equals or not NAME.match(name):
        raise LinearizeError(f'{option}: "{text}" names nothing; write {FORM}')
    letters = () if scene is None else scene.parameters
    return name, numbers(said, f"{option} {name}", next((one for one in letters if one.name == name), None))


def numbers(specified: str, where: str, letter: Parameter | None = None) -> Array:
    """Return the values of a range or a list, as of `read_values`."""
    found = RANGE.match(specified)
    if found and found["kind"] in RANGES:
        texts = split_commas(found["inside"])
        parts = [number(part, where, letter if k < 2 else None) for k, part in enumerate(texts)]
        if len(parts) != 3 or parts[2] != int(parts[2]) or not 2 <= parts[2] <= MOST:
            raise LinearizeError(f"{where}: {specified} wants a beginning, an end and how many, 2 to {MOST}")
        if found["kind"] == "geomspace" and not parts[0] * parts[1] > 0:
            raise LinearizeError(f"{where}: {specified} begins and ends on the same side of zero")
        return np.asarray(RANGES[found["kind"]](parts[0], parts[1], int(parts[2])))
    if specified.startswith("[") and specified.endswith("]"):
        return np.array([number(part, where, letter) for part in split_commas(specified[1:-1])])
    raise LinearizeError(f'{where}: "{specified}" is no range; write {FORM}')


def number(given: object, where: str, letter: Letter | None = None) -> float:
    """Return the number that a number, or a formula without names, is, of a letter or of none.

    Raises:
        LinearizeError: it is none, or in a unit that does not fit the letter's, or in none where it has one of its own.
    """
    found = read_number(given, {}, f"{where}: {given}", faults := Faults(""), letter or Parameter(""))
    faults.close(LinearizeError)
    return found or 0.0


def array_of(given: object, kind: type[float] | type[complex] = float) -> Any:
    """Return numbers as an array, which has no entries where they are none."""
    try:
        return np.array(given, dtype=kind) if kind is complex or not np.iscomplexobj(np.asarray(given)) else np.zeros(0)
    except (TypeError, ValueError, OverflowError):
        return np.zeros(0, dtype=kind)


BRACKET = 2.0**-7
"""Part of a step to which bisection narrows."""

DEGREE = 8
"""Of the polynomial through real parts inside a bracket."""

CROSSINGS = 6
"""Critical values between two values at most."""

HALVINGS = 30
"""Of a bracket, where nothing is smooth."""


@dataclass(frozen=True)
class Critical:
    """Where an eigenvalue, or a pair, crosses the imaginary axis."""

    value: float  # of the parameter
    frequency: float  # of the pair there, Hz; 0 of a real eigenvalue
    grows: bool  # whether the mode grows above the value, and decays below; else the other way round

    def __str__(self) -> str:
        how = f"oscillates at {in_digits(self.frequency, 6)} Hz" if self.frequency else "does not oscillate"
        return f"{in_digits(self.value, 12)}: a mode that {how} {'begins' if self.grows else 'ceases'} to grow"


@dataclass(frozen=True, eq=False)
class RootLocus(Plotted):
    """Eigenvalues over a parameter, or over the gain k of a loop.

    Attributes:
        name: of the parameter, or the system.
        over: what the values are of: the parameter, or k.
        values: shape (N,), increasing.
        poles: eigenvalues, 1/s, shape (N, n): a column is a branch; those that are zero are among them.
        growing: how many grow at each value, pairs as two, shape (N,).
        critical: where that changes.
        zeros: of the loop, 1/s, which its poles go to as k grows; None over a parameter.
    """

    name: str
    over: str
    values: Array
    poles: Complexes
    growing: Array
    critical: tuple[Critical, ...]
    zeros: Complexes | None = None

    def __repr__(self) -> str:
        told, of = "".join(f"\n    {line}" for line in self.lines()), self.name or self.over
        return f"<RootLocus of {of}, {len(self.values)} values, {self.poles.shape[1]} branches:{told}>"

    @cached_property
    def branches(self) -> Complexes:
        """The branches that are not zero everywhere, shape (N, branches)."""
        return self.poles[:, np.any(self.poles != 0, axis=0)]

    @property
    def ranges(self) -> list[tuple[float, float, int]]:
        """Ranges of the parameter with one count of growing eigenvalues each: from, to, count."""
        edges = [float(self.values[0]), *(one.value for one in self.critical), float(self.values[-1])]
        counts = [int(self.growing[0])]
        for one in self.critical:
            counts.append(counts[-1] + (1 if one.grows else -1) * (2 if one.frequency else 1))
        return list(zip(edges[:-1], edges[1:], counts, strict=True))

    def lines(self) -> list[str]:
        """Return critical values and ranges in words, one line each."""
        lines = [f"{self.over} = {one}" for one in self.critical]
        for low, high, count in self.ranges:
            what = {0: "nothing grows", 1: "1 eigenvalue grows"}.get(count, f"{count} eigenvalues grow")
            lines.append(f"{self.over} = {in_digits(low, 6)} ... {in_digits(high, 6)}: {what}")
        return lines

    def table(self) -> Table[str | float]:
        """Return a row a value: that, real and imaginary parts of the branches, 1/s, and how many grow."""
        n = self.branches.shape[1]
        head = [self.over, *(f"{part}{k + 1}" for k in range(n) for part in ("re", "im")), "growing"]
        rows = [
            (float(x), *(float(y) for value in row for y in (value.real, value.imag)), int(count))
            for x, row, count in zip(self.values, self.branches, self.growing, strict=True)
        ]
        return Table(head, rows, range(len(head)))

    def _figure(self) -> FilledFigure:
        """Return parts over the parameter, and the locus in the plane; over a gain the plane alone, with zeros."""
        if self.zeros is not None:
            begin = {f"k = {self.values[0]:g}": self.poles[0]}
            return pole_map(f"{self.name}: root locus", begin, self.zeros, branches=self.poles)

        def fill(figure: Any) -> None:
            over_it, plane = figure.subplots(1, 2, gridspec_kw={"width_ratios": [3, 2]})
            for k, branch in enumerate(self.branches.T):
                colour = f"C{k % 10}"
                over_it.plot(self.values, branch.real, color=colour, linewidth=1.4)
                if np.any(branch.imag > 0):
                    above = np.where(branch.imag > 0, branch.imag, np.nan)
                    over_it.plot(self.values, above, color=colour, linewidth=0.9, linestyle="--")
                plane.plot(branch.real, branch.imag, color=colour, linewidth=1.0)
                plane.plot(branch.real[:1], branch.imag[:1], "x", color=colour, markersize=5)
            for low, high, count in self.ranges:
                if not count:
                    over_it.axvspan(low, high, color="C2", alpha=0.12, linewidth=0)
            for one in self.critical:
                over_it.axvline(one.value, color="0.4", linewidth=0.7, linestyle=":")
                over_it.annotate(
                    f"{one.value:.4g}", (one.value, 1), xycoords=("data", "axes fraction"), xytext=(2, -2),
                    textcoords="offset points", fontsize=8, va="top",
                )  # fmt: skip
            over_it.axhline(0, color="0.3", linewidth=0.7)
            plane.axvline(0, color="0.3", linewidth=0.7)
            over_it.set_title("real parts (solid), imaginary (dashed); shaded: nothing grows", loc="left", fontsize=9)
            plane.set_title("the same in the plane; × where it begins", loc="left", fontsize=9)
            over_it.set(xlabel=self.over, ylabel="real and imaginary part, 1/s")
            plane.set(xlabel="real part, 1/s", ylabel="imaginary part, 1/s")
            for axis in (over_it, plane):
                axis.grid(alpha=0.3)

        return FilledFigure(f"{self.name}: eigenvalues over {self.over}", (11.0, 4.6), fill)

    def as_json(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "over": self.over, "values": self.values.tolist(), "growing": self.growing.tolist(),
            "eigenvalues": [pairs_of(row) for row in self.branches],
            "critical": [{"value": c.value, "hertz": c.frequency, "grows_above": c.grows} for c in self.critical],
        }  # fmt: skip


@checked(LinearizeError)
def root_locus(
    over: str,
    values: Sequence[float] | Array,
    system: Callable[[float], StateSpace],
    name: str = "",
    zeros: Complexes | None = None,
) -> RootLocus:
    """Return the eigenvalues of a system at values of a parameter or a gain, and where their real parts cross zero.

    Args:
        over: what the values are of, for what is told.
        values: increasing, two at least.
        system: the linear system at a value.
        name: of the system.
        zeros: of a loop whose gain the values are.

    Raises:
        LinearizeError: the values do not increase, or are too many; and what `system` raises.
    """
    x = array_of(values)
    if x.ndim != 1 or not 2 <= len(x) <= MOST or not np.isfinite(x).all() or np.any(np.diff(x) <= 0):
        where = f"{argument('over')} {over}" if zeros is None else "gains"
        raise LinearizeError(
            f"{where}: values must be finite and increase, two at least and {MOST} at most; such as "
            f'"{over}=linspace(0,10,100)"'
        )
    found = [system(float(value)) for value in x]
    if any(getattr(one, "period", None) for one in found):
        raise LinearizeError(f"{name or over}: a root locus is of a system without a period; ask before discretize")
    counts = [_count(one) for one in found]
    critical: list[Critical] = []
    for k in range(len(x) - 1):
        critical += _crossings(system, x[k], x[k + 1], counts[k], counts[k + 1])
    return RootLocus(name, over, x, _followed(found), np.array(counts), tuple(critical), zeros)


def _followed(systems: Sequence[StateSpace]) -> Complexes:
    """Return eigenvalues in the order of branches, shape (N, n); zeros follow zeros where there are as many of them."""
    from scipy.optimize import linear_sum_assignment  # late: it takes a second to load

    rows: list[Complexes] = [one.poles for one in systems]
    rows = [np.concatenate([row, np.zeros(max(map(len, rows)) - len(row))]) for row in rows]
    for k in range(1, len(rows)):
        before, now = rows[k - 1], rows[k]
        moving, fresh = np.flatnonzero(before), now[now != 0]
        if len(moving) != len(fresh):
            moving, fresh = np.arange(len(before)), now
        rows[k] = np.zeros(len(now), dtype=np.complex128)
        rows[k][moving] = fresh[linear_sum_assignment(np.abs(before[moving, None] - fresh[None, :]))[1]]
    return np.array(rows)


def _count(one: StateSpace) -> int:
    return sum(2 if mode.oscillates else 1 for mode in one.spectrum.growing)


def _crossings(
    system: Callable[[float], StateSpace], low: float, high: float, below: int, above: int, left_over: int = CROSSINGS
) -> list[Critical]:
    """Return where counts change between two values, one crossing after the other."""
    if below == above or not left_over:
        return []
    left, right = low, high
    while right - left > BRACKET * (high - low):
        middle = (left + right) / 2
        if _count(system(middle)) == below:
            left = middle
        else:
            right = middle
    count = _count(system(right))
    return [*_refined(system, left, right), *_crossings(system, right, high, count, above, left_over - 1)]


def _refined(system: Callable[[float], StateSpace], low: float, high: float) -> list[Critical]:
    """Return where counts change between two values close to each other."""
    nodes = (low + high) / 2 + (high - low) / 2 * chebyshev.chebpts2(DEGREE + 1)
    branches = _followed([system(float(x)) for x in nodes]).T
    nothing = SIDEWAYS * float(np.abs(branches).max(initial=0.0))
    found = []
    for branch in branches:
        first, last = (0.0 if abs(one.real) <= nothing else one.real for one in (branch[0], branch[-1]))
        if first * last < 0 and branch[0].imag >= 0:
            value = _zero(nodes, branch.real)
            frequency = abs(float(chebyshev.Chebyshev.fit(nodes, branch.imag, DEGREE)(value))) / (2 * np.pi)
            found.append(Critical(value, frequency, bool(branch[-1].real > 0)))
    if not found:  # a pair on the axis meets at zero, and parts along the real axis: its square goes through zero
        squares = [(branch**2).real for branch in branches]
        turning = [one for one in squares if one[0] * one[-1] < 0]
        found = [Critical(_zero(nodes, one), 0.0, bool(one[-1] > 0)) for one in turning[:1]]
    return sorted(found, key=lambda one: one.value) or [_halved(system, low, high)]


def _zero(nodes: Array, values: Array) -> float:
    """Return where the polynomial through values at Chebyshev points is zero; it changes sign between its ends."""
    from scipy.optimize import brentq

    return float(brentq(chebyshev.Chebyshev.fit(nodes, values, DEGREE), nodes[0], nodes[-1], rtol=8.9e-16))


def _halved(system: Callable[[float], StateSpace], low: float, high: float) -> Critical:
    """Return where a count changes by bisection alone: two pairs on the axis meet, and one leaves it."""
    below, above = _count(system(low)), _count(system(high))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _count(system(middle)) == below else (low, middle)
    fastest = system(high if above > below else low).spectrum.modes[0]
    return Critical((low + high) / 2, fastest.frequency if fastest.oscillates else 0.0, above > below)
