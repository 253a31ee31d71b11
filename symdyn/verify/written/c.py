"""The meaning of C as far as generated files go.

    <stem>_<function>            one state; the arguments and the result may be the same array
    <function>_part<n>           a piece of it, read where it is called
    <function>_block             as many states as it says, entry i of state k at [i * stride + k], of the result at
                                 [i * reach + k]
    <function>_pass<n>           one loop over them, read where it is called, for state k
    <function>_places            which entry of a block's result each entry of the result is; one after the last is zero

    <function>_solved            a loop, which is fixed text, over <function>_steps: how many columns, then of every
                                 step the row, its scale, how many terms, and factor and row of each, by places of r;
                                 <function>_turned: how many rows the result is, plus these turned, and what is added to
                                 which of its places; or over pairs of velocities by <function>_chains: of each how
                                 many it depends on, how many of these are of other joints, and all of them

    static const <type> <function>_ground[3] = {...};          numbers that a function goes over in a loop, which is
    static const <type> <function>_joints[n] = {{...}, ...};   fixed text, as the whole numbers are with which a joint
    static const <type> <function>_matrices[m][9] = ...;       begins, before its 16

Where a header is all of a module, all names but the first begin with `<stem>_own_`. All other functions of a file are
fixed text: `sincos_row`, `sincos_rows`, `sign_of`, `exp_of` mean here what they are called, columns and rows of states
are brought to `_block` by what is compared and measured.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from symdyn.dynamics import PairRuns, Velocities
from symdyn.dynamics.mechanism import RowSolve
from symdyn.graph import Expr
from symdyn.verify.written.c_family import SYNTAX, CFile, CReader, blanked, declared_name, parameters
from symdyn.verify.written.memory import Fault, Index, Pointer, Result, Rows, Work
from symdyn.verify.written.reading import (
    ExpectedFunction,
    Read,
    ReadLanguage,
    Text,
    TextReading,
    Unread,
    line_of,
    text_of,
    unread,
)
from symdyn.verify.written.straight_line import takes

if TYPE_CHECKING:
    from tree_sitter import Node

GRAMMAR = "tree_sitter_c"

SINES, ROWS, COPY = "sincos_row", "sincos_rows", "memcpy"
CLEAR = "memset"

GROUP = 8
"""`sincos_row` takes a multiple of so many angles."""

LANES_AT_ONCE = 8
"""`sincos_rows` uses so many rows more, or as many as it has angles."""

TABLES = ("ground", "joints", "matrices")
"""What tables of numbers are called, behind the function's name."""

PLACES = re.compile(r"static const unsigned short \w+\[([0-9]+)\] = \{(.*)\};")
"""A table of whole numbers, as it is written."""

COLUMNS = 8
"""Rows that are solved in a loop are whole vectors of so many columns, and begin where a vector may."""

SPACE = re.compile(rb", (double|float) work\[([0-9]{1,9})\]\)\n\{")
"""How parameters end of a function that is given its work space, of which a line of the cache may be left out."""

LINE = 64
"""Bytes."""

SPACED = re.compile(r"(?:double|float)\*const(w)=aligned_of\(work\);|(?:double|float)\*constr=w\+([0-9]+);")
"""Arrays in that, without their spaces."""

PART = re.compile(r"([0-9]+)\*sizeof\*([a-z]+)")
"""How much of a local array is copied, without its spaces."""

UNKNOWN = re.compile(
    rb"\bSYMDYN_(ALIGNED|ALONE|PART|CROWDED|EACH|APART|SHOWN|INLINED|RESTRICT)\b"
    rb'|(?<=#ifdef __cplusplus\n)(extern "C" \{|\})(?=\n#endif\n)'
)
"""What grammars know nothing of: macros for attributes and for a loop of fixed text, a brace in a condition."""

LOOP = re.compile(r"for\(size_tk=0;k<([0-9]+);k\+\+\)")
"""The head of a loop, without its spaces."""


