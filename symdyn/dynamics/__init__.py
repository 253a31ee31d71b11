"""Equations of motion, derived twice: by Lagrange's equations and by recursion along the tree."""

from symdyn.dynamics.base_parameters import base_parameters
from symdyn.dynamics.derive import CUBIC, DYNAMICS, KINEMATICS, LARGE, available, derive, derive_one, roads
from symdyn.dynamics.equations import Argument, Equations, Function
from symdyn.dynamics.outputs import OUTPUTS
from symdyn.dynamics.workspace import Workspace

__all__ = [
    "CUBIC",
    "DYNAMICS",
    "KINEMATICS",
    "LARGE",
    "OUTPUTS",
    "Argument",
    "Equations",
    "Function",
    "Workspace",
    "available",
    "base_parameters",
    "derive",
    "derive_one",
    "roads",
]
