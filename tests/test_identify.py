"""Identification: what was put into a log comes out again, and what a log cannot tell is told."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import symdyn
from symdyn.algebra import Floats
from symdyn.cli import main
from symdyn.dynamics import Workspace
from symdyn.dynamics.mechanism.tree import body_inertia
from symdyn.dynamics.outputs import BaseColumns
from symdyn.errors import IdentifyError
from symdyn.graph import evaluate
from symdyn.identification.linear_model import TERMS, base_frames, linear_model, with_terms
from symdyn.identification.regression import Rows, solve
from symdyn.scene import Scene, bind
from symdyn.scene.forces import FORCES
from symdyn.scene.values.joint import Limits
from symdyn.scene.values.quantity import Quantity

EXAMPLES = Path(__file__).parent.parent / "examples"
pytestmark = [pytest.mark.runs("cc")]

Capture = pytest.CaptureFixture[str]

MOTION = {
    "q1": "sin(2*t) + 0.4*cos(5*t)",
    "q2": "0.8*sin(3*t) - 0.4*cos(1.7*t)",
    "q3": "0.1*sin(3.3*t) + 0.05*cos(2.1*t)",
    "q4": "sin(4*t)",
}


USUAL = {"origin": "0, 0, 0", "x": "1, 0, 0", "z": "0, 0, 1"}
"""Of the frame of a body."""


def scara() -> Scene:
    return symdyn.read(EXAMPLES / "scara.toml")


def log(scene: Scene, motion: Mapping[str, str] = MOTION, until: float = 10, count: int = 2001) -> dict[str, Any]:
    run = symdyn.inverse(scene, motion, np.linspace(0, until, count))
    return {name: np.array(run[name]) for name in ("t", *scene.coordinates, *filter(None, scene.drives))}


def noisy(data: dict[str, Any], seed: int, force: float, place: float = 1e-5) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    size = {name: force * np.std(x) if name.startswith("tau") else place for name, x in data.items()}
    return {n: x if n == "t" else x + size[n] * rng.normal(size=len(x)) for n, x in data.items()}


def heavier(scene: Scene) -> Scene:
    """Return the scene with other friction and drives than it declares, by the names that identification gives."""
    opened = with_terms(scene, tuple(TERMS))
    return bind(opened, {"fv1": 1.5, "fc1": 2.5, "f02": 0.3, "fc3": 0.7, "Ia2": 0.02})


def test_a_log_without_noise_gives_back_what_made_it() -> None:
    found = symdyn.identify(scara(), log(scara()))

    assert found.not_identifiable == ()
    assert found.regression.condition < 10
    np.testing.assert_allclose(found.after, found.before, atol=2e-4)
    assert all(one.percent < 0.01 for one in found.fits)


@pytest.mark.parametrize("name", ["arm7", "puma560", "scara", "spatial_3r"])
def test_moments_of_the_last_body_are_those_in_the_frame_that_is_told(name: str) -> None:
    scene = symdyn.read(EXAMPLES / f"{name}.toml")
    scene = bind(scene, {one.name: 0.3 + 0.1 * n for n, one in enumerate(scene.free_parameters)})
    k, (body, joint, place) = [*base_frames(scene).items()][-1]
    said = dict(re.findall(r"(\w+)(?: along)? \(([^)]*)\)", place))
    p, x, z = (np.array(said.get(what, usual).split(", "), dtype=float) for what, usual in USUAL.items())

    w = Workspace(scene)
    known = {w.graph.symbol(one.name): float(one.value.at({})) for one in scene.parameters}
    last = body_inertia(scene.bodies[-1], w.graph)
    own = [float(one) for one in evaluate([last.m, *last.h], Floats(), known)]
    named = dict(zip(BaseColumns.of(w).names, evaluate(BaseColumns.of(w).values(), Floats(), known), strict=True))

    assert (body, joint) == (scene.bodies[-1].name, scene.joints[-1].name)
    first = np.array(own[1:]) - own[0] * p
    for axis, way in (("x", x), ("y", np.cross(z, x))):  # a column that nothing feels is none
        assert float(named.get(f"m{axis}{k}", 0.0)) == pytest.approx(first @ way, abs=1e-6)


def test_frames_of_base_parameters_are_told_where_base_parameters_are() -> None:
    v = {"m1": 1, "m2": 1, "h1": 0.4, "h2": 0.3, "g": 9.81}
    arm = symdyn.example("two_link")
    run = symdyn.inverse(arm, {"q1": "sin(t)", "q2": "cos(1.3*t)"}, np.linspace(0, 10, 501), values=v)
    found = symdyn.identify(arm, run, values=v)

    assert found.frames == {
        "R1": ("link1", "shoulder", "x along (0, 1, 0)"),
        "R2": ("link2", "elbow", "x along (0, 1, 0)"),
    }
    assert repr(found).endswith("; .frames tells what R1 is>")
    assert [" ".join(row) for row in found.tables[1]][1] == "R2 link2 elbow x along (0, 1, 0)"
    assert "in the frame of the body" in symdyn.identification.report(found)
    assert found.as_dict()["frames"]["R1"] == ("link1", "shoulder", "x along (0, 1, 0)")


@pytest.mark.parametrize("seconds", [0.0, 0.006, -0.04])
def test_a_delay_of_forces_is_estimated_and_told_where_it_is_one(seconds: float) -> None:
    scene, t = scara(), np.linspace(1, 11, 1001)
    here, later = (symdyn.inverse(scene, MOTION, one) for one in (t, t - seconds))
    drives = [name for name in scene.drives if name]
    data = {"t": t, **{name: here[name] for name in scene.coordinates}, **{name: later[name] for name in drives}}
    found = symdyn.identify(scene, noisy(data, 4, 0.02))
    value, error = found.delay

    assert 1e-5 < error < 2e-4
    assert abs(value - seconds) < 4 * error
    assert found.as_dict()["delay"] == {"value": value, "standard_error": error}
    told = [note for note in found.notes if "driving forces came" in note]
    assert [("after" in note, "before" in note) for note in told] == [(seconds > 0, seconds < 0)] * (seconds != 0)


@pytest.mark.wide(2)
@pytest.mark.parametrize("samples", [0, 4])
def test_noise_of_positions_makes_no_delay_of_forces(samples: int) -> None:
    """Up to 60 standard errors off, with a slope of the forces that were computed from noisy positions."""
    values = {"m1": 2.5, "m2": 1.4, "h1": 0.4, "h2": 0.3, "g": 9.81}
    scene, every = bind(symdyn.example("two_link"), values), 0.002
    run = symdyn.simulate(scene, until=6, every=every, forces="M1=6*sin(2*t)+4*cos(5*t), M2=2*sin(3*t)+1.5*cos(7*t)")
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        data = {name: run[name] + 5e-5 * rng.normal(size=len(run.t)) for name in scene.coordinates}
        data |= {name: np.roll(run[name], samples) + 0.03 * rng.normal(size=len(run.t)) for name in ("M1", "M2")}
        found = symdyn.identify(
            scene, {"t": run.t[samples:], **{k: x[samples:] for k, x in data.items()}}, friction="coulomb"
        )
        value, error = found.delay

        assert abs(value - samples * every) < 3 * error < 0.001
        assert any("driving forces came" in note for note in found.notes) == (samples > 0)


@pytest.mark.parametrize("band", [0.4, 0.8])
def test_a_band_below_the_motion_pulls_nothing_and_is_told(band: float) -> None:
    """Positions were kept up to the band alone: 4 standard errors off where the motion was faster."""
    data = noisy(log(scara(), until=20), 2, 0.02)
    found, whole = symdyn.identify(scara(), data, band=band), symdyn.identify(scara(), data)
    z = (found.after - found.before) / found.errors

    assert np.sqrt(np.mean(z**2)) < 1.7
    assert (found.errors < 0.004).all()
    assert abs(found.delay[0]) < 4 * found.delay[1]
    assert f"Hz, above the band of {band} Hz: what forces tell there is not used" in found.notes[0]
    assert not whole.notes


def test_each_of_several_logs_has_its_own_delay_and_one_at_rest_none() -> None:
    scene, t = symdyn.example("pendulum"), np.linspace(0, 8, 401)
    motion = "q1=sin(t)+0.4*sin(2.7*t)"
    here, later = (symdyn.inverse(scene, motion, times=one) for one in (t, t - 0.05))
    logs = [{"t": t, "q1": here["q1"], "tau1": tau} for tau in (here["tau1"], later["tau1"])]
    found = symdyn.identify(scene, logs)
    rest = symdyn.identify(scene, {"t": t, "q1": 0.3 + 0 * t, "tau1": 1.2 + 0 * t})

    (told,) = (note for note in found.notes if "driving forces came" in note)
    assert "came 50 ms after" in told
    assert rest.delay[0] == 0
    assert np.isnan(rest.delay[1])


def test_friction_that_a_scene_lacks_is_told_beside_its_inertias() -> None:
    true = heavier(scara())
    found = symdyn.identify(scara(), noisy(log(true), 3, 0.02), friction=("viscous", "coulomb", "armature"))

    for name, value in {"fv1": 1.5, "fc1": 2.5, "fc3": 0.7}.items():
        place = found.names.index(name)
        assert found.before[place] == 0.0
        assert abs(found.after[place] - value) < 4 * found.errors[place] < 0.2


@pytest.mark.slow  # test_identify_coverage.py holds that the truth is inside, in every run
def test_an_interval_is_as_wide_as_it_says() -> None:
    """Twenty logs of a SCARA: the squares of errors over standard errors have the mean of their distribution."""
    scene, data = scara(), log(scara())
    runs = [symdyn.identify(scene, noisy(data, seed, 0.1)) for seed in range(20)]
    off = np.array([one.after - one.before for one in runs])
    z = off / np.array([one.errors for one in runs])
    joint = [d @ one.regression.information @ d for d, one in zip(off, runs, strict=True)]

    assert 0.6 < np.mean(z**2) < 1.5  # 160 of mean one
    assert 0.7 < np.mean(joint) / len(runs[0].names) < 1.4
    inside = [(one.interval()[:, 0] <= one.before) & (one.before <= one.interval()[:, 1]) for one in runs]
    assert 0.88 <= np.mean(inside) <= 0.995


def test_rows_that_the_estimate_follows_say_nothing_about_noise() -> None:
    """Eight slow rows tell a parameter each, so that nothing of them is left: noise is that of the other rows, 1."""
    count, p = 60, 8
    f = np.asarray(0.05 * np.arange(count), dtype=np.float64)
    tau = np.random.default_rng(1).normal(size=count)
    rows = Rows(np.eye(count, p), tau, np.zeros(count, int), f, np.arange(count))
    found = solve([f"b{k}" for k in range(p)], rows, np.zeros(p), 3.0, 1)

    np.testing.assert_allclose(found.errors, np.sqrt(np.mean(tau[p:] ** 2)), rtol=0.05)


def test_a_joint_that_never_moves_is_named_and_keeps_what_the_scene_says() -> None:
    still = {**MOTION, "q1": "0.2"}
    found = symdyn.identify(scara(), noisy(log(scara(), still), 1, 0.01))
    said = " ".join(one.words for one in found.not_identifiable)

    assert "q1 never moves" in said
    assert "move q1" in said
    assert any("JxxR1 + JyyR1" in one.parameters for one in found.not_identifiable)
    place = found.names.index("mR3")
    assert found.regression.identifiable[place]
    assert abs(found.after[place] - found.before[place]) < 4 * found.errors[place] < 1e-2


@pytest.mark.parametrize("seed", range(2, 6))
def test_a_joint_that_never_moves_takes_no_other_parameter_with_it(seed: int) -> None:
    """What chance mixes into a column of noise is cleared: all but the inertia of the joint is told."""
    found = symdyn.identify(scara(), noisy(log(scara(), {**MOTION, "q1": "0.2"}), seed, 0.01))

    assert [one.combination for one in found.not_identifiable] == ["JxxR1 + JyyR1"]
    told = found.regression.identifiable
    assert list(told) == [False] + [True] * 7
    assert np.all(np.abs(found.after - found.before)[told] < 4.5 * found.errors[told])


def test_what_two_columns_of_noise_truly_share_stays_together() -> None:
    """One signal in two columns with noise of their own: their sum is told, their difference is not."""
    rng = np.random.default_rng(4)
    one, other, *draws = rng.normal(size=(5, 400))
    noise = 1e-3 * np.stack([draws[0], np.zeros(400), np.zeros(400)], axis=1)
    Y = np.stack([one, one, other], axis=1) + noise
    buried = 1e-3 * np.stack([draws[1], np.zeros(400), np.zeros(400)], axis=1)
    tau = one * 3 + other + draws[2]
    found = solve(("a", "b", "c"), Rows(Y, tau, *rows_of(400), buried), np.array([1, 1, 1]), 10, 1)

    assert list(found.identifiable) == [False, False, True]
    assert abs(found.estimate[0] + found.estimate[1] - 3) < 0.2
    assert abs(found.estimate[0] - found.estimate[1]) < 1e-2


def test_what_no_motion_tells_apart_is_told_so() -> None:
    found = symdyn.identify(scara(), log(scara()), friction=tuple(TERMS))

    assert len(found.not_identifiable) == 1
    assert found.not_identifiable[0].why == "no motion separates them"
    assert {"mR3", "f03", "Ia3"} <= set(found.not_identifiable[0].parameters)
    np.testing.assert_allclose(found.after[found.names.index("mR3")], 1.5, atol=1e-3)


def test_the_bound_of_the_ellipsoid_is_that_of_its_distribution() -> None:
    """Noise known from many rows: chi-square; from few: Hotelling's, by F, and a sum of such for several joints."""
    few = solve(("a",), Rows(np.ones((9, 1)), np.arange(9.0), *rows_of(9)), np.zeros(1), 1.0, 1)
    rng = np.random.default_rng(0)
    for shares in [((4.0, 1e7),), ((8.0, 20.0),), ((3.0, 15.0), (5.0, 60.0), (0.0, 0.0))]:
        draws = sum(k * rng.f(k, n, 200000) for k, n in shares if k)
        assert abs(np.mean(draws <= replace(few, shares=np.array(shares)).reach(0.95)) - 0.95) < 0.006
    np.testing.assert_allclose(replace(few, shares=np.array([[4.0, 1e7]])).reach(0.9), chi2.ppf(0.9, 4), rtol=1e-5)
    assert replace(few, shares=np.zeros((1, 2))).reach() == 0


