"""What a walkthrough prints is what the graph says, in every language, on every page."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from math import cos, sin
from pathlib import Path

import pytest
from calls import counted
from latex_reader import LatexReader, displays
from lessons import lesson_of
from mechanisms import jointed

from symdyn.algebra.form import Number, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.cli import main
from symdyn.dynamics import Energies, Workspace
from symdyn.dynamics.loops.constraint_rows import differentiated
from symdyn.dynamics.mechanism.state import body_placements
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import DerivationError, EmitError
from symdyn.graph import Expr, Graph, Op, evaluate, reachable, substitute, tangents
from symdyn.scene import Quantity, Scene, read
from symdyn.scene.joints import JOINTS
from symdyn.scene.scene_files import Starter
from symdyn.scene.toml import read_text
from symdyn.table import Table
from symdyn.teach import Document, rendered, walkthrough
from symdyn.teach.derivations import meaning as meaning_room
from symdyn.teach.derivations.dalembert.laws import LAW
from symdyn.teach.document import ERRATA, Box, Braced, Fold, Formula, Matrix, Picture, Shares, Step, Words
from symdyn.teach.languages import PLACE, language_of, languages
from symdyn.teach.mathematics import Spelling, written
from symdyn.teach.notation import NUMBERS, READS
from symdyn.teach.render.handout import FORMULATIONS, usual_formulation

EXAMPLES = Path(__file__).parent.parent / "examples"
DIGITS = {"scara": 2e-4}  # numbers of six digits
SPRUNG = """
name = "sprung"
gravity = [0, "-g", 0]
[parameters]
m = { value = 1, positive = true }
l = { value = 1, positive = true }
k = { value = 40, positive = true }
g = { value = 9.81, positive = true }
[bodies.rod]
particles = [{ mass = "m", at = [0, "l", 0] }]
[joints.pivot]
type = "revolute"
parent = "ground"
child = "rod"
axis = [0, 0, 1]
coordinate = "phi"
drive = "M"
damping = 0.2
armature = 0.05
[springs.coil]
joint = "pivot"
stiffness = 1
[springs.cord]
from = { body = "ground", at = ["-l", 0, 0] }
to = { body = "rod", at = [0, "l/2", 0] }
stiffness = "k"
free = 0.5
"""
CUT = ["two_link", "cart_pole", "spatial_3r", "four_bar", "slider_crank", "governor"]
TIED = ["slider_crank", "four_bar", "governor"]
SCENES = ["pendulum", "two_link", "cart_pole", "double_pendulum", "spatial_3r", "rrp", "sprung", "scara"]


def scene(name: str) -> Scene:
    templates = {"spatial_3r": "rrr", "rrp": "rrp"}
    if name == "sprung":
        return read_text(SPRUNG, name)
    if name in templates:
        return read_text(Starter(name).from_template(templates[name]), name)
    return read(EXAMPLES / f"{name}.toml")


@cache
def lesson(name: str, language: str = "en", formulation: str = "lagrange") -> Document:
    return lesson_of(scene(name), language, formulation=formulation)


def value_of_symbol(name: str) -> float:
    return 0.3 + sum(ord(letter) * (k + 3) for k, letter in enumerate(name)) % 89 / 60


def floats(nodes: list[Expr]) -> list[float]:
    values = {x: value_of_symbol(str(x.value)) for x in reachable(nodes) if x.op is Op.SYMBOL}
    return evaluate(nodes, Floats(), values)


def reader(document: Document) -> LatexReader:
    graph = document.graph
    symbols = {}
    for key, latex in Spelling(document).symbols.items():
        name = document.names.get(key)
        if not key.endswith(":tied"):  # the same quantity with the conditions put in
            symbols[latex] = graph.symbol(key) if name is None or name.node is None else name.node
    return LatexReader(symbols, graph)


def is_general(document: Document, block: Formula | Braced) -> bool:
    """Whether a formula is about any coordinate q_i, which has no value."""
    named = [document.names.get(key) for key in block.form.symbols]
    return any(one is not None and one.node is None and one.look is not None for one in named)


@pytest.mark.wide(6)
@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        *((name, "lagrange") for name in SCENES),
        *((name, "multipliers") for name in TIED),
        *((name, "dalembert") for name in CUT),
    ],
)
def test_every_formula_of_the_latex_has_the_value_of_the_graph(name: str, formulation: str) -> None:
    document = lesson(name, formulation=formulation)
    (tex,) = rendered(document, "latex").values()
    printed = displays(str(tex))
    every = [(step, block) for step, block in document.blocks() if isinstance(block, (Formula, Braced))]
    blocks = [(step, block) for step, block in every if not step.key.startswith(ERRATA)]  # these stand in words
    assert len(printed) == len(blocks) > 5
    read_latex, solved = reader(document), dict[Expr, Expr]()
    for text, (step, block) in zip(printed, blocks, strict=True):
        if is_general(document, block):
            continue  # of any coordinate; `test_the_principle_holds_for_every_coordinate` puts each in its place
        if step.key.startswith((LAW, "solved:", "ties.solved", "eliminated")):
            continue  # tests/test_teach_dalembert.py and test_teach_tied.py look at what holds where conditions do
        left, *right = read_latex.sides(text)
        key = block.value if isinstance(block, Braced) else block.left
        if step.key == "explicit" and not key:
            (solved[left],) = right
            continue
        truth = document.names[key].node if key else left
        assert truth is not None
        if key and not isinstance(block, Braced):
            assert left is truth, text
        if formulation == "dalembert" and document.scene.loops and not key:
            continue  # A x + b = 0 holds for the x that it determines
        for side in right:
            expected, shown = floats([truth, side])
            assert shown == pytest.approx(expected, rel=DIGITS.get(name, 1e-9), abs=1e-9), text
    count = len(document.scene.velocities) if solved else 0
    equations = [[document.names[f"{side}:{i + 1}"].node for side in ("tau", "QA")] for i in range(count)]
    for balance, force in equations:  # with the accelerations put in
        assert balance is not None
        assert force is not None
        expected, shown = floats([force, *substitute([balance], solved)])
        assert shown == pytest.approx(expected, rel=DIGITS.get(name, 1e-9), abs=1e-9)


@pytest.mark.heavy("spatial_3r", "governor")
@pytest.mark.long
@pytest.mark.parametrize("name", CUT)
def test_every_bivector_of_the_latex_has_the_value_of_the_graph(name: str) -> None:
    document = lesson(name, formulation="dalembert")
    (tex,) = rendered(document, "latex").values()
    printed = re.findall(r"\\begin\{bmatrix\}(.*?)\\end\{bmatrix\}", str(tex), re.DOTALL)
    columns = [(step, block) for step, block in document.blocks() if isinstance(block, Matrix)]
    assert len(printed) == len(columns) >= 2 * len(document.scene.bodies)
    read_latex = reader(document)
    for text, (step, column) in zip(printed, columns, strict=True):
        if step.key.startswith(LAW):
            continue
        for entry, key in zip(re.split(r"\\\\|&", text), column.names, strict=True):
            (value,) = read_latex.sides(entry)
            expected, shown = floats([document.names[key].node, value])
            assert shown == pytest.approx(expected, rel=1e-9, abs=1e-9), entry


def table(name: str, key: str) -> dict[str, list[float]]:
    """Return the numbers of the table in a step of D'Alembert's lesson, by symbol."""
    step = next(s for section in lesson(name, formulation="dalembert").sections for s in section.steps if s.key == key)
    (values,) = (block for block in step.blocks if isinstance(block, Table))
    texts = {row[0].parts[0].name: [str(cell.parts[0]) for cell in row[1:]] for row in values.rows}
    return {key: [float(x.replace("−", "-")) for x in cells if x[-1] in "0123456789"] for key, cells in texts.items()}


@pytest.mark.long
@pytest.mark.mends("5.10")
@pytest.mark.parametrize(("name", "tied"), [("four_bar", 2), ("slider_crank", 2), ("spatial_slider_crank", 3)])
def test_the_equations_of_loops_are_written_before_they_are_used(name: str, tied: int) -> None:
    document = lesson_of(scene(name), formulation="dalembert")
    keys = [step.key for section in document.sections for step in section.steps]
    written = ("loops", "loops:rates", "loops:accelerations")
    formulas = [block for step, block in document.blocks() if step.key in written and isinstance(block, Formula)]
    assert len(formulas) == 3 * tied
    assert keys.index("loops") < keys.index("state")

    (values,) = (block for step, block in document.blocks() if step.key == "state")
    shown = {row[0].parts[0].name: float(row[1].parts[0].replace("−", "-")) for row in values.rows}
    for level, block in enumerate(formulas):
        graph = Graph()
        node = block.form.express(graph)
        used = {x: shown[str(x.value)] for x in reachable([node]) if x.op is Op.SYMBOL}
        assert any(str(x.value).endswith("_dot") for x in used) == (level >= tied)
        assert any(str(x.value).endswith("_ddot") for x in used) == (level >= 2 * tied)
        assert evaluate([node], Floats(), used)[0] == pytest.approx(0, abs=5e-3)
        away = {x: value + 0.3 * k for k, (x, value) in enumerate(used.items(), 1)}
        assert abs(evaluate([node], Floats(), away)[0]) > 0.01


def test_a_closed_mechanism_moves_as_its_loop_allows_and_the_ground_moves_its_momentum() -> None:
    state = {key: value[0] for key, value in table("four_bar", "state").items()}
    one = read(EXAMPLES / "four_bar.toml")
    w = Workspace(one)
    rows = differentiated(one, w.graph, w.state)
    values = {w.graph.symbol(key): value for key, value in state.items()}
    rates = [w.graph.total(g * u for g, u in zip(G, w.state.qd, strict=True)) for G in rows.G]
    pushes = [w.graph.total(g * a for g, a in zip(G, w.state.qdd, strict=True)) for G in rows.G]
    assert (state["phi_dot"], state["phi_ddot"]) == (1, 0.5)
    assert evaluate(rates, Floats(), values) == pytest.approx([0] * 5, abs=2e-3)
    assert evaluate([a + b for a, b in zip(pushes, rows.bias, strict=True)], Floats(), values) == pytest.approx(
        [0] * 5, abs=5e-3
    )

    found = {key: value[0] for key, value in table("four_bar", "reactions").items()}
    momentum = [w.graph.zero, w.graph.zero]
    placed = body_placements(one, w.graph)
    for body in one.bodies:
        at = placed[body.name].point(tuple(x.express(w.graph) for x in body.com))
        momentum = [p + body.mass.express(w.graph) * x for p, x in zip(momentum, at, strict=False)]
    pushed = tangents(tangents(momentum, w.state.velocity), w.state.acceleration)
    x, y = evaluate(pushed, Floats(), values)
    assert found["reaction:motor:0"] + found["reaction:pivot:0"] == pytest.approx(x, abs=1e-2)
    assert found["reaction:motor:1"] + found["reaction:pivot:1"] - 7.5 * 9.81 == pytest.approx(y, abs=2e-2)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "drive"), [("four_bar", "M"), ("slider_crank", "M"), ("governor", "T"), ("rsup", "M")]
)
def test_both_formulations_have_the_same_drives_in_numbers(name: str, drive: str) -> None:
    (first, second) = table(name, "formulations")[drive]
    assert first == second != 0


@pytest.mark.long
def test_a_freedom_that_nothing_drives_is_counted_and_needs_no_drive() -> None:
    ball = "drive:ball:2"
    step = next(
        s for s in lesson("spatial_slider_crank", formulation="dalembert").sections[3].steps if s.key == "count"
    )
    words = " ".join(str(part) for block in step.blocks if isinstance(block, Words) for part in block.parts)
    assert "Freedoms that nothing drives: 1 (written in joint ball)" in words
    assert "18 = 2 + 16" in words
    idle = {key: value for key, value in table("spatial_slider_crank", "reactions").items() if key.startswith("drive")}
    assert idle == {ball: [0]}


def test_errata_of_the_other_formulation_say_what_is_right_and_check_it() -> None:
    for name in ("two_link", "four_bar", "pendulum"):
        boxes = [b for _, b in lesson(name, formulation="dalembert").blocks() if isinstance(b, Box)]
        assert [re.findall(r"5\.\w+", str(box.title)) for box in boxes] == [
            [number] for number in ("5.1b", "5.1c", "5.3", "5.13", "5.14", "5.16")
        ]
    box = next(b for s, b in lesson("two_link", formulation="dalembert").blocks() if s.key == "errata:moved:link2")
    told = re.findall(r"[=≈] (−?[0-9.]*[0-9])", " ".join(map(str, box.blocks[-1].parts)))
    wrong, right = (float(x.replace("−", "-")) for x in told)
    state = table("two_link", "state")
    m, h1, h2, q2, u1, a1, a2 = (state[x][0] for x in ("m2", "h1", "h2", "q2", "q1_dot", "q1_ddot", "q2_ddot"))
    spin = -m * h2 * h2 * (a1 + a2)
    assert right == pytest.approx(spin - m * h2 * h1 * (a1 * cos(q2) + u1 * u1 * sin(q2)), rel=2e-3)
    assert wrong == pytest.approx(spin + m * h2 * h1 * sin(q2), rel=5e-3)  # (h1 s q1, -h1 c q1) for an acceleration


@pytest.mark.wide("two_link")
@pytest.mark.long
@pytest.mark.parametrize("name", ["two_link", "four_bar"])
def test_parts_of_the_other_formulation(name: str) -> None:
    parts = {
        until: walkthrough(scene(name), until=until, formulation="dalembert").sections
        for until in FORMULATIONS["dalembert"].until
    }
    before = 4 if scene(name).loops else 3  # scene, method, loops
    assert [len(sections) for sections in parts.values()] == [before, before + 1, before + 2, before + 4]
    ends = {until: [one.key for one in sections if one.key != "errata"][-1] for until, sections in parts.items()}
    assert all(end == until for until, end in ends.items())
    assert parts["formulations"][-1].key == "errata"
    with pytest.raises(EmitError, match="'energies' is no part of the formulation dalembert; there are count, bodies"):
        walkthrough(scene(name), until="energies", formulation="dalembert")


def test_a_wrong_drive_stops_the_lesson(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Energies, "driving_forces", lambda energy: [2 * energy.K for _ in energy.state.qd])
    with pytest.raises(AssertionError, match="the two formulations differ"):
        walkthrough(scene("two_link"), formulation="dalembert")


def test_a_wrong_formula_is_noticed() -> None:
    document = lesson("two_link")
    step, block = next((s, b) for s, b in document.blocks() if isinstance(b, Formula) and b.left == "k_z:1,1")
    wrong = replace(block, form=block.form.terms[0])
    left, right = Spelling(document).formula(wrong)
    truth, shown = floats([document.names["k_z:1,1"].node, reader(document).sides((left + right).replace("\v", ""))[1]])
    assert step.key == "coefficients:k_z"
    assert shown != pytest.approx(truth)


@pytest.mark.heavy("spatial_3r", "rrp", "scara", "double_pendulum")
@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_forms_are_worth_their_names(name: str) -> None:
    document = lesson(name)
    named = [block for _, block in document.blocks() if isinstance(block, Formula) and block.left]
    assert named
    for block in named:
        found = [block.form, *([block.right] if block.right is not None else [])]
        expected, *shown = floats([document.names[block.left].node, *(document.value(form) for form in found)])
        assert shown == pytest.approx([expected] * len(shown), rel=1e-9, abs=1e-9), block.left


@pytest.mark.heavy("spatial_3r")
@pytest.mark.long(0)
@pytest.mark.parametrize("name", ["two_link", "cart_pole", "spatial_3r"])
def test_bars_add_up_to_the_torque(name: str) -> None:
    charts = [block for _, block in lesson(name).blocks() if isinstance(block, Shares)]
    assert len(charts) == len(scene(name).velocities)
    for chart in charts:
        assert sum(bar.value for bar in chart.bars) == pytest.approx(chart.value)
        assert sum(bar.share for bar in chart.bars) == pytest.approx(1)


def test_damping_is_a_bar_and_takes_its_power() -> None:
    document = lesson("sprung")  # a damper in the joint, whose drive is M
    (chart,) = (block for _, block in document.blocks() if isinstance(block, Shares))
    labels = [text_of(bar.label) for bar in chart.bars]
    assert "0.2*phi_dot" in labels
    assert chart.total == Symbol("M")
    assert chart.bars[labels.index("0.2*phi_dot")].value == pytest.approx(0.2)  # at 1 rad/s
    power = next(b for s, b in document.blocks() if s.key == "power" and isinstance(b, Formula) and b.left == "d/dt E:")
    assert text_of(power.form) == "(M - 0.2*phi_dot)*phi_dot"
    step = next(s for section in document.sections for s in section.steps if s.key == "acting")
    kinds = [row[0].parts[0] for block in step.blocks if isinstance(block, Table) for row in block.rows]
    assert kinds == ["viscous damping", "spring", "spring"]


def test_the_terms_of_a_passive_joint_cancel() -> None:
    step = next(s for section in lesson("cart_pole").sections for s in section.steps if s.key == "torque:2")
    assert "no drive acts on" in "".join(map(str, step.claim.parts))


BALL = """
name = "ball"
gravity = [0, 0, -9.81]
[bodies]
a = { mass = 1, com = [0.2, 0, 0.1], inertia = [0.1, 0.2, 0.3], inertia_about = "com" }
b = { mass = 2, com = [0, 0.1, 0.3], inertia = [0.1, 0.2, 0.25], inertia_about = "com" }
[joints]
c = { type = "cylindrical", parent = "ground", child = "a", axis = [0, 0, 1] }
s = { type = "spherical", orientation = "zyx", parent = "a", child = "b", origin = [0.5, 0, 0] }
"""


@pytest.mark.long
def test_joints_of_several_freedoms_go_both_formulations() -> None:
    one = read_text(BALL, "ball")
    document = walkthrough(one, formulation="dalembert")  # proves that both formulations give the same drives
    assert "formulations" in [section.key for section in document.sections]
    drives = [key for key in document.names if key.startswith("tau")]
    assert drives == [f"tau{i}" for i in range(1, 6)]

    why = [b for s, b in walkthrough(one).blocks() if s.key == "meaning:k_D" and isinstance(b, Table)]
    told = {row[0].parts[0].name: str(row[2].parts[0]) for table in why for row in table.rows}
    assert told["k_D:1,2"] == told["k_D:2,2"] == "a slide is straight: "  # the way along the cylinder


ROD = """
name = "rod"
[bodies]
a = { mass = 1, com = [0.2, 0.1, 0.05] }
[joints]
c = { type = "rod", length = 0.5, orientation = "zyx", parent = "ground", child = "a" }
"""  # along axes of coordinates: in oblique ones its forms fill pages


@pytest.mark.wide(4)
@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in JOINTS if kind != "fixed"])
def test_every_type_of_joint_goes_dalemberts_formulation(kind: str) -> None:
    one = read_text(ROD, "rod") if kind == "rod" else jointed(kind, orientation="zyx")
    document = walkthrough(one, formulation="dalembert")  # which proves itself
    closed = ["loops"] if one.is_constrained else []
    keys = ["scene", "method", *closed, "count", "bodies", "reactions", "formulations", "errata"]
    assert [section.key for section in document.sections] == keys


COUPLED = """
name = "coupled"
gravity = [0, -9.81, 0]
[bodies]
a = { mass = 1, com = [1, 0, 0] }
b = { mass = 2, com = [1, 0, 0] }
[joints.j1]
type = "revolute"
parent = "ground"
child = "a"
axis = [0, 0, 1]
coordinate = "phi"
drive = "M"
force = "2*sin(3*t)"
[joints.j2]
type = "revolute"
parent = "a"
child = "b"
axis = [0, 0, 1]
origin = [2, 0, 0]
mimic = { joint = "j1", ratio = -2 }
"""


@pytest.mark.long(0)
def test_coupled_joints_and_forces_in_time_go_both_formulations() -> None:
    one = read_text(COUPLED, "coupled")
    first, second = walkthrough(one), walkthrough(one, formulation="dalembert")
    state = {row[0].parts[0]: row[1].parts[0] for s, b in first.blocks() if s.key == "state" for row in b.rows}
    assert state[Symbol("t")] == "0.4"
    chart = next(block for _, block in first.blocks() if isinstance(block, Shares))
    (drive,) = (row for s, b in second.blocks() if s.key == "formulations" and isinstance(b, Table) for row in b.rows)
    assert [cell.parts[0] for cell in drive[1:]] == [written(chart.value)] * 2


def test_languages_have_the_same_keys_and_places() -> None:
    english = language_of("en").lesson
    for language in languages():
        texts = language_of(language).lesson
        assert texts.keys() == english.keys(), language
        for key, text in texts.items():
            assert sorted(set(PLACE.findall(text))) == sorted(set(PLACE.findall(english[key]))), (language, key)
            assert "\\" not in text, "prose holds no LaTeX"


@pytest.mark.long(0)
def test_languages_differ_in_prose_only() -> None:
    english, slovak = lesson("two_link", "en"), lesson("two_link", "sk")
    assert [step.key for s in english.sections for step in s.steps] == [
        step.key for s in slovak.sections for step in s.steps
    ]
    (a,), (b,) = (rendered(one, "latex").values() for one in (english, slovak))
    assert displays(str(a)) == displays(str(b))
    assert "Kinetická energia" in str(b)
    assert "kinetic energy" not in str(b)


@pytest.mark.long(0)
def test_textbook_mode_numbers_every_equation() -> None:
    document = lesson("two_link")
    (tex,) = rendered(document, "latex").values()
    numbers = set(re.findall(r"\\tag\{([\d.]+)\}", str(tex)))
    assert numbers >= set(NUMBERS.values())
    boxes = [block for _, block in document.blocks() if isinstance(block, Box) and block.kind == "erratum"]
    assert len(boxes) == len(READS)
    others = {block.number for _, block in lesson("double_pendulum").blocks() if isinstance(block, Formula)}
    assert others == {"", "5.21", "5.22"}  # of every mechanism


def step_of(document: Document, key: str) -> Step:
    return next(step for section in document.sections for step in section.steps if step.key == key)


def test_equilibria_of_the_double_arm_are_its_four_vertical_positions() -> None:
    table, search = step_of(lesson("two_link"), "equilibria").blocks
    assert "Newton's method looked from 200 starts" in str(search.parts[0])
    stable = [row for row in table.rows if "stable" in row[2].parts]
    assert len(table.rows) == 4
    assert [row[0].parts + row[1].parts for row in stable] == [(Number.ZERO, Number.ZERO)]


def test_equilibria_with_springs_are_where_no_force_is_left() -> None:
    document = lesson("sprung")
    table = step_of(document, "equilibria").blocks[0]
    assert isinstance(table, Table)
    graph = document.graph
    force = document.names["k_G:1"].node + document.names["k_E:1"].node
    values = {graph.symbol(p.name): float(p.value.value) for p in document.scene.parameters}
    for (place,), *_ in ((row[0].parts, *row[1:]) for row in table.rows):
        angle = float(str(place).replace("−", "-"))
        (left,) = evaluate([force], Floats(), {**values, graph.symbol("phi"): angle})
        assert abs(left) < 0.02  # four digits of the angle
    assert len(table.rows) >= 1


def equilibria(text: str) -> tuple[list[Table[Words]], str]:
    """Return the tables of equilibria of a scene, and what is said about them."""
    found = walkthrough(read_text(text, "scene"))
    step = step_of(found, "equilibria")
    said = " ".join(str(part) for block in step.blocks if isinstance(block, Words) for part in block.parts)
    return [block for block in step.blocks if isinstance(block, Table)], said


@pytest.mark.parametrize("acting", ['force = "0.5*sin(3*t)"', 'motion = "0.3*sin(2*t)"', "motion = 0.3"])
def test_what_is_driven_in_time_has_no_equilibria(acting: str) -> None:
    found = walkthrough(read_text(SPRUNG.replace('drive = "M"', acting), "scene"))
    assert "after.rests" not in [section.key for section in found.sections]


@pytest.mark.long
def test_a_force_that_vanishes_at_rest_at_all_times_leaves_the_equilibria() -> None:
    tables, _ = equilibria(SPRUNG.replace('drive = "M"', 'force = "-2*phi_dot*t**2"'))
    assert tables == equilibria(SPRUNG)[0]
    assert tables


WOUND = """
name = "wound"
gravity = [0, "-g", 0]
[parameters]
g = 9.81
[bodies]
rod = { particles = [{ mass = 1, at = [1, 0, 0] }] }
[joints]
pivot = { type = "revolute", parent = "ground", child = "rod", axis = [0, 0, 1], coordinate = "phi" }
[springs.coil]
joint = "pivot"
stiffness = 0.5
"""


def test_all_equilibria_of_a_wound_spring_are_listed() -> None:
    (table,), said = equilibria(WOUND)
    found = [float(str(row[0].parts[0]).replace("−", "-")) for row in table.rows]
    # by hand: 0.5 phi + 9.81 cos(phi) = 0 has its roots in |phi| <= 19.62, and they are alternately stable
    fine = [-20 + 40 * (k + 0.5) / 40_001 for k in range(40_001)]
    signs = [0.5 * x + 9.81 * cos(x) > 0 for x in fine]
    expected = [a for a, before, after in zip(fine, signs, signs[1:], strict=False) if before != after]
    assert len(expected) > 10
    assert found == pytest.approx(expected, abs=6e-3)
    kinds = [str(row[1].parts[0]) for row in table.rows]
    assert kinds == ["stable", "unstable"] * (len(kinds) // 2) + ["stable"]
    assert "outside there may be others" in said


def test_a_constant_force_turns_the_stable_position_round() -> None:
    plain = WOUND.split("[springs", maxsplit=1)[0]
    up = '[loads.up]\nbody = "rod"\nat = [1, 0, 0]\nforce = [0, 20, 0]\n'
    for text, kinds in ((plain, {-1: "stable", 1: "unstable"}), (plain + up, {-1: "unstable", 1: "stable"})):
        (table,), said = equilibria(text)
        places = [text_of(row[0].parts[0]) for row in table.rows]
        assert sorted(places) == ["-pi/2", "pi/2"]
        for place, row in zip(places, table.rows, strict=True):
            assert row[1].parts == (kinds[-1 if place.startswith("-") else 1],)
        assert "a whole turn was searched" in said


def test_a_position_where_a_spring_has_no_length_is_no_equilibrium() -> None:
    cord = '[springs.cord]\nfrom = { body = "ground", at = [1, 0, 0] }\nto = { body = "rod", at = [1, 0, 0] }\n'
    (table,), _ = equilibria(WOUND.split("[springs", maxsplit=1)[0] + cord + "stiffness = 40\nfree = 0.5\n")
    places = [float(str(row[0].parts[0]).replace("−", "-")) for row in table.rows]
    assert len(places) == 3  # between the first two the force jumps
    for q in places:  # 9.81 cos q + k (d - 0.5) dd/dq with d = 2 |sin(q/2)|
        way = 1 if q > 0 else -1
        assert abs(9.81 * cos(q) + 40 * (2 * way * sin(q / 2) - 0.5) * way * cos(q / 2)) < 0.03


FOLLOWING = WOUND.replace(
    "[springs",
    """[bodies.second]
