"""Laws of motion and what follows from them through rows: integrated, solved, or refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import inverse, read_motion, simulate
from symdyn.simulation.trajectory import Trajectory

pytestmark = pytest.mark.runs()

ROOT = Path(__file__).parent.parent
FOUND, EXAMPLES = ROOT / "tests" / "data" / "found", ROOT / "examples"

SLIDER_CRANK = """
name = "slider_crank"
gravity = [0, -9.81, 0]
[bodies.crank]
mass = 1
[bodies.rod]
mass = 2
com = [0.5, 0, 0]
[bodies.piston]
mass = 1.5
[joints.A]
type = "revolute"
parent = "ground"
child = "crank"
coordinate = "q1"
drive = false
start = 0.6
[joints.B]
type = "revolute"
parent = "crank"
child = "rod"
origin = [0.5, 0, 0]
coordinate = "q2"
drive = false
start = -0.9
[joints.P]
type = "prismatic"
parent = "ground"
child = "piston"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
start = 1.3
[[loop]]
name = "C"
type = "revolute"
parent = "rod"
child = "piston"
origin = [1, 0, 0]
"""


def followed(scene: Scene, *laws: str, until: float = 1.0, count: int = 11) -> Trajectory:
    return inverse(scene, read_motion(scene, laws), np.linspace(0.0, until, count))  # type: ignore[operator]


@pytest.mark.mends("3.3")
@pytest.mark.parametrize("path", [EXAMPLES / "cart_with_wheel.toml", FOUND / "rolling_cart.toml"], ids=lambda p: p.stem)
def test_a_wheel_under_a_cart_turns_as_far_as_it_rolls(path: Path) -> None:
    found = followed(read(path), "x=t**2")

    assert found["phi"] == pytest.approx(5 * found.t**2, abs=1e-12)
    assert found["phi_dot"] == pytest.approx(10 * found.t, abs=1e-12)
    assert found["phi_ddot"] == pytest.approx(np.full(11, 10.0), abs=1e-12)


@pytest.mark.mends("3.3")
def test_laws_that_leave_motions_open_are_refused() -> None:
    with pytest.raises(SimulateError, match=r"laws are missing: 2 freedoms of rolling_disc are left.*give 2 more"):
        followed(read(EXAMPLES / "rolling_disc.toml"), "x=t")


def test_a_quaternion_with_a_part_of_its_laws_is_refused() -> None:
    with pytest.raises(SimulateError, match=r"motion: e2, e3 missing; a quaternion moves as \(e0, e1, e2, e3\)"):
        followed(read(EXAMPLES / "rolling_disc.toml"), "e0=cos(t)", "e1=sin(t)")


@pytest.mark.mends("3.3")
def test_laws_that_slip_are_refused() -> None:
    with pytest.raises(SimulateError, match=r"t = 0 s: the loops and rows do not allow the velocities of x, phi"):
        followed(read(EXAMPLES / "cart_with_wheel.toml"), "x=t", "phi=t")


def disc() -> Scene:
    return read(FOUND / "rolling_disc_zxy.toml")


def test_a_disc_is_where_its_simulation_rolls_it(tmp_path: Path) -> None:
    """Forward and back: the angles of a free motion as laws give its path, and need no force."""
    scene = disc()
    rates = {"q1": "1", "q2": "0.5", "q3": "9"}
    free = simulate(scene, until=1.0, start_rates=rates, every=0.002)  # type: ignore[operator]
    table = tmp_path / "angles.csv"
    names = ["t", *(f"q{k}{end}" for end in ("", "_dot", "_ddot") for k in (1, 2, 3))]
    rows = np.column_stack([free.t, *(free[name] for name in names[1:])])
    table.write_text(
        "\n".join([",".join(names), *(",".join(map(repr, row)) for row in rows.tolist())]), encoding="utf-8"
    )
    found = inverse(scene, read_motion(scene, [str(table)]), free.t[::25])  # type: ignore[operator]

    for name in ("x", "y", "z", "x_dot", "y_dot", "x_ddot"):
        assert found[name] == pytest.approx(free[name][::25], abs=1e-7)
    assert np.abs(found.tau).max() < 1e-5


def test_a_height_is_solved_and_a_way_is_integrated() -> None:
    found = followed(disc(), "q1=0.3*t", "q2=0.1+0.05*sin(t)", "q3=2*t", until=2.0, count=21)
    fine = followed(disc(), "q1=0.3*t", "q2=0.1+0.05*sin(t)", "q3=2*t", until=2.0, count=2001)

    assert found["z"] == pytest.approx(0.26 * np.cos(found["q2"]), abs=1e-12)
    ends = followed(disc(), "q1=0.3*t", "q2=0.1+0.05*sin(t)", "q3=2*t", until=2.0, count=2)
    assert found["x"] == pytest.approx(fine["x"][::100], abs=1e-11)
    assert ends["x"] == pytest.approx(fine["x"][::2000], abs=1e-11)
    way = np.concatenate([[0.0], np.cumsum((fine["x_dot"][1:] + fine["x_dot"][:-1]) / 2 * 0.001)])
    assert fine["x"] == pytest.approx(way, abs=1e-6)


def test_quaternions_with_laws_roll_too() -> None:
    found = followed(
        read(EXAMPLES / "rolling_disc.toml"), "e0=cos(3*t)", "e1=0", "e2=sin(3*t)", "e3=0", until=1.0
    )  # upright, 6 rad/s

    assert found["x"] == pytest.approx(0.3 * 6 * found.t, abs=1e-10)
    assert found["z"] == pytest.approx(np.full(11, 0.3), abs=1e-12)
    assert found["flight_wy"] == pytest.approx(np.full(11, 6.0), abs=1e-12)


def test_what_no_row_knows_rests() -> None:
    text = (EXAMPLES / "cart_with_wheel.toml").read_text(encoding="utf-8")
    text += (
        '[bodies.bob]\nmass = 1\n[joints.arm]\ntype = "revolute"\nparent = "cart"\nchild = "bob"\ncoordinate = "a"\n'
    )
    found = followed(read_text(text, "cart.toml"), "x=t")

    assert not found["a"].any()
    assert any("no law is given for a: at rest" in note for note in found.notes)
    assert found["phi"][-1] == pytest.approx(5.0)


def test_idle_motions_are_least_and_told() -> None:
    found = followed(read(EXAMPLES / "rssr.toml"), "phi=0.2*t")

    assert any("idle: coupler spins about the line of its joints" in note for note in found.notes)
    assert not any("at rest" in note for note in found.notes)


def test_a_motion_in_which_a_wheel_comes_to_lie_flat_between_two_samples_ends_before() -> None:
    scene = read(FOUND / "rolling_disc_zxy.toml")

    with pytest.warns(RuntimeWarning, match=r"t = 1\.3708 s: contact contact: .* lies flat.*; the rows until"):
        found = followed(scene, "q1=0.001", "q2=0.2+t", "q3=0", until=2.0, count=6)

    assert found.t.tolist() == pytest.approx([0.0, 0.4, 0.8, 1.2])
    assert not found.complete


def test_loops_that_cannot_be_closed_any_more_end_the_rows() -> None:
    scene = read_text(SLIDER_CRANK, "slider_crank.toml")

    with pytest.warns(RuntimeWarning, match=r"t = 0\.\d+ s: the loops cannot be closed with x = "):
        found = followed(scene, "x=1.32+t")

    assert found.t.tolist() == pytest.approx([0.0, 0.1])  # the piston gets as far as 1.5 m
    assert np.isfinite(found.tau).all()


def test_a_dead_centre_where_no_force_gives_the_motion_ends_the_rows(tmp_path: Path) -> None:
    scene = read_text(SLIDER_CRANK, "slider_crank.toml")
    file, rows = tmp_path / "slider_crank.toml", tmp_path / "rows.csv"
    file.write_text(SLIDER_CRANK, encoding="utf-8")

    with pytest.raises(SimulateError, match=r"t = 0 s: no finite F gives slider_crank this .* dead centre"):
        followed(scene, "q1=t")
    done = main(["inverse", str(file), "--motion", "q1=0.5-t", "--until", "1", "--every", "0.1", "-o", str(rows)])

    assert done == 1
    assert len(rows.read_text(encoding="utf-8").splitlines()) == 1 + 5
    assert "nan" not in rows.read_text(encoding="utf-8")


@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("name", "start", "found"),
    [
        ("four_bar", {"chi": -2}, [-1.24565317, -2.19362291]),
        ("four_bar", {"chi": -2.1936}, [-1.24565317, -2.19362291]),
        ("four_bar", {}, [1.24565317, 2.19362291]),
        ("slider_crank", {"x": -0.1}, [-np.pi, -0.15]),
        ("slider_crank", {"x": 0.1}, [0.0, 0.25]),
    ],
)
def test_a_start_chooses_the_branch_that_a_simulation_from_there_has(
    name: str, start: dict[str, float], found: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    run, from_there = (
        inverse(scene, "phi=2*t", [0, 0.01], start=start),
        simulate(scene, start={"phi": 0, **start}, until=0.01),
    )
    assert run.q[0] == pytest.approx([0, *found], abs=1e-7)
    assert run.q[0] == pytest.approx(from_there.q[0], abs=1e-7)
    assert ("the others say where the assembly begins" in str(run.notes)) == bool(start)
    if start:
        (chosen,) = start.items()
        words = ["--motion", "phi=2*t", "--until", "0.01", "--start", "{}={}".format(*chosen)]
        assert main(["inverse", str(EXAMPLES / f"{name}.toml"), *words]) == 0
        row = capsys.readouterr().out.splitlines()[1].split(",")
        assert [float(x) for x in row[2:4]] == pytest.approx(found, abs=1e-7)


@pytest.mark.parametrize(
    ("motion", "start", "told"),
    [
        ("q1=30*t", {"q1": 1}, "start: q1 = 1 is not taken: its law begins at 0"),
        ("q1=30*t", {"q2_dot": 1}, "start: q2_dot is not taken: velocities follow from the motion"),
        ("q1=if(t>0.5,1,0)", {}, "motion: q1 jumps at t = 0.5 s; "),
        ("q1=if(t>1.5,1,0)", {"q1": 0}, ""),
        ("q1=abs(t-0.5)", {"q2": 1}, ""),
    ],
)
def test_notes_tell_what_a_motion_leaves_out(motion: str, start: dict[str, float], told: str) -> None:
    values = {"m1": 1, "m2": 1, "h1": 1, "h2": 1, "g": 9.81}
    at_rest, *rest = inverse(EXAMPLES / "two_link.toml", motion, [0, 0.3, 1], start=start, values=values).notes
    assert at_rest == "no law is given for q2: at rest"
    assert [one.startswith(told) for one in rest] == [True] * bool(told)
