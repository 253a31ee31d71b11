"""Products with derivatives along the manifold of a closed scene, J d and wᵀ J, without J.

    d        amounts of the independent positions and velocities, and of forces or independent accelerations
    w        weights of the entries of the output
    μ, ν     M μ - Gᵀ ν = w_u̇, G μ = -w_λ: what forward dynamics solves once more, for weights of u̇ and of λ

By the symmetry of what is solved  w·(δu̇, δλ) = -μ·δR + ν·δC  at fixed μ, ν, u̇ and λ: one sweep backwards over unsolved
equations, and the dependent positions and velocities taken out of the sum by a solution each (`Manifold.pulled`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from symdyn.dynamics.outputs.closed_derivatives import ALONG, ALONG_MANIFOLD, Derivative
from symdyn.dynamics.outputs.closed_slopes import carried_forces, driven, equations, manifold_of, solution
from symdyn.dynamics.outputs.named_functions import ALONG_MANIFOLD as NAMES, WEIGHTS, direction, multiplier_symbols
from symdyn.dynamics.outputs.output import Formulation, Output, by_lagrange
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.graph import Expr, substitute, tangents

WAY = "manifold"


def _amounts(w: Workspace, along: Sequence[str]) -> dict[str, tuple[Expr, ...]]:
    return {name: direction(w.graph, NAMES[name], len(ALONG[name](w))) for name in along}


def _weights(w: Workspace, one: Derivative) -> tuple[Expr, ...]:
    return direction(w.graph, WEIGHTS, len(one.rows(w)))


# J d


def _tangent(one: Derivative, formulation: str, w: Workspace) -> list[Expr]:
    seeds = manifold_of(w, formulation).direction(_amounts(w, one.arguments))
    return tangents(w.once(one.solved[formulation]), seeds)


def _implicit(part: int, w: Workspace) -> list[Expr]:
    amounts = _amounts(w, ("q", "qd", "tau"))
    seeds = manifold_of(w, "implicit").direction(amounts)
    accelerations, multipliers = w.once(solution, WAY)
    known = dict(zip((*w.state.qdd, *multiplier_symbols(w)), (*accelerations, *multipliers), strict=True))
    moved = substitute(tangents(w.once(equations), seeds), known)
    return w.loops.solved([-x for x in moved[: w.state.n]], moved[w.state.n :])[part]


def _implicit_inverse(w: Workspace) -> list[Expr]:
    seeds = manifold_of(w, "implicit").direction(_amounts(w, ("q", "qd", "qdd")))
    return driven(w, tangents(w.once(carried_forces), seeds))


# wᵀ J


def _pulled(one: Derivative, formulation: str, w: Workspace) -> list[Expr]:
    entries = w.once(one.solved[formulation])
    phi = w.graph.total(a * x for a, x in zip(_weights(w, one), entries, strict=True))
    found = manifold_of(w, formulation).pulled(phi, one.arguments)
    return [x for name in one.arguments for x in found[name]]


def _adjoint(one: Derivative, part: int, w: Workspace) -> list[Expr]:
    graph, n, weights = w.graph, w.state.n, _weights(w, one)
    none = [graph.zero] * len(w.loops.decisions.kept)
    mu, nu = w.loops.solved(w.still, weights) if part else w.loops.solved(weights, none)
    fixed = [graph.symbol(f"mu[{k}]") for k in range(n + len(nu))]
    signed = [*(-x for x in fixed[:n]), *fixed[n:]]
    phi = graph.total(a * x for a, x in zip(signed, w.once(equations), strict=True))
    accelerations, multipliers = w.once(solution, WAY)
    symbols = (*w.state.qdd, *multiplier_symbols(w), *fixed)
    known = dict(zip(symbols, (*accelerations, *multipliers, *mu, *nu), strict=True))
    found = manifold_of(w, "implicit").pulled(phi, one.arguments)
    return substitute([x for name in one.arguments for x in found[name]], known)


# Rows

Entries = Callable[[Workspace], Sequence[Expr]]


def _row(one: Derivative, text: str, formulations: dict[str, Entries], **more: object) -> Output:
    return Output(
        f"{text} along the manifold, dependent positions and velocities moving along, of {one.text}",
        when_constrained="only",
        formulations={
            name: (by_lagrange if name == "lagrange" else Formulation)(derive) for name, derive in formulations.items()
        },
        default_in="request",
        may_fail="reported",
        depends=one.depends,
        remark=one.remark,
        **more,  # type: ignore[arg-type]
    )


def _jvp(one: Derivative, implicit: Entries) -> Output:
    return _row(
        one,
        f"derivative {one.blocks} d along one direction d",
        {"implicit": implicit, **{formulation: partial(_tangent, one, formulation) for formulation in one.solved}},
        arguments=(*one.arguments, *(NAMES[name] for name in one.arguments)),
        result=f"d{one.result}",
        axes=(one.rows,),
        units=f"{one.units}, per unit of the direction",
    )


def _vjp(one: Derivative, formulations: dict[str, Entries]) -> Output:
    return _row(
        one,
        f"derivatives weights^T {one.blocks}",
        {**formulations, **{formulation: partial(_pulled, one, formulation) for formulation in one.solved}},
        arguments=(*one.arguments, WEIGHTS),
        weighs=one.rows,
        result="slopes",
        axes=(lambda w: tuple(label for name in one.arguments for label in ALONG[name](w)),),
        units=f"{one.units}, times weights, per unit of what moves",
    )


_FORWARD, _MULTIPLIERS, _INVERSE = (ALONG_MANIFOLD[x] for x in ("forward_dynamics", "multipliers", "inverse_dynamics"))

CLOSED_PRODUCTS: dict[str, Output] = {
    "forward_dynamics_jvp": _jvp(_FORWARD, partial(_implicit, 0)),
    "forward_dynamics_vjp": _vjp(_FORWARD, {"adjoint": partial(_adjoint, _FORWARD, 0)}),
    "multipliers_jvp": _jvp(_MULTIPLIERS, partial(_implicit, 1)),
    "multipliers_vjp": _vjp(_MULTIPLIERS, {"adjoint": partial(_adjoint, _MULTIPLIERS, 1)}),
    "inverse_dynamics_jvp": _jvp(_INVERSE, _implicit_inverse),
    "inverse_dynamics_vjp": _vjp(_INVERSE, {}),
}
"""Rows of closed scenes, by what is asked."""
