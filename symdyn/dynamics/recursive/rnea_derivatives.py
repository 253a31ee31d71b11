"""Derivatives of the recursive Newton-Euler algorithm with respect to every move: closed forms, one recursion.

Reference: Singh, Russell and Wensing, Efficient analytical derivatives of rigid body dynamics using spatial vector
algebra, IEEE Robotics and Automation Letters 7 (2022); here in link frames, by second moments, and with velocities
measured from the origin at hand.

    i, j     a move, and i itself or one that carries it
    S        what the bodies beyond do per unit of the move, (angular, linear): (z, 0) for a turn, (0, z) for a slide
    S', S"   what becomes of S by the motion below its joint: (ω × z, 0) and (U z, a × z) for a turn, (0, ω × z) and
             (0, U z) for a slide
    I        moments of all bodies beyond joint i as one: m, h, J
    B        their Coriolis forces: B d = Σ m (r × (δω × v(r)), δω × v(r)) for a variation d = (δω, δv) of the velocity,
             which P = Σ m r v(r)ᵀ and l = Σ m v(r) hold: B d = (tr(P) δω - Pᵀ δω, δω × l)

    A = I S,    G = 2 Bᵀ S, a couple,    F₁ = 2 (B S + I S'),    F₀ = 2 B S' + I S" + S ×* f

and with all of them walked into frame j

    ∂f_j/∂r̈_i = A·S_j    ∂f_j/∂ṙ_i = F₁·S_j              ∂f_j/∂r_i = F₀·S_j
                          ∂f_i/∂ṙ_j = G·S_j + 2 A·S'_j    ∂f_i/∂r_j = G·S'_j + A·S"_j

f_i is the force of move i, r_i, ṙ_i, r̈_i are its position, rate and acceleration. Where laws of motion are the same in
all frames that glide, v(r) may count from any point's velocity: here from that of the origin, so that the origin's own
appears nowhere. An origin that moves back by p, and is slower by u, has

    l + m u,    P + p (l + m u)ᵀ + h uᵀ,    G + 2 u × (linear part of A)

P, l and u stand for twice of what they are, so that hardly anything is doubled. A joint is seen from the end of its
rise that is nearer to the ground, where all that it brings goes next.

Where several moves share one joint that is described by velocities of its own (a ball, a free body), they are one
block: S is constant in the frame of its last move, what is below is the parent's motion, and the sum of S' and of the
rate of S stands for 2 S' in F₁ and beside A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.links import Link, PlanarTurn, Turn
from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.rnea import LinkMotion, balance, carried, moving
from symdyn.graph import Expr
from symdyn.spatial import (
    Mat,
    Vec,
    add,
    add_matrices,
    apply,
    cross,
    dot,
    neg,
    scale,
    sub,
    transpose,
    zero_vector,
)

Twist = tuple[Vec, Vec]
"""Angular and linear part; of a wrench moment and force."""

Pair = tuple[int, int]


@dataclass(frozen=True)
class MoveDerivatives:
    """Forces of the moves, and their derivatives by pairs (force, move); where there is no entry they are zero.

    Attributes:
        forces: N m or N, by moves; rotors at the joints are left to others.
        by_position: N m/rad and the like.
        by_rate: N m s/rad and the like.
        by_acceleration: the mass matrix of the moves, kg m^2, kg m or kg.
    """

    forces: dict[int, Expr] = field(default_factory=dict)
    by_position: dict[Pair, Expr] = field(default_factory=dict)
    by_rate: dict[Pair, Expr] = field(default_factory=dict)
    by_acceleration: dict[Pair, Expr] = field(default_factory=dict)


@dataclass(frozen=True)
class _Way:
    """How an origin moves back: by p, and twice the velocity u of the old one as seen from the new one."""

    p: Vec
    u: Vec


@dataclass(frozen=True)
class _Subspace:
    """S, S', S" of one move, and 2 S' or what stands for it in a block; see the module's legend."""

    own: Twist
    first: Twist
    second: Twist
    twice: Twist


@dataclass(frozen=True)
class _Brought:
    """What a move brings to those that carry it, in the frame at hand: wrenches A, F₁ and F₀, and the couple G."""

    A: Twist
    G: Vec
    F1: Twist
    F0: Twist

    def moved(self, way: _Way) -> _Brought:
        """Return it about an origin that has moved back."""
        A, F1, F0 = ((add(n, cross(way.p, f)), f) for n, f in (self.A, self.F1, self.F0))
        return _Brought(A, add(self.G, cross(way.u, self.A[1])), F1, F0)

    def turned(self, turn: Turn) -> _Brought:
        """Return it in axes from which `turn` leads here."""
        A, F1, F0 = ((turn.back(n), turn.back(f)) for n, f in (self.A, self.F1, self.F0))
        return _Brought(A, turn.back(self.G), F1, F0)


