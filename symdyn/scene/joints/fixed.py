"""Fixed joint: a weld. Class t = 6."""

from __future__ import annotations

from symdyn.graph import Expr
from symdyn.scene.joints.kind import JointKind
from symdyn.spatial import Transform, Vec, unit_transform


def _motion(axis: Vec, q: tuple[Expr, ...]) -> Transform:
    return unit_transform(axis[0].graph)


def _subspace(axis: Vec) -> tuple[tuple[Vec, Vec], ...]:
    return ()


FIXED = JointKind(class_t=6, units=(), motion=_motion, subspace=_subspace)
