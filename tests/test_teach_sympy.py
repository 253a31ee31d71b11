"""Every formula of Lagrange's lessons against a derivation by SymPy alone, which reads nothing of the generator."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from lesson_by_sympy import Tree, at
from lessons import lesson_of

from symdyn.algebra.numeric import Floats
from symdyn.graph import evaluate
from symdyn.scene import read
from symdyn.teach import Document
from symdyn.teach.document import Braced, Formula

ROOT = Path(__file__).parent.parent
SCENES = {name: ROOT / f"examples/{name}.toml" for name in ("two_link", "cart_pole", "spatial_3r")}
SCENES |= {
    name: ROOT / f"tests/data/found/{name}.toml" for name in ("heavy_top_zyx", "hoop_driven", "elastic_pendulum")
}
OWN = {"positions", "velocities", "energies", "lagrangian", "equations", "coefficients", "numbers"}
"""Sections whose every formula is derived a second time here."""

DEFINED = {"k_D torque": "k_D:1,1"}
"""Products with a rate, by what multiplies it: their form is held against the graph elsewhere."""


@cache
def derived(name: str) -> tuple[Document, Tree]:
    document = lesson_of(read(SCENES[name]))
    return document, Tree(document.scene)


def point(document: Document, tree: Tree) -> dict[str, float]:
    names = [p.name for p in document.scene.parameters] + [str(x) for x in (*tree.q, *tree.u, *tree.a)]
    return {name: 0.31 + sum(ord(x) * (k + 3) for k, x in enumerate(name)) % 89 / 61 for name in names}


@pytest.mark.wide("two_link")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", SCENES)
def test_every_quantity_of_a_lesson_is_what_sympy_derives(name: str) -> None:
    document, tree = derived(name)
    named = {key: one.node for key, one in document.names.items() if one.node is not None and key in tree.values}
    here = point(document, tree)
    mine = at([tree.values[key] for key in named], here)
    symbols = {document.graph.symbol(key): value for key, value in here.items()}
    theirs = evaluate(list(named.values()), Floats(), symbols)
    assert dict(zip(named, theirs, strict=True)) == pytest.approx(dict(zip(named, mine, strict=True)), abs=1e-9)

    left = {
        key
        for section in document.sections
        if section.key in OWN
        for step in section.steps
        for block in step.blocks
        if isinstance(block, (Formula, Braced)) and (key := block.value if isinstance(block, Braced) else block.left)
    }
    assert left - set(named) <= set(DEFINED)
    assert len(left) > 20


@pytest.mark.long
@pytest.mark.heavy("spatial_3r", "heavy_top_zyx")
@pytest.mark.parametrize("name", SCENES)
def test_the_second_opinion_is_itself_a_motion_by_lagrange(name: str) -> None:
    document, tree = derived(name)
    here, n = point(document, tree), range(len(tree.q))
    for i in (str(k + 1) for k in n):
        terms = [tree.values[f"k_G:{i}"], tree.values[f"k_E:{i}"]]
        terms += [tree.values[f"k_z:{i},{j + 1}"] * tree.a[j] for j in n]
        terms += [tree.values[f"k_D:{i},{j + 1}"] * tree.u[j] ** 2 for j in n]
        terms += [
            tree.values[f"k_C:{i},{j + 1},{k + 1}"] * tree.u[j] * tree.u[k] for j in n for k in range(j + 1, len(n))
        ]
        whole, *parts = at([tree.values[f"tau:{i}"], *terms], here)
        assert sum(parts) == pytest.approx(whole, abs=1e-9)
