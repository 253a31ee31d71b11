"""Energy shaping and damping by drives: against matching by hand, energy control, PD control; and by proof."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from test_linearizing import ACROBOT, LED_AS_WELL, value, with_outputs

import symdyn
from symdyn.dynamics import Workspace, derive_one
from symdyn.emit import TARGETS, emit
from symdyn.errors import DerivationError
from symdyn.program import Program, formulate, lower
from symdyn.scene import Quantity, Scene, bind, read_text
from symdyn.verdict import Verdict
from symdyn.verify import certify

WHEEL = """
name = "wheel"
units = "none"
gravity = [0, -9.81, 0]
[parameters]
m3 = 1.3
I1 = 0.25
I2 = 0.2
a1 = 1
a2 = -2
a3 = 5
k = 0.7
[bodies]
rod = { mass = "m3/9.81", com = [0, 1, 0], inertia = ["I1", "I1/2", "I1"], inertia_about = "frame" }
disc = { inertia = ["I2", "I2", "I2"], inertia_about = "com" }
[joints]
hinge = { type = "revolute", parent = "ground", child = "rod", axis = [0, 0, 1], coordinate = "q1", drive = false }
axle = { type = "revolute", parent = "rod", child = "disc", axis = [0, 0, 1], coordinate = "r", drive = "u" }
"""
"""The inertia wheel pendulum; q2 = q1 + r is the angle of the wheel in space, in which M = diag(I1, I2)."""

SHAPED = (
    "(a3*I1**2*q1_dot**2 - 2*a2*I1*I2*q1_dot*(q1_dot + r_dot) + a1*I2**2*(q1_dot + r_dot)**2)/(2*(a1*a3 - a2**2))"
    " + I1*m3/(a1 + a2)*cos(q1) + k/2*(q1 + r - I1*(a2 + a3)/(I2*(a1 + a2))*q1)**2"
)
"""H_d = p·M_d⁻¹ p / 2 + V_d of Ortega, Spong, Gómez-Estern and Blankenstein (2002), M_d = [a1, a2; a2, a3]."""

STATES = [([0.0, 0.0], [0.0, 0.0]), ([math.pi, 0.3], [0.5, -0.2]), ([0.4, 0.4], [-1.0, 2.0])]


def wheel(**outputs: str) -> Scene:
    return with_outputs(read_text(WHEEL), **({"H": SHAPED} | outputs))


@pytest.mark.parametrize(("q", "u"), STATES)
def test_the_inertia_wheel_pendulum_is_shaped_as_matching_by_hand_has_it(q: list[float], u: list[float]) -> None:
    """τ from the rows of [-1; 1] u = ∇V - M_d M⁻¹ ∇V_d, J_2 = 0; damping by -Gᵀ M_d⁻¹ p."""
    m3, I1, I2, a1, a2, a3, k = 1.3, 0.25, 0.2, 1, -2, 5, 0.7
    g2 = -I1 * (a2 + a3) / (I2 * (a1 + a2))
    z = q[0] + q[1] + g2 * q[0]
    by_hand = a2 * m3 / (a1 + a2) * math.sin(q[0]) - k * z * (a2 * g2 / I1 + a3 / I2)
    forces = value(wheel(), "shaping_forces:H", q, u)
    assert forces == pytest.approx([0, by_hand], abs=1e-12)
    assert value(wheel(), "output_rate:H", q, u, forces) == pytest.approx([0], abs=1e-12)

    p = np.array([I1 * u[0], I2 * (u[0] + u[1])])
    slopes = np.linalg.solve([[a1, a2], [a2, a3]], p)
    assert value(wheel(), "damping_forces:H", q, u) == pytest.approx([0, slopes[0] - slopes[1]], abs=1e-12)


@pytest.mark.runs("cc")
def test_its_energy_falls_where_it_is_damped() -> None:
    scene = wheel()
    shape, damp = (symdyn.lambdify(scene, f"{name}_forces:H") for name in ("shaping", "damping"))

    def control(t: float, q: np.ndarray, u: np.ndarray) -> list[float]:
        return [(shape(q, u) + 5 * damp(q, u))[1]]

    run = symdyn.simulate(scene, until=4, start={"q1": 0.8}, forces=control)
    energy = symdyn.lambdify(scene, "output:H")
    states = zip(*(run[name] for name in ("q1", "r", "q1_dot", "r_dot")), strict=True)
    falls = np.diff([energy(one[:2], one[2:], [0, 0]) for one in states])
    assert falls.max() < 1e-6
    assert falls.sum() < -0.5


@pytest.mark.parametrize(("q", "u"), STATES)
def test_swinging_up_by_energy_is_damping_of_its_error(q: list[float], u: list[float]) -> None:
    """Åström and Furuta (2000): the force is -(E - E_0) times the drive's velocity, which is Bᵀ q̇."""
    scene = with_outputs(symdyn.example("cart_pole"), swing="(kinetic_energy + potential_energy - 3)**2/2")
    error = value(scene, "kinetic_energy", q, u)[0] + value(scene, "potential_energy", q)[0] - 3
    found = value(scene, "damping_forces:swing", q, u)

    assert found == pytest.approx([-error * u[0], 0], abs=1e-12)


