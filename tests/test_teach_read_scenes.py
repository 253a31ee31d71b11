"""Five scenes read as a teacher would: what was false, not said or said in an ugly way in their lessons.

Equations: Taylor, Classical Mechanics, 7.41 (bead on a parabola), 3.2 (rocket), 11.4 (double pendulum).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from symdyn.emit.print import text_of
from symdyn.scene import Scene, read, read_text
from symdyn.teach import walkthrough
from symdyn.teach.derivations.limits import smaller_by, vanishing
from symdyn.teach.derivations.solved import solved_steps
from symdyn.teach.document import Formula
from symdyn.teach.lesson import Lesson
from symdyn.teach.render.markdown import markdown
from symdyn.teach.shown_state import choose_state

SCENES = Path(__file__).parent / "data" / "read_scenes"


@cache
def page(name: str, language: str = "en") -> str:
    return written(scene(name), language)


def written(of: Scene, language: str = "en") -> str:
    (text,) = (x for key, x in markdown(walkthrough(of, language, "full")).items() if key.endswith(".md"))
    return str(text)


@cache
def scene(name: str) -> Scene:
    return read(SCENES / f"{name}.toml")


def test_energy_of_a_rocket_changes_with_its_mass() -> None:
    text = page("rocket")
    assert "masses are held fixed in all derivatives with respect to time below" in text
    z, z_dot, g, c = 0.3, 1.0, 9.81, 2.0
    power = -c * (g * z + z_dot**2 / 2)
    assert f"in the chosen state at the rate of {power:.4g} W".replace("-", "−") in text
    assert r"W_m = -c (g z + \tfrac{1}{2} \dot z^2)" in text


def test_bodies_of_one_mass_do_not_vanish_one_by_one() -> None:
    lesson = Lesson(scene("twin"), "en")
    (found,) = (one for one in vanishing(lesson) if [str(m.value) for m in one.without] == ["m"])
    assert not smaller_by(lesson, found)  # with m → 0 both bobs weigh nothing


def test_a_mass_beside_a_mass_matrix_is_told_in_the_table_of_symbols() -> None:
    given = (
        (SCENES / "twin.toml")
        .read_text(encoding="utf-8")
        .replace("\nm = ", "\nM = ")
        .replace('mass = "m"', 'mass = "M"')
    )
    heavy = read_text(given, "twin.toml")
    text = written(heavy)
    assert r"| $\mathbf{M}$ | mass matrix, in bold type: $M$ is a letter of the mechanism |  |  |" in text
    assert "| $M$ | mass of each bob | kg | 1 |" in text
    assert r"\mathbf{M}_s = \begin{bmatrix} 5 M l^2" in text
    assert "matica hmotnosti, tlačená tučne: $M$ je veličina mechanizmu" in written(heavy, "sk")
    assert "in bold type" not in page("twin") + page("shaken")  # neither has both


def test_a_determinant_is_positive() -> None:
    lesson = Lesson(scene("twin"), "en")
    (step,) = solved_steps(lesson, choose_state(lesson.scene, lesson.state, lesson.graph))
    delta = step.blocks[0]
    assert isinstance(delta, Formula)
    assert text_of(delta.form) == "2 - cos(theta2)**2"


def test_what_is_shaken_rests_nowhere_without_its_spring() -> None:
    assert "it rests everywhere" not in page("shaken")
    assert "| base: $M$; cart: $m_1$ |" in page("shaken")


def test_a_bead_on_a_turning_parabola_has_its_equation_with_the_rate_put_in() -> None:
    text = page("parabola")
    above = r"\bigl(\Omega^2 - 2 (2 a \dot r^2 + g) a\bigr) r"
    assert rf"\ddot r = \frac{{{above}}}{{4 a^2 r^2 + 1}}" in text
    assert r"T = 2 m \Omega \dot r r" in text
    assert "with prescribed motions kept: oscillates, λ ≈ ± 3.774 i 1/s" in text  # √(2 a g - Ω²)
    assert "so that no rate is held" not in text


def test_a_bead_on_a_turning_parabola_has_its_threshold_and_its_condition_integrated() -> None:
    text = page("parabola")
    assert "changes its sign at $\\Omega^2$ = $2 a g$, for the values of the lesson at $\\Omega$ = 6.264 rad/s" in text
    assert "$c_1$ = d/dt ($z - a r^2$)" in text


def test_a_bead_on_a_wire_given_by_formulas_rests_everywhere_at_the_threshold() -> None:
    given = (SCENES / "parabola.toml").read_text(encoding="utf-8")
    wire = """[joints.out]
type = "custom"
parent = "wire"
child = "bead"
steps = [["Tx", "r"], ["Tz", "a*r**2"]]
coordinate = "r"
units = ["m"]
drive = false
"""
    first, _, _ = given.partition("[joints.out]")
    begin, _, end = first.partition("[bodies.slider]")
    text = written(read_text(begin + "[bodies.bead]" + end.partition("[bodies.bead]")[2] + wire, "wire.toml"))
    assert "Or $\\Omega^2$ = $2 a g$, the critical speed: then it rests at every $r$." in text


def test_a_ratio_that_acts_twice_is_a_square() -> None:
    text = page("belt")
    assert r"Q_1^{A} = k i - \frac{r_1^2 b \dot{\phi}_1}{r_2^2}" in text
    assert r"\frac{U - R i - k \dot{\phi}_1}{L_p}" in text


def test_formulas_are_the_same_in_slovak() -> None:
    shown = [[part.replace("{,}", ".") for part in page("parabola", code).split("$$")[1::2]] for code in ("en", "sk")]
    assert shown[0] == shown[1]


def test_a_rod_in_a_slot_swings_about_where_it_stays_at_one_rate() -> None:
    """By hand: V'' = 4 m² s² φ̇²/I at every s, where m φ̇² = k, with I = J + m l²/12 + m s²."""
    text = page("slot")
    assert r"\omega_n^2 = \frac{48 m \dot{\phi}^2 s^2}{(l^2 + 12 s^2) m + 12 J}" in text
    assert "Or $m \\dot{\\phi}^2 - k$ = 0, at every $s$." in text
    assert "The condition of steady motion is put in." in text
    assert "| $s$ | the spring is relaxed | along x |" in text
    assert "| $J$ → 0 |" in text.replace("\u00a0", " ")
    assert "disc is a point mass" in text


def test_a_letter_that_cancels_is_named() -> None:
    """Of a pendulum it is the mass, but not where a drive turns it."""
    driven = (SCENES.parent.parent.parent / "examples/pendulum.toml").read_text(encoding="utf-8")
    free = driven.replace('force = "-b*q1_dot"', "drive = false #")
    assert "The motion does not depend on $m$." in written(read_text(free, "free.toml"))
    assert "The motion does not depend on" not in written(read_text(driven, "driven.toml"))
