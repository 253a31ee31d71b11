"""A document as one HTML page that needs nothing else: mathematics in MathML, pictures inside, exercises that answer.

A formula is written in pieces, one a term, which the browser sets in lines of any width; what is wider scrolls. Numbers
stand under terms whose value the program of the page computes. Its figure shows the words of `Step.show`, and the
vector that a term of a formula speaks of.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Union

from symdyn.algebra import Form, Number, Symbol
from symdyn.draw import style
from symdyn.dynamics.mechanism import body_placements
from symdyn.emit import in_html, render
from symdyn.emit.code import page_stem, stem
from symdyn.emit.print import BREAK, latex_width
from symdyn.errors import DerivationError, TeachError
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene.values import acceleration_name
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
    Questions,
    Room,
    Shares,
    Step,
    Try,
    Words,
)
from symdyn.teach.languages import language_of
from symdyn.teach.lesson import masses
from symdyn.teach.mathematics import PART, Spelling, flow, inline, pieces, with_words
from symdyn.teach.practice.questions import questions
from symdyn.teach.render.live import absence
from symdyn.teach.render.page import Interactive, interactive

SHOWN: tuple[str, ...] = (
    *("names", "frames", "angles", "places", "velocities", "accelerations", "weights", "forces", "inertia"),
    *("coriolis", "centrifugal", "momenta", "reactions", "energies", "plots", "phase", "trails", "ghost", "cone"),
)
"""Words that stand alone; `body:NAME` and `joint:NAME` point at one."""

OF_A_MASS: Mapping[str, str] = {
    **dict.fromkeys(("x", "y", "z"), "places"),
    **dict.fromkeys(("dx", "dy", "dz", "v2", "K"), "velocities"),
    "P": "weights",
}
"""By what stands before the colon of a name's key; behind it, the number of a mass."""

OF_ALL: Mapping[str, str] = {
    "k_z": "inertia",
    "Mz": "inertia",
    "k_C": "coriolis",
    "k_D": "centrifugal",
    "k_G": "weights",
    "MG": "weights",
    "k_E": "forces",
    **dict.fromkeys(("FD", "MD", "F*D", "M*D"), "inertia"),
    **dict.fromkeys(("FR", "MR", "F*R", "M*R", "reaction"), "reactions"),
    **dict.fromkeys(("FA", "MA", "F*A", "M*A"), "weights"),
}

BY_STEP: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("scene", "task", "coordinates"), ("angles", "names")),
    "notation": ("frames",),
    "position": ("angles", "places"),
    "energies": ("velocities", "weights", "energies"),
    "lagrangian": ("velocities", "weights", "energies"),
    "momentum": ("momenta",),
    "rate": ("accelerations",),
    "equation": ("inertia", "weights", "forces"),
    "coefficients:k_z": ("inertia",),
    "coefficients:k_C": ("coriolis",),
    "coefficients:k_D": ("centrifugal",),
    "coefficients:k_G": ("weights",),
    "state": ("angles",),
    "torque": ("inertia", "coriolis", "centrifugal", "weights"),
    "moved": ("accelerations", "inertia"),
    "about": ("accelerations", "inertia"),
    "balance": ("weights", "inertia", "reactions", "forces"),
    "substituted": ("weights", "inertia", "reactions", "forces"),
    "power": ("energies", "plots"),
}
"""What a step shows that does not say it, by its key or what stands there before a colon."""

_IN_ITS_OWN_FRAME = re.compile(r"(\d)\1(?![\d])")  # F_22 is about body 2, in frame 2


@dataclass(frozen=True)
class Owners:
    """Whose vectors names speak of."""

    masses: Mapping[str, str]  # bodies by the number of a mass
    bodies: tuple[str, ...] = ()  # by number, the first at 0
    carriers: Mapping[str, str] = field(default_factory=dict)  # joints by the body that they carry


def pointed(key: str, owners: Owners) -> str:
    """Return what a name of a document speaks of, or "".

    Such as "velocities:arm"; "inertia", that of all; "coriolis/0,1", for k_C of velocities 0 and 1.
    """
    kind, _, rest = key.partition(":")
    if kind in OF_A_MASS:
        known = owners.masses.get(rest, "")
        return f"{OF_A_MASS[kind]}:{known}" if known else "" if rest else OF_A_MASS[kind]
    found = OF_ALL.get(kind.removesuffix("bar"), "")
    if found in ("coriolis", "centrifugal"):
        by = [str(int(number) - 1) for number in rest.split(",")[1:] if number.isdigit()]
        return f"{found}/{','.join(by)}" if by else found
    joint = rest.split(":")[0].partition(",")[2] or (rest.split(":")[0] if kind == "reaction" else "")
    if joint in owners.carriers.values():
        return f"{found}:{joint}" if found == "reactions" else found
    of = _IN_ITS_OWN_FRAME.match(rest)
    if found and of and int(of[1]) <= len(owners.bodies):
        body = owners.bodies[int(of[1]) - 1]
        return f"{found}:{owners.carriers[body]}" if found == "reactions" else f"{found}:{body}"
    return found


