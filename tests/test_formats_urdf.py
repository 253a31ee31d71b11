"""URDF files become scenes with the file's own numbers, faults name the file's own parts, and text reads back."""

import random
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.errors import SceneError
from symdyn.runtime import lambdify
from symdyn.scene import Quantity, Scene, parse, read, read_noting
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.formats.placing import printable_names
from symdyn.scene.formats.urdf import read_element
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.entry import Faults
from symdyn.scene.values.grammar import check_name
from symdyn.scene.values.joint import Coupling, Limits

ARM = Path(__file__).parent / "data" / "gripper_arm.urdf"

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'

LINK = f'<link name="{{}}">{INERTIAL}</link>'

LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="2"/>'


def reading(inside: str, **options: bool) -> Reading:
    return read_element(
        XmlElement.parse(f'<robot name="r">\n{inside}\n</robot>'.encode(), "r.urdf"),
        Faults("r.urdf"),
        ReadOptions(**options),
    )


def joint(name: str, parent: str, child: str, inside: str = LIMIT, kind: str = "revolute") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def pendulum(inside: str = LIMIT, kind: str = "revolute") -> str:
    return f'<link name="base"/>\n{LINK.format("bob")}\n{joint("hinge", "base", "bob", inside, kind)}'


def faults(inside: str, **options: bool) -> str:
    with pytest.raises(SceneError, match=r"\Ar\.urdf: ") as caught:
        reading(inside, **options)
    return str(caught.value)


# Reading


def test_every_part_of_a_file_is_read_with_its_own_digits():
    scene = read(ARM)
    shoulder, elbow, wrist, right, left = scene.joints
    upper, forearm, palm, _, _ = scene.bodies

    assert scene.name == "gripper_arm"
    assert [j.name for j in scene.joints] == ["shoulder", "elbow", "wrist", "slide_right", "slide_left"]
    assert [j.type for j in scene.joints] == ["revolute", "revolute", "fixed", "prismatic", "prismatic"]
    assert scene.coordinates == ("q1", "q2", "q3")
    assert shoulder.parent == Scene.GROUND
    assert shoulder.origin.steps == (
        ("Tz", Quantity.number(Fraction(1, 2))),
        ("Rz", parse("-pi/4")),
        ("Rx", parse("pi/2")),
    )
    assert (shoulder.damping, shoulder.friction) == (Quantity.number(Fraction(1, 2)), Quantity.number(Fraction(1, 4)))
    assert shoulder.limits == Limits()
    assert elbow.axis == (Quantity.number(1), Quantity.number(0), Quantity.number(1))
    assert elbow.limits == Limits(parse("-2.5"), parse("2.5"), parse("3"), parse("40"))
    assert wrist.origin.steps[-1] == ("Ry", parse("1.57"))  # three digits are not π/2
    assert right.coupling == Coupling((("q3", Quantity.number(1)),), parse("0.001"))
    assert right.damping == parse("0.3")
    assert (left.coordinate, left.drive) == ("q3", "tau3")
    assert forearm.mass == parse("1.25")
    assert forearm.com == (parse("0.2"), parse("0.01"), parse("0"))
    assert upper.inertia == tuple(parse(x) for x in ("0.03", "0.02", "0.04", "-0.001", "0.003", "0.002"))
    assert palm.mass == Quantity.number(0)


def test_what_was_changed_or_left_out_is_noted():
    notes = [line.removeprefix(f"{ARM}: ") for line in read_noting(ARM).notes]

    assert notes == [
        'link "upper-arm": is called upper_arm here',
        'robot "gripper arm": is called gripper_arm here',
        "1.5707963 is read as pi/2 in line 6: link upper-arm <origin> rpy",
        "1.57079633 is read as pi/2 in line 45: joint shoulder <origin> rpy",
        "-0.7853981634 is read as -pi/4 in line 45: joint shoulder <origin> rpy",
        "damping enters the equations as -damping * rate (slide_right, shoulder)",
        "friction is kept as data and enters no equation (shoulder); write "
        "friction = { coulomb = 0.5, smoothing = 0.01 } in the scene to have it act",
        "coordinates: q1 shoulder, q2 elbow, q3 slide_left",
    ]


