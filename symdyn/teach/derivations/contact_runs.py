"""The section of a lesson on contacts: its steps in order, a run through what happens, and what follows from series.

What a run finds at its first impact is held against the formulas of the lesson.

    g̈ = -a:  a flight takes 2 ġ⁺/a, the next one e times as long;  all of them 2 ġ⁺/(a (1 - e))
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symdyn import simulation
from symdyn.algebra import Form, Number
from symdyn.dynamics import Workspace
from symdyn.dynamics.outputs import contact_equations, lacks_modes, with_modes
from symdyn.errors import SymdynError
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene import Scene, SceneUnits
from symdyn.teach.derivations.contact_laws import law_steps, limit_steps
from symdyn.teach.derivations.contacts import MINUS, ONE, Struck
from symdyn.teach.derivations.elsewhere import elsewhere
from symdyn.teach.derivations.joint_percussions import joint_steps
from symdyn.teach.derivations.lagrange import scene_picture
from symdyn.teach.derivations.precession import NO_FORM, lowest, shortened
from symdyn.teach.derivations.solved import Quotients, vanishing
from symdyn.teach.document import Block, Box, Document, Formula, Letter, Picture, Section, Step, Words
from symdyn.teach.lesson import Lesson, Prose
from symdyn.teach.played import played
from symdyn.teach.shown_state import Chosen, choose_state, picture_letters

BEHIND = ("explicit", "equations", "by.equations", "reactions")
"""Sections behind which contacts stand, the first that there is."""

HORIZONS, LONGEST_RUN = (2.0, 20.0), 120.0
"""s: until when a run looks for what happens, and how long it may be until flights end."""

STRIKES = ("strikes", "becomes taut")
"""Events that are impacts, of contacts and of ropes."""

EVENTS = 6
"""Events of a run that are listed."""

JUST_BEFORE = 1e-12
"""s: how long before an impact its state is read."""

AGREE = 1e-6
"""Of a formula and a run, relative."""


def without_contacts(scene: Scene) -> Scene:
    """Return a scene that is open and does not stick, with letters that keep the units that contacts tell."""
    if not lacks_modes(scene):
        return scene
    told = SceneUnits(scene).inferred
    parameters = tuple(one if one.unit else replace(one, unit=told[one.name]) for one in scene.parameters)
    others = tuple(one for one in scene.elements if one not in scene.unilaterals)
    return replace(scene, parameters=parameters, joints=with_modes(scene).joints, elements=others)


def with_contacts(document: Document, scene: Scene) -> Document:
    """Return a lesson with what is said of contacts, stops and dry friction, behind the equations if it has them.

    Args:
        document: of an open mechanism.
        scene: the same with its contacts.
    """
    place = next((k for key in BEHIND for k, one in enumerate(document.sections) if one.key == key), None)
    if place is None or scene.is_constrained or any(joint.velocities for joint in scene.joints):
        return document
    w = Workspace(scene)
    touches = contact_equations(w, w.zeros, False).touches
    if not touches:
        return document
    lesson = Lesson(document.scene, document.language, dict(document.names), graph=document.graph)
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph)
    several = len(touches) > 1
    struck = [Struck(lesson, one, str(k) if several else "", chosen) for k, one in enumerate(touches, 1)]
    steps = [*(one.rates() for one in struck), *law_steps(lesson, struck)]
    run = None if elsewhere(lesson, "run") else _followed(scene, chosen)
    if not lesson.scene.prescribed_velocities:
        told = set[tuple[bool, int, str]]()
        for one in struck:
            found = (*one.impact(), *limit_steps(one, scene), *joint_steps(one))
            steps += [replace(step, key=f"more.{step.key}") if one.kind in told else step for step in found]
            told.add(one.kind)
        steps += _numbers(lesson, struck, scene, run)
    section = lesson.section("contacts", steps)
    letters = picture_letters(lesson.scene, lesson.graph, chosen)
    shown = scene_picture(Prose(scene, lesson.language), chosen, letters)
    sections = (*document.sections[: place + 1], section, *document.sections[place + 1 :])
    frictions = [chosen.of(*(x.express(lesson.graph) for x in (one.static, one.mu))) for one in struck]
    shows = played(scene, list(zip(touches, frictions, strict=True)), chosen.parameters, run)
    pictured = tuple(_pictured(x, shown) for x in sections)
    return replace(document, sections=pictured, names=lesson.names, played=shows)


def _pictured(section: Section, shown: Picture) -> Section:
    """Return a section with the picture of the mechanism replaced, such as by one with its planes."""
    steps = (
        replace(x, blocks=tuple(shown if isinstance(y, Picture) and y.key == shown.key else y for y in x.blocks))
        for x in section.steps
    )
    return replace(section, steps=tuple(steps))


def _followed(scene: Scene, chosen: Chosen, until: Sequence[float] = HORIZONS) -> simulation.Trajectory | None:
    """Return a run from the scene's start through what happens first, if something does; None where nothing runs."""
    values = {one.name: chosen.parameters[one.name] for one in scene.free_parameters}
    run = None
    for end in until:
        try:
            run = simulation.simulate(scene, until=end, values=values or None, say=lambda line: None)
        except SymdynError:
            return None
        if run.impacts:
            break
    return run


