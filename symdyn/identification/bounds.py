"""What an exciting motion must keep: limits of joints and drives, and boxes, of anything that has a name.

    q1=-1..1  q1_dot=..2  q1_ddot=-5..5  tau1=-40..40  tool.z=0.1..       either end may be left out

Limits are those of the scene; what is asked for narrows them. Coordinates without any get one that is reported, since a
motion that nothing bounds has no best.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from symdyn.errors import suggestion
from symdyn.frozen import dataclass, replace
from symdyn.scene import Quantity, Scene, SceneUnits
from symdyn.scene.values import Faults, Joint, Parameter, acceleration_name, force_unit
from symdyn.simulation.prescribed import drive_names, number_of, parameter_values, read_number

Box = Mapping[str, tuple[object, object]] | Sequence[str]

REACH = {"rad": 2.0, "m": 0.25}
"""rad or m, to both sides of the start, of a coordinate without limits."""

SPEED = {"rad": 2.0, "m": 0.5}
"""rad/s or m/s, of a velocity without a limit."""

UNITS = {"position": "", "velocity": "/s", "acceleration": "/s^2"}


@dataclass(frozen=True)
class Bound:
    """Limits of one number of a motion.

    Attributes:
        name: such as "q1", "tau1" or "tool.z".
        kind: "position", "velocity", "acceleration", "force" or "place".
        index: which of its kind; of points three times its number, and the axis.
        low, high: -inf and inf where there is none.
        unit: such as "rad/s".
        usual: whether it is a default.
    """

    name: str
    kind: str
    index: int
    low: float = -math.inf
    high: float = math.inf
    unit: str = ""
    usual: bool = False

    @property
    def size(self) -> float:
        """Half the range between both, or how far the one is from zero: the unit of distances to limits."""
        if math.isfinite(self.low) and math.isfinite(self.high):
            return (self.high - self.low) / 2
        return abs(self.low if math.isfinite(self.low) else self.high) or 1.0

    def within(self, low: float, high: float) -> Bound:
        """Return the narrower bound."""
        return replace(self, low=max(self.low, low), high=min(self.high, high), usual=False)


def read_bounds(scene: Scene, start: Sequence[float], box: Box, faults: Faults) -> tuple[Bound, ...]:
    """Return the bounds of every position and velocity, and of what else has some, in the order of `_all`.

    Args:
        scene: the mechanism, its parameters bound; every velocity is the rate of the coordinate of its number.
        start: coordinates at the start, shape (nq,).
        box: limits by name, (low, high) with None for none, or as texts; see the module's legend.
        faults: takes what is wrong.
    """
    values = parameter_values(scene)
    found = _all(scene)
    for joint in scene.joints:
        for name, low, high in _of_joint(scene, joint, values, faults):
            found[name] = found[name].within(low, high)
    points = {one.name for one in scene.points}
    for where, given, low, high in _asked(box, values, {name: one.unit for name, one in found.items()}, faults):
        name = _dotted(given, points)
        if name in found:
            found[name] = found[name].within(low, high)
        else:
            faults.add(where, f"{given} is nothing that a box can hold; {suggestion(given, found)}")
    found = {name: replace(one, unit=scene.shown_unit(one.unit)) for name, one in found.items()}
    units = SceneUnits(scene).velocities
    for k, (q, u) in enumerate(zip(scene.coordinates, scene.velocities, strict=True)):
        reach, speed = REACH[units[k]], SPEED[units[k]]
        one = found[q]
        if math.isinf(one.low) or math.isinf(one.high):
            low = one.low if math.isfinite(one.low) else min(start[k], one.high) - reach
            high = one.high if math.isfinite(one.high) else max(start[k], one.low) + reach
            found[q] = replace(one, low=low, high=high, usual=True)
        if math.isinf(found[u].low) and math.isinf(found[u].high):
            found[u] = replace(found[u], low=-speed, high=speed, usual=True)
        elif math.isinf(found[u].low) or math.isinf(found[u].high):
            size = found[u].high if math.isfinite(found[u].high) else -found[u].low
            found[u] = replace(found[u], low=-size, high=size)
    for one in found.values():
        if not one.low < one.high:
            faults.add(one.name, f"limits {one.low:g} to {one.high:g} {one.unit} leave no range; widen them")
        elif one.kind in ("velocity", "acceleration") and not one.low < 0 < one.high:
            faults.add(one.name, f"limits {one.low:g} to {one.high:g} {one.unit} do not let it rest; let 0 lie between")
    return tuple(one for one in found.values() if math.isfinite(one.low) or math.isfinite(one.high))


def usual_notes(bounds: Sequence[Bound]) -> list[str]:
    """Return notes on bounds that are defaults, one line a size."""
    found: dict[str, list[str]] = {}
    for one in bounds:
        if one.usual:
            found.setdefault(f"{one.low:.4g} to {one.high:.4g} {one.unit}", []).append(one.name)
    return [
        f"{', '.join(names)}: no limits are known; taken from {size}; give limits in the scene or a box "
        f'such as "{names[0]}=-1..1"'
        for size, names in found.items()
    ]


def _all(scene: Scene) -> dict[str, Bound]:
    """Return what a box can hold, by name: coordinates, velocities, accelerations, drives, places of points."""
    units = SceneUnits(scene).velocities
    found: dict[str, Bound] = {}
    for kind, names in (
        ("position", scene.coordinates),
        ("velocity", scene.velocities),
        ("acceleration", [acceleration_name(name) for name in scene.velocities]),
    ):
        found |= {name: Bound(name, kind, k, unit=units[k] + UNITS[kind]) for k, name in enumerate(names)}
    found |= {name: Bound(name, "force", k, unit=force_unit(units[k])) for k, name in enumerate(drive_names(scene))}
    axes = [(f"{one.name}.{axis}", 3 * k + i) for k, one in enumerate(scene.points) for i, axis in enumerate("xyz")]
    return found | {name: Bound(name, "place", k, unit="m") for name, k in axes}


def _dotted(name: str, points: set[str]) -> str:
    """Return tool.z of point_tool_z, as runs call it; another name as it is."""
    point, _, axis = name.removeprefix("point_").rpartition("_")
    return f"{point}.{axis}" if name.startswith("point_") and point in points else name


def _of_joint(
    scene: Scene, joint: Joint, values: Mapping[str, Quantity], faults: Faults
) -> list[tuple[str, float, float]]:
    """Return name, low and high of a joint's limits, of the coordinate that it has or follows."""

    def number(quantity: Quantity | None) -> float:
        found = math.inf if quantity is None else number_of(quantity, values, f"joints.{joint.name}", faults)
        return math.inf if found is None else found

    given, coupling = joint.limits, joint.coupling
    if coupling is None and len(joint.coordinates) != 1:
        return []
    ratios = ((joint.coordinates[0], Quantity.ONE),) if coupling is None else coupling.ratios
    if len(ratios) > 1:  # a limit of a sum is no limit of one
        return []
    ((followed, slope),) = ratios
    ratio, offset = number(slope), 0.0 if coupling is None else number(coupling.offset)
    if ratio == 0:
        return []
    k = scene.coordinates.index(followed)
    ends = (-number(None) if given.lower is None else number(given.lower), number(given.upper))
    low, high = sorted((end - offset) / ratio for end in ends)
    speed = number(given.velocity) / abs(ratio)
    found = [(scene.coordinates[k], low, high), (scene.velocities[k], -speed, speed)]
    if coupling is None:
        found.append((drive_names(scene)[k], -number(given.effort), number(given.effort)))
    return found


