"""Names in place of numbers: their values are those numbers, so functions are the same; closed forms are readable."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from mechanisms import coupled_tree, random_tree

from symdyn.dynamics import derive
from symdyn.dynamics.closed_forms.closed_form import closed_form
from symdyn.emit.print.equations_text import equations_text
from symdyn.errors import SceneError
from symdyn.program import lower
from symdyn.runtime import lambdify
from symdyn.scene import Quantity, body, parse, prismatic, read, read_text, revolute, scene, with_symbols, write_text
from symdyn.scene.values import Parameter, spell
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

EXAMPLES = Path(__file__).parent.parent / "examples"
KINDS = ("inertia", "geometry", "all")
FUNCTIONS = ("inverse_dynamics", "mass_matrix", "kinetic_energy", "potential_energy")
SCENES = [read(EXAMPLES / f"{name}.toml") for name in ("arm7", "scara", "cart_pole", "puma560")]
SCENES += [random_tree(1, free=False), random_tree(2), random_tree(7), coupled_tree(1), coupled_tree(2)]


def by_name(one):
    return one.name


@cache
def bound(one):
    """Return the entries of every function with values in their place; no pass, which is proved on its own."""
    return [routine.function.entries for routine in lower(derive(one, FUNCTIONS), ()).routines]


@pytest.mark.wide(8)
@pytest.mark.long
@pytest.mark.parametrize("what", KINDS)
@pytest.mark.parametrize("one", SCENES, ids=by_name)
def test_with_its_values_bound_every_function_is_the_same(one, what):
    sides = [bound(one), bound(with_symbols(one, what))]
    claims = [Claim(name, "numbers", what, *pair) for name, *pair in zip(FUNCTIONS, *sides, strict=True)]

    assert {finding.verdict for finding in prove(claims)[1]} == {Verdict.PROVED}


def test_a_changed_value_changes_the_function():
    one, named = SCENES[1], with_symbols(SCENES[1], "inertia")
    heavier = tuple(replace(p, value=Quantity.number(10)) if p.name == "m2" else p for p in named.parameters)
    pair = [derive(s, ["mass_matrix"]) for s in (one, replace(named, parameters=heavier))]
    left, right = (lower(equations).routines[0].function.entries for equations in pair)

    assert prove([Claim("M", "as it was", "heavier", left, right)])[1][0].verdict != Verdict.PROVED


def test_built_code_takes_no_more_arguments():
    one = SCENES[1]
    q = np.array([0.1, 0.2, 0.3, 0.4])
    before, after = (lambdify(s, "mass_matrix")(q) for s in (one, with_symbols(one, "all")))

    assert np.allclose(before, after, rtol=1e-13)


@pytest.mark.parametrize("one", SCENES, ids=by_name)
def test_no_number_is_left_where_a_name_should_stand(one):
    named = with_symbols(one, "all")
    for joint in named.joints:
        for kind, amount in (*joint.origin.steps, *joint.tip.steps):
            assert amount.symbols or (kind.startswith("R") and re.fullmatch(r"-?(\d+\*)?pi(/2)?", spell(amount)))
        assert joint.armature == Quantity.number(0) or joint.armature.symbols
    for carried in named.bodies:
        for entry in (carried.mass, *(carried.com or carried.first_moment), *carried.inertia):
            assert entry.symbols or entry == Quantity.number(0)
    assert read_text(write_text(named, "toml").text) == named


def test_names_are_those_of_robotics():
    arm = scene(
        "arm",
        bodies=[
            body("base", mass=2, com=[0, 0, "0.5"]),
            body("rod", mass=1, com=["0.2", 0, 0], inertia=["0", "0.03", "0.03"], about="com"),
        ],
        joints=[
            prismatic("lift", "ground", "base", armature="0.4", damping="0.1"),
            revolute("turn", "base", "rod", origin=[("Tz", "0.3"), ("Rx", "pi/2"), ("Ry", "pi/6"), ("Tz", "-0.1")]),
        ],
    )
    named = with_symbols(arm, "all")

    assert {p.name: p.value for p in named.parameters} == {
        "m1": Quantity.number(2), "mz1": Quantity.number(1), "Ixx1": parse("0.5"), "Iyy1": parse("0.5"),
        "m2": Quantity.number(1), "mx2": parse("0.2"), "Iyy2": parse("0.07"), "Izz2": parse("0.07"),
        "Ia1": parse("0.4"), "d2": parse("0.3"), "beta2": parse("pi/6"), "d2_2": parse("0.1"),
        "fv1": parse("0.1"), "g": parse("9.81"),
    }  # fmt: skip
    assert named.joints[1].origin.steps == (
        ("Tz", Quantity.symbol("d2")), ("Rx", parse("pi/2")), ("Ry", Quantity.symbol("beta2")),
        ("Tz", -Quantity.symbol("d2_2"))
    )  # fmt: skip
    assert named.gravity == (Quantity.number(0), Quantity.number(0), -Quantity.symbol("g"))
    assert [p.name for p in named.parameters if p.positive] == ["m1", "m2", "Ia1", "d2", "d2_2", "fv1", "g"]
    assert {p.unit for p in named.parameters if p.name in ("Ia1", "fv1")} == {"kg", "N s/m"}


def test_formulas_and_zeros_stay():
    pole = SCENES[2]

    assert with_symbols(pole, "geometry").joints == pole.joints
    assert with_symbols(pole, "inertia") == pole
    assert with_symbols(with_symbols(SCENES[0], "all"), "all") == with_symbols(SCENES[0], "all")


def test_a_body_with_formulas_keeps_its_form():
    one = scene(
        "half",
        parameters={"m": None},
        bodies=[body("rod", mass="m", com=["-1/2", 0, "3*m"], inertia=[0, 3, 3], about="com", particles=[
            {"mass": 2, "at": [1, 0, 0]}
        ])],
        joints=[revolute("hinge", "ground", "rod")],
    )  # fmt: skip
    named = with_symbols(one, "inertia")
    values = {p.name: p.value for p in named.parameters}

    assert values == {
        "m": None, "m1": Quantity.number(2), "x1": parse("-1/2"), "Iyy1": Quantity.number(3),
        "Izz1": Quantity.number(3), "x1_2": Quantity.number(1)
    }  # fmt: skip
    assert named.bodies[0].com == (Quantity.symbol("x1"), Quantity.number(0), parse("3*m"))
    assert named.bodies[0].particles[0].mass == Quantity.symbol("m1")
    assert named.parameters[2].text == "inertia about the centre of mass, entry yy of rod"


def test_names_that_are_in_use_are_avoided():
    taken = scene(
        "taken",
        parameters={"m1": 3},
        bodies=[body("bob", mass=2, particles=[{"mass": "m1", "at": [1, 0, 0]}])],
        joints=[revolute("hinge", "ground", "bob", coordinate="m1_b", drive="mx1")],
    )
    named = with_symbols(taken, "inertia")

    assert [p.name for p in named.parameters] == ["m1", "m1_b_b"]  # m1_b is a coordinate
    assert named.bodies[0].mass == Quantity.symbol("m1_b_b")
    assert named.bodies[0].particles == taken.bodies[0].particles


def test_particles_of_numbers_are_taken_into_the_ten():
    one = scene(
        "dumbbell",
        bodies=[body("bell", mass=1, particles=[{"mass": 2, "at": [1, 0, 0]}, {"mass": 2, "at": [-1, 0, "1/2"]}])],
        joints=[revolute("hinge", "ground", "bell", axis=[0, 1, 0])],
    )
    named = with_symbols(one, "inertia")

    assert named.bodies[0].particles == ()
    assert {p.name: p.value for p in named.parameters} == {
        "m1": Quantity.number(5), "mz1": Quantity.number(1), "Ixx1": parse("1/2"), "Iyy1": parse("9/2"),
        "Izz1": Quantity.number(4), "Ixz1": Quantity.number(1),
    }  # fmt: skip


def test_a_closed_form_is_linear_in_the_inertia_names():
    named = with_symbols(SCENES[1], "inertia")
    inertial = {p.name for p in named.parameters} - {p.name for p in SCENES[1].parameters}
    closed = closed_form(named)

    for i in range(closed.n):
        for j in range(closed.n):
            text = closed.sympy("k_z", i, j).expand()
            found = [x for x in text.free_symbols if str(x) in inertial]
            assert all(text.diff(x, y) == 0 for x in found for y in found)
    assert str(closed.sympy("k_z", 2, 2)) == "m3 + m4"


def test_equations_of_numbers_print_with_names():
    pendulum = scene(
        "pendulum",
        bodies=[body("bob", mass=2, com=[0, "-0.5", 0])],
        joints=[revolute("hinge", "ground", "bob")],
        gravity=[0, "-9.81", 0],
    )

    assert equations_text(with_symbols(pendulum, "all"), "text").strip() == "Izz1*q1_ddot - my1*g*sin(q1) = tau1"


def test_an_unknown_kind_is_named():
    with pytest.raises(SceneError, match='symbols for "mass" are not known; known are inertia, geometry, all'):
        with_symbols(SCENES[0], "mass")


def test_gravity_in_two_directions_gets_two_names():
    tilted = replace(SCENES[1], gravity=(Quantity.number(1), Quantity.number(0), Quantity.number(Fraction("-9.81"))))
    added = with_symbols(tilted, "all").parameters[-2:]

    assert [(p.name, p.value) for p in added] == [("gx", Quantity.number(1)), ("gz", parse("9.81"))]
    assert isinstance(added[0], Parameter)
