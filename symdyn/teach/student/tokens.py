r"""Tokens of a student's formula, the same for LaTeX and for plain text, and a cursor that reads them one by one.

First the text is brought to one spelling; positions in the student's text are kept:

    θ̇₁²    \dot \theta_{1}^{2}         ½ m·h    (1/2) m*h        dL/dqd1    slopeqd1

Then it is split by the tables of `grammar`:

    word      a name with its indices, as letters and digits alone: q_{1}, q1 and q_1 are "q1", \theta_1 is "theta1"
    sub       an index that follows a bracket or an accent
    number    exact; 0.5 and 0,5
    command   \frac, \dot, a brace                   function, constant      \sin, sin, pi
    open, close, op      brackets and + - * / ^ =
    row, stop            the end of a line; the end of a formula
    unknown              what has no place in a formula; its text says why
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Sequence
from fractions import Fraction

from symdyn.errors import TeachError
from symdyn.frozen import dataclass, replace
from symdyn.teach.student import grammar
from symdyn.teach.student.grammar import (
    COMMANDS,
    FUNCTIONS,
    LETTERS,
    MOST_LETTERS,
    SPELLINGS,
    TIME_LETTERS,
    Names,
    plain_index,
)

LONGEST = 50_000
SHOWN = 100  # characters of a line that a message shows

_INSIDE = re.compile(
    r"\\begin\{(align|aligned|equation|gather|multline|eqnarray|displaymath|math|split)(\*?)\}(.*?)\\end\{\1\2\}"
    r"|\$\$(.*?)\$\$|\\\[(.*?)\\\]|\\\((.*?)\\\)|\$(.*?)\$",
    re.DOTALL,
)


@dataclass(frozen=True)
class Source:
    """A text and where each of its characters stood."""

    name: str  # of the file, for messages
    original: str  # as the student wrote it
    text: str  # in plain letters
    at: tuple[int, ...]  # for each character of `text` (and its end) the place in `original`
    marked: bool  # whether only what LaTeX marks as mathematics was kept

    def fault(self, at: int, message: str) -> TeachError:
        """Return the error for character `at` of `text`: file, line and column, then the line with a caret."""
        place = self.at[min(at, len(self.at) - 1)]
        line = self.original.count("\n", 0, place) + 1
        start = self.original.rfind("\n", 0, place) + 1
        shown = self.original[start:].split("\n", 1)[0].replace("\t", " ")
        column = place - start
        cut = max(0, column - SHOWN // 2)
        shown, before = shown[cut : cut + SHOWN], shown[cut:column]
        caret = " " * sum(not unicodedata.combining(c) for c in before) + "^"
        return TeachError(f"{self.name}:{line}:{column + 1}: {message}\n  {shown}\n  {caret}")

    def line(self, at: int) -> int:
        """Return the line, from 1, of character `at` of `text`."""
        return self.original.count("\n", 0, self.at[min(at, len(self.at) - 1)]) + 1


def source(text: str, name: str = "text") -> Source:
    """Return a text ready to be split into tokens; of a LaTeX text only what stands in mathematics is kept.

    Raises:
        TeachError: the text is too long.
    """
    if len(text) > LONGEST:
        raise TeachError(f"{name}: {len(text)} characters; {LONGEST} are allowed")
    kept = _without_comments(text)
    marked = _INSIDE.search(kept) is not None
    if marked:
        mask = [" "] * len(kept)
        for found in _INSIDE.finditer(kept):
            mask[found.start() : found.end()] = kept[found.start() : found.end()]
        kept = "".join(new if new != " " or old != "\n" else "\n" for new, old in zip(mask, kept, strict=True))
    at = list(range(len(kept)))
    for pattern, means in _SPELLINGS:
        kept, at = _respelled(kept, at, pattern, means)
    return Source(name, text, kept, (*at, len(text)), marked)


def _without_comments(text: str) -> str:
    """Return the text with spaces for comments, as long as before."""
    return re.sub(r"(?<!\\)%[^\n]*|#[^\n]*", lambda found: " " * len(found[0]), text)


# Spellings

_SPELLINGS = [(re.compile(pattern, re.ASCII), means) for pattern, means in SPELLINGS]


def _respelled(text: str, at: list[int], pattern: re.Pattern[str], means: str) -> tuple[str, list[int]]:
    """Return a text with what a pattern finds spelled as it means, and where its characters stood."""
    parts: list[str] = []
    places: list[int] = []
    end = 0
    for found in pattern.finditer(text):
        new = _meaning(means, found[0], found[1] if pattern.groups else "")
        parts += [text[end : found.start()], new]
        own = [at[found.start()]] * len(new)
        if (begin := means.find("$1")) >= 0:
            own[begin : begin + len(found[1])] = at[found.start(1) : found.end(1)]
        places += [*at[end : found.start()], *own]
        end = found.end()
    return "".join((*parts, text[end:])), places + at[end:]


def _meaning(means: str, result: str, inner: str) -> str:
    ways: dict[str, Callable[[], str]] = {
        "lower": result.lower,
        "letter": lambda: f"\\{LETTERS[result]} ",
        "decomposed": lambda: _decomposed(result),
        "slope": lambda: f"slope{_bare(inner)} ",
        "rate": lambda: f"rate{inner} ",
        "equation": lambda: _equated(inner),
    }
    if means in ways:
        return ways[means]()
    return means.replace("$1", inner).replace("$k", unicodedata.normalize("NFKD", result))


def _decomposed(letter: str) -> str:
    """Return a letter with dots as the letter, then its dots; others as they are."""
    parts = unicodedata.normalize("NFD", letter)
    return parts if set(parts[1:]) <= {"\u0307", "\u0308"} else letter


def _bare(by: str) -> str:
    r"""Return what a derivative is taken by as one word: \dot{q}_1 and q_1' are q1dot."""
    dots = 2 * by.count("\\ddot") + by.count("\\dot") + by.count("'")
    return re.sub(r"\\d?dot(?![A-Za-z])|[\\{}_' ]", "", by) + "dot" * dots


