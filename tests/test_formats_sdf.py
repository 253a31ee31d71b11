"""SDF files become scenes that stand and move as the file says; what cannot be read is told with what would work."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.errors import SceneError
from symdyn.runtime import lambdify
from symdyn.scene import parse, read, read_noting, read_text
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.formats.placing import placement
from symdyn.scene.formats.sdf import read_element
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.entry import Faults
from symdyn.scene.values.joint import Limits

ARM = Path(__file__).parent / "data" / "arm.sdf"

INERTIAL = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"

LINKS = f'<link name="a">{INERTIAL}</link><link name="b"><pose relative_to="a">1 0 0 0 0 0</pose>{INERTIAL}</link>\n'

AXIS = "<axis><xyz>0 0 1</xyz></axis>"


def joint(inside: str = AXIS, kind: str = "revolute", parent: str = "a", child: str = "b", name: str = "hinge") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


WELD = joint("", "fixed", "world", "a", "weld")


def parsed(text: str, **options: object) -> Reading:
    return read_element(XmlElement.parse(text.encode(), "m.sdf"), Faults("m.sdf"), ReadOptions(**options))


def reading(inside: str, version: str = "1.9", **options: object) -> Reading:
    return parsed(f'<sdf version="{version}"><model name="m">\n{inside}\n</model></sdf>', **options)


def faults(inside: str, **options: object) -> str:
    with pytest.raises(SceneError, match=r"\Am\.sdf: ") as caught:
        reading(inside, **options)
    return str(caught.value)


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return a rotation by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose(x: float, y: float, z: float, roll: float = 0, pitch: float = 0, yaw: float = 0) -> np.ndarray:
    """Return the matrix of a pose, from what the specification says of its six numbers."""
    X = np.eye(4)
    X[:3, :3] = turn(np.eye(3)[2], yaw) @ turn(np.eye(3)[1], pitch) @ turn(np.eye(3)[0], roll)
    X[:3, 3] = x, y, z
    return X


def moved(R: np.ndarray | None = None, p: np.ndarray | None = None) -> np.ndarray:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = (np.eye(3) if R is None else R), (np.zeros(3) if p is None else p)
    return X


# What the file says


def test_every_part_of_a_file_is_read():
    scene = read(ARM)
    stand, shoulder, slide, screw = scene.joints

    assert scene.name == "arm"
    assert [one.name for one in scene.bodies] == ["base", "upper_arm", "forearm", "nut"]
    assert [(one.type, one.parent, one.child) for one in scene.joints] == [
        ("fixed", "ground", "base"),
        ("revolute", "base", "upper_arm"),
        ("prismatic", "upper_arm", "forearm"),
        ("helical", "forearm", "nut"),
    ]
    assert shoulder.limits == Limits(parse("-2"), parse("2"), None, parse("50"))
    assert shoulder.damping == parse("0.3")
    assert [(s.joint, s.stiffness, s.free) for s in scene.struts] == [("shoulder", (parse("4"),), parse("0.2"))]
    assert (slide.drive, slide.limits, screw.drive) == (None, Limits(), "tau3")
    assert dict(screw.shape)["pitch"] == parse("0.05")
    assert [one.name for one in scene.points] == ["elbow"]
    assert scene.points[0].at.steps == (("Tx", parse("0.4")), ("Tz", parse("0.1")), ("Rx", parse("pi/6")))
    assert stand.name == "stand"


def test_what_was_changed_or_left_out_is_noted():
    assert [line.removeprefix(f"{ARM}: ") for line in read_noting(ARM).notes] == [
        "what is static is left aside (floor)",
        'link "upper-arm": is called upper_arm here',
        "1.5707963 is read as pi/2 in line 16: link upper-arm <pose> rpy",
        "coordinates: q1 shoulder, q2 slide, q3 screw",
    ]


@pytest.mark.parametrize("q", [(0, 0, 0), (0.7, -0.3, 1.9), (-1.2, 0.4, 0)])
def test_links_stand_and_move_where_the_file_says(q):
    """Computed from the specification with matrices: another way from poses to places than ours."""
    model = pose(0.1, 0.2, 0.3, 0, 0, 0.4) @ pose(0.05, 0, 0.1, 0, 0.3)
    base = pose(0, 0, 0.1, 0.1, 0.2, 0.3)
    upper = base @ pose(0.3, 0, 0.2, 0, np.pi / 2, 0.2)
    forearm = upper @ pose(0.4, 0, 0.1, np.pi / 6) @ pose(0.1, 0.1, 0, 0, 0, np.pi / 2)
    nut = pose(0.9, 0.3, 1, 0.3, -0.4, 1.1)
    hinge = upper @ pose(0, 0.05, 0, 0.1)
    axis = hinge[:3, :3].T @ np.array([0, 0.6, 0.8])
    X = model @ hinge @ moved(turn(axis, q[0])) @ np.linalg.inv(hinge)
    at_elbow = X @ upper @ pose(0.4, 0, 0.1, np.pi / 6)
    X = X @ forearm @ moved(p=np.array([q[1], 0, 0])) @ np.linalg.inv(forearm)
    at_forearm = X @ forearm
    y = np.array([0, 1, 0])
    X = X @ nut @ moved(turn(y, q[2]), 0.05 * q[2] / (2 * np.pi) * y)
    elbow, lower, end = lambdify(read(ARM), ("pose:elbow", "pose:forearm", "pose:nut"))

    for found, expected in ((elbow, at_elbow), (lower, at_forearm), (end, X)):
        assert found(np.array(q, float)) == pytest.approx(expected[:3], abs=1e-15 * 8)


def test_poses_that_are_given_in_one_another_are_exact():
    scene = reading(
        LINKS + '<frame name="f"><pose degrees="True">0.1 0 0 90 0 45</pose></frame>' + WELD + joint()
    ).scene

    assert scene.joints[1].origin.steps == (("Tx", parse("1")),)
    assert scene.joints[1].tip.steps == ()
    assert scene.points[0].at.steps == (("Tx", parse("0.1")), ("Rz", parse("pi/4")), ("Rx", parse("pi/2")))


def test_right_angles_between_poses_of_the_model_stay_exact():
    links = (
        f'<link name="a"><pose>0.1 0.2 0.3 1.57079632679 0 0</pose>{INERTIAL}</link>'
        f'<link name="b"><pose>1.1 0.2 0.7 1.57079632679 0 1.57079632679</pose>{INERTIAL}</link>'
    )
    hinge = reading(links + WELD + joint()).scene.joints[1]

    assert hinge.origin.steps == (("Tx", parse("1")), ("Ty", parse("0.4")), ("Ry", parse("pi/2")))


@pytest.mark.parametrize(
    ("version", "inside", "axis"),
    [
        ("1.4", AXIS, (0, 1, 0)),
        ("1.5", AXIS, (0, 0, 1)),
        ("1.9", AXIS, (0, 0, 1)),
        ("", AXIS, (0, 0, 1)),
        ("1.6", AXIS.replace("</axis>", "<use_parent_model_frame>1</use_parent_model_frame></axis>"), (0, 1, 0)),
        ("1.9", '<axis><xyz expressed_in="__model__">0 0 1</xyz></axis>', (0, 1, 0)),
        ("1.9", '<axis><xyz expressed_in="a">0 0 1</xyz></axis>', (0, 1, 0)),
    ],
)
def test_an_axis_is_in_its_joint_but_where_the_file_or_its_version_says_otherwise(version, inside, axis):
    links = LINKS.replace("1 0 0 0 0 0", "1 0 0 1.57079632679 0 0")

    assert [float(x.at({})) for x in reading(links + WELD + joint(inside), version).scene.joints[1].axis] == list(axis)


@pytest.mark.parametrize(
    ("said", "pitch"),
    [
        ("<screw_thread_pitch>0.01</screw_thread_pitch>", "0.01"),
        ("<thread_pitch>-4</thread_pitch>", "pi/2"),
        ("<screw_thread_pitch>0.02</screw_thread_pitch><thread_pitch>7</thread_pitch>", "0.02"),
    ],
)
def test_a_screw_is_right_handed_and_its_old_key_is_not(said, pitch):
    assert dict(reading(LINKS + WELD + joint(said + AXIS, "screw")).scene.joints[1].shape)["pitch"] == parse(pitch)


def test_two_axes_turn_one_after_the_other():
    axes = "<axis><xyz>1 0 0</xyz><limit><effort>0</effort></limit></axis><axis2><xyz>0 1 0</xyz></axis2>"
    scene = reading(LINKS + WELD + joint(axes, "universal")).scene
    R = lambdify(scene, "pose:b")(np.array([0.4, 0.9]))[:, :3]

    assert turn(np.eye(3)[0], 0.4) @ turn(np.eye(3)[1], 0.9) == pytest.approx(R, abs=1e-15)
    assert scene.joints[1].drives == (None, "tau2")


def test_what_an_inertial_leaves_out_is_one():
    text = '<link name="a"/><link name="b"><inertial><mass>3</mass></inertial></link>' + WELD + joint()
    result = reading(text)

    assert [body.mass for body in result.scene.bodies] == [parse("1"), parse("3")]
    assert result.scene.bodies[0].inertia[:3] == (parse("1"),) * 3
    assert "m.sdf: what <inertial> leaves out is 1 kg and 1 kg m^2, as SDF has it (a, b)" in result.notes


@pytest.mark.parametrize(
    ("world", "gravity"),
    [
        ("<gravity>1 2 -3.5</gravity>", ("1", "2", "-3.5")),
        ("", ("0", "0", "-9.8")),
        (None, ("0", "0", "-9.81")),
    ],
)
def test_gravity_is_that_of_the_world(world, gravity):
    model = f'<model name="m">{LINKS}{WELD}{joint()}</model>'
    inside = model if world is None else f'<world name="w">{world}{model}</world>'

    assert parsed(f'<sdf version="1.9">{inside}</sdf>').scene.gravity == tuple(parse(x) for x in gravity)


def test_links_that_gravity_does_not_pull():
    text = LINKS + WELD + joint()
    none = text.replace("</link>", "<gravity>false</gravity></link>")

    assert reading(none).scene.gravity == (parse("0"),) * 3
    assert "<gravity> is false for some links and not for others (a)" in faults(
        none.replace("<gravity>false</gravity>", "", 2).replace("</link>", "<gravity>0</gravity></link>", 1)
    )


# What floats, what closes


FREE = '<pose>0.1 0 0.5 0 0 1.57079632679</pose><link name="a"><pose>0 0.2 0 3.14159265359 0 0</pose></link>'


def test_a_model_that_nothing_ties_to_the_world_is_free_and_starts_where_it_stands():
    result = reading(FREE)
    (base,) = result.scene.joints

    assert (base.name, base.type, base.drives) == ("a_free", "free", (None,) * 6)
    assert [float(x.at({})) for x in base.start] == pytest.approx([-0.1, 0, 0.5, 0, 0.5**0.5, 0.5**0.5, 0], abs=1e-15)
    assert "a fixed joint with <parent>world</parent> would hold one (a)" in result.notes[-1]
    X = lambdify(result.scene, "pose:a")(np.array([float(x.at({})) for x in base.start]))
    assert (pose(0.1, 0, 0.5, 0, 0, np.pi / 2) @ pose(0, 0.2, 0, np.pi))[:3] == pytest.approx(X, abs=1e-15)


def test_the_name_of_a_floating_base_is_that_of_the_one_there_is():
    assert reading(FREE, floating_base="root").scene.joints[0].name == "root"
    assert "0 parts of the model are free" in faults(LINKS + WELD + joint(), floating_base="root")
    assert "2 parts of the model are free" in faults(LINKS, floating_base="root")


def test_the_root_of_what_floats_is_the_link_that_nothing_carries():
    scene = reading(LINKS + joint(parent="b", child="a")).scene

    assert [(one.parent, one.child) for one in scene.joints] == [("ground", "b"), ("b", "a")]
    assert [one.type for one in scene.joints] == ["free", "revolute"]


PARALLELOGRAM = (
    f'<link name="a"><pose>0 0 0 0 0 0</pose>{INERTIAL}</link><link name="b"><pose>0 1 0 0 0 0</pose>{INERTIAL}</link>'
    f'<link name="c"><pose>3 0 0 0 0 0</pose>{INERTIAL}</link>'
    + "".join(
        joint(name=name, parent=p, child=c)
        for name, p, c in (("j1", "world", "a"), ("j2", "a", "b"), ("j3", "world", "c"))
    )
    + '<joint name="j4" type="revolute"><pose relative_to="c">0 1 0 0 0 0</pose><parent>b</parent><child>c</child>'
)

TWIN = """
name = "m"
[bodies]
a = { mass = 1, inertia = [1, 1, 1] }
b = { mass = 1, inertia = [1, 1, 1] }
c = { mass = 1, inertia = [1, 1, 1] }
[joints]
j1 = { type = "revolute", parent = "ground", child = "a" }
j2 = { type = "revolute", parent = "a", child = "b", origin = [0, 1, 0] }
j3 = { type = "revolute", parent = "ground", child = "c", origin = [3, 0, 0] }
[[loop]]
name = "j4"
type = "revolute"
parent = "b"
child = "c"
origin = [3, 0, 0]
child_origin = [0, 1, 0]
"""


@pytest.mark.parametrize(
    "cut", ["", "<physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics>"]
)
def test_a_joint_too_many_closes_a_loop(cut):
    scene, twin = reading(PARALLELOGRAM + AXIS + cut + "</joint>").scene, read_text(TWIN)
    (loop,) = scene.loops
    q, v, tau = np.array([0.3, -0.3, 0.3]), np.array([0.7, -0.7, 0.7]), np.array([0.2, -0.1, 0.4])

    assert (loop.name, loop.parent, loop.child) == ("j4", "b", "c")
    for output, arguments in (("constraint_jacobian", (q,)), ("forward_dynamics", (q, v, tau))):
        found, expected = lambdify(scene, output)(*arguments), lambdify(twin, output)(*arguments)
        assert found == pytest.approx(expected, abs=1e-14)
        assert np.max(np.abs(expected)) > 0.1


# What is refused


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        ("", "line 1: model: there is no <link>; a model has one at least"),
        (LINKS + LINKS, 'line 3: link a: the name "a" is that of line 2: link a, too; rename one of them'),
        (LINKS + WELD + joint(name="b"), 'joint b: the name "b" is that of line 2: link b, too'),
        ('<link name="__model__"/>', "that of what SDF calls so itself, too; rename"),
        (
            '<link name="a"><pose relative_to="b"/></link><link name="b"><pose relative_to="f"/></link>'
            '<frame name="f"><pose relative_to="a"/></frame>',
            "relative_to goes in a circle: a -> b -> f -> a; give one in __model__",
        ),
        ('<link name="a"><pose relative_to="a"/></link>', "relative_to goes in a circle: a -> a"),
        (
            '<link name="a"/><frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>',
            "attached_to goes in a circle: f -> g -> f",
        ),
        (
            '<link name="a"><pose relative_to="bb"/></link><link name="b"/>',
            'relative_to="bb" is not a frame of this file; did you mean b?',
        ),
        ('<link name="a"><pose relative_to="x::y"/></link>', "what is inside of nested models is not read"),
        (LINKS + WELD + joint(parent="c"), 'joint hinge: parent="c" is not a frame of this file; known are a, b, weld'),
        (LINKS + joint(child="world"), "<child> is the world, which carries and is not carried; swap"),
        (
            LINKS + WELD + '<joint name="j" type="ball"><child>b</child></joint>',
            "<joint> has no parent; name a link as its <parent>",
        ),
        (LINKS + WELD + joint(kind="hinge"), 'type="hinge" is not read; did you mean revolute?'),
        (LINKS + WELD + joint(kind="gearbox"), 'type="gearbox" is not read; write <mimic> in an <axis>'),
        (LINKS + WELD + joint(""), "<axis> is missing; give <axis><xyz>0 0 1</xyz></axis>"),
        (LINKS + WELD + joint(AXIS, "universal"), "<axis2> is missing"),
        (LINKS + WELD + joint(AXIS, "screw"), "has no pitch; give <screw_thread_pitch>, m a turn"),
        (LINKS + WELD + joint("<axis><xyz>0 0</xyz></axis>"), '<axis> xyz="0 0" has 2 numbers; three are needed'),
        (LINKS + WELD + joint("<axis><xyz>0 0 0</xyz></axis>"), "has zero length; give a direction"),
        (
            LINKS + WELD + joint('<axis><xyz expressed_in="z">0 0 1</xyz></axis>'),
            'expressed_in="z" is not a frame of this file',
        ),
        (
            LINKS + WELD + joint(AXIS.replace("</axis>", "<limit><lower>2</lower><upper>1</upper></limit></axis>")),
            "swap them",
        ),
        (
            LINKS + WELD + joint(AXIS.replace("</axis>", '<mimic joint="z"/></axis>')),
            'mimic.joint = "z" is not a joint',
        ),
        (
            LINKS + WELD + joint(AXIS.replace("</axis>", '<mimic joint="weld" axis="axis2"/></axis>')),
            "<mimic> of an axis2 is not read",
        ),
        (
            LINKS
            + WELD
            + joint(
                AXIS.replace("</axis>", "<dynamics><damping>1</damping></dynamics></axis>")
                + "<axis2><xyz>1 0 0</xyz></axis2>",
                "universal",
            ),
            "damping of its two axes differs, and a joint has one; make them equal",
        ),
        (
            LINKS + WELD + joint("<axis><dynamics><spring_stiffness>1</spring_stiffness></dynamics></axis>", "ball"),
            "a spring, or <mimic>, of a ball joint is not read; write two revolute joints",
        ),
        (
            LINKS.replace("1 0 0 0 0 0", "1e400 0 0 0 0 0"),
            'link b: <pose> xyz="1e400" cannot be used: a number is beyond',
        ),
        (LINKS.replace("1 0 0 0 0 0", "inf 0 0 0 0 nan"), '<pose> xyz="inf" is not a decimal number'),
        (LINKS.replace("1 0 0 0 0 0", "1 0 0"), '<pose> "1 0 0" has 3 numbers; it takes six: x y z roll pitch yaw'),
        (LINKS.replace("1 0 0 0 0 0", "1 0 0" + " " * 2000 + "0 0 0"), "has 4 numbers"),
        (
            LINKS.replace('relative_to="a">1', 'rotation_format="quat_xyzw">0 1'),
            "has a quaternion of length zero; that of no turn is 0 0 0 1",
        ),
        (
            LINKS.replace('relative_to="a"', 'rotation_format="quat"'),
            'rotation_format="quat" is unknown; did you mean quat_xyzw?',
        ),
        (LINKS.replace("<mass>1", "<mass>one"), '<inertial> mass="one" is not a decimal number'),
        (LINKS.replace("<mass>1", "<mass>-1") + WELD + joint(), "mass = -1 is negative"),
        (LINKS.replace("<ixx>1", "<ixx>9") + WELD + joint(), "is not physically consistent"),
        (
            LINKS.replace("<inertial>", '<inertial auto="true">'),
            "<inertial auto> takes the inertia from shapes, which are not read; gz sdf",
        ),
        (LINKS.replace("<inertial>", "<pose/><pose/><inertial>"), "a second <pose> of one <link>; keep one of them"),
        (LINKS.replace("<inertial>", "<inertial><pose/><pose/>"), "a second <pose> of one <inertial>; keep one"),
        (LINKS + WELD + joint(AXIS + AXIS), "a second <axis> of one <joint>; keep one of them"),
        (LINKS + "<pose/><pose/>", "a second <pose> of one <model>; keep one of them"),
        (LINKS.replace("<inertial>", '<inertial><pose relative_to="b"/>'), "it is in its link; delete relative_to"),
        (LINKS.replace("<inertial>", "<inertial><fluid_added_mass/>"), "<fluid_added_mass> is not read; write [loads]"),
        (LINKS.replace("<inertial>", "<velocity_decay/><inertial>"), "drag by <velocity_decay> is not read"),
        (LINKS.replace("<inertial>", "<kinematic>true</kinematic><inertial>"), "is <kinematic>, moved by a program"),
        (
            LINKS + '<model name="n"/>',
            "line 3: a nested model is not read; move its links and joints into the outer one; gz sdf -p",
        ),
        (
            LINKS + WELD + joint(AXIS.replace("</axis>", "<mimic/></axis>")),
            "<mimic> has no joint; name the joint to follow",
        ),
        (LINKS + "<include/>", "line 3: an <include> is not read; gz sdf -p FILE > whole.sdf writes it out"),
        (LINKS + "<static>yes</static>", 'line 1: <model> static="yes" is not a boolean; write true or false'),
        (LINKS.replace('relative_to="a"', 'degrees="yes"'), '<pose> degrees="yes" is not a boolean'),
        (LINKS + "<static>1</static>", "there is no <model> that moves; m is static: delete <static>"),
        (LINKS + WELD + joint("", "fixed"), "nothing moves"),
    ],
)
def test_what_cannot_be_read_is_told_with_what_would_work(inside, words):
    assert words in faults(inside)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<sdf/>", "there is no <model> that moves"),
        ("<robot/>", "its root is <robot>; the root of an SDF file is <sdf>"),
        ('<sdf><model name="m"/><model name="n"/></sdf>', "line 1: there are 2 models that move; keep one in a file"),
        ('<sdf><world name="a"/><world name="b"/><model name="m"/></sdf>', "there are 2 worlds; keep one in a file"),
        ('<sdf><world name="a"><include/></world></sdf>', "an <include> is not read; delete it if it is scenery"),
        ('<sdf><world name="a"><joint/><model name="m"/></world></sdf>', "a joint between models is not read"),
        (
            '<sdf><world name="a"><model name="m"><pose relative_to="x"/><link name="l"/></model></world></sdf>',
            'relative_to="x" is not a frame of this file; known are m, world',
        ),
        ('<!DOCTYPE x [<!ENTITY a "1">]><sdf/>', "a document type or an entity is not read"),
    ],
)
def test_what_is_no_file_of_one_model_is_told(text, words):
    with pytest.raises(SceneError) as caught:
        parsed(text)
    assert words in str(caught.value)


@pytest.mark.parametrize("chained", [True, False])
def test_what_is_many_poses_away_stands_where_it_should(chained):
    """Each link is given in the one before it: what joins the last one to the world is a hundred poses away."""
    n, step = 100, "0.01 0 0.02 0.1 0.2 0.3"
    text = ""
    for k in range(n):
        base, last = f"l{k - 1}" if k else "__model__", k == n - 1
        text += f'<link name="l{k}"><pose relative_to="{base}">{step}</pose></link>'
        parent = base if k and chained and not last else "world"
        text += joint(AXIS if last else "", "revolute" if last else "fixed", parent, f"l{k}", f"j{k}")
    p, R = placement(reading(text).scene.joints[-1].origin, {})
    X = np.linalg.matrix_power(pose(*map(float, step.split())), n)

    assert np.array(R, float) == pytest.approx(X[:3, :3], abs=1e-14)
    assert np.array(p, float) == pytest.approx(X[:3, 3], abs=1e-14)


# Verbs


def test_verbs_take_a_file(capsys, tmp_path):
    small = tmp_path / "m.world"
    small.write_text(f'<sdf version="1.9"><model name="m">{LINKS}{WELD}{joint()}</model></sdf>')

    assert main(["info", str(small), "--json"]) == 0
    assert [one["name"] for one in json.loads(capsys.readouterr().out)["result"]["joints"]] == ["weld", "hinge"]
    assert main(["equations", str(small), "--format", "text"]) == 0
    assert "q1_ddot" in capsys.readouterr().out
    assert main(["convert", str(ARM), str(tmp_path / "arm.toml")]) == 0
    assert read(tmp_path / "arm.toml") == read(ARM)
    assert main(["convert", str(tmp_path / "arm.toml"), str(tmp_path / "arm.sdf")]) == 0
    assert read(tmp_path / "arm.sdf").joints == read(ARM).joints
