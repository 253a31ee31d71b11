"""A table, and how it is written: text, HTML, Markdown, CSV and LaTeX, each escaped as its target asks."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any, Generic, TypeVar
from unicodedata import combining, east_asian_width

from symdyn.emit import in_html, in_latex, in_markdown
from symdyn.frozen import dataclass
from symdyn.rounding import in_digits
from symdyn.shown import Suggesting

C = TypeVar("C")

DIGITS, NOTHING = 6, 1e-12
"""Digits of floats, and what beside the largest entry of a matrix is zero."""

_BAR = re.compile(r"(?<!\\)\|")  # what ends a cell of Markdown, in a formula too


@dataclass(frozen=True)
class Table(Suggesting, Generic[C]):
    """A table.

    Attributes:
        columns: the heads, with units where there are some: "mass, kg".
        rows: the cells, each row as long as the heads: texts, numbers, HTML that says so by `__html__`, or what a
            `write` makes text of.
        numbers: places of the columns that hold numbers, from 0; they stand to the right.
        title: what it is about; "" for none.

    Floats have six digits, or as many as are asked for; in CSV they have all. A `write` makes text of one cell or head
    in the language of the call, and escapes it; without one, nothing in a cell is read as anything but text.
    """

    columns: Sequence[C]
    rows: Sequence[Sequence[C]]
    numbers: Collection[int] = ()
    title: str = ""

    def __repr__(self) -> str:
        return self.text().rstrip()

    def __iter__(self) -> Iterator[Sequence[C]]:
        """Yield the rows."""
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @staticmethod
    def matrix(
        corner: str, rows: Sequence[str], columns: Sequence[str], entries: Sequence[Sequence[float]]
    ) -> Table[str | float]:
        """Return a matrix with names on its rows and columns; what is nothing beside the largest entry is 0."""
        least = NOTHING * max((abs(x) for row in entries for x in row), default=0.0)
        cells: list[list[str | float]] = [
            [name, *(0.0 if abs(x) <= least else x for x in row)] for name, row in zip(rows, entries, strict=True)
        ]
        return Table((corner, *columns), cells, range(1, 1 + len(columns)))

    def text(self, rule: str = "─") -> str:
        """Return it for a terminal: the title, the heads, a rule of that letter, the rows, an empty line."""
        head, *rows = (f" {'   '.join(row)} " for row in self._padded())
        width = _width(head)
        top = [self.title + " " * (width - _width(self.title)), " " * width] if self.title else []
        return "\n".join([*top, head, f" {rule * (width - 2)} ", *rows, " " * width])

    def lines(self) -> list[str]:
        """Return heads and rows as lines inside of other text."""
        return ["  ".join(row).rstrip() for row in self._padded()]

    def _padded(self) -> list[list[str]]:
        """Return heads and rows as text, the cells of a column as wide as its widest."""
        cells = [[_plain(cell) for cell in row] for row in (self.columns, *self.rows)]
        widths = [max(map(_width, column)) for column in zip(*cells, strict=True)]
        return [
            [
                " " * (width - _width(cell)) + cell if k in self.numbers else cell + " " * (width - _width(cell))
                for k, (cell, width) in enumerate(zip(row, widths, strict=True))
            ]
            for row in cells
        ]

    def html(self, write: Callable[[Any], str] | None = None, row_heads: bool = False) -> str:
        """Return the element <table>; with `row_heads` the first cell of a row is its head."""
        written = write or _html
        kinds = [' class="number"' if k in self.numbers else "" for k in range(len(self.columns))]
        top = f"<caption>{in_html(self.title)}</caption>" if self.title else ""
        if any(self.columns):
            heads = zip(kinds, self.columns, strict=True)
            top += f"<thead><tr>{''.join(f'<th{kind}>{written(cell)}</th>' for kind, cell in heads)}</tr></thead>"
        rows = []
        for row in self.rows:
            cells = [f"<td{kind}>{written(cell)}</td>" for kind, cell in zip(kinds, row, strict=True)]
            if row_heads:
                cells[0] = f'<th scope="row">{written(row[0])}</th>'
            rows.append(f"<tr>{''.join(cells)}</tr>")
        body = "\n".join(rows)
        return f"<table>{top}<tbody>\n{body}\n</tbody></table>"

    def _repr_html_(self) -> str:
        return self.html()

    def markdown(self, write: Callable[[Any], str] | None = None) -> str:
        """Return lines between bars, below the title."""
        written = write or (lambda cell: in_markdown(" ".join(_plain(cell).split())))
        head, *rows = [[_BAR.sub(r"\\|", written(cell)) for cell in row] for row in (self.columns, *self.rows)]
        rule = ["--:" if k in self.numbers else "---" for k in range(len(head))]
        title = f"{in_markdown(self.title)}\n\n" if self.title else ""
        return title + "\n".join(f"| {' | '.join(row)} |" for row in (head, rule, *rows))

    def csv(self) -> str:
        """Return lines of RFC 4180, the heads first, without the title; floats have the digits that read back."""
        from csv import writer  # most tables are only printed

        file = io.StringIO()
        writer(file, lineterminator="\n").writerows((self.columns, *self.rows))
        return file.getvalue()

    def latex(self, write: Callable[[Any], str] | None = None, columns: str = "") -> str:
        """Return a tabular, below the title; `columns` are its column types, without them l, and r for numbers."""
        written = write or (lambda cell: in_latex(_plain(cell)))
        types = columns or "".join("r" if k in self.numbers else "l" for k in range(len(self.columns)))
        head, *rows = [" & ".join(map(written, row)) + r" \\" for row in (self.columns, *self.rows)]
        title = f"{in_latex(self.title)}\n\n" if self.title else ""
        body = "\n".join([head, r"\hline", *rows])
        return f"{title}\\begin{{tabular}}{{@{{}}{types}@{{}}}}\n{body}\n\\end{{tabular}}"


def _html(cell: object) -> str:
    return cell.__html__() if hasattr(cell, "__html__") else in_html(_plain(cell))


def _plain(cell: object) -> str:
    return in_digits(cell, DIGITS) if isinstance(cell, float) else str(cell)


def _width(text: str) -> int:
    """Return how many columns of a terminal a text takes: accents none, ideographs two."""
    if text.isascii():
        return len(text)
    return sum(0 if combining(one) else 1 + (east_asian_width(one) in "WF") for one in text)
