"""Loops, rows and prescribed motions in time, against each other and against closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_mechanisms import crank_rocker, exact, four_bar
from scipy.integrate import solve_ivp

from symdyn.errors import SimulateError
from symdyn.scene import Scene, read, read_text
from symdyn.scene.values.formula import parse as formula
from symdyn.simulation import Trajectory, inverse, read_forces, read_motion, simulate
from symdyn.simulation.equations.implicit import Implicit
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.initial import read_start

pytestmark = pytest.mark.runs()

EXAMPLES = Path(__file__).parent.parent / "examples"

DISC = read(EXAMPLES / "rolling_disc.toml")


@pytest.fixture
def _ida() -> None:
    pytest.importorskip("sksundae", reason="needs scikit-sundae, the extra simulate")


# IDA


@pytest.mark.heavy("spatial_slider_crank")
@pytest.mark.usefixtures("_ida")
@pytest.mark.parametrize(
    ("name", "rates", "forces"),
    [
        ("four_bar", {}, []),
        ("slider_crank", {"phi": "2"}, ["M=0.3*sin(5*t)"]),
        ("spatial_slider_crank", {"phi": "2"}, []),
        ("rolling_disc", {}, []),
        ("heavy_top", {}, []),
    ],
)
def test_multipliers_give_the_motion_of_reduced_coordinates(
    name: str, rates: dict[str, str], forces: list[str]
) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    given = read_forces(scene, forces)
    until = 0.2 if name == "heavy_top" else 1.0
    reference = simulate(
        scene, forces=given, until=until, start=None, start_rates=rates, method="dop853", rtol=1e-12, every=0.1
    )
    found = simulate(
        scene, forces=given, until=until, start=None, start_rates=rates, method="ida", rtol=1e-10, every=0.1
    )

    assert found.stopped == "end"
    assert np.abs(found.q - reference.q).max() < 2e-7
    assert np.abs(found.q[-1] - found.q[0]).max() > 0.1
    assert found.monitors["energy"] < 1e-7 * found.monitors["energy_scale"]
    assert max(found.monitors.get(law, 0.0) for law in ("loops", "loop_rates", "quaternions")) < 1e-9


def test_a_change_point_is_near_where_all_bars_lie_along_each_other() -> None:
    """The shortest bar and the longest are as long as the two others together."""
    one = exact(1)
    scene = four_bar(one, exact(3), exact(2), exact(2), (one, one, one), ("1", "1/5", "2"))
    system = state_equations(scene)

    assert system.changes(np.zeros(3))
    assert not system.changes(read_start(scene).q)


@pytest.mark.usefixtures("_ida")
def test_both_positions_and_velocities_are_held_without_projection(monkeypatch: pytest.MonkeyPatch) -> None:
    """With G u = 0 alone the loops would open, by 6e-7 here."""
    monkeypatch.setattr("symdyn.simulation.equations.system.Projection.__call__", lambda *_: None)
    found = simulate(read(EXAMPLES / "four_bar.toml"), until=5.0, method="ida", rtol=1e-8)

    assert found.monitors["loops"] < 6e-8
    assert found.monitors["loop_rates"] < 1e-6


@pytest.mark.parametrize("name", ["four_bar", "rolling_disc", "spatial_slider_crank"])
def test_the_implicit_equations_hold_where_the_reduced_ones_do(name: str) -> None:
    scene = read(EXAMPLES / f"{name}.toml")
    system, start = (
        state_equations(scene),
        read_start(scene, rates={scene.velocities[0]: "1"} if name != DISC.name else {}),
    )
    equations = Implicit(system)
    y, rates = equations.start(0.0, np.concatenate([start.q, start.u, np.zeros(int(system.works))]))
    size = np.abs(rates).max()

    assert np.abs(equations.residual(0.0, y, rates)).max() < 1e-10 * max(1.0, size)
    for k in range(len(y)):  # and nowhere else: every unknown counts
        moved, speed = y.copy(), rates.copy()
        moved[k], speed[k] = moved[k] + 1e-3, speed[k] + 1e-3
        assert np.abs(equations.residual(0.0, moved, speed)).max() > 1e-6


def test_ida_is_no_method_for_loops_in_proportion() -> None:
    pytest.importorskip("sksundae", reason="needs scikit-sundae, the extra simulate")
    from closed_mechanisms import n_four_bar

    with pytest.raises(SimulateError, match=r"ida does not apply: the loops hold coordinates in proportion"):
        simulate(n_four_bar(2), until=0.1, method="ida")


# Rows that hold velocities alone


def lowest(run: Trajectory) -> np.ndarray:
    """Return the height of the disc's lowest point over the ground."""
    _, _, z, e0, e1, e2, e3 = run.q.T
    axis = 2 * (e2 * e3 + e0 * e1)  # of the disc, upwards
    return z - 0.3 * np.sqrt(1 - axis * axis)


