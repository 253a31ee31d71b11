"""How much of a measure's variance each varied name is to blame for: Sobol's indices, with intervals.

    first order S_i    the part that goes if name i were known, averaged over all values of it
    total order T_i    the part that stays if all others were known: S_i and all that i does together with others

Names are drawn independently of each other. S_i sum to 1 where nothing is done together; T_i - S_i is what is. They are
SciPy's estimates (Saltelli et al. 2010) from the runs of the design "saltelli", whose groups are [A, B, AB_1 … AB_d]:
two independent points of the sequence, and A with one entry of B at a time. Intervals are percentiles of groups drawn
again with a seed, so that the same runs give the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symdyn.algebra import Array
from symdyn.arguments import native
from symdyn.errors import SimulateError, UnknownNameError
from symdyn.scene.values import choice
from symdyn.shown import Shown
from symdyn.study.design import SALTELLI

if TYPE_CHECKING:
    from symdyn.study.runs import Runs

FEWEST = 4
"""Groups below which nothing is estimated."""

WIDE = 0.3
"""Width of an interval beyond which a user is told that there are too few runs."""


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


def indices(runs: Runs, measure: str, level: float, resamples: int, seed: int) -> Indices:
    """Return Sobol's indices of a measure, with intervals; arguments and errors as of `Runs.indices`."""
    (level,), (resamples, seed) = native(float, level), native(int, resamples, seed)
    if not runs.has_indices:
        raise SimulateError(
            f"{runs.scene}: Sobol's indices need runs of the design {SALTELLI}, and these are of "
            f"{runs.about.get('design')}; sweep again with --design {SALTELLI}"
        )
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
            f"Sobol's indices take {FEWEST} at least, and hundreds to mean something: raise --count, or vary by less "
            "where runs fail"
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
            f"{measure}: an interval is {widest:.2g} wide; indices need more runs than quantiles: raise --count "
            f"({count} groups now)"
        )
    return Indices(measure, runs.names, first, total, ends[:, 0].T, ends[:, 1].T, level, count, tuple(notes))


def estimate(groups: Array) -> tuple[Array, Array]:
    """Return the indices of first and of total order, shapes (d,), of groups, shape (a power of two, d + 2)."""
    from scipy.stats import sobol_indices

    parts: Any = {"f_A": groups[None, :, 0], "f_B": groups[None, :, 1], "f_AB": groups[:, 2:].T[:, None, :]}
    found = sobol_indices(func=parts, n=len(groups))
    return np.atleast_1d(found.first_order), np.atleast_1d(found.total_order)
