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
from symdyn.graph import Expr, Op, gradient, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.values import DryJoint, GapContact, Joint, PlaneContact, StateVariable, Stop, Unilateral
from symdyn.unlocked import cached_property

MODE = ("closed", "sticks", "slip")
"""The numbers of a mode: c, b and z of the legend."""


def with_modes(scene: Scene) -> Scene:
    """Return a scene with all that opens, closes and sticks as elements, and their modes as states.

    Nothing changes the modes but events. Stops are limits with a restitution; friction of joints that is not smoothed
    sticks.
    """
    joints, elements = [], list(scene.elements)
    for joint in scene.joints:
        one, e = joint, joint.limits.restitution
        if e is not None:
            for upper, limit in ((False, joint.limits.lower), (True, joint.limits.upper)):
                if limit is not None:
                    name = f"{joint.name}.{'upper' if upper else 'lower'}"
                    elements.append(Stop(name, restitution=e, joint=joint.name, upper=upper, at=limit))
            one = replace(one, limits=replace(one.limits, lower=None, upper=None, restitution=None))
        if sticks(joint):
            elements.append(DryJoint(f"{joint.name}.friction", joint=joint.name, dry=joint.dry))
            one = replace(one, dry=None)
        joints.append(one)
    whole = replace(scene, joints=tuple(joints), elements=tuple(elements))
    names = [f"{one.name}.{word}" for one in whole.unilaterals for word in MODE]
    return replace(whole, states=(*scene.states, *(StateVariable(name, Quantity.ZERO) for name in names)))


def sticks(joint: Joint) -> bool:
    """Tell whether a joint has dry friction that is not smoothed."""
    return joint.dry is not None and len(joint.rates) == 1 and FORCES[joint.dry.kind].rub.jumps(joint.dry)


def has_modes(scene: Scene) -> bool:
    """Tell whether something in a scene opens, closes or sticks."""
    stops = any(joint.limits.restitution is not None for joint in scene.joints)
    return bool(scene.unilaterals) or stops or any(map(sticks, scene.joints))


