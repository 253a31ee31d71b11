"""Steps: limits in which a result must be what everybody knows: nothing to carry, no gravity, small swings."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from symdyn.algebra import Form, Symbol, with_squares
from symdyn.dynamics import Energies
from symdyn.errors import DerivationError
from symdyn.graph import Expr, gradient, substitute
from symdyn.scene import Quantity, Scene
from symdyn.teach.derivations.afterwards.reduced import Reduced, zero
from symdyn.teach.derivations.lagrange.energies import kinetic_form
from symdyn.teach.derivations.lagrange.velocities import length
from symdyn.teach.document import Block, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen

UNITS = ("kg", "m", "m/s2", "N/m", "Nm/rad")
"""Of parameters that may go to zero."""

LONGEST = 26
"""Terms and factors of an energy that fits into a table."""

AMPLITUDES = (10, 30, 60, 90)
"""Degrees."""

EVEN = 1e-6
"""Of a ratio of periods: less is none."""

PARTS = 400
"""Of the integral for a period."""


def limit_steps(lesson: Lesson, left: Reduced | None, chosen: Chosen) -> list[Step]:
    """Return the table of limits, mechanisms with a body less, and periods of large swings."""
    steps = [_energies(lesson)]
    if left is not None:
        steps.append(_swings(lesson, left))
    return [step for step in steps if step is not None]


def _energies(lesson: Lesson) -> Step | None:
    """Return what K and P become as one parameter after the other vanishes."""
    graph, energy = lesson.graph, lesson.energy
    rows: list[tuple[Words, Form | Words, Form | Words, Words]] = []
    checks: list[Block] = []
    for parameter in lesson.scene.parameters:
        if parameter.unit.replace("^", "").replace("²", "2").replace(" ", "") not in UNITS:
            continue
        symbol = graph.symbol(parameter.name)
        try:
            K, P = substitute([energy.K, energy.P], {symbol: graph.zero})
        except ZeroDivisionError:
            continue
        if zero(lesson, K - energy.K) and zero(lesson, P - energy.P):
            continue
        try:
            shown = (kinetic_form(lesson, K), with_squares(lesson.short(P)))
        except (DerivationError, KeyError):
            continue
        if max(map(length, shown)) > LONGEST:
            continue
        rows.append((Words((Symbol(parameter.name), " → 0")), *shown, _left(lesson, K, P)))
        checks += _smaller(lesson, symbol, K, P)
    if not rows:
        return None
    table = lesson.table(("limits.limit", Symbol("K:"), Symbol("P:"), "limits.left"), rows)
    blocks, reason = (table, *checks), lesson.say("limits.reason")
    return Step("limits", lesson.say("limits"), blocks, reason, show=("energies", "ghost"))


def _left(lesson: Lesson, K: Expr, P: Expr) -> Words:
    """Return what no longer counts: coordinates whose rates move nothing, and those that L forgets."""
    state = lesson.state
    idle: list[Form] = [named(q) for q, u in zip(state.q, state.qd, strict=True) if zero(lesson, gradient(K, [u])[0])]
    cyclic: list[Form] = []
    for k, (q, name) in enumerate(zip(state.q, map(named, state.q), strict=True)):
        known = gradient(K - P, [q])[0]
        if name not in idle and zero(lesson, known) and not zero(lesson, lesson.slopes[k]):
            cyclic.append(name)
    parts: list[str | Form] = []
    if idle:
        parts += lesson.say("limits.idle", names=together(idle)).parts
    if cyclic:
        parts += [*(["; "] if parts else []), *lesson.say("limits.cyclic", names=together(cyclic)).parts]
    return Words(tuple(parts) or ("–",))


def _smaller(lesson: Lesson, vanishing: Expr, K: Expr, P: Expr) -> list[Block]:
    """Return the sentence that the mechanism without a body that weighs nothing has the same energies."""
    graph = lesson.graph
    for body in lesson.scene.bodies:
        smaller = without(lesson.scene, body.name)
        weighs = [mass for mass in lesson.masses if mass.body.name == body.name]
        nodes = [x for mass in weighs for x in (mass.m, *(y for row in mass.inertia for y in row))]
        left = substitute(nodes, {vanishing: graph.zero})
        if smaller is None or not nodes or not all(x.is_zero for x in left):
            continue
        other = Energies.of(smaller, graph)  # the parameter may stand in what is left, too
        less = substitute([other.K, other.P], {vanishing: graph.zero})
        same = zero(lesson, K - less[0]) and zero(lesson, P - less[1])
        assert same, f"without {body.name} the energies are others: one of the two derivations is wrong"
        return [lesson.say("limits.smaller", parameter=named(vanishing), body=body.name)]
    return []


def without(scene: Scene, body: str) -> Scene | None:
    """Return an open scene without one of its last bodies; None where something else is fixed to it."""
    (joint,) = [joint for joint in scene.joints if joint.child == body]
    followed = {one.coupling.coordinate for one in scene.joints if one.coupling}
    if len(scene.bodies) < 2 or scene.is_closed or scene.elements or joint.armature != Quantity.ZERO:
        return None
    if joint.coupling or followed.intersection(joint.coordinates) or body in (one.parent for one in scene.joints):
        return None
    return replace(
        scene,
        bodies=tuple(one for one in scene.bodies if one.name != body),
        joints=tuple(one for one in scene.joints if one is not joint),
        points=tuple(one for one in scene.points if one.body != body),
        outputs=(),
    )


def _swings(lesson: Lesson, left: Reduced) -> Step | None:
    """Return periods of swings of finite amplitude about the valley, over that of small ones."""
    if not left.turns:
        return None
    valleys = [one for one in left.level(-math.pi, math.pi) if one[1] > 0]
    if not valleys:
        return None
    place, curvature, m = min(valleys, key=lambda one: float(left.at(np.array([one[0]]))[1][0]))
    small = 2 * math.pi * math.sqrt(m / curvature)
    rows, ratios = [], []
    for degrees in AMPLITUDES:
        taken = swing(left, place, math.radians(degrees))
        if taken is None:
            break
        ratios.append(taken / small)
        rows.append((f"{degrees}°", f"{lesson.written(taken)} s", lesson.written(taken / small)))
    if not rows:
        return None
    table = lesson.table(("swings.amplitude", "swings.period", "swings.ratio"), rows)
    key = "longer" if min(ratios) > 1 + EVEN else "shorter" if max(ratios) < 1 - EVEN else "other"
    claim = lesson.say(
        f"swings.{key}", q=named(left.q), place=f"{lesson.about(place)} rad", period=f"{lesson.about(small)} s"
    )
    return Step("swings", claim, (table,), lesson.say("swings.reason"), show=("phase", "plots"))


def swing(left: Reduced, place: float, amplitude: float) -> float | None:
    """Return the period of a swing from `place + amplitude`, s, T = 2 ∫ √(m/(2 (E - V))) dr; None beyond its valley.

    With r = middle + half sin s the integrand has no end at which it is infinite, and equal steps converge fast.
    """
    E = float(left.at(np.array([place + amplitude]))[1][0])
    beyond = np.diff(left.at(place + np.linspace(0, amplitude, 101))[1])
    x = place - np.linspace(0, 2 * math.pi, 2001)
    V = left.at(x)[1]
    past = np.flatnonzero(~(E > V))
    if not len(past) or past[0] == 0 or not (np.all(beyond > 0) and np.all(np.diff(V[: past[0] + 1]) > 0)):
        return None
    low, high = float(x[past[0]]), float(x[past[0] - 1])
    for _ in range(60):
        middle = (low + high) / 2
        if E - float(left.at(np.array([middle]))[1][0]) > 0:
            high = middle
        else:
            low = middle
    other, top = (low + high) / 2, place + amplitude
    s = (np.arange(PARTS) + 0.5) * math.pi / PARTS - math.pi / 2
    half = (top - other) / 2
    m, V = left.at((top + other) / 2 + half * np.sin(s))
    if not np.all(E - V > 0):
        return None
    return float(2 * np.sum(np.sqrt(m / (2 * (E - V))) * half * np.cos(s)) * math.pi / PARTS)
