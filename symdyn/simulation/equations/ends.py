"""Where equations of motion end: angles that become singular, wheels that come to lie flat.

clearance      volume of the axes of three turns: it changes its sign where the angles are singular
w² - FLAT²     w the sine of the angle between the axis of a wheel and the normal of its plane, which vanishes
               where no point of the rim is the lowest; being |sin|, it does so without a change of sign
"""

from __future__ import annotations

from fractions import Fraction

from symdyn.dynamics.loops.cuts import gauges
from symdyn.dynamics.loops.loop_numbers import FLAT
from symdyn.dynamics.mechanism.angles import angles_of
from symdyn.graph import Expr, Graph, reachable
from symdyn.scene import Scene


def ends(scene: Scene, graph: Graph) -> list[tuple[Expr, str]]:
    """Return what crosses zero at such places, and what is said there."""
    found = [(one.clearance(graph), one.became_singular) for one in angles_of(scene)]
    least = graph.constant(Fraction(FLAT).limit_denominator(10**6))
    found += [(one.sine * one.sine - least * least, one.fell_flat) for one in gauges(scene, graph)]
    moving = {graph.symbol(name) for name in scene.coordinates}
    return [(formula, words) for formula, words in found if moving.intersection(reachable([formula]))]
