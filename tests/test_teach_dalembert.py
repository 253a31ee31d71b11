"""What D'Alembert's lesson says: its laws hold for every body that it cuts free, its loops are solved before use."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy
from lessons import lesson_of, step_of

from symdyn.algebra.form import Form, Function, Number, Power, Product, Sum, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.graph import Graph, Op, evaluate, reachable
from symdyn.scene import Scene, read
from symdyn.scene.toml import read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion, solved_at
from symdyn.teach.derivations.dalembert.side_by_side import terms_of_both
from symdyn.teach.derivations.dalembert.solved_loops import less
from symdyn.teach.derivations.dalembert.spatial_loop import other_joints
from symdyn.teach.derivations.rotations import expanded_squares
from symdyn.teach.document import Formula, Matrix

ROOT = Path(__file__).parent
EXAMPLES = ROOT.parent / "examples"
STARTS = ("four_bar", "slider_crank", "governor", "cart_with_wheel")


@cache
def lesson(name: str, language: str = "en") -> Document:
    return lesson_of(read(EXAMPLES / f"{name}.toml"), language, formulation="dalembert")


def state_of(name: str) -> dict[str, float]:
    """Return the lesson's state in all digits: a position where loops are closed, and what they allow."""
    balance = Balance(read(EXAMPLES / f"{name}.toml"), "en")
    return {str(x.value): value for x, value in choose_motion(balance).values.items()}


def value(document: Document, form: Form, state: dict[str, float]) -> float:
    node = document.value(form)
    symbols = [x for x in reachable([node]) if x.op is Op.SYMBOL]
    return float(evaluate([node], Floats(), {x: state[str(x.value)] for x in symbols})[0])


@pytest.mark.wide(2)
@pytest.mark.long
@pytest.mark.parametrize("name", STARTS)
def test_loops_are_solved_by_formulas_that_hold_where_they_are_closed(name: str) -> None:
    document, state = lesson(name), state_of(name)
    solved = [block for step, block in document.blocks() if step.key.startswith("solved:")]
    formulas = [block for block in solved if isinstance(block, Formula) and not block.left and block.right is not None]
    assert len(formulas) >= 2
    for block in formulas:
        left, right = value(document, block.form, state), value(document, block.right, state)
        off = (left - right + np.pi) % (2 * np.pi) - np.pi if isinstance(block.form, Symbol) else left - right
        assert off == pytest.approx(0, abs=1e-7), block
        others = {key: x + 0.1 * k**1.5 for k, (key, x) in enumerate(state.items(), 1)}
        assert value(document, block.form, others) - value(document, block.right, others) != pytest.approx(0, abs=1e-6)


@pytest.mark.long(0)
@pytest.mark.wide("2.5")
@pytest.mark.parametrize("start", [0.8, 2.5, -1.2])
def test_a_four_bar_is_assembled_as_it_is_drawn_wherever_it_starts(start: float) -> None:
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8").replace("start = 0.8", f"start = {start}")
    scene = read_text(text, "four_bar")
    for crossed in (False, True):
        if crossed:
            text = text.replace("start = 2.0260131545490214846", "start = -2.03").replace(
                "start = 0.1420089234527959928", "start = -1.7"
            )
            scene = read_text(text, "four_bar")
        assembled(scene)


def test_a_four_bar_is_assembled_where_its_angles_have_turned_once_more() -> None:
    text = (EXAMPLES / "four_bar.toml").read_text(encoding="utf-8")
    text = text.replace("start = 2.0260131545490214846", "start = 8.309198461728608")

    assembled(read_text(text.replace("start = 0.1420089234527959928", "start = 6.425194230632382"), "four_bar"))


def assembled(scene: Scene) -> None:
    """Hold the formulas of both angles of a four-bar against the drawn position."""
    document = walkthrough(scene, formulation="dalembert", until="count")
    chosen = choose_motion(Balance(scene, "en"))
    state = {str(x.value): one for x, one in chosen.values.items()}
    found = [
        block
        for step, block in document.blocks()
        if step.key == "solved:positions:1" and isinstance(block, Formula) and isinstance(block.form, Symbol)
    ]
    assert {block.form.name for block in found} == {"psi", "chi"}
    for block in found:
        off = state[block.form.name] - value(document, block.right, state)
        assert (off + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0, abs=1e-7)


