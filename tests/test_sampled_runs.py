"""Runs under controllers: rows at all samples, stairs in plots, saturation, and the same told at every door."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sliding_block import BLOCK, TEXT

from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.scene import read, read_text
from symdyn.simulation import METHODS, Feedback, Trajectory, simulate
from symdyn.simulation.integrate import importable
from symdyn.simulation.panels import draw, plot

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
CART = read(EXAMPLES / "cart_pole.toml")
LAW = lambda t, q, u: -30 * q[0] - 8 * u[0]  # noqa: E731


def alternating() -> Callable[..., float]:
    """A controller whose force is 1, -1, 1, ... from sample to sample."""
    calls: list[float] = []

    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        calls.append(t)
        return 1.0 if len(calls) % 2 else -1.0

    return law


# Rows


@pytest.mark.mends("30.control.2")
@pytest.mark.parametrize("delay", [0.0, 0.025, 0.01])
def test_every_sample_has_a_row(delay: float) -> None:
    run = simulate(CART, until=10, feedback=Feedback(alternating(), ("F",), period=0.025, delay=delay))
    samples = np.arange(401) * 0.025

    assert np.abs(run.t[:, None] - samples).min(axis=0).max() < 1e-12
    changes = np.count_nonzero(np.diff(run["F"]))
    assert changes == 400 - (1 if delay == 0 else 0) - (1 if delay == 0.025 else 0)
    acting = run.t >= delay
    wanted = np.where(np.floor((run.t[acting] - delay + 1e-9) / 0.025).astype(int) % 2 == 0, 1.0, -1.0)
    assert np.array_equal(run["F"][acting][:-1], wanted[:-1])  # the sample at the end acts no more


@pytest.mark.parametrize("period", [0.3, 1.0, 7.0])
def test_a_slow_sample_has_as_many_rows_as_other_runs(period: float) -> None:
    run = simulate(BLOCK, until=3.0, feedback=Feedback(lambda t, q, u: 1.0, period=period))

    assert 200 < len(run.t) < 420
    assert run.t[-1] == 3.0
    assert np.diff(run.t).max() < 3.0 / 199
    assert np.diff(run.t).min() > 1e-9


@pytest.mark.mends("30.control.2")
def test_samples_between_rows_are_told() -> None:
    control = Feedback(lambda t, q, u: -q[0], period=0.025, delay=0.01)
    run = simulate(BLOCK, until=2, every=0.1, feedback=control)
    as_many = simulate(BLOCK, until=2, every=0.025, feedback=control)
    more = simulate(BLOCK, until=2, every=0.02, feedback=control)

    assert len(run.t) == 21
    assert any("60 of 80 lie between rows, up to 3 between two" in note for note in run.notes)
    assert any("every=0.025 shows all" in note for note in run.notes)
    assert not any("between rows" in note for note in (*as_many.notes, *more.notes))


def test_of_very_many_samples_some_have_no_row_and_that_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.simulation.equations.control_loop.MOST", 100)
    run = simulate(BLOCK, until=1.0, feedback=Feedback(lambda t, q, u: t, period=0.004))

    assert np.allclose(np.diff(run.t)[:-1], 0.012)
    assert any("166 of 250 lie between rows, up to 2 between two" in note for note in run.notes)


# Stairs


def corners(svg: bytes) -> np.ndarray:
    """Return the points of the longest curve of a picture, shape (N, 2)."""
    paths = re.findall(rb'<path d="([^"]*)"', svg)
    longest = max(paths, key=len).decode()
    return np.array([float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", longest)]).reshape(-1, 2)


def is_stairs(svg: bytes) -> bool:
    points = corners(svg)
    assert len(points) > 20
    return bool((np.abs(np.diff(points, axis=0)).min(axis=1) < 0.2).all())  # points: matplotlib simplifies paths


@pytest.mark.mends("30.also.stairs")
def test_held_forces_are_drawn_as_stairs_in_every_plot(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="needs matplotlib, the extra plot")
    run = simulate(BLOCK, until=2.0, feedback=Feedback(LAW, period=0.05, limits={"F": 9}))
    plot(run, tmp_path / "run.html", ["F"])

    shown = run.plot("F")._repr_mimebundle_()["image/svg+xml"]
    pictures = {
        "svg": draw(run, "svg", ["F"]),
        "notebook": shown.encode(),
        "page": (tmp_path / "run.html").read_bytes(),
    }
    assert {name: is_stairs(picture) for name, picture in pictures.items()} == dict.fromkeys(pictures, True)
    assert not is_stairs(draw(run, "svg", ["x"]))


@pytest.mark.parametrize(
    ("forces", "held"), [("", ("F",)), ("F=0.5", ("F",)), ("F=-x", ()), ("F=t", ()), (lambda t, q, u: 0.5, ())]
)
def test_what_moves_between_samples_is_not_held(forces: Any, held: tuple[str, ...]) -> None:
    run = simulate(BLOCK, forces=forces or {}, until=0.1, feedback=Feedback(lambda t, q, u: 1.0, period=0.05))

    assert run.held == (*held, "command_F")
    assert simulate(BLOCK, until=0.1, feedback=lambda t, q, u: 1.0).held == ()


def test_inputs_and_outputs_of_held_signals_are_held() -> None:
    scene = read_text(
        TEXT.replace('gravity = "none"\n', 'gravity = "none"\nparameters = { k = 2 }\n')
        + '[inputs]\nw = 0.5\n[outputs]\ntwice = "k*w + 1"\npower = "w*x_dot"\nspeed = "x_dot"\n'
    )
    control = Feedback(lambda t, q, u: 1.0, ("w",), period=0.05)

    assert simulate(scene, until=0.1, feedback=control).held == ("w", "twice", "command_w")
    assert simulate(scene, forces="F=k*w", until=0.1, feedback=control).held == ("F", "w", "twice", "command_w")
    assert simulate(scene, forces="F=k*w - x", until=0.1, feedback=control).held == ("w", "twice", "command_w")


# Saturation


def shares(run: Trajectory) -> dict[float, float]:
    """Return the percentage of the time that notes tell, by limit."""
    told = (re.fullmatch(r"F saturates at its limit (\S+) N for (\S+) % of the time.*", note) for note in run.notes)
    return {float(one[1]): float(one[2]) for one in told if one}


@pytest.mark.mends("30.control.2")
@pytest.mark.parametrize("delay", [0.0, 0.02, 0.13])
def test_sampled_forces_are_cut_from_sample_to_sample(delay: float) -> None:
    period, until, most = 0.05, 1.5, 4.0
    control = Feedback(LAW, period=period, delay=delay, limits={"F": (-3, most)}, initial=[9.0])
    run = simulate(BLOCK, until=until, feedback=control)
    states = simulate(BLOCK, until=until, every=period, feedback=control)
    asked = [9.0, *(LAW(t, q, u) for t, q, u in zip(states.t, states.q, states.qd, strict=True))]
    starts = [0.0, *(states.t + delay)]
    cut: dict[float, float] = {}
    for force, begin, end in zip(asked, starts, [*starts[1:], until], strict=True):
        if not -3 <= force <= most:
            limit = most if force > most else -3.0
            cut[limit] = cut.get(limit, 0.0) + max(0.0, min(end, until) - begin)

    assert shares(run) == {limit: pytest.approx(100 * time / until, rel=2e-3) for limit, time in cut.items()}
    assert set(cut) == {-3.0, 4.0}
    for name, limit in ((one.name, one.limit) for one in run.saturations):
        inside = [(one.begin, one.end) for one in run.saturations if one.limit == limit]
        at = run[name] == limit
        assert all(any(a - 1e-9 <= t < b - 1e-9 for a, b in inside) for t in run.t[:-1][at[:-1]])
    assert all(one.end > one.begin for one in run.saturations)


@pytest.mark.mends("30.control.2")
@pytest.mark.parametrize("method", ["dop853", "radau", "lsoda", "cvode"])
def test_the_time_at_which_a_force_leaves_its_limit_is_that_of_the_motion(method: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip(f"needs {METHODS[method].library}")
    # F = -30 x cut at 6 N, x = 1/2 - t - 6 t²/4: until 30 x = 6, then an oscillation of amplitude more than 1/5
    run = simulate(BLOCK, until=1.7, feedback=Feedback(lambda t, q, u: -30 * q[0], limits={"F": 6.0}), method=method)
    leaves = (-1 + math.sqrt(1 + 4 * 1.5 * 0.3)) / 3
    rate, speed = math.sqrt(15), -1 - 3 * leaves
    size = math.hypot(0.2, speed / rate)
    phase = math.atan2(-speed / rate, 0.2)  # x = size cos(rate (t - leaves) + phase) until x = -1/5
    again = leaves + (math.acos(-0.2 / size) - phase) / rate
    back = again + 2 * (size * rate * math.sin(math.acos(-0.2 / size))) / 3

    parts = {-6.0: leaves / 1.7, 6.0: (back - again) / 1.7}
    assert shares(run) == {limit: pytest.approx(100 * part, rel=5e-3) for limit, part in parts.items()}
    found = [(one.limit, one.begin, one.end) for one in run.saturations]
    assert [one[0] for one in found] == [-6.0, 6.0]
    assert np.allclose([one[1:] for one in found], [(0.0, leaves), (again, back)], atol=2e-6)


def test_a_limit_that_nothing_reaches_is_told_so() -> None:
    for period in (None, 0.05):
        run = simulate(BLOCK, until=1.0, feedback=Feedback(LAW, period=period, limits={"F": 1e3}))

        assert run.saturations == ()
        assert "F never reaches its limits, -1000 to 1000 N" in run.notes


def test_a_force_that_jumps_from_limit_to_limit_is_at_one_of_them() -> None:
    run = simulate(BLOCK, until=1.0, feedback=Feedback(lambda t, q, u: 9.0 if t < 0.4 else -9.0, limits={"F": 2}))

    assert [(one.limit, one.begin) for one in run.saturations] == [(2.0, 0.0), (-2.0, pytest.approx(0.4, abs=1e-9))]
    assert [one.end for one in run.saturations] == [pytest.approx(0.4, abs=1e-9), 1.0]


def test_a_run_that_is_stopped_is_cut_there() -> None:
    for period in (None, 0.1):
        run = simulate(
            BLOCK, until=9.0, stops=["x"], feedback=Feedback(lambda t, q, u: -9.0, period=period, limits={"F": 2})
        )

        assert [(one.begin, one.end) for one in run.saturations] == [(0.0, run.t[-1])]
        assert shares(run) == {-2.0: 100.0}


# A word that is read does something, or is told to have no effect


OPTIONS = [
    pytest.param({"period": 0.1}, id="period"),
    pytest.param({"period": None, "delay": 0.0}, id="no period"),
    pytest.param({"delay": 0.02}, id="delay"),
    pytest.param({"limits": {"F": 3}}, id="limits that cut"),
    pytest.param({"limits": {"F": 300}}, id="limits that do not", marks=pytest.mark.mends("30.class.ignored")),
    pytest.param({"initial": [2.0]}, id="initial"),
]


@pytest.mark.parametrize("more", OPTIONS)
def test_every_option_of_a_controller_changes_what_is_told(more: dict[str, Any]) -> None:
    usual: dict[str, Any] = {"period": 0.05, "delay": 0.05}
    runs = [simulate(BLOCK, until=1.0, every=0.01, feedback=Feedback(LAW, **{**usual, **one})) for one in ({}, more)]

    told = [(run.table()[1].tolist(), run.notes) for run in runs]
    assert told[0] != told[1]


@pytest.mark.mends("30.class.ignored")
def test_a_first_force_that_never_acts_is_told() -> None:
    with pytest.raises(SimulateError, match="initial: is the force before the first sample; give a period too"):
        simulate(BLOCK, until=0.1, feedback=Feedback(LAW, initial=[2.0]))
    sampled = [Feedback(LAW, period=0.05, **one) for one in ({}, {"initial": [2.0]})]
    runs = [simulate(BLOCK, until=0.1, feedback=one) for one in sampled]

    assert np.array_equal(runs[0].q, runs[1].q)
    assert [note for note in runs[1].notes if note not in runs[0].notes] != []


@pytest.mark.mends("30.class.ignored")
def test_a_spacing_of_rows_that_hides_samples_is_told() -> None:
    runs = [simulate(BLOCK, until=1.0, every=every, feedback=Feedback(LAW, period=0.01)) for every in (0.01, 0.1)]

    assert runs[0].notes != runs[1].notes


@pytest.mark.mends("30.class.ignored")
@pytest.mark.parametrize(
    ("method", "more", "words"),
    [
        ("taylor", {"rtol": 1e-10, "atol": 1e-3}, "atol = 0.001 has no effect: taylor has one tolerance, rtol = 1e-10"),
        ("taylor", {"rtol": 1e-16}, "rtol = 1e-16 is finer than what taylor works with; it takes 2.2e-16"),
        ("dop853", {"rtol": 1e-15}, "rtol = 1e-15 is finer than what dop853 works with; it takes 2.2e-14"),
        ("ida", {"rtol": 1e-13}, "rtol = 1e-13 is finer than what ida works with; it takes 1e-11"),
    ],
)
def test_a_tolerance_that_a_method_does_not_take_is_told(method: str, more: dict[str, float], words: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip(f"needs {METHODS[method].library}")
    run = simulate(BLOCK, until=0.1, method=method, **more)

    assert any(words in note for note in run.notes)
    assert run.rtol == max(more["rtol"], METHODS[method].finest)
    assert run.atol == run.rtol


@pytest.mark.parametrize("method", [name for name, one in METHODS.items() if one.step is None])
def test_a_tolerance_changes_the_run_or_is_told_to_have_no_effect(method: str) -> None:
    if not importable(METHODS[method].module):
        pytest.skip(f"needs {METHODS[method].library}")
    options = [{"rtol": 1e-6, "atol": 1e-6}, {"rtol": 1e-6, "atol": 1e-3}, {"rtol": 1e-4, "atol": 1e-6}]
    spring = read_text(TEXT + '[springs.s]\njoint = "slide"\nstiffness = 300\n')
    runs = [simulate(spring, until=1.0, method=method, **more) for more in options]

    told = [(run.q.tolist(), run.notes) for run in runs]
    assert told[0] != told[1]
    assert told[0] != told[2]


# The same events, saturation and notes at every door


@pytest.mark.mends("30.class.doors")
def test_a_run_tells_the_same_at_every_door(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In Python, at the shell as text and JSON, in a notebook, beside a plot on a page, and in a file of arrays."""
    pytest.importorskip("matplotlib", reason="needs matplotlib, the extra plot")
    scene, gains = tmp_path / "block.toml", tmp_path / "gains.json"
    scene.write_text(TEXT.replace("start_rates = -1", "start_rates = -1\nlimits = { velocity = 1.5 }"))
    said: dict[str, Any] = {"K": [[90, 4]], "states": ["x", "x_dot"], "inputs": ["F"], "period": 0.01}
    said["limits"] = {"F": 4.0}
    gains.write_text(json.dumps(said))
    run = simulate(read(scene), until=1.5, every=0.05, feedback=said, reports=["x"])
    words = ["simulate", str(scene), "--until", "1.5", "--every", "0.05", "--feedback", str(gains), "--report", "x"]

    files = ["-o", str(tmp_path / "run.npz"), "--plot", str(tmp_path / "run.html"), "--plot-columns", "F"]
    assert main([*words, "-o", str(tmp_path / "run.csv")]) == 0
    shell = capsys.readouterr().err
    assert main([*words, *files, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    about = json.loads(str(np.load(tmp_path / "run.npz")["about"]))

    assert any("between rows" in note for note in run.notes)
    assert any("velocity limit 1.5 m/s is passed" in note for note in run.notes)
    assert any("F saturates" in note for note in run.notes)
    assert len(run.events) >= 1
    doors = {
        "text": shell,
        "JSON": "\n".join(answer["notes"]),
        "notebook": run._repr_mimebundle_()["text/html"],
        "page": (tmp_path / "run.html").read_text(encoding="utf-8"),
        "arrays": "\n".join(about["notes"]),
    }
    escaped = {name: text.replace("&#x27;", "'").replace("&quot;", '"') for name, text in doors.items()}
    named = [note.replace("every=0.01 shows", "--every 0.01 shows") for note in run.notes]  # as the shell calls it
    missing = [
        (door, note)
        for door, text in escaped.items()
        for note in (run.notes if door == "notebook" else named)
        if note not in text
    ]
    assert not missing
    for told in (answer["result"], about):
        assert [one["t"] for one in told["events"]] == [one.t for one in run.events]
        assert [one["begin"] for one in told["saturations"]] == [one.begin for one in run.saturations]
    for door in ("text", "notebook", "page"):
        assert all(one.words in escaped[door] for one in run.saturations[:20]), door
        assert all(str(one.t)[:5] in escaped[door] for one in run.events), door


def test_chatter_is_listed_in_part_and_counted() -> None:
    from symdyn.simulation.equations.saturation import cut_lines

    run = simulate(BLOCK, until=2, feedback=Feedback(alternating(), ("F",), period=0.025, limits={"F": 0.5}))

    assert len(run.saturations) == 80
    assert cut_lines(run.saturations)[20:] == ["and 60 more, which run.saturations lists"]
    assert shares(run) == {-0.5: 50.0, 0.5: 50.0}
    assert sum("40 times, the first from t = " in note for note in run.notes) == 2


def test_a_run_without_a_controller_has_none_of_it() -> None:
    run = simulate(BLOCK, until=0.1, method="dop853")

    assert (run.held, run.saturations, len(run.t)) == ((), (), 201)
