"""Equations of motion, derived twice: by Lagrange's equations and by recursion along the tree.

What decides numerically about loops and reactions needs NumPy and is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from symdyn.dynamics.closed_forms.frames_and_parameters import base_parameters
from symdyn.dynamics.loops.partition import LoopChoices
from symdyn.dynamics.roads.derive import (
    LARGEST,
    available,
    available_on,
    called,
    derive,
    derive_one,
    expected,
    loop_alone,
    of_place,
    there,
    wanted_on,
)
from symdyn.dynamics.roads.named_functions import Argument, Equations, Function
from symdyn.dynamics.roads.output import Output, Road, Unasked
from symdyn.dynamics.roads.outputs import OUTPUTS, coefficients
from symdyn.dynamics.roads.regressor_outputs import linear_parameters
from symdyn.dynamics.roads.requests import request_of, roads_lacking, roads_of, row_of
from symdyn.dynamics.roads.workspace import Workspace

if TYPE_CHECKING:
    from symdyn.dynamics.loops.continuation import assemble, consistent, follow
    from symdyn.dynamics.roads.unique_reactions import reactions_at, unique_reactions

_NUMERIC = {
    "assemble": "symdyn.dynamics.loops.continuation",
    "consistent": "symdyn.dynamics.loops.continuation",
    "follow": "symdyn.dynamics.loops.continuation",
    "reactions_at": "symdyn.dynamics.roads.unique_reactions",
    "unique_reactions": "symdyn.dynamics.roads.unique_reactions",
}

__all__ = [
    "LARGEST",
    "OUTPUTS",
    "Argument",
    "Equations",
    "Function",
    "LoopChoices",
    "Output",
    "Road",
    "Unasked",
    "Workspace",
    "assemble",
    "available",
    "available_on",
    "base_parameters",
    "called",
    "coefficients",
    "consistent",
    "derive",
    "derive_one",
    "expected",
    "follow",
    "linear_parameters",
    "loop_alone",
    "of_place",
    "reactions_at",
    "request_of",
    "roads_lacking",
    "roads_of",
    "row_of",
    "there",
    "unique_reactions",
    "wanted_on",
]


def __getattr__(name: str) -> Any:
    """Import what needs NumPy when it is first asked for."""
    if name in _NUMERIC:
        return getattr(import_module(_NUMERIC[name]), name)
    raise AttributeError(f"symdyn.dynamics has no {name!r}")
