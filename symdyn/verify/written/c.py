"""The meaning of C as far as generated files go.

    <stem>_<function>            one state; the arguments and the result may be the same array
    <function>_part<n>           a piece of it, read where it is called
    <function>_block             as many states as it says, entry i of state k at [i * stride + k], of the result at
                                 [i * reach + k]
    <function>_pass<n>           one loop over them, read where it is called, for state k
    <function>_places            which entry of a block's result each entry of the result is; one after the last is zero

    <function>_ground, _joints, _matrices    numbers that a function goes over in a loop, which is fixed text

Where a header is all of a module, all names but the first begin with `<stem>_own_`. All other functions of a file are
fixed text: `sincos_row`, `sincos_rows`, `sign_of`, `exp_of` mean here what they are called, columns and rows of states
are brought to `_block` by what is compared and measured.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from symdyn.verify.written.c_family import CFile, CReader, blanked, declared_name, takes
from symdyn.verify.written.c_rows import copy_part, run_steps
from symdyn.verify.written.c_tables import read_table
from symdyn.verify.written.memory import Fault, Index, Pointer, Result, Rows, Work
from symdyn.verify.written.reading import ExpectedFunction, Read, ReadLanguage, Text, TextReading, Unread
from symdyn.verify.written.straight_line import finished, opened
from symdyn.verify.written.syntax import line_of, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

GRAMMAR = "tree_sitter_c"

SINES, ROWS, COPY = "sincos_row", "sincos_rows", "memcpy"
CLEAR = "memset"

GROUP = 8
"""`sincos_row` takes a multiple of so many angles."""

LANES_AT_ONCE = 8
"""`sincos_rows` uses so many rows more, or as many as it has angles."""

TABLE_OF_STEPS = "steps"
"""What the table of a loop over rows is called, behind the function's name."""

PART = re.compile(r"([0-9]+)\*sizeof\*([a-z]+)")
"""How much of a local array is copied, without its spaces."""

UNKNOWN = re.compile(
    rb"\bSYMDYN_(ALIGNED|ALONE|PART|CROWDED|EACH|SHOWN|INLINED|RESTRICT)\b"
    rb'|(?<=#ifdef __cplusplus\n)(extern "C" \{|\})(?=\n#endif\n)'
)
"""What grammars know nothing of: macros for attributes and for a loop of fixed text, a brace in a condition."""

LOOP = re.compile(r"for\(size_tk=0;k<([0-9]+);k\+\+\)")
"""The head of a loop, without its spaces."""


def read(text: Text) -> TextReading:
    """Return what the functions of a C file compute."""
    file = CFile(text, definitions(text.root), grammar=GRAMMAR)
    functions: list[Read] = []
    for wanted in text.wanted:
        if wanted.loop:
            functions += [read_table(file, wanted)] if f"{text.stem}_{wanted.name}" in file.functions else []
            continue
        for name, columns in ((f"{text.stem}_{wanted.name}", False), (f"{wanted.name}_block", True)):
            if name in file.functions:
                functions += _function(file, name, wanted, columns)
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def read_columns(text: Text) -> TextReading:
    """Return what the functions of a C file compute whose results are written column by column."""
    found = read(text)
    shapes = {wanted.name: wanted.shape for wanted in text.wanted}
    return replace(found, functions=tuple(one.by_rows(shapes[one.function]) for one in found.functions))


def definitions(root: Node) -> dict[str, Node]:
    """Return the functions that are defined in a file by name, inside its conditions and extern "C" too."""
    found: dict[str, Node] = {}
    for node in outside(root):
        if node.type == "function_definition":
            name = declared_name(node)
            if name in found:
                raise unread(node, "is defined twice")
            found[name] = node
    return found


def outside(root: Node) -> Iterator[Node]:
    """Iterate over what stands outside of functions, inside conditions and extern "C" too."""
    stack = [root]
    while stack:
        node = stack.pop()
        if node.type in INSIDE:
            stack += node.children
        else:
            yield node


INSIDE = ("translation_unit", "preproc_ifdef", "preproc_if", "linkage_specification", "declaration_list")


