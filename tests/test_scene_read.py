"""Scenes from TOML, from Denavit-Hartenberg tables and from Python are one and the same."""

import math
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from symdyn.errors import SceneError
from symdyn.graph import Graph
from symdyn.scene import (
    Quantity,
    Scene,
    body,
    dh_table,
    fixed,
    joint,
    parameter,
    parse,
    point,
    prismatic,
    read,
    read_text,
    revolute,
    scene,
    with_symbolic_inertia,
)
from symdyn.scene.scene_files import Starter
from symdyn.scene.symbolic import INERTIAL
from symdyn.scene.values import Pose
from symdyn.spatial import Transform

PENDULUM = """
gravity = [0, "-g", 0]
[parameters]
m = 1.0
l = { value = "1/2", unit = "m", positive = true, latex = "\\\\ell", text = "length" }
g = {}
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
"""


def test_toml_and_python_give_the_same_scene():
    text = """
    name = "crane"
    gravity = [0, 0, "-g"]
    [parameters]
    g = { value = 9.81, unit = "m/s^2", positive = true }
    m = 0.3
    b = {}
    [bodies.trolley]
    mass = "2*m"
    inertia = { xx = 1, yy = 1, zz = 1.5, xy = "m/10" }
    inertia_about = "com"
    [bodies.hook]
    first_moment = [0, 0, "-m/4"]
    mass = "m"
    inertia = [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.001]]
    inertia_about = "frame"
    particles = [{ mass = 1, at = [0, 0, -0.5] }]
    [bodies.lamp]
    [joints.rope]
    type = "revolute"
    parent = "trolley"
    child = "hook"
    axis = [1, 1, 0]
    origin = { xyz = [0, 0, -0.1], rpy = ["30 deg", 0, "pi/2"] }
    tip = [["Tz", -1], ["Rx", 0]]
    drive = false
    [joints.rail]
    type = "prismatic"
    parent = "ground"
    child = "trolley"
    axis = [1, 0, 0]
    coordinate = "x"
    drive = "F"
    force = "-b*x_dot"
    [joints.screw]
    type = "fixed"
    parent = "trolley"
    child = "lamp"
    [points.eye]
    body = "hook"
    at = [0, 0, -0.2]
    """
    built = scene(
        "crane",
        gravity=[0, 0, "-g"],
        parameters=[parameter("g", 9.81, unit="m/s^2", positive=True), parameter("m", Fraction(3, 10)), parameter("b")],
        bodies=[
            body("trolley", mass="2*m", inertia=[[1, "m/10", 0], ["m/10", 1, 0], [0, 0, 1.5]], about="com"),
            body(
                "hook",
                mass="m",
                first_moment=[0, 0, "-0.25*m"],
                inertia=np.array([0.02, 0.02, 0.001]),
                about="frame",
                particles=[{"mass": 1, "at": (0, 0, "-1/2")}],
            ),
            body("lamp"),
        ],
        joints=[
            revolute(
                "rope",
                "trolley",
                "hook",
                axis=np.array([1.0, 1.0, 0.0]),
                origin=[["Tz", -0.1], ["Rz", "90 deg"], ["Rx", "pi/6"]],
                tip=Pose((("Tz", Quantity.number(-1)),)),
                drive=False,
            ),
            joint(
                "rail",
                "prismatic",
                Scene.GROUND,
                "trolley",
                axis=[1, 0, 0],
                coordinate="x",
                drive="F",
                force="-b*x_dot",
            ),
            fixed("screw", "trolley", "lamp"),
        ],
        points=[point("eye", "hook", {"xyz": [0, 0, -0.2]})],
    )

    assert read_text(text, "anything.toml") == built


def test_joints_come_parents_first_and_bodies_follow_them():
    bodies = [body(name) for name in "abcd"]
    joints = [
        revolute("jc", "b", "c"),
        prismatic("ja", Scene.GROUND, "a"),
        revolute("jd", Scene.GROUND, "d"),
        revolute("jb", "a", "b"),
    ]
    ordered = scene("tree", bodies=bodies, joints=joints)

    assert [j.name for j in ordered.joints] == ["ja", "jb", "jc", "jd"]
    assert [b.name for b in ordered.bodies] == ["a", "b", "c", "d"]
    assert ordered.coordinates == ("q1", "q2", "q3", "q4")
    assert [j.drive for j in ordered.joints] == ["tau1", "tau2", "tau3", "tau4"]