def test_a_disc_rolls_on_the_ground_and_keeps_its_energy() -> None:
    found = simulate(DISC, until=5.0, rtol=1e-12)
    turned = np.degrees(2 * np.arccos(np.abs(found.q[:, 3])))

    assert found.stopped == "end"
    assert turned.max() > 170  # through all attitudes, where a choice of velocities may become singular
    assert found.monitors["energy"] < 1e-9 * found.monitors["energy_scale"]
    assert found.monitors["loop_rates"] < 1e-11
    assert np.abs(lowest(found)).max() < 1e-10


def test_a_disc_rolls_in_a_circle() -> None:
    """Steady turn: (I3 + m r²) ω Ω cos λ = I1 Ω² cos λ sin λ - m g r sin λ, λ its lean, Ω about the vertical."""
    m, r, g, lean, turn = 1.0, 0.3, 9.81, np.pi / 12, 1.7
    I1, I3, s, c = m * r * r / 4, m * r * r / 2, np.sin(lean), np.cos(lean)
    spin = (I1 * turn**2 * c * s - m * g * r * s) / ((I3 + m * r * r) * turn * c)
    rates = {"flight_vx": spin * r, "flight_wy": spin, "flight_wx": 0.0, "flight_wz": turn * c}
    period = 2 * np.pi / turn
    found = simulate(DISC, until=period, rtol=1e-12, start_rates={k: repr(float(x)) for k, x in rates.items()})
    e0, e1, e2, e3 = found.q[:, 3:].T

    assert np.ptp(2 * (e2 * e3 + e0 * e1)) < 1e-9  # the lean stays
    assert np.abs(found.q[-1, :3] - found.q[0, :3]).max() < 1e-8  # and the circle closes
    across = np.ptp(found.q[:, :2], axis=0)
    assert across == pytest.approx(np.full(2, 2 * abs(spin * r / turn)), rel=1e-3)


# Prescribed motions


def carried() -> Scene:
    """A point mass on a metre of rod, hung from a slide that shakes."""
    return read_text(
        """
        name = "carried"
        gravity = [0, -9.81, 0]
        [bodies.slide]
        mass = 2
        [bodies.rod]
        mass = 1
        com = [0, -1, 0]
        [joints.shaker]
        type = "prismatic"
        parent = "ground"
        child = "slide"
        axis = [1, 0, 0]
        coordinate = "x"
        motion = "0.3*sin(4*t)"
        [joints.hinge]
        type = "revolute"
        parent = "slide"
        child = "rod"
        axis = [0, 0, 1]
        coordinate = "theta"
        drive = false
        start = 0.4
        """
    )


