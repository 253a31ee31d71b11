"""What solves with the mass matrix, multipliers of least norm, the centre of pressure, and requests of frames."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import DerivationError, SymdynError
from symdyn.runtime import lambdify
from symdyn.scene import Scene, read_text

LEG = """
name = "leg"
gravity = [0, 0, "-9.81"]
[bodies.trunk]
mass = 6
com = [0.01, 0.02, 0.1]
inertia = { xx = 0.2, yy = 0.3, zz = 0.1, xz = 0.01 }
inertia_about = "com"
[bodies.shank]
mass = 2
com = [0, 0, -0.2]
inertia = [0.03, 0.03, 0.002]
inertia_about = "com"
[bodies.foot]
mass = 1
com = [0.03, 0, -0.02]
inertia = [0.002, 0.004, 0.005]
inertia_about = "com"
[joints.base]
type = "free"
parent = "ground"
child = "trunk"
drive = false
start = [0, 0, 0.45, 1, 0, 0, 0]
[joints.knee]
type = "revolute"
parent = "trunk"
child = "shank"
axis = [0, 1, 0]
[joints.ankle]
type = "revolute"
parent = "shank"
child = "foot"
axis = [0, 1, 0]
origin = [0, 0, -0.4]
"""
CORNERS = {"a": (0.1, 0.05), "b": (0.1, -0.05), "c": (-0.05, 0.05), "d": (-0.05, -0.05)}


def held(*corners: str, z: float = -0.05) -> Scene:
    """Return the leg, corners of its foot held where they stand at the start, each by a ball."""
    text = LEG
    for name in corners:
        x, y = CORNERS[name]
        text += f'[points.{name}]\nbody = "foot"\nat = [{x}, {y}, {z}]\n'
        text += f'[[loop]]\nname = "hold_{name}"\ntype = "spherical"\nparent = "ground"\nchild = "foot"\n'
        text += f"origin = [{x}, {y}, 0]\nchild_origin = [{x}, {y}, {z}]\n"
    return read_text(text, "leg.toml")


def state(scene: Scene, seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions at which the foot stands flat, velocities at which it rests, and drives."""
    rng = np.random.default_rng(seed)
    q = np.array([0, 0, 0.45, 1, 0, 0, 0, 0, 0], float)
    return q, np.zeros(8), np.r_[np.zeros(6), rng.uniform(-1, 1, 2)]


def test_multipliers_of_least_norm_are_those_of_the_pseudo_inverse():
    """Four corners held: twelve rows, six of which the others imply; their forces are the same."""
    scene = held(*CORNERS)
    names = [f"jacobian:{name}" for name in CORNERS]
    least, forces, *rows = lambdify(scene, ["minimum_norm_multipliers", "constraint_forces", *names])
    q, u, tau = state(scene)
    G = np.vstack([J(q)[:3] for J in rows])
    f = forces(q, u, tau)

    assert np.linalg.matrix_rank(G) == 6
    assert least(q, u, tau) == pytest.approx(np.linalg.pinv(G.T) @ f, abs=1e-10)
    assert G.T @ least(q, u, tau) == pytest.approx(f, abs=1e-10)


def test_without_redundant_rows_multipliers_are_those_of_least_norm():
    scene = symdyn.example("four_bar")
    least, multipliers = lambdify(scene, ["minimum_norm_multipliers", "multipliers"])
    point = symdyn.dynamics.Workspace(scene).loops.decisions.assembly.regular
    given = np.asarray(point), np.full(len(scene.velocities), 0.3), np.ones(len(scene.velocities))

    assert multipliers(*given) == pytest.approx([x for x in least(*given) if x], rel=1e-9)


def test_the_centre_of_pressure_is_that_of_the_forces_at_the_corners():
    scene = held(*CORNERS)
    least, pressure, motion = lambdify(scene, ["minimum_norm_multipliers", "centre_of_pressure", "forward_dynamics"])
    q, u, tau = state(scene)
    F = least(q, u, tau).reshape(4, 3)
    at = np.array([[*xy, 0] for xy in CORNERS.values()])
    moment, force = np.cross(at, F).sum(axis=0), F.sum(axis=0)

    found = pressure(q, u, motion(q, u, tau))
    assert found == pytest.approx([-moment[1] / force[2], moment[0] / force[2], 0], abs=1e-12)


