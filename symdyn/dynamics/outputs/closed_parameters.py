"""Derivatives of what closed scenes do by their parameters, along the manifold, which a parameter moves.

Independent positions and velocities (and accelerations), and forces, are held; dependent ones go where the loops take
them: G_d δξ_d = -∂r/∂p of the rows that hold positions, then G δu = -δ(G) u, as `Manifold` has it. Of mechanisms whose
lengths are free, the derivative is the one that a designer sees.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symdyn.dynamics.loops.manifold import Seeds
from symdyn.dynamics.outputs import parameter_outputs as parameters
from symdyn.dynamics.outputs.closed_derivatives import ALONG_MANIFOLD, Derivative
from symdyn.dynamics.outputs.closed_slopes import by_row, manifold_of
from symdyn.dynamics.outputs.output import Formulation, Output, by_lagrange
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, substitute, tangents


def _directions(there: Workspace, formulation: str, names: Sequence[str], moves: bool) -> list[Seeds]:
    """Return how all symbols move with each parameter; accelerations too if they are an argument."""
    loops, manifold = there.loops, manifold_of(there, formulation)
    residual = loops.held_residual(loops.differentiated if formulation == "lagrange" else loops.recursive)
    found = [manifold.by_parameter(there.graph.symbol(name), residual) for name in names]
    return [manifold.accelerating(one) for one in found] if moves else found


def _slopes(one: Derivative, formulation: str, only: str, w: Workspace) -> list[Expr]:
    there: Workspace = w.once(parameters.opened)
    entries: Sequence[Expr] = there.once(one.solved[formulation])
    directions = _directions(there, formulation, parameters.names(w, only), "qdd" in one.arguments)
    found = by_row([tangents(entries, seeds) for seeds in directions], len(entries))
    return found if there is w else substitute(found, {}, w.graph)


def by_parameters(of: str, only: str = "") -> Output:
    """Return the row of derivatives of an output along the manifold, by all named parameters or by one."""
    one = ALONG_MANIFOLD[of]
    return Output(
        f"derivatives by {only or 'the named parameters'} along the manifold, independent positions and velocities "
        f"held, dependent ones moving along, of {one.text}",
        one.arguments,
        f"d{one.result}",
        (one.rows, lambda w: parameters.names(w, only)),
        f"{one.units}, per unit of the parameter",
        "only",
        {
            formulation: (by_lagrange if formulation == "lagrange" else Formulation)(
                partial(_slopes, one, formulation, only)
            )
            for formulation in one.solved
        },
        default_in="request",
        may_fail="reported",
        depends=one.depends,
        remark=lambda w: one.remark(w) + parameters.left_out(w, only),
    )


SOLVED = tuple(name for name, one in ALONG_MANIFOLD.items() if one.solved)
"""What can be differentiated so."""
