"""Motions in time: motion prescribed and forces found, or forces prescribed and motion found."""

from symdyn.simulation.forces import Forces, read_forces
from symdyn.simulation.forward import simulate
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.inverse import inverse
from symdyn.simulation.model import Event, Trajectory
from symdyn.simulation.motion import Motion, read_motion

__all__ = ["METHODS", "Event", "Forces", "Motion", "Trajectory", "inverse", "read_forces", "read_motion", "simulate"]
