"""A locked joint is a fixed one, for every derivation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES

from symdyn.dynamics import derive
from symdyn.errors import SceneError
from symdyn.graph import Graph
from symdyn.program import lower
from symdyn.runtime import lambdify
from symdyn.scene import Quantity, body, fixed, helical, lock, parse, prismatic, read_text, revolute, scene
from symdyn.verdict import Verdict
from symdyn.verify import certify

LINK = {"mass": 2, "com": ["1/3", 0, "1/10"], "inertia": [1, 2, 2], "about": "com"}


def arm(**second: object):
    """Three links; the second joint as told."""
    return scene(
        "arm",
        parameters={"p": None},
        bodies=[body(f"b{i}", **LINK) for i in range(3)],
        joints=[
            revolute("j0", "ground", "b0", axis=[0, 1, 0]),
            prismatic("j1", "b0", "b1", axis=[0, 0, -2], origin=[1, 0, 0], **second),
            revolute("j2", "b1", "b2", axis=[1, 0, 0], origin=[0, 0, 1], force="-3*q3 - 2*q3_dot"),
        ],
    )


def test_a_locked_joint_has_no_coordinate_and_the_others_keep_their_names():
    locked = arm(locked=True)

    assert locked.coordinates == ("q1", "q3")
    assert [joint.drive for joint in locked.moving] == ["tau1", "tau3"]
    assert [joint.locked for joint in locked.joints] == [False, True, False]
    assert [joint.type for joint in locked.joints] == ["revolute", "fixed", "revolute"]


def test_a_locked_joint_stands_where_it_is_told_along_its_axis():
    by_hand = scene(
        "arm",
        parameters={"p": None},
        bodies=[body(f"b{i}", **LINK) for i in range(3)],
        joints=[
            revolute("j0", "ground", "b0", axis=[0, 1, 0]),
            fixed("j1", "b0", "b1", origin=[["Tx", 1], ["Tz", "-p"]]),
            revolute(
                "j2",
                "b1",
                "b2",
                axis=[1, 0, 0],
                origin=[0, 0, 1],
                coordinate="q3",
                drive="tau3",
                force="-3*q3 - 2*q3_dot",
            ),
        ],
    )

    assert arm(locked=True, position="p") == by_hand


@pytest.mark.usefixtures("numpy_alone")
def test_locking_costs_less_and_both_derivations_see_it():
    moving, locked = arm(), arm(locked=True, position="1/2")
    counts = [lower(derive(one, ("inverse_dynamics",)))["inverse_dynamics"].counts for one in (moving, locked)]

    assert counts[1].cost < counts[0].cost
    certificate = certify(locked, ("inverse_dynamics", "mass_matrix"))
    assert certificate.passed
    assert [f.verdict for f in certificate.findings if "lagrange" in f.claim] == [Verdict.PROVED] * 2


def test_a_joint_that_follows_a_locked_one_is_locked_and_formulas_see_its_place():
    gripper = scene(
        "gripper",
        bodies=[body(f"b{i}", **LINK) for i in range(3)],
        joints=[
            revolute("lead", "ground", "b0", locked=True, position="pi/6"),
            revolute("follow", "b0", "b1", mimic={"joint": "lead", "ratio": -2, "offset": "pi/2"}),
            revolute("free", "b1", "b2", force="-3*q1*q2 - 2*q1_dot"),
        ],
    )

    assert gripper.coordinates == ("q2",)
    ((step, turn),) = gripper.joints[1].origin.steps
    graph = Graph()
    assert (step, graph.sin(turn.express(graph))) == ("Rz", graph.constant(1) / 2)
    assert gripper.joints[2].force == parse("-3*(pi/6)*q2")


def test_joints_of_a_scene_can_be_locked_later():
    assert lock(arm(), {"j1": parse("p")}) == arm(locked=True, position="p")
    assert lock(arm(), {"j1": "pi/2"}) == lock(arm(), {"j1": parse("pi/2")})


@pytest.mark.parametrize(("position", "message"), [("pi/", "breaks off"), ([1], "give a number or a formula")])
def test_a_position_that_is_no_formula_is_named_with_its_joint(position, message):
    with pytest.raises(SceneError, match=f"joints.j1: position .*{message}"):
        lock(arm(), {"j1": position})


def test_a_toml_file_and_a_dh_table_may_lock_joints():
    text = Path(EXAMPLES / "puma560.toml").read_text()
    assert "[[dh.links]]" in text
    first = text.index("[[dh.links]]") + len("[[dh.links]]")
    locked = read_text(f'{text[:first]}\nlocked = true\nposition = "30 deg"{text[first:]}')

    assert len(locked.coordinates) == len(read_text(text).coordinates) - 1
    assert locked.joints[0].locked


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ({"position": 1}, "joints.j1: position is where a locked joint stands; write locked = true"),
        ({"locked": 1}, "joints.j1: locked = 1 is neither true nor false"),
        ({"locked": True, "position": "q1"}, "joints.j1: position uses q1, which is no parameter"),
        ({"locked": True, "position": "1/0"}, "joints.j1: position .*divides by zero"),
        (
            {"locked": True, "mimic": {"joint": "j0"}},
            "joints.j1: locked = true has no meaning for a joint that follows another one",
        ),
    ],
)
def test_a_lock_that_makes_no_sense_is_refused(second, message):
    with pytest.raises(SceneError, match=message):
        arm(**second)


@pytest.mark.long
@pytest.mark.parametrize(("kind", "keys"), [(revolute, {}), (prismatic, {}), (helical, {"pitch": "1/5"})])
@pytest.mark.parametrize("axis", [[2, -1, 2], [1, 1, 0]])
def test_an_oblique_axis_is_locked_where_it_is_told(kind, keys, axis):
    free = scene(
        "tilted",
        bodies=[body(f"b{i}", **LINK) for i in range(3)],
        joints=[
            revolute("j0", "ground", "b0", axis=[0, 1, 0]),
            kind("j1", "b0", "b1", axis=axis, origin=[1, 0, 0], **keys),
            revolute("j2", "b1", "b2", axis=[1, 0, 0], origin=[0, 0, 1]),
        ],
    )
    locked = lock(free, {"j1": parse("7/10")})

    wanted = numbers(free, [0.3, 0.7, -0.4], [1.1, 0.0, 0.6], [0.2, 0.0, -0.9])
    np.testing.assert_allclose(numbers(locked, [0.3, -0.4], [1.1, 0.6], [0.2, -0.9]), np.delete(wanted, 1), rtol=1e-12)


def test_a_follower_with_an_offset_is_locked_with_its_leader():
    free = scene(
        "followed",
        bodies=[body(f"b{i}", **LINK) for i in range(3)],
        joints=[
            revolute("j0", "ground", "b0", axis=[0, 1, 0]),
            revolute("j1", "b0", "b1", origin=[1, 0, 0]),
            revolute("j2", "b1", "b2", axis=[1, 2, 2], origin=[0, 0, 1], mimic=FOLLOWS),
        ],
    )
    locked = lock(free, {"j1": parse("7/10")})

    wanted = numbers(free, [0.3, 0.7], [1.1, 0.0], [0.2, 0.0])
    np.testing.assert_allclose(numbers(locked, [0.3], [1.1], [0.2]), wanted[:1], rtol=1e-12)


FOLLOWS = {"joint": "j1", "ratio": 2, "offset": "1/3"}


def numbers(scene, *state):
    """Return inverse dynamics of a state."""
    return lambdify(scene, "inverse_dynamics")(*state)


def test_something_must_be_left_to_move():
    with pytest.raises(SceneError, match="nothing moves: every joint is locked; leave one free"):
        lock(arm(), {f"j{i}": Quantity.number(0) for i in range(3)})


def test_only_a_joint_with_a_coordinate_can_be_locked():
    with pytest.raises(SceneError, match=r"joints\.j7: only a joint with a coordinate of its own can be locked"):
        lock(arm(), {"j7": Quantity.number(0)})
