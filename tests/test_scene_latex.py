"""The LaTeX of a parameter is checked where it is declared, so that a document compiles or its scene is refused."""

from __future__ import annotations

import re

import pytest

import symdyn
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import SceneError
from symdyn.scene import Scene, body, fixed, prismatic, revolute, scene, universal, write_text
from symdyn.scene.toml import read_text
from symdyn.scene.values.grammar import check_latex


def pendulum(latex: str) -> Scene:
    """Return a scene whose only parameter is printed as `latex`, a TOML literal."""
    return read_text(
        f"""
        name = "pendulum"
        [parameters]
        k = {{ latex = {latex} }}
        [bodies.bob]
        particles = [{{ mass = "k", at = [0, -1, 0] }}]
        [joints.hinge]
        type = "revolute"
        parent = "ground"
        child = "bob"
        axis = [0, 0, 1]
        """,
        "pendulum.toml",
    )


@pytest.mark.parametrize(
    "latex",
    [r"\kappa", r"m_{1,\mathrm{a}}", r"\hat{m}_0", "k'", r"k_{\{a,b\}}", r"p_{\%}", r"{}^A x", r"\lambda^{(1)}"],
)
def test_what_stands_in_a_formula_is_taken(latex: str) -> None:
    assert pendulum(f"'''{latex}'''").parameters[0].latex == latex


def test_an_empty_text_is_as_good_as_none() -> None:
    assert latex_symbols(pendulum("''"))["k"] == "k"


REFUSED = {
    "'m_{1'": "has braces that do not pair",
    "'m}_{1'": "has braces that do not pair",
    r"'\{m}'": "has braces that do not pair",
    "'$m$'": "holds $",
    "'a & b'": "holds &",
    "'50%'": "holds %",
    "'#1'": "holds #",
    "'m~1'": "holds ~",
    r"'a \\ b'": "holds \\",
    "'m\\'": "holds \\",
    '"a\\nb"': "holds a line break",
    "'κ'": "holds a line break or a character that is not ASCII",
    "' '": "is empty",
}


@pytest.mark.parametrize("latex", REFUSED)
def test_what_would_break_a_document_is_refused_with_place_and_reason(latex: str) -> None:
    with pytest.raises(SceneError, match=r"pendulum.toml:\d+: parameters.k: latex = .* " + re.escape(REFUSED[latex])):
        pendulum(latex)


def test_the_error_says_what_is_allowed() -> None:
    allowed = r"letters, digits, _ ^ ', Greek, accents such as \hat{k}, fonts such as \mathrm{a}, \text{max}"
    assert check_latex("$k$") == f"holds $, which no symbol in a formula needs; a symbol has {allowed}"


def test_coordinates_are_printed_as_their_joint_says() -> None:
    """One symbol, or one for each coordinate, in TOML and in Python, there and back; else by the rule of names."""
    joints = [
        revolute("a", "ground", "x", coordinate="th1", latex=r"\vartheta"),
        prismatic("b", "x", "y", coordinate="al"),
        universal("c", "y", "z", coordinates=["ph", "be_2"], latex=["u", r"\beta_{\mathrm{c}}"]),
        revolute("d", "z", "w", coordinate="ps"),
    ]
    one = scene(
        "s", parameters={"th": 1}, bodies=[body(name, mass=1, inertia=[1, 1, 1]) for name in "xyzw"], joints=joints
    )
    shown = {"th1": r"\vartheta", "al": "a_l", "ph": "u", "be_2": r"\beta_{\mathrm{c}}", "ps": r"\psi", "th": "t_h"}

    assert {name: latex_symbols(one)[name] for name in shown} == shown
    assert latex_symbols(one)["th1_dot"] == r"\dot{\vartheta}"
    assert read_text(write_text(one, "toml").text, "s.toml") == one
    assert r"\ddot{\vartheta}" in symdyn.equations(one).latex()
    for latex, words in {"$x$": "holds", 3: "is not text", ("a", "b"): "has 2 names; a revolute joint has 1"}.items():
        with pytest.raises(SceneError, match=words):
            scene("s", bodies=[body("x", mass=1)], joints=[revolute("a", "ground", "x", latex=latex)])  # type: ignore[arg-type]
    with pytest.raises(SceneError, match='latex = "a" has no meaning for a fixed joint'):
        scene("s", bodies=[body("x", mass=1)], joints=[fixed("a", "ground", "x", latex="a")])
