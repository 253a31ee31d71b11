"""State equations whose named parameters are free: other values, decisions that these spoil, other processes."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from symdyn.errors import SymdynError
from symdyn.graph import reachable
from symdyn.scene import Scene, bind, read, read_text
from symdyn.scene.values.folding import map_quantities, substituted
from symdyn.simulation import Trajectory, inverse, read_forces, read_motion, simulate
from symdyn.simulation.equations.compiled_routines import opened
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.equations.written import state_equations, written_decisions
from symdyn.simulation.force_columns import choices
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import METHODS, importable

pytestmark = pytest.mark.runs

EXAMPLES = Path(__file__).parent.parent / "examples"

CASES = {"double_pendulum": "l1", "cart_pole": "mp", "four_bar": "m2", "rolling_disc": "r", "governor": "l"}
"""An example and a parameter of it."""


def another(scene: Scene, name: str, factor: float = 1.25) -> Scene:
    """Return the scene with another value of a parameter."""
    (value,) = (p.value for p in scene.parameters if p.name == name)
    assert value is not None
    return bind(scene, {name: str(float(value.value) * factor)})  # type: ignore[arg-type]


def of_numbers(scene: Scene) -> Scene:
    """Return the scene with numbers in place of its parameters."""
    known = {p.name: p.value for p in scene.parameters if p.value is not None}
    return map_quantities(replace(scene, parameters=()), lambda one: substituted(one, known))


def state(system: StateEquations) -> np.ndarray:
    start = read_start(system.scene)
    away = 0.0 if system.closed else 0.3
    return np.concatenate([start.q + away, start.u + away, np.zeros(int(system.works))])


@pytest.mark.wide("double_pendulum", "four_bar")
@pytest.mark.parametrize("name", CASES)
def test_equations_at_other_values_are_those_of_a_scene_of_numbers(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    first = state_equations(scene)
    other = state_equations(another(scene, CASES[name]))
    numbers = state_equations(of_numbers(other.scene))
    x = state(other)

    assert other.compiled is first.compiled
    assert numbers.compiled is not first.compiled
    assert any(
        abs(other.evaluate(told, 0.0, x) - first.evaluate(told, 0.0, x)).max() > 1e-3 for told in ("rates", "potential")
    )
    for told in set(other.calls) & set(numbers.calls):
        assert other.evaluate(told, 0.2, x) == pytest.approx(numbers.evaluate(told, 0.2, x), rel=1e-9, abs=1e-9), told


@pytest.mark.wide(4)
@pytest.mark.parametrize(
    "method", [name for name, one in METHODS.items() if importable(one.module) and one.finds_events]
)
@pytest.mark.parametrize("name", ["double_pendulum", "four_bar"])
def test_nothing_is_compiled_for_another_value(name: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    asked = {"until": 0.2, "method": method, "rtol": 1e-7, "reports": [scene.coordinates[0]]}
    simulate(scene, **asked)  # type: ignore[arg-type]
    forbidden = [
        "symdyn.simulation.equations.compiled_routines.load_program",
        "symdyn.simulation.equations.compiled_routines.lower",
        "symdyn.simulation.integrate.taylor.translate",
    ]
    for place in forbidden:
        monkeypatch.setattr(place, None)
    found = simulate(another(scene, CASES[name]), **asked)  # type: ignore[arg-type]

    assert found.complete
    assert found.monitors["energy"] <= 1e-4 * found.monitors["energy_scale"]


def test_values_are_given_with_the_call() -> None:
    scene = read(EXAMPLES / "double_pendulum.toml")
    given = simulate(scene, until=0.5, values={"l1": "0.7", "g": 1.62})
    bound = simulate(bind(scene, {"l1": "0.7", "g": 1.62}), until=0.5)

    assert np.array_equal(given.table()[1], bound.table()[1])


def test_a_run_does_not_depend_on_what_was_run_before() -> None:
    scene = read(EXAMPLES / "double_pendulum.toml")
    first = simulate(scene, until=1.0)
    simulate(another(scene, "l1"), until=1.0)
    again = simulate(scene, until=1.0)

    assert np.array_equal(first.table()[1], again.table()[1])


def test_what_is_zero_drops_out_and_comes_back() -> None:
    scene = read(EXAMPLES / "cart_pole.toml")
    with_drag, without = state_equations(scene), state_equations(bind(scene, {"b": 0}))

    assert with_drag.works
    assert not without.works
    assert state_equations(another(scene, "b")).compiled is with_drag.compiled


TILTED = """
name = "tilted"
[parameters]
alpha = { value = "90 deg" }
[bodies.arm]
mass = 1
com = [0.3, 0, 0]
inertia = [0.1, 0.2, 0.3]
inertia_about = "com"
[joints.hinge]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 0, 1]
origin = [["Rx", "alpha/2"], ["Rx", "alpha/2"]]
coordinate = "q1"
"""


def test_right_angles_stay_exact_and_others_are_free() -> None:
    scene = read_text(TILTED)
    right = state_equations(scene)
    leaning, steep = (state_equations(bind(scene, {"alpha": value})) for value in ("80 deg", "1.2 rad"))

    assert right.compiled.program["rates"].counts.cost < leaning.compiled.program["rates"].counts.cost
    assert leaning.compiled is steep.compiled


LINKAGE = """
name = "linkage"
[parameters]
a = { value = 1, positive = true }
c = { value = 1, positive = true }
[bodies.crank]
mass = 1
com = ["a/2", 0, 0]
[bodies.coupler]
mass = 2
com = [1, 0, 0]
[bodies.rocker]
mass = 1
com = ["c/2", 0, 0]
[joints.A]
type = "revolute"
parent = "ground"
child = "crank"
axis = [0, 1, 0]
coordinate = "alpha"
drive = false
start = -1
[joints.B]
type = "revolute"
parent = "crank"
child = "coupler"
axis = [0, 1, 0]
origin = ["a", 0, 0]
coordinate = "beta"
drive = false
start = 1
[joints.D]
type = "revolute"
parent = "ground"
child = "rocker"
axis = [0, 1, 0]
origin = [2, 0, 0]
coordinate = "delta"
drive = false
start = -1
[[loop]]
name = "C"
type = "revolute"
parent = "coupler"
child = "rocker"
axis = [0, 1, 0]
origin = [2, 0, 0]
tip = ["-c", 0, 0]
"""


def test_a_value_that_spoils_a_decision_is_noticed_told_and_right() -> None:
    """A parallelogram, whose loop holds coordinates in proportion, and a linkage whose does not."""
    scene = read_text(LINKAGE)
    lines: list[str] = []
    simulate(scene, until=0.1, method="dop853", say=lines.append)
    other = bind(scene, {"c": 1.1})
    found = simulate(other, until=0.5, method="dop853", say=lines.append)
    fresh = simulate(of_numbers(other), until=0.5, method="dop853")

    (line,) = [line for line in lines if "otherwise than before" in line]
    assert "loops in proportion" in line
    assert line in found.notes
    assert found.q == pytest.approx(fresh.q, abs=1e-8)
    assert found.monitors["loops"] < 1e-10


def test_decisions_that_may_not_hold_are_not_taken_over() -> None:
    """A parallelogram could have its coordinates in proportion: what was decided for another linkage is not enough."""
    scene = read_text(LINKAGE)
    known = written_decisions(bind(scene, {"c": 1.1}))
    start = read_start(scene).q

    assert known.linear is None
    assert not known.hold(opened(scene).numbers(), start)
    assert not known.hold(opened(bind(scene, {"c": 1.2})).numbers(), start)  # which it does not close


@pytest.mark.heavy("rolling_disc")
@pytest.mark.parametrize("name", ["four_bar", "rolling_disc", "governor"])
def test_where_the_start_is_given_nothing_is_assembled(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, parameter = read(EXAMPLES / f"{name}.toml"), {"four_bar": "m2", "rolling_disc": "m", "governor": "k"}[name]
    start = read_start(scene)
    simulate(scene, until=0.3, method="dop853", start=start)
    other = another(scene, parameter)
    with monkeypatch.context() as patch:
        patch.setattr("symdyn.dynamics.loops.loop_numbers.Numbers.decided", None)
        found = simulate(other, until=0.3, method="dop853", start=start)
    fresh = simulate(of_numbers(other), until=0.3, method="dop853", start=start)

    assert found.q == pytest.approx(fresh.q, abs=1e-8)


def test_a_value_that_divides_by_zero_is_refused() -> None:
    scene = read(EXAMPLES / "pendulum.toml")
    simulate(scene, until=0.1)
    with pytest.raises(SymdynError, match=r"zero|no mass"):
        simulate(scene, until=0.1, values={"l": 0})


def results(tmp_path: Path) -> tuple[StateEquations, Trajectory]:
    table = tmp_path / "pushes.csv"
    table.write_text("t,F\n0,0\n0.1,1\n0.2,0\n")
    scene = read(EXAMPLES / "cart_pole.toml")
    forces = read_forces(scene, [str(table)])
    return state_equations(scene, forces), simulate(scene, forces=forces, until=0.3, reports=["theta"])


def test_what_is_returned_pickles(tmp_path: Path) -> None:
    equations, trajectory = results(tmp_path)
    again, moved = pickle.loads(pickle.dumps((equations, trajectory)))

    assert again.compiled is equations.compiled
    assert np.array_equal(moved.table()[1], trajectory.table()[1])
    assert moved.scene == trajectory.scene


@pytest.mark.parametrize("law", ["0.3*sin(2*t)", "0.2", *(f"{one}(0, 1, 2)" for one in ("quintic", "trapezoidal")),
                                 "spline(0, 0, 1, 0.5, 2, 0)"])  # fmt: skip
def test_motions_pickle(law: str) -> None:
    motion, t = read_motion(read(EXAMPLES / "pendulum.toml"), [f"q1={law}"]), np.linspace(0, 2, 7)
    (there,), (here,) = pickle.loads(pickle.dumps(motion)).laws.values(), motion.laws.values()

    assert np.array_equal(there(t), here(t))


RECEIVER = """
import pickle, sys
equations, x = pickle.load(sys.stdin.buffer)
sys.stdout.buffer.write(pickle.dumps(equations.rates(0.05, x)))
"""


@pytest.mark.slow
def test_a_process_with_an_empty_cache_reads_a_pickle(tmp_path: Path) -> None:
    equations, _ = results(tmp_path)
    x = state(equations)
    text = pickle.dumps((equations, x))
    place = os.environ | {"SYMDYN_CACHE_DIR": str(tmp_path / "empty")}
    run = subprocess.run([sys.executable, "-c", RECEIVER], input=text, capture_output=True, env=place, check=True)

    assert len(text) < 50_000  # a scene, and no machine code
    assert np.array_equal(pickle.loads(run.stdout), equations.rates(0.05, x))
    assert list((tmp_path / "empty").iterdir())


def rates(equations: StateEquations, x: np.ndarray) -> np.ndarray:
    return equations.rates(0.05, x)


@pytest.mark.slow
def test_processes_that_are_spawned_take_equations_and_give_trajectories(tmp_path: Path) -> None:
    equations, _ = results(tmp_path)
    x = state(equations)
    with get_context("spawn").Pool(1) as pool:
        far = pool.apply(rates, (equations, x))
        run = pool.apply(simulate, (equations.scene,), {"until": 0.1, "values": {"l": 0.4}})

    assert np.array_equal(far, rates(equations, x))
    assert np.array_equal(run.q, simulate(equations.scene, until=0.1, values={"l": 0.4}).q)


@pytest.mark.wide("cart_pole")
@pytest.mark.parametrize("name", ["cart_pole", "four_bar"])
def test_inverse_dynamics_and_reactions_compile_nothing_for_another_value(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, t = read(EXAMPLES / f"{name}.toml"), np.linspace(0.0, 0.2, 3)
    first = scene.coordinates[0]
    law = [f"{first}={float(read_start(scene).q[0])!r} + 0.3*t**2"]
    inverse(scene, read_motion(scene, law), t, reactions=True)
    with monkeypatch.context() as patch:
        patch.setattr("symdyn.simulation.equations.compiled_routines.load_program", None)
        other = another(scene, CASES[name])
        found = inverse(other, read_motion(other, law), t, reactions=True)
    numbers = of_numbers(other)
    fresh = inverse(numbers, read_motion(numbers, law), t, reactions=True)

    assert found.names == fresh.names
    assert found.table()[1] == pytest.approx(fresh.table()[1], rel=1e-9, abs=1e-9)


def test_values_are_given_with_the_call_of_inverse_dynamics() -> None:
    scene, t, law = read(EXAMPLES / "cart_pole.toml"), np.linspace(0.0, 0.2, 3), {"x": "l*sin(t)", "theta": "0.3*t"}
    inverse(scene, law, t)
    given, bound = inverse(scene, law, t, values={"l": "0.7", "g": 1.62}), bind(scene, {"l": "0.7", "g": 1.62})

    assert np.array_equal(given.table()[1], inverse(bound, read_motion(bound, law), t).table()[1])


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", ["four_bar", "governor"])
def test_reactions_of_a_run_compile_nothing_for_another_value(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, asked = read(EXAMPLES / f"{name}.toml"), {"until": 0.1, "method": "dop853", "reactions": "joint"}
    simulate(scene, **asked)  # type: ignore[arg-type]
    other = another(scene, {"four_bar": "m2", "governor": "k"}[name])
    with monkeypatch.context() as patch:
        patch.setattr("symdyn.simulation.equations.compiled_routines.load_program", None)
        found = simulate(other, **asked)  # type: ignore[arg-type]
    fresh = simulate(of_numbers(other), **asked)  # type: ignore[arg-type]

    assert found.names == fresh.names
    assert found.table()[1] == pytest.approx(fresh.table()[1], rel=1e-7, abs=1e-7)


def test_what_numbers_choose_otherwise_is_another_function_of_reactions() -> None:
    scene = read_text(LINKAGE)
    one, other, same = (choices(bind(scene, {"c": value}), "body") for value in (1.1, 1, "1.1"))

    assert one == same
    assert one != other


@pytest.mark.slow
def test_reactions_are_right_however_the_plane_of_a_loop_leans() -> None:
    scene = read_text(LEANING)
    t, law = np.array([0.0, 0.1]), {"alpha": "-1 + 0.1*t"}
    inverse(scene, law, t, reactions="joint")
    for value in ("0.3", "0.7", "0"):
        other = bind(scene, {"lean": value})
        found, fresh = (inverse(one, law, t, reactions="joint") for one in (other, of_numbers(other)))

        assert found.names == fresh.names
        assert found.table()[1] == pytest.approx(fresh.table()[1], rel=1e-9, abs=1e-9)


LEANING = (
    LINKAGE.replace("c = { value = 1, positive = true }", "c = { value = 1.1, positive = true }\nlean = { value = 0 }")
    .replace("drive = false\nstart = -1", 'start = -1\norigin = [["Rz", "lean"]]', 1)
    .replace('origin = [2, 0, 0]\ncoordinate = "delta"', 'origin = [["Rz", "lean"], ["Tx", 2]]\ncoordinate = "delta"')
)


def test_what_the_command_line_binds_is_folded() -> None:
    scene = bind(read(EXAMPLES / "cart_pole.toml"), {"l": "0.4"})
    system = state_equations(scene.in_numbers(["l"]))

    (params,) = system.compiled.prepared["prepare"].function.arguments
    needed = {node.value for node in reachable(system.compiled.prepared["prepare"].function.entries)}
    assert "l" in [str(one.value) for one in params.symbols]
    assert "l" not in needed
    assert "mp" in needed
