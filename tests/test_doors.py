"""Doors in Python: what they take, and what they say of what they cannot take."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy

import symdyn
from symdyn.errors import DrawError, SimulateError
from symdyn.simulation import read_forces, simulate

EXAMPLES = Path(__file__).parent.parent / "examples"
ARM = symdyn.read(EXAMPLES / "two_link.toml")
CART = symdyn.read(EXAMPLES / "cart_pole.toml")


@pytest.mark.mends("6.sympy")
@pytest.mark.parametrize("whole", [np.int64, sympy.Integer])
def test_indices_are_whole_numbers_of_any_library(whole):
    closed = symdyn.closed_form(ARM)
    try:
        found = closed.sympy("k_z", whole(0), whole(1))
    except symdyn.SymdynError as fault:
        pytest.fail(str(fault))

    assert found == closed.sympy("k_z", 0, 1)


@pytest.mark.parametrize("index", [2, -1, 0.0, "0", None])
def test_other_indices_are_refused(index):
    with pytest.raises(symdyn.SymdynError, match="there is no coefficient"):
        symdyn.closed_form(ARM)["k_z", 0, index]


@pytest.mark.mends("6.pickle")
def test_a_closed_form_pickles():
    closed = symdyn.closed_form(ARM)
    try:
        again = pickle.loads(pickle.dumps(closed))
    except TypeError as fault:
        pytest.fail(str(fault))

    assert str(again.sympy("k_C", 0, 0)) == str(closed.sympy("k_C", 0, 0))


@pytest.mark.runs
@pytest.mark.mends("6.key")
def test_a_function_that_is_not_there_is_told_with_those_that_are():
    arm = symdyn.load(ARM, ["mass_matrix"])

    with pytest.raises(KeyError, match=r"there is no function 'pose:nothing'; there are mass_matrix"):
        arm["pose:nothing"]


@pytest.mark.mends("6.picture")
@pytest.mark.parametrize(
    ("position", "words"), [({"q1": 0.2}, "give a list of numbers"), (["x", 1.0], "give a list of numbers")]
)
def test_a_picture_at_what_is_no_position_says_so(position, words):
    with pytest.raises((DrawError, TypeError, ValueError)) as caught:
        symdyn.picture(ARM, position)

    assert isinstance(caught.value, DrawError), "a bare exception"
    assert words in str(caught.value)


@pytest.mark.runs
@pytest.mark.mends("6.forces")
@pytest.mark.parametrize("forces", ["F=0.5", ["F=0.5"], {"F": "0.5"}, {"F": 0.5}])
def test_forces_are_read_from_text_lists_and_names(forces):
    try:
        run = simulate(CART, forces=forces, until=0.1)
    except AttributeError as fault:
        pytest.fail(str(fault))

    assert np.array_equal(run.q, simulate(CART, forces=read_forces(CART, ["F=0.5"]), until=0.1).q)


@pytest.mark.mends("6.forces")
def test_forces_that_are_none_are_one_fault():
    with pytest.raises((SimulateError, AttributeError)) as caught:
        simulate(CART, forces=0.5, until=0.1)

    assert isinstance(caught.value, SimulateError), "a bare exception"
    assert "give a formula" in str(caught.value)


@pytest.mark.mends("6.letters")
def test_one_entry_of_forces_is_one_entry():
    with pytest.raises(SimulateError) as caught:
        read_forces(CART, "G=1")

    assert len(caught.value.faults) == 1


@pytest.mark.runs
@pytest.mark.mends("6.simulate")
def test_a_door_is_a_door_at_the_second_call_too():
    """Rooms are imported when a door is first used; none of them takes the place of a door."""
    code = "import pkgutil, symdyn\nnames = set(symdyn.__all__)\nscene = symdyn.read('examples/cart_pole.toml')\n"
    code += "first = [len(symdyn.simulate(scene, until=0.1).t), len(symdyn.simulate(scene, until=0.1).t)]\n"
    code += "assert first[0] == first[1]\n"
    code += "assert not names & {module.name for module in pkgutil.iter_modules(symdyn.__path__)}"
    ran = subprocess.run([sys.executable, "-c", code], cwd=EXAMPLES.parent, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize("law", ["tan(pi/2)", "1/cos(pi/2)", "t/sin(pi)"])
def test_a_force_that_divides_by_what_is_exactly_zero_is_refused(law: str) -> None:
    with pytest.raises(symdyn.SymdynError, match="divides by zero; check the denominator"):
        simulate(CART, forces=f"F={law}", until=0.1)
