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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from math import prod
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read, ReadLanguage, Text, TextReading, Unread
from symdyn.verify.written.syntax import line_of, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

FUNCTIONS = {
    "sin": Op.SIN,
    "cos": Op.COS,
    "sqrt": Op.SQRT,
    "exp": Op.EXP,
    "log": Op.LOG,
    "tanh": Op.TANH,
    "abs": Op.ABS,
    "sign": Op.SIGN,
}
"""Of `Base`, of one number."""

OF_TWO = {"atan": Op.ATAN2}
"""Of `Base`, of two numbers."""

SINES = "sincos"

OPERATIONS: Mapping[str, Callable[[Expr, Expr], Expr]] = {
    "+": Expr.__add__,
    "-": Expr.__sub__,
    "*": Expr.__mul__,
    "/": Expr.__truediv__,
}

COMMENTS = frozenset({"line_comment", "block_comment"})

CALLED = ("Array", "Base", "DimensionMismatch", "T", "eltype", "float", "length", "promote_type", "size", "throw")
"""What the lines before the arithmetic call by its name, and names that stand for types."""

INBOUNDS = "@inbounds"

FLOAT = "float"
"""Makes a real number of a whole one, which would overflow, and leaves all others as they are."""


def read(text: Text) -> TextReading:
    """Return what the functions of a Julia module compute that write into their first argument."""
    tops = meant(text.root)
    modules = [node for node in tops if node.type == "module_definition"]
    strange = next((node for node in tops if node.type not in ("module_definition", "string_literal")), None)
    if strange is not None or len(modules) != 1:
        raise unread(strange or text.root, "is no file of one module")
    found = _definitions(modules[0])
    functions: list[Read] = []
    cuts: list[Cut] = []
    for wanted in text.wanted:
        name = f"{wanted.name}!" if wanted.shape else wanted.name
        if name in found:
            function = _Function(text, wanted, frozenset(found))
            functions.append(function.read(found[name], name))
            cuts.append(Cut(*function.span, name))
        if wanted.shape:
            _room(found.get(wanted.name), wanted, modules[0])
    return TextReading(tuple(functions), tuple(cuts))


def _room(node: Node | None, requested: ExpectedFunction, module: Node) -> None:
    """Look whether a function makes room for its result and has it filled."""
    if node is None:
        raise unread(meant(module)[1], f"has no function {requested.name}")
    _takes(node, [*requested.arguments])
    room = f"Array{{T}}(undef, {', '.join(map(str, requested.shape))})"
    expected = [f"T = {_type(requested)}", f"return {requested.name}!({', '.join([room, *requested.arguments])})"]
    for one, words in zip_longest(_body(node), expected):
        if one is None or words is None or plain(one) != words:
            raise unread(one or node, f"is not {words}")


def _type(expected: ExpectedFunction) -> str:
    """Return the type of a result."""
    types = [f"{'typeof' if one in expected.scalars else 'eltype'}({one})" for one in expected.arguments]
    return f"float(promote_type({', '.join(types)}))" if types else "Float64"


def _takes(node: Node, expected: Sequence[str]) -> None:
    """Look whether a function has the parameters that it must have."""
    listed = [said(one) for one in meant(meant(_signature(node))[1])[1:-1:2]]
    if listed != [*expected]:
        raise unread(node, f"takes {', '.join(listed)}, not {', '.join(expected)}")


def _body(node: Node) -> list[Node]:
    return [one for one in meant(node) if one.type not in ("function", "signature", "end", ";")]


def plain(node: Node) -> str:
    """Return text with single spaces."""
    return " ".join(said(node).split())


def _definitions(module: Node) -> dict[str, Node]:
    """Return the functions of a module by name; one that has several methods has no single meaning."""
    found: dict[str, Node] = {}
    _, _, *inside, _ = meant(module)
    for node in inside:
        if node.type == "string_literal" and not any(one.type == "string_interpolation" for one in node.children):
            continue  # words about the next function
        if node.type != "function_definition":
            raise unread(node, "is no function, nor words about one")
        called = _signature(node)
        name = said(meant(called)[0])
        if name in found or name in CALLED:
            raise unread(called, "is defined twice")
        found[name] = node
    return found


def _signature(node: Node) -> Node:
    """Return the call that a definition looks like."""
    (signature,) = (one for one in node.children if one.type == "signature")
    inner = meant(signature)[0]
    if inner.type != "call_expression" or meant(inner)[0].type != "identifier":
        raise unread(node, "is no plain function")
    return inner


def meant(node: Node) -> list[Node]:
    """Return the children of a node that mean something."""
    return [one for one in node.children if one.type not in COMMENTS]


