"""Motions that are hard to integrate: fast spin, stiff springs, loops through change points, chaos and long times.

Heavy top (Geradin and Cardona, Flexible Multibody Dynamics, 2001): the reference is integrated in 113 bits at two
tolerances that agree to 25 digits. A free top that flips about its middle axis: Euler's equations, 2T = ω·Jω and
H² = |Jω|² are constant, ω in Jacobi's elliptic functions.

Stiff springs, damped and not, are compared with their closed form; methods are those that `simulate` chooses.

The A02 benchmark of IFToMM (Gonzalez et al. 2006) turns N parallelograms in a row through their change point. Its angle
θ from the upward vertical is that of a pendulum, I θ'' = c g sin θ with I = (N + 1)/3 + N and c = (N + 1)/2 + N; the
references solve that to 40 digits. Problem A01 there is a pendulum in Cartesian coordinates: whichever coordinate is
chosen as independent fails somewhere on its way.

References of the double pendulum are by the method of Gragg, Bulirsch and Stoer in 113 bits, two runs of different
order and tolerance that agree to 18 digits or more. A disturbance of one ulp grows with the motion, a thousandfold from
the horizontal and 1e8-fold from high up. No code in doubles can do better, and the bounds allow some tens of ulps. Over
1e4 seconds only the energy is judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from symdyn.algebra import Array
from symdyn.bench.measurements import Case, energy_drift, of_motion, worst
from symdyn.bench.stress.scenes import (
    free_top,
    heavy_top,
    offset_pendulum,
    parallelogram,
    pinned,
    rubbing,
    stiff_spring,
    two_link,
)
from symdyn.scene import Scene, Starter, read_text
from symdyn.simulation import METHODS, Trajectory, simulate

TIGHTEST = 1e-15

HEAVY_COM = {
    0.1: (0.42129665892540204364731043, 0.89457197434559299089118047, -0.14916470056189961161832080),
    1.0: (0.17334396409838604259196611, 0.64008859207056878286059200, -0.74849079113358130948359768),
    2.0: (-0.15041682274564175981003083, -0.72416559163689565074855440, -0.67302226954044409605022105),
}
FREE_RATES = {
    1.0: (
        -0.11772830612228216500510650861835365,
        9.9993070282863891177451152570080085,
        0.06797537314454841175199715117,
    ),
    10.0: (
        -0.058973745415728225205933237103723771,
        -9.9998261533564492700143703889373700,
        0.034058296338088344736494005,
    ),
}


def spin() -> Iterator[Case]:
    """Yield the tops."""
    made = simulate(heavy_top(), until=2.0, every=0.1, rtol=TIGHTEST)
    w, x, y, z = made.q.T
    com = np.stack([2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)], axis=1)
    com /= np.sum(made.q**2, axis=1, keepdims=True)
    name = "heavy top, 150 rad/s, 2 s"
    yield Case(name, "error of the centre of mass, m", 1e-10, *_largest(com, HEAVY_COM))
    yield of_motion(name, "drift of the energy over its size", 1e-12, energy_drift(made), made)
    made = simulate(free_top(), until=100.0, every=0.1, rtol=TIGHTEST)
    J = np.array([1.0, 2.0, 3.0])
    twice, squared = (J * made.qd**2).sum(axis=1), ((J * made.qd) ** 2).sum(axis=1)
    name = "middle axis, three flips, 10 s"
    for letter, values in (("2T", twice), ("H^2", squared)):
        drift = np.abs(values[:101] / values[0] - 1).max()
        yield of_motion(name, f"relative drift of {letter}", 1e-13, drift, made)
    drift = np.abs(twice / 200.000004 - 1).max()
    yield of_motion("middle axis, 28 flips, 100 s", "relative drift of 2T", 1e-12, drift, made)
    yield Case(name, "error of the rates, rad/s", 1e-8, *_largest(made.qd, FREE_RATES))


def _largest(values: Array, known: Mapping[float, tuple[float, ...]]) -> tuple[float | None, str]:
    """Return the largest error at the times that are known, and when it is, of rows a tenth of a second apart."""
    return worst([(float(np.abs(values[round(t / 0.1)] - row).max()), f"t = {t:g} s") for t, row in known.items()])


RUBBED = 0.02567383074505579027
"""Where the rubbing mass is after 2 s, by Taylor's method in 64 bits with steps that are short enough."""


def stiff() -> Iterator[Case]:
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


TURNED = {2: (10.0, 31.750597186986102), 40: (10.0, 31.59743374398574)}
"""Number of loops: a time, and the angle then."""

PINNED = (0.2750874625761600854173914492541662579534, -0.9614192050991250642651350685967630546063)
"""Where the pendulum of problem A01, level and at rest before, is after 10 s."""


def change_points() -> Iterator[Case]:
    """Yield parallelograms through their change point, alone, in a row, and with a coupler too many."""
    yield from _kept("four-bar through its change point, 5 s", simulate(parallelogram(), until=5.0))
    yield from _kept("two couplers, one of them redundant, 5 s", simulate(parallelogram(second=True), until=5.0))
    made = simulate(pinned(), until=10.0, method="dop853", rtol=1e-12)
    name = "pendulum as a free body and a pin, A01, 10 s"
    yield of_motion(name, "error of the place, m", 1e-9, np.abs(made.q[-1, :2] - PINNED).max(), made)
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


def chaos() -> Iterator[Case]:
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


def chaos_of_scene(scene: Scene) -> Iterator[Case]:
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
