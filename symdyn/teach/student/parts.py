"""Which terms of a wrong answer differ: lost, turned or with another factor, two at once too, found by value.

    mine / factor = Σ c_k t_k        c_k = 1 right, 0 lost, -1 turned

The factor is 1, or what makes the coefficient of one acceleration that of the scene's equation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from symdyn.algebra import Form
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient
from symdyn.teach.student.course import Course
from symdyn.teach.student.differences import split_terms
from symdyn.teach.student.wrong_energies import used

MOST, MOST_WRONG = 10, 3
"""Terms of a result that is taken apart, and how many may be wrong at once."""

LOST = {"gravity": "weightless", "spring": "spring", "load": "friction", "rates": "velocities"}
TURNED = {"gravity": "gravity", "spring": "spring", "load": "friction"}
SUITS = {
    "gravity": ("gravity", "weightless", "height", "energies", "direction"),
    "spring": ("spring",),
    "load": ("friction",),
    "rates": ("product", "slope", "velocities", "chain", "cross", "relative"),
    "inertia": ("coupling", "steiner", "inertia", "half", "carried", "relative", "cross", "body", "arm", "term"),
    "drive": (),
}
"""Rules by what the terms are of that they explain."""


@dataclass(frozen=True)
class Term:
    """One term of a right result: its kind, its formula and its value."""

    kind: str
    form: Form
    node: Expr


def terms_of(course: Course, key: str) -> list[Term]:
    """Return the terms of a quantity, none where they are too many; of an equation those of what vanishes."""
    try:
        return list(islice(_terms(course, key), MOST + 1))[: MOST + 1] if key else []
    except DerivationError:
        return []


def _terms(course: Course, key: str) -> Iterator[Term]:
    graph, e = course.graph, course.right
    kinetic, potential = graph.total(e.K.values()), {k: v for k, v in e.P.items() if k != "E"}
    parts: list[tuple[str, Expr]] = []
    if key.startswith("tau:"):
        i = int(key.partition(":")[2]) - 1
        inertial, product, slope, _ = course.steps(i, kinetic, graph.zero)
        gravity, elastic = (course.slope(x, course.state.q[i]) for x in (graph.total(potential.values()), e.P["E"]))
        drive = course.scene.drives[i]
        parts = [("inertia", inertial), ("rates", product - slope), ("gravity", gravity), ("spring", elastic)]
        parts += [("load", -e.Q[i]), ("drive", -graph.symbol(drive) if drive else graph.zero)]
    elif key in ("P:", "L:", "K:"):
        sign = -1 if key == "L:" else 1
        parts = [("inertia", kinetic)] if key != "P:" else []
        if key != "K:":
            parts += [("gravity", sign * graph.total(potential.values())), ("spring", sign * e.P["E"])]
    elif key.removeprefix("dL:/d") in course.scene.coordinates:
        q = graph.symbol(key.removeprefix("dL:/d"))
        energies = (("rates", kinetic), ("gravity", -graph.total(potential.values())), ("spring", -e.P["E"]))
        parts = [(kind, course.slope(energy, q)) for kind, energy in energies]
    elif key.startswith(("k_z", "dL:")) and (node := course.value(key, e)) is not None:
        parts = [("inertia", node)]
    for kind, node in parts:
        if not node.is_zero:
            for form in split_terms(Form.of(node), course.scene):
                yield Term(kind, form, form.express(graph))


def accelerations(course: Course, key: str) -> list[tuple[str, Expr]]:
    """Return the accelerations of an equation and their coefficients."""
    node = course.value(key, course.right) if key.startswith("tau:") else None
    if node is None:
        return []
    found = used(node, course.state.qdd)
    return [(str(a.value), x) for a, x in zip(found, gradient(node, found), strict=True)]


def fitted(mine: Sequence[float], columns: Sequence[Sequence[float]]) -> list[float] | None:
    """Return the coefficients with which some columns are an answer, None where they are not, or all are right."""
    A, b = np.array(columns).T, np.array(mine)
    if A.size == 0 or len(b) < A.shape[1] or not (np.isfinite(A).all() and np.isfinite(b).all()):
        return None
    found = np.linalg.lstsq(A, b, rcond=1e-9)[0]
    if np.abs(A @ found - b).max() > 1e-7 * max(np.abs(b).max(), np.abs(A).max()):
        return None
    wrong = int((np.abs(found - 1) > 1e-6).sum())
    return found.tolist() if 0 < wrong <= min(MOST_WRONG, max(1, len(found) - 1)) else None


def named(terms: Sequence[Term], found: Sequence[float], rule: str) -> list[tuple[str, Term]]:
    """Return the rules that wrong coefficients tell, with the terms, that which was found before first if it suits."""
    wrong = [(c, term) for c, term in zip(found, terms, strict=True) if abs(c - 1) > 1e-6]
    told = []
    for c, term in wrong:
        if abs(c) < 1e-6:
            told.append((LOST.get(term.kind, "term"), term))
        elif abs(c + 1) < 1e-6:
            told.append((TURNED.get(term.kind, "termsign"), term))
        else:
            told.append(("termfactor", term))
    fits = [term for _, term in wrong if rule in SUITS[term.kind]]
    if fits and len(told) == 1 and told[0][0].startswith("term"):  # the rule says more than that a term differs
        return [(rule, fits[0])]
    return [*told, *([(rule, fits[0])] if fits and rule not in [one for one, _ in told] else [])]