mass = 1
[joints.elbow]
type = "revolute"
parent = "rod"
child = "second"
axis = [0, 0, 1]
origin = [2, 0, 0]
mimic = { joint = "pivot", ratio = -2, offset = 0.5 }
[springs""",
)


@pytest.mark.parametrize("formulation", ["lagrange", "dalembert"])
def test_a_joint_that_follows_another_one_says_so(formulation: str) -> None:
    until = "energies" if formulation == "lagrange" else "count"
    document = walkthrough(read_text(FOLLOWING, "following"), until=until, formulation=formulation)
    steps = {step.key: step for section in document.sections for step in section.steps}
    joints = next(block for block in steps["joints"].blocks if isinstance(block, Table))
    position = "0.5 - 2*phi"
    assert [text_of(row[4].parts[0]) for row in joints.rows] == ["phi", position]
    (table,) = steps["acting"].blocks
    (row,) = [row for row in table.rows if row[0].parts == ("coupling",)]
    assert row[1].parts[0] == "joint elbow follows pivot: its coordinate is "
    assert text_of(row[1].parts[1]) == position
    if formulation == "dalembert":
        words = [str(block.parts[0]) for block in steps["count"].blocks if isinstance(block, Words)]
        assert any("A joint that follows another one (elbow)" in text for text in words)
        meanings = [row[1].parts for row in steps["unknowns"].blocks[0].rows]
        assert ("what keeps joint elbow coupled to joint pivot",) in meanings


def test_a_wrong_moment_of_inertia_stops_the_lesson(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meaning_room.Axis, "lever", lambda self, place: place)
    with pytest.raises(AssertionError, match="k_z:1,1 and J:1 differ"):
        walkthrough(scene("spatial_3r"))


@pytest.mark.long(0)
def test_until_and_detail_shorten() -> None:
    arm = scene("two_link")
    parts = [walkthrough(arm, until=until).sections for until in ("energies", "lagrangian", "equations")]
    assert [[s.key for s in found if s.key != "errata"][-1] for found in parts] == [
        "energies",
        "lagrangian",
        "equations",
    ]
    brief, full = walkthrough(arm), lesson("two_link")
    assert brief.sections == full.sections
    assert 2 * sum(len(s.steps) for s in brief.kept().sections) < sum(len(s.steps) for s in full.kept().sections)
    with pytest.raises(EmitError, match="until 'now' is no part of the formulation lagrange"):
        walkthrough(arm, until="now")


def test_long_expressions_of_large_scenes_are_folded() -> None:
    assert any(isinstance(block, Fold) for _, block in walkthrough(scene("scara"), until="equations").blocks())


def test_quaternions_are_told_what_would_work() -> None:
    for formulation in ("lagrange", "multipliers", "dalembert"):
        with pytest.raises(DerivationError, match=r'formulation="quaternions" .* orientation = "zyx"'):
            walkthrough(read(EXAMPLES / "heavy_top.toml"), formulation=formulation)


def test_closed_mechanisms_are_told_the_other_formulations() -> None:
    with pytest.raises(DerivationError, match=r'formulation="multipliers" .*, formulation="dalembert"'):
        walkthrough(read(EXAMPLES / "four_bar.toml"), formulation="lagrange")


@pytest.mark.parametrize(
    ("name", "formulation"),
    [("cart_pole", "lagrange"), ("four_bar", "multipliers"), ("heavy_top", "quaternions"), ("rssr", "quaternions")],
)
def test_a_lesson_takes_the_formulation_that_fits_its_scene(name: str, formulation: str) -> None:
    assert usual_formulation(read(EXAMPLES / f"{name}.toml")) == formulation


@pytest.mark.long(0)
def test_without_gravity_every_position_is_an_equilibrium() -> None:
    zero = Quantity.number(0)
    still = walkthrough(replace(scene("two_link"), gravity=(zero, zero, zero)))
    step = step_of(still, "equilibria")
    (said,) = step.blocks
    assert isinstance(said, Words)
    assert "Every position" in str(said.parts[0])


@pytest.mark.long(0)
def test_same_scene_same_bytes() -> None:
    first, second = (rendered(walkthrough(scene("cart_pole")), "md") for _ in range(2))
    assert first == second


@pytest.mark.long(0)
def test_command_writes_markdown_with_its_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["walkthrough", str(EXAMPLES / "cart_pole.toml"), "-o", str(tmp_path)]) == 0
    paths = capsys.readouterr().out.split()
    text = (tmp_path / "cart_pole.md").read_text(encoding="utf-8")
    for name in re.findall(r"!\[[^\]]*\]\(([^)]*)\)", text):
        assert str(tmp_path / name) in paths
        assert (tmp_path / name).read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.runs("pdflatex")
def test_pdf_is_built_and_the_same_every_time(tmp_path: Path) -> None:
    ((name, first),) = rendered(lesson("two_link", "sk"), "pdf").items()
    ((_, second),) = rendered(lesson("two_link", "sk"), "pdf").items()
    assert name == "two_link.pdf"
    assert isinstance(first, bytes)
    assert first.startswith(b"%PDF")
    assert first == second


def test_pictures_have_a_text_for_those_who_cannot_see_them() -> None:
    pictures = [block for _, block in lesson("two_link").blocks() if isinstance(block, Picture)]
    assert len({one.key for one in pictures}) == len(pictures) >= 2
    assert all(one.alt and one.caption.parts for one in pictures)


@pytest.mark.long
def test_a_lesson_that_nobody_would_read_is_refused_early() -> None:
    """A seven-axis arm: told before any step is written."""
    told = r"arm7: a lesson .* format=.sliders. .* symdyn generate"
    with counted() as calls, pytest.raises(DerivationError, match=told):
        walkthrough(scene("arm7"))

    assert calls.number < 700_000


@pytest.mark.long
@pytest.mark.parametrize("angle", ["atan2(l, h) - 2*(l/h)", "2*l/h", "sqrt(l/h + 1)*(l + h)/h", "l*(1 + l/h)/h"])
def test_an_angle_that_is_a_formula_of_lengths_is_read_again_from_what_is_printed(angle: str) -> None:
    text = f"""
    name = "tilted"
    gravity = [0, "-9.81", 0]
    parameters = {{ l = {{ unit = "m" }}, h = {{ unit = "m" }} }}
    bodies.arm.particles = [{{ mass = 1, at = ["l", "h", 1] }}]
    [joints.j]
    type = "revolute"
    parent = "ground"
    child = "arm"
    axis = [0, 0, 1]
    origin = {{ rpy = ["{angle}", 0, 0] }}
    """
    document = walkthrough(read_text(text, "tilted"))
    assert any("square" in step.key for section in document.sections for step in section.steps)


def test_torques_are_called_as_the_textbook_calls_them_and_its_form_stands_beside_ours() -> None:
    document = lesson("two_link")
    text = str(rendered(document, "md")["two_link.md"])
    assert "gives rise to the inertial torque $M_{z,11}$ in the axis $o_1$" in text
    assert "$M_{z,12}$ is the reaction torque in the axis $o_1$ that the acceleration $\\ddot q_2$ induces" in text
    assert "$M_{D,11}$ is the centripetal torque in the axis $o_1$; it is zero" in text
    assert r"- k_{C,1}^{(5.40)} \dot q_1 \dot q_2 - k_{D,12}^{(5.40)} \dot q_2^2 + k_{G,1}" in text
    assert text.count("Slovak textbook") == 1
    assert "the book " not in text
    forces = next(b for _, b in document.blocks() if isinstance(b, Picture) and b.key == "centrifugal")
    assert all(f">{one}" in forces.svg for one in "FMSo")
    assert "zotrvačného krútiaceho momentu" in str(rendered(lesson("two_link", "sk"), "md"))
