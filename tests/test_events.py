"""Events of motions that are known in closed form: by every method, as every kind of event, through every door."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from symdyn import ensemble, example, simulate, sweep
from symdyn.cli import main
from symdyn.scene import Scene, read_text
from symdyn.simulation import METHODS
from symdyn.simulation.integrate import importable
from symdyn.simulation.trajectory import Trajectory
from symdyn.study.runs import STOPPED

pytestmark = pytest.mark.runs("cc")

COEFFICIENTS = ("a0", "a1", "a2", "a3", "a4", "kx")
FORCE = "F=(a0-9)+(a1-9)*t+(a2-9)*t**2+(a3-9)*t**3+(a4-9)*t**4+(kx-9)*x"
"""Parameters are given nine more than is meant: zero decides the form of equations, which then are compiled anew."""

BLOCK = """
name = "block"
[parameters]
{parameters}
[bodies.block]
mass = 1
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
{limits}
"""


def block(limits: str = "") -> Scene:
    parameters = "\n".join(f"{name} = 9" for name in (*COEFFICIENTS, "c"))
    return read_text(BLOCK.format(parameters=parameters, limits=f"limits = {limits}" if limits else ""))


@dataclass(frozen=True)
class Flight:
    """x'' = forces, from x0 with v; x passes c at t for the first time, None for never until `until`.

    `limit` is the limit of the joint that does the same, "" where only a formula does.
    """

    x0: float
    v: float
    c: float
    t: float | None
    limit: str = ""
    until: float = 1.0
    forces: dict[str, float] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, float]:
        return {name: 9.0 + self.forces.get(name, 0.0) for name in COEFFICIENTS} | {"c": self.c}


G = {"a0": -9.81}


def fall(height: float, v: float) -> float:
    """Return when a ball that is thrown upwards is for the last time at a height above its start."""
    return (v + math.sqrt(v * v - 2 * 9.81 * height)) / 9.81


FLIGHTS = {
    "a ball from the guard": Flight(2.0, 0.1, 2.0, 0.2 / 9.81, "lower", forces=G),
    "a slow ball from the guard": Flight(2.0, 1e-3, 2.0, 0.002 / 9.81, "lower", forces=G),
    "a ball from a guard at zero": Flight(0.0, 0.1, 0.0, 0.2 / 9.81, forces=G),
    "a ball from a guard that no double is": Flight(math.pi / 6, 0.1, math.pi / 6, 0.2 / 9.81, "lower", forces=G),
    "a ball let go of on the guard": Flight(2.0, 0.0, 2.0, None, "upper", forces=G),
    "a ball thrown down from the guard": Flight(2.0, -0.1, 2.0, None, "upper", forces=G),
    "a ball from below the guard": Flight(1.0, 5.0, 2.0, (5 - math.sqrt(25 - 2 * 9.81)) / 9.81, "upper", forces=G),
    "a ball that clears the guard for a moment": Flight(
        1.0, 4.905, 2.22625 - 1e-6, 0.5 - math.sqrt(2e-6 / 9.81), "upper", forces=G
    ),
    "a ball that clears it not": Flight(1.0, 4.905, 2.22625 + 1e-6, None, "upper", forces=G),
    "from rest, by the third derivative": Flight(2.0, 0.0, 2.0, 1.0, "lower", 1.5, {"a1": 6.0, "a2": -12.0}),
    "from rest, by the fifth derivative": Flight(2.0, 0.0, 2.0, 1.0, "upper", 1.5, {"a3": -20.0, "a4": 30.0}),
    "an oscillator from its rest": Flight(0.0, 1.0, 0.0, math.pi / 2, "", 2.0, {"kx": -4.0}),
    "an oscillator from its turning point": Flight(2.0, 0.0, 2.0, None, "upper", 3.0, {"kx": -4.0}),
    "a motion without a force": Flight(1.0, 1e-3, 1.0001, 0.1, "upper"),
    "one that stands on the guard": Flight(2.0, 0.0, 2.0, None, "upper"),
}

COARSE = {"rk23": 2e-5, "rk45": 1e-7, "bdf": 1e-4, "lsoda": 1e-5, "cvode": 1e-4, "adams": 1e-5, "ida": 1e-5}
"""Errors of times that methods have from their tolerances; all others know these motions to more than 1e-9 s."""

FINE = ("a ball that clears the guard for a moment", "a ball that clears it not", "from rest, by the fifth derivative")
"""What is less than they can tell."""

LOOKING = [name for name, one in METHODS.items() if one.finds_events and importable(one.module)]


def wrong(name: str, flight: Flight, t: float, happened: bool, method: str) -> list[str]:
    """Return what is wrong with the end of a run."""
    known = flight.until if flight.t is None else flight.t
    if happened is (flight.t is not None) and abs(t - known) < COARSE.get(method, 1e-9):
        return []
    return [f"{name}, {method}: {t!r} s, {'an event' if happened else 'none'}, where {flight.t} s is known"]


@pytest.mark.long
@pytest.mark.mends("30.numbers.8")
def test_a_formula_passes_zero_by_every_method_when_the_closed_form_says() -> None:
    scene, found = block(), list[str]()
    for method in LOOKING:
        for name, one in FLIGHTS.items():
            if method in COARSE and name in FINE:
                continue
            begin = {"start": {"x": one.x0}, "start_rates": {"x_dot": one.v}, "values": one.values}
            run = simulate(scene, forces=FORCE, until=one.until, method=method, stops="x - c", say=str, **begin)
            found += wrong(name, one, run.t[-1], bool(run.events), method)
            assert run.t[-1] == (run.events[-1].t if run.events else one.until)
    assert found == []


@pytest.mark.mends("30.numbers.8")
def test_a_ball_from_the_ground_stops_there_without_a_choice_of_method(tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "ball.toml"
    path.write_text(
        'name = "ball"\ngravity = [0, 0, -9.81]\n[bodies.b]\nmass = 1\n[joints.z]\ntype = "prismatic"\n'
        'parent = "ground"\nchild = "b"\naxis = [0, 0, 1]\ncoordinate = "z"\n'
    )
    command = ["simulate", str(path), "--until", "1", "--start", "z=0", "--start-rates", "z_dot=0.1", "--stop", "z"]
    assert main(command) == 0
    last = capsys.readouterr().out.splitlines()[-1].split(",")
    assert float(last[0]) == pytest.approx(0.2 / 9.81, abs=1e-15)


@pytest.mark.long
@pytest.mark.mends("30.numbers.8")
def test_a_limit_is_passed_at_its_own_time_by_every_method() -> None:
    """Not where its slack is left, 1e-9 m further: 1e-6 s later at 1 mm/s."""
    scenes, found = {way: block(f'{{ {way} = "c" }}') for way in ("lower", "upper")}, list[str]()
    for method in LOOKING:
        for name, one in FLIGHTS.items():
            if not one.limit or (method in COARSE and name in FINE):
                continue
            begin = {"start": {"x": one.x0}, "start_rates": {"x_dot": one.v}, "values": one.values}
            run = simulate(scenes[one.limit], forces=FORCE, until=one.until, method=method, say=str, **begin)
            found += wrong(name, one, run.t[-1], bool(run.events), method)
            if run.events and method not in COARSE:
                assert run["x"][-1] == pytest.approx(one.c, abs=1e-12)
                assert np.all(np.diff(run.t) > 0)
    assert found == []


@pytest.mark.mends("30.numbers.8")
def test_a_limit_that_is_left_at_the_start_is_passed_there() -> None:
    begin = {"start": {"x": 2.0}, "start_rates": {"x_dot": 1e-3}, "values": Flight(2.0, 1e-3, 2.0, 0.0).values}
    for method in ("taylor", "dop853"):
        run = simulate(block('{ upper = "c" }'), forces=FORCE, until=1.0, method=method, say=str, **begin)
        assert run.events[-1].t == run.t[-1] == 0.0


@pytest.mark.wide("dop853")
@pytest.mark.long
@pytest.mark.mends("30.numbers.8")
@pytest.mark.parametrize("method", [None, "dop853", "taylor"])
def test_ensembles_end_their_runs_when_the_closed_form_says(method: str | None) -> None:
    found = list[str]()
    for limits, flights in (
        ("", FLIGHTS),
        ('{ lower = "c" }', {name: one for name, one in FLIGHTS.items() if one.limit == "lower"}),
        ('{ upper = "c" }', {name: one for name, one in FLIGHTS.items() if one.limit == "upper"}),
    ):
        for until in sorted({one.until for one in flights.values()}):
            some = {name: one for name, one in flights.items() if one.until == until}
            values = {key: np.array([one.values[key] for one in some.values()]) for key in (*COEFFICIENTS, "c")}
            runs = ensemble(
                block(limits), forces=FORCE, until=until, start={"x": np.array([one.x0 for one in some.values()])},
                start_rates={"x_dot": np.array([one.v for one in some.values()])}, values=values, method=method,
                stops=() if limits else "x - c",
            )  # fmt: skip
            for k, (name, one) in enumerate(some.items()):
                found += wrong(name, one, float(runs.t[k]), bool(runs.codes[k] == STOPPED), method or "chosen")
    assert found == []


@pytest.mark.mends("30.numbers.8")
def test_a_sweep_ends_its_runs_when_the_closed_form_says() -> None:
    flight = FLIGHTS["a ball from the guard"]
    study = sweep(
        block('{ lower = "c" }'), {"x_dot": "linspace(0.001,2,5)"}, "end(x_dot)", until=1.0, forces=FORCE,
        start={"x": 2.0}, values=flight.values,
    )  # fmt: skip
    speeds = np.linspace(0.001, 2, 5)
    assert study["end(x_dot)"] == pytest.approx(-speeds, abs=1e-9)


@pytest.mark.parametrize("method", LOOKING)
def test_every_zero_of_a_formula_in_time_alone_is_reported(method: str) -> None:
    """Steps of eight seconds would look at whole turns alone."""
    run = simulate(
        block(),
        forces=FORCE,
        until=8.0,
        start={"x": 0},
        start_rates={"x_dot": 0},
        method=method,
        reports="sin(2*pi*t) - 0.5",
        say=str,
    )
    known = sorted([k + part for k in range(8) for part in (1 / 12, 5 / 12)])
    assert [event.t for event in run.events] == pytest.approx(known, abs=1e-9)


DISC = """
name = "disc"
gravity = [0, 0, 0]
[bodies.b]
mass = 1
inertia = [0.05, 0.05, 0.011]
inertia_about = "com"
[joints.j]
type = "revolute"
parent = "ground"
child = "b"
axis = [0, 0, 1]
coordinate = "phi"
"""

ROUNDING = "phi**3 - 3*phi**2 + 3*phi - 1 - 1e-18"
"""Near phi = 1 it is rounding alone, of either sign."""


def turning(method: str, until: float, rate: float, phi: float = 0.0, **events: str) -> Trajectory:
    return simulate(
        read_text(DISC),
        forces={},
        until=until,
        start={"phi": phi},
        start_rates={"phi_dot": rate},
        method=method,
        say=str,
        **events,
    )


@pytest.mark.wide(2)
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_thousands_of_zeros_in_one_step_are_all_told(method: str) -> None:
    """Without a force a step of Taylor's method is the whole run."""
    run = turning(method, 100.0, 60.0, reports="cos(phi)")
    known = (np.arange(1910) + 0.5) * math.pi / 60
    assert [event.t for event in run.events] == pytest.approx(known, abs=1e-9)
    run = turning(method, 100.0, 60.0, stops="sin(phi) + t/50 - 2.0001")
    assert run.t[-1] == pytest.approx(50.081302008239, abs=1e-9)


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_zeros_of_third_order_are_all_told(method: str) -> None:
    run = turning(method, 20.0, 6.0, 0.5, reports="sin(phi)**3")
    known = (np.arange(1, 39) * math.pi - 0.5) / 6
    assert run.complete
    assert [event.t for event in run.events] == pytest.approx(known, abs=1e-9)


