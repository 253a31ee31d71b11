"""Pages of closed mechanisms and of quaternions in a browser: loops stay closed, numbers are what Python computes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import OVERLAPS, move, opened, played, typed, values
from scipy.integrate import solve_ivp

from symdyn.dynamics import derive
from symdyn.dynamics.loops.loop_numbers import Numbers
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.emit import emit
from symdyn.program import lower
from symdyn.runtime import run_python
from symdyn.scene import Scene, read
from symdyn.teach import walkthrough
from symdyn.teach.render.html import html_page
from symdyn.teach.render.live import Live, live
from symdyn.teach.render.page import interactive_page

EXAMPLES = Path(__file__).parent.parent / "examples"

Array = np.ndarray[Any, np.dtype[np.float64]]


def saved(name: str, folder: Path, language: str = "en") -> tuple[Scene, Path]:
    """Return a scene and its page on disk."""
    path = folder / f"{name}.html"
    path.write_text(page_of(name, language), encoding="utf-8")
    return scene_of(name), path


@cache
def scene_of(name: str) -> Scene:
    return read(EXAMPLES / f"{name}.toml")


@cache
def page_of(name: str, language: str) -> str:
    return interactive_page(scene_of(name), language=language)


@cache
def live_of(name: str) -> Live:
    return live(scene_of(name))


def state_of(page: Any, scene: Scene, group: str) -> Array:
    """Return q, qd or qdd: what was typed, and what follows with all digits."""
    rows = page.evaluate(
        "group => [...document.querySelectorAll(`[data-group=${group}][type=number], [data-out=${group}]`)]"
        ".map(x => [Number(x.dataset.k), Number(x.dataset.value ?? x.value)])",
        group,
    )
    found = np.full(len(scene.coordinates if group == "q" else scene.velocities), np.nan)
    for k, x in rows:
        found[k] = x
    return found


class Truth:
    """A closed scene's functions by the other formulation at values of all parameters, reduced to rows by hand."""

    FUNCTIONS = ("tree_forces", "velocity_forces", "mass_matrix", "kinetic_energy", "potential_energy")
    ROWS = ("constraint_jacobian", "constraint_bias")

    def __init__(self, scene: Scene, params: Array) -> None:
        free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
        given = {p.name: float(p.value.at({}) or 0) for p in scene.parameters if p.value is not None}
        closing, self.params = LoopChoices(parameters=tuple(given.items())), [params] if len(params) else []
        formulations = dict.fromkeys(self.FUNCTIONS, "lagrange") | dict.fromkeys(self.ROWS, "differentiation")
        derived = {name: derive(free, [name], formulation, closing) for name, formulation in formulations.items()}
        self.calls = {name: getattr(run_python(emit(lower(one))), one[name].name) for name, one in derived.items()}

    def __call__(self, name: str, *state: Array) -> Any:
        return self.calls[name](*state, *self.params)

    def allowed(self, q: Array, rows: tuple[int, ...]) -> tuple[Array, Array, list[int]]:
        """Return G, and T of u = T u_i, and the dependent velocities."""
        G, i = self("constraint_jacobian", q), list(rows)
        d = [k for k in range(G.shape[1]) if k not in i]
        T = np.zeros((G.shape[1], len(i)))
        T[i] = np.eye(len(i))
        T[d] = -np.linalg.solve(G[:, d], G[:, i])
        return G, T, d

    def coefficients(self, q: Array, rows: tuple[int, ...]) -> dict[tuple[str, tuple[int, ...]], float]:
        """Return k_z, k_D and k_C by name and indices."""
        G, T, d = self.allowed(q, rows)
        M, n = self("mass_matrix", q), range(len(rows))

        def b(*moving: int) -> Array:
            u, s = T[:, list(moving)].sum(axis=1), np.zeros(len(T))
            s[d] = -np.linalg.solve(G[:, d], self("constraint_bias", q, u))
            return np.asarray(T.T @ (M @ s + self("velocity_forces", q, u)))

        found = {("k_z", place): float(x) for place, x in np.ndenumerate(T.T @ M @ T)}
        for j in n:
            found |= {("k_D", (i, j)): float(x) for i, x in enumerate(b(j))}
        for j, k in combinations(n, 2):
            found |= {("k_C", (i, j, k)): float(x) for i, x in enumerate(b(j, k) - b(j) - b(k))}
        return found


