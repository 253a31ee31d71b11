"""Bodies that are welded together are one body to the equations: an inertia is judged when all of that body is there.

    c, R    centre of mass of a part and its axes, in the frame of the body that all hang on
    C       centre of mass of all           d = c - C
    I       inertia of all about C = sum of R I_part Rᵀ + m (d·d 1 - d dᵀ)

Robot files are full of links of no mass to speak of, whose numbers mean nothing and which a fixed joint holds to a link
that has both. What is welded to the ground moves nowhere, and no equation holds its inertia.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from symdyn.graph import Op
from symdyn.scene.checks.draft import Draft
from symdyn.scene.values.body import Body, Pose
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.model import Scene
from symdyn.scene.values.names import listed
from symdyn.scene.values.physical import central_inertia, impossible, inertia_fault
from symdyn.scene.values.quantity import FormulaError, Quantity, Value
from symdyn.scene.values.turns import circular

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
