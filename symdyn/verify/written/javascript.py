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

from typing import TYPE_CHECKING

from symdyn.graph import Op
from symdyn.verify.written.memory import Index
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

MATH = "Math"

FOR_JS = {**FUNCTIONS, "abs": Op.ABS, "sign": Op.SIGN, "atan2": Op.ATAN2, "pow": Op.POW}

SYNTAX = Syntax(arguments="arguments", functions=FOR_JS)
"""Functions are those of the object Math."""

CHECKS = ("_check", "_number")
"""Functions of the file that throw or do nothing."""

SELECT = "_select"
"""A function of the file."""

RESULT = "out"


def read(text: Text) -> TextReading:
    """Return what the functions of a module or script compute."""
    bound = _bound(_statements(text.root))
    if MATH in bound:
        raise Unread(line_of(bound[MATH][0]), "something of this file is called Math")
    file = File(text, {})
    functions = []
    for wanted in text.expected:
        places = bound.get(wanted.name, [])
        if len(places) > 1:
            raise unread(places[-1], f"is one of several called {wanted.name}")
        functions += [JavaScriptReader(file, wanted).read(place) for place in places]
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def _statements(root: Node) -> list[Node]:
    """Return the statements of a module, or of the one function that a script consists of."""
    plain = SYNTAX.meant(root)
    if len(plain) != 1:
        return plain
    inner = next((one for one in nodes(plain[0]) if one.type == "arrow_function"), None)
    body = inner.child_by_field_name("body") if inner else None
    return plain if body is None else list(body.children)


def _bound(statements: list[Node]) -> dict[str, list[Node]]:
    found: dict[str, list[Node]] = {}
    for statement in statements:
        for one in statement.children if "declaration" in statement.type else ():
            name = one.child_by_field_name("name") if one.type == "variable_declarator" else one
            for word in nodes(name) if name is not None and name.type != "statement_block" else ():
                if "identifier" in word.type:
                    found.setdefault(text_of(word), []).append(statement)
    return found


class JavaScriptReader(Reader):
    """What only JavaScript says: arguments that are checked, functions of Math, a result that is returned."""

    syntax = SYNTAX

    def read(self, node: Node) -> Read:
        why = "is no plain function"
        _, declared, _ = SYNTAX.shaped(node, why, "const", "variable_declarator", ";")
        _, _, function = SYNTAX.shaped(declared, why, "identifier", "=", "arrow_function")
        parameters, _, body = SYNTAX.shaped(function, why, "formal_parameters", "=>", "statement_block")
        taken = [*self.expected.arguments]
        if self.expected.shape:
            taken.append(f"{RESULT} = new Float64Array({self.expected.size})")
        takes(parameters, [text_of(one) for one in SYNTAX.listed(parameters, why)], taken)
        result = self.open()
        if not self.expected.shape:
            del self.names[RESULT]
        lines = SYNTAX.meant(body)[1:-1]
        first = next((k for k, one in enumerate(lines) if not self._checks(one)), len(lines))
        if first == len(lines):
            raise unread(node, "returns nothing")
        self.run(lines[first:-1])
        returned = SYNTAX.meant(lines[-1])
        if kinds(returned)[::2] != ["return", ";"]:
            raise unread(lines[-1], "does not return a result")
        value = returned[1]
        if not self.expected.shape:
            result.store(Index(0), self.real(value), line_of(value))
        elif text_of(value) != RESULT:
            raise unread(lines[-1], f"does not return {RESULT}")
        self.file.cut(self.expected.name, lines[first], lines[-1])
        return self.finished(self.expected.name, lines[-1], result)

    def _checks(self, node: Node) -> bool:
        """Tell whether a statement does nothing but check an argument."""
        if kinds(node.children) != ["call_expression", ";"]:
            return False
        callee, listed = node.children[0].children
        plain = {*kinds(listed.children)} <= {"(", ")", ",", "string", "identifier", "number"}
        return callee.type == "identifier" and text_of(callee) in CHECKS and plain

    def statement(self, node: Node) -> None:
        """Read `const x1 = …;` or `out[0] = …;`."""
        found = SYNTAX.meant(node)
        if kinds(found) == ["const", "variable_declarator", ";"]:
            inner, target = found[1], SYNTAX.name
        elif kinds(found) == ["assignment_expression", ";"]:
            inner, target = found[0], SYNTAX.entry
        else:
            raise unread(node, "is no statement that is read here")
        parts = SYNTAX.meant(inner)
        if kinds(parts)[:2] != [target, "="] or len(parts) != 3:
            raise unread(node, "is no assignment that is read here")
        left, _, right = parts
        if target == SYNTAX.name:
            self.set(left, self.real(right))
        else:
            self.store(left, self.real(right))

    def hides(self, name: str) -> bool:
        return name in (MATH, SELECT)

    def function(self, node: Node) -> Op | None:
        if text_of(node) == SELECT and node.type == SYNTAX.name:
            return Op.SELECT
        parts = SYNTAX.meant(node)
        held = kinds(parts) == ["identifier", ".", "property_identifier"] and text_of(parts[0]) == MATH
        return SYNTAX.functions.get(text_of(parts[2])) if held else None


JAVASCRIPT = ReadLanguage("JavaScript", "tree_sitter_javascript", read)
