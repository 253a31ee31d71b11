"""Contacts that are held as a mask says at run time: against KKT equations, Pinocchio, least squares; and refusals."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from robots import robot_folder

import symdyn
from symdyn.algebra import Batches
from symdyn.dynamics import derive
from symdyn.errors import ArgumentError, DerivationError, SceneError
from symdyn.graph import evaluate
from symdyn.runtime import lambdify
from symdyn.scene import Scene, read_text, with_contacts
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.urdf import read

EXAMPLES = Path(__file__).parent.parent / "examples"
FEET = ["fl_foot", "fr_foot", "rl_foot", "rr_foot"]
STANCES = np.array(list(product((0.0, 1.0), repeat=4)))
AXES = (1, 2, 0)
"""Places of a force along x, y, z, of normal, along, across."""

BODY = """
[bodies.b]
mass = 2
com = [0.01, 0.02, 0]
inertia = [0.05, 0.06, 0.07]
inertia_about = "com"
[joints.free]
type = "free"
parent = "ground"
child = "b"
"""

ARM = """
units = "none"
[bodies.x]
mass = 1
[bodies.a]
mass = 1
com = [0.3, 0, 0]
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[bodies.c]
mass = 1.5
com = [0.2, 0, 0.1]
inertia = [0.1, 0.2, 0.1]
inertia_about = "com"
[joints.slide]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "x"
motion = "0.1*sin(2*t)"
[joints.j1]
type = "revolute"
axis = [0, 1, 0]
parent = "x"
child = "a"
[joints.j2]
type = "revolute"
axis = [0, 1, 0]
parent = "a"
child = "c"
origin = [0.6, 0, 0]
"""

TIP = '[contacts.tip]\nbody = "c"\nat = [0.5, 0, 0]\nplane = { normal = [0, 0, 1] }\n'
STOP = "limits = { upper = 1, restitution = 0.2 }\n"


def corners(*places: tuple[float, float]) -> Scene:
    text = BODY
    for k, (x, y) in enumerate(places):
        text += f'[contacts.m{k}]\nbody = "b"\nat = [{x}, {y}, -0.1]\nfriction = 0.5\n'
    return read_text(text)


BOX = corners((-0.3, -0.2), (-0.3, 0.2), (0.3, -0.2), (0.3, 0.2))


def numbers(scene: Scene, name: str, **values: np.ndarray) -> np.ndarray:
    """Return the results of an output at many states by running its expressions, shape (states, ...)."""
    (function,) = derive(scene, [name]).functions
    known = {x: values[a.name][:, i] for a in function.arguments for i, x in enumerate(a.symbols)}
    states = len(values["q"])
    entries = [np.broadcast_to(x, (states,)) for x in evaluate(function.entries, Batches(), known)]
    return np.stack(entries, axis=1).reshape(states, *function.shape)


def stances(scene: Scene, start: bool = False) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(4)
    q = rng.uniform(-1, 1, (len(STANCES), len(scene.coordinates)))
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    v, tau = rng.uniform(-2, 2, (2, len(STANCES), len(scene.velocities)))
    if start:  # at rest, upright, all legs alike
        q[:] = [0, 0, 0.3, 1, 0, 0, 0] + [0, 0.8, -1.6] * 4
        v[:] = tau[:] = 0
    return {"q": q, "qd": v, "tau": tau, "mask": STANCES}


@pytest.mark.parametrize("start", [False, True])
def test_all_stances_solve_the_equations_of_what_is_held(start: bool) -> None:
    scene = with_contacts(EXAMPLES / "quadruped.toml", FEET)
    at, n = stances(scene, start), len(scene.velocities)
    found = numbers(scene, "held_dynamics", **at)
    M, free = numbers(scene, "mass_matrix", **at), numbers(scene, "forward_dynamics", **at)
    rows = [numbers(scene, f"gap_jacobian:{foot}", **at) for foot in FEET]
    drift = [numbers(scene, f"gap_jdot:{foot}", **at) for foot in FEET]
    for k, stance in enumerate(STANCES):
        held = np.repeat(stance, 3).astype(bool)
        W, gamma = np.vstack([one[k] for one in rows])[held], np.hstack([one[k] for one in drift])[held]
        kkt = np.block([[M[k], -W.T], [W, np.zeros((len(W), len(W)))]])
        exact = np.linalg.solve(kkt, np.hstack([M[k] @ free[k], -gamma]))
        size = np.abs(exact).max()
        assert found[k, :n] == pytest.approx(exact[:n], abs=1e-11 * size)
        assert found[k, n:][held] == pytest.approx(exact[n:], abs=1e-11 * size)
        assert not found[k, n:][~held].any()


@pytest.mark.slow
@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("path", "feet"),
    [
        ("go2_description/urdf/go2.urdf", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"]),
        ("solo_description/robots/solo12.urdf", ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"]),
    ],
)
def test_all_stances_and_their_derivatives_are_pinocchios(path: str, feet: list[str]) -> None:
    pin, folder = pytest.importorskip("pinocchio"), robot_folder()
    if folder is None:
        pytest.skip("the package example-robot-data is not installed")
    model = pin.buildModelFromUrdf(str(folder / path), pin.JointModelFreeFlyer())
    data, n = model.createData(), model.nv
    robot = read(folder / path, ReadOptions(snap=False, floating_base="root_joint")).scene
    order = robot.order(list(model.names)[1:], quaternion="xyzw")
    ours, slopes = lambdify(with_contacts(robot, feet), ["held_dynamics", "held_dynamics_derivatives"])
    rng, v = np.random.default_rng(2), order.v

    def close(one: np.ndarray, other: np.ndarray) -> None:
        assert np.abs(one - other).max(initial=0) <= 1e-12 * np.abs(other).max(initial=0)

    for stance in STANCES:
        q_ = pin.integrate(model, pin.neutral(model), rng.uniform(-1, 1, n))
        v_, tau_ = rng.uniform(-2, 2, (2, n))
        q, qd, tau = np.empty(n + 1), np.empty(n), np.empty(n)
        q[order.q], qd[v], tau[v] = q_, v_, tau_
        models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for foot in np.array(feet)[stance > 0]:
            frame = model.frames[model.getFrameId(str(foot))]
            kind, axes = pin.ContactType.CONTACT_3D, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            models.append(pin.RigidConstraintModel(kind, model, frame.parentJoint, frame.placement, axes))
            datas.append(models[-1].createData())
        pin.initConstraintDynamics(model, data, models, datas)
        settings = pin.ProximalSettings(1e-14, 0.0, 1)
        pin.constraintDynamics(model, data, q_, v_, tau_, models, datas, settings)
        pin.computeConstraintDynamicsDerivatives(model, data, models, datas, settings)
        found, J = ours(q, qd, tau, stance), slopes(q, qd, tau, stance)
        close(found[:n][v], data.ddq)
        close(found[n:].reshape(4, 3)[stance > 0][:, AXES].ravel(), data.lambda_c)
        moved = J[:n].reshape(n, 3, n)[v][..., v]
        pushed = J[n:].reshape(4, 3, 3, n)[stance > 0][:, AXES].reshape(-1, 3, n)[..., v]
        for k, word in enumerate(("dq", "dv", "dtau")):
            close(moved[:, k], getattr(data, f"ddq_{word}"))
            close(pushed[:, k], getattr(data, f"dlambda_{word}"))


def test_forces_of_corners_that_hold_the_same_are_of_least_size() -> None:
    rng = np.random.default_rng(3)
    q, tau = rng.uniform(-1, 1, (16, 7)), rng.uniform(-3, 3, (16, 6))
    q[:, 3:] /= np.linalg.norm(q[:, 3:], axis=1, keepdims=True)
    at = {"q": q, "qd": np.zeros((16, 6)), "tau": tau, "mask": STANCES, "proximal": np.full((16, 1), 1e-3)}
    found = numbers(BOX, "held_dynamics_proximal", **at)
    D, b = numbers(BOX, "delassus", **at), numbers(BOX, "contact_bias", **at)
    for k, stance in enumerate(STANCES):
        held = np.repeat(stance, 3).astype(bool)
        least = np.linalg.pinv(D[k][np.ix_(held, held)], rcond=1e-10) @ -b[k][held]
        assert found[k, 6:][held] == pytest.approx(least, abs=1e-9 * np.abs(least).max(initial=1))
        assert not found[k, 6:][~held].any()


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("text", "name"),
    [
        (ARM + TIP, "held_dynamics"),
        (ARM.replace('motion = "0.1*sin(2*t)"\n', "") + STOP + TIP, "held_dynamics_derivatives"),
        (ARM + STOP + TIP, "held_dynamics_proximal"),
        pytest.param(BODY + TIP.replace('"c"', '"b"'), "held_dynamics_derivatives", marks=pytest.mark.slow),
    ],
)
def test_two_formulations_agree(text: str, name: str) -> None:
    found = symdyn.certify(read_text(text), [name])
    assert found.passed
    assert [one for one in found.findings if one.verdict == "proved"]


def test_what_cannot_be_held_is_refused_in_words() -> None:
    with pytest.raises(DerivationError, match=r"contacts hold the same .* ask for held_dynamics_proximal"):
        derive(BOX, ["held_dynamics"])
    with pytest.raises(DerivationError, match=r"has no contacts; declare one"):
        derive(symdyn.example("two_link"), ["held_dynamics"])
    derive(corners((0.3, 0.1)), ["held_dynamics"])


@pytest.mark.runs("cc")
def test_masks_that_are_none_are_refused_in_words() -> None:
    call = symdyn.load(corners((0.3, 0.1)), ["held_dynamics"]).held_dynamics
    q, v = np.array([0, 0, 0.1, 1, 0, 0, 0]), np.zeros(6)
    assert call(q, v, v, [1])[6] == pytest.approx(call(q, v, v, np.array([True]))[6])
    assert call(q, v, v, np.array([[0], [1]])).shape == (2, 9)
    assert call(q, v, v, [0])[:3] == pytest.approx([0, 0, -9.81])
    with pytest.raises(ArgumentError, match=r"mask has 2; give 0 or 1 of each of mask\[0\]"):
        call(q, v, v, [2])
    with pytest.raises(ArgumentError, match=r"mask has nan; give 0 or 1"):
        call(q, v, v, mask=np.array([np.nan]))
    with pytest.raises(ArgumentError, match=r"mask has 2 in its last dimension; give 1 numbers, mask\[0\]$"):
        call(q, v, v, [1, 1])
    assert "mask" in str(call.__doc__)


def test_places_that_are_none_are_refused_in_words() -> None:
    with pytest.raises(SceneError, match=r"there is no body or point 'fl_fot'; did you mean fl_foot"):
        with_contacts(EXAMPLES / "quadruped.toml", ["fl_fot"])
    with pytest.raises(SceneError, match=r"contacts\.fl_foot is there already; leave it out"):
        with_contacts(EXAMPLES / "quadruped.toml", ["fl_foot", "fl_foot"])
    with pytest.raises(SceneError, match=r"friction = -1 is no coefficient; give a number, 0 or above"):
        with_contacts(EXAMPLES / "quadruped.toml", FEET, friction=-1)
    with pytest.raises(SceneError, match=r"friction = nan is no coefficient"):
        with_contacts(EXAMPLES / "quadruped.toml", FEET, friction=float("nan"))
