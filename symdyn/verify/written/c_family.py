"""What C, C++, CUDA and OpenCL say alike: real and whole numbers, places in arrays, declarations, parts of a function.

Names are set once, by `const`; entries of local arrays are written again and again, those of the result once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Index, MemoryInputs, Pointer, Rows, Work
from symdyn.verify.written.reading import Unread, kinds, line_of, nodes, parse, text_of, unread
from symdyn.verify.written.straight_line import FUNCTIONS, WHOLE, File, Reader, Syntax, Value

if TYPE_CHECKING:
    from tree_sitter import Node

SYNTAX = Syntax(number="number_literal")

MATH = {**FUNCTIONS, "fabs": Op.ABS, "atan2": Op.ATAN2, "pow": Op.POW}
"""Of <math.h>."""

OURS = {
    "exp_of": Op.EXP,
    "atan2_of": Op.ATAN2,
    "sign_of": Op.SIGN,
    "select_of": Op.SELECT,
    "symdyn_sign_of_double": Op.SIGN,
    "symdyn_sign_of_float": Op.SIGN,
    "symdyn_select_of_double": Op.SELECT,
    "symdyn_select_of_float": Op.SELECT,
}
"""Fixed text of the file."""

TRIGRAPH = re.compile(rb"\?\?[=/'()!<>-]")

PRODUCT = re.compile(rb"\((?=[A-Za-z_][A-Za-z_0-9]* \*)")
"""A parenthesis after which a product may be read as a pointer type of a cast; a plus sign tells them apart."""

MACRO = re.compile(rb"\bSYMDYN_(?!ALIGNED\b)[A-Z]+")
"""What no grammar is shown, and no body that is read holds."""

LARGEST = 1 << 16
"""No local array has more entries."""

UNUSED = ["(", "type_descriptor", ")", "identifier"]


WHOLE_OPERATIONS: Mapping[str, Callable[[Index, Index], Index]] = {"+": Index.__add__, "*": Index.__mul__}


class TakenForCast(Exception):  # noqa: N818  a signal
    """The grammar takes a product in parentheses for a type."""


@dataclass
class CFile(File):
    """A file of C, C++, CUDA or OpenCL; `grammar` is that of the language."""

    grammar: str = ""

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


def blanked(source: bytes, unknown: re.Pattern[bytes]) -> bytes:
    """Return a file as the grammar takes it: spaces in place of what it does not know, directives aside."""

    def blank(match: re.Match[bytes]) -> bytes:
        line = source[source.rfind(b"\n", 0, match.start()) + 1 : match.start()]
        return match[0] if line.startswith(b"#") else b" " * len(match[0])

    return unknown.sub(blank, source)


@dataclass
class CReader(Reader):
    """What these languages say alike.

    Attributes:
        again: whether a statement is read a second time, with casts told apart.
        arrays: local arrays, whose size the language knows, with their declarations.
        lanes: states of a block, 0 until it is said.
    """

    syntax = SYNTAX
    file: CFile
    again: bool = False
    arrays: dict[str, str] = field(default_factory=dict)
    lanes: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.meanings |= {"pointer_expression": self.address, "cast_expression": self.cast}

    @property
    def real_word(self) -> str:
        """What the type of real numbers is called."""
        return self.file.text.real

    @property
    def laned(self) -> bool:
        """Whether the function is about the states of a block."""
        return "stride" in self.names

    def body(self, name: str) -> None:
        """Read the body of a function of the file, whose parameters stand for something."""
        node = self.file.functions[name]
        if name in self.file.cuts:
            raise unread(node, "is called twice")
        body = node.child_by_field_name("body")
        if body is None or body.type != "compound_statement":
            raise unread(node, "has no body")
        if MACRO.search(self.file.text.source, body.start_byte, body.end_byte):
            raise unread(node, "holds a macro of fixed text")
        self.file.cut(name, body)
        self.block(body)
        lanes = [f"{self.lanes} states"] if self.lanes else []
        about = ", ".join([name, *lanes, *self.arrays.values()])  # sizes that code around relies on, or the stack
        self.file.cut(name, body, about=about)

    def block(self, body: Node) -> None:
        children = SYNTAX.meant(body)
        if len(children) < 2 or children[0].type != "{" or children[-1].type != "}":
            raise unread(body, "is no block")
        self.run(children[1:-1])

    def run(self, statements: Iterable[Node]) -> None:
        """Read statements, one after the other, some of them again where a product was taken for a cast."""
        for node in statements:
            try:
                super().run([node])
            except TakenForCast:
                self.again = True
                super().run([self._again(node)])
                self.again = False

    def statement(self, node: Node) -> None:
        inner = node.children[0] if kinds(node.children)[1:] == [";"] else node
        if node.type == "declaration":
            self.declare(node)
        elif node.type != "expression_statement":
            super().statement(node)
        elif inner.type == "assignment_expression":
            self._assign(inner)
        elif inner.type == "call_expression":
            self.perform(inner)
        elif inner.type != "cast_expression" or kinds(inner.children) != UNUSED:
            super().statement(node)
        elif text_of(inner.children[1]) != "void" or text_of(inner.children[3]) not in self.names:
            raise unread(node, "is no word of something unused")

    def perform(self, node: Node) -> None:
        """Read a call whose value nobody takes; languages say which have a meaning."""
        raise unread(node, "is no call that is read here")

    def piece(self, node: Node, name: str) -> None:
        """Read a part of this function, where it is called."""
        inner, given = parameters(self.file.functions[name]), self.call(node)[1]
        if len(inner) != len(given) or len(set(inner)) != len(inner):
            raise unread(node, f"does not give {name} what it takes")
        values = {one: self.value(argument) for one, argument in zip(inner, given, strict=True)}
        piece = type(self)(self.file, self.expected, values, lanes=self.lanes)
        piece.body(name)
        self.lanes = piece.lanes

    def declare(self, node: Node) -> None:
        """Read `const double x = …;`, `const double a[8] = {…};` or `double w[4], r[4][64];`."""
        found = kinds(node.children)
        if found[0] == "type_qualifier" and found[2:] == ["init_declarator", ";"]:
            qualifier, real, declarator, _ = node.children
            self._is_real(real)
            if text_of(qualifier) != "const":
                raise unread(qualifier, "is not const")
            self._define(declarator)
            return
        if found[-1] != ";" or {*found[2:-1:2]} - {","}:
            raise unread(node, "is no declaration that is read here")
        self._is_real(node.children[0])
        for declarator in node.children[1:-1:2]:
            self.declare_array(declarator)

    def declare_array(self, node: Node) -> None:
        """Read what stands in a declaration without a value."""
        inner, size = self._array(node)
        if inner.type == "identifier":
            self.set(inner, Pointer(Work(size)))
            self.arrays[text_of(inner)] = text_of(node)
            return
        name, rows = self._array(inner)
        self.of_lanes(node, size)
        self.set(name, Rows(tuple(Pointer(Work(size, row=True)) for _ in range(rows))))
        self.arrays[text_of(name)] = text_of(node)

    def hides(self, name: str) -> bool:
        return self.function_of(name) is not None or name in self.file.functions

    def of_lanes(self, node: Node, lanes: int) -> None:
        """Look whether a number is that of the states of a block."""
        if not self.laned or self.lanes not in (0, lanes):
            raise unread(node, "is not of as many states as the block")
        self.lanes = lanes

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
        if text_of(node) != self.real_word:
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
        if len(values) != size or {*kinds(listed.children[2:-1:2])} - {","}:
            raise unread(listed, f"is not a list of {size}")
        for place, value in enumerate(values):
            memory.store(Index(place), value, line_of(listed))
        self.set(name, Pointer(memory))
        self.arrays[text_of(name)] = text_of(declarator)

    def _array(self, node: Node) -> tuple[Node, int]:
        """Return what is declared an array, and its length."""
        if kinds(node.children)[1:] != ["[", "number_literal", "]"]:
            raise unread(node, "is no array of a known length")
        size = self.whole(node.children[2])
        if size > LARGEST:
            raise unread(node, f"has more than {LARGEST} entries")
        return node.children[0], size

    def _assign(self, node: Node) -> None:
        left, operator, right = node.children
        if operator.type != "=" or left.type != SYNTAX.entry:
            raise unread(node, "is no assignment to an entry of an array")
        self.store(left, self.real(right))

    # Expressions

    def whole(self, node: Node) -> int:
        value = self.value(node)
        if not (isinstance(value, Index) and value.plain):
            raise unread(node, "is no whole number")
        return value.units

    def function_of(self, name: str) -> Op | None:
        if name in self.file.functions:  # nothing of the C library then
            return OURS.get(self.file.within(name))
        if self.file.text.real == "float":
            return MATH.get(name[:-1]) if name.endswith("f") else None
        return MATH.get(name)

    def combined(self, node: Node, operator: str, a: Value, b: Value) -> Value:
        """Return what an operator makes of two values, be they whole numbers, or a place and how much further on."""
        if isinstance(a, Index) and isinstance(b, Index):
            if operator in WHOLE_OPERATIONS:
                return WHOLE_OPERATIONS[operator](a, b)
            raise unread(node, "is no sum or product of whole numbers")
        if isinstance(a, Pointer) and isinstance(b, Index) and operator == "+":
            return a.plus(b)
        return super().combined(node, operator, a, b)

    def function(self, node: Node) -> Op | None:
        return self.function_of(text_of(node)) if node.type in ("identifier", "qualified_identifier") else None

    def index(self, node: Node) -> Index:
        index = self.value(node)
        if not isinstance(index, Index):
            raise unread(node, "is no index")
        return index

    def number(self, node: Node) -> Value:
        """Return a literal: a whole number, or a real one."""
        digits = text_of(node)
        if WHOLE.fullmatch(digits):
            return Index(int(digits))
        size = digits.lstrip("-+")  # the grammar takes a sign along
        if self.file.text.real == "float":
            if not size.endswith("f"):
                raise unread(node, "is no float")
            size = size[:-1]
        if size.isdigit():
            raise unread(node, "is no decimal number")
        value = self.file.text.number(size, line_of(node))
        return self.file.text.negative(value, line_of(node)) if digits[0] == "-" else value

    def signed(self, node: Node) -> Value:
        """Return what a sign makes of a number; a plus sign is what tells a product from a cast."""
        operator, operand = node.children
        return self.real(operand) if operator.type == "+" else super().signed(node)

    def address(self, node: Node) -> Value:
        operator, operand = node.children
        value = self.value(operand)
        if operator.type != "&" or not isinstance(value, Expr) or operand.type != "identifier":
            raise unread(node, "is not the address of a number")
        return Pointer(MemoryInputs(text_of(operand), (value,)))

    def cast(self, node: Node) -> Value:
        """Refuse a cast, unless it may be a product."""
        if not self.again:
            raise TakenForCast
        raise unread(node, "is no expression that is read here")


def declared_name(node: Node) -> str:
    """Return the name that a function definition gives."""
    declarator = node.child_by_field_name("declarator")
    while declarator is not None and declarator.type == "pointer_declarator":  # nobody reads what returns an address
        declarator = declarator.child_by_field_name("declarator")
    name = declarator.child_by_field_name("declarator") if declarator is not None else None
    if declarator is None or declarator.type != "function_declarator" or name is None:
        raise unread(node, "is no plain function")
    return text_of(name)


def parameters(node: Node) -> list[str]:
    """Return the names of the parameters of a function."""
    declarator = node.child_by_field_name("declarator")
    listed = declarator.child_by_field_name("parameters") if declarator is not None else None
    if listed is None:
        raise unread(node, "has no parameters")
    return [_parameter(one) for one in listed.named_children if one.type == "parameter_declaration"]


def _parameter(node: Node) -> str:
    """Return the name that a declaration gives, however its type is written around it."""
    names = [text_of(one) for one in nodes(node) if one.type == "identifier"]
    if len(names) != 1:
        raise unread(node, "is no plain parameter")
    return names[0]
