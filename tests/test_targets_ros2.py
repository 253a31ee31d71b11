"""The package of ROS 2: what it holds and refuses; built against stubs of the interfaces, its numbers are ours."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hostile import in_markdown

import symdyn
from symdyn.cli import main
from symdyn.dynamics import derive
from symdyn.emit import TARGETS, beside, emit
from symdyn.program import lower
from symdyn.scene import Scene, read

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
STUBS = HERE / "data" / "ros2"
GRIPPER = HERE / "data" / "gripper_arm.urdf"

RUBBING = """
name = "Rubbing__Arm"
[bodies.a]
mass = 2
com = ["1/3", 0, 0]
inertia = [0.1, 0.2, 0.3]
inertia_about = "com"
[bodies.b]
mass = 1
com = [0, "1/4", "1/5"]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[bodies.stand]
[joints.weld]
type = "fixed"
parent = "ground"
child = "stand"
origin = { xyz = [0, 0, 2] }
[joints.turn]
type = "revolute"
parent = "stand"
child = "a"
axis = [0, 1, 0]
damping = 2
friction = { coulomb = 0.5, smoothing = 0.1 }
armature = 0.3
[joints.slide]
type = "prismatic"
parent = "a"
child = "b"
axis = [1, 0, 0]
origin = { xyz = [1, 0, 0] }
damping = 3
[points.m1]
body = "b"
at = [0, 0, 0.5]
"""


def generated(folder: Path, scene: Path | str, *words: str) -> int:
    return main(["generate", str(scene), "--target", "ros2", "-o", str(folder), "--quiet", *words])


def written(folder: Path) -> Path:
    path = folder / "rubbing.toml"
    path.write_text(RUBBING, encoding="utf-8")
    return path


@pytest.mark.long
def test_what_describes_the_package_agrees_with_what_it_holds(tmp_path: Path) -> None:
    assert generated(tmp_path / "p", written(tmp_path)) == 0
    package = ElementTree.parse(tmp_path / "p" / "package.xml").getroot()
    name = package.findtext("name")

    assert name == "symdyn_rubbing_arm"
    assert f"project({name} " in (tmp_path / "p" / "CMakeLists.txt").read_text()
    assert {one.text for one in package.findall("depend")} >= {"inverse_dynamics_solver", "kinematics_interface"}
    for kind in ("dynamics", "kinematics"):
        described = ElementTree.parse(tmp_path / "p" / f"{kind}.xml").getroot()
        (plugin,) = described.findall("class")
        exported = f"PLUGINLIB_EXPORT_CLASS({plugin.get('type')}, {plugin.get('base_class_type')})"
        assert described.get("path") == name
        assert plugin.get("name") == f"{name}/{kind.title()}"
        assert exported in (tmp_path / "p" / "src" / f"{kind}.cpp").read_text()


@pytest.mark.long
def test_a_description_that_somebody_made_theirs_is_left_as_it_is(tmp_path: Path) -> None:
    generated(tmp_path, written(tmp_path))
    whole = (tmp_path / "package.xml").read_text(encoding="utf-8").splitlines(keepends=True)
    theirs = "".join(line for line in whole if "Written by symdyn" not in line)
    (tmp_path / "package.xml").write_text(theirs, encoding="utf-8")
    generated(tmp_path, written(tmp_path))

    assert (tmp_path / "package.xml").read_text(encoding="utf-8") == theirs


@pytest.mark.long
def test_a_robot_may_be_called_anything() -> None:
    name = "R */ int canary; /* ]]> <canary/> & \" ' --> `canary` [x](canary) $(canary) \\"
    scene = replace(read(GRIPPER), name=name)
    sources = emit(lower(derive(scene, TARGETS["ros2"].functions(scene))), "ros2")  # type: ignore[misc]

    for path, text in {**sources.texts, **beside(sources)}.items():
        if path.endswith(".xml"):
            assert "canary" not in {one.tag for one in ElementTree.fromstring(text).iter()}
        elif path.endswith(".md"):
            assert in_markdown(text) == []
        else:
            code = re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)
            assert not re.search(r"(?<!\w)canary", code), path


REFUSED = [
    ("four_bar", "", "closed loops"),
    ("free_body", "", "joints that have several coordinates"),
    ("rolling_disc", "", "forces beside gravity"),
    ("states/servo", "", "states of one's own"),
    ("two_link", "", "m1, m2, h1, h2, g without a value; give --bind m1=1,m2=1,h1=1,h2=1,g=1"),
    ("two_link", "--functions pose:tool", "is made of mass_matrix, .*; leave --functions out"),
    ("puma560", "--static", "is about motion; leave --static out"),
    ("puma560", "--real float", "takes double alone"),
]


@pytest.mark.parametrize(("scene", "words", "told"), REFUSED)
def test_what_the_interfaces_have_no_place_for_is_refused(
    scene: str, words: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert generated(tmp_path, EXAMPLES / f"{scene}.toml", *words.split()) == 1
    assert re.search(told, capsys.readouterr().err)
    assert not [*tmp_path.iterdir()]


# Built


def run(folder: Path, *words: str, given: str = "") -> str:
    done = subprocess.run(words, cwd=folder, input=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()
    return done.stdout


def built(folder: Path) -> str:
    """Return what builds a package for CMake and ctest say."""
    flags = "-Wall -Wextra -Wshadow -pedantic"
    run(folder, "cmake", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={STUBS}", f"-DCMAKE_CXX_FLAGS={flags}",
        "-DCMAKE_BUILD_TYPE=Debug")  # fmt: skip
    run(folder, "cmake", "--build", "build")
    return run(folder, "ctest", "--test-dir", "build", "--output-on-failure", "-V")


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return what loads a package's plugins by the names of their classes, as pluginlib does."""
    folder = tmp_path_factory.mktemp("driver")
    headers = [f"-I{STUBS / 'include'}", "-isystem", "/usr/include/eigen3"]
    run(folder, "g++", "-std=c++17", *headers, "-rdynamic", str(STUBS / "driver.cpp"), "-o", "driver", "-ldl")
    return str(folder / "driver")


