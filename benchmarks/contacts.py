"""Contacts, stops and dry friction: times and velocities against closed forms, laws in numbers, time of a run.

    python benchmarks/contacts.py

Each line has what was set out to be reached; the script ends with 1 where one was missed.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import symdyn
from symdyn.simulation.equations.complementarity import FREE, Laws

DATA = Path(__file__).resolve().parent.parent / "tests" / "data" / "impacts"
RANDOM = 10_000


def told(name: str, value: float, most: float, unit: str) -> bool:
    """Print one line; return whether it was missed."""
    missed = not value <= most
    print(f"{name:64} {value:10.3g} {unit:4} of {most:g} {'MISSED' if missed else 'reached'}")
    return missed


def ball() -> list[bool]:
    """Return what was missed by a ball that bounces until it rests."""
    scene = symdyn.read(DATA / "scenes" / "ball.toml")
    first = (2 / 9.81) ** 0.5
    truth = [first * (1 + 2 * sum(0.8**i for i in range(1, k + 1))) for k in range(30)]
    missed = []
    for method in ("taylor", "dop853"):
        run = symdyn.simulate(scene, until=6, method=method, rtol=1e-13)
        hits = [one.t for one in run.impacts][:30]
        worst = float(np.abs(np.array(hits) - truth).max())
        missed.append(told(f"ball by {method}: time of 30 hits, largest error", worst, 1e-12, "s"))
        rest = abs((run.impacts[-1].rest or 0.0) - first * 1.8 / 0.2)
        missed.append(told(f"ball by {method}: when it rests, error", rest, 1e-10, "s"))
        missed.append(
            told(f"ball by {method}: its rate then", float(np.abs(run["z_dot"][run.t > 4.1]).max()), 0.0, "m/s")
        )
    times = []
    for _ in range(7):
        begin = time.perf_counter()
        run = symdyn.simulate(scene, until=6, method="taylor")
        times.append(1e3 * (time.perf_counter() - begin))
    ninety = median(times) * 90 / len(run.impacts)
    missed.append(told(f"ball: {len(run.impacts)} events in {median(times):.0f} ms; ninety of them", ninety, 50, "ms"))
    return missed


def references() -> list[bool]:
    """Return what was missed of published figures; see tests/test_contacts.py."""
    missed = []
    for case in json.loads((DATA / "references.json").read_text())["cases"]:
        if "scene" not in case or case["id"] == "ball":
            continue
        run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=case["until"], method="taylor", rtol=1e-13)
        words = {"impact": "strikes", "stick": "sticks", "slip": "slips"}
        for kind, *rest in (one["what"] for one in case["expect"][:1]):
            if kind == "time":
                what, contact, k = rest
                hits = [one.t for one in run.impacts if one.what == words[what] and one.contact.startswith(contact)]
                wanted = case["expect"][0]
                off = abs([t for t in hits if t > 1e-9][k] - wanted["value"])
                missed.append(told(f"{case['id']}: time of the first event, error", off, wanted["tol"], "s"))
        kept = [value for name, value in run.monitors.items() if name.startswith("contact_laws")]
        missed.append(told(f"{case['id']}: laws of contact, every row", max(kept, default=0.0), 1e-12, ""))
        missed.append(told(f"{case['id']}: energy balance", float(np.abs(run["energy_error"]).max()), 1e-10, "J"))
    return missed


def laws() -> list[bool]:
    """Return what was missed by the laws on random contacts: two ways to solve, and no energy gained."""
    rng, differ, gained, count = np.random.default_rng(0), 0, 0, 0
    times = {"cases": 0.0, "pivots": 0.0}
    for _ in range(RANDOM):
        k = int(rng.integers(1, 3))
        B, W = rng.normal(size=(8, 8)), rng.normal(size=(2 * k, 8))
        D = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(8), W.T)
        mu, e = rng.uniform(0, 1, k), np.full(k, rng.uniform(0, 1))
        one = Laws(D, tuple(range(0, 2 * k, 2)), tuple((i,) for i in range(1, 2 * k, 2)), mu, mu, e)
        v = W @ rng.normal(size=8)
        if not np.any(v[::2] < 0):
            continue
        count += 1
        target = np.zeros(2 * k)
        target[::2] = -e * v[::2]
        begin = time.perf_counter()
        cases = [found for _, found in one.solutions(v, [(FREE, *one.slips(i)) for i in range(k)], None, target)]
        between = time.perf_counter()
        pivots = one.by_pivots(v, [0.0] * k, np.zeros(k), target)
        times["cases"] += between - begin
        times["pivots"] += time.perf_counter() - between
        size = max(1e-6, *(float(np.abs(found).max()) for found in cases))
        differ += pivots is None or min(float(np.abs(found - pivots).max()) for found in cases) > 1e-8 * size
        impulses = one.impact(v, [True] * k)
        gained += impulses @ (2 * v + D @ impulses) / 2 > 1e-14 * np.abs(impulses * v).sum()
    print(f"{count} random impacts of one or two contacts: all cases {1e6 * times['cases'] / count:.0f} us each, "
          f"Lemke {1e6 * times['pivots'] / count:.0f} us")  # fmt: skip
    return [
        told("all cases and Lemke's pivots, differences", differ, 0, ""),
        told("Poisson's law, one restitution: impacts that add energy", gained, 0, ""),
    ]


def gaits() -> list[bool]:
    """Return what was missed by periodic motions: a biped's fixed point with its multipliers, from a loaded scene."""
    walker = symdyn.read(DATA / "scenes" / "walker.toml")
    asked: dict[str, Any] = {"section": "strikes foot_a", "swap": "a=b"}
    found = symdyn.gait(walker, **asked).continued("slope", [0.0095])[0]
    times = []
    for slope in (0.0096, 0.0097, 0.0098, 0.0099, 0.01):
        begin = time.process_time()
        (found,) = found.continued("slope", [slope])
        times.append(time.process_time() - begin)
    return [
        told("walker: a fixed point and its multipliers, processor time", median(times), 0.1, "s"),
        told("walker: what its fixed point misses itself by", found.missed, 1e-9, ""),
    ]


