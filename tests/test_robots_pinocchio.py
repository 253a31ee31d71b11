"""Every URDF of example-robot-data agrees with Pinocchio to 1e-12, or is refused for a reason that holds."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mpmath
import numpy as np
import pytest
from robots import NUMBERS, FloatingPeer, Peer, differences, number, relative, robot_files, robot_folder

from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import SceneError
from symdyn.program import lower
from symdyn.runtime import lambdify
from symdyn.scene import Scene
from symdyn.scene.declaration.reading import Reading, ReadOptions
from symdyn.scene.formats import sdf, sdf_writer
from symdyn.scene.formats.urdf import read
from symdyn.scene.formats.urdf_writer import write_text

pytestmark = pytest.mark.slow

pytest.importorskip("pinocchio")

FILES = robot_files()

CLOSE = 1e-12

REFUSED = {
    "alex_psyonic_hands.urdf": r'joint Left_index_q2: mimic\.joint = "index_q1" is not a joint',
    "quadrotor_base.urdf": "nothing moves",
    "quadrotor_base.urdf.xacro": "is a macro; run xacro first",
    "iris_simple.urdf": "nothing moves",
    "ur3.urdf": "there is no <link>",
}
"""Files that hold no mechanism, and what is said of them."""

FLOATING = ("solo12.urdf", "a1.urdf", "talos_full_v2.urdf", "hyq_no_sensors.urdf", "ur5_robot.urdf", "panda.urdf")


def name(path: Path) -> str:
    folder = robot_folder()
    return str(path.relative_to(folder)) if folder else path.name


def read_plainly(path: Path, floating_base: str | None = None) -> Reading:
    return read(path, ReadOptions(snap=False, allow_invalid_inertia=True, floating_base=floating_base))


needs_robots = pytest.mark.skipif(not FILES, reason="the package example-robot-data is not installed")

every_file = pytest.mark.parametrize("path", FILES, ids=name)

every_robot = pytest.mark.parametrize("path", [path for path in FILES if path.name not in REFUSED], ids=name)


following = pytest.mark.parametrize(
    "path", [path for path in FILES if path.name not in REFUSED and "<mimic" in path.read_text("utf-8")], ids=name
)


@needs_robots
def test_there_are_seventy_files():
    assert len(FILES) == 70
    assert {path.name for path in FILES} >= set(REFUSED)


@every_robot
def test_the_dynamics_are_those_of_pinocchio(path):
    scene = read_plainly(path).scene
    peer = Peer(path, scene)
    found = differences(scene, peer)

    assert found["inverse_dynamics"] <= CLOSE
    assert found["mass_matrix"] <= CLOSE
    if np.isnan(found["forward_dynamics"]):  # it does not exist where the mass matrix is singular
        M = peer.mass_matrix(np.full(len(scene.coordinates), 0.3))
        assert np.min(np.linalg.eigvalsh(M)) <= 1e-15 * np.max(M)
    else:
        assert found["forward_dynamics"] <= CLOSE


@every_robot
def test_a_robot_that_goes_through_sdf_is_that_of_pinocchio(path, tmp_path):
    scene = read_plainly(path).scene
    file = tmp_path / "robot.sdf"
    file.write_text(sdf_writer.write_text(scene).text)
    back = sdf.read(file, ReadOptions(snap=False, allow_invalid_inertia=True)).scene
    names = [joint.name for joint in scene.joints if joint.moves]  # in SDF no joint is called as a link
    renamed = dict(zip([joint.name for joint in back.joints if joint.moves], names, strict=True))
    joints = tuple(replace(joint, name=renamed.get(joint.name, joint.name)) for joint in back.joints)
    found = differences(replace(back, joints=joints), Peer(path, scene))

    assert found["inverse_dynamics"] <= CLOSE
    assert found["mass_matrix"] <= CLOSE


@needs_robots
@pytest.mark.parametrize("path", [path for path in FILES if path.name in FLOATING], ids=name)
def test_a_floating_base_is_the_free_flyer_of_pinocchio(path):
    """Position, quaternion, velocities in the moved frame: the free flyer, but for the place of the quaternion's w."""
    scene = read_plainly(path, floating_base="base").scene
    found = differences(scene, FloatingPeer(path, read_plainly(path).scene))

    assert scene.joints[0].type == "free"
    assert max(found.values()) <= CLOSE


ORDERED = ("solo12.urdf", "anymal.urdf", "talos_reduced.urdf", "hyq_no_sensors.urdf", "icub.urdf")
"""Robots with branches whose joints all have limits, so that Pinocchio's positions are ours but for their order."""


@needs_robots
@pytest.mark.parametrize("path", [path for path in FILES if path.name in ORDERED], ids=name)
@pytest.mark.parametrize("base", ["root_joint", None])
def test_an_order_of_joints_takes_pinocchio_s_numbers_to_ours(path, base):
    """By the names in its model alone, which come in another order."""
    import pinocchio as pin

    scene = read_plainly(path, floating_base=base).scene
    model = pin.buildModelFromUrdf(str(path), *([pin.JointModelFreeFlyer()] if base else []))
    data = model.createData()
    order = scene.order(list(model.names)[1:], quaternion="xyzw")
    damping = np.zeros(model.nv)
    for joint in scene.moving:
        damping[list(scene.velocities).index(joint.rates[0])] += number(joint.damping)
    inverse, mass = lambdify(scene, ("inverse_dynamics", "mass_matrix"))
    rng = np.random.default_rng(3)
    q_, (v_, a_) = rng.uniform(-1, 1, model.nq), rng.uniform(-1, 1, (2, model.nv))
    if base:
        q_[3:7] /= np.linalg.norm(q_[3:7])
    q, v, a = np.empty(model.nq), np.empty(model.nv), np.empty(model.nv)
    q[order.q], v[order.v], a[order.v] = q_, v_, a_
    M = pin.crba(model, data, q_)

    assert relative((inverse(q, v, a) - damping * v)[order.v], pin.rnea(model, data, q_, v_, a_)) <= CLOSE
    assert relative(mass(q)[np.ix_(order.v, order.v)], np.triu(M) + np.triu(M, 1).T) <= CLOSE


