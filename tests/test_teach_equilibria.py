"""Places of rest that lessons list: there no force works on anything that the bodies can do."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path

import pytest
from lessons import lesson_of, step_of
from test_teach_walkthrough import SPRUNG, lesson, scene

from symdyn.algebra.form import Form, Number
from symdyn.algebra.numeric import Floats
from symdyn.emit.print.formula_text import text_of
from symdyn.graph import Graph, evaluate
from symdyn.scene import Quantity, read, read_text
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
    step = step_of(document, "equilibria")
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


WOUND = """
name = "wound"
gravity = [0, "-g", 0]
[parameters]
g = 9.81
[bodies]
rod = { particles = [{ mass = 1, at = [1, 0, 0] }] }
[joints]
pivot = { type = "revolute", parent = "ground", child = "rod", axis = [0, 0, 1], coordinate = "phi" }
[springs.coil]
joint = "pivot"
stiffness = 0.5
"""


def equilibria(text: str) -> tuple[list[Table[Words]], str]:
    """Return the tables of equilibria of a scene, and what is said about them."""
    found = walkthrough(read_text(text, "scene"))
    step = step_of(found, "equilibria")
    said = " ".join(str(part) for block in step.blocks if isinstance(block, Words) for part in block.parts)
    return [block for block in step.blocks if isinstance(block, Table)], said


def test_equilibria_of_the_double_arm_are_its_four_vertical_positions() -> None:
    table, search = step_of(lesson("two_link"), "equilibria").blocks
    assert "Newton's method looked from 200 starts" in str(search.parts[0])
    stable = [row for row in table.rows if "stable" in row[2].parts]
    assert len(table.rows) == 4
    assert [row[0].parts + row[1].parts for row in stable] == [(Number.ZERO, Number.ZERO)]


def test_equilibria_with_springs_are_where_no_force_is_left() -> None:
    document = lesson("sprung")
    table = step_of(document, "equilibria").blocks[0]
    assert isinstance(table, Table)
    graph = document.graph
    force = document.names["k_G:1"].node + document.names["k_E:1"].node
    values = {graph.symbol(p.name): float(p.value.value) for p in document.scene.parameters}
    for (place,), *_ in ((row[0].parts, *row[1:]) for row in table.rows):
        angle = float(str(place).replace("−", "-"))
        (left,) = evaluate([force], Floats(), {**values, graph.symbol("phi"): angle})
        assert abs(left) < 0.02  # four digits of the angle
    assert len(table.rows) >= 1


@pytest.mark.parametrize("acting", ['force = "0.5*sin(3*t)"', 'motion = "0.3*sin(2*t)"', "motion = 0.3"])
def test_what_is_driven_in_time_has_no_equilibria(acting: str) -> None:
    found = walkthrough(read_text(SPRUNG.replace('drive = "M"', acting), "scene"))
    assert "after.rests" not in [section.key for section in found.sections]


@pytest.mark.long
def test_a_force_that_vanishes_at_rest_at_all_times_leaves_the_equilibria() -> None:
    tables, _ = equilibria(SPRUNG.replace('drive = "M"', 'force = "-2*phi_dot*t**2"'))
    assert tables == equilibria(SPRUNG)[0]
    assert tables


def test_all_equilibria_of_a_wound_spring_are_listed() -> None:
    (table,), said = equilibria(WOUND)
    found = [float(str(row[0].parts[0]).replace("−", "-")) for row in table.rows]
    # by hand: 0.5 phi + 9.81 cos(phi) = 0 has its roots in |phi| <= 19.62, and they are alternately stable
    fine = [-20 + 40 * (k + 0.5) / 40_001 for k in range(40_001)]
    signs = [0.5 * x + 9.81 * cos(x) > 0 for x in fine]
    expected = [a for a, before, after in zip(fine, signs, signs[1:], strict=False) if before != after]
    assert len(expected) > 10
    assert found == pytest.approx(expected, abs=6e-3)
    kinds = [str(row[1].parts[0]) for row in table.rows]
    assert kinds == ["stable", "unstable"] * (len(kinds) // 2) + ["stable"]
    assert "outside there may be others" in said


def test_a_constant_force_turns_the_stable_position_round() -> None:
    plain = WOUND.split("[springs", maxsplit=1)[0]
    up = '[loads.up]\nbody = "rod"\nat = [1, 0, 0]\nforce = [0, 20, 0]\n'
    for text, kinds in ((plain, {-1: "stable", 1: "unstable"}), (plain + up, {-1: "unstable", 1: "stable"})):
        (table,), said = equilibria(text)
        places = [text_of(row[0].parts[0]) for row in table.rows]
        assert sorted(places) == ["-pi/2", "pi/2"]
        for place, row in zip(places, table.rows, strict=True):
            assert row[1].parts == (kinds[-1 if place.startswith("-") else 1],)
        assert "a whole turn was searched" in said


def test_a_position_where_a_spring_has_no_length_is_no_equilibrium() -> None:
    cord = '[springs.cord]\nfrom = { body = "ground", at = [1, 0, 0] }\nto = { body = "rod", at = [1, 0, 0] }\n'
    (table,), _ = equilibria(WOUND.split("[springs", maxsplit=1)[0] + cord + "stiffness = 40\nfree = 0.5\n")
    places = [float(str(row[0].parts[0]).replace("−", "-")) for row in table.rows]
    assert len(places) == 3  # between the first two the force jumps
    for q in places:  # 9.81 cos q + k (d - 0.5) dd/dq with d = 2 |sin(q/2)|
        way = 1 if q > 0 else -1
        assert abs(9.81 * cos(q) + 40 * (2 * way * sin(q / 2) - 0.5) * way * cos(q / 2)) < 0.03


@pytest.mark.long(0)
def test_without_gravity_every_position_is_an_equilibrium() -> None:
    zero = Quantity.number(0)
    still = walkthrough(replace(scene("two_link"), gravity=(zero, zero, zero)))
    step = step_of(still, "equilibria")
    (said,) = step.blocks
    assert isinstance(said, Words)
    assert "Every position" in str(said.parts[0])
