"""Places of rest that lessons list: there no force works on anything that the bodies can do."""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import pytest
from lessons import lesson_of

from symdyn.algebra.form import Form
from symdyn.algebra.numeric import Floats
from symdyn.graph import Graph, evaluate
from symdyn.scene import read, read_text
from symdyn.table import Table
from symdyn.teach import Document, walkthrough
from symdyn.teach.document import Words

FOUND = Path(__file__).parent / "data/found"

POLE = """
name = "pole"
gravity = [0, 0, -10]
[bodies.top]
mass = 2
com = [0, 0, 1]
inertia = [1, 1, 0.5]
inertia_about = "com"
[joints.point]
type = "spherical"
parent = "ground"
child = "top"
orientation = "zyz"
drive = false
"""


def places(document: Document) -> list[list[float]]:
    """Return the coordinates of every place that the lesson calls an equilibrium."""
    step = next(step for section in document.sections for step in section.steps if step.key == "equilibria")
    table = next(block for block in step.blocks if isinstance(block, Table))
    return [[number(cell.parts[0]) for cell in row[:-2]] for row in table.rows]


def number(part: str | Form) -> float:
    if isinstance(part, str):
        return float(part.replace("−", "-"))
    return float(evaluate([part.express(Graph())], Floats(), {})[0])


@pytest.mark.long(0)
@pytest.mark.mends("5.2")
def test_a_top_rests_where_its_weight_has_no_moment_about_the_point() -> None:
    """At q2 = ±π/2 the angles of zyx are singular: k_G vanishes, and the weight pulls the top over."""
    document = lesson_of(read(FOUND / "heavy_top_zyx.toml"))

    found = places(document)  # of q2, q3: the centre of mass is at Rz Ry Rx (0, 1, 0)
    across = [((sin(a) * sin(b)) ** 2 + cos(b) ** 2) ** 0.5 for a, b in found]
    assert len(found) == 4
    assert max(across) < 1e-9
    words = [part for _, b in document.blocks() if isinstance(b, Words) for part in b.parts if isinstance(part, str)]
    assert any("virtual work of all bodies" in part for part in words)


@pytest.mark.long(0)
def test_rest_at_a_place_where_angles_are_singular_is_kept() -> None:
    found = places(walkthrough(read_text(POLE, "pole")))  # of q2 alone, from the vertical

    assert sorted(abs(q2) for (q2,) in found) == pytest.approx([0, pi])
