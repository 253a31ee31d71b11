"""Geometry of taut ropes: straight parts from tangent point to tangent point, and what lies around wheels.

    d        way from one place of the rope to the next: points, or centres of wheels
    n        axis of the wheels, across the plane of d        ρ    ± radius, + where the rope turns left; 0 of a point
    t, s     direction and length of the straight part:  s² = d² - Δ²,  t = (s d + Δ d × n) / d²,  Δ = ρ' - ρ
    φ        angle around a wheel, from the direction t that comes to the direction t' that leaves, above 0 and below 2π

A unit of tension exerts -t on the later place, at its tangent point, and t on the former; so L changes by t · (velocity
of the one tangent point, as a point of its body, less that of the other), and what wheels turn by has no part in it:
it cancels between both sides of each. A wheel that the rope ends on winds it up: L is counted from the start, where
nothing is wound, by the turn of the wheel's joint and the swing of t, less than half a turn either way.

Where s² is the square of a polynomial, as that of a load which hangs straight down, s is that polynomial, positive at
the start.

Reference: the tangents of two circles; Pott, Cable-Driven Parallel Robots (2018), section 3.3, for pulleys.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

from symdyn.algebra import Compactor, TrigonometricRing
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass
from symdyn.graph import Expr, Graph, Op, evaluate, substitute
from symdyn.scene import Scene
from symdyn.scene.joints import JOINTS, start_of, unit
from symdyn.scene.values import Place
from symdyn.spatial import Mat, Transform, Vec, Wrench, add, cross, dot, neg, scale, zero_vector


@dataclass(frozen=True)
class Straight:
    """A straight part, axes of the body of its first place: t, s, and what a unit of tension does about the last."""

    direction: Vec
    length: Expr
    wrench: Wrench


@dataclass(frozen=True)
class Taut:
    """Ropes of a scene on a graph."""

    scene: Scene
    graph: Graph

    def straight(self, near: Place, far: Place, X: Transform) -> Straight:
        """Return the straight part between two places; X places the later one in the axes of the former.

        Raises:
            DerivationError: the way between wheels, or from one, leaves their plane.
        """
        d, square = X.p, dot(X.p, X.p)
        first, second = self._radius(near), self._radius(far)
        step = second - first
        n = self._axis(near, far, X)
        s = self.root(square - step * step, near.ordered)
        across = zero_vector(self.graph) if n is None else scale(step, cross(d, n))
        x, y, z = (self._share(part, square if n else s) for part in (add(scale(s, d), across) if n else d))
        t = (x, y, z)
        moment = zero_vector(self.graph) if n is None else scale(-second, n)
        return Straight(t, s, Wrench(neg(t), moment))

    def length(self, ends: Sequence[Place], poses: Sequence[Transform]) -> Expr:
        """Return L of a rope, m; `poses` are X of its straight parts."""
        parts = [self.straight(*pair, X) for pair, X in zip(pairwise(ends), poses, strict=True)]
        total = [one.length for one in parts]
        for wheel, cosine, sine in self._around(ends, poses, parts):
            total.append(wheel.radius.express(self.graph) * self._wrap(cosine, sine))
        if ends[0].turn:
            total.append(-self._wound(ends[0], parts[0].direction))
        if ends[-1].turn:
            total.append(self._wound(ends[-1], poses[-1].R.T @ parts[-1].direction))
        return self.graph.total(total)

    def _around(
        self, ends: Sequence[Place], poses: Sequence[Transform], parts: Sequence[Straight]
    ) -> Iterator[tuple[Place, Expr, Expr]]:
        """Yield the wheels that a rope passes, with cosine and sine of the angle that it lies around each."""
        for wheel, X, before, after in zip(ends[1:-1], poses, parts, parts[1:], strict=False):
            if wheel.turn:
                comes, leaves = X.R.T @ before.direction, after.direction
                sine = dot(unit(wheel.axis, self.graph), cross(comes, leaves)) * wheel.turn
                yield wheel, dot(comes, leaves), sine

    def lifts(self, name: str, ends: Sequence[Place], placed: Mapping[str, Transform]) -> Iterator[tuple[Expr, str]]:
        """Yield what falls to zero where a rope lifts off a wheel that it passes, and words.

        15 (1 - cos φ) + 8 sin φ is negative from 0.98 rad, 2 atan(8/15), before a whole turn to its end, and 0.001 rad
        is left where L would jump.
        """
        poses = [X for *_, X in self._parts(ends, placed)]
        parts = [self.straight(*pair, X) for pair, X in zip(pairwise(ends), poses, strict=True)]
        for wheel, cosine, sine in self._around(ends, poses, parts):
            yield (
                (1 - cosine) * 15 + (sine - Fraction(1, 1000)) * 8,
                f"rope {name}: what lies around its wheel on {wheel.body} is nothing, or almost a turn; "
                "there the rope takes another way, which these equations do not know",
            )

    def placed(self, ends: Sequence[Place], placed: Mapping[str, Transform]) -> Expr:
        """Return L of a rope, m, from the placement of every body."""
        return self.length(ends, [X for *_, X in self._parts(ends, placed)])

    def pulls(self, ends: Sequence[Place], placed: Mapping[str, Transform]) -> list[tuple[Place, Wrench]]:
        """Return what a unit of tension does about the places of a rope, ground axes, twice where it passes."""
        found = []
        for near, far, frame, X in self._parts(ends, placed):
            there = self.straight(near, far, X).wrench.rotated(frame.R)
            found += [(near, -there.about(frame.R @ X.p)), (far, there)]
        return found

    def tangents(self, ends: Sequence[Place], placed: Mapping[str, Transform]) -> list[Vec]:
        """Return where every straight part of a rope begins and ends, ground axes, m."""
        found = []
        for near, far, frame, X in self._parts(ends, placed):
            n, t = self._axis(near, far, X), self.straight(near, far, X).direction
            out = zero_vector(self.graph) if n is None else cross(t, n)
            found += [frame.point(scale(self._radius(near), out)), frame.point(add(X.p, scale(self._radius(far), out)))]
        return found

    def _parts(
        self, ends: Sequence[Place], placed: Mapping[str, Transform]
    ) -> Iterator[tuple[Place, Place, Transform, Transform]]:
        """Yield neighbours, the frame at the first, in axes of the ground between points alone, and X."""
        frames = [placed[end.body] @ self.seat(end)[1] for end in ends]
        if not any(end.turn for end in ends):  # which is shorter
            frames = [Transform(Mat.identity(self.graph), frame.p) for frame in frames]
        for (near, far), (a, b) in zip(pairwise(ends), pairwise(frames), strict=True):
            yield near, far, a, a.inverse() @ b

    def seat(self, place: Place) -> tuple[str, Transform]:
        """Return the body of a place, and the frame there in its axes."""
        x, y, z = (entry.express(self.graph) for entry in place.at)
        return place.body, Transform(Mat.identity(self.graph), (x, y, z))

    def _radius(self, place: Place) -> Expr:
        return place.radius.express(self.graph) * place.turn

    def _axis(self, near: Place, far: Place, X: Transform) -> Vec | None:
        """Return the axis of the wheels of a straight part; None between points."""
        axes = [unit(near.axis, self.graph)] if near.turn else []
        axes += [X.R @ unit(far.axis, self.graph)] if far.turn else []
        if not axes:
            return None
        if not all(self._vanishes(x) for x in (dot(axes[0], X.p), *cross(axes[0], axes[-1]))):
            raise DerivationError(
                f"{self.scene.name}: a rope from {near.body} to {far.body} leaves the plane of its wheel, whose "
                "axis is not across the way; place both in one plane with axes across it, or lead it through a point"
            )
        return axes[0]

    def _wrap(self, cosine: Expr, sine: Expr) -> Expr:
        graph = self.graph
        for quarters, (c, s) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))):
            if self._vanishes(cosine - c) and self._vanishes(sine - s):
                return graph.pi * quarters / 2
        return graph.pi + graph.function(Op.ATAN2, -sine, -cosine)

    def _wound(self, wheel: Place, t: Vec) -> Expr:
        """Return what a wheel that the rope ends on has let go since the start, m; t in axes of its body."""
        graph, n, turn = self.graph, unit(wheel.axis, self.graph), self._turned(wheel)
        places = zip(self.scene.coordinates, start_of(self.scene).position, strict=True)
        start = {graph.symbol(q): x.express(graph) for q, x in places}
        across = scale(graph.sin(turn), cross(n, t))  # in axes that do not turn with the wheel
        x, y, z = (self._share(part, graph.one) for part in add(scale(graph.cos(turn), t), across))
        now = (x, y, z)
        x, y, z, before = substitute([*now, turn], start)
        cosine, sine = dot((x, y, z), now), dot(n, cross((x, y, z), now))
        swung = graph.zero if self._vanishes(sine) else graph.function(Op.ATAN2, sine, cosine)
        return wheel.radius.express(graph) * wheel.turn * (turn - before - swung)

    def _turned(self, wheel: Place) -> Expr:
        """Return by what the joint has turned that carries the body of a wheel, about the axis of the wheel."""
        joint = next((joint for joint in self.scene.joints if joint.child == wheel.body), None)
        if joint is not None and joint.moves and JOINTS[joint.type].velocities(joint) == ("rad",):
            axis = joint.tip.transform(self.graph).R.T @ unit(joint.axis, self.graph)
            for sense in (1, -1):
                if all(self._vanishes(x) for x in add(axis, scale(-sense, unit(wheel.axis, self.graph)))):
                    return joint.position(self.graph) * sense
        return self.graph.zero

    def _share(self, part: Expr, whole: Expr) -> Expr:
        """Return a component of a direction, as -1, 0 or 1 where it is that everywhere."""
        for value in (0, 1, -1):
            if self._vanishes(part - whole * value):
                return self.graph.constant(value)
        return part / whole

    def _vanishes(self, entry: Expr) -> bool:
        """Tell whether an entry is zero everywhere, as far as it is a polynomial."""
        if entry.is_zero:
            return True
        try:
            ring = TrigonometricRing([entry])
            return ring.is_zero(evaluate([entry], ring, ring.values([entry]))[0])
        except DerivationError:
            return False

    def root(self, square: Expr, guessed: bool = False) -> Expr:
        """Return the root, the polynomial positive at the start if there is one; `guessed` puts 1 for what is free."""
        from symdyn.algebra import Floats  # starts NumPy

        try:
            ring = TrigonometricRing([square])
            found = ring.square_root(evaluate([square], ring, ring.values([square]))[0])
            node = self.graph.zero if found is None else Compactor(ring, ())(found).express(self.graph)
            (value,) = evaluate([node], Floats(), self._start(guessed))
        except (DerivationError, KeyError):  # no polynomial, or a length that is free
            value = 0.0
        return self.graph.sqrt(square) if value == 0 else node if value > 0 else -node

    def _start(self, guessed: bool) -> dict[Expr, float]:
        """Values of parameters, and of coordinates at the start, as far as they are known."""
        values: dict[str, Fraction | float] = {}
        letters = [(p.name, p.value) for p in (*self.scene.parameters, *(self.scene.given if guessed else ()))]
        for name, x in [*letters, *zip(self.scene.coordinates, start_of(self.scene).position, strict=True)]:
            value = (1 if guessed else None) if x is None else x.known_at(values)
            values |= {} if value is None else {name: value}
        return {self.graph.symbol(name): float(value) for name, value in values.items()}
