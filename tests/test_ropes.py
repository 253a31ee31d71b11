"""Ropes: closed forms of textbooks, structure matrices of cable robots, convex hulls, MuJoCo's tendons, proofs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from engine.balance import balance
from engine.mechanism import Mechanism
from numpy.testing import assert_allclose
from placeless import placeless
from scipy.integrate import solve_ivp
from scipy.spatial import ConvexHull

import symdyn
import symdyn.scene as declared
from symdyn.errors import DerivationError, SceneError, SimulateError
from symdyn.scene import Scene, body, elastic_rope, output, planar, prismatic, revolute, rope, rope_damping
from symdyn.scene.scene_files import write_text as write_as
from symdyn.scene.toml import write_text
from symdyn.teach import walkthrough
from symdyn.teach.render.markdown import markdown
from symdyn.verdict import Verdict
from symdyn.verify import certify

G = 9.81

Y = [0, 1, 0]
"""The axis of what turns in the plane of x and z."""


def hanging(name: str, at: Any, start: Any = 1, drive: Any = False) -> Any:
    """Return a slide downwards whose coordinate is how far below z = 0 its body hangs."""
    return prismatic(
        f"slide_{name}", "ground", name, origin=[at, 0, 0], axis=[0, 0, -1], coordinate=f"x_{name}", start=start,
        drive=drive,
    )  # fmt: skip


def wheel(radius: Any, turn: str = "left", on: str = "ground", at: Sequence[Any] = (0, 0, 0)) -> dict[str, Any]:
    return {"body": on, "at": list(at), "radius": radius, "axis": Y, "turn": turn}


def atwood(*ropes: Any, **more: Any) -> Scene:
    """Return two masses of 2 and 3 kg that hang at x = ± r, r = 1/2 m."""
    bodies = [body("a", mass=2), body("b", mass=3)]
    joints = [hanging("a", "-r"), hanging("b", "r", 2)]
    more["parameters"] = {"r": "1/2", "l": "3 + pi/2"} | more.get("parameters", {})
    return declared.scene("atwood", bodies=bodies, joints=joints, ropes=ropes, **more)


def around(**more: Any) -> Scene:
    return atwood(rope("r", ["a", wheel("r"), "b"], length="l"), **more)


loaded = cache(symdyn.lambdify)


def at(scene: Scene, request: str, q: Any, qd: Any = None, tau: Any = None) -> Any:
    """Return the values of an output at a state."""
    function = loaded(scene, request)
    n = len(scene.velocities)
    state = {"q": q, "qd": np.zeros(n) if qd is None else qd, "tau": np.zeros(n) if tau is None else tau}
    return function(*(state[one.name] for one in function.operands if one.name in state))


# Textbooks


def test_atwood_hangs_on_a_wheel_or_a_point_alike() -> None:
    through_points = atwood(
        rope(
            "r", ["a", {"body": "ground", "at": ["-1/2", 0, 0]}, {"body": "ground", "at": ["1/2", 0, 0]}, "b"], length=4
        )
    )
    for scene in (around(), through_points):
        assert_allclose(at(scene, "tension:r", [1, 2]), 2 * 2 * 3 * G / 5, rtol=1e-14)
        assert_allclose(at(scene, "forward_dynamics", [1, 2]), [-G / 5, G / 5], rtol=1e-14)


def test_the_condition_is_printed_in_letters() -> None:
    page = symdyn.equations(around())
    text = page.text()

    assert "-pi*r + l - x_a - x_b = 0" in text
    assert "tension of rope r" in text
    assert sympy.diag(2, 3) == page.sympy().M


def test_two_machines_on_one_rope_accelerate_as_newton_s_laws_say() -> None:
    m1, m2, m3, p = 7.0, 2.0, 3.0, 0.5
    bodies = [body(name, mass=mass) for name, mass in zip("pabc", (p, m1, m2, m3), strict=True)]
    ropes = [rope("upper", ["a", "ground", "p"], length=3), rope("lower", ["b", "p", "c"], length=3)]
    joints = [hanging("p", 0), hanging("a", 0, 2), hanging("b", 0, 2), hanging("c", 0, 3)]
    scene = declared.scene("double", bodies=bodies, joints=joints, ropes=ropes)
    rows = np.array([
        [p, 0, 0, 0, 1, -2], [0, m1, 0, 0, 1, 0], [0, 0, m2, 0, 0, 1], [0, 0, 0, m3, 0, 1], [1, 1, 0, 0, 0, 0],
        [-2, 0, 1, 1, 0, 0],
    ])  # fmt: skip
    found = np.linalg.solve(rows, [p * G, m1 * G, m2 * G, m3 * G, 0, 0])

    assert_allclose(at(scene, "forward_dynamics", [1, 2, 2, 3]), found[:4], rtol=1e-13)
    assert_allclose([at(scene, f"tension:{one}", [1, 2, 2, 3]) for one in ("upper", "lower")], found[4:], rtol=1e-13)


@pytest.mark.parametrize("parts", [2, 3, 4, 5])
def test_block_and_tackle_is_held_by_a_share_of_the_load(parts: int) -> None:
    places = ["ground", "block"] if parts % 2 == 0 else ["block", "ground"]
    through = [*(places * parts)[: parts + 1], "hand"]
    scene = declared.scene(
        "tackle",
        bodies=[body("block", mass=12), body("hand", mass=1)],
        joints=[hanging("block", 0), hanging("hand", 0, drive="F")],
        ropes=[rope("r", through, length=parts + 1)],
    )
    held = at(scene, "forward_dynamics", [1, 1], tau=[0, 12 * G / parts - G])

    assert through[-2] == "ground"
    assert_allclose(held, 0, atol=1e-12)
    assert_allclose(at(scene, "tension:r", [1, 1], tau=[0, 12 * G / parts - G]), 12 * G / parts, rtol=1e-13)


def wound(*ropes: Any, inertia: float = 3.0) -> Scene:
    """Return a drum, at rest where its ropes hang straight, with masses of 2 and 5 kg beside it."""
    turning = revolute("pin", "ground", "drum", axis=Y, coordinate="phi", drive=False)
    bodies = [body("drum", mass=1, inertia=[2, inertia, 2], about="com"), body("a", mass=2), body("b", mass=5)]
    return declared.scene(
        "winch", bodies=bodies, joints=[turning, hanging("a", "-1/2"), hanging("b", "1/4")], ropes=ropes
    )


def test_a_drum_is_turned_by_what_hangs_on_it() -> None:
    left, right = wheel("1/2", "left", "drum"), wheel("1/4", "right", "drum")
    scene = wound(rope("left", ["a", left], length=1), rope("right", ["b", right], length=1))
    alpha = (5 * G / 4 - 2 * G / 2) / (3 + 2 / 4 + 5 / 16)  # two radii, by moments about the pin
    found = at(scene, "forward_dynamics", [0, 1, 1])

    assert_allclose(found, [alpha, -alpha / 2, alpha / 4], rtol=1e-13)
    assert_allclose(at(scene, "constraint_residual", [9, 1 - 4.5, 1 + 9 / 4]), 0, atol=1e-14)  # more than a turn
    assert_allclose(at(scene, "tension:right", [0, 1, 1]), 5 * (G - alpha / 4), rtol=1e-13)


def test_a_rope_that_does_not_slip_feels_the_wheel_and_one_that_slips_does_not() -> None:
    both = [wheel("1/2", "left", "drum"), wheel("1/2", "left", "drum")]
    bodies = [body("drum", mass=1, inertia=[2, 3, 2], about="com"), body("a", mass=2), body("b", mass=5)]
    joints = [revolute("pin", "ground", "drum", axis=Y, coordinate="phi", drive=False)]
    joints += [hanging("a", "-1/2"), hanging("b", "1/2")]
    held = [rope("l", ["a", both[0]], length=1), rope("r", [both[1], "b"], length=1)]
    slips = [rope("r", ["a", both[0], "b"], length="2 + pi/2")]
    for ropes, inertia in ((held, 3 / 0.25), (slips, 0.0)):
        scene = declared.scene("pulley", bodies=bodies, joints=joints, ropes=ropes)
        a = 3 * G / (7 + inertia)
        assert_allclose(at(scene, "forward_dynamics", [0, 1, 1])[1:], [-a, a], rtol=1e-12)


# Geometry that is not ours


def led(*through: Any, length: Any = 5) -> Scene:
    """Return a free plate in the plane of x and z with a rope."""
    plate = body("plate", mass=2, inertia=[1, 1.5, 1], about="com", com=["1/10", 0, "1/5"])
    moves = planar("moves", "ground", "plate", axis=Y, coordinates=["x", "z", "phi"], start=[1, -2, "1/5"], drive=False)
    return declared.scene("led", bodies=[plate], joints=[moves], ropes=[rope("r", through, length)])


CORNER = {"body": "plate", "at": ["1/4", 0, "1/3"]}
ANCHOR = {"body": "ground", "at": ["-5/2", 0, "-1"]}
WHEELS = [wheel("1/2", at=(-1, 0, "1/2")), wheel("3/10", at=("3/5", 0, "4/5"))]


def placed(q: Sequence[float], corner: Sequence[float] = (0.25, 1 / 3)) -> np.ndarray:
    """Return where a corner of the plate is, which turns about y: z towards x."""
    x, z, phi = q
    c, s, (a, b) = math.cos(phi), math.sin(phi), corner
    return np.array([x + c * a + s * b, z - s * a + c * b])


def coordinates(place: Sequence[float]) -> np.ndarray:
    """Return the coordinates of a planar joint about y, whose second axis is downwards."""
    return np.array([place[0], -place[1], place[2]])


STATES = [(1.0, -2.0, 0.2), (1.3, -1.5, 0.0), (2.0, -1.0, -0.7), (0.9, -2.5, 1.0)]


def test_a_taut_rope_is_a_part_of_a_convex_hull() -> None:
    scene = led(ANCHOR, *WHEELS, CORNER)
    circles = np.linspace(0, 2 * math.pi, 40001)[:-1]
    for place in STATES:
        q, corner = coordinates(place), placed(place)
        spots = [np.array([-2.5, -1.0]), corner]
        for (x, z), r in (((-1, 0.5), 0.5), ((0.6, 0.8), 0.3)):
            spots += [np.array([x, z]) + r * np.stack([np.cos(circles), np.sin(circles)], axis=1)]
        whole = ConvexHull(np.vstack(spots)).area  # the perimeter, in a plane
        assert_allclose(5 - at(scene, "constraint_residual", q), whole - np.linalg.norm(corner - spots[0]), rtol=1e-8)


def test_rows_of_a_cable_robot_are_its_structure_matrix() -> None:
    anchors = [(-3, 0), (-3, 4), (3, 4), (3, 0)]
    corners = [(-0.5, -0.2), (-0.5, 0.2), (0.5, 0.2), (0.5, -0.2)]
    plate = body("plate", mass=2, inertia=[1, 1, 1], about="com")
    moves = planar("moves", "ground", "plate", axis=Y, coordinates=["x", "z", "phi"], start=[0, 2, 0], drive=False)
    ropes = [
        elastic_rope(
            f"r{k}", [{"body": "ground", "at": [a[0], 0, a[1]]}, {"body": "plate", "at": [str(b[0]), 0, str(b[1])]}],
            stiffness=300, free=1,
        )
        for k, (a, b) in enumerate(zip(anchors, corners, strict=True))
    ]  # fmt: skip
    scene = declared.scene("robot", gravity="none", bodies=[plate], joints=[moves], ropes=ropes)
    q = coordinates((0.3, 1.7, 0.2))
    J = at(scene, "jacobian:plate", q)
    wrench = np.zeros(3)
    for k, (a, b) in enumerate(zip(anchors, corners, strict=True)):
        corner = placed((0.3, 1.7, 0.2), b)
        way, lever = a - corner, corner - (0.3, 1.7)
        T = 300 * (np.linalg.norm(way) - 1)
        u = way / np.linalg.norm(way)
        assert_allclose(at(scene, f"tension:r{k}", q), T, rtol=1e-13)
        wrench += T * np.array([*u, lever[1] * u[0] - lever[0] * u[1]])  # about y

    assert_allclose(at(scene, "elastic_forces", q), -J[[0, 2, 4]].T @ wrench, rtol=1e-11)


TENDON = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <site name="anchor" pos="-2.5 0 -1"/><site name="above" pos="-1 0 3"/>
    <geom name="wheel" type="cylinder" size="0.5 0.1" pos="-1 0 0.5" euler="1.5707963267948966 0 0"/>
    <body name="plate">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>
      <geom type="sphere" size="0.1" mass="1"/><site name="corner" pos="0.25 0 0.3333333333333333"/>
    </body>
  </worldbody>
  <tendon><spatial name="r">
    <site site="anchor"/><geom geom="wheel" sidesite="above"/><site site="corner"/>
  </spatial></tendon>
</mujoco>
"""