def rows_of(count: int) -> tuple[Any, Any, Any]:
    """Return joint, frequency and group of rows of one joint."""
    return np.zeros(count, np.int64), np.arange(count) / count, np.arange(count)


def test_samples_where_a_joint_stands_are_told() -> None:
    true = heavier(scara())
    found = symdyn.identify(scara(), noisy(log(true), 3, 0.02, 1e-4), friction=("coulomb",))
    (note,) = [one for one in found.notes if "left out where a joint stands" in one]

    assert "% of tau1" in note
    assert not any("stands" in one for one in symdyn.identify(scara(), noisy(log(scara()), 3, 0.02, 1e-4)).notes)


@pytest.mark.parametrize("motion", ["q1=sin(2*t)+0.4*cos(5*t)", "q1=0.3*sin(t)+0.1*cos(3*t)"])
def test_friction_whose_jump_is_smooth_is_found_from_speeds_beyond_it(motion: str) -> None:
    bare = symdyn.example("pendulum")
    (joint,) = bare.joints
    dry = FORCES["friction"].noun(
        joint.name, Quantity.number(Fraction(2, 5)), smoothing=Quantity.number(Fraction(1, 50))
    )
    run = symdyn.inverse(replace(bare, joints=(replace(joint, dry=dry),)), motion, np.linspace(0, 10, 2001))
    for noise, off in ((0.0, 1e-5), (0.02, 0.005)):
        force = run["tau1"] + noise * np.random.default_rng(0).normal(size=len(run.t))
        found = symdyn.identify(bare, {"t": run.t, "q1": run["q1"], "tau1": force}, friction="coulomb")
        place = found.names.index("fc1")

        assert abs(found.after[place] - 0.4) < max(3 * found.errors[place], off) < 0.02
        assert any("left out where a joint stands or creeps" in note for note in found.notes)


