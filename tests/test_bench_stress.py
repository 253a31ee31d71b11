"""Hard cases: the metrics see errors, and the cases hold; those that take long are behind the marker."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from scenes_in_time import block

from symdyn.bench.measurements import Case, Stress, worst
from symdyn.bench.reference import positions_of
from symdyn.bench.stress import FAMILIES, stress
from symdyn.bench.stress.motions import chaos_of_scene
from symdyn.bench.stress.odd_numbers import _hidden, _in_numpy, _minus_zero
from symdyn.bench.stress.scenes import arm, calls, chain, gimbal, heavier, solved, two_link
from symdyn.bench.stress.solving import BESIDE, FORWARD, shares, states
from symdyn.cli import main
from symdyn.errors import MethodError, SimulateError
from symdyn.scene import body, prismatic, read, scene

pytestmark = pytest.mark.runs()

STRESS = import_module("symdyn.bench.stress")  # its package offers the function of that name

EXAMPLES = Path(__file__).parent.parent / "examples"


class Wrong:
    """A module whose functions are off by a factor."""

    def __init__(self, module, factor):
        self.module, self.factor = module, factor

    def __getattr__(self, name):
        return lambda *state: np.asarray(getattr(self.module, name)(*state)) * self.factor


def test_a_solution_that_is_off_fails_both_bounds():
    made = calls(two_link(), FORWARD, beside=BESIDE)
    given = states(positions_of(two_link()), 2)
    wrong = replace(made, modules={"C": Wrong(made.modules["C"], 1 + 1e-12)})

    right = solved(made, given)
    off = solved(wrong, given)
    assert max(one.backward for one in right) < 10
    assert max(one.forward for one in right) < 10
    assert max(one.backward for one in off) > 100
    assert max(one.forward for one in off) > 10
    assert solved(replace(made, modules={"C": Wrong(made.modules["C"], math.nan)}), given)[0].forward == math.inf


def test_an_error_beyond_the_running_bound_is_seen():
    made = calls(two_link(), ("gravity_forces",))
    q = {"q": np.array([[0.3, 0.4], [1.0, 2.0]])}

    assert shares(made, "gravity_forces", q)[0] < 1
    assert shares(replace(made, modules={"C": Wrong(made.modules["C"], 1 + 1e-13)}), "gravity_forces", q)[0] > 10


def test_a_hidden_nan_is_counted():
    made = calls(two_link(), ("gravity_forces",))

    class Deaf:
        def gravity_forces(self, q):
            return made.modules["C"].gravity_forces(np.nan_to_num(q))

    given = {"q": np.array([[0.3, 0.4], [1.0, 2.0]])}
    assert _hidden(made, given, math.nan)[0] == 0
    assert _hidden(replace(made, modules={"deaf": Deaf()}), given, math.nan)[0] > 0


def test_chains_in_absolute_angles_are_the_same_mechanism():
    relative, absolute = calls(chain(3), ("kinetic_energy",)), calls(chain(3, absolute=True), ("kinetic_energy",))
    phi, rates = np.array([[0.3, -1.0, 2.0]]), np.array([[1.0, 0.5, -2.0]])
    q, qd = (np.diff(x, prepend=0.0) for x in (phi, rates))

    one = relative.modules["NumPy"].kinetic_energy(q, qd)
    assert one == pytest.approx(absolute.modules["NumPy"].kinetic_energy(phi, rates), rel=1e-14)


def test_heavier_scales_the_mass_matrix_body_by_body():
    M = calls(arm(), ("mass_matrix",)).modules["NumPy"].mass_matrix
    scaled = calls(heavier(arm(), (7,) * 6), ("mass_matrix",)).modules["NumPy"].mass_matrix
    q = np.linspace(-1, 1, 6)

    assert scaled(q) == pytest.approx(7 * M(q), rel=1e-13)
    assert gimbal().coordinates == ("psi", "theta", "phi")


def test_what_is_no_number_fails():
    assert not Case("n", "m", 1.0, math.nan).passed
    assert not Case("n", "m", math.inf, math.inf).passed
    assert worst([(1.0, "a"), (math.nan, "b"), (2.0, "c")])[1] == "b"
    assert not Stress("", "", (Case("n", "m", 1.0, 2.0),)).passed


@pytest.mark.mends("30.class.verdicts")
def test_where_nothing_is_compared_nothing_passes():
    assert not Case("n", "m", 1.0, *worst([])).passed
    assert not stress(read(EXAMPLES / "pendulum.toml"), ["spin"]).passed
    assert not stress(read(EXAMPLES / "two_link.toml"), ["solving"]).passed  # its parameters have no value


def test_a_case_of_which_nothing_is_compared_is_not_shown():
    case = Case("n", "m", 1.0, *worst([(None, "a")]))
    assert (case.verdict, case.worst) == ("not shown", "nothing could be compared")
    found = Stress("", "", (case, Case("n", "m", 1.0, 0.5)))

    assert found.verdict == "not shown"
    assert found.lines == ["Not shown: n, m: nothing could be compared"]


def test_errors_over_bounds_of_no_state_are_not_zero():
    made = calls(read(EXAMPLES / "four_bar.toml"), ("inverse_dynamics",))  # singular at q = 0
    given = {name: np.zeros((2, 3)) for name in ("q", "qd", "qdd")}

    assert shares(made, "inverse_dynamics", given)[0] is None


@pytest.mark.runs
def test_exceptions_are_not_run_without_a_compiler_and_not_shown_where_asked_for(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)
    monkeypatch.setattr(STRESS, "FAMILIES", {"traps": FAMILIES["traps"]})
    pendulum = read(EXAMPLES / "pendulum.toml")

    assert stress(pendulum, ["traps"]).unshown
    assert not stress(pendulum, ["traps"]).passed
    (one,) = stress(pendulum).not_run
    assert one.what.startswith("traps: exceptions that C functions raise")


UNREAL = prismatic("slide", parent="ground", child="slab", axis=(1, 0, 0), force="2*log(-1 - 3*q1**2)")


def unreal():
    """Return a scene whose force has a real value nowhere."""
    return scene("unreal", bodies=[body("slab", mass=1)], joints=[UNREAL])


@pytest.mark.mends("30.class.verdicts")
def test_a_scene_without_a_real_value_at_its_start_is_not_shown(monkeypatch):
    monkeypatch.setattr(STRESS, "FAMILIES", {name: FAMILIES[name] for name in ("numbers", "chaos")})
    found = stress(unreal())

    assert not found.passed
    assert not found.not_run
    (one,) = found.not_shown
    assert one.what == "chaos"
    assert "has no real value there; give another start" in one.why


@pytest.mark.runs("cc")
def test_where_the_equations_have_no_value_nothing_is_compared_and_nothing_fails():
    found = stress(unreal(), ["solving", "traps"])
    verdicts = {case.family: {one.verdict for one in found.cases if one.family == case.family} for case in found.cases}

    assert verdicts == {"solving": {"not shown"}, "traps": {"agrees in numbers"}}
    assert {one.why for one in found.not_shown} == {"the equations are not finite"}


def test_a_method_that_this_machine_lacks_is_not_run(monkeypatch):
    def lacks(_):
        raise MethodError("method taylor needs heyoka")

    monkeypatch.setattr(STRESS, "FAMILIES", {"chaos": replace(FAMILIES["chaos"], of_scene=lacks)})

    assert [one.what for one in stress(unreal()).not_run] == ["chaos"]
    assert [one.what for one in stress(unreal(), ["chaos"]).not_shown] == ["chaos"]


@pytest.mark.wide("stiff")
@pytest.mark.parametrize("family", ["angles", "traps", "stiff"])
def test_the_built_in_cases_hold(family):
    found = stress(families=[family])

    assert found.cases
    assert found.passed, [case for case in found.cases if not case.passed]


@pytest.mark.slow
@pytest.mark.parametrize("family", [name for name in FAMILIES if name not in ("angles", "traps", "stiff")])
def test_the_longer_built_in_cases_hold(family):
    found = stress(families=[family])

    assert found.cases
    assert found.passed, [case for case in found.cases if not case.passed]


def test_a_users_scene_is_put_to_the_cases_that_fit(tmp_path, capsys):
    scene = str(EXAMPLES / "double_pendulum.toml")

    assert main(["stress", scene, "--families", "angles,traps,chaos,stiff", "-o", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "none failed" in out
    assert "stiff: all cases are about built-in scenes" in out
    facts = json.loads((tmp_path / "stress.json").read_text("utf-8"))
    assert facts["passed"]
    assert {case["family"] for case in facts["cases"]} >= {"traps", "chaos"}
    assert (
        "symdyn stress double_pendulum.toml --families angles,traps,chaos,stiff" in (tmp_path / "stress.md").read_text()
    )
    assert '<span class="pass">pass</span>' in (tmp_path / "stress.html").read_text("utf-8")


def test_closed_mechanisms_solve_with_small_backward_errors_and_take_minus_zero():
    found = stress(read(EXAMPLES / "four_bar.toml"), ["solving", "numbers"])

    assert found.passed, [case for case in found.cases if not case.passed]
    assert {case.metric for case in found.cases} >= {"backward error of accelerations and of loops / eps"}


@pytest.mark.slow
def test_a_scene_whose_forces_name_time_is_solved_at_times():
    slab = prismatic("slide", parent="ground", child="slab", axis=(1, 0, 0), force="3*sin(t)")
    found = stress(scene("pushed", bodies=[body("slab", mass=1)], joints=[slab], units="none"), ["solving"])

    assert found.cases
    assert found.passed, [case for case in found.cases if not case.passed]


def test_minus_zero_that_changes_a_result_is_seen_and_singular_positions_are_not():
    made = calls(read(EXAMPLES / "four_bar.toml"), ("inverse_dynamics",))  # singular at q = 0
    given = {name: np.ones((2, 3)) for name in ("q", "qd", "qdd")}
    assert _minus_zero(made, given)[0] == 0

    class Signed:
        def gravity_forces(self, q):
            return np.copysign(1.0, np.asarray(q))

    pendulum = calls(two_link(), ("gravity_forces",))
    assert _minus_zero(replace(pendulum, modules={"signed": Signed()}), {"q": np.ones((2, 2))})[0] > 4


def test_parameters_without_values_are_asked_for():
    found = stress(read(EXAMPLES / "two_link.toml"), ["solving", "angles", "chaos"])

    assert not found.cases
    assert found.verdict == "not shown"
    assert all("m1, m2, h1, h2, g have no value; give them, as in values={" in one.why for one in found.unshown)


def test_a_program_run_operation_by_operation_is_the_code():
    given = {"q": np.array([[0.3, 0.4], [1.0, 2.0]])}
    run = calls(two_link(), ("gravity_forces",), compiled=False)
    code = calls(two_link(), ("gravity_forces",)).results("gravity_forces", given)

    (one, other) = run.results("gravity_forces", given).values()
    assert one == pytest.approx(code["NumPy, many states"], rel=1e-15)
    assert np.array_equal(one, other)


def test_an_exception_of_numpy_is_counted():
    made = calls(two_link(), ("gravity_forces",))

    class Loud:
        def gravity_forces(self, q):
            return np.sqrt(-np.asarray(q))

    assert _in_numpy(made) == [(0.0, "none")]
    assert worst(_in_numpy(replace(made, modules={"NumPy": Loud()})))[0] == 1


def test_a_failed_bound_is_exit_1(monkeypatch, capsys):
    import symdyn.cli.stress  # noqa: F401  takes the table as it is, and not that of this test for ever

    family = replace(FAMILIES["traps"], builtin=lambda: iter([Case("made up", "m", 1.0, 2.0)]))
    monkeypatch.setattr(STRESS, "FAMILIES", {"traps": family})

    assert main(["stress"]) == 1
    assert "FAIL" in capsys.readouterr().out


def test_families_are_listed_and_misspelt_ones_told(capsys):
    assert main(["stress", "--families", ""]) == 0
    assert "change points" in capsys.readouterr().out
    with pytest.raises(SimulateError, match="family angels is not known; did you mean angles"):
        stress(read(EXAMPLES / "pendulum.toml"), ["angels"])


def test_the_motion_of_a_scene_with_dry_friction_is_judged_by_its_equations():
    found = block("friction = { coulomb = 1.0, smoothing = 0.001 }")

    assert [case for case in chaos_of_scene(found) if not case.passed] == []
