"""Where joints pass their limits, which every run looks for beside where equations of motion end.

    upper          x - limit                lower     limit - x
    velocity       v² - limit²              effort    τ² - limit²

Limits are negative inside and positive outside; one is passed that is positive by more than `SLACK`. Only passages
outwards are looked for: nothing in the equations keeps a limit, but behind those of position they are no longer those
of the mechanism, whose joint rests on its stop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Faults, Joint, force_unit
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values

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
    """A limit that a motion may pass.

    Attributes:
        joint: whose it is.
        kind: a key of `UNITS`.
        beyond: formula that is positive beyond it.
    """

    joint: Joint
    kind: str
    beyond: Expr

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
