"""Step: where the mechanism stays at rest without drives.

At rest k_G + k_E = Q. Quarter turns are decided exactly. Where one angle alone matters, the others are the sign changes
of k_G + k_E - Q in small steps; elsewhere they are what Newton's method finds, and the lesson says so. Where angles are
singular these forces may vanish without rest: such places are judged by the virtual work of all bodies, and named.
A position is stable where the potential of gravity, springs and constant forces has a minimum: all eigenvalues of
∂(k_G + k_E - Q)/∂q are positive.
"""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product

import numpy as np

from symdyn.algebra.form import Form, Number, Pi, Symbol, power_of, product_of
from symdyn.dynamics.mechanism.loads import generalized_forces
from symdyn.dynamics.mechanism.prescribed import TIME
from symdyn.graph import Expr, gradient, reachable, substitute
from symdyn.scene.units import coordinate_units
from symdyn.teach.document import Block, Step, Values, Words
from symdyn.teach.lesson import Lesson, together
from symdyn.teach.numbers import written
from symdyn.teach.shown_state import Chosen
from symdyn.teach.singular import Judge

STARTS = 60
STEPS = 720  # of a turn
MOST_TURNS = 8  # to either side, where a spring counts turns
MOST_EXACT = 256  # candidates that are decided exactly
CLOSE = 1e-7


def equilibrium_step(lesson: Lesson, chosen: Chosen) -> Step:
    """Return the table of equilibria, or a sentence where every position is one, none is, or time decides."""
    rest = _at_rest(lesson)
    moving = _variables(lesson, rest)
    driven = any(joint.motion is not None for joint in lesson.scene.joints)
    if driven or lesson.graph.symbol(TIME) in reachable(rest):
        return Step("equilibria", lesson.say("equilibria"), (lesson.say("equilibria.driven"),))
    if not moving:
        free = all(node.is_zero or _zero(lesson, node) for node in rest)
        said = lesson.say("equilibria.all" if free else "equilibria.never")
        return Step("equilibria", lesson.say("equilibria"), (said,))
    exact = _exact(lesson, rest, moving)
    turns = _whole_turns(lesson, rest, moving, chosen)
    found, how_searched = _searched(lesson, rest, moving, turns, chosen)
    known = [np.array([float(exact_turn) * np.pi / 2 for exact_turn in one]) for one in exact]
    places: list[tuple[list[str | Form], str, np.ndarray]] = [
        ([_quarter(k) for k in one], "exact", place) for one, place in zip(exact, known, strict=True)
    ]
    others = [x for x in found if not any(_same(x, y, moving, turns) for y in known)]
    places += [([written(x) for x in place], "numeric", place) for place in others]
    judge = Judge(lesson, rest, chosen)
    rows, false = [], []
    for shown, how, place in places:
        if judge.rests(dict(zip(moving, map(float, place), strict=True))):
            rows.append(_row(lesson, shown, how, _stable(lesson, rest, moving, place, chosen)))
        else:
            false.append(shown)
    search = [how_searched, *([_left_out(lesson, moving, false)] if false else [])]
    if not rows:
        return Step("equilibria", lesson.say("equilibria"), (lesson.say("equilibria.none"), *search))
    head = (
        *(Words((Symbol(str(q.value)),)) for q in moving),
        lesson.say("equilibria.kind"),
        lesson.say("equilibria.how"),
    )
    blocks: list[Block] = [Values(head, tuple(rows)), *search]
    idle = [Symbol(str(q.value)) for q in lesson.state.q if q not in moving]
    if idle:
        blocks.append(lesson.say("equilibria.idle", names=together(list(idle))))
    return Step("equilibria", lesson.say("equilibria"), tuple(blocks), lesson.say("equilibria.reason"))


def _at_rest(lesson: Lesson) -> list[Expr]:
    """Return k_G + k_E - Q at q̇ = 0."""
    state, zero = lesson.state, lesson.graph.zero
    slopes = gradient(lesson.energy.P, state.q)
    acting = substitute(generalized_forces(lesson.scene, lesson.graph), dict.fromkeys(state.qd, zero))
    return [a - b for a, b in zip(slopes, acting, strict=True)]


def _variables(lesson: Lesson, rest: list[Expr]) -> list[Expr]:
    """Return the coordinates on which the forces at rest depend."""
    needed = set(reachable(rest))
    return [q for q in lesson.state.q if q in needed]


def _turns(lesson: Lesson) -> dict[Expr, bool]:
    units = coordinate_units(lesson.scene)
    return {q: unit == "rad" for q, unit in zip(lesson.state.q, units, strict=True)}


