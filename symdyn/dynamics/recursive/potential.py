"""Potential energy of a kinematic tree: first moments, added up from the tips to the ground."""

from __future__ import annotations

from symdyn.dynamics.recursive.reframe import LeanTree
from symdyn.graph import Expr
from symdyn.spatial import dot


def potential_energy(tree: LeanTree) -> Expr:
    """Return P = -g·Σ m r, J; what is welded to the ground counts, and so does what regrouping has moved there."""
    body = list(tree.body)
    for i in tree.inward():
        p = tree.parent[i]
        body[p] = body[p] + tree.link[i].moments_back(body[i])
    return -dot(tree.gravity, body[0].h)
