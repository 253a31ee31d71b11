"""Samples that fit nothing: driving forces so far off that no noise of their joint explains them.

Judged by residuals of single samples next to their median absolute deviation, joint by joint (Hampel 1974); what is
left out is told by joint and time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.identification.filtered import Flags

FAR = 6.0
"""Standard deviations, told from the median, beyond which a sample is left out."""

ROUNDING = 1e-6
"""Part of the root mean square of a force below which no residual is far."""

GAUSS = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""


@dataclass(frozen=True)
class Outlier:
    """One stretch of samples that were left out.

    Attributes:
        source: of the log.
        drive: name of the driving force.
        start, end: times of the first and the last sample, s.
        samples: how many.
        worst: the largest residual there, N m or N.
    """

    source: str
    drive: str
    start: float
    end: float
    samples: int
    worst: float


def far(residuals: Array, used: Flags, tau: Array) -> Flags:
    """Return which samples are far off, shape (N, nv), from residuals of all samples and those that are used."""
    found = np.zeros(residuals.shape, dtype=bool)
    for j in range(residuals.shape[1]):
        own = residuals[used[:, j], j]
        if len(own) < 3:
            continue
        centre = float(np.median(own))
        size = GAUSS * float(np.median(np.abs(own - centre)))
        size = max(size, ROUNDING * float(np.sqrt(np.mean(tau[used[:, j], j] ** 2))))
        found[:, j] = np.abs(residuals[:, j] - centre) > FAR * size
    return found & used


def stretches(out: Flags, residuals: Array, t: Array, source: str, drives: tuple[str, ...]) -> list[Outlier]:
    """Return what was left out as stretches of neighbours, in the order of joints and times."""
    found = []
    for j, drive in enumerate(drives):
        places = np.flatnonzero(out[:, j])
        for part in np.split(places, np.flatnonzero(np.diff(places) > 3) + 1) if len(places) else []:
            worst = residuals[part, j][int(np.abs(residuals[part, j]).argmax())]
            found.append(Outlier(source, drive, float(t[part[0]]), float(t[part[-1]]), len(part), float(worst)))
    return found
