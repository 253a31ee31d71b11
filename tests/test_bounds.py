"""Sizes have bounds that are told, numbers without a value are told where they stand, and no work grows past use."""

from __future__ import annotations

import difflib
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import pytest

from symdyn.cli import main
from symdyn.dynamics import available
from symdyn.emit.code.identifiers import stem
from symdyn.errors import SceneError
from symdyn.scene import read
from symdyn.scene.toml import read_text
from symdyn.teach.student.grammar import Names

EXAMPLES = Path(__file__).parent.parent / "examples"

ARM = """
name = "arm"
gravity = [0, 0, -9.81]

[parameters]
a = {{ value = {a} }}

[bodies.b]
mass = 1
com = [{com}, 0, 0]

[joints.j]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 1, 0]
coordinate = "q1"
"""

TINY = '"log(1e-400)"'


def chain(bodies: int) -> str:
    parents = ["ground", *(f"b{i}" for i in range(bodies))]
    parts = (
        f'[bodies.b{i}]\nmass = 1\ncom = [1, 0, 0]\n[joints.j{i}]\ntype = "revolute"\nparent = "{parents[i]}"\n'
        f'child = "b{i}"\naxis = [0, {i % 2}, {1 - i % 2}]\n'
        for i in range(bodies)
    )
    return 'name = "chain"\ngravity = [0, 0, -9.81]\n' + "".join(parts)


def refused(text: str) -> str:
    """Return the message about a scene that cannot be read."""
    with pytest.raises(SceneError) as caught:
        read_text(text)
    return str(caught.value)


