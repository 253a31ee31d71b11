"""What a mechanism is in general decides its reactions: planes, redundancy, natural positions, given drives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from arms import EXAMPLES

import symdyn
from symdyn.cli import main
from symdyn.dynamics import Workspace, derive, reactions_at
from symdyn.dynamics.loops.mobility import mobility
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.errors import DerivationError
from symdyn.scene import read_text

DATA = Path(__file__).parent / "data"
FOUND = DATA / "found"


COAXIAL = """
name = "coaxial"
gravity = "none"
[bodies]
wheel = { mass = 1, inertia = [1, 1, 2], inertia_about = "com" }
[joints]
hinge = { type = "revolute", parent = "ground", child = "wheel", origin = [["Rx", 0.7]], start = 0.5 }
[[loop]]
name = "bearing"
type = "cylindrical"
parent = "ground"
child = "wheel"
origin = [["Rx", 0.7], ["Tz", 0.5]]
tip = { xyz = [1.2e-17, 3.9e-18, 0.5] }
"""


def found(name):
    return symdyn.read(FOUND / f"{name}.toml")


def moving(scene, q, seed=1, passive=False):
    """Return (q, u, u̇, τ) that the loops and contacts allow: random u and τ, τ = 0 where nothing drives."""
    rng = np.random.default_rng(seed)
    n = len(scene.velocities)
    G = symdyn.lambdify(scene, "constraint_jacobian")(q)
    u = rng.uniform(-1, 1, n)
    u -= np.linalg.pinv(G) @ G @ u
    tau = rng.uniform(-1, 1, n) * [bool(drive) or passive for drive in scene.drives]
    return q, u, symdyn.lambdify(scene, "forward_dynamics")(q, u, tau), tau


def both_doors(scene, q):
    """Return `reactions`, `forward_reactions`, and `reactions_at`, during one motion."""
    q, u, a, tau = moving(scene, q)
    assert np.isfinite(a).all()
    doors = (symdyn.lambdify(scene, "reactions")(q, u, a), symdyn.lambdify(scene, "forward_reactions")(q, u, tau))
    return *doors, reactions_at(scene, q, u, a)


# What lies across a plane


@pytest.mark.mends("3.1")
def test_a_contact_that_leans_pushes_along_its_normal():
    """16.35 N up are 27.25 N along (0, 3, 4)/5: the plane of the motion says nothing of what a wrench is."""
    scene = found("oblique_contact")
    still = [0.0, 0.0, 0.0]

    R = symdyn.lambdify(scene, "forward_reactions")(still, still, still)
    np.testing.assert_allclose(R[1], [0, 16.35, 21.8, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(R[0], [0, 0, -21.8, 0, 0, 0], atol=1e-12)


@pytest.mark.mends("3.1")
@pytest.mark.parametrize("name", ["oblique_contact", "offset_rod"])
def test_two_doors_tell_one_reaction(name):
    scene = found(name)
    q = np.array(Workspace(scene).loops.decisions.assembly.q)
    inverse, forward, least = both_doors(scene, q)

    assert least.possible
    assert least.unique.all()
    np.testing.assert_allclose(inverse, least.wrenches, atol=1e-9)
    np.testing.assert_allclose(forward, least.wrenches, atol=1e-9)


@pytest.mark.mends("3.1")
def test_a_rod_pushes_along_itself():
    """From (0.3, 0, 0) on a to (0.3, 0, 0.2) on b."""
    scene = found("offset_rod")
    R = symdyn.lambdify(scene, "reactions:ground")([1.0, 1.0], [0.0, 0.0], [3.0, 3.0])
    force, way = R[2, :3], np.array([0.5, 0, 0.2])

    assert abs(force[2]) > 0.1
    np.testing.assert_allclose(np.cross(force, way), 0, atol=1e-12)


# Natural positions


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.mends("3.2")
@pytest.mark.parametrize(("yaw", "reduced"), [(0.0, 0.1), (0.3, 0.0), (0.0, 0.0), (0.0, -0.2), (np.pi / 2, 0.0)])
def test_a_rolling_disc_has_reactions_at_natural_positions(yaw, reduced):
    scene = found("rolling_disc_zxy")
    inverse, forward, least = both_doors(scene, np.array([0.4, -0.3, 0.26 * np.cos(reduced), yaw, reduced, 0.7]))

    assert least.possible
    assert least.unique.all()
    np.testing.assert_allclose(inverse, least.wrenches, atol=1e-9)
    np.testing.assert_allclose(forward, least.wrenches, atol=1e-9)


@pytest.mark.long
@pytest.mark.mends("3.2")
def test_an_upright_bicycle_has_reactions():
    scene = symdyn.read(DATA / "bicycle.toml")
    inverse, forward, least = both_doors(scene, np.array(Workspace(scene).loops.decisions.assembly.q))

    assert least.possible
    assert least.unique.all()
    np.testing.assert_allclose(inverse, least.wrenches, atol=1e-7)
    np.testing.assert_allclose(forward, least.wrenches, atol=1e-7)


# Drives that are given, joints that only look redundant


@pytest.mark.mends("3.6")
def test_two_motors_with_given_torques_determine_all_reactions():
    """Body c: pin, bearing and weight give it its acceleration."""
    scene = found("two_motors")
    q = np.array(Workspace(scene).loops.decisions.assembly.q)
    q, u, a, tau = moving(scene, q)
    R = symdyn.lambdify(scene, "forward_reactions:ground")(q, u, tau)

    at = symdyn.lambdify(scene, "com_acceleration:c")(q, u, a)
    np.testing.assert_allclose(R[2, :3] + R[3, :3] + [0, -9.81, 0], at, atol=1e-9)
    np.testing.assert_allclose(R[[0, 2], 5], tau[[0, 2]], atol=1e-9)
    with pytest.raises(DerivationError, match=r"over-actuated, 2 drives .* of ja.* of jc"):
        derive(scene, ["reactions"])


@pytest.mark.mends("3.6")
def test_a_joint_that_turns_and_slides_on_one_coordinate_is_not_overconstrained():
    """1 kg that slides 0.1 m a radian along an axis that turns with it: F = m a, seen from the body."""
    scene = found("cam")
    u, v, a = 0.3, 2.0, 5.0
    R = symdyn.lambdify(scene, "reactions")([u], [v], [a])

    force = [0.1 * a - 0.1 * u * v * v, 0.2 * v * v + 0.1 * u * a, 9.81]
    np.testing.assert_allclose(R[0, :3], force, atol=1e-12)
    assert R[0, 5] == pytest.approx(0.4 * a, abs=1e-12)  # about the body's own origin, its centre of mass


@pytest.mark.mends("3.6")
def test_a_body_that_loops_hold_bears_one_that_swings():
    """A ball at the ground that a hinge keeps from turning: only what hangs on it moves, by its weight."""
    scene = found("no_prescribed")
    q = np.array(Workspace(scene).loops.decisions.assembly.q)
    a = symdyn.lambdify(scene, "forward_dynamics")(q, np.zeros(4), np.zeros(4))
    R = symdyn.lambdify(scene, "pose:b1")(q)[:, :3]

    weight = R.T @ [0, 0, -9.81]
    np.testing.assert_allclose(a[:3], 0, atol=1e-9)
    assert a[3] == pytest.approx(0.1 * weight[1] / (0.3 + 0.01), rel=1e-9)


SLEIGH = """
name = "sleigh"
[bodies]
sled = { mass = 2, com = [0.1, 0, 0.2], inertia = [0.02, 0.04, 0.05], inertia_about = "com" }
[joints.on]
type = "planar"
parent = "ground"
child = "sled"
axis = [0, 0, 1]
coordinates = ["x", "y", "phi"]
drive = false
[constraints.blade]
type = "knife_edge"
body = "sled"
axis = [0, 1, 0]
"""


@pytest.mark.mends("3.2")
@pytest.mark.parametrize("heading", [0.0, np.pi / 2, -np.pi / 2])
def test_a_blade_has_motions_and_reactions_at_every_heading(heading):
    """Whichever velocities go before: at some heading they leave one open. With t along the blade, m v' = F t + m l w²,
    and (I + m l²) w' = M - m l v w."""
    scene = symdyn.scene.read_text(SLEIGH, "sleigh.toml")
    forward, reactions = (symdyn.lambdify(scene, name) for name in ("forward_dynamics", "forward_reactions"))
    q, c, s = np.array([0.2, -0.3, heading]), np.cos(heading), np.sin(heading)
    u, tau = np.array([0.5 * c, 0.5 * s, 2.0]), np.array([1.0, 2.0, 0.3])

    faster, turning = (c * tau[0] + s * tau[1]) / 2 + 0.1 * 4, (0.3 - 2 * 0.1 * 0.5 * 2) / (0.05 + 2 * 0.01)
    expected = [faster * c - 0.5 * s * 2, faster * s + 0.5 * c * 2, turning]
    np.testing.assert_allclose(forward(q, u, tau), expected, atol=1e-12)
    least = reactions_at(scene, q, u, forward(q, u, 0 * tau))
    assert least.unique.all()
    np.testing.assert_allclose(reactions(q, u, 0 * tau), least.wrenches, atol=1e-9)


