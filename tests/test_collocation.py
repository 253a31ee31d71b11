"""Collocation: its derivatives, its order, its equations of closed and rolling mechanisms, and what it refuses."""

from __future__ import annotations

import pickle
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import symdyn
from symdyn.algebra.numeric import Batches
from symdyn.dynamics import LoopChoices
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import SimulateError
from symdyn.graph import evaluate
from symdyn.scene import Scene, bind, parse
from symdyn.scene.toml import read_text
from symdyn.transcription import METHODS, Collocation, along
from symdyn.transcription.local import written
from symdyn.transcription.solution import lagrangian

pytestmark = pytest.mark.runs("cc")

EXAMPLES = Path(__file__).parent.parent / "examples"
CART = symdyn.read(EXAMPLES / "cart_pole.toml")


MOTOR = """
name = "motor"
gravity = [0, -9.81, 0]
[parameters]
m = 0.5
l = 0.3
k = 0.08
b = 0.002
[inputs.V]
[signals]
drop = "0.4*i + k*theta_dot"
[states.i]
rate = "(V - drop)/0.1"
start = 0.1
[bodies.bob]
mass = "m"
com = [0, "-l", 0]
[joints.hinge]
type = "revolute"
parent = "ground"
child = "bob"
axis = [0, 0, 1]
coordinate = "theta"
drive = false
force = "k*i - b*theta_dot"
"""

WARM = MOTOR.replace(
    "[states.i]", '[states.warmth]\nrate = "t*i**2 - warmth*l/(1 + t**2)"\nstart = 0.3\n[states.i]'
).replace('"k*i - ', '"k*i/(1 + warmth)*V - ')
"""Whose torque falls, and whose rates change by the time, a parameter and other states."""


def example(name: str) -> Scene:
    if name == "led_cart":
        text = (EXAMPLES / "cart_pole.toml").read_text().replace('drive = "F"', 'motion = "0.2*sin(5*t)"')
        return read_text(text)
    if name in ("motor", "warm"):
        return read_text(MOTOR if name == "motor" else WARM, f"{name}.toml")
    if name == "every_kind":
        return bind(symdyn.read(Path(__file__).parent / "data" / "every_kind.toml"), {"F": 1})
    return symdyn.read(EXAMPLES / f"{name}.toml")


def in_complex_numbers(problem: Collocation, formulas: dict[str, list[str]]) -> Collocation:
    """Return the problem with local functions evaluated node by node, which takes complex numbers; without slopes."""
    scene, free = problem.scene, problem.free
    opened = replace(scene, parameters=tuple(replace(p, value=None) if p.name in free else p for p in scene.parameters))
    values = {p.name: p.value for p in scene.parameters}
    w = Workspace(opened, LoopChoices(parameters=tuple((n, float(values[n].value)) for n in free)))
    found = written(w, free, {name: [parse(text) for text in texts] for name, texts in formulas.items()})
    known = {w.graph.symbol(n): x.express(w.graph) for n, x in values.items() if n not in free}
    numbers = dict(zip(known, evaluate(list(known.values()), Batches(), {}), strict=True))

    def function(name: str):
        def value(at):
            count = len(at["q"])
            state = {
                symbol: at[kind] if kind == "t" else at[kind][..., k]
                for kind, symbols in found.kinds.items()
                if kind in at
                for k, symbol in enumerate(symbols)
            }
            with np.errstate(all="ignore"):
                entries = evaluate(list(found.entries[name]), Batches(), numbers | state)
            return np.stack([np.broadcast_to(x, count) for x in entries], axis=1)

        return value

    others = {n: replace(one, value=function(n)) for n, one in problem.locals.items()}
    return replace(problem, source=replace(problem.source, locals=others))


WHAT = {  # a tree, loops, rolling, quaternions, a prescribed motion, parameters that are looked for
    "cart_pole": {
        "free": ("l", "mp"),
        "cost": "F**2 + 2*t*x_ddot*point_tip_x_ddot",
        "final_cost": "2*theta**2*t + point_tip_x_dot",
    },
    "four_bar": {"cost": "M**2"},
    "rolling_disc": {},
    "free_body": {"final_cost": "t**2"},
    "led_cart": {"cost": "t*theta_dot**2 + 2*x_ddot*theta_ddot"},
    "warm": {"free": ("l", "V"), "cost": "V**2*i + 2*t*warmth**2", "final_cost": "t*i*theta"},
}