@dataclass(frozen=True)
class _Composite:
    """Bodies beyond a joint as one; see the module's legend."""

    body: Moments
    P: Mat
    momentum: Vec

    def __add__(self, other: _Composite) -> _Composite:
        P, l = add_matrices(self.P, other.P), add(self.momentum, other.momentum)  # noqa: E741
        return _Composite(self.body + other.body, P, l)

    def moved(self, way: _Way) -> _Composite:
        """Return it about an origin that has moved back."""
        h, P, l = self.body.h, self.P, add(self.momentum, scale(self.body.m, way.u))  # noqa: E741
        rows = [tuple(P[r][c] + way.p[r] * l[c] + h[r] * way.u[c] for c in range(3)) for r in range(3)]
        return _Composite(self.body.shifted(way.p), (rows[0], rows[1], rows[2]), l)  # type: ignore[arg-type]

    def turned(self, turn: Turn) -> _Composite:
        """Return it in axes from which `turn` leads here."""
        body = Moments(self.body.m, turn.back(self.body.h), turn.tensor_back(self.body.J))
        return _Composite(body, _turned(turn, self.P), turn.back(self.momentum))

    def inertia(self, d: Twist) -> Twist:
        """Return I d: angular momentum about the origin, momentum."""
        (w, v), (m, h, J) = d, (self.body.m, self.body.h, self.body.J)
        return add(_less_trace(J, w), cross(h, v)), add(scale(m, v), cross(w, h))

    def coriolis(self, w: Vec) -> Twist:
        """Return 2 B d for the angular part of d."""
        return _less_trace(transpose(self.P), w), cross(w, self.momentum)

    def brought(self, S: _Subspace, wrench: Twist) -> _Brought:
        """Return what a move brings, at its own origin."""
        (w, v), (n, f) = S.own, wrench
        G = add(_less_trace(self.P, w), cross(self.momentum, v))
        F1 = _plus(self.coriolis(w), self.inertia(S.twice))
        acting = (add(cross(w, n), cross(v, f)), cross(w, f))
        return _Brought(
            self.inertia(S.own), G, F1, _plus(_plus(self.coriolis(S.first[0]), self.inertia(S.second)), acting)
        )


def rnea_derivatives(tree: LeanTree, qd: Sequence[Expr], qdd: Sequence[Expr], gravity: bool = True) -> MoveDerivatives:
    """Return the derivatives of the forces that bodies need, before they are gathered on the velocities.

    Args:
        tree: the mechanism; the moves of a block but the last carry no body.
        qd: velocities, shape (n,).
        qdd: their rates, shape (n,).
        gravity: whether gravity acts.
    """
    motion, rise, shift = _motions(tree, qd, qdd, gravity)
    S: dict[int, _Subspace] = {}
    for block in tree.block:
        S |= _subspaces(tree, block, motion, rise, shift) if block else {}
    wrench = [balance(body, moved) for body, moved in zip(tree.body, motion, strict=True)]
    beyond = [_composite(body, moved) for body, moved in zip(tree.body, motion, strict=True)]
    found = MoveDerivatives()
    for i in tree.inward():
        p, link = tree.parent[i], tree.link[i]
        foot, (n, f) = beyond[i].moved(rise[i]), wrench[i]
        alone = len(tree.block[i]) == 1
        here = (foot, (add(n, cross(rise[i].p, f)), f)) if alone else (beyond[i], wrench[i])
        for k in tree.block[i]:
            found.forces[k] = _work(here[1], S[k].own)
            _enter(tree, found, k, i, here[0].brought(S[k], here[1]), S, rise, shift)
        wrench[p] = _plus(wrench[p], link.wrench_back(*wrench[i]))
        if p:
            for turn in reversed(link.turns):
                foot = foot.turned(turn)
            beyond[p] = beyond[p] + foot.moved(shift[i])
    return found


def _motions(
    tree: LeanTree, qd: Sequence[Expr], qdd: Sequence[Expr], gravity: bool
) -> tuple[list[LinkMotion], list[_Way], list[_Way]]:
    """Return the motion of every frame, as `rnea` has it, and the ways along its rise and its shift."""
    still, zero = zero_vector(tree.graph), tree.graph.zero
    rate, acceleration, ends = tree.rates(qd), tree.accelerations(qd, qdd), tree.ends
    motion = [moving(still, still, neg(tree.gravity) if gravity else still)]
    rise, shift = [_Way(still, still)], [_Way(still, still)]
    for i in tree.outward():
        below, link, slides = motion[tree.parent[i]], tree.link[i], tree.slides[i]
        motion.append(carried(below, link, slides, rate[i], acceleration[i], ends[i]))
        up = (zero, zero, link.rise)
        x, y, z = cross(_twice(motion[i].w), up)
        rise.append(_Way(up, (x, y, z + rate[i] * 2) if slides else (x, y, z)))
        shift.append(_Way(link.shift, cross(_twice(below.w), link.shift)))
    return motion, rise, shift


