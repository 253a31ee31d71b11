"""Directions, signs and points that results state, against numbers that were worked out by hand."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.draw import acting_on
from symdyn.emit.print.dalembert_page import dalembert_lines
from symdyn.graph import Graph, evaluate
from symdyn.scene import parse, read_text
from symdyn.scene.values import acceleration_name


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("kind", ["spherical", "free", "point_on_line", "point_on_plane", "revolute", "planar"])
def test_a_drive_acts_along_what_its_velocity_turns_or_moves(kind: str, sense: int) -> None:
    """Drives of quaternions, which are no coordinates, were left out."""
    axis, half = ("" if kind in ("spherical", "free") else f"axis = [0, {sense}, 0]"), math.sqrt(0.5)
    text = f"""
    [bodies.b]
    mass = 1
    [joints.j]
    type = "{kind}"
    parent = "ground"
    child = "b"
    origin = [["Rz", "pi/2"]]
    {axis}
    """
    e = [half, half, 0, 0]  # a quarter turn about x, which the origin has turned to y: columns y, z, x
    moved = [(0, 1, 0), (0, 0, 1), (1, 0, 0)]
    along, (x, y) = (-sense, 0, 0), ((0, 1, 0), (0, 0, -sense))
    q, forces, couples = {
        "spherical": (e, [], moved),
        "free": ([0, 0, 0, *e], moved, moved),
        "point_on_line": ([0, *e], [along], moved),
        "point_on_plane": ([0, 0, *e], [x, y], moved),
        "revolute": ([0.3], [], [along]),
        "planar": ([0, 0, 0.3], [x, y], [along]),
    }[kind]
    drives = [w for w in acting_on(read_text(text), "b", q) if r"\tau" in w.name]

    expected = [*((*w, 0, 0, 0) for w in forces), *((0, 0, 0, *w) for w in couples)]
    np.testing.assert_allclose([(*w.force, *w.couple) for w in drives], expected, atol=1e-15)


def test_the_drive_of_a_bead_acts_along_its_wire() -> None:
    """It was drawn along the first of the joint's steps."""
    text = """
    [bodies.bead]
    mass = 1
    [joints.wire]
    type = "custom"
    parent = "ground"
    child = "bead"
    coordinate = "u"
    units = ["m"]
    drive = "F"
    steps = [["Tx", "u"], ["Ty", "u**2/2"]]
    """
    (drive,) = [w for w in acting_on(read_text(text), "bead", [0.75]) if w.name == "F"]

    assert drive.force == pytest.approx((0.8, 0.6, 0))


ON_A_FLOOR = """
gravity = [0, 0, -10]
[bodies.block]
mass = 2
[bodies.follower]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
drive = false
coordinate = "x"
[joints.gear]
type = "revolute"
parent = "block"
child = "follower"
axis = [0, -1, 0]
KIND
[contacts.foot]
body = "block"
at = [0, 0, -1]
plane = { body = "ground", normal = [0, 0, 1], at = [0, 0, -1] }
FRICTION
[ropes.leash]
type = "slack"
through = [{ body = "ground", at = [0, 3, 4] }, { body = "block", at = [0, 0, 0] }]
length = 9
"""


@pytest.mark.parametrize(
    ("kind", "felt", "rough"),
    [
        ('mimic = { joint = "slide", ratio = 2 }', ("gear", "slide"), False),
        ('drive = "M"\n[springs.s]\njoint = "gear"\nstiffness = 3', ("gear",), True),
        ('drive = "M"\ndamping = 0.1', ("gear",), False),
        ('drive = "M"\nlimits = { upper = 1, restitution = 0 }', ("gear",), True),
        ('drive = "M"\n[constraints.c]\nformula = "x_dot - 2*q2_dot"\nacts_in = "joints"', ("gear", "slide"), False),
        ('drive = "M"', (), True),
    ],
)
def test_a_body_alone_has_what_contacts_slack_ropes_and_joints_do(
    kind: str, felt: tuple[str, ...], rough: bool
) -> None:
    """Contacts that open, slack ropes, and what springs, friction, stops and gears do in a joint were left out."""
    one = read_text(ON_A_FLOOR.replace("KIND", kind).replace("FRICTION", "static = 0.3" if rough else ""))
    q = [0.0] * len(one.coordinates)
    block, follower = ({w.name: w for w in acting_on(one, body, q)} for body in ("block", "follower"))
    ways = {rf"F_{{\mathrm{{foot}}{k}}}": way for k, way in zip(FEET[rough], np.eye(3)[[2, 0, 1]], strict=False)}

    feet = {name: w for name, w in block.items() if "foot" in name}
    assert {name: tuple(w.force) for name, w in feet.items()} == {name: tuple(way) for name, way in ways.items()}
    assert {tuple(w.at) for w in feet.values()} == {(0, 0, -1)}
    assert block[r"F_{\mathrm{leash}}"].force == pytest.approx((0, 0.6, 0.8))
    own = {f"{sign}Q_{{\\mathrm{{{joint}}}}}" for joint in felt for sign in ("", "-")[: 1 + (joint == "gear")]}
    assert {name for name in (*block, *follower) if "Q" in name} == own
    if felt:
        Q = r"Q_{\mathrm{gear}}"
        assert tuple(follower[Q].couple) == (0, -1, 0) == tuple(-x for x in block[f"-{Q}"].couple)


