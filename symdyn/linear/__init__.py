"""Mechanisms to first order next to a point or a steady motion: state space, modes, stability."""

from symdyn.linear.linearization import Axis, Linearization, Point
from symdyn.linear.linearized import linearize
from symdyn.linear.modes import Mode, Spectrum

__all__ = ["Axis", "Linearization", "Mode", "Point", "Spectrum", "linearize"]
