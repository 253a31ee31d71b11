"""acados: models of `generate --target acados`, integrated and optimised by it, beside our own numbers.

Run: python benchmarks/acados_model.py PYTHON, the last one a Python that has acados: `pip install comma-deps-acados`
there, or its Python package with ACADOS_SOURCE_DIR and LD_LIBRARY_PATH set.
Each line of integrators: how far the end of a step of 0.1 s is from `simulate` at 1e-12, and by differences its first
sensitivities from that; the Hessian from differences of acados' own adjoint. Then an optimum by SQP with exact
Hessians: status, iterations, residual, seconds, and the bytes of C that compute the Hessian of one evaluation, as
CasADi differentiates our Jacobians; and the same with our C (`--external`), which acados' own calls.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from bars import Bar, at_most, told

import symdyn
from symdyn.cli import main as generate

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
T = 0.1

MODELS = {"cart_pole": (10, [0.1, 0.4, 0.2, -0.3], [2.0]),
          "puma560": (40, [0.3, -0.5, 0.7, 0.2, 0.4, -0.6, *[0.1] * 6], [5.0, 20.0, 5.0, 1.0, 0.5, 0.2])}  # fmt: skip


def ends(name: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the state at T, by us."""
    scene = symdyn.read(EXAMPLES / f"{name}.toml")
    drives = [one for one in scene.drives if one]
    n = len(scene.coordinates)
    run = symdyn.simulate(
        scene, forces=dict(zip(drives, u.tolist(), strict=True)), until=T, every=T, rtol=1e-12, atol=1e-12,
        start=dict(zip(scene.coordinates, x[:n].tolist(), strict=True)),
        start_rates=dict(zip(scene.coordinates, x[n:].tolist(), strict=True)),
    )  # fmt: skip
    return np.concatenate([run.q[-1], run.qd[-1]])


def sensitivities(name: str, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the derivatives of the end by the start and the forces, by differences."""
    given, step, columns = np.concatenate([x, u]), 1e-4, []
    for k in range(len(given)):
        moved = [given + sign * step * (np.arange(len(given)) == k) for sign in (1, -1)]
        first, second = (ends(name, one[: len(x)], one[len(x) :]) for one in moved)
        columns.append((first - second) / (2 * step))
    return np.transpose(columns)


def far(found: object, wanted: object) -> float:
    """Return the largest difference, by the largest entry."""
    return float(np.abs(np.array(found) - np.array(wanted)).max() / max(1.0, np.abs(np.array(wanted)).max()))


LIMITS = (("end of a step", 1e-6), ("S_forw", 1e-5), ("S_hess", 1e-5))
"""How far integrators may be off, over the largest entry: steps of both are of fourth order, differences have 1e-4."""


def measured(python: str, name: str, option: tuple[str, ...]) -> dict:
    """Return what acados finds of a model, in a process of its own."""
    where = "import acados; print(acados.LIB_DIR)"
    library = subprocess.run([python, "-c", where], capture_output=True, text=True, check=False).stdout.strip()
    environment = {**os.environ, "PYTHONPATH": ""} | ({"LD_LIBRARY_PATH": library} if library else {})
    steps, x, u = MODELS[name]
    with tempfile.TemporaryDirectory() as folder:
        scene = str(EXAMPLES / f"{name}.toml")
        assert generate(["generate", scene, "--target", "acados", "-o", folder, "--quiet", *option]) == 0
        made = f"{folder}/{name}_external"
        if option:
            subprocess.run(["gcc", "-O2", "-fPIC", "-shared", f"{made}.c", "-o", f"{made}.so", "-lm"], check=True)
        asked = {"name": name, "x": x, "u": u, "T": T, "steps": steps, "library": f"{made}.so" if option else ""}
        given = json.dumps({"folder": folder, "models": [asked]})
        command = [python, str(HERE / "peers" / "acados_model.py")]
        done = subprocess.run(command, input=given, capture_output=True, text=True, env=environment, check=False)
    if done.returncode:
        sys.exit(done.stderr[-2000:])
    return json.loads(done.stdout.splitlines()[-1])[name]


def main() -> int:
    """Print the lines, and bars; 1 where one is missed."""
    bars: list[Bar] = []
    (python,) = sys.argv[1:]
    for name, (_, x, u) in MODELS.items():
        end, slopes = ends(name, np.array(x), np.array(u)), sensitivities(name, np.array(x), np.array(u))
        costs = []
        for option in ((), ("--external",)):
            found, what = measured(python, name, option), f"{name}{', our C' if option else ''}"
            for kind in ("ERK", "IRK"):
                one = found[kind]
                off = far(one["x"], end), far(one["S_forw"], slopes), far(one["S_hess"], one["differences"])
                limits = zip(off, LIMITS, strict=True)
                bars += [at_most(f"{what}, {kind}, {text}, off", most, value) for value, (text, most) in limits]
                size = np.abs(one["S_hess"]).max()
                print(f"{what:17} {kind}  end {off[0]:.1e}  S_forw {off[1]:.1e}  S_hess {off[2]:.1e} of {size:.1e}")
            one = found["optimum"]
            how = f"status {one['status']}, {one['iterations']} iterations, residual {one['residuals']:.0e}"
            built = f"built in {one['built']:.1f} s, Hessian {one['bytes'] / 1e3:.0f} kB of C"
            print(f"{what:17} SQP  {how}, cost {one['cost']:.6g}, {one['seconds'] * 1e3:.1f} ms, {built}")
            solved = one["status"] == 0
            bars.append(Bar(f"{what}, SQP with exact Hessians", "status 0", f"status {one['status']}", solved))
            bars.append(at_most(f"{what}, C of its Hessian", 2, one["bytes"] / 1e6, "MB"))
            costs.append(one["cost"])
        bars.append(at_most(f"{name}, cost of both ways, off", 1e-9, abs(costs[0] - costs[1]) / costs[0]))
    return told(bars)


if __name__ == "__main__":
    sys.exit(main())
