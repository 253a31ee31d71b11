"""A small file fills no machine: what a few letters of it ask for is counted before it is made."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SceneError, SymdynError
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats import mjcf
from symdyn.scene.formats.urdf import read

MESH = """<robot name="r"><link name="base"/><link name="a"><inertial><mass value="1"/></inertial>
<visual><geometry><mesh filename="{name}"/></geometry></visual></link>
<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint></robot>"""

COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/></asset>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION"
source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>
</triangles></mesh></geometry></library_geometries><library_nodes>{nodes}</library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="top"><instance_node url="#{top}"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def shown(folder: Path, name: str) -> tuple[list[object], list[str]]:
    """Return what a robot's link shows of a mesh, and what is said of it."""
    from symdyn.draw.robot_meshes import robot_solids

    (folder / "r.urdf").write_text(MESH.format(name=name), encoding="utf-8")
    notes: list[str] = []
    solids = robot_solids(read(folder / "r.urdf", ReadOptions()).scene, notes.append)
    return [one for some in solids.values() for one in some], notes


def laughing(path: Path, levels: int, inside: str = '<instance_geometry url="#g"/>') -> None:
    """Write nodes of ten nodes of ten nodes."""
    nodes = [f'<node id="n0">{inside}</node>']
    for k in range(1, levels):
        ten = f'<instance_node url="#n{k - 1}"/>' * 10
        nodes.append(f'<node id="n{k}">{ten}</node>')
    path.write_text(COLLADA.format(nodes="".join(nodes), top=f"n{levels - 1}"), encoding="utf-8")