def asked(driver: str, folder: Path, *lines: str) -> list[np.ndarray | None]:
    """Return what the plugins answer, a line each; None for what is refused."""
    (library,) = (folder / "build").glob("libsymdyn_*.so")
    types = []
    for category in ("inverse_dynamics_solver", "kinematics_interface"):
        described = ElementTree.parse((folder / "build" / "plugins" / category).read_text()).getroot()
        assert library.name == f"lib{described.get('path')}.so"
        types.append(str(described.find("class").get("type")))  # type: ignore[union-attr]
    told = run(folder, driver, str(library), *types, given="\n".join([*lines, ""])).splitlines()
    return [None if one == "refused" else np.array(one.split(), float) for one in told]


def row(*vectors: Sequence[float]) -> str:
    return " ; ".join(" ".join(f"{x:.17g}" for x in one) for one in vectors)


def close(found: np.ndarray | None, wanted: np.ndarray) -> None:
    assert found is not None
    np.testing.assert_allclose(found, np.ravel(wanted), rtol=1e-12, atol=1e-12)


def compared(driver: str, folder: Path, scene: Scene, links: Sequence[str], states: np.ndarray) -> None:
    """Hold both plugins against functions of NumPy at states, shape (any, 3, n)."""
    asks = [*("mass_matrix", "velocity_forces", "gravity_forces", "inverse_dynamics"),
            *(f"{kind}:{one}" for one in links for kind in ("pose", "jacobian"))]  # fmt: skip
    f = symdyn.load(scene, asks)
    n = len(scene.coordinates)
    for q, qd, qdd in states:
        M, c, g, tau = f.mass_matrix(q), f.velocity_forces(q, qd), f.gravity_forces(q), f.inverse_dynamics(q, qd, qdd)
        rubbing = f.inverse_dynamics(q, qd, np.zeros(n)) - c - g
        _, *found = asked(driver, folder, "begin -", f"H {row(q)}", f"c {row(q, qd)}", f"g {row(q)}", f"f {row(qd)}",
                          f"tau {row(q, qd, qdd)}")  # fmt: skip
        for one, wanted in zip(found, (M, c, g, rubbing, tau - rubbing), strict=True):
            close(one, wanted)
        for link in links:
            J = f[f"jacobian:{link}"](q)
            dx = J @ qd
            damped = np.linalg.solve(J.T @ J + 5e-6 * np.eye(n), J.T)
            _, *found = asked(driver, folder, "begin -", f"pose {link} {row(q)}", f"J {link} {row(q)}",
                              f"to_cartesian {link} {row(q, qd)}", f"inverse {link} {row(q)}",
                              f"to_joints {link} {row(q, dx)}")  # fmt: skip
            for one, wanted in zip(found[:3], (f[f"pose:{link}"](q), J, dx), strict=True):
                close(one, wanted)
            np.testing.assert_allclose(found[3], damped.ravel(), rtol=0, atol=1e-7 * np.abs(damped).max())
            np.testing.assert_allclose(found[4], damped @ dx, rtol=0, atol=1e-8)


def states_of(scene: Scene) -> np.ndarray:
    """Return zeros, equal angles, and a random state."""
    n = len(scene.coordinates)
    return np.array([np.zeros((3, n)), np.full((3, n), 0.5), np.random.default_rng(2).normal(size=(3, n))])


programs = pytest.mark.runs("cmake", "g++")


@programs
@pytest.mark.slow
def test_joints_that_rub_have_their_friction_apart_from_torques(driver: str, tmp_path: Path) -> None:
    path = written(tmp_path)
    generated(tmp_path / "p", path)
    told = built(tmp_path / "p")

    assert told.count(" right") > 10
    assert "WRONG" not in told
    scene = read(path)
    compared(driver, tmp_path / "p", scene, ["stand", "a", "b", "m1"], states_of(scene))


