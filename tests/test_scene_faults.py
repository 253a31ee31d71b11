"""Every mistake in a scene is named: file, table, what was found, what would work; and all of them together."""

import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from placeless import placeless

from symdyn.errors import SceneError
from symdyn.scene import Scene, body, dh_table, parameter, point, read, read_text, revolute, scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values.body import impossible

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.toml"))

GOOD = """\
gravity = [0, 0, "-g"]

[parameters]
g = 9.81
m1 = { value = 2, positive = true }
l1 = {}

[bodies.link1]
mass = "m1"
com = [0, "-l1/2", 0]
inertia = [1, 1, 1]
inertia_about = "com"

[bodies.link2]
mass = 1

[joints.shoulder]
type = "revolute"
parent = "ground"
child = "link1"
axis = [0, 0, 1]

[joints.elbow]
type = "prismatic"
parent = "link1"
child = "link2"
axis = [0, 0, 1]
force = "-3*m1*q2_dot"

[points.tool]
body = "link2"
"""


def faults(text):
    with pytest.raises(SceneError, match=r"^arm\.toml:\d+: ") as caught:
        read_text(text, "arm.toml")
    return tuple(map(placeless, caught.value.faults))


def test_the_scene_that_the_faults_are_put_into_is_good():
    assert read_text(GOOD, "arm.toml").coordinates == ("q1", "q2")


