"""An oscillating-cylinder engine, and what is said of its loop: where it is cut, what it holds, what works instead."""

from __future__ import annotations

import re

import numpy as np
import pytest

import symdyn
from symdyn.errors import DerivationError, SceneError
from symdyn.scene import read_text, write_text

ENGINE = """
gravity = [0, -9.81, 0]
[parameters]
r = 0.05
D = 0.25
L = 0.20
cp = 40
[bodies]
crank = { mass = 1, inertia = [0.002, 0.002, 0.004] }
piston = { mass = 0.6, com = ["L/2", 0, 0], inertia = [0, 0.003, 0.003], inertia_about = "com" }
cylinder = { mass = 1.5, inertia = [0.001, 0.01, 0.01] }
[joints]
main = { type = "revolute", parent = "ground", child = "crank", coordinate = "phi", drive = "M", start = "40 deg" }
"""

PIN = 'type = "revolute"\nparent = "crank"\nchild = "piston"\norigin = ["r", 0, 0]\n'

TRUNNION = 'type = "revolute"\nparent = "ground"\nchild = "cylinder"\norigin = ["D", 0, 0]\ndrive = false\n'

BORE = 'type = "prismatic"\nparent = "cylinder"\nchild = "piston"\naxis = [1, 0, 0]\ntip = ["-L", 0, 0]\n'

SEAL = '[dampers.seal]\nfrom = { body = "cylinder", at = [0, 0, 0] }\nto = { body = "piston", at = [0, 0, 0] }\n'

AT_THE_SLIDE = (
    f'{ENGINE}[joints.crankpin]\n{PIN}coordinate = "psi"\ndrive = false\nstart = "-50 deg"\n'
    f'[joints.trunnion]\n{TRUNNION}coordinate = "beta"\nstart = "-10 deg"\n[[loop]]\nname = "bore"\n{BORE}'
)

AT_THE_PIN = (
    f'{ENGINE}[joints.trunnion]\n{TRUNNION}coordinate = "beta"\nstart = "-10 deg"\n'
    f'[joints.bore]\n{BORE}coordinate = "u"\ndrive = false\ndamping = "cp"\n[[loop]]\nname = "crankpin"\n{PIN}'
)