def read(text: Text) -> TextReading:
    """Return what the functions of a C file compute."""
    file = CFile(text, definitions(text.root), grammar=GRAMMAR)
    functions: list[Read] = []
    for wanted in text.expected:
        if wanted.loop:
            functions += [_table(file, wanted)] if f"{text.stem}_{wanted.name}" in file.functions else []
            continue
        for name, columns in ((f"{text.stem}_{wanted.name}", False), (f"{wanted.name}_block", True)):
            if name in file.functions:
                functions += _function(file, name, wanted, columns)
    return TextReading(tuple(functions), tuple(file.cuts.values()))


def read_columns(text: Text) -> TextReading:
    """Return what the functions of a C file compute whose results are written column by column."""
    found = read(text)
    shapes = {wanted.name: wanted.shape for wanted in text.expected}
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
    node, reader = file.functions[name], CStatements(file, expected)
    space = SPACE.search(file.text.source, node.start_byte, node.end_byte)
    more = ["work"] if space and not columns else []
    takes(node, parameters(node), [*(["stride", "reach"] if columns else []), *expected.arguments, "out", *more])
    result = reader.open(columns, apart=columns, reaching=columns)
    reader.space = int(space[2]) - LINE // (4 if file.text.real == "float" else 8) if space and more else 0
    if columns:
        reader.names.update(stride=Index(0, 0, 1), reach=Index(0, 0, 0, 1))
    reader.body(name)
    places = _places(file, f"{expected.name}_places") if columns else None
    if places is None:
        return [reader.finished(name, node, result)]
    copied = _copied(file, name, expected, result, places)
    if None in result.entries:  # it is written nowhere but in rows
        return [copied]
    return [reader.finished(name, node, result), replace(copied, name=f"{expected.name}_places")]


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
    found = _arrays(file, name)
    if not found:
        return None
    table = PLACES.fullmatch(text_of(found[0]))
    numbers = table[2].split(", ") if table else []
    if len(found) > 1 or table is None or table[1] != str(len(numbers)) or not all(map(str.isdecimal, numbers)):
        raise unread(found[0], "is no table of places")
    return [int(number) for number in numbers]


def _arrays(file: CFile, name: str) -> list[Node]:
    """Return the declarations of an array that has this name, or that of a header's own, and a value."""
    found = []
    for node in outside(file.text.root):
        declared = node.child_by_field_name("declarator") if node.type == "declaration" else None
        while declared is not None and declared.type in ("init_declarator", "array_declarator"):
            declared = declared.child_by_field_name("declarator")
        if declared is not None and file.within(text_of(declared)) == name:
            found.append(node)
    return found


def _table(file: CFile, expected: ExpectedFunction) -> Read:
    """Return the numbers of all tables of a function, in the order of the text."""
    entries: list[Expr] = []
    lines: list[int] = []
    for name in (f"{expected.name}_{ending}" for ending in TABLES):
        for row in (row for node in _arrays(file, name) for row in _rows(node)):
            cells = [one for one in SYNTAX.meant(row) if one.is_named and not text_of(one).isdigit()]
            numbers = [(value, line_of(cell)) for cell in cells for value in _numbers(file, cell)]
            entries += [value for value, _ in numbers]
            lines += [line for _, line in numbers]
            if cells:
                file.cut(f"{name}:{cells[0].start_byte}", cells[0], cells[-1], name)
    return Read(expected.name, expected.name, tuple(entries), tuple(lines))


def _rows(node: Node) -> list[Node]:
    declared = node.child_by_field_name("declarator")
    table = declared.child_by_field_name("value") if declared is not None else None
    if table is None or table.type != "initializer_list":
        raise unread(node, "is no table")
    return [one for one in table.children if one.type == "initializer_list"] or [table]


def _numbers(file: CFile, node: Node) -> Iterator[Expr]:
    if node.type == "initializer_list":
        for one in node.named_children:
            yield from _numbers(file, one)
    elif node.type in ("number_literal", "unary_expression"):
        yield _number(file, "".join(text_of(node).split()), node)
    elif node.type != "comment":
        raise unread(node, "is no number")


