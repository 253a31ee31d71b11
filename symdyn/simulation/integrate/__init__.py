"""Integrators; `METHODS` is the table of all."""

import math
from functools import partial

from symdyn.errors import MethodError, suggestion
from symdyn.frozen import replace
from symdyn.simulation.integrate import gauss, moreau, stepwise, taylor
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

METHODS: dict[str, Method] = taylor.METHODS | stepwise.SCIPY | stepwise.SUNDIALS | gauss.METHODS | moreau.METHODS


def named(name: str) -> Method:
    """Return a method by its name, behind which the length of its steps may stand: moreau:1e-3.

    Raises:
        MethodError: there is none, or that is no length.
    """
    key, colon, text = name.lower().partition(":")
    if key not in METHODS or (colon and METHODS[key].step is None):
        raise MethodError(f"method {name} is not known; {suggestion(key, METHODS)}")
    if not colon:
        return METHODS[key]
    try:
        step = float(text)
    except ValueError:
        step = math.nan
    if not 1e-9 <= step < math.inf:
        raise MethodError(f"method {name}: {text or 'nothing'} is no length of a step; give it in s, {key}:1e-3")
    return replace(METHODS[key], step=step, run=partial(moreau.run, step=step))


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
    "named",
]