EDITS = [
    # (what stands in the good scene, what is put in its place, the fault)
    ("axis = [0, 0, 1]\nforce", "axis = [0, 0, 0]\nforce",
     "joints.elbow: axis = [0, 0, 0] has zero length; give a direction such as [0, 0, 1]"),
    ("axis = [0, 0, 1]\nforce", 'axis = [0, "sin(pi)", 0]\nforce',
     "joints.elbow: axis = [0, sin(pi), 0] has zero length; give a direction such as [0, 0, 1]"),
    ("axis = [0, 0, 1]\nforce", 'axis = [0, "l1", 1]\nforce',
     "joints.elbow: axis = [0, l1, 1] depends on l1; give numbers, and tilt by origin.rpy instead"),
    ("axis = [0, 0, 1]\nforce", "axis = [0, 1]\nforce",
     "joints.elbow: axis = [0, 1] has 2 entries; three are needed, such as [0, 0, 1]"),
    ("axis = [0, 0, 1]\nforce", 'axis = "z"\nforce',
     'joints.elbow: axis = "z" is not a list of three; write axis = [0, 0, 1]'),
    ('parent = "link1"', 'parent = "lnk1"', 'joints.elbow: parent = "lnk1" is not a body; did you mean link1?'),
    ('child = "link2"', 'child = "forearm"', 'joints.elbow: child = "forearm" is not a body; known are link1, link2'),
    ('child = "link2"', 'child = "ground"',
     'bodies.link2: no joint connects the body to ground; add one with child = "link2"'),
    ('child = "link2"', 'child = "link1"',
     'joints.elbow: joins "link1" with itself; write another parent or child'),
    ('child = "link2"', 'child = "forearm"',
     'bodies.link2: no joint connects the body to ground; add one with child = "link2"'),
    ('parent = "ground"', 'parent = "link2"',
     'joints.shoulder: parent = "link2" closes a ring, link1 -> link2 -> link1 (child -> parent), that nothing joins '
     'to ground; write parent = "ground" in one of its joints'),
    ('parent = "ground"\n', "", 'joints.shoulder: parent is missing; write the body that carries it, or "ground"'),
    ('child = "link2"\n', "", "joints.elbow: child is missing; write the body that it carries"),
    ('type = "prismatic"\n', "", f"joints.elbow: type is missing; write one of {', '.join(JOINTS)}"),
    ('type = "prismatic"', 'type = "prismatik"',
     'joints.elbow: type = "prismatik" is not a joint; did you mean prismatic? '
     f"(there are {', '.join(JOINTS)})"),
    ('type = "prismatic"', "type = 3", 'joints.elbow: type = 3 is not text; put it in quotes, such as type = "m1"'),
    ('type = "prismatic"', 'type = "fixed"',
     'joints.elbow: force = "-3*m1*q2_dot" has no meaning for a fixed joint; leave it out'),
    ("com = [0", "centre = [0",
     'bodies.link1: unknown key "centre"; it is com = [0, 0, 0.1]'),
    ("com = [0", "Com = [0", 'bodies.link1: unknown key "Com"; did you mean com?'),
    ("gravity", "gravty", 'unknown key "gravty"; did you mean gravity?'),
    ("mass = 1\n", "mass = -1\n", "bodies.link2: mass = -1 is negative; give a mass of zero or more"),
    ("mass = 1\n", 'mass = "g - 10"\n', "bodies.link2: mass = g - 10 = -0.19 is negative; correct g"),
    ("mass = 1\n", 'particles = [{ mass = -1, at = [0, 0, 0] }]\n',
     "bodies.link2: particles[0]: mass = -1 is negative; give a mass of zero or more"),
    ("mass = 1\n", "particles = [{ mass = 1 }]\n",
     'bodies.link2: particles[0]: at is missing; give a list such as [{ mass = "m1", at = [0, 0, 0] }]'),
    ("mass = 1\n", "mass = inf\n", "bodies.link2: mass = Infinity is not a finite number; give one such as 9.81"),
    ("mass = 1\n", "mass = 1e400\n",
     "bodies.link2: mass = 1E+400: a number is beyond the largest double, 1.8e308; choose units that keep it smaller"),
    ("mass = 1\n", f"mass = 0.{'1' * 1200}\n",
     f"bodies.link2: mass = 0.{'1' * 95}...: 0.{'1' * 18}... has 1202 digits; 1000 are allowed"),
    ("mass = 1\n", f"mass = {'1' * 5000}\n",
     "is not TOML that can be read: an integer has more digits than any number needs"),
    ("mass = 1\n", "mass = true\n",
     'bodies.link2: mass = true is true or false; give a number or a formula such as "m1*h1**2/12"'),
    ("mass = 1\n", 'mass = "m1*"\n',
     'bodies.link2: mass = "m1*" is not a usable formula: it breaks off at its end; check brackets and operators; '
     "a unit stands behind a number alone, as in 5 mm"),
    ("mass = 1\n", 'mass = "m2"\n',
     "bodies.link2: mass = m2 uses the undefined symbol m2; declare it in parameters (known are g, m1, l1)"),
    ("mass = 1\n", 'mass = "q1"\n',
     "bodies.link2: mass = q1 uses q1; a mass or an inertia changes by a state: write "
     'mass = "m_link2" and [states.m_link2] with rate = -0.1, start = 1, unit = "kg", and [flows.link2] with body = '
     '"link2", velocity = [0, 0, 0]'),
    ("mass = 1\n", 'mass = "1/(m1 - 2)"\n',
     "bodies.link2: mass = 1/(m1 - 2) divides by zero; check the values of its parameters"),
    ("mass = 1\n", 'mass = "1/cos(pi/2)"\n',
     "bodies.link2: mass = 1/cos(pi/2) divides by zero; check the denominator"),
    ("mass = 1\n", 'mass = "1/(m1 - m1)"\n',
     "bodies.link2: mass = 1/(m1 - m1) divides by zero; check the denominator"),
    ("mass = 1\n", 'mass = "sqrt(1 - g)"\n',
     "bodies.link2: mass = sqrt(1 - g) takes the square root of -8.81; it must not be negative; "
     "check the values of its parameters"),
    ("q2_dot", "q2_ddot",
     "joints.elbow: force = -3*m1*q2_ddot uses q2_ddot, which moves; only the force of a joint, loads and rows may "
     "depend on what moves"),
    ("inertia = [1, 1, 1]", "inertia = [1, 1, 3]",
     "bodies.link1: inertia (as given) is not physically consistent: its moments Ixx = 1, Iyy = 1, Izz = 3 break the "
     "triangle inequality Ixx + Iyy >= Izz by 33.3 % (Ixx + Iyy = 2); check the numbers and inertia_about, or write "
     "allow_invalid_inertia = true"),
    ("inertia = [1, 1, 1]", "inertia = [1, -1, 1]",
     "bodies.link1: inertia (as given) is not physically consistent: of its moments Iyy = -1, Ixx = 1, Izz = 1, Iyy is "
     "negative (it must be positive semidefinite); check the numbers and inertia_about, or write "
     "allow_invalid_inertia = true"),
    ("inertia = [1, 1, 1]", "inertia = { xx = 1, yy = 1, zz = 1, xy = 2 }",
     "bodies.link1: inertia (as given) is not physically consistent: of its principal moments I1 = -1, I2 = 1, I3 = 3, "
     "I1 is negative (it must be positive semidefinite); check the numbers and inertia_about, or write "
     "allow_invalid_inertia = true"),
    ("inertia = [1, 1, 1]", "inertia = { xx = 2, yy = 2, zz = 1, xy = 1 }",
     "bodies.link1: inertia (as given) is not physically consistent: its principal moments I1 = 1, I2 = 1, I3 = 3 "
     "break the triangle inequality I1 + I2 >= I3 by 33.3 % (I1 + I2 = 2); check the numbers and inertia_about, or "
     "write allow_invalid_inertia = true"),
    ('com = [0, "-l1/2", 0]\ninertia = [1, 1, 1]\ninertia_about = "com"',
     'com = [1, 0, 0]\ninertia = [1, 1, 1]\ninertia_about = "frame"',
     "bodies.link1: inertia (moved to the centre of mass) is not physically consistent: of its moments Iyy = -1, "
     "Izz = -1, Ixx = 1, Iyy is negative (it must be positive semidefinite); check the numbers and inertia_about, or "
     "write allow_invalid_inertia = true"),
    ("inertia = [1, 1, 1]", "inertia = [1, 1]",
     "bodies.link1: inertia = [1, 1] is neither [xx, yy, zz], of a ball [J, J, J], nor a table "
     "{ xx = 1, yy = 1, zz = 1, xy = 0, xz = 0, yz = 0 }"),
    ("inertia = [1, 1, 1]", "inertia = [[1, 0, 0], [1, 1, 0], [0, 0, 1]]",
     "bodies.link1: inertia = [[1, 0, 0], [1, 1, 0], [0, 0, 1]] is not symmetric; "
     "entry [i][j] must equal entry [j][i]"),
    ('inertia_about = "com"\n', "",
     'bodies.link1: inertia_about is missing; write "com" (centre of mass) or "frame" (origin of the body frame)'),
    ('inertia_about = "com"', 'inertia_about = "joint"',
     'bodies.link1: inertia_about = "joint" is not known; write "com" or "frame"'),
    ("mass = 1\n", "mass = 1\ncom = [0, 0, 0]\nfirst_moment = [0, 0, 0]\n",
     "bodies.link2: com and first_moment give the same quantity; write one of them"),
    ("mass = 1\n", "first_moment = [1, 0, 0]\n",
     "bodies.link2: first_moment is not zero but the mass is; give a mass, or write allow_invalid_inertia = true"),
    ("value = 2", "value = -2",
     "parameters.m1: value = -2 is not positive; correct it or drop positive = true"),
    ("value = 2", 'value = "2*m1"',
     "parameters.m1: value = 2*m1 depends on itself: m1 -> m1; give one of them a number"),
    ("value = 2", 'value = "1/sin(pi)"', "parameters.m1: value = 1/sin(pi) divides by zero; give a finite number"),
    ("positive = true", 'positive = "yes"', 'parameters.m1: positive = "yes" is neither true nor false'),
    ("value = 2", 'value = 2, unit = "k\\ng"',
     'parameters.m1: unit = "k g" holds a line break or another unprintable character; write one line'),
    ("l1 = {}", "lambda = {}", 'parameters.lambda: "lambda" is a keyword of Python; try lambda1'),
    ("l1 = {}", "double = {}", 'parameters.double: "double" is a keyword of C; try double1'),
    ("l1 = {}", "sin = {}", 'parameters.sin: "sin" is a function or constant of formulas; try sin1'),
    ("l1 = {}", "t = {}", 'parameters.t: "t" is the time in formulas and runs; rename it, such as t_0'),
    ("l1 = {}", "q1 = {}",
     'joints.shoulder: coordinate = "q1" is already the name of parameters.q1; choose another name'),
    ("l1 = {}", "tau2 = {}",
     'joints.elbow: drive = "tau2" is already the name of parameters.tau2; choose another name'),
    ('axis = [0, 0, 1]\nforce', 'coordinate = "q1"\nforce',
     'joints.elbow: coordinate = "q1" is already the name of joints.shoulder (coordinate); choose another name'),
    ("[points.tool]", "[points.link1]",
     'points.link1: "link1" is already the name of bodies.link1; choose another name'),
    ("[points.tool]", '[points."my tool"]',
     'points.my tool: "my tool" is not a plain identifier; use ASCII letters, digits and _ and begin with a letter, '
     "such as my_tool"),
    ('[points.tool]\nbody = "link2"', "[points.tool]",
     "points.tool: body is missing; write the body that carries the point"),
    ('[points.tool]\nbody = "link2"', '[points.tool]\nbody = "link3"',
     'points.tool: body = "link3" is not a body; did you mean link2?'),
    ('[points.tool]\nbody = "link2"', '[points.tool]\nbody = ""',
     'points.tool: body = "" names nothing; write a name'),
    ('parent = "link1"', 'parent = ""', 'joints.elbow: parent = "" names nothing; write a name'),
    ('child = "link2"', 'child = ""', 'joints.elbow: child = "" names nothing; write a name'),
    ('type = "prismatic"', 'type = ""', 'joints.elbow: type = "" names nothing; write a name'),
    ("force =", 'mimic = { joint = "" }\nforce =', 'joints.elbow: mimic = "" names nothing; write a name'),
    ("[points.tool]", '[loads.push]\nbody = ""\nforce = [1, 0, 0]\n[points.tool]',
     'loads.push: body = "" names nothing; write a name'),
    ("[points.tool]", '[springs.coil]\njoint = ""\nstiffness = 1\n[points.tool]',
     'springs.coil: joint = "" names nothing; write a name'),
    ("[points.tool]", '[springs.coil]\nfrom = ""\nto = "link1"\nstiffness = 1\n[points.tool]',
     'springs.coil: from = "" names nothing; write a name'),
    ('[points.tool]\nbody = "link2"', "[points]\ntool = 3",
     "points.tool: is 3, not a table; write [points.tool] and its keys below"),
    ('gravity = [0, 0, "-g"]', "gravity = [0, 0]",
     "gravity = [0, 0] has 2 entries; three are needed, such as [0, 0, 1]"),
    ('gravity = [0, 0, "-g"]', 'gravity = "down"',
     'gravity = "down" is not a vector; give a vector such as [0, 0, -9.81], or "none"'),
    ('gravity = [0, 0, "-g"]', 'name = "1 arm"\ngravity = [0, 0, "-g"]',
     'name = "1 arm" is not a plain identifier; use ASCII letters, digits and _ and begin with a letter, '
     'such as link_1'),
    ('gravity = [0, 0, "-g"]', 'name = 7\ngravity = [0, 0, "-g"]',
     'name = 7 is not text; write one such as name = "two_link"'),
    ('gravity = [0, 0, "-g"]', "dh = 1", 'dh: is 1, not a table; write [dh] and convention = "standard" or "modified"'),
    ("force =", 'origin = { xyz = [0, 0, 0], rpz = [0, 0, 0] }\nforce =',
     'joints.elbow: origin = {xyz = [0, 0, 0], rpz = [0, 0, 0]} has an unknown key "rpz"; did you mean rpy?'),
    ("force =", 'origin = [["Tw", 1]]\nforce =',
     'joints.elbow: origin = [["Tw", 1]] is not made of steps: ["Tw", 1]; give a list such as '
     '[["Tz", 0.1], ["Rx", "pi/2"]]'),
    ("force =", "origin = 4\nforce =",
     "joints.elbow: origin = 4 is not a placement; give { xyz = [0, 0, 0], rpy = [0, 0, 0] }"),
    ("[points.tool]", "[bodies.link1]\n[points.tool]",
     "column 14: bodies.link1 is declared twice; give each table a name of its own"),
    ("mass = 1\n", "mass = 1\nmass = 2\n",
     "column 9: mass is given twice in one table; remove one of them"),
    ("mass = 1\n", "mass = \n", "column 8: is not valid TOML: Invalid value"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "fault"), EDITS, ids=[fault[:60] for _, _, fault in EDITS])
