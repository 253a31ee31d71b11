"""One door for every format: the extension says which, for .xml the root element."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.errors import SceneError
from symdyn.scene import read, read_noting, scene_of

DATA = Path(__file__).parent / "data"
URDF = DATA / "gripper_arm.urdf"

HOLLOW = """<robot name="hollow"><link name="base"/>
<link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>
"""


@pytest.mark.parametrize(
    "prolog",
    ["", "\ufeff", '<?xml version="1.0"?>\n', "<!-- <mujoco> -->\n<!-- <sdf> -->\n  ", " \n\t" * 1000],
    ids=["none", "mark", "declaration", "comments", "space"],
)
def test_an_xml_file_is_what_its_root_element_says(prolog, tmp_path):
    path = tmp_path / "robot.xml"
    text = URDF.read_text(encoding="utf-8")
    path.write_text(prolog + text[text.index("<robot") :], encoding="utf-8")

    assert read(path) == read(URDF)


def test_extensions_may_be_capitals(tmp_path):
    path = tmp_path / "ROBOT.URDF"
    path.write_bytes(URDF.read_bytes())

    assert read(path) == read(URDF)


def test_sdf_is_known_by_its_root(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text('<sdf version="1.9"><model name="m"/></sdf>')

    with pytest.raises(SceneError, match=r"robot\.xml: line 1: model: there is no <link>"):
        read(path)


def test_snapping_can_be_turned_off():
    snapped, kept = read_noting(URDF), read_noting(URDF, snap=False)

    assert any(" is read as pi/2" in note for note in snapped.notes)
    assert not any(" is read as " in note and "pi" in note for note in kept.notes)
    assert snapped.scene != kept.scene
    assert all(note.startswith(f"{URDF}: ") for note in (*snapped.notes, *kept.notes))


def test_an_invalid_inertia_of_a_robot_file_says_how_to_read_it_all_the_same(tmp_path):
    path = tmp_path / "hollow.urdf"
    path.write_text(HOLLOW)

    with pytest.raises(SceneError, match=r"Ixx \+ Iyy >= Izz .* or read with allow_invalid_inertia=True$"):
        read(path)
    reading = read_noting(path, allow_invalid_inertia=True)
    assert [body.allow_invalid_inertia for body in reading.scene.bodies] == [True]
    assert reading.scene == read(path, allow_invalid_inertia=True)
    assert [note for note in reading.notes if note.endswith("; kept as it is")]


@pytest.mark.runs
def test_a_reader_is_imported_when_its_format_is_met(tmp_path):
    path = tmp_path / "hollow.toml"
    path.write_text('[bodies.a]\n[joints.b]\ntype = "revolute"\nparent = "ground"\nchild = "a"\n')
    code = f"import sys, symdyn; symdyn.read({str(path)!r}); print([m for m in sys.modules if 'formats' in m])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=dict(os.environ))

    assert run.stdout.strip() == "[]"


def test_a_document_type_in_a_file_called_xml_is_told_as_such(tmp_path):
    path = tmp_path / "bomb.xml"
    path.write_text('<!DOCTYPE l [<!ENTITY a "aa">]><robot/>')

    with pytest.raises(SceneError, match=r"bomb.xml: .*DOCTYPE"):
        read(path)


TOML = Path(__file__).parent.parent / "examples" / "two_link.toml"


@pytest.mark.parametrize("path", [TOML, URDF, DATA / "tree.par"], ids=lambda path: path.suffix)
@pytest.mark.parametrize("mode", ["r", "rb"])
def test_an_open_file_is_the_scene_that_its_name_says(path, mode):
    with path.open(mode) as file:
        assert scene_of(file) == read(path)


def test_an_open_file_without_a_name_is_toml_or_what_its_root_element_says():
    nameless = io.StringIO(TOML.read_text(encoding="utf-8")), io.BytesIO(TOML.read_bytes())
    assert all(read(file) == read(TOML) for file in nameless)
    assert read(io.BytesIO(b"\xef\xbb\xbf \n" + URDF.read_bytes())) == read(URDF)
    numbered = os.fdopen(os.open(TOML, os.O_RDONLY))  # its name is a number
    with numbered:
        assert read(numbered) == read(TOML)


def test_text_has_been_decoded_whatever_encoding_its_declaration_tells():
    text = URDF.read_text(encoding="utf-8")
    text = '<?xml version="1.0" encoding="UTF-16"?>\n' + text[text.index("<robot") :]

    assert read(named(text, "arm.urdf")) == read(URDF)


def test_an_open_mjcf_file_finds_what_it_includes_beside_it(tmp_path):
    pytest.importorskip("mujoco")
    body = '<body name="a"><joint name="j" axis="0 0 1"/><inertial pos="1 0 0" mass="1" diaginertia="1 1 1"/></body>'
    (tmp_path / "arm.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>", encoding="utf-8")
    path = tmp_path / "world.xml"
    path.write_text('<mujoco><include file="arm.xml"/></mujoco>', encoding="utf-8")
    with path.open() as file:
        assert read(file) == read(path)


def test_a_scene_is_itself_and_a_path_may_be_text():
    scene = read(TOML)
    assert scene_of(scene) is scene
    assert scene_of(str(TOML)) == scene_of(TOML) == scene


def closed():
    file = io.StringIO("")
    file.close()
    return file


def numbers():
    file = io.StringIO("")
    file.read = lambda size: 1  # type: ignore[method-assign,assignment]
    return file


def named(text, name):
    file = io.StringIO(text)
    file.name = name  # type: ignore[attr-defined]
    return file


@pytest.mark.parametrize(
    ("source", "told"),
    [
        (None, r"None is no scene; give a Scene, the path of a file such as arm\.toml, or an open file"),
        (3, "3 is no scene"),
        ({"name": "a"}, r'\{name = "a"\} is no scene'),
        ([TOML], "is no scene"),
        (io.StringIO(""), r"scene: nothing is left to be read; an open file is read once, seek\(0\) goes back"),
        (closed(), "scene: cannot be read .*closed file"),
        (numbers(), "scene: gives int to be read; give a file opened for text or bytes"),
        (io.BytesIO(b"name = '\xff'"), "byte 8 is not UTF-8"),
        (io.StringIO("name = '\udcff'"), "is not UTF-8"),
        (io.StringIO("<plan/>"), r"has the root element <plan>; expected one of <robot>"),
        (named("x = 1", "<stdin>"), r'^<stdin>:1: unknown key "x"'),
        (named("x = 1", "a\x1b[2J.toml"), r"^a\\x1b\[2J\.toml:1: unknown key"),
        (named("<mujoco", "a.urdf"), r"^a\.urdf: line 1, column 1: is not well-formed XML"),
        (io.StringIO("#" * (2**22 + 1)), "holds more than 4 MB"),
    ],
)
def test_what_is_no_scene_is_told_in_one_line(source, told):
    with pytest.raises(SceneError, match=told) as caught:
        scene_of(source)

    assert caught.value.faults


@pytest.mark.runs
def test_every_door_takes_a_path_and_an_open_file(tmp_path):
    import inspect

    import symdyn
    from symdyn.scene import SceneLike

    doors = [getattr(symdyn, name) for name in symdyn.__all__]
    first = {door.__name__: next(iter(inspect.signature(door).parameters.values())) for door in doors if callable(door)}
    takes = {name for name, one in first.items() if one.name == "scene"}
    assert takes == set(symdyn.__all__) - {"Feedback", "Scene", "SymdynError", "example", "pid", "read"}
    kinds = {str(first[name].annotation) for name in takes - {"Problem"}}
    assert kinds == {"SceneLike", "SceneLike | Problem", "SceneLike | Moved"}
    assert SceneLike
    with TOML.open() as file:
        assert symdyn.dynamics.derive(file, ["mass_matrix"]).scene == read(TOML)
    assert symdyn.picture(TOML) == symdyn.picture(read(TOML))
