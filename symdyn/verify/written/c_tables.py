"""Tables of numbers in a file of C, which a function goes over in a loop.

static const <type> <function>_ground[3] = {...};                  three numbers
static const <type> <function>_joints[n] = {{...}, ...};           whole numbers first, which are fixed text; then 16
static const <type> <function>_matrices[m][9] = {{...}, ...};      nine each, where there are any
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from symdyn.graph import Expr
from symdyn.verify.written.c_family import CFile
from symdyn.verify.written.reading import Cut, ExpectedFunction, Read
from symdyn.verify.written.syntax import line_of, said, unread

if TYPE_CHECKING:
    from tree_sitter import Node

INSIDE = ("translation_unit", "preproc_ifdef")
"""What declarations stand in."""

TABLES = ("ground", "joints", "matrices")
"""Names behind that of the function."""


def read_table(file: CFile, expected: ExpectedFunction) -> Read:
    """Return the numbers of all tables of a function, in the order of the text."""
    entries: list[Expr] = []
    lines: list[int] = []
    for ending in TABLES:
        name = f"{expected.name}_{ending}"
        for row in _rows(file, name):
            cells = [one for one in row.named_children if one.type != "comment" and not said(one).isdigit()]
            numbers = [(value, line_of(cell)) for cell in cells for value in _numbers(file, cell)]
            entries += [value for value, _ in numbers]
            lines += [line for _, line in numbers]
            if cells:
                first, last = cells[0].start_byte, cells[-1].end_byte
                file.cuts[f"{name}:{first}"] = Cut(first, last, name)
    return Read(expected.name, expected.name, tuple(entries), tuple(lines))


def _rows(file: CFile, name: str) -> Iterator[Node]:
    """Yield the rows of a table, or the list that is all of it."""
    stack = [file.text.root]
    while stack:
        node = stack.pop()
        stack += node.children if node.type in INSIDE else []
        if node.type != "declaration":
            continue
        declared = node.child_by_field_name("declarator")
        left = declared.child_by_field_name("declarator") if declared is not None else None
        while left is not None and left.type == "array_declarator":
            left = left.child_by_field_name("declarator")
        if declared is None or left is None or file.within(said(left)) != name:
            continue
        table = declared.child_by_field_name("value")
        if table is None or table.type != "initializer_list":
            raise unread(node, "is no table")
        inner = [one for one in table.named_children if one.type == "initializer_list"]
        yield from inner or [table]


def _numbers(file: CFile, node: Node) -> Iterator[Expr]:
    """Yield the numbers of a cell, or of a list of them."""
    if node.type == "initializer_list":
        for one in node.named_children:
            yield from _numbers(file, one)
    elif node.type == "number_literal":
        yield _number(file, said(node), node)
    elif node.type == "unary_expression":
        yield _number(file, "".join(said(node).split()), node)
    elif node.type != "comment":
        raise unread(node, "is no number")


def _number(file: CFile, decimal: str, node: Node) -> Expr:
    """Return the number of a literal with its sign."""
    size = decimal.removeprefix("-")
    value = file.text.number(size.removesuffix("f") if file.text.real == "float" else size, line_of(node))
    return file.text.negative(value, line_of(node)) if size != decimal else value
