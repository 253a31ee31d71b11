"""What a user chooses about closed loops, through every door: --independent, --baumgarte, `closing=`."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from symdyn import certify, lambdify, load
from symdyn.cli import main
from symdyn.dynamics import LoopChoices
from symdyn.scene import read

EXAMPLES = Path(__file__).parent.parent / "examples"
FOUR_BAR = str(EXAMPLES / "four_bar.toml")
CHOICE = LoopChoices(("chi",), Fraction(5), Fraction(5, 2))
FUNCTIONS = ("forward_dynamics", "constraint_jacobian", "constraint_bias", "constraint_residual")


def test_baumgarte_pulls_the_loops_together_and_the_header_says_so(tmp_path: Path) -> None:
    words = ["--independent", "chi", "--baumgarte", "5,5/2", "--functions", "forward_dynamics", "-o", str(tmp_path)]
    assert main(["generate", FOUR_BAR, *words]) == 0
    text = (tmp_path / "four_bar.py").read_text(encoding="utf-8")

    assert "--independent chi --baumgarte 5,5/2" in text
    assert "independent: chi; Baumgarte: alpha 5, beta 2.5 1/s" in text


@pytest.mark.runs
@pytest.mark.parametrize("door", ["lambdify", "load"])
def test_the_choice_reaches_the_functions(door: str) -> None:
    scene = read(FOUR_BAR)
    if door == "lambdify":
        forward, G, bias, residual = lambdify(scene, FUNCTIONS, closing=CHOICE)
    else:
        loaded = load(scene, FUNCTIONS, closing=CHOICE)
        forward, G, bias, residual = (loaded[name] for name in FUNCTIONS)
    q, u, tau = np.array([0.8, 0.3, 2.1]), np.array([0.4, -0.2, 0.7]), np.array([1.0, 0.0, 0.0])
    found = G(q) @ forward(q, u, tau) + bias(q, u)

    np.testing.assert_allclose(found, -10 * G(q) @ u - 6.25 * residual(q), atol=1e-10)
    assert np.abs(found).max() > 0.1


@pytest.mark.usefixtures("numpy_alone")
def test_the_certificate_names_the_choice() -> None:
    found = certify(read(FOUR_BAR), ("forward_dynamics",), closing=CHOICE)

    assert found.passed
    assert "independent: chi; Baumgarte: alpha 5, beta 2.5 1/s" in found.notes


@pytest.mark.long(0)
def test_info_names_the_choice(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", FOUR_BAR, "--independent", "psi", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["result"]

    assert facts["chosen"] == "independent: psi"
    assert facts["mobility"]["independent"] == ["psi_dot"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--independent", "nope"], "there is no velocity 'nope'"),
        (["--independent", "phi,psi"], "phi, psi given, but it has 1 degree of freedom"),
        (["--independent", ","], "--independent: no name is given; write --independent phi,psi"),
        (["--baumgarte", "5"], "--baumgarte 5: these are no two numbers; write ALPHA,BETA"),
        (["--baumgarte", "5,1/0"], "--baumgarte 5,1/0: these are no two numbers"),
        (["--baumgarte=-1,2"], "a negative rate drives the loops apart"),
    ],
)
@pytest.mark.parametrize("verb", ["generate", "verify", "info"])
def test_wrong_choices_say_what_would_work(
    verb: str, words: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    place = ["-o", str(tmp_path)] if verb == "generate" else []
    assert main([verb, FOUR_BAR, *words, *place]) == 1
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_tree_has_nothing_to_choose(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(EXAMPLES / "two_link.toml"), "--independent", "q1"]) == 1
    assert "two_link: --independent: it has no loops and no rows" in capsys.readouterr().err


def test_info_names_all_coordinates_of_a_free_joint(capsys: pytest.CaptureFixture[str]) -> None:
    scene = str(EXAMPLES / "free_body.toml")
    assert main(["info", scene]) == 0
    text = capsys.readouterr().out
    assert main(["info", scene, "--json"]) == 0
    (joint,) = json.loads(capsys.readouterr().out)["result"]["joints"]

    assert "x y z in m, e0 e1 e2 e3 in 1, velocities flight_vx flight_vy flight_vz in m/s" in text
    assert [one["name"] for one in joint["coordinates"]] == ["x", "y", "z", "e0", "e1", "e2", "e3"]
    assert [one["unit"] for one in joint["velocities"]] == ["m/s"] * 3 + ["rad/s"] * 3
    assert joint["drives"] == [None] * 6
