"""A document as Markdown: mathematics between dollar signs, pictures as files beside it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symdyn.emit import in_markdown, render
from symdyn.emit.code import page_stem
from symdyn.emit.print import BREAK, Line
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

ROOM = 620.0  # of a display, pt at 10 pt
BAR = 24  # characters of a share of one

MARKS = {"erratum": "⚠", "remark": "ℹ", "check": "✓"}


def markdown(document: Document) -> dict[str, str]:
    """Return the files by name: the text, and its pictures as SVG."""
    document = solutions_last(document)
    page = Page(document)
    sections = [
        {
            "title": in_markdown(section.title),
            "steps": [
                {
                    "claim": page.claim(step),
                    "reference": in_markdown(step.reference),
                    "blocks": page.blocks(step.blocks),
                    "reason": page.words(step.reason),
                }
                for step, _ in document.in_folds(section)
            ],
        }
        for section in document.sections
    ]
    text = render("teach/walkthrough.md.jinja", {"title": in_markdown(document.title), "sections": sections})
    pictures = {_file(document, one): one.svg for _, one in document.blocks() if isinstance(one, Picture)}
    return {f"{page_stem(document.scene.name)}.md": text, **pictures}


def _file(document: Document, picture: Picture) -> str:
    """Return the name of a picture's file, beside the text; its titles are in the language of the document."""
    language = "" if document.language == "en" else f"-{document.language}"
    return f"{page_stem(document.scene.name)}{language}-{picture.key}.svg"


class Page:
    """The blocks of one document."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.spell = Spelling(document)

    def words(self, words: Words) -> str:
        """Return prose."""
        return self.spell.words(words, in_markdown)

    def claim(self, step: Step) -> str:
        """Return what a step says first, in bold of a result and of a question of a sheet."""
        text = self.words(step.claim)
        return f"**{text}**" if text and (step.is_result or step.key.startswith("question:")) else text

    def blocks(self, blocks: Sequence[Block]) -> list[str]:
        """Return the paragraphs of blocks."""
        return [text for block in blocks for text in self.block(block)]

    def block(self, block: Block) -> Iterator[str]:
        """Yield the paragraphs of a block."""
        if isinstance(block, Words):
            yield self.words(block)
        elif isinstance(block, (Formula, Braced)):
            left, right = self.spell.formula(block) if isinstance(block, Formula) else self.spell.braced(block)
            yield display(Line(ROOM).broken(left.replace(BREAK, ""), right), block.number)
        elif isinstance(block, Matrix):
            yield display([self.spell.matrix(block)], block.number)
        elif isinstance(block, Picture):
            yield f"![{in_markdown(block.alt)}]({_file(self.document, block)})"
            yield f"*{self.words(block.caption)}*"
        elif isinstance(block, Table):
            yield block.markdown(self.words)
        elif isinstance(block, Shares):
            yield self.words(block.caption)
            yield self._bars(block)
        elif isinstance(block, Box):
            inside = self.blocks(block.blocks)
            title = f"**{MARKS[block.kind]} {self.words(block.title)}**"
            yield "\n".join(f"> {line}".rstrip() for line in "\n\n".join([title, *inside]).split("\n"))
        elif isinstance(block, Fold):
            inside = self.blocks(block.blocks)
            summary = f"<details><summary>{self.words(block.summary)}</summary>"
            yield "\n\n".join([summary, *inside, "</details>"])
        elif isinstance(block, Blank):
            yield self.words(block.ask)
            summary = language_of(self.document.language).lesson["exercise.hint"]
            yield f"<details><summary>{summary}</summary>\n\n{self.words(block.hint)}\n\n</details>"
        elif isinstance(block, Choice):
            yield from map(self.words, (block.ask, *block.listed))
        elif isinstance(block, Room):
            yield "<br>" * block.lines

    def _bars(self, shares: Shares) -> str:
        heads, rows = (f"${self.spell.inline(shares.total)}$", in_markdown(shares.unit), ""), []
        for bar in shares.bars:
            length = round(BAR * bar.share)
            mark = ("█" if bar.value >= 0 else "▒") * max(length, 1) if bar.value else ""
            label, value = f"${self.spell.inline(bar.label)}$", self.spell.written(bar.value)
            rows.append((label, value, f"{mark} {100 * bar.share:.0f} %"))
        return Table(heads, rows).markdown(str)


def display(aligned: list[str], number: str = "") -> str:
    """Return a display of one or more lines with its equation number."""
    tag = rf" \tag{{{number}}}" if number else ""
    body = " \\\\\n".join(aligned)
    if len(aligned) == 1:
        return f"$$\n{body.replace('&', '', 1).strip()}{tag}\n$$"
    return f"$$\n\\begin{{aligned}}\n{body}\n\\end{{aligned}}{tag}\n$$"
