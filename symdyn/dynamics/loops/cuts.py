"""Where a tree is cut: joints that close loops, and contacts that forbid velocities only.

    J     joint frame on the parent; the ground frame for a contact
    X     placement of the frame at P, on the child, in J
    a     axis of a wheel, or direction across a blade, axes of J
    n     normal of the ground       w    |a × n|, the sine of the angle between them
    d     from the centre O of a wheel to the lowest point of its rim

A wrench (force, moment) acts at P, axes of J. A contact's wrenches are the forces at the lowest point of the rim, moved
to O; its residual is zero, since it says nothing about places.

Reference: Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972), chapter 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics.state import placement, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import GROUND, JOINTS, Joint, Row, Scene, express
from symdyn.scene.joints.blocks import unit
from symdyn.scene.joints.constraints import forces
from symdyn.spatial import Transform, Vec, apply, cross, dot, identity, scale, sub, unit_transform

Wrench = tuple[Vec, Vec]


@dataclass(frozen=True)
class Cut:
    """One cut.

    Attributes:
        owner: name of the loop or of the row.
        parent, child: bodies.
        before: placement of J in the parent.
        behind: placement of the frame at P in the child.
        wrenches, residual: as functions of X.
        closes: whether it is a joint, so that its residual means something.
    """

    owner: str
    parent: str
    before: Transform
    child: str
    behind: Transform
    wrenches: Callable[[Transform], tuple[Wrench, ...]]
    residual: Callable[[Transform], tuple[Expr, ...]]
    closes: bool


def cuts(scene: Scene, graph: Graph) -> list[Cut]:
    """Return the cut joints of a scene, and its contacts."""
    contacts = [_contact(row, graph) for row in scene.rows if row.type != "formula"]
    return [_joint(joint, graph) for joint in scene.loops] + contacts


def _joint(joint: Joint, graph: Graph) -> Cut:
    kind = JOINTS[joint.type]
    return Cut(
        joint.name,
        joint.parent,
        placement(joint.origin, graph),
        joint.child,
        placement(joint.tip, graph).inverse(),
        lambda X: kind.wrenches(joint, X),
        lambda X: kind.residual(joint, X),
        True,
    )


def _contact(row: Row, graph: Graph) -> Cut:
    assert row.place is not None, "a contact is at a place"
    wrenches = _blade if row.type == "knife_edge" else _rolling
    behind = Transform(identity(graph), vector(row.place.at, graph))
    count = 1 if row.type == "knife_edge" else len(row.components)
    return Cut(
        row.name,
        GROUND,
        unit_transform(graph),
        row.place.body,
        behind,
        lambda X: wrenches(row, X),
        lambda X: (graph.zero,) * count,
        False,
    )


def _blade(row: Row, X: Transform) -> tuple[Wrench, ...]:
    return forces(apply(X.R, unit(row.axis, X.p[0].graph)))


def _rolling(row: Row, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    a, n, r = apply(X.R, unit(row.axis, graph)), unit(row.normal, graph), express(row.radius, graph)
    w = _sine(a, n)
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    ways = {
        "along": (scale(1 / w, cross(a, n)), scale(-r, a)),
        "across": _at_rim(scale(1 / w, cross(n, cross(a, n))), d),
        "normal": _at_rim(n, d),
    }
    return tuple(ways[component] for component in row.components)


def _at_rim(force: Vec, d: Vec) -> Wrench:
    return force, cross(d, force)


def _sine(a: Vec, n: Vec) -> Expr:
    """Return |a × n|; 1 where the wheel stands upright whatever it does, which the ring decides exactly."""
    graph, across = a[0].graph, cross(a, n)
    square = dot(across, across)
    try:
        ring = TrigonometricRing([square])
        (value,) = evaluate([square], ring, ring.values([square]))
    except DerivationError:  # a motion that is no trigonometric polynomial
        return graph.sqrt(square)
    return graph.one if ring.is_zero(value - 1) else graph.sqrt(square)
