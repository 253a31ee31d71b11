"""Hamilton's, Routh's, Kane's and Appell's equations: against Lagrange's in numbers, and against books."""

import re
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy

import symdyn
from symdyn.algebra import Form
from symdyn.emit.print.formulation_groups import EquationGroup
from symdyn.emit.print.formulations_page import PAGES
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Graph
from symdyn.scene import Quantity, Scene
from symdyn.scene.toml import read_text

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))

import formulations

SPHERICAL = """
name = "spherical"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 0.7, unit = "kg", positive = true }
l = { value = 1.1, unit = "m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.ring]
[bodies.bob]
particles = [{ mass = "m", at = [0, 0, "-l"] }]
[joints.post]
type = "revolute"
parent = "ground"
child = "ring"
axis = [0, 0, 1]
coordinate = "phi"
drive = false
[joints.hinge]
type = "revolute"
parent = "ring"
child = "bob"
axis = [0, 1, 0]
coordinate = "theta"
drive = false
"""

TOP = """
name = "top"
gravity = [0, 0, "-g"]
[parameters]
A = { value = 0.05, unit = "kg m^2", positive = true }
C = { value = 0.03, unit = "kg m^2", positive = true }
m = { value = 0.7, unit = "kg", positive = true }
l = { value = 0.2, unit = "m", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.top]
mass = "m"
com = [0, 0, "l"]
inertia = ["A", "A", "C"]
inertia_about = "frame"
[joints.point]
type = "spherical"
parent = "ground"
child = "top"
orientation = "zxz"
coordinates = ["psi", "theta", "phi"]
drive = false
"""

PLANE = """
name = "plane"
gravity = [0, "-g", 0]
[parameters]
m = { value = 0.7, unit = "kg", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
c = { value = 0.4, unit = "N s/m" }
[bodies.slide]
[bodies.bob]
particles = [{ mass = "m", at = [0, 0, 0] }]
[joints.x]
type = "prismatic"
parent = "ground"
child = "slide"
axis = [1, 0, 0]
coordinate = "x"
drive = false
[joints.y]
type = "prismatic"
parent = "slide"
child = "bob"
axis = [0, 1, 0]
coordinate = "y"
drive = false
start = -1.1
"""

ROD = (
    PLANE
    + """
[constraints.rod]
formula = "x*x_dot + y*y_dot"
acts_in = "joints"
"""
)

ROTOR = SPHERICAL.replace('coordinate = "theta"', 'coordinate = "theta"\narmature = 0.3')


def values_of(scene: Scene, q: list[float], u: list[float], more: dict[str, float]) -> dict[str, float]:
    known = {one.name: float(one.value.at({})) for one in scene.parameters if one.value is not None}
    return known | dict(zip(scene.coordinates, q, strict=True)) | dict(zip(scene.velocities, u, strict=True)) | more


def number(form: Form, values: dict[str, float]) -> float:
    expression = form.to_sympy()
    return float(expression.subs({symbol: values[str(symbol)] for symbol in expression.free_symbols}))


def plain(form: Form) -> sympy.Expr:
    """Return a formula in symbols of which nothing is assumed."""
    found = form.to_sympy()
    return found.subs({symbol: sympy.Symbol(str(symbol)) for symbol in found.free_symbols})


def group(groups: list[EquationGroup], title: str) -> EquationGroup:
    return next(one for one in groups if one.title == title)


@pytest.fixture(params=["two_link", "cart_pole", "gallery/furuta", "TOP", "SPHERICAL", "ROTOR"])
def scene(request: pytest.FixtureRequest) -> Scene:
    if request.param.isupper():
        return read_text(globals()[request.param])
    scene = symdyn.example(request.param.split("/")[-1])
    sized = (one if one.value is not None else replace(one, value=Quantity.number(Fraction(k + 3, 5)))
             for k, one in enumerate(scene.parameters))  # fmt: skip
    return replace(scene, parameters=tuple(sized))


def motion(scene: Scene) -> tuple[list[float], list[float], list[float], list[float]]:
    drawn = np.random.default_rng(4)
    q, u = drawn.uniform(0.3, 1.2, len(scene.coordinates)), drawn.uniform(-1, 1, len(scene.velocities))
    tau = [drawn.uniform(-1, 1) if drive else 0.0 for drive in scene.drives]
    a = symdyn.lambdify(scene, "forward_dynamics")(q, u, tau)
    return q.tolist(), u.tolist(), np.asarray(a).tolist(), tau


