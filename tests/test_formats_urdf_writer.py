"""URDF text says the same mechanism as the scene it was written from, and what it cannot say is listed."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from mechanisms import coupled_tree, random_tree

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import SceneError
from symdyn.graph import Graph, evaluate
from symdyn.program import lower
from symdyn.runtime import lambdify, run_python
from symdyn.scene import Quantity, Scene, parse, read, read_text
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats import par_writer
from symdyn.scene.formats.placing import angle_text, decimal_text, xyz_rpy
from symdyn.scene.formats.urdf import read_element
from symdyn.scene.formats.urdf_writer import write_text
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values import Pose
from symdyn.scene.values.entry import Faults
from symdyn.scene.values.joint import Limits
from symdyn.scene.values.model import STANDARD_GRAVITY
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

ARM = Path(__file__).parent / "data" / "gripper_arm.urdf"

EXACT = """
name = "arm"
[bodies.rod]
mass = 2
com = [0.5, 0, 0]
inertia = [0.1, 0.2, 0.3]
inertia_about = "com"
particles = [{ mass = 2, at = [1.5, 0, 0] }]
[bodies.tool]
mass = 0.5
first_moment = [0.25, 0, 0.125]
inertia = [1, 1, 1]
inertia_about = "frame"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "rod"
axis = [1, 1, 0]
origin = [["Rx", "pi/2"], ["Tx", 0.1], ["Rz", "pi/2"]]
tip = [["Tz", 0.2], ["Ry", "-pi/2"]]
damping = 0.1
[joints.slide]
type = "prismatic"
parent = "rod"
child = "tool"
axis = [0, 0, -3]
origin = { xyz = [0, 0, 0.3], rpy = ["pi/6", 0.3, "-2*pi/3"] }
limits = { lower = -0.1, effort = 5 }
[points.eye]
body = "tool"
at = [0, 0, 0.125]
"""


def again(scene: Scene) -> Scene:
    """Return the scene written as URDF and read again."""
    options = ReadOptions(allow_invalid_inertia=True)
    return read_element(
        XmlElement.parse(write_text(scene).text.encode(), "again.urdf"), Faults("again.urdf"), options
    ).scene


def entries(scene: Scene, output: str):
    return derive(scene, (output,)).functions[0].entries


def bare(scene: Scene) -> Scene:
    """Return a scene with all that URDF has no word for taken out, parameters with values put in."""
    joints = [replace(joint, forces=(), armature=Quantity.ZERO) for joint in scene.joints]
    return replace(scene, gravity=STANDARD_GRAVITY, joints=tuple(joints))


@pytest.mark.parametrize("output", ["inverse_dynamics", "mass_matrix"])
def test_what_is_exact_in_decimals_is_proved_to_have_the_same_dynamics(output):
    scene = read_text(EXACT.replace("[1, 1, 0]", "[0, -2, 0]"))
    claim = Claim(output, "declared", "read again", entries(scene, output), entries(again(scene), output))

    assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_an_oblique_axis_is_proved_to_have_the_same_dynamics():
    scene = read_text(EXACT)  # its length is one root in the scene and another one in the file
    claim = Claim("M", "declared", "read again", entries(scene, "mass_matrix"), entries(again(scene), "mass_matrix"))

    assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_the_proof_sees_another_number():
    scene = read_text(EXACT)
    other = read_text(EXACT.replace("mass = 0.5", "mass = 0.5000000000000001"))
    claim = Claim("M", "declared", "another", entries(other, "mass_matrix"), entries(again(scene), "mass_matrix"))

    assert prove([claim])[1][0].verdict == Verdict.DIFFERENT


@pytest.mark.wide(5)
@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("make", [random_tree, coupled_tree])
def test_any_tree_has_the_same_dynamics_when_it_is_read_again(make, seed):
    scene = with_values(bare(make(seed)))
    ours, back = functions(scene), functions(again(scene))
    n = len(scene.coordinates)
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, n))

    for f, g, arguments in zip(ours, back, [(q, qd, qdd), (q,)], strict=True):
        expected = f(*arguments)
        assert np.max(np.abs(g(*arguments) - expected)) <= 1e-13 * max(1e-9, np.max(np.abs(expected)))


def functions(scene: Scene) -> tuple[Any, Any]:
    """Return inverse dynamics and the mass matrix as they are derived, without passes."""
    module = run_python(emit(lower(derive(scene, ("inverse_dynamics", "mass_matrix")), ())))
    return module.inverse_dynamics, module.mass_matrix


def with_values(scene: Scene) -> Scene:
    """Return the scene with a value for each parameter."""
    parameters = [p if p.value else replace(p, value=parse(f"{k + 2}/7")) for k, p in enumerate(scene.parameters)]
    return replace(scene, parameters=tuple(parameters))


def test_a_file_that_was_written_reads_as_itself():
    once = again(read(ARM))

    assert again(once) == once
    assert write_text(once).lost == ()
    assert write_text(again(once)).text == write_text(once).text


def test_tips_and_points_become_fixed_joints_and_keep_their_frames():
    scene = again(read_text(EXACT))

    assert [body.name for body in scene.bodies] == ["rod_base", "rod", "tool", "eye"]
    assert [(j.name, j.type) for j in scene.joints] == [
        ("hinge", "revolute"), ("hinge_tip", "fixed"), ("slide", "prismatic"), ("eye_joint", "fixed"),
    ]  # fmt: skip
    pose, other = lambdify(read_text(EXACT), "pose:eye"), lambdify(scene, "pose:eye")
    q = np.array([0.3, -0.7])
    assert np.allclose(pose(q), other(q), rtol=0, atol=1e-15)


def test_limits_stay_and_a_prismatic_joint_without_them_gets_numbers_that_mean_none():
    text = write_text(read_text(EXACT)).text
    (limit,) = ElementTree.fromstring(text).iter("limit")

    assert limit.attrib == {"lower": "-0.1", "upper": "1000000000", "velocity": "1000000000", "effort": "5"}
    assert again(read_text(EXACT)).joints[2].limits == Limits(lower=parse("-0.1"), effort=Quantity.number(5))


def test_what_the_format_cannot_hold_is_listed():
    scene = read_text(
        EXACT.replace('name = "arm"', 'name = "arm"\ngravity = [0, -9.81, 0]\nparameters = { b = 0.5 }')
        .replace("damping = 0.1", 'drive = false\ncoordinate = "theta"\nforce = "-b*theta"\narmature = 0.01')
        .replace("limits = {", 'drive = "F"\nlimits = {')
    )

    assert write_text(scene).lost == (
        "the names of parameters: b are written as their values",
        "the names of coordinates: theta are called q1, q2, ... when the file is read again",
        "the names of drives: F are called tau1, tau2, ... when the file is read again",
        "joints.hinge: armature = 0.01: there is no rotor inertia",
        "gravity = [0, -9.81, 0]: readers of URDF take [0, 0, -9.81]",
        "joints.hinge: drive = false: every joint of a URDF that moves is driven",
        "joints.hinge: force = -b*theta: there are no forces in formulas",
    )
    assert write_text(read_text(EXACT)).lost == ()


def test_floating_and_planar_joints_come_back():
    text = EXACT + (
        '[bodies.boat]\nmass = 1\n[joints.sea]\ntype = "planar"\nparent = "ground"\nchild = "boat"\n'
        "axis = [0, 1, 0]\ndrive = false\ndamping = 0.5\n"
        '[bodies.drone]\nmass = 1\n[joints.air]\ntype = "free"\nparent = "ground"\nchild = "drone"\ndrive = false\n'
    )
    scene = read_text(text)
    written = write_text(scene)

    back = again(scene)

    assert written.lost == ()
    for name in ("sea", "air"):
        there, here = (next(joint for joint in one.joints if joint.name == name) for one in (scene, back))
        assert here == there


def test_what_has_no_word_in_robot_files_is_lost_or_refused():
    ring = EXACT + (
        '[[loop]]\ntype = "point_on_line"\nparent = "ground"\nchild = "LAST"\n'
        '[springs.s]\njoint = "hinge"\nstiffness = 1\n[dampers.d]\njoint = "hinge"\ndamping = 1\n'
        '[loads.w]\nbody = "LAST"\nforce = [0, 0, "3*t"]\n[constraints.r]\nformula = "q1_dot"\n'
    ).replace("LAST", read_text(EXACT).bodies[-1].name)
    scene = read_text(ring)

    for lost in (write_text(scene).lost, par_writer.write_text(scene).lost):
        shown = "\n".join(lost)
        assert all(
            f"{name}: " in shown for name in ("loops.loop1", "springs.s", "dampers.d", "loads.w", "constraints.r")
        )

    ball = '[bodies.x]\nmass = 1\n[joints.y]\ntype = "spherical"\nparent = "ground"\nchild = "x"\n'
    with pytest.raises(SceneError, match=r"joints\.y: URDF has no spherical joints; it has revolute, prismatic"):
        write_text(read_text(EXACT + ball))


def test_free_parameters_are_refused():
    scene = read_text(
        EXACT.replace('name = "arm"', 'name = "arm"\nparameters = { m = {} }').replace(
            "mass = 2\ncom", 'mass = "m"\ncom'
        )
    )

    with pytest.raises(SceneError, match="arm: URDF holds numbers only, and m has no value; give each a value"):
        write_text(scene)


def test_a_first_moment_without_mass_is_refused():
    text = EXACT.replace("mass = 0.5", "mass = 0\nallow_invalid_inertia = true")

    with pytest.raises(SceneError, match=r"bodies\.tool: has a first moment but no mass"):
        write_text(read_text(text))


def test_a_body_with_inertia_alone_has_its_centre_where_its_frame_is():
    text = EXACT.replace("mass = 0.5", "mass = 0\nallow_invalid_inertia = true").replace(
        "[0.25, 0, 0.125]", "[0, 0, 0]"
    )
    tool = ElementTree.fromstring(write_text(read_text(text)).text).find("link[@name='tool']/inertial")

    assert tool is not None
    assert tool.find("mass").attrib == {"value": "0"}
    assert tool.find("origin") is None


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(1, 8), "0.125"),
        (Fraction(-5), "-5"),
        (Fraction(0), "0"),
        (Fraction(100), "100"),
        (Fraction(1, 3), "0.3333333333333333"),
        (Fraction("1.57079632679489655800"), "1.570796326794896558"),
        (Fraction("1e-30"), "1E-30"),
        (Fraction("0.12345678901234567890123456789012345678"), "0.12345678901234567890123456789012345678"),
        (Fraction(10) ** 30, "1E+30"),
        (0.1, "0.1"),
        (2.0, "2"),
    ],
)
def test_numbers_are_exact_where_they_end_and_else_the_nearest_double(value, text):
    assert decimal_text(value) == text
    assert float(text) == float(value)


def test_an_angle_that_only_looks_like_a_multiple_of_pi_is_not_read_as_one():
    assert angle_text(Fraction("1.57079633")) == "1.570796330"
    assert angle_text(Fraction("0.3")) == "0.3"
    assert angle_text(Fraction(3)) == "3"


@pytest.mark.parametrize(
    "steps",
    [
        [("Rx", "pi/2"), ("Rz", "pi/2")],  # pitch of a right angle: roll and yaw turn about one axis
        [("Ry", "pi/2"), ("Rx", "0.3")],
        [("Rz", "pi"), ("Rx", "0.1"), ("Rz", "pi")],
        [("Rx", "1"), ("Ry", "2"), ("Rz", "3")],
        [("Rx", "pi")],
        [("Ry", "2")],
        [("Rx", "-pi/2"), ("Ty", "2"), ("Rx", "pi/2"), ("Tz", "-1")],
    ],
)
def test_steps_become_roll_pitch_and_yaw(steps):
    pose = Pose(tuple((kind, parse(amount)) for kind, amount in steps))
    xyz, rpy = xyz_rpy(pose, {})
    named = zip(("Tx", "Ty", "Tz", "Rz", "Ry", "Rx"), [*xyz, *reversed(rpy)], strict=True)
    same = Pose(tuple((kind, parse(repr(float(x)))) for kind, x in named))

    assert np.allclose(matrix(pose), matrix(same), rtol=0, atol=1e-15)


def matrix(pose: Pose) -> list[float]:
    T = pose.transform(Graph())
    return evaluate([*T.p, *(x for row in T.R for x in row)], Floats(), {})


@pytest.mark.mends("3.12")
def test_the_inertia_of_two_particles_is_written_as_one_that_a_body_has(tmp_path):
    """One principal moment of a rod is the sum of the others; rounded decimals lie on either side."""
    found = Path(__file__).parent / "data" / "found" / "two_particles.toml"
    scenes = [found.read_text("utf-8")]
    rng = np.random.default_rng(5)
    for _ in range(40):
        m, n = (f"{x:.1f}" for x in rng.uniform(0.1, 2, 2))
        at, to = ([float(f"{x:.1f}") for x in rng.uniform(-0.5, 0.5, 3)] for _ in range(2))
        rod = f"particles = [{{ mass = {m}, at = {at} }}, {{ mass = {n}, at = {to} }}]"
        scenes.append(f'[bodies.a]\n{rod}\n[joints.j]\ntype = "revolute"\nparent = "ground"\nchild = "a"\n')
    for text in scenes:
        scene = read_text(text, "rod.toml")
        path = tmp_path / "rod.urdf"
        path.write_text(write_text(scene).text, encoding="utf-8")
        again = read(path)  # refused where a principal moment is larger than the sum of the others
        values = [float(x.at({})) for x in again.bodies[0].inertia]
        exact = [float(x) for x in _about_centre(scene.bodies[0].particles)]
        assert np.max(np.abs(np.subtract(values, exact))) <= 1e-15 * max(exact)


def _about_centre(particles) -> list[Fraction]:
    mass = [p.mass.at({}) for p in particles]
    place = [[x.at({}) for x in p.at] for p in particles]
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    x, y, z = (a - b for a, b in zip(*place, strict=True))
    squares = (y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z)
    return [reduced * square for square in squares]
