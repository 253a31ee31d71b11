"""MJCF files read through MuJoCo's compiler move as MuJoCo moves them."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.mechanism.state import quaternions
from symdyn.errors import SceneError
from symdyn.graph import Graph, evaluate
from symdyn.runtime import lambdify
from symdyn.scene import Scene, read_text, write_text
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.formats import mjcf
from symdyn.scene.values import Pose, spell, velocity_name
from symdyn.scene.values.quantity import Quantity

mujoco = pytest.importorskip("mujoco")

DATA = Path(__file__).parent / "data"

FILES = ("pendulum.xml", "cart_pole.xml", "arm.xml", "gimbal.xml", "floating.xml")

TENDON = '<tendon><fixed name="t">{}</fixed>{}</tendon><equality><tendon name="e" tendon1="t"/></equality>'

ROD = '<inertial pos="0 0 -0.5" mass="2" diaginertia="0.2 0.2 0.01"/>'


def read(name: str, **options: bool) -> Reading:
    return mjcf.read(DATA / name, ReadOptions(**options))


def world(tmp_path: Path, inside: str, around: str = "") -> Path:
    path = tmp_path / "robot.xml"
    path.write_text(f"<mujoco>{around}<worldbody>{inside}</worldbody></mujoco>")
    return path


def body(joint: str = '<joint name="j"/>', inertial: str = ROD, name: str = "b") -> str:
    return f'<body name="{name}">{joint}{inertial}</body>'


def faults(path: Path) -> str:
    with pytest.raises(SceneError) as caught:
        mjcf.read(path, ReadOptions())
    return str(caught.value)


class Peer:
    """The same file in MuJoCo, driven by our coordinates, meshes taken out, nothing touching.

    qpos = A q + b, qvel = B u, qacc = B u' + c: B is A but for quaternions, whose velocities are ours, and for the
    velocity of a free joint, which MuJoCo gives along the axes of the world: R v, whose rate is R (v' + ω × v).
    """

    def __init__(self, path: Path, scene: Scene) -> None:
        spec = mujoco.MjSpec.from_file(str(path))
        for kind in ("materials", "textures", "meshes"):
            for element in list(getattr(spec, kind)):
                spec.delete(element)
        for geom in list(spec.geoms):
            geom.material = ""
            if geom.meshname:
                spec.delete(geom)
        self.model = spec.compile()
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self.data = mujoco.MjData(self.model)
        self.A, self.b = np.zeros((self.model.nq, len(scene.coordinates))), np.zeros(self.model.nq)
        self.B, self.free = np.zeros((self.model.nv, len(scene.velocities))), []
        for joint in scene.joints:
            if not joint.moves:
                continue
            there = self.model.joint(joint.name)
            position, dof, coupling = there.qposadr[0], there.dofadr[0], joint.coupling
            ratio = dict(coupling.ratios)[coupling.coordinates[0]].at({}) if coupling else 1
            self.b[position] = coupling.offset.at({}) if coupling else 0
            for k, name in enumerate(coupling.coordinates if coupling else joint.coordinates):
                self.A[position + k, scene.coordinates.index(name)] = ratio
            for k, name in enumerate([*map(velocity_name, coupling.coordinates)] if coupling else joint.rates):
                self.B[dof + k, scene.velocities.index(name)] = ratio
            if joint.type == "free":
                self.free.append((position + 3, dof, scene.velocities.index(joint.rates[0])))

    def set(self, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Put the state in; return B and c."""
        self.data.qpos = self.A @ q + self.b
        B, c = self.B.copy(), np.zeros(self.model.nv)
        for position, dof, k in self.free:
            R = np.zeros(9)
            mujoco.mju_quat2Mat(R, self.data.qpos[position : position + 4])
            R = R.reshape(3, 3)
            B[dof : dof + 3, k : k + 3] = R
            c[dof : dof + 3] = R @ np.cross(u[k + 3 : k + 6], u[k : k + 3])
        self.data.qvel = B @ u
        return B, c

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        B, c = self.set(q, qd)
        self.data.qacc = B @ qdd + c
        mujoco.mj_inverse(self.model, self.data)
        return B.T @ self.data.qfrc_inverse

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        u = np.zeros(self.B.shape[1])
        self.inverse_dynamics(q, u, u)
        B, _ = self.set(q, u)
        every = [np.eye(self.model.nv)[k] for k in range(self.model.nv)]
        columns = []
        for unit in every:
            column = np.zeros(self.model.nv)
            mujoco.mj_mulM(self.model, self.data, column, unit)
            columns.append(column)
        return B.T @ np.array(columns).T @ B

    def forward_dynamics(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        B, c = self.set(q, qd)
        self.data.qfrc_applied = np.linalg.solve(B.T, tau)
        mujoco.mj_forward(self.model, self.data)
        return np.linalg.solve(B, self.data.qacc - c)


def draw(scene: Scene, rng: np.random.Generator) -> np.ndarray:
    """Return random coordinates, quaternions of length one."""
    q = rng.uniform(-2, 2, len(scene.coordinates))
    for names in quaternions(scene):
        first = scene.coordinates.index(names[0])
        q[first : first + 4] /= np.linalg.norm(q[first : first + 4])
    return q


@pytest.mark.heavy("arm.xml-False", "gimbal.xml-False", "floating.xml-False")
@pytest.mark.long
@pytest.mark.parametrize("snap", [True, False])
@pytest.mark.parametrize("name", FILES)
def test_dynamics_are_those_of_mujoco(name: str, snap: bool) -> None:
    scene = read(name, snap=snap).scene
    peer = Peer(DATA / name, scene)
    inverse, mass, forward = lambdify(scene, ("inverse_dynamics", "mass_matrix", "forward_dynamics"))
    rng = np.random.default_rng(7)
    for _ in range(5):  # MuJoCo before 4 turns a full inertia into principal axes to ten digits only
        q = draw(scene, rng)
        qd, qdd = rng.uniform(-2, 2, (2, len(scene.velocities)))
        tau = peer.inverse_dynamics(q, qd, qdd)
        np.testing.assert_allclose(inverse(q, qd, qdd), tau, rtol=0, atol=1e-11 * np.abs(tau).max())
        np.testing.assert_allclose(mass(q), peer.mass_matrix(q), rtol=0, atol=1e-11)
        if not any(joint.coupling for joint in scene.joints):
            qdd = peer.forward_dynamics(q, qd, tau)
            np.testing.assert_allclose(forward(q, qd, tau), qdd, rtol=0, atol=1e-10 * np.abs(qdd).max())


def test_sites_lie_where_mujoco_puts_them() -> None:
    scene = read("arm.xml").scene
    peer = Peer(DATA / "arm.xml", scene)
    q = np.array([0.3, -1.1, 0.04])
    peer.inverse_dynamics(q, 0 * q, 0 * q)
    pose = lambdify(scene, "pose:grip")(q)
    np.testing.assert_allclose(pose[:3, 3], peer.data.site("grip").xpos, atol=1e-14)
    np.testing.assert_allclose(pose[:3, :3].ravel(), peer.data.site("grip").xmat, atol=1e-14)


def test_joints_keep_what_resists_them_and_their_limits() -> None:
    scene = read("pendulum.xml").scene
    hinge = scene.joints[0]
    assert (hinge.damping, hinge.armature, hinge.friction) == tuple(
        Quantity.number(Fraction(text)) for text in ("0.05", "0.01", "0.02")
    )
    assert (spell(hinge.limits.lower), spell(hinge.limits.upper)) == ("-2*pi/3", "pi/2")
    (spring,) = read("pendulum.xml").scene.elements
    assert (spring.joint, [spell(k) for k in spring.stiffness], spell(spring.free)) == ("hinge", ["1.5"], "pi/6")
    effort = read("arm.xml").scene.joints[2].limits.effort
    assert effort == Quantity.number(40)


def test_right_angles_are_exact_and_noted_and_doubles_without_snap() -> None:
    reading = read("arm.xml")
    upper = next(joint for joint in reading.scene.joints if joint.child == "upper")
    assert [(kind, spell(amount)) for kind, amount in upper.origin.steps] == [
        ("Tz", "0.1"), ("Ry", "-pi/6"), ("Rx", "pi/2"),
    ]  # fmt: skip
    assert any("multiples of pi were recognised in body base, body upper" in note for note in reading.notes)
    plain = read("arm.xml", snap=False)
    upper = next(joint for joint in plain.scene.joints if joint.child == "upper")
    assert all("pi" not in spell(amount) for _, amount in upper.origin.steps)
    assert not any("multiples of pi" in note for note in plain.notes)


def test_a_full_inertia_keeps_the_digits_of_the_file() -> None:
    hand = next(body for body in read("arm.xml").scene.bodies if body.name == "hand")
    assert [spell(x) for x in hand.inertia] == ["0.002", "0.003", "0.0025", "0.0002", "-0.0001", "0.0003"]


def test_several_joints_on_one_body_hang_on_massless_bodies() -> None:
    scene = read("gimbal.xml").scene
    assert [body.name for body in scene.bodies] == ["ball_yaw", "ball_pitch", "ball_reach", "ball", "follower"]
    assert [body.mass == Quantity.number(0) for body in scene.bodies] == [True, True, True, False, False]


def test_a_linear_equality_is_a_coupling() -> None:
    reading = read("gimbal.xml")
    geared = reading.scene.joints[-1]
    assert geared.coupling is not None
    assert geared.coupling.coordinates == ("q1",)
    assert (spell(dict(geared.coupling.ratios)["q1"]), spell(geared.coupling.offset)) == ("-2", "7*pi/36 + 0.1")
    assert any("geared follows yaw" in note for note in reading.notes)


def test_gravity_is_off_when_the_file_says_so(tmp_path: Path) -> None:
    path = world(tmp_path, body(), '<option gravity="1 2 3"><flag gravity="disable"/></option>')
    assert [spell(x) for x in mjcf.read(path, ReadOptions()).scene.gravity] == ["0", "0", "0"]
    path = world(tmp_path, body(), '<option gravity="1 2 3.7"/>')
    assert [spell(x) for x in mjcf.read(path, ReadOptions()).scene.gravity] == ["1", "2", "3.7"]


def test_springs_and_dampers_are_off_when_the_file_says_so(tmp_path: Path) -> None:
    joint = '<joint name="j" stiffness="2" damping="3"/>'
    path = world(tmp_path, body(joint), '<option><flag spring="disable" damper="disable"/></option>')
    found = mjcf.read(path, ReadOptions()).scene
    assert (found.elements, found.joints[0].damping) == ((), Quantity.number(0))


def test_names_that_cannot_be_printed_are_changed_with_a_note(tmp_path: Path) -> None:
    path = world(tmp_path, body('<joint name="left/hip-1"/>', name="for"))
    reading = mjcf.read(path, ReadOptions())
    assert (reading.scene.joints[0].name, reading.scene.bodies[0].name) == ("left_hip_1", "for_frame")
    assert any("joint left/hip-1: is called left_hip_1 here" in note for note in reading.notes)


@pytest.mark.parametrize(
    ("inside", "around", "message"),
    [
        (body('<joint name="j" type="ball" stiffness="1"/>'), "", "joint j: stiffness of a ball is not read"),
        (
            body('<joint name="j" type="free" armature="1"/>'),
            "",
            "joint j: armature of a free joint is not read: a free body has no rotor; add it to the body's own mass",
        ),
        (
            body() + '<site name="s"/><site name="o" pos="0 1 0"/>',
            '<tendon><spatial name="t"><site site="s"/><site site="o"/></spatial></tendon>'
            '<equality><tendon name="e" tendon1="t"/></equality>',
            "equality e: the tendon t runs through space, and its length is no sum of joint positions; delete it, or",
        ),
        (
            body(),
            TENDON.format('<joint joint="j" coef="0"/>', ""),
            r"equality e: ties 0 joints \(none\), and a coupling ties two or more; delete it, .* \[constraints.NAME\]",
        ),
        (
            body(),
            TENDON.format('<joint joint="j" coef="2"/>', ""),
            r"equality e: ties 1 joints \(j\), .*; it holds this joint still: .* lock it in TOML",
        ),
        (
            body() + body('<joint name="k"/>', name="c"),
            '<equality><joint joint1="j" joint2="k" polycoef="0 1 2 0 0"/></equality>',
            "equality 1: is no linear coupling",
        ),
        (
            body(),
            '<tendon><fixed name="t" stiffness="3"><joint joint="j" coef="1"/></fixed></tendon>',
            "tendon t: has stiffness",
        ),
        (body(), '<option density="1.2"/>', "option: density and viscosity of a fluid"),
        (
            body(),
            '<actuator><motor name="m" joint="j" armature="0.1"/></actuator>',
            "actuator m: armature of an actuator is not read|unrecognized attribute: 'armature'",
        ),
        (
            body(inertial='<geom type="mesh" mesh="shell"/>'),
            '<asset><mesh name="shell" file="shell.stl"/></asset>',
            'body b: takes its inertia from the mesh "shell.stl", and there is no such file; put it there, or give',
        ),
        (body(joint=""), "", "nothing moves"),
        (body() + "<oops/>", "", "MuJoCo's compiler refuses it: XML Error: Schema violation: unrecognized element"),
        (body(inertial=""), "", "compiler refuses it: Error: mass and inertia of moving bodies must be larger"),
        (body().replace("0.2 0.2", "nan 0.2"), "", 'line 1: <inertial> diaginertia="nan 0.2 0.01" is not finite'),
        (body(), '<size nuser_body="1000000000"/>', "<size> nuser_body=.* asks for much memory"),
        (
            f'<replicate count="900000">{body()}</replicate>',
            "",
            "<replicate> and <attach> make more than 1000000 elements",
        ),
        (
            f'<replicate count="60"><replicate count="60">{body()}</replicate></replicate>',
            "",
            "there are 3601 bodies; 2000 are the most that is read",
        ),
        (
            body('<joint name="j" damping="1e300"/>'),
            "",
            "compiled model has numbers of dof_damping that are not finite",
        ),
        ("<flexcomp/>", "", "line 1: <flexcomp> is not read: deformable bodies"),
        (body(), '<include file="nowhere.xml"/>', "compiler refuses it: XML Error: .*nowhere.xml"),
        (body(), '<include file="robot.xml"/>', "line 1: robot.xml includes itself"),
    ],
    ids=lambda value: None,
)
def test_what_cannot_be_read_is_refused_in_one_line(
    inside: str, around: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = world(tmp_path, inside, around)
    with pytest.raises(SceneError, match=message) as caught:
        mjcf.read(path, ReadOptions())
    assert all(line.startswith(str(path)) for line in str(caught.value).splitlines())
    assert [file.name for file in tmp_path.iterdir()] == ["robot.xml"], "MuJoCo leaves no log behind"


def test_all_faults_of_a_file_are_told_together(tmp_path: Path) -> None:
    text = faults(
        world(
            tmp_path, body('<joint type="free" armature="1"/>') + body('<joint type="ball" stiffness="1"/>', name="c")
        )
    )
    assert "armature of" in text
    assert "stiffness of" in text


LOOPS = """
  <body name="a" pos="0 0 1"><joint name="j" axis="0 1 0"/><geom size="0.1" pos="0.5 0 0"/></body>
  <body name="b" pos="0 1 1"><joint name="k" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 1 0 0"/>
    <site name="s" pos="0.5 0 0" euler="0 30 0"/>
    <body name="c" pos="1 0 0"><joint name="l" type="ball"/><geom size="0.1" pos="0 0 0.2"/>
      <site name="t" pos="0 0 0.1" euler="20 0 0"/></body></body>
"""

EQUALITY = """
<equality>
  <connect name="pin" body1="a" body2="b" anchor="0.7 0.1 0.2"/>
  <connect body1="c" anchor="0.1 0 0"/>
  <weld name="glue" body1="c" body2="a" anchor="0.1 0.2 0.3" relpose="0.3 0.2 0.1 0.5 0.5 0.5 0.5"/>
  <weld name="clamp" site1="s" site2="t"/>
</equality>
"""


def test_connect_and_weld_close_loops_where_mujoco_measures_them(tmp_path: Path) -> None:
    """The residual of a loop is what MuJoCo calls efc_pos, as a point apart in the world."""
    path = world(tmp_path, LOOPS, EQUALITY)
    scene = mjcf.read(path, ReadOptions()).scene
    assert [(loop.name, loop.type, loop.parent, loop.child) for loop in scene.loops] == [
        ("pin", "spherical", "a", "b"),
        ("loop2", "spherical", "c", "ground"),
        ("glue", "fixed", "c", "a"),
        ("clamp", "fixed", "b", "c"),
    ]
    model = mujoco.MjSpec.from_file(str(path)).compile()
    data = mujoco.MjData(model)
    q = draw(scene, np.random.default_rng(3))
    data.qpos = q
    mujoco.mj_forward(model, data)
    first = 0
    for loop in scene.loops:
        poses = []
        for body_name, frame in ((loop.parent, loop.origin), (loop.child, loop.tip.inverse())):
            there = data.body(body_name if body_name != "ground" else "world")
            own = np.eye(4)
            own[:3, :3], own[:3, 3] = there.xmat.reshape(3, 3), there.xpos
            poses.append(own @ matrix_of(frame))
        apart = poses[0][:3, 3] - poses[1][:3, 3]
        np.testing.assert_allclose(apart, data.efc_pos[first : first + 3], atol=1e-12)
        if loop.type == "fixed":  # MuJoCo's three more are the vector part of q1 relpose q2*
            turn = poses[1][:3, :3].T @ poses[0][:3, :3]
            half = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
            w = np.sqrt(max(0.0, 1 + np.trace(turn)))
            found = data.efc_pos[first + 3 : first + 6]
            np.testing.assert_allclose(np.abs(half / (2 * w)), np.abs(found), atol=1e-9)
        first += 6 if loop.type == "fixed" else 3


def matrix_of(pose: Pose) -> np.ndarray:
    graph = Graph()
    found = pose.transform(graph)
    entries = evaluate([*(x for row in found.R for x in row), *found.p], Floats(), {})
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.array(entries[:9]).reshape(3, 3), entries[9:]
    return matrix


@pytest.mark.parametrize(
    "content",
    [
        b"<mujoco",
        b"\x00\xff<mujoco/>",
        b'<!DOCTYPE x [<!ENTITY a "b">]><mujoco>&a;</mujoco>',
        b"<mujoco>" + b"<body>" * 100_000,
        b'<mujoco model="' + b"x" * 3_000_000 + b'"/>',
        b"<mujoco><worldbody>" + b"<body>" * 190 + b"</body>" * 190 + b"</worldbody></mujoco>",
        b"<robot/>",
    ],
    ids=["cut off", "no text", "entity", "deep", "long", "empty bodies", "URDF"],
)
def test_garbage_ends_in_one_line(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_bytes(content)
    text = faults(path)
    assert text.startswith(str(path))
    assert len(text.splitlines()) == 1


def test_an_entity_in_an_included_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_text('<!DOCTYPE x [<!ENTITY a "b">]><mujoco>&a;</mujoco>')
    path = world(tmp_path, body(), '<include file="part.xml"/>')
    assert "part.xml: line 1: a document type or an entity is not read" in faults(path)


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_is_included_is_a_file(kind: str, tmp_path: Path) -> None:
    """A pipe that nobody writes to would keep the compiler waiting without an end."""
    os.mkfifo(tmp_path / "part.xml")
    name = {"pipe": "part.xml", "device": os.devnull}[kind]
    assert f"{name} is no file" in faults(world(tmp_path, body(), f'<include file="{name}"/>'))


def test_a_mesh_in_the_file_itself_gives_its_inertia(tmp_path: Path) -> None:
    corners = " ".join(f"{x} {y} {z}" for x in (0, 1) for y in (0, 2) for z in (0, 3))
    geom = '<geom type="mesh" mesh="brick" density="1"/>'
    path = world(tmp_path, body(inertial=geom), f'<asset><mesh name="brick" vertex="{corners}"/></asset>')
    found = mjcf.read(path, ReadOptions()).scene.bodies[0]
    assert float(found.mass.value) == pytest.approx(6, rel=1e-6)  # type: ignore[arg-type]


def test_without_mujoco_the_way_to_get_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert 'pip install "symdyn[robots]"' in faults(world(tmp_path, body()))


def test_an_old_mujoco_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco, "__version__", "3.1.6")
    assert "mujoco 3.1.6 is too old, 3.4 is needed" in faults(world(tmp_path, body()))


def test_the_suffix_mjcf_is_read_like_xml(tmp_path):
    text = (Path(__file__).parent / "data" / "pendulum.xml").read_bytes()
    (tmp_path / "pendulum.mjcf").write_bytes(text)
    (tmp_path / "pendulum.xml").write_bytes(text)

    one, other = (mjcf.read(tmp_path / name, ReadOptions()).scene for name in ("pendulum.mjcf", "pendulum.xml"))
    assert one == other


def test_a_lopsided_force_range_is_noted(tmp_path):
    path = tmp_path / "one.xml"
    joint = '<joint name="j" type="hinge" axis="0 0 1" actuatorfrcrange="-1 5"/>'
    inertial = '<inertial pos="1 0 0" mass="1" diaginertia="1 1 1"/>'
    path.write_text(f'<mujoco><worldbody><body name="b">{joint}{inertial}</body></worldbody></mujoco>')
    reading = mjcf.read(path, ReadOptions())

    assert any("actuatorfrcrange = -1 5 is kept as one largest force, 5" in note for note in reading.notes)
    assert reading.scene.joints[0].limits.effort == Quantity.number(5)


# A base that floats


def test_a_floating_base_is_the_free_joint_that_the_file_could_have(tmp_path: Path) -> None:
    base = (
        '<body name="base" pos="1 2 3" quat="1 1 0 0"><inertial pos="0 0 0.1" mass="3" diaginertia="1 2 2.5"/>{}</body>'
    )
    arm = body('<joint name="j" axis="1 2 3"/>')
    still, free = base.format(arm), base.format('<freejoint name="trunk"/>' + arm)
    ours = mjcf.read(world(tmp_path, still), ReadOptions(floating_base="trunk")).scene
    theirs = mjcf.read(world(tmp_path, free), ReadOptions()).scene
    unit = [Quantity.number(1), Quantity.number(2), Quantity.number(3)]

    assert list(ours.joints[0].start[:3]) == unit == list(theirs.joints[0].start[:3])
    assert ours.joints == tuple(
        replace(joint, drives=mine.drives) for joint, mine in zip(theirs.joints, ours.joints, strict=True)
    )
    assert ours.bodies == theirs.bodies


def test_a_base_with_joints_of_its_own_is_not_set_free(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"floating base: the one body .* carries none without a joint, b with joints"):
        mjcf.read(world(tmp_path, body()), ReadOptions(floating_base="trunk"))


# Meshes that give inertia

BRICK = """\
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 0
v 0 0 3
v 1 0 3
v 1 2 3
v 0 2 3
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""


@pytest.mark.mends("4.mesh")
@pytest.mark.parametrize("suffix", ["xml", "mjcf"])
def test_a_mesh_beside_the_file_gives_its_inertia(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    """A brick of 1 m, 2 m, 3 m and 1 kg/m^3: m = 6 kg, I = m/12 (b² + c²) about its centre."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "brick.obj").write_text(BRICK)
    geoms = '<geom type="mesh" mesh="brick" density="1"/><geom type="mesh" mesh="drawn" mass="0"/>'
    files = '<mesh name="brick" file="brick.obj"/><mesh name="drawn" file="nowhere.obj"/>'
    path = world(tmp_path, body(inertial=geoms), f'<compiler meshdir="parts"/><asset>{files}</asset>')
    path = path.rename(tmp_path / f"robot.{suffix}")
    monkeypatch.chdir("/")  # the mesh lies beside the file, wherever the program runs
    brick = mjcf.read(path, ReadOptions()).scene.bodies[0]

    assert float(brick.mass.at({})) == pytest.approx(6, rel=1e-6)
    assert [float(x.at({})) for x in brick.com] == pytest.approx([0.5, 1, 1.5], rel=1e-6)
    moments = [float(x.at({})) for x in brick.inertia]
    assert moments == pytest.approx([6.5, 5, 2.5, 0, 0, 0], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "size", "words"),
    [
        ("shell.stl", 70 << 20, 'the mesh "shell.stl" of 70 MB; 64 are the most that is read; give the body <inertial'),
        ("shell.ply", 10, 'the mesh "shell.ply", which is none of .stl, .obj, .msh; convert it, or give'),
        ("shell.stl", 10, "MuJoCo's compiler refuses it: "),
    ],
)
def test_a_mesh_that_cannot_be_read_is_told(tmp_path: Path, name: str, size: int, words: str) -> None:
    with (tmp_path / name).open("wb") as mesh:
        mesh.truncate(size)
    around = f'<asset><mesh name="shell" file="{name}"/></asset>'
    assert words in faults(world(tmp_path, body(inertial='<geom type="mesh" mesh="shell"/>'), around))


# Tendons that couple joints


@pytest.mark.mends("4.tendon")
def test_an_equality_of_fixed_tendons_is_the_coupling_that_mujoco_keeps(tmp_path: Path) -> None:
    """0.5 (a - 0.3) + 1.5 b - 0.1 = 2 · 0.25 b: b follows a, and c follows b by a chain."""
    two = '<fixed name="u"><joint joint="b" coef="0.25"/></fixed>'
    three = '<fixed name="v"><joint joint="c" coef="-1"/><joint joint="b" coef="4"/></fixed>'
    joints = (
        '<joint name="a" axis="0 1 0" ref="0.3"/>',
        '<joint name="b" axis="0 1 0"/>',
        '<joint name="c" type="slide"/>',
    )
    inside = "".join(body(one, name=f"on_{k}").replace("<body", '<body pos="0 0 1"') for k, one in enumerate(joints))
    around = (
        '<compiler angle="radian"/><tendon><fixed name="t"><joint joint="a" coef="0.5"/><joint joint="b" coef="1.5"/>'
        f'</fixed>{two}{three}</tendon><equality><tendon name="e" tendon1="t" tendon2="u" polycoef="0.1 2 0 0 0"/>'
        '<tendon name="f" tendon1="v"/></equality>'
    )
    path = world(tmp_path, inside, around)
    scene = mjcf.read(path, ReadOptions()).scene
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)

    assert scene.coordinates == ("q1",)
    for a in (-0.4, 0.3, 1.1):
        for joint in scene.joints:
            coupled = joint.coupling
            value = (
                a if coupled is None else float(dict(coupled.ratios)["q1"].at({})) * a + float(coupled.offset.at({}))
            )
            data.joint(joint.name).qpos[0] = value
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY], 0, atol=1e-15)


