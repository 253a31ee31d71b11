"""Which values are tried together, a row of `DESIGNS` each, and Sobol's indices, which one of the designs is made for.

A design is points in the unit cube, which the quantile functions of `DISTRIBUTIONS` turn into values. A run's values
follow from its number and the seed alone: any stretch can be asked for, so that neither blocks nor workers nor their
order change a number, and nothing need hold all of it.

Sobol's indices are the shares of a measure's variance that each varied name causes:

    first order S_i    the part that goes if name i were known, averaged over all values of it
    total order T_i    the part that stays if all others were known: S_i and all that i does together with others

Names are drawn independently of each other. S_i sum to 1 where nothing is done together; T_i - S_i is what is. They are
SciPy's estimates (Saltelli et al. 2010) from the runs of the design "saltelli", whose groups are [A, B, AB_1 … AB_d]:
two independent points of the sequence, and A with one entry of B at a time. Intervals are percentiles of groups drawn
again with a seed, so that the same runs give the same bytes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import argument, native
from symdyn.bounds import BOUNDS
from symdyn.errors import SimulateError, UnknownNameError, choice, listed, suggestion
from symdyn.frozen import dataclass
from symdyn.scene.values import Faults
from symdyn.shown import Shown
from symdyn.study.distributions import LEAST, MOST, Distribution
from symdyn.unlocked import cached_property

if TYPE_CHECKING:
    from symdyn.study.runs import Runs

USUAL_COUNT = 1000

LARGEST_LATIN = 50_000_000
"""Numbers that a Latin hypercube may have: it is drawn as a whole."""

LARGEST_COUNT = BOUNDS["runs of a sweep"]

MOST_SOBOL = 21201
"""Names that Sobol's sequence of SciPy has directions for."""


@dataclass(frozen=True)
class Plan:
    """A row of `DESIGNS`.

    Attributes:
        description: what it is, one line.
        points: of the unit cube, from how many there are of each name (lists alone) or 0, how many in all, the seed,
            the first that is wanted and the one behind the last; shape (n, names).
        lists: whether it takes lists alone, whose lengths determine how many points there are.
        fault: what is wrong with so many points of so many names; "" for nothing.
        counted: how many runs a count asks for, of so many names.
    """

    description: str
    points: Callable[[Sequence[int], int, int, int, int], Array]
    lists: bool = False
    fault: Callable[[int, int], str] = lambda count, names: ""
    counted: Callable[[int, int], int] = lambda count, names: count


def _grid(lengths: Sequence[int], count: int, seed: int, first: int, last: int) -> Array:
    places = np.unravel_index(np.arange(first, last), tuple(lengths))
    return np.array([(k + 0.5) / n for k, n in zip(places, lengths, strict=True)]).T.reshape(last - first, -1)


def _random(lengths: Sequence[int], count: int, seed: int, first: int, last: int) -> Array:
    # one draw of 64 bits a number: the stream can be entered anywhere
    stream = np.random.PCG64(seed)
    stream.advance(first * len(lengths))
    return np.random.Generator(stream).random((last - first, len(lengths)))


def _sobol(lengths: Sequence[int], count: int, seed: int, first: int, last: int) -> Array:
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(lengths), scramble=True, seed=np.random.default_rng(seed))
    if first:
        sequence.fast_forward(first)
    # that their number is no power of two is reported by `sweep` alone
    with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore", category=UserWarning):
        return np.asarray(sequence.random(last - first))


@lru_cache(maxsize=1)
def _hypercube(names: int, count: int, seed: int) -> Array:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(names, seed=np.random.default_rng(seed)).random(count))


def _latin(lengths: Sequence[int], count: int, seed: int, first: int, last: int) -> Array:
    return _hypercube(len(lengths), count, seed)[first:last]


def _saltelli(lengths: Sequence[int], count: int, seed: int, first: int, last: int) -> Array:
    # groups of [A, B, A with one entry of B at a time], A and B being the halves of one point of Sobol's sequence
    names = len(lengths)
    low, high = first // (names + 2), -(-last // (names + 2))
    both = _sobol([*lengths, *lengths], 0, seed, low, high)
    A, B = both[:, :names], both[:, names:]
    groups = np.repeat(A[:, None, :], names + 2, axis=1)
    groups[:, 1] = B
    for k in range(names):
        groups[:, 2 + k, k] = B[:, k]
    begin = low * (names + 2)
    return groups.reshape(-1, names)[first - begin : last - begin]


def _grouped(count: int, names: int) -> int:
    """Return how many runs there are of so many points or more, a power of two."""
    return (1 << (count - 1).bit_length()) * (names + 2)


def _small(count: int, names: int) -> str:
    if count * names <= LARGEST_LATIN:
        return ""
    return f"a Latin hypercube of {count} points of {names} names is drawn as a whole and too large; take sobol"


