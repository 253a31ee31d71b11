r"""Multipliers in a student's Lagrangian: L + Σ λ_k f_k, where every f_k vanishes wherever the loops are closed.

The conditions may be written in other ways than the scene's, so they are looked at in numbers, as rows are: each
vanishes on the motions that are allowed, and together they forbid as much as the scene's rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.algebra import Form, Number
from symdyn.dynamics.mechanism import State
from symdyn.emit.print import Printable
from symdyn.graph import Graph, gradient, tangents
from symdyn.scene import Scene
from symdyn.teach.student.answer import Answer
from symdyn.teach.student.mistakes import Mistake
from symdyn.teach.student.quantity import judged
from symdyn.teach.student.rows import LEVELS, holds, independent, level_of
from symdyn.verdict import Verdict

ENERGIES = ("K", "P", "L")
ADDED_TO = ("P", "L")
"""Where Lagrange's multipliers may stand: L + λ f, which is K - (P - λ f)."""


def energy_judged(line: int, kind: str, form: Form, right: Form, page: Printable) -> Answer:
    """Return the answer to an energy of the whole mechanism: K, P or L, with multipliers or without."""
    scene = page.scene
    given = set(form.symbols)
    used = [row.multiplier for row in page.constraints.rows if row.multiplier in given]
    if not used:
        return judged(line, kind, form, right, scene, kind)
    if kind in ADDED_TO and len(used) == len(page.constraints.rows) and _added(form, used, scene):
        alone = judged(line, kind, form.substitute(dict.fromkeys(used, Number.ZERO)), right, scene, kind)
        return replace(alone, multiplied=tuple(used)) if alone.right else alone
    answer = judged(line, kind, form, right, scene, kind)
    return (
        replace(answer, mistake=Mistake("multiplier", Graph().zero)) if answer.verdict == Verdict.DIFFERENT else answer
    )


def _added(form: Form, used: Sequence[str], scene: Scene) -> bool:
    """Whether a formula is λ_k f_k, added up, beside what holds no λ; every f_k a condition, no two the same one."""
    graph = Graph()
    conditions = [Form.of(x) for x in gradient(form.express(graph), [graph.symbol(name) for name in used])]
    if any(set(used) & set(f.symbols) or level_of(f, scene) != LEVELS[0] for f in conditions):
        return False
    return all(holds(f, scene) or _constant(f, scene) for f in conditions) and independent(conditions, scene)


def _constant(condition: Form, scene: Scene) -> bool:
    """Whether a condition of positions keeps its value where rows tie velocities: x - r φ of a wheel that rolls."""
    if not scene.rows:
        return False
    graph = Graph()
    state = State.of(scene, graph)
    (rate,) = tangents([condition.express(graph)], state.velocity)
    return holds(Form.of(rate), scene)
