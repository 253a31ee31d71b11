"""Runs that end early keep their rows and say why, whatever the method; runs that would not end say how long."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from patience import HANG

from symdyn.cli import main
from symdyn.scene import read
from symdyn.simulation import read_forces, simulate
from symdyn.simulation.integrate.integration import IntegrationError
from symdyn.simulation.integrate.stepwise import Pace

pytestmark = pytest.mark.runs()

HERE = Path(__file__).parent
EXAMPLES = HERE.parent / "examples"
CART, FOUR_BAR = str(EXAMPLES / "cart_pole.toml"), str(EXAMPLES / "four_bar.toml")

ENDS = "F=5+sqrt(0.01-x)"
"""Has no real value from x = 0.01 m on, where the cart comes at t = 0.0635 s."""

LIBRARIES = {"taylor": "heyoka", "cvode": "sksundae", "adams": "sksundae", "ida": "sksundae"}


@pytest.mark.parametrize("method", ["taylor", "dop853", "rk45", "radau", "bdf", "lsoda", "cvode", "adams", "ida"])
def test_a_run_that_ends_early_keeps_its_rows(method: str, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip(LIBRARIES.get(method, "scipy"), reason="needs the library of the method")
    scene = read(CART)
    with pytest.warns(RuntimeWarning, match="rows until t = .* s are kept"):
        found = simulate(scene, forces=read_forces(scene, [ENDS]), until=1.0, method=method, every=0.005)

    assert not found.complete
    assert len(found.t) > 10
    assert 0.06 < found.t[-1] < 0.0636
    assert np.all(np.isfinite(found.q))
    assert np.all(np.isfinite(found.qd))
    assert "the driving force F" in found.stopped
    assert "has no real value there" in found.stopped
    assert capfd.readouterr() == ("", "")  # nobody prints into what the caller prints


@pytest.mark.mends("2.ida")
def test_in_python_an_end_before_its_time_warns_and_keeps_its_rows() -> None:
    pytest.importorskip("sksundae", reason="needs scikit-sundae, the extra simulate")
    scene = read(CART)
    with pytest.warns(RuntimeWarning, match="IDA cannot go on"):
        found = simulate(scene, forces=read_forces(scene, [ENDS]), until=1.0, method="ida", every=0.005)
    assert len(found.t) > 10


@pytest.mark.mends("2.ida")
def test_ida_keeps_to_its_tolerance() -> None:
    """A four-bar for 2 s: within fifty times what is asked of a step, where errors of all steps add up.

    Rounding decides which steps are taken, so that one run may have eleven times and its neighbour fifty-three.
    """
    pytest.importorskip("sksundae", reason="needs scikit-sundae, the extra simulate")
    scene = read(FOUR_BAR)
    known = simulate(scene, until=2.0, method="dop853", rtol=1e-12, every=2.0).q[-1]
    runs = {rtol: simulate(scene, until=2.0, method="ida", rtol=rtol, every=2.0) for rtol in (8e-9, 9e-9, 1e-8)}
    assert np.median([np.abs(found.q[-1] - known).max() / rtol for rtol, found in runs.items()]) < 50


SHAFT = """
name = "shaft"
gravity = [0, 0, -9.81]
[bodies]
shaft = { mass = 1, inertia = [0.1, 0.1, 0.1], inertia_about = "com" }
slider = { mass = 1 }
[joints]
turn = { type = "revolute", parent = "ground", child = "shaft", axis = [0, 0, 1], coordinate = "phi", start_rates = 2 }
slide = { type = "prismatic", parent = "ground", child = "slider", axis = [1, 0, 0], coordinate = "x", start = 1 }
"""


@pytest.mark.mends("2.radau")
def test_implicit_methods_know_how_rates_depend_on_a_coordinate_that_hardly_moves_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Differences of a coordinate without effect grow with every try, until it stands at infinity."""
    path = tmp_path / "shaft.toml"
    path.write_text(SHAFT)
    oscillator = "x=10*(1-x**2)*x_dot-x+1e-300*sin(phi)"
    command = ["simulate", str(path), "--forces", oscillator, "--until", "200", "--every", "50", "--rtol", "1e-2"]
    assert main([*command, "--method", "radau"]) == 0
    rows = [[float(x) for x in line.split(",")] for line in capsys.readouterr().out.splitlines()[1:]]
    assert [row[0] for row in rows] == [0, 50, 100, 150, 200]
    assert rows[-1][1] == pytest.approx(400)


