"""A verdict is proved, agrees in numbers, fails or not shown; a claim of which nothing was compared is never a pass.

Every kind of claim is put where it cannot be looked at. What is no claim stands apart: `test_verify_no_claims.py`.
"""

from __future__ import annotations

import json
import math
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from closed_mechanisms import slider_crank

import symdyn
from symdyn.cli import main
from symdyn.cli.verify import _ulps
from symdyn.errors import MissingProgram
from symdyn.program import Sampling
from symdyn.scene import read_text
from symdyn.verify import Claim, Law, certify, measure, prove, rigorous
from symdyn.verify.equality import Fields

EXAMPLES = Path(__file__).parent.parent / "examples"
TWO_LINK = symdyn.example("two_link")
PENDULUM = symdyn.example("pendulum")

NOWHERE = """
[bodies.bob]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "bob"
axis = [1, 0, 0]
force = "2*log(-1 - 3*q1**2)"
"""
"""Its forces have a real value in no state."""

FUNCTIONS = ["inverse_dynamics", "forward_dynamics"]

numpy_alone = pytest.mark.usefixtures("numpy_alone")


def nowhere() -> symdyn.Scene:
    return read_text(NOWHERE, "nowhere.toml")


def words(certificate: Any) -> dict[str, str]:
    return {one.what: one.why for one in certificate.not_shown}


# Claims that cannot be looked at


@numpy_alone
@pytest.mark.mends("30.numbers.1")
@pytest.mark.mends("30.class.verdicts")
def test_functions_that_are_real_nowhere_are_not_passed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Formulations, laws, programs and measurements alike."""
    path = tmp_path / "nowhere.toml"
    path.write_text(NOWHERE, encoding="utf-8")
    status = main(["verify", str(path), "--functions", ",".join(FUNCTIONS)])
    told = capsys.readouterr().out

    assert status == 1
    assert "passed" not in told
    assert told.rstrip().endswith("nowhere: not shown")
    for what in (
        "inverse_dynamics: rnea = lagrange",
        "forward dynamics: FD(q, qd, ID(q, qd, qdd)) = qdd",
        "forward_dynamics: program = equations",
    ):
        assert f"Not shown: {what}: no point was found at which both sides have a real value" in told
    assert "Not shown: inverse_dynamics in numpy against 50 digits: real at none of the states tried" in told


KINDS = {
    "trees": ("two_link", ["inverse_dynamics", "mass_matrix", "coriolis_matrix", "kinetic_energy", "potential_energy"]),
    "regressors": ("two_link", ["inverse_dynamics", "regressor", "base_regressor"]),
    "momentum": ("two_link", ["centre_of_mass", "centre_of_mass_jacobian", "centroidal_momentum_matrix"]),
    "prepared": ("two_link", ["mass_matrix"]),
    "loops": ("four_bar", ["velocities", "constraint_jacobian", "constraint_bias", "forward_dynamics", "multipliers"]),
    "reactions": ("four_bar", ["reactions", "inverse_dynamics"]),
}
"""Claims about equations, by what they are about."""


@pytest.mark.long
@numpy_alone
@pytest.mark.mends("30.class.verdicts")
@pytest.mark.parametrize("kind", KINDS)
def test_no_claim_about_equations_holds_where_no_point_is_real(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def unreal(self: Any, outputs: Any, draw: int) -> None:
        raise ValueError

    monkeypatch.setattr("symdyn.verify.points.NumberPoints.values", unreal)
    name, outputs = KINDS[kind]
    found = certify(symdyn.example(name), outputs, prepare=kind == "prepared")
    proofs = [one for one in found.findings if "in numbers" not in one.claim and "definite" not in one.claim]

    assert not found.passed
    assert len(proofs) >= len(outputs)
    assert {one.verdict for one in proofs} == {"not shown"}
    assert {one.claim for one in proofs} == words(found).keys()


@numpy_alone
def test_json_notebook_and_text_say_the_same_words() -> None:
    found = certify(nowhere(), FUNCTIONS)
    facts = found.as_dict()
    page = found._repr_mimebundle_()["text/html"]

    assert (found.verdict, facts["verdict"], facts["passed"]) == ("not shown", "not shown", False)
    assert repr(found).startswith("<Certificate of nowhere: not shown;")
    assert {one["verdict"] for one in (*facts["findings"], *facts["accuracy"])} == {"not shown"}
    assert {one["what"] for one in facts["not_shown"]} == words(found).keys()
    assert '<p class="bad">not shown</p>' in page
    assert "real at none of the states tried" in page
    json.dumps(facts, allow_nan=False)


@pytest.mark.mends("30.class.verdicts")
def test_a_claim_without_entries_is_not_proved() -> None:
    (finding,) = prove([Claim("nothing", "a", "b", (), ())])[1]

    assert finding.verdict == "not shown"


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_a_law_that_compares_nothing_is_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    laws = import_module("symdyn.verify.laws")  # not the function of that name
    empty = Law(("mass_matrix",), None, lambda w: Claim("idle law", "nothing", "nothing", (), ()))
    monkeypatch.setattr(laws, "LAWS", [*laws.LAWS, empty])
    found = certify(TWO_LINK, ["mass_matrix"])

    assert not found.passed
    assert words(found) == {"idle law: nothing = nothing": "it has no entries to compare"}


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_closed_mechanisms_without_one_position_to_compare_at_are_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.verify.natural_positions._at", lambda entries, values: None)
    found = certify(slider_crank(), ["forward_dynamics", "multipliers", "reactions"])

    assert not found.passed
    assert {one.partition(":")[0] for one in words(found)} == {"forward dynamics", "forward_reactions", "reactions"}


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_a_derived_entry_that_is_not_finite_where_the_equations_have_a_solution_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A crank determines its slider everywhere: a hole of the code is not forward dynamics that does not exist."""
    natural = import_module("symdyn.verify.natural_positions")
    scene, real, holes = slider_crank(), natural._at, [True]

    def with_a_hole(entries: Any, values: Any) -> Any:
        of_forward_dynamics = len(entries) == 2 * len(scene.velocities)
        return None if of_forward_dynamics and holes and holes.pop() else real(entries, values)

    monkeypatch.setattr(natural, "_at", with_a_hole)
    found = certify(scene, ["forward_dynamics", "multipliers"])

    assert not holes
    assert not found.passed
    assert found.verdict == "fails"
    (failed,) = found.failed
    assert failed.what.startswith("forward dynamics: at the start = ")
    assert failed.why == "at the start derived entries are not finite where the equations have a solution"


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_a_mass_matrix_that_is_finite_nowhere_is_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Lost(Sampling):
        def state(self, widen: float = 1.0) -> list[Any]:
            return [np.full(argument.shape, np.nan) for argument in self.arguments]

    monkeypatch.setattr("symdyn.verify.natural_positions.Sampling", Lost)
    found = certify(TWO_LINK, ["mass_matrix", "forward_dynamics"])

    assert not found.passed
    assert words(found).keys() == {"mass matrix: positive definite"}


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_texts_of_functions_that_no_point_of_a_field_has_are_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    from symdyn.algebra.finite_field import Redraw

    def unlucky(*_: Any) -> None:
        raise Redraw

    monkeypatch.setattr("symdyn.verify.building.printed", unlucky)
    found = certify(PENDULUM, ["mass_matrix"])

    assert not found.passed
    assert "no point of a field" in words(found)["the text of NumPy"]


