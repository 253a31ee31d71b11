"""Step: where the mechanism stays at rest without drives.

At rest k_G + k_E = Q. Quarter turns are decided exactly. Where one angle alone matters, the others are the sign changes
of k_G + k_E - Q in small steps; elsewhere they are what Newton's method finds, and the lesson says so. A position is
stable where the potential of gravity, springs and constant forces has a minimum: all eigenvalues of
∂(k_G + k_E - Q)/∂q are positive.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product

import numpy as np

from symdyn.algebra import Array, Form, Number, Pi, Ratios
from symdyn.dynamics.mechanism import TIME, generalized_forces
from symdyn.graph import Expr, evaluate, gradient, reachable, substitute
from symdyn.scene import SceneUnits
from symdyn.teach.derivations.afterwards.singular_places import Judge
from symdyn.teach.document import Block, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.shown_state import Chosen
from symdyn.unlocked import cached_property

STARTS = 60
STEPS = 720  # of a turn
MOST_TURNS = 8  # to either side, where a spring counts turns
MOST_EXACT = 256  # candidates that are decided exactly
CLOSE = 1e-7


Shown = list[str | Form]  # a place in print, one entry a coordinate


@dataclass(frozen=True)
class RestPlace:
    """A place of rest.

    Attributes:
        shown: its coordinates in print.
        exact: the same as functions of the parameters; None for one that was found in numbers.
        at: its coordinates, those of `Rest.q`.
        kind: "stable", "unstable" or "undecided".
    """

    shown: Shown
    exact: tuple[Expr, ...] | None
    at: Array
    kind: str


@dataclass(frozen=True)
class Rests:
    """All places of rest that were found, and what was no such place.

    Attributes:
        rest: the forces that vanish there.
        places: the exact ones first.
        false: where coordinates are singular, though forces vanish.
        searched: the sentence that says how they were looked for.
        why: the key of the sentence that stands in place of a list; "" where there is one.
    """

    rest: Rest
    places: tuple[RestPlace, ...] = ()
    false: tuple[Shown, ...] = ()
    searched: Words | None = None
    why: str = ""


def places_of_rest(lesson: Lesson, chosen: Chosen) -> Rests:
    """Return where the mechanism stays at rest without drives."""
    rest = Rest(lesson, chosen)
    driven = any(joint.motion is not None for joint in lesson.scene.joints)
    if driven or lesson.graph.symbol(TIME) in reachable(rest.forces):
        return Rests(rest, why="driven")
    if not rest.q:
        return Rests(rest, why="all" if all(map(rest.never, rest.forces)) else "never")
    exact = rest.exact()
    found, how_searched = rest.searched()
    known = [np.array(chosen.of(*one)) for one in exact]
    places: list[tuple[Shown, tuple[Expr, ...] | None, Array]] = [
        ([_exactly(x) for x in one], one, place) for one, place in zip(exact, known, strict=True)
    ]
    others = [x for x in found if not any(rest.same(x, y) for y in known)]
    places += [([lesson.written(x) for x in place], None, place) for place in others]
    judge = Judge(lesson, chosen, rest.q, rest.forces)
    rests = [judge.rests(place) for _, _, place in places]
    return Rests(
        rest,
        tuple(
            RestPlace(shown, one, place, rest.stable(place))
            for (shown, one, place), ok in zip(places, rests, strict=True)
            if ok
        ),
        tuple(shown for (shown, _, _), ok in zip(places, rests, strict=True) if not ok),
        how_searched,
    )


def equilibrium_step(lesson: Lesson, rests: Rests) -> Step:
    """Return the table of equilibria, or a sentence where every position is one, none is, or time decides."""

    def step(*blocks: Block) -> Step:
        return Step("equilibria", lesson.say("equilibria"), blocks, show=("weights", "forces"))

    if rests.why:
        return step(lesson.say(f"equilibria.{rests.why}"))
    rest = rests.rest
    search = [
        *([rests.searched] if rests.searched else []),
        *([_left_out(lesson, rest, rests.false)] if rests.false else []),
    ]
    if not rests.places:
        return step(lesson.say("equilibria.none"), *search)
    rows = [
        (
            *place.shown,
            lesson.say(f"equilibria.{place.kind}"),
            lesson.say("equilibria.exact" if place.exact is not None else "equilibria.numeric"),
        )
        for place in rests.places
    ]
    blocks: list[Block] = [lesson.table((*map(named, rest.q), "equilibria.kind", "equilibria.how"), rows), *search]
    idle: list[Form] = [named(q) for q in lesson.state.q if q not in rest.q]
    if idle:
        blocks.append(lesson.say("equilibria.idle", names=together(idle)))
    return replace(step(*blocks), reason=lesson.say("equilibria.reason"))


class Rest:
    """The forces k_G + k_E - Q at q̇ = 0, and the coordinates q on which they depend."""

    def __init__(self, lesson: Lesson, chosen: Chosen) -> None:
        state, graph = lesson.state, lesson.graph
        slopes = gradient(lesson.energy.P, state.q)
        acting = substitute(generalized_forces(lesson.scene, graph), dict.fromkeys(state.qd, graph.zero))
        self.lesson, self.chosen = lesson, chosen
        self.forces = [a - b for a, b in zip(slopes, acting, strict=True)]
        units, needed = (
            dict(zip(state.q, SceneUnits(lesson.scene).coordinates, strict=True)),
            set(reachable(self.forces)),
        )
        self.q = [q for q in state.q if q in needed]
        self.angles = [units[q] == "rad" for q in self.q]

    def at(self, x: Array, nodes: list[Expr] | None = None) -> Array:
        """Return values at a place, of the forces where no nodes are given."""
        moved = self.chosen.moved(dict(zip(self.q, map(float, x), strict=True)))
        return np.array(moved.of(*(self.forces if nodes is None else nodes)))

    def never(self, force: Expr) -> bool:
        """Tell whether a force is zero for every value of the parameters, wherever the mechanism is."""
        from symdyn.dynamics import formulas

        if force.is_zero or set(reachable([force])).intersection(self.lesson.state.q):
            return force.is_zero
        return formulas([force], 1) == [Number.ZERO]

    @cached_property
    def turns(self) -> list[bool]:
        """Which coordinates are angles that a whole turn brings back, as it does not where a spring counts turns."""
        here = np.array([0.3 + 0.7 * k for k in range(len(self.q))])
        before, found = self.at(here), []
        for k, angle in enumerate(self.angles):
            after = self.at(here + 2 * np.pi * (np.arange(len(here)) == k))
            same = np.allclose(before, after, rtol=1e-9, atol=1e-9 * (1 + np.abs(before).max()))
            found.append(angle and bool(same))
        return found

    def same(self, x: Array, y: Array) -> bool:
        """Tell whether two places are one."""
        apart = [abs(_within(a - b)) if turns else abs(a - b) for a, b, turns in zip(x, y, self.turns, strict=True)]
        return max(apart) < 1e-6

    def exact(self) -> list[tuple[Expr, ...]]:
        """Return the places that are equilibria for every value of the parameters: angles in quarter turns.

        Slides are where linear springs hold them, at zero where nothing linear does.
        """
        for choice in ((0, 2, 1, -1), (0, 2)):
            candidates = list(product(*(choice if angle else (0,) for angle in self.angles)))
            if len(candidates) <= MOST_EXACT:
                break
        else:
            return []
        graph, found = self.lesson.graph, []
        for one in candidates:
            at = {q: graph.pi * Fraction(k, 2) if k else graph.zero for q, k in zip(self.q, one, strict=True)}
            try:
                at |= self._held(at)
                left = substitute(self.forces, at)
            except ZeroDivisionError:  # a spring of no length pulls nowhere
                continue
            if all(map(self.never, left)):
                found.append(tuple(at[q] for q in self.q))
        return found

    def _held(self, at: Mapping[Expr, Expr]) -> dict[Expr, Expr]:
        """Return where linear forces hold the slides, angles being given; nothing where they are not linear."""
        slides = [q for q, angle in zip(self.q, self.angles, strict=True) if not angle]
        along = [k for k, q in enumerate(self.lesson.state.q) if q in slides]
        turned = {q: x for q, x in at.items() if q not in slides}
        forces = substitute([self.forces[k] for k in along], turned)
        slopes = [x for force in forces for x in gradient(force, slides)]
        if not slides or set(reachable(slopes)).intersection(slides):
            return {}
        still = substitute(forces, dict.fromkeys(slides, self.lesson.graph.zero))
        field = Ratios([*slopes, *still])
        known, n = evaluate([*slopes, *still], field, field.values()), len(slides)
        stiffness = [known[k : k + n] for k in range(0, n * n, n)]
        try:
            shifts = field.solved(stiffness, [[field.neg(x)] for x in known[n * n :]])
        except (ZeroDivisionError, OverflowError):
            return {}
        return {q: field.form(x).express(self.lesson.graph) for q, (x,) in zip(slides, shifts, strict=True)}

    def searched(self) -> tuple[list[Array], Words]:
        """Return the places that were found in numbers, and the sentence that says how they were looked for."""
        say = self.lesson.say
        if len(self.q) > 1 or not self.angles[0]:
            return self._newton(), say("equilibria.newton", starts=str(STARTS))
        if self.turns[0]:
            return self._crossings(-np.pi, 1), say("equilibria.turn")
        known = [x for x in (float(x[0]) for x in self._newton()) if abs(x) < 2 * np.pi * MOST_TURNS]
        ends = (min(known, default=0.0), max(known, default=0.0))
        first, last = (int(np.floor((x + np.pi) / (2 * np.pi))) for x in ends)
        found = self._crossings((2 * first - 1) * np.pi, last - first + 1)
        while first > -MOST_TURNS and (more := self._crossings((2 * first - 3) * np.pi, 1)):
            first, found = first - 1, more + found
        while last < MOST_TURNS and (more := self._crossings((2 * last + 1) * np.pi, 1)):
            last, found = last + 1, found + more
        least, most = _quarter(2 * (2 * first - 1)), _quarter(2 * (2 * last + 1))
        return found, say("equilibria.turns", q=named(self.q[0]), least=least, most=most)

    def _crossings(self, start: float, turns: int) -> list[Array]:
        """Return where the forces change sign and vanish in start < q <= start + 2π turns, ascending."""
        g = next(node for node in self.forces if self.q[0] in set(reachable([node])))

        def at(x: float) -> float:
            try:
                return float(self.at(np.array([x]), [g])[0])
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
            if np.abs(self.at(np.array([high]))).max() <= 1e-9 * (1 + most):
                found.append(np.array([high]))
        return found

    def _newton(self) -> list[Array]:
        """Return roots of the forces that Newton's method finds from many starts, whole turns within (-π, π]."""
        rng, n = random.Random(1), len(self.forces)
        flat = [*self.forces, *(x for node in self.forces for x in gradient(node, self.q))]
        found: list[Array] = []

        def linear(x: Array) -> tuple[Array, Array]:
            values = self.at(x, flat)
            return values[:n], values[n:].reshape(n, len(self.q))

        for _ in range(STARTS):
            x = np.array([rng.uniform(-np.pi, np.pi) for _ in self.q])
            for _ in range(40):
                value, slope = linear(x)
                step = np.linalg.lstsq(slope, -value, rcond=1e-12)[0]
                x = x + step
                if np.abs(step).max() < 1e-12:
                    break
            value, slope = linear(x)
            size = 1 + np.abs(slope).max()
            isolated = np.linalg.matrix_rank(slope, tol=1e-9 * size) == len(self.q)
            if isolated and np.abs(value).max() <= 1e-9 * size:
                x = np.array([_within(a) if turns else a for a, turns in zip(x, self.turns, strict=True)])
                if not any(self.same(x, y) for y in found):
                    found.append(x)
        return sorted(found, key=lambda y: [round(float(a), 6) for a in y])

    def stable(self, place: Array) -> str:
        """Return "stable", "unstable" or, as where forces have no potential, "undecided"."""
        forces = [force for q, force in zip(self.lesson.state.q, self.forces, strict=True) if q in self.q]
        flat = [x for force in forces for x in gradient(force, self.q)]
        curvature = self.at(place, flat).reshape(len(forces), len(forces))
        size = np.abs(curvature).max() or 1.0
        if np.abs(curvature - curvature.T).max() > 1e-9 * size:
            return "undecided"
        least = np.linalg.eigvalsh(curvature).min()
        return "stable" if least > 1e-9 * size else "unstable" if least < -1e-9 * size else "undecided"


def _within(angle: float) -> float:
    turned = float(np.pi - (np.pi - angle) % (2 * np.pi))
    return np.pi if abs(turned + np.pi) < CLOSE else turned


def _left_out(lesson: Lesson, rest: Rest, places: Sequence[Shown]) -> Words:
    """Return the sentence about places where coordinates are singular and the bodies are not at rest."""
    parts: Shown = []
    for place in places:
        parts += ["; "] if parts else []
        for k, (q, x) in enumerate(zip(rest.q, place, strict=True)):
            parts += [*([", "] if k else []), named(q), " ≈ " if isinstance(x, str) else " = ", x]
    return lesson.say("equilibria.singular", places=Words(tuple(parts)))


def _exactly(node: Expr) -> Form:
    """Return a place as it is printed: parts of π, or a quotient of parameters."""
    field = Ratios([node])
    return field.form(evaluate([node], field, field.values())[0])


def _quarter(k: int) -> Form:
    """Return k π/2 as a form."""
    value = Fraction(k, 2)
    if not value:
        return Number(value)
    below = Number(Fraction(value.denominator)).power(-1)
    return Form.product((Number(Fraction(value.numerator)), Pi(), *((below,) if value.denominator > 1 else ())))
