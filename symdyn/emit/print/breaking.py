"""Long formulas in lines, broken at + and -, outside brackets where there is a choice; displays of LaTeX from them.

Lines of LaTeX fit an A4 page with 20 mm margins at 10 pt. Pages that would be too long are refused with their size:
their formulas are counted before one is written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence

from symdyn.algebra import Form
from symdyn.errors import EmitError
from symdyn.frozen import dataclass

BREAK = "\v"
"""Stands in formulas in front of every + and - at which a line may end."""

LINE = 470.0  # pt: 170 mm less a little for what the estimate misses
INDENT = 20.0

TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[0-9.]|[A-Za-z]|[_^{}]|.", re.DOTALL)

GLYPHS = {  # widths in pt at 10 pt, Computer Modern
    **dict.fromkeys((r"\sin", r"\cos", r"\exp", r"\ln", r"\tanh", r"\max", r"\min"), 18.0),
    **dict.fromkeys(("+", "-", "="), 12.3),
    **dict.fromkeys((r"\cdot",), 7.3),
    **dict.fromkeys(("(", ")"), 4.0),
    **dict.fromkeys((r"\bigl", r"\bigr"), 0.7),
    **dict.fromkeys((r"\Bigl", r"\Bigr"), 2.2),
    **dict.fromkeys((r"\biggl", r"\biggr"), 3.4),
    **dict.fromkeys((r"\dot", r"\ddot", r"\mathrm", r"\mathit", r"\mathtt", "{", "}", " ", BREAK, "&"), 0.0),
    r"\,": 1.7,
    r"\quad": 10.0,
    ".": 2.8,
    ",": 4.5,
    r"\sqrt": 8.5,
    "m": 8.8,
    "w": 7.2,
    "M": 10.8,
    **dict.fromkeys("ijl", 4.2),
    **dict.fromkeys("ABCDEFGHIKLNOPQRUVWXYZ", 8.0),
    **dict.fromkeys("0123456789", 5.0),
}
ORDINARY = 5.9  # any other letter
SCRIPT = 0.72


def latex_width(text: str) -> float:
    """Return a slightly generous estimate of the width of a formula, pt at 10 pt."""
    tokens = TOKEN.findall(text)
    width, _ = _measure(tokens, 0)
    return width


def _measure(tokens: list[str], at: int) -> tuple[float, int]:
    """Return the width of tokens up to the brace that closes, and where it stands."""
    total = 0.0
    while at < len(tokens) and tokens[at] != "}":
        token = tokens[at]
        if token in ("_", "^"):
            width, after = _argument(tokens, at + 1)
            subscript_width = width
            if after < len(tokens) and tokens[after] == "^" and token == "_":  # both at one place
                width, after = _argument(tokens, after + 1)
                subscript_width = max(subscript_width, width)
            total, at = total + SCRIPT * subscript_width + 0.5, after
        elif token in (r"\frac", r"\tfrac"):
            upper, after = _argument(tokens, at + 1)
            lower, at = _argument(tokens, after)
            total += max(upper, lower) * (SCRIPT if token == r"\tfrac" else 1) + 2.4
        elif token == "{":
            width, after = _measure(tokens, at + 1)
            total, at = total + width, after + 1
        else:
            total += GLYPHS.get(token, ORDINARY)
            at += 1
    return total, at


def _argument(tokens: list[str], at: int) -> tuple[float, int]:
    while at < len(tokens) and tokens[at] == " ":
        at += 1
    if at < len(tokens) and tokens[at] == "{":
        width, after = _measure(tokens, at + 1)
        return width, after + 1
    return (GLYPHS.get(tokens[at], ORDINARY), at + 1) if at < len(tokens) else (0.0, at)


LATE = 0.55  # a line is filled at least so far before brackets are respected


def break_lines(text: str, first: float, rest: float, width: Callable[[str], float]) -> list[str]:
    """Return `text` in lines that start with an operator, but for the first.

    Args:
        text: with break marks.
        first: room on the first line, in units of `width`.
        rest: room on the others.
        width: what a piece takes.
    """
    pieces = text.split(BREAK)
    sizes = [width(piece) for piece in pieces]
    depths, depth = [], 0
    for piece in pieces:
        depths.append(depth)
        depth += piece.count("(") - piece.count(")")
    lines, start, room = [], 0, first
    while start < len(pieces):
        end, used = start + 1, sizes[start]
        while end < len(pieces) and used + sizes[end] <= room:
            used += sizes[end]
            end += 1
        if end < len(pieces):
            filled, best = 0.0, end
            for k in range(start, end):
                filled += sizes[k]
                if filled >= LATE * room and depths[k + 1] <= depths[best]:
                    best = k + 1
            end = best
        lines.append("".join(pieces[start:end]).strip())
        start, room = end, rest
    return lines


DIGITS = 6
COLUMN = LINE / 4  # widest left-hand side that others are aligned with
MOST_LINES = 60  # of one align, which TeX reads whole

Lines = list[str]


@dataclass(frozen=True)
class Line:
    """A line of a display, `room` pt wide."""

    room: float = LINE

    def broken(self, left: str, text: str, right: str = "", column: float = 0.0) -> Lines:
        """Return `left text right` in lines aligned at the start of `text`, behind a column so wide or wider, pt."""
        room = self.room - max(latex_width(left), column)
        lines = break_lines(text, room, room - INDENT, latex_width)
        if right and latex_width(lines[-1] + right) > room - INDENT * (len(lines) > 1):
            lines += break_lines(right, room - INDENT, room - INDENT, latex_width)
        else:
            lines[-1] = f"{lines[-1]} {right.replace(BREAK, '')}".rstrip()
        first, *others = lines
        return [f"{left} &{first}" if left else f"& {first}", *(rf"&\quad {{}}{line}" for line in others)]

    def aligned(self, pairs: Sequence[tuple[str, str]]) -> list[Lines]:
        """Return the lines of left and right of each pair, in one display, aligned at the sign that right begins with.

        Args:
            pairs: both sides with break marks; a left one too wide to align with stands behind the column; "" for none.
        """
        column = max(
            (width for width in map(latex_width, ((left for left, _ in pairs))) if width <= COLUMN), default=0.0
        )
        return [self._sides(left, right, column) for left, right in pairs]

    @staticmethod
    def display(lines: Lines) -> str:
        body = " \\\\\n  ".join(lines)
        return f"\\begin{{align*}}\n  {body}\n\\end{{align*}}"

    def _sides(self, left: str, right: str, column: float) -> Lines:
        if latex_width(left) > COLUMN:
            return self.broken("", f"{left} {BREAK}{right}", column=column)
        return self.broken(left.replace(BREAK, ""), right, column=column)


def definitions(pairs: Sequence[tuple[str, str]]) -> list[str]:
    """Return displays of left = right, aligned at the signs.

    Args:
        pairs: both sides of each, with break marks; without a left one the other is all that is written.
    """
    return list(align(Line().aligned([(left, f"= {right}" if left else right) for left, right in pairs])))


def equations(pairs: Sequence[tuple[str, str]]) -> list[str]:
    """Return displays of left = right, aligned at the signs if all fit a line so, else where they begin."""
    sides = [(left.replace(BREAK, ""), right.replace(BREAK, "")) for left, right in pairs]
    if sum(max(map(latex_width, side)) for side in zip(*sides, strict=True)) + latex_width("=") <= LINE:
        return list(align([[f"{left} &= {right}"] for left, right in sides]))
    return list(align([Line().broken("", left, f"= {right}") for left, right in pairs]))


def align(paragraphs: Sequence[Lines]) -> Iterator[str]:
    """Yield align* displays, a few paragraphs each; one that is longer than a display goes on in the next."""
    chunk: list[str] = []
    for paragraph in paragraphs:
        if chunk and len(chunk) + len(paragraph) > MOST_LINES:
            yield Line.display(chunk)
            chunk = []
        chunk += paragraph
        while len(chunk) > MOST_LINES:
            yield Line.display(chunk[:MOST_LINES])
            chunk = chunk[MOST_LINES:]
    if chunk:
        yield Line.display(chunk)


def together(indices: Sequence[str]) -> str:
    """Return indices side by side, set apart where one has two digits."""
    return (r"\," if any(len(i) > 1 for i in indices) else "").join(indices)


def entry_name(letter: str, *index: int) -> str:
    """Return M_{12} or g_{1}; `index` counts from 0."""
    return f"{letter}_{{{together([str(i + 1) for i in index])}}}"


@dataclass(frozen=True)
class BMatrix:
    """A matrix of entries in LaTeX, in square brackets: `str` is its LaTeX."""

    rows: Sequence[Sequence[str]]

    def __str__(self) -> str:
        return r"\begin{bmatrix} " + r" \\ ".join(" & ".join(row) for row in self.rows) + r" \end{bmatrix}"

    @property
    def width(self) -> float:
        """How wide it is printed, pt."""
        return sum(max(latex_width(row[j]) for row in self.rows) + 10 for j in range(len(self.rows[0])))


MOST = 5.0
"""Megabytes of a page."""

BYTES = 5
"""Of a page in LaTeX for every part of its formulas, in long ones."""


def refuse_too_long(name: str, what: str, forms: Iterable[Form], ask: str) -> None:
    """Do nothing where formulas fit on a page that somebody may read.

    Args:
        name: of the scene.
        what: is written, such as "D'Alembert's system".
        forms: all that are written, as often as they are.
        ask: what to do instead.

    Raises:
        EmitError: they do not.
    """
    known: Sizes = {}
    size = BYTES * sum(parts(form, known) for form in forms) / 1e6
    if size > MOST:
        raise EmitError(
            f"{name}: {what} would be some {float(f'{size:.1g}'):g} MB of formulas, and {MOST:g} MB are the most that "
            f"are written; {ask}"
        )


Sizes = dict[int, tuple[Form, int]]
"""Forms with their sizes, held by identity, as long forms share their parts."""


def parts(form: Form, known: Sizes) -> int:
    """Return of how many parts a form is written."""
    if id(form) not in known:
        known[id(form)] = form, 1 + sum(parts(part, known) for part in form.parts)
    return known[id(form)][1]
