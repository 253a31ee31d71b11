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
from dataclasses import replace

from symdyn.dynamics.recursive.lean_tree import LeanTree
from symdyn.dynamics.recursive.link_motion import LinkMotion, moving, turning_with, with_products
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.rnea import transmitted
from symdyn.graph import Expr, tangents
from symdyn.spatial import Vec, add, neg, scale, zero_vector


def polarised(
    tree: LeanTree, qd: Sequence[Expr], v: Sequence[Expr], acceleration: Sequence[Expr], gravity: bool = True
) -> list[Expr]:
    """Return M(q) a + c(q; q̇, v) + g(q), shape (n,); N m or N. c(q; q̇, v) = C(q, q̇) v for rates of coordinates.

    Args:
        tree: link frames.
        qd: velocities, shape (n,).
        v: other velocities, shape (n,); both may be swapped.
        acceleration: a, shape (n,).
        gravity: whether weight is among the forces.
    """
    graph, still = tree.graph, zero_vector(tree.graph)
    half, rate = [x / 2 for x in tree.rates(qd)], tree.rates(v)
    along = dict(zip(qd, v, strict=True))
    bias = [x / 2 for x in tangents(tree.bias(qd), along)]
    moved = [a + b for a, b in zip(tree.rates(acceleration), bias, strict=True)]
    ends = tree.ends
    w, r = [still], [still]
    motion = [moving(still, still, neg(tree.gravity) if gravity else still)]
    for i in tree.outward():
        p, link = tree.parent[i], tree.link[i]
        carried = link.out(w[p]), link.out(r[p])
        w.append(carried[0] if tree.slides[i] else _plus(carried[0], half[i]))
        r.append(carried[1] if tree.slides[i] else _plus(carried[1], rate[i]))
        turned = _across(carried[0], rate[i], carried[1], half[i])
        after = _sliding if tree.slides[i] else _turning
        motion.append(after(motion[p], link, turned, (w[i], r[i]), moved[i], ends[i]))
    forces = transmitted(tree, motion, moved)
    for ball in tree.balls:
        at_rest, moving_ = ball.forces([graph.zero] * tree.n, acceleration), ball.forces(qd, [graph.zero] * tree.n)
        for k, one, other in zip(ball.velocities, at_rest, tangents(moving_, along), strict=True):
            forces[k] = forces[k] + one + other / 2
    return forces


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
    parent: LinkMotion, link: Link, turned: tuple[Expr, Expr], rates: tuple[Vec, Vec], acceleration: Expr, ends: bool
) -> LinkMotion:
    a = link.out(add(parent.a, parent.U @ link.shift))
    a = (a[0] + turned[0] * 2, a[1] + turned[1] * 2, a[2] + acceleration)
    moved = with_products(rates[0], _products(*rates), link.out(parent.dw), a)
    return _raised(moved, link)


def _turning(
    parent: LinkMotion, link: Link, turned: tuple[Expr, Expr], rates: tuple[Vec, Vec], acceleration: Expr, ends: bool
) -> LinkMotion:
    a, dw = link.out(add(parent.a, parent.U @ link.shift)), link.out(parent.dw)
    if link.is_right:
        xx, _, zz, xy, xz, yz = _products(*rates)
        column = link.out(parent.U @ link.axis)
        moved = turning_with(
            rates[0], (xx, zz, xy, xz, yz), lambda: (xz * 2, yz * 2), dw[2] + acceleration, a, column, ends
        )
    else:
        dw = (dw[0] + turned[0], dw[1] + turned[1], dw[2] + acceleration)
        moved = with_products(rates[0], _products(*rates), dw, a)
    return _raised(moved, link)


def _raised(moved: LinkMotion, link: Link) -> LinkMotion:
    rise = scale(link.rise, (moved.U[0][2], moved.U[1][2], moved.U[2][2]))
    return replace(moved, a=add(moved.a, rise))
