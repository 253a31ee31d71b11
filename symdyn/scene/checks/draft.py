"""A scene that is not yet checked, and every quantity that it holds, with its place and with what it may name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values.body import Body, Pose
from symdyn.scene.values.joint import Joint, Limits
from symdyn.scene.values.key import MOTION, PARAMETERS, TIME
from symdyn.scene.values.model import Scene
from symdyn.scene.values.quantity import Quantity
from symdyn.scene.values.signals import letters

CLOCK = "t"
"""Name of the time in formulas."""

KINDS = ("parameters", "bodies", "joints", "loops", "points", "elements", "inputs", "outputs")


@dataclass(frozen=True)
class Draft:
    """A scene in declared order, not yet checked; bodies and joints need not belong together.

    Attributes:
        scene: what was declared.
        where: for each of `KINDS` the places of its entries, for messages.
    """

    scene: Scene
    where: Mapping[str, tuple[str, ...]]


class Use(NamedTuple):
    """A quantity of the scene, where it stands, and what it may name beside parameters."""

    where: str
    key: str
    quantity: Quantity
    allowed: frozenset[str] = frozenset()


def uses(draft: Draft) -> Iterator[Use]:
    """Return every quantity but parameter values and directions, in declared order."""
    scene, where = draft.scene, draft.where
    moving = frozenset((*scene.coordinates, *scene.velocities))
    timed = moving | {CLOCK, *(one.name for one in scene.inputs)}
    yield from _vector("", "gravity", scene.gravity)
    for place, body in zip(where["bodies"], scene.bodies, strict=True):
        yield from _body(place, body)
    for place, joint in zip(where["joints"], scene.joints, strict=True):
        yield from _joint(place, joint, timed)
    for place, joint in zip(where["loops"], scene.loops, strict=True):
        yield from _joint(place, joint, timed)
    for place, point in zip(where["points"], scene.points, strict=True):
        yield from _steps(place, "at", point.at)
    allowed = {PARAMETERS: frozenset[str](), MOTION: moving, TIME: timed}
    for place, one in zip(where["elements"], scene.elements, strict=True):
        for part in FORCES[one.kind].parts:
            yield from (Use(place, key, quantity, allowed[names]) for key, quantity, names in part.numbers(one))
    for place, output in zip(where["outputs"], scene.outputs, strict=True):
        yield Use(place, "formula", output.formula, frozenset(letters(scene, output.formula.symbols)))


def joint_numbers(joint: Joint) -> Iterator[tuple[str, Quantity]]:
    """Return what a joint says in numbers and parameters beside its placement, by key."""
    if joint.coupling is not None:
        yield from (("mimic.ratio", joint.coupling.ratio), ("mimic.offset", joint.coupling.offset))
    yield from (("armature", joint.armature), ("damping", joint.damping), ("friction", joint.friction))
    for part in FORCES[joint.dry.kind].parts if joint.dry else ():
        yield from ((f"friction.{name}", quantity) for name, quantity, _ in part.numbers(joint.dry))
    for field in fields(Limits):
        quantity = getattr(joint.limits, field.name)
        if quantity is not None:
            yield f"limits.{field.name}", quantity
    yield from ((name, x) for key in JOINTS[joint.type].keys for name, x, _ in key.numbers(joint))
    yield from ((f"start[{k}]", x) for k, x in enumerate(joint.start))
    yield from ((f"start_rates[{k}]", x) for k, x in enumerate(joint.start_rates))


def _body(where: str, body: Body) -> Iterator[Use]:
    yield Use(where, "mass", body.mass)
    for key, vector in (("com", body.com), ("first_moment", body.first_moment), ("inertia", body.inertia)):
        yield from _vector(where, key, vector or ())
    for k, particle in enumerate(body.particles):
        yield Use(where, f"particles[{k}].mass", particle.mass)
        yield from _vector(where, f"particles[{k}].at", particle.at)
    yield from (Use(where, f"shape.{name}", size) for name, size in (body.shape.sizes if body.shape else ()))
    yield from _vector(where, "shape.axis", (body.shape and body.shape.axis) or ())


def _joint(where: str, joint: Joint, timed: frozenset[str]) -> Iterator[Use]:
    yield from _steps(where, "origin", joint.origin)
    yield from _steps(where, "tip", joint.tip)
    for key, value in JOINTS[joint.type].values(joint):
        if isinstance(value, Pose):
            yield from _steps(where, key.name, value, frozenset(joint.coordinates))
    for k, force in enumerate(joint.forces):
        yield Use(where, "force" if len(joint.forces) == 1 else f"forces[{k}]", force, timed)
    if joint.motion is not None:
        yield Use(where, "motion", joint.motion, frozenset((CLOCK,)))
    yield from (Use(where, key, quantity) for key, quantity in joint_numbers(joint))


def _vector(where: str, key: str, entries: Sequence[Quantity], allowed: frozenset[str] = frozenset()) -> Iterator[Use]:
    yield from (Use(where, f"{key}[{i}]", x, allowed) for i, x in enumerate(entries))


def _steps(where: str, key: str, pose: Pose, allowed: frozenset[str] = frozenset()) -> Iterator[Use]:
    yield from (Use(where, f"{key}.{kind}", amount, allowed) for kind, amount in pose.steps)
