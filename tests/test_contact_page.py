"""Contacts in print: against the outputs that are proved, and what has no such page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy

import symdyn
from symdyn.emit.print.formulations_page import FormulationPage, formulation_text
from symdyn.errors import DerivationError
from symdyn.scene import Scene, read_text

SCENES = Path(__file__).parent / "data" / "impacts" / "scenes"
ROD = (SCENES / "falling_rod_0.36.toml").read_text()

STATE = {"x": 0.1, "y": 0.4, "theta": 0.7}
RATES = {"x_dot": 0.3, "y_dot": -1.2, "theta_dot": 0.5}


def told(scene: Scene, more: dict[str, float]) -> dict[str, float]:
    """Return what the page says in numbers, by the names of its rows."""
    known = {**STATE, **RATES, **more}
    for row in (row for group in FormulationPage(scene, "contact").groups for row in group.rows):
        found = sympy.sympify(row.form.to_sympy())
        known[row.name] = float(found.subs({s: known[str(s)] for s in found.free_symbols}))
    return known


@pytest.mark.runs("cc")
@pytest.mark.parametrize("law", ["poisson", "newton"])
def test_the_page_of_contacts_agrees_with_the_outputs(law: str) -> None:
    scene = read_text(
        ROD.replace(
            'friction = "0.36"', f'friction = 0.36\nlaw = "{law}"\nrestitution = "{"1/2" if law == "newton" else 0}"'
        )
    )
    q, u, a = np.array([*STATE.values()]), np.array([*RATES.values()]), np.array([0.2, -0.3, 0.4])
    call = symdyn.load(
        scene, ["gap:foot", "gap_rate:foot", "gap_jacobian:foot", "gap_jdot:foot", "delassus", "impact:foot"]
    )
    forces = np.array([2.0, -0.5])
    given = dict(zip(("x_ddot", "y_ddot", "theta_ddot", "lambda_n", "lambda_t"), [*a, *forces], strict=True))
    page, W = told(scene, given), call.gap_jacobian_foot(q)[:2]
    assert [page["g"], page["g_dot"], page["s"]] == pytest.approx([call.gap_foot(q), *(W @ u)])
    assert [page["g_ddot"], page["s_dot"]] == pytest.approx(W @ a + call.gap_jdot_foot(q, u)[:2])
    assert [page.get(f"Q_c{k}", 0.0) for k in (1, 2, 3)] == pytest.approx(W.T @ forces)
    assert [page["D11"], page["D12"], page["D22"]] == pytest.approx(call.delassus(q)[[0, 0, 1], [0, 1, 1]])
    sticks = abs(page["Lambda_t"]) <= 0.36 * page["Lambda_n"]
    after = {z: page["s"] + call.delassus(q)[1] @ [page[f"Lambda_n{z}"], page[f"Lambda_t{z}"]] for z in "+-"}
    way = "" if sticks else "+" if after["+"] > 0 else "-"
    assert [page[f"Lambda_n{way}"], page[f"Lambda_t{way}"]] == pytest.approx(call.impact_foot(q, u)[3:])


def test_the_page_names_one_thing_alike_in_laws_rows_and_formulas() -> None:
    """Of several contacts with their numbers, and where a scene has g, s and D itself."""
    text = ROD.replace('coordinate = "x"', 'coordinate = "D"').replace('coordinate = "y"', 'coordinate = "g"')
    for scene in (read_text(text), symdyn.read(SCENES / "rocking_block.toml")):
        page = formulation_text(scene, "contact")
        assert "dot}" not in page.replace(r"\dot{", "").replace(r"\ddot{", "")
        assert "_ddot" not in page
        assert "cal}}" not in page
    for part in (
        r"$0 \le g_1 \perp \lambda_{n,1} \ge 0$",
        r"\ddot{g_1} = 0",
        r"\ddot g_1 &=",
        "D_{1,1} D_{2,2} - D_{1,2}^2",
    ):
        assert part in page


def test_letters_that_a_scene_has_are_left_to_it() -> None:
    text = ROD.replace('coordinate = "x"', 'coordinate = "s"').replace('coordinate = "y"', 'coordinate = "g"')
    found = formulation_text(read_text(text), "contact", "text")
    assert "gap = g - 0.5*cos(theta)" in found
    assert "slip = s_dot + 0.5*cos(theta)*theta_dot" in found


def test_what_has_no_page_of_contacts_says_why() -> None:
    with pytest.raises(DerivationError, match="has no contacts that open and close; print Lagrange's equations"):
        formulation_text(symdyn.example("pendulum"), "contact")
    ball = """
[bodies.b]
mass = 1
inertia = [1, 1, 1]
inertia_about = "com"
[joints.f]
type = "free"
parent = "ground"
child = "b"
orientation = "zyx"
[contacts.floor]
body = "b"
friction = 0.2
"""
    with pytest.raises(DerivationError, match=r"contacts\.floor can slip along two directions"):
        formulation_text(read_text(ball), "contact")
