"""Revolute joint R: one rotation about the axis. Class t = 5."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.kind import JointKind
from symdyn.spatial import Transform, Vec, rotation, zero_vector


def _motion(axis: Vec, q: tuple[Expr, ...]) -> Transform:
    return Transform(rotation(axis, q[0]), zero_vector(axis[0].graph))


def _subspace(axis: Vec) -> tuple[tuple[Vec, Vec], ...]:
    return ((axis, zero_vector(axis[0].graph)),)


REVOLUTE = JointKind(class_t=5, units=("rad",), motion=_motion, subspace=_subspace)
