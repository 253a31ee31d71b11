"""Joints that follow others, rotors, dampers, limits: what may be declared, and that the dynamics are the reduced ones.

With the positions of all joints x = G q + offsets, the reduced equations are M = Gᵀ M' G and τ = Gᵀ τ'.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
from mechanisms import coupled_tree
from placeless import placeless
from running import call

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Workspace, derive, derive_one
from symdyn.dynamics.closed_forms.closed_form import closed_form
from symdyn.emit.print.equations_text import equations_text
from symdyn.errors import SceneError
from symdyn.graph import substitute
from symdyn.scene import Quantity, body, dh_table, parse, read_text, revolute, scene
from symdyn.scene.values import acceleration_name, velocity_name
from symdyn.scene.values.joint import Coupling
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

HAND = """
[bodies.palm]
mass = 1
[bodies.near]
mass = 1
[bodies.far]
mass = 1

[joints.wrist]
type = "revolute"
parent = "ground"
child = "palm"
mimic = { joint = "tip", ratio = 2, offset = "pi/4" }
armature = 0.1
damping = 0.2
friction = 0.3
limits = { lower = -1, upper = 1, velocity = 2, effort = 3 }

[joints.knuckle]
type = "prismatic"
parent = "palm"
child = "near"
mimic = { joint = "wrist", ratio = "1/3", offset = 1 }