def test_a_driven_arm_is_shaped_as_by_a_spring_and_compensated_weight() -> None:
    """Takegaki and Arimoto (1981): τ = g - k q for H_d = K + k |q|²/2."""
    arm = symdyn.example("two_link")
    arm = with_outputs(
        bind(arm, {one.name: "1.3" for one in arm.free_parameters}), H="kinetic_energy + 2*(q1**2 + q2**2)"
    )
    q, u = [0.3, -0.8], [1.0, 0.4]

    weights = value(arm, "gravity_forces", q)
    assert value(arm, "shaping_forces:H", q, u) == pytest.approx(np.subtract(weights, np.multiply(4, q)), rel=1e-12)


@pytest.mark.parametrize(("q", "u"), STATES)
def test_a_lyapunov_function_falls_as_its_controller_has_it(q: list[float], u: list[float]) -> None:
    """As Lozano, Fantoni and Block (2000) bring a cart and its pole to the upright: V = E²/2 + ... has V' = -c ẋ²."""
    energy = "kinetic_energy + potential_energy - 1.2"
    scene = with_outputs(symdyn.example("cart_pole"), V=f"({energy})**2/2 + 0.3*x_dot**2 + 0.2*x**2", E=energy)
    a, B = value(scene, "decoupling_row:V", q, u)[:2]
    controlled = [(-0.4 * u[0] ** 2 - a) / B if B else 0.0, 0.0]
    assert value(scene, "output_rate:V", q, u, controlled) == pytest.approx([-0.4 * u[0] ** 2], abs=1e-9)

    (E,), (power,) = value(scene, "output:E", q, u, [0.7, 0.0]), value(scene, "output_rate:E", q, u, [0.7, 0.0])
    by_hand = E * power + 0.6 * u[0] * value(scene, "forward_dynamics", q, u, [0.7, 0.0])[0] + 0.4 * q[0] * u[0]
    assert value(scene, "output_rate:V", q, u, [0.7, 0.0]) == pytest.approx([by_hand], rel=1e-9, abs=1e-12)


@pytest.mark.usefixtures("numpy_alone")
def test_it_is_proved_that_shaped_energies_change_by_losses_alone_and_damping_by_its_square() -> None:
    scene = wheel(E="(kinetic_energy + potential_energy)**2/2")
    scene = replace(scene, joints=tuple(replace(one, damping=Quantity.number(1)) for one in scene.joints))
    names = ("shaping_forces:H", "damping_forces:E", "damping_forces:H", "output_rate:H", "output_rate:E")
    certificate = certify(scene, (*names, "forward_dynamics"))
    proved = {one.claim.partition(":")[0] for one in certificate.findings if one.verdict == Verdict.PROVED}

    assert certificate.passed
    assert {"shaped energies", "damped functions", "shaping_forces", "damping_forces"} <= proved


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("q1_dot**2 + r_dot**2 + cos(q1)", "H does not match: its potential energy cannot be kept.*by 1.49"),
        ("q1_dot**3", "H is no shaped energy: that is quadratic in velocities"),
        ("q1_dot + q1_dot**2", "H is no shaped energy: that is quadratic in velocities"),
        ("q1_dot**2 + t", "H is no function of coordinates, velocities and parameters alone"),
        ("q1 + r", "H does not feel every drive in a way of its own"),
    ],
)
def test_what_is_no_shaped_energy_says_why(formula: str, said: str) -> None:
    with pytest.raises(DerivationError, match=f"wheel: output {said}"):
        derive_one(Workspace(wheel(H=formula)), "shaping_forces:H")


