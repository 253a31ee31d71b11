"""Derivatives that implicit methods ask for: exact from the graph, and when they are worth it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.scene import read
from symdyn.simulation import simulate
from symdyn.simulation.equations import implicit
from symdyn.simulation.equations.implicit import FEW, Implicit, differences, slopes, slopes_in_turn
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import importable

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"
RUBBING = "F=-5*tanh(x_dot/1e-4) + 8*sin(t)"


def cart(until: float, **more: object):
    scene = read(EXAMPLES / "cart_pole.toml")
    return simulate(scene, forces=RUBBING, until=until, start={"theta": "0.5"}, method="radau", every=until, **more)  # type: ignore[arg-type]


def test_exact_derivatives_are_made_for_long_runs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    kept = implicit.slopes
    monkeypatch.setattr(implicit, "slopes", lambda system: made.append(system.scene.name) or kept(system))

    cart(1e-3)
    assert made == []

    long = cart(3.0)
    assert made == ["cart_pole"]

    again = cart(3.0)  # now that all is compiled
    assert np.array_equal(long.q, again.q)
    assert long.steps == again.steps


@pytest.mark.heavy("rolling_disc")
@pytest.mark.parametrize("name", ["cart_pole", "four_bar", "heavy_top", "rolling_disc"])
def test_differences_and_exact_derivatives_agree(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    system, start = state_equations(scene), read_start(scene)
    x = np.concatenate([start.q, start.u, np.zeros(int(system.works))])

    slope = slopes_in_turn(system)
    first = slope(0.0, x)
    for _ in range(FEW - 1):
        slope(0.0, x)

    exact = slope(0.0, x)
    assert np.array_equal(exact, slopes(system)(0.0, x))
    assert np.array_equal(first, differences(system, 0.0, x, implicit.RELATIVE))
    assert np.abs(first - exact).max() < 1e-7 * max(1.0, np.abs(exact).max())


@pytest.mark.skipif(not importable("sksundae"), reason="needs the extra simulate")
def test_equations_with_multipliers_have_exact_derivatives_from_the_first_step_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene, asked = read(EXAMPLES / "four_bar.toml"), []
    kept = Implicit.slope
    monkeypatch.setattr(Implicit, "slope", lambda one, *at: asked.append(at[0]) or kept(one, *at))

    simulate(scene, until=0.1, method="ida", every=0.1)

    assert len(asked) > 2
