"""What every run looks for: where equations of motion end, and where joints pass their limits.

    clearance      volume of the axes of three turns: it changes its sign where the angles are singular
    w² - FLAT²     w the sine of the angle between the axis of a wheel and the normal of its plane, which vanishes
                   where no point of the rim is the lowest; being |sin|, it does so without a change of sign
    position       (x - lower) (x - upper), or one of them alone
    velocity       v² - limit²              effort    τ² - limit²

Limits are negative inside and positive outside, so that their zeros are passages, by turns out and in: told, as nothing
in the equations keeps them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from symdyn.dynamics.loops.cuts import gauges
from symdyn.dynamics.loops.loop_numbers import FLAT
from symdyn.dynamics.mechanism.angles import angles_of
from symdyn.dynamics.mechanism.loads import joint_rates
from symdyn.dynamics.mechanism.state import joint_position
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene import JOINTS, Joint, Quantity, Scene, express
from symdyn.scene.values.table import Faults
from symdyn.simulation.prescribed.formulas_in_time import number_of, parameter_values

SLACK = Fraction(1, 10**9)
"""What a motion may be beyond a limit, rad or m, for one that rests on it rounds."""

UNITS = {"position": ("rad", "m"), "velocity": ("rad/s", "m/s"), "effort": ("N m", "N")}


def ends(scene: Scene, graph: Graph) -> list[tuple[Expr, str]]:
    """Return what crosses zero at such places, and what is said there."""
    found = [(one.clearance(graph), one.became_singular) for one in angles_of(scene)]
    least = graph.constant(Fraction(FLAT).limit_denominator(10**6))
    found += [(one.sine * one.sine - least * least, one.fell_flat) for one in gauges(scene, graph)]
    moving = {graph.symbol(name) for name in scene.coordinates}
    return [(formula, words) for formula, words in found if moving.intersection(reachable([formula]))]


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

    def words(self, scene: Scene) -> str:
        """Return whose, what and how far at values of a scene, such as "joint elbow: position within -1 … 1.57 rad"."""
        given = self.joint.limits
        size = None if self.kind == "position" else getattr(given, self.kind)
        lower, upper = (None if x is None else _number(scene, x) for x in (given.lower, given.upper))
        if size is not None:
            range_ = f"up to {_number(scene, size)}"
        elif lower is not None and upper is not None:
            range_ = f"within {lower} … {upper}"
        else:
            range_ = f"up to {upper}" if lower is None else f"from {lower}"
        turns = not JOINTS[self.joint.type].slides(self.joint)
        return f"joint {self.joint.name}: {self.kind} {range_} {UNITS[self.kind][0 if turns else 1]}"


def limits_of(scene: Scene, graph: Graph, drives: Sequence[Expr]) -> list[Limit]:
    """Return the limits that joints declare and a state can pass, for the driving force of every velocity."""
    velocities, found = list(scene.velocities), []
    for joint in scene.joints:
        given, rates = joint.limits, joint_rates(joint, graph)
        if len(rates) != 1:
            continue
        if given.lower is not None or given.upper is not None:
            found.append(_position(joint, graph))
        sizes = [("velocity", given.velocity, rates[0])]
        if joint.coupling is None:
            sizes.append(("effort", given.effort, drives[velocities.index(joint.rates[0])]))
        for kind, largest, value in sizes:
            if largest is not None:
                size = express(largest, graph)
                found.append(Limit(joint, kind, value * value - size * size - SLACK))
    still = {parameter.name for parameter in scene.parameters}
    return [
        one
        for one in found
        if any(node.op is Op.SYMBOL and node.value not in still for node in reachable([one.beyond]))
    ]


def _position(joint: Joint, graph: Graph) -> Limit:
    x, lower, upper = joint_position(joint, graph), joint.limits.lower, joint.limits.upper
    least, most = (None if one is None else express(one, graph) for one in (lower, upper))
    if least is not None and most is not None:
        beyond = (x - (least - SLACK)) * (x - (most + SLACK))
    else:
        beyond = x - most - SLACK if most is not None else least - x - SLACK  # type: ignore[operator]
    return Limit(joint, "position", beyond)


def _number(scene: Scene, quantity: Quantity) -> str:
    value = number_of(quantity, parameter_values(scene), "limits", Faults(""))
    return "?" if value is None else f"{value:.6g}"


def passed(words: str, beyond_at_start: bool, times: Sequence[float]) -> str:
    """Return what is said of a limit, passed out and in by turns at some times; "" where a run kept it."""
    out = [*([0.0] if beyond_at_start else []), *times[1 if beyond_at_start else 0 :: 2]]
    if not out:
        return ""
    first = "at the start" if beyond_at_start else f"at t = {out[0]:.6g} s"
    again = len(out) - 1
    more = f" and {again} time{'s' * (again > 1)} more" if again else ""
    return f"{words} is passed {first}{more}; the limit is data for controllers, nothing in the equations keeps it"