def all_values(scene: Scene) -> tuple[dict[str, float], list[float]]:
    q, u, a, tau = motion(scene)
    more = {drive: x for drive, x in zip(scene.drives, tau, strict=True) if drive}
    more |= {f"{name}_ddot": x for name, x in zip(scene.coordinates, a, strict=True)}
    return values_of(scene, q, u, more), a


def test_canonical_equations_are_the_rates_of_momenta(scene: Scene) -> None:
    """ṗ by them is the difference of `momentum` along the motion; q̇ by them is q̇."""
    groups, (values, a) = list(PAGES["hamilton"](scene)), all_values(scene)
    q, u, _, _ = motion(scene)
    momentum, h = symdyn.lambdify(scene, "momentum"), 1e-6
    ahead, behind = (
        momentum(np.add(q, np.multiply(s, u)) + s * s / 2 * np.array(a), np.add(u, np.multiply(s, a))) for s in (h, -h)
    )
    slopes = (ahead - behind) / (2 * h)
    momenta = {row.name: number(row.form, values) for row in group(groups, "Momenta").rows}

    assert np.allclose(list(momenta.values()), momentum(q, u), rtol=1e-12)
    for row in group(groups, "Canonical equations").rows:
        found = number(row.form, values | momenta)
        if row.name in scene.velocities:
            assert found == pytest.approx(values[row.name], rel=1e-10, abs=1e-12)
        else:
            assert found == pytest.approx(slopes[[*momenta].index(row.name.removesuffix("_dot"))], rel=1e-7, abs=1e-8)


@pytest.mark.parametrize("formulation", ["kane", "gibbs-appell"])
def test_the_equations_vanish_along_a_motion(scene: Scene, formulation: str) -> None:
    groups, (values, _) = list(PAGES[formulation](scene)), all_values(scene)

    for row in groups[-1].rows:
        assert number(row.form, values) == pytest.approx(0, abs=1e-10)


def test_shares_of_bodies_add_up_to_the_inertia_forces(scene: Scene) -> None:
    groups, (values, _) = list(PAGES["kane"](scene)), all_values(scene)

    active = [number(row.form, values) for row in group(groups, "Active forces").rows]
    inertia = np.zeros(len(active))
    for row in (row for one in groups for row in one.rows if row.name.endswith("*")):
        inertia[int(row.name[1:-1]) - 1] += number(row.form, values)
    assert np.allclose(np.add(active, inertia), 0, atol=1e-10)


def test_the_spherical_pendulum_is_that_of_goldstein() -> None:
    """H = (p_θ² + p_φ² / sin² θ) / (2 m l²) - m g l cos θ; R holds the amended potential."""
    m, length, g, theta, p1, p2, rate = sympy.symbols("m l g theta p1 p2 theta_dot")
    groups = list(PAGES["hamilton"](read_text(SPHERICAL)))

    H = plain(group(groups, "Hamiltonian").rows[0].form)
    by_book = (p2**2 + p1**2 / sympy.sin(theta) ** 2) / (2 * m * length**2) - m * g * length * sympy.cos(theta)
    assert sympy.simplify(H - by_book) == 0

    R = plain(group(list(PAGES["routh"](read_text(SPHERICAL))), "Routh's function").rows[0].form)
    amended = p1**2 / (2 * m * length**2 * sympy.sin(theta) ** 2) - m * g * length * sympy.cos(theta)
    assert sympy.simplify(R - (m * length**2 * rate**2 / 2 - amended)) == 0


def test_the_transformation_to_cyclic_coordinates_is_that_of_goldstein() -> None:
    """10.3, Hamilton's characteristic function: p_θ² = 2 m l² (E + m g l cos θ) - p_φ²/sin² θ, p_φ and E staying."""
    m, length, g, theta, p1, E = sympy.symbols("m l g theta p1 E")
    (row,) = group(list(PAGES["hamilton"](read_text(SPHERICAL))), "Canonical transformation").rows
    square = 2 * m * length**2 * (E + m * g * length * sympy.cos(theta)) - p1**2 / sympy.sin(theta) ** 2
    assert row.name == "p2**2"
    assert sympy.simplify(plain(row.form) - square) == 0

    top = read_text(TOP)
    groups = list(PAGES["hamilton"](top))
    values = values_of(top, [0.3, 0.8, 1.9], [0.0, 0.0, 0.0], {"p1": 0.01, "p3": 0.02, "E": 2.0})
    (row,), (H,) = (group(groups, title).rows for title in ("Canonical transformation", "Hamiltonian"))
    assert number(H.form, values | {"p2": number(row.form, values) ** 0.5}) == pytest.approx(2.0)
    damped = symdyn.example("pendulum")
    assert "Canonical transformation" not in [one.title for one in PAGES["hamilton"](damped)]