def said(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return what a command says when it ends with our error."""
    assert main(words) in (1, 2)
    return capsys.readouterr().err


# Numbers without a value


@pytest.mark.mends("2.log")
@pytest.mark.parametrize(("a", "com"), [(TINY, 1), (1, TINY)])
def test_a_number_below_all_doubles_is_told_where_it_stands(a: object, com: object) -> None:
    message = refused(ARM.format(a=a, com=com))

    assert "smallest double" in message
    assert "com" in message or "parameters.a" in message


@pytest.mark.mends("2.log")
@pytest.mark.parametrize(
    "words",
    [
        ["draw", "{arm}", "--at", "q1=log(1e-400)"],
        ["simulate", "{arm}", "--until", "1", "--start", "q1=log(1e-400)"],
        ["info", "{arm}", "--bind", "a=log(1e-400)"],
    ],
)
def test_options_tell_a_number_below_all_doubles(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arm = tmp_path / "arm.toml"
    arm.write_text(ARM.format(a=1, com=1), encoding="utf-8")

    assert "smallest double" in said([word.format(arm=arm) for word in words], capsys)


@pytest.mark.mends("2.axis")
def test_an_axis_names_no_symbol(tmp_path: Path) -> None:
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8").replace("axis = [0, 0, 1]", 'axis = ["none", 0, 1]')

    assert "none" in refused(text)


@pytest.mark.mends("2.overflow")
def test_a_mass_that_no_double_holds_in_a_moment_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "heavy.toml"
    text = ARM.format(a=1, com=0).replace("mass = 1\n", "particles = [{ mass = 1.797e308, at = [1, 0, 0] }]\n")
    scene.write_text(text.replace("com = [0, 0, 0]\n", ""), encoding="utf-8")

    message = said(["walkthrough", str(scene), "--formulation", "dalembert", "-o", str(tmp_path / "lesson.md")], capsys)

    assert "largest double" in message


def test_an_arrow_that_no_double_holds_is_told_in_our_words_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "heavy.toml"
    scene.write_text(ARM.format(a=1, com=0.1).replace("mass = 1\n", "mass = 1.797e308\n"), encoding="utf-8")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        message = said(["walkthrough", str(scene), "-o", str(tmp_path / "lesson.md")], capsys)

    assert "largest double" in message


# Sizes


@pytest.mark.mends("2.nesting")
@pytest.mark.parametrize("line", ["mass" + ".a" * 400 + " = 1", "gravity = " + "[" * 300 + "]" * 300])
def test_nesting_and_parts_of_a_key_have_a_bound(line: str) -> None:
    message = refused(f'name = "deep"\n{line}\n')

    assert "deeper" in message or "401 parts" in message
    assert len(message) < 400


def test_no_comment_or_text_is_a_key_of_many_parts() -> None:
    dots = "a." * 40
    scene = read_text(ARM.format(a=1, com=1) + f'# {dots}\n[loads]\n[points.p]\nbody = "b"\nat = [1, 0, 0] # {dots}\n')

    assert scene.points[0].name == "p"


@pytest.mark.runs
@pytest.mark.mends("2.include")
def test_a_file_name_that_no_system_takes_is_told(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    robot = tmp_path / "robot.xml"
    robot.write_text(f'<mujoco><include file="{"9" * 400}"/><worldbody/></mujoco>', encoding="utf-8")

    with pytest.raises(SceneError):
        read(robot)


def large_toml(path: Path) -> None:
    path.write_text(ARM.format(a=1, com=1) + "#" * (5 * 2**20), encoding="utf-8")


def large_xml(path: Path) -> None:
    path.write_text('<robot name="r"><link name="a"/><!--' + "x" * (33 * 2**20) + "--></robot>", encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "fill"),
    [pytest.param("a.toml", large_toml, marks=pytest.mark.mends("2.bytes")), ("a.urdf", large_xml)],
)
def test_files_have_a_bound_of_bytes(name: str, fill: Callable[[Path], None], tmp_path: Path) -> None:
    fill(tmp_path / name)

    with pytest.raises(SceneError, match="holds more than"):
        read(tmp_path / name)


@pytest.mark.long
@pytest.mark.mends("2.bytes")
@pytest.mark.parametrize("words", [["simulate", "--until", "1", "--forces"], ["inverse", "--motion"]])
def test_files_of_numbers_have_a_bound_of_bytes(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = tmp_path / "columns.csv"
    with columns.open("wb") as file:
        file.truncate(65 * 2**20)

    message = said([words[0], str(EXAMPLES / "pendulum.toml"), *words[1:], str(columns)], capsys)

    assert "holds more than" in message


@pytest.mark.mends("2.csv")
def test_a_cell_that_the_reader_of_columns_refuses_is_our_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = tmp_path / "columns.csv"
    columns.write_text(f"t,q1\n0,{'1' * 200_000}\n1,1\n", encoding="utf-8")

    assert "no CSV" in said(["inverse", str(EXAMPLES / "pendulum.toml"), "--motion", str(columns)], capsys)


@pytest.mark.mends("2.values")
def test_values_have_a_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.scene.toml.MOST_VALUES", 100, raising=False)

    assert "holds more than 100 values" in refused('name = "x"\ngravity = [' + "1," * 101 + "]\n")


@pytest.mark.mends("2.particles")
def test_particles_of_a_body_have_a_bound() -> None:
    many = ", ".join("{ mass = 1, at = [1, 0, 0] }" for _ in range(501))
    text = ARM.format(a=1, com=0).replace("mass = 1\ncom = [0, 0, 0]\n", f"particles = [{many}]\n")

    assert "501; 500 are allowed" in refused(text)


UNKNOWN_BODIES = "".join(f'[joints.k{i}]\ntype = "fixed"\nparent = "x{i}"\nchild = "y{i}"\n' for i in range(150))
UNKNOWN_KEYS = "".join(f"key{i} = 1\n" for i in range(150))
UNKNOWN_TABLES = "".join(f"[a{i}.b.c]\n" for i in range(150))
UNKNOWN_SYMBOLS = "".join(f'[bodies.c{i}]\nmass = "x{i}"\n' for i in range(150))


@pytest.mark.mends("2.faults")
@pytest.mark.parametrize("tail", [UNKNOWN_BODIES, UNKNOWN_KEYS, UNKNOWN_TABLES, UNKNOWN_SYMBOLS])
def test_a_file_that_is_broken_as_a_whole_is_not_read_to_its_end(tail: str) -> None:
    lines = refused(ARM.format(a=1, com=1) + tail).splitlines()

    assert len(lines) == 101
    assert "mend these first" in lines[-1]


@pytest.mark.mends("2.near")
def test_the_search_for_a_near_name_has_a_bound() -> None:
    known = "".join(f"length{i} = {{ value = 1 }}\n" for i in range(1000))
    text = ARM.format(a=1, com='"lenght7"').replace("[bodies.b]", f"{known}[bodies.b]")
    compare = difflib.SequenceMatcher.real_quick_ratio

    with patch.object(difflib.SequenceMatcher, "real_quick_ratio", autospec=True, side_effect=compare) as compared:
        message = refused(text)

    assert "did you mean length7?" in message or "length7" in message
    assert compared.call_count <= 100


@pytest.mark.mends("2.student")
def test_a_long_word_of_a_student_is_cut_in_linear_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    homework = tmp_path / "homework.txt"
    homework.write_text(f"k_{{z,11}} = m_{'x' * 800}\n", encoding="utf-8")
    look = Names._piece

    with patch.object(Names, "_piece", autospec=True, side_effect=look) as looked:
        message = said(["check-derivation", str(homework), str(EXAMPLES / "two_link.toml")], capsys)

    assert "is no symbol of two_link" in message
    assert len(message) < 700
    assert looked.call_count < 50_000


# Long chains


@pytest.mark.mends("2.chain")
def test_functions_with_squares_of_entries_are_left_out_of_long_chains_unless_asked_for() -> None:
    outputs, left_out = available(read_text(chain(201)))

    assert {"inverse_dynamics", "forward_dynamics", "gravity_forces"} <= set(outputs)
    assert {"mass_matrix", "k_z"}.isdisjoint(outputs)
    assert any("mass_matrix" in reason and "ask with functions" in reason for reason in left_out)


def test_info_says_what_it_does_not_count_for_long_chains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("symdyn.dynamics.outputs.derive.Requested.LARGEST", 3)
    monkeypatch.setattr("symdyn.cli.info.MOST_NESTED", 3, raising=False)
    path = tmp_path / "chain.toml"
    path.write_text(chain(4), encoding="utf-8")

    assert main(["info", str(path)]) == 0

    out, err = capsys.readouterr()
    assert "b2 <- b3" in out
    assert "mass_matrix" in err
    assert "as derived" in err


def test_the_nodes_of_a_chain_grow_as_its_bodies() -> None:
    from symdyn.dynamics import derive

    short, long = (len(derive(read_text(chain(n)), ["inverse_dynamics"]).graph.nodes) for n in (20, 80))

    assert long < 4.5 * short


# Commas and file names


@pytest.mark.mends("2.comma")
def test_a_comma_inside_a_function_parts_no_coordinates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pictures = []
    for at in ("q1=atan2(1, 1), q2=0.2", "q1=pi/4,q2=0.2"):
        assert main(["draw", str(EXAMPLES / "two_link.toml"), "--at", at]) == 0
        pictures.append(capsys.readouterr().out)

    assert pictures[0] == pictures[1]


@pytest.mark.mends("2.device")
@pytest.mark.parametrize("name", ["CON", "nul", "Aux", "COM1", "lpt9"])
def test_no_file_is_called_as_a_device_of_windows(name: str) -> None:
    assert stem(name) == f"{name}_"


@pytest.mark.mends("2.device")
def test_no_scene_begins_as_a_device_of_windows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    assert "device" in said(["new", "CON"], capsys)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
@pytest.mark.mends("2.device")
@pytest.mark.parametrize("format", ["md", "html", "latex", "notebook"])
def test_no_lesson_is_called_as_a_device_of_windows(format: str) -> None:
    from symdyn.teach import rendered, walkthrough

    scene = read_text(ARM.format(a=1, com=1).replace('"arm"', '"CON"'))

    names = rendered(walkthrough(scene), format)

    assert not [name for name in names if name.split(".")[0].upper() == "CON"]


def test_a_lesson_shows_the_pictures_that_stand_beside_it() -> None:
    from symdyn.teach import rendered, walkthrough

    files = rendered(walkthrough(read_text(ARM.format(a=1, com=1).replace('"arm"', '"CON"'))), "md")

    assert set(re.findall(r"\]\((.*?\.svg)\)", files["CON_.md"])) == {name for name in files if name.endswith(".svg")}
