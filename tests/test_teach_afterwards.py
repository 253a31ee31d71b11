"""What lessons say after the equations, against SymPy, against books, and where it may be false."""

from __future__ import annotations

import re
from functools import cache
from math import acos, cos, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from lesson_by_sympy import Tree, at
from lessons import keys_of, lesson_of, step_of
from scipy.special import ellipk

from symdyn import simulate
from symdyn.algebra.numeric import Floats
from symdyn.emit.print.formula_text import text_of
from symdyn.graph import Expr, Op, evaluate, reachable
from symdyn.scene import bind, read, read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.derivations.charts import contours
from symdyn.teach.document import Formula, Matrix, Picture, Step, Words

ROOT = Path(__file__).parent.parent
SCENES = {name: ROOT / f"examples/{name}.toml" for name in ("pendulum", "two_link", "cart_pole", "double_pendulum")}
SCENES |= {name: ROOT / f"tests/data/found/{name}.toml" for name in ("hoop_driven", "elastic_pendulum")}
TOP = """
name = "top"
gravity = [0, 0, "-g"]
[parameters]
m = { value = 1, unit = "kg", positive = true }
l = { value = 0.3, unit = "m", positive = true }
I1 = { value = 0.05, unit = "kg m^2", positive = true }
I3 = { value = 0.02, unit = "kg m^2", positive = true }
g = { value = 9.81, unit = "m/s^2", positive = true }
[bodies.top]
mass = "m"
com = [0, 0, "l"]
inertia = ["I1", "I1", "I3"]
inertia_about = "com"
[joints.point]
type = "spherical"
parent = "ground"
child = "top"
orientation = "zxz"
coordinates = ["phi", "theta", "psi"]
drive = false
start = [0, 0.5, 0]
start_rates = [2, 0, 60]
"""


@cache
def lesson(name: str, language: str = "en") -> Document:
    return lesson_of(read_text(TOP, "top") if name == "top" else read(SCENES[name]), language)


def said(one: Step) -> str:
    parts = [*one.claim.parts, *(part for block in one.blocks if isinstance(block, Words) for part in block.parts)]
    return " ".join(part for part in parts if isinstance(part, str))


def table(one: Step) -> list[list[str]]:
    (values,) = (block for block in one.blocks if isinstance(block, Table))
    return [["".join(str(part) for part in cell.parts) for cell in row] for row in values.rows]


def number(text: str) -> float:
    found = re.search(r"−?[\d.]+(?: · 10\^−?\d+)?", text)
    assert found, text
    return float(found[0].replace("−", "-").replace(" · 10^", "e"))


def value(document: Document, node: Expr, **given: float) -> float:
    symbols = {x: 0.3 + (sum(map(ord, str(x.value))) % 97) / 97 for x in reachable([node]) if x.op is Op.SYMBOL}
    return float(evaluate([node], Floats(), {x: given.get(str(x.value), v) for x, v in symbols.items()})[0])


@pytest.mark.wide("pendulum", "cart_pole", "elastic_pendulum")
@pytest.mark.long
@pytest.mark.parametrize("name", ["pendulum", "two_link", "cart_pole", "double_pendulum", "elastic_pendulum"])
def test_inertia_and_stiffness_at_a_rest_are_second_derivatives_by_sympy(name: str) -> None:
    document = lesson(name)
    tree = Tree(document.scene)
    K, P, n = tree.values["K:"], tree.values["P:"], len(tree.q)
    names = [p.name for p in document.scene.parameters]
    point = {name: 0.3 + (sum(map(ord, name)) % 97) / 97 for name in names}
    seen = 0
    for kind, tag in (("stable", "s"), ("unstable", "u")):
        rows = [row for row in step_of(document, "equilibria").blocks if isinstance(row, Table)]
        head = ["".join(getattr(part, "name", str(part)) for part in cell.parts) for cell in rows[0].columns]
        (row,) = [row for row in rows[0].rows if row[-2].parts == (kind,)][:1]
        place = {q: document.value(cell.parts[0]) for q, cell in zip(head[:-2], row, strict=False)}
        here = dict.fromkeys(map(str, tree.u), 0.0) | dict.fromkeys(map(str, tree.q), 0.4)
        here |= {q: value(document, node) for q, node in place.items()} | point
        for i in range(n):
            for j in range(n):
                for letter, energy, by in (("M", K, tree.u), ("K", P, tree.q)):
                    key = f"near:{tag}:{letter}:{i + 1},{j + 1}"
                    node = document.names[key].node
                    assert node is not None
                    (mine,) = at([sp.diff(energy, by[i], by[j])], here)
                    assert value(document, node, **here) == pytest.approx(mine, abs=1e-9), key
                    seen += 1
    assert seen == 4 * n * n


