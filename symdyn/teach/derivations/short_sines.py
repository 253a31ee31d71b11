"""Short forms of nodes in sines of the angles of a scene, by sums of angles where these are shorter."""

from __future__ import annotations

from itertools import product

from symdyn.algebra import Compactor, Form
from symdyn.dynamics import angle_groups
from symdyn.dynamics.mechanism import State
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene import Scene
from symdyn.teach.derivations.velocities import length
from symdyn.teach.lesson import Lesson


def in_sines(lesson: Lesson, node: Expr) -> Form | None:
    """Return a node as short as a ring of sines can write it; None where it is no polynomial in them."""
    return shortest(node, lesson.scene, lesson.state)


def shortest(node: Expr, scene: Scene, state: State) -> Form | None:
    """Return the same with angles and letters of a scene, by the sum of an angle and a parameter if shorter."""
    parallel = angle_groups(scene, node.graph, across=scene.is_constrained)

    def written(node: Expr) -> Form | None:
        try:
            return Compactor.of([node], (*state.q, *state.qd, *state.qdd), parallel)(node)
        except (DerivationError, KeyError):
            return None

    found = [written(node)]
    waves = [x.args[0] for x in reachable([node]) if x.op in (Op.SIN, Op.COS)] if found[0] else []
    angles = dict.fromkeys(x for x in reachable(waves) if x.op is Op.SYMBOL)
    fixed = {one.name for one in scene.parameters}
    for q, a in product([x for x in angles if x in state.q], [x for x in angles if x.value in fixed]):
        for shift in (a, -a):
            if (form := written(substitute([node], {q: q - shift})[0])) is not None:
                found.append(form.substitute({str(q.value): Form.of(a + q if shift is a else q - a)}))
    return min(found, key=lambda form: length(form) if form is not None else 0)
