"""An ensemble is many runs of `simulate`: each of its lanes is one, whatever way it was run."""

from __future__ import annotations

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

VALUES = {"m1": [1.0, 2.0, 3.0], "m2": 1.5, "h1": 1, "h2": "0.7", "g": 9.81}
START = {"q1": [0.1, 1.2, 3.0]}


def test_a_measure_is_that_of_the_rows_of_a_run() -> None:
    scene = symdyn.example("two_link")
    texts = ["max(abs(M2))", "end(q1) - start(q2_dot)/m1", "when_max(q1)", "rms(q2)", "mean(q1_ddot)"]
    forces = "M2=-0.3*q2_dot+0.1*t"
    runs = symdyn.ensemble(scene, forces, 2.0, START, {"q2": 0.4}, VALUES, texts, method="taylor", workers=2)
    for k in range(3):
        values = VALUES | {"m1": VALUES["m1"][k]}
        one = symdyn.simulate(scene, forces, 2.0, {"q1": START["q1"][k]}, {"q2": 0.4}, values=values)
        np.testing.assert_allclose(runs.q[k], one.q[-1], atol=1e-7)
        span = np.trapezoid(np.ones_like(one.t), one.t)
        expected = [
            abs(one["M2"]).max(),
            one["q1"][-1] - one["q2_dot"][0] / values["m1"],
            one.t[one["q1"].argmax()],
            np.sqrt(np.trapezoid(one["q2"] ** 2, one.t) / span),
            np.trapezoid(one["q1_ddot"], one.t) / span,
        ]
        np.testing.assert_allclose([runs[text][k] for text in texts], expected, atol=1e-7)
    assert runs.words == ("end",)
    assert runs.complete.all()


def test_all_faults_of_a_call_are_told_at_once() -> None:
    with pytest.raises(SimulateError) as told:
        symdyn.ensemble(
            symdyn.example("two_link"),
            start={"q1": [0.1, np.nan], "q9": 1, "q2": [[1]]},
            values={"m1": [1.0, -2.0, 3.0], "m2": 1, "h1": 1, "h2": 1, "g": [1.0, 2.0]},
            measures=["max(abs(M9))", "rms(max(q1))", "q1", "max(q1", "3"],
            workers=0,
        )
    words = "\n".join(told.value.faults)
    for part in (
        "q1: run 1 has nan", "q9 is not known", "shape (1, 1)", "values m1 has 3, values g has 2", "run 1 has -2",
        "uses M9", "folds what is a number already", "write max(q1), end(q1)", "bracket that is not closed",
        "folds nothing", "workers = 0",
    ):  # fmt: skip
        assert part in words
