"""Second computations of what one way alone computed in `identification` and `linear`: slopes, and places of ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.identification import gains as gains_of
from symdyn.identification.gains import first
from symdyn.identification.regression import Rows
from symdyn.linear.prepared import prepared
from symdyn.linear.steady import settled
from symdyn.linear.symbolic import symbolic
from symdyn.simulation import Problem


@pytest.mark.parametrize("hardly", [False, True], ids=["told", "hardly told"])
def test_slopes_of_the_first_guess_of_gains_are_those_of_its_residuals(
    hardly: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By differences, and with a least squares that knows no slopes; gains that data hardly tell stay near a guess."""
    import scipy.optimize

    draw = np.random.default_rng(3)
    joint = np.repeat(np.arange(3), 40)
    Y = draw.normal(size=(120, 5))
    beta, gains = np.array([1.0, -2.0, 0.5, 3.0]), np.array([0.5, -2.0, 1.0])
    if hardly:
        Y[:, -1] *= 1e-4  # of what is known hardly anything is felt
    tau = (Y @ np.append(beta, 1.0)) / gains[joint] + 1e-3 * draw.normal(size=120)
    rows = Rows(Y, tau, joint, np.zeros(120), np.zeros(120, np.int64))
    solve, seen = scipy.optimize.least_squares, list[float]()

    def watched(off: Any, begin: Any, slope: Any, **more: Any) -> Any:
        found = solve(off, begin, slope, **more)
        assert not off(begin)[-2:].any(), "a guess is where gains that are not told stay"
        pulls, sizes = slope(begin)[:, :-2].T @ off(begin), np.abs(slope(begin)[:, :-2]).T @ np.abs(off(begin))
        assert np.abs(pulls / sizes).max() < 1e-9, "parameters begin where they fit best beside the guess of gains"
        for x in (begin, found.x, begin + 0.1 * draw.normal(size=len(begin))):
            steps = 1e-6 * np.maximum(1, np.abs(x))
            by_steps = [
                (off(x + h * one) - off(x - h * one)) / (2 * h) for h, one in zip(steps, np.eye(len(x)), strict=True)
            ]
            seen.append(float(np.abs(np.stack(by_steps, axis=1) - slope(x)).max() / np.abs(slope(x)).max()))
            rest = np.abs(slope(x)[-2:] - np.stack(by_steps, axis=1)[-2:]).max()
            assert rest < 1e-8, "weak rows"
        return found

    monkeypatch.setattr(scipy.optimize, "least_squares", watched)
    found = first({0: "A", 1: "A"}, rows, np.ones(3))
    assert len(seen) >= 3
    assert max(seen) < 1e-7
    if not hardly:
        np.testing.assert_allclose(found.values, gains, rtol=0.05)
    assert gains_of.WEAK * np.abs(found.values).max() < 1


TWO_DRIVES = """
name = "two_drives"
gravity = [0, 0, 0]
[inputs.u]
[inputs.w]
[bodies.a]
mass = 2
[bodies.b]
mass = 3
[joints.along]
type = "prismatic"
parent = "ground"
child = "a"
axis = [1, 0, 0]
coordinate = "x"
drive = "F"
force = ["-5*x + 7*w - 2*x_dot"]
[joints.beside]
type = "prismatic"
parent = "ground"
child = "b"
axis = [0, 1, 0]
coordinate = "z"
drive = false
force = ["-3*z - 2*z_dot"]
[joints.across]
type = "prismatic"
parent = "a"
child = "b2"
axis = [0, 1, 0]
coordinate = "y"
drive = "G"
force = ["-4*y + 11*u"]
[bodies.b2]
mass = 1
[outputs]
one = "2*F + 3*G + x"
two = "13*u + 17*w + y_dot"
"""


def test_outputs_that_drives_and_inputs_act_on_at_once_have_formulas(tmp_path: Any) -> None:
    """D of formulas is D of numbers, by differences too."""
    (tmp_path / "two.toml").write_text(TWO_DRIVES)
    scene = symdyn.read(tmp_path / "two.toml")
    asked = prepared(Problem(scene), outputs=["one", "two"])
    found = settled(asked, asked.at(np.zeros(3), np.zeros(3)))
    formulas = symbolic(asked, found)

    inputs = {name: k for k, name in enumerate(found.inputs.names)}
    assert found.D[0, inputs["F"]] == 2
    assert found.D[0, inputs["G"]] == 3
    assert found.D[1, inputs["u"]] == 13
    assert found.D[1, inputs["w"]] == 17
    assert np.count_nonzero(found.D) == 4
    assert formulas is not None, "what is given up because formulas and numbers differ is not told"
    for exact, numbers in ((formulas.A, found.A), (formulas.B, found.B), (formulas.C, found.C), (formulas.D, found.D)):
        np.testing.assert_allclose([[float(x.to_sympy()) for x in row] for row in exact], numbers, atol=1e-12)
