"""Times of samples."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from symdyn.scene.values.table import Faults

Array = npt.NDArray[np.float64]

SAMPLES = 200
"""Samples after the first, if no spacing is given."""

MOST = 20_000_000
"""Samples that are more than anybody reads."""


def sample_times(until: float, every: float | None, faults: Faults) -> Array:
    """Return 0, every, 2 every, ..., until."""
    if not (math.isfinite(until) and until > 0):
        faults.add("", f"until = {until:g} s is not a time after the start; give a positive one")
        return np.zeros(1)
    if every is None:
        return np.linspace(0.0, until, SAMPLES + 1)
    if not (math.isfinite(every) and every > 0):
        faults.add("", f"every = {every:g} s is no spacing of samples; give a positive one")
        return np.zeros(1)
    if until / every > MOST:
        faults.add("", f"every = {every:g} s makes {until / every:.3g} samples of {until:g} s; {MOST:.3g} are the most")
        return np.zeros(1)
    count = math.floor(until / every * (1 + 1e-12))
    times: Array = every * np.arange(count + 1, dtype=np.float64)
    if until - times[-1] > 1e-9 * every:
        return np.append(times, until)
    times[-1] = until
    return times
