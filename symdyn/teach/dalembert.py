"""The D'Alembert road as a document: every body cut free, its bivectors (5.1)-(5.17), its equilibrium (5.18).

Bodies are numbered as the textbook does, the ground being 1; frame j has its origin in the joint that carries body j.
Where the mechanism moves in a plane of coordinates of all frames, three equations a body are written.

    A, D, R, *R     actions, inertia, the reaction in the reference joint, reactions in other joints
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.algebra.form import ZERO, Form, Symbol, product_of, sum_of
from symdyn.draw import Wrench, free_body
from symdyn.dynamics.kinematics import centre_of_mass
from symdyn.dynamics.reactions.bivectors import frames
from symdyn.dynamics.reactions.dalembert import DRIVE
from symdyn.emit.formula_text import text_of
from symdyn.emit.symbols import latex_symbols
from symdyn.errors import DerivationError
from symdyn.graph import Expr
from symdyn.scene import Scene
from symdyn.spatial import apply, cross, sub, zero_vector
from symdyn.teach.balance import Balance
from symdyn.teach.document import (
    Block,
    Column,
    Document,
    Fold,
    Formula,
    Letter,
    Name,
    Picture,
    Section,
    Step,
    Values,
    Words,
)
from symdyn.teach.notation import notation_step, scene_step
from symdyn.teach.numbers import Chosen, choose_state, scene_picture
from symdyn.teach.reactions import numbers_step, roads_step, solved_steps
from symdyn.teach.render.spelling import letter
from symdyn.teach.velocities import length

WIDEST = 130
"""Characters of an entry from which a column is folded."""


def dalembert_walkthrough(scene: Scene, language: str = "en") -> Document:
    """Return the walkthrough by D'Alembert's method (5.1)-(5.20), for open and closed mechanisms.

    Raises:
        EmitError: there are more unknowns than anyone reads.
    """
    lesson = Balance(scene, language)
    chosen = choose_state(lesson.scene, lesson.state, lesson.graph, moving=not lesson.closed)
    bodies = [step for j in range(len(lesson.scene.bodies)) for step in _body(lesson, j, chosen)]
    first = [scene_step(lesson, scene_picture(lesson, chosen)), notation_step(lesson), _unknown_table(lesson)]
    sections = (
        Section("scene", lesson.text("section.scene"), tuple(first)),
        Section("count", lesson.text("section.count"), (_count(lesson),)),
        Section("bodies", lesson.text("section.bodies"), tuple(bodies)),
        Section("reactions", lesson.text("section.reactions"), (*solved_steps(lesson), numbers_step(lesson, chosen))),
        Section("roads", lesson.text("section.roads"), (roads_step(lesson),)),
    )
    title = lesson.text("title.dalembert", scene=lesson.scene.name)
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, sections)


# Unknowns


def _unknown_table(lesson: Balance) -> Step:
    rows = []
    for symbol, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True):
        words = lesson.along(one)
        kind = "unknown.drive" if one.kind == DRIVE else f"unknown.{words.split(' ')[0]}" if words else "unknown.other"
        rows.append((Words((symbol,)), lesson.say(kind, joint=one.joint, axis=words[-1:])))
    head = (lesson.say("table.symbol"), lesson.say("table.meaning"))
    reason = lesson.say("unknowns.reason")
    return Step("unknowns", lesson.say("unknowns"), (Values(head, tuple(rows)),), reason, "(5.6), (5.7)")


def _count(lesson: Balance) -> Step:
    """Return (5.18)-(5.20) in numbers."""
    system, rows = lesson.system, []
    counts = [one.joint for one in system.unknowns if one.kind != DRIVE]
    for joint in (*lesson.scene.joints, *lesson.scene.loops):
        kind = lesson.say(f"joint.{joint.type}")
        rows.append((Words((joint.name,)), kind, Words((str(counts.count(joint.name)),))))
    head = (lesson.say("table.joint"), lesson.say("table.kind"), lesson.say("table.class"))
    places = {
        "equations": str(system.equations),
        "each": str(len(system.kept)),
        "bodies": str(len(system.bodies)),
        "reactions": str(system.reactions),
        "drives": str(system.drives),
    }
    correct = system.equations == len(system.unknowns)
    blocks: list[Block] = [Values(head, tuple(rows)), lesson.say("count.sum", **places)]
    blocks.append(lesson.say("count.correct" if correct else "count.over"))
    plane = lesson.say("count.plane") if len(system.kept) == 3 else Words(())
    return Step("count", lesson.say("count", **places), tuple(blocks), plane, "(5.18)-(5.20)")


# Bodies


def _body(lesson: Balance, j: int, chosen: Chosen) -> list[Step]:
    """Return the free body, its bivectors and its equilibrium."""
    body, system = lesson.scene.bodies[j], lesson.system
    known, here = system.bodies[j], f"{j + 2}{',' if j > 7 else ''}{j + 2}"
    caption = lesson.say("free.caption", body=body.name)
    drawn, prefix = _wrenches(lesson, j, chosen), f"free{j + 2}-"
    svg = free_body(lesson.scene, body.name, chosen.q, drawn, chosen.parameters, prefix=prefix)
    alt = lesson.text("free.caption", body=body.name)
    picture = Picture(svg, caption, alt, f"free-{body.name}")
    joint = system.hanging.joints[j].joint.name
    columns = [
        _column(lesson, "A", here, lesson.kept(known.action), "5.1"),
        _column(lesson, "D", here, lesson.kept(known.inertia), "5.17"),
    ]
    for h, hinge in enumerate(system.hanging.hinges):
        own = h == j
        present = [u for u, one in enumerate(system.unknowns) if (j, u) in system.blocks and one.acts[0][0] == h]
        if present:
            index = here if own else f"{j + 2},{hinge.joint.name}"
            columns.append(_reaction(lesson, ("R" if own else "*R", index), j, present, "5.6" if own else "5.10"))
    balance: list[Block] = []
    for row in range(len(lesson.axes)):
        parts = [Symbol(column.names[row]) for column in columns if column.entries[row] != ZERO]
        if parts:
            balance.append(Formula("", sum_of(parts), "5.18" if row == 0 else "", ZERO))
    shown = [_folded(lesson, column) for column in columns]
    claim = lesson.say("free", body=body.name, number=str(j + 2))
    cut = Step(f"free:{body.name}", claim, (picture,), lesson.say("free.reason", joint=joint, number=str(j + 2)))
    named = lesson.say("bivectors", body=body.name)
    bivectors = Step(f"bivectors:{body.name}", named, tuple(shown), lesson.say("bivectors.reason"), "(5.1)-(5.17)")
    claim, reason = lesson.say("balance", body=body.name), lesson.say("balance.reason")
    return [cut, bivectors, Step(f"balance:{body.name}", claim, tuple(balance), reason, "(5.18)")]


def _wrenches(lesson: Balance, j: int, chosen: Chosen) -> list[Wrench]:
    """Return what acts on body j, ground frame: A and D at the centre of mass, every unknown at its joint."""
    hanging, body = lesson.workspace.hanging, lesson.scene.bodies[j]
    T, origin = frames(hanging)[j], hanging.joints[j].place_on_child
    try:
        centre = sub(centre_of_mass(lesson.scene, body.name, lesson.graph), origin)
    except DerivationError:  # no mass
        centre = zero_vector(lesson.graph)
    known = lesson.system.bodies[j]
    spelled = latex_symbols(lesson.scene) | {
        key: letter(name.look) for key, name in lesson.names.items() if isinstance(name.look, Letter)
    }
    acting = [("F^A", centre, known.action), ("F^D", centre, known.inertia)]
    for u, one in enumerate(lesson.system.unknowns):
        if (j, u) in lesson.system.blocks:
            hinge = hanging.hinges[one.acts[0][0]]
            place = hinge.place_on_child if hinge.child == j else hinge.place_on_parent
            acting.append((spelled[lesson.unknowns[u].name], sub(place, origin), lesson.system.blocks[j, u]))
    drawn = []
    for name, way, (force, moment) in acting:
        couple = sub(moment, cross(way, force))
        values = chosen.of(*T.point(way), *apply(T.R, force), *apply(T.R, couple))
        values = [0.0 if abs(x) < 1e-9 * (1 + max(map(abs, values[3:]))) else x for x in values]
        if any(values[3:]):
            drawn.append(Wrench(name, values[:3], values[3:6], values[6:]))
    return drawn


def _column(lesson: Balance, kind: str, index: str, entries: Sequence[Expr], number: str) -> Column:
    forms = tuple(lesson.short(entry) for entry in entries)
    return _named(lesson, (kind, index), list(zip(forms, entries, strict=True)), number)


def _reaction(lesson: Balance, look: tuple[str, str], j: int, present: Sequence[int], number: str) -> Column:
    """Return what the unknowns of one joint exert on body j."""
    columns = [lesson.kept(lesson.system.blocks[j, u]) for u in present]
    sizes = [lesson.unknowns[u] for u in present]
    entries = []
    for row in zip(*columns, strict=True):
        form = sum_of(product_of((lesson.short(x), size)) for x, size in zip(row, sizes, strict=True))
        values = [lesson.names[size.name].node for size in sizes]
        node = lesson.graph.total(x * value for x, value in zip(row, values, strict=True) if value is not None)
        entries.append((form, node))
    return _named(lesson, look, entries, number)


def _named(lesson: Balance, look: tuple[str, str], entries: Sequence[tuple[Form, Expr]], number: str) -> Column:
    kind, index = look
    names = []
    for (head, axis), (_, node) in zip(lesson.axes, entries, strict=True):
        key = f"{head}{kind}:{index}:{axis}"
        lesson.names[key] = Name(Letter(head, (*index.split(","), axis), above=kind), node)
        names.append(key)
    left = f"F{kind}:{index}"
    lesson.names[left] = Name(Letter("F", tuple(index.split(",")), above=kind, accent="bar"))
    return Column(left, tuple(form for form, _ in entries), tuple(names), number)


def _folded(lesson: Balance, column: Column) -> Block:
    """Return a column, or its entries one below the other in a fold where they are long."""
    if max(len(text_of(entry)) for entry in column.entries) <= WIDEST:
        return column
    pairs = zip(column.names, column.entries, strict=True)
    entries = tuple(Formula(name, form) for name, form in pairs)
    terms = str(sum(map(length, column.entries)))
    return Fold(lesson.say("long", name=Symbol(column.left), terms=terms), entries)
