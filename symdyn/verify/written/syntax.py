"""Syntax trees, by grammars that others wrote (tree-sitter)."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator
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


STRANGE = re.compile(r"\\[ \t]+$|[0-9]{1001}", re.MULTILINE)
"""A backslash before spaces, which joins lines for some compilers; a number without end."""

NO_CODE = re.compile(r"[^\x00-\x7f]|\\")
"""What no part that is read holds."""


def letters(source: bytes, cut: Cut | None = None) -> None:
    """Look whether a file is written in letters that mean the same to its grammar and to all who run it.

    Invisible ones do not: a carriage return ends a comment here and not there. In a part that is read, a name of other
    letters than ASCII may be the same as one of ASCII, and a backslash may join or spell tokens.

    Raises:
        Unread: it is not.
    """
    first, part = (0, source) if cut is None else (cut.start, source[cut.start : cut.end])
    try:
        text = part.decode("utf-8")
    except UnicodeDecodeError as fault:
        raise Unread(source.count(b"\n", 0, first + fault.start) + 1, "is not UTF-8") from None
    wrong = STRANGE.search(text) if cut is None else NO_CODE.search(text)
    place = wrong.start() if wrong else _invisible(text)
    if place is not None:
        line = source.count(b"\n", 0, first) + text.count("\n", 0, place) + 1
        raise Unread(line, f"{text[place : place + 1]!r} may mean something else to those who run it")


def _invisible(text: str) -> int | None:
    """Return where a letter is that nobody sees, None if all lines are plain."""
    if text.replace("\n", "").replace("\t", "").isprintable():
        return None
    return next(k for k, one in enumerate(text) if not (one.isprintable() or one in "\n\t"))


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


def kinds(nodes: Iterable[Node]) -> list[str]:
    """Return what the grammar calls some nodes."""
    return [node.type for node in nodes]


def line_of(node: Node) -> int:
    """Return where a node begins, counted from 1."""
    return node.start_point[0] + 1


def text_of(node: Node) -> str:
    """Return the text of a node."""
    return (node.text or b"").decode("utf-8", "replace")


def spaced(node: Node) -> str:
    """Return the text of a node with single spaces."""
    return " ".join(text_of(node).split())


def words(node: Node) -> str:
    """Return the text of a node as an error quotes it."""
    text = spaced(node)
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def unread(node: Node, why: str) -> Unread:
    """Return the error that says of a node why it has no meaning."""
    return Unread(line_of(node), f"{words(node)} {why}")


def fixed_text(source: bytes, root: Node, cuts: tuple[Cut, ...], comments: frozenset[str]) -> bytes:
    """Return a file without its comments, with a name in place of everything that was read."""
    spans = [(cut.start, cut.end, b"<%s>" % cut.name.encode()) for cut in cuts]
    found = (node for node in _outside(root, cuts) if node.type in comments)
    silent = [(node.start_byte, node.end_byte, _gap(source, node)) for node in found]
    parts: list[bytes] = []
    place = 0
    for first, last, name in sorted([*spans, *silent]):
        assert first >= place, "what was read overlaps"
        parts += [source[place:first], name]
        place = last
    return b"".join([*parts, source[place:]])


def _gap(source: bytes, comment: Node) -> bytes:
    """Return a space where a comment is all that stands between two tokens."""
    around = source[comment.start_byte - 1 : comment.start_byte], source[comment.end_byte : comment.end_byte + 1]
    return b" " if all(around) and not any(one.isspace() for one in around) else b""


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
