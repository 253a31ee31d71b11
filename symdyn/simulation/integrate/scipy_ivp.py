"""SciPy's integrators: explicit Runge-Kutta methods, and implicit ones for stiff systems.

References: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I (1993), DOP853; II (1996), Radau IIA;
Shampine and Reichelt, The MATLAB ODE suite (1997), BDF; Petzold, Automatic selection of methods (1983), LSODA.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from symdyn.algebra import Array
from symdyn.simulation.equations.implicit import slopes_in_turn
from symdyn.simulation.integrate.method import SHARE, InitialValueProblem, IntegrationError, Method, Piece
from symdyn.simulation.integrate.steps import follow
from symdyn.simulation.integrate.watch import IntegrationStep

MULTISTEP = ("BDF", "LSODA")

IMPLICIT = ("Radau", *MULTISTEP)
"""Those that ask for the derivative of the rates."""

SMALLEST = 100 * float(np.finfo(np.float64).eps)
"""The smallest relative tolerance that SciPy takes."""


def run(problem: InitialValueProblem, name: str) -> Iterator[Piece]:
    """Yield the pieces of the motion by the integrator that SciPy calls `name`.

    Raises:
        IntegrationError: the step has become too small, or there are no rates to go on with.
    """
    from scipy import integrate

    kind = getattr(integrate, name)
    share = SHARE if name in MULTISTEP else 1.0
    options: dict[str, Any] = {"rtol": max(share * problem.rtol, SMALLEST), "atol": share * problem.atol}
    if name in IMPLICIT:
        options["jac"] = slopes_in_turn(problem.system)
    solver: Any = kind(problem.system.rates, 0.0, problem.x, problem.bound, **options)
    spent = 0

    def steps() -> Iterator[IntegrationStep]:
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise IntegrationError(f"{name} cannot go on after t = {solver.t:g} s: {message.rstrip('.')}")
            yield IntegrationStep(solver.t_old, solver.t, solver.y.copy(), _Interpolant(solver), spent + solver.nfev)

    def resume(t: float, x: Array) -> None:
        nonlocal solver, spent
        spent += solver.nfev
        size = None
        if solver.status == "running":  # else its last step was cut short
            size = min(getattr(solver, "h_abs", None) or solver.step_size, problem.bound - t)
        if not np.isfinite(problem.system.rates(t, x)).all():  # of these SciPy would look for a first step for ever
            raise IntegrationError(f"{name} cannot go on after t = {t:g} s: accelerations have no finite value there")
        solver = kind(problem.system.rates, t, x, problem.bound, first_step=size, **options)

    return follow(problem, steps(), resume, 1e5 if name in MULTISTEP else 1.0)


class _Interpolant:
    """The states inside the last step; DOP853 needs three more evaluations, which are spent when they are asked for."""

    def __init__(self, solver: Any) -> None:
        self.solver, self.curve = solver, None

    def __call__(self, times: Array) -> Array:
        if self.curve is None:
            self.curve = self.solver.dense_output()
        return np.asarray(self.curve(times), dtype=np.float64).T  # type: ignore[misc]


def _method(name: str, text: str, rtol: float) -> Method:
    share = SHARE if name in MULTISTEP else 1.0
    return Method("SciPy", text, "scipy", "", rtol, partial(run, name=name), finest=SMALLEST / share)


METHODS = {
    "dop853": _method("DOP853", "explicit Runge-Kutta method of order 8", 1e-10),
    "rk45": _method("RK45", "explicit Runge-Kutta method of order 5", 1e-8),
    "rk23": _method("RK23", "explicit Runge-Kutta method of order 3", 1e-6),
    "radau": _method("Radau", "implicit Runge-Kutta method of order 5, for stiff systems", 1e-8),
    "bdf": _method("BDF", "backward differentiation formulas, for stiff systems", 1e-8),
    "lsoda": _method("LSODA", "Adams and BDF methods, changed as the system is stiff or not", 1e-9),
}
