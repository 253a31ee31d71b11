"""Inverse dynamics as a loop over the rows of a table: the steps are `rnea`'s, over symbols for the numbers of a row.

    outward     from the motion of the parent: the joint's, and what its body takes for it
    inward      from what all bodies beyond take: the joint's force, and its part of the parent's

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3; see `rnea` for U and the moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from symdyn.dynamics.recursive.joint_table import JointTable
from symdyn.dynamics.recursive.link_motion import carried
from symdyn.dynamics.recursive.row_kinds import (
    ORIGIN,
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
from symdyn.dynamics.recursive.variations import plus
from symdyn.graph import Expr, Graph

WRENCH = 6
"""Numbers of a moment and a force."""


def rnea_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q), shape (n,), N m or N, by the loop; positive accelerates."""
    return over_table(table, inverse_sweeps, {"q": q, "qd": qd, "qdd": qdd})


@cache
def inverse_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    link, slides = link_of(kind, graph), kind.slides
    qdd = graph.symbol("qdd")
    moved = carried(motion_of(graph, "motion"), link, slides, graph.symbol("qd"), qdd)
    takes = body_of(kind, graph).wrench(moved.a, moved.U)
    own, beyond = (vectors(symbols(graph, name, WRENCH)) for name in ("own", "beyond"))
    n, f = plus((own[0], own[1]), (beyond[0], beyond[1]))
    tau = (f[2] if slides else n[2]) + rotor_of(kind, graph) * qdd
    motion = flat(moved.w, moved.dw, moved.a, *moved.U)
    return (
        Sweep("outward", "motion", motion, ground=ORIGIN, keeps="own", kept=flat(*takes)),
        Sweep("inward", "beyond", flat(*link.wrench_back(n, f)), inward=True, result=tau),
    )
