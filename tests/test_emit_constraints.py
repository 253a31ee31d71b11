"""The equations of closed scenes in print: Gᵀ λ on the right, the rows below, equal to what generated code computes."""

from __future__ import annotations

import random
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patience import HANG

from symdyn import lambdify
from symdyn.cli import main
from symdyn.emit.print.equations_text import FORMATS, GROUPS, equations_text
from symdyn.scene import Scene, body, loop, read, revolute, scene
from symdyn.scene.values import acceleration_name, spell

EXAMPLES = Path(__file__).parent.parent / "examples"
CLOSED = ("four_bar", "slider_crank", "governor", "rsup", "cart_with_wheel")
FUNCTIONS = ("forward_dynamics", "multipliers", "constraint_residual", "constraint_jacobian")


def example(name: str) -> Scene:
    return read(EXAMPLES / f"{name}.toml")


@cache
def functions(name: str) -> Any:
    return lambdify(example(name), FUNCTIONS)


@pytest.mark.parametrize("angles", ["long", "short"])
@pytest.mark.parametrize("name", ["four_bar", "slider_crank"])
def test_short_angles_reach_the_rows(name: str, angles: str) -> None:
    text = equations_text(example(name), "text", angles=angles)

    assert ("*cos(psi)" in text) == (angles == "long")
    assert ("*c2 " in text) == (angles == "short")


@pytest.mark.wide(3)
@pytest.mark.long
@pytest.mark.parametrize("group", ["equations", "matrix"])
@pytest.mark.parametrize("name", CLOSED)
def test_generated_code_solves_the_printed_equations(name: str, group: str) -> None:
    scene = example(name)
    forward, sizes, residual, jacobian = functions(name)
    rng = random.Random(3)
    n = len(scene.velocities)
    q, u, tau = (np.array([rng.uniform(0.2, 1.0) for _ in range(n)]) for _ in range(3))
    tau = tau * [drive is not None for drive in scene.drives]
    free = [np.ones(len(scene.free_parameters))] if scene.free_parameters else []
    qdd, found = forward(q, u, tau, *free), sizes(q, u, tau, *free)
    values = dict(zip(scene.coordinates, q, strict=True)) | dict(zip(scene.velocities, u, strict=True))
    values |= dict(zip(map(acceleration_name, scene.velocities), qdd, strict=True))
    values |= {drive: x for drive, x in zip(scene.drives, tau, strict=True) if drive}
    values |= {f"lambda{k}": x for k, x in enumerate(found, 1)}
    printed = run(equations_text(scene, "sympy", group), scene, values)

    balances = [x for key, x in printed.items() if key.startswith("equation")]
    assert len(balances) == (n if group == "equations" else 1)
    for difference in [*balances, *(x for key, x in printed.items() if key.startswith("acceleration"))]:
        assert np.abs(difference).max() < 1e-9 * max(1.0, np.abs(found).max())
    rates = [x for key, x in printed.items() if key.startswith("velocity")]
    np.testing.assert_allclose(np.ravel(rates), jacobian(q, *free) @ u, atol=1e-12)
    positions = [x for key, x in printed.items() if key.startswith("position")]
    closing = residual(q, *free)
    np.testing.assert_allclose(np.ravel(positions), closing if scene.loops else [], atol=1e-12)


def run(text: str, scene: Scene, values: dict[str, float]) -> dict[str, np.ndarray[Any, Any]]:
    """Left minus right of every equation of a printed program."""
    import sympy

    names: dict[str, Any] = {}
    exec("from sympy import *", names)
    exec(text, names)
    parameters = {p.name: float(sympy.sympify(spell(p.value))) for p in scene.parameters if p.value is not None}
    known = values | parameters
    at = {symbol: known[symbol.name] for symbol in names.values() if isinstance(symbol, sympy.Symbol)}
    found = {}
    for name, equation in names.items():
        if isinstance(equation, sympy.Eq):
            found[name] = np.array((equation.lhs - equation.rhs).subs(at), dtype=float)
    return found


@pytest.mark.parametrize("format_", FORMATS)
@pytest.mark.parametrize("group", GROUPS)
def test_every_page_names_the_multipliers(format_: str, group: str) -> None:
    text = equations_text(example("four_bar"), format_, group)

    assert "force along x of loop hinge, exerted by coupler on rocker" in text


