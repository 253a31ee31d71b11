r"""A document in LaTeX for pdflatex, one file, and as PDF: pictures are drawn in it, long lines broken at + and -."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from symdyn.arguments import argument
from symdyn.draw import tex_picture
from symdyn.emit import in_latex, render
from symdyn.emit.code import page_stem
from symdyn.emit.print import BMatrix, Latex, Line, latex_width
from symdyn.errors import EmitError
from symdyn.table import Table
from symdyn.teach.document import (
    Blank,
    Block,
    Box,
    Braced,
    Choice,
    Document,
    Fold,
    Formula,
    Matrix,
    Picture,
    Room,
    Shares,
    Step,
    Words,
)
from symdyn.teach.languages import language_of
from symdyn.teach.mathematics import Spelling
from symdyn.teach.practice.questions import solutions_last

TAG = 55.0  # room for an equation number
INSET = 24.0  # what a box takes from the line
THIN = r" \, "  # between factors
BRACKETS = 24.0  # of a matrix, with the sign before it
GAP = 16.0  # between columns of a table
ROWS, TALL_ROWS = 40, 10  # of one table, and of one whose cells have several lines
HALF = 0.48  # of the line, for one of two pictures
BAR = 150.0  # pt of a share of one

SECONDS = 120  # of pdflatex
TAIL = 15  # lines of what it says where it stops

NEXT_LINE, TALLEST = r"\\", 16  # lines of what a frame keeps on one page
DISPLAYS = (r"\begin{align*}", r"\begin{equation*}")
WITH_NEXT = r"\withnext"

COLOURS = {"erratum": "fff0ee", "remark": "eef4fb", "check": "eef8f0"}


def latex(document: Document) -> dict[str, str]:
    """Return the one file by name."""
    document = solutions_last(document.kept())
    page = _Page(document)
    sections = [
        {
            "title": in_latex(section.title),
            "bookmark": _pdf_text(section.title),
            "steps": page.errata(section.steps)
            if section.key == "errata"
            else [page.step(one) for one in section.steps],
        }
        for section in document.sections
    ]
    values = {
        "title": in_latex(document.title),
        "known": _pdf_text(document.title),
        "language": document.language,
        "comment": document.scene.name,
        "sections": sections,
    }
    return {f"{page_stem(document.scene.name)}.tex": render("teach/walkthrough.tex.jinja", values)}


class _Page:
    """The blocks of one document."""

    def __init__(self, document: Document) -> None:
        self.spell = Spelling(document)
        self.hint = language_of(document.language).lesson["exercise.hint"]

    def step(self, step: Step) -> dict[str, str]:
        """Return the places of the template: a claim stays on the page of what it announces."""
        body = self.body(step.blocks, Line.room, step.framed)
        displayed = body.lstrip().startswith(DISPLAYS)
        return {
            "claim": rf"\textbf{{{self.words(step.claim)}}}"
            if step.is_result and step.claim.parts
            else self.words(step.claim),
            "reference": step.reference,
            "end": "}" if displayed else rf"\par}}{WITH_NEXT}" if body else "}",
            "body": body.lstrip("\n") if displayed else body,
            "reason": self.words(step.reason),
        }

    def errata(self, steps: Sequence[Step]) -> Iterator[dict[str, str]]:
        """Yield the boxes of an appendix: those that hold a table as rows of one, then others, in small print."""
        rows, others, head = list[tuple[Words, ...]](), list[str](), (Words(("",)),) * 4
        for box in (block for step in steps for block in step.blocks if isinstance(block, Box)):
            said = Words(
                (*box.title.parts, ". ", *(x for b in box.blocks if isinstance(b, Words) for x in (*b.parts, " ")))
            )
            if found := [block for block in box.blocks if isinstance(block, Table)]:
                (_, left, number), (text, right) = found[0].columns, found[0].rows
                head = (Words(("",)), text[0], right[0], number)
                forms = (Words((*left.parts, " = ", *row[1].parts)) for row in (text, right))
                rows.append((said, *forms, Words((*text[2].parts, "; ", *right[2].parts))))
            else:
                others.append(self.words(said))
        shown = [*([self._table(Table(head, tuple(rows)), 1.1 * Line.room)] if rows else []), *others]
        body = "\n\n".join(f"{{\\small\n{one}\n\\par}}" for one in shown)
        yield {"claim": "", "reference": "", "end": "}", "body": body, "reason": ""}

    def words(self, words: Words) -> str:
        return self.spell.words(words, in_latex)

    def body(self, blocks: Sequence[Block], room: float, framed: slice = slice(0, 0)) -> str:
        """Return blocks one after the other; formulas in a row share a display, that of a result in a frame."""
        text = ""
        for alike, pairs in groupby(enumerate(blocks), lambda pair: _kind(pair[1])):
            places, group = zip(*pairs, strict=True)
            if alike is Picture:
                text += "".join(f"\n\n{one}" for one in self._pictures(group, room))
            elif alike is Formula:
                result = places[0] == framed.start and framed.stop
                shown = self._display(group, room - INSET * bool(result))
                framing = result and shown.count(NEXT_LINE) < TALLEST
                text += f"\n\n\\begin{{result}}\n{shown}\n\\end{{result}}\n" if framing else f"\n{shown}\n"
            else:
                text += "".join(f"\n\n{one}" for block in group for one in self.block(block, room))
        for display in DISPLAYS:  # belongs to the paragraph before it
            text = text.replace(f"{WITH_NEXT}\n{display}", f"\n{display}").replace(f"\n\n{display}", f"\n{display}")
        return text

    def _display(self, group: Sequence[Block], room: float) -> str:
        formulas = [block for block in group if isinstance(block, (Formula, Braced))]
        pairs = [self.spell.formula(one) if isinstance(one, Formula) else self.spell.braced(one) for one in formulas]
        rows = []
        tagged = room - TAG * any(block.number for block in formulas)
        for block, lines in zip(formulas, Line(tagged).aligned(pairs), strict=True):
            tag = rf" \tag{{{block.number}}}" if block.number else ""
            rows.append(" \\\\\n  ".join(lines) + tag)
        return Line.display(rows)

    def _matrix(self, block: Matrix, room: float) -> str:
        """Return a matrix; one that is too wide with its entries by name, which are written out below it."""
        tag = rf" \tag{{{block.number}}}" if block.number else ""
        room -= TAG if tag else 0
        left, right = self.spell.matrix(block).split("&", maxsplit=1)
        entries = [self.spell.inline(entry) for entry in block.entries]
        whole = [entries[k : k + block.width] for k in range(0, len(entries), block.width)]
        aside = latex_width(left) + BRACKETS
        if BMatrix(whole).width + aside <= room:
            return f"\\begin{{equation*}}\n  {left}{right}{tag}\n\\end{{equation*}}"
        rows, pairs = self.spell.named_matrix(block)
        written = Line(room).aligned(pairs)
        if (named := BMatrix(rows)).width + aside <= room:
            written.insert(0, [f"{left} &= {named}"])
        *lines, last = (line for paragraph in written for line in paragraph)
        return Line.display([*lines, f"{last}{tag}"])

    def block(self, block: Block, room: float) -> Iterator[str]:
        """Yield the paragraphs of a block that is no formula, on lines of `room` pt."""
        if isinstance(block, Words):
            text = self.words(block)
            yield f"{text}{WITH_NEXT}" if text.endswith(":") else text
        elif isinstance(block, Matrix):
            yield self._matrix(block, room)
        elif isinstance(block, Table):
            yield self._table(block, min(room, Line.room))  # small print has no wider lines
        elif isinstance(block, Shares):
            yield self.words(block.caption)
            yield self._bars(block)
        elif isinstance(block, Box):
            body = rf"\textbf{{{self.words(block.title)}}}" + self.body(block.blocks, room - INSET)
            yield f"\\begin{{lesson}}{{{COLOURS[block.kind]}}}\n{body}\n\\end{{lesson}}"
        elif isinstance(block, Fold):
            body = rf"\emph{{{self.words(block.summary)}}}" + self.body(block.blocks, room / 0.9)
            yield f"{{\\small\n{body}\n\\par}}"
        elif isinstance(block, Blank):
            yield self.words(block.ask)
            yield rf"\emph{{{self.hint}: {self.words(block.hint)}}}"
        elif isinstance(block, Choice):
            yield from map(self.words, (block.ask, *block.listed))
        elif isinstance(block, Room):
            yield rf"\room{{{block.lines}}}"

    def _pictures(self, group: Sequence[Picture], room: float) -> Iterator[str]:
        """Yield pictures with their captions, two beside each other where both are narrow."""
        shown = [(tex_picture(one.svg), rf"\nopagebreak \small {self.words(one.caption)}") for one in group]
        sizes = [float(found[1]) for drawn, _ in shown if (found := re.search(r"\\begin\{picture\}\(([\d.]+),", drawn))]
        k = 0
        while k < len(shown):
            row = shown[k : k + (2 if max(sizes[k : k + 2]) < HALF * room else 1)]
            boxes = [f"{drawn}\n\n{caption}" for drawn, caption in row]
            if len(row) == 2:
                boxes = [
                    f"\\begin{{minipage}}[b]{{{HALF}\\linewidth}}\\centering\n{one}\n\\end{{minipage}}" for one in boxes
                ]
            yield "\\begin{center}\n" + "\\hfill\n".join(boxes) + "\n\\end{center}"
            k += len(row)

    def _table(self, table: Table[Words], room: float) -> str:
        """Return a table whose wide columns share what the narrow ones leave."""
        head, *others = rows = [[self.words(cell) for cell in row] for row in (table.columns, *table.rows)]
        widths = [max(map(_width, column)) for column in zip(*rows, strict=True)]
        least = [max(_width(part) for cell in column for part in _unbroken(cell)) for column in zip(*rows, strict=True)]
        columns = _columns(widths, least, room - GAP * len(widths))
        most = TALL_ROWS if "p{" in columns else ROWS
        parts = [Table(head, others[k : k + most]) for k in range(0, len(others), most)]
        return "\n\n".join(part.latex(_breakable, columns) for part in parts)

    def _bars(self, shares: Shares) -> str:
        total, value = self.spell.inline(shares.total), self._value(shares.value)
        rows = [rf"${total}$ & ${value}$ {in_latex(shares.unit)} & \\ \hline"]
        for bar in shares.bars:
            colour = "sdplus" if bar.value >= 0 else "sdminus"
            rule = rf"\textcolor{{{colour}}}{{\rule{{{max(BAR * bar.share, 0.4):.1f}pt}}{{6pt}}}}"
            cells = (f"${self.spell.inline(bar.label)}$", f"${self._value(bar.value)}$")
            rows.append(f"{cells[0]} & {cells[1]} & {rule}~{100 * bar.share:.0f}\\,\\% \\\\")
        body = "\n".join(rows)
        return f"\\begin{{center}}\n\\begin{{tabular}}{{@{{}}lrl@{{}}}}\n{body}\n\\end{{tabular}}\n\\end{{center}}"

    def _value(self, value: float) -> str:
        return Latex.scientific(self.spell.written(value).replace("−", "-").replace(",", "{,}").replace(" · 10^", "e"))


def _kind(block: Block) -> type | None:
    """Return what blocks are together that follow each other: formulas in one display, pictures in one row."""
    return Formula if isinstance(block, (Formula, Braced)) else Picture if isinstance(block, Picture) else None


def _pdf_text(text: str) -> str:
    r"""Return text as the inside of a PDF string, two bytes a character, each as \string\ and its octal digits."""
    return "".join(rf"\string\{byte:03o}" for byte in b"\xfe\xff" + text.encode("utf-16-be"))


def _breakable(cell: str) -> str:
    return cell.replace(THIN, rf"{THIN}\allowbreak ")


def _width(cell: str) -> float:
    """Return an estimate of the width of a cell, pt."""
    outside = COMMAND.sub("x", "".join(cell.split("$")[::2]))
    return 5.5 * len(outside) + sum(latex_width(inside) for inside in cell.split("$")[1::2])


COMMAND = re.compile(r"\\ensuremath\{[^{}]*\}|\\[A-Za-z]+\{\}|\\.")
"""One letter of text that takes more in LaTeX."""


def _unbroken(cell: str) -> Iterator[str]:
    """Yield the parts of a cell that are not broken: words, and factors of formulas without a fraction."""
    for k, part in enumerate(cell.split("$")):
        if k % 2 == 0:
            yield from part.split()
        else:
            yield from (f"${term}$" for term in ([part] if r"\frac" in part else re.split(r" [+-] | \\, ", part)))


def _columns(widths: Sequence[float], least: Sequence[float], room: float) -> str:
    r"""Return the column types: l for what fits or does not break, p{…} for what is wide; each has its least width."""
    if sum(widths) <= room:
        return "l" * len(widths)
    left, wide = room, list(range(len(widths)))
    while True:
        narrow = [k for k in wide if widths[k] <= max(left / len(wide), least[k])]
        if not narrow or len(narrow) == len(wide):
            break
        left -= sum(widths[k] for k in narrow)
        wide = [k for k in wide if k not in narrow]
    sizes = {k: widths[k] for k in wide}
    while True:  # what is wide shares what is left, but for columns that would not hold their widest word
        shared = [k for k in wide if sizes[k] != least[k]]
        rest, total = left - sum(least[k] for k in wide if k not in shared), sum(widths[k] for k in shared)
        sizes |= {k: max(rest * widths[k] / total, 0.6 * rest / len(shared)) for k in shared}
        scale = rest / (sum(sizes[k] for k in shared) or 1.0)
        sizes |= {k: scale * sizes[k] for k in shared}
        tight = [k for k in shared if sizes[k] < least[k]]
        if not tight or len(tight) == len(shared):
            break
        sizes |= {k: least[k] for k in tight}
    ragged = r">{\raggedright\arraybackslash}"
    return "".join(f"{ragged}p{{{sizes[k]:.0f}pt}}" if k in sizes else "l" for k in range(len(widths)))


def pdf(document: Document) -> dict[str, bytes]:
    """Return the one file by name; the same document, the same bytes.

    Raises:
        EmitError: pdflatex is absent or stops.
    """
    program, other = shutil.which("pdflatex"), f"{argument('format', 'latex')} writes the source"
    if program is None:
        raise EmitError(f"pdflatex is not installed, so there is no PDF; {other}")
    ((name, source),) = latex(document).items()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "lesson.tex").write_text(source, encoding="utf-8")
        command = [program, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "lesson.tex"]
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "0", "FORCE_SOURCE_DATE": "1", "openin_any": "p"}
        try:
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, timeout=SECONDS, check=False, text=True,
                errors="replace",
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise EmitError(f"pdflatex takes more than {SECONDS} s; {other}") from None
        if done.returncode:
            said = "\n".join(done.stdout.splitlines()[-TAIL:])
            raise EmitError(f"pdflatex stops; {other}. Its last words:\n{said}")
        return {f"{Path(name).stem}.pdf": Path(folder, "lesson.pdf").read_bytes()}
