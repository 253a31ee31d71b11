"""What a robot file has no words for, told in words of its own: whose positions q1, q2, ... are.

A URDF or MJCF file names joints and links; coordinates are called q1, q2, ...
"""

from __future__ import annotations

from pathlib import Path

from symdyn.scene.values.model import Scene

SCENES = ("", ".toml", ".par")
"""Endings of files that name their coordinates themselves, or none where Python made the scene."""

MOST = 12


def coordinates_of_joints(scene: Scene, most: int | None = None) -> str:
    """Return which joint each coordinate of a robot file belongs to: "q1 shoulder, q2 elbow"; "" of other scenes.

    Args:
        scene: the mechanism.
        most: joints that are told; None: all.
    """
    if Path(scene.source).suffix.lower() in SCENES:
        return ""
    joints = [joint for joint in scene.joints if joint.coordinates]
    told = [f"{_run(joint.coordinates)} {joint.name}" for joint in joints[:most]]
    return ", ".join([*told, *([f"... ({len(joints)} joints in all)"] if len(told) < len(joints) else [])])


def _run(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} ... {names[-1]}"
