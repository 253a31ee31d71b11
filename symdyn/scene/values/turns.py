"""Turns: which multiples of π an angle is, what brings the z axis to a direction, and where a placement leads."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.body import Pose
from symdyn.scene.values.quantity import NULL, Quantity, Vector

Step = tuple[str, Quantity]

RIGHT = folding.mul(Quantity.number(Fraction(1, 2)), Quantity.PI)


def turns(angle: Quantity) -> Fraction | None:
    """Return k of an angle k π, None for any other angle."""
    if angle == Quantity.ZERO:
        return Fraction(0)
    if angle == Quantity.PI:
        return Fraction(1)
    if angle.op is Op.NEG:
        inner = turns(angle.args[0])
        return None if inner is None else -inner
    if angle.op is Op.MUL and angle.args[1] == Quantity.PI:
        return folding.fraction(angle.args[0])
    return None


def plus(a: Quantity, b: Quantity) -> Quantity:
    """Return the sum of two angles; multiples of π add up to one."""
    x, y = turns(a), turns(b)
    return folding.add(a, b) if x is None or y is None else folding.mul(Quantity.number(x + y), Quantity.PI)


def quarter_turns(angle: Quantity) -> int | None:
    """Return k of an angle k π/2, modulo four; None for any other angle."""
    found = turns(angle)
    return int(found * 2) % 4 if found is not None and (found * 2).denominator == 1 else None


def inverse(steps: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps that undo a placement."""
    return tuple((kind, folding.neg(amount)) for kind, amount in reversed(steps))


def towards(axis: Vector) -> tuple[Step, ...]:
    """Return a rotation that takes z to the direction of an axis of any length, free of symbols."""
    x, y, z = axis
    if x == Quantity.ZERO and y == Quantity.ZERO:
        return (("Rx", Quantity.PI),) if _negative(z) else ()
    if y == Quantity.ZERO and z == Quantity.ZERO:
        return (("Ry", folding.neg(RIGHT) if _negative(x) else RIGHT),)
    if x == Quantity.ZERO and z == Quantity.ZERO:
        return (("Rx", RIGHT if _negative(y) else folding.neg(RIGHT)),)
    across = folding.power(folding.add(folding.mul(x, x), folding.mul(y, y)), Fraction(1, 2))
    return (("Rz", folding.function(Op.ATAN2, y, x)), ("Ry", folding.function(Op.ATAN2, across, z)))


def _negative(x: Quantity) -> bool:
    value = x.at({})
    assert value is not None, "an axis is free of symbols"
    return value < 0


def circular(op: Op, angle: Quantity) -> Quantity:
    """Return sin or cos (the operation) of an angle, as a number where it is rational."""
    value = folding.function(op, angle).express(Graph())
    return Quantity.number(value.value) if value.op is Op.CONSTANT else folding.function(op, angle)  # type: ignore[arg-type]


def cosine_and_sine(angle: Quantity) -> tuple[Quantity, Quantity]:
    """Return cosine and sine of an angle, whole numbers at right angles."""
    k = quarter_turns(angle)
    if k is None:
        return folding.function(Op.COS, angle), folding.function(Op.SIN, angle)
    return Quantity.number((1, 0, -1, 0)[k]), Quantity.number((0, 1, 0, -1)[k])


def translation(pose: Pose) -> Vector:
    """Return where a placement puts the origin, m."""
    r = list(NULL)
    for kind, amount in reversed(pose.steps):
        k = "xyz".index(kind[1])
        if kind[0] == "T":
            r[k] = folding.add(r[k], amount)
            continue
        i, j = (k + 1) % 3, (k + 2) % 3
        if r[i] == r[j] == Quantity.ZERO:
            continue
        c, s = cosine_and_sine(amount)
        r[i], r[j] = (
            folding.add(folding.mul(c, r[i]), folding.neg(folding.mul(s, r[j]))),
            folding.add(folding.mul(s, r[i]), folding.mul(c, r[j])),
        )
    return (r[0], r[1], r[2])
