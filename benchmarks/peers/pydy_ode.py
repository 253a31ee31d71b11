"""PyDy: forward dynamics of the two-link arm, from Kane's equations, by the right-hand side that it generates.

One call gives the derivative of the whole state, q̇ and q̈, for one state; C by Cython where Cython is installed.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
from cases import Case
from harness import Timed, python_sweep
from native import MissingError

NAME = "PyDy"


def generator() -> str:
    """Return the fastest of PyDy's generators that is there."""
    return "cython" if find_spec("Cython") else "lambdify"


def version() -> str:
    """Return its version."""
    import pydy

    return f"{pydy.__version__}, KanesMethod, generator {generator()}"


def timed(case: Case, output: str) -> list[Timed]:
    """Return one call of the right-hand side."""
    from pydy.codegen.ode_function_generators import generate_ode_function

    if output != "forward_dynamics":
        raise MissingError("it generates forward dynamics alone")
    if case.n > 2:
        raise MissingError("Kane's equations in space take SymPy too long")
    from mechanics import kane

    method, robot = kane(case.scene)
    # the driving forces are constants to PyDy, as good as any other input
    rhs = generate_ode_function(
        method.forcing_full,
        robot.q,
        robot.u,
        list(robot.drive),
        mass_matrix=method.mass_matrix_full,
        generator=generator(),
    )
    states = [np.concatenate([case.states["q"][k], case.states["qd"][k]]) for k in range(4)]
    drives = [case.states["tau"][k].copy() for k in range(4)]

    def result() -> np.ndarray:
        return np.array([rhs(x, 0.0, tau)[case.n :] for x, tau in zip(states, drives, strict=True)])

    sweep = python_sweep(lambda: rhs(states[0], 0.0, drives[0]))
    return [Timed(case.name, output, NAME, "python", 1, sweep, result)]
