"""Corke's PUMA 560 without motors: torques, gravity, mass matrix, Coriolis matrix at 40 digits, by all formulations."""

from __future__ import annotations

import pytest
from arms import puma560
from oracles import BIG, assert_digits, flat, numbers, oracle
from running import call

from symdyn.dynamics import derive, formulations_of

PUMA = oracle("puma560_corke")
STATES = PUMA["states"]

CHECKS = {"inverse_dynamics": "tau_no_motor", "gravity_forces": "grav", "mass_matrix": "M_no_motor"}


@pytest.fixture(scope="module")
def scene():
    return puma560()


def evaluated(scene, name, formulation, state, **more):
    given = {key: numbers(state[key]) for key in ("q", "qd", "qdd")}
    return call(derive(scene, [name], formulation), name, BIG, **{**given, **more})


@pytest.mark.long
@pytest.mark.parametrize("name", [*CHECKS, "coriolis_matrix"])
def test_every_formulation_gives_the_published_robot(scene, name):
    for formulation in formulations_of(name):
        equations = derive(scene, [name], formulation)
        for state in STATES:
            given = state[CHECKS.get(name, "C_christoffel")]
            given = flat(given) if isinstance(given[0], list) else given
            found = call(equations, name, BIG, **{key: numbers(state[key]) for key in ("q", "qd", "qdd")})
            assert_digits(found, given)


@pytest.mark.parametrize("state", STATES, ids=[state["name"] for state in STATES])
def test_velocity_forces_are_the_published_coriolis_matrix_times_velocity(scene, state):
    qd = numbers(state["qd"])
    C = [numbers(row) for row in state["C_christoffel"]]

    found = evaluated(scene, "velocity_forces", None, state)

    expected = [sum(c * v for c, v in zip(row, qd, strict=True)) for row in C]
    assert_digits(found, [str(value) for value in expected])


TAU = ["10", "-5", "3", "0.5", "-0.25", "0.125"]


@pytest.mark.parametrize("state", STATES, ids=[state["name"] for state in STATES])
def test_accelerations_with_motors_need_the_published_torque(scene, state):
    """With rotor inertia G² Jm on every axis, the published accelerations must ask for the torque they came from."""
    qdd = numbers(state["qdd_for_tau_10_m5_3_p5_mp25_p125_with_motor"])
    rotor = [BIG.number(link["G"]) ** 2 * BIG.number(link["Jm"]) for link in PUMA["links"]]

    found = evaluated(scene, "inverse_dynamics", None, state, qdd=qdd)

    assert_digits([a + j * x for a, j, x in zip(found, rotor, qdd, strict=True)], TAU)


@pytest.mark.parametrize("formulation", formulations_of("forward_dynamics"))
def test_forward_dynamics_takes_the_published_torque_back_to_the_acceleration(scene, formulation):
    equations = derive(scene, ["forward_dynamics"], formulation)
    for state in STATES:
        given = {key: numbers(state[key]) for key in ("q", "qd")}
        found = call(equations, "forward_dynamics", BIG, **given, tau=numbers(state["tau_no_motor"]))
        assert_digits(found, state["qdd"], "1e-29")
