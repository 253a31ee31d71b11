"""Lessons of scenes with states of their own: what is known, where all rests, which energy a state stores."""

from __future__ import annotations

from math import tanh

import pytest
from lessons import lesson_of

import symdyn
from symdyn.algebra import Form, Symbol
from symdyn.algebra.numeric import Floats
from symdyn.emit.print import text_of
from symdyn.graph import Op, evaluate, gradient, reachable
from symdyn.scene import parse
from symdyn.table import Table
from symdyn.teach.document import Document, Formula, Step


def lesson(name: str) -> tuple[Document, dict[str, Step]]:
    document = lesson_of(symdyn.example(name))
    return document, {step.key: step for section in document.sections for step in section.steps}


def said(step: Step) -> str:
    return " ".join(str(x) for one in (step.claim, *step.blocks, step.reason) for x in getattr(one, "parts", ()))


def test_states_are_not_known_and_their_forces_are_told() -> None:
    _, steps = lesson("dc_motor")
    known = str(steps["task"].blocks[0])
    assert "'wanted'" in known
    assert not [name for name in ("'i'", "'n'") if name in known]
    assert "Forces that depend on" in said(steps["task"])
    (table,) = (block for block in steps["acting"].blocks if isinstance(block, Table))
    assert "theta_dot" in str(table.rows[0][1])


def test_a_motor_rests_where_its_current_holds_the_weight() -> None:
    document, steps = lesson("dc_motor")
    current, angle = steps["states:rest"].blocks
    assert isinstance(current, Formula)
    assert current.right == Symbol("wanted")
    value = next(x for x in getattr(angle, "parts", ()) if isinstance(x, Form) and "wanted" in x.symbols)
    at = {"k": 0.08, "wanted": 5.0, "m": 0.5, "l": 0.3}
    (found,) = evaluate([value.express(document.graph)], Floats(), {document.graph.symbol(x): y for x, y in at.items()})
    assert float(found) == pytest.approx(5 * 0.08 / (9.81 * 0.5 * 0.3))
    (table,) = (block for block in steps["equilibria"].blocks if isinstance(block, Table))
    assert [str(cell.parts[0]) for cell in table.rows[0][:3]] == ["0.2753 rad", "5 A", "0.01532 A s"]


def test_the_state_of_a_lesson_has_the_rates_of_states() -> None:
    _, steps = lesson("dc_motor")
    table = steps["state"].blocks[0]
    assert isinstance(table, Table)
    told = {str(row[0].parts[0]): str(row[1].parts[0]) for row in table.rows}
    i, n, theta_dot = 1.0, 0.8, 1.0
    rate = (24 * tanh((2 * (5 - i) + 400 * n) / 24) - 1.2 * i - 0.08 * theta_dot) / 0.004
    assert float(told[str(Symbol("d/dt i"))]) == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize(("name", "energy"), [("dc_motor", "L*i**2/2"), ("caster", "C*s*alpha**2/2")])
def test_what_a_state_stores_is_found_by_the_power_that_it_exchanges(name: str, energy: str) -> None:
    document, steps = lesson(name)
    _, change = steps["states:energy"].blocks
    assert isinstance(change, Formula)
    scene, graph = symdyn.example(name), document.graph
    stored = parse(energy).express(graph)
    rates = {graph.symbol(one.name): one.rate.express(graph) for one in scene.states}
    (state,) = (x for x in rates if not gradient(stored, [x])[0].is_zero)
    force = scene.joints[0].forces[0].express(graph)
    u = graph.symbol(scene.velocities[0])
    damping = scene.joints[0].damping.express(graph) * u * u
    power = force * u - damping + gradient(stored, [state])[0] * rates[state]
    values = {x: 0.3 + 0.1 * k for k, x in enumerate(reachable([power])) if x.op is Op.SYMBOL}
    left, right = (float(x) for x in evaluate([change.form.express(graph), power], Floats(), values))
    assert left == pytest.approx(right)


def test_nothing_is_told_of_rest_where_a_force_keeps_it_from_resting() -> None:
    assert "states:rest" not in lesson("drive")[1]


def test_nothing_is_stored_where_force_and_rate_exchange_no_power() -> None:
    assert "states:energy" not in lesson("actuator")[1]


def test_decimals_of_the_scene_stay_decimals_where_an_equation_is_solved() -> None:
    _, steps = lesson("dc_motor")
    (form,) = (block.right for block in steps["explicit"].blocks if isinstance(block, Formula))
    assert form is not None
    assert text_of(form) == "(k*i - b*theta_dot - 9.81*m*l*sin(theta))/(m*l**2)"
