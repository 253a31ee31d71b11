"""What equations in SymPy answer: accelerations, ẋ = f(x, u), functions for SciPy; against symdyn's own runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symdyn
from symdyn.errors import EmitError, UnknownNameError
from symdyn.scene import read_text

pytestmark = [pytest.mark.long, pytest.mark.runs("cc")]

EXAMPLES = Path(__file__).parent.parent / "examples"

STRUT = """
name = "strut"
gravity = [0, -9.81, 0]
parameters = { k = 40, c = 0.3, m = 2 }
bodies.ball = { mass = "m" }
[joints.across]
type = "prismatic"
parent = "ground"
child = "carriage"
axis = [1, 0, 0]
coordinate = "x"
[joints.down]
type = "prismatic"
parent = "carriage"
child = "ball"
axis = [0, 1, 0]
coordinate = "y"
[bodies.carriage]
[springs.s]
from = { body = "ground", at = [0, 1, 0] }
to = "ball"
stiffness = "k"
free = 0.4
[dampers.d]
from = { body = "ground", at = [0, 1, 0] }
to = "ball"
damping = "c"
"""

LED = """
name = "led"
gravity = [0, -9.81, 0]
parameters = { l = 0.7, m = 1, w = 3 }
bodies.cart = { mass = 2 }
bodies.bob = { mass = "m", com = [0, "-l", 0] }
[joints.rail]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
motion = "0.1*sin(w*t)"
[joints.pin]
type = "revolute"
parent = "cart"
child = "bob"
axis = [0, 0, 1]
coordinate = "q"
"""

SCENES: dict[str, tuple[Any, dict[str, float], dict[str, str]]] = {
    "cart_pole": (EXAMPLES / "cart_pole.toml", {"theta": 0.3}, {"F": "2*sin(3*t) - x_dot"}),
    "double_pendulum": (EXAMPLES / "double_pendulum.toml", {"q1": 1, "q2": -0.4}, {}),
    "four_bar": (EXAMPLES / "four_bar.toml", {"phi": 0.9}, {"M": "1 - phi_dot"}),
    "slider_crank": (EXAMPLES / "slider_crank.toml", {"phi": 0.4}, {}),
    "strut": (STRUT, {"x": 0.3, "y": 0.1}, {}),
    "led": (LED, {"q": 0.5}, {}),
}


def told(name: str) -> tuple[symdyn.Scene, dict[str, float], dict[str, str]]:
    scene, start, forces = SCENES[name]
    return (symdyn.read(scene) if isinstance(scene, Path) else read_text(scene)), start, forces


@pytest.mark.heavy("slider_crank", "state_space-four_bar")
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("way", ["state_space", "lambdify"])
def test_scipy_moves_what_sympy_says_as_symdyn_does(name: str, way: str) -> None:
    scene, start, forces = told(name)
    run = symdyn.simulate(scene, until=0.5, every=0.1, start=start, forces=forces, rtol=1e-12, atol=1e-13)
    equations = symdyn.equations(scene)
    if way == "lambdify":
        rates = equations.lambdify(forces)
    else:
        x, f = equations.state_space()
        symbols = equations.sympy()
        idle = dict.fromkeys(map(symbols.__getitem__, filter(None, scene.drives)), 0)
        drives = {symbols[one]: sympy.sympify(text, dict(symbols.symbols)) for one, text in forces.items()}
        plain = f.subs({**symbols.values, **idle, **drives})
        call = sympy.lambdify([symbols["t"], list(x)], list(plain), cse=True)
        rates = lambda t, x: np.array(call(t, x), dtype=float)  # noqa: E731
    first = np.concatenate([run.q[0], run.qd[0]])
    found = solve_ivp(rates, (0, 0.5), first, t_eval=run.t, rtol=1e-12, atol=1e-13, method="DOP853")
    assert pytest.approx(np.hstack([run.q, run.qd]), rel=1e-9, abs=1e-9) == found.y.T


def test_accelerations_and_multipliers_solve_the_equations() -> None:
    four_bar = symdyn.equations(symdyn.read(EXAMPLES / "four_bar.toml")).sympy()
    qdd, multipliers = four_bar.solve_accelerations()
    point = {**four_bar.values, four_bar["M"]: 1}
    point |= {one: 0.3 + 0.1 * k for k, one in enumerate([*four_bar.q, *four_bar.qd])}
    e = four_bar
    M, a, rest, tau, G, pulls, bias = (
        np.array(one.subs(point).evalf().tolist(), dtype=float)
        for one in (e.M, qdd, e.c + e.g + e.k_E, e.tau, e.G, multipliers, e.bias)
    )
    assert M @ a + rest == pytest.approx(tau + G.T @ pulls, abs=1e-9)
    assert G @ a == pytest.approx(-bias, abs=1e-9)


def test_what_is_too_long_to_be_solved_in_symbols_is_solved_in_numbers() -> None:
    scene = symdyn.read(EXAMPLES / "puma560.toml")
    equations = symdyn.equations(scene).sympy()
    with pytest.raises(EmitError, match=r"puma560: 6 equations are too many.*take \.lambdify\(\)"):
        equations.state_space()
    x = np.linspace(-0.6, 0.8, 12)
    known = symdyn.load(scene, "forward_dynamics").forward_dynamics(x[:6], x[6:], np.zeros(6))
    assert equations.lambdify()(0.0, x)[6:] == pytest.approx(known, rel=1e-9)


def test_symbols_are_replaced_by_name_in_all_matrices() -> None:
    strut = symdyn.equations(read_text(STRUT)).sympy()
    found = strut.subs({"k": "2*m", strut["x"]: 0})
    assert not found.sub
    assert found.k_E.free_symbols == {strut["m"], strut["y"]}
    assert strut.subs("m", 3).M[1, 1] == 3
    with pytest.raises(UnknownNameError, match="there is no 'mass'"):
        strut.subs("mass", 3)


def test_dynamic_symbols_are_functions_for_scipy_too() -> None:
    scene = told("cart_pole")[0]
    x = np.array([0.1, 0.3, -0.2, 0.5])
    plain, dynamic = (symdyn.equations(scene).sympy(dynamic=one).lambdify({"F": "-x"}) for one in (False, True))
    assert dynamic(0.0, x) == pytest.approx(plain(0.0, x), rel=1e-14)


T = sympy.Symbol("t")
THETA = sympy.Function("theta")(T)


@pytest.mark.parametrize("dynamic", [False, True])
@pytest.mark.parametrize(
    "force",
    [
        -2 * sympy.Symbol("theta_dot") * sympy.Symbol("theta") + sympy.sin(T),
        -2 * sympy.Symbol("theta_dot", positive=True) * THETA + sympy.sin(sympy.Symbol("t", positive=True)),
        -2 * THETA.diff(T) * THETA + sympy.sin(T),
        -2 * dynamicsymbols("theta", 1) * dynamicsymbols("theta") + sympy.sin(dynamicsymbols._t),
    ],
)
def test_a_symbol_written_as_a_name_is_that_one(force: Any, dynamic: bool) -> None:
    symbols = symdyn.equations(symdyn.example("cart_pole")).sympy(dynamic=dynamic)
    text, x = "-2*theta_dot*theta + sin(t)", np.array([0.1, 0.3, -0.2, 0.5])
    expected = symbols.lambdify({"F": text})(0.7, x)
    assert symbols.lambdify({sympy.Symbol("F"): force})(0.7, x) == pytest.approx(expected, rel=1e-14)
    assert symbols.subs(F=force).tau == symbols.subs(F=text).tau
    assert symbols.subs({sympy.Symbol("mp"): 3}).M == symbols.subs(mp=3).M
    assert symbols[sympy.Symbol("theta")] == symbols["theta"]


@pytest.mark.parametrize("dynamic", [False, True])
def test_a_constant_takes_the_place_of_no_function_and_of_no_other_symbol(dynamic: bool) -> None:
    """A length l(t) stays one, beside the constants l and b; what is negative is no mass of the scene."""
    symbols = symdyn.equations(symdyn.example("cart_pole")).sympy(dynamic=dynamic)
    for name in ("l", "b"):
        own = sympy.Function(name)(T)
        for put in (own, own.diff(T)):
            assert symbols.subs(l=put).M == symbols.M.subs(symbols["l"], put.subs(T, symbols["t"])) != symbols.M
        assert symbols.subs({own: 3}).M == symbols.M
        with pytest.raises(UnknownNameError, match=rf"there is no '{name}\(t\)'"):
            symbols[own]
    for strange in (sympy.Symbol("mp", negative=True), sympy.Symbol("mp", imaginary=True)):
        for given in ({"l": strange**2}, {strange: 3}):
            with pytest.raises(UnknownNameError, match="mp: the scene's has other assumptions; give 'mp' or"):
                symbols.subs(given)
        with pytest.raises(UnknownNameError, match="mp: the scene"):
            symbols[strange]


@pytest.mark.parametrize("dynamic", [False, True])
def test_what_stands_in_the_equations_is_its_own_name(dynamic: bool) -> None:
    for scene in ("cart_pole", "scara"):
        symbols = symdyn.equations(symdyn.example(scene)).sympy(dynamic=dynamic)
        assert [symbols[one] for one in symbols.symbols.values()] == [*symbols.symbols.values()]
        assert symbols[dynamicsymbols(symbols.scene.coordinates[0], 1)] == symbols.qd[0]
        with pytest.raises(UnknownNameError, match="there is no "):
            symbols[symbols.q[0] ** 2]


def test_a_slope_has_the_rate_of_a_plain_symbol() -> None:
    symbols = symdyn.equations(symdyn.example("cart_pole")).sympy()
    slopes = []
    for rate in (sympy.Symbol("theta_dot"), symbols["theta_dot"]):
        x, f = symbols.subs(F=-2 * rate).state_space()
        slopes.append(f.jacobian(x))
    assert slopes[0] == slopes[1]
    assert slopes[0][2, 3].subs(symbols["theta_dot"], 0) != 0


def test_a_force_may_have_parameters_and_no_strange_names() -> None:
    symbols = symdyn.equations(symdyn.example("cart_pole")).sympy()
    mass, x = sympy.Symbol("mp"), np.array([0.1, 0.3, -0.2, 0.5])
    one = symbols.lambdify({"F": -mass * sympy.Symbol("x"), "mp": 2 * sympy.Symbol("mc"), "mc": 3})(0, x)
    assert one == pytest.approx(symbols.lambdify({"F": -6 * sympy.Symbol("x"), "mp": 6, "mc": 3})(0, x), rel=1e-14)
    for strange, name in ((sympy.Symbol("mu"), "mu"), (sympy.Function("u")(T), r"u\(t\)")):
        with pytest.raises(UnknownNameError, match=f"cart_pole: there is no {name}; "):
            symbols.lambdify({"F": strange})
    with pytest.raises(EmitError, match="is no value; give a number, a formula or an expression"):
        symbols.subs(F=sympy.Matrix([1]))


def test_parameters_without_a_value_are_asked_for() -> None:
    equations = symdyn.equations(symdyn.read(EXAMPLES / "two_link.toml"))
    with pytest.raises(EmitError, match=r"two_link: no value for g, h1, h2, m1, m2; give \{'g': 1, .*'m2': 1\}"):
        equations.lambdify()
    with pytest.raises(EmitError, match="3 names no values"):
        equations.lambdify(3)  # type: ignore[arg-type]
    symbols = equations.sympy()
    assert equations.lambdify({symbols[name]: 1 for name in ("g", "h1", "h2", "m1", "m2")})(0, np.zeros(4)).any() == 0
    assert equations.lambdify({"g": 10, "h1": 1, "h2": 1, "m1": 1, "m2": 1})(0, np.zeros(4)).shape == (4,)


@pytest.mark.parametrize("dynamic", [False, True])
def test_equations_with_values_answer_as_those_without(dynamic: bool) -> None:
    pendulum = symdyn.equations(symdyn.example("pendulum"))
    put = (pendulum.sympy(dynamic) if dynamic else pendulum).subs(m=2, b=0)

    assert put.text() == "2*g*l*sin(q1) + 2*l**2*q1_ddot = tau1"
    assert [symdyn.scene.parse(side) for side in put.text().split(" = ")]
    assert put.sympy() is put
    assert "&= \\tau_{1}" in put.latex() or "&= \\tau_1" in put.latex()
    for name in ("text", "latex", "sympy", "subs", "solve_accelerations", "state_space", "lambdify"):
        assert callable(getattr(put, name))
        assert callable(getattr(pendulum, name))
