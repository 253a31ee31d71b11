"""All branches of an arm at a pose: axes against poses of the scene, closed forms by hand and by EAIK, what is told."""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Callable
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import pytest
from test_inverse_paths import PATH, arms, frame

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import Scene, read_text
from symdyn.simulation import Branches, arm_branches, arm_of

Array = np.ndarray[Any, np.dtype[np.float64]]

PUMA = symdyn.example("puma560")
SEVEN = symdyn.example("arm7")


def by_dh(name: str, *rows: tuple[float, float, str], more: str = "") -> Scene:
    """Return an arm of links d, a, α."""
    links = "".join(
        f'[[dh.links]]\nd = {d}\na = {a}\nalpha = "{alpha}"\nmass = 1\ncom = [0, 0, 0]\n'
        'inertia = [1, 1, 1]\ninertia_about = "com"\n'
        for d, a, alpha in rows
    )
    last = f'[points.tool]\nbody = "link{len(rows)}"\n'
    return read_text(f'name = "{name}"\n[dh]\nconvention = "standard"\n{links}{last}{more}')


UR = (
    *((0.089159, 0, "pi/2"), (0, -0.425, "0"), (0, -0.39225, "0")),
    *((0.10915, 0, "pi/2"), (0.09465, 0, "-pi/2"), (0.0823, 0, "0")),
)
ODD = (
    *((0.1, 0.05, "pi/2"), (0.02, -0.4, "pi/3"), (0.1, 0.3, "pi/4")),
    *((0.3, 0.1, "pi/2"), (0.1, 0.05, "-pi/2"), (0.08, 0.02, "pi/3")),
)
SHOULDER = (
    *((0, 0, "pi/2"), (0, 0, "-pi/2"), (0.3, 0, "pi/2")),
    *((0, 0.4, "pi/3"), (0.2, 0.3, "pi/2"), (0.1, 0.1, "0")),
)
LIMITED = {"joint1": (-0.5, 1.0), "joint6": (1.0, 2 * pi)}


def turned(arm: Any, q: Array) -> Array:
    """Return the pose by a product of turns about the arm's axes."""
    T = np.eye(4)
    for h, c, x in zip(arm.h, arm.c, q, strict=True):
        W, turn = np.cross(np.eye(3), h), np.eye(4)
        turn[:3, :3] += np.sin(x) * W + (1 - np.cos(x)) * W @ W
        turn[:3, 3] = c - turn[:3, :3] @ c
        T = T @ turn
    return (T @ np.vstack([np.column_stack([arm.R, arm.p]), [0, 0, 0, 1]]))[:3]


@pytest.mark.parametrize("scene", [PUMA, by_dh("ur", *UR), by_dh("odd", *ODD)], ids=lambda scene: scene.name)
def test_turns_about_the_axes_of_an_arm_are_its_pose(scene: Scene) -> None:
    arm, pose = arm_of(scene, "tool"), symdyn.lambdify(scene, "pose:tool")

    for q in (np.zeros(6), np.full(6, pi / 2), *np.random.default_rng(5).uniform(-3, 3, (4, 6))):
        assert np.abs(turned(arm, q) - pose(q)).max() < 1e-14
        assert np.abs(turned(arm.placed(), q) - pose(q)).max() < 1e-14


def test_a_joint_that_is_held_is_one_that_is_not_there() -> None:
    folded, told = arm_of(SEVEN, "tool").held(2, 0.3), arm_of(SEVEN, "tool", {"q3": 0.3})

    assert folded.names == told.names == ("q1", "q2", "q4", "q5", "q6", "q7")
    assert all(np.abs(getattr(folded, part) - getattr(told, part)).max() < 1e-14 for part in ("h", "R", "p"))
    q = np.array([0.1, -0.2, 0.4, 0.5, 0.6, 0.7])
    assert np.abs(turned(folded, q) - turned(told, q)).max() < 1e-14


