"""Columns of a motion beside its coordinates: points, multipliers, reactions in the axes asked for."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"


def _columns(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, np.ndarray]:
    """Return the columns that a command prints, by name."""
    assert main([*words]) == 0, capsys.readouterr().err
    rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    table = np.array([[float(cell) for cell in row] for row in rows[1:]])
    return dict(zip(rows[0], table.T, strict=True))


@pytest.mark.mends("3.11")
@pytest.mark.parametrize("verb", ["simulate", "inverse"])
def test_declared_points_have_columns_in_ground_axes(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "double_pendulum.toml")
    given = (
        ["--start", "q1=0.7,q2=0.4", "--method", "dop853"] if verb == "simulate" else ["--motion", "q1=t+0.7", "q2=0.4"]
    )
    found = _columns(capsys, verb, scene, *given, "--until", "0.2", "--every", "0.1")

    assert {"point_tip_x", "point_tip_y", "point_tip_z"} <= set(found)
    q1, q2 = found["q1"], found["q1"] + found["q2"]
    assert np.hypot(found["point_tip_x"], found["point_tip_y"]) == pytest.approx(
        np.abs(0.6 * np.exp(1j * q1) + 0.5 * np.exp(1j * q2)), rel=1e-12
    )


@pytest.mark.mends("3.11")
@pytest.mark.parametrize("verb", ["simulate", "inverse"])
def test_multipliers_are_the_wrench_of_their_loop_in_axes_of_the_joint(
    verb: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = str(EXAMPLES / "four_bar.toml")
    given = ["--forces", "M=3", "--method", "dop853"] if verb == "simulate" else ["--motion", "phi=0.8+t**2"]
    try:
        found = _columns(capsys, verb, scene, *given, "--until", "0.2", "--every", "0.1", "--reactions", "joint")
    except SystemExit:
        pytest.fail("--reactions takes no axes")

    for axis in "xy":
        assert found[f"multiplier_hinge_f{axis}_joint"] == pytest.approx(
            found[f"reaction_hinge_f{axis}_joint"], abs=1e-9
        )
        assert np.abs(found[f"multiplier_hinge_f{axis}_joint"]).min() > 0.1


@pytest.mark.mends("3.11")
def test_reactions_are_told_in_three_kinds_of_axes(capsys: pytest.CaptureFixture[str]) -> None:
    """One force, turned: its size stays, its components do not."""
    scene = str(EXAMPLES / "double_pendulum.toml")
    run = (
        "simulate",
        scene,
        "--start",
        "q1=0.7",
        "--until",
        "0.1",
        "--every",
        "0.1",
        "--method",
        "dop853",
        "--reactions",
    )
    try:
        body, joint, ground = (_columns(capsys, *run, *axes) for axes in ([], ["joint"], ["ground"]))
    except SystemExit:
        pytest.fail("--reactions takes no axes")

    sizes = [
        np.linalg.norm([found[f"reaction_lower_f{axis}{ending}"] for axis in "xyz"], axis=0)
        for found, ending in ((body, ""), (joint, "_joint"), (ground, "_ground"))
    ]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-9)
    assert sizes[2] == pytest.approx(sizes[0], rel=1e-9)
    assert not np.allclose(body["reaction_lower_fx"], ground["reaction_lower_fx_ground"], rtol=1e-3)


def test_the_contact_of_a_wheel_names_its_directions(capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "rolling_disc.toml")
    found = _columns(capsys, "simulate", scene, "--until", "0.1", "--every", "0.1", "--method", "dop853", "--reactions")

    names = [name for name in found if name.startswith("multiplier")]
    assert names == ["multiplier_contact_along", "multiplier_contact_across", "multiplier_contact_normal"]


def test_axes_that_do_not_exist_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(EXAMPLES / "pendulum.toml"), "--until", "1", "--reactions", "parent"]) == 1
    assert 'reactions: "parent" are no axes; write body, joint or ground' in capsys.readouterr().err


def test_axes_that_do_not_exist_are_told_with_all_other_faults() -> None:
    with pytest.raises(SimulateError, match=r"until = -1 s is not a time after the start(.|\n)*\"parent\" are no axes"):
        symdyn.simulate(symdyn.read(EXAMPLES / "pendulum.toml"), until=-1.0, reactions="parent")