# Words and order


@pytest.mark.mends("3.7")
def test_independent_velocities_keep_the_order_that_was_asked_for():
    scene = symdyn.read(EXAMPLES / "rolling_disc.toml")
    names = [str(s.value) for s in derive(scene, ["velocities"])["velocities"].arguments[1].symbols][::-1]
    function = derive(scene, ["velocities"], closing=LoopChoices(tuple(names)))["velocities"]

    assert [str(s.value) for s in function.arguments[1].symbols] == names
    assert f"independent joint velocities: {', '.join(names)}" in function.arguments[1].text
    q = np.array(Workspace(scene).loops.decisions.assembly.q)
    found = symdyn.lambdify(scene, "velocities", closing=LoopChoices(tuple(names)))(q, [1.0, 2.0, 3.0])
    assert [found[scene.velocities.index(name)] for name in names] == [1, 2, 3]


@pytest.mark.mends("3.13")
def test_drives_that_are_too_many_are_told_with_their_joints():
    with pytest.raises(DerivationError, match=r"over-actuated, 2 drives \(tau1 of ja, tau3 of jc\) for 1 degree"):
        derive(found("two_motors"), ["inverse_dynamics"])


SINGULAR = """
name = "weightless"
[parameters]
gross = { value = 1, unit = "kg" }
tare = { value = 1, unit = "kg" }
[bodies]
tray = { mass = "gross - tare", com = [0.1, 0, 0] }
[joints]
hinge = { type = "revolute", parent = "ground", child = "tray" }
"""


@pytest.mark.mends("3.13")
def test_a_mass_that_is_zero_by_its_parameters_is_told_with_its_joint(tmp_path, capsys):
    path = tmp_path / "weightless.toml"
    path.write_text(SINGULAR, encoding="utf-8")

    assert main(["info", str(path)]) == 0  # what has no accelerations has forces all the same
    assert "a motion of the joint hinge, which carries tray, moves no mass" in capsys.readouterr().err


def test_a_rounded_offset_is_no_lever() -> None:
    """Two hinges whose axes are the same but for 1e-17 m turn as one."""
    scene = read_text(COAXIAL, "coaxial.toml")

    assert mobility(scene).by_rank == 1
    assert symdyn.lambdify(scene, "forward_dynamics")([0.5], [0.0], [2.0]) == pytest.approx([1.0])
