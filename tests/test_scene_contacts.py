"""Contacts as they are declared: planes and their normals, balls, and what other doors make of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.draw.free_bodies import acting_on
from symdyn.draw.ground import pushes
from symdyn.draw.pictures import drawing
from symdyn.draw.places import places
from symdyn.draw.stage import pose
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.emit.print.equations_text import equations_text
from symdyn.errors import SceneError
from symdyn.scene import Scene, bind, body, free, knife_edge, read, read_noting, read_text, rolling, scene, write_text
from symdyn.scene.forces.force_table import FORCES
from symdyn.teach.render.controls import held
from symdyn.teach.student.derivation_check import check_derivation

DATA, EXAMPLES = Path(__file__).parent / "data", Path(__file__).parent.parent / "examples"

HEAD = """name = "wheel"
gravity = GRAVITY
[parameters]
g = PARAMETER
[bodies.disc]
mass = 1
inertia = [0.02, 0.04, 0.02]
inertia_about = "com"
[bodies.table]
mass = 1
[joints.flight]
type = "free"
parent = "ground"
child = "disc"
orientation = "zxy"
coordinates = ["x", "y", "z", "a", "b", "c"]
[joints.slide]
type = "prismatic"
parent = "ground"
child = "table"
[constraints.touch]
type = "rolling"
body = "disc"
axis = [0, 1, 0]
radius = 0.3
"""


def wheel(gravity: str = "[0, 0, -9.81]", g: str = "9.81", more: str = "") -> Scene:
    return read_text(HEAD.replace("GRAVITY", gravity).replace("PARAMETER", g) + more, "wheel.toml")


def normal(one: Scene) -> tuple[float, ...]:

    return tuple(float(x.at({}) or 0) for x in one.constraints[0].plane.normal)


@pytest.mark.parametrize(
    ("gravity", "g", "expected"),
    [
        ("[0, 0, -9.81]", "1", (0, 0, 1)),
        ("[0, -9.81, 0]", "1", (0, 1, 0)),
        ('["g", 0, 0]', "2", (-1, 0, 0)),
        ('[0, 0, "-g"]', "{ positive = true }", (0, 0, 1)),
        ('[0, 0, "-g**2"]', "{}", (0, 0, 1)),
        ('["0.6*g", 0, "-0.8*g"]', "{ positive = true }", (-0.6, 0, 0.8)),
        ('["3*sin(g)", 0, "-3*cos(g)"]', "0.5", (-3 * np.sin(0.5), 0, 3 * np.cos(0.5))),
    ],
)
def test_a_plane_without_a_normal_is_level(gravity: str, g: str, expected: tuple[float, ...]) -> None:
    assert normal(wheel(gravity, g)) == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    ("gravity", "g", "says"),
    [
        ('"none"', "1", r"gravity = \[0, 0, 0\] has no direction; write normal = \[0, 0, 1\]"),
        ('[0, 0, "-g"]', "{}", r"the direction of gravity = \[0, 0, -g\] depends on g, which may be negative"),
        ('["g", 0, -9.81]', "{ positive = true }", "the direction of gravity = .* depends on g"),
    ],
)
def test_gravity_of_no_decided_direction_needs_a_normal(gravity: str, g: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        wheel(gravity, g)
    for more in ("normal = [0, 0, 1]\n", "plane = { normal = [0, 0, 1] }\n"):
        assert normal(wheel(gravity, g, more)) == (0, 0, 1)


def test_the_normal_is_that_of_gravity_as_it_is_declared_whatever_is_bound() -> None:
    free_g = wheel('[0, 0, "-g"]', "{ positive = true }")

    assert normal(bind(free_g, {"g": 0})) == normal(bind(wheel('[0, 0, "-g"]', "9.81"), {"g": -3})) == (0, 0, 1)


def test_a_plane_that_gravity_tilts_is_told(tmp_path: Path) -> None:
    path = tmp_path / "wheel.toml"
    path.write_text(HEAD.replace("GRAVITY", '[0, "-g", 0]').replace("PARAMETER", "1"), encoding="utf-8")

    (note,) = read_noting(path).notes
    assert "constraints.touch: its plane is level: normal = [0, 1, 0], against gravity" in note
    path.write_text(path.read_text(encoding="utf-8") + "normal = [0, 1, 0]\n", encoding="utf-8")
    assert not read_noting(path).notes


def test_a_moving_plane_has_a_normal_of_its_own() -> None:
    with pytest.raises(SceneError, match=r'plane: normal is missing; a plane on body "table" has one of its own'):
        wheel(more='plane = { body = "table" }\n')


@pytest.mark.parametrize(
    "more",
    [
        "",
        "normal = [0, 3, 4]\n",
        'components = ["normal"]\n',
        "plane = { at = [0, 0, 0.5] }\n",
        'plane = { body = "table", at = [0, 0, "g"], normal = [0, 0, 1] }\ncomponents = ["normal", "along"]\n',
    ],
)
@pytest.mark.parametrize("ball", [False, True])
def test_contacts_are_written_as_they_were_read(more: str, ball: bool) -> None:
    text = HEAD.replace("GRAVITY", "[0, 0, -9.81]").replace("PARAMETER", "0.1") + more
    one = read_text(text.replace("axis = [0, 1, 0]\n", "") if ball else text, "wheel.toml")
    written = write_text(one, "toml").text

    assert read_text(written, "again.toml") == one
    assert write_text(read_text(written, "again.toml"), "toml").text == written


def test_words_of_python_declare_the_same_contacts() -> None:
    plane = {"body": "b", "at": [0, 0, 0.1], "normal": [0, 0, 1]}
    one = scene(
        "both",
        bodies=[body("a", mass=1), body("b", mass=1)],
        joints=[free("f", "ground", "a"), free("h", "ground", "b")],
        constraints=[
            rolling("ball", body="a", radius=0.1, plane=plane),
            rolling("wheel", body="a", radius=0.1, axis=[0, 1, 0], normal=[0, 0, 1]),
            knife_edge("blade", body="a", axis=[0, 1, 0], plane=plane),
        ],
    )  # fmt: skip

    assert read_text(write_text(one, "toml").text, "again.toml") == one
    assert [FORCES[row.kind].holonomic(row) for row in one.contacts] == [True, False, False]
    assert one.constraints[0].axis is None


@pytest.mark.long
def test_info_tells_contacts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(EXAMPLES / "rolling_disc.toml")]) == 0
    told = capsys.readouterr().out
    assert (
        "contact contact: disc, a wheel of radius r about its [0, 1, 0], rolls on the plane of ground through "
        "[0, 0, 0], normal [0, 0, 1] (along, across, normal)"
    ) in told
    assert main(["info", "--json", str(DATA / "contacts" / "skate.toml")]) == 0
    (row,) = json.loads(capsys.readouterr().out)["result"]["constraints"]
    assert row["law"].startswith("sled does not slide along its [0, 1, 0] at [0, 0, 0] on the plane of table")


def test_a_contact_that_holds_a_height_is_printed_as_a_position() -> None:
    one = wheel(more='components = ["along", "across", "normal"]\n').contacts[0]
    text = HEAD.replace("GRAVITY", "[0, 0, -9.81]").replace("PARAMETER", "0.1").replace("axis = [0, 1, 0]\n", "")
    shown = equations_text(read_text(text, "ball.toml"), "text")

    assert FORCES[one.kind].holonomic(one)
    assert "\nz - 0.3 = 0\n" in shown
    assert "normal force of contact touch, exerted by ground on disc" in shown


@pytest.mark.parametrize(
    ("formula", "right"),
    [
        (r"z - r \cos q_2 = 0", True),
        (r"\dot z + r \sin q_2 \dot q_2 = 0", True),
        (r"\dot x \cos q_1 + \dot y \sin q_1 - r (\dot q_3 + \sin q_2 \dot q_1) = 0", True),
        (r"z = r", False),
        (r"\dot x \cos q_1 + \dot y \sin q_1 - r \dot q_3 = 0", False),
    ],
)
def test_rows_of_a_wheel_that_a_student_writes_are_checked(formula: str, right: bool) -> None:
    (answer,) = check_derivation(formula, read(DATA / "found" / "rolling_disc_zxy.toml"))

    assert answer.right is right


# Pictures


def test_the_plane_of_a_contact_is_drawn_under_what_touches_it() -> None:
    one = read(EXAMPLES / "rolling_disc.toml")
    q, values = pose(one)
    found = places(one, q[None, :], values)
    touch = found.touches["contact"]
    shown = drawing(one, q, values)
    (plane,) = [item for item in shown.items if item.id == "plane-contact"]

    assert touch.normal[0] == pytest.approx([0, 0, 1])
    assert touch.spot[0] == pytest.approx(found.wheels["contact"][0][0])
    assert plane.layer == 0
    assert plane.shapes[0].points.shape == (1, 4, 2)


def test_a_planar_scene_shows_the_plane_as_a_hatched_line() -> None:
    text = HEAD.replace("GRAVITY", "[0, 0, -9.81]").replace("PARAMETER", "0.1")
    text = text.replace('type = "free"', 'type = "planar"\naxis = [0, 1, 0]').replace('orientation = "zxy"\n', "")
    text = text.replace('["x", "y", "z", "a", "b", "c"]', '["u", "v", "a"]')
    one = read_text(text + 'components = ["along", "normal"]\n', "planar.toml")
    (plane,) = [item for item in drawing(one).items if item.id == "plane-touch"]
    level = plane.shapes[1].points[0, :, 1]

    assert np.ptp(level) < 1e-9
    rim = next(shape for item in drawing(one).items for shape in item.shapes if shape.kind == "disc")
    assert level[0] == pytest.approx(rim.points[0, 0, 1] + rim.size, abs=1e-6)  # y down: below the centre


def test_a_ball_has_an_outline() -> None:
    one = read(DATA / "contacts" / "turntable.toml")
    (ball,) = [item for item in drawing(one).items if item.id == "body-ball"]
    rims = [shape for shape in ball.shapes if shape.kind == "disc"]

    assert rims[0].tilt[0, 0] == pytest.approx(rims[0].size)  # a circle wherever it is seen from
    assert len(rims) == 2


@pytest.mark.parametrize("name", ["turntable", "skate", "bicycle"])
def test_forces_of_contacts_in_free_body_figures_are_those_of_their_multipliers(name: str) -> None:
    one = read(DATA / "contacts" / f"{name}.toml")
    numbers = Numbers(one)
    q = numbers.drawn(3)
    found = places(one, q[None, :], pose(one)[1])
    labels = numbers.constraints.labels
    for row in one.constraints:
        R = (found.ground if row.plane.body == "ground" else found.body(row.plane.body).frame).R[0]
        wrenches = [numbers.at([*one.wrench[0], *one.wrench[1]], q) for one in labels if one.owner == row.name]
        at, forces = pushes(row, found)
        for wrench, force in zip(wrenches, forces, strict=True):
            assert R @ wrench[:3] == pytest.approx(force, abs=1e-12)
            moment = np.cross(at - found.touches[row.name].spot[0], force)
            assert R @ wrench[3:] == pytest.approx(moment, abs=1e-12)


def test_a_contact_is_cut_in_the_figures_of_both_its_bodies() -> None:
    one = read(DATA / "contacts" / "turntable.toml")
    ball, table = ({w.name: w for w in acting_on(one, body_)} for body_ in ("ball", "table"))

    for k in (1, 2, 3):
        name = rf"F_{{\mathrm{{touch}},{k}}}"
        assert ball[name].at == table[f"-{name}"].at
        assert np.array(ball[name].force) == pytest.approx(-np.array(table[f"-{name}"].force))


def test_on_a_page_the_height_of_a_wheel_follows_and_all_else_is_free() -> None:
    for name, free_ones in (("rolling_disc", {0, 1, 3, 4, 5, 6}), ("four_bar", None)):
        one = read(EXAMPLES / f"{name}.toml")
        tied = held(Workspace(one))
        if free_ones is None:
            assert all(len(block.rows) == len(block.velocities) for block in tied.closing.blocks)
        else:
            assert set(tied.moved) == free_ones
    angles = held(Workspace(read(DATA / "found" / "rolling_disc_zxy.toml")))
    assert set(angles.moved) == {0, 1, 3, 4, 5}