def _whole_turns(lesson: Lesson, rest: list[Expr], moving: list[Expr], chosen: Chosen) -> dict[Expr, bool]:
    """Tell which coordinates are angles that a whole turn brings back, as it does not where a spring counts turns."""
    units = _turns(lesson)
    here = np.array([0.3 + 0.7 * k for k in range(len(moving))])
    before, found = _evaluate(chosen, moving, here, rest, [])[0], {}
    for k, q in enumerate(moving):
        there = here + 2 * np.pi * (np.arange(len(moving)) == k)
        after = _evaluate(chosen, moving, there, rest, [])[0]
        found[q] = units[q] and bool(np.allclose(before, after, rtol=1e-9, atol=1e-9 * (1 + np.abs(before).max())))
    return found


def _exact(lesson: Lesson, rest: list[Expr], moving: list[Expr]) -> list[tuple[int, ...]]:
    """Return the positions in quarter turns, slides at zero, that are equilibria for every value of the parameters."""
    turns = _turns(lesson)
    for choice in ((0, 2, 1, -1), (0, 2)):
        candidates = list(product(*(choice if turns[q] else (0,) for q in moving)))
        if len(candidates) <= MOST_EXACT:
            break
    else:
        return []
    graph = lesson.graph
    found = []
    for one in candidates:
        at = {q: graph.pi * Fraction(k, 2) if k else graph.zero for q, k in zip(moving, one, strict=True)}
        try:
            left = substitute(rest, at)
        except ZeroDivisionError:  # a spring of no length pulls nowhere
            continue
        if all(node.is_zero or _zero(lesson, node) for node in left):
            found.append(one)
    return found


def _zero(lesson: Lesson, node: Expr) -> bool:
    from symdyn.dynamics.closed_forms.frames_and_parameters import vanishes

    return not any(q in set(reachable([node])) for q in lesson.state.q) and vanishes(node)


def _searched(
    lesson: Lesson, rest: list[Expr], moving: list[Expr], turns: dict[Expr, bool], chosen: Chosen
) -> tuple[list[np.ndarray], Words]:
    """Return the roots of the forces at rest that were found, and the sentence that says how they were looked for."""
    if len(moving) > 1 or not _turns(lesson)[moving[0]]:
        found = _newton(rest, moving, turns, chosen)
        return found, lesson.say("equilibria.newton", starts=str(STARTS))
    (q,) = moving
    if turns[q]:
        return _crossings(rest, q, -np.pi, 1, chosen), lesson.say("equilibria.turn")
    known = [float(x[0]) for x in _newton(rest, moving, turns, chosen)]
    known = [x for x in known if abs(x) < 2 * np.pi * MOST_TURNS]
    first, last = (int(np.floor((x + np.pi) / (2 * np.pi))) for x in (min(known, default=0.0), max(known, default=0.0)))
    found = _crossings(rest, q, (2 * first - 1) * np.pi, last - first + 1, chosen)
    while first > -MOST_TURNS and (more := _crossings(rest, q, (2 * first - 3) * np.pi, 1, chosen)):
        first, found = first - 1, more + found
    while last < MOST_TURNS and (more := _crossings(rest, q, (2 * last + 1) * np.pi, 1, chosen)):
        last, found = last + 1, found + more
    ends = {"least": _multiple(2 * first - 1), "most": _multiple(2 * last + 1)}
    return found, lesson.say("equilibria.turns", q=Symbol(str(q.value)), **ends)


def _crossings(rest: list[Expr], q: Expr, start: float, turns: int, chosen: Chosen) -> list[np.ndarray]:
    """Return where the forces at rest change sign and vanish in start < q <= start + 2π turns, ascending."""
    g = next(node for node in rest if q in set(reachable([node])))

    def at(x: float) -> float:
        try:
            return float(_evaluate(chosen, [q], np.array([x]), [g], [])[0][0])
        except (ArithmeticError, ValueError):  # a spring of no length, a pole
            return float("nan")

    grid = start + 2 * np.pi / STEPS * np.arange(STEPS * turns + 1)
    sizes = [at(x) for x in grid]
    most, found = max((abs(x) for x in sizes if np.isfinite(x)), default=0.0), []
    for a, b, at_a, at_b in zip(grid[:-1], grid[1:], sizes[:-1], sizes[1:], strict=True):
        low, high = float(a), float(b)
        if at_b != 0 and not at_a * at_b < 0:
            continue
        while at_b != 0 and low < (middle := (low + high) / 2) < high:
            low, high = (middle, high) if at(middle) * at_b < 0 else (low, middle)
        if not abs(at(high)) <= 1e-9 * (1 + min(most, max(abs(at_a), abs(at_b)))):  # a pole
            continue
        if np.abs(_evaluate(chosen, [q], np.array([high]), rest, [])[0]).max() <= 1e-9 * (1 + most):
            found.append(np.array([high]))
    return found


