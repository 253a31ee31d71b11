"""Step: where the mechanism stays at rest without drives.

At rest k_G + k_E = Q. The places are those of `symdyn.linear`: quarter turns are decided exactly; where one angle alone
matters, the others are the sign changes of k_G + k_E - Q in small steps; elsewhere they are what Newton's method finds,
and the lesson says so. A position is stable where the potential of gravity, springs and constant forces has a minimum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from symdyn.algebra import Form, Number, Pi
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.graph import Expr, gradient, reachable, substitute
from symdyn.linear import Equilibrium, rests
from symdyn.scene import SceneUnits
from symdyn.teach.document import Block, Step, Words
from symdyn.teach.lesson import Lesson, Prose, named, together
from symdyn.teach.shown_state import Chosen

QUARTERS = (0, 2, 1, -1)
"""Quarter turns in the order in which they are listed."""


@dataclass(frozen=True)
class Rests:
    """All places of rest that were found.

    Attributes:
        lesson: what is told of.
        forces: k_G + k_E - Q at q̇ = 0, which vanish there.
        q: the coordinates on which they depend.
        places: the exact ones first.
        searched: the sentences that say how places were looked for, and what was no such place.
        families: the sentences that say that others rest next to some places.
        why: the key of the sentence that stands in place of a list; "" where there is one.
    """

    lesson: Lesson
    forces: Sequence[Expr]
    q: tuple[Expr, ...] = ()
    places: tuple[Equilibrium, ...] = ()
    searched: tuple[Words, ...] = ()
    families: tuple[Words, ...] = ()
    why: str = ""

    def shown(self, place: Equilibrium) -> list[str | Form]:
        """Return a place in print, one entry a coordinate of q."""
        exact, written, state = place.exact, self.lesson.written, self.lesson.state
        if exact is not None:
            return [exact[str(q.value)] for q in self.q]
        return [written(float(place.q[state.q.index(q)])) for q in self.q]

    def where(self, place: Equilibrium) -> list[str | Form]:
        """Return "q1 = 0, q2 ≈ 3.142"."""
        parts: list[str | Form] = []
        for q, x in zip(self.q, self.shown(place), strict=True):
            parts += [*([", "] if parts else []), named(q), " ≈ " if isinstance(x, str) else " = ", x]
        return parts


def places_of_rest(lesson: Lesson, chosen: Chosen) -> Rests:
    """Return where the mechanism stays at rest without drives."""
    state, graph = lesson.state, lesson.graph
    slopes = gradient(lesson.energy.P, state.q)
    acting = substitute(generalized_forces(lesson.scene, graph), dict.fromkeys(state.qd, graph.zero))
    forces = [a - b for a, b in zip(slopes, acting, strict=True)]
    driven = any(joint.motion is not None for joint in lesson.scene.joints)
    if driven or graph.symbol(TIME) in reachable(forces):
        return Rests(lesson, forces, why="driven")
    values = {one.name: chosen.parameters[one.name] for one in lesson.scene.free_parameters}
    found = rests(lesson.scene, values, np.array(chosen.q), chosen.values.get(graph.symbol(TIME), 0.0))
    places, q = (*found.places, *found.locked), tuple(q for q in state.q if str(q.value) not in found.idle)
    if not q:
        return Rests(lesson, forces, why="all" if places else "never")
    listed = Rests(lesson, forces, q, _listed(lesson, q, places), families=families(lesson, found.places, found.more))
    turns = round(found.scanned / math.pi)
    search = lesson.say("equilibria.turn" if turns else "equilibria.newton", starts=str(found.starts))
    if turns > 1:
        least, most = (Form.product((Number(Fraction(k)), Pi())) for k in (-turns, turns))
        search = lesson.say("equilibria.turns", q=named(q[0]), least=least, most=most)
    false = _left_out(listed, _listed(lesson, q, found.false))
    return replace(listed, searched=(search, *false))


def _listed(lesson: Lesson, q: Sequence[Expr], places: Sequence[Equilibrium]) -> tuple[Equilibrium, ...]:
    """Return places in the order in which they are listed: exact ones first, quarter turn by quarter turn."""
    units = SceneUnits(lesson.scene).coordinates
    angles = [k for k, one in enumerate(lesson.state.q) if one in q and units[k] == "rad"]
    exact = [place for place in places if place.exact is not None]
    exact.sort(key=lambda place: [QUARTERS.index(round(2 * place.q[k] / math.pi)) for k in angles])
    return (*exact, *(place for place in places if place.exact is None))


def _left_out(rests: Rests, places: Sequence[Equilibrium]) -> list[Words]:
    """Return the sentence about places where coordinates are singular and the bodies are not at rest, if any are."""
    parts: list[str | Form] = []
    for place in places:
        parts += [*(["; "] if parts else []), *rests.where(place)]
    return [rests.lesson.say("equilibria.singular", places=Words(tuple(parts)))] if parts else []


def families(lesson: Prose, places: Sequence[Equilibrium], more: int) -> tuple[Words, ...]:
    """Return what is said where others rest next to places, and `more` starts led to further ones."""
    said = [lesson.say("closed.family")] if any(place.family for place in places) else []
    return (*said, *([lesson.say("closed.more", count=str(more))] if more else []))


def equilibrium_step(lesson: Lesson, rests: Rests) -> Step:
    """Return the table of equilibria, or a sentence where every position is one, none is, or time decides."""

    def step(*blocks: Block) -> Step:
        return Step("equilibria", lesson.say("equilibria"), blocks, show=("weights", "forces"))

    if rests.why:
        return step(lesson.say(f"equilibria.{rests.why}"))
    if not rests.places:
        return step(lesson.say("equilibria.none"), *rests.searched)
    rows = [
        (
            *rests.shown(place),
            lesson.say(f"equilibria.{place.kind}"),
            lesson.say("equilibria.exact" if place.exact is not None else "equilibria.numeric"),
        )
        for place in rests.places
    ]
    table = lesson.table((*map(named, rests.q), "equilibria.kind", "equilibria.how"), rows)
    idle: list[Form] = [named(q) for q in lesson.state.q if q not in rests.q]
    apart = [lesson.say("equilibria.idle", names=together(idle))] if idle else []
    blocks: list[Block] = [table, *rests.searched, *apart, *rests.families]
    return replace(step(*blocks), reason=lesson.say("equilibria.reason"))
