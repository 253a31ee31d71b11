"""Paths of points and frames: coordinates along them against closed forms of inverse kinematics, and what is told."""

from __future__ import annotations

from itertools import product
from math import acos, asin, atan2, cos, hypot, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import Scene, bind, read, read_text
from symdyn.simulation import inverse
from symdyn.simulation.trajectory import Trajectory

pytestmark = pytest.mark.runs("cc")

EXAMPLES = Path(__file__).parent.parent / "examples"
LINKS = {"m1": 1, "m2": 1, "h1": 1, "h2": "0.8", "g": "9.81"}

Array = np.ndarray[Any, np.dtype[np.float64]]


@pytest.fixture(scope="module")
def two_link() -> Scene:
    return bind(read(EXAMPLES / "two_link.toml"), LINKS)


@pytest.fixture(scope="module")
def puma() -> Scene:
    return read(EXAMPLES / "puma560.toml")


def along(scene: Scene, path: Any, until: float = 2.0, count: int = 21, **more: Any) -> Trajectory:
    return inverse(scene, times=np.linspace(0.0, until, count), path=path, say=lambda line: None, **more)


def slope(x: Array, t: Array) -> Array:
    """Return central differences of order six."""
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * (t[1] - t[0]))
    return np.sum([w * x[k : len(x) - 6 + k] for k, w in enumerate(weights)], axis=0)


def moves_as_it_says(run: Trajectory, within: float) -> None:
    assert np.abs(slope(run.q, run.t) - run.qd[3:-3]).max() < within
    assert np.abs(slope(run.qd, run.t) - run.qdd[3:-3]).max() < within


# Closed forms


def elbows(x: float, y: float) -> list[tuple[float, float]]:
    """Return both positions of links 1 and 0.8 m that hang down at zero."""
    bend = acos((x * x + y * y - 1 - 0.8**2) / (2 * 0.8))
    return [(atan2(x, -y) - atan2(0.8 * sin(q2), 1 + 0.8 * cos(q2)), q2) for q2 in (bend, -bend)]


@pytest.mark.parametrize("elbow", [0, 1])
def test_two_links_keep_the_elbow_that_they_begin_with(two_link: Scene, elbow: int) -> None:
    start = {"q1": 0.8 - elbow, "q2": 0.7 - 1.4 * elbow} if elbow == 0 else {"q1": "1.6", "q2": "-1.8"}
    run = along(
        two_link, "tool = 0.8 + 0.3*sin(t), -0.9 + 0.2*cos(2*t), 0", start={k: str(x) for k, x in start.items()}
    )

    wanted = [elbows(0.8 + 0.3 * sin(t), -0.9 + 0.2 * cos(2 * t))[elbow] for t in run.t]
    assert run.stopped == "end"
    assert np.abs(run.q - wanted).max() < 1e-14
    x, y, u = run["point_tool_x"], run["point_tool_y"], run.qd
    assert -y * u[:, 0] + 0.8 * np.cos(run.q.sum(axis=1)) * u[:, 1] == pytest.approx(0.3 * np.cos(run.t), abs=1e-13)
    assert x * u[:, 0] + 0.8 * np.sin(run.q.sum(axis=1)) * u[:, 1] == pytest.approx(-0.4 * np.sin(2 * run.t), abs=1e-13)


def test_an_array_of_places_says_the_path_that_they_lie_on(two_link: Scene) -> None:
    start = {"q1": "0.8", "q2": "0.7"}
    run = along(two_link, "tool = 0.8 + 0.3*sin(t), -0.9 + 0.2*cos(2*t), 0", start=start)
    places = np.column_stack([run[f"point_tool_{axis}"] for axis in "xyz"])

    other = along(two_link, {"tool": (run.t, places)}, start=start)

    assert np.abs(other.q - run.q).max() < 1e-12


A2, D3, L3, BEND = 0.4318, 0.15005, hypot(0.0203, 0.4318), atan2(0.4318, 0.0203)


def rotation(k: int, angle: float) -> Array:
    c, s, R = cos(angle), sin(angle), np.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    R[[i, j, i, j], [i, j, j, i]] = c, c, -s, s
    return R


