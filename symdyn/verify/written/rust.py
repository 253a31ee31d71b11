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
from dataclasses import dataclass
from typing import TYPE_CHECKING

from symdyn.graph import Expr, Op
from symdyn.verify.written.memory import Index, MemoryInputs, Pointer, Result, Rows, Work
from symdyn.verify.written.reading import (
    ExpectedFunction,
    Read,
    ReadLanguage,
    Text,
    TextReading,
    kinds,
    line_of,
    nodes,
    text_of,
    unread,
)
from symdyn.verify.written.straight_line import File, Reader, Syntax, Value, takes

if TYPE_CHECKING:
    from tree_sitter import Node

COMMENTS = frozenset({"line_comment", "block_comment"})

SYNTAX = Syntax(
    number="float_literal",
    entry="index_expression",
    arguments="arguments",
    place="integer_literal",
    silent=COMMENTS,
    functions={
        "sine_of": Op.SIN,
        "cosine_of": Op.COS,
        "sqrt_of": Op.SQRT,
        "exp_of": Op.EXP,
        "log_of": Op.LOG,
        "tanh_of": Op.TANH,
        "abs_of": Op.ABS,
        "sign_of": Op.SIGN,
        "select_of": Op.SELECT,
        "atan2_of": Op.ATAN2,
    },
)
"""Functions are those of the file."""

REALS = {"double": "f64", "float": "f32"}

STATE = "k"

K = Index(0, 1)

LARGEST = 1 << 16
"""No memory of a function has more entries."""


def read(text: Text) -> TextReading:
    """Return what the functions of a module compute."""
    functions: dict[str, Node] = {}
    for node in text.root.children:
        named = node.child_by_field_name("name")
        if named is not None and text_of(named) in functions:
            raise unread(named, "is defined twice")
        if named is not None:
            functions[text_of(named)] = node
    file = File(text, functions)
    found = []
    for wanted in text.expected:
        for name, laned in ((wanted.name, False), (f"{wanted.name}_block", True)):
            if name in functions:
                found.append(_read(file, wanted, name, laned))
    return TextReading(tuple(found), tuple(file.cuts.values()))


def _read(file: File, wanted: ExpectedFunction, name: str, laned: bool) -> Read:
    """Return what a function computes, of one state or of a block."""
    parameters, body = _parts(file, name, file.functions[name])
    types = dict(text_of(one).split(": ", 1) for one in parameters.children if one.type == "parameter")
    rows = re.fullmatch(r"&mut \[\[\w+; ([0-9]+)\]; [0-9]+\]", types.get("out", ""))
    reader = RustReader(file, wanted, lanes=int(rows[1]) if laned and rows else 0)
    result = reader.open(columns=laned, apart=True)
    if not (wanted.shape or laned):
        del reader.names["out"]
    for one, value in [*reader.names.items()]:
        size = wanted.size if one == "out" else len(wanted.arguments[one])
        if types.get(one) != reader.kind(value):
            raise unread(parameters, f"has no {one} of {size} entries")
        if isinstance(value, Pointer) and "[[" in types[one]:
            reader.names[one] = Rows(tuple(Pointer(value.memory, Index(0, 0, row)) for row in range(size)))
    takes(parameters, [*types], [*reader.names])
    *statements, last = SYNTAX.meant(body)[1:-1]
    if "out" in reader.names:
        reader.run([*statements, last])
    else:
        reader.run(statements)
        result.store(Index(0), reader.real(last), line_of(body))
    return reader.finished(name, body, result)


def _parts(file: File, name: str, at: Node) -> tuple[Node, Node]:
    """Return parameters and body of a function, which is read by that."""
    node = file.functions.get(name)
    if node is None or node.type != "function_item":
        raise unread(at, f"there is no function {name}")
    parameters, body = (node.child_by_field_name(key) for key in ("parameters", "body"))
    if parameters is None or body is None:
        raise unread(node, "is no whole function")
    if node.child_by_field_name("type_parameters") is not None:
        raise unread(node, "has parameters of types")
    file.cut(name, body)
    return parameters, body


