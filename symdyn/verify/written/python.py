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
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from symdyn.frozen import dataclass, field
from symdyn.graph import Op
from symdyn.verify.written.reading import (
    Read,
    ReadLanguage,
    Text,
    TextReading,
    Unread,
    kinds,
    line_of,
    nodes,
    text_of,
    unread,
)
from symdyn.verify.written.straight_line import FUNCTIONS, File, Reader, Syntax, takes

if TYPE_CHECKING:
    from tree_sitter import Node

SYNTAX = Syntax(
    number="float", signed="unary_operator", binary="binary_operator", entry="subscript", called="call", place="integer"
)

CODING = re.compile(rb"^[ \t\f]*#.*?coding[:=]", re.MULTILINE)
"""A comment that Python reads (PEP 263)."""


@dataclass(frozen=True)
class Dialect:
    """How the functions of a module are called."""

    handed: str  # a first parameter that holds functions, which lines of their own take out of it; "" for none
    package: str  # what is imported and holds functions, called through it; "" for none
    functions: Mapping[str, Op]  # what they are called there
    builtins: Mapping[str, Op]  # functions of Python itself
    own: Mapping[str, Op] = field(default_factory=dict)  # functions of the module


SMOOTH = {**FUNCTIONS, "atan2": Op.ATAN2}

OF_NUMPY = Dialect("of", "", {**SMOOTH, "pow": Op.POW, "sign": Op.SIGN, "select": Op.SELECT}, {"abs": Op.ABS})
OF_CASADI = Dialect(
    "", "casadi", {**SMOOTH, "sign": Op.SIGN, "fabs": Op.ABS, "power": Op.POW}, {}, {"_select_of": Op.SELECT}
)
OF_HEYOKA = Dialect("", "heyoka", SMOOTH, {}, {"_pow_of": Op.POW})


def read(dialect: Dialect, text: Text) -> TextReading:
    """Return what the functions of a module compute."""
    bound = _bound(text.root)
    if CODING.search(b"\n".join(text.source.splitlines()[:2])):
        raise Unread(1, "a comment says that letters are other letters")
    if dialect.package and kinds(bound.get(dialect.package, [])) != ["import_statement"]:
        raise Unread(1, f"{dialect.package} is not imported, or something else has its name")
    file = File(text, {name: places[-1] for name, places in bound.items()})
    functions = []
    for wanted in text.expected:
        name = f"_{wanted.name}"
        if name in bound:
            if kinds(bound[name]) != ["function_definition"]:
                raise unread(bound[name][-1], f"is not the one plain function {name}")
            functions.append(PythonReader(file, wanted, dialect=dialect).read(name))
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def _bound(root: Node) -> dict[str, list[Node]]:
    """Return the statements that bind each name of the module, by their type those of definitions and imports."""
    found: dict[str, list[Node]] = {}
    for statement in root.children:
        words: list[Node] = []
        inner = statement.child_by_field_name("definition")
        for node in (statement, inner) if inner is not None else (statement,):
            name = node.child_by_field_name("name")
            if node.type in ("function_definition", "class_definition") and name is not None:
                words.append(name)
        if statement.type in ("import_statement", "import_from_statement"):
            imported = [one for one in nodes(statement) if one.type == "identifier"]
            words += imported[statement.type == "import_from_statement" :]
        if statement.type == "expression_statement" and statement.children[0].type == "assignment":
            left = statement.children[0].child_by_field_name("left")
            words += [one for one in nodes(left) if one.type == "identifier"] if left is not None else []
        for word in words:
            found.setdefault(text_of(word), []).append(statement)
    return found


@dataclass
class PythonReader(Reader):
    """What only Python says: functions that are handed in or held by a package, a tuple at the end."""

    syntax = SYNTAX
    dialect: Dialect = OF_NUMPY  # how functions are called
    calls: dict[str, Op] = field(default_factory=dict)  # functions that were taken out of what is handed in

    def read(self, name: str) -> Read:
        node, handed = self.file.functions[name], self.dialect.handed
        taken = [*([handed] if handed else []), *self.expected.arguments]
        listed = node.child_by_field_name("parameters")
        takes(node, [text_of(one) for one in listed.children[1:-1:2]] if listed is not None else [], taken)
        SYNTAX.shaped(node, "is no plain function", "def", "identifier", "parameters", ":", "block")
        self.open(numbers=False)
        del self.names["out"]
        self.file.cut(name, node.children[-1])
        *statements, last = SYNTAX.meant(node.children[-1])
        self.run(statements)
        return self._result(last, name)

    def statement(self, node: Node) -> None:
        """Read `x1 = …`, or `sin = of.sin`."""
        (inner,) = SYNTAX.shaped(node, "is no statement that is read here", "assignment")
        if kinds(inner.children)[:2] != ["identifier", "="] or len(inner.children) != 3:
            raise unread(node, "is no assignment that is read here")
        left, _, right = inner.children
        if text_of(left) in self.calls or text_of(left) == self.dialect.handed:
            raise unread(left, "has a value already")
        if self.dialect.handed and right.type == "attribute":
            words = [text_of(one) for one in right.children]
            if len(words) != 3 or words[:2] != [self.dialect.handed, "."] or words[2] not in self.dialect.functions:
                raise unread(right, "is no function that is read here")
            self.calls[self.fresh(left)] = self.dialect.functions[words[2]]
        else:
            self.set(left, self.real(right))

    def hides(self, name: str) -> bool:
        return name == self.dialect.package or name in self.dialect.builtins

    def _result(self, node: Node, name: str) -> Read:
        if node.type != "return_statement" or kinds(node.children) != ["return", "tuple"]:
            raise unread(node, "does not return a tuple")
        listed = SYNTAX.listed(node.children[1], "is no tuple that is read here")
        if len(listed) != self.expected.size:
            raise unread(node, f"has {len(listed)} entries, not {self.expected.size}")
        return Read(self.expected.name, name, tuple(map(self.real, listed)), tuple(map(line_of, listed)))

    def function(self, node: Node) -> Op | None:
        if node.type == "identifier":
            there = self.dialect.own if text_of(node) in self.file.functions else self.dialect.builtins
            return self.calls.get(text_of(node)) or there.get(text_of(node))
        words = [text_of(one) for one in node.children] if node.type == "attribute" else []
        held = words[:2] == [self.dialect.package, "."] and len(words) == 3
        return self.dialect.functions.get(words[2]) if held else None


def _language(title: str, dialect: Dialect) -> ReadLanguage:
    return ReadLanguage(title, "tree_sitter_python", partial(read, dialect))


NUMPY = _language("Python with NumPy", OF_NUMPY)
CASADI = _language("Python with CasADi", OF_CASADI)
HEYOKA = _language("Python with heyoka", OF_HEYOKA)