TIMED = 3
"""Runs of each kind, of which the fastest counts."""


def timed(run: Callable[[], float]) -> tuple[float, float]:
    """Return what a run misses, m, and its time, s."""
    missed, times = run(), []
    for _ in range(TIMED):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return missed, min(times)


def end_missed(scene: symdyn.Scene, column: str, until: float, exact: float, method: str) -> float:
    """Return what a run by a method misses at its end, m."""
    return abs(float(symdyn.simulate(scene, until=until, every=until / 2, method=method)[column][-1]) - exact)


def beside_mujoco(scene: str, step: float, until: float, rest: float) -> Callable[[], float]:
    """Return a run by MuJoCo of a scene of this file, from its MJCF in `MJCF`; it misses `rest` at its end, m."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(MJCF[scene])
    model.opt.timestep = step
    data = mujoco.MjData(model)

    def run() -> float:
        mujoco.mj_resetData(model, data)
        data.qvel[0] = 2.0 if scene == "brick" else 0.0
        for _ in range(round(until / step)):
            mujoco.mj_step(model, data)
        return abs(float(data.qpos[0] + (scene == "ball")) - rest)

    return run


MJCF = {
    "brick": """<mujoco><option gravity="2.8990532273477414 0 -9.3718509279"/><worldbody>
<geom type="plane" size="9 9 1" friction="0.5 0 0"/><body pos="0 0 0.1"><joint type="slide" axis="1 0 0"/>
<joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.1" mass="1" friction="0.5 0 0"/></body>
</worldbody></mujoco>""",
    "ball": """<mujoco><worldbody><geom type="plane" size="9 9 1" solref="-100000 -140"/><body pos="0 0 1.1">
<joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.1" mass="1" solref="-100000 -140"/></body>
</worldbody></mujoco>""",
}
"""The brick on its incline, and a ball on a spring of 1e5 /s² with a damper of 140 /s, which alone has e = 0.49."""


def steps() -> list[bool]:
    """Return what was missed by Moreau's steps, beside runs by events and MuJoCo's; all errors are printed."""
    missed, until = [], {"brick": 2.0, "ball": 1.2}
    halved = (DATA / "scenes" / "ball.toml").read_text(encoding="utf-8").replace('"0.8"', '"0.5"')
    scenes = {"brick": symdyn.read(DATA / "scenes" / "brick.toml"), "ball": symdyn.scene.read_text(halved)}
    for name, scene in scenes.items():
        told_by, end = "x" if name == "brick" else "z", until[name]
        exact = float(symdyn.simulate(scene, until=end, method="taylor", rtol=1e-13)[told_by][-1])

        methods = ("dop853", "moreau:1e-2", "moreau:1e-3", "moreau:1e-4")
        rows = {method: timed(partial(end_missed, scene, told_by, end, exact, method)) for method in methods}
        if find_spec("mujoco") is not None:
            for step in (2e-3, 1e-4):
                rows[f"MuJoCo {step:g}"] = timed(beside_mujoco(name, step, end, exact))
        for method, (off, seconds) in rows.items():
            print(f"{name} by {method}: at t = {end:g} s {off:.1e} m off in {1e3 * seconds:.1f} ms")
    brick, errors = scenes["brick"], []
    for step in (0.01, 0.005, 0.0025):
        off = []
        for phase in (np.arange(16) + 0.5) / 16:
            start = {"y": 9.81 * np.cos(0.3) * (0.2 + phase * step) ** 2 / 2}
            pair = [symdyn.simulate(brick, until=0.6, every=0.3, start=start, method=method)["x"][-1]
                    for method in ("dop853", f"moreau:{step}")]  # fmt: skip
            off.append(pair[1] - pair[0])
        errors.append(float(np.sqrt(np.mean(np.square(off)))))
    for coarse, fine in pairwise(errors):
        order = np.log2(coarse / fine)
        missed.append(told(f"brick thrown on its incline, order {order:.3f}, off 1 by", abs(order - 1), 0.1, ""))
    return missed


if __name__ == "__main__":
    sys.exit(any([*ball(), *references(), *laws(), *gaits(), *steps()]))
