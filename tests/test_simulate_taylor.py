"""heyoka's Taylor method where it could go wrong: what its series overlooks, ends of motions, events, repetition."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scenes_in_time import block, pendulum

from symdyn.scene import Scene
from symdyn.simulation import Trajectory, read_forces, simulate
from symdyn.simulation.integrate.taylor import SAMPLES, STRETCH, Guard

pytestmark = pytest.mark.runs()

pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")


RUBBING = block("friction = { coulomb = 1.0, smoothing = 0.001 }")


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12, 1e-15])
def test_smoothed_friction_is_not_stepped_over(rtol: float) -> None:
    reference = simulate(RUBBING, until=2.0, method="lsoda", rtol=1e-12)
    found = simulate(RUBBING, until=2.0, method="taylor", rtol=rtol)

    assert np.abs(found.q - reference.q).max() < max(1e-8, 100 * rtol)
    assert np.abs(found.qd - reference.qd).max() < max(1e-7, 1000 * rtol)


def test_unguarded_it_would_be() -> None:
    """The reason for the guard, so that nobody takes it away."""
    before = Guard.holds
    try:
        Guard.holds = lambda *_: True  # type: ignore[method-assign, assignment]
        wrong = simulate(RUBBING, until=2.0, method="taylor", rtol=1e-12)
    finally:
        Guard.holds = before  # type: ignore[method-assign]
    reference = simulate(RUBBING, until=2.0, method="lsoda", rtol=1e-12)

    assert np.abs(wrong.q - reference.q).max() > 1e-3
    assert wrong.monitors["energy"] < 1e-6  # the balance does not tell: work is done along the same steps


def test_every_function_that_heyoka_is_asked_for_is_there() -> None:
    law = "F=sin(x) + cos(x) + exp(-x) + sqrt(2 + x) + log(3 + x) + tanh(x) + atan2(x, 2) + (2 + x)**0.7"
    found, other = (
        simulate(block(), forces=read_forces(block(), [law]), until=1.0, method=method, rtol=1e-11)
        for method in ("taylor", "dop853")
    )

    np.testing.assert_allclose(found.q, other.q, rtol=0, atol=1e-9)


def test_unasked_another_method_is_taken_there() -> None:
    lines: list[str] = []
    found = simulate(RUBBING, until=0.1, say=lines.append)

    assert found.method == "dop853"
    assert "a series may overlook a turn of tanh" in lines[0]


@pytest.mark.parametrize("scene", [pendulum, lambda: RUBBING], ids=["straight", "guarded"])
def test_the_same_run_is_the_same_text(scene: Callable[[], Scene]) -> None:
    """Steps depend on no clock."""
    runs = [simulate(scene(), until=20.0, method="taylor").to_csv() for _ in range(2)]

    assert runs[0] == runs[1]


@pytest.mark.parametrize("samples", [SAMPLES, 50])
def test_stretches_are_joined_without_a_seam(samples: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symdyn.simulation.integrate.taylor.SAMPLES", samples)
    found = simulate(block(), until=200.0, method="taylor", rtol=1e-15)

    assert found.steps > 2 * STRETCH
    assert len(found.t) == 201
    assert found.q[:, 0] == pytest.approx(0.5 * np.cos(5 * found.t), abs=1e-11)


@pytest.mark.parametrize("every", [None, 0.01, 10.0])
@pytest.mark.parametrize(
    ("force", "end"), [("F=sqrt(x)", 0.24), ("F=1e5*x**3", 0.0165)], ids=["no real value", "no finite value"]
)
def test_a_motion_that_ends_keeps_what_it_had(force: str, end: float, every: float | None) -> None:
    found, other = (
        simulate(block(), forces=read_forces(block(), [force]), until=20.0, method=method, every=every)
        for method in ("taylor", "dop853")
    )

    assert "or a formula has no real value, after t = " in found.stopped
    assert f"after t = {found.t[-1]:g} s" in found.stopped
    assert found.t[-1] == pytest.approx(other.t[-1], rel=1e-4)
    assert len(found.t) == len(other.t)
    assert np.all(np.isfinite(found.table()[1][:-1]))
    assert found.t[-1] > end


@pytest.mark.parametrize("method", ["taylor", "dop853"])
def test_what_is_zero_at_the_start_stops_nothing(method: str, capfd: pytest.CaptureFixture[str]) -> None:
    found = simulate(block(start=0.1), until=1.0, method=method, stops=["x - 0.1"])
    later = simulate(block(start=0.1), until=1.0, method=method, stops=["x"], reports=["x_dot", "x - 0.05"])

    assert found.stopped == "end"
    assert later.t[-1] == pytest.approx(np.pi / 10, rel=1e-8)
    assert later.q[-1, 0] == pytest.approx(0, abs=1e-9)
    assert [event.formula for event in later.events] == ["x - 0.05", "x"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_the_last_row_of_a_stopped_run_is_the_event(method: str) -> None:
    found: Trajectory = simulate(block("friction = { coulomb = 0.5, smoothing = 0.01 }"), until=9.0, method=method,
                                 stops=["x + 0.2"])  # fmt: skip

    assert found.t[-1] == found.events[-1].t
    assert found.q[-1, 0] == pytest.approx(-0.2, abs=1e-9)
    assert np.all(np.diff(found.t) > 0)
