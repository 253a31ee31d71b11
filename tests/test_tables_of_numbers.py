"""Tables of numbers in formulas: against SciPy, in proofs, in runs, written and read, and what is refused."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicHermiteSpline,
    CubicSpline,
    RectBivariateSpline,
    RegularGridInterpolator,
)

import symdyn
import symdyn.scene as declared
from symdyn.algebra import Floats
from symdyn.dynamics import derive
from symdyn.emit import emit
from symdyn.errors import SceneError, SimulateError
from symdyn.graph import Graph, evaluate, tangents
from symdyn.program import lower
from symdyn.runtime import RUNNERS
from symdyn.scene import read_text
from symdyn.scene.toml import write_text
from symdyn.scene.values.curve import METHODS, Curve
from symdyn.verdict import Verdict
from symdyn.verify import certify
from symdyn.verify.building import read_back

X = ["-1", "-0.4", "0", "0.3", "1", "1.25", "2"]
Y = ["30", "20", "0", "-5", "-10", "-10", "4.5"]


def curve(method: str, x: list[str] = X, y: list[str] = Y) -> Curve:
    return Curve("c", tuple((Fraction(a), Fraction(b)) for a, b in zip(x, y, strict=True)), method)


def values(one: Curve, places: np.ndarray, order: int = 0) -> np.ndarray:
    graph = Graph()
    x = graph.symbol("x")
    node = one.body(graph, [x])
    for _ in range(order):
        (node,) = tangents([node], {x: graph.one})
    return np.array([evaluate([node], Floats(), {x: float(place)})[0] for place in places])


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("method", METHODS)
def test_values_and_derivatives_are_those_of_scipy(method: str, order: int) -> None:
    x, y = np.array(X, float), np.array(Y, float)
    inside = np.setdiff1d(np.linspace(-1, 2, 61), x)
    if method == "linear":
        slopes = np.diff(y) / np.diff(x)
        wanted = [np.interp(inside, x, y), slopes[np.searchsorted(x, inside) - 1], 0 * inside][order]
    else:
        wanted = (Akima1DInterpolator if method == "akima" else CubicSpline)(x, y)(inside, order)
    assert_allclose(values(curve(method), inside, order), wanted, rtol=1e-13, atol=4e-15 * 30 * 50**order)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_points_are_enough(method: str, count: int) -> None:
    one = curve(method, X[:count], Y[:count])
    x, y = np.array(X[:count], float), np.array(Y[:count], float)
    assert_allclose(values(one, x), y, atol=1e-14 * 30)
    if method == "cubic":
        places = np.linspace(-1, x[-1], 9)
        assert_allclose(values(one, places), CubicSpline(x, y)(places), atol=1e-12)
    before, behind = values(one, np.array([x[0] - 2.0, x[-1] + 3.0]), 1)
    assert_allclose([before, behind], values(one, x[[0, -1]] + [-1e-9, 1e-9], 1))


def along_both(method: str, x: np.ndarray, y: np.ndarray, z: np.ndarray, a: float, b: float) -> float:
    """Return what SciPy's interpolators make of a grid, shape (len(y), len(x)), at x = a, y = b."""
    if method == "linear":
        return float(np.squeeze(RegularGridInterpolator((y, x), z)((b, a))))
    if method == "cubic":
        return float(RectBivariateSpline(y, x, z, s=0)([b], [a])[0, 0])
    slopes = Akima1DInterpolator(y, z, axis=0).derivative()(y)
    there, rising = (Akima1DInterpolator(x, one, axis=1)(a) for one in (z, slopes))
    return float(CubicHermiteSpline(y, there, rising)(b))


@pytest.mark.parametrize("method", METHODS)
def test_two_arguments_are_a_grid(method: str) -> None:
    rng = np.random.default_rng(1)
    x, y = np.array([0, 1, 2.5, 3, 4]), np.array([-1, 0, 2, 2.5])
    z = rng.integers(-9, 9, (4, 5)).astype(float)
    z[1] = z[2] = 3.0  # a ridge, on which Akima's weights vanish
    grid = [(None, *map(Fraction, x)), *((Fraction(b), *map(Fraction, row)) for b, row in zip(y, z, strict=True))]
    one, graph = Curve("c", tuple(grid), method), Graph()
    u, v = graph.symbol("u"), graph.symbol("v")
    node = one.body(graph, [u, v])
    slopes = [tangents([node], {symbol: graph.one})[0] for symbol in (u, v)]
    for a, b in ((0.3, -0.2), (1.0, 0.0), (2.4, 1.9), (0, -1), (3.7, 2.2), (4, 2.5)):
        assert float(one.at([a, b])) == pytest.approx(along_both(method, x, y, z, a, b), rel=1e-12, abs=1e-12)
    for a, b in ((0.3, -0.2), (2.4, 1.9), (3.7, 2.2)):
        ends = [[along_both(method, x, y, z, *at) for at in ((a + h, b), (a, b + h))] for h in (1e-6, -1e-6)]
        found = evaluate(slopes, Floats(), {u: a, v: b})
        assert_allclose(found, np.subtract(ends[0], ends[1]) / 2e-6, rtol=1e-6, atol=1e-6)


