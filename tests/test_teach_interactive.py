"""The interactive page in a real browser: it computes what Python computes, plays, and fits a phone."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import OVERLAPS, opened, pictured, played

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
from symdyn.teach import walkthrough
from symdyn.teach.languages import language_of, languages
from symdyn.teach.render.html import html_page
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


def values(page: Any, kind: str) -> list[float]:
    """Return all values of one kind that the page shows, with all digits, in its order."""
    found: list[str] = page.eval_on_selector_all(f"[data-out={kind}]", "all => all.map(x => x.dataset.value)")
    return [float(x) for x in found]


def move(page: Any, group: str, k: int, value: float) -> None:
    """Type a number as a user does."""
    page.fill(f"input[type=number][data-group={group}][data-k='{k}']", repr(value))


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


@pytest.mark.wide("two_link-sk-light-1280", "everything-en-dark-390")
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize(("name", "language", "scheme"), [("two_link", "sk", "light"), ("everything", "en", "dark")])
def test_nothing_overlaps_and_nothing_is_wider_than_the_window(
    browser: Any, tmp_path: Path, name: str, language: str, scheme: str, width: int
) -> None:
    with opened(browser, saved(scene_of(name), tmp_path, language), width, scheme) as page:
        for group, x in (("qd", -1.23456), ("qdd", -12.3456)):
            move(page, group, 0, x)
        page.click(".live-choice summary")
        page.check("[data-word=frames]")
        page.evaluate("scrollTo(0, 0)")  # the picture stays in sight, and what is scrolled away lies under it

        assert page.evaluate(OVERLAPS) == []
        assert page.evaluate("document.documentElement.lang") == language
        dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(18, 23, 29)"
        assert dark == (scheme == "dark")
        page.emulate_media(media="print")
        assert not page.is_visible("input[type=range]")
        assert page.is_visible("input[type=number][data-group]")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


@pytest.mark.parametrize(("name", "drives"), [("two_link", "none"), ("everything", "held")])
def test_the_motion_is_forward_dynamics_and_its_energy_does_not_drift(
    browser: Any, tmp_path: Path, name: str, drives: str
) -> None:
    scene = scene_of(name)
    program = live(scene).program
    module = run_python(emit(program))
    with opened(browser, saved(scene, tmp_path)) as page:

        def state(group: str) -> list[float]:
            return [
                float(x)
                for x in page.eval_on_selector_all(
                    f"input[type=number][data-group={group}]", "all => all.map(x => x.value)"
                )
            ]

        start, rates, params = state("q"), state("qd"), state("params")
        tau = values(page, "tau") if drives == "held" else [0.0] * len(start)
        page.select_option("[data-do=drives]", drives)
        played(page, 0.6)
        (t,), (drift,), (E,) = values(page, "t"), values(page, "drift"), values(page, "E")
        q, qdd = state("q"), state("qdd")
        page.click("[data-do=reset]")
        assert state("q") == start
        assert values(page, "t") == [0.0]

    takes_time = "t" in [a.name for a in program["forward_dynamics"].function.arguments]

    def slope(now: float, y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        a, b = np.split(y, 2)
        return np.concatenate([b, module.forward_dynamics(a, b, tau, *([now] if takes_time else []), params)])

    y, count = np.array([*start, *rates]), 2000
    h = t / count
    for k in range(count):
        a = slope(k * h, y)
        b = slope((k + 0.5) * h, y + h / 2 * a)
        c = slope((k + 0.5) * h, y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slope((k + 1) * h, y + h * c))
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

        def state(group: str) -> list[float]:
            found = page.eval_on_selector_all(f"input[type=number][data-group={group}]", "all => all.map(x => x.value)")
            return [float(x) for x in found]

        q, qd, before = state("q"), state("qd"), dict(zip(names, state("params"), strict=True))
        drift, (t,) = page.evaluate(f"symdyn.{name}.advance(0.3)"), values(page, "t")
        (E,), behind = values(page, "E"), dict(zip(names, state("params"), strict=True))
        found = [*state("q"), *state("qd"), *(behind[one.name] for one in scene.states)]
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


def test_a_link_keeps_the_state_and_a_strange_one_changes_nothing(browser: Any, tmp_path: Path) -> None:
    path = saved(scene_of("two_link"), tmp_path)
    with opened(browser, path) as page:
        before = page.evaluate("[...symdyn.two_link.state().q]")
        for strange in ("q=1,2", "q=1,NaN&qd=0,0&qdd=0,0&params=1,1,1,1,1&t=0", "q=<script>", ""):
            page.evaluate(f"location.replace('#live-two_link?{strange}')")
            pictured(page)  # by then it has heard
            assert page.evaluate("[...symdyn.two_link.state().q]") == before
        page.evaluate("symdyn.two_link.advance(0.3)")
        state = page.evaluate("(({q, qd, params, t}) => [[...q], [...qd], [...params], t])(symdyn.two_link.state())")
        page.click("[data-do=link]")
        kept = page.evaluate("location.hash")
        page.click("[data-do=reset]")
        page.evaluate("location.replace('#other')")
        page.evaluate("hash => location.replace(hash)", kept)
        page.wait_for_function("symdyn.two_link.state().t > 0.2")
        again = page.evaluate("(({q, qd, params, t}) => [[...q], [...qd], [...params], t])(symdyn.two_link.state())")
    assert again == state


def test_the_phase_portrait_starts_where_it_is_pointed_at_and_a_ghost_moves_otherwise(
    browser: Any, tmp_path: Path
) -> None:
    with opened(browser, saved(scene_of("pendulum"), tmp_path)) as page:
        page.evaluate("symdyn.pendulum.show(['phase', 'ghost', 'trails', 'angles'])")
        portrait = page.locator("[data-panel=phase] svg")
        box = portrait.bounding_box()
        portrait.click(position={"x": box["width"] * (46 + 306 * 0.75) / 360, "y": box["height"] * 69 / 150})
        page.wait_for_function("symdyn.pendulum.state().t > 0.3")
        page.click("[data-do=play]")
        (E,) = values(page, "E")
        ghost, own = (
            page.eval_on_selector(f"svg.symdyn {where}", "x => x.getAttribute('d')")
            for where in (".live-ghost path.link", ".mark path.link")
        )
    assert abs(E) < 0.1  # it began at a quarter turn, at rest, as high as its pin; pictures have pixels
    assert ghost != own


def test_the_keyboard_is_enough(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        before = values(page, "coefficient")
        page.focus("input[type=range][data-group=q][data-k='1']")
        page.keyboard.press("ArrowRight")
        assert values(page, "coefficient") != before
        page.focus("[data-do=play]")
        page.keyboard.press("Space")
        page.wait_for_function("Number(document.querySelector('[data-out=t]').dataset.value) > 0")
        assert page.inner_text("[data-do=play]") == "Pause"
        page.keyboard.press("Space")
        assert page.inner_text("[data-do=play]") == "Play"
        names = page.eval_on_selector_all(
            ".live input, .live button, .live select",
            "all => all.map(x => x.getAttribute('aria-label') || x.textContent || x.closest('label').textContent)",
        )
        assert all(name.strip() for name in names)


def test_what_is_no_number_changes_nothing_and_a_massless_body_is_told(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        field = "input[type=number][data-group=q][data-k='0']"
        before, shown = values(page, "tau"), page.input_value(field)
        for typed, kept in (("", shown), ("1e400", "1e+40")):  # the last of 1, 1e4, 1e40 that is a number
            page.focus(field)
            page.keyboard.press("Control+A")
            page.keyboard.press("Delete")
            page.keyboard.type(typed)
            page.keyboard.press("Tab")
            assert page.input_value(field) == kept
            assert (values(page, "tau") == before) == (kept == shown)
        move(page, "params", 0, 0.0)
        move(page, "params", 1, 0.0)
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent")
        assert page.inner_text("[data-do=play]") == "Play"


def test_nothing_speaks_while_it_plays_but_faults(browser: Any, tmp_path: Path) -> None:
    """Numbers change sixty times a second: none of them is a live region."""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        loud = "output, [aria-live], [role=status], [role=alert], [role=log]"
        assert page.eval_on_selector_all(loud, "all => all.map(x => x.dataset.out)") == ["chosen", "lost"]
        page.evaluate("symdyn.two_link.advance(0.5)")
        assert page.text_content("[data-out=chosen]") == ""  # it tells what a key has moved
        order = "all => all.filter(x => x.tabIndex >= 0).map(x => x.dataset.do ?? x.dataset.group)"
        reached = page.eval_on_selector_all(".live button, .live select, .live input", order)
        assert reached[:3] == ["play", "step", "reset"]
        assert all(word in reached for word in ("q", "qd", "qdd", "params"))
        page.focus("[data-do=play]")
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.dataset.do") == "step"
        assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_several_scenes_stand_in_one_page(browser: Any, tmp_path: Path) -> None:
    parts = [interactive(scene_of(name)) for name in ("two_link", "cart_pole")]
    text = f"<!DOCTYPE html><meta charset=utf-8><style>{parts[0].css}</style>"
    text += "".join(f"{one.body}<script>{one.script}</script>" for one in parts)
    path = tmp_path / "both.html"
    path.write_text(text, encoding="utf-8")
    with opened(browser, path) as page:
        page.fill("[data-live=cart_pole] input[type=number][data-group=params]", "2.5")
        assert page.eval_on_selector("[data-live=cart_pole] [data-out=coefficient]", "x => x.dataset.value") == "2.6"
        assert page.evaluate("Object.keys(symdyn).join()") == "two_link,cart_pole"
        assert page.evaluate("new Set([...document.querySelectorAll('[id]')].map(x => x.id)).size") == page.evaluate(
            "document.querySelectorAll('[id]').length"
        )


def test_a_motion_that_runs_away_is_stopped_and_told(browser: Any, tmp_path: Path) -> None:
    text = """
    [bodies.cart]
    mass = 1
    [joints.rail]
    type = "prismatic"
    parent = "ground"
    child = "cart"
    axis = [1, 0, 0]
    coordinate = "x"
    force = "2*x_dot**3*exp(3*x)"
    """
    with opened(browser, saved(read_text(text, "runaway.toml"), tmp_path)) as page:
        move(page, "qd", 0, 5.0)
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent")
        assert "ran away" in page.inner_text("[data-out=lost]")
        assert page.inner_text("[data-do=play]") == "Play"


# Without a browser


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


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", ["two_link", "cart_pole"])
def test_sliders_begin_at_the_state_of_the_lesson_and_come_back_to_it(browser: Any, tmp_path: Path, name: str) -> None:
    """The numbers of the lesson's table of values, as it prints them."""
    scene, path = scene_of(name), tmp_path / "lesson.html"
    path.write_text(html_page(walkthrough(scene)), encoding="utf-8")
    with opened(browser, path) as page:
        told = page.eval_on_selector_all(
            "#step-state tbody tr td:nth-child(2)", "all => all.map(x => x.textContent.replace('−', '-'))"
        )
        n = len(scene.parameters)

        def shown() -> list[str]:
            groups = ("params", "q", "qd", "qdd")
            return [x for g in groups for x in page.eval_on_selector_all(
                f"input[type=number][data-group={g}]", "all => all.map(x => x.value)")]  # fmt: skip

        begun = shown()
        assert [float(f"{float(x):.4g}") for x in begun] == [float(x) for x in told]
        assert len(begun) == n + 3 * len(scene.coordinates)
        for i, torque in enumerate(values(page, "tau") if name == "two_link" else (), 1):  # the lesson's are without Q
            claim = str(page.text_content(f"#step-torque-{i} .claim")).replace("−", "-")
            assert f"{torque:.4g}" in claim
        move(page, "q", 0, 1.7)
        assert shown() != begun
        page.click("[data-do=reset]")
        assert shown() == begun


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
        theta, speed = (float(page.input_value(f"input[type=number][data-group={g}][data-k='1']")) for g in ("q", "qd"))
        played(page, 1.2)
        (t,), (drift,), (E,) = values(page, "t"), values(page, "drift"), values(page, "E")
        assert values(page, "q") == pytest.approx([5 * t], rel=1e-12)
        assert values(page, "qdd") == [0.0]
        found = float(page.input_value("input[type=number][data-group=q][data-k='1']"))

    y, count = np.array([theta, speed]), 4000

    def slope(y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.array([y[1], (5.0**2 * np.cos(y[0]) - 9.81 / 0.4) * np.sin(y[0])])

    h = (t - 0.7) / count
    for _ in range(count):
        a = slope(y)
        b = slope(y + h / 2 * a)
        c = slope(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slope(y + h * c))
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
        shown = page.eval_on_selector_all("input[type=number][data-group=qd]", "all => all.map(x => Number(x.value))")
        ranges = page.eval_on_selector_all(
            "input[type=range][data-group=qd]", "all => all.map(x => [x.min, x.max].map(Number))"
        )
    assert shown == pytest.approx(given, rel=1e-4)
    assert all(low <= x <= high for x, (low, high) in zip(shown, ranges, strict=True))


@pytest.mark.mends("5.6")
def test_the_lines_of_the_energies_go_by_time(browser: Any, tmp_path: Path) -> None:
    """Half as fast a motion fills half as much of the strip in the same number of pictures."""
    end = """() => {
      symdyn.two_link.show(["energies"]);
      const points = document.querySelector("[data-panel=energies] path.line.live-k").getAttribute("d").split("L");
      const t = Number(document.querySelector("[data-out=t]").dataset.value);
      const axis = document.querySelector("[data-panel=energies] .grid").getAttribute("d").match(/M([\\d.]+)/)[1];
      return [t, points[points.length - 1].split(" ").map(Number)[0] - Number(axis)];
    }"""
    through = f"""stages => {{
      window.seen = [];
      const end = {end}, [play, speed] = ["play", "speed"].map(kind => document.querySelector(`[data-do=${{kind}}]`));
      const look = () => {{
        const [faster, least] = stages[window.seen.length];
        speed.value = faster;
        if (Number(document.querySelector("[data-out=t]").dataset.value) > least) window.seen.push(end());
        if (window.seen.length < stages.length) requestAnimationFrame(look);
        else play.click();
      }};
      play.click();
      look();
    }}"""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.evaluate(through, [["2", 1.0], ["0.25", 1.4], ["1", 2.0]])
        page.wait_for_function("window.seen.length === 3")
        seen = page.evaluate("window.seen")
    slopes = [x / t for t, x in seen]
    assert slopes == pytest.approx([slopes[0]] * 3, rel=0.01)


@pytest.mark.mends("5.6")
def test_a_spring_of_a_slide_begins_where_its_length_does(browser: Any, tmp_path: Path) -> None:
    """The spring of an elastic pendulum is as long as its coordinate: from the pivot, not from a wall behind it."""
    scene = read(LED.parent / "elastic_pendulum.toml")
    with opened(browser, saved(scene, tmp_path)) as page:
        pivot, bob = page.evaluate(
            """() => ["circle.joint", "path.joint"].map(look => {
              const all = [...document.querySelectorAll(`svg.symdyn ${look}`)].filter(x => x.getAttribute("transform"));
              return all[all.length - 1].getAttribute("transform").match(/-?[\\d.]+/g).slice(0, 2).map(Number);
            })"""
        )
        ropes = page.eval_on_selector_all("svg.symdyn path.rope", "all => all.map(x => x.getAttribute('d'))")
    way = np.array(bob) - np.array(pivot)
    coils = [text for text in ropes if text and "A" not in text and text.count("L") > 1]
    drawn = [np.array([float(x) for x in re.findall(r"-?[\d.]+", text)]).reshape(-1, 2) for text in coils]
    placed = [spots for spots in drawn if np.abs(spots).max() > 40]  # in the picture's place, not around its own
    assert placed
    for spots in placed:
        assert ((spots - pivot) @ way / (way @ way)).min() > -0.1


def test_the_page_says_when_the_energy_is_not_held(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.evaluate("""() => {
            const right = symdyn.two_link.potential_energy;
            let calls = 0;
            symdyn.two_link.potential_energy = (...given) => right(...given) * (1 + 1e-6 * calls++);
        }""")
        page.click("[data-do=play]")
        page.wait_for_function("document.querySelector('[data-out=lost]').textContent.includes('billionth')")


def test_what_is_said_of_a_panel_goes_with_it(browser: Any, tmp_path: Path) -> None:
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        assert page.is_visible("[data-note=energies]")
        page.evaluate("symdyn.two_link.show(['velocities'])")
        assert not page.is_visible("[data-note=energies]")
        assert page.is_visible("text=Energy kept to")


@pytest.mark.slow
def test_blocks_in_the_window_take_turns_while_it_plays_and_agree_when_it_stands(browser: Any, tmp_path: Path) -> None:
    """One block of numbers a picture; within a table its terms are of one moment and add up."""
    with opened(browser, saved(scene_of("two_link"), tmp_path)) as page:
        page.set_viewport_size({"width": 1280, "height": 3000})
        page.evaluate("""() => {
            window.most = 0;
            let blocks = new Set();
            const watch = new MutationObserver(found => {
                for (const one of found) blocks.add(one.target.closest(".live-rows, .live-panel table"));
            });
            const options = { subtree: true, attributes: true, attributeFilter: ["data-value"] };
            watch.observe(document.querySelector(".live-panel"), options);
            const next = () => {
                window.most = Math.max(window.most, blocks.size);
                blocks = new Set();
                requestAnimationFrame(next);
            };
            requestAnimationFrame(next);
        }""")
        first = values(page, "tau")
        page.click("[data-do=play]")
        changed = """first => [...document.querySelectorAll('[data-out=tau]')]
            .every((one, k) => Number(one.dataset.value) !== first[k])"""
        page.wait_for_function(changed, arg=first)
        assert page.evaluate("window.most") == 1
        off = """() => Math.max(...[...document.querySelectorAll('.live-torques table')].map(table => {
            const all = kind => [...table.querySelectorAll(`[data-out=${kind}]`)].map(one => Number(one.dataset.value));
            return Math.abs(all("tau")[0] - all("term").reduce((x, y) => x + y, 0)); }))"""
        assert page.evaluate(off) < 1e-9
        page.click("[data-do=play]")
        assert page.evaluate(off) < 1e-9
