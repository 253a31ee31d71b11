"""Long and chaotic motions: the double pendulum against references in 113 bits, its energy over 1e4 seconds.

References are by the method of Gragg, Bulirsch and Stoer, two runs of different order and tolerance that agree to 18
digits or more. A disturbance of one ulp grows with the motion, a thousandfold from the horizontal and 1e8-fold from
high up: no code in doubles can do better than that, and the bounds leave it some tens of ulps.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symdyn.bench.case import Case, energy_drift, of_motion, worst
from symdyn.bench.stress.scenes import offset_pendulum, two_link
from symdyn.scene import Scene
from symdyn.simulation import simulate

TIGHTEST = 1e-15

TIGHT = 1e-12
"""Tolerance of a user's scene: what is judged is its equations, and stiff ones default to coarse steps."""

LONG, PATIENCE = 1e4, 30.0
"""Seconds of a long motion of a user's scene, and how long it may take to compute."""

ENDS = (  # name, start of q1 and q2, absolute angles at t = 10 s, bound
    ("regular, from 0.5 and 1 rad", ("1/2", "1/2"), (-0.24973260979313797, -0.09914901262953989), 1e-13),
    ("chaotic, from the horizontal", ("pi/2", "0"), (-0.5684746640159501, -0.5263937279324047), 1e-11),
    ("chaotic, from high up", ("3", "-1/2"), (-33.4146116944758, -19.01151728022292), 1e-6),
)

A01 = {
    10.0: 0.2786806735699829600484367747371447713460745,
    100.0: 0.1825251484957908510583110767935097325818,
    1000.0: -0.7521772168905752958481428714011651424977,
    2000.0: -0.9520445234156831972724167263908190548778,
}
"""Time, and the angle from the downward vertical in Jacobi's elliptic functions: A01 of Gonzalez et al. (2006)."""


def builtin() -> Iterator[Case]:
    """Yield the double pendulum from three starts, a pendulum, and the energy over a long time."""
    for name, (q1, q2), ends, bound in ENDS:
        made = simulate(two_link(), until=10.0, start={"q1": q1, "q2": q2}, rtol=TIGHTEST)
        gap = np.abs(np.cumsum(made.q[-1]) - ends).max()
        yield of_motion(f"double pendulum, {name}, 10 s", "error of the angles, rad", bound, gap, made)
    made = simulate(offset_pendulum(), until=2000.0, every=10.0, start={"q1": "pi/2"}, rtol=TIGHTEST)
    gaps = [(abs(float(made.q[round(t / 10), 0]) - angle), f"{made.method}, t = {t:g} s") for t, angle in A01.items()]
    yield Case("simple pendulum from level, A01, 2000 s", "error of the angle, rad", 1e-9, *worst(gaps))
    for name, (q1, q2) in (("regular", ("1/2", "1/2")), ("chaotic", ("pi/2", "0"))):
        made = simulate(two_link(), until=1e4, every=10.0, start={"q1": q1, "q2": q2}, rtol=TIGHTEST)
        metric = "drift of the energy over its size"
        yield of_motion(f"double pendulum, {name}, 1e4 s", metric, 1e-11, energy_drift(made), made)


def of_scene(scene: Scene) -> Iterator[Case]:
    """Yield the balance of energy and the loops of the scene's own motion, 10 s without drives."""
    name, metric = "10 s without drives", "balance of energy over its size"
    made = simulate(scene, until=10.0, rtol=TIGHT)
    yield of_motion(name, metric, 1e-8, energy_drift(made), made)
    if "loops" in made.monitors:
        yield of_motion(name, "residual of the loops, m", 1e-8, made.monitors["loops"], made)
    if not made.ended or made.wall * LONG / 10.0 > PATIENCE:
        return
    made = simulate(scene, until=LONG, every=LONG / 1000, rtol=1e-13)
    yield of_motion(f"{LONG:g} s without drives", metric, 1e-8, energy_drift(made), made)
