"""Loops over a table of joints: inverse and forward dynamics as sweeps, one row a joint.

A formulation of an output that goes over a table has its row here, by its name, and nowhere else.

Inverse dynamics has the steps of `rnea` (see there for U and the moments):

    outward     from the motion of the parent: the joint's, and what its body takes for it
    inward      from what all bodies beyond take: the joint's force, and its part of the parent's

Forward dynamics has those of `aba`:

    outward     from the motion of the parent that velocities alone give: the joint's, and what its body takes for it
    inward      from the articulated inertia of all beyond: U / D and u / D of the joint, and its part of the parent's
    besides     from the accelerations besides of the parent: q̈, and those of the joint

A joint waits for the one before it, so as much as possible is computed beforehand. A turn about the joint's own axis
keeps what vanishes along that axis, and goes on beside the division. U / D is turned into the parent's frame, where it
gives q̈ before accelerations are turned.

Derivatives of forward dynamics are at its q̈ those of inverse dynamics, multiplied by -M⁻¹, and M⁻¹.

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TypeVar

from symdyn.dynamics.mechanism.cost import CATEGORY
from symdyn.dynamics.recursive.derivative_sweeps import derivative_sweeps
from symdyn.dynamics.recursive.joint_table import (
    ORIGIN,
    JointTable,
    RowKind,
    body_of,
    flat,
    kinds_of,
    motion_of,
    names_of,
    rotor_of,
    symbols,
    transform_of,
    vectors,
)
from symdyn.dynamics.recursive.links import JointTransform, Twist, base_motion, plus, propagate, six
from symdyn.dynamics.recursive.sweeps import Pairs, Sweep, Sweeps, over_table, values_over_table
from symdyn.dynamics.recursive.tree_dynamics import ArticulatedInertia, across_locked, along_z, articulated_inertia
from symdyn.errors import NoValueError
from symdyn.frozen import dataclass, replace
from symdyn.graph import Algebra, Expr, Graph, evaluate, reachable
from symdyn.scene import Scene
from symdyn.spatial import Mat, zero_vector

T = TypeVar("T")

INERTIA, BESIDES = 27, 6
"""Numbers of an articulated inertia (I, H, M, bias: 6, 9, 6, 6), and of accelerations."""


def aba_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], tau: Sequence[Expr]) -> list[Expr]:
    """Return q̈ that solves M(q) q̈ + c(q, q̇) + g(q) = τ, shape (n,), rad/s^2 or m/s^2, by the loop."""
    return over_table(table, forward_sweeps, {"q": q, "qd": qd, "tau": tau})


@cache
def forward_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    zero = graph.zero
    zeros = zero_vector(graph)
    X, body = transform_of(kind, graph), body_of(kind, graph)
    moved = propagate(motion_of(graph, "motion"), X, kind.slides, graph.symbol("qd"), zero)
    own = articulated_inertia(body, moved)
    IA = _inertia(symbols(graph, "inertia", INERTIA)) + articulated_inertia(body, base_motion(zeros))
    IA = replace(IA, bias=plus(IA.bias, _pair(symbols(graph, "bias", BESIDES))))
    IA = IA.seen_from(JointTransform(zeros, (), X.turn, X.offset))  # about and along the axis, then the rest
    rest = replace(X.fixed_part(False), offset=zero)
    D = IA.along_z(kind.slides)[kind.slides][2] + rotor_of(kind, graph)
    U_D, u_D, Ia = IA.through_joint(kind.slides, D, graph.symbol("tau"))
    share = rest.wrench_back(*U_D)  # U / D in the parent's frame
    (n, f), parent = (_pair(symbols(graph, name, BESIDES)) for name in ("share", "besides"))
    w, v = parent
    late = f[2] * v[2], n[2] * w[2]  # what the parent's own acceleration is in
    early = n[0] * w[0] + n[1] * w[1] + (f[0] * v[0] + f[1] * v[1])
    qdd = graph.symbol(f"share{BESIDES}") - early - late[not kind.slides] - late[kind.slides]
    beyond = plus(across_locked(parent, X), along_z(qdd, kind.slides))
    motion = flat(moved.w, moved.dw, moved.a, *moved.U)
    A = Ia.seen_from(rest)
    inertia = *six(A.I), *flat(*A.H), *six(A.M), *flat(*A.bias)
    return (
        Sweep("outward", "motion", motion, keeps="bias", kept=flat(*own.bias)),
        Sweep("inward", "inertia", inertia, inward=True, keeps="share", kept=(*flat(*share), u_D)),
        Sweep("besides", "besides", flat(*beyond), ground=3, result=qdd),
    )


def aba_derivatives_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], tau: Sequence[Expr]) -> list[Expr]:
    """Return the derivatives of forward dynamics by q, q̇ and τ, shape (n, 3 n), row by row, by the loop."""
    return over_table(table, forward_derivative_sweeps, {"q": q, "qd": qd, "tau": tau})


@cache
def forward_derivative_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind: those that find q̈, and there those of the derivatives of τ."""
    *before, last = forward_sweeps(kind)
    *frames, bodies = derivative_sweeps(kind)
    assert bodies.pairs is not None, "they go through pairs"
    solved = replace(bodies, pairs=replace(bodies.pairs, solved=True))
    return (*before, replace(last, finds="qdd"), *frames, solved)


