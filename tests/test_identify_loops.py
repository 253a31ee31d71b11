"""Closed mechanisms in `identify`: all coordinates in the log, the rows of drives alone."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import IdentifyError
from symdyn.identification import identified
from symdyn.scene import bind

pytestmark = [pytest.mark.runs("cc")]

CASES = {"four_bar": {"m3": 4.5}, "slider_crank": {"m3": 0.6, "k": 36.0}}
"""What the mechanism that was measured has, and its scene has not."""


def log(name: str) -> dict[str, np.ndarray]:
    scene = bind(symdyn.example(name), CASES[name])
    run = symdyn.simulate(scene, forces="M=3*sin(4*t)+2*cos(1.3*t)", until=4, every=0.004)
    return {column: np.array(run[column]) for column in ("t", *scene.coordinates, "M")}


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_the_drive_of_a_loop_tells_masses_and_stiffness(name: str) -> None:
    found = symdyn.identify(symdyn.example(name), log(name))
    made = identified(found)

    assert [one.drive for one in found.fits] == ["M"]
    assert found.fits[0].percent < 2 < 100 * found.fits[0].before / found.fits[0].size
    for parameter, value in CASES[name].items():
        assert made.values[parameter] == pytest.approx(value, rel=0.02)


def test_a_coordinate_of_a_loop_that_was_not_measured_is_named() -> None:
    data = log("four_bar")
    del data["psi"]

    with pytest.raises(IdentifyError, match="has no column psi"):
        symdyn.identify(symdyn.example("four_bar"), data)
