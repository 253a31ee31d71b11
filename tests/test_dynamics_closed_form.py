"""Closed forms: the textbook's formulas to the letter, the energies of the graph exactly, within the promised time."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from calls import counted

from symdyn.algebra.numeric import Floats
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics.closed_forms.closed_form import ClosedForm, closed_form
from symdyn.dynamics.mechanism.lagrange import Energies
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene, body, parse, read, revolute, scene, with_symbolic_inertia
from symdyn.scene.toml import read_text

EXAMPLES = Path(__file__).parent.parent / "examples"
SMALL = ["pendulum", "two_link", "cart_pole", "double_pendulum", "scara"]


def example(name: str) -> Scene:
    return read(str(EXAMPLES / f"{name}.toml"))


@pytest.fixture(scope="module")
def two_link() -> ClosedForm:
    return closed_form(example("two_link"))


TEXTBOOK = {
    "(5.45)": (("k_z", 0, 0), "(m1 + m2)*h1**2 + m2*h2**2 + 2*m2*h1*h2*cos(q2)"),
    "(5.51)": (("k_z", 0, 1), "m2*h2**2 + m2*h1*h2*cos(q2)"),
    "(5.54)": (("k_z", 1, 0), "m2*h2**2 + m2*h1*h2*cos(q2)"),
    "(5.49)": (("k_z", 1, 1), "m2*h2**2"),
    "(5.40) k_C1": (("k_C", 0, 0), "-2*m2*h1*h2*sin(q2)"),
    "(5.44) k_C2": (("k_C", 1, 0), "0"),
    "(5.55) k_D11": (("k_D", 0, 0), "0"),
    "(5.40) k_D12": (("k_D", 0, 1), "-m2*h1*h2*sin(q2)"),
    "(5.44) k_D21": (("k_D", 1, 0), "m2*h1*h2*sin(q2)"),
    "(5.44) k_D22": (("k_D", 1, 1), "0"),
    "(5.40) k_G1": (("k_G", 0), "(m1 + m2)*g*h1*sin(q1) + m2*g*h2*sin(q1 + q2)"),
    "(5.44) k_G2": (("k_G", 1), "m2*g*h2*sin(q1 + q2)"),
    "(5.34)": (("P",), "-g*h1*(m1 + m2)*cos(q1) - m2*g*h2*cos(q1 + q2)"),
}


@pytest.mark.parametrize("equation", TEXTBOOK)
def test_the_two_link_arm_reads_as_in_the_textbook(equation: str, two_link: ClosedForm) -> None:
    import sympy

    key, text = TEXTBOOK[equation]
    positive = {name: sympy.Symbol(name, positive=True) for name in ("m1", "m2", "h1", "h2", "g")}
    real = {name: sympy.Symbol(name, real=True) for name in ("q1", "q2")}

    assert two_link.sympy(*key) == sympy.sympify(text, {**positive, **real})  # the same form, not only the same value


@pytest.mark.parametrize("name", [*SMALL, "puma560"])
def test_energies_equal_those_of_the_graph_exactly(name: str) -> None:
    scene, graph = example(name), Graph()
    closed, energy = closed_form(scene), Energies.of(scene, graph)
    nodes = [energy.K, energy.P, closed.form("K").express(graph), closed.form("P").express(graph)]
    ring = TrigonometricRing(nodes, (*energy.state.q, *energy.state.qd))
    K, P, printed_K, printed_P = evaluate(nodes, ring, ring.values(nodes))

    assert ring.is_zero(K - printed_K)
    assert ring.is_zero(P - printed_P)


def float_values(nodes: list[Expr]) -> list[float]:
    """Return the values of nodes at a state that depends on the names of their symbols only."""
    names = sorted({str(x.value) for x in reachable(nodes) if x.op is Op.SYMBOL})
    numbers = {name: 0.3 + 0.37 * k for k, name in enumerate(names)}
    values = {x: numbers[str(x.value)] for x in reachable(nodes) if x.op is Op.SYMBOL}
    return evaluate(nodes, Floats(), values)


def coefficients_of_the_graph(scene: Scene, graph: Graph) -> dict[tuple[object, ...], Expr]:
    energy = Energies.of(scene, graph)
    M, n = energy.mass_matrix(), energy.state.n
    symbols = energy.directions.christoffel(M)
    k_C, k_D, k_G = symbols.coriolis(), symbols.centrifugal(), energy.gravity_forces()
    found: dict[tuple[object, ...], Expr] = {("k_z", i, j): M[i][j] for i in range(n) for j in range(n)}
    pairs = range(len(list(combinations(range(n), 2))))
    found.update({("k_C", i, pair): k_C[i][pair] for i in range(n) for pair in pairs})
    found.update({("k_D", i, j): k_D[i][j] for i in range(n) for j in range(n)})
    found.update({("k_G", i): k_G[i] for i in range(n)})
    return found


@pytest.mark.parametrize("name", [*SMALL, "puma560"])
def test_every_coefficient_has_the_value_of_the_graph(name: str) -> None:
    scene, graph = example(name), Graph()
    closed, expected = closed_form(scene), coefficients_of_the_graph(scene, graph)
    keys = closed.coefficient_names()
    values = float_values([expected[key] for key in keys] + [closed.form(*key).express(graph) for key in keys])

    assert set(keys) == set(expected)
    assert values[len(keys) :] == pytest.approx(values[: len(keys)], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", [*SMALL, "puma560"])
def test_a_compact_form_equals_the_normal_form_in_the_ring(name: str) -> None:
    closed = closed_form(example(name))
    graph, ring = closed.state.q[0].graph, closed.ring
    for key in closed.coefficient_names():
        node = closed.form(*key).express(graph)
        assert ring.is_zero(evaluate([node], ring, ring.values([node]))[0] - closed[key]), key


def tilted(*tilts: str) -> Scene:
    """Return an arm of heavy bodies whose joint frames are tilted by roll, pitch, yaw, as in a robot file."""
    lines = ["gravity = [0, 0, '-g']", "[parameters]", "g = { value = 9.81 }"]
    for i, rpy in enumerate(tilts, 1):
        lines += [f"[bodies.b{i}]", "mass = 1.3", "com = [0.1, 0.2, 0.3]", "inertia_about = 'com'"]
        lines += ["inertia = { xx = 0.1, yy = 0.2, zz = 0.25, xy = 0.01, xz = 0.02, yz = 0.03 }"]
        lines += [f"[joints.j{i}]", "type = 'revolute'", f"child = 'b{i}'", f"coordinate = 'q{i}'", "axis = [0, 0, 1]"]
        lines += [
            f"parent = '{f'b{i - 1}' if i > 1 else 'ground'}'",
            f"origin = {{ xyz = [0.1, 0, 0.4], rpy = {rpy} }}",
        ]
    return read_text("name = 'tilted'\n" + "\n".join(lines), "tilted.toml")


TILTS = {
    "1 degree": ["['1 deg', 0, 0]"],
    "12.5 and 33 degrees": ["['12.5 deg', '33 deg', 0]"],
    "12.5 degrees, then 33": ["['12.5 deg', 0, 0]", "['33 deg', 0, 0]"],
    "12.345 degrees": ["['12.345 deg', 0, 0]", "['89.95 deg', 0, 0]"],
    "degrees in a formula": ["[0.5, 'deg(0.123456)', 0]"],
    "three radians": ["[0.3, 0.123456789, 0.7853981634]"],
    "radians of 16 digits": ["[0.1234567890123456, 1.234567890123457, -0.987654321098765]"] * 2,
    "sevenths and eighths of a turn": ["['2*pi/7', 'pi/8', 0]", "['5*pi/8', 0.2, 0]"],
}


@pytest.mark.long
@pytest.mark.parametrize("name", TILTS)
def test_odd_constant_angles_print_short_and_exact_to_the_last_digits(name: str) -> None:
    scene, graph = tilted(*TILTS[name]), Graph()
    with counted() as calls:
        closed = closed_form(scene)
        keys = closed.coefficient_names()
        texts = [text_of(closed.form(*key)) for key in keys]
        expected = coefficients_of_the_graph(scene, graph)
        values = float_values([*(expected[key] for key in keys), *(parse(text).express(graph) for text in texts)])

    assert calls.number < 1_000_000
    assert values[len(keys) :] == pytest.approx(values[: len(keys)], rel=1e-12, abs=1e-14)
    assert sum(map(len, texts)) < 8000


def test_one_degree_reads_as_one_degree() -> None:
    closed = closed_form(tilted("['1 deg', 0, 0]"))

    assert text_of(closed.form("k_G", 0)) == "0.13*g*(cos(q1) - 2*sin(q1))*sin(pi/180)"
    assert str(closed.sympy("k_G", 0)) == "13*g*(-2*sin(q1) + cos(q1))*sin(pi/180)/100"


def test_equal_odd_tilts_forth_and_back_are_parallel_axes() -> None:
    scene = tilted("['7 deg', 0, 0]", "['12.5 deg', 0.3, 0]", "['-12.5 deg', 0, 0]", "[0, -0.3, 0]")
    first, *middle, last = scene.joints
    welds = [replace(joint, type="fixed", coordinates=()) for joint in middle]

    closed = closed_form(replace(scene, joints=(first, *welds, last)))

    assert [[str(q) for q in group.atoms] for group in closed.parallel] == [["q1", "q4"]]


@pytest.mark.long
def test_many_odd_angles_are_refused_in_time_with_the_way_out() -> None:
    with (
        counted() as calls,
        pytest.raises(DerivationError, match=r"closed form .*too long .* symdyn generate writes NumPy and C code"),
    ):
        closed_form(tilted(*(f"[0.3{k}, 0.7{k}, 0.9{k}]" for k in range(6))))

    assert calls.number < 1_000_000


def test_a_chain_of_sixty_is_refused_at_once() -> None:
    scene = chain(60)
    with (
        counted() as calls,
        pytest.raises(DerivationError, match=r"k_C alone has 106200 entries, and 100000 is the limit"),
    ):
        closed_form(scene)

    assert calls.number < 1_000


@pytest.mark.parametrize(
    "key",
    [("k_q", 0), ("k_z", 0, 5), ("k_z",), ("k_z", -1, -1), ("k_C", 0, 1), ("k_G", 0, 0), ("K", 0), (), ("k_z", 0.0, 1)],
    ids=str,
)
def test_a_coefficient_that_does_not_exist_is_an_error_that_lists_those_that_do(
    key: tuple[object, ...], two_link: ClosedForm
) -> None:
    for ask in (two_link.sympy, two_link.form):
        with pytest.raises(
            DerivationError, match=r"no coefficient .* give \('k_z', i, j\), .* i and j in 0\.\.1 and pair in"
        ):
            ask(*key)


@pytest.mark.parametrize(("angle", "shown"), [("pi/10", "pi/10"), ("3/10", "0.3"), ("1", "1")])
def test_an_axis_given_by_an_angle_leaves_no_root(angle: str, shown: str) -> None:
    """sqrt(sin(pi/10)**2 + cos(pi/10)**2) is one, whatever the angle."""
    axis = [f"cos({angle})", 0, f"sin({angle})"]
    tilted = scene(
        "tilted",
        bodies=[body("link", mass=2, com=[1, 0, 0])],
        joints=[revolute("j", "ground", "link", axis=axis)],
    )
    form = closed_form(tilted).form("k_z", 0, 0)
    assert text_of(form) == f"2*sin({shown})**2"


def test_parallel_axes_are_found_through_prismatic_joints() -> None:
    groups = {name: [[str(q) for q in group.atoms] for group in closed_form(example(name)).parallel] for name in SMALL}

    assert groups["two_link"] == [["q1", "q2"]]
    assert groups["scara"] == [["q1", "q2", "q4"]]
    assert groups["cart_pole"] == []


def test_opposed_axes_print_differences() -> None:
    scene = example("two_link")
    shoulder, elbow = scene.joints
    turned = elbow.shaped(axis=(Quantity.number(0), Quantity.number(0), Quantity.number(-1)))

    assert str(closed_form(replace(scene, joints=(shoulder, turned))).sympy("k_G", 1)) == "-g*h2*m2*sin(q1 - q2)"


def test_a_puma_shows_the_sum_of_its_parallel_axes() -> None:
    gravity = str(closed_form(example("puma560")).sympy("k_G", 2))

    assert "q2 + q3" in gravity
    assert "q1" not in gravity


def test_energy_is_linear_in_the_inertial_parameters() -> None:
    scene = with_symbolic_inertia(example("puma560"))
    closed = closed_form(scene)
    names = {parameter.name for parameter in scene.parameters}
    inertial = {i for i, g in enumerate(closed.ring.generators) if g.kind == "symbol" and str(g.node) in names}
    powers = [sum(power for i, power in monomial if i in inertial) for monomial, _ in closed.ring.terms(closed.K)]

    assert set(powers) == {1}
    assert len(powers) > 1000


def test_without_gravity_there_are_no_gravity_terms() -> None:
    closed = closed_form(example("two_link").with_gravity((Quantity.number(0), Quantity.number(0), Quantity.number(0))))

    assert all(closed.ring.is_zero(k) for k in closed.k_G)
    assert not closed.ring.is_zero(closed.M[0][0])


def chain(n: int, turned: int = -1) -> Scene:
    """Return n point masses in a row on parallel axes; the axis of joint `turned` points the other way."""
    scene = example("two_link")
    shoulder, elbow = scene.joints
    joints, bodies = [], []
    for i in range(n):
        joint = replace(elbow, name=f"j{i}", child=f"b{i}", coordinates=(f"q{i}",), drives=(None,))
        joint = (
            replace(joint, parent=f"b{i - 1}") if i else replace(joint, parent=shoulder.parent, origin=shoulder.origin)
        )
        up = -1 if i == turned else 1
        joints.append(joint.shaped(axis=(Quantity.number(0), Quantity.number(0), Quantity.number(up))))
        bodies.append(replace(scene.bodies[0], name=f"b{i}"))
    return replace(scene, bodies=tuple(bodies), joints=tuple(joints), points=())


@pytest.mark.parametrize("turned", [-1, 2])
def test_a_long_chain_has_few_terms_and_the_values_of_the_graph(turned: int) -> None:
    scene, graph = chain(5, turned), Graph()
    closed, expected = closed_form(scene), coefficients_of_the_graph(scene, graph)
    keys = closed.coefficient_names()
    values = float_values([expected[key] for key in keys] + [closed.form(*key).express(graph) for key in keys])

    assert values[len(keys) :] == pytest.approx(values[: len(keys)], rel=1e-9, abs=1e-9)
    assert len(closed["k_G", 4]) == 1


def test_a_chain_of_twelve_prints_sums_of_angles() -> None:
    closed = closed_form(chain(12))

    assert len(closed.K) < 10_000
    assert str(closed.sympy("k_D", 10, 11)) == "-h1**2*m1*sin(q11)"
    assert str(closed.sympy("k_G", 11)).startswith("g*h1*m1*sin(q0 + q1")
