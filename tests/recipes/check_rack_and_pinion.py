"""What a joint type from outside is worth: everything that symdyn does with its own, checked by laws.

`tests/test_recipes.py` runs this in a fresh process, where the type is one file that is imported here.
"""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import rack_and_pinion  # noqa: F401  it adds its row

import symdyn
from symdyn.draw import free_body
from symdyn.dynamics.loops.mobility import mobility
from symdyn.emit import TARGETS, emit
from symdyn.errors import SymdynError
from symdyn.scene import lock, parse, read_text, with_symbols, write_text
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_kind import JointKind, JointMark
from symdyn.simulation import simulate
from symdyn.teach import walkthrough

pytestmark = pytest.mark.runs  # motions are compiled where there is a compiler

NAME = "rack_and_pinion"
R, M, I = 0.25, 2.0, 0.3  # noqa: E741

TREE = f"""name = "roller"
gravity = [-9.81, 0, 0]
[parameters]
r = {R}
[bodies.pinion]
mass = {M}
inertia = [0.2, 0.2, {I}]
inertia_about = "com"
[joints.mesh]
type = "{NAME}"
parent = "ground"
child = "pinion"
radius = "r"
coordinate = "phi"
drive = "M"
start = 2
[points.rim]
body = "pinion"
at = [0, 0.25, 0]
"""

LOOP = f"""name = "closed"
gravity = [-9.81, 0, 0]
[bodies.pinion]
mass = {M}
inertia = [0.2, 0.2, {I}]
inertia_about = "com"
[joints.flat]
type = "planar"
parent = "ground"
child = "pinion"
coordinates = ["x", "y", "phi"]
drive = false
[[loop]]
name = "mesh"
type = "{NAME}"
parent = "ground"
child = "pinion"
radius = {R}
"""


def refusal(text: str) -> str:
    with pytest.raises(SymdynError) as refused:
        read_text(text)
    return str(refused.value)


def check_keys() -> None:
    """Its key is read, written, checked, named and asked for, and belongs to no other type."""
    scene = read_text(TREE)

    assert read_text(write_text(scene, "toml").text) == scene
    assert "radius is missing; write radius = 0.1" in refusal(TREE.replace('radius = "r"\n', ""))
    assert "radius = -1 is that of no pinion" in refusal(TREE.replace('radius = "r"', "radius = -1"))
    assert "uses the undefined symbol s" in refusal(TREE.replace('radius = "r"', 'radius = "s"'))
    assert "radius" in refusal(TREE.replace('radius = "r"', "radius = [1]"))
    assert 'radius = "r" has no meaning for a revolute joint' in refusal(TREE.replace(NAME, "revolute"))
    assert f"did you mean {NAME}?" in refusal(TREE.replace(NAME, "rack_and_pinon"))
    named = with_symbols(read_text(TREE.replace('"r"', "0.25")), "geometry")
    assert next((p.name, p.unit, p.text) for p in named.parameters if p.name != "r") == (
        "rp1", "m", "pitch radius of mesh"
    )  # fmt: skip
    for kind in ("urdf", "par"):
        with pytest.raises(SymdynError, match=NAME):
            write_text(scene, kind)


def check_blocks() -> None:
    """The pinion is where x = r φ, and falls along its rack as one of mass m + I / r²."""
    scene = read_text(TREE)
    for phi in (-0.7, 0.0, 2.3):
        place = np.asarray(symdyn.lambdify(scene, "pose:rim")([phi]))
        tip = np.array([R * phi - R * np.sin(phi), R * np.cos(phi), 0])
        np.testing.assert_allclose(place.ravel()[[3, 7, 11]], tip, atol=1e-15)
    found = symdyn.lambdify(scene, "forward_dynamics")([0.3], [2.0], [0.5])
    np.testing.assert_allclose(found, [(0.5 - M * 9.81 * R) / (M * R * R + I)], rtol=1e-14)
    motion = simulate(scene, until=2.0)
    kinetic, potential = symdyn.lambdify(scene, ("kinetic_energy", "potential_energy"))
    total = kinetic(motion.q, motion.qd) + potential(motion.q)
    np.testing.assert_allclose(total, total[0], rtol=1e-9)