def _newton(rest: list[Expr], moving: list[Expr], turns: dict[Expr, bool], chosen: Chosen) -> list[np.ndarray]:
    """Return roots of the forces at rest that Newton's method finds from many starts, whole turns within (-π, π]."""
    rng = random.Random(1)
    rows = [gradient(node, moving) for node in rest]
    found: list[np.ndarray] = []
    for _ in range(STARTS):
        x = np.array([rng.uniform(-np.pi, np.pi) for _ in moving])
        for _ in range(40):
            value, slope = _evaluate(chosen, moving, x, rest, rows)
            if not np.isfinite(value).all() or not np.isfinite(slope).all():
                break
            step = np.linalg.lstsq(slope, -value, rcond=1e-12)[0]
            x = x + step
            if np.abs(step).max() < 1e-12:
                break
        value, slope = _evaluate(chosen, moving, x, rest, rows)
        size = 1 + np.abs(slope).max()
        isolated = np.linalg.matrix_rank(slope, tol=1e-9 * size) == len(moving)
        if not isolated or not np.isfinite(value).all() or np.abs(value).max() > 1e-9 * size:
            continue
        x = np.array([_within(a) if turns[q] else a for a, q in zip(x, moving, strict=True)])
        if not any(_same(x, y, moving, turns) for y in found):
            found.append(x)
    return sorted(found, key=lambda y: [round(float(a), 6) for a in y])


def _evaluate(
    chosen: Chosen, moving: list[Expr], x: np.ndarray, rest: list[Expr], rows: list[list[Expr]]
) -> tuple[np.ndarray, np.ndarray]:
    at = Chosen({**chosen.values, **dict(zip(moving, map(float, x), strict=True))}, chosen.q, chosen.parameters)
    flat = at.of(*rest, *(entry for row in rows for entry in row))
    return np.array(flat[: len(rest)]), np.array(flat[len(rest) :]).reshape(len(rows), len(moving))


def _within(angle: float) -> float:
    turned = float(np.pi - (np.pi - angle) % (2 * np.pi))
    return np.pi if abs(turned + np.pi) < CLOSE else turned


def _same(x: np.ndarray, y: np.ndarray, moving: list[Expr], turns: dict[Expr, bool]) -> bool:
    apart = [abs(_within(a - b)) if turns[q] else abs(a - b) for a, b, q in zip(x, y, moving, strict=True)]
    return max(apart) < 1e-6


def _stable(lesson: Lesson, rest: list[Expr], moving: list[Expr], place: np.ndarray, chosen: Chosen) -> str:
    """Return the key of what the potential says: a minimum, none, or undecided, as where forces have no potential."""
    slopes = [node for q, node in zip(lesson.state.q, rest, strict=True) if q in moving]
    rows = [gradient(node, moving) for node in slopes]
    _, curvature = _evaluate(chosen, moving, place, slopes, rows)
    size = np.abs(curvature).max() or 1.0
    if np.abs(curvature - curvature.T).max() > 1e-9 * size:
        return "undecided"
    eigenvalues = np.linalg.eigvalsh(curvature)
    if eigenvalues.min() > 1e-9 * size:
        return "stable"
    return "unstable" if eigenvalues.min() < -1e-9 * size else "undecided"


def _left_out(lesson: Lesson, moving: list[Expr], places: list[list[str | Form]]) -> Words:
    """Return the sentence about places where coordinates are singular and the bodies are not at rest."""
    parts: list[str | Form] = []
    for place in places:
        parts += ["; "] if parts else []
        for k, (q, x) in enumerate(zip(moving, place, strict=True)):
            parts += [*([", "] if k else []), Symbol(str(q.value)), " ≈ " if isinstance(x, str) else " = ", x]
    return lesson.say("equilibria.singular", places=Words(tuple(parts)))


def _row(lesson: Lesson, place: list[str | Form], how: str, kind: str) -> tuple[Words, ...]:
    cells = [Words((x,)) for x in place]
    return (*cells, lesson.say(f"equilibria.{kind}"), lesson.say(f"equilibria.{how}"))


def _multiple(k: int) -> Form:
    """Return k π as a form."""
    return _quarter(2 * k)


def _quarter(k: int) -> Form:
    """Return k π/2 as a form."""
    value = Fraction(k, 2)
    if not value:
        return Number(value)
    below = power_of(Number(Fraction(value.denominator)), -1)
    return product_of((Number(Fraction(value.numerator)), Pi(), *((below,) if value.denominator > 1 else ())))