def test_samples_that_nothing_explains_are_left_out_and_told() -> None:
    data = noisy(log(scara()), 3, 0.02)
    data["tau2"] = data["tau2"].copy()
    data["tau2"][700:704] += 300.0
    found = symdyn.identify(scara(), data)
    kept = symdyn.identify(scara(), data, outliers=False)

    (one,) = found.outliers
    assert (one.drive, one.samples) == ("tau2", 4)
    assert 3.4 < one.start < one.end < 3.6
    assert any("tau2 at t = 3.5" in note for note in found.notes)
    right = found.before
    assert np.linalg.norm(found.after - right) < 0.5 * np.linalg.norm(kept.after - right)
    assert np.linalg.norm(kept.errors) > 2 * np.linalg.norm(found.errors)


def test_the_verb_leaves_out_what_nothing_explains_unless_it_is_kept(tmp_path: Path, capsys: Capture) -> None:
    data = noisy(log(scara(), count=1001), 5, 0.02)
    data["tau2"][350:352] += 300.0
    file = tmp_path / "log.csv"
    np.savetxt(file, np.column_stack([*data.values()]), "%.17g", ",", header=",".join(data), comments="")
    told = []
    for more in ([], ["--keep-outliers"]):
        assert main(["identify", str(EXAMPLES / "scara.toml"), str(file), *more]) == 0
        told.append("tau2 at t = 3.5" in "".join(capsys.readouterr()))

    assert told == [True, False]


