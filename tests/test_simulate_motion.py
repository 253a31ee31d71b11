"""Motion laws, forces, tables, events and starts, each held to what it must satisfy."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_mechanisms import crank_rocker, exact
from scenes_in_time import double_pendulum, heavy_top, pendulum

from symdyn.dynamics.loops.mobility import mobility
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read
from symdyn.scene.values import Joint
from symdyn.scene.values.entry import Faults
from symdyn.scene.values.formula import parse as formula
from symdyn.simulation import METHODS, Trajectory, inverse, read_forces, read_motion, simulate
from symdyn.simulation.equations.implicit import differences
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.forward import is_stiff
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import importable
from symdyn.simulation.prescribed.forces import SceneMotion
from symdyn.simulation.prescribed.motion_laws import Law, read_law

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"

LAWS = [
    "0.3*sin(2*t) + t**3/7",
    "exp(-t)*cos(3*t)",
    "constant(0.4)",
    "cubic(0.1, 1.3, 1.5, start=0.2)",
    "quintic(0.1, pi/2, 1.5, 0.2)",
    "cycloidal(0, -1, 1.7, 0.1)",
    "trapezoidal(0, 2, 1.6, ramp=0.3, start=0.1)",
    "spline(0, 0, 0.7, 0.5, 1.1, -0.2, 1.9, 0.3)",
]


def law(text: str) -> Law:
    faults = Faults("")
    found = read_law(text, {}, "q", faults)
    assert found is not None, faults.lines
    return found


@pytest.mark.parametrize("text", LAWS)
def test_velocity_and_acceleration_are_derivatives_of_the_position(text: str) -> None:
    t, h = np.array([0.15, 0.33, 0.61, 1.02, 1.27, 1.44]), 1e-5
    q, qd, qdd = law(text)(t)

    ahead, behind = law(text)(t + h), law(text)(t - h)

    assert np.allclose(qd, (ahead[0] - behind[0]) / (2 * h), atol=1e-8)
    assert np.allclose(qdd, (ahead[1] - behind[1]) / (2 * h), atol=1e-7)
    assert q.shape == t.shape


@pytest.mark.parametrize("text", ["cubic(1, 3, 2)", "quintic(1, 3, 2)", "cycloidal(1, 3, 2)", "trapezoidal(1, 3, 2)"])
def test_laws_go_from_one_end_to_the_other_and_rest(text: str) -> None:
    q, qd, _ = law(text)(np.array([-1.0, 0.0, 1.0, 2.0, 5.0]))

    assert np.allclose(q, [1, 1, 2, 3, 3], atol=1e-15)
    assert np.allclose(qd[[0, 1, 3, 4]], 0, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("quintic(0, 1)", "T missing"),
        ("cubic(0, 1, -2)", "not a duration"),
        ("trapezoidal(0, 1, 2, 1.5)", "not within"),
        ("spline(0, 0, 0, 1)", "must rise"),
        ("spline(0, 0, 1)", "by turns"),
        ("cubic(0, 1, 2, 3, 4)", "5 arguments"),
        ("cubic(0, 1, 2, begin=3)", "no argument begin"),
        ("sin(t", "breaks off"),
        ("q1 + t", "uses q1"),
    ],
)
def test_wrong_laws_are_told_in_one_line(text: str, said: str) -> None:
    faults = Faults("")

    assert read_law(text, {}, "q", faults) is None
    assert len(faults.lines) == 1
    assert said in faults.lines[0]


def test_forces_of_a_motion_give_the_motion_back(tmp_path: Path) -> None:
    scene = read(EXAMPLES / "puma560.toml")
    motion = read_motion(scene, ["q1=0.3*sin(2*t)", "q2=quintic(0, 0.5, 1)", "q3=cycloidal(0.2, -0.3, 1)"])
    forces = inverse(scene, motion, np.linspace(0, 1, 2001))
    forces.to_csv(tmp_path / "forces.csv")

    start = {"q3": "0.2"}
    found = simulate(
        scene,
        forces=read_forces(scene, [str(tmp_path / "forces.csv")]),
        until=1.0,
        start=start,
        start_rates={"q1": "0.6"},
        every=0.25,
    )

    assert found.method == "dop853"  # a table has no Taylor series
    assert np.abs(found.q - forces.q[::500]).max() < 1e-6


def test_a_recorded_motion_gives_its_forces_back_digit_for_digit(tmp_path: Path) -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    found = simulate(scene, forces=read_forces(scene, ["F=-3*x - x_dot + sin(t)"]), until=2.0, start={"theta": "0.3"})
    found.to_csv(tmp_path / "motion.csv")

    again = inverse(scene, read_motion(scene, [str(tmp_path / "motion.csv")]), found.t)

    assert np.abs(again.tau[:, 0] - found.tau[:, 0]).max() < 1e-11
    assert np.abs(again.tau[:, 1]).max() < 1e-11  # the hinge is passive


def test_a_recorded_top_gives_its_forces_back(tmp_path: Path) -> None:
    found = simulate(heavy_top(), until=0.1)
    found.to_csv(tmp_path / "motion.csv")

    again = inverse(heavy_top(), read_motion(heavy_top(), [str(tmp_path / "motion.csv")]), found.t)

    assert np.abs(again.tau).max() < 1e-7


def test_a_turning_quaternion_takes_the_torque_of_its_axis() -> None:
    motion = read_motion(heavy_top(), ["q1=cos(t**2/2)", "q2=0", "q3=sin(t**2/2)", "q4=0"])
    found = inverse(heavy_top(), motion, [0.5, 1.0])

    assert np.allclose(found.qd, [[0, 1.0, 0], [0, 2.0, 0]], atol=1e-14)
    assert np.allclose(found.qdd[:, 1], 2.0, atol=1e-13)
    assert np.allclose(found.tau[:, 1], 0.46875 * 2, atol=1e-12)


def test_a_crank_drives_its_four_bar_and_the_same_torque_moves_it(tmp_path: Path) -> None:
    scene = crank_rocker()
    motion = inverse(scene, read_motion(scene, ["q_A=0.8 + 0.3*sin(2*t)"]), np.linspace(0, 1, 2001))
    motion.to_csv(tmp_path / "forces.csv")

    forces = read_forces(scene, [str(tmp_path / "forces.csv")])
    found = simulate(
        scene, forces=forces, until=1.0, start={"q_A": "0.8"}, start_rates={"q_A": "0.6"}, every=0.25, rtol=1e-10
    )

    assert motion.extra["loop_error"].max() < 1e-12
    assert np.all(motion.tau[:, 1:] == 0)
    assert np.abs(found.q - motion.q[::500]).max() < 1e-6
    assert found.monitors["loops"] < 1e-9
    assert found.monitors["energy"] < 1e-8 * found.monitors["energy_scale"]


@pytest.mark.parametrize("method", [name for name, one in METHODS.items() if one.finds_events])
def test_every_method_finds_the_same_motion_and_events(method: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip(f"needs {METHODS[method].library}")
    found = simulate(pendulum(), until=3.0, method=method, rtol=1e-9 if method != "rk23" else 1e-7, reports=["q1"])

    reference = simulate(pendulum(), until=3.0, method="dop853", rtol=1e-12)
    assert np.abs(found.q - reference.q).max() < 2e-5
    assert len(found.events) == 3
    period = 2.367841947576237  # IFToMM A01
    assert found.events[0].t == pytest.approx(period / 4, abs=1e-5)
    assert found.events[1].t == pytest.approx(3 * period / 4, abs=1e-5)


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_stop_ends_the_run_where_its_formula_vanishes(method: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip("needs heyoka")
    found = simulate(pendulum(), until=3.0, stops=["q1 + 0.5"], reports=["q1_dot"], method=method, rtol=1e-12)

    assert found.stopped == "q1 + 0.5"
    assert found.q[-1, 0] == pytest.approx(-0.5, abs=1e-10)
    assert found.t[-1] == found.events[-1].t
    assert [event.stops for event in found.events] == [True]  # at rest at the start is no crossing


def test_energy_balance_counts_drives_and_losses() -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    found = simulate(scene, forces=read_forces(scene, ["F=5*sin(3*t) - 2*x"]), until=5.0, start={"theta": "0.4"})

    assert np.abs(found.extra["other_power"]).max() > 0.01
    assert np.abs(found.extra["work"]).max() > 0.1
    assert found.monitors["energy"] < 1e-10 * found.monitors["energy_scale"]


def test_a_stiff_system_gets_an_implicit_method() -> None:
    scene = read(EXAMPLES / "pendulum.toml")
    lines: list[str] = []
    drive = next(name for name in scene.drives if name)
    found = simulate(
        scene, forces=read_forces(scene, [f"{drive}=-1e5*q1_dot"]), until=10.0, start={"q1": "1"}, say=lines.append
    )

    assert found.method in ("cvode", "radau")
    assert "stiff" in lines[0]


@pytest.mark.parametrize("name", ["four_bar", "pendulum"])
def test_a_saddle_is_not_stiff_however_long_the_motion(name: str) -> None:
    system = state_equations(read(EXAMPLES / f"{name}.toml"))
    x = np.zeros(system.nq + system.nv + system.works)
    if name == "pendulum":
        x[0] = np.pi
    else:
        x[: system.nq] = simulate(system.scene, until=0.1).q[0]

    assert np.linalg.eigvals(differences(system, 0.0, x, 1e-6)).real.min() < -1.0
    assert not is_stiff(system, x, 1e9)


def test_branches_are_no_case_for_taylor() -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    forces = read_forces(scene, ["F=-sign(x_dot)"])
    lines: list[str] = []

    simulate(scene, forces=forces, until=0.1, start={"x": "1"}, say=lines.append)

    assert "branch" in lines[0]
    with pytest.raises(SimulateError, match="does not apply"):
        simulate(scene, forces=forces, until=0.1, method="taylor")


def test_faults_of_a_table_come_together(tmp_path: Path) -> None:
    path = tmp_path / "motion.csv"
    path.write_text("t,q1,q1\n0,1,1\n")
    with pytest.raises(SimulateError, match="q1 twice") as fault:
        read_motion(double_pendulum(), [str(path)])
    assert len(fault.value.faults) == 2

    path.write_text("t,q1,q2\n0,1,nan\n2,x,1\n1,1,1\n3,1\n")
    with pytest.raises(SimulateError, match="not a finite number") as fault:
        read_motion(double_pendulum(), [str(path)])
    assert [line.split(": ")[1] for line in fault.value.faults] == ["row 2", "row 3", "row 5", "row 4"]


def test_outside_its_table_a_motion_is_not_known(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("t,q1,q2\n0,0,0\n1,1,1\n2,0,0\n")
    motion = read_motion(double_pendulum(), [str(tmp_path / "m.csv")])

    with pytest.raises(SimulateError, match="from 0 s to 2 s only"):
        inverse(double_pendulum(), motion, [0.0, 3.0])


def test_a_start_that_does_not_close_is_told() -> None:
    with pytest.raises(SimulateError, match="the loops do not close with q_D = 3"):
        simulate(crank_rocker(), until=0.1, start={"q_D": "3"})
    with pytest.raises(SimulateError, match="not known"):
        simulate(double_pendulum(), until=0.1, start={"q7": "1"}, start_rates={"q8": "1"})


def test_a_coordinate_without_law_rests_and_is_named() -> None:
    found = inverse(double_pendulum(), SceneMotion(), [0.0, 1.0])

    assert found.notes == ("no law is given for q1, q2: at rest",)


def test_csv_holds_every_digit_and_the_same_run_is_the_same_text() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs: list[Trajectory] = [simulate(double_pendulum(), until=0.5, start={"q1": "1"}) for _ in range(2)]
    first = runs[0].to_csv().splitlines()

    assert runs[0].to_csv() == runs[1].to_csv()
    assert [float(x) for x in first[-1].split(",")] == runs[0].table()[1][-1].tolist()
    assert first[0].split(",")[:5] == ["t", "q1", "q2", "q1_dot", "q2_dot"]


def _with_rates(rates: dict[str, str]) -> Scene:
    """Return the crank-rocker with rates at the start of some joints."""
    scene = crank_rocker()
    joints = (replace(j, start_rates=(exact(rates[j.name]),)) if j.name in rates else j for j in scene.joints)
    return replace(scene, joints=tuple(joints))


def test_declared_rates_of_a_closed_scene_stay_and_the_others_follow() -> None:
    u = read_start(_with_rates({"A": "2"})).u

    assert u == pytest.approx([2, -2.70989534238792, -0.09150487088332], rel=1e-11)  # fourbar_reactions, case 1
    assert read_start(_with_rates({"A": "1"}), rates={"q_A": "2"}).u == pytest.approx(u, rel=1e-15)


def test_rates_that_contradict_each_other_are_refused() -> None:
    contradicting = "q_A_dot = 2, q_D_dot = 7 contradict each other: C is violated"
    with pytest.raises(SimulateError, match=contradicting):
        read_start(scene := _with_rates({"A": "2", "D": "7"}))
    with pytest.raises(SimulateError, match=contradicting):
        read_start(scene, rates={"q_A": "2", "q_D": "7"})
    (note,) = [one for one in mobility(_with_rates({"A": "2", "D": "7"})).notes if "planar" not in one]
    assert contradicting in note


def test_a_rate_that_is_given_does_not_loosen_a_prescribed_one() -> None:
    scene = crank_rocker()
    led = replace(scene.joints[0], start=(), motion=formula("4/5 + 2*t"), drives=(None,))
    scene = replace(scene, joints=(led, *scene.joints[1:]))

    with pytest.raises(SimulateError, match="contradict each other"):
        read_start(scene, rates={"q_D": "7"})


def test_loops_that_forbid_nothing_are_simulated_as_the_tree() -> None:
    """A hinge that is closed by a second one on the same line: all rows of the loop are redundant."""
    scene = pendulum()
    (hinge,) = scene.joints
    twin = Joint("twin", hinge.type, hinge.parent, hinge.child, origin=hinge.origin, tip=hinge.tip)
    doubled = replace(scene, loops=(twin,))
    tree, closed = (simulate(one, until=0.2, every=0.1, start={"q1": "1"}) for one in (scene, doubled))

    assert np.abs(closed.q - tree.q).max() < 1e-11
    assert "loop_error" not in closed.extra
    assert inverse(doubled, read_motion(doubled, ["q1=t"]), [0.0, 0.1]).tau == pytest.approx(
        inverse(scene, read_motion(scene, ["q1=t"]), [0.0, 0.1]).tau
    )
    assert inverse(doubled, SceneMotion(), [0.0]).notes == ("no law is given for q1: at rest",)


def test_a_quaternion_that_is_no_unit_is_told_and_divided_by_its_length() -> None:
    start = read_start(heavy_top(), {"q1": "3", "q2": "4", "q3": "0", "q4": "0"})

    assert start.q[:4] == pytest.approx([0.6, 0.8, 0, 0])
    assert start.notes == ("start: the quaternion (q1, q2, q3, q4) has length 5; it was divided by that",)
    assert not read_start(heavy_top()).notes
