"""Driving forces along a reference: the recursion of `rnea`, each product of two velocities taken of two motions.

c(q, q̇) is quadratic in q̇, and c(q; u, v) the symmetric form with c(q; u, u) = c(q, u); so is every product of two
rates in the recursion:

    x y        ½ (x_u y_v + x_v y_u)
    ω × z q̇    ½ (ω_u × z v + ω_v × z u)

One of the two motions is carried as its half, w = ω_u / 2, which leaves one multiplication a term.

Reference: the recursion is that of `rnea`; Slotine and Li (1987), Niemeyer and Slotine (1991) for its use.
"""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.dynamics.recursive.link_motion import LinkMotion, at_rest, raised, with_column, with_products, z_column
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.dynamics.recursive.rnea import joint_forces
from symdyn.graph import Expr, tangents
from symdyn.spatial import Vec, add, neg, zero_vector


def polarised(tree: ReducedTree, qd: Sequence[Expr], v: Sequence[Expr], acceleration: Sequence[Expr]) -> list[Expr]:
    """Return M(q) a + c(q; q̇, v) + g(q), shape (n,); N m or N. c(q; q̇, v) = C(q, q̇) v for rates of coordinates.

    Args:
        tree: link frames.
        qd: velocities, shape (n,).
        v: other velocities, shape (n,); both may be swapped.
        acceleration: a, shape (n,).
    """
    graph, still = tree.graph, zero_vector(tree.graph)
    half, rate = [x / 2 for x in tree.rates(qd)], tree.rates(v)
    along = dict(zip(qd, v, strict=True))
    bias = [x / 2 for x in tangents(tree.bias(qd), along)]
    moved = [a + b for a, b in zip(tree.rates(acceleration), bias, strict=True)]
    w, r = [still], [still]
    motion = [at_rest(neg(tree.gravity))]
    for i in tree.outward():
        p, link = tree.parent[i], tree.link[i]
        turned = link.out(w[p]), link.out(r[p])
        w.append(turned[0] if tree.slides[i] else _plus(turned[0], half[i]))
        r.append(turned[1] if tree.slides[i] else _plus(turned[1], rate[i]))
        across = _across(turned[0], rate[i], turned[1], half[i])
        after = _sliding if tree.slides[i] else _turning
        motion.append(raised(after(motion[p], link, across, (w[i], r[i]), moved[i]), link))
    none = [graph.zero] * tree.n
    mixed = [x / 2 for x in tangents(tree.ball_forces(qd, none), along)]
    balls = [a + b for a, b in zip(tree.ball_forces(none, acceleration), mixed, strict=True)]
    return joint_forces(tree, motion, moved, (), balls)


def _plus(x: Vec, z: Expr) -> Vec:
    return (x[0], x[1], x[2] + z)


def _across(w: Vec, rate: Expr, r: Vec, half: Expr) -> tuple[Expr, Expr]:
    """Return x and y of ω × z q̇, polarised."""
    return w[1] * rate + r[1] * half, -(w[0] * rate + r[0] * half)


def _products(w: Vec, r: Vec) -> tuple[Expr, ...]:
    """Return ωx², ωy², ωz², ωx ωy, ωx ωz, ωy ωz, polarised."""
    (x, y, z), (X, Y, Z) = w, r
    return x * X * 2, y * Y * 2, z * Z * 2, x * Y + y * X, x * Z + z * X, y * Z + z * Y


def _sliding(
    parent: LinkMotion, link: Link, across: tuple[Expr, Expr], rates: tuple[Vec, Vec], acceleration: Expr
) -> LinkMotion:
    a = link.out(add(parent.a, parent.U @ link.shift))
    a = (a[0] + across[0] * 2, a[1] + across[1] * 2, a[2] + acceleration)
    return with_products(rates[0], _products(*rates), link.out(parent.dw), a)


def _turning(
    parent: LinkMotion, link: Link, across: tuple[Expr, Expr], rates: tuple[Vec, Vec], acceleration: Expr
) -> LinkMotion:
    a, dw = link.out(add(parent.a, parent.U @ link.shift)), link.out(parent.dw)
    dw = (dw[0] + across[0], dw[1] + across[1], dw[2] + acceleration)
    column = z_column(parent, link)
    if column is None:
        return with_products(rates[0], _products(*rates), dw, a)
    return with_column(rates[0], _products(*rates), dw[2], a, column)