def test_data_that_were_held_back_judge_the_fit() -> None:
    found = symdyn.identify(scara(), noisy(log(scara()), 2, 0.1), hold_back=0.25)

    assert 0.2 < found.validation[0].mean() < 0.3
    for one in found.fits:
        assert 0.5 < one.validation / one.error < 2
        assert one.validation_percent == pytest.approx(one.percent * one.validation / one.error)


def test_a_gap_in_time_parts_a_log() -> None:
    data = log(scara())
    keep = np.r_[0:700, 900:2001]
    found = symdyn.identify(scara(), {name: x[keep] for name, x in data.items()})

    assert len(found.motions) == 2
    assert any("a gap from t = 3.495 s to 4.5 s" in note for note in found.notes)
    np.testing.assert_allclose(found.after, found.before, atol=2e-4)


def test_what_is_too_short_between_two_gaps_is_left_out_alone() -> None:
    data = log(scara())
    keep = np.r_[0:700, 900:910, 1100:2001]
    found = symdyn.identify(scara(), {name: x[keep] for name, x in data.items()})

    assert len(found.motions) == 2
    assert any("t = 4.5 s to 4.545 s is too short for a band" in note for note in found.notes)


def test_uneven_times_are_made_even_and_told() -> None:
    run = log(scara(), count=4001)
    rng = np.random.default_rng(0)
    keep = np.sort(rng.choice(4001, 2800, replace=False))
    found = symdyn.identify(scara(), {name: x[keep] for name, x in run.items()})

    assert any("interpolated" in note for note in found.notes)
    np.testing.assert_allclose(found.after, found.before, atol=5e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"q1_dot": ("q1", 180 / np.pi)}, 'q1_dot looks like deg/s; units={"q1_dot": "deg/s"}'),
        ({"q1_dot": ("q1", 1000.0)}, "one of the two is off by 1000"),
        ({"q1_dot": ("q1", -1.0)}, "has the other sign"),
        ({"q3_dot": ("q3", 1000.0)}, "q3_dot looks like mm/s"),
    ],
)
def test_velocities_betray_their_units(change: dict[str, tuple[str, float]], words: str) -> None:
    data = log(scara())
    data |= {f"{name}_dot": np.gradient(data[name], data["t"]) for name in scara().coordinates}
    for name, (of, factor) in change.items():
        data[name] = factor * np.gradient(data[of], data["t"])

    with pytest.raises(IdentifyError, match=words):
        symdyn.identify(scara(), data)


