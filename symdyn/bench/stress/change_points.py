"""Closed loops where it hurts: parallelograms at their change point, loops that say one thing twice.

The A02 benchmark of IFToMM (Gonzalez et al. 2006) turns N parallelograms in a row through their change point. Its angle
θ from the upward vertical is that of a pendulum, I θ'' = c g sin θ with I = (N + 1)/3 + N and c = (N + 1)/2 + N; the
references solve that to 40 digits. Problem A01 there is a pendulum in Cartesian coordinates: whichever of them is
chosen as independent fails somewhere on its way.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symdyn.bench.case import Case, energy_drift, of_motion
from symdyn.bench.stress.scenes import parallelogram, pinned
from symdyn.scene import Starter, read_text
from symdyn.simulation import Trajectory, simulate

TURNED = {2: (10.0, 31.750597186986102), 40: (10.0, 31.59743374398574)}
"""Number of loops: a time, and the angle then."""

A01 = (0.2750874625761600854173914492541662579534, -0.9614192050991250642651350685967630546063)
"""Where the pendulum of problem A01, level and at rest before, is after 10 s."""


def builtin() -> Iterator[Case]:
    """Yield parallelograms through their change point, alone, in a row, and with a coupler too many."""
    yield from _kept("four-bar through its change point, 5 s", simulate(parallelogram(), until=5.0))
    yield from _kept("two couplers, one of them redundant, 5 s", simulate(parallelogram(second=True), until=5.0))
    made = simulate(pinned(), until=10.0, method="dop853", rtol=1e-12)
    name = "pendulum as a free body and a pin, A01, 10 s"
    yield of_motion(name, "error of the place, m", 1e-9, np.abs(made.q[-1, :2] - A01).max(), made)
    yield from _kept(name, made)
    for loops, (until, angle) in TURNED.items():
        made = simulate(read_text(Starter("row").from_template("n_four_bar", loops)), until=until)
        name = f"{loops} four-bars in a row, A02, {until:g} s"
        yield of_motion(name, "relative error of the angle", 1e-9, abs(made.q[-1, 0] / angle - 1), made)
        yield from _kept(name, made)


def _kept(name: str, made: Trajectory) -> Iterator[Case]:
    loops = max(made.monitors["loops"], made.monitors["loop_rates"])
    yield of_motion(name, "drift of the energy over its size", 1e-9, energy_drift(made), made)
    yield of_motion(name, "residual of the loops, m and m/s", 1e-10, loops, made)