def test_a_fault_says_where_what_and_what_would_work(old, new, fault):
    assert old in GOOD
    assert f"arm.toml: {fault}" in faults(GOOD.replace(old, new, 1))


def test_all_faults_are_reported_together():
    bad = GOOD.replace("mass = 1\n", "mass = -1\n").replace('type = "prismatic"', 'type = "screw"')
    bad = bad.replace("axis = [0, 0, 1]", "axis = [0, 0, 0]").replace("l1 = {}", "l2 = {}").replace("com =", "kom =")

    found = [re.sub(r"^arm\.toml: (\S+?):.*", r"\1", fault) for fault in faults(bad)]

    assert found == ["bodies.link1", "joints.elbow", "joints.shoulder", "joints.elbow", "bodies.link2"]


def test_the_message_is_one_line_a_fault():
    with pytest.raises(SceneError, match="negative") as caught:
        read_text(GOOD.replace("mass = 1", "mass = -1").replace('"m1"', '"m3"'), "arm.toml")
    assert str(caught.value).splitlines() == list(caught.value.faults)
    assert len(caught.value.faults) == 2


def test_an_invalid_inertia_may_be_asked_for():
    text = GOOD.replace("inertia = [1, 1, 1]", "allow_invalid_inertia = true\ninertia = [1, 1, 3]")

    assert read_text(text).bodies[0].allow_invalid_inertia