def faults(text: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        read_text(text)
    return [line.split(": ", 1)[1] for line in caught.value.faults]


@pytest.mark.runs("cc")
def test_damping_where_a_loop_is_cut_is_a_damper_or_that_of_another_cut() -> None:
    (told,) = faults(f'{AT_THE_SLIDE}damping = "cp"\n')
    assert told == (
        'loop.bore: damping = "cp" has no meaning for a joint that closes a loop; write [joints.bore] in its place, '
        'and [[loop]] for another joint of the loop; or [dampers.NAME] with from = { body = "cylinder", at = .. }, '
        'to = { body = "piston", at = .. }, two points on its axis'
    )
    moves = ({"phi": "0.7 + 30*t"}, [0.0, 0.01, 0.05])
    by_damper, other_cut, without = (
        symdyn.inverse(read_text(text), *moves)["M"]
        for text in (f'{AT_THE_SLIDE}{SEAL}damping = "cp"\n', AT_THE_PIN, AT_THE_SLIDE)
    )
    assert by_damper == pytest.approx(other_cut, abs=1e-9)
    assert np.abs(by_damper - without).max() > 0.1


@pytest.mark.parametrize("key", ['coordinate = "u"', "limits = { lower = 0 }", "start = 1", 'drive = "F"'])
def test_what_a_cut_joint_has_not_is_that_of_another_cut(key: str) -> None:
    (told,) = faults(f"{AT_THE_SLIDE}{key}\n")
    assert told.endswith("write [joints.bore] in its place, and [[loop]] for another joint of the loop")


def test_a_loop_without_a_freedom_is_not_sent_to_where_a_key_is_refused_again() -> None:
    (told,) = faults(
        AT_THE_SLIDE.replace('type = "prismatic"', 'type = "fixed"').replace("axis = [1, 0, 0]\n", "") + "start = 1\n"
    )
    assert told == "loop.bore: start = 1 has no meaning for a fixed joint; leave it out"
    (told,) = faults(f"{AT_THE_SLIDE}stiffness = 3\n")
    assert "[springs.NAME] with from and to" in told


YOKE = """
gravity = [0, -9.81, 0]
[bodies]
crank = { mass = 1, inertia = [0.01, 0.01, 0.01] }
block = { mass = 0.2, inertia = [0.001, 0.001, 0.001] }
yoke = { mass = 2 }
[joints]
main = { type = "revolute", parent = "ground", child = "crank", coordinate = "phi", drive = "M", start = 0.7 }
[joints.pin]
drive = false
type = "revolute"
parent = "crank"
child = "block"
coordinate = "psi"
origin = [0.1, 0, 0]
start = -0.7
[joints.guide]
drive = false
type = "prismatic"
parent = "ground"
child = "yoke"
coordinate = "x"
axis = [1, 0, 0]
start = 0.08
[[loop]]
name = "slot"
type = "prismatic"
parent = "yoke"
child = "block"
axis = [0.5, 1, 0]
"""
"""A Scotch yoke whose slot leans."""

OTHER_WAY = YOKE.replace('parent = "yoke"', 'parent = "block"').replace('child = "block"\naxis', 'child = "yoke"\naxis')

CRANK = """
gravity = [0, -9.81, 0]
[bodies]
crank = { mass = 1, inertia = [0.01, 0.01, 0.01] }
rod = { mass = 0.5, com = [0.2, 0, 0], inertia = [0.01, 0.01, 0.01], inertia_about = "com" }
piston = { mass = 0.8, inertia = [0.01, 0.01, 0.01] }
[joints]
main = { type = "revolute", parent = "ground", child = "crank", coordinate = "phi", drive = "M", start = 0.7 }
[joints.pin]
drive = false
type = "revolute"
parent = "crank"
child = "rod"
coordinate = "psi"
origin = [0.1, 0, 0]
start = -0.8
[joints.wrist]
drive = false
type = "revolute"
parent = "rod"
child = "piston"
coordinate = "eta"
origin = [0.4, 0, 0]
AXIS
[[loop]]
name = "bore"
type = "prismatic"
parent = "ground"
child = "piston"
axis = [1, 0, 0]
origin = [0, 0.03, 0]
"""
"""A slider-crank, its cylinder aside of the crank's axis."""

CUT_AT_A_SLIDE = {
    "swinging cylinder": AT_THE_SLIDE,
    "yoke": YOKE,
    "yoke from the block": OTHER_WAY,
    "slider-crank": CRANK.replace("AXIS", "start = 0.1"),
    "slider-crank, axes opposite": CRANK.replace("AXIS", "axis = [0, 0, -1]\nstart = -0.1"),
    "the other branch": CRANK.replace("AXIS", "start = 3.3").replace("start = -0.8", "start = 2.6"),
}


@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", CUT_AT_A_SLIDE)
def test_positions_of_a_loop_that_is_cut_at_a_slide_are_those_of_numbers(name: str) -> None:
    scene = read_text(CUT_AT_A_SLIDE[name])
    led = symdyn.inverse(scene, {"phi": "0.7 + t"}, times=np.linspace(0, 2 * np.pi, 50)).q

    positions, residual = symdyn.lambdify(scene, ("positions", "constraint_residual"))
    found = positions(led[:, :1])

    assert np.abs(residual(found)).max() < 1e-14
    turns = [not name.startswith("x") for name in scene.coordinates]
    assert np.abs(np.where(turns, np.sin((found - led) / 2), found - led)).max() < 1e-8


@pytest.mark.runs("cc")
def test_positions_are_those_of_another_cut() -> None:
    phi = 0.698
    by_slide, by_pin = (symdyn.lambdify(read_text(text), "positions")([phi]) for text in (AT_THE_SLIDE, AT_THE_PIN))
    assert by_slide[2] == pytest.approx(by_pin[1], abs=1e-12)
    assert np.sin(by_slide[1] + phi - by_slide[2]) == pytest.approx(0, abs=1e-12)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("rsup", "they need a loop with two unknowns, against 3 from the loop ball"),
        ("cart_with_wheel", "against 1 from the contact slip"),
        ("rolling_disc", "a joint of it is described by a quaternion"),
    ],
)
def test_the_line_of_positions_works(name: str, why: str) -> None:
    scene = symdyn.example(name)
    with pytest.raises(DerivationError, match=why) as caught:
        symdyn.lambdify(scene, "positions")
    (call,) = re.findall(r"symdyn\.\w+\(scene, .*\)\.q", str(caught.value))
    assert eval(call).shape[1] == len(scene.coordinates)