@pytest.mark.wide(2)
@pytest.mark.parametrize("name", ["pendulum", "two_link", "cart_pole", "double_pendulum", "elastic_pendulum"])
def test_formulas_of_frequencies_are_roots_of_the_determinant(name: str) -> None:
    document, n = lesson(name), len(lesson(name).scene.velocities)
    for tag in "su":
        nodes = {key: one.node for key, one in document.names.items() if key.startswith(f"near:{tag}:") and one.node}
        found = {key: value(document, node) for key, node in nodes.items()}
        A, C = (
            np.array([[found[f"near:{tag}:{letter}:{i + 1},{j + 1}"] for j in range(n)] for i in range(n)])
            for letter in "MK"
        )
        squares = sorted(np.linalg.eigvals(np.linalg.solve(A, C)).real)
        told = [found[key] for key in found if re.fullmatch(rf"near:{tag}:omega:\d", key)]
        for key, b in found.items():
            if key.endswith(":b"):
                d = found[key[:-1] + "d"]
                told += [(b - sqrt(b * b - 4 * d)) / 2, (b + sqrt(b * b - 4 * d)) / 2]
        told += [0.0] * (n - len(told))  # what drifts has no formula
        assert sorted(told) == pytest.approx(squares, rel=1e-7, abs=1e-9)


def test_frequencies_of_books() -> None:
    by_hand = {
        ("pendulum", "near:s:omega:1"): "g/l",
        ("cart_pole", "near:u:omega:1"): "-6*g*(mc + mp)/(l*(4*mc + mp))",
        ("elastic_pendulum", "near:s:omega:1"): "g*k/(m*g + k*l0)",
        ("elastic_pendulum", "near:s:omega:2"): "k/m",
    }
    for (name, key), text in by_hand.items():
        document = lesson(name)
        node = document.names[key].node
        assert node is not None
        values = {str(x): 0.3 + (sum(map(ord, str(x))) % 97) / 97 for x in sp.sympify(text).free_symbols}
        assert value(document, node) == pytest.approx(float(sp.sympify(text).subs(values)))


def test_a_rest_that_springs_hold_is_told_exactly() -> None:
    document = lesson("elastic_pendulum")
    assert {row[-1] for row in table(step_of(document, "equilibria"))} == {"exactly"}


@pytest.mark.wide(2)
@pytest.mark.heavy("hoop_driven")
@pytest.mark.parametrize("name", SCENES)
def test_cyclic_coordinates_are_those_that_sympy_finds(name: str) -> None:
    document = lesson(name)
    tree, led = Tree(document.scene), [joint.motion is not None for joint in document.scene.moving]
    L = tree.values["K:"] - tree.values["P:"]
    led = [one for joint, one in zip(document.scene.moving, led, strict=True) for _ in joint.coordinates]
    points = [{str(x): 0.2 + k * sum(map(ord, str(x))) % 97 / 97 for x in L.free_symbols} for k in (1, 2, 3)]
    slopes = [[abs(at([sp.diff(L, q)], point)[0]) for point in points] for q in tree.q]
    cyclic = [k + 1 for k, slope in enumerate(slopes) if not led[k] and max(slope) < 1e-12]
    assert [int(key[7:]) for key in sorted(keys_of(document)) if key.startswith("cyclic:")] == cyclic
    for k in cyclic:
        node = document.names[f"p:{k}"].node
        assert node is not None
        momentum = sp.diff(L, tree.u[k - 1])
        values = {str(x): 0.3 + (sum(map(ord, str(x))) % 97) / 97 for x in momentum.free_symbols}
        assert value(document, node) == pytest.approx(at([momentum], values)[0])


def test_a_bead_on_a_turning_hoop_rests_where_books_say() -> None:
    document = lesson("hoop_driven")
    one = step_of(document, "steady")
    theta = acos(9.81 / (0.4 * 64))
    rows = table(one)
    assert [number(row[0]) for row in rows] == pytest.approx([-theta, 0, theta, pi], abs=5e-4)
    assert [row[1] for row in rows] == ["stable", "unstable", "stable", "unstable"]
    assert number(rows[2][2]) == pytest.approx(8 * sin(theta), abs=5e-4)
    assert "no generalized momentum" in said(step_of(document, "no momentum"))
    assert "K + P" not in said(step_of(document, "energy"))  # letters are the lesson's
    jacobi = document.names["h:"].node
    assert jacobi is not None
    m, R, J, W, g = (0.3 + (sum(map(ord, x)) % 97) / 97 for x in ("m", "R", "J", "Omega", "g"))
    u, q = 0.7, 0.4
    by_hand = m * R * R * u * u / 2 - m * g * R * cos(q) - m * R * R * W * W * sin(q) ** 2 / 2 - J * W * W / 2
    assert value(document, jacobi, theta=q, theta_dot=u) == pytest.approx(by_hand)


