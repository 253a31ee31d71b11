"""Derivatives of the recursive Newton-Euler algorithm by every elementary joint: closed forms, one recursion.

Reference: Singh, Russell and Wensing, Efficient analytical derivatives of rigid body dynamics using spatial vector
algebra, IEEE Robotics and Automation Letters 7 (2022); here in link frames, by second moments, and with velocities
measured from the origin at hand.

    i, j     an elementary joint (revolute or prismatic, of one degree of freedom), and i itself or an ancestor of it
    S        motion subspace, twist per unit of its rate: (z, 0) of a revolute joint, (0, z) of a prismatic one
    S', S"   its first and second rate by the motion of the parent: (ω × z, 0) and (U z, a × z) of a revolute joint,
             (0, ω × z) and (0, U z) of a prismatic one
    I        composite inertia of the subtree of joint i: mass m, first moment h, second moments J
    B        their Coriolis forces: B d = Σ m (r × (δω × v(r)), δω × v(r)) for a variation d = (δω, δv) of the velocity,
             which P = Σ m r v(r)ᵀ and l = Σ m v(r) hold: B d = (tr(P) δω - Pᵀ δω, δω × l)

    A = I S,    G = 2 Bᵀ S, a couple,    F₁ = 2 (B S + I S'),    F₀ = 2 B S' + I S" + S ×* f

and with all of them transformed to frame j

    ∂f_j/∂r̈_i = A·S_j    ∂f_j/∂ṙ_i = F₁·S_j              ∂f_j/∂r_i = F₀·S_j
                          ∂f_i/∂ṙ_j = G·S_j + 2 A·S'_j    ∂f_i/∂r_j = G·S'_j + A·S"_j

f_i is the force of elementary joint i, r_i, ṙ_i, r̈_i are its position, rate and acceleration. Since laws of motion are
the same in all inertial frames, v(r) may be taken relative to any point: here to the origin, whose own velocity so
appears nowhere. Shifted to an origin at -p, whose velocity is less by u, they become

    l + m u,    P + p (l + m u)ᵀ + h uᵀ,    G + 2 u × (linear part of A)

P, l and u hold twice their values, which saves operations. Contributions of a joint are about the origin on its axis
before its joint offset (the constant or variable translation along z), the one nearer to the ground.

Where several elementary joints make up one joint that has velocities of its own (spherical, free), they are one
block: S is constant in the frame of its last, S' and S" are by the motion of the block's parent, and the sum of S' and
of the rate of S stands for 2 S' in F₁ and beside A. Forces are (moment, force), twists (angular, linear).
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.recursive.links import (
    JointTransform,
    LinkMotion,
    Moments,
    SpatialForce,
    Turn,
    Twist,
    base_motion,
    plus,
    power,
    propagate,
)
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.frozen import dataclass, field
from symdyn.graph import Expr
from symdyn.spatial import Mat, Vec, add, cross, dot, neg, scale, sub, zero_vector


@dataclass(frozen=True)
class OriginShift:
    """A shift of the origin to -p, and twice the velocity u of the old one relative to the new one."""

    p: Vec
    u: Vec


@dataclass(frozen=True)
class Subspace:
    """S, S', S" of one elementary joint, and 2 S' or what stands for it in a block."""

    twist: Twist
    first: Twist
    second: Twist
    twice: Twist


@dataclass(frozen=True)
class Contribution:
    """What an elementary joint contributes to the derivatives of its ancestors' forces: A, F₁ and F₀, the couple G."""

    A: SpatialForce
    G: Vec
    F1: SpatialForce
    F0: SpatialForce

    def shifted(self, by: OriginShift) -> Contribution:
        A, F1, F0 = ((add(n, cross(by.p, f)), f) for n, f in (self.A, self.F1, self.F0))
        return Contribution(A, add(self.G, cross(by.u, self.A[1])), F1, F0)

    def turned(self, turn: Turn) -> Contribution:
        """Return it in axes from which `turn` leads here."""
        A, F1, F0 = ((turn.back(n), turn.back(f)) for n, f in (self.A, self.F1, self.F0))
        return Contribution(A, turn.back(self.G), F1, F0)


