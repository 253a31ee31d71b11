"""Inverse kinematics of an arm in a lesson: the steps of `symdyn.emit.print.arm_page`, and the geometry behind them."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.algebra import Form, Symbol
from symdyn.dynamics.outputs import BRANCHES
from symdyn.emit.print import ArmStep, PrintName, arm_steps, latex_symbols
from symdyn.errors import DerivationError
from symdyn.teach.document import Formula, Letter, Step, Words
from symdyn.teach.lesson import Prose, together


def inverse_kinematics_steps(lesson: Prose) -> Iterator[Step]:
    """Yield how the angles of the first arm with a closed form are found; nothing where there is none."""
    for end in lesson.scene.points or lesson.scene.bodies:
        try:
            told = list(arm_steps(lesson.scene, end.name))
        except DerivationError:
            continue
        yield from (_step(lesson, end.name, one) for one in told)
        return


def _step(lesson: Prose, end: str, told: ArmStep) -> Step:
    own = {name for row in told.rows for name in (row.name, *row.form.symbols)}
    own |= {x for names in told.names.values() for x in names}
    for name in sorted(own - latex_symbols(lesson.scene).keys()):
        look = PrintName.of_code(name)
        below = (look.subscript,) if look.subscript else ()
        lesson.called(name, Letter(look.head, below, accent="bar" if name.endswith("_") else ""))  # d3 is the scene's
    places: dict[str, Words | Form | str] = {x: together([*map(Symbol, y)]) for x, y in told.names.items()}
    blocks = tuple(Formula(row.name, row.form) for row in told.rows)
    if told.title:
        first, *more = told.keys
        reason = lesson.say(f"arm.{more[0]}", **places) if more else Words(())
        return Step(f"arm:{told.title}", lesson.say(f"arm.{first}", q=Symbol(told.title), **places), blocks, reason)
    kind = "wrist" if len(told.names["parallel"]) < len(told.names["meeting"]) else "parallel"
    places |= {"end": end, "branches": str(BRANCHES)}
    return Step(
        "arm", lesson.say("arm.pose", **places), (lesson.say(f"arm.{kind}", **places),), lesson.say("arm.reach")
    )