FEET = {False: ("",), True: (",1", ",2", ",3")}
"""Indices of the forces of a contact, by whether it is rough."""


SLIDES = """
gravity = [0, 0, -9.81]
[bodies.a]
mass = 1
[bodies.b]
mass = 2
[joints.s]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
start = -0.6
[joints.t]
type = "prismatic"
parent = "ground"
child = "b"
axis = [0, 0, 1]
coordinate = "z"
start = 0.8
[[loop]]
name = "link"
type = "rod"
parent = "b"
child = "a"
length = 1
"""


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("x", "z"), [(-1, 0), (1, 0), (0, 1), (0, -1), (-0.6, 0.8)])
def test_the_multiplier_of_a_rod_is_its_force_wherever_it_starts(x: float, z: float) -> None:
    """At a start along -x it was called fx_joint, which it was the opposite of, and which it no longer was later."""
    text = SLIDES.replace("start = -0.6", f"start = {x}.0" if x == int(x) else f"start = {x}")
    run = symdyn.simulate(read_text(text.replace("start = 0.8", f"start = {float(z)}")), until=0.2, reactions="ground")
    a, b = run.qdd[:, 0], run.qdd[:, 1]
    rod = run["multiplier_link_force"]

    np.testing.assert_allclose(rod * run["x"], a, atol=1e-9)  # on a, from b to a, over the length 1
    np.testing.assert_allclose(-rod * -run["z"], 2 * (b + 9.81), atol=1e-9)


@pytest.mark.runs("cc")
def test_the_moment_of_a_cross_is_named_after_no_axis() -> None:
    """At its zero position it was called my_joint, which it was the opposite of."""
    text = """
    [bodies.a]
    mass = 1
    inertia = [0.1, 0.1, 0.1]
    inertia_about = "com"
    [bodies.b]
    mass = 1
    inertia = [0.1, 0.1, 0.1]
    inertia_about = "com"
    [joints.s]
    type = "revolute"
    parent = "ground"
    child = "a"
    [joints.ball]
    type = "spherical"
    parent = "ground"
    child = "b"
    drives = ["Mx", "My", "Mz"]
    [[loop]]
    name = "cross"
    type = "universal"
    parent = "a"
    child = "b"
    """
    run = symdyn.simulate(read_text(text), until=0.01, forces="My=0.3", reactions="joint")

    assert run["multiplier_cross_moment"][0] == pytest.approx(0.3)  # about -y: it stops what My would turn
    assert run["reaction_cross_my_joint"][0] == pytest.approx(-0.3)


@pytest.mark.parametrize(("normal", "name"), [("y", "F_rim_y"), ("-y", "R_rim_1")])
def test_the_force_of_a_plane_bears_an_axis_only_along_it(normal: str, name: str) -> None:
    """That of a plane with the normal -y, gravity along +y, was called F_rim_y."""
    sense = -1 if normal == "-y" else 1
    text = f"""
    gravity = [0, {-9.81 * sense}, 0]
    [bodies.b]
    mass = 1
    inertia = [0.1, 0.1, 0.1]
    inertia_about = "com"
    [joints.j]
    type = "planar"
    parent = "ground"
    child = "b"
    drive = false
    [constraints.rim]
    type = "rolling"
    body = "b"
    radius = 0.2
    components = ["normal"]
    axis = [0, 0, 1]
    plane = {{ body = "ground", normal = [0, {sense}, 0] }}
    """
    lines = dalembert_lines(read_text(text))

    assert f"# {name}: force along {normal} of the reaction in joint rim, joint axes, N" in lines