def test_times_in_milliseconds_are_named_and_can_be_said() -> None:
    data = log(scara())
    data |= {f"{name}_dot": np.gradient(data[name], data["t"]) for name in scara().coordinates}
    data["t"] = 1000 * data["t"]

    with pytest.raises(IdentifyError, match=r'all velocities are 1000 times .* units={"t": "ms"} gives it'):
        symdyn.identify(scara(), data)
    assert symdyn.identify(scara(), data, units={"t": "ms"}).fits[0].percent < 1


def test_degrees_are_told_from_limits_and_thousandths_from_the_scene() -> None:
    scene = scara()
    data = log(scene)
    first, *others = scene.joints
    limited = replace(scene, joints=(replace(first, limits=Limits(Quantity.number(-2), Quantity.number(2))), *others))
    with pytest.raises(IdentifyError, match=r"q1 goes to 78\.\d+, its joint to 2 rad: it looks like deg"):
        symdyn.identify(limited, {**data, "q1": np.degrees(data["q1"])})
    off = symdyn.identify(scene, {**data, "tau1": 1000 * data["tau1"]})
    assert any("tau1 is 1000 times what the scene expects: it looks like mNm" in note for note in off.notes)
    fitted = symdyn.identify(scene, {**data, "tau1": 1000 * data["tau1"]}, units={"tau1": "mNm"})
    np.testing.assert_allclose(fitted.after, fitted.before, atol=2e-4)