MOST = 6000
"""Nodes of the graph that all numbers of a page may need, else it has none: its script computes them as it moves."""

Shown = Union[Formula, Braced]


class Numbered:
    """The values that stand below the terms of one document, in the order in which they were first asked for.

    Attributes:
        values: nodes on the document's graph; their symbols are of the state and the parameters.
    """

    def __init__(self, document: Document) -> None:
        """Know the symbols that the figure of the document moves."""
        scene = document.scene
        accelerations = [acceleration_name(velocity) for velocity in scene.velocities]
        parameters = [parameter.name for parameter in scene.parameters]
        self.values: list[Expr] = []
        self._document = document
        self._symbols = {*scene.coordinates, *scene.velocities, *accelerations, *parameters}
        self._places: dict[Expr, int] = {}
        graph = Graph()
        found = masses(scene, graph, body_placements(scene, graph))
        self._owners = Owners(
            {one.tag: one.body.name for one in found},
            tuple(body.name for body in scene.bodies),
            {joint.child: joint.name for joint in scene.joints},
        )
        shown = [block for _, block in document.blocks() if isinstance(block, (Formula, Braced))]
        self._pieces = {block: list(self._terms(block)) for block in shown}
        wanted = [value for terms in self._pieces.values() for _, value in terms if value is not None]
        self._too_long = len(reachable(wanted)) > MOST

    def marks(self, block: Shown, count: int) -> str:
        """Return attributes of a formula that is printed in `count` pieces: places of values, and what pieces speak of.

        "-" stands for a piece without; no attributes where no piece has any, or the pieces are not the terms.
        """
        terms = self._pieces[block]
        if self._too_long or len(terms) != count:
            return ""
        places = [str(self._place(value)) if value is not None else "-" for _, value in terms]
        about = [self._about(form) for form, _ in terms]
        left = pointed(_key(block), self._owners)
        about = [one or left or "-" for one in about]
        return _attribute("n", places) + _attribute("at", about)

    def shown(self, step: Step) -> tuple[str, ...]:
        """Return what the figure shows while a step is read; what its terms speak of where nobody says it."""
        for known in (step.show, BY_STEP.get(step.key), BY_STEP.get(step.key.partition(":")[0])):
            if known:
                return known
        found: dict[str, None] = {}
        for block in step.blocks:
            if isinstance(block, (Formula, Braced)):
                for form, _ in self._pieces[block]:
                    about = self._about(form) or pointed(_key(block), self._owners)
                    found[about.partition(":")[0].partition("/")[0]] = None
        return tuple(word for word in found if word)

    def _terms(self, block: Shown) -> Iterator[tuple[Form | None, Expr | None]]:
        """Yield of each piece that is printed what it speaks of and its value, None where none is to be shown."""
        if isinstance(block, Braced):
            yield None, self._named(block.value) if block.left != Number.ZERO else None
            if not block.terms:
                yield None, None
            for brace in block.terms:
                about = Symbol(brace.under) if brace.under else brace.form
                yield about, self._value(Form.product((brace.form, brace.rate)))
            return
        terms = _terms_or_zero(block.form)
        if block.left:
            yield None, self._named(block.left) if len(terms) > 1 else None
        for term in (*terms, *(_terms_or_zero(block.right) if block.right is not None else ())):
            yield term, self._value(term)

    def _named(self, key: str) -> Expr | None:
        name = self._document.names.get(key)
        return name.node if name is not None else None

    def _value(self, form: Form) -> Expr | None:
        """Return what a term is worth; None for a number, which says so itself."""
        node = self._document.value(form)
        return None if node.op is Op.CONSTANT else node

    def _place(self, node: Expr) -> int | str:
        """Return where a value stands among those of the page, "-" for one that the page does not compute."""
        if node not in self._places:
            if not all(one.op is not Op.SYMBOL or str(one.value) in self._symbols for one in reachable([node])):
                return "-"
            self._places[node] = len(self.values)
            self.values.append(node)
        return self._places[node]

    def _about(self, form: Form | None) -> str:
        keys = form.symbols if form is not None else []
        return next((found for key in keys if (found := pointed(key, self._owners))), "")


def _terms_or_zero(form: Form) -> tuple[Form, ...]:
    return tuple(form.terms) or (Number.ZERO,)


def _key(block: Shown) -> str:
    return block.left if isinstance(block, Formula) else ""


def _attribute(name: str, entries: list[str]) -> str:
    if all(entry == "-" for entry in entries):
        return ""
    return f' data-{name}="{in_html("|".join(entries))}"'


