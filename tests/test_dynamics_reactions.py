"""Reactions in every joint: two formulations, laws, numbers of others, what is not unique, and generated code."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from arms import EXAMPLES, cart_pole, puma560, spatial_arm, three_link, two_link
from closed_mechanisms import bricard, crank_rocker, exact, four_bar, n_four_bar, rssr, slider_crank, symbolic_four_bar
from figure_5_39 import single_loop, vector
from mechanisms import coupled_tree, jointed, random_tree
from oracles import BIG, assert_digits, numbers, oracle
from running import call, solved_reactions

import symdyn
from symdyn.dynamics import Workspace, derive, derive_one
from symdyn.dynamics.outputs.unique_reactions import _closed, reactions_at
from symdyn.dynamics.reactions.dalembert import Equilibrium
from symdyn.errors import DerivationError
from symdyn.graph import substitute
from symdyn.scene import Quantity, Scene, parse
from symdyn.scene.forces.applied_forces import Damper, Friction, Spring
from symdyn.scene.toml import read_text
from symdyn.scene.values import Load, Place
from symdyn.teach import walkthrough
from symdyn.verdict import Verdict
from symdyn.verify.certificate import on_unit_sphere
from symdyn.verify.equality import Claim, prove
from symdyn.verify.laws import laws


def driven(one: Scene) -> Scene:
    """Return a scene with a drive in its first joint."""
    return replace(one, joints=(replace(one.joints[0], drives=("M",)), *one.joints[1:]))


JOINTED = [
    jointed("spherical", "rod"),
    jointed("free", "universal"),
    jointed("helical", "cylindrical", "custom"),
    jointed("planar", "point_on_line"),
    jointed("point_on_plane", "revolute", "fixed"),
    jointed("universal", "spherical", orientation="zyx"),
]
TREES = [
    two_link(),
    cart_pole(),
    spatial_arm(),
    *(random_tree(k, 4) for k in range(4)),
    coupled_tree(0),
    coupled_tree(1),
]
CLOSED = [crank_rocker(), symbolic_four_bar(), slider_crank(), single_loop(), driven(n_four_bar(2))]


def loaded() -> Scene:
    """A tree with a spring, damper and friction of every kind, and loads in both frames, one a formula in time."""
    tree = random_tree(3, 4)
    moving = [joint.name for joint in tree.joints if joint.moves]
    ends = (Place("b0", vector("1/10", "1/5", "3/10")), Place("b3", vector("2/5", 0, "1/3")))
    hook = (Place("ground", vector(1, 2, 3)), Place("b2", vector("1/2", 0, 0)))
    dry = Friction(moving[-1], Quantity.number(2), smoothing=Quantity.number(Fraction(1, 10)))
    return replace(
        tree,
        name="loaded",
        elements=(
            Spring("coil", joint=moving[0], stiffness=vector(3, 1), free=Quantity.number(1)),
            Spring("tie", ends=ends, stiffness=vector(5), free=Quantity.number(1), preload=Quantity.number(2)),
            Spring("hook", ends=hook, stiffness=vector(5)),
            Damper("pot", joint=moving[1], damping=vector(1, 2)),
            Damper("strut", ends=ends, damping=vector(2, 1)),
            Load(
                "push",
                Place("b3", vector(1, 0, 2)),
                (parse("2*t"), Quantity.number(1), Quantity.number(3)),
                vector(1, 2, 3),
            ),
            Load("jet", Place("b1"), vector(1, 2, 3), vector(3, 1, 2), "body"),
        ),
        joints=tuple(replace(j, dry=dry) if j.name == moving[-1] else j for j in tree.joints),
    )


def by_name(one):
    return one.name


def verdicts(scene, claims):
    return {finding.verdict for finding in prove(on_unit_sphere(scene, claims))[1]}


# The whole system (5.18) and the laws


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("one", [*TREES, *JOINTED, *CLOSED, rssr(), n_four_bar(2), bricard()], ids=by_name)
def test_recursion_solves_the_whole_system(one):
    outputs = ("reactions", "forward_dynamics", "multipliers") if one.loops else ("reactions",)
    claims = [claim for claim in laws(Workspace(one), outputs) if claim.right_name.startswith("equilibrium")]

    assert [claim.name for claim in claims] == ["reactions", "forward_reactions"][: 1 + bool(one.loops)]
    assert verdicts(one, claims) == {Verdict.PROVED}


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("one", [*TREES, *JOINTED, *CLOSED], ids=by_name)
def test_laws_of_reactions_are_proved(one):
    claims = list(laws(Workspace(one), ("reactions", "inverse_dynamics")))

    assert {claim.name for claim in claims} == {"reactions", "drives in reactions", "power of reactions", "momentum"}
    assert verdicts(one, claims) == {Verdict.PROVED}


def test_springs_dampers_friction_and_loads_are_in_the_reactions():
    one = loaded()
    w = Workspace(one)
    claims = laws(w, ("reactions", "inverse_dynamics"))

    assert len(claims) == 4
    assert verdicts(one, claims) <= {
        Verdict.PROVED,
        Verdict.NUMERICAL,
    }  # a distance is a root, which fields cannot always tell
    assert [a.name for a in derive_one(w, "reactions").arguments] == ["q", "qd", "qdd", "t", "params"]


def test_a_reaction_that_is_off_breaks_every_law(monkeypatch):
    """A body heavier in the reactions than in the equations: no law holds any more."""
    from symdyn.dynamics.reactions import free_bodies as module

    one = two_link()
    real = module.needed
    monkeypatch.setattr(module, "needed", lambda inertia, motion: real(inertia + inertia, motion))

    assert verdicts(one, laws(Workspace(one), ("reactions", "inverse_dynamics"))) == {Verdict.DIFFERENT}


@pytest.mark.long
@pytest.mark.parametrize("one", [crank_rocker(), slider_crank(), single_loop()], ids=by_name)
def test_multipliers_of_lagranges_equations_are_the_reactions_of_the_cut_joint(one):
    """Lagrange with multipliers = D'Alembert, identically: off the closed positions too."""
    w = Workspace(one)
    system = Equilibrium.of(w.hanging, tau=w.state.tau, whole=True)
    motion = dict(zip(w.state.qdd, derive_one(w, "forward_dynamics", "lagrange").entries, strict=True))
    last, places = len(system.unknowns), {(u.joint, u.number): k for k, u in enumerate(system.unknowns)}
    rows = system.rows()
    found = iter(substitute([entry for row in rows for entry in row.values()], motion))
    rows = [{c: next(found) for c in row} for row in rows]
    labels = [w.loops.recursive.labels[k] for k in w.loops.decisions.independent_rows]
    for label, size in zip(labels, derive_one(w, "multipliers", "lagrange").entries, strict=True):
        rows.append({places[label.owner, label.number]: w.graph.one, last: size})

    assert verdicts(one, [Claim.solvable("cut", "lambda", "(5.18)", rows, last)]) == {Verdict.PROVED}
    rows[-1][last] = 2 * rows[-1][last]
    assert verdicts(one, [Claim.solvable("cut", "lambda", "(5.18)", rows, last)]) == {Verdict.DIFFERENT}


