"""Formulas are put into the words of the book without a change of value."""

from __future__ import annotations

from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn.algebra.compact import with_added_angles, with_squares
from symdyn.algebra.form import Form
from symdyn.algebra.numeric import Floats
from symdyn.emit.print.formula_text import text_of
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import read, read_text
from symdyn.teach.render.markdown import markdown
from symdyn.teach.student.statements import read_formula

EXAMPLES = Path(__file__).parent.parent / "examples"
BODIES = '[parameters]\nr = { unit = "m" }\n' + "".join(
    f'[bodies.b{k}]\nmass = 1\n[joints.j{k}]\ntype = "revolute"\nparent = "{"ground" if k == 1 else f"b{k - 1}"}"\n'
    f'child = "b{k}"\naxis = [0, 0, 1]\ncoordinate = "{"abc"[k - 1]}"\n'
    for k in (1, 2, 3)
)
SCENE = read_text(BODIES, "abc.toml")


def _value(form: Form) -> float:
    graph = Graph()
    node = form.express(graph)
    symbols = sorted({str(x.value) for x in reachable([node]) if x.op is Op.SYMBOL})
    known = {graph.symbol(name): 0.3 + 0.17 * sum(map(ord, name)) % 1.3 for name in symbols}
    return float(evaluate([node], Floats(), known)[0])


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(a + 2 b) a + b^2", "(a + b)**2"),
        ("r (a + 2 b) a + r b^2", "r*(a + b)**2"),
        ("(a + 2 b + 2 c) a + (b + 2 c) b + c^2", "(a + b + c)**2"),
        ("(a + 2 b) a + c^2", None),
        ("(a + 2 b) a + 2 b^2", None),
    ],
)
def test_squares_of_sums_are_put_together(text: str, shown: str | None) -> None:
    form = read_formula(text, SCENE)
    found = with_squares(form)

    assert _value(found) == pytest.approx(_value(form), abs=1e-12)
    assert (text_of(found) if shown else found) == (shown or form)


@pytest.mark.parametrize("p", ["sin", "cos"])
@pytest.mark.parametrize("q", ["sin", "cos"])
@pytest.mark.parametrize("first", ["", "-"])
@pytest.mark.parametrize("second", ["+", "-"])
def test_addition_theorems_keep_the_value(p: str, q: str, first: str, second: str) -> None:
    other = {"sin": "cos", "cos": "sin"}
    form = read_formula(f"{first} r {p}(a + b) {q}(c) {second} r {other[p]}(a + b) {other[q]}(c) + a", SCENE)
    found = with_added_angles(form)

    assert _value(found) == pytest.approx(_value(form), abs=1e-12)
    assert len(found.terms) == 2  # type: ignore[union-attr]


@pytest.mark.mends("5.10")
def test_the_lesson_of_a_four_bar_shows_squares_of_rates_and_differences_of_angles() -> None:
    text = next(iter(markdown(lesson_of(read(EXAMPLES / "four_bar.toml"), formulation="dalembert")).values()))

    assert r"(\dot{\phi} + \dot{\psi})^2" in text
    assert r"(\dot{\phi} + 2 \dot{\psi}) \dot{\phi}" not in text
    assert r"\cos(\phi + \psi) \, \sin \chi" not in text
