"""Forward dynamics as a loop over the rows of a table: what the loop does at a joint, kind by kind of joint.

The steps are `aba`'s, over symbols for the numbers of a row; what all rows of a kind have in common, a right angle, no
shift, is no symbol but written out, so it costs nothing. C prints these expressions, and `aba_loop` puts the numbers of
a table into them, joint by joint: so what is proved of these expressions is proved of that loop.

    outward     from the motion of the parent that velocities alone give: the joint's, and what its body takes for it
    inward      from the articulated inertia of all beyond: U / D and u / D of the joint, and its part of the parent's
    besides     from the accelerations besides of the parent: q̈, and those of the joint
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

from symdyn.dynamics.recursive.aba import Articulated, Pair, along_z, articulated, at_rest, given_way
from symdyn.dynamics.recursive.joint_table import JointRow, JointTable
from symdyn.dynamics.recursive.link_motion import LinkMotion, carried, moving
from symdyn.dynamics.recursive.links import GeneralTurn, Link, PlanarTurn, Turn
from symdyn.dynamics.recursive.moments import Moments
from symdyn.graph import Expr, Graph, substitute
from symdyn.spatial import Mat, Vec, plus, symmetric, zero_vector

NO_TURN, RIGHT, LEFT, ABOUT_X, ANY = "none", "right", "left", "x", "any"
"""Fixed turns: none, by ±90° about x, by another angle about x, by a matrix."""

MOTION, INERTIA, BESIDES = 18, 27, 6
"""Numbers of a motion (w, dw, a, U), of an articulated inertia (J, H, M, bias: 6, 9, 6, 6), of accelerations."""

MOST_KINDS = 8
"""Kinds of joints that a mechanism may have before they are told apart by fewer of their numbers."""


@dataclass(frozen=True, order=True)
class JointKind:
    """What all joints of a kind have in common.

    Attributes:
        slides: whether it is prismatic.
        fixed: of the fixed turns above.
        shift: how many numbers the shift has, from the first on.
        rises: whether there is a rise along z, which slides have.
        rotor: whether there is a rotor.
    """

    slides: bool
    fixed: str
    shift: int
    rises: bool
    rotor: bool


@dataclass(frozen=True)
class JointSteps:
    """Results of the three steps at a joint, as expressions of symbols that are called as the numbers of rows are.

    Attributes:
        graph: of these steps alone.
        motion, bias: of the step outward, shapes (18,) and (6,).
        share, inertia: of the step inward, shapes (7,), U / D as the parent feels it and u / D, and (27,).
        qdd, besides: of the last step, shapes () and (6,).
    """

    graph: Graph
    motion: tuple[Expr, ...]
    bias: tuple[Expr, ...]
    share: tuple[Expr, ...]
    inertia: tuple[Expr, ...]
    qdd: Expr
    besides: tuple[Expr, ...]


def kinds_of(table: JointTable) -> list[JointKind]:
    """Return the kind of every row; of many kinds those become one that differ in zeros alone."""
    found = [_kind(row) for row in table.rows]
    if len(set(found)) > MOST_KINDS:
        return [JointKind(one.slides, one.fixed, 3, True, True) for one in found]
    return found


def _kind(row: JointRow) -> JointKind:
    turn, shift = row.fixed, sum(not x.is_zero for x in row.shift)
    if len(turn) > 2:
        fixed = ANY
    elif turn[0].is_zero and turn[1].value in (1, -1):
        fixed = RIGHT if turn[1].value == 1 else LEFT
    else:
        fixed = NO_TURN if turn[1].is_zero and turn[0] is turn[0].graph.one else ABOUT_X
    along_x = shift == 0 or (shift == 1 and not row.shift[0].is_zero)
    rises = row.slides or not row.rise.is_zero
    return JointKind(row.slides, fixed, shift if along_x else 3, rises, not row.rotor.is_zero)


def aba_loop(table: JointTable, q: Sequence[Expr], qd: Sequence[Expr], tau: Sequence[Expr]) -> list[Expr]:
    """Return q̈ that solves M(q) q̈ + c(q, q̇) + g(q) = τ, shape (n,), rad/s^2 or m/s^2, by the loop."""
    graph = q[0].graph
    zero = graph.zero
    kinds, rows, n = kinds_of(table), table.rows, range(1, len(table.rows) + 1)
    given: list[dict[str, Expr]] = []
    for row, p, v, t in zip(rows, q, qd, tau, strict=True):
        angle = zero if row.slides else p
        c, s = graph.cos(angle), graph.sin(angle)
        c, s = c * row.zero[0] - s * row.zero[1], s * row.zero[0] + c * row.zero[1]
        given.append({**numbers_of(row), "cosine": c, "sine": s, "q": p, "qd": v, "tau": t})

    def after(i: int, steps: JointSteps, wanted: Sequence[Expr], **more: Sequence[Expr]) -> list[Expr]:
        """Return results of a step at joint i."""
        entries = given[i - 1] | {f"{name}{k}": x for name, some in more.items() for k, x in enumerate(some)}
        return substitute(wanted, {steps.graph.symbol(name): x for name, x in entries.items()}, graph)

    motion = [[zero] * MOTION]
    inertia = [[zero] * INERTIA for _ in range(len(rows) + 1)]
    shares, taken = list[list[Expr]](), list[list[Expr]]()
    for i in n:
        steps = steps_of(kinds[i - 1])
        found = after(i, steps, (*steps.motion, *steps.bias), motion=motion[rows[i - 1].parent])
        motion.append(found[:MOTION])
        taken.append(found[MOTION:])
    for i in reversed(n):
        steps, parent = steps_of(kinds[i - 1]), rows[i - 1].parent
        found = after(i, steps, (*steps.share, *steps.inertia), inertia=inertia[i], bias=taken[i - 1])
        shares.append(found[: BESIDES + 1])
        inertia[parent] = [a + b for a, b in zip(inertia[parent], found[BESIDES + 1 :], strict=True)]
    more, qdd = [[zero] * 3 + list(table.ground)], list[Expr]()
    for i in n:
        steps, before = steps_of(kinds[i - 1]), more[rows[i - 1].parent]
        first, *rest = after(i, steps, (steps.qdd, *steps.besides), besides=before, share=shares[-i])
        qdd.append(first)
        more.append(rest)
    return qdd


def numbers_of(row: JointRow) -> dict[str, Expr]:
    """Return the numbers of a row by the names that steps have for them."""
    turn = row.fixed if len(row.fixed) > 2 else ()
    found = {f"matrix{k}": x for k, x in enumerate(turn)} or dict(zip(("c", "s"), row.fixed, strict=True))
    found |= dict(zip("xyz", row.shift, strict=True)) | {"rise": row.rise, "rotor": row.rotor}
    return found | {f"b{k}": x for k, x in enumerate(row.moments)}


@cache
def steps_of(kind: JointKind) -> JointSteps:
    """Return the steps at a joint of a kind, on a graph of their own."""
    graph = Graph()
    zero = graph.zero
    still = zero_vector(graph)
    link, body = _link(kind, graph), _body(kind, graph)
    rotor = graph.symbol("rotor") if kind.rotor else zero
    moved = carried(_motion(graph), link, kind.slides, graph.symbol("qd"), zero, ends=False)
    own = articulated(body, moved)
    A = _inertia(_symbols(graph, "inertia", INERTIA)) + articulated(body, moving(still, still, still))
    A = replace(A, bias=plus(A.bias, _pair(_symbols(graph, "bias", 6))))
    D = A.along_z(kind.slides)[kind.slides][2] + rotor
    share, alone, rest = given_way(A, kind.slides, D, graph.symbol("tau"))
    felt = link.wrench_back(*share)  # by the parent, so that q̈ does not wait for its accelerations to be turned
    (n, f), before = (_pair(_symbols(graph, name, BESIDES)) for name in ("share", "besides"))
    w, v = before
    late = f[2] * v[2], n[2] * w[2]  # what the parent's own acceleration is in
    early = n[0] * w[0] + n[1] * w[1] + (f[0] * v[0] + f[1] * v[1])
    qdd = graph.symbol(f"share{BESIDES}") - early - late[not kind.slides] - late[kind.slides]
    beyond = plus(at_rest(before, link), along_z(qdd, kind.slides))
    return JointSteps(
        graph,
        _flat(moved.w, moved.dw, moved.a, *moved.U),
        _flat(*own.bias),
        (*_flat(*felt), alone),
        _flat_inertia(rest.seen_from(link)),
        qdd,
        _flat(*beyond),
    )


def _link(kind: JointKind, graph: Graph) -> Link:
    zero, one = graph.zero, graph.one
    matrix = tuple(_vectors(_symbols(graph, "matrix", 9)))
    turns: dict[str, tuple[Turn, ...]] = {
        NO_TURN: (),
        RIGHT: (PlanarTurn(0, zero, one),),
        LEFT: (PlanarTurn(0, zero, -one),),
        ABOUT_X: (PlanarTurn(0, graph.symbol("c"), graph.symbol("s")),),
        ANY: (GeneralTurn((matrix[0], matrix[1], matrix[2])),),
    }
    x, y, z = (graph.symbol(name) if k < kind.shift else zero for k, name in enumerate("xyz"))
    turn = PlanarTurn(2, graph.symbol("cosine"), graph.symbol("sine"))
    rise = graph.symbol("rise") if kind.rises else zero
    return Link((x, y, z), turns[kind.fixed], turn, rise + graph.symbol("q") if kind.slides else rise)


def _body(kind: JointKind, graph: Graph) -> Moments:
    """Return the body of a row: what its joint does not feel stands with its parent."""
    b, zero = _symbols(graph, "b", 7), graph.zero
    if kind.slides:
        return Moments(b[0], (b[1], b[2], b[3]), (zero_vector(graph),) * 3)
    return Moments(zero, (b[0], b[1], zero), symmetric(b[2], b[3], zero, b[4], b[5], b[6]))


def _motion(graph: Graph) -> LinkMotion:
    """Return the motion of the parent."""
    w, dw, a, *U = _vectors(_symbols(graph, "motion", MOTION))
    return replace(moving(w, dw, a), U=(U[0], U[1], U[2]))


def _symbols(graph: Graph, name: str, many: int) -> list[Expr]:
    return [graph.symbol(f"{name}{k}") for k in range(many)]


def _vectors(entries: Sequence[Expr]) -> list[Vec]:
    return [(entries[k], entries[k + 1], entries[k + 2]) for k in range(0, len(entries), 3)]


def _pair(entries: Sequence[Expr]) -> Pair:
    first, last = _vectors(entries)
    return first, last


def _flat(*rows: Vec) -> tuple[Expr, ...]:
    return tuple(x for row in rows for x in row)


def _inertia(entries: Sequence[Expr]) -> Articulated:
    H = _vectors(entries[6:15])
    return Articulated(symmetric(*entries[:6]), (H[0], H[1], H[2]), symmetric(*entries[15:21]), _pair(entries[21:]))


def _flat_inertia(A: Articulated) -> tuple[Expr, ...]:
    return *_six(A.J), *_flat(*A.H), *_six(A.M), *_flat(*A.bias)


def _six(matrix: Mat) -> tuple[Expr, ...]:
    """Return the entries of a symmetric matrix in the order of `symmetric`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix
    return xx, yy, zz, xy, xz, yz
