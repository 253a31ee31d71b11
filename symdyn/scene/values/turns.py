"""Turns: which multiples of π an angle is, and the rotation that brings the z axis to a direction."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from symdyn.graph import Graph, Op
from symdyn.scene.values import folding
from symdyn.scene.values.quantity import PI, ZERO, Quantity, Vector, express, number
from symdyn.scene.values.value import value_of

Step = tuple[str, Quantity]

RIGHT = folding.mul(number(Fraction(1, 2)), PI)


def turns(angle: Quantity) -> Fraction | None:
    """Return k of an angle k π, None for any other angle."""
    if angle == ZERO:
        return Fraction(0)
    if angle == PI:
        return Fraction(1)
    if angle.op is Op.NEG:
        inner = turns(angle.args[0])
        return None if inner is None else -inner
    if angle.op is Op.MUL and angle.args[1] == PI:
        return folding.fraction(angle.args[0])
    return None


def plus(a: Quantity, b: Quantity) -> Quantity:
    """Return the sum of two angles; multiples of π add up to one."""
    x, y = turns(a), turns(b)
    return folding.add(a, b) if x is None or y is None else folding.mul(number(x + y), PI)


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
    if x == ZERO and y == ZERO:
        return (("Rx", PI),) if _negative(z) else ()
    if y == ZERO and z == ZERO:
        return (("Ry", folding.neg(RIGHT) if _negative(x) else RIGHT),)
    if x == ZERO and z == ZERO:
        return (("Rx", RIGHT if _negative(y) else folding.neg(RIGHT)),)
    across = folding.power(folding.add(folding.mul(x, x), folding.mul(y, y)), Fraction(1, 2))
    return (("Rz", folding.function(Op.ATAN2, y, x)), ("Ry", folding.function(Op.ATAN2, across, z)))


def _negative(x: Quantity) -> bool:
    value = value_of(x, {})
    assert value is not None, "an axis is free of symbols"
    return value < 0


def circular(op: Op, angle: Quantity) -> Quantity:
    """Return sin or cos (the operation) of an angle, as a number where it is rational."""
    value = express(folding.function(op, angle), Graph())
    return number(value.value) if value.op is Op.CONSTANT else folding.function(op, angle)  # type: ignore[arg-type]
