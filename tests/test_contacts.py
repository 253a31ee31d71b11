"""Contacts, stops and dry friction in runs, against closed forms and published figures; see tests/data/impacts."""

from __future__ import annotations

from math import atan, pi

import numpy as np
import pytest
from contact_scenes import ALONE, BELT, CASES, DATA, DOWN, FALL, KNEE, LOOPED, ROD, TWO, row_of_balls, sliders, wheel

import symdyn
from symdyn.errors import SceneError, SimulateError
from symdyn.scene import read_text, write_text

pytestmark = pytest.mark.runs("cc")

METHODS = ("taylor", "dop853")


def told(run: symdyn.Trajectory, what: list) -> float:
    """Return what a reference tells of a run."""
    kind, *rest = what
    if kind == "end":
        return float(run[rest[0]][-1])
    names = {"impact": "strikes", "stick": "sticks", "slip": "slips"}
    hits = [one for one in run.impacts if one.what == names[rest[0]] and _is(one.contact, rest[1]) and one.t > 1e-9]
    if kind == "time":
        return hits[rest[2]].t
    return float(run(hits[rest[2]].t + 1e-12)[rest[3]][0])


def _is(contact: str, name: str) -> bool:
    return name in (contact, contact.rpartition("_")[0])


@pytest.mark.parametrize("name", [one for one, case in CASES.items() if "scene" in case])
@pytest.mark.parametrize("method", METHODS)
def test_runs_agree_with_closed_forms(name: str, method: str) -> None:
    case = CASES[name]
    run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=case["until"], method=method, rtol=1e-13)
    for one in case["expect"]:
        assert told(run, one["what"]) == pytest.approx(one["value"], rel=0, abs=one["tol"]), one["what"]
    assert np.abs(run["energy_error"]).max() < 1e-10
    assert min((one.lost for one in run.impacts), default=0.0) >= 0.0
    missed = {name: value for name, value in run.monitors.items() if name.startswith(("penetration", "contact_laws"))}
    assert max(missed.values(), default=0.0) < 1e-11, missed


def test_flights_that_become_shorter_without_end_are_passed_in_their_limit() -> None:
    case = CASES["ball"]
    run = symdyn.simulate(symdyn.read(DATA / case["scene"]), until=6, method="taylor")
    assert run.impacts[-1].rest == pytest.approx(case["zeno_time"], rel=0, abs=case["zeno_tol"])
    resting = run.t > case["zeno_time"]
    assert np.all(run["z_dot"][resting] == 0.0)
    assert np.all(run["mode_floor"][resting] == 1.0)
    assert run["normal_floor"][-1] == pytest.approx(9.81)


def test_a_block_on_a_belt_sticks_and_slips_with_the_period_of_its_closed_form() -> None:
    run = symdyn.simulate(read_text(BELT), until=3, method="taylor")
    slips = [one.t for one in run.impacts if one.what == "slips"]
    d = 0.2 * 9.81 / 100
    assert slips[0] == pytest.approx(CASES["stick_slip_belt"]["values"]["first_slip"], abs=1e-13)
    assert np.diff(slips) == pytest.approx(2 * (pi - atan(d * 10 / 0.5)) / 10 + 2 * d / 0.5, abs=1e-12)
    assert np.abs(run["energy_error"]).max() < 1e-12
    sticking = run["mode_c"] == 1
    assert np.all(run["x_dot"][sticking] == pytest.approx(0.5, abs=1e-12))
    assert np.all(np.abs(run["friction_c"]) <= 0.4 * run["normal_c"] + 1e-9)