@pytest.mark.long(0)
def test_a_heavy_top_precesses_as_its_momenta_ask() -> None:
    """Goldstein, 5.7: m g l = φ̇ (I₃ (ψ̇ + φ̇ cos θ) - I cos θ φ̇), with I about the point; no rest at the poles."""
    assert {"cyclic:1", "cyclic:3"} <= keys_of(lesson("top"))
    rows = table(step_of(lesson("top"), "steady"))
    assert [row[3] for row in rows] == ["stable", "stable"]
    theta, phi, psi = (number(cell) for cell in rows[1][:3])
    spin = psi + phi * cos(theta)
    weight = phi * (0.02 * spin - (0.05 + 0.09) * phi * cos(theta))
    assert weight == pytest.approx(1 * 9.81 * 0.3, rel=2e-3)


@pytest.mark.slow
@pytest.mark.mends("30.lessons.1.4")
def test_a_gyroscope_that_rests_in_its_frame_stands_at_every_tilt() -> None:
    """∂W/∂β = sin β α̇ (C γ̇ - (A - C) α̇ cos β): three ways to be zero, and a rate is zero, not some 1e-11 rad/s."""
    one = step_of(lesson_of(read(ROOT / "tests/data/found/gimbal.toml")), "steady")
    parts = [part for block in one.blocks if isinstance(block, Words) for part in block.parts]
    words = "".join(part if isinstance(part, str) else text_of(part) for part in parts)
    assert "sin(beta) = 0" in words
    assert "alpha_dot = 0, at every beta" in words
    assert "cos(beta) = C*gamma_dot/((A - C)*alpha_dot)" in words
    for row in table(one):
        beta, alpha, gamma = map(number, row[:3])
        ways = (sin(beta), alpha, 0.008 * gamma - (0.005 - 0.008) * alpha * cos(beta))
        assert min(map(abs, ways)) < 1e-3
        assert alpha == 0 or abs(alpha) > 1e-3


def test_periods_of_a_pendulum_are_elliptic_integrals() -> None:
    for row in table(step_of(lesson("pendulum"), "swings")):
        amplitude, ratio = radians(number(row[0])), number(row[2])
        assert ratio == pytest.approx(2 / pi * ellipk(sin(amplitude / 2) ** 2), abs=6e-4)


@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "double_pendulum", "top"])
def test_all_terms_hold_the_energy_and_a_forgotten_one_does_not(name: str) -> None:
    first, *others = table(step_of(lesson(name), "compare"))
    assert first[1:] == ["0 J", "–"]
    assert others
    assert all(number(row[1]) != 0 and number(row[2]) > 0.01 for row in others)


def test_limits_are_those_of_simpler_mechanisms() -> None:
    one = step_of(lesson("two_link"), "limits")
    rows = table(one)
    assert len(rows) == 3
    assert all(row[-1].strip("–") for row in rows), "limits that say nothing are left out"
    assert "was derived as well" in said(one)


SHAKER = """
name = "shaker"
gravity = "none"
[parameters]
m = { value = 2, unit = "kg" }
k = { value = 0.2, unit = "kN/m" }
c = { value = 3, unit = "N s/m" }
F0 = { value = 5, unit = "N" }
Omega = { value = 7, unit = "rad/s" }
[bodies.block]
mass = "m"
[joints.rail]
type = "prismatic"
parent = "ground"
child = "block"
axis = [1, 0, 0]
coordinate = "x"
drive = false
damping = "c"
force = "F0*cos(Omega*t)"
start = 0.1
[springs.coil]
joint = "rail"
stiffness = "k"
"""
FURUTA = (ROOT / "examples/gallery/furuta.toml").read_text(encoding="utf-8")
COUPLED = (ROOT / "tests/data/found/coupled.toml").read_text(encoding="utf-8")
LIMITS = [
    (FURUTA, "m2, J2", "no mass moves with theta2; the mechanism without pendulum"),
    (FURUTA, "J2", "pendulum is a point mass"),
    (FURUTA, "b1", "without a drive the momentum of theta1 is conserved"),
    (FURUTA, "b2", "only drives, weights and springs act along theta2"),
    (SHAKER, "k", "cyclic: x; the mechanism without the spring coil"),
    (COUPLED, "k", "the mechanism without the spring middle"),
    (
        COUPLED.replace('"k2"', '"k1"'),
        "k1",
        "the mechanism without the spring first, last",
    ),
    (SHAKER.replace('stiffness = "k"', 'stiffness = "k"\npreload = "F0"'), "k", None),
    (SHAKER, "c", "no damping: at resonance the amplitude grows without bound"),
    (SHAKER, "F0", "no force depends on time: free vibration"),
    (SHAKER, "Omega", None),
    (SHAKER.replace('force = "F0*cos(Omega*t)"', ""), "c", "without drives K: + P: is conserved"),
    (SHAKER.replace('damping = "c"', ""), "F0", "no force depends on time: free vibration; without drives K: + P:"),
    (SHAKER.replace('"F0*cos(Omega*t)"', '"F0"'), "F0", None),
]


