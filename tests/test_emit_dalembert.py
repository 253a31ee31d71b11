"""D'Alembert's system in LaTeX: what the page of an arm and of a four-bar says, and that it compiles."""

from __future__ import annotations

import re
import subprocess

import numpy as np
import pytest
from arms import puma560, two_link
from closed_mechanisms import symbolic_four_bar
from figure_5_39 import single_loop

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.emit.print.dalembert_page import dalembert_lines, dalembert_text
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import bind, body, parse, prismatic, read, scene
from symdyn.teach import walkthrough


def test_page_of_the_two_link_arm():
    text = dalembert_text(two_link())

    assert "3(u-1) = 3 \\cdot 2 = 6" in text
    assert "m_R = \\sum t\\,s_t = 4" in text
    assert "6 = 2 + 4" in text
    assert r"\bar F^{A}_{22} = \begin{bmatrix} -m_2 g \sin(q_1 + q_2) \\ -m_2 g \cos(q_1 + q_2)" in text
    outwards = r"-\ddot q_1 m_1 h_1 \\ -\dot q_1^2 m_1 h_1 \\ -\ddot q_1 m_1 h_1^2"  # the mass is at (0, -h1)
    assert r"\bar F^{D}_{11} = \begin{bmatrix} " + outwards in text
    assert r"\bar F^{*R}_{1,\mathrm{elbow}} = \begin{bmatrix} -F_{\mathrm{elbow},x} \\ -F_{\mathrm{elbow},y}" in text


def test_page_of_the_four_bar_shows_the_pattern_of_blocks():
    text = dalembert_text(symbolic_four_bar())

    assert "9 = 1 + 8" in text
    assert (
        r"\begin{bmatrix} A_{1,\mathrm{A}} & A_{1,\mathrm{B}} & 0 & 0 \\ "
        r"0 & A_{2,\mathrm{B}} & 0 & A_{2,\mathrm{C}} \\ "
        r"0 & 0 & A_{3,\mathrm{D}} & A_{3,\mathrm{C}} \end{bmatrix}"
    ) in text


def test_an_index_of_two_digits_stands_apart_from_its_twin():
    names = ["ground", *(f"b{k}" for k in range(10))]
    sliders = [prismatic(f"j{k}", *names[k : k + 2], axis=[1, 0, 0]) for k in range(10)]
    text = dalembert_text(scene("train", bodies=[body(name, mass=1) for name in names[1:]], joints=sliders))

    assert r"\bar F^{D}_{99}" in text
    assert r"\bar F^{D}_{10,10}" in text


@pytest.mark.slow
def test_a_spatial_mechanism_has_six_equations_a_body():
    text = dalembert_text(single_loop())

    assert "6(u-1) = 6 \\cdot 3 = 18" in text
    assert "18 = 1 + 17" in text


@pytest.mark.long(0)
def test_an_idle_spin_is_no_drive():
    text = dalembert_text(read("examples/rssr.toml"))

    said = "1 of them of degrees of freedom that nothing drives, such as an idle spin (ball)"
    assert f"$n = 2$ unknown drives, {said}" in text
    assert "18 = 2 + 16" in text


def test_a_force_over_time_has_time_among_the_symbols_of_the_document():
    slab = prismatic("slide", parent="ground", child="slab", axis=(1, 0, 0), force="3*sin(2*t)")
    text = dalembert_text(scene("pushed", bodies=[body("slab", mass=1)], joints=[slab]), document=True)

    assert r"\sin(2 t)" in text
    assert r"$t$ & time & $\mathrm{s}$" in text


def test_the_same_page_twice():
    assert dalembert_text(symbolic_four_bar()) == dalembert_text(symbolic_four_bar())


