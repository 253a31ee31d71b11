"""Forward dynamics as a loop over the rows of a table: the steps are `aba`'s, over symbols for the numbers of a row.

    outward     from the motion of the parent that velocities alone give: the joint's, and what its body takes for it
    inward      from the articulated inertia of all beyond: U / D and u / D of the joint, and its part of the parent's
    besides     from the accelerations besides of the parent: q̈, and those of the joint

A joint waits for the one before it, so what it can do beforehand it does: a turn about the joint's own axis keeps what
vanishes along that, and goes on beside the division; U / D is turned into the parent's frame, where q̈ finds it without
waiting for accelerations to be turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from symdyn.dynamics.recursive.articulated import Articulated, across, along_z, articulated, given_way
from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.dynamics.recursive.link_motion import at_rest, carried
from symdyn.dynamics.recursive.links import Link
from symdyn.dynamics.recursive.row_kinds import (
    RowKind,
    body_of,
    flat,
    link_of,
    motion_of,
    rotor_of,
    symbols,
    vectors,
)
from symdyn.dynamics.recursive.sweeps import Sweep, over_table
from symdyn.dynamics.recursive.variations import Twist, plus
from symdyn.graph import Expr, Graph
from symdyn.spatial import Mat, zero_vector

INERTIA, BESIDES = 27, 6
"""Numbers of an articulated inertia (J, H, M, bias: 6, 9, 6, 6), and of accelerations."""


def aba_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], tau: Sequence[Expr]) -> list[Expr]:
    """Return q̈ that solves M(q) q̈ + c(q, q̇) + g(q) = τ, shape (n,), rad/s^2 or m/s^2, by the loop."""
    return over_table(table, forward_sweeps, {"q": q, "qd": qd, "tau": tau})


@cache
def forward_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    zero = graph.zero
    still = zero_vector(graph)
    link, body = link_of(kind, graph), body_of(kind, graph)
    moved = carried(motion_of(graph, "motion"), link, kind.slides, graph.symbol("qd"), zero)
    own = articulated(body, moved)
    A = _inertia(symbols(graph, "inertia", INERTIA)) + articulated(body, at_rest(still))
    A = replace(A, bias=plus(A.bias, _pair(symbols(graph, "bias", BESIDES))))
    along, rest = _apart(link)
    A = A.seen_from(along)
    D = A.along_z(kind.slides)[kind.slides][2] + rotor_of(kind, graph)
    share, alone, left = given_way(A, kind.slides, D, graph.symbol("tau"))
    felt = rest.wrench_back(*share)  # by the parent
    (n, f), before = (_pair(symbols(graph, name, BESIDES)) for name in ("share", "besides"))
    w, v = before
    late = f[2] * v[2], n[2] * w[2]  # what the parent's own acceleration is in
    early = n[0] * w[0] + n[1] * w[1] + (f[0] * v[0] + f[1] * v[1])
    qdd = graph.symbol(f"share{BESIDES}") - early - late[not kind.slides] - late[kind.slides]
    beyond = plus(across(before, link), along_z(qdd, kind.slides))
    motion = flat(moved.w, moved.dw, moved.a, *moved.U)
    inertia = _flat_inertia(left.seen_from(rest))
    return (
        Sweep("outward", "motion", motion, keeps="bias", kept=flat(*own.bias)),
        Sweep("inward", "inertia", inertia, inward=True, keeps="share", kept=(*flat(*felt), alone)),
        Sweep("besides", "besides", flat(*beyond), ground=3, result=qdd),
    )


def _apart(link: Link) -> tuple[Link, Link]:
    """Return what of a link goes about and along the axis of its joint, and the rest."""
    graph = link.rise.graph
    still = link.at_rest(False)
    return Link(zero_vector(graph), (), link.turn, link.rise), replace(still, rise=graph.zero)


def _pair(entries: Sequence[Expr]) -> Twist:
    first, last = vectors(entries)
    return first, last


def _inertia(entries: Sequence[Expr]) -> Articulated:
    H = vectors(entries[6:15])
    return Articulated(Mat.symmetric(*entries[:6]), Mat(H), Mat.symmetric(*entries[15:21]), _pair(entries[21:]))


def _flat_inertia(A: Articulated) -> tuple[Expr, ...]:
    return *_six(A.J), *flat(*A.H), *_six(A.M), *flat(*A.bias)


def _six(matrix: Mat) -> tuple[Expr, ...]:
    """Return the entries of a symmetric matrix in the order of `symmetric`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return xx, yy, zz, xy, xz, yz