PAIRS = [*(("cart_pole", method) for method in METHODS), *((name, "hermite_simpson") for name in WHAT)]
PAIRS += [("four_bar", "implicit_midpoint"), ("free_body", "implicit_midpoint")]
"""Scenes and methods: one scene by all, every scene by one, and what is held at nodes that are no stages."""


@pytest.mark.wide(2)
@pytest.mark.heavy("rolling_disc")
@pytest.mark.parametrize(("name", "method"), dict.fromkeys(PAIRS))
def test_derivatives_are_those_of_complex_steps(name, method):
    """Imaginary steps of 1e-30 have no cancellation; what is differentiated here is evaluated without our tangents."""
    scene, given = example(name), WHAT[name]
    path = {f"{scene.coordinates[0]} + 2*t*{scene.velocities[-1]}": (-1, 1)}
    problem = symdyn.collocation(scene, (0.5, 1.5), [0, 0.3, 1], method, path=path, **given)
    formulas = {
        "path": list(path),
        "running": [given["cost"]] if "cost" in given else [],
        "final": [given["final_cost"]] if "final_cost" in given else [],
    }
    z = problem.guess + 0.3 * np.random.default_rng(1).standard_normal(problem.size)
    other = in_complex_numbers(problem, formulas)

    assert problem.residual(z) == pytest.approx(other.residual(z), rel=1e-12, abs=1e-12)
    J = problem.jacobian(z).toarray()
    steps = z + 1e-30j * np.eye(problem.size)
    expected = np.stack([other.residual(step).imag / 1e-30 for step in steps], axis=1)
    np.testing.assert_allclose(J, expected, rtol=1e-11, atol=1e-12 * np.abs(J).max())
    if formulas["running"] or formulas["final"]:
        slopes = [other.objective(step).imag / 1e-30 for step in steps]
        np.testing.assert_allclose(problem.gradient(z), slopes, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("name", METHODS)
def test_every_row_of_methods_fulfils_the_conditions_of_its_order(name):
    """Butcher's simplifying assumptions B(p) and C(s): stages integrate polynomials exactly."""
    method = METHODS[name]
    s = len(method.c)

    assert (method.starts, method.ends) == (method.c[0] == 0, method.c[-1] == 1)
    for k in range(1, method.order + 1):
        assert sum(b * c ** (k - 1) for b, c in zip(method.b, method.c, strict=True)) == Fraction(1, k)
    for k in range(1, s + 1):
        sums = [sum(a * c ** (k - 1) for a, c in zip(row, method.c, strict=True)) for row in method.A]
        assert sums == [c**k / k for c in method.c]


def test_a_scene_of_every_kind_has_exact_derivatives():
    scene = example("every_kind")
    problem = symdyn.collocation(scene, (0.5, 1.5), [0, 0.4, 1])
    z = problem.guess + 0.05 * np.random.default_rng(1).standard_normal(problem.size)
    other = in_complex_numbers(problem, {"path": [], "running": [], "final": []})

    expected = np.stack([other.residual(z + 1e-30j * way).imag / 1e-30 for way in np.eye(problem.size)], axis=1)

    np.testing.assert_allclose(problem.jacobian(z).toarray(), expected, rtol=1e-11, atol=1e-12)


@pytest.mark.heavy("rolling_disc")
@pytest.mark.parametrize(("name", "method"), dict.fromkeys(PAIRS))
def test_the_hessian_is_the_slope_of_the_gradient_of_the_lagrangian(name, method):
    scene, given = example(name), WHAT[name]
    path = {f"{scene.coordinates[0]} + 2*t*{scene.velocities[-1]}": (-1, 1)}
    problem = symdyn.collocation(scene, (0.5, 1.5), [0, 0.3, 1], method, path=path, **given)
    rng = np.random.default_rng(2)
    z, sigma, multipliers = (
        problem.guess + 0.3 * rng.standard_normal(problem.size),
        1.7,
        rng.standard_normal(problem.rows),
    )

    def slope(z):
        return sigma * problem.gradient(z) + multipliers @ problem.jacobian(z)

    def difference(way, step):
        return (slope(z + step * way) - slope(z - step * way)) / (2 * step)

    of = lagrangian(problem)
    upper = np.zeros((problem.size, problem.size))
    upper[of.rows, of.columns] = of.values(z, sigma, multipliers)
    ways = rng.standard_normal((5, problem.size))
    expected = np.array([(4 * difference(way, 1e-4) - difference(way, 2e-4)) / 3 for way in ways])
    assert np.all(of.rows <= of.columns)
    np.testing.assert_allclose(ways @ (upper + np.triu(upper, 1).T), expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("method", METHODS)
def test_the_pattern_names_each_place_once_and_in_order(method):
    problem = symdyn.collocation(example("four_bar"), (1, 2), 4, method)
    places = list(zip(problem.jacobian_rows.tolist(), problem.jacobian_columns.tolist(), strict=True))

    assert places == sorted(set(places))
    assert len(problem.jacobian_values(problem.guess)) == len(places)


def solved(problem: Collocation, z: np.ndarray) -> np.ndarray:
    """Return the z that solves the equations with the driving forces as they are, by Newton's method."""
    unknown = ~problem.given
    unknown[problem.place["force"]] = False
    for _ in range(12):
        g, J = problem.residual(z)[problem.binding], problem.jacobian(z)[problem.binding][:, unknown]
        assert J.shape[0] == J.shape[1]
        step = spsolve(J.tocsc(), g)
        z = z.copy()
        z[unknown] -= step
        if np.abs(step).max() < 1e-11:
            return z
    raise AssertionError(f"Newton's method does not converge: {np.abs(step).max()}")


MOVES = {  # a scene, the time of the end, a start
    "cart_pole": (0.6, {"theta": "2"}, {"theta": "1"}),
    "four_bar": (0.5, {}, {"phi": "1"}),
    "rolling_disc": (0.4, {}, {}),
    "free_body": (0.5, {}, {}),
    "governor": (0.2, {}, {}),
    "led_cart": (0.6, {"theta": "2"}, {"theta": "1"}),
    "motor": (0.6, {"theta": "2", "i": "3"}, {"theta": "1"}),
}


ORDERS = {"trapezoidal": 2, "hermite_simpson": 4, "implicit_midpoint": 2}
EVERY = ("cart_pole", "four_bar", "rolling_disc")
"""Scenes whose order is looked at by all methods."""


@pytest.mark.wide("cart_pole-trapezoidal", "four_bar-trapezoidal", "free_body-hermite_simpson")
@pytest.mark.parametrize(
    ("name", "method"),
    [(name, method) for name in MOVES for method in ORDERS if name in EVERY or method == "hermite_simpson"],
)
def test_errors_fall_with_the_order_of_the_method(name, method):
    order = ORDERS[method]
    assert order == METHODS[method].order
    scene, (until, start, rates) = example(name), MOVES[name]
    errors, residuals = [], []
    for intervals in (10, 20):
        problem = symdyn.collocation(scene, until, intervals, method, start=start, start_rates=rates)
        run = symdyn.simulate(
            scene, until=until, start=start, start_rates=rates, rtol=1e-12, atol=1e-12, every=until / 2 / intervals
        )
        z = along(problem, run)
        z[problem.place["force"]] = 0.0
        last = problem.residual(z)[problem.row["defects"]][:, -1]
        residuals.append(np.sqrt(np.mean(last**2)) * intervals)
        end = [problem.place[kind][-1] for kind in ("q", "s", "u")]
        found = solved(problem, z)
        errors.append(max(np.abs(found[place] - z[place]).max(initial=0.0) for place in end))

    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)
    assert np.log2(residuals[0] / residuals[1]) == pytest.approx(order, abs=0.5)


@pytest.mark.parametrize("name", ["cart_pole", "four_bar", "free_body", "led_cart", "warm"])
@pytest.mark.parametrize("method", METHODS)
def test_a_time_that_is_given_has_the_slopes_of_one_that_is_found(name, method):
    scene = example(name)
    given, found = (symdyn.collocation(scene, until, [0, 0.3, 1], method) for until in (1.5, (0.5, 2.5)))
    z = np.random.default_rng(8).normal(size=given.size)

    for one in (z, z + 1):  # the second call, too
        whole = found.jacobian(np.append(one, 1.5)).toarray()[:, :-1]
        assert given.jacobian(one).toarray() == pytest.approx(whole, rel=1e-13, abs=1e-13)


def test_two_times_of_the_end_may_stand_in_an_array():
    between, same = (symdyn.collocation(example("cart_pole"), until, 4) for until in ((0.5, 2.5), np.array([0.5, 2.5])))

    assert same.size == between.size
    assert (same.lower[-1], same.upper[-1]) == (0.5, 2.5) == (between.lower[-1], between.upper[-1])


def test_a_problem_and_its_hessian_pickle():
    problem = symdyn.collocation(CART, (0.5, 1.5), 4, cost="F**2 + 2*t*x**2", free="l")
    z, weights = problem.guess + 0.1, np.ones(problem.rows)
    problem.jacobian_values(z)
    again, of = pickle.loads(pickle.dumps((problem, lagrangian(problem))))

    assert np.array_equal(again.residual(z), problem.residual(z))
    assert np.array_equal(again.jacobian_values(z), problem.jacobian_values(z))
    assert np.array_equal(of.values(z, 2.0, weights), lagrangian(problem).values(z, 2.0, weights))
    assert (again.scene, again.free, again.notes) == (problem.scene, problem.free, problem.notes)


REST = "at rest at the end, where positions are given: x_dot"
FOUR = example("four_bar")
SLIDES = read_text(
    (EXAMPLES / "cart_pole.toml").read_text().replace('drive = "F"', 'drive = "F"\nlimits = { upper = "2*l" }')
)


@pytest.mark.parametrize(
    ("scene", "given", "told"),
    [
        (CART, {"cost": "F**2", "path": {"x**2": (0, 1)}, "free": "l"}, []),
        (CART, {"cost": "abs(F) + 3*x"}, ["slopes of the cost are one-sided where .* turns over, of F: .*flat"]),
        (CART, {"path": {"sign(theta)": (0, 1)}}, ["slopes of the path are one-sided where .*, of theta: "]),
        (CART, {"final_cost": "sqrt(x**2)"}, [r"slopes of the final cost are no number \(NaN\) .*, of x"]),
        (
            CART,
            {"end": {"x": "2*l", "theta": 0}, "free": ("l", "mp")},
            [REST, "end: x takes l as the scene has it, not .*"],
        ),
        (CART, {"end": {"x": "2*l"}}, [REST]),
        (CART, {"end": {"x": "2*l"}, "end_rates": "free"}, []),
        (SLIDES, {"free": "l"}, ["limits of .* takes l as the scene has it, .*"]),
        (
            FOUR,
            {"start": {"phi": 1, "psi": 1}},
            ["start: more coordinates are given than can be chosen freely; phi .*"],
        ),
        (FOUR, {"free": ("m1", "b")}, ["rows at the start, which is given whole, have b in them: .* are left"]),
    ],
)
def test_kinks_and_what_stays_as_it_was_given_are_told(scene, given, told):
    every = symdyn.collocation(scene, 1, 2, **given).notes
    notes = [one for one in every if not one.startswith("no cost")]

    assert ("no cost: any motion that keeps all conditions will do" in every) == (not {"cost", "final_cost"} & {*given})
    assert len(notes) == len(told)
    assert all(re.match(one, note) for one, note in zip(told, notes, strict=True)), notes


def test_an_end_of_positions_is_at_rest_unless_its_velocities_are_free() -> None:
    """Velocities there were free without a word, though the start is at rest: a load arrived at 6.6 m/s."""

    def zeros(**how: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
        cart = symdyn.example("cart_pole")
        problem = symdyn.collocation(cart, 2, 4, cost="F**2", end={"x": 1, "theta": "pi"}, **how)
        last = problem.place["u"][problem.grid.node[-1]]
        fixed = problem.lower[last] == problem.upper[last]
        return tuple(np.array(cart.velocities)[fixed]), problem.notes

    assert zeros()[0] == ("x_dot", "theta_dot")
    (note,) = zeros()[1]
    assert note == (
        'at rest at the end, where positions are given: x_dot, theta_dot = 0; end_rates="free" leaves them free'
    )
    assert zeros(end_rates="free") == ((), ())
    assert zeros(end_rates={"x": "free"})[0] == ("theta_dot",)
    assert zeros(end_rates={"x_dot": 1, "theta": 0}) == (("x_dot", "theta_dot"), ())
    with pytest.raises(SimulateError, match="end rates: y is not known"):
        zeros(end_rates={"y": "free"})


def test_an_end_of_a_quaternion_is_at_rest() -> None:
    spun = read_text(
        """
        [bodies.b]
        mass = 1
        inertia = [1, 2, 3]
        inertia_about = "com"
        com = [0, 0, 0.1]
        [joints.j]
        type = "spherical"
        parent = "ground"
        child = "b"
        """,
    )

    problem = symdyn.collocation(spun, 1, 4, end=dict.fromkeys(spun.coordinates[1:], 0))

    last = problem.place["u"][problem.grid.node[-1]]
    assert not problem.upper[last].any()