@following
def test_following_joints_agree_with_pinocchio_s_own(path):
    scene = read_plainly(path).scene
    if not any(joint.coupling for joint in scene.joints):
        pytest.skip("only fixed joints follow another one")
    try:
        peer = Peer(path, scene, mimic=True)
    except ValueError as error:
        pytest.skip(f"Pinocchio refuses: {error}")
    found = differences(scene, peer, states=1)

    assert found["inverse_dynamics"] <= CLOSE
    assert found["mass_matrix"] <= CLOSE


@every_file
def test_what_holds_no_mechanism_is_refused_for_its_reason(path):
    if path.name in REFUSED:
        with pytest.raises(SceneError, match=REFUSED[path.name]):
            read_plainly(path)
    else:
        assert read_plainly(path).scene.coordinates


@every_robot
def test_inertias_are_refused_exactly_where_no_body_has_them(path):
    warned = [line for line in read_plainly(path).notes if "is not physically consistent" in line]

    assert [re.search(r"link (\S+): inertia", line)[1] for line in warned] == impossible_links(path)
    if impossible_bodies(path):
        with pytest.raises(SceneError, match="is not physically consistent"):
            read(path, ReadOptions())
    else:
        assert read(path, ReadOptions()).scene.bodies


ROUNDING = mpmath.mpf(10) ** -17
"""Beside which moments of inertia are judged, kg m^2."""


def impossible_bodies(path: Path) -> int:
    """Return how many bodies of Pinocchio's model, which has merged what is welded, have inertias that none has."""
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(path))
    moments = [np.linalg.eigvalsh(one.inertia) for one in model.inertias.tolist()[1:]]
    return sum(small + middle < large - max(1e-12 * large, float(ROUNDING)) for small, middle, large in moments)


def impossible_links(path: Path) -> list[str]:
    """Return the links, the root aside, whose principal moments are negative or break the triangle inequality."""
    root = ElementTree.parse(path).getroot()
    children = {child.attrib["link"] for child in root.findall("joint/child")}
    found = []
    for link in root.findall("link"):
        inertia = link.find("inertial/inertia")
        if inertia is None or link.attrib["name"] not in children:
            continue
        with mpmath.workdps(60):
            xx, xy, xz, yy, yz, zz = (mpmath.mpf(inertia.attrib[key]) for key in NUMBERS)
            small, middle, large = sorted(mpmath.eigsy(mpmath.matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))[0])
            slack = ROUNDING
            if small < -slack or small + middle < large - slack:
                found.append(link.attrib["name"])
    return found


@every_robot
def test_snapping_changes_a_robot_by_no_more_than_its_angles_were_rounded(path):
    snapped = read(path, ReadOptions(allow_invalid_inertia=True))
    plain = read_plainly(path).scene
    texts = [note.removeprefix(f"{path}: ").split(" is read as ")[0] for note in snapped.notes if "is read as" in note]
    rounding = sum(10.0 ** -len(text.partition(".")[2].partition("e")[0]) for text in texts)
    n = len(plain.coordinates)
    q = np.random.default_rng(1).uniform(-2, 2, n)

    assert relative(mass_matrix(snapped.scene, q), mass_matrix(plain, q)) <= 100 * rounding + 1e-13


@every_robot
def test_a_robot_that_is_written_and_read_again_is_the_same(path, tmp_path):
    scene = read(path, ReadOptions(allow_invalid_inertia=True)).scene
    file = tmp_path / "again.urdf"
    file.write_text(write_text(scene).text)
    again = read(file, ReadOptions(allow_invalid_inertia=True)).scene
    n = len(scene.coordinates)
    q = np.random.default_rng(1).uniform(-2, 2, n)

    assert [line for line in write_text(scene).lost if "allow_invalid_inertia" not in line] == []
    assert again == scene or relative(mass_matrix(again, q), mass_matrix(scene, q)) <= 1e-14


@needs_robots
@pytest.mark.parametrize("robot", ["talos_full_v2", "icub", "romeo", "g1_29dof_rev_1_0", "centauro"])
def test_a_humanoid_becomes_c_within_a_second(robot):
    path = next(path for path in FILES if path.name == f"{robot}.urdf")

    def file_to_c() -> float:
        start = time.process_time()
        scene = read(path, ReadOptions(allow_invalid_inertia=True)).scene
        sources = emit(lower(derive(scene, ("inverse_dynamics",))), "c")
        assert len(sources.files[0][1]) > 10_000
        return time.process_time() - start

    assert min(file_to_c() for _ in range(3)) < 1.0


def mass_matrix(scene: Scene, q: np.ndarray) -> np.ndarray:
    return lambdify(scene, "mass_matrix")(q)
