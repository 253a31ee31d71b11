"""The stated 95 % intervals of identification hold the truth as often as they say, over seeds that nobody picked."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom
from simulated_logs import ARMS, coverage

from symdyn.identification import identify

pytestmark = pytest.mark.runs("cc")


@pytest.mark.slow
@pytest.mark.long
def test_intervals_of_a_plane_arm_hold_the_truth() -> None:
    found = coverage(ARMS["two_link"], 20)

    chance = binom.ppf([1e-4, 1 - 1e-4], 20, 0.95)
    assert np.all(found.held >= chance[0])
    assert binom.ppf(1e-3, 200, 0.95) <= found.held.sum() * 200 / (20 * len(found.held)), "too narrow"
    assert found.joint >= chance[0]
    assert 0.8 < found.ratio < 1.2, "too narrow or too wide"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["puma560", "arm7"])
def test_intervals_of_a_spatial_arm_hold_the_truth(name: str) -> None:
    found = coverage(ARMS[name], 100)

    assert 90 * len(found.held) <= found.held.sum() <= 99 * len(found.held)
    assert np.all(found.held >= binom.ppf(1e-4, 100, 0.95))
    assert 0.95 < found.ratio < 1.05
    assert 90 <= found.joint <= 99


def test_a_log_of_a_seed_is_the_same_every_time() -> None:
    arm = ARMS["two_link"]

    first, second = arm.log(3), arm.log(3)

    assert all(np.array_equal(first[name], second[name]) for name in first)
    assert not np.array_equal(first["M1"], arm.log(4)["M1"])


def test_intervals_are_wider_where_torques_are_noisier() -> None:
    arm = ARMS["two_link"]
    log = arm.log(0)
    noise = np.random.default_rng(5).normal(size=(2, len(log["t"])))
    worse = log | {"M1": log["M1"] + 2 * noise[0], "M2": log["M2"] + 1 * noise[1]}

    clear, noisy = (identify(arm.scene, one, friction=["viscous", "coulomb"]) for one in (log, worse))

    assert np.all(noisy.errors > 2 * clear.errors)
