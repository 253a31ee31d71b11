"""Scenes: what a user declares, from TOML, Denavit-Hartenberg tables or Python."""

from symdyn.scene.binding import bind, read_bindings, with_values, without_hidden_zeros
from symdyn.scene.build import body, dh_table, given, looked_at, parameter, point, scene
from symdyn.scene.build_joints import (
    custom,
    cylindrical,
    fixed,
    free,
    helical,
    joint,
    loop,
    planar,
    point_on_line,
    point_on_plane,
    prismatic,
    revolute,
    rod,
    spherical,
    universal,
)
from symdyn.scene.declaration.locking import lock
from symdyn.scene.declaration.reading import ReadOptions, Written
from symdyn.scene.examples import example, examples
from symdyn.scene.forces import FORCES, pull_of
from symdyn.scene.forces.body_load import load
from symdyn.scene.forces.contact import knife_edge, rolling
from symdyn.scene.forces.damper import Damper, damper
from symdyn.scene.forces.force_kind import ForceKind, Pull, Push
from symdyn.scene.forces.friction import Friction
from symdyn.scene.forces.spring import Spring, spring
from symdyn.scene.forces.velocity_row import Formula, row
from symdyn.scene.joints import JOINTS, JointKind, JointMotion, Move
from symdyn.scene.joints.start import starting_position, starting_velocity
from symdyn.scene.scene_files import FileLike, SceneLike, read, read_noting, scene_of, write_text
from symdyn.scene.symbolic import with_symbols
from symdyn.scene.ten_parameters import with_symbolic_inertia
from symdyn.scene.toml import read_text
from symdyn.scene.values.body import Body, Particle, Pose
from symdyn.scene.values.element import Contact, Element, Load, Place, Row, Strut
from symdyn.scene.values.formula import FormulaError, parse
from symdyn.scene.values.joint import Coupling, Joint, Limits, acceleration_name, velocity_name
from symdyn.scene.values.mapping import in_numbers
from symdyn.scene.values.model import GROUND, Input, Parameter, Point, Scene, Signal
from symdyn.scene.values.outline import OUTLINES
from symdyn.scene.values.quantity import Quantity, express, number, symbol
from symdyn.scene.values.spelling import spell

__all__ = [
    "FORCES",
    "GROUND",
    "JOINTS",
    "OUTLINES",
    "Body",
    "Contact",
    "Coupling",
    "Damper",
    "Element",
    "FileLike",
    "ForceKind",
    "Formula",
    "FormulaError",
    "Friction",
    "Input",
    "Joint",
    "JointKind",
    "JointMotion",
    "Limits",
    "Load",
    "Move",
    "Parameter",
    "Particle",
    "Place",
    "Point",
    "Pose",
    "Pull",
    "Push",
    "Quantity",
    "ReadOptions",
    "Row",
    "Scene",
    "SceneLike",
    "Signal",
    "Spring",
    "Strut",
    "Written",
    "acceleration_name",
    "bind",
    "body",
    "custom",
    "cylindrical",
    "damper",
    "dh_table",
    "example",
    "examples",
    "express",
    "fixed",
    "free",
    "given",
    "helical",
    "in_numbers",
    "joint",
    "knife_edge",
    "load",
    "lock",
    "looked_at",
    "loop",
    "number",
    "parameter",
    "parse",
    "planar",
    "point",
    "point_on_line",
    "point_on_plane",
    "prismatic",
    "pull_of",
    "read",
    "read_bindings",
    "read_noting",
    "read_text",
    "revolute",
    "rod",
    "rolling",
    "row",
    "scene",
    "scene_of",
    "spell",
    "spherical",
    "spring",
    "starting_position",
    "starting_velocity",
    "symbol",
    "universal",
    "velocity_name",
    "with_symbolic_inertia",
    "with_symbols",
    "with_values",
    "without_hidden_zeros",
    "write_text",
]
