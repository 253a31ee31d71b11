"""What doors return is kept: it says itself in a few lines, and goes to other processes."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.verify import Certificate, Fields

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long(0)]

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    """What doors return."""
    scene = symdyn.example("cart_pole")
    found: dict[str, Any] = {"scene": scene, "equations": symdyn.equations(scene)}
    found["sympy"] = found["equations"].sympy()
    found["derived"] = symdyn.dynamics.derive(scene, ["mass_matrix"])
    found["program"] = symdyn.program.lower(found["derived"])
    found["loaded"] = symdyn.load(scene, ["mass_matrix"])
    found["function"] = symdyn.lambdify(scene, "mass_matrix")
    found["run"] = symdyn.simulate(scene, until=0.02)
    found["closed"] = symdyn.closed_form(scene)
    found["sensitivity"] = symdyn.sensitivity(scene, until=0.1)
    found["gait"] = symdyn.gait(symdyn.example("pendulum"), section="q1", start="q1=0.3")
    q = np.linspace(0, 1, 9)
    found["calibration"] = symdyn.calibrate(scene, {"x": q, "theta": q * q, "tip.y": np.cos(q * q)}, "tip")
    found["linear"] = symdyn.linearize(scene)
    found["certificate"] = Certificate("cart_pole", Fields(1, (7,), 1), (), (), ())
    found["collocation"] = symdyn.collocation(scene, until=1, cost="F**2", intervals=4)
    return found


def test_a_terminal_shows_a_few_lines(kept: dict[str, Any]) -> None:
    for name, noun in kept.items():
        shown = repr(noun)
        assert shown.startswith("<"), name
        assert len(shown.splitlines()) <= 5, shown
        assert len(shown) <= 500, shown


def test_two_of_a_kind_are_compared_without_a_fault(kept: dict[str, Any]) -> None:
    """Those that hold arrays are themselves alone."""
    for name, noun in kept.items():
        assert noun == noun, name  # noqa: PLR0124
        assert (noun == pickle.loads(pickle.dumps(noun))) in (True, False), name


def test_no_list_is_long() -> None:
    arm = symdyn.example("arm7")
    names = [f"{name}:{body.name}" for name in ("pose", "jacobian", "com_acceleration") for body in arm.bodies]
    for noun in (
        arm,
        symdyn.equations(symdyn.example("puma560")).sympy(),
        symdyn.dynamics.derive(arm, names),
        symdyn.program.lower(symdyn.dynamics.derive(arm, names)),
    ):
        assert len(repr(noun)) <= 500
    assert "(21 in all)" in repr(symdyn.dynamics.derive(arm, names))


READ = "import pickle, sys; print([repr(one) for one in pickle.load(sys.stdin.buffer)])"


def test_another_process_has_the_same(kept: dict[str, Any]) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "-c", READ]
    told = subprocess.run(
        words, input=pickle.dumps(list(kept.values())), env=environment, capture_output=True, check=False
    )

    assert told.returncode == 0, told.stderr.decode()
    assert told.stdout.decode().strip() == str([repr(one) for one in kept.values()])
