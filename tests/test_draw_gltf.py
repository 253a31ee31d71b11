"""glTF: bodies are nodes that move as the run does, meshes of robots are opened where they may be, viewers agree."""

from __future__ import annotations

import re
import struct
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES, two_link
from gltf_viewers import shown, validated, viewer
from hostile import PAYLOADS
from mechanisms import jointed, random_tree
from npm_packages import packages
from scipy.spatial.transform import Rotation
from test_draw_files import pixels

import symdyn
from symdyn.draw import film
from symdyn.draw.gltf import ball, box, cylinder
from symdyn.draw.places import places
from symdyn.draw.stage import values_of
from symdyn.errors import DrawError
from symdyn.scene import Scene, read
from symdyn.scene.joints import JOINTS

pygltflib = pytest.importorskip("pygltflib", reason="needs pygltflib, the extra plot")

T = np.linspace(0.0, 1.0, 21)


def motion(scene: Scene) -> np.ndarray:
    """Return positions that move every coordinate; quaternions keep their length."""
    q = np.stack([0.3 * np.sin((1 + k) * T + k) for k in range(len(scene.coordinates))], axis=1)
    for joint in scene.joints:
        kind = JOINTS[joint.type]
        if len(kind.coordinates(joint)) > len(kind.velocities(joint)):
            at = [scene.coordinates.index(name) for name in joint.coordinates][-4:]
            q[:, at] /= np.linalg.norm(q[:, at], axis=1, keepdims=True)
    return q


def opened(path: Path) -> tuple[pygltflib.GLTF2, dict[str, dict[str, np.ndarray]]]:
    """Return a file and, by the name of a node, times and values of everything that moves it."""
    file = pygltflib.GLTF2().load(str(path))
    blob = file.binary_blob()
    assert all(0 < one.pbrMetallicRoughness.baseColorFactor[3] <= 1 for one in file.materials)

    def numbers(k: int) -> np.ndarray:
        accessor = file.accessors[k]
        view = file.bufferViews[accessor.bufferView]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        return np.frombuffer(blob, "<f4", accessor.count * width, view.byteOffset).reshape(accessor.count, width)

    moves: dict[str, dict[str, np.ndarray]] = {}
    for clip in file.animations:
        for channel in clip.channels:
            sampler = clip.samplers[channel.sampler]
            found = moves.setdefault(file.nodes[channel.target.node].name, {})
            found["time"], found[channel.target.path] = numbers(sampler.input), numbers(sampler.output)
    return file, moves


@pytest.mark.parametrize(
    "scene", [two_link(), random_tree(2, 5), jointed("free", "spherical", "cylindrical")], ids=lambda one: one.name
)
def test_every_body_is_a_node_that_is_where_the_run_has_it(scene: Scene, tmp_path: Path) -> None:
    q = motion(scene)
    values = {parameter.name: 1.0 for parameter in scene.parameters}
    file, moves = opened(film(scene, T, q, tmp_path / "a.glb", values))
    found = places(scene, q, values)

    assert [node.name for node in file.nodes] == [scene.name, Scene.GROUND, *(body.name for body in scene.bodies)]
    assert file.nodes[0].children == list(range(1, len(file.nodes)))
    for body in found.bodies:
        node = next(node for node in file.nodes if node.name == body.name)
        tracks = moves.get(body.name, {})
        where = tracks.get("translation", np.tile(node.translation, (21, 1)))
        turned = Rotation.from_quat(tracks.get("rotation", np.tile(node.rotation, (21, 1)))).as_matrix()
        assert where == pytest.approx(body.frame.p, abs=1e-6)
        assert turned == pytest.approx(body.frame.R, abs=1e-6)
        assert not tracks or tracks["time"][:, 0] == pytest.approx(T, abs=1e-6)


