"""Regressors side by side with Pinocchio in C++: seventy columns of an arm of seven axes, and the fewest.

    python benchmarks/regressors.py [--rounds 15] [--robots puma560,arm7]

Ours are compiled C, one state a call and batches; Pinocchio's are computeJointTorqueRegressor and
computeCoriolisMatrix, whose products with its parameters and with velocities are compared with our forces before they
are timed. Needs `pip install -e '.[bench]'`.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT), str(ROOT / "tests")]

import numpy as np  # noqa: E402
from cases import EXAMPLES, Case  # noqa: E402
from harness import CLOSE, Timed, measure  # noqa: E402
from peers import ours_c, pinocchio_cpp  # noqa: E402

from symdyn.scene import read  # noqa: E402

OURS = ("regressor", "base_regressor", "coriolis_matrix")
THEIRS = {"regressor": "regressor", "base_regressor": "regressor", "coriolis_matrix": "coriolis_matrix"}
BAR = 10
"""Times as fast as Pinocchio's regressor that the base regressor is to be, one state a call."""


def compared(one: Timed, case: Case) -> Timed:
    """Return what is timed, if it gives the forces that the equations give."""
    found = one.result()
    if one.peer == pinocchio_cpp.NAME:
        right = pinocchio_cpp.parameters(case) if one.output == "regressor" else None
        right = case.states["qd"] if right is None else np.broadcast_to(right, (len(found), len(right)))
        forces = np.einsum("kij,kj->ki", found.reshape(len(found), case.n, -1), right)
        off = case.difference("inverse_dynamics" if one.output == "regressor" else "velocity_forces", forces)
    else:
        off = case.difference(one.output, found)
    assert off < CLOSE, f"{one.peer}, {one.output}: off by {off:.1e}"
    return one


def main() -> None:
    """Print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--robots", default="puma560,arm7")
    options = parser.parse_args()
    for name in options.robots.split(","):
        case = Case(name, read(EXAMPLES / f"{name}.toml"))
        ours = [one for output in OURS for one in ours_c.timed(case, output) if one.peer == ours_c.NAME]
        theirs = [one for output in sorted({*THEIRS.values()}) for one in pinocchio_cpp.timed(case, output)]
        found = measure([compared(one, case) for one in (*ours, *theirs)], options.rounds, 0.02)
        peer = {one.timed.output: one for one in found if one.timed.peer == pinocchio_cpp.NAME}
        for one in found:
            other = peer[THEIRS[one.timed.output]]
            ratio = median(b / a for a, b in zip(one.samples, other.samples, strict=True))
            size = len(case.programs[one.timed.output].routines[0].function.entries)
            print(
                f"{name:8} {one.timed.peer:14} {one.timed.output:16} {one.timed.way:6} {size:4} entries "
                f"{one.median:8.1f} ns  {ratio:6.2f} times Pinocchio's {other.timed.output}"
            )
    print(f"bar: base regressor, one state a call, at least {BAR} times Pinocchio's regressor")


if __name__ == "__main__":
    main()
