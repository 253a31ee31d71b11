"""SDF text says the same mechanism as the scene it was written from, and what it cannot say is listed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mechanisms import coupled_tree, random_tree
from test_formats_urdf_writer import EXACT, entries, functions, with_values

from symdyn.errors import SceneError
from symdyn.runtime import lambdify
from symdyn.scene import Quantity, Scene, example, read_text
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.sdf import read_element
from symdyn.scene.formats.sdf_writer import write_text
from symdyn.scene.formats.xml import XmlElement
from symdyn.scene.values.entry import Faults
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

EVERY = """
name = "every"
gravity = [0, -9.81, 0]
[bodies]
base = { mass = 3, com = [0.1, 0, 0], inertia = [0.3, 0.2, 0.25], inertia_about = "com" }
yoke = { mass = 2, com = [0, 0.2, 0.1], inertia = [0.1, 0.2, 0.15], inertia_about = "com" }
ball = { mass = 1, com = [0, 0, 0.3], inertia = [0.02, 0.03, 0.04], inertia_about = "com" }
nut = { mass = 0.5, com = [0.1, 0.1, 0], inertia = [0.01, 0.01, 0.01], inertia_about = "com" }
shaft = {}
pinion = { mass = 0.2, inertia = [0.001, 0.001, 0.002] }
[joints]
root = { type = "free", parent = "ground", child = "base", start = [0.1, 0.2, 0.3, "1/2", "1/2", "1/2", "1/2"], drive = false }
cardan = { type = "universal", parent = "base", child = "yoke", axis = [1, 0, 0], second_axis = [0, 1, 1], damping = 0.2, origin = [0, 0, 0.5], tip = [0, 0.1, 0] }
socket = { type = "spherical", parent = "yoke", child = "ball", origin = { xyz = [0, 0.4, 0], rpy = [0.1, 0.2, 0.3] }, drive = false }
thread = { type = "helical", parent = "base", child = "nut", axis = [0, 1, 0], pitch = 0.02, limits = { lower = 0, upper = 3 } }
axle = { type = "revolute", parent = "base", child = "shaft", axis = [0, 0, 1], origin = [0.3, 0, 0], drive = false }
gear = { type = "revolute", parent = "base", child = "pinion", axis = [0, 0, 1], origin = [0.4, 0, 0], mimic = { joint = "axle", ratio = -3, offset = 0.25 } }
[springs.clock]
joint = "axle"
stiffness = 4
free = 0.5
[points.tip]
body = "ball"
at = { xyz = [0, 0, 0.6], rpy = [0, 0, "pi/2"] }
"""  # noqa: E501

LOOP = """
name = "parallelogram"
[bodies]
a = { mass = 1, inertia = [1, 1, 1] }
b = { mass = 1, inertia = [1, 1, 1] }
c = { mass = 1, inertia = [1, 1, 1] }
[joints]
j1 = { type = "revolute", parent = "ground", child = "a", axis = [0, 1, 0] }
j2 = { type = "revolute", parent = "a", child = "b", axis = [0, 1, 0], origin = [0, 0, 1] }
j3 = { type = "revolute", parent = "ground", child = "c", axis = [0, 1, 0], origin = [3, 0, 0] }
[[loop]]
name = "j4"
type = "revolute"
parent = "b"
child = "c"
axis = [0, 1, 0]
origin = [3, 0, 0]
child_origin = [0, 0, 1]
"""


def again(scene: Scene) -> Scene:
    """Return the scene written as SDF and read again."""
    text = write_text(scene).text.encode()
    return read_element(
        XmlElement.parse(text, "again.sdf"), Faults("again.sdf"), ReadOptions(allow_invalid_inertia=True)
    ).scene


@pytest.mark.parametrize("output", ["inverse_dynamics", "mass_matrix"])
def test_what_is_exact_in_decimals_is_proved_to_have_the_same_dynamics(output):
    scene = read_text(EXACT)
    claim = Claim(output, "declared", "read again", entries(scene, output), entries(again(scene), output))

    assert prove([claim])[1][0].verdict == Verdict.PROVED


@pytest.mark.wide(5)
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("make", [random_tree, coupled_tree])
def test_any_tree_has_the_same_dynamics_when_it_is_read_again(make, seed):
    scene = make(seed)
    joints = [replace(joint, forces=(), armature=Quantity.ZERO) for joint in scene.joints]
    scene = with_values(replace(scene, joints=tuple(joints)))
    ours, back = functions(scene), functions(again(scene))
    n = len(scene.coordinates)
    q, qd, qdd = np.random.default_rng(seed).uniform(-2, 2, (3, n))

    for f, g, arguments in zip(ours, back, [(q, qd, qdd), (q,)], strict=True):
        expected = f(*arguments)
        assert np.max(np.abs(g(*arguments) - expected)) <= 1e-13 * max(1e-9, np.max(np.abs(expected)))


def test_every_kind_of_joint_has_the_same_dynamics_when_it_is_read_again():
    scene = read_text(EVERY)
    back = again(scene)
    rng = np.random.default_rng(0)
    q, (v, a) = rng.uniform(-1, 1, len(scene.coordinates)), rng.uniform(-1, 1, (2, len(scene.velocities)))
    q[3:7] /= np.linalg.norm(q[3:7])
    q[9:13] /= np.linalg.norm(q[9:13])

    assert [j.name for j in back.joints] == ["base_free", *(j.name for j in scene.joints[1:])]
    assert [(j.type, j.drives) for j in back.joints] == [(j.type, j.drives) for j in scene.joints]
    assert [float(x.at({})) for x in back.joints[0].start] == pytest.approx([0.1, 0.2, 0.3, *[0.5] * 4], abs=1e-15)
    assert back.points == scene.points
    assert back.struts == tuple(replace(one, name="axle") for one in scene.struts)
    assert [j.limits for j in back.joints] == [j.limits for j in scene.joints]
    for output in ("inverse_dynamics", "mass_matrix", "potential_energy", "pose:tip"):
        arguments = (q, v, a) if output == "inverse_dynamics" else (q,)
        expected = lambdify(scene, output)(*arguments)
        assert lambdify(back, output)(*arguments) == pytest.approx(expected, abs=1e-14 * np.max(np.abs(expected)))
    assert [line for line in write_text(scene).lost if "names of" not in line] == [
        "joints.root: a link that is free has no joint; read again it is called base_free",
        "springs.clock: is called axle there",
    ]


@pytest.mark.parametrize("text", [EXACT, EVERY, LOOP], ids=["exact", "every", "loop"])
def test_a_file_that_was_written_reads_as_itself(text):
    once = again(read_text(text))

    assert again(once) == once
    assert write_text(once).lost == ()
    assert write_text(again(once)).text == write_text(once).text


def test_a_loop_is_cut_where_the_scene_cuts_it():
    scene = read_text(LOOP)
    back = again(scene)
    q, v, tau = np.array([0.3, -0.3, 0.3]), np.array([0.7, -0.7, 0.7]), np.array([0.2, -0.1, 0.4])

    assert [(one.name, one.type, one.parent, one.child) for one in back.loops] == [("j4", "revolute", "b", "c")]
    assert lambdify(back, "forward_dynamics")(q, v, tau) == pytest.approx(
        lambdify(scene, "forward_dynamics")(q, v, tau), abs=1e-14
    )


def test_a_loop_that_is_open_at_zero_is_refused():
    with pytest.raises(SceneError, match=r"loops\.j4: is open by 0\.5 where all coordinates are zero.*or write TOML"):
        write_text(read_text(LOOP.replace("child_origin = [0, 0, 1]", "child_origin = [0, 0, 0.5]")))
    with pytest.raises(SceneError, match=r"four_bar: loops\.hinge: is open by 3\.5"):
        write_text(example("four_bar"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (('type = "universal"', 'type = "planar"'), "SDF has no planar joints; it has revolute, prismatic, helical"),
        (('parent = "ground", child = "base"', 'parent = "shaft", child = "base"'), "is free of the world alone"),
        (("shaft", "world"), '"world" is what SDF calls the ground; give the body another name'),
        (("mass = 0.2", 'mass = "m"'), "SDF holds numbers only, and m has no value"),
        (('joint = "axle", ratio = -3', "ratios = { axle = 1, thread = 2 }"), "SDF has no joint that follows several"),
    ],
)
def test_what_sdf_has_no_word_for_is_refused(change, words):
    text = EVERY.replace(*change).replace("second_axis = [0, 1, 1], " if "planar" in change[1] else "\0", "")
    text = text.replace(", offset = 0.25", "") if "ratios" in change[1] else text
    if 'parent = "shaft"' in change[1]:
        text = text.replace('parent = "base", child = "shaft"', 'parent = "ground", child = "shaft"')
    text = text.replace("[bodies]", "[parameters]\nm = {}\n[bodies]") if '"m"' in change[1] else text
    with pytest.raises(SceneError) as caught:
        write_text(read_text(text))
    assert words in str(caught.value)


def test_what_is_left_out_is_told():
    text = EVERY.replace("stiffness = 4", "stiffness = [4, 5]").replace(
        "damping = 0.2", "armature = 0.2, damping = 0.2"
    )
    text = text.replace('body = "ball"', 'body = "ground"').replace('name = "every"', 'name = "every"\n')
    text = text.replace("shaft = {}", "axle = {}").replace('"shaft"', '"axle"').replace("armature = 0.2, ", "")
    text = text.replace('type = "free", parent', 'type = "free", origin = [1, 0, 0], damping = 0.1, parent')
    lost = "\n".join(write_text(read_text(text)).lost)

    for words in (
        "axle: is called axle_2 there", "points.tip: a point of the ground", "springs.clock: ",
        "joints.root: origin and tip: read again, coordinates count from the world to the link",
        "joints.root: damping: a link that is free has none",
    ):  # fmt: skip
        assert words in lost


def test_gravity_that_is_not_the_usual_one_is_that_of_a_world():
    text = write_text(read_text(EVERY)).text

    assert "<gravity>0 -9.81 0</gravity>" in text
    assert "<world" not in write_text(read_text(LOOP)).text
    assert read_text(EVERY).gravity == again(read_text(EVERY)).gravity


def test_a_mechanism_is_that_of_mujoco():
    """A ball, a hinge with a spring, turned inertias: MuJoCo's numbers of the same thing in its own words."""
    mujoco = pytest.importorskip("mujoco")
    arm = """<mujoco><compiler angle="radian" eulerseq="zyx"/><worldbody>
      <body name="a" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1"><joint type="ball" damping="0.3"/>
        <inertial pos="0.1 0 0.2" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/>
        <body name="b" pos="0.5 0 0.1"><joint type="hinge" axis="0 0.6 0.8"
            stiffness="5" springref="0.4" damping="0.1"/>
          <inertial pos="0 0.3 0" mass="1" diaginertia="0.05 0.06 0.07"/></body></body></worldbody></mujoco>"""
    inertia = "<inertia><ixx>{}</ixx><iyy>{}</iyy><izz>{}</izz><ixy>{}</ixy><ixz>{}</ixz><iyz>{}</iyz></inertia>"
    ours = f"""<sdf version="1.9"><model name="m">
      <link name="a"><pose>0.1 0.2 0.3 0.1 0.2 0.3</pose><inertial><pose>0.1 0 0.2 0 0 0</pose><mass>2</mass>
        {inertia.format(0.3, 0.2, 0.25, 0.01, 0.02, 0.03)}</inertial></link>
      <link name="b"><pose relative_to="a">0.5 0 0.1 0 0 0</pose><inertial><pose>0 0.3 0 0 0 0</pose><mass>1</mass>
        {inertia.format(0.05, 0.06, 0.07, 0, 0, 0)}</inertial></link>
      <joint name="j" type="ball"><parent>world</parent><child>a</child>
        <axis><dynamics><damping>0.3</damping></dynamics></axis></joint>
      <joint name="k" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0.6 0.8</xyz><dynamics>
        <damping>0.1</damping><spring_stiffness>5</spring_stiffness><spring_reference>0.4</spring_reference>
        </dynamics></axis></joint></model></sdf>"""
    scene = read_element(XmlElement.parse(ours.encode(), "m.sdf"), Faults("m.sdf"), ReadOptions()).scene
    model = mujoco.MjModel.from_xml_string(arm)
    data = mujoco.MjData(model)
    f = lambdify(scene, "inverse_dynamics")
    for seed in range(4):
        rng = np.random.default_rng(seed)
        q, v, a = rng.uniform(-1, 1, 5), rng.uniform(-1, 1, 4), rng.uniform(-1, 1, 4)
        q[:4] /= np.linalg.norm(q[:4])
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        assert f(q, v, a) == pytest.approx(data.qfrc_inverse, abs=1e-12)


def test_numbers_that_are_multiples_of_pi_come_back():
    text = LOOP.replace("origin = [0, 0, 1] }", 'origin = { xyz = [0, 0, 1], rpy = [0, "pi/2", "-pi/2"] } }', 1)
    scene = read_text(text.split("[[loop]]")[0])
    file = write_text(scene).text

    assert "1.5707963267948966" in file
    assert again(scene).joints[1].origin == scene.joints[1].origin


def test_a_robot_of_the_package_goes_through_sdf():
    scene = example("humanoid")
    back = again(scene)
    q = np.random.default_rng(2).uniform(-1, 1, len(scene.coordinates))

    assert [j.name for j in back.joints] == [j.name for j in scene.joints]
    assert lambdify(back, "mass_matrix")(q) == pytest.approx(lambdify(scene, "mass_matrix")(q), abs=1e-14)
