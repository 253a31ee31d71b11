"""Steps: what is known and wanted; Lagrange's equations (5.21), (5.22), from which every later step is derived.

The index i in them stands for any coordinate: these names have no value, and tests put each coordinate in their place.
"""

from __future__ import annotations

from symdyn.algebra import Form, Number, Symbol
from symdyn.dynamics.mechanism import generalized_forces
from symdyn.emit.print import Printable
from symdyn.scene import SceneUnits
from symdyn.teach.document import Block, Formula, Letter, Name, Step, Words
from symdyn.teach.lesson import Lesson, named, together

ANY = ("q:i", "q_dot:i", "Q:i", "QA:i")
"""Keys of any coordinate, its rate, its generalized force, and the part of that which is not of P."""


def task_step(lesson: Lesson) -> Step:
    """Return what is known and what is wanted."""
    scene = lesson.scene
    moving = together([Symbol(q) for q in scene.coordinates])
    given = together([Symbol(p.name) for p in scene.parameters])
    driven = [Symbol(drive) for drive in scene.drives if drive]
    ways = lesson.state.q if len(lesson.state.q) == lesson.state.n else lesson.state.qd  # a quaternion has no drives
    passive = [named(q) for q, drive in zip(ways, scene.drives, strict=True) if drive is None]
    known = lesson.say("task.known", parameters=given) if scene.parameters else lesson.say("task.known.numbers")
    blocks: list[Block] = [known]
    if driven:
        blocks.append(lesson.say("task.wanted", drives=together(driven), coordinates=moving))
    if passive:
        blocks.append(lesson.say("task.passive", coordinates=together(passive)))
    return Step("task", lesson.say("task"), tuple(blocks), lesson.say("task.reason") if driven else Words(()))


def principle_steps(lesson: Lesson, page: Printable) -> list[Step]:
    """Return (5.21) and (5.22), both with L, and the generalized force of every coordinate."""
    q, qd, Q, QA = _general(lesson)
    for letter, node in (("K", lesson.energy.K), ("P", lesson.energy.P), ("L", lesson.L)):
        lesson.name(f"{letter}:", letter, node=node)
    kinetic, potential = lesson.slope("K:", q.name, None), lesson.slope("P:", q.name, None)
    momentum, slope = lesson.slope("L:", qd.name, None), lesson.slope("L:", q.name, None)
    rate = lesson.rate(lesson.slope("K:", qd.name, None).name, None)
    stated = [
        Formula("", _less(rate, kinetic), "5.21", Q),
        Formula("", Q, "5.22", _less(QA, potential)),
    ]
    both: list[Block] = [
        Formula("L:", _less(Symbol("K:"), Symbol("P:")), lesson.number("L.definition")),
        Formula("", _less(lesson.rate(momentum.name, None), slope), "", QA),
        lesson.say("stated.way"),
    ]
    count = str(lesson.state.n)
    every = together([named(x) for x in lesson.state.q])
    claim = lesson.say("stated" if lesson.state.n > 1 else "stated.one", q=q, count=count, coordinates=every)
    return [
        Step("principle", claim, tuple(stated), lesson.say("stated.reason", q=q), "(5.21), (5.22)"),
        Step("principle:L", lesson.say("stated.L"), tuple(both), lesson.say("stated.L.reason"), "(5.23)"),
        _forces(lesson, page),
    ]


def _general(lesson: Lesson) -> tuple[Symbol, Symbol, Symbol, Symbol]:
    """Name any coordinate q_i, its rate, Q_i and Q_i^A."""
    keys = iter(ANY)
    letter = lesson.letters["q"]
    lesson.names[q := next(keys)] = Name(Letter(letter, ("i",)))
    lesson.names[qd := next(keys)] = Name(Letter(letter, ("i",), dots=1))
    force = lesson.called(next(keys), Letter("Q", ("i",)))
    return Symbol(q), Symbol(qd), force, lesson.called(next(keys), Letter("Q", ("i",), above="A"))


def _forces(lesson: Lesson, page: Printable) -> Step:
    """Return Q_i^A of every coordinate: its drive, and what else acts."""
    blocks: list[Block] = []
    slides = [unit == "m" for unit in SceneUnits(lesson.scene).velocities]
    acting = generalized_forces(lesson.scene, lesson.graph)
    for i, form in enumerate(page.right):
        key = f"QA:{i + 1}"
        node = acting[i] + (lesson.drives[i] if lesson.scene.drives[i] else lesson.graph.zero)
        lesson.called(key, Letter("Q", (str(i + 1),), above="A"), node)
        blocks += [_said(lesson, i, slides[i]), Formula(key, form)]
    return Step(
        "principle:forces", lesson.say("generalized"), tuple(blocks), lesson.say("generalized.reason"), show=("forces",)
    )


def _said(lesson: Lesson, i: int, slides: bool) -> Words:
    joint = next(one for one in lesson.scene.joints if lesson.scene.coordinates[i] in one.coordinates)
    drive = lesson.scene.drives[i]
    key = ("generalized.driven" if drive else "generalized.passive") + (".slide" if slides else "")
    places = {"drive": Symbol(drive)} if drive else {}
    return lesson.say(key, q=named(lesson.state.q[i]), joint=joint.name, **places)


def _less(a: Form, b: Form) -> Form:
    return Form.sum((a, Form.product((Number.MINUS_ONE, b))))
