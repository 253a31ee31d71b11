"""Laws of impact and friction in numbers, and their formulas in generated code beside them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from contact_scenes import ROD

import symdyn
from symdyn.algebra import Floats
from symdyn.dynamics.outputs.contact_outputs import _phase
from symdyn.graph import Graph, evaluate
from symdyn.scene import read_text
from symdyn.simulation.equations.complementarity import FREE, Laws

pytestmark = pytest.mark.runs("cc")


def drawn(rng: np.random.Generator) -> tuple[Laws, np.ndarray]:
    k, nv = int(rng.integers(1, 4)), 8
    B, W = rng.normal(size=(nv, nv)), rng.normal(size=(2 * k, nv))
    D = W @ np.linalg.solve(B @ B.T + 0.1 * np.eye(nv), W.T)
    mu, e = rng.uniform(0, 1, k), np.full(k, rng.uniform(0, 1))
    laws = Laws(D, tuple(range(0, 2 * k, 2)), tuple((i,) for i in range(1, 2 * k, 2)), mu, mu, e)
    return laws, W @ rng.normal(size=nv)


def kept(laws: Laws, impulses: np.ndarray, xi: np.ndarray) -> bool:
    small, slow = 1e-8 * max(1e-6, np.abs(impulses).max()), 1e-8 * max(1.0, np.abs(laws.D @ impulses).max())
    for k, (n, t) in enumerate(zip(laws.normals, (one[0] for one in laws.tangents), strict=True)):
        if impulses[n] < -small or xi[n] < -slow or (impulses[n] > small and xi[n] > slow):
            return False
        largest = laws.friction[k] * impulses[n]
        if abs(impulses[t]) > largest + small or (
            abs(xi[t]) > 1e-8 and abs(impulses[t] + np.sign(xi[t]) * largest) > 1e-7
        ):
            return False
    return True


def test_lemke_and_all_cases_find_the_same_impulses() -> None:
    rng, differ = np.random.default_rng(1), 0
    for _ in range(400):
        laws, v = drawn(rng)
        count = len(laws.normals)
        target = np.zeros(len(v))
        target[::2] = -laws.restitution * v[::2]
        every = [(FREE, *laws.slips(k)) for k in range(count)]
        cases = [found for _, found in laws.solutions(v, every, None, target)]
        pivots = laws.by_pivots(v, [0.0] * count, np.zeros(count), target)
        assert pivots is not None
        assert cases
        assert all(kept(laws, found, laws.D @ found + v - target) for found in (pivots, *cases))
        size = max(1e-6, np.abs(pivots).max())
        differ += min(np.abs(found - pivots).max() for found in cases) > 1e-8 * size
    assert differ == 0


def test_poisson_with_one_restitution_never_adds_energy_and_newton_may() -> None:
    rng, gained = np.random.default_rng(2), {True: 0, False: 0}
    for _ in range(400):
        laws, v = drawn(rng)
        for poisson in gained:
            impulses = laws.impact(v, [poisson] * len(laws.normals))
            work = impulses @ (2 * v + laws.D @ impulses) / 2
            gained[poisson] += work > 1e-14 * np.abs(impulses * v).sum()
    assert gained[True] == 0
    assert gained[False] > 0


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("friction", [0, 0.3, 2.5])
def test_the_impact_of_one_contact_is_a_formula(law: str, friction: float) -> None:
    text = ROD.replace('friction = "0.36"', f'friction = {friction}\nrestitution = 0.7\nlaw = "{law}"')
    scene = read_text(text)
    call = symdyn.load(scene, ["impact:foot", "delassus", "gap_rate:foot", "impact_matrix:foot"])
    rng = np.random.default_rng(3)
    for _ in range(50):
        q, u = rng.normal(size=3), rng.normal(size=3)
        D, v, C = call.delassus(q), call.gap_rate_foot(q, u), call.impact_matrix_foot(q)
        m, mu = len(D), np.array([friction])
        laws = Laws(D, (0,), ((1,) if m == 2 else (),), mu, mu, np.array([0.7]))
        impulses = laws.impact(v[:m], [law == "poisson"]) if v[0] < 0 else np.zeros(m)
        found = call.impact_foot(q, u)
        assert found[3 : 3 + m] == pytest.approx(impulses, abs=1e-12)
        assert found[:3] == pytest.approx(u + C[:, :m] @ impulses, abs=1e-12)


def test_the_formula_of_a_phase_is_that_of_all_cases_however_rough() -> None:
    """Where μ |D_nt| is above D_nn, no impulse fits one of the ways to slip."""
    graph, rng, steep = Graph(), np.random.default_rng(4), 0
    a, b, c, mu, vn, vt = letters = [graph.symbol(name) for name in ("a", "b", "c", "mu", "vn", "vt")]
    touch = SimpleNamespace(friction=mu)
    forms = _phase([[a, b], [b, c]], [vn, vt], touch, graph.zero)  # type: ignore[arg-type]
    for _ in range(400):
        B, size = rng.normal(size=(2, 2)), float(rng.uniform(0, 2))
        D, v = B @ B.T + 0.02 * np.eye(2), rng.normal(size=2) * (-1, 1)
        v[0] = -abs(v[0])
        laws = Laws(D, (0,), ((1,),), np.array([size]), np.array([size]), np.zeros(1))
        values = dict(zip(letters, [D[0, 0], D[0, 1], D[1, 1], size, *v], strict=True))
        assert evaluate(forms, Floats(), values) == pytest.approx(laws.impact(v, [False]), rel=1e-7, abs=1e-12)
        steep += D[0, 0] < size * abs(D[0, 1])
    assert steep > 20


def test_outputs_of_contacts_are_proved() -> None:
    names = ["gap:foot", "gap_jacobian:foot", "gap_rate:foot", "gap_jdot:foot", "impact_matrix:foot", "impact:foot"]
    found = symdyn.certify(read_text(ROD), [*names, "delassus", "contact_bias", "contact_dynamics"])
    assert found.passed
    assert len([one for one in found.findings if one.verdict == "proved"]) == 22


def test_the_dynamics_of_a_mode_keep_its_rows() -> None:
    q, u, tau = np.array([-0.2, 0.4, 0.4]), np.array([0.1, -0.2, 0.3]), np.zeros(3)
    call = symdyn.load(read_text(ROD), ["contact_dynamics", "forward_dynamics", "gap_jacobian:foot", "gap_jdot:foot"])

    def moved(closed: float, slip: float) -> np.ndarray:
        return np.asarray(call.contact_dynamics(q, u, tau, np.array([closed]), np.array([slip])))

    W, bias = call.gap_jacobian_foot(q), call.gap_jdot_foot(q, u)
    assert moved(0, 0)[:3] == pytest.approx(call.forward_dynamics(q, u, tau))
    assert W @ moved(1, 0)[:3] + bias == pytest.approx(np.zeros(3), abs=1e-13)
    slips = moved(1, 1)
    assert (W @ slips[:3] + bias)[0] == pytest.approx(0, abs=1e-13)
    assert slips[4] == pytest.approx(-0.36 * slips[3])
