"""Where a motion starts: what is given and what follows, limits that it passes, parts that have no value there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_mechanisms import crank_rocker, exact

import symdyn
from symdyn.cli import main
from symdyn.emit import emit
from symdyn.errors import SimulateError
from symdyn.program import formulate, lower
from symdyn.runtime import run_python
from symdyn.scene import Scene, read
from symdyn.scene.toml import read_text
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.initial import read_start

HERE = Path(__file__).parent
EXAMPLES, FOUND = HERE.parent / "examples", HERE / "data" / "found"
FOUR_BAR = str(EXAMPLES / "four_bar.toml")


def _turning(rate: str) -> Scene:
    """Return the crank-rocker whose crank turns at the start."""
    scene = crank_rocker()
    return replace(scene, joints=(replace(scene.joints[0], start_rates=(exact(rate),)), *scene.joints[1:]))


@pytest.mark.runs
@pytest.mark.mends("3.8")
def test_coordinates_beyond_the_freedoms_choose_the_branch_and_what_they_become_is_told(
    capsys: pytest.CaptureFixture[str],
) -> None:
    command = ["simulate", FOUR_BAR, "--until", "0.01", "--every", "0.01", "--method", "dop853"]
    assert main([*command, "--start", "phi=0.8,psi=-2.5,chi=-2"]) == 0
    out, err = capsys.readouterr()

    phi, psi, chi = (float(x) for x in out.splitlines()[1].split(",")[1:4])
    assert phi == 0.8
    assert (psi, chi) == pytest.approx((-2.16969600667464, -2.45370023777086), rel=1e-12)  # the other branch
    assert "more coordinates are given than can be chosen freely; phi kept" in err
    assert "psi = -2.16969601, chi = -2.45370024" in err


@pytest.mark.runs("cc")
@pytest.mark.parametrize("psi", [-3.0, 0.5, 3.0])
def test_a_dependent_coordinate_that_is_given_wins_over_what_the_scene_says(psi: float) -> None:
    """psi = 3 is reached: crank and coupler are 2.02 m long together, and from 0.5 to 7.5 m close the loop."""
    scene = read(FOUR_BAR)
    alone = read_start(scene, {"psi": psi})
    assert alone.q[1] == pytest.approx(psi, abs=1e-12)
    assert np.abs(opened(scene).numbers().residual(alone.q)).max() < 1e-9
    assert symdyn.linearize(scene, start={"psi": psi}, anywhere=True).point.q == pytest.approx(alone.q, abs=1e-12)

    branches = (-2.35234125, -0.12483531, 3.93084406)  # of phi = 1, by the law of cosines
    nearest = min(branches, key=lambda one: abs(one - psi))
    assert read_start(scene, {"phi": 1.0, "psi": psi}).q[1] == pytest.approx(nearest, abs=1e-8)
    run = symdyn.inverse(scene, {"phi": "1 + t"}, until=0.01, start={"psi": psi})
    assert run["psi"][0] == pytest.approx(nearest, abs=1e-8)


def test_whole_radians_beyond_a_turn_are_told_to_be_no_degrees() -> None:
    scene = read(EXAMPLES / "pendulum.toml")
    told = 'start: q1 = 90 is in rad; write "90 deg" for degrees'
    assert [told in read_start(scene, {"q1": x}).notes for x in (90, "90", "90 deg", 3, 6.5)] == [True, True] + 3 * [
        False
    ]
    text = (EXAMPLES / "pendulum.toml").read_text(encoding="utf-8")
    for start, noted in (("90", True), ('"90 deg"', False), ('"90 rad"', False), ("6.5", False)):
        assert (
            told in read_start(read_text(text.replace('child = "bob"', f'child = "bob"\nstart = {start}'))).notes
        ) == noted


def test_one_coordinate_is_kept_be_it_driven_or_not() -> None:
    scene = crank_rocker()
    for name, value in (("q_A", 1.0), ("q_D", 2.2)):
        start = read_start(scene, {name: repr(value)})
        assert start.q[list(scene.coordinates).index(name)] == pytest.approx(value, abs=1e-15)
        assert not any("more coordinates" in note for note in start.notes)


def test_all_digits_of_a_closed_position_are_no_word_worth() -> None:
    scene = crank_rocker()
    whole = dict(zip(scene.coordinates, map(repr, read_start(scene).q.tolist()), strict=True))

    assert not [note for note in read_start(scene, whole).notes if "start" in note]
    assert read_start(scene, whole).q == pytest.approx(read_start(scene).q, abs=1e-12)


@pytest.mark.mends("3.8")
def test_a_coordinate_that_the_loops_do_not_reach_is_refused_with_where_they_close(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["simulate", FOUR_BAR, "--until", "0.01", "--start", "chi=1.5"]) == 1
    assert "the loops do not close with chi = 1.5; from there they close at chi = 2.03184" in capsys.readouterr().err


@pytest.mark.mends("3.8")
def test_rates_that_are_given_replace_those_of_the_scene() -> None:
    scene = _turning("2")
    start = read_start(scene, rates={"q_D": "7"})
    names = list(scene.velocities)

    assert start.u[names.index("q_D_dot")] == 7.0
    assert start.u[names.index("q_A_dot")] != pytest.approx(2.0)
    assert start.u == pytest.approx(read_start(crank_rocker(), rates={"q_D": "7"}).u, rel=1e-12)
    (note,) = [note for note in start.notes if "start rates" in note]
    assert "what is given leaves no choice of q_A_dot, 2 in the scene" in note


@pytest.mark.runs
def test_rates_of_the_scene_that_are_still_open_stay(capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "governor.toml")  # turns at 12 rad/s
    command = [
        "simulate",
        scene,
        "--until",
        "0.001",
        "--every",
        "0.001",
        "--method",
        "dop853",
        "--start-rates",
        "beta=3",
    ]
    assert main(command) == 0
    out, err = capsys.readouterr()
    names, first = (line.split(",") for line in out.splitlines()[:2])
    row = dict(zip(names, map(float, first), strict=True))

    assert row["phi_dot"] == 12.0
    assert row["alpha_dot"] == pytest.approx(3.0)
    assert "leaves no choice" not in err


PENDULUM = """
name = "stop"
gravity = [0, "-g", 0]
[parameters]
g = 9.81
[bodies.rod]
mass = 1
com = [0, -0.5, 0]
[joints.pin]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
start = {start}
limits = {{ lower = -1, upper = 0.5, velocity = 3, effort = 2 }}
"""


@pytest.mark.runs
@pytest.mark.mends("3.9")
@pytest.mark.parametrize("method", ["dop853", "taylor"])
def test_a_limit_of_a_joint_that_is_passed_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], method: str
) -> None:
    if method == "taylor":
        pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    scene = tmp_path / "stop.toml"
    scene.write_text(PENDULUM.format(start=0.4))
    push = "tau1=1.5+9*(0.5+tanh(400*(t-1))/2)" if method == "dop853" else "tau1=2.5"
    command = ["simulate", str(scene), "--method", method, "--ignore-limits", "--until"]
    assert main([*command, "0.8", "--forces", push]) == 0
    quiet = capsys.readouterr().err
    assert ("joint pin: upper limit 0.5 rad is passed at t = " in quiet) == (method == "taylor")

    scene.write_text(PENDULUM.format(start=1.2))
    assert main([*command, "1.2"]) == 0
    err = capsys.readouterr().err
    assert "joint pin: upper limit 0.5 rad is passed at the start" in err
    assert "joint pin: lower limit -1 rad is passed at t = " in err
    assert "joint pin: velocity limit 3 rad/s is passed at t = " in err


@pytest.mark.runs
def test_a_motion_within_its_limits_is_quiet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "stop.toml"
    scene.write_text(PENDULUM.format(start=0.5))  # it begins on its limit
    assert main(["simulate", str(scene), "--until", "2", "--method", "dop853", "-o", str(tmp_path / "a.csv")]) == 0
    assert "is passed" not in capsys.readouterr().err


@pytest.mark.runs
@pytest.mark.mends("3.12")
def test_a_spring_of_no_length_that_pulls_nowhere_there_has_a_force_and_an_energy(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Its ends lie 0.3 m from the hinge: P = c/2 |b - a|² = 9/10 (1 - cos q), and J q̈ = -9/10 sin q."""
    command = ["simulate", str(FOUND / "zero_spring.toml"), "--until", "1", "--every", "0.5", "--method", "dop853"]
    assert main(command) == 0
    out = capsys.readouterr().out
    names, *rows = (line.split(",") for line in out.splitlines())
    found = dict(zip(names, np.array(rows, dtype=float).T, strict=True))

    assert found["potential_energy"] == pytest.approx(0.9 * (1 - np.cos(found["q1"])), abs=1e-14)
    assert found["q1_ddot"] == pytest.approx(-0.9 / 0.11 * np.sin(found["q1"]), abs=1e-13)


