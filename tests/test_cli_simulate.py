"""The verbs `simulate` and `inverse` as a user calls them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import HANG

from symdyn.cli import main

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
DOUBLE = str(EXAMPLES / "double_pendulum.toml")


def test_simulate_prints_csv_and_says_its_method(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", DOUBLE, "--until", "1", "--start", "q1=1", "--method", "dop853", "--every", "0.25"]) == 0

    out, err = capsys.readouterr()
    rows = out.splitlines()
    assert rows[0].startswith("t,q1,q2,q1_dot,q2_dot,q1_ddot,q2_ddot,tau1,tau2,kinetic_energy")
    assert [row.split(",")[0] for row in rows[1:]] == ["0.0", "0.25", "0.5", "0.75", "1.0"]
    assert "symdyn: method: dop853 (SciPy), tolerance 1e-10" in err
    assert "energy balance holds to" in err


def test_stop_report_npz_and_plots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib, the extra plot")
    words = ["simulate", DOUBLE, "--until", "5", "--start", "q1=0.5,q2=0.3", "--stop", "q1 - 0.1", "--report", "q2"]
    words += ["--method", "dop853", "-o", str(tmp_path / "a.npz")]
    for ending in ("svg", "pdf", "png", "html"):
        assert main([*words, "--plot", str(tmp_path / f"a.{ending}")]) == 0

    err = capsys.readouterr().err
    assert "event: q2 = 0 at t = 0.35568" in err
    assert "stopped: q1 - 0.1 = 0 at t = 0.40026" in err
    data = np.load(tmp_path / "a.npz")
    assert data["q"][-1, 0] == pytest.approx(0.1, abs=1e-9)
    about = json.loads(str(data["about"]))
    assert about["stopped"] == "q1 - 0.1"
    assert [*about["units"]][:9] == ["t", "q1", "q2", "q1_dot", "q2_dot", "q1_ddot", "q2_ddot", "tau1", "tau2"]
    assert (about["units"]["q1_dot"], about["units"]["kinetic_energy"]) == ("rad/s", "J")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    pdf = (tmp_path / "a.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert b"matplotlib" not in pdf
    assert b"CreationDate" not in pdf
    page = (tmp_path / "a.html").read_text()
    assert "<svg" in page
    assert "http-equiv" not in page
    assert "<script src" not in page
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.html", "a.npz", "a.pdf", "a.png", "a.svg"]


def test_the_page_of_a_plot_tells_what_a_contact_takes(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib, the extra plot")
    words = ["simulate", "examples/rolling_disc.toml", "--until", "0.1", "--every", "0.05"]

    assert main([*words, "--plot", str(tmp_path / "a.html")]) == 0
    page = (tmp_path / "a.html").read_text()
    assert "smallest normal force, N, of contact" in page
    assert "largest friction coefficient that is needed, of contact" in page


@pytest.mark.slow
def test_a_plot_does_not_read_a_stranger_s_matplotlibrc(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib, the extra plot")
    words = [sys.executable, "-m", "symdyn", "simulate", DOUBLE, "--until", "0.1", "--method", "dop853"]
    pictures = []
    for name, stranger in (
        ("alone", None),
        ("beside", b"axes.facecolor: red\ntext.usetex: True\nlines.marker: \xff\n"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        if name == "beside":
            (folder / "matplotlibrc").write_bytes(stranger)
        to = ["-o", "a.csv", "--plot", "a.svg"]
        done = subprocess.run([*words, *to], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert "matplotlibrc" not in done.stderr
        pictures.append((folder / "a.svg").read_bytes())
    assert pictures[0] == pictures[1]


LIBRARY = """
import os, signal, time
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.1)
except KeyboardInterrupt as fault:
    raise ImportError("initialization failed") from fault
"""


def test_an_interrupt_while_a_library_is_imported_is_an_interrupt(tmp_path: Path) -> None:
    (tmp_path / "heyoka.py").write_text(LIBRARY)
    words = [sys.executable, "-m", "symdyn", "simulate", DOUBLE, "--until", "0.1", "--method", "taylor"]
    paths = os.pathsep.join([str(tmp_path), str(Path(__file__).parent.parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        words,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=_listening,
    )
    assert done.returncode == 130, done.stderr
    assert "symdyn: interrupted at t = 0 s" in done.stderr
    assert "ImportError" not in done.stderr


def _listening() -> None:
    """Hear SIGINT, which a shell's background ignores, and so would its children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_inverse_prints_forces_and_reactions(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["inverse", DOUBLE, "--motion", "q1=quintic(0, pi/2, 1)", "q2=0.1*t**2", "--until", "1", "--every", "0.5"]
    assert main([*words, "--reactions"]) == 0

    header, *rows = capsys.readouterr().out.splitlines()
    assert "tau1" in header
    assert "reaction_upper_fx" in header
    assert len(rows) == 3


