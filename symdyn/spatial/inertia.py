"""Rigid-body inertia about the origin of a frame: mass, first moment, inertia matrix."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.graph import Expr, Graph
from symdyn.spatial.rigid import Transform
from symdyn.spatial.vector import (
    Mat,
    Vec,
    add,
    add_matrices,
    apply,
    cross,
    dot,
    identity,
    multiply,
    outer,
    scale,
    scale_matrix,
    symmetric,
    transpose,
    zero_vector,
)


@dataclass(frozen=True)
class Inertia:
    """Ten inertial parameters in a frame A.

    Attributes:
        m: mass, kg.
        h: first moment m r, kg m.
        I: inertia matrix about the origin of A, kg m^2; products as matrix entries.
    """

    m: Expr
    h: Vec
    I: Mat  # noqa: E741  the book's name

    def __add__(self, other: Inertia) -> Inertia:
        """Return the inertia of both together."""
        return Inertia(self.m + other.m, add(self.h, other.h), add_matrices(self.I, other.I))

    def seen_from(self, T: Transform) -> Inertia:
        """Return the inertia in frame B, for T = T_BA.

        With x' = R x + p:  h' = R h + m p,  I' = R I Rᵀ + (2 p·R h + m p²) 1 - p (R h)ᵀ - (R h) pᵀ - m p pᵀ.
        """
        h, turned, p, m = self.h, self.I, T.p, self.m
        if not T.is_shift:
            h, turned = apply(T.R, h), multiply(multiply(T.R, turned), transpose(T.R))
        spread = dot(p, h) * 2 + m * dot(p, p)
        mixed = outer(p, add(h, scale(m, p)))
        off = add_matrices(mixed, outer(h, p))
        shifted = add_matrices(turned, add_matrices(scale_matrix(spread, identity(m.graph)), scale_matrix(-1, off)))
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = shifted
        return Inertia(m, add(h, scale(m, p)), symmetric(xx, yy, zz, xy, xz, yz))

    def momentum(self, w: Vec, v: Vec) -> tuple[Vec, Vec]:
        """Return (angular, linear) momentum about the origin for angular velocity w and velocity v of the origin."""
        return add(apply(self.I, w), cross(self.h, v)), add(scale(self.m, v), cross(w, self.h))


def no_inertia(graph: Graph) -> Inertia:
    """Return the inertia of nothing."""
    nothing = zero_vector(graph)
    return Inertia(graph.zero, nothing, (nothing, nothing, nothing))


def point_inertia(mass: Expr, at: Vec) -> Inertia:
    """Return the inertia of a point mass: I = m (r² 1 - r rᵀ)."""
    squares = outer(at, at)
    spread = scale_matrix(dot(at, at), identity(mass.graph))
    about = scale_matrix(mass, add_matrices(spread, scale_matrix(-1, squares)))
    return Inertia(mass, scale(mass, at), about)