def test_a_top_has_squares_of_sines_below_its_lines() -> None:
    """(cos θ - 1)(cos θ + 1), which factors of polynomials are, is -sin² θ."""
    text = symdyn.emit.print.printed_text(symdyn.example("gyroscope"), "text", formulation="hamilton")

    assert "phi_dot = -4*(-p1 + p3*cos(theta))/((R**2 + 4*s**2)*m*sin(theta)**2)\n" in text
    assert not re.search(r"cos\(theta\) - 1\b", text)


@pytest.mark.parametrize("text", [SPHERICAL, TOP, "gyroscope"])
def test_what_is_left_after_routh_holds_along_a_motion(text: str) -> None:
    scene = symdyn.example(text) if text == "gyroscope" else read_text(text)
    groups, (values, _) = list(PAGES["routh"](scene)), all_values(scene)
    momenta = {row.name: number(row.form, values) for row in group(groups, "Constant momenta").rows}

    for row in group(groups, "Equations that are left").rows:
        assert number(row.form, values | momenta) == pytest.approx(0, abs=1e-10)
    for row in group(groups, "Cyclic velocities").rows:
        assert number(row.form, values | momenta) == pytest.approx(values[row.name], rel=1e-10)


def test_letters_of_the_page_are_none_of_the_scene() -> None:
    """A coordinate H, parameters p and drives p1 and F1 of the scene keep their letters."""
    text = SPHERICAL.replace('"theta"', '"H"').replace("\nm = ", "\np = ").replace('mass = "m"', 'mass = "p"')
    scene = read_text(text.replace("drive = false", 'drive = "p1"', 1).replace("drive = false", 'drive = "F1"'))
    page = {name: symdyn.emit.print.printed_text(scene, formulation=name) for name in ("hamilton", "kane")}
    lines = symdyn.emit.print.printed_text(scene, "text", formulation="hamilton").splitlines()

    assert r"\mathcal{H} &= " in page["hamilton"]
    assert r"\dot P_1 &= p_1" in page["hamilton"]
    assert "mathtt" not in page["hamilton"]
    assert [line.split(" =")[0] for line in lines if " = " in line and line[0] != "#"] == [
        "P1", "P2", "H_cal", "phi_dot", "H_dot", "P1_dot", "P2_dot",
    ]  # fmt: skip
    assert [row.name for row in group(list(PAGES["kane"](scene)), "Active forces").rows] == ["Q1", "Q2"]


def test_the_top_has_two_constant_momenta() -> None:
    assert [row.name for row in group(list(PAGES["routh"](read_text(TOP))), "Constant momenta").rows] == ["p1", "p3"]


def test_udwadia_and_kalabas_pendulum() -> None:
    """Proc. R. Soc. A 439 (1992): Q_c = -m (ẋ² + ẏ² - g y) / (x² + y²) [x, y] of a particle on a rod."""
    m, g, x, y, dx, dy = sympy.symbols("m g x y x_dot y_dot")
    found = [plain(row.form) for row in group(list(PAGES["udwadia-kalaba"](read_text(ROD))), UK).rows]

    size = -m * (dx**2 + dy**2 - g * y) / (x**2 + y**2)
    assert [sympy.simplify(one - size * way) for one, way in zip(found, (x, y), strict=True)] == [0, 0]


UK = "Udwadia and Kalaba's equation"


