"""A constant delay of driving forces behind the motion in a log: both were sampled, or written, at different times.

    τ(t) = F(t - d; β)            measured forces, F = Y β what the model says of the motion at a time
    τ(t + d) = Y β - δ τ̇          near a guess d: least squares of β and δ, and d + δ is the next guess

τ̇ is of measured forces, smoothed to what stands above their noise: in that of Y β would be noise of the positions,
differentiated three times, which residuals have too. The standard error is that of δ beside β.

Reference: Björklund and Ljung, A review of time-delay estimation techniques, IEEE CDC (2003), section IV.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symdyn.identification.filtered import LEAST_ROOM, Flags, reach, smooth
from symdyn.identification.gains import Fitted
from symdyn.identification.linear_model import LinearModel
from symdyn.identification.payload import DataPart, Evidence, rows_of
from symdyn.identification.regression import Rows, solve, solved

STEPS, SETTLED = 12, 1e-4
"""Of the search with the weights of the fit; part of a period of the band that the last one changes the delay by."""

SURE, TOLD, STILL = 4.0, 0.02, 1e-9
"""Standard errors, and parts of a step of the log, beyond both of which a delay is told; changes of forces in a period
of the band, over the forces, that are rounding."""


def delay(
    model: LinearModel, held: Evidence, found: Fitted, band: float, only: Sequence[int] = ()
) -> tuple[float, float]:
    """Return the delay of the forces of a fit, or of some of its motions, s, and its standard error; NaN: not told."""
    parts = [replace(part, motion=motion) for part, motion in zip(held.parts, found.motions, strict=True)]
    used, p, d = list(found.used), parts[0].Y.shape[2] - 1, 0.0
    beta, weights = found.regression.estimate[:p], found.regression.weights
    if only:
        counts = [len(_rows(model, [one], [mask], d).tau) for one, mask in zip(parts, used, strict=True)]
        weights = np.concatenate([np.split(weights, np.cumsum(counts))[k] for k in only])
        parts, used = [parts[k] for k in only], [used[k] for k in only]
    for _ in range(STEPS if len(weights) else 0):
        rows = _rows(model, parts, used, d)
        beta, *_ = solved(rows.Y, rows.tau, weights, np.zeros(p + 1), np.zeros((0, 0)))
        beta, step = beta[:p], float(beta[p])
        d += float(np.clip(step, -0.5 / band, 0.5 / band))
        if abs(step) < SETTLED / band:
            break
    names, rows = (*found.regression.names[:p], "delay"), _rows(model, parts, used, d)
    if np.abs(rows.Y[:, -1]).max(initial=0.0) <= STILL * band * np.abs(rows.force).max(initial=0.0):
        return 0.0, np.nan
    told = solve(names, rows, np.append(beta, 0.0), band, len(found.gains))
    return d + float(told.estimate[-1]), float(told.errors[-1])


def _rows(model: LinearModel, parts: Sequence[DataPart], used: Sequence[Flags], d: float) -> Rows:
    """Return rows of forces from d later on, with their slope as last column."""
    from scipy.interpolate import make_interp_spline

    moved, masks = list[DataPart](), list[Flags]()
    for part, mask in zip(parts, used, strict=True):
        t, tau, drawn = part.motion.t, part.motion.tau, part.drawn
        tau = make_interp_spline(t, tau, k=3)(np.clip(t + d, t[0], t[-1])) if d else tau
        cut = min(part.motion.band, LEAST_ROOM * reach(tau, step := float(t[1] - t[0])))
        slope = np.gradient(smooth(tau, step, cut), t, axis=0) if cut else 0 * tau
        Y = np.insert(part.Y, -1, -slope, axis=2)
        drawn = None if drawn is None else np.insert(drawn, -1, 0.0, axis=2)
        moved.append(replace(part, motion=replace(part.motion, tau=tau), Y=Y, drawn=drawn))
        masks.append(mask & ((t + d >= t[0]) & (t + d <= t[-1]))[:, None])
    rows = rows_of(model, moved, masks, False)
    buried = rows.buried[:, :-1] if rows.buried.size else rows.buried
    return replace(rows, Y=rows.Y[:, :-1], tau=rows.tau - rows.Y[:, -1], buried=buried, force=rows.tau)


def words(found: tuple[float, float], step: float, source: str) -> list[str]:
    """Return a note on a delay that is not zero."""
    d, error = found
    if not (np.isfinite(error) and abs(d) > max(SURE * error, TOLD * step)):
        return []
    late = f"as if driving forces came {1e3 * abs(d):.3g} ms {'after' if d > 0 else 'before'} the motion"
    more = f"with a standard error of {1e3 * error:.2g} ms, which pulls what is identified; move their columns by that"
    return [f"{source}: {late}, {more}"]
