"""The state that the lesson shows, what the equations are worth there, and what stays constant."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

from symdyn.algebra import Form, Symbol
from symdyn.teach.derivations.quaternions.turning import Turning
from symdyn.teach.document import Step
from symdyn.teach.lesson import together
from symdyn.teach.shown_state import Chosen, choose_state

TURNED = (0.8, 0.4, 0.2, 0.4)
"""A unit quaternion none of whose components hides anything."""


def choose_turned(lesson: Turning) -> Chosen:
    """Return the state of all lessons with every quaternion turned away from where it hides something."""
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
    values = dict(chosen.values)
    for sphere in lesson.spheres:
        e = [values[x] for x in sphere]
        if min(map(abs, e)) < 1e-6 or abs(sqrt(sum(x * x for x in e)) - 1) > 1e-9:
            values |= dict(zip(sphere, TURNED, strict=True))
    return replace(chosen.moved(values), q=tuple(values[q] for q in lesson.state.q))


def conserved_steps(lesson: Turning) -> list[Step]:
    """Return a step for every quaternion whose momentum about the turned axes keeps its size, as without moments."""
    if lesson.ties:
        return []
    steps = []
    for joint in lesson.balls:
        first = lesson.first(joint) + len(joint.rates) - 3
        own = range(first, first + 3)
        free = all(lesson.scene.drives[i] is None and lesson.acting[i].is_zero for i in own)
        graph = lesson.graph
        turning = graph.total(lesson.p[i] * (lesson.p_rates[i] - lesson.needed[i]) for i in own)
        if not free or not lesson.vanishes(turning):
            continue
        square: Form = Form.sum(Symbol(f"p:{i + 1}").power(2) for i in own)
        assert square.terms, "a sum of squares has terms"
        momenta = together([Symbol(f"p:{i + 1}") for i in own])
        said = lesson.say("conserved", joint=joint.name, square=square)
        steps.append(Step(f"conserved:{joint.name}", said, (), lesson.say("conserved.reason", momenta=momenta)))
    return steps