def test_standing_still_it_is_below_the_centre_of_mass():
    scene = symdyn.example("quadruped")
    pressure, centre = lambdify(scene, ["centre_of_pressure", "centre_of_mass"])
    q = np.array([0.3, -0.2, 0.4, 0.8, 0.6, 0, 0, *np.linspace(-1, 1, 12)])
    zero = np.zeros(18)

    assert pressure(q, zero, zero) == pytest.approx([*centre(q)[:2], 0], abs=1e-14)


def test_closed_scenes_solve_with_the_matrix_of_the_tree():
    scene = held("a")
    M, inverse, solve = lambdify(scene, ["mass_matrix", "mass_matrix_inverse", "mass_matrix_solve"])
    q, b = state(scene)[0], np.linspace(-1, 1, 8)

    assert inverse.__name__ == "tree_mass_matrix_inverse"
    assert M(q) @ inverse(q) == pytest.approx(np.eye(8), abs=1e-12)
    assert M(q) @ solve(q, b) == pytest.approx(b, abs=1e-12)


def test_a_frame_moves_as_its_jacobian_says():
    """V = J u and V̇ = J u̇ + J̇ u in every frame; a word for the usual one changes nothing."""
    scene = symdyn.example("arm7")
    body = scene.bodies[-1].name
    q, u, a = np.random.default_rng(5).uniform(-1, 1, (3, 7))
    for frame in ("", ":local", ":world", ":aligned"):
        kinds = ("jacobian", "velocity", "jdot_qdot", "acceleration")
        J, V, bias, A = lambdify(scene, [f"{kind}:{body}{frame}" for kind in kinds])
        assert V(q, u) == pytest.approx(J(q) @ u, abs=1e-12)
        assert A(q, u, a) == pytest.approx(J(q) @ a + bias(q, u), abs=1e-11)
        if frame == ":aligned":
            assert np.array_equal(J(q), lambdify(scene, f"jacobian:{body}")(q))


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("jacobian:tip:locl", r"there is no frame 'locl'; did you mean local\?"),
        ("jacobian:tpi:local", r"there is no body or point 'tpi'; did you mean tip\?"),
        ("jacobian:tip:", "there is no frame ''; there are aligned, local, world"),
        ("velocty:tip", "did you mean velocity:NAME"),
        ("velocity", "velocity needs a point; write velocity:NAME, such as velocity:tip"),
        ("pose:tip:local", "pose is in no frame that can be chosen; jacobian:NAME, jdot_qdot:NAME, velocity:NAME"),
        ("mass_matrix:tip:local", "mass_matrix is about the whole scene|in no frame"),
        ("mass_matrix_invers", r"did you mean mass_matrix_inverse\?"),
        ("minimum_norm_multipliers", "is about closed loops and rows, of which cart_pole has none"),
    ],
)
@pytest.mark.parametrize(
    "door", [pytest.param(symdyn.load, marks=pytest.mark.runs), symdyn.dynamics.derive, symdyn.lambdify]
)
def test_what_cannot_be_asked_for_is_refused_at_once(asked, told, door):
    with pytest.raises(SymdynError, match=told):
        door(symdyn.example("cart_pole"), [asked])


def test_without_gravity_there_is_no_centre_of_pressure():
    with pytest.raises(DerivationError, match="there is no centre of pressure without gravity"):
        symdyn.dynamics.derive(read_text(LEG.replace('"-9.81"', "0"), "leg.toml"), ["centre_of_pressure"])


# Frames and names, limits, manipulability


def test_two_functions_never_have_one_name():
    """A body called foot_local beside the local frame of the foot would have its name in code."""
    scene = read_text(LEG.replace('"shank"', '"foot_local"').replace("bodies.shank", "bodies.foot_local"), "leg.toml")

    with pytest.raises(
        DerivationError, match="jacobian:foot:local would be called in code what jacobian:foot_local is"
    ):
        symdyn.dynamics.derive(scene, ["jacobian:foot:local"])


