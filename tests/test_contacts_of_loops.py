"""Functions of contacts beside a loop: those of the same mechanism without it, and proofs."""

from __future__ import annotations

import numpy as np
import pytest
from contact_scenes import ALONE, LOOPED

import symdyn
from symdyn.errors import DerivationError
from symdyn.scene.toml import read_text

pytestmark = [pytest.mark.runs("cc")]

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


@pytest.mark.parametrize("text", [LOOPED, ALONE], ids=["loop", "alone"])
def test_forces_that_are_not_unique_are_those_of_least_size(text: str) -> None:
    """One freedom that a normal force holds, and friction too."""
    call = symdyn.load(read_text(text), ["contact_dynamics", "delassus", "contact_bias"])
    q = np.array([0.3, 0.3, -0.3])[: 3 if text == LOOPED else 1]
    rest, closed = np.zeros(len(q)), np.ones(1)
    found = call.contact_dynamics(q, rest, rest, closed, 0 * closed)
    wanted = np.linalg.lstsq(call.delassus(q), -call.contact_bias(q, rest, rest), rcond=1e-10)[0]

    assert found[: len(q)] == pytest.approx(rest, abs=1e-9)
    assert found[len(q) :] == pytest.approx(wanted, rel=1e-7)
    assert np.abs(wanted).max() > 1
