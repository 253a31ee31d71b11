"""Spinning bodies to first order, in axes that do not spin with them: one rule for every joint with a quaternion.

A top of moments A, C about its pivot, at spin w: A z'' - i C w z' - m g l z = 0, z = x + i y of its tip.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from numpy.testing import assert_allclose

import symdyn
from symdyn.linear import Linearization, stability
from symdyn.scene import read_text

MASS, ARM, A, C, SPIN = 0.7, 0.23, 0.05, 0.011, 60.0
WEIGHT = MASS * 9.81 * ARM
CENTRAL = A - MASS * ARM**2


def top(
    axis: int = 2, name: str = "p", body: str = "top", drive: str = "false", spin: float = SPIN, arm: float = ARM
) -> str:
    """Return a joint and a body: a top whose axis of symmetry, upright, is x, y or z of its own axes."""
    along = np.eye(3)[axis]
    inertia = (CENTRAL + (C - CENTRAL) * along).tolist()
    start = UPRIGHT[axis]
    return f"""
[bodies.{body}]
mass = {MASS}
com = {(arm * along).tolist()}
inertia = {inertia}
inertia_about = "com"
[joints.{name}]
type = "spherical"
parent = "ground"
child = "{body}"
drive = {drive}
start = {start}
start_rates = {(spin * along).tolist()}
"""


HALF = math.sqrt(0.5)
UPRIGHT = ([HALF, 0.0, -HALF, 0.0], [HALF, HALF, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
"""Quaternions that turn x, y, z to the vertical."""

HEAD = 'name = "top"\ngravity = [0, 0, -9.81]\n'


def closed_form(spin: float = SPIN, arm: float = ARM) -> list[complex]:
    """Return λ of A λ² - i C w λ - m g l = 0 and their conjugates, of the moments about the pivot."""
    pivot = CENTRAL + MASS * arm**2
    roots = np.roots([pivot, -1j * C * spin, -MASS * 9.81 * arm])
    return ordered([*roots, *roots.conj()])


def eigenvalues(found: Linearization) -> list[complex]:
    """Return the eigenvalues that are not zero."""
    return ordered(found.eigenvalues[: len(found.states) - found.spectrum.zeros])


def ordered(values: Iterable[complex]) -> list[complex]:
    """Return eigenvalues by their imaginary and then their real parts, rounding apart."""
    return sorted(values, key=lambda x: (round(x.imag, 6), x.real))


@pytest.mark.mends("30.numbers.2")
def test_a_sleeping_top_nutates_and_precesses_as_the_finding_says() -> None:
    found = symdyn.linearize(read_text(HEAD + top()))
    assert [mode.frequency for mode in found.modes] == pytest.approx([0.500, 1.602], abs=1.1e-3)
    assert stability(found).verdict == "oscillating"


@pytest.mark.mends("30.numbers.2")
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("drive", ["false", "true"])
@pytest.mark.parametrize("spin", [20.0, -52.0, 300.0])
def test_a_top_moves_as_its_equation_says_whichever_axis_it_is_built_about(axis: int, drive: str, spin: float) -> None:
    found = symdyn.linearize(read_text(HEAD + top(axis, drive=drive, spin=spin)))
    assert_allclose(eigenvalues(found), closed_form(spin), rtol=1e-9, atol=1e-6)
    assert any(f"do not spin with it about its {'xyz'[axis]}" in note for note in found.notes)


@pytest.mark.parametrize(("spin", "verdict"), [(51.0939, "unstable"), (51.0941, "oscillating")])
def test_the_critical_spin_of_a_top_is_where_it_was(spin: float, verdict: str) -> None:
    critical = math.sqrt(4 * A * WEIGHT) / C
    assert critical == pytest.approx(51.0940, abs=5e-5)
    assert stability(symdyn.linearize(read_text(HEAD + top(spin=spin)))).verdict == verdict


@pytest.mark.mends("30.numbers.2")
def test_two_tops_of_one_scene_are_each_looked_at_in_axes_that_do_not_spin() -> None:
    both = top() + top(0, "r", "other", spin=-75.0, arm=0.2)
    found = symdyn.linearize(read_text(HEAD + both))
    expected = [*closed_form(), *closed_form(-75.0, 0.2)]
    assert_allclose(eigenvalues(found), ordered(expected), atol=1e-7)


@pytest.mark.mends("30.numbers.2")
def test_a_free_body_of_rotation_nutates_by_its_momentum_over_its_moment_across() -> None:
    """I ω̇ + ω × I ω = 0 about its axis of symmetry, seen from outside: all its points go round by C w / A."""
    text = f"""