@pytest.mark.parametrize(("group", "entries"), [("equations", 0), ("coefficients", 6), ("textbook", 0), ("matrix", 6)])
def test_rows_are_written_entry_by_entry_where_the_equations_are(group: str, entries: int) -> None:
    text = equations_text(example("four_bar"), "text", group)

    assert len(re.findall(r"^G\[[12],[123]\] = ", text, re.MULTILINE)) == entries  # two rows, three coordinates
    assert ("\n# velocities" in text) == (not entries)


def test_the_rows_of_a_four_bar_are_short() -> None:
    lines = equations_text(example("four_bar"), "text").splitlines()

    assert "-b + d*cos(phi + psi) + c*cos(phi + psi - chi) - a*cos(psi) = 0" in lines
    assert any(line.endswith("= c*sin(phi + psi - chi)*lambda1 + c*cos(phi + psi - chi)*lambda2") for line in lines)


def test_a_loop_on_a_turning_base_folds_products_into_sums_of_angles() -> None:
    """Two branches stand side by side on a body whose own axis is another one, as a palletizing arm has it."""
    bars = [body(name, mass=1, com=[1, 0, 0]) for name in ("base", "upper", "crank", "rod")]
    joints = [
        revolute("yaw", "ground", "base", axis=[0, 0, 1]),
        revolute("p", "base", "upper", axis=[0, 1, 0], coordinate="p", start=-1),
        revolute("s", "base", "crank", axis=[0, 1, 0], coordinate="s", start=-1, origin=["-3/10", 0, 0]),
        revolute("r", "crank", "rod", axis=[0, 1, 0], coordinate="r", start=1, origin=[1, 0, 0]),
    ]
    close = loop("close", "revolute", "rod", "upper", axis=[0, 1, 0], origin=["3/10", 0, 0], tip=[-1, 0, 0])
    text = equations_text(scene("pallet", bodies=bars, joints=joints, loops=[close]), "text")

    assert "# positions\n-0.3 + cos(p - s - r) + 0.3*cos(s + r) - cos(r) = 0\n" in text


def test_trees_say_nothing_of_multipliers() -> None:
    assert "lambda" not in equations_text(example("two_link"), document=True)


def test_a_parameter_called_lambda1_keeps_its_name(tmp_path: Path) -> None:
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8")
    path = tmp_path / "four_bar.toml"
    path.write_text(re.sub(r"\bm3\b", "lambda1", text), encoding="utf-8")

    assert "# lambda1_: force along x" in equations_text(read(path), "text")


@pytest.mark.parametrize("format_", FORMATS)
def test_rows_without_a_closed_form_are_named_and_say_why(format_: str, tmp_path: Path) -> None:
    text = (EXAMPLES / "rolling_disc.toml").read_text(encoding="utf-8")
    coordinates = '["x", "y", "z", "a", "b", "c"]\norientation = "zyx"'
    text = text.replace('["x", "y", "z", "e0", "e1", "e2", "e3"]', coordinates)
    text = re.sub(r"start = .*", 'start = [0, 0, "r*cos(pi/12)", 0, 0, "pi/12"]', text)
    text = re.sub(r"start_rates = .*", "", text)
    path = tmp_path / "rolling_disc.toml"
    path.write_text(text, encoding="utf-8")
    shown = equations_text(read(path), format_)

    assert "has no closed form: " in shown
    assert ("G_{" in shown) if format_ == "latex" else ("G1_" in shown)


@pytest.mark.wide(3)
@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("name", ["four_bar", "rsup"])
def test_documents_of_closed_scenes_compile_and_fit(name: str, group: str, tmp_path: Path) -> None:
    (tmp_path / "page.tex").write_text(equations_text(example(name), group=group, document=True), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False, timeout=HANG)
    log = done.stdout.decode("utf-8", "replace")

    assert done.returncode == 0, log[-2000:]
    assert "Overfull" not in log


@pytest.mark.parametrize(
    "words", [["equations"], ["equations", "--as", "base-parameters"], ["info", "--base-parameters"]], ids=" ".join
)
@pytest.mark.parametrize("name", ["heavy_top", "rolling_disc", "free_body"])
def test_quaternions_end_in_one_line_or_in_a_page(
    name: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    code = main([words[0], str(EXAMPLES / f"{name}.toml"), *words[1:]])
    told = capsys.readouterr()

    assert "Traceback" not in told.err
    if code:
        assert code == 1
        assert 'write orientation = "zyx"' in told.err
    else:
        assert told.out.strip()
