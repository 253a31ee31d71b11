"""The two-link arm of example 5.28 against 30 states at 40 digits: usual, singular, huge, and with masses 1e±12."""

from __future__ import annotations

import pytest
from arms import two_link
from oracles import BIG, assert_digits, numbers, oracle
from running import call

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import derive

CASES = oracle("two_link_point_mass")["cases"]
NAMES = [f"m1={c['m1']} m2={c['m2']} h1={c['h1']} q={c['q'][0][:6]},{c['q'][1][:6]}" for c in CASES]
OUTPUTS = ("inverse_dynamics", "forward_dynamics", "mass_matrix")


@pytest.fixture(scope="module", params=["lagrange", "crba"])
def formulation(request):
    """The same outputs by both formulations."""
    recursive = {"inverse_dynamics": "rnea", "forward_dynamics": "aba", "mass_matrix": "crba"}
    scene = two_link()
    return {name: derive(scene, [name], recursive[name] if request.param == "crba" else "lagrange") for name in OUTPUTS}


def evaluated(formulation, name, case, algebra, convert):
    given = {key: convert(case[key]) for key in ("q", "qd", "qdd")}
    params = convert([case[key] for key in ("m1", "m2", "h1", "h2", "g")])
    return call(formulation[name], name, algebra, **given, tau=convert(["0", "0"]), params=params)


@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_forty_digits_of_torque_mass_matrix_and_free_acceleration(formulation, case):
    assert_digits(evaluated(formulation, "inverse_dynamics", case, BIG, numbers), case["tau"])
    m11, m12, m22 = case["M"]
    assert_digits(evaluated(formulation, "mass_matrix", case, BIG, numbers), [m11, m12, m12, m22])
    assert_digits(evaluated(formulation, "forward_dynamics", case, BIG, numbers), case["free_qdd"])


TAME = [(case, name) for case, name in zip(CASES, NAMES, strict=True) if float(case["condM"]) < 100]


@pytest.mark.parametrize("case", [case for case, _ in TAME], ids=[name for _, name in TAME])
def test_doubles_reach_what_conditioning_allows(formulation, case):
    def doubles(texts):
        return [float(text) for text in texts]

    reach = max(1.0, *(abs(float(angle)) for angle in case["q"]))  # the rounding of a large angle is an error of q
    # of the largest term: torques may cancel
    weight = max(float(case["M"][0]), 1) * max(1.0, *(float(x) ** 2 for x in case["qd"]), float(case["qdd"][0]))
    found = evaluated(formulation, "inverse_dynamics", case, Floats(), doubles)
    for a, b in zip(found, doubles(case["tau"]), strict=True):
        assert abs(a - b) <= 64 * 2**-53 * reach * max(weight, 9.81)
    found, expected = evaluated(formulation, "forward_dynamics", case, Floats(), doubles), doubles(case["free_qdd"])
    scale = max(9.81, *(abs(x) for x in expected))
    for a, b in zip(found, expected, strict=True):
        assert abs(a - b) <= 64 * 2**-53 * reach * float(case["condM"]) * scale
