"""Step: where the mechanism stays at rest without drives.

At rest k_G + k_E = Q. Quarter turns are decided exactly. Where one angle alone matters, the others are the sign changes
of k_G + k_E - Q in small steps; elsewhere they are what Newton's method finds, and the lesson says so. A position is
stable where the potential of gravity, springs and constant forces has a minimum: all eigenvalues of
∂(k_G + k_E - Q)/∂q are positive.

Where angles are singular these forces may vanish though no body is in balance; such places are named.

    v = J q̇          velocities of all bodies: of a point, and angular
    f = Jᵀ w         generalized forces at rest, of the forces w against those velocities
    J⁺ᵀ f            the part of w that works on what the bodies can do: zero at rest, and only there

There J loses rank, so f says less than w: a rotation that the bodies can make is none that the coordinates can tell.
The part that works is then looked at beside the place, where J has its rank.
"""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import product

import numpy as np

from symdyn.algebra.form import Form, Number, Pi, power_of, product_of
from symdyn.draw.places import Array
from symdyn.dynamics.mechanism.loads import generalized_forces
from symdyn.dynamics.mechanism.prescribed import TIME
from symdyn.graph import Expr, gradient, reachable, substitute, tangents
from symdyn.scene.units import coordinate_units
from symdyn.teach.document import Block, Step, Words
from symdyn.teach.lesson import Lesson, named, together
from symdyn.teach.roads.lagrange.velocities import angular_velocity
from symdyn.teach.shown_state import Chosen

STARTS = 60
STEPS = 720  # of a turn
MOST_TURNS = 8  # to either side, where a spring counts turns
MOST_EXACT = 256  # candidates that are decided exactly
CLOSE = 1e-7

BESIDE = 1e-5  # rad or m
WORKS = 1e-3  # of what works elsewhere: more than this is no rest
TURNED = 1e-6  # of the largest singular value of J: less is a motion that the coordinates do not tell
PLACES = 4

Shown = list[str | Form]  # a place in print, one entry a coordinate


def equilibrium_step(lesson: Lesson, chosen: Chosen) -> Step:
    """Return the table of equilibria, or a sentence where every position is one, none is, or time decides."""
    rest = Rest(lesson, chosen)

    def step(*blocks: Block) -> Step:
        return Step("equilibria", lesson.say("equilibria"), blocks)

    driven = any(joint.motion is not None for joint in lesson.scene.joints)
    if driven or lesson.graph.symbol(TIME) in reachable(rest.forces):
        return step(lesson.say("equilibria.driven"))
    if not rest.q:
        return step(lesson.say("equilibria.all" if all(map(rest.never, rest.forces)) else "equilibria.never"))
    exact = rest.exact()
    found, how_searched = rest.searched()
    known = [np.array([float(Fraction(k)) * np.pi / 2 for k in one]) for one in exact]
    places: list[tuple[Shown, str, Array]] = [
        ([_quarter(k) for k in one], "exact", place) for one, place in zip(exact, known, strict=True)
    ]
    others = [x for x in found if not any(rest.same(x, y) for y in known)]
    places += [([lesson.written(x) for x in place], "numeric", place) for place in others]
    judge, rows, false = Judge(lesson, rest), [], []
    for shown, how, place in places:
        if judge.rests(place):
            kind = rest.stable(place)
            rows.append((*shown, lesson.say(f"equilibria.{kind}"), lesson.say(f"equilibria.{how}")))
        else:
            false.append(shown)
    search = [how_searched, *([_left_out(lesson, rest, false)] if false else [])]
    if not rows:
        return step(lesson.say("equilibria.none"), *search)
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
        units, needed = dict(zip(state.q, coordinate_units(lesson.scene), strict=True)), set(reachable(self.forces))
        self.q = [q for q in state.q if q in needed]
        self.angles = [units[q] == "rad" for q in self.q]

    def at(self, x: Array, nodes: list[Expr] | None = None) -> Array:
        """Return values at a place, of the forces where no nodes are given."""
        moved = self.chosen.moved(dict(zip(self.q, map(float, x), strict=True)))
        return np.array(moved.of(*(self.forces if nodes is None else nodes)))

    def never(self, force: Expr) -> bool:
        """Tell whether a force is zero for every value of the parameters, wherever the mechanism is."""
        from symdyn.dynamics.closed_forms.frames_and_parameters import vanishes

        return force.is_zero or (not set(reachable([force])).intersection(self.lesson.state.q) and vanishes(force))

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

    def exact(self) -> list[tuple[int, ...]]:
        """Return the places in quarter turns, slides at zero, that are equilibria for every value of the parameters."""
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
                left = substitute(self.forces, at)
            except ZeroDivisionError:  # a spring of no length pulls nowhere
                continue
            if all(map(self.never, left)):
                found.append(one)
        return found

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