def test_a_clutch_locks_when_its_closed_form_says() -> None:
    run = symdyn.simulate(read_text(TWO), until=8)
    (lock,) = run.impacts
    assert (lock.contact, lock.what) == ("b_friction", "sticks")
    assert lock.t == pytest.approx(90 / (20 / 2 + 20 / 3), abs=1e-12)
    assert run["p1_dot"][-1] == pytest.approx(64, abs=1e-12)  # (2*10 + 3*100)/5
    assert run["p2_dot"][-1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_three_balls_at_once_part_as_published(law: str) -> None:
    run = symdyn.simulate(read_text(row_of_balls(law)), until=2)
    assert [run[f"x{name}_dot"][-1] for name in "abc"] == pytest.approx(CASES["three_balls"]["values"]["at_once"])
    assert sum(run[f"x{name}_dot"][-1] for name in "abc") == pytest.approx(1)


def test_a_rimless_wheel_rolls_down_as_mcgeer_has_it() -> None:
    values = CASES["rimless_wheel"]["values"]["rates_after_strike"]
    run = symdyn.simulate(read_text(wheel(0.08)), until=4.6, method="taylor")
    strikes = [one.t for one in run.impacts if one.what == "strikes" and one.t > 1e-6]
    rates = [-float(run(t + 1e-9)["theta_dot"][0]) for t in dict.fromkeys(strikes)]
    assert rates[: len(values)] == pytest.approx(values[: len(rates)], abs=1e-7)
    assert len(rates) >= 4


def test_an_ensemble_of_contacts_runs_one_by_one() -> None:
    scene = symdyn.read(DATA / "scenes/ball.toml")
    found = symdyn.ensemble(scene, start={"z": [1.0, 2.0]}, until=0.7, measures="max(abs(z_dot))")
    speeds = [(2 * 9.81 * z) ** 0.5 for z in (1, 2)]
    assert np.ravel(found["max(abs(z_dot))"]) == pytest.approx(speeds, rel=0.05)


def test_a_rod_slips_at_the_angle_of_its_closed_form() -> None:
    run = symdyn.simulate(read_text(ROD), until=1, method="taylor")
    slip = next(one for one in run.impacts if one.what == "slips")
    assert float(run(slip.t)["theta"][0]) == pytest.approx(CASES["falling_rod_0.36"]["slips_at_angle"], abs=1e-10)


TABLE = FALL.replace('body = "b"\nrest', 'body = "b"\nplane = { body = "table", normal = [0, 0, 1] }\nrest')

TABLE += """
[bodies.table]
mass = 3
[joints.t]
type = "prismatic"
parent = "ground"
child = "table"
axis = [0, 0, 1]
coordinate = "h"
motion = "0.05*sin(20*t)"
"""

SLOPE = f"""gravity = ["9.81*sin(0.4)", 0, "-9.81*cos(0.4)"]
{sliders("xz")}[contacts.c]
body = "b"
plane = {{ body = "ground", normal = [0, 0, 1] }}
friction = 0.3
static = 0.6
"""


def test_what_is_pulled_up_lifts_off_again_and_again() -> None:
    run = symdyn.simulate(read_text(FALL), until=1, forces="tau1=20*t")
    assert [one.what for one in run.impacts] == ["lifts off"]
    assert run["z"][-1] == pytest.approx(20 / 6 * (1 - 9.81 / 20) ** 3)
    run = symdyn.simulate(read_text(FALL), until=4, forces="tau1=15*sin(5*t)", values={"e": 0})
    assert [one.what for one in run.impacts] == ["lifts off", "strikes"] * 3 + ["lifts off"]
    assert run["gap_f"].min() > -1e-12
    assert run["normal_f"].min() >= 0
    run = symdyn.simulate(read_text(KNEE), until=2, forces="tau1=-15*t")
    assert [(one.contact, one.what) for one in run.impacts][:2] == [("h_upper", "strikes"), ("h_upper", "lifts off")]
    assert "rad/s" in run.impacts[0].words


@pytest.mark.parametrize("e", [0, 0.7])
def test_a_plane_that_moves_as_it_is_told_keeps_the_balance_of_energy(e: float) -> None:
    run = symdyn.simulate(read_text(TABLE), until=2, start="z=0.1", values={"e": e})
    assert len(run.impacts) > 6
    assert np.abs(run["energy_error"]).max() < 1e-11
    assert run["gap_f"].min() > -1e-12
    assert min(one.lost for one in run.impacts) >= 0


@pytest.mark.parametrize(("rate", "sticks"), [(0, 0.0), (-1, 1 / 9.81 / (np.sin(0.4) + 0.3 * np.cos(0.4)))])
def test_static_friction_holds_what_sliding_friction_would_not(rate: float, sticks: float) -> None:
    run = symdyn.simulate(read_text(SLOPE), until=1, start_rates=f"x_dot={rate}")
    assert run["mode_c"][-1] == 1
    assert run["x_dot"][-1] == 0
    assert [one.t for one in run.impacts] == pytest.approx([sticks] if rate else [])


def test_formulas_of_accelerations_know_the_forces_of_contacts() -> None:
    scene = read_text(SLOPE.replace("0.4)", "0)") + '[outputs]\na = "x_ddot"\n')
    run = symdyn.simulate(scene, until=1, start_rates="x_dot=1", stops=["x_ddot + 2"])
    assert run["a"][0] == pytest.approx(-0.3 * 9.81)
    assert run.t[-1] == pytest.approx(1 / (0.3 * 9.81))


def test_friction_that_turns_round_at_once_does_not_stick() -> None:
    scene = read_text(KNEE.replace("restitution = 0 }", "restitution = 0.5 }\nfriction = { coulomb = 2 }"))
    run = symdyn.simulate(scene, until=0.5)
    assert [one.what for one in run.impacts] == ["strikes", "slips"]
    assert run.impacts[1].mode[-1] == "slips +"
    told = symdyn.simulate(scene, until=0.1, reactions=True)  # beside stops and friction of joints they are known
    assert np.isfinite(told["reaction_h_fz"]).all()
    formula = read_text(write_text(scene, "toml").text + '[outputs]\nr = "reaction_h_fz"\n')
    assert symdyn.simulate(formula, until=0.1)["r"] == pytest.approx(told["reaction_h_fz"])


def test_a_run_between_its_samples_tells_the_impacts_of_the_run() -> None:
    run = symdyn.simulate(read_text(FALL), until=1, start="z=1", every=0.5)
    assert len(run(0.9).impacts) == len(run.impacts) == 1
    assert run(0.7)["z_dot"][0] == pytest.approx(0.7 * (2 * 9.81) ** 0.5 - 9.81 * (0.7 - (2 / 9.81) ** 0.5))


BLOCK = f"""{DOWN}{sliders("xz", "s_r", "", z="start = 0.5")}
[bodies.b]
mass = 1
inertia = [0.1, 0.1, 0.1]
inertia_about = "com"
[joints.r]
type = "revolute"
parent = "s_r"
child = "b"
axis = [0, 1, 0]
coordinate = "r"
"""

for at in (-0.3, 0.3):
    BLOCK += f'[contacts.c{int(at > 0)}]\nbody = "b"\nat = [{at}, 0, -0.5]\nfriction = 0.5\n'
    BLOCK += 'plane = { body = "ground", normal = [0, 0, 1] }\n'


def test_a_block_on_two_corners_slides_when_both_are_at_the_edge_of_their_cones() -> None:
    run = symdyn.simulate(read_text(BLOCK), until=1, forces="tau1=8*t")
    slips = 0.5 * 9.81 / 8
    assert run["x_dot"][-1] == pytest.approx(4 * (1 - slips**2) - 0.5 * 9.81 * (1 - slips))
    assert run.impacts[-1].t == pytest.approx(slips)


def test_a_block_that_rocks_from_corner_to_corner_comes_to_rest() -> None:
    run = symdyn.simulate(read_text(BLOCK), until=2, start="z=0.8, r=0.3")
    assert min(run["gap_c0"].min(), run["gap_c1"].min()) > -1e-11
    assert (run["mode_c0"][-1], run["mode_c1"][-1]) == (1, 1)
    assert run["z"][-1] == pytest.approx(0.5, abs=1e-9)
    assert np.abs(run["energy_error"]).max() < 1e-10


"""A parallelogram, which is a pendulum of one angle."""


def test_contacts_of_a_loop_are_those_of_the_same_mechanism_without() -> None:
    one, other = (
        symdyn.simulate(read_text(text), until=3, method="dop853", rtol=1e-11, atol=1e-12) for text in (LOOPED, ALONE)
    )
    assert one["a"] == pytest.approx(other["a"], abs=1e-7)
    assert [hit.t for hit in one.impacts[:8]] == pytest.approx([hit.t for hit in other.impacts[:8]], abs=1e-8)
    assert one.impacts[0].impulse == pytest.approx(other.impacts[0].impulse, rel=1e-7)
    assert one["normal_floor"][-1] == pytest.approx(other["normal_floor"][-1])
    assert np.abs(one["loop_error"]).max() < 1e-9


ROPE = f"""{DOWN}{sliders("xz", z="start = -1")}
[ropes.r]
type = "slack"
through = ["ground", "b"]
length = 1
"""


def test_a_pendulum_on_a_rope_leaves_its_circle_where_its_closed_form_says() -> None:
    """At (v² - 2 g l)/(3 g l) above the pivot; then a parabola until it is taut again."""
    scene = read_text(ROPE)
    run = symdyn.simulate(scene, until=2, start_rates={"x_dot": (3.5 * 9.81) ** 0.5}, rtol=1e-12)
    slack, taut = run.impacts[:2]
    assert (slack.what, taut.what) == ("goes slack", "becomes taut")
    assert run(slack.t)["z"][0] == pytest.approx(0.5, abs=1e-9)
    falls = taut.t - slack.t
    speed = (0.5 * 9.81) ** 0.5  # v² = g l sin φ where it leaves
    x, z = run(slack.t)["x"][0] - 0.5 * speed * falls, 0.5 + 0.75**0.5 * speed * falls - 9.81 / 2 * falls**2
    assert np.hypot(x, z) == pytest.approx(1, abs=1e-9)
    assert "becomes taut" in taut.words
    assert "J lost" in taut.words
    assert symdyn.certify(scene, ["gap:r", "gap_jacobian:r", "gap_jdot:r", "impact:r"]).passed
    assert read_text(write_text(scene, "toml").text) == scene


@pytest.mark.filterwarnings("error")
def test_a_slack_rope_whose_ends_meet_is_told() -> None:
    with pytest.raises(SimulateError, match=r"start: r has no direction there, as of a rope whose ends meet"):
        symdyn.simulate(read_text(ROPE), until=1, start="z=0")


def test_a_slack_rope_around_a_wheel_is_told() -> None:
    over = ', { body = "ground", at = [0, 0, 1], radius = 0.1, axis = [0, 1, 0], turn = "left" }, "b"]'
    with pytest.raises(SceneError, match=r"ropes\.r: a rope that may be slack leaves a wheel, and its length jumps"):
        read_text(ROPE.replace(', "b"]', over))


def test_what_is_not_active_passes_its_plane() -> None:
    """A compass walker scuffs with its swinging leg; every published gait lets it."""
    scene = read_text(FALL.replace('restitution = "e"', 'restitution = "e"\nactive = "z + 2"'))
    run = symdyn.simulate(scene, until=1, start="z=1")
    assert run.impacts[0].t == pytest.approx((2 / 9.81) ** 0.5)
    scene = read_text(FALL.replace('restitution = "e"', 'restitution = "e"\nactive = "-z - 2"'))
    assert not symdyn.simulate(scene, until=1, start="z=1").impacts


HELD = FALL.replace("contacts.f", "contacts.floor").replace("e = 0.7", "e = 0").replace("start = 0", "start = 1")


@pytest.mark.parametrize("method", ["taylor", "radau"])
@pytest.mark.parametrize(
    ("column", "least", "t", "there"),
    [("gap_floor", 0.1, 0.428352936878, 0.1), ("normal_floor", 5, 0.451523640986, 9.81)],
)
def test_a_column_of_a_contact_ends_a_run(method: str, column: str, least: float, t: float, there: float) -> None:
    run = symdyn.simulate(read_text(HELD), until=3, stops=[f"{column} - {least}"], method=method)

    assert run.stopped == f"{column} - {least}"
    assert run.t[-1] == pytest.approx(t, abs=1e-9)
    assert run[column][-1] == pytest.approx(there, abs=1e-8)


@pytest.mark.parametrize("name", ["friction_floor", "mode_floor", "normal_flor"])
def test_a_column_of_a_contact_that_there_is_not_is_told(name: str) -> None:
    with pytest.raises(
        SimulateError, match=f"{name}.* not known|{name} is no column of this scene; known are gap_floor"
    ):
        symdyn.simulate(read_text(HELD), until=3, stops=[f"{name} - 1"])
