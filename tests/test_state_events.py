"""Resets of states: when they happen, what jumps, what is told, and how small changes go through them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symdyn
from symdyn.errors import MethodError
from symdyn.scene import Scene, read_text
from symdyn.simulation import METHODS
from symdyn.simulation.equations.events import saltation

OSCILLATOR = """
name = "counted"
units = "none"
[parameters]
p = 0.3
[bodies.bob]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "bob"
axis = [1, 0, 0]
coordinate = "x"
drive = false
force = "-x"
start = 1
[states.s]
rate = 1
reset = { when = "s - p", to = "s - p", way = "up" }
[states.both]
rate = 0
reset = { when = "x", to = "both + 1" }
[states.down]
rate = 0
reset = { when = "x", to = "down + both + 1", way = "down" }
"""


@pytest.fixture(scope="module")
def counted() -> Scene:
    return read_text(OSCILLATOR, "counted.toml")


@pytest.mark.runs("cc")
@pytest.mark.parametrize("method", [name for name, one in METHODS.items() if one.finds_events])
def test_every_method_that_finds_events_goes_on_behind_jumps(counted: Scene, method: str) -> None:
    if not METHODS[method].installed:
        pytest.skip(f"{method} is not installed")
    run = symdyn.simulate(counted, until=8, every=0.1, method=method)
    assert run.ended
    np.testing.assert_allclose(run["x"], np.cos(run.t), atol=2e-4)
    away = np.mod(run["s"] - run.t + 0.15, 0.3) - 0.15  # a saw tooth of 0.3 s
    np.testing.assert_allclose(away, 0, atol=1e-9)
    times = [one.t for one in run.events if one.formula == "reset of both: x"]
    np.testing.assert_allclose(times, np.pi * np.array([0.5, 1.5, 2.5]), atol=1e-4)
    assert run["both"][-1] == 3
    assert run["down"][-1] == 1 + 3  # at 1.5 π it passes upwards; what jumps at once sees what there was before


@pytest.mark.runs("cc")
def test_no_method_without_events_is_taken(counted: Scene) -> None:
    with pytest.raises(MethodError, match="gauss does not apply: it looks for no events"):
        symdyn.simulate(counted, until=1, method="gauss")


@pytest.mark.runs("cc")
def test_a_run_between_its_rows_jumps_too(counted: Scene) -> None:
    run = symdyn.simulate(counted, until=3, every=1, method="dop853")
    found = run([0.25, 0.35, 0.95, 2.5])
    np.testing.assert_allclose(found["s"], [0.25, 0.05, 0.05, 0.1], atol=1e-9)
    np.testing.assert_allclose(found["both"], [0, 0, 0, 1])


@pytest.mark.runs("cc")
def test_a_jump_may_pass_what_ends_the_run(counted: Scene) -> None:
    run = symdyn.simulate(counted, until=8, stops="both - 1.5", method="dop853")
    assert (run.stopped, run.events[-1].stops) == ("both - 1.5", True)
    np.testing.assert_allclose(run.t[-1], 1.5 * np.pi, atol=1e-8)


@pytest.mark.runs("cc")
@pytest.mark.parametrize("by", ["forward", "adjoint"])
def test_slopes_go_through_jumps(by: str) -> None:
    text = OSCILLATOR.replace('"s - p"', '"s - p*(1 + x/4)"').replace("rate = 1\n", 'rate = "1 + x/3"\n')
    scene = read_text(text.replace('force = "-x"', 'force = "-x + s/3"'), "counted.toml")
    found = symdyn.sensitivity(scene, until=1.2, parameters="p", by=by)

    def end(x: float = 1.0, s: float = 0.0, p: float = 0.3) -> Any:
        run = symdyn.simulate(scene, until=1.2, start={"x": x, "s": s}, values={"p": p}, rtol=1e-12, method="dop853")
        assert len(run.events) == 4
        return run[["x", "x_dot", "s"]][-1]

    h = 1e-6
    for name, ahead, behind in (
        ("x", end(x=1 + h), end(x=1 - h)),
        ("s", end(s=h), end(s=-h)),
        ("p", end(p=0.3 + h), end(p=0.3 - h)),
    ):
        np.testing.assert_allclose(
            [found[row, name] for row in ("x", "x_dot", "s")], (ahead - behind) / (2 * h), atol=2e-8
        )


@pytest.mark.runs("cc")
def test_what_comes_closer_and_closer_ends_the_run_in_words() -> None:
    text = OSCILLATOR.replace('to = "s - p"', 'to = "p - d"')
    halved = '[states.d]\nstart = 1\nrate = 0\nreset = { when = "s - p", to = "d/2", way = "up" }\n'
    told = "counted: reset of s, d: s - p comes again within the tolerance after t = 2.3 s"
    with pytest.warns(RuntimeWarning, match=told):
        run = symdyn.simulate(read_text(text + halved), until=3, method="dop853")
    np.testing.assert_allclose(run.t[-1], 2.3, atol=1e-9)  # 0.3 + 1 + 1/2 + 1/4 + ...


def test_resets_are_a_function_of_the_state(counted: Scene) -> None:
    found = symdyn.lambdify(counted, "resets")([2.0], [0.0], [0.75, 3.0, 5.0])
    np.testing.assert_allclose(found, [[0.45, 0.45, 3, 5], [2, 0.75, 4, 5], [2, 0.75, 3, 9]])


def test_a_touch_has_no_slope() -> None:
    slopes = np.eye(3, 3, -1)  # x = (x, v), nothing jumps; no parameter
    slopes[0] = [1, 0, -1]  # g = x - t
    assert saltation(slopes, np.array([1.0, 0.0]), np.array([1.0, 0.0])) is None
    found: Any = saltation(slopes, np.array([2.0, 0.0]), np.array([0.5, 0.0]))
    np.testing.assert_allclose(found, np.array([[1 - 1.5, 0], [0, 1]]))
