"""Functions of momenta, Routh's, and that of Gibbs and Appell: against books, and motions that they tell."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_formulations import SPHERICAL, TOP

import symdyn
from symdyn.dynamics import Workspace, derive_one
from symdyn.emit import TARGETS, emit
from symdyn.errors import DerivationError
from symdyn.program import formulate, lower
from symdyn.scene import Scene, bind, read_text
from symdyn.verdict import Verdict
from symdyn.verify import certify

ALL = ("hamiltonian", "canonical_rates", "gibbs_function")
LAWS = ("momentum", "kinetic_energy", "potential_energy", "gravity_forces", "forward_dynamics")

KEPLER = """
name = "kepler"
gravity = [0, 0, 0]
[parameters]
m = { value = 0.8, unit = "kg", positive = true }
k = { value = 3.1, unit = "N m^2", positive = true }
[bodies.arm]
[bodies.planet]
particles = [{ mass = "m", at = [0, 0, 0] }]
[joints.sun]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 0, 1]
coordinate = "phi"
drive = false
[joints.ray]
type = "prismatic"
parent = "arm"
child = "planet"
axis = [1, 0, 0]
coordinate = "r"
drive = false
force = "-k/r**2"
"""


def value(scene: Scene, name: str, *given: object) -> float:
    return float(symdyn.lambdify(scene, name)(*given))


# Books


def test_the_spherical_pendulum_of_goldstein() -> None:
    """Classical Mechanics, 8.1: H = (p_θ² + p_φ² / sin² θ) / (2 m l²) - m g l cos θ, and R of its amended potential."""
    scene, m, length, g = read_text(SPHERICAL), 0.7, 1.1, 9.81
    for theta, p_phi, p_theta in ((0.4, 0.3, -0.2), (1.3, 0.0, 0.5), (math.pi / 2, 1.0, 0.0)):
        inertia, weight = m * length**2, m * g * length * math.cos(theta)
        amended = p_phi**2 / (2 * inertia * math.sin(theta) ** 2)
        H = p_theta**2 / (2 * inertia) + amended - weight
        assert value(scene, "hamiltonian", [0.9, theta], [p_phi, p_theta]) == pytest.approx(H, rel=1e-13)
        R = inertia * 0.7**2 / 2 - amended + weight
        assert value(scene, "routhian", [0.9, theta], [5.0, 0.7], [p_phi, 7.0]) == pytest.approx(R, rel=1e-13)


def test_the_heavy_symmetric_top_of_goldstein() -> None:
    """5.7: H = p_θ²/2A + (p_φ - p_ψ cos θ)²/(2 A sin² θ) + p_ψ²/2C + m g l cos θ, ψ the precession here."""
    scene, (A, C, m, length, g) = read_text(TOP), (0.05, 0.03, 0.7, 0.2, 9.81)
    q, (precession, nutation, spin) = [0.3, 0.8, 1.9], (0.11, 0.07, 0.2)
    theta, p = q[1], [precession, nutation, spin]
    amended = (precession - spin * math.cos(theta)) ** 2 / (2 * A * math.sin(theta) ** 2) + spin**2 / (2 * C)
    weight = m * g * length * math.cos(theta)

    H = nutation**2 / (2 * A) + amended + weight
    assert value(scene, "hamiltonian", q, p) == pytest.approx(H, rel=1e-12)
    R = A * 0.6**2 / 2 - amended - weight
    assert value(scene, "routhian", q, [0.0, 0.6, 0.0], p) == pytest.approx(R, rel=1e-12)
    assert derive_one(Workspace(scene), "routhian").text.endswith("; cyclic: psi, phi")


def test_keplers_problem_as_a_linkage() -> None:
    """Goldstein 8.2: ṗ_r = p_φ²/(m r³) - k/r², p_φ stays."""
    m, k, r, p_phi, p_r = 0.8, 3.1, 1.7, 0.9, -0.3
    found = symdyn.lambdify(read_text(KEPLER), "canonical_rates")([0.2, r], [p_phi, p_r], [0.0, 0.0])

    rates = [p_phi / (m * r**2), p_r / m, 0.0, p_phi**2 / (m * r**3) - k / r**2]
    assert found == pytest.approx(rates, rel=1e-13, abs=1e-15)


# Motions


@pytest.mark.parametrize("name", ["cart_pole", "heavy_top", "free_body", "crane"])
def test_slopes_of_h_are_the_rates_that_it_tells(name: str) -> None:
    """q̇ = ∂H/∂p; ṗ = -X H + brackets + τ + Q, of balls and free bodies those of Lie and Poisson, p × ω."""
    scene = symdyn.example(name)
    scene = bind(scene, {one.name: "1.3" for one in scene.free_parameters})
    n, rng = len(scene.velocities), np.random.default_rng(6)
    q, p, tau = (rng.uniform(-1, 1, size) for size in (len(scene.coordinates), n, n))
    q = q / np.linalg.norm(q) if name == "heavy_top" else q
    if name == "free_body":
        q[3:] /= np.linalg.norm(q[3:])
    slopes = np.ravel(symdyn.lambdify(scene, "hamiltonian_derivatives")(q, p))
    rates = symdyn.lambdify(scene, "canonical_rates")(q, p, tau)
    momenta = symdyn.lambdify(scene, "momentum")(q, rates[:n])

    assert rates[:n] == pytest.approx(slopes[n:], rel=1e-10)
    assert momenta == pytest.approx(p, rel=1e-10)
    if name == "heavy_top":
        assert rates[n:] == pytest.approx(-slopes[:n] + np.cross(p, rates[:n]) + tau, rel=1e-10)
    if name == "free_body":
        v, w = rates[:3], rates[3:6]
        turned = np.concatenate([np.cross(p[:3], w), np.cross(p[3:], w) + np.cross(p[:3], v)])
        assert rates[n:] == pytest.approx(-slopes[:n] + turned + tau, rel=1e-10)


@pytest.mark.long
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", ["heavy_top", "four_bar", "rolling_disc", "TOP", "KEPLER"])
def test_all_of_them_are_proved(name: str) -> None:
    """Trees with balls, loops and rows in rates: formulations, and laws that tie them to the equations of motion."""
    scene = read_text(globals()[name]) if name.isupper() else symdyn.example(name)
    some = (*ALL, *LAWS, "tree_forces" if scene.is_constrained else "inverse_dynamics")
    certificate = certify(scene, (*some, "routhian") if name.isupper() else some)
    claims = {one.claim.partition(":")[0] for one in certificate.findings if one.verdict == Verdict.PROVED}

    assert certificate.passed
    told = {*ALL, "Hamiltonian", "canonical rates", "Appell's equations"}
    told |= set() if scene.is_constrained else {"canonical power"}
    assert told | ({"Routh's function", "conserved momenta"} if name.isupper() else set()) <= claims


@pytest.mark.long
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize(
    ("name", "formulation", "law"),
    [
        ("pendulum", "hamilton", "canonical rates"),
        ("heavy_top", "port-hamiltonian", "canonical power"),
        ("gyroscope", "routh", "conserved momenta"),
        ("four_bar", "gibbs-appell", "Appell's equations"),
        ("four_bar", "udwadia-kalaba", "constraint_forces"),
        ("rocket", "hamilton", "canonical rates"),
    ],
)
def test_a_formulation_is_certified_by_its_functions_and_laws(name: str, formulation: str, law: str) -> None:
    certificate = certify(symdyn.example(name), formulation=formulation, targets=["numpy"])

    assert certificate.passed
    assert law in {one.claim.partition(":")[0] for one in certificate.findings if one.verdict == Verdict.PROVED}


@pytest.mark.parametrize(
    ("name", "formulation", "said"),
    [
        ("cart_pole", "routh", "Routh's function does not exist: no coordinate is cyclic"),
        (
            "cart_pole",
            "udwadia-kalaba",
            "constraint_forces is about closed loops and rows, of which cart_pole has none",
        ),
        ("four_bar", "routh", "routhian is about trees; loops or rows close four_bar"),
    ],
)
def test_what_a_scene_has_not_is_not_certified_and_says_why(name: str, formulation: str, said: str) -> None:
    with pytest.raises(DerivationError, match=said):
        certify(symdyn.example(name), formulation=formulation)


# Messages, letters, targets


def test_where_no_coordinate_is_cyclic_a_message_says_so() -> None:
    with pytest.raises(DerivationError, match=r"cart_pole: Routh's function does not exist: no coordinate is cyclic"):
        derive_one(Workspace(symdyn.example("cart_pole")), "routhian")
    with pytest.raises(DerivationError, match="routhian is about trees; loops or rows close four_bar"):
        derive_one(Workspace(symdyn.example("four_bar")), "routhian")


def test_a_force_that_names_a_coordinate_leaves_it_no_longer_cyclic() -> None:
    forced = read_text(KEPLER.replace('"phi"', '"phi"\nforce = "k*cos(phi)/r"'))

    assert Workspace(read_text(KEPLER)).cyclic == (0,)
    assert Workspace(forced).cyclic == ()


CLASH = SPHERICAL.replace("m = {", "p = {").replace('mass = "m"', 'mass = "p"').replace('"theta"', '"H"')


@pytest.mark.parametrize("target", TARGETS)
def test_every_target_writes_them_for_a_scene_with_their_letters(target: str) -> None:
    """A mass p, free, and a coordinate H."""
    scene = read_text(CLASH.replace("value = 0.7, ", ""))
    row = TARGETS[target]
    if row.functions is not None:  # it is a model of its own functions
        return
    assert emit(lower(formulate(scene, (*ALL, "routhian"))), target)
