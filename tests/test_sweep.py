"""Sweeps: what names are varied over, which values are tried together, what comes of it, stores that are kept."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from patience import HANG
from scipy import stats

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError, StudyError, UnknownNameError
from symdyn.scene import Scene
from symdyn.scene.values.entry import Faults
from symdyn.study.design import DESIGNS, Design, read_design
from symdyn.study.distributions import DISTRIBUTIONS, Distribution, read_over
from symdyn.study.runs import ENDED, FAILED, NOT_MADE, STOPPED

EXAMPLES = Path(__file__).parent.parent / "examples"
PENDULUM = str(EXAMPLES / "pendulum.toml")

Capture = pytest.CaptureFixture[str]


def over_of(*texts: str) -> tuple[Distribution, ...]:
    faults = Faults("")
    found = read_over(Scene("p"), texts, [text.partition("=")[0] for text in texts], faults)
    assert not faults.lines
    return found


def design_of(kind: str | None, count: int | None, *texts: str, seed: int = 3) -> Design:
    faults = Faults("")
    found = read_design(over_of(*texts), kind, count, seed, faults)
    assert found is not None, faults.lines
    return found


LISTS = {
    "linspace(1,2,5)": np.linspace(1, 2, 5),
    "linspace(start=1, stop=2, count=3)": np.linspace(1, 2, 3),
    "geomspace(1,100,3)": [1, 10, 100],
    "logspace(0,2,3)": [1, 10, 100],
    "[1, 2/4, pi]": [1, 0.5, math.pi],
}


@pytest.mark.parametrize("text", LISTS)
def test_a_list_has_its_values(text: str) -> None:
    (one,) = over_of(f"a={text}")
    np.testing.assert_allclose(one.values, LISTS[text])
    assert set(one.at(np.linspace(0, 0.999, 50))) == set(one.values)


KNOWN: dict[str, stats.rv_continuous] = {
    "uniform(2,5)": stats.uniform(2, 3),
    "loguniform(1,100)": stats.loguniform(1, 100),
    "normal(3,2)": stats.norm(3, 2),
    "normal(3, sigma=2, low=1)": stats.truncnorm(-1, np.inf, 3, 2),
    "normal(3,2,1,3.5)": stats.truncnorm(-1, 0.25, 3, 2),
    "normal(0,1,low=7,high=9)": stats.truncnorm(7, 9),
    "normal(0,1,low=9,high=10)": stats.truncnorm(9, 10),
    "normal(0,1,high=-9)": stats.truncnorm(-np.inf, -9),
    "lognormal(median=10,sigma=0.3)": stats.lognorm(0.3, scale=10),
    "triangular(1,2,5)": stats.triang(0.25, 1, 4),
    "triangular(1,1,5)": stats.triang(0, 1, 4),
}


@pytest.mark.parametrize("text", KNOWN)
def test_a_distribution_has_the_quantiles_of_scipy(text: str) -> None:
    u = np.array([1e-9, 0.01, 0.25, 0.5, 0.9, 1 - 1e-9])
    (one,) = over_of(f"a={text}")
    assert one.values is None
    np.testing.assert_allclose(one.at(u), KNOWN[text].ppf(u), rtol=1e-7)


def test_every_distribution_is_tried_above() -> None:
    assert {text.partition("(")[0] for text in (*LISTS, *KNOWN)} - {"[1, 2/4, pi]"} == set(DISTRIBUTIONS)


@pytest.mark.parametrize("kind", [kind for kind in DISTRIBUTIONS if DISTRIBUTIONS[kind].quantile])
def test_no_draw_is_infinite(kind: str) -> None:
    text = next(one for one in KNOWN if one.startswith(kind))
    (one,) = over_of(f"a={text}")
    assert np.all(np.isfinite(one.at(np.array([0.0, 1 - 2.0**-53]))))


WRONG = {
    "m=foo(1)": 'over m: "foo(1)" is no list of values and no distribution; known are linspace',
    "m=normal(1,-2)": "sigma = -2 is negative",
    "m=uniform(2,1)": "low = 2 is above high = 1",
    "m=uniform(1)": "high is missing; uniform(low, high)",
    "m=uniform(1,2,3)": "3 is no argument of uniform(low, high)",
    "m=uniform(1,low=3)": "low is given twice",
    "m=linspace(1,2,0)": "count = 0 is no number of values",
    "m=linspace(1,2,2.5)": "count = 2.5 is no number of values",
    "m=geomspace(-1,1,3)": "begin and end on the same side of zero",
    "m=lognormal(0,1)": "median = 0 is not positive",
    "m=normal(0,1,3,2)": "low = 3 is not below high = 2",
    "m=normal(0,1,low=60)": "nothing of it lies between",
    "m=[]": "[] lists nothing",
    "m=[1,inf]": "inf is not a finite number",
    "m=__import__('os')": "over m: ",
    "m=uniform(1,__import__)": '"__import__" uses __import__, which is not known here',
    "m": '"m" names nothing that is varied',
    "=[1]": "names nothing that is varied",
    "zz=[1,2]": "over: zz is not known; known are m, l, g, b, q1, q1_dot",
    "m=tolerance()": "m has no tolerance",
    "q1=tolerance(5 %)": "q1 is no parameter, and a tolerance is of one",
    "m=tolerance(5 mm)": "is in mm",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_no_distribution_is_told(text: str) -> None:
    faults = Faults("")
    read_over(symdyn.example("pendulum"), [text], (), faults)
    assert WRONG[text] in "\n".join(faults.lines)


def test_all_faults_are_told_at_once(capsys: Capture) -> None:
    line = ["sweep", PENDULUM, "--over", "zz=[1]", "--over", "m=normal(1,-1)", "--measure", "q1", "--until", "-1"]
    line += ["--count", "0", "--seed", "-1", "--block", "0", "--forces", "tau9=1", "--start", "q7=1", "--rtol", "7"]
    assert main(line) == 1
    told = capsys.readouterr().err
    for word in ("zz", "sigma", "q1 at no time", "until", "count", "seed", "block", "tau9", "q7", "rtol"):
        assert word in told, word
    assert "Traceback" not in told


SOME = ("a=uniform(0,1)", "b=normal(1,2)", "c=[1,2,3]")


@pytest.mark.parametrize("kind", DESIGNS)
def test_any_stretch_of_a_design_is_that_of_the_whole(kind: str) -> None:
    texts = ("a=linspace(0,1,7)", "b=[1,2,3]", "c=[4,5]") if DESIGNS[kind].lists else SOME
    design = design_of(kind, None if DESIGNS[kind].lists else 40, *texts)
    whole = design.values()
    assert whole.shape == (design.count, 3)
    parts = [design.values(first, first + 11) for first in range(0, design.count, 11)]
    assert np.array_equal(np.concatenate(parts), whole)
    assert np.array_equal(replace(design).values(), whole)


@pytest.mark.parametrize("kind", [kind for kind in DESIGNS if not DESIGNS[kind].lists])
def test_another_seed_gives_other_numbers(kind: str) -> None:
    assert not np.array_equal(design_of(kind, 16, *SOME).values(), design_of(kind, 16, *SOME, seed=4).values())


@pytest.mark.parametrize("kind", [kind for kind in DESIGNS if not DESIGNS[kind].lists])
def test_draws_have_the_mean_and_the_spread_of_their_distribution(kind: str) -> None:
    values = design_of(kind, 2048, "a=uniform(0,1)", "b=normal(1,2)").values()
    np.testing.assert_allclose(values.mean(axis=0), [0.5, 1.0], atol=0.15)
    np.testing.assert_allclose(values.std(axis=0), [12**-0.5, 2.0], rtol=0.06)


def test_a_grid_is_every_value_with_every_other() -> None:
    assert design_of(None, None, "a=[1,2]", "b=[3,4,5]").values().tolist() == [
        [1, 3], [1, 4], [1, 5], [2, 3], [2, 4], [2, 5],
    ]  # fmt: skip


def test_a_latin_hypercube_has_one_draw_in_each_part() -> None:
    values = design_of("latin", 20, "a=uniform(0,20)", "b=uniform(0,20)").values()
    assert all(sorted(np.floor(column)) == list(range(20)) for column in values.T)


MIXED = {
    "lists and distributions": ((None, None, 0), ["lists (c) make a grid, and distributions (a, b) are drawn from"]),
    "a grid of distributions": (("grid", None, 0), ["grid takes lists; a, b is drawn from"]),
    "an unknown design": (("foo", None, 0), ["design: foo is not known; known are grid, random"]),
    "no runs": (("random", 0, 0), ["count: 0 is no number of runs"]),
    "a seed below zero": (("random", 5, -1), ["seed: -1 is no seed"]),
    "a hypercube without bounds": (("latin", 10**9, 0), ["too large; take sobol"]),
}


@pytest.mark.parametrize("case", MIXED)
def test_designs_that_cannot_be_are_told(case: str) -> None:
    (kind, count, seed), words = MIXED[case]
    faults = Faults("")
    assert read_design(over_of(*SOME), kind, count, seed, faults) is None
    assert all(any(word in line for line in faults.lines) for word in words), faults.lines


MEASURES = ("max(abs(q1))", "last=end(q1)", "rms(q1_dot)")


def small(**more: object) -> symdyn.study.Runs:
    over = ["m=normal(1,0.1)", "q1=uniform(0.1,1)"]
    asked = {"until": 0.5, "count": 40, "method": "dop853", "seed": 5, "block": 7, **more}
    return symdyn.sweep(symdyn.example("pendulum"), over, MEASURES, **asked)  # type: ignore[arg-type]


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_run_of_a_sweep_is_a_run_of_simulate() -> None:
    study = small()
    assert study.complete
    assert set(study.codes) == {ENDED}
    for k in (0, 6, 7, 39):
        m, q1 = study.values[k]
        run = symdyn.simulate(
            symdyn.example("pendulum"), until=0.5, start={"q1": q1}, values={"m": m}, method="dop853", rtol=1e-9
        )
        assert study["max(abs(q1))"][k] == pytest.approx(np.abs(run["q1"]).max(), abs=1e-8)
        assert study["last"][k] == pytest.approx(run["q1"][-1], abs=1e-8)
    assert study.units == {"m": "kg", "q1": "rad", "max(abs(q1))": "rad", "last": "rad", "rms(q1_dot)": "rad/s"}


def same(one: symdyn.study.Runs, other: symdyn.study.Runs) -> bool:
    columns = all(np.array_equal(one[name], other[name], equal_nan=True) for name in one)
    return (
        columns and list(one) == list(other) and np.array_equal(one.codes, other.codes) and one.reasons == other.reasons
    )


@pytest.mark.long
@pytest.mark.runs("cc")
def test_blocks_and_threads_change_no_number() -> None:
    one = small()
    assert same(one, small(block=40, workers=2))
    assert same(one, small(block=1, workers=1))


@pytest.mark.long
@pytest.mark.runs("cc")
def test_runs_that_cannot_be_fail_alone_and_are_told() -> None:
    study = symdyn.sweep(symdyn.example("pendulum"), "m=normal(1,1)", "end(q1)", until=0.1, count=60, block=25)
    wrong = study["m"] <= 0
    assert 0 < wrong.sum() == study.failed < 60
    assert np.array_equal(np.isnan(study["end(q1)"]), wrong)
    assert np.array_equal(study.codes == FAILED, wrong)
    assert list(study.reasons) == np.flatnonzero(wrong)[: len(study.reasons)].tolist()
    assert all(words.endswith("it must be positive") for words in study.reasons.values())
    assert np.isfinite(study.mean("end(q1)"))
    assert np.all(np.isfinite(study.quantiles("end(q1)")))


@pytest.mark.long
@pytest.mark.runs("cc")
def test_runs_that_a_limit_stops_keep_what_they_measured(tmp_path: Path) -> None:
    text = (EXAMPLES / "pendulum.toml").read_text()
    (tmp_path / "p.toml").write_text(
        text.replace('child = "bob"', 'child = "bob"\nlimits = { upper = 0.5, lower = -3 }')
    )
    scene = symdyn.read(tmp_path / "p.toml")
    study = symdyn.sweep(scene, "q1_dot=[0.1, 9]", "end(t)", until=1, start={"q1": 0})
    assert study.codes.tolist() == [ENDED, STOPPED]
    assert study["end(t)"][0] == 1 > study["end(t)"][1] > 0
    assert list(study.reasons) == [1]
    assert "limit" in study.reasons[1]


@pytest.mark.long
@pytest.mark.runs("cc")
def test_letters_of_forces_are_varied() -> None:
    study = symdyn.sweep(
        symdyn.example("pendulum"), "k=[1,2]", "start(tau1)", until=0.1, forces=["tau1=-k*q1"], start="q1=0.5"
    )
    np.testing.assert_allclose(study["start(tau1)"], [-0.5, -1.0])


@pytest.mark.runs("cc")
def test_parameters_without_a_value_get_the_varied_ones() -> None:
    study = symdyn.sweep(
        symdyn.example("two_link"), {"m1": [1, 2]}, "end(q1)", until=0.05, values={"m2": 1, "h1": 1, "h2": 1, "g": 9.81}
    )
    assert study.complete
    assert np.all(np.isfinite(study["end(q1)"]))


TOLERANCES = """
name = "p"
[parameters]
m = { value = 2, unit = "kg", tolerance = "5 %" }
l = { value = 0.5, unit = "m", tolerance = "0.1 mm", positive = true }
g = { value = 9.81, tolerance = { sigma = 0.02 } }
[bodies.b]
mass = "m"
com = ["l", 0, 0]
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 1, 0]
force = "g - g"
"""


def test_tolerances_of_a_scene_are_what_is_varied(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text(TOLERANCES)
    scene, faults = symdyn.read(tmp_path / "p.toml"), Faults("")
    m, length, g = read_over(scene, (), (), faults)
    assert [m.name, length.name, g.name] == ["m", "l", "g"]
    np.testing.assert_allclose(m.at(np.array([0, 1])), [1.9, 2.1])
    np.testing.assert_allclose(length.at(np.array([0, 1])), [0.4999, 0.5001])
    np.testing.assert_allclose(g.at(np.array([0.5, stats.norm.cdf(1)])), [9.81, 9.83])
    (wider,) = read_over(scene, ["m=tolerance(10 %)"], (), faults)
    np.testing.assert_allclose(wider.at(np.array([0, 1])), [1.8, 2.2])
    assert not faults.lines
    for text, word in (("l=tolerance(100 %)", "reaches down to 0"), ("q1=tolerance()", "no parameter")):
        read_over(scene, [text], (), faults)
        assert word in faults.lines[-1]
    faults = Faults("")
    read_over(symdyn.example("pendulum"), (), (), faults)
    assert "no parameter of pendulum has a tolerance" in faults.lines[-1]


def interrupting(after: int) -> Callable[[float], None]:
    seen: list[float] = []

    def progress(share: float) -> None:
        seen.append(share)
        if len(seen) == after:
            raise KeyboardInterrupt

    return progress


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_store_that_was_interrupted_is_gone_on_with(tmp_path: Path) -> None:
    whole, said = small(), []
    part = small(output=tmp_path / "a.zarr", progress=interrupting(2), say=said.append)
    assert (part.left, part.complete) == (26, False)
    assert set(part.codes) == {NOT_MADE, ENDED}
    assert "interrupted: 14 of 40 runs are there; the same command goes on with the rest" in said
    assert np.isnan(part["last"][14:]).all()

    said.clear()
    rest = small(output=tmp_path / "a.zarr", block=20, say=said.append)
    assert any("2 of 6 blocks are there already" in line for line in said)
    assert any("goes on with them" in line for line in said)
    assert same(rest, whole)
    assert same(symdyn.study.open(tmp_path / "a.zarr"), whole)

    (tmp_path / "a.zarr" / "codes" / "c" / "3").write_bytes(b"spoilt")
    assert same(small(output=tmp_path / "a.zarr"), whole)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_store_says_what_is_in_it(tmp_path: Path) -> None:
    import zarr

    study = small(output=tmp_path / "a.zarr", count=8)
    group = zarr.open_group(str(tmp_path / "a.zarr"), mode="r")
    about = dict(group.attrs)
    assert about["format"] == "symdyn.study"
    assert about["units"] == dict(study.units)
    assert about["names"] == ["m", "q1"]
    assert about["job"]["scene_sha256"] == study.about["scene_sha256"]
    assert about["job"]["seed"] == 5
    (tmp_path / "again.toml").write_text(about["scene_toml"])
    assert symdyn.read(tmp_path / "again.toml") == symdyn.example("pendulum")
    assert np.array_equal(group["values"][:], study.values)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_store_of_other_numbers_is_refused_and_stays(tmp_path: Path) -> None:
    study = small(output=tmp_path / "a.zarr", count=8)
    for other, words in (
        ({"seed": 6}, "seed is 5 there, 6 here"),
        ({"until": 0.6}, "asked until is 0.5 there, 0.6 here"),
        ({"rtol": 1e-6}, "asked rtol is not given there, 1e-06 here"),
        ({"values": {"l": 2}}, "scene_sha256 is"),
    ):
        with pytest.raises(StudyError, match=words):
            small(output=tmp_path / "a.zarr", **{"count": 8, **other})
    assert same(symdyn.study.open(tmp_path / "a.zarr"), study)


def test_what_is_no_store_is_refused_and_stays(tmp_path: Path) -> None:
    (tmp_path / "file.zarr").write_text("mine")
    (tmp_path / "folder.zarr").mkdir()
    (tmp_path / "folder.zarr" / "mine").write_text("mine")
    for name in ("file.zarr", "folder.zarr"):
        with pytest.raises(SimulateError, match="is no sweep of symdyn"):
            small(output=tmp_path / name)
    assert (tmp_path / "file.zarr").read_text() == (tmp_path / "folder.zarr" / "mine").read_text() == "mine"
    with pytest.raises(SimulateError, match="there is no folder"):
        small(output=tmp_path / "no" / "a.zarr")
    with pytest.raises(SimulateError, match=r"is no \.zarr store"):
        small(output=tmp_path / "a.parquet")
    with pytest.raises(StudyError, match="there is no such store"):
        symdyn.study.open(tmp_path / "a.zarr")


def line_of(folder: Path, *more: str) -> list[str]:
    return [
        "sweep", PENDULUM, "--over", "q1=uniform(0.1,1)", "--count", "2000", "--block", "50", "--until", "0.5",
        "--measure", "max(abs(q1))", "--method", "dop853", "-o", str(folder / "a.zarr"), *more,
    ]  # fmt: skip


HEARING = """
import signal, sys, time
from symdyn.cli import main, sweep
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it, and so would children
class Bar(sweep.Bar):
    blocks = 0
    def __call__(self, share):
        super().__call__(share)
        Bar.blocks += 1
        if Bar.blocks == 3:
            print("three blocks", flush=True)
            while signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # until one is heard
                time.sleep(0.01)
