"""Assembly, continuation and initial velocities of closed mechanisms; numbers from published benchmarks."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_mechanisms import crank_rocker, exact, four_bar, n_four_bar, rssr, symbolic_four_bar

from symdyn.dynamics import Workspace, assemble, consistent, follow
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.errors import DerivationError
from symdyn.runtime import lambdify
from symdyn.scene import read_text
from symdyn.scene.values import Joint
from symdyn.scene.values.entry import compose
from symdyn.scene.values.quantity import Quantity

DATA = Path(__file__).parent / "data"

FOURBARS = json.loads((DATA / "fourbar_reactions.json").read_text("utf-8"))["cases"]


@pytest.mark.parametrize("case", FOURBARS, ids=[f"{case['name']}-{case['q']}" for case in FOURBARS])
def test_a_four_bars_torque_motion_and_reaction_near_its_change_point_too(case: dict[str, object]) -> None:
    """Newton-Euler at 60 digits; at 1e-9 rad from the change point one singular value is 3e-10.

    The torque keeps all digits; a perturbation of q by one rounding would change the reaction by 1e-16 / 1e-9 of its
    1e10 N, so that 1e-6 of it is what conditioning allows.
    """
    number = {key: float(case[key]) for key in case if key.endswith(("rate", "acc", "angle", "q", "qd", "qdd", "tau"))}  # type: ignore[arg-type]
    lengths = [exact(str(case[key])) for key in ("a_crank", "b_coupler", "c_rocker", "d_ground")]
    masses = tuple(exact(str(mass)) for mass in case["masses"])  # type: ignore[attr-defined]
    q = np.array([number["q"], number["coupler_angle"] - number["q"], number["rocker_angle"]])
    qd = np.array([number["qd"], number["coupler_rate"] - number["qd"], number["rocker_rate"]])
    qdd = np.array([number["qdd"], number["coupler_acc"] - number["qdd"], number["rocker_acc"]])
    scene = four_bar(*lengths, masses, tuple(repr(float(x)) for x in q))  # type: ignore[arg-type]
    notes = Workspace(scene).loops.decisions.assembly.notes
    inverse, forward, multipliers = lambdify(scene, ("inverse_dynamics", "forward_dynamics", "multipliers"))

    assert bool(notes) == str(case["name"]).startswith("near_change_point")
    tau = inverse(q, qd, qdd)
    assert tau == pytest.approx([number["tau"], 0, 0], rel=1e-13)
    assert forward(q, qd, tau) == pytest.approx(qdd, abs=1e-9)
    phi = number["coupler_angle"]
    turn = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
    expected = np.array([float(x) for x in case["F_coupler_on_rocker"]])  # type: ignore[attr-defined]
    assert turn @ multipliers(q, qd, tau) == pytest.approx(expected, rel=1e-6 if notes else 1e-13)


IFTOMM = json.loads((DATA / "iftomm_closed_form.json").read_text("utf-8"))


@pytest.mark.long
@pytest.mark.parametrize(("n", "singular"), [(2, False), (40, False), (2, True)])
def test_n_four_bars_keep_their_energy_and_move_as_one_pendulum(n: int, singular: bool) -> None:
    """All cranks are parallel: I θ̈ = -c g cos θ and ½ I θ̇² + c g sin θ = const, angles from the horizontal.

    `singular` looks at 1e-6 rad from the position where all bars are in line and the loops change branches.
    """
    facts = IFTOMM[f"A02_N{n}"]
    I, c = float(facts["I"]), float(facts["c"])  # noqa: E741  the oracle's name
    scene = n_four_bar(n)
    forward, kinetic, potential, velocities = lambdify(
        scene, ("forward_dynamics", "kinetic_energy", "potential_energy", "velocities")
    )
    for row in facts["rows"]:
        angle, rate = np.pi / 2 - float(row["theta"]), -float(row["thetad"])
        angle = 1e-6 if singular else angle
        q, u = _parallel(angle, n), _rates(rate, n)
        energy = kinetic(q, u) + potential(q)
        if not singular:
            assert energy == pytest.approx(float(facts["E0"]), rel=1e-12)
            some = Workspace(scene).loops.decisions.partition.independent if n < 10 else ()
            assert not some or velocities(q, u[list(some)]) == pytest.approx(u, rel=1e-9)
        expected = -c * 9.81 * np.cos(angle) / I
        assert forward(q, u, np.zeros(len(q))) == pytest.approx(_rates(expected, n), rel=1e-5 if singular else 1e-8)


def _parallel(angle: float, n: int) -> np.ndarray:
    return np.array([angle, *([-angle, angle] * n)])


def _rates(rate: float, n: int) -> np.ndarray:
    return np.array([rate, *([-rate, rate] * n)])


def test_a_start_is_closed_and_the_driven_joint_keeps_its_place() -> None:
    found = assemble(crank_rocker())

    assert found.q[0] == 0.8
    assert found.residual < 1e-14
    assert assemble(crank_rocker(), {"q_A": 2.9}, ("q_A",)).q[0] == 2.9
    other = assemble(crank_rocker(), {"q_B": -2.5, "q_D": -2.0})
    assert other.q[0] == 0.8
    assert other.q[2] < 0  # the branch of the guess


def test_what_cannot_be_assembled_names_loop_constraint_and_singular_value() -> None:
    short = four_bar(*(exact(x) for x in ("1", "1", "1", "4")), (Quantity.ONE,) * 3)  # type: ignore[arg-type]

    with pytest.raises(
        DerivationError,
        match=r"the loop C cannot be assembled from this start: its gap along . is 0\.98\d m, the smallest "
        r"singular value of the constraints there is [0-9.e-]+; give",
    ):
        assemble(short)


def test_a_driven_joint_that_had_to_move_is_told() -> None:
    rocking = four_bar(*(exact(x) for x in ("3", "1", "3/2", "4")), (Quantity.ONE,) * 3, ("3", "1/2", "2"))  # type: ignore[arg-type]

    found = assemble(rocking)
    assert found.notes[0] == "the loops do not close at the start of q_A, which had to move"


def test_a_loop_that_closes_with_its_axis_reversed_is_told() -> None:
    """The residual vanishes there as well: its rate has the wrong sign."""
    scene = rssr()
    loop = replace(scene.loops[0], type="fixed", tip=compose(("Rx", exact(3))))
    arm = Joint("only", "spherical", "ground", "crank",
                coordinates=("e0", "e1", "e2", "e3"), velocities=("a", "b", "c"),
                drives=(None,) * 3, start=(Quantity.ZERO, Quantity.ONE, Quantity.ZERO, Quantity.ZERO))  # fmt: skip
    hinge_loop = replace(loop, type="revolute", parent="ground", child="crank", origin=compose(), tip=compose())
    scene = replace(scene, bodies=scene.bodies[:1], joints=(arm,), loops=(hinge_loop,))

    with pytest.raises(DerivationError, match="the loop C closes in the wrong direction"):
        assemble(scene)


def test_free_parameters_need_values_to_assemble_in_numbers() -> None:
    scene = symbolic_four_bar()
    with pytest.raises(DerivationError, match="a, b, c, d, m1, m2, m3 have no value"):
        assemble(scene)

    values = {"a": 1.0, "b": 3.0, "c": 3.5, "d": 4.0, "m1": 1.0, "m2": 1.0, "m3": 1.0}
    found = assemble(scene, {"q_A": 0.8, "q_B": 0.1, "q_D": 2.0}, ("q_A",), values)
    assert found.q == pytest.approx(assemble(crank_rocker()).q)


def test_loops_that_cannot_be_closed_are_given_up_when_enough_is_spent(monkeypatch: pytest.MonkeyPatch) -> None:
    text = """
    bodies.arm = {{ mass = 1 }}
    parameters.r = {{}}
    joints.hub = {{ type = "revolute", parent = "ground", child = "arm" }}
    [[loop]]
    name = "far"
    type = "revolute"
    parent = "ground"
    child = "arm"
    origin = ["{}", 0, 0]
    tip = ["r", 0, 0]
    """
    limit = 200_000
    monkeypatch.setattr("symdyn.dynamics.loops.assembly.EFFORT", limit)
    numbers = Numbers(read_text(text.format("r + 9"), "far.toml"))

    with pytest.raises(
        DerivationError, match=r"the loop far cannot be.*random values of r were tried, \d+ times: give"
    ):
        numbers.witness({})
    assert limit < numbers.effort < 1.5 * limit
    assert Numbers(read_text(text.format("r"), "near.toml")).witness({})[1].residual < 1e-9


def test_a_path_keeps_its_branch_through_two_turns() -> None:
    scene = crank_rocker()
    begin = assemble(scene)
    path = follow(scene, begin, {"q_A": np.linspace(0.8, 0.8 + 4 * np.pi, 9)})  # steps of π/2 are cut finer

    assert path[4] == pytest.approx([0.8 + 2 * np.pi, begin.q[1] - 2 * np.pi, begin.q[2]])
    assert path[-1, 2] == pytest.approx(begin.q[2])
    closed = lambdify(scene, "positions")(path[:, :1])
    assert np.abs(np.sin((path - closed) / 2)).max() < 1e-9


def test_a_path_ends_at_a_fold_with_its_singular_value() -> None:
    scene = crank_rocker()

    with pytest.raises(
        DerivationError, match=r"the path ends at q_D = 2\.023.*: the loops do not close beyond, a turning"
    ):
        follow(scene, assemble(scene), {"q_D": [2.0, 1.0]})


def test_initial_velocities_follow_or_contradict() -> None:
    scene = crank_rocker()
    begin = assemble(scene)
    u = consistent(scene, begin, {"q_A_dot": 2.0})
    assert u[1:] == pytest.approx([-0.70989534238792 - 2, -0.09150487088332], rel=1e-12)  # fourbar_reactions, case 1

    with pytest.raises(DerivationError, match="q_A_dot = 2, q_B_dot = 1 contradict each other: C is violated"):
        consistent(scene, begin, {"q_A_dot": 2.0, "q_B_dot": 1.0})
    joints = tuple(replace(joint, start_rates=(exact(1),)) for joint in scene.joints)
    with pytest.raises(DerivationError, match="contradict each other"):
        consistent(replace(scene, joints=joints), begin)


def test_a_loop_without_length_is_told() -> None:
    """All hinges on one line: what the loop forbids is forbidden already."""
    none = four_bar(*(exact(0) for _ in range(4)), (Quantity.ONE,) * 3)  # type: ignore[arg-type]

    (note,) = [one for one in assemble(none).notes if "start" not in one]
    assert note.startswith("the loop C forbids nothing that the other joints of the loop do not forbid already")
    assert not any("forbids nothing" in one for one in assemble(crank_rocker()).notes)
