"""A run stops where a joint reaches a limit of its position, and says so; whoever wants to goes on."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import METHODS, inverse, simulate
from symdyn.simulation.integrate import importable

EXAMPLES = Path(__file__).parents[1] / "examples"

SLIDE = """
name = "slide"
[parameters]
far = 2
[bodies.block]
mass = 1
com = [0, 0, 0]
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
limits = { lower = -1, upper = "far/2", velocity = 3, effort = 4 }
"""


@pytest.fixture(scope="module")
def slide() -> Scene:
    return read_text(SLIDE)


def _four_bar(limit: str) -> Scene:
    text = (EXAMPLES / "four_bar.toml").read_text()
    return read_text(text.replace("start = 2.0260131545490214846", f"start = 2.0260131545490214846\nlimits = {limit}"))


@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.parametrize("method", [name for name, one in METHODS.items() if one.finds_events])
def test_every_integrator_stops_at_a_limit_and_says_which_joint_which_limit_and_when(slide: Scene, method: str) -> None:
    """A block under a force of 2 N is 1 m away after 1 s, and 4 m after 2."""
    if not importable(METHODS[method].module):
        pytest.skip(f"{METHODS[method].library} is not installed")
    with pytest.warns(RuntimeWarning, match="joint rail reaches its upper limit 1 m at t = 1") as told:
        run = simulate(slide, forces="F=2", until=2.0, method=method)
    assert "ignore_limits=True" in str(told[0].message)
    assert "ignore_limits=True" in str(told[0].message)
    assert run.t[-1] == run.events[-1].t == pytest.approx(1.0, abs=1e-6)
    assert run["x"][-1] == pytest.approx(1.0, abs=2e-9)
    assert (run.complete, run.events[-1].stops, run.events[-1].formula) == (False, True, "joint rail: upper limit 1 m")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        on = simulate(slide, forces="F=2", until=2.0, method=method, ignore_limits=True)
    assert on.complete
    assert not on.events
    assert on["x"][-1] == pytest.approx(4.0, abs=1e-5)
    assert [note for note in on.notes if "rail: upper limit 1 m is passed at t = 1 s;" in note]


@pytest.mark.runs("cc")
def test_limits_of_velocity_and_effort_are_told_and_a_value_of_a_parameter_moves_the_stop(slide: Scene) -> None:
    said: list[str] = []
    run = simulate(slide, forces="F=5", until=2.0, method="dop853", values={"far": 3}, say=said.append)

    assert run.stopped.startswith("joint rail reaches its upper limit 1.5 m at t = 0.774596669")
    assert run.t[-1] == pytest.approx(np.sqrt(0.6))
    assert "joint rail: velocity limit 3 m/s is passed at t = 0.6 s" in "\n".join(said)
    assert "joint rail: effort limit 4 N is passed at the start" in "\n".join(said)


@pytest.mark.runs("cc")
def test_a_start_beyond_a_limit_is_told_and_the_run_stops_where_the_joint_passes_it_again(slide: Scene) -> None:
    said: list[str] = []
    run = simulate(
        slide, forces="F=-9*x", until=5.0, start={"x": "1.5"}, method="dop853", values={"far": 2}, say=said.append
    )
    assert "rail: upper limit 1 m is passed at the start; the run goes on until the joint has come back" in said[0]
    assert run.stopped.startswith("joint rail reaches its lower limit -1 m")

    run = simulate(slide, forces="F=-9*x", until=5.0, start={"x": "1.5"}, method="dop853", values={"far": 4}, say=print)
    assert run.t[-1] == pytest.approx(np.arccos(-1 / 1.5) / 3)


@pytest.mark.runs("cc")
def test_limits_that_are_reached_at_one_time_and_events_before_them_are_told_in_order(slide: Scene) -> None:
    """v² = 4 x under a force of 2 N: 2 m/s at 1 m."""
    text = SLIDE.replace("velocity = 3", "velocity = 2")
    for force, ending in (("F=2", "upper limit 1 m"), ("F=-2", "lower limit -1 m")):
        run = simulate(read_text(text), forces=force, until=2.0, method="dop853", reports="x**2 - 0.25", say=print)
        assert f"joint rail reaches its {ending} at t = " in run.stopped
        assert [event.formula for event in run.events] == ["x**2 - 0.25", f"joint rail: {ending}"]
        assert run.events[0].t == pytest.approx(np.sqrt(0.5))


@pytest.mark.runs("cc")
def test_a_start_on_a_limit_is_none_beyond_it(slide: Scene) -> None:
    resting = simulate(slide, until=1.0, start={"x": "1"}, method="dop853")
    assert resting.complete
    assert not resting.notes

    inwards = simulate(slide, forces="F=-1", until=1.0, start={"x": "1"}, method="dop853")
    assert inwards.complete


@pytest.mark.runs("cc")
@pytest.mark.long(0)
@pytest.mark.parametrize("method", ["taylor", "dop853", "ida"])
def test_a_joint_that_a_loop_leads_stops_the_mechanism(method: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip(f"{METHODS[method].library} is not installed")
    run = simulate(_four_bar("{ upper = 2.2 }"), forces="M=30", until=3.0, method=method, say=print)

    assert run.stopped.startswith("joint pivot reaches its upper limit 2.2 rad at t = 0.472244")
    assert run.t[-1] == pytest.approx(0.4722443208, abs=3e-9)
    assert run["chi"][-1] == pytest.approx(2.2, abs=1e-8)
    assert run.monitors["loops"] < 1e-9


@pytest.mark.runs("cc")
def test_a_follower_has_limits_of_its_own() -> None:
    text = SLIDE + (
        '[bodies.far_block]\nmass = 1\ncom = [0, 0, 0]\n[joints.arm]\ntype = "prismatic"\nparent = "ground"\n'
        'child = "far_block"\naxis = [0, 1, 0]\nmimic = { joint = "rail", ratio = -2 }\nlimits = { lower = -1 }\n'
    )
    run = simulate(read_text(text), forces="F=5", until=2.0, method="dop853", say=print)
    assert run.stopped.startswith("joint arm reaches its lower limit -1 m at t = 1 s,")
    assert run["x"][-1] == pytest.approx(0.5)


URDF = """<robot name="lever"><link name="base"/>
<link name="rod"><inertial><origin xyz="1 0 0"/><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="0.5" effort="100" velocity="1"/></joint></robot>"""

MJCF = """<mujoco><worldbody><body name="rod"><joint name="elbow" type="hinge" axis="0 1 0" range="-60 30"/>
<geom type="capsule" fromto="0 0 0 1 0 0" size="0.05"/></body></worldbody></mujoco>"""


@pytest.mark.runs("cc")
@pytest.mark.long
@pytest.mark.parametrize(("ending", "text", "limit"), [("urdf", URDF, 0.5), ("xml", MJCF, np.pi / 6)])
def test_limits_of_robot_files_stop_a_fall(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str, text: str, limit: float
) -> None:
    if ending == "xml":
        pytest.importorskip("mujoco")
    robot = tmp_path / f"lever.{ending}"
    robot.write_text(text)
    command = ["simulate", str(robot), "--until", "3", "--method", "dop853", "-o", str(tmp_path / "run.csv")]
    assert main(command) == 1
    told = capsys.readouterr().err
    assert f"joint elbow reaches its upper limit {limit:.6g} rad at t = " in told
    assert "Traceback" not in told
    assert main([*command, "--ignore-limits"]) == 0
    assert f"joint elbow: upper limit {limit:.6g} rad is passed at t = " in capsys.readouterr().err


@pytest.mark.runs("cc")
def test_inverse_tells_where_a_prescribed_motion_leaves_limits(slide: Scene) -> None:
    times = np.linspace(0.0, 3.0, 301)
    run = inverse(slide, {"x": "1.5*sin(pi*t)"}, times)
    told = "\n".join(run.notes)

    assert run.complete
    assert "joint rail: upper limit 1 m is passed at t = 0.24 s and 1 time more" in told  # asin(2/3)/π = 0.232
    assert "joint rail: lower limit -1 m is passed at t = 1.24 s;" in told
    assert "joint rail: velocity limit 3 m/s is passed at t = 0 s" in told
    assert "joint rail: effort limit 4 N is passed at t = " in told
    assert not inverse(slide, {"x": "0.1*sin(t)"}, times).notes
    assert not inverse(read(EXAMPLES / "pendulum.toml"), {"q1": "t"}, times).notes
