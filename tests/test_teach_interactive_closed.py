"""Pages of closed mechanisms and of quaternions in a real browser: loops stay closed, numbers are what Python computes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import OVERLAPS, chromium, opened
from scipy.integrate import solve_ivp

from symdyn.build import run_python
from symdyn.dynamics import derive
from symdyn.dynamics.loops.assembly import closed_position, with_parameters
from symdyn.dynamics.loops.numbers import numbers_of
from symdyn.dynamics.loops.partition import Closing
from symdyn.emit import emit
from symdyn.program import lower
from symdyn.scene import Scene, read
from symdyn.scene.value import value_of
from symdyn.teach.interactive import interactive_page, live

EXAMPLES = Path(__file__).parent.parent / "examples"

Array = np.ndarray[Any, np.dtype[np.float64]]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


def saved(name: str, folder: Path, language: str = "en") -> tuple[Scene, Path]:
    """Return a scene and its page on disk."""
    scene, path = read(EXAMPLES / f"{name}.toml"), folder / f"{name}.html"
    path.write_text(interactive_page(scene, language=language), encoding="utf-8")
    return scene, path


def values(page: Any, kind: str) -> list[float]:
    """Return all values of one kind that the page shows, with all digits, in its order."""
    found: list[str] = page.eval_on_selector_all(f"[data-out={kind}]", "all => all.map(x => x.dataset.value)")
    return [float(x) for x in found]


def move(page: Any, group: str, k: int, value: float) -> None:
    page.fill(f"input[type=number][data-group={group}][data-k='{k}']", repr(value))


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


def truth_of(scene: Scene) -> Any:
    """Return the scene's functions by the other road, all parameters free."""
    free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    names = ["tree_forces", "kinetic_energy", "potential_energy", "mass_matrix"]
    closing = Closing(parameters=tuple((p.name, float(value_of(p.value, {}) or 0)) for p in scene.parameters if p.value))
    functions = [derive(free, [name], "lagrange", closing) for name in names]
    functions += [derive(free, [n], "differentiation", closing) for n in ("constraint_jacobian", "constraint_bias")]
    modules = [run_python(emit(lower(one))) for one in functions]
    names += ["constraint_jacobian", "constraint_bias"]
    return type("Truth", (), {n: staticmethod(getattr(m, n)) for n, m in zip(names, modules, strict=True)})


CASES = {  # positions of the sliders of q, rates of independent velocities, accelerations, a parameter to move
    "four_bar": ({0: 2.2}, {0: -1.7}, {0: 3.1}, ("c", 3.3)),
    "slider_crank": ({0: -2.0}, {0: 4.0}, {0: -2.0}, None),
    "governor": ({0: 0.7, 1: 0.9}, {0: 6.0, 1: -0.4}, {0: 1.0, 1: 2.0}, ("l", 0.16)),
    "rssr": ({0: -1.1}, {0: 2.5, 2: -1.5}, {0: 0.5, 2: 1.5}, None),
}


