"""Motion from measured positions: zero-phase low-pass, derivatives, and equations projected on slow cosines.

    q       forwards and backwards through a Butterworth filter of order 4, so that nothing is delayed
    q̇, q̈    of a spline through what is left, of order 5
    rows    τ = Y β + e holds at every sample, so it holds for sums of rows: both sides are multiplied by
            orthonormal cosines up to the band (DCT-II), a row each.
            White noise stays white, and as many rows are left as the
            band admits; this is the parallel filter and the decimation of the literature in one step.

Reference: Gautier and Poignet, Extended Kalman filtering and weighted least squares dynamic identification of robot
(2001); Janot, Vandanjon and Gautier, A generic instrumental variable approach for industrial robot identification
(2014), section III; Swevers, Verdonck and De Schutter, Dynamic model identification for industrial robots (2007).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array
from symdyn.frozen import dataclass
from symdyn.identification.log import SHORTEST, Log

Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

ORDER = 4
EDGE = 5.0
"""Periods of the band that are dropped at both ends of a log, where a filter knows one side only."""

ABOVE, SHARE = 30.0, 0.9999
"""How far motion stands above the floor of noise, and its share of the power of accelerations."""

ROOM, LEAST_ROOM = 20.0, 2.0
"""Widths of bands over the motion's highest frequency: what lies above the harmonics of the motion is noise alone, and
shows how large it is."""

UNBENT = 4.0
"""Frequency to which positions are kept at least, over the motion's highest: the filter takes 1.5e-5 of it."""

UNEVEN, TOLD = 1e-6, 0.05
"""Part of a step by which steps may differ and are called even, and by which they may without a note."""

GAP = 4.0
"""Times a usual step, from which a step is a gap."""

PERIODS = 4.0
"""Of the band that a part of a log lasts at least."""

ROUNDED = 1e-12
"""Part of its size to which a filter and a spline know a column that never moves: noise is never taken as less."""

MOST = 5
"""Gaps of one log that are reported one by one."""


@dataclass(frozen=True)
class Motion:
    """A motion with its derivatives, ready for a regressor, at even times.

    Attributes:
        source: of the log.
        t: times, s, shape (N,).
        q: coordinates, shape (N, nq); behind them, where there are inputs or states, what `rate_rows` says.
        qd: velocities, shape (N, nv).
        qdd: accelerations, shape (N, nv).
        tau: driving forces as measured, shape (N, nv).
        noise: of the rates up to `cut`, standard deviations of q, q̇ and q̈, shape (3, nv); zero where they were given.
        band: up to which rows are taken, Hz.
        cut: up to which q was kept, Hz: the band, and no less than the motion takes, whose shape a filter would bend.
    """

    source: str
    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    noise: Array
    band: float
    cut: float


def spectrum(x: Array, step: float) -> tuple[Array, Array]:
    """Return frequencies, Hz, and power at them of the columns of x, shape (N, n), by a Hann window."""
    window = np.hanning(len(x))[:, None]
    line = np.linspace(0.0, 1.0, len(x))[:, None]
    moved = x - (x[:1] * (1 - line) + x[-1:] * line)
    power = np.abs(np.fft.rfft(moved * window, axis=0)) ** 2 / np.sum(window**2)
    return np.asarray(np.fft.rfftfreq(len(x), step), dtype=np.float64), power


def floor(x: Array, step: float) -> Array:
    """Return the variance of white noise of the columns of x, shape (n,), from the upper half of their spectrum.

    It is not less than what rounding makes of a column: the rates of a joint at rest are nothing but that.
    """
    frequency, power = spectrum(x, step)
    above = power[frequency >= 0.5 * frequency[-1]]
    found: Array = np.median(above, axis=0) / np.log(2.0)  # the median of an exponential distribution
    return np.asarray(np.maximum(found, (ROUNDED * np.abs(x).max(axis=0)) ** 2))


def reach(x: Array, step: float) -> float:
    """Return the highest frequency of the columns of x and their harmonics, shape (N, n), above noise; Hz, or 0."""
    frequency, power = spectrum(x, step)
    clear = np.where(power > ABOVE * floor(x, step), power, 0.0) * frequency[:, None] ** 4
    summed = np.cumsum(clear, axis=0).T
    found = (frequency[np.searchsorted(column, SHARE * column[-1])] for column in summed if column[-1] > 0)
    return float(max(found, default=0.0))


def smooth(x: Array, step: float, cut: float) -> Array:
    """Return the columns of x, shape (N, n), without what is faster than `cut` in Hz, not delayed."""
    from scipy.signal import butter, sosfiltfilt

    if (part_of := 2 * cut * step) >= 1:
        return x
    sections = butter(ORDER, part_of, output="sos")
    return np.asarray(sosfiltfilt(sections, x, axis=0, padlen=min(len(x) - 1, int(18 / part_of))))