@pytest.mark.wide(2)
@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_a_search_that_rounding_ends_says_from_when_on(method: str) -> None:
    run = turning(method, 100.0, 1e-9, 1.000001, reports=ROUNDING)
    assert run.complete
    assert [ROUNDING in note and "events of it may be missing" in note for note in run.notes].count(True) == 1


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_an_event_is_told_whose_run_ends_by_what_doubles_hold(method: str) -> None:
    """The steps of such a run are taken twice."""
    values = dict.fromkeys(COEFFICIENTS, 9.0) | {"c": 0.0, "kx": 1e4 + 9}
    run = simulate(
        block(), forces=FORCE, until=20.0, start={"x": 1}, start_rates={"x_dot": 0.5}, method=method,
        values=values, say=str, reports=("x - 1e138", "1e138 - x"),
    )  # fmt: skip
    known = (138 * math.log(10) - math.log((1 + 0.005) / 2)) / 100
    assert [event.t for event in run.events] == pytest.approx([known, known], abs=1e-7)


UNREAL = {
    "from below, past": ("sqrt(x) - 1", Flight(-1.0, 1.0, 0.0, None, until=4.0), [2.0]),
    "from below, late": ("sqrt(x) - 2", Flight(-1.0, 1.0, 0.0, None, until=8.0), [5.0]),
    "from below, never": ("sqrt(x) + 1", Flight(-1.0, 1.0, 0.0, None, until=4.0), []),
    "to and fro": (
        "sqrt(x) - 0.5",
        Flight(0.0, 1.0, 0.0, None, until=10.0, forces={"kx": -1.0}),
        [turn * math.pi + way * math.asin(0.25) for turn, way in ((0, 1), (1, -1), (2, 1), (3, -1))],
    ),
    "ends to be": ("sqrt(1 - x) - 0.5", Flight(0.0, 1.0, 0.0, None, until=4.0), [0.75]),
    "a pole": ("1/(x - 1)", Flight(0.0, 1.0, 0.0, None, until=2.0), []),
    "a pole elsewhere": ("1/(x - 1)", Flight(0.3, 1.1, 0.0, None, until=2.0), []),
    "a zero at a pole": ("(x - 0.7)/(x - 0.9)", Flight(0.0, 1.0, 0.0, None, until=2.0), [0.7]),
}
"""Formulas that are not real for a while, or not finite: what they are, the motion, and when they pass zero."""


