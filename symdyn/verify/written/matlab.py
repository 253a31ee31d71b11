"""The meaning of MATLAB as far as generated files go: a function a file, straight lines of rows of numbers.

A variable is a row, a number for each state, so products and quotients are those with a dot; what stands between two
rows without one is a product of matrices, and refused. Arrays begin at 1, and a matrix is stored column by column:
row r of `out` is the entry that `reshape` puts there. `sin` and the like are MATLAB's own unless a variable or a
function of the file has the name; `sqrt_of` and `log_of` are functions of the file, fixed text, which are NaN where
`sqrt` and `log` are complex.

What checks arguments and tells how many states there are, up to the first row that is read, is fixed text too; a name
that it sets is no row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, ReadLanguage, Text, TextReading, Unread
from symdyn.verify.written.syntax import line_of, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

FUNCTIONS = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "abs": Op.ABS,
    "sign": Op.SIGN,
    "atan2": Op.ATAN2,
}
"""MATLAB's own."""

OURS = {"sqrt_of": Op.SQRT, "log_of": Op.LOG}
"""Fixed text of the file."""

ROWWISE: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    ".*": Expr.__mul__,
    "./": Expr.__truediv__,
}
"""Operators that take two rows number by number."""

STATES, COUNTED = "states", "columns_of"
"""How many states there are, and the function of the file that looks at an argument for it."""

ALLOCATING = ("zeros", "sum", "reshape")
"""Functions that fixed text calls after the first row."""

SILENT = ("comment", "line_continuation", "\n")


def read(text: Text) -> TextReading:
    """Return what the first function of a MATLAB file computes; a file of comments alone has none."""
    tops = [node for node in text.root.children if node.type not in SILENT and said(node).strip()]
    if not tops:
        return TextReading((), ())
    strange = next((node for node in tops if node.type != "function_definition"), None)
    if strange is not None:
        raise unread(strange, "is no function")
    names = [_name(node) for node in tops]
    if len({*names}) != len(names):
        raise unread(tops[0], "is followed by two functions of one name")
    wanted = next((one for one in text.wanted if one.name == names[0]), None)
    if wanted is None:
        raise unread(tops[0], "is none of the functions that are wanted")
    return _Function(text, wanted, frozenset(names)).read(tops[0])


def _name(node: Node) -> str:
    name = node.child_by_field_name("name")
    if name is None or name.type != "identifier":
        raise unread(node, "is no plain function")
    return said(name)


def meant(node: Node) -> list[Node]:
    """Return the children of a node that mean something."""
    return [one for one in node.children if one.type not in SILENT and said(one).strip()]


