"""Lengths of springs and dampers between points stand by name, and every formula is worth what it was written out."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from latex_reader import LatexReader, displays

from symdyn.algebra.form import Form, Function, Number, Power, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.dynamics.closed_forms.closed_form import closed_form
from symdyn.dynamics.mechanism.lagrange import Energies
from symdyn.emit.print.equations_text import equations_text
from symdyn.emit.print.formula_text import Latex
from symdyn.emit.print.printed_names import latex_symbols
from symdyn.graph import Expr, Graph, Op, evaluate, reachable
from symdyn.scene import Quantity, Scene, parse, read
from symdyn.scene.toml import read_text

DATA = Path(__file__).parent / "data"
FILES = {"sp": DATA / "findings" / "sp.toml", "car": DATA / "findings" / "car.toml", "struts": DATA / "struts.toml"}


def scene_of(name: str) -> Scene:
    return read(str(FILES[name]))


def changed(name: str, *pairs: tuple[str, str]) -> Scene:
    """Return a scene whose file says something else."""
    text = FILES[name].read_text(encoding="utf-8")
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return read_text(text, name)


def value_of(name: str) -> float:
    return 0.2 + sum(ord(letter) * (k + 3) for k, letter in enumerate(name)) % 97 / 60


def floats(nodes: list[Expr]) -> list[float]:
    return evaluate(nodes, Floats(), {x: value_of(str(x.value)) for x in reachable(nodes) if x.op is Op.SYMBOL})


def needed(scene: Scene, graph: Graph) -> list[Expr]:
    """Return the drives, zero where there is none, less what Lagrange's formulation says that the motion needs."""
    drives = [(Quantity.symbol(x) if x else Quantity.number(0)).express(graph) for x in scene.drives]
    return [drive - force for drive, force in zip(drives, Energies.of(scene, graph).driving_forces(), strict=True)]


def printed_text(scene: Scene) -> tuple[list[list[str]], dict[str, str]]:
    """Return both sides of every equation in plain text, and what names stand for."""
    lines = re.sub(r"\n +", " ", equations_text(scene, "text")).splitlines()
    sides = [line.split(" = ") for line in lines if " = " in line and not line.startswith("#")]
    n = len(scene.velocities)
    return sides[:n], dict(sides[n:])


@pytest.mark.parametrize("name", FILES)
def test_text_with_its_definitions_has_the_values_of_the_graph(name: str) -> None:
    scene, graph = scene_of(name), Graph()
    equations, defined = printed_text(scene)
    assert defined

    def read_back(text: str) -> Expr:
        for known, form in reversed(defined.items()):  # a rate before the length that stands in it
            text = re.sub(rf"\b{known}\b", f"({form})", text)
        return parse(text).express(graph)

    balances = [read_back(right) - read_back(left) for left, right in equations]
    assert floats(balances) == pytest.approx(floats(needed(scene, graph)), rel=1e-9, abs=1e-9)


@pytest.mark.mends("30.control.4")
@pytest.mark.parametrize(("name", "lengths"), [("sp", 1), ("car", 2)])
def test_text_says_every_length_once(name: str, lengths: int) -> None:
    assert equations_text(scene_of(name), "text").count("sqrt(") == lengths


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("angles", ["long"])
def test_latex_with_its_definitions_has_the_values_of_the_graph(name: str, angles: str) -> None:
    scene, graph = scene_of(name), Graph()
    n, lines = len(scene.velocities), displays(equations_text(scene, "latex", angles=angles))
    known = {latex: graph.symbol(one) for one, latex in latex_symbols(scene).items()} | {"t": graph.symbol("t")}
    for line in lines[n:]:
        left, right = line.split("=", 1)
        known[left.replace("&", "").strip()] = LatexReader(known, graph).sides(right)[0]
    sides = [LatexReader(known, graph).sides(line) for line in lines[:n]]
    balances = [right - left for left, right in sides]
    assert floats(balances) == pytest.approx(floats(needed(scene, graph)), rel=1e-5, abs=1e-5)


@pytest.mark.mends("30.control.4")
def test_equations_share_a_display_and_are_aligned_where_they_fit() -> None:
    tex = equations_text(scene_of("sp"), "latex")
    first = tex.partition(r"\end{align*}")[0]

    assert first.count(r"\ddot") == 3
    assert len(re.findall("&=", first)) == 3