@pytest.mark.mends("30.attacks.4")
def test_nodes_of_nodes_are_counted_before_they_are_unfolded(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    laughing(tmp_path / "m.dae", 4, '<instance_geometry url="#g"/>' * 11)
    solids, notes = shown(tmp_path, "m.dae")

    assert solids == []
    assert "shows 11000 parts; 2000 are the most that is read" in notes[0]


def test_nodes_in_a_circle_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    laughing(tmp_path / "m.dae", 3, '<instance_node url="#n2"/>' * 10)
    solids, notes = shown(tmp_path, "m.dae")

    assert solids == []
    assert "levels deep" in notes[0]


def test_a_mesh_that_is_shown_a_few_times_is_shown(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    laughing(tmp_path / "m.dae", 3)

    assert len(shown(tmp_path, "m.dae")[0]) == 100


@pytest.mark.mends("30.attacks.4")
@pytest.mark.parametrize("blank", [" ", " \\\n", " \\\r\n"], ids=["one line", "lines", "lines of Windows"])
def test_a_face_of_an_obj_file_has_a_bound_of_corners(blank: str, tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf " + blank.join(["1 2 3"] * 400) + "\nf 1 2 3\n"
    (tmp_path / "m.obj").write_bytes(text.encode())
    solids, notes = shown(tmp_path, "m.obj")

    assert solids == []
    assert "a face of more than 1000 corners" in notes[0]


def test_many_short_faces_are_no_long_one(tmp_path: Path) -> None:
    pytest.importorskip("trimesh")
    for end in (b"\n", b"\r\n"):
        (tmp_path / "m.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + (b"f 1 2 3" + end) * 3000)

        assert shown(tmp_path, "m.obj")[0]


@pytest.mark.parametrize(
    ("asset", "said"),
    [
        pytest.param(
            '<hfield name="h" nrow="2100" ncol="2100" size="1 1 1 1"/>',
            "4410000 heights",
            marks=pytest.mark.mends("30.attacks.4"),
        ),
        pytest.param(
            '<mesh name="m" builtin="supersphere" params="201 1 1"/>',
            "40401 corners",
            marks=pytest.mark.mends("30.attacks.4"),
        ),
        ('<mesh name="m" builtin="supertorus" params="201 0.5 1 1"/>', "40401 corners"),
        ('<mesh name="m" builtin="wedge" params="250 250 60 60 0"/>', "62500 corners"),
        pytest.param('<mesh name="m" builtin="cone" params="40001 0.5"/>', "40001 corners", id="cone"),
        (
            "".join(f'<mesh name="{name}" builtin="supersphere" params="100 1 1"/>' for name in "mnopq"),
            "50000 corners",
        ),
    ],
)
def test_what_a_few_letters_make_has_a_bound(asset: str, said: str, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "m.xml"
    geom = '<geom type="mesh" mesh="m"/>' if "mesh" in asset else '<geom size="1"/>'
    world = f"<worldbody><body><joint/>{geom}</body></worldbody>"
    path.write_text(f"<mujoco><asset>{asset}</asset>{world}</mujoco>", encoding="utf-8")

    with pytest.raises(SceneError, match=said):
        mjcf.read(path, ReadOptions())


def test_small_ones_are_made(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "m.xml"
    assets = '<hfield name="h" nrow="99" ncol="99" size="1 1 1 1"/>'
    assets += '<mesh name="m" builtin="wedge" params="9 9 60 60 0"/>'
    world = '<worldbody><body><joint/><geom type="mesh" mesh="m"/></body></worldbody>'
    path.write_text(f"<mujoco><asset>{assets}</asset>{world}</mujoco>", encoding="utf-8")

    assert mjcf.read(path, ReadOptions()).scene.bodies


@pytest.mark.mends("30.also.bounds-of-meshes")
@pytest.mark.mends("30.class.believed")
@pytest.mark.long
@pytest.mark.parametrize("kind", ["parts.obj", "corners.obj", "faces.obj", "binary.stl", "text.stl"])
def test_a_mesh_of_too_many_parts_or_triangles_is_refused_before_it_is_loaded(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trimesh = pytest.importorskip("trimesh")
    number = 1_000_001
    corners, facet = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", b"facet normal 0 0 1 outer loop endloop endfacet\n"
    content: dict[str, Callable[[], bytes]] = {
        "parts.obj": lambda: corners + b"".join(b"g g%d\nusemtl m%d\nf 1 2 3\n" % (k, k) for k in range(11_000)),
        "corners.obj": lambda: corners + (b"f" + b" 1 2 3" * 300 + b"\n") * (number // 898 + 1),
        "faces.obj": lambda: corners + b"f 1 2 3\n" * number,
        "binary.stl": lambda: b" " * 80 + number.to_bytes(4, "little") + bytes(50 * number),
        "text.stl": lambda: b"solid a\n" + facet * number + b"endsolid\n",
    }
    (tmp_path / kind).write_bytes(content[kind]())
    monkeypatch.setattr(trimesh, "load_scene", lambda *args, **more: pytest.fail("it was loaded"))

    solids, notes = shown(tmp_path, kind)
    assert solids == []
    assert re.search(r"shows (some )?\d+ (parts|triangles); \d+ are the most that is read", notes[0])


@pytest.mark.mends("30.also.bounds-of-arrays")
@pytest.mark.parametrize("told", [True, False])
def test_a_run_without_coordinates_is_refused_before_its_arrays_are_read(
    told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An array that says it is of 80 TB is not made either."""
    from symdyn.linear.system import read_run

    path = tmp_path / "run.npz"
    names = {"q": np.zeros((9, 1)), "qd": np.zeros((9, 1)), "tau": np.zeros((9, 1)), "velocities": ["q1_dot"]}
    if not told:
        np.savez_compressed(path, t=np.zeros(9))
    else:
        np.savez(path, t=np.zeros(9), coordinates=["q1"], **names)
        with zipfile.ZipFile(path) as old:
            inside = {one.filename: old.read(one) for one in old.infolist()}
        inside["t.npy"] = inside["t.npy"].replace(b"(9,), }" + b" " * 13, b"(9999999999999,), }" + b" ", 1)
        with zipfile.ZipFile(path, "w") as new:
            for name, content in inside.items():
                new.writestr(name, content)
    monkeypatch.setattr(np.lib.npyio.NpzFile, "__getitem__", lambda self, name: pytest.fail(f"{name} was read"))

    with pytest.raises(SymdynError, match=r"is no run that simulate has written"):
        read_run(symdyn.example("pendulum"), path)
