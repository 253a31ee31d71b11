"""A formula of a student's beside that of one quantity: equal by value, or in which terms it differs."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra import Form, Number
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph
from symdyn.scene import Scene
from symdyn.teach.student.answer import EQUAL, ROUNDED, Answer
from symdyn.teach.student.differences import differences
from symdyn.verdict import Verdict
from symdyn.verify import Claim, Finding, prove

MANY = 400  # differences, which no answer lists


def minus(form: Form) -> Form:
    """Return -form."""
    return Form.sum([Form.product((Number.MINUS_ONE, form))])


def less(a: Form, b: Form) -> Form:
    """Return a - b."""
    return Form.sum((a, Form.product((Number.MINUS_ONE, b))))


def judged(line: int, name: str, form: Form, right: Form, scene: Scene, kind: str) -> Answer:
    """Return the answer to a formula of a quantity, or of a row."""
    finding = equality(name, form, right, scene)
    if finding.verdict != Verdict.DIFFERENT:
        return Answer(line, name, finding.verdict, finding.error_log10)
    if kind.startswith(("P", "L")) and (constant := _free(less(form, right), scene)) is not None:
        return Answer(line, name, Verdict.PROVED, finding.error_log10, shifted=constant)
    values = _values(form, right, scene)
    if values and equality(name, form, right.substitute(values), scene).verdict in EQUAL:
        return Answer(line, name, Verdict.PROVED, valued=tuple(values))
    if equality(name, form, minus(right), scene).verdict in EQUAL:
        return Answer(line, name, Verdict.DIFFERENT, turned=True)
    try:
        listed = differences(form, right, scene)
    except DerivationError:
        listed = []
    if listed and all(d.kind == "rounded" for d in listed):
        return Answer(line, name, ROUNDED, differences=tuple(listed))
    return Answer(line, name, Verdict.DIFFERENT, differences=tuple(listed[:MANY]))


def _values(form: Form, right: Form, scene: Scene) -> dict[str, Form]:
    """Return the numbers of parameters that only the right formula names."""
    absent = set(right.symbols) - set(form.symbols)
    values = {p.name: p.value for p in scene.parameters if p.name in absent and p.value is not None}
    return {name: Form.of(value.express(Graph())) for name, value in values.items()}


def equality(name: str, form: Form, right: Form, scene: Scene) -> Finding:
    """Return whether two forms are the same function."""
    graph = Graph()
    return same_value(name, form.express(graph), right.express(graph), scene)


def same_value(name: str, node: Expr, right: Expr, scene: Scene) -> Finding:
    """Return whether two nodes of one graph are the same function."""
    return findings([Claim(name, "found", "scene", (node,), (right,))], scene)[0]


def findings(claims: Sequence[Claim], scene: Scene) -> list[Finding]:
    """Return what becomes of claims about a scene."""
    return prove(claims, positive=[p.name for p in scene.parameters if p.positive])[1]


def _free(form: Form, scene: Scene) -> Form | None:
    """Return the value of a form if it depends on parameters only: it is looked at term by term."""
    try:
        left = [
            d.found or Form.product((Number.MINUS_ONE, d.right or Number.ZERO))
            for d in differences(form, Number.ZERO, scene)
        ]
    except DerivationError:
        return None
    moving = {*scene.coordinates, *scene.velocities}
    return Form.sum(left) if not any(moving & set(term.symbols) for term in left) else None