CASES = {  # positions of the sliders of q, rates of independent velocities, accelerations, a parameter to move
    "four_bar": ({0: 2.2}, {0: -1.7}, {0: 3.1}, ("c", 3.3)),
    "slider_crank": ({0: -2.0}, {0: 4.0}, {0: -2.0}, None),
    "governor": ({0: 0.7, 1: 0.9}, {0: 6.0, 1: -0.4}, {0: 1.0, 1: 2.0}, ("l", 0.16)),
    "rssr": ({0: -1.1}, {0: 2.5, 2: -1.5}, {0: 0.5, 2: 1.5}, None),
}


@pytest.mark.wide("four_bar", "slider_crank")
@pytest.mark.parametrize("name", CASES)
def test_closed_numbers_follow_the_sliders_and_are_what_python_computes(
    browser: Any, tmp_path: Path, name: str
) -> None:
    scene, path = saved(name, tmp_path)
    positions, rates, pulls, changed = CASES[name]
    names, computed = [p.name for p in scene.parameters], live_of(name)
    with opened(browser, path) as page:
        if changed:
            move(page, "params", names.index(changed[0]), changed[1])
        for group, wanted in (("q", positions), ("qd", rates), ("qdd", pulls)):
            for k, x in wanted.items():
                move(page, group, k, x)
        assert page.inner_text("[data-out=lost]") == ""
        q, qd, qdd = (state_of(page, scene, group) for group in ("q", "qd", "qdd"))
        typed = [page.input_value(f"input[type=number][data-group=params][data-k='{k}']") for k in range(len(names))]
        seen = {kind: values(page, kind) for kind in ("tau", "term", "coefficient", "exerted", "K", "P")}
    params = np.array(typed, dtype=np.float64)

    free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    numbers = Numbers(free).bound_to(dict(zip(names, params.tolist(), strict=True)))
    held = [k for k in range(len(scene.velocities)) if k in positions]
    np.testing.assert_allclose(numbers.closed_position(q, held).q, q, rtol=0, atol=1e-11)
    np.testing.assert_allclose(q[list(positions)], list(positions.values()))

    truth = Truth(scene, params)
    G, T, _ = truth.allowed(q, computed.rows)
    np.testing.assert_allclose(G @ qd, 0, atol=1e-11)
    np.testing.assert_allclose(G @ qdd + truth("constraint_bias", q, qd), 0, atol=1e-10)
    forces = truth("tree_forces", q, qd, qdd)
    np.testing.assert_allclose(seen["tau"], T.T @ forces, rtol=1e-11, atol=1e-11)
    assert seen["K"] == pytest.approx([truth("kinetic_energy", q, qd)], rel=1e-11)
    assert seen["P"] == pytest.approx([truth("potential_energy", q)], rel=1e-11)
    sums = np.zeros(len(computed.rows))
    np.add.at(sums, [term.row for term in computed.terms], seen["term"])
    np.testing.assert_allclose(sums, T.T @ forces, rtol=1e-10, atol=1e-10)

    wanted = truth.coefficients(q, computed.rows)
    shown = [term for term in computed.terms if term.function != "acting"]
    for term, x in zip(shown, seen["coefficient"], strict=True):
        if (key := (term.function, term.indices)) in wanted:
            assert x == pytest.approx(wanted.pop(key), rel=1e-9, abs=1e-10), term
    assert all(abs(x) < 1e-9 for x in wanted.values()), "what is not shown vanishes"

    assert computed.held is not None
    drives = list(computed.held.drives)
    rest = forces - G.T @ seen["exerted"][len(drives) :]
    rest[drives] -= seen["exerted"][: len(drives)]
    passive = [k for k in computed.rows if k not in drives]  # what no drive moves takes a force that is not there
    np.testing.assert_allclose(np.delete(rest, passive), 0, atol=1e-9)


@pytest.mark.wide("four_bar")
@pytest.mark.parametrize("name", ["four_bar", "governor"])
def test_sliders_of_closed_mechanisms_begin_where_the_lesson_shows_numbers(
    browser: Any, tmp_path: Path, name: str
) -> None:
    scene, path = read(EXAMPLES / f"{name}.toml"), tmp_path / "lesson.html"
    path.write_text(html_page(walkthrough(scene, formulation="dalembert")), encoding="utf-8")
    with opened(browser, path) as page:
        told = page.eval_on_selector_all(
            "#step-state tbody tr td:nth-child(2)", "all => all.map(x => x.textContent.replace('−', '-'))"
        )
        seen = np.concatenate([state_of(page, scene, group) for group in ("q", "qd", "qdd")])

    numbers = [float(x.replace(" · 10^", "e")) for x in told[len(scene.parameters) :]]
    np.testing.assert_allclose(seen, numbers[: len(seen)], rtol=1e-3, atol=1e-9)
    assert len(set(numbers)) > 4


