"""Linear motions in a mode of contacts: closed forms, differences of the equations of the mode, and of runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import LinearizeError
from symdyn.scene import read_text
from symdyn.simulation import Start

pytestmark = pytest.mark.runs("cc")

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"

ROD = symdyn.read(SCENES / "falling_rod_0.36.toml")


def slopes(f: Callable[[np.ndarray], np.ndarray], x: np.ndarray, h: float = 1e-3) -> np.ndarray:
    ways = h * np.eye(len(x))
    return np.array([(8 * (f(x + e) - f(x - e)) - (f(x + 2 * e) - f(x - 2 * e))) / (12 * h) for e in ways]).T


@pytest.mark.parametrize(("word", "z"), [("slip+", 1.0), ("slip-", -1.0)])
def test_a_rod_that_slips_is_that_of_the_equations_of_its_mode(word: str, z: float) -> None:
    """The states are x and y; the angle follows from the height."""
    dynamics = symdyn.load(ROD, ["contact_dynamics"]).contact_dynamics

    def state(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        theta = np.arccos(2 * x[1])
        return np.array([x[0], x[1], theta]), np.array([x[2], x[3], -2 * x[3] / np.sin(theta)])

    def rates(x: np.ndarray) -> np.ndarray:
        a = dynamics(*state(x), np.zeros(3), np.ones(1), np.array([z]))
        return np.array([x[2], x[3], a[0], a[1]])

    x = np.array([0.1, 0.5 * np.cos(0.6), 0.7 * z, -0.4])
    found = symdyn.linearize(ROD, mode={"foot": word}, start=Start(*state(x)), anywhere=True)

    assert found.states.names == ("x", "y", "x_dot", "y_dot")
    np.testing.assert_allclose(found.A, slopes(rates, x), atol=1e-7)


HANGING = """
gravity = [0, 0, -9.81]
[bodies.a]
mass = 2
[bodies.b]
mass = 1
com = [0, 0, -0.5]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
friction = { coulomb = 5 }
[joints.hinge]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 1, 0]
coordinate = "h"
limits = { upper = 0.2, restitution = 0.5 }
"""


def test_dry_friction_that_sticks_leaves_a_pendulum_and_one_that_slips_a_force() -> None:
    scene = read_text(HANGING)
    stuck = symdyn.linearize(scene, mode={"slide_friction": "stick"})
    slips = symdyn.linearize(scene, mode={"slide_friction": "slip-"}, forces="F=-5")

    assert stuck.states.names == ("x", "h", "h_dot")
    np.testing.assert_allclose(stuck.A[2], [0, -9.81 / 0.5, 0], atol=1e-12)
    np.testing.assert_allclose(stuck.B, [[0, 0], [0, 0], [0, 4]], atol=1e-12)
    assert slips.kind == "rest"  # the force is its friction
    np.testing.assert_allclose(slips.poles.imag.max(), np.sqrt(9.81 / 0.5 * 1.5))


def test_a_mode_is_the_motion_of_a_run_in_it() -> None:
    """A rod whose foot sticks: over a tenth of a second, from states next to each other."""
    stuck = symdyn.linearize(ROD, mode={"foot": "stick"}, anywhere=True)

    def end(step: float) -> np.ndarray:
        theta = 0.05 + step
        start = Start(np.array([-0.5 * np.sin(theta), 0.5 * np.cos(theta), theta]), np.zeros(3))
        run = symdyn.simulate(ROD, start=start, until=1e-3, every=1e-3, rtol=1e-13)
        return np.array([run["theta"][-1], run["x_dot"][-1]])

    moved = (8 * (end(1e-3) - end(-1e-3)) - (end(2e-3) - end(-2e-3))) / 12e-3
    row = [stuck.states.names.index(name) for name in ("theta", "x_dot")]
    by_mode = stuck.discretize(1e-3).A[row, row[0]]
    np.testing.assert_allclose(by_mode[1], moved[1], rtol=1e-4)  # A is that of the beginning: x_dot = -9.81*1.5/2*t
    assert by_mode[0] == pytest.approx(moved[0], abs=1e-6)


@pytest.mark.parametrize(
    ("mode", "start", "words"),
    [
        ({"foot": "sticks"}, None, "foot cannot be 'sticks'; did you mean stick"),
        ({"feet": "stick"}, None, "there is no contact feet; there are foot"),
        (
            {"foot": "stick"},
            Start(np.array([0, 1.0, 0]), np.zeros(3)),
            "foot is not held at this point: its gap is 0.5",
        ),
        ({"foot": "stick"}, Start(np.array([0, 0.5, 0]), np.array([0, 1.0, 0])), "velocities along its row 1"),
    ],
)
def test_a_mode_that_there_is_not_is_told(mode: dict[str, str], start: Any, words: str) -> None:
    with pytest.raises(LinearizeError, match=words):
        symdyn.linearize(ROD, mode=mode, start=start, anywhere=True)


def test_a_joint_with_dry_friction_has_no_open_mode() -> None:
    with pytest.raises(LinearizeError, match="slide_friction sticks or slips always: say stick, slip"):
        symdyn.linearize(read_text(HANGING), mode={"hinge_upper": "closed"})


def test_the_shell_tells_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    asked = [str(SCENES / "falling_rod_0.36.toml"), "--mode", "foot=stick", "--anywhere"]

    assert main(["linearize", *asked]) == 0
    assert "3.82881" in capsys.readouterr().out  # √(3 g cos θ / 2 l)