CART = """
name = "cart"
[bodies.cart]
mass = 1
[joints.slide]
type = "prismatic"
parent = "ground"
child = "cart"
axis = [1, 0, 0]
coordinate = "x"
force = '{force}'
[tables.damper]
points = [[-1, 30], [-0.2, 20], [0, 0], [0.3, -5], [1, -10]]
method = "akima"
"""


def cart(folder: Path, force: str = 'table("damper", x_dot) + table("spring.csv", x)') -> symdyn.Scene:
    (folder / "spring.csv").write_text("x; F\n# measured\n-0.5; 200\n-0.1; 20\n0; 0\n0.25; -1e1\n")
    (folder / "cart.toml").write_text(CART.replace("{force}", force))
    return symdyn.read(folder / "cart.toml")


def test_a_scene_with_tables_is_written_and_declared_in_python(tmp_path: Path) -> None:
    scene = cart(tmp_path)
    (tmp_path / "again.toml").write_text(write_text(scene).text)
    (tmp_path / "spring.csv").unlink()
    assert symdyn.read(tmp_path / "again.toml") == scene
    slide = declared.prismatic(
        "slide", "ground", "cart", axis=[1, 0, 0], coordinate="x", force='table("damper", x_dot) + table("spring", x)'
    )
    tables = [
        declared.table("damper", [[-1, 30], [-0.2, 20], [0, 0], [0.3, -5], [1, -10]], method="akima"),
        declared.table("spring", [[-0.5, 200], [-0.1, 20], [0, 0], [0.25, -10]]),
    ]
    made = declared.scene("cart", bodies=[declared.body("cart", mass=1)], joints=[slide], tables=tables)
    assert made == scene


def test_equations_name_the_table_and_every_law_is_proved(tmp_path: Path, numpy_alone: None) -> None:
    scene = cart(tmp_path)
    page = symdyn.equations(scene)
    assert r"\operatorname{damper}(\dot x) + \operatorname{spring}(x)" in page.latex()
    assert 'table("damper", x_dot) + table("spring", x)' in page.text()
    assert certify(scene).passed


@pytest.mark.parametrize("target", ["c", "cpp", "rust", "numpy", "js", "gpu"])
def test_code_looks_a_table_up_one_line_each(target: str) -> None:
    """A hundred points are one operation, of the derivative another one; with another digit the text is not proved."""
    wave = [[k / 50 - 1, round(10 * float(np.sin(k / 7)), 6)] for k in range(100)]
    text = CART.replace("{force}", 'table("damper", x_dot)')
    text = text.replace("[[-1, 30], [-0.2, 20], [0, 0], [0.3, -5], [1, -10]]", str(wave))
    program = lower(derive(read_text(text), ["forward_dynamics", "forward_dynamics_by_qd"]))
    assert [str(one.counts) for one in program.routines] == ["0 mul, 1 add, 1 other", "0 mul, 0 add, 1 other"]

    made = emit(program, target)
    for code in made.texts.values():
        lines = [line for line in code.splitlines() if "0.98, " in line]
        assert len(lines) in (0, 2)
        assert all("damper" in line for line in lines)
    for told, wanted in (("0.98, ", Verdict.PROVED), ("0.99, ", Verdict.DIFFERENT)):
        changed = {name: code.replace("0.98, ", told).encode() for name, code in made.texts.items()}
        found = read_back(made, changed)
        assert {one.verdict for one in found if one.functions or one.where} == {wanted}


@pytest.mark.long
@pytest.mark.runs("cc", "node")
@pytest.mark.parametrize("target", ["c", "js", "numpy"])
def test_code_gives_what_the_table_has(target: str, tmp_path: Path) -> None:
    program = lower(derive(cart(tmp_path), ["forward_dynamics", "forward_dynamics_by_qd"]))
    module = RUNNERS[target].run(emit(program, target))
    akima = curve("akima", ["-1", "-0.2", "0", "0.3", "1"], ["30", "20", "0", "-5", "-10"])
    places = np.array([-3, -1, -0.7, -0.2, 0, 1e-300, 0.3, 0.31, 1, 2])
    for order, name in enumerate(("forward_dynamics", "forward_dynamics_by_qd")):
        found = [np.ravel(getattr(module, name)([0.0], [place], [0.0]))[0] for place in places]
        assert_allclose(found, values(akima, places, order), rtol=1e-14, atol=1e-14)
        assert np.isnan(getattr(module, name)([0.0], [np.nan], [0.0])).all()