sweep.Bar = Bar
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.wide("9")
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=str)
def test_a_sweep_that_is_stopped_loses_no_block_and_makes_none_twice(
    how: signal.Signals, tmp_path: Path, capsys: Capture
) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", HEARING, *line_of(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    marks = tmp_path / "a.zarr" / "codes" / "c"
    assert process.stdout is not None
    assert process.stdout.readline() == "three blocks\n"
    process.send_signal(how)
    _, err = process.communicate(timeout=HANG)
    assert "Traceback" not in err
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert "the same command goes on with the rest" in err
    part = symdyn.study.open(tmp_path / "a.zarr")
    assert 0 < part.left < 2000
    assert part.left % 50 == 0
    made = {one.name: one.stat().st_mtime_ns for one in marks.iterdir() if ".partial" not in one.name}

    assert main([*line_of(tmp_path), "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["left"] == 0
    assert all((marks / name).stat().st_mtime_ns == when for name, when in made.items())
    whole = symdyn.sweep(
        symdyn.example("pendulum"), "q1=uniform(0.1,1)", "max(abs(q1))", until=0.5, count=2000, method="dop853"
    )
    assert same(symdyn.study.open(tmp_path / "a.zarr"), whole)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_notes_on_runs_that_are_alike_are_told_once() -> None:
    said: list[str] = []
    study = symdyn.sweep(
        symdyn.example("four_bar"), "a=uniform(0.9,1.1)", "end(t)", until=0.01, count=5, say=said.append, block=2
    )
    assert study.complete
    assert sum("so that the loops close" in line for line in said) == 1
    assert len(said) == len(set(said))


@pytest.mark.runs("cc")
def test_a_sweep_of_which_nothing_comes_fails(capsys: Capture) -> None:
    line = ["sweep", PENDULUM, "--over", "m=[-1,0]", "--measure", "max(q1)", "--until", "0.1"]
    assert main(line) == 1
    assert "no run has measures; run 0: m = -1; it must be positive" in capsys.readouterr().err
    assert main([*line, "--workers", "0"]) == 1
    assert "workers: 0 is none; give 1 or more" in capsys.readouterr().err


def test_a_sequence_that_is_not_even_is_told() -> None:
    said: list[str] = []
    symdyn.sweep(
        symdyn.example("pendulum"), "m=uniform(-2,-1)", "max(q1)", until=0.1, design="sobol", count=5, say=said.append
    )
    assert said == ["5 is no power of two, of which Sobol's sequence is most even; 8 is"]


@pytest.mark.runs("cc")
def test_groups_are_counted_and_a_part_of_a_value_is_named() -> None:
    pendulum = symdyn.example("pendulum")
    runs = symdyn.sweep(pendulum, "m=uniform(1,2)", "max(q1)", until=0.1, design="saltelli", count=5)
    assert len(runs) == 24
    assert runs.notes[0] == "8 groups, a power of two, of names + 2 runs each"
    told = r'no distribution; write "tolerance\(5 %\)" or "normal\(m, 5 /100\*m\)"'
    with pytest.raises(SimulateError, match=told):
        symdyn.sweep(pendulum, {"m": "5 %"}, "max(q1)", until=0.1)
    with pytest.raises(SimulateError, match=told):
        symdyn.uncertainty(pendulum, {"m": "5 %"}, until=0.1)
    bars = symdyn.uncertainty(pendulum, {"m": "normal(m, 5 /100*m)"}, until=0.1, values={"m": 2}, start={"q1": 1})
    other = symdyn.uncertainty(pendulum, {"m": 0.1}, until=0.1, values={"m": 2}, start={"q1": 1})
    assert bars["sd_q1"][-1] == pytest.approx(other["sd_q1"][-1], rel=1e-4)


FULL = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from symdyn.cli import main
assert main([*sys.argv[1:-2], "--quiet"]) == 0  # is compiled
resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000))
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.skipif(os.name == "nt", reason="limits of files")
def test_a_disk_that_takes_no_more_is_told(tmp_path: Path) -> None:
    changed = {"2000": "1500", "50": "1500", "0.5": "0.05"}
    line = [changed.get(word, word) for word in line_of(tmp_path)]
    found = subprocess.run(
        [sys.executable, "-c", FULL, *line], check=False, capture_output=True, text=True, timeout=HANG
    )
    assert found.returncode == 1
    assert "cannot write there" in found.stderr
    assert "Traceback" not in found.stderr
    assert symdyn.study.open(tmp_path / "a.zarr").left == 1500


