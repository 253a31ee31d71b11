"""Lessons with multipliers: loops and rolling, each formula held against a derivation in SymPy that shares nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
import sympy as sp
from lessons import floats, lesson_of, value_of_symbol

from symdyn.algebra import Form
from symdyn.cli import main
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene import Scene, read, read_text
from symdyn.simulation import simulate
from symdyn.table import Table
from symdyn.teach import Document, walkthrough
from symdyn.teach.document import Braced, Formula, Matrix

EXAMPLES = Path(__file__).parent.parent / "examples"
DISC = (EXAMPLES / "rolling_disc.toml").read_text(encoding="utf-8")
for old, new in (
    ('"e0", "e1", "e2", "e3"]', '"a", "b", "c"]\norientation = "zxy"'),
    ('"cos(pi/24)", "sin(pi/24)", 0, 0]', '0.3, "pi/12", 0.2]'),
    ("start_rates", "# "),
):
    DISC = DISC.replace(old, new)


def scene(name: str) -> Scene:
    return read_text(DISC, "disc.toml") if name == "disc" else read(EXAMPLES / f"{name}.toml")


@cache
def lesson(name: str, language: str = "en") -> Document:
    return lesson_of(scene(name), language, formulation="multipliers")


# By hand


@dataclass(frozen=True)
class ByHand:
    """A mechanism as a person would write it in SymPy: energies, conditions on positions, slips, other forces."""

    q: tuple[sp.Symbol, ...]
    K: sp.Expr
    P: sp.Expr
    held: tuple[sp.Expr, ...]
    slips: tuple[sp.Expr, ...] = ()


def rates(q: tuple[sp.Symbol, ...]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(f"{x}_dot") for x in q)


def rate(node: sp.Expr, q: tuple[sp.Symbol, ...]) -> sp.Expr:
    u = rates(q)
    a = [sp.Symbol(f"{x}_ddot") for x in q]
    return sum((sp.diff(node, x) * y for x, y in zip((*q, *u), (*u, *a), strict=True)), sp.S.Zero)


def slider_crank() -> ByHand:
    phi, psi, x, r, l, m2, m3, J1, g = q = sp.symbols("phi psi x r l m2 m3 J1 g")  # noqa: E741
    q = q[:3]
    centre = sp.Matrix([r * sp.cos(phi) + l / 2 * sp.cos(phi + psi), r * sp.sin(phi) + l / 2 * sp.sin(phi + psi)])
    v = centre.applyfunc(lambda one: rate(one, q))
    w = rate(phi + psi, q)
    K = J1 * rate(phi, q) ** 2 / 2 + m2 * v.dot(v) / 2 + m2 * l**2 / 24 * w**2 + m3 * rate(x, q) ** 2 / 2
    end = x - r * sp.cos(phi) - l * sp.cos(phi + psi), -r * sp.sin(phi) - l * sp.sin(phi + psi)
    return ByHand(q, K, m2 * g * centre[1], end)


def four_bar() -> ByHand:
    phi, psi, chi, a, b, c, d, m1, m2, m3, g = symbols = sp.symbols("phi psi chi a b c d m1 m2 m3 g")
    q = symbols[:3]
    elbow = sp.Matrix([a * sp.cos(phi), a * sp.sin(phi)])
    coupler = elbow + b / 2 * sp.Matrix([sp.cos(phi + psi), sp.sin(phi + psi)])
    v = coupler.applyfunc(lambda one: rate(one, q))
    K = m1 * a**2 / 6 * rate(phi, q) ** 2 + m2 * v.dot(v) / 2 + m2 * b**2 / 24 * rate(phi + psi, q) ** 2
    K += m3 * c**2 / 6 * rate(chi, q) ** 2
    P = g * (m1 * elbow[1] / 2 + m2 * coupler[1] + m3 * c / 2 * sp.sin(chi))
    end = elbow + b * sp.Matrix([sp.cos(phi + psi), sp.sin(phi + psi)])
    return ByHand(q, K, P, (d + c * sp.cos(chi) - end[0], c * sp.sin(chi) - end[1]))


def disc() -> ByHand:
    symbols = sp.symbols("x y z a b c m r")
    z, a, b, c, m, r = symbols[2:]
    q = symbols[:6]
    lean = sp.rot_ccw_axis3(a) * sp.rot_ccw_axis1(b)  # the frame that does not roll with the disc
    w = sp.Matrix([rate(b, q), rate(c, q) + rate(a, q) * sp.sin(b), rate(a, q) * sp.cos(b)])
    v = sp.Matrix([rate(one, q) for one in q[:3]])
    K = m * v.dot(v) / 2 + m * r**2 / 8 * (w[0] ** 2 + 2 * w[1] ** 2 + w[2] ** 2)
    lowest = r * sp.Matrix([-sp.sin(a) * sp.sin(b), sp.cos(a) * sp.sin(b), -sp.cos(b)])  # in the plane of the disc
    slip = v + (lean * w).cross(lowest)
    along, across = sp.Matrix([sp.cos(a), sp.sin(a), 0]), sp.Matrix([-sp.sin(a), sp.cos(a), 0])
    return ByHand(q, K, m * sp.Float("9.81", 20) * z, (z - r * sp.cos(b),), (slip.dot(along), slip.dot(across)))


HANDS: dict[str, Callable[[], ByHand]] = {"slider_crank": slider_crank, "four_bar": four_bar, "disc": disc}


def worth(node: Expr | None) -> float:
    assert node is not None
    return floats([node])[0]


def by_hand(node: sp.Expr) -> float:
    return float(node.subs({x: value_of_symbol(str(x)) for x in node.free_symbols}).evalf())


@pytest.mark.heavy("disc")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", HANDS)
def test_energies_conditions_and_equations_are_what_is_derived_by_hand(name: str) -> None:
    document, hand = lesson(name), HANDS[name]()
    names, L, u = document.names, hand.K - hand.P, rates(hand.q)
    assert worth(names["K:"].node) == pytest.approx(by_hand(hand.K))
    assert worth(names["P:"].node) == pytest.approx(by_hand(hand.P))
    conditions = {f"f:{k}": f for k, f in enumerate(hand.held, len(hand.slips) + 1)}
    along = {f"df:{k}": rate(f, hand.q) for k, f in enumerate(hand.held, len(hand.slips) + 1)}
    along |= {f"s:{k}": slip for k, slip in enumerate(hand.slips, 1)}
    pushed = {f"d{key}": rate(one, hand.q) for key, one in along.items()}
    for key, node in {**conditions, **along, **pushed}.items():
        assert worth(names[key].node) == pytest.approx(by_hand(node)), key
    slopes = [[sp.diff(along[key], one) for one in u] for key in sorted(along, key=lambda key: key[-1])]
    for i, (q, one) in enumerate(zip(hand.q, u, strict=True)):
        momentum = sp.diff(L, one)
        left = rate(momentum, hand.q) - sp.diff(L, q)
        assert worth(names[f"dL:/d{one}"].node) == pytest.approx(by_hand(momentum))
        assert worth(names[f"tau:{i + 1}"].node) == pytest.approx(by_hand(left))
        for k, row in enumerate(slopes, 1):
            assert worth(names[f"A:{k},{i + 1}"].node) == pytest.approx(by_hand(row[i]), abs=1e-12)


@pytest.mark.long(0)
@pytest.mark.wide(3)
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long) for name in HANDS])
@pytest.mark.parametrize("language", ["en", "sk"])
def test_every_formula_is_worth_its_name(name: str, language: str) -> None:
    document = lesson(name, language)
    count = 0
    for step, block in document.blocks():
        if step.key.startswith(("ties.solved", "eliminated")):  # which hold where conditions do: test_teach_tied.py
            continue
        if isinstance(block, (Formula, Braced)):
            key = block.left if isinstance(block, Formula) else block.value
            truth = document.names[key].node if key else document.value(block.form)
            others = [block.form, *([block.right] if isinstance(block, Formula) and block.right is not None else [])]
            for form in others:
                assert worth(document.value(form)) == pytest.approx(worth(truth), rel=1e-9, abs=1e-9), step.key
            count += 1
        if isinstance(block, Matrix):
            for form, key in zip(block.entries, block.names, strict=True):
                truth = document.names[key].node
                assert worth(document.value(form)) == pytest.approx(worth(truth), rel=1e-9, abs=1e-9), step.key
    assert count > 30


def table(document: Document, key: str) -> dict[str, float]:
    (values,) = (block for step, block in document.blocks() if step.key == key and isinstance(block, Table))
    texts = {row[0].parts[0].name: str(row[1].parts[0]) for row in values.rows}
    return {name: float(text.strip("≈ ").replace("−", "-")) for name, text in texts.items()}


@pytest.mark.heavy("disc")
@pytest.mark.long
@pytest.mark.parametrize("name", HANDS)
def test_the_shown_state_solves_the_equations_by_hand(name: str) -> None:
    document, hand = lesson(name), HANDS[name]()
    state, forces = table(document, "state"), table(document, "forces")
    held = [forces[f"lambda:{k}"] for k in range(1, len(hand.held) + len(hand.slips) + 1)]
    L = hand.K - hand.P

    def at(node: sp.Expr) -> float:
        return float(node.subs({x: state[str(x)] for x in node.free_symbols}).evalf())

    along = [*hand.slips, *(rate(f, hand.q) for f in hand.held)]
    for node in (*hand.held, *along, *(rate(one, hand.q) for one in along)):
        assert at(node) == pytest.approx(0, abs=5e-3)
    for q, u in zip(hand.q, rates(hand.q), strict=True):
        left = at(rate(sp.diff(L, u), hand.q) - sp.diff(L, q))
        carried = sum(force * at(sp.diff(one, u)) for force, one in zip(held, along, strict=True))
        drive = forces.get("M", 0.0) if str(q) == "phi" else 0.0
        gas = -state["k"] * state["x_dot"] if name == "slider_crank" and str(q) == "x" else 0.0
        assert left == pytest.approx(carried + drive + gas, abs=2e-2), q


def said(document: Document) -> str:
    return " ".join(
        str(part) for section in document.sections for step in section.steps
        for words in (step.claim, step.reason) for part in words.parts
    )  # fmt: skip


@pytest.mark.long
def test_rolling_of_a_disc_is_non_holonomic_and_that_of_a_wheel_on_a_cart_is_not() -> None:
    assert "Frobenius' condition fails" in said(lesson("disc"))
    cart = walkthrough(scene("cart_with_wheel"), formulation="multipliers", until="conditions")
    assert "Frobenius' condition fails" not in said(cart)
    assert "can be integrated" in said(cart)


@pytest.mark.runs("cc")
@pytest.mark.long
def test_a_disc_that_rolls_has_the_accelerations_of_its_simulation() -> None:
    of = scene("disc")
    steps = {step.key: step for section in lesson("disc").sections for step in section.steps}
    run = simulate(of, until=0.1, start={"b": 0.3}, start_rates={"a_dot": 0.4, "b_dot": 0.1, "c_dot": 5.0})
    at = {p.name: float(p.value.known_at({})) for p in of.parameters if p.value is not None}
    at |= {name: float(run[name][-1]) for name in run.names}

    def number(form: Form) -> float:
        node = form.to_sympy()
        return float(node.subs({x: at[str(x)] for x in node.free_symbols}))

    found = [x for key in ("eliminated", "eliminated:solved") for x in steps[key].blocks if isinstance(x, Formula)]
    assert len(found) == 9
    for block in found:
        assert block.right is not None
        assert number(block.form) == pytest.approx(number(block.right), abs=1e-6)


@pytest.mark.long
@pytest.mark.wide(3)
@pytest.mark.parametrize("language", ["en", "sk"])
@pytest.mark.parametrize(("name", "formulation"), [("two_link", "lagrange"), ("four_bar", "multipliers")])
def test_kanes_form_is_the_same_equation_in_one_line(name: str, formulation: str, language: str) -> None:
    document = lesson_of(scene(name), language, formulation=formulation)
    (line,) = (block for step, block in document.blocks() if step.key == "kane" and isinstance(block, Formula))
    assert line.right is not None
    assert worth(document.value(line.right)) == pytest.approx(worth(document.names["tau:1"].node))
    assert worth(document.value(line.right)) == pytest.approx(worth(document.value(line.form)))
    assert len(line.right.terms) > 3


def test_an_open_mechanism_is_told_the_other_formulation() -> None:
    with pytest.raises(DerivationError, match='formulation="lagrange"'):
        walkthrough(scene("two_link"), formulation="multipliers")


@pytest.mark.long(0)
def test_a_ratio_of_determinants_is_written_where_squares_of_sines_are_left() -> None:
    text = """
    name = "rolling_screw"
    gravity = [0, -9.81, 0]
    [parameters]
    m = "1 g"
    r = "3 mm"
    [bodies]
    arm.particles = [{ mass = "2*m", at = [0, 0.5798, 0] }]
    wheel.particles = [{ mass = "2*m", at = [1.5, 1.313, 0.4] }]
    [joints]
    base = { type = "free", parent = "ground", child = "arm", orientation = "zxz" }
    screw = { type = "helical", parent = "arm", child = "wheel", axis = [0, 0, -1], pitch = 0.1 }
    [constraints.contact]
    type = "rolling"
    body = "wheel"
    axis = [0, 0, 1]
    radius = "r"
    components = ["along", "across"]
    """
    document = walkthrough(read_text(text))
    assert "ratios" in {step.key for step, _ in document.blocks()}


@pytest.mark.heavy("notebook", "latex")
@pytest.mark.long(0)
@pytest.mark.parametrize("format", ["md", "html", "notebook", "latex"])
def test_every_format_takes_it(format: str, tmp_path: Path) -> None:
    assert main(["walkthrough", str(EXAMPLES / "four_bar.toml"), "--formulation", "multipliers", "--language", "sk",
                 "--format", format, "-o", str(tmp_path)]) == 0  # fmt: skip