def test_derivatives_of_the_motion_are_the_slopes_of_the_tables(tmp_path: Path) -> None:
    found = symdyn.linearize(cart(tmp_path), start={"x": 0.1}, anywhere=True)
    assert_allclose(found.A[1, 0], -40, rtol=1e-13)
    assert_allclose(
        found.A[1, 1],
        values(curve("akima", ["-1", "-0.2", "0", "0.3", "1"], ["30", "20", "0", "-5", "-10"]), np.zeros(1), 1)[0],
    )


@pytest.mark.long
@pytest.mark.runs("cc")
def test_a_run_along_a_table_is_exact_between_knots(tmp_path: Path) -> None:
    """A linear spring in two pieces: half a swing of each, by its own period."""
    stiff, soft = 450.0, 40.0
    (tmp_path / "spring.csv").write_text(f"-1, {stiff}\n0, 0\n1, {-soft}\n")
    (tmp_path / "cart.toml").write_text(CART.replace("{force}", 'table("spring.csv", x)'))
    scene = symdyn.read(tmp_path / "cart.toml")
    period = np.pi / np.sqrt(stiff) + np.pi / np.sqrt(soft)
    run = symdyn.simulate(scene, until=2 * period, every=2 * period, start={"x": 0.1}, rtol=1e-10, method="dop853")
    assert run["x"][-1] == pytest.approx(0.1, abs=1e-8)
    assert np.isfinite(symdyn.sensitivity(scene, until=0.1, start={"x": 0.1}).matrix).all()


@pytest.mark.runs("cc")
@pytest.mark.parametrize(
    ("method", "told"),
    [("gauss", "table bends at its points, which its steps may go past"), ("taylor", "table in the equations branch")],
)
def test_methods_of_high_order_say_that_it_bends(method: Any, told: str, tmp_path: Path) -> None:
    with pytest.raises(SimulateError, match=f"method {method} does not apply: {told}"):
        symdyn.simulate(cart(tmp_path), until=1, method=method)


@pytest.mark.parametrize(
    ("force", "points", "told"),
    [
        ('table("dampr", x)', None, r'table\("dampr", ...\): is no table; did you mean damper'),
        ('table("damper", x, t)', None, r'table\("damper", ...\): takes 1 arguments, here are 2'),
        ('table("none.csv", x)', None, r"none.csv: there is no such file"),
        ('table("../cart.csv", x)', None, r"../cart.csv lies elsewhere; put it into the folder of the scene"),
        ('table("/etc/cart.csv", x)', None, r"/etc/cart.csv lies elsewhere"),
        ('table("cart.toml.csv", x)', None, r"cart.toml.csv: line 2: 'b' is no number"),
        ("table(x)", None, "table takes a name or file in quotes and 1 or 2 arguments"),
        (
            'table("damper", x)',
            "[[0, 1], [0, 2]]",
            r"tables.damper: points: x must ascend; the 2. is 0 behind 0; give them in order",
        ),
        ('table("damper", x)', "[]", "tables.damper: points: has no rows; write"),
        ('table("damper", x)', "[[0, 1]]", "tables.damper: points: has 1 knots of x; give 2 to 200"),
        ('table("damper", x)', "[[0, 1], [1]]", "tables.damper: points: row 2 has other than 2 numbers"),
        ('table("damper", x)', "[[0, 1], [1, true]]", "tables.damper: points: 'True' is no number"),
        ('table("damper", x)', "3", r"tables.damper: points: 3 is no list of rows such as"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path: Path, force: str, points: str | None, told: str) -> None:
    (tmp_path / "cart.toml.csv").write_text("1, 2\na, b\n".replace("a", "2"))
    text = CART.replace("{force}", force)
    if points is not None:
        text = text.replace("[[-1, 30], [-0.2, 20], [0, 0], [0.3, -5], [1, -10]]", points)
    (tmp_path / "cart.toml").write_text(text)
    with pytest.raises(SceneError, match=told) as refused:
        symdyn.read(tmp_path / "cart.toml")
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize("force", ['2*table("none.csv", x) - table("none.csv", 0)', 'table("none.csv", x, t)**2'])
def test_a_file_that_is_no_table_is_told_once(tmp_path: Path, force: str) -> None:
    (tmp_path / "cart.toml").write_text(CART.replace("{force}", force))
    with pytest.raises(SceneError) as refused:
        symdyn.read(tmp_path / "cart.toml")
    assert (
        str(refused.value)
        == f"{tmp_path / 'cart.toml'}:1: {tmp_path / 'none.csv'}: there is no such file; check the path"
    )