def test_every_moving_body_has_a_channel_and_no_other(tmp_path: Path) -> None:
    q = np.stack([0 * T, T], axis=1)  # the first link stands still
    _, moves = opened(film(two_link(), T, q, tmp_path / "a.glb"))

    assert list(moves) == ["link2"]
    assert "rotation" in moves["link2"]
    assert not opened(film(two_link(), [0.0], q[:1], tmp_path / "b.glb"))[0].animations


def test_moments_that_single_precision_cannot_tell_apart_are_one(tmp_path: Path) -> None:
    times = [0.0, 1.0, 1.0 + 1e-12, 2.0]
    _, moves = opened(film(two_link(), times, np.ones((4, 2)) * np.array(times)[:, None], tmp_path / "a.glb"))

    assert moves["link1"]["time"][:, 0].tolist() == [0.0, 1.0, 2.0]


def test_a_turn_never_goes_the_long_way_round(tmp_path: Path) -> None:
    q = np.stack([np.linspace(0, 20, 21), 0 * T], axis=1)
    _, moves = opened(film(two_link(), T, q, tmp_path / "a.glb"))
    turns = moves["link1"]["rotation"]

    assert np.einsum("ni,ni->n", turns[1:], turns[:-1]).min() > 0.5


def test_the_same_run_is_the_same_file_and_needs_no_other(tmp_path: Path) -> None:
    path = film(two_link(), T, np.stack([T, T], axis=1), tmp_path / "a.glb")
    data = path.read_bytes()

    assert data == film(two_link(), T, np.stack([T, T], axis=1), tmp_path / "b.glb").read_bytes()
    assert b"uri" not in data
    assert b"pygltflib" not in data


SOLIDS = {"box": box(np.array([1.0, 2, 3]), "#ffffff"), "cylinder": cylinder(1.0, 2.0, "#ffffff")}
SOLIDS |= {"ball": ball(1.5, "#ffffff")}


@pytest.mark.parametrize("solid", list(SOLIDS))
@pytest.mark.parametrize("scale", [(1, 1, 1), (1, 2, 3), (-1, 1, 2)])
def test_solids_are_closed_and_seen_from_outside(solid: str, scale: tuple[float, ...]) -> None:
    one = SOLIDS[solid].put(
        Rotation.from_rotvec([0.3, -0.4, 0.9]).as_matrix(), np.array([1.0, 2, 3]), np.array(scale, float)
    )
    a, b, c = (one.points[one.triangles[:, k]] for k in range(3))
    outward = np.cross(b - a, c - a)
    middle = one.points.mean(axis=0)
    volume = np.einsum("ni,ni->", np.cross(a - middle, b - middle), c - middle) / 6
    edges = np.round(np.concatenate([np.stack([a, b], 1), np.stack([b, c], 1), np.stack([c, a], 1)]), 6)
    known = {(tuple(x), tuple(y)) for x, y in edges.tolist()}

    assert volume > 0
    assert all((y, x) in known for x, y in known)
    assert np.einsum("ni,ni->n", outward, one.normals[one.triangles[:, 0]]).min() > 0
    assert np.linalg.norm(one.normals, axis=1) == pytest.approx(1.0)


# Meshes of robots

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def stl() -> bytes:
    """Return a tetrahedron."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[list(face)].ravel(), 0) for face in FACES)
    return b"\0" * 80 + struct.pack("<I", len(FACES)) + body


def obj() -> bytes:
    lines = ["mtllib /etc/passwd", *(f"v {x} {y} {z}" for x, y, z in CORNERS)]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES)]).encode()


def dae(entity: str = "") -> bytes:
    numbers = " ".join(str(1000 * x) for x in CORNERS.ravel())
    indices = " ".join(str(k) for face in FACES for k in face)
    return f"""<?xml version="1.0"?>{entity}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse><color>1 0 0 1</color></diffuse>
</lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">{numbers}</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4" material="m"><input semantic="VERTEX" source="#v" offset="0"/><p>{indices}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="m" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