@pytest.mark.parametrize("inertia", ["[1, 1, 2]", "[0.1, 0.2, 0.3]", "[0, 1, 1]", '["l1", 1, 5]', "[0, 0, 0]"])
def test_flat_slender_and_unknown_inertias_pass(inertia):
    assert read_text(GOOD.replace("inertia = [1, 1, 1]", f"inertia = {inertia}")).bodies


def test_a_turned_flat_plate_with_irrational_entries_passes():
    third = 'inertia = { xx = "1 + sin(0.3)**2", yy = "1 + cos(0.3)**2", zz = 3, xy = "sin(0.3)*cos(0.3)" }'

    assert read_text(GOOD.replace("inertia = [1, 1, 1]", third)).bodies


DH = """
[dh]
convention = "standard"
[[dh.links]]
name = "arm"
alpha = "90 deg"
mass = 1
"""


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('convention = "standard"', "", 'dh: convention is missing; write convention = "standard" or "modified"'),
        ("standard", "craig", 'dh: convention = "craig" is not known; write "standard" or "modified"'),
        ("alpha", "alfa", 'dh.links.arm: unknown key "alfa"; did you mean alpha?'),
        ("mass = 1", "mass = -1", "dh.links.arm: mass = -1 is negative"),
        ("mass = 1", 'type = "screw"', 'dh.links.arm: type = "screw" is not a joint'),
        ("mass = 1", 'theta = "x"', "dh.links.arm: origin.Rz = x uses the undefined symbol x"),
        ('[[dh.links]]\nname = "arm"\nalpha = "90 deg"\nmass = 1', "links = 3", "dh: links is no list of rows"),
        ('[[dh.links]]\nname = "arm"\nalpha = "90 deg"\nmass = 1', "links = [3]",
         "dh: links: row 1 = 3 is not a table"),
        ('convention = "standard"', 'convention = "standard"\nparent = "base"',
         'dh.links.arm: parent = "base" is not a body'),
    ],
)  # fmt: skip
def test_faults_of_a_dh_table_name_its_rows(old, new, fault):
    assert any(line.startswith(f"arm.toml: {fault}") for line in faults(DH.replace(old, new)))


