"""Forces of contacts and accelerations, for all modes at once.

    W            all n and t, contact by contact, of which friction acts along the t       D = W M⁻¹ Wᵀ    Delassus
    u̇            a + M⁻¹ Wᵀ λ,  a without contacts         W u̇ + γ     accelerations of gaps and slips

A mode is three numbers, which say which rows of D λ + W a + γ are zero:

    open   c = 0            λn = 0                λt = 0
    stick  c = 1, b = 1     n u̇ + γn = 0          t u̇ + γt = 0
    slip   c = 1, b = 0     n u̇ + γn = 0          λt = -z μ λn,  z the sign of s; 0 where nothing rubs

So one set of formulas holds for all modes: what is not closed has the row λ = 0 in place of its own.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symdyn.dynamics.loops.partition import solve_square
from symdyn.dynamics.outputs.contact_rows import Row, Touch, touching
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, tangents
from symdyn.unlocked import cached_property


@dataclass(frozen=True)
class ContactEquations:
    """Contacts of a scene, their forces and the accelerations in every mode.

    Attributes:
        touches: the contacts, in order.
        rows: W and γ, m of them: of each its n, and its t where there is friction.
        free: a, shape (nv,).
        columns: M⁻¹ Wᵀ by row of W, shape (m, nv).
        velocities: u, shape (nv,).
    """

    touches: tuple[Touch, ...]
    rows: tuple[Row, ...]
    free: tuple[Expr, ...]
    columns: tuple[tuple[Expr, ...], ...]
    velocities: tuple[Expr, ...]

    @cached_property
    def delassus(self) -> list[list[Expr]]:
        """D, shape (m, m)."""
        return [[dot(row.entries, column) for column in self.columns] for row in self.rows]

    @cached_property
    def drift(self) -> list[Expr]:
        """W a + γ, shape (m,)."""
        return [dot(row.entries, self.free) + row.bias for row in self.rows]

    @cached_property
    def forces(self) -> list[Expr]:
        """λ in the mode, shape (m,), N."""
        A, b = [list(row) for row in self.delassus], [-one for one in self.drift]
        one, at = self.free[0].graph.one, 0
        for touch in self.touches:
            closed, sticks, slip = touch.mode
            normal = at if touch.normal else None
            if touch.normal:
                _hold(A, b, at, closed)
                at += 1
            if touch.tangent:
                _hold(A, b, at, closed * sticks)
                limit = (one - closed * sticks) * slip * touch.friction
                if normal is None:
                    b[at] = b[at] - limit
                else:
                    A[at][normal] = A[at][normal] + limit
                at += 1
        return solve_square(A, b)

    @cached_property
    def generalized(self) -> list[Expr]:
        """Wᵀ λ, shape (nv,), N m or N."""
        return [dot(parts, self.forces) for parts in zip(*(row.entries for row in self.rows), strict=True)]

    @cached_property
    def accelerations(self) -> list[Expr]:
        """u̇ in the mode, shape (nv,)."""
        by_velocity = zip(self.free, *self.columns, strict=True)
        return [a + dot(parts, self.forces) for a, *parts in by_velocity]

    def parts(self, of_rows: Sequence[Expr]) -> list[tuple[Expr | None, Expr | None]]:
        """Return what rows have, contact by contact: of n and of t, None where there is none."""
        rest = iter(of_rows)
        return [(next(rest) if one.normal else None, next(rest) if one.tangent else None) for one in self.touches]


def _hold(A: list[list[Expr]], b: list[Expr], row: int, held: Expr) -> None:
    """Keep a row where it is held, and have λ = 0 in place of it elsewhere."""
    A[row] = [held * entry for entry in A[row]]
    A[row][row] = A[row][row] + (held.graph.one - held)
    b[row] = held * b[row]


def contact_equations(w: Workspace, accelerations: Sequence[Expr], by_recursion: bool = True) -> ContactEquations:
    """Return the equations of all that opens, closes and sticks; `accelerations` are a, of forward dynamics.

    Raises:
        DerivationError: loops or rows close the scene, or friction acts along two directions.
    """
    if w.scene.is_constrained:
        raise DerivationError(f"{w.scene.name}: contacts that open and close beside loops or constraints are not known")
    touches = touching(w, by_recursion)
    for one in touches:
        if one.tangent is not None and len(one.slips) > 1:
            raise DerivationError(
                f"{w.scene.name}: contacts.{one.law.name}: it can slip along two directions, and friction is known "
                "along one; leave friction out, or let joints keep it in a plane"
            )
    rows = [row for one in touches for row in one.rows]
    columns = tuple(tuple(columns_of(w, accelerations, row)) for row in rows)
    return ContactEquations(touches, tuple(rows), tuple(accelerations), columns, w.state.qd)


def columns_of(w: Workspace, accelerations: Sequence[Expr], row: Row) -> list[Expr]:
    """Return M⁻¹ wᵀ of a row w, shape (nv,): what accelerations gain by a unit of its force."""
    return tangents(accelerations, dict(zip(w.state.tau, row.entries, strict=True)))


def dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """Return Σ a_k b_k."""
    return b[0].graph.total(x * y for x, y in zip(a, b, strict=True))
