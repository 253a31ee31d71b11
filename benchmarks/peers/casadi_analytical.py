"""CasADi: C that it generates from the graph of Pinocchio's own derivatives, in place of CasADi's jacobian."""

from __future__ import annotations

from cases import Case
from harness import Timed

from peers.casadi_c import generated, version

__all__ = ["NAME", "timed", "version"]

NAME = "CasADi C, analytical"

CODES = {"inverse_dynamics_derivatives": 4, "forward_dynamics_derivatives": 6}


def timed(case: Case, output: str) -> list[Timed]:
    """Return computeRNEADerivatives or computeABADerivatives over CasADi's symbols, one state a call."""
    return [generated(case, output, NAME, CODES[output])]