@pytest.mark.parametrize("text", ["", "name = 'x'", "[bodies]\n[joints]"])
def test_an_empty_scene_moves_nothing(text):
    assert any("nothing moves" in line for line in faults(text))


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.toml: there is no such file"):
        read(tmp_path / "nowhere.toml")
    with pytest.raises(SceneError, match="is a folder; give a scene file"):
        read(tmp_path)
    (tmp_path / "latin.toml").write_bytes("name = 'größe'".encode("latin-1"))
    with pytest.raises(SceneError, match=r"latin\.toml:1: byte 10 is not UTF-8"):
        read(tmp_path / "latin.toml")
    with pytest.raises(SceneError, match="cannot be read"):
        read("a\0b")
    with pytest.raises(SceneError, match="cannot be read"):
        read("x" * 5000)


@pytest.mark.parametrize(
    "value",
    [
        "1e999999999",
        "-1e99999999999999999999999",
        "nan",
        "9" * 5000,
        "0." + "9" * 5000,
        "'1." + "9" * 3000 + "'",
        "[" * 2000,
        "1979-05-27",
        "'x'",
        "[[[1]]]",
    ],
)
def test_no_value_hangs_or_crashes_the_reader(value):
    with pytest.raises(SceneError, match=r"arm\.toml"):
        read_text(GOOD.replace("mass = 1\n", f"mass = {value}\n"), "arm.toml")


