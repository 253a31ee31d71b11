"""Loops in closed form: dependent coordinates, and where a governor rests and stands while it turns."""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import pytest

from symdyn.scene import read
from symdyn.table import Table
from symdyn.teach.document import Document, Formula, Picture, Step, Words
from tests.lessons import lesson_of

sympy = pytest.importorskip("sympy")

EXAMPLES = Path(__file__).parent.parent / "examples"
GOVERNOR = {"l": 0.15, "m": 0.8, "M": 1.5, "J": 0.05, "k": 400, "s0": 0.29}


def lesson(name: str) -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"))


def step_of(name: str, key: str) -> Step:
    return next(step for section in lesson(name).sections for step in section.steps if step.key == key)


def solved(name: str) -> list[tuple[Any, Any]]:
    blocks = step_of(name, "ties.solved").blocks
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


def test_a_governor_hangs_at_rest() -> None:
    (table,) = (block for block in step_of("governor", "equilibria.one").blocks if isinstance(block, Table))
    first = ["".join(str(part) for part in cell.parts) for cell in table.rows[0]]
    assert first[1:] == ["0 rad", "−0.3 m", "stable"]


def test_the_curve_of_a_governor_is_that_of_its_numbers() -> None:
    step = step_of("governor", "steady.curve")
    forms = [
        part.to_sympy()
        for block in step.blocks
        if isinstance(block, Words)
        for part in block.parts
        if not isinstance(part, str)
    ]
    value = next(x for x in forms if "phi_dot" in map(str, x.free_symbols) and "k" in map(str, x.free_symbols))
    least = next(x for x in forms if {"k", "s0"} <= set(map(str, x.free_symbols)) and x != value)
    steady = next(step for section in lesson("governor").sections for step in section.steps if step.key == "steady")
    told = next(block for block in steady.blocks if isinstance(block, Table)).rows[0][1].parts[0]
    assert acos(number(value, **GOVERNOR, phi_dot=12)) == pytest.approx(float(str(told).split()[0]), abs=1e-4)
    at = {**GOVERNOR, "phi_dot": sqrt(number(least, **GOVERNOR))}
    assert number(value, **at) == pytest.approx(1)
    assert number(value, **GOVERNOR, phi_dot=1e6) == pytest.approx(cos(pi / 2), abs=1e-6)
    assert any(isinstance(block, Picture) for block in step.blocks)
