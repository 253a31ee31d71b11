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

from dataclasses import dataclass
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Index, Pointer
from symdyn.verify.written.reading import Cut, ReadLanguage, Text, TextReading, Unread, kinds, line_of, text_of, unread
from symdyn.verify.written.straight_line import FUNCTIONS, File, Reader, Syntax, Value, takes

if TYPE_CHECKING:
    from tree_sitter import Node

SYNTAX = Syntax(
    inner="parenthesis",
    signed="unary_operator",
    binary="binary_operator",
    entry="",  # is a call, too
    called="function_call",
    silent=frozenset({"comment", "line_continuation", "\n"}),
    functions={**FUNCTIONS, "abs": Op.ABS, "sign": Op.SIGN, "atan2": Op.ATAN2},
    operators={"+": Expr.__add__, "-": Expr.__sub__, ".*": Expr.__mul__, "./": Expr.__truediv__},
)
"""MATLAB's own functions, and operators that take two rows number by number."""

OURS = {"sqrt_of": Op.SQRT, "log_of": Op.LOG, "pow_of": Op.POW, "select_of": Op.SELECT}
"""Fixed text of the file."""

STATES, COUNTED = "states", "columns_of"
"""How many states there are, and the function of the file that looks at an argument for it."""

ALLOCATING = ("zeros", "sum", "reshape")
"""Functions that fixed text calls after the first row."""


def read(text: Text) -> TextReading:
    """Return what the first function of a MATLAB file computes; a file of comments alone has none."""
    tops = SYNTAX.meant(text.root)
    if not tops:
        return TextReading((), ())
    strange = next((node for node in tops if node.type != "function_definition"), None)
    if strange is not None:
        raise unread(strange, "is no function")
    functions = {_name(node): node for node in tops}
    if len(functions) != len(tops):
        raise unread(tops[0], "is followed by two functions of one name")
    wanted = next((one for one in text.expected if one.name == _name(tops[0])), None)
    if wanted is None:
        raise unread(tops[0], "is none of the functions that are wanted")
    return MatlabReader(File(text, functions), wanted).read(tops[0])


def _name(node: Node) -> str:
    name = node.child_by_field_name("name")
    if name is None or name.type != "identifier":
        raise unread(node, "is no plain function")
    return text_of(name)


