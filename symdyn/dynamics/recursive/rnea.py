"""Recursive Newton-Euler algorithm: inverse dynamics of a kinematic tree, and its polarised form for two velocities.

    i, p         body 1..n and its parent, p < i; body 0 is the base
    X[i]         transform across joint i, from frame i to frame p (`links`); Featherstone's iXλ leads the other way
    z            axis of joint i in frame i, which it turns about or slides along
    motion[i]    velocity and acceleration of body i: ω, ω̇, a of the origin, U = [ω̇]× + [ω]× [ω]× (`links`)
    body[i]      mass, m r and J = Σ m r rᵀ about the origin of frame i (`links`)
    f[i]         wrench on body i by its parent: moment about the origin of frame i, then force, in frame i
    A_ik         rate of elementary joint i per unit of velocity k: τ_k = Σ_i A_ik (force of joint i)

Accelerations are those of the frames' origins. Gravity is the acceleration -g of the base, so no body needs a weight.

Polarised form (`polarised`), which control along a reference takes: c(q, q̇) is quadratic in q̇, and c(q; u, v) is its
symmetric bilinear form with c(q; u, u) = c(q, u). So is every product of two rates in the recursion:

    x y        ½ (x_u y_v + x_v y_u)
    ω × z q̇    ½ (ω_u × z v + ω_v × z u)

One of the two motions is propagated as its half, w = ω_u / 2, which leaves one multiplication a term.

References: Featherstone, Rigid Body Dynamics Algorithms (2008), table 5.1; Khalil and Dombre, Modeling, Identification
and Control of Robots (2002), eq. (9.86)-(9.97); Slotine and Li (1987), Niemeyer and Slotine (1991), of polarised forms.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.recursive.links import (
    JointTransform,
    LinkMotion,
    at_rise_end,
    base_motion,
    plus,
    propagate,
    with_column,
    with_products,
    z_column,
)
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.graph import Expr, tangents
from symdyn.spatial import Vec, Wrench, add, neg, sub, zero_vector


def rnea(tree: ReducedTree, qd: Sequence[Expr], qdd: Sequence[Expr], acting: Sequence[Wrench] = ()) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q) less the forces of external wrenches; N m or N; positive accelerates.

    Zeros for q̇ or q̈ leave their terms out of the graph. External wrenches, here (force, moment), act on the base and
    every body, each in its frame.
    """
    rate, acceleration = tree.rates(qd), tree.accelerations(qd, qdd)
    motion = [base_motion(neg(tree.gravity))]
    for i in tree.outward():  # pass 1: velocities and accelerations, base to tips
        motion.append(propagate(motion[tree.parent[i]], tree.X[i], tree.slides[i], rate[i], acceleration[i]))
    return joint_forces(tree, motion, acceleration, acting, tree.ball_forces(qd, qdd))


def joint_forces(
    tree: ReducedTree,
    motion: Sequence[LinkMotion],
    qdd: Sequence[Expr],
    acting: Sequence[Wrench],
    balls: Sequence[Expr],
) -> list[Expr]:
    """Return the forces of the velocities, shape (n,), that give all bodies their motions, and rotors of `balls`."""
    X, tau = tree.X, [tree.graph.zero] * len(tree.parent)
    f = [body.wrench(moved.a, moved.U) for body, moved in zip(tree.body, motion, strict=True)]
    for i, (force, moment) in enumerate(acting):
        f[i] = (sub(f[i][0], moment), sub(f[i][1], force))
    for i in tree.inward():  # pass 2: forces, tips to base
        p = tree.parent[i]
        tau[i] = tree.along_axis(i, f[i]) + tree.armature[i] * qdd[i]
        f[p] = plus(f[p], X[i].wrench_back(*f[i]))
    return [force + rotor for force, rotor in zip(tree.gather(tau), balls, strict=True)]


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
        motion.append(at_rise_end(step(motion[p], X, across, (w[i], r[i]), qdd[i]), X))
    none = [graph.zero] * tree.n
    mixed = [x / 2 for x in tangents(tree.ball_forces(qd, none), along)]
    balls = [a + b for a, b in zip(tree.ball_forces(none, acceleration), mixed, strict=True)]
    return joint_forces(tree, motion, qdd, (), balls)


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