@programs
@pytest.mark.slow
def test_a_robot_of_urdf_has_followers_chains_and_its_own_names(driver: str, tmp_path: Path) -> None:
    generated(tmp_path, GRIPPER)
    built(tmp_path)
    scene = read(GRIPPER)
    compared(driver, tmp_path, scene, ["upper_arm", "palm", "finger_right"], states_of(scene))

    q = np.array([0.3, -0.4, 0.01])
    J = symdyn.load(scene, ["jacobian:palm"])["jacobian:palm"](q)
    begun, *found = asked(
        driver, tmp_path, "text kinematics.tip palm", "text kinematics.base world", f"begin {GRIPPER}",
        f"J palm {row(q[:2])}", f"pose upper-arm {row(q[:2])}", f"pose world {row(q[:2])}", f"J world {row(q[:2])}",
        f"J palm {row(q)}", f"J finger_left {row(q[:2])}", f"J nothing {row(q[:2])}", f"H {row(q[:2])}",
    )  # fmt: skip
    assert begun is not None
    assert not J[:, 2].any()
    close(found[0], J[:, :2])
    assert found[1] is not None
    close(found[2], np.eye(3, 4))
    close(found[3], np.zeros((6, 2)))
    assert found[4:] == [None] * 4


@programs
@pytest.mark.slow
def test_parameters_descriptions_and_frames_are_looked_at(driver: str, tmp_path: Path) -> None:
    generated(tmp_path, EXAMPLES / "two_link.toml", "--bind", "m1=1,m2=2,h1=1,h2=1/2,g=9.81")
    built(tmp_path)
    other = tmp_path / "other.urdf"
    other.write_text("<robot name='r'><joint name='shoulder'/><joint name = \"elbow-2\"/></robot>")
    right = tmp_path / "right.urdf"
    right.write_text("<robot name='r'><joint name='shoulder'/><joint name = \"elbow\"/></robot>")
    begins = {
        "begin -": True,
        f"begin {right}": True,
        f"begin {other}": False,
        "text kinematics.tip hand\nbegin -": False,
        "text kinematics.base link1\nbegin -": False,
        "number kinematics.alpha -1\nbegin -": False,
        "number kinematics.alpha 0.5\nbegin -": True,
    }
    for words, fine in begins.items():
        (found,) = asked(driver, tmp_path, words)
        assert (found is not None) == fine, words
    (before,) = asked(driver, tmp_path, f"J tool {row([0, 0])}")
    assert before is None

    f, params = symdyn.load(EXAMPLES / "two_link.toml", ["jacobian:tool"]), np.array([1, 2, 1, 0.5, 9.81])
    J = f["jacobian:tool"](np.array([0.2, 0.7]), params)
    _, found = asked(driver, tmp_path, "number kinematics.alpha 0.5\nbegin -", f"inverse tool {row([0.2, 0.7])}")
    close(found, np.linalg.solve(J.T @ J + 0.5 * np.eye(2), J.T))

    def turned(axis: Sequence[float], angle: float) -> list[float]:
        return [*(np.sin(angle / 2) * np.array(axis) / np.linalg.norm(axis)), np.cos(angle / 2)]

    a, b = [1, 2, 3, *turned([1, 0, 0], np.pi / 2)], [1, 0, 3.5, *turned([1, 0, 0], np.pi / 2)]
    about_y = [0, 0, 0, *turned([0, 1, 0], 0.6)]
    _, *found = asked(
        driver, tmp_path, "begin -", f"difference {row(a, b, [0.5])}", f"difference {row(a, a, [0])}",
        f"difference {row(about_y, [0, 0, 0, 0, 0, 0, 1], [2])}",
        f"difference {row(about_y, [0, 0, 0, *(-x for x in turned([0, 1, 0], 0.7))], [1])}",
        f"difference {row([0, 0, 0, *turned([0, 0, 1], np.pi / 2)], [0, 0, 0, 0.5, 0.5, 0.5, 0.5], [1])}",
    )  # fmt: skip
    close(found[0], np.array([0, -4, 1, 0, 0, 0]))
    assert found[1] is None
    close(found[2], np.array([0, 0, 0, 0, -0.3, 0]))
    close(found[3], np.array([0, 0, 0, 0, 0.1, 0]))
    close(found[4], np.array([0, 0, 0, 0, np.pi / 2, 0]))  # about y of the ground, by which x of the first frame stands


@programs
@pytest.mark.slow
@pytest.mark.parametrize("file", ["src/puma560.c", "src/dynamics.cpp", "src/kinematics.cpp"])
def test_a_wrong_number_fails_the_package_s_own_test(file: str, tmp_path: Path) -> None:
    change = {
        "src/puma560.c": (r"(out\[1\] = )", r"\1- "),
        "src/dynamics.cpp": (r"return tau", "return -tau"),
        "src/kinematics.cpp": (r"all\[row \* JOINTS", "all[(5 - row) * JOINTS"),
    }
    generated(tmp_path, EXAMPLES / "puma560.toml")
    path = tmp_path / file
    path.write_text(re.sub(*change[file], path.read_text(), count=1))

    with pytest.raises(AssertionError, match="WRONG"):
        built(tmp_path)
