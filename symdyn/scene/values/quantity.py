"""Quantities: what a user may write wherever a scene wants a number.

A quantity is an exact formula: a fraction, π, a named parameter, or an operation on quantities. It is a small frozen
tree with no graph behind it, so that two scenes compare equal when they say the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

from symdyn.graph import Expr, Graph, Op, arithmetic


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

    def __neg__(self) -> Quantity:
        return self if self == ZERO else Quantity(Op.NEG, (self,))

    def __mul__(self, other: Quantity) -> Quantity:
        if ZERO in (self, other):
            return ZERO
        return other if self == ONE else self if other == ONE else Quantity(Op.MUL, (self, other))

    def __add__(self, other: Quantity) -> Quantity:
        return other if self == ZERO else self if other == ZERO else Quantity(Op.ADD, (self, other))

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


def number(value: Fraction | int) -> Quantity:
    """Return an exact constant."""
    return Quantity(Op.CONSTANT, (), value if type(value) is Fraction else Fraction(value))


def symbol(name: str) -> Quantity:
    """Return a named parameter, coordinate or velocity."""
    return Quantity(Op.SYMBOL, (), name)


ZERO = number(0)
ONE = number(1)
PI = Quantity(Op.PI)

Vector = tuple[Quantity, Quantity, Quantity]

NULL: Vector = (ZERO, ZERO, ZERO)
