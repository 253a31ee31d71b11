"""Quantities: what a user may write wherever a scene wants a number.

A quantity is an exact formula: a fraction, π, a named parameter, or an operation on quantities. It is a small frozen
tree with no graph behind it, so that two scenes compare equal when they say the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar

from symdyn.graph import Expr, Graph, Op, arithmetic

Value = Fraction | float


@dataclass(frozen=True)
class Quantity:
    """A node of a formula.

    Attributes:
        op: what the node computes.
        args: its operands.
        value: the fraction of a constant, the name of a symbol, else None.
        unit: in which its writer gave a number, such as "mm"; the quantity itself is in SI, and equals the same in
            another.
    """

    op: Op
    args: tuple[Quantity, ...] = ()
    value: Fraction | str | None = None
    unit: str = field(default="", compare=False, repr=False)

    ZERO: ClassVar[Quantity]
    ONE: ClassVar[Quantity]
    PI: ClassVar[Quantity]

    @staticmethod
    def number(value: Fraction | int) -> Quantity:
        """Return an exact constant."""
        return Quantity(Op.CONSTANT, (), value if type(value) is Fraction else Fraction(value))

    @staticmethod
    def symbol(name: str) -> Quantity:
        """Return a named parameter, coordinate or velocity."""
        return Quantity(Op.SYMBOL, (), name)

    def __neg__(self) -> Quantity:
        return self if self == Quantity.ZERO else Quantity(Op.NEG, (self,))

    def __mul__(self, other: Quantity) -> Quantity:
        if Quantity.ZERO in (self, other):
            return Quantity.ZERO
        return other if self == Quantity.ONE else self if other == Quantity.ONE else Quantity(Op.MUL, (self, other))

    def __add__(self, other: Quantity) -> Quantity:
        return other if self == Quantity.ZERO else self if other == Quantity.ZERO else Quantity(Op.ADD, (self, other))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the symbols in the formula, in order of appearance."""
        names = {str(self.value): None} if self.op is Op.SYMBOL else {}
        for arg in self.args:
            names.update(dict.fromkeys(arg.symbols))
        return tuple(names)

    def express(self, graph: Graph) -> Expr:
        """Return the quantity as a node of `graph`; symbols keep their names.

        Raises:
            ZeroDivisionError: the formula divides by a constant zero.
        """
        if self.op is Op.CONSTANT:
            assert isinstance(self.value, Fraction)
            return graph.constant(self.value)
        if self.op is Op.SYMBOL:
            return graph.symbol(str(self.value))
        if self.op is Op.PI:
            return graph.pi
        args = [arg.express(graph) for arg in self.args]
        if self.op.is_function:
            return graph.function(self.op, *args)
        return arithmetic(graph)[self.op](*args)  # type: ignore[no-any-return]

    def at(self, values: Mapping[str, Value]) -> Value | None:
        """Return its value, exact where it is rational; None when one of its symbols has no value.

        Raises:
            FormulaError: it divides by zero, has no real value, or is beyond the largest double.
        """
        from symdyn.scene.values.value import value_of

        return value_of(self, values)

    def known_at(self, values: Mapping[str, Value]) -> Value | None:
        """Return its value, None where it is not known, or does not exist, which is reported apart."""
        from symdyn.scene.values.folding import FormulaError

        try:
            return self.at(values)
        except FormulaError:
            return None

    def substituted(self, values: Mapping[str, Quantity]) -> Quantity:
        """Return the formula with quantities in place of symbols, folded again.

        Raises:
            FormulaError: it divides by what is now zero, or takes a root or logarithm that no longer exists.
        """
        if self.op is Op.SYMBOL:
            return values.get(str(self.value), self)
        args = tuple(arg.substituted(values) for arg in self.args)
        if all(new is old for new, old in zip(args, self.args, strict=True)):
            return self
        from symdyn.scene.values.folding import folded

        return folded(self.op, args)


Quantity.ZERO, Quantity.ONE, Quantity.PI = Quantity.number(0), Quantity.number(1), Quantity(Op.PI)

Vector = tuple[Quantity, Quantity, Quantity]

NULL: Vector = (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