def test_nothing_goes_through_the_free_joint_of_a_rolling_disc():
    """All that keeps the disc up and rolling acts in its contact with the ground, not in a joint that takes nothing."""
    w = Workspace(symdyn.read(EXAMPLES / "rolling_disc.toml"))
    idle = dict.fromkeys(w.state.tau, w.graph.zero)
    found = tuple(substitute(derive_one(w, "forward_reactions").entries, idle))

    assert any(not entry.is_zero for entry in found)  # it does not vanish at birth
    zeros = (w.graph.zero,) * 6
    assert verdicts(w.scene, [Claim("flight", "R", "0", found, zeros)]) <= {Verdict.PROVED, Verdict.NUMERICAL}


def test_axes_of_body_joint_and_ground_tell_one_wrench():
    one = random_tree(1, 4)
    w = Workspace(one)
    body, joint, ground = (derive_one(w, f"reactions{axes}").entries for axes in ("", ":joint", ":ground"))

    def squares(entries):
        return tuple(w.graph.total(x * x for x in entries[k : k + 3]) for k in range(0, len(entries), 3))

    assert verdicts(one, [Claim("size", "body", "joint", squares(body), squares(joint))]) == {Verdict.PROVED}
    assert verdicts(one, [Claim("size", "body", "ground", squares(body), squares(ground))]) == {Verdict.PROVED}
    assert verdicts(one, [Claim("entries", "body", "ground", body, ground)]) == {Verdict.DIFFERENT}