@pytest.mark.mends("2.radau")
@pytest.mark.parametrize("method", ["radau", "bdf"])
def test_what_a_library_raises_ends_the_run_with_its_rows(
    method: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import scipy.integrate

    kind = getattr(scipy.integrate, {"radau": "Radau", "bdf": "BDF"}[method])
    step = kind._step_impl

    def fails(self: object) -> object:
        if self.t > 0.1:  # type: ignore[attr-defined]
            raise ValueError("array must not contain infs or NaNs")
        return step(self)

    monkeypatch.setattr(kind, "_step_impl", fails)
    assert main(["simulate", CART, "--until", "1", "--start", "theta=0.1", "--every", "0.01", "--method", method]) == 1
    out, err = capsys.readouterr()
    assert len(out.splitlines()) > 10
    assert "array must not contain infs or NaNs" in err


FOREVER = """
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, (400, 400))
try:
    from symdyn.simulation import integration
    integration.FIRST = 0.1
except ImportError:
    pass
from symdyn.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.mends("2.until")
def test_an_end_that_no_run_reaches_ends_it_with_its_rows_and_says_why() -> None:
    words = ["simulate", str(EXAMPLES / "pendulum.toml"), "--start", "q1=1", "--until", "1e308", "--method", "dop853"]
    found = subprocess.run(
        [sys.executable, "-c", FOREVER, *words], capture_output=True, text=True, timeout=HANG, check=False
    )
    assert found.returncode == 1
    assert "at this pace t = 1e+308 s takes about" in found.stderr
    assert "years, so the run ends here" in found.stderr
    assert len(found.stdout.splitlines()) >= 3  # the header, the start, and where it stood


def test_a_run_that_is_long_says_how_long(monkeypatch: pytest.MonkeyPatch) -> None:
    from symdyn.simulation.integrate import integration

    now, said = [0.0], list[str]()
    monkeypatch.setattr(integration.time, "perf_counter", lambda: now[0])
    one = integration.Outlook(1e6, said.append)
    for now[0], t in ((0.0, 0.0), (1.0, 100.0), (3.5, 350.0), (10.0, 1000.0), (20.0, 2000.0)):
        one.look(t)
    assert [line.split(" after")[0] for line in said] == ["t = 350 s", "t = 2000 s"]
    assert "the end at t = 1e+06 s is about 2.8 hours away" in said[0]


@pytest.mark.mends("3.10")
def test_series_are_the_choice_for_loops_and_keep_them_closed(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")
    assert main(["simulate", FOUR_BAR, "--until", "2", "--every", "2"]) == 0
    out, err = capsys.readouterr()
    assert "method: taylor (heyoka), tolerance 1e-12" in err

    names, _, row = (line.split(",") for line in out.splitlines())
    last = dict(zip(names, map(float, row), strict=True))
    scene = read(FOUR_BAR)
    known = simulate(scene, until=2.0, method="dop853", rtol=1e-13, every=2.0).q[-1]
    assert [last[name] for name in scene.coordinates] == pytest.approx(known, abs=1e-11)
    assert last["loop_error"] < 1e-12
    assert last["energy_error"] == pytest.approx(0, abs=1e-10)


def test_thousands_of_steps_that_advance_are_no_fault() -> None:
    def integrated(way: float) -> None:
        problem: Any = SimpleNamespace(system=SimpleNamespace(once=lambda _: False), begin=0.0, until=10.0)
        pace = Pace(problem)
        for k in range(Pace.STEPS):
            step: Any = SimpleNamespace(t1=1.0 + way * (k + 1) / Pace.STEPS)
            pace.begin = pace.begin or 1.0
            pace.check(step)

    integrated(0.01)
    with pytest.raises(IntegrationError, match="beyond all bounds"):
        integrated(1e-10)
