"""Numbers under terms: which values of a document the program of its page computes, and what each term speaks of.

The figure of a page shows the words of `Step.show`, and the vector that a term of a formula speaks of.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Union

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import body_placements
from symdyn.emit import in_html
from symdyn.graph import Expr, Graph, Op, reachable
from symdyn.scene.values import acceleration_name
from symdyn.teach.document import Braced, Document, Formula, Step
from symdyn.teach.lesson import masses

SHOWN: tuple[str, ...] = (
    "frames",
    "angles",
    "places",
    "velocities",
    "accelerations",
    "weights",
    "forces",
    "inertia",
    "coriolis",
    "centrifugal",
    "momenta",
    "reactions",
    "energies",
    "plots",
    "phase",
    "trails",
    "ghost",
)
"""Words that stand alone; `body:NAME` and `joint:NAME` point at one."""

POINTING = ("body:", "joint:")

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
    **dict.fromkeys(("scene", "task", "coordinates"), ("angles",)),
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
    "balance": ("weights", "inertia", "reactions", "forces"),
    "power": ("energies", "plots"),
}
"""What a step shows that does not say it, by its key or what stands there before a colon."""

_IN_ITS_OWN_FRAME = re.compile(r"(\d)\1(?![\d])")  # F_22 is about body 2, in frame 2


@dataclass(frozen=True)
class Owners:
    """Whose vectors names speak of.

    Attributes:
        masses: bodies by the number of a mass.
        bodies: by number, the first at 0.
        carriers: joints by the body that they carry.
    """

    masses: Mapping[str, str]
    bodies: tuple[str, ...] = ()
    carriers: Mapping[str, str] = field(default_factory=dict)


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
