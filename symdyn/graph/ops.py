"""The operations a graph is made of, and what each one needs.

One row an operation. Everything that depends on an operation stands in a table keyed by `Op`: its arity here, its
partial derivatives in `differentiate.py`, its value in each algebra, its spelling in each target. A test holds the
tables complete.
"""

from __future__ import annotations

from enum import IntEnum


class Op(IntEnum):
    """What a node computes.

    Loops over nodes have names of their own for members: Python 3.11 takes 100 ns to look one up in its class.
    """

    CONSTANT = 0  # an exact fraction
    PI = 1  # the named constant
    SYMBOL = 2  # a named input
    ADD = 3
    SUB = 4
    MUL = 5
    DIV = 6
    NEG = 7
    SIN = 8
    COS = 9
    SQRT = 10
    EXP = 11
    LOG = 12
    TANH = 13
    ABS = 14
    SIGN = 15
    ATAN2 = 16

    @property
    def arity(self) -> int:
        """How many operands it takes."""
        return ARITY[self]

    @property
    def is_function(self) -> bool:
        """Whether it is no field arithmetic; an algebra answers it in its `function` method."""
        return self in FUNCTIONS

    __hash__ = int.__hash__  # an enumeration's own is a Python function, and tables are read at every node


CONSTANT, PI, SYMBOL, ADD, SUB, MUL, DIV, NEG = list(Op)[:8]
"""Names for loops over nodes of this package."""

ARITY: dict[Op, int] = {
    Op.CONSTANT: 0,
    Op.PI: 0,
    Op.SYMBOL: 0,
    Op.ADD: 2,
    Op.SUB: 2,
    Op.MUL: 2,
    Op.DIV: 2,
    Op.NEG: 1,
    Op.SIN: 1,
    Op.COS: 1,
    Op.SQRT: 1,
    Op.EXP: 1,
    Op.LOG: 1,
    Op.TANH: 1,
    Op.ABS: 1,
    Op.SIGN: 1,
    Op.ATAN2: 2,
}

FUNCTIONS: frozenset[Op] = frozenset(op for op in Op if op >= Op.SIN)
"""Operations that are not field arithmetic; an algebra answers them in its `function` method."""
