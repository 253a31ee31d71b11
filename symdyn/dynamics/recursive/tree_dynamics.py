"""Inverse and forward dynamics of a kinematic tree in O(n): the algorithms of Newton-Euler and of articulated bodies.

    i, p         body 1..n and its parent, p < i; body 0 is the base
    X[i]         transform across joint i, from frame i to frame p (`links`); Featherstone's iXλ leads the other way
    z, S_i       axis of elementary joint i (one degree of freedom) in frame i, and its unit twist about z or along z
    motion[i]    velocity and acceleration of body i: ω, ω̇, a of the origin, U = [ω̇]× + [ω]× [ω]× (`links`)
    body[i]      mass, m r and J = Σ m r rᵀ about the origin of frame i (`links`)
    f[i]         wrench on body i by its parent: moment about the origin of frame i, then force, in frame i
    A_ik         rate of elementary joint i per unit of velocity k (`Topology`): τ_k = Σ_i A_ik (force of joint i)

Accelerations are those of the frames' origins, so that no linear velocity is needed. Gravity is the acceleration -g of
the base, so no body needs a weight.

Polarised form (`polarised`), of passivity-based tracking control: c(q, q̇) is quadratic in q̇, and c(q; u, v) is its
symmetric bilinear form with c(q; u, u) = c(q, u). So is every product of two rates in the recursion:

    x y        ½ (x_u y_v + x_v y_u)
    ω × z q̇    ½ (ω_u × z v + ω_v × z u)

One of the two motions is propagated as its half, w = ω_u / 2, which leaves one multiplication a term.

Articulated bodies: motion[i] is that of the velocities at q̈ = 0 without gravity; joint i has velocity i - 1 alone.

    IA[i]       articulated inertia and bias: [n; f] = [[I, H], [Hᵀ, M]] [ω̇; a] + bias, moment first, in frame i
    U, D, u     IA S, Sᵀ IA S and its rotor's inertia, τ - Sᵀ bias of joint i
    Ia          IA - U Uᵀ / D, with its bias: the apparent inertia that joint i adds to body p
    a[i]        accelerations to be added to those of motion[i], (angular, linear), in frame i

With c = Ṡ q̇ in the motions of pass 1, c is multiplied by the body's own inertia only. This saves a sixth of the
operations of table 7.1.

References: Featherstone, Rigid Body Dynamics Algorithms (2008), table 5.1, section 7.2 and table 7.1; Khalil and
Dombre, Modeling, Identification and Control of Robots (2002), eq. (9.86)-(9.97); Slotine and Li (1987), Niemeyer and
Slotine (1991), of polarised forms.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.mechanism.linear_solve import Singular, vanishes
from symdyn.dynamics.recursive.links import (
    JointTransform,
    LinkMotion,
    Moments,
    SpatialForce,
    Twist,
    at_offset_end,
    base_motion,
    plus,
    power,
    propagate,
    with_column,
    with_products,
    z_column,
)
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.errors import DerivationError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, tangents
from symdyn.spatial import Mat, Vec, Wrench, add, cross, neg, sub, zero_vector


def rnea(tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q) less the forces of external wrenches; N m or N; positive accelerates.

    Zeros for q̇ or q̈ leave their terms out of the graph. External wrenches, here (force, moment), act on the base and
    every body, each in its frame.
    """
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    motion = [base_motion(neg(tree.gravity))]
    for i in tree.outward():  # pass 1: velocities and accelerations, base to leaves
        motion.append(propagate(motion[tree.parent[i]], tree.X[i], tree.slides[i], rate[i], acceleration[i]))
    return joint_forces(tree, motion, acceleration, acting, tree.spherical_rotor_forces(qd, qdd))


