"""All second derivatives of robots, and contractions of them: `python benchmarks/second_derivatives.py [--rounds 50]`.

Generated C of one state a call, compiled as all benchmarks are: time of a call, size of the source, what gcc takes. The
humanoid has a free base, a torso of three joints, a head, two arms of seven and two legs of six, full inertias: 36
velocities. Its second derivatives of forward dynamics are arrays (`symdyn.runtime.second_derivatives`), from Python.
Published figures, of other machines: an Atlas of 36 velocities 200 us and 2.1 ms, a quadruped 51 us (Singh, Russell and
Wensing 2023). Packed ones are compared with differences of first derivatives along a velocity. Times are of the
processor for one thread, the least of rounds; the script ends with 1 where a bar was missed.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy is imported

import numpy as np
from bars import Bar, at_most, told
from native import NATIVE

from symdyn.dynamics import second_derivative_places
from symdyn.emit import emit
from symdyn.program import formulate, lower
from symdyn.runtime import lambdify, second_derivatives
from symdyn.scene import Scene, body, free, read, revolute, scene

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PACKED = "inverse_dynamics_second_derivatives_packed"
X, Y, Z = [1, 0, 0], [0, 1, 0], [0, 0, 1]
LIMBS = (
    ("torso", "trunk", (Z, Y, X), 0),
    ("head", "torso3", (Z,), 0),
    ("left", "torso3", (Y, X, Z, Y, Z, Y, X), 1),
    ("right", "torso3", (Y, X, Z, Y, Z, Y, X), -1),
    ("leg", "trunk", (Z, X, Y, Y, Y, X), 1),
    ("limp", "trunk", (Z, X, Y, Y, Y, X), -1),
)
INERTIA = {"xx": "0.03", "yy": "0.025", "zz": "0.02", "xy": "0.001", "xz": "0.002", "yz": "-0.001"}


def humanoid() -> Scene:
    """Return a robot of 36 velocities."""
    rng = np.random.default_rng(36)

    def link(name: str) -> Any:
        return body(name, mass=2, com=[f"{x:.3f}" for x in rng.uniform(-0.1, 0.1, 3)], inertia=INERTIA, about="com")

    bodies, joints = [link("trunk")], [free("flight", "ground", "trunk")]
    for name, root, axes, side in LIMBS:
        parent = root
        for k, axis in enumerate(axes, 1):
            bodies.append(link(f"{name}{k}"))
            at = ["0.01", "0.02", "-0.15"] if k > 1 else ["0.02", f"{0.15 * side:.2f}", "0.1"]
            joints.append(revolute(f"{name}{k}_joint", parent, f"{name}{k}", axis=axis, origin=at))
            parent = f"{name}{k}"
    return scene("humanoid36", bodies=bodies, joints=joints)


def state(model: Scene, seed: int = 1) -> list[np.ndarray]:
    """Return positions with a unit quaternion, velocities and accelerations or forces at random."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, len(model.coordinates))
    if len(model.coordinates) > len(model.velocities):
        q[3:7] /= np.linalg.norm(q[3:7])
    return [q, *rng.uniform(-1, 1, (2, len(model.velocities)))]


