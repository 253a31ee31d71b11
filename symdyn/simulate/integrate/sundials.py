"""SUNDIALS through scikit-sundae: CVODE's multistep methods, BDF for stiff systems and Adams for others.

Reference: Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers (2005).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from symdyn.simulate.integrate.method import IntegrationError, Method, Piece, Problem, Step, follow

Array = npt.NDArray[np.float64]

SMALLEST = 1e-15

SLACK = 1e5
"""A projection makes CVODE begin at order one again: it waits until it is worth that."""


def run(problem: Problem, name: str) -> Iterator[Piece]:
    """Yield the pieces of the motion by CVODE's BDF or Adams methods.

    Raises:
        IntegrationError: CVODE cannot go on; with its words.
    """
    from sksundae.cvode import CVODE

    count = 0

    def right(t: float, x: Array, out: Array) -> None:
        nonlocal count
        count += 1
        out[:] = problem.system.rates(t, x)

    solver: Any = CVODE(right, method=name, rtol=max(problem.rtol, SMALLEST), atol=problem.atol, max_num_steps=100_000)
    solver.init_step(0.0, problem.x)

    def steps() -> Iterator[Step]:
        t, again = 0.0, 0
        while t < problem.until:
            found = solver.step(problem.until, method="onestep", tstop=problem.until)
            again = again + 1 if found.t <= t else 0
            if not found.success or again > 1:
                raise IntegrationError(f"CVODE cannot go on after t = {t:g} s: {found.message}")
            if again:  # after a look inside a step CVODE first returns to its end
                continue
            begin, t = t, float(found.t)
            yield Step(begin, t, np.array(found.y, dtype=np.float64), inside, count)

    def inside(times: Array) -> Array:
        """Return the states inside the last step."""
        return np.array([solver.step(float(t), method="normal").y for t in times])

    def resume(t: float, x: Array) -> None:
        solver.init_step(t, x)

    return follow(problem, steps(), resume, SLACK)


METHODS = {
    "cvode": Method("SUNDIALS", "CVODE's BDF, for stiff systems", "sksundae", "stiff", 1e-8, partial(run, name="BDF")),
    "adams": Method("SUNDIALS", "CVODE's Adams methods", "sksundae", "stiff", 1e-9, partial(run, name="Adams")),
}
