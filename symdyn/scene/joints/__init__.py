"""Joint types: one file and one row each."""

from __future__ import annotations

from symdyn.scene.joints.fixed import FIXED
from symdyn.scene.joints.kind import JointKind
from symdyn.scene.joints.prismatic import PRISMATIC
from symdyn.scene.joints.revolute import REVOLUTE

JOINTS: dict[str, JointKind] = {
    "revolute": REVOLUTE,
    "prismatic": PRISMATIC,
    "fixed": FIXED,
}

__all__ = ["JOINTS", "JointKind"]
