"""What can be asked of closed scenes in place of what operators make of their outputs, along the manifold."""

from __future__ import annotations

from symdyn.dynamics.outputs.closed_derivatives import ALONG_MANIFOLD, CLOSED_DERIVATIVES, MOTION_RESIDUAL, RESIDUAL
from symdyn.dynamics.outputs.closed_parameters import SOLVED, by_parameters
from symdyn.dynamics.outputs.closed_products import CLOSED_PRODUCTS
from symdyn.dynamics.outputs.operators import BY, MOTION, of_another, words_of
from symdyn.dynamics.outputs.output import Output
from symdyn.dynamics.outputs.output_table import OUTPUTS
from symdyn.errors import DerivationError

CLOSED: dict[str, Output] = {**CLOSED_DERIVATIVES, **CLOSED_PRODUCTS}
"""Rows of closed scenes, by what is asked; beside them derivatives by parameters, NAME_by_PARAMETER."""

MANY: dict[str, Output] = {**OUTPUTS, RESIDUAL: MOTION_RESIDUAL}
"""Rows of which many others can be asked for, by a word behind their name."""


def of_closed(name: str) -> Output | None:
    """Return the row that closed scenes have for what is asked; None where there is no other than that of all scenes.

    Raises:
        DerivationError: closed scenes have no such derivatives of what changes along their manifold.
    """
    if name in CLOSED:
        return CLOSED[name]
    output, by, parameter = name.partition(BY)
    if by and output in SOLVED and parameter not in MOTION:
        return by_parameters(output, "" if parameter == "parameters" else parameter)
    of = next((one for one in ALONG_MANIFOLD if name.startswith(f"{one}_") and of_another(name, OUTPUTS)), None)
    if of is None:
        return None
    raise DerivationError(
        f"where loops or rows close a scene there is no {name}; there are {', '.join(words(of, True))}"
    )


def words(of: str, closed: bool) -> list[str]:
    """Return what can be asked of an output, of closed scenes or of others."""
    if not closed or of not in ALONG_MANIFOLD:
        return words_of(of, MANY[of])
    by = (f"{of}{BY}parameters", f"{of}{BY}PARAMETER") if of in SOLVED else ()
    return [*(one for one in CLOSED if one.startswith(f"{of}_")), *by]
