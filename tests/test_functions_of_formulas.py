"""Functions of formulas: their digits near edges, their derivatives at rest, where they bend, and how they print."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.optimize import brentq

import symdyn
from symdyn.algebra import Floats, Form
from symdyn.emit.print import text_of
from symdyn.errors import SimulateError
from symdyn.graph import Graph, evaluate
from symdyn.scene import parse, read_text
from symdyn.scene.toml import write_text
from symdyn.scene.values import spell
from symdyn.verify import certify

EDGES = (0.0, 1e-300, 1e-12, 1e-4, 0.3, 0.5, 0.9, 1 - 1e-6, 1 - 1e-12, 1 - 2.0**-53, 1.0)
WIDE = (*EDGES, 2.5, 20.0, 300.0, 700.0)


def value(text: str, **places: float) -> float:
    graph = Graph()
    node = parse(text).express(graph)
    return float(evaluate([node], Floats(), {graph.symbol(name): x for name, x in places.items()})[0])


@pytest.mark.parametrize(
    ("name", "exact", "places"),
    [
        ("asin", mpmath.asin, EDGES),
        ("acos", mpmath.acos, EDGES),
        ("atan", mpmath.atan, WIDE),
        ("sinh", mpmath.sinh, WIDE),
        ("cosh", mpmath.cosh, WIDE),
    ],
)
def test_what_is_composed_has_its_digits_near_edges(
    name: str, exact: Callable[..., mpmath.mpf], places: tuple[float, ...]
) -> None:
    for x in (sign * place for place in places for sign in (1, -1)):
        with mpmath.workprec(200):
            truth = exact(mpmath.mpf(x))
            found = mpmath.mpf(value(f"{name}(x)", x=x))
            assert abs(found - truth) <= 4 * mpmath.mpf(2) ** -53 * abs(truth), (x, found)


def test_extremes_choices_and_powers_are_those_of_python() -> None:
    for x in (-2.0, -0.0, 0.0, 1e-20, 1.0, 3e20):
        assert value("max(x, 1, 0)", x=x) == max(x, 1, 0)
        assert value("min(x, 1)", x=x) == min(x, 1)
        assert value("abs(x)**1.5", x=x) == abs(x) ** 1.5
        assert value("if(x > 0, 1, 2)", x=x) == (1 if x > 0 else 2)
        assert value("if(x >= 0, 1, 2)", x=x) == (1 if x >= 0 else 2)
        assert value("if(-1 < x <= 1 and not x < 0, 1, 2)", x=x) == (1 if -1 < x <= 1 and not x < 0 else 2)
        assert value("if(x < -1 or x > 1, x, 0)", x=x) == (x if x < -1 or x > 1 else 0)


@pytest.mark.parametrize(
    "text",
    ["max(x, 0)", "min(x, y, z)", "if(x > y, a, b)", "if(x > 0, a*x, b)", "x**1.5", "(x + 1)**(-2/3)", "(x**1.5)**2"],
)
def test_a_formula_is_written_as_it_is_read(text: str) -> None:
    found = parse(text)
    assert parse(spell(found)) == found
    graph = Graph()
    node = found.express(graph)
    printed = parse(text_of(Form.of(node))).express(graph)
    places = {graph.symbol(name): 0.3 + 0.2 * k for k, name in enumerate(found.symbols)}
    one, other = evaluate([node, printed], Floats(), places)
    assert other == pytest.approx(one, rel=1e-15)


CART = """
name = "cart"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 1, unit = "kg" }
k = { value = 400, unit = "N/m" }
d = 3
F = { value = 50, unit = "N" }
n = 1.25
g = { value = 9.81, unit = "m/s^2" }
[bodies.cart]
mass = "m"
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [0, 0, 1]
coordinate = "z"
force = "{force}"
"""

PULLED = "min(k*max(-z, 0), F) - d*abs(z_dot)**1.5*sign(z_dot) + if(z > 1 and z_dot > 0, -F*(1 + z/h)**n, 0)"


def cart(force: str) -> symdyn.Scene:
    return read_text(CART.replace("{force}", force).replace("n = 1.25", 'n = 1.25\nh = { value = 2, unit = "m" }'))


@pytest.mark.long
def test_every_law_and_every_text_is_proved(numpy_alone: None) -> None:
    assert certify(cart(PULLED)).passed


def test_equations_print_as_they_are_read(tmp_path: Path) -> None:
    found = symdyn.equations(cart(PULLED))
    page = found.latex()
    assert r"\min(k \max(-z, 0), F)" in page.replace(r"\bigl", "").replace(r"\bigr", "")
    assert r"\lvert \dot z \rvert^{\tfrac{3}{2}}" in page
    assert r"\begin{cases}" in page
    (row,) = found.sympy().equations
    assert row.has(sympy.Piecewise, sympy.Max, sympy.Min)
    scene = cart(PULLED)
    file = tmp_path / "again.toml"
    file.write_text(write_text(scene).text)
    assert symdyn.read(file) == scene


def test_derivatives_at_rest_are_numbers() -> None:
    """A square root of |v| has none there: abs(v)**1.5 has, and it is 0; max takes the side of below."""
    system = symdyn.linearize(cart("k*max(-z, 0) - d*abs(z_dot)**1.5*sign(z_dot) + m*g"), start={"z": 0})
    assert_allclose(system.A, [[0, 1], [0, 0]], atol=1e-12)
    pressed = symdyn.linearize(cart("k*max(-z, 0) - d*abs(z_dot)**1.5*sign(z_dot)"), start={"z": -9.81 / 400})
    assert_allclose(pressed.A, [[0, 1], [-400, 0]], atol=1e-12)


@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("method", ["dop853", "radau", "lsoda"])
def test_a_bouncing_mass_comes_back_as_the_closed_form_says(method: str) -> None:
    """It falls 1 m on a spring that only pushes; integrators begin anew where it touches and leaves."""
    w, g = 20.0, 9.81
    fall = np.sqrt(2 / g)
    contact = brentq(lambda t: g / w**2 * (np.cos(w * t) - 1) - g * fall / w * np.sin(w * t), 1e-3, 0.3)
    period = 2 * fall + contact

    run = symdyn.simulate(
        cart("k*max(-z, 0)"), until=2 * period, every=2 * period, start={"z": 1.0}, method=method, rtol=1e-9
    )
    assert run["z"][-1] == pytest.approx(1.0, abs=2e-7)
    assert not run.events


@pytest.mark.long
@pytest.mark.runs("cc")
def test_places_where_equations_bend_are_steps_of_integrators() -> None:
    """A force that begins at a place: a line, then a parabola."""
    run = symdyn.simulate(
        cart("m*g + if(z > h/4, F, 0)"),
        until=1.0,
        every=1.0,
        start={"z": 0.0},
        start_rates={"z": 1.0},
        rtol=1e-9,
        method="rk45",
    )
    assert run["z"][-1] == pytest.approx(0.5 + 0.5 + 50 * 0.5**2 / 2, rel=1e-8)


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.runs("cc")
@pytest.mark.parametrize("force", ["5e3*(abs(z + 1) - abs(z - 1) - 2*z)", "1e4*(max(-1 - z, 0) - max(z - 1, 0))"])
@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_no_step_goes_across_a_bend(force: str, method: Any) -> None:
    """Between two walls that are springs: a flight of 2 s, then pi/100 s in a wall; across edges digits are lost."""
    text = (
        'name = "flight"\nunits = "none"\n[bodies.bob]\nmass = 1\n[joints.slide]\ntype = "prismatic"\nparent = "ground"'
    )
    text += (
        f'\nchild = "bob"\naxis = [1, 0, 0]\ncoordinate = "z"\ndrive = false\nstart_rates = [1]\nforce = "{force}"\n'
    )
    times = 2 * (1 + np.pi / 200) * np.arange(1, 6) - 1 - np.pi / 200  # in the midst of a stay
    run = symdyn.simulate(read_text(text), until=20, rtol=1e-8, method=method)
    assert_allclose(run(times)["z"], 1.01 * (-1) ** np.arange(5.0), rtol=0, atol=1e-8)
    assert_allclose([run["z"][-1], run["z_dot"][-1]], [20 - 2 - 10 * (2 + np.pi / 100) + 2, 1], rtol=0, atol=1e-7)


@pytest.mark.long
@pytest.mark.runs("cc")
def test_what_jumps_has_no_gradient_and_what_bends_has() -> None:
    with pytest.raises(SimulateError, match="jumps"):
        symdyn.sensitivity(cart("m*g + if(z > h/4, F, 0)"), until=0.1, start={"z": 0.4})
    found = symdyn.sensitivity(cart("k*max(-z, 0)"), until=0.1, start={"z": -0.1})
    assert np.isfinite(found.matrix).all()
