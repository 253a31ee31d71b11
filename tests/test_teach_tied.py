"""Loops in closed form: dependent coordinates, and where a governor rests and stands while it turns."""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import pytest
from lessons import lesson_of, step_of

from symdyn.emit.print import text_of
from symdyn.scene import read
from symdyn.table import Table
from symdyn.teach.document import Document, Formula, Picture, Step, Words

sympy = pytest.importorskip("sympy")

EXAMPLES = Path(__file__).parent.parent / "examples"
GOVERNOR = {"l": 0.15, "m": 0.8, "M": 1.5, "J": 0.05, "k": 400, "s0": 0.29}


def lesson(name: str) -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"))


def solved(name: str) -> list[tuple[Any, Any]]:
    blocks = step_of(lesson(name), "ties.solved").blocks
    return [(x.form.to_sympy(), x.right.to_sympy()) for x in blocks if isinstance(x, Formula) and x.right is not None]


def number(node: Any, **values: float) -> float:
    return float(node.subs({x: values[str(x)] for x in node.free_symbols}))


def test_the_rod_of_a_slider_crank_follows_by_its_sine_and_the_piston_by_a_root() -> None:
    crank, rod, phi = 0.05, 0.2, 0.7
    at = {"r": crank, "l": rod, "phi": phi}
    (sine, its), (cosine, other), (x, way) = solved("slider_crank")
    assert (str(sine), str(cosine), str(x)) == ("sin(phi + psi)", "cos(phi + psi)", "x")
    assert number(its, **at) == pytest.approx(-crank * sin(phi) / rod)
    assert number(other, **at) == pytest.approx(sqrt(1 - (crank * sin(phi) / rod) ** 2))
    assert number(way, **at) == pytest.approx(crank * cos(phi) + sqrt(rod**2 - (crank * sin(phi)) ** 2))


def test_the_arms_of_a_governor_are_alike_and_the_sleeve_follows() -> None:
    (s, way), (beta, angle) = solved("governor")
    assert (str(s), str(beta), str(angle)) == ("s", "beta", "alpha")
    assert number(way, l=0.15, alpha=0.6) == pytest.approx(-0.3 * cos(0.6))


def test_the_rocker_of_a_four_bar_follows_by_the_squares_of_both_conditions() -> None:
    blocks = [x for x in step_of(lesson("four_bar"), "ties.solved").blocks if isinstance(x, Formula)]
    named = {x.left: x.form.to_sympy() for x in blocks if x.left and x.right is None}
    phi, closed = 0.9, {str(x): sympy.sympify(y) for x, y in solved("four_bar")}
    lengths = {p.name: float(p.value.known_at({})) for p in read(EXAMPLES / "four_bar.toml").parameters if p.value}
    at = {**lengths, "phi": phi}
    numbers = {name: number(form, **at) for name, form in named.items()}
    at["chi"] = number(closed["chi"], **at, **numbers)
    cosine, sine = (number(closed[f"{wave}(phi + psi)"], **at) for wave in ("cos", "sin"))
    a, b, c, d = (lengths[x] for x in "abcd")
    assert cosine**2 + sine**2 == pytest.approx(1)
    assert a * cos(phi) + b * cosine == pytest.approx(d + c * cos(at["chi"]))
    assert a * sin(phi) + b * sine == pytest.approx(c * sin(at["chi"]))
    assert sine > 0  # as it is assembled, not crossed


def test_a_governor_hangs_at_rest() -> None:
    (table,) = (block for block in step_of(lesson("governor"), "equilibria.one").blocks if isinstance(block, Table))
    first = ["".join(str(part) for part in cell.parts) for cell in table.rows[0]]
    assert first[1:] == ["0 rad", "−0.3 m", "stable"]


