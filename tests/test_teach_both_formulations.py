"""D'Alembert's lesson beside Lagrange's: the same drives, and what each of them says of loops, joints and couplings."""

from __future__ import annotations

import re
from math import cos, sin

import pytest
from lessons import lesson_of, step_of
from mechanisms import jointed
from test_teach_equilibria import WOUND
from test_teach_walkthrough import EXAMPLES, lesson, scene

from symdyn.algebra.form import Symbol
from symdyn.algebra.numeric import Floats
from symdyn.dynamics import Energies, Workspace
from symdyn.dynamics.loops.constraint_rows import differentiated
from symdyn.dynamics.mechanism.state import body_placements
from symdyn.emit.print.formula_text import text_of
from symdyn.errors import EmitError
from symdyn.graph import Graph, Op, evaluate, reachable, tangents
from symdyn.scene import read
from symdyn.scene.joints import JOINTS
from symdyn.scene.toml import read_text
from symdyn.table import Table
from symdyn.teach import walkthrough
from symdyn.teach.document import Box, Formula, Shares, Words
from symdyn.teach.mathematics import written
from symdyn.teach.render.handout import FORMULATIONS

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


ROD = """
name = "rod"
[bodies]
a = { mass = 1, com = [0.2, 0.1, 0.05] }
[joints]
c = { type = "rod", length = 0.5, orientation = "zyx", parent = "ground", child = "a" }
"""  # along axes of coordinates: in oblique ones its forms fill pages


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


def table(name: str, key: str) -> dict[str, list[float]]:
    """Return the numbers of the table in a step of D'Alembert's lesson, by symbol."""
    step = step_of(lesson(name, formulation="dalembert"), key)
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


@pytest.mark.wide(4)
@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in JOINTS if kind != "fixed"])
def test_every_type_of_joint_goes_dalemberts_formulation(kind: str) -> None:
    one = read_text(ROD, "rod") if kind == "rod" else jointed(kind, orientation="zyx")
    document = walkthrough(one, formulation="dalembert")  # which proves itself
    closed = ["loops"] if one.is_constrained else []
    keys = ["scene", "method", *closed, "count", "bodies", "reactions", "formulations", "errata"]
    assert [section.key for section in document.sections] == keys


@pytest.mark.long(0)
def test_coupled_joints_and_forces_in_time_go_both_formulations() -> None:
    one = read_text(COUPLED, "coupled")
    first, second = walkthrough(one), walkthrough(one, formulation="dalembert")
    state = {row[0].parts[0]: row[1].parts[0] for s, b in first.blocks() if s.key == "state" for row in b.rows}
    assert state[Symbol("t")] == "0.4"
    chart = next(block for _, block in first.blocks() if isinstance(block, Shares))
    (drive,) = (row for s, b in second.blocks() if s.key == "formulations" and isinstance(b, Table) for row in b.rows)
    assert [cell.parts[0] for cell in drive[1:]] == [written(chart.value)] * 2


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