@pytest.mark.parametrize(("text", "letters", "words"), LIMITS)
def test_a_limit_is_told_of_inertias_friction_and_forces(text: str, letters: str, words: str | None) -> None:
    (values,) = (block for block in step_of(lesson_of(read_text(text)), "limits").blocks if isinstance(block, Table))
    rows = [
        ["".join(x if isinstance(x, str) else text_of(x) for x in cell.parts) for cell in row] for row in values.rows
    ]
    found = {row[0].split("\u00a0")[0]: row[-1] for row in rows}
    assert (letters in found) == bool(words), found
    assert found.get(letters, "").startswith(words or "")


MOVED = FURUTA.replace('start = "pi"', "start = 1").replace('drive = "T"', 'drive = "T"\nstart_rates = [3]')


@pytest.mark.runs("cc")
@pytest.mark.parametrize(("text", "gone"), [(SHAKER, ("c", "F0")), (MOVED, ("b1",)), (MOVED, ("b1", "b2"))])
def test_what_is_conserved_in_a_limit_is_the_same_all_along_a_run(text: str, gone: tuple[str, ...]) -> None:
    """Furuta's momentum is that of Cazzolato and Prime (2011), and half of the friction leaves none of it as it was."""
    for part, stays in ((0.0, True), (0.5, False)):
        scene = read_text(text)
        run = simulate(bind(scene, dict.fromkeys(gone, part)), until=1.0, rtol=1e-9)
        kept = run["kinetic_energy"] + run["potential_energy"]
        if gone == ("b1",):
            p = {one.name: float(one.value.at({}) or 0) for one in scene.parameters if one.value is not None}
            s, c = np.sin(run["theta2"]), np.cos(run["theta2"])
            inertia = (
                p["J1"] + p["m1"] * p["l1"] ** 2 + p["m2"] * p["L1"] ** 2 + (p["J2"] + p["m2"] * p["l2"] ** 2) * s**2
            )
            kept = inertia * run["theta1_dot"] + p["m2"] * p["L1"] * p["l2"] * c * run["theta2_dot"]
        assert (np.ptp(kept) < 1e-6 * np.abs(kept).max()) == stays


def test_a_parameter_that_vanishes_may_stand_in_the_bodies_that_are_left() -> None:
    text = SCENES["two_link"].read_text(encoding="utf-8")
    document = walkthrough(read_text(text.replace('mass = "m2"', 'mass = "m1/2"'), "even"))
    assert "limits" in keys_of(document)


def test_a_name_of_ours_is_none_of_the_scene() -> None:
    document = lesson_of(read(ROOT / "tests/data/found/collide.toml"))
    assert {"near:stable", "landscape", "compare", "limits"} <= keys_of(document)


def test_what_is_driven_otherwise_has_no_steady_motion() -> None:
    text = SCENES["hoop_driven"].read_text(encoding="utf-8").replace("Omega*t", "sin(Omega*t)")
    document = walkthrough(read_text(text, "swinging"))
    assert not {"steady", "phase", "compare"} & keys_of(document)
    assert "equilibria" not in keys_of(document)


@pytest.mark.long
@pytest.mark.parametrize("language", ["en", "sk"])
def test_every_picture_is_a_curve_with_axes_that_can_be_read(language: str) -> None:
    document = lesson("hoop_driven", language)
    shown = next(block for s, block in document.blocks() if s.key == "phase" and isinstance(block, Picture))
    assert "nan" not in shown.svg
    assert shown.svg.count("<path") > 10
    assert ">π/2<" in shown.svg
    assert "\\pdfliteral" in str(next(iter(rendered(document, "latex").values())))


