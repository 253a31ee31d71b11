"""Readers of generated files, chosen by the end of a file's name, and what they read of a C++ header.

Generated C++ headers are templates over the type T of real numbers:

    raw::<function>          one state, by addresses; the arguments and the result may be the same array
    own::<function>_part<n>  a piece of it, read where it is called

`own::sincos_row<n>`, `own::exp_of`, `own::sign_of` and the functions with lengths in types are fixed text. Constants
are doubles that T is made of.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from symdyn.graph import Op
from symdyn.verify.written.c import C_BY_COLUMNS, C
from symdyn.verify.written.c_family import MATH, OURS, CFile, CReader, blanked, declared_name, parameters
from symdyn.verify.written.javascript import JAVASCRIPT
from symdyn.verify.written.julia import JULIA
from symdyn.verify.written.kernels import CUDA, OPENCL
from symdyn.verify.written.matlab import MATLAB
from symdyn.verify.written.memory import Index, Pointer, Work
from symdyn.verify.written.python import CASADI, HEYOKA, NUMPY
from symdyn.verify.written.reading import ReadLanguage, Text, TextReading, text_of, unread
from symdyn.verify.written.rust import RUST
from symdyn.verify.written.straight_line import Value, takes

if TYPE_CHECKING:
    from tree_sitter import Node


GRAMMAR = "tree_sitter_cpp"

UNKNOWN = re.compile(rb"^SYMDYN_PACK .*$|\b(SYMDYN_PART|SYMDYN_EACH|__restrict)\b", re.MULTILINE)
"""What the grammar knows nothing of: macros for attributes, loops and operators of fixed text, a word of compilers."""

STANDARD = {**MATH, "abs": Op.ABS}
"""Of <cmath>, once they are named by `using`."""

SINES = re.compile(r"own::sincos_row<([1-9][0-9]*)>")
LOOP = re.compile(r"for\(std::size_ti=0;i<([0-9]+);i\+\+\)\{(\w+)\[i\]=(\w+)\[i\];\}")
NOTHING = re.compile(r"T\*constw=nullptr;")


def read(text: Text) -> TextReading:
    """Return what the functions of a C++ header compute."""
    file = CFile(text, _definitions(text.root), grammar=GRAMMAR)
    functions = []
    for wanted in text.expected:
        name = f"raw::{wanted.name}"
        if name in file.functions:
            node, reader = file.functions[name], CppStatements(file, wanted)
            takes(node, parameters(node), [*wanted.arguments, "out"])
            result = reader.open()
            reader.body(name)
            functions.append(reader.finished(name, node, result))
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def _definitions(root: Node) -> dict[str, Node]:
    """Return the functions of the namespaces `raw` and `own` by their qualified names."""
    found: dict[str, Node] = {}
    again: set[str] = set()
    stack = [(root, "")]
    while stack:
        node, space = stack.pop()
        if node.type == "namespace_definition":
            name = node.child_by_field_name("name")
            inner = text_of(name) if name is not None and text_of(name) in ("raw", "own") else ""
            stack += [(child, inner) for child in node.children]
        elif node.type in INSIDE:
            stack += [(child, space) for child in node.children]
        elif node.type == "function_definition" and space:
            name_in_space = f"{space}::{declared_name(node)}"
            if name_in_space in found:
                again.add(name_in_space)
            found[name_in_space] = node
    for name_in_space in again:
        if name_in_space != "own::sincos_row":  # of every type one
            raise unread(found[name_in_space], "is defined twice")
    return found


INSIDE = ("translation_unit", "preproc_ifdef", "preproc_if", "declaration_list", "template_declaration")


@dataclass
class CppStatements(CReader):
    """What only C++ says: the type T, functions looked up by `using`."""

    used: set[str] = field(default_factory=set)

    @property
    def real_word(self) -> str:
        """What the type of real numbers is called."""
        return "T"

    def statement(self, node: Node) -> None:
        words = "".join(text_of(node).split())
        copied = LOOP.fullmatch(words) if node.type == "for_statement" else None
        if node.type == "using_declaration" and words.startswith("usingstd::") and words[10:-1] in STANDARD:
            self._use(node, words[10:-1])
        elif copied is not None:
            self._copy(node, int(copied[1]), copied[2], copied[3])
        elif node.type == "declaration" and NOTHING.fullmatch(words):
            self.set(node.children[1].children[0].children[-1], Pointer(Work(0)))
        else:
            super().statement(node)

    def _use(self, node: Node, name: str) -> None:
        if name in self.names:
            raise unread(node, "hides a name")
        self.used.add(name)

    def function_of(self, name: str) -> Op | None:
        if name.startswith("own::") and name in self.file.functions:
            return OURS.get(name[5:])
        return STANDARD.get(name) if name in self.used else None

    def called(self, node: Node) -> Value:
        """Return the value of a call; T(0.5) is a number."""
        if text_of(node.children[0]) != "T":
            return super().called(node)
        _, given = self.call(node)
        if len(given) != 1 or given[0].type != "number_literal":
            raise unread(node, "is no constant")
        return self.converted(node, super().number(given[0]))

    def number(self, node: Node) -> Value:
        """Return a whole number; a double is none by itself, but what a T is made of."""
        value = super().number(node)
        if not isinstance(value, Index):
            raise unread(node, "is a double, and no T")
        return value

    def perform(self, node: Node) -> None:
        """Read `own::sincos_row<n>(…)`, or a part of this function."""
        callee, given = self.call(node)
        name = "".join(text_of(callee).split())
        row = SINES.fullmatch(name)
        if row is not None and "own::sincos_row" in self.file.functions and len(given) == 3:
            values = [self.value(one) for one in given]
            sizes = {one.memory.size for one in values if isinstance(one, Pointer) and isinstance(one.memory, Work)}
            if len(sizes) != 1 or not {text_of(one) for one in given} <= self.arrays.keys():
                raise unread(node, "does not take three arrays of one length")
            self.sines(node, values, [Index(place) for place in range(int(row[1]))])
        elif name in self.file.functions and re.fullmatch(rf"own::{self.expected.name}_part[0-9]+", name):
            self.piece(node, name)
        else:
            super().perform(node)

    def _copy(self, node: Node, count: int, to: str, source: str) -> None:
        if to not in self.names or source not in self.arrays:
            raise unread(node, "is no copy of a local array")
        values = self.names[source]
        if not (isinstance(values, Pointer) and isinstance(values.memory, Work) and values.memory.size == count):
            raise unread(node, "is no copy of a whole array")
        self.copy(self.names[to], values, node)


CPP = ReadLanguage("C++", GRAMMAR, read, partial(blanked, unknown=UNKNOWN))


READERS: Mapping[str, Mapping[str, ReadLanguage]] = {
    "numpy": {".py": NUMPY},
    "c": {".c": C, ".h": C},
    "js": {".mjs": JAVASCRIPT, ".js": JAVASCRIPT},
    "casadi": {".py": CASADI, ".c": C},
    "heyoka": {".py": HEYOKA},
    "matlab": {".m": MATLAB},
    "cpp": {".hpp": CPP},
    "julia": {".jl": JULIA},
    "rust": {".rs": RUST},
    "gpu": {".cu": CUDA, ".cl": OPENCL},
}
"""Target: ending of a file: what it is read as. Other files of a target are fixed text."""

OTHERWISE: Mapping[tuple[str, str], Mapping[str, ReadLanguage]] = {
    ("matlab", "mex"): {".c": C_BY_COLUMNS, ".h": C}  # its .m files hand on what they are given
}
"""Target and option whose files are read otherwise."""


def languages(target: str, option: str) -> Mapping[str, ReadLanguage]:
    """Return what the files of a target with an option are read as, by the ends of their names."""
    return OTHERWISE.get((target, option), READERS[target])