def test_rates_that_no_page_holds_are_found_in_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    def keys() -> set[str]:
        document = walkthrough(read(EXAMPLES / "governor.toml"), formulation="dalembert", until="count")
        return {step.key for step, _ in document.blocks()}

    assert "solved:linear" in keys()
    monkeypatch.setattr("symdyn.teach.derivations.dalembert.solved_loops.PAGE", 20)  # its longest has 21 terms
    assert "solved:linear" not in keys()


@pytest.mark.parametrize(
    ("name", "key", "form"),
    [
        ("slider_crank", "M*R:2,wristpin:z", "-l F_y"),
        ("four_bar", "M*R:2,hinge:z", "-b F_y"),
    ],
)
def test_a_force_in_a_hinge_has_the_arm_that_one_sees(name: str, key: str, form: str) -> None:
    """Seen from the parent a pin is where it was declared, not around the whole loop (FINDINGS 5.10)."""
    document = lesson(name)
    block = next(b for _, b in document.blocks() if isinstance(b, Matrix) and key in b.names)
    entry = block.entries[block.names.index(key)]
    assert isinstance(entry, Product)
    assert len(entry.factors) == 3
    pin = key.split(",")[1].split(":", maxsplit=1)[0]
    assert entry.factors[1:] == (Symbol(form[1]), Symbol(f"reaction:{pin}:1"))


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_factor_less_leaves_the_quotient(power: int) -> None:
    x, numbers = Symbol("x"), {"x": Number(Fraction(5)), "y": Number(Fraction(7))}
    left = Form.product(less(x, (x.power(power), Symbol("y"))))

    assert evaluate([left.substitute(numbers).express(Graph())], Floats(), {}) == [5 ** (power - 1) * 7]


def test_an_angle_is_written_in_one_way() -> None:
    """Not sin(χ - φ) beside cos(φ - χ): the scene's first coordinate is positive in each."""
    document = lesson("four_bar")
    order = document.scene.coordinates
    angles = []
    for _, block in document.blocks():
        forms = block.entries if isinstance(block, Matrix) else [block.form] if isinstance(block, Formula) else []
        angles += [angle for form in forms for angle in circular(form)]
    assert len(angles) > 20
    for angle in angles:
        graph = Graph()
        q = {x.value: x for x in reachable([angle.express(graph)]) if x.op is Op.SYMBOL}
        leading = min(q, key=order.index)
        one = evaluate([angle.express(graph)], Floats(), {x: float(x.value == leading) for x in q.values()})[0]
        assert one > 0


def circular(form: Form) -> list[Form]:
    if isinstance(form, Function):
        return [form.args[0]] if form.op in (Op.SIN, Op.COS) else [x for arg in form.args for x in circular(arg)]
    if isinstance(form, Power):
        return circular(form.base)
    inner = form.terms if isinstance(form, Sum) else form.factors if isinstance(form, Product) else ()
    return [x for part in inner for x in circular(part)]


@pytest.mark.parametrize("name", ["two_link", "cart_pole", "double_pendulum", "spatial_3r"])
def test_each_term_of_lagrange_is_what_the_bodies_of_dalembert_add_up_to(name: str) -> None:
    document = walkthrough(read(EXAMPLES / f"{name}.toml"), until="energies")
    terms = terms_of_both(document.scene)
    assert {term.velocity for term in terms} == set(range(len(document.scene.velocities)))
    for term in terms:
        values = [value(document, form, DefaultState()) for form in (term.coefficient, *term.shares)]
        assert sum(values[1:]) == pytest.approx(values[0], rel=1e-9, abs=1e-12), term


@pytest.mark.long
@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
@pytest.mark.parametrize("language", ["en", "sk"])
def test_both_formulations_end_in_the_table_that_sets_them_side_by_side(formulation: str, language: str) -> None:
    document = lesson_of(read(EXAMPLES / "cart_pole.toml"), language, formulation=formulation)
    step = step_of(document, "side")
    tables = [block for block in step.blocks if isinstance(block, Table)]
    rows = [[len(table.rows), {len(row) for row in table.rows}] for table in tables]
    assert rows == [[3, {3}], [3, {3}]]


class DefaultState(dict[str, float]):
    """A number for any symbol, no two alike."""

    def __missing__(self, key: str) -> float:
        return 0.3 + sum(ord(letter) * (k + 3) for k, letter in enumerate(key)) % 89 / 60


