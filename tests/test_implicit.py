"""The rule of what equations decide: they hold, K is symmetric and solved, and trees and loops share it."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from symdyn.algebra import Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs import implicit
from symdyn.dynamics.outputs.tangent_space import FREE, MANIFOLD
from symdyn.graph import Expr, Op, evaluate, reachable, substitute, tangents
from symdyn.scene import read

EXAMPLES = Path(__file__).parent.parent / "examples"
TREES, LOOPS = ("cart_pole", "scara", "puma560"), ("four_bar", "governor", "slider_crank")


def at_work(name: str) -> tuple[Workspace, implicit.Implicit]:
    w = Workspace(read(EXAMPLES / f"{name}.toml"))
    return w, w.once(implicit.motion, MANIFOLD if w.scene.is_constrained else FREE)


def numbers(entries: Sequence[Expr]) -> np.ndarray:
    """Return entries where every symbol has some value: off the manifold, and of another mechanism of the kind."""
    symbols = [node for node in reachable(entries) if node.op is Op.SYMBOL]
    values = {node: random.Random(str(node.value)).uniform(0.4, 1.3) for node in symbols}
    return np.array(evaluate(entries, Floats(), values), dtype=float)


@pytest.mark.parametrize("name", [*TREES, *LOOPS])
def test_equations_hold_at_what_they_decide(name: str) -> None:
    _, known = at_work(name)
    left = substitute(known.residual(), dict(zip(known.symbols, known.values(), strict=True)))
    assert np.abs(numbers(left)).max() < 1e-9 * np.abs(numbers(known.residual())).max()


@pytest.mark.parametrize("name", [*TREES, *LOOPS])
def test_what_is_solved_has_the_symmetric_matrix_of_slopes(name: str) -> None:
    w, known = at_work(name)
    one, zero, size = w.graph.one, w.graph.zero, len(known.symbols)
    columns = [numbers(tangents(known.residual(), {symbol: one})) for symbol in known.symbols]
    solved = [numbers(known.solve([one if i == k else zero for i in range(size)])) for k in range(size)]
    K, X = np.array(columns).T, np.array(solved).T

    assert pytest.approx(K.T, rel=1e-12, abs=1e-12 * np.abs(K).max()) == K
    assert pytest.approx(np.eye(size), abs=1e-9) == K @ X


@pytest.mark.parametrize("name", TREES)
def test_a_tree_has_by_the_rule_what_its_recursion_finds(name: str) -> None:
    w, _ = at_work(name)
    by_rule = implicit.jacobian(implicit.motion, implicit.accelerations, "implicit", FREE, ("q", "qd", "tau"), w)
    known = numbers(derive_one(w, "forward_dynamics_derivatives", "recursive").entries)
    assert numbers(by_rule) == pytest.approx(known, rel=1e-9, abs=1e-9 * np.abs(known).max())


@pytest.mark.parametrize("name", LOOPS)
def test_a_column_is_the_product_along_one_direction(name: str) -> None:
    w, _ = at_work(name)
    for part, of in ((implicit.accelerations, "forward_dynamics"), (implicit.multipliers, "multipliers")):
        along = ("q", "qd", "tau")
        J = implicit.jacobian(implicit.motion, part, "implicit", MANIFOLD, along, w)
        moved = implicit.jvp(implicit.motion, part, MANIFOLD, along, w)
        d = [one for some in MANIFOLD.amounts(w, along).values() for one in some]
        known = numbers(J).reshape(len(moved), len(d)) @ numbers(d)
        assert numbers(moved) == pytest.approx(known, rel=1e-9, abs=1e-9 * np.abs(known).max()), of
