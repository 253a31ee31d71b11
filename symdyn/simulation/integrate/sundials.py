"""SUNDIALS through scikit-sundae: CVODE's multistep methods, BDF for stiff systems and Adams for others, and IDA.

IDA takes the equations with multipliers as they are, see `symdyn.simulation.equations.implicit`.

Reference: Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers (2005).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from functools import partial
from io import StringIO
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.equations.implicit import Implicit, slopes_in_turn
from symdyn.simulation.equations.system import StateEquations
from symdyn.simulation.integrate.method import SHARE, InitialValueProblem, IntegrationError, Method, Piece
from symdyn.simulation.integrate.steps import follow
from symdyn.simulation.integrate.watch import IntegrationStep

SMALLEST, SMALLEST_IDA = 1e-15, 1e-12
"""The finest tolerances that the methods get along with; below, IDA's equations are not solved to it."""

SLACK = 1e5
"""A projection makes CVODE begin at order one again: it waits until it is worth that."""


def run(problem: InitialValueProblem, name: str) -> Iterator[Piece]:
    """Yield the pieces of the motion by CVODE's BDF or Adams methods.

    Raises:
        IntegrationError: CVODE cannot go on; with its words.
    """
    from sksundae.cvode import CVODE

    count, derivative = 0, slopes_in_turn(problem.system)

    def right(t: float, x: Array, out: Array) -> None:
        nonlocal count
        count += 1
        out[:] = problem.system.rates(t, x)

    def slope(t: float, x: Array, rates: Array, out: Array) -> None:
        out[:] = derivative(t, x)

    solver: Any = CVODE(right, method=name, jacfn=slope, **_options(problem, SMALLEST))
    return _followed(problem, solver, "CVODE", lambda t, x: (x,), lambda: count)


def run_ida(problem: InitialValueProblem) -> Iterator[Piece]:
    """Yield the pieces of the motion by IDA's BDF methods.

    Raises:
        IntegrationError: IDA cannot go on; with its words.
    """
    from sksundae.ida import IDA

    equations, count = Implicit(problem.system), 0

    def residual(t: float, y: Array, rates: Array, out: Array) -> None:
        nonlocal count
        count += 1
        out[:] = equations.residual(t, y, rates)

    def slope(t: float, y: Array, rates: Array, values: Array, c: float, out: Array) -> None:
        out[:] = equations.slope(t, y, rates, c)

    solver: Any = IDA(residual, jacfn=slope, **_options(problem, SMALLEST_IDA))
    return _followed(problem, solver, "IDA", equations.start, lambda: count)


def _options(problem: InitialValueProblem, least: float) -> dict[str, Any]:
    """Return tolerances; SUNDIALS keeps its own warnings, which go to the standard output, to itself."""
    for stream in ("WARNING", "ERROR"):
        os.environ.setdefault(f"SUNLOGGER_{stream}_FILENAME", os.devnull)
    rtol = max(SHARE * problem.rtol, least)
    return {"rtol": rtol, "atol": problem.atol * (rtol / problem.rtol), "max_num_steps": 100_000}


def _followed(
    problem: InitialValueProblem,
    solver: Any,
    title: str,
    whole: Callable[[float, Array], tuple[Array, ...]],
    count: Callable[[], int],
) -> Iterator[Piece]:
    """Yield the pieces of a solver's steps; `whole` makes its own state, whose first part is the problem's."""
    size = len(problem.x)
    solver.init_step(0.0, *whole(0.0, problem.x))

    def steps() -> Iterator[IntegrationStep]:
        t, again = 0.0, 0
        while t < problem.until:
            with redirect_stdout(StringIO()):  # where scikit-sundae prints why a step failed, beside returning it
                found = solver.step(problem.bound, method="onestep", tstop=problem.bound)
            again = again + 1 if found.t <= t else 0
            if not found.success or again > 1:
                why = "its steps are too small to move the time" if found.success else found.message.rstrip(".")
                raise IntegrationError(f"{title} cannot go on after t = {t:g} s: {why}")
            if again:  # after a look inside a step SUNDIALS first returns to its end
                continue
            begin, t = t, float(found.t)
            yield IntegrationStep(begin, t, np.array(found.y[:size], dtype=np.float64), inside, count())

    def inside(times: Array) -> Array:
        """Return the states inside the last step."""
        return np.array([solver.step(float(t), method="normal").y[:size] for t in times])

    def resume(t: float, x: Array) -> None:
        solver.init_step(t, *whole(t, x))

    return follow(problem, steps(), resume, SLACK)


def proportional(system: StateEquations) -> str:
    """Return why IDA does not apply to a system, "" if it does."""
    return "the loops hold coordinates in proportion, and lose rank at their change points" if system.linear else ""


METHODS = {
    "cvode": Method(
        "SUNDIALS",
        "CVODE's BDF, for stiff systems",
        "sksundae",
        "simulate",
        1e-8,
        partial(run, name="BDF"),
        finest=SMALLEST / SHARE,
    ),
    "adams": Method(
        "SUNDIALS",
        "CVODE's Adams methods",
        "sksundae",
        "simulate",
        1e-9,
        partial(run, name="Adams"),
        finest=SMALLEST / SHARE,
    ),
    "ida": Method(
        "SUNDIALS",
        "IDA's BDF, for loops with their multipliers",
        "sksundae",
        "simulate",
        1e-8,
        run_ida,
        proportional,
        finest=SMALLEST_IDA / SHARE,
    ),
}