AXES = {f"{sign}{'xyz'[k]}": k for sign in ("", "-") for k in range(3)}


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "cylindrical", "planar", "helical"])
def test_what_is_named_after_an_axis_of_the_joint_holds_a_body_at_rest(kind: str, axis: str) -> None:
    """The forces are the weight turned round, the moments those of its arm; D'Alembert's equations vanish with them."""
    k, sense = AXES[axis], -1 if axis[0] == "-" else 1
    a = [sense * int(i == k) for i in range(3)]
    one = read_text(f"""
    gravity = [3, -5, 7]
    [bodies.b]
    mass = 2
    com = [0.1, 0.2, -0.3]
    [joints.j]
    type = "{kind}"
    parent = "ground"
    child = "b"
    axis = {a}
    {"pitch = 0.5" if kind == "helical" else ""}
    """)
    force, moment = np.array([-6.0, 10, -14]), np.array([0.2, 3.2, 2.2])
    x, y = {"x": ("-z", "y"), "-x": ("z", "y"), "y": ("x", "-z"), "-y": ("x", "z"), "z": ("x", "y"), "-z": ("x", "-y")}[
        axis
    ]
    pushed = {c: (-1 if c[0] == "-" else 1) * force[AXES[c]] for c in AXES}
    turned = sense * moment[k]
    drives = {
        "revolute": [turned],
        "prismatic": [pushed[axis]],
        "cylindrical": [turned, pushed[axis]],
        "planar": [pushed[x], pushed[y], turned],
        "helical": [turned + pushed[axis] * 0.25 / math.pi],
    }[kind]
    known = dict.fromkeys((*one.coordinates, *one.velocities, *map(acceleration_name, one.velocities)), 0.0)
    known |= dict(zip(filter(None, one.drives), drives, strict=True)) | {"R_j_5": force[k]}
    known |= {f"F_j_{c}": value for c, value in zip("xyz", force, strict=True)}
    known |= {f"M_j_{c}": value for c, value in zip("xyz", moment, strict=True)}

    graph = Graph()
    lines = [line for line in re.sub(r"\n +", " ", dalembert_lines(one)).splitlines() if line.endswith(" = 0")]
    sides = [parse(line.removesuffix(" = 0")).express(graph) for line in lines]
    found = evaluate(sides, Floats(), {graph.symbol(name): value for name, value in known.items()})
    assert len(found) in (3, 6)
    np.testing.assert_allclose(found, 0, atol=1e-12)


@pytest.mark.runs("cc")
def test_normal_and_friction_act_along_the_directions_that_the_page_says() -> None:
    """Six points slide at (2, 3, 6) less its part along the normal, each pressed with 20 N on a plane of its own."""
    n = {axis.replace("-", "m"): (-1 if axis[0] == "-" else 1) * np.eye(3)[k] for axis, k in AXES.items()}
    slip = {name: np.array([2.0, 3, 6]) - np.dot([2.0, 3, 6], one) * one for name, one in n.items()}
    text = 'gravity = "none"\n' + "".join(
        f"""
        [bodies.{name}]
        mass = 1
        [joints.j{name}]
        type = "custom"
        parent = "ground"
        child = "{name}"
        coordinates = ["x{name}", "y{name}", "z{name}"]
        units = ["m", "m", "m"]
        steps = [["Tx", "x{name}"], ["Ty", "y{name}"], ["Tz", "z{name}"]]
        drive = false
        start_rates = {slip[name].tolist()}
        [loads.f{name}]
        body = "{name}"
        force = {(-20 * one).tolist()}
        [contacts.c{name}]
        body = "{name}"
        plane = {{ body = "ground", normal = {one.tolist()} }}
        friction = 0.3
        """
        for name, one in n.items()
    )
    run = symdyn.simulate(read_text(text), until=0.01, every=0.01, method="dop853")

    for name, one in n.items():
        along = np.array([0.0, 1, 0] if name in ("x", "mx") else [1.0, 0, 0])
        friction = -6 * slip[name] / np.linalg.norm(slip[name])
        assert run[f"normal_c{name}"][0] == pytest.approx(20)
        assert run[f"friction_along_c{name}"][0] == pytest.approx(friction @ along)
        assert run[f"friction_across_c{name}"][0] == pytest.approx(friction @ np.cross(one, along))
