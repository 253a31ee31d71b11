"""Closed mechanisms in time: Taylor's method with projection against DOP853, and the other methods beside them.

    python benchmarks/closed_in_time.py [rounds] [scene ...]

Every closed example, and Andrews' squeezer, as it is and with a spring a hundred times as stiff. Each method has its
own default tolerance, which a user gets who says none; Taylor's at 1e-13 and DOP853 at 1e-12 and 1e-13 besides. Times
are processor time, medians of interleaved rounds: until the first step (Taylor's is compiled in them), and from there
on. Errors are those of the end, coordinates over their size or 1, against Taylor's method at 1e-15; how far DOP853 at
1e-13 is from that is told beside the scene, as a bound of what the reference is worth. Motions in more digits than
doubles have are in tests/data/closed_in_time.json.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

import numpy as np

from symdyn.scene import Scene, bind, read
from symdyn.simulation import METHODS, Trajectory, simulate

HERE = Path(__file__).parent
EXAMPLES, DATA = HERE.parent / "examples", HERE / "data"

ROWS: dict[str, tuple[Path, dict[str, str], list[str], dict[str, str], float]] = {
    "four_bar": (EXAMPLES / "four_bar.toml", {}, [], {}, 5.0),
    "slider_crank": (EXAMPLES / "slider_crank.toml", {}, [], {"phi": "6"}, 5.0),
    "governor": (EXAMPLES / "governor.toml", {}, [], {}, 5.0),
    "spatial_slider_crank": (EXAMPLES / "spatial_slider_crank.toml", {}, [], {"phi": "5"}, 5.0),
    "rssr": (EXAMPLES / "rssr.toml", {}, [], {"phi": "3"}, 5.0),
    "rsup": (EXAMPLES / "rsup.toml", {}, [], {"phi": "3"}, 5.0),
    "rolling_disc": (EXAMPLES / "rolling_disc.toml", {}, [], {}, 5.0),
    "cart_with_wheel": (EXAMPLES / "cart_with_wheel.toml", {}, ["T=0.5*cos(2*t)-0.1*x"], {}, 5.0),
    "squeezer": (DATA / "squeezer.toml", {}, ["mom=0.033"], {}, 0.03),
    "squeezer, ten times as long": (DATA / "squeezer.toml", {}, ["mom=0.033"], {}, 0.3),
    "squeezer, spring 100 times as stiff": (DATA / "squeezer.toml", {"c": "453000"}, ["mom=0.033"], {}, 0.03),
}

TRIED: tuple[tuple[str, float | None], ...] = (
    ("taylor", None),
    ("taylor", 1e-13),
    ("dop853", None),
    ("dop853", 1e-12),
    ("dop853", 1e-13),
    ("radau", None),
    ("cvode", None),
    ("ida", None),
)


def main(rounds: int, wanted: Sequence[str] = ()) -> None:
    """Print a table a scene."""
    for name, (path, parameters, forces, rates, until) in ROWS.items():
        if wanted and name not in wanted:
            continue
        scene = bind(read(path), parameters) if parameters else read(path)

        def run(
            method: str,
            rtol: float | None,
            scene: Scene = scene,
            forces: list[str] = forces,
            rates: dict[str, str] = rates,
            until: float = until,
        ) -> tuple[Trajectory, float, float]:
            begin = time.process_time()
            first: list[float] = []
            found = simulate(
                scene, forces=forces, until=until, start=None, start_rates=rates, method=method, rtol=rtol,
                progress=lambda _: first or first.append(time.process_time()), say=lambda _: None,
            )  # fmt: skip
            return found, first[0] - begin, time.process_time() - first[0]

        known = run("taylor", 1e-15)[0].q[-1]
        scale = np.maximum(1.0, np.abs(known))
        sure = float(np.max(np.abs(run("dop853", 1e-13)[0].q[-1] - known) / scale))
        print(f"\n{name}, {until:g} s; the reference holds to {sure:.1e}\n")
        print("| method | prepare, s | integrate, s | steps | error at the end | energy, part | loops |")
        print("|---|--:|--:|--:|--:|--:|--:|")
        times: dict[tuple[str, float | None], list[tuple[float, float]]] = {one: [] for one in TRIED}
        last = {}
        for _ in range(rounds):
            for one in TRIED:
                found, preparing, integrating = run(*one)
                times[one].append((preparing, integrating))
                last[one] = found
        for (method, rtol), found in last.items():
            taken = times[method, rtol]
            off = float(np.max(np.abs(found.q[-1] - known) / scale)) if found.complete else float("nan")
            drift = found.monitors["energy"] / max(found.monitors["energy_scale"], 1e-300)
            print(
                f"| {method}, {rtol or METHODS[method].rtol:.0e} | {median(a for a, _ in taken):.2f} "
                f"| {median(b for _, b in taken):.3f} | {found.steps} | {off:.1e} | {drift:.1e} "
                f"| {found.monitors.get('loops', 0.0):.0e} |",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5, sys.argv[2:])
