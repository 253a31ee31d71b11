"""What generated files say of their arguments: names, order of quaternions, axes of velocities, numbers and arrays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from mechanisms import jointed

from symdyn.dynamics import OUTPUTS, derive
from symdyn.dynamics.outputs.named_functions import conventions, runs
from symdyn.emit import emit
from symdyn.program.lower import lower
from symdyn.scene import parse, read

FOUR_BAR = Path(__file__).parent.parent / "examples" / "four_bar.toml"


@pytest.mark.parametrize("target", ["numpy", "c", "js"])
def test_headers_name_coordinates_and_say_the_conventions_of_quaternions(target: str) -> None:
    scene = jointed("free", "revolute")
    text = "".join(emit(lower(derive(scene, ["momentum"])), target).values())

    assert "x0 ... x7; quaternions are in the order (w, x, y, z)" in text
    assert "j0_wx, j0_wy, j0_wz, x7_dot; velocities v and w of free joints" in text


def test_names_that_are_rates_are_not_repeated() -> None:
    scene = jointed("revolute", "prismatic")
    assert (conventions(scene, "q"), conventions(scene, "qd")) == ("x0, x1", "")


def test_names_that_count_up_are_told_by_the_first_and_the_last() -> None:
    assert runs(["x", "q1", "q2", "q3", "q4", "q6", "a9", "a10", "a11", "a12"]) == "x, q1 ... q4, q6, a9 ... a12"
    assert runs(["q01", "q02", "t"]) == "q01, q02, t"


@pytest.mark.parametrize("target", ["numpy", "c", "js"])
def test_time_is_a_number_and_no_array(target: str) -> None:
    scene = jointed("revolute")
    (joint,) = scene.joints
    moved = replace(scene, joints=(replace(joint, motion=parse("sin(t)")),))
    text = "".join(emit(lower(derive(moved, ["prescribed_motion"])), target).values())

    assert "t, a number; s: time" in text
    assert " t, shape" not in text


def test_texts_of_outputs_follow_the_words_in_front_of_them() -> None:
    """Docstrings begin "Return the ..."."""
    for name in ("forward_reactions", "reactions"):
        assert OUTPUTS[name].text.startswith("reactions [force; moment]")


@pytest.mark.parametrize(("drives", "words"), [(True, "zero where it is passive"), (False, "no joint has a drive")])
def test_inverse_dynamics_of_a_loop_says_where_its_forces_stand(drives: bool, words: str) -> None:
    scene = read(FOUR_BAR)
    if not drives:
        scene = replace(scene, joints=tuple(replace(joint, drives=(None,)) for joint in scene.joints))
    assert words in derive(scene, ["inverse_dynamics"])["inverse_dynamics"].text
