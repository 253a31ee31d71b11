"""Prismatic joint P: one translation along the axis. Class t = 5."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.kind import JointKind
from symdyn.spatial import Transform, Vec, identity, scale, zero_vector


def _motion(axis: Vec, q: tuple[Expr, ...]) -> Transform:
    return Transform(identity(axis[0].graph), scale(q[0], axis))


def _subspace(axis: Vec) -> tuple[tuple[Vec, Vec], ...]:
    return ((zero_vector(axis[0].graph), axis),)


PRISMATIC = JointKind(class_t=5, units=("m",), motion=_motion, subspace=_subspace)