def test_without_snapping_angles_keep_their_digits():
    result = read_noting(ARM, snap=False)

    assert result.scene.joints[0].origin.steps[1:] == (("Rz", parse("-0.7853981634")), ("Rx", parse("1.57079633")))
    assert not [note for note in result.notes if "is read as" in note]


@pytest.mark.parametrize(
    "rpy", ["0.1 -0.2 0.3", "1.57079633 0 0", "0 0 3.14159265", "0 -1.57079633 0.5", "2 0 0", "0.25 0.5 -0.75"]
)
def test_a_rotated_inertia_is_r_i_r_transposed(rpy):
    entries = (0.3, 0.4, 0.5, 0.02, -0.03, 0.05)
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    shown = " ".join(f'{key}="{x}"' for key, x in zip(keys, entries, strict=True))
    inertial = f'<inertial><origin rpy="{rpy}"/><mass value="1"/><inertia {shown}/></inertial>'
    text = f'<link name="base"/><link name="bob">{inertial}</link>' + joint("hinge", "base", "bob", LIMIT)
    found = reading(text, snap=False).scene.bodies[0].inertia
    roll, pitch, yaw = (float(x) for x in rpy.split())
    R = turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)
    xx, yy, zz, xy, xz, yz = entries
    expected = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T

    values = [float(x.at({})) for x in found]
    assert np.allclose(values, expected[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], rtol=0, atol=1e-15)


def turn(axis: int, angle: float) -> np.ndarray:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[j, j] = R[k, k] = np.cos(angle)
    R[k, j] = np.sin(angle)
    R[j, k] = -R[k, j]
    return R


def test_the_axis_is_x_when_it_is_left_out():
    assert reading(pendulum()).scene.joints[0].axis == (Quantity.number(1), Quantity.number(0), Quantity.number(0))


def test_the_root_is_the_ground_and_a_mass_of_its_own_is_noted():
    text = LINK.format("base") + LINK.format("bob") + joint("hinge", "base", "bob")

    assert [body.name for body in reading(text).scene.bodies] == ["bob"]
    (note,) = reading(text).notes
    assert note.startswith(
        "r.urdf: line 2: link base: is the root and does not move; its mass (1 kg) enters no equation"
    )


def test_a_limit_without_bound_is_no_limit():
    inside = '<limit lower="-1e16" upper="inf" effort="1e9" velocity="3"/>'

    assert reading(pendulum(inside)).scene.joints[0].limits == Limits(velocity=Quantity.number(3))


def test_a_fixed_joint_drops_what_only_motion_gives_a_meaning():
    extra = '<dynamics damping="1" friction="2"/><mimic joint="hinge"/><axis xyz="0 0 0"/>'
    result = reading(pendulum() + LINK.format("tool") + joint("weld", "bob", "tool", extra, "fixed"))

    assert result.scene.joints[1].damping == Quantity.number(0)
    assert result.notes == (
        "r.urdf: damping of a fixed joint is left out (weld)",
        "r.urdf: friction of a fixed joint is left out (weld)",
        "r.urdf: mimic of a fixed joint is left out (weld)",
    )


def test_a_joint_that_follows_a_follower_follows_the_first():
    links = "".join(LINK.format(name) for name in "abcd")
    text = links + joint("j3", "c", "d", LIMIT + '<mimic joint="j2" multiplier="2" offset="1.5708"/>')
    text += joint("j2", "b", "c", LIMIT + '<mimic joint="j1" multiplier="-3" offset="0.5"/>') + joint("j1", "a", "b")
    couplings = {j.name: j.coupling for j in reading(text, snap=False).scene.joints}

    assert couplings == {
        "j1": None,
        "j2": Coupling((("q1", Quantity.number(-3)),), parse("1/2")),
        "j3": Coupling((("q1", Quantity.number(-6)),), parse("2.5708")),
    }