def _subspaces(
    tree: LeanTree, block: Sequence[int], motion: Sequence[LinkMotion], rise: Sequence[_Way], shift: Sequence[_Way]
) -> dict[int, _Subspace]:
    """Return S and what becomes of it of every move of a block: at the foot of its rise, or (several) in its end."""
    zero, one = tree.graph.zero, tree.graph.one
    still, z = zero_vector(tree.graph), (zero, zero, one)
    last = block[-1]
    if len(block) == 1:
        moved, below, link = motion[last], motion[tree.parent[last]], tree.link[last]
        across, twice = _cross_z(moved.w), _cross_z(_twice(moved.w))
        column = (moved.U[0][2], moved.U[1][2], moved.U[2][2])
        if tree.slides[last]:
            return {last: _Subspace((still, z), (still, across), (still, column), (still, twice))}
        foot = link.out(add(below.a, apply(below.U, link.shift)))
        return {last: _Subspace((z, still), (across, still), (column, _cross_z(foot)), (twice, still))}
    below, v = motion[tree.parent[block[0]]], still  # as if the joint were locked; v as seen from the origin
    S: dict[int, Twist] = {}
    for i in block:
        link = tree.link[i]
        before, below = below, carried(below, link, tree.slides[i], zero, zero, False)
        v = link.out(add(v, sub(cross(before.w, link.shift), _half(shift[i].u))))
        v = add(v, sub(cross(below.w, rise[i].p), _half(rise[i].u)))
        S = {k: _out(link, twist) for k, twist in S.items()}
        S[i] = (still, z) if tree.slides[i] else (z, still)
    locked, rate = (below.w, v), (motion[last].w, still)
    spatial = (below.dw, sub(below.a, cross(below.w, v)))
    found = {}
    for k, own in S.items():
        first = _bracket(locked, own)
        second = _plus(_bracket(spatial, own), _bracket(locked, first))
        found[k] = _Subspace(own, first, second, _plus(first, _bracket(rate, own)))
    return found


def _composite(body: Moments, motion: LinkMotion) -> _Composite:
    """Return one body: P = -J ω×, l = ω × h, twice."""
    w = _twice(motion.w)
    return _Composite(body, (cross(w, body.J[0]), cross(w, body.J[1]), cross(w, body.J[2])), cross(w, body.h))


def _enter(
    tree: LeanTree,
    found: MoveDerivatives,
    k: int,
    last: int,
    now: _Brought,
    S: dict[int, _Subspace],
    rise: Sequence[_Way],
    shift: Sequence[_Way],
) -> None:
    """Read what move k brings, at the end of its block, to itself and to all that carry it."""
    j = last
    while j:
        block = tree.block[j]
        alone = len(block) == 1
        if alone and j != last:
            now = now.moved(rise[j])
        for m in block:
            s = S[m]
            found.by_acceleration[k, m] = found.by_acceleration[m, k] = _work(now.A, s.own)
            if j != last or not alone:
                found.by_rate[k, m] = dot(now.G, s.own[0]) + _work(now.A, s.twice)
                found.by_position[k, m] = dot(now.G, s.first[0]) + _work(now.A, s.second)
            if j != last or alone:
                found.by_rate[m, k] = _work(now.F1, s.own)
                found.by_position[m, k] = _work(now.F0, s.own)
        if not tree.parent[j]:
            break
        if not alone:
            now = now.moved(rise[j])
        for turn in reversed(tree.link[j].turns):
            now = now.turned(turn)
        now, j = now.moved(shift[j]), tree.parent[j]


def _out(link: Link, twist: Twist) -> Twist:
    """Return a twist of the parent's frame in the link's own."""
    w, v = twist
    turned = link.out(w)
    return turned, add(link.out(add(v, cross(w, link.shift))), scale(link.rise, _cross_z(turned)))


def _twice(x: Vec) -> Vec:
    return scale(2, x)


def _half(x: Vec) -> Vec:
    return scale(x[0].graph.one / 2, x)


def _plus(a: Twist, b: Twist) -> Twist:
    return add(a[0], b[0]), add(a[1], b[1])


def _work(wrench: Twist, twist: Twist) -> Expr:
    return dot(wrench[0], twist[0]) + dot(wrench[1], twist[1])


def _bracket(a: Twist, b: Twist) -> Twist:
    """Return a × b: the rate of a twist b that moves with a."""
    return cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0]))


def _cross_z(x: Vec) -> Vec:
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
        columns = transpose((turn.back(P[0]), turn.back(P[1]), turn.back(P[2])))  # of P Rᵀ
        return transpose((turn.back(columns[0]), turn.back(columns[1]), turn.back(columns[2])))
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
    return (tuple(rows[0]), tuple(rows[1]), tuple(rows[2]))  # type: ignore[return-value]
