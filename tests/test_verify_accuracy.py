"""What built code is held against: a bound, and runs with roundings by lot where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from formulas import argument, function

from symdyn.dynamics.outputs.named_functions import Equations
from symdyn.graph import Graph
from symdyn.program import lower
from symdyn.scene import Scene
from symdyn.scene.values import Parameter
from symdyn.verify.accuracy import measure, remarks

STEPS = 40


def quotient_without_a_bound():
    """Return 1/x, x having come through 40 steps x = c x - x at c = 2, each of which triples its bound."""
    graph = Graph()
    q, x = graph.symbol("q1"), graph.symbol("x1")
    c = graph.sin(q) ** 2 + graph.cos(q) ** 2 + 1
    moved = x
    for _ in range(STEPS):
        moved = c * moved - moved
    arguments = [argument("q", [q]), argument("params", [x], "m")]
    scene = Scene("growing", (Parameter("x1", unit="m"),))
    return lower(Equations(scene, graph, (function("share", arguments, (1,), [1 / moved]),)))


class Module:
    def __init__(self, factor: float = 1.0) -> None:
        self.factor = factor

    def share(self, q, params):
        c, x = math.sin(q[0]) ** 2 + math.cos(q[0]) ** 2 + 1, params[0]
        for _ in range(STEPS):
            x = c * x - x
        return np.array([self.factor / x])


@pytest.mark.parametrize(("factor", "passed"), [(1.0, True), (1 + 1e-9, False)])
def test_code_without_a_bound_is_held_against_runs_with_roundings_by_lot(factor, passed):
    (found,) = measure(quotient_without_a_bound(), {"numpy": Module(factor)})

    assert (found.bounded, found.states, found.passed) == (False, 12, passed)
    (told,) = remarks([found])
    assert told.startswith("share: no bound holds so many roundings: held against 6 runs")