def _equated(inside: str) -> str:
    """Return the two arguments of an equation with "=" between them: the comma that stands in no bracket."""
    depth = 0
    for k, letter in enumerate(inside):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            return f"{inside[:k]}={inside[k + 1 :]}"
    return inside


MOST_DIGITS = 40

_TOKENS = [(re.compile(pattern, re.ASCII), kind) for pattern, kind in grammar.TOKENS]
_TIMES = [(re.compile(pattern), order, cut) for pattern, order, cut in grammar.TIMES]
_GROUP, _INDEX, _OF_TIME = map(re.compile, (grammar.GROUP, grammar.INDEX, grammar.OF_TIME))
_UNDERSCORES = re.compile("_*(?=_)")


@dataclass(frozen=True)
class Token:
    """One token of a kind, see the module; it begins `at` in the source's text.

    Dots of a word come from primes; `spelled` is a word with the underscores of its indices: q_1 of q1.
    """

    kind: str
    text: str
    at: int
    dots: int = 0
    value: Fraction = Fraction(0)
    spelled: str = ""


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

    def _add(
        self, kind: str, text: str, end: int, dots: int = 0, value: Fraction = Fraction(0), spelled: str = ""
    ) -> None:
        last = self.found[-1] if self.found else None
        if kind == "close" and text == "}" and last and (last.kind, last.text) == ("open", "{"):
            self.found.pop()
        else:
            self.found.append(Token(kind, text, self.at, dots, value, spelled))
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
            self._word("_".join(map(plain_index, group[0].split("_"))), group.end())
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
            name += f"_{index}"
        dots = 0
        while dots < 2 and self.text.startswith("'", end):
            dots, end = dots + 1, end + 1
        text = name.replace("_", "")
        self._add("constant" if text == "pi" and not dots else "word", text, end, dots, spelled=name)

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
    kept = list[Token]()
    for token in found:
        first = kept[-1] if kept else token
        greek = first.text in LETTERS.values() and first.text not in names.symbols and not first.dots
        if greek and token.kind == "word" and (text := first.text + token.text) in names.symbols:  # Δx
            kept[-1] = replace(token, text=text, spelled=first.spelled + token.spelled, at=first.at)
        else:
            kept.append(token)
    letters = "".join(_letter(token, names) for token in kept)
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
        after = kept[match.end()] if match.end() < len(kept) else None
        if match.lastindex is None and order == 1 and after is not None and after.kind == "open" and letters[at] != "C":
            timeless.append(replace(kept[at], kind="command", text="rate", dots=0))  # of a bracket
            at = match.end()
            continue
        if match.lastindex is None:
            raise source.fault(
                kept[at].at, "derivatives are read of coordinates only; carry this one out first: results are compared"
            )
        accents = len(match[1]) - len(match[1].lstrip(".:({"))
        word, dots = kept[match.start(1) + accents], match[1].count(".") + 2 * match[1].count(":")
        timeless.append(replace(word, text=word.text[cut:], spelled=word.spelled[cut:], dots=word.dots + dots + order))
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
        return "S" if text == "dt" else "n"
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
