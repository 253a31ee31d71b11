"""Forward dynamics of a planar four-bar with one freedom: generated C against C written by hand, ns a call.

Run: python benchmarks/closed_loops.py
Both take q, qd, tau of all three joints (the dependent angles are supplied) and return all three accelerations. The
last lines add the closed-form position solution, and the velocities, in front. Medians of interleaved rounds.

The hand-written code is the textbook's reduction to one freedom: absolute angles, the crank's equation with the reduced
inertia, one division by the sine of the transmission angle.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

import numpy as np
from harness import Timed, measure
from native import NATIVE, address, compiled, loops

from symdyn.table import Table

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from closed_mechanisms import crank_rocker

from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.runtime.commands import FLAGS

BY_HAND = r"""
#include <math.h>
/* crank a, coupler b, rocker c, ground d; slender rods; theta, phi, psi their absolute angles */
static const double a = 1.0, b = 3.0, c = 3.5;
static const double I1 = 1.0 / 3.0 + 3.0, I2 = 3.0 * 9.0 / 3.0, I3 = 3.5 * 12.25 / 3.0; /* I1: the coupler at B too */
static const double k = 3.0 * 1.0 * 1.5; /* m2 a b / 2 */
static const double g1 = 9.81 * (0.5 + 3.0), g2 = 9.81 * 3.0 * 1.5, g3 = 9.81 * 3.5 * 1.75;

void by_hand(const double q[], const double qd[], const double tau[], double qdd[])
{
    const double theta = q[0], phi = q[0] + q[1], psi = q[2];
    const double s1 = sin(theta), c1 = cos(theta), s2 = sin(phi), c2 = cos(phi), s3 = sin(psi), c3 = cos(psi);
    const double w1 = qd[0], w2 = qd[0] + qd[1], w3 = qd[2];
    const double inverse = 1.0 / (s2 * c3 - c2 * s3); /* sin(phi - psi) */
    const double s13 = s1 * c3 - c1 * s3, c13 = c1 * c3 + s1 * s3;
    const double s12 = s1 * c2 - c1 * s2, c12 = c1 * c2 + s1 * s2, c23 = c2 * c3 + s2 * s3;
    const double r2 = -(a / b) * s13 * inverse, r3 = -(a / c) * s12 * inverse; /* of the unit rate of theta */
    const double e1 = a * w1 * w1, e2 = b * w2 * w2, e3 = c * w3 * w3;
    const double n2 = -(e1 * c13 + e2 * c23 - e3) * inverse * (1.0 / b);
    const double n3 = -(e1 * c12 + e2 - e3 * c23) * inverse * (1.0 / c);
    const double load1 = tau[0] - tau[1] - g1 * c1 - k * (c12 * n2 + s12 * w2 * w2);
    const double load2 = tau[1] - g2 * c2 + k * s12 * w1 * w1 - I2 * n2;
    const double load3 = tau[2] - g3 * c3 - I3 * n3;
    const double inertia = I1 + r2 * (2.0 * k * c12 + I2 * r2) + I3 * r3 * r3;
    const double x = (load1 + r2 * load2 + r3 * load3) / inertia;
    qdd[0] = x;
    qdd[1] = r2 * x + n2 - x;
    qdd[2] = r3 * x + n3;
}
"""

INSIDE = """
void with_positions(const double q[], const double qd[], const double tau[], double qdd[])
{
    double all[3], rates[3];
    four_bar_positions(q, all);
    four_bar_velocities(all, qd, rates);
    four_bar_forward_dynamics(all, rates, tau, qdd);
}
"""

STATES = 512


def main() -> int:
    """Print a table in Markdown."""
    scene = crank_rocker()
    program = lower(formulate(scene, ("positions", "velocities", "forward_dynamics")))
    sources = emit(program, "c")
    header, text = sources.files[1], sources.files[0][1]
    flags = (*(flag for flag in FLAGS if flag != "-shared"), *NATIVE, "-fopenmp-simd")
    code = text.replace(f'#include "{header[0]}"', header[1]) + INSIDE
    ours, theirs = ctypes.CDLL(str(compiled(code, flags))), ctypes.CDLL(str(compiled(BY_HAND, flags)))
    rng = np.random.default_rng(1)
    closed, moving = np.zeros((STATES, 3)), np.zeros((STATES, 3))
    q, qd, tau = (np.ascontiguousarray(rng.uniform(-2, 2, (STATES, 3))) for _ in range(3))
    for k in range(STATES):
        ours.four_bar_positions(address(q[k]), address(closed[k]))
        ours.four_bar_velocities(address(closed[k]), address(qd[k]), address(moving[k]))
    functions = {
        "hand-written C": theirs.by_hand,
        "symdyn": ours.four_bar_forward_dynamics,
        "symdyn, positions and velocities inside": ours.with_positions,
    }
    out = {name: np.zeros((STATES, 3)) for name in functions}
    clock = loops()

    def timed(name: str) -> Timed:
        places = [address(x) for x in (closed, moving, tau)]

        def sweep(sweeps: int) -> float:
            count = [ctypes.c_long(STATES), ctypes.c_long(sweeps), (ctypes.c_long * 3)(3, 3, 3), ctypes.c_long(3)]
            return float(clock.time_states(functions[name], 3, *count, *places, address(out[name])))

        return Timed("four-bar", "forward_dynamics", name, "state", STATES, sweep, lambda: out[name])

    measured = measure([timed(name) for name in functions], rounds=25, seconds=0.01)
    off = np.abs(out["hand-written C"] - out["symdyn"]).max() / np.abs(out["symdyn"]).max()
    assert off < 1e-10, f"the two disagree by {off:.1e}"
    base = np.array(measured[0].samples)
    rows = [(one.timed.peer, f"{one.median:.1f}", f"{np.median(np.array(one.samples) / base):.2f}") for one in measured]
    print(Table(("code", "ns a call", "of hand-written"), rows, (1, 2)).markdown(str))
    return 0


if __name__ == "__main__":
    sys.exit(main())