@pytest.mark.mends("30.class.verdicts")
def test_a_measurement_of_no_state_is_not_passed() -> None:
    from symdyn.program import lower

    program = lower(symdyn.dynamics.derive(nowhere(), ["inverse_dynamics"]))
    (found,) = measure(program, {"numpy": SimpleNamespace(inverse_dynamics=lambda q, qd, qdd: np.zeros(1))})

    assert not found.passed
    assert found.states == 0


@pytest.mark.mends("30.class.verdicts")
def test_numbers_beyond_those_of_the_type_are_compared_with_nothing() -> None:
    """A bound that is infinite allows everything."""
    from formulas import argument, function

    from symdyn.dynamics.outputs.named_functions import Equations
    from symdyn.graph import Graph
    from symdyn.program import lower
    from symdyn.scene import Scene

    graph = Graph()
    q = graph.symbol("q1")
    large = graph.constant(10**400) * q
    equations = Equations(Scene("large"), graph, (function("large", [argument("q", [q])], (1,), [large]),))
    (found,) = measure(lower(equations), {"numpy": SimpleNamespace(large=lambda q: np.full(1, np.inf))})

    assert not found.passed


@pytest.mark.runs("cc")
@pytest.mark.mends("30.class.verdicts")
def test_blocks_of_states_without_a_value_are_not_passed() -> None:
    from symdyn.program import lower
    from symdyn.verify.building import Building, run_blocks

    found = run_blocks(Building(lower(symdyn.dynamics.derive(nowhere(), ["inverse_dynamics"])), "double"), "c")

    assert not found.passed
    assert not found.wrong


