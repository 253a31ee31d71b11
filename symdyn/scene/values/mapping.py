"""The same scene with other quantities: a change applied to every formula that it holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from symdyn.graph import Op, arithmetic
from symdyn.scene.values import folding
from symdyn.scene.values.quantity import Quantity

T = TypeVar("T")

_FOLDED = arithmetic(folding)


def map_quantities(thing: T, change: Callable[[Quantity], Quantity]) -> T:
    """Return `thing`, a noun of the scene or a tuple of them, with `change` applied to every quantity inside."""
    return _mapped(thing, change)  # type: ignore[no-any-return]


def _mapped(thing: Any, change: Callable[[Quantity], Quantity]) -> Any:
    if isinstance(thing, Quantity):
        return change(thing)
    if isinstance(thing, tuple):
        return tuple(_mapped(part, change) for part in thing)
    if is_dataclass(thing) and not isinstance(thing, type):
        return replace(thing, **{field.name: _mapped(getattr(thing, field.name), change) for field in fields(thing)})
    return thing


def substituted(quantity: Quantity, values: Mapping[str, Quantity]) -> Quantity:
    """Return the formula with quantities in place of symbols, folded again.

    Raises:
        FormulaError: it divides by what is now zero, or takes a root or logarithm that no longer exists.
    """
    if quantity.op is Op.SYMBOL:
        return values.get(str(quantity.value), quantity)
    if not quantity.args:
        return quantity
    args = [substituted(arg, values) for arg in quantity.args]
    if all(new is old for new, old in zip(args, quantity.args, strict=True)):
        return quantity
    operation = _FOLDED.get(quantity.op)
    return operation(*args) if operation else folding.function(quantity.op, *args)