def test_mujoco_s_tendon_is_as_long_and_pulls_alike() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(TENDON)
    data, scene = mujoco.MjData(model), led(ANCHOR, WHEELS[0], CORNER)
    for place in STATES:
        q = coordinates(place)
        data.qpos[:] = place
        mujoco.mj_forward(model, data)
        J, moment = at(scene, "jacobian:plate", q)[[0, 2, 4]], np.asarray(data.ten_J).reshape(-1)[:3]
        assert_allclose(5 - at(scene, "constraint_residual", q), data.ten_length, rtol=1e-12)
        assert_allclose(-at(scene, "constraint_jacobian", q)[0], moment @ J, atol=1e-12)


# Other formulations


def bungee() -> Scene:
    """Return a plate and a mass with an elastic rope, its damping, and a rope of a length, none along an axis."""
    plate = body("plate", mass=2, inertia=[1, 1.5, 1], about="com", com=["1/10", 0, "1/5"])
    moves = planar("moves", "ground", "plate", axis=Y, coordinates=["x", "z", "phi"], start=[1, -2, "1/5"], drive=False)
    through: list[Any] = [ANCHOR, CORNER, {"body": "load", "at": [0, "1/10", 0]}]
    ropes = [
        elastic_rope("e", through, stiffness=[40, 3], free=2, preload=1),
        rope_damping("d", through[1:], damping=[2, "1/3"]),
        rope("r", [CORNER, {"body": "ground", "at": [1, 1, 1]}, "load"], length=6),
    ]
    joints = [moves, hanging("load", 2, 2)]
    return declared.scene("bungee", bodies=[plate, body("load", mass=3)], joints=joints, ropes=ropes)


