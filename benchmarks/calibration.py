"""Whether stated intervals of a calibration hold the truth, over seeds, and FIGAROH beside on the same poses.

    python benchmarks/calibration.py [--arms two_link,puma560,arm7] [--seeds 100] [--poses 60] [--figaroh PYTHON]

Poses have noise of 0.1 mm, and turns of 0.2 mrad where they are measured; what no motion separates from others is as in
the scene, the rest is off by some 2 mm and 2 mrad. Seeds are 0, 1, 2, ... and none is picked. Counted is for how many
parameters of all seeds the 95 % interval holds the true value, the least and the most of one parameter; without noise
how far estimates are off; and how long one takes. `--figaroh` names the Python of an environment with
`pip install figaroh==1.0.2`, which is given the file of arm7 and positions of one seed.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from bars import Bar, at_most, told
from scipy.spatial.transform import Rotation

import symdyn
from symdyn.identification.geometry import GeometricModel
from symdyn.scene import Scene, write_text

NOISE, TURNS, SIZE = 1e-4, 2e-4, 2e-3
"""m and rad: of positions and of turns; of what parameters are off."""

VALUES = {"two_link": {"m1": 1, "m2": 1, "h1": 0.4, "h2": 0.3, "g": 9.81}}
PARAMETERS = {"two_link": ("h*", "*_offset")}


def poses(model: GeometricModel, values: Any, q: Any, noise: float, rng: Any, turned: bool) -> dict[str, Any]:
    """Return a log of poses."""
    p, R, _ = model.at(values, q)
    found = dict(zip(model.coordinates, q.T, strict=True))
    found |= dict(zip("xyz", (p + noise * NOISE * rng.standard_normal(p.shape)).T, strict=True))
    if turned:
        turns = Rotation.from_rotvec(noise * TURNS * rng.standard_normal(p.shape)) * Rotation.from_matrix(R)
        found |= dict(zip(("rx", "ry", "rz"), turns.as_rotvec().T, strict=True))
    return found


def one(scene: Scene, point: str, asked: Any, seed: int, count: int, turned: bool, noise: float) -> tuple[Any, ...]:
    """Return names, whether intervals hold the truth, errors and seconds of one seed."""
    rng = np.random.default_rng(seed)
    model = GeometricModel.of(scene, point)
    q = rng.uniform(-1.5, 1.5, (count, len(model.coordinates)))
    told = symdyn.calibrate(scene, poses(model, model.values, q, 0, rng, turned), point, asked).names
    truth = model.values.copy()
    places = [model.names.index(name) for name in told]
    truth[places] += SIZE * rng.standard_normal(len(places))
    log = poses(model, truth, q, noise, rng, turned)
    start = time.perf_counter()
    found = symdyn.calibrate(scene, log, point, asked)
    seconds = time.perf_counter() - start
    true = np.array([truth[model.names.index(name)] for name in found.names])
    low, high = found.interval().T
    return found.names, (low <= true) & (true <= high), np.abs(found.after - true), seconds


def figaroh(python: str, count: int) -> Bar:
    """Calibrate the zeros of arm7 by FIGAROH and here, from the same positions; return how far both are apart."""
    scene = symdyn.example("arm7")
    model, rng = GeometricModel.of(scene, "link7"), np.random.default_rng(0)
    q, truth = rng.uniform(-1.5, 1.5, (count, 7)), model.values.copy()
    offsets = [f"q{k}_offset" for k in range(1, 7)]
    truth[[model.names.index(name) for name in offsets]] = SIZE * rng.standard_normal(len(offsets))
    log = poses(model, truth, q, 1.0, rng, False)
    found = symdyn.calibrate(scene, log, "link7", offsets)
    with TemporaryDirectory() as folder:
        at = Path(folder)
        (at / "arm.urdf").write_text(write_text(scene, "urdf", lossy=True).text)
        (at / "poses.json").write_text(json.dumps({"q": q.tolist(), "p": np.stack([log[k] for k in "xyz"]).T.tolist()}))
        ran = subprocess.run(
            [python, str(Path(__file__).with_name("figaroh_calibration.py")), folder],
            capture_output=True,
            text=True,
            check=False,
        )
    if ran.returncode:
        sys.exit(ran.stderr[-2000:])
    other = json.loads(ran.stdout.splitlines()[-1])
    print("zeros of the joints of arm7, rad:  truth, here ± standard error, FIGAROH ± its standard deviation")
    apart = 0.0
    for name, error in zip(found.names, found.errors, strict=True):
        there = other[f"offsetRZ_joint{name[1]}"]
        apart = max(apart, abs(found[name] - there[0]))
        print(
            f"  {name} {truth[model.names.index(name)]:.7f}  {found[name]:.7f} ± {error:.1e}  "
            f"{there[0]:.7f} ± {there[1]:.1e}"
        )
    return at_most("zeros of arm7, apart from FIGAROH's", 1e-7, apart, "rad")


def main() -> int:
    """Count and print; 1 where a bar is missed."""
    bars: list[Bar] = []
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", default="two_link,puma560,arm7")
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--figaroh")
    options = parser.parse_args()
    for name in filter(None, options.arms.split(",")):
        scene = symdyn.scene.scene_of(symdyn.example(name), VALUES.get(name))
        point = scene.bodies[-1].name if name not in VALUES else "tool"
        for turned in (True, False) if name not in VALUES else (False,):
            every = [
                one(scene, point, PARAMETERS.get(name), seed, options.poses, turned, 1.0)
                for seed in range(options.seeds)
            ]
            clean = one(scene, point, PARAMETERS.get(name), 0, options.poses, turned, 0.0)
            held: dict[str, list[bool]] = {}
            for names, inside, _, _ in every:
                for each, yes in zip(names, inside, strict=True):
                    held.setdefault(each, []).append(bool(yes))
            shares = [100 * np.mean(one) for one in held.values() if len(one) > options.seeds / 2]
            whole = 100 * np.mean([yes for one in held.values() for yes in one])
            what = f"{name}, {'poses' if turned else 'positions'}"
            off = 3 * 100 * (0.05 * 0.95 / options.seeds) ** 0.5  # three deviations, if all parameters went together
            text, wanted = f"{what}, intervals of 95 % that hold", f"95 ± {off:.1f} %"
            bars.append(Bar(text, wanted, f"{whole:.1f} %", bool(abs(whole - 95) <= off)))
            bars.append(at_most(f"{what}, off without noise", 1e-12, float(clean[2].max()), "m, rad"))
            print(
                f"{name:9} {'poses    ' if turned else 'positions'} {len(every[0][0])} parameters: intervals hold "
                f"{whole:.1f} % (least {min(shares):.0f}, most {max(shares):.0f}); without noise off by "
                f"{clean[2].max():.1e}; {np.median([one[3] for one in every]):.2f} s"
            )
    if options.figaroh:
        bars.append(figaroh(options.figaroh, options.poses))
    return told(bars)


if __name__ == "__main__":
    sys.exit(main())