def test_udwadia_and_kalabas_particle_with_a_row_in_rates() -> None:
    """Analytical Dynamics (1996): ẏ = z² ẋ gives Q_c = 2 m ż z ẋ / (1 + z⁴) [-z², 1, 0]."""
    third = PLANE.replace("[bodies.bob]", "[bodies.post]\n[bodies.bob]").replace('child = "bob"', 'child = "post"')
    third = third.replace('gravity = [0, "-g", 0]', "gravity = [0, 0, 0]") + (
        '[joints.z]\ntype = "prismatic"\nparent = "post"\nchild = "bob"\naxis = [0, 0, 1]\ncoordinate = "z"\n'
        'drive = false\n[constraints.row]\nformula = "y_dot - z**2*x_dot/m2"\nacts_in = "joints"\n'
    )
    scene = read_text(third.replace("[parameters]", '[parameters]\nm2 = { value = 1, unit = "m^2" }'))
    rows = group(list(PAGES["udwadia-kalaba"](scene)), UK).rows

    values = {"m": 0.7, "m2": 1.0, "z": 0.6, "z_dot": -0.8, "x_dot": 1.3, "y_dot": 0.36 * 1.3, "x": 0.0, "y": 0.0}
    size = 2 * 0.7 * -0.8 * 0.6 * 1.3 / (1 + 0.6**4)
    assert {row.name: number(row.form, values) for row in rows} == pytest.approx({"Q_c1": -0.36 * size, "Q_c2": size})


@pytest.mark.long
def test_the_forces_of_a_four_bar_are_those_of_least_norm_of_all_its_rows() -> None:
    """By NumPy's pseudo-inverse of the rows that are printed, and with two more that depend on them."""
    scene = symdyn.example("four_bar")
    sized = (one if one.value else replace(one, value=Quantity.number(Fraction(k + 4, 5)))
             for k, one in enumerate(scene.parameters))  # fmt: skip
    scene = replace(scene, parameters=tuple(sized))
    w = symdyn.dynamics.Workspace(scene)
    q = np.asarray(w.loops.decisions.assembly.q, float)
    tau = [0.3, 0.0, 0.0]
    u = np.asarray(symdyn.lambdify(scene, "velocities")(q, [0.7]), float)
    at = values_of(scene, q.tolist(), u.tolist(), {drive: 0.3 for drive in scene.drives if drive})
    rows = {row.name: number(row.form, at) for one in PAGES["udwadia-kalaba"](scene) for row in one.rows}
    forward = symdyn.lambdify(scene, "forward_dynamics")(q, u, tau)
    M = np.array([[rows.get(f"M_cal{min(i, j)}{max(i, j)}", 0) for j in (1, 2, 3)] for i in (1, 2, 3)])
    Q, b = np.array([rows.get(f"Q{i}", 0) for i in (1, 2, 3)]), np.array([rows.get(f"b_cal{k}", 0) for k in (1, 2)])
    A = np.array([[rows.get(f"A{k}{j}", 0) for j in (1, 2, 3)] for k in (1, 2)])

    def added(A: np.ndarray, b: np.ndarray) -> np.ndarray:
        free = np.linalg.solve(M, Q)
        return np.asarray(A.T @ np.linalg.pinv(A @ np.linalg.solve(M, A.T)) @ (b - A @ free))

    assert np.linalg.solve(M, Q + added(A, b)) == pytest.approx(forward, rel=1e-9)
    twice = np.vstack([A, A[0] + A[1], 2 * A[1]]), np.concatenate([b, [b[0] + b[1], 2 * b[1]]])
    assert added(*twice) == pytest.approx(added(A, b), rel=1e-9)
    assert symdyn.lambdify(scene, "constraint_forces")(q, u, tau) == pytest.approx(added(A, b), rel=1e-9)


@pytest.mark.long
def test_the_power_of_port_hamiltonian_equations_is_the_rate_of_energy(scene: Scene) -> None:
    groups, (values, a) = list(PAGES["port-hamiltonian"](scene)), all_values(scene)
    q, u, _, _ = motion(scene)
    energies, h = symdyn.lambdify(scene, ("kinetic_energy", "potential_energy")), 1e-5
    ahead, behind = (
        sum(float(one(*[np.add(q, np.multiply(s, u)) + s * s / 2 * np.array(a), np.add(u, np.multiply(s, a))][:k]))
            for one, k in zip(energies, (2, 1), strict=True)) for s in (h, -h)
    )  # fmt: skip
    (power,) = group(groups, "Power").rows

    assert number(power.form, values) == pytest.approx((ahead - behind) / (2 * h), rel=1e-6, abs=1e-7)