def joint_forces(
    tree: ReducedTree,
    motion: Sequence[LinkMotion],
    qdd: Sequence[Expr],
    acting: Sequence[Wrench],
    rotors: Sequence[Expr],
) -> list[Expr]:
    """Return generalized forces, shape (n,), for the motions of all bodies; those of spherical rotors are added."""
    X, tau = tree.X, [tree.graph.zero] * len(tree.parent)
    f = [body.wrench(moved.a, moved.U) for body, moved in zip(tree.body, motion, strict=True)]
    for i, (force, moment) in enumerate(acting):
        f[i] = (sub(f[i][0], moment), sub(f[i][1], force))
    for i in tree.inward():  # pass 2: forces, leaves to base
        p = tree.parent[i]
        tau[i] = tree.along_axis(i, f[i]) + tree.armature[i] * qdd[i]
        f[p] = plus(f[p], X[i].wrench_back(*f[i]))
    return [force + rotor for force, rotor in zip(tree.generalized_forces(tau), rotors, strict=True)]


def polarised(tree: ReducedTree, qd: Sequence[Expr], v: Sequence[Expr], acceleration: Sequence[Expr]) -> list[Expr]:
    """Return M(q) a + c(q; q̇, v) + g(q), shape (n,); N m or N. c(q; q̇, v) = C(q, q̇) v for rates of coordinates.

    Args:
        tree: link frames.
        qd: velocities, shape (n,).
        v: other velocities, shape (n,); both may be swapped.
        acceleration: a, shape (n,).
    """
    graph, zeros = tree.graph, zero_vector(tree.graph)
    half, rate = [x / 2 for x in tree.rates(qd)], tree.rates(v)
    along = dict(zip(qd, v, strict=True))
    bias = [x / 2 for x in tangents(tree.bias(qd), along)]
    qdd = [a + b for a, b in zip(tree.rates(acceleration), bias, strict=True)]
    w, r = [zeros], [zeros]
    motion = [base_motion(neg(tree.gravity))]
    for i in tree.outward():
        p, X = tree.parent[i], tree.X[i]
        turned = X.out(w[p]), X.out(r[p])
        w.append(turned[0] if tree.slides[i] else _plus_z(turned[0], half[i]))
        r.append(turned[1] if tree.slides[i] else _plus_z(turned[1], rate[i]))
        across = _across(turned[0], rate[i], turned[1], half[i])
        step = _prismatic if tree.slides[i] else _revolute
        motion.append(at_offset_end(step(motion[p], X, across, (w[i], r[i]), qdd[i]), X))
    none = [graph.zero] * tree.n
    mixed = [x / 2 for x in tangents(tree.spherical_rotor_forces(qd, none), along)]
    rotors = [a + b for a, b in zip(tree.spherical_rotor_forces(none, acceleration), mixed, strict=True)]
    return joint_forces(tree, motion, qdd, (), rotors)


def _plus_z(x: Vec, z: Expr) -> Vec:
    return (x[0], x[1], x[2] + z)


def _across(w: Vec, rate: Expr, r: Vec, half: Expr) -> Vec:
    """Return ω × z q̇, polarised."""
    return w[1] * rate + r[1] * half, -(w[0] * rate + r[0] * half), rate.graph.zero


def _products(w: Vec, r: Vec) -> tuple[Expr, ...]:
    """Return ωx², ωy², ωz², ωx ωy, ωx ωz, ωy ωz, polarised."""
    (x, y, z), (X, Y, Z) = w, r
    return x * X * 2, y * Y * 2, z * Z * 2, x * Y + y * X, x * Z + z * X, y * Z + z * Y


def _prismatic(parent: LinkMotion, X: JointTransform, across: Vec, rates: tuple[Vec, Vec], qdd: Expr) -> LinkMotion:
    a = X.out(add(parent.a, parent.U @ X.shift))
    a = (a[0] + across[0] * 2, a[1] + across[1] * 2, a[2] + qdd)
    return with_products(rates[0], _products(*rates), X.out(parent.dw), a)


def _revolute(parent: LinkMotion, X: JointTransform, across: Vec, rates: tuple[Vec, Vec], qdd: Expr) -> LinkMotion:
    a, dw = X.out(add(parent.a, parent.U @ X.shift)), X.out(parent.dw)
    dw = (dw[0] + across[0], dw[1] + across[1], dw[2] + qdd)
    column = z_column(parent, X)
    if column is None:
        return with_products(rates[0], _products(*rates), dw, a)
    return with_column(rates[0], _products(*rates), dw[2], a, column)