@dataclass(frozen=True)
class Composite:
    """A composite body: inertial moments, and twice P and l."""

    body: Moments
    P: Mat
    momentum: Vec

    def __add__(self, other: Composite) -> Composite:
        P, l = self.P + other.P, add(self.momentum, other.momentum)  # noqa: E741
        return Composite(self.body + other.body, P, l)

    def shifted(self, by: OriginShift) -> Composite:
        h, P, l = self.body.h, self.P, add(self.momentum, scale(self.body.m, by.u))  # noqa: E741
        rows = ([P[r][c] + by.p[r] * l[c] + h[r] * by.u[c] for c in range(3)] for r in range(3))
        return Composite(self.body.shifted(by.p), Mat((x, y, z) for x, y, z in rows), l)

    def turned(self, turn: Turn) -> Composite:
        """Return it in axes from which `turn` leads here."""
        body = Moments(self.body.m, turn.back(self.body.h), turn.tensor_back(self.body.J))
        return Composite(body, turn.block_back(self.P), turn.back(self.momentum))

    def inertia(self, d: Twist) -> SpatialForce:
        """Return I d: angular momentum about the origin, momentum."""
        (w, v), (m, h, J) = d, (self.body.m, self.body.h, self.body.J)
        return add(_less_trace(J, w), cross(h, v)), add(scale(m, v), cross(w, h))

    def coriolis(self, w: Vec) -> SpatialForce:
        """Return 2 B d for the angular part of d; the linear one does not enter."""
        return _less_trace(self.P.T, w), cross(w, self.momentum)

    def couple(self, d: Twist) -> Vec:
        """Return the moment of 2 Bᵀ d, whose force is zero."""
        return add(_less_trace(self.P, d[0]), cross(self.momentum, d[1]))

    def contribution(self, S: Subspace, wrench: SpatialForce) -> Contribution:
        """Return the contribution of an elementary joint, for the wrench that moves the bodies."""
        (w, v), (n, f) = S.twist, wrench
        G = self.couple(S.twist)
        F1 = plus(self.coriolis(w), self.inertia(S.twice))
        F0 = plus(self.coriolis(S.first[0]), self.inertia(S.second))
        acting = (add(cross(w, n), cross(v, f)), cross(w, f))
        return Contribution(self.inertia(S.twist), G, F1, plus(F0, acting))


def single_body(body: Moments, twice: Vec) -> Composite:
    """Return one body, for twice its angular velocity: P = -J ω×, l = ω × h."""
    P = Mat(cross(twice, row) for row in body.J)
    return Composite(body, P, cross(twice, body.h))


def bracket(a: Twist, b: Twist) -> Twist:
    """Return a × b: the rate of a twist b that moves with a."""
    return cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0]))


def cross_z(x: Vec) -> Vec:
    """Return x × z."""
    return (x[1], -x[0], x[0].graph.zero)


def _less_trace(M: Mat, w: Vec) -> Vec:
    return (
        (M[1][1] + M[2][2]) * w[0] - M[0][1] * w[1] - M[0][2] * w[2],
        (M[0][0] + M[2][2]) * w[1] - M[1][0] * w[0] - M[1][2] * w[2],
        (M[0][0] + M[1][1]) * w[2] - M[2][0] * w[0] - M[2][1] * w[1],
    )


Pair = tuple[int, int]


@dataclass(frozen=True)
class JointForceDerivatives:
    """Forces of elementary joints, and their derivatives by pairs (force, joint); zero where there is no entry.

    Attributes:
        forces: N m or N, by joint; without those of rotors at the joints.
        by_position: N m/rad and the like.
        by_rate: N m s/rad and the like.
        by_acceleration: the mass matrix of the elementary joints, kg m^2, kg m or kg.
    """

    forces: dict[int, Expr] = field(default_factory=dict)
    by_position: dict[Pair, Expr] = field(default_factory=dict)
    by_rate: dict[Pair, Expr] = field(default_factory=dict)
    by_acceleration: dict[Pair, Expr] = field(default_factory=dict)


