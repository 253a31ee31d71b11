"""D'Alembert's system in LaTeX: what the page of an arm and of a four-bar says, and that it compiles."""

from __future__ import annotations

import subprocess

import pytest
from arms import puma560, two_link
from closed_mechanisms import symbolic_four_bar
from figure_5_39 import single_loop

from symdyn.cli import main
from symdyn.emit.print.dalembert_page import dalembert_text
from symdyn.errors import EmitError
from symdyn.scene import body, prismatic, read, scene


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


@pytest.mark.long
def test_a_spatial_mechanism_has_six_equations_a_body():
    text = dalembert_text(single_loop())

    assert "6(u-1) = 6 \\cdot 3 = 18" in text
    assert "18 = 1 + 17" in text


def test_an_idle_spin_is_no_drive():
    text = dalembert_text(read("examples/rssr.toml"))

    assert "$n = 2$ unknown drives, 1 of them of freedoms that nothing drives, such as an idle spin (ball)" in text
    assert "18 = 2 + 16" in text


def test_a_force_over_time_has_time_among_the_symbols_of_the_document():
    slab = prismatic("slide", parent="ground", child="slab", axis=(1, 0, 0), force="sin(2*t)")
    text = dalembert_text(scene("pushed", bodies=[body("slab", mass=1)], joints=[slab]), document=True)

    assert r"\sin(2 t)" in text
    assert r"$t$ & time & $\mathrm{s}$" in text


def test_the_same_page_twice():
    assert dalembert_text(symbolic_four_bar()) == dalembert_text(symbolic_four_bar())


def test_a_system_that_nobody_reads_is_refused(monkeypatch):
    monkeypatch.setattr("symdyn.emit.print.dalembert_page.MOST", 20)
    with pytest.raises(EmitError, match="36 unknowns are more than anyone reads"):
        dalembert_text(puma560())


def test_command_line(capsys):
    assert main(["equations", "examples/two_link.toml", "--as", "dalembert"]) == 0
    assert r"\bar F^{R}_{11}" in capsys.readouterr().out
    assert main(["equations", "examples/two_link.toml", "--as", "dalembert", "--format", "text"]) == 1
    assert "written in LaTeX, not as text" in capsys.readouterr().err


@pytest.mark.runs
@pytest.mark.runs("pdflatex")
@pytest.mark.parametrize("one", [two_link(), symbolic_four_bar()], ids=lambda one: one.name)
def test_the_document_compiles_and_fits_the_page(one, tmp_path):
    (tmp_path / "page.tex").write_text(dalembert_text(one, document=True), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)

    assert done.returncode == 0, done.stdout[-2000:]
    assert "Overfull" not in done.stdout
