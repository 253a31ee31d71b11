"""Dynamics with contacts held both ways, told at run time which: one function for all stances of a walking robot.

    W        rows of all directions of all contacts, those that are not held times zero        M = Lᵀ D L
    c        1 for a row that is held, else 0          γ  the rate of W u at u̇ = 0
    V        L⁻ᵀ Wᵀ, zero but for the joints of each contact's own branch
    Δ        Vᵀ D⁻¹ V + diag(1 - c), regular where the rows that are held are independent
    λ        -Δ⁻¹ (Vᵀ D⁻¹ y + c γ),  y = L⁻ᵀ (τ - h)          L u̇ = D⁻¹ (y + V λ)

A row that is not held reads λ = 0. Of rows that hold the same, Δ is singular, and the forces of least size are found by
the proximal point method, from λ = 0, with a term ρ, in 1/kg for forces:

    λ + (Δ + ρ)⁻¹ (b - Δ λ),    five times; (ρ/(σ + ρ))⁵ of b is left, σ the least value of Δ that is not zero

Derivatives follow from the equations, as `implicit` has it: at u̇ and λ, with the factors of M and Δ,

    -δR = -δ(M u̇ + h - τ - Wᵀ λ),    -δs = -c δ(W u̇ + γ)          δy = L⁻ᵀ (-δR), and then as above

Reference: Carpentier, Budhiraja and Mansard, Proximal and sparse resolution of constrained dynamic equations (2021).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain

from symdyn.dynamics.loops.partition import solve_square
from symdyn.dynamics.mechanism.linear_solve import Factored, RowSolve, RowStep, Singular, factored
from symdyn.dynamics.outputs import recursive_derivatives, tree_formulations as trees
from symdyn.dynamics.outputs.contact_equations import STEPS, Rows, columns_of, dot, eliminated, proximal
from symdyn.dynamics.outputs.contact_outputs import DIRECTIONS, every_touch, touches
from symdyn.dynamics.outputs.contact_rows import Row, Touch
from symdyn.dynamics.outputs.named_functions import DRIVES, MODES, MULTIPLIERS, PROXIMAL, direction
from symdyn.dynamics.outputs.output import Formulation, Output, Size, by_lagrange
from symdyn.dynamics.outputs.tangent_space import FREE
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError, listed
from symdyn.frozen import dataclass
from symdyn.graph import Expr, substitute, tangents

MASK = MODES[0]


def _normal(touch: Touch) -> tuple[Row, ...]:
    """Return the row of a normal, none along what joints hold already."""
    there = touch.normal and not all(entry.is_zero for entry in touch.normal.entries)
    return (touch.normal,) if touch.normal and there else ()


def _names(w: Workspace) -> tuple[str, ...]:
    found = list[str]()
    for one in every_touch(w):
        words = (
            *DIRECTIONS[: len(_normal(one))],
            *("tangent", *DIRECTIONS[1:])[len(one.slips) // 2 :][: len(one.slips)],
        )
        found += [f"{word} of {one.law.name}" for word in words]
    return tuple(found)


def _held(w: Workspace, by_recursion: bool) -> tuple[list[Row], list[Expr]]:
    """Return all rows, rough or smooth, and c of each."""
    every = every_touch(w, by_recursion)
    masks = direction(w.graph, MASK, len(every))
    rows = [(row, c) for touch, c in zip(every, masks, strict=True) for row in (*_normal(touch), *touch.slips)]
    return [row for row, _ in rows], [c for _, c in rows]


# By factors


@dataclass(frozen=True)
class Held:
    """The factors of the legend, of velocities whose motion is not prescribed."""

    free: list[int]  # those velocities
    mass: Factored  # factors of M
    V: Rows  # shape (free, m)
    Z: Rows  # D⁻¹ V
    delta: Rows  # Δ, shape (m, m)
    right: tuple[list[Expr], list[Expr]]  # y, and c γ and what prescribed accelerations add to it

    @property
    def wanted(self) -> list[Expr]:
        """The right side of the equations of λ, shape (m,)."""
        return [-(dot(column, self.right[0]) + x) for column, x in zip(columns(self.Z), self.right[1], strict=True)]


def columns(rows: Rows) -> Rows:
    """Return a matrix transposed."""
    return [list(column) for column in zip(*rows, strict=True)]


def _factors(w: Workspace) -> Held:
    rows, c = _held(w, True)
    graph, free, entered = w.graph, w.prescribed.free, w.prescribed.entered(w.zeros)
    mass = recursive_derivatives.factored_mass(w, w.composite_mass)
    W = [[x * held for x in row.entries] for row, held in zip(rows, c, strict=True)]
    rest = trees.unbalanced(w)
    V = mass.inward([[row[i] for row in W] for i in free])
    y = [x for (x,) in mass.inward([[rest[i]] for i in free])]
    Z = mass.scaled(V)
    gamma = [held * (row.bias + dot(row.entries, entered)) for row, held in zip(rows, c, strict=True)]
    left, right, m = columns(V), columns(Z), range(len(c))
    lower = [[dot(left[i], right[j]) + (graph.one - c[i] if i == j else 0) for j in range(i + 1)] for i in m]
    return Held(free, mass, V, Z, [[lower[max(i, j)][min(i, j)] for j in m] for i in m], (y, gamma))


def _regular(w: Workspace) -> Factored:
    """Return the factors of Δ; DerivationError where rows hold the same when all are held."""
    found: Held = w.once(_factors)
    graph, in_order = w.graph, range(-1, len(found.delta))
    all_held = dict.fromkeys(direction(graph, MASK, len(every_touch(w))), graph.one)
    try:
        factored(graph, in_order, [substitute(row, all_held) for row in found.delta])
    except Singular as fault:
        raise DerivationError(
            f"{w.scene.name}: contacts hold the same where all are held, {_names(w)[fault.velocity]} what "
            f"{listed(_names(w)[fault.velocity + 1 :], 6)} hold, so that their forces are not unique; ask for {LEAST}, "
            "whose forces are of least size"
        ) from fault
    return factored(graph, in_order, found.delta)


def _solution(w: Workspace, lam: Sequence[Expr]) -> list[Expr]:
    found: Held = w.once(_factors)
    moving = w.prescribed.entered(w.zeros)
    whole = [[y + dot(row, lam)] for y, row in zip(found.right[0], found.V, strict=True)]
    for i, (x,) in zip(found.free, found.mass.outward(found.mass.scaled(whole)), strict=True):
        moving[i] = x
    return [*moving, *lam]


def _by_factors(w: Workspace) -> list[Expr]:
    found: Held = w.once(_factors)
    lam = w.once(_regular).solve([[one] for one in found.wanted])
    return _solution(w, [x for (x,) in lam])


def _least_by_factors(w: Workspace) -> list[Expr]:
    found: Held = w.once(_factors)
    A = _softened(w, found.delta)
    regular = factored(w.graph, range(-1, len(A)), A)
    return _solution(w, proximal(found.delta, found.wanted, lambda b: [x for (x,) in regular.solve([[x] for x in b])]))


def _softened(w: Workspace, A: Rows) -> Rows:
    """Return A + ρ."""
    (rho,) = direction(w.graph, PROXIMAL, 1)
    return [[x + rho if i == j else x for j, x in enumerate(row)] for i, row in enumerate(A)]


# By Lagrange's equations and rows of differentiated placements


def _unfactored(w: Workspace, least: bool) -> list[Expr]:
    """Return the same from W M⁻¹ Wᵀ."""
    rows, c = _held(w, False)
    free: list[Expr] = w.once(trees.lagrange_forward)
    by_row = [columns_of(w, free, row) for row in rows]
    one, m = w.graph.one, range(len(rows))
    A = [[c[i] * c[j] * dot(rows[i].entries, by_row[j]) + (one - c[i] if i == j else 0) for j in m] for i in m]
    b = [-held * (dot(row.entries, free) + row.bias) for row, held in zip(rows, c, strict=True)]
    lam = proximal(A, b, partial(eliminated, _softened(w, A))) if least else solve_square(A, b)
    pushed = [held * x for held, x in zip(c, lam, strict=True)]
    return [*(a + dot(parts, pushed) for a, *parts in zip(free, *by_row, strict=True)), *lam]


# Derivatives


def held_derivatives(w: Workspace, along: Sequence[str]) -> list[Expr]:
    """Return the derivatives of accelerations, then of forces, along "q", "qd" or "tau", row by row."""
    found: Held = w.once(_factors)
    sides: Rows = w.once(_sides, *along)
    free = len(found.free)
    y = found.mass.inward(sides[:free])
    lam = w.once(_regular).solve(_less(sides[free:], columns(found.Z), y))
    pushed = _less(y, [[-x for x in row] for row in found.V], lam)
    whole = [[w.graph.zero] * len(sides[0]) for _ in range(w.state.n)]
    for i, row in zip(found.free, found.mass.outward(found.mass.scaled(pushed)), strict=True):
        whole[i] = row
    return list(chain(*whole, *lam))


def _less(rows: Rows, factors: Rows, others: Rows) -> Rows:
    """Return rows - factors @ others."""
    by_column = columns(others)
    return [
        [x - dot(f, column) for x, column in zip(row, by_column, strict=True)]
        for row, f in zip(rows, factors, strict=True)
    ]


def held_solve(w: Workspace, along: Sequence[str]) -> RowSolve | None:
    """Return the steps of the same: rows of y become accelerations, those behind them forces; None with motions."""
    found: Held = w.once(_factors)
    delta: Factored = w.once(_regular)
    n, one = w.state.n, w.graph.one
    if len(found.free) < n:
        return None
    sides: Rows = w.once(_sides, *along)
    steps = [
        *found.mass.inward_steps(),
        *(RowStep(n + r, one, _terms(column, 0)) for r, column in enumerate(columns(found.Z))),
        *delta.steps(range(n, len(sides))),
        *(RowStep(i, one, _terms([-x for x in row], n)) for i, row in enumerate(found.V)),
        *found.mass.outward_steps(),
    ]
    beside = ((None,) * len(sides[0]),) * len(sides)
    at = tuple((k, tuple(row)) for k, row in enumerate(sides))
    return RowSolve(w.scene, at, len(sides), tuple(steps), beside, switched=True)


def _terms(factors: Sequence[Expr], start: int) -> tuple[tuple[Expr, int], ...]:
    return tuple((x, start + k) for k, x in enumerate(factors) if not x.is_zero)


def _sides(w: Workspace, *along: str) -> Rows:
    """Return -δR of what is free, then -δs, at the solution, a column for each direction."""
    n, graph, free = w.state.n, w.graph, w.prescribed.free
    rows, c = _held(w, True)
    pushes = direction(graph, MULTIPLIERS, len(rows))  # c λ
    exerted = [dot(parts, pushes) for parts in zip(*(row.entries for row in rows), strict=True)]
    kept = [held * (dot(row.entries, w.state.qdd) + row.bias) for row, held in zip(rows, c, strict=True)]
    moving = [name for name in along if name != DRIVES]
    by_tree = recursive_derivatives.inverse_derivatives(w, moving) if moving else []
    found: Rows = []
    for at, seed in enumerate(FREE.seeds(w, "", moving)):
        moved = tangents([*(exerted[i] for i in free), *kept], seed)
        pulled = [moved[k] - by_tree[len(moving) * n * i + at] for k, i in enumerate(free)]
        found.append([*pulled, *(-x for x in moved[len(free) :])])
    solution = w.once(_by_factors)
    pushed = [held * x for held, x in zip(c, solution[n:], strict=True)]
    known = dict(zip((*w.state.qdd, *pushes), (*solution[:n], *pushed), strict=True))
    flat = iter(substitute(list(chain(*found)), known))
    found = [[next(flat) for _ in column] for column in found]
    if DRIVES in along:  # the last one
        found += [[graph.one if i == k else graph.zero for i in free] + [graph.zero] * len(rows) for k in range(n)]
    return columns(found)


# The table

HELD_DYNAMICS, LEAST = "held_dynamics", "held_dynamics_proximal"


def _ways(derive: Callable[[Workspace], list[Expr]], least: bool) -> dict[str, Formulation]:
    return {"crba": Formulation(derive), "lagrange": by_lagrange(partial(_unfactored, least=least))}


_TEXT = "accelerations, and forces of contacts that mask holds both ways, normal and where they can slip"
_ROW = partial(
    Output,
    result="qdd",
    axes=(lambda w: (*w.scene.velocities, *_names(w)),),
    units="of accelerations; N or N m",
    when_constrained="refuse",
    may_fail="reported",
    default_in="request",
    exists=touches,
)

HELD: Mapping[str, Output] = {
    HELD_DYNAMICS: _ROW(
        f"{_TEXT}; contacts that hold the same have no such forces",
        ("q", "qd", "tau", MASK),
        formulations=_ways(_by_factors, least=False),
        size=Size((0, 36), 1.0),
    ),
    LEAST: _ROW(
        f"{_TEXT}, forces of least size where contacts hold the same, by {STEPS} steps of the proximal point method",
        ("q", "qd", "tau", MASK, PROXIMAL),
        formulations=_ways(_least_by_factors, least=True),
        size=Size((0, 40), 1.0),
    ),
}