def test_a_fixed_joint_is_a_section():
    """A bar cut at any place x carries there what is beyond it: shear m g (1 - x) and moment m g (1 - x)²/2."""
    x = Fraction(3, 10)

    def bar(name, length):
        third = Quantity.number(3 * length**3 / 36)  # m l²/12, 3 kg/m
        return symdyn.scene.values.Body(
            name,
            Quantity.number(3 * length),
            vector(length / 2, 0, 0),
            None,
            (Quantity.number(0), third, third, *(Quantity.number(0),) * 3),
        )

    one = Scene(
        "cut",
        gravity=vector(0, "-9.81", 0),
        bodies=(bar("near", x), bar("far", 1 - x)),
        joints=(
            symdyn.scene.values.Joint("pin", "revolute", "ground", "near", coordinates=("q",)),
            symdyn.scene.values.Joint(
                "section", "fixed", "near", "far", origin=symdyn.scene.values.Pose((("Tx", Quantity.number(x)),))
            ),
        ),
    )
    found = call(derive(one, ["reactions"]), "reactions", BIG, q=[0], qd=[0], qdd=[0])

    weight = Fraction("9.81") * 3 * (1 - x)
    expected = [0, weight, 0, 0, 0, weight * (1 - x) / 2]
    assert all(abs(a - BIG.constant(Fraction(b))) < 1e-50 for a, b in zip(found[6:], expected, strict=True))


# Numbers of others


def rows_of(found):
    return [found[k : k + 6] for k in range(0, len(found), 6)]


FORMULATIONS = {
    "recursive": lambda one, axes, *given, **state: call(
        derive(one, [f"reactions:{axes}"]), f"reactions_{axes}", *given, **state
    ),
    "dalembert": solved_reactions,
}


@pytest.mark.parametrize("case", oracle("two_link_point_mass")["cases"], ids=lambda case: "_".join(case["q"])[:20])
@pytest.mark.parametrize("formulation", ["recursive", "dalembert"])
def test_joint_forces_of_the_two_link_arm(case, formulation):
    given = {key: numbers(case[key]) for key in ("q", "qd", "qdd")}
    params = numbers(case[name] for name in ("m1", "m2", "h1", "h2", "g"))
    found = rows_of(FORMULATIONS[formulation](two_link(), "ground", BIG, **given, params=params))

    assert_digits(found[0][:2], case["joint1_force_on_link1_xy"])
    assert_digits(found[1][:2], case["joint2_force_on_link2_xy"])
    assert_digits([row[5] for row in found], case["tau"])  # drives included
    assert all(abs(row[k]) < 1e-40 for row in found for k in (2, 3, 4))


def test_moments_about_the_axes_of_the_published_three_link_arm():
    """Modern Robotics, chapter 8: InverseDynamics, with the wrench (1, …, 1) that the tip exerts, moment and force."""
    arm, root = oracle("modern_robotics_3link"), BIG.context.sqrt(2)
    turns = [root, BIG.number(1), BIG.number(1)]  # the published first axis is (1, 0, 1)
    place = Place("link3", vector("0.39225", "0.01615", "0.000159"))
    push = vector(-1, -1, 1)  # -(1, 1, 1) in the tip's axes, which are turned by 90° about y
    one = replace(three_link(), elements=(Load("tip", place, push, push, "body"),))
    state = {
        key: [turn * x for turn, x in zip(turns, numbers(arm["data"][key].split()), strict=True)]
        for key in ("q", "qd", "qdd")
    }
    rows = rows_of(call(derive(one, ["reactions:joint"]), "reactions_joint", BIG, **state))

    axes = [(1 / root, 0, 1 / root), (0, 1, 0), (0, 1, 0)]
    torque = [sum(a * m for a, m in zip(axis, row[3:], strict=True)) for axis, row in zip(axes, rows, strict=True)]
    found = [turn * t for turn, t in zip(turns, torque, strict=True)]
    assert_digits(found, arm["ours"]["ID"], "1e-27")
    assert_digits(found, arm["published"]["ID"], "1e-9")


NAMES = ("F_ground_on_crank", "F_crank_on_coupler", "F_ground_on_rocker", "F_coupler_on_rocker")


def four_bar_case(case):
    """Return the scene of a case, and its state in big floats."""
    lengths = [exact(case[name]) for name in ("a_crank", "b_coupler", "c_rocker", "d_ground")]
    one = four_bar(*lengths, tuple(exact(m) for m in case["masses"]))
    state = {}
    for key, names in (
        ("q", ("q", "coupler_angle", "rocker_angle")),
        ("qd", ("qd", "coupler_rate", "rocker_rate")),
        ("qdd", ("qdd", "coupler_acc", "rocker_acc")),
    ):
        first, coupler, rocker = numbers(case[name] for name in names)
        state[key] = [first, coupler - first, rocker]
    return one, state


