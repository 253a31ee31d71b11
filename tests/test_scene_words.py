"""Every joint, spring, damper, load and row: what its words mean, what becomes of them, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
from wide import everything

from symdyn.errors import SceneError
from symdyn.graph import Graph
from symdyn.scene import (
    Quantity,
    bind,
    body,
    lock,
    parse,
    read_noting,
    read_text,
    revolute,
    scene,
    with_symbolic_inertia,
    with_symbols,
    write_text,
)
from symdyn.scene.declaration.draft import draft_of, uses
from symdyn.scene.forces import FORCES
from symdyn.scene.forces.applied_forces import Friction
from symdyn.scene.forces.constraints import linear_parts
from symdyn.scene.joints import JOINTS
from symdyn.scene.joints.joint_table import start_of
from symdyn.scene.values import Place

WIDE = everything()


def named(kind, name, one=WIDE):
    return next(thing for thing in getattr(one, kind) if thing.name == name)


def test_the_wide_scene_holds_every_joint_and_every_noun():
    joints = {joint.type for joint in WIDE.joints}
    assert joints == set(JOINTS) - {"fixed"}, "declare one at the end of the joints of tests/wide.py"
    assert WIDE.loops
    rubbing = {joint.dry.kind for joint in WIDE.joints if joint.dry}
    declared = {name for name, kind in FORCES.items() if kind.section != "joints"}  # the others runs make of joints
    assert {one.kind for one in WIDE.elements} | rubbing == declared, "declare one in tests/wide.py"


def test_every_word_reads_back():
    text = write_text(WIDE, "toml").text

    assert read_text(text) == WIDE
    assert write_text(read_text(text), "toml").text == text


def test_coordinates_and_drives_are_counted_over_the_scene():
    assert named("joints", "c1").coordinates == ("q4", "q5")
    assert named("joints", "c1").drives == ("M", None)
    assert named("joints", "s1").coordinates == ("q8", "q9", "q10", "q11")
    assert named("joints", "s1").drives == (None,) * 3
    assert named("joints", "s2").drives == ("tau11", "tau12", "tau13")
    assert len(WIDE.coordinates) == len(WIDE.velocities) + 3


def test_velocities_of_a_quaternion_are_named_after_the_joint():
    assert named("joints", "s1").rates == ("s1_wx", "s1_wy", "s1_wz")
    assert named("joints", "f1").rates == ("f1_vx", "f1_vy", "f1_vz", "f1_wx", "f1_wy", "f1_wz")
    assert named("joints", "l1").rates == ("x_dot", "l1_wx", "l1_wy", "l1_wz")
    assert named("joints", "f2").velocities == ()


def test_the_start_of_a_quaternion_is_no_rotation():
    by_name = dict(zip(WIDE.coordinates, start_of(WIDE).position, strict=True))
    rates = dict(zip(WIDE.velocities, start_of(WIDE).velocity, strict=True))

    assert [by_name[name] for name in named("joints", "f1").coordinates] == [
        Quantity.number(x) for x in (0, 0, 0, 1, 0, 0, 0)
    ]
    assert [by_name[f"q{k}"] for k in range(8, 12)] == [Quantity.number(Fraction(1, 2))] * 4
    assert by_name["q3"] == parse("pi/3")
    assert (by_name["x"], by_name["e0"], by_name["e1x"]) == (Quantity.number(0), Quantity.number(1), Quantity.number(0))
    assert (rates["f1_wx"], rates["f1_vx"], rates["q3_dot"]) == (
        Quantity.number(1),
        Quantity.number(0),
        Quantity.number(2),
    )


def test_a_rotor_behind_a_gear_is_seen_with_the_square_of_its_ratio():
    assert named("joints", "r1").armature == Quantity.number(Fraction(5, 2))


def test_friction_as_a_number_is_data_and_as_a_table_enters_the_equations():
    one = named("joints", "p1")

    assert one.dry == Friction(
        "p1", Quantity.number(1), Quantity.number(2), Quantity.number(Fraction(1, 5)), Quantity.number(Fraction(1, 100))
    )
    assert one.friction == Quantity.number(0)
    assert (named("joints", "gear").friction, named("joints", "gear").dry) == (Quantity.number(3), None)


def test_an_end_is_a_body_a_named_point_or_a_place():
    assert named("elements", "s_line").ends == (
        Place("b", (Quantity.number(0), parse("r"), Quantity.number(0))),
        Place("l", (Quantity.number(0), parse("r"), Quantity.number(0))),
    )
    assert named("elements", "d_line").ends == (
        Place("ground", (Quantity.ONE, Quantity.ZERO, Quantity.ZERO)),
        Place("c", tuple(Quantity.number(k) for k in (1, 2, 3))),
    )


def test_a_joint_may_follow_one_coordinate_of_several():
    assert named("joints", "gear").coupling.coordinates == ("alpha",)
    assert named("joints", "gear").coupling.ratios == (("alpha", Quantity.number(-2)),)


def test_the_checks_look_at_every_quantity():
    """All but parameter values and the directions of axes, which are checked by themselves."""
    for one in (WIDE, with_symbols(WIDE, "all")):
        axes = {
            x for joint in (*one.joints, *one.loops) for _, way in JOINTS[joint.type].directions(joint) for x in way
        }
        axes |= {x for row in one.contacts for x in (*(row.axis or ()), *row.plane.normal)}
        seen = {use.quantity for use in uses(draft_of(one))}
        plain = (replace(x, flux=x.rate or Quantity.ZERO) if x.kind == "flow" else x for x in one.elements)
        held = set(Quantity.inside(replace(one, parameters=(), elements=tuple(plain))))  # what follows from rates apart
        assert held - axes <= seen <= held


def test_names_for_numbers_leave_the_values_as_they_are():
    one = with_symbols(WIDE, "all")
    values = {parameter.name: parameter.value for parameter in one.parameters if parameter.value is not None}
    graph = Graph()

    back = bind(one, {})
    numbers = [x for joint in one.loops for _, x in joint.shape if isinstance(x, Quantity)]
    for element in one.elements:
        numbers += [x.quantity for part in FORCES[element.kind].parts for x in part.numbers(element)]

    assert back == one
    assert all(quantity.symbols or quantity.express(graph).is_zero for quantity in numbers)
    assert values["Fz2"] == Quantity.number(9)
    assert named("loops", "ring4", one).shape[1][1].symbols == ("h_o4",)
    assert values["h_o4"] == Quantity.number(Fraction(1, 50))


def test_symbolic_inertia_keeps_the_parameters_that_anything_else_uses():
    one = with_symbolic_inertia(WIDE)

    assert {"k", "r"} <= {parameter.name for parameter in one.parameters}
    assert "m" not in {parameter.name for parameter in one.parameters}


def test_what_is_bound_to_zero_is_zero_everywhere():
    one = bind(WIDE, {"k": 0})

    assert named("elements", "s_joint", one).stiffness == (Quantity.number(0),) * 3
    assert named("elements", "wind", one).force[0] == Quantity.number(0)
    assert named("elements", "d_line", one).damping == (Quantity.number(0),)
    assert "k" not in {name for q in Quantity.inside(replace(one, parameters=())) for name in q.symbols}


def test_a_rod_bound_to_no_length_is_refused():
    with pytest.raises(SceneError, match=r"rod1: length = 0 is that of no rod"):
        bind(replace(WIDE, elements=()), {"r": 0})


def test_locked_joints_take_their_springs_with_them():
    one = lock(
        WIDE,
        {
            "r1": Quantity.number(0),
            "s1": Quantity.number(0),
            "rod1": Quantity.number(0),
            "cam": parse("pi/2"),
            "h1": parse("pi"),
        },
    )

    assert [one.name for one in one.struts if one.kind == "spring"] == ["s_line", "constant"]
    assert named("joints", "rod1", one).origin.steps == (("Tz", parse("r")),)
    assert named("joints", "cam", one).origin.steps == (("Rz", parse("pi/2")), ("Tx", parse("r*sin(pi/2)")))
    (turn, angle), (slide, way) = named("joints", "h1", one).origin.steps
    assert (turn, angle, slide) == ("Rz", parse("pi"), "Tz")
    assert way.express(graph := Graph()) is parse("r/200").express(graph)
    assert named("constraints", "slip", one).formula == parse("x_dot*cos(pi/2) - r*(0 - 2*alpha_dot)")
    assert read_text(write_text(one, "toml").text) == one


def test_a_joint_of_several_coordinates_is_locked_at_zero_only():
    with pytest.raises(SceneError, match=r"joints\.u1: has 2 coordinates and is locked at zero only"):
        lock(WIDE, {"u1": Quantity.number(1)})


ROWS = [
    ("a_dot", {"a_dot": "1"}, "0"),
    ("x*a_dot - (b_dot + a_dot)/y", {"a_dot": "x - 1/y", "b_dot": "-1/y"}, "0"),
    ("-(2*a_dot + x)*3", {"a_dot": "-6"}, "-(x*3)"),
    ("a_dot*b_dot", None, None),
    ("sin(a_dot)", None, None),
    ("x/a_dot", None, None),
    ("a_dot**2", None, None),
]


@pytest.mark.parametrize(("formula", "slopes", "rest"), ROWS)
def test_a_formula_is_split_into_what_each_velocity_multiplies(formula, slopes, rest):
    velocities = ("a_dot", "b_dot")
    if slopes is None:
        with pytest.raises(SceneError, match=r"multiplies velocities|is no sum"):
            linear_parts(parse(formula), velocities)
        return
    found, alone = linear_parts(parse(formula), velocities)
    graph = Graph()
    assert set(found) == set(slopes)
    for name, slope in slopes.items():
        assert (found[name].express(graph) - parse(slope).express(graph)).is_zero
    assert (alone.express(graph) - parse(rest).express(graph)).is_zero


BASE = """\
[parameters]
m = 1
[bodies.a]
mass = "m"
[bodies.b]
mass = 1
[joints.j]
type = "revolute"
parent = "ground"
child = "a"
[joints.k]
type = "TYPE"
parent = "a"
child = "b"
KEYS
"""

JOINT_FAULTS = [
    ("revolute", "pitch = 1", "pitch = 1 has no meaning for a revolute joint; leave it out"),
    ("spherical", "axis = [0, 0, 1]", "axis = [0, 0, 1] has no meaning for a spherical joint; leave it out"),
    ("helical", "", "pitch is missing; write pitch = 0.01, the advance a turn in metres"),
    ("rod", "length = 0", "length = 0 is that of no rod; give the distance of its ends, or write a spherical joint"),
    ("rod", "", "length is missing; write length = 0.5, the distance of its ends in metres"),
    ("universal", "second_axis = [0, 0, 3]", "second_axis = [0, 0, 3] is parallel to axis"),
    ("universal", 'axis = [1, 1, 0]\nsecond_axis = ["sqrt(2)", "2/sqrt(2)", 0]', "is parallel to axis"),
    ("universal", "second_axis = [0, 0, 0]", "second_axis = [0, 0, 0] has zero length"),
    ("spherical", 'orientation = "zzx"', 'orientation = "zzx" is neither "quaternion" nor three axes of which no two'),
    ("spherical", 'orientation = "xyw"', 'orientation = "xyw" is neither'),
    ("spherical", "start = [0, 0, 0, 0]", "start: the quaternion (w, x, y, z) has zero length"),
    ("free", "start = [1, 0, 0, 0, 0, 0, 0]", "start: the quaternion (w, x, y, z), entries 4 to 7, has zero length"),
    ("spherical", "start = [1, 0, 0]", "start = [1, 0, 0] is 3 numbers; a spherical joint has 4 coordinates"),
    ("spherical", "start_rates = 1", "start_rates = 1 is one number; a spherical joint has 3 velocities"),
    ("cylindrical", 'start = ["q1", 0]', "start[0] = q1 uses q1, which moves"),
    ("cylindrical", 'coordinates = ["x"]', 'coordinates = ["x"] has 1 names; a cylindrical joint has 2 coordinates'),
    ("cylindrical", 'coordinate = "x"', 'coordinate = "x" has 1 names; a cylindrical joint has 2 coordinates'),
    (
        "cylindrical",
        "coordinates = [1, 2]",
        'coordinates: 1 is not text; put it in quotes, such as coordinates = ["q2"',
    ),
    ("cylindrical", 'coordinates = ["x", "x"]', '"x" is already the name of joints.k (coordinate)'),
    ("cylindrical", 'drives = ["M"]', 'drives = ["M"] has 1 entries; a cylindrical joint has 2 velocities'),
    ("cylindrical", "drives = [1, false]", "drives: 1 is no name, nor true or false"),
    ("cylindrical", "force = 3", "force = 3 is one number; a cylindrical joint has 2 velocities"),
    ("cylindrical", "armature = 3", "armature = 3 has no meaning for a cylindrical joint, which has 2 velocities"),
    ("spherical", "rotor = { inertia = 1 }", "rotor = {inertia = 1} has no meaning for a spherical joint, which has 3"),
    ("free", "armature = 3", "armature = 3 has no meaning for a free joint, which has 6 velocities"),
    ("spherical", "friction = { coulomb = 1 }", "friction is a table, which has no meaning for a spherical joint"),
    ("spherical", 'mimic = { joint = "j" }', 'mimic = {joint = "j"} has no meaning for a spherical joint'),
    ("spherical", 'motion = "t"', 'motion = "t" has no meaning for a spherical joint, which has 3 velocities'),
    ("revolute", 'drive = false\nmotion = "t"', "motion = t prescribes what no drive can hold: the joint is passive"),
    ("revolute", 'motion = "q1"', "motion = q1 uses q1, which moves"),
    ("revolute", "coordinate = 'x'\ncoordinates = ['x']", "coordinate and coordinates give the same quantity"),
    ("revolute", "armature = 1\nrotor = { inertia = 1 }", "armature and rotor give the same quantity"),
    ("revolute", "rotor = { gear = 1 }", "rotor: inertia is missing"),
    ("revolute", "rotor = { inertia = -1 }", "rotor: inertia = -1 is negative"),
    ("revolute", "rotor = { inertia = 1, gear = 0 }", "rotor: gear = 0 turns no rotor"),
    ("revolute", "friction = { static = 1 }", "friction: coulomb is missing"),
    ("revolute", "friction = { coulomb = -1 }", "friction.coulomb = -1 is negative; give zero or more"),
    ("revolute", "friction = { coulomb = 1, stribeck = 0 }", "friction.stribeck = 0 is no rate; give one above zero"),
    ("revolute", 'coordinate = "t"', 'coordinate = "t" is the time in formulas and runs; rename it, such as t_0'),
    ("revolute", 'damping = "t"', "damping = t uses t, the time; only forces, loads and prescribed motions may depend"),
    ("custom", 'coordinates = ["u"]', "steps is missing"),
    ("custom", 'steps = [["Rz", "u"]]\ncoordinate = "u"', 'units is missing; write "rad" or "m" for each coordinate'),
    ("custom", 'steps = [["Rz", "u"]]\nunits = ["rad"]', "coordinates is missing; name those that its steps use"),
    ("custom", 'steps = [["Rz", "w"]]\nunits = ["rad"]\ncoordinate = "u"', "steps.Rz = w uses the undefined symbol w"),
    ("custom", 'steps = [["Rz", "q1"]]\nunits = ["rad"]\ncoordinate = "u"', "steps.Rz = q1 uses q1, which moves"),
    ("custom", 'steps = [["Rz", "u"]]\nunits = ["deg"]\ncoordinate = "u"', 'units = ["deg"] is not a list of one to'),
    ("fixed", "damping = 1", "damping = 1 has no meaning for a fixed joint; leave it out"),
]


@pytest.mark.parametrize(("kind", "keys", "expected"), JOINT_FAULTS)
def test_what_a_joint_cannot_mean_is_refused(kind, keys, expected):
    with pytest.raises(SceneError) as caught:
        read_text(BASE.replace("TYPE", kind).replace("KEYS", keys))

    assert any(
        f"joints.k: {expected}" in line or (expected in line and "joints.k" in line) for line in caught.value.faults
    )


@pytest.mark.parametrize("friction", ["{ coulomb = 1 }", "{ coulomb = 1, smoothing = 0 }"])
def test_ideal_friction_may_be_declared(friction):
    one = read_text(BASE.replace("TYPE", "revolute").replace("KEYS", f"friction = {friction}"))

    assert one.joints[1].dry == Friction(one.joints[1].name, Quantity.number(1))


MORE = BASE.replace("TYPE", "cylindrical").replace("KEYS", "")

LOAD_FAULTS = [
    ("springs.s", "stiffness = 1", "has neither joint nor from and to; write joint"),
    ("springs.s", 'joint = "j"', "stiffness is missing; write stiffness = 100"),
    ("springs.s", 'joint = "j"\nfrom = "a"\nstiffness = 1', "has joint and from; write joint"),
    ("springs.s", 'joint = "k"\nstiffness = 1', 'joint = "k" has 2 coordinates; name one with one, or two points'),
    ("springs.s", 'joint = "l"\nstiffness = 1', 'joint = "l" is not a joint of the tree; known are j, k'),
    ("springs.s", 'from = "a"\nto = "c"\nstiffness = 1', 'to = "c" is neither a body nor a point; '),
    ("springs.s", 'from = "a"\nto = { body = "a", at = [1, 0, 0] }\nstiffness = 1', "from and to are on one body"),
    ("springs.s", 'from = "ground"\nto = "a"\nstiffness = 1', "an end lies where j does not move it, so"),
    ("springs.s", 'from = "a"\nto = 3\nstiffness = 1', "to = 3 is no end"),
    ("springs.s", 'joint = "j"\nstiffness = []', "stiffness = [] holds no number"),
    ("springs.s", 'joint = "j"\nstiffness = "t"', "stiffness = t uses t, the time"),
    ("springs.s", 'joint = "j"\nstifness = 1', 'unknown key "stifness"; did you mean stiffness?'),
    ("dampers.d", 'joint = "j"', "damping is missing"),
    ("dampers.d", 'joint = "j"\ndamping = -2', "damping = -2 is negative; give zero or more"),
    ("loads.w", 'body = "a"', "has neither force nor couple"),
    ("loads.w", "force = [0, 0, 1]", "give body and at, or point"),
    ("loads.w", 'body = "c"\nforce = [0, 0, 1]', 'body = "c" is not a body; '),
    ("loads.w", 'body = "ground"\nforce = [0, 0, 1]', "acts on ground, which does not move; name a body"),
    ("loads.w", 'point = "p"\nforce = [0, 0, 1]', 'point = "p" is not a point'),
    ("loads.w", 'body = "a"\nforce = [0, 0, "q9"]', "force[2] = q9 uses the undefined symbol q9"),
    ("loads.w", 'body = "a"\nat = ["t", 0, 0]\nforce = [0, 0, 1]', "at[0] = t uses t, the time"),
    ("loads.w", 'body = "a"\nforce = [0, 0, 1]\nframe = "world"', 'frame = "world" is not known'),
    ("constraints.r", "", "formula is missing"),
    ("constraints.r", 'formula = "q1_dot*q2_dot"', "not linear in the velocities: q1_dot*q2_dot multiplies velocities"),
    ("constraints.r", 'formula = "q1_dot - 1"', "holds -1, which no velocity multiplies"),
    ("constraints.r", 'formula = "q1"', "holds q1, which no velocity multiplies"),
    ("constraints.r", 'formula = "q1 - q1"', "holds no velocity"),
    ("constraints.r", 'formula = "t*q1_dot"', "uses t, the time"),
    ("constraints.r", 'type = "sliding"', 'type = "sliding" is not a constraint; '),
    ("constraints.r", 'type = "knife_edge"\nbody = "a"', "axis is missing"),
    ("constraints.r", 'type = "rolling"\nbody = "a"\naxis = [0, 0, 0]\nradius = 1', "axis = [0, 0, 0] has zero length"),
    ("constraints.r", 'type = "rolling"\nbody = "a"\naxis = [0, 1, 0]\nradius = 0', "radius = 0 is that of no wheel"),
    ("constraints.r", 'type = "rolling"\nbody = "a"\naxis = [0, 1, 0]', "radius is missing"),
    ("constraints.r", 'type = "rolling"\nbody = "a"\naxis = [0, 1, 0]\nradius = 1\ncomponents = ["z"]', "components ="),
]  # fmt: skip


@pytest.mark.parametrize(("where", "keys", "expected"), LOAD_FAULTS)
def test_what_a_load_cannot_mean_is_refused(where, keys, expected):
    with pytest.raises(SceneError) as caught:
        read_text(f"{MORE}\n[{where}]\n{keys}\n")

    assert any(f"{where}: " in line and expected in line for line in caught.value.faults), caught.value.faults


def test_all_faults_come_together():
    text = MORE + '[springs.s]\njoint = "x"\n[loads.w]\nbody = "z"\nforce = [1, 2]\n[[loop]]\ntype = "rod"\n'

    with pytest.raises(SceneError) as caught:
        read_text(text)

    assert len(caught.value.faults) >= 7


def test_time_has_no_place_in_a_mass():
    with pytest.raises(
        SceneError, match=r'mass = t uses t; a mass or an inertia changes by a state: write mass = "m_a"'
    ):
        scene("x", bodies=[body("a", mass="t")], joints=[revolute("j", "ground", "a")])


@pytest.mark.parametrize(
    ("keys", "angle"),
    [
        ("start = 90", "90"),
        ("origin = { xyz = [0, 0, 1], rpy = [0, 0, -45] }", "-45"),
        ("limits = { lower = -30, upper = 30 }", "-30"),
        ("start = 14", ""),
        ('start = "90 deg"', ""),
        ("limits = { lower = -1000, upper = 1000 }", ""),
        ('start = "15 rad"', ""),
        ('limits = { lower = "-30 rad", upper = "30 rad" }', ""),
        ("limits = { lower = 0, upper = 60 }", ""),
        ("limits = { lower = -75, upper = 75 }", ""),
    ],
)
def test_degrees_where_radians_stand_are_noted(tmp_path, keys, angle):
    path = tmp_path / "s.toml"
    path.write_text(BASE.replace("TYPE", "revolute").replace("KEYS", keys))

    told = "".join(note for note in read_noting(path).notes if "in rad" in note)

    assert (f'the angle {angle} is in rad, many turns; in degrees write "{angle} deg"' if angle else "") in told
    assert bool(told) == bool(angle)


def test_plain_friction_is_noted_as_data_that_does_not_act(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(BASE.replace("TYPE", "revolute").replace("KEYS", "friction = 0.5"))

    (note,) = read_noting(path).notes
    assert "friction is kept as data and enters no equation" in note
    assert "friction = { coulomb = 0.5, smoothing = 0.01 }" in note

    path.write_text(BASE.replace("TYPE", "revolute").replace("KEYS", "friction = { coulomb = 1, smoothing = 0.1 }"))
    assert read_noting(path).notes == ()