def test_an_equality_of_a_fixed_tendon_ties_three_joints_as_mujoco_does(tmp_path: Path) -> None:
    """2 (a - 0.3) + b - 4 c = 0.1: the outermost follows both others, as in a differential."""
    joints = ('<joint name="a" ref="0.3"/>', '<joint name="b"/>', '<joint name="c"/>')
    inside = "".join(body(one, name=f"on_{k}") for k, one in enumerate(joints))
    coefs = "".join(f'<joint joint="{name}" coef="{x}"/>' for name, x in (("a", 2), ("b", 1), ("c", -4)))
    around = '<compiler angle="radian"/>' + TENDON.format(coefs, "").replace(
        'tendon1="t"', 'tendon1="t" polycoef="0.1 0 0 0 0"'
    )
    path = world(tmp_path, inside, around)
    reading = mjcf.read(path, ReadOptions())
    model = mujoco.MjModel.from_xml_path(str(path))
    data, (tied,) = mujoco.MjData(model), (one.coupling for one in reading.scene.joints if one.coupling)

    assert any("c follows a, b without give here" in note for note in reading.notes)
    for a, b in ((0.3, 0.0), (-0.4, 1.1)):
        slopes = [float(slope.at({})) for _, slope in tied.ratios]
        data.qpos[:] = a, b, slopes @ np.array([a, b]) + float(tied.offset.at({}))
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY], 0, atol=1e-15)


