"""Integrators, one file a library; `METHODS` is the table of all."""

from symdyn.simulation.integrate import gauss, scipy_ivp, sundials, taylor
from symdyn.simulation.integrate.method import (
    DOUBLES,
    Hit,
    InitialValueProblem,
    IntegrationError,
    Method,
    Piece,
    importable,
    integrate,
)

METHODS: dict[str, Method] = {**taylor.METHODS, **scipy_ivp.METHODS, **sundials.METHODS, **gauss.METHODS}

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