def test_all_faults_of_a_log_are_told_together(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,q1,q2,q3,theta4,tau_1,tau2,tau3,tau4\n" + "".join(f"{k},0,0,0,0,0,0,0,0\n" for k in range(5)))

    assert main(["identify", str(EXAMPLES / "scara.toml"), str(file)]) == 1
    said = capsys.readouterr().err
    assert "has no column q4, tau1 (did you mean tau_1?)" in said
    assert "has 5 rows; at least 20 are needed" in said
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"band": -1.0}, "give a frequency in Hz above zero"),
        ({"hold_back": 1.5}, "give a share of the data"),
        ({"friction": "stiction"}, "there is no term stiction"),
        ({"units": {"q1": "furlong"}}, "furlong is no unit"),
        ({"units": {"q9": "deg"}}, "has no such column"),
        ({"band": 0.01}, "t = 0 s to 10 s is too short for a band"),
    ],
)
def test_settings_that_mean_nothing_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(IdentifyError, match=words):
        symdyn.identify(scara(), log(scara()), **settings)


def test_what_cannot_be_identified_with_is_refused_in_words() -> None:
    data = {"t": np.linspace(0, 1, 50), "q1": np.zeros(50), "q2": np.zeros(50), "M1": np.zeros(50), "M2": np.zeros(50)}
    with pytest.raises(IdentifyError, match="h1, g have no value, and it is geometry or gravity"):
        symdyn.identify(symdyn.example("two_link"), data)
    with pytest.raises(IdentifyError, match="no joint has a drive"):
        linear_model(symdyn.example("heavy_top"))


@pytest.mark.parametrize(
    ("data", "words"),
    [("q1=sin(t)", "q1: a log is a CSV file or arrays over t, not a formula"), (lambda t: {"q1": t}, "not a function")],
)
def test_what_is_no_log_is_refused_in_words(data: Any, words: str) -> None:
    with pytest.raises(IdentifyError, match=words):
        symdyn.identify(scara(), data)


