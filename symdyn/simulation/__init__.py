"""Motions in time: motion prescribed and forces found, or forces prescribed and motion found."""

from symdyn.simulation.feedback.controller import Feedback, read_feedback
from symdyn.simulation.feedback.gains import Gains
from symdyn.simulation.feedback.saturation import Saturation
from symdyn.simulation.forward import simulate
from symdyn.simulation.gradients import Sensitivity, sensitivity
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.inverse_run import inverse
from symdyn.simulation.prescribed.forces import Forces, read_forces
from symdyn.simulation.prescribed.path_entries import read_path
from symdyn.simulation.prescribed.point_path import ScenePath
from symdyn.simulation.prescribed.scene_motion import SceneMotion, read_motion
from symdyn.simulation.trajectory import Event, Trajectory

__all__ = [
    "METHODS",
    "Event",
    "Feedback",
    "Forces",
    "Gains",
    "Saturation",
    "SceneMotion",
    "ScenePath",
    "Sensitivity",
    "Trajectory",
    "inverse",
    "read_feedback",
    "read_forces",
    "read_motion",
    "read_path",
    "sensitivity",
    "simulate",
]