def test_python_reports_its_faults_by_scene_and_table():
    with pytest.raises(SceneError, match="already the name") as caught:
        scene(
            "arm",
            parameters=[parameter("m"), parameter("m"), body("x")],
            bodies=[body("a", mass=np.float64("nan")), body("a"), body(3)],
            joints=[revolute("j", Scene.GROUND, "a"), revolute("j", Scene.GROUND, "b", drive=1)],
            points=[point("p", "a")],
            dh=dh_table("standard", [{"name": 4}]),
        )
    assert caught.value.faults == (
        "arm: parameters: bodies.x was not made by parameter(...)",
        'arm: dh.links.4: name = 4 is not text; put it in quotes, such as name = "link1"',
        "arm: bodies.a: mass = nan: NaN is not a finite number; give one such as 9.81",
        'arm: joints.j: drive = 1 is not text; put it in quotes, such as drive = "tau2"',
        'arm: parameters.m: "m" is already the name of parameters.m; choose another name',
        'arm: bodies.a: "a" is already the name of bodies.a; choose another name',
        'arm: bodies.3: "3" is not a plain identifier; use ASCII letters, digits and _ and begin with a letter, '
        "such as link_1",
        'arm: joints.j: "j" is already the name of joints.j; choose another name',
        'arm: joints.j: child = "b" is not a body; known are a, 3, link1',
        'arm: bodies.3: no joint connects the body to ground; add one with child = "3"',
    )


@pytest.mark.long(0)
@settings(max_examples=40)
@given(st.data())
def test_a_damaged_file_gives_a_scene_or_a_scene_error(data):
    text = data.draw(st.sampled_from(EXAMPLES)).read_text()
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        stop = min(len(text), start + data.draw(st.integers(0, 12)))
        pieces = [
            "",
            "{}",
            "[]",
            "0",
            "-1",
            "true",
            '"q1"',
            "nan",
            "[1, 2]",
            "\n",
            "'",
            "ground",
            "=",
            "[[dh.links]]\n",
            ".",
        ]
        text = text[:start] + data.draw(st.sampled_from(pieces)) + text[stop:]
    try:
        outcome = read_text(text, "x.toml").source
    except SceneError as error:
        outcome = str(error)
    assert all(line.startswith("x.toml") for line in outcome.splitlines())


RAW = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.sampled_from(["a", "m", "ground", "", "1/0", "com", "q1"]),
    ),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["xyz", "rpy", "mass", "at", "xx", "z"]), inner, max_size=3)
    ),
    max_leaves=6,
)


@pytest.mark.long
@settings(max_examples=60)
@given(st.lists(RAW, min_size=8, max_size=8))
def test_any_value_in_any_place_gives_a_scene_or_a_scene_error(raw):
    try:
        outcome = scene(
            "s",
            parameters=[parameter("m", raw[0])],
            gravity=raw[1],
            bodies=[body("a", mass=raw[2], com=raw[3], inertia=raw[4], about="com", particles=raw[5])],
            joints=[revolute("j", Scene.GROUND, "a", axis=raw[6], origin=raw[7])],
        ).name
    except SceneError as error:
        outcome = str(error)
    assert all(line.startswith("s") for line in outcome.splitlines())


@pytest.mark.parametrize("seed", range(5))
def test_the_inertia_of_any_point_masses_is_one_that_a_body_has(seed):
    random = np.random.default_rng(seed)
    points = [[Fraction(int(x), 7) for x in row] for row in random.integers(-9, 10, (3, 3))]
    masses = [Fraction(int(m)) for m in random.integers(1, 9, 3)]
    matrix = [
        [
            sum((m * ((np.dot(r, r) if i == j else 0) - r[i] * r[j]) for m, r in zip(masses, points, strict=True)))
            for j in range(3)
        ]
        for i in range(3)
    ]

    assert impossible(matrix) is None
    assert impossible([[float(x) for x in row] for row in matrix]) is None


@pytest.mark.parametrize("seed", range(20))
def test_principal_minors_decide_as_principal_moments_do(seed):
    random = np.random.default_rng(seed)
    entries = random.integers(-3, 4, (3, 3)) + np.diag(random.integers(2, 9, 3))
    matrix = entries + entries.T
    small, middle, large = np.linalg.eigvalsh(matrix)

    decided = impossible([[Fraction(int(x)) for x in row] for row in matrix])

    assert (decided is None) == (small >= 0 and small + middle >= large)
