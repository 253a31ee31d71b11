"""Scenes: what a user declares, from TOML, Denavit-Hartenberg tables or Python."""

from symdyn.scene.joints import JOINTS, JointKind
from symdyn.scene.model import (
    GROUND,
    Body,
    Joint,
    Parameter,
    Particle,
    Point,
    Pose,
    Scene,
    acceleration_name,
    velocity_name,
)
from symdyn.scene.quantity import Quantity, express, number, symbol

__all__ = [
    "GROUND",
    "JOINTS",
    "Body",
    "Joint",
    "JointKind",
    "Parameter",
    "Particle",
    "Point",
    "Pose",
    "Quantity",
    "Scene",
    "acceleration_name",
    "express",
    "number",
    "symbol",
    "velocity_name",
]