def _pair(entries: Sequence[Expr]) -> Twist:
    first, last = vectors(entries)
    return first, last


def _inertia(entries: Sequence[Expr]) -> ArticulatedInertia:
    H = vectors(entries[6:15])
    return ArticulatedInertia(Mat.symmetric(*entries[:6]), Mat(H), Mat.symmetric(*entries[15:21]), _pair(entries[21:]))


WRENCH = 6
"""Numbers of a moment and a force."""


def rnea_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], qdd: Sequence[Expr]) -> list[Expr]:
    """Return τ = M(q) q̈ + c(q, q̇) + g(q), shape (n,), N m or N, by the loop; positive accelerates."""
    return over_table(table, inverse_sweeps, {"q": q, "qd": qd, "qdd": qdd})


@cache
def inverse_sweeps(kind: RowKind) -> tuple[Sweep, ...]:
    """Return the sweeps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    X, slides = transform_of(kind, graph), kind.slides
    qdd = graph.symbol("qdd")
    moved = propagate(motion_of(graph, "motion"), X, slides, graph.symbol("qd"), qdd)
    takes = body_of(kind, graph).wrench(moved.a, moved.U)
    own, beyond = (vectors(symbols(graph, name, WRENCH)) for name in ("own", "beyond"))
    n, f = plus((own[0], own[1]), (beyond[0], beyond[1]))
    tau = (f[2] if slides else n[2]) + rotor_of(kind, graph) * qdd
    motion = flat(moved.w, moved.dw, moved.a, *moved.U)
    return (
        Sweep("outward", "motion", motion, ground=ORIGIN, keeps="own", kept=flat(*takes)),
        Sweep("inward", "beyond", flat(*X.wrench_back(n, f)), inward=True, result=tau),
    )


LITTLE = 1e-10
"""A pivot so many times smaller than the largest one is looked at exactly."""


@dataclass(frozen=True)
class TableLoop:
    """A loop over a table of joints, by a formulation of `TABLE_LOOPS`."""

    formulation: str
    table: JointTable

    @property
    def algorithm(self) -> LoopAlgorithm:
        return TABLE_LOOPS[self.formulation]

    @property
    def kinds(self) -> list[RowKind]:
        """The kind of every row: few of derivatives, whose steps are long and run less often than pairs of joints."""
        return kinds_of(self.table, self.algorithm.few)

    @property
    def goes_through_pairs(self) -> bool:
        """Whether its result is of pairs of joints, in three blocks of columns."""
        return any(one.pairs for one in self.algorithm.sweeps(self.kinds[0]))

    def may_fail(self, scene: Scene) -> bool:
        """Tell whether it may not exist: it divides by pivots, and one at a position drawn at random is near zero."""
        if not self.algorithm.divides:
            return False
        from symdyn.algebra import Floats

        draw = random.Random(1)
        numbers = iter(self.table.numbers(scene)[len(self.table.ground) :])
        exact = {id(row): [float(next(numbers)) for _ in row.entries] for row in self.table.rows}
        held = {i: [0.0] * INERTIA for i in range(len(self.table.rows) + 1)}
        pivots, algebra = [], Floats()
        for i, (row, kind) in reversed(list(enumerate(zip(self.table.rows, self.kinds, strict=True), 1))):
            (inward,) = (one for one in forward_sweeps(kind) if one.inward)
            x, y = draw.uniform(-1, 1), draw.uniform(-1, 1)
            known = dict(zip(names_of(row), exact[id(row)], strict=True))
            known |= {"cosine": x, "sine": (1 - x * x) ** 0.5, "q": y, "tau": 1.0}
            known |= {f"inertia{k}": one for k, one in enumerate(held[i])} | {f"bias{k}": 0.0 for k in range(6)}
            known |= {f"inertia{k}": 0.0 for k in range(INERTIA - 6, INERTIA)}
            values = {inward.handed[0].graph.symbol(name): one for name, one in known.items()}
            try:
                found = evaluate((inward.kept[BESIDES], *inward.handed), algebra, values)
            except NoValueError:
                return True
            pivots.append(abs(1 / found[0]) if found[0] else float("inf"))
            held[row.parent] = [a + b for a, b in zip(held[row.parent], found[1:], strict=True)]
        return min(pivots) <= LITTLE * max(pivots)

    def values(self, numbers: Sequence[T], given: Mapping[str, Sequence[T]], algebra: Algebra[T]) -> list[T]:
        """Return its result over an algebra, for the numbers of its table and its arguments.

        Raises:
            what the algebra does where there is no value.
        """
        return values_over_table(self.table, self.algorithm.sweeps, numbers, given, algebra)


@dataclass(frozen=True)
class LoopAlgorithm:
    """What a loop does, when it is taken, and what for."""

    sweeps: Sweeps  # what it does at a joint of a kind
    fewest: int  # joints from which code is a loop unless it is asked for otherwise
    why: str  # what is gained from there on, in words
    divides: bool = False  # whether it divides by pivots of the mass matrix, and does not exist where that is singular
    few: bool = False  # whether kinds of joints that differ in right angles alone are one


SOONER = "faster, as its code stays in the nearest cache, and compiled at once"

TABLE_LOOPS = {
    # About where lines of one state, which are fetched anew at every call, take longer than they wait for each other;
    # of trees with many kinds of joints and of bodies with many zeros a little later than of others.
    "rnea_loop": LoopAlgorithm(inverse_sweeps, 64, SOONER),
    "aba_loop": LoopAlgorithm(forward_sweeps, 40, SOONER, divides=True),
    "rnea_derivatives_loop": LoopAlgorithm(derivative_sweeps, 20, SOONER, few=True),
    "aba_derivatives_loop": LoopAlgorithm(forward_derivative_sweeps, 32, SOONER, divides=True, few=True),
}

FROM_ZERO = Counter(multiplications=4, additions=2)
"""What a turn that is not zero where q is costs besides."""


def count_loop(loop: TableLoop) -> Counter[str]:
    """Return the operations of one call; what several hand to one joint is added."""
    found, handed, rows = Counter[str](), set[int](), loop.table.rows
    for row, kind in zip(rows, loop.kinds, strict=True):
        sweeps = loop.algorithm.sweeps(kind)
        found += _count_sweeps(sweeps)
        if row.parent in handed:
            inward = (one for one in sweeps if one.inward)
            found += Counter(additions=sum(not x.is_zero for one in inward for x in one.handed))
        handed.add(row.parent)
        found += Counter(sincos=int(not row.slides))
        found += Counter() if row.at_zero or row.slides else FROM_ZERO
    for pairs in (one.pairs for one in loop.algorithm.sweeps(loop.kinds[0]) if one.pairs):
        found += _count_pairs(loop, pairs)
    return found


def _count_pairs(loop: TableLoop, pairs: Pairs) -> Counter[str]:
    """Return the operations of all pairs, and of equations with M where they are solved, all columns alike."""
    found, rows, n = Counter[str](), loop.table.rows, len(loop.table.rows)
    depth, products = [0], 0
    for row, many in zip(rows, loop.table.carried, strict=True):
        depth.append(depth[row.parent] + 1)
        products += (many - 1) * (depth[-1] + 6 * n)
        if row.parent:
            one = _count(pairs.of(rows[row.parent - 1].slides))
            found += Counter({name: many * number for name, number in one.items()})
    if pairs.solved:
        found += Counter(multiplications=products, additions=products, divisions=sum(depth) - n + 3 * n * n)
    return found


@cache
def _count_sweeps(sweeps: tuple[Sweep, ...]) -> Counter[str]:
    """Return the operations of sweeps at a joint, as they are printed: each is a function of its own."""
    return sum((_count(one.results) for one in sweeps), Counter[str]())


@cache
def _count(results: tuple[Expr, ...]) -> Counter[str]:
    return Counter(name for node in reachable(results) if (name := CATEGORY[node.op]))