def test_the_curve_of_a_governor_is_that_of_its_numbers() -> None:
    step = step_of(lesson("governor"), "steady.curve")
    forms = [
        part.to_sympy()
        for block in step.blocks
        if isinstance(block, Words)
        for part in block.parts
        if not isinstance(part, str)
    ]
    value = next(x for x in forms if "phi_dot" in map(str, x.free_symbols) and "k" in map(str, x.free_symbols))
    least = next(x for x in forms if {"k", "s0"} <= set(map(str, x.free_symbols)) and x != value)
    steady = step_of(lesson("governor"), "steady")
    told = next(block for block in steady.blocks if isinstance(block, Table)).rows[0][1].parts[0]
    assert acos(number(value, **GOVERNOR, phi_dot=12)) == pytest.approx(float(str(told).split()[0]), abs=1e-4)
    at = {**GOVERNOR, "phi_dot": sqrt(number(least, **GOVERNOR))}
    assert number(value, **at) == pytest.approx(1)
    assert number(value, **GOVERNOR, phi_dot=1e6) == pytest.approx(cos(pi / 2), abs=1e-6)
    assert any(isinstance(block, Picture) for block in step.blocks)


def said(step: Step) -> str:
    """Return claim, sentences and reason of a step without formulas."""
    parts = [*step.claim.parts, *(x for b in step.blocks if isinstance(b, Words) for x in b.parts), *step.reason.parts]
    return " ".join(str(x) for x in parts)


def test_a_governor_ends_in_one_equation_of_its_arm() -> None:
    length, m, M, k, s0, w = (*(GOVERNOR[x] for x in ("l", "m", "M", "k", "s0")), 12.0)
    *_, form = [
        block.form.to_sympy()
        for block in step_of(lesson("governor"), "eliminated").blocks
        if isinstance(block, Formula)
    ]
    names = set(map(str, form.free_symbols))
    assert names.isdisjoint({"beta", "s", "beta_dot", "s_dot"})
    a, u, f = 0.6, 0.7, 1.1
    found = number(form, **GOVERNOR, alpha=a, alpha_dot=u, alpha_ddot=f, phi_dot=w)
    turning = 2 * (4 * m * length**2 + 0.1 * length**2 + 8e-4)  # both arms with balls
    height = -(9.81 * M - 2 * k * length * cos(a) + k * s0) * -2 * length * sin(a) + 2 * 9.81 * (
        0.1 + 2 * m
    ) * length * sin(a)
    sleeve = 4 * M * length**2 * (sin(a) ** 2 * f + sin(a) * cos(a) * u**2)
    assert found == pytest.approx(turning * (f - w**2 * sin(a) * cos(a)) + sleeve + height)


def test_a_free_spindle_keeps_its_momentum() -> None:
    assert "Without the drive" in said(step_of(lesson("governor"), "conserved:1"))


def test_held_rate_and_kept_momentum_swing_each_with_their_frequency() -> None:
    step = step_of(lesson("governor"), "steady.curve")
    assert "critical speed is 7.399 rad/s" in said(step)
    (table,) = (block for block in step.blocks if isinstance(block, Table))
    rows = {str(row[0].parts[0]): [str(cell.parts[0]) for cell in row[1:]] for row in table.rows}
    assert rows["7.399 rad/s"] == ["0 rad", "0 rad", "−0.3 m", "0 rad/s", "0 rad/s"]
    assert rows["12 rad/s"][-2:] == ["10.73 rad/s", "15.84 rad/s"]
    assert "no rate is held" in said(step_of(lesson("governor"), "steady"))  # whose eigenvalues are 15.84 i


def test_the_multiplier_of_a_rod_is_its_force() -> None:
    (table,) = (block for block in step_of(lesson("governor"), "multipliers").blocks if isinstance(block, Table))
    assert "compression" in str(table.rows[0][1].parts[0])
    assert "twice its length" in said(step_of(lesson("governor"), "tie:link1"))


def test_what_a_closed_form_decides_is_not_said_to_be_missed() -> None:
    assert "does not find" not in said(step_of(lesson("governor"), "equilibria.one"))
    assert "λ" not in said(step_of(lesson("governor"), "equilibria"))  # there are no eigenvalues in its table


def test_masses_stand_first_in_products_and_in_tables() -> None:
    *_, ball = (block for block in step_of(lesson("governor"), "kinetic:2b").blocks if isinstance(block, Formula))
    assert [one.name for one in lesson("governor").scene.parameters] == ["m", "M", "J", "l", "k", "s0"]
    assert text_of(ball.form).startswith("2*m*l**2")
