"""Wheels, balls and blades on planes: heights that are held, motions that are known, forces on both bodies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.mobility import mobility
from symdyn.errors import DerivationError, SceneError, SimulateError
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import simulate
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start
from symdyn.simulation.trajectory import Trajectory

DATA, EXAMPLES = Path(__file__).parent / "data", Path(__file__).parent.parent / "examples"
ZXY = (DATA / "found" / "rolling_disc_zxy.toml").read_text(encoding="utf-8")
R, G = 0.26, 9.81

BALL = """
name = "ball"
[bodies.ball]
mass = 2
inertia = [0.008, 0.008, 0.008]
inertia_about = "com"
[joints.flight]
type = "free"
parent = "ground"
child = "ball"
drive = false
coordinates = ["x", "y", "z", "e0", "e1", "e2", "e3"]
start = [0, 0, 0.1, 1, 0, 0, 0]
[constraints.touch]
type = "rolling"
body = "ball"
radius = 0.1
"""


def run(scene: Scene, until: float = 1.0, **options: object) -> Trajectory:
    return simulate(scene, until=until, **options)  # type: ignore[arg-type]


def at(scene: Scene, trajectory: Trajectory, name: str) -> np.ndarray:
    return np.asarray(trajectory[name])


# Heights


@pytest.mark.mends("3.4")
def test_a_wheel_that_starts_above_its_plane_is_brought_onto_it() -> None:
    text = ZXY.replace('start = [0, 0, "r*cos(0.1)",', "start = [0, 0, 5,")
    z = read_start(read_text(text, "disc.toml")).q[2]

    assert z == pytest.approx(R * np.cos(read_start(read_text(text, "disc.toml")).q[4]), abs=1e-9)


@pytest.mark.mends("3.4")
def test_a_wheel_that_is_told_to_lean_stands_on_its_plane() -> None:
    q = read_start(read_text(ZXY, "disc.toml"), {"q2": "0.2"}).q

    assert q[4] == 0.2
    assert q[2] == pytest.approx(R * np.cos(0.2), abs=1e-12)


@pytest.mark.mends("3.4")
def test_the_ground_is_across_gravity() -> None:
    text = ZXY.replace('name = "rolling_disc_zxy"', 'name = "upward"\ngravity = [0, -9.81, 0]')
    text = text.replace("axis = [0, 1, 0]", "axis = [0, 0, 1]").replace(
        'start = [0, 0, "r*cos(0.1)", 0.3, 0.1, 1.97]', ""
    )
    start = read_start(read_text(text, "disc.toml"))

    assert start.q[1] == pytest.approx(R, abs=1e-9)  # upright on the plane y = 0


@pytest.mark.runs
@pytest.mark.mends("3.4")
def test_a_rolling_wheel_keeps_its_height() -> None:
    trajectory = run(read(EXAMPLES / "rolling_disc.toml"), 3.0)
    e = np.stack([at(trajectory.scene, trajectory, f"e{k}") for k in range(4)], axis=1)
    axis_z = 2 * (e[:, 2] * e[:, 3] + e[:, 0] * e[:, 1])  # z of the turned y
    off = at(trajectory.scene, trajectory, "z") - 0.3 * np.sqrt(1 - axis_z**2)

    assert np.abs(off).max() < 1e-11
    assert "constraint_residual" in {r.function.name for r in state_equations(trajectory.scene).program.routines}
    residual = state_equations(trajectory.scene).program["constraint_residual"].function
    assert sum(not entry.is_zero for entry in residual.entries) == 1


def test_without_a_normal_component_nothing_is_added_and_the_distance_is_told() -> None:
    text = ZXY.replace('["along", "across", "normal"]', '["along", "across"]').replace('"r*cos(0.1)"', '"r + 0.1"')
    silent, spoken = (read_text(one, "disc.toml") for one in (text, text + "plane = { at = [0, 0, 0.05] }\n"))

    assert mobility(silent).by_rank == mobility(spoken).by_rank == 4
    assert read_start(silent).q[2] == read_start(spoken).q[2] == pytest.approx(R + 0.1)
    assert not any("plane" in note for note in read_start(silent).notes)
    (note,) = read_start(spoken).notes
    assert f"{R + 0.05 - R * np.cos(0.1):.3g} m above its plane" in note
    assert note in mobility(spoken).notes


def test_a_blade_has_no_height_and_the_distance_from_a_declared_plane_is_told() -> None:
    text = (DATA / "contacts" / "skate.toml").read_text(encoding="utf-8")
    scene = read_text(text.replace("normal = [0, 0, 1] }", "at = [0, 0, 0.2], normal = [0, 0, 1] }"), "skate.toml")

    assert [label.holonomic for label in Numbers(scene).constraints.labels] == [False]
    assert any("sled is 0.2 m below its plane" in note for note in read_start(scene).notes)


def test_the_rate_of_the_height_is_the_row_of_the_normal_off_the_plane_too() -> None:
    scene = read(DATA / "contacts" / "turntable.toml")
    disc = BALL.replace("radius = 0.1", "radius = 0.1\naxis = [1, 2, 2]\ncomponents = ['normal']")
    disc += "plane = { at = [0.1, 0.2, 0.3], normal = [1, -2, 2] }\n"
    for one in (scene, read_text(disc, "disc.toml")):
        numbers = Numbers(one)
        held = [k for k, label in enumerate(numbers.constraints.labels) if label.holonomic]
        for seed in range(5):
            q = numbers.drawn(seed)
            assert numbers.residual_rates(q)[held] == pytest.approx(numbers.jacobian(q)[held], abs=1e-13)


# Where there is no lowest point


def test_a_wheel_that_starts_flat_is_refused_and_says_what_helps() -> None:
    text = ZXY.replace('"r*cos(0.1)", 0.3, 0.1', '0, 0.3, "pi/2"')

    with pytest.raises(SimulateError, match=r"contact contact: disc lies flat on its plane.*give a start at which it"):
        read_start(read_text(text, "disc.toml"))


def test_a_coin_without_a_start_lies_flat_and_is_refused_so() -> None:
    start = 'start = [0, 0, "r*cos(0.1)", 0.3, 0.1, 1.97]'
    text = ZXY.replace("axis = [0, 1, 0]", "axis = [0, 0, 1]").replace(start, "")

    with pytest.raises(SimulateError, match=r"contact contact: disc lies flat on its plane.*give a start at which it"):
        read_start(read_text(text, "disc.toml"))


def test_a_wheel_whose_axis_is_always_along_the_normal_is_refused_with_its_row() -> None:
    text = BALL.replace('type = "free"', 'type = "prismatic"').replace("radius = 0.1", "radius = 0.1\naxis = [0, 0, 1]")
    text = text.replace('coordinates = ["x", "y", "z", "e0", "e1", "e2", "e3"]\nstart = [0, 0, 0.1, 1, 0, 0, 0]\n', "")

    with pytest.raises(
        DerivationError, match=r"constraints.touch: ball lies flat on its plane wherever the joints stand"
    ):
        Numbers(read_text(text, "disc.toml"))


@pytest.mark.runs
@pytest.mark.parametrize("method", ["dop853", "radau", "cvode"])
def test_a_disc_that_falls_flat_ends_the_run_with_its_rows(method: str) -> None:
    """At rest and leaning it falls about the tangent of its rim: 5/4 m r² (1 - cos) drops into 5/8 m r² rate²."""
    trajectory = run(read_text(ZXY, "disc.toml"), 0.7, method=method, every=0.01)

    assert trajectory.t[-1] == pytest.approx(0.63724, abs=1e-4)
    assert "lies flat" in trajectory.stopped
    assert np.isfinite(trajectory.table()[1]).all()


@pytest.mark.runs
@pytest.mark.parametrize("mass", ["3.43", "3.43e-12"])
def test_a_falling_disc_would_pull_as_much_as_its_fall_says(mass: str) -> None:
    """With c the cosine of the lean N = m g (0.2 - 1.6 c c0 + 2.4 c²) from rest at c0, least at c = c0 / 3."""
    scene, c0 = read_text(ZXY.replace("3.43", mass), "disc.toml"), np.cos(0.1)
    trajectory = run(scene, 0.7, every=0.001)
    c = c0 / 3
    least = float(mass) * G * (0.2 - 1.6 * c * c0 + 2.4 * c * c)

    assert trajectory.monitors["normal_force contact"] == pytest.approx(least, rel=1e-3)
    assert any("would pull" in note for note in trajectory.notes)
    assert any("friction coefficient" in note for note in trajectory.notes)


# Motions that are known


@pytest.mark.runs
def test_a_ball_rolls_down_a_slope_with_five_sevenths_of_what_it_would_slide_with() -> None:
    scene = read_text(BALL + "plane = { normal = [-3, 0, 4] }\n", "ball.toml")
    trajectory = run(scene, 1.0, start={"x": "0", "z": "0.125"})
    a = 5 / 7 * G * 0.6

    assert trajectory["x"][-1] - trajectory["x"][0] == pytest.approx(-a / 2 * 0.8, rel=1e-9)
    friction = 2 / 7 * 0.6 / 0.8  # m g sin(slope) - m a, over m g cos(slope)
    assert trajectory.monitors["friction_coefficient touch"] == pytest.approx(friction, rel=1e-6)


@pytest.mark.runs
def test_a_ball_without_friction_slides() -> None:
    scene = read_text(BALL + "components = ['normal']\nplane = { normal = [-3, 0, 4] }\n", "ball.toml")
    trajectory = run(scene, 1.0)

    assert trajectory["x"][-1] - trajectory["x"][0] == pytest.approx(-G * 0.6 / 2 * 0.8, rel=1e-9)
    assert not any("friction" in note for note in trajectory.notes)


@pytest.mark.runs
def test_a_ball_on_a_turntable_runs_round_with_two_sevenths_of_its_rate() -> None:
    text = (DATA / "contacts" / "turntable.toml").read_text(encoding="utf-8")
    text = text.replace("drive=false\nstart_rates=[2]", 'motion = "2*t"')
    rates = {"flight_vx": "0.3", "flight_wx": "0.5", "flight_wz": "1"}
    trajectory = run(read_text(text, "turntable.toml"), 6.0, start_rates=rates, rtol=1e-11)
    xy = np.stack([trajectory["x"], trajectory["y"]], axis=1)
    circle = np.linalg.lstsq(np.column_stack([2 * xy, np.ones(len(xy))]), (xy**2).sum(axis=1))[0]
    way = xy - circle[:2]
    turned = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))

    assert np.ptp(np.linalg.norm(way, axis=1)) < 1e-8
    assert turned - turned[0] == pytest.approx(2 / 7 * 2 * trajectory.t, abs=1e-8)


@pytest.mark.runs
def test_a_disc_on_a_plane_that_speeds_up_follows_with_a_third() -> None:
    text = (
        BALL.replace("[joints.flight]", TABLE)
        .replace("radius = 0.1", "radius = 0.1\naxis = [0, 1, 0]")
        .replace("inertia = [0.008, 0.008, 0.008]", "inertia = [0.005, 0.01, 0.005]")
    )  # m r² / 2 about its axis
    text += "components = ['along', 'across', 'normal']\nplane = { body = 'table', normal = [0, 0, 1] }\n"
    trajectory = run(read_text(text, "disc.toml"), 1.0)

    assert trajectory["s"][-1] == pytest.approx(0.75, rel=1e-9)
    assert trajectory["x"][-1] == pytest.approx(0.25, rel=1e-8)


TABLE = """[bodies.table]
mass = 5
[joints.slide]
type = "prismatic"
parent = "ground"
child = "table"
axis = [1, 0, 0]
coordinate = "s"
motion = "0.75*t**2"
[joints.flight]"""


@pytest.mark.runs
def test_a_disc_rolls_round_steadily_at_the_rates_of_neimark_and_fufaev() -> None:
    """Momentum about the centre, and what the ground exerts on it, both turn about the vertical.

    The axis leans by θ, the precession is Ω, the whole spin about the axis σ, and C = 2 A = m r²/2. Then L = C σ a +
    A Ω cos θ b turns with Ω, and is turned by weight and by the force that keeps the centre on its circle, both at the
    rim: (C + m r²) σ Ω cos θ = A Ω² sin θ cos θ - m g r sin θ.
    """
    scene = read_text(ZXY, "disc.toml")
    lean, precession = 0.35, 1.7
    s, c = np.sin(lean), np.cos(lean)
    whole = (0.25 * precession**2 * s * c - G * s / R) / (1.5 * precession * c)
    spin = whole - precession * s
    start = {"q1": "0", "q2": f"{lean!r}", "q3": "0"}
    rates = {"q1": f"{precession!r}", "q2": "0", "q3": f"{float(spin)!r}"}
    trajectory = run(scene, 5.0, start=start, start_rates=rates)

    assert np.ptp(trajectory["q2"]) < 1e-7
    assert trajectory["q1"][-1] == pytest.approx(5 * precession, abs=1e-6)


def eigenvalues(scene: Scene, speed: float) -> np.ndarray:
    """Return those of the linearised motion of lean and steer about going straight ahead."""
    system, numbers = state_equations(scene), Numbers(scene)
    q, u = list(scene.coordinates), list(scene.velocities)
    held = [u.index(f"{name}_dot") for name in ("x", "y", "yaw", "lean", "steer", "rear_turn", "front_turn")]
    moving = [len(q) + u.index(f"{name}_dot") for name in ("lean", "steer")]

    def rates(x: np.ndarray) -> np.ndarray:
        guess = numbers.start()
        guess[[q.index("lean"), q.index("steer")]] = x[:2]
        at = np.array(numbers.closed_position(guess, held).q)
        given = dict(zip((u.index("lean_dot"), u.index("steer_dot")), x[2:].tolist(), strict=True))
        state = np.concatenate([at, numbers.fitting_rates(at, {**given, u.index("rear_turn_dot"): speed / 0.3})])
        return np.array([*x[2:], *system.rates(0.0, state)[moving]])

    slopes = [(rates(1e-5 * e) - rates(-1e-5 * e)) / 2e-5 for e in np.eye(4)]
    return np.sort_complex(np.linalg.eigvals(np.array(slopes).T))


MEIJAARD: Mapping[float, list[complex]] = {  # table 2 of the paper
    0.0: [-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393],
    5.0: [-14.07838969279822, -0.77534188219585 - 4.46486771378823j, -0.77534188219585 + 4.46486771378823j,
          -0.32286642900409],
}  # fmt: skip


@pytest.mark.runs
@pytest.mark.parametrize("speed", MEIJAARD)
def test_the_benchmark_bicycle_has_the_eigenvalues_of_meijaard_and_others(speed: float) -> None:
    found = eigenvalues(read(DATA / "contacts" / "bicycle.toml"), speed)

    assert found == pytest.approx(np.array(MEIJAARD[speed]), abs=2e-7)


@pytest.mark.long
def test_the_benchmark_bicycle_is_stable_between_weave_and_capsize_speed_only() -> None:
    scene = read(DATA / "contacts" / "bicycle.toml")
    growth = [eigenvalues(scene, speed).real.max() for speed in (4.2, 4.4, 5.9, 6.1)]

    assert [rate > 0 for rate in growth] == [True, False, False, True]


# Forces on both bodies


@pytest.mark.runs
def test_what_turns_on_a_free_turntable_turns_it_back() -> None:
    trajectory = run(read(DATA / "contacts" / "turntable.toml"), 3.0, start_rates={"q1": "2", "flight_vx": "0.4"})
    e = np.stack([trajectory[f"e{k}"] for k in range(4)], axis=1)
    R33 = [2 * (e[:, 1] * e[:, 3] - e[:, 0] * e[:, 2]), 2 * (e[:, 2] * e[:, 3] + e[:, 0] * e[:, 1]),
           1 - 2 * (e[:, 1] ** 2 + e[:, 2] ** 2)]  # fmt: skip
    spin = sum(row * trajectory[f"flight_w{k}"] for row, k in zip(R33, "xyz", strict=True))
    speed = _velocity(trajectory)
    L = 2 * trajectory["q1_dot"] + 0.004 * spin + trajectory["x"] * speed[:, 1] - trajectory["y"] * speed[:, 0]

    assert np.ptp(L) < 1e-8 * abs(L[0])
    assert np.ptp(trajectory["q1_dot"]) > 1e-3  # the table feels the ball


def _velocity(trajectory: Trajectory) -> np.ndarray:
    """Return the velocity of the ball in the ground frame, shape (N, 3)."""
    w, x, y, z = (trajectory[f"e{k}"] for k in range(4))
    rows = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    v = np.stack([trajectory[f"flight_v{k}"] for k in "xyz"])
    return np.asarray(np.einsum("ijn,jn->ni", rows, v))


@pytest.mark.runs
def test_a_table_carries_what_rolls_on_it() -> None:
    trajectory = run(read(DATA / "contacts" / "turntable.toml"), 0.5, reactions=True)

    assert trajectory["reaction_spin_fz"] == pytest.approx(np.full(len(trajectory.t), 6 * G), rel=1e-9)


@pytest.mark.runs
def test_a_blade_pushes_its_table_back() -> None:
    trajectory = run(read(DATA / "contacts" / "skate.toml"), 3.0)
    turn, rate = trajectory["phi"], trajectory["phi_dot"]
    ahead = trajectory["x_dot"] - 0.1 * np.sin(turn) * rate
    momentum = 5 * trajectory["s_dot"] + 2 * ahead
    slip = -np.sin(turn) * (trajectory["x_dot"] - trajectory["s_dot"]) + np.cos(turn) * trajectory["y_dot"]

    assert np.ptp(momentum) < 1e-8
    assert np.abs(slip).max() < 1e-9
    assert np.ptp(trajectory["s_dot"]) > 0.1


@pytest.mark.runs
def test_forces_that_are_not_unique_are_not_told() -> None:
    text = BALL + BALL[BALL.index("[constraints.touch]") :].replace("constraints.touch", "constraints.again")
    notes = run(read_text(text, "twice.toml"), 0.1).notes

    assert sum("forces are not unique" in note for note in notes) == 2


def test_what_a_wheel_cannot_touch_is_refused() -> None:
    for more, says in (
        ('plane = { body = "ball", normal = [0, 0, 1] }', 'touches a plane on its own body, "ball"'),
        ('plane = { body = "bal" }', 'plane: body = "bal" is not a body; did you mean ball?'),
        ("plane = { normal = [0, 0, 0] }", r"plane: normal = \[0, 0, 0\] has zero length"),
        ("plane = { height = 3 }", 'plane: unknown key "height"'),
        ("plane = 3", "plane = 3 is not a table; write plane = {"),
        ("plane = { at = [0, 0, 1] }\nnormal = [0, 0, 1]", "normal is given beside plane; write it into plane"),
        ('normal = ["t", 0, 1]', "give numbers, and tilt a body that carries it instead"),
    ):
        with pytest.raises(SceneError, match=says):
            read_text(BALL + more + "\n", "ball.toml")