def test_a_loop_that_cannot_close_stays_where_it_closes_last(browser: Any, tmp_path: Path) -> None:
    """A rocker's crank: with a = 4 the four-bar no longer turns round; the slider stops at its limit, in words."""
    scene, path = saved("four_bar", tmp_path)
    a, b, c, d = 3.0, 1.5, 2.0, 4.0
    with opened(browser, path) as page:
        for k, x in ((0, a), (1, b), (2, c)):
            move(page, "params", k, x)
            assert page.inner_text("[data-out=lost]") == "", k
        move(page, "q", 0, 3.0)
        assert "do not close" in page.inner_text("[data-out=lost]")
        reached = typed(page, "q")[0]
        residual = page.evaluate(
            "([q, p]) => symdyn.four_bar.constraint_residual(q, p)",
            [state_of(page, scene, "q").tolist(), [a, b, c, d, 1, 3, 3.5, 9.81]],
        )
        move(page, "q", 0, 1e40)  # soon given up
        move(page, "q", 0, 0.2)
        assert page.inner_text("[data-out=lost]") == ""
    limit = np.arccos((a * a + d * d - (b + c) ** 2) / (2 * a * d))  # coupler and rocker in line
    assert reached == pytest.approx(limit, abs=2e-3)
    assert np.abs(list(residual.values()) if isinstance(residual, dict) else residual).max() < 1e-3  # five digits typed


@pytest.mark.heavy("rolling_disc", "heavy_top")
@pytest.mark.parametrize("name", ["four_bar", "rssr", "rolling_disc", "heavy_top"])
def test_a_played_motion_is_that_of_the_equations(browser: Any, tmp_path: Path, name: str) -> None:
    scene, path = saved(name, tmp_path)
    module = run_python(emit(live_of(name).program))
    closed = live_of(name).held is not None
    with opened(browser, path) as page:
        data = page.content().split("const data = ", 1)[1].split(";\n", 1)[0]
        start = page.evaluate(f"() => ({data}).start")
        page.evaluate("() => 0")
        for k in range(len(start["qd"])):
            if page.locator(f"input[type=number][data-group=qd][data-k='{k}']").count():
                move(page, "qd", k, 0.5 + 0.4 * k)
        qd = state_of(page, scene, "qd")
        played(page, 0.7)
        (t,), (drift,), (E,) = values(page, "t"), values(page, "drift"), values(page, "E")
        end = state_of(page, scene, "qd")
    params, n, nq = np.array(start["params"]), len(qd), len(start["q"])
    extra = [params] if len(params) else []

    def slope(_: float, y: Array) -> Array:
        q, u = y[:nq], y[nq:]
        way = module.coordinate_rates(q, u, *extra) if hasattr(module, "coordinate_rates") else u
        return np.concatenate([way, module.forward_dynamics(q, u, np.zeros(n), *extra)])

    found = solve_ivp(slope, (0, t), [*start["q"], *qd], method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(end, found[nq:], rtol=2e-4, atol=1e-4)  # five digits are shown
    assert abs(drift) < 1e-6 * max(1.0, abs(E))
    if closed and hasattr(module, "constraint_residual"):
        assert np.abs(module.constraint_residual(found[:nq], *extra)).max() < 1e-7


def test_roll_pitch_and_yaw_turn_a_ball(browser: Any, tmp_path: Path) -> None:
    from scipy.spatial.transform import Rotation

    scene, path = saved("heavy_top", tmp_path)
    angles = [0.7, -1.2, 2.5]
    with opened(browser, path) as page:
        for k, x in enumerate(angles):
            move(page, "turn", k, x)
        P = values(page, "P")
        kept = typed(page, "turn")
    assert kept == pytest.approx(angles)
    x, y, z, w = Rotation.from_euler("xyz", angles).as_quat()
    module = run_python(emit(lower(derive(scene, ["potential_energy"]))))
    extra = [np.array([])] if scene.free_parameters else []
    assert P[0] == pytest.approx(float(module.potential_energy(np.array([w, x, y, z]), *extra)), rel=1e-12)


@pytest.mark.wide("four_bar")
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize(("name", "language", "scheme"), [("four_bar", "sk", "dark"), ("rolling_disc", "en", "light")])
def test_nothing_overlaps(browser: Any, tmp_path: Path, name: str, language: str, scheme: str, width: int) -> None:
    _, path = saved(name, tmp_path, language)
    with opened(browser, path, width, scheme) as page:
        assert page.evaluate(OVERLAPS) == []
