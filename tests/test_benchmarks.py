"""The side-by-side benchmark runs and compares before it times; nothing here says how fast anything is."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.runs()

FOLDER = Path(__file__).parent.parent / "benchmarks"

WAYS = ("state", "batch")

needs_gcc = pytest.mark.runs("gcc")


def run(*words: str, script: str = "run.py") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(FOLDER / script), *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@needs_gcc
@pytest.mark.slow
def test_our_code_is_measured_and_reported(tmp_path):
    words = ["--robots", "two_link", "--outputs", "inverse_dynamics,mass_matrix", "--peers", "ours_c"]
    done = run("--quick", "--no-generation", *words, "-o", str(tmp_path))
    assert done.returncode == 0, done.stderr

    found = json.loads((tmp_path / "results.json").read_text("utf-8"))
    kinds = {(row["output"], row["peer"], row["way"]) for row in found["times"]}
    assert {(output, "symdyn", "state") for output in ("inverse_dynamics", "mass_matrix")} <= kinds
    assert all(len(row["samples"]) == found["rounds"] and min(row["samples"]) > 0 for row in found["times"])
    text = (tmp_path / "results.md").read_text("utf-8")
    assert "## Inverse dynamics" in text
    assert "| symdyn: C, one state a call |" in text


@pytest.mark.slow
@needs_gcc
def test_derivatives_are_measured_against_50_digits_and_bars_without_a_peer_are_told_apart(tmp_path):
    words = ["--quick", "--robots", "puma560", "--peers", "ours_c", "--rounds", "1", "-o", str(tmp_path)]
    done = run(*words, script="derivatives.py")
    assert done.returncode == 0, done.stderr

    found = json.loads((tmp_path / "results.json").read_text("utf-8"))
    kinds = {(row["output"], row["way"]) for row in found["times"] if row["peer"] == "symdyn"}
    assert kinds == {(f"{which}_dynamics_derivatives", way) for which in ("inverse", "forward") for way in WAYS}
    assert all(0 < row["relative"] < 1e-12 for row in found["times"])
    assert all(0 < row["share"] < 1 for row in found["times"])
    text = (tmp_path / "results.md").read_text("utf-8")
    assert "missed" not in text
    assert "comparisons were not made: their peer or their robot is left out" in text


def test_the_part_about_derivatives_takes_its_own_place_in_the_page(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    from derivatives_page import BEGIN, END, placed

    page = (FOLDER.parent / "docs" / "performance.md").read_text("utf-8")
    old = page.split(BEGIN)[1].split(END)[0].strip()

    assert placed(page, old + "\n") == page
    assert placed(page, "new\n").split(BEGIN)[1].split(END)[0].strip() == "new"
    with pytest.raises(ValueError, match="has no place for derivatives"):
        placed("# another page", old)


@pytest.mark.wide(2)
@pytest.mark.parametrize(
    ("script", "there"), [("run.py", "two_link, puma560, arm7"), ("derivatives.py", "puma560, arm7, anymal, chain16")]
)
def test_an_unknown_robot_is_refused(script, there):
    done = run("--robots", "arm9", script=script)

    assert done.returncode == 2
    assert f"there is no robot arm9; there are {there}" in done.stderr


def test_a_peer_that_computes_something_else_is_not_timed(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    import run as bench
    from cases import cases
    from harness import Timed

    case = cases()["two_link"]
    wrong = case.references["gravity_forces"] * (1 + 1e-9)

    class Peer:
        NAME = "wrong"

        @staticmethod
        def timed(case, output):
            return [Timed(case.name, output, "wrong", "state", 1, lambda sweeps: 1.0, lambda: wrong)]

    with pytest.raises(AssertionError, match="wrong, state: gravity_forces of two_link differs by"):
        bench.ready(case, "gravity_forces", [Peer], {})


@pytest.mark.wide(2)
@pytest.mark.parametrize("what", ["inverse dynamics to plain C", "inverse dynamics to library"])
@needs_gcc
def test_generation_is_timed_by_itself(what):
    command = [sys.executable, str(FOLDER / "generation.py"), what, "chain3"]
    assert float(subprocess.run(command, capture_output=True, text=True, check=True).stdout) > 0


def test_no_script_hides_a_module_of_the_tests():
    # `python benchmarks/x.py` with PYTHONPATH=tests looks for modules in benchmarks first.
    assert not {p.name for p in FOLDER.glob("*.py")} & {p.name for p in Path(__file__).parent.glob("*.py")}


@pytest.mark.slow
@pytest.mark.long
@needs_gcc
def test_every_accuracy_is_measured_beside_double():
    words = ["--robots", "puma560", "--outputs", "mass_matrix", "--states", "20", "--rounds", "2"]
    done = run(*words, script="accuracy_levels.py")
    assert done.returncode == 0, done.stderr
    for level in ("double", "1e-10", "float"):
        assert f"| puma560 | mass_matrix | {level} |" in done.stdout
    assert "| puma560, mass_matrix, accuracy 1e-10: largest error | ≤ 1e-10 |" in done.stdout


def test_every_bar_of_batch_and_matrices_is_told_where_it_was_measured(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    from bars import ALONE, BATCH, FD, FILLING, ID, NEAR_FLOOR, OURS, ROWS, M, bars

    def row(robot, output, kind, time):
        names = dict(zip(("peer", "way"), kind, strict=True))
        return {"robot": robot, "output": output, **names, "median": time, "samples": [time, time]}

    heyoka = ("heyoka, our graph", "batch")
    times = [row("arm7", ID, heyoka, 24.0), row("arm7", ID, BATCH, 16.0), row("puma560", ID, BATCH, 12.0)]
    kinds = {FILLING: 100.0, ALONE: 200.0, OURS: 400.0, BATCH: 120.0, ROWS: 500.0}
    times += [row("tree32", M, kind, time) for kind, time in kinds.items()]
    times += [row(f"chain{n}", FD, BATCH, time) for n, time in ((8, 10.0), (64, 100.0))]
    found = {bar.text: bar.reached for bar in bars(times, multipliers=1)}

    near = {robot: next(text for text in found if f"of {robot}, batch" in text) for robot, _ in NEAR_FLOOR}
    assert [found[near[robot]] for robot in ("arm7", "puma560")] == [True, False]
    assert found["inverse dynamics, batch, times heyoka on our graph"]
    told = {text: reached for text, reached in found.items() if text.startswith("M of tree32")}
    assert list(told.values()) == [True, True, True, False, False, False]
    assert any("floor 3.00" in bar.shown for bar in bars(times)), "one after the other, both take so long"
    assert found["forward_dynamics, batch: time a joint of a chain of 64, times that of 8"]
    assert len(found) == 10
    others = {bar.text: bar.verdict for bar in bars(times, multipliers=2)}
    assert {others[text] for text in near.values()} == {"another core's bar"}


@needs_gcc
def test_the_machine_says_how_many_products_its_core_begins_in_a_cycle(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    import machine

    core = machine.multipliers()
    assert core is not None
    assert core.width in (128, 256, 512)
    assert core.products > 0
    assert core.clock > 0
    assert str(core).endswith("GHz")


@pytest.mark.slow
@pytest.mark.long(0)
def test_large_mechanisms_are_held_to_their_bars():
    done = run("64", "--loops", "--tables", "--runs", "1", script="large_mechanisms.py")
    assert done.returncode == 0, done.stderr
    assert "chain of 64, from the scene to C: " in done.stdout
    assert "(≤ 0.15 s)" in done.stdout
