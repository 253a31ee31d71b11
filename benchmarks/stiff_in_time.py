"""What exact derivatives are worth to implicit methods: `python benchmarks/stiff_in_time.py`.

Each motion is integrated with derivatives that are differences, exact ones, and those that `simulate` takes (the first
few of a run differences, exact if it is a longer one; of IDA exact ones). Printed are evaluations of the equations
(those of differences included), derivatives, and the processor time of a run, ms, as median of rounds in which the
three take turns once all is compiled; then what deriving and compiling the exact derivative took, by the clock, s.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
import unittest.mock
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import symdyn
from symdyn.scene import read_text
from symdyn.simulation.equations import implicit
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import stepwise

EXAMPLES = Path(__file__).parent.parent / "examples"

SPRINGS = """
name = "stiff_springs"
gravity = [0, 0, 0]
[bodies.a]
mass = 1
[bodies.b]
mass = 0.01
[joints.slow]
type = "prismatic"
parent = "ground"
child = "a"
coordinate = "x"
start = 0.5
force = "-10*x"
[joints.fast]
type = "prismatic"
parent = "a"
child = "b"
coordinate = "y"
start = 0.01
force = "-1e6*y - 1e4*y_dot - 1e8*y**3"
"""

CONTACT = """
name = "contact_like"
units = "none"
[bodies.ball]
mass = 1
inertia = [0.01, 0.01, 0.01]
inertia_about = "com"
[joints.height]
type = "prismatic"
parent = "ground"
child = "ball"
coordinate = "z"
start = 0.02
force = "1e-3*exp(-z/1e-3)*1e4*(1 - 0.5*tanh(z_dot))"
"""

CASES = (  # scene, method, forces, s, where it starts if not as declared
    (SPRINGS, "radau", "", 10.0, {}),
    (SPRINGS, "cvode", "", 10.0, {}),
    (CONTACT, "radau", "", 2.0, {}),
    (CONTACT, "cvode", "", 2.0, {}),
    ("cart_pole", "radau", "F=-5*tanh(x_dot/1e-4) + 8*sin(t)", 4.0, {"theta": "0.5"}),
    ("cart_pole", "bdf", "F=-5*tanh(x_dot/1e-4) + 8*sin(t)", 4.0, {"theta": "0.5"}),
    ("cart_pole", "cvode", "F=-5*tanh(x_dot/1e-4) + 8*sin(t)", 4.0, {"theta": "0.5"}),
    ("four_bar", "ida", "", 5.0, {}),
    ("four_bar", "radau", "", 5.0, {}),
    ("rolling_disc", "ida", "", 2.0, {}),
    ("rolling_disc", "radau", "", 2.0, {}),
    ("arm7", "radau", "", 0.5, {"q2": "0.5"}),
)


def main() -> None:
    """Print a line a case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SYMDYN_CACHE_DIR"] = folder
        print(f"{'':24}{'differences':>22}{'exact':>22}{'as simulate does':>22}{'exact: before':>15}")
        print(f"{'scene':16}{'method':8}" + 3 * f"{'f':>8}{'J':>6}{'ms':>8}" + f"{'s':>15}")
        for source, method, forces, until, start in CASES:
            scene = read_text(source) if "\n" in source else symdyn.read(EXAMPLES / f"{source}.toml")
            run = _run(scene, method, forces, until, start)
            cells, spent = _measured(run, rounds)
            words = "".join(f"{f:8d}{J:6d}{1e3 * t:8.1f}" for f, J, t in cells)
            print(f"{scene.name:16}{method:8}{words}{spent:15.2f}", flush=True)


def _run(scene: Any, method: str, forces: str, until: float, start: dict[str, str]) -> Callable[[float], Any]:
    given = read_start(scene, start)
    return lambda end: symdyn.simulate(
        scene, forces=forces or {}, until=end * until, start=given, method=method, every=end * until
    )


def _measured(run: Callable[[float], Any], rounds: int) -> tuple[list[tuple[int, int, float]], float]:
    """Return evaluations, derivatives and s of the three ways, and s that exact derivatives took to be made."""
    spent: list[list[float]] = [[], [], []]
    with _as("differences"):
        run(1e-6), run(1e-6)
    with _as("exact"):
        begun = time.perf_counter()
        run(1e-6)
        before = time.perf_counter() - begun
    counts = []
    for way in WAYS:
        with _as(way) as numbers:
            run(1.0)
        counts.append(numbers)
    for _ in range(rounds):
        for way, times in zip(WAYS, spent, strict=True):
            with _as(way, counted=False):
                begun = time.process_time()
                run(1.0)
                times.append(time.process_time() - begun)
    return [(one["f"], one["J"], statistics.median(t)) for one, t in zip(counts, spent, strict=True)], before


WAYS = ("differences", "exact", "as it is")


@contextmanager
def _as(way: str, counted: bool = True) -> Iterator[dict[str, int]]:
    """Let runs take derivatives so, and count evaluations of the equations and derivatives that are asked for."""
    numbers = {"f": 0, "J": 0}
    few = {"differences": 10**9, "exact": 0}.get(way, implicit.FEW)
    patch = unittest.mock.patch.object

    def counting(call: Callable[..., Any], key: str) -> Callable[..., Any]:
        def found(*args: Any) -> Any:
            numbers[key] += 1
            return call(*args)

        return found

    def by_differences(one: Any, t: float, y: Any, rates: Any, c: float) -> Any:
        columns = []
        for k, direction in enumerate(np.eye(one.size)):
            step = implicit.RELATIVE * max(1.0, abs(y[k])) * direction
            pair = [one.residual(t, y + s * step, rates + s * c * step) for s in (1, -1)]
            columns.append((pair[0] - pair[1]) / (2 * step[k]))
        return np.array(columns).T

    multiplied = by_differences if way == "differences" else implicit.Implicit.slope
    with ExitStack() as stack:
        enter = stack.enter_context
        enter(patch(implicit, "FEW", few))
        enter(patch(implicit.Implicit, "slope", counting(multiplied, "J") if counted else multiplied))
        if counted:
            enter(patch(StateEquations, "rates", counting(StateEquations.rates, "f")))
            enter(patch(implicit.Implicit, "residual", counting(implicit.Implicit.residual, "f")))
            make = implicit.slopes_in_turn
            enter(patch(stepwise, "slopes_in_turn", lambda system: counting(make(system), "J")))
        yield numbers


if __name__ == "__main__":
    main()