def test_kinetic_energy_that_does_not_match_is_told_from_potential_energy() -> None:
    weightless = read_text(WHEEL.replace("[0, -9.81, 0]", "[0, 0, 0]"))
    scene = with_outputs(weightless, H="(2 + q1**2)*q1_dot**2 + r_dot**2", free="kinetic_energy")
    with pytest.raises(DerivationError, match="H does not match: its kinetic energy cannot be kept"):
        derive_one(Workspace(scene), "shaping_forces:H")
    assert value(scene, "shaping_forces:free", [0.3, 0.2], [1.0, 2.0]) == [0, 0]


def test_where_drives_have_no_part_in_it_messages_say_so() -> None:
    with pytest.raises(DerivationError, match="wheel: output y has no drive in its rate; take one that velocities"):
        derive_one(Workspace(wheel(y="q1")), "damping_forces:y")
    with pytest.raises(DerivationError, match=r"led: output y is shaped where no motion|is shaped where no motion is"):
        derive_one(Workspace(with_outputs(read_text(LED_AS_WELL), y="kinetic_energy")), "shaping_forces:y")
    four_bar = with_outputs(symdyn.example("four_bar"), y="kinetic_energy")
    with pytest.raises(DerivationError, match="shaping_forces:y is about trees; loops or rows close four_bar"):
        derive_one(Workspace(four_bar), "shaping_forces:y")
    with pytest.raises(DerivationError, match="acrobot has no outputs; declare one"):
        derive_one(Workspace(read_text(ACROBOT)), "shaping_forces:y")


@pytest.mark.usefixtures("numpy_alone")
def test_damping_of_a_loop_takes_its_square_from_the_rate() -> None:
    four_bar = with_outputs(symdyn.example("four_bar"), y="kinetic_energy")
    certificate = certify(four_bar, ("damping_forces:y", "output_rate:y", "forward_dynamics"))

    assert "damped functions" in {one.claim.partition(":")[0] for one in certificate.findings}


def test_energies_are_letters_of_outputs_and_a_parameter_of_that_name_stays_one() -> None:
    pendulum = with_outputs(symdyn.example("pendulum"), E="kinetic_energy + potential_energy")
    K, P = value(pendulum, "kinetic_energy", [0.4], [2.0])[0], value(pendulum, "potential_energy", [0.4])[0]
    assert value(pendulum, "output:E", [0.4], [2.0], [0.0]) == pytest.approx([K + P])
    own = read_text(WHEEL.replace("k = 0.7", "kinetic_energy = 7") + '[outputs.y]\nformula = "kinetic_energy + q1"\n')
    assert value(own, "output:y", [0.5, 0], [0, 0], [0, 0]) == pytest.approx([7.5])


@cache
def clashing() -> Program:
    """Return a program of a coordinate V and an output tau."""
    scene = with_outputs(
        read_text(WHEEL.replace('"r"', '"V"')), tau=SHAPED.replace("r_dot", "V_dot").replace(" r ", " V ")
    )
    return lower(formulate(scene, ("shaping_forces:tau", "damping_forces:tau", "damping_forces_by_qd:tau")))


@pytest.mark.parametrize("target", [name for name, row in TARGETS.items() if row.functions is None])
def test_every_target_writes_them_for_a_scene_with_their_letters(target: str) -> None:
    assert emit(clashing(), target)
