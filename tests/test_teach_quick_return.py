"""A block slides on a link that turns: slide and angle in closed form, and the accelerations, beside those by hand."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import pytest
from lessons import lesson_of

from symdyn.scene.toml import read_text
from symdyn.teach.document import Formula

sympy = pytest.importorskip("sympy")

SCENE = """
name = "quick_return"
parameters = { r = "0.08 m", d = "0.2 m", J1 = "0.02 kg m^2", J2 = "0.05 kg m^2", m = "0.5 kg", b = "0.8 N m s/rad" }
bodies.crank = { mass = 1, inertia = ["J1/2", "J1/2", "J1"], inertia_about = "com" }
bodies.link = { mass = 1, inertia = ["J2/2", "J2/2", "J2"], inertia_about = "com" }
bodies.block = { mass = "m" }
[joints.motor]
parent = "ground"
child = "crank"
type = "revolute"
axis = [0, 0, 1]
origin = [0, "d", 0]
coordinate = "phi"
drive = "M"
start = 0.5
[joints.pin]
parent = "ground"
child = "link"
type = "revolute"
axis = PIN
coordinate = "theta"
drive = false
damping = "b"
start = ANGLE
[joints.slot]
parent = "link"
child = "block"
type = "prismatic"
axis = SLOT
origin = AT
coordinate = "s"
drive = false
start = SLIDE
[[loop]]
name = "crankpin"
parent = "crank"
child = "block"
type = "revolute"
axis = [0, 0, 1]
origin = ["r", 0, 0]
"""
NUMBERS = {"r": 0.08, "d": 0.2, "J1": 0.02, "J2": 0.05, "m": 0.5, "b": 0.8, "phi": 0.7, "phi_dot": 1.5, "M": 0.3}


def formulas(step: str, **filled: str) -> dict[str, Any]:
    """Return what a step of the lesson says of each coordinate or acceleration."""
    text = SCENE
    for word, value in filled.items():
        text = text.replace(word, value)
    steps = {one.key: one for section in lesson_of(read_text(text, "w.toml")).sections for one in section.steps}
    shown = (x for x in steps[step].blocks if isinstance(x, Formula) and x.right is not None)
    return {str(x.form.to_sympy()): x.right.to_sympy() for x in shown if x.right is not None}


def number(node: Any, values: dict[str, float]) -> float:
    return float(node.subs({x: values[str(x)] for x in node.free_symbols}))


@pytest.mark.parametrize(
    ("way", "slot", "at", "angle", "slide"),
    [
        (1, [1, 0, 0], [0, 0, 0], 1.3, 0.25),
        pytest.param(1, [1, 0, 0], [0, 0, 0], -1.8, -0.25, marks=pytest.mark.slow),
        pytest.param(1, [0, 1, 0], [0, 0, 0], -0.3, 0.25, marks=pytest.mark.slow),
        (-1, [1, 0, 0], [0.03, 0.04, 0], -1.1, 0.2),
    ],
)
def test_slide_and_angle_close_the_loop_on_the_side_where_it_is_assembled(
    way: int, slot: list[float], at: list[float], angle: float, slide: float
) -> None:
    filled = {"PIN": [0, 0, way], "SLOT": slot, "AT": at, "ANGLE": angle, "SLIDE": slide}
    found, values = formulas("ties.solved", **{word: str(value) for word, value in filled.items()}), dict(NUMBERS)
    for x in ("s", "theta"):
        values[x] = number(found[x], values)
    x, y = (at[k] + values["s"] * slot[k] for k in (0, 1))
    turn, phi = way * values["theta"], NUMBERS["phi"]
    assert x * cos(turn) - y * sin(turn) == pytest.approx(0.08 * cos(phi))
    assert x * sin(turn) + y * cos(turn) == pytest.approx(0.2 + 0.08 * sin(phi))
    assert values["s"] * slide > 0


def test_solved_accelerations_are_those_of_one_equation_in_the_angle_of_the_crank() -> None:
    plain = {"PIN": "[0, 0, 1]", "SLOT": "[1, 0, 0]", "AT": "[0, 0, 0]", "ANGLE": "1.3", "SLIDE": "0.25"}
    solved = formulas("eliminated:solved", **plain)
    phi, rate, M = sympy.symbols("phi phi_dot M")
    r, d, J1, J2, m, b = sympy.symbols("r d J1 J2 m b")
    s = sympy.sqrt(r**2 + d**2 + 2 * r * d * sympy.sin(phi))
    theta = sympy.atan2(d + r * sympy.sin(phi), r * sympy.cos(phi))
    inertia = J1 + (J2 + m * s**2) * theta.diff(phi) ** 2 + m * s.diff(phi) ** 2
    own = (M - inertia.diff(phi) * rate**2 / 2 - b * theta.diff(phi) ** 2 * rate) / inertia
    values = {**NUMBERS, "s": number(s, NUMBERS), "theta": number(theta, NUMBERS)}
    values["phi_ddot"] = number(own, NUMBERS)
    assert number(solved["phi_ddot"], values) == pytest.approx(values["phi_ddot"])
    for name, x in (("theta", theta), ("s", s)):
        by_hand = x.diff(phi) * values["phi_ddot"] + x.diff(phi, 2) * rate**2
        assert "ddot" not in str(solved[f"{name}_ddot"])
        assert number(solved[f"{name}_ddot"], values) == pytest.approx(number(by_hand, values))