def _numbers(
    lesson: Lesson, struck: Sequence[Struck], scene: Scene, run: simulation.Trajectory | None
) -> Iterator[Step]:
    """Yield what happens in a run, whether the formulas say the same of its first impact, and flights without end."""
    if left_out := elsewhere(lesson, "run"):
        yield Step("contacts:run", left_out, ())
        return
    if run is None or not run.impacts:
        return
    first = next((event for event in run.impacts if event.what in STRIKES), None)
    rows = list[list[str | Words]]()
    for event in run.impacts[:EVENTS]:
        what = lesson.say(f"contacts.event.{event.what}", contact=event.contact)
        told = (event.before, f"{event.unit}/s"), (event.after, f"{event.unit}/s"), (event.lost, "J")
        numbers = [_shown(lesson, x, unit) if event.what in STRIKES else "" for x, unit in told]
        rows.append([_shown(lesson, event.t, "s"), what, *(numbers if first else ())])
    heads = ["contacts.time", "contacts.event"]
    heads += ["contacts.rate.before", "contacts.rate.after", "contacts.lost"] if first else []
    blocks: list[Block] = [lesson.table(heads, rows)]
    one = next((x for x in struck if first is not None and x.name == first.contact), None)
    if first and first.impulse[0] and one and one.columns is not None and len(one.touch.tangents) < 2:
        agree = _agree(one, run, _just_before(one, run, first.t))
        assert agree or len(struck) > 1, "an impact that its formulas do not tell"
        key = "together" if not agree else "agrees.rough" if one.has_friction else "agrees"
        said = lesson.say(f"contacts.{key}", contact=one.name)
        blocks.append(Box("check", lesson.say("check.title"), (said,)))
    yield Step("contacts:run", lesson.say("contacts.run"), tuple(blocks), lesson.say("contacts.run.reason"))
    if first is not None and one is not None and len(struck) == 1 and not one.has_friction:
        yield from _flights(one, scene, first.t, first.after)


def _shown(lesson: Lesson, value: float, unit: str) -> str:
    """Return a number of a run with its unit, as if it had no errors of rounding."""
    return lesson.scene.in_shown_unit(lesson.about(float(f"{value:.9g}") if abs(value) > AGREE**2 else 0.0), unit)


def _agree(one: Struck, run: simulation.Trajectory, here: Chosen) -> bool:
    """Tell whether the first impact of a run is as formulas say at the state before it; with friction, as D says."""
    assert one.columns is not None, "asked for where there are forms"
    graph, size, first = one.lesson.graph, len(one.rows), next(x for x in run.impacts if x.what in STRIKES)
    v, d = np.split(np.array(here.of(*one.speeds, *(x.express(graph) for row in one.columns[1] for x in row))), [size])
    D, impulse = d.reshape(size, size), np.array(first.impulse[:size])
    e, mu = here.of(one.e.express(graph), one.mu.express(graph))
    after = v + D @ impulse
    apart = [(after[0] - first.after) / v[0], (impulse @ (v + after) / 2 + first.lost) / (impulse[0] * v[0])]
    apart += [abs(impulse[1]) / impulse[0] - mu] if one.has_friction else [(1 + e) * v[0] / D[0, 0] / impulse[0] + 1]
    return bool(np.all(np.abs(apart[:2]) <= AGREE) and apart[2] <= AGREE)