@dataclass
class _Function:
    """A function that is being read: what its names stand for, each set once, and the entries of its result."""

    text: Text
    wanted: ExpectedFunction
    local: frozenset[str]
    names: dict[str, Expr] = field(default_factory=dict)
    entries: dict[int, tuple[Expr, int]] = field(default_factory=dict)
    span: tuple[int, int] = (0, 0)

    def read(self, node: Node, name: str) -> Read:
        """Return what it computes."""
        wanted = self.wanted
        _takes(node, [*(["out"] if wanted.shape else []), *wanted.arguments])
        body = _body(node)
        begun = self._checked(body)
        ended = body[-1] if len(body) > begun else node
        if wanted.shape:
            if plain(ended) != "return out":
                raise unread(ended, "does not return out")
            statements = body[begun:-1]
        else:
            statements = body[begun:]
        for statement in statements[: len(statements) - (not wanted.shape)]:
            self._statement(statement)
        if not wanted.shape:
            self._return(ended)
        last = (statements or body)[-1].end_byte
        self.span = (statements[0].start_byte if statements else last, last)
        missing = [place for place in range(wanted.size) if place not in self.entries]
        if missing:
            raise Unread(line_of(node), f"{name} never writes entry {self._index(missing[0])} of the result")
        read = [self.entries[place] for place in range(wanted.size)]
        return Read(wanted.name, name, tuple(one for one, _ in read), tuple(line for _, line in read))

    def _checked(self, body: Sequence[Node]) -> int:
        """Return how many statements look at lengths and set T; each must say what it has to, in this order."""
        wanted = self.wanted
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
            if place >= len(body) or not plain(body[place]).startswith(expected):
                raise unread(body[min(place, len(body) - 1)], f"is not {expected}")
        return len(checks)

    def _return(self, node: Node) -> None:
        """Read `return …` of one number."""
        if node.type != "return_statement" or len(meant(node)) != 2:
            raise unread(node, "does not return a number")
        self.entries[0] = self.value(meant(node)[1]), line_of(node)

    def _unchecked(self, node: Node) -> Node:
        """Return what stands after `@inbounds`."""
        inner = meant(node)
        listed = meant(inner[1]) if len(inner) == 2 else []
        if said(inner[0]) != INBOUNDS or len(listed) != 1:
            raise unread(node, "is no entry without a look at its index")
        return listed[0]

    def _statement(self, node: Node) -> None:
        if node.type == "macrocall_expression":
            node = self._unchecked(node)
        if node.type != "assignment" or [one.type for one in meant(node)[1:2]] != ["operator"]:
            raise unread(node, "is no statement that is read here")
        left, operator, right = meant(node)
        if said(operator) != "=":
            raise unread(operator, "is no assignment")
        if left.type == "index_expression":
            self._store(left, self.value(right))
        elif left.type in ("open_tuple", "tuple_expression"):
            self._both(left, right)
        else:
            self._set(left, self.value(right))

    def _set(self, node: Node, value: Expr) -> None:
        name = said(node)
        if node.type != "identifier":
            raise unread(node, "is no name")
        if name in self.names or name in self.wanted.arguments or name == "out":
            raise unread(node, "has a value already")
        if name in self.local or name in (*FUNCTIONS, *OF_TWO, SINES, *CALLED):
            raise unread(node, "hides a function")
        self.names[name] = value

    def _both(self, left: Node, right: Node) -> None:
        """Read `s1, c1 = sincos(q_1)`."""
        targets = [one for one in meant(left) if one.type not in ("(", ")", ",")]
        called, arguments = self._call(right) if right.type == "call_expression" else ("", [])
        if called != SINES or SINES in self.local or len(targets) != 2 or len(arguments) != 1:
            raise unread(right, "is no sine with its cosine")
        angle = self.value(arguments[0])
        self._set(targets[0], self.text.graph.sin(angle))
        self._set(targets[1], self.text.graph.cos(angle))

    def _store(self, node: Node, value: Expr) -> None:
        name, places = self._places(node)
        lengths = self.wanted.shape or (1,)
        if name != "out" or len(places) != len(lengths):
            raise unread(node, f"is no entry of a result of shape {self.wanted.shape}")
        if any(not 1 <= place <= length for place, length in zip(places, lengths, strict=True)):
            raise unread(node, f"is no entry of a result of shape {self.wanted.shape}")
        number = sum((place - 1) * prod(lengths[axis + 1 :]) for axis, place in enumerate(places))
        if number in self.entries:
            raise unread(node, "is written again")
        self.entries[number] = value, line_of(node)

    def _index(self, number: int) -> str:
        lengths = self.wanted.shape or (1,)
        places = [1 + number // prod(lengths[axis + 1 :]) % length for axis, length in enumerate(lengths)]
        return f"[{', '.join(map(str, places))}]"

    # Expressions

    def value(self, node: Node) -> Expr:
        """Return the number that an expression is."""
        if node.type == "identifier":
            if said(node) not in self.names:
                raise unread(node, "has no value yet")
            return self.names[said(node)]
        if node.type == "parenthesized_expression":
            inner = meant(node)
            if len(inner) != 3 or [inner[0].type, inner[2].type] != ["(", ")"]:
                raise unread(node, "is no expression that is read here")
            return self.value(inner[1])
        if node.type == "unary_expression":
            return self._signed(node)
        if node.type == "binary_expression":
            return self._binary(node)
        if node.type == "call_expression":
            return self._called(node)
        raise unread(node, "is no expression that is read here")

    def _signed(self, node: Node) -> Expr:
        operator, operand = meant(node)
        if operand.type == "argument_list":
            _, *listed, _ = meant(operand)
            if len(listed) != 1:
                raise unread(node, "is no sign of a number")
            (operand,) = listed
        if said(operator) != "-":
            raise unread(node, "is no sign of a number")
        return self.text.negative(self.value(operand), line_of(node))

    def _binary(self, node: Node) -> Expr:
        left, operator, right = meant(node)
        if said(operator) not in OPERATIONS:
            raise unread(node, "is no operation of real numbers")
        try:
            return OPERATIONS[said(operator)](self.value(left), self.value(right))
        except ZeroDivisionError:
            raise unread(node, "divides by zero") from None

    def _given(self, node: Node) -> Expr:
        """Read what `float(…)` takes: an entry of an argument, or an argument that is one number."""
        if node.type == "identifier" and said(node) in self.wanted.scalars:
            return self.wanted.arguments[said(node)][0]
        return self._entry(self._unchecked(node) if node.type == "macrocall_expression" else node)

    def _entry(self, node: Node) -> Expr:
        name, places = self._places(node)
        entries = self.wanted.arguments.get(name)
        if entries is None or name in self.wanted.scalars or len(places) != 1:
            raise unread(node, "is no entry of an argument")
        if self.entries:
            raise unread(node, "is read after the result was written, which may be the same array")
        if not 1 <= places[0] <= len(entries):
            raise unread(node, f"is entry {places[0]} of {name}, which has {len(entries)}")
        return entries[places[0] - 1]

    def _places(self, node: Node) -> tuple[str, list[int]]:
        """Read `name[2, 1]`: places, counted from 1."""
        name, *rest = meant(node) if node.type == "index_expression" else (node,)
        inner = meant(rest[0]) if rest else []
        digits = [said(one) for one in inner[1:-1:2]]
        whole = all(one.type == "integer_literal" and said(one).isdecimal() for one in inner[1:-1:2])
        if name.type != "identifier" or not digits or not whole or any(one.type != "," for one in inner[2:-1:2]):
            raise unread(node, "is no entry of an array")
        return said(name), [int(one) for one in digits]

    def _called(self, node: Node) -> Expr:
        """Return the value of a call; `-(a + b)` is one, too."""
        if meant(node)[0].type == "operator":
            return self._signed(node)
        name, arguments = self._call(node)
        table = OF_TWO if len(arguments) == 2 else FUNCTIONS
        if name == "T" and len(arguments) == 1:
            return self._literal(arguments[0])
        if name == FLOAT and len(arguments) == 1:
            return self._given(arguments[0])
        if name in self.local or name in self.names or name not in table or len(arguments) not in (1, 2):
            raise unread(node, "is no function that is read here")
        return self.text.graph.function(table[name], *map(self.value, arguments))

    def _literal(self, node: Node) -> Expr:
        """Read what `T(…)` converts: a decimal number, with a sign or without."""
        parts = meant(node) if node.type == "unary_expression" else [node]
        if parts[-1].type != "float_literal" or [said(one) for one in parts[:-1]] not in ([], ["-"]):
            raise unread(node, "is no decimal number")
        value = self.text.number(said(parts[-1]), line_of(node))
        return value if len(parts) == 1 else self.text.negative(value, line_of(node))

    def _call(self, node: Node) -> tuple[str, Sequence[Node]]:
        """Return the name and the arguments of a call."""
        name, *rest = meant(node)
        inner = meant(rest[0]) if len(rest) == 1 and rest[0].type == "argument_list" else []
        if name.type != "identifier" or not inner or any(one.type != "," for one in inner[2:-1:2]):
            raise unread(node, "is no call that is read here")
        return said(name), inner[1:-1:2]


JULIA = ReadLanguage("Julia", "tree_sitter_julia", COMMENTS, read)
