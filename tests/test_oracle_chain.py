"""Chains of 1 to 100 point masses: 30 digits of torques and free accelerations, with graphs that stay small."""

from __future__ import annotations

from fractions import Fraction

import pytest
from arms import chain
from oracles import BIG, assert_digits, oracle
from running import call

from symdyn.dynamics import derive

CASES = {case["n"]: case for case in oracle("chain_pendulum")["cases"]}


def oracle_chain(n):
    """Return the scene of a case; from 20 links on, its length is 10 m altogether."""
    lengths = {"1 each": Fraction(1), "10/n each": Fraction(10, n)}
    return chain(n, lengths[CASES[n]["l"]])


def state(n):
    """Return q, q̇, q̈ by the oracle's rules."""
    rules = {
        "q": [Fraction(i + 1, 10) * (-1) ** i for i in range(n)],
        "qd": [Fraction((7 * i) % 11 - 5, 10) for i in range(n)],
        "qdd": [Fraction((5 * i) % 13 - 6, 10) for i in range(n)],
        "tau": [Fraction(0)] * n,
    }
    return {name: [BIG.constant(value) for value in values] for name, values in rules.items()}


def evaluated(name, formulation, n, **more):
    equations = derive(oracle_chain(n), [name], formulation)
    return call(equations, name, BIG, **{**state(n), **more})


@pytest.mark.parametrize("n", CASES)
def test_recursive_inverse_dynamics_of_a_chain(n):
    assert_digits(evaluated("inverse_dynamics", "rnea", n), CASES[n]["tau"], "1e-28")


@pytest.mark.long(0)
@pytest.mark.parametrize("n", CASES)
def test_articulated_body_algorithm_lets_a_chain_fall(n):
    assert_digits(evaluated("forward_dynamics", "aba", n), CASES[n]["free_qdd"], "1e-27")


@pytest.mark.parametrize("n", [n for n in CASES if n <= 20])
def test_composite_mass_and_ldl_let_a_chain_fall(n):
    assert_digits(evaluated("forward_dynamics", "crba", n), CASES[n]["free_qdd"], "1e-27")


@pytest.mark.parametrize("n", [n for n in CASES if n <= 5])
def test_lagrange_agrees_on_short_chains(n):
    assert_digits(evaluated("inverse_dynamics", "lagrange", n), CASES[n]["tau"], "1e-28")
    assert_digits(evaluated("forward_dynamics", "lagrange", n), CASES[n]["free_qdd"], "1e-27")


@pytest.mark.long
def test_composite_mass_of_a_hundred_links_takes_free_accelerations_to_zero_torque():
    n = 100
    free = [BIG.number(text) for text in CASES[n]["free_qdd"]]

    torque = evaluated("inverse_dynamics", "rnea", n, qdd=free)
    at_rest = evaluated("inverse_dynamics", "rnea", n, qdd=state(n)["tau"])
    M = evaluated("mass_matrix", "crba", n)

    inertial = [sum(M[n * i + j] * free[j] for j in range(n)) for i in range(n)]
    assert max(abs(value) for value in torque) < BIG.number("1e-22") * max(abs(value) for value in at_rest)
    assert_digits([-value for value in inertial], [BIG.context.nstr(value, 40) for value in at_rest], "1e-22")


def size(name, formulation, n):
    return len(derive(chain(n), [name], formulation).graph.nodes)


@pytest.mark.parametrize(("name", "formulation"), [("inverse_dynamics", "rnea"), ("forward_dynamics", "aba")])
def test_recursions_grow_by_the_same_nodes_for_every_link(name, formulation):
    grown = [size(name, formulation, n) for n in (10, 20, 30)]

    assert grown[2] - grown[1] <= 1.1 * (grown[1] - grown[0])