@pytest.mark.long
@pytest.mark.runs
@pytest.mark.parametrize("name", ["two_link", "slider_crank", "scara"])
def test_plain_text_is_a_linear_system_whose_solution_is_the_drive(name):
    mechanism = symdyn.example(name)
    mechanism = bind(mechanism, {one.name: 1 + k / 3 for k, one in enumerate(mechanism.free_parameters)})
    text = dalembert_lines(mechanism)
    unknowns = re.findall(r"^# (\w+): ", text, re.MULTILINE)
    lines = [line for line in re.sub(r"\n +", " ", text).splitlines() if line and not line.startswith("#")]
    graph = Graph()
    sides = [parse(line.removesuffix(" = 0")).express(graph) for line in lines]
    rng = np.random.default_rng(3)
    if mechanism.is_constrained:  # a state on the manifold, with accelerations and drives that go together
        run = symdyn.simulate(mechanism, forces={"M": "0.4"}, until=0.3)
        q, qd, qdd, wanted = run.q[-1], run.qd[-1], run.qdd[-1], {"M": 0.4}
    else:
        q, qd, qdd = rng.uniform(-1, 1, (3, len(mechanism.coordinates)))
        tau = symdyn.lambdify(mechanism, "inverse_dynamics")(q, qd, qdd)
        wanted = dict(zip(mechanism.drives, tau, strict=True))
    state = dict(zip(mechanism.coordinates, q, strict=True)) | dict(zip(mechanism.velocities, qd, strict=True))
    state |= {name.replace("_dot", "_ddot"): x for name, x in zip(mechanism.velocities, qdd, strict=True)}
    state |= {one.name: float(one.value.value) for one in mechanism.parameters}
    symbols = [node for node in reachable(sides) if node.op is Op.SYMBOL]

    def residual(x):
        given = state | dict(zip(unknowns, x, strict=True))
        return np.array(evaluate(sides, Floats(), {node: given[node.value] for node in symbols}))

    b = residual(np.zeros(len(unknowns)))
    A = np.column_stack([residual(row) - b for row in np.eye(len(unknowns))])
    found = dict(zip(unknowns, np.linalg.solve(A, -b), strict=True))
    assert len(lines) == len(unknowns) == A.shape[0]
    for drive, size in wanted.items():
        assert found[drive] == pytest.approx(size, abs=1e-9)


def test_numbers_are_not_rounded_in_silence(capsys):
    scara = symdyn.example("scara")
    assert "Decimal numbers are rounded to 6 digits." in dalembert_text(scara)
    assert "rounded" not in dalembert_text(two_link())

    digits = ["--formulation", "dalembert", "--format", "text"]
    assert main(["equations", str(scara.source), *digits]) == 0
    assert capsys.readouterr().out == dalembert_lines(scara) + "\n"
    assert main(["equations", str(scara.source), "--formulation", "dalembert", "--format", "sympy"]) == 1
    assert "written in LaTeX and, without --document, as text" in capsys.readouterr().err


def test_a_drive_called_like_a_reaction_keeps_its_name():
    rail = prismatic("rail", "ground", "cart", axis=[1, 0, 0], drive="F_rail_y")
    text = dalembert_lines(scene("cart", bodies=[body("cart", mass=1)], joints=[rail]))

    assert "# F_rail_y: drive of joint rail" in text
    assert "# F_rail_y_: force along y" in text


def test_a_system_that_nobody_reads_is_refused(monkeypatch):
    monkeypatch.setattr("symdyn.emit.print.dalembert_page.MOST", 20)
    with pytest.raises(EmitError, match="36 unknowns are more than anyone reads"):
        dalembert_text(puma560())


def test_command_line(capsys):
    assert main(["equations", "examples/two_link.toml", "--formulation", "dalembert"]) == 0
    assert r"\bar F^{R}_{11}" in capsys.readouterr().out
    assert (
        main(["equations", "examples/two_link.toml", "--formulation", "dalembert", "--format", "text", "--document"])
        == 1
    )
    assert "written in LaTeX and, without --document, as text" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "told"), [("--angles short", "leave --angles out"), ("--as matrix", "leave --as out")]
)
def test_what_dalembert_s_system_does_not_take_is_refused(option, told, capsys):
    assert main(["equations", "examples/two_link.toml", "--formulation", "dalembert", *option.split()]) == 1
    assert told in capsys.readouterr().err


@pytest.mark.runs
@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize("one", [two_link(), symbolic_four_bar()], ids=lambda one: one.name)
def test_the_document_compiles_and_fits_the_page(one, tmp_path):
    (tmp_path / "page.tex").write_text(dalembert_text(one, document=True), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)

    assert done.returncode == 0, done.stdout[-2000:]
    assert "Overfull" not in done.stdout


@pytest.mark.mends("30.also.lessons")
def test_a_system_of_many_megabytes_is_refused_with_its_size_before_it_is_written() -> None:
    """As LaTeX the bicycle's would be 76 MB; two wheels' directions stand in every entry."""
    bicycle = symdyn.example("bicycle")
    for written in (dalembert_text, dalembert_lines):
        with pytest.raises(symdyn.SymdynError, match="some 80 MB of formulas, and 5 MB are the most"):
            written(bicycle)


def test_a_lesson_of_many_megabytes_is_refused_with_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """No scene is known that has one: other bounds keep lessons below a megabyte, so this one is lowered."""
    monkeypatch.setattr("symdyn.emit.print.breaking.MOST", 0.001)
    with pytest.raises(
        symdyn.SymdynError, match=r"lesson by dalembert would be some 0\.\d+ MB .*ask for less of it \(until\)"
    ):
        walkthrough(symdyn.example("four_bar"), formulation="dalembert")