def test_what_a_file_draws_senses_or_drives_is_not_looked_at():
    noise = '<visual><origin rpy="a b c"/></visual><collision/><sensor name="s"/><gazebo/>'
    text = pendulum().replace("</link>", noise + "</link>") + "<transmission/><ros2_control/><gazebo><plugin/></gazebo>"

    assert reading(text).scene == reading(pendulum()).scene


def test_floating_and_planar_joints_have_several_coordinates_and_no_drive():
    text = pendulum() + LINK.format("boat") + LINK.format("drone")
    text += joint("sea", "base", "boat", '<axis xyz="0 0 1"/><dynamics damping="2"/>' + LIMIT, "planar")
    text += joint("air", "base", "drone", "", "floating")

    result = reading(text)

    sea, air = result.scene.joints[1:]
    assert (sea.type, sea.coordinates, sea.drives) == ("planar", ("q2", "q3", "q4"), (None,) * 3)
    assert (sea.axis, sea.damping) == ((Quantity.number(0), Quantity.number(0), Quantity.number(1)), Quantity.number(2))
    assert (air.type, dict(air.shape)["orientation"], air.rates[3:]) == (
        "free",
        "quaternion",
        ("air_wx", "air_wy", "air_wz"),
    )
    assert any("limit of a joint with several coordinates is left out (sea)" in note for note in result.notes)


def test_a_second_joint_on_a_link_closes_a_loop_with_a_note():
    result = reading(pendulum() + joint("other", "base", "bob"))

    assert [loop.name for loop in result.scene.loops] == ["other"]
    assert any("closes a loop and is cut" in note for note in result.notes)


# Faults


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (pendulum(LIMIT, "revolut"), r"type=\"revolut\" is not a joint of URDF; did you mean revolute\?"),
        (pendulum(""), r"line 4: joint hinge: <limit> is missing; give <limit lower=.* or make it type=\"continuous\""),
        (
            pendulum("", "prismatic"),
            r"<limit> is missing; give <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/>$",
        ),
        (
            pendulum('<limit lower="0" upper="1" velocity="1"/>'),
            r"<limit> has no effort; give a number such as effort=\"1\.0\"",
        ),
        (pendulum(LIMIT + '<axis xyz="0 0 0"/>'), r"line 4: joint hinge: axis = \[0, 0, 0\] has zero length"),
        (pendulum(LIMIT + '<axis xyz="0 1"/>'), r"<axis> xyz=\"0 1\" has 2 numbers; three are needed"),
        (pendulum(LIMIT + '<axis xyz="0 1 z"/>'), r"<axis> xyz=\"z\" is not a decimal number; write one such as 0\.35"),
        (pendulum(LIMIT + '<axis xyz="0 1 nan"/>'), r"xyz=\"nan\" is not a decimal number"),
        (pendulum(LIMIT + '<axis xyz="0 1 1_0"/>'), r"xyz=\"1_0\" is not a decimal number"),
        (pendulum(LIMIT + '<axis xyz="0 1 1e999"/>'), r"xyz=\"1e999\" cannot be used: .* beyond"),
        (pendulum(LIMIT + '<axis xyz="0 1 1e99999999999"/>'), r"is not a decimal number"),
        (pendulum(LIMIT + '<dynamics damping="-1"/>'), r"joint hinge: damping = -1 is negative"),
        (pendulum(LIMIT + '<mimic joint="hing"/>'), r"\"hing\" is not a joint; did you mean hinge\?"),
        (pendulum(LIMIT + '<mimic joint="hinge"/>'), r"joint hinge: mimic: the joint follows itself"),
        (pendulum(LIMIT + "<mimic/>"), r"<mimic> has no joint; name the joint to follow"),
        (pendulum().replace('<child link="bob"/>', ""), r"<child link=\"\.\.\.\"> is missing; name the link there"),
        (
            pendulum().replace('<child link="bob"/>', '<child link="bop"/>'),
            r"<child> link=\"bop\" is not a link; did you mean bob\?",
        ),
        (pendulum() + LINK.format("bob"), r"line 4: link bob: \"bob\" is already the name of line 3: link bob"),
        (pendulum() + joint("hinge", "base", "bob"), r"\"hinge\" is already the name"),
        (pendulum() + LINK.format("loose"), r"2 links are the child of no joint: base, loose; connect all but one"),
        (pendulum() + joint("back", "bob", "base"), r"every link is the child of a joint; a URDF is a tree"),
        (pendulum() + '<link name=" "/>', r"line 4: <link> has no name; give one such as name=\"link_1\""),
        (
            pendulum().replace('<mass value="1"/>', ""),
            r"<inertial> has no <mass>; give both mass and inertia, or leave out",
        ),
        (
            pendulum().replace('<mass value="1"/>', "<mass/>"),
            r"<mass> has no value; give a number such as value=\"1\.0\"",
        ),
        (pendulum().replace('ixx="1"', ""), r"line 3: link bob: <inertia> has no ixx"),
        (pendulum().replace('value="1"', 'value="-1"'), r"line 3: link bob: mass = -1 is negative"),
        (
            pendulum().replace('ixx="1"', 'ixx="3"'),
            r"line 3: link bob: inertia .* break the triangle .*allow_invalid_inertia=True",
        ),
        ("", r"there is no <link>"),
        (LINK.format("alone"), r"nothing moves"),
    ],
    ids=range(29),
)
def test_a_fault_names_line_part_and_way_out(inside, words):
    assert re.search(words, faults(inside), re.MULTILINE)