[joints.tip]
type = "revolute"
parent = "near"
child = "far"
limits = { upper = "pi/2" }
"""


def test_a_chain_of_mimics_ends_at_its_coordinate_exactly():
    wrist, knuckle, tip = read_text(HAND).joints

    assert wrist.coupling == Coupling((("q1", Quantity.number(2)),), parse("pi/4"))
    assert knuckle.coupling == Coupling((("q1", Quantity.number(Fraction(2, 3))),), parse("pi/12 + 1"))
    assert (tip.coordinate, tip.drive, tip.coupling) == ("q1", "tau1", None)
    assert read_text(HAND).coordinates == ("q1",)


def test_limits_and_losses_are_kept():
    wrist, _, tip = read_text(HAND).joints

    assert (wrist.armature, wrist.damping, wrist.friction) == (parse("0.1"), parse("0.2"), parse("0.3"))
    assert (wrist.limits.lower, wrist.limits.effort) == (Quantity.number(-1), Quantity.number(3))
    assert (tip.limits.lower, tip.limits.upper) == (None, parse("pi/2"))


def test_python_and_denavit_hartenberg_rows_say_the_same_as_toml():
    keys = {"armature": "0.1", "damping": "0.2", "friction": "0.3", "limits": {"lower": -1, "upper": None}}
    follower = {"mimic": {"joint": "joint1", "ratio": 2}, **keys}
    rows = [{"mass": 1}, {"mass": 1, "a": 1, **follower}]
    links = scene("s", dh=dh_table("modified", rows))
    arm = scene(
        "s",
        bodies=[body("link1", mass=1), body("link2", mass=1)],
        joints=[
            revolute("joint1", "ground", "link1"),
            revolute("joint2", "link1", "link2", origin=[1, 0, 0], **follower),
        ],
    )

    assert arm == links
    assert arm.joints[1].coupling == Coupling((("q1", Quantity.number(2)),))
    assert arm.joints[1].limits.lower == Quantity.number(-1)


EDITS = [
    ('joint = "tip", ratio', 'joint = "knuckle", ratio',
     "joints.wrist: mimic: the joint follows itself: wrist -> knuckle -> wrist; give one a coordinate"),
    ('joint = "tip", ratio', 'joint = "wrist", ratio',
     "joints.wrist: mimic: the joint follows itself: wrist -> wrist; give one a coordinate"),
    ('joint = "tip", ratio', 'joint = "tipp", ratio',
     'joints.wrist: mimic.joint = "tipp" is not a joint; did you mean tip?'),
    ('joint = "tip", ratio', "ratio",
     'joints.wrist: mimic: joint is missing; write mimic = { joint = "leader", ratio = 1, offset = 0 }'),
    ('{ joint = "tip", ratio = 2, offset = "pi/4" }', '"tip"',
     'joints.wrist: mimic = "tip" is not a table; write mimic = { joint = "leader", ratio = 1, offset = 0 }'),
    ("ratio = 2", "ration = 2", 'joints.wrist: mimic: unknown key "ration"; did you mean ratio?'),
    ("ratio = 2", 'ratio = "rho"',
     "joints.wrist: mimic.ratio = rho uses the undefined symbol rho; declare it in parameters (known are none)"),
    ("ratio = 2", 'ratio = "q1"',
     "joints.wrist: mimic.ratio = q1 uses q1, which moves; only the force of a joint, loads and rows may depend on "
     "what moves"),
    ("ratio = 2", "ratio = 1e308", "a number is beyond the largest double"),
    ("armature", 'drive = "push"\narmature',
     'joints.wrist: drive = "push" has no meaning for a joint that follows another one; leave it out'),
    ("armature", 'coordinate = "x"\narmature',
     'joints.wrist: coordinate = "x" has no meaning for a joint that follows another one; leave it out'),
    ("armature", "force = 1\narmature",
     "joints.wrist: force = 1 has no meaning for a joint that follows another one; leave it out"),
    ("armature = 0.1", "armature = -0.1", "joints.wrist: armature = -0.1 is negative; give zero or more"),
    ("damping = 0.2", "damping = -0.2", "joints.wrist: damping = -0.2 is negative; give zero or more"),
    ("friction = 0.3", 'friction = "1 - 2"', "joints.wrist: friction = -1 is negative; give zero or more"),
    ("velocity = 2", "velocity = -2", "joints.wrist: limits.velocity = -2 is negative; give zero or more"),
    ("lower = -1", "lower = 3", "joints.wrist: limits.lower = 3 is above limits.upper = 1; swap them"),
    ("lower = -1", "low = -1", 'joints.wrist: limits: unknown key "low"; it is lower'),
    ('{ upper = "pi/2" }', "1.5",
     "joints.tip: limits = 1.5 is not a table; write limits = { lower = -1, upper = 1, velocity = 2, effort = 50 }"),
    ('type = "prismatic"', 'type = "fixed"', "has no meaning for a fixed joint; leave it out"),
    ('child = "far"', 'child = "far"\nmimic = { joint = "wrist" }', "the joint follows itself: wrist -> tip -> wrist"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "fault"), EDITS)
def test_a_mistake_is_named(old, new, fault):
    assert old in HAND
    text = HAND.replace(old, new, 1)
    if "1e308" in new:
        text = text.replace('ratio = "1/3"', "ratio = 10")
    with pytest.raises(SceneError, match=r"^scene\.toml:\d+: ") as caught:
        read_text(text)
    assert any(line.endswith(fault) or fault in line for line in caught.value.faults), caught.value.faults


def test_a_fixed_joint_is_not_followed():
    text = HAND.replace('child = "far"\nlimits = { upper = "pi/2" }', 'child = "far"').replace(
        'type = "revolute"\nparent = "near"', 'type = "fixed"\nparent = "near"'
    )
    with pytest.raises(SceneError, match=r'mimic\.joint = "tip" is a fixed joint; follow one that moves'):
        read_text(text)


@pytest.mark.long(0)
def test_a_long_chain_of_mimics_is_no_matter_of_depth():
    links = range(1200)
    follow = [None if i == 1199 else {"joint": f"j{i + 1}", "ratio": -1} for i in links]
    long = scene(
        "longest",
        bodies=[body(f"b{i}", mass=1) for i in links],
        joints=[revolute(f"j{i}", f"b{i - 1}" if i else "ground", f"b{i}", mimic=follow[i]) for i in links],
    )

    assert long.joints[0].coupling == Coupling((("q1", Quantity.number(-1)),))


# The dynamics are those that a person would reduce by hand


def released(one):
    """Return the scene with coordinates of their own for all joints, and the position of each in terms of q."""
    joints, positions = [], []
    for k, joint in enumerate(one.joints):
        if not joint.moves:
            joints.append(joint)
            continue
        follows = joint.coupling or Coupling(((joint.coordinate, Quantity.ONE),))
        joints.append(replace(joint, coordinates=(f"y{k}",), coupling=None))
        positions.append(follows)
    return replace(one, joints=tuple(joints)), positions


def reduced(one, w):
    """Return (M, tau, K, P) of the released scene, carried over to the coordinates of the coupled one."""
    free, positions = released(one)
    other = Workspace(free)
    M, tau, K, P = (
        derive_one(other, name, "lagrange" if name == "mass_matrix" else None).entries
        for name in ("mass_matrix", "inverse_dynamics", "kinetic_energy", "potential_energy")
    )
    zero, n, N = w.graph.zero, len(one.coordinates), len(positions)
    G = [
        [dict(follows.ratios).get(q, Quantity.ZERO).express(w.graph) for q in one.coordinates] for follows in positions
    ]
    values = {}
    for name, follows, row in zip(free.coordinates, positions, G, strict=True):
        led = [sum((x * w.graph.symbol(rate(q)) for x, q in zip(row, one.coordinates, strict=True)), start=zero)
               for rate in (str, velocity_name, lambda q: acceleration_name(velocity_name(q)))]  # fmt: skip
        values[other.graph.symbol(name)] = led[0] + follows.offset.express(w.graph)
        values[other.graph.symbol(velocity_name(name))] = led[1]
        values[other.graph.symbol(acceleration_name(velocity_name(name)))] = led[2]
    everything = substitute([*M, *tau, *K, *P], values, w.graph)
    M, tau, energies = everything[: N * N], everything[N * N : N * N + N], everything[-2:]
    small = [
        sum((G[i][a] * M[N * i + j] * G[j][b] for i in range(N) for j in range(N)), start=zero)
        for a in range(n)
        for b in range(n)
    ]
    return small, [sum((G[i][k] * tau[i] for i in range(N)), start=zero) for k in range(n)], energies


def differential(one):
    """Return the scene with followers that follow every coordinate."""
    ratios = tuple((q, Quantity.number(Fraction(k + 1, 2))) for k, q in enumerate(one.coordinates))
    joints = (replace(x, coupling=replace(x.coupling, ratios=ratios)) if x.coupling else x for x in one.joints)
    return replace(one, joints=tuple(joints))


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("several", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_coupled_trees_have_the_dynamics_of_the_reduced_tree(seed, several):
    one = coupled_tree(seed, n=4)
    one = differential(one) if several else one
    w = Workspace(one)
    M, tau, energies = reduced(one, w)
    K, P = (derive_one(w, name).entries for name in ("kinetic_energy", "potential_energy"))
    claims = [
        Claim("M", "coupled", "reduced", derive_one(w, "mass_matrix", "crba").entries, tuple(M)),
        Claim("tau", "coupled", "reduced", derive_one(w, "inverse_dynamics", "rnea").entries, tuple(tau)),
        Claim("energies", "coupled", "reduced", (*K, *P), tuple(energies)),
    ]

    found = prove([claim for claim in claims if claim.left])[1]  # k_C of one coordinate has no entries
    assert {finding.verdict for finding in found} == {Verdict.PROVED}


def test_a_wrong_ratio_is_found_out():
    one = coupled_tree(1, n=4)
    k = next(k for k, joint in enumerate(one.joints) if joint.coupling)
    coupling = one.joints[k].coupling
    ((q, ratio),) = coupling.ratios
    wrong = replace(one.joints[k], coupling=replace(coupling, ratios=((q, ratio + Quantity.number(1)),)))
    w = Workspace(one)
    M = reduced(replace(one, joints=(*one.joints[:k], wrong, *one.joints[k + 1 :])), w)[0]

    finding = prove([Claim("M", "coupled", "reduced", derive_one(w, "mass_matrix").entries, tuple(M))])[1][0]

    assert finding.verdict not in (Verdict.PROVED, Verdict.NUMERICAL)


def test_two_equal_gears_weigh_like_one_wheel():
    """A motor of inertia J behind a gear of ratio r adds r² J to the wheel: 3 + 4 · 5."""
    disc = {"inertia": [0, 0, 3], "about": "com", "mass": 1, "allow_invalid_inertia": True}
    wheels = scene(
        "gears",
        bodies=[body("wheel", **disc), body("motor", **{**disc, "inertia": [0, 0, 4]})],
        joints=[
            revolute("axle", "ground", "wheel"),
            revolute("shaft", "ground", "motor", mimic={"joint": "axle", "ratio": -2}, armature=1, damping="1/4"),
        ],
    )
    functions = derive(wheels, ["mass_matrix", "inverse_dynamics"])

    assert call(functions, "mass_matrix", Floats(), q=[0.3]) == [3 + 4 * (4 + 1)]
    assert call(functions, "inverse_dynamics", Floats(), q=[0.3], qd=[2.0], qdd=[0.0]) == [4 * 0.25 * 2]


@pytest.mark.heavy("2")
@pytest.mark.parametrize("seed", [1, 2, 4])
def test_closed_forms_of_coupled_trees_are_those_of_the_graph(seed):
    one = coupled_tree(seed, n=3)
    closed, w = closed_form(one), Workspace(one)
    claims = []
    for name in ("k_z", "k_C", "k_D", "k_G"):
        printed = [closed.form(*key).express(w.graph) for key in closed.coefficient_names() if key[0] == name]
        claims.append(Claim(name, "printed", "graph", tuple(printed), derive_one(w, name).entries))

    found = prove([claim for claim in claims if claim.left])[1]  # k_C of one coordinate has no entries
    assert {finding.verdict for finding in found} == {Verdict.PROVED}


def test_printed_equations_have_the_damping_of_followers():
    one = scene(
        "gears",
        parameters=dict.fromkeys(("d1", "d2")),
        bodies=[body("wheel", mass=1), body("motor", mass=1)],
        joints=[
            revolute("axle", "ground", "wheel", armature=1, damping="d1"),
            revolute("shaft", "ground", "motor", mimic={"joint": "axle", "ratio": -3}, damping="d2"),
        ],
    )

    assert equations_text(one, "text").strip() == "q1_ddot = tau1 - d1*q1_dot - 9*d2*q1_dot"


@pytest.mark.parametrize(
    ("new", "fault"),
    [
        ("armature = -0.1", "scene.toml: joints.wrist: armature = -0.1 is negative; give zero or more"),
        (
            "rotor = { inertia = -0.1, gear = 3 }",
            "scene.toml: joints.wrist: rotor: inertia = -0.1 is negative; give an inertia of zero or more",
        ),
    ],
    ids=["armature", "rotor"],
)
def test_a_negative_armature_is_told_once(new, fault):
    with pytest.raises(SceneError, match="is negative") as caught:
        read_text(HAND.replace("armature = 0.1", new, 1))
    assert placeless(caught.value) == fault
