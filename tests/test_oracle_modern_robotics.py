"""The three-link arm of Lynch and Park, Modern Robotics, chapter 8: published to 8 decimals, known to 30."""

from __future__ import annotations

import pytest
from arms import three_link
from oracles import BIG, assert_digits, flat, numbers, oracle
from running import call

from symdyn.dynamics import derive, formulations_of

ARM = oracle("modern_robotics_3link")
OURS, PUBLISHED = ARM["ours"], ARM["published"]
TURNS = [BIG.context.sqrt(2), BIG.number(1), BIG.number(1)]
"""Turn in rad for one unit of each published coordinate: the first axis is (1, 0, 1), not of length one."""


def turned(texts):
    """Return published coordinates, or their rates, in rad."""
    return [turn * value for turn, value in zip(TURNS, numbers(texts), strict=True)]


STATE = {key: turned(ARM["data"][key].split()) for key in ("q", "qd", "qdd")}


def evaluated(name, formulation=None, **more):
    """Return an output with respect to the published coordinates: each index that counts joints scales with TURNS."""
    found = call(derive(three_link(), [name], formulation), name.replace(":", "_"), BIG, **{**STATE, **more})
    if name == "mass_matrix":
        return [a * b * found[3 * i + j] for i, a in enumerate(TURNS) for j, b in enumerate(TURNS)]
    if name == "forward_dynamics":
        return [value / turn for turn, value in zip(TURNS, found, strict=True)]
    if name == "pose:tip":
        return found
    return [value * TURNS[k % 3] for k, value in enumerate(found)]  # forces, and rows of the Jacobian


def tip_torques():
    """Return J^T w for the wrench on the environment, moment (1, 1, 1) and force (1, 1, 1) in the tip's axes."""
    J, T = evaluated("jacobian:tip"), evaluated("pose:tip")
    push = [sum(T[4 * row : 4 * row + 3]) for row in range(3)]  # R (1, 1, 1), force and moment alike
    return [sum(J[3 * row + i] * w for row, w in enumerate(push + push)) for i in range(3)]


@pytest.mark.parametrize(("name", "key"), [("gravity_forces", "G"), ("velocity_forces", "C"), ("mass_matrix", "M")])
def test_every_formulation_gives_the_published_terms(name, key):
    for formulation in formulations_of(name):
        found = evaluated(name, formulation)
        assert_digits(found, flat(OURS[key]) if key == "M" else OURS[key], "1e-27")
        if key in PUBLISHED:
            assert_digits(found, PUBLISHED[key], "1e-7")


def test_jacobian_carries_the_tip_wrench_to_the_joints():
    assert_digits(tip_torques(), OURS["tip"], "1e-27")
    assert_digits(tip_torques(), PUBLISHED["tip"], "1e-8")


@pytest.mark.parametrize("formulation", formulations_of("inverse_dynamics"))
def test_inverse_dynamics_and_the_tip_wrench_make_the_published_torque(formulation):
    torque = [a + b for a, b in zip(evaluated("inverse_dynamics", formulation), tip_torques(), strict=True)]

    assert_digits(torque, OURS["ID"], "1e-27")
    assert_digits(torque, PUBLISHED["ID"], "1e-9")


@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
def test_forward_dynamics_gives_the_published_acceleration(formulation):
    drive = [a - b for a, b in zip(numbers([".5", ".6", ".7"]), tip_torques(), strict=True)]

    found = evaluated(
        "forward_dynamics", formulation, tau=[value / turn for turn, value in zip(TURNS, drive, strict=True)]
    )

    assert_digits(found, OURS["FD"], "1e-27")
    assert_digits(found, PUBLISHED["FD_tau_p5_p6_p7"], "1e-8")
