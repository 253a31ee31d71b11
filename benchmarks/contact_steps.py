"""Error against time of runs through contacts: by events, by Moreau's steps, and by MuJoCo's, of two scenes.

    python benchmarks/contact_steps.py --docs docs

A brick slides down an incline, stops and rests; a ball bounces with half its velocity. Errors are those of the place at
the end, beside closed forms. Times are of a run from a scene that is loaded and compiled, the least of a
few. MuJoCo's contacts are soft: what it tends to with shorter steps is another motion, and its error says how far away.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from math import cos, sin
from pathlib import Path

import machine

import symdyn
from symdyn.bench.report import Dot, Series, log_log
from symdyn.table import Table

SCENES = Path(__file__).resolve().parent.parent / "tests" / "data" / "impacts" / "scenes"

BEGIN = "<!-- What follows, up to the next mark, is written by `python benchmarks/contact_steps.py --docs docs`. -->"
END = "<!-- Here contacts end. -->"

TIMED = 3
"""Runs of each kind, of which the fastest counts."""

COLUMN, UNTIL = {"brick": "x", "ball": "z"}, {"brick": 2.0, "ball": 1.2}

TITLES = {"brick": "A brick stops on an incline and rests, 2 s", "ball": "A ball bounces three times, 1.2 s"}

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

FALLS = (2 / 9.81) ** 0.5
"""s; then flights of FALLS, FALLS / 2 and FALLS / 4."""

EXACT = {
    "brick": 2.0**2 / (2 * 9.81 * (0.5 * cos(0.3) - sin(0.3))),
    "ball": 9.81 * FALLS / 8 * (1.2 - 2.5 * FALLS) - 9.81 / 2 * (1.2 - 2.5 * FALLS) ** 2,
}
"""Where they end, m."""

ELLIPTIC = '<mujoco><option cone="elliptic" impratio="100" '
"""MuJoCo's own advice against creeping."""

Run = Callable[[], float]
"""Returns what a run misses at its end, m."""


def scenes() -> dict[str, symdyn.Scene]:
    """Return the brick, and the ball with e = 0.5."""
    halved = (SCENES / "ball.toml").read_text(encoding="utf-8").replace('"0.8"', '"0.5"')
    return {"brick": symdyn.read(SCENES / "brick.toml"), "ball": symdyn.scene.read_text(halved)}


def ours(name: str, scene: symdyn.Scene) -> Iterator[tuple[str, str, Run]]:
    """Yield series, what is set, and a run, for each run of ours."""
    until, exact = UNTIL[name], EXACT[name]

    def end(**asked: object) -> float:
        return float(symdyn.simulate(scene, until=until, every=until / 2, **asked)[COLUMN[name]][-1])

    for method in ("taylor", "dop853"):
        for rtol in (1e-3, 1e-6, 1e-9, 1e-12):
            yield (
                f"by events, {method}",
                f"tolerance {rtol:g}",
                lambda m=method, r=rtol: abs(end(method=m, rtol=r) - exact),
            )
    for step in ("1e-2", "1e-3", "1e-4"):
        yield "Moreau's steps", f"{step} s", lambda s=step: abs(end(method=f"moreau:{s}") - exact)
    if find_spec("mujoco") is None:
        return
    texts = {"MuJoCo": MJCF[name]}
    if name == "brick":
        texts["MuJoCo, elliptic, impratio 100"] = MJCF[name].replace("<mujoco><option ", ELLIPTIC)
    for series, text in texts.items():
        for step in (5e-3, 2e-3, 5e-4, 1e-4, 2e-5):
            yield series, f"{step:g} s", by_mujoco(name, text, step)


def by_mujoco(name: str, text: str, step: float) -> Run:
    """Return a run by MuJoCo."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    data, count = mujoco.MjData(model), round(UNTIL[name] / step)

    def run() -> float:
        mujoco.mj_resetData(model, data)
        data.qvel[0] = 2.0 if name == "brick" else 0.0
        mujoco.mj_step(model, data, nstep=count)
        return abs(float(data.qpos[0]) + (name == "ball") - EXACT[name])

    return run


def timed(run: Run) -> tuple[float, float]:
    """Return what a run misses, m, and its time, s."""
    missed, times = run(), []
    for _ in range(TIMED):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
        if times[-1] > 2.0:
            break
    return missed, min(times)


def main() -> None:
    """Measure, print, and write pictures and table where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", type=Path, help="the folder of performance-of-runs.md")
    options, before, parts = parser.parse_args(), machine.load(), list[str]()
    for name, scene in scenes().items():
        dots, rows = dict[str, list[Dot]](), list[tuple[str, str, str, str]]()
        for series, told, run in ours(name, scene):
            missed, seconds = timed(run)
            dots.setdefault(series, []).append(Dot(seconds, missed, f"{series}, {told}: {missed:.1e} m"))
            rows.append((series, told, f"{1e3 * seconds:.1f}", f"{missed:.1e}"))
            print(f"{name:6}{series:32}{told:18}{1e3 * seconds:10.1f} ms{missed:10.1e} m", flush=True)
        plotted = [Series(series, tuple(some), joined=True) for series, some in dots.items()]
        picture = log_log(TITLES[name], "seconds", "error at the end, m", plotted)
        parts += [f"![{TITLES[name]}](performance/contacts_{name}.svg)", ""]
        parts += [Table(("", "steps or tolerance", "ms", "error, m"), rows, (2, 3)).markdown(str), ""]
        if options.docs:
            (options.docs / "performance" / f"contacts_{name}.svg").write_text(picture + "\n", "utf-8")
    about = machine.describe(before, [("MuJoCo", _mujoco())])
    facts = [about[group] for group in ("machine", "peers")]
    parts += [f"- {key}: {value}" for group in facts for key, value in group.items()]  # type: ignore[attr-defined]
    if options.docs:
        page = options.docs / "performance-of-runs.md"
        head, rest = page.read_text("utf-8").split(BEGIN)
        text = "\n".join(parts)
        page.write_text(f"{head}{BEGIN}\n\n{text}\n\n{END}{rest.split(END)[1]}", "utf-8")


def _mujoco() -> str:
    from importlib.metadata import PackageNotFoundError, version

    for name in ("mujoco", "mujoco-core"):
        try:
            return version(name)
        except PackageNotFoundError:
            continue
    return "not installed"


if __name__ == "__main__":
    main()
