"""MJCF files read through MuJoCo's compiler move as MuJoCo moves them."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symdyn.build import lambdify
from symdyn.errors import SceneError
from symdyn.scene import Scene, spell
from symdyn.scene.formats import mjcf
from symdyn.scene.quantity import number
from symdyn.scene.reading import Reading, ReadOptions
from symdyn.scene.value import value_of

mujoco = pytest.importorskip("mujoco")

DATA = Path(__file__).parent / "data"

FILES = ("pendulum.xml", "cart_pole.xml", "arm.xml", "gimbal.xml")

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
    """The same file in MuJoCo, driven by our coordinates: q' = A q + b, meshes taken out, nothing touching."""

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
        self.A, self.b = np.zeros((self.model.nv, len(scene.coordinates))), np.zeros(self.model.nv)
        for joint in scene.joints:
            if joint.moves:
                dof = self.model.joint(joint.name).dofadr[0]
                coupling = joint.coupling
                column = scene.coordinates.index(coupling.coordinate if coupling else joint.coordinate)
                self.A[dof, column] = value_of(coupling.ratio, {}) if coupling else 1
                self.b[dof] = value_of(coupling.offset, {}) if coupling else 0

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        self.data.qpos, self.data.qvel, self.data.qacc = self.A @ q + self.b, self.A @ qd, self.A @ qdd
        mujoco.mj_inverse(self.model, self.data)
        return self.A.T @ self.data.qfrc_inverse

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        self.inverse_dynamics(q, 0 * q, 0 * q)
        every = [np.eye(self.model.nv)[k] for k in range(self.model.nv)]
        columns = []
        for unit in every:
            column = np.zeros(self.model.nv)
            mujoco.mj_mulM(self.model, self.data, column, unit)
            columns.append(column)
        return self.A.T @ np.array(columns).T @ self.A

    def forward_dynamics(self, q: np.ndarray, qd: np.ndarray, tau: np.ndarray) -> np.ndarray:
        self.data.qpos, self.data.qvel, self.data.qfrc_applied = self.A @ q + self.b, self.A @ qd, tau
        mujoco.mj_forward(self.model, self.data)
        return self.data.qacc.copy()


@pytest.mark.parametrize("snap", [True, False])
@pytest.mark.parametrize("name", FILES)
def test_dynamics_are_those_of_mujoco(name: str, snap: bool) -> None:
    scene = read(name, snap=snap).scene
    peer = Peer(DATA / name, scene)
    inverse, mass, forward = lambdify(scene, ("inverse_dynamics", "mass_matrix", "forward_dynamics"))
    rng = np.random.default_rng(7)
    for _ in range(5):  # MuJoCo before 4 turns a full inertia into principal axes to ten digits only
        q, qd, qdd = rng.uniform(-2, 2, (3, len(scene.coordinates)))
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
        number(Fraction(text)) for text in ("0.05", "0.01", "0.02")
    )
    assert (spell(hinge.limits.lower), spell(hinge.limits.upper)) == ("-2*pi/3", "pi/2")
    assert spell(hinge.force) == "-3*(q1 - pi/6)/2"
    effort = read("arm.xml").scene.joints[2].limits.effort
    assert effort == number(40)


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
    assert [body.mass == number(0) for body in scene.bodies] == [True, True, True, False, False]


def test_a_linear_equality_is_a_coupling() -> None:
    reading = read("gimbal.xml")
    geared = reading.scene.joints[-1]
    assert geared.coupling is not None
    assert geared.coupling.coordinate == "q1"
    assert (spell(geared.coupling.ratio), spell(geared.coupling.offset)) == ("-2", "7*pi/36 + 0.1")
    assert any("geared follows yaw" in note for note in reading.notes)


def test_gravity_is_off_when_the_file_says_so(tmp_path: Path) -> None:
    path = world(tmp_path, body(), '<option gravity="1 2 3"><flag gravity="disable"/></option>')
    assert [spell(x) for x in mjcf.read(path, ReadOptions()).scene.gravity] == ["0", "0", "0"]
    path = world(tmp_path, body(), '<option gravity="1 2 3.7"/>')
    assert [spell(x) for x in mjcf.read(path, ReadOptions()).scene.gravity] == ["1", "2", "3.7"]


def test_springs_and_dampers_are_off_when_the_file_says_so(tmp_path: Path) -> None:
    joint = '<joint name="j" stiffness="2" damping="3"/>'
    path = world(tmp_path, body(joint), '<option><flag spring="disable" damper="disable"/></option>')
    found = mjcf.read(path, ReadOptions()).scene.joints[0]
    assert (found.force, found.damping) == (number(0), number(0))


def test_names_that_cannot_be_printed_are_changed_with_a_note(tmp_path: Path) -> None:
    path = world(tmp_path, body('<joint name="left/hip-1"/>', name="for"))
    reading = mjcf.read(path, ReadOptions())
    assert (reading.scene.joints[0].name, reading.scene.bodies[0].name) == ("left_hip_1", "for_frame")
    assert any("joint left/hip-1: is called left_hip_1 here" in note for note in reading.notes)


@pytest.mark.parametrize(
    ("inside", "around", "message"),
    [
        (body('<freejoint name="root"/>'), "", "joint root: is a free joint, .* delete it to hold the body"),
        (body('<joint name="j" type="ball"/>'), "", "joint j: is a ball joint, .* write three hinges"),
        (
            body() + body('<joint name="k"/>', name="c"),
            '<equality><weld name="w" body1="b" body2="c"/></equality>',
            "equality w: is a weld constraint, .* closed loops",
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
            "body b: takes its inertia from the mesh shell, and meshes are not opened",
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
    text = faults(world(tmp_path, body("<freejoint/>") + body('<joint type="ball"/>', name="c")))
    assert "free joint" in text
    assert "ball joint" in text


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


def test_a_mesh_in_the_file_itself_gives_its_inertia(tmp_path: Path) -> None:
    corners = " ".join(f"{x} {y} {z}" for x in (0, 1) for y in (0, 2) for z in (0, 3))
    geom = '<geom type="mesh" mesh="brick" density="1"/>'
    path = world(tmp_path, body(inertial=geom), f'<asset><mesh name="brick" vertex="{corners}"/></asset>')
    found = mjcf.read(path, ReadOptions()).scene.bodies[0]
    assert float(found.mass.value) == pytest.approx(6, rel=1e-6)  # type: ignore[arg-type]


def test_without_mujoco_the_way_to_get_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert "pip install symdyn[mjcf]" in faults(world(tmp_path, body()))


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
    assert reading.scene.joints[0].limits.effort == number(5)
