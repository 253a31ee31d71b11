"""Straight lines of code read back: one reader of expressions, a row of node types and spellings a language.

A name stands for a number, for a whole number, or for a place in an array; it is set once, hides no function, and is
read when it has a value. What only one language says is a method of its own in a class that follows this one: its
statements, what it calls its functions, how it spells an entry of an array.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Union

from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Op, Piecewise
from symdyn.unlocked import cached_property
from symdyn.verify.written.memory import Fault, Index, MemoryInputs, Pointer, Result, Rows, Spelled, Work
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, Text, Unread, kinds, line_of, text_of, unread

if TYPE_CHECKING:
    from tree_sitter import Node

Value = Union[Expr, Index, Pointer, Rows]

WHOLE = re.compile(r"0|[1-9][0-9]*")

EXACT = 2**24
"""Whole numbers below are floats."""

OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}

FUNCTIONS = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
}
"""What all languages call alike."""


@dataclass(frozen=True)
class Syntax:
    """How a language writes expressions.

    Attributes:
        name, number, inner, signed, binary, entry, called: what the grammar calls them; `inner` has parentheses.
        arguments: what it calls the list behind a name that is called.
        place: what it calls a whole number in an index.
        silent: what it calls nodes that mean nothing.
        functions: of the language, by name.
        operators: of two numbers.
    """

    name: str = "identifier"
    number: str = "number"
    inner: str = "parenthesized_expression"
    signed: str = "unary_expression"
    binary: str = "binary_expression"
    entry: str = "subscript_expression"
    called: str = "call_expression"
    arguments: str = "argument_list"
    place: str = "number"
    silent: frozenset[str] = frozenset({"comment"})
    functions: Mapping[str, Op] = field(default_factory=dict)
    operators: Mapping[str, Callable[[Expr, Expr], Expr]] = field(default_factory=lambda: OPERATIONS)

    def meant(self, node: Node) -> list[Node]:
        """Return the children of a node that mean something."""
        return [one for one in node.children if one.type not in self.silent]

    def shaped(self, node: Node, why: str, *expected: str) -> list[Node]:
        """Return the children of a node that mean something, which must be of these types.

        Raises:
            Unread: they are not; this is `why`.
        """
        found = self.meant(node)
        if kinds(found) != [*expected]:
            raise unread(node, why)
        return found

    def listed(self, node: Node, why: str) -> list[Node]:
        """Return what stands between brackets, with commas; Unread where it does not; this is `why`."""
        first, *inner, last = self.meant(node)
        if (first.type, last.type) not in (("(", ")"), ("[", "]")) or any(one.type != "," for one in inner[1::2]):
            raise unread(node, why)
        return inner[::2]


TABLED = re.compile(
    r"^[^\n]*?\b(\w*table_\d+_\w+)\b[^\n]*?[\[{(]([-+.\def]+(?:, [-+.\def]+)*)[\]})][^\n]*?\b(\d+), (\d+)", re.MULTILINE
)
"""A function that is given by points: its name, numbers, how many of them are knots, and how wide rows are."""


@dataclass
class File:
    """A file whose functions are read."""

    text: Text
    functions: Mapping[str, Node]
    cuts: dict[str, Cut] = field(default_factory=dict)

    @cached_property
    def tables(self) -> dict[str, Piecewise]:
        """Functions that are given by points, by name: each is said in one line."""
        found, text = {}, self.text
        for match in TABLED.finditer(text.source.decode("utf-8", "replace")):
            name, listed, knots, width = match.groups()
            line, n, w = text.source.count(b"\n", 0, match.start()) + 1, int(knots), int(width)
            values = [text.literal(one, line) for one in listed.split(", ")]
            if len(values) != n + (n + 1) * w or name in found:
                raise Unread(line, f"{name} is no table of {n} knots, or one of several")
            rows = tuple(tuple(values[k : k + w]) for k in range(n, len(values), w))
            found[name] = Piecewise("", tuple(values[:n]), rows)
        return found

    def cut(self, name: str, first: Node, last: Node | None = None, about: str = "") -> None:
        """Say that what stands from one node to another has been read, the function `name`, or `about` it."""
        self.cuts[name] = Cut(first.start_byte, (last or first).end_byte, about or name)


@dataclass
class Reader:
    """One function that is being read."""

    syntax: ClassVar[Syntax]  # of the language
    file: File  # where it stands
    expected: ExpectedFunction  # which of the program's functions it is, or a part of
    names: dict[str, Value] = field(default_factory=dict)  # arguments and what was set

    def __post_init__(self) -> None:
        """Lay out which node is which expression."""
        self.meanings: dict[str, Callable[[Node], Value]] = {
            self.syntax.name: self.name,
            self.syntax.number: self.number,
            self.syntax.inner: self.inner,
            self.syntax.signed: self.signed,
            self.syntax.binary: self.binary,
            self.syntax.entry: self.entry,
            self.syntax.called: self.called,
        }

    def open(
        self,
        columns: bool = False,
        apart: bool = False,
        reaching: bool = False,
        numbers: bool = True,
        spelled: Spelled = str,
    ) -> Result:
        """Let names stand for arguments, entries of one state or of state k among columns; return the result, `out`.

        Args:
            columns: whether its arguments are columns of states.
            apart: whether the result is another array than the arguments.
            reaching: whether columns of the result are `reach` apart, not as those of arguments.
            numbers: whether arguments that are one number are given as such, and not as arrays.
            spelled: how the language counts entries of the result.
        """
        wanted, common = self.expected, common_of(self.expected) if columns else ""
        given = {one: MemoryInputs(one, wanted.arguments[one], columns and one != common) for one in wanted.arguments}
        result = Result(wanted.size, columns, () if apart else tuple(given.values()), reaching, spelled)
        by_value = wanted.scalars if numbers and not columns else ()
        for name, memory in given.items():
            self.names[name] = memory.entries[0] if name in by_value else Pointer(memory)
        self.names["out"] = Pointer(result)
        return result

    def finished(self, name: str, node: Node, result: Result) -> Read:
        """Return what a function computes, when its body has been read.

        Raises:
            Unread: an entry of its result was never written.
        """
        try:
            entries, lines = result.whole()
        except Fault as fault:
            raise Unread(line_of(node), f"{name} {fault}") from None
        return Read(self.expected.name, name, entries, lines)

    def run(self, statements: Iterable[Node]) -> None:
        for node in statements:
            try:
                self.statement(node)
            except Fault as fault:
                raise unread(node, str(fault)) from None

    def statement(self, node: Node) -> None:
        """Read one statement; languages say which have a meaning."""
        raise unread(node, "is no statement that is read here")

    def set(self, node: Node, value: Value) -> None:
        """Let a new name stand for a value."""
        self.names[self.fresh(node)] = value

    def fresh(self, node: Node) -> str:
        """Return a name that stands for nothing yet."""
        if node.type != self.syntax.name:
            raise unread(node, "is no name")
        name = text_of(node)
        if name in self.names:
            raise unread(node, "has a value already")
        if self.hides(name):
            raise unread(node, "hides what is called by this name")
        return name

    def hides(self, name: str) -> bool:
        """Tell whether a name is one of something else."""
        return name in self.syntax.functions or name in self.file.functions

    def store(self, node: Node, value: Expr) -> None:
        """Write an entry of an array, `out[0] = …`."""
        base, index = self.subscript(node)
        if not isinstance(base, Pointer):
            raise unread(node, "is no entry of an array")
        base.store(index, value, line_of(node))

    def copy(self, to: Value, source: Value, node: Node) -> None:
        """Copy a local array, all of it."""
        if not (isinstance(to, Pointer) and isinstance(source, Pointer) and isinstance(source.memory, Work)):
            raise unread(node, "is no copy of a local array")
        values = [source.load(Index(place)) for place in range(source.memory.size)]
        for place, value in enumerate(values):
            to.store(Index(place), value, line_of(node))

    # Expressions

    def value(self, node: Node) -> Value:
        meaning = self.meanings.get(node.type)
        if meaning is None:
            raise unread(node, "is no expression that is read here")
        try:
            return meaning(node)
        except Fault as fault:
            raise unread(node, str(fault)) from None

    def real(self, node: Node) -> Expr:
        return self.converted(node, self.value(node))

    def converted(self, node: Node, value: Value) -> Expr:
        """Return a value as a real number, into which whole numbers turn exactly."""
        if isinstance(value, Expr):
            return value
        if isinstance(value, Index) and value.plain and abs(value.units) < EXACT:
            return self.file.text.graph.constant(value.units)
        raise unread(node, "is no real number")

    def name(self, node: Node) -> Value:
        name = text_of(node)
        if name not in self.names:
            raise unread(node, "has no value yet")
        return self.names[name]

    def number(self, node: Node) -> Value:
        return self.file.text.number(text_of(node), line_of(node))

    def inner(self, node: Node) -> Value:
        listed = self.syntax.listed(node, "is no expression that is read here")
        if len(listed) != 1:
            raise unread(node, "is no expression that is read here")
        return self.value(listed[0])

    def signed(self, node: Node) -> Value:
        """Return what a sign makes of a number."""
        operator, operand = self.syntax.meant(node)
        why = "is no sign of a number"
        given = self.syntax.listed(operand, why) if operand.type == self.syntax.arguments else [operand]  # of a call
        if text_of(operator) != "-" or len(given) != 1:
            raise unread(node, why)
        return self.file.text.negative(self.real(given[0]), line_of(node))

    def binary(self, node: Node) -> Value:
        parts = self.syntax.meant(node)
        if len(parts) != 3:
            raise unread(node, "is no expression that is read here")
        if text_of(parts[1]) not in self.syntax.operators:
            raise unread(node, "is no operation that is read here")
        return self.combined(node, text_of(parts[1]), self.value(parts[0]), self.value(parts[2]))

    def combined(self, node: Node, operator: str, a: Value, b: Value) -> Value:
        try:
            return self.syntax.operators[operator](self.converted(node, a), self.converted(node, b))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def subscript(self, node: Node) -> tuple[Value, Index]:
        """Return the array and the index of `x[i]`."""
        parts = self.syntax.meant(node)
        if len(parts) == 2:
            parts = [parts[0], *self.syntax.meant(parts[1])]  # a list of its own in C++
        if len(parts) != 4 or (parts[1].type, parts[3].type) != ("[", "]"):
            raise unread(node, "is no entry of an array")
        return self.value(parts[0]), self.index(parts[2])

    def index(self, node: Node) -> Index:
        """Return which entry of an array a whole number is."""
        if node.type != self.syntax.place or not WHOLE.fullmatch(text_of(node)):
            raise unread(node, "is no place in an array")
        return Index(int(text_of(node)))

    def entry(self, node: Node) -> Value:
        """Return an entry of an array, or a row."""
        base, index = self.subscript(node)
        if isinstance(base, Rows):
            return base.row(index)
        if not isinstance(base, Pointer):
            raise unread(node, "is no entry of an array")
        return base.load(index)

    def call(self, node: Node) -> tuple[Node, list[Node]]:
        """Return what is called, and with what."""
        callee, *rest = self.syntax.meant(node)
        if len(rest) != 1 or rest[0].type != self.syntax.arguments:
            raise unread(node, "is no call that is read here")
        return callee, self.syntax.listed(rest[0], "is no call that is read here")

    def called(self, node: Node) -> Value:
        callee, given = self.call(node)
        name = text_of(callee).removeprefix("own::")
        if name in self.file.tables and name not in self.names and len(given) == 1:
            return self.file.text.graph.lookup(self.file.tables[name], self.real(given[0]))
        op = self.function(callee)
        if op is None:
            raise unread(node, "is no function that is read here")
        if len(given) != op.arity:
            raise unread(node, "has another number of arguments")
        return self.file.text.graph.function(op, *map(self.real, given))

    def function(self, node: Node) -> Op | None:
        """Return which operation is called, None if none that is known."""
        other = node.type != self.syntax.name or text_of(node) in self.names or text_of(node) in self.file.functions
        return None if other else self.syntax.functions.get(text_of(node))


def takes(node: Node, found: Sequence[str], expected: Sequence[str]) -> None:
    """Look whether a function has the parameters that it must have; Unread where it has not."""
    if [*found] != [*expected]:
        raise unread(node, f"takes {', '.join(found)}, not {', '.join(expected)}")


def common_of(expected: ExpectedFunction) -> str:
    """Return which argument all states of a batch have in common; "" if each state has its own."""
    given = expected.arguments
    return next((name for name in given if name in ("params", "prepared") and len(given) > 1), "")
