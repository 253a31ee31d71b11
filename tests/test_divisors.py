"""Nothing that is generated divides by what is zero everywhere: every divisor of every output by every formulation."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.dynamics import Requested, Workspace, derive_one, expected, formulations_of, of_place
from symdyn.emit import emit
from symdyn.graph import Graph, Op, reachable
from symdyn.program import lower
from symdyn.runtime import run_python
from symdyn.scene import read, read_text
from symdyn.verdict import Verdict
from symdyn.verify import certify

ROOT = Path(__file__).parent.parent
PINNED = [ROOT / "tests" / "data" / f"pinned_{name}.toml" for name in ("particle", "rod")]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))


@pytest.mark.parametrize(
    "formulation",
    [
        pytest.param(one, marks=pytest.mark.mends("30.numbers.1") if one == "lagrange" else ())
        for one in formulations_of("forward_dynamics", read(PINNED[0]))
    ],
)
def test_a_particle_that_is_pinned_falls_as_a_pendulum(formulation):
    """Closed form: r² φ̈ = -g x; the mass matrix is singular, and that of what the loop leaves free is not."""
    scene, phi = read(PINNED[0]), 0.4
    equations = symdyn.dynamics.derive(scene, ["forward_dynamics"], formulation=formulation)
    module = run_python(emit(lower(equations)))
    found = module.forward_dynamics(np.array([0, 0, phi]), np.array([0, 0, 1.0]), np.zeros(3))
    x = 0.3 * cos(phi) - 0.1 * sin(phi)
    assert found == pytest.approx([0, 0, -9.81 * x / 0.1], rel=1e-12, abs=1e-12)


@pytest.mark.mends("30.numbers.1")
@pytest.mark.parametrize("path", PINNED, ids=lambda path: path.stem)
def test_formulations_agree_where_the_mass_matrix_is_singular(path):
    found = certify(read(path), ["forward_dynamics", "multipliers"], targets=["numpy"])
    pairs = [one for one in found.findings if " = lagrange" in f"{one.claim} " or "crba" in one.claim]
    assert [one.verdict for one in pairs] == [Verdict.PROVED] * len(pairs)
    assert pairs
    assert found.passed


@pytest.mark.mends("30.numbers.1")
@pytest.mark.parametrize("formulation", ["crba", "aba", "lagrange", None])
def test_a_rod_that_is_free_to_turn_about_itself_has_no_forward_dynamics(formulation):
    """Its mass matrix is singular at all positions, yet none of its entries is zero."""
    tree = read_text(PINNED[1].read_text(encoding="utf-8").split("[[loop]]")[0])
    with pytest.raises(symdyn.SymdynError, match="moves no mass, so that the mass matrix is singular; give d a mass"):
        symdyn.dynamics.derive(tree, ["forward_dynamics"], formulation=formulation)


MASSLESS = """
name = "crank"
gravity = "none"
[bodies.a]
[joints.j1]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 0, 1]
coordinate = "q1"
[bodies.b]
particles = [{ mass = 1, at = [1, 0, 0] }]
[joints.j2]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 0, 1]
origin = [1, 0, 0]
coordinate = "q2"
start = 0.5
[constraints.r]
formula = "cos(q1)*q1_dot + sin(q1)*q2_dot"
acts_in = "joints"
"""


def test_a_mass_matrix_that_is_singular_at_zeros_alone_leaves_no_hole_there():
    """At zeros the row holds q1 alone, and q2 turns with the inertia 1 about its joint: q2'' = tau2."""
    module = run_python(emit(lower(symdyn.dynamics.derive(read_text(MASSLESS), ["forward_dynamics"]))))
    found = module.forward_dynamics(np.zeros(2), np.zeros(2), np.array([0.3, 0.7]))
    assert found == pytest.approx([0.0, 0.7], abs=1e-14)


@pytest.mark.heavy("bicycle")
@pytest.mark.wide(3)
@pytest.mark.parametrize("path", [*PINNED, *EXAMPLES], ids=lambda path: path.stem)
def test_no_divisor_is_zero_everywhere(path):
    from symdyn.dynamics.mechanism.linear_solve import vanishes

    scene = read(path)
    workspace = Workspace(scene)
    wanted = [*expected(scene, "verify"), *of_place(scene.bodies[-1].name, "verify")]
    seen = 0
    for name in Requested(workspace, tuple(wanted), ()).there(derive_one)[0]:
        for formulation in formulations_of(name, scene):
            entries = derive_one(workspace, name, formulation).entries
            divisors = [node.args[1] for node in reachable(entries) if node.op is Op.DIV]
            assert not [one for one in divisors if vanishes(one)], f"{name} by {formulation}"
            seen += len(divisors)
    assert seen


def test_what_is_zero_in_disguise_is_told_from_what_is_not():
    from symdyn.dynamics.mechanism.linear_solve import vanishes

    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    s, c = graph.sin(x + y), graph.cos(x + y)
    sums = s - (graph.sin(x) * graph.cos(y) + graph.cos(x) * graph.sin(y))
    root = graph.sqrt(x * x + y)
    assert vanishes(sums)
    assert vanishes(graph.constant(2) - s * s * 2 - 2 * c * c)
    assert vanishes(root * root - y - x * x)
    assert vanishes((x + y) * (x - y) - x * x + y * y)
    assert not vanishes(sums + graph.sin(x / 7) / 10**9)
    assert not vanishes(root - x)
    assert not vanishes(graph.one)
    assert vanishes(graph.zero)


def test_an_angle_whose_order_cannot_be_factored_is_refused_in_words():
    """What zeros are needs a root of unity of order 2 n, whose primes are its proof (it hung on the way there)."""
    from symdyn.dynamics.mechanism.linear_solve import vanishes
    from symdyn.errors import DerivationError

    graph = Graph()
    x = graph.symbol("x")
    fine = graph.pi / 10**300
    assert vanishes(graph.sin(x + fine) - graph.sin(x) * graph.cos(fine) - graph.cos(x) * graph.sin(fine))
    with pytest.raises(DerivationError, match="a factor of 906 bits that no small prime divides; at most 128"):
        vanishes(graph.sin(x + graph.pi / int("6" * 300)) - x)
