"""A lesson ends with the equation that a student looks for: solved, motions put in, multipliers eliminated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from lessons import lesson_of, step_of

from symdyn.algebra import Form
from symdyn.scene import read, read_text
from symdyn.teach.document import Document, Formula, Words

sympy = pytest.importorskip("sympy")

SCENES = Path(__file__).parent / "data" / "lessons"


def lesson(name: str) -> Document:
    return lesson_of(read(SCENES / f"{name}.toml"))


def solved(name: str, key: str = "explicit") -> list[tuple[Any, Any]]:
    """Return both sides of the equations of a step, Δ written out."""
    found = []
    given: dict[Any, Any] = {}
    for block in step_of(lesson(name), key).blocks:
        if isinstance(block, Formula) and block.left:
            given[sympy.Symbol(block.left, real=True)] = block.form.to_sympy()
        elif isinstance(block, Formula) and block.right is not None:
            found.append((block.form.to_sympy().subs(given), block.right.to_sympy().subs(given)))
    return found


def same(left: Any, right: str) -> bool:
    known = {str(x): x for x in left.free_symbols}
    names = "m M l g R A Omega t alpha theta theta_dot theta_ddot phi_dot x_ddot x_dot"
    known = {name: known.get(name, sympy.Symbol(name, real=True)) for name in names.split()}
    return bool(sympy.simplify(left - sympy.sympify(right, locals=known)) == 0)


@pytest.mark.parametrize(
    ("name", "number", "by_hand"),
    [
        ("plain_pend", 0, "-g/l*sin(theta)"),
        ("hoop", 0, "(Omega**2*cos(theta) - g/R)*sin(theta)"),
        ("kapitza", 0, "-(g - A*Omega**2*cos(Omega*t))*sin(theta)/l"),
        ("wedge", 0, "-m*g*sin(alpha)*cos(alpha)/(M + m*sin(alpha)**2)"),
        ("wedge", 1, "(M + m)*g*sin(alpha)/(M + m*sin(alpha)**2)"),
        ("spherical", 0, "-2*theta_dot*phi_dot*cos(theta)/sin(theta)"),
        ("spherical", 1, "(phi_dot**2*cos(theta) - g/l)*sin(theta)"),
    ],
)
def test_accelerations_are_those_found_by_hand(name: str, number: int, by_hand: str) -> None:
    assert same(solved(name)[number][1], by_hand)


def test_the_drive_of_a_prescribed_motion_has_the_motion_put_in() -> None:
    ((_, torque),) = solved("hoop", "explicit.drives")
    assert same(torque, "2*m*R**2*Omega*sin(theta)*cos(theta)*theta_dot")


@pytest.mark.parametrize("name", ["wheelpend", "wheelroll"])
def test_multipliers_and_dependent_rates_are_eliminated(name: str) -> None:
    first, second = solved(name, "eliminated")
    assert same(first[0], "(3*M/2 + m)*x_ddot + m*l*cos(theta)*theta_ddot - m*l*sin(theta)*theta_dot**2")
    assert same(second[0], "m*l*cos(theta)*x_ddot + m*l**2*theta_ddot + m*g*l*sin(theta)")
    assert first[1] == second[1] == 0


def changed(*changes: tuple[str, str], name: str = "spherical") -> Document:
    text = (SCENES / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return lesson_of(read_text(text, "changed.toml"))


LEVEL = ('at = [0,0,"-l"]', 'at = ["l",0,0]')
SLIDE = (LEVEL, ('pin]\ntype = "revolute"', 'pin]\ntype = "prismatic"'), ("[0,-1,0]", "[1,0,0]"), ('"pi/5"', "0"))
LED = ('drive = false\nstart = "pi/5"', 'motion = "3*t"')


@pytest.mark.parametrize(
    ("name", "changes", "told"),
    [
        ("spherical", (), ["For phi_ddot this holds only where sin(theta) ≠ 0."]),
        ("spherical", (*SLIDE, ("0.8", "0.2")), ["For phi_ddot this holds only where l + theta ≠ 0."]),
        ("spherical", (*SLIDE, ("0.8", "5")), ["For phi_ddot this holds only where l + theta ≠ 0."]),
        ("spherical", (LED,), ["For phi_ddot this holds only where sin(3*t) ≠ 0."]),
        ("wedge", (), []),
        ("hoop", (), []),
    ],
)
def test_accelerations_say_where_they_divide_by_zero(
    name: str, changes: tuple[tuple[str, str], ...], told: list[str]
) -> None:
    words = [x.parts for x in step_of(changed(*changes, name=name), "explicit").blocks if isinstance(x, Words)]

    assert ["".join(x if isinstance(x, str) else str(x.to_sympy()) for x in parts) for parts in words] == told


def test_a_tilt_from_the_horizontal_has_a_critical_speed_as_one_from_below() -> None:
    for changes in ((), (LEVEL,)):
        blocks = step_of(changed(("drive = false\nstart_rates", "start_rates"), *changes), "steady").blocks
        forms = [x for block in blocks if isinstance(block, Words) for x in block.parts if isinstance(x, Form)]
        assert any(same(form.to_sympy(), "g/l") for form in forms)
        assert any(
            "speed is 3.502 rad/s" in str(x) for block in blocks if isinstance(block, Words) for x in block.parts
        )


def said(name: str, key: str) -> tuple[str, list[Form]]:
    step = step_of(lesson(name), key)
    words = [step.claim, *(block for block in step.blocks if isinstance(block, Words))]
    parts = [part for one in words for part in one.parts]
    return " ".join(x for x in parts if isinstance(x, str)), [x for x in parts if isinstance(x, Form)]


def test_the_momentum_of_the_whole_motion_is_conserved() -> None:
    _, forms = said("wheelpend", "conserved:1")
    assert same(forms[-1].to_sympy(), "(3*M/2 + m)*x_dot + m*l*cos(theta)*theta_dot")


def test_a_condition_with_constant_coefficients_is_integrated() -> None:
    text, forms = said("wheelpend", "ties.slip")
    assert "holonomic" in text
    assert {str(x) for x in forms[-1].to_sympy().free_symbols} == {"x", "R", "phi"}


def test_the_threshold_of_a_steady_motion_is_told_in_closed_form() -> None:
    _, forms = said("hoop", "steady")
    assert any(same(form.to_sympy(), "g/R") for form in forms)
    assert any(same(form.to_sympy(), "Omega**2 - g**2/(R**2*Omega**2)") for form in forms)


def test_a_prescribed_coordinate_is_no_degree_of_freedom() -> None:
    text, _ = said("hoop", "scene")
    assert "coordinates: 2, prescribed: 1; degrees of freedom: 1" in text
