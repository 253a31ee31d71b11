"""The meaning of Julia as far as generated modules go: straight lines of numbers, a result entry by entry.

    <function>!(out, q, params)    writes a result into `out`; the arguments and the result may be the same array
    <function>(q, params)          returns a result that is one number, or makes room for one and calls the former

Arrays begin at 1, and a matrix is indexed by row and column, whatever its storage. A name is set once and hides no
function. `T(0.5)` is the number nearest to 0.5 of the type T that all arguments have in common; a literal by itself
would be a Float64 whatever they are, and is refused.

What comes before the arithmetic is read word by word: that every argument and the result have their lengths, begin at
1, and which type T is. `@inbounds`, which looks at no index, leans on that.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Index
from symdyn.verify.written.reading import (
    Cut,
    ExpectedFunction,
    Read,
    ReadLanguage,
    Text,
    TextReading,
    kinds,
    line_of,
    spaced,
    text_of,
    unread,
)
from symdyn.verify.written.straight_line import FUNCTIONS, OPERATIONS, File, Reader, Syntax, Value, takes

if TYPE_CHECKING:
    from tree_sitter import Node

COMMENTS = frozenset({"line_comment", "block_comment"})

SYNTAX = Syntax(
    number="",  # those by themselves are of one type
    entry="index_expression",
    place="integer_literal",
    silent=COMMENTS,
    functions={**FUNCTIONS, "abs": Op.ABS, "sign": Op.SIGN, "atan": Op.ATAN2},
    operators={**OPERATIONS, "^": lambda x, y: x.graph.function(Op.POW, x, y)},
)

CALLED = ("Array", "Base", "DimensionMismatch", "T", "eltype", "float", "length", "promote_type", "size", "throw")
"""What the lines before the arithmetic call by its name, and names that stand for types."""

SELECT = "select_of"
"""A function of the module."""

SINES, INBOUNDS, FLOAT = "sincos", "@inbounds", "float"
"""`float` makes a real number of a whole one, which would overflow, and leaves all others as they are."""


def read(text: Text) -> TextReading:
    """Return what the functions of a Julia module compute that write into their first argument."""
    tops = SYNTAX.meant(text.root)
    modules = [node for node in tops if node.type == "module_definition"]
    strange = next((node for node in tops if node.type not in ("module_definition", "string_literal")), None)
    if strange is not None or len(modules) != 1:
        raise unread(strange or text.root, "is no file of one module")
    file = File(text, _definitions(modules[0]))
    functions = []
    for wanted in text.expected:
        name = f"{wanted.name}!" if wanted.shape else wanted.name
        if name in file.functions:
            functions.append(JuliaReader(file, wanted).read(name))
        if wanted.shape:
            _room(file.functions.get(wanted.name), wanted, modules[0])
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def _room(node: Node | None, requested: ExpectedFunction, module: Node) -> None:
    """Look whether a function makes room for its result and has it filled."""
    if node is None:
        raise unread(SYNTAX.meant(module)[1], f"has no function {requested.name}")
    takes(node, _parameters(node), [*requested.arguments])
    room = f"Array{{T}}(undef, {', '.join(map(str, requested.shape))})"
    expected = [f"T = {_type(requested)}", f"return {requested.name}!({', '.join([room, *requested.arguments])})"]
    for one, words in zip_longest(_body(node), expected):
        if one is None or words is None or spaced(one) != words:
            raise unread(one or node, f"is not {words}")


def _type(expected: ExpectedFunction) -> str:
    types = [f"{'typeof' if one in expected.scalars else 'eltype'}({one})" for one in expected.arguments]
    return f"float(promote_type({', '.join(types)}))" if types else "Float64"


def _parameters(node: Node) -> list[str]:
    return [text_of(one) for one in SYNTAX.listed(SYNTAX.meant(_signature(node))[1], "is no plain function")]


def _body(node: Node) -> list[Node]:
    return [one for one in SYNTAX.meant(node) if one.type not in ("function", "signature", "end", ";")]


def _definitions(module: Node) -> dict[str, Node]:
    """Return the functions of a module by name; one that has several methods has no single meaning."""
    found: dict[str, Node] = {}
    _, _, *inside, _ = SYNTAX.meant(module)
    for node in inside:
        if node.type == "string_literal" and not any(one.type == "string_interpolation" for one in node.children):
            continue  # words about the next function
        if node.type != "function_definition":
            raise unread(node, "is no function, nor words about one")
        called = _signature(node)
        name = text_of(SYNTAX.meant(called)[0])
        if name in found or name in CALLED:
            raise unread(called, "is defined twice")
        found[name] = node
    return found


def _signature(node: Node) -> Node:
    (signature,) = (one for one in node.children if one.type == "signature")
    inner = SYNTAX.meant(signature)[0]
    if inner.type != "call_expression" or SYNTAX.meant(inner)[0].type != "identifier":
        raise unread(node, "is no plain function")
    return inner


class JuliaReader(Reader):
    """What only Julia says: places from 1 on without a look at them, numbers made to be of a type, sines in pairs."""

    syntax = SYNTAX

    def function(self, node: Node) -> Op | None:
        ours = text_of(node) == SELECT and SELECT in self.file.functions and SELECT not in self.names
        return Op.SELECT if ours else super().function(node)

    def read(self, name: str) -> Read:
        node, wanted = self.file.functions[name], self.expected
        takes(node, _parameters(node), [*(["out"] if wanted.shape else []), *wanted.arguments])
        body = _body(node)
        begun = self._checked(body)
        ended = body[-1] if len(body) > begun else node
        statements = body[begun : -1 if wanted.shape else None]
        result = self.open(numbers=False, spelled=self._spelled)
        if wanted.shape:
            if spaced(ended) != "return out":
                raise unread(ended, "does not return out")
            self.run(statements)
        else:
            del self.names["out"]
            self.run(statements[:-1])
            if ended.type != "return_statement" or len(SYNTAX.meant(ended)) != 2:
                raise unread(ended, "does not return a number")
            result.store(Index(0), self.real(SYNTAX.meant(ended)[1]), line_of(ended))
        last = (statements or body)[-1].end_byte
        self.file.cuts[name] = Cut(statements[0].start_byte if statements else last, last, name)
        return self.finished(name, node, result)

    def _spelled(self, place: int) -> str:
        return ", ".join(str(1 + one) for one in np.unravel_index(place, self.expected.shape or (1,)))

    def _checked(self, body: Sequence[Node]) -> int:
        """Return how many statements look at lengths and set T; each must say what it has to, in this order."""
        wanted = self.expected
        arrays = [one for one in wanted.arguments if one not in wanted.scalars]
        checks = [f"length({one}) == {len(wanted.arguments[one])} || throw(" for one in arrays]
        if wanted.shape:
            size = f"{', '.join(map(str, wanted.shape))}{',' * (len(wanted.shape) == 1)}"
            checks.append(f"size(out) == ({size}) || throw(")
        one_based = [*(["out"] if wanted.shape else []), *arrays]
        if one_based:
            checks.append(f"Base.require_one_based_indexing({', '.join(one_based)})")
        checks.append(f"T = {_type(wanted)}")
        for place, expected in enumerate(checks):
            if place >= len(body) or not spaced(body[place]).startswith(expected):
                raise unread(body[min(place, len(body) - 1)], f"is not {expected}")
        return len(checks)

    def _unchecked(self, node: Node) -> Node:
        inner = SYNTAX.meant(node)
        listed = SYNTAX.meant(inner[1]) if len(inner) == 2 else []
        if text_of(inner[0]) != INBOUNDS or len(listed) != 1:
            raise unread(node, "is no entry without a look at its index")
        return listed[0]

    def statement(self, node: Node) -> None:
        """Read `x1 = …`, `s1, c1 = sincos(q_1)` or `@inbounds out[1] = …`."""
        if node.type == "macrocall_expression":
            node = self._unchecked(node)
        if node.type != "assignment" or kinds(SYNTAX.meant(node))[1:2] != ["operator"]:
            raise unread(node, "is no statement that is read here")
        left, operator, right = SYNTAX.meant(node)
        if text_of(operator) != "=":
            raise unread(operator, "is no assignment")
        if left.type == SYNTAX.entry:
            self.store(left, self.real(right))
        elif left.type in ("open_tuple", "tuple_expression"):
            self._both(left, right)
        else:
            self.set(left, self.real(right))

    def hides(self, name: str) -> bool:
        return name in (SINES, *CALLED) or super().hides(name)

    def _both(self, left: Node, right: Node) -> None:
        targets = [one for one in SYNTAX.meant(left) if one.type not in ("(", ")", ",")]
        callee, given = self.call(right) if right.type == SYNTAX.called else (right, [])
        if text_of(callee) != SINES or SINES in self.file.functions or len(targets) != 2 or len(given) != 1:
            raise unread(right, "is no sine with its cosine")
        angle = self.real(given[0])
        self.set(targets[0], self.file.text.graph.sin(angle))
        self.set(targets[1], self.file.text.graph.cos(angle))

    def entry(self, node: Node) -> Value:
        """Refuse an entry by itself, which may be a whole number."""
        raise unread(node, "is no expression that is read here")

    def subscript(self, node: Node) -> tuple[Value, Index]:
        """Return the array and the index of `x[2, 1]`, which count from 1."""
        name, listed = SYNTAX.shaped(node, "is no entry of an array", "identifier", "vector_expression")
        base, places = self.value(name), SYNTAX.listed(listed, "is no entry of an array")
        index = [self.index(one).units - 1 for one in places]
        shape = (
            self.expected.shape if text_of(name) == "out" else (len(self.expected.arguments.get(text_of(name), ())),)
        )
        if len(index) != len(shape) or any(not 0 <= k < length for k, length in zip(index, shape, strict=True)):
            raise unread(node, f"is no entry of an array of shape {shape}")
        return base, Index(int(np.ravel_multi_index(index, shape)))

    def called(self, node: Node) -> Value:
        """Return the value of a call; `-(a + b)` is one, too."""
        if SYNTAX.meant(node)[0].type == "operator":
            return self.signed(node)
        callee, given = self.call(node)
        if text_of(callee) == "T" and len(given) == 1:
            return self._literal(given[0])
        if text_of(callee) == FLOAT and len(given) == 1:
            return self._given(given[0])
        return super().called(node)

    def _literal(self, node: Node) -> Expr:
        """Read what `T(…)` converts: a decimal number, with a sign or without."""
        parts = SYNTAX.meant(node) if node.type == SYNTAX.signed else [node]
        if parts[-1].type != "float_literal" or [text_of(one) for one in parts[:-1]] not in ([], ["-"]):
            raise unread(node, "is no decimal number")
        value = self.file.text.number(text_of(parts[-1]), line_of(node))
        return value if len(parts) == 1 else self.file.text.negative(value, line_of(node))

    def _given(self, node: Node) -> Value:
        """Read what `float(…)` takes: an entry of an argument, or an argument that is one number."""
        if node.type == SYNTAX.name and text_of(node) in self.expected.scalars:
            return self.expected.arguments[text_of(node)][0]
        return super().entry(self._unchecked(node) if node.type == "macrocall_expression" else node)


JULIA = ReadLanguage("Julia", "tree_sitter_julia", read, comments=COMMENTS)
