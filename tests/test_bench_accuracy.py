"""Run time against error: the yardsticks themselves, and the report that a user gets."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from arms import puma560, spatial_arm

from symdyn.algebra.big import BigFloats
from symdyn.bench import Measured, bench
from symdyn.bench.implementations import implementations
from symdyn.bench.reference import REGIONS, Positions, Solve, draw, linear, near_singular, positions_of, reference
from symdyn.bench.report import Dot, Series, log_log
from symdyn.bench.time_and_error import marked
from symdyn.cli import main
from symdyn.graph import evaluate
from symdyn.program import formulate, lower
from symdyn.program.tunable import quaternion_places
from symdyn.scene import body, prismatic, read, scene

EXAMPLES = Path(__file__).parent.parent / "examples"
ARM = Positions(("rad",) * 6, np.empty((0, 6)))


@pytest.fixture(scope="module")
def routine():
    return lower(formulate(puma560(), ("inverse_dynamics",))).routines[0]


def test_the_reference_is_the_graph_at_fifty_digits(routine):
    states = draw(routine.function.arguments, ARM, "large angles", 3, 1, "double")
    known, big = reference(routine.function, states, 3), BigFloats(60)

    for k in range(3):
        values = {}
        for argument in routine.function.arguments:
            numbers = map(big.number, states[argument.name][k].tolist())
            values |= zip(argument.symbols, numbers, strict=True)
        exact = evaluate(routine.function.entries, big, values)
        for place, value in enumerate(exact):
            rest = value - big.number(known.high[k, place]) - big.number(known.low[k, place])
            assert abs(rest) <= abs(value) * 2.0**-104
            assert known.bound[k, place] > 0


def test_an_error_of_one_ulp_is_measured_as_such(routine):
    states = draw(routine.function.arguments, ARM, "range", 4, 1, "double")
    known = reference(routine.function, states, 4)
    off = known.high.copy()
    off[2, 1] = np.nextafter(off[2, 1], np.inf)

    gap = known.errors(off)

    assert gap[2, 1] == pytest.approx(np.spacing(known.high[2, 1]) - known.low[2, 1], rel=1e-9)
    assert np.all(gap[[0, 1, 3]] <= np.spacing(np.abs(known.high[[0, 1, 3]])) / 2)
    off[1, 1] = np.nan
    assert known.errors(off)[1, 1] == np.inf


@pytest.mark.wide(2)
@pytest.mark.runs
@pytest.mark.parametrize("real", ["double", "float"])
def test_every_implementation_computes_the_same_function(real):
    """With a scalar parameter block, so that what all states share is shared in every layout."""
    equations = formulate(spatial_arm(), ("mass_matrix",))
    made = [one for one in implementations(equations, 0.0, ("native",), ("double", "float")) if one.real == real]
    function = made[0].routine.function
    positions = Positions(("rad", "rad", "m"), np.empty((0, 3)))
    states = draw(function.arguments, positions, "range", 5, 1, real)
    known = reference(function, states, 5)

    assert {one.variant for one in made} == {
        "NumPy module, one state",
        "NumPy module, many states",
        "C scalar",
        "C batch",
        "C rows",
        "C scalar, plain file",
        "ufunc, one state",
        "ufunc, many states",
    } | ({f"C {way} to 1e-10" for way in ("scalar", "batch", "rows")} if real == "double" else set())
    for one in made:
        gap = known.errors(one.results(states))
        assert gap.shape == (5, 9)
        unit = 1e-12 if one.accuracy else {"double": 2.0**-53, "float": 2.0**-24}[real]
        assert gap.max() <= 40 * unit * np.abs(known.high).max(), one.variant


def test_regions_are_where_they_say():
    angles, _ = (lower(formulate(puma560(), ("gravity_forces",))).routines[0].function.arguments, None)
    drawn = {region: np.abs(draw(angles, ARM, region, 50, 1, "double")["q"]) for region in REGIONS}

    assert drawn["near zero"].max() <= 0.1
    assert drawn["near zero"].min() < 1e-6
    assert drawn["range"].max() <= np.pi
    assert 1e3 <= drawn["large angles"].min() <= drawn["large angles"].max() <= 1e6
    floats = draw(angles, ARM, "range", 5, 1, "float")["q"]
    assert np.array_equal(floats, floats.astype(np.float32))


def test_quaternions_have_unit_length():
    units = ("m", "m", "m", "1", "1", "1", "1", "rad")
    positions = Positions(units, np.empty((0, 8)))

    assert quaternion_places(units) == [3]
    for region in REGIONS:
        q = positions.draw(region, 20, np.random.default_rng(1))
        assert np.linalg.norm(q[:, 3:7], axis=1) == pytest.approx(np.ones(20))


def test_singular_positions_are_found():
    def stretched(q):  # singular where q2 is a multiple of pi, as the Jacobian of a planar arm
        return np.stack([np.stack([np.ones(len(q)), 0 * q[:, 0]], 1), np.stack([q[:, 0] * 0, np.sin(q[:, 1])], 1)], 1)

    q = near_singular(Positions(("rad", "rad"), np.empty((0, 2))), [stretched], seed=1)

    assert np.abs(np.sin(q[:, 1])).max() < 0.05
    assert np.abs(np.sin(q[0, 1])) < 1e-4


def one(call: float, relative: float) -> Measured:
    return Measured("f", "C", "double", "native", "rnea", {}, 0.0, None, call, relative, ())


def test_best_is_what_nothing_beats_in_both():
    assert [m.best for m in marked([one(1, 1e-8), one(2, 1e-15), one(3, 1e-15), one(4, 1e-16)])] == [
        True,
        True,
        False,
        True,
    ]
    assert not marked([one(1, float("inf"))])[0].best
    assert not marked([one(2, 1e-15), replace(one(3, 0.9e-15))])[1].best  # as accurate, and slower


def test_a_plot_is_well_formed_and_holds_every_finite_point():
    dots = (Dot(1.0, 1e-16, "a < b & c", marked=True), Dot(10.0, 0.0, "exact"), Dot(1.0, float("inf"), "lost"))
    text = log_log("t & u", "ns", "error", [Series("one", dots), Series("two", dots[:1], joined=True)])
    assert "var(" not in text, "programs that are no browsers know no variables, and paint black"

    root = ET.fromstring(text)
    titles = [node.text for node in root.iter() if node.tag.endswith("title")]
    assert titles.count("a < b & c") == 2
    assert "exact" in titles
    assert "lost" not in titles


def allowed(way: str, roundoffs: float) -> float:
    """Return how large a backward error may be, in units of the roundoff."""
    return 1e-10 * 2.0**53 if way.endswith("to 1e-10") else roundoffs


@pytest.mark.slow
@pytest.mark.runs
def test_the_command_writes_a_page_that_needs_nothing_else(tmp_path, capsys):
    words = ["bench", str(EXAMPLES / "double_pendulum.toml"), "--quick", "--functions", "forward_dynamics"]

    assert main([*words, "-o", str(tmp_path)]) == 0
    assert "C batch" in capsys.readouterr().out
    facts = json.loads((tmp_path / "bench.json").read_text("utf-8"))
    ways = {(m["variant"], m["real"], m["formulation"]) for m in facts["measured"]}
    assert ("C rows", "float", facts["measured"][0]["formulation"]) in ways
    assert any(way == "C batch to 1e-10" for way, _, _ in ways)
    assert len({m["formulation"] for m in facts["measured"]}) > 1
    for m in facts["measured"]:
        assert m["call"] > 0
        assert m["operations"]["multiplications"] > 0
        assert {e["region"] for e in m["errors"]} == set(REGIONS)
        assert all(e["condition"][2] < 2 for e in m["errors"]), m["variant"]
        assert all(e["backward"][2] < allowed(m["variant"], 40) for e in m["errors"]), m["variant"]
    page = (tmp_path / "bench.html").read_text("utf-8")
    assert "symdyn bench double_pendulum.toml --functions forward_dynamics --quick" in page
    assert page.count("<svg") == 3  # the function, the end of the motion, its energy
    assert "src=" not in page
    assert "href=" not in page
    HTMLParser().feed(page)
    text = (tmp_path / "bench.md").read_text("utf-8")
    assert "| C batch" in text
    assert "In the region *singular*" in text
    motion = facts["motion"]
    assert motion["uncertain"] < 1e-14
    assert {curve["method"] for curve in motion["precision"]} >= {"dop853", "lsoda"}
    for curves in (motion["precision"], motion["drift"]):
        assert any(point["best"] for curve in curves for point in curve["points"])


@pytest.mark.slow
@pytest.mark.wide(4)
@pytest.mark.runs
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "rssr", "heavy_top"])
def test_closed_mechanisms_and_quaternions_have_states_of_their_own_and_backward_errors(name):
    scene = read(EXAMPLES / f"{name}.toml")
    found = bench(scene, ["forward_dynamics"], quick=True, trajectories=False)
    positions = positions_of(scene)

    for region in ("range", "large angles"):
        q = positions.draw(region, 5, np.random.default_rng(1))
        if positions.loops is not None:
            off = [np.abs(positions.loops.numbers.residual(row)).max() for row in q]
            assert max(off) <= 1e-12 * max(1, np.abs(q).max())
    recursive = [one for one in found.measured if one.formulation == "crba"]
    assert recursive
    for one in recursive:
        assert one.errors
        assert all(e.backward[2] < allowed(one.variant, 20) for e in one.errors), one.label


@pytest.mark.runs
def test_the_backward_error_of_a_closed_mechanism_sees_wrong_accelerations_and_open_loops():
    scene = read(EXAMPLES / "four_bar.toml")
    (routine,) = lower(formulate(scene, ("forward_dynamics",))).routines
    states = draw(routine.function.arguments, positions_of(scene), "range", 4, 1, "double")
    known = reference(routine.function, states, 4)
    solve = Solve.at(linear(scene, "forward_dynamics"), states, 4)

    def backward(qdd):
        return max(solve.backward(qdd, states["tau"], known.kept, 2.0**-53))

    assert backward(known.high) < 2
    for k in range(3):
        off = known.high.copy()
        off[1, k] *= 1 + 1e-10
        assert backward(off) > 1e4


@pytest.mark.long
def test_without_a_compiler_the_rest_is_measured(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)

    functions = "mass_matrix,gravity_forces,forward_dynamics_derivatives"
    assert main(["bench", str(EXAMPLES / "pendulum.toml"), "--quick", "--functions", functions]) == 0
    out = capsys.readouterr().out
    assert "C and ufunc were not measured" in out
    assert "forward_dynamics_derivatives" in out
    assert "error 99 %" in out
    assert "NumPy module" in out


def test_unknown_functions_are_told_together_and_none_is_no_list(capsys):
    scene = str(EXAMPLES / "pendulum.toml")

    assert main(["bench", scene, "--functions", "foo,inverse_dynamics,bar"]) == 1
    told = capsys.readouterr().err
    assert "there is no output 'foo'" in told
    assert "there is no output 'bar'" in told
    assert main(["bench", scene, "--functions", ","]) == 1
    assert "pendulum: no function is asked for" in capsys.readouterr().err


@pytest.mark.mends("2.bench")
def test_a_measurement_that_takes_minutes_says_so_and_what_is_shorter(monkeypatch, capsys):
    class BegunError(Exception):
        pass

    def begins(*_):
        raise BegunError

    monkeypatch.setattr("symdyn.cli.bench.bench", begins)
    with pytest.raises(BegunError):
        main(["bench", str(EXAMPLES / "double_pendulum.toml")])
    assert "a minute or more" in capsys.readouterr().err
    with pytest.raises(BegunError):
        main(["bench", str(EXAMPLES / "double_pendulum.toml"), "--quick"])
    assert not capsys.readouterr().err


@pytest.mark.long
@pytest.mark.runs
def test_double_doubles_stand_on_the_same_curve():
    equations = formulate(spatial_arm(), ("mass_matrix",))
    made = [one for one in implementations(equations, 0.0, ("native",), ("double", "float")) if one.real == "dd"]
    function = made[0].routine.function
    states = draw(function.arguments, Positions(("rad", "rad", "m"), np.empty((0, 3))), "range", 5, 1, "dd")
    known = reference(function, states, 5)

    assert [one.variant for one in made] == ["C batch", "C rows"]
    for one in made:
        results = one.results(states)
        assert results.shape == (5, 9, 2)
        assert 0 < known.errors(results).max() < 1e-29 * np.abs(known.high).max()
        results[3, 4, 1] += 1e-25
        assert known.errors(results)[3, 4] == pytest.approx(1e-25, rel=1e-3)


@pytest.mark.slow
@pytest.mark.runs
def test_what_double_doubles_have_no_function_for_is_measured_without_them():
    rail = prismatic("rail", "ground", "cart", axis=[1, 0, 0], force="2*tanh(u)")
    cart = scene("cart", gravity=[0, 0, 0], inputs={"u": 0}, bodies=[body("cart", mass=10)], joints=[rail])
    equations = formulate(cart, ("inverse_dynamics",))
    assert all(one.real != "dd" for one in implementations(equations, 0.0, ("native",), ("double", "float")))


@pytest.mark.runs
@pytest.mark.mends("30.class.verdicts")
def test_what_is_real_at_no_state_has_no_error_and_is_no_best_choice(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)
    slide = prismatic("slide", parent="ground", child="bob", axis=(1, 0, 0), force="2*log(-1 - 3*q1**2)")
    found = bench(
        scene("nowhere", bodies=[body("bob", mass=1)], joints=[slide]),
        ["inverse_dynamics"],
        quick=True,
        trajectories=False,
    )

    assert found.measured
    assert not any(one.best for one in found.measured)
    assert "inverse_dynamics: it is real at none of the states, so its error is not shown" in found.notes