def test_fixed_joints_have_no_coordinate_and_no_number():
    built = scene("s", bodies=[body("a"), body("b")], joints=[fixed("f", Scene.GROUND, "a"), revolute("r", "a", "b")])

    assert built.coordinates == ("q1",)
    assert [j.drive for j in built.joints] == [None, "tau1"]


def test_the_name_of_a_scene_defaults_to_the_stem_of_its_file():
    assert read_text(PENDULUM, "folder/my-pendulum.toml").name == "my_pendulum"
    assert read_text(PENDULUM, "3d.toml").name == "scene_3d"
    assert read_text('name = "p"\n' + PENDULUM, "x.toml").name == "p"


def test_parameters_keep_order_value_and_assumptions():
    m, length, g = read_text(PENDULUM).parameters

    assert (m.name, m.value) == ("m", Quantity.number(1))
    assert (length.value, length.unit, length.positive, length.latex) == (
        Quantity.number(Fraction(1, 2)),
        "m",
        True,
        "\\ell",
    )
    assert (g.name, g.value) == ("g", None)
    assert read_text(PENDULUM).free_parameters == (g,)


@pytest.mark.parametrize(
    ("text", "gravity"),
    [
        ("", (0, 0, Fraction("-9.81"))),
        ("gravity = false", (0, 0, 0)),
        ('gravity = "none"', (0, 0, 0)),
        ('gravity = [0, "-1.62", 1e-3]', (0, Fraction("-1.62"), Fraction(1, 1000))),
    ],
)
def test_gravity_is_standard_none_or_given(text, gravity):
    rest = PENDULUM.replace('gravity = [0, "-g", 0]', "")

    assert read_text(text + rest).gravity == tuple(Quantity.number(x) for x in gravity)


def test_digits_of_a_file_are_exact():
    text = PENDULUM.replace("m = 1.0", "m = 0.10000000000000000000001")

    assert read_text(text).parameters[0].value == Quantity.number(Fraction("0.10000000000000000000001"))


def test_roll_pitch_yaw_turn_about_fixed_axes():
    roll, pitch, yaw = "10 deg", "20 deg", "30 deg"
    built = scene(
        "s", bodies=[body("a")], joints=[revolute("r", Scene.GROUND, "a", origin={"rpy": [roll, pitch, yaw]})]
    )

    assert built.joints[0].origin == Pose((("Rz", parse(yaw)), ("Ry", parse(pitch)), ("Rx", parse(roll))))


def dh_pose(row, convention, q, kind):
    """A_i by the printed formula, with floats: the witness for the steps that the table gives."""

    def turn(axis, angle):
        c, s, k = math.cos(angle), math.sin(angle), "xyz".index(axis)
        m = np.eye(4)
        i, j = (k + 1) % 3, (k + 2) % 3
        m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
        return m

    def shift(axis, length):
        m = np.eye(4)
        m["xyz".index(axis), 3] = length
        return m

    theta, d, a, alpha = row["theta"], row["d"], row["a"], row["alpha"]
    theta, d = (theta + q, d) if kind == "revolute" else (theta, d + q)
    if convention == "standard":
        return turn("z", theta) @ shift("z", d) @ shift("x", a) @ turn("x", alpha)
    return turn("x", alpha) @ shift("x", a) @ turn("z", theta) @ shift("z", d)


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_dh_rows_place_the_link_as_the_convention_says(convention, kind):
    row = {"type": kind, "theta": 0.3, "d": 0.7, "a": -0.2, "alpha": 1.1}
    built = scene("s", dh=dh_table(convention, [row, {"mass": 1}]))
    only, q = built.joints[0], 0.45
    motion = Pose((("Rz" if kind == "revolute" else "Tz", Quantity.number(Fraction("0.45"))),))
    graph = Graph()
    place = Transform.unit(graph)
    for pose in (only.origin, motion, only.tip):
        for step, amount in pose.steps:
            place = place @ Transform.elementary(step, amount.express(graph))
    from symdyn.graph import Op, evaluate

    class Floats:
        constant, pi = staticmethod(float), staticmethod(lambda: math.pi)
        add, sub = staticmethod(lambda a, b: a + b), staticmethod(lambda a, b: a - b)
        mul, div, neg = staticmethod(lambda a, b: a * b), staticmethod(lambda a, b: a / b), staticmethod(lambda a: -a)

        def function(self, node, args):
            return {Op.SIN: math.sin, Op.COS: math.cos}[node.op](*args)

    entries = [x for row in (*place.R, place.p) for x in row]
    found = np.array(evaluate(entries, Floats(), {})).reshape(4, 3)
    expected = dh_pose(row, convention, q, kind)

    np.testing.assert_allclose(found[:3], expected[:3, :3], atol=1e-15)
    np.testing.assert_allclose(found[3], expected[:3, 3], atol=1e-15)
    assert only.axis == (Quantity.number(0), Quantity.number(0), Quantity.number(1))
    assert only.parent == Scene.GROUND
    assert built.joints[1].parent == "link1"