@pytest.mark.mends("4.armature")
def test_the_rotor_of_a_ball_resists_as_in_mujoco(tmp_path: Path) -> None:
    inertial = '<inertial pos="0.1 0.05 0.3" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/>'
    inner = f'<body pos="0.3 0 0.1" euler="0 23 0"><joint name="l" type="ball" armature="0.4"/>{inertial}</body>'
    ball = f'<joint name="k" type="ball" pos="0.01 0.02 0.1" armature="0.7"/>{inertial}{inner}'
    middle = f'<body pos="0.2 0.1 0" euler="10 20 30">{ball}</body>'
    path = world(tmp_path, f'<body><joint name="j" axis="1 2 0" armature="0.2"/>{inertial}{middle}</body>')
    scene = mjcf.read(path, ReadOptions()).scene
    assert [spell(joint.armature) for joint in scene.joints] == ["0.2", "0.7", "0.4"]
    peer, rng = Peer(path, scene), np.random.default_rng(3)
    q, (qd, qdd) = draw(scene, rng), rng.uniform(-2, 2, (2, len(scene.velocities)))
    inverse, mass, forward = lambdify(scene, ("inverse_dynamics", "mass_matrix", "forward_dynamics"))
    tau = peer.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(inverse(q, qd, qdd), tau, rtol=0, atol=1e-13 * np.abs(tau).max())
    np.testing.assert_allclose(mass(q), peer.mass_matrix(q), rtol=0, atol=1e-13)
    np.testing.assert_allclose(forward(q, qd, tau), qdd, rtol=0, atol=1e-12)


