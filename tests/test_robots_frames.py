"""Frames, and what solves with M or moves along the group, are Pinocchio's on an arm and on a quadruped that floats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from robots import robot_files

from symdyn.runtime import lambdify
from symdyn.scene.declaration.reading import ReadOptions
from symdyn.scene.formats.urdf import read

pin = pytest.importorskip("pinocchio")

HUMANOID = Path(__file__).parent.parent / "examples" / "gallery" / "humanoid.urdf"
ROBOTS = {path.name: path for path in robot_files() if path.name in ("ur5_robot.urdf", "solo12.urdf")}
CASES = [
    (HUMANOID, False, "left_forearm"),
    pytest.param(HUMANOID, True, "left_forearm", marks=pytest.mark.slow),
    pytest.param(ROBOTS.get("ur5_robot.urdf"), False, "tool0", marks=pytest.mark.slow),
    pytest.param(ROBOTS.get("solo12.urdf"), True, "HR_FOOT", marks=pytest.mark.slow),
]
CLOSE = 1e-12
THEIRS = {"local": "LOCAL", "world": "WORLD", "aligned": "LOCAL_WORLD_ALIGNED"}


class Twins:
    """One robot here and in Pinocchio, at one state in the numbers of both: theirs end with _."""

    def __init__(self, path: Path | None, floats: bool) -> None:
        if path is None:
            pytest.skip("the package example-robot-data is not installed")
        options = ReadOptions(snap=False, allow_invalid_inertia=True, floating_base="root_joint" if floats else None)
        self.scene = read(path, options).scene
        self.model = pin.buildModelFromUrdf(str(path), *([pin.JointModelFreeFlyer()] if floats else []))
        self.data = self.model.createData()
        self.order = self.scene.order(list(self.model.names)[1:], quaternion="xyzw")
        rng = np.random.default_rng(7)
        nq, nv = self.model.nq, self.model.nv
        self.q_, self.to_ = (self.unit(rng.uniform(-1, 1, nq)) for _ in range(2))
        self.v_, self.a_, self.tau_ = rng.uniform(-1, 1, (3, nv))
        self.q, self.to = self.positions(self.q_), self.positions(self.to_)
        self.v, self.a, self.tau = map(self.velocities, (self.v_, self.a_, self.tau_))

    def unit(self, q: np.ndarray) -> np.ndarray:
        if self.model.nq != self.model.nv:
            q[3:7] /= np.linalg.norm(q[3:7])
        return q

    def positions(self, q: np.ndarray) -> np.ndarray:
        found = np.empty_like(q)
        found[self.order.q] = q
        return found

    def velocities(self, v: np.ndarray) -> np.ndarray:
        found = np.empty_like(v)
        found[self.order.v] = v
        return found

    def square(self, M: np.ndarray) -> np.ndarray:
        return M[np.ix_(self.order.v, self.order.v)]

    def pair(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return two squares that stand beside each other."""
        return self.square(J[:, : self.model.nv]), self.square(J[:, self.model.nv :])


def close(ours: np.ndarray, theirs: np.ndarray) -> None:
    assert np.max(np.abs(ours - theirs)) <= CLOSE * max(1, np.max(np.abs(theirs)))


def right_jacobian(step: np.ndarray, floats: bool) -> np.ndarray:
    """Return the sum of (-ad)^k / (k + 1)! for the six velocities of a base that floats."""
    J = np.eye(len(step))
    if not floats:
        return J
    (a, b, c), (x, y, z) = step[:3], step[3:6]
    v, w = (np.array([[0, -r, q], [r, 0, -p], [-q, p, 0]]) for p, q, r in ((a, b, c), (x, y, z)))
    ad, term = np.block([[w, v], [np.zeros((3, 3)), w]]), np.eye(6)
    for k in range(2, 40):
        term = -term @ ad / k
        J[:6, :6] += term
    return J