@pytest.mark.long
@pytest.mark.parametrize("name", FILES)
def test_sympy_with_sub_is_what_is_written_out(name: str) -> None:
    import symdyn

    found, closed = symdyn.equations(scene_of(name)).sympy(), closed_form(scene_of(name))
    assert found.sub
    assert not any(
        symbol in value.free_symbols | value.atoms(type(symbol)) for symbol in found.sub for value in found.sub.values()
    )
    for i in range(closed.n):
        same(found.k_E[i].subs(found.sub), closed.sympy("k_E", i))
        same(found.P.diff(found.q[i]).subs(found.sub).doit(), found.k_E[i].subs(found.sub) + found.g[i])
    same(found.P.subs(found.sub), closed.sympy("P"))


def same(one: Any, other: Any) -> None:
    values = {x: value_of(x.name) for x in one.free_symbols | other.free_symbols}
    assert float(one.subs(values)) == pytest.approx(float(other.subs(values)), rel=1e-9, abs=1e-9)


def test_sympy_in_time_and_as_a_program_say_the_same() -> None:
    import sympy

    import symdyn

    scene = scene_of("sp")
    moving = symdyn.equations(scene).sympy(dynamic=True)
    plain = symdyn.equations(scene).sympy()
    still = {moving[name]: plain[name] for name in plain.symbols if name in (*scene.coordinates, *scene.velocities)}
    ordered = dict(sorted(still.items(), key=lambda pair: -len(str(pair[0]))))
    same(moving.tau[0].subs(moving.sub).subs(ordered), plain.tau[0].subs(plain.sub))
    space: dict[str, Any] = {}
    exec("from sympy import *", space)
    exec(equations_text(scene, "sympy"), space)
    for i, equation in enumerate(plain.equations, 1):
        other = space[f"equation{i}"]
        assert isinstance(other, sympy.Eq)
        for a, b in zip(other.args, equation.args, strict=True):
            same(a.subs(space["sub"]), b.subs(plain.sub))


@pytest.mark.parametrize("own", ["s_s", "ss", "s_s_"])
def test_a_length_is_called_as_no_symbol_of_the_scene(own: str) -> None:
    scene = changed("sp", ("\nk = 10", f"\n{own} = 10"), ('"k"', f'"{own}"'))
    graph = Graph()
    equations, defined = printed_text(scene)
    assert own not in defined
    assert f"{own}*" in equations[0][0]
    symbols = latex_symbols(scene, (), [next(iter(defined))])
    assert len(set(symbols.values())) == len(symbols)
    texts = {name: parse(form).express(graph) for name, form in defined.items()}
    assert all(graph.symbol(own) not in reachable([node]) for node in texts.values())


def test_struts_between_the_same_points_share_a_length_and_others_do_not() -> None:
    turned = changed(
        "sp",
        (
            '[dampers.d]\nfrom = { body = "b", at = ["a", 0, 0] }\nto = { body = "ground", at = [0, -1, 0] }',
            '[dampers.s]\nto = { body = "b", at = ["a", 0, 0] }\nfrom = { body = "ground", at = [0, -1, 0] }',
        ),
    )
    other = changed(
        "sp",
        (
            '[dampers.d]\nfrom = { body = "b", at = ["a", 0, 0] }',
            '[dampers.s]\nfrom = { body = "b", at = [0, "a", 0] }',
        ),
    )

    assert list(printed_text(turned)[1]) == ["s_s", "s_s_dot"]
    assert list(printed_text(other)[1]) == ["s_s", "s_damper_s", "s_damper_s_dot"]


RAIL = """
gravity = "none"
parameters = { m = {}, k = {}, c = {}, l = {}, h = {} }
bodies.slide.mass = "m"
joints.rail = { type = "prismatic", parent = "ground", child = "slide", axis = [1, 0, 0], coordinate = "x" }
springs.sf = { from = { body = "ground", at = [0, "h", 0] }, to = "slide", stiffness = "k", free = "l" }
dampers.df = { from = { body = "ground", at = [0, "h", 0] }, to = "slide", damping = "c" }
"""


def test_the_page_shows_what_is_printed() -> None:
    page = Path(__file__).parent.parent / "docs" / "equations.md"
    assert equations_text(read_text(RAIL, "rail"), "text") in page.read_text(encoding="utf-8")


@pytest.mark.long(0)
def test_a_student_may_answer_with_lengths_by_their_names() -> None:
    from symdyn.teach import check_derivation

    right = r"m \ddot x + \frac{k (s_s - \tfrac12) (x + a \cos \phi)}{s_s} = -\frac{2 \dot s_s (x + a \cos \phi)}{s_s}"
    wrong = right.replace(r"\dot s_s", "s_s")
    scene = scene_of("sp")

    assert [answer.right for answer in check_derivation(right, scene)] == [True]
    assert [answer.right for answer in check_derivation(wrong, scene)] == [False]
    assert [answer.right for answer in check_derivation("P = k*(s_s - 1/2)**2/2", scene)] == [True]


