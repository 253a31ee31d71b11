"""Forces of contacts and accelerations, for all modes at once.

    W            all n and t, contact by contact, of which friction acts along the t       D = W M⁻¹ Wᵀ    Delassus
    u̇            a + M⁻¹ Wᵀ λ,  a without contacts         W u̇ + γ     accelerations of gaps and slips

A mode is numbers, which say which rows of D λ + W a + γ are zero:

    open   c = 0            λn = 0                λt = 0
    stick  c = 1, b = 1     n u̇ + γn = 0          t u̇ + γt = 0
    slip   c = 1, b = 0     n u̇ + γn = 0          λt = -μ λn s/|s|;  0 where nothing rubs

So one set of formulas holds for all modes: what is not closed has the row λ = 0 in place of its own.

Four corners of a box hold more than there is to hold: D is singular, accelerations are unique, forces are not. Runs
take those of least size: E makes D regular, and what E changes in the rows is taken back by steps, so that they
hold to rounding. Along the plane each contact takes as much as its normal force lets it, by `yields`. E is the same for
all contacts, else forces would be least in another measure.

    (D + E) λ = b,      λ + (D + E)⁻¹ (b - D λ),      E = ε d diag(1, yields),      d = Σ D_kk of what is closed

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from itertools import islice

from symdyn.dynamics.loops.partition import solve_square
from symdyn.dynamics.outputs.contact_rows import Row, Touch, touching
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.frozen import dataclass
from symdyn.graph import Expr, tangents
from symdyn.unlocked import cached_property

Rows = list[list[Expr]]

SOFT, STEPS = Fraction(1, 10**7), 5
"""ε, large beside rounding and small beside what rows that differ leave, as those of feet that are close to each other;
and the steps, those behind the first taking it back."""


@dataclass(frozen=True)
class ContactEquations:
    """Contacts of a scene, their forces and the accelerations in every mode."""

    touches: tuple[Touch, ...]  # the contacts, in order
    rows: tuple[Row, ...]  # W and γ, m of them: of each its n, and each t where there is friction
    free: tuple[Expr, ...]  # a, shape (nv,)
    columns: tuple[tuple[Expr, ...], ...]  # M⁻¹ Wᵀ by row of W, shape (m, nv)
    velocities: tuple[Expr, ...]  # u, shape (nv,)
    shared: bool = False  # whether several may hold the same, so that forces are those of least size

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
        graph = self.free[0].graph
        one, at, soft = graph.one, 0, list[Expr]()
        diagonal = self.parts([row[k] for k, row in enumerate(A)])
        size = SOFT * graph.total(
            touch.mode[0] * next(iter(along), graph.zero) if first is None else touch.mode[0] * first
            for touch, (first, along) in zip(self.touches, diagonal, strict=True)
        )
        for touch in self.touches:
            closed, sticks, _, yields = touch.mode
            normal = at if touch.normal else None
            if touch.normal:
                soft.append(closed * size)
                _hold(A, b, at, closed)
                at += 1
            for direction in touch.directions[: len(touch.tangents)]:
                held = closed * sticks
                soft.append(held * yields * size)
                _hold(A, b, at, held)
                limit = (one - held) * direction * touch.friction
                if normal is None:
                    b[at] = b[at] - limit
                else:
                    A[at][normal] = A[at][normal] + limit
                at += 1
        return _least(A, b, soft) if self.shared else solve_square(A, b)

    @cached_property
    def generalized(self) -> list[Expr]:
        """Wᵀ λ, shape (nv,), N m or N."""
        return [dot(parts, self.forces) for parts in zip(*(row.entries for row in self.rows), strict=True)]

    @cached_property
    def accelerations(self) -> list[Expr]:
        """u̇ in the mode, shape (nv,)."""
        by_velocity = zip(self.free, *self.columns, strict=True)
        return [a + dot(parts, self.forces) for a, *parts in by_velocity]

    def distance(self, touch: Touch) -> Expr:
        """Return what is never below zero: the gap, of a law of rates ġ."""
        return dot(touch.normal.entries, self.velocities) if touch.normal and touch.law.at_rates else touch.gap

    def slips(self, touch: Touch) -> list[Expr]:
        """Return the velocities with which one slips, of each of its tangents."""
        return [dot(row.entries, self.velocities) for row in touch.tangents]

    def parts(self, of_rows: Sequence[Expr]) -> list[tuple[Expr | None, tuple[Expr, ...]]]:
        """Return what rows have, contact by contact: of n, None where there is none, and of each t."""
        rest = iter(of_rows)
        return [(next(rest) if one.normal else None, tuple(islice(rest, len(one.tangents)))) for one in self.touches]


def _hold(A: list[list[Expr]], b: list[Expr], row: int, held: Expr) -> None:
    """Keep a row where it is held, and have λ = 0 in place of it elsewhere."""
    A[row] = [held * entry for entry in A[row]]
    A[row][row] = A[row][row] + (held.graph.one - held)
    b[row] = held * b[row]


def _least(A: Rows, b: Sequence[Expr], soft: Sequence[Expr]) -> list[Expr]:
    """Return the x of least size, shape (m,), with A x = b to rounding, A singular or not."""
    regular = [[x + soft[i] if i == j else x for j, x in enumerate(row)] for i, row in enumerate(A)]
    return proximal(A, b, partial(eliminated, regular))


def proximal(A: Rows, b: Sequence[Expr], softly: Callable[[Sequence[Expr]], list[Expr]]) -> list[Expr]:
    """Return x with A x = b, shape (m,); `softly` solves with more on the diagonal of A."""
    x = softly(b)
    for _ in range(STEPS - 1):
        missed = [one - dot(row, x) for row, one in zip(A, b, strict=True)]
        x = [one + more for one, more in zip(x, softly(missed), strict=True)]
    return x


def eliminated(A: Sequence[Sequence[Expr]], b: Sequence[Expr]) -> list[Expr]:
    """Return A⁻¹ b by elimination in the order of rows, shape (m,)."""
    rows = [[*row, one] for row, one in zip(A, b, strict=True)]
    for k, pivot in enumerate(rows):
        for row in rows[k + 1 :]:
            if not row[k].is_zero:
                factor = row[k] / pivot[k]
                row[k + 1 :] = [x - factor * y for x, y in zip(row[k + 1 :], pivot[k + 1 :], strict=True)]
    found = list[Expr]()
    for k in reversed(range(len(rows))):
        rest = rows[k][-1] - dot(rows[k][k + 1 : -1], found) if found else rows[k][-1]
        found.insert(0, rest / rows[k][k])
    return found


def contact_equations(
    w: Workspace, accelerations: Sequence[Expr], by_recursion: bool = True, shared: bool = False
) -> ContactEquations:
    """Return the equations of all that opens, closes and sticks; `accelerations` are a, of forward dynamics.

    Where forces may be `shared`, and several contacts, or two directions, may hold the same, they are of least size.

    Raises:
        DerivationError: loops or rows close the scene.
    """
    touches = touching(w, by_recursion)
    rows = [row for one in touches for row in one.rows]
    columns = tuple(tuple(columns_of(w, accelerations, row)) for row in rows)
    several = sum(one.normal is not None for one in touches) > 1 or any(len(one.tangents) > 1 for one in touches)
    return ContactEquations(touches, tuple(rows), tuple(accelerations), columns, w.state.qd, shared and several)


def columns_of(w: Workspace, accelerations: Sequence[Expr], row: Row) -> list[Expr]:
    """Return M⁻¹ wᵀ of a row w, shape (nv,): what accelerations gain by a unit of its force."""
    return tangents(accelerations, dict(zip(w.state.tau, row.entries, strict=True)))


def dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """Return Σ a_k b_k."""
    return b[0].graph.dot(a, b)