def _few(count: int, names: int) -> str:
    if names > MOST_SOBOL:
        return f"Sobol's sequence is known for {MOST_SOBOL} names at most; there are {names}: take random"
    return "Sobol's sequence has 2**30 points at most; take random" if count > 2**30 else ""


SALTELLI = "saltelli"

DESIGNS: Mapping[str, Plan] = {
    "grid": Plan("every value of a list with every one of the others", _grid, lists=True),
    "random": Plan("independent draws (Monte Carlo)", _random),
    "latin": Plan("a Latin hypercube: each name's distribution in COUNT parts, one draw in each", _latin, fault=_small),
    "sobol": Plan("Sobol's sequence, scrambled: even coverage; a power of two is best", _sobol, fault=_few),
    SALTELLI: Plan(
        "COUNT pairs of points, a power of two, and what Sobol's indices take beside them: COUNT (names + 2) runs",
        _saltelli,
        fault=lambda count, names: _few(count // (names + 2), 2 * names),
        counted=_grouped,
    ),
}
"""By the word that is written."""


@dataclass(frozen=True)
class Design:
    """Which values are tried together."""

    kind: str  # a key of `DESIGNS`
    over: tuple[Distribution, ...]  # what is varied, in order
    count: int  # how many runs there are
    seed: int = 0  # of what is drawn

    @property
    def names(self) -> tuple[str, ...]:
        """What is varied."""
        return tuple(one.name for one in self.over)

    def values(self, first: int = 0, last: int | None = None) -> Array:
        """Return the values of runs from `first` on, `last` not included, shape (n, names)."""
        last = self.count if last is None else min(last, self.count)
        lengths = [0 if one.values is None else len(one.values) for one in self.over]
        u = np.clip(DESIGNS[self.kind].points(lengths, self.count, self.seed, first, last), LEAST, MOST)
        with np.errstate(all="ignore"):  # what is beyond doubles is infinite, and such a run fails and is reported
            return self._of(u)

    def _of(self, u: Array) -> Array:
        low, width, others = self._straight
        if low.size:
            found = u * width  # all columns in one go: with forty of them this is most of what a set costs
            found += low
        else:
            found = np.empty_like(u)
        for k, one in others:
            found[:, k] = one.at(u[:, k])
        return found

    @cached_property
    def _straight(self) -> tuple[Array, Array, list[tuple[int, Distribution]]]:
        """Ends and widths of uniform distributions, of shape (names,) or (0,) where there is none; and the others."""
        if not any(one.kind == "uniform" for one in self.over):
            return np.empty(0), np.empty(0), list(enumerate(self.over))
        ends = [dict(one.arguments) if one.kind == "uniform" else {"low": 0.0, "high": 0.0} for one in self.over]
        low, high = (np.array([one[key] for one in ends]) for key in ("low", "high"))
        return low, np.subtract(high, low), [(k, one) for k, one in enumerate(self.over) if one.kind != "uniform"]


def read_design(
    over: tuple[Distribution, ...], kind: str | None, count: int | None, seed: int, faults: Faults
) -> Design | None:
    """Return the design that is asked for; without a kind, a grid of lists alone or random draws of distributions.

    `faults` takes what is wrong.
    """
    listed = [one.name for one in over if one.values is not None]
    drawn = [one.name for one in over if one.values is None]
    before = len(faults.lines)
    if kind is None and listed and drawn:
        faults.add(
            "design",
            f"lists ({', '.join(listed)}) make a grid, and distributions ({', '.join(drawn)}) are drawn from; choose "
            f"one with {argument('design')} random, latin or sobol, where each value of a list has the same chance",
        )
    kind = kind or ("random" if drawn else "grid")
    if kind not in DESIGNS:
        faults.add("design", f"{kind} is not known; {suggestion(kind, DESIGNS)}")
    if not isinstance(seed, int) or seed < 0:
        faults.add("seed", f"{seed!r} is no seed; give a whole number that is zero or positive")
    if count is not None and not (isinstance(count, int) and 1 <= count <= LARGEST_COUNT):
        faults.add("count", f"{count!r} is no number of runs; give 1 to {LARGEST_COUNT}")
    if len(faults.lines) > before or not over:
        return None
    plan = DESIGNS[kind]
    if plan.lists and drawn:
        faults.add("design", f"{kind} takes lists; {', '.join(drawn)} is drawn from: take random, latin or sobol")
        return None
    if plan.lists:
        size = prod(0 if one.values is None else len(one.values) for one in over)
        if count is not None and count != size:
            faults.add("count", f"{kind} has {size} runs by its lists; leave {argument('count')} out")
        if size > LARGEST_COUNT:
            faults.add("design", f"the grid has {size} runs; {LARGEST_COUNT} are allowed")
        return Design(kind, over, size, seed)
    runs = plan.counted(USUAL_COUNT if count is None else count, len(over))
    if fault := plan.fault(runs, len(over)):
        faults.add("design", fault)
        return None
    return Design(kind, over, runs, seed)


FEWEST = 4
"""Groups below which nothing is estimated."""

WIDE = 0.3
"""Width of an interval beyond which a note says that there are too few runs."""


@dataclass(frozen=True, eq=False)
class Indices(Shown):
    """Sobol's indices of one measure.

    Attributes:
        measure: its name.
        names: what was varied, shape (d,).
        first: indices of first order, shape (d,).
        total: of total order, shape (d,).
        first_interval: what holds the former with the chance `level`, shape (d, 2).
        total_interval: likewise the latter.
        level: such as 0.95.
        groups: how many groups of d + 2 runs they are estimated from.
        notes: what a user should know.
    """

    measure: str
    names: tuple[str, ...]
    first: Array
    total: Array
    first_interval: Array
    total_interval: Array
    level: float
    groups: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        each = ", ".join(
            f"{name} {first:.3f} ({total:.3f})"
            for name, first, total in zip(self.names, self.first, self.total, strict=True)
        )
        return f"<Indices of {self.measure}, first order (total): {each}>"


def indices(runs: Runs, measure: str | None, level: float, resamples: int, seed: int) -> Indices:
    """Return Sobol's indices of a measure, with intervals; arguments and errors as of `Runs.indices`."""
    (level,), (resamples, seed) = native(float, level), native(int, resamples, seed)
    if not runs.has_indices:
        raise SimulateError(
            f"{runs.scene}: Sobol's indices need runs of the design {SALTELLI}, and these are of "
            f"{runs.about.get('design')}; sweep again with {argument('design', SALTELLI)}"
        )
    if measure is None and len(runs.measures) == 1:
        (measure,) = runs.measures
    if measure is None:
        raise SimulateError(f'{runs.scene}: name one of {listed(every := list(runs.measures))}, .indices("{every[0]}")')
    if measure not in runs.measures:
        raise UnknownNameError(f"{runs.scene}: there is no measure {measure}; {choice(measure, runs.measures)}")
    d = len(runs.names)
    column = runs[measure]
    groups = column[: len(column) // (d + 2) * (d + 2)].reshape(-1, d + 2)
    whole = groups[np.isfinite(groups).all(axis=1)]
    count = 2 ** (len(whole).bit_length() - 1) if len(whole) else 0
    if count < FEWEST:
        raise SimulateError(
            f"{runs.scene}: {measure}: {len(whole)} of {len(groups)} groups of {d + 2} runs have values throughout; "
            f"Sobol's indices take {FEWEST} at least, and hundreds to mean something: raise {argument('count')}, or "
            "vary by less where runs fail"
        )
    found = whole[:count]
    notes = []
    if len(whole) < len(groups):
        notes.append(
            f"{measure}: {len(groups) - len(whole)} of {len(groups)} groups have a run without a value and are left "
            f"out; {count} are used, a power of two: the indices are those of the values at which runs do not fail"
        )
    size = float(np.abs(found).max())
    if float(np.ptp(found)) <= 1e-12 * size:
        notes.append(f"{measure} is the same for all values, so that there is no variance to share out")
        none, wide = np.zeros(d), np.zeros((d, 2))
        return Indices(measure, runs.names, none, none, wide, wide, level, count, tuple(notes))
    first, total = estimate(found)
    generator = np.random.default_rng(seed)
    again = np.array([estimate(found[generator.integers(0, count, count)]) for _ in range(resamples)])
    ends = np.quantile(again, [(1 - level) / 2, (1 + level) / 2], axis=0)  # (2, first or total, d)
    widest = float(np.max(ends[1] - ends[0]))
    if widest > WIDE:
        notes.append(
            f"{measure}: an interval is {widest:.2g} wide; indices need more runs than quantiles: raise "
            f"{argument('count')} ({count} groups now)"
        )
    return Indices(measure, runs.names, first, total, ends[:, 0].T, ends[:, 1].T, level, count, tuple(notes))


def estimate(groups: Array) -> tuple[Array, Array]:
    """Return the indices of first and of total order, shapes (d,), of groups, shape (a power of two, d + 2)."""
    from scipy.stats import sobol_indices

    parts: Any = {"f_A": groups[None, :, 0], "f_B": groups[None, :, 1], "f_AB": groups[:, 2:].T[:, None, :]}
    found = sobol_indices(func=parts, n=len(groups))
    return np.atleast_1d(found.first_order), np.atleast_1d(found.total_order)
