"""The verb `convert`, and the reading options that every verb takes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from symdyn.cli import main
from symdyn.scene import Written, read, toml, with_symbols

EXAMPLES = Path(__file__).parent.parent / "examples"
DATA = Path(__file__).parent / "data"
ROBOTS = [*sorted(DATA.glob("*.urdf")), *sorted(DATA.glob("*.par"))]
SCARA = str(EXAMPLES / "scara.toml")

INVALID = """
[bodies.wheel]
mass = 1
inertia = [1, 1, 3]
inertia_about = "com"
[joints.axle]
type = "revolute"
parent = "ground"
child = "wheel"
armature = 0.5
damping = 0.25
limits = { upper = 2, effort = 30 }
"""

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def invalid(tmp_path: Path) -> Path:
    path = tmp_path / "wheel.toml"
    path.write_text(INVALID, encoding="utf-8")
    return path


def test_convert_writes_the_same_scene_and_prints_the_path(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "arm.toml"

    assert main(["convert", SCARA, str(tmp_path / "new" / "arm.toml")]) == 1
    assert "there is no folder" in capsys.readouterr().err
    assert main(["convert", SCARA, str(out)]) == 0
    assert capsys.readouterr() == (f"{out}\n", "")
    assert read(out) == read(SCARA)


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.name)
def test_a_robot_file_becomes_toml_that_says_the_same(path: Path, tmp_path: Path) -> None:
    out = tmp_path / "robot.toml"

    assert main(["convert", str(path), str(out)]) == 0
    assert read(out) == read(path)


@pytest.mark.long
def test_a_robot_file_becomes_c_in_one_command(tmp_path: Path, capsys: Capture) -> None:
    urdf = next(path for path in ROBOTS if path.suffix == ".urdf")

    assert main(["generate", str(urdf), "--target", "c", "-o", str(tmp_path)]) == 0
    streams = capsys.readouterr()
    assert [Path(line).suffix for line in streams.out.splitlines()] == [".c", ".h", ".c", ".txt"]
    assert f"symdyn: {urdf.name}: 1.57079633 is read as pi/2" in streams.err
    assert f"symdyn generate {urdf.name} --target c\n" in Path(streams.out.split()[0]).read_text()


def test_convert_with_symbols_writes_names_and_values(tmp_path: Path) -> None:
    out = tmp_path / "arm.toml"

    assert main(["convert", SCARA, str(out), "--symbolic", "all"]) == 0
    assert read(out) == with_symbols(read(SCARA), "all")


def test_convert_never_overwrites_without_force(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "arm.toml"
    out.write_text("mine")

    assert main(["convert", SCARA, str(out)]) == 1
    assert capsys.readouterr().err == f"symdyn: {out} exists; give another name, or --force to overwrite it\n"
    assert out.read_text() == "mine"
    assert main(["convert", SCARA, str(out), "--force"]) == 0
    assert read(out) == read(SCARA)


def test_a_scene_with_faults_leaves_the_old_file_alone(invalid: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "arm.toml"
    out.write_text("mine")

    assert main(["convert", str(invalid), str(out), "--force"]) == 1
    assert "is not physically consistent" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.toml", "wheel.toml"]


@pytest.mark.parametrize(
    ("source", "out", "words"),
    [
        (SCARA, "arm.txt", "arm.txt: no format to write is known by this name; give it one of the extensions .toml"),
        (SCARA, "arm", "arm: no format to write is known by this name"),
        (SCARA, "arm.step", "arm.step: no format to write is known by this name"),
        ("nowhere.toml", "arm.toml", "nowhere.toml: there is no such file"),
        ("nowhere.urdf", "arm.toml", "nowhere.urdf: there is no such file"),
        ("robot.step", "arm.toml", 'robot.step: the extension ".step" names no format; there are .toml, .urdf'),
        ("page.xml", "arm.toml", "page.xml: has the root element <html>; expected one of <robot>, <mujoco>, <sdf>"),
        ("empty.xml", "arm.toml", "empty.xml: is empty; give a robot file"),
        ("open.xml", "arm.toml", "open.xml: line 1, column 10: is not well-formed XML"),
    ],
)
def test_a_file_of_no_known_format_is_one_line(
    source: str, out: str, words: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robot.step").write_text("ISO-10303-21;")
    Path("page.xml").write_text('<?xml version="1.0"?>\n<!-- <robot> -->\n<!DOCTYPE html>\n<html><robot/></html>')
    Path("empty.xml").write_text("")
    Path("open.xml").write_text("<!-- " * 1000)

    assert main(["convert", source, out]) == 1
    streams = capsys.readouterr()
    assert words in streams.err
    assert len(streams.err.splitlines()) == 1
    assert not Path(out).exists()


def test_what_a_format_cannot_hold_is_refused_or_listed(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = ("scara: points cannot be said", "scara: gravity cannot be said")
    monkeypatch.setattr(toml, "write_text", lambda scene: Written(scene.name, lost))
    out = tmp_path / "arm.toml"

    assert main(["convert", SCARA, str(out)]) == 1
    assert capsys.readouterr().err == (
        "symdyn: scara: points cannot be said\n"
        "scara: gravity cannot be said\n"
        "scara: toml cannot hold all of this; --lossy leaves it out\n"
    )
    assert not out.exists()
    assert main(["convert", SCARA, str(out), "--lossy"]) == 0
    assert capsys.readouterr().err == "".join(f"symdyn: left out: {line}\n" for line in lost)
    assert out.read_text() == "scara"


# Options of every verb


@pytest.mark.parametrize("verb", ["equations", "generate", "verify", "info", "convert"])
def test_every_verb_that_reads_takes_the_reading_options(verb: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([verb, "--help"])

    shown = capsys.readouterr().out
    assert all(option in shown for option in ("--symbolic", "--no-snap", "--allow-invalid-inertia"))


def test_an_invalid_inertia_is_an_error_or_a_note(invalid: Path, capsys: Capture) -> None:
    assert main(["info", str(invalid)]) == 1
    assert "Ixx + Iyy >= Izz" in capsys.readouterr().err
    assert main(["info", str(invalid), "--allow-invalid-inertia"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(
        f"symdyn: {invalid.name}: bodies.wheel: inertia (as given) is not physically consistent: "
    )
    assert lines[0].endswith("; kept as it is")


def test_an_excused_inertia_is_written_as_excused(invalid: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.toml"

    assert main(["convert", str(invalid), str(out), "--allow-invalid-inertia"]) == 0
    assert read(out) == read(invalid, allow_invalid_inertia=True)
    assert read(out).bodies[0].allow_invalid_inertia


def test_a_generated_file_names_the_options_that_it_was_read_with(invalid: Path, tmp_path: Path) -> None:
    options = ["--symbolic", "inertia", "--no-snap", "--allow-invalid-inertia"]

    assert main(["generate", str(invalid), *options, "--functions", "mass_matrix", "-o", str(tmp_path)]) == 0
    words = "symdyn generate wheel.toml --symbolic inertia --no-snap --allow-invalid-inertia --target numpy"
    assert f"{words} --functions mass_matrix\n" in (tmp_path / "wheel.py").read_text()


def test_symbols_are_printed(capsys: Capture) -> None:
    assert main(["equations", str(EXAMPLES / "scara.toml"), "--symbolic", "all", "--format", "text"]) == 0
    assert "(m3 + m4)*q3_ddot - (m3 + m4)*g = tau3\n" in capsys.readouterr().out


def test_many_notes_are_cut_short(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "many.toml"
    links = range(25)
    path.write_text(
        "".join(f'[bodies.b{i}]\nmass = 1\ninertia = [1, 1, 3]\ninertia_about = "com"\n' for i in links)
        + "".join(f'[joints.j{i}]\ntype = "revolute"\nparent = "ground"\nchild = "b{i}"\n' for i in links)
    )
    assert main(["convert", str(path), str(tmp_path / "out.toml"), "--allow-invalid-inertia"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 21
    assert lines[-1] == f"symdyn: {path.name}: and 5 notes more"


def test_info_shows_rotors_dampers_limits_and_followers(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "hand.toml"
    path.write_text(
        INVALID.replace("[1, 1, 3]", "[1, 1, 2]")
        + '[bodies.motor]\nmass = 1\n[joints.gear]\ntype = "revolute"\nparent = "ground"\nchild = "motor"\n'
        'mimic = { joint = "axle", ratio = "-1/2" }\n'
    )
    assert main(["info", str(path)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "axle: revolute, q1 in rad, armature 0.5, damping 0.25, from -oo to 2, effort up to 30" in shown
    assert "gear: revolute, follows q1: ratio -0.5, offset 0" in shown
    assert main(["info", str(path), "--json"]) == 0
    axle, gear = json.loads(capsys.readouterr().out)["result"]["joints"]
    limits = {"lower": None, "upper": "2", "velocity": None, "effort": "30", "restitution": None, "one_way": False}
    assert axle["limits"] == limits
    assert (axle["armature"], axle["mimic"]) == ("0.5", None)
    assert gear["mimic"] == {"ratios": {"q1": "-0.5"}, "offset": "0"}
