"""The LaTeX of a parameter is checked where it is declared, so that a document compiles or its scene is refused."""

from __future__ import annotations

import re

import pytest

from symdyn.emit.print.printed_names import latex_symbols
from symdyn.errors import SceneError
from symdyn.scene import Scene
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
