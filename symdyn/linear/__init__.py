"""Mechanisms to first order next to a point or a steady motion: state space, modes, stability."""

from symdyn.linear.equilibrium import Equilibria, Equilibrium
from symdyn.linear.linearization import Axis, Linearization, Point
from symdyn.linear.linearized import linearize, linearize_along, linearize_at_rest
from symdyn.linear.modes import Mode, Spectrum
from symdyn.linear.verdict import Stability, stability

__all__ = [
    "Axis",
    "Equilibria",
    "Equilibrium",
    "Linearization",
    "Mode",
    "Point",
    "Spectrum",
    "Stability",
    "linearize",
    "linearize_along",
    "linearize_at_rest",
    "stability",
]
