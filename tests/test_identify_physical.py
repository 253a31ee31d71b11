"""Inertias that bodies can have: by cones, and by Cholesky factors that are no others."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

import symdyn
from symdyn.errors import IdentifyError
from symdyn.identification import physical as subject
from symdyn.identification.identified_scene import _physical_notes
from symdyn.identification.linear_model import TEN, unknowns
from symdyn.identification.physical import MARGIN, SPREAD, matrix, nearest_physical, pseudo_rows
from symdyn.scene.symbolic import bind
from symdyn.scene.values.formula import quantity

FAR = 10.0
"""A spread that lets noise lead bodies to the edge of what can be."""


def _bound(name):
    scene = symdyn.example(name)
    return bind(scene, {p.name: 1 + k / 10 for k, p in enumerate(scene.free_parameters)})


def _estimates(scene, noise, seed=1):
    """Return unknowns, estimates and their covariance from forces of random states with noise."""
    known = unknowns(scene)
    n = len(scene.coordinates)
    draw = np.random.default_rng(seed)
    q, qd, qdd = draw.uniform(-2, 2, (3, 300, n))
    rows = symdyn.lambdify(scene, "base_regressor")(q, qd, 3 * qdd).reshape(300 * n, -1)
    tau = rows @ (known.map @ known.values) + noise * draw.normal(size=len(rows))
    return known, np.linalg.lstsq(rows, tau, rcond=None)[0], noise**2 * np.linalg.inv(rows.T @ rows)


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["puma560", "arm7", "scara", "two_link", "four_bar", "cart_pole", "gripper2", "governor"]
)
def test_the_map_gives_the_base_parameters(name):
    scene = _bound(name)
    known = unknowns(scene)
    n, m = len(scene.coordinates), len(scene.velocities)
    if scene.is_constrained:
        return
    draw = np.random.default_rng(0)
    q, (qd, qdd) = draw.uniform(-1, 1, n), draw.uniform(-1, 1, (2, m))
    whole = symdyn.lambdify(scene, "regressor")(q, qd, qdd)
    base = symdyn.lambdify(scene, "base_regressor")(q, qd, qdd)

    np.testing.assert_allclose(base @ known.map, whole, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "noise"), [("arm7", 0.5)])
def test_cones_and_cholesky_factors_find_the_same(name, noise):
    known, estimate, covariance = _estimates(_bound(name), noise)

    found = nearest_physical(known, known.map, estimate, covariance, spread=FAR)

    by_factors = _by_factors(known, estimate, covariance, found)
    assert found.projected
    assert np.abs((found.base - known.map @ by_factors) / np.sqrt(np.diag(covariance))).max() < 0.1


def _squares(known, estimate, covariance, spread=SPREAD):
    """Return A and b, so that |A (values - declared) - b|^2 is what is made least."""
    length, sizes = subject._sizes(known)
    weigh, target = subject._weighed(subject.prior_of(known), known.map, estimate, covariance)
    metric = subject._metric(known, subject.prior_of(known), known.map, estimate, length, sizes) / spread
    return np.vstack([weigh, metric]), np.concatenate([target, np.zeros(len(metric))])


def _by_factors(known, estimate, covariance, start):
    """Minimise the same squares over P = L L^T + margin 1 (Rucker and Wensing 2022), by SciPy."""
    p, count = len(known.values), len(known.bodies)
    length, sizes = subject._sizes(known)
    A, b = _squares(known, estimate, covariance, FAR)
    back = [np.linalg.inv(pseudo_rows(k, p, length)[:, TEN * k : TEN * (k + 1)]) for k in range(count)]
    low = np.tril_indices(4)

    def values(x):
        found = x.copy()
        for k in range(count):
            factor = np.zeros((4, 4))
            factor[low] = x[TEN * k : TEN * (k + 1)]
            matrix = factor @ factor.T + 2 * MARGIN * sizes[k] * np.eye(4)
            found[TEN * k : TEN * (k + 1)] = back[k] @ [matrix[i, j] for i, j in subject.UPPER]
        return found

    x = start.values.copy()
    for k in range(count):
        spd = matrix(pseudo_rows(k, p, length) @ start.values) + 0.1 * sizes[k] * np.eye(4)
        x[TEN * k : TEN * (k + 1)] = np.linalg.cholesky(spd)[low]
    ends = {"x_scale": "jac", "xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-12, "max_nfev": 3000}
    return values(least_squares(lambda x: A @ (values(x) - subject.prior_of(known)) - b, x, **ends).x)


@pytest.mark.parametrize(("name", "noise"), [("puma560", 0.5), ("two_link", 0.1), ("arm7", 2.0)])
def test_nothing_that_bodies_can_have_is_nearer(name, noise):
    """The slope of the squares is one of the cones: Z >= 0 with Z (P - margin) = 0, which proves the least value."""
    known, estimate, covariance = _estimates(_bound(name), noise)

    found = nearest_physical(known, known.map, estimate, covariance)

    A, b = _squares(known, estimate, covariance)
    slope = 2 * A.T @ (A @ (found.values - subject.prior_of(known)) - b)
    length, sizes = subject._sizes(known)
    for k in range(len(known.bodies)):
        rows = pseudo_rows(k, len(known.values), length)
        own = slice(TEN * k, TEN * (k + 1))
        upper = np.linalg.solve(rows[:, own].T, slope[own]) / [1 if i == j else 2 for i, j in subject.UPPER]
        Z, P = matrix(upper), matrix(rows @ found.values) - 2 * MARGIN * sizes[k] * np.eye(4)
        tight = 1e-6 * (1 + np.abs(Z).max())
        assert np.linalg.eigvalsh(Z)[0] > -tight / sizes[k]
        assert np.linalg.eigvalsh(P)[0] > -1e-7 * sizes[k]
        assert abs(np.sum(Z * P)) < 1e-5 * (1 + float(np.sum((A @ (found.values - subject.prior_of(known)) - b) ** 2)))


def test_every_pseudo_inertia_is_positive_definite():
    known, estimate, covariance = _estimates(_bound("puma560"), 1.0)

    found = nearest_physical(known, known.map, estimate, covariance)

    assert known.scene.bodies[0].mass == quantity(0), "a body that no body can be, as declared"
    assert found.before.min() < 0 < found.margins.min()
    for m, x, y, z, xx, yy, zz, xy, xz, yz in known.ten(found.values):
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        moments = np.trace(inertia) / 2 * np.eye(3) - inertia
        pseudo = np.block([[moments, np.array([[x, y, z]]).T], [np.array([x, y, z, m])]])
        assert np.linalg.eigvalsh(pseudo)[0] > 0


def test_estimates_of_real_bodies_are_left_alone():
    scene = _bound("arm7")
    known, estimate, covariance = _estimates(scene, 1e-3)

    found = nearest_physical(known, known.map, estimate, covariance)

    assert not found.projected
    assert found.distance < 0.01
    assert np.abs(found.values - known.values).max() < 0.1


def test_what_no_motion_moves_keeps_the_scenes_own():
    known, estimate, covariance = _estimates(_bound("puma560"), 0.5)
    felt = np.any(known.map[:, :TEN], axis=1)

    found = nearest_physical(known, known.map[~felt], estimate[~felt], covariance[np.ix_(~felt, ~felt)])

    assert found.kept == ("link1",)
    assert (found.values[:TEN] == known.values[:TEN]).all()


def test_the_mass_of_all_is_what_it_is_said_to_be():
    known, estimate, covariance = _estimates(_bound("arm7"), 0.5)

    found = nearest_physical(known, known.map, estimate, covariance, total_mass=30)

    assert known.ten(found.values)[:, 0].sum() == pytest.approx(30, rel=1e-7)


def test_a_body_lies_in_its_ellipsoid():
    known, estimate, covariance = _estimates(_bound("scara"), 0.5)
    body = known.bodies[-1]

    found = nearest_physical(known, known.map, estimate, covariance, inside={body: ((0, 0, 0.2), (0.01, 0.01, 0.01))})

    m, x, y, z, *_ = known.ten(found.values)[-1]
    assert sum(((a - c) / 0.01) ** 2 for a, c in zip((x / m, y / m, z / m), (0, 0, 0.2), strict=True)) <= 1 + 1e-6


def test_what_cannot_be_is_told():
    known, estimate, covariance = _estimates(_bound("scara"), 0.5)

    with pytest.raises(IdentifyError, match="no bodies have what is asked"):
        nearest_physical(known, known.map, estimate, covariance, total_mass=-1)
    with pytest.raises(IdentifyError, match='"hand" is no body of scara'):
        nearest_physical(known, known.map, estimate, covariance, inside={"hand": ((0, 0, 0), (1, 1, 1))})


def test_friction_is_never_negative():
    scene = symdyn.example("scara")
    joints = tuple(replace(j, damping=quantity("0.001")) if j.moves else j for j in scene.joints)
    known, estimate, covariance = _estimates(replace(scene, joints=joints), 0.5)

    found = nearest_physical(known, known.map, estimate, covariance)

    assert len(known.signed) == 4
    assert (known.signs @ found.values >= -1e-9).all()
    assert any("damping" in one for one in found.at_limit)


def test_the_same_estimates_give_the_same_bytes():
    known, estimate, covariance = _estimates(_bound("puma560"), 0.5)

    first, second = (nearest_physical(known, known.map, estimate, covariance).values for _ in range(2))

    assert first.tobytes() == second.tobytes()


@pytest.mark.long
@pytest.mark.parametrize(("moves", "noise"), [((0,), 1e-12), ((1,), 1e-9), ((0, 5), 1e-6)])
def test_estimates_that_have_no_noise_and_few_joints_have_bodies(moves, noise):
    """Standard errors of nearly nothing, some combinations not told, and two bodies that no body can be."""
    scene = symdyn.example("puma560")
    joints = tuple(replace(j, damping=quantity("0.5")) if k < 2 else j for k, j in enumerate(scene.joints))
    known = unknowns(replace(scene, joints=joints))
    t, n = np.arange(0, 10, 0.05), len(scene.coordinates)
    q, qd, qdd = np.full((len(t), n), 0.3), np.zeros((len(t), n)), np.zeros((len(t), n))
    for k in moves:
        w = 2 + k
        q[:, k], qd[:, k], qdd[:, k] = np.sin(w * t), w * np.cos(w * t), -w * w * np.sin(w * t)
    rows = symdyn.lambdify(known.scene, "base_regressor")(q, qd, qdd).reshape(len(t) * n, -1)
    scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-9)
    _, s, Vt = np.linalg.svd(rows / scale, full_matrices=False)
    told = s > 1e-6 * s[0]
    C = Vt[told] * scale
    estimate = C @ known.map @ known.values

    found = nearest_physical(known, C @ known.map, estimate, np.diag((noise / s[told]) ** 2))

    assert found.identifiable == told.sum() < len(known.base)
    assert found.margins[[name not in found.kept for name in known.bodies]].min() > 0
    assert found.missed < 0.2


def test_what_is_missed_is_told_in_percent():
    found = subject.Physical(
        unknowns(symdyn.example("pendulum")), np.zeros(0), 3.0, 0.99, 4, np.zeros(0), np.zeros(0), 1.0, (), (), True
    )
    assert any("3 standard errors away, all 4 together, and miss 99 % of them" in one for one in _physical_notes(found))
