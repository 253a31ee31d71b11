"""Reaction percussions of all joints at the impact of one contact, and where a hinge feels none: the sweet spot.

Bodies are cut free as for reactions, with the changes of the velocities in place of accelerations; what is finite, such
as weights, leaves nothing over no time:

    -M_j Δv_j + Σ P^R = 0        (5.18) integrated over the impact, body by body, from the tips to the ground

Reference: the textbook, section 5.1.1, eq. (5.18); Routh, Dynamics of a System of Rigid Bodies (1905), § 119.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symdyn.algebra import Array, Form, Symbol
from symdyn.dynamics import Workspace
from symdyn.dynamics.reactions import percussions
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, gradient, reachable, substitute
from symdyn.scene import Quantity, Scene
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import Joint, PlaneContact, Stop
from symdyn.teach.derivations.contacts import Struck
from symdyn.teach.derivations.precession import NO_FORM, lowest, shortened
from symdyn.teach.derivations.velocities import folded
from symdyn.teach.document import Block, Formula, Letter, Step
from symdyn.teach.lesson import SMALL_SCENE

PLACES = (0.37, 1.13)
"""What is added to coordinates where percussions are looked at, rad or m."""

NONE = 1e-9
"""Of a percussion that vanishes, relative to that of the contact."""


@dataclass(frozen=True)
class Felt:
    """One percussion of a joint that does not vanish, along an axis of the ground."""

    joint: Joint
    at: int  # of the moment, 3 to 5, or of the force, 0 to 2
    entry: Expr  # in changes of velocities, which stand as accelerations, and percussions of the contact


def joint_steps(one: Struck) -> Iterator[Step]:
    """Yield the reaction percussions of all joints, and of one hinge that holds everything the place where it has none.

    Contacts by formulas do not say where they act, and dry friction strikes nothing.
    """
    lesson = one.lesson
    if not isinstance(one.touch.law, (PlaneContact, Stop)) or one.columns is None or one.is_tied:
        return
    forces = [one.percussion(way, "" if one.has_friction else "+") for way in ("n", "t")[: len(one.rows)]]
    if len(one.rows) > len(forces) or lesson.state.n > SMALL_SCENE:
        return  # it slips along two directions, or is nothing to be read
    changes = [one.jump(i) for i in range(lesson.state.n)]
    loads = [lesson.graph.symbol(x.name) for x in forces]
    felt = list(_felt(one, loads))
    blocks, several = list[Block](), len(lesson.scene.joints) > 1
    for x in felt:
        number = str(lesson.scene.joints.index(x.joint) + 1) if several else ""
        index = tuple(part for part in ("xyz"[x.at % 3], number, one.number) if part)
        letter = Letter("R", index) if x.at < 3 else Letter("M", index, above="R")
        try:
            slopes = [shortened(lesson, part) for part in gradient(x.entry, [*lesson.state.qdd, *loads])]
        except NO_FORM:
            return
        form = Form.sum(Form.product(pair) for pair in zip(slopes, [*changes, *forces], strict=True) if pair[0].terms)
        symbol = lesson.called(f"felt:{x.at}:{number}:{one.number}", letter)
        blocks.append(folded(lesson, Formula(symbol.name, form)))
    if not blocks:
        return
    claim = lesson.say("contacts.joints", contact=one.name)
    reason = lesson.say(f"contacts.joints.reason{'.one' if not several else ''}")
    yield Step(f"contacts:joints:{one.name}", claim, tuple(blocks), reason, "(5.18)")
    yield from _sweet(one, felt, forces)


def _felt(one: Struck, loads: list[Expr]) -> Iterator[Felt]:
    """Yield what does not vanish, joint by joint: what the equations of the impact make zero does."""
    lesson, law, ways = one.lesson, one.touch.law, one.touch.ways
    closed = () if law.closed is None else (law.closed,)
    still = (Quantity.ZERO, Quantity.ZERO, Quantity.ZERO)
    bare = replace(lesson.scene.with_gravity(still), elements=closed, loops=())
    w = Workspace(bare)
    sizes = [w.graph.zero] * 3
    for k, load in zip((0, *ways), loads, strict=False):
        sizes[k] = w.graph.symbol(str(load.value))
    entries = percussions(w.hanging, sizes[: 3 * len(closed)])
    undriven = dict.fromkeys(w.state.tau, w.graph.zero)
    entries = substitute(substitute(entries, undriven), {}, lesson.graph)
    seen = sum((np.abs(_at(one, loads, entries, shift)) for shift in PLACES), np.zeros(len(entries)))
    for k, entry in enumerate(entries):
        if seen[k] > NONE:
            yield Felt(bare.joints[k // 6], k % 6, entry)


def _at(one: Struck, loads: list[Expr], entries: list[Expr], shift: float) -> Array:
    """Return entries at a position, with the velocities that its percussions, 1 and 0.4, change."""
    lesson, state = one.lesson, one.lesson.state
    q = {x: value + shift * (k + 1) for k, (x, value) in enumerate(zip(state.q, one.chosen.of(*state.q), strict=True))}
    here = one.chosen.with_values({**q, **dict(zip(loads, (1.0, 0.4), strict=False))})
    M = np.array(here.of(*(x for p in lesson.momenta for x in gradient(p, state.qd)))).reshape(state.n, state.n)
    pushed = here.of(
        *(lesson.graph.total(row[i] * x for row, x in zip(one.rows, loads, strict=True)) for i in range(state.n))
    )
    changed = dict(zip(state.qdd, np.linalg.solve(M, pushed).tolist(), strict=True))
    return np.array(here.with_values(changed).of(*entries))


def _sweet(one: Struck, felt: list[Felt], forces: list[Symbol]) -> Iterator[Step]:
    """Yield the percussion of the one hinge that holds everything where all coordinates are zero, and where it is zero.

    It is told of a smooth contact that touches there.
    """
    lesson, state, law, graph = one.lesson, one.lesson.state, one.touch.law, one.lesson.graph
    roots = [joint for joint in lesson.scene.joints if joint.parent == Scene.GROUND]
    if not isinstance(law, PlaneContact) or one.has_friction or one.columns is None or len(roots) != 1:
        return
    still = dict.fromkeys((*state.q, *state.qd), graph.zero)
    gap, *columns = substitute([one.node(one.touch.gap), *(x.express(graph) for x in one.columns[0][0])], still)
    if law.plane.body != Scene.GROUND or JOINTS[roots[0].type].slides(roots[0]) or not gap.is_zero:
        return
    (force,), blocks, sums = forces, list[Block](), list[Expr]()
    moved = still | dict(zip(state.qdd, columns, strict=True)) | {graph.symbol(force.name): graph.one}
    for x in felt:
        if x.joint.name != roots[0].name or x.at > 2:
            continue
        try:
            taken = lowest(substitute([x.entry], moved)[0])
            if taken.is_zero:
                continue
            form = shortened(lesson, taken)
        except NO_FORM:
            return
        axis = "xyz"[x.at]
        key = lesson.called(f"hinge:{axis}:{one.number}", Letter("R", (axis, one.number) if one.number else (axis,)))
        blocks.append(Formula(key.name, Form.product((form, force))))
        sums.append(taken)
    if not blocks:
        return
    yield Step(
        f"contacts:hinge:{one.name}", lesson.say("contacts.hinge", joint=roots[0].name, contact=one.name), tuple(blocks)
    )
    names = dict.fromkeys(name for x in law.place.at for name in x.symbols)
    if len(sums) == len(names) == state.n == 1:
        (at,) = names
        (slope,) = gradient(sums[0], [graph.symbol(at)])
        (rest,) = substitute([sums[0]], {graph.symbol(at): graph.zero})
        try:
            spot = lowest(-rest / slope)
            if slope.is_zero or graph.symbol(at) in reachable([spot]):
                return
            formula = Formula("", Symbol(at), right=shortened(lesson, spot))
        except NO_FORM:
            return
        claim = lesson.say("contacts.sweet", contact=one.name)
        yield Step(f"impact:sweet:{one.name}", claim, (formula,), lesson.say("contacts.sweet.reason"))