@pytest.mark.runs("cc")
def test_blocks_are_looked_at_where_they_have_a_value() -> None:
    from symdyn.program import lower
    from symdyn.verify.building import Building, run_blocks

    scene = read_text(NOWHERE.replace("2*log(-1 - 3*q1**2)", "2*log(2*q1 - 6)"), "far.toml")
    found = run_blocks(Building(lower(symdyn.dynamics.derive(scene, ["inverse_dynamics"])), "double"), "c")

    assert (found.passed, found.without) == (True, ())


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_bounds_of_nothing_are_not_passed() -> None:
    assert not rigorous(PENDULUM, []).passed
    assert not rigorous(PENDULUM, ["k_C"]).passed


@numpy_alone
def test_a_bound_that_is_not_there_is_not_shown_and_a_result_that_is_not_there_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = rigorous(nowhere(), ["inverse_dynamics"], states=1)
    assert (found.verdict, {one.verdict for one in found.bounds}) == ("not shown", {"not shown"})

    from symdyn.verify.building import Modules

    broken = SimpleNamespace(mass_matrix=lambda q: np.full((1, 1), np.nan))
    room = import_module("symdyn.verify.rigorous")
    monkeypatch.setattr(room, "modules_of", lambda *_: Modules({"numpy": broken}, ()))
    assert rigorous(PENDULUM, ["mass_matrix"], states=1).verdict == "fails"


@pytest.mark.mends("30.class.verdicts")
def test_a_certificate_of_nothing_is_not_passed() -> None:
    from symdyn.verify import Certificate

    assert not Certificate("nothing", Fields(1, (7,), 1), (), (), ()).passed


@numpy_alone
@pytest.mark.mends("30.class.verdicts")
def test_what_has_no_entries_is_no_claim_and_alone_no_pass() -> None:
    """k_C of one coordinate."""
    alone, beside = certify(PENDULUM, ["k_C"]), certify(PENDULUM, ["k_C", "mass_matrix"])

    assert not alone.passed
    assert beside.passed
    for found in (alone, beside):
        assert "k_C: it has no entries" in map(str, found.absent)


# Files


@pytest.fixture
def folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """Return a folder with a C file of two links."""
    options = ["--functions", "mass_matrix", "--target", "c", "-o", str(tmp_path)]
    assert main(["generate", str(EXAMPLES / "two_link.toml"), *options]) == 0
    capsys.readouterr()
    return tmp_path


@pytest.mark.parametrize("name", ["MissingProgram", "Redraw"])
def test_files_that_cannot_be_read_here_are_not_shown(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from symdyn.algebra.finite_field import Redraw

    def fails(*_: Any) -> None:
        raise MissingProgram("no grammar of C; install the extra prove") if name == "MissingProgram" else Redraw

    monkeypatch.setattr("symdyn.verify.building.prove_texts", fails)
    assert main(["verify", str(EXAMPLES / "two_link.toml"), "--files", str(folder)]) == 1

    told = capsys.readouterr().out
    assert "Not shown: the text of two_link.c: no " in told
    assert told.rstrip().endswith("two_link: not shown")


def test_files_whose_equations_are_real_nowhere_are_not_passed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def unreal(self: Any, outputs: Any, draw: int) -> None:
        raise ValueError

    monkeypatch.setattr("symdyn.verify.points.NumberPoints.values", unreal)
    assert main(["verify", str(EXAMPLES / "two_link.toml"), "--files", str(folder)]) == 1
    assert "Not shown: mass_matrix: program = equations: no point" in capsys.readouterr().out


def test_an_empty_file_proves_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "two_link.h").write_text("", encoding="utf-8")

    assert main(["verify", str(EXAMPLES / "two_link.toml"), "--files", str(folder)]) == 1
    assert "Fails: the text of two_link.h: fixed text" in capsys.readouterr().out


# One place decides


def test_the_worst_verdict_is_that_of_all_and_of_none_nothing_is_shown() -> None:
    from symdyn.verdict import Verdict

    assert Verdict.worst([]) == "not shown"
    assert Verdict.worst(["proved", "agrees in numbers"]) == "agrees in numbers"
    assert Verdict.worst(["proved", "not shown"]) == "not shown"
    assert Verdict.worst(["not shown", "fails", "proved"]) == "fails"
    assert [Verdict.of(0), Verdict.of(0, proved=True), Verdict.of(3), Verdict.of(3, proved=True)] == [
        *("not shown", "not shown"),
        *("agrees in numbers", "proved"),
    ]
    assert Verdict.of(0, wrong=True) == Verdict.of(3, wrong=True, proved=True) == "fails"


@pytest.mark.parametrize(("error", "told"), [(0.0, "0"), (1.25, "1.2"), (3e292, "of 0"), (math.inf, "inf")])
def test_an_error_of_what_is_exactly_0_is_no_number_of_ulps(error: float, told: str) -> None:
    assert _ulps(error) == told
