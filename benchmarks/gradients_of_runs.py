"""What gradients of a run cost beside the run itself: `python benchmarks/gradients_of_runs.py`.

Runs of 1 s by DOP853 at 1e-12 and their gradients by both doors take turns once all is compiled; printed are medians of
processor time, ms, and of ratios inside rounds. Central differences take two runs a column.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import symdyn
from symdyn.simulation.initial import read_start

EXAMPLES = Path(__file__).parent.parent / "examples"

CASES = {"pendulum": {"q1": "1"}, "four_bar": {}, "rolling_disc": {}}  # scene, where it starts if not as declared

ROUNDS = 9


def main() -> None:
    """Print a row a scene."""
    print(f"{'scene':16}{'columns':>8}{'run, ms':>10}{'forward':>10}{'adjoint':>10}{'differences':>13}")
    for name, given in CASES.items():
        scene = symdyn.read(EXAMPLES / f"{name}.toml")
        start = read_start(scene, given)
        calls: list[Callable[[], object]] = [
            lambda scene=scene, start=start: symdyn.simulate(  # type: ignore[misc]
                scene, until=1.0, start=start, every=1.0, method="dop853", rtol=1e-12
            ),
            *(
                lambda scene=scene, start=start, by=by: symdyn.sensitivity(scene, until=1.0, start=start, by=by)  # type: ignore[misc]
                for by in ("forward", "adjoint")
            ),
        ]
        columns = len(symdyn.sensitivity(scene, until=1.0, start=start).columns)
        for call in calls:
            call()
        rounds = [[_timed(call) for call in calls] for _ in range(ROUNDS)]
        run, *ratios = (statistics.median(one) for one in zip(*((a, b / a, c / a) for a, b, c in rounds), strict=True))
        print(f"{name:16}{columns:8}{1e3 * run:10.1f}" + "".join(f"{x:10.2f}" for x in ratios) + f"{2 * columns:13}")


def _timed(call: Callable[[], object]) -> float:
    begun = time.process_time()
    call()
    return time.process_time() - begun


if __name__ == "__main__":
    main()