def _asked(
    box: Box, values: Mapping[str, Quantity], units: Mapping[str, str], faults: Faults
) -> list[tuple[str, str, float, float]]:
    """Return place, name, low and high of every entry that can be read."""
    entries: list[tuple[str, object, object]] = []
    if isinstance(box, Mapping):
        for name, pair in box.items():
            try:
                low, high = pair
            except (TypeError, ValueError):
                faults.add(f"box: {name}", f"{pair!r:.60} is no pair; give (low, high), None for an end without limit")
                continue
            entries.append((name, low, high))
    else:
        for text in (box,) if isinstance(box, str) else box:
            name, equals, said = (part.strip() for part in str(text).partition("="))
            low, dots, high = (part.strip() for part in said.partition(".."))
            if not (equals and dots and name and (low or high)):
                faults.add("box", f'"{text}" is no box; write name=low..high, such as tool.z=0.1.. or q1=-1..1')
                continue
            entries.append((name, low or None, high or None))
    found = []
    for name, low, high in entries:
        where = f"box: {name}"
        pair, unit = ((low, -math.inf), (high, math.inf)), units.get(name, "")
        ends = [_number(end, usual, where, values, faults, unit) for end, usual in pair]
        if None not in ends:
            found.append((where, name, *ends))
    return found  # type: ignore[return-value]


def _number(
    end: object, usual: float, where: str, values: Mapping[str, Quantity], faults: Faults, unit: str
) -> float | None:
    if end is None:
        return usual
    found = read_number(end, values, where, faults, Parameter("", unit=unit))
    if found is not None and math.isnan(found):
        faults.add(where, "nan is no limit; give a number, or leave the end out")
        return None
    return found


def fits(scene: Scene) -> list[str]:
    """Return why motions of a scene cannot be chosen freely, nothing where they can."""
    if scene.is_constrained:
        return [
            f"{scene.name}: its loops or contacts tie coordinates to each other, and an exciting motion would have to "
            "keep them; excite the mechanism with its loops opened, or give a motion of your own to `identify`"
        ]
    found = []
    for joint in scene.moving:
        if joint.motion is not None:
            found.append(f"joints.{joint.name}: its motion is prescribed; take `motion` away for the time of exciting")
        elif joint.velocities:
            found.append(
                f"joints.{joint.name}: velocities of a {joint.type} joint are no rates of its coordinates, which no "
                "series of time moves one by one; lock it for the time of exciting, locked = true"
            )
        elif len(joint.drives) < len(joint.coordinates) or None in joint.drives:
            found.append(
                f"joints.{joint.name}: without a drive its motion cannot be chosen; give it one, or lock it for the "
                "time of exciting, locked = true"
            )
    return found