@pytest.mark.parametrize(("path", "floats", "name"), CASES)
def test_frames_are_those_of_pinocchio(path, floats, name):
    """Its accelerations are spatial: where frames are aligned ours is what it calls classical."""
    t = Twins(path, floats)
    kinds = ("jacobian", "velocity", "jdot_qdot", "acceleration")
    calls = iter(lambdify(t.scene, [f"{kind}:{name}:{frame}" for frame in THEIRS for kind in kinds]))
    pin.forwardKinematics(t.model, t.data, t.q_, t.v_, t.a_)
    pin.computeJointJacobians(t.model, t.data, t.q_)
    frame = t.model.getFrameId(name)
    for word, theirs in THEIRS.items():
        J, V, bias, A = (next(calls) for _ in kinds)
        where = getattr(pin, theirs)
        classical = word == "aligned"
        accelerated = pin.getFrameClassicalAcceleration if classical else pin.getFrameAcceleration
        wanted = accelerated(t.model, t.data, frame, where).vector
        J_ = pin.getFrameJacobian(t.model, t.data, frame, where)
        close(J(t.q)[:, t.order.v], J_)
        close(V(t.q, t.v), pin.getFrameVelocity(t.model, t.data, frame, where).vector)
        close(A(t.q, t.v, t.a), wanted)
        close(bias(t.q, t.v), wanted - J_ @ t.a_)


@pytest.mark.parametrize(("path", "floats", "name"), CASES)
def test_what_solves_with_the_mass_matrix_is_that_of_pinocchio(path, floats, name):
    t = Twins(path, floats)
    inverse, factors, solve = lambdify(t.scene, ["mass_matrix_inverse", "mass_matrix_factors", "mass_matrix_solve"])
    M = pin.crba(t.model, t.data, t.q_)
    M = np.triu(M) + np.triu(M, 1).T
    LD = factors(t.q)
    L = np.tril(LD, -1) + np.eye(len(LD))

    scale = np.max(np.abs(np.linalg.inv(M)))
    assert np.max(np.abs(t.square(inverse(t.q)) - pin.computeMinverse(t.model, t.data, t.q_))) <= 1e-11 * scale
    close(t.square(L.T @ np.diag(np.diag(LD)) @ L), M)
    assert np.allclose(M @ solve(t.q, t.tau)[t.order.v], t.tau_, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("path", "floats", "name"), CASES)
def test_positions_are_integrated_and_subtracted_as_by_pinocchio(path, floats, name):
    """Steps far, near, and of no length; quaternions of either sign, and the same one."""
    t = Twins(path, floats)
    names = ["integrate", "difference", "integrate_jacobian", "difference_jacobian", "neutral"]
    integrate, difference, by_step, by_ends, neutral = lambdify(t.scene, names)
    close(neutral()[t.order.q], pin.neutral(t.model))
    for size in (1, 0.3, 0.2, 1e-3, 1e-8, 1e-15, 0):
        after = pin.integrate(t.model, t.q_, size * t.v_)
        close(integrate(t.q, size * t.v)[t.order.q], after)
        close(difference(t.q, t.positions(after)), size * t.v)
        by_q, by_v = t.pair(by_step(t.q, size * t.v))
        close(by_q, pin.dIntegrate(t.model, t.q_, size * t.v_, pin.ARG0))
        close(by_v, right_jacobian(size * t.v_, floats))
        loses = 1e-10 if size == 1e-3 else CLOSE  # Pinocchio's own digits: `right_jacobian` has all
        assert np.max(np.abs(by_v - pin.dIntegrate(t.model, t.q_, size * t.v_, pin.ARG1))) <= loses
    flipped = t.to_.copy()
    flipped[3:7] *= -1 if floats else 1
    near = pin.integrate(t.model, t.q_, 0.01 * t.v_)
    for to_ in (t.to_, flipped, near):
        to = t.positions(to_)
        close(difference(t.q, to)[t.order.v], pin.difference(t.model, t.q_, to_))
        for ours, arg in zip(t.pair(by_ends(t.q, to)), (pin.ARG0, pin.ARG1), strict=True):
            close(ours, pin.dDifference(t.model, t.q_, to_, arg))
    close(difference(t.q, t.q), np.zeros(t.model.nv))
