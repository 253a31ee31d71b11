"""The equations that loops and other rows add, in print: r(q) = 0 and its derivative G q̇ = 0.

A joint that only keeps two points together is written in the axes of the ground, as one does by hand; all others as
`symdyn equations` prints their rows.
"""

from __future__ import annotations

from collections.abc import Callable

from symdyn.algebra.compact import Compactor
from symdyn.algebra.form import ZERO, Form, Symbol, form_of, signed_product, sum_of
from symdyn.algebra.joined_terms import with_added_angles
from symdyn.algebra.sums_of_angles import total_angles
from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics.closed_forms.constraint_forms import closed_constraints
from symdyn.dynamics.closed_forms.parallel import angle_groups
from symdyn.dynamics.mechanism.placements import body_placements
from symdyn.dynamics.reactions.hinges import Hinge
from symdyn.errors import DerivationError
from symdyn.graph import Expr, evaluate, tangents
from symdyn.scene import JOINTS
from symdyn.teach.document import Block, Formula, Step, Words
from symdyn.teach.roads.dalembert.balance import Balance
from symdyn.teach.roads.lagrange.velocities import folded
from symdyn.teach.student.rows import keeps_points, points_apart

IN_A_PLANE = 3  # equations of a body


def loop_steps(lesson: Balance) -> list[Step]:
    """Return the step that writes the loops' equations; none for an open mechanism, nor where they have no formulas."""
    if not lesson.closed:
        return []
    together = [hinge for hinge in lesson.workspace.hanging.loops if _is_point(lesson, hinge)]
    placed = body_placements(lesson.scene, lesson.graph)
    gaps = [x for hinge in together for x in points_apart(hinge, placed) if not x.is_zero]
    moving = [x for x in tangents(gaps, lesson.state.velocity) if not x.is_zero]
    write = _writer(lesson, [*gaps, *moving])
    positions, rates = [write(x) for x in gaps], [write(x) for x in moving]
    try:
        rows = closed_constraints(lesson.scene).rows
    except DerivationError:  # loops that do not close
        rows = ()
    done = {hinge.joint.name for hinge in together}
    for row in rows:
        if row.G and not (row.loop and row.owner in done):
            if row.closes and row.residual is not None:
                positions.append(row.residual)
            names = [Symbol(name) for name in lesson.scene.velocities]
            rates.append(sum_of(signed_product(entry, u) for entry, u in zip(row.G, names, strict=True)))
    blocks: list[Block] = []
    for key, forms in (("loops.positions", positions), ("loops.rates", rates)):
        if forms:
            blocks += [lesson.say(key), *(_vanishing(lesson, form) for form in forms)]
    if not blocks:
        return []
    points = ", ".join(hinge.joint.name for hinge in together)
    reason = lesson.say("loops.reason", joints=points) if points else Words(())
    return [Step("loops", lesson.say("loops"), tuple(blocks), reason)]


def _is_point(lesson: Balance, hinge: Hinge) -> bool:
    """Whether all that a joint does is to keep two points together."""
    if not keeps_points(hinge):
        return False
    kind = JOINTS[hinge.joint.type]
    planar = len(lesson.system.kept) == IN_A_PLANE
    return kind.class_t(hinge.joint) == 3 or (planar and kind.velocities(hinge.joint) == ("rad",))


def _writer(lesson: Balance, nodes: list[Expr]) -> Callable[[Expr], Form]:
    """Return what writes these nodes: in sines of sums of angles, as they stand where they are no polynomials."""
    state, parallel = lesson.state, angle_groups(lesson.scene, lesson.graph, across=True)
    try:
        ring = TrigonometricRing(nodes, (*state.q, *state.qd), total_angles(parallel))
        values = dict(zip(nodes, evaluate(nodes, ring, ring.values(nodes)), strict=True))
    except DerivationError:
        return form_of
    compact = Compactor(ring, parallel)
    return lambda node: with_added_angles(compact(values[node]))


def _vanishing(lesson: Balance, form: Form) -> Block:
    return folded(lesson, Formula("", form, right=ZERO))
