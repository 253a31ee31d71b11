"""A scene that is not yet checked, and every quantity that it holds, with its place and with what it may name.

Bodies that are welded together are one body to the equations: an inertia is judged when all of that body is there.

    c, R    centre of mass of a part and its axes, in the frame of the body that all hang on
    C       centre of mass of all           d = c - C
    I       inertia of all about C = sum of R I_part Rᵀ + m (d·d 1 - d dᵀ)

Robot files are full of links of no mass to speak of, whose numbers mean nothing and which a fixed joint holds to a link
that has both. What is welded to the ground moves nowhere, and no equation holds its inertia.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from symdyn.errors import listed
from symdyn.frozen import dataclass
from symdyn.graph import Op
from symdyn.scene.declaration.scene_table import BODY, GRAVITY, POINT
from symdyn.scene.declaration.states import STATE
from symdyn.scene.forces.force_table import FORCES, place_of
from symdyn.scene.joints.joint_table import JOINTS, ORIGIN, RESISTING, TIP
from symdyn.scene.values.body import Body, Pose, central_inertia, circular, impossible, inertia_fault
from symdyn.scene.values.dimension import force_unit
from symdyn.scene.values.grammar import CLOCK
from symdyn.scene.values.joint import Element, Joint, Strut
from symdyn.scene.values.key import LED, MOTION, OWN, PARAMETERS, PLACED, STATED, TIMED, Part
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import FormulaError, Quantity, Value

KINDS = (
    "parameters",
    "bodies",
    "joints",
    "loops",
    "points",
    "elements",
    "inputs",
    "outputs",
    "derived",
    "states",
    "signals",
)


@dataclass(frozen=True)
class Draft:
    """A scene in declared order, not yet checked; bodies and joints need not belong together.

    Attributes:
        scene: what was declared.
        where: for each of `KINDS` the places of its entries, for messages.
    """

    scene: Scene
    where: Mapping[str, tuple[str, ...]]


def draft_of(scene: Scene) -> Draft:
    """Return a scene that was checked before as a draft, its entries where their names say."""
    places = {kind: tuple(f"{kind}.{one.name}" for one in getattr(scene, kind)) for kind in KINDS}
    places |= {"derived": tuple(f"parameters.{one.name}" for one in scene.derived)}
    return Draft(scene, places | {"elements": tuple(map(place_of, scene.elements))})


class Use(NamedTuple):
    """A quantity of the scene, where it stands, what it may name beside parameters, and its unit of SI or "".

    Of a number of a joint that both slides and turns there is an `other` unit: it acts along, in the one, and about, in
    the other one.
    """

    where: str
    key: str
    quantity: Quantity
    allowed: frozenset[str] = frozenset()
    unit: str = ""
    other: str = ""


def uses(draft: Draft) -> Iterator[Use]:
    """Return every quantity but parameter values and directions, in declared order."""
    scene, where = draft.scene, draft.where
    moving = frozenset((*scene.coordinates, *scene.velocities))
    timed = moving | {CLOCK, *(one.name for one in scene.given)}
    states = frozenset(one.name for one in scene.states)
    allowed = {PARAMETERS: frozenset[str](), MOTION: moving, TIMED: timed, STATED: states}
    allowed[PLACED] = frozenset((CLOCK, *scene.rates))
    allowed[LED] = frozenset((CLOCK, *(name for name, rate in scene.rates.items() if rate in scene.rates)))
    yield from _uses("", (GRAVITY,), scene, allowed)
    for place, body in zip(where["bodies"], scene.bodies, strict=True):
        yield from _uses(place, BODY, body, allowed)
    led = {q: way for one in scene.joints if scene.followed.intersection(one.coordinates) for q, way in _ways(one)}
    for place, joint in zip(where["joints"], scene.joints, strict=True):
        yield from _joint(place, joint, allowed, led)
    for place, joint in zip(where["loops"], scene.loops, strict=True):
        yield from _joint(place, joint, allowed)
    for place, point in zip(where["points"], scene.points, strict=True):
        yield from _uses(place, POINT, point, allowed)
    for place, one in zip(where["elements"], scene.elements, strict=True):
        yield from _uses(place, FORCES[one.kind].parts, one, allowed, slides(scene, one))
    for place, output in zip(where["outputs"], scene.outputs, strict=True):
        yield Use(place, "formula", output.formula, frozenset(scene.formula_names(output.formula.symbols)), output.unit)
    for place, state in zip(where["states"], scene.states, strict=True):
        units = {"rate": state.rate_unit, "start": state.unit, "reset.to": state.unit}
        yield from (use._replace(unit=units.get(use.key, "")) for use in _uses(place, STATE, state, allowed))
    for place, signal in zip(where["signals"], scene.signals, strict=True):
        yield Use(place, "formula", signal.formula, timed, signal.unit)
    for place, parameter in zip(where["derived"], scene.derived, strict=True):
        if parameter.value is not None:
            yield Use(place, "value", parameter.value, unit=parameter.unit)


def _uses(
    where: str, parts: Iterable[Part], one: object, allowed: Mapping[int, frozenset[str]], straight: bool = True
) -> Iterator[Use]:
    """Return the quantities of a noun, whose parts say what each may name, and its unit."""
    for part in parts:
        for key, quantity, names, unit in part.numbers(one, straight):
            yield Use(where, key, quantity, allowed[names], unit)


def slides(scene: Scene, one: Element) -> bool:
    """Tell whether what an element pulls along is in m, as between two points or at a joint that slides."""
    named = next((joint for joint in scene.joints if isinstance(one, Strut) and joint.name == one.joint), None)
    return named is None or JOINTS[named.type].slides(named)


def _ways(joint: Joint) -> Iterator[tuple[str, str]]:
    """Return the unit of each coordinate of a joint."""
    return zip(joint.coordinates, JOINTS[joint.type].coordinates(joint), strict=False)


def _numbers(where: str, joint: Joint, led: Mapping[str, str] = MappingProxyType({})) -> Iterator[Use]:
    """Return what a joint says in numbers; `led` has the units of coordinates that others follow."""
    kind = JOINTS[joint.type]
    if set(kind.velocities(joint)) == {"m", "rad"}:
        for one, other in zip(*(_numbers_of(where, joint, led, straight) for straight in (False, True)), strict=True):
            yield one if one.unit == other.unit else one._replace(other=other.unit)
    else:
        yield from _numbers_of(where, joint, led, kind.slides(joint))


def _numbers_of(where: str, joint: Joint, led: Mapping[str, str], straight: bool) -> Iterator[Use]:
    """Return what a joint says in numbers, as of one that only slides or only turns."""
    kind = JOINTS[joint.type]
    places, speeds = kind.coordinates(joint), kind.velocities(joint)
    way = "m" if straight else "rad"
    plain = frozenset[str]()
    if joint.coupling is not None:
        for name, ratio in joint.coupling.ratios:
            leading = led.get(name, "")
            unit = "1" if leading == way else f"{way}/{leading}" if leading else ""
            key = "mimic.ratio" if len(joint.coupling.ratios) == 1 else f"mimic.ratios.{name}"
            yield Use(where, key, ratio, plain, unit)
        yield Use(where, "mimic.offset", joint.coupling.offset, plain, way)
    allowed = {PARAMETERS: plain, OWN: frozenset(joint.coordinates)}
    yield from _uses(where, (*RESISTING, *kind.keys), joint, allowed, straight)
    for use in _uses(where, FORCES[joint.dry.kind].parts, joint.dry, allowed, straight) if joint.dry else ():
        yield use._replace(key=f"friction.{use.key}")
    rates = [f"{unit}/s" for unit in speeds]
    for key, values, units in ("start", joint.start, places), ("start_rates", joint.start_rates, rates):
        for k, x in enumerate(values):
            yield Use(where, f"{key}[{k}]" if values[1:] else key, x, plain, "".join(units[k : k + 1]))


def _joint(
    where: str, joint: Joint, allowed: Mapping[int, frozenset[str]], led: Mapping[str, str] = MappingProxyType({})
) -> Iterator[Use]:
    yield from _uses(where, (ORIGIN, TIP), joint, allowed)
    speeds = JOINTS[joint.type].velocities(joint)
    for k, force in enumerate(joint.forces):
        unit = "".join(map(force_unit, speeds[k : k + 1]))
        yield Use(where, "force" if len(joint.forces) == 1 else f"forces[{k}]", force, allowed[TIMED], unit)
    if joint.motion is not None:
        yield Use(where, "motion", joint.motion, allowed[LED], "".join(speeds[:1]))
    yield from _numbers(where, joint, led)


WELD = "fixed"
"""The type of a joint that holds two bodies together."""


class Judged(NamedTuple):
    """A body whose inertia no body has: where it stands, why, what would mend it, and whether it is read as it is."""

    where: str
    name: str
    why: str
    advice: str
    fine: bool


Welds = Mapping[str, Sequence[tuple[str, Joint]]]
"""The bodies that hang together, by body: each that a fixed joint ties to it, and that joint."""


def judge(draft: Draft, values: Mapping[str, Value]) -> Iterator[Judged]:
    """Yield the bodies whose inertia no body has, each judged with all that is welded to it."""
    scene = draft.scene
    alone = {body.name: inertia_fault(body, values) for body in scene.bodies if not body.allow_invalid_inertia}
    if not any(alone.values()):
        return
    welds: dict[str, list[tuple[str, Joint]]] = {}
    for joint in scene.joints:
        if joint.type == WELD:
            welds.setdefault(joint.parent, []).append((joint.child, joint))
            welds.setdefault(joint.child, []).append((joint.parent, joint))
    verdicts: dict[str, tuple[tuple[str, ...], str | None]] = {}
    for where, body in zip(draft.where["bodies"], scene.bodies, strict=True):
        fault = alone.get(body.name)
        if fault is None:
            continue
        why, advice = fault
        if body.name not in verdicts:
            names = tuple(_welded(welds, body.name))
            condition = None if Scene.GROUND in names else _together(scene, welds, names, values) if names[1:] else why
            verdicts.update(dict.fromkeys(names, (names, condition)))
        names, condition = verdicts[body.name]
        others = listed((name for name in names if name != body.name), 4)
        if Scene.GROUND in names:
            why += "; it is welded to the ground, and enters no equation"
        elif names[1:]:
            why += f"; with {others}, to which it is welded, it makes "
            why += "a body that can be" if condition is None else f"none either: {condition}"
        yield Judged(where, body.name, why, advice, condition is None)


def _welded(welds: Welds, name: str) -> dict[str, None]:
    """Return the bodies that welds tie to one, itself the first; the ground may be among them."""
    found = {name: None}
    waiting = [name]
    while waiting:
        for other, _ in welds.get(waiting.pop(), ()):
            if other not in found:
                found[other] = None
                waiting.append(other)
    return found


def _together(scene: Scene, welds: Welds, names: Collection[str], values: Mapping[str, Value]) -> str | None:
    """Return the condition that bodies break which are welded together, None where they make one that can be."""
    import numpy as np

    try:
        frames = _frames(welds, next(iter(names)), values)
        parts = [
            (mass, frame[:3, :3] @ centre + frame[:3, 3], frame[:3, :3] @ inertia @ frame[:3, :3].T)
            for body in scene.bodies
            if (frame := frames.get(body.name)) is not None
            for mass, centre, inertia in _parts(body, values)
        ]
    except (FormulaError, ZeroDivisionError, OverflowError):
        return "not all of its numbers have values"
    with np.errstate(over="ignore", invalid="ignore"):  # `impossible` tells
        total = sum(mass for mass, _, _ in parts)
        middle = sum((mass * centre for mass, centre, _ in parts), start=np.zeros(3)) / (total or 1.0)
        whole = np.zeros((3, 3))
        for mass, centre, inertia in parts:
            arm = centre - middle
            whole = whole + inertia + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        return impossible(((whole + whole.T) / 2).tolist())


def _frames(welds: Welds, name: str, values: Mapping[str, Value]) -> dict[str, Any]:
    """Return the placements, shape (4, 4), of all that is welded to a body, in its frame."""
    import numpy as np

    frames = {name: np.eye(4)}
    waiting = [name]
    while waiting:
        one = waiting.pop()
        for other, joint in welds.get(one, ()):
            if other not in frames:
                step = _placement(joint.origin, values) @ _placement(joint.tip, values)
                frames[other] = frames[one] @ (step if one == joint.parent else np.linalg.inv(step))
                waiting.append(other)
    return frames


def _placement(pose: Pose, values: Mapping[str, Value]) -> Any:
    """Return a pose as a homogeneous matrix, shape (4, 4)."""
    import numpy as np

    placed = np.eye(4)
    for kind, amount in pose.steps:
        step, axis = np.eye(4), "xyz".index(kind[1])
        if kind[0] == "T":
            step[axis, 3] = _known(amount, values)
        else:
            c, s = (_known(circular(op, amount), values) for op in (Op.COS, Op.SIN))
            j, k = (axis + 1) % 3, (axis + 2) % 3
            step[j, j], step[j, k], step[k, j], step[k, k] = c, -s, s, c
        placed = placed @ step
    return placed


def _parts(body: Body, values: Mapping[str, Value]) -> Iterator[tuple[float, Any, Any]]:
    """Yield mass, centre of mass and inertia about it of the extended part of a body and of its particles."""
    import numpy as np

    matrix, mass = central_inertia(body, values), _known(body.mass, values)
    place = body.com if body.first_moment is None else body.first_moment
    if matrix is None or place is None:
        raise FormulaError("is not known")
    centre = np.array([_known(x, values) for x in place])
    if body.first_moment is not None and mass:
        centre = centre / mass
    yield mass, centre, np.array(matrix, dtype=float)
    for particle in body.particles:
        at = np.array([_known(x, values) for x in particle.at])
        yield _known(particle.mass, values), at, np.zeros((3, 3))


def _known(quantity: Quantity, values: Mapping[str, Value]) -> float:
    value = quantity.at(values)
    if value is None:
        raise FormulaError(f"depends on {', '.join(quantity.symbols)} without a value")
    return float(value)
