"""What stays hidden until exercises are answered: what comes after them, and what is worth the same.

The rule is the order of the derivation: a step may follow from every result before it, unless it is about another mass
or body, or a row of `APART` says otherwise. So a new kind of step leaks nothing before anyone thinks of exercises.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from math import isclose, nan

from symdyn.algebra import Floats, Form, Symbol
from symdyn.errors import NoValueError
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.table import Table
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
    Step,
    Words,
)
from symdyn.teach.student.vocabulary import Names

MASS = ("position", "rotation", "turning", "velocity", "square", "spin", "offset", "kinetic", "potential")
BODY = ("free", "frame", "moved", "bivectors", "balance")
OF_ONE = (*MASS, *BODY)
"""Kinds of steps about one mass or body, which is what stands behind the colon of their keys."""

APART = {
    "potential": ("velocity", "turning", "square", "spin", "offset", "kinetic"),
    "rotation": ("position",),
    "turning": ("position", "velocity"),
    "spin": ("position", "velocity", "square"),
    "rotor": MASS,
    "springs": MASS,
}
"""Kinds of steps that come after others and do not follow from them."""


def follows(step: str, requested: str) -> bool:
    """Whether a step, by its key, may follow from another one that comes before it."""
    kind, _, of = step.removeprefix(ERRATA).partition(":")
    source, _, other = requested.partition(":")
    if kind in OF_ONE and source in OF_ONE and of != other:
        return False
    return source not in APART.get(kind, ())


def plain(form: Form, own: frozenset[str]) -> bool:
    """Whether a form is written out: more than a name or a number, in symbols of the scene alone."""
    found = set(form.symbols)
    return bool(found) and found <= own and not isinstance(form.split_sign()[1], Symbol)


def own_symbols(document: Document) -> frozenset[str]:
    """Return the symbols of the scene, without those that the document gives a value, such as drives."""
    return frozenset(Names(document.scene).symbols.values()) - {k for k, x in document.names.items() if x.node}


class Hidden:
    """Answers by value, to find where else one of them stands."""

    def __init__(self, document: Document, answers: Mapping[str, Form]) -> None:
        """Begin with the answers by keys of blanks."""
        self.document, self.own = document, own_symbols(document)
        self.points: list[dict[str, float]] = [{}, {}]
        self.answers = {key: self._values(document.value(form)) for key, form in answers.items()}

    def by(self, step: Step) -> Iterator[str]:
        """Yield the blanks that a step gives away: a formula in it is worth the answer, its sign apart."""
        forms = [form for block in (step.claim, *step.blocks, step.reason) for form in written_out(block)]
        found = [self._values(self.document.value(form)) for form in forms if plain(form, self.own)]
        for key, answer in self.answers.items():
            if any(self._alike(one, answer, sign) for one in found for sign in (1, -1)):
                yield key

    @staticmethod
    def _alike(result: list[float], answer: list[float], sign: int) -> bool:
        pairs = zip(result, answer, strict=True)
        return all(isclose(x, sign * y, rel_tol=1e-9, abs_tol=1e-12) for x, y in pairs)

    def _values(self, node: Expr) -> list[float]:
        """Return the values at points that are the same for all, NaN where there is none, which is like nothing."""
        values = []
        symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
        for k, point in enumerate(self.points):
            for x in symbols:
                name = str(x.value)
                point.setdefault(name, random.Random(f"{k}:{name}").uniform(0.25, 2.0))
            try:
                values.append(evaluate([node], Floats(), {x: point[str(x.value)] for x in symbols})[0])
            except NoValueError:  # a rod is too short there
                values.append(nan)
        return values


def written_out(block: Block) -> Iterator[Form]:
    """Yield the right-hand sides of a block, of tables and prose all forms; of what is asked nothing."""
    if isinstance(block, Formula):
        yield from (form for form in (block.form, block.right) if form is not None)
    elif isinstance(block, Braced):
        yield from (block.form, *(term.form for term in block.terms))
    elif isinstance(block, Matrix):
        yield from block.entries
    elif isinstance(block, (Box, Fold)):
        yield from (form for inner in block.blocks for form in written_out(inner))
    elif isinstance(block, Blank):
        yield from (part for part in block.ask.parts if not isinstance(part, str))
    elif isinstance(block, (Table, Words)):
        cells = [cell for row in block.rows for cell in row] if isinstance(block, Table) else [block]
        yield from (part for cell in cells for part in cell.parts if not isinstance(part, str))
