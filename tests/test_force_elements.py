"""Every kind of force element: its row is complete, and its force is the slope of its energy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from wide import everything

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.dynamics.mechanism.state import pull, resisting, stored, stored_between
from symdyn.graph import Expr, Graph, Op, evaluate, gradient, reachable
from symdyn.scene.forces import FORCES, elastic
from symdyn.scene.forces.force_kind import Mark, Pull
from symdyn.scene.values import Strut
from symdyn.scene.values.key import needed_of
from symdyn.teach.languages import languages

WIDE = everything()

PULLS = {name: kind.law for name, kind in FORCES.items() if isinstance(kind.law, Pull)}

PICTURE = Path(symdyn.__file__).parent.parent / "templates" / "teach" / "interactive_picture.js"

PLACES = (0.3, 0.9, 2.2)


def at(nodes: list[Expr], x: float) -> list[float]:
    """Return values with x at a place and every parameter 1.3."""
    leaves = {node for node in reachable(nodes) if node.op is Op.SYMBOL}
    return evaluate(nodes, Floats(), {node: x if node.value == "x" else 1.3 for node in leaves})


@pytest.mark.parametrize("name", [name for name, kind in FORCES.items() if kind.section != "joints"])
def test_every_kind_has_words_in_every_language_and_keys_that_it_needs(name: str) -> None:
    kind = FORCES[name]

    assert set(kind.words) == set(languages())
    assert set(kind.needs) <= {key for part in kind.parts for key in part.keys}
    needed = needed_of(kind.parts) or any(part.rules for part in kind.parts)
    assert any(key in kind.missing for key in kind.needs) or (needed and not kind.missing)


@pytest.mark.parametrize("name", PULLS)
def test_every_strut_has_a_mark_that_pages_can_draw(name: str) -> None:
    mark = FORCES[name].mark

    assert isinstance(mark, Mark)
    text = PICTURE.read_text("utf8")
    assert all(f"  {mark.page}{place}: () =>" in text for place in ("", "_slide", "_zero", "_turn"))


def declared(kind: str, some: Sequence[Strut]) -> list[Strut]:
    """Return the struts of a kind, of which there is one at least."""
    found = [one for one in some if one.kind == kind]
    assert found, f"declare a {kind} in tests/wide.py"
    return found


@pytest.mark.parametrize("kind", [name for name, law in PULLS.items() if law.energy])
def test_the_force_is_the_slope_of_the_energy_at_joints_and_between_points(kind: str) -> None:
    for strut in declared(kind, elastic(WIDE)):
        law, graph = PULLS[kind], Graph()
        x = graph.symbol("x")
        slopes = [gradient(energy, [x])[0] for energy in (stored(strut, x), stored_between(strut, x * x))]
        forces = [law.force(strut, x, graph.zero), pull(strut, x * x, graph.zero) * x]
        for place in PLACES:
            force, *found = at([*forces, *slopes], place)
            assert found == pytest.approx([force] * 3, rel=1e-12), strut.name


@pytest.mark.parametrize("kind", [name for name, law in PULLS.items() if not law.energy])
def test_what_stores_nothing_takes_power_and_is_without_force_at_rest(kind: str) -> None:
    for strut in declared(kind, resisting(WIDE)):
        law, graph = PULLS[kind], Graph()
        x = graph.symbol("x")

        assert law.force(strut, x, graph.zero).is_zero
        for place in PLACES:
            assert at([law.force(strut, x, x) * x], place)[0] >= 0, strut.name
