"""Integrators, one file a library; `METHODS` is the table of all."""

from symdyn.simulation.integrate import gauss, scipy_ivp, sundials, taylor
from symdyn.simulation.integrate.method import Hit, IntegrationError, Method, Piece, Problem, importable, integrate

METHODS: dict[str, Method] = {**taylor.METHODS, **scipy_ivp.METHODS, **sundials.METHODS, **gauss.METHODS}

__all__ = ["METHODS", "Hit", "IntegrationError", "Method", "Piece", "Problem", "importable", "integrate"]
