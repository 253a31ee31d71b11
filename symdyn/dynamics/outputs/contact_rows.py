"""What opens, closes, sticks and slips in a scene: contacts with planes, contacts by formulas, stops, dry friction.

    g    gap, m or rad              ġ = n u,  n its Jacobian
    s    slips, m/s                 s = t u,  one direction or two
    γ    the rates of n u and t u at u̇ = 0

Everything is a row of `Touch`, whatever it was made from. Rows of planes are those of contacts that roll, by recursion
or by differentiation.

Reference: Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from symdyn.dynamics.loops.constraint_rows import Constraints, differentiated, recursive
from symdyn.dynamics.outputs.workspace import Workspace
from symdyn.frozen import dataclass, replace
from symdyn.graph import Expr, Op, gradient, substitute, tangents
from symdyn.scene import Quantity, Scene
from symdyn.scene.forces import FORCES
from symdyn.scene.joints import JOINTS
from symdyn.scene.values import DryJoint, GapContact, Joint, OneWay, StateVariable, Stop, Unilateral

MODE = ("closed", "sticks", "slip", "yields")
"""The numbers of a mode: whether it is closed, whether it sticks, the sign of its slip, or 1 where it may slip any way,
and how much it leaves to others that stick with it. What touches while others carry all is not closed, and sticks."""

CLOSED_AT_ONCE = 8
"""Contacts with gaps that are closed at once, at most, in runs and in generated C."""


def unilaterals_of(scene: Scene) -> tuple[Unilateral, ...]:
    """Return all that opens, closes and sticks: what is declared, limits with a restitution, friction not smoothed."""
    found = list(scene.unilaterals)
    for joint in scene.joints:
        e = joint.limits.restitution
        for word, limit in (("lower", joint.limits.lower), ("upper", joint.limits.upper)):
            if e is not None and limit is not None:
                stop = Stop(f"{joint.name}_{word}", restitution=e, joint=joint.name, upper=word == "upper", at=limit)
                found.append(stop)
        if sticks(joint):
            found.append(DryJoint(f"{joint.name}_friction", joint=joint.name, dry=joint.dry))
        if joint.limits.one_way:
            found.append(OneWay(f"{joint.name}_one_way", joint=joint.name))
    return tuple(found)


def with_modes(scene: Scene) -> Scene:
    """Return a scene with all of these as elements, and their modes as states, which nothing but events changes."""
    whole = unilaterals_of(scene)
    joints = []
    for joint in scene.joints:
        struck = joint.limits.restitution is not None
        limits = replace(joint.limits, lower=None, upper=None, restitution=None) if struck else joint.limits
        limits = replace(limits, one_way=False)
        joints.append(replace(joint, limits=limits, dry=None if sticks(joint) else joint.dry))
    others = tuple(one for one in scene.elements if not isinstance(one, Unilateral))
    modes = tuple(StateVariable(f"{one.name}.{word}", Quantity.ZERO) for one in whole for word in MODE)
    return replace(scene, joints=tuple(joints), elements=(*others, *whole), states=(*scene.states, *modes))


def sticks(joint: Joint) -> bool:
    """Tell whether a joint has dry friction that is not smoothed."""
    return joint.dry is not None and len(joint.rates) == 1 and FORCES[joint.dry.kind].rub.jumps(joint.dry)


def lacks_modes(scene: Scene) -> bool:
    """Tell whether something opens, closes or sticks whose modes are no states of a scene."""
    known = {one.name for one in scene.states}
    return any(f"{one.name}.{MODE[0]}" not in known for one in unilaterals_of(scene))


class Row(NamedTuple):
    """A row that is linear in velocities: its entries, shape (nv,), and their rate times u."""

    entries: tuple[Expr, ...]
    bias: Expr


@dataclass(frozen=True)
class Touch:
    """One of them on a graph.

    Attributes:
        law: as declared, or made.
        gap: g, m or rad; zero of a law of rates.
        normal: n; None of dry friction of a joint, which is closed always.
        slips: t of each direction along which it can slip.
        ways: which components of a plane's contact these are: 1 along, 2 across.
        friction, static, restitution: μ while it slips and while it sticks, and e; of dry friction of a joint the
            forces themselves, N or N m.
        mode: closed, sticks, slip, yields.
        directions: of the slip, one of each of `tangents`; the unit vector, zero where it sticks.
        unit: of the gap, "m" or "rad".
        active: where it is above zero what is open may strike; None for everywhere.
    """

    law: Unilateral
    gap: Expr
    normal: Row | None
    slips: tuple[Row, ...]
    friction: Expr
    static: Expr
    restitution: Expr
    mode: tuple[Expr, Expr, Expr, Expr]
    directions: tuple[Expr, ...]
    unit: str
    active: Expr | None
    ways: tuple[int, ...] = ()

    @property
    def tangents(self) -> tuple[Row, ...]:
        """The slips along which friction acts; none without."""
        return () if self.friction.is_zero and self.static.is_zero else self.slips

    @property
    def rows(self) -> tuple[Row, ...]:
        """The normal and the tangents, those that there are."""
        return (*(() if self.normal is None else (self.normal,)), *self.tangents)


def touching(w: Workspace, by_recursion: bool = True) -> tuple[Touch, ...]:
    """Return all of them, rows of planes by recursion, or by differentiation of placements."""
    scene = w.scene
    laws = unilaterals_of(scene)
    closed = tuple(one.closed for one in laws if one.closed is not None)
    held = replace(scene, loops=(), elements=closed)
    found: Constraints = recursive(held, w.tree, w.state) if by_recursion else differentiated(held, w.graph, w.state)
    by_owner: dict[str, list[tuple[Expr, Row]]] = {}
    for label, gap, entries, bias in zip(found.labels, found.residual, found.G, found.bias, strict=True):
        by_owner.setdefault(label.owner, []).append((gap, Row(entries, bias)))
    return tuple(_touch(w, one, by_owner.get(one.name, [])) for one in laws)


def _touch(w: Workspace, law: Unilateral, rows: Sequence[tuple[Expr, Row]]) -> Touch:
    graph = w.graph
    mu, e = law.friction.express(graph), law.restitution.express(graph)
    static = mu if law.static is None else law.static.express(graph)
    gap, normal, slips, unit, ways = graph.zero, None, list[Row](), "m", tuple[int, ...]()
    if law.closed is not None:
        (gap, normal), *_ = rows
        ways = tuple(k for k, (_, row) in enumerate(rows) if k and not all(entry.is_zero for entry in row.entries))
        slips = [rows[k][1] for k in ways]
    elif isinstance(law, GapContact):
        gap = law.gap.express(graph)
        slips = [] if law.tangent is None else [_row(w, law.tangent.express(graph))]
    elif isinstance(law, Stop):
        joint = _joint(w.scene, law.joint)
        gap, unit = joint.position(graph) - law.at.express(graph), "m" if JOINTS[joint.type].slides(joint) else "rad"
        gap = -gap if law.upper else gap
    elif isinstance(law, DryJoint):
        assert law.dry is not None, "it was made of a friction"
        (rate,) = _joint(w.scene, law.joint).speeds(graph)
        slips = [_row(w, rate)]
        force = FORCES[law.dry.kind].rub.force(law.dry, rate)
        (mu,) = substitute([force], {graph.function(Op.SIGN, rate): graph.one})
        (static,) = substitute([mu], {rate: graph.zero})
    elif isinstance(law, OneWay):
        joint = _joint(w.scene, law.joint)
        (rate,) = joint.speeds(graph)
        normal, unit = _row(w, rate), "m" if JOINTS[joint.type].slides(joint) else "rad"
    if isinstance(law, (GapContact, Stop)):
        normal = _row(w, tangents([gap], w.state.velocity)[0])
    closed, held, slip, yields = (graph.symbol(f"{law.name}.{word}") for word in MODE)
    speeds = [graph.dot(row.entries, w.state.qd) for row in slips]
    speed = graph.sqrt(graph.total(s * s for s in speeds) + Fraction(1, 10**24))  # never zero
    directions = tuple(slip * s / speed for s in speeds) if len(speeds) > 1 else (slip,) * len(speeds)
    active = None if law.active is None else law.active.express(graph)
    mode = (closed, held, slip, yields)
    return Touch(law, gap, normal, tuple(slips), mu, static, e, mode, directions, unit, active, ways)


def _joint(scene: Scene, name: str) -> Joint:
    return next(joint for joint in scene.joints if joint.name == name)


def _row(w: Workspace, rate: Expr) -> Row:
    """Return the row of a rate that is linear in velocities."""
    (bias,) = tangents([rate], w.state.velocity)
    return Row(tuple(gradient(rate, w.state.qd)), bias)
