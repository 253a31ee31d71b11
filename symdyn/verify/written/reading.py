"""The nouns of this package: what a reader of a language is given, and what it returns.

Syntax trees are by grammars that others wrote (tree-sitter). Correct rounding, the number of a type that is nearest to
an exact one, is worked out apart from the printer.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cache, lru_cache
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from symdyn.errors import MissingProgram
from symdyn.extras import install
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph

if TYPE_CHECKING:
    from tree_sitter import Node, Parser


def nearest(value: Fraction, real: str) -> Fraction:
    """Return the number of the type "double" or "float" that is nearest to `value`, ties to even, exactly.

    Raises:
        OverflowError: `value` is too large for the type.
    """
    number = float(value)  # a quotient of integers, which Python rounds correctly
    if real == "double":
        return Fraction(number)
    with np.errstate(over="ignore", under="ignore"):
        near = np.float32(number)  # rounded twice, so perhaps not the nearest, but beside it
        beside = [np.nextafter(near, np.float32(end)) for end in (-np.inf, np.inf)]
    known = [Fraction(float(one)) for one in (near, *beside) if np.isfinite(one)]
    if not known or abs(value) >= Fraction(2**128 - 2**103):
        raise OverflowError(f"{number} is too large for the type float")
    unit = Fraction(2) ** -149
    return min(known, key=lambda one: (abs(one - value), one / unit % 2 ** (_exponent(one) + 1) != 0))


def _exponent(number: Fraction) -> int:
    """Return k such that the last bit of a float of this size is worth 2^(k - 149)."""
    size = int(abs(number) * 2**149)
    return max(0, size.bit_length() - 24)


DECIMAL = re.compile(r"(0|[1-9][0-9]*)(\.[0-9]*)?([eE][+-]?[0-9]{1,4})?")


class Unread(Exception):  # noqa: N818  a verdict, not an error
    """The file says something that its reader has no meaning for; carries the line and the words."""

    def __init__(self, line: int, words: str) -> None:
        super().__init__(f"line {line}: {words}")
        self.line, self.words = line, words


@dataclass(frozen=True)
class ExpectedFunction:
    """A function that a file must hold.

    Attributes:
        name: what the function is called in files, without what a language puts before it.
        arguments: by name, in calling order, a symbol for each entry, on the graph of the text.
        scalars: names of arguments that are one number.
        shape: of the result.
        loop: whether it goes over a table, whose numbers are then all that is read of it.
    """

    name: str
    arguments: Mapping[str, tuple[Expr, ...]]
    scalars: frozenset[str]
    shape: tuple[int, ...]
    loop: bool = False

    @property
    def size(self) -> int:
        size = 1
        for length in self.shape:
            size *= length
        return size


@dataclass(frozen=True)
class Text:
    """A file on its way through a reader."""

    root: Node  # of its syntax tree
    source: bytes  # its bytes
    stem: str  # how names of files begin, and of functions where a language has no modules
    real: str  # "double" or "float"
    expected: tuple[ExpectedFunction, ...]  # the functions of the program, in order
    graph: Graph  # where expressions are made

    def number(self, decimal: str, line: int) -> Expr:
        """Return the number of the type that a decimal literal is read as.

        Raises:
            Unread: it is none of `1.5`, `2e-3` and the like, or too large for the type.
        """
        if not DECIMAL.fullmatch(decimal):
            raise Unread(line, f"{decimal} is no decimal number")
        try:
            return self.graph.constant(_nearest(decimal, self.real))
        except OverflowError:
            raise Unread(line, f"{decimal} is too large for the type {self.real}") from None

    def literal(self, decimal: str, line: int) -> Fraction:
        """Return the number of the type that a literal with a sign or without is read as.

        Raises:
            Unread: as of `number`, or a zero has a sign.
        """
        value = self.number(decimal.removeprefix("-").removesuffix("f" if self.real == "float" else ""), line)
        value = self.negative(value, line) if decimal.startswith("-") else value
        assert isinstance(value.value, Fraction), "a literal is a constant"
        return value.value

    def negative(self, value: Expr, line: int) -> Expr:
        """Return -value; Unread where it is zero; -0.0 is the same number of other bits, and never written."""
        if value.is_zero:
            raise Unread(line, "a zero has a sign")
        return -value


@lru_cache(maxsize=10_000)  # all files of a certificate hold the same numbers
def _nearest(decimal: str, real: str) -> Fraction:
    return nearest(Fraction(decimal), real)


@dataclass(frozen=True)
class Read:
    """What one function of a file computes, or the numbers that it goes over in a loop."""

    function: str  # name of the wanted function
    name: str  # what this one is called in the file: there may be several, for one state and for many
    entries: tuple[Expr, ...]  # of its result, row by row
    lines: tuple[int, ...]  # where each entry is written

    def by_rows(self, shape: tuple[int, ...]) -> Read:
        """Return a result of some shape row by row, whose entries stand column by column."""
        places = np.arange(len(self.entries)).reshape(shape[::-1]).T.ravel().tolist()
        entries, lines = tuple(self.entries[place] for place in places), tuple(self.lines[place] for place in places)
        return replace(self, entries=entries, lines=lines)


@dataclass(frozen=True)
class Cut:
    """A part of a file that a reader has read: bytes `start` to `end`; `name` stands for it among the fixed text."""

    start: int
    end: int
    name: str


@dataclass(frozen=True)
class TextReading:
    """What a reader has read of a file; the rest of the file is fixed text."""

    functions: tuple[Read, ...]
    cuts: tuple[Cut, ...]


@dataclass(frozen=True)
class ReadLanguage:
    """One language.

    Attributes:
        title: what reports call it.
        grammar: module of its grammar.
        read: its meaning.
        plain: a file as the grammar takes it, each byte at its place: blanks where there is a macro, say.
        comments: node types of comments.
    """

    title: str
    grammar: str
    read: Callable[[Text], TextReading]
    plain: Callable[[bytes], bytes] = bytes
    comments: frozenset[str] = frozenset({"comment"})


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
