"""Closed mechanisms on the page: all coefficients reduced to the independent velocities, and what closes the loops.

    u = T u_i,  u̇ = T u̇_i + s      what loops and rows allow, s quadratic in u
    tau*_i = Tᵀ (M u̇ + c + g + k_E - Q),  so with b(u) = Tᵀ (M s + c):

    k_z* = Tᵀ M T,  k_G* = Tᵀ g,  k_E* = Tᵀ k_E,  k_D*_j = b(T e_j),  k_C*_jk = b(T e_j + T e_k) - b(T e_j) - b(T e_k)

Reference: Featherstone, Rigid Body Dynamics Algorithms (2008), section 3.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from symdyn.dynamics import Function, Workspace, derive_one
from symdyn.dynamics.loops import Partition
from symdyn.dynamics.mechanism import TIME, solve
from symdyn.dynamics.outputs import arguments
from symdyn.errors import DerivationError
from symdyn.graph import Expr, Op, reachable, substitute
from symdyn.scene.forces import elastic
from symdyn.scene.joints import JOINTS

ACTING = "acting"

STATE = ("q", "qd", "qdd")

NOTHING = 1e-9
"""What a step of one metre or radian moves a coordinate by that it does not move."""


@dataclass(frozen=True)
class Held:
    """How loops and rows of a scene tie its state together.

    Attributes:
        velocities: independent ones.
        moved: by coordinate that may be moved by itself the velocity that is its rate, -1 where none is.
        closing: rows that hold positions, with the velocities that take a state back to them, in the order of solving;
            of a contact whose rows need each other, the one that holds its height, with all that they determine.
        drives: velocities with a drive.
        multipliers: (owner, words) of each, such as ("hinge", "force along x").
        undriven: why the drives are not determined; "" where they are.
    """

    velocities: tuple[int, ...]
    moved: dict[int, int]
    closing: Partition
    drives: tuple[int, ...]
    multipliers: tuple[tuple[str, str], ...]
    undriven: str

    @property
    def dependent(self) -> tuple[int, ...]:
        """Velocities that take a state back to what holds positions; none where rows hold velocities only."""
        return tuple(sorted(k for block in self.closing.blocks for k in block.velocities))


def held(w: Workspace) -> Held:
    """Return what a scene's loops and rows decide.

    Raises:
        DerivationError: the loops cannot be assembled.
    """
    decisions, labels = w.loops.decisions, w.loops.recursive.labels
    whole = decisions.partition
    G, closing = w.loops.G(w.loops.recursive), []
    for block in whole.blocks:
        rows = tuple(r for r in block.rows if labels[decisions.kept[r]].closes)
        used = tuple(k for k in block.velocities if any(not G[r][k].is_zero for r in rows))
        if rows:
            closing.append(block if rows == block.rows else replace(block, rows=rows, velocities=used))
    back = Partition((), (), tuple(closing))
    words = tuple((labels[k].owner, decisions.names[k].partition(": ")[2]) for k in decisions.kept)
    return Held(
        whole.independent,
        _moved(w, back),
        back,
        tuple(w.scene.driven_velocities) if decisions.driven else (),
        words,
        "" if decisions.driven else decisions.fault,
    )


def _moved(w: Workspace, closing: Partition) -> dict[int, int]:
    """Return what `Held.moved` says."""
    found: dict[int, int] = {}
    q, u = 0, 0
    dependent = {k for block in closing.blocks for k in block.velocities}
    still = _left_alone(w, closing)
    for joint in w.scene.moving:
        size, ball = len(joint.coordinates), JOINTS[joint.type].quaternion(joint)
        places, velocities = range(q, q + size), range(u, u + len(joint.rates))
        if ball is None:
            found |= {q + k: u + k for k in range(size) if u + k not in dependent}
        elif not dependent.intersection(velocities):
            found |= dict.fromkeys(places, -1)
        elif still.issuperset(places[ball:]):
            found |= dict.fromkeys(sorted(still.intersection(places)), -1)
        q, u = q + size, u + len(joint.rates)
    return found


def _left_alone(w: Workspace, closing: Partition) -> set[int]:
    """Return the coordinates that no step of blocks with more velocities than rows moves; none without such."""
    blocks = [block for block in closing.blocks if len(block.rows) < len(block.velocities)]
    numbers, decisions = w.loops.numbers, w.loops.decisions
    at = np.array(decisions.assembly.typical)
    G = numbers.jacobian(at)[list(decisions.kept)]
    moved = np.zeros(len(at))
    for block in blocks:
        steps = np.linalg.pinv(G[np.ix_(block.rows, block.velocities)])
        for step in steps.T:
            whole = np.zeros(w.state.n)
            whole[list(block.velocities)] = step / np.abs(step).max()
            moved += np.abs(numbers.moved(at, whole) - at)
    return {int(k) for k in np.flatnonzero(moved < NOTHING)} if blocks else set()


def reduced_functions(w: Workspace, tied: Held) -> list[Function]:
    """Return the functions of a closed mechanism's page.

    These are the coefficients of its rows, "row_forces", their sums, and "acting", what acts beside drives, all shape
    (independent,); "fitted_velocities" and "fitted_accelerations" of (q, qd), (q, qd, qdd), shape (nv,): independent
    entries as they are, the others as loops and rows demand; "correction" of q, Newton's step that closes loops, and
    "carried" of (q, qd), how dependent velocities of loops follow all others, shape (nv,); "constraint_residual";
    "inverse_dynamics" and, of (q, qd, qdd, tau), "multipliers". A motion passes positions at which a partition is
    singular, so it is kept on the loops by "nearest" velocities, (1 - G⁺ G) u, and "shortest" steps, -G⁺ r.
    """
    reduced, M, size = w.loops.reduction, w.composite_mass, len(tied.velocities)
    forces = w.forces(list(w.state.qdd))
    square, C, D = [x for row in reduced.mass(M) for x in row], *_velocity_coefficients(w)
    rows = [
        function(w, "k_z", "reduced k_z", square, ("q",), (size, size)),
        function(w, "k_C", "reduced k_C", C, ("q",), (size, size * (size - 1) // 2)),
        function(w, "k_D", "reduced k_D", D, ("q",), (size, size)),
        function(w, "k_G", "reduced k_G", reduced.gathered(w.gravity_forces), ("q",)),
        function(w, "row_forces", "reduced forces", reduced.gathered(forces), STATE),
    ]
    if elastic(w.scene):
        rows.append(function(w, "k_E", "reduced k_E", reduced.gathered(w.elastic.forces), ("q",)))
    if any(not force.is_zero for force in w.Q):
        rows.append(function(w, ACTING, "reduced forces beside drives", reduced.gathered(w.Q), ("q", "qd")))
    return [*(one for one in rows if one.entries), *_fitting(w, tied), *_driving(w, forces)]


def _velocity_coefficients(w: Workspace) -> tuple[list[Expr], list[Expr]]:
    """Return k_C*, shape (independent, pairs), and k_D*, shape (independent, independent)."""
    reduced = w.loops.reduction
    n = range(len(reduced.independent))

    def b(*moving: int) -> list[Expr]:
        u = [w.graph.total(row[reduced.independent[j]] for j in moving if reduced.independent[j] in row) for row in T]
        s = substitute(reduced.s, dict(zip(w.state.qd, u, strict=True)))
        return reduced.gathered(w.velocity_forces(u, s))

    T = reduced.T
    alone = [b(j) for j in n]
    pairs = [(b(j, k), alone[j], alone[k]) for j, k in combinations(n, 2)]
    return [both[i] - one[i] - other[i] for i in n for both, one, other in pairs], [alone[j][i] for i in n for j in n]


def _fitting(w: Workspace, tied: Held) -> list[Function]:
    """Return what makes a state fit the loops and rows."""
    reduced, zero, rows = w.loops.reduction, w.graph.zero, w.loops.recursive
    rates = [w.graph.total(t * w.state.qd[i] for i, t in row.items()) for row in reduced.T]
    bent = reduced.spread([w.state.qdd[i] for i in reduced.independent])
    functions = [
        function(w, "fitted_velocities", "velocities that the loops allow", rates, ("q", "qd")),
        function(w, "fitted_accelerations", "accelerations that the loops allow", bent, STATE),
    ]
    G, residual = w.loops.G(rows), w.loops.residual(rows)
    if G:
        off = [w.graph.total(x * u for x, u in zip(row, w.state.qd, strict=True)) for row in G]
        nearest = [u + x for u, x in zip(w.state.qd, _least(G, off), strict=True)]
        functions.append(function(w, "nearest", "nearest velocities that the loops allow", nearest, ("q", "qd")))
    if tied.closing.blocks:
        step = _taken_back(G, tied, [-r for r in residual])
        steps = [step.get(k, zero) for k in range(w.state.n)]
        others = [k for k in range(w.state.n) if k not in tied.dependent]
        follow = _taken_back(G, tied, [-w.graph.total(row[k] * w.state.qd[k] for k in others) for row in G])
        carried = [follow.get(k, u) for k, u in enumerate(w.state.qd)]
        functions += [
            function(w, "constraint_residual", "residuals of the loops", residual, ("q",)),
            function(w, "shortest", "Newton's shortest step", _least(G, residual), ("q",)),
            function(w, "correction", "Newton's step of dependent coordinates", steps, ("q",)),
            function(w, "carried", "velocities that close the loops", carried, ("q", "qd")),
        ]
    return functions


def _taken_back(G: Sequence[Sequence[Expr]], tied: Held, b: Sequence[Expr]) -> dict[int, Expr]:
    """Return x with G x = b in the rows that hold positions, by velocity; the least one where more than one does."""
    x: dict[int, Expr] = {}
    for block in tied.closing.blocks:
        rest = [b[r] - b[r].graph.total(G[r][k] * x[k] for k in x) for r in block.rows]
        matrix = [[G[r][k] for k in block.velocities] for r in block.rows]
        square = len(block.rows) == len(block.velocities)
        found = block.solve(G, rest) if square else _least(matrix, [-one for one in rest])
        x |= dict(zip(block.velocities, found, strict=True))
    return x


def _least(G: Sequence[Sequence[Expr]], b: Sequence[Expr]) -> list[Expr]:
    """Return -G⁺ b, shape (nv,), for rows that are independent."""
    graph = b[0].graph
    square = [[graph.total(x * y for x, y in zip(one, other, strict=True)) for other in G] for one in G]
    found = solve(range(-1, len(G)), square, b)
    return [-graph.total(row[k] * x for row, x in zip(G, found, strict=True)) for k in range(len(G[0]))]


def _driving(w: Workspace, forces: list[Expr]) -> list[Function]:
    """Return inverse dynamics, at independent velocities where drives do not fit, and the multipliers."""
    decisions, reduced = w.loops.decisions, w.loops.reduction
    try:
        functions = [derive_one(w, "inverse_dynamics")]
    except DerivationError:
        alone = dict(zip(reduced.independent, reduced.gathered(forces), strict=True))
        entries = [alone.get(k, w.graph.zero) for k in range(w.state.n)]
        functions = [function(w, "inverse_dynamics", "forces at independent velocities", entries, STATE)]
    if decisions.kept:
        excess = [force - tau for force, tau in zip(forces, w.state.tau, strict=True)]
        found = decisions.partition.solve_transposed(w.loops.G(w.loops.recursive), excess)
        functions.append(function(w, "multipliers", "what loops and rows exert", found, (*STATE, "tau")))
    return functions


def function(
    workspace: Workspace,
    name: str,
    text: str,
    entries: Sequence[Expr],
    takes: Sequence[str],
    shape: tuple[int, ...] | None = None,
) -> Function:
    """Return entries as a function of what it takes, of time too where they depend on it."""
    timed = any(node.op is Op.SYMBOL and node.value == TIME for node in reachable(entries))
    given = arguments(workspace, (*takes, *((TIME,) if timed else ())))
    return Function(name, text, given, name, (len(entries),) if shape is None else shape, tuple(entries), "", name)