def test_the_reference_of_the_tests_moves_alike() -> None:
    scene, rng = bungee(), np.random.default_rng(34)
    mechanism = Mechanism(scene)
    for q in ([1, -2, 0.2, 2], [0.3, -1, 0, 1], [-1, -1.5, 2, 3]):
        u = rng.uniform(-1, 1, 4)
        found = balance(mechanism.at(q, u), np.full(4, np.nan), np.zeros(4))
        assert_allclose(at(scene, "forward_dynamics", q, u), found.du, rtol=1e-9, atol=1e-10)


PROVED = {
    "atwood": around,
    "drum": lambda: wound(rope("r", ["a", wheel("1/2", "left", "drum")], length=1)),
    "wheels": lambda: led(ANCHOR, *WHEELS, CORNER),
    "bungee": bungee,
}


@pytest.mark.long(1)
@pytest.mark.heavy("bungee")
@pytest.mark.usefixtures("numpy_alone")
@pytest.mark.parametrize("name", PROVED)
def test_lengths_differentiated_and_tensions_along_the_tree_are_proved_equal(name: str) -> None:
    scene = PROVED[name]()
    names = ["constraint_jacobian", "constraint_bias", "constraint_residual", "forward_reactions"]
    certificate = certify(scene, [*names, "forward_dynamics", f"tension:{scene.ropes[0].name}"])

    assert certificate.verdict is Verdict.PROVED or certificate.passed, str(certificate)