def _function(file: CFile, name: str, expected: ExpectedFunction, columns: bool) -> list[Read]:
    """Return what a function computes, for one state, or for state k of a block: there, and where it is copied to."""
    takes(file, name, [*(["stride", "reach"] if columns else []), *expected.arguments, "out"])
    given = opened(expected, columns, apart=columns, reaching=columns)
    if columns:
        given.names.update(stride=Index(0, 0, 1), reach=Index(0, 0, 0, 1))
    CStatements(file, expected, given.names).body(name)
    places = _places(file, f"{expected.name}_places") if columns else None
    if places is None:
        return [finished(file.functions[name], name, expected, given.result)]
    copied = _copied(file, name, expected, given.result, places)
    if None in given.result.entries:  # it is written nowhere but in rows
        return [copied]
    return [
        finished(file.functions[name], name, expected, given.result),
        replace(copied, name=f"{expected.name}_places"),
    ]


def _copied(file: CFile, name: str, expected: ExpectedFunction, result: Result, places: list[int]) -> Read:
    """Return a result whose entries are those of a block's result at some places."""
    try:
        entries, lines = result.first()
    except Fault as fault:
        raise Unread(line_of(file.functions[name]), f"{name} {fault}") from None
    if len(places) != expected.size or not all(0 <= place <= len(entries) for place in places):
        raise Unread(line_of(file.functions[name]), f"{name} has other entries than {expected.name}_places says")
    entries, lines = (*entries, file.text.graph.zero), (*lines, line_of(file.functions[name]))
    chosen = tuple(entries[place] for place in places), tuple(lines[place] for place in places)
    return Read(expected.name, name, *chosen)


def _places(file: CFile, name: str) -> list[int] | None:
    """Return the numbers of a table of a file, None if there is no such table."""
    declared = [one for one in outside(file.text.root) if one.type == "declaration"]
    found = [one for one in declared if _declares(one, name) or _declares(one, file.prefix + name)]
    if not found:
        return None
    name = name if _declares(found[0], name) else file.prefix + name
    numbers = [said(one) for one in found[0].children[-2].children[-1].children[1:-1:2]]
    table = said(found[0])
    expected = f"static const unsigned short {name}[{len(numbers)}] = {{{', '.join(numbers)}}};"
    if len(found) > 1 or table != expected or not all(number.isdecimal() for number in numbers):
        raise unread(found[0], "is no table of places")
    return [int(number) for number in numbers]


def _declares(node: Node, name: str) -> bool:
    """Return whether a declarator begins with a name."""
    declarators = [one.children[0] for one in node.children if one.type == "init_declarator"]
    return any(one.type == "array_declarator" and said(one.children[0]) == name for one in declarators)