@pytest.mark.parametrize(
    ("scene", "axes"),
    [
        (PUMA, ["q2, q3 are parallel", "q1, q2 meet in a point", "q4, q5, q6 meet in a point",
                "spherical wrist: a closed form"]),
        (by_dh("ur", *UR), ["q2, q3, q4 are parallel", "q1, q2 meet in a point", "q4, q5 meet in a point",
                            "q5, q6 meet in a point", "three parallel axes: a closed form"]),
        (by_dh("shoulder", *SHOULDER), ["q1, q2, q3 meet in a point", "q3, q4 meet in a point",
                                        "spherical shoulder: a closed form"]),
        (SEVEN, ["q1, q2, q3 meet in a point", "q3, q4, q5 meet in a point", "q5, q6, q7 meet in a point",
                 "7 joints: a closed form where one of q1, q2, q3, q4, q5, q6, q7 is held"]),
        (by_dh("odd", *ODD), ["6 joints: no closed form is known; three axes in a row would have to meet at an end, or "
                              "be parallel"]),
        (by_dh("five", *UR[:5]), ["q2, q3, q4 are parallel", "q1, q2 meet in a point",
                                  "q4, q5 meet in a point", "5 joints: a closed form of the poses that they reach"]),
    ],
    ids=lambda one: one.name if isinstance(one, Scene) else "",
)  # fmt: skip
def test_axes_that_meet_and_are_parallel_name_the_class(scene: Scene, axes: list[str]) -> None:
    assert list(arm_of(scene, "tool").words) == axes


POSE = "tool=0.45, 0.2, 0.1, rpy(0, 0.5, 0.2)"


@pytest.mark.parametrize(
    ("scene", "asked", "told"),
    [
        (by_dh("odd", *ODD), {}, "odd: tool: 6 joints: no closed form is known"),
        (SEVEN, {}, r"arm7: tool: 7 joints: .* is held; give laws of 1 of them, such as motion=\{\"q1\": 0.3\}"),
        (symdyn.example("scara"), {}, r"stroke is prismatic, .*; hold it, as in motion=\{\"q3\": 0.3\}"),
        (symdyn.example("four_bar"), {"path": "coupler=0, 0, 0, rpy(0, 0, 0)"}, "four_bar: its loops and rows have no"),
        (symdyn.example("free_body"), {"path": "wingnut=0, 0, 0, rpy(0, 0, 0)"}, "of 7 coordinates"),
        (PUMA, {"path": "tool=0.4, 0.2, 0.1"}, "path: tool: a closed form takes a whole pose; give x, y, z and rpy"),
        (PUMA, {"path": "tool=0.4, 0.2, 0.1, pointing(z, 0, 0, 1)"}, "a closed form takes a whole pose"),
        (PUMA, {"path": [POSE, "link3=0, 0, 0"]}, "a branch is one of a frame with a path; 2 have one"),
        (PUMA, {"motion": ["q1=0", "q2=0", "q3=0", "q4=0", "q5=0", "q6=0"]}, "nothing that is not held moves tool"),
        (by_dh("shoulder", *SHOULDER), {}, r'need EAIK: pip install "symdyn\[ik\]"'),
    ],
    ids=["odd", "seven", "slides", "loop", "floats", "place", "pointing", "two", "held", "missing"],
)
def test_what_has_no_closed_form_is_told_in_words(
    scene: Scene, asked: dict[str, Any], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "eaik", None)
    monkeypatch.setitem(sys.modules, "eaik.IK_HP", None)

    with pytest.raises(SimulateError, match=told):
        symdyn.inverse_kinematics(scene, **{"path": POSE, **asked})


# The PUMA, by its output


