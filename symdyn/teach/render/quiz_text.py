"""What a learning platform shows and reads: blocks as HTML with LaTeX for MathJax, formulas in its own letters."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symdyn.algebra import Form, Symbol
from symdyn.emit import in_html
from symdyn.emit.print import BREAK, text_of
from symdyn.errors import TeachError
from symdyn.frozen import dataclass
from symdyn.scene import Scene
from symdyn.table import Table
from symdyn.teach.document import Blank, Block, Box, Braced, Fold, Formula, Matrix, Picture, Words
from symdyn.teach.languages import language_of
from symdyn.teach.mathematics import Spelling
from symdyn.teach.practice.quiz import Part, Told, Variant, marked
from symdyn.unlocked import cached_property


class Html:
    """Blocks of one variant as HTML; pictures stand inside."""

    instead: Mapping[int, int] = {}
    """Letters of prose that would mean something on the platform, and others."""

    def __init__(self, variant: Variant) -> None:
        """Spell the names of the variant's document."""
        self.variant, self.spell = variant, Spelling(variant.document)

    def words(self, words: Words) -> str:
        """Return prose."""
        return "".join(self.prose(x) if isinstance(x, str) else self.inline(x) for x in words.parts)

    def prose(self, text: str, quote: bool = False) -> str:
        """Return text without formulas."""
        return in_html(text.translate(self.instead), quote=quote)

    def inline(self, form: Form) -> str:
        """Return a formula in a line of text."""
        return rf"\({in_html(self.spell.inline(form), quote=False)}\)"

    def blocks(self, blocks: Iterable[Block]) -> str:
        """Return elements, one a line."""
        return "\n".join(text for block in blocks for text in self.block(block))

    def block(self, block: Block) -> Iterator[str]:
        """Yield the elements of a block."""
        if isinstance(block, Words):
            yield f"<p>{self.words(block)}</p>"
        elif isinstance(block, (Formula, Braced)):
            left, right = self.spell.formula(block) if isinstance(block, Formula) else self.spell.braced(block)
            yield self._display(f"{left} {right}")
        elif isinstance(block, Matrix):
            yield self._display(self.spell.matrix(block).replace("&", "", 1))
        elif isinstance(block, Table):
            yield block.html(self.words)
        elif isinstance(block, Picture):
            data = b64encode(block.svg.encode()).decode()
            yield f'<p><img alt="{self.prose(block.alt, quote=True)}" src="data:image/svg+xml;base64,{data}"></p>'
            yield f"<p>{self.words(block.caption)}</p>"
        elif isinstance(block, (Box, Fold)):
            head = block.title if isinstance(block, Box) else block.summary
            yield f"<p><b>{self.words(head)}</b></p>"
            yield self.blocks(block.blocks)

    def asked(self, part: Part) -> tuple[str, str]:
        """Return what is asked, with what is said before it; and what stands in front of the box."""
        left = f"{self.inline(part.asked.shown)} = " if isinstance(part.asked, Blank) else ""
        return self.blocks((*part.before, part.asked.ask)), left

    def solved(self, part: Part) -> str:
        """Return the way to an answer."""
        return self.blocks((part.asked.ask, *part.asked.solution))

    def shown(self, how: str) -> dict[str, Any]:
        """Return what `Quiz.shown` says."""
        parts = dict[str, Any]()
        for key, part in self.variant.parts.items():
            ask, left = self.asked(part)
            parts[key] = {"ask": ask, "left": left, "solution": self.solved(part)}
            if isinstance(part.asked, Blank):
                parts[key]["answer"] = text_of(part.answer)
            else:
                every = part.asked.options
                parts[key]["options"] = [{"text": self.words(x.text), "right": str(x.right).lower()} for x in every]
        typed = {name: name for name in self.variant.typed}
        return {
            "params": {"task": self.blocks(self.variant.task), "how": how, "symbols": self.how(typed)},
            "parts": parts,
        }

    def how(self, letters: Mapping[str, str]) -> str:
        """Return a table of the letters, as they are printed and as they are typed."""
        words = language_of(self.variant.document.language).lesson
        latex = self.variant.typed
        rows = tuple(
            (rf"\({latex[name]}\)", f"<code>{in_html(new)}</code>") for name, new in letters.items() if name in latex
        )
        return Table((words["table.symbol"], words["quiz.typed"]), rows).html(str)

    @staticmethod
    def _display(latex: str) -> str:
        return rf"<p>\[{in_html(latex.replace(BREAK, '').strip(), quote=False)}\]</p>"