def test_derivatives_are_those_of_small_steps() -> None:
    scene, q, step = led(ANCHOR, *WHEELS, CORNER), np.array([1.0, -2.0, 0.2]), 1e-5
    slopes = at(scene, "constraint_jacobian", q)
    steps = [q + step * e for e in np.eye(3)], [q - step * e for e in np.eye(3)]
    up, down = ([at(scene, "constraint_residual", one)[0] for one in some] for some in steps)

    assert_allclose(slopes[0], (np.array(up) - down) / (2 * step), atol=1e-9)


def test_a_rope_without_length_at_the_start_is_refused() -> None:
    bodies, joints = [body("a", mass=2), body("b", mass=3)], [hanging("a", 0, 0), hanging("b", 0, 0)]
    scene = declared.scene("start", bodies=bodies, joints=joints, ropes=[rope("r", ["a", "ground", "b"], length=4)])

    with pytest.raises(DerivationError) as refused:
        at(scene, "constraint_jacobian", [1, 3])
    assert str(refused.value) == (
        "start: the rope r (two of its places meet, or one is inside of a wheel) has no real value at x_a = 0, "
        "x_b = 0; give the scene a start where it has one"
    )


# Runs


def bob(degrees: float) -> Scene:
    """Return a mass of 1 kg on a rope of 2 m, at rest at an angle from straight down."""
    at = f"{degrees} deg"
    start: list[Any] = [f"2*sin({at})", f"2*cos({at})", 0]
    moves = planar("moves", "ground", "bob", axis=Y, coordinates=["x", "z", "phi"], drive=False, start=start)
    return declared.scene(
        "bob", bodies=[body("bob", mass=1, inertia=[1, 1, 1], about="com")], joints=[moves],
        ropes=[rope("r", ["ground", "bob"], length=2)], outputs=[output("pull", "tension_r")],
    )  # fmt: skip