@dataclass(frozen=True)
class ArticulatedInertia:
    """An articulated inertia and its bias, as in the module's legend; I and M are symmetric."""

    I: Mat  # noqa: E741  the book's name
    H: Mat
    M: Mat
    bias: SpatialForce

    def __add__(self, other: ArticulatedInertia) -> ArticulatedInertia:
        """Return the sum, both in one frame."""
        bias = plus(self.bias, other.bias)
        return ArticulatedInertia(self.I + other.I, self.H + other.H, self.M + other.M, bias)

    def along_z(self, slides: bool) -> SpatialForce:
        """Return [[I, H], [Hᵀ, M]] times the unit twist about z, or along z where the joint `slides` (is prismatic)."""
        n, f = (self.H, self.M) if slides else (self.I, self.H.T)
        return (n[0][2], n[1][2], n[2][2]), (f[0][2], f[1][2], f[2][2])

    def through_joint(self, slides: bool, D: Expr, tau: Expr) -> tuple[SpatialForce, Expr, ArticulatedInertia]:
        """Return U / D, u / D and Ia with its bias, in the joint's frame.

        Where no rotor adds to D, U / D is one along the axis, and the bias there is τ.
        """
        U = self.along_z(slides)
        u = tau - self.bias[slides][2]
        pivot, one = 1 / D, D.graph.one
        U_D = _over(U[0], D, pivot), _over(U[1], D, pivot)

        def biased(b: Vec, s: Vec, along: bool) -> Vec:
            last = tau if along and s[2] is one else b[2] + u * s[2]  # U / D across the axis may be 1 by chance
            return b[0] + u * s[0], b[1] + u * s[1], last

        bias = biased(self.bias[0], U_D[0], not slides), biased(self.bias[1], U_D[1], slides)
        return U_D, u * pivot, replace(self._projected(U, U_D, slides), bias=bias)

    def _projected(self, U: SpatialForce, U_D: SpatialForce, slides: bool) -> ArticulatedInertia:
        """Return IA - U Uᵀ / D; the bias stays.

        Written so that rows and columns that vanish along the joint's axis are symbolic zeros.
        """
        coupled = Mat.outer(U[0], U_D[1]) if slides else Mat.outer(U_D[0], U[1])
        return ArticulatedInertia(
            _minus(self.I, Mat.outer(U[0], U_D[0])).mirrored(),
            _minus(self.H, coupled),
            _minus(self.M, Mat.outer(U[1], U_D[1])).mirrored(),
            self.bias,
        )

    def shifted(self, p: Vec) -> ArticulatedInertia:
        """Return it about an origin that lies at -p: f keeps, n gains p × f, a becomes a - p × ω̇."""
        (x, y, z), H = p, self.H
        K = H + Mat.skew(p) @ self.M
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = self.I
        I = Mat.symmetric(  # noqa: E741  I - H [p]x - (...)^T - [p]x M [p]x, from H before and K after
            xx - (z * (H[0][1] + K[0][1]) - y * (H[0][2] + K[0][2])),
            yy - (x * (H[1][2] + K[1][2]) - z * (H[1][0] + K[1][0])),
            zz - (y * (H[2][0] + K[2][0]) - x * (H[2][1] + K[2][1])),
            xy - (z * (H[1][1] - K[0][0]) + x * K[0][2] - y * H[1][2]),
            xz - (y * (K[0][0] - H[2][2]) + z * H[2][1] - x * K[0][1]),
            yz - (x * (H[2][2] - K[1][1]) + y * K[1][0] - z * H[2][0]),
        )
        n, f = self.bias
        return ArticulatedInertia(I, K, self.M, (add(n, cross(p, f)), f))

    def seen_from(self, X: JointTransform) -> ArticulatedInertia:
        """Return it in the parent's frame."""
        zero = X.offset.graph.zero
        here = self.shifted((zero, zero, X.offset))
        rotational, H, M = here.I, here.H, here.M
        for turn in reversed(X.turns):
            rotational, H, M = turn.tensor_back(rotational), turn.block_back(H), turn.tensor_back(M)
        bias = (X.back(here.bias[0]), X.back(here.bias[1]))
        return ArticulatedInertia(rotational, H, M, bias).shifted(X.shift)


