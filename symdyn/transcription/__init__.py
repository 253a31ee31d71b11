"""Optimal control as equations in numbers: what solvers of nonlinear programs ask for, and what they find."""

from symdyn.transcription.ipopt import solve
from symdyn.transcription.problem import collocation
from symdyn.transcription.solution import Solution, along
from symdyn.transcription.tableaux import METHODS, Method
from symdyn.transcription.transcribed import Collocation

__all__ = ["METHODS", "Collocation", "Method", "Solution", "along", "collocation", "solve"]
