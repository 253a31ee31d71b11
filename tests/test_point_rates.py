"""Velocities and accelerations of declared points: of trees, quaternions, loops and linear systems."""

from __future__ import annotations

from typing import Any

import pytest

import symdyn
from symdyn.errors import SimulateError
from symdyn.scene import Scene
from symdyn.scene.toml import read_text
from symdyn.scene.values import LETTERS

OUTPUTS = """
[points.eye]
body = "{}"
at = [0.2, 0.3, -0.5]
[outputs]
speed = "point_eye_x_dot"
push = "point_eye_x_ddot"
place = "point_eye_x"
"""

CASES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "a tree": ("cart_pole", "pole", {"forces": "F=cos(3*t)", "start": {"theta": 1}}),
    "a quaternion": ("free_body", "wingnut", {"start": {"flight_wx": 3, "flight_wz": 2, "flight_vy": 1}}),
    "a loop": ("four_bar", "coupler", {"forces": "M=20"}),
}


def seen(example: str, body: str) -> Scene:
    return read_text(symdyn.scene.write_text(symdyn.example(example), "toml").text + OUTPUTS.format(body))


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("example", "body", "given"), CASES.values(), ids=CASES)
def test_rates_of_a_point_are_those_of_its_place(example: str, body: str, given: dict[str, Any]) -> None:
    run = symdyn.simulate(seen(example, body), until=0.2, every=1e-3, method="dop853", **given)
    for place, rate in (("place", "speed"), ("speed", "push")):
        slope = (run[place][2:] - run[place][:-2]) / 2e-3
        assert slope == pytest.approx(run[rate][1:-1], abs=1e-4 * abs(run[rate]).max())


@pytest.mark.usefixtures("numpy_alone")
def test_two_formulations_agree_on_the_acceleration_of_a_point() -> None:
    scene = seen("cart_pole", "pole")
    assert symdyn.certify(scene, ["outputs"]).passed


def test_in_a_linear_system_rates_are_s_times_the_place() -> None:
    names = [f"point_eye_x{rate}" for rate in ("", "_dot", "_ddot")]
    system = symdyn.linearize(seen("cart_pole", "pole"), outputs=names).formulas
    place, speed, push = (system.transfer(name) for name in names)
    s = next(one for one in place.free_symbols if str(one) == "s")
    assert (speed / place).cancel() == s
    assert (push / speed).cancel() == s
    assert [LETTERS.point_unit(name) for name in names] == ["m", "m/s", "m/s^2"]


def test_the_rate_of_an_output_that_is_a_place_is_told_by_the_point() -> None:
    with pytest.raises(SimulateError, match="uses place_ddot, which is not known here; did you mean point_eye_x_ddot"):
        symdyn.linearize(seen("cart_pole", "pole"), outputs=["place_ddot"])
