"""The one document: steps with a claim, the mathematics, a reason and a reference. Renderers walk it, nothing else.

No block holds LaTeX. A formula is a form (`symdyn.algebra.form`), whose symbols are those of the scene or keys of
`Document.names`; a name says how it is printed and what it is worth, so that tests compare texts with the graph.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import groupby
from typing import Union

from symdyn.algebra import Form
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Graph, Op, reachable, substitute
from symdyn.scene import Scene
from symdyn.table import Table
from symdyn.teach.languages import language_of
from symdyn.teach.played import Played

# Names


@dataclass(frozen=True)
class Letter:
    """A letter with indices: K_1, ẋ_2 (one dot), v_2² (power 2), k_{z,12}.

    Attributes:
        letter: one Latin letter, the name of a Greek one in Latin ("omega"), or LaTeX that begins with a backslash.
        index: what stands below, parts set apart by commas: ("z", "12").
        dots: time derivatives.
        power: exponent above.
        above: what stands above to the right: A, D, R for actions, inertia, reactions.
        accent: "bar" or "" above the letter.
    """

    letter: str
    index: tuple[str, ...] = ()
    dots: int = 0
    power: int = 1
    above: str = ""
    accent: str = ""


@dataclass(frozen=True)
class Slope:
    """The derivative ∂of/∂by; both are symbols of the scene or keys of names."""

    of: str
    by: str


@dataclass(frozen=True)
class Rate:
    """The derivative d/dt of a symbol of the scene or a key of names."""

    of: str


@dataclass(frozen=True)
class Name:
    """How a quantity is printed, None for as the symbol of the scene that the key is; its value, None for none."""

    look: Union[Letter, Slope, Rate, None]
    node: Expr | None = None


# Blocks


@dataclass(frozen=True)
class Words:
    """Prose in the language of the document; forms stand in it as inline mathematics."""

    parts: tuple[str | Form, ...]


@dataclass(frozen=True)
class Formula:
    """left = form, or left = form = right."""

    left: str  # key of `Document.names`; "" where the formula starts with `form`
    form: Form
    number: str = ""  # the source's equation number, "5.24"; "" for none
    right: Form | None = None


@dataclass(frozen=True)
class Brace:
    """One term: form · rate, with the name `under` below an under-brace around form."""

    form: Form  # the coefficient, as it is printed; its sign belongs to it
    under: str  # key of `Document.names`; "" for no brace, where `form` is the name of a long coefficient
    rate: Form


@dataclass(frozen=True)
class Braced:
    """left = Σ of under-braced terms, as (5.40)."""

    left: Form  # the drive and the other forces; ZERO for a passive joint
    terms: tuple[Brace, ...]
    value: str  # key of `Document.names`: what the sum is worth, whatever the left-hand side says it shall be
    number: str = ""

    @property
    def form(self) -> Form:
        """The same without braces."""
        return Form.sum(Form.product((term.form, term.rate)) for term in self.terms)


@dataclass(frozen=True)
class Matrix:
    """left = a matrix; of one column a vector or a bivector (force over moment)."""

    left: str  # how it is called; key of `Document.names`
    entries: tuple[Form, ...]  # forms, row by row
    names: tuple[str, ...]  # key of `Document.names` of each entry, in order
    number: str = ""
    width: int = 1  # number of columns


@dataclass(frozen=True)
class Picture:
    """A drawing."""

    svg: str  # a whole <svg> element; ids in it are unique in the document
    caption: Words
    alt: str
    key: str  # file name without ending, where a format keeps pictures in files


@dataclass(frozen=True)
class Bar:
    """One bar: a signed value and its part of the sum of absolute values, 0 to 1."""

    label: Form
    value: float
    share: float


@dataclass(frozen=True)
class Shares:
    """A bar chart of what adds up to one quantity, the total."""

    caption: Words
    total: Form
    value: float
    unit: str
    bars: tuple[Bar, ...]


@dataclass(frozen=True)
class Box:
    """A "remark", "erratum" or "check", set apart."""

    kind: str
    title: Words
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Fold:
    """What is long: shown folded where the format can, else in small print."""

    summary: Words
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Blank:
    """An exercise: a result left out."""

    key: str  # unique in the document
    ask: Words
    left: str  # what is asked for, key of `Document.names`, where its value is
    shown: Form  # what stands in front of the answer: the name, or the side of an equation that is not asked for
    answer: Form  # one right answer
    hint: Words
    solution: tuple[Block, ...]


@dataclass(frozen=True)
class Option:
    """What may be chosen: whether it is right, and why or why not."""

    text: Words
    right: bool
    reason: Words


@dataclass(frozen=True)
class Choice:
    """A question with answers to choose from, of which some are right; its key is unique in the document."""

    key: str
    ask: Words
    options: tuple[Option, ...]
    solution: tuple[Block, ...]

    @property
    def lettered(self) -> dict[str, Option]:
        """The options by letter."""
        return dict(zip("abcdefgh", self.options, strict=False))

    @property
    def right(self) -> list[str]:
        """The letters of those that are right."""
        return [letter for letter, option in self.lettered.items() if option.right]

    @property
    def listed(self) -> list[Words]:
        """Each option as a paragraph: "a) q = 0"."""
        return [Words((f"{letter}) ", *option.text.parts)) for letter, option in self.lettered.items()]


@dataclass(frozen=True)
class Room:
    """Empty lines on a sheet, to write on by hand."""

    lines: int


Block = Union[Words, Formula, Braced, Matrix, Picture, Table[Words], Shares, Box, Fold, Blank, Choice, Room]


Questions = (Blank, Choice)
"""Blocks that wait for an answer; each has a key, what is asked, and a solution."""


# The document

ERRATA = "errata:"
"""What stands before the key of a step that tells what the textbook has wrong in it."""


RESULTS = ("lagrangian", "equation", "explicit", "uniform", "reduced", "eliminated", "nutation", "result", "impact")
"""Steps that end in what a lesson is for, by their key or what stands there before a colon; others are the way."""

BRIEF = frozenset(
    (
        *("scene", "task", "coordinates", "acting", "notation", "tie", "ties.silent", "unknowns", "count", "free"),
        *(*RESULTS, "derived", "multipliers", "ratios", "substituted", "law:system", "solved", "reactions", "contacts"),
        *("equilibria", "near:stable", "steady", "energy", "limits", "power", "formulations", "momenta", "matter"),
        *("ties.solved", "equilibria.one", "steady.curve", "forced", "forced.response", "kept", "spins", "states"),
        *("euler", "precession", "upright:0", "variant", "given", "physics", "solution", "follows", "later", "errata"),
        *("conserved", "cyclic"),
    )
)
"""Steps of a brief lesson, by their key or what stands there before a colon; of the rest a page has folds."""


@dataclass(frozen=True)
class Try:
    """A parameter or a velocity to move at a sentence, and its value, in its unit, where what is said changes."""

    name: str
    threshold: float
    unit: str


@dataclass(frozen=True)
class Step:
    """One step of a derivation.

    Attributes:
        key: unique in the document, the same in every language.
        claim: what is shown, one sentence; no parts for boxes about the step before.
        blocks: the mathematics.
        reason: why it is so; no parts where the blocks say it.
        reference: where it comes from, "(5.24)"; "" for none.
        show: words of `symdyn.teach.render.html`, what the figure of a page shows; none for those before.
        needs: keys of blanks that are answered or given up before the step is shown.
        tries: sliders that a page with a moving figure has below the blocks.
    """

    key: str
    claim: Words
    blocks: tuple[Block, ...]
    reason: Words = Words(())
    reference: str = ""
    show: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    tries: tuple[Try, ...] = ()

    @property
    def is_result(self) -> bool:
        """Whether its last formula is a result, which is framed."""
        return bool(self.blocks) and self.key.partition(":")[0] in RESULTS

    @property
    def framed(self) -> slice:
        """Which blocks stand in a frame: of a result the last formulas that follow each other."""
        known = [k for k, block in enumerate(self.blocks) if isinstance(block, (Formula, Braced))]
        if not self.is_result or not known:
            return slice(0, 0)
        first = next(k for k in reversed(known) if k - 1 not in known)
        return slice(first, known[-1] + 1)

    @property
    def is_brief(self) -> bool:
        """Whether a brief lesson has it."""
        return not BRIEF.isdisjoint((self.key, self.key.partition(":")[0]))

    def opened(self) -> Iterator[Block]:
        """Yield every block, those inside boxes, folds and solutions too."""
        for block in self.blocks:
            yield from _opened(block)

    def spoken(self) -> tuple[Block, ...]:
        """Return all that it says as blocks."""
        reference = (f" {self.reference}",) if self.reference else ()
        claim = Words((*self.claim.parts, *reference))
        return tuple(one for one in (claim, *self.blocks, self.reason) if not isinstance(one, Words) or one.parts)

    @property
    def asks(self) -> bool:
        """Whether it waits for an answer."""
        return any(isinstance(block, Questions) for block in self.blocks)


@dataclass(frozen=True)
class Section:
    """A part of the document: key the same in every language, a title, steps."""

    key: str
    title: str
    steps: tuple[Step, ...]

    def runs(self, folded: Callable[[Step], bool]) -> Iterator[tuple[bool, tuple[Step, ...]]]:
        """Yield steps that follow each other and are folded, or are not."""
        yield from ((hidden, tuple(steps)) for hidden, steps in groupby(self.steps, folded))


@dataclass(frozen=True)
class Document:
    """A walkthrough.

    Attributes:
        language: "en", "sk".
        graph: where the values of names live.
        names: how keys in formulas are printed, and what they are worth.
        formulation: a key of `FORMULATIONS` in `handout.py`.
        declared: the scene where it has states of its own, which are parameters of `scene`.
        played: the run of its page through the contacts that `scene` has been taken without.
        brief: whether steps that are not `Step.is_brief` are folded, or left out of what cannot fold.
    """

    title: str
    language: str
    scene: Scene
    graph: Graph
    names: Mapping[str, Name]
    sections: tuple[Section, ...]
    formulation: str = "lagrange"
    brief: bool = False
    declared: Scene | None = None
    played: Played | None = None

    def blocks(self) -> Iterator[tuple[Step, Block]]:
        """Yield every block with its step, those inside boxes, folds and solutions too."""
        for step in (step for section in self.sections for step in section.steps):
            yield from ((step, block) for block in step.opened())

    def forms(self) -> Iterator[Form]:
        """Yield every form that stands in a display."""
        for _, block in self.blocks():
            if isinstance(block, Matrix):
                yield from block.entries
            elif isinstance(block, Formula):
                yield from (block.form,) if block.right is None else (block.form, block.right)
            elif isinstance(block, Braced):
                yield from (term.form for term in block.terms)

    def value(self, form: Form) -> Expr:
        """Return what a form is worth on the graph: names in it are replaced by their values."""
        node = form.express(self.graph)
        symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
        known = {x: found.node for x in symbols if (found := self.names.get(str(x.value))) and found.node is not None}
        return substitute([node], known)[0]

    def kept(self) -> Document:
        """Return what paper has of a brief document: brief steps, questions, and sections that keep one."""
        if not self.brief:
            return self
        cited = {"state"} if {"errata", "reactions"} & {one.key for one in self.sections} else set[str]()  # its numbers
        sections = [
            replace(part, steps=tuple(x for x in part.steps if x.is_brief or x.asks or x.key in cited))
            for part in self.sections
        ]
        return replace(self, sections=tuple(section for section in sections if section.steps))

    def folds(self, step: Step) -> bool:
        """Whether a page has a step in a fold: of a brief document what is not brief, and what a textbook has wrong."""
        return self.brief and (not step.is_brief or step.key.startswith(ERRATA))

    def in_folds(self, section: Section) -> Iterator[tuple[Step, tuple[Step, ...]]]:
        """Yield what a text without an order of its own for folds has of a section, and the steps that it is made of.

        Folded steps, but for questions, are blocks of one fold.
        """
        summary = language_of(self.language).lesson["page.more"]
        for folded, run in section.runs(lambda step: self.folds(step) and not step.asks):
            if not folded:
                yield from ((step, (step,)) for step in run)
                continue
            inside = tuple(block for step in run for block in step.spoken())
            fold = Fold(Words((summary.format(count=len(run)),)), inside)
            yield Step(f"more:{run[0].key}", Words(()), (fold,)), run


def _opened(block: Block) -> Iterator[Block]:
    yield block
    inside = block.blocks if isinstance(block, (Box, Fold)) else block.solution if isinstance(block, Questions) else ()
    for inner in inside:
        yield from _opened(inner)
