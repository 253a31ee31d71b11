"""What one types at the shell who knows another tool, and what comes."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from pathlib import Path

import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import (
    ArgumentError,
    SimulateError,
    SymdynError,
)
from symdyn.simulation import panels

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
        (["bode", "a.toml"], "it is symdyn linearize FILE --show bode"),
        (["simulate", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["sweep", "a.toml", "--noise", "x=1"], "in Python a controller has it: symdyn.Feedback(law, noise=...)"),
        (["identify", "a.toml", "--output-error", "m"], "--output-error is no option; give --by output-error"),
        (["identify", "a.toml", "--log", "x.csv"], "files of data stand behind the scene"),
        (["sweep", "a.toml", "--indices"], "give --design saltelli"),
        (["optimize", "a.toml"], "in Python symdyn.collocation(...) finds optimal motions"),
        (["linearize", "a.toml", "--transmissibility", "z"], "give --bode FILE"),
        (["generate", "a.toml", "--language", "c"], "did you mean --target?"),
        (["eom", "a.toml"], "did you mean equations?"),
        (["equilibrium", "a.toml"], "did you mean linearize?"),
        (["trim", "a.toml"], "did you mean linearize?"),
        (["linearize", "a.toml", "--trim", "x"], "did you mean --start?"),
        (["linearize", "a.toml", "--period", "1"], "--period is no option; give --dt"),
        (["linearize", "a.toml", "--noise", "1"], "variances are those of --kalman"),
        (["identify", "a.toml", "--method", "output-error"], "give --by output-error"),
        (["new", "--list"], "--template takes rr, rrr, rrp"),
        (["new", "a", "--template", "3r"], "did you mean rrr?"),
        (["simulate", "BLOCK", "--until", "1", "--limits", "F=1"], "which is not given; give --feedback FILE too"),
        (["simulate", "BLOCK", "--until", "1", "--fps", "1"], "which is not given; give --animate FILE too"),
        (["simulate", "BLOCK", "--until", "1", "--plot-columns", "x"], "give --plot FILE too"),
        (["inverse", "BLOCK", "--until", "1", "--motion", "x_dot=30"], "write x=30*t for 30 a second"),
        (["simulate", "BLOCK", "--until", "1", "--start", "x=3mmm"], "did you mean mm?"),
        (["sweep", "BLOCK", "--over", "c=[5,8]", "--design", "lhs", "--measure", "x"], "did you mean latin?"),
        (["sweep", "BLOCK", "--over", "c=[5,8]", "--design", "monte_carlo", "--measure", "x"], "did you mean random?"),
        (["sweep", "BLOCK", "--over", "c=[5,8]", "--bind", "c=3", "--measure", "x"], "--bind: c is varied; leave it"),
        (["sweep", "BLOCK", "--over", "c=[5,8],x=[1,2]", "--over", "c=[1]", "--measure", "x"], "c is given twice"),
        (["info", "STIFF"], "it is of a spring of its own"),
        (["simulate", "BLOCK", "--until", "1", "--start", "x=1", "x_dot=2"], 'text with commas, "x=1,x_dot=2"'),
        (["simulate", "BLOCK", "--until", "1", "--start", "x=1 x_dot=2"], "commas stand between values by name"),
        (["simulate", "BLOCK", "--until", "1", "--stop", "x=0"], "for x = 0 write x, for x = y x - y"),
        (["equations", "BLOCK", "--format", "tex"], "did you mean latex?"),
        (["walkthrough", "BLOCK", "-o", "no/such/x.html"], "there is no folder no/such"),
    ],
)
def test_the_shell_guesses_what_is_meant_or_nothing(
    words: list[str], meant: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "BLOCK").with_suffix(".toml").write_text(SPRUNG)
    (tmp_path / "STIFF").with_suffix(".toml").write_text(SPRUNG.replace('drive = "F"', "stifness = 3"))
    with contextlib.suppress(SystemExit):
        assert main([str(tmp_path / f"{one}.toml") if one in ("BLOCK", "STIFF") else one for one in words])
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


def test_equations_that_divide_by_zero_at_the_start_have_a_note(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path, told = tmp_path / "a.toml", "at the start damper pot has no length there, and so no direction"
    pot = '[dampers.pot]\nfrom = "ground"\nto = "block"\ndamping = 3\n'
    free = SPRUNG.replace("c = 1", "c = {}")
    for text, noted in ((SPRUNG, True), (SPRUNG.replace("mass", "com = [0.1, 0, 0]\nmass"), True), (free, False),
                        (SPRUNG.replace("drive", "start = 0.2\ndrive"), False)):  # fmt: skip
        path.write_text(text + pot)
        assert main(["equations", str(path)]) == 0
        assert (told in capsys.readouterr().err) == noted


def test_a_joint_of_no_type_is_one_fault_and_a_centre_without_a_mass_is_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "a.toml"
    path.write_text(SPRUNG.replace('"prismatic"', '"slider"').replace("c = 1", 'c = "1 N s/m"'))
    assert main(["equations", str(path)]) == 1
    assert 'type = "slider" is not a joint; did you mean prismatic?' in (told := capsys.readouterr().err)
    assert "asked for" not in told
    for mass, joint in (("com = [0, 0, 1]", True), ("com = [0, 0, 0]", False), ("mass = 1\ncom = [0, 0, 1]", False)):
        path.write_text(SPRUNG.replace("mass = 1", mass))
        assert main(["draw", str(path), "-o", str(tmp_path / "a.svg")]) == 0
        assert ("bodies.block: has a centre of mass and no mass" in capsys.readouterr().err) == joint


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
    with pytest.raises(SimulateError, match="and no force or acceleration, whose cost is over time: cost"):
        symdyn.collocation(CART, until=1, end={"x": 1}, final_cost="F**2", intervals=4)

    path = str(tmp_path / "cart.toml")
    Path(path).write_text(symdyn.scene.write_text(CART, "toml").text)
    regulator = upright.lqr({"x": 1, "x_integral": 2}, {"F": 0.1}, N={"x*F": 0.05}, integral="x")
    asked = ["--lqr", "Q=x:1;x_integral:2", "R=F:0.1", "N=x*F:0.05", "integral=x"]
    assert main(["linearize", path, *asked, "--show", "margins", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["lqr"]["K"] == regulator.K.tolist()
    assert main(["linearize", path, *asked, "--show", "margins"]) == 0
    shown = capsys.readouterr().out
    assert f"loop of the regulator, cut open at F, asymptotically stable: {regulator.margins().words}" in shown
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


def test_what_is_given_twice_is_held_and_what_changes_nothing_is_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path, gains = tmp_path / "block.toml", str(tmp_path / "g.json")
    path.write_text(SPRUNG)
    asked = ["simulate", str(path), "--until", "1", "--every", "1", "--start", "x=1", "--start", "x_dot=2"]
    assert main(asked) == 0
    assert capsys.readouterr().out.splitlines()[1].split(",")[1:3] == ["1.0", "2.0"]

    both = [["Q=x:10;R=F:3"], ["Q=x:10", "--lqr", "R=F:3"], ["Q=x:10", "R=F:3"]]
    told, sampled = [], ["linearize", str(path), "--dt", "0.01", "--lqr"]
    for weights in both:
        assert main([*sampled, *weights, "--gains", gains, "--show", "step"]) == 0
        said = capsys.readouterr()
        told.append(said.out)
        assert "--dt 0.01: --show step: of the mechanism all the time" in said.err
    assert told[0] == told[1] == told[2]
    assert main([*sampled, "--show", "bode"]) == 0
    assert "--dt 0.01:" not in capsys.readouterr().err
    assert main([*asked, "--feedback", gains, "--period", "0.02"]) == 0
    assert "is made for 0.01 s" in capsys.readouterr().err

    with pytest.raises(SimulateError, match="values: mp is varied; leave it out here"):
        symdyn.sweep(CART, "mp=[1,2]", "max(x)", values={"mp": 3}, until=0.1)
    runs = symdyn.sweep(CART, "mp=normal(mp, 0.001)", "max(x)", values={"mp": 3}, until=0.1, count=2)
    assert (runs["mp"] > 2.9).all()


def test_a_folder_that_is_not_there_is_refused_and_a_name_is_no_list_of_letters(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, lost = symdyn.simulate(CART, until=0.02), tmp_path / "lost"
    writers: list[Callable[[], object]] = [
        lambda: run.to_csv(lost / "a.csv"), lambda: run.to_npz(lost / "a.npz"), lambda: run.save_plot(lost / "a.svg"),
        lambda: symdyn.draw.film(run, lost / "a.html"), lambda: symdyn.draw.picture(CART, file=lost / "a.svg"),
    ]  # fmt: skip
    for write in writers:
        with pytest.raises(SymdynError, match="there is no folder"):
            write()
    assert not lost.exists()
    drawn: list[object] = []
    monkeypatch.setattr(panels, "plot", lambda run, path, names, width: drawn.append(names))
    for names in ("x, theta", ["x", "theta"], "x"):
        run.save_plot(tmp_path / "a.svg", names)
    assert drawn == [["x", "theta"], ["x", "theta"], ["x"]]