class Judge:
    """Tells places of rest from places where coordinates are singular."""

    def __init__(self, lesson: Lesson, rest: Rest) -> None:
        self.rest, self.q, self.rank = rest, lesson.state.q, 0
        self.J: list[Expr] = []
        for body in lesson.scene.bodies:
            origin = tangents(lesson.placed[body.name].p, lesson.state.velocity)
            self.J += [x for v in (*origin, *angular_velocity(lesson, body)) for x in gradient(v, lesson.state.qd)]
        rng = random.Random(2)
        around = [self._measured(np.array([rng.uniform(-1.5, 1.5) for _ in self.q])) for _ in range(PLACES)]
        self.rank = max((rank for rank, _ in around), default=0)
        self.size = max((work for _, work in around), default=0.0)

    def rests(self, place: Array) -> bool:
        """Tell whether forces whose generalized forces vanish there do no work on anything that the bodies can do."""
        at = dict(zip(self.rest.q, place, strict=True))
        rng, q = random.Random(3), np.array([at.get(q, self.rest.chosen.values[q]) for q in self.q])
        if self._measured(q)[0] >= self.rank:
            return True
        beside = [q + BESIDE * np.array([rng.uniform(0.5, 1) for _ in q]) for _ in range(PLACES)]
        return max(self._measured(one)[1] for one in beside) <= WORKS * self.size

    def _measured(self, q: Array) -> tuple[int, float]:
        """Return the rank of J and the size of what works."""
        n, at = len(self.q), self.rest.chosen.moved(dict(zip(self.q, map(float, q), strict=True)))
        try:
            flat = np.array(at.of(*self.rest.forces, *self.J))
        except (ArithmeticError, ValueError):  # a spring of no length, a pole
            return self.rank, 0.0
        f, J = flat[:n], flat[n:].reshape(-1, n)
        rank = int(np.linalg.matrix_rank(J, tol=TURNED * np.abs(J).max(initial=0.0)))
        return rank, float(np.linalg.norm(np.linalg.pinv(J.T, rcond=1e-9) @ f))


def _within(angle: float) -> float:
    turned = float(np.pi - (np.pi - angle) % (2 * np.pi))
    return np.pi if abs(turned + np.pi) < CLOSE else turned


def _left_out(lesson: Lesson, rest: Rest, places: list[Shown]) -> Words:
    """Return the sentence about places where coordinates are singular and the bodies are not at rest."""
    parts: Shown = []
    for place in places:
        parts += ["; "] if parts else []
        for k, (q, x) in enumerate(zip(rest.q, place, strict=True)):
            parts += [*([", "] if k else []), named(q), " ≈ " if isinstance(x, str) else " = ", x]
    return lesson.say("equilibria.singular", places=Words(tuple(parts)))


def _quarter(k: int) -> Form:
    """Return k π/2 as a form."""
    value = Fraction(k, 2)
    if not value:
        return Number(value)
    below = power_of(Number(Fraction(value.denominator)), -1)
    return product_of((Number(Fraction(value.numerator)), Pi(), *((below,) if value.denominator > 1 else ())))
