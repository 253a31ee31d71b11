"""Motion from measured positions: zero-phase low-pass, derivatives, and equations projected on slow cosines.

    q       forwards and backwards through a Butterworth filter of order 4, so that nothing is delayed
    q̇, q̈    of a spline through what is left, of order 5
    rows    τ = Y β + e holds at every sample, so it holds for sums of rows: both sides are multiplied by
            orthonormal cosines up to the band (DCT-II), a row each.
            White noise stays white, and as many rows are left as the
            band has room for; this is the parallel filter and the decimation of the literature in one step.

Reference: Gautier and Poignet, Extended Kalman filtering and weighted least squares dynamic identification of robot
(2001); Janot, Vandanjon and Gautier, A generic instrumental variable approach for industrial robot identification
(2014), section III; Swevers, Verdonck and De Schutter, Dynamic model identification for industrial robots (2007).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from symdyn.algebra.numeric import Array
from symdyn.identification.log import Log

Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

ORDER = 4
EDGE = 1.0
"""Periods of the band that are dropped at both ends of a log, where a filter knows one side only."""

ABOVE, SHARE, ROOM = 30.0, 0.9999, 5.0
"""How far motion stands above the floor of noise, its share of the power of accelerations, and room for harmonics."""

UNEVEN = 1e-6
"""Part of a step by which steps may differ and are still called even."""


@dataclass(frozen=True)
class Motion:
    """A motion with its derivatives, ready for a regressor, at even times.

    Attributes:
        source: of the log.
        t: times, s, shape (N,).
        q: coordinates, shape (N, nq).
        qd: velocities, shape (N, nv).
        qdd: accelerations, shape (N, nv).
        tau: driving forces as measured, shape (N, nv).
        noise: of the rates in the band, standard deviations of q, q̇ and q̈, shape (3, nv); zero where they were given.
        band: Hz.
    """

    source: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    noise: Array
    band: float

    @property
    def rows(self) -> int:
        """How many cosines the band has room for."""
        step = float(self.t[1] - self.t[0])
        return max(1, min(len(self.t), int(2 * self.band * step * len(self.t))))


def spectrum(x: Array, step: float) -> tuple[Array, Array]:
    """Return frequencies, Hz, and power at them of the columns of x, shape (N, n), by a Hann window."""
    window = np.hanning(len(x))[:, None]
    line = np.linspace(0.0, 1.0, len(x))[:, None]
    moved = x - (x[:1] * (1 - line) + x[-1:] * line)
    power = np.abs(np.fft.rfft(moved * window, axis=0)) ** 2 / np.sum(window**2)
    return np.asarray(np.fft.rfftfreq(len(x), step), dtype=np.float64), power


def floor(x: Array, step: float) -> Array:
    """Return the variance of white noise of the columns of x, shape (n,), from the upper half of their spectrum."""
    frequency, power = spectrum(x, step)
    above = power[frequency >= 0.5 * frequency[-1]]
    found: Array = np.median(above, axis=0) / np.log(2.0)  # the median of an exponential distribution
    return found


def choose_band(logs: Iterable[Log]) -> float:
    """Return a band in Hz, that of the motion and room for its harmonics: what stands above the noise of positions."""
    highest, largest = 0.0, np.inf
    for log in logs:
        step = float(np.median(np.diff(log.t)))
        largest = min(largest, 0.4 / step)
        frequency, power = spectrum(log.q, step)
        level = floor(log.q, step)
        clear = np.where(power > ABOVE * level, power, 0.0) * frequency[:, None] ** 4
        for column in clear.T:
            summed = np.cumsum(column)
            if summed[-1] > 0:
                at = int(np.searchsorted(summed, SHARE * summed[-1]))
                highest = max(highest, float(frequency[at]))
    return min(largest, ROOM * highest) if highest else largest / 4


def motions(log: Log, band: float) -> tuple[Motion, ...]:
    """Return the motion of a log, filtered, its edges dropped."""
    from scipy.interpolate import make_interp_spline
    from scipy.signal import butter, sosfiltfilt

    step = float(np.median(np.diff(log.t)))
    t, q, qd, qdd, tau = log.t, log.q, log.qd, log.qdd, log.tau
    if np.abs(np.diff(t) - step).max() > UNEVEN * step:
        count = round(float((t[-1] - t[0]) / step)) + 1
        even = np.linspace(t[0], t[-1], count)
        q = make_interp_spline(t, q, k=3)(even)
        qd = None if qd is None else make_interp_spline(t, qd, k=3)(even)
        qdd = None if qdd is None else make_interp_spline(t, qdd, k=3)(even)
        tau = make_interp_spline(t, tau, k=1)(even)
        t, step = even, float(even[1] - even[0])
    noise = np.zeros((3, tau.shape[1]))
    cut = 2 * band * step
    if qdd is None or qd is None:
        sections = butter(ORDER, cut, output="sos") if cut < 1 else None

        def smooth(x: Array) -> Array:
            if sections is None:
                return x
            found: Array = sosfiltfilt(sections, x, axis=0, padlen=min(len(x) - 1, int(3 / cut) * 6))
            return found

        if qd is None:
            level = floor(q, step)
            fit = make_interp_spline(t, smooth(q), k=5)
            q, qd, qdd = fit(t), fit(t, 1), fit(t, 2)
            w = 2 * np.pi * band
            share = min(1.0, cut) * level
            noise = np.sqrt(np.stack([share, share * w**2 / 3, share * w**4 / 5]))
        else:
            level = floor(qd, step)
            fit = make_interp_spline(t, smooth(qd), k=5)
            q, qd, qdd = smooth(q), fit(t), fit(t, 1)
            w = 2 * np.pi * band
            share = min(1.0, cut) * level
            noise = np.sqrt(np.stack([0 * share, share, share * w**2 / 3]))
        edge = min(int(np.ceil(EDGE / (band * step))), len(t) // 10)
        keep = slice(edge, len(t) - edge)
        t, q, qd, qdd, tau = t[keep], q[keep], qd[keep], qdd[keep], tau[keep]
    return (Motion(log.source, t, q, qd, qdd, tau, noise, band),)


def projected(x: Array, rows: int) -> Array:
    """Return the sums of rows of x, shape (N, ...), over the slowest orthonormal cosines, shape (rows, ...)."""
    from scipy.fft import dct

    found: Array = dct(x, type=2, norm="ortho", axis=0)[:rows]
    return found