def test_all_faults_of_a_command_come_together(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", DOUBLE, "--until", "-1", "--start", "q9=1", "--forces", "q8=1", "--stop", "q7", "--rtol", "3"]
    assert main([*words, "--method", "tailor", "-o", "a.txt"]) == 1

    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err
    for said in ("until = -1", "q9", "q8", "q7", "rtol = 3", "did you mean taylor?", ".csv or .npz"):
        assert said in err
    assert len(err.splitlines()) == 7


def test_free_parameters_and_unknown_laws_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(DOUBLE).read_text().replace("m2 = { value = 0.8, ", "m2 = { ")
    (tmp_path / "open.toml").write_text(text)

    assert main(["simulate", str(tmp_path / "open.toml"), "--until", "1"]) == 1
    assert "m2 has no value" in capsys.readouterr().err
    assert main(["inverse", DOUBLE, "--motion", "q1=quintik(0,1,2)", "q5=0"]) == 1
    err = capsys.readouterr().err
    assert "q5 is not a coordinate" in err
    assert "give --until" in err


def test_animations_are_pages_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", DOUBLE, "--until", "1", "--start", "q1=1", "--method", "dop853", "--every", "0.1"]
    assert main([*words, "--animate", str(tmp_path / "a.html")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'a.html'}\n"  # and no table
    motion = ["inverse", DOUBLE, "--motion", "q1=quintic(0, 1, 1)", "--until", "1", "--every", "0.1"]
    assert main([*motion, "--animate", str(tmp_path / "b.svg"), "-o", str(tmp_path / "b.csv")]) == 0

    page, picture = (tmp_path / "a.html").read_text(), (tmp_path / "b.svg").read_text()
    assert page.startswith("<!DOCTYPE html>")
    assert len(json.loads(page.split('type="application/json">')[1].split("</script>")[0])["t"]) == 11
    assert picture.startswith("<svg")
    assert 'dur="1s"' in picture
    assert main([*words, "--animate", str(tmp_path / "a.avi")]) == 1
    assert "animations are written to .html, .svg, .gif, .glb, .mp4 files" in capsys.readouterr().err
    assert main([*words, "--animate", str(tmp_path / "none" / "a.html")]) == 1
    assert "there is no folder" in capsys.readouterr().err


def test_what_is_odd_about_a_run_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "f.csv"
    table.write_text("t,F\n0,1\n1,2\n")
    cart = str(EXAMPLES / "cart_pole.toml")
    assert main(["simulate", cart, "--until", "2", "--forces", str(table), "--every", "1"]) == 0
    assert (
        "the table of F goes from 0 s to 1 s; outside, the force is that of its nearest row" in capsys.readouterr().err
    )
    assert main(["simulate", cart, "--until", "1", "--forces", str(table), "--every", "1"]) == 0
    assert "the table of F" not in capsys.readouterr().err
    assert main(["inverse", cart, "--motion", "x=0", "theta=t", "--until", "1", "--every", "1"]) == 0
    assert "theta has no drive, and the motion takes up to " in capsys.readouterr().err
    assert main(["simulate", cart, "--until", "9", "--forces", "F=-20*x-8*sign(x_dot)", "--start", "x=0.1"]) == 1
    err = capsys.readouterr().err
    assert "the motion sticks at t = " in err
    assert "tanh(v/0.01)" in err
    assert main(["simulate", cart, "--until", "1", "--rtol", "1e-40", "--start", "x="]) == 1
    err = capsys.readouterr().err
    assert "rtol = 1e-40 is not a tolerance; give one between 1e-30 and 1" in err
    assert '--start: "x=" is not name=formula' in err


@pytest.mark.mends("2.ida")
@pytest.mark.parametrize("method", ["cvode", "adams", "ida"])
def test_sundials_keeps_its_own_words_to_itself(method: str, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("sksundae", reason="needs scikit-sundae, the extra simulate")
    cart = str(EXAMPLES / "cart_pole.toml")
    words = ["simulate", cart, "--until", "1", "--forces", "F=5+sqrt(0.01-x)", "--method", method]
    assert main(words) == 1

    out, err = capfd.readouterr()
    head, *rows = out.splitlines()
    assert head.startswith("t,x,theta")
    assert len(rows) > 10
    assert all(len([float(cell) for cell in row.split(",")]) == len(head.split(",")) for row in rows)
    assert "WARNING" not in out + err
    assert " cannot go on after t = 0.0635" in err
    assert "Successful" not in err


LISTENING = """
import os, signal, sys, threading
from symdyn.cli import main
from symdyn.simulation.integrate.integration import Outlook
signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores Ctrl-C
look, soon = Outlook.look, threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
def first(self, t, why=str):
    if t > 5:  # while it goes on, however long what is before takes
        Outlook.look = look
        soon.start()
Outlook.look = first
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.wide("dop853")
@pytest.mark.parametrize("method", ["dop853", "taylor"])
def test_ctrl_c_keeps_what_was_computed(tmp_path: Path, method: str) -> None:
    if method == "taylor":
        pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    out = tmp_path / "long.csv"
    until = {"dop853": "10000", "taylor": "1000000"}[method]
    words = ["simulate", DOUBLE, "--until", until, "--every", "0.1", "--start", "q1=1", "--method", method]
    process = subprocess.run(
        [sys.executable, "-c", LISTENING, *words, "-o", out],
        check=False,
        stderr=subprocess.PIPE,
        text=True,
        timeout=HANG,
    )
    err = process.stderr

    assert process.returncode == 130
    assert "interrupted at t = " in err
    assert "Traceback" not in err
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    assert len(table) > 20
    assert np.all(np.diff(table[:, 0]) > 0)
    assert np.all(np.isfinite(table))
    assert [path.name for path in tmp_path.iterdir()] == ["long.csv"]