def test_masses_without_numbers_need_none() -> None:
    scene = bind(symdyn.example("two_link"), {"h1": 0.5, "g": 9.81})
    true = bind(scene, {"m1": 2, "m2": 1, "h2": 0.4})
    found = symdyn.identify(scene, log(true, {"q1": "sin(2*t)+0.3*cos(5*t)", "q2": "sin(3*t)"}))

    assert list(np.isnan(found.before)) == [True, False, True] * 2  # point masses lie on their links
    np.testing.assert_allclose(found.after, linear_model(true).prior, atol=2e-3)


def test_the_verb_prints_tables_and_one_json_object(tmp_path: Path, capsys: Capture) -> None:
    import json

    file = tmp_path / "log.csv"
    file.write_text(symdyn.inverse(scara(), MOTION, np.linspace(0, 10, 1001)).to_csv())
    scene = str(EXAMPLES / "scara.toml")

    assert main(["identify", scene, str(file), "--friction", "viscous, coulomb", "--hold-back", "0.25"]) == 0
    out = capsys.readouterr().out
    assert "Base parameters of scara" in out
    assert "condition number" in out
    assert main(["identify", scene, str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["result"]
    assert [one["name"] for one in told["parameters"]][:2] == ["JxxR1 + JyyR1", "mxR2"]
    assert told["condition"] < 10
    assert main(["identify", scene]) == 1
    assert "no data; give a CSV file" in capsys.readouterr().err


def test_the_same_log_gives_the_same_bytes() -> None:
    data = noisy(log(scara()), 1, 0.1)
    one, other = (symdyn.identify(scara(), data) for _ in range(2))

    assert one.after.tobytes() == other.after.tobytes()
    assert one.covariance.tobytes() == other.covariance.tobytes()


def test_the_verb_fits_runs_where_forces_say_nothing(tmp_path: Path, capsys: Capture) -> None:
    scene = EXAMPLES / "pendulum.toml"
    run = symdyn.simulate(symdyn.read(scene), until=2, start={"q1": 1}, values={"b": 0.03}, every=0.02)
    file = tmp_path / "log.csv"
    file.write_text(run.to_csv())

    assert main(["identify", str(scene), str(file), "--by", "output-error", "--parameters", "b"]) == 0
    (line,) = [one for one in capsys.readouterr().out.splitlines() if one.strip().startswith("b ")]
    assert "0.03" in line
    assert main(["identify", str(scene), str(file), "--by", "output-error", "--band", "3"]) == 1
    assert "--band: of --by regression" in capsys.readouterr().err


def test_data_may_stand_behind_options(tmp_path: Path, capsys: Capture) -> None:
    """`SCENE --bind LIST DATA.csv` was "unrecognized arguments: DATA.csv": argparse had closed the list of files."""
    one, other, scene = tmp_path / "one.csv", tmp_path / "other.csv", str(EXAMPLES / "scara.toml")
    for file, end in ((one, 10), (other, 9)):
        file.write_text(symdyn.inverse(scara(), MOTION, np.linspace(0, end, 501)).to_csv())
    rows = []
    for words in (
        [str(one), str(other), "--band", "8"],
        ["--band", "8", str(one), str(other)],
        [str(one), "--band", "8", str(other)],
        ["--band", "8", "--", str(one), str(other)],
    ):
        assert main(["identify", scene, "--json", *words]) == 0
        rows.append(capsys.readouterr().out)

    assert len(set(rows)) == 1
    with pytest.raises(SystemExit):
        main(["info", scene, "--quiet", str(one)])
    assert "unrecognized arguments" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["log.csv", "--parameters", "m1"], "--parameters: of --by output-error"),
        (["log.csv", "--start", "q1=1"], "--start: of --by output-error"),
        (["log.csv", "--seed", "0"], "--seed: of --excite"),
        (["log.csv", "--by", "output-error", "--hold-back", "0.2"], "--hold-back: of --by regression"),
        (["log.csv", "--by", "output-error", "--keep-outliers"], "--keep-outliers: of --by regression"),
        (["log.csv", "--by", "output-error", "--total-mass", "3"], "--total-mass: of --by regression"),
        (["log.csv", "--by", "output-error", "-o", "a.csv"], "-o: of --by regression"),
        (["--excite", "--band", "3"], "--band: of --by regression"),
        (["--excite", "--friction", "all"], "--friction: of --by regression"),
        (["--excite", "--by", "output-error"], "--excite fits nothing"),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_an_option_that_would_do_nothing_is_refused(words: list[str], told: str, capsys: Capture) -> None:
    """Those of one way were ignored by the others: `--parameters m1` fitted all parameters, `--excite` no friction."""
    assert main(["identify", str(EXAMPLES / "scara.toml"), *words]) == 1
    assert told in capsys.readouterr().err


def test_rounding_of_a_joint_at_rest_tells_nothing() -> None:
    """Rates of a constant column are rounding of filter and spline: they told an inertia of -3e7, friction of 5e11."""
    data = noisy(log(scara()), 3, 0.01)
    still = data | {"q2": np.full_like(data["t"], 0.3)}
    found = symdyn.identify(scara(), still, friction=("viscous", "coulomb"))
    moved = [k for k, told in enumerate(found.regression.identifiable) if told]

    assert not any("R2" in found.names[k] or found.names[k].endswith("v2") for k in moved)
    np.testing.assert_allclose(
        np.delete(found.after, moved), np.delete(np.nan_to_num(found.before), moved), rtol=0, atol=20
    )
    assert any("q2 never moves" in note for note in found.notes)


def test_a_force_in_thousands_is_named_by_the_unit_of_its_joint() -> None:
    data = noisy(log(scara()), 3, 0.01)
    kinds = dict(zip(scara().drives, scara().joints, strict=True))
    for drive, joint in kinds.items():
        found = symdyn.identify(scara(), {**data, drive: data[drive] / 1000})
        unit = "kN" if joint.type == "prismatic" else "kNm"
        said = f'it looks like {unit}; units={{"{drive}": "{unit}"}}'
        assert any(said in note for note in found.notes), drive


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace(",", ";"), "semicolons stand between the names; write commas"),
        (lambda text: text.replace(",", "\t"), "tabs stand between the names"),
        (lambda text: "# monday\n" + text, 'the first row is "# monday"; .* remove what stands above'),
        (lambda text: text.replace("t,", "time,", 1), "it has time, q1, .*; call the times, in s, t"),
    ],
)
def test_a_file_of_another_make_says_how_to_write_it(tmp_path: Path, change: Callable[[str], str], words: str) -> None:
    file = tmp_path / "log.csv"
    file.write_text(change(symdyn.inverse(scara(), MOTION, np.linspace(0, 1, 51)).to_csv()))

    with pytest.raises(IdentifyError, match=words):
        symdyn.identify(scara(), str(file))


