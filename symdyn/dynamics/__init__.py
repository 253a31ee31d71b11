"""Equations of motion, derived twice: by Lagrange's equations and by recursion along the tree."""

from symdyn.dynamics.derive import CUBIC, DYNAMICS, KINEMATICS, LARGE, available, derive, derive_one, roads
from symdyn.dynamics.equations import Argument, Equations, Function
from symdyn.dynamics.loops.assembly import Assembly
from symdyn.dynamics.loops.closure import Closing
from symdyn.dynamics.loops.continuation import assemble, consistent, follow
from symdyn.dynamics.loops.mobility import Mobility, mobility
from symdyn.dynamics.loops.outputs import CLOSED_ONLY, is_closed
from symdyn.dynamics.outputs import OUTPUTS
from symdyn.dynamics.reactions.outputs import REACTIONS
from symdyn.dynamics.recursive.base_parameters import base_parameters
from symdyn.dynamics.workspace import Workspace

__all__ = [
    "CLOSED_ONLY",
    "CUBIC",
    "DYNAMICS",
    "KINEMATICS",
    "LARGE",
    "OUTPUTS",
    "REACTIONS",
    "Argument",
    "Assembly",
    "Closing",
    "Equations",
    "Function",
    "Mobility",
    "Workspace",
    "assemble",
    "available",
    "base_parameters",
    "consistent",
    "derive",
    "derive_one",
    "follow",
    "is_closed",
    "mobility",
    "roads",
]