@pytest.mark.parametrize("name", FILES)
def test_the_system_of_dalembert_names_lengths_and_has_its_values(name: str) -> None:
    from symdyn.emit.print.dalembert_page import forms_of, printed_system

    system = printed_system(scene_of(name))
    written, graph = forms_of(system), system.hanging.graph
    assert written.lengths.named
    for known in system.bodies:
        entries = [x for part in (*known.action, *known.inertia) for x in part]
        shown = [written.lengths.written_out(written(x)).express(graph) for x in entries]
        assert floats(shown) == pytest.approx(floats(entries), rel=1e-9, abs=1e-9)


@pytest.mark.mends("30.control.4")
@pytest.mark.parametrize(("name", "lengths"), [("sp", 1), ("car", 2)])
def test_the_text_of_dalembert_says_every_length_once(name: str, lengths: int) -> None:
    from symdyn.emit.print.dalembert_page import dalembert_lines

    assert dalembert_lines(scene_of(name)).count("sqrt(") == lengths


LESSONS = [("sp", "lagrange"), ("sp", "dalembert"), ("car", "lagrange"), ("car", "dalembert")]


@pytest.mark.heavy("car-dalembert")
@pytest.mark.long
@pytest.mark.parametrize(("name", "formulation"), LESSONS)
def test_formulas_of_a_lesson_have_the_values_of_the_graph(name: str, formulation: str) -> None:
    from symdyn.teach import walkthrough
    from symdyn.teach.document import Formula

    document, shown = walkthrough(scene_of(name), formulation=formulation), 0
    for step, block in document.blocks():
        if isinstance(block, Formula) and block.left and not step.key.startswith(("law", "stated")):
            truth = document.names[block.left].node
            if truth is None or any(not one.value for one in reachable([truth]) if one.op is Op.SYMBOL):
                continue
            for form in (block.form, block.right):
                if form is not None:
                    values = floats([truth, document.value(form)])
                    assert values[1] == pytest.approx(values[0], rel=1e-9, abs=1e-9), (step.key, block.left)
                    shown += step.key == "lengths"
    assert shown == 2 * (2 if name == "car" else 1)


@pytest.mark.heavy("car-dalembert")
@pytest.mark.long
@pytest.mark.mends("30.control.4")
@pytest.mark.parametrize(("name", "formulation"), LESSONS)
def test_a_lesson_says_every_length_once(name: str, formulation: str) -> None:
    from symdyn.teach import walkthrough
    from symdyn.teach.document import Braced, Formula

    scene = scene_of(name)
    roots = [
        step.key
        for step, block in walkthrough(scene, formulation=formulation).blocks()
        if isinstance(block, (Formula, Braced))
        for one in block.form.walk()
        if isinstance(one, Function) and one.op is Op.SQRT and {*one.symbols} & {*scene.coordinates}
    ]
    assert len(roots) == (2 if name == "car" else 1)


def wide_quotients() -> list[Form]:
    """Return fractions too wide for a line: above, below, under a root, with powers, and in a sum."""
    names = [Symbol(f"l{k}") for k in range(24)]
    long = Form.sum(names)
    root, two = Function(Op.SQRT, (long,)), Number(Fraction(2))
    m, c = Symbol("m"), Symbol("c")
    return [
        Form.product((two, long, Form.sum((m, c)), Power(m, -1))),
        Form.product((m, Power(long, -1))),
        Form.product((long, Form.sum((m, c)), Power(root, -1))),
        Form.product((m, Power(root, -3), Power(c, -2))),
        Form.product((Number(Fraction(-1, 2)), long, Power(long, -2))),
        Form.sum((c, Form.product((Number(Fraction(-1)), long, Power(Form.sum((m, c)), -1))))),
        Power(long, -2),
        Power(root, 3),
        root,
    ]


@pytest.mark.mends("30.control.4")
@pytest.mark.parametrize("k", range(9))
def test_wide_fractions_break_and_have_their_value(k: int) -> None:
    form, graph = wide_quotients()[k], Graph()
    names = {f"l{i}": f"l_{{{i}}}" for i in range(24)} | {"m": "m", "c": "c"}
    text = Latex(names)(form)
    pieces = text.split("\v")

    reader = LatexReader({latex: graph.symbol(name) for name, latex in names.items()}, graph)
    (shown,) = reader.sides(text.replace("\v", ""))
    assert floats([shown]) == pytest.approx(floats([form.express(graph)]), rel=1e-9)
    assert max(map(len, pieces)) < 120, pieces