@dataclass
class RustReader(Reader):
    """What only Rust says: names that are set anew, memory of zeros, sines in pairs, loops over the states of a block.

    So many `lanes` stand side by side, 0 for one state.
    """

    syntax = SYNTAX
    lanes: int = 0

    def statement(self, node: Node) -> None:
        inner = node.children[0] if kinds(node.children) == ["for_expression"] else node
        if node.type == "let_declaration":
            self._let(node)
        elif inner.type == "for_expression":
            self._loop(inner)
        elif node.type == "expression_statement" and kinds(node.children) == ["call_expression", ";"]:
            self._part(node.children[0])
        elif node.type == "expression_statement" and kinds(node.children) == ["assignment_expression", ";"]:
            self._assign(node.children[0])
        else:
            super().statement(node)

    def _let(self, node: Node) -> None:
        found = [one for one in kinds(node.children) if one != "mutable_specifier"]
        pattern, value = node.child_by_field_name("pattern"), node.child_by_field_name("value")
        if pattern is None or value is None or found[0] != "let" or found[2:] != ["=", value.type, ";"]:
            raise unread(node, "is no declaration that is read here")
        mutable = len(found) != len(node.children)
        if pattern.type == "_":
            plain = {"tuple_expression", "reference_expression", "identifier", "(", ")", ",", "&"}
            told = {text_of(one) for one in nodes(value) if one.type == "identifier"}
            if {*kinds(nodes(value))} - plain or told - self.names.keys():
                raise unread(node, "is no statement that is read here")
        elif pattern.type == "tuple_pattern":
            names = SYNTAX.listed(pattern, "is no pair of names")
            if len(names) != 2 or mutable:
                raise unread(pattern, "is no pair of names")
            for name, array in zip(names, self._sincos(value), strict=True):
                self.set(name, array)
        elif value.type in ("reference_expression", "array_expression"):
            self.set(pattern, self._memory(value, mutable))
        elif mutable:
            raise unread(node, "may change, which no number does here")
        else:
            self.set(pattern, self.real(value))

    def fresh(self, node: Node) -> str:
        """Return a name that is given to something, or from now on to something else."""
        name = text_of(node)
        if node.type != SYNTAX.name or name in ("out", STATE) or name in self.file.functions or "#" in name:
            raise unread(node, "is no name that is given here")
        if name in self.expected.arguments and name in self.names:
            raise unread(node, "is an argument")
        return name

    def _memory(self, node: Node, mutable: bool) -> Value:
        """Return memory of zeros: `&mut [0.0; 6]`, or `[[0.0; 64]; 6]` that may change."""
        plain = re.fullmatch(r"&mut \[0\.0; ([0-9]+)\]", text_of(node))
        many = re.fullmatch(rf"\[\[0\.0; {self.lanes}\]; ([0-9]+)\]", text_of(node))
        found = many if mutable else plain
        if found is None or (many is not None and not self.lanes) or int(found[1]) > LARGEST:
            raise unread(node, "is no memory that is read here")
        size, zero = int(found[1]), self.file.text.graph.zero
        if many is None:
            return Pointer(Work(size, filled=zero))
        return Rows(tuple(Pointer(Work(1, row=True, filled=zero)) for _ in range(size)))

    def _assign(self, node: Node) -> None:
        left, operator, right = SYNTAX.meant(node)
        if operator.type != "=":
            raise unread(node, "is no assignment that is read here")
        if left.type == "tuple_expression":
            places = SYNTAX.listed(left, "is no pair of rows")
            if len(places) != 2:
                raise unread(left, "is no pair of rows")
            for one, row in zip(places, self._sincos(right), strict=True):
                self._row(one).store(K, row.load(K), line_of(one))
        elif left.type == SYNTAX.signed:
            self._copy(left, right)
        else:
            self.store(left, self.real(right))

    def _copy(self, left: Node, right: Node) -> None:
        to, source = self.names.get(text_of(left)[1:]), self.names.get(text_of(right)[1:])
        stars = text_of(left)[0] == text_of(right)[0] == "*" and right.type == SYNTAX.signed
        if to is None or source is None or not stars or self.kind(to) != self.kind(source):
            raise unread(left, "is no copy of an array")
        self.copy(to, source, left)

    def _loop(self, node: Node) -> None:
        """Read `for k in 0..64 { … }` over all states of a block."""
        pattern, value, body = (node.child_by_field_name(key) for key in ("pattern", "value", "body"))
        if pattern is None or value is None or body is None:
            raise unread(node, "is no whole loop")
        before = self.names
        if not self.lanes or STATE in before or text_of(pattern) != STATE or text_of(value) != f"0..{self.lanes}":
            raise unread(node, "is no loop over the states of a block")
        self.names = {**before, STATE: K}
        self.run(SYNTAX.meant(body)[1:-1])
        self.names = before

    def _part(self, node: Node) -> None:
        """Read the call of a part of this function, which works on the same memory."""
        callee, given = self.call(node)
        if {callee.type, *kinds(given)} != {SYNTAX.name}:
            raise unread(node, "is no call that is read here")
        parameters, body = _parts(self.file, text_of(callee), node)
        found = [one for one in parameters.children if one.type == "parameter"]
        if len(found) != len(given):
            raise unread(node, "has another number of arguments")
        names = {}
        for parameter, one in zip(found, given, strict=True):
            name, kind = text_of(parameter).split(": ", 1)
            value = self.names.get(text_of(one))
            if value is None or kind != self.kind(value):
                raise unread(one, f"is no {kind}")
            names[name] = value
        RustReader(self.file, self.expected, names).run(SYNTAX.meant(body)[1:-1])

    def kind(self, value: Value) -> str:
        """Return the type that a number or an array is handed on as, "" for what is not."""
        real = REALS[self.file.text.real]
        memory = value.memory if isinstance(value, Pointer) else None
        if isinstance(memory, Work):
            return "" if memory.row else f"&mut [{real}; {memory.size}]"
        if isinstance(memory, MemoryInputs | Result):
            entry = f"[{real}; {self.lanes}]" if memory.columns else real
            array = f"[{entry}; {len(memory.entries)}]"
            return f"&{array}" if isinstance(memory, MemoryInputs) else f"&mut {array}"
        return real if isinstance(value, Expr) else ""

    def _sincos(self, node: Node) -> tuple[Pointer, Pointer]:
        """Return sines and cosines: of `&[x, y]`, or of a row of a block."""
        callee, given = self.call(node) if node.type == SYNTAX.called else (node, [])
        if (
            text_of(callee) != "sincos"
            or "sincos" not in self.file.functions
            or kinds(given) != ["reference_expression"]
        ):
            raise unread(node, "is no pair of sines and cosines")
        _, what = given[0].children
        row = what.type != "array_expression"
        if row:
            angles = [self._row(what).load(K)]
        else:
            angles = [self.real(one) for one in SYNTAX.listed(what, "is no list of angles")]
        found = Work(len(angles), row), Work(len(angles), row)
        for op, work in zip((Op.SIN, Op.COS), found, strict=True):
            work.entries.update((place, self.file.text.graph.function(op, x)) for place, x in enumerate(angles))
        return Pointer(found[0]), Pointer(found[1])

    def _row(self, node: Node) -> Pointer:
        """Return a row of a block, `w[1]`, or one number of all states."""
        row = self.value(node) if node.type in (SYNTAX.name, SYNTAX.entry) else None
        if STATE in self.names or not isinstance(row, Pointer):
            raise unread(node, "is no row")
        return row

    def index(self, node: Node) -> Index:
        return K if STATE in self.names and text_of(node) == STATE else super().index(node)

    def called(self, node: Node) -> Value:
        """Return the value of a call; fma(a, b, c) is a b + c."""
        callee, given = self.call(node)
        if text_of(callee) == "fma" and "fma" in self.file.functions and len(given) == 3:
            a, b, c = map(self.real, given)
            return a * b + c
        return super().called(node)

    def function(self, node: Node) -> Op | None:
        return SYNTAX.functions.get(text_of(node)) if text_of(node) in self.file.functions else None


RUST = ReadLanguage("Rust", "tree_sitter_rust", read, comments=COMMENTS)
