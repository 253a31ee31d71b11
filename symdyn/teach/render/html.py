"""A document as one HTML page that needs nothing else: mathematics in MathML, pictures inside, exercises that answer.

A formula is written in pieces, one a term, which the browser sets in lines of any width; what is wider scrolls.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from symdyn.algebra import Form
from symdyn.draw import style
from symdyn.emit import in_html, render
from symdyn.emit.code import page_stem, stem
from symdyn.emit.print import BREAK, latex_width
from symdyn.errors import DerivationError, TeachError
from symdyn.table import Table
from symdyn.teach.document import (
    Blank,
    Block,
    Box,
    Braced,
    Document,
    Fold,
    Formula,
    Matrix,
    Picture,
    Room,
    Shares,
    Words,
)
from symdyn.teach.interactive.live import absence
from symdyn.teach.interactive.numbered import Numbered
from symdyn.teach.interactive.page import Interactive, interactive
from symdyn.teach.languages import language_of
from symdyn.teach.mathematics import PART, Spelling, flow, inline, pieces
from symdyn.teach.practice.questions import questions

SHORT = 150.0  # of a formula between words


def html(document: Document) -> dict[str, str]:
    """Return the one file by name."""
    return {f"{page_stem(document.scene.name)}.html": html_page(document)}


def html_page(document: Document) -> str:
    """Return the page: the steps, sliders where the mechanism allows them, solutions of exercises."""
    page = _Page(document)
    sections = [
        {
            "key": section.key,
            "title": in_html(section.title),
            "waits": any(step.needs for step in section.steps),
            "steps": [
                {
                    "key": _anchor(step.key),
                    "claim": page.words(step.claim),
                    "reference": in_html(step.reference),
                    "blocks": [text for block in step.blocks for text in page.block(block)],
                    "reason": page.words(step.reason),
                    "show": in_html(" ".join(page.numbered.shown(step))),
                    "needs": page.numbers(step.needs),
                }
                for step in section.steps
            ],
        }
        for section in document.sections
    ]
    asked, (live, absent) = questions(document), _live(document, page.numbered)
    values = {
        "title": in_html(document.title),
        "language": document.language,
        "text": language_of(document.language).lesson,
        "sections": sections,
        "style": live.css if live else style("auto"),  # of all pictures, once
        "live": live,
        "absent": absent,
        "reading": _reading(document),
        "questions": asked,
    }
    return render("teach/walkthrough.html.jinja", values)


def _live(document: Document, numbered: Numbered) -> tuple[Interactive | None, str]:
    """Return the part with sliders; for a mechanism that they cannot move None, and why."""
    try:
        return interactive(document.scene, language=document.language, named=numbered.values), ""
    except (TeachError, DerivationError) as fault:
        why = absence(document.scene, document.language)
        return None, in_html(why or f"{language_of(document.language).page['absent']} {fault}")


def _reading(document: Document) -> dict[str, str]:
    """Return what the script of a page that is read needs to know."""
    words = language_of(document.language).page
    return {"name": stem(document.scene.name), "point": words["point"], "term": words["term"]}


def _anchor(key: str) -> str:
    return re.sub(r"[^\w-]+", "-", key)


class _Page:
    """The blocks of one document."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.spell = Spelling(document)
        self.text = language_of(document.language).lesson
        self.numbered = Numbered(document)
        self.blanks = [block.key for _, block in document.blocks() if isinstance(block, Blank)]

    def numbers(self, keys: Iterable[str]) -> str:
        """Return the numbers of blanks, from 0, as a page writes what a step needs."""
        return " ".join(str(self.blanks.index(key)) for key in keys)

    def words(self, words: Words) -> str:
        return "".join(in_html(x, quote=False) if isinstance(x, str) else self._inline(x) for x in words.parts)

    def _inline(self, form: Form) -> str:
        """Return a formula in a line of text; a long one in pieces."""
        latex = self.spell.inline(form)
        return inline(latex) if latex_width(latex) < SHORT else f'<span class="run">{flow("", self.spell(form))}</span>'

    def block(self, block: Block) -> Iterator[str]:
        """Yield the elements of a block."""
        if isinstance(block, Words):
            yield f"<p>{self.words(block)}</p>"
        elif isinstance(block, (Formula, Braced)):
            left, right = self.spell.formula(block) if isinstance(block, Formula) else self.spell.braced(block)
            terms = pieces(left.replace(BREAK, ""), right)
            yield _numbered(PART.join(terms), block.number, self.numbered.marks(block, len(terms)))
        elif isinstance(block, Matrix):
            left, right = self.spell.matrix(block).split("&", maxsplit=1)
            yield _numbered(flow(left.strip(), right), block.number)
        elif isinstance(block, Picture):
            alt = in_html(block.alt)
            svg = re.sub(r"<title>.*?</title>", lambda _: f"<title>{alt}</title>", block.svg, count=1, flags=re.S)
            svg = re.sub(r"<style>.*?</style>\n?", "", svg, count=1, flags=re.S)
            svg = re.sub(r'aria-label="[^"]*"', lambda _: f'aria-label="{alt}"', svg, count=1)
            yield f"<figure>{svg.strip()}<figcaption>{self.words(block.caption)}</figcaption></figure>"
        elif isinstance(block, Table):
            yield f'<div class="scroll">{block.html(self.words)}</div>'
        elif isinstance(block, Shares):
            yield self._bars(block)
        elif isinstance(block, Box):
            inside = "\n".join(text for part in block.blocks for text in self.block(part))
            yield f'<aside class="box {block.kind}"><p class="name">{self.words(block.title)}</p>\n{inside}</aside>'
        elif isinstance(block, Fold):
            inside = "\n".join(text for part in block.blocks for text in self.block(part))
            yield f"<details><summary>{self.words(block.summary)}</summary>\n{inside}</details>"
        elif isinstance(block, Blank):
            yield self._blank(block)
        elif isinstance(block, Room):
            yield f'<div class="room" style="height:{2 * block.lines}em"></div>'

    def _bars(self, shares: Shares) -> str:
        rows = []
        for bar in shares.bars:
            kind = "plus" if bar.value >= 0 else "minus"
            drawn = f'<span class="bar {kind}" style="width:{100 * bar.share:.1f}%"></span>'
            cells = f"<th>{inline(self.spell.inline(bar.label))}</th><td>{self.spell.written(bar.value)}</td>"
            rows.append(f'<tr>{cells}<td class="drawn">{drawn}</td><td>{100 * bar.share:.0f}&nbsp;%</td></tr>')
        total, value = inline(self.spell.inline(shares.total)), self.spell.written(shares.value)
        cells = f"<th>{total}</th><td>{value}</td><td>{in_html(shares.unit)}</td><td></td>"
        end = f'<tr class="total">{cells}</tr>'
        caption = f"<caption>{self.words(shares.caption)}</caption>"
        body = "\n".join([*rows, end])
        return f'<div class="scroll"><table class="shares">{caption}<tbody>\n{body}\n</tbody></table></div>'

    def _blank(self, blank: Blank) -> str:
        name = _anchor(blank.key)
        values = {
            "key": in_html(blank.key),
            "name": name,
            "ask": self.words(blank.ask),
            "left": inline(self.spell.inline(blank.shown)),
            "hint": self.words(blank.hint),
            "number": self.numbers([blank.key]),
            "solution": [text for part in blank.solution for text in self.block(part)],
            "text": self.text,
        }
        return render("teach/blank.html.jinja", values)


def _numbered(formula: str, number: str, marks: str = "") -> str:
    tag = f'<span class="number">({in_html(number)})</span>' if number else ""
    return f'<div class="formula"><div class="flow"{marks}>{formula}</div>{tag}</div>'