class CStatements(CReader):
    """What only C says: blocks of states, loops over them, parts."""

    def statement(self, node: Node) -> None:
        """Read one statement."""
        if node.type == "for_statement":
            self._loop(node)
        elif not (node.type == "preproc_call" and said(node).split() == ["#pragma", "omp", "simd"]):
            super().statement(node)

    def perform(self, node: Node) -> None:
        """Read one that sets or copies a whole array, takes sines, or is a part or a loop of this function.

        These are `memset(r, 0, sizeof r)`, `memcpy(out, r, sizeof r)`, `sincos_row(…)` and `sincos_rows(…)`.
        """
        (callee, given), own, within = self.call(node), self.file.own, self.file.within
        name = said(callee)
        if name == COPY:
            self._copy(node, given)
        elif name == CLEAR:
            self._clear(node, given)
        elif name == own(f"{self.wanted.name}_solved") and name in self.file.functions:
            self._solved(node, given)
        elif name == own(SINES) and name in self.file.functions:
            self._sines(node, given)
        elif name == own(ROWS) and name in self.file.functions:
            self._rows_of_sines(node, given)
        elif name in self.file.functions and re.fullmatch(rf"{self.wanted.name}_(part|pass)[0-9]+", within(name)):
            self.piece(node, name)
        else:
            super().perform(node)

    def _loop(self, node: Node) -> None:
        """Read a loop for state k; what has been set before is common to all."""
        found = LOOP.fullmatch("".join("".join(said(one).split()) for one in node.children[:-1]))
        if found is None or "k" in self.names or not self.laned:
            raise unread(node, "is no loop over the states of a block")
        self.of_lanes(node, int(found[1]))
        self.names["k"] = Index(0, 1)
        self.block(node.children[-1])

    def _copy(self, node: Node, arguments: list[Node]) -> None:
        if len(arguments) != 3:
            raise unread(node, "is no copy that is read here")
        part = PART.fullmatch("".join(said(arguments[2]).split()))
        if part is not None:
            to, source = (self.value(one) for one in arguments[:2])
            copy_part(node, to, source, int(part[1]), self.names.get(part[2]))
            return
        self._whole(arguments[1], arguments[2])
        self.copy(self.value(arguments[0]), self.value(arguments[1]), node)

    def _solved(self, node: Node, arguments: list[Node]) -> None:
        table = _places(self.file, f"{self.wanted.name}_{TABLE_OF_STEPS}")
        if len(arguments) != 1 or table is None:
            raise unread(node, "is no loop over rows")
        run_steps(node, table, self.value(arguments[0]))

    def _clear(self, node: Node, arguments: list[Node]) -> None:
        if len(arguments) != 3 or said(arguments[1]) != "0":
            raise unread(node, "sets no array to zero")
        self._whole(arguments[0], arguments[2])
        array = self.value(arguments[0])
        if not (isinstance(array, Pointer) and isinstance(array.memory, Work)):
            raise unread(node, "sets no local array to zero")
        for place in range(array.memory.size):
            array.store(Index(place), self.file.text.graph.zero, line_of(node))

    def _whole(self, array: Node, size: Node) -> None:
        """Look whether `size` is that of a local array."""
        measured = size.children[1:] if size.type == "sizeof_expression" else []
        if len(measured) != 1 or not {said(measured[0]), said(array)} <= self.arrays.keys():
            raise unread(size, "is not the size of a local array")
        if said(measured[0]) != said(array):
            raise unread(size, f"is not the size of {said(array)}")

    def _sines(self, node: Node, arguments: list[Node]) -> None:
        """Read `sincos_row(count, x, s, c)`: of one state, or of a row of states."""
        if len(arguments) != 4:
            raise unread(node, "is no row of sines")
        count = self.whole(arguments[0])
        if self.laned:
            self.of_lanes(node, count)
        if count % GROUP:
            raise unread(node, f"takes {count} sines, which is no multiple of {GROUP}")
        places = [Index(0, 1)] if self.laned else [Index(place) for place in range(count)]
        self.sines(node, [self.value(one) for one in arguments[1:]], places)

    def _rows_of_sines(self, node: Node, arguments: list[Node]) -> None:
        """Read `sincos_rows(rows, count, stride, x, w)`: of rows of states, to neighbouring rows of work space."""
        if len(arguments) != 5 or not self.laned:
            raise unread(node, "is no rows of sines")
        rows, count = (self.whole(one) for one in arguments[:2])
        stride, angles, work = (self.value(one) for one in arguments[2:])
        self.of_lanes(node, count)
        if count % GROUP:
            raise unread(node, f"takes {count} sines, which is no multiple of {GROUP}")
        if not (isinstance(stride, Index) and isinstance(angles, Pointer) and isinstance(work, Rows)):
            raise unread(node, "is no rows of sines")
        try:
            work.row(Index(2 * rows + min(rows, LANES_AT_ONCE) - 1))  # what remains waits there
            for row in range(rows):
                given = angles.plus(Index(row) * stride), work.row(Index(2 * row)), work.row(Index(2 * row + 1))
                self.sines(node, given, [Index(0, 1)])
        except Fault as fault:
            raise unread(node, str(fault)) from None


C = ReadLanguage("C", GRAMMAR, frozenset({"comment"}), read, partial(blanked, unknown=UNKNOWN))
C_BY_COLUMNS = replace(C, read=read_columns)
