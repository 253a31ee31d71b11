"""What expressions of C, C++, CUDA and OpenCL mean: real numbers, whole numbers, places in arrays."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Union

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Fault, Index, MemoryInputs, Pointer, Rows
from symdyn.verify.written.reading import Cut, ExpectedFunction, Text, Unread
from symdyn.verify.written.syntax import line_of, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

Value = Union[Expr, Index, Pointer, Rows]

MATH = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "fabs": Op.ABS,
    "atan2": Op.ATAN2,
}
"""Of <math.h>."""

OURS = {
    "exp_of": Op.EXP,
    "sign_of": Op.SIGN,
    "symdyn_sign_of_double": Op.SIGN,
    "symdyn_sign_of_float": Op.SIGN,
}
"""Fixed text of the file."""

WHOLE = re.compile(rb"0|[1-9][0-9]*")

TRIGRAPH = re.compile(rb"\?\?[=/'()!<>-]")

EXACT = 2**24
"""Whole numbers below are floats."""


class TakenForCast(Exception):  # noqa: N818  a signal
    """The grammar takes a product in parentheses for a type."""


@dataclass
class File:
    """A file whose functions are read.

    Attributes:
        text: the file.
        functions: definitions by name.
        grammar: of the language.
        cuts: what has been read, by the name of the function.
    """

    text: Text
    functions: Mapping[str, Node]
    grammar: str
    cuts: dict[str, Cut] = field(default_factory=dict)

    @property
    def prefix(self) -> str:
        """How names begin of what a header has for itself."""
        return f"{self.text.stem}_own_"

    def own(self, name: str) -> str:
        """Return what a function of the file's own is called in it."""
        return self.prefix + name if self.prefix + name in self.functions else name

    def within(self, name: str) -> str:
        """Return the name that something of a header's own would have in a source file."""
        return name.removeprefix(self.prefix)

    def __post_init__(self) -> None:
        """Refuse trigraphs: `??/` ends a line that goes on, for some compilers."""
        found = TRIGRAPH.search(self.text.source)
        if found is not None:
            raise Unread(self.text.source.count(b"\n", 0, found.start()) + 1, f"{found[0].decode()} is a trigraph")


