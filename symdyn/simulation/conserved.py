"""Momenta that the motion conserves: found by their rates, which vanish at random states.

Candidates are the generalized momenta p = M u, and for a ball or a free body on the ground the same in ground axes, the
angular one about the ground's origin. A rate is formed on the graph, with the accelerations of the forward dynamics in
it, so that gravity, drives and loads count; what vanishes at every one of the random states is conserved.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from symdyn.algebra.numeric import Floats
from symdyn.dynamics.derive import derive_one
from symdyn.dynamics.state import joint_motion, placement, quaternions
from symdyn.dynamics.workspace import Workspace
from symdyn.graph import Expr, evaluate, tangents
from symdyn.scene import GROUND, JOINTS, Joint, express
from symdyn.simulation.reading import TIME
from symdyn.spatial import add, apply, cross

STATES = 4
NEGLIGIBLE = 1e-9
"""A rate below it, over the largest rate of any momentum and at least 1, is zero."""


def conserved(w: Workspace, accelerations: Sequence[Expr], tabulated: bool) -> list[tuple[str, Expr]]:
    """Return name and formula of every momentum that is conserved; none for closed scenes.

    Args:
        w: the scene.
        accelerations: u̇ in terms of q, u and t, shape (nv,).
        tabulated: whether some driving force is a table, which has no formula.
    """
    scene, state = w.scene, w.state
    if scene.is_closed or tabulated or not state.n:
        return []
    momenta = list(derive_one(w, "momentum").entries)
    names = [f"momentum_{velocity.removesuffix('_dot')}" for velocity in scene.velocities]
    candidates = list(zip(names, momenta, strict=True))
    first = 0
    for joint in scene.moving:
        own = momenta[first : first + len(joint.rates)]
        if joint.parent == GROUND and "1" in JOINTS[joint.type].coordinates(joint):
            candidates += _in_ground_axes(w, joint, own)
        first += len(joint.rates)
    seeds = state.velocity | dict(zip(state.qd, accelerations, strict=True))
    seeds[w.graph.symbol(TIME)] = w.graph.one
    rates = tangents([p for _, p in candidates], seeds)
    sizes = [0.0] * len(candidates)
    for k in range(STATES):
        try:
            values = evaluate(rates, Floats(), _state(w, k))
        except (ArithmeticError, ValueError):
            return []
        sizes = [max(size, abs(value)) for size, value in zip(sizes, values, strict=True)]
    limit = NEGLIGIBLE * max(1.0, *sizes)
    return [one for one, size in zip(candidates, sizes, strict=True) if size <= limit and not one[1].is_zero]


def _in_ground_axes(w: Workspace, joint: Joint, own: Sequence[Expr]) -> list[tuple[str, Expr]]:
    """Return the momenta of a ball or free joint on the ground, in ground axes."""
    T = placement(joint.origin, w.graph) @ joint_motion(joint, w.graph).placement
    if len(own) == 3:
        angular = apply(T.R, (own[0], own[1], own[2]))
        return [(f"momentum_{joint.name}_L{axis}", x) for axis, x in zip("xyz", angular, strict=True)]
    if len(own) != 6:
        return []
    linear = apply(T.R, (own[0], own[1], own[2]))
    angular = add(apply(T.R, (own[3], own[4], own[5])), cross(T.p, linear))
    pairs = [(f"P{axis}", x) for axis, x in zip("xyz", linear, strict=True)]
    pairs += [(f"L{axis}", x) for axis, x in zip("xyz", angular, strict=True)]
    return [(f"momentum_{joint.name}_{name}", x) for name, x in pairs]


def _state(w: Workspace, k: int) -> dict[Expr, float]:
    """Return the k-th random state, with unit quaternions."""
    rng = random.Random(f"{w.scene.name}:{k}")
    values = {x: rng.uniform(-1.0, 1.0) for x in (*w.state.q, *w.state.qd, w.graph.symbol(TIME))}
    for group in quaternions(w.scene):
        nodes = [w.graph.symbol(name) for name in group]
        length = sum(values[node] ** 2 for node in nodes) ** 0.5
        values |= {node: values[node] / length for node in nodes}
    for parameter in w.scene.parameters:
        if parameter.value is not None:
            (values[w.graph.symbol(parameter.name)],) = evaluate([express(parameter.value, w.graph)], Floats(), {})
    return values
