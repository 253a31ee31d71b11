"""Collocation through impacts with restitution and friction, beside runs under the forces that it finds."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

THROWN = """
name = "thrown"
gravity = [0, 0, "-9.81"]
[bodies.a]
[bodies.c]
[bodies.b]
mass = 2
inertia = [0.01, 0.02, 0.01]
inertia_about = "com"
[joints.x]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
drive = false
[joints.z]
type = "prismatic"
parent = "a"
child = "c"
axis = [0, 0, 1]
coordinate = "z"
drive = "F"
start = 1
[joints.t]
type = "revolute"
parent = "c"
child = "b"
axis = [0, 1, 0]
coordinate = "phi"
drive = false
[contacts.floor]
body = "b"
restitution = 0.6
"""

BALL, ROD = 'type = "ball"\nradius = 0.1\n', "at = [0.1, 0, -0.2]\n"


@pytest.mark.targets  # IPOPT comes with CasADi
@pytest.mark.parametrize(
    ("more", "spin", "leaves"),
    [
        pytest.param(f"{BALL}friction = 0.1", 40, -1, id="a ball slips on"),
        pytest.param(f'{BALL}friction = 0.1\nlaw = "newton"', 40, -1, id="by Newton's law alike"),
        pytest.param(f'{BALL}friction = 0.9\nlaw = "newton"', 40, 0, id="a ball comes to rest along the floor"),
        pytest.param(f"{ROD}friction = 0.05", 0, 1, id="a point beside the centre of mass"),
    ],
)
def test_what_bounces_with_friction_does_so_in_a_run_under_the_forces(more: str, spin: float, leaves: float) -> None:
    scene = read_text(THROWN + more)
    start = {"x_dot": 1, "z_dot": 0, "phi_dot": spin}
    phases = [{"duration": 0.4}, {"strikes": {"floor": leaves}}]
    found = symdyn.collocation(scene, 0.8, 12, cost="F**2", start_rates=start, end={"z": 0.5}, phases=phases).solve()
    run = found.simulated(rtol=1e-10)

    assert [one.what for one in run.impacts] == ["strikes"]
    assert found.impacts[0].impulse == pytest.approx(run.impacts[0].impulse, rel=1e-7)
    assert np.abs(found.impacts[0].impulse[1]) > 0.1
    assert found.run.q[-1] == pytest.approx(run.q[-1], abs=1e-7)


@pytest.mark.parametrize(
    ("more", "strikes", "words"),
    [
        ("friction = 0.1", "floor", 'floor bounces with friction: say how it leaves: strikes = {"floor": 1} where its'),
        (
            "friction = 0.1",
            {"floor": 2},
            'phases: 2: strikes = {"floor": 1} where its slip is above zero behind, -1 below',
        ),
        ("friction = 0.1", {"floor": 0}, 'floor rests along its plane behind: write law = "newton"'),
    ],
)
def test_a_bounce_with_friction_that_is_not_told_is_refused(more: str, strikes: object, words: str) -> None:
    with pytest.raises(SimulateError) as fault:
        symdyn.collocation(read_text(THROWN + more), 1, 4, cost="F**2", phases=[{}, {"strikes": strikes}])

    assert words in str(fault.value)
