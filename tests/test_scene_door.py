"""One door for every format: the extension says which, for .xml the root element."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from symdyn.errors import SceneError
from symdyn.scene import ReadOptions, read, read_noting

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


def test_sdf_is_refused_with_the_way_out(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text('<sdf version="1.9"><model name="m"/></sdf>')

    with pytest.raises(SceneError, match=r"robot\.xml: is SDF, which is not read here.* give the URDF"):
        read(path)


def test_snapping_can_be_turned_off():
    snapped, kept = read_noting(URDF), read_noting(URDF, ReadOptions(snap=False))

    assert any(" is read as pi/2" in note for note in snapped.notes)
    assert not any(" is read as " in note and "pi" in note for note in kept.notes)
    assert snapped.scene != kept.scene
    assert all(note.startswith(f"{URDF}: ") for note in (*snapped.notes, *kept.notes))


def test_an_invalid_inertia_of_a_robot_file_says_how_to_read_it_all_the_same(tmp_path):
    path = tmp_path / "hollow.urdf"
    path.write_text(HOLLOW)

    with pytest.raises(SceneError, match=r"Ixx \+ Iyy >= Izz .* or read with --allow-invalid-inertia$"):
        read(path)
    reading = read_noting(path, ReadOptions(allow_invalid_inertia=True))
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
