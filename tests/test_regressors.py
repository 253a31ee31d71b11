"""Regressors: proved by two formulations, times parameters the forces of the scene and of others with its joints."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from counts_of_literature import state_dependent_counts

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Workspace, derive_one, linear_parameters
from symdyn.dynamics.outputs.base_columns import BaseColumns, Linear, base_columns, columns
from symdyn.dynamics.outputs.regressor_outputs import PASSIVITY, REGRESSORS
from symdyn.errors import DerivationError
from symdyn.graph import evaluate
from symdyn.scene import bind, read, read_text
from symdyn.scene.symbolic import INERTIAL
from symdyn.verdict import Verdict

EXAMPLES = Path(__file__).parent.parent / "examples"
sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))

from robots_dh import robot, robot_scene  # noqa: E402

BESIDE = ("kinetic_energy", "potential_energy", "velocity_forces")
SCENES = ("pendulum", "two_link", "spatial_3r", "governor", "scara", "heavy_top", "free_body", "rsup")
CLOSED = ("four_bar", "rssr", "rolling_disc", "spatial_slider_crank")


@pytest.mark.wide("governor", "free_body")
@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", SCENES + CLOSED)
def test_two_formulations_agree_and_the_laws_of_regressors_hold(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    forces = ("inverse_dynamics", *(("tree_forces",) if scene.is_constrained else ()))
    found = symdyn.certify(scene, (*forces, *BESIDE, *REGRESSORS, *PASSIVITY))

    assert {finding.verdict for finding in found.findings} == {Verdict.PROVED}
    claims = {finding.claim.partition(":")[0] for finding in found.findings}
    assert {"regressor", "base regressor", "energy regressor", "C times a velocity"} <= claims
    assert "forces along a reference" in claims
    assert ("regressor along a reference" in claims) == (not scene.is_constrained)


ACTED_ON = """
name = "acted_on"
gravity = [0, 0, "-9.81"]

[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
damping = 2
armature = 3
friction = { coulomb = 5, static = 6, stribeck = "0.1", smoothing = "0.01" }

[bodies.cart]
mass = 4
com = [0, 0, 0]
inertia = [1, 1, 1]
inertia_about = "com"

[springs.bumper]
joint = "slide"
stiffness = 7
free = "0.3"
preload = 8
"""


@pytest.mark.usefixtures("numpy_alone")
def test_what_acts_has_columns_and_what_multiplies_another_one_keeps_its_value() -> None:
    scene = read_text(ACTED_ON)
    told = columns(Workspace(scene))
    assert told[len(INERTIAL) :] == ("Ia1", "fv1", "fc1", "fs1", "k1", "p1")
    assert base_columns(Workspace(scene)) == ("mR1 + Ia1", "fv1", "fc1", "fs1", "k1", "p1")
    assert symdyn.certify(scene, ("inverse_dynamics", "regressor", "base_regressor")).passed

    Y = symdyn.lambdify(scene, "base_regressor")([0.5], [0.02], [2])
    rate, curve = np.tanh(2), np.exp(-0.04)
    np.testing.assert_allclose(Y, [[2, 0.02, rate * (1 - curve), rate * curve, 0.2, 1]], rtol=1e-13)


@pytest.mark.parametrize("name", ["spatial_3r", "two_link"])
def test_the_regressor_of_one_scene_gives_the_forces_of_another_with_its_joints(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    rng = np.random.default_rng(3)
    known = {p.name: float(rng.uniform(0.5, 2)) for p in scene.parameters}
    other = {**known, **{one: value * 1.7 for one, value in known.items() if one[0] in "mI"}}
    q, qd, qdd = rng.uniform(-2, 2, (3, len(scene.coordinates)))
    Y = symdyn.lambdify(bind(scene, known), "regressor")(q, qd, qdd)
    w = Workspace(bind(scene, other))
    pi = evaluate(Linear.of(w).parameters(), Floats(), {w.graph.symbol(one): value for one, value in other.items()})
    tau = symdyn.lambdify(bind(scene, other), "inverse_dynamics")(q, qd, qdd)

    np.testing.assert_allclose(Y @ pi, tau, rtol=1e-13)


@pytest.mark.parametrize(
    ("name", "count", "base", "forces", "along", "times"),
    [
        ("puma560", 36, (368, 274), (279, 267), (407, 312), (262, 242)),
        ("panda", 43, (642, 445), (330, 319), (689, 491), (315, 298)),
    ],
)
def test_columns_and_operations_are_as_few_as_they_were(
    name: str, count: int, base: object, forces: object, along: object, times: object
) -> None:
    w = Workspace(robot_scene(robot(name)))
    assert len(base_columns(w)) == count
    counted = {one: state_dependent_counts(derive_one(w, one)) for one in ("base_regressor", *(o for o in PASSIVITY))}
    assert {one: (c.multiplications, c.additions) for one, c in counted.items()} == {
        "base_regressor": base,
        "slotine_li_forces": forces,
        "slotine_li_regressor": along,
        "coriolis_times": times,
    }


def test_parameters_are_told_by_name_with_formulas() -> None:
    scene = read(EXAMPLES / "pendulum.toml")
    told = dict(linear_parameters(scene))
    assert list(told) == [*(f"{kind}1" for kind, _, _ in INERTIAL), "b"]
    assert {str(told["m1"]), str(told["Iyz1"])} == {str(told["m1"].graph.symbol("m")), "0"}
    assert [name for name, _ in linear_parameters(scene, "base_regressor")] == list(base_columns(Workspace(scene)))
    with pytest.raises(DerivationError, match="give regressor or base_regressor"):
        linear_parameters(scene, "mass_matrix")


def test_equal_columns_are_one_and_say_so() -> None:
    told = base_columns(Workspace(read(EXAMPLES / "two_link.toml")))
    assert told == ("mxR1", "myR1", "JxxR1 + JyyR1", "mxR2", "myR2", "JxxR2 + JyyR2")


@pytest.mark.parametrize(("name", "count"), [("two_link", 6), ("cart_pole", 5), ("scara", 8), ("spatial_3r", 15)])
def test_no_column_of_the_base_regressor_depends_on_others(name: str, count: int) -> None:
    """A SCARA's stroke lies along all its turns: moments beside it are the forearm's."""
    scene = read(EXAMPLES / f"{name}.toml")
    known = {p.name: 1 + 0.3 * k for k, p in enumerate(scene.parameters)}
    scene = bind(scene, known)
    q, qd, qdd = np.random.default_rng(4).normal(size=(3, 40, len(scene.coordinates)))
    Y = symdyn.lambdify(scene, "base_regressor")(q, qd, qdd)
    assert Y.shape[-1] == count == np.linalg.matrix_rank(Y.reshape(-1, Y.shape[-1]))

    w = Workspace(scene)
    pi = evaluate(BaseColumns.of(w).values(), Floats(), {w.graph.symbol(one): value for one, value in known.items()})
    tau = symdyn.lambdify(scene, "inverse_dynamics")(q, qd, qdd)
    np.testing.assert_allclose(Y @ pi, tau, rtol=1e-12, atol=1e-12)


def test_parameters_of_the_scene_s_own_are_columns_too() -> None:
    assert columns(Workspace(read(EXAMPLES / "governor.toml")))[-1] == "k"