@pytest.mark.runs("cc")
def test_a_run_tells_the_tension() -> None:
    run = symdyn.simulate(bob(60), until=0.5)
    u = run.qd[:, 0] ** 2 + run.qd[:, 1] ** 2

    assert_allclose(run["pull"], G / 2 + 3 * u / 4, rtol=1e-9)  # m g cos + m v²/l, and v² = 2 g (h₀ - h)
    assert run.monitors["tension r"] == pytest.approx(G / 2)
    assert not run.notes


@pytest.mark.runs("cc")
def test_a_run_tells_where_a_rope_would_push() -> None:
    run = symdyn.simulate(bob(120), until=0.01)

    (note,) = run.notes
    assert note.startswith("rope r: it would push at t = 0 s, by up to 4.9")
    assert note.endswith("; it goes slack there, which this model does not know")


@pytest.mark.runs("cc")
def test_a_run_ends_where_the_tension_vanishes() -> None:
    run = symdyn.simulate(bob(0), until=2, start_rates={"x": 7.0, "z": 0, "phi": 0}, stops="tension_r")

    assert run.stopped == "tension_r"
    assert_allclose(-run.q[-1][1], (7.0**2 - 2 * 2 * G) / (3 * G), rtol=1e-8)  # where m v²/l is the weight's share


def over_a_wheel(made: Any = rope, **law: Any) -> Scene:
    """Return a mass on a rope that comes along a level way to the top of a wheel and hangs straight down beside it."""
    moves = planar("moves", "ground", "bob", axis=Y, coordinates=["x", "z", "phi"], start=["1/2", 2, 0], drive=False)
    over = made("r", [{"body": "ground", "at": [-1, 0, "1/2"]}, wheel("1/2"), "bob"], **law or {"length": "3 + pi/4"})
    mass = body("bob", mass=1, inertia=[1, 1, 1], about="com")
    return declared.scene("over", bodies=[mass], joints=[moves], ropes=[over])


LIFTS = (
    "rope r: what lies around its wheel on ground is nothing, or almost a turn; there the rope "
    "takes another way, which these equations do not know"
)


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("method", "speed"), [("dop853", 7.0), ("lsoda", 40.0), ("taylor", 40.0)])
def test_a_run_ends_where_a_rope_lifts_off_its_wheel(method: Any, speed: float) -> None:
    """With the wrap φ and s = l - r φ, s φ'' = g cos φ + r φ'²: the pendulum whose thread winds around a cylinder."""
    with pytest.warns(RuntimeWarning, match="is nothing"):
        run = symdyn.simulate(
            over_a_wheel(), until=2, start_rates={"x": speed, "z": 0, "phi": 0}, method=method, rtol=1e-9
        )
    length, r = 2 + math.pi / 4, 0.5
    event: Any = lambda t, y: y[0] - 0.001  # noqa: E731
    event.terminal = True
    found = solve_ivp(
        lambda t, y: [y[1], (G * math.cos(y[0]) + r * y[1] ** 2) / (length - r * y[0])],
        (0, 2), [math.pi / 2, -speed / 2], events=event, rtol=1e-11, atol=1e-12,
    )  # fmt: skip

    assert run.stopped.endswith(f"s: {LIFTS}")
    assert run.t[-1] == pytest.approx(found.t[-1], rel=1e-4)
    assert_allclose(run.q[-1][:2], [2 + math.pi / 4, -0.5], atol=0.003)


@pytest.mark.runs("cc")
def test_an_elastic_rope_lifts_off_too_and_a_slow_one_stays() -> None:
    stiff = over_a_wheel(elastic_rope, stiffness=3000, free="3 + pi/4")
    for scene in (stiff, over_a_wheel()):
        slow = symdyn.simulate(scene, until=2, start_rates={"x": 2.0, "z": 0, "phi": 0})
        assert slow.complete
    with pytest.warns(RuntimeWarning, match="is nothing"):
        run = symdyn.simulate(stiff, until=2, start_rates={"x": 20.0, "z": 0, "phi": 0})
    assert run.t[-1] < 0.3