def arms(R: Array, p: Array) -> list[list[float]]:
    """Return all eight positions of the PUMA: shoulder left or right, elbow up or down, wrist flipped or not.

    px s1 - py c1 = d3; two links a2 and √(a3² + d4²) in the plane of the arm; R36 = Rz(q4) Ry(-q5) Rz(q6).
    """
    found = []
    for shoulder, elbow, wrist in product((0, 1), (1, -1), (1, -1)):
        lean = asin(D3 / hypot(p[0], p[1]))
        q1 = atan2(p[1], p[0]) + (pi - lean if shoulder else lean)
        x, y = p[0] * cos(q1) + p[1] * sin(q1), p[2]
        angle = elbow * acos((x * x + y * y - A2**2 - L3**2) / (2 * A2 * L3))
        q2 = atan2(y, x) - atan2(L3 * sin(angle), A2 + L3 * cos(angle))
        q3 = angle - BEND
        W = (rotation(2, q1) @ rotation(0, pi / 2) @ rotation(2, q2 + q3) @ rotation(0, -pi / 2)).T @ R
        b = wrist * atan2(hypot(W[0, 2], W[1, 2]), W[2, 2])
        q4, q6 = atan2(wrist * W[1, 2], wrist * W[0, 2]), atan2(wrist * W[2, 1], -wrist * W[2, 0])
        found.append([q1, q2, q3, q4, -b, q6])
    return found


def frame(t: float) -> tuple[Array, Array]:
    """Return what PATH says."""
    R = rotation(2, 0.2 - 0.3 * t) @ rotation(1, 0.5 + 0.2 * t) @ rotation(0, 0.3 * sin(t))
    return R, np.array([0.45 + 0.1 * sin(t), 0.2 + 0.1 * t, 0.2 * cos(t)])


PATH = "tool = 0.45 + 0.1*sin(t), 0.2 + 0.1*t, 0.2*cos(t), rpy(0.3*sin(t), 0.5 + 0.2*t, 0.2 - 0.3*t)"


@pytest.mark.parametrize("branch", range(8))
def test_a_puma_keeps_the_one_of_its_eight_branches_that_it_begins_with(puma: Scene, branch: int) -> None:
    near = arms(*frame(0.0))[branch]
    start = {f"q{k + 1}": str(x + 0.05 * (-1) ** k) for k, x in enumerate(near)}

    run = along(puma, PATH, count=3, start=start)  # a second between samples

    off = [(q - np.array(arms(*frame(t))[branch]) + pi) % (2 * pi) - pi for t, q in zip(run.t, run.q, strict=True)]
    assert run.stopped == "end"
    assert np.abs(off).max() < 1e-13
    assert run["path_error"].max() < 1e-14


