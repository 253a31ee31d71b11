"""MJX, MuJoCo written in JAX, over many states: a program of its own, since JAX has one width of numbers a process.

    python benchmarks/gpu_mjx.py double|float [--check]

It prints lines that benchmarks/gpu.py reads: "card NAME", "result FUNCTION NUMBERS" at the known states, and unless
`--check` is given "FUNCTION STATES SECONDS", where calls follow one another without waiting and arrays stay where they
are. Only the steps that a function needs are called, not `mjx.step`, and XLA drops what nobody reads.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import jax  # noqa: E402
import numpy as np  # noqa: E402
from cases import cases  # noqa: E402
from gpu_peers import BATCHES, FD, ID, TIMED  # noqa: E402
from mujoco import mjx  # noqa: E402
from mujoco.mjx._src import smooth  # noqa: E402
from peers.mujoco_c import model_of  # noqa: E402

ROUNDS, AT_LEAST = 7, 0.02


def main() -> int:
    """Print the lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("real", choices=("double", "float"))
    parser.add_argument("--check", action="store_true", help="results alone")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", options.real == "double")
    jax.config.update("jax_default_matmul_precision", "highest")  # else floats are multiplied with 10 bits on a card
    case = cases()[TIMED]
    model = mjx.put_model(model_of(case.urdf), impl="jax")
    calls = {name: jax.jit(jax.vmap(run)) for name, run in functions(model).items()}
    given = {ID: ("q", "qd", "qdd"), FD: ("q", "qd", "tau")}
    device = jax.devices()[0]
    print(f"card {device.device_kind} ({device.platform})")
    for name, call in calls.items():
        out = np.asarray(call(*(jax.numpy.asarray(case.states[one]) for one in given[name])))
        print(f"result {name} {' '.join(f'{x:.17g}' for x in out.ravel())}")
    if options.check:
        return 0
    number = jax.numpy.zeros(1)
    nothing = jax.jit(lambda x: x + 1)
    print(f"nothing 1 {seconds(lambda: nothing(number)):.9g}")
    for name, call in calls.items():
        for n in BATCHES:
            arrays = [jax.numpy.asarray(np.resize(case.states[one], (n, case.n))) for one in given[name]]
            print(f"{name} {n} {seconds(lambda: call(*arrays)):.9g}", flush=True)  # noqa: B023
    return 0


def functions(model: Any) -> dict[str, Callable[..., Any]]:
    """Return both functions of one state."""
    data = mjx.make_data(model)

    def inverse(q: Any, qd: Any, qdd: Any) -> Any:
        d = data.replace(qpos=q, qvel=qd, qacc=qdd)
        for step in (mjx.kinematics, mjx.com_pos, mjx.com_vel):
            d = step(model, d)
        return mjx.rne(model, d, flg_acc=True).qfrc_bias

    def forward(q: Any, qd: Any, tau: Any) -> Any:
        d = data.replace(qpos=q, qvel=qd)
        for step in (mjx.kinematics, mjx.com_pos, mjx.crb, mjx.factor_m, mjx.com_vel, mjx.rne):
            d = step(model, d)
        return smooth.solve_m(model, d, tau - d.qfrc_bias)

    return {ID: inverse, FD: forward}


def seconds(call: Callable[[], Any]) -> float:
    """Return the seconds of a call: the median of rounds of so many that a round takes 20 ms."""
    count, found = 1, []
    while len(found) < ROUNDS:
        start = time.perf_counter()
        for _ in range(count):
            last = call()
        last.block_until_ready()
        taken = time.perf_counter() - start
        if not found and taken < AT_LEAST:
            count *= 2
            continue
        found.append(taken / count)
    return median(found)


if __name__ == "__main__":
    sys.exit(main())