def rnea_derivatives(tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr]) -> JointForceDerivatives:
    """Return the derivatives of elementary joint forces, before they are projected onto the velocities.

    Args:
        tree: the mechanism; of a block only the last joint carries a body.
        qd: velocities, shape (n,).
        qdd: their rates, shape (n,).
    """
    return _Recursion(tree, 2).run(qd, qdd)


def halves_by_rate(tree: ReducedTree, qd: Sequence[Expr]) -> JointForceDerivatives:
    """Return half of the derivatives by rates, and the mass matrix of the elementary joints."""
    found = _Recursion(tree.without_gravity, 1).run(qd, [tree.graph.zero] * len(qd))
    return JointForceDerivatives(by_rate=found.by_rate, by_acceleration=found.by_acceleration)


@dataclass(frozen=True)
class _Recursion:
    """The motion of a tree, and what is found.

    Attributes:
        tree: the mechanism.
        times: 2, or 1 where velocities are to enter once instead of twice.
        motion: of every frame, as `rnea` has it.
        offset, shift: of every frame's origin: back along its joint offset, then along its shift to the parent's.
        S: of every elementary joint, before its joint offset or, in a block of several, in the frame of the last.
    """

    tree: ReducedTree
    times: int
    motion: list[LinkMotion] = field(default_factory=list)
    offset: list[OriginShift] = field(default_factory=list)
    shift: list[OriginShift] = field(default_factory=list)
    S: dict[int, Subspace] = field(default_factory=dict)

    def run(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> JointForceDerivatives:
        """Return the derivatives: motion outwards, then what each joint contributes inwards."""
        tree, found = self.tree, JointForceDerivatives()
        self._propagate(qd, qdd)
        for block in filter(None, tree.block):
            self.S.update(self._single(block[0]) if len(block) == 1 else self._block(block))
        wrench = [body.wrench(moved.a, moved.U) for body, moved in zip(tree.body, self.motion, strict=True)]
        composite = [single_body(body, self._spin(i)) for i, body in enumerate(tree.body)]
        for i in tree.inward():
            p, (n, f), near = tree.parent[i], wrench[i], composite[i].shifted(self.offset[i])
            moment = add(n, cross(self.offset[i].p, f))
            acting, bodies = ((moment, f), near) if self._plain(i) else (wrench[i], composite[i])
            for k in tree.block[i]:
                found.forces[k] = power(acting, self.S[k].twist)
                self._enter(found, k, i, bodies.contribution(self.S[k], acting))
            wrench[p] = plus(wrench[p], tree.X[i].wrench_back(n, f))
            if p:
                for turn in reversed(tree.X[i].turns):
                    near = near.turned(turn)
                composite[p] = composite[p] + near.shifted(self.shift[i])
        return found

    def _plain(self, i: int) -> bool:
        """Return whether elementary joint i is no part of a block of several."""
        return len(self.tree.block[i]) == 1

    def _spin(self, i: int) -> Vec:
        """Return twice the angular velocity of frame i."""
        return scale(self.times, self.motion[i].w)

    def _propagate(self, qd: Sequence[Expr], qdd: Sequence[Expr]) -> None:
        """Compute the motion of every frame, and the shifts of its origin."""
        tree, zeros, zero = self.tree, zero_vector(self.tree.graph), self.tree.graph.zero
        rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
        self.motion.append(base_motion(neg(tree.gravity)))
        self.offset.append(OriginShift(zeros, zeros))
        self.shift.append(OriginShift(zeros, zeros))
        for i in tree.outward():
            p, X, slides = tree.parent[i], tree.X[i], tree.slides[i]
            self.motion.append(propagate(self.motion[p], X, slides, rate[i], acceleration[i]))
            up = (zero, zero, X.offset)
            sliding = (zero, zero, rate[i] * self.times if slides else zero)
            self.offset.append(OriginShift(up, add(cross(self._spin(i), up), sliding)))
            self.shift.append(OriginShift(X.shift, cross(self._spin(p), X.shift)))

    def _single(self, i: int) -> dict[int, Subspace]:
        """Return S of a revolute or prismatic joint, and its rates, before its joint offset."""
        zero, one, zeros = self.tree.graph.zero, self.tree.graph.one, zero_vector(self.tree.graph)
        moved, parent, X, z = self.motion[i], self.motion[self.tree.parent[i]], self.tree.X[i], (zero, zero, one)
        across, twice = cross_z(moved.w), cross_z(self._spin(i))
        column = (moved.U[0][2], moved.U[1][2], moved.U[2][2])
        if self.tree.slides[i]:
            return {i: Subspace((zeros, z), (zeros, across), (zeros, column), (zeros, twice))}
        near = X.out(add(parent.a, parent.U @ X.shift))
        return {i: Subspace((z, zeros), (across, zeros), (column, cross_z(near)), (twice, zeros))}

    def _block(self, block: Sequence[int]) -> dict[int, Subspace]:
        """Return S of every joint of a block, and its rates, in the frame of its last."""
        tree, zeros = self.tree, zero_vector(self.tree.graph)
        zero, one = tree.graph.zero, tree.graph.one
        part, z = one / self.times, (zero, zero, one)
        parent, v = self.motion[tree.parent[block[0]]], zeros  # as if the joint were locked; v as seen from the origin
        S: dict[int, Twist] = {}
        for i in block:
            X, up = tree.X[i], self.offset[i]
            v = X.out(add(v, sub(cross(parent.w, X.shift), scale(part, self.shift[i].u))))
            parent = propagate(parent, X, tree.slides[i], zero, zero)
            v = add(v, sub(cross(parent.w, up.p), scale(part, up.u)))
            S = {k: _out(X, twist) for k, twist in S.items()}
            S[i] = (zeros, z) if tree.slides[i] else (z, zeros)
        locked, rate = (parent.w, v), (self.motion[block[-1]].w, zeros)
        spatial = (parent.dw, sub(parent.a, cross(parent.w, v)))
        found = {}
        for k, twist in S.items():
            first = bracket(locked, twist)
            second = plus(bracket(spatial, twist), bracket(locked, first))
            turned, slid = plus(first, bracket(rate, twist))
            half = one * self.times / 2
            found[k] = Subspace(twist, first, second, (scale(half, turned), scale(half, slid)))
        return found

    def _enter(self, found: JointForceDerivatives, k: int, last: int, contribution: Contribution) -> None:
        """Enter the derivatives of forces of joint k and of its ancestors, `last` being the last of k's block."""
        tree, j, plain = self.tree, last, self._plain(last)
        while j:
            if self._plain(j) and j != last:
                contribution = contribution.shifted(self.offset[j])
            for m in tree.block[j]:
                S = self.S[m]
                found.by_acceleration[k, m] = found.by_acceleration[m, k] = power(contribution.A, S.twist)
                if m != k or not plain:
                    found.by_rate[k, m] = dot(contribution.G, S.twist[0]) + power(contribution.A, S.twice)
                    found.by_position[k, m] = dot(contribution.G, S.first[0]) + power(contribution.A, S.second)
                if m not in tree.block[last] or plain:
                    found.by_rate[m, k] = power(contribution.F1, S.twist)
                    found.by_position[m, k] = power(contribution.F0, S.twist)
            if not tree.parent[j]:
                return
            if not self._plain(j):
                contribution = contribution.shifted(self.offset[j])
            for turn in reversed(tree.X[j].turns):
                contribution = contribution.turned(turn)
            contribution, j = contribution.shifted(self.shift[j]), tree.parent[j]


def _out(X: JointTransform, twist: Twist) -> Twist:
    """Return a twist of the parent's frame in the joint's own."""
    w, v = twist
    turned = X.out(w)
    return turned, add(X.out(add(v, cross(w, X.shift))), scale(X.offset, cross_z(turned)))