@dataclass(frozen=True)
class Touch:
    """A contact on a graph.

    Attributes:
        contact: as declared, or made.
        gap: g, m or rad.
        normal, normal_bias: n, shape (nv,), and γn; () of dry friction of a joint, which is closed always.
        tangent, tangent_bias: t, shape (nv,), and γt; () of a contact without friction.
        friction, static, restitution: μ while it slips and while it sticks, and e; of dry friction of a joint the
            forces themselves, N or N m.
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

    @property
    def rows(self) -> list[tuple[tuple[Expr, ...], Expr]]:
        """n with γn and t with γt, those that there are."""
        both = ((self.normal, self.normal_bias), (self.tangent, self.tangent_bias))
        return [(row, bias) for row, bias in both if row]


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
        return [_dot(column, self.forces) for column in zip(*self.rows, strict=True)]

    @cached_property
    def accelerations(self) -> list[Expr]:
        """u̇ in the mode, shape (nv,)."""
        by_velocity = zip(self.free, *self.columns, strict=True)
        return [a + _dot(parts, self.forces) for a, *parts in by_velocity]

    def parts(self, of_rows: Sequence[Expr]) -> list[tuple[Expr | None, Expr | None]]:
        """Return what rows have, contact by contact: of n and of t, None where there is none."""
        rest = iter(of_rows)
        return [(next(rest) if one.normal else None, next(rest) if one.tangent else None) for one in self.touches]


def _hold(A: list[list[Expr]], b: list[Expr], row: int, held: Expr) -> None:
    """Keep a row where it is held, and have λ = 0 in place of it elsewhere."""
    A[row] = [held * entry for entry in A[row]]
    A[row][row] = A[row][row] + (held.graph.one - held)
    b[row] = held * b[row]


def contact_equations(w: Workspace, accelerations: Sequence[Expr] | None = None) -> ContactEquations:
    """Return the equations of the contacts of a scene; `accelerations` are a in place of forward dynamics.

    Raises:
        DerivationError: loops or rows close the scene, or friction acts along two directions.
    """
    if w.scene.is_constrained:
        raise DerivationError(f"{w.scene.name}: contacts that open and close beside loops or constraints are not known")
    touches = touching(w, recursive)
    free = tuple(derive_one(w, "forward_dynamics").entries if accelerations is None else accelerations)
    rows = [row for one in touches for row, _ in one.rows]
    biases = tuple(bias for one in touches for _, bias in one.rows)
    columns = tuple(tuple(tangents(free, dict(zip(w.state.tau, row, strict=True)))) for row in rows)
    return ContactEquations(touches, tuple(rows), biases, free, columns, w.state.qd)


Row = tuple[tuple[Expr, ...], Expr]


def touching(w: Workspace, rows_of: Callable[..., Constraints]) -> tuple[Touch, ...]:
    """Return what opens, closes and sticks in a scene; rows of contacts with planes by recursion or differentiation."""
    graph, scene = w.graph, w.scene
    planes = [one for one in scene.unilaterals if isinstance(one, PlaneContact)]
    held = replace(scene, loops=(), elements=tuple(one.closed for one in planes))
    found = rows_of(held, w.tree, w.state) if rows_of is recursive else rows_of(held, graph, w.state)
    by_owner: dict[str, list[tuple[Expr, tuple[Expr, ...], Expr]]] = {}
    for label, *row in zip(found.labels, found.residual, found.G, found.bias, strict=True):
        by_owner.setdefault(label.owner, []).append((row[0], row[1], row[2]))
    return tuple(_touch(w, one, by_owner.get(one.name, [])) for one in scene.unilaterals)


def _touch(w: Workspace, one: Unilateral, rows: Sequence[tuple[Expr, tuple[Expr, ...], Expr]]) -> Touch:
    graph = w.graph
    mu, e = one.friction.express(graph), one.restitution.express(graph)
    static = mu if one.static is None else one.static.express(graph)
    none: Row = ((), graph.zero)
    gap, normal, tangents_ = graph.zero, none, list[Row]()
    if isinstance(one, PlaneContact):
        (gap, *first), *others = rows
        normal = (first[0], first[1])
        tangents_ = [(t, bias) for _, t, bias in others if not all(entry.is_zero for entry in t)]
    elif isinstance(one, GapContact):
        gap = one.gap.express(graph)
        normal = _row(w, tangents([gap], w.state.velocity)[0])
        tangents_ = [] if one.tangent is None else [_row(w, one.tangent.express(graph))]
    elif isinstance(one, Stop):
        gap = _joint(w.scene, one.joint).position(graph) - one.at.express(graph)
        gap = -gap if one.upper else gap
        normal = _row(w, tangents([gap], w.state.velocity)[0])
    elif isinstance(one, DryJoint):
        assert one.dry is not None, "it was made of a friction"
        (rate,) = _joint(w.scene, one.joint).speeds(graph)
        tangents_ = [_row(w, rate)]
        force = FORCES[one.dry.kind].rub.force(one.dry, rate)
        (mu,) = substitute([force], {graph.function(Op.SIGN, rate): graph.one})
        (static,) = substitute([mu], {rate: graph.zero})
    rough = not (mu.is_zero and static.is_zero)
    if rough and len(tangents_) > 1:
        raise DerivationError(
            f"{w.scene.name}: contacts.{one.name}: it can slip along two directions, and friction is known along "
            "one; leave friction out, or let joints keep it in a plane"
        )
    tangent = tangents_[0] if rough and tangents_ else none
    closed, held, slip = (graph.symbol(f"{one.name}.{word}") for word in MODE)
    return Touch(one, gap, *normal, *tangent, mu, static, e, (closed, held, slip))


def _joint(scene: Scene, name: str) -> Joint:
    return next(joint for joint in scene.joints if joint.name == name)


def _row(w: Workspace, rate: Expr) -> Row:
    """Return the row of a rate that is linear in velocities, and its bias."""
    (bias,) = tangents([rate], w.state.velocity)
    return tuple(gradient(rate, w.state.qd)), bias


def _dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    return b[0].graph.total(x * y for x, y in zip(a, b, strict=True))