@dataclass
class MatlabReader(Reader):
    """What only MATLAB says: rows of arrays, and a result that is made, written row by row, and brought into shape."""

    syntax = SYNTAX
    made: bool = False  # whether there is room for the result
    shaped: bool = False  # whether it has its shape

    def read(self, node: Node) -> TextReading:
        """Return what it computes, and which parts of the file that is: those between its fixed text."""
        self._head(node)
        result = self.open(apart=True, numbers=False, spelled=lambda place: str(place + 1))
        (body,) = (one for one in node.children if one.type == "block")
        parts: list[tuple[int, int]] = []
        going = begun = False
        rest = iter(SYNTAX.meant(body))
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
            self.run([statement])
            first = parts.pop()[0] if going else statement.start_byte
            parts.append((first, ended.end_byte))
            going = True
        cuts = (Cut(*part, f"{self.expected.name} {number}") for number, part in enumerate(parts, 1))
        found = self.finished(self.expected.name, node, result).by_rows(self.expected.shape)
        if not self.made or (len(self.expected.shape) > 1 and not self.shaped):
            raise Unread(line_of(node), f"{self.expected.name} returns no result of shape {self.expected.shape}")
        return TextReading((found,), tuple(cuts))

    def _head(self, node: Node) -> None:
        """Look whether it takes and returns what it must."""
        outputs = [one for one in node.children if one.type == "function_output"]
        given = [one for one in node.children if one.type == "function_arguments"]
        if len(outputs) != 1 or [text_of(one) for one in SYNTAX.meant(outputs[0])] != ["out", "="]:
            raise unread(node, "does not return out")
        listed = [text_of(one) for one in SYNTAX.listed(given[0], "is no plain function")] if given else []
        takes(node, listed, [*self.expected.arguments])

    def _counts(self, node: Node) -> bool:
        """Tell whether a statement is one of those that count states, which are fixed text."""
        left, right = self._sides(node)
        if left.type != "identifier" or text_of(left) != STATES:
            return False
        called = SYNTAX.meant(right)[0] if right.type == SYNTAX.called else right
        if text_of(called) not in ("1", COUNTED) or (text_of(called) == COUNTED and COUNTED not in self.file.functions):
            raise unread(node, "does not count states")
        return True

    def _sides(self, node: Node) -> tuple[Node, Node]:
        left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
        if left is None or right is None or kinds(SYNTAX.meant(node))[1:-1] != ["="]:
            raise unread(node, "is no assignment that is read here")
        return left, right

    def _allocates(self, node: Node) -> bool:
        """Tell of `out = zeros(rows, states, …)` and `out = reshape(out, n, m, states)`, which stay fixed text."""
        left, right = self._sides(node)
        if left.type != "identifier" or text_of(left) != "out":
            return False
        callee, given = self.call(right) if right.type == SYNTAX.called else (right, [])
        called, words = text_of(callee), [text_of(one) for one in given]
        if called == "zeros" and not self.made and words[:2] == [str(self.expected.size), STATES]:
            self.made = True
        elif called == "reshape" and self.made and not self.shaped and len(self.expected.shape) > 1:
            if words != ["out", *map(str, self.expected.shape), STATES]:
                raise unread(right, f"is not of shape {self.expected.shape}")
            self.shaped = True
        else:
            raise unread(node, "is no result that is read here")
        if called in self.file.functions:
            raise unread(node, "calls a function of the file")
        return True

    def statement(self, node: Node) -> None:
        """Read `x1 = …` or a row of the result, `out(3, :) = …`."""
        left, right = self._sides(node)
        if left.type == SYNTAX.called and (self.shaped or not self.made):
            raise unread(node, "is no row of the result")
        if left.type == SYNTAX.called:
            self.store(left, self.real(right))
        elif self.made:
            raise unread(node, "comes after the result was begun")
        else:
            self.set(left, self.real(right))

    def hides(self, name: str) -> bool:
        return name in (STATES, *ALLOCATING) or super().hides(name)

    def binary(self, node: Node) -> Value:
        """Return what an operator makes of two rows, number by number."""
        if text_of(SYNTAX.meant(node)[1]) not in SYNTAX.operators:
            raise unread(node, "takes no rows number by number")
        return super().binary(node)

    def called(self, node: Node) -> Value:
        """Return a row of an argument, or a function of rows: MATLAB writes both alike."""
        array = isinstance(self.names.get(text_of(SYNTAX.meant(node)[0])), Pointer)
        return self.entry(node) if array else super().called(node)

    def function(self, node: Node) -> Op | None:
        ours = text_of(node) in self.file.functions and text_of(node) not in self.names
        return OURS.get(text_of(node)) if ours else super().function(node)

    def subscript(self, node: Node) -> tuple[Value, Index]:
        """Return the array and the row of `name(3, :)`, which counts from 1."""
        name, given = self.call(node)
        if len(given) != 2 or given[0].type != SYNTAX.place:
            raise unread(node, "is no row of an array")
        if given[1].type != "spread_operator":
            raise unread(node, "is no whole row")
        row = self.index(given[0]).units
        size = self.expected.size if text_of(name) == "out" else len(self.expected.arguments.get(text_of(name), ()))
        if not 1 <= row <= size:
            raise unread(node, f"is row {row} of {text_of(name)}, which has {size}")
        return self.value(name), Index(row - 1)

    def call(self, node: Node) -> tuple[Node, list[Node]]:
        """Return what is called, and with what stands between the parentheses of `name(…)`."""
        why = "is no call that is read here"
        if kinds(SYNTAX.meant(node)) == ["identifier", "(", ")"]:
            return SYNTAX.meant(node)[0], []
        callee, _, listed, _ = SYNTAX.shaped(node, why, "identifier", "(", "arguments", ")")
        given = SYNTAX.meant(listed)
        if any(one.type != "," for one in given[1::2]):
            raise unread(node, why)
        return callee, given[::2]


MATLAB = ReadLanguage("MATLAB", "tree_sitter_matlab", read)