def skew(v: np.ndarray) -> np.ndarray:
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "two_link"])
def test_what_is_displayed_of_each_body_obeys_the_laws(name: str) -> None:
    """(5.11), (5.13), (5.14), (5.16) of what a lesson displays, which is worth its names, give its bivector (5.17)."""
    document, state = lesson(name), state_of(name)
    laws = {block.left for step, block in document.blocks() if isinstance(block, Formula) and step.key == "law:inertia"}
    assert {f"law:{key}" for key in ("F_D0", "F_D", "M_D", "F_star")} <= laws

    def shown(left: str, places: str = "xyz") -> np.ndarray:
        keys = [f"{left}:{place}" for place in places.split(" ")] if " " in places else [f"{left}:{x}" for x in places]
        names = [document.names.get(key) for key in keys]  # none for a point that stays where it is
        return np.array(
            [0.0 if one is None else value(document, Symbol(k), state) for k, one in zip(keys, names, strict=True)]
        )

    square = " ".join(f"{r}{c}" for r in "123" for c in "123")
    for j, body in enumerate(document.scene.bodies, 1):
        P, I = (shown(left, square).reshape(3, 3) for left in (f"P:0{j}", f"I:{j}{j}"))  # noqa: E741  the book's names
        w, dw, F, star = (shown(left) for left in (f"omega:0{j}", f"domega:0{j}", f"FD:0{j}", f"F*D:{j}{j}"))
        (m,) = (state.get(f"m{j}"),)
        assert m is not None, body.name
        assert pytest.approx(-m * shown(f"ddr:0,T{j}"), abs=1e-9) == F
        way = shown(f"r:0,T{j}") - shown(f"r:0,O{j}")
        if f"ddr:0,O{j}:x" in document.names:
            assert pytest.approx(-m * P.T @ shown(f"ddr:0,O{j}"), abs=1e-9) == star
            force, moment = P.T @ F, -(I @ dw + skew(w) @ I @ w) + skew(P.T @ way) @ star
            found = [*(shown(f"FD:{j}{j}", "xy")), *shown(f"MD:{j}{j}", "z")]
            assert pytest.approx([force[0], force[1], moment[2]], abs=1e-9) == found
        else:
            (step,) = (one for part in document.sections for one in part.steps if one.key == f"accelerated:{body.name}")
            one_point = "are one point" in str(step.blocks)
            assert star == pytest.approx(P.T @ F if one_point else np.zeros(3), abs=1e-9)


def test_the_whole_system_is_of_reactions_and_a_sine_ends_before_what_follows() -> None:
    text = str(rendered(lesson("slider_crank"), "md")["slider_crank.md"])
    assert "All bodies together: one linear system for all unknowns" in text
    assert "for accelerations and multipliers" not in text
    assert r"\frac{r \cos \phi \, \dot{\phi}}{l \cos(\phi + \psi)}" in text


def test_products_that_differ_in_the_order_of_their_factors_are_one() -> None:
    """((s + c) (a + b))² has the outer factors a², a b and b², however its terms were met."""
    a, b = Symbol("a"), Symbol("b")
    sines = (Function(Op.SIN, Symbol("x")), Function(Op.COS, Symbol("x")))
    form = Form.sum(Form.product((s, k)) for s in sines for k in (a, b))
    groups = expanded_squares([form])
    assert groups is not None
    assert len(groups) == 3


def test_every_equation_is_put_in_and_is_what_sympy_finds() -> None:
    """The six rows of two_link against positions that SymPy differentiates."""
    document, state = lesson("two_link"), state_of("two_link")
    rows = {
        body: [b.form for s, b in document.blocks() if s.key == f"substituted:{body}" and isinstance(b, Formula)]
        for body in ("link1", "link2")
    }
    t, m, h, g = sympy.Symbol("t"), (state["m1"], state["m2"]), (state["h1"], state["h2"]), state["g"]
    q = [sympy.Function(f"q{k}")(t) for k in (1, 2)]
    at = {q[k].diff(t, n): state[f"q{k + 1}" + suffix] for n, suffix in ((2, "_ddot"), (1, "_dot")) for k in (0, 1)}
    at |= {q[k]: state[f"q{k + 1}"] for k in (0, 1)}
    turned = (q[0], q[0] + q[1])
    arms = [sympy.Matrix([d * sympy.sin(a), -d * sympy.cos(a)]) for d, a in zip(h, turned, strict=True)]
    places = [arms[0], arms[0] + arms[1]]
    given = {f"reaction:{joint}:{k}": 0.4 * k + len(joint) for joint in ("shoulder", "elbow") for k in range(2)}
    given |= {"M1": 3.1, "M2": -1.7}
    forces = {
        joint: sympy.Matrix([given[f"reaction:{joint}:{k}"] for k in range(2)]) for joint in ("shoulder", "elbow")
    }

    def moment(arm: sympy.Matrix, force: sympy.Matrix) -> sympy.Expr:
        return arm[0] * force[1] - arm[1] * force[0]

    weight = [sympy.Matrix([0, -m[k] * g]) - m[k] * places[k].diff(t, 2) for k in (0, 1)]
    R1 = sympy.Matrix([[sympy.cos(q[0]), -sympy.sin(q[0])], [sympy.sin(q[0]), sympy.cos(q[0])]])
    elbow = R1 * forces["elbow"]
    sides = {
        "link1": (
            weight[0] + forces["shoulder"] - elbow,
            moment(arms[0], weight[0] - elbow) + given["M1"] - given["M2"],
            turned[0],
        ),
        "link2": (weight[1] + elbow, moment(arms[1], weight[1]) + given["M2"], turned[1]),
    }
    for body, (force, torque, angle) in sides.items():
        back = sympy.Matrix([[sympy.cos(angle), sympy.sin(angle)], [-sympy.sin(angle), sympy.cos(angle)]])
        expected = [float(x.subs(at)) for x in (*(back * force), torque)]
        assert [loose(document, form, state | given) for form in rows[body]] == pytest.approx(expected, abs=1e-9)