MESHES = {"stl": stl, "obj": obj, "dae": dae}


def robot(folder: Path, visual: str, collision: str = "") -> Scene:
    """Return an arm of one link, read from a file in robot/urdf, with what it looks like."""
    (folder / "robot" / "urdf").mkdir(parents=True, exist_ok=True)
    (folder / "robot" / "meshes").mkdir(exist_ok=True)
    path = folder / "robot" / "urdf" / "arm.urdf"
    path.write_text(f"""<robot name="arm"><link name="base"/><link name="link-1"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>{visual}{collision}</link>
      <joint name="hinge" type="continuous"><parent link="base"/><child link="link-1"/><axis xyz="0 0 1"/></joint>
      </robot>""")
    return read(path)


def look(name: str, more: str = "", tag: str = "visual") -> str:
    origin = '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'
    return f'<{tag}>{origin}<geometry><mesh filename="{name}" {more}/></geometry></{tag}>'


def filmed(scene: Scene, folder: Path) -> tuple[np.ndarray, list[list[float]], list[str]]:
    """Return corners and colours of the link, and what was noted."""
    notes: list[str] = []
    file, _ = opened(film(scene, [0.0, 1.0], [[0.0], [1.0]], folder / "a.glb", note=notes.append))
    node = next(node for node in file.nodes if node.name == "link_1")
    corners, colours = [], []
    for part in file.meshes[node.mesh].primitives:
        accessor = file.accessors[part.attributes.POSITION]
        view = file.bufferViews[accessor.bufferView]
        data = np.frombuffer(file.binary_blob(), "<f4", 3 * accessor.count, view.byteOffset)
        corners.append(data.reshape(-1, 3))
        colours.append(file.materials[part.material].pbrMetallicRoughness.baseColorFactor)
    return np.concatenate(corners), colours, notes


@pytest.mark.long
@pytest.mark.parametrize("kind", list(MESHES))
@pytest.mark.parametrize("name", ["../meshes/a.{}", "package://robot/meshes/a.{}", "package://other/meshes/a.{}"])
def test_meshes_of_the_robot_are_where_its_file_puts_them(kind: str, name: str, tmp_path: Path) -> None:
    scene = robot(tmp_path, look(name.format(kind), 'scale="1 1 -2"'))
    (tmp_path / "robot" / "package.xml").write_text("<package/>")
    (tmp_path / "robot" / "meshes" / f"a.{kind}").write_bytes(MESHES[kind]())
    corners, colours, notes = filmed(scene, tmp_path)
    wanted = {(1 - y, 2 + x, 3 - 2 * z) for x, y, z in CORNERS.tolist()}

    assert notes == []
    assert {tuple(np.round(row, 4).tolist()) for row in corners} == wanted
    assert len(colours) == 1
    if kind == "dae":
        assert colours[0] == [1.0, 0.0, 0.0, 1.0]