@pytest.mark.parametrize("name", CASES)
def test_closed_numbers_follow_the_sliders_and_are_what_python_computes(
    browser: Any, tmp_path: Path, name: str
) -> None:
    """Loops closed and reduced by hand from the other road's tree forces and rows."""
    scene, path = saved(name, tmp_path)
    positions, rates, pulls, changed = CASES[name]
    params = [p.name for p in scene.parameters]
    computed = live(scene)
    assert computed.held is not None
    with opened(browser, path) as page:
        start = page.evaluate("symdyn.NAME.constraint_residual ? 1 : 0".replace("NAME", name))
        assert start
        if changed:
            move(page, "params", params.index(changed[0]), changed[1])
        for group, wanted in (("q", positions), ("qd", rates), ("qdd", pulls)):
            for k, x in wanted.items():
                move(page, group, k, x)
        assert page.inner_text("[data-out=lost]") == ""
        q, qd, qdd = (state_of(page, scene, group) for group in ("q", "qd", "qdd"))
        p = np.array([float(page.input_value(f"input[type=number][data-group=params][data-k='{k}']"))
                      for k in range(len(params))])  # fmt: skip
        seen = {kind: values(page, kind) for kind in ("tau", "term", "coefficient", "exerted", "K", "P")}

    free = replace(scene, parameters=tuple(replace(one, value=None) for one in scene.parameters))
    numbers = with_parameters(numbers_of(free), dict(zip(params, p.tolist(), strict=True)))
    held = [k for k in range(len(scene.velocities)) if k in positions]
    np.testing.assert_allclose(closed_position(numbers, q, held).q, q, rtol=0, atol=1e-11)
    assert np.allclose(q[list(positions)], list(positions.values()))

    truth, extra = truth_of(scene), [p] if params else []
    kept = run_python(emit(computed.program)).constraint_residual  # same rows
    assert np.abs(kept(q, *extra)).max() < 1e-11
    G, i = truth.constraint_jacobian(q, *extra), list(computed.rows)
    d = [k for k in range(len(qd)) if k not in i]
    np.testing.assert_allclose(G @ qd, 0, atol=1e-11)
    np.testing.assert_allclose(G @ qdd + truth.constraint_bias(q, qd, *extra), 0, atol=1e-10)
    T = np.zeros((len(qd), len(i)))
    T[i] = np.eye(len(i))
    T[d] = -np.linalg.solve(G[:, d], G[:, i])
    tau = T.T @ truth.tree_forces(q, qd, qdd, *extra)
    np.testing.assert_allclose(seen["tau"], tau, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose([*seen["K"], *seen["P"]],
                               [truth.kinetic_energy(q, qd, *extra), truth.potential_energy(q, *extra)], rtol=1e-11)  # fmt: skip
    sums = np.zeros(len(i))
    for term, x in zip(computed.terms, seen["term"], strict=True):
        sums[term.row] += x
    np.testing.assert_allclose(sums, tau, rtol=1e-10, atol=1e-10)

    def b(*moving: int) -> Array:
        u = T[:, list(moving)].sum(axis=1)
        s = np.zeros(len(qd))
        s[d] = -np.linalg.solve(G[:, d], truth.constraint_bias(q, u, *extra))
        still = np.zeros_like(u)
        inertial = truth.tree_forces(q, u, s, *extra) - truth.tree_forces(q, still, still, *extra)
        acting = truth.tree_forces(q, u, still, *extra) + truth.tree_forces(q, -u, still, *extra)  # c is even, forces may be odd
        even = truth.tree_forces(q, still, still, *extra)
        return T.T @ (inertial - truth.tree_forces(q, u, still, *extra) + even + acting / 2 - even)

    wanted = {("k_z", (a, c)): x for (a, c), x in np.ndenumerate(T.T @ truth.mass_matrix(q, *extra) @ T)}
    for j in range(len(i)):
        wanted |= {("k_D", (a, j)): x for a, x in enumerate(b(j))}
    for j, k in combinations(range(len(i)), 2):
        wanted |= {("k_C", (a, j, k)): x for a, x in enumerate(b(j, k) - b(j) - b(k))}
    shown = [term for term in computed.terms if term.function != "acting"]
    for term, x in zip(shown, seen["coefficient"], strict=True):
        if (term.function, term.indices) in wanted:
            assert x == pytest.approx(wanted.pop((term.function, term.indices)), rel=1e-9, abs=1e-10), term
    assert all(abs(x) < 1e-9 for x in wanted.values()), "what is not shown vanishes"

    drives, multipliers = computed.held.drives, seen["exerted"][len(computed.held.drives) :]
    full = np.zeros(len(qd))
    full[list(drives)] = seen["exerted"][: len(drives)]
    passive = [k for k in i if k not in drives]  # what no drive moves takes a force that is not there
    rest = truth.tree_forces(q, qd, qdd, *extra) - full - G.T @ multipliers
    np.testing.assert_allclose(np.delete(rest, passive), 0, atol=1e-9)


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
        reached = float(page.input_value("input[type=number][data-group=q]"))
        residual = page.evaluate(
            "([q, p]) => symdyn.four_bar.constraint_residual(q, p)",
            [state_of(page, scene, "q").tolist(), [a, b, c, d, 1, 3, 3.5, 9.81]],
        )
        move(page, "q", 0, 0.2)
        assert page.inner_text("[data-out=lost]") == ""
    limit = np.arccos((a * a + d * d - (b + c) ** 2) / (2 * a * d))  # coupler and rocker in line
    assert reached == pytest.approx(limit, abs=2e-3)
    assert np.abs(list(residual.values()) if isinstance(residual, dict) else residual).max() < 1e-3  # five digits typed


@pytest.mark.parametrize("name", ["four_bar", "rssr", "rolling_disc", "heavy_top"])
def test_a_played_motion_is_that_of_the_equations(browser: Any, tmp_path: Path, name: str) -> None:
    scene, path = saved(name, tmp_path)
    module = run_python(emit(live(scene).program))
    closed = live(scene).held is not None
    with opened(browser, path) as page:
        data = page.content().split("const data = ", 1)[1].split(";\n", 1)[0]
        start = page.evaluate(f"() => ({data}).start")
        page.evaluate("() => 0")
        for k in range(len(start["qd"])):
            if page.locator(f"input[type=number][data-group=qd][data-k='{k}']").count():
                move(page, "qd", k, 0.5 + 0.4 * k)
        qd = state_of(page, scene, "qd")
        page.click("[data-do=play]")
        page.wait_for_function("Number(document.querySelector('[data-out=t]').dataset.value) > 0.7")
        page.click("[data-do=play]")
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
        kept = [float(page.input_value(f"input[type=number][data-group=turn][data-k='{k}']")) for k in range(3)]
    assert kept == pytest.approx(angles)
    x, y, z, w = Rotation.from_euler("xyz", angles).as_quat()
    module = run_python(emit(lower(derive(scene, ["potential_energy"]))))
    extra = [np.array([])] if scene.free_parameters else []
    assert P[0] == pytest.approx(float(module.potential_energy(np.array([w, x, y, z]), *extra)), rel=1e-12)


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize(("name", "language", "scheme"), [("four_bar", "sk", "dark"), ("rolling_disc", "en", "light")])
def test_nothing_overlaps(browser: Any, tmp_path: Path, name: str, language: str, scheme: str, width: int) -> None:
    _, path = saved(name, tmp_path, language)
    with opened(browser, path, width, scheme) as page:
        assert page.evaluate(OVERLAPS) == []
