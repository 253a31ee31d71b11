"""Composite-rigid-body algorithm: the mass matrix of a kinematic tree.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.

    i, j, p     body 1..n, one that carries it, and its parent, p < i
    X[i]        transform across joint i, from frame i to frame p (`links`)
    S_i         axis of joint i: z of frame i, which it turns about or slides along
    C[i]        composite body: everything beyond joint i as one rigid body, in frame i (`moments`)
    F           C[i] S_i, its momentum for unit velocity of joint i: (angular, linear), walked down to the base
    H           H_ij = F·S_j, the mass matrix of the moves
"""

from __future__ import annotations

from symdyn.dynamics.recursive.moments import Moments
from symdyn.dynamics.recursive.reduced_tree import ReducedTree
from symdyn.graph import Expr
from symdyn.spatial import Vec


def crba(tree: ReducedTree) -> list[list[Expr]]:
    """Return the mass matrix M(q), shape (n, n), symmetric, so that K = q̇ᵀ M q̇ / 2; kg m^2, kg m or kg.

    It is positive definite unless a massless body ends a branch; entries of joints on different branches are zero.
    """
    X, C, H = tree.link, list(tree.body), dict[tuple[int, int], Expr]()
    for i in tree.inward():
        F = momentum(C[i], tree.slides[i])
        H[i, i] = tree.along_axis(i, F) + tree.armature[i]
        j = i
        while tree.parent[j]:
            F, j = X[j].wrench_back(*F), tree.parent[j]
            H[i, j] = H[j, i] = tree.along_axis(j, F)
        if p := tree.parent[i]:
            C[p] = C[p] + X[i].moments_back(C[i])
    return with_balls(tree, H)


def momentum(body: Moments, slides: bool, polar: Expr | None = None) -> tuple[Vec, Vec]:
    """Return angular momentum about the origin and momentum for unit velocity along z, where `polar` is I_zz."""
    (x, y, _), J, zero = body.h, body.J, body.m.graph.zero
    if slides:
        return (y, -x, zero), (zero, zero, body.m)
    return (-J[0][2], -J[1][2], body.polar if polar is None else polar), (-y, x, zero)


def with_balls(tree: ReducedTree, H: dict[tuple[int, int], Expr]) -> list[list[Expr]]:
    """Return the mass matrix of the velocities for that of the moves, rotors of balls included."""
    M = tree.gather_matrix(H)
    for ball in tree.balls:
        for k, m, value in ball.entries():
            M[k][m] = M[k][m] + value
    return M