def _just_before(one: Struck, run: simulation.Trajectory, t: float) -> Chosen:
    """Return the state of a run just before a time."""
    state, at = one.lesson.state, run(max(t - JUST_BEFORE, 0.0))
    values = dict(zip((*state.q, *state.qd), (*at.q.ravel(), *at.qd.ravel()), strict=True))
    return one.chosen.with_values({x: float(value) for x, value in values.items()})


def _flights(one: Struck, scene: Scene, t: float, after: float) -> Iterator[Step]:
    """Yield the series of flights where the gap has a constant acceleration while it is open."""
    lesson = one.lesson
    bounce = one.chosen.of(one.e.express(lesson.graph))[0]
    fall = _acceleration(one)
    if fall is None or not 0 < bounce < 1:
        return
    (a,) = one.chosen.of(fall)
    total = 2 * after / (a * (1 - bounce)) if a > 0 else math.inf
    if t + total > LONGEST_RUN:
        return
    run = _followed(scene, one.chosen, [1.2 * (t + total)])
    rest = None if run is None else run.impacts[-1].rest
    assert rest is not None, "flights without end end within the run"
    assert abs(rest - t - total) <= AGREE * rest, "flights that do not end as their series does"
    rate = lesson.called("gap.rate:after", Letter("g", dots=1, above="+"))
    pushed, two = shortened(lesson, fall), Number(Fraction(2))
    flight, whole = (lesson.called(f"flight:{k}", Letter(r"\Delta t", (k,) if k else ())) for k in ("1", ""))
    high, later = lesson.called("height:1", Letter("h", ("1",))), lesson.called("height:+", Letter(r"\mathit{h}_{n+1}"))
    less = Form.sum((ONE, Form.product((MINUS, one.e))))
    under = Form.product((pushed, Number(1 - one.e.value) if isinstance(one.e, Number) else less))
    blocks = (
        Formula(flight.name, Form.product((two, rate, pushed.power(-1)))),
        lesson.say("contacts.flights.heights", e=one.e),
        Formula(high.name, Form.product((rate.power(2), two.power(-1), pushed.power(-1)))),
        Formula(later.name, Form.product((one.e.power(2), lesson.called("height:n", Letter("h", ("n",)))))),
        lesson.say("contacts.flights.then", e=one.e, first=rate),
        Formula(whole.name, Form.product((two, rate, under.power(-1)))),
    )
    numbers = {"t": _shown(lesson, t, "s"), "rest": _shown(lesson, rest, "s")}
    box = Box("check", lesson.say("check.title"), (lesson.say("contacts.flights.check", **numbers),))
    claim = lesson.say("contacts.flights", contact=one.name, acceleration=pushed.negative, rate=rate)
    yield Step("impact:flights", claim, (*blocks, box), lesson.say("contacts.flights.reason"))


def _acceleration(one: Struck) -> Expr | None:
    """Return -g̈ of an open contact without drives where it is made of parameters alone; else None."""
    lesson, state = one.lesson, one.lesson.state
    if any(lesson.scene.drives):
        return None
    told = vanishing(lesson, range(state.n), {})
    M, h = [gradient(x, state.qdd) for x in told], substitute(told, dict.fromkeys(state.qdd, lesson.graph.zero))
    try:
        write = Quotients(lesson, [*(x for row in M for x in row), *h])
        found = write.field.solved([[write.known[x] for x in row] for row in M], [[write.known[x]] for x in h])
        slower = [-write.field.form(x).express(lesson.graph) for (x,) in found]
        (change,) = tangents([one.speeds[0]], state.acceleration)
        fall = lowest(-substitute([change], dict(zip(state.qdd, slower, strict=True)))[0])
    except NO_FORM:
        return None
    return None if {*state.q, *state.qd}.intersection(reachable([fall])) else fall