def test_a_ball_turns_by_the_exponential_of_its_group():
    """A quaternion behind other coordinates, steps of any length, and half a turn: the sign of the axis is free."""
    top = symdyn.example("heavy_top")
    integrate, difference, by_step = lambdify(top, ["integrate", "difference", "integrate_jacobian"])
    e = np.array([0.5, 0.5, -0.5, 0.5])
    for step in np.array([[0.3, -2, 1], [1e-9, 0, 2e-9], [0, 0, 0], [0.2, 0.05, -0.1], [0, 0.25, 0]]):
        after = integrate(e, step)
        A, J = np.split(by_step(e, step), 2, axis=1)
        assert after @ after == pytest.approx(1, abs=1e-15)
        assert difference(e, after) == pytest.approx(step, abs=1e-14)
        assert difference(e, -after) == pytest.approx(step, abs=1e-14)
        assert A @ step == pytest.approx(step, abs=1e-14)
        assert J @ step == pytest.approx(step, abs=1e-14)
        assert np.allclose(A @ A.T, np.eye(3), rtol=0, atol=1e-14)
    assert np.abs(difference([1, 0, 0, 0], [0, 0, 1, 0])) == pytest.approx([0, np.pi, 0], abs=1e-15)


def test_limits_stand_where_coordinates_and_velocities_do():
    limited = LEG.replace("[joints.ankle]", '[joints.ankle]\nlimits = { lower = "-a", upper = 0.7, effort = 40 }')
    scene = read_text(limited.replace("[bodies.trunk]", "[parameters]\na = {}\n[bodies.trunk]"), "leg.toml")
    found = symdyn.scene.limits(scene, {"a": 0.5})

    assert {key: len(values) for key, values in found.items()} == {"lower": 9, "upper": 9, "velocity": 8, "effort": 8}
    assert [found["lower"][-1], found["upper"][-1], found["velocity"][-1], found["effort"][-1]] == [
        -0.5,
        0.7,
        np.inf,
        40,
    ]
    assert np.isinf(found["lower"][:-1]).all()
    with pytest.raises(SymdynError, match=r"leg: joints.ankle: limits.lower depends on a; give values in parameters"):
        symdyn.scene.limits(scene)


def test_manipulability_is_the_root_of_the_determinant():
    """At a stretched arm it is zero; of many Jacobians at once too."""
    from symdyn.dynamics import manipulability, singular_values

    scene = symdyn.example("puma560")
    jacobian = lambdify(scene, "jacobian:tool")
    J = np.array([jacobian(q) for q in np.random.default_rng(2).uniform(-1, 1, (3, 6))])
    linear = J[:, :3]

    assert manipulability(J) == pytest.approx(np.sqrt(np.linalg.det(linear @ linear.transpose(0, 2, 1))))
    assert manipulability(J, "all") == pytest.approx(np.abs(np.linalg.det(J)), abs=1e-12)
    assert singular_values(J, "angular").shape == (3, 3)
    assert manipulability([[0, 0], [2, 1]], "all") == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize(
    ("jacobian", "part", "told"),
    [
        (np.eye(6), "liner", r"part = 'liner' is not known; did you mean linear\?"),
        (np.eye(5), "linear", r"jacobian has shape \(5, 5\); give finite numbers in six rows"),
        ([1, 2], "all", r"jacobian has shape \(2,\); give finite numbers in rows and columns"),
        (np.full((6, 2), np.nan), "all", "give finite numbers"),
        ("J", "all", "give finite numbers"),
    ],
)
def test_what_is_no_jacobian_is_told(jacobian, part, told):
    with pytest.raises(SymdynError, match=told):
        symdyn.dynamics.singular_values(jacobian, part)


@pytest.mark.slow
@pytest.mark.runs("cc")
def test_written_code_of_all_of_it_is_read_back_and_agrees():
    """One and many states: an argument's name is no name of the code's own, and a function may take nothing."""
    scene, body = symdyn.example("free_body"), "wingnut"
    asked = ["integrate", "difference", "integrate_jacobian", "difference_jacobian", "mass_matrix_solve", "neutral"]
    asked += ["mass_matrix_inverse", "mass_matrix_factors", f"acceleration:{body}:local", f"jacobian:{body}:world"]
    found = symdyn.certify(scene, asked, targets=("c", "casadi"))

    assert found.passed, str(found)


@pytest.mark.slow
@pytest.mark.usefixtures("numpy_alone")
def test_redundant_rows_and_pressure_are_proved():
    assert symdyn.certify(held(*CORNERS), ["minimum_norm_multipliers", "centre_of_pressure"]).passed
