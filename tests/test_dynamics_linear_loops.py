"""Loops whose coordinates stay in proportion: parallelograms, which then pass their change points."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from oracles import oracle

import symdyn
from symdyn.algebra.numeric import Floats
from symdyn.bench.stress.scenes import parallelogram
from symdyn.dynamics import Workspace, derive_one
from symdyn.dynamics.outputs.written_decisions import linear_loops
from symdyn.graph import evaluate, substitute
from symdyn.scene import Scene, read_text
from symdyn.scene.scene_files import Starter
from symdyn.simulation import simulate
from symdyn.simulation.equations.system import Projection
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start

pytestmark = pytest.mark.runs()


def row_of(n: int) -> Scene:
    return read_text(Starter("row").from_template("n_four_bar", n))


def test_a_parallelogram_holds_its_coordinates_in_proportion():
    w = Workspace(row_of(2))
    loops = linear_loops(w.loops.numbers, w.loops.decisions)

    assert loops is not None
    assert len(loops.independent) == 1
    assert {abs(x) for row in loops.T.values() for x in row.values()} == {Fraction(1)}


@pytest.mark.parametrize("template", ["four_bar", "slider_crank"])
def test_other_loops_do_not(template):
    closed = Workspace(read_text(Starter("one").from_template(template))).loops

    assert linear_loops(closed.numbers, closed.decisions) is None


def test_away_from_change_points_it_is_the_forward_dynamics_of_everybody():
    w = Workspace(row_of(2))
    loops = linear_loops(w.loops.numbers, w.loops.decisions)
    assert loops is not None
    (free,) = loops.independent
    values = {w.state.q[free]: 0.7, w.state.qd[free]: -1.3} | dict.fromkeys(w.state.tau, 0.4)
    own = {name: w.graph.symbol(name) for name in ("m", "l", "g")}
    values |= {own["m"]: 1.0, own["l"]: 1.0, own["g"]: 9.81}
    known = loops.followers(w)
    usual = substitute(derive_one(w, "forward_dynamics").entries, known)

    found = evaluate(substitute(loops.forward_dynamics(w), known), Floats(), values)

    assert found == pytest.approx(evaluate(usual, Floats(), values), rel=1e-12)


def test_two_four_bars_in_a_row_pass_their_change_point():
    case = oracle("iftomm_closed_form")["A02_N2"]
    until = {row["t"]: row for row in case["rows"]}["10"]

    made = simulate(row_of(2), until=10.0)

    assert made.stopped == "end"
    assert made.q[-1, 0] == pytest.approx(float(until["theta"]), rel=1e-9)
    assert made.qd[-1, 0] == pytest.approx(float(until["thetad"]), rel=1e-9)
    assert made.monitors["loops"] < 1e-12
    assert np.abs(made["loop_rate_error"]).max() < 1e-12


@pytest.mark.slow
def test_forty_four_bars_in_a_row_take_few_steps_for_twenty_seconds():
    case = oracle("iftomm_closed_form")["A02_N40"]

    made = simulate(row_of(40), until=20.0)

    assert made.q[-1, 0] == pytest.approx(float(case["rows"][-1]["theta"]), rel=1e-9)
    assert made.steps < 400


def test_what_is_compiled_for_a_row_grows_as_its_length():
    """Rows in proportion need no G, whose entries grow as the square."""
    short, long = (state_equations(row_of(n)).program.routines for n in (5, 10))
    sizes = [sum(len(one.function.entries) + len(one.steps) for one in routines) for routines in (short, long)]

    assert sizes[1] < 2.1 * sizes[0]
    assert "slopes" not in [one.function.name for one in long]


@pytest.mark.parametrize("template", ["four_bar", "slider_crank"])
def test_the_rows_of_a_system_are_those_of_the_scene(template):
    """G is put together of its entries that are not zero."""
    scene = read_text(Starter("one").from_template(template))
    system, G = state_equations(scene), symdyn.load(scene, "constraint_jacobian").constraint_jacobian
    start = read_start(scene)
    x = np.concatenate([start.q, start.u + 0.3, np.zeros(int(system.works))])

    assert system.jacobian(0.0, x) == pytest.approx(G(start.q))
    assert system.jacobian(0.0, np.stack([x, x]))[1] == pytest.approx(G(start.q))
    assert system.evaluate("row_rates", 0.0, x) == pytest.approx(G(start.q) @ x[system.nq :][: system.nv])


def test_a_state_of_loops_in_proportion_is_moved_onto_them_and_its_work_stays():
    """Residuals and rows by the scene's own functions; the free coordinate, its rate and what follows are kept."""
    scene = row_of(2)
    system = state_equations(scene)
    called = symdyn.load(scene, ["constraint_residual", "constraint_jacobian"])
    (free,) = system.decisions.partition.independent
    start = read_start(scene)
    drift = 1e-3 * np.sin(np.arange(1, len(start.q) + 1))
    x = np.concatenate([start.q + drift, start.u + drift, [17.0, -3.0]])

    moved = Projection(system, 1e-9).projected(x)

    nq, nv = len(start.q), len(start.u)
    assert system.linear
    assert len(moved) == len(x)
    assert moved[nq + nv :].tolist() == [17.0, -3.0]
    assert np.abs(called.constraint_residual(moved[:nq])).max() < 1e-14
    assert np.abs(called.constraint_jacobian(moved[:nq]) @ moved[nq : nq + nv]).max() < 1e-14
    assert moved[free] == x[free]
    assert moved[nq + free] == x[nq + free]
    assert np.abs(called.constraint_residual(x[:nq])).max() > 1e-4


def test_a_redundant_coupler_changes_nothing_of_that():
    made = simulate(parallelogram(second=True), until=5.0)

    assert made.stopped == "end"
    assert made.monitors["energy"] < 1e-9 * made.monitors["energy_scale"]