def test_velocities_and_accelerations_are_derivatives_and_forces_those_of_the_motion(
    puma: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start = ",".join(f"q{k + 1}={x}" for k, x in enumerate(arms(*frame(0.0))[0]))
    scene, files = str(EXAMPLES / "puma560.toml"), [str(tmp_path / name) for name in ("a.csv", "b.csv")]
    options = ["--until", "2", "--every", "0.01", "--start", start]
    assert main(["inverse", scene, "--path", PATH, *options, "-o", files[0]]) == 0
    assert main(["inverse", scene, "--motion", files[0], "-o", files[1]]) == 0

    one, other = (np.genfromtxt(name, delimiter=",", names=True) for name in files)
    for k in range(1, 7):
        assert np.abs(slope(one[f"q{k}"], one["t"]) - one[f"q{k}_dot"][3:-3]).max() < 1e-9
        assert np.abs(slope(one[f"q{k}_dot"], one["t"]) - one[f"q{k}_ddot"][3:-3]).max() < 1e-8
        assert one[f"tau{k}"] == pytest.approx(other[f"tau{k}"], abs=1e-9)


def quaternions(run: Trajectory) -> str:
    """Return where the tool of a PUMA is along a run, as a table with quaternions."""
    from scipy.spatial.transform import Rotation

    lines = ["t,point_tool_x,point_tool_y,point_tool_z,qw,qx,qy,qz"]
    for t in run.t:
        R, p = frame(t)
        x, y, z, w = 3 * Rotation.from_matrix(R).as_quat()  # any length
        lines.append(",".join(repr(float(one)) for one in (t, *p, w, x, y, z)))
    return "\n".join(lines)


def test_tables_and_quaternions_say_the_same_path(puma: Scene, tmp_path: Path) -> None:
    start = {f"q{k + 1}": str(x) for k, x in enumerate(arms(*frame(0.0))[3])}
    run = along(puma, PATH, count=201, start=start)
    (tmp_path / "path.csv").write_text(quaternions(run))
    (tmp_path / "path.toml").write_text(f'[path]\ntool = "{tmp_path / "path.csv"}"\n')

    table = along(puma, str(tmp_path / "path.toml"), count=201, start=start)
    numbers = np.genfromtxt(tmp_path / "path.csv", delimiter=",", skip_header=1)
    arrays = along(puma, {"tool": (numbers[:, 0], numbers[:, 1:])}, count=201, start=start)

    assert np.abs(table.q - run.q).max() < 1e-12
    assert np.array_equal(arrays.q, table.q)
    assert np.abs(table.qd - run.qd).max() < 1e-4  # of cubic splines


# Singular places


STRAIGHT = "sin(0.3*t) + 0.8*sin(0.3*t + 0.5*sin(t - 1)), -cos(0.3*t) - 0.8*cos(0.3*t + 0.5*sin(t - 1)), 0"


@pytest.mark.parametrize("count", [20, 21, 501])  # beside the singular place, in it, and next to it
def test_a_stretched_arm_goes_through_smoothly_and_is_told(two_link: Scene, count: int) -> None:
    run = along(two_link, f"tool = {STRAIGHT}", count=count, start={"q1": "0", "q2": "-0.5"})

    t = run.t
    assert np.abs(run.q - np.stack([0.3 * t, 0.5 * np.sin(t - 1)], axis=1)).max() < 1e-12
    assert np.abs(run.qd - np.stack([0.3 + 0 * t, 0.5 * np.cos(t - 1)], axis=1)).max() < 1e-10
    assert np.abs(run.qdd - np.stack([0 * t, -0.5 * np.sin(t - 1)], axis=1)).max() < 1e-8
    (note,) = run.notes
    assert note.startswith("path: t = 1 s: through a singular place to another branch, at q1 = 0.3, q2 = ")
    assert "tool cannot move along (-0.2955, 0.9553, 0), and q1, q2 can move without it" in note


def test_a_wrist_that_stretches_is_told_with_the_axes_that_meet(puma: Scene, tmp_path: Path) -> None:
    from scipy.spatial.transform import Rotation

    def motion(t: float) -> list[float]:
        return [0.2 * t, 0.5 + 0.1 * t, -0.5 + 0.2 * t, 0.3 + 0.1 * t, 0.4 * (t - 1), 0.1 + 0.2 * t]

    lines = ["t,x,y,z,qw,qx,qy,qz"]
    for t in np.linspace(0, 2, 401).tolist():
        q1, q2, q3, q4, q5, q6 = motion(t)
        X, Y = (A2 * f(q2) + L3 * f(q2 + q3 + BEND) for f in (cos, sin))
        R = rotation(2, q1) @ rotation(0, pi / 2) @ rotation(2, q2 + q3) @ rotation(0, -pi / 2)
        R = R @ rotation(2, q4) @ rotation(1, -q5) @ rotation(2, q6)
        x, y, z, w = Rotation.from_matrix(R).as_quat()
        p = (X * cos(q1) + D3 * sin(q1), X * sin(q1) - D3 * cos(q1), Y)
        lines.append(",".join(repr(float(one)) for one in (t, *p, w, x, y, z)))
    (tmp_path / "path.csv").write_text("\n".join(lines))
    start = {f"q{k + 1}": str(x) for k, x in enumerate(motion(0.0))}

    run = along(puma, f"tool={tmp_path / 'path.csv'}", start=start)  # a sample is there

    assert np.abs(run.q - [motion(t) for t in run.t]).max() < 1e-9
    assert np.abs(run.qd[1:-1] - [0.2, 0.1, 0.2, 0.1, 0.4, 0.2]).max() < 1e-6  # the ends of a spline are less exact
    assert "t = 1 s: through a singular place" in run.notes[0]
    assert "tool turns about (0.785, 0.5565, 0.2722) only as it moves along" in run.notes[0]
    assert run.notes[0].endswith("q4, q6 can move without it")


def test_a_path_may_lie_next_to_singular_places_all_along(two_link: Scene) -> None:
    r = abs(1 + 0.8 * np.exp(0.01j))
    run = along(two_link, f"tool = {r!r}*sin(t), -{r!r}*cos(t), 0".replace("np.float64", ""), start={"q2": "0.01"})

    assert run.stopped == "end"
    assert np.abs(run["q2"] - 0.01).max() < 1e-11
    assert np.abs(run.qd - [1.0, 0.0]).max() < 1e-8
    assert np.abs(run.qdd).max() < 1e-5
    assert "near a singular place" in run.notes[0]


def test_a_path_out_of_reach_ends_where_it_leaves_it(two_link: Scene) -> None:
    run = along(two_link, "tool = 1 + 0.5*t, 0, 0", count=18, start={"q1": "0.9", "q2": "1"})  # 1.8 m at 1.6 s

    assert len(run.t) == 14
    assert (
        "path: t = 1.6 s: it goes out of reach there: at t = 1.64706 s tool misses (1.82353, 0, 0) by 0.0235294 m"
        in (run.stopped)
    )


def test_a_path_that_ends_stretched_is_told_to_be_singular(two_link: Scene) -> None:
    run = along(two_link, "tool = 1 + 0.5*t, 0, 0", until=1.6, count=17, start={"q1": "0.9", "q2": "1"})

    assert len(run.t) == 16
    assert "t = 1.6 s: singular: the coordinates cannot go on smoothly, at q1 = 1.5" in run.stopped
    assert "or leave a component free (_)" in run.stopped


@pytest.mark.parametrize(
    ("path", "start", "told"),
    [
        ("tool = 3, 4, 0", {}, r"t = 0 s: out of reach: tool misses \(3, 4, 0\) by 3\.2 m"),
        ("tool = 1, 1, 0.5", {}, r"out of reach: tool misses \(1, 1, 0\.5\) by 0\.5 m"),
        ("tool = 0, -1.8, 0", {}, r"begins at a singular place, at q1 = .*tool cannot move along y"),
        ("tool = 1e300, 0, 0", {}, "out of reach"),
        ("link1 = t, 0, 0", {}, r"t = 0 s: link1 cannot move there as the path does"),
        ("tool = 1, 1", {}, r'"1, 1" has 2 parts; a path is x, y, z'),
        ("tol = 1, 1, 0", {}, "tol is no point and no body; did you mean tool"),
        ("tool = 1, w, 0", {}, "w, which is not known here"),
        ("tool = 1, 1, 0, turned(1)", {}, r"says no turning; .*rpy"),
        ("tool = 1, 1, 0, rpy(1, 2)", {}, r"rpy takes \(roll, pitch, yaw\)"),
        ("tool = 1, 1, 0, pointing(w, 1, 0, 0)", {}, "w is no axis; write pointing"),
        ("tool = 1, 1, 0, pointing(x, t, 0, 0)", {}, "has no finite value or derivative at t = 0 s"),
        ("tool = 1, 1, 0, pointing()", {}, r"^path: tool: \"pointing\(\)\": pointing takes \(axis, a, b, c\)$"),
        ("tool = 1, 1, 0, rpy(0, 0, 0", {}, r"lacks a bracket; write rpy\(roll, pitch, yaw\)"),
        ("tool = 1, 1, 0, rpy", {}, r"lacks a bracket; write rpy\(roll, pitch, yaw\)"),
        ("tool = (1, 1, 0)", {}, "has 1 part; a path is x, y, z"),
        ("tool = sqrt(t), 1, 0", {}, "has no finite value or derivative at t = 0 s"),
        ("tool = _, _, _", {}, "asks for nothing"),
        ("tool = nowhere.csv", {}, "nowhere.csv"),
        ("nowhere.csv", {}, r"write POINT=nowhere|nowhere.csv"),
        ("tool = 1, 1, 0", {"q9": "1"}, "start: q9 is not known"),
    ],
)
def test_what_is_no_path_is_told(two_link: Scene, path: str, start: dict[str, str], told: str) -> None:
    with pytest.raises(SimulateError, match=told):
        along(two_link, path, start=start)


@pytest.mark.parametrize("course", [3.0, ([0.0, 1.0], [[1, 2], [1, 2, 3]]), ([0.0, 1.0], "ab"), None])
def test_what_is_no_path_in_python_is_told_in_a_line_with_what_is_one(two_link: Scene, course: Any) -> None:
    with pytest.raises(SimulateError, match=r"^path: tool: \w+ is no path; give text, .* of shape \(N, 3\)") as told:
        along(two_link, {"tool": course})
    assert len(told.value.faults) == 1


def test_a_path_that_asks_for_what_is_so_anyway_lets_all_rest(two_link: Scene) -> None:
    run = along(two_link, "tool = _, _, 0", start={"q1": "0.3"})

    assert run.notes == ("no law is given for q1, q2, which tool does not depend on: at rest",)
    assert np.abs(run.q - [0.3, 0.0]).max() == np.abs(run.qd).max() == 0.0


def test_a_wheel_that_lies_flat_is_refused() -> None:
    with pytest.raises(SimulateError, match=r"path: t = 0 s: |start: "):
        along(read(EXAMPLES / "rolling_disc.toml"), "disc = t, t, 0, pointing(x, t, 1, 0)")


# Redundant arms and closed mechanisms


def test_freedoms_that_are_left_move_least_or_by_a_law(two_link: Scene) -> None:
    least = along(two_link, "tool = 1 + 0.2*t, _, _", count=201, start={"q1": "0.9", "q2": "1"})
    given = along(two_link, "tool = 1 + 0.2*t, _, _", count=21, start={"q1": "0.9"}, motion="q2 = 1 - 0.3*t")

    J = np.stack([np.cos(least.q[:, 0]) + 0.8 * np.cos(least.q.sum(axis=1)), 0.8 * np.cos(least.q.sum(axis=1))], axis=1)
    assert np.abs(least.qd - 0.2 * J / np.einsum("ni,ni->n", J, J)[:, None]).max() < 1e-12
    moves_as_it_says(least, 1e-8)
    assert "1 freedom is left: the velocities of q1, q2 are those with the least sum of squares" in least.notes[0]
    assert given["q2"] == pytest.approx(1 - 0.3 * given.t, abs=1e-15)
    assert given["point_tool_x"] == pytest.approx(1 + 0.2 * given.t, abs=1e-14)
    assert not given.notes


@pytest.mark.slow
@pytest.mark.long
def test_seven_axes_follow_a_frame(tmp_path: Path) -> None:
    scene = read(EXAMPLES / "arm7.toml")
    start = {f"q{k + 1}": str(x) for k, x in enumerate((0.1, 0.5, 0.2, 1, 0.3, 0.8, 0.1))}
    path = "tool = 0.05*cos(2*t), -0.04 + 0.05*sin(2*t), 0.9, {}"

    frame = along(scene, path.format("rpy(0, 0.3, 0.6 + 0.1*t)"), count=201, start=start)
    axis = along(scene, path.format("pointing(z, 0.2, 0.2 + 0.1*t, 1)"), until=1, count=101, start=start)
    beside = along(scene, path.format("rpy(0, 0.3, 0.6 + 0.1*t)"), start=start, motion=f"q1 = {frame.q[0, 0]} + 0.05*t")

    moves_as_it_says(frame, 1e-6)
    moves_as_it_says(axis, 1e-6)
    assert [run.stopped for run in (frame, axis, beside)] == ["end"] * 3
    assert max(float(run["path_error"].max()) for run in (frame, axis, beside)) < 1e-13


def hinge(name: str, parent: str, child: str, x: float, q: str, start: float, drive: bool) -> str:
    return f"""
[bodies.{child}]
mass = 0.3
com = [0.1, 0, 0]
inertia = [0.001, 0.001, 0.001]
inertia_about = "com"
[joints.{name}]
type = "revolute"
parent = "{parent}"
child = "{child}"
origin = [{x}, 0, 0]
coordinate = "{q}"
drive = {str(drive).lower()}
start = {start}
"""


FIVE_BAR = (
    'name = "five_bar"\ngravity = [0, -9.81, 0]\n'
    + hinge("A", "ground", "a", 0, "q1", 1.9, True)
    + hinge("B", "a", "b", 0.2, "p1", -0.9, False)
    + hinge("C", "ground", "c", 0.2, "q2", 1.2, True)
    + hinge("D", "c", "d", 0.2, "p2", 0.9, False)
    + '[[loop]]\nname = "E"\ntype = "revolute"\nparent = "b"\nchild = "d"\norigin = [0.3, 0, 0]\ntip = [-0.3, 0, 0]\n'
    + '[points.tool]\nbody = "b"\nat = [0.3, 0, 0]\n'
)


def test_a_five_bar_follows_a_circle() -> None:
    run = along(read_text(FIVE_BAR, "toml"), "tool = 0.1 + 0.05*cos(2*t), 0.38 + 0.05*sin(2*t), 0", count=101)

    def legs(t: float) -> list[float]:
        x, y = 0.1 + 0.05 * cos(2 * t), 0.38 + 0.05 * sin(2 * t)
        found = []
        for base, side in ((0.0, 1), (0.2, -1)):
            r = hypot(x - base, y)
            found.append(atan2(y, x - base) + side * acos((r * r + 0.2**2 - 0.3**2) / (2 * 0.2 * r)))
        return found

    assert np.abs(np.stack([run["q1"], run["q2"]], axis=1) - [legs(t) for t in run.t]).max() < 1e-13
    assert run["path_error"].max() < 1e-15
    moves_as_it_says(run, 1e-6)


BASE, ARM, ROD, PLATFORM, WIDE = 0.2, 0.2, 0.5, 0.05, 0.04


def delta() -> str:
    """Return a delta robot: three arms, six rods, and a platform that flies."""
    text = 'name = "delta"\ngravity = [0, 0, -9.81]\n[bodies.platform]\nmass = 0.4\ninertia = [0.001, 0.001, 0.002]\n'
    text += 'inertia_about = "com"\n'
    for k in range(3):
        c, s, a = cos(2 * pi * k / 3), sin(2 * pi * k / 3), 2 * pi * k / 3
        text += f"""
[bodies.arm{k}]
mass = 0.2
com = [0.1, 0, 0]
inertia = [0.0001, 0.001, 0.001]
inertia_about = "com"
[joints.shoulder{k}]
type = "revolute"
parent = "ground"
child = "arm{k}"
axis = [0, 1, 0]
origin = {{ xyz = [{BASE * c!r}, {BASE * s!r}, 0], rpy = [0, 0, {a!r}] }}
coordinate = "q{k}"
start = 0.3
"""
    text += '[joints.flight]\ntype = "free"\nparent = "ground"\nchild = "platform"\ndrive = false\n'
    text += 'coordinates = ["x", "y", "z", "e0", "e1", "e2", "e3"]\nstart = [0, 0, -0.45, 1, 0, 0, 0]\n'
    for k, side in product(range(3), (1, -1)):
        c, s = cos(2 * pi * k / 3), sin(2 * pi * k / 3)
        x, y = PLATFORM * c - side * WIDE * s, PLATFORM * s + side * WIDE * c
        text += f'[[loop]]\nname = "rod{k}{"ab"[side > 0]}"\ntype = "rod"\nparent = "arm{k}"\nchild = "platform"\n'
        text += f"origin = [{ARM}, {side * WIDE}, 0]\ntip = [{-x!r}, {-y!r}, 0]\nlength = {ROD}\n"
    return text + '[points.tool]\nbody = "platform"\n'


def shoulder(k: int, p: Array) -> float:
    """Return the angle of an arm: |elbow - end of the rod| = ROD is E cos q + F sin q + G = 0, bent outwards."""
    c, s = cos(2 * pi * k / 3), sin(2 * pi * k / 3)
    x, y, z = p[0] * c + p[1] * s + PLATFORM - BASE, -p[0] * s + p[1] * c, p[2]
    E, F, G = -2 * ARM * x, 2 * ARM * z, ARM**2 + x * x + y * y + z * z - ROD**2
    return atan2(F, E) + acos(-G / hypot(E, F))


@pytest.mark.long
def test_a_delta_robot_follows_a_helix() -> None:
    run = along(read_text(delta(), "toml"), "tool = 0.08*cos(3*t), 0.08*sin(3*t), -0.45 + 0.03*t", count=11)

    places = np.stack([0.08 * np.cos(3 * run.t), 0.08 * np.sin(3 * run.t), -0.45 + 0.03 * run.t], axis=1)
    wanted = [[shoulder(k, p) for k in range(3)] for p in places]
    assert run.stopped == "end"
    assert np.abs(np.stack([run[f"q{k}"] for k in range(3)], axis=1) - wanted).max() < 1e-12
