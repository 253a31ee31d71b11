"""What a start is beyond its doubles: a third of a radian is no double, and a run with 31 digits starts there."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from symdyn.algebra import Array
from symdyn.dynamics.mechanism import quaternions
from symdyn.graph import Graph
from symdyn.program import constants
from symdyn.scene import Scene
from symdyn.simulation.initial import Start

NEAR = Fraction(1, 2**50)
"""What a number may be off beside its size and still be the double of its formula; else it was moved, and stays."""


def beyond_doubles(scene: Scene, start: Start, size: int) -> Array:
    """Return what the formulas of a start are beyond its doubles, shape (size,); zero where there are none.

    Quaternions are brought to length one.
    """
    low, graph = np.zeros(size), Graph()
    numbers = [formula.express(graph) for formula in start.formulas]
    for group in quaternions(scene) if numbers else ():
        first = list(scene.coordinates).index(group[0])
        four = numbers[first : first + 4]
        length = graph.sqrt(graph.total(x * x for x in four))
        numbers[first : first + 4] = [x / length for x in four]
    known = constants(numbers)
    for k, (number, double) in enumerate(zip(numbers, (*start.q, *start.u)[: len(numbers)], strict=True)):
        off = known[number] - Fraction(float(double))
        low[k] = float(off) if abs(off) <= NEAR * abs(known[number]) else 0.0
    return low