def usual_bands(logs: Iterable[Log]) -> tuple[float, ...]:
    """Return bands in Hz, widest first, down to one that the motions just fit into."""
    logs = tuple(logs)
    steps = [float(np.median(np.diff(log.t))) for log in logs]
    highest, largest = max(reach(log.q, step) for log, step in zip(logs, steps, strict=True)), 0.4 / max(steps)
    if not highest:
        return (largest / 4,)
    found, narrowest = [min(largest, ROOM * highest)], min(largest, LEAST_ROOM * highest)
    while found[-1] > narrowest:
        found.append(max(found[-1] / 2, narrowest))
    return tuple(found)


def motions(log: Log, band: float) -> tuple[tuple[Motion, ...], tuple[str, ...]]:
    """Return the motion of a log, filtered, its edges dropped, and notes; a motion for each part between gaps."""
    step = float(np.median(np.diff(log.t)))
    ends = np.flatnonzero(np.diff(log.t) > GAP * step)
    notes, found, highest = list[str](), list[Motion](), reach(log.q, step)
    if band < highest:
        notes.append(
            f"{log.source}: the motion reaches {highest:.3g} Hz, above the band of {band:.3g} Hz: what forces tell "
            "there is not used; a band of twice that, or none given, makes standard errors smaller"
        )
    cut = max(band, min(0.4 / step, UNBENT * highest))
    for k in ends[:MOST]:
        notes.append(
            f"{log.source}: a gap from t = {log.t[k]:.6g} s to {log.t[k + 1]:.6g} s; both sides are used apart"
        )
    if len(ends) > MOST:
        notes.append(f"{log.source}: and {len(ends) - MOST} gaps more")
    for part in np.split(np.arange(len(log.t)), ends + 1):
        span = float(log.t[part[-1]] - log.t[part[0]])
        if len(part) < SHORTEST or span * band < PERIODS:
            notes.append(
                f"{log.source}: t = {log.t[part[0]]:.6g} s to {log.t[part[-1]]:.6g} s is too short for a band of "
                f"{band:.3g} Hz and left out"
            )
            continue
        one, told = _motion(log, part, step, band, cut)
        found.append(one)
        notes += [line for line in told if line not in notes]
    return tuple(found), tuple(notes)


def _motion(log: Log, part: Indices, step: float, band: float, cut: float) -> tuple[Motion, list[str]]:
    """Return the motion of one part of a log, and notes."""
    from scipy.interpolate import make_interp_spline

    t, q, tau = log.t[part], log.q[part], log.tau[part]
    qd, qdd = (None if x is None else x[part] for x in (log.qd, log.qdd))
    given = np.hstack([log.inputs[part], log.states[part]]) if log.inputs.size + log.states.size else None
    notes = []
    off = float(np.abs(np.diff(t) - step).max())
    if off > UNEVEN * step:
        even = np.linspace(t[0], t[-1], round(float((t[-1] - t[0]) / step)) + 1)
        q, tau = make_interp_spline(t, q, k=3)(even), make_interp_spline(t, tau, k=1)(even)
        qd, qdd, given = (None if x is None else make_interp_spline(t, x, k=3)(even) for x in (qd, qdd, given))
        t, step = even, float(even[1] - even[0])
        if off > TOLD * step:
            notes.append(f"{log.source}: steps differ by up to {off:.3g} s; interpolated to one of {step:.6g} s")
    noise = np.zeros((3, tau.shape[1]))

    def beside(q: Array, given: Array | None) -> Array:
        if given is None:
            return q
        own = given[:, log.inputs.shape[1] :]
        return np.hstack([q, t[:, None], given, make_interp_spline(t, own, k=5)(t, 1)])

    if qdd is not None and qd is not None:
        return Motion(log.source, t, beside(q, given), qd, qdd, tau, noise, band, cut), notes
    share, w = min(1.0, 2 * cut * step), 2 * np.pi * cut
    if qd is None:
        level, fit = share * floor(q, step), make_interp_spline(t, smooth(q, step, cut), k=5)
        q, qd, qdd = fit(t), fit(t, 1), fit(t, 2)
        noise = np.sqrt(np.stack([level, level * w**2 / 3, level * w**4 / 5]))
    else:
        level, fit = share * floor(qd, step), make_interp_spline(t, smooth(qd, step, cut), k=5)
        q, qd, qdd = smooth(q, step, cut), fit(t), fit(t, 1)
        noise = np.sqrt(np.stack([0 * level, level, level * w**2 / 3]))
    q = beside(q, None if given is None else smooth(given, step, cut))
    edge = min(int(np.ceil(EDGE / (band * step))), len(t) // 10)
    keep = slice(edge, len(t) - edge)
    return Motion(log.source, t[keep], q[keep], qd[keep], qdd[keep], tau[keep], noise, band, cut), notes


def projected(x: Array, rows: int) -> Array:
    """Return the sums of rows of x, shape (N, ...), over the slowest orthonormal cosines, shape (rows, ...)."""
    from scipy.fft import dct

    return np.asarray(dct(x, type=2, norm="ortho", axis=0)[:rows])
