"""The nouns of this package: what a reader of a language is given, and what it returns."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from symdyn.graph import Expr, Graph
from symdyn.verify.written.nearest import nearest

if TYPE_CHECKING:
    from tree_sitter import Node

DECIMAL = re.compile(r"(0|[1-9][0-9]*)(\.[0-9]*)?([eE][+-]?[0-9]{1,4})?")


class Unread(Exception):  # noqa: N818  a verdict, not an error
    """The file says something that its reader has no meaning for; carries the line and the words."""

    def __init__(self, line: int, words: str) -> None:
        """Store the line, counted from 1, and what is wrong there."""
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
        """Entries of the result."""
        size = 1
        for length in self.shape:
            size *= length
        return size


@dataclass(frozen=True)
class Text:
    """A file on its way through a reader.

    Attributes:
        root: of its syntax tree.
        source: its bytes.
        stem: how names of files begin, and of functions where a language has no modules.
        real: "double" or "float".
        wanted: the functions of the program, in order.
        graph: where expressions are made.
    """

    root: Node
    source: bytes
    stem: str
    real: str
    wanted: tuple[ExpectedFunction, ...]
    graph: Graph

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

    def negative(self, value: Expr, line: int) -> Expr:
        """Return -value.

        Raises:
            Unread: it is zero; -0.0 is the same number of other bits, and never written.
        """
        if value.is_zero:
            raise Unread(line, "a zero has a sign")
        return -value


@lru_cache(maxsize=10_000)  # all files of a certificate hold the same numbers
def _nearest(decimal: str, real: str) -> Fraction:
    return nearest(Fraction(decimal), real)


@dataclass(frozen=True)
class Read:
    """What one function of a file computes, or the numbers that it goes over in a loop.

    Attributes:
        function: name of the wanted function.
        name: what this one is called in the file: there may be several, for one state and for many.
        entries: of its result, row by row.
        lines: where each entry is written.
    """

    function: str
    name: str
    entries: tuple[Expr, ...]
    lines: tuple[int, ...]

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
