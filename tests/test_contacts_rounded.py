"""Contacts where rounding tells what happens: far from the origin, and at jumps of forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

BALL = (Path(__file__).parent / "data" / "impacts" / "scenes" / "ball.toml").read_text(encoding="utf-8")
FALLS = (2 / 9.81) ** 0.5


def far(at: float) -> symdyn.Scene:
    """Return the ball that bounces, at a height of its floor."""
    return read_text(
        BALL.replace("start = 1", f"start = {at + 1}").replace("plane = {", f"plane = {{ at = [0, 0, {at}],")
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_ball_bounces_a_kilometre_up_and_rests(method: str) -> None:
    run = symdyn.simulate(far(1000), until=6, method=method)
    hits = np.array([one.t for one in run.impacts if one.what == "strikes"][:20])
    truth = [FALLS * (1 + 2 * sum(0.8**i for i in range(1, k + 1))) for k in range(20)]

    assert np.abs(hits - truth).max() < 1e-10
    assert abs((run.impacts[-1].rest or 0.0) - 9 * FALLS) < 1e-7
    assert (run["z"][-1], run["z_dot"][-1]) == (1000.0, 0.0)


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_what_rounding_of_a_place_says_nothing_of_ends_a_run_in_words(method: str) -> None:
    words = (
        r"the gap of floor is rounded to 2e-09 m there, and 1e-10 m tells what touches; "
        r"put the origin of the scene near its contacts"
    )

    with pytest.warns(RuntimeWarning, match=words):
        run = symdyn.simulate(far(1_000_000), until=2, method=method)

    assert run.t[-1] < FALLS


@pytest.mark.parametrize("at", [0.5, 0.6006621490201194])
def test_a_force_that_jumps_lifts_a_contact_off_once(at: float) -> None:
    """Its event was told by the force ahead of the jump, which closed the contact again, without end."""
    lifted = read_text(BALL.replace("drive = false\nstart = 1", 'drive = "F"'))
    run = symdyn.simulate(lifted, until=1, every=0.1, method="dop853", forces={"F": lambda t: 5.0 if t < at else 15.0})

    assert [one.what for one in run.impacts] == ["lifts off"]
    assert len(run.t) == 11
    assert run["z"][-1] == pytest.approx((15 - 9.81) * (1 - at) ** 2 / 2, abs=1e-13)