def test_all_faults_of_a_file_come_together():
    text = pendulum("<axis xyz='0 0 0'/>").replace('ixx="1"', 'ixx="7"') + LINK.format("loose")

    found = faults(text).splitlines()
    for words in ("<limit> is missing", "zero length", "triangle", "2 links are the child of no joint"):
        assert [line for line in found if words in line], words


def test_invalid_inertias_are_notes_when_they_are_allowed():
    text = pendulum().replace('ixx="1"', 'ixx="3"')
    result = reading(text, allow_invalid_inertia=True)

    assert result.scene.bodies[0].allow_invalid_inertia
    (note,) = result.notes
    assert re.match(r"r\.urdf: line 3: link bob: inertia .* break the triangle inequality", note)


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (
            '<link name="${prefix}base"/>',
            r'line 2: <link> name="\$\{prefix\}base" is an expression of xacro; run xacro first',
        ),
        (
            '<m xmlns:x="http://www.ros.org/wiki/xacro"><x:macro/></m>',
            r"line 2: <xacro:macro> is a macro; run xacro first",
        ),
    ],
)
def test_xacro_is_refused_in_one_line(inside, words):
    found = faults(inside)

    assert re.search(words, found)
    assert "\n" not in found


def test_another_root_is_refused():
    with pytest.raises(SceneError, match=r"its root is <sdf>; the root of a URDF is <robot>"):
        read_element(XmlElement.parse((b"<sdf/>"), "x.urdf"), Faults("x.urdf"), ReadOptions())


# Names


def test_names_become_printable_and_stay_apart():
    names = [
        "left-arm",
        "left_arm",
        "left arm",
        "q",
        "1st",
        "ground",
        "x_dot",
        "",
        "ä",
        "while",
        "good",
        "q",
        "_x",
        "é" * 99,
    ]
    found = printable_names(names, "link")

    assert found["good"] == "good"
    assert found["left_arm"] == "left_arm"
    assert (found["left-arm"], found["left arm"], found["q"]) == ("left_arm_2", "left_arm_3", "q")
    assert (found["1st"], found["ground"], found["x_dot"]) == ("link_1st", "ground_link", "x_dot_link")
    assert len(set(found.values())) == len(found)
    assert all(check_name(name) is None and name != Scene.GROUND for name in found.values())


