"""Forced vibration: amplitude, phase, resonance and absorber in closed form, against results by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from lessons import keys_of, lesson_of, step_of

from symdyn.scene import read
from symdyn.teach.document import Document, Formula, Picture, Words

sympy = pytest.importorskip("sympy")

SCENES = Path(__file__).parent / "data" / "lessons"


def lesson(name: str) -> Document:
    return lesson_of(read(SCENES / f"{name}.toml"))


def shown(name: str) -> list[Any]:
    """Return right-hand sides and forms of sentences of the response."""
    found = []
    for block in step_of(lesson(name), "forced.response").blocks:
        if isinstance(block, Formula) and block.right is not None:
            found.append(block.right.to_sympy())
        elif isinstance(block, Words):
            found += [part.to_sympy() for part in block.parts if not isinstance(part, str)]
    return found


def same(left: Any, right: str) -> bool:
    names = {x: sympy.Symbol(str(x)) for x in left.free_symbols}
    difference = left.subs(names) - sympy.sympify(right)
    values = {x: 0.3 + 0.37 * k for k, x in enumerate(sorted(difference.free_symbols, key=str))}
    return abs(complex(difference.subs(values))) < 1e-9


@pytest.mark.parametrize(
    ("name", "by_hand"),
    [
        ("forced", "F0/sqrt((k - m*Omega**2)**2 + (c*Omega)**2)"),
        ("forced", "c*Omega/(k - m*Omega**2)"),
        ("forced", "k/m - c**2/(2*m**2)"),
        ("absorber", "F0*(k2 - m2*Omega**2)/((k1 - (m1 + m2)*Omega**2)*(k2 - m2*Omega**2) - m2**2*Omega**4)"),
        ("absorber", "F0*m2*Omega**2/((k1 - (m1 + m2)*Omega**2)*(k2 - m2*Omega**2) - m2**2*Omega**4)"),
    ],
)
def test_the_response_keeps_the_letters_of_the_force(name: str, by_hand: str) -> None:
    assert any(same(form, by_hand) for form in shown(name))


def test_the_amplitude_is_drawn_over_the_frequency() -> None:
    assert any(isinstance(block, Picture) for block in step_of(lesson("absorber"), "forced.response").blocks)


@pytest.mark.parametrize("name", ["kapitza", "hoop"])
def test_a_drive_that_forces_no_vibration_about_rest_has_no_response(name: str) -> None:
    assert "forced" not in keys_of(lesson(name))
