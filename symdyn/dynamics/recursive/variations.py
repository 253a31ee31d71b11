"""What a move does to the bodies beyond it, and what that brings to those that carry it: nouns of `rnea_derivatives`.

Its legend holds here too: S, S', S", I, B, P, l, A, G, F₁, F₀. Everything is told in one frame, about its origin, by
velocities as seen from that origin.
"""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.dynamics.recursive.links import Moments, PlanarTurn, Turn
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, cross, dot, scale

Twist = tuple[Vec, Vec]
"""Angular and linear part; of a wrench moment and force."""


@dataclass(frozen=True)
class VariationWay:
    """How an origin moves back: by p, and twice the velocity u of the old one as seen from the new one."""

    p: Vec
    u: Vec


@dataclass(frozen=True)
class Subspace:
    """S, S', S" of one move, and 2 S' or what stands for it in a block."""

    own: Twist
    first: Twist
    second: Twist
    twice: Twist


@dataclass(frozen=True)
class Brought:
    """What a move brings to those that carry it: wrenches A, F₁ and F₀, and the couple G."""

    A: Twist
    G: Vec
    F1: Twist
    F0: Twist

    def moved(self, way: VariationWay) -> Brought:
        """Return it about an origin that has moved back."""
        A, F1, F0 = ((add(n, cross(way.p, f)), f) for n, f in (self.A, self.F1, self.F0))
        return Brought(A, add(self.G, cross(way.u, self.A[1])), F1, F0)

    def turned(self, turn: Turn) -> Brought:
        """Return it in axes from which `turn` leads here."""
        A, F1, F0 = ((turn.back(n), turn.back(f)) for n, f in (self.A, self.F1, self.F0))
        return Brought(A, turn.back(self.G), F1, F0)


@dataclass(frozen=True)
class Composite:
    """Several bodies as one: moments, and twice of P and l."""

    body: Moments
    P: Mat
    momentum: Vec

    def __add__(self, other: Composite) -> Composite:
        """Return both together."""
        P, l = self.P + other.P, add(self.momentum, other.momentum)  # noqa: E741
        return Composite(self.body + other.body, P, l)

    def moved(self, way: VariationWay) -> Composite:
        """Return it about an origin that has moved back."""
        h, P, l = self.body.h, self.P, add(self.momentum, scale(self.body.m, way.u))  # noqa: E741
        rows = ([P[r][c] + way.p[r] * l[c] + h[r] * way.u[c] for c in range(3)] for r in range(3))
        return Composite(self.body.shifted(way.p), Mat((x, y, z) for x, y, z in rows), l)

    def turned(self, turn: Turn) -> Composite:
        """Return it in axes from which `turn` leads here."""
        body = Moments(self.body.m, turn.back(self.body.h), turn.tensor_back(self.body.J))
        return Composite(body, _turned(turn, self.P), turn.back(self.momentum))

    def inertia(self, d: Twist) -> Twist:
        """Return I d: angular momentum about the origin, momentum."""
        (w, v), (m, h, J) = d, (self.body.m, self.body.h, self.body.J)
        return add(_less_trace(J, w), cross(h, v)), add(scale(m, v), cross(w, h))

    def coriolis(self, w: Vec) -> Twist:
        """Return 2 B d for the angular part of d; the linear one takes no part."""
        return _less_trace(self.P.T, w), cross(w, self.momentum)

    def brought(self, S: Subspace, wrench: Twist) -> Brought:
        """Return what a move brings, for the wrench that moves the bodies."""
        (w, v), (n, f) = S.own, wrench
        G = add(_less_trace(self.P, w), cross(self.momentum, v))
        F1 = plus(self.coriolis(w), self.inertia(S.twice))
        F0 = plus(self.coriolis(S.first[0]), self.inertia(S.second))
        acting = (add(cross(w, n), cross(v, f)), cross(w, f))
        return Brought(self.inertia(S.own), G, F1, plus(F0, acting))


def body_alone(body: Moments, twice: Vec) -> Composite:
    """Return one body, for twice its angular velocity: P = -J ω×, l = ω × h."""
    P = Mat(cross(twice, row) for row in body.J)
    return Composite(body, P, cross(twice, body.h))


def plus(a: Twist, b: Twist) -> Twist:
    """Return the sum."""
    return add(a[0], b[0]), add(a[1], b[1])


def work(wrench: Twist, twist: Twist) -> Expr:
    """Return the power of a wrench on a twist."""
    return dot(wrench[0], twist[0]) + dot(wrench[1], twist[1])


def bracket(a: Twist, b: Twist) -> Twist:
    """Return a × b: the rate of a twist b that moves with a."""
    return cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0]))


def cross_z(x: Vec) -> Vec:
    """Return x × z."""
    return (x[1], -x[0], x[0].graph.zero)


def _less_trace(M: Mat, w: Vec) -> Vec:
    """Return tr(M) w - M w."""
    return (
        (M[1][1] + M[2][2]) * w[0] - M[0][1] * w[1] - M[0][2] * w[2],
        (M[0][0] + M[2][2]) * w[1] - M[1][0] * w[0] - M[1][2] * w[2],
        (M[0][0] + M[1][1]) * w[2] - M[2][0] * w[0] - M[2][1] * w[1],
    )


def _turned(turn: Turn, P: Mat) -> Mat:
    """Return R P Rᵀ of a matrix that need not be symmetric: about an axis for 12 multiplications."""
    if not isinstance(turn, PlanarTurn):
        columns = Mat(map(turn.back, P)).T  # of P Rᵀ
        return Mat(map(turn.back, columns)).T
    k, i, j, c, s = turn.k, (turn.k + 1) % 3, (turn.k + 2) % 3, turn.cos, turn.sin
    rows = [list(row) for row in P]
    if c.is_zero:
        rows[i][i], rows[j][j], rows[i][j], rows[j][i] = P[j][j], P[i][i], -P[j][i], -P[i][j]
    elif not s.is_zero:
        w = c * (P[i][i] - P[j][j]) - s * (P[i][j] + P[j][i])
        rows[i][i], rows[j][j] = P[j][j] + c * w, P[i][i] - c * w
        rows[i][j], rows[j][i] = P[i][j] + s * w, P[j][i] + s * w
    rows[i][k], rows[j][k] = c * P[i][k] - s * P[j][k], s * P[i][k] + c * P[j][k]
    rows[k][i], rows[k][j] = c * P[k][i] - s * P[k][j], s * P[k][i] + c * P[k][j]
    return Mat((x, y, z) for x, y, z in rows)
