"""What another value of a named parameter costs `symdyn.simulate`: `python benchmarks/another_value.py`.

Medians of processor time and of time by the clock, ms, over RUNS values after the first, of a motion so short (1 µs)
that only what comes before and behind it counts: the value itself (`bind`, which checks the scene again), what is
prepared from it, the start, and the columns that are told. A closed mechanism is given its start where it says so, and
else is assembled anew for each value.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import symdyn
from symdyn.scene import Scene, bind
from symdyn.simulation import Start
from symdyn.simulation.initial import read_start

EXAMPLES = Path(__file__).parent.parent / "examples"

RUNS, SHORT = 15, 1e-6

CASES = (  # scene, a parameter that leaves the start where it is, method
    ("pendulum", "l", "taylor"),
    ("double_pendulum", "l1", "taylor"),
    ("double_pendulum", "l1", "dop853"),
    ("cart_pole", "mp", "dop853"),
    ("cart_pole", "mp", "cvode"),
    ("heavy_top", "m", "taylor"),
    ("four_bar", "m2", "taylor"),
    ("four_bar", "m2", "ida"),
    ("rolling_disc", "m", "dop853"),
    ("governor", "k", "dop853"),
)


def main() -> None:
    """Print a line a case."""
    print(f"{'scene':16} {'method':8} {'start':10} {'value, ms':>10} {'simulate, ms':>13} {'by the clock':>13}")
    for name, parameter, method in CASES:
        scene = symdyn.read(EXAMPLES / f"{name}.toml")
        if parameter not in [one.name for one in scene.parameters]:
            continue
        starts: dict[str, Start | None] = {"assembled" if scene.is_constrained else "read": None}
        if scene.is_constrained:
            starts["given"] = read_start(scene)
        for place, (words, start) in enumerate(starts.items()):
            print(f"{name:16} {method:8} {words:10}", *_measured(scene, parameter, method, start, place))


def _measured(scene: Scene, parameter: str, method: str, start: Start | None, place: int) -> tuple[str, str, str]:
    (value,) = (float(one.value.value) for one in scene.parameters if one.name == parameter)  # type: ignore[arg-type, union-attr]

    def run(one: Scene) -> object:
        return symdyn.simulate(one, until=SHORT, every=SHORT, method=method, start=start)

    run(scene)
    run(bind(scene, {parameter: f"{0.999 * value:.12f}"}))
    spent = []
    for k in range(RUNS):
        text = f"{value * (1 + (k + RUNS * place) / 1000):.12f}"
        bound, *binding = _timed(lambda text=text: bind(scene, {parameter: text}))  # type: ignore[misc]
        _, *running = _timed(lambda bound=bound: run(bound))  # type: ignore[misc]
        spent.append((binding[0], *running))
    value_ms, run_ms, clock_ms = (1000 * statistics.median(one) for one in zip(*spent, strict=True))
    return f"{value_ms:10.2f}", f"{run_ms:13.2f}", f"{clock_ms:13.2f}"


def _timed(call: Callable[[], Scene]) -> tuple[Scene, float, float]:
    """Return a result, its processor time and its time by the clock, s."""
    spent, clock = time.process_time(), time.perf_counter()
    found = call()
    return found, time.process_time() - spent, time.perf_counter() - clock


if __name__ == "__main__":
    main()