@pytest.mark.wide("to and fro", "a pole")
@pytest.mark.long
@pytest.mark.parametrize("name", UNREAL)
def test_a_formula_without_a_real_value_for_a_while_passes_zero_where_it_has_one(name: str) -> None:
    formula, one, known = UNREAL[name]
    for method in LOOKING:
        begin = {"start": {"x": one.x0}, "start_rates": {"x_dot": one.v}, "values": one.values}
        run = simulate(block(), forces=FORCE, until=one.until, method=method, reports=formula, say=str, **begin)
        assert [e.t for e in run.events] == pytest.approx(known, abs=10 * COARSE.get(method, 1e-10)), method
        run = simulate(block(), forces=FORCE, until=one.until, method=method, stops=formula, say=str, **begin)
        assert run.t[-1] == pytest.approx([*known, one.until][0], abs=10 * COARSE.get(method, 1e-10)), method


@pytest.mark.wide("dop853")
@pytest.mark.parametrize("method", [None, "dop853", "taylor"])
def test_ensembles_end_their_runs_where_a_formula_has_a_real_value(method: str | None) -> None:
    for formula, known in (
        ("sqrt(x) - 1", [2.0, 1.5, 3.0]),
        (("sqrt(x) + 1", "1/(x - 1)"), [4.0] * 3),
        ("cos(20*pi*t) + t/2 - 2.0001", [2.09507807413] * 3),
    ):
        values = {name: np.full(3, 9.0) for name in COEFFICIENTS}
        runs = ensemble(
            block(), forces=FORCE, until=4.0, start={"x": np.array([-1.0, -0.5, -2.0])}, values=values,
            start_rates={"x_dot": np.ones(3)}, method=method, stops=formula,
        )  # fmt: skip
        assert runs.t == pytest.approx(np.array(known), abs=1e-7), formula


@pytest.mark.mends("30.also.runs")
@pytest.mark.parametrize("method", ["dop853", "rk45", "radau", "bdf", "lsoda", "taylor"])
def test_what_loops_keep_at_zero_passes_it_nowhere(method: str) -> None:
    """The rod's end stays on the line that the piston slides on, to the limit that loops are kept to."""
    kept = ["r*sin(phi) + l*sin(phi + psi)", "phi_dot*r*cos(phi) + (phi_dot + psi_dot)*l*cos(phi + psi)"]
    run = simulate(example("slider_crank"), until=0.5, start={"phi": "0.5"}, method=method, reports=kept)
    assert run.events == ()


@pytest.mark.parametrize("method", ["dop853", "taylor", "bdf"])
def test_a_loop_that_starts_at_a_zero_passes_it_when_it_comes_back(method: str) -> None:
    """With next to no load the crank swings about its lowest place and is back at half a period."""
    rest = {"start": {"phi": "-1.5"}, "start_rates": {"phi_dot": "1"}, "values": {"k": "1e-9"}}
    run = simulate(example("slider_crank"), until=3, method=method, stops="phi + 1.5", **rest)
    assert run.stopped == "phi + 1.5"
    assert run.t[-1] > 0.1
