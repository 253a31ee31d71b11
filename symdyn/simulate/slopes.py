"""The derivative of a system's rates by its state, ∂f/∂x, for implicit methods: the equations' graph differentiated.

    c, H, fit    a closed mechanism's correction -G_d⁻¹ r, zero where its loops are closed; q̇ = H u; fitted velocities
    δq' = δq + H δc        δu' = δfit(q', u)        δf = δrates(q', u')

f brings a state back to its loops before it looks at it, and so does its derivative. One function takes a state and a
direction (δq, δu); all columns are one call of it, a batch of directions. Its length is thus that of the equations
times three or so, however many columns there are, and no size of a difference has to be guessed: a coordinate that
nothing depends on, as of a shaft that turns freely, has a column of zeros.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from symdyn.build.load import load_program
from symdyn.dynamics.equations import Argument, Equations, Function
from symdyn.graph import Expr, substitute, tangents
from symdyn.program import lower

if TYPE_CHECKING:
    from symdyn.simulate.system import System

Array = npt.NDArray[np.float64]

RELATIVE = 1e-6
"""Size of a difference, over that of the coordinate or 1: where the graph has no value."""


def slopes(system: System) -> Callable[[float, Array], Array]:
    """Return the function of (t, x) whose value is ∂f/∂x, shape (nx, nx)."""
    program, nq, nv = system.program, system.nq, system.nv
    rates = program["rates"].function
    graph = program.graph
    symbols = {argument.name: argument.symbols for argument in rates.arguments}
    dq = [graph.symbol(f"dq[{k}]") for k in range(nq)]
    du = [graph.symbol(f"du[{k}]") for k in range(nv)]
    along_q: Sequence[Expr] = dq
    along_u: Sequence[Expr] = du
    if system.closed and not system.linear:
        correction, movement, fitted = (program[name].function.entries for name in ("correction", "movement", "fitted"))
        step = tangents(correction, dict(zip(symbols["q"], dq, strict=True)))
        moved = substitute(movement, dict(zip(symbols["qd"], step, strict=True)))
        along_q = [a + b for a, b in zip(dq, moved, strict=True)]
        along_u = tangents(fitted, _seeds(symbols, along_q, du))
    entries = tangents(rates.entries, _seeds(symbols, along_q, along_u))
    directions = (
        Argument("dq", tuple(dq), "direction of the positions", ()),
        Argument("du", tuple(du), "direction of the velocities", ()),
    )
    function = Function(
        name="along",
        text="rates along a direction",
        arguments=(*rates.arguments, *directions),
        result="out",
        shape=(len(entries),),
        entries=tuple(entries),
        units="",
        formulation="",
    )
    calls, _ = load_program(lower(Equations(system.scene, graph, (function,))), lean=True)
    every_q, every_u = np.eye(nq + nv)[:, :nq].copy(), np.eye(nq + nv)[:, nq:].copy()

    def slope(t: float, x: Array) -> Array:
        J = np.zeros((len(x), len(x)))
        q, u = x[:nq], x[nq : nq + nv]
        if not system.ill_chosen(q):
            J[:, : nq + nv] = calls["along"](q, u, system.tables(t), t, every_q, every_u).T
            if np.all(np.isfinite(J)):
                return J
        return differences(system, t, x, RELATIVE)

    return slope


def _seeds(symbols: dict[str, tuple[Expr, ...]], q: Sequence[Expr], u: Sequence[Expr]) -> dict[Expr, Expr]:
    return dict(zip((*symbols["q"], *symbols["qd"]), (*q, *u), strict=True))


def differences(system: System, t: float, x: Array, relative: float) -> Array:
    """Return ∂f/∂x by central differences of that relative size, (nx, nx); zeros where it is not finite."""
    J = np.empty((len(x), len(x)))
    for k in range(len(x)):
        step = relative * max(1.0, abs(float(x[k])))
        ahead, behind = x.copy(), x.copy()
        ahead[k] += step
        behind[k] -= step
        J[:, k] = (system.rates(t, ahead) - system.rates(t, behind)) / (2 * step)
    return np.where(np.isfinite(J), J, 0.0)
