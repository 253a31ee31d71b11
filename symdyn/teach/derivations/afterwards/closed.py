"""Steps for mechanisms with loops or rolling: rests, and the steady motion next to the start, both in numbers.

What is found is what `symdyn linearize` finds: eigenvalues of the motion that loops and rolling leave free.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from symdyn.algebra import Symbol
from symdyn.errors import DerivationError, DrawError, LinearizeError, SimulateError
from symdyn.linear import Equilibrium, Linearization, rests, steady_at_start
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.afterwards.equilibria import families
from symdyn.teach.document import Block, Section, Step, Words
from symdyn.teach.lesson import Prose, together

FAULTS = (LinearizeError, SimulateError, DerivationError, DrawError, ArithmeticError)
"""What says that there is no one linear motion, such as at a parameter without a value."""

MOVES = 1e-9
"""Rates, rad/s or m/s, that are none."""


def closed_sections(lesson: Prose) -> list[Section]:
    """Return where a mechanism with loops or rolling rests, and how it can go on steadily; none where neither is."""
    rest, idle = _rests(lesson)
    steps = [step for step in (rest, _steady(lesson, idle)) if step is not None]
    return [lesson.section("after.rests", steps)] if steps else []


def _rests(lesson: Prose) -> tuple[Step | None, Sequence[str]]:
    """Return where it rests, None where that is everywhere, and coordinates that do not matter."""
    try:
        found = rests(lesson.scene)
        systems = found.systems
    except FAULTS:
        return None, ()
    if len(found.idle) == len(lesson.scene.coordinates):
        return None, found.idle
    of = "closed" if lesson.scene.is_closed else "open"
    searched = lesson.say(f"{of}.search", starts=str(found.starts))
    blocks: list[Block] = [_places(lesson, found.places, found.idle, systems)] if systems else []
    if found.crossings:
        blocks += [lesson.say("closed.crossings"), _places(lesson, found.crossings, found.idle)]
    blocks += [searched] if blocks else [lesson.say("equilibria.none"), searched]
    if found.idle:
        blocks.append(lesson.say("closed.idle", names=together([Symbol(name) for name in found.idle])))
    blocks += families(lesson, found.places, found.more)
    reason = lesson.say(f"{of}.reason")
    step = Step("equilibria", lesson.say("equilibria"), tuple(blocks), reason, show=("weights", "forces"))
    return step, found.idle


def _places(
    lesson: Prose, places: Sequence[Equilibrium], idle: Sequence[str], systems: Sequence[Linearization] = ()
) -> Block:
    """Return the table of places, without coordinates that do not matter, and what eigenvalues of systems there say."""
    scene, units = lesson.scene, SceneUnits(lesson.scene).coordinates
    shown = [k for k, q in enumerate(scene.coordinates) if q not in idle]
    rows: list[list[str | Words]] = [
        [_with_unit(lesson, float(place.q[k]) + 0.0, units[k]) for k in shown] for place in places
    ]
    for row, one in zip(rows, systems, strict=False):  # there may be none
        row += [lesson.say(f"closed.{one.stability.verdict}"), eigenvalues(lesson, _moving(one))]
    heads = ("equilibria.kind", "closed.values") if systems else ()
    return lesson.table([*(Symbol(scene.coordinates[k]) for k in shown), *heads], rows)


def _steady(lesson: Prose, idle: Sequence[str]) -> Step | None:
    """Return the steady motion next to the start, None where it starts at rest or there is none.

    Coordinates that do not matter, `idle`, are not listed.
    """
    scene = lesson.scene
    try:
        found = steady_at_start(scene)
    except FAULTS:
        return None
    if found is None:
        return None
    one, turning = found
    units, rates = SceneUnits(scene).coordinates, SceneUnits(scene).velocities
    moving = np.abs(turning) > MOVES
    free = {*one.dropped, *one.cyclic, *idle}
    q = [k for k, name in enumerate(scene.coordinates) if not (name in free or moving[k] or units[k] == "1")]
    u = [k for k, x in enumerate(one.point.u) if abs(x) > MOVES]
    rows = [(Symbol(scene.coordinates[k]), _with_unit(lesson, float(one.point.q[k]), units[k])) for k in q]
    rows += [(Symbol(scene.velocities[k]), f"{lesson.written(float(one.point.u[k]))} {rates[k]}/s") for k in u]
    verdict = lesson.say(f"closed.{one.stability.verdict}")
    told = lesson.say("closed.next", kind=verdict, values=eigenvalues(lesson, _moving(one)))
    blocks = (lesson.table(("table.symbol", "table.value"), rows), told)
    return Step(
        "steady", lesson.say("closed.steady"), blocks, lesson.say("closed.steady.reason"), show=("centrifugal",)
    )


def _with_unit(lesson: Prose, x: float, unit: str) -> str:
    return lesson.written(x) if unit == "1" else lesson.scene.in_shown_unit(lesson.written(x), unit)


def eigenvalues(lesson: Prose, values: Iterable[complex]) -> str:
    """Return eigenvalues in print, 1/s, of a pair the one above; "0" where there are none."""
    told = []
    for x in values:
        real = lesson.written(x.real) if not x.imag or abs(x.real) > 1e-9 * abs(x) else ""
        told.append(f"{real} ± {lesson.written(x.imag)} i".strip() if x.imag else real)
    return "; ".join(told) or "0"


def _moving(one: Linearization) -> list[complex]:
    """Return the eigenvalues that are not zero."""
    return [mode.value for mode in one.modes if mode.value]