def _number(file: CFile, decimal: str, node: Node) -> Expr:
    size = decimal.removeprefix("-")
    value = file.text.number(size.removesuffix("f") if file.text.real == "float" else size, line_of(node))
    return file.text.negative(value, line_of(node)) if size != decimal else value


@dataclass
class CStatements(CReader):
    """What only C says: blocks of states, loops over them, parts; `space` entries to work in, 0 for its own."""

    space: int = 0

    def statement(self, node: Node) -> None:
        if node.type == "for_statement":
            self._loop(node)
        elif self.space and (found := SPACED.fullmatch("".join(text_of(node).split()))):
            self._spaced(node, found)
        elif not (node.type == "preproc_call" and text_of(node).split() == ["#pragma", "omp", "simd"]):
            super().statement(node)

    def perform(self, node: Node) -> None:
        """Read one that sets or copies a whole array, takes sines, or is a part or a loop of this function.

        These are `memset(r, 0, sizeof r)`, `memcpy(out, r, sizeof r)`, `sincos_row(…)` and `sincos_rows(…)`.
        """
        (callee, given), own, within = self.call(node), self.file.own, self.file.within
        name = text_of(callee)
        if name == COPY:
            self._copy(node, given)
        elif name == CLEAR:
            self._clear(node, given)
        elif name == own(f"{self.expected.name}_solved") and name in self.file.functions:
            self._solved(node, given)
        elif name == own(SINES) and name in self.file.functions:
            self._sines(node, given)
        elif name == own(ROWS) and name in self.file.functions:
            self._rows_of_sines(node, given)
        elif name in self.file.functions and re.fullmatch(rf"{self.expected.name}_(part|pass)[0-9]+", within(name)):
            self.piece(node, name)
        else:
            super().perform(node)

    def _spaced(self, node: Node, found: re.Match[str]) -> None:
        """Read which part of its work space an array is: w begins it, r follows and is the rest."""
        before = int(found[2] or 0)
        if (*sorted({"r", "w"} & self.names.keys()),) != ("w",) * bool(found[2]) or before >= self.space:
            raise unread(node, "is no part of the work space")
        if found[2]:
            self.names["w"] = Pointer(Work(before))
        self.names["r" if found[2] else "w"] = Pointer(Work(self.space - before))
        self.arrays["work"] = f"work[{self.space}]"

    def _loop(self, node: Node) -> None:
        found = LOOP.fullmatch("".join("".join(text_of(one).split()) for one in node.children[:-1]))
        if found is None or "k" in self.names or not self.laned:
            raise unread(node, "is no loop over the states of a block")
        self.of_lanes(node, int(found[1]))
        self.names["k"] = Index(0, 1)
        self.block(node.children[-1])

    def _copy(self, node: Node, arguments: list[Node]) -> None:
        if len(arguments) != 3:
            raise unread(node, "is no copy that is read here")
        part = PART.fullmatch("".join(text_of(arguments[2]).split()))
        if part is not None:
            to, source = (self.value(one) for one in arguments[:2])
            count = int(part[1])
            array = self.names.get(part[2])
            if not (isinstance(to, Pointer) and isinstance(source, Pointer) and isinstance(source.memory, Work)):
                raise unread(node, "is no copy of a local array")
            if not (isinstance(array, Pointer) and array.memory is source.memory):
                raise unread(node, "is measured by another array")
            for place in range(count):
                to.store(Index(place), source.load(Index(place)), line_of(node))
            return
        self._whole(arguments[1], arguments[2])
        self.copy(self.value(arguments[0]), self.value(arguments[1]), node)

    def _paired(self, node: Node, ways: list[int], arguments: list[Node]) -> None:
        """Compose the entries of pairs of velocities, whose ways a table has, from numbers in a local array."""
        r, out = (self.value(one) for one in arguments) if len(arguments) == 2 else (None, None)
        if not (isinstance(r, Pointer) and isinstance(r.memory, Work) and isinstance(out, Pointer)):
            raise unread(node, "is no loop over pairs")
        if not r.index == out.index == Index(0):
            raise unread(node, "begins within an array")
        chain, shared = list[tuple[int, ...]](), list[int]()
        while ways:
            many, other, *ways = [*ways, 0, 0] if len(ways) < 2 else ways
            chain.append(tuple(ways[:many]))
            shared.append(many - other)
            if len(chain[-1]) != many or not 0 <= other < many or max(chain[-1]) >= r.memory.size // PairRuns.EACH:
                raise unread(node, "has a table that is none of ways")
            ways = ways[many:]
        numbers = [r.load(Index(k)) for k in range(PairRuns.EACH * len(chain))]
        entries = PairRuns.composed(Velocities(tuple(chain), tuple(shared)), numbers)
        for place, entry in enumerate(entries):
            out.store(Index(place), entry, line_of(node))

    def _solved(self, node: Node, arguments: list[Node]) -> None:
        """Run the steps of a table over the rows of a local array."""
        if ways := _places(self.file, f"{self.expected.name}_chains"):
            self._paired(node, ways, arguments)
            return
        table, turned = (_places(self.file, f"{self.expected.name}_{of}") for of in ("steps", "turned"))
        r = self.value(arguments[0]) if len(arguments) == 1 + bool(turned) else None
        if table is None or not (isinstance(r, Pointer) and isinstance(r.memory, Work) and r.index == Index(0)):
            raise unread(node, "is no loop over rows")
        (width, *rest), at = table, 0
        while at < len(rest):
            step = rest[at : at + 3]
            at += 3 + 2 * rest[at + 2] if len(step) == 3 else len(rest)
            terms = rest[at - 2 * step[2] : at] if at <= len(rest) else ()
            if len(terms) != 2 * step[-1]:
                raise unread(node, "has a table that ends within a step")
            rows, factors = [step[0], *terms[1::2]], [r.load(Index(place)) for place in (step[1], *terms[::2])]
            if any(place % COLUMNS for place in (width, *rows)) or step[0] in rows[1:]:
                raise unread(node, "has rows that are no whole vectors, or takes a row from itself")
            for column in range(width):
                x, *others = (r.load(Index(place + column)) for place in rows)
                found = RowSolve.stepped(x, factors[0], zip(factors[1:], others, strict=True))
                r.store(Index(step[0] + column), found, line_of(node))
        if turned:
            out, (N, *added) = self.value(arguments[1]), turned
            if not (isinstance(out, Pointer) and out.index == Index(0)) or len(added) % 2 or width < N:
                raise unread(node, "has no place for a matrix and the same, turned")
            rows = [r.load(Index(width * i + j)) for i in range(N) for j in range(N)]
            more = ((to, r.load(Index(at))) for to, at in zip(added[::2], added[1::2], strict=True))
            for place, entry in enumerate(RowSolve.added(rows, more)):
                out.store(Index(place), entry, line_of(node))

    def _clear(self, node: Node, arguments: list[Node]) -> None:
        if len(arguments) != 3 or text_of(arguments[1]) != "0":
            raise unread(node, "sets no array to zero")
        part, array = PART.fullmatch("".join(text_of(arguments[2]).split())), self.value(arguments[0])
        if part is None:
            self._whole(arguments[0], arguments[2])
        if not (isinstance(array, Pointer) and isinstance(array.memory, Work)):
            raise unread(node, "sets no local array to zero")
        for place in range(int(part[1]) if part else array.memory.size):
            array.store(Index(place), self.file.text.graph.zero, line_of(node))

    def _whole(self, array: Node, size: Node) -> None:
        """Look whether `size` is that of a local array."""
        measured = size.children[1:] if size.type == "sizeof_expression" else []
        if len(measured) != 1 or not {text_of(measured[0]), text_of(array)} <= self.arrays.keys():
            raise unread(size, "is not the size of a local array")
        if text_of(measured[0]) != text_of(array):
            raise unread(size, f"is not the size of {text_of(array)}")

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


C = ReadLanguage("C", GRAMMAR, read, partial(blanked, unknown=UNKNOWN))
C_BY_COLUMNS = replace(C, read=read_columns)
