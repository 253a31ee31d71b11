"""Custom joint: elementary motions whose amounts are formulas in its own coordinates. Class t = 6 - coordinates.

A cam, a screw with a varying pitch, a knee: the motion subspace is what the formulas' derivatives make it. It carries a
body of the tree; it closes no loop, since what it forbids has no closed form.
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.graph import Expr
from symdyn.scene.joints.blocks import path
from symdyn.scene.joints.kind import Block, JointKind, Wrench
from symdyn.scene.joints.turned import inverse
from symdyn.scene.model import Joint
from symdyn.spatial import Transform


def _blocks(joint: Joint) -> tuple[Block, ...]:
    return (path(joint.steps, joint.coordinates, joint.units),)


def _wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
    raise NotImplementedError("a custom joint closes no loop; the scene's check refuses it")


def _residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
    raise NotImplementedError("a custom joint closes no loop; the scene's check refuses it")


def _turned(joint: Joint) -> Joint:
    return replace(joint, steps=inverse(joint.steps))


CUSTOM = JointKind(("steps", "units"), _blocks, _wrenches, _residual, _turned)
