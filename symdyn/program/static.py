"""Equations of a mechanism at rest: every velocity is zero, and no longer an argument.

Inverse dynamics at rest is M(q) q̈ + g(q), forward dynamics starts from standstill, and velocity forces are zero.
"""

from __future__ import annotations

from dataclasses import replace

from symdyn.dynamics.roads.equations import Argument, Equations
from symdyn.graph import substitute

VELOCITIES = "qd"


def at_rest(equations: Equations) -> Equations:
    """Return the equations with q̇ = 0, on the same graph; functions without velocities are left as they are."""
    graph = equations.graph
    still = {
        symbol: graph.zero
        for function in equations.functions
        for argument in function.arguments
        if argument.name == VELOCITIES
        for symbol in argument.symbols
    }
    entries = iter(substitute([entry for f in equations.functions for entry in f.entries], still))
    functions = tuple(
        replace(
            function,
            text=function.text + ("; at rest, qd = 0" if _moves(function.arguments) else ""),
            arguments=tuple(a for a in function.arguments if a.name != VELOCITIES),
            entries=tuple(next(entries) for _ in function.entries),
        )
        for function in equations.functions
    )
    return Equations(equations.scene, graph, functions)


def _moves(arguments: tuple[Argument, ...]) -> bool:
    return any(argument.name == VELOCITIES for argument in arguments)
