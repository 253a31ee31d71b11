"""A table is the same cells in every language, and no cell is read as anything but text."""

from __future__ import annotations

import csv
import re
from html.parser import HTMLParser

import pytest

from symdyn.rounding import showing
from symdyn.table import Table

PLAIN = Table(("name", "mass, kg"), (("rod", 0.5), ("disc µ", 12)), (1,), "bodies")

HOSTILE = ("<b>&\"'", "a|b", "\\", "$x$ `y` *z* _w_", "# % { } ~ ^", "two\nlines", 'comma, "quote"', "日本 é")
"""Cells that mean something in one language or another."""

ATTACKED = Table(("<i>", "what"), [(cell, cell) for cell in HOSTILE], title="<script>")


class Cells(HTMLParser):
    """The text of every cell of a table, and the elements."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[str] = []
        self.cells: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append(tag)
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_data(self, data: str) -> None:
        if self.cells:
            self.cells[-1] += data


def test_text_stands_under_a_title_and_a_rule() -> None:
    assert PLAIN.text().split("\n") == [
        "bodies             ",
        "                   ",
        " name     mass, kg ",
        " ───────────────── ",
        " rod           0.5 ",
        " disc µ         12 ",
        "                   ",
    ]


def test_lines_stand_inside_other_text() -> None:
    assert PLAIN.lines() == ["name    mass, kg", "rod          0.5", "disc µ        12"]


def test_html_has_the_title_as_caption_and_numbers_to_the_right() -> None:
    head, *rows, end = PLAIN.html().split("\n")
    assert head == (
        '<table><caption>bodies</caption><thead><tr><th>name</th><th class="number">mass, kg</th></tr></thead><tbody>'
    )
    assert rows == [
        '<tr><td>rod</td><td class="number">0.5</td></tr>',
        '<tr><td>disc µ</td><td class="number">12</td></tr>',
    ]
    assert end == "</tbody></table>"
    assert PLAIN._repr_html_() == PLAIN.html()
    assert '<tr><th scope="row">rod</th><td class="number">0.5</td></tr>' in PLAIN.html(row_heads=True)
    assert "<thead>" not in Table(("", ""), [("a", "b")]).html()


def test_a_cell_that_is_html_stands_as_it_is() -> None:
    class Formula:
        def __html__(self) -> str:
            return "<math></math>"

    assert "<td><math></math></td>" in Table(("x",), [(Formula(),)]).html()


def test_markdown_csv_and_latex() -> None:
    assert PLAIN.markdown() == "bodies\n\n| name | mass, kg |\n| --- | --: |\n| rod | 0.5 |\n| disc µ | 12 |"
    assert PLAIN.csv() == 'name,"mass, kg"\nrod,0.5\ndisc µ,12\n'
    assert PLAIN.latex() == (
        "bodies\n\n\\begin{tabular}{@{}lr@{}}\nname & mass, kg \\\\\n\\hline\n"
        "rod & 0.5 \\\\\ndisc µ & 12 \\\\\n\\end{tabular}"
    )


def test_csv_reads_back_to_the_same_cells() -> None:
    third = 1 / 3
    head, *rows = csv.reader(Table(ATTACKED.columns, [*ATTACKED.rows, (third, 1e-300)]).csv().splitlines(True))
    assert head == ["<i>", "what"]
    assert rows[:-1] == [[cell, cell] for cell in HOSTILE]
    assert list(map(float, rows[-1])) == [third, 1e-300]


def test_html_holds_hostile_cells_as_text() -> None:
    found = Cells(ATTACKED.html())
    assert set(found.elements) == {"table", "caption", "thead", "tbody", "tr", "th", "td"}
    assert [cell.strip("\n") for cell in found.cells] == ["<i>", "what", *(cell for cell in HOSTILE for _ in range(2))]


def test_markdown_keeps_a_row_a_line_and_its_bars() -> None:
    lines = ATTACKED.markdown().split("\n")[2:]
    assert len(lines) == 2 + len(HOSTILE)
    assert all(len(re.findall(r"(?<!\\)\|", line)) == 3 for line in lines)
    assert not re.search(r"(?<!\\)[<*_`]", re.sub(r"</?span>", "", "\n".join(lines)))


def test_a_bar_of_a_formula_ends_no_cell_of_markdown() -> None:
    assert Table(("q",), [("$|q|$",), (r"$\|q\|$",)]).markdown(str).split("\n")[2:] == [r"| $\|q\|$ |"] * 2


def test_latex_escapes_what_it_would_read() -> None:
    assert Table(("50 %",), [("a_b & c",)]).latex() == (
        "\\begin{tabular}{@{}l@{}}\n50 \\% \\\\\n\\hline\na\\_b \\& c \\\\\n\\end{tabular}"
    )


def test_a_write_makes_text_of_cells_and_heads() -> None:
    table = Table((1, 2), [(3, 4)])
    assert table.html(lambda cell: f"<b>{cell}</b>").count("<b>") == 4
    assert table.markdown(lambda cell: f"*{cell}*").split("\n")[2] == "| *3* | *4* |"
    assert table.latex(lambda cell: f"${cell}$", "cc") == (
        "\\begin{tabular}{@{}cc@{}}\n$1$ & $2$ \\\\\n\\hline\n$3$ & $4$ \\\\\n\\end{tabular}"
    )


def test_floats_have_six_digits_or_those_that_are_asked_for() -> None:
    table = Table(("x",), [(2 / 3,)])
    assert table.lines()[1] == "0.666667"
    with showing(3):
        assert table.lines()[1] == "0.667"
        assert table.csv() == "x\n0.6666666666666666\n"


def test_widths_are_those_of_a_terminal() -> None:
    assert Table(("x", "y"), [("日本", 1), ("é", 2)]).lines() == ["x     y", "日本  1", "é     2"]


def test_what_is_nothing_beside_the_largest_entry_of_a_matrix_is_zero() -> None:
    assert Table.matrix("A", ("q1", "q2"), ("u",), [[1e9], [-1e-5]]).lines() == ["A       u", "q1  1e+09", "q2      0"]
    assert Table.matrix("A", ("q1",), ("u",), [[-0.0]]).lines()[1] == "q1  0"


def test_rows_as_long_as_the_heads_are_asked_for() -> None:
    for written in (Table.text, Table.html):
        with pytest.raises(ValueError, match="zip"):
            written(Table(("a", "b"), [("one",)]))
