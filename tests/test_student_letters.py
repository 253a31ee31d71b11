"""Every letter that a scene offers, typed into every kind of line: an answer or a sentence, never a fault of ours.

A Lagrangian with multipliers is right where each stands times a condition, however that is written: the rows that
symdyn prints are one way, the points of the loop in the axes of the ground another.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from symdyn.cli import main
from symdyn.emit.print.formula_text import text_of
from symdyn.emit.print.printable import Printable
from symdyn.errors import SymdynError
from symdyn.scene import Scene, read, read_text
from symdyn.scene.values import acceleration_name
from symdyn.teach import check_derivation
from symdyn.verdict import Verdict

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))
LINES = (
    "L = {x}", "P = m_2 g + {x}", "K = {x}", "k_z11 = {x}", "k_G1 = {x}", "k_D11 = {x}", "{drive} = {x}",
    "{acceleration} = {x}", "{x} = 0", "{x} + {velocity} = 0", "x_1 = {x}", "v_1^2 = {x}", "K_1 = {x}",
    "dL/d{q} = {x}", "L = K - P + {x}*{q}",
)  # fmt: skip
BESIDE = (r"\lambda_1", "lambda2", "t", "R_1", "F_{slip}")
"""Multipliers, time and reactions: letters that no scene declares."""

FOUR_BAR = ROOT / "examples" / "four_bar.toml"
ALONG, ACROSS = "(a*cos(phi) + b*cos(phi + psi) - c*cos(chi) - d)", "(a*sin(phi) + b*sin(phi + psi) - c*sin(chi))"
WEIGHTS = "1/2*m1*g*a*sin(phi) + m2*g*(a*sin(phi) + b/2*sin(phi + psi)) + 1/2*m3*g*c*sin(chi)"

WHEEL = """
gravity = "none"
parameters = { m = 2, J = 3, r = 0.5 }
bodies.belt.mass = "m"
bodies.wheel = { inertia = ["J", "J", "J"], inertia_about = "com" }
joints.track = { type = "prismatic", parent = "ground", child = "belt", axis = [1, 0, 0], coordinate = "x" }
joints.axle = { type = "revolute", parent = "ground", child = "wheel", axis = [0, 1, 0], coordinate = "phi" }
constraints.slip.formula = "x_dot - r*phi_dot"
"""


def letters(scene: Scene) -> Iterator[str]:
    yield from BESIDE
    yield from (p.name for p in scene.parameters)
    yield from (given.name for given in scene.inputs)
    yield from (*scene.coordinates, *scene.velocities, *map(acceleration_name, scene.velocities))
    yield from filter(None, scene.drives)


def written(line: str, letter: str, scene: Scene) -> str:
    u = scene.velocities[0]
    drive = next(filter(None, scene.drives), "tau1")
    return line.format(x=letter, q=scene.coordinates[0], velocity=u, acceleration=acceleration_name(u), drive=drive)


@pytest.mark.mends("30.attacks.1")
@pytest.mark.wide("four_bar")
@pytest.mark.long
@pytest.mark.parametrize("line", [r"L = \lambda_1", r"P = m_2 g + \lambda_1", r"K = \lambda_1", r"\ddot\phi = t"])
@pytest.mark.parametrize("name", ["four_bar", "slider_crank"])
def test_a_multiplier_or_the_time_in_a_line_is_judged(name: str, line: str, tmp_path: Path) -> None:
    text = tmp_path / "line.txt"
    text.write_text(line, encoding="utf-8")

    assert main(["check-derivation", str(text), str(ROOT / "examples" / f"{name}.toml")]) == 1


@pytest.mark.wide("pendulum")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["pendulum", "cart_with_wheel"])
def test_letters_in_lines_are_judged_or_refused_in_words(name: str) -> None:
    scene = read(ROOT / "examples" / f"{name}.toml")

    for k, letter in enumerate(letters(scene)):
        for line in LINES if letter in BESIDE else LINES[k % 3 :: 5]:
            _answered(written(line, letter, scene), scene)


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_letters_of_every_example_in_lines_are_judged_or_refused_in_words(path: Path) -> None:
    scene = read(path)
    if len(scene.velocities) > 4:
        pytest.skip("a longer one has no closed form that a student writes")

    for k, letter in enumerate(letters(scene)):
        for line in LINES if letter in BESIDE[:3] else LINES[k % 5 :: 5]:
            _answered(written(line, letter, scene), scene)


def _answered(text: str, scene: Scene) -> None:
    with suppress(SymdynError):
        assert check_derivation(text, scene), text


@pytest.mark.long
@pytest.mark.parametrize(
    "added",
    [
        f"- lambda1*{ALONG} - lambda2*{ACROSS}",
        f"+ lambda1*({ALONG} + 2*{ACROSS}) - 3*lambda2*{ALONG}",
        "printed",
    ],
)
def test_multipliers_of_conditions_are_right_however_they_are_written(added: str) -> None:
    scene = read(FOUR_BAR)
    if added == "printed":
        rows = zip(("lambda1", "lambda2"), Printable.of(scene).constraints.positions(), strict=True)
        added = "".join(f" - {name}*({text_of(form)})" for name, form in rows)

    (answer,) = check_derivation(f"P = {WEIGHTS} {added}", scene)

    assert answer.right
    assert answer.multiplied == ("lambda1", "lambda2")


@pytest.mark.long
@pytest.mark.parametrize(
    "added",
    [
        f"- lambda1*{ALONG}",  # one is missing
        f"- lambda1*{ALONG} - lambda2*{ALONG}",  # the same one twice
        f"- lambda1*({ALONG} + d) - lambda2*{ACROSS}",  # vanishes nowhere
        f"- lambda1**2*{ALONG} - lambda2*{ACROSS}",
        f"- lambda1*{ALONG}*phi_dot - lambda2*{ACROSS}",
    ],
)
def test_other_multipliers_are_not(added: str) -> None:
    (answer,) = check_derivation(f"P = {WEIGHTS} {added}", read(FOUR_BAR))

    assert answer.verdict == Verdict.DIFFERENT
    assert answer.mistake is not None
    assert answer.mistake.rule == "multiplier"


def test_a_row_of_velocities_that_holds_a_position_ties_a_lagrangian() -> None:
    scene = read_text(WHEEL, "wheel.toml")
    energy = "L = 1/2*m*x_dot**2 + 1/2*J*phi_dot**2"

    assert check_derivation(f"{energy} + lambda1*(x - r*phi)", scene)[0].right
    assert not check_derivation(f"{energy} + lambda1*(x + r*phi)", scene)[0].right
    assert not check_derivation(f"{energy} + lambda1*(x_dot - r*phi_dot)", scene)[0].right  # no principle has that


@pytest.mark.parametrize("pi", [pytest.param("pi", marks=pytest.mark.mends("30.lessons.1.7")), r"\pi", "π"])
def test_pi_is_read_however_it_is_written(pi: str, tmp_path: Path) -> None:
    text = tmp_path / "line.txt"
    text.write_text(f"k_z22 = {pi}/{pi}*m2*h2**2*2*{pi}/(2{pi})", encoding="utf-8")

    assert main(["check-derivation", str(text), str(ROOT / "examples" / "two_link.toml")]) == 0