def articulated_inertia(body: Moments, motion: LinkMotion) -> ArticulatedInertia:
    """Return the inertia of a single body: the wrench that its motion needs is its bias."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.J
    I = Mat.symmetric(yy + zz, xx + zz, xx + yy, -xy, -xz, -yz)  # noqa: E741  the book's name
    mass = Mat.identity(body.m.graph).scaled(body.m)
    return ArticulatedInertia(I, Mat.skew(body.h), mass, body.wrench(motion.a, motion.U))


def across_locked(parent: Twist, X: JointTransform) -> Twist:
    """Return the accelerations beyond a locked joint, from those of the parent's frame."""
    (dw, a), zero = parent, X.offset.graph.zero
    turned, moved = X.out(dw), X.out(add(a, cross(dw, X.shift)))
    return turned, add(moved, cross(turned, (zero, zero, X.offset)))


def _over(a: Vec, D: Expr, pivot: Expr) -> Vec:
    x, y, z = (D.graph.one if entry is D else entry * pivot for entry in a)
    return x, y, z


def along_z(amount: Expr, slides: bool) -> Twist:
    """Return a twist of some amount about z, or along z where the joint `slides`."""
    zeros = zero_vector(amount.graph)
    along = (amount.graph.zero, amount.graph.zero, amount)
    return (zeros, along) if slides else (along, zeros)


def _minus(a: Mat, b: Mat) -> Mat:
    return Mat((sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])))


def aba(tree: ReducedTree, qd: Sequence[Expr], tau: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return q̈ for the joint forces τ, shape (n,); rad/s^2 or m/s^2.

    External wrenches, here (force, moment), act on the base and every body, each in its frame.

    Raises:
        Singular: a joint has no inertia beyond it.
        DerivationError: a joint follows another one.
    """
    if tree.coupled or tree.spherical_rotors:
        what = "joints that share a velocity" if tree.coupled else "rotors of spherical joints"
        raise DerivationError(f"the articulated-body algorithm does not take {what}; use the formulation crba")
    graph, zeros, X = tree.graph, zero_vector(tree.graph), tree.X
    motion = [base_motion(zeros)]
    IA = [articulated_inertia(tree.body[0], motion[0])]
    for i in tree.outward():  # pass 1: motions at q̈ = 0, base to leaves
        motion.append(propagate(motion[tree.parent[i]], X[i], tree.slides[i], qd[i - 1], graph.zero))
        IA.append(articulated_inertia(tree.body[i], motion[i]))
    for i, (force, moment) in enumerate(acting):
        IA[i] = replace(IA[i], bias=(sub(IA[i].bias[0], moment), sub(IA[i].bias[1], force)))
    U_D: list[SpatialForce] = [(zeros, zeros)] * (tree.n + 1)
    u_D = [graph.zero] * (tree.n + 1)
    for i in tree.inward():  # pass 2: articulated inertias, leaves to base
        p, slides = tree.parent[i], tree.slides[i]
        if vanishes(D := tree.along_axis(i, IA[i].along_z(slides)) + tree.armature[i]):
            raise Singular(tree.A[i][0][0])
        U_D[i], u_D[i], Ia = IA[i].through_joint(slides, D, tau[i - 1])
        if p:
            IA[p] = IA[p] + Ia.seen_from(X[i])
    a: list[Twist] = [(zeros, neg(tree.gravity))]
    qdd: list[Expr] = []
    for i in tree.outward():  # pass 3: accelerations to be added, base to leaves
        locked = across_locked(a[tree.parent[i]], X[i])
        qdd.append(u_D[i] - power(U_D[i], locked))
        a.append(plus(locked, along_z(qdd[-1], tree.slides[i])))
    return [x - bias for x, bias in zip(qdd, tree.bias(qd)[1:], strict=True)]