@dataclass
class _Function:
    """A function that is being read: what its names stand for, each set once, and what is known of its result."""

    text: Text
    wanted: ExpectedFunction
    local: frozenset[str]
    names: dict[str, Expr] = field(default_factory=dict)
    entries: dict[int, tuple[Expr, int]] = field(default_factory=dict)
    made: bool = False
    shaped: bool = False

    def read(self, node: Node) -> TextReading:
        """Return what it computes, and which parts of the file that is: those between its fixed text."""
        self._head(node)
        (body,) = (one for one in node.children if one.type == "block")
        parts: list[tuple[int, int]] = []
        going = begun = False
        rest = iter(meant(body))
        for statement in rest:
            if statement.type == "if_statement" and not begun:
                continue
            if statement.type != "assignment":
                raise unread(statement, "is no statement that is read here")
            ended = next(rest, statement)
            if ended.type != ";":
                raise unread(statement, "does not end with a semicolon")
            fixed = not begun and self._counts(statement)
            begun |= not fixed
            if fixed or self._allocates(statement):
                going = False
                continue
            self._assign(statement)
            first = parts.pop()[0] if going else statement.start_byte
            parts.append((first, ended.end_byte))
            going = True
        cuts = (Cut(*part, f"{self.wanted.name} {number}") for number, part in enumerate(parts, 1))
        return TextReading((self._whole(node),), tuple(cuts))

    def _head(self, node: Node) -> None:
        """Look whether it takes and returns what it must."""
        outputs = [one for one in node.children if one.type == "function_output"]
        given = [one for one in node.children if one.type == "function_arguments"]
        if len(outputs) != 1 or [said(one) for one in meant(outputs[0])] != ["out", "="]:
            raise unread(node, "does not return out")
        listed = [said(one) for one in meant(given[0])[1:-1:2]] if given else []
        if listed != [*self.wanted.arguments]:
            raise unread(node, f"takes {', '.join(listed)}, not {', '.join(self.wanted.arguments)}")

    def _counts(self, node: Node) -> bool:
        """Tell whether a statement is one of those that count states, which are fixed text."""
        left, right = self._sides(node)
        if left.type != "identifier" or said(left) != STATES:
            return False
        called = meant(right)[0] if right.type == "function_call" else right
        if said(called) not in ("1", COUNTED) or (said(called) == COUNTED and COUNTED not in self.local):
            raise unread(node, "does not count states")
        return True

    def _assign(self, node: Node) -> None:
        left, right = self._sides(node)
        if left.type == "function_call":
            self._store(left, self.value(right))
        elif left.type != "identifier":
            raise unread(left, "is no name")
        elif self.made:
            raise unread(node, "comes after the result was begun")
        else:
            self._set(left, self.value(right))

    def _sides(self, node: Node) -> tuple[Node, Node]:
        left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
        if left is None or right is None or [one.type for one in meant(node)[1:-1]] != ["="]:
            raise unread(node, "is no assignment that is read here")
        return left, right

    def _allocates(self, node: Node) -> bool:
        """Tell of `out = zeros(rows, states, …)` and `out = reshape(out, n, m, states)`, which stay fixed text."""
        left, right = self._sides(node)
        if left.type != "identifier" or said(left) != "out":
            return False
        words = [said(one) for one in self._arguments(right)] if right.type == "function_call" else []
        called = said(meant(right)[0])
        if called == "zeros" and not self.made and words[:2] == [str(self.wanted.size), STATES]:
            self.made = True
        elif called == "reshape" and self.made and not self.shaped and len(self.wanted.shape) > 1:
            if words != ["out", *map(str, self.wanted.shape), STATES]:
                raise unread(right, f"is not of shape {self.wanted.shape}")
            self.shaped = True
        else:
            raise unread(node, "is no result that is read here")
        if called in self.local:
            raise unread(node, "calls a function of the file")
        return True

    def _store(self, node: Node, value: Expr) -> None:
        """Write a row of the result, `out(3, :) = …`."""
        name, row = self._row(node)
        if name != "out" or not self.made or self.shaped:
            raise unread(node, "is no row of the result")
        if not 1 <= row <= self.wanted.size:
            raise unread(node, f"is row {row} of a result that has {self.wanted.size}")
        if row in self.entries:
            raise unread(node, "is written again")
        self.entries[row] = value, line_of(node)

    def _set(self, node: Node, value: Expr) -> None:
        name = said(node)
        if name in self.names or name in self.wanted.arguments or name == STATES:
            raise unread(node, "has a value already")
        if name in FUNCTIONS or name in self.local or name in ALLOCATING:
            raise unread(node, "hides a function")
        self.names[name] = value

    def _whole(self, node: Node) -> Read:
        """Return all entries row by row, as they stand column by column."""
        missing = [row for row in range(1, self.wanted.size + 1) if row not in self.entries]
        if missing:
            raise Unread(line_of(node), f"{self.wanted.name} never writes row {missing[0]} of the result")
        if not self.made or (len(self.wanted.shape) > 1 and not self.shaped):
            raise Unread(line_of(node), f"{self.wanted.name} returns no result of shape {self.wanted.shape}")
        places = [1 + column_major(place, self.wanted.shape) for place in range(self.wanted.size)]
        entries = tuple(self.entries[row][0] for row in places)
        return Read(self.wanted.name, self.wanted.name, entries, tuple(self.entries[row][1] for row in places))

    # Expressions

    def value(self, node: Node) -> Expr:
        """Return the row that an expression is."""
        if node.type == "identifier":
            if said(node) not in self.names:
                raise unread(node, "has no value yet")
            return self.names[said(node)]
        if node.type == "number":
            return self.text.number(said(node), line_of(node))
        if node.type == "parenthesis":
            inner = meant(node)
            if [one.type for one in (inner[0], inner[-1])] != ["(", ")"] or len(inner) != 3:
                raise unread(node, "is no expression that is read here")
            return self.value(inner[1])
        if node.type == "unary_operator":
            operator, operand = meant(node)
            if operator.type != "-":
                raise unread(node, "is no sign of a row")
            return self.text.negative(self.value(operand), line_of(node))
        if node.type == "binary_operator":
            return self._binary(node)
        if node.type == "function_call":
            return self._called(node)
        raise unread(node, "is no expression that is read here")

    def _binary(self, node: Node) -> Expr:
        left, operator, right = meant(node)
        if operator.type not in ROWWISE:
            raise unread(node, "takes no rows number by number")
        try:
            return ROWWISE[operator.type](self.value(left), self.value(right))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def _called(self, node: Node) -> Expr:
        """Return a row of an argument, or a function of rows: MATLAB writes both alike."""
        name = said(meant(node)[0])
        if name in self.wanted.arguments:
            _, row = self._row(node)
            entries = self.wanted.arguments[name]
            if not 1 <= row <= len(entries):
                raise unread(node, f"is row {row} of {name}, which has {len(entries)}")
            return entries[row - 1]
        op = OURS.get(name) if name in self.local else FUNCTIONS.get(name)
        arguments = self._arguments(node)
        if op is None or name in self.names:
            raise unread(node, "is no function that is read here")
        if len(arguments) != (2 if op is Op.ATAN2 else 1):
            raise unread(node, "has another number of arguments")
        return self.text.graph.function(op, *map(self.value, arguments))

    def _row(self, node: Node) -> tuple[str, int]:
        """Read `name(3, :)`: a row, counted from 1."""
        arguments = self._arguments(node)
        digits = said(arguments[0]) if arguments else ""
        if len(arguments) != 2 or arguments[0].type != "number" or not (digits.isascii() and digits.isdigit()):
            raise unread(node, "is no row of an array")
        if arguments[1].type != "spread_operator":
            raise unread(node, "is no whole row")
        return said(meant(node)[0]), int(digits)

    def _arguments(self, node: Node) -> Sequence[Node]:
        """Return what stands between the parentheses of `name(…)`."""
        inner = meant(node)
        if [one.type for one in inner] == ["identifier", "(", ")"]:
            return []
        if [one.type for one in inner] != ["identifier", "(", "arguments", ")"]:
            raise unread(node, "is no call that is read here")
        listed = meant(inner[2])
        if any(one.type != "," for one in listed[1::2]):
            raise unread(node, "is no call that is read here")
        return listed[::2]


def column_major(place: int, shape: Sequence[int]) -> int:
    """Return where the entry stands in memory column by column that is number `place` row by row, both from 0."""
    index: list[int] = []
    for length in reversed(shape):
        index.append(place % length)
        place //= length
    return sum(one * prod(shape[:axis]) for axis, one in enumerate(reversed(index)))


MATLAB = ReadLanguage("MATLAB", "tree_sitter_matlab", frozenset({"comment"}), read)
