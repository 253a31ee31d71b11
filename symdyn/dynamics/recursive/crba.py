"""Composite-rigid-body algorithm: the mass matrix of a kinematic tree, along factored links.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.

    i, p     a moving body 1..n and its parent, p < i
    C[i]     moments of everything beyond joint i, as one rigid body, in frame i: m, h, J
    n, f     its momentum for unit velocity of joint i, walked down to the ground, in the frame of body j

    polar    J_xx + J_yy of C[i]

Joint axes are z axes. For a unit turn n = (-J_xz, -J_yz, J_xx + J_yy) and f = z × h; for a unit slide n = h × z and
f = m z. Since n and f turn as J and h do, what both need is one node. Turns about parallel axes keep the polar moment.
"""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.dynamics.recursive.leaps import walk
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.reframe import LeanTree
from symdyn.graph import Expr
from symdyn.spatial import Vec


def crba(tree: LeanTree, leaping: bool = False, keeping: bool = False) -> list[list[Expr]]:
    """Return the mass matrix M(q), so that K = q̇ᵀ M q̇ / 2.

    Args:
        tree: the mechanism.
        leaping: pass runs of parallel axes in one turn by the sum of their angles; see `leaps`.
        keeping: add polar moments up where all axes beyond a joint are parallel to its own, in place of adding up
            the entries of a turned J.

    Returns:
        M, shape (n, n), symmetric; positive definite unless a massless body ends a branch; kg m^2, kg m or kg.
        Entries of joints on different branches are zero.
    """
    C = list(tree.body)
    polar: list[Expr | None] = [body.J[0][0] + body.J[1][1] if keeping else None for body in C]
    M = [[tree.graph.zero] * tree.n for _ in range(tree.n)]

    def enter(i: int, j: int, value: Expr) -> None:
        """Add the term of moves i and j to the entries of the velocities that they share in."""
        for k, x in tree.A[i]:
            for m, y in tree.A[j]:
                M[k][m] = M[k][m] + x * y * value

    for i in tree.inward():
        n, f = _momentum(C[i], tree.slides[i], polar[i])
        enter(i, i, (f[2] if tree.slides[i] else n[2]) + tree.armature[i])
        for j, value in walk(tree, i, n, f) if leaping else _step_by_step(tree, i, n, f):
            enter(i, j, value)
            enter(j, i, value)
        if tree.parent[i]:
            p = tree.parent[i]
            polar[p] = _sum_of_polar_moments(polar[p], polar[i], tree.link[i], C[i])
            C[p] = C[p] + tree.link[i].moments_back(C[i])
    for ball in tree.balls:
        for k, m, value in ball.entries():
            M[k][m] = M[k][m] + value
    return M


def _sum_of_polar_moments(own: Expr | None, beyond: Expr | None, link: Link, body: Moments) -> Expr | None:
    """Return the polar moment of two bodies, the second one beyond a link; None if axes are not parallel."""
    if own is None or beyond is None or link.fixed:
        return None
    turned, (x, y, _) = link.back(body.h), link.shift
    return own + (beyond + x * 2 * (turned[0] + body.m / 2 * x) + y * 2 * (turned[1] + body.m / 2 * y))


def _momentum(body: Moments, slides: bool, polar: Expr | None) -> tuple[Vec, Vec]:
    """Return angular momentum about the origin and momentum for unit velocity along z."""
    (x, y, _), J, zero = body.h, body.J, body.m.graph.zero
    if slides:
        return (y, -x, zero), (zero, zero, body.m)
    return (-J[0][2], -J[1][2], J[0][0] + J[1][1] if polar is None else polar), (-y, x, zero)


def _step_by_step(tree: LeanTree, j: int, n: Vec, f: Vec) -> Iterator[tuple[int, Expr]]:
    """Yield every ancestor of joint j with the part of a wrench in frame j that its joint feels."""
    while tree.parent[j]:
        n, f = tree.link[j].wrench_back(n, f)
        j = tree.parent[j]
        yield j, f[2] if tree.slides[j] else n[2]
