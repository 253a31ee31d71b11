"""The equations that loops and other rows add, in print: written, differentiated twice, solved, and then used.

    r(q) = 0,    G q̇ = 0,    G q̈ + Ġ q̇ = 0

A joint that only keeps two points together is written in the axes of the ground, as one does by hand; all others as
`symdyn equations` prints their rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symdyn.algebra import Compactor, Form, Number, Symbol, TrigonometricRing, with_added_angles, with_squares
from symdyn.dynamics import ClosedRow, angle_groups, closed_constraints
from symdyn.dynamics.mechanism import body_placements
from symdyn.dynamics.reactions import JointFrames
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, tangents
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import acceleration_name
from symdyn.teach.derivations.dalembert.balance import Balance
from symdyn.teach.derivations.dalembert.solved_loops import solved_loops
from symdyn.teach.derivations.lagrange.velocities import PAGE, folded, length
from symdyn.teach.document import Block, Formula, Step, Words
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
    return row.residual if row.closes else None, rate, push


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
    ring = TrigonometricRing(nodes, (*state.q, *state.qd, *state.qdd), parallel)
    values = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
    compact = Compactor(ring, parallel)
    return lambda node: lesson.order(with_squares(with_added_angles(compact(values[node]))))


def _vanishing(lesson: Balance, form: Form) -> Block:
    """Return that a form is zero; without minus signs in front of all of its terms."""
    if all(term.split_sign()[0] < 0 for term in form.terms):
        form = Form.sum(Form.product((Number.MINUS_ONE, term)) for term in form.terms)
    return folded(lesson, Formula("", form, right=Number.ZERO))