def test_text_in_columns_that_nothing_reads_is_left_alone(tmp_path: Path) -> None:
    """A column of states, "ok" in every row, made a log unreadable, though other columns are left alone."""
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_text(symdyn.inverse(scara(), MOTION, np.linspace(0, 10, 501)).to_csv())
    head, *rows = plain.read_text().splitlines()
    other.write_text("\n".join([f"{head},state", *(f"{row},ok" for row in rows)]))

    assert symdyn.identify(scara(), str(other)).after.tobytes() == symdyn.identify(scara(), str(plain)).after.tobytes()
    other.write_text("\n".join([head, *rows[:100], rows[100].replace(",", ",x", 1), *rows[101:]]))
    with pytest.raises(IdentifyError, match="is not a finite number; leave the row out"):
        symdyn.identify(scara(), str(other))


def test_a_log_counts_once_and_a_band_ends_where_samples_do() -> None:
    """The same file twice made intervals narrower by a root of two; 5000 Hz was a band of 200 samples a s."""
    data = noisy(log(scara()), 3, 0.01)

    with pytest.raises(IdentifyError, match="is a log that is given already"):
        symdyn.identify(scara(), [data, dict(data)])
    with pytest.raises(IdentifyError, match="samples show no more than 100 Hz"):
        symdyn.identify(scara(), data, band=5000)
