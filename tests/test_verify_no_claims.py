"""What is no claim stands apart: what this machine cannot run unless it was asked for, and what does not exist."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import symdyn
from symdyn.cli import main
from symdyn.emit import TARGETS
from symdyn.errors import MissingProgram
from symdyn.verify import certify, rigorous

EXAMPLES = Path(__file__).parent.parent / "examples"
TWO_LINK = symdyn.example("two_link")
PENDULUM = symdyn.example("pendulum")

numpy_alone = pytest.mark.usefixtures("numpy_alone")


# What this machine cannot run


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """No compiler, no Node.js, no grammar, no PATH."""

    def no_grammar(*_: Any) -> None:
        raise MissingProgram("no grammar; install the extra prove")

    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("symdyn.runtime.compiler.find_spec", lambda name: None)
    monkeypatch.setattr("symdyn.verify.building.prove_texts", no_grammar)


@pytest.mark.runs
@pytest.mark.usefixtures("bare")
def test_on_a_bare_machine_what_is_not_run_is_listed_and_the_rest_holds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(EXAMPLES / "two_link.toml")]) == 0

    told = capsys.readouterr().out
    for what in ("the error of C", "the error of JavaScript", "the text of NumPy", "the text of JavaScript"):
        assert f"Not run: {what}: " in told
    assert "Not shown" not in told
    assert told.rstrip().endswith("two_link: passed")


@pytest.mark.runs
@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(("target", "what"), [("c", "the error of"), ("js", "the error of"), ("numpy", "the text of")])
@pytest.mark.mends("30.also.verdicts")
def test_what_was_asked_for_and_cannot_be_run_is_not_shown(
    target: str, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["verify", str(EXAMPLES / "pendulum.toml"), "--functions", "mass_matrix"]
    assert main([*asked, "--targets", target]) == 1

    told = capsys.readouterr().out
    assert f"Not shown: {what}" in told
    assert "Not run" not in told


@numpy_alone
@pytest.mark.usefixtures("bare")
def test_a_program_that_no_machine_lacks_is_measured_all_the_same() -> None:
    found = certify(PENDULUM, ["mass_matrix"])

    assert found.passed
    assert [(one.function, one.module) for one in found.accuracy] == [("mass_matrix", "numpy")]


@pytest.mark.runs
@pytest.mark.mends("30.also.verdicts")
def test_a_function_that_no_module_runs_is_not_shown() -> None:
    """A ufunc leaves out what is large."""
    found = certify(TWO_LINK, ["k_C", "mass_matrix"], targets=["ufunc"])

    assert not found.passed
    assert [one.what for one in found.not_shown] == ["the error of k_C"]


@numpy_alone
def test_a_language_that_nothing_runs_is_proved_by_its_text() -> None:
    found = certify(PENDULUM, ["mass_matrix"], targets=["julia"])

    assert found.passed
    assert found.lines == ["Not looked at: the error of Julia: not measured: symdyn runs no Julia"]
    assert [one["what"] for one in found.as_dict()["not_looked_at"]] == ["the error of Julia"]
    assert "not looked at" in found._repr_mimebundle_()["text/html"]


@pytest.mark.runs
def test_a_target_that_nothing_reads_back_is_measured_alone() -> None:
    found = certify(PENDULUM, ["mass_matrix"], targets=["json"])

    assert found.passed
    assert [one.what for one in found.not_looked_at] == [f"the text of {TARGETS['json'].title}"]
    assert not certify(PENDULUM, ["mass_matrix"], targets=["numpy"]).not_looked_at


@pytest.mark.mends("30.class.verdicts")
def test_an_empty_list_of_targets_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["verify", str(EXAMPLES / "pendulum.toml"), "--functions", "mass_matrix"]

    assert main([*asked, "--targets", ","]) == 1
    assert "no target is asked for" in capsys.readouterr().err


# What does not exist there


@pytest.mark.runs
def test_a_position_where_rows_lose_rank_is_told_with_the_rank() -> None:
    """Four bars of one length and its half that start flat: a change point."""
    from dataclasses import replace

    from closed_mechanisms import n_four_bar

    flat = n_four_bar(1)
    joints = tuple(replace(joint, start=(symdyn.scene.Quantity.number(0),)) for joint in flat.joints)
    found = certify(replace(flat, joints=joints), ["forward_dynamics", "multipliers"])

    assert found.passed
    (told,) = [one for one in found.absent if "rank" in one.why]
    assert told.what.startswith("forward dynamics at ")
    assert "the rows of loops and prescribed motions have rank 1 of 2" in told.why


@numpy_alone
@pytest.mark.mends("30.also.verdicts")
def test_bounds_at_a_position_where_rows_lose_rank_leave_out_forward_dynamics() -> None:
    """Three parallel cranks at zero: nothing is claimed of what does not exist there, and the rest is bounded."""
    scene = symdyn.read(Path(__file__).parent / "data" / "three_cranks.toml")
    flat = dict.fromkeys(scene.coordinates, 0.0)
    found = rigorous(scene, ["forward_dynamics", "tree_forces"], flat)

    assert found.passed
    assert {one.function for one in found.bounds} == {"tree_forces"}
    (told,) = [one for one in found.absent if one.what.startswith("forward_dynamics at this state")]
    assert "have rank 2 of 3" in told.why


@numpy_alone
def test_formulations_that_a_scene_has_not_are_told() -> None:
    found = certify(symdyn.example("four_bar"), ["forward_dynamics"])

    assert found.passed
    assert any("aba of forward_dynamics" in one.what and "loops" in one.why for one in found.absent)


@numpy_alone
def test_a_formulation_that_is_refused_for_a_scene_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from symdyn.errors import DerivationError
    from symdyn.verify import claims

    real = claims.derive_one

    def derive(w: Any, name: str, formulation: str | None = None) -> Any:
        if formulation == "lagrange":
            raise DerivationError("M is singular")
        return real(w, name, formulation)

    monkeypatch.setattr(claims, "derive_one", derive)
    found = certify(PENDULUM, ["inverse_dynamics"])

    assert found.passed
    assert "formulation lagrange of inverse_dynamics: M is singular" in map(str, found.absent)


@pytest.mark.usefixtures("numpy_alone")
def test_what_was_not_looked_at_is_not_told_as_what_does_not_apply(monkeypatch: pytest.MonkeyPatch) -> None:
    """The run of a hopper ends where it lands: the rest of its second is no claim, and none that holds."""
    why = {"run of 1 s, all of it": "it ends at t = 0.2 s"}
    monkeypatch.setattr("symdyn.verify.natural_positions.contact_checks", lambda scene, seed: ({}, why))
    found = symdyn.certify(symdyn.example("hopper"), ["mass_matrix", "k_C", "delassus", "gap:floor"])
    assert found.lines == ["Not looked at: run of 1 s, all of it: it ends at t = 0.2 s"]
    assert not any("run of 1 s" in one.what for one in (*found.claims, *found.absent))
