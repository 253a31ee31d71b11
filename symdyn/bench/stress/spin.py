"""Fast spin: the heavy top, and a free top that flips about its middle axis.

heavy top    Geradin and Cardona, Flexible Multibody Dynamics (2001); reference integrated in 113 bits, two tolerances
that agree to 25 digits
free top     Euler's equations: 2T = ω·Jω and H² = |Jω|² are constant; ω in Jacobi's elliptic functions
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from symdyn.bench.case import Case, energy_drift, of_motion, worst
from symdyn.bench.stress.scenes import free_top, heavy_top
from symdyn.simulation import simulate

Array = npt.NDArray[np.float64]

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


def builtin() -> Iterator[Case]:
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
