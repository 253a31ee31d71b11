"""Steady precession, critical spin, nutation and what is conserved: lessons against results by hand."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lessons import lesson_of, step_of

from symdyn.scene import read
from symdyn.table import Table
from symdyn.teach.document import Blank, Choice, Document, Formula, Step, Words
from symdyn.teach.practice.exercises import with_exercises

sympy = pytest.importorskip("sympy")

ROOT = Path(__file__).parent
NAMES = "m l g A C psi_dot phi_dot alpha_dot theta beta p1 p3 spin:3 Ixx1 Iyy1 my1 point_wy nutation:omega"


def lesson(name: str) -> Document:
    folder = (
        ROOT / "data" / "lessons" if (ROOT / "data" / "lessons" / f"{name}.toml").exists() else ROOT.parent / "examples"
    )
    return lesson_of(read(folder / f"{name}.toml"))


@cache
def shown(name: str, key: str) -> list[Any]:
    """Return what stands on the right of the formulas of a step, and forms in its sentences."""
    found = []
    for block in step_of(lesson(name), key).blocks:
        if isinstance(block, Formula):
            found.append((block.form if block.right is None or not block.right.terms else block.right).to_sympy())
        elif isinstance(block, Words):
            found += [part.to_sympy() for part in block.parts if not isinstance(part, str)]
    return found


def same(left: Any, right: str) -> bool:
    """Tell whether a form is worth what was found by hand, at numbers; w is the spin, theta the angle of a top."""
    other = {"spin:3": "w", "point_wy": "w", "p:1": "p1", "p:3": "p3", "euler:theta": "theta"}
    named = {x: sympy.Symbol(other.get(str(x), str(x))) for x in left.free_symbols}
    difference = left.subs(named) - sympy.sympify(right, locals={"beta": sympy.Symbol("beta"), "C": sympy.Symbol("C")})
    values = {x: 0.3 + 0.37 * k for k, x in enumerate(sorted(difference.free_symbols, key=str))}
    return abs(complex(difference.subs(values))) < 1e-9


@pytest.mark.parametrize(
    ("name", "key", "by_hand"),
    [
        ("top", "precession", "A*cos(theta)*psi_dot**2 - C*w*psi_dot + m*g*l"),
        ("top", "precession", "(C*w - sqrt(C**2*w**2 - 4*A*m*g*l*cos(theta)))/(2*A*cos(theta))"),
        ("top", "precession", "(C*w + sqrt(C**2*w**2 - 4*A*m*g*l*cos(theta)))/(2*A*cos(theta))"),
        ("top", "precession", "4*A*m*g*l*cos(theta)/C**2"),
        ("top", "precession", "m*g*l/(C*w)"),
        ("top", "upright:0", "4*A*m*g*l/C**2"),
        ("top", "upright:0", "(C*w)**2/(4*A**2) - m*g*l/A"),
        ("top", "upright:1", "(C*w)**2/(4*A**2) + m*g*l/A"),
        ("top", "nutation", "(C*w/A - 2*psi_dot*cos(theta))**2 + psi_dot**2*sin(theta)**2"),
        ("top", "nutation", "(C*w/A)**2"),
        ("spherical", "precession", "g/(l*cos(theta))"),
        ("spherical", "upright:0", "g/l"),
        ("spherical", "nutation", "phi_dot**2*(1 + 3*cos(theta)**2)"),
        ("gimbal", "precession", "C*w/(A*cos(beta))"),
        ("gimbal", "nutation", "(C*w*sin(beta))**2/((A + Ji)*(Jo + Ji + A*sin(beta)**2))"),
        ("heavy_top", "precession", "4*Ixx1*my1*g*cos(theta)/Iyy1**2"),
        ("heavy_top", "upright:0", "4*Ixx1*my1*g/Iyy1**2"),
    ],
)
def test_what_a_top_does_is_what_books_say(name: str, key: str, by_hand: str) -> None:
    assert any(same(form, by_hand) for form in shown(name, key))


def test_the_potential_that_momenta_leave_is_that_of_the_reduced_motion() -> None:
    (form, *_) = shown("top", "effective")
    assert same(form, "(p1 - p3*cos(theta))**2/(2*A*sin(theta)**2) + p3**2/(2*C) + m*g*l*cos(theta)")


def words(step: Step) -> str:
    return "".join(str(part) for part in step.claim.parts if isinstance(part, str))


def test_a_heavy_top_keeps_two_momenta_and_its_energy() -> None:
    keys = [step.key for section in lesson("heavy_top").sections for step in section.steps]
    assert [key for key in keys if key.startswith(("kept", "energy"))] == ["kept:point", "kept:2", "energy"]
    assert "along z" in words(step_of(lesson("heavy_top"), "kept:point"))


def test_the_critical_spin_is_told_in_numbers() -> None:
    text = " ".join(
        str(x) for block in step_of(lesson("heavy_top"), "upright:0").blocks for x in getattr(block, "parts", ())
    )
    number = (4 * 15.234375 * 15 * 9.81) ** 0.5 / 0.46875
    assert f"{number:.4g} rad/s" in text


def test_a_body_without_moments_turns_over_about_its_middle_axis() -> None:
    (table,) = (block for block in step_of(lesson("free_body"), "spins:flight").blocks if isinstance(block, Table))
    rows = [(row[0].parts[0], row[1].parts[0], row[2].parts[0]) for row in table.rows]
    found = [(axis, form.to_sympy(), kind) for axis, form, kind in rows if not isinstance(form, str)]
    third = sympy.Rational(1, 3)
    assert found == [("x", -third, "stable"), ("y", third, "unstable"), ("z", -1, "stable")]


def test_nothing_is_told_of_precession_where_nothing_is_cyclic() -> None:
    keys = {step.key for section in lesson("hoop").sections for step in section.steps}
    assert not keys.intersection({"effective", "precession", "nutation"})


def asked(name: str) -> dict[str, Choice | Blank]:
    document = with_exercises(lesson(name), ask=("physics",))
    return {block.key: block for _, block in document.blocks() if isinstance(block, (Choice, Blank))}


def right(question: Choice | Blank) -> list[str]:
    assert isinstance(question, Choice)
    return [
        "".join(str(x) for x in option.text.parts if isinstance(x, str)) for option in question.options if option.right
    ]


def test_questions_about_a_top_have_the_answers_of_its_lesson() -> None:
    found = asked("heavy_top")
    critical = found["physics:critical"]
    assert isinstance(critical, Blank)
    assert same(critical.answer.to_sympy(), "4*Ixx1*my1*g/Iyy1**2")
    assert right(found["physics:stable"]) == ["centre of mass of top below the joint"]
    assert [text.split(",")[0] for text in right(found["physics:conserved"])] == [
        "the angular momentum along z of the ground",
        "the angular momentum along an axis of the body",
        "the energy ",
    ]
    assert len(right(found["physics:limit"])) == 2
    assert right(found["physics:unit"]) == ["kg m²"]


def test_a_free_body_is_asked_which_spin_lasts() -> None:
    found = asked("free_body")
    assert right(found["physics:spin"]) == ["x", "z"]
    assert len(right(found["physics:conserved"])) == 4


def table_of(name: str, key: str) -> list[list[str]]:
    (table,) = (block for block in step_of(lesson(name), key).blocks if isinstance(block, Table))
    return [[str(cell.parts[0]) for cell in row] for row in table.rows]


def test_both_precessions_are_told_in_numbers_and_one_where_the_equation_is_linear() -> None:
    A, C, weight, spin = 15.234375, 0.46875, 15 * 9.81, 150
    rows = [row[1:] for row in table_of("heavy_top", "precession")]
    root = ((C * spin) ** 2 - 4 * A * weight * 0.5) ** 0.5
    both = [f"{(C * spin + sign * root) / A:.4g} rad/s" for sign in (-1, 1)]  # at 60 degrees
    assert rows[:3] == [["–", "–"], both, [f"{weight / (C * spin):.4g} rad/s", "–"]]
    assert rows[3][1].startswith("−")  # hanging down, the fast one turns the other way
    assert any(same(form, "my1*g/(Iyy1*w)") for form in shown("heavy_top", "precession"))


def test_a_top_says_where_it_starts_and_which_spin_is_meant() -> None:
    told = " ".join(str(x) for b in step_of(lesson("heavy_top"), "euler").blocks for x in getattr(b, "parts", ()))
    assert "The scene starts with" in told
    assert "≈ 1.571" in told
    assert "= 150" in told
    unit = "".join(str(x) for b in step_of(lesson("heavy_top"), "quaternion").blocks for x in getattr(b, "parts", ()))
    assert "nothing is turned" in unit


def test_a_mass_that_no_equation_holds_is_no_letter() -> None:
    document = lesson("heavy_top")
    assert [one.name for one in document.scene.parameters] == ["my1", "Ixx1", "Iyy1", "g"]