@pytest.mark.runs("cc")
def test_a_prescribed_motion_ends_where_a_rope_lifts_off_its_wheel() -> None:
    """Level with the top of the wheel the rope is straight: the bob is raised there in a second and a half."""
    with pytest.warns(RuntimeWarning, match="is nothing"):
        run = symdyn.inverse(over_a_wheel(), {"z": "1 - t", "phi": "0"}, until=3, every=0.25, start={"x": 2})

    assert run.stopped == f"motion: t = 1.5 s: {LIFTS}"
    assert len(run.t) == len(run["loop_error"]) == 6
    with pytest.raises(SimulateError, match=f"motion: t = 0 s: {LIFTS}"):
        symdyn.inverse(over_a_wheel(), {"z": "-1/2 - t", "phi": "0"}, until=3, start={"x": 3})


@pytest.mark.runs("cc")
def test_a_prescribed_motion_tells_where_a_rope_would_push() -> None:
    """A drum pays out rope faster than its load falls: T = m (g - r φ'')."""
    left, right = wheel("1/2", "left", "drum"), wheel("1/4", "right", "drum")
    scene = wound(rope("left", ["a", left], length=1), rope("right", ["b", right], length=1))
    run = symdyn.inverse(scene, {"phi": "if(t > 1/4, 30, 3)*(t - 1/4)**2"}, until=0.5, every=0.125)

    assert run.monitors == pytest.approx({"tension left": 2 * (G + 3), "tension right": 5 * (G - 15)})
    assert (
        "rope right: it would push at t = 0.375 s, by up to 25.9 N at t = 0.375 s; it goes slack there, "
        "which this model does not know"
    ) in run.notes


# What is said of it


def written(scene: Scene, file: Path) -> Path:
    file.write_text(write_text(scene).text)
    return file


def test_it_is_written_read_and_named(tmp_path: Path) -> None:
    for scene in (bungee(), led(ANCHOR, *WHEELS, CORNER)):
        assert symdyn.read(written(scene, tmp_path / "again.toml")).elements == scene.elements
    named = declared.with_symbols(scene, "geometry")
    free = {one.name for one in named.parameters}

    assert {"L1", "r_c1_1", "r_c1_2", "a_c1_0", "d_c1_3"} <= free
    assert_allclose(at(named, "constraint_residual", [1, 2, 0.2]), at(scene, "constraint_residual", [1, 2, 0.2]))


def test_robot_files_refuse_it() -> None:
    with pytest.raises(SceneError) as refused:
        write_as(around(), "urdf")

    assert "ropes.r: a rope, which acts in the equations" in str(refused.value)


def test_a_picture_draws_it_around_its_wheel() -> None:
    drawn = symdyn.picture(around())

    assert drawn.count('class="rope"') >= 2  # the rope, and the rim


@pytest.mark.parametrize("back", [False, True])
def test_a_picture_draws_it_wherever_it_begins(back: bool) -> None:
    through: list[Any] = [wheel("r"), "a"]

    drawn = symdyn.picture(atwood(rope("r", through[::-1] if back else through, length="l")))

    assert 'class="rope"' in drawn


def test_a_lesson_says_what_it_keeps_and_what_its_multiplier_is() -> None:
    page = markdown(walkthrough(around(), until="equations"))["atwood.md"]

    assert "Rope r keeps its length (a – ground – b): its straight parts, and what lies around wheels," in page
    assert "the tension of rope r, positive where it pulls" in page


def test_a_lesson_names_slopes_that_are_longer_than_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    def page() -> str:
        return str(markdown(walkthrough(over_a_wheel(), until="equations"))["over.md"])

    named = r"\begin{bmatrix} J_{11} & J_{12} & 0 \end{bmatrix}"
    assert named not in page()  # in lowest terms they are short
    monkeypatch.setattr("symdyn.teach.derivations.multiplier_steps.PAGE", 1)
    assert named in page()