FLOOR = """<geom type="plane" size="5 5 1" pos="0 0 0.1" friction="0.4 0 0"/>
<geom type="plane" size="5 5 1" contype="0" conaffinity="0"/>
<body name="b"><joint name="along" type="slide" axis="1 0 0"/><joint name="lift" type="slide" axis="0 0 1"/>
<geom type="sphere" size="0.1" mass="2" pos="0 0 -0.2" friction="0.7 0 0"/>
<geom type="capsule" size="0.05" fromto="0 0 0 0.3 0 0" mass="1" condim="1" priority="1"/>
<geom type="sphere" size="0.5" mass="1" contype="2" conaffinity="4"/><geom type="box" size="0.1 0.1 0.1"/></body>"""


def test_a_floor_is_told_as_contacts_that_say_the_same(tmp_path: Path) -> None:
    """Nothing of it is read; its rows, written under [contacts], are a ball that falls on the plane and slides."""
    found = mjcf.read(world(tmp_path, FLOOR), ReadOptions())
    told = [note.rpartition("robot.xml: ")[2] for note in found.notes]
    assert not found.scene.unilaterals
    assert sum("[contacts], rigid, whatever solref and solimp say" in note for note in told) == 1
    rows = [note for note in told if note.startswith("b_")]
    plane = "plane = { at = [0, 0, 0.1], normal = [0, 0, 1] }"
    assert sorted(rows) == [
        f'b_1 = {{ type = "ball", body = "b", at = [0, 0, -0.2], radius = 0.1, {plane}, friction = 0.7 }}',
        f'b_2 = {{ type = "ball", body = "b", at = [0, 0, 0], radius = 0.05, {plane}, friction = 0 }}',
        f'b_3 = {{ type = "ball", body = "b", at = [0.3, 0, 0], radius = 0.05, {plane}, friction = 0 }}',
    ]
    scene = read_text(write_text(found.scene, "toml").text + "\n[contacts]\n" + "\n".join(rows))
    gap = lambdify(scene, "gap:b_1")
    assert gap([0.0, 0.5]) == pytest.approx(0.5 - 0.2 - 0.1 - 0.1)
    assert gap([0.3, 1.0]) == pytest.approx(1.0 - 0.4)