class Built:
    """One function of generated C."""

    def __init__(self, model: Scene, name: str, folder: str) -> None:
        """Derive, write and compile it."""
        begin = time.process_time()
        program = lower(formulate(model, [name]))
        texts = emit(program, "c").texts
        self.derived = time.process_time() - begin
        self.size = sum(map(len, texts.values())) / 1e6
        for file, text in texts.items():
            Path(folder, file).write_text(text, "utf-8")
        (source,) = (file for file in texts if file.endswith(".c"))
        library = Path(folder, f"{name}.so")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run(["gcc", *NATIVE, "-shared", str(Path(folder, source)), "-o", str(library), "-lm"], check=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.compiled, self.memory = used.ru_utime - before, used.ru_maxrss / 1e6
        self.call = getattr(ctypes.CDLL(str(library)), f"{model.name}_{name}")
        self.function = program.routines[0].function
        self.out = np.zeros(self.function.shape)

    def given(self, model: Scene) -> list[Any]:
        """Return addresses of arguments at random."""
        known = dict(zip(("q", "qd", "last"), state(model), strict=True))
        rng = np.random.default_rng(2)
        self.kept = [
            known.get(a.name, known["last"] if a.name in ("qdd", "tau") else rng.uniform(-1, 1, len(a.symbols)))
            for a in self.function.arguments
        ]
        return [ctypes.c_void_p(one.ctypes.data) for one in (*self.kept, self.out)]


def least(run: Callable[[], object], rounds: int, each: int) -> float:
    """Return the least mean of rounds, us of the processor for this thread."""
    found = []
    for _ in range(rounds):
        begin = time.thread_time()
        for _ in range(each):
            run()
        found.append((time.thread_time() - begin) / each * 1e6)
    return min(found)


def off(model: Scene, built: Built) -> float:
    """Return how far packed second derivatives by the last joint's velocity are from differences, in parts of them."""
    first, n, at = (
        lambdify(model, "inverse_dynamics_derivatives"),
        len(model.velocities),
        second_derivative_places(model),
    )
    there, here = ([*built.kept] for _ in range(2))
    step = np.eye(n)[n - 1] * 1e-4
    there[1], here[1] = built.kept[1] + step, built.kept[1] - step
    slopes = (first(*there) - first(*here)) / 2e-4
    rows = at[:, 2] == 2 * n - 1
    expected = slopes[at[rows, 0], at[rows, 1]]
    return float(np.abs(built.out[rows] - expected).max() / np.abs(expected).max())


CASES = (
    ("quadruped", PACKED, 10),
    ("quadruped", "forward_dynamics_second_derivatives_packed", None),
    ("humanoid36", PACKED, 50),
    ("humanoid36", "inverse_dynamics_hessian", 60),
    ("humanoid36", "inverse_dynamics_hessian_vector", 60),
    ("humanoid36", "forward_dynamics_hessian", 60),
    ("humanoid36", "forward_dynamics_hessian_vector", 60),
)
"""Robot, function, and us of a call at most."""


def main() -> int:
    """Print a line a function, and the bars; 1 where one is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=50)
    parser.add_argument("--quick", action="store_true", help="the quadruped alone")
    given = parser.parse_args()
    models = {"quadruped": read(EXAMPLES / "quadruped.toml"), "humanoid36": humanoid()}
    bars: list[Bar] = []
    print(f"{'':56}{'entries':>9}{'us':>8}{'derived, s':>12}{'source, MB':>12}{'gcc, s':>8}{'GB':>6}")
    for robot, name, most in CASES[:2] if given.quick else CASES:
        with tempfile.TemporaryDirectory() as folder:
            built, model = Built(models[robot], name, folder), models[robot]
            arguments = built.given(model)
            micro = least(lambda: built.call(*arguments), given.rounds, 20)  # noqa: B023  called here
        print(f"{robot + ' ' + name:56}{built.out.size:9}{micro:8.1f}{built.derived:12.1f}{built.size:12.2f}"
              f"{built.compiled:8.1f}{built.memory:6.2f}")  # fmt: skip
        if most:
            bars.append(at_most(f"{robot}, {name}", most, micro, "us"))
        if name == PACKED:
            bars.append(at_most(f"{robot}, {name}, off differences", 1e-7, off(model, built)))
        bars.append(at_most(f"{robot}, {name}, source", 2, built.size, "MB"))
        bars.append(at_most(f"{robot}, {name}, gcc", 60, built.compiled, "s"))
        bars.append(at_most(f"{robot}, {name}, gcc", 2, built.memory, "GB"))
    for robot, most in (("quadruped", None), ("humanoid36", 1000)) if not given.quick else ():
        arrays, at = second_derivatives(models[robot]), state(models[robot])
        micro = least(lambda: arrays.forward(*at), given.rounds, 10)  # noqa: B023
        print(f"{robot + ', arrays of forward dynamics, from Python':65}{micro:8.1f}")
        if most:
            bars.append(at_most(f"{robot}, all second derivatives of forward dynamics", most, micro, "us"))
    return told(bars)


if __name__ == "__main__":
    sys.exit(main())
