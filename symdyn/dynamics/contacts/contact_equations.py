"""Equations of contacts that open and close, for all their modes at once.

    g, n, t      gap, and the Jacobians of its rate ġ = n u and of the slip s = t u; γ their rates at u̇ = 0
    W            all n and t, contact by contact          D = W M⁻¹ Wᵀ       Delassus' matrix
    u̇            a + M⁻¹ Wᵀ λ,  a without contacts        W u̇ + γ           accelerations of gaps and slips

A mode is three numbers, which say which rows of D λ + W a + γ are zero:

    open   c = 0            λn = 0                λt = 0
    stick  c = 1, b = 1     n u̇ + γn = 0          t u̇ + γt = 0
    slip   c = 1, b = 0     n u̇ + γn = 0          λt = -z μ λn,  z the sign of s; 0 where it is held by nothing

So one set of formulas holds for all modes: what is not closed has the row λ = 0 in place of its own.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from symdyn.dynamics.loops.constraint_rows import Constraints, recursive
from symdyn.dynamics.loops.partition import solve_square
from symdyn.dynamics.outputs.derive import derive_one
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.errors import DerivationError
from symdyn.graph import Expr, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.values import StateVariable, Unilateral
from symdyn.unlocked import cached_property

MODE = ("closed", "sticks", "slip")
"""The numbers of a mode: c, b and z of the legend."""


def with_modes(scene: Scene) -> Scene:
    """Return a scene with the modes of its contacts as states, which nothing changes but events."""
    names = [f"{one.name}.{word}" for one in scene.unilaterals for word in MODE]
    return replace(scene, states=(*scene.states, *(StateVariable(name, Quantity.ZERO) for name in names)))


@dataclass(frozen=True)
class Touch:
    """A contact on a graph.

    Attributes:
        contact: as declared.
        gap: g, m.
        normal, normal_bias: n, shape (nv,), and γn.
        tangent, tangent_bias: t, shape (nv,), and γt; () of a contact without friction.
        friction, static, restitution: μ while it slips and while it sticks, and e.
        mode: c, b and z.
    """

    contact: Unilateral
    gap: Expr
    normal: tuple[Expr, ...]
    normal_bias: Expr
    tangent: tuple[Expr, ...]
    tangent_bias: Expr
    friction: Expr
    static: Expr
    restitution: Expr
    mode: tuple[Expr, Expr, Expr]


@dataclass(frozen=True)
class ContactEquations:
    """Contacts of a scene, their forces and the accelerations in every mode.

    Attributes:
        touches: the contacts, in order.
        rows: W, shape (m, nv): of each its n, and its t where there is friction.
        biases: γ, shape (m,).
        free: a, shape (nv,).
        columns: M⁻¹ Wᵀ by row of W, shape (m, nv).
        velocities: u, shape (nv,).
    """

    touches: tuple[Touch, ...]
    rows: tuple[tuple[Expr, ...], ...]
    biases: tuple[Expr, ...]
    free: tuple[Expr, ...]
    columns: tuple[tuple[Expr, ...], ...]
    velocities: tuple[Expr, ...]

    @cached_property
    def delassus(self) -> list[list[Expr]]:
        """D, shape (m, m)."""
        return [[_dot(row, column) for column in self.columns] for row in self.rows]

    @cached_property
    def drift(self) -> list[Expr]:
        """W a + γ, shape (m,)."""
        return [_dot(row, self.free) + bias for row, bias in zip(self.rows, self.biases, strict=True)]

    @cached_property
    def forces(self) -> list[Expr]:
        """λ in the mode, shape (m,), N."""
        A, b = [list(row) for row in self.delassus], [-one for one in self.drift]
        one, at = self.free[0].graph.one, 0
        for touch in self.touches:
            closed, sticks, slip = touch.mode
            held = closed
            for k in range(at, at + 1 + bool(touch.tangent)):
                A[k] = [held * entry for entry in A[k]]
                A[k][k] = A[k][k] + (one - held)
                b[k] = held * b[k]
                if k > at:
                    A[k][at] = A[k][at] + (one - held) * slip * touch.friction
                held = closed * sticks
            at += 1 + bool(touch.tangent)
        return solve_square(A, b)

    @cached_property
    def accelerations(self) -> list[Expr]:
        """u̇ in the mode, shape (nv,)."""
        by_velocity = zip(self.free, *self.columns, strict=True)
        return [a + _dot(parts, self.forces) for a, *parts in by_velocity]

    def parts(self, of_rows: Sequence[Expr]) -> list[tuple[Expr, Expr | None]]:
        """Return what rows have, contact by contact: of n, and of t where there is friction."""
        found, rest = list[tuple[Expr, Expr | None]](), iter(of_rows)
        for touch in self.touches:
            found.append((next(rest), next(rest) if touch.tangent else None))
        return found


def contact_equations(w: Workspace, accelerations: Sequence[Expr] | None = None) -> ContactEquations:
    """Return the equations of the contacts of a scene; `accelerations` are a in place of forward dynamics.

    Raises:
        DerivationError: loops or rows close the scene, or friction acts along two directions.
    """
    if w.scene.is_constrained:
        raise DerivationError(f"{w.scene.name}: contacts that open and close beside loops or constraints are not known")
    touches = touching(w, recursive)
    free = tuple(derive_one(w, "forward_dynamics").entries if accelerations is None else accelerations)
    rows, biases = list[tuple[Expr, ...]](), list[Expr]()
    for one in touches:
        rows.append(one.normal)
        biases.append(one.normal_bias)
        if one.tangent:
            rows.append(one.tangent)
            biases.append(one.tangent_bias)
    columns = tuple(tuple(tangents(free, dict(zip(w.state.tau, row, strict=True)))) for row in rows)
    return ContactEquations(touches, tuple(rows), tuple(biases), free, columns, w.state.qd)


def touching(w: Workspace, rows_of: Callable[..., Constraints]) -> tuple[Touch, ...]:
    """Return the contacts of a scene, their rows by recursion or by differentiation."""
    graph, scene = w.graph, w.scene
    held = replace(scene, loops=(), elements=tuple(one.closed for one in scene.unilaterals))
    found = rows_of(held, w.tree, w.state) if rows_of is recursive else rows_of(held, graph, w.state)
    by_owner: dict[str, list[tuple[Expr, tuple[Expr, ...], Expr]]] = {}
    for label, *row in zip(found.labels, found.residual, found.G, found.bias, strict=True):
        by_owner.setdefault(label.owner, []).append((row[0], row[1], row[2]))
    touches = []
    for one in scene.unilaterals:
        (gap, normal, bias), *others = by_owner[one.name]
        mode = tuple(graph.symbol(f"{one.name}.{word}") for word in MODE)
        moving = [(t, rate) for _, t, rate in others if not all(entry.is_zero for entry in t)]
        mu = one.friction.express(graph)
        static = mu if one.static is None else one.static.express(graph)
        rough = not (mu.is_zero and static.is_zero)
        if rough and len(moving) > 1:
            raise DerivationError(
                f"{scene.name}: contacts.{one.name}: it can slip along two directions, and friction is known along "
                "one; leave friction out, or let joints keep it in a plane"
            )
        tangent, tangent_bias = moving[0] if rough and moving else ((), graph.zero)
        e = one.restitution.express(graph)
        touches.append(Touch(one, gap, normal, bias, tangent, tangent_bias, mu, static, e, mode))  # type: ignore[arg-type]
    return tuple(touches)


def _dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    return b[0].graph.total(x * y for x, y in zip(a, b, strict=True))