@dataclass(frozen=True)
class Dialect:
    """How a platform's algebra writes formulas."""

    words: Mapping[str, str]  # its names of functions, by ours
    reserved: str  # letters that mean something else there
    cased: bool = True  # whether m and M are two letters
    exact: bool = False  # whether decimals become fractions

    def letters(self, variant: Variant) -> dict[str, str]:
        """Return what each symbol is called, by its name: itself, but for one that is taken."""
        found, taken = dict[str, str](), set(self.reserved.split())
        for name in [*variant.typed, *variant.diagnosis.others]:
            new, k = name, 1
            while (new if self.cased else new.lower()) in taken:
                new, k = f"{name}_{k}", k + 1
            taken.add(new if self.cased else new.lower())
            found[name] = new
        return found

    def text(self, form: Form, letters: Mapping[str, str]) -> str:
        """Return a formula.

        Raises:
            TeachError: a symbol of it is no letter that a student can type, or it looks up a table.
        """
        if strange := [name for name in form.symbols if name not in letters]:
            raise TeachError(f"{strange[0]} stands in a result, and is nothing that can be typed into a platform")
        renamed = form.substitute({old: Symbol(new) for old, new in letters.items() if old != new})
        text = text_of(renamed).replace("**", "^")
        if "table(" in text or "if(" in text:
            raise TeachError("a result looks up a table or has cases, which no platform's algebra is told")
        if self.exact:
            text = _DECIMAL.sub(lambda found: f"({Fraction(found[0])})", text)
        return _WORD.sub(lambda found: self.words.get(found[0], found[0]), text)


def points_by(
    letters: Mapping[str, str], points: Iterable[Mapping[str, float]], scene: Scene
) -> list[dict[str, float]]:
    """Return points by letters, values without their last digits, but for parameters: pi/2 has a cosine of 6e-17."""
    whole = {one.name for one in scene.parameters}
    return [{letters[x]: v if x in whole else float(f"{v:.12g}") for x, v in p.items() if x in letters} for p in points]


_DECIMAL = re.compile(r"(?<![\w.])\d+(?:\.\d+(?:e-?\d+)?|e-?\d+)")
_WORD = re.compile(r"(?<!\w)(?:log|sign|atan2|pi)(?=\(|\W|$)")


@dataclass(frozen=True)
class Quiz:
    """The exercises of a mechanism for learning platforms.

    Attributes:
        scene: what the variants are drawn from.
        variants: the lessons, the scene's own first.
        settings: arguments of `Handout` that make these lessons again, but for the scene and the seed.
    """

    scene: Scene
    variants: tuple[Variant, ...]
    settings: Mapping[str, object]

    @property
    def words(self) -> Mapping[str, str]:
        """Prose in the language of the lessons."""
        return language_of(self.variants[0].document.language).lesson

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The questions that every variant has.

        Raises:
            TeachError: there is none.
        """
        first, *others = self.variants
        common = [
            key
            for key, part in first.parts.items()
            if all(key in one.parts and isinstance(one.parts[key].asked, type(part.asked)) for one in others)
        ]
        if not common:
            raise TeachError(f"{self.scene.name}: no question is one of every variant; ask for one variant")
        return tuple(common)

    def parts(self, key: str) -> Sequence[Part]:
        """Return a question variant by variant."""
        return [one.parts[key] for one in self.variants]

    def shown(self) -> dict[str, Any]:
        """Return what a page shows of the first variant, as HTML with LaTeX, for MathJax; pictures stand inside.

        Returns:
            params: task, how answers are written, a table of the letters; parts: by key ask, left (what stands in front
            of the box), solution, and answer or options (text, whether right).
        """
        return Html(self.variants[0]).shown(self.words["quiz.prairielearn"])

    def marks(self, key: str) -> int:
        """Return what a right answer is worth."""
        return self.parts(key)[0].marks

    def marked(self, key: str, text: str) -> Told:
        """Return what the checker says to an answer to a question of the first variant; see `marked`."""
        return marked(self.variants[0].document, key, text)