def test_a_dh_table_may_hang_on_a_declared_body():
    built = scene(
        "s",
        bodies=[body("sled", mass=3)],
        joints=[prismatic("rail", Scene.GROUND, "sled", axis=[1, 0, 0])],
        dh=dh_table("modified", [{"mass": 1, "name": "arm", "coordinate": "phi", "drive": False}], parent="sled"),
    )

    assert [b.name for b in built.bodies] == ["sled", "arm"]
    assert built.joints[1].parent == "sled"
    assert (built.joints[1].coordinate, built.joints[1].drive) == ("phi", None)


def test_symbolic_inertia_opens_ten_parameters_a_body():
    opened = with_symbolic_inertia(read_text(PENDULUM))

    assert [p.name for p in opened.parameters][:2] == ["g", "m1"]
    assert [p.name for p in opened.parameters][2:] == [f"{kind}1" for kind, _, _ in INERTIAL[1:]]
    assert opened.bodies[0].first_moment == (Quantity.symbol("mx1"), Quantity.symbol("my1"), Quantity.symbol("mz1"))
    assert (opened.bodies[0].com, opened.bodies[0].about, opened.bodies[0].particles) == (None, "frame", ())
    assert opened.joints == read_text(PENDULUM).joints


def test_symbolic_inertia_steps_aside_for_names_in_use():
    text = PENDULUM.replace('"-g"', '"-m1"').replace("g = {}", "m1 = {}")
    names = [p.name for p in with_symbolic_inertia(read_text(text)).parameters]

    assert names[:3] == ["m1", "m1_b", "mx1_b"]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("template", Starter.TEMPLATES)
def test_every_starter_reads_back(template):
    built = read_text(Starter("mine").from_template(template))

    assert built.name == "mine"
    assert built.coordinates


@pytest.mark.parametrize("n", [1, 3, 12])
def test_a_chain_has_n_links(n):
    built = read_text(Starter("chain").from_template("chain", n))

    assert built.coordinates == tuple(f"q{k}" for k in range(1, n + 1))
    assert [j.parent for j in built.joints] == [Scene.GROUND] + [f"link{k}" for k in range(1, n)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("x", "pumma"), r"no template \"pumma\"; did you mean puma\? \(there are rr, rrr"),
        (("x", "rr", 3), "n = 3 goes with the templates chain and n_four_bar only"),
        (("x", "chain", 0), "1 to 1024"),
        (("x", "chain", 1025), "1 to 1024"),
        (("a b", "rr"), 'the name "a b" is not a plain identifier'),
    ],
)
def test_a_starter_that_cannot_be_written_says_why(arguments, message):
    name, *words = arguments
    with pytest.raises(SceneError, match=message):
        Starter(name).from_template(*words)


@pytest.mark.runs
def test_reading_a_scene_imports_neither_sympy_nor_numpy(tmp_path):
    file = tmp_path / "p.toml"
    file.write_text(PENDULUM)
    slow = {"sympy", "numpy", "jinja2"}
    code = f"import sys, symdyn.scene as s; s.read({str(file)!r}); print({slow} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=dict(os.environ))

    assert run.stdout.strip() == "set()"


def test_a_file_is_read_by_path(tmp_path):
    file = tmp_path / "p.toml"
    file.write_bytes(b"\xef\xbb\xbf" + PENDULUM.encode())

    assert read(file) == read(str(file)) == read_text(PENDULUM, "p.toml")
    assert read(file).source == str(file)