@pytest.mark.runs("cc")
def test_a_table_is_written_and_read_back(tmp_path: Path, capsys: Capture) -> None:
    line = ["sweep", PENDULUM, "--over", "m=[-1,1]", "--over", "q1=[0.2,0.4]", "--until", "0.05"]
    assert main([*line, "--measure", "max(abs(q1))", "-o", str(tmp_path / "a.csv")]) == 0
    out, err = capsys.readouterr()
    assert "2 of 4 runs failed" in err
    assert "run 0 (m = -1, q1 = 0.2): m = -1; it must be positive" in err
    assert (tmp_path / "a.csv").read_text() == (
        "m,q1,max(abs(q1)),ended\n-1.0,0.2,nan,failed\n-1.0,0.4,nan,failed\n1.0,0.2,0.2,end\n1.0,0.4,0.4,end\n"
    )
    assert "pendulum: 4 runs over m, q1 (grid)" in out
    assert main([*line, "--measure", "max(q1)", "-o", str(tmp_path / "a.xyz")]) == 1
    assert "sweeps are kept in .zarr stores, or written as .csv tables" in capsys.readouterr().err


@pytest.mark.runs("cc")
def test_a_study_is_a_table_with_units() -> None:
    pandas = pytest.importorskip("pandas")
    study = symdyn.sweep(symdyn.example("pendulum"), {"q1": np.array([0.1, 0.2])}, "a=max(q1)", until=0.05)
    frame = study.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame) == ["q1", "a", "ended"]
    assert frame.attrs["units"] == {"q1": "rad", "a": "rad"}
    assert list(frame["ended"]) == ["end", "end"]
    assert repr(study) == "<Runs of pendulum: 2 runs over q1; a>"
    with pytest.raises(UnknownNameError, match="there is no column b"):
        study["b"]