def check_forbids() -> None:
    """Every law holds, reactions too; a loop that it closes leaves one freedom, along which x = r φ."""
    scene = read_text(TREE)

    assert symdyn.certify(scene).passed
    assert symdyn.certify(scene, ["reactions", "forward_reactions"]).passed
    assert JOINTS[NAME].class_t(scene.joints[0]) == 5
    shown = free_body(scene, "pinion")
    assert "force F mesh,3" in shown  # that of the teeth, with its moment
    assert "couple M" in shown

    scene = read_text(LOOP)
    assert mobility(scene).by_rank == 1
    motion = simulate(scene, until=0.5)
    np.testing.assert_allclose(motion.q[:, 0], R * motion.q[:, 2], atol=1e-8)
    assert abs(motion.q[-1, 0]) > 0.2


def check_words() -> None:
    for language, words in JOINTS[NAME].words.items():
        for formulation in ("lagrange", "dalembert"):
            assert words in str(walkthrough(read_text(TREE), language=language, formulation=formulation))
    assert set(JOINTS[NAME].words) == {"en", "sk"}


def check_mark() -> None:
    """The picture is face-on, since the motion is in a plane, with a ring on a rail along x."""
    shown = symdyn.picture(read_text(TREE))

    assert 'class="joint"' in shown
    assert "hatch" in shown


def check_held() -> None:
    scene = lock(read_text(TREE.replace("[points", "[bodies.hanger]\nmass = 1\n[joints.pin]\ntype = \"revolute\"\n"
        "parent = \"pinion\"\nchild = \"hanger\"\n[points")), {"mesh": parse("pi/2")})  # fmt: skip
    still = np.asarray(symdyn.lambdify(scene, "pose:rim")([0.0])).ravel()

    np.testing.assert_allclose(still[[3, 7, 11]], [R * np.pi / 2 - R, 0, 0], atol=1e-15)


CHECKS = {
    "keys": check_keys, "blocks": check_blocks, "forbids": check_forbids,
    "words": check_words, "mark": check_mark, "held": check_held,
}  # fmt: skip

GONE = {
    "keys": (), "blocks": lambda joint: (), "forbids": None,
    "words": {}, "mark": JointMark(()), "held": lambda joint, position: (),
}  # fmt: skip


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("field", CHECKS)
def test_the_new_type_does_what_its_row_says(field: str) -> None:
    CHECKS[field]()


@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("field", CHECKS)
def test_a_row_without_a_field_fails_the_check_of_that_field(field: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(JOINTS, NAME, replace(JOINTS[NAME], **{field: GONE[field]}))

    with pytest.raises((AssertionError, SymdynError, LookupError, TypeError, pytest.fail.Exception)):
        CHECKS[field]()


def test_it_stands_among_other_joints() -> None:
    """A rod hangs on the pinion: the pair is proved, written for every target, drawn, and told as a closed form."""
    rod = """[bodies.rod]
mass = 1
com = [0, -0.5, 0]
[joints.pin]
type = "revolute"
parent = "pinion"
child = "rod"
"""
    scene = read_text(TREE + rod)

    assert symdyn.certify(scene).passed
    assert str(symdyn.closed_form(scene).sympy("k_z", 0, 1)) == "r*(-sin(phi)*sin(q2) + cos(phi)*cos(q2))/2 + 1/4"
    free = [name for name, target in TARGETS.items() if target.functions is None]
    assert all(emit(symdyn.program.lower(symdyn.dynamics.derive(scene, ["reactions"])), name).files for name in free)
    assert f"{NAME} joint mesh" in symdyn.picture(scene)
    follows = read_text(TREE + rod + 'mimic = { joint = "mesh", ratio = -1 }\n')
    assert symdyn.certify(follows).passed
    backwards = TREE.replace('"ground"', '"x"').replace('"pinion"', '"ground"').replace('"x"', '"pinion"')
    assert "cannot be turned round" in refusal(backwards)


def test_every_field_of_a_row_is_checked_or_left_to_its_default() -> None:
    row = JOINTS[NAME]
    assert {one.name for one in fields(JointKind) if getattr(row, one.name) is not one.default} == set(CHECKS)
