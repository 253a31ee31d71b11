"""`symdyn linearize` at the command line: what it prints, writes, and says of what cannot be."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.algebra import Symbol
from symdyn.cli import main
from symdyn.linear import report

EXAMPLES = Path(__file__).parent.parent / "examples"


def run(*words: str) -> int:
    first, *others = words
    return main(["linearize", str(EXAMPLES / f"{first}.toml"), *others])


def test_json_has_all_digits_names_units_and_formulas(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("pendulum", "--json") == 0
    found = json.loads(capsys.readouterr().out)["result"]
    exact = symdyn.linearize(symdyn.read(EXAMPLES / "pendulum.toml"))
    assert found["A"] == exact.A.tolist()
    assert found["states"] == [{"name": "q1", "unit": "rad"}, {"name": "q1_dot", "unit": "rad/s"}]
    assert found["formulas"]["A"][1] == ["-g/l", "-b/(m*l**2)"]
    assert found["formulas"]["eigenvalues"] == ["ω² = g/l, 2 ζ ω = b/(m*l**2)"]
    assert found["stability"] == "asymptotically stable"


@pytest.mark.parametrize("ending", ["npz", "mat", "csv"])
def test_files_hold_the_matrices_and_their_names(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"x.{ending}"
    assert run("cart_pole", "-o", str(path)) == 0
    A = symdyn.linearize(symdyn.read(EXAMPLES / "cart_pole.toml")).A
    if ending == "npz":
        with np.load(path) as file:
            assert np.array_equal(file["A"], A)
            assert file["states"].tolist() == ["x", "theta", "x_dot", "theta_dot"]
            assert file["state_units"].tolist() == ["m", "rad", "m/s", "rad/s"]
    elif ending == "mat":
        from scipy.io import loadmat

        file = loadmat(path)
        assert np.array_equal(file["A"], A)
        assert [str(name[0]) for name in file["inputs"].ravel()] == ["F"]
    else:
        lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
        assert lines[0] == ["t", "matrix", "row", "unit", "x", "theta", "x_dot", "theta_dot", "F"]
        assert lines[4][:4] == ["0.0", "rate", "theta_dot", "rad/s^2"]
        assert [float(x) for x in lines[4][4:8]] == A[3].tolist()


@pytest.mark.runs("pdflatex")
def test_latex_compiles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pages = []
    for words in (("cart_pole",), ("slider_crank", "--start", "rest"), ("rolling_disc", "--anywhere")):
        assert run(*words, "--format", "latex") == 0
        pages.append(capsys.readouterr().out)
    text = "\n".join([r"\documentclass{article}\usepackage{amsmath}\begin{document}", *pages, r"\end{document}"])
    (tmp_path / "x.tex").write_text(text, encoding="utf-8")
    made = subprocess.run(
        [str(shutil.which("pdflatex")), "-interaction=nonstopmode", "-halt-on-error", "x.tex"],
        cwd=tmp_path, capture_output=True, check=False,
    )  # fmt: skip
    assert made.returncode == 0, made.stdout[-2000:]


def test_along_a_file_there_is_a_system_a_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.csv"
    path.write_text("t,q1,q1_dot,tau1\n0,0.1,0,0\n1,0.2,0.5,1\n", encoding="utf-8")
    assert run("pendulum", "--along", str(path), "--json") == 0
    first, second = json.loads(capsys.readouterr().out)["result"]
    assert first["A"][1][0] == pytest.approx(-9.81 / 0.5 * np.cos(0.1))
    assert second["point"] == {"t": 1.0, "q": {"q1": 0.2}, "u": {"q1_dot": 0.5}, "tau": {"tau1": 1.0}}


BAD = {
    "no equilibrium": (
        ("cart_pole", "--start", "theta=1"),
        "no equilibrium at this point: .*; the nearest equilibrium is at",
    ),
    "no name": (("cart_pole", "--start", "thet=1"), "did you mean theta"),
    "unbound": (("two_link",), "--bind m1=1"),
    "no file": (("cart_pole", "--along", "none.csv"), "there is no such file"),
    "no run": (("cart_pole", "--along", "none.txt"), "runs are read from .csv or .npz"),
    "no ending": (("cart_pole", "-o", "x.txt"), "written to .npz or .mat or .csv"),
    "no folder": (("cart_pole", "-o", "/none/x.npz"), "there is no folder"),
    "no output": (("cart_pole", "--outputs", "foo"), "foo, which is not known"),
    "no reaction": (("cart_pole", "--outputs", "reaction_nope_fx"), "did you mean reaction_hinge_fx"),
    "no loops": (("cart_pole", "--independent", "x"), "all its coordinates are independent"),
    "no rest": (("scara", "--start", "rest"), "no position of rest was found from 200 seeded starts"),
    "no value": (("cart_pole", "--forces", "F=1/x"), "has no value"),
    "rates at rest": (("cart_pole", "--start", "rest", "--start-rates", "x=1"), "--start rest has no velocities"),
    "turning quaternion": (
        ("rolling_disc", "--start-rates", "flight_wz=3"),
        "no steady motion at this point: ",
    ),
}


@pytest.mark.parametrize(("words", "told"), BAD.values(), ids=BAD)
def test_what_cannot_be_is_told(words: tuple[str, ...], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(*words) == 1
    said = capsys.readouterr().err
    assert said.startswith("symdyn: ")
    assert re.search(told, said), said


def test_a_singular_place_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("governor", "--start", "alpha=0,beta=0,s=-0.3", "--start-rates", "phi=0") == 1
    assert "branches of motion meet" in capsys.readouterr().err


def test_corners_of_friction_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (EXAMPLES / "pendulum.toml").read_text(encoding="utf-8")
    path = tmp_path / "rough.toml"
    path.write_text(text.replace('force = "-b*q1_dot"', 'force = "-2*b*abs(q1_dot)*q1_dot"'), encoding="utf-8")
    assert main(["linearize", str(path)]) == 0
    assert "one-sided: a sign or an absolute value of q1_dot turns over here" in capsys.readouterr().out


def test_a_definition_of_more_than_400_characters_is_told_by_what_has_it() -> None:
    assert report._short(Symbol("q" * 400)) == "q" * 400
    assert report._short(Symbol("q" * 401)).startswith("... (401 characters; --format latex, --json and ")


def test_formulas_are_printed_where_eigenvalues_are_long_and_else_it_is_said_what_has_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("gallery/furuta") == 0
    told = capsys.readouterr()
    assert "B[theta2_dot, T] = l2*m2*L1/(" in told.out
    assert "formulas" not in told.err
    assert run("spatial_slider_crank") == 0
    assert "--symbolic all gives them names" in capsys.readouterr().err
    assert run("rolling_disc", "--start", "z=r,e0=1,e1=0", "--start-rates", "flight_wx=0,flight_wy=6") == 0
    assert "symdyn.linearize(...).formulas in Python" in capsys.readouterr().err


def test_bode_beside_lqr_is_of_the_loop_and_weights_take_commas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("scipy")
    assert (
        run("cart_pole", "--lqr", "Q=x:10,theta:100", "R=F:0.1", "--show", "bode", "--hertz", "[1, 2]", "--json") == 0
    )
    told = capsys.readouterr()
    found, said = json.loads(told.out)["result"], told.err
    regulator = symdyn.linearize(EXAMPLES / "cart_pole.toml").lqr({"x": 10, "theta": 100}, {"F": 0.1})
    assert found["lqr"]["K"] == regulator.K.tolist()
    assert found["bode"] == regulator.loop.bode(hertz=[1, 2]).as_json()
    assert "K (s I - A)^-1 B" in said


@pytest.mark.parametrize("words", [("--lqr", "N="), ("--lqr", "Q = "), ("--kalman", "W=")])
def test_a_weight_of_nothing_is_refused(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert run("pendulum", *words) == 1
    assert "weighs nothing; write " in capsys.readouterr().err


def test_an_open_contact_is_one_that_a_mode_leaves_out(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("gallery/hopper", "--anywhere") == 1
    assert "say what each does there, --mode floor=open; or closed" in capsys.readouterr().err
    assert run("gallery/hopper", "--mode", "floor=open", "--anywhere") == 0
