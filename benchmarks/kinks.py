"""What it brings that integrators begin anew where equations bend: error and evaluations of one run, with and without.

    python benchmarks/kinks.py        prints a table; ends with 1 where DOP853 or Radau gain no two digits

A mass flies freely at 1 m/s between two walls, springs of 1e4 N/m that begin at x = -1 and 1. A flight takes 2 s and
a stay in a wall pi/100 s, so that its place is known. Without bends, steps go across where a wall begins. Multistep
methods gain nothing: they begin anew at order one.
"""

from __future__ import annotations

import sys
from math import pi, sin, sqrt
from unittest.mock import patch

import symdyn
from symdyn.scene import Scene, read_text
from symdyn.simulation.equations import written
from symdyn.table import Table

WALL, UNTIL, RTOL = 1e4, 50.0, 1e-8
SCENE = """
name = "{name}"
units = "none"
[bodies.bob]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "bob"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "{force}"
start_rates = [1]
"""
SPELLED = {
    "abs": f"{WALL / 2}*(abs(x + 1) - abs(x - 1) - 2*x)",
    "max": f"{WALL}*(max(-1 - x, 0) - max(x - 1, 0))",
}
METHODS, BAR = ("rk45", "dop853", "radau", "lsoda"), ("dop853", "radau")


def place(t: float) -> float:
    """Return x at a time, m, of a flight that begins at zero with 1 m/s."""
    w, stay = sqrt(WALL), pi / sqrt(WALL)
    count, t = divmod(t + 1, 2 + stay)
    x = t - 1 if t < 2 else 1 + sin(w * (t - 2)) / w
    return x * (-1) ** int(count)


def ran(scene: Scene, method: str) -> tuple[float, int]:
    """Return the error of x at the end, m, and how often rates were evaluated."""
    run = symdyn.simulate(scene, until=UNTIL, every=UNTIL, method=method, rtol=RTOL)  # type: ignore[arg-type]
    return abs(run["x"][-1] - place(UNTIL)), run.evaluations


def main() -> int:
    """Print the table; return 1 where a method of high order gains less than two digits at one kind of kink."""
    rows, gained = [], dict.fromkeys(BAR, 0.0)
    for name, force in SPELLED.items():
        for method in METHODS:
            told = ran(read_text(SCENE.format(name=f"{name}_told", force=force)), method)
            with patch.object(written, "_bends", lambda *_: []):
                untold = ran(read_text(SCENE.format(name=f"{name}_untold", force=force)), method)
            if method in BAR:
                gained[method] = max(gained[method], untold[0] / told[0])
            rows.append((name, method, f"{untold[0]:.1e}", str(untold[1]), f"{told[0]:.1e}", str(told[1])))
    heads = ("kink of", "method", "error across, m", "evaluations", "error begun anew, m", "evaluations")
    print(Table(heads, rows, title=f"A flight between two walls, {UNTIL:g} s, rtol {RTOL:g}").text())
    return int(min(gained.values()) < 100)


if __name__ == "__main__":
    sys.exit(main())
