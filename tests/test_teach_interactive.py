"""The interactive page in a real browser: it computes what Python computes, plays, and fits a phone."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import move, opened, played, typed, values
from scipy.integrate import solve_ivp

import symdyn
from symdyn.draw.places import places
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import DrawError, TeachError
from symdyn.program import lower
from symdyn.runtime import run_python
from symdyn.scene import Scene, read, read_text
from symdyn.scene.forces import elastic
from symdyn.scene.joints.joint_table import start_of
from symdyn.teach.languages import language_of, languages
from symdyn.teach.render.live import absence, by_hand, live
from symdyn.teach.render.page import interactive, interactive_page

EXAMPLES = Path(__file__).parent.parent / "examples"

EVERYTHING = """
name = "everything"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 2, unit = "kg", positive = true }
c = { value = 30, unit = "N/m" }
d = { unit = "N s/m", positive = true }
F = { value = 3, unit = "N", text = "</script><script>throw 1</script><!-- " }
g = { unit = "m/s^2", positive = true }
[bodies.arm]
mass = "m"
com = [0.5, 0, 0]
inertia = [0.01, 0.2, 0.2]
inertia_about = "com"
[bodies.slide]
mass = 1
inertia = [0.02, 0.02, 0.01]
inertia_about = "com"
[bodies.end]
mass = 0.4
com = [0, 0, 0.2]
inertia = [0.01, 0.01, 0.02]
inertia_about = "com"
particles = [{ mass = 0.3, at = [0.1, 0, 0.3] }]
[joints.a]
type = "revolute"
parent = "ground"
child = "arm"
axis = [0, 1, 0]
damping = "d/5"
limits = { lower = -1, upper = 2 }
[joints.b]
type = "prismatic"
parent = "arm"
child = "slide"
axis = [1, 0, 0]
origin = [1, 0, 0]
[joints.u]
type = "universal"
parent = "slide"
child = "end"
axis = [0, 1, 0]
second_axis = [0, 0, 1]
[springs.s]
from = { body = "ground", at = [0, 0, 1] }
to = "slide"
stiffness = "c"
free = 0.4
[dampers.b]
from = { body = "ground", at = [0, 0, 1] }
to = "slide"
damping = "d"
[loads.push]
body = "end"
at = [0, 0, 0.3]
force = ["F*cos(2*t)", 0, 0]
frame = "ground"
[points.tool]
body = "end"
at = [0, 0, 0.4]
"""


def scene_of(name: str) -> Scene:
    return read_text(EVERYTHING, "everything.toml") if name == "everything" else read(EXAMPLES / f"{name}.toml")


def saved(scene: Scene, folder: Path, language: str = "en") -> Path:
    """Return a page on disk."""
    path = folder / f"{scene.name}.html"
    path.write_text(interactive_page(scene, language=language), encoding="utf-8")
    return path


def freed(scene: Scene) -> Scene:
    return replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))


@pytest.mark.wide("cart_pole", "everything")
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "scara", "everything"])
def test_numbers_follow_the_sliders_and_are_what_python_computes(browser: Any, tmp_path: Path, name: str) -> None:
    """The page's functions are the cheapest of all, these are Lagrange's where there are any."""
    scene = scene_of(name)
    names = ["k_z", "k_C", "k_D", "k_G", "inverse_dynamics", "kinetic_energy", "potential_energy"]
    names += ["k_E"] if elastic(scene) else []
    truth = run_python(emit(lower(derive(freed(scene), names, "lagrange" if name != "scara" else None))))
    rng, n = np.random.default_rng(5), len(scene.coordinates)
    state = {key: rng.uniform(-1.5, 1.5, n) for key in ("q", "qd", "qdd")}
    params = rng.uniform(0.5, 1.5, len(scene.parameters))

    with opened(browser, saved(scene, tmp_path)) as page:
        before = values(page, "coefficient")
        for group, numbers in ({**state, "params": params}).items():
            for k, x in enumerate(numbers):
                move(page, group, k, float(x))
        seen = {kind: values(page, kind) for kind in ("tau", "coefficient", "term", "K", "P", "E")}
        drawn = page.evaluate(
            "([q, p]) => [...symdyn.NAME.drawn_points(q, q.map(() => 0), ...p)]".replace("NAME", name),
            [state["q"].tolist(), [*([0] if name == "everything" else []), params.tolist()]],
        )

    q, qd, qdd = state["q"], state["qd"], state["qdd"]
    k_z, k_C, k_D, k_G = (getattr(truth, f"k_{x}")(q, params) for x in "zCDG")
    timed = [np.float64(0)] if name == "everything" else []
    tau = truth.inverse_dynamics(q, qd, qdd, *timed, params)
    pairs = list(combinations(range(n), 2))
    wanted = []
    for i in range(n):
        whole = [(k_z[i, j], k_z[i, j] * qdd[j]) for j in range(n)]
        whole += [(k_C[i, p], k_C[i, p] * qd[j] * qd[k]) for p, (j, k) in enumerate(pairs)]
        whole += [(k_D[i, j], k_D[i, j] * qd[j] ** 2) for j in range(n)]
        whole += [(k_G[i], k_G[i])]
        whole += [(x, x) for x in ([truth.k_E(q, params)[i]] if elastic(scene) else [])]
        rest = tau[i] - sum(value for _, value in whole)
        whole += [(0.0, rest)]  # what acts beside drives has no coefficient
        wanted.append([(c, v) for c, v in whole if abs(v) > 1e-11])
    found = np.array(seen["term"])
    assert len(found) >= len([x for row in wanted for x in row])
    np.testing.assert_allclose(
        [x for x in found if abs(x) > 1e-11], [v for row in wanted for _, v in row], rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(
        [x for x in seen["coefficient"] if abs(x) > 1e-11],
        [c for row in wanted for c, _ in row if c],
        rtol=1e-12,
        atol=1e-12,
    )
    np.testing.assert_allclose(seen["tau"], tau, rtol=1e-12, atol=1e-12)
    K, P = truth.kinetic_energy(q, qd, params), truth.potential_energy(q, params)
    np.testing.assert_allclose([*seen["K"], *seen["P"], *seen["E"]], [K, P, K + P], rtol=1e-12, atol=1e-12)
    assert before != seen["coefficient"]

    here = dict(zip([one.name for one in scene.parameters], params.tolist(), strict=True))
    found_places = places(scene, q[None], here)
    rows = np.reshape(drawn, (-1, 3))
    for _, frame in found_places.points.values():
        assert np.abs(rows - frame.p[0]).max(axis=1).min() < 1e-12
    for body in found_places.bodies:
        for _, at in body.particles:
            assert np.abs(rows - at[0]).max(axis=1).min() < 1e-12


@pytest.mark.parametrize(("name", "drives"), [("two_link", "none"), ("everything", "held")])
def test_the_motion_is_forward_dynamics_and_its_energy_does_not_drift(
    browser: Any, tmp_path: Path, name: str, drives: str
) -> None:
    scene = scene_of(name)
    program = live(scene).program
    module = run_python(emit(program))
    with opened(browser, saved(scene, tmp_path)) as page:
        start, rates, params = typed(page, "q"), typed(page, "qd"), typed(page, "params")
        tau = values(page, "tau") if drives == "held" else [0.0] * len(start)
        page.select_option("[data-do=drives]", drives)
        played(page, 0.6)
        (t,), (drift,), (E,) = values(page, "t"), values(page, "drift"), values(page, "E")
        q, qdd = typed(page, "q"), typed(page, "qdd")
        page.click("[data-do=reset]")
        assert typed(page, "q") == start
        assert values(page, "t") == [0.0]

    takes_time = "t" in [a.name for a in program["forward_dynamics"].function.arguments]

    def slope(now: float, y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        a, b = np.split(y, 2)
        return np.concatenate([b, module.forward_dynamics(a, b, tau, *([now] if takes_time else []), params)])

    y = solve_ivp(slope, (0, t), [*start, *rates], method="DOP853", rtol=1e-9, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(q, y[: len(q)], rtol=5e-5, atol=1e-6)  # five digits are shown: half a unit of the last
    np.testing.assert_allclose(qdd, slope(t, y)[len(q) :], rtol=1e-3, atol=1e-4)
    assert abs(drift) < 1e-7 * max(1.0, abs(E))


@pytest.mark.wide("rocket")
@pytest.mark.runs("cc")
@pytest.mark.parametrize("name", ["dc_motor", "rocket", "muscle"])
def test_states_of_the_scene_move_on_the_page_as_simulate_says(browser: Any, tmp_path: Path, name: str) -> None:
    """With sliders, from where they start; what they bring in, a mass that leaves too, is in the balance of energy."""
    scene = symdyn.example(name)
    names = [*(one.name for one in scene.parameters), *(one.name for one in scene.given)]
    with opened(browser, saved(scene, tmp_path)) as page:
        q, qd, before = typed(page, "q"), typed(page, "qd"), dict(zip(names, typed(page, "params"), strict=True))
        drift, (t,) = page.evaluate(f"symdyn.{name}.advance(0.3)"), values(page, "t")
        (E,), behind = values(page, "E"), dict(zip(names, typed(page, "params"), strict=True))
        found = [*typed(page, "q"), *typed(page, "qd"), *(behind[one.name] for one in scene.states)]
    run = symdyn.simulate(
        scene, until=t, every=t, forces={one.name: repr(before[one.name]) for one in scene.inputs},
        start=dict(zip(scene.coordinates, q, strict=True)) | {one.name: before[one.name] for one in scene.states},
        start_rates=dict(zip(scene.velocities, qd, strict=True)),
        values={one.name: before[one.name] for one in scene.parameters},
    )  # fmt: skip
    wanted = [run[one][-1] for one in (*scene.coordinates, *scene.velocities, *(one.name for one in scene.states))]
    np.testing.assert_allclose(found, wanted, rtol=6e-5, atol=1e-6)  # five digits are shown
    assert before != behind
    assert abs(drift) < 1e-9 * max(1.0, abs(E))


@pytest.mark.wide(3)
@pytest.mark.parametrize("name", ["two_link", "double_pendulum", "heavy_top", "free_body", "four_bar", "governor"])
def test_energy_is_held_to_a_billionth_over_a_minute(browser: Any, tmp_path: Path, name: str) -> None:
    with opened(browser, saved(scene_of(name), tmp_path)) as page:
        most = f"Math.max(...[1, 2, 3, 4, 5, 6].map(() => Math.abs(symdyn.{name}.advance(10))))"
        drift, (t,) = page.evaluate(most), values(page, "t")
        size = max(*values(page, "K"), *map(abs, values(page, "E")))
    assert t == pytest.approx(60)
    assert drift <= 1e-9 * size


def test_coriolis_and_centrifugal_forces_are_what_the_coefficients_say(browser: Any, tmp_path: Path) -> None:
    """The power of each part is that of its coefficients: -Σ q̇_i k_C q̇_j q̇_k, and likewise; all masses are points."""
    scene = scene_of("two_link")
    with opened(browser, saved(scene, tmp_path)) as page:
        q, qd, qdd, params = (
            np.array(x)
            for x in page.evaluate(
                "(({q, qd, qdd, params}) => [q, qd, qdd, params].map(x => [...x]))(symdyn.two_link.state())"
            )
        )

        def power(kind: str, of: str = "undefined") -> float:
            forces, rates = (
                np.array(page.evaluate(f"symdyn.two_link.arrows({what}).map(x => x[3])"))
                for what in (f"'{kind}', {of}", "'velocities'")
            )
            return float((forces * rates).sum())

        found = [power(kind) for kind in ("inertia", "coriolis", "centrifugal", "weights")]
        single = [power("coriolis", "[0, 1]"), power("centrifugal", "[1]")]
    module = run_python(emit(lower(derive(freed(scene), ["mass_matrix", "k_C", "k_D", "k_G"]))))
    C, D = module.k_C(q, params), module.k_D(q, params)
    coriolis, centrifugal = qd @ C[:, 0] * qd[0] * qd[1], qd @ D @ qd**2
    inertia = qd @ module.mass_matrix(q, params) @ qdd + coriolis + centrifugal
    wanted = [-inertia, -coriolis, -centrifugal, -qd @ module.k_G(q, params)]
    np.testing.assert_allclose(found, wanted, rtol=1e-10)
    np.testing.assert_allclose(single, [-coriolis, -qd @ D[:, 1] * qd[1] ** 2], rtol=1e-10)


@pytest.mark.long
@pytest.mark.parametrize("name", ["scara", "cart_pole", "heavy_top", "free_body", "everything"])
def test_the_motion_of_the_masses_is_that_of_the_whole(name: str) -> None:
    """Momentum and angular momentum about the centre of mass, and their rates, by the centroidal outputs."""
    scene = freed(scene_of(name))
    names = ["centroidal_momentum_matrix", "centroidal_momentum_bias"]
    program, truth = live(scene_of(name)).program, run_python(emit(lower(derive(scene, names))))
    module, rng = run_python(emit(program)), np.random.default_rng(3)
    n, params = len(scene.velocities), rng.uniform(0.5, 1.5, len(scene.parameters))
    q = rng.uniform(-1, 1, len(scene.coordinates))
    if len(q) > n:  # the last four are a quaternion
        q[-4:] /= np.linalg.norm(q[-4:])
    qd, qdd = rng.uniform(-1, 1, n), rng.uniform(-1, 1, n)
    given = [params] if len(params) else []
    masses = module.mass_motions(q, qd, qdd, *given)
    p, v, a, L, dL = (masses[:, 3 * k : 3 * k + 3] for k in range(5))
    m = masses[:, 15:]
    arm = p - (m * p).sum(0) / m.sum()

    found = [(m * v).sum(0), (L + np.cross(arm, m * v)).sum(0), (m * a).sum(0), (dL + np.cross(arm, m * a)).sum(0)]

    A, bias = truth.centroidal_momentum_matrix(q, *given), truth.centroidal_momentum_bias(q, qd, *given)
    np.testing.assert_allclose(np.concatenate(found), [*(A @ qd), *(A @ qdd + bias)], rtol=1e-9, atol=1e-11)


@pytest.mark.long(0)
def test_terms_that_cancel_are_left_out() -> None:
    """k_G,1 of the arm with an upright first axis is a sum that cancels; by its looks it does not vanish."""
    computed = live(scene_of("scara"))
    shown = {(term.function, term.indices) for term in computed.terms}

    assert not any(name == "k_D" and indices[0] == indices[1] for name, indices in shown)
    assert ("k_D", (0, 1)) in shown
    computed = live(scene_of("arm7"))
    assert not computed.program["k_G"].function.entries[0].is_zero
    assert {term.indices for term in computed.terms if term.function == "k_G"} == {(i,) for i in range(1, 7)}


def test_scenes_that_sliders_cannot_move_are_refused_in_words() -> None:
    scene, message = read(EXAMPLES / "quadruped.toml"), "more than 8"
    with pytest.raises(TeachError, match=message):
        interactive(scene)
    assert message in absence(scene, "en")
    assert absence(scene, "sk") not in ("", absence(scene, "en"))


def scene_text(more: str) -> str:
    return f"""
    [bodies.arm]
    mass = 1
    com = [1, 0, 0]
    [joints.a]
    type = "revolute"
    parent = "ground"
    child = "arm"
    axis = [0, 0, 1]
    {more}
    """


def test_wrong_names_and_languages_are_refused() -> None:
    with pytest.raises(DrawError, match='"m3" is not a parameter'):
        interactive(scene_of("two_link"), {"m3": 1.0})
    with pytest.raises(TeachError, match="language 'de' is not known; there are en, sk"):
        interactive(scene_of("two_link"), language="de")


def test_parameters_begin_where_they_are_told() -> None:
    assert 'value="2.25"' in interactive(scene_of("two_link"), {"h1": 2.25}).body


def test_the_same_scene_gives_the_same_page() -> None:
    assert interactive_page(scene_of("two_link")) == interactive_page(scene_of("two_link"))


def test_languages_have_the_same_words() -> None:
    pages = [language_of(code).page for code in languages()]
    assert all(words.keys() == pages[0].keys() for words in pages)
    assert all(all(words.values()) for words in pages)


def test_the_page_needs_nothing_else_and_is_small() -> None:
    text = interactive_page(scene_of("two_link"))

    assert len(text) < 120_000
    assert len(re.findall(r"^const [cs]\d=Math\.\w+\(q_\d\);$", text, re.MULTILINE)) > 4  # no spaces in formulas
    assert not any(word in text for word in ("src=", "href=", "@import", "url(", "fetch("))


LED = Path(__file__).parent / "data/found/hoop_driven.toml"


@pytest.mark.mends("5.5")
def test_a_prescribed_motion_runs_on_the_page(browser: Any, tmp_path: Path) -> None:
    """The hoop turns by phi = Omega t whatever the bead does; the bead moves by its equation, and the motor works."""
    scene = read(LED)
    with opened(browser, saved(scene, tmp_path)) as page:
        (t,) = values(page, "t")
        (phi,), (rate,) = values(page, "q"), values(page, "qd")
        assert (phi, rate) == pytest.approx((8 * t, 8), rel=1e-12)
        move(page, "t", 0, 0.7)
        assert values(page, "q") == pytest.approx([8 * 0.7], rel=1e-12)
        move(page, "params", 2, 5.0)
        assert values(page, "q") + values(page, "qd") == pytest.approx([5 * 0.7, 5], rel=1e-12)
        (theta,), (speed,) = typed(page, "q"), typed(page, "qd")
        played(page, 1.2)
        (t,), (drift,), (E,) = values(page, "t"), values(page, "drift"), values(page, "E")
        assert values(page, "q") == pytest.approx([5 * t], rel=1e-12)
        assert values(page, "qdd") == [0.0]
        (found,) = typed(page, "q")

    def slope(_: float, y: np.ndarray[Any, Any]) -> list[float]:
        return [y[1], (5.0**2 * np.cos(y[0]) - 9.81 / 0.4) * np.sin(y[0])]

    y = solve_ivp(slope, (0.7, t), [theta, speed], method="DOP853", rtol=1e-9, atol=1e-12).y[:, -1]
    assert found == pytest.approx(y[0], rel=1e-4, abs=1e-4)
    assert abs(drift) < 1e-7 * max(1.0, abs(E))  # with the work of the motor


def test_a_motion_that_time_alone_decides_can_be_played(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(read_text(scene_text('motion = "sin(2*t)"'), "led.toml"), tmp_path)) as page:
        played(page, 0.7)
        (t,) = values(page, "t")
        assert values(page, "q") == pytest.approx([np.sin(2 * t)], rel=1e-12)
        assert values(page, "qdd") == pytest.approx([-4 * np.sin(2 * t)], rel=1e-12)


def test_sliders_take_over_the_motions_of_closed_scenes_alone() -> None:
    led = read_text(scene_text('motion = "sin(2*t)"'), "led.toml")
    text = (EXAMPLES / "slider_crank.toml").read_text()
    closed = read_text(text.replace('coordinate = "phi"', 'coordinate = "phi"\nmotion = "2*t"'), "slider_crank")

    assert by_hand(led) is led
    assert [joint.motion is None for joint in by_hand(closed).joints] == [True] * len(closed.joints)


def test_a_closed_mechanism_with_a_prescribed_motion_is_moved_by_hand(browser: Any, tmp_path: Path) -> None:
    text = (EXAMPLES / "slider_crank.toml").read_text()
    scene = read_text(text.replace('coordinate = "phi"', 'coordinate = "phi"\nmotion = "1 + 2*t"'), "slider_crank")
    assert any(joint.motion is not None for joint in scene.joints)
    with opened(browser, saved(scene, tmp_path)) as page:
        assert page.is_disabled("[data-do=play]")
        assert "moved by hand, and cannot be played" in page.inner_text("section.live")
        assert float(page.input_value("input[type=number][data-group=q][data-k='0']")) == pytest.approx(1.8)
        move(page, "q", 0, 2.0)
        assert abs(values(page, "q")[0]) > 0


@pytest.mark.mends("5.6")
@pytest.mark.parametrize("name", ["heavy_top", "free_body"])
def test_a_page_begins_with_the_velocities_of_the_scene(browser: Any, tmp_path: Path, name: str) -> None:
    scene = scene_of(name)
    given = [float(x.at({}) or 0) for x in start_of(scene).velocity]
    with opened(browser, saved(scene, tmp_path)) as page:
        shown = typed(page, "qd")
        ranges = page.eval_on_selector_all(
            "input[type=range][data-group=qd]", "all => all.map(x => [x.min, x.max].map(Number))"
        )
    assert shown == pytest.approx(given, rel=1e-4)
    assert all(low <= x <= high for x, (low, high) in zip(shown, ranges, strict=True))
