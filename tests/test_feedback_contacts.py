"""Controllers of a scene whose equations have modes of contacts as states: none of them is told these."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.scene import Scene, read_text
from symdyn.simulation import Feedback, linear_law, simulate

pytestmark = pytest.mark.runs()

CART = """
gravity = [0, 0, -9.81]
[bodies.cart]
mass = 1
[bodies.pole]
mass = 0.2
com = [0, 0, 0.4]
inertia = [0.01, 0.01, 0]
inertia_about = "com"
[joints.rail]
type = "prismatic"
axis = [1, 0, 0]
parent = "ground"
child = "cart"
coordinate = "x"
drive = "F"
damping = 0.3
BESIDE
[joints.pivot]
type = "revolute"
parent = "cart"
child = "pole"
axis = [0, 1, 0]
coordinate = "theta"
drive = false
"""
BESIDE = {
    "a stop": "limits = { lower = -0.05, upper = 0.05, restitution = 0.4 }",
    "friction that sticks": "friction = { coulomb = 0.5 }",
}
GAINS = np.array([[-4.5, -47.0, -6.0, -10.0]])
STATES = ["x", "theta", "x_dot", "theta_dot"]
LAW = " + ".join(f"{-k}*{name}" for k, name in zip(GAINS[0].tolist(), STATES, strict=True))
STATIC = linear_law([], [], [], [[60.0, 8.0]], ["theta", "theta_dot"], "F")
CUT = {"F": 2.0}


@cache
def cart(which: str) -> Scene:
    return read_text(CART.replace("BESIDE", BESIDE[which]))


@cache
def by_formula(which: str, law: str, method: str) -> Any:
    return simulate(cart(which), forces={"F": law}, **asked(method))


def asked(method: str) -> dict[str, Any]:
    return {"until": 0.4, "start": {"theta": 0.1, "x_dot": 0.5}, "method": method, "rtol": 1e-9, "every": 0.02}


KINDS: dict[str, tuple[Callable[[], object], str]] = {
    "a matrix": (lambda: GAINS, LAW),
    "gains of a file": (lambda: {"K": GAINS.tolist(), "states": STATES, "inputs": ["F"]}, LAW),
    "a function": (lambda: Feedback(lambda t, q, u: -GAINS[0] @ np.concatenate([q, u]), "F"), LAW),
    "with limits": (lambda: Feedback(GAINS, "F", limits=CUT), f"max(-2, min(2, {LAW}))"),
    "static, of signals": (lambda: STATIC, "-60*theta - 8*theta_dot"),
}


@pytest.mark.wide(3)
@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.parametrize("which", BESIDE)
@pytest.mark.parametrize("kind", KINDS)
def test_a_law_is_the_formula_that_it_says_where_contacts_have_modes(kind: str, which: str, method: str) -> None:
    feedback, law = KINDS[kind]
    expected = by_formula(which, law, method)
    run = simulate(cart(which), feedback=feedback(), **asked(method))

    assert run.complete
    assert len(run.impacts) == len(expected.impacts)
    assert which != "a stop" or run.impacts
    assert np.abs(run.q - expected.q).max() < 1e-6
    assert np.abs(run["F"] - expected["F"]).max() < 1e-4


@pytest.mark.parametrize("which", BESIDE)
def test_a_law_with_states_is_the_scene_that_has_them(which: str) -> None:
    lead = linear_law(-20, 1, -1020.0, 60.0, "theta", "F")
    scene = read_text(CART.replace("BESIDE", BESIDE[which]) + '[states]\nz = { rate = "-20*z - theta", start = 0.0 }\n')
    options = asked("dop853")
    start = {**options.pop("start"), "z": float(lead.law.start[0, 0]) * -0.1}  # type: ignore[union-attr]

    expected = simulate(scene, forces={"F": "-1020*z - 60*theta"}, start=start, **options)
    run = simulate(cart(which), feedback=lead, **asked("dop853"))
    assert run.complete
    assert np.abs(run.q - expected.q).max() < 1e-6


@pytest.mark.parametrize("which", BESIDE)
def test_samples_are_of_the_state_alone_where_contacts_have_modes(which: str) -> None:
    lin = symdyn.linearize(read_text(CART.replace("BESIDE", "")))
    observer = lin.lqg({"x": 1, "theta": 10}, {"F": 0.5}, {"F": 0.5}, {"x": 1e-4, "theta": 1e-4}, period=0.02)
    for law in (Feedback(GAINS, "F", period=0.02), observer):
        run = simulate(cart(which), feedback=law, **asked("dop853"))
        assert run.complete
        held = {round(t, 6): F for t, F in zip(run.t[:-1].tolist(), run["F"].tolist(), strict=False)}
        if law is not observer:
            each = {round(t, 6): x for t, x in zip(run.t.tolist(), np.hstack([run.q, run.qd]).tolist(), strict=True)}
            assert all(pytest.approx(float(-GAINS[0] @ each[t]), abs=1e-7) == F for t, F in held.items())
        assert np.ptp(list(held.values())) > 0.1