@pytest.mark.mends("3.12")
@pytest.mark.parametrize("formulation", ["rnea", "lagrange"])
def test_a_spring_that_stiffens_has_a_force_where_its_ends_meet_by_every_formulation(
    tmp_path: Path, formulation: str
) -> None:
    file = tmp_path / "stiffens.toml"
    file.write_text((FOUND / "zero_spring.toml").read_text().replace("stiffness=10", "stiffness=[10, 5, 3]"))
    code = run_python(emit(lower(formulate(read(file), ("inverse_dynamics",), formulation)), "numpy"))

    assert code.inverse_dynamics([0.0], [0.0], [1.0]) == pytest.approx([0.11])  # J of the body alone
    s = 0.6 * np.sin(0.2)  # at 0.4 rad
    pulled = (10 * s + 5 * s**2 + 3 * s**3) * 0.3 * np.cos(0.2)
    assert code.inverse_dynamics([0.4], [0.0], [0.0]) == pytest.approx([pulled])


@pytest.mark.runs
@pytest.mark.mends("3.12")
def test_a_spring_of_no_length_that_pulls_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "pulls.toml"
    scene.write_text((FOUND / "zero_spring.toml").read_text() + "free = 0.1\n")
    assert main(["simulate", str(scene), "--until", "1"]) == 1
    assert "spring s has no length there, where it pulls (with free = 0 it would not; else" in capsys.readouterr().err