def test_what_turns_stands_in_j_what_brakes_in_r_and_the_rest_in_f() -> None:
    """Forces c ẏ and -c ẋ, as of a charge, do no work; dry friction is no matrix times velocities."""
    turned = PLANE.replace('coordinate = "x"', 'coordinate = "x"\nforce = "c*y_dot"\ndamping = 0.2')
    scene = read_text(turned.replace('coordinate = "y"', 'coordinate = "y"\nforce = "-c*x_dot"'))
    rows = {
        row.name: str(row.form.to_sympy()) for row in group(list(PAGES["port-hamiltonian"](scene)), "Structure").rows
    }

    assert rows == {"R11": "1/5", "J12": "c"}
    rubbed = turned.replace("damping = 0.2", "friction = { coulomb = 0.3, smoothing = 0.1 }")
    (row,) = group(list(PAGES["port-hamiltonian"](read_text(rubbed))), "Structure").rows
    assert row.name == "F1"


@pytest.mark.parametrize(
    ("name", "formulation", "message"),
    [
        ("two_link", "udwadia-kalaba", "two_link: Udwadia and Kalaba's equation is about constraints, and no loop"),
        ("four_bar", "port-hamiltonian", "four_bar: Hamilton's equations are written in independent coordinates"),
        ("four_bar", "hamilton", "four_bar: Hamilton's equations are written in independent coordinates"),
        ("four_bar", "kane", "four_bar: Kane's equations are written in independent coordinates"),
        ("cart_pole", "routh", "cart_pole: Routh's equations do not exist: no coordinate is cyclic"),
        ("heavy_top", "routh", "heavy_top: Routh's equations do not exist: no coordinate is cyclic"),
    ],
)
def test_a_scene_without_a_formulation_says_why(name: str, formulation: str, message: str) -> None:
    with pytest.raises(DerivationError, match=message):
        symdyn.emit.print.printed_text(symdyn.example(name), formulation=formulation)


# test_contact_page.py and test_arm_page.py have the others
@pytest.mark.parametrize("formulation", sorted(PAGES.keys() - {"contact", "inverse-kinematics"}))
def test_pages_are_text_latex_and_a_document(formulation: str) -> None:
    scene = read_text(ROD if formulation == "udwadia-kalaba" else SPHERICAL)
    printed = symdyn.emit.print.printed_text

    assert printed(scene, "text", formulation=formulation).startswith("# ")
    assert r"\paragraph{" in printed(scene, formulation=formulation)
    assert r"\begin{document}" in printed(scene, document=True, formulation=formulation)
    with pytest.raises(EmitError, match=f"{formulation}: a document is written in LaTeX, not as sympy"):
        printed(scene, "sympy", document=True, formulation=formulation)


@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        ("SPHERICAL", "hamilton"),
        ("SPHERICAL", "routh"),
        ("ROTOR", "kane"),
        ("heavy_top", "hamilton"),
        ("heavy_top", "gibbs-appell"),
        ("ROD", "udwadia-kalaba"),
        ("PLANE", "port-hamiltonian"),
    ],
)
def test_pages_are_programs_of_sympy_that_hold_the_same(name: str, formulation: str) -> None:
    """Run as a user does; squares of momenta, F* and what is zero on the left included."""
    one = read_text(globals()[name]) if name.isupper() else symdyn.example(name)
    rows = [row for some in PAGES[formulation](one) for row in some.rows]
    found: dict[str, object] = {}
    exec(symdyn.emit.print.printed_text(one, "sympy", formulation=formulation), vars(sympy) | {}, found)
    said = [x for key, x in found.items() if re.fullmatch(r"[a-z_]+\d+", key) and not isinstance(x, sympy.Symbol)]

    for equation, row in zip(said, rows, strict=False):
        form = plain(row.form)
        if not isinstance(equation, sympy.Eq):  # SymPy knows that it is true
            assert equation == sympy.true
            continue
        assert str(equation.lhs).replace("_star", "*") == row.name
        right = equation.rhs.subs({x: sympy.Symbol(str(x)) for x in equation.free_symbols})
        assert sympy.simplify(right - form) == 0
    assert len(said) >= len(rows)


@pytest.mark.long
@pytest.mark.parametrize("name", ["two_link", "gyroscope", "four_bar"])
def test_the_page_of_counts_says_what_pages_take(name: str) -> None:
    """Operations and characters; milliseconds are those of one machine."""
    heads, row = (
        [cell.strip() for cell in line.strip("| \n").split("|")]
        for line in (formulations.ROOT / "docs" / "formulations.md").read_text("utf8").splitlines()
        if line.startswith(("| example", f"| {name} ".replace("_", r"\_")))
    )
    for formulation, cell in zip(heads[1:], row[1:], strict=True):
        found = formulations.measured(symdyn.example(name), formulation)
        told = cell.split(" / ")[:2]
        assert [str(found.operations), str(found.characters)] == told or (found.fault and len(told) == 1), formulation