def test_contours_of_a_bowl_are_circles() -> None:
    x = np.linspace(-2, 2, 41)
    z = x[:, None] ** 2 + x[None, :] ** 2
    (line,) = contours(x, x, z, 1.0)
    assert np.hypot(line[:, 0], line[:, 1]) == pytest.approx(1, abs=5e-3)
    assert line[0] == pytest.approx(line[-1])
    assert contours(x, x, z, 99.0) == []


def test_formulas_and_matrices_are_named() -> None:
    for name in SCENES:
        for one, block in lesson(name).blocks():
            if one.key.startswith(("near:", "cyclic", "steady", "energy")) and isinstance(block, (Formula, Matrix)):
                assert block.left in lesson(name).names


@pytest.mark.long
def test_a_governor_opens_as_far_as_its_speed_asks() -> None:
    """By hand, by virtual work of centrifugal forces, weights and spring; s = -2 l cos α, balls at 2 l sin α."""
    from symdyn.teach.derivations.equilibria import closed_sections
    from symdyn.teach.lesson import Prose

    (section,) = closed_sections(Prose(read(ROOT / "examples/governor.toml"), "en"))
    one = next(step for step in section.steps if step.key == "steady")
    found = {row[0]: number(row[1]) for row in table(one)}
    alpha, rate = (next(x for name, x in found.items() if letter in name) for letter in ("alpha", "phi_dot"))
    length, ball, arm, inertia, sleeve, k, s0, g = 0.15, 0.8, 0.1, 8e-4, 1.5, 400, 0.29, 9.80665
    turning = (ball * 4 + arm) * length**2 + inertia  # of an arm with its ball, about the spindle, over sin² α
    outwards = 2 * turning * sin(alpha) * cos(alpha) * rate**2
    weights = 2 * (2 * ball + arm) * g * length * sin(alpha) + sleeve * g * 2 * length * sin(alpha)
    spring = k * (s0 - 2 * length * cos(alpha)) * 2 * length * sin(alpha)
    assert rate == 12
    assert outwards == pytest.approx(weights + spring, rel=2e-3)
    assert "oscillates" in said(one) + str(one.blocks)


@pytest.mark.long
def test_a_closed_lesson_tells_where_it_rests() -> None:
    document = lesson_of(read(ROOT / "examples/four_bar.toml"), formulation="multipliers")
    rows = table(step_of(document, "equilibria"))
    assert [row[-2] for row in rows] == ["oscillates", "oscillates", "unstable", "unstable"]


def test_frequencies_by_formula_are_numbered_as_the_shapes() -> None:
    """k/m, 6.32 rad/s, is the second shape of the elastic pendulum, and the swing, 3.63 rad/s, its first."""
    document = lesson("elastic_pendulum")
    rows = table(step_of(document, "near:stable"))
    squares = [document.names[f"near:s:omega:{number}"].node for number in (1, 2)]
    for row, square in zip(rows, squares, strict=True):
        assert square is not None
        assert f"{sqrt(value(document, square, m=1, k=40, l0=0.5, g=9.81)):.4g} rad/s" in row[1]


@pytest.mark.long(0)
def test_a_mass_whose_centre_is_off_the_axis_has_a_centrifugal_force() -> None:
    """Of angles zyx the third turns the top about x, and its centre of mass lies on y."""
    document = lesson_of(read(ROOT / "tests/data/found/heavy_top_zyx.toml"))
    assert not any("there is no centrifugal force" in row[2] for row in table(step_of(document, "meaning:k_D")))


@pytest.mark.long(0)
def test_what_can_rest_everywhere_has_no_rests_to_list() -> None:
    assert "equilibria" not in keys_of(lesson_of(read(ROOT / "examples/free_body.toml"), formulation="quaternions"))
    upright, *_ = table(
        step_of(lesson_of(read(ROOT / "examples/heavy_top.toml"), formulation="quaternions"), "equilibria")
    )
    assert "3.108" in upright[-1], "sqrt(m g l / I)"


def test_of_bodies_whose_kinetic_energy_is_negative_no_curves_are_told() -> None:
    """An inertia in letters without values is believed, whatever lengths a lesson then takes for them."""
    impossible = """
    name = "rig"
    parameters = { J = { positive = true }, k = 15 }
    bodies.wheel = { mass = 1, inertia = ["-J", "-J", "-J"], inertia_about = "com" }
    joints.j = { type = "revolute", parent = "ground", child = "wheel", axis = [0, 0, 1] }
    springs.coil = { joint = "j", stiffness = "k" }
    """
    told, negative = (
        {step.key for section in walkthrough(read_text(text)).sections for step in section.steps}
        for text in (impossible.replace("-J", "J"), impossible)
    )

    assert {"equilibria", "phase", "swings"} <= told
    assert not negative & {"phase", "swings"}
    assert "equilibria" in negative
