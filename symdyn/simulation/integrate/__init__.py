"""Integrators; `METHODS` is the table of all."""

from symdyn.simulation.integrate import gauss, stepwise, taylor
from symdyn.simulation.integrate.integration import (
    DOUBLES,
    Hit,
    InitialValueProblem,
    IntegrationError,
    Method,
    Piece,
    importable,
    integrate,
)

METHODS: dict[str, Method] = {**taylor.METHODS, **stepwise.SCIPY, **stepwise.SUNDIALS, **gauss.METHODS}

FINEST = min(method.finest for method in METHODS.values())
"""The finest relative tolerance that there is a method for."""

__all__ = [
    "DOUBLES",
    "FINEST",
    "METHODS",
    "Hit",
    "InitialValueProblem",
    "IntegrationError",
    "Method",
    "Piece",
    "importable",
    "integrate",
]
