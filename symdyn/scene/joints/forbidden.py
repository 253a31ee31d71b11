"""What joints forbid: wrenches that do no work, and residuals of placement.

    X        placement of the moved joint frame in the joint frame
    A        rotation that takes z to the joint's axis; its columns are directions in the joint frame
    R, p     rotation and translation of X

Wrenches (force, moment) act at the origin of the moved frame; axes of the joint frame.
"""

from __future__ import annotations

from symdyn.graph import Expr, Graph
from symdyn.scene.joints.blocks import unit
from symdyn.scene.joints.joint_kind import Forbids
from symdyn.scene.values.joint import Joint
from symdyn.scene.values.quantity import Vector
from symdyn.spatial import Mat, Transform, Vec, Wrench, add, cross, dot, scale, zero_vector


def forbidding(shifts: str, turns: str = "none") -> Forbids:
    """Return what a joint forbids that takes away shifts and turns: those "along" or "across" its axis, or "all".

    Turns are "all", those about directions "across" the axis, or "none". Forces and moments are along the same ones.
    """

    def wrenches(joint: Joint, X: Transform) -> tuple[Wrench, ...]:
        graph = X.p[0].graph
        return forces(*chosen(shifts, joint, graph)) + moments(*chosen(turns, joint, graph))

    def residual(joint: Joint, X: Transform) -> tuple[Expr, ...]:
        graph = X.p[0].graph
        gone = offsets(X, *chosen(shifts, joint, graph))
        if turns == "all":
            return gone + turned(X)
        x, y, axis = directions(joint.axis, graph)
        return gone + (leaning(X, axis, x, y) if turns == "across" else ())

    return Forbids(wrenches, residual)


def chosen(which: str, joint: Joint, graph: Graph) -> tuple[Vec, ...]:
    """Return the directions of the joint frame that a word means."""
    if which in ("all", "none"):
        return Mat.identity(graph) if which == "all" else ()
    x, y, axis = directions(joint.axis, graph)
    return (x, y) if which == "across" else (axis,)


def directions(axis: Vector, graph: Graph) -> tuple[Vec, Vec, Vec]:
    """Return two directions across an axis and the axis itself, the columns of A."""
    return Mat.towards(unit(axis, graph)).T


def forces(*along: Vec) -> tuple[Wrench, ...]:
    """Return unit forces."""
    return tuple(Wrench(x, zero_vector(x[0].graph)) for x in along)


def moments(*along: Vec) -> tuple[Wrench, ...]:
    """Return unit moments."""
    return tuple(Wrench(zero_vector(x[0].graph), x) for x in along)


def offsets(X: Transform, *along: Vec) -> tuple[Expr, ...]:
    """Return the components of p along directions, m."""
    return tuple(dot(x, X.p) for x in along)


def leaning(X: Transform, axis: Vec, *across: Vec) -> tuple[Expr, ...]:
    """Return the components of axis × R axis along directions: how far the axis leans."""
    lean = cross(axis, X.R @ axis)
    return tuple(dot(x, lean) for x in across)


def turned(X: Transform) -> Vec:
    """Return ½ Σ e × R e: zero without rotation, the rotation vector close to it."""
    graph = X.p[0].graph
    total = zero_vector(graph)
    for e in Mat.identity(graph):
        total = add(total, cross(e, X.R @ e))
    return scale(graph.one / 2, total)
