"""What has no value at a state where a run cannot begin or go on: a formula, or a strut between points that meet."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from symdyn.algebra import Array, Floats
from symdyn.dynamics.loops import Numbers
from symdyn.dynamics.mechanism import ends_apart, pull
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import TIMED, spell
from symdyn.simulation.prescribed.forces import Forces, force_names
from symdyn.spatial import dot


def valueless(scene: Scene, forces: Forces, t: float = 0.0, q: Array | None = None, u: Array | None = None) -> str:
    """Return what has no value at a time, s, and a state, shapes (nq,) and (nu,), or the start; "" for nothing."""
    graph = Graph()
    if q is None or u is None:
        q, u = Numbers(scene).start(), np.zeros(len(scene.first_order))
    values = scene.at_time(graph, t) | dict(zip(map(graph.symbol, scene.coordinates), q.tolist(), strict=True))
    moving = (*scene.velocities, *(one.name for one in scene.states))
    values |= dict(zip(map(graph.symbol, moving), u.tolist(), strict=True))
    for parameter in scene.parameters:
        if parameter.value is not None:
            values[graph.symbol(parameter.name)] = evaluate([parameter.value.express(graph)], Floats(), {})[0]

    def has_value(formula: Expr) -> bool:
        try:
            return math.isfinite(evaluate([formula], Floats(), values)[0])
        except (ArithmeticError, ValueError):
            return False

    for what, quantity in _formulas(scene, forces):
        try:
            known = has_value(quantity.express(graph))
        except ZeroDivisionError:
            known = False
        if not known:
            return f"{what}, {spell(quantity)}, has no real value there"
    for what, formula in _between_points(scene, graph):
        if not has_value(formula):
            return what
    return ""


def _formulas(scene: Scene, forces: Forces) -> Iterator[tuple[str, Quantity]]:
    names = force_names(scene)
    for k, formula in forces.formulas.items():
        yield f"the {'driving force' if k < len(scene.velocities) else 'input'} {names[k]}", formula
    for joint in scene.joints:
        for formula in joint.forces:
            yield f"the force of joint {joint.name}", formula
        if joint.motion is not None:
            yield f"the motion of joint {joint.name}", joint.motion
    for state in scene.states:
        yield f"the rate of the state {state.name}", state.rate
    for one in scene.elements:
        for part in FORCES[one.kind].parts:
            for number in part.numbers(one):
                if number.names == TIMED:
                    yield f"{one.kind} {one.name}", number.quantity


def _between_points(scene: Scene, graph: Graph) -> Iterator[tuple[str, Expr]]:
    for strut in scene.struts:
        if not strut.ends:
            continue
        way = ends_apart(scene, strut.ends, graph)
        square = dot(way, way)
        if square.is_zero:  # points that never part pull at nothing
            continue
        words = f"{strut.kind} {strut.name} has no length there"
        beside = [one for one in scene.struts if one is not strut and one.ends == strut.ends]
        if FORCES[strut.kind].pull.over is None:
            springs = (f"{x.kind} {x.name}" for x in beside if FORCES[x.kind].pull.over is not None)
            spring = next(springs, "a spring beside it")
            ways = f"put it on a joint, or give {spring} a free length (free = 0.5) and start where it has it"
            yield f"{words}, and so no direction: {ways}", graph.one / square
        else:
            ways = "start where it has its length" if beside else "with free = 0 it would not; else set its ends apart"
            words = f"{words}, where it pulls ({ways})"
            yield f"{words}, and so no direction", pull(strut, square, graph.zero)
