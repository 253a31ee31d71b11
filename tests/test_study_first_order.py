"""Error bars to first order: against differences of whole runs, against Monte Carlo, and where nothing is linear."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import symdyn
from symdyn.errors import SimulateError, SymdynError, UnknownNameError
from symdyn.simulation import Uncertainty

pytestmark = [pytest.mark.runs("cc"), pytest.mark.long]

HANGING = {"theta": "pi-0.4"}


def test_slopes_of_a_tree_are_those_of_runs_next_to_it() -> None:
    scene = symdyn.example("cart_pole")
    names, columns = ("mp", "l", "x", "theta_dot"), ("x", "theta", "theta_dot", "theta_ddot", "F", "kinetic_energy")
    forces = "F=0.3*cos(t)-0.2*x_dot-2*mc"
    found = symdyn.uncertainty(
        scene,
        dict.fromkeys(names, 0.01),
        forces=forces,
        until=2,
        start=HANGING,
        start_rates={"theta_dot": 0.5},
        columns=columns,
    )
    assert found.varied == names
    for k, name in enumerate(names):
        _slopes_next_to_it(scene, found, k, name, columns, forces)


def _slopes_next_to_it(
    scene: symdyn.Scene, found: Uncertainty, k: int, name: str, columns: tuple[str, ...], forces: str
) -> None:
    step, sides = 1e-5, []
    for sign in (1, -1):
        values = {name: 0.1 + sign * step if name == "mp" else 0.5 + sign * step} if name in ("mp", "l") else {}
        start = HANGING | ({name: sign * step} if name == "x" else {})
        rates = {"theta_dot": 0.5 + (sign * step if name == "theta_dot" else 0.0)}
        sides.append(
            symdyn.simulate(
                scene,
                forces=forces,
                until=2,
                start=start,
                start_rates=rates,
                method="dop853",
                rtol=1e-12,
                values=values,
                say=lambda _: None,
                every=0.01,
            )
        )
    for j, column in enumerate(columns):
        wanted = (sides[0][column] - sides[1][column]) / (2 * step)
        np.testing.assert_allclose(found.slopes[:, j, k], wanted, atol=2e-6 * max(1.0, np.abs(wanted).max()))


def test_slopes_of_a_closed_mechanism_are_those_of_runs_next_to_it() -> None:
    scene = symdyn.example("four_bar")
    found = symdyn.uncertainty(
        scene, {"a": 0.003, "m2": 0.01, "phi_dot": 0.1}, until=0.5, columns=["phi", "chi", "chi_dot"]
    )
    for k, name in enumerate(("a", "m2", "phi_dot")):
        step, sides = 1e-5, []
        for sign in (1, -1):
            values = {name: {"a": 1.0, "m2": 3.0}[name] + sign * step} if name != "phi_dot" else None
            rates = {"phi_dot": float(found.run["phi_dot"][0]) + sign * step * (name == "phi_dot")}
            start = {"phi": float(found.run["phi"][0])}
            run = symdyn.simulate(
                scene, until=0.5, start=start, start_rates=rates, method="dop853", rtol=1e-12, values=values,
                say=lambda _: None,
            )  # fmt: skip
            sides.append(run)
        for j, column in enumerate(found.names):
            wanted = (sides[0][column] - sides[1][column]) / (2 * step)
            np.testing.assert_allclose(found.slopes[:, j, k], wanted, atol=1e-5 * max(1.0, np.abs(wanted).max()))


def test_monte_carlo_finds_the_same_standard_deviations() -> None:
    scene, over = symdyn.example("cart_pole"), {"mp": 0.001, "l": 0.001, "theta_dot": 0.002}
    columns = ("x", "theta")
    found = symdyn.uncertainty(scene, over, until=2, start=HANGING, columns=columns)
    generator, n = np.random.default_rng(1), 1000
    mp, length, rate = (generator.normal(mean, sd, n) for mean, sd in zip((0.1, 0.5, 0.0), over.values(), strict=True))
    runs = symdyn.ensemble(
        scene, until=2, start=HANGING, start_rates={"theta_dot": rate}, values={"mp": mp, "l": length},
        measures=[f"end({name})" for name in columns],
    )  # fmt: skip
    for name in columns:
        assert float(np.std(runs[f"end({name})"])) == pytest.approx(float(found[f"sd_{name}"][-1]), rel=0.07)


@pytest.mark.slow
def test_monte_carlo_finds_the_same_where_loops_close() -> None:
    scene, n = symdyn.example("four_bar"), 300
    found = symdyn.uncertainty(scene, {"a": 0.003, "b": 0.009, "m2": 0.1}, until=1, columns=["phi", "phi_dot"])
    generator = np.random.default_rng(2)
    drawn = {name: generator.normal(*of, n) for name, of in (("a", (1, 0.003)), ("b", (3, 0.009)), ("m2", (3, 0.1)))}
    runs = symdyn.ensemble(scene, until=1, values=drawn, measures=["end(phi)", "end(phi_dot)"])
    for name in found.names:
        assert float(np.std(runs[f"end({name})"])) == pytest.approx(float(found[f"sd_{name}"][-1]), rel=0.12)


def test_forces_of_a_motion_have_the_variance_that_their_formula_says() -> None:
    found = symdyn.uncertainty(
        symdyn.example("cart_pole"),
        {"mc": 0.1, "mp": "uniform(0.05, 0.15)"},
        motion=["x=t**2", "theta=0"],
        times=[0.0, 1.0],
        columns="F",
    )  # fmt: skip  F = 2 (mc + mp) + 2 b t, with theta at rest
    np.testing.assert_allclose(found["sd_F"], np.full(2, 2 * np.hypot(0.1, 0.1 / np.sqrt(12))), rtol=1e-9)
    np.testing.assert_allclose(found.shares("F").sum(axis=1), 1.0)
    np.testing.assert_allclose(found.shares("F")[0, 0], 12 / 13, rtol=1e-8)
    assert found.run["F"].tolist() == pytest.approx([2.2, 2.4])


@pytest.mark.parametrize("law", ["phi=1+t", "chi=2.0255+0.05*t"])
def test_forces_of_a_closed_mechanism_hold_the_coordinate_whose_motion_is_given(law: str) -> None:
    scene, times = symdyn.example("four_bar"), [0.0, 0.1, 0.2]
    base = symdyn.inverse(scene, law, times)
    found = symdyn.uncertainty(scene, {"a": 0.01, "m3": 0.1}, motion=law, times=times)
    drive = next(name for name in found.names if np.any(base[name]))
    assert not [note for note in found.notes if drive in note], "by its own output"
    for k, (name, value) in enumerate((("a", 1.0), ("m3", 3.5))):
        sides = [symdyn.inverse(scene, law, times, values={name: value + s * 1e-5}) for s in (1, -1)]
        wanted = (sides[0][drive] - sides[1][drive]) / 2e-5
        np.testing.assert_allclose(found.slopes[:, found.names.index(drive), k], wanted, rtol=1e-5, atol=1e-5)


def test_other_columns_of_a_motion_are_told_by_differences_and_it_is_said() -> None:
    found = symdyn.uncertainty(
        symdyn.example("cart_pole"),
        {"mc": 0.1},
        motion=["x=t**2", "theta=0"],
        times=[0.0, 1.0],
        columns=["drive_power"],
    )
    assert found["sd_drive_power"].tolist() == pytest.approx([0.0, 0.4])
    assert "by differences, not by derivatives: drive_power" in found.notes


def test_correlation_adds_or_takes_away() -> None:
    scene = symdyn.example("cart_pole")
    motion: Mapping[str, object] = {"motion": ["x=t**2", "theta=0"], "times": [0.0, 1.0], "columns": "F"}
    for rho, wanted in ((1.0, 0.4), (-1.0, 0.0), (0.0, 0.2 * np.sqrt(2))):
        C = 0.01 * np.array([[1, rho], [rho, 1]])
        found = symdyn.uncertainty(scene, ["mc", "mp"], covariance=C, **motion)  # type: ignore[arg-type]
        assert float(found["sd_F"][0]) == pytest.approx(wanted, abs=1e-9)


def test_what_cannot_be_is_refused_in_words_all_at_once() -> None:
    scene = symdyn.example("cart_pole")
    with pytest.raises(SimulateError) as told:
        symdyn.uncertainty(scene, {"mq": 0.1, "mp": -1.0, "l": "normal(1, sigma=-1)"})
    assert len(told.value.faults) == 3
    assert "mq is no parameter, and no position or velocity" in str(told.value)
    assert "over mp: -1 is no standard deviation" in str(told.value)
    assert "sigma = -1 is negative" in str(told.value)
    for given, words in (
        ([[1, 0]], "square matrix"), ([[1, 2], [0, 1]], "not symmetric"), ([[1, 2], [2, 1]], "negative eigenvalue"),
        (np.eye(3), "is 3 × 3, of 2 names"), ("no", "no matrix"),
    ):  # fmt: skip
        with pytest.raises(SimulateError, match=words):
            symdyn.uncertainty(scene, ["mc", "mp"], covariance=given)  # type: ignore[arg-type]
    with pytest.raises(SimulateError, match="nothing is varied, and no parameter of cart_pole has a tolerance"):
        symdyn.uncertainty(scene, {})
    with pytest.raises(SimulateError, match="theta is given by the motion"):
        symdyn.uncertainty(scene, {"theta": 0.1}, motion="x=t", times=[0, 1])
    with pytest.raises(SimulateError, match="psi at the start follows others"):
        symdyn.uncertainty(symdyn.example("four_bar"), {"psi": 0.1}, until=0.1)
    with pytest.raises(SimulateError, match="sign jumps"):
        symdyn.uncertainty(scene, {"mp": 0.1}, forces="F=-sign(x_dot)", until=0.1)
    with pytest.raises(SymdynError, match="there is no column thetaa"):
        symdyn.uncertainty(scene, {"mp": 0.1}, until=0.1, columns="thetaa")
    found = symdyn.uncertainty(scene, {"mp": 0.1}, until=0.1, columns="theta")
    with pytest.raises(UnknownNameError, match="no uncertainty of 'x'"):
        found["x"]


def test_tables_and_pictures_of_error_bars(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    found = symdyn.uncertainty(symdyn.example("cart_pole"), {"mp": 0.01, "theta": 0.02}, until=1, start=HANGING)
    assert found.to_csv(tmp_path / "found.csv") == str(tmp_path / "found.csv")
    assert found.to_csv().splitlines()[0].startswith("t,x,sd_x,theta,sd_theta")
    frame = pandas.read_csv(tmp_path / "found.csv")
    assert np.array_equal(frame["sd_theta"], found["sd_theta"])
    assert np.array_equal(frame["theta"], found["theta"])  # which was the standard deviation
    assert np.array_equal(found["theta"], found.run["theta"])
    assert found.to_pandas().attrs["units"]["sd_theta_dot"] == "rad/s"
    assert found.drawn("svg") == found.drawn("svg")
    assert "image/svg+xml" in found.plot("theta")._repr_mimebundle_()  # type: ignore[attr-defined]
