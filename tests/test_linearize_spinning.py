"""Spinning bodies to first order, in axes that do not spin with them: one rule for every joint with a quaternion.

A top of moments A, C about its pivot, at spin w: A z'' - i C w z' - m g l z = 0, z = x + i y of its tip.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike

import symdyn
from symdyn.linear import Linearization
from symdyn.linear.stability import zero_kinds
from symdyn.scene import read_text
from symdyn.simulation import Problem

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
    return written(arm * along, inertia, start, spin * along, name, body, drive)


def written(
    com: ArrayLike,
    inertia: ArrayLike,
    start: ArrayLike,
    rates: ArrayLike,
    name: str = "p",
    body: str = "top",
    drive: str = "false",
    orientation: str = "quaternion",
) -> str:
    """Return a joint that turns every way and its body, moments about its centre of mass."""
    return f"""
[bodies.{body}]
mass = {MASS}
com = {np.asarray(com).tolist()}
inertia = {np.asarray(inertia).tolist()}
inertia_about = "com"
[joints.{name}]
type = "spherical"
orientation = "{orientation}"
parent = "ground"
child = "{body}"
drive = {drive}
start = {np.asarray(start).tolist()}
start_rates = {np.asarray(rates).tolist()}
"""


def by_angles(axis: int, orientation: str, start: ArrayLike, rates: ArrayLike, drive: str = "false") -> str:
    """Return the top by three angles, its axis of symmetry x, y or z of its own axes."""
    along = np.eye(3)[axis]
    inertia = np.diag(CENTRAL + (C - CENTRAL) * along)
    return HEAD + written(ARM * along, inertia, start, rates, drive=drive, orientation=orientation)


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
    return ordered(found.poles[: len(found.states) - found.spectrum.zeros])


def ordered(values: Iterable[complex]) -> list[complex]:
    """Return eigenvalues by their imaginary and then their real parts, rounding apart."""
    return sorted(values, key=lambda x: (round(x.imag, 6), x.real))


@pytest.mark.mends("30.numbers.2")
def test_a_sleeping_top_nutates_and_precesses_as_the_finding_says() -> None:
    found = symdyn.linearize(read_text(HEAD + top()))
    assert [mode.frequency for mode in found.modes] == pytest.approx([0.500, 1.602], abs=1.1e-3)
    assert found.stability.verdict == "marginally stable"


@pytest.mark.wide(4)  # of which each axis has its share
@pytest.mark.mends("30.numbers.2")
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("drive", ["false", "true"])
@pytest.mark.parametrize("spin", [20.0, -52.0, 300.0])
def test_a_top_moves_as_its_equation_says_whichever_axis_it_is_built_about(axis: int, drive: str, spin: float) -> None:
    found = symdyn.linearize(read_text(HEAD + top(axis, drive=drive, spin=spin)))
    assert_allclose(eigenvalues(found), closed_form(spin), rtol=1e-9, atol=1e-6)
    assert any(f"do not spin with it about its {'xyz'[axis]}" in note for note in found.notes)


@pytest.mark.parametrize(("spin", "verdict"), [(51.0939, "unstable"), (51.0941, "marginally stable")])
def test_the_critical_spin_of_a_top_is_where_it_was(spin: float, verdict: str) -> None:
    critical = math.sqrt(4 * A * WEIGHT) / C
    assert critical == pytest.approx(51.0940, abs=5e-5)
    assert symdyn.linearize(read_text(HEAD + top(spin=spin))).stability.verdict == verdict


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
        assert along.stability.verdict == "marginally stable"


@pytest.mark.mends("30.numbers.2")
def test_a_ball_that_turns_about_no_axis_of_its_own_is_looked_at_in_axes_at_rest() -> None:
    text = HEAD + top(arm=0.0).replace(f"[{CENTRAL}, {CENTRAL}, {C}]", "[0.1, 0.1, 0.1]")
    found = symdyn.linearize(read_text(text), start_rates={"p_wx": "1", "p_wy": "-2", "p_wz": "4"})
    assert found.spectrum.modes[0].value.imag == pytest.approx(math.sqrt(21), rel=1e-9)  # i w of A = C
    assert any("axis (" in note for note in found.notes)


def test_what_is_no_body_of_rotation_is_looked_at_in_its_own_axes_and_it_is_said() -> None:
    found = symdyn.linearize(
        symdyn.example("free_body"), start_rates={"flight_wx": "0", "flight_wy": "0", "flight_wz": "3"}
    )
    assert not found.spin.any()
    assert any("turn with it, and so are frequencies" in note for note in found.notes)


@pytest.mark.mends("30.numbers.2")
def test_every_speed_of_a_locus_is_looked_at_in_axes_that_do_not_spin() -> None:
    """λ² = 4g/(5r) - 12ω²/5 of a rolling disc, at the first value and at the others."""
    from symdyn.linear.linearized import systems

    disc = symdyn.example("rolling_disc")
    system = systems(Problem(disc, (), {"z": "r", "e0": "1", "e1": "0"}, {"flight_wx": "0", "flight_wy": "s"}), "s")
    for speed in (4.0, 6.0, 9.0):
        largest = max(abs(system(speed).poles))
        assert largest == pytest.approx(math.sqrt(12 / 5 * speed**2 - 4 * 9.81 / 1.5), rel=1e-7)


@pytest.mark.parametrize("drive", ["false", "true"])
def test_both_formulations_to_a_sampled_system_meet_in_axes_that_do_not_spin(drive: str) -> None:
    from symdyn.linear.evolution import along_a_step
    from symdyn.linear.prepared import prepared

    scene = read_text(HEAD + top(drive=drive))
    one = symdyn.linearize(scene)
    exact, stepped = one.discretize(0.03), along_a_step(prepared(Problem(scene)), one, 0.03)
    assert_allclose(stepped.A, exact.A, atol=1e-11)
    assert_allclose(stepped.B, exact.B, atol=1e-10)


def test_gains_in_axes_that_do_not_spin_say_so() -> None:
    from symdyn.linear.regulator import SPINNING

    assert SPINNING in symdyn.linearize(read_text(HEAD + top(drive="true"))).lqr().notes


def test_an_input_along_an_axis_of_the_body_keeps_the_axes_of_the_body() -> None:
    """B stays in those alone: a torque of an input about x of a body that spins about z."""
    jet = '[inputs.u]\n[loads.jet]\nbody = "top"\nat = [0, 0, 0.3]\nforce = ["u", 0, 0]\nframe = "body"\n'
    text = HEAD + top() + jet
    found = symdyn.linearize(read_text(text))
    assert not found.spin.any()


HALF_TURN = math.pi / 2
ANGLES = (
    ("zyx", 2, [0, 0, 0]),
    ("zyx", 1, [0.4, 0, HALF_TURN]),
    ("zxy", 2, [0.3, 0, 0]),
    ("zxz", 1, [0, HALF_TURN, 0]),
)
"""Sequences, axes of symmetry and angles with that axis upright, in which the first turns about it."""


@pytest.mark.mends("30.also.axes")
@pytest.mark.parametrize("drive", ["false", "true"])
@pytest.mark.parametrize(("orientation", "axis", "start"), ANGLES)
def test_a_top_by_angles_moves_as_the_one_by_a_quaternion(
    orientation: str, axis: int, start: list[float], drive: str
) -> None:
    found = symdyn.linearize(read_text(by_angles(axis, orientation, start, [SPIN, 0, 0], drive)))
    assert_allclose(eigenvalues(found), closed_form(), rtol=1e-9, atol=1e-6)
    assert found.stability.verdict == "marginally stable"
    assert any("do not spin with it" in note for note in found.notes)


@pytest.mark.mends("30.also.axes")
def test_angles_of_what_is_no_body_of_rotation_turn_with_the_first_and_it_is_said() -> None:
    text = HEAD.replace("-9.81", "0") + written([0, 0, 0], [2, 3, 4], [0, 0, 0], [3, 0, 0], orientation="zyx")
    found = symdyn.linearize(read_text(text))
    euler = math.sqrt(3)  # w √((C - A)(C - B)/AB); and the axis that stays is seen to turn back by w
    assert_allclose([x.imag for x in eigenvalues(found)], [-3, -euler, euler, 3], rtol=1e-9)
    assert any("turn with q1, and so are frequencies" in note for note in found.notes)


def test_both_formulations_to_a_sampled_system_meet_for_angles_in_axes_that_do_not_spin() -> None:
    from symdyn.linear.evolution import along_a_step
    from symdyn.linear.prepared import prepared

    scene = read_text(by_angles(1, "zyx", [0.4, 0, HALF_TURN], [SPIN, 0, 0], "true"))
    one = symdyn.linearize(scene)
    exact, stepped = one.discretize(0.03), along_a_step(prepared(Problem(scene)), one, 0.03)
    assert one.spin.any()
    assert_allclose(stepped.A, exact.A, atol=1e-9)
    assert_allclose(stepped.B, exact.B, atol=1e-9)


def oblique(way: ArrayLike, angle: float, spin: float = SPIN) -> str:
    """Return the upright top with the axes of its body turned by an angle about some direction."""
    n = np.asarray(way) / np.linalg.norm(way)
    across = np.cross(np.eye(3), n)
    R = np.eye(3) + math.sin(angle) * across + (1 - math.cos(angle)) * across @ across
    inertia = R @ np.diag([CENTRAL, CENTRAL, C]) @ R.T
    start = [math.cos(angle / 2), *(-math.sin(angle / 2) * n)]
    return HEAD + written(R[:, 2] * ARM, (inertia + inertia.T) / 2, start, R[:, 2] * spin)


@pytest.mark.mends("30.also.axes")
@pytest.mark.parametrize(("way", "angle"), [([1, 2, 0.5], 0.7), ([0, 1, 0], 0.3), ([1, 1, -3], 1.5)])
@pytest.mark.parametrize(("spin", "verdict"), [(SPIN, "marginally stable"), (51.0, "unstable")])
def test_a_top_is_judged_alike_however_the_axes_of_its_body_are_turned(
    way: list[float], angle: float, spin: float, verdict: str
) -> None:
    found = symdyn.linearize(read_text(oblique(way, angle, spin)))
    assert_allclose(eigenvalues(found), closed_form(spin), rtol=1e-7, atol=1e-6)
    assert found.stability.verdict == verdict
    assert "undecided" not in found.zero_eigenvalues


def test_a_zero_that_leads_to_no_other_steady_motion_is_undecided() -> None:
    """One position does nothing and its velocity is driven by the other one, which moves at an even rate."""
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = A[2, 1] = 1.0

    assert zero_kinds(A, 4, 2, (), 0, "steady") == {"family": 2, "undecided": 2}


TILT = 0.5
PRECESSION = min(np.roots([A * math.cos(TILT), -C * SPIN, WEIGHT]).tolist())
"""The slow rate of A cos θ p² - C w p + m g l = 0, w along the axis of symmetry."""


@pytest.mark.mends("30.also.axes")
def test_a_precession_by_a_quaternion_is_refused_with_the_angles_in_which_it_is_steady() -> None:
    start, rates = [math.cos(TILT / 2), math.sin(TILT / 2), 0, 0], [0, PRECESSION * math.sin(TILT), SPIN]
    text = HEAD + written([0, 0, ARM], [CENTRAL, CENTRAL, C], start, rates)
    with pytest.raises(symdyn.SymdynError, match='orientation = "zxz"'):
        symdyn.linearize(read_text(text))


def test_a_steady_precession_by_angles_nutates_as_its_equation_says() -> None:
    """A θ'' = -V'(θ), V = (p - s cos θ)²/(2 A sin² θ) + m g l cos θ, p and s the momenta of precession and spin."""
    own = SPIN - PRECESSION * math.cos(TILT)
    found = symdyn.linearize(read_text(by_angles(2, "zxz", [0, TILT, 0], [PRECESSION, 0, own])))
    s = C * SPIN
    p = A * PRECESSION * math.sin(TILT) ** 2 + s * math.cos(TILT)

    def V(x: float) -> float:
        return (p - s * math.cos(x)) ** 2 / (2 * A * math.sin(x) ** 2) + WEIGHT * math.cos(x)

    step = 1e-3
    curved = (V(TILT + step) - 2 * V(TILT) + V(TILT - step)) / step**2
    assert found.modes[0].value.imag == pytest.approx(math.sqrt(curved / A), rel=1e-5)