@pytest.mark.parametrize("name", [pytest.param("half_car", marks=pytest.mark.long), "rocket"])
def test_power_holds_what_energy_itself_changes_by(name: str) -> None:
    """Supports that move, a mass that burns: dH/dt of H(t, q, p) along its own canonical equations, by differences."""
    scene = symdyn.example(name)
    groups, rng = list(PAGES["port-hamiltonian"](scene)), np.random.default_rng(5)
    given = [*(one.name for one in scene.inputs), *(one.name for one in scene.states)]
    q, u, more = (rng.uniform(0.3, 0.6, len(some)).tolist() for some in (scene.coordinates, scene.velocities, given))
    values = values_of(scene, q, u, dict(zip(given, more, strict=True)))
    values |= {row.name: number(row.form, values) for row in group(groups, "Momenta").rows}
    rates = {row.name: number(row.form, values) for row in group(groups, "Canonical equations").rows}
    rates |= {f"{one.name}_dot": number(Form.of(one.rate.express(Graph())), values) for one in scene.states}
    rates |= {f"{one}_dot": values[rate] for one, rate in scene.rates.items() if rate in values}
    moved = [one for one in values if f"{one}_dot" in rates or one in scene.velocities]
    (H,), (power,), h = group(groups, "Hamiltonian").rows, group(groups, "Power").rows, 3e-8
    ahead, behind = (
        number(H.form, values | {one: values[one] + s * rates.get(f"{one}_dot", 0.0) for one in moved}) for s in (h, -h)
    )

    assert number(power.form, values) == pytest.approx((ahead - behind) / (2 * h), rel=1e-5)


CRANK = """
name = "crank"
gravity = [0, 0, 0]
[parameters]
mA = { unit = "kg", positive = true }
mB = { unit = "kg", positive = true }
mC = { unit = "kg", positive = true }
kA = { unit = "m", positive = true }
kB = { unit = "m", positive = true }
a = { unit = "m", positive = true }
b = { unit = "m", positive = true }
[bodies.A]
mass = "mA"
com = [0, 0, "-a"]
inertia = ["mA*kA**2", "mA*kA**2", 0]
inertia_about = "com"
[bodies.C]
mass = "mC"
com = [0, 0, 0]
[bodies.B]
mass = "mB"
com = [0, 0, "-b"]
inertia = ["mB*kB**2", "mB*kB**2", 0]
inertia_about = "com"
[joints.shaft]
type = "revolute"
parent = "ground"
child = "A"
axis = [0, 1, 0]
coordinate = "q1"
[joints.bore]
type = "prismatic"
parent = "ground"
child = "C"
axis = [0, 0, 1]
coordinate = "z"
[joints.pin]
type = "revolute"
parent = "C"
child = "B"
axis = [0, -1, 0]
coordinate = "q2"
"""


def test_the_crank_rod_and_piston_of_kane() -> None:
    """Kane and Levinson (1985), exercise 11.10: F_r* of q̇_1, -q̇_2 and ż, the rod on the piston alone."""
    rows = group(list(PAGES["kane"](read_text(CRANK))), "Kane's equations").rows
    mA, mB, mC, kA, kB, a, b, q2, w2 = sympy.symbols("mA mB mC kA kB a b q2 q2_dot")
    du1, du3, dw2 = sympy.symbols("q1_ddot z_ddot q2_ddot")
    tau1, tau2, tau3 = sympy.symbols("tau1 tau2 tau3")
    du2, sin, cos = -dw2, sympy.sin(q2), sympy.cos(q2)
    first = -mA * (a**2 + kA**2) * du1
    second = -mB * ((b**2 + kB**2) * du2 - b * sin * du3)
    third = -((mB + mC) * du3 - mB * b * sin * du2 + mB * b * cos * w2**2)

    by_book = (tau1 + first, tau2 + third, tau3 - second)
    assert [sympy.simplify(plain(row.form) - one) for row, one in zip(rows, by_book, strict=True)] == [0, 0, 0]