def loose(document: Document, form: Form, state: dict[str, float]) -> float:
    """Return what a form is worth where unknowns are what the state says, and not what solves the equations."""
    node = form.express(document.graph)
    return float(
        evaluate([node], Floats(), {x: state[str(x.value)] for x in reachable([node]) if x.op is Op.SYMBOL})[0]
    )


def test_the_last_term_of_the_moment_and_steiner_s_are_shown() -> None:
    document, state = lesson("slider_crank"), state_of("slider_crank")
    step = {one.key: one for part in document.sections for one in part.steps}["about:rod"]
    matrices = {block.left: block for block in step.blocks if isinstance(block, Matrix)}
    shown = {k: np.array([value(document, x, state) for x in b.entries]) for k, b in matrices.items()}
    star, m, length = value_of(document, "F*D:22", state), state["m2"], state["l"]

    assert shown["r:2,T2"] == pytest.approx([length / 2, 0, 0])
    assert shown["M*D:22"] == pytest.approx(np.cross(shown["r:2,T2"], star))
    assert shown["I:2,T2"].reshape(3, 3)[2, 2] == pytest.approx(m * length**2 / 12)
    assert "about:piston" not in {one.key for part in document.sections for one in part.steps}


def value_of(document: Document, left: str, state: dict[str, float]) -> np.ndarray:
    """Return a vector by its name."""
    return np.array([value(document, Symbol(f"{left}:{axis}"), state) for axis in "xyz"])


def test_a_plane_leaves_three_of_six_rows() -> None:
    document = lesson("cart_with_wheel")  # moves in x and z
    columns = [b for s, b in document.blocks() if s.key == "bivectors:cart" and isinstance(b, Matrix)]
    assert {len(b.entries) for b in columns} == {6}
    assert all(b.entries[k] == Number.ZERO for b in columns for k in (1, 3, 5))
    assert {len(b.entries) for s, b in document.blocks() if s.key == "bivectors:wheel" and isinstance(b, Matrix)} == {3}
    text = str(rendered(document, "md")["cart_with_wheel.md"])
    assert "rows 2, 4, 6 are empty" in text
    assert r"6 (u - 1) = n + m_R \tag{5.20}" in text
    assert r"3 (u - 1) = n + m_R" in text
    assert r"\mathbf{A} \mathbf{x} + \mathbf{b} = 0" in text
    assert r"\mathbf{b} = 0 \tag" not in text
    assert all(rf"\tag{{{number}}}" in text for number in ("5.1a", "5.1b", "5.1c", "5.5a", "5.5b", "5.5c"))


def test_where_nothing_is_driven_no_drives_are_compared() -> None:
    text = (EXAMPLES / "cart_with_wheel.toml").read_text(encoding="utf-8").replace('drive = "T"', "drive = false")
    document = walkthrough(read_text(text, "free_wheel"), formulation="dalembert")
    shown = "".join(map(str, rendered(document, "md").values()))
    assert "Drives compared" not in shown
    assert "The reactions obey the laws of mechanics" in shown


LOOPS = ("rsup", "spatial_slider_crank", "rssr")


