"""Motions of closed mechanisms against ones in numbers of 64 bits (data/closed_in_time.py), and closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from closed_mechanisms import n_four_bar
from oracles import oracle

from symdyn.bench.stress.scenes import pinned
from symdyn.scene import read
from symdyn.simulation import simulate

pytestmark = pytest.mark.runs()

ROOT = Path(__file__).parent.parent
MOTIONS = oracle("closed_in_time")["rows"]
METHODS = ("taylor", "dop853")

MUCH = 10.0
"""How many times another method's error a method may have that is asked for the same tolerance."""

LEAST = 1e-12
"""Errors of the size of coordinates and velocities that are rounding's."""


@pytest.fixture(autouse=True)
def _heyoka() -> None:
    pytest.importorskip("heyoka", reason="needs heyoka, the extra simulate")


def error(name: str, method: str, rtol: float) -> float:
    """Return the largest error of a run, over the size of every coordinate and velocity or 1."""
    row = MOTIONS[name]
    given = np.array(row["states"])
    every = row["until"] / len(given)
    found = simulate(
        read(ROOT / name),
        forces=row["forces"],
        until=row["until"],
        start=None,
        start_rates=row["rates"],
        method=method,
        rtol=rtol,
        every=every,
    )
    off = np.abs(np.hstack([found.q, found.qd])[1:] - given)
    assert row["sure"] < LEAST / 10
    return float((off / np.maximum(1.0, np.abs(given).max(axis=0))).max())


@pytest.mark.mends("30.numbers.3")
@pytest.mark.parametrize(
    "name", [pytest.param("examples/spatial_slider_crank.toml", marks=pytest.mark.slow), "examples/rssr.toml"]
)
def test_series_on_closed_loops_reach_what_is_asked_for(name: str) -> None:
    """What misses the loops by e is off by 4e6 e after 5 s of an RSSR: it cannot wait for a projection."""
    series, steps = (error(name, method, 1e-13) for method in METHODS)

    assert series < MUCH * max(steps, LEAST)
    assert series < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-8, 1e-10, 1e-12, 1e-13, 3e-14])
@pytest.mark.parametrize("name", MOTIONS)
def test_series_on_closed_loops_are_as_true_as_runge_and_kutta(name: str, rtol: float) -> None:
    series, steps = (error(name, method, rtol) for method in METHODS)

    assert series < MUCH * max(steps, LEAST)


@pytest.mark.parametrize("method", METHODS)
def test_closed_forms_are_met_to_the_last_tolerance(method: str) -> None:
    """IFToMM's A01 as a free body and a pin, and A02: the limit is ten times what DOP853 is off."""
    given = oracle("iftomm_closed_form")
    swung = simulate(pinned(), until=10.0, method=method, rtol=1e-13, every=0.01)
    chain = n_four_bar(2)
    rates = {velocity: "-1" if velocity.startswith("q_A") else "1" for velocity in chain.velocities}
    turned = simulate(chain, until=4.0, start_rates=rates, method=method, rtol=1e-13, every=0.5)

    for row in given["A01"]["rows"][:5]:
        k = int(np.argmin(np.abs(swung.t - float(row["t"]))))
        assert np.abs(swung.q[k, :2] - [float(row["x_start_plus1"]), float(row["y"])]).max() < 1e-10
    for row in given["A02_N2"]["rows"][:3]:
        k = int(np.argmin(np.abs(turned.t - float(row["t"]))))
        assert abs(np.cos(turned.q[k, 0]) - float(row["B0x"])) < 1e-11
        assert abs(np.sin(turned.q[k, 0]) - float(row["B0y"])) < 1e-11


@pytest.mark.slow
def test_the_last_row_of_a_run_is_its_end() -> None:
    """heyoka's clock has two doubles: a sum of 5,000 steps was an ulp behind the end, and made a row of its own."""
    row = MOTIONS["benchmarks/data/squeezer.toml"]
    found = simulate(
        read(ROOT / "benchmarks/data/squeezer.toml"),
        forces=row["forces"],
        until=0.3,
        method="taylor",
        rtol=2.3e-16,
        every=0.006,
    )

    assert len(found.t) == 51
    assert found.t[-1] == 0.3


def test_what_the_loops_keep_zero_is_no_event() -> None:
    """A residual is zero but for rounding, which every projection would turn round."""
    scene = read(ROOT / "examples/slider_crank.toml")
    found = simulate(scene, until=5.0, start_rates={"phi": "6"}, reports=["r*sin(phi) + l*sin(phi + psi)"])

    assert found.method == "taylor"
    assert found.events == ()