def test_a_loop_that_holds_a_drive_is_named() -> None:
    held = read_text(
        AT_THE_SLIDE.replace(f'name = "bore"\n{BORE}', BORE.replace('child = "piston"', 'child = "crank"'))
    )
    with pytest.raises(DerivationError, match="phi, which M of main drives, is held by the loop loop1; correct what"):
        symdyn.lambdify(held, "inverse_dynamics")


def test_loops_that_hold_a_drive_together_are_named() -> None:
    """Two rods hold the piston on the crank, neither alone; a slide is free beside them."""
    rods = "".join(
        f'[[loop]]\nname = "{name}"\ntype = "rod"\nparent = "cylinder"\nchild = "piston"\n'
        f"length = 0.22\norigin = [0, {side}, 0]\nchild_origin = [0, {side}, 0]\n"
        for name, side in (("left", 0.1), ("right", -0.07))
    )
    fixed = TRUNNION.replace("revolute", "fixed").replace("drive = false\n", "")
    bob = '[bodies.bob]\nmass = 1\n[joints.arm]\ntype = "prismatic"\nparent = "ground"\nchild = "bob"\ndrive = false\n'
    text = f"{ENGINE}[joints.crankpin]\n{PIN}drive = false\n[joints.trunnion]\n{fixed}{bob}{rods}"
    with pytest.raises(DerivationError, match="is held by the loop left, the loop right together; correct what"):
        symdyn.lambdify(read_text(text), "inverse_dynamics")


RING = """
[bodies]
bell = { mass = 3 }
clapper = { mass = 1 }
bob = { mass = 1 }
[joints.arm]
type = "revolute"
parent = "ground"
child = "bob"
[joints.axle]
type = "revolute"
parent = "clapper"
child = "bell"
damping = 1
[joints.pin]
type = "revolute"
parent = "bell"
child = "clapper"
damping = 2
[springs.leather]
joint = "pin"
stiffness = 3
"""


def test_a_ring_that_hangs_on_nothing_is_one_mistake() -> None:
    assert faults(RING) == [
        'joints.axle: parent = "clapper" closes a ring, bell -> clapper -> bell (child -> parent), that nothing joins '
        'to ground; write parent = "ground" in one of its joints'
    ]
    assert len(read_text(RING.replace('parent = "clapper"', 'parent = "ground"')).coordinates) == 3
    alone = re.sub(r"bob = .*\n(.*\n){4}", "", RING)
    assert "bob" not in alone
    assert faults(alone) == faults(RING)


RACK = """
bodies = { cart = { mass = 1 }, wheel = { mass = 1, inertia = [1, 1, 1] } }
[joints.track]
type = "prismatic"
parent = "ground"
child = "cart"
[joints.roll]
type = "TYPE"
parent = "cart"
child = "wheel"
mimic = { joint = "track" }
"""


def test_a_ratio_between_unlike_joints_is_asked_for() -> None:
    assert faults(RACK.replace("TYPE", "revolute")) == [
        "joints.roll: mimic: ratio is missing, in rad/m, since track is in m; write one such as ratio = 2"
    ]
    read_text(RACK.replace("TYPE", "prismatic"))
    one = read_text(RACK.replace("TYPE", "revolute").replace('"track" }', '"track", ratio = 1 }'))
    assert read_text(write_text(one, "toml").text).joints == one.joints


def test_a_value_that_is_none_is_one_mistake() -> None:
    (told,) = faults(
        RING.replace('"clapper"\nchild = "bell"', '"ground"\nchild = "bell"')
        + '[parameters]\nm = { value = "1,2", positive = true }\n'
    )
    assert "write decimals with a point" in told
