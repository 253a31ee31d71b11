"""Numbers of another tool, which has the same joints in another order, are found in ours by the joints' names."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mechanisms import coupled_tree, jointed, random_tree

from symdyn.errors import SceneError
from symdyn.runtime import lambdify
from symdyn.scene import Scene, read_text

DOCS = Path(__file__).parent.parent / "docs"

HAND = """
{base}
[bodies.palm]
mass = 1.5
com = [0.1, 0.02, -0.03]
inertia = [0.02, 0.03, 0.04]
inertia_about = "com"
{fingers}
"""

FREE = '[joints.base]\ntype = "free"\nparent = "ground"\nchild = "palm"\ndrives = false\n'
TURNING = '[joints.base]\ntype = "revolute"\nparent = "ground"\nchild = "palm"\n'

FINGER = """
[bodies.{name}]
mass = {mass}
com = [0.05, {mass}, 0.01]
inertia = [0.01, 0.02, 0.015]
inertia_about = "com"
[joints.{name}_joint]
type = "{type}"
parent = "palm"
child = "{name}"
origin = {{ xyz = [0.1, {mass}, 0], rpy = [{mass}, 0.2, -0.4] }}
"""

FINGERS = [
    ("thumb", 0.3, "revolute"),
    ("index", 0.7, "spherical"),
    ("pad", 0.4, "prismatic"),
    ("ring", 0.2, "revolute"),
]


def hand(base: str, order: list[int]) -> Scene:
    fingers = (FINGER.format(name=name, mass=mass, type=kind) for name, mass, kind in (FINGERS[k] for k in order))
    return read_text(HAND.format(base=base, fingers="".join(fingers)))


def state(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, len(scene.coordinates))
    v, a = rng.uniform(-1, 1, (2, len(scene.velocities)))
    return q, v, a


@pytest.mark.long(0)
@pytest.mark.wide(3)
@pytest.mark.parametrize("base", [FREE, TURNING], ids=["free", "turning"])
@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 1, 0, 2], [2, 3, 1, 0]], ids=str)
def test_the_same_mechanism_in_another_order_has_the_same_dynamics_by_names(base: str, order: list[int]) -> None:
    ours, theirs = hand(base, [0, 1, 2, 3]), hand(base, order)
    found = ours.order([joint.name for joint in theirs.joints])
    one, other = (lambdify(scene, ("inverse_dynamics", "mass_matrix")) for scene in (ours, theirs))
    q_, v_, a_ = state(theirs, 1)
    q, v, a = np.empty_like(q_), np.empty_like(v_), np.empty_like(a_)
    q[found.q], v[found.v], a[found.v] = q_, v_, a_

    np.testing.assert_allclose(one[0](q, v, a)[found.v], other[0](q_, v_, a_), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(one[1](q)[np.ix_(found.v, found.v)], other[1](q_), rtol=1e-12, atol=1e-13)
    assert order == [0, 1, 2, 3] or np.max(np.abs(one[0](q_, v_, a_) - other[0](q_, v_, a_))) > 1e-3


@pytest.mark.parametrize(
    "scene", [*(random_tree(seed) for seed in range(6)), *(coupled_tree(seed) for seed in range(3))], ids=str
)
def test_an_order_is_a_permutation_and_tells_the_names_that_go_with_it(scene: Scene) -> None:
    names = [joint.name for joint in scene.joints]
    random.Random(scene.name).shuffle(names)
    order = scene.order(names)

    assert sorted(order.q) == list(range(len(scene.coordinates)))
    assert sorted(order.v) == list(range(len(scene.velocities)))
    assert order.joints == tuple(name for name in names if name in {joint.name for joint in scene.moving})
    assert order.coordinates == tuple(np.array(scene.coordinates)[order.q])
    assert order.velocities == tuple(np.array(scene.velocities)[order.v])
    assert order.drives == tuple(np.array(scene.drives, dtype=object)[order.v])
    assert order == scene.order(order.joints)


def test_a_quaternion_is_put_into_its_order_and_places_before_it_are_not() -> None:
    scene = jointed("free", "revolute", "spherical")
    order = scene.order(["j2", "j0", "j1"], quaternion="xyzw")
    q = np.arange(12.0)

    assert q[order.q].tolist() == [9, 10, 11, 8, 0, 1, 2, 4, 5, 6, 3, 7]
    assert order.v.tolist() == [7, 8, 9, 0, 1, 2, 3, 4, 5, 6]


def test_names_that_a_file_has_and_that_were_made_printable_are_known() -> None:
    scene = hand(TURNING, [0, 1, 2, 3])

    assert scene.order(["base", "thumb-joint", "Index Joint", "pad_joint", "ring_joint"]) == scene.order(
        [joint.name for joint in scene.joints]
    )


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["base"], "thumb_joint, index_joint, pad_joint, ring_joint missing; give every joint that moves"),
        (["base", "thumb_joint", "base"], "'base' stands there twice"),
        (["universe", "base"], "there is no joint 'universe'; known are base, thumb_joint"),
        (["bas"], "there is no joint 'bas'; did you mean base?"),
        ("base", "give a list of names"),
        ([1], "give a list of texts"),
    ],
)
def test_an_order_that_leaves_something_open_is_refused(names: list[str], said: str) -> None:
    with pytest.raises(SceneError, match=re.escape(said)):
        hand(TURNING, [0, 1, 2, 3]).order(names)
    with pytest.raises(SceneError, match="'wxyz' or 'xyzw'"):
        hand(TURNING, [0, 1, 2, 3]).order([], quaternion="ijkw")


def test_fixed_joints_may_be_among_the_names() -> None:
    scene = hand(TURNING, [0, 1, 2, 3])
    welded = replace(
        scene, joints=(*scene.joints[:-1], replace(scene.joints[-1], type="fixed", coordinates=(), drives=()))
    )

    assert welded.order([joint.name for joint in welded.joints]).joints == tuple(
        joint.name for joint in welded.joints[:-1]
    )


def test_who_says_that_we_agree_with_pinocchio_says_the_order_of_joints() -> None:
    """Paragraph by paragraph, and item by item."""
    claims = [
        part
        for page in DOCS.glob("*.md")
        for part in re.split(r"\n\s*\n|\n(?=[-#|] ?)", page.read_text(encoding="utf-8"))
        if "Pinocchio" in part and re.search(r"\bagrees?\b", part)
    ]

    assert len(claims) >= 3
    assert [part for part in claims if "order" not in part] == []
