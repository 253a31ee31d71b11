"""The meaning of Python as far as generated files go: one function an output, straight lines, a tuple at the end.

    def _<function>(q, qd, params):        NumPy's begins with `of`, which holds the functions of floats or of arrays
        sin = of.sin
        q_1 = q[0]
        x1 = sin(q_1) * 2.0
        return (
            x1,
        )

Each name is set once. A number is a float, and so is every result; a whole number stands nowhere but in an index. What
hands arguments to these functions, and makes arrays of what they return, is fixed text.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
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
"""Of floats: `/` is no integer division, since no operand is a whole number."""

SMOOTH = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "atan2": Op.ATAN2,
}


CODING = re.compile(rb"^[ \t\f]*#.*?coding[:=]", re.MULTILINE)
"""A comment that Python reads (PEP 263)."""


@dataclass(frozen=True)
class Dialect:
    """How the functions of a module are called.

    Attributes:
        handed: a first parameter that holds functions, which lines of their own take out of it; "" for none.
        package: what is imported and holds functions, called through it; "" for none.
        functions: what they are called there.
        builtins: functions of Python itself.
    """

    handed: str
    package: str
    functions: Mapping[str, Op]
    builtins: Mapping[str, Op]


OF_NUMPY = Dialect("of", "", {**SMOOTH, "sign": Op.SIGN}, {"abs": Op.ABS})
OF_CASADI = Dialect("", "casadi", {**SMOOTH, "sign": Op.SIGN, "fabs": Op.ABS}, {})
OF_HEYOKA = Dialect("", "heyoka", SMOOTH, {})


def read(dialect: Dialect, text: Text) -> TextReading:
    """Return what the functions of a module compute."""
    bound = _bound(text.root)
    if CODING.search(b"\n".join(text.source.splitlines()[:2])):
        raise Unread(1, "a comment says that letters are other letters")
    if dialect.package and [node.type for node in bound.get(dialect.package, [])] != ["import_statement"]:
        raise Unread(1, f"{dialect.package} is not imported, or something else has its name")
    functions: list[Read] = []
    cuts: list[Cut] = []
    for wanted in text.wanted:
        name = f"_{wanted.name}"
        places = bound.get(name, [])
        if not places:
            continue
        if len(places) > 1 or places[0].type != "function_definition":
            raise unread(places[-1], f"is not the one plain function {name}")
        (node,) = places
        body = node.child_by_field_name("body")
        assert body is not None, "a definition has a body"
        try:
            functions.append(_Function(text, wanted, dialect, frozenset(bound)).read(node, body))
        except RecursionError:
            raise unread(node, "nests its expressions too deeply") from None
        cuts.append(Cut(body.start_byte, body.end_byte, name))
    return TextReading(tuple(functions), tuple(cuts))


def _bound(root: Node) -> dict[str, list[Node]]:
    """Return the statements that bind each name of the module, by their type those of definitions and imports."""
    found: dict[str, list[Node]] = {}
    for statement in root.children:
        inner = statement.child_by_field_name("definition")
        for node in (statement, inner) if inner is not None else (statement,):
            name = node.child_by_field_name("name")
            if node.type in ("function_definition", "class_definition") and name is not None:
                found.setdefault(said(name), []).append(statement)
        if statement.type in ("import_statement", "import_from_statement"):
            words = [said(one) for one in nodes(statement) if one.type == "identifier"]
            for word in words if statement.type == "import_statement" else words[1:]:
                found.setdefault(word, []).append(statement)
        if statement.type == "expression_statement" and statement.children[0].type == "assignment":
            left = statement.children[0].child_by_field_name("left")
            for one in nodes(left) if left is not None else ():
                if one.type == "identifier":
                    found.setdefault(said(one), []).append(statement)
    return found


@dataclass
class _Function:
    """A function that is being read: what its names stand for, each set once."""

    text: Text
    wanted: ExpectedFunction
    dialect: Dialect
    bound: frozenset[str]
    names: dict[str, Expr] = field(default_factory=dict)
    calls: dict[str, Op] = field(default_factory=dict)

    def read(self, node: Node, body: Node) -> Read:
        """Return what it computes."""
        taken = [self.dialect.handed] * bool(self.dialect.handed) + [*self.wanted.arguments]
        listed = node.child_by_field_name("parameters")
        found = [said(one) for one in listed.children[1:-1:2]] if listed is not None else []
        plain = ["def", "identifier", "parameters", ":", *("comment",) * (len(node.children) - 5), "block"]
        if found != taken or [one.type for one in node.children] != plain:
            raise unread(node, f"takes {', '.join(found)}, not {', '.join(taken)}")
        statements = [one for one in body.children if one.type != "comment"]
        for statement in statements[:-1]:
            self._statement(statement)
        return self._result(statements[-1])

    def _statement(self, node: Node) -> None:
        """Read `x1 = …`, or `sin = of.sin`."""
        if node.type != "expression_statement" or [one.type for one in node.children] != ["assignment"]:
            raise unread(node, "is no statement that is read here")
        if [one.type for one in node.children[0].children[:2]] != ["identifier", "="] or len(
            node.children[0].children
        ) != 3:
            raise unread(node, "is no assignment that is read here")
        left, _, right = node.children[0].children
        name = said(left)
        if name in self.names or name in self.calls or name in (*self.wanted.arguments, self.dialect.handed):
            raise unread(left, "has a value already")
        if name == self.dialect.package or name in self.dialect.builtins:
            raise unread(left, "hides what is called by this name")
        if self.dialect.handed and right.type == "attribute":
            self.calls[name] = self._handed(right)
        else:
            self.names[name] = self.value(right)

    def _result(self, node: Node) -> Read:
        if node.type != "return_statement" or [one.type for one in node.children] != ["return", "tuple"]:
            raise unread(node, "does not return a tuple")
        inner = [one for one in node.children[1].children[1:-1] if one.type != "comment"]
        listed, commas = inner[::2], inner[1::2]
        if any(one.type != "," for one in commas):
            raise unread(node.children[1], "is no tuple that is read here")
        if len(listed) != self.wanted.size:
            raise unread(node, f"has {len(listed)} entries, not {self.wanted.size}")
        entries = tuple(self.value(one) for one in listed)
        return Read(self.wanted.name, f"_{self.wanted.name}", entries, tuple(line_of(one) for one in listed))

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
        return self.text.number(said(node), line_of(node))

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

    def _entry(self, children: list[Node], node: Node) -> Expr:
        """Return an entry of an argument, which arrays and sequences count from 0."""
        if [one.type for one in children] != ["identifier", "[", "integer", "]"]:
            raise unread(node, "is no entry of an argument")
        entries = self.wanted.arguments.get(said(children[0]))
        digits = said(children[2])
        if entries is None or not (digits.isascii() and digits.isdigit()):
            raise unread(node, "is no entry of an argument")
        if int(digits) >= len(entries):
            raise unread(node, f"is entry {digits} of {said(children[0])}, which has {len(entries)}")
        return entries[int(digits)]

    def _called(self, children: list[Node], node: Node) -> Expr:
        callee, listed = children
        inner = [one for one in listed.children if one.type != "comment"]
        op, arguments = self._function(callee), inner[1:-1:2]
        commas = [one.type for one in inner[2:-1:2]]
        if op is None or listed.type != "argument_list" or any(one != "," for one in commas):
            raise unread(node, "is no function that is read here")
        if len(arguments) != (2 if op is Op.ATAN2 else 1):
            raise unread(node, "has another number of arguments")
        return self.text.graph.function(op, *map(self.value, arguments))

    def _function(self, node: Node) -> Op | None:
        """Return which operation is called, None for none that is known."""
        if node.type == "identifier":
            hidden = said(node) in self.bound
            return self.calls.get(said(node)) or (None if hidden else self.dialect.builtins.get(said(node)))
        children = node.children
        if [one.type for one in children] == ["identifier", ".", "identifier"] and self.dialect.package:
            held = said(children[0]) == self.dialect.package
            return self.dialect.functions.get(said(children[2])) if held else None
        return None

    def _handed(self, node: Node) -> Op:
        """Return which operation `of.sin` is."""
        words = [said(one) for one in node.children]
        if len(words) != 3 or words[:2] != [self.dialect.handed, "."] or words[2] not in self.dialect.functions:
            raise unread(node, "is no function that is read here")
        return self.dialect.functions[words[2]]


VALUES: Mapping[str, Callable[[_Function, list[Node], Node], Expr]] = {
    "identifier": _Function._name,
    "float": _Function._number,
    "parenthesized_expression": _Function._inner,
    "unary_operator": _Function._signed,
    "binary_operator": _Function._binary,
    "subscript": _Function._entry,
    "call": _Function._called,
}
"""Types of nodes that are expressions."""


def _language(title: str, dialect: Dialect) -> ReadLanguage:
    return ReadLanguage(title, "tree_sitter_python", frozenset({"comment"}), partial(read, dialect))


NUMPY = _language("Python with NumPy", OF_NUMPY)
CASADI = _language("Python with CasADi", OF_CASADI)
HEYOKA = _language("Python with heyoka", OF_HEYOKA)
