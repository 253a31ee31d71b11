"""What would give an answer away: written-out results that follow from what an exercise asks, or are worth the same."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from math import isclose

from symdyn.algebra.form import Form, Symbol, symbols_of
from symdyn.algebra.numeric import Floats
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.teach.document import (
    ERRATA,
    Blank,
    Block,
    Box,
    Braced,
    Document,
    Fold,
    Formula,
    Matrix,
    Picture,
    Step,
    Values,
    Words,
)
from symdyn.teach.student.vocabulary import Names

FOLLOWS = {
    "kinetic": ("square",),
    "energies": ("square", "potential"),
    "lagrangian": ("square", "potential"),
    "rate": ("momentum",),
    "meaning": ("coefficients",),
}
"""Steps, by what stands before the colon of their keys, that write out what follows from those asked."""

ALIKE = ("kinetic", "rate")
"""Those that follow from the one asked of the same mass or coordinate alone."""

WHOLE = "meaning"
"""Those whose blocks hang together: they are hidden or stay together, but for pictures."""


class Hidden:
    """What is hidden while some steps of a document are asked for."""

    def __init__(self, document: Document, asked: Sequence[Step]) -> None:
        """Begin with the steps that have blanks."""
        self.document = document
        self.keys = [step.key for step in asked]
        self.own = set(Names(document.scene).symbols.values()) - {
            k for k, name in document.names.items() if name.node is not None
        }
        blanks = [block for step in asked for block in step.blocks if isinstance(block, Blank)]
        self.points: list[dict[str, float]] = [{}, {}]
        self.answers = [self._values(document.value(blank.answer)) for blank in blanks]

    def parts(self, step: Step) -> tuple[list[Block], list[Block]]:
        """Return the blocks of a step that may stay, and those that tell an answer."""
        hide = self._writes if self._follows(step) else self._tells
        hidden: list[Block] = [block for block in step.blocks if not isinstance(block, Blank) and hide(block)]
        if hidden and step.key.partition(":")[0] == WHOLE:
            hidden = [block for block in step.blocks if not isinstance(block, Picture)]
        return [block for block in step.blocks if not any(block is one for one in hidden)], hidden

    def _follows(self, step: Step) -> bool:
        kind, _, rest = step.key.removeprefix(ERRATA).partition(":")
        if kind in ALIKE:
            return any(f"{source}:{rest}" in self.keys for source in FOLLOWS[kind])
        return any(key.partition(":")[0] in FOLLOWS.get(kind, ()) for key in self.keys)

    def _writes(self, block: Block) -> bool:
        """Whether a block writes something out in symbols of the scene alone, or tells an answer."""
        return any(map(self._plain, _written_out(block))) or self._tells(block)

    def _plain(self, form: Form) -> bool:
        found = set(symbols_of(form))
        return bool(found) and found <= self.own

    def _tells(self, block: Block) -> bool:
        """Whether a formula, more than a name, is worth an answer, its sign apart; tables and prose name symbols."""
        if isinstance(block, (Values, Words)):
            return False
        forms = [form for form in _written_out(block) if self._plain(form) and not isinstance(form, Symbol)]
        return any(self._is_answer(self.document.value(form)) for form in forms)

    def _is_answer(self, node: Expr) -> bool:
        found = self._values(node)
        return any(
            all(isclose(x, sign * y, rel_tol=1e-9, abs_tol=1e-12) for x, y in zip(found, answer, strict=True))
            for answer in self.answers
            for sign in (1, -1)
        )

    def _values(self, node: Expr) -> list[float]:
        """Return the values at points that are the same for all."""
        values = []
        symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
        for k, point in enumerate(self.points):
            for x in symbols:
                name = str(x.value)
                point.setdefault(name, random.Random(f"{k}:{name}").uniform(0.25, 2.0))
            values.append(evaluate([node], Floats(), {x: point[str(x.value)] for x in symbols})[0])
        return values


def _written_out(block: Block) -> Iterator[Form]:
    """Yield the right-hand sides of a block, of tables and prose all forms."""
    if isinstance(block, Formula):
        yield from (form for form in (block.form, block.right) if form is not None)
    elif isinstance(block, Braced):
        yield from (block.form, *(term.form for term in block.terms))
    elif isinstance(block, Matrix):
        yield from block.entries
    elif isinstance(block, (Box, Fold)):
        yield from (form for inner in block.blocks for form in _written_out(inner))
    elif isinstance(block, (Values, Words)):
        cells = [cell for row in block.rows for cell in row] if isinstance(block, Values) else [block]
        yield from (part for cell in cells for part in cell.parts if not isinstance(part, str))
