"""Long formulas in lines, broken at + and -, outside brackets where there is a choice; displays of LaTeX from them.

Lines of LaTeX fit an A4 page with 20 mm margins at 10 pt.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from symdyn.emit.print.latex_width import BREAK, INDENT, LINE, latex_width

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
    """A line of a display.

    Attributes:
        room: how wide it is, pt.
    """

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
        column = column_of(left for left, _ in pairs)
        return [self._sides(left, right, column) for left, right in pairs]

    @staticmethod
    def display(lines: Lines) -> str:
        """Return the align* display of lines."""
        body = " \\\\\n  ".join(lines)
        return f"\\begin{{align*}}\n  {body}\n\\end{{align*}}"

    def _sides(self, left: str, right: str, column: float) -> Lines:
        if latex_width(left) > COLUMN:
            return self.broken("", f"{left} {BREAK}{right}", column=column)
        return self.broken(left.replace(BREAK, ""), right, column=column)


def column_of(lefts: Iterable[str]) -> float:
    """Return how wide the column of left-hand sides is that stand in one display, those left out that are too wide."""
    return max((width for width in map(latex_width, lefts) if width <= COLUMN), default=0.0)


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
    """A matrix in square brackets: `str` is its LaTeX.

    Attributes:
        rows: of entries in LaTeX.
    """

    rows: Sequence[Sequence[str]]

    def __str__(self) -> str:
        return r"\begin{bmatrix} " + r" \\ ".join(" & ".join(row) for row in self.rows) + r" \end{bmatrix}"

    @property
    def width(self) -> float:
        """How wide it is printed, pt."""
        return sum(max(latex_width(row[j]) for row in self.rows) + 10 for j in range(len(self.rows[0])))
