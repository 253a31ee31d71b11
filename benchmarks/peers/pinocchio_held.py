"""Pinocchio: constrained forward dynamics and their derivatives, points of a robot held to the ground.

`constraintDynamics` and `computeConstraintDynamicsDerivatives` in turn, for the same partial derivatives as ours: of
the solution of M q̈ + h = τ + Gᵀ λ, G q̈ + γ = 0 with all coordinates and velocities taken as independent.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np
from harness import Timed
from native import HERE, NATIVE, address, compiled

from peers import pinocchio_cpp

if TYPE_CHECKING:
    from cases import Case
    from held import Held

    Points = tuple[tuple[str, tuple[float, ...]], ...]

NAME = pinocchio_cpp.NAME

version = pinocchio_cpp.version


def held(case: Case, points: Points) -> tuple[ctypes.CDLL, ctypes.c_void_p, pinocchio_cpp.Places]:
    """Return the code, a robot with points of it held, and our places of its coordinates and velocities."""
    flags = ("-std=c++17", "-w", *NATIVE, *pinocchio_cpp.DEFINES, *pinocchio_cpp.include())
    code = ctypes.CDLL(str(compiled(HERE / "peers" / "pinocchio_held.cpp", flags, "g++")))
    code.peer_robot.restype = ctypes.c_void_p
    code.peer_time.restype = ctypes.c_double
    rows, places = pinocchio_cpp.numbers(case)
    names = list(pinocchio_cpp.model_of(case.urdf).names)
    numbers = np.array([[names.index(joint), *at] for joint, at in points], dtype=float).reshape(-1, 4)
    return code, ctypes.c_void_p(code.peer_robot(len(rows), address(rows), len(numbers), address(numbers))), places


def timed(case: Held, output: str) -> list[Timed]:
    """Return the derivatives, one state a call."""
    code, robot, places = held(case.free, case.points)
    arguments = pinocchio_cpp.given(case, output, places)
    states, size = case.references[output].shape
    out = np.zeros((states, size))

    def run(sweeps: int, into: ctypes.c_void_p | None = None) -> float:
        where = [address(a) for a in arguments]
        return code.peer_time(robot, 1, ctypes.c_long(size), ctypes.c_long(states), ctypes.c_long(sweeps), *where, into)

    def result() -> np.ndarray:
        run(1, address(out))
        return pinocchio_cpp.restored(out, places["qd"], case.n)

    return [Timed(case.name, output, NAME, "state", states, run, result)]