@dataclass
class Values:
    """One function that is being read: what its names stand for.

    Attributes:
        file: where it stands.
        wanted: which of the program's functions it is, or a part of.
        names: arguments and what was set; each name is set once.
        again: whether a statement is read a second time, with casts told apart.
    """

    file: File
    wanted: ExpectedFunction
    names: dict[str, Value]
    again: bool = False

    def real(self, node: Node) -> Expr:
        """Return the real number that an expression is."""
        return self._converted(node, self.value(node))

    def _converted(self, node: Node, value: Value) -> Expr:
        """Return a value as a real number, into which whole numbers turn exactly."""
        if isinstance(value, Expr):
            return value
        if isinstance(value, Index) and value.plain and abs(value.units) < EXACT:
            return self.file.text.graph.constant(value.units)
        raise unread(node, "is no real number")

    def whole(self, node: Node) -> int:
        """Return the whole number that an expression is."""
        value = self.value(node)
        if not (isinstance(value, Index) and value.plain):
            raise unread(node, "is no whole number")
        return value.units

    def value(self, node: Node) -> Value:
        """Return what an expression is."""
        meaning = MEANINGS.get(node.type)
        if meaning is None:
            raise unread(node, "is no expression that is read here")
        try:
            return meaning(self, node)
        except Fault as fault:
            raise unread(node, str(fault)) from None

    def function_of(self, name: str) -> Op | None:
        """Return which operation a function is, None if none."""
        if name in self.file.functions:  # nothing of the C library then
            return OURS.get(self.file.within(name))
        if self.file.text.real == "float":
            return MATH.get(name[:-1]) if name.endswith("f") else None
        return MATH.get(name)

    def subscript(self, node: Node) -> tuple[Value, Index]:
        """Return the array and the index of `x[i]`."""
        base, *rest = node.children
        if len(rest) == 1 and rest[0].type == "subscript_argument_list":  # of C++
            rest = rest[0].children
        if len(rest) != 3 or [rest[0].type, rest[2].type] != ["[", "]"]:
            raise unread(node, "is no entry of an array")
        index = self.value(rest[1])
        if not isinstance(index, Index):
            raise unread(rest[1], "is no index")
        return self.value(base), index

    def arguments(self, node: Node) -> list[Node]:
        """Return what a call gives."""
        listed = node.children[-1]
        kinds = [one.type for one in listed.children]
        if listed.type != "argument_list" or kinds[0] != "(" or kinds[-1] != ")":
            raise unread(node, "is no call that is read here")
        if kinds[2:-1:2] != [","] * (len(kinds[1:-1]) // 2):
            raise unread(node, "is no call that is read here")
        return listed.children[1:-1:2]

    def called(self, node: Node) -> Value:
        """Return the value of a call."""
        name = node.children[0]
        op = self.function_of(said(name)) if name.type in ("identifier", "qualified_identifier") else None
        given = self.arguments(node)
        if op is None:
            raise unread(node, "is no function that is read here")
        if len(given) != op.arity:
            raise unread(node, "has another number of arguments")
        return self.file.text.graph.function(op, *(self.real(one) for one in given))

    def decimal(self, node: Node, digits: str) -> Expr:
        """Return the number that a literal is, without its sign."""
        if self.file.text.real == "float":
            if not digits.endswith("f"):
                raise unread(node, "is no float")
            digits = digits[:-1]
        return self.exactly(node, digits)

    def exactly(self, node: Node, digits: str) -> Expr:
        """Return the number of the type that digits with a point or an exponent are read as."""
        if digits.isdigit():
            raise unread(node, "is no decimal number")
        return self.file.text.number(digits, line_of(node))

    def number(self, node: Node) -> Value:
        """Return a literal: a whole number, or a real one."""
        source = node.text or b""
        if WHOLE.fullmatch(source):
            return Index(int(source))
        digits = source.decode("ascii", "replace")
        size = self.decimal(node, digits.lstrip("-+"))  # the grammar takes a sign along
        return self.file.text.negative(size, line_of(node)) if digits[0] == "-" else size

    def name(self, node: Node) -> Value:
        """Return what a name stands for."""
        name = said(node)
        if name not in self.names:
            raise unread(node, "has no value yet")
        return self.names[name]

    def inner(self, node: Node) -> Value:
        """Return what is in parentheses."""
        if [one.type for one in node.children[::2]] != ["(", ")"]:
            raise unread(node, "is no expression that is read here")
        return self.value(node.children[1])

    def signed(self, node: Node) -> Value:
        """Return what a sign makes of a real number."""
        operator, operand = node.children
        if operator.type == "+":
            return self.real(operand)
        if operator.type != "-":
            raise unread(node, "is no sign of a real number")
        return self.file.text.negative(self.real(operand), line_of(node))

    def address(self, node: Node) -> Value:
        """Return the address of a number."""
        operator, operand = node.children
        value = self.value(operand)
        if operator.type != "&" or not isinstance(value, Expr) or operand.type != "identifier":
            raise unread(node, "is not the address of a number")
        return Pointer(MemoryInputs(said(operand), (value,)))

    def binary(self, node: Node) -> Value:
        """Return what an operator makes of two operands."""
        if len(node.children) != 3:
            raise unread(node, "is no expression that is read here")
        left, operator, right = node.children
        a, b = self.value(left), self.value(right)
        if isinstance(a, Index) and isinstance(b, Index):
            if operator.type in WHOLE_OPERATIONS:
                return WHOLE_OPERATIONS[operator.type](a, b)
            raise unread(node, "is no sum or product of whole numbers")
        if isinstance(a, Pointer) and isinstance(b, Index) and operator.type == "+":
            return a.plus(b)
        if operator.type not in OPERATIONS:
            raise unread(operator, "is no operation of real numbers")
        try:
            return OPERATIONS[operator.type](self._converted(left, a), self._converted(right, b))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def entry(self, node: Node) -> Value:
        """Return an entry of an array, or a row."""
        base, index = self.subscript(node)
        if isinstance(base, Rows):
            return base.row(index)
        if not isinstance(base, Pointer):
            raise unread(node, "is no entry of an array")
        return base.load(index)

    def cast(self, node: Node) -> Value:
        """Refuse a cast, unless it may be a product."""
        if not self.again:
            raise TakenForCast
        raise unread(node, "is no expression that is read here")


WHOLE_OPERATIONS: Mapping[str, Callable[[Index, Index], Index]] = {"+": Index.__add__, "*": Index.__mul__}
OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}
MEANINGS: Mapping[str, Callable[[Values, Node], Value]] = {  # by node type; late, since languages differ
    "identifier": lambda values, node: values.name(node),
    "number_literal": lambda values, node: values.number(node),
    "parenthesized_expression": lambda values, node: values.inner(node),
    "unary_expression": lambda values, node: values.signed(node),
    "binary_expression": lambda values, node: values.binary(node),
    "call_expression": lambda values, node: values.called(node),
    "subscript_expression": lambda values, node: values.entry(node),
    "pointer_expression": lambda values, node: values.address(node),
    "cast_expression": lambda values, node: values.cast(node),
}
