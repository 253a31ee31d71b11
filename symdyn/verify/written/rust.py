"""The meaning of Rust as far as generated files go: functions of one state, their parts, and blocks of many states.

    pub fn gravity(q: &[f64; 2], out: &mut [f64; 2]) {
        let (sine1, cosine1) = sincos(&[q[0], q[1]]);
        let x1 = fma(sine1[0], 9.81, cosine1[1]);
        out[0] = x1;
        ...

In a block, `for k in 0..64` runs over states; what stands at [k] is that of one of them. `fma`, `sincos` and functions
such as `exp_of` are fixed text of the file, as is what cuts rows of states into blocks. Arguments and results cannot
share memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Union

from symdyn.graph import Expr, Op
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, ReadLanguage, Text, TextReading
from symdyn.verify.written.syntax import line_of, nodes, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}

OURS = {
    "sine_of": Op.SIN,
    "cosine_of": Op.COS,
    "sqrt_of": Op.SQRT,
    "exp_of": Op.EXP,
    "log_of": Op.LOG,
    "tanh_of": Op.TANH,
    "abs_of": Op.ABS,
    "sign_of": Op.SIGN,
    "atan2_of": Op.ATAN2,
}
"""Functions of the file."""

REALS = {"double": "f64", "float": "f32"}

STATE = "k"

LARGEST = 1 << 16
"""No memory of a function has more entries."""

WHOLE = re.compile(r"0|[1-9][0-9]*")


@dataclass
class Array:
    """Numbers of one state.

    Attributes:
        entries: as they are now.
        laned: whether there are many states, so that entries stand at [k] of their rows.
        once: whether each entry is written once, as those of a result are.
        fixed: whether nothing may be written.
        written: by place, the line where it was written.
    """

    entries: list[Expr]
    laned: bool
    once: bool = False
    fixed: bool = False
    written: dict[int, int] = field(default_factory=dict)


Value = Union[Expr, Array]


def read(text: Text) -> TextReading:
    """Return what the functions of a module compute."""
    functions: dict[str, list[Node]] = {}
    for node in text.root.children:
        name = node.child_by_field_name("name")
        if name is not None:
            functions.setdefault(said(name), []).append(node)
    file = _File(text, functions)
    found = []
    for wanted in text.wanted:
        for ending in ("", "_block"):
            if f"{wanted.name}{ending}" in functions:
                found.append(file.function(wanted, f"{wanted.name}{ending}"))
    return TextReading(tuple(found), tuple(file.cuts.values()))


@dataclass
class _File:
    """A file that is being read; `cuts` are the bodies that were."""

    text: Text
    functions: Mapping[str, list[Node]]
    cuts: dict[str, Cut] = field(default_factory=dict)

    def body(self, name: str, at: Node) -> tuple[Node, Node]:
        """Return parameters and body of the one function of a name."""
        places = self.functions.get(name, [])
        if len(places) != 1 or places[0].type != "function_item":
            raise unread(at, f"there is not one function {name}")
        parameters, body = (places[0].child_by_field_name(key) for key in ("parameters", "body"))
        if parameters is None or body is None:
            raise unread(places[0], "is no whole function")
        if places[0].child_by_field_name("type_parameters") is not None:
            raise unread(places[0], "has parameters of types")
        self.cuts[name] = Cut(body.start_byte, body.end_byte, name)
        return parameters, body

    def function(self, requested: ExpectedFunction, name: str) -> Read:
        """Return what a function computes, of one state or of a block."""
        parameters, body = self.body(name, self.functions[name][0])
        real, zero = REALS[self.text.real], self.text.graph.zero
        laned = name != requested.name
        found = dict(said(one).split(": ", 1) for one in parameters.children if one.type == "parameter")
        names: dict[str, Value] = {}
        lanes = 0
        for argument, symbols in requested.arguments.items():
            kind = found.get(argument, "")
            rows = re.fullmatch(rf"&\[\[{real}; ([0-9]+)\]; {len(symbols)}\]", kind)
            row = re.fullmatch(rf"&\[{real}; ([0-9]+)\]", kind) if laned and argument in requested.scalars else None
            if kind == real and argument in requested.scalars and not laned:
                names[argument] = symbols[0]
            elif laned and (rows or row):
                lanes = int((rows or row)[1])  # type: ignore[index]
                names[argument] = Array([*symbols], True, fixed=True)
            elif kind == f"&[{real}; {len(symbols)}]":
                names[argument] = Array([*symbols], False, fixed=True)
            else:
                raise unread(parameters, f"has no {argument} of {len(symbols)} entries")
        expected = [*requested.arguments]
        result = Array([zero] * requested.size, laned, once=True)
        if requested.shape or laned:
            kind = found.get("out", "")
            many = re.fullmatch(rf"&mut \[\[{real}; ([0-9]+)\]; {requested.size}\]", kind)
            if laned and many:
                lanes = int(many[1])
            elif laned or kind != f"&mut [{real}; {requested.size}]":
                raise unread(parameters, f"has no out of {requested.size} entries")
            expected.append("out")
            names["out"] = result
        if [*found] != expected:
            raise unread(parameters, f"is not ({', '.join(expected)})")
        try:
            value = _Function(self, names, lanes).run(body)
        except RecursionError:
            raise unread(body, "nests its expressions too deeply") from None
        if not requested.shape and not laned:
            if value is None:
                raise unread(body, "has no value")
            return Read(requested.name, name, (value,), (line_of(body),))
        missing = [place for place in range(requested.size) if place not in result.written]
        if missing or value is not None:
            raise unread(body, f"leaves entry {missing[0]} as it is" if missing else "has a value")
        return Read(
            requested.name, name, tuple(result.entries), tuple(result.written[k] for k in range(requested.size))
        )


@dataclass
class _Function:
    """A function that is being read: what its names stand for now, how many states stand side by side."""

    file: _File
    names: dict[str, Value]
    lanes: int
    looping: bool = False

    def run(self, body: Node) -> Expr | None:
        """Read statements, and return the value at their end, None for none."""
        statements = [one for one in body.children[1:-1] if "comment" not in one.type]
        for k, node in enumerate(statements):
            if node.type == "let_declaration":
                self._let(node)
            elif node.type == "expression_statement":
                self._statement(node)
            elif node.type == "for_expression":
                self._loop(node)
            elif k == len(statements) - 1:
                return self.value(node)
            else:
                raise unread(node, "is no statement that is read here")
        return None

    def _let(self, node: Node) -> None:
        kinds = [one.type for one in node.children if one.type != "mutable_specifier"]
        pattern, value = node.child_by_field_name("pattern"), node.child_by_field_name("value")
        if pattern is None or value is None or kinds[0] != "let" or kinds[2:] != ["=", value.type, ";"]:
            raise unread(node, "is no declaration that is read here")
        mutable = len(kinds) != len(node.children)
        if pattern.type == "_":
            plain = ("tuple_expression", "reference_expression", "identifier", "(", ")", ",", "&")
            told = [said(one) for one in nodes(value) if one.type == "identifier"]
            if any(one.type not in plain for one in nodes(value)) or any(name not in self.names for name in told):
                raise unread(node, "is no statement that is read here")
        elif pattern.type == "tuple_pattern":
            names = [one for one in pattern.children[1:-1] if one.type != ","]
            if len(names) != 2 or any(one.type != "identifier" for one in names) or mutable:
                raise unread(pattern, "is no pair of names")
            for name, array in zip(names, self._sincos(value), strict=True):
                self._name(name, array)
        elif value.type in ("reference_expression", "array_expression"):
            self._name(pattern, self._memory(value, mutable))
        elif mutable:
            raise unread(node, "may change, which no number does here")
        else:
            self._name(pattern, self.value(value))

    def _name(self, node: Node, value: Value) -> None:
        name = said(node)
        if node.type != "identifier" or name in ("out", STATE) or name in self.file.functions or "#" in name:
            raise unread(node, "is no name that is given here")
        if isinstance(self.names.get(name), Array) and self.names[name].fixed:  # type: ignore[union-attr]
            raise unread(node, "is an argument")
        self.names[name] = value

    def _memory(self, node: Node, mutable: bool) -> Array:
        """Return memory of zeros: `&mut [0.0; 6]`, or `[[0.0; 64]; 6]` that may change."""
        plain = re.fullmatch(r"&mut \[0\.0; ([0-9]+)\]", said(node))
        many = re.fullmatch(rf"\[\[0\.0; {self.lanes}\]; ([0-9]+)\]", said(node))
        found = many if mutable else plain
        if found is None or (many is not None and not self.lanes) or int(found[1]) > LARGEST:
            raise unread(node, "is no memory that is read here")
        return Array([self.file.text.graph.zero] * int(found[1]), mutable)

    def _statement(self, node: Node) -> None:
        if [one.type for one in node.children] not in (["assignment_expression", ";"], ["call_expression", ";"]):
            if [one.type for one in node.children] == ["for_expression"]:
                self._loop(node.children[0])
                return
            raise unread(node, "is no statement that is read here")
        inner = node.children[0]
        if inner.type == "call_expression":
            self._part(inner)
            return
        left, operator, right = inner.children
        if operator.type != "=":
            raise unread(node, "is no assignment that is read here")
        if left.type == "tuple_expression":
            places = [one for one in left.children[1:-1] if one.type != ","]
            if len(places) != 2:
                raise unread(left, "is no pair of rows")
            for one, row in zip(places, self._sincos(right), strict=True):
                self._row(one, row)
        elif left.type == "unary_expression":
            self._copy(left, right)
        else:
            value = self.value(right)
            array, place = self._place(left)
            self._write(array, place, value, left)

    def _copy(self, left: Node, right: Node) -> None:
        """Read `*out = *r`."""
        to, found = self.names.get(said(left)[1:]), self.names.get(said(right)[1:])
        stars = said(left)[0] == said(right)[0] == "*"
        if not (stars and isinstance(to, Array) and isinstance(found, Array) and len(to.entries) == len(found.entries)):
            raise unread(left, "is no copy of an array")
        if to.laned or found.laned or right.type != "unary_expression":
            raise unread(left, "is no copy of an array")
        for place, value in enumerate(found.entries):
            if place not in found.written:
                raise unread(right, f"has no entry {place} yet")
            self._write(to, place, value, left, found.written[place])

    def _row(self, node: Node, array: Array) -> None:
        """Write a row of states: `w[1]` of a block."""
        kinds = [one.type for one in node.children]
        to = self.names.get(said(node.children[0])) if kinds == ["identifier", "[", "integer_literal", "]"] else None
        if not isinstance(to, Array) or not to.laned or not array.laned or self.looping or len(array.entries) != 1:
            raise unread(node, "is no row")
        self._write(to, self._digits(node.children[2]), array.entries[0], node)

    def _write(self, array: Array, place: int, value: Expr, node: Node, line: int = 0) -> None:
        if array.fixed or place >= len(array.entries) or (array.once and place in array.written):
            raise unread(node, "is no entry that may be written, or one that is written already")
        array.entries[place] = value
        array.written[place] = line or line_of(node)

    def _loop(self, node: Node) -> None:
        """Read `for k in 0..64 { … }` over all states of a block."""
        pattern, value, body = (node.child_by_field_name(key) for key in ("pattern", "value", "body"))
        if pattern is None or value is None or body is None:
            raise unread(node, "is no whole loop")
        if not self.lanes or self.looping or said(pattern) != STATE or said(value) != f"0..{self.lanes}":
            raise unread(node, "is no loop over the states of a block")
        inside = _Function(self.file, dict(self.names), self.lanes, looping=True)
        if inside.run(body) is not None:
            raise unread(body, "has a value")

    def _part(self, node: Node) -> None:
        """Read the call of a part of this function, which works on the same memory."""
        callee, listed = node.children
        given = [one for one in listed.children[1:-1] if one.type != ","]
        if callee.type != "identifier" or any(one.type != "identifier" for one in given):
            raise unread(node, "is no call that is read here")
        parameters, body = self.file.body(said(callee), node)
        names, real = {}, REALS[self.file.text.real]
        found = [one for one in parameters.children if one.type == "parameter"]
        if len(found) != len(given):
            raise unread(node, "has another number of arguments")
        for parameter, one in zip(found, given, strict=True):
            name, kind = said(parameter).split(": ", 1)
            value = self.names.get(said(one))
            if isinstance(value, Array):
                wanted = f"&{'' if value.fixed else 'mut '}[{real}; {len(value.entries)}]"
                fits = kind == wanted and not value.laned
            else:
                fits = kind == real and value is not None
            if not fits or value is None:
                raise unread(one, f"is no {kind}")
            names[name] = value
        if _Function(self.file, names, 0).run(body) is not None:
            raise unread(body, "has a value")

    def _sincos(self, node: Node) -> tuple[Array, Array]:
        """Return sines and cosines: of `&[x, y]`, or of a row of a block."""
        kinds = [one.type for one in node.children]
        if kinds != ["identifier", "arguments"] or said(node.children[0]) != "sincos" or "sincos" in self.names:
            raise unread(node, "is no pair of sines and cosines")
        inner = node.children[1].children
        if [one.type for one in inner] != ["(", "reference_expression", ")"] or len(inner[1].children) != 2:
            raise unread(node, "is no pair of sines and cosines")
        what, laned = inner[1].children[1], False
        if what.type == "array_expression":
            listed = [one for one in what.children[1:-1] if one.type != ","]
            if any(said(one) == ";" for one in listed):
                raise unread(what, "is no list of angles")
            angles = [self.value(one) for one in listed]
        else:
            kinds = [one.type for one in what.children]
            array = self.names.get(said(what.children[0])) if kinds and kinds[0] == "identifier" else None
            scalar = self.names.get(said(what)) if what.type == "identifier" else None
            if isinstance(scalar, Array) and scalar.laned and len(scalar.entries) == 1:
                angles = scalar.entries[:]
            elif isinstance(array, Array) and array.laned and kinds == ["identifier", "[", "integer_literal", "]"]:
                angles = [self._entry_of(array, self._digits(what.children[2]), what)]
            else:
                raise unread(what, "is no row of angles")
            laned = True
            if self.looping:
                raise unread(what, "is no row inside of a loop")
        graph = self.file.text.graph
        return Array([graph.sin(x) for x in angles], laned), Array([graph.cos(x) for x in angles], laned)

    # Expressions

    def value(self, node: Node) -> Expr:
        """Return the number that an expression is."""
        meaning = VALUES.get(node.type)
        if meaning is None:
            raise unread(node, "is no expression that is read here")
        return meaning(self, node)

    def _named(self, node: Node) -> Expr:
        value = self.names.get(said(node))
        if not isinstance(value, Expr):
            raise unread(node, "is no number, or none yet")
        return value

    def _number(self, node: Node) -> Expr:
        return self.file.text.number(said(node), line_of(node))

    def _inner(self, node: Node) -> Expr:
        if [one.type for one in node.children[::2]] != ["(", ")"]:
            raise unread(node, "is no expression that is read here")
        return self.value(node.children[1])

    def _signed(self, node: Node) -> Expr:
        operator, operand = node.children
        if operator.type != "-":
            raise unread(node, "is no sign of a number")
        return self.file.text.negative(self.value(operand), line_of(node))

    def _binary(self, node: Node) -> Expr:
        if len(node.children) != 3 or node.children[1].type not in OPERATIONS:
            raise unread(node, "is no operation that is read here")
        left, operator, right = node.children
        try:
            return OPERATIONS[operator.type](self.value(left), self.value(right))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def _digits(self, node: Node) -> int:
        if not WHOLE.fullmatch(said(node)):
            raise unread(node, "is no place")
        return int(said(node))

    def _place(self, node: Node) -> tuple[Array, int]:
        """Return the array and the place of `x[3]`, or of `x[3][k]` of a block."""
        kinds = [one.type for one in node.children]
        if kinds == ["index_expression", "[", "identifier", "]"] and said(node.children[2]) == STATE and self.looping:
            array, place = self._place_of_row(node.children[0])
            if array.laned:
                return array, place
        if kinds == ["identifier", "[", "identifier", "]"] and said(node.children[2]) == STATE and self.looping:
            scalar = self.names.get(said(node.children[0]))
            if isinstance(scalar, Array) and scalar.laned and len(scalar.entries) == 1:
                return scalar, 0
        if kinds == ["identifier", "[", "integer_literal", "]"]:
            array, place = self._place_of_row(node)
            if not array.laned:
                return array, place
        raise unread(node, "is no entry of an array")

    def _place_of_row(self, node: Node) -> tuple[Array, int]:
        kinds = [one.type for one in node.children]
        array = self.names.get(said(node.children[0])) if kinds == ["identifier", "[", "integer_literal", "]"] else None
        if not isinstance(array, Array):
            raise unread(node, "is no entry of an array")
        return array, self._digits(node.children[2])

    def _entry(self, node: Node) -> Expr:
        return self._entry_of(*self._place(node), node)

    def _entry_of(self, array: Array, place: int, node: Node) -> Expr:
        if place >= len(array.entries) or array.once:
            raise unread(node, "is no entry that may be read")
        return array.entries[place]

    def _called(self, node: Node) -> Expr:
        callee, listed = node.children
        name = said(callee)
        given = [self.value(one) for one in listed.children[1:-1] if one.type != ","]
        if callee.type != "identifier" or len(self.file.functions.get(name, [])) != 1 or name in self.names:
            raise unread(node, "is no function that is read here")
        if name == "fma" and len(given) == 3:
            return given[0] * given[1] + given[2]
        op = OURS.get(name)
        if op is None or len(given) != (2 if op is Op.ATAN2 else 1):
            raise unread(node, "is no function that is read here")
        return self.file.text.graph.function(op, *given)


VALUES: Mapping[str, Callable[[_Function, Node], Expr]] = {
    "identifier": _Function._named,
    "float_literal": _Function._number,
    "parenthesized_expression": _Function._inner,
    "unary_expression": _Function._signed,
    "binary_expression": _Function._binary,
    "index_expression": _Function._entry,
    "call_expression": _Function._called,
}
"""Types of nodes that are expressions."""

RUST = ReadLanguage("Rust", "tree_sitter_rust", frozenset({"line_comment", "block_comment"}), read)
