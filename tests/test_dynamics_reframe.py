"""Frames of the generator's choice and base parameters: the same mechanism with fewer numbers in it."""

from __future__ import annotations

import random
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from arms import spatial_arm
from mechanisms import COUPLED, TREES

from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.closed_forms.frames_and_parameters import base_parameters
from symdyn.dynamics.mechanism.tree import settle, values_of
from symdyn.dynamics.recursive.links import GeneralTurn, PlanarTurn
from symdyn.dynamics.recursive.reduced_tree import reframe, regroup
from symdyn.errors import DerivationError
from symdyn.graph import Graph, Op, evaluate, gradient, reachable
from symdyn.scene import body, prismatic, read_text, revolute, scene
from symdyn.verdict import Verdict
from symdyn.verify.equality import Claim, prove

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))

from robots_dh import ROBOTS, robot, robot_scene

SCENES = [*TREES, *COUPLED[:3], spatial_arm()]


def entries(T):
    return (*T.R[0], *T.R[1], *T.R[2], *T.p)


@pytest.mark.parametrize("one", SCENES, ids=lambda one: one.name)
def test_factored_links_place_the_chosen_frames_where_they_say(one):
    tree = Workspace(one).tree
    reduced = reframe(tree)
    claims = [
        Claim(
            f"link {i}",
            "link",
            "declared",
            entries(reduced.moved[reduced.parent[i]] @ reduced.X[i].transform),
            entries(tree.T[i] @ reduced.moved[i]),
        )
        for i in reduced.outward()
    ]

    assert {found.verdict for found in prove(claims)[1]} == {Verdict.PROVED}


@pytest.mark.parametrize("one", SCENES, ids=lambda one: one.name)
def test_chosen_frames_have_z_along_their_joints(one):
    tree = Workspace(one).tree
    reduced = reframe(tree)
    for i in reduced.outward():
        axis = tree.S[i][reduced.slides[i]]

        claim = Claim("axis", "z", "declared", tuple(row[2] for row in reduced.moved[i].R), tuple(axis))

        assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_frames_of_a_chain_turn_about_x_alone_before_the_joint():
    for one in ROBOTS:
        for X in reframe(Workspace(robot_scene(one)).tree).X:
            assert all(isinstance(turn, PlanarTurn) and turn.k == 0 for turn in X.fixed)
            assert X.shift[1].is_zero
            assert X.shift[2].is_zero


def test_frames_of_parallel_axes_lie_beside_each_other_along_x():
    shifts = ["3/5", "4/5", "1/3"]
    origin = list(zip(("Tx", "Ty", "Tz"), shifts, strict=True))
    bodies = [body(name, mass=1, com=["1/3", "1/5", "1/7"]) for name in "abc"]
    joints = [
        revolute("j1", "ground", "a"),
        revolute("j2", "a", "b", origin=origin),
        revolute("j3", "b", "c", origin=origin),
    ]
    reduced = Workspace(scene("stairs", bodies=bodies, joints=joints)).reduced

    for X in reduced.X[2:]:
        assert [str(x) for x in X.shift] == ["1", "0", "0"]


def leaning(turns, parameters=()):
    """Two revolute joints, the second one placed by a shift and `turns`."""
    return scene(
        "leaning",
        parameters=dict.fromkeys(parameters),
        bodies=[body("a", mass=1, com=["1/3", "1/5", "1/7"]), body("b", mass=2, com=["1/9", "1/2", "1/4"])],
        joints=[revolute("j1", "ground", "a"), revolute("j2", "a", "b", origin=[("Tx", 1), ("Ty", "1/3"), *turns])],
    )


KEPT = {
    "by two parameters": leaning([("Rx", "u"), ("Ry", "v")], ("u", "v")),
    "by odd angles": leaning([("Rx", "37*pi/180"), ("Ry", "21*pi/180")]),
}


@pytest.mark.parametrize("name", KEPT)
def test_an_axis_that_leans_inexactly_keeps_its_declared_rotation(name):
    w = Workspace(KEPT[name])
    claim = Claim(
        "ID",
        "rnea",
        "lagrange",
        *(derive_one(w, "inverse_dynamics", formulation).entries for formulation in ("rnea", "lagrange")),
    )

    assert isinstance(w.reduced.X[2].fixed[0], GeneralTurn)
    assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_an_axis_that_leans_by_one_parameter_needs_no_root():
    w = Workspace(leaning([("Rx", "u")], ("u",)))
    nodes = reachable(derive_one(w, "inverse_dynamics").entries)

    assert isinstance(w.reduced.X[2].fixed[0], PlanarTurn)
    assert not [node for node in nodes if node.op is Op.SQRT]


TWISTED = """
name = "twisted"
parameters = { u = 0.3, v = 0.2 }
[dh]
convention = "modified"
links = [
    { mass = 1, com = [0.1, 0.2, 0.3] },
    { alpha = "TWIST", a = 0.5, d = "v", mass = 2, com = [0.3, 0.1, 0.2] },
    { alpha = "TWIST", a = 0.7, mass = 3, com = [0.2, 0.4, 0.1] },
]
"""


@pytest.mark.parametrize("twist", ["u", "-u"])
def test_an_offset_along_an_axis_that_leans_by_a_parameter_is_the_rise_of_the_link(twist):
    w = Workspace(read_text(TWISTED.replace("TWIST", twist)))
    formulations = [derive_one(w, "inverse_dynamics", formulation).entries for formulation in ("rnea", "lagrange")]

    assert w.reduced.X[2].offset is w.graph.symbol("v")
    assert prove([Claim("ID", "rnea", "lagrange", *formulations)])[1][0].verdict == Verdict.PROVED


