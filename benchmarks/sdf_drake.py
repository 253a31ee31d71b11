"""SDF: our dynamics and Drake's, of tests/data/arm.sdf and of the robots of example-robot-data written as SDF.

Run: PYTHONPATH=tests python benchmarks/sdf_drake.py PYTHON, the last one a Python that has the package drake.
Each line: file, coordinates, and the largest difference of mass matrix and inverse dynamics at three random states,
relative to the largest entry; of what floats the mass matrix alone. Drake has no <mimic> in a discrete time of zero:
followers are held. Where Drake says that it puts another inertia in the place of one, nothing is compared.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from bars import at_most, told
from robots import robot_files

from symdyn.errors import SceneError
from symdyn.runtime import lambdify
from symdyn.scene import Scene
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats import sdf, urdf
from symdyn.scene.formats.sdf_writer import write_text

HERE = Path(__file__).parent

ARM = HERE.parent / "tests" / "data" / "arm.sdf"


def read_sdf(path: Path) -> Scene:
    """Return the scene in a file."""
    return sdf.read(path, ReadOptions(snap=False, allow_invalid_inertia=True)).scene


def agreement(path: Path, python: str) -> tuple[int, float, float]:
    """Return the coordinates of a file, and how far its mass matrix and inverse dynamics are from Drake's."""
    scene, rng = read_sdf(path), np.random.default_rng(0)
    n, m = len(scene.coordinates), len(scene.velocities)
    states = []
    for _ in range(3):
        q, i = rng.uniform(-1, 1, n), 0
        for joint in scene.joints:
            if joint.type == "free":
                q[i + 3 : i + 7] /= np.linalg.norm(q[i + 3 : i + 7])
            i += len(joint.coordinates)
        states.append({"q": q.tolist(), "v": rng.uniform(-1, 1, m).tolist(), "a": rng.uniform(-1, 1, m).tolist()})
    given = {
        "gravity": [float(x.at({})) for x in scene.gravity],
        "joints": [(j.name, j.type, len(j.coordinates), len(j.rates), j.child) for j in scene.joints],
        "floats": any(j.type == "free" for j in scene.joints),
        "states": states,
    }
    command = [python, str(HERE / "peers" / "drake_sdf.py"), str(path)]
    run = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True, env={}, check=False)
    if run.returncode:
        raise SceneError(f"Drake: {run.stderr.strip().splitlines()[-1][:120]}")
    if other := sorted(set(re.findall(r"named (\S+) has invalid inertia|(?:mass > 0').*failed", run.stderr))):
        raise SceneError(f"Drake puts other inertias in the place of {len(other)} that it holds for invalid")
    inverse, mass = lambdify(scene, ("inverse_dynamics", "mass_matrix"))
    errors = [0.0, 0.0]
    for state, theirs in zip(states, json.loads(run.stdout), strict=True):
        q, v, a = (np.array(state[key]) for key in "qva")
        pairs = [(mass(q), theirs["M"]), (inverse(q, v, a), theirs["tau"])]
        for k, (ours, other) in enumerate(pairs):
            if other is not None:
                errors[k] = max(errors[k], float(np.max(np.abs(ours - other)) / np.max(np.abs(other))))
    return n, errors[0], errors[1]


def main(python: str) -> int:
    """Print a line a file, and the bar; 1 where it is missed."""
    n, *errors = agreement(ARM, python)
    print(f"{ARM.name}: {n} coordinates, M %.1e, tau %.1e" % tuple(errors))
    worst, count = max(errors), 1
    for path in robot_files():
        try:
            scene = urdf.read(path, ReadOptions(snap=False, allow_invalid_inertia=True)).scene
            free = tuple(
                j if j.coupling is None else replace(j, coupling=None, type="fixed", shape=(), damping=j.damping)
                for j in scene.joints
            )
            text = write_text(scene if free == scene.joints else replace(scene, joints=free)).text
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "robot.sdf"
                file.write_text(
                    re.sub(r"<effort>[^<]*</effort>|<velocity>[^<]*</velocity>", "", text), encoding="utf-8"
                )
                n, mass, tau = agreement(file, python)
        except SceneError as error:
            print(f"{path.name}: {str(error).splitlines()[0][-150:]}")
            continue
        worst, count = max(worst, mass, tau), count + 1
        print(f"{path.name}: {n} coordinates, M {mass:.1e}, tau {tau:.1e}")
    return told([at_most(f"SDF, {count} files, off Drake's M and tau", 1e-12, worst)])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