def test_shapes_and_colours_of_the_file_are_shown(tmp_path: Path) -> None:
    green = '<material name="m"><color rgba="0 1 0 0.5"/></material>'
    shape = f'<visual><geometry><box size="2 4 6"/></geometry>{green}</visual>'
    corners, colours, _ = filmed(robot(tmp_path, shape), tmp_path)

    assert np.abs(corners).max(axis=0).tolist() == [1, 2, 3]
    assert colours == [[0.0, 1.0, 0.0, 0.5]]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("../../secret.stl", "is outside"),
        ("package://robot/../../secret.stl", "is outside"),
        ("{folder}/secret.stl", "is outside"),
        ("file://{folder}/secret.stl", "is outside"),
        ("../meshes/link.stl", "is outside"),
        ("https://example.invalid/a.stl", "is not beside the file"),
        ("../meshes/none.stl", "is not there"),
        ("../meshes/a.ply", "is none of .stl, .obj, .dae"),
        ("../meshes/broken.stl", "cannot be read|no triangles"),
        ("../meshes/broken.dae", "cannot be read|is not well-formed|not XML"),
        ("../meshes/broken.obj", r"cannot be read \(IndexError: "),
        ("../meshes/bomb.dae", "document type|DOCTYPE|entit"),
        ("../meshes/large.stl", "MB, and 256 MB of all, are the most"),
        ("", "is outside|is none of"),
        ("../meshes/" + "a" * 300 + ".stl", "is not there|is outside"),
        ("../meshes/a\\0.stl", "is not there|is outside"),
    ],
)
def test_other_meshes_are_not_opened_and_the_link_is_drawn(name: str, message: str, tmp_path: Path) -> None:
    scene = robot(tmp_path, look(name.format(folder=tmp_path)))
    (tmp_path / "robot" / "package.xml").write_text("<package/>")
    (tmp_path / "secret.stl").write_bytes(stl())
    meshes = tmp_path / "robot" / "meshes"
    (meshes / "link.stl").symlink_to(tmp_path / "secret.stl")
    (meshes / "broken.stl").write_bytes(b"solid nothing\n facet")
    (meshes / "broken.dae").write_bytes(b"<COLLADA><asset>")
    (meshes / "broken.obj").write_bytes(b"v 0 0 0\nf 1 2 9\n")
    (meshes / "bomb.dae").write_bytes(dae('<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'))
    with (meshes / "large.stl").open("wb") as file:
        file.truncate(65 * 2**20)
    corners, _, notes = filmed(scene, tmp_path)

    assert len(notes) == 1
    assert 'arm.urdf: line 1: link "link-1": ' in notes[0]
    assert re.search(message, notes[0]), notes[0]
    assert len(corners) > 4


def test_a_small_file_that_asks_for_much_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.draw.robot_meshes.MOST_TRIANGLES", 10_000)
    many = '<visual><geometry><sphere radius="1"/></geometry></visual>' * 1000
    _, _, notes = filmed(robot(tmp_path, many), tmp_path)

    assert len(notes) == 1
    assert "more than 10000 triangles" in notes[0]


def test_a_colour_that_is_none_is_told(tmp_path: Path) -> None:
    scene = robot(tmp_path, '<visual><geometry><box size="1 1 1"/></geometry><material name="red"/></visual>')
    path = Path(scene.source)
    path.write_text(path.read_text().replace("<link", '<material name="red"><color rgba="red"/></material><link', 1))
    corners, _, notes = filmed(scene, tmp_path)

    assert len(corners) == 24
    assert notes == ['arm.urdf: line 1: <color> rgba="red" are not 4 numbers']


def test_an_stl_in_letters_is_read(tmp_path: Path) -> None:
    scene = robot(tmp_path, look("a.stl"))
    lines = ["solid a"]
    for face in FACES:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*CORNERS[k]) for k in face]
        lines += ["endloop", "endfacet"]
    text = "\n".join([*lines, "endsolid a", ""])
    (tmp_path / "robot" / "urdf" / "a.stl").write_text(text)
    corners, _, notes = filmed(scene, tmp_path)

    assert notes == []
    assert len({tuple(row) for row in corners.tolist()}) == 4


def test_what_touches_is_shown_where_what_is_seen_cannot_be(tmp_path: Path) -> None:
    scene = robot(tmp_path, look("../urdf/none.stl"), look("a.stl", tag="collision"))
    (tmp_path / "robot" / "urdf" / "a.stl").write_bytes(stl())
    corners, _, notes = filmed(scene, tmp_path)

    assert len(notes) == 1
    assert len({tuple(row) for row in corners.tolist()}) == 4


def test_a_mesh_that_names_other_files_opens_none(tmp_path: Path) -> None:
    scene = robot(tmp_path, look("../urdf/a.obj"))
    (tmp_path / "robot" / "urdf" / "a.obj").write_bytes(obj())
    filmed(scene, tmp_path)  # everything is imported
    seen: list[str] = []
    watching = [True]
    sys.addaudithook(lambda event, args: seen.append(str(args[0])) if event == "open" and watching[0] else None)
    filmed(scene, tmp_path)
    watching[0] = False

    assert any("a.obj" in name for name in seen)
    assert not any("passwd" in name for name in seen)


