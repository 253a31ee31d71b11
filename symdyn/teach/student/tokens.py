r"""Tokens of a student's formula: the same for LaTeX and for plain text, by the tables of `grammar`.

word      a name with its indices, as letters and digits alone: q_{1}, q1 and q_1 are "q1", \theta_1 is "theta1"
sub       an index that follows a bracket or an accent
number    exact; 0.5 and 0,5
command   \frac, \dot, a brace                   function, constant      \sin, sin, pi
open, close, op      brackets and + - * / ^ =
row, stop            the end of a line; the end of a formula
unknown              what has no place in a formula; its text says why

A cursor reads them one by one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symdyn.errors import TeachError
from symdyn.teach.student import grammar
from symdyn.teach.student.grammar import COMMANDS, FUNCTIONS, MOST_LETTERS, TIME_LETTERS, plain_index
from symdyn.teach.student.source import Source
from symdyn.teach.student.vocabulary import Names

MOST_DIGITS = 40

_TOKENS = [(re.compile(pattern, re.ASCII), kind) for pattern, kind in grammar.TOKENS]
_TIMES = [(re.compile(pattern), order, cut) for pattern, order, cut in grammar.TIMES]
_GROUP, _INDEX, _OF_TIME = map(re.compile, (grammar.GROUP, grammar.INDEX, grammar.OF_TIME))
_UNDERSCORES = re.compile("_*(?=_)")


@dataclass(frozen=True)
class Token:
    """One token of a kind, see the module; it begins `at` in the source's text. Dots of a word come from primes."""

    kind: str
    text: str
    at: int
    dots: int = 0
    value: Fraction = Fraction(0)


def tokens(source: Source) -> list[Token]:
    """Return the tokens of a text, without {}, which only sets distances in LaTeX.

    Raises:
        TeachError: an index, a brace or digits that cannot be right.
    """
    return _Lexer(source).run()


class _Lexer:
    def __init__(self, source: Source) -> None:
        self.source, self.text, self.at = source, source.text, 0
        self.found: list[Token] = []

    def run(self) -> list[Token]:
        while self.at < len(self.text):
            matches = ((kind, pattern.match(self.text, self.at)) for pattern, kind in _TOKENS)
            self._next(*next((kind, match[0]) for kind, match in matches if match))
        return self.found

    def _add(self, kind: str, text: str, end: int, dots: int = 0, value: Fraction = Fraction(0)) -> None:
        last = self.found[-1] if self.found else None
        if kind == "close" and text == "}" and last and (last.kind, last.text) == ("open", "{"):
            self.found.pop()
        else:
            self.found.append(Token(kind, text, self.at, dots, value))
        self.at = end

    def _next(self, kind: str, text: str) -> None:
        at, end = self.at, self.at + len(text)
        if kind == "command":
            unknown = ("unknown", f"{text} is not known here; write the formula with \\frac, \\sin, \\dot")
            kind, text = COMMANDS.get(text[1:], unknown)
        elif kind == "unknown":
            text = f"{text!r} has no place in a formula"
        if kind == "number":
            if len(text) > MOST_DIGITS:
                raise self.source.fault(at, f"a number of {len(text)} characters; {MOST_DIGITS} are allowed")
            self._add(kind, text, end, value=Fraction(text.replace("{,}", ".").replace(",", ".")))
        elif kind == "word":
            self._word(text, end)
        elif kind == "upright":
            group = _GROUP.match(self.text, end)
            if not group:
                raise self.source.fault(at, f"{self.text[at:end]} needs braces: {self.text[at:end]}{{m}}")
            self._word(plain_index(group[0]), group.end())
        elif kind == "step":
            self._add("unknown", f"{self.text[at:end]}: carry it out first; results are compared, not steps", end)
        elif kind == "sub":
            self._add(kind, *self._index(at))
        elif kind:
            self._add(kind, "^" if text == "**" else text, end)
        else:
            self.at = end

    def _word(self, name: str, end: int) -> None:
        if len(name) > MOST_LETTERS:
            raise self.source.fault(self.at, f"a name of {len(name)} characters; put spaces or * between factors")
        if name in FUNCTIONS and not self.text.startswith("_", end):
            self._add("function", FUNCTIONS[name], end)
            return
        while under := _UNDERSCORES.match(self.text, end):
            index, end = self._index(under.end(), optional=len(name) > 1)
            name += index
        dots = 0
        while dots < 2 and self.text.startswith("'", end):
            dots, end = dots + 1, end + 1
        self._add("constant" if name == "pi" and not dots else "word", name, end, dots)

    def _index(self, at: int, optional: bool = False) -> tuple[str, int]:
        """Return the index that begins with the underscore at `at`, and where it ends; names of code end in _ too."""
        found = _INDEX.match(self.text, at)
        if found is None or not (found[1] or optional):
            raise self.source.fault(at, "an index is missing; write q_1 or q_{12}")
        return plain_index(found[1]), found.end()


