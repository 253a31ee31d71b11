"""The meaning of JavaScript as far as generated files go: one function an output, straight lines, entries of `out`.

    const mass_matrix = (q, params, out = new Float64Array(4)) => {
      _check("mass_matrix", "q", q, 2);
      const q_2 = q[1];
      const x1 = Math.cos(q_2) * 2.0;
      out[0] = x1;
      return out;
    };

All numbers are doubles. Each name is set once, by `const`. What is checked of arguments stands before, and is fixed
text like all that is outside of these functions; a script keeps them in one function of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, ReadLanguage, Text, TextReading, Unread
from symdyn.verify.written.syntax import line_of, nodes, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}

MATH = {
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
"""Of the object Math."""

CHECKS = ("_check", "_number")
"""Functions of the file that throw or do nothing."""

RESULT = "out"


def read(text: Text) -> TextReading:
    """Return what the functions of a module or script compute."""
    bound = _bound(_statements(text.root))
    if "Math" in bound:
        raise Unread(line_of(bound["Math"][0]), "something of this file is called Math")
    functions: list[Read] = []
    cuts: list[Cut] = []
    for wanted in text.wanted:
        places = bound.get(wanted.name, [])
        if not places:
            continue
        if len(places) > 1:
            raise unread(places[-1], f"is one of several called {wanted.name}")
        try:
            found, cut = _Function(text, wanted).read(places[0])
        except RecursionError:
            raise unread(places[0], "nests its expressions too deeply") from None
        functions.append(found)
        cuts.append(cut)
    return TextReading(tuple(functions), tuple(cuts))


def _statements(root: Node) -> list[Node]:
    """Return the statements of a module, or of the one function that a script consists of."""
    plain = [one for one in root.children if one.type != "comment"]
    if len(plain) != 1:
        return plain
    inner = next((one for one in nodes(plain[0]) if one.type == "arrow_function"), None)
    body = inner.child_by_field_name("body") if inner else None
    return plain if body is None else list(body.children)


def _bound(statements: list[Node]) -> dict[str, list[Node]]:
    """Return the statements that bind each name."""
    found: dict[str, list[Node]] = {}
    for statement in statements:
        for one in statement.children if "declaration" in statement.type else ():
            name = one.child_by_field_name("name") if one.type == "variable_declarator" else one
            for word in nodes(name) if name is not None and name.type != "statement_block" else ():
                if "identifier" in word.type:
                    found.setdefault(said(word), []).append(statement)
    return found


@dataclass
class _Function:
    """A function that is being read: what its names stand for, each set once, and entries of the result so far."""

    text: Text
    wanted: ExpectedFunction
    names: dict[str, Expr] = field(default_factory=dict)
    written: dict[int, tuple[Expr, int]] = field(default_factory=dict)

    def read(self, node: Node) -> tuple[Read, Cut]:
        """Return what it computes, and where that stands."""
        if [one.type for one in node.children] != ["const", "variable_declarator", ";"]:
            raise unread(node, "is no plain function")
        declared = [one.type for one in node.children[1].children]
        if declared != ["identifier", "=", "arrow_function"]:
            raise unread(node, "is no plain function")
        function = node.children[1].children[2]
        if [one.type for one in function.children] != ["formal_parameters", "=>", "statement_block"]:
            raise unread(node, "is no plain function")
        self._take(function.children[0])
        lines = [one for one in function.children[2].children[1:-1] if one.type != "comment"]
        first = next((k for k, one in enumerate(lines) if not self._checks(one)), len(lines))
        if first == len(lines):
            raise unread(node, "returns nothing")
        for line in lines[first:-1]:
            self._line(line)
        entries = self._returned(lines[-1])
        found = Read(
            self.wanted.name, self.wanted.name, tuple(value for value, _ in entries), tuple(line for _, line in entries)
        )
        return found, Cut(lines[first].start_byte, lines[-1].end_byte, self.wanted.name)

    def _take(self, node: Node) -> None:
        """Read the parameters; a scalar is a number from the beginning."""
        found = [one for one in node.children[1:-1] if one.type not in (",", "comment")]
        names = [said(one) for one in found]
        taken = [*self.wanted.arguments]
        if self.wanted.shape:
            taken.append(f"{RESULT} = new Float64Array({self.wanted.size})")
        if names != taken:
            raise unread(node, f"is not ({', '.join(taken)})")
        for name in self.wanted.scalars:
            (self.names[name],) = self.wanted.arguments[name]

    def _checks(self, node: Node) -> bool:
        """Tell whether a statement does nothing but check an argument."""
        if [one.type for one in node.children] != ["call_expression", ";"]:
            return False
        callee, listed = node.children[0].children
        plain = all(one.type in ("(", ")", ",", "string", "identifier", "number") for one in listed.children)
        return callee.type == "identifier" and said(callee) in CHECKS and plain

    def _line(self, node: Node) -> None:
        """Read `const x1 = …;` or `out[0] = …;`."""
        kinds = [one.type for one in node.children]
        if kinds == ["const", "variable_declarator", ";"]:
            self._name_value(node.children[1])
        elif kinds == ["assignment_expression", ";"] and self.wanted.shape:
            self._write(node.children[0])
        else:
            raise unread(node, "is no statement that is read here")

    def _name_value(self, node: Node) -> None:
        if [one.type for one in node.children[:2]] != ["identifier", "="] or len(node.children) != 3:
            raise unread(node, "is no declaration that is read here")
        name = said(node.children[0])
        if name in self.names or name in (*self.wanted.arguments, RESULT, "Math"):
            raise unread(node, "has a value already")
        self.names[name] = self.value(node.children[2])

    def _write(self, node: Node) -> None:
        if [one.type for one in node.children[:2]] != ["subscript_expression", "="] or len(node.children) != 3:
            raise unread(node, "is no assignment that is read here")
        array, place = self._subscript(node.children[0])
        if array != RESULT:
            raise unread(node, f"writes to {array}")
        if place in self.written or place >= self.wanted.size:
            raise unread(node, f"is not one entry of {self.wanted.size}, or one that is written already")
        value = self.value(node.children[2])
        self.written[place] = value, line_of(node)

    def _returned(self, node: Node) -> list[tuple[Expr, int]]:
        """Return the entries of the result, each with its line."""
        if [one.type for one in node.children][::2] != ["return", ";"] or len(node.children) != 3:
            raise unread(node, "does not return a result")
        if not self.wanted.shape:
            return [(self.value(node.children[1]), line_of(node))]
        if node.children[1].type != "identifier" or said(node.children[1]) != RESULT:
            raise unread(node, f"does not return {RESULT}")
        missing = [place for place in range(self.wanted.size) if place not in self.written]
        if missing:
            raise unread(node, f"comes before entry {missing[0]} is written")
        return [self.written[place] for place in range(self.wanted.size)]

    # Expressions

    def value(self, node: Node) -> Expr:
        """Return the number that an expression is."""
        meaning = VALUES.get(node.type)
        if meaning is None:
            raise unread(node, "is no expression that is read here")
        children = [one for one in node.children if one.type != "comment"] if node.child_count else []
        return meaning(self, children, node)

    def _name(self, _: list[Node], node: Node) -> Expr:
        name = said(node)
        if name not in self.names:
            raise unread(node, "has no value yet")
        return self.names[name]

    def _number(self, _: list[Node], node: Node) -> Expr:
        digits = said(node)
        if digits[:1] == "0" and digits[1:2].isdigit():
            raise unread(node, "is no decimal number")
        return self.text.number(digits, line_of(node))

    def _inner(self, children: list[Node], node: Node) -> Expr:
        if len(children) != 3:
            raise unread(node, "is no expression that is read here")
        return self.value(children[1])

    def _signed(self, children: list[Node], node: Node) -> Expr:
        operator, operand = children
        if operator.type != "-":
            raise unread(node, "is no sign of a number")
        return self.text.negative(self.value(operand), line_of(node))

    def _binary(self, children: list[Node], node: Node) -> Expr:
        left, operator, right = children
        if operator.type not in OPERATIONS:
            raise unread(node, "is no operation that is read here")
        try:
            return OPERATIONS[operator.type](self.value(left), self.value(right))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def _subscript(self, node: Node) -> tuple[str, int]:
        """Return the array and the place of `q[1]`, counted from 0."""
        kinds = [one.type for one in node.children]
        digits = said(node.children[2]) if kinds == ["identifier", "[", "number", "]"] else ""
        if not (digits.isascii() and digits.isdigit()) or (digits[0] == "0" and digits != "0"):
            raise unread(node, "is no entry of an array")
        return said(node.children[0]), int(digits)

    def _entry(self, _: list[Node], node: Node) -> Expr:
        array, place = self._subscript(node)
        entries = self.wanted.arguments.get(array, ())
        if array in self.wanted.scalars or place >= len(entries):
            raise unread(node, "is no entry of an argument")
        if self.written:
            raise unread(node, f"is read after {RESULT} was written, which may be the same array")
        return entries[place]

    def _called(self, children: list[Node], node: Node) -> Expr:
        if len(children) != 2 or children[1].type != "arguments":
            raise unread(node, "is no call that is read here")
        callee, listed = children
        parts = [one.type for one in callee.children]
        if parts != ["identifier", ".", "property_identifier"] or said(callee.children[0]) != "Math":
            raise unread(node, "is no function that is read here")
        op = MATH.get(said(callee.children[2]))
        inner = [one for one in listed.children if one.type != "comment"][1:-1]
        if op is None or any(one.type != "," for one in inner[1::2]):
            raise unread(node, "is no function that is read here")
        if len(inner) != 2 * op.arity - 1:
            raise unread(node, "has another number of arguments")
        return self.text.graph.function(op, *map(self.value, inner[::2]))


VALUES: Mapping[str, Callable[[_Function, list[Node], Node], Expr]] = {
    "identifier": _Function._name,
    "number": _Function._number,
    "parenthesized_expression": _Function._inner,
    "unary_expression": _Function._signed,
    "binary_expression": _Function._binary,
    "subscript_expression": _Function._entry,
    "call_expression": _Function._called,
}
"""Types of nodes that are expressions."""

JAVASCRIPT = ReadLanguage("JavaScript", "tree_sitter_javascript", frozenset({"comment"}), read)
