"""What statements of C, C++, CUDA and OpenCL do, one after the other: names are set once, entries of arrays written."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from symdyn.verify.written.c_values import File, TakenForCast, Value, Values
from symdyn.verify.written.memory import Fault, Index, MemoryInputs, Pointer, Result, Rows, Work
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, Unread
from symdyn.verify.written.syntax import line_of, nodes, parse, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

PRODUCT = re.compile(rb"\((?=[A-Za-z_][A-Za-z_0-9]* \*)")
"""A parenthesis after which a product may be read as a pointer type of a cast; a plus sign tells them apart."""

MACRO = re.compile(rb"\bSYMDYN_(?!ALIGNED\b)[A-Z]+")
"""What no grammar is shown, and no body that is read holds."""

LARGEST = 1 << 16
"""No local array has more entries."""

UNUSED = ["(", "type_descriptor", ")", "identifier"]


@dataclass
class Statements(Values):
    """The statements of one function.

    Attributes:
        arrays: local arrays, whose size the language knows, with their declarations.
        lanes: states of a block, 0 until it is said.
    """

    arrays: dict[str, str] = field(default_factory=dict)
    lanes: int = 0

    @property
    def real_word(self) -> str:
        """What the type of real numbers is called."""
        return self.file.text.real

    @property
    def laned(self) -> bool:
        """Whether the function is about the states of a block."""
        return "stride" in self.names

    def run(self, name: str) -> None:
        """Read the body of a function of the file, whose parameters are bound."""
        node = self.file.functions[name]
        if name in self.file.cuts:
            raise unread(node, "is called twice")
        body = node.child_by_field_name("body")
        if body is None or body.type != "compound_statement":
            raise unread(node, "has no body")
        if MACRO.search(self.file.text.source, body.start_byte, body.end_byte):
            raise unread(node, "holds a macro of fixed text")
        self.file.cuts[name] = Cut(body.start_byte, body.end_byte, name)
        self.block(body)
        lanes = [f"{self.lanes} states"] if self.lanes else []
        about = ", ".join([name, *lanes, *self.arrays.values()])  # sizes that code around relies on, or the stack
        self.file.cuts[name] = Cut(body.start_byte, body.end_byte, about)

    def block(self, body: Node) -> None:
        """Read all statements of a body."""
        children = body.children
        if len(children) < 2 or children[0].type != "{" or children[-1].type != "}":
            raise unread(body, "is no block")
        for statement in children[1:-1]:
            try:
                self.statement(statement)
            except TakenForCast:
                self.again = True
                self.statement(self._again(statement))
                self.again = False
            except Fault as fault:
                raise unread(statement, str(fault)) from None

    def statement(self, node: Node) -> None:
        """Read one statement; languages add theirs."""
        if node.type == "declaration":
            self.declare(node)
        elif node.type == "expression_statement" and len(node.children) == 2 and node.children[1].type == ";":
            self._act(node.children[0])
        elif node.type != "comment":
            raise unread(node, "is no statement that is read here")

    def call(self, node: Node) -> None:
        """Read a call whose value nobody takes; languages say which have a meaning."""
        raise unread(node, "is no call that is read here")

    def declare(self, node: Node) -> None:
        """Read `const double x = …;`, `const double a[8] = {…};` or `double w[4], r[4][64];`."""
        kinds = [child.type for child in node.children]
        if kinds[0] == "type_qualifier" and kinds[2:] == ["init_declarator", ";"]:
            qualifier, real, declarator, _ = node.children
            self._is_real(real)
            if said(qualifier) != "const":
                raise unread(qualifier, "is not const")
            self._define(declarator)
            return
        if kinds[-1] != ";" or kinds[2:-1:2] != [","] * len(kinds[2:-1:2]):
            raise unread(node, "is no declaration that is read here")
        self._is_real(node.children[0])
        for declarator in node.children[1:-1:2]:
            self.declare_array(declarator)

    def declare_array(self, node: Node) -> None:
        """Read what stands in a declaration without a value."""
        inner, size = self._array(node)
        if inner.type == "identifier":
            self.set(inner, Pointer(Work(size)))
            self.arrays[said(inner)] = said(node)
            return
        name, rows = self._array(inner)
        self.of_lanes(node, size)
        self.set(name, Rows(tuple(Work(size, row=True) for _ in range(rows))))
        self.arrays[said(name)] = said(node)

    def set(self, node: Node, value: Value) -> None:
        """Let a new name stand for a value."""
        if node.type != "identifier":
            raise unread(node, "is no name")
        name = said(node)
        if name in self.names:
            raise unread(node, "has a value already")
        if self.function_of(name) is not None or name in self.file.functions:
            raise unread(node, "hides a function")
        self.names[name] = value

    def of_lanes(self, node: Node, lanes: int) -> None:
        """Look whether a number is that of the states of a block."""
        if not self.laned or self.lanes not in (0, lanes):
            raise unread(node, "is not of as many states as the block")
        self.lanes = lanes

    def copy(self, to: Value, source: Value, node: Node) -> None:
        """Copy a local array, all of it."""
        if not (isinstance(to, Pointer) and isinstance(source, Pointer) and isinstance(source.memory, Work)):
            raise unread(node, "is no copy of a local array")
        values = [source.load(Index(place)) for place in range(source.memory.size)]
        for place, value in enumerate(values):
            to.store(Index(place), value, line_of(node))

    def sines(self, node: Node, values: Iterable[Value], places: Iterable[Index]) -> None:
        """Take sines and cosines of angles, at some places of three arrays."""
        angles, sines, cosines = values
        if not (isinstance(angles, Pointer) and isinstance(sines, Pointer) and isinstance(cosines, Pointer)):
            raise unread(node, "is no row of sines")
        graph, line = self.file.text.graph, line_of(node)
        for place in places:
            angle = angles.load(place)
            sines.store(place, graph.sin(angle), line)
            cosines.store(place, graph.cos(angle), line)

    def _again(self, node: Node) -> Node:
        """Return a statement read again: `(a * (b)) - c` is no cast, where a is a number."""
        source = b"\n" * (line_of(node) - 1) + b"void f(void) {" + PRODUCT.sub(b"(+", node.text or b"") + b"}"
        body = parse(self.file.grammar, source).children[-1].child_by_field_name("body")
        if body is None or len(body.children) != 3:
            raise unread(node, "is no statement that is read here")
        return body.children[1]

    def _is_real(self, node: Node) -> None:
        if said(node) != self.real_word:
            raise unread(node, f"is not {self.real_word}")

    def _define(self, node: Node) -> None:
        if len(node.children) != 3 or node.children[1].type != "=":
            raise unread(node, "is no declaration that is read here")
        name, _, value = node.children
        if name.type == "identifier":
            self.set(name, self.real(value))
        elif name.type == "array_declarator" and value.type == "initializer_list":
            self._define_array(name, value)
        else:
            raise unread(node, "is no declaration that is read here")

    def _define_array(self, declarator: Node, listed: Node) -> None:
        name, size = self._array(declarator)
        memory = Work(size)
        values = [self.real(one) for one in listed.children[1:-1:2]]
        if len(values) != size or any(one.type != "," for one in listed.children[2:-1:2]):
            raise unread(listed, f"is not a list of {size}")
        for place, value in enumerate(values):
            memory.store(Index(place), value, line_of(listed))
        self.set(name, Pointer(memory))
        self.arrays[said(name)] = said(declarator)

    def _array(self, node: Node) -> tuple[Node, int]:
        """Return what is declared an array, and its length."""
        if [child.type for child in node.children[1:]] != ["[", "number_literal", "]"]:
            raise unread(node, "is no array of a known length")
        size = self.whole(node.children[2])
        if size > LARGEST:
            raise unread(node, f"has more than {LARGEST} entries")
        return node.children[0], size

    def _act(self, node: Node) -> None:
        if node.type == "assignment_expression":
            self._assign(node)
        elif node.type == "call_expression":
            self.call(node)
        elif node.type == "cast_expression" and [one.type for one in node.children] == UNUSED:
            if said(node.children[1]) != "void" or said(node.children[3]) not in self.names:
                raise unread(node, "is no word of something unused")
        else:
            raise unread(node, "is no statement that is read here")

    def _assign(self, node: Node) -> None:
        left, operator, right = node.children
        if operator.type != "=" or left.type != "subscript_expression":
            raise unread(node, "is no assignment to an entry of an array")
        base, index = self.subscript(left)
        if not isinstance(base, Pointer):
            raise unread(left, "is no entry of an array")
        base.store(index, self.real(right), line_of(node))


@dataclass(frozen=True)
class Opened:
    """The arguments of a function that is about to be read: its names, and where its result goes."""

    names: dict[str, Value]
    result: Result


def opened(expected: ExpectedFunction, columns: bool, apart: bool, reaching: bool = False) -> Opened:
    """Return the arguments of a function by name, entries of one state or of state k among columns.

    Args:
        expected: which function.
        columns: whether its arguments are columns of states.
        apart: whether the result is another array than the arguments.
        reaching: whether columns of the result are `reach` apart, not as those of arguments.
    """
    common = common_of(expected) if columns else ""
    given = {one: MemoryInputs(one, expected.arguments[one], columns and one != common) for one in expected.arguments}
    result = Result(expected.size, columns, () if apart else tuple(given.values()), reaching)
    names: dict[str, Value] = {
        one: memory.entries[0] if one in expected.scalars and not columns else Pointer(memory)
        for one, memory in given.items()
    }
    return Opened({**names, "out": Pointer(result)}, result)


def finished(file: File, name: str, expected: ExpectedFunction, result: Result) -> Read:
    """Return what a function computes, when its body has been read."""
    try:
        entries, lines = result.whole()
    except Fault as fault:
        raise Unread(line_of(file.functions[name]), f"{name} {fault}") from None
    return Read(expected.name, name, entries, lines)


def takes(file: File, name: str, expected: list[str]) -> None:
    """Look whether a function has these parameters."""
    found = parameters(file.functions[name])
    if found != expected:
        raise unread(file.functions[name], f"takes {', '.join(found)}, not {', '.join(expected)}")


def declared_name(node: Node) -> str:
    """Return the name that a function definition gives."""
    declarator = node.child_by_field_name("declarator")
    while declarator is not None and declarator.type == "pointer_declarator":  # nobody reads what returns an address
        declarator = declarator.child_by_field_name("declarator")
    name = declarator.child_by_field_name("declarator") if declarator is not None else None
    if declarator is None or declarator.type != "function_declarator" or name is None:
        raise unread(node, "is no plain function")
    return said(name)


def parameters(node: Node) -> list[str]:
    """Return the names of the parameters of a function."""
    declarator = node.child_by_field_name("declarator")
    listed = declarator.child_by_field_name("parameters") if declarator is not None else None
    if listed is None:
        raise unread(node, "has no parameters")
    return [_parameter(one) for one in listed.named_children if one.type == "parameter_declaration"]


def _parameter(node: Node) -> str:
    """Return the name that a declaration gives, however its type is written around it."""
    names = [said(one) for one in nodes(node) if one.type == "identifier"]
    if len(names) != 1:
        raise unread(node, "is no plain parameter")
    return names[0]


def common_of(expected: ExpectedFunction) -> str:
    """Return which argument all states of a batch have in common; "" if each state has its own."""
    given = expected.arguments
    return next((name for name in given if name in ("params", "prepared") and len(given) > 1), "")
