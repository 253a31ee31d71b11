"""A function of a scene at many parameter sets: every number is that of one call of `load`'s function."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.cli import main
from symdyn.errors import SimulateError
from symdyn.study import job_of_places

ARM = symdyn.example("two_link")

FILE = str(Path(symdyn.__file__).parent.parent / "examples" / "two_link.toml")

FIXED = {"h1": 1, "h2": 1, "g": 9.81}

OVER = ["m1=uniform(1,2)", "m2=normal(1,0.1)", "q1=[0,0.5,1]"]

pytestmark = pytest.mark.runs("cc")


def swept(measure: Any, **more: Any) -> symdyn.study.Runs:
    said: dict[str, Any] = {"over": OVER, "values": FIXED, "design": "random", "count": 500}
    return symdyn.sweep(ARM, measure=measure, **(said | more))


def forces(study: symdyn.study.Runs, q2: Any, qd: Any, qdd: Any) -> Any:
    arm = symdyn.load(ARM, "inverse_dynamics")
    q = np.stack(np.broadcast_arrays(study["q1"], q2), axis=-1)
    return arm.inverse_dynamics(q, qd, qdd, m1=study["m1"], m2=study["m2"], **FIXED)


def test_each_set_is_one_call_at_one_place() -> None:
    study = swept(["M1", "heavier=M1-m1*g*h1+3*q2_ddot", "max(abs(M2))"], at="q2=0.3,q1_ddot=1,q2_ddot=2")

    tau = forces(study, 0.3, [0, 0], [1, 2])
    assert np.allclose(study["M1"], tau[:, 0], rtol=1e-13)
    assert np.allclose(study["max(abs(M2))"], abs(tau[:, 1]), rtol=1e-13)
    assert np.allclose(study["heavier"], tau[:, 0] - study["m1"] * 9.81 + 6, rtol=1e-13)


def test_folds_go_over_places(tmp_path: Path) -> None:
    t = np.linspace(0, 2, 41)
    at = {"t": t, "q2": np.sin(t), "q2_dot": np.cos(t), "q1_ddot": 0.5}
    measures = ["max(abs(M1))", "integral(M1)", "when_max(M2)", "end(M2) - start(M2)"]
    study = swept(measures, at=at)

    assert len(study) == 500
    for run in (0, 7, 499):
        q = np.stack([np.full(41, study["q1"][run]), np.sin(t)], axis=-1)
        qd, qdd = np.stack([0 * t, np.cos(t)], axis=-1), np.stack([0 * t + 0.5, 0 * t], axis=-1)
        tau = symdyn.load(ARM, "inverse_dynamics").inverse_dynamics(
            q, qd, qdd, m1=study["m1"][run], m2=study["m2"][run], **FIXED
        )
        wanted = [abs(tau[:, 0]).max(), np.trapezoid(tau[:, 0], t), t[tau[:, 1].argmax()], tau[-1, 1] - tau[0, 1]]
        assert np.allclose([study[name][run] for name in measures], wanted, rtol=1e-12, atol=1e-13)

    file = tmp_path / "motion.csv"
    rows = np.stack(np.broadcast_arrays(*at.values()), axis=-1).tolist()
    file.write_text("\n".join([",".join(at), *(",".join(map(repr, row)) for row in rows)]) + "\n")
    again = swept(measures, at=str(file))
    assert all(np.array_equal(study[name], again[name]) for name in measures)


@pytest.mark.parametrize("rows", [1, 7, 5000])
def test_no_number_depends_on_how_many_go_through_at_a_time(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = swept("M1", at="q2=0.3")
    monkeypatch.setattr(job_of_places, "ROWS", rows)
    found = swept("M1", at="q2=0.3", block=3 * rows)

    assert found.values.tobytes() == expected.values.tobytes()
    assert found["M1"].tobytes() == expected["M1"].tobytes()


def test_matrices_and_numbers_have_names_too() -> None:
    study = swept(["M1_2", "M2_2"], function="mass_matrix", at="q2=0.3")
    energy = swept("K", function="kinetic_energy", at="q1_dot=1,q2=0.3")
    loaded = symdyn.load(ARM, ["mass_matrix", "kinetic_energy"])
    some = {"m1": study["m1"], "m2": study["m2"], **FIXED}

    matrix = loaded.mass_matrix(np.stack([study["q1"], 0 * study["q1"] + 0.3], axis=-1), **some)
    assert np.allclose(study["M1_2"], matrix[:, 0, 1], rtol=1e-13)
    assert np.allclose(energy["K"], matrix[:, 0, 0] / 2, rtol=1e-13)


def test_sets_that_are_none_fail_alone() -> None:
    study = swept("M1", over={"m1": [1, -1, 2]}, design=None, count=None, at="q2=0.3", values={**FIXED, "m2": 1})

    assert np.isfinite(study["M1"]).tolist() == [True, False, True]
    assert study.reasons == {1: "m1 = -1; it must be positive"}


def test_nothing_varied_but_places_is_computed_without_prepare() -> None:
    study = swept("M1", over="q1=[0,0.5,1]", design=None, count=None, values={**FIXED, "m1": 1, "m2": 1}, at="q2=0.3")

    assert len(study) == 3
    assert np.isfinite(study["M1"]).all()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"function": "inverse_dynamic"}, "function: there is no output 'inverse_dynamic'"),
        ({"at": "q9=1"}, "at: inverse_dynamics takes no q9"),
        ({"at": "q1=1"}, "at: q1 is varied; leave it out here"),
        ({"at": "q2"}, 'at: "q2" is not name=formula'),
        ({"at": {"q2": [1, 2], "q2_dot": [1, 2, 3]}}, "q2 has 2 places, and another one has 3"),
        ({"at": "nowhere.csv"}, "nowhere.csv"),
        ({"at": "q2=1", "until": 3}, "until: of runs"),
        ({"at": "q2=1", "forces": "M1=3"}, "forces: of runs"),
        ({"at": "q2=1", "measure": "M7"}, '"M7" uses M7, which is not known here; known are M2, M1, t'),
        ({"at": "q2=1", "measure": "M1", "function": "mass_matrix"}, "mass_matrix neither takes nor gives M1"),
        ({"at": "q2=1", "block": 0}, "block: 0 is no number of sets"),
        ({"at": "q2=1", "values": {}}, "have no value; give them"),
        ({"at": "q2=1", "over": "q7=[1,2]"}, "over: q7 is not known"),
    ],
)
def test_what_does_not_fit_is_told(more: dict[str, Any], words: str) -> None:
    with pytest.raises(SimulateError, match=words.replace("(", r"\(")):
        swept(**({"measure": "M1"} | more))


def test_the_command_line_sweeps_a_function(capsys: pytest.CaptureFixture[str]) -> None:
    given = ["sweep", FILE, "--bind", "m2=1,h1=1,h2=1,g=9.81", "--over", "m1=[1,2]", "--measure", "M1"]

    assert main([*given, "--function", "inverse_dynamics", "--at", "q1=0.3,q1_ddot=1"]) == 0
    assert "M1" in capsys.readouterr().out
