"""Syntax trees, by grammars that others wrote (tree-sitter)."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from symdyn.errors import MissingProgram
from symdyn.extras import install
from symdyn.verify.written.reading import Cut, Unread

if TYPE_CHECKING:
    from tree_sitter import Node, Parser


def parse(grammar: str, source: bytes) -> Node:
    """Return the root of the syntax tree of a file.

    Raises:
        MissingProgram: the grammar is not installed.
        Unread: the file is not of this language.
    """
    root = _parser(grammar).parse(source).root_node
    if root.has_error:
        wrong = next((node for node in nodes(root) if node.is_error or node.is_missing), None)
        wrong = wrong or [node for node in nodes(root) if node.has_error][-1]  # something without a node is missing
        raise Unread(line_of(wrong), f"{words(wrong)} is no syntax of the language")
    return root


@cache
def _parser(grammar: str) -> Parser:
    try:
        from tree_sitter import Language, Parser

        return Parser(Language(import_module(grammar).language()))
    except ImportError as fault:
        raise MissingProgram(f"reading text back needs {grammar}: {install('prove')}") from fault


def nodes(node: Node) -> Iterator[Node]:
    """Iterate over a node and all below it, in the order of the text."""
    cursor = node.walk()
    while True:
        here = cursor.node
        assert here is not None
        yield here
        if cursor.goto_first_child():
            continue
        while not cursor.goto_next_sibling():
            if not cursor.goto_parent():
                return


def line_of(node: Node) -> int:
    """Return where a node begins, counted from 1."""
    return node.start_point[0] + 1


def said(node: Node) -> str:
    """Return the text of a node."""
    return (node.text or b"").decode("utf-8", "replace")


def words(node: Node) -> str:
    """Return the text of a node as an error quotes it."""
    text = " ".join(said(node).split())
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def unread(node: Node, why: str) -> Unread:
    """Return the error that says of a node why it has no meaning."""
    return Unread(line_of(node), f"{words(node)} {why}")


def fixed_text(source: bytes, root: Node, cuts: tuple[Cut, ...], comments: frozenset[str]) -> bytes:
    """Return a file without its comments, with a name in place of everything that was read."""
    spans = [(cut.start, cut.end, b"<%s>" % cut.name.encode()) for cut in cuts]
    silent = [(node.start_byte, node.end_byte, b"") for node in _outside(root, cuts) if node.type in comments]
    parts: list[bytes] = []
    place = 0
    for first, last, name in sorted([*spans, *silent]):
        assert first >= place, "what was read overlaps"
        parts += [source[place:first], name]
        place = last
    return b"".join([*parts, source[place:]])


def _outside(root: Node, cuts: tuple[Cut, ...]) -> Iterator[Node]:
    """Iterate over the nodes that are in no cut."""
    spans = sorted((cut.start, cut.end) for cut in cuts)

    def inside(node: Node) -> bool:
        place = bisect_right(spans, (node.start_byte, root.end_byte))
        return place > 0 and node.end_byte <= spans[place - 1][1]

    stack = [root]
    while stack:
        node = stack.pop()
        yield node
        stack += [one for one in node.children if not inside(one)]
