"""The centre of mass and momentum about it, and derivatives along quaternions, beside Pinocchio's; and bad input."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from oracles import DATA, oracle

import symdyn
from symdyn.dynamics import OUTPUTS, Formulation, Workspace, derive, formulations_of
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene import Scene, read_text
from symdyn.verify import certify

pytestmark = pytest.mark.long

ASKED = (
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "centre_of_mass",
    "centre_of_mass_jacobian",
    "centroidal_momentum_matrix",
    "centroidal_momentum_bias",
)

FLYER = """
name = "flyer"
[bodies.trunk]
mass = 3
com = [0.1, -0.2, 0.05]
inertia = { xx = 0.4, yy = 0.5, zz = 0.6, xy = 0.03, xz = -0.02, yz = 0.01 }
inertia_about = "com"
[bodies.arm]
mass = 1.5
com = [0, 0.1, -0.3]
inertia = { xx = 0.2, yy = 0.15, zz = 0.1, xy = 0, xz = 0.01, yz = -0.02 }
inertia_about = "com"
[bodies.hand]
mass = 0.7
com = [0.2, 0, 0.1]
inertia = { xx = 0.05, yy = 0.06, zz = 0.07, xy = 0.004, xz = 0.003, yz = 0.002 }
inertia_about = "com"
[joints]
flight = { type = "free", parent = "ground", child = "trunk" }
[joints.ball]
type = "spherical"
parent = "trunk"
child = "arm"
origin = { xyz = [0.3, 0.1, 0.2], rpy = [0.3, -0.4, 0.5] }
[joints.hinge]
type = "revolute"
parent = "arm"
child = "hand"
axis = [1, 0, 0]
origin = { xyz = [0, 0.2, -0.6], rpy = [0, 0.7, 0] }
"""
"""The robot of `pinocchio_derivatives`."""


@cache
def flyer() -> Scene:
    """Return it."""
    return read_text(FLYER, "flyer.toml")


@pytest.mark.heavy("forward_dynamics_derivatives")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ASKED)
def test_it_is_what_pinocchio_says_of_a_free_flyer_with_a_ball(name: str) -> None:
    """Only the quaternion's w has another place: v and ω along the moved frame are Pinocchio's tangent."""
    call, taken = symdyn.lambdify(flyer(), name), derive(flyer(), [name]).functions[0].arguments
    for state in oracle("derivatives_pinocchio")["states"]:
        expected = np.array(state[name])
        found = call(*(np.array(state[argument.name]) for argument in taken))
        assert np.abs(found - expected).max() <= 1e-11 * max(1, np.abs(expected).max())


@pytest.mark.slow
def test_the_reference_is_what_pinocchio_writes_today() -> None:
    pytest.importorskip("pinocchio")
    import pinocchio_derivatives as peer

    robot = peer.model()
    for state, known in zip(peer.states(), oracle("derivatives_pinocchio")["states"], strict=True):
        for name, value in peer.results(robot, *state).items():
            assert np.allclose(value, known[name], rtol=1e-10, atol=1e-10), name


def test_the_reference_says_where_it_comes_from() -> None:
    text = json.loads((DATA / "derivatives_pinocchio.json").read_text(encoding="utf-8"))["source"]
    assert text.endswith("python tests/pinocchio_derivatives.py FILE")


# Laws


MOMENTUM = ("centre_of_mass", "centre_of_mass_jacobian", "centroidal_momentum_matrix", "centroidal_momentum_bias")


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long(0)
def test_laws_of_momentum_are_proved_of_a_free_base() -> None:
    certificate = certify(flyer(), [*MOMENTUM, "gravity_forces", "momentum"])
    told = [finding.claim.partition(":")[0] for finding in certificate.findings]
    assert certificate.passed
    assert {"centre of mass", "momentum", "weight", "rate of momentum", "momentum of a free base"} <= set(told)


WELDED = """
name = "welded"
[bodies]
table = { mass = 100, com = [9, 9, 9] }
link = { mass = 2, com = [1, 0, 0] }
flange = { mass = 1, com = [1, 0, 0] }
[joints]
stand = { type = "fixed", parent = "ground", child = "table" }
hinge = { type = "revolute", parent = "table", child = "link", axis = [0, 0, 1], rotor = { inertia = 1, gear = 10 } }
weld = { type = "fixed", parent = "link", child = "flange", origin = [1, 0, 0] }
"""


def test_what_is_welded_to_the_ground_does_not_count_and_rotors_have_no_part() -> None:
    scene = read_text(WELDED, "welded.toml")
    centre, matrix = (symdyn.lambdify(scene, name) for name in ("centre_of_mass", "centroidal_momentum_matrix"))
    assert centre([0.0]) == pytest.approx([4 / 3, 0, 0])
    assert matrix([0.0])[:, 0] == pytest.approx([0, 4, 0, 0, 0, 2 * 1 / 9 + 1 * 4 / 9])
    bias = symdyn.lambdify(scene, "centroidal_momentum_bias")
    assert bias([0.0], [2.0]) == pytest.approx([-3 * 4 / 3 * 4, 0, 0, 0, 0, 0])


MASSLESS = """
[bodies]
table = { mass = 5, com = [0, 0, 0] }
needle = {}
[joints]
stand = { type = "fixed", parent = "ground", child = "table" }
hinge = { type = "revolute", parent = "table", child = "needle", axis = [0, 0, 1] }
"""


@pytest.mark.parametrize("name", MOMENTUM)
@pytest.mark.parametrize("formulation", [0, 1])
def test_without_mass_there_is_no_centre(name: str, formulation: int) -> None:
    scene = read_text(MASSLESS, "needle.toml")
    with pytest.raises(DerivationError, match="no body that moves has a mass, so that there is no centre of mass"):
        derive(scene, [name], formulations_of(name)[formulation])


def test_nobody_has_them_unasked() -> None:
    assert not set(symdyn.dynamics.available(flyer())[0]) & set(MOMENTUM)


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.long
@pytest.mark.parametrize("name", MOMENTUM)
def test_a_fault_that_all_formulations_share_breaks_a_law(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, row = read_text(WELDED, "welded.toml"), OUTPUTS[name]
    asked = [*MOMENTUM, "gravity_forces"]
    assert certify(scene, asked).passed

    def faulty(w: Workspace) -> list[Expr]:
        first, *rest = row.formulations["recursive"].derive(w)
        return [first + w.state.q[0], *rest]

    monkeypatch.setitem(OUTPUTS, name, replace(row, formulations={"recursive": Formulation(faulty)}))
    assert not certify(scene, asked).passed
