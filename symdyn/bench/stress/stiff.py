"""Stiff springs, damped and not, against their closed form; methods are those that `simulate` chooses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symdyn.bench.case import Case, energy_drift, of_motion
from symdyn.bench.stress.scenes import rubbing, stiff_spring
from symdyn.simulation import METHODS, simulate

RUBBED = 0.02567383074505579027
"""Where the rubbing mass is after 2 s, by Taylor's method in 64 bits with steps that are short enough."""


def builtin() -> Iterator[Case]:
    """Yield springs from a metre out: x(t) is a sum of two exponentials, or a cosine."""
    for stiffness, damping in ((10**6, 10**5), (10**8, 10**7), (10**12, 10**9)):
        made = simulate(stiff_spring(stiffness, damping), until=1.0)
        slow = -2 * stiffness / (damping + np.sqrt(float(damping) ** 2 - 4 * stiffness))
        fast = -damping - slow
        x = (fast * np.exp(slow * made.t) - slow * np.exp(fast * made.t)) / (fast - slow)
        name = f"rates {-slow:.3g} and {-fast:.3g} per second, 1 s"
        yield of_motion(name, "error of x, m, tolerance 1e-8", 1e-6, np.abs(made.q[:, 0] - x).max(), made)
    made = simulate(rubbing(), until=2.0)
    name, gap = "dry friction, smooth within 1 mm/s, 2 s", abs(made.q[-1, 0] - RUBBED)
    yield of_motion(name, "error of x, m, tolerance 1e-8", 1e-5, gap, made)
    if METHODS["taylor"].installed:
        made = simulate(rubbing(), until=2.0, method="taylor", rtol=1e-12)
        gap = abs(float(made.q[-1, 0]) - RUBBED)
        yield Case("dry friction, by Taylor's method, 2 s", "error of x, m, tolerance 1e-12", 1e-10, gap)
    stiffness = 10**8
    made = simulate(stiff_spring(stiffness, 0), until=1.0, rtol=1e-15)
    name, gap = "1592 oscillations, no damping", np.abs(made.q[:, 0] - np.cos(np.sqrt(stiffness) * made.t)).max()
    yield of_motion(name, "error of x, m", 1e-9, gap, made)
    yield of_motion(name, "drift of the energy over its size", 1e-11, energy_drift(made), made)
