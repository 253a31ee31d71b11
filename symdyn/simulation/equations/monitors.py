"""What runs watch beside the equations of motion: momenta that are conserved, and limits of joints that are passed.

Candidates for what is conserved are the generalized momenta p = M u, and for a ball or a free body on the ground the
same in ground axes, the angular one about the ground's origin. A rate is formed on the graph, with the accelerations of
the forward dynamics in it, so that gravity, drives and loads count; what vanishes at every one of the random states is
conserved.

Limits are negative inside and positive outside; one is passed that is positive by more than `SLACK`:

    upper          x - limit                lower     limit - x
    velocity       v² - limit²              effort    τ² - limit²

Only passages outwards are looked for: nothing in the equations keeps a limit, but behind those of position they are no
longer those of the mechanism, whose joint rests on its stop.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence

from symdyn.algebra import Floats
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.mechanism import TIME, quaternions
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, tangents
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, joint_motion
from symdyn.scene.values import Faults, Joint, force_unit
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values
from symdyn.spatial import add, cross
from symdyn.unlocked import cached_property

STATES = 4
NEGLIGIBLE = 1e-9
"""A rate below it, over the largest rate of any momentum and at least 1, is zero."""


@dataclass(frozen=True)
class Candidates:
    """Momenta that may be conserved."""

    scene: Scene  # whose, its parameters free
    names: tuple[str, ...] = ()  # of their columns
    formulas: tuple[Expr, ...] = ()  # of the momenta, shape (count,)
    rates: tuple[Expr, ...] = ()  # of the momenta, in the order of `formulas`

    @cached_property
    def _order(self) -> tuple[Expr, ...]:
        return reachable(self.rates)

    def conserved(self, values: Mapping[str, float]) -> tuple[int, ...]:
        """Return which momenta are conserved at values of the parameters, ascending."""
        sizes = [0.0] * len(self.names)
        for k in range(STATES if sizes else 0):
            state = _state(self.scene, self.rates[0].graph, k) | values_on(self.rates[0].graph, values)
            try:
                rates = evaluate(self.rates, Floats(), state, self._order)
            except (ArithmeticError, ValueError):
                return ()
            sizes = [max(size, abs(value)) for size, value in zip(sizes, rates, strict=True)]
        limit = NEGLIGIBLE * max(1.0, *sizes) if sizes else 0.0
        return tuple(k for k, size in enumerate(sizes) if size <= limit and not self.formulas[k].is_zero)


def candidates(w: Workspace, accelerations: Sequence[Expr], tabulated: bool) -> Candidates:
    """Return name and formula of every momentum that may be conserved; none of closed scenes or under tables.

    `accelerations` are u̇ in terms of q, u and t, shape (nv,).
    """
    scene, state = w.scene, w.state
    if scene.is_constrained or tabulated or not state.n:
        return Candidates(scene)
    momenta = list(derive_one(w, "momentum").entries)
    names = [f"momentum_{velocity.removesuffix('_dot')}" for velocity in scene.velocities]
    found = list(zip(names, momenta, strict=True))
    first = 0
    for joint in scene.moving:
        own = momenta[first : first + len(joint.rates)]
        if joint.parent == Scene.GROUND and JOINTS[joint.type].quaternion(joint) is not None:
            found += _in_ground_axes(w, joint, own)
        first += len(joint.rates)
    seeds = state.velocity | dict(zip(state.qd, accelerations, strict=True))
    seeds |= {w.graph.symbol(TIME): w.graph.one} | dict(zip(w.states, w.state_rates, strict=True))
    formulas = tuple(p for _, p in found)
    return Candidates(scene, tuple(name for name, _ in found), formulas, tuple(tangents(formulas, seeds)))


def _in_ground_axes(w: Workspace, joint: Joint, own: Sequence[Expr]) -> list[tuple[str, Expr]]:
    """Return the momenta of a ball or free joint on the ground, in ground axes."""
    T = joint.origin.transform(w.graph) @ joint_motion(joint, w.graph).placement
    if len(own) == 3:
        angular = T.R @ (own[0], own[1], own[2])
        return [(f"momentum_{joint.name}_L{axis}", x) for axis, x in zip("xyz", angular, strict=True)]
    if len(own) != 6:
        return []
    linear = T.R @ (own[0], own[1], own[2])
    angular = add(T.R @ (own[3], own[4], own[5]), cross(T.p, linear))
    pairs = [(f"P{axis}", x) for axis, x in zip("xyz", linear, strict=True)]
    pairs += [(f"L{axis}", x) for axis, x in zip("xyz", angular, strict=True)]
    return [(f"momentum_{joint.name}_{name}", x) for name, x in pairs]


def _state(scene: Scene, graph: Graph, k: int) -> dict[Expr, float]:
    rng = random.Random(f"{scene.name}:{k}")
    values = {graph.symbol(name): rng.uniform(-1.0, 1.0) for name in (*scene.plain_names, TIME)}
    for group in quaternions(scene):
        nodes = [graph.symbol(name) for name in group]
        length = sum(values[node] ** 2 for node in nodes) ** 0.5
        values |= {node: values[node] / length for node in nodes}
    return values


def values_on(graph: Graph, values: Mapping[str, float]) -> dict[Expr, float]:
    """Return values by name as values of the symbols of a graph."""
    return {graph.symbol(name): value for name, value in values.items()}


SLACK = 1e-9
"""What a motion may be beyond a limit, of its unit or that squared, for one that rests on it rounds."""

UNITS = {
    "lower": ("rad", "m"),
    "upper": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "effort": (force_unit("rad"), force_unit("m")),
}
"""By the key of a limit, where a joint turns and where it slides."""

STOPS = ("lower", "upper")
"""Limits that a joint cannot pass without breaking; the others say what its drive can do."""


@dataclass(frozen=True)
class Limit:
    """A limit that a motion may pass."""

    joint: Joint  # whose it is
    kind: str  # a key of `UNITS`
    beyond: Expr  # formula that is positive beyond it

    def size(self, scene: Scene) -> float:
        """Return how far it lets go at values of a scene, of its unit; NaN where that has no value."""
        value = number_of(getattr(self.joint.limits, self.kind), parameter_values(scene), "limits", Faults(""))
        return math.nan if value is None else value

    def words(self, scene: Scene) -> str:
        """Return which it is and how far it lets go, such as "upper limit 1.57 rad"."""
        turns = not JOINTS[self.joint.type].slides(self.joint)
        unit = UNITS[self.kind][0 if turns else 1]
        return f"{self.kind} limit {scene.in_shown_unit(f'{self.size(scene):.6g}', unit)}"


def limits_of(scene: Scene, graph: Graph, drives: Sequence[Expr]) -> list[Limit]:
    """Return the limits that joints declare and a state can pass, for the driving force of every velocity."""
    velocities, found = list(scene.velocities), []
    for joint in scene.joints:
        given, rates = joint.limits, joint.speeds(graph)
        if len(rates) != 1:
            continue
        x = joint.position(graph)
        if given.lower is not None:
            found.append(Limit(joint, "lower", given.lower.express(graph) - x))
        if given.upper is not None:
            found.append(Limit(joint, "upper", x - given.upper.express(graph)))
        sizes = [("velocity", given.velocity, rates[0])]
        if joint.coupling is None:
            sizes.append(("effort", given.effort, drives[velocities.index(joint.rates[0])]))
        for kind, largest, value in sizes:
            if largest is not None:
                size = largest.express(graph)
                found.append(Limit(joint, kind, value * value - size * size))
    still = {parameter.name for parameter in scene.parameters}
    return [
        one
        for one in found
        if any(node.op is Op.SYMBOL and node.value not in still for node in reachable([one.beyond]))
    ]
