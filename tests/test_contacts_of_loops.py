"""Functions of contacts beside a loop: those of the same mechanism without it, and proofs."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import DerivationError
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

LOOPED = """
gravity = [0, 0, -9.81]
[bodies.left]
mass = 1
com = [0.2, 0, 0]
inertia = [0.02, 0.02, 0.02]
inertia_about = "com"
[bodies.right]
mass = 2
com = [0.3, 0, 0]
inertia = [0.03, 0.03, 0.03]
inertia_about = "com"
[bodies.coupler]
mass = 3
[joints.a]
type = "revolute"
parent = "ground"
child = "left"
axis = [0, 1, 0]
coordinate = "a"
start = 0.2
[joints.b]
type = "revolute"
parent = "ground"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
coordinate = "b"
start = 0.2
[joints.c]
type = "revolute"
parent = "left"
child = "coupler"
axis = [0, 1, 0]
origin = [0.5, 0, 0]
coordinate = "c"
start = -0.2
[[loop]]
type = "revolute"
parent = "coupler"
child = "right"
axis = [0, 1, 0]
origin = [1, 0, 0]
tip = [-0.5, 0, 0]
[contacts.floor]
body = "coupler"
at = [0.4, 0, -0.1]
restitution = 0.5
friction = 0.2
plane = { at = [0, 0, -0.45], normal = [0, 0, 1] }
"""
"""A parallelogram, which is a pendulum of one angle."""

ALONE = """
gravity = [0, 0, -9.81]
[parameters]
J = "0.02 + 0.03 + 1*0.2**2 + 2*0.3**2 + 3*0.5**2"
Jc = "J - (1*0.2 + 2*0.3 + 3*0.5)**2/6"
[bodies.arm]
mass = 6
com = ["(1*0.2 + 2*0.3 + 3*0.5)/6", 0, 0]
inertia = ["Jc/2", "Jc", "Jc/2"]
inertia_about = "com"
[joints.a]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
coordinate = "a"
start = 0.2
[contacts.floor]
type = "gap"
gap = "0.35 - 0.5*sin(a)"
tangent = "-0.5*a_dot*sin(a)"
restitution = 0.5
friction = 0.2
"""

SMOOTH, SMOOTH_ALONE = (read_text(text.replace("friction = 0.2", "")) for text in (LOOPED, ALONE))


def test_functions_of_contacts_beside_a_loop_are_those_of_the_mechanism_without() -> None:
    a, u, force = 0.3, 0.7, 1.3
    signs = np.array([1, 1, -1])  # a, b and c of the parallelogram
    given = {"q": a * signs, "qd": u * signs, "tau": np.array([force, 0, 0]), "mask": [1.0], "slip": [0.0]}
    alone = given | {"q": [a], "qd": [u], "tau": [force]}
    takes = {
        "delassus": ("q",),
        "contact_bias": ("q", "qd", "tau"),
        "contact_dynamics": (*given,),
        "impact:floor": ("q", "qd"),
    }
    for name, words in takes.items():
        found, wanted = (
            np.asarray(symdyn.lambdify(scene, name)(*(values[word] for word in words))).ravel()
            for scene, values in ((SMOOTH, given), (SMOOTH_ALONE, alone))
        )
        if len(found) > len(wanted):  # velocities or accelerations of all three
            assert found[1:3] == pytest.approx(wanted[0] * signs[1:])
            found = np.delete(found, [1, 2])
        assert found == pytest.approx(wanted)


@pytest.mark.slow
def test_functions_of_contacts_beside_a_loop_are_proved() -> None:
    asked = ["gap:floor", "delassus", "contact_bias", "impact:floor", "impact_matrix:floor", "contact_dynamics"]

    assert symdyn.certify(SMOOTH, asked).passed
    assert symdyn.certify(read_text(LOOPED), [one for one in asked if one != "impact:floor"]).passed


def test_an_impact_with_more_impulses_than_ways_to_move_has_no_formula() -> None:
    words = (
        r"contacts\.floor: 2 impulses act, and 1 velocity is free, so that they are not unique; leave its friction out"
    )
    for text in (LOOPED, ALONE):
        with pytest.raises(DerivationError, match=words):
            symdyn.lambdify(read_text(text), "impact:floor")
