"""Rates of an arm with six motors and PI servos beside its forward dynamics: operations, and time of built C.

    python benchmarks/state_rates.py        prints a table; ends with 1 where the bar is missed

Every joint of a PUMA 560 has a motor with a coil, whose voltage a PI servo sets. Beside forward dynamics of the same
arm, with torques 3 i, `state_rates` computes the rates of twelve states. It may take 1.15 times as long as that and its
own operations at the same pace. Times are the least of many batches that fit the caches.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import symdyn
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import Counts
from symdyn.scene import Scene, read_text
from symdyn.scene.toml import write_text
from symdyn.table import Table

BAR, STATES, TIMES = 1.15, 1000, 2000


def servo_arm() -> Scene:
    """Return the arm with its motors and servos."""
    text = write_text(symdyn.example("puma560")).text.replace('"puma560"', '"servo_arm"\nunits = "none"')
    for k in range(1, 7):
        text = text.replace(f"[joints.joint{k}]\n", f'[joints.joint{k}]\nforce = "3*i{k}"\n')
        text += f'[states.i{k}]\nrate = "(20*(0.3 - q{k}) + n{k} - q{k}_dot - 2*i{k})/0.01"\n'
        text += f'[states.n{k}]\nrate = "50*(0.3 - q{k})"\n'
    return read_text(text)


def least(call: Callable[..., Any], *given: np.ndarray) -> float:
    """Return nanoseconds a state."""
    found = []
    for _ in range(TIMES):
        begin = time.perf_counter()
        call(*given)
        found.append(time.perf_counter() - begin)
    return min(found) / STATES * 1e9


def main() -> int:
    """Print the table; return 1 where the bar is missed."""
    scene, rng = servo_arm(), np.random.default_rng(1)
    w = Workspace(scene)
    forward, rates = (derive_one(w, name) for name in ("forward_dynamics", "state_rates"))
    counts = [Counts.of(one) for one in (forward, rates)]
    own = counts[1] - counts[0]
    q, u, tau = (rng.uniform(-1, 1, (STATES, 6)) for _ in range(3))
    states = rng.uniform(-1, 1, (STATES, 12))
    built = symdyn.lambdify(scene, ("forward_dynamics", "state_rates"), target="c")
    times = [least(one, q, u, tau, states) for one in built]
    share = times[0] * own.cost / counts[0].cost
    ratio = times[1] / (times[0] + share)
    rows = [
        ("forward_dynamics", str(counts[0]), f"{times[0]:.0f}"),
        ("state_rates", str(counts[1]), f"{times[1]:.0f}"),
        ("their difference", str(own), f"{times[1] - times[0]:.0f}"),
    ]
    print(Table(("function", "operations", "ns a state"), rows, title="PUMA 560 with six motors and PI servos").text())
    print(f"state_rates takes {times[1] / times[0]:.3f} times as long, {ratio:.3f} of what its operations would take")
    return int(ratio > BAR)


if __name__ == "__main__":
    sys.exit(main())
