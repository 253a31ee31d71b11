"""Long formulas in lines, broken at + and -, outside brackets where there is a choice; displays of LaTeX from them.

Lines of LaTeX fit an A4 page with 20 mm margins at 10 pt.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from symdyn.emit.print.formula_text import BREAK

LATE = 0.55  # a line is filled at least so far before brackets are respected

TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[0-9.]|[A-Za-z]|[_^{}]|.", re.DOTALL)

GLYPHS = {  # widths in pt at 10 pt, Computer Modern
    **dict.fromkeys((r"\sin", r"\cos", r"\exp", r"\ln", r"\tanh"), 18.0),
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


LINE = 470.0  # pt: 170 mm less a little for what the estimate misses
INDENT = 20.0
DIGITS = 6
MOST_LINES = 60  # of one align, which TeX reads whole

Lines = list[str]


def lines_of(left: str, text: str, right: str = "") -> Lines:
    """Return the lines of `left text right`, aligned at the start of `text`."""
    room = LINE - latex_width(left)
    lines = break_lines(text, room, room - INDENT, latex_width)
    if right and latex_width(lines[-1] + right) > room - INDENT * (len(lines) > 1):
        lines += break_lines(right, room - INDENT, room - INDENT, latex_width)
    else:
        lines[-1] = f"{lines[-1]} {right.replace(BREAK, '')}".rstrip()
    first, *others = lines
    return [f"{left} &{first}" if left else f"& {first}", *(rf"&\quad {{}}{line}" for line in others)]


def definition(left: str, text: str) -> Lines:
    """Return `left = text`; a long left-hand side does not push the lines to the right."""
    return lines_of(left, f"= {text}")


def align(paragraphs: Sequence[Lines]) -> Iterator[str]:
    """Yield align* displays, a few paragraphs each."""
    chunk: list[Lines] = []
    for i, paragraph in enumerate(paragraphs):
        chunk.append(paragraph)
        full = sum(map(len, chunk)) + (len(paragraphs[i + 1]) if i + 1 < len(paragraphs) else MOST_LINES) > MOST_LINES
        if full:
            body = " \\\\\n".join("  " + " \\\\\n  ".join(lines) for lines in chunk)
            yield f"\\begin{{align*}}\n{body}\n\\end{{align*}}"
            chunk = []


def together(indices: Sequence[str]) -> str:
    """Return indices side by side, set apart where one has two digits."""
    return (r"\," if any(len(i) > 1 for i in indices) else "").join(indices)


def entry_name(letter: str, *index: int) -> str:
    """Return M_{12} or g_{1}; `index` counts from 0."""
    return f"{letter}_{{{together([str(i + 1) for i in index])}}}"


def bmatrix(rows: Sequence[Sequence[str]]) -> str:
    """Return a matrix."""
    return r"\begin{bmatrix} " + r" \\ ".join(" & ".join(row) for row in rows) + r" \end{bmatrix}"


def matrix_width(rows: Sequence[Sequence[str]]) -> float:
    """Return how wide a matrix is printed, pt."""
    return sum(max(latex_width(row[j]) for row in rows) + 10 for j in range(len(rows[0])))
