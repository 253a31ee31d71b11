"""The walkthrough of any mechanism by D'Alembert's method, with the equations of its loops and a picture of the system.

Equations of loops and other constraints are written, differentiated twice, solved, and then used:

    r(q) = 0,    G q̇ = 0,    G q̈ + Ġ q̇ = 0

A joint that only keeps two points together is written in the axes of the ground, as one does by hand; all others as
`symdyn equations` prints their rows.

The picture shows the matrix of the whole system (5.18): rows are equations, columns unknowns, blocks bodies and joints.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby

from symdyn.algebra import Compactor, Form, Number, Symbol, with_squares
from symdyn.draw import Diagram, Text
from symdyn.dynamics import ClosedRow, angle_groups, closed_constraints
from symdyn.dynamics.mechanism import body_placements
from symdyn.dynamics.reactions import JointFrames
from symdyn.emit.print import latex_symbols
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, reachable, tangents
from symdyn.scene import Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Contact, acceleration_name
from symdyn.teach.derivations.coordinates import defined_lengths
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.bodies import body_steps
from symdyn.teach.derivations.dalembert.laws import LAW, law_errata, law_steps
from symdyn.teach.derivations.dalembert.shown_motion import choose_motion, formulations_step, numbers_step, solved_steps
from symdyn.teach.derivations.dalembert.side_by_side import side_by_side
from symdyn.teach.derivations.dalembert.solved_loops import solved_loops
from symdyn.teach.derivations.dalembert.spatial_loop import block_matrices, loop_picture
from symdyn.teach.derivations.lagrange import scene_picture, state_step
from symdyn.teach.derivations.velocities import PAGE, folded, length
from symdyn.teach.document import Block, Document, Formula, Letter, Picture, Step, Words
from symdyn.teach.lesson import called
from symdyn.teach.mathematics import letter
from symdyn.teach.notation import acting_steps, joints_step, leader, notation_step, scene_step, with_appendix
from symdyn.teach.shown_state import Chosen
from symdyn.teach.student.rows import keeps_points, points_apart

IN_A_PLANE = 3  # equations of a body


@dataclass(frozen=True)
class Gap:
    """One joint that keeps two points together.

    Attributes:
        joint: its name.
        apart: the way between the points, m, axes of the ground, coordinates that vanish by themselves left out.
    """

    joint: str
    apart: tuple[Expr, ...]


def loop_steps(lesson: Balance, chosen: Chosen) -> list[Step]:
    """Return the steps about loops; none for an open mechanism, nor where their equations have no formulas."""
    if not lesson.closed:
        return []
    placed = body_placements(lesson.scene, lesson.graph)
    together = [hinge for hinge in lesson.workspace.hanging.loops if _is_point(lesson, hinge)]
    gaps = [Gap(hinge.joint.name, tuple(x for x in points_apart(hinge, placed) if not x.is_zero)) for hinge in together]
    apart = [x for gap in gaps for x in gap.apart]
    rates = tangents(apart, lesson.state.velocity)
    levels = [apart, rates, tangents(rates, lesson.state.acceleration)]
    try:
        write = loop_writer(lesson, [x for level in levels for x in level])
    except DerivationError:
        write = Form.of
    written = [[write(x) for x in level if not x.is_zero] for level in levels]
    for row in _other_rows(lesson, {hinge.joint.name for hinge in together}):
        for level, form in zip(written, _forms_of(lesson, row), strict=True):
            if form is not None:
                level.append(lesson.order(form) if length(form) <= PAGE else form)
    if not any(written):
        return []
    points = ", ".join(gap.joint for gap in gaps)
    reasons = (lesson.say("loops.reason", joints=points) if points else Words(()), Words(()), Words(()))
    shows = ((), ("velocities",), ("accelerations",))
    steps = [
        Step(key, lesson.say(key), tuple(_vanishing(lesson, form) for form in forms), reason, show=show)
        for key, forms, reason, show in zip(
            ("loops", "loops:rates", "loops:accelerations"), written, reasons, shows, strict=True
        )
        if forms
    ]
    return [*steps, *solved_loops(lesson, chosen, [gap.apart for gap in gaps], loop_writer)]


def _other_rows(lesson: Balance, done: set[str]) -> list[ClosedRow]:
    """Return the rows of loops that do more than keep points together, and of wheels and blades."""
    try:
        rows = closed_constraints(lesson.scene).rows
    except DerivationError:  # loops that do not close
        return []
    return [row for row in rows if row.G and not (row.loop and row.owner in done)]


def _forms_of(lesson: Balance, row: ClosedRow) -> tuple[Form | None, Form, Form]:
    """Return r, G q̇ and G q̈ + Ġ q̇ of a row; None for r of a row between rates."""
    names = [Symbol(name) for name in lesson.scene.velocities]
    pushed = [Symbol(acceleration_name(name)) for name in lesson.scene.velocities]
    rate = Form.sum(entry.signed_product(u) for entry, u in zip(row.G, names, strict=True))
    bias = (
        form.signed_product(names[i].power(2) if i == j else Form.product((names[i], names[j])))
        for i, j, form in row.bias
    )
    push = Form.sum([*(entry.signed_product(a) for entry, a in zip(row.G, pushed, strict=True)), *bias])
    return row.residual if row.holonomic else None, rate, push


def _is_point(lesson: Balance, hinge: JointFrames) -> bool:
    """Whether all that a joint does is to keep two points together."""
    if not keeps_points(hinge):
        return False
    kind = JOINTS[hinge.joint.type]
    planar = len(lesson.system.kept) == IN_A_PLANE
    return kind.class_t(hinge.joint) == 3 or (planar and kind.velocities(hinge.joint) == ("rad",))


def loop_writer(lesson: Balance, nodes: Sequence[Expr]) -> Callable[[Expr], Form]:
    """Return what writes these nodes in sines of sums of angles.

    Raises:
        DerivationError: they are no polynomials.
    """
    state, parallel = lesson.state, angle_groups(lesson.scene, lesson.graph, across=True)
    write = Compactor.of(nodes, (*state.q, *state.qd, *state.qdd), parallel)
    return lambda node: lesson.order(with_squares(write(node)))


def _vanishing(lesson: Balance, form: Form) -> Block:
    """Return that a form is zero; without minus signs in front of all of its terms."""
    if all(term.split_sign()[0] < 0 for term in form.terms):
        form = Form.sum(Form.product((Number.MINUS_ONE, term)) for term in form.terms)
    return folded(lesson, Formula("", form, right=Number.ZERO))


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
    equation = Formula("", Form.sum((Form.product((s["A"], s["x"])), s["b"])), right=Number.ZERO)
    whole = block_matrices(lesson, *s.values()) if lesson.in_letters else ()
    blocks: tuple[Block, ...] = (equation, *whole, picture, lesson.say("system.count", **places))
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


UNTIL = ("count", "bodies", "reactions", "formulations")
"""The parts that it may end with."""


def dalembert_walkthrough(scene: Scene, language: str = "en", until: str = "formulations") -> Document:
    """Return the walkthrough by D'Alembert's method (5.1)-(5.20), for open and closed mechanisms, up to one of UNTIL.

    Raises:
        EmitError: there are more unknowns than anyone reads.
    """
    lesson = Balance(scene, language)
    chosen = choose_motion(lesson)
    shown = scene_step(lesson, scene_picture(lesson, chosen))
    first = [
        shown,
        *acting_steps(lesson),
        *defined_lengths(lesson, lesson.lengths),
        notation_step(lesson),
        joints_step(lesson),
    ]
    method = [step for law in law_steps(lesson) for step in (law, *law_errata(lesson, law.key))]
    sections = [lesson.section("scene", first), lesson.section("method", method)]
    if tied := loop_steps(lesson, chosen):
        sections.append(lesson.section("loops", tied))
    sections.append(lesson.section("count", [_unknown_table(lesson), _count(lesson)]))
    last = UNTIL.index(until)
    if last >= 1:
        steps = [step for j in range(len(lesson.scene.bodies)) for step in body_steps(lesson, j, chosen)]
        figure = [loop_picture(lesson, chosen)] if lesson.in_letters else []
        sections.append(lesson.section("bodies", [*figure, *steps]))
    if last >= 2:
        steps = [system_step(lesson), *solved_steps(lesson), state_step(lesson, chosen), numbers_step(lesson, chosen)]
        sections.append(lesson.section("reactions", steps))
    if last >= 3:
        if (proof := formulations_step(lesson, chosen)) is not None:
            table = side_by_side(lesson)
            section = lesson.section("formulations", [proof, *([table] if table else [])])
            alone = not proof.reference and not table
            sections.append(replace(section, title=lesson.text("section.laws")) if alone else section)
        sections = with_appendix(lesson, sections)
    title = lesson.text("title.dalembert", scene=called(lesson.scene))
    return Document(title, language, lesson.scene, lesson.graph, lesson.names, tuple(sections), "dalembert")


def _unknown_table(lesson: Balance) -> Step:
    rows = []
    passive, contact = lesson.system.passive, _contacts(lesson)
    for symbol, one in zip(lesson.unknowns, lesson.system.unknowns, strict=True):
        words = lesson.system.direction(one)
        kind = f"unknown.{words.split(' ')[0]}" if words[-2:] in (" x", " y", " z") else "unknown.other"
        if one.is_drive:
            kind = "unknown.drive" if one not in passive else "unknown.idle" if lesson.closed else "unknown.passive"
        places = {"joint": one.joint, "axis": words[-1:]}
        if one.is_reaction and (one.joint, one.number) in contact:
            kind, touching = contact[one.joint, one.number]
            places |= touching
        if one.is_coupling:
            joint = next(joint for joint in lesson.scene.joints if joint.name == one.joint)
            kind, places["leader"] = "unknown.coupling", leader(lesson.scene, joint)
        rows.append((symbol, lesson.say(kind, **places)))
    table, reason = lesson.table(("symbol", "meaning"), rows), lesson.say("unknowns.reason")
    return Step("unknowns", lesson.say("unknowns"), (table,), reason, "(5.6), (5.7)")


def _contacts(lesson: Balance) -> dict[tuple[str, int], tuple[str, dict[str, str]]]:
    """Return the words for each force of a contact, with their places; none where not all of them are asked for."""
    found: dict[tuple[str, int], tuple[str, dict[str, str]]] = {}
    unknown = [(one.joint, one.number) for one in lesson.system.unknowns]
    for row in lesson.scene.constraints:
        told = FORCES[row.kind].touch.words(row) if isinstance(row, Contact) else ()
        if isinstance(row, Contact) and all(told) and (row.name, len(told) - 1) in unknown:
            bodies = (
                lesson.text("ground") if name == Scene.GROUND else name for name in (row.plane.body, row.place.body)
            )
            places = dict(zip(("parent", "child"), bodies, strict=True)) | {"owner": row.name}
            found |= {(row.name, k): (f"tie.{one}", dict(places)) for k, one in enumerate(told)}
    return found


def _count(lesson: Balance) -> Step:
    """Return (5.18)-(5.20) in numbers."""
    system, joints = lesson.system, (*lesson.scene.joints, *lesson.scene.loops)
    counts = [one.joint for one in system.unknowns if not one.is_drive]
    rows = [(joint.name, lesson.joint_kind(joint), str(counts.count(joint.name))) for joint in joints]
    for row in lesson.scene.constraints:
        if row.name in counts:
            kind = Words((lesson.kind(row.kind, FORCES[row.kind].words),))
            rows.append((row.text or row.name, kind, str(counts.count(row.name))))
    classes = [counts.count(name) for name in dict.fromkeys(counts)]
    places: dict[str, str | Form] = {
        "equations": str(system.equations),
        "each": str(len(system.kept)),
        "bodies": str(len(system.bodies)),
        "sum": " + ".join(f"{t} · {classes.count(t)}" for t in sorted(set(classes), reverse=True)) or "0",
        "reactions": str(system.reactions),
        "drives": str(system.drives),
        "m": lesson.name("m:R", "m", "R", node=None),
    }
    symbols = [lesson.name(f"s:{t}", "s", str(t), node=None) for t in sorted(set(classes), reverse=True)]
    numbers = [str(classes.count(t)) for t in sorted(set(classes), reverse=True)]
    listed = [part for pair in zip(symbols, numbers, strict=True) for part in (", ", pair[0], f" = {pair[1]}")]
    correct = system.equations == len(system.unknowns)
    blocks: list[Block] = [lesson.table(("joint", "kind", "class"), rows)]
    if symbols:
        moving = str(len(system.bodies) + 1)
        said = {key: Symbol(LAW + name) for key, name in (("u", "u"), ("s", "s_t"), ("t", "t"))}
        blocks.append(lesson.say("count.classes", bodies=moving, classes=Words(tuple(listed[1:])), **said))
    blocks.append(lesson.say("count.sum", **places))
    coupled = ", ".join(one.joint for one in system.unknowns if one.is_coupling)
    if coupled:
        blocks.append(lesson.say("count.coupled", joints=coupled))
    if system.passive:
        names = ", ".join(dict.fromkeys(one.joint for one in system.passive))
        key = "count.idle" if lesson.closed else "count.passive"
        blocks.append(lesson.say(key, number=str(len(system.passive)), joints=names))
    blocks.append(lesson.say("count.correct" if correct else "count.over", **places))
    plane = lesson.say("count.plane") if len(system.kept) == 3 else Words(())
    return Step("count", lesson.say("count", **places), tuple(blocks), plane, "(5.18)-(5.20)")
