"""The whole system (5.18) as a picture of its matrix: rows equations, columns unknowns, blocks bodies and joints."""

from __future__ import annotations

from itertools import groupby

from symdyn.algebra import Form, Number
from symdyn.draw import Diagram, Text
from symdyn.emit.print import latex_symbols
from symdyn.graph import reachable
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.laws import LAW
from symdyn.teach.document import Block, Formula, Letter, Picture, Step
from symdyn.teach.mathematics import letter

FONT = Diagram.FONT
CELL = 2.1 * FONT
"""Side of a place in the matrix, units of the picture."""

FIXED, MOVING = "particle body0", "com"
"""Looks of entries: filled for what is constant, a ring for what changes with the position."""

RADIUS = 4.5


def system_step(lesson: Balance) -> Step:
    """Return A x + b = 0 with its picture, and what the picture says about the order of solving."""
    A = lesson.system.matrix()
    full = sum(not entry.is_zero for row in A for entry in row)
    look = {"A": Letter(r"\mathbf{A}"), "x": Letter(r"\mathbf{x}"), "b": Letter(r"\mathbf{b}")}
    s = {key: lesson.called(f"{LAW}system:{key}", one) for key, one in look.items()}
    places = {"rows": str(len(A)), "columns": str(len(lesson.unknowns)), "full": str(full)}
    places["all"] = str(len(A) * len(lesson.unknowns))
    title = lesson.text("system.alt", scene=lesson.scene.name, **places)
    picture = Picture(_drawn(lesson, title), lesson.say("system.caption"), title, "system")
    equation = Formula("", Form.sum((Form.product((s["A"], s["x"])), s["b"])), "5.18", Number.ZERO)
    blocks: tuple[Block, ...] = (equation, picture, lesson.say("system.count", **places))
    alone = ", ".join(lesson.scene.bodies[j].name for j in _alone(lesson)) if lesson.closed else ""
    key = "system.tree" if not lesson.closed else "system.some" if alone else "system.loops"
    reason = lesson.say(key, bodies=alone)
    return Step(f"{LAW}system", lesson.say("system.all", **s), blocks, reason, "(5.18)", show=("reactions",))


def _alone(lesson: Balance) -> list[int]:
    """Return the bodies whose own equations have no more unknowns than there are of them."""
    found: dict[int, int] = {}
    for j, _ in lesson.system.blocks:
        found[j] = found.get(j, 0) + 1
    return [j for j in range(len(lesson.scene.bodies)) if found.get(j, 0) <= len(lesson.system.kept)]


def _drawn(lesson: Balance, title: str) -> str:
    """Return the picture."""
    sheet, A, system = Diagram(title, "system"), lesson.system.matrix(), lesson.system
    spelled = latex_symbols(lesson.scene)
    moving = {*lesson.state.q}
    lefts, left = [], 0.0
    for joint, group in groupby(range(len(system.unknowns)), key=lambda u: system.unknowns[u].joint):
        columns, name = list(group), Text.as_written(joint)
        width = max(len(columns) * CELL, name.width + FONT)
        sheet.text(name, left + width / 2, -2.6 * FONT)
        for k, u in enumerate(columns):
            lefts.append(left + (k + 0.5) * width / len(columns))
            sheet.text(_unknown(lesson, u, spelled), lefts[-1], -1.1 * FONT)
        left += width
        sheet.line("leader", [(left, -3.2 * FONT), (left, len(A) * CELL)])
    each = len(system.kept)
    for j, body in enumerate(lesson.scene.bodies):
        name = Text.as_written(body.name)
        sheet.text(name, -4.2 * FONT - name.width / 2, (each * j + each / 2) * CELL)
        for k, (kind, axis) in enumerate(lesson.axes):
            y = (each * j + k + 0.5) * CELL
            sheet.text(Text.of_name(f"{lesson.letters.latex(kind)}_{axis}"), -1.6 * FONT, y)
            for u, x in enumerate(lefts):
                entry = A[each * j + k][u]
                if not entry.is_zero:
                    changes = not moving.isdisjoint(reachable([entry]))
                    sheet.dot(MOVING if changes else FIXED, (x, y), RADIUS)
        bottom = each * (j + 1) * CELL
        sheet.line("leader", [(-3.4 * FONT, bottom), (left, bottom)])
    sheet.line("stem", [(0.0, 0.0), (left, 0.0), (left, len(A) * CELL), (0.0, len(A) * CELL), (0.0, 0.0)])
    return sheet.svg("system-")


def _unknown(lesson: Balance, u: int, spelled: dict[str, str]) -> Text:
    """Return the name of an unknown without its joint, which stands above its block."""
    key = lesson.unknowns[u].name
    look = lesson.names[key].look if key in lesson.names else None
    if isinstance(look, Letter):
        return Text.of_name(letter(Letter(look.letter, look.index[1:])))
    return Text.of_name(spelled[key])