# Functions of time


def without_time(source: Source, found: Sequence[Token], names: Names) -> list[Token]:
    """Return the tokens with primes in place of derivatives with respect to time, and no "(t)" behind what moves.

    Raises:
        TeachError: the derivative of what is no coordinate, which is a step and no result.
    """
    kept, letters = list(found), "".join(_letter(token, names) for token in found)
    while behind := [(match.end(1), match.end()) for match in _OF_TIME.finditer(letters)]:
        for begin, end in reversed(behind):
            del kept[begin:end]
            letters = letters[:begin] + letters[end:]
    timeless: list[Token] = []
    at = 0
    while at < len(kept):
        rows = ((pattern.match(letters, at), order, cut) for pattern, order, cut in _TIMES)
        match, order, cut = next((row for row in rows if row[0]), (None, 0, 0))
        if match is None:
            timeless.append(kept[at])
            at += 1
            continue
        if match.lastindex is None:
            raise source.fault(
                kept[at].at, "derivatives are read of coordinates only; carry this one out first: results are compared"
            )
        accents = len(match[1]) - len(match[1].lstrip(".:({"))
        word, dots = kept[match.start(1) + accents], match[1].count(".") + 2 * match[1].count(":")
        timeless.append(replace(word, text=word.text[cut:], dots=word.dots + dots + order))
        at = match.end()
    return timeless


def _letter(token: Token, names: Names) -> str:
    """Return the letter of a token in patterns of time."""
    text, kind = token.text, token.kind
    if kind == "sub" or (kind == "number" and text != "2"):
        return "_"
    if kind != "word":
        return TIME_LETTERS.get(f"\\{text}" if kind == "command" else text, "w")
    moves, without = names.moves(text), text[:1] == "d" and names.moves(text[1:])
    if moves or without:
        return "e" if text == "d" else "E" if not moves else "D" if without else "q"
    if text in names.symbols and text not in ("d", "t"):
        return "S" if text == "dt" else "w"
    return TIME_LETTERS.get(text, "w")


class Cursor:
    """A row of tokens and how far it is read."""

    def __init__(self, source: Source, tokens: Sequence[Token], end: int) -> None:
        """Begin at the first token; `end` is where the formula ends in the source's text."""
        self.source, self.tokens, self.end = source, tokens, end
        self.next = 0

    def peek(self) -> Token | None:
        """Return the next token, None at the end."""
        return self.tokens[self.next] if self.next < len(self.tokens) else None

    def sees(self, kind: str, *texts: str) -> bool:
        """Whether the next token is of a kind, with one of the texts if there are any."""
        token = self.peek()
        return token is not None and token.kind == kind and (not texts or token.text in texts)

    def take(self) -> Token:
        """Return the next token and go on.

        Raises:
            TeachError: there is none, or it has no place in a formula.
        """
        token = self.peek()
        if token is None:
            raise self.source.fault(self.end, "the formula breaks off; something is missing here")
        if token.kind == "unknown":
            raise self.fault(token, token.text)
        self.next += 1
        return token

    def fault(self, token: Token, message: str) -> TeachError:
        """Return the error for a token."""
        return self.source.fault(token.at, message)
