"""Composite-rigid-body algorithm: the mass matrix of a kinematic tree.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), table 6.2.

    i, p     a moving body 1..n and its parent, p < i
    Ic[i]    inertia of everything beyond joint i, as one rigid body, in frame i
    n, f     its momentum for unit velocity of joint i, walked down to the ground, in the frame of body j
"""

from __future__ import annotations

from symdyn.dynamics.tree import Tree
from symdyn.graph import Expr
from symdyn.spatial import add, apply, cross, dot


def crba(tree: Tree) -> list[list[Expr]]:
    """Return the mass matrix M(q), so that K = q̇ᵀ M q̇ / 2.

    Returns:
        M, shape (n, n), symmetric; positive definite unless a massless body ends a branch; kg m^2, kg m or kg.
        Entries of joints on different branches are zero.
    """
    Ic = list(tree.inertia)
    M = [[tree.graph.zero] * tree.n for _ in range(tree.n)]

    def enter(i: int, j: int, value: Expr) -> None:
        """Add the term of joints i and j to the entry of their coordinates, which joints that follow share."""
        k, m = tree.column[i], tree.column[j]
        M[k][m] = M[k][m] + tree.ratio[i] * tree.ratio[j] * value

    for i in tree.inward():
        z, s = tree.S[i]
        n, f = Ic[i].momentum(z, s)
        j = i
        while j:
            z, s = tree.S[j]
            value = dot(z, n) + dot(s, f)
            enter(i, j, value + tree.armature[i] if i == j else value)
            if i != j:
                enter(j, i, value)
            f = apply(tree.T[j].R, f)
            n = add(apply(tree.T[j].R, n), cross(tree.T[j].p, f))
            j = tree.parent[j]
        if tree.parent[i]:
            p = tree.parent[i]
            Ic[p] = Ic[p] + Ic[i].seen_from(tree.T[i])
    return M