def test_the_common_normal_of_nearly_parallel_axes_stays_near():
    w = Workspace(leaning([("Rx", "1/1000000")]))
    (claim,) = [
        Claim(
            "ID",
            "a",
            "b",
            *(derive_one(w, "inverse_dynamics", formulation).entries for formulation in ("rnea", "lagrange")),
        )
    ]

    assert [entry.is_zero for entry in w.reduced.X[2].shift] == [False, False, True]
    assert all(abs(value) < 2 for value in values_of(w.reduced.X[2].shift))
    assert w.reduced.X[2].offset.is_zero
    assert prove([claim])[1][0].verdict == Verdict.PROVED


def test_a_common_normal_of_rational_length_is_found():
    w = Workspace(leaning([("Rx", "atan2(3, 4)")]))
    one = Workspace(
        scene(
            "axes",
            bodies=[body("a", mass=1, com=[1, 2, 3]), body("b", mass=2, com=[1, 0, 1])],
            joints=[revolute("j1", "ground", "a"), revolute("j2", "a", "b", axis=[1, 2, 2], origin=[1, 0, 0])],
        )
    )

    assert all(isinstance(turn, PlanarTurn) for X in (*w.reduced.X, *one.reduced.X) for turn in X.fixed)
    assert derive_one(w, "inverse_dynamics").entries


def test_no_revolute_chain_keeps_a_mass_and_no_slide_a_turning_inertia():
    reduced = Workspace(robot_scene(robot("stanford"))).reduced
    for i in reduced.outward():
        kept = reduced.body[i]
        if reduced.slides[i]:
            assert all(entry.is_zero for row in kept.J for entry in row)
        elif i > 3:
            assert kept.m.is_zero
            assert kept.h[2].is_zero
            assert kept.J[2][2].is_zero


def test_regrouping_twice_changes_nothing():
    reduced = Workspace(robot_scene(robot("stanford"))).reduced
    again = regroup(reduced)

    assert again.body[1:] == reduced.body[1:]


def rank(one, seed=1, states=30):
    """Return on how many combinations of the declared inertial parameters the driving forces depend."""
    w, rng = Workspace(one), random.Random(seed)
    inertial = [w.graph.symbol(p.name) for p in one.free_parameters if p.unit.startswith("kg")]
    slopes = [x for tau in derive_one(w, "inverse_dynamics").entries for x in gradient(tau, inertial)]
    state = {*w.state.q, *w.state.qd, *w.state.qdd}
    symbols = [node for node in reachable(slopes) if node.op is Op.SYMBOL]
    fixed = {node: rng.uniform(0.3, 1.2) for node in symbols if node not in state}
    rows = []
    for _ in range(states):
        moving = {node: rng.uniform(-2, 2) for node in symbols if node in state}
        rows += np.reshape(evaluate(slopes, Floats(), {**fixed, **moving}), (-1, len(inertial))).tolist()
    return np.linalg.matrix_rank(np.array(rows, dtype=float))


@pytest.mark.parametrize("one", ROBOTS, ids=lambda one: one.name)
def test_base_parameters_are_as_many_as_can_be_told_apart(one):
    assert len(base_parameters(robot_scene(one))) == rank(robot_scene(one))


def test_puma_560_has_its_36_base_parameters():
    names = [name for name, _ in base_parameters(robot_scene(robot("puma560")))]

    assert len(names) == 36
    assert names[:3] == ["ZZR1", "mxR2", "myR2"]


def test_base_parameters_of_a_slider_are_its_mass_and_its_first_moments_across_the_turret():
    one = scene(
        "turret",
        parameters=dict.fromkeys(("m", "x", "y", "z", "I")),
        bodies=[
            body("base", mass=1, com=[1, 0, 0]),
            body("slide", mass="m", first_moment=["x", "y", "z"], inertia={"zz": "I"}, about="frame"),
        ],
        joints=[revolute("turn", "ground", "base"), prismatic("reach", "base", "slide", axis=[1, 0, 0])],
    )

    assert [name for name, _ in base_parameters(one)] == ["ZZR1", "MR2", "mxR2", "mzR2"]


# Constants in the open


def test_a_hidden_zero_and_a_hidden_fraction_are_settled_and_a_root_stands():
    g = Graph()
    s, c = g.sin(g.pi * Fraction(2, 9)), g.cos(g.pi * Fraction(2, 9))
    x = g.symbol("x")

    settled = settle([s * s + c * c - 1, s * s + c * c, s, x * (s * s + c * c)])

    assert settled[0] is g.zero
    assert settled[1] is g.one
    assert settled[2] is s
    assert settled[3] is x * (s * s + c * c)


def test_a_constant_that_is_no_real_number_is_an_error():
    g = Graph()
    with pytest.raises(DerivationError, match="no finite real number"):
        settle([g.sqrt(g.sin(g.pi * Fraction(-2, 9)))])


@pytest.mark.parametrize("one", ROBOTS, ids=lambda one: one.name)
def test_right_angles_and_symbols_need_no_big_numbers(one, monkeypatch):
    monkeypatch.setattr("symdyn.algebra.big.BigFloats", None)  # calling it would fail

    assert Workspace(robot_scene(one)).reduced.X