# Anything at all


WORDS = ("", "nan", "1e400", "-1", "0 0 0", "ground", "world", "palm", "q", "fixed", "floating", "9" * 50, "${x}")


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("seed", range(150))
def test_a_file_that_was_damaged_is_a_scene_or_a_list_of_faults(seed):
    rng = random.Random(seed)
    text = ARM.read_text()
    for _ in range(rng.randint(1, 3)):
        found = rng.choice(list(re.finditer('"([^"]*)"', text)))
        text = text[: found.start(1)] + rng.choice(WORDS) + text[found.end(1) :]
    text = text if rng.random() < 0.5 else text.replace(rng.choice(re.findall("<[a-z_]+[^<>]*/>", text)), "", 1)

    lines = outcome(text)
    assert lines
    assert all(re.match(r"(r\.urdf: .|q\d)", line) and "\n" not in line for line in lines)


def outcome(text: str) -> tuple[str, ...]:
    """Return the faults of a file, or its coordinates if it has no fault."""
    try:
        return read_element(
            XmlElement.parse(text.encode(), "r.urdf"), Faults("r.urdf"), ReadOptions()
        ).scene.coordinates
    except SceneError as error:
        return error.faults


# Slips that other readers pass over


@pytest.mark.mends("4.inertia")
def test_an_inertial_without_inertia_is_a_point_mass(tmp_path):
    """Pinocchio, too, takes the mass at its origin and no inertia about it: M = m l²."""
    point = '<inertial><origin xyz="0 0 0.5" rpy="1 2 3"/><mass value="4"/></inertial>'
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r">{pendulum().replace(INERTIAL, point)}</robot>')
    result = read_noting(path)

    assert any("without <inertia> is read as a point mass at its origin" in note for note in result.notes)
    assert lambdify(result.scene, "mass_matrix")([0.3]) == pytest.approx(4 * 0.5**2, rel=1e-15)


def test_limits_that_are_swapped_name_line_joint_and_both_numbers():
    swapped = LIMIT.replace('lower="-1"', 'lower="1"').replace('upper="1"', 'upper="-0.5"')
    assert (
        faults(pendulum(swapped)) == 'r.urdf: line 4: joint hinge: <limit> lower="1" is above upper="-0.5"; swap them'
    )


# A base that floats