@pytest.mark.parametrize("method", ["taylor", "dop853", "ida"])
def test_a_shaken_pendulum_follows_its_slide(method: str) -> None:
    pytest.importorskip({"taylor": "heyoka", "ida": "sksundae"}.get(method, "scipy"))
    found = simulate(carried(), until=3.0, method=method, rtol=1e-11, every=0.5)

    def pendulum(t: float, y: np.ndarray) -> list[float]:
        return [y[1], -9.81 * np.sin(y[0]) + 4.8 * np.sin(4 * t) * np.cos(y[0])]

    by_hand = solve_ivp(pendulum, (0, 3), [0.4, 0], "DOP853", found.t, rtol=1e-13, atol=1e-13)
    x, theta = found.q.T
    bound = 1e-6 if method == "ida" else 1e-8
    assert np.abs(x - 0.3 * np.sin(4 * found.t)).max() < bound
    assert np.abs(theta - by_hand.y[0]).max() < bound
    force = 3 * found.qdd[:, 0] + np.cos(theta) * found.qdd[:, 1] - np.sin(theta) * found.qd[:, 1] ** 2
    assert found.tau[:, 0] == pytest.approx(force, abs=1e-6)  # what the shaker takes, Newton's law for both
    assert np.abs(found["work"]).max() > 0.1
    assert found.monitors["energy"] < 1e-6


@pytest.mark.parametrize("method", ["dop853", "ida"])
def test_a_crank_that_is_led_leads_its_loop(method: str) -> None:
    pytest.importorskip({"ida": "sksundae"}.get(method, "scipy"))
    scene = crank_rocker()
    led = replace(scene.joints[0], start=(), motion=formula("4/5 + 3*t + 0.2*sin(5*t)"))
    scene_led = replace(scene, joints=(led, *scene.joints[1:]))
    found = simulate(scene_led, until=2.0, method=method, rtol=1e-10, every=0.1)
    wanted = inverse(scene, read_motion(scene, ["q_A=4/5 + 3*t + 0.2*sin(5*t)"]), found.t)

    assert np.abs(found.q - wanted.q).max() < 1e-6
    assert found.tau[:, 0] == pytest.approx(wanted.tau[:, 0], rel=1e-5, abs=1e-5 * np.abs(wanted.tau).max())
    assert found.monitors["loops"] < 1e-8
    assert found.monitors["energy"] < 1e-6 * found.monitors["energy_scale"]


ON_ITS_AXIS = """
name = "mast"
[bodies.cross]
mass = 0
[bodies.bob]
particles = [{ mass = 1, at = [0, 0, -1] }]
[joints.turn]
type = "revolute"
parent = "ground"
child = "cross"
axis = [0, 0, 1]
[joints.swing]
type = "revolute"
parent = "cross"
child = "bob"
axis = [1, 0, 0]
"""


def test_inverse_finds_the_forces_of_a_run_that_has_a_prescribed_motion(tmp_path: Path) -> None:
    run = simulate(carried(), until=1.0, method="dop853", rtol=1e-12)
    run.to_csv(tmp_path / "run.csv")
    found = inverse(carried(), read_motion(carried(), [str(tmp_path / "run.csv")]), run.t)

    assert found.tau == pytest.approx(run.tau, abs=1e-8)
    with pytest.raises(SimulateError, match="x has a prescribed motion in the scene"):
        inverse(carried(), read_motion(carried(), ["x=t"]), [0.0])


def test_too_many_samples_are_counted() -> None:
    with pytest.raises(SimulateError, match=r"every = 1e-09 s makes 1e\+09 samples of 1 s; 2e\+07 are the most"):
        simulate(carried(), until=1.0, every=1e-9)


def test_a_start_where_a_velocity_moves_no_mass_is_told() -> None:
    scene = read_text(ON_ITS_AXIS)

    with pytest.raises(SimulateError, match=r"^mast: q1_dot moves no mass at the start"):
        simulate(scene, until=1.0)
    with pytest.raises(SimulateError, match=r"q1_dot moves no mass at the start"):
        simulate(scene, until=1.0, start={"q1": "1"})
    assert simulate(scene, until=1.0, start={"q2": "0.5"}, start_rates={"q1": "3"}).stopped == "end"