def text(R: Array, p: Array) -> dict[str, tuple[Array, Array]]:
    """Return a path that rests at a pose."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(R).as_quat()
    return {"tool": (np.array([0.0, 1.0]), np.array([[*p, w, x, y, z]] * 2))}


def turns(x: Array) -> Array:
    """Return angles within half a turn."""
    return x - 2 * pi * np.round(x / (2 * pi))


def apart(found: Branches) -> float:
    """Return how far the two branches that are most alike are apart, rad."""
    far = np.abs(turns(found.q[:, None] - found.q[None])).max(axis=2)
    return float(far[~np.eye(len(far), dtype=bool)].min())


@pytest.mark.runs("cc")
def test_the_puma_has_eight_branches_and_the_first_is_next_to_the_start() -> None:
    R, p = frame(0.3)
    start = {f"q{k + 1}": float(x) for k, x in enumerate(np.array(arms(R, p))[5] + 0.01)}
    found = symdyn.inverse_kinematics(PUMA, text(R, p), start=start)

    assert found.q.shape == (8, 6)
    assert all(np.abs(turns(found.q - q)).max(axis=1).min() < 1e-10 for q in np.array(arms(R, p)))
    assert found.error.max() < 1e-10
    assert apart(found) > 0.01
    assert np.abs(found.q[0] - np.array(list(start.values())) + 0.01).max() < 1e-10
    far = np.linalg.norm(found.q - np.array(list(start.values())), axis=1)
    assert all(one <= other + 1e-9 for one, other in pairwise(far))
    assert found.within.all()
    assert not found.singular.any()
    pose = symdyn.lambdify(PUMA, "pose:tool")
    assert all(np.abs(pose(q) - np.column_stack([R, p])).max() < 1e-10 for q in found.q)
    assert len(pickle.loads(pickle.dumps(found)).at(np.column_stack([R, p])).q) == 8


@pytest.mark.runs("cc")
def test_branches_within_limits_come_first_by_whole_turns_where_these_lead_there() -> None:
    source = symdyn.scene.write_text(PUMA, "toml").text
    for joint, (low, high) in LIMITED.items():
        source = source.replace(
            f"[joints.{joint}]\n", f"[joints.{joint}]\nlimits = {{lower = {low}, upper = {high}}}\n"
        )
    arm = read_text(source)
    R, p = frame(0.3)
    free, found = (symdyn.inverse_kinematics(one, text(R, p)) for one in (PUMA, arm))

    def reaches(q: Array) -> bool:
        turns = q[5] + 2 * pi * np.arange(-2, 3)
        return -0.5 <= q[0] <= 1.0 and bool(((turns >= 1.0) & (turns <= 2 * pi)).any())

    assert 0 < found.within.sum() == sum(map(reaches, free.q)) < 8
    assert found.within.tolist() == sorted(found.within, reverse=True)
    inside = found.q[found.within]
    assert (inside[:, 5] >= 1.0).all()
    assert (inside[:, 5] <= 2 * pi).all()
    assert found.error.max() < 1e-10


@pytest.mark.runs("cc")
def test_a_straight_wrist_is_told_and_stands_next_to_the_start() -> None:
    q = np.array([0.3, 0.2, 0.4, 0.5, 0.0, 0.6])
    T = symdyn.lambdify(PUMA, "pose:tool")(q)
    found = symdyn.inverse_kinematics(PUMA, text(T[:, :3], T[:, 3]), start="q1=0.3,q2=0.2,q3=0.4,q4=0.7,q6=0.6")

    assert found.singular.tolist() == [True] + [False] * 6
    assert np.abs(found.q[0] - [0.3, 0.2, 0.4, 0.6, 0.0, 0.5]).max() < 1e-6  # q4 + q6 = 1.1, halfway from 0.7 and 0.6
    assert "branch 1 is singular: q4, q6 can move without tool" in found.notes
    assert found.error.max() < 1e-10


@pytest.mark.runs("cc")
def test_a_solution_of_least_squares_is_mended_or_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    R, p = frame(0.3)
    off = np.array(arms(R, p)) + np.eye(6)[5] * 0.3
    monkeypatch.setattr(arm_branches, "_is_derived", lambda w, request: False)
    monkeypatch.setattr(arm_branches, "_eaik", lambda arm: lambda R, p: (off, np.ones(8, dtype=bool)))
    found = symdyn.inverse_kinematics(PUMA, text(R, p))
    assert found.error.max() < 1e-10

    # its wrist gets as far as √(d3² + (a2 + √(a3² + d4²))²) = 0.87701 m
    with pytest.raises(
        SimulateError, match=r"tool: the pose is out of reach: at q1 = .* misses \(2, 0, 0\) by 1.12299 m"
    ):
        found.at(np.column_stack([np.eye(3), [2.0, 0, 0]]))
    with pytest.raises(SimulateError, match=r"shapes \(3, 4\), \(6,\) are none; give \[R p\], R a rotation"):
        found.at(np.column_stack([2 * np.eye(3), [2.0, 0, 0]]))


@pytest.mark.runs("cc")
def test_a_path_begins_on_the_branch_that_is_asked_for() -> None:
    t = np.array([0.0, 0.5])
    first = symdyn.inverse_kinematics(PUMA, PATH)

    for k in (1, 5, 8):
        run = symdyn.inverse(PUMA, path=PATH, times=t, branch=k)
        assert np.abs(run.q[0] - first.q[k - 1]).max() < 1e-9
        assert run["path_error"].max() < 1e-10
    with pytest.raises(SimulateError, match="branch 9: tool has branches 1 to 8 there"):
        symdyn.inverse(PUMA, path=PATH, times=t, branch=9)


@pytest.mark.runs("cc")
def test_the_shell_lists_branches_and_begins_on_one(
    capsys: pytest.CaptureFixture[str], puma_file: Callable[..., list[str]]
) -> None:
    assert main(puma_file("--branch", "all", "--json")) == 0
    told = json.loads(capsys.readouterr().out)["result"]
    assert told["names"] == [f"q{k}" for k in range(1, 7)]
    assert len(told["q"]) == 8
    assert np.max(told["error"]) < 1e-10

    assert main(puma_file("--branch", "all")) == 0
    assert "spherical wrist: a closed form" in capsys.readouterr().out
    assert main(puma_file("--branch", "3", "--until", "0.1", "--every", "0.1")) == 0
    row = capsys.readouterr().out.splitlines()[1].split(",")
    assert [float(x) for x in row[1:7]] == pytest.approx(told["q"][2], abs=1e-9)
    with pytest.raises(SystemExit):
        main(puma_file("--branch", "0"))
    assert "0 is no branch; give 1 for the one next to the start, 2, ..., or all" in capsys.readouterr().err


@pytest.fixture
def puma_file() -> Callable[..., list[str]]:
    from pathlib import Path

    file = Path(__file__).parent.parent / "examples" / "puma560.toml"
    return lambda *words: ["inverse", str(file), "--path", PATH, *words]


def test_info_names_the_class_of_an_arm(
    capsys: pytest.CaptureFixture[str], puma_file: Callable[..., list[str]]
) -> None:
    assert main(["info", puma_file()[1], "--json"]) == 0
    (arm,) = json.loads(capsys.readouterr().out)["result"]["arms"]
    assert arm["point"] == "tool"
    assert arm["axes"][-1] == "spherical wrist: a closed form"


# EAIK


@pytest.mark.targets
@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("scene", "most", "held"),
    [(PUMA, 8, ""), (by_dh("ur", *UR), 8, ""), (by_dh("shoulder", *SHOULDER), 8, ""), (SEVEN, 8, "q3=0.3"),
     (by_dh("five", *UR[:5]), 2, ""), (symdyn.example("scara"), 2, "q3=0.3")],
    ids=lambda one: getattr(one, "name", ""),
)  # fmt: skip
def test_every_branch_of_eaik_has_the_pose(scene: Scene, most: int, held: str) -> None:
    pytest.importorskip("eaik.IK_HP")
    places = [scene.coordinates.index(name) for name in arm_of(scene, "tool", {"q3": 0.3} if held else {}).names]
    pose, rng = symdyn.lambdify(scene, "pose:tool"), np.random.default_rng(7)
    first, counts = None, []
    for natural in (0.3, pi / 2, 0.0, None, *[None] * 60):
        q = np.full(len(scene.coordinates), 0.3)
        q[places] = rng.uniform(-3, 3, len(places)) if natural is None else natural
        T = pose(q)
        if first is None:
            start = dict(zip(scene.coordinates, q.tolist(), strict=True))
            first = symdyn.inverse_kinematics(scene, text(T[:, :3], T[:, 3]), held or (), start=start)
        found = first.at(T, q)
        assert found.error.max() < 1e-10
        assert max(np.abs(pose(one) - T).max() for one in found.q) < 1e-10
        assert np.abs(found.q[0] - q).max() < 1e-6
        assert len(found.q) == 1 or apart(found) > 1e-6
        counts.append(len(found.q) if natural is None else 0)
    assert max(counts) == most


@pytest.mark.targets
@pytest.mark.runs("cc")
@pytest.mark.parametrize("scene", [PUMA, by_dh("ur", *UR)], ids=lambda scene: scene.name)
def test_eaik_and_the_output_have_the_same_branches(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("eaik.IK_HP")
    pose = symdyn.lambdify(scene, "pose:tool")
    poses = pose(np.random.default_rng(3).uniform(-3, 3, (50, 6)))
    ours = symdyn.inverse_kinematics(scene, text(poses[0, :, :3], poses[0, :, 3]))
    monkeypatch.setattr(arm_branches, "_is_derived", lambda w, request: False)
    theirs = symdyn.inverse_kinematics(scene, text(poses[0, :, :3], poses[0, :, 3]))
    for T in poses:
        one, other = ours.at(T).q, theirs.at(T).q
        assert len(one) == len(other)
        assert all(np.abs(turns(other - q)).max(axis=1).min() < 1e-9 for q in one)