ROBOT = f"""<link name="base">{INERTIAL.replace('mass value="1"', 'mass value="3"')}</link>
{LINK.format("bob")}
{joint("hinge", "base", "bob", '<origin xyz="0 0.2 0.1" rpy="0.3 0 0"/><axis xyz="0 1 0"/>' + LIMIT)}"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{ROBOT}</robot>')
    return path


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.mends("4.floating")
@pytest.mark.parametrize("verb", [["info"], ["generate", "-o", "{out}"], ["convert", "{out}.toml"], ["info", "--json"]])
def test_every_verb_that_reads_a_robot_lets_its_base_float(robot, tmp_path, capsys, verb):
    words = [word.format(out=tmp_path / "out") for word in verb]
    try:
        status = main([words[0], str(robot), *words[1:], "--floating-base", "trunk"])
    except SystemExit as usage:
        status = usage.code
    said = capsys.readouterr()
    assert status == 0, said.err


def test_a_floating_base_carries_the_mass_of_the_root_and_moves_the_joints_as_before(robot):
    still, free = read(robot), read(robot, floating_base="trunk")
    M, tau = lambdify(free, ("mass_matrix", "inverse_dynamics"))
    q, u = [0, 0, 0, 1, 0, 0, 0, 0.4], np.zeros(7)

    assert [j.name for j in free.joints] == ["trunk", "hinge"]
    assert free.joints[0].type == "free"
    assert not any(free.joints[0].drives)
    assert [b.name for b in free.bodies] == ["base", "bob"]
    np.testing.assert_allclose(np.diag(M(q))[:3], 4, rtol=1e-15)
    np.testing.assert_allclose(tau(q, u, u)[:3], [0, 0, 4 * 9.81], atol=1e-13)
    np.testing.assert_allclose(tau(q, u, u)[6:], lambdify(still, "inverse_dynamics")([0.4], [0], [0]), atol=1e-14)
    assert not any("does not move" in note for note in read_noting(robot, floating_base="trunk").notes)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("hinge", "there is a joint hinge already; give the base another name, such as hinge_joint"),
        ("my base", "is not a plain identifier; .* such as my_base"),
        ("", "is empty; give a name"),
    ],
)
def test_a_floating_base_needs_a_name_of_its_own(robot, name, words):
    with pytest.raises(SceneError, match=f"floating base: .*{words}"):
        read(robot, floating_base=name)


def test_what_floats_already_or_has_no_base_is_told(robot, tmp_path):
    robot.write_text(f'<robot name="r">{pendulum("", "floating")}</robot>')
    with pytest.raises(SceneError, match="the joint hinge sets the robot free already; leave the floating base out"):
        read(robot, floating_base="trunk")
    for file, words in (("rx90.par", "gives its base no mass"), ("dead_centre.toml", 'type = "free"')):
        with pytest.raises(SceneError, match=f"only robots in URDF and MJCF are set free; .*{words}"):
            read(ARM.parent / file, floating_base="trunk")


# What a robot file has no words for


@pytest.mark.mends("4.poses")
def test_info_tells_how_the_pose_of_the_tool_is_asked_for(robot, capsys):
    """A URDF declares no points, so no pose is among the functions; what is told gives the pose of the last link."""
    assert main(["info", str(robot)]) == 0
    told = re.search(r"--functions (\S+)", capsys.readouterr().out)

    assert told is not None, "info tells how poses are asked for"
    assert lambdify(read(robot), told[1].split(",")[0])([0.0]) == pytest.approx(
        np.array([[1, 0, 0, 0], [0, np.cos(0.3), -np.sin(0.3), 0.2], [0, np.sin(0.3), np.cos(0.3), 0.1]])
    )


@pytest.mark.wide("numpy")
@pytest.mark.long(0)
@pytest.mark.mends("4.names")
@pytest.mark.parametrize("target", ["numpy", "c", "js"])
def test_generated_code_tells_whose_positions_the_coordinates_are(tmp_path, capsys, target):
    assert main(["generate", str(ARM), "--target", target, "-o", str(tmp_path)]) == 0
    texts = [file.read_text("utf-8") for file in tmp_path.iterdir()]

    assert "coordinates: q1 shoulder, q2 elbow, q3 slide_left" in capsys.readouterr().err
    assert any("q1 shoulder, q2 elbow, q3 slide_left" in text for text in texts)


@pytest.mark.long(0)
@pytest.mark.mends("4.digits")
def test_numbers_that_info_prints_are_exact_and_short_or_rounded_and_marked(robot, capsys):
    long = LIMIT.replace('lower="-1"', 'lower="-2.0943951023931953"')
    robot.write_text(robot.read_text().replace(LIMIT, long + '<dynamics damping="0.12345678901234"/>'))
    printed = ""
    for more in ([], ["--base-parameters"], ["--symbolic", "inertia"]):
        assert main(["info", str(robot), *more]) == 0
        printed += capsys.readouterr().out

    assert not re.search(r"\d[.]?\d{9,}", printed)
    assert "from ≈ -2.0944 to 1" in printed
    assert "damping ≈ 0.123457" in printed
    assert main(["info", str(robot), "--json"]) == 0
    assert "-2.0943951023931953" in capsys.readouterr().out