@pytest.mark.runs
@pytest.mark.mends("3.13")
def test_a_formula_without_a_real_value_is_named_with_what_helps(capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "pendulum.toml")
    assert main(["simulate", scene, "--until", "1", "--forces", "tau1=sqrt(q1 - 1)"]) == 1
    err = capsys.readouterr().err
    assert "sqrt(" in err
    assert "has no real value there" in err
    assert "give another start" in err


def test_a_start_that_is_no_start_is_refused_whole() -> None:
    with pytest.raises(SimulateError, match="q_Z is not known"):
        read_start(crank_rocker(), {"q_Z": "1"})


ROW = """
name = "row"
[bodies.a]
mass = 1
[bodies.b]
mass = 1
[joints.first]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
[joints.second]
type = "prismatic"
parent = "a"
child = "b"
axis = [0, 1, 0]
coordinate = "y"
[constraints.slip]
formula = "y_dot - 2*x_dot/x"
"""


@pytest.mark.mends("3.13")
def test_a_row_without_a_real_value_is_named_with_what_helps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "row.toml"
    scene.write_text(ROW)
    assert main(["simulate", str(scene), "--until", "1"]) == 1
    err = capsys.readouterr().err
    assert "the constraint slip has no real value at x = 0, y = 0; give the scene a start where it has one" in err
