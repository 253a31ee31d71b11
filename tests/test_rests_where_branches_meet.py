"""Where a mechanism rests though rows of its loops depend on each other: a governor that hangs down."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.linear import linearize_at_rest
from symdyn.scene import read_text

GOVERNOR = Path(__file__).parent.parent / "examples" / "governor.toml"


def governor_energy(alpha: float, beta: float, s: float) -> float:
    """Return the potential energy of the governor, J."""
    length, ball, arm, sleeve, k, s0, g = 0.15, 0.8, 0.1, 1.5, 400, 0.29, 9.81
    arms = (2 * length * ball + length * arm) * g * (math.cos(alpha) + math.cos(beta))
    return sleeve * g * s - arms + k / 2 * (s + s0) ** 2


@pytest.mark.mends("30.lessons.1.5")
@pytest.mark.mends("30.class.optimum")
def test_a_governor_is_said_to_rest_where_it_hangs_down(capsys: pytest.CaptureFixture[str]) -> None:
    main(["linearize", str(GOVERNOR), "--start", "rest"])
    told = capsys.readouterr().err
    assert "200 seeded starts of Newton's method" in told
    assert "alpha = 0 rad, beta = 0 rad, s = -0.3 m" in told
    assert "no position of rest" not in told


@pytest.mark.long(0)
@pytest.mark.mends("30.lessons.1.5")
@pytest.mark.mends("30.class.optimum")
def test_its_lesson_does_not_say_that_it_rests_nowhere(tmp_path: Path) -> None:
    page = tmp_path / "governor.md"
    assert main(["walkthrough", str(GOVERNOR), "-o", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "None was found" not in text
    assert "| 0 rad | 0 rad | −0.3 m |" in text


def beside(place: tuple[float, float, float], a: float, b: float) -> list[tuple[float, float, float]]:
    """Return places next to one on every branch through it: s = 0 with any α and β, or s = -2 l cos α with α = ± β."""
    alpha, beta, s = place
    if abs(s) < 1e-6:
        return [(alpha + a, beta + b, 0.0)]
    return [(alpha + a, beta + way * a, -0.3 * math.cos(alpha + a)) for way in (1, -1)]


def test_the_energy_stays_along_both_branches_that_meet_there() -> None:
    """An independent account of each place that is told."""
    _, found = linearize_at_rest(symdyn.read(GOVERNOR))
    assert not found.places
    assert len(found.crossings) == 5
    for crossing in found.crossings:
        place = tuple(crossing.q[1:].tolist())
        assert np.allclose(beside(place, 0.0, 0.0), place, atol=1e-6)
        for a, b in ((1e-5, 0.0), (0.0, 1e-5)):
            for ahead, behind in zip(beside(place, a, b), beside(place, -a, -b), strict=True):
                assert abs(governor_energy(*ahead) - governor_energy(*behind)) / 2e-5 < 1e-6


PARALLELOGRAM = """
name = "parallelogram"
gravity = [0, -9.81, 0]
[joints]
a = { type = "revolute", parent = "ground", child = "left", start = 1, drive = false }
b = { type = "revolute", parent = "left", child = "coupler", origin = [1, 0, 0], start = -1, drive = false }
c = { type = "revolute", parent = "ground", child = "right", origin = [2, 0, 0], start = 1, drive = false }
[[loop]]
name = "close"
type = "revolute"
parent = "coupler"
child = "right"
origin = [2, 0, 0]
tip = [-1, 0, 0]
"""


def test_where_a_parallelogram_is_flat_branches_meet_but_its_weight_moves_it() -> None:
    bodies = "".join(
        f'[bodies.{name}]\nmass = {mass}\ncom = [{at}, 0, 0]\ninertia = [0, 0.2, 0.2]\ninertia_about = "com"\n'
        for name, mass, at in (("left", 1, 0.5), ("coupler", 2, 1), ("right", 1, 0.5))
    )
    systems, found = linearize_at_rest(read_text(PARALLELOGRAM + bodies))
    assert not found.crossings
    upright = [one for one in systems if np.allclose(np.abs(one.point.q), math.pi / 2, atol=1e-9)]
    assert len(upright) == 2