def test_a_lesson_by_d_alembert_asks_no_drive_for_a_motion_that_none_gives() -> None:
    bodies = [body("a", mass=2), body("b", mass=3), body("c", mass=1, com=[0, 0, -1])]
    swings = revolute("h", "b", "c", axis=Y, coordinate="th", drive=False)
    joints = [hanging("a", "-1/2", drive="F"), hanging("b", "1/2", 2), swings]
    ropes = [rope("r", ["a", wheel("1/2"), "b"], length="3 + pi/2")]
    hung = declared.scene("hung", bodies=bodies, joints=joints, ropes=ropes)

    page = markdown(walkthrough(hung, formulation="dalembert"))["hung.md"]
    assert "The reactions obey the laws of mechanics." in page


ROUTE = (
    'write through = ["hook", "pulley", "load"], each the name of a body or point or { body = "NAME", at = [0, 0, 0] '
    '}, or a wheel, { body = "NAME", radius = 0.1, turn = "left" }'
)
SEEN = 'write turn = "left" or "right", as the rope turns, seen with the axis towards the eye'
BACK = '["a", "ground", { body = "ground", at = [1, 0, 0] }]'
OVER = '["a", { body = "ground", %s }, "b"]'

FAULTS = {  # of `through`, of `length`, what is said
    "one place": ('["a"]', "1", f'through = ["a"] is no list of two places or more; {ROUTE}'),
    "no place": ("", "1", f"through is missing; {ROUTE}"),
    "no name": ('["a", "grund"]', "1", 'through[1] = "grund" is neither a body nor a point; did you mean ground?'),
    "no end": ('["a", 7]', "1", f"through[1] = 7 is no end; {ROUTE}"),
    "no length": ('["a", "ground"]', "", "length is missing; write length = 2"),
    "zero": ('["a", "ground"]', "0", "length = 0 is that of no rope; give one above zero"),
    "negative": ('["a", "ground"]', '"-l"', "length = -l is that of no rope; give one above zero"),
    "heavy": ('["a", "ground"]', '"2 kg"', 'length = "2 kg" is in kg, and m is asked for'),
    "one body": (
        BACK, "1",
        'through[1] and through[2] are on one body, "ground", so that this end of the rope never changes and does '
        "nothing; end with through[1]",
    ),
    "point": (OVER % "radius = 0, turn = 'left'", "1", "through[1]: radius = 0 is that of no wheel; give one above"),
    "no turn": (OVER % "radius = 1", "1", f"ropes.r: through[1]: turn is missing; {SEEN}"),
    "up": (OVER % "radius = 1, turn = 'up'", "1", f'through[1]: turn = "up" is neither left nor right; {SEEN}'),
    "no wheel": (
        OVER % "turn = 'left'", "1",
        "through[1]: turn goes with the radius of a wheel; write radius = 0.1, or leave turn out",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_wrong_is_told_in_words(fault: str, tmp_path: Path) -> None:
    through, length, told = FAULTS[fault]
    file = tmp_path / "s.toml"
    before = written(around(), file).read_text().split("[ropes.r]")[0]
    said = (f"{key} = {value}" for key, value in (("through", through), ("length", length)) if value)
    file.write_text("\n".join([before, "[ropes.r]", *said, ""]))

    with pytest.raises(SceneError) as refused:
        symdyn.read(file)
    assert (
        placeless(refused.value)
        .split("\n")[0]
        .startswith(f"{file}: ropes.r: {told}".replace("ropes.r: ropes.r", "ropes.r"))
    )
    assert "\n" not in str(refused.value)


def test_what_has_no_length_or_no_plane_is_refused() -> None:
    inside = led(ANCHOR, wheel(3), CORNER)
    with pytest.raises(DerivationError) as refused:
        at(inside, "constraint_jacobian", [1, 2, 0.2])
    assert str(refused.value) == (
        "led: the rope r (two of its places meet, or one is inside of a wheel) has no real value at x = 1, "
        "z = -2, phi = 0.2; give the scene a start where it has one"
    )
    across = led(ANCHOR, {**wheel("1/2"), "axis": [0, 0, 1]}, CORNER)
    with pytest.raises(DerivationError) as refused:
        at(across, "constraint_jacobian", [1, 2, 0.2])
    assert str(refused.value) == (
        "led: a rope from ground to ground leaves the plane of its wheel, whose axis is not across the way; place both "
        "in one plane with axes across it, or lead it through a point"
    )
    with pytest.raises(DerivationError) as refused:
        at(around(), "tension:q", [1, 2])
    assert str(refused.value) == "atwood: there is no rope 'q' in [ropes]; there are r"
