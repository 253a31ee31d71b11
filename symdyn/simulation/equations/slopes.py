"""The derivative of a system's rates by its state, ∂f/∂x, for implicit methods: the equations' graph differentiated.

    c, H, fit    a closed mechanism's correction -G_d⁻¹ r, zero where its loops are closed; q̇ = H u; fitted velocities
    δq' = δq + H δc        δu' = δfit(q', u)        δf = δrates(q', u')

f brings a state back to its loops before it looks at it, and so does its derivative. One function takes a state and a
direction (δq, δu); all columns are one call of it, a batch of directions. Its length is thus that of the equations
times three or so, however many columns there are, and no size of a difference has to be guessed: a coordinate that
nothing depends on, as of a shaft that turns freely, has a column of zeros.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symdyn.algebra.numeric import Array
from symdyn.graph import substitute, tangents
from symdyn.simulation.equations.compiled_routines import Compiled, argument, compiled, plain
from symdyn.simulation.equations.system import StateEquations

RELATIVE = 1e-6
"""Size of a difference, over that of the coordinate or 1: where the graph has no value."""


def slopes(system: StateEquations) -> Callable[[float, Array], Array]:
    """Return the function of (t, x) whose value is ∂f/∂x, shape (nx, nx)."""
    nq, nv = system.nq, system.nv
    along = system.once(_along).at(system.opened.values)["along"]
    every_q, every_u = (np.ascontiguousarray(part) for part in np.split(np.eye(nq + nv), [nq], axis=1))

    def slope(t: float, x: Array) -> Array:
        J = np.zeros((len(x), len(x)))
        q, u = x[:nq], x[nq : nq + nv]
        if not system.ill_chosen(q):
            J[:, : nq + nv] = along(q, u, system.tables(t), t, every_q, every_u).T
            if np.all(np.isfinite(J)):
                return J
        return differences(system, t, x, RELATIVE)

    return slope


def _along(system: StateEquations) -> Compiled:
    """Return the derivative of the rates in a direction (δq, δu), their last arguments."""
    program, nq, nv = system.program, system.nq, system.nv
    rates = program["rates"].function
    q, u = (one.symbols for one in rates.arguments if one.name in ("q", "qd"))
    dq, du = argument(program.graph, "dq", nq), argument(program.graph, "du", nv)
    along = (dq.symbols, du.symbols)
    if system.closed and not system.linear:
        names = ("correction", "movement", "fitted")
        correction, movement, fitted = (program[name].function.entries for name in names)
        step = tangents(correction, dict(zip(q, dq.symbols, strict=True)))
        moved = substitute(movement, dict(zip(u, step, strict=True)))
        ways = tuple(a + b for a, b in zip(dq.symbols, moved, strict=True))
        along = (ways, tuple(tangents(fitted, dict(zip((*q, *u), (*ways, *du.symbols), strict=True)))))
    entries = tangents(rates.entries, dict(zip((*q, *u), (*along[0], *along[1]), strict=True)))
    function = plain("along", entries, (*rates.arguments, dq, du))
    return compiled(system.opened.scene, program.graph, (function,))


def differences(system: StateEquations, t: float, x: Array, relative: float) -> Array:
    """Return ∂f/∂x by central differences of that relative size, (nx, nx); zeros where it is not finite."""
    J = np.empty((len(x), len(x)))
    for k in range(len(x)):
        step = relative * max(1.0, abs(float(x[k])))
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        J[:, k] = (system.rates(t, ahead) - system.rates(t, behind)) / (2 * step)
    return np.where(np.isfinite(J), J, 0.0)
