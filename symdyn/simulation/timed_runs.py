"""Runs of a scene without drives by any method at any tolerance, timed: nothing is told of them but states and work."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symdyn.algebra import Array
from symdyn.scene import Scene
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.extended import Truth, truth
from symdyn.simulation.forward import ready
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.method import InitialValueProblem, Piece, integrate
from symdyn.simulation.trajectory_builder import observe

ROUNDING = 1e-14


@dataclass(frozen=True)
class TimedRun:
    """States of a run, the processor time of its integration in seconds, and its evaluations."""

    x: Array
    seconds: float
    evaluations: int


@dataclass(frozen=True)
class TimedRuns:
    """A system and its start, ready to be run by any method."""

    system: StateEquations
    x: Array

    @classmethod
    def of(cls, scene: Scene, at: Mapping[str, str]) -> TimedRuns:
        """Return a scene without drives, its start moved to `at`, ready to be run.

        Raises:
            SimulateError: it cannot be simulated, has parameters without values, or no accelerations at its start.
            DerivationError: there is no forward dynamics.
        """
        system, begin = state_equations(scene), read_start(scene, at)
        x = np.concatenate([begin.q, begin.u, np.zeros(int(system.works))])
        ready(system, x)
        return cls(system, x)

    def run(self, name: str, tolerance: float, until: float, samples: int = 2) -> TimedRun:
        """Return a run; what comes before the first step, such as compiling, is not in its time.

        Raises:
            IntegrationError: it does not reach its end.
        """
        times = np.linspace(0.0, until, samples)
        project = Projection(self.system, max(ROUNDING, 1e-2 * tolerance))
        problem = InitialValueProblem(self.system, self.x, times, tolerance, tolerance, (), project)
        pieces: list[Piece] = []
        begin = 0.0
        for piece in integrate(METHODS[name], problem):
            begin = begin if pieces else time.thread_time()
            pieces.append(piece)
        seconds = time.thread_time() - begin
        return TimedRun(
            np.concatenate([piece.x for piece in pieces]), seconds, sum(piece.evaluations for piece in pieces)
        )

    def truth(self, until: float) -> Truth:
        """Return where the motion ends, to more digits than a double has; errors as of `run`."""
        return truth(self.system, self.x, until, lambda name, tolerance: self.run(name, tolerance, until).x[-1])

    def drift(self, made: TimedRun, until: float) -> float:
        """Return the largest error of the balance of energy of a run over its size."""
        _, monitors = observe(self.system, np.linspace(0.0, until, len(made.x)), made.x)
        return monitors["energy"] / (monitors["energy_scale"] or 1.0)
