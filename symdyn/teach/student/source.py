r"""A student's text in the one way that is parsed: what is spelled otherwise is replaced, with positions.

θ̇₁²    \dot{\theta }_{1}^{2}        ½ m·h    (1/2) m*h        dL/dqd1    slopeqd1
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass

from symdyn.errors import TeachError
from symdyn.teach.student.grammar import LETTERS, SPELLINGS

LONGEST = 50_000
SHOWN = 100  # characters of a line that a message shows

_INSIDE = re.compile(
    r"\\begin\{(align|aligned|equation|gather|multline|eqnarray|displaymath|math|split)(\*?)\}(.*?)\\end\{\1\2\}"
    r"|\$\$(.*?)\$\$|\\\[(.*?)\\\]|\\\((.*?)\\\)|\$(.*?)\$",
    re.DOTALL,
)


@dataclass(frozen=True)
class Source:
    """A text and where each of its characters stood.

    Attributes:
        name: of the file, for messages.
        original: as the student wrote it.
        text: in plain letters.
        at: for each character of `text` (and its end) the place in `original`.
        marked: whether only what LaTeX marks as mathematics was kept.
    """

    name: str
    original: str
    text: str
    at: tuple[int, ...]
    marked: bool

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
        places += [*at[end : found.start()], *[at[found.start()]] * len(new)]
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