def test_other_verbs_open_no_mesh(tmp_path: Path) -> None:
    scene = robot(tmp_path, look("../meshes/none.stl"))

    assert symdyn.picture(scene).startswith("<svg")
    film(scene, [0.0, 1.0], [[0.0], [1.0]], tmp_path / "a.svg", note=pytest.fail)


@pytest.mark.wide(4)
@pytest.mark.long
@pytest.mark.parametrize("payload", list(PAYLOADS))
def test_names_of_a_stranger_stay_names(payload: str, tmp_path: Path) -> None:
    scene = replace(two_link(), name=PAYLOADS[payload])
    file, _ = opened(film(scene, T, np.stack([T, T], axis=1), tmp_path / "a.glb"))

    assert [node.name for node in file.nodes] == [PAYLOADS[payload], Scene.GROUND, "link1", "link2"]


def test_numbers_beyond_single_precision_are_told(tmp_path: Path) -> None:
    with pytest.raises(DrawError, match="beyond single precision"):
        film(two_link(), [0.0, 1.0], [[0.0, 0.0], [1.0, 1.0]], tmp_path / "a.glb", {"h1": 1e39})
    assert not list(tmp_path.iterdir())


# Programs of others


@pytest.mark.slow
@pytest.mark.runs("node", "npm")
def test_the_validator_of_khronos_finds_nothing(tmp_path: Path) -> None:
    packages()
    scenes = {name: read(EXAMPLES / f"{name}.toml") for name in ("puma560", "rolling_disc", "cart_pole", "quadruped")}
    scenes["tree"] = random_tree(3, 6)
    paths = [
        film(scene, T, motion(scene), tmp_path / f"{name}.glb", {p.name: 1.0 for p in scene.free_parameters})
        for name, scene in scenes.items()
    ]
    arm = robot(tmp_path, look("a.dae"))
    (tmp_path / "robot" / "urdf" / "a.dae").write_bytes(dae())
    paths.append(film(arm, T, T[:, None], tmp_path / "arm.glb"))

    for path, report in validated(paths).items():
        issues = report["issues"]
        assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), (path.name, issues["messages"][:3])
        assert report["info"]["animationCount"] == 1
    broken = tmp_path / "broken.glb"
    data = paths[0].read_bytes().replace(b'"POSITION"', b'"POSITIOM"')
    broken.write_bytes(data)
    assert validated([broken])[broken]["issues"]["numErrors"] > 0


@pytest.mark.slow
@pytest.mark.long(0)
@pytest.mark.runs("chromium", "npm")
def test_three_js_draws_bodies_where_they_are_and_frames_that_differ(tmp_path: Path) -> None:
    packages()
    scene = read(EXAMPLES / "double_pendulum.toml")
    q = np.stack([T, -2 * T], axis=1)
    path = film(scene, T, q, tmp_path / "a.glb")
    with viewer() as page:
        about, ((first, _), (second, there)) = shown(page, path, [0.0, 0.5])

    ((name, length, tracks),) = about["clips"]
    assert (name, length) == ("motion", 1.0)
    assert {track.rpartition(".")[2] for track in tracks} == {"position", "quaternion"}
    off = np.abs(pixels(first) - pixels(second)).max(axis=2)
    assert (pixels(first) < 200).any()
    assert (off > 60).mean() > 0.002
    found = places(scene, q[10:11], values_of(scene))
    lengths = {body.name: float(np.linalg.norm(body.frame.p[0])) for body in found.bodies}
    for body, far in lengths.items():
        assert float(np.linalg.norm(there[body])) == pytest.approx(far, abs=1e-5)
