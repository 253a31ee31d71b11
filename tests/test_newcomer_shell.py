"""What one types at the shell who knows another tool, and what comes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import (
    ArgumentError,
    SimulateError,
)

pytestmark = pytest.mark.runs("cc")

CART = symdyn.example("cart_pole")


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["equations", "a.toml", "--latex"], "give --format latex"),
        (["plot", "a.toml"], "simulate, inverse and sweep write one, --plot FILE"),
        (["animate", "a.toml"], "simulate writes one, --animate FILE"),
        (["linearize", "a.toml", "--from", "F"], "inputs are all drives and inputs of the scene"),
        (["linearize", "a.toml", "--to", "theta"], "give --outputs"),
        (["bode", "a.toml"], "did you mean linearize?"),
        (["simulate", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["sweep", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["identify", "a.toml", "--output-error", "m"], "--output-error is no option; give --by output-error"),
        (["linearize", "a.toml", "--transmissibility", "z"], "give --bode FILE"),
        (["generate", "a.toml", "--language", "c"], "did you mean --target?"),
        (["eom", "a.toml"], "did you mean equations?"),
        (["equilibrium", "a.toml"], "did you mean linearize?"),
        (["trim", "a.toml"], "did you mean linearize?"),
        (["linearize", "a.toml", "--trim", "x"], "did you mean --start?"),
    ],
)
def test_the_shell_guesses_what_is_meant_or_nothing(
    words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert meant in capsys.readouterr().err


SPRUNG = """
[bodies.block]
mass = 1
[joints.rail]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "block"
coordinate = "x"
drive = "F"
damping = "c"
[springs.coil]
joint = "rail"
stiffness = 100
[parameters]
c = 1
"""


def test_what_was_silent_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    with pytest.raises(SimulateError, match=r'formulas of the state are forces: forces=\{"F": "-x"\}'):
        symdyn.simulate(CART, feedback={"F": "-x"}, until=1)
    with pytest.raises(ArgumentError, match="did you mean bounds"):
        symdyn.collocation(CART, until=1, limits={"F": 15})  # type: ignore[call-arg]
    upright = symdyn.linearize(CART)
    told = 'V misses theta: measured with variance 1; linearize with outputs=["x"] leaves it out'
    assert upright.kalman({"F": 1}, {"x": 1e-6}).notes == (told,)
    assert told in repr(upright.kalman({"F": 1}, {"x": 1e-6}))
    assert told in repr(upright.lqg(W={"F": 1}, V={"x": 1e-6}))
    assert "misses" not in repr(upright.kalman({"F": 1}, {"x": 1e-6, "theta": 1e-6}))

    assert "no cost: any motion" in repr(symdyn.collocation(CART, until=1, end={"x": 1}, intervals=4))
    assert "no cost" not in repr(symdyn.collocation(CART, until=1, end={"x": 1}, cost="F**2", intervals=4))
    with pytest.raises(SimulateError, match="and no force, whose cost is over time: cost"):
        symdyn.collocation(CART, until=1, end={"x": 1}, final_cost="F**2", intervals=4)

    path = str(tmp_path / "cart.toml")
    Path(path).write_text(symdyn.scene.write_text(CART, "toml").text)
    regulator = upright.lqr({"x": 1, "x_integral": 2}, {"F": 0.1}, N={"x*F": 0.05}, integral="x")
    asked = ["--lqr", "Q=x:1;x_integral:2", "R=F:0.1", "N=x*F:0.05", "integral=x"]
    assert main(["linearize", path, *asked, "--show", "margins", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["lqr"]["K"] == regulator.K.tolist()
    assert main(["linearize", path, *asked, "--show", "margins"]) == 0
    shown = capsys.readouterr().out
    assert f"loop of the regulator, cut open at F, stable: {regulator.margins().words}" in shown
    assert main(["linearize", path, "--lqr", "N=F*x:1"]) == 1
    assert "N: F*x is no state times a drive; write such as x*F" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["simulate", path, "--quantisation", "theta=0.1"])
    assert "in Python a controller has it: symdyn.Feedback(law, quantisation=...)" in capsys.readouterr().err


def test_a_small_grid_is_shown_row_by_row(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "block.toml"
    path.write_text(SPRUNG)
    asked = ["sweep", str(path), "--over", "c=[5,8]", "--start", "x=1", "--until", "1", "--measure", "end(x)"]
    assert main(asked) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows if row.split()[-1:] == ["end"]] == ["5", "8"]