@pytest.mark.parametrize("case", oracle("fourbar_reactions")["cases"], ids=lambda case: f"{case['name']}_{case['q']}")
@pytest.mark.parametrize("formulation", ["recursive", "dalembert"])
def test_pin_forces_of_the_four_bar_change_point_included(case, formulation):
    one, state = four_bar_case(case)
    rows = rows_of(FORMULATIONS[formulation](one, "ground", BIG, **state))

    for name, row in zip(NAMES, rows, strict=True):
        assert_digits(row[:2], case[name], "1e-28")
        assert all(abs(x) < 1e-30 for x in row[2:5])  # rods in the plane: nothing acts across it
    assert_digits([rows[0][5]], [case["tau"]], "1e-28")


# Generated code


@pytest.mark.wide("reactions-two_link", "forward_reactions:joint-four_bar", "reactions-coupled1")
@pytest.mark.runs
@pytest.mark.parametrize("one", [two_link(), crank_rocker(), single_loop(), coupled_tree(1, 4)], ids=by_name)
@pytest.mark.parametrize("output", ["reactions", "forward_reactions:joint"])
def test_generated_code_gives_the_reactions(one, output):
    function = derive(one, [output]).functions[0]
    rng = np.random.default_rng(3)
    state = [rng.uniform(0.2, 0.9, len(argument.symbols)) for argument in function.arguments]
    named = {
        a.name: [BIG.number(repr(float(x))) for x in values]
        for a, values in zip(function.arguments, state, strict=True)
    }
    expected = np.array([float(x) for x in call(derive(one, [output]), function.name, BIG, **named)]).reshape(-1, 6)

    from symdyn.emit import emit
    from symdyn.runtime import build, run_python

    program = symdyn.program.lower(derive(one, [output]))
    for module in (run_python(emit(program, "numpy")), build(program)):
        found = getattr(module, function.name)(*state)
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("one", [two_link(), crank_rocker()], ids=by_name)
def test_reactions_cost_nothing_where_nobody_asks(one):
    from symdyn.dynamics import available

    assert not [name for name in available(one)[0] if "reactions" in name]
    assert not [function.name for function in derive(one).functions if "reactions" in function.name]


def test_forces_of_bodies_are_not_regrouped():
    """The mass of the last link of a PUMA is in its base parameters nowhere, and in its reaction."""
    one = replace(puma560(), parameters=(symdyn.scene.values.Parameter("load"),))
    heavier = replace(one.bodies[-1], mass=symdyn.scene.Quantity.symbol("load"))
    one = replace(one, bodies=(*one.bodies[:-1], heavier))
    (weight,) = derive(one, ["reactions:ground"]).functions
    found = call(derive(one, ["reactions:ground"]), weight.name, BIG, q=[0] * 6, qd=[0] * 6, qdd=[0] * 6, params=[7])

    assert abs(rows_of(found)[-1][2] - BIG.number("68.67")) < 1e-50


# What is not unique


def in_floats(case):
    one, state = four_bar_case(case)
    return one, {key: [float(x) for x in values] for key, values in state.items()}


def test_a_row_that_forbids_nothing_has_a_force_that_nothing_tells():
    one = read_text(
        'name = "idle"\n[joints.a]\ntype = "revolute"\nparent = "ground"\nchild = "b"\naxis = [0, 1, 0]\n'
        'coordinate = "q1"\n[bodies.b]\nparticles = [{ mass = 1, at = [0.3, 0, 0] }]\n'
        '[constraints.r]\nformula = "0*q1_dot"\n'
    )
    found = reactions_at(one, [0.1])

    assert found.words == ("r: force of the row is not unique",)
    assert found.unique.all()
    system = Equilibrium.of(Workspace(one).hanging)
    assert "r" not in {system.unknowns[u].joint for _, u in system.blocks}
    assert walkthrough(one, formulation="dalembert").sections


def test_across_the_plane_a_four_bar_is_three_times_overconstrained():
    case = oracle("fourbar_reactions")["cases"][0]
    one, state = in_floats(case)
    found = reactions_at(one, **state)

    assert (found.equations, found.rank, found.redundancy) == (18, 18, 3)
    loose = {"force along z", "moment about x", "moment about y"}
    assert {(c.joint, c.text) for c in found.components if not c.unique} == {(j, t) for j in "ABCD" for t in loose}
    assert "C: force along z is not unique" in found.words
    assert found.unique.tolist() == [[True, True, False, False, False, True]] * 4
    forces = derive(one, ["reactions"])
    expected = np.array([float(x) for x in call(forces, "reactions", BIG, **four_bar_case(case)[1])]).reshape(-1, 6)
    np.testing.assert_allclose(found.wrenches, expected, atol=1e-10)
    drive = next(c for c in found.components if c.text == "drive tau")
    assert drive.value == pytest.approx(float(case["tau"]), rel=1e-12)


