"""Runs of a scene without drives by any method at any tolerance, timed, and where they truly end.

The truth, by which every method is judged, has more digits than a double: Taylor's method in the long doubles of the
machine, 64 bits of significand on x86 and 113 on 64-bit ARM, at least three digits more than the best run in doubles
can have, whatever the motion does to errors. Starts are the doubles that the methods are given, brought onto closed
loops at 50 digits. Steps are made shorter until two runs agree, with each other and roughly with DOP853: a series of
tanh, as of smoothed friction, does not see its poles coming. How the last two differ tells how far the truth itself may
be off. Where heyoka or long doubles are missing, for equations that branch, and where nothing agrees, DOP853 at its
finest stands in.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.algebra import Array, BigFloats
from symdyn.errors import SimulateError
from symdyn.frozen import dataclass, replace
from symdyn.graph import evaluate
from symdyn.scene import Scene
from symdyn.simulation.equations.system import Projection, StateEquations
from symdyn.simulation.equations.written import state_equations
from symdyn.simulation.forward import check_start
from symdyn.simulation.initial import read_start
from symdyn.simulation.integrate import METHODS
from symdyn.simulation.integrate.heyoka_expressions import taylor_of
from symdyn.simulation.integrate.integration import InitialValueProblem, Piece, integrate
from symdyn.simulation.trajectory_builder import observe

Long = npt.NDArray[np.longdouble]

EPSILON = float(np.finfo(np.longdouble).eps)
DIGITS = round(-np.log10(EPSILON))
FINEST = (2.3e-14, 2.3e-13)
"""Tolerances of DOP853 where it stands in; SciPy takes none below 100 eps."""

NEWTON = 3
"""Steps from a state that is good to eight digits to one that is good to fifty."""

SHARE, SHORTER, RUNS = 16, 0.25, 8
"""Steps of the first run are at most this part of the motion, those of the next one so many times as long; runs."""

SETTLED, NEAR = 1e-15, 1e4
"""Two runs that differ by less have settled; by less than so many times that where shorter steps no longer help."""

ROUGH = 1e-9
"""Tolerance of a run of DOP853 that has to be near."""

Doubles = Callable[[str, float], Array]


@dataclass(frozen=True)
class Truth:
    """The end of a motion."""

    x: Long  # coordinates, then velocities, shape (nq + nv,)
    uncertain: float  # how far it may be off, in the measure of `distance`
    how: str  # by which method, in words

    def distance(self, x: npt.NDArray[Any]) -> float:
        """Return the largest difference from a state, over the largest entry of either one, at least 1."""
        size = max(1.0, float(np.abs(self.x).max()), float(np.abs(x).max()))
        return float(np.abs(self.x - x[: len(self.x)]).max()) / size


def truth(system: StateEquations, x: Array, until: float, doubles: Doubles) -> Truth:
    """Return where the motion from x ends.

    Args:
        system: the equations.
        x: state at t = 0.
        until: time of the end, s.
        doubles: end of a run by a method with a tolerance.

    Raises:
        SimulateError: the motion cannot be computed up to its end.
    """
    n = system.nq + system.nv
    why = METHODS["taylor"].refuses(system)
    if not why and not METHODS["taylor"].installed:
        why = "heyoka is not installed"
    if not why and EPSILON > 1e-18:
        why = "long doubles are doubles here"
    if not why:
        try:
            found = _taylor(system, x, until)
        except SimulateError as fault:
            why = str(fault)
        else:
            apart = found.distance(doubles("dop853", ROUGH))
            if found.uncertain <= SETTLED * NEAR and apart <= ROUGH * NEAR:
                return found
            why = f"Taylor's method does not settle: by shorter steps its end moves by {found.uncertain:.0e}"
    best, other = (doubles("dop853", tolerance)[:n].astype(np.longdouble) for tolerance in FINEST)
    how = f"DOP853 at {FINEST[0]:g}, as good as others at their best and no better: {why}"
    return Truth(best, Truth(best, 0.0, how).distance(other), how)


def long_double(value: Fraction) -> Any:
    """Return a fraction as a long double, good to an ulp."""
    return np.longdouble(value.numerator) / np.longdouble(value.denominator)


def _taylor(system: StateEquations, x: Array, until: float) -> Truth:
    """Return the end of the motion by ever shorter steps, until it settles."""
    start = np.concatenate([_on_loops(system, x), np.zeros(int(system.works), np.longdouble)])
    ta, reached = taylor_of(system, start.copy(), long_double, np.longdouble)
    how = f"Taylor's method with {DIGITS} digits"
    found, step = Truth(start, np.inf, how), np.longdouble(until) / SHARE
    for _ in range(RUNS):
        ta.state[:], ta.time = start, np.longdouble(0)
        outcome, _, _, steps, *_ = ta.propagate_until(np.longdouble(until), max_delta_t=step)
        if outcome != reached:
            raise SimulateError(f"{system.scene.name}: the motion leaves what numbers hold after t = {ta.time:g} s")
        end = Truth(ta.state[: system.nq + system.nv].copy(), 0.0, how)
        before, found = found.uncertain, replace(end, uncertain=end.distance(found.x))
        if found.uncertain <= SETTLED or SETTLED * NEAR > found.uncertain > before / 4:
            break
        step = SHORTER * min(step, np.longdouble(until) / steps)
    return found


def _on_loops(system: StateEquations, x: Array) -> Long:
    """Return a start with its loops closed to all digits, the independent coordinates as they are."""
    if not system.closed:
        return x[: system.nq + system.nv].astype(np.longdouble)
    big = BigFloats(50)
    q, u = ([big.number(value) for value in part] for part in np.split(x[: system.nq + system.nv], [system.nq]))

    known = system.compiled.values(system.opened.values)
    prepared = [[big.number(float(value)) for value in known]] if len(known) else []

    def call(name: str, *given: list[Any]) -> list[Any]:
        function = system.compiled.prepared[name].function
        return evaluate(function.entries, big, function.values((*prepared, *given), lambda value: value))

    for _ in range(NEWTON):
        moved = call("movement", q, call("correction", q, u))
        q = [a + b for a, b in zip(q, moved, strict=True)]
    u = call("fitted", q, u)
    return np.array([np.longdouble(big.context.nstr(value, 40)) for value in (*q, *u)])


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
        scene.refuse_states("a timed run", SimulateError)
        x = np.concatenate([begin.q, begin.u, np.zeros(int(system.works))])
        check_start(system, x)
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