def numbers_of(document: Document, key: str) -> tuple[list[str], np.ndarray]:
    """Return the last table of a step: keys of its heads and its numbers, without the first and the last column."""
    step = next(one for part in document.sections for one in part.steps if one.key == key)
    (table,) = (block for block in step.blocks if isinstance(block, Table))
    heads = [next(iter(head.parts[0].symbols)) for head in table.columns[1:-1]]
    cells = [
        [float(str(cell.parts[0]).replace("−", "-").replace(" · 10^", "e")) for cell in row[1:-1]] for row in table.rows
    ]
    return heads, np.array(cells)


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_in_space_stays_in_letters_and_their_values_give_its_inertia_forces(name: str) -> None:
    """(5.13)-(5.17) of the table of accelerations are the column of the table whose rows add up to zero."""
    document, balance = lesson(name), Balance(read(EXAMPLES / f"{name}.toml"), "en")
    chosen = choose_motion(balance)
    for j, body in enumerate(document.scene.bodies):
        one = balance.cuts[j]
        assert one is not None
        _, (a_T, a_O, w, dw) = numbers_of(document, f"letters:{body.name}")
        heads, rows = numbers_of(document, f"balance:{body.name}")
        P, tensor = (np.reshape(chosen.of(*(x for row in M for x in row)), (3, 3)) for M in (one.P, one.I))
        (m,), arm = chosen.of(one.m), chosen.of(*one.arm)
        force = -m * P.T @ a_T
        moment = -(tensor @ dw + skew(w) @ tensor @ w) + np.cross(arm, -m * P.T @ a_O)
        column = next((k for k, head in enumerate(heads) if head.startswith("FDbar:")), None)
        shown = np.zeros(6) if column is None else rows[:, column]
        scale = max(1.0, float(np.abs(rows).max()))

        assert [*force, *moment] == pytest.approx(shown, abs=1e-3 * scale)
        assert rows.sum(axis=1) == pytest.approx(np.zeros(6), abs=1e-3 * scale)


@pytest.mark.parametrize("name", LOOPS)
def test_the_blocks_of_a_loop_are_what_its_joints_exert(name: str) -> None:
    """1, and minus or plus the shift and the turn, at the bivector that a joint transmits; ground first as frame 0."""
    balance = Balance(read(EXAMPLES / f"{name}.toml"), "en")
    chosen, system = choose_motion(balance), balance.system
    x = solved_at(balance, chosen)[0]
    frames = [
        (np.reshape(chosen.of(*(e for row in T.R for e in row)), (3, 3)), np.array(chosen.of(*T.p)))
        for T in system.hanging.frames
    ]

    def exerted(j: int, h: int) -> np.ndarray:
        mine = [u for u, one in enumerate(system.unknowns) if one.acts[0][0] == h and (j, u) in system.blocks]
        return sum(
            (x[u] * np.array(chosen.of(*(e for v in system.blocks[j, u] for e in v))) for u in mine), np.zeros(6)
        )

    for j, (P_j, r_j) in enumerate(frames):
        for h, hinge, as_written in other_joints(balance, j):
            if h < len(frames):
                (P_e, r_e), bivector = frames[h], exerted(h, h)
            else:
                turned = np.reshape(chosen.of(*(e for row in hinge.origin.R for e in row)), (3, 3))
                P_p, (r_p, O_p) = np.eye(3), (np.zeros(3), np.zeros(3))
                if hinge.parent >= 0:
                    P_p, r_p = frames[hinge.parent]
                    O_p = np.array(chosen.of(*system.hanging.joints[hinge.parent].place_on_child))
                P_e, r_e = P_p @ turned, r_p + P_p @ (np.array(chosen.of(*hinge.place_on_parent)) - O_p)
                own = [u for u, one in enumerate(system.unknowns) if one.acts[0][0] == h]
                units = (system.unknowns[u].acts[0][1] for u in own)
                bivector = sum(
                    x[u] * np.array(chosen.of(*(e for v in W for e in v))) for u, W in zip(own, units, strict=True)
                )
            P, r = P_j.T @ P_e, P_j.T @ (r_e - r_j)
            force = P @ bivector[:3]
            shifted = np.array([*force, *(np.cross(r, force) + P @ bivector[3:])])

            assert exerted(j, h) == pytest.approx(shifted if as_written else -shifted, abs=1e-7)


def test_contacts_stand_in_the_table_of_classes() -> None:
    document = lesson("cart_with_wheel")
    step = next(one for part in document.sections for one in part.steps if one.key == "count")
    (table,) = (block for block in step.blocks if isinstance(block, Table))

    assert [str(row[0].parts[0]) for row in table.rows] == ["track", "axle", "slip"]
    assert [int(str(row[2].parts[0])) for row in table.rows] == [2, 2, 1]