def test_the_least_reactions_depend_on_the_length_and_unique_ones_do_not():
    """A weight across the plane: what the four bearings share depends on how a moment counts against a force."""
    one, state = in_floats(oracle("fourbar_reactions")["cases"][0])
    one = replace(one, gravity=vector(0, "-9.81", "-9.81"))
    short, long = (reactions_at(one, **state, length=length) for length in (0.1, 10.0))

    assert short.possible
    assert long.possible
    assert not np.allclose(short.wrenches[~short.unique], long.wrenches[~long.unique], rtol=1e-3)
    np.testing.assert_allclose(short.wrenches[short.unique], long.wrenches[long.unique], rtol=1e-9, atol=1e-9)
    values = {(c.joint, c.text): c.value for c in short.components if c.text == "force along z"}
    assert values["A", "force along z"] + values["D", "force along z"] == pytest.approx(9.81 * 7.5)  # still balanced


def bricard_position():
    from symdyn.dynamics.outputs.workspace import Workspace

    return [float(x) for x in Workspace(bricard()).loops.decisions.assembly.regular]


def test_bricards_linkage_has_one_redundant_reaction_and_its_code_says_so():
    one = bricard()
    q = bricard_position()
    found = reactions_at(one, q)

    assert found.redundancy == 1
    assert found.words
    function = derive(one, ["reactions"])["reactions"]
    assert function.unique == tuple(found.unique.ravel().tolist())
    assert "not unique" in function.text
    R = symdyn.lambdify(one, "reactions")(q, [0.0] * 5, [0.0] * 5)
    np.testing.assert_allclose(R[found.unique], found.wrenches[found.unique], atol=1e-9)
    assert not np.allclose(R, found.wrenches, atol=1e-3)  # the least ones are others


def test_every_reaction_of_a_correct_spatial_mechanism_is_unique():
    one = single_loop()
    w = Workspace(one)
    q = [float(x) for x in w.loops.decisions.assembly.regular]
    found = reactions_at(one, q)

    assert (found.equations, found.rank, found.redundancy) == (18, 18, 0)
    assert found.words == ()
    assert found.unique.all()
    expected = derive(one, ["reactions"])
    still = {"qd": [0.0] * 6, "qdd": [0.0] * 6}
    from symdyn.algebra.numeric import Floats

    values = call(expected, "reactions", Floats(), q=q, **still)
    np.testing.assert_allclose(found.wrenches, np.array(values).reshape(-1, 6), atol=1e-9)


def test_an_idle_spin_leaves_the_reactions_unique():
    one = rssr()
    w = Workspace(one)
    found = reactions_at(one, [float(x) for x in w.loops.decisions.assembly.regular])

    assert found.redundancy == 0
    assert derive_one(w, "forward_reactions").shape == (4, 6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": [0.0]}, "q has 1 entries, the scene has 3"),
        ({"length": 0.0}, "a characteristic length is positive"),
        ({}, "parameter a has no value"),
    ],
)
def test_a_wrong_argument_is_named(change, message):
    one = symbolic_four_bar()
    given = {"q": [0.1, 0.2, 0.3], **change}
    if change:
        given["parameters"] = {p.name: 1.0 for p in one.parameters}
    with pytest.raises(DerivationError, match=message):
        reactions_at(one, **given)


def test_too_many_drives_are_told():
    one = crank_rocker()
    driven = replace(one, joints=tuple(replace(j, drives=(f"M{k}",)) for k, j in enumerate(one.joints)))
    with pytest.raises(
        DerivationError,
        match=r"reactions are not unique: over-actuated, 3 drives .M0 of A, M1 of B, M2 of D. for 1 degree",
    ):
        derive(driven, ["reactions"])
    assert derive(driven, ["forward_reactions"])["forward_reactions"].shape == (4, 6)


def test_an_open_position_is_left_as_it_is_and_told() -> None:
    scene = symdyn.example("four_bar")
    q = np.array([1.0, 2.0, 3.0])
    here, places, off = _closed(scene, q, {})
    assert here is q
    assert places == ()
    assert off > 0.01
