"""Derivatives of inverse dynamics as sweeps over a table of joints, in axes of the ground.

Closed forms are those of `rnea_derivatives`; see there for S, A, G, F₁, F₀ and composite bodies, twice whose velocities
stand here too. There contributions are turned from frame to frame. Here all vectors have axes of the ground, about the
origin of the frame at hand, so that contributions are but shifted on their way to the ground; and those of all joints
beyond one take the same shift, side by side.

    frames      from R, ω, ω̇, a of the parent: the joint's, its origin p in the parent's frame, and u
    bodies      composite body and wrench of all beyond: A, G, F₁, F₀ of the joint, and its derivatives by itself
    pairs       of a joint and of all beyond: shifted to the origin of its parent, and derivatives with the parent
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from symdyn.dynamics.recursive.joint_table import (
    JointTable,
    RowKind,
    body_of,
    flat,
    rotor_of,
    symbols,
    transform_of,
    vectors,
)
from symdyn.dynamics.recursive.links import GeneralTurn, Moments, plus, power, six
from symdyn.dynamics.recursive.rnea_derivatives import Composite, Contribution, OriginShift, Subspace, single_body
from symdyn.dynamics.recursive.sweeps import Pairs, Sweep, over_table
from symdyn.graph import Expr, Graph
from symdyn.spatial import Mat, Vec, add, cross, dot, scale, zero_vector

KEPT = "at"
"""How what a joint keeps begins: R, ω, ω̇, a, p, u, ż, z̈, a × z."""

MANY, MOTION = 33, 18
"""Numbers of that, and of what is handed on outwards: R, ω, ω̇, a."""

COMPOSITE, GOES = 28, 21
"""Numbers of a composite body (m, h, J, P, l: 1, 3, 6, 9, 3) and a wrench, and of A, G, F₁, F₀."""


def rnea_derivatives_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
    """Return the derivatives of inverse dynamics by q, q̇ and q̈, shape (n, 3 n), row by row, by the loop."""
    return over_table(table, derivative_sweeps, {"q": q, "qd": qd, "qdd": qdd})


@cache
def derivative_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    motion, kept = _frames(kind, graph)
    handed, pairs = _bodies(kind, graph)
    return (
        Sweep("frames", "motion", motion, ground=15, ones=(0, 4, 8), keeps=KEPT, kept=kept),
        Sweep("bodies", "beyond", handed, inward=True, pairs=pairs),
    )


def _frames(kind: RowKind, graph: Graph) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Return R, ω, ω̇, a of a joint's frame, and what it keeps."""
    *rows, w, dw, a = vectors(symbols(graph, "motion", MOTION))
    X, qd, qdd = transform_of(kind, graph), graph.symbol("qd"), graph.symbol("qdd")
    R = Mat(map(X.out, rows))
    z = _axis(R)
    p = add(Mat(rows) @ X.shift, scale(X.offset, z))
    dz = cross(w, z)
    u = cross(w, p)
    a = add(a, add(cross(dw, p), cross(w, u)))
    if kind.slides:
        u = add(u, scale(qd, z))
        a = add(a, add(scale(qd * 2, dz), scale(qdd, z)))
    else:
        dw = add(dw, add(scale(qdd, z), scale(qd, dz)))
        w = add(w, scale(qd, z))
    ddz = add(cross(dw, z), cross(w, dz))
    beside = zero_vector(graph) if kind.slides else cross(a, z)
    motion = flat(*R, w, dw, a)
    return motion, (*motion, *flat(p, scale(2, u), dz, ddz, beside))


def _bodies(kind: RowKind, graph: Graph) -> tuple[tuple[Expr, ...], Pairs]:
    """Return the composite body and the wrench about the parent's origin, and what is of pairs."""
    *rows, w, dw, a = vectors(symbols(graph, KEPT, MOTION))
    R = GeneralTurn(Mat(rows))
    body = body_of(kind, graph)
    body = Moments(body.m, R.back(body.h), R.tensor_back(body.J))
    xx, yy, zz, xy, yz, zx = *(x * x for x in w), w[0] * w[1], w[1] * w[2], w[2] * w[0]
    x, y, z = dw
    U = Mat(((-yy - zz, xy - z, zx + y), (xy + z, -xx - zz, yz - x), (zx - y, yz + x, -xx - yy)))
    beyond = symbols(graph, "beyond", COMPOSITE)
    h, J, (*P, l, n, f) = *vectors(beyond[1:4]), beyond[4:10], vectors(beyond[10:])  # noqa: E741
    composite = single_body(body, scale(2, w)) + Composite(Moments(beyond[0], h, Mat.symmetric(*J)), Mat(P), l)
    wrench = plus(body.wrench(a, U), (n, f))
    by = OriginShift(*vectors(symbols(graph, KEPT, MANY)[MOTION : MOTION + 6]))
    S = subspace(graph, KEPT, kind.slides)
    near, moment = composite.shifted(by), add(wrench[0], cross(by.p, wrench[1]))
    one = composite.contribution(S, wrench)
    own = power(one.F0, S.twist), power(one.F1, S.twist), power(one.A, S.twist) + rotor_of(kind, graph)
    handed = (near.body.m, *near.body.h, *six(near.body.J), *flat(*near.P, near.momentum, moment, wrench[1]))
    n, f, G, n1, f1, n0, f0 = vectors(symbols(graph, Pairs.CARRIED, GOES))
    shifted = Contribution((n, f), G, (n1, f1), (n0, f0)).shifted(by)
    turn, slide = (_both_ways(shifted, subspace(graph, Pairs.ABOVE, slides)) for slides in (False, True))
    return handed, Pairs(_flat(one), own, _flat(shifted), (turn, slide), KEPT, MANY)


def _both_ways(one: Contribution, S: Subspace) -> tuple[Expr, ...]:
    """Return the entries of a pair: of the joint that has S and the one that contributes, then the reverse."""
    return (
        power(one.A, S.twist),
        power(one.F1, S.twist),
        power(one.F0, S.twist),
        dot(one.G, S.twist[0]) + power(one.A, S.twice),
        dot(one.G, S.first[0]) + power(one.A, S.second),
    )


def subspace(graph: Graph, name: str, slides: bool) -> Subspace:
    """Return S of a joint and its rates, of what it keeps, which symbols with this name are."""
    *rows, _w, _dw, _a, _p, _u, dz, ddz, beside = vectors(symbols(graph, name, MANY))
    z, zeros = _axis(Mat(rows)), zero_vector(graph)
    if slides:
        return Subspace((zeros, z), (zeros, dz), (zeros, ddz), (zeros, scale(2, dz)))
    return Subspace((z, zeros), (dz, zeros), (ddz, beside), (scale(2, dz), zeros))


def _axis(R: Mat) -> Vec:
    (_, _, x), (_, _, y), (_, _, z) = R
    return x, y, z


def _flat(one: Contribution) -> tuple[Expr, ...]:
    return flat(*one.A, one.G, *one.F1, *one.F0)
