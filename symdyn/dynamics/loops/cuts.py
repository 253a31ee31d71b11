"""Where a tree is cut: joints that close loops, and contacts of blades, wheels and balls with a plane.

    J     joint frame on the parent; for a contact it stands in a point of the plane, axes of the body that carries it
    X     placement of the frame at P, on the child, in J; P is the blade's point, or the centre O of a wheel
    a     axis of a wheel, or direction across a blade, axes of J
    n     normal of the plane        w    |a × n|, the sine of the angle between them
    d     from O to the point of the rim that is lowest; -r n for a ball

A wrench (force, moment) acts at P, axes of J. A contact's wrenches are the forces at the lowest point, moved to O. The
one along n has a residual, the height of that point, n·p - r w, whose rate it is; the others say nothing about places.

Reference: Neimark and Fufaev, Dynamics of Nonholonomic Systems (1972), chapter 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from symdyn.algebra.trigonometric import TrigonometricRing
from symdyn.dynamics.state import placement, vector
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Graph, evaluate
from symdyn.scene import JOINTS, Joint, Row, Scene, express
from symdyn.scene.joints.blocks import unit
from symdyn.scene.joints.constraints import forces
from symdyn.spatial import Transform, Vec, apply, cross, dot, identity, scale, sub

Wrench = tuple[Vec, Vec]


@dataclass(frozen=True)
class Cut:
    """One cut.

    Attributes:
        owner: name of the loop or of the row.
        parent, child: bodies; what carries the plane is the parent of a contact.
        before: placement of J in the parent.
        behind: placement of the frame at P in the child.
        wrenches: what the parent can exert on the child without working, as functions of X.
        residual: likewise what vanishes where the row is kept; zero for a row that does not close.
        closes: for each wrench whether it holds a position, so that its residual means something.
        joint: the joint that closes the loop; None for a contact.
        names: of a contact's wrenches, in words; "" where a direction says it.
    """

    owner: str
    parent: str
    before: Transform
    child: str
    behind: Transform
    wrenches: Callable[[Transform], tuple[Wrench, ...]]
    residual: Callable[[Transform], tuple[Expr, ...]]
    closes: tuple[bool, ...]
    joint: Joint | None
    names: tuple[str, ...] = ()


def cuts(scene: Scene, graph: Graph) -> list[Cut]:
    """Return the cut joints of a scene, and its contacts."""
    contacts = [contact(row, graph) for row in scene.rows if row.type != "formula"]
    return [_joint(joint, graph) for joint in scene.loops] + contacts


def _joint(joint: Joint, graph: Graph) -> Cut:
    kind = JOINTS[joint.type]
    wrenches, residual = kind.wrenches, kind.residual
    assert wrenches, "the scene's check refuses loops of joints whose wrenches have no formula"
    assert residual, "what has wrenches has a residual"
    return Cut(
        joint.name,
        joint.parent,
        placement(joint.origin, graph),
        joint.child,
        placement(joint.tip, graph).inverse(),
        lambda X: wrenches(joint, X),
        lambda X: residual(joint, X),
        (True,) * kind.class_t(joint),
        joint,
    )


def contact(row: Row, graph: Graph) -> Cut:
    """Return the cut that a blade, a wheel or a ball makes."""
    assert row.place is not None, "a contact is at a place"
    rolls = row.type == "rolling"
    closes = tuple(one == "normal" for one in row.components) if rolls else (False,)
    return Cut(
        row.name,
        row.plane.body,
        Transform(identity(graph), vector(row.plane.at, graph)),
        row.place.body,
        Transform(identity(graph), vector(row.place.at, graph)),
        lambda X: (_rolling if rolls else _blade)(row, X),
        lambda X: tuple(height(row, X) if one else graph.zero for one in closes),
        closes,
        None,
        _names(row),
    )


def _names(row: Row) -> tuple[str, ...]:
    if row.type == "knife_edge":
        return ("force across the blade",)
    track = {way: "" if row.axis is None else f"force {way} the track" for way in ("along", "across")}
    return tuple((track | {"normal": "normal force"})[component] for component in row.components)


def _blade(row: Row, X: Transform) -> tuple[Wrench, ...]:
    assert row.axis is not None, "a blade has a direction across it"
    return forces(apply(X.R, unit(row.axis, X.p[0].graph)))


def _rolling(row: Row, X: Transform) -> tuple[Wrench, ...]:
    graph = X.p[0].graph
    n, r = unit(row.plane.normal, graph), express(row.radius, graph)
    if row.axis is None:
        along, d = in_plane(n), scale(-r, n)
        ways = {"along": _at_rim(along, d), "across": _at_rim(cross(n, along), d), "normal": forces(n)[0]}
        return tuple(ways[component] for component in row.components)
    a = apply(X.R, unit(row.axis, graph))
    w = _sine(a, n)
    if w.is_zero:
        raise DerivationError(
            f"rows.{row.name}: {row.place.body if row.place else ''} lies flat on its plane wherever the joints stand, "
            "its axis along the normal, so that no point of its rim is the lowest; turn the axis of the wheel"
        )
    d = scale(-r / w, sub(n, scale(dot(n, a), a)))
    ways = {
        "along": (scale(1 / w, cross(a, n)), scale(-r, a)),
        "across": _at_rim(scale(1 / w, cross(n, cross(a, n))), d),
        "normal": _at_rim(n, d),
    }
    return tuple(ways[component] for component in row.components)


def height(row: Row, X: Transform) -> Expr:
    """Return how far the lowest point of a wheel or a ball, or the point of a blade, is off its plane, m."""
    graph = X.p[0].graph
    n = unit(row.plane.normal, graph)
    rise = dot(n, X.p)
    return rise - express(row.radius, graph) * sine(row, X) if row.type == "rolling" else rise


def sine(row: Row, X: Transform) -> Expr:
    """Return w of a wheel; 1 for a ball."""
    graph = X.p[0].graph
    if row.axis is None:
        return graph.one
    return _sine(apply(X.R, unit(row.axis, graph)), unit(row.plane.normal, graph))


def in_plane(n: Vec) -> Vec:
    """Return a unit vector of a plane: its x, unless the normal is along it."""
    graph = n[0].graph
    x, y = (graph.one, graph.zero, graph.zero), (graph.zero, graph.one, graph.zero)
    axis = y if n[1].is_zero and n[2].is_zero else x
    way = sub(axis, scale(dot(axis, n), n))
    return scale(graph.one / graph.sqrt(dot(way, way)), way)


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
