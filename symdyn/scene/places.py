"""Where a fault of a TOML scene stands in its text: line and column of the key that it names.

Readers say a fault as `source: where: what`, where names tables and keys: "bodies.link1: particles[0]". tomllib keeps
no places, so the text is walked once more, and only where there is a fault. The walk is tolerant: it takes whatever
comes, since tomllib has said what the text means, or where it is none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from symdyn.errors import Place, SceneError, printable, without_long_words

_BLANK = r"(?:[ \t\r\n,]|#[^\n]*)*+"
_NAME = r"""[ \t]*(?P<name>[\w-]+|"(?:[^"\\\n]|\\.)*"|'[^'\n]*')[ \t]*"""
_TEXT = r'"""(?s:[^\\]|\\.)*?"""|\'\'\'(?s:.)*?\'\'\'|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'|[^\s,\]}#]+'

DEEPEST = 20
"""Levels of a value that are walked; a scene needs five."""

_SAID = r"line (\d+)(?:, column (\d+))?: "
ENDED = "end of document: "
"""How tomllib, and our own look at long keys, tell a place."""


@dataclass
class _Node:
    """A key, an entry of a list, or the whole text.

    Attributes:
        begin, end: offsets of its name; of an entry of a list, of its value.
        value: what follows the name as written, of a single value.
        inner: what it holds, by name, or by number in a list.
    """

    begin: int = 0
    end: int = 0
    value: str = ""
    inner: dict[str, _Node] = field(default_factory=dict)

    def put(self, name: str, begin: int, end: int) -> _Node:
        """Return what it holds under a name; where it is named first is its place."""
        return self.inner.setdefault(name, _Node(begin, end))

    def last(self) -> _Node:
        """Return the last entry of a list of tables, and of all else itself."""
        numbers = [name for name in self.inner if name.isdigit()]
        return self.inner[numbers[-1]] if numbers else self


class _Walk:
    """A walk through a text, which leaves `root` behind."""

    def __init__(self, text: str) -> None:
        self.text, self.at, self.root = text, 0, _Node()
        table = self.root
        while self._goes_on():
            before = self.at
            if text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)
            if self.at == before:  # no key: the rest of the line says nothing
                self.at = _end_of_line(text, self.at)

    def _goes_on(self, until: str = "") -> bool:
        found = re.compile(_BLANK).match(self.text, self.at)
        self.at = found.end() if found else self.at
        return self.at < len(self.text) and self.text[self.at] != until

    def _names(self) -> Iterator[tuple[str, int, int]]:
        """Return the parts of a dotted key."""
        while found := re.compile(_NAME).match(self.text, self.at):
            self.at = found.end()
            yield found["name"].strip("\"'"), found.start("name"), found.end("name")
            if self.text[self.at : self.at + 1] != ".":
                return
            self.at += 1

    def _header(self) -> _Node:
        begin, several = self.at, self.text.startswith("[[", self.at)
        self.at += 1 + several
        table = self.root
        for part in self._names():
            table = table.last().put(*part)
        table = table.put(str(len(table.inner)), begin, self.at) if several else table.last()
        while self.text[self.at : self.at + 1] == "]":
            self.at += 1
        return table

    def _pair(self, table: _Node, depth: int = 0) -> None:
        for part in self._names():
            table = table.put(*part)
        if self.text[self.at : self.at + 1] == "=":
            self.at += 1
            self._value(table, depth)

    def _value(self, node: _Node, depth: int = 0) -> None:
        close = {"[": "]", "{": "}"}.get(self.text[self.at : self.at + 1] if self._goes_on() else "", "")
        if close and depth < DEEPEST:
            self.at += 1
            while self._goes_on(close):
                before = self.at
                if close == "}":
                    self._pair(node, depth + 1)
                else:
                    entry = node.put(str(len(node.inner)), before, before)
                    self._value(entry, depth + 1)
                    entry.end = self.at
                self.at += self.at == before
            self.at += 1
        elif found := re.compile(_TEXT).match(self.text, self.at):
            self.at, node.value = found.end(), found[0].strip("\"'")


_BETWEEN = ' .:[]"'
"""What stands between the names of a place."""


def _node(root: _Node, told: str) -> _Node:
    """Return what a fault is about, by the names that it begins with; the whole text where it names none."""
    node = root
    while True:
        told = told.lstrip(_BETWEEN).removeprefix("unknown key ").lstrip(_BETWEEN)
        fits = [x for x in node.inner if x and told.startswith(x) and not re.match(r"[\w-]", told[len(x) :])]
        if not fits:
            return node
        name = max(fits, key=len)
        node, told = node.inner[name], told[len(name) :]


@contextmanager
def placing(text: str, source: str) -> Iterator[None]:
    """Give the faults that a block ends with their places in a text; one that names none is about line 1.

    Raises:
        SceneError: `source: where: what` has become `source:LINE: where: what`.
    """
    try:
        yield
    except SceneError as error:
        root = _Walk(text).root
        # rows of [[loop]] and [[dh.links]] are found by their names, as faults call them: as given, or by number
        none = _Node()
        links = root.inner.get("dh", none).inner.get("links", none)
        for usual, rows in (("loop", root.inner.get("loop", none)), ("link", links)):
            for k, row in enumerate([*rows.inner.values()], start=1):
                given = row.inner.get("name")
                rows.inner.setdefault(given.value if given else f"{usual}{k}", row)
        front = printable(without_long_words(f"{source}: "), keep="")  # as errors have it
        each = [_placed(fault.removeprefix(front), text, root) for fault in error.faults]
        raise SceneError([f"{source}:{place.line}: {told}" for place, told in each], [one for one, _ in each]) from None


def _placed(told: str, text: str, root: _Node) -> tuple[Place, str]:
    """Return where a fault stands, and what is left to be told."""
    if told.startswith(ENDED):
        return place_at(text, len(text.rstrip())), told
    if said := re.match(_SAID, told):
        line, column = int(said[1]), int(said[2] or 1)
        return Place(line, column), f"column {column}: {told[said.end() :]}" if said[2] else told[said.end() :]
    node = _node(root, told)
    return place_at(text, node.begin, min(node.end, _end_of_line(text, node.begin))), told


def place_at(text: str, begin: int, end: int = 0) -> Place:
    """Return the place of offsets of a text."""
    return Place(text.count("\n", 0, begin) + 1, begin - text.rfind("\n", 0, begin), max(1, end - begin))


def _end_of_line(text: str, at: int) -> int:
    end = text.find("\n", at)
    return end if end >= 0 else len(text)
