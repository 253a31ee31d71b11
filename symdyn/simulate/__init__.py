"""Motions in time: motion prescribed and forces found, or forces prescribed and motion found."""

from symdyn.simulate.forces import Forces, read_forces
from symdyn.simulate.forward import simulate
from symdyn.simulate.integrate import METHODS
from symdyn.simulate.inverse import inverse
from symdyn.simulate.model import Event, Trajectory
from symdyn.simulate.motion import Motion, read_motion

__all__ = ["METHODS", "Event", "Forces", "Motion", "Trajectory", "inverse", "read_forces", "read_motion", "simulate"]
