"""The meaning of C as far as generated files go: straight lines of real numbers, arrays, calls of parts, one loop.

    <stem>_<function>            one state; the arguments and the result may be the same array
    <function>_part<n>           a piece of it, read where it is called
    <function>_block             as many states as it says, entry i of state k at [i * stride + k]
    <function>_pass<n>           one loop over them, read where it is called, for state k

All other functions of a file are fixed text: `sincos_row`, `sign_of`, `exp_of` mean here what they are called, columns
and rows of states are brought to `_block` by what is compared and measured.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Union

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Fault, Given, Index, Pointer, Result, Rows, Work
from symdyn.verify.written.reading import Cut, Language, Read, Reading, Text, Unread, Wanted
from symdyn.verify.written.syntax import line_of, nodes, parse, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

Value = Union[Expr, Index, Pointer, Rows]

FUNCTIONS = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "fabs": Op.ABS,
    "atan2": Op.ATAN2,
}
"""Of <math.h>; those of floats end with f."""

OURS = {"exp_of": Op.EXP, "sign_of": Op.SIGN}
"""Fixed text of the file."""

SINES = "sincos_row"

WHOLE = re.compile(rb"0|[1-9][0-9]*")
EXACT = 2**24
"""Whole numbers below are floats."""

GROUP = 8
"""`sincos_row` takes a multiple of so many angles at least."""

UNKNOWN = re.compile(rb'\b(ALIGNED|ALONE|PART|EACH)\b|(?<=#ifdef __cplusplus\n)(extern "C" \{|\})(?=\n#endif\n)')
"""What grammars know nothing of: macros for attributes and for a loop of fixed text, a brace in a condition."""

PRODUCT = re.compile(rb"\((?=[A-Za-z_][A-Za-z_0-9]* \*)")
"""A parenthesis after which a product may be read as a pointer type of a cast; a plus sign tells them apart."""


def plain(source: bytes) -> bytes:
    """Return a file as the grammar takes it: spaces in place of what it does not know, directives aside."""

    def blank(found: re.Match[bytes]) -> bytes:
        line = source[source.rfind(b"\n", 0, found.start()) + 1 : found.start()]
        return found[0] if line.startswith(b"#") else b" " * len(found[0])

    return UNKNOWN.sub(blank, source)


def read(text: Text) -> Reading:
    """Return what the functions of a C file compute."""
    found: dict[str, Node] = {}
    for node in text.root.children:
        _collect(node, found)
    reader = _File(text, found)
    functions: list[Read] = []
    for wanted in text.wanted:
        for name, columns in ((f"{text.stem}_{wanted.name}", False), (f"{wanted.name}_block", True)):
            if name in found:
                functions.append(reader.function(name, wanted, columns))
    return Reading(tuple(functions), tuple(reader.cuts.values()))


def _collect(node: Node, found: dict[str, Node]) -> None:
    """Add the functions that are defined at the top of a file, or inside its conditions and extern "C"."""
    if node.type in ("preproc_ifdef", "preproc_if", "linkage_specification", "declaration_list"):
        for child in node.children:
            _collect(child, found)
    if node.type != "function_definition":
        return
    declarator = node.child_by_field_name("declarator")
    name = declarator.child_by_field_name("declarator") if declarator is not None else None
    if declarator is None or declarator.type != "function_declarator" or name is None:
        raise unread(node, "is no plain function")
    if said(name) in found:
        raise unread(name, "is defined twice")
    found[said(name)] = node


@dataclass
class _File:
    """A file whose functions are read."""

    text: Text
    functions: Mapping[str, Node]
    grammar: str = "tree_sitter_c"
    cuts: dict[str, Cut] = field(default_factory=dict)

    def function(self, name: str, wanted: Wanted, columns: bool) -> Read:
        """Return what a function computes, for one state, or for state k of a block."""
        node = self.functions[name]
        common = _common(wanted) if columns else ""
        given = {one: Given(one, wanted.arguments[one], columns and one != common) for one in wanted.arguments}
        result = Result(wanted.size, columns, () if columns else tuple(given.values()))
        names: dict[str, Value] = {
            one: memory.entries[0] if one in wanted.scalars and not columns else Pointer(memory)
            for one, memory in given.items()
        }
        expected = [*(["stride"] if columns else []), *wanted.arguments, "out"]
        if parameters(node) != expected:
            raise unread(node, f"takes {', '.join(parameters(node))}, not {', '.join(expected)}")
        names |= {"out": Pointer(result), **({"stride": Index(0, 0, 1)} if columns else {})}
        frame = _Frame(self, wanted, names)
        self.run(name, frame)
        try:
            entries, lines = result.whole()
        except Fault as fault:
            raise Unread(line_of(node), f"{name} {fault}") from None
        lanes = f" {frame.lanes}" if columns else ""
        self.cuts[name] = Cut(self.cuts[name].start, self.cuts[name].end, f"{name}{lanes}")
        return Read(wanted.name, name, entries, lines)

    def run(self, name: str, frame: _Frame) -> None:
        """Read the body of a function, with its parameters bound."""
        if name in self.cuts:
            raise unread(self.functions[name], "is called twice")
        body = self.functions[name].child_by_field_name("body")
        assert body is not None, "a definition has a body"
        self.cuts[name] = Cut(body.start_byte, body.end_byte, name)
        frame.block(body)


def parameters(node: Node) -> list[str]:
    """Return the names of the parameters of a function."""
    declarator = node.child_by_field_name("declarator")
    listed = declarator.child_by_field_name("parameters") if declarator is not None else None
    if listed is None:
        raise unread(node, "has no parameters")
    return [_declared(one) for one in listed.named_children if one.type == "parameter_declaration"]


def _declared(node: Node) -> str:
    """Return the name that a declaration gives, however its type is written around it."""
    names = [said(one) for one in nodes(node) if one.type == "identifier"]
    if len(names) != 1:
        raise unread(node, "is no plain parameter")
    return names[0]


def _common(wanted: Wanted) -> str:
    """Return which argument all states of a block have in common."""
    return next((name for name in wanted.arguments if name in ("params", "prepared")), "")


class _TakenForCast(Exception):  # noqa: N818  a signal
    """The grammar takes a product in parentheses for a type."""


@dataclass
class _Frame:
    """One function that is being read: what its names stand for; each is set once."""

    file: _File
    wanted: Wanted
    names: dict[str, Value]
    lanes: int = 0
    loop: bool = False
    arrays: set[str] = field(default_factory=set)
    again: bool = False

    def block(self, body: Node) -> None:
        """Read all statements of a body."""
        children = body.children
        if len(children) < 2 or children[0].type != "{" or children[-1].type != "}":
            raise unread(body, "is no block")
        for statement in children[1:-1]:
            try:
                self._statement(statement)
            except _TakenForCast:
                self.again = True
                self._statement(self._again(statement))
                self.again = False
            except Fault as fault:
                raise unread(statement, str(fault)) from None

    def _statement(self, node: Node) -> None:
        if node.type == "declaration":
            self._declare(node)
        elif node.type == "expression_statement" and len(node.children) == 2 and node.children[1].type == ";":
            self._act(node.children[0])
        elif node.type == "for_statement":
            self._loop(node)
        elif node.type == "comment" or (node.type == "preproc_call" and said(node).split() == OMP):
            pass
        else:
            raise unread(node, "is no statement that is read here")

    def _again(self, node: Node) -> Node:
        """Return a statement read again: `(a * (b)) - c` is no cast, where a is a number."""
        source = b"\n" * (line_of(node) - 1) + b"void f(void) {" + PRODUCT.sub(b"(+", node.text or b"") + b"}"
        root = parse(self.file.grammar, source)
        body = root.children[-1].child_by_field_name("body")
        if body is None or len(body.children) != 3:
            raise unread(node, "is no statement that is read here")
        return body.children[1]

    # Statements

    def _declare(self, node: Node) -> None:
        """Read `const double x = …;`, `const double a[8] = {…};` or `double w[4], r[4][64];`."""
        kinds = [child.type for child in node.children]
        if kinds == ["type_qualifier", "primitive_type", "init_declarator", ";"]:
            qualifier, real, declarator, _ = node.children
            self._is_real(real)
            if said(qualifier) != "const":
                raise unread(qualifier, "is not const")
            name, equals, value = declarator.children
            if name.type == "identifier":
                self._set(name, self.real(value))
            elif name.type == "array_declarator" and value.type == "initializer_list":
                self._set_array(name, value)
            else:
                raise unread(declarator, "is no declaration that is read here")
            if equals.type != "=":
                raise unread(equals, "is no =")
            return
        if kinds[0] != "primitive_type" or kinds[-1] != ";" or kinds[2:-1:2] != [","] * len(kinds[2:-1:2]):
            raise unread(node, "is no declaration that is read here")
        self._is_real(node.children[0])
        for declarator in node.children[1:-1:2]:
            self._declare_array(declarator)

    def _is_real(self, node: Node) -> None:
        if said(node) != self.file.text.real:
            raise unread(node, f"is not {self.file.text.real}")

    def _declare_array(self, node: Node) -> None:
        inner, size = self._array(node)
        if inner.type == "identifier":
            self._set(inner, Pointer(Work(size)))
            self.arrays.add(said(inner))
            return
        name, rows = self._array(inner)
        self._of_lanes(node, size)
        self._set(name, Rows(tuple(Work(size, row=True) for _ in range(rows))))

    def _array(self, node: Node) -> tuple[Node, int]:
        """Return what is declared an array, and its length."""
        if [child.type for child in node.children[1:]] != ["[", "number_literal", "]"]:
            raise unread(node, "is no array of a known length")
        return node.children[0], self._whole(node.children[2])

    def _set_array(self, declarator: Node, listed: Node) -> None:
        name, size = self._array(declarator)
        memory = Work(size)
        values = [self.real(one) for one in listed.children[1:-1:2]]
        if len(values) != size or any(one.type != "," for one in listed.children[2:-1:2]):
            raise unread(listed, f"is not a list of {size}")
        for place, value in enumerate(values):
            memory.store(Index(place), value, line_of(listed))
        self._set(name, Pointer(memory))

    def _set(self, node: Node, value: Value) -> None:
        if node.type != "identifier":
            raise unread(node, "is no name")
        name = said(node)
        if name in self.names:
            raise unread(node, "has a value already")
        if self.function_of(name) is not None or name in self.file.functions or name in (SINES, "memcpy"):
            raise unread(node, "hides a function")
        self.names[name] = value

    def _act(self, node: Node) -> None:
        if node.type == "assignment_expression":
            left, operator, right = node.children
            if operator.type != "=" or left.type != "subscript_expression":
                raise unread(node, "is no assignment to an entry of an array")
            base, index = self._subscript(left)
            if not isinstance(base, Pointer):
                raise unread(left, "is no entry of an array")
            base.store(index, self.real(right), line_of(node))
        elif node.type == "call_expression":
            self._call(node)
        elif node.type == "cast_expression" and [one.type for one in node.children] == UNUSED:
            if said(node.children[1]) != "void" or said(node.children[3]) not in self.names:
                raise unread(node, "is no word of something unused")
        else:
            raise unread(node, "is no statement that is read here")

    def _loop(self, node: Node) -> None:
        """Read `for (size_t k = 0; k < 64; k++) { … }` for state k; what has been set before is common to all."""
        body = node.child_by_field_name("body")
        head = b"".join((one.text or b"").replace(b" ", b"") for one in node.children[:-1])
        found = re.fullmatch(rb"for\(size_tk=0;k<([0-9]+);k\+\+\)", head)
        if found is None or body is None or self.loop or "k" in self.names or not self.lanes_allowed:
            raise unread(node, "is no loop over the states of a block")
        self._of_lanes(node, int(found[1]))
        self.loop = True
        self.names["k"] = Index(0, 1)
        self.block(body)

    @property
    def lanes_allowed(self) -> bool:
        """Whether the function is about the states of a block."""
        return "stride" in self.names

    def _of_lanes(self, node: Node, lanes: int) -> None:
        """Look whether a number is that of the states of a block."""
        if not self.lanes_allowed or self.lanes not in (0, lanes):
            raise unread(node, "is not of as many states as the block")
        self.lanes = lanes

    def _call(self, node: Node) -> None:
        name, *listed = node.children
        arguments = listed[0].children[1:-1:2] if len(listed) == 1 else []
        if name.type != "identifier" or any(one.type != "," for one in listed[0].children[2:-1:2]):
            raise unread(node, "is no call that is read here")
        called = said(name)
        if called == "memcpy":
            self._copy(node, arguments)
        elif called == SINES and SINES in self.file.functions:
            self._sines(node, arguments)
        elif called in self.file.functions and re.fullmatch(rf"{self.wanted.name}_(part|pass)[0-9]+", called):
            inner = parameters(self.file.functions[called])
            if len(inner) != len(arguments) or len(set(inner)) != len(inner):
                raise unread(node, f"does not give {called} what it takes")
            values = {one: self.value(argument) for one, argument in zip(inner, arguments, strict=True)}
            frame = _Frame(self.file, self.wanted, values, self.lanes)
            self.file.run(called, frame)
            self.lanes = frame.lanes
        else:
            raise unread(node, "is no call that is read here")

    def _copy(self, node: Node, arguments: Sequence[Node]) -> None:
        """Read `memcpy(out, r, sizeof r)`."""
        if len(arguments) != 3 or arguments[2].type != "sizeof_expression":
            raise unread(node, "is no copy that is read here")
        to, source = self.value(arguments[0]), self.value(arguments[1])
        size = arguments[2].children[1:]
        if len(size) != 1 or size[0].type != "identifier" or not {said(size[0]), said(arguments[1])} <= self.arrays:
            raise unread(arguments[2], "is not the size of a local array")
        if said(size[0]) != said(arguments[1]):
            raise unread(arguments[2], f"is not the size of {said(arguments[1])}")
        if not (isinstance(to, Pointer) and isinstance(source, Pointer) and isinstance(source.memory, Work)):
            raise unread(node, "is no copy of a local array")
        values = [source.load(Index(place)) for place in range(source.memory.size)]
        for place, value in enumerate(values):
            to.store(Index(place), value, line_of(node))

    def _sines(self, node: Node, arguments: Sequence[Node]) -> None:
        """Read `sincos_row(count, x, s, c)`: of one state, or of a row of states."""
        if len(arguments) != 4:
            raise unread(node, "is no row of sines")
        count = self._whole(arguments[0])
        angles, sines, cosines = (self.value(one) for one in arguments[1:])
        if not (isinstance(angles, Pointer) and isinstance(sines, Pointer) and isinstance(cosines, Pointer)):
            raise unread(node, "is no row of sines")
        if self.lanes_allowed:
            self._of_lanes(node, count)
            places = [Index(0, 1)]
        else:
            places = [Index(place) for place in range(count)]
        if count % GROUP:
            raise unread(node, f"takes {count} sines, which is no multiple of {GROUP}")
        graph, line = self.file.text.graph, line_of(node)
        for place in places:
            angle = angles.load(place)
            sines.store(place, graph.sin(angle), line)
            cosines.store(place, graph.cos(angle), line)

    # Expressions

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

    def value(self, node: Node) -> Value:
        """Return what an expression is."""
        meaning = VALUES.get(node.type)
        if meaning is None:
            raise unread(node, "is no expression that is read here")
        try:
            return meaning(self, node)
        except Fault as fault:
            raise unread(node, str(fault)) from None

    def _name(self, node: Node) -> Value:
        name = said(node)
        if name not in self.names:
            raise unread(node, "has no value yet")
        return self.names[name]

    def _number(self, node: Node) -> Value:
        source = node.text or b""
        if WHOLE.fullmatch(source):
            return Index(int(source))
        decimal = source.decode("ascii", "replace")
        if decimal[0] in "-+":  # the grammar takes a sign along
            size = self._decimal(node, decimal[1:])
            return -size if decimal[0] == "-" else size
        return self._decimal(node, decimal)

    def _decimal(self, node: Node, decimal: str) -> Expr:
        if self.file.text.real == "float":
            if not decimal.endswith("f"):
                raise unread(node, "is no float")
            decimal = decimal[:-1]
        if decimal.isdigit():
            raise unread(node, "is no decimal number")
        return self.file.text.number(decimal, line_of(node))

    def _whole(self, node: Node) -> int:
        value = self.value(node)
        if not (isinstance(value, Index) and value.plain):
            raise unread(node, "is no whole number")
        return value.units

    def _inner(self, node: Node) -> Value:
        if [one.type for one in node.children[::2]] != ["(", ")"]:
            raise unread(node, "is no expression that is read here")
        return self.value(node.children[1])

    def _unary(self, node: Node) -> Value:
        operator, operand = node.children
        if operator.type == "+":
            return self.real(operand)
        if operator.type != "-":
            raise unread(node, "is no sign of a real number")
        return -self.real(operand)

    def _cast(self, node: Node) -> Value:
        if not self.again:
            raise _TakenForCast
        raise unread(node, "is no expression that is read here")

    def _address(self, node: Node) -> Value:
        operator, operand = node.children
        value = self.value(operand)
        if operator.type != "&" or not isinstance(value, Expr) or operand.type != "identifier":
            raise unread(node, "is not the address of a number")
        return Pointer(Given(said(operand), (value,)))

    def _binary(self, node: Node) -> Value:
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

    def _function(self, node: Node) -> Value:
        name, listed = node.children
        op = self.function_of(said(name)) if name.type == "identifier" else None
        arguments = listed.children[1:-1:2]
        if op is None or any(one.type != "," for one in listed.children[2:-1:2]):
            raise unread(node, "is no function that is read here")
        if len(arguments) != (2 if op is Op.ATAN2 else 1):
            raise unread(node, "has another number of arguments")
        return self.file.text.graph.function(op, *(self.real(one) for one in arguments))

    def function_of(self, name: str) -> Op | None:
        """Return which operation a function is, None if none."""
        if name in self.file.functions:  # nothing of the C library then
            return OURS.get(name)
        if self.file.text.real == "float":
            return FUNCTIONS.get(name[:-1]) if name.endswith("f") else None
        return FUNCTIONS.get(name)

    def _entry(self, node: Node) -> Value:
        base, index = self._subscript(node)
        if isinstance(base, Rows):
            return base.row(index)
        if not isinstance(base, Pointer):
            raise unread(node, "is no entry of an array")
        return base.load(index)

    def _subscript(self, node: Node) -> tuple[Value, Index]:
        if [one.type for one in node.children[1::2]] != ["[", "]"]:
            raise unread(node, "is no entry of an array")
        index = self.value(node.children[2])
        if not isinstance(index, Index):
            raise unread(node.children[2], "is no index")
        return self.value(node.children[0]), index


OMP = ["#pragma", "omp", "simd"]
UNUSED = ["(", "type_descriptor", ")", "identifier"]
WHOLE_OPERATIONS: Mapping[str, Callable[[Index, Index], Index]] = {"+": Index.__add__, "*": Index.__mul__}
OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}
VALUES: Mapping[str, Callable[[_Frame, Node], Value]] = {
    "identifier": _Frame._name,
    "number_literal": _Frame._number,
    "parenthesized_expression": _Frame._inner,
    "unary_expression": _Frame._unary,
    "binary_expression": _Frame._binary,
    "call_expression": _Frame._function,
    "subscript_expression": _Frame._entry,
    "pointer_expression": _Frame._address,
    "cast_expression": _Frame._cast,
}

C = Language("C", "tree_sitter_c", frozenset({"comment"}), read, plain)
