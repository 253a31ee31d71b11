"""Motions that are prescribed: coordinates that follow a formula in time, whatever force that takes.

The coordinate stays in q. In forward dynamics its acceleration is known and its force is not: with p for prescribed and
f for free velocities

    M_ff u̇_f = τ_f - (M_fp u̇_p + h_f)      τ_p = M_pf u̇_f + M_pp u̇_p + h_p      h = c + g + k_E - Q

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 9.1, hybrid dynamics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.mechanism.ldl import Singular, solve
from symdyn.graph import Expr, Graph, tangents
from symdyn.scene import Scene

TIME = "t"
"""Name of time in formulas and on the graph, s."""

INPUTS = "inputs"
"""Name of the argument of what depends on letters that are given over time."""


def inputs_of(scene: Scene, graph: Graph) -> tuple[Expr, ...]:
    """Return the symbols of the inputs of a scene."""
    return tuple(graph.symbol(one.name) for one in scene.inputs)


def has_motion(scene: Scene) -> bool:
    """Whether a motion is prescribed."""
    return any(joint.motion is not None for joint in scene.joints)


@dataclass(frozen=True)
class Prescribed:
    """Prescribed motions.

    Attributes:
        n: number of velocities.
        place: velocities with a prescribed motion, from 0, ascending.
        position, velocity, acceleration: of each, formulas in t.
    """

    n: int
    place: tuple[int, ...]
    position: tuple[Expr, ...]
    velocity: tuple[Expr, ...]
    acceleration: tuple[Expr, ...]

    @property
    def free(self) -> list[int]:
        """Velocities without a prescribed motion, from 0, ascending."""
        return [k for k in range(self.n) if k not in self.place]

    def entered(self, values: Sequence[Expr]) -> list[Expr]:
        """Return rates of velocities, shape (n,), with the prescribed ones in their places."""
        result = list(values)
        for k, value in zip(self.place, self.acceleration, strict=True):
            result[k] = value
        return result


def prescribed(scene: Scene, graph: Graph) -> Prescribed:
    """Return the prescribed motions of a scene, and their derivatives by time."""
    known = [(scene.velocities.index(j.rates[0]), j.motion) for j in scene.joints if j.motion is not None]
    known.sort(key=lambda pair: pair[0])
    clock = {graph.symbol(TIME): graph.one} if known else {}
    position = [formula.express(graph) for _, formula in known]
    velocity = tangents(position, clock)
    acceleration = tangents(velocity, clock)
    place = tuple(k for k, _ in known)
    return Prescribed(len(scene.velocities), place, tuple(position), tuple(velocity), tuple(acceleration))


def accelerations(
    given: Prescribed, parents: Sequence[int], M: list[list[Expr]], tau: Sequence[Expr], bias: Sequence[Expr]
) -> list[Expr]:
    """Return u̇, shape (n,): prescribed where it is, else from M_ff u̇_f = τ_f - bias_f; Singular where M_ff is.

    The bias is M u̇ + h for the prescribed accelerations alone; `parents` is the tree of the free velocities.
    """
    free = given.free
    own = [[M[i][j] for j in free] for i in free]
    try:
        found = solve(parents, own, [tau[i] - bias[i] for i in free])
    except Singular as fault:
        raise Singular(free[fault.velocity]) from fault
    result = given.entered([M[0][0].graph.zero] * given.n) if given.n else []
    for i, value in zip(free, found, strict=True):
        result[i] = value
    return result