name = "frisbee"
gravity = [0, 0, 0]
[bodies.frisbee]
mass = 2
inertia = [0.3, 0.3, 0.5]
inertia_about = "com"
[joints.flight]
type = "free"
parent = "ground"
child = "frisbee"
start_rates = [1, 0, 0, 0, 0, {SPIN}]
"""
    for scene in (text, text.replace("[1, 0, 0, 0, 0, ", "[0, 0, 1, 0, 0, ")):
        along = symdyn.linearize(read_text(scene.replace("[1, 0, 0,", "[0, 0, 0,")))
        assert_allclose(eigenvalues(along), [-0.5 / 0.3 * SPIN * 1j, 0.5 / 0.3 * SPIN * 1j], rtol=1e-9)
        assert stability(along).verdict == "oscillating"


@pytest.mark.mends("30.numbers.2")
def test_a_ball_that_turns_about_no_axis_of_its_own_is_looked_at_in_axes_at_rest() -> None:
    text = HEAD + top(arm=0.0).replace(f"[{CENTRAL}, {CENTRAL}, {C}]", "[0.1, 0.1, 0.1]")
    found = symdyn.linearize(read_text(text), rates={"p_wx": "1", "p_wy": "-2", "p_wz": "4"})
    assert found.spectrum.modes[0].value.imag == pytest.approx(math.sqrt(21), rel=1e-9)  # i w of A = C
    assert any("axis (" in note for note in found.notes)


def test_what_is_no_body_of_rotation_is_looked_at_in_its_own_axes_and_it_is_said() -> None:
    found = symdyn.linearize(symdyn.example("free_body"), rates={"flight_wx": "0", "flight_wy": "0", "flight_wz": "3"})
    assert not found.spin.any()
    assert any("turn with it, and so are frequencies" in note for note in found.notes)


@pytest.mark.mends("30.numbers.2")
def test_every_speed_of_a_locus_is_looked_at_in_axes_that_do_not_spin() -> None:
    """λ² = 4g/(5r) - 12ω²/5 of a rolling disc, at the first value and at the others."""
    from symdyn.linear.over_values import systems

    disc = symdyn.example("rolling_disc")
    system = systems(disc, "s", {"z": "r", "e0": "1", "e1": "0"}, {"flight_wx": "0", "flight_wy": "s"})
    for speed in (4.0, 6.0, 9.0):
        largest = max(abs(system(speed).eigenvalues))
        assert largest == pytest.approx(math.sqrt(12 / 5 * speed**2 - 4 * 9.81 / 1.5), rel=1e-7)


@pytest.mark.parametrize("drive", ["false", "true"])
def test_both_roads_to_a_sampled_system_meet_in_axes_that_do_not_spin(drive: str) -> None:
    from symdyn.linear.prepared import prepared
    from symdyn.linear.sampled import along_a_step, sampled

    scene = read_text(HEAD + top(drive=drive))
    one = symdyn.linearize(scene)
    exact, stepped = sampled(one, 0.03), along_a_step(prepared(scene), one, 0.03)
    assert_allclose(stepped.A, exact.A, atol=1e-11)
    assert_allclose(stepped.B, exact.B, atol=1e-10)


def test_gains_in_axes_that_do_not_spin_say_so() -> None:
    from symdyn.linear.regulator import SPINNING, lqr

    assert SPINNING in lqr(symdyn.linearize(read_text(HEAD + top(drive="true")))).notes


def test_an_input_along_an_axis_of_the_body_keeps_the_axes_of_the_body() -> None:
    """B stays in those alone: a torque of an input about x of a body that spins about z."""
    jet = '[inputs.u]\n[loads.jet]\nbody = "top"\nat = [0, 0, 0.3]\nforce = ["u", 0, 0]\nframe = "body"\n'
    text = HEAD + top() + jet
    found = symdyn.linearize(read_text(text))
    assert not found.spin.any()
