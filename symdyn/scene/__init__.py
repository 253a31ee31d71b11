"""Scenes: what a user declares, from TOML, Denavit-Hartenberg tables or Python."""

from symdyn.scene.build import body, dh_table, fixed, joint, parameter, point, prismatic, revolute, scene
from symdyn.scene.formula import FormulaError, parse
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
from symdyn.scene.names import check_name
from symdyn.scene.quantity import Quantity, express, number, symbol
from symdyn.scene.spelling import spell
from symdyn.scene.symbolic import with_symbolic_inertia
from symdyn.scene.toml import read, read_text

__all__ = [
    "GROUND",
    "JOINTS",
    "Body",
    "FormulaError",
    "Joint",
    "JointKind",
    "Parameter",
    "Particle",
    "Point",
    "Pose",
    "Quantity",
    "Scene",
    "acceleration_name",
    "body",
    "check_name",
    "dh_table",
    "express",
    "fixed",
    "joint",
    "number",
    "parameter",
    "parse",
    "point",
    "prismatic",
    "read",
    "read_text",
    "revolute",
    "scene",
    "spell",
    "symbol",
    "velocity_name",
    "with_symbolic_inertia",
]