_KEPT = re.compile("<math(?:(?!<math).)*?</math>(?:\u00a0[^\\s<]+)+")  # else browsers part a line at the formula
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
            "runs": [
                (page.text["page.more"].format(count=len(run)) if folded else "", [page.step(step) for step in run])
                for folded, run in section.runs(document.folds)
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
    return with_words(render("teach/walkthrough.html.jinja", values), language_of(document.language).page)


def _live(document: Document, numbered: Numbered) -> tuple[Interactive | None, str]:
    """Return the part with sliders; for a mechanism that they cannot move None, and why."""
    told, states = document.language, document.declared.states if document.declared else ()
    try:
        return interactive(document.scene, None, told, numbered.values, states, document.played), ""
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
        self.blanks = [block.key for _, block in document.blocks() if isinstance(block, Questions)]

    def numbers(self, keys: Iterable[str]) -> str:
        """Return the numbers of blanks, from 0, as a page writes what a step needs."""
        return " ".join(str(self.blanks.index(key)) for key in keys)

    def words(self, words: Words) -> str:
        text = "".join(in_html(x, quote=False) if isinstance(x, str) else self._inline(x) for x in words.parts)
        return _KEPT.sub(r'<span class="kept">\g<0></span>', text)

    def _inline(self, form: Form) -> str:
        """Return a formula in a line of text; a long one in pieces."""
        latex = self.spell.inline(form)
        return inline(latex) if latex_width(latex) < SHORT else f'<span class="run">{flow("", self.spell(form))}</span>'

    def step(self, step: Step) -> dict[str, object]:
        """Return the places of the template."""
        return {
            "key": _anchor(step.key),
            "claim": self.words(step.claim),
            "reference": in_html(step.reference),
            "blocks": self.blocks(step),
            "result": step.is_result,
            "tries": [self.tried(one) for one in step.tries],
            "reason": self.words(step.reason),
            "show": in_html(" ".join(self.numbered.shown(step))),
            "needs": self.numbers(step.needs),
        }

    def blocks(self, step: Step) -> list[str]:
        """Return the elements of a step, a result in its frame."""
        before, framed, after = (
            [text for block in step.blocks[part] for text in self.block(block)]
            for part in (slice(step.framed.start), step.framed, slice(step.framed.stop, None))
        )
        return [*before, *(['<div class="frame">', *framed, "</div>"] if framed else []), *after]

    def tried(self, one: Try) -> dict[str, str]:
        """Return the slider of a threshold: twice as far, in the middle where what the sentence says changes."""
        scene, words = self.document.scene, language_of(self.document.language).page
        groups = {"params": [parameter.name for parameter in scene.parameters], "qd": scene.velocities}
        entry = next(f"{group} {names.index(one.name)}" for group, names in groups.items() if one.name in names)
        label, unit = inline(self.spell.symbols[one.name]), in_html(scene.shown_unit(one.unit))
        text = words["try"].format(name=label, value=self.spell.written(one.threshold), unit=unit)
        low, high = (f"{x:.6g}" for x in sorted((0.02 * one.threshold, 2 * one.threshold)))
        return {"entry": entry, "unit": unit, "text": text, "low": low, "high": high}

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
            still = ' class="still"' if block.key == "scene" else ""  # what moves stands for it on a screen
            yield f"<figure{still}>{svg.strip()}<figcaption>{self.words(block.caption)}</figcaption></figure>"
        elif isinstance(block, Table):
            yield f'<div class="scroll" tabindex="0">{block.html(self.words)}</div>'
        elif isinstance(block, Shares):
            yield self._bars(block)
        elif isinstance(block, Box):
            inside = "\n".join(text for part in block.blocks for text in self.block(part))
            name = f'<p class="name">{self.words(block.title)}</p>'
            yield f'<div role="note" class="box {block.kind}">{name}\n{inside}</div>'
        elif isinstance(block, Fold):
            inside = "\n".join(text for part in block.blocks for text in self.block(part))
            yield f"<details><summary>{self.words(block.summary)}</summary>\n{inside}</details>"
        elif isinstance(block, Questions):
            yield self._question(block)
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
        return (
            f'<div class="scroll" tabindex="0"><table class="shares">{caption}<tbody>\n{body}\n</tbody></table></div>'
        )

    def _question(self, blank: Blank | Choice) -> str:
        values: dict[str, object] = {
            "key": in_html(blank.key),
            "name": _anchor(blank.key),
            "ask": self.words(blank.ask),
            "number": self.numbers([blank.key]),
            "solution": [text for part in blank.solution for text in self.block(part)],
            "text": self.text,
            "options": [],
        }
        if isinstance(blank, Choice):
            options = blank.lettered.items()
            values["options"] = [(key, self.words(one.text), self.words(one.reason)) for key, one in options]
            values["several"] = len(blank.right) > 1
        else:
            values |= {"left": inline(self.spell.inline(blank.shown)), "hint": self.words(blank.hint)}
        return render("teach/blank.html.jinja", values)


def _numbered(formula: str, number: str, marks: str = "") -> str:
    tag = f'<span class="number">({in_html(number)})</span>' if number else ""
    return f'<div class="formula"><div class="flow"{marks}>{formula}</div>{tag}</div>'
