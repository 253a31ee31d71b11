"""Every bound on what is read of a stranger's file refuses in words, and before the work that it spares."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from symdyn.bounds import BOUNDS
from symdyn.cli import main
from symdyn.errors import SceneError, SymdynError
from symdyn.scene import read
from symdyn.scene.scene_files import read_noting

EXAMPLES = Path(__file__).parent.parent / "examples"

ROBOT = """<robot name="r"><link name="base"/><link name="a"><inertial><mass value="1"/></inertial>{shown}</link>
<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>{more}</robot>"""

VISUAL = '<visual><geometry><mesh filename="{name}"/></geometry></visual>'

BODY = '<body><joint/><geom type="mesh" mesh="m"/></body>'

ARM = """
gravity = [0, 0, -9.81]
[bodies.b]
{body}
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
"""

Refusal = Callable[[], object]


def beyond(what: str) -> int:
    return BOUNDS[what] + 1


def toml(folder: Path, text: str) -> Refusal:
    (folder / "a.toml").write_text(text, encoding="utf-8")
    return lambda: read(folder / "a.toml")


def urdf(folder: Path, shown: str = "", more: str = "") -> Refusal:
    (folder / "a.urdf").write_text(ROBOT.format(shown=shown, more=more), encoding="utf-8")
    return lambda: read(folder / "a.urdf")


def mjcf(folder: Path, assets: str = "", world: str = BODY, head: str = "") -> Refusal:
    text = f"<mujoco>{head}<asset>{assets}</asset><worldbody>{world}</worldbody></mujoco>"
    (folder / "a.mjcf").write_text(text, encoding="utf-8")
    return lambda: read(folder / "a.mjcf")


def par(folder: Path, text: str) -> Refusal:
    (folder / "a.par").write_text(text, encoding="utf-8")
    return lambda: read(folder / "a.par")


def shows(folder: Path, name: str, *more: str) -> Refusal:
    """Return what draws a robot whose link shows a mesh, and others; what is not shown is a note."""
    pytest.importorskip("trimesh")
    from symdyn.draw.robot_meshes import robot_solids

    urdf(folder, "".join(VISUAL.format(name=one) for one in (name, *more)))
    scene = read_noting(folder / "a.urdf").scene

    def drawn() -> None:
        notes: list[str] = []
        solids = robot_solids(scene, notes.append)
        assert not any(solids.values())
        raise SceneError(notes)

    return drawn


def hollow(path: Path, size: int, head: bytes = b"") -> Path:
    """Write a file of so many bytes of which the disk holds but its beginning."""
    with path.open("wb") as file:
        file.write(head)
        file.truncate(size)
    return path


def said(*words: str) -> Refusal:
    """Return what runs a command that ends with our error, and raises what it said."""

    def run() -> None:
        assert main(list(words)) in (1, 2)
        raise SceneError("see stderr")

    return run


TRIANGLE = (
    '<geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array>'
    '<technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" '
    'type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input '
    'semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" '
    'offset="0"/><p>{corners}</p></triangles></mesh></geometry>'
)


def collada(path: Path, nodes: list[str], top: str, triangles: int = 1) -> str:
    library = "".join(f'<node id="n{k}">{inside}</node>' for k, inside in enumerate(nodes))
    path.write_text(
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/></asset>'
        f"<library_geometries>{TRIANGLE.format(corners='0 1 2 ' * triangles)}</library_geometries>"
        f'<library_nodes>{library}</library_nodes><library_visual_scenes><visual_scene id="s"><node id="top">{top}'
        '</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>',
        encoding="utf-8",
    )
    return path.name


GEOMETRY = '<instance_geometry url="#g"/>'


def levels(folder: Path) -> Refusal:
    nodes = [GEOMETRY, *(f'<instance_node url="#n{k}"/>' * 10 for k in range(8))]
    return shows(folder, collada(folder / "m.dae", nodes, '<instance_node url="#n8"/>'))


def shown_triangles(folder: Path) -> Refusal:
    """A file that says of 30,000 triangles that they are one, and shows them 100 times."""
    return shows(folder, collada(folder / "m.dae", [], GEOMETRY * 100, 30_000))


def obj(path: Path, corners: int) -> str:
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf " + "1 2 3 " * (corners // 3 + 1), encoding="utf-8")
    return path.name


def many_meshes(folder: Path) -> Refusal:
    names = [f"m{k}" for k in range(9)]
    for name in names:
        hollow(folder / f"{name}.stl", BOUNDS["bytes of a mesh"])
    bodies = "".join(f'<body><joint/><geom type="mesh" mesh="{name}"/></body>' for name in names)
    return mjcf(folder, "".join(f'<mesh name="{name}" file="{name}.stl"/>' for name in names), bodies)


def shown_bytes(folder: Path) -> Refusal:
    names = [hollow(folder / f"m{k}.stl", BOUNDS["bytes of a mesh"] + (k == 4)).name for k in range(5)]
    return shows(folder, names[4], *names[:4])


def arrays(folder: Path) -> Refusal:
    """A small file that unpacks to more than is read; its directory says so, whatever comes of it."""
    from symdyn.linear.system import read_run

    path = folder / "run.npz"
    np.savez_compressed(path, t=np.zeros(9))
    content = bytearray(path.read_bytes())
    size = content.index(b"PK\x01\x02") + 24
    content[size : size + 4] = beyond("bytes of the arrays of a file").to_bytes(4, "little")
    path.write_bytes(content)
    return lambda: read_run(read(EXAMPLES / "pendulum.toml"), path)


def program(folder: Path) -> Refusal:
    from symdyn.emit.targets.json_graph import read_program

    text = " " * beyond("characters of a program in JSON")
    return lambda: read_program(text)


def store(folder: Path) -> Refusal:
    """A store that says it holds blocks without end; whoever writes one can seal it."""
    pytest.importorskip("zarr")
    import symdyn
    from symdyn.study.run_sweep import KINDS, opened, zarr
    from symdyn.study.store import SEAL, seal

    path = folder / "s.zarr"
    over = "q1=linspace(0.1,0.3,4)"
    symdyn.sweep(EXAMPLES / "pendulum.toml", over, "max(abs(q1))", until=0.01, method="dop853", output=path)
    group = zarr().open_group(path, mode="r+")
    about = dict(group.attrs)
    count = beyond("blocks of a store")
    for name in KINDS:
        file = path / name / "zarr.json"
        said = json.loads(file.read_text(encoding="utf-8"))
        said["shape"][0], said["chunk_grid"]["configuration"]["chunk_shape"][0] = count, 1
        file.write_text(json.dumps(said), encoding="utf-8")
    about["job"] = about["job"] | {"count": count}
    group = zarr().open_group(path, mode="r+")
    group.attrs.update(about | {SEAL: seal(about, {name: group[name] for name in KINDS})})
    return lambda: opened(path)


def described(folder: Path) -> Refusal:
    pytest.importorskip("zarr")
    from symdyn.study.run_sweep import opened

    (folder / "s.zarr").mkdir()
    hollow(folder / "s.zarr" / "zarr.json", beyond("bytes of a store's own description"))
    return lambda: opened(folder / "s.zarr")


def runs(folder: Path) -> Refusal:
    import symdyn

    count = beyond("runs of a sweep")
    over = "q1=normal(1,0.1)"
    return lambda: symdyn.sweep(EXAMPLES / "pendulum.toml", over, "max(abs(q1))", until=0.01, count=count)


def generated(folder: Path, count: int, size: int) -> Refusal:
    for k in range(count):
        hollow(folder / f"{k}.c", size)
    return said("verify", str(EXAMPLES / "pendulum.toml"), "--files", str(folder))


def columns(folder: Path, size: int, row: str) -> Refusal:
    path = hollow(folder / "c.csv", size) if not row else folder / "c.csv"
    if row:
        path.write_text("t,q1\n" + row, encoding="utf-8")
    return said("inverse", str(EXAMPLES / "pendulum.toml"), "--motion", str(path))


def including(folder: Path) -> Refusal:
    for k in range(beyond("files that an MJCF file includes")):
        (folder / f"i{k}.xml").write_text("<mujocoinclude/>", encoding="utf-8")
    names = range(beyond("files that an MJCF file includes"))
    return mjcf(folder, head="".join(f'<include file="i{k}.xml"/>' for k in names))


def hooked(folder: Path) -> Refusal:
    """Bodies that a few letters make."""
    return mjcf(
        folder, world=f'<replicate count="{beyond("bodies of an MJCF file")}"><body><joint/></body></replicate>'
    )


def massy(folder: Path) -> Refusal:
    particles = ", ".join(["{ mass = 1, at = [1, 0, 0] }"] * beyond("particles of a body"))
    return toml(folder, ARM.format(body=f"particles = [{particles}]"))


def homework(folder: Path) -> Refusal:
    path = hollow(folder / "h.txt", beyond("bytes of a student's file"))
    return said("check-derivation", str(path), str(EXAMPLES / "pendulum.toml"))


def equal_lines(folder: Path) -> Refusal:
    (folder / "h.txt").write_text("L = m\n" * beyond("lines of a student's file"), encoding="utf-8")
    return said("check-derivation", str(folder / "h.txt"), str(EXAMPLES / "pendulum.toml"))


FILES: dict[str, Callable[[Path], Refusal]] = {
    "bytes of a TOML file": lambda at: toml(at, "#" * beyond("bytes of a TOML file")),
    "values of a TOML file": lambda at: toml(at, "gravity = [" + "1," * beyond("values of a TOML file") + "]"),
    "levels of a TOML file": lambda at: toml(at, "gravity = " + "[" * 200 + "]" * 200),
    "parts of a dotted key": lambda at: toml(at, "mass" + ".a" * beyond("parts of a dotted key") + " = 1"),
    "particles of a body": massy,
    "bytes of an XML file": lambda at: urdf(at, more="<!--" + "x" * beyond("bytes of an XML file") + "-->"),
    "bytes of a tag": lambda at: urdf(at, more='<gazebo a="' + "x" * 2 * beyond("bytes of a tag") + '"/>'),
    "levels of an XML file": lambda at: urdf(at, more="<a>" * 300 + "</a>" * 300),
    "elements of an XML file": lambda at: urdf(at, more="<a/>" * beyond("elements of an XML file")),
    "bytes of a .par file": lambda at: par(at, "x" * beyond("bytes of a .par file")),
    "values of a list of a .par file": lambda at: par(
        at, "NL = 1\nM = {" + "1," * beyond("values of a list of a .par file") + "1}"
    ),
    "files that an MJCF file includes": including,
    "elements that an MJCF file makes": lambda at: mjcf(
        at, world=f'<replicate count="1001"><replicate count="1001">{BODY}</replicate></replicate>'
    ),
    "bodies of an MJCF file": hooked,
    "reserved by an attribute of an MJCF file": lambda at: mjcf(at, head='<size nkey="100000000"/>'),
    "heights of the hfields of an MJCF file": lambda at: mjcf(
        at, '<hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/>'
    ),
    "corners of the built-in meshes of an MJCF file": lambda at: mjcf(
        at, '<mesh name="m" builtin="supersphere" params="5000 1 1"/>'
    ),
    "bytes of a mesh": lambda at: shows(at, hollow(at / "m.stl", beyond("bytes of a mesh")).name),
    "bytes of the meshes that give inertia": many_meshes,
    "bytes of the meshes that are shown": shown_bytes,
    "corners of a face of a mesh": lambda at: shows(at, obj(at / "m.obj", 9_000_000)),
    "triangles that are shown": shown_triangles,
    "parts of a mesh": levels,
    "bytes of a file of numbers or formulas": lambda at: columns(
        at, beyond("bytes of a file of numbers or formulas"), ""
    ),
    "numbers of a file of columns": lambda at: columns(at, 0, "1,1\n" * (BOUNDS["numbers of a file of columns"] // 2)),
    "bytes of the arrays of a file": arrays,
    "characters of a program in JSON": program,
    "runs of a sweep": runs,
    "blocks of a store": store,
    "bytes of a store's own description": described,
    "bytes of a student's file": homework,
    "lines of a student's file": equal_lines,
    "bytes of a generated file": lambda at: generated(at, 1, beyond("bytes of a generated file")),
    "generated files that are read": lambda at: generated(at, beyond("generated files that are read"), 0),
}
"""A file beyond each row of the table, by what is counted."""


def test_the_page_tells_every_bound() -> None:
    page = (Path(__file__).parent.parent / "docs" / "robots.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in page.partition("## How much is read")[2].splitlines()[7:]]
    told = [(row[0], row[1]) for row in rows[: len(BOUNDS)]]

    assert told == [(what, f"{n >> 20} MB" if n % 2**20 == 0 else f"{n:,}") for what, n in BOUNDS.items()]


WORDS = (
    *("more than", "most that is read", "are allowed", "deeper than", "longer than", "much memory", "give 1 to"),
    *("has 17 parts", "blocks are read", "bodies; 2000 are", "for memory"),
)
"""How a refusal says that there is too much."""


def test_every_bound_has_a_file_beyond_it() -> None:
    assert set(FILES) == set(BOUNDS)


COMPILES = "blocks of a store"
"""What is made by a sweep, which looks for a compiler."""


@pytest.mark.heavy("elements of an XML file", "values of a TOML file")
@pytest.mark.long
@pytest.mark.parametrize(
    "what", [pytest.param(what, marks=pytest.mark.runs("cc") if what == COMPILES else ()) for what in FILES]
)
def test_a_file_beyond_a_bound_is_refused_in_words_and_soon(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if "MJCF" in what or "inertia" in what:
        pytest.importorskip("mujoco")
    refusal = FILES[what](tmp_path)
    begun = time.process_time()
    with pytest.raises(SymdynError) as caught:
        refusal()
    took = time.process_time() - begun

    message = f"{caught.value}{capsys.readouterr().err}"
    assert took < 2
    assert len(message) < 2000
    assert re.search("|".join(WORDS), message), message


def test_equal_lines_of_a_student_are_compared_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from symdyn.teach import check_derivation
    from symdyn.teach.student import derivation_check

    calls: list[int] = []
    compare = derivation_check.energy_judged
    monkeypatch.setattr(derivation_check, "energy_judged", lambda *all: calls.append(1) or compare(*all))
    answers = check_derivation("L = m\n" * 50, read(EXAMPLES / "pendulum.toml"))

    assert len(calls) == 1
    assert [one.line for one in answers] == [*range(1, 51)]
