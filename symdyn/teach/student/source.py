r"""A student's text, in plain letters: Greek letters, dots, raised and lowered digits become commands, with positions.

θ̇₁²    \dot{\theta}_{1}^{2}        ½ m·h    (1/2) m*h        −    -
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

from symdyn.errors import TeachError
from symdyn.scene.values import GREEK
from symdyn.teach.student.spellings import replacements

LONGEST = 50_000
SHOWN = 100  # characters of a line that a message shows

RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
LOWERED = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
SIGNS = {"·": "*", "×": "*", "∙": "*", "⋅": "*", "−": "-", "–": "-", "″": "''"}
SIGNS |= {"\u00a0": " ", "\u2009": " ", "\u202f": " ", "\t": " ", "′": "'", "″": "''", "\r": " "}
SIGNS |= {one: f"({unicodedata.normalize('NFKD', one).replace(chr(0x2044), '/')})" for one in "½⅓⅔¼¾⅕⅖⅗⅘⅙⅚⅛⅜⅝⅞"}
DOTS = {"\u0307": "dot", "\u0308": "ddot"}
_PIECES = re.compile(r"[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+|[₀₁₂₃₄₅₆₇₈₉]+|.", re.DOTALL)

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
    plain: list[str] = []
    at: list[int] = []
    for piece, place in _pieces(kept):
        plain.append(piece)
        at += [place] * len(piece)
    read = "".join(plain)
    for begin, end, new in replacements(read):
        at[begin:end] = [at[begin]] * len(new)
        read = read[:begin] + new + read[end:]
    return Source(name, text, read, (*at, len(text)), marked)


def _without_comments(text: str) -> str:
    """Return the text with spaces for comments, as long as before."""
    return re.sub(r"(?<!\\)%[^\n]*|#[^\n]*", lambda found: " " * len(found[0]), text)


def _pieces(text: str) -> Iterator[tuple[str, int]]:
    """Yield what each character, or run of raised or lowered digits, becomes and where it stood."""
    at = 0
    while at < len(text):
        found = _PIECES.match(text, at)
        assert found is not None, "a dot matches every character"
        run, start = found[0], at
        at = found.end()
        if run[0] in "⁰¹²³⁴⁵⁶⁷⁸⁹⁻":
            yield f"^{{{run.translate(RAISED)}}}", start
        elif run[0] in "₀₁₂₃₄₅₆₇₈₉":
            yield f"_{{{run.translate(LOWERED)}}}", start
        elif run in SIGNS:
            yield SIGNS[run], start
        else:
            base, *marks = list(unicodedata.normalize("NFD", run))
            while at < len(text) and text[at] in DOTS:
                marks.append(text[at])
                at += 1
            letter = _letter(base)
            if marks and all(mark in DOTS for mark in marks):
                accent = "ddot" if len(marks) == 2 else DOTS[marks[0]]
                yield f"\\{accent}{{{letter}}}", start
            else:
                yield (letter if not marks else run), start


def _letter(character: str) -> str:
    """Return a Greek letter as a command."""
    if not "\u0370" <= character <= "\u03ff":
        return character
    name = unicodedata.name(character, "").split()
    found = (name[-1].lower() if "SMALL" in name else name[-1].capitalize()) if name else ""
    found = {"lamda": "lambda", "Lamda": "Lambda"}.get(found, found)
    return f"\\{found} " if found in GREEK else character
